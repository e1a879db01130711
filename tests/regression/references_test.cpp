// Light at points of real levels against values that an independent renderer (Mitsuba 3) computed there: by paths, and by
// the surface cache that a bake would build.

#include "core/environment_file.h"
#include "core/gltf.h"
#include "core/sh.h"
#include "probes/bake.h"
#include "probes/cache_bias.h"
#include "probes/gather.h"

#include <fmt/format.h>
#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

const fs::path shared = LIGHTGRID_SHARED;

std::vector<std::string> reference_names() {
    std::vector<std::string> names;
    if (!fs::is_directory(shared / "references")) return {};
    for (const auto& entry : fs::directory_iterator(shared / "references")) {
        if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
    }
    std::sort(names.begin(), names.end());
    return names;
}

glm::dvec3 vec3(const nlohmann::json& value) {
    return {value.at(0), value.at(1), value.at(2)};
}

Environment reference_environment(const nlohmann::json& value) {
    if (value.is_null()) return {};
    if (value.is_object()) return Environment::uniform(glm::vec3(vec3(value.at("constant"))));
    return load_environment(shared / "data" / value.get<std::string>()).environment;
}

constexpr double one_percent = 0.01;

/// As many as a pilot says are needed for a noise of `wanted` in L_0 at the worst point, within reason.
std::uint32_t samples_for(double wanted, const Gather& pilot, std::uint32_t pilot_samples) {
    double worst = 0;
    for (std::size_t i = 0; i < pilot.coefficients.size(); i += static_cast<std::size_t>(sh_size(pilot.bands))) {
        worst = std::max(worst, glm::length(pilot.coefficients[i].error) / glm::length(pilot.coefficients[i].mean));
    }
    const double needed = pilot_samples * (worst / wanted) * (worst / wanted);
    return static_cast<std::uint32_t>(std::clamp(needed, 16384.0, 262144.0));
}

struct Agreement {
    int values = 0;
    int agree = 0;
    double signed_error = 0;  // of L_0, relative to its sum
    double worst_noise = 0;   // of L_0
    double square_off = 0;    // lux^2, mean over irradiances: that no noise explains
    double stated_bias = 0;   // Light::bias
    double relative_bias = 0;
    std::string outliers;
};

/// Light at the points of a level.
struct Light {
    Gather gather;
    double bias = 0;  // lux, root mean square over points and normals: at most, as the cache's own measurement has it
};

Light light_by_paths(const PathTracer& paths, const std::vector<glm::vec3>& points, GatherOptions options) {
    options.samples = 4096;
    options.seed = 1;
    options.samples = samples_for(one_percent, gather(paths, points, options), options.samples);
    options.seed = 0;
    return {gather(paths, points, options)};
}

Light light_by_cache(const PathTracer& paths, const std::vector<glm::vec3>& points, GatherOptions options) {
    BakeOptions bake;
    bake.target.samples = 1024;
    const BakePlan plan = plan_bake(paths, bake);
    std::vector<glm::vec3> all = plan.points;
    all.insert(all.end(), points.begin(), points.end());
    const SurfaceCache cache = build_surface_cache(paths, all, plan.cache);
    options.samples = 65536;
    options.rays.cache = &cache;
    Light light{gather(paths, points, options)};
    BiasOptions bias_options;
    bias_options.samples = 8192;
    const CacheBias bias = measure_bias(paths, cache, points, options.normals, bias_options);
    const std::size_t normals = options.normals.size();
    double sum = 0;
    double sum_of_squares = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        double square = 0;
        for (std::size_t k = i * normals; k < (i + 1) * normals; ++k) square += glm::dot(bias.a[k], bias.b[k]);
        square /= 3 * static_cast<double>(normals);
        sum += square;
        sum_of_squares += square * square;
    }
    const auto n = static_cast<double>(points.size());
    const double error = std::sqrt((sum_of_squares - sum * sum / n) / (n - 1) / n);
    light.bias = std::sqrt(std::max(0.0, sum / n + 2 * error));
    return light;
}

using LightAt = Light (*)(const PathTracer& paths, const std::vector<glm::vec3>& points, GatherOptions options);

