#pragma once

#include "viewer/camera.h"

#include <glm/glm.hpp>

#include <array>

namespace lightgrid {

struct Box;

/// What every drawing needs to know of who looks. Positions on the card are relative to `origin`.
struct Eye {
    glm::dvec3 origin{0};  // Scene::origin
    glm::mat4 clip_from_level{1};
    glm::vec3 position{0};  // of the eye, relative to origin
    float exposure = 1;     // radiance is multiplied by it before it is written, so that half holds it
    glm::mat3 ray{1};       // columns: right, up, forward; the first two as long as half the picture is wide and high

    /// Nothing of `box` (relative to origin) can be seen: it is wholly outside of one of the frustum's planes.
    [[nodiscard]] bool misses(const Box& box) const;
};

[[nodiscard]] Eye make_eye(const Pose& pose, const Lens& lens, double aspect, glm::dvec3 origin, float exposure);

}  // namespace lightgrid
