#include "viewer/reference_map.h"

#include "core/parallel.h"
#include "core/sampling.h"
#include "tools/ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace lightgrid {
namespace {

constexpr std::size_t candidates_per_place = 8;
constexpr float turn_in_sizes = 0.05F;     // what a right angle counts as, of the level's size
constexpr float reach_of_a_place = 2.5F;   // of what the places are apart
constexpr float much_the_same_way = 0.5F;  // cosine of 60 degrees
constexpr std::size_t block = 64;          // places that are traced together
constexpr std::uint32_t replicates = 16;
constexpr std::uint32_t first_samples = 2048;
constexpr std::uint32_t more_samples = 16384;
constexpr float good_enough = 0.02F;       // standard error, of the irradiance
constexpr float of_difference = 0.25F;     // or of the difference that it is to tell
constexpr float darkest_of_usual = 0.05F;  // light below this share of the usual is compared as if it were that

/// Squared metres between places of a level of this size, facing other ways included.
float apartness(const MapPlace& a, glm::vec3 position, glm::vec3 normal, float size) {
    const glm::vec3 way = a.position - position;
    const float turn = turn_in_sizes * size * (1 - glm::dot(a.normal, normal));
    return glm::dot(way, way) + turn * turn;
}

float size_of(const Tracer& tracer) {
    return static_cast<float>(glm::length(tracer.scene().bounds.size()));
}

/// Valid probes with ground below them; all valid ones where none has.
std::vector<glm::vec3> where_people_are(const Tracer& tracer, const Volume& volume) {
    std::vector<glm::vec3> valid;
    for (std::size_t slot = 0; slot < volume.list_start(); ++slot) {
        if (is_valid(volume.states[slot])) valid.emplace_back(gather_position(volume, slot) - tracer.scene().origin);
    }
    std::vector<char> has_ground(valid.size());
    for_each_index(valid.size(), [&](std::size_t i) { has_ground[i] = height_above_ground(tracer, valid[i]) ? 1 : 0; });
    std::vector<glm::vec3> above;
    for (std::size_t i = 0; i < valid.size(); ++i) {
        if (has_ground[i] != 0) above.push_back(valid[i]);
    }
    return above.empty() ? valid : above;
}

std::vector<MapPlace> candidates(const Tracer& tracer, const Volume& volume, std::size_t count, std::uint64_t seed) {
    const std::vector<glm::vec3> eyes = where_people_are(tracer, volume);
    std::vector<MapPlace> found;
    if (eyes.empty()) return found;
    RandomStream random(seed);
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 from = eyes[static_cast<std::size_t>(random.next_double() * static_cast<double>(eyes.size()))];
        const glm::vec3 direction = sphere_direction(random.next2());
        const Hit hit = tracer.closest_hit(from, direction);
        if (!hit.found()) continue;
        const Surface surface = tracer.surface(hit, direction);
        const glm::vec3 normal = surface.front ? surface.normal : -surface.normal;
        found.push_back({surface.leave(normal), normal});
    }
    return found;
}

float relative_error(const MapPlace& place) {
    const float light = luminance(glm::vec3(place.irradiance.mean));
    return light > 0 ? luminance(glm::vec3(place.irradiance.error)) / light : 0.0F;
}

/// Light of all these places anew.
void trace(const PathTracer& paths, std::vector<MapPlace>& places, std::span<const std::size_t> which,
           std::uint32_t samples, std::uint64_t seed, const std::function<void()>& check) {
    GatherOptions options;
    options.bands = 1;
    options.replicates = replicates;
    options.samples = samples;
    options.seed = seed;
    options.one_normal_each = true;
    std::vector<glm::vec3> points;
    for (const std::size_t i : which) {
        points.push_back(places[i].position);
        options.normals.push_back(places[i].normal);
    }
    GatherSums sums(paths, std::move(points), options);
    sums.add_replicates(replicates, [&](std::size_t) {
        if (check) check();
    });
    const Gather gathered = sums.result();
    for (std::size_t k = 0; k < which.size(); ++k) {
        places[which[k]].irradiance = gathered.irradiance[k];
        places[which[k]].samples = samples;
    }
}

}  // namespace

