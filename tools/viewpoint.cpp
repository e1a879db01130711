#include "tools/viewpoint.h"

#include "core/parallel.h"
#include "core/sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace lightgrid {
namespace {

constexpr int headings = 24;
constexpr std::size_t most_eyes = 1024;

struct Prospect {
    double score = -1;
    int heading = 0;
};

glm::vec3 direction_of(double heading) {
    const double angle = 2 * std::numbers::pi * heading / headings;
    return glm::normalize(glm::vec3(std::cos(angle), -0.12F, std::sin(angle)));
}

/// How far one sees around an eye, and towards which heading it is worth looking.
Prospect look_around(const Tracer& tracer, glm::vec3 eye, double horizontal_angle_deg, float far) {
    std::array<double, headings> depth{};
    for (int i = 0; i < headings; ++i) {
        const Hit hit = tracer.closest_hit(eye, direction_of(i));
        // What is out of sight or very far fills a picture with sky; what is very near fills it with one wall.
        const double seen = hit.found() ? std::min(hit.distance, far) : 0.15 * far;
        depth[static_cast<std::size_t>(i)] = std::log(std::max(seen / far, 0.01));
    }
    const int half = std::max(1, static_cast<int>(horizontal_angle_deg / 360 * headings / 2));
    Prospect best{.score = -1e9};
    for (int i = 0; i < headings; ++i) {
        double sum = 0;
        for (int k = -half; k <= half; ++k) sum += depth[static_cast<std::size_t>((i + k + headings) % headings)];
        if (sum > best.score) best = {sum, i};
    }
    return best;
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
    const float median_light = light[light.size() / 2];

    const double eye_level = box.min.y + 0.35 * box.size().y;
    std::erase_if(valid, [&](std::size_t slot) {
        const bool too_high_or_low = std::abs(gather_position(volume, slot).y - eye_level) > 0.2 * box.size().y;
        return too_high_or_low || luminance(volume.sh(slot)[0]) < 0.3F * median_light;
    });
    if (valid.empty())
        return Camera::looking_at(box.center(), box.center() + glm::dvec3(1, 0, 0), horizontal_angle_deg);

    const auto far = static_cast<float>(0.7 * glm::length(box.size()));
    const std::size_t stride = (valid.size() + most_eyes - 1) / most_eyes;
    std::vector<Prospect> prospects((valid.size() + stride - 1) / stride);
    for_each_index(prospects.size(), [&](std::size_t i) {
        const glm::vec3 eye(gather_position(volume, valid[i * stride]) - tracer.scene().origin);
        prospects[i] = look_around(tracer, eye, horizontal_angle_deg, far);
    });
    const auto best = std::max_element(prospects.begin(), prospects.end(),
                                       [](const Prospect& a, const Prospect& b) { return a.score < b.score; });
    const glm::dvec3 eye = gather_position(volume, valid[static_cast<std::size_t>(best - prospects.begin()) * stride]);
    return Camera::looking_at(eye, eye + glm::dvec3(direction_of(best->heading)), horizontal_angle_deg);
}

}  // namespace lightgrid
