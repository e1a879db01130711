#include "probes/placement.h"

#include "core/parallel.h"
#include "core/sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <span>

namespace lightgrid {
namespace {

constexpr std::uint32_t evidence_rays = 64;
/// Share of rays that may leave an enclosure through cracks.
constexpr float crack_share = 0.1F;
/// Of back faces, all and near ones: free space in real levels sees up to two thirds of them, rock nearly nothing else.
constexpr float inside_score = 0.85F;
/// Of back faces where it is pitch dark. Solids that stand in one another or on a floor of the same height show their
/// front faces too; in rooms without any light, there is little that these would be taken for.
constexpr float inside_score_in_the_dark = 1.0F / 3;
/// Of the usual light: a point with more is free, whatever it sees.
constexpr double lit_share = 0.05;
/// Asking for light is costly: a probe that finds no place with so many looks stays where it is.
constexpr int most_looks_for_light = 4;
/// Of the spacing: nearer to a surface than this, a probe is moved. Less lets probes into cracks that their cells do
/// not look like: with 0.01 one between a ceiling and the lamp below it doubles the error of a whole Cornell box.
constexpr float clearance_share = 0.1F;

/// Of the spacing: what keeps open points off surfaces, and off lights that have no size.
constexpr double open_clearance_share = 0.01;
constexpr double open_light_share = 0.1;

/// Of the cells of a probe on its grid's border, weighted as they are interpolated.
constexpr std::uint32_t space_points = 64;
/// Such a probe moves through a wall to see this many times as much of its cells.
constexpr float gain_worth_a_wall = 1.25F;
/// Of the most that is seen from anywhere near: a nearer place with as much will do.
constexpr float enough_seen = 0.75F;
constexpr std::size_t most_places = 8;
constexpr int steps_to_place = 8;

/// Of a step: a surface this near is one that the probe is on, and both of its sides are open to it.
constexpr float on_surface = 0.05F;

struct Sight {
    float distance;
    bool back;           // of a surface that is opaque there
    glm::vec3 to_plane;  // the shortest way to the plane of what was met
};

struct Surroundings {
    std::vector<Sight> hits;  // nearest first
    float escaped = 0;        // share of rays
};

Surroundings look_around(const Tracer& tracer, glm::vec3 point) {
    Surroundings seen;
    for (std::uint32_t i = 0; i < evidence_rays; ++i) {
        const glm::vec3 direction = sphere_direction(sobol_point(i, 0));
        const Hit hit = tracer.closest_hit(point, direction);
        if (!hit.found()) {
            seen.escaped += 1.0F / evidence_rays;
            continue;
        }
        const Surface surface = tracer.surface(hit, direction);
        // What lets light through bounds no solid; `doubleSided` says nothing, because exporters set it on everything.
        const SurfacePoint at = surface_at(tracer.scene(), *surface.mesh, hit.id.triangle, hit.barycentric);
        const bool back = !surface.front && passed_share(at) == glm::vec3(0);
        seen.hits.push_back({hit.distance, back, hit.distance * glm::dot(direction, surface.normal) * surface.normal});
    }
    std::sort(seen.hits.begin(), seen.hits.end(),
              [](const Sight& a, const Sight& b) { return a.distance < b.distance; });
    return seen;
}

/// What the surroundings say of a point; light has the last word on what is suspect.
enum class Suspicion : std::uint8_t {
    none,
    if_dark,  // inside where it gets no light at all
    strong,   // inside unless it is lit
};

/// Back faces as evidence: over all rays and over the nearest quarter of them.
Suspicion suspect(const Surroundings& seen, bool has_sky) {
    if (seen.hits.empty()) return has_sky ? Suspicion::none : Suspicion::strong;
    if (has_sky && seen.escaped > crack_share) return Suspicion::none;
    const auto back_faces = [&](std::size_t count) {
        const auto end = seen.hits.begin() + static_cast<std::ptrdiff_t>(count);
        return static_cast<float>(std::count_if(seen.hits.begin(), end, [](const Sight& s) { return s.back; }));
    };
    const std::size_t near = (seen.hits.size() + 3) / 4;
    const float all_share = back_faces(seen.hits.size()) / evidence_rays;
    const float near_share = back_faces(near) / static_cast<float>(near);
    // Without a sky, rays that leave see no more than back faces.
    if (0.5F * (all_share + seen.escaped + near_share) >= inside_score) return Suspicion::strong;
    const bool enclosed = seen.escaped <= crack_share;
    return enclosed && std::max(all_share, near_share) >= inside_score_in_the_dark ? Suspicion::if_dark
                                                                                   : Suspicion::none;
}

bool is_inside(glm::vec3 point, Suspicion suspicion, const LightEvidence& light) {
    if (suspicion == Suspicion::none) return false;
    if (!light.share) return suspicion == Suspicion::strong;
    const double share = light.share(point);
    return suspicion == Suspicion::strong ? share < lit_share : !(share > 0);
}

/// The same for the places where one probe may go: once it has asked for light so often, what is suspect is no place.
class PlacesOfOneProbe {
  public:
    explicit PlacesOfOneProbe(const LightEvidence& light) : light_(&light) {}

