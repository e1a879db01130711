#include "core/error.h"

#include <gtest/gtest.h>

namespace lightgrid {
namespace {

TEST(Error, ReadsWhereThenProblemThenRemedy) {
    const Error error("index 912, but only 880 vertices", "mesh \"arch\"", "Re-export the mesh.");
    EXPECT_STREQ(error.what(), "mesh \"arch\": index 912, but only 880 vertices. Re-export the mesh.");
    EXPECT_STREQ(error.inside("hall.glb").what(),
                 "hall.glb: mesh \"arch\": index 912, but only 880 vertices. Re-export the mesh.");
}

TEST(Error, LeavesOutEmptyParts) {
    EXPECT_STREQ(Error("no scene").what(), "no scene");
}

TEST(Error, BlamesTheInputUnlessToldOtherwise) {
    EXPECT_EQ(Error("x").fault(), Fault::input);
    EXPECT_EQ(Error("x", "", "", Fault::work).inside("y").fault(), Fault::work);
}

}  // namespace
}  // namespace lightgrid
