#include "viewer/object_shadow.h"

#include "core/sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lightgrid {
namespace {

/// In radii. The shadow of the distant light is (r / (0.25 d))^2 dark at most (contact_shadow.glsl): 4 % here. What the
/// object hides of an even sky is (r / d)^2 of it: 2 %.
constexpr double reach = 20;
constexpr double sky_reach = 7;
/// Of the shadow, from half a radius before the centre on: its width, and by how much that grows with the distance, both
/// as in contact_shadow.glsl.
constexpr float shadow_start = -0.5F;
constexpr float shadow_width = 1.02F;
constexpr float shadow_growth = 0.25F;

}  // namespace

bool ObjectShadow::reaches(const Box& box) const {
    const glm::dvec3 nearest = glm::clamp(glm::dvec3(center), box.min, box.max);
    return glm::distance(nearest, glm::dvec3(center)) < reach * static_cast<double>(radius);
}

bool ObjectShadow::reaches(glm::vec3 at, float around) const {
    const glm::vec3 to_object = (center - at) / radius;
    const float extent = around / radius;
    const float squared = glm::dot(to_object, to_object);
    const auto within = [&](double distance) {
        const float most = static_cast<float>(distance) + extent;
        return squared < most * most;
    };
    if (within(sky_reach)) return true;
    const float along = glm::dot(to_object, light.direction);
    const float beside = std::sqrt(std::max(squared - along * along, 0.0F));
    return within(reach) && along + extent > shadow_start &&
           beside < shadow_width + shadow_growth * std::max(along + extent, 0.0F) + extent;
}

ShadowSplit split_by_shadow(const LevelMesh& mesh, std::span<const LevelDraw* const> draws,
                            const ObjectShadow& shadow) {
    ShadowSplit split;
    std::vector<std::uint32_t> rest;
    const auto keep = [&](LevelDraw draw, std::span<const std::uint32_t> indices, std::vector<LevelDraw>& draws_of) {
        if (indices.empty()) return;
        draw.first_index = static_cast<std::uint32_t>(split.indices.size());
        draw.index_count = static_cast<std::uint32_t>(indices.size());
        split.indices.insert(split.indices.end(), indices.begin(), indices.end());
        draws_of.push_back(draw);
    };
    std::vector<std::uint32_t> darkened;
    for (const LevelDraw* draw : draws) {
        for (const LevelDraw& place : in_each_place(*draw)) {
            const glm::mat4x3& to_level = mesh.instances[static_cast<std::size_t>(place.first_instance)];
            darkened.clear();
            rest.clear();
            for (std::size_t i = place.first_index; i < place.first_index + place.index_count; i += 3) {
                std::array<glm::vec3, 3> corners{};
                for (std::size_t k = 0; k < 3; ++k) {
                    corners[k] = to_level * glm::vec4(mesh.vertices[mesh.indices[i + k]].position, 1);
                }
                const glm::vec3 middle = (corners[0] + corners[1] + corners[2]) / 3.0F;
                float around = 0;
                for (const glm::vec3& corner : corners) around = std::max(around, glm::distance(middle, corner));
                std::vector<std::uint32_t>& part = shadow.reaches(middle, around) ? darkened : rest;
                part.insert(part.end(), {mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]});
            }
            keep(place, darkened, split.shaded);
            keep(place, rest, split.others);
        }
    }
    return split;
}

void set_shadow(const Uniforms& uniforms, const ObjectShadow& shadow) {
    uniforms.set("shadow_center", shadow.center);
    uniforms.set("shadow_scale", 1 / shadow.radius);
    uniforms.set("shadow_fading", static_cast<float>(2 / (reach * reach)));
    uniforms.set("sky_fading", static_cast<float>(2 / (sky_reach * sky_reach)));
    uniforms.set("shadow_direction", shadow.light.direction);
    const float rest = std::max(std::numbers::pi_v<float> * luminance(shadow.light.ambient), 1e-30F);
    uniforms.set("shadow_contrast", std::min(luminance(shadow.light.illuminance) / rest, 1e4F));
}

}  // namespace lightgrid
