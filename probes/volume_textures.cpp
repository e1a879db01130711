#include "probes/volume_textures.h"

#include "core/error.h"
#include "core/sh.h"
#include "probes/half_storage.h"
#include "probes/known_cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <span>

namespace lightgrid {
namespace {

constexpr int largest_texels = texels_per_probe(max_texture_bands);
/// With a power of two, shaders find rows by shifting.
constexpr int index_width = 2048;
constexpr int tree_width = 2048;

TextureImage make_image(TexelFormat format, glm::ivec3 size) {
    TextureImage image{format, size, {}};
    image.texels.resize(texel_bytes(format) * size.x * size.y * size.z);
    return image;
}

template <typename T>
void put(TextureImage& image, std::size_t texel, const std::array<T, 4>& values) {
    assert(sizeof(values) == texel_bytes(image.format));
    std::memcpy(image.texels.data() + texel * sizeof(values), values.data(), sizeof(values));
}

using ProbeTexels = std::array<glm::vec4, largest_texels>;

/// In the order of texels_per_probe; the state is put last, in w.
ProbeTexels probe_texels(std::span<const glm::vec3> sh, int bands, float state) {
    ProbeTexels texels{};
    if (bands > 1) {
        const int per_channel = bands - 1;
        for (int i = 0; i < 4 * per_channel; ++i) {
            for (int c = 0; c < 3; ++c) texels[c * per_channel + i / 4][i % 4] = sh[i][c];
        }
    }
    const int last = texels_per_probe(bands) - 1;
    if (bands != 2) texels[last] = glm::vec4(sh[sh_size(bands) - 1], 0);
    texels[last].w = state;
    return texels;
}

/// scale  that numbers are divided by, 1 for float; the state, the last texel's w, is stored as it is
void put_probe_texel(TextureImage& image, std::size_t texel, glm::vec4 value, float scale, bool last) {
    if (image.format == TexelFormat::rgba32f) {
        put<float>(image, texel, {value.x, value.y, value.z, value.w});
    } else {
        put<std::uint16_t>(image, texel,
                           {to_half(value.x, scale), to_half(value.y, scale), to_half(value.z, scale),
                            to_half(value.w, last ? 1 : scale)});
    }
}

float state_number(ProbeState state) {
    return is_valid(state) ? 2 : state == ProbeState::filled ? 1 : 0;
}

int texture_bands(const Volume& volume, const TextureOptions& options) {
    assert(options.bands >= 1 && options.bands <= max_texture_bands);
    return std::min(volume.bands, options.bands);
}

glm::dvec3 texture_origin(const Volume& volume, const TextureOptions& options) {
    if (options.origin) return *options.origin;
    glm::dvec3 low = volume.grids.front().origin;
    glm::dvec3 high = low;
    for (const Grid& grid : volume.grids) {
        low = glm::min(low, grid.origin);
        high = glm::max(high, grid.position(grid.counts - 1));
    }
    return low + 0.5 * (high - low);
}

/// How many bricks an atlas holds along each axis: about a cube of texels, with few bricks of no use.
glm::ivec3 atlas_bricks(std::size_t count, int texels) {
    const int width = brick_size * texels;  // of a brick, in texels
    const double side = std::cbrt(static_cast<double>(count) * width * brick_size * brick_size);
    const auto share = [](std::size_t all, std::size_t part) { return static_cast<int>((all + part - 1) / part); };
    const int x = std::clamp(static_cast<int>(std::ceil(side / width)), 1, max_texture_size / width);
    const int most_y = std::clamp(static_cast<int>(std::ceil(side / brick_size)), 1, max_texture_size / brick_size);
    const int z = share(count, static_cast<std::size_t>(x) * most_y);
    const int y = share(count, static_cast<std::size_t>(x) * z);
    return {share(count, static_cast<std::size_t>(y) * z), y, z};
}

/// The largest coefficient of a brick may not be among the bands that are kept; what scales those is theirs alone.
float kept_scale(std::span<const glm::vec3> coefficients, std::size_t sh_size, std::size_t kept) {
    std::vector<glm::vec3> used;
    for (std::size_t i = 0; i < coefficients.size(); ++i) {
        if (i % sh_size < kept) used.push_back(coefficients[i]);
    }
    return half_scale(used);
}

/// row_of_grid  of each of the volume's grids in VolumeTextures::grids
TextureImage pack_tree(const Volume& volume, glm::dvec3 origin, std::span<const int> row_of_grid) {
    const KnownCells known = find_known_cells(volume, SlotTable(volume));
    const std::size_t texels = 2 * std::max<std::size_t>(known.nodes.size(), 1);
    const auto width = static_cast<int>(std::min<std::size_t>(texels, tree_width));
    TextureImage tree =
        make_image(TexelFormat::rgba32f, {width, static_cast<int>((texels + tree_width - 1) / tree_width), 1});
    for (std::size_t i = 0; i < known.nodes.size(); ++i) {
        const KnownCells::Node& node = known.nodes[i];
        const glm::vec3 low(node.low - origin);
        const glm::vec3 high(node.high - origin);
        const int link = node.link < 0 ? -1 - row_of_grid[static_cast<std::size_t>(-1 - node.link)] : node.link;
        put<float>(tree, 2 * i, {low.x, low.y, low.z, static_cast<float>(link)});
        put<float>(tree, 2 * i + 1, {high.x, high.y, high.z, 0});
    }
    return tree;
}

void check_has_cells(const Volume& volume) {
    if (!volume.has_cells()) {
        throw Error("a probe list has no cells to interpolate in", {}, "Bake a volume with a grid.");
    }
}

}  // namespace

VolumeTextures pack_volume(const Volume& volume, const TextureOptions& options) {
    check_has_cells(volume);
    VolumeTextures result;
    result.bands = texture_bands(volume, options);
    result.origin = texture_origin(volume, options);
    const int texels = texels_per_probe(result.bands);
    const TexelFormat format = options.half ? TexelFormat::rgba16f : TexelFormat::rgba32f;

    const glm::ivec3 bricks = atlas_bricks(volume.bricks.size(), texels);
    if (bricks.z > max_texture_size / brick_size) {
        throw Error(fmt::format("{} bricks, more than a texture of {} texels along each axis holds",
                                volume.bricks.size(), max_texture_size),
                    {}, "Use a wider spacing or fewer bands.");
    }
    result.atlas = make_image(format, bricks * glm::ivec3(brick_size * texels, brick_size, brick_size));

    const std::vector<std::size_t> order = finest_first(volume.grids);
    std::vector<std::size_t> first_of_grid(volume.grids.size());
    std::vector<int> row_of_grid(volume.grids.size());
    std::size_t lattice = 0;
    result.grids = make_image(TexelFormat::rgba32f, {3, static_cast<int>(order.size()), 1});
    for (std::size_t row = 0; row < order.size(); ++row) {
        const Grid& grid = volume.grids[order[row]];
        const glm::vec3 origin(grid.origin - result.origin);
        const glm::vec3 inverse(1.0 / grid.spacing);
        const glm::vec3 counts(grid.counts);
        const std::size_t index_row = lattice / index_width;
        put<float>(result.grids, 3 * row, {origin.x, origin.y, origin.z, static_cast<float>(lattice % index_width)});
        put<float>(result.grids, 3 * row + 1, {inverse.x, inverse.y, inverse.z, static_cast<float>(index_row)});
        put<float>(result.grids, 3 * row + 2, {counts.x, counts.y, counts.z, 0});
        first_of_grid[order[row]] = lattice;
        row_of_grid[order[row]] = static_cast<int>(row);
        const glm::ivec3 spanned = lattice_bricks(grid);
        lattice += static_cast<std::size_t>(spanned.x) * spanned.y * spanned.z;
    }
    result.index = make_image(TexelFormat::rgba16ui,
                              {index_width, static_cast<int>((lattice + index_width - 1) / index_width), 1});

    result.tree = pack_tree(volume, result.origin, row_of_grid);

    const std::size_t brick_coefficients = probes_per_brick * volume.sh_size();
    for (std::size_t b = 0; b < volume.bricks.size(); ++b) {
        const auto coefficients = std::span(volume.coefficients).subspan(b * brick_coefficients, brick_coefficients);
        const float scale = options.half ? kept_scale(coefficients, volume.sh_size(), sh_size(result.bands)) : 1.0F;
        const auto i = static_cast<int>(b);
        const glm::ivec3 place(i % bricks.x, i / bricks.x % bricks.y, i / (bricks.x * bricks.y));

        const Brick& brick = volume.bricks[b];
        const glm::ivec3 spanned = lattice_bricks(volume.grids[brick.grid]);
        const glm::ivec3 at = brick.origin / brick_size;
        const std::size_t entry =
            first_of_grid[brick.grid] + (static_cast<std::size_t>(at.z) * spanned.y + at.y) * spanned.x + at.x;
        put<std::uint16_t>(result.index, entry,
                           {static_cast<std::uint16_t>(place.x), static_cast<std::uint16_t>(place.y),
                            static_cast<std::uint16_t>(place.z), static_cast<std::uint16_t>(127 + std::ilogb(scale))});

        for (std::size_t p = 0; p < probes_per_brick; ++p) {
            const std::size_t slot = b * probes_per_brick + p;
            const ProbeTexels probe = probe_texels(volume.sh(slot), result.bands, state_number(volume.states[slot]));
            const glm::ivec3 texel = place * brick_size + probe_in_brick(p);
            const std::size_t row =
                static_cast<std::size_t>(texel.z) * result.atlas.size.y + static_cast<std::size_t>(texel.y);
            const std::size_t first = row * result.atlas.size.x + static_cast<std::size_t>(texel.x) * texels;
            for (int t = 0; t < texels; ++t) {
                put_probe_texel(result.atlas, first + t, probe[t], scale, t == texels - 1);
            }
        }
    }
    return result;
}

bool is_dense(const Volume& volume) {
    if (volume.grids.size() != 1) return false;
    const glm::ivec3 spanned = lattice_bricks(volume.grids.front());
    return volume.bricks.size() == static_cast<std::size_t>(spanned.x) * spanned.y * spanned.z;
}

FilteredTextures pack_filtered(const Volume& volume, const TextureOptions& options) {
    check_has_cells(volume);
    if (!is_dense(volume)) {
        throw Error(volume.grids.size() == 1
                        ? "not all bricks of the grid are stored, but hardware filtering needs a dense one"
                        : fmt::format("{} grids, but hardware filtering takes one", volume.grids.size()),
                    {}, "Use the exact form, or bake one grid.");
    }
    FilteredTextures result;
    result.bands = texture_bands(volume, options);
    result.origin = texture_origin(volume, options);
    const Grid& grid = volume.grids.front();
    const glm::dvec3 scale = 1.0 / (grid.spacing * glm::dvec3(grid.counts));
    result.scale = glm::vec3(scale);
    result.offset = glm::vec3((result.origin - grid.origin) * scale + 0.5 / glm::dvec3(grid.counts));

    const int texels = texels_per_probe(result.bands);
    const TexelFormat format = options.half ? TexelFormat::rgba16f : TexelFormat::rgba32f;
    if (options.half) result.gain = kept_scale(volume.coefficients, volume.sh_size(), sh_size(result.bands));
    for (int t = 0; t < texels; ++t) result.probes.push_back(make_image(format, grid.counts));
    for (std::size_t slot = 0; slot < volume.list_start(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        const float state = state_number(volume.states[slot]);
        const ProbeTexels probe = probe_texels(volume.sh(slot), result.bands, state / 2);
        const glm::ivec3 at = lattice_index(volume, slot);
        const std::size_t texel = (static_cast<std::size_t>(at.z) * grid.counts.y + at.y) * grid.counts.x + at.x;
        for (int t = 0; t < texels && state > 0; ++t) {
            put_probe_texel(result.probes[t], texel, probe[t], result.gain, t == texels - 1);
        }
    }
    return result;
}

}  // namespace lightgrid
