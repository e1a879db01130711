#include "core/error.h"
#include "core/sh.h"
#include "probes/sampler.h"
#include "probes/volume_file.h"
#include "tools/csv.h"
#include "tools/layer_options.h"
#include "tools/level_options.h"
#include "tools/verbs.h"

#include <cmath>
#include <numbers>

namespace lightgrid {
namespace {

void write_coefficients(const Sampler& sampler, int bands, const Points& points, const SampleOptions& options,
                        bool dering) {
    std::vector<std::string> columns{"x", "y", "z", "valid"};
    add_sh_columns(columns, 'c', bands);
    CsvWriter out(columns);
    for (const glm::dvec3& position : points.positions) {
        Sample sample = sampler.sample(position, options);
        if (dering) dering_sh(sample.sh);
        out << position << (sample.weight > 0 ? 1 : 0);
        for (const glm::vec3& coefficient : sample.sh) out << coefficient;
        out.end_row();
    }
    out.finish();
}

void write_irradiance(const Sampler& sampler, int bands, const Points& points, const SampleOptions& options,
                      bool dering) {
    CsvWriter out({"x", "y", "z", "nx", "ny", "nz", "r", "g", "b", "valid"});
    std::vector<glm::vec3> sh(sh_size(bands));
    const auto write_row = [&](glm::dvec3 position, glm::dvec3 normal) {
        const glm::vec3 unit = unit_normal(normal);
        const glm::dvec3 biased = position + static_cast<double>(options.normal_bias) * glm::dvec3(unit);
        const float weight = sampler.sample(biased, sh, options);
        if (dering) dering_sh(sh);
        out << position << normal << irradiance_from_sh(sh, unit) << (weight > 0 ? 1 : 0);
        out.end_row();
    };
    for (std::size_t i = 0; i < points.positions.size(); ++i) {
        if (!points.normals.empty()) {
            write_row(points.positions[i], points.normals[i]);
        } else {
            for (const glm::vec3& axis : axis_normals) write_row(points.positions[i], axis);
        }
    }
    out.finish();
}

std::vector<glm::vec3> layer_weights(const QueryOptions& options, const Volume& volume) {
    try {
        return parse_layer_weights(options.layers, volume);
    } catch (const Error& error) {
        throw error.inside("--layers");
    }
}

}  // namespace

void run_query(const QueryOptions& options) {
    const Volume volume = load_volume(options.volume);
    if (!volume.has_cells()) {
        throw Error("is a probe list: it has no cells to interpolate in", options.volume,
                    "Read its probes with lightgrid probes, or bake a volume with a grid.");
    }
    const Points points = read_points(options.points);
    const Sampler sampler(volume);
    std::vector<glm::vec3> environment(volume.sh_size(), glm::vec3(0));
    environment[0] = 2 * std::sqrt(std::numbers::pi_v<float>) * options.sky;  // L_0 of a uniform sky
    SampleOptions how;
    const auto unit = static_cast<float>(metres_per_unit(volume));
    how.normal_bias = options.normal_bias / unit;
    how.outside = options.outside == "fade" ? Outside::fade : Outside::clamp;
    how.fade_distance = options.fade_distance / unit;
    how.environment = environment;
    const std::vector<glm::vec3> layers =
        options.layers.empty() ? std::vector<glm::vec3>() : layer_weights(options, volume);
    how.layers = layers;
    options.sh ? write_coefficients(sampler, volume.bands, points, how, options.dering)
               : write_irradiance(sampler, volume.bands, points, how, options.dering);
}

}  // namespace lightgrid
