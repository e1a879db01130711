#include "viewer/route.h"

#include "core/parallel.h"
#include "core/sampling.h"
#include "viewer/panorama.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

namespace lightgrid {
namespace {

constexpr std::size_t most_places = 6;
/// Of a place to visit, of that of the best: less and less until the way is long enough.
constexpr std::array<double, 3> least_interest{0.5, 0.25, 0.12};
constexpr double long_enough = 0.5;  // of the diagonal of free space
constexpr double comfortable = 1.5;  // cells of room: no more is asked for
constexpr double worth_off_ground = 0.4;
constexpr int smoothing_rounds = 200;
/// Enough to tell whether there is anything to see.
constexpr Directions glances{.yaws = 16, .pitches = 4, .lowest_pitch_deg = -34, .pitch_step_deg = 18};

// ---- where to go ---------------------------------------------------------------------------------------------------

/// How much there is to see at each point, in the direction in which there is most.
std::vector<double> find_interest(const Tracer& tracer, const LookUp& light, const FreeSpace& space) {
    std::vector<double> interest(space.points.size());
    float top = -std::numeric_limits<float>::infinity();
    float bottom = std::numeric_limits<float>::infinity();
    for (const glm::vec3& point : space.points) {
        top = std::max(top, point.y);
        bottom = std::min(bottom, point.y);
    }
    for_each_index(interest.size(), [&](std::size_t i) {
        const Panorama panorama = look_round(tracer, light, space.points[i], 2.5 * space.room, glances);
        double most = 0;
        for (int yaw = 0; yaw < glances.yaws; ++yaw) {
            most = std::max(most, worth_of_view(panorama, yaw, glances.pitches / 2));
        }
        const glm::dvec3 point = tracer.scene().origin + glm::dvec3(space.points[i]);
        const double bright = brightness(luminance(mean_irradiance_at(light, point)), light);
        const double room = std::min(1.0, space.clearance[i] / (comfortable * space.spacing));
        // People know levels from low in them, on the ground; roofs from above say little.
        const double height = top > bottom ? (space.points[i].y - bottom) / (top - bottom) : 0;
        const double low = 1 / (1 + 8 * std::max(0.0, height - 0.25));
        const double ground = tracer.closest_hit(space.points[i], {0, -1, 0}).found() ? 1 : worth_off_ground;
        interest[i] = (0.01 + std::max(0.0, most) * most) * (0.02 + bright) * room * low * ground;
    });
    return interest;
}

/// Paths of least cost from some points to all others. Room to the sides and interest make a way shorter.
struct Ways {
    std::vector<double> cost;
    std::vector<double> length;       // of the path, metres
    std::vector<std::uint32_t> from;  // the point before; itself at a start
};

Ways find_ways(const FreeSpace& space, const std::vector<double>& interest, std::span<const std::uint32_t> starts) {
    using Entry = std::pair<double, std::uint32_t>;
    Ways ways{std::vector<double>(space.points.size(), std::numeric_limits<double>::infinity()),
              std::vector<double>(space.points.size()), std::vector<std::uint32_t>(space.points.size())};
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    const double best = std::max(*std::max_element(interest.begin(), interest.end()), 1e-6);
    for (const std::uint32_t start : starts) {
        ways.cost[start] = 0;
        ways.from[start] = start;
        open.emplace(0, start);
    }
    while (!open.empty()) {
        const auto [cost, point] = open.top();
        open.pop();
        if (cost > ways.cost[point]) continue;
        for (std::uint32_t k = space.first_link[point]; k < space.first_link[point + 1]; ++k) {
            const FreeSpace::Link& link = space.links[k];
            const double tight = space.spacing / (space.clearance[link.to] + 0.1 * space.spacing);
            const double dull = 1 / (0.1 + interest[link.to] / best);
            const double climb = std::abs(space.points[link.to].y - space.points[point].y) / link.length;
            const double next = cost + link.length * (0.2 + tight * tight + dull) * (1 + 1.5 * climb);
            if (next >= ways.cost[link.to]) continue;
            ways.cost[link.to] = next;
            ways.length[link.to] = ways.length[point] + link.length;
            ways.from[link.to] = point;
            open.emplace(next, link.to);
        }
    }
    return ways;
}

/// Points worth a visit, far from one another: the most interesting first, then whatever is most interesting times how
/// far it is from those chosen.
std::vector<std::uint32_t> choose_places(const FreeSpace& space, const std::vector<double>& interest, double least) {
    std::vector<std::uint32_t> places{
        static_cast<std::uint32_t>(std::max_element(interest.begin(), interest.end()) - interest.begin())};
    while (places.size() < most_places) {
        const Ways ways = find_ways(space, interest, places);
        std::uint32_t best = places[0];
        double most = 0;
        for (std::uint32_t i = 0; i < space.points.size(); ++i) {
            if (interest[i] < least * interest[places[0]] || !std::isfinite(ways.cost[i])) continue;
            const double worth = interest[i] * ways.length[i];
            if (worth > most) {
                most = worth;
                best = i;
            }
        }
        if (ways.length[best] < 3 * space.spacing) break;
        places.push_back(best);
    }
    return places;
}

/// The way through all places: from the last chosen, which is far from the others, always on to the nearest.
std::vector<glm::vec3> find_line(const FreeSpace& space, const std::vector<double>& interest, double least) {
    std::vector<std::uint32_t> places = choose_places(space, interest, least);
    std::uint32_t here = places.size() > 1 ? places[1] : places[0];
    std::erase(places, here);
    std::vector<glm::vec3> route{space.points[here]};
    while (!places.empty()) {
        const Ways ways = find_ways(space, interest, std::array{here});
        const auto next = std::min_element(places.begin(), places.end(), [&](std::uint32_t a, std::uint32_t b) {
            return ways.cost[a] < ways.cost[b];
        });
        std::vector<glm::vec3> leg;
        for (std::uint32_t i = *next; i != here; i = ways.from[i]) leg.push_back(space.points[i]);
        route.insert(route.end(), leg.rbegin(), leg.rend());
        here = *next;
        places.erase(next);
    }
    return route;
}

// ---- how to get there ----------------------------------------------------------------------------------------------

double length_of(std::span<const glm::vec3> line) {
    double length = 0;
    for (std::size_t i = 1; i < line.size(); ++i) length += glm::distance(line[i - 1], line[i]);
    return length;
}

/// Points at equal distances along a line, its ends included.
std::vector<glm::vec3> resampled(std::span<const glm::vec3> line, std::size_t count) {
    const double step = length_of(line) / static_cast<double>(count - 1);
    std::vector<glm::vec3> points{line.front()};
    double passed = 0;
    for (std::size_t i = 1; i < line.size() && points.size() + 1 < count; ++i) {
        const double length = glm::distance(line[i - 1], line[i]);
        while (points.size() + 1 < count && static_cast<double>(points.size()) * step <= passed + length) {
            const double share = length > 0 ? (static_cast<double>(points.size()) * step - passed) / length : 0;
            points.push_back(glm::mix(line[i - 1], line[i], static_cast<float>(share)));
        }
        passed += length;
    }
    while (points.size() < count) points.push_back(line.back());
    return points;
}

/// Pulls a line straight where that leads through nothing and not nearer than `clearance` to anything (or than it was).
void smooth(std::vector<glm::vec3>& line, const Tracer& tracer, float clearance) {
    std::vector<float> room;
    for (const glm::vec3 point : line) room.push_back(clearance_at(tracer, point, clearance));
    for (int round = 0; round < smoothing_rounds; ++round) {
        for (std::size_t i = 1; i + 1 < line.size(); ++i) {
            const glm::vec3 to = 0.25F * (line[i - 1] + 2.0F * line[i] + line[i + 1]);
            if (!is_clear(tracer, line[i], to) || !is_clear(tracer, line[i - 1], to) ||
                !is_clear(tracer, to, line[i + 1])) {
                continue;
            }
            const float there = clearance_at(tracer, to, clearance);
            if (there < std::min(room[i], clearance)) continue;
            line[i] = to;
            room[i] = there;
        }
    }
}

}  // namespace

glm::vec3 Route::at(double distance) const {
    const double place = std::clamp(distance / step, 0.0, static_cast<double>(points.size() - 1));
    const auto before = std::min(static_cast<std::size_t>(place), points.size() - 2);
    return glm::mix(points[before], points[before + 1], static_cast<float>(place - static_cast<double>(before)));
}

Route find_route(const Tracer& tracer, const LookUp& light, const FreeSpace& space) {
    if (space.points.size() < 2) return {};
    const std::vector<double> interest = find_interest(tracer, light, space);
    Box box;
    for (const glm::vec3 point : space.points) box.extend(point);
    std::vector<glm::vec3> line;
    for (const double least : least_interest) {
        line = find_line(space, interest, least);
        if (length_of(line) >= long_enough * glm::length(box.size())) break;
    }
    if (line.size() < 2) return {};
    const auto count =
        std::clamp<std::size_t>(static_cast<std::size_t>(length_of(line) / (0.5 * space.spacing)), 16, 2000);
    line = resampled(line, count);
    smooth(line, tracer, static_cast<float>(comfortable * space.spacing));
    Route route;
    route.points = resampled(line, 4 * count);
    route.step = length_of(line) / static_cast<double>(route.points.size() - 1);
    return route;
}

}  // namespace lightgrid
