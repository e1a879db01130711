#include "tools/volume_summary.h"

#include "core/sh.h"

#include <cmath>

namespace lightgrid {
namespace {

double squared(glm::dvec3 v) {
    return glm::dot(v, v);
}

}  // namespace

VolumeSummary summarize(const Volume& volume) {
    VolumeSummary summary;
    double sum_light = 0;
    double sum_noise = 0;
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        ++summary.states[static_cast<std::size_t>(volume.states[slot])];
        if (!is_valid(volume.states[slot])) continue;
        double light = 0;
        double noise = 0;
        for (std::size_t axis = 0; axis < axis_normals.size(); ++axis) {
            const glm::dvec3 irradiance(irradiance_from_sh(volume.sh(slot), axis_normals[axis]));
            summary.irradiance += irradiance;
            light += squared(irradiance);
            noise += squared(glm::dvec3(volume.axis_errors[slot * axis_normals.size() + axis]));
        }
        sum_light += light;
        sum_noise += noise;
        const double share = light > 0 ? std::sqrt(noise / light) : 0;
        if (share > summary.worst_noise) {
            summary.worst_noise = share;
            summary.worst_position = gather_position(volume, slot);
        }
    }
    if (summary.valid() > 0) {
        const double directions = static_cast<double>(summary.valid() * axis_normals.size());
        summary.irradiance /= directions;
        summary.noise = std::sqrt(sum_noise / (3 * directions));
        summary.relative_noise = sum_light > 0 ? std::sqrt(sum_noise / sum_light) : 0;
    }
    return summary;
}

}  // namespace lightgrid
