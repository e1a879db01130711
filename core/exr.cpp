#include "core/exr.h"

#include "core/error.h"
#include "core/near_names.h"

#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfRgbaFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStdIO.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

namespace lightgrid {
namespace {

using Imath::Box2i;

/// Where colour is in a file.
struct Color {
    int part = 0;
    std::string layer;                 // of the part's channels; empty: they have none
    std::string name;                  // of part and layer, for people; empty: both have none
    std::array<std::string, 3> names;  // of R, G, B; three times the same for luminance
    bool chroma = false;               // luminance and chroma, at lower resolution
};

/// All layers of a part that have colour, by name.
std::vector<Color> find_colors(const Imf::ChannelList& channels) {
    std::map<std::string, std::map<std::string, std::string>> layers;  // layer, channel in lower case: full name
    for (auto it = channels.begin(); it != channels.end(); ++it) {
        const std::string name = it.name();
        const std::size_t dot = name.rfind('.');
        const std::string layer = dot == std::string::npos ? "" : name.substr(0, dot);
        layers[layer].emplace(lower_case(name.substr(dot + 1)), name);
    }
    std::vector<Color> colors;
    for (const auto& [layer, names] : layers) {
        const auto find = [&names = names](const char* letter, const char* word) -> std::string {
            if (const auto it = names.find(letter); it != names.end()) return it->second;
            const auto it = names.find(word);
            return it != names.end() ? it->second : "";
        };
        const std::array rgb{find("r", "red"), find("g", "green"), find("b", "blue")};
        const std::string y = find("y", "luminance");
        const bool vector = names.contains("x");  // X, Y, Z of a normal, a position, a motion
        if (!rgb[0].empty() && !rgb[1].empty() && !rgb[2].empty()) {
            colors.push_back({0, layer, layer, rgb, false});
        } else if (!y.empty() && !vector) {
            colors.push_back({0, layer, layer, {y, y, y}, names.contains("ry") && names.contains("by")});
        }
    }
    return colors;
}

/// In the order of parts, then of names.
std::vector<Color> all_colors(const Imf::MultiPartInputFile& file, const std::string& where) {
    std::vector<Color> colors;
    std::string all_channels;
    for (int part = 0; part < file.parts(); ++part) {
        const Imf::Header& header = file.header(part);
        const bool deep = header.hasType() && Imf::isDeepData(header.type());
        for (auto it = header.channels().begin(); it != header.channels().end(); ++it)
            all_channels += fmt::format("{}{}", all_channels.empty() ? "" : ", ", it.name());
        if (deep) all_channels += " (deep)";
        if (deep) continue;
        for (Color& color : find_colors(header.channels())) {
            color.part = part;
            if (file.parts() > 1 && header.hasName() && header.name() != color.layer)
                color.name = header.name() + (color.layer.empty() ? "" : "." + color.layer);
            colors.push_back(std::move(color));
        }
    }
    if (colors.empty())
        throw Error(fmt::format("the OpenEXR image has no colour, only the channels {}", all_channels), where,
                    "Channels R, G and B, or Y, are needed.");
    return colors;
}

/// The words of a layer's name, in lower case: "ViewLayer.Combined", "rgba_main".
std::vector<std::string> words_of(const std::string& name) {
    std::vector<std::string> words(1);
    for (const char c : lower_case(name)) {
        if (std::isalnum(static_cast<unsigned char>(c)) != 0)
            words.back() += c;
        else if (!words.back().empty())
            words.emplace_back();
    }
    if (words.back().empty()) words.pop_back();
    return words;
}

/// How likely a layer is to be the picture as a whole, as renderers name theirs; lower is likelier.
int rank_of(const std::string& name) {
    static const std::vector<std::set<std::string>> usual = {
        {"combined"},
        {"beauty", "rgba", "rgb", "c", "ci", "final", "composite", "main", "master"},
        {"color", "colour", "image", "default"}};
    static const std::set<std::string> no_light = {"albedo",
                                                   "ao",
                                                   "alpha",
                                                   "ambientocclusion",
                                                   "occlusion",
                                                   "bump",
                                                   "crypto",
                                                   "cryptoasset",
                                                   "cryptomaterial",
                                                   "cryptoobject",
                                                   "denoise",
                                                   "denoising",
                                                   "depth",
                                                   "id",
                                                   "indexma",
                                                   "indexob",
                                                   "mask",
                                                   "matte",
                                                   "mist",
                                                   "motion",
                                                   "n",
                                                   "normal",
                                                   "normals",
                                                   "object",
                                                   "opacity",
                                                   "p",
                                                   "position",
                                                   "roughness",
                                                   "shadow",
                                                   "st",
                                                   "uv",
                                                   "vector",
                                                   "velocity",
                                                   "z",
                                                   "zdepth"};
    const std::vector<std::string> words = words_of(name);
    const auto has = [&](const std::set<std::string>& known) {
        return std::any_of(words.begin(), words.end(), [&](const std::string& word) { return known.contains(word); });
    };
    if (words.empty()) return 0;
    const int last = static_cast<int>(usual.size()) + 1;
    if (has(no_light)) return last + 1;
    for (std::size_t i = 0; i < usual.size(); ++i)
        if (has(usual[i])) return static_cast<int>(i) + 1;
    return last;
}

bool is_called(const Color& color, const std::string& asked) {
    const std::string name = lower_case(color.name);
    const std::string wanted = lower_case(asked);
    return name == wanted || name.ends_with("." + wanted);
}

std::string listed(const std::vector<Color>& colors) {
    std::string names;
    for (const Color& color : colors)
        names += fmt::format("{}{}", names.empty() ? "" : ", ", color.name.empty() ? "(unnamed)" : color.name);
    return names;
}

/// asked  the name of a layer; empty: the likeliest
Color choose_color(const Imf::MultiPartInputFile& file, const std::string& asked, const std::string& where,
                   std::vector<std::string>& notices) {
    std::vector<Color> colors = all_colors(file, where);
    if (!asked.empty()) {
        const auto whole = std::find_if(colors.begin(), colors.end(), [&](const Color& c) { return c.name == asked; });
        if (whole != colors.end()) return *whole;
        std::vector<Color> called;
        std::copy_if(colors.begin(), colors.end(), std::back_inserter(called),
                     [&](const Color& color) { return is_called(color, asked); });
        if (called.size() == 1) return called.front();
        throw Error(called.empty() ? fmt::format("has no layer \"{}\" with colour", asked)
                                   : fmt::format("several layers are called \"{}\"", asked),
                    where, fmt::format("Name one of: {}.", listed(called.empty() ? colors : called)));
    }
    const Color chosen = *std::min_element(
        colors.begin(), colors.end(), [](const Color& a, const Color& b) { return rank_of(a.name) < rank_of(b.name); });
    const std::string what = chosen.name.empty() ? "the unnamed layer" : fmt::format("layer \"{}\"", chosen.name);
    if (colors.size() > 1)
        notices.push_back(fmt::format("{} was read, of {}", what, listed(colors)));
    else if (!chosen.name.empty())
        notices.push_back(what + " was read");
    return chosen;
}

std::int64_t area(const Box2i& window) {
    if (window.isEmpty()) return 0;
    return (std::int64_t{window.max.x} - window.min.x + 1) * (std::int64_t{window.max.y} - window.min.y + 1);
}

/// Refuses what cannot be meant before memory is taken for it. Deflate reaches about 1000 to 1, on 6 bytes a pixel or
/// more; no codec of OpenEXR comes near 16,384 pixels a byte of file.
void check_area(const Box2i& window, std::size_t file_size, const std::string& where) {
    const std::int64_t pixels = area(window);
    if (pixels > 0 && pixels <= max_radiance_pixels && pixels / 16384 <= static_cast<std::int64_t>(file_size)) return;
    throw Error(fmt::format("the OpenEXR image claims the pixels {}, {} to {}, {} in {} bytes", window.min.x,
                            window.min.y, window.max.x, window.max.y, file_size),
                where, fmt::format("Unless the file is damaged, scale it to at most {} pixels.", max_radiance_pixels));
}

RadianceImage black(const Box2i& window) {
    RadianceImage image{window.max.x - window.min.x + 1, window.max.y - window.min.y + 1, {}};
    image.pixels.resize(static_cast<std::size_t>(image.width) * image.height, glm::vec3(0));
    return image;
}

/// The data window, all of it, at full resolution.
RadianceImage read_channels(Imf::MultiPartInputFile& file, const Color& color) {
    Imf::InputPart part(file, color.part);
    const Box2i window = part.header().dataWindow();
    RadianceImage image = black(window);
    // OpenEXR addresses pixels by their coordinates, so that the first slice begins far outside of the array.
    const auto base = [&](int c) {
        const std::int64_t first = static_cast<std::int64_t>(window.min.y) * image.width + window.min.x;
        return reinterpret_cast<char*>(reinterpret_cast<std::uintptr_t>(&image.pixels.front()[c]) -
                                       static_cast<std::uintptr_t>(first) * sizeof(glm::vec3));
    };
    const bool grey = color.names[0] == color.names[1];
    Imf::FrameBuffer buffer;
    for (int c = 0; c < (grey ? 1 : 3); ++c)
        buffer.insert(color.names[c],
                      Imf::Slice(Imf::FLOAT, base(c), sizeof(glm::vec3), sizeof(glm::vec3) * image.width));
    part.setFrameBuffer(buffer);
    part.readPixels(window.min.y, window.max.y);
    if (grey)
        for (glm::vec3& pixel : image.pixels) pixel = glm::vec3(pixel.r);
    return image;
}

/// Luminance and chroma: OpenEXR's own filter brings the chroma to full resolution, in half precision.
RadianceImage read_chroma(const std::string& bytes, const std::string& layer) {
    Imf::StdISStream stream;
    stream.str(bytes);
    Imf::RgbaInputFile file(stream, layer);
    const Box2i window = file.dataWindow();
    RadianceImage image = black(window);
    std::vector<Imf::Rgba> row(image.width);
    for (int y = 0; y < image.height; ++y) {
        file.setFrameBuffer(row.data() - window.min.x, 1, 0);
        file.readPixels(window.min.y + y);
        for (int x = 0; x < image.width; ++x) image.at(x, y) = glm::vec3(row[x].r, row[x].g, row[x].b);
    }
    return image;
}

void convert_to_rec709(RadianceImage& image, const Imf::Header& header, std::vector<std::string>& notices) {
    if (!Imf::hasChromaticities(header)) return;
    const Imf::Chromaticities stored = Imf::chromaticities(header);
    const Imf::Chromaticities rec709;
    const auto near = [](const Imath::V2f& a, const Imath::V2f& b) { return (a - b).length() < 1e-3F; };
    if (near(stored.red, rec709.red) && near(stored.green, rec709.green) && near(stored.blue, rec709.blue) &&
        near(stored.white, rec709.white))
        return;
    const Imath::M44f matrix = Imf::RGBtoXYZ(stored, 1) * Imf::XYZtoRGB(rec709, 1);
    for (glm::vec3& pixel : image.pixels) {
        Imath::V3f color;
        matrix.multDirMatrix(Imath::V3f(pixel.r, pixel.g, pixel.b), color);
        pixel = {color.x, color.y, color.z};
    }
    notices.push_back("converted to Rec.709 from the primaries that the file names");
}

/// What of the data lies in the frame, the rest black.
RadianceImage fit(RadianceImage data, const Box2i& data_window, const Box2i& frame) {
    if (data_window == frame) return data;
    RadianceImage image = black(frame);
    const int first = std::max(frame.min.x, data_window.min.x);
    const int end = std::min(frame.max.x, data_window.max.x) + 1;
    for (int y = std::max(frame.min.y, data_window.min.y); y <= std::min(frame.max.y, data_window.max.y); ++y) {
        const glm::vec3* const source = &data.at(0, y - data_window.min.y) - data_window.min.x;
        std::copy(source + first, source + end, &image.at(0, y - frame.min.y) - frame.min.x + first);
    }
    return image;
}

RadianceFile read_file(const std::string& bytes, const std::string& where, const std::string& layer) {
    Imf::StdISStream stream;
    stream.str(bytes);
    Imf::MultiPartInputFile file(stream);
    RadianceFile result;
    const Color color = choose_color(file, layer, where, result.notices);
    const Imf::Header& header = file.header(color.part);
    const Box2i data = header.dataWindow();
    check_area(data, bytes.size(), where);

    if (Imf::hasEnvmap(header))
        result.envmap = Imf::envmap(header) == Imf::ENVMAP_CUBE ? Envmap::cube : Envmap::latlong;
    Box2i frame = data;
    if (result.envmap == Envmap::unspecified && header.displayWindow() != data) {
        const Box2i display = header.displayWindow();
        if (data.intersects(display)) {
            check_area(display, bytes.size(), where);
            frame = display;
            result.notices.push_back(fmt::format(
                "data window {}, {} to {}, {} fitted to the display window {}, {} to {}, {}", data.min.x, data.min.y,
                data.max.x, data.max.y, display.min.x, display.min.y, display.max.x, display.max.y));
        } else {
            result.notices.push_back("the data window lies outside the display window: it was read as the picture");
        }
    }
    if (color.chroma && color.part > 0)
        throw Error("luminance and chroma channels are read from the first part only", where,
                    "Convert it to R, G and B.");
    result.image = color.chroma ? read_chroma(bytes, color.layer) : read_channels(file, color);
    convert_to_rec709(result.image, header, result.notices);
    result.image = fit(std::move(result.image), data, frame);
    return result;
}

void check_finite(const RadianceImage& image, const std::string& where) {
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const glm::vec3& pixel = image.at(x, y);
            if (std::isfinite(pixel.r) && std::isfinite(pixel.g) && std::isfinite(pixel.b)) continue;
            throw Error(fmt::format("pixel {}, {} is {}, {}, {}", x, y, pixel.r, pixel.g, pixel.b), where,
                        "Replace it by a finite value.");
        }
    }
}

}  // namespace