    [[nodiscard]] bool is_inside(glm::vec3 place, Suspicion suspicion) {
        if (suspicion != Suspicion::none && ++looks_for_light_ > most_looks_for_light) return true;
        return lightgrid::is_inside(place, suspicion, *light_);
    }

  private:
    const LightEvidence* light_;
    int looks_for_light_ = 0;
};

/// A surface within about `clearance`: seven lines through the point, so that no plane slips between them.
bool touches(const Tracer& tracer, glm::vec3 point, float clearance) {
    static constexpr std::array<glm::vec3, 7> lines = {{{1, 0, 0},
                                                        {0, 1, 0},
                                                        {0, 0, 1},
                                                        {0.58F, 0.58F, 0.58F},
                                                        {-0.58F, 0.58F, 0.58F},
                                                        {0.58F, -0.58F, 0.58F},
                                                        {0.58F, 0.58F, -0.58F}}};
    return std::any_of(lines.begin(), lines.end(), [&](glm::vec3 line) {
        return tracer.closest_hit(point - clearance * line, 2 * clearance * line, 1).found();
    });
}

/// Nothing is in the way but the surface of a solid that `from` may be inside of. What comes behind that, from whatever
/// side, is a wall.
bool reaches(const Tracer& tracer, glm::vec3 from, glm::vec3 to) {
    const glm::vec3 direction = to - from;
    const Hit hit = tracer.closest_hit(from, direction, 1);
    if (!hit.found()) return true;
    const Surface surface = tracer.surface(hit, direction);
    if (surface.front) return false;
    return !tracer.closest_hit(surface.leave(direction), direction, std::max(0.0F, 1 - hit.distance)).found();
}

/// A probe that has to move, and how far it may.
struct Stuck {
    glm::vec3 point{0};
    Surroundings seen;
    bool touching;  // too near to a surface: a step to any side may do
    bool inside;    // the ways out are those to the planes whose back faces it sees
    float clearance;
    glm::vec3 reach{0};  // the most along each axis
    Box limits;
};

/// The least offset that frees the probe, or none.
std::optional<glm::vec3> freeing_offset(const Tracer& tracer, const Stuck& probe, const LightEvidence& light) {
    const float step = 2 * probe.clearance;
    std::vector<glm::vec3> candidates;
    for (const Sight& sight : probe.seen.hits) {
        const float height = glm::length(sight.to_plane);
        if (probe.inside && sight.back && height > 0) candidates.push_back(sight.to_plane * ((height + step) / height));
    }
    for (int i = 0; probe.touching && i < 27; ++i) {
        if (i != 13) candidates.push_back(step * glm::vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
    }
    for (std::uint32_t i = 0; probe.touching && i < evidence_rays; ++i) {
        candidates.push_back(2 * step * sphere_direction(sobol_point(i, 0)));
    }
    std::erase_if(candidates, [&](glm::vec3 offset) {
        const glm::dvec3 place = glm::dvec3(probe.point) + glm::dvec3(offset);
        return glm::any(glm::greaterThan(glm::abs(offset), probe.reach)) ||
               glm::any(glm::lessThan(place, probe.limits.min)) || glm::any(glm::greaterThan(place, probe.limits.max));
    });
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](glm::vec3 a, glm::vec3 b) { return glm::dot(a, a) < glm::dot(b, b); });
    const auto same = std::unique(candidates.begin(), candidates.end(), [&](glm::vec3 a, glm::vec3 b) {
        return glm::distance(a, b) < 0.1F * probe.clearance;  // seen on the same plane
    });
    candidates.erase(same, candidates.end());
    PlacesOfOneProbe places(light);
    const auto is_free_at = [&](glm::vec3 place) {
        const Suspicion suspicion = suspect(look_around(tracer, place), light.has_sky);
        if (suspicion == Suspicion::strong && probe.inside) return false;
        return !places.is_inside(place, suspicion);
    };
    const auto found = std::find_if(candidates.begin(), candidates.end(), [&](glm::vec3 offset) {
        const glm::vec3 start = probe.point + on_surface * offset;
        const glm::vec3 place = probe.point + offset;
        const bool open =
            probe.inside ? reaches(tracer, start, place) : !tracer.closest_hit(start, place - start, 1).found();
        return open && !touches(tracer, place, probe.clearance) && is_free_at(place);
    });
    return found == candidates.end() ? std::nullopt : std::optional(*found);
}

/// Points in the cells around a probe that are inside its box, as dense as its weight there: a tent along each axis,
/// half of one on a border. Empty for a probe in the lattice's inside.
std::vector<glm::vec3> space_of_border_probe(const Stuck& probe) {
    const glm::vec3 cell = 2.0F * probe.reach;
    const auto below = glm::greaterThan(probe.point - probe.reach, glm::vec3(probe.limits.min));
    const auto above = glm::lessThan(probe.point + probe.reach, glm::vec3(probe.limits.max));
    if (glm::all(below) && glm::all(above)) return {};
    std::vector<glm::vec3> space(space_points, probe.point);
    for (std::uint32_t i = 0; i < space_points; ++i) {
        const glm::vec3 u(sobol_point(i, 0), (static_cast<float>(i) + 0.5F) / space_points);
        for (int axis = 0; axis < 3; ++axis) {
            const bool both = below[axis] && above[axis];
            const float toward = both ? std::abs(2 * u[axis] - 1) : u[axis];
            const bool down = both ? u[axis] < 0.5F : below[axis];
            space[i][axis] += (down ? -1.0F : 1.0F) * (1 - std::sqrt(toward)) * cell[axis];
        }
    }
    return space;
}

/// For a probe that, moved by `current`, is walled off from most of the points of `space`, as all behind a level's outer
/// wall are: the least offset towards a place that sees much more of them, or none.
std::optional<glm::vec3> offset_into_view(const Tracer& tracer, const Stuck& probe, glm::vec3 current,
                                          std::span<const glm::vec3> space, const LightEvidence& light) {
    const auto seen_from = [&](glm::vec3 place) {
        return static_cast<float>(std::count_if(space.begin(), space.end(), [&](glm::vec3 point) {
            return !tracer.closest_hit(place, point - place, 1).found();
        }));
    };
    const float seen = seen_from(probe.point + current);
    if (2 * seen >= static_cast<float>(space.size())) return {};

    struct Place {
        glm::vec3 offset;
        float seen;
    };
    std::vector<Place> places;
    for (const glm::vec3 point : space_of_border_probe(probe)) {
        const glm::vec3 offset = point - probe.point;
        if (glm::all(glm::lessThanEqual(glm::abs(offset), probe.reach))) places.push_back({offset, 0});
    }
    std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
        return glm::dot(a.offset, a.offset) > glm::dot(b.offset, b.offset);
    });
    places.resize(std::min(places.size(), most_places));  // the farthest in
    float most = 0;
    for (Place& place : places) {
        place.seen = seen_from(probe.point + place.offset);
        most = std::max(most, place.seen);
    }
    if (most < gain_worth_a_wall * seen || most == 0) return {};
    PlacesOfOneProbe looked_at(light);
    const auto is_free_at = [&](glm::vec3 place) {
        return !touches(tracer, place, probe.clearance) &&
               !looked_at.is_inside(place, suspect(look_around(tracer, place), light.has_sky));
    };
    for (const Place& place : places) {
        if (place.seen < enough_seen * most) continue;
        for (int step = 1; step <= steps_to_place; ++step) {
            const glm::vec3 offset = place.offset * (static_cast<float>(step) / steps_to_place);
            const glm::vec3 there = probe.point + offset;
            if (seen_from(there) >= enough_seen * most && is_free_at(there)) return offset;
        }
    }
    return {};
}

