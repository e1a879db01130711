#pragma once

#include "probes/volume.h"

#include <ImathBox.h>
#include <ImfFrameBuffer.h>
#include <ImfPixelType.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// What the writer and the reader of volume files share: names, and how probes become pixels. Private to them;
/// FORMAT.md says the same to everybody else.
namespace lightgrid::volume_file {

inline constexpr const char* error_part = "combined.error";
inline constexpr const char* validity_part = "validity";
inline constexpr const char* index_part = "index";
inline constexpr const char* list_part = "list";

inline constexpr const char* format_attribute = "lightgrid.format";
inline constexpr const char* conventions_attribute = "lightgrid.conventions";
inline constexpr const char* bands_attribute = "lightgrid.bands";
inline constexpr const char* stored_bands_attribute = "lightgrid.storedBands";
inline constexpr const char* brick_size_attribute = "lightgrid.brickSize";
inline constexpr const char* layers_attribute = "lightgrid.layers";
inline constexpr const char* noise_attribute = "lightgrid.noise";
inline constexpr const char* grids_attribute = "lightgrid.grids";
inline constexpr const char* list_length_attribute = "lightgrid.listLength";
inline constexpr const char* list_origin_attribute = "lightgrid.listOrigin";
inline constexpr const char* settings_attribute = "lightgrid.settings";
[[nodiscard]] std::string grid_attribute(std::size_t grid, const char* what);

/// A tile is a brick, its z-slices side by side, or 64 rows of a probe list. Tiles fill the picture row by row.
inline constexpr int tile_width = brick_size * brick_size;
inline constexpr int tile_height = brick_size;
struct Layout {
    int columns = 1;  // tiles
    int rows = 1;

    [[nodiscard]] std::size_t tiles() const { return static_cast<std::size_t>(columns) * rows; }
    /// Data windows: a pixel for each probe, a pixel for each tile.
    [[nodiscard]] Imath::Box2i probes() const { return {{0, 0}, {columns * tile_width - 1, rows * tile_height - 1}}; }
    [[nodiscard]] Imath::Box2i index() const { return {{0, 0}, {columns - 1, rows - 1}}; }
};
/// How many tiles hold so many probes, and an about square picture of them.
[[nodiscard]] std::size_t tiles_for(std::size_t slots);
[[nodiscard]] Layout layout_for(std::size_t tiles);

/// A channel of a tiled part and where its numbers are in memory: four bytes at first + slot * stride, a float (HALF
/// and FLOAT) or bits (UINT). Like Imf::Slice, it knows only writable memory; writing a file reads it.
struct ProbeChannel {
    std::string name;
    Imf::PixelType type = Imf::FLOAT;  // in the file
    char* first = nullptr;
    std::size_t stride = 0;
};

/// What a part of coefficients leaves out: bands above, and colour (r = g = b: NAME.Y instead of NAME.R, .G, .B).
struct Stored {
    int bands = 0;
    bool grey = false;
};
/// c0.R c0.G c0.B c1.R ... or c0.Y c1.Y ..., of `bands` bands in memory.
///
/// coefficients  of the volume or one of its layers
[[nodiscard]] std::vector<ProbeChannel> light_channels(const Volume& volume, Stored stored,
                                                       std::vector<glm::vec3>& coefficients);
/// The same with e for c, then the six axes of irradiance: E+x.R ...
[[nodiscard]] std::vector<ProbeChannel> error_channels(Volume& volume, Stored stored);
/// offset.x .y .z
[[nodiscard]] std::vector<ProbeChannel> offset_channels(Volume& volume);
/// x.lo x.hi y.lo ...: the halves of the doubles' bits.
[[nodiscard]] std::vector<ProbeChannel> position_channels(Volume& volume);

using Scales = std::vector<float>;  // a factor per tile for HALF channels; empty: 1

/// The memory of one tile's channels, planar, for a frame buffer in tile coordinates.
class TileBuffer {
  public:
    /// half_as_float  HALF channels are converted on the way (OpenEXR does so when reading, not when writing)
    TileBuffer(const std::vector<ProbeChannel>& channels, bool half_as_float);

    [[nodiscard]] const Imf::FrameBuffer& frame() const { return frame_; }
    /// Pixel of probe p; two bytes wide where half is not converted, else four.
    [[nodiscard]] char* pixel(std::size_t channel, std::size_t p) {
        return planes_[channel].base + pixel_of_probe(p) * planes_[channel].size;
    }
    void clear();

  private:
    struct Plane {
        char* base;
        std::size_t size;  // bytes per pixel
    };
    [[nodiscard]] static constexpr std::size_t pixel_of_probe(std::size_t p) {
        const glm::ivec3 probe = probe_in_brick(p);
        return std::size_t{tile_width} * probe.y + std::size_t{brick_size} * probe.z + probe.x;
    }

    std::vector<std::uint32_t> memory_;
    std::vector<Plane> planes_;
    Imf::FrameBuffer frame_;
};

/// The index part: an image with one pixel per tile that says which brick it is.
struct Index {
    // Bits of `flags`.
    static constexpr std::uint32_t used = 1;  // the tile holds probes; the last ones of a picture may not
    static constexpr std::uint32_t rows = 2;  // those of the list, not a brick

    Index(std::size_t tiles, const Volume& volume);

    /// The channels that a file has: where bricks are only if there are cells, scales only with half.
    [[nodiscard]] Imf::FrameBuffer frame(const Volume& volume, int columns);

    std::vector<std::uint32_t> flags;
    std::vector<std::uint32_t> grid;
    std::array<std::vector<std::uint32_t>, 3> origin;
    Scales light_scale;
    Scales error_scale;
    std::vector<Scales> layer_scales;  // by layer
};

}  // namespace lightgrid::volume_file
