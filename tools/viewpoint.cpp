#include "tools/viewpoint.h"

#include "core/parallel.h"
#include "core/sampling.h"
#include "tools/ground.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

namespace lightgrid {
namespace {

constexpr int headings = 24;
constexpr std::array<float, 3> pitches_deg{-22, -8, 6};
constexpr float wanted_pitch_deg = -7;
constexpr std::size_t most_eyes = 1024;

constexpr double eye_height_m = 1.6;       // above the ground
constexpr float share_of_headroom = 0.5F;  // lower where there is less of it
constexpr double share_of_median_light = 0.3;

// Worths are added; how far one sees counts as the mean logarithm of the distance, from 0 (across the level) to -4.6.
constexpr double depth_of_nothing = 0.15;  // what is out of sight fills a picture with sky
constexpr double nearest_depth = 0.01;     // what is very near fills it with one wall
constexpr double worth_of_enclosure = 1.5;
constexpr double worth_of_variety = 2;

struct Prospect {
    double worth = -1e9;
    int heading = 0;
};

glm::vec3 direction_of(double heading, float pitch_deg) {
    const double angle = 2 * std::numbers::pi * heading / headings;
    const double pitch = glm::radians(static_cast<double>(pitch_deg));
    return {std::cos(angle) * std::cos(pitch), std::sin(pitch), std::sin(angle) * std::cos(pitch)};
}

/// What one ray finds: how far it is, and which surface it is, by mesh and the way it faces.
struct Glance {
    double depth = 0;
    std::optional<std::tuple<std::uint32_t, std::uint32_t, int, int, int>> surface;
};

Glance glance(const Tracer& tracer, glm::vec3 eye, glm::vec3 direction, float far) {
    const Hit hit = tracer.closest_hit(eye, direction);
    Glance seen{std::log(depth_of_nothing), {}};
    if (!hit.found()) return seen;
    seen.depth = std::log(std::clamp(static_cast<double>(hit.distance / far), nearest_depth, 1.0));
    const glm::ivec3 facing(glm::round(2.0F * tracer.surface(hit, direction).normal));
    seen.surface.emplace(hit.id.instance, hit.id.geometry, facing.x, facing.y, facing.z);
    return seen;
}

/// Of all rays from an eye, up ones included: how many meet something.
double enclosure(const Tracer& tracer, glm::vec3 eye, const std::vector<Glance>& level_glances) {
    std::size_t met = 0;
    for (const Glance& seen : level_glances) met += seen.surface ? 1 : 0;
    std::size_t above = 0;
    for (int i = 0; i < headings; ++i) above += tracer.closest_hit(eye, direction_of(i, 50)).found() ? 1 : 0;
    return 0.5 * static_cast<double>(met) / static_cast<double>(level_glances.size()) +
           0.5 * static_cast<double>(above) / headings;
}

/// What there is to see around an eye, and towards which heading it is worth looking.
Prospect look_around(const Tracer& tracer, glm::vec3 eye, double horizontal_angle_deg, float far) {
    std::vector<Glance> glances;
    for (int i = 0; i < headings; ++i) {
        for (const float pitch : pitches_deg) glances.push_back(glance(tracer, eye, direction_of(i, pitch), far));
    }
    const double around = worth_of_enclosure * enclosure(tracer, eye, glances);
    const int half = std::max(1, static_cast<int>(horizontal_angle_deg / 360 * headings / 2));
    Prospect best;
    for (int i = 0; i < headings; ++i) {
        double depth = 0;
        std::size_t rays = 0;
        std::set<decltype(Glance::surface)> surfaces;
        for (int k = -half; k <= half; ++k) {
            const auto column = static_cast<std::size_t>((i + k + headings) % headings);
            for (std::size_t p = 0; p < pitches_deg.size(); ++p, ++rays) {
                const Glance& seen = glances[column * pitches_deg.size() + p];
                depth += seen.depth;
                if (seen.surface) surfaces.insert(seen.surface);
            }
        }
        const double count = static_cast<double>(rays);
        const double worth =
            depth / count + worth_of_variety * std::sqrt(static_cast<double>(surfaces.size()) / count) + around;
        if (worth > best.worth) best = {worth, i};
    }
    return best;
}

/// Where the eyes of somebody would be who stands below a point, or nothing where nobody could.
std::optional<glm::vec3> standing_eye(const Tracer& tracer, glm::vec3 point, float level_height) {
    const std::optional<float> above_ground = height_above_ground(tracer, point);
    if (!above_ground) return {};
    constexpr glm::vec3 up(0, 1, 0);
    const Hit ceiling = tracer.closest_hit(point, up);
    const float headroom = *above_ground + (ceiling.found() ? ceiling.distance : level_height);
    const auto eyes = static_cast<float>(eye_height_m / tracer.scene().metres_per_unit);
    const float height = std::min({eyes, share_of_headroom * headroom, share_of_headroom * level_height});
    return point + (height - *above_ground) * up;
}

}  // namespace

Camera find_viewpoint(const Tracer& tracer, const Volume& volume, double horizontal_angle_deg) {
    Box box;
    std::vector<std::size_t> valid;
    std::vector<float> light;
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (!is_valid(volume.states[slot])) continue;
        box.extend(gather_position(volume, slot));
        valid.push_back(slot);
        light.push_back(luminance(volume.sh(slot)[0]));
    }
    if (valid.empty()) return Camera{};
    std::nth_element(light.begin(), light.begin() + static_cast<std::ptrdiff_t>(light.size() / 2), light.end());
    const auto least_light = static_cast<float>(share_of_median_light * light[light.size() / 2]);
    std::erase_if(valid, [&](std::size_t slot) { return luminance(volume.sh(slot)[0]) < least_light; });

    const auto far = static_cast<float>(0.7 * glm::length(box.size()));
    const auto level_height = static_cast<float>(std::max(box.size().y, 1e-3 * glm::length(box.size())));
    const std::size_t stride = (valid.size() + most_eyes - 1) / most_eyes;
    struct Stand {
        glm::vec3 eye{0};
        Prospect prospect;
    };
    std::vector<Stand> stands((valid.size() + stride - 1) / stride);
    for_each_index(stands.size(), [&](std::size_t i) {
        const glm::vec3 probe(gather_position(volume, valid[i * stride]) - tracer.scene().origin);
        const std::optional<glm::vec3> eye = standing_eye(tracer, probe, level_height);
        // What floats in the void has no ground: then any probe will do.
        stands[i].eye = eye.value_or(probe);
        stands[i].prospect = look_around(tracer, stands[i].eye, horizontal_angle_deg, far);
        if (!eye) stands[i].prospect.worth -= 100;
    });
    const auto best = std::max_element(stands.begin(), stands.end(), [](const Stand& a, const Stand& b) {
        return a.prospect.worth < b.prospect.worth;
    });
    const glm::dvec3 eye = tracer.scene().origin + glm::dvec3(best->eye);
    const glm::dvec3 towards(direction_of(best->prospect.heading, wanted_pitch_deg));
    return Camera::looking_at(eye, eye + towards, horizontal_angle_deg);
}

}  // namespace lightgrid
