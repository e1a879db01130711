#include "core/error.h"
#include "core/gltf.h"
#include "core/parallel.h"
#include "core/sh.h"
#include "probes/gather.h"
#include "tools/csv.h"
#include "tools/program.h"
#include "tools/verbs.h"

#include <fmt/format.h>

namespace lightgrid {
namespace {

constexpr std::uint32_t reference_replicates = 32;

void write_coefficients(const Points& points, const Gather& gather) {
    std::vector<std::string> columns{"x", "y", "z"};
    add_sh_columns(columns, 'c', gather.bands);
    add_sh_columns(columns, 'e', gather.bands);
    CsvWriter out(columns);
    for (std::size_t i = 0; i < points.positions.size(); ++i) {
        out << points.positions[i];
        for (const Estimate& estimate : gather.sh(i)) out << estimate.mean;
        for (const Estimate& estimate : gather.sh(i)) out << estimate.error;
        out.end_row();
    }
    out.finish();
}

void write_irradiance(const Points& points, const Gather& gather) {
    CsvWriter out({"x", "y", "z", "nx", "ny", "nz", "r", "g", "b", "er", "eg", "eb"});
    for (std::size_t i = 0; i < points.positions.size(); ++i) {
        for (std::size_t k = 0; k < gather.normals; ++k) {
            const Estimate& estimate = gather.irradiance[i * gather.normals + k];
            out << points.positions[i];
            if (points.normals.empty()) {
                out << axis_normals[k];
            } else {
                out << points.normals[i];
            }
            out << estimate.mean << estimate.error;
            out.end_row();
        }
    }
    out.finish();
}

}  // namespace

void run_reference(const ReferenceOptions& options) {
    if (options.bands < 1 || options.bands > max_sh_bands) {
        throw Error(fmt::format("{} bands: must be 1 to {}", options.bands, max_sh_bands), "--bands");
    }
    const ThreadLimit threads(options.threads);
    const ChosenLight light = choose_light(options.light);
    for (const std::string& notice : light.notices) warn("lightgrid", notice);
    const Scene scene = load_level(options.level, load_options(options.level_options));
    for (const std::string& notice : scene.notices) warn("lightgrid", notice);
    const Points points = read_points(options.points);
    const Tracer tracer(scene);
    const PathTracer paths(tracer, light.environment);

    GatherOptions gather_options;
    gather_options.bands = options.bands;
    gather_options.samples = options.samples;
    gather_options.replicates = reference_replicates;
    gather_options.seed = options.seed;
    if (points.normals.empty()) {
        gather_options.normals.assign(axis_normals.begin(), axis_normals.end());
    } else {
        gather_options.one_normal_each = true;
        for (const glm::dvec3& normal : points.normals) gather_options.normals.push_back(unit_normal(normal));
    }
    std::vector<glm::vec3> relative;
    for (const glm::dvec3& position : points.positions) relative.emplace_back(position - scene.origin);
    PathCounts counts;
    const Gather result = gather(paths, std::move(relative), gather_options, &counts);
    if (counts.dropped > 0) {
        warn("lightgrid", fmt::format("{} samples were not finite and count as black", counts.dropped));
    }
    if (result.is_black() && (paths.lights() & ~counts.tested) != 0) {
        warn("lightgrid",
             fmt::format("no light reached any of {} points, and not every light was tested by a ray: that "
                         "they are black is no evidence",
                         points.positions.size()));
    }
    options.sh ? write_coefficients(points, result) : write_irradiance(points, result);
}

}  // namespace lightgrid