/// The slots that hold a grid's probes, and who is beside whom.
class Lattice {
  public:
    Lattice(const Volume& volume, const SlotTable& table, std::size_t grid)
        : volume_(&volume), table_(&table), grid_(grid) {}

    [[nodiscard]] const Grid& grid() const { return volume_->grids[grid_]; }
    /// In the order of the volume's bricks.
    [[nodiscard]] std::vector<std::size_t> slots() const {
        std::vector<std::size_t> slots;
        for (std::size_t slot = 0; slot < volume_->list_start(); ++slot) {
            const bool here = static_cast<std::size_t>(volume_->bricks[slot / probes_per_brick].grid) == grid_;
            if (here && volume_->states[slot] != ProbeState::absent) slots.push_back(slot);
        }
        return slots;
    }
    /// All that share a cell with the probe in `slot`, and are stored.
    [[nodiscard]] std::vector<std::size_t> neighbours(std::size_t slot) const {
        std::vector<std::size_t> found;
        const glm::ivec3 probe = lattice_index(*volume_, slot);
        for (int k = 0; k < 27; ++k) {
            const glm::ivec3 other = probe + glm::ivec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
            const bool inside =
                glm::all(glm::greaterThanEqual(other, glm::ivec3(0))) && glm::all(glm::lessThan(other, grid().counts));
            const std::ptrdiff_t at = k != 13 && inside ? table_->slot(grid_, other) : SlotTable::none;
            if (at != SlotTable::none) found.push_back(static_cast<std::size_t>(at));
        }
        return found;
    }

