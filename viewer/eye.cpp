#include "viewer/eye.h"

#include "core/scene.h"

#include <cmath>

namespace lightgrid {

bool Eye::misses(const Box& box) const {
    const glm::dmat4 rows = glm::transpose(glm::dmat4(clip_from_level));
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {-1.0, 1.0}) {
            const glm::dvec4 plane = rows[3] + side * rows[axis];
            const glm::dvec3 farthest = glm::mix(box.min, box.max, glm::greaterThan(glm::dvec3(plane), glm::dvec3(0)));
            if (glm::dot(plane, glm::dvec4(farthest, 1)) < 0) return true;
        }
    }
    return false;
}

Eye make_eye(const Pose& pose, const Lens& lens, double aspect, glm::dvec3 origin, float exposure) {
    Eye eye;
    eye.origin = origin;
    eye.clip_from_level = clip_from_level(pose, lens, aspect, origin);
    eye.position = glm::vec3(pose.eye - origin);
    eye.exposure = exposure;
    const double half_height = std::tan(glm::radians(lens.vertical_angle_deg) / 2);
    const glm::dvec3 along = forward(pose);
    const glm::dvec3 right = rightward(pose);
    eye.ray = glm::mat3(aspect * half_height * right, half_height * glm::cross(right, along), along);
    return eye;
}

}  // namespace lightgrid
