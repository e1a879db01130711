#include "core/gltf/lights.h"

#include "core/error.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace lightgrid::gltf {
namespace {

LightKind kind_of(const std::string& type) {
    if (type == "directional") return LightKind::directional;
    return type == "spot" ? LightKind::spot : LightKind::point;
}

/// Source: KHR_lights_punctual. A light shines along -Z of its node; the node's own scale has no part in it.
Light read_light(const tinygltf::Light& source, const PlacedNode& placed, const glm::dvec3& origin) {
    Light light;
    light.kind = kind_of(source.type);
    for (int i = 0; i < 3; ++i) {
        const double color = source.color.empty() ? 1 : source.color[static_cast<std::size_t>(i)];
        light.intensity[i] = static_cast<float>(source.intensity * color);
        if (!std::isfinite(light.intensity[i]))
            throw Error(fmt::format("its light has an intensity of {:g} x {:g}", source.intensity, color), "",
                        "Lower its intensity.");
    }
    light.position = glm::vec3(glm::dvec3(placed.unscaled[3]) - origin);
    if (light.kind != LightKind::point) {
        const glm::dvec3 direction = -glm::dvec3(placed.unscaled[2]);
        if (!(glm::length(direction) > 0))
            throw Error("its light has no direction: a parent scales it to nothing", "", "Give the parent a scale.");
        light.direction = glm::vec3(glm::normalize(direction));
    }
    if (source.range > 0) light.range = static_cast<float>(source.range);
    if (light.kind == LightKind::spot) {
        light.cos_inner = static_cast<float>(std::cos(source.spot.innerConeAngle));
        light.cos_outer = static_cast<float>(std::cos(source.spot.outerConeAngle));
    }
    return light;
}

}  // namespace

void read_lights(const Document& document, const std::vector<PlacedNode>& nodes, Scene& scene, Notices& notices) {
    std::size_t dark = 0;
    for (const PlacedNode& placed : nodes) {
        const tinygltf::Node& node = document.node(placed.index);
        const tinygltf::Value* extension = find_extension(node.extensions, "KHR_lights_punctual");
        if (extension == nullptr || placed.hidden || is_scaled_away(placed.transform)) continue;
        const std::string place = document.node_name(placed.index);
        try {
            const tinygltf::Light& source = document.light(extension->Get("light").GetNumberAsInt());
            Light light = read_light(source, placed, scene.origin);
            light.name = node.name.empty() ? source.name : node.name;
            light.group = placed.group;
            if (light.kind == LightKind::spot && source.spot.innerConeAngle >= source.spot.outerConeAngle)
                notices.add(place, "the inner cone of its light is not inside the outer one: its edge is sharp");
            if (light.intensity == glm::vec3(0))
                ++dark;
            else
                scene.lights.push_back(std::move(light));
        } catch (const Error& error) {
            throw error.inside(place);
        }
    }
    if (dark > 0) scene.left_out.push_back({"lights", "their intensity is 0", fmt::format("{} lights", dark)});
}

}  // namespace lightgrid::gltf