std::vector<MapPlace> choose_map_places(const Tracer& tracer, const Volume& volume, std::size_t count,
                                        std::uint64_t seed) {
    std::vector<MapPlace> pool = candidates(tracer, volume, candidates_per_place * count, seed);
    std::vector<MapPlace> places;
    const float size = size_of(tracer);
    std::vector<float> apart(pool.size(), std::numeric_limits<float>::infinity());
    std::size_t next = 0;
    while (!pool.empty() && places.size() < std::min(count, pool.size())) {
        places.push_back(pool[next]);
        places.back().apart = std::sqrt(apart[next]);
        for_each_index(pool.size(), [&](std::size_t i) {
            apart[i] = std::min(apart[i], apartness(pool[i], places.back().position, places.back().normal, size));
        });
        next = static_cast<std::size_t>(std::max_element(apart.begin(), apart.end()) - apart.begin());
        if (!(apart[next] > 0)) break;
    }
    return places;
}

void trace_map(const PathTracer& paths, ReferenceMap map, const std::function<void(const ReferenceMap&)>& tell,
               const std::function<void()>& check) {
    std::size_t told = block;
    while (map.traced < map.places.size()) {
        std::vector<std::size_t> which(std::min(block, map.places.size() - map.traced));
        std::iota(which.begin(), which.end(), map.traced);
        trace(paths, map.places, which, first_samples, mix_bits(map.traced, first_samples), check);
        map.traced += which.size();
        if (map.traced < told) continue;
        tell(map);
        told *= 2;
    }
    std::vector<std::size_t> unsure;
    for (std::size_t i = 0; i < map.places.size(); ++i) {
        if (relative_error(map.places[i]) > good_enough) unsure.push_back(i);
    }
    for (std::size_t first = 0; first < unsure.size(); first += block) {
        const std::span which = std::span(unsure).subspan(first, std::min(block, unsure.size() - first));
        trace(paths, map.places, which, more_samples, mix_bits(first, more_samples), check);
    }
    map.last = true;
    tell(map);
}

float difference_at(const MapPlace& place, glm::dvec3 origin, const LookUp& volume) {
    if (place.samples == 0 || volume.volume == nullptr) return -1;
    const float reference = luminance(glm::vec3(place.irradiance.mean));
    const float error = luminance(glm::vec3(place.irradiance.error));
    const float said = luminance(surface_irradiance(volume, origin + glm::dvec3(place.position), place.normal));
    const float scale = std::max(reference, darkest_of_usual * luminance(volume.volume->usual_light));
    if (!(scale > 0)) return said > 0 ? -1.0F : 0.0F;
    const float difference = std::abs(said - reference);
    const bool is_known = error <= std::max(good_enough * scale, of_difference * difference);
    return is_known ? difference / scale : -1.0F;
}

std::vector<float> differences_of(const ReferenceMap& map, glm::dvec3 origin, const LookUp& volume) {
    std::vector<float> differences(map.places.size(), -1.0F);
    for_each_index(map.traced, [&](std::size_t i) { differences[i] = difference_at(map.places[i], origin, volume); });
    return differences;
}

std::vector<std::size_t> worst_places(const ReferenceMap& map, std::span<const float> differences, double apart,
                                      std::size_t most) {
    std::vector<std::size_t> order(differences.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return differences[a] > differences[b]; });
    std::vector<std::size_t> worst;
    for (const std::size_t i : order) {
        if (worst.size() == most || !(differences[i] > 0)) break;
        const bool is_near = std::any_of(worst.begin(), worst.end(), [&](std::size_t other) {
            return glm::distance(map.places[i].position, map.places[other].position) < apart;
        });
        if (!is_near) worst.push_back(i);
    }
    return worst;
}

std::optional<std::size_t> nearest_place(std::span<const MapPlace> places, glm::vec3 position, glm::vec3 normal,
                                         float size) {
    if (places.empty()) return {};
    std::size_t nearest = 0;
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < places.size(); ++i) {
        const float away = apartness(places[i], position, normal, size);
        if (away < least) {
            least = away;
            nearest = i;
        }
    }
    const float reach = reach_of_a_place * places.back().apart;
    if (least > reach * reach || glm::dot(places[nearest].normal, normal) < much_the_same_way) return {};
    return nearest;
}

}  // namespace lightgrid