  private:
    const Volume* volume_;
    const SlotTable* table_;
    std::size_t grid_;
};

/// A probe on a face of its grid's box, and all that it shares a cell with.
struct BorderProbe {
    std::size_t slot;
    std::vector<std::size_t> neighbours;
};

std::vector<BorderProbe> border_probes(const Volume& volume) {
    std::vector<BorderProbe> border;
    const SlotTable table(volume);
    for (std::size_t g = 0; g < volume.grids.size(); ++g) {
        const Lattice lattice(volume, table, g);
        for (const std::size_t slot : lattice.slots()) {
            const glm::ivec3 probe = lattice_index(volume, slot);
            if (glm::any(glm::equal(probe, glm::ivec3(0))) || glm::any(glm::equal(probe, lattice.grid().counts - 1))) {
                border.push_back({slot, lattice.neighbours(slot)});
            }
        }
    }
    return border;
}

/// A filling of one probe, computed from the volume as it is and applied later, so that order does not matter.
struct Filling {
    std::size_t slot;
    std::vector<glm::vec3> coefficients, errors, axis_errors;
    std::vector<std::vector<glm::vec3>> layers;
};

std::optional<Filling> fill_from_neighbours(const Volume& volume, const Tracer& tracer, const Lattice& lattice,
                                            std::size_t slot, const std::vector<bool>& has_light, bool through_walls) {
    const glm::dvec3 origin = tracer.scene().origin;
    const glm::vec3 place(lattice_position(volume, slot) - origin);
    const glm::dvec3 last = lattice.grid().position(lattice.grid().counts - 1);
    const auto n = static_cast<std::size_t>(volume.bands) * volume.bands;
    Filling filling{slot, std::vector<glm::vec3>(n), std::vector<glm::vec3>(n), std::vector<glm::vec3>(6), {}};
    filling.layers.assign(volume.layers.size(), std::vector<glm::vec3>(n));
    float weight_sum = 0;
    for (const std::size_t from : lattice.neighbours(slot)) {
        if (!has_light[from]) continue;
        const glm::dvec3 gathered_at = gather_position(volume, from);
        const glm::vec3 neighbour(gathered_at - origin);
        // What was moved out of the box is on the far side of what bounds the level.
        const bool beyond = glm::any(glm::lessThan(gathered_at, lattice.grid().origin)) ||
                            glm::any(glm::greaterThan(gathered_at, last));
        if (!through_walls && (beyond || !reaches(tracer, place, neighbour))) continue;
        const float weight = 1 / glm::dot(neighbour - place, neighbour - place);
        weight_sum += weight;
        for (std::size_t i = 0; i < n; ++i) {
            filling.coefficients[i] += weight * volume.coefficients[from * n + i];
            filling.errors[i] += weight * volume.errors[from * n + i];
        }
        for (std::size_t i = 0; i < 6; ++i) filling.axis_errors[i] += weight * volume.axis_errors[from * 6 + i];
        for (std::size_t k = 0; k < filling.layers.size(); ++k) {
            const std::vector<glm::vec3>& coefficients = volume.layers[k].coefficients;
            for (std::size_t i = 0; i < n; ++i) filling.layers[k][i] += weight * coefficients[from * n + i];
        }
    }
    if (weight_sum == 0) return {};
    for (auto* values : {&filling.coefficients, &filling.errors, &filling.axis_errors}) {
        for (glm::vec3& value : *values) value /= weight_sum;
    }
    for (std::vector<glm::vec3>& values : filling.layers) {
        for (glm::vec3& value : values) value /= weight_sum;
    }
    return filling;
}

