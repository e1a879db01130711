#include "probes/surface_patches.h"

#include "core/sampling.h"

#include <algorithm>
#include <cmath>

namespace lightgrid {
namespace {

/// Shifts the lattice of cubes by this share of them, so that walls at round coordinates do not lie in their faces,
/// where rounding would deal out a surface among two cubes by chance.
constexpr float lattice_shift = 0.381966F;

/// Of a cube's width: how far off the surface patches look at their points. What stands lower does not cut a cube.
constexpr float lift = 0.125F;

/// Feelers end this far within the corners of a cube, so that rounding does not put them into the next.
constexpr float to_corner = 0.98F;

int dominant_axis(glm::vec3 v) {
    const glm::vec3 a = glm::abs(v);
    if (a.x >= a.y && a.x >= a.z) return 0;
    return a.y >= a.z ? 1 : 2;
}

/// floor() without a call, which it is on processors without SSE 4.1.
int whole(float x) {
    const int truncated = static_cast<int>(x);
    return truncated - (x < static_cast<float>(truncated) ? 1 : 0);
}

glm::ivec3 cube_of(glm::vec3 position, float inverse_width) {
    const glm::vec3 p = position * inverse_width + lattice_shift;
    return {whole(p.x), whole(p.y), whole(p.z)};
}

constexpr std::uint64_t word(std::uint32_t high, std::uint32_t low) {
    return std::uint64_t{high} << 32 | low;
}

bool sees(const Tracer& tracer, glm::vec3 from, glm::vec3 to) {
    return tracer.transmittance(from, to - from, 1) != glm::vec3(0);
}

}  // namespace

SurfaceSide::SurfaceSide(const Hit& hit, glm::vec3 origin, glm::vec3 direction)
    : id(hit.id),
      position(origin + hit.distance * direction),
      normal(glm::dot(hit.normal, direction) > 0 ? -hit.normal : hit.normal) {
    if (normal == glm::vec3(0)) normal = -direction;  // triangles without area face the ray, as in Tracer::surface
}

SurfacePatches::SurfacePatches(float width) : slots_(1024) {
    for (int level = 0; level < most_levels; ++level) {
        widths_[level] = std::ldexp(width, level);
        inverse_widths_[level] = 1 / widths_[level];
    }
}

std::uint64_t SurfacePatches::key_of(const SurfaceSide& side, int level) const noexcept {
    const auto cube = glm::uvec3(cube_of(side.position, inverse_widths_[level]));
    const int axis = dominant_axis(side.normal);
    const auto facing = static_cast<std::uint32_t>(2 * axis + (side.normal[axis] > 0 ? 1 : 0));
    // 64 mixed bits are as good as what they are made of: of a million keys two are the same in one level of 4e7.
    const std::uint64_t surface = word(side.id.instance, side.id.geometry);
    const std::uint64_t place = word(cube.z, static_cast<std::uint32_t>(level) * 6 + facing);
    return mix_bits(word(cube.x, cube.y), place * 0xd6e8feb86659fd93U + surface * 0xa0761d6478bd642fU);
}

std::size_t SurfacePatches::slot_of(std::uint64_t key) const noexcept {
    const std::size_t mask = slots_.size() - 1;
    const auto tag = static_cast<std::uint32_t>(key >> 32);
    std::size_t i = key & mask;
    while (slots_[i].first != 0 && slots_[i].tag != tag) i = (i + 1) & mask;
    return i;
}

void SurfacePatches::grow_table() {
    const std::vector<Slot> old = std::move(slots_);
    slots_.assign(4 * old.size(), {});
    for (const Slot& slot : old) {
        if (slot.first != 0) slots_[slot_of(patches_[slot.first - 1].key)] = slot;
    }
}

glm::vec3 SurfacePatches::lifted(const SurfaceSide& side, int level) const noexcept {
    return side.position + (lift * widths_[level]) * glm::normalize(side.normal);
}

/// Whether something hides a corner of the cube where the patch's own surface goes on. Every straight cut leaves a
/// corner on either side.
bool SurfacePatches::is_cut(const Tracer& tracer, const SurfaceSide& side, int level,
                            std::uint64_t& shadow_rays) const noexcept {
    const float width = widths_[level];
    const std::uint64_t key = key_of(side, level);
    const int axis = dominant_axis(side.normal);
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const glm::vec3 low = (glm::vec3(cube_of(side.position, inverse_widths_[level])) - lattice_shift) * width;
    const glm::vec3 anchor = lifted(side, level);
    for (int corner = 0; corner < 4; ++corner) {
        glm::vec3 along(0);
        along[u] = to_corner * (low[u] + ((corner & 1) != 0 ? width : 0) - side.position[u]);
        along[v] = to_corner * (low[v] + ((corner & 2) != 0 ? width : 0) - side.position[v]);
        along[axis] = -(side.normal[u] * along[u] + side.normal[v] * along[v]) / side.normal[axis];
        shadow_rays += 2;
        if (sees(tracer, anchor, anchor + along)) continue;
        const glm::vec3 down = 2.0F * (side.position - anchor);
        const Hit below = tracer.closest_hit(anchor + along, down, 1);
        if (below.found() && key_of(SurfaceSide(below, anchor + along, down), level) == key) return true;
    }
    return false;
}

std::uint32_t SurfacePatches::find(const Tracer& tracer, const SurfaceSide& side,
                                   std::uint64_t& shadow_rays) const noexcept {
    for (int level = 0; level < levels_; ++level) {
        const Slot slot = slots_[slot_of(key_of(side, level))];
        if (slot.first == 0) continue;
        if (slot.cut == 0) return slot.first - 1;
        const glm::vec3 place = lifted(side, level);
        for (std::uint32_t patch = slot.first - 1; patch != none; patch = patches_[patch].next) {
            ++shadow_rays;
            if (sees(tracer, place, patches_[patch].anchor)) return patch;
        }
    }
    return none;
}

std::vector<std::uint32_t> SurfacePatches::add(const Tracer& tracer, std::span<const SurfaceSide> sides, int level,
                                               std::uint64_t& shadow_rays) {
    std::vector<std::uint32_t> result;
    result.reserve(sides.size());
    levels_ = std::max(levels_, level + 1);
    for (const SurfaceSide& side : sides) {
        const std::uint64_t key = key_of(side, level);
        const glm::vec3 place = lifted(side, level);
        std::size_t slot = slot_of(key);
        if (slots_[slot].first == 0) {
            if (2 * ++used_slots_ > slots_.size()) {
                grow_table();
                slot = slot_of(key);
            }
            result.push_back(size());
            patches_.push_back({key, place, none});
            const bool cut = is_cut(tracer, side, level, shadow_rays);
            slots_[slot] = {static_cast<std::uint32_t>(key >> 32), size(), cut};
            cut_cubes_ += cut ? 1 : 0;
            continue;
        }
        std::uint32_t last = none;
        std::uint32_t patch = slots_[slot].first - 1;
        int count = 0;
        for (; patch != none; patch = patches_[patch].next) {
            ++shadow_rays;
            if (sees(tracer, place, patches_[patch].anchor)) break;
            last = patch;
            ++count;
        }
        if (patch == none) {
            cut_cubes_ += slots_[slot].cut != 0 ? 0 : 1;
            slots_[slot].cut = 1;
            if (count < most_patches_per_cube) {
                patch = size();
                patches_[last].next = patch;
                patches_.push_back({key, place, none});
            }
        }
        result.push_back(patch);
    }
    return result;
}

}  // namespace lightgrid
