#include "core/error.h"
#include "core/whole_file.h"
#include "probes/half_storage.h"
#include "probes/volume_file.h"
#include "probes/volume_file_parts.h"

#include <Iex.h>
#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfIO.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfStringVectorAttribute.h>
#include <ImfTiledOutputPart.h>
#include <ImfVecAttribute.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace lightgrid {
namespace volume_file {
namespace {

class OutputBytes : public Imf::OStream {
  public:
    OutputBytes() : OStream("volume") {}

    void write(const char bytes[], int count) override {
        if (position_ + count > bytes_.size()) bytes_.resize(position_ + count);
        std::memcpy(bytes_.data() + position_, bytes, count);
        position_ += count;
    }
    std::uint64_t tellp() override { return position_; }
    void seekp(std::uint64_t position) override { position_ = position; }

    [[nodiscard]] std::string take() { return std::move(bytes_); }

  private:
    std::string bytes_;
    std::size_t position_ = 0;
};

// A tiled part: its header and where its numbers are, of the first `slots` probes of its tiles.
struct Part {
    Imf::Header header;
    Layout layout;
    std::size_t slots;
    std::vector<ProbeChannel> channels;
    Scales scales;
};

Imf::Header make_header(const std::string& name, const std::string& type, Layout all, const Imath::Box2i& data_window) {
    // The parts of a file have to share the display window.
    Imf::Header header(all.probes(), data_window, 1, {0, 0}, 1, Imf::INCREASING_Y, Imf::ZIP_COMPRESSION);
    header.zipCompressionLevel() = 6;  // whatever the process has as its default
    header.setName(name);
    header.setType(type);
    Imf::addChromaticities(header, Imf::Chromaticities());  // Rec.709
    return header;
}

// all  the layout of all probes: the display window, which the parts of a file share
Part make_part(const std::string& name, Layout all, std::size_t slots, std::vector<ProbeChannel> channels,
               Scales scales = {}) {
    const Layout layout = layout_for(tiles_for(slots));
    Imf::Header header = make_header(name, Imf::TILEDIMAGE, all, layout.probes());
    header.setTileDescription({tile_width, tile_height, Imf::ONE_LEVEL});
    for (const ProbeChannel& channel : channels) header.channels().insert(channel.name, Imf::Channel(channel.type));
    return {std::move(header), layout, slots, std::move(channels), std::move(scales)};
}

void write_tiles(Imf::MultiPartOutputFile& file, int number, const Part& part) {
    Imf::TiledOutputPart output(file, number);
    TileBuffer tile(part.channels, false);
    output.setFrameBuffer(tile.frame());
    for (std::size_t t = 0; t < part.layout.tiles(); ++t) {
        const std::size_t first = t * probes_per_brick;
        const std::size_t count = first < part.slots ? std::min<std::size_t>(part.slots - first, probes_per_brick) : 0;
        const float scale = part.scales.empty() ? 1.0F : part.scales[t];
        tile.clear();
        for (std::size_t c = 0; c < part.channels.size(); ++c) {
            const ProbeChannel& channel = part.channels[c];
            for (std::size_t p = 0; p < count; ++p) {
                const char* source = channel.first + (first + p) * channel.stride;
                if (channel.type == Imf::HALF) {
                    float value = 0;
                    std::memcpy(&value, source, sizeof value);
                    const std::uint16_t bits = to_half(value, scale);
                    std::memcpy(tile.pixel(c, p), &bits, sizeof bits);
                } else {
                    std::memcpy(tile.pixel(c, p), source, sizeof(std::uint32_t));
                }
            }
        }
        output.writeTile(static_cast<int>(t % part.layout.columns), static_cast<int>(t / part.layout.columns));
    }
}

Index make_index(const Volume& volume, Layout layout) {
    Index index(layout.tiles(), volume);
    const auto brick_of = [](const std::vector<glm::vec3>& values, std::size_t brick, std::size_t per_slot) {
        const std::size_t first = brick * probes_per_brick * per_slot;
        return std::span(values).subspan(first, std::min(values.size() - first, probes_per_brick * per_slot));
    };
    for (std::size_t t = 0; t < tiles_for(volume.slots()); ++t) {
        index.flags[t] = Index::used;
        if (t >= volume.bricks.size()) {
            index.flags[t] |= Index::rows;
        } else {
            index.grid[t] = volume.bricks[t].grid;
            for (int axis = 0; axis < 3; ++axis) index.origin[axis][t] = volume.bricks[t].origin[axis];
        }
        if (volume.half) {
            index.light_scale[t] = half_scale(brick_of(volume.coefficients, t, volume.sh_size()));
            for (std::size_t i = 0; i < volume.layers.size(); ++i) {
                index.layer_scales[i][t] = half_scale(brick_of(volume.layers[i].coefficients, t, volume.sh_size()));
            }
            index.error_scale[t] = half_scale(brick_of(volume.errors, t, volume.sh_size()),
                                              brick_of(volume.axis_errors, t, axis_normals.size()));
        }
    }
    return index;
}

Imf::Header make_index_header(const Volume& volume, Layout layout, const Imf::FrameBuffer& frame) {
    Imf::Header header = make_header(index_part, Imf::SCANLINEIMAGE, layout, layout.index());
    for (auto slice = frame.begin(); slice != frame.end(); ++slice) {
        header.channels().insert(slice.name(), Imf::Channel(slice.slice().type));
    }
    header.insert(format_attribute, Imf::IntAttribute(volume_format));
    header.insert(conventions_attribute, Imf::StringAttribute(std::string(volume_conventions)));
    header.insert(bands_attribute, Imf::IntAttribute(volume.bands));
    header.insert(brick_size_attribute, Imf::IntAttribute(brick_size));
    Imf::StringVector layers{combined_layer};
    for (const Layer& layer : volume.layers) layers.push_back(layer.name);
    header.insert(layers_attribute, Imf::StringVectorAttribute(layers));
    header.insert(grids_attribute, Imf::IntAttribute(static_cast<int>(volume.grids.size())));
    for (std::size_t g = 0; g < volume.grids.size(); ++g) {
        const Grid& grid = volume.grids[g];
        const auto to_imath = [](glm::dvec3 v) { return Imath::V3d(v.x, v.y, v.z); };
        header.insert(grid_attribute(g, "origin"), Imf::V3dAttribute(to_imath(grid.origin)));
        header.insert(grid_attribute(g, "spacing"), Imf::V3dAttribute(to_imath(grid.spacing)));
        header.insert(grid_attribute(g, "counts"), Imf::V3iAttribute({grid.counts.x, grid.counts.y, grid.counts.z}));
    }
    Imf::StringVector settings;
    for (const auto& [name, value] : volume.settings) settings.push_back(fmt::format("{}={}", name, value));
    header.insert(settings_attribute, Imf::StringVectorAttribute(settings));
    return header;
}

bool all_zero(std::span<const glm::vec3> values) {
    return std::all_of(values.begin(), values.end(), [](glm::vec3 v) { return v == glm::vec3(0); });
}

// The volume's own light, or that of a layer.
Part make_light_part(const std::string& name, std::vector<glm::vec3>& coefficients, const Volume& volume, Layout all,
                     const Scales& scales) {
    // A part needs a channel: at least one band, be it dark.
    const Stored stored{std::max(1, used_bands(coefficients, volume.bands)), is_grey(coefficients)};
    Part part = make_part(name, all, volume.slots(), light_channels(volume, stored, coefficients), scales);
    part.header.insert(stored_bands_attribute, Imf::IntAttribute(stored.bands));
    return part;
}

Part make_error_part(Volume& volume, Layout all, const Index& index) {
    const Stored stored{std::max(1, used_bands(volume.errors, volume.bands)),
                        is_grey(volume.errors) && is_grey(volume.axis_errors)};
    Part part = make_part(error_part, all, volume.slots(), error_channels(volume, stored), index.error_scale);
    part.header.insert(stored_bands_attribute, Imf::IntAttribute(stored.bands));
    return part;
}

Part make_validity_part(Volume& volume, Layout all, std::vector<float>& states) {
    for (const ProbeState state : volume.states) states.push_back(static_cast<float>(state));
    std::vector<ProbeChannel> channels;
    if (!all_zero(volume.offsets)) channels = offset_channels(volume);
    channels.push_back({"state", Imf::HALF, reinterpret_cast<char*>(states.data()), sizeof(float)});
    return make_part(validity_part, all, volume.slots(), std::move(channels));
}

// The exact positions, and floats beside them that stock tools can show.
Part make_list_part(Volume& volume, Layout all, std::vector<glm::vec3>& relative) {
    const glm::dvec3 origin = volume.list.front();
    for (const glm::dvec3& position : volume.list) relative.emplace_back(position - origin);
    std::vector<ProbeChannel> channels = position_channels(volume);
    for (int axis = 0; axis < 3; ++axis) {
        channels.push_back(
            {std::string(1, "xyz"[axis]), Imf::FLOAT, reinterpret_cast<char*>(&relative[0][axis]), sizeof(glm::vec3)});
    }
    Part part = make_part(list_part, all, volume.list.size(), std::move(channels));
    part.header.insert(list_length_attribute, Imf::IntAttribute(static_cast<int>(volume.list.size())));
    part.header.insert(list_origin_attribute, Imf::V3dAttribute({origin.x, origin.y, origin.z}));
    return part;
}

std::string encode(Volume& volume) {
    const Layout layout = layout_for(tiles_for(volume.slots()));
    Index index = make_index(volume, layout);
    const Imf::FrameBuffer index_frame = index.frame(volume, layout.columns);
    std::vector<float> states;
    std::vector<glm::vec3> relative;

    std::vector<Part> parts{make_light_part(combined_layer, volume.coefficients, volume, layout, index.light_scale)};
    if (!all_zero(volume.errors) || !all_zero(volume.axis_errors))
        parts.push_back(make_error_part(volume, layout, index));
    parts.push_back(make_validity_part(volume, layout, states));
    if (!volume.list.empty()) parts.push_back(make_list_part(volume, layout, relative));
    for (std::size_t i = 0; i < volume.layers.size(); ++i) {
        Layer& layer = volume.layers[i];
        parts.push_back(make_light_part(layer.name, layer.coefficients, volume, layout, index.layer_scales[i]));
        parts.back().header.insert(noise_attribute, Imf::DoubleAttribute(layer.noise));
    }

    std::vector<Imf::Header> headers;
    headers.reserve(parts.size() + 1);
    for (const Part& part : parts) headers.push_back(part.header);
    headers.push_back(make_index_header(volume, layout, index_frame));

    OutputBytes stream;
    {
        // No threads: the order of calls is the order of bytes.
        Imf::MultiPartOutputFile file(stream, headers.data(), static_cast<int>(headers.size()), false, 0);
        for (std::size_t i = 0; i < parts.size(); ++i) {
            write_tiles(file, static_cast<int>(i), parts[i]);
        }
        Imf::OutputPart output(file, static_cast<int>(parts.size()));
        output.setFrameBuffer(index_frame);
        output.writePixels(layout.rows);
    }  // here the tables of offsets are written
    return stream.take();
}

}  // namespace
}  // namespace volume_file

std::string encode_volume(const Volume& volume) {
    check_volume(volume);
    // OpenEXR's frame buffers point to writable memory, though writing a file only reads it.
    return volume_file::encode(const_cast<Volume&>(volume));
}

void save_volume(const Volume& volume, const std::filesystem::path& path) {
    try {
        write_whole_file(path, encode_volume(volume));
    } catch (const Iex::BaseExc& error) {
        throw Error(fmt::format("cannot be encoded: {}", error.what()), path.string(), {}, Fault::work);
    }
}

}  // namespace lightgrid