void apply(Volume& volume, const Filling& filling) {
    const auto n = static_cast<std::ptrdiff_t>(filling.coefficients.size());
    const auto slot = static_cast<std::ptrdiff_t>(filling.slot);
    std::copy(filling.coefficients.begin(), filling.coefficients.end(), volume.coefficients.begin() + slot * n);
    std::copy(filling.errors.begin(), filling.errors.end(), volume.errors.begin() + slot * n);
    std::copy(filling.axis_errors.begin(), filling.axis_errors.end(), volume.axis_errors.begin() + slot * 6);
    for (std::size_t k = 0; k < filling.layers.size(); ++k) {
        std::copy(filling.layers[k].begin(), filling.layers[k].end(), volume.layers[k].coefficients.begin() + slot * n);
    }
    volume.states[filling.slot] = ProbeState::filled;
}

}  // namespace

bool is_free(const Tracer& tracer, glm::vec3 point, float clearance, const LightEvidence& light) {
    if (touches(tracer, point, clearance)) return false;
    return !is_inside(point, suspect(look_around(tracer, point), light.has_sky), light);
}

bool is_at_light(const Tracer& tracer, glm::vec3 point, double spacing) {
    const auto near = static_cast<float>(open_light_share * spacing);
    const std::vector<Light>& lights = tracer.scene().lights;
    return std::any_of(lights.begin(), lights.end(), [&](const Light& light) {
        return light.kind != LightKind::directional && glm::distance(light.position, point) < near;
    });
}

bool is_open(const Tracer& tracer, glm::vec3 point, double spacing, const LightEvidence& light) {
    return !is_at_light(tracer, point, spacing) &&
           is_free(tracer, point, static_cast<float>(open_clearance_share * spacing), light);
}

