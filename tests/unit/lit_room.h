#pragma once

#include "core/environment.h"
#include "core/scene.h"
#include "core/sh.h"
#include "probes/volume.h"
#include "tests/scene_builder.h"

#include <cmath>

/// A room with light of all kinds, to be baked in many lights, and how far two of its bakes are from each other.
namespace lightgrid {

/// Materials of `room`, in its order.
enum RoomMaterial { none, wall, lamp, neon };

struct Room {
    Scene scene;
    Environment sky;
};

/// Walls and a floor under the sky, with a block, a lamp, a tube that is off, and a point light.
inline Room room() {
    Room room{{}, Environment::uniform(glm::vec3(0.5F, 0.5F, 1))};
    Scene& scene = room.scene;
    scene.name = "room";
    add_grey(scene, 0.5F);
    Material grey;
    grey.base_color = {0.7F, 0.6F, 0.5F};
    add_material(scene, grey);
    add_grey(scene, 0.3F, 8);
    add_grey(scene, 0.3F);
    add_quad(scene, wall, {-2, 0, -2}, {0, 0, 4}, {4, 0, 0});
    add_quad(scene, wall, {-2, 0, -2}, {4, 0, 0}, {0, 2, 0});
    add_quad(scene, wall, {2, 0, 2}, {-4, 0, 0}, {0, 2, 0});
    add_quad(scene, wall, {-2, 0, 2}, {0, 0, -4}, {0, 2, 0});
    add_quad(scene, wall, {2, 0, -2}, {0, 0, 4}, {0, 2, 0});
    add_box(scene, wall, {-0.4F, 0, -0.4F}, {0.5F, 0.9F, 0.3F}, Facing::outward);
    add_quad(scene, lamp, {-1.5F, 1.9F, -1.5F}, {0.5F, 0, 0}, {0, 0, 0.5F});
    add_quad(scene, neon, {1, 1.9F, 0.5F}, {0.2F, 0, 0}, {0, 0, 1});
    scene.lights.push_back(point_light({1.2F, 1.5F, -1.2F}, 3));
    return room;
}

/// Difference of irradiance over all directions, over its root mean square in b; at the probes that both have gathered
/// at the same place (where there is no sky, others are taken to be outside).
inline double difference(const Volume& a, const Volume& b) {
    double squares = 0;
    double power = 0;
    for (std::size_t slot = 0; slot < b.slots(); ++slot) {
        if (!is_valid(a.states[slot]) || !is_valid(b.states[slot])) continue;
        if (gather_position(a, slot) != gather_position(b, slot)) continue;
        for (std::size_t i = 0; i < b.sh_size(); ++i) {
            const double lobe = cosine_lobe(static_cast<int>(std::sqrt(static_cast<double>(i) + 0.5)));
            const glm::dvec3 v(b.sh(slot)[i]);
            const glm::dvec3 d = glm::dvec3(a.sh(slot)[i]) - v;
            squares += lobe * lobe * glm::dot(d, d);
            power += lobe * lobe * glm::dot(v, v);
        }
    }
    return std::sqrt(squares / power);
}

}  // namespace lightgrid
