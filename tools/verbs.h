#pragma once

#include "tools/light_options.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <string>

/// What `lightgrid VERB` does, a function per verb: results to standard output, Error when something is wrong.
namespace lightgrid {

void run_info(const std::string& volume_path, bool json);

void run_probes(const std::string& volume_path);

struct QueryOptions {
    std::string volume;
    std::string points;  // CSV; "-": standard input
    bool sh = false;     // coefficients instead of irradiance
    float normal_bias = 0;
    std::string outside = "clamp";  // or "fade"
    float fade_distance = 1;
    glm::vec3 sky{0};  // radiance that `fade` goes to, the same from everywhere
};
void run_query(const QueryOptions& options);

struct ReferenceOptions {
    std::string level;
    std::string points;  // CSV; "-": standard input
    bool sh = false;     // coefficients instead of irradiance
    int scene = -1;
    LightOptions light;
    std::uint32_t samples = 32768;  // gather rays per point
    int bands = 3;
    std::uint64_t seed = 0;
    int threads = 0;
};
/// The path tracer's answer, with standard errors.
void run_reference(const ReferenceOptions& options);

/// reference_path  a volume, or a CSV of values ("-": standard input)
void run_diff(const std::string& reference_path, const std::string& volume_path, bool json);

}  // namespace lightgrid
