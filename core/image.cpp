#include "core/image.h"

#include "core/error.h"
#include "core/exr.h"
#include "core/hdr.h"
#include "core/whole_file.h"

#include <fmt/format.h>

// Compiled in here, for this file alone: Draco's shared library has a copy of its own, which would be called instead.
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_JPEG
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#include <stb_image.h>
#include <stb_image_write.h>
#include <webp/decode.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <numeric>
#include <string_view>
#include <zlib.h>

namespace lightgrid {
namespace {

using Bytes = std::span<const std::byte>;

enum class Format { png, jpeg, webp };

bool has_bytes_at(Bytes bytes, std::size_t offset, std::string_view wanted) {
    return bytes.size() >= offset + wanted.size() &&
           std::memcmp(bytes.data() + offset, wanted.data(), wanted.size()) == 0;
}

const unsigned char* as_chars(Bytes bytes) {
    return reinterpret_cast<const unsigned char*>(bytes.data());
}

Format recognise(Bytes bytes, const std::string& where) {
    if (bytes.empty()) throw Error("the image is empty", where);
    if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
        throw Error(fmt::format("the image file has {} bytes, more than 2 GiB", bytes.size()), where);

    if (has_bytes_at(bytes, 0, "\x89PNG\r\n\x1a\n")) return Format::png;
    if (has_bytes_at(bytes, 0, "\xff\xd8\xff")) return Format::jpeg;
    if (has_bytes_at(bytes, 0, "RIFF") && has_bytes_at(bytes, 8, "WEBP")) return Format::webp;

    struct Signature {
        std::size_t offset;
        std::string_view start;
        const char* name;
    };
    static constexpr std::array unsupported{
        Signature{0, "\xabKTX 20\xbb\r\n\x1a\n", "KTX2"},
        Signature{0, "\xabKTX 11\xbb\r\n\x1a\n", "KTX"},
        Signature{0, "DDS ", "DDS"},
        Signature{0, "GIF8", "GIF"},
        Signature{0, "BM", "BMP"},
        Signature{4, "ftypavif", "AVIF"},
        Signature{0, "II*\0", "TIFF"},
        Signature{0, "MM\0*", "TIFF"},
        Signature{0, "\x76\x2f\x31\x01", "OpenEXR"},
        Signature{0, "#?RADIANCE", "Radiance HDR"},
    };
    for (const Signature& signature : unsupported) {
        if (!has_bytes_at(bytes, signature.offset, signature.start)) continue;
        throw Error(fmt::format("the image is {}, which is not supported here", signature.name), where,
                    "Convert it to PNG, JPEG or WebP.");
    }
    throw Error("the image is neither PNG, JPEG nor WebP", where, "Convert it to one of them.");
}

/// stb_image checks no checksums, so that damage would become wrong colours: the chunks that matter are checked here.
bool png_is_intact(Bytes bytes) {
    const unsigned char* data = as_chars(bytes);
    const auto word_at = [&](std::size_t i) {
        return std::uint32_t{data[i]} << 24 | std::uint32_t{data[i + 1]} << 16 | std::uint32_t{data[i + 2]} << 8 |
               std::uint32_t{data[i + 3]};
    };
    constexpr std::size_t around = 12;  // length, type and checksum of a chunk
    std::size_t i = 8;                  // behind the signature
    while (bytes.size() - i >= around) {
        const std::size_t length = word_at(i);
        if (length > bytes.size() - i - around) return false;
        const bool critical = (data[i + 4] & 0x20) == 0;  // an upper-case type
        const uLong checksum = crc32(0, data + i + 4, static_cast<uInt>(length) + 4);
        if (critical && checksum != word_at(i + 8 + length)) return false;
        if (has_bytes_at(bytes, i + 4, "IEND")) return true;
        i += length + around;
    }
    return false;
}

/// The tables of a JPEG's DHT segment (class and number, 16 counts, symbols) hold no more symbols than there can be.
bool huffman_tables_fit(std::span<const unsigned char> segment) {
    constexpr std::size_t counts = 16, most_symbols = 256;
    while (!segment.empty()) {
        if (segment.size() < 1 + counts) return false;
        const auto count = segment.subspan(1, counts);
        const auto symbols = std::accumulate(count.begin(), count.end(), std::size_t{0});
        if (symbols > most_symbols || 1 + counts + symbols > segment.size()) return false;
        segment = segment.subspan(1 + counts + symbols);
    }
    return true;
}

/// stb_image fills what a cut JPEG lacks with grey, so that its end is looked for here: walks the markers to the EOI.
/// Before version 2.28 it also writes Huffman tables that are too large over what comes behind them.
bool jpeg_is_intact(Bytes bytes) {
    const unsigned char* data = as_chars(bytes);
    const std::size_t size = bytes.size();
    constexpr unsigned soi = 0xd8, eoi = 0xd9, sos = 0xda, dht = 0xc4, tem = 0x01, rst0 = 0xd0, rst7 = 0xd7;
    bool in_scan = false;
    std::size_t i = 0;
    while (i + 1 < size) {
        if (data[i] != 0xff) {
            ++i;  // entropy-coded data, or bytes between segments, which decoders pass over
            continue;
        }
        const unsigned marker = data[i + 1];
        if (marker == 0xff) {
            ++i;  // fill byte
        } else if (marker == eoi) {
            return in_scan;
        } else if (marker == 0 || marker == soi || marker == tem || (marker >= rst0 && marker <= rst7)) {
            i += 2;
        } else {
            if (i + 3 >= size) return false;
            in_scan = in_scan || marker == sos;
            const std::size_t length = data[i + 2] << 8 | data[i + 3];  // of itself and what follows
            if (length < 2 || i + 2 + length > size) return false;
            if (marker == dht && !huffman_tables_fit({data + i + 4, length - 2})) return false;
            i += 2 + length;
        }
    }
    return false;
}

struct StbFree {
    void operator()(void* pixels) const { stbi_image_free(pixels); }
};

Error undecodable(std::string_view format, std::string_view reason, const std::string& where) {
    return Error(fmt::format("the {} image cannot be decoded: {}", format, reason), where,
                 "The file is damaged or cut off: export it again.");
}

std::string_view stb_reason() {
    const char* reason = stbi_failure_reason();
    return reason != nullptr ? reason : "unknown reason";
}

ByteImage decode_stb(Bytes bytes, Format format, const std::string& where) {
    const std::string_view name = format == Format::png ? "PNG" : "JPEG";
    if (format == Format::png && !png_is_intact(bytes))
        throw undecodable(name, "it ends too early, or a checksum is wrong", where);
    if (format == Format::jpeg && !jpeg_is_intact(bytes))
        throw undecodable(name, "it ends before its end-of-image marker, or a Huffman table is too large", where);

    const int size = static_cast<int>(bytes.size());
    ByteImage image;
    int channels = 0;
    if (stbi_is_16_bit_from_memory(as_chars(bytes), size) != 0) {
        const std::unique_ptr<stbi_us, StbFree> wide(
            stbi_load_16_from_memory(as_chars(bytes), size, &image.width, &image.height, &channels, 4));
        if (!wide) throw undecodable(name, stb_reason(), where);
        image.pixels.resize(static_cast<std::size_t>(image.width) * image.height);
        std::uint8_t* narrow = &image.pixels.front().x;
        std::transform(wide.get(), wide.get() + 4 * image.pixels.size(), narrow,
                       [](stbi_us value) { return static_cast<std::uint8_t>((value * 255U + 32767U) / 65535U); });
    } else {
        const std::unique_ptr<stbi_uc, StbFree> decoded(
            stbi_load_from_memory(as_chars(bytes), size, &image.width, &image.height, &channels, 4));
        if (!decoded) throw undecodable(name, stb_reason(), where);
        static_assert(sizeof(glm::u8vec4) == 4);
        image.pixels.resize(static_cast<std::size_t>(image.width) * image.height);
        std::memcpy(image.pixels.data(), decoded.get(), 4 * image.pixels.size());
    }
    return image;
}

WebPBitstreamFeatures webp_features(Bytes bytes, const std::string& where) {
    WebPBitstreamFeatures features;
    if (WebPGetFeatures(as_chars(bytes), bytes.size(), &features) != VP8_STATUS_OK)
        throw undecodable("WebP", "no valid header", where);
    if (features.has_animation != 0)
        throw Error("the WebP image is an animation, which is not supported", where, "Export a still image.");
    return features;
}

ByteImage decode_webp(Bytes bytes, const std::string& where) {
    const WebPBitstreamFeatures features = webp_features(bytes, where);
    ByteImage image{features.width, features.height, {}};
    image.pixels.resize(static_cast<std::size_t>(image.width) * image.height);
    if (WebPDecodeRGBAInto(as_chars(bytes), bytes.size(), &image.pixels.front().x, 4 * image.pixels.size(),
                           4 * image.width) == nullptr)
        throw undecodable("WebP", "damaged or incomplete data", where);
    return image;
}

}  // namespace

ByteImage decode_image(std::span<const std::byte> bytes, const std::string& where) {
    const Format format = recognise(bytes, where);
    return format == Format::webp ? decode_webp(bytes, where) : decode_stb(bytes, format, where);
}

glm::ivec2 image_size(std::span<const std::byte> bytes, const std::string& where) {
    const Format format = recognise(bytes, where);
    if (format == Format::webp) {
        const WebPBitstreamFeatures features = webp_features(bytes, where);
        return {features.width, features.height};
    }
    glm::ivec2 size{0};
    int channels = 0;
    if (stbi_info_from_memory(as_chars(bytes), static_cast<int>(bytes.size()), &size.x, &size.y, &channels) == 0)
        throw undecodable(format == Format::png ? "PNG" : "JPEG", stb_reason(), where);
    return size;
}

float decode_srgb(std::uint8_t value) noexcept {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> linear{};
        for (std::size_t i = 0; i < linear.size(); ++i) {
            const double x = static_cast<double>(i) / 255;
            linear[i] = static_cast<float>(x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4));
        }
        return linear;
    }();
    return table[value];
}

