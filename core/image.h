#pragma once

#include <glm/glm.hpp>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace lightgrid {

/// Linear radiance (or any other linear quantity), row-major, top row first.
struct RadianceImage {
    int width = 0;
    int height = 0;
    std::vector<glm::vec3> pixels;

    [[nodiscard]] const glm::vec3& at(int x, int y) const { return pixels[static_cast<std::size_t>(y) * width + x]; }
    [[nodiscard]] glm::vec3& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
};

/// Eight bits a channel as stored in the file (no sRGB decoding), row-major, top row first. Missing alpha is 255; grey
/// is spread over R, G, B.
struct ByteImage {
    int width = 0;
    int height = 0;
    std::vector<glm::u8vec4> pixels;

    [[nodiscard]] const glm::u8vec4& at(int x, int y) const { return pixels[static_cast<std::size_t>(y) * width + x]; }
    [[nodiscard]] glm::u8vec4& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
};

/// PNG, JPEG or WebP from memory, recognised by content; 16-bit PNG is rounded to 8. A file that is damaged, cut off or
/// of another format (KTX2, DDS, ...) throws Error naming it. `where` is what messages call the image.
[[nodiscard]] ByteImage decode_image(std::span<const std::byte> bytes, const std::string& where);

/// Size in pixels from the header alone: cheap. Throws Error.
[[nodiscard]] glm::ivec2 image_size(std::span<const std::byte> bytes, const std::string& where);

/// A byte of an sRGB image as a linear number in [0, 1] (IEC 61966-2-1).
[[nodiscard]] float decode_srgb(std::uint8_t value) noexcept;

/// The mapping that an OpenEXR file claims in its `envmap` attribute.
enum class Envmap : std::uint8_t { unspecified, latlong, cube };

struct RadianceFile {
    RadianceImage image;
    Envmap envmap = Envmap::unspecified;
    std::vector<std::string> notices;  // choices made where the file left some, for the user
};

/// A picture of linear light from memory, recognised by content.
///
/// OpenEXR       scanline, tiled, multi-part, any compression; level 0 of mip- and rip-maps; half, float or uint;
///               R, G, B or luminance (Y, with or without RY and BY). Of several layers (channels "LAYER.R", or parts by
///               their names) the one that `layer` names, in any case, whole or by its last words ("Combined" is
///               "ViewLayer.Combined"); else the combined or unnamed one, then beauty by its usual names, then the first
///               that is not known for something other than light (an ambient occlusion, a normal); the choice is said.
///               Converted to Rec.709 where `chromaticities` says otherwise. The picture is the display window, black
///               where the data window leaves it out; with an `envmap` attribute it is the data window, as ImfEnvmap.h
///               says.
/// Radiance HDR  RGBE, run-length coded or flat, divided by EXPOSURE as its specification asks.
/// PNG, JPEG, WebP  decoded from sRGB to [0, 1].
///
/// Throws Error: an unknown format, no such layer (those that are there are listed), a damaged or cut file, no colour (channels are listed), a pixel that is not finite
/// (named), more than max_radiance_pixels. Negative values are kept.
[[nodiscard]] RadianceFile decode_radiance(std::span<const std::byte> bytes, const std::string& where,
                                           const std::string& layer = {});
[[nodiscard]] RadianceFile read_radiance(const std::filesystem::path& path, const std::string& layer = {});

inline constexpr std::int64_t max_radiance_pixels = std::int64_t{1} << 28;  // 16,384 x 16,384: 3 GiB

/// OpenEXR, R, G, B as float, losslessly compressed. Written whole or not at all; throws Error.
void write_exr(const RadianceImage& image, const std::filesystem::path& path);

/// PNG, 8 bits a channel, with alpha where a pixel is not opaque. Written whole or not at all; throws Error.
void write_png(const ByteImage& image, const std::filesystem::path& path);

}  // namespace lightgrid
