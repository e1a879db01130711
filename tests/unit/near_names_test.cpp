#include "core/near_names.h"

#include <gtest/gtest.h>

namespace lightgrid {
namespace {

TEST(NearNames, LowerCaseLeavesWhatIsNoAsciiLetter) {
    EXPECT_EQ(lower_case("Wood_01.PNG"), "wood_01.png");
    EXPECT_EQ(lower_case("\xC3\x84.EXR"), "\xC3\x84.exr");
}

TEST(NearNames, ThoseThatTakeTheFewestEditsComeFirst) {
    EXPECT_EQ(edit_distance("dome", "dome"), 0U);
    EXPECT_EQ(edit_distance("", "dome"), 4U);
    EXPECT_EQ(edit_distance("doem", "dome"), 1U) << "neighbours that are swapped";
    EXPECT_EQ(edit_distance("home", "domes"), 2U);
    EXPECT_EQ(nearest_names("skydoem", {"Tree", "SkyDome", "Sky", "SkyDome"}, 2),
              (std::vector<std::string>{"SkyDome", "Sky"}));
    EXPECT_TRUE(nearest_names("dome", {}, 3).empty());
}

}  // namespace
}  // namespace lightgrid