RadianceFile decode_radiance(std::span<const std::byte> bytes, const std::string& where, const std::string& layer) {
    if (is_exr(bytes)) return decode_exr(bytes, where, layer);
    if (!layer.empty())
        throw Error(fmt::format("has no layer \"{}\": only OpenEXR images have layers", layer), where,
                    "Name no layer.");
    if (is_hdr(bytes)) return decode_hdr(bytes, where);
    const ByteImage stored = decode_image(bytes, where);
    RadianceFile file{{stored.width, stored.height, {}}, Envmap::unspecified, {}};
    file.image.pixels.reserve(stored.pixels.size());
    for (const glm::u8vec4 pixel : stored.pixels)
        file.image.pixels.emplace_back(decode_srgb(pixel.r), decode_srgb(pixel.g), decode_srgb(pixel.b));
    file.notices.push_back("8-bit image, decoded from sRGB: its brightest value is 1 cd/m^2");
    return file;
}

RadianceFile read_radiance(const std::filesystem::path& path, const std::string& layer) {
    const std::string bytes = read_whole_file(path);
    return decode_radiance(std::as_bytes(std::span(bytes)), path.string(), layer);
}

void write_exr(const RadianceImage& image, const std::filesystem::path& path) {
    write_whole_file(path, encode_exr(image));
}

void write_png(const ByteImage& image, const std::filesystem::path& path) {
    const bool opaque =
        std::all_of(image.pixels.begin(), image.pixels.end(), [](glm::u8vec4 pixel) { return pixel.a == 255; });
    const int channels = opaque ? 3 : 4;
    std::string samples;
    samples.reserve(image.pixels.size() * channels);
    for (const glm::u8vec4& pixel : image.pixels)
        for (int c = 0; c < channels; ++c) samples.push_back(static_cast<char>(pixel[c]));

    std::string file;
    const auto append = [](void* out, void* data, int size) {
        static_cast<std::string*>(out)->append(static_cast<const char*>(data), size);
    };
    if (stbi_write_png_to_func(append, &file, image.width, image.height, channels, samples.data(),
                               image.width * channels) == 0)
        throw Error(fmt::format("a PNG of {} x {} cannot be encoded", image.width, image.height), path.string(), "",
                    Fault::work);
    write_whole_file(path, file);
}

}  // namespace lightgrid
