#include "probes/headroom.h"

#include "core/parallel.h"
#include "core/sampling.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <vector>

namespace lightgrid {
namespace {

constexpr std::size_t columns = 4096;
constexpr double spots = 0.005;  // of all columns
constexpr int most_floors = 16;
constexpr int sideways = 16;
/// Of the headroom.
constexpr double half_width_of_ground = 0.35;
constexpr double step_of_ground = 0.5;
constexpr double height_of_room = 0.5;
/// Of what is met sideways: with more back faces than this a space is inside a solid.
constexpr double most_back_faces = 0.9;
constexpr double least_walls = 0.5;  // of all directions sideways

constexpr glm::vec3 down(0, -1, 0);

class Columns {
  public:
    Columns(const Tracer& tracer, double headroom)
        : tracer_(tracer), headroom_(headroom), bounds_(tracer.scene().bounds), margin_(0.5 * headroom) {}

    /// Where the i-th column is open to the sky, if that is ground.
    std::optional<double> ground(std::size_t i, std::uint64_t& rays) const {
        const glm::dvec2 u(sobol_point(static_cast<std::uint32_t>(i), 0));
        const glm::dvec2 place(bounds_.min.x + u.x * bounds_.size().x, bounds_.min.z + u.y * bounds_.size().z);
        const std::optional<double> top = first_below(place, bounds_.max.y + margin_, rays);
        if (!top || !is_wide(place, *top, rays)) return {};
        return top;
    }

  private:
    [[nodiscard]] glm::vec3 relative(glm::dvec3 point) const { return glm::vec3(point - tracer_.scene().origin); }

    std::optional<double> first_below(glm::dvec2 place, double height, std::uint64_t& rays) const {
        ++rays;
        const Hit hit = tracer_.closest_hit(relative({place.x, height, place.y}), down);
        if (!hit.found()) return {};
        return height - static_cast<double>(hit.distance);
    }

    /// The same ground all around: what is over a wall of a room is a part of its roof.
    bool is_wide(glm::dvec2 place, double height, std::uint64_t& rays) const {
        const double step = half_width_of_ground * headroom_;
        for (int i = 0; i < 9; ++i) {
            const glm::dvec2 beside = place + step * glm::dvec2(i % 3 - 1, i / 3 - 1);
            if (beside.x < bounds_.min.x || beside.x > bounds_.max.x || beside.y < bounds_.min.z ||
                beside.y > bounds_.max.z)
                continue;  // the level ends there
            const std::optional<double> there = first_below(beside, bounds_.max.y + margin_, rays);
            if (!there || std::abs(*there - height) > step_of_ground * headroom_ || is_roof(beside, *there, rays))
                return false;
        }
        return true;
    }

    bool is_roof(glm::dvec2 place, double top, std::uint64_t& rays) const {
        const double least = height_of_room * headroom_;
        double above = top;
        for (int floor = 0; floor < most_floors; ++floor) {
            // A little further each time: what is as thin as that is one with what lies below.
            const std::optional<double> below = first_below(place, above - 1e-3 * headroom_, rays);
            if (!below) return false;
            if (above - *below >= least && is_room({place.x, 0.5 * (above + *below), place.y}, rays)) return true;
            above = *below;
        }
        return false;
    }

    bool is_room(glm::dvec3 point, std::uint64_t& rays) const {
        int walls = 0;
        int backs = 0;
        for (int i = 0; i < sideways; ++i) {
            const double angle = glm::two_pi<double>() * (i + 0.5) / sideways;
            const glm::vec3 direction(static_cast<float>(std::cos(angle)), 0, static_cast<float>(std::sin(angle)));
            ++rays;
            const Hit hit = tracer_.closest_hit(relative(point), direction);
            if (!hit.found()) continue;
            ++walls;
            const Surface surface = tracer_.surface(hit, direction);
            const Material& material = tracer_.scene().materials[static_cast<std::size_t>(surface.mesh->material)];
            if (!surface.front && !material.double_sided) ++backs;
        }
        return walls >= least_walls * sideways && backs <= most_back_faces * walls;
    }

    const Tracer& tracer_;
    double headroom_;
    Box bounds_;
    double margin_;  // above the bounds, where columns begin
};

}  // namespace

std::optional<double> top_of_open_ground(const Tracer& tracer, double headroom, std::uint64_t& rays) {
    if (tracer.scene().bounds.empty()) return {};
    const Columns all(tracer, headroom);
    std::vector<std::optional<double>> grounds(columns);
    std::vector<std::uint64_t> counted(columns);
    for_each_index(columns, [&](std::size_t i) { grounds[i] = all.ground(i, counted[i]); });
    rays += std::accumulate(counted.begin(), counted.end(), std::uint64_t{0});
    std::vector<double> heights;
    for (const std::optional<double>& ground : grounds)
        if (ground) heights.push_back(*ground);
    const auto higher = static_cast<std::size_t>(spots * static_cast<double>(columns));
    if (heights.size() <= higher) return {};
    const auto top = heights.begin() + static_cast<std::ptrdiff_t>(higher);
    std::nth_element(heights.begin(), top, heights.end(), std::greater<>());
    return *top;
}

}  // namespace lightgrid