bool is_exr(std::span<const std::byte> bytes) {
    constexpr std::array magic{std::byte{0x76}, std::byte{0x2f}, std::byte{0x31}, std::byte{0x01}};
    return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
}

RadianceFile decode_exr(std::span<const std::byte> bytes, const std::string& where, const std::string& layer) {
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    RadianceFile file;
    try {
        file = read_file(text, where, layer);
    } catch (const Error&) {
        throw;
    } catch (const std::exception& problem) {  // OpenEXR's own, and of the standard library where it checks too little
        throw Error(fmt::format("the OpenEXR image cannot be read: {}", problem.what()), where,
                    "The file is damaged or cut off: export it again.");
    }
    check_finite(file.image, where);
    return file;
}

std::string encode_exr(const RadianceImage& image) {
    Imf::Header header(image.width, image.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer buffer;
    const char* const names[] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c) {
        header.channels().insert(names[c], Imf::Channel(Imf::FLOAT));
        // Slices are read only, whatever their type says.
        char* const base = const_cast<char*>(reinterpret_cast<const char*>(&image.pixels.front()[c]));
        buffer.insert(names[c], Imf::Slice(Imf::FLOAT, base, sizeof(glm::vec3), sizeof(glm::vec3) * image.width));
    }
    Imf::StdOSStream stream;
    {
        Imf::OutputFile file(stream, header);
        file.setFrameBuffer(buffer);
        file.writePixels(image.height);
    }
    return stream.str();
}

}  // namespace lightgrid
