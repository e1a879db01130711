#include "viewer/camera.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>

namespace lightgrid {
namespace {

constexpr glm::dvec3 up(0, 1, 0);

double whole_turn(double deg) {
    const double rest = std::fmod(deg, 360);
    return rest < 0 ? rest + 360 : rest;
}

}  // namespace

glm::dvec3 forward(const Pose& pose) {
    const double yaw = glm::radians(pose.yaw_deg);
    const double pitch = glm::radians(pose.pitch_deg);
    return {-std::sin(yaw) * std::cos(pitch), std::sin(pitch), -std::cos(yaw) * std::cos(pitch)};
}

glm::dvec3 rightward(const Pose& pose) {
    const double yaw = glm::radians(pose.yaw_deg);
    return {std::cos(yaw), 0, -std::sin(yaw)};
}

Pose looking_at(glm::dvec3 eye, glm::dvec3 target) {
    Pose pose{.eye = eye};
    const glm::dvec3 to = target - eye;
    if (!(glm::length(to) > 0)) return pose;
    const double level = std::hypot(to.x, to.z);
    if (level > 0) pose.yaw_deg = whole_turn(glm::degrees(std::atan2(-to.x, -to.z)));
    pose.pitch_deg = std::clamp(glm::degrees(std::atan2(to.y, level)), -most_pitch_deg, most_pitch_deg);
    return pose;
}

Pose turned(const Pose& pose, double yaw_deg, double pitch_deg) {
    Pose result = pose;
    result.yaw_deg = whole_turn(pose.yaw_deg + yaw_deg);
    result.pitch_deg = std::clamp(pose.pitch_deg + pitch_deg, -most_pitch_deg, most_pitch_deg);
    return result;
}

Pose moved(const Pose& pose, glm::dvec3 by) {
    Pose result = pose;
    result.eye += by.x * rightward(pose) + by.y * up + by.z * forward(pose);
    return result;
}

Lens lens_for(double diagonal, double object_size) {
    const double size = std::max(diagonal, 1e-6);
    Lens lens;
    lens.far = 4 * size;
    lens.near = std::min(2e-4 * size, 0.05 * object_size);
    return lens;
}

glm::mat4 clip_from_level(const Pose& pose, const Lens& lens, double aspect, glm::dvec3 origin) {
    const glm::dvec3 eye = pose.eye - origin;
    const glm::dmat4 view = glm::lookAt(eye, eye + forward(pose), up);
    return {glm::perspective(glm::radians(lens.vertical_angle_deg), aspect, lens.near, lens.far) * view};
}

glm::dvec3 ray_through(const Pose& pose, const Lens& lens, glm::dvec2 pixel, glm::ivec2 size) {
    const double half_height = std::tan(glm::radians(lens.vertical_angle_deg) / 2);
    const glm::dvec2 at = (2.0 * (pixel + 0.5) - glm::dvec2(size)) / static_cast<double>(size.y) * half_height;
    const glm::dvec3 along = forward(pose);
    const glm::dvec3 right = rightward(pose);
    return glm::normalize(along + at.x * right - at.y * glm::cross(right, along));
}

}  // namespace lightgrid
