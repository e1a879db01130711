#include "viewer/layer_mix.h"

#include "core/sh.h"
#include "viewer/environment_light.h"

#include <algorithm>
#include <optional>

namespace lightgrid {
namespace {

bool is_of_sky(const Layer& layer) {
    for (int i = 0; i < sh_size(sky_layer_bands); ++i) {
        if (layer.name == sky_layer(i)) return true;
    }
    return false;
}

}  // namespace

LayerKnob* find_sky(LayerMix& mix) noexcept {
    const auto sky =
        std::find_if(mix.knobs.begin(), mix.knobs.end(), [](const LayerKnob& knob) { return knob.name == sky_knob; });
    return sky == mix.knobs.end() ? nullptr : &*sky;
}

LayerMix mix_of(const Volume& volume, bool has_sky) {
    LayerMix mix;
    for (const Layer& layer : volume.layers) {
        if (!is_of_sky(layer)) mix.knobs.push_back({layer.name});
    }
    if (!has_sky_layers(volume)) return mix;
    mix.knobs.push_back({sky_knob, has_sky ? 1.0F : 0.0F});
    if (!has_sky) mix.sky = SkyShown::uniform;
    return mix;
}

glm::vec3 emission_weight(const LayerMix& mix, std::string_view group) noexcept {
    for (const std::string_view name : {group, std::string_view("other")}) {
        for (const LayerKnob& knob : mix.knobs) {
            if (knob.name == name) return knob.weight * knob.color;
        }
    }
    return glm::vec3(1);
}

std::vector<glm::vec3> weights_of(const LayerMix& mix, const Volume& volume, const Sh36& sky) {
    std::vector<glm::vec3> weights(volume.layers.size(), glm::vec3(0));
    for (const LayerKnob& knob : mix.knobs) {
        const glm::vec3 weight = knob.weight * knob.color;
        if (const std::optional<std::size_t> layer = find_layer(volume, knob.name)) {
            weights[*layer] = weight;
        } else if (knob.name == sky_knob) {
            Sh36 radiance = turned(sky, mix.sky_turned_deg);
            for (glm::vec3& coefficient : radiance) coefficient *= weight;
            set_sky(volume, radiance, weights);
        }
    }
    return weights;
}

Volume mixed_volume(const Volume& volume, std::span<const glm::vec3> weights) {
    // By name, so that layers are not copied; a new field does not compile until it is here.
    const auto& [bands, grids, bricks, list, states, coefficients, errors, axis_errors, offsets, layers, half,
                 settings] = volume;
    return {bands,  grids,       bricks,  list, states, mix_layers(volume, weights),
            errors, axis_errors, offsets, {},   half,   settings};
}

}  // namespace lightgrid