PlacementCounts place_probes(Volume& volume, const Tracer& tracer, const LightEvidence& light,
                             const std::function<void(std::size_t)>& done) {
    const glm::dvec3 origin = tracer.scene().origin;
    std::vector<glm::vec3> offsets(volume.slots(), glm::vec3(0));
    const auto examine = [&](std::size_t slot) {
        Stuck probe;
        probe.point = glm::vec3(lattice_position(volume, slot) - origin);
        probe.seen = look_around(tracer, probe.point);
        probe.inside = is_inside(probe.point, suspect(probe.seen, light.has_sky), light);
        if (slot >= volume.list_start()) return probe;
        const Grid& grid = volume.grids[volume.bricks[slot / probes_per_brick].grid];
        probe.reach = glm::vec3(0.5 * grid.spacing);
        probe.clearance =
            clearance_share * static_cast<float>(std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z}));
        probe.limits = {grid.origin - origin, grid.position(grid.counts - 1) - origin};
        probe.touching = touches(tracer, probe.point, probe.clearance);
        return probe;
    };
    const auto settle = [&](std::size_t slot, std::optional<glm::vec3> offset) {
        volume.states[slot] = offset ? ProbeState::moved : ProbeState::missing;
        offsets[slot] = offset.value_or(glm::vec3(0));
    };
    std::mutex mutex;
    std::size_t looked_at = 0;
    const auto tell = [&](std::size_t more) {
        if (!done) return;
        const std::lock_guard lock(mutex);
        looked_at += more;
        done(looked_at);
    };

    for_each_index(volume.slots(), [&](std::size_t slot) {
        tell(1);
        if (volume.states[slot] == ProbeState::absent) return;
        const Stuck probe = examine(slot);
        volume.states[slot] = probe.inside ? ProbeState::missing : ProbeState::valid;
        const bool is_listed = slot >= volume.list_start();
        if (!is_listed && (probe.inside || probe.touching)) settle(slot, freeing_offset(tracer, probe, light));
    });

    const std::vector<BorderProbe> border = border_probes(volume);
    const auto is_valid_slot = [&](std::size_t slot) { return is_valid(volume.states[slot]); };
    std::vector<std::size_t> alone;
    for (const auto& [slot, neighbours] : border) {
        if (!is_valid_slot(slot) && std::none_of(neighbours.begin(), neighbours.end(), is_valid_slot)) {
            alone.push_back(slot);
        }
    }
    for_each_index(alone.size(), [&](std::size_t i) {
        tell(0);
        Stuck probe = examine(alone[i]);
        const glm::dvec3 cell(2.0F * probe.reach);
        probe.limits = {probe.limits.min - cell, probe.limits.max + cell};
        settle(alone[i], freeing_offset(tracer, probe, light));
    });
    // Through the outer wall: those on faces by what there is in their cells, then those on edges and in corners, which
    // have more of their cells outside, after their neighbours.
    for (int round = 0; round < 3; ++round) {
        std::vector<std::optional<glm::vec3>> moves(border.size());
        for_each_index(border.size(), [&](std::size_t i) {
            tell(0);
            const auto& [slot, neighbours] = border[i];
            if (!is_valid_slot(slot)) return;
            const Stuck probe = examine(slot);
            if (probe.inside || probe.seen.hits.empty()) return;
            if (probe.seen.hits.front().distance > glm::length(probe.reach)) return;
            std::vector<glm::vec3> space;
            if (round == 0) space = space_of_border_probe(probe);
            for (const std::size_t other : neighbours) {
                if (round == 0 || !is_valid_slot(other)) continue;
                space.push_back(glm::vec3(lattice_position(volume, other) - origin) + offsets[other]);
            }
            moves[i] = offset_into_view(tracer, probe, offsets[slot], space, light);
        });
        for (std::size_t i = 0; i < border.size(); ++i) {
            if (moves[i]) settle(border[i].slot, moves[i]);
        }
    }

    PlacementCounts counts;
    for (const ProbeState state : volume.states) {
        counts.valid += state == ProbeState::valid ? 1 : 0;
        counts.moved += state == ProbeState::moved ? 1 : 0;
        counts.invalid += state == ProbeState::missing ? 1 : 0;
    }
    counts.rays = (counts.valid + counts.moved + counts.invalid) * evidence_rays;
    if (counts.moved > 0) volume.offsets = std::move(offsets);
    return counts;
}

std::size_t fill_invalid(Volume& volume, const Tracer& tracer) {
    std::size_t filled = 0;
    std::vector<bool> has_light(volume.slots());
    for (std::size_t i = 0; i < volume.slots(); ++i) has_light[i] = is_valid(volume.states[i]);
    const SlotTable table(volume);
    for (std::size_t grid = 0; grid < volume.grids.size(); ++grid) {
        const Lattice lattice(volume, table, grid);
        std::vector<std::size_t> empty = lattice.slots();
        std::erase_if(empty, [&](std::size_t slot) { return has_light[slot]; });
        // Ring by ring along free segments; where that stops, one ring through walls, and on.
        bool through_walls = false;
        while (!empty.empty()) {
            std::vector<std::optional<Filling>> fillings(empty.size());
            for_each_index(empty.size(), [&](std::size_t i) {
                fillings[i] = fill_from_neighbours(volume, tracer, lattice, empty[i], has_light, through_walls);
            });
            std::vector<std::size_t> still_empty;
            for (std::size_t i = 0; i < empty.size(); ++i) {
                if (!fillings[i]) {
                    still_empty.push_back(empty[i]);
                    continue;
                }
                apply(volume, *fillings[i]);
                has_light[fillings[i]->slot] = true;
                ++filled;
            }
            const bool progress = still_empty.size() < empty.size();
            empty = std::move(still_empty);
            if (!progress && through_walls) break;
            through_walls = !progress;
        }
    }
    return filled;
}

}  // namespace lightgrid
