#include "core/hdr.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace lightgrid {
namespace {

/// What is left of the file.
class Input {
  public:
    Input(std::string_view bytes, const std::string& where) : bytes_(bytes), where_(where) {}

    std::string_view line() {
        const std::size_t end = bytes_.find('\n', position_);
        if (end == std::string_view::npos) throw cut();
        std::string_view text = bytes_.substr(position_, end - position_);
        position_ = end + 1;
        if (text.ends_with('\r')) text.remove_suffix(1);
        return text;
    }
    unsigned byte() {
        if (position_ >= bytes_.size()) throw cut();
        return static_cast<unsigned char>(bytes_[position_++]);
    }
    [[nodiscard]] bool starts_with(std::string_view wanted) const {
        return bytes_.substr(position_).starts_with(wanted);
    }
    [[nodiscard]] std::size_t left() const { return bytes_.size() - position_; }

    [[nodiscard]] Error damaged(const std::string& problem) const {
        return Error(fmt::format("the Radiance HDR image is damaged at byte {}: {}", position_, problem), where_,
                     "Export it again.");
    }
    [[nodiscard]] Error cut() const { return damaged("it ends too early"); }

  private:
    std::string_view bytes_;
    const std::string& where_;
    std::size_t position_ = 0;
};

using Rgbe = std::array<std::uint8_t, 4>;

/// mantissa / 256 x 2^(e - 128). No half is added to the mantissa: writers today round, and readers agree on this.
glm::vec3 decode(Rgbe pixel) {
    if (pixel[3] == 0) return glm::vec3(0);
    const float unit = std::ldexp(1.0F, pixel[3] - 136);
    return unit * glm::vec3(pixel[0], pixel[1], pixel[2]);
}

struct Size {
    int width = 0;
    int height = 0;
    bool bottom_up = false;
    bool right_to_left = false;
};

/// "-Y 512 +X 1024": from the top down, rows of 1024 from the left.
std::optional<Size> parse_size(std::string_view line) {
    const auto number = [&](std::string_view axis) -> std::optional<int> {
        if (!line.substr(1).starts_with(axis)) return {};
        line.remove_prefix(1 + axis.size());
        int value = 0;
        const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
        if (error != std::errc() || value < 1) return {};
        line.remove_prefix(end - line.data());
        return value;
    };
    Size size;
    if (line.size() < 2) return {};
    size.bottom_up = line.front() == '+';
    const std::optional<int> height = number("Y ");
    if (!height || line.size() < 3 || line.front() != ' ') return {};
    line.remove_prefix(1);
    size.right_to_left = line.front() == '-';
    const std::optional<int> width = number("X ");
    if (!width) return {};
    size.width = *width;
    size.height = *height;
    return size;
}

/// Each of the four components run-length coded on its own.
void read_coded_row(Input& input, std::span<Rgbe> row) {
    for (std::size_t component = 0; component < 4; ++component) {
        std::size_t x = 0;
        while (x < row.size()) {
            const unsigned code = input.byte();
            const std::size_t count = code > 128 ? code - 128 : code;
            if (count == 0 || count > row.size() - x) throw input.damaged("a run is longer than the row");
            if (code > 128) {
                const auto value = static_cast<std::uint8_t>(input.byte());
                for (std::size_t i = 0; i < count; ++i) row[x++][component] = value;
            } else {
                for (std::size_t i = 0; i < count; ++i) row[x++][component] = static_cast<std::uint8_t>(input.byte());
            }
        }
    }
}

/// Whole pixels; 1, 1, 1, n repeats the one before n times, and consecutive counts are digits of base 256.
void read_flat_row(Input& input, std::span<Rgbe> row) {
    std::size_t x = 0;
    int shift = 0;
    while (x < row.size()) {
        Rgbe pixel;
        for (std::uint8_t& component : pixel) component = static_cast<std::uint8_t>(input.byte());
        if (pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1) {
            const std::size_t count = shift < 32 ? static_cast<std::size_t>(pixel[3]) << shift : row.size() + 1;
            if (x == 0 || count > row.size() - x) throw input.damaged("a run is longer than the row");
            const Rgbe previous = row[x - 1];
            std::fill_n(row.begin() + static_cast<std::ptrdiff_t>(x), count, previous);
            x += count;
            shift += 8;
        } else {
            row[x++] = pixel;
            shift = 0;
        }
    }
}

std::string_view as_text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

bool is_hdr(std::span<const std::byte> bytes) {
    return as_text(bytes).starts_with("#?RADIANCE") || as_text(bytes).starts_with("#?RGBE");
}

RadianceFile decode_hdr(std::span<const std::byte> bytes, const std::string& where) {
    Input input(as_text(bytes), where);
    float exposure = 1;
    while (true) {
        const std::string_view line = input.line();
        if (line.empty()) break;
        const std::size_t equals = line.find('=');
        if (line.front() == '#' || equals == std::string_view::npos) continue;
        const std::string_view key = line.substr(0, equals);
        std::string_view value = line.substr(equals + 1);
        value.remove_prefix(std::min(value.find_first_not_of(" \t"), value.size()));
        if (key == "FORMAT" && value != "32-bit_rle_rgbe")
            throw Error(fmt::format("Radiance HDR of FORMAT {} is not supported", value), where,
                        "Convert it to 32-bit_rle_rgbe or to OpenEXR.");
        if (key == "EXPOSURE") {
            float factor = 0;
            std::from_chars(value.data(), value.data() + value.size(), factor);
            if (!(std::isnormal(factor) && factor > 0)) throw input.damaged("EXPOSURE is not a positive number");
            exposure *= factor;
        }
    }
    const std::string_view size_line = input.line();
    const std::optional<Size> size = parse_size(size_line);
    if (!size)
        throw Error(fmt::format("Radiance HDR with the size \"{}\" is not supported", size_line.substr(0, 40)), where,
                    "Store it by rows, as -Y height +X width.");
    if (static_cast<std::int64_t>(size->width) * size->height > max_radiance_pixels)
        throw Error(fmt::format("the image has {} x {} pixels", size->width, size->height), where,
                    fmt::format("At most {} are read: scale it down.", max_radiance_pixels));
    // A run covers at most 127 pixels of one component with two bytes, or 255 whole pixels with four.
    if (input.left() < static_cast<std::size_t>(size->width) * size->height / 64) throw input.cut();

    RadianceFile file{{size->width, size->height, {}}, Envmap::unspecified, {}};
    file.image.pixels.resize(static_cast<std::size_t>(size->width) * size->height);
    std::vector<Rgbe> row(size->width);
    const bool may_be_coded = size->width >= 8 && size->width <= 0x7fff;
    const std::string coded_start{2, 2, static_cast<char>(size->width >> 8), static_cast<char>(size->width & 0xff)};
    for (int y = 0; y < size->height; ++y) {
        if (may_be_coded && input.starts_with(coded_start)) {
            for (int i = 0; i < 4; ++i) input.byte();
            read_coded_row(input, row);
        } else {
            read_flat_row(input, row);
        }
        if (size->right_to_left) std::reverse(row.begin(), row.end());
        glm::vec3* const target = &file.image.at(0, size->bottom_up ? size->height - 1 - y : y);
        std::transform(row.begin(), row.end(), target, decode);
    }
    if (exposure != 1) {
        for (glm::vec3& pixel : file.image.pixels) pixel /= exposure;
        file.notices.push_back(fmt::format("divided by the EXPOSURE of its header, {}", exposure));
    }
    return file;
}

}  // namespace lightgrid
