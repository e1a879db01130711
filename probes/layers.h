#pragma once

#include "core/environment.h"
#include "core/scene.h"
#include "core/tracer.h"
#include "probes/kept_transport.h"
#include "probes/light_sources.h"
#include "probes/volume.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

/// Parts of the light that are stored apart. All are solved from one transport, so that their sum is all light.
namespace lightgrid {

/// What of the light shall be stored apart.
struct LayerChoice {
    bool direct_indirect = false;     // what comes straight from lights, emitters and sky; what surfaces reflect
    bool sky = false;                 // the light of any sky
    bool all_groups = false;          // of lights
    std::vector<std::string> groups;  // these

    [[nodiscard]] bool any() const { return direct_indirect || sky || all_groups || !groups.empty(); }
};

/// `combined`: nothing; `direct,indirect`; or a list of `sky`, `groups` for all of them, and names of groups. Throws
/// Error.
[[nodiscard]] LayerChoice parse_layers(const std::string& names);

/// A layer before it is baked.
struct LayerPlan {
    std::string name;
    std::uint32_t source = LightSources::off;  // whose light it is (LayersPlan::sources) ...
    bool direct = true;                        // what comes straight from it
    bool reflected = true;                     // by surfaces
    int sky = -1;                              // ... or that of a sky whose radiance is this basis function
};

struct LayersPlan {
    LightSources sources;  // to be traced apart: those of layers, what is in none, and the sky where it is a transfer
    std::vector<LayerPlan> layers;
};

/// Groups are layers by their names, and what is in none of these is `other`, if there is any. With a sky that can be
/// changed (sky_layer) no layer has the light of the environment: it is one of the skies to choose.
///
/// Throws Error for groups that the level does not have, listing those it has, and for too many.
[[nodiscard]] LayersPlan plan_layers(const LayerChoice& choice, const Scene& scene, const Environment& environment);

/// Solves for the light of each source alone and stores it at the probes of a volume that has the places of
/// kept.volume: all light together as its own, and its layers.
///
/// kept    traced with the sources of the plan
/// layers  of the plan
/// returns what patches reflect of all light
KeptLight light_layers(const KeptTransport& kept, const Tracer& tracer, const Environment& environment,
                       std::span<const LayerPlan> layers, Volume& volume);

}  // namespace lightgrid
