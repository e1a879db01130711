// Light at points of real levels against values that an independent renderer (Mitsuba 3) computed there.

#include "core/environment_file.h"
#include "core/gltf.h"
#include "core/sh.h"
#include "probes/gather.h"

#include <fmt/format.h>
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
    std::string outliers;
};

Agreement compare_level(const std::string& name) {
    const nlohmann::json reference = nlohmann::json::parse(std::ifstream(shared / "references" / (name + ".json")));
    const Scene scene = load_level(shared / "data" / reference.at("level").get<std::string>());
    const Environment environment = reference_environment(reference.at("environment"));
    const Tracer tracer(scene);
    const PathTracer paths(tracer, environment);

    std::vector<glm::vec3> points;
    for (const auto& point : reference.at("points")) points.emplace_back(vec3(point.at("p")) - scene.origin);
    GatherOptions options;
    options.samples = 4096;
    options.replicates = 32;
    options.seed = 1;
    options.samples = samples_for(one_percent, gather(paths, points, options), options.samples);
    options.seed = 0;
    options.normals.assign(axis_normals.begin(), axis_normals.end());
    const Gather ours = gather(paths, points, options);

    Agreement result;
    double ambient_sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& point = reference.at("points").at(i);
        double mean_irradiance = 0;
        for (const auto& [direction, value] : point.at("irradiance").items()) {
            const glm::dvec3 v = vec3(value);
            mean_irradiance += (v.x + v.y + v.z) / 18;
        }
        const auto compare = [&](const std::string& what, const Estimate& estimate, const nlohmann::json& mean,
                                 const nlohmann::json& error) {
            const glm::dvec3 expected = vec3(mean);
            const glm::dvec3 expected_error = vec3(error);
            for (int c = 0; c < 3; ++c) {
                const double tolerance = 3 * std::hypot(estimate.error[c], expected_error[c]) + 1e-4 * mean_irradiance;
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
            compare(fmt::format("coefficient {}", k), ours.sh(i)[k], point.at("sh").at(k), point.at("sh_se").at(k));
        }
        const std::array<const char*, 6> names = {"+x", "-x", "+y", "-y", "+z", "-z"};
        for (std::size_t k = 0; k < 6; ++k) {
            compare(names[k], ours.irradiance[i * 6 + k], point.at("irradiance").at(names[k]),
                    point.at("irradiance_se").at(names[k]));
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
    fmt::print("{:36} {} of {} within 3 standard errors, mean signed error {:+.3f} %, worst noise {:.2f} % of L_0\n",
               name, result.agree, result.values, 100 * result.signed_error, 100 * result.worst_noise);
    return result;
}

TEST(References, AgreeWithinThreeStandardErrors) {
    const std::vector<std::string> names = reference_names();
    if (names.empty()) GTEST_SKIP() << "no reference values in " << shared;
    int values = 0;
    int agree = 0;
    double signed_error = 0;
    std::string outliers;
    for (const std::string& name : names) {
        const Agreement level = compare_level(name);
        values += level.values;
        agree += level.agree;
        signed_error += level.signed_error / static_cast<double>(names.size());
        outliers += level.outliers;
        EXPECT_LT(level.worst_noise, 0.03) << name;
        // The references' rays start 5e-5 of the level's diagonal off surfaces and their shadow rays end 9e-4 short of
        // emitters. In the garage, whose window frame cuts through the emitter, that alone brings 0.5 to 1 % more
        // light.
        EXPECT_LT(std::abs(level.signed_error), 0.01) << name;
    }
    // A point's values are correlated, so they are counted over all levels.
    EXPECT_GE(agree, 0.99 * values) << outliers;
    EXPECT_LT(std::abs(signed_error), 0.005);
}

}  // namespace
}  // namespace lightgrid
