#include "probes/light_sources.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace lightgrid {
namespace {

/// What a part of the light belonged to, and of which it brings so much now; none: no factor gives it.
struct Part {
    std::uint32_t source = LightSources::off;
    std::optional<glm::vec3> factor;
    std::uint32_t* other = nullptr;  // what to set where it has to be traced; null: it is gone
};

std::optional<glm::vec3> factor_of(glm::vec3 before, glm::vec3 now) {
    glm::vec3 factor(0);
    for (int c = 0; c < 3; ++c) {
        if (before[c] > 0) {
            factor[c] = now[c] / before[c];
        } else if (now[c] != 0) {
            return {};
        }
    }
    return factor;
}

/// The same light, but for how strong it is.
bool same_but_for_intensity(const Light& a, const Light& b) {
    return a.kind == b.kind && a.position == b.position && a.direction == b.direction && a.range == b.range &&
           a.cos_inner == b.cos_inner && a.cos_outer == b.cos_outer;
}

}  // namespace

LightSources separate_sources(const Scene& scene, const Environment& environment) {
    LightSources sources;
    std::uint32_t found = 0;
    const auto next = [&] { return std::min(found++, LightSources::most - 1); };
    sources.of_sky = environment.is_black() ? LightSources::off : next();
    for (const Material& material : scene.materials) {
        sources.of_material.push_back(material.emits() ? next() : LightSources::off);
    }
    for (const Light& light : scene.lights) {
        sources.of_light.push_back(light.intensity != glm::vec3(0) ? next() : LightSources::off);
    }
    sources.count = std::clamp(found, 1U, LightSources::most);
    return sources;
}

LightState light_of(const Scene& scene, const Environment& environment, const LightSources& sources) {
    LightState light{sources, {}, scene.lights, environment.shape(), environment.scale()};
    for (const Material& material : scene.materials) light.emission.push_back(material.emission);
    for (Light& l : light.lights) l.name.clear();
    return light;
}

LightChange compare_light(const LightState& before, const Scene& scene, const Environment& environment) {
    LightChange change;
    change.factor.assign(before.sources.count, glm::vec3(0));
    LightSources& others = change.others;
    others.of_material.assign(scene.materials.size(), LightSources::off);
    others.of_light.assign(scene.lights.size(), LightSources::off);
    others.of_sky = LightSources::off;

    std::vector<Part> parts;
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        const glm::vec3 now = scene.materials[i].emission;
        const std::uint32_t source = before.sources.material(static_cast<int>(i));
        if (source == LightSources::off && now == glm::vec3(0)) continue;
        parts.push_back(
            {source, factor_of(before.emission[i], now), now != glm::vec3(0) ? &others.of_material[i] : nullptr});
    }
    std::vector<char> found(before.lights.size());
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        Part part;
        part.other = light.intensity != glm::vec3(0) ? &others.of_light[i] : nullptr;
        for (std::size_t k = 0; k < before.lights.size(); ++k) {
            if (found[k] != 0 || !same_but_for_intensity(before.lights[k], light)) continue;
            found[k] = 1;
            part.source = before.sources.light(k);
            part.factor = factor_of(before.lights[k].intensity, light.intensity);
            break;
        }
        parts.push_back(part);
    }
    for (std::size_t k = 0; k < before.lights.size(); ++k) {
        if (found[k] == 0) parts.push_back({before.sources.light(k), glm::vec3(0), nullptr});
    }
    Part sky{before.sources.of_sky, {}, environment.is_black() ? nullptr : &others.of_sky};
    if (environment.is_black()) {
        sky.factor = glm::vec3(0);
    } else if (environment.shape() == before.sky_shape) {
        sky.factor = factor_of(before.sky_scale, environment.scale());
    }
    parts.push_back(sky);

    std::vector<std::optional<glm::vec3>> common(before.sources.count);
    std::vector<char> differs(before.sources.count);
    for (const Part& part : parts) {
        if (part.source == LightSources::off) continue;
        std::optional<glm::vec3>& factor = common[part.source];
        if (!part.factor || (factor && *factor != *part.factor)) differs[part.source] = 1;
        if (!factor) factor = part.factor;
    }
    for (std::uint32_t s = 0; s < before.sources.count; ++s) {
        if (common[s] && differs[s] == 0) change.factor[s] = *common[s];
    }
    for (const Part& part : parts) {
        if (part.other == nullptr) continue;
        if (part.source != LightSources::off && differs[part.source] == 0) continue;
        *part.other = 0;
        change.any_other = true;
    }
    change.sky_is_new = others.of_sky != LightSources::off;
    return change;
}

}  // namespace lightgrid
