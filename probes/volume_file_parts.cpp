#include "probes/volume_file_parts.h"

#include "core/sh.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <initializer_list>

namespace lightgrid::volume_file {
namespace {

static_assert(std::endian::native == std::endian::little, "x.lo is the first half of a double in memory");

char* address(float& value) {
    return reinterpret_cast<char*>(&value);
}

// One colour per slot: value `index` of the `per_slot` that each slot has.
void add_colour(std::vector<ProbeChannel>& channels, const std::string& name, Imf::PixelType type, bool grey,
                std::vector<glm::vec3>& values, std::size_t per_slot, std::size_t index) {
    const std::size_t stride = per_slot * sizeof(glm::vec3);
    if (grey) {
        channels.push_back({name + ".Y", type, address(values[index].r), stride});
    } else {
        channels.push_back({name + ".R", type, address(values[index].r), stride});
        channels.push_back({name + ".G", type, address(values[index].g), stride});
        channels.push_back({name + ".B", type, address(values[index].b), stride});
    }
}

std::vector<ProbeChannel> sh_channels(const char* prefix, const Volume& volume, Stored stored,
                                      std::vector<glm::vec3>& values) {
    std::vector<ProbeChannel> channels;
    const Imf::PixelType type = volume.half ? Imf::HALF : Imf::FLOAT;
    for (int i = 0; i < sh_size(stored.bands); ++i) {
        add_colour(channels, fmt::format("{}{}", prefix, i), type, stored.grey, values, volume.sh_size(), i);
    }
    return channels;
}

}  // namespace

std::string grid_attribute(std::size_t grid, const char* what) {
    return fmt::format("lightgrid.grid{}.{}", grid, what);
}

std::size_t tiles_for(std::size_t slots) {
    return (slots + probes_per_brick - 1) / probes_per_brick;
}

Layout layout_for(std::size_t tiles) {
    // Square: columns * tile_width = rows * tile_height, and columns * rows = tiles.
    const double columns = std::ceil(std::sqrt(static_cast<double>(tiles) * tile_height / tile_width));
    const auto whole = static_cast<std::size_t>(columns);
    return {static_cast<int>(whole), static_cast<int>((tiles + whole - 1) / whole)};
}

std::vector<ProbeChannel> light_channels(const Volume& volume, Stored stored, std::vector<glm::vec3>& coefficients) {
    return sh_channels("c", volume, stored, coefficients);
}

std::vector<ProbeChannel> error_channels(Volume& volume, Stored stored) {
    std::vector<ProbeChannel> channels = sh_channels("e", volume, stored, volume.errors);
    const Imf::PixelType type = volume.half ? Imf::HALF : Imf::FLOAT;
    std::size_t axis = 0;
    for (const char* name : {"E+x", "E-x", "E+y", "E-y", "E+z", "E-z"}) {
        add_colour(channels, name, type, stored.grey, volume.axis_errors, axis_normals.size(), axis++);
    }
    return channels;
}

std::vector<ProbeChannel> offset_channels(Volume& volume) {
    glm::vec3& first = volume.offsets.front();
    return {{"offset.x", Imf::FLOAT, address(first.x), sizeof first},
            {"offset.y", Imf::FLOAT, address(first.y), sizeof first},
            {"offset.z", Imf::FLOAT, address(first.z), sizeof first}};
}

std::vector<ProbeChannel> position_channels(Volume& volume) {
    std::vector<ProbeChannel> channels;
    char* word = reinterpret_cast<char*>(volume.list.data());
    for (const char* name : {"x.lo", "x.hi", "y.lo", "y.hi", "z.lo", "z.hi"}) {
        channels.push_back({name, Imf::UINT, word, sizeof(glm::dvec3)});
        word += sizeof(std::uint32_t);
    }
    return channels;
}

TileBuffer::TileBuffer(const std::vector<ProbeChannel>& channels, bool half_as_float)
    : memory_(channels.size() * probes_per_brick) {
    for (const ProbeChannel& channel : channels) {
        const Imf::PixelType type = channel.type == Imf::HALF && half_as_float ? Imf::FLOAT : channel.type;
        const std::size_t size = type == Imf::HALF ? sizeof(std::uint16_t) : sizeof(std::uint32_t);
        char* base = reinterpret_cast<char*>(memory_.data() + planes_.size() * probes_per_brick);
        planes_.push_back({base, size});
        constexpr bool in_tile_coordinates = true;
        frame_.insert(channel.name, Imf::Slice(type, base, size, size * tile_width, 1, 1, 0, in_tile_coordinates,
                                               in_tile_coordinates));
    }
}

void TileBuffer::clear() {
    std::fill(memory_.begin(), memory_.end(), 0);
}

Index::Index(std::size_t tiles, const Volume& volume)
    : flags(tiles),
      grid(tiles),
      light_scale(tiles, 1.0F),
      error_scale(tiles, 1.0F),
      layer_scales(volume.layers.size(), light_scale) {
    origin.fill(std::vector<std::uint32_t>(tiles));
}

Imf::FrameBuffer Index::frame(const Volume& volume, int columns) {
    Imf::FrameBuffer result;
    const auto add = [&](const std::string& name, Imf::PixelType type, void* data) {
        constexpr std::size_t size = 4;  // bytes, UINT and FLOAT
        result.insert(name, Imf::Slice(type, static_cast<char*>(data), size, size * columns));
    };
    add("flags", Imf::UINT, flags.data());
    if (volume.has_cells()) {
        add("grid", Imf::UINT, grid.data());
        add("origin.x", Imf::UINT, origin[0].data());
        add("origin.y", Imf::UINT, origin[1].data());
        add("origin.z", Imf::UINT, origin[2].data());
    }
    if (volume.half) {
        add("combined.scale", Imf::FLOAT, light_scale.data());
        add("combined.error.scale", Imf::FLOAT, error_scale.data());
        for (std::size_t i = 0; i < layer_scales.size(); ++i) {
            add(volume.layers[i].name + ".scale", Imf::FLOAT, layer_scales[i].data());
        }
    }
    return result;
}

}  // namespace lightgrid::volume_file