Agreement compare_level(const std::string& name, LightAt light_at) {
    const nlohmann::json reference = nlohmann::json::parse(std::ifstream(shared / "references" / (name + ".json")));
    LoadOptions white;  // as the references take levels without materials
    white.default_albedo = 1;
    const Scene scene = load_level(shared / "data" / reference.at("level").get<std::string>(), white);
    const Environment environment = reference_environment(reference.at("environment"));
    const Tracer tracer(scene);
    const PathTracer paths(tracer, environment);

    std::vector<glm::vec3> points;
    for (const auto& point : reference.at("points")) points.emplace_back(vec3(point.at("p")) - scene.origin);
    GatherOptions options;
    options.replicates = 32;
    options.normals.assign(axis_normals.begin(), axis_normals.end());
    const Light light = light_at(paths, points, options);
    const Gather& ours = light.gather;

    Agreement result;
    result.stated_bias = light.bias;
    double ambient_sum = 0;
    double square = 0;  // of irradiance, mean
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& point = reference.at("points").at(i);
        double mean_irradiance = 0;
        for (const auto& [direction, value] : point.at("irradiance").items()) {
            const glm::dvec3 v = vec3(value);
            mean_irradiance += (v.x + v.y + v.z) / 18;
        }
        // bias: of this value, root mean square
        const auto compare = [&](const std::string& what, const Estimate& estimate, const nlohmann::json& mean,
                                 const nlohmann::json& error, double bias) {
            const glm::dvec3 expected = vec3(mean);
            const glm::dvec3 expected_error = vec3(error);
            for (int c = 0; c < 3; ++c) {
                const double noise = std::hypot(estimate.error[c], expected_error[c]);
                const double tolerance = 3 * std::hypot(noise, bias) + 1e-4 * mean_irradiance;
                ++result.values;
                if (std::abs(estimate.mean[c] - expected[c]) <= tolerance) {
                    ++result.agree;
                } else {
                    result.outliers +=
                        fmt::format("{} point {} {} colour {}: {} +- {}, reference {} +- {}\n", name, i, what, c,
                                    estimate.mean[c], estimate.error[c], expected[c], expected_error[c]);
                }
            }
        };
        for (std::size_t k = 0; k < 9; ++k) {
            // What an error of it adds to irradiance, over all directions, is cosine_lobe / sqrt(4 pi) of it.
            const double lobe = cosine_lobe(k == 0 ? 0 : k < 4 ? 1 : 2);
            compare(fmt::format("coefficient {}", k), ours.sh(i)[k], point.at("sh").at(k), point.at("sh_se").at(k),
                    light.bias * std::sqrt(4 * glm::pi<double>()) / lobe);
        }
        const std::array<const char*, 6> names = {"+x", "-x", "+y", "-y", "+z", "-z"};
        for (std::size_t k = 0; k < 6; ++k) {
            const Estimate& irradiance = ours.irradiance[i * 6 + k];
            compare(names[k], irradiance, point.at("irradiance").at(names[k]), point.at("irradiance_se").at(names[k]),
                    light.bias);
            const glm::dvec3 off = irradiance.mean - vec3(point.at("irradiance").at(names[k]));
            const glm::dvec3 error = vec3(point.at("irradiance_se").at(names[k]));
            const double noise = glm::dot(irradiance.error, irradiance.error) + glm::dot(error, error);
            square += glm::dot(irradiance.mean, irradiance.mean) / (18 * static_cast<double>(points.size()));
            result.square_off += (glm::dot(off, off) - noise) / (18 * static_cast<double>(points.size()));
        }
        const glm::dvec3 ambient = vec3(point.at("sh").at(0));
        for (int c = 0; c < 3; ++c) {
            result.signed_error += ours.sh(i)[0].mean[c] - ambient[c];
            ambient_sum += ambient[c];
            const double floor = 1e-4 * mean_irradiance;
            result.worst_noise = std::max(result.worst_noise, ours.sh(i)[0].error[c] / std::max(ambient[c], floor));
        }
    }
    result.signed_error /= ambient_sum;
    result.relative_bias = light.bias / std::sqrt(square);
    fmt::print(
        "{:36} {} of {} within 3 standard errors, mean signed error {:+.3f} %, worst noise {:.2f} % of L_0; off by "
        "{:.3g} lx, stated {:.3g}\n",
        name, result.agree, result.values, 100 * result.signed_error, 100 * result.worst_noise,
        std::sqrt(std::max(0.0, result.square_off)), result.stated_bias);
    return result;
}

void compare_all_levels(LightAt light_at) {
    const std::vector<std::string> names = reference_names();
    if (names.empty()) GTEST_SKIP() << "no reference values in " << shared;
    int values = 0;
    int agree = 0;
    double signed_error = 0;
    std::string outliers;
    for (const std::string& name : names) {
        const Agreement level = compare_level(name, light_at);
        values += level.values;
        agree += level.agree;
        signed_error += level.signed_error / static_cast<double>(names.size());
        outliers += level.outliers;
        EXPECT_LT(level.worst_noise, 0.03) << name;
        // The references' rays start 5e-5 of the level's diagonal off surfaces and their shadow rays end 9e-4 short of
        // emitters. In the garage, whose window frame cuts through the emitter, that alone brings 0.5 to 1 % more
        // light.
        EXPECT_LT(std::abs(level.signed_error), 0.01 + level.relative_bias) << name;
    }
    // A point's values are correlated, so they are counted over all levels.
    EXPECT_GE(agree, 0.99 * values) << outliers;
    EXPECT_LT(std::abs(signed_error), 0.005);
}

TEST(References, PathsAgreeWithinThreeStandardErrors) {
    compare_all_levels(light_by_paths);
}

TEST(References, CachesAgreeWithinThreeStandardErrorsAndTheirStatedBias) {
    compare_all_levels(light_by_cache);
}

}  // namespace
}  // namespace lightgrid
