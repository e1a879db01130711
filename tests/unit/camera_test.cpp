#include "viewer/camera.h"

#include "core/scene.h"
#include "viewer/eye.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lightgrid {
namespace {

void expect_near(glm::dvec3 got, glm::dvec3 wanted, double tolerance) {
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(got[axis], wanted[axis], tolerance) << "axis " << axis;
}

TEST(Camera, YawTurnsCounterClockwiseSeenFromAbove) {
    expect_near(forward({}), {0, 0, -1}, 1e-15);
    expect_near(forward({{}, 90, 0}), {-1, 0, 0}, 1e-15);
    expect_near(forward({{}, 180, 0}), {0, 0, 1}, 1e-15);
    expect_near(rightward({}), {1, 0, 0}, 1e-15);
    expect_near(rightward({{}, 90, 0}), {0, 0, -1}, 1e-15);
}

TEST(Camera, LooksWhereItIsToldTo) {
    const glm::dvec3 eye(1, 2, 3);
    for (const glm::dvec3 target : {glm::dvec3(4, 3, -2), glm::dvec3(-3, 1, 9), glm::dvec3(1, 2, 8)}) {
        expect_near(forward(looking_at(eye, target)), glm::normalize(target - eye), 1e-14);
    }
    EXPECT_EQ(looking_at(eye, eye).yaw_deg, 0);
    EXPECT_EQ(looking_at(eye, eye + glm::dvec3(0, 5, 0)).pitch_deg, most_pitch_deg);
}

TEST(Camera, PitchIsClampedAndYawStaysWithinATurn) {
    const Pose pose = turned({{}, 350, 80}, 20, 30);
    EXPECT_DOUBLE_EQ(pose.yaw_deg, 10);
    EXPECT_EQ(pose.pitch_deg, most_pitch_deg);
    EXPECT_DOUBLE_EQ(turned({}, -90, 0).yaw_deg, 270);
}

TEST(Camera, MovesAlongItsOwnAxesButUpIsTheLevels) {
    const Pose pose{{0, 0, 0}, 90, 45};
    expect_near(moved(pose, {1, 0, 0}).eye, {0, 0, -1}, 1e-15);
    expect_near(moved(pose, {0, 1, 0}).eye, {0, 1, 0}, 0);
    expect_near(moved(pose, {0, 0, 2}).eye, 2.0 * forward(pose), 1e-15);
}

TEST(Camera, RayThroughAPixelMeetsWhatTheMatrixPutsThere) {
    const Pose pose{{1e5, 2, -3e5}, 33, -12};  // far out: matrices are relative to an origin for this
    const glm::dvec3 origin(1e5, 0, -3e5);
    const Lens lens{55, 0.01, 500};
    const glm::ivec2 size(640, 360);
    const glm::mat4 matrix = clip_from_level(pose, lens, 640.0 / 360, origin);
    for (const glm::dvec2 pixel : {glm::dvec2(0, 0), glm::dvec2(639, 100), glm::dvec2(320, 359)}) {
        const glm::dvec3 point = pose.eye + 7.0 * ray_through(pose, lens, pixel, size);
        const glm::vec4 clip = matrix * glm::vec4(point - origin, 1);
        const glm::dvec2 at(0.5 * (clip.x / clip.w + 1) * size.x, 0.5 * (1 - clip.y / clip.w) * size.y);
        // Float matrices: a few times 2^-24 of a picture of 640 pixels.
        EXPECT_NEAR(at.x, pixel.x + 0.5, 1e-3);
        EXPECT_NEAR(at.y, pixel.y + 0.5, 1e-3);
    }
}

TEST(Eye, MissesBoxesOutOfSightAndNoneInSight) {
    const Eye eye = make_eye({{10, 0, 0}, 0, 0}, {90, 0.1, 100}, 1, {10, 0, 0}, 1);
    const auto box_at = [](glm::dvec3 center, double half) {
        Box box;
        box.extend(center - half);
        box.extend(center + half);
        return box;
    };
    EXPECT_FALSE(eye.misses(box_at({0, 0, -5}, 1)));
    EXPECT_FALSE(eye.misses(box_at({5.9, 0, -5}, 1)));  // an edge reaches in
    EXPECT_FALSE(eye.misses(box_at({0, 0, 0}, 50)));    // all around
    EXPECT_TRUE(eye.misses(box_at({0, 0, 5}, 1)));      // behind
    EXPECT_TRUE(eye.misses(box_at({8, 0, -5}, 1)));     // to the right
    EXPECT_TRUE(eye.misses(box_at({0, -8, -5}, 1)));    // below
    EXPECT_TRUE(eye.misses(box_at({0, 0, -200}, 1)));   // beyond
}

TEST(Eye, RaysSpanThePicture) {
    const Pose pose{{0, 0, 0}, 70, 20};
    const Lens lens{60, 0.1, 100};
    const Eye eye = make_eye(pose, lens, 2, {}, 1);
    const glm::ivec2 size(200, 100);
    const glm::dvec3 corner = ray_through(pose, lens, {-0.5, -0.5}, size);  // the upper left
    expect_near(glm::normalize(glm::dvec3(eye.ray * glm::vec3(-1, 1, 1))), corner, 1e-6);
}

}  // namespace
}  // namespace lightgrid
