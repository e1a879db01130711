#include "probes/layers.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/sh.h"
#include "probes/error_report.h"
#include "probes/gather_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

namespace lightgrid {
namespace {

constexpr const char* syntax = "Give combined, direct,indirect, or a list of sky, groups and names of groups";

std::vector<std::string> split(const std::string& names) {
    std::vector<std::string> list;
    for (std::size_t begin = 0; begin <= names.size();) {
        const std::size_t end = std::min(names.find(',', begin), names.size());
        list.push_back(names.substr(begin, end - begin));
        begin = end + 1;
    }
    return list;
}

std::vector<int> find_groups(const LayerChoice& choice, const Scene& scene) {
    std::vector<int> found;
    for (std::size_t i = 0; choice.all_groups && i < scene.groups.size(); ++i) found.push_back(static_cast<int>(i));
    for (const std::string& name : choice.groups) {
        const auto group = std::find(scene.groups.begin(), scene.groups.end(), name);
        if (group == scene.groups.end()) {
            throw Error(fmt::format("there is no group \"{}\" of lights", name), scene.name,
                        scene.groups.empty() ? R"(Give nodes extras {"lightgrid": {"group": "NAME"}}.)"
                                             : fmt::format("Choose among: {}.", fmt::join(scene.groups, ", ")));
        }
        const auto index = static_cast<int>(group - scene.groups.begin());
        if (std::find(found.begin(), found.end(), index) == found.end()) found.push_back(index);
    }
    if (choice.all_groups && found.empty()) {
        throw Error("has no groups of lights", scene.name,
                    R"(Give nodes extras {"lightgrid": {"group": "NAME"}}, or leave groups out of --layers.)");
    }
    constexpr std::size_t most = LightSources::most - 2;  // what is in none of them, and the sky
    if (found.size() > most) {
        throw Error(fmt::format("{} groups of lights, but {} can be layers", found.size(), most), scene.name,
                    "Name fewer in --layers.");
    }
    return found;
}

float basis_function(int i, glm::vec3 direction) {
    std::array<float, sh_size(sky_layer_bands)> basis;
    sh_basis(sky_layer_bands, direction, basis);
    return basis[static_cast<std::size_t>(i)];
}

/// Stores all light that probes see.
void light_all(const KeptTransport& kept, const LightSeen& seen, Volume& volume) {
    for (const KeptGather& gather : kept.gathers) {
        const GatherLight light(gather, seen, volume.bands);
        for_each_index(gather.slots.size(), [&](std::size_t point) {
            const std::vector<Estimate> values = light.at(point);
            store(std::span(values).first(volume.sh_size()), std::span(values).subspan(volume.sh_size()),
                  gather.slots[point], volume);
        });
    }
}

void light_layer(const KeptTransport& kept, const LightSeen& seen, const Volume& volume, Layer& layer) {
    const std::size_t n = volume.sh_size();
    double variance = 0;
    double energy = 0;
    for (const KeptGather& gather : kept.gathers) {
        const GatherLight light(gather, seen, volume.bands);
        std::vector<glm::dvec2> squares(gather.slots.size());  // of error and irradiance
        for_each_index(squares.size(), [&](std::size_t point) {
            const std::vector<Estimate> values = light.at(point);
            const std::span<glm::vec3> sh = std::span(layer.coefficients).subspan(gather.slots[point] * n, n);
            std::vector<glm::vec3> errors(n);
            for (std::size_t i = 0; i < n; ++i) {
                sh[i] = glm::vec3(values[i].mean);
                errors[i] = glm::vec3(values[i].error);
            }
            squares[point] = {mean_square_irradiance(errors), mean_square_irradiance(sh)};
        });
        for (const glm::dvec2& square : squares) {
            variance += square.x;
            energy += square.y;
        }
    }
    layer.noise = energy > 0 ? std::sqrt(variance / energy) : 0;
}

}  // namespace

LayerChoice parse_layers(const std::string& names) {
    LayerChoice choice;
    if (names == combined_layer) return choice;
    const std::vector<std::string> list = split(names);
    const auto has = [&](const char* name) { return std::find(list.begin(), list.end(), name) != list.end(); };
    if (has("direct") || has("indirect")) {
        if (list.size() != 2 || !has("direct") || !has("indirect")) {
            throw Error("direct,indirect are two halves, and no other layer goes with them", "", syntax);
        }
        choice.direct_indirect = true;
        return choice;
    }
    for (const std::string& name : list) {
        if (name.empty()) throw Error(fmt::format("\"{}\" has an empty name", names), "", syntax);
        if (name == combined_layer) throw Error("combined is always there: it goes with no other layer", "", syntax);
        if (name == "other") throw Error("other is what is in no layer: it comes by itself", "", syntax);
        if (name == "sky") {
            choice.sky = true;
        } else if (name == "groups") {
            choice.all_groups = true;
        } else {
            choice.groups.push_back(name);
        }
    }
    return choice;
}

LayersPlan plan_layers(const LayerChoice& choice, const Scene& scene, const Environment& environment) {
    LayersPlan plan;
    if (!choice.any()) return plan;
    if (choice.direct_indirect) {
        plan.layers = {{"direct", 0, true, false}, {"indirect", 0, false, true}};
        return plan;
    }
    LightSources& sources = plan.sources;
    std::vector<std::uint32_t> source_of_group(scene.groups.size(), LightSources::off);
    sources.count = 0;
    for (const int group : find_groups(choice, scene)) {
        source_of_group[static_cast<std::size_t>(group)] = sources.count;
        plan.layers.push_back({scene.groups[static_cast<std::size_t>(group)], sources.count++});
    }
    const std::uint32_t other = sources.count++;
    bool any_other = false;
    const auto source_of = [&](bool shines, int group) {
        if (!shines) return LightSources::off;
        const std::uint32_t source = group < 0 ? LightSources::off : source_of_group[static_cast<std::size_t>(group)];
        if (source != LightSources::off) return source;
        any_other = true;
        return other;
    };
    for (const Material& material : scene.materials) {
        sources.of_material.push_back(source_of(material.emits(), material.group));
    }
    for (const Light& light : scene.lights) {
        sources.of_light.push_back(source_of(light.intensity != glm::vec3(0), light.group));
    }
    if (choice.sky && !environment.is_black()) {
        sources.of_sky = sources.count++;
    } else {
        sources.of_sky = source_of(!environment.is_black(), -1);
    }
    if (any_other) plan.layers.push_back({"other", other});
    for (int i = 0; choice.sky && i < sh_size(sky_layer_bands); ++i) {
        plan.layers.push_back({sky_layer(i), LightSources::off, true, true, i});
    }
    return plan;
}

KeptLight light_layers(const KeptTransport& kept, const Tracer& tracer, const Environment& environment,
                       std::span<const LayerPlan> layers, Volume& volume) {
    KeptLight all;
    all.made = kept.made;
    all.made.counts = {};
    all.made.sweeps = 0;
    const auto solved = [&](std::span<const glm::dvec3> direct) {
        TransportSolution solution = solve(kept.transport, direct, kept.options.accuracy);
        all.made.sweeps += solution.sweeps;
        all.made.residual = std::max(all.made.residual, solution.residual);
        return std::vector<glm::vec3>(solution.light.begin(), solution.light.end());
    };
    const std::size_t sources = kept.direct.size();
    std::vector<std::vector<glm::vec3>> reflected;  // by source
    std::vector<glm::dvec3> sum(kept.transport.patches());
    for (const std::vector<glm::vec3>& direct : kept.direct) {
        const std::vector<glm::vec3>& light =
            reflected.emplace_back(solved(std::vector<glm::dvec3>(direct.begin(), direct.end())));
        for (std::size_t patch = 0; patch < sum.size(); ++patch) sum[patch] += glm::dvec3(light[patch]);
    }
    all.radiance.assign(sum.begin(), sum.end());

    const SkyLight sky = sky_of_rays(environment);
    const auto sky_along = [&](glm::vec3 direction) { return sky.along(direction); };
    const std::vector<glm::vec3> every_source(sources, glm::vec3(1));
    light_all(kept, {all.radiance, every_source, sky_along}, volume);

    volume.layers.clear();
    for (const LayerPlan& plan : layers) {
        Layer& layer = volume.layers.emplace_back();
        layer.name = plan.name;
        layer.coefficients.resize(volume.coefficients.size(), glm::vec3(0));
        std::vector<glm::vec3> straight(sources, glm::vec3(0));
        LightSeen seen{{}, straight};
        std::vector<glm::vec3> of_sky;
        if (plan.sky >= 0) {
            seen.sky = [&](glm::vec3 direction) { return glm::vec3(basis_function(plan.sky, direction)); };
            of_sky = solved(direct_from_sky(tracer, kept.transport, kept.places, seen.sky, kept.options));
            seen.reflected = of_sky;
        } else {
            if (plan.reflected) seen.reflected = reflected[plan.source];
            if (plan.direct) straight[plan.source] = glm::vec3(1);
            if (plan.direct && plan.source == kept.light.sources.of_sky) seen.sky = sky_along;
        }
        light_layer(kept, seen, volume, layer);
    }
    return all;
}

}  // namespace lightgrid
