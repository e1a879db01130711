#include "viewer/default_flight.h"

#include "core/sampling.h"
#include "viewer/free_space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

namespace lightgrid {
namespace {

/// Room that a flight asks for around itself, in cells of the lattice of free space: less and less until there is room
/// to go somewhere.
constexpr std::array<float, 4> wanted_clearances{1.5F, 1.0F, 0.6F, 0.3F};
/// Of the points of free space at the least clearance, that at a larger one are enough to fly through.
constexpr double enough_room = 0.4;
constexpr std::size_t most_places = 6;
constexpr double least_interest = 0.3;  // of a place to visit, of that of the best
constexpr int smoothing_rounds = 200;
constexpr double least_duration_s = 10;
constexpr double most_duration_s = 24;
constexpr double keys_per_second = 4;
constexpr double sizes_ahead = 6;     // from eye to object, in the object's size
constexpr double object_drop = 0.15;  // tangent of the angle by which the object is seen below the middle
constexpr int gaze_steps = 4;         // to each side of the object
constexpr double gaze_step_deg = 9;

// ---- where to go ---------------------------------------------------------------------------------------------------

/// How much there is to see at each point: light, from some side rather than from all, amid the level.
std::vector<double> find_interest(const FreeSpace& space, const LookUp& light, glm::dvec3 origin) {
    std::vector<double> interest(space.points.size());
    const double usual = luminance(light.volume->usual_light);
    float top = -std::numeric_limits<float>::infinity();
    float bottom = std::numeric_limits<float>::infinity();
    for (const glm::vec3& point : space.points) {
        top = std::max(top, point.y);
        bottom = std::min(bottom, point.y);
    }
    for (std::size_t i = 0; i < interest.size(); ++i) {
        const Sh9 sh = radiance_sh(light, origin + glm::dvec3(space.points[i]));
        const double mean = luminance(sh[0]);
        const glm::dvec3 first(luminance(sh[1]), luminance(sh[2]), luminance(sh[3]));
        const double one_sided = mean > 0 ? std::min(1.0, glm::length(first) / (std::sqrt(3.0) * mean)) : 0;
        const double bright =
            usual > 0
                ? std::min(2.0, luminance(mean_irradiance_at(light, origin + glm::dvec3(space.points[i]))) / usual)
                : 1;
        // People know levels from low in them, and roofs from above say little.
        const double height = top > bottom ? (space.points[i].y - bottom) / (top - bottom) : 0;
        const double low = 1 / (1 + 4 * std::max(0.0, height - 0.25));
        // Behind the scenes and high above them there are backs of surfaces, or none.
        const double amid = space.fronts[i] * space.fronts[i];
        interest[i] = (0.02 + bright) * (0.3 + one_sided) * (0.02 + amid) * low;
    }
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
            const double dull = 1 / (0.05 + interest[link.to]);
            const double climb = std::abs(space.points[link.to].y - space.points[point].y) / link.length;
            const double next = cost + link.length * (0.2 + tight + dull) * (1 + 1.5 * climb);
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
std::vector<std::uint32_t> choose_places(const FreeSpace& space, const std::vector<double>& interest) {
    std::vector<std::uint32_t> places{
        static_cast<std::uint32_t>(std::max_element(interest.begin(), interest.end()) - interest.begin())};
    while (places.size() < most_places) {
        const Ways ways = find_ways(space, interest, places);
        std::uint32_t best = places[0];
        double most = 0;
        for (std::uint32_t i = 0; i < space.points.size(); ++i) {
            if (interest[i] < least_interest * interest[places[0]] || !std::isfinite(ways.cost[i])) continue;
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
std::vector<glm::vec3> find_route(const FreeSpace& space, const std::vector<double>& interest) {
    std::vector<std::uint32_t> places = choose_places(space, interest);
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
    std::vector<float> room(line.size());
    for (std::size_t i = 0; i < line.size(); ++i) room[i] = clearance_at(tracer, line[i], clearance);
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

/// A place on a line that is given by points at equal distances.
glm::vec3 at_length(std::span<const glm::vec3> line, double step, double length) {
    const double place = std::clamp(length / step, 0.0, static_cast<double>(line.size() - 1));
    const auto before = std::min(static_cast<std::size_t>(place), line.size() - 2);
    return glm::mix(line[before], line[before + 1], static_cast<float>(place - static_cast<double>(before)));
}

/// Mean over a few neighbours on both sides, and again: takes jumps out of what is followed with the eye.
template <typename Value>
void soften(std::vector<Value>& values, int reach) {
    for (int round = 0; round < 2; ++round) {
        const std::vector<Value> before = values;
        const auto last = static_cast<std::ptrdiff_t>(values.size()) - 1;
        for (std::ptrdiff_t i = 0; i <= last; ++i) {
            Value sum{};
            for (std::ptrdiff_t k = i - reach; k <= i + reach; ++k) {
                sum += before[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(k, 0, last))];
            }
            values[static_cast<std::size_t>(i)] = sum / static_cast<float>(2 * reach + 1);
        }
    }
}

/// From 0 to 1, starting and ending at rest.
double eased(double t) {
    constexpr double ramp = 0.12;  // of the time, at each end
    const double most = 1 / (1 - ramp);
    if (t < ramp) return most * t * t / (2 * ramp);
    if (t > 1 - ramp) return 1 - most * (1 - t) * (1 - t) / (2 * ramp);
    return most * (t - ramp / 2);
}

/// More light comes from where one looks when flying this way than when flying back.
bool looks_into_light(std::span<const glm::vec3> line, const LookUp& light, glm::dvec3 origin) {
    double difference = 0;
    for (std::size_t i = 1; i < line.size(); ++i) {
        const Sh9 sh = radiance_sh(light, origin + glm::dvec3(line[i]));
        const glm::vec3 first(luminance(sh[3]), luminance(sh[1]), luminance(sh[2]));
        difference += glm::dot(first, line[i] - line[i - 1]);
    }
    return difference >= 0;
}

/// How far ahead of a place on the line the object flies: in sight, and not so near that it fills the picture where the
/// line turns back.
double find_lead(const Tracer& tracer, std::span<const glm::vec3> line, double step, double passed, double ahead) {
    const glm::vec3 eye = at_length(line, step, passed);
    double best = ahead;
    double least = std::numeric_limits<double>::infinity();
    for (double lead = 0.5 * ahead; lead <= 2.5 * ahead; lead += 0.1 * ahead) {
        const glm::vec3 object = at_length(line, step, passed + lead);
        const double too_near = std::max(0.0, 1 - glm::distance(eye, object) / (0.7 * ahead));
        const double cost = std::abs(lead / ahead - 1) + 10 * too_near + (is_clear(tracer, eye, object) ? 0 : 3);
        if (cost >= least) continue;
        least = cost;
        best = lead;
    }
    return best;
}

/// How much light there is to see in a direction, and how it differs: mean and standard deviation over some rays of
/// what arrives where they end, in units of the usual light.
double worth_seeing(const Tracer& tracer, const LookUp& light, glm::vec3 eye, glm::vec3 ahead, float distance) {
    const glm::dvec3 origin = tracer.scene().origin;
    const glm::vec3 right = glm::normalize(glm::cross(ahead, glm::vec3(0, 1, 0)));
    const glm::vec3 up = glm::cross(right, ahead);
    const double usual = luminance(light.volume->usual_light);
    double sum = 0;
    double squares = 0;
    constexpr int rays = 15;
    for (int i = 0; i < rays; ++i) {
        const glm::vec2 aside = glm::vec2(i % 5 - 2, i / 5 - 1) * 0.2F;
        const glm::vec3 direction = glm::normalize(ahead + aside.x * right + aside.y * up);
        const Hit hit = tracer.closest_hit(eye, direction);
        if (!hit.found()) continue;
        const Surface surface = tracer.surface(hit, direction);
        const glm::vec3 normal = surface.front ? surface.normal : -surface.normal;
        const glm::vec3 lit = surface_irradiance(light, origin + glm::dvec3(surface.position), normal);
        // What is nearer than the object fills the picture and hides the rest.
        const double near = hit.distance / (hit.distance + distance);
        const double bright = near * (usual > 0 ? std::min(2.0, luminance(lit) / usual) : 1);
        sum += bright / rays;
        squares += bright * bright / rays;
    }
    return sum + std::sqrt(std::max(0.0, squares - sum * sum));
}

/// By how much to look to the left of the object, degrees, so that there is most to see.
float find_gaze(const Tracer& tracer, const LookUp& light, glm::dvec3 eye, glm::dvec3 object) {
    const Pose towards = looking_at(eye, object);
    double most = -1;
    double best = 0;
    for (int i = -gaze_steps; i <= gaze_steps; ++i) {
        const glm::vec3 ahead(forward(turned(towards, i * gaze_step_deg, 0)));
        const double aside = static_cast<double>(i) / gaze_steps;
        const double worth = worth_seeing(tracer, light, glm::vec3(eye - tracer.scene().origin), ahead,
                                          static_cast<float>(glm::distance(eye, object))) -
                             0.3 * aside * aside;
        if (worth <= most) continue;
        most = worth;
        best = i * gaze_step_deg;
    }
    return static_cast<float>(best);
}

DefaultFlight turn_in_place(const Tracer& tracer, const LitVolume& volume) {
    const LookUp light = look_up(volume, Settings{});
    glm::dvec3 eye = tracer.scene().bounds.empty() ? glm::dvec3(0) : tracer.scene().bounds.center();
    float most = -1;
    for (std::size_t slot = 0; slot < volume.volume.list_start(); ++slot) {
        if (!is_valid(volume.volume.states[slot])) continue;
        const glm::dvec3 position = gather_position(volume.volume, slot);
        const float bright = luminance(mean_irradiance_at(light, position));
        if (bright > most) {
            most = bright;
            eye = position;
        }
    }
    DefaultFlight result;
    for (int i = 0; i <= 8; ++i) {
        FlightKey key{.time_s = i * least_duration_s / 8, .eye = eye, .yaw_deg = 45.0 * i};
        key.object = eye + 0.5 * volume.spacing * forward({eye, key.yaw_deg, -10});
        result.flight.keys.push_back(key);
    }
    result.object_size = 0.15 * volume.spacing;
    return result;
}

}  // namespace

DefaultFlight make_default_flight(const Tracer& tracer, const LitVolume& volume) {
    const glm::dvec3 origin = tracer.scene().origin;
    const LookUp light = look_up(volume, Settings{});
    FreeSpace space = find_free_space(tracer, volume.volume, wanted_clearances.back());
    const double all = static_cast<double>(space.points.size());
    float clearance = wanted_clearances.back();
    for (const float wanted : wanted_clearances) {
        FreeSpace roomy = find_free_space(tracer, volume.volume, wanted);
        if (static_cast<double>(roomy.points.size()) < enough_room * all) continue;
        space = std::move(roomy);
        clearance = wanted;
        break;
    }
    if (space.points.size() < 2) return turn_in_place(tracer, volume);

    const auto room = static_cast<float>(clearance * space.spacing);
    std::vector<glm::vec3> line = find_route(space, find_interest(space, light, origin));
    if (line.size() < 2) return turn_in_place(tracer, volume);
    const auto count =
        std::clamp<std::size_t>(static_cast<std::size_t>(length_of(line) / (0.5 * space.spacing)), 16, 2000);
    line = resampled(line, count);
    smooth(line, tracer, room);
    if (!looks_into_light(line, light, origin)) std::reverse(line.begin(), line.end());

    const double length = length_of(line);
    const std::vector<glm::vec3> even = resampled(line, 4 * count);
    const double step = length / static_cast<double>(even.size() - 1);
    // The object is a few of its sizes ahead, as far as it is in sight.
    const double size = std::min(1.0 * room, 0.06 * length);
    const double ahead = std::min(sizes_ahead * size, 0.4 * length);
    const double duration = std::clamp(length / (4 * size), least_duration_s, most_duration_s);
    // The camera stops where the object, at the end of the line, is still some way off.
    double end = length - ahead;
    while (end > 0.5 * length && glm::distance(at_length(even, step, end), even.back()) < 0.8 * ahead) end -= step;
    const int keys = 1 + static_cast<int>(duration * keys_per_second);

    DefaultFlight result;
    result.object_size = size;
    std::vector<float> leads;
    for (int i = 0; i < keys; ++i) {
        const double passed = eased(static_cast<double>(i) / (keys - 1)) * end;
        leads.push_back(static_cast<float>(find_lead(tracer, even, step, passed, ahead)));
    }
    soften(leads, 2);
    std::vector<float> gazes;
    for (int i = 0; i < keys; ++i) {
        const double share = static_cast<double>(i) / (keys - 1);
        const double passed = eased(share) * end;
        const double lead = leads[static_cast<std::size_t>(i)];
        FlightKey key{.time_s = share * duration, .eye = origin + glm::dvec3(at_length(even, step, passed))};
        key.object = origin + glm::dvec3(at_length(even, step, passed + lead));
        gazes.push_back(find_gaze(tracer, light, key.eye, *key.object));
        result.flight.keys.push_back(key);
    }
    soften(gazes, static_cast<int>(keys_per_second));
    for (std::size_t i = 0; i < gazes.size(); ++i) {
        // The object is seen a little below the middle of the picture.
        FlightKey& key = result.flight.keys[i];
        const double distance = glm::distance(key.eye, *key.object);
        const Pose towards = looking_at(key.eye, *key.object + glm::dvec3(0, object_drop * distance, 0));
        key.look_at = key.eye + std::max(distance, 1e-6) * forward(turned(towards, gazes[i], 0));
    }
    return result;
}

}  // namespace lightgrid
