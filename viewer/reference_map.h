#pragma once

#include "probes/gather.h"
#include "viewer/look_up.h"

#include <glm/glm.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

/// The path tracer's light at places all over a level's surfaces, to be compared with what a volume says there.
namespace lightgrid {

/// A place on a surface, and what is known of the light there.
struct MapPlace {
    glm::vec3 position{0};      // relative to Scene::origin, off the surface
    glm::vec3 normal{0, 1, 0};  // of the side
    Estimate irradiance{};      // lux, integrated with the cosine; replicates
    float apart = 0;            // from the nearest place before it, facing included, metres
    std::uint32_t samples = 0;  // gather rays; 0: not traced yet
};

struct ReferenceMap {
    std::vector<MapPlace> places;  // so ordered that the first of them, however many, are spread over the level
    std::size_t traced = 0;        // the first so many have been
    bool last = false;             // no better one will follow
};

inline constexpr std::size_t map_places = 1024;

/// Places where rays from valid probes meet surfaces, on the side that they meet, whatever the winding; the farthest from
/// all before it, and facing most elsewhere, next. Fewer where fewer are met. Probes without ground below see what nobody
/// does, and count only where no probe has any. The same for the same level, volume and seed.
[[nodiscard]] std::vector<MapPlace> choose_map_places(const Tracer& tracer, const Volume& volume, std::size_t count,
                                                      std::uint64_t seed = 0);

/// Traces all places with 2,048 rays each, and those that are not known to 2 % then with 16,384.
///
/// tell   called with the map when more of it is known: after 64, 128, 256 ... places, and when all is done
/// check  called now and then; what it throws ends the work and comes out
void trace_map(const PathTracer& paths, ReferenceMap map, const std::function<void(const ReferenceMap&)>& tell,
               const std::function<void()>& check = {});

/// By how much a volume is off at a place: the difference of luminances over that of the reference, or over 5 % of the
/// volume's usual light where that is more. Negative where the reference is not known well enough to tell: its standard
/// error is above 2 %, and above a quarter of the difference.
[[nodiscard]] float difference_at(const MapPlace& place, glm::dvec3 origin, const LookUp& volume);
/// The same for all places of a map.
[[nodiscard]] std::vector<float> differences_of(const ReferenceMap& map, glm::dvec3 origin, const LookUp& volume);

/// The places with the largest known differences, the largest first, none of them within `apart` of another.
[[nodiscard]] std::vector<std::size_t> worst_places(const ReferenceMap& map, std::span<const float> differences,
                                                    double apart, std::size_t most);

/// The place that stands for a point of a surface: the nearest one, if it faces much the same way and is not much farther
/// than the places are from each other.
///
/// size  of the level, metres: a right angle counts as a twentieth of it
[[nodiscard]] std::optional<std::size_t> nearest_place(std::span<const MapPlace> places, glm::vec3 position,
                                                       glm::vec3 normal, float size);

}  // namespace lightgrid
