#include "core/error.h"
#include "core/sh.h"
#include "core/whole_file.h"
#include "probes/volume_file.h"
#include "probes/volume_file_parts.h"

#include <Iex.h>
#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStringVectorAttribute.h>
#include <ImfTiledInputPart.h>
#include <ImfVecAttribute.h>
#include <ImfVersion.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <string_view>

namespace lightgrid {
namespace volume_file {
namespace {

class InputBytes : public Imf::IStream {
  public:
    InputBytes(std::span<const std::byte> bytes, const std::string& name) : IStream(name.c_str()), bytes_(bytes) {}

    bool read(char target[], int count) override {
        if (count < 0 || position_ > bytes_.size() || static_cast<std::size_t>(count) > bytes_.size() - position_) {
            throw Iex::InputExc("it ends too early");
        }
        std::memcpy(target, bytes_.data() + position_, count);
        position_ += count;
        return position_ < bytes_.size();
    }
    std::uint64_t tellg() override { return position_; }
    void seekg(std::uint64_t position) override { position_ = position; }

  private:
    std::span<const std::byte> bytes_;
    std::uint64_t position_ = 0;
};

// OpenEXR allocates what an attribute says its size is before it looks how much file there is: up to 2 GiB for one
// altered byte. So the headers are walked through first: magic number, flags, then name, type, size and value of each
// attribute.
void check_attribute_sizes(std::span<const std::byte> bytes) {
    std::string_view rest(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const auto take = [&rest](std::size_t size) {
        if (size > rest.size()) throw Iex::InputExc("it ends too early");
        const std::string_view taken = rest.substr(0, size);
        rest.remove_prefix(size);
        return taken;
    };
    const auto take_name = [&] {
        const std::string_view name = take(std::min(rest.find('\0'), rest.size()));
        take(1);
        return name;
    };
    take(sizeof(std::uint32_t));
    const bool many_parts = (static_cast<unsigned char>(take(sizeof(std::uint32_t))[1]) & 0x10U) != 0;
    for (bool first_of_part = true;;) {
        const std::string_view name = take_name();
        if (name.empty()) {
            // A part ends; so do all, after the only one or with an empty one.
            if (!many_parts || first_of_part) return;
            first_of_part = true;
            continue;
        }
        first_of_part = false;
        take_name();  // type
        std::int32_t size = 0;
        std::memcpy(&size, take(sizeof size).data(), sizeof size);
        if (size < 0 || static_cast<std::size_t>(size) > rest.size()) {
            throw Error(
                fmt::format("is damaged: attribute \"{}\" has {} bytes, but {} are left", name, size, rest.size()));
        }
        take(size);
    }
}

std::string in_part(const Imf::Header& header) {
    return fmt::format("part \"{}\"", header.name());
}

template <typename Attribute>
const auto& attribute(const Imf::Header& header, const char* name) {
    const auto* found = header.findTypedAttribute<Attribute>(name);
    if (found == nullptr) {
        throw Error(fmt::format("attribute \"{}\" is missing or of another type", name), in_part(header));
    }
    return found->value();
}

void require_channel(const Imf::Header& header, const std::string& name, Imf::PixelType type) {
    const Imf::Channel* found = header.channels().findChannel(name);
    if (found == nullptr || found->type != type || found->xSampling != 1 || found->ySampling != 1) {
        throw Error(fmt::format("channel \"{}\" is missing or of another type", name), in_part(header));
    }
}

int find_part(const Imf::MultiPartInputFile& file, const std::string& name) {  // -1: none
    for (int i = 0; i < file.parts(); ++i) {
        if (file.header(i).hasName() && file.header(i).name() == name) return i;
    }
    return -1;
}

int require_part(const Imf::MultiPartInputFile& file, const std::string& name) {
    const int part = find_part(file, name);
    if (part < 0) throw Error(fmt::format("has no part \"{}\"", name));
    return part;
}

// The attribute is looked for in every part: a later version may name its parts otherwise.
void check_format(const Imf::MultiPartInputFile& file) {
    for (int i = 0; i < file.parts(); ++i) {
        const auto* format = file.header(i).findTypedAttribute<Imf::IntAttribute>(format_attribute);
        if (format == nullptr) continue;
        if (format->value() == volume_format) return;
        throw Error(fmt::format("is a probe volume of format {}, but this program reads format {}", format->value(),
                                volume_format),
                    {}, "Use the Lightgrid that wrote it, or bake it again with this one.");
    }
    throw Error("is an OpenEXR image but not a probe volume", {}, "Make a volume with level-bake.");
}

// Everything of the volume that the index part's header says.
Volume read_header(const Imf::Header& header) {
    Volume volume;
    volume.bands = attribute<Imf::IntAttribute>(header, bands_attribute);
    if (volume.bands < 1 || volume.bands > max_sh_bands) {
        throw Error(fmt::format("{} bands, but 1 to {} are possible", volume.bands, max_sh_bands), in_part(header));
    }
    const int size = attribute<Imf::IntAttribute>(header, brick_size_attribute);
    if (size != brick_size) {
        throw Error(fmt::format("bricks of {}^3 probes, but only {}^3 are read", size, brick_size), in_part(header));
    }
    const int grids = attribute<Imf::IntAttribute>(header, grids_attribute);
    for (int g = 0; g < grids; ++g) {  // ends at the first that is missing, whatever the number says
        const auto vector = [&](const char* what) {
            const Imath::V3d v = attribute<Imf::V3dAttribute>(header, grid_attribute(g, what).c_str());
            return glm::dvec3(v.x, v.y, v.z);
        };
        const Imath::V3i counts = attribute<Imf::V3iAttribute>(header, grid_attribute(g, "counts").c_str());
        volume.grids.push_back({vector("origin"), vector("spacing"), {counts.x, counts.y, counts.z}});
    }
    for (const std::string& setting : attribute<Imf::StringVectorAttribute>(header, settings_attribute)) {
        const std::size_t equals = setting.find('=');
        if (equals == std::string::npos || equals == 0) {
            throw Error(fmt::format("setting \"{}\" is not NAME=VALUE", setting), in_part(header));
        }
        volume.settings[setting.substr(0, equals)] = setting.substr(equals + 1);
    }
    return volume;
}

// The names of layers besides the combined one. Each has to have its part, so that a broken list cannot ask for much.
std::vector<Layer> list_layers(const Imf::MultiPartInputFile& file, const Imf::Header& index) {
    std::vector<Layer> layers;
    const Imf::StringVector names = attribute<Imf::StringVectorAttribute>(index, layers_attribute);
    if (names.empty() || names.front() != combined_layer) {
        throw Error(fmt::format("attribute \"{}\" does not begin with {}", layers_attribute, combined_layer),
                    in_part(index));
    }
    for (std::size_t i = 1; i < names.size(); ++i) {
        if (std::count(names.begin(), names.end(), names[i]) > 1) {
            throw Error(fmt::format("layer \"{}\" is listed twice", names[i]), in_part(index));
        }
        static_cast<void>(require_part(file, names[i]));
        layers.push_back({names[i], {}, 0});
    }
    return layers;
}

// The tiles that the index speaks of, checked against the size of the light's part. OpenEXR has read a table of that
// many offsets from the file by now, so that a size made up by a broken file does not get here.
Layout read_layout(const Imf::Header& index, const Imf::Header& light) {
    const Imath::Box2i& window = index.dataWindow();
    const Layout layout{window.max.x + 1, window.max.y + 1};
    const bool sane = window.min == Imath::V2i(0) && layout.columns <= std::numeric_limits<int>::max() / tile_width &&
                      layout.rows <= std::numeric_limits<int>::max() / tile_height;
    if (!sane || light.dataWindow() != layout.probes()) {
        throw Error(fmt::format("its size does not fit that of part \"{}\"", light.name()), in_part(index));
    }
    return layout;
}

Index read_index(Imf::MultiPartInputFile& file, int part, Layout layout, const Volume& volume) {
    Index index(layout.tiles(), volume);
    const Imf::FrameBuffer frame = index.frame(volume, layout.columns);
    for (auto slice = frame.begin(); slice != frame.end(); ++slice) {
        require_channel(file.header(part), slice.name(), slice.slice().type);
    }
    Imf::InputPart input(file, part);
    input.setFrameBuffer(frame);
    input.readPixels(0, layout.rows - 1);
    return index;
}

// How many tiles hold bricks, and how many rows of the list: the first ones, in that order.
struct UsedTiles {
    std::size_t bricks = 0;
    std::size_t rows = 0;
};
UsedTiles count_used(const Index& index) {
    UsedTiles tiles;
    for (std::size_t t = 0; t < index.flags.size(); ++t) {
        if ((index.flags[t] & Index::used) == 0) continue;
        const bool row = (index.flags[t] & Index::rows) != 0;
        if (t != tiles.bricks + tiles.rows || (!row && tiles.rows > 0)) {
            throw Error(
                fmt::format("tile {} is out of order: bricks come first, then the list, then what is unused", t),
                fmt::format("part \"{}\"", index_part));
        }
        ++(row ? tiles.rows : tiles.bricks);
    }
    return tiles;
}

void check_scales(const Scales& scales) {
    for (std::size_t t = 0; t < scales.size(); ++t) {
        if (std::isfinite(scales[t]) && scales[t] > 0) continue;
        throw Error(fmt::format("scale {} of tile {} is not positive and finite", scales[t], t),
                    fmt::format("part \"{}\"", index_part));
    }
}

std::vector<Brick> read_bricks(const Index& index, std::size_t count) {
    std::vector<Brick> bricks;
    for (std::size_t t = 0; t < count; ++t) {
        // What does not fit an int turns negative, which check_volume refuses.
        bricks.push_back({static_cast<int>(index.grid[t]),
                          {static_cast<int>(index.origin[0][t]), static_cast<int>(index.origin[1][t]),
                           static_cast<int>(index.origin[2][t])}});
    }
    return bricks;
}

// Fills the memory of `channels` for the first `slots` probes.
void read_tiles(Imf::MultiPartInputFile& file, int part, const std::vector<ProbeChannel>& channels, Layout layout,
                std::size_t slots, const Scales& scales = {}) {
    const Imf::Header& header = file.header(part);
    if (!header.hasTileDescription() || header.tileDescription().xSize != tile_width ||
        header.tileDescription().ySize != tile_height || header.tileDescription().mode != Imf::ONE_LEVEL) {
        throw Error(fmt::format("tiles of {} x {} pixels were expected", tile_width, tile_height), in_part(header));
    }
    if (header.dataWindow() != layout.probes()) throw Error("its size does not fit the index", in_part(header));
    for (const ProbeChannel& channel : channels) require_channel(header, channel.name, channel.type);

    Imf::TiledInputPart input(file, part);
    TileBuffer tile(channels, true);
    input.setFrameBuffer(tile.frame());
    for (std::size_t t = 0; t < tiles_for(slots); ++t) {
        input.readTile(static_cast<int>(t % layout.columns), static_cast<int>(t / layout.columns));
        const std::size_t first = t * probes_per_brick;
        const std::size_t count = std::min<std::size_t>(slots - first, probes_per_brick);
        for (std::size_t c = 0; c < channels.size(); ++c) {
            const ProbeChannel& channel = channels[c];
            const bool scaled = channel.type == Imf::HALF && !scales.empty();
            for (std::size_t p = 0; p < count; ++p) {
                char* target = channel.first + (first + p) * channel.stride;
                std::memcpy(target, tile.pixel(c, p), sizeof(std::uint32_t));
                if (!scaled) continue;
                float value = 0;
                std::memcpy(&value, target, sizeof value);
                value *= scales[t];
                std::memcpy(target, &value, sizeof value);
            }
        }
    }
}

bool stores_half(const Imf::Header& light) {
    for (const char* name : {"c0.R", "c0.Y"}) {
        const Imf::Channel* found = light.channels().findChannel(name);
        if (found != nullptr) return found->type == Imf::HALF;
    }
    return false;
}

Stored read_stored(const Imf::Header& header, int bands, const char* grey_channel) {
    const int stored = attribute<Imf::IntAttribute>(header, stored_bands_attribute);
    if (stored < 1 || stored > bands) {
        throw Error(fmt::format("{} bands are stored, but the volume has {}", stored, bands), in_part(header));
    }
    return {stored, header.channels().findChannel(grey_channel) != nullptr};
}

void spread_grey(std::vector<glm::vec3>& values) {
    for (glm::vec3& v : values) v = glm::vec3(v.r);
}

void read_list(Imf::MultiPartInputFile& file, std::size_t tiles, Volume& volume) {
    const int part = require_part(file, list_part);
    const int length = attribute<Imf::IntAttribute>(file.header(part), list_length_attribute);
    if (length < 1 || tiles_for(length) != tiles) {
        throw Error(fmt::format("{} probes do not fit {} tiles", length, tiles), in_part(file.header(part)));
    }
    volume.list.resize(length);
    read_tiles(file, part, position_channels(volume), layout_for(tiles), volume.list.size());
}

void read_validity(Imf::MultiPartInputFile& file, Layout layout, Volume& volume) {
    const int part = require_part(file, validity_part);
    const Imf::Header& header = file.header(part);
    std::vector<float> states(volume.slots());
    std::vector<ProbeChannel> channels;
    if (header.channels().findChannel("offset.x") != nullptr) {
        volume.offsets.resize(volume.slots());
        channels = offset_channels(volume);
    }
    channels.push_back({"state", Imf::HALF, reinterpret_cast<char*>(states.data()), sizeof(float)});
    read_tiles(file, part, channels, layout, volume.slots());
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        const float state = states[slot];
        if (!(state >= 0 && state <= static_cast<float>(ProbeState::missing)) || state != std::floor(state)) {
            throw Error(fmt::format("state {} of probe {} is unknown", state, slot), in_part(header));
        }
        volume.states[slot] = static_cast<ProbeState>(static_cast<int>(state));
    }
}

std::vector<glm::vec3> read_light(Imf::MultiPartInputFile& file, int part, Layout layout, const Scales& scales,
                                  const Volume& volume) {
    std::vector<glm::vec3> coefficients(volume.slots() * volume.sh_size(), glm::vec3(0));
    const Stored stored = read_stored(file.header(part), volume.bands, "c0.Y");
    read_tiles(file, part, light_channels(volume, stored, coefficients), layout, volume.slots(), scales);
    if (stored.grey) spread_grey(coefficients);
    return coefficients;
}

void read_errors(Imf::MultiPartInputFile& file, Layout layout, const Index& index, Volume& volume) {
    volume.errors.assign(volume.slots() * volume.sh_size(), glm::vec3(0));
    volume.axis_errors.assign(volume.slots() * axis_normals.size(), glm::vec3(0));
    const int part = find_part(file, error_part);
    if (part < 0) return;  // left out: nothing is uncertain
    const Stored stored = read_stored(file.header(part), volume.bands, "e0.Y");
    read_tiles(file, part, error_channels(volume, stored), layout, volume.slots(), index.error_scale);
    if (stored.grey) {
        spread_grey(volume.errors);
        spread_grey(volume.axis_errors);
    }
}

Volume decode(Imf::IStream& stream) {
    Imf::MultiPartInputFile file(stream, 0);
    check_format(file);
    const int index_number = require_part(file, index_part);
    const int light = require_part(file, combined_layer);
    Volume volume = read_header(file.header(index_number));
    volume.half = stores_half(file.header(light));
    volume.layers = list_layers(file, file.header(index_number));
    const Layout layout = read_layout(file.header(index_number), file.header(light));
    const Index index = read_index(file, index_number, layout, volume);
    check_scales(index.light_scale);
    check_scales(index.error_scale);
    for (const Scales& scales : index.layer_scales) check_scales(scales);
    const UsedTiles used = count_used(index);
    if (used.bricks + used.rows == 0) throw Error("holds no probes");
    volume.bricks = read_bricks(index, used.bricks);
    if (used.rows > 0) read_list(file, used.rows, volume);
    volume.states.resize(volume.list_start() + volume.list.size());
    read_validity(file, layout, volume);
    volume.coefficients = read_light(file, light, layout, index.light_scale, volume);
    read_errors(file, layout, index, volume);
    for (std::size_t i = 0; i < volume.layers.size(); ++i) {
        Layer& layer = volume.layers[i];
        const int part = require_part(file, layer.name);
        layer.noise = attribute<Imf::DoubleAttribute>(file.header(part), noise_attribute);
        layer.coefficients = read_light(file, part, layout, index.layer_scales[i], volume);
    }
    check_volume(volume);
    return volume;
}

}  // namespace
}  // namespace volume_file

Volume decode_volume(std::span<const std::byte> bytes, const std::string& name) {
    try {
        if (bytes.size() < 4 || !Imf::isImfMagic(reinterpret_cast<const char*>(bytes.data()))) {
            throw Error(bytes.empty() ? "is empty" : "is not an OpenEXR file", {},
                        "Give a volume that level-bake wrote (*.probes.exr).");
        }
        volume_file::check_attribute_sizes(bytes);
        volume_file::InputBytes stream(bytes, name);
        return volume_file::decode(stream);
    } catch (const Error& error) {
        throw error.inside(name);
    } catch (const std::bad_alloc&) {
        throw Error("needs more memory than there is", name, {}, Fault::work);
    } catch (const std::exception& error) {  // Iex::BaseExc, and what OpenEXR lets through on broken headers
        throw Error(fmt::format("is damaged: {}", error.what()), name, "Copy it again, or bake it again.");
    }
}

Volume load_volume(const std::filesystem::path& path) {
    const std::string bytes = read_whole_file(path);
    return decode_volume(std::as_bytes(std::span(bytes)), path.string());
}

}  // namespace lightgrid
