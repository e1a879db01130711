#pragma once

#include "tools/level_options.h"
#include "tools/light_options.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// What `lightgrid VERB` does, a function per verb: results to standard output, Error when something is wrong.
namespace lightgrid {

void run_info(const std::string& volume_path, bool json);

void run_probes(const std::string& volume_path);

struct QueryOptions {
    std::string volume;
    std::string points;             // CSV; "-": standard input
    bool sh = false;                // coefficients instead of irradiance
    float normal_bias = 0;          // metres, as fade_distance
    std::string outside = "clamp";  // or "fade"
    float fade_distance = 1;
    std::string layers;   // weights of layers (layer_options.h); empty: the combined light
    glm::vec3 sky{0};     // radiance that `fade` goes to, the same from everywhere
    bool dering = false;  // windows the coefficients at each point so that irradiance is nowhere negative
};
void run_query(const QueryOptions& options);

struct ReferenceOptions {
    std::string level;
    std::string points;  // CSV; "-": standard input
    bool sh = false;     // coefficients instead of irradiance
    LevelOptions level_options;
    LightOptions light;
    std::uint32_t samples = 32768;  // gather rays per point
    int bands = 3;
    std::uint64_t seed = 0;
    int threads = 0;
};
/// The path tracer's answer, with standard errors.
void run_reference(const ReferenceOptions& options);

struct DrawOptions {
    std::string level;
    std::string volume;
    std::string folder = ".";
    LevelOptions level_options;        // beyond those that the volume was baked with
    LightOptions light;                // what is around the level; the light on it is the volume's
    std::optional<glm::dvec3> at;      // where slices and cuts go through; none: the volume's middle
    std::vector<double> camera;        // eye and target; empty: found
    double angle_deg = 70;             // the camera's, horizontally
    std::optional<float> exposure;     // per cd/m^2; none: automatic
    std::optional<float> normal_bias;  // metres; none: three tenths of the spacing
    int width = 1280;                  // pixels
    std::string report;                // of level-bake; empty: no curve
};
/// Writes slices.png and probes.png into the folder, view.png with a camera, error.svg with a report, and their paths
/// to standard output.
void run_draw(const DrawOptions& options);

/// reference_path  a volume, or a CSV of values ("-": standard input)
void run_diff(const std::string& reference_path, const std::string& volume_path, bool json);

}  // namespace lightgrid
