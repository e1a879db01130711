#pragma once

#include "core/environment_file.h"
#include "core/gltf.h"
#include "probes/bake.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

/// Levels that benchmarks of bakes compare, and the probes of them.
namespace lightgrid {

/// A level, the light on it, and what of it is compared.
struct Level {
    std::string name;
    Scene scene;
    Environment environment;
    std::optional<double> spacing;
    std::size_t compared = 256;                                // probes, at most
    double from_x = -std::numeric_limits<double>::infinity();  // of them
    double reference_seconds = 30;  // of the processor, for each half of a reference, so that it can tell a bias of 1 %
};

/// The probes that a bake of 1,024 gather rays would place, and the cache that it would build for them.
inline std::vector<glm::vec3> probes_of(const PathTracer& paths, std::optional<double> spacing, CacheOptions& cache) {
    BakeOptions options;
    options.placement.spacing = spacing;
    options.method = Method::cache;
    options.target.samples = 1024;
    BakePlan plan = plan_bake(paths, options);
    cache = plan.cache;
    return std::move(plan.points);
}

inline std::vector<glm::vec3> spread_over(const std::vector<glm::vec3>& points, std::size_t most) {
    const std::size_t count = std::min(most, points.size());
    std::vector<glm::vec3> some;
    for (std::size_t i = 0; i < count; ++i) some.push_back(points[i * points.size() / count]);
    return some;
}

inline Level load_lit_level(const std::string& name, const std::filesystem::path& file,
                            const std::filesystem::path& environment = {}) {
    Level level;
    level.name = name;
    level.scene = load_level(file);
    if (!environment.empty()) level.environment = load_environment(environment).environment;
    return level;
}

}  // namespace lightgrid
