#include "tools/target_options.h"

#include "core/error.h"

#include <gtest/gtest.h>

namespace lightgrid {
namespace {

TEST(TargetOptions, PercentagesHaveTheirSign) {
    EXPECT_DOUBLE_EQ(parse_percentage("2%"), 0.02);
    EXPECT_DOUBLE_EQ(parse_percentage("0.5 %"), 0.005);
    for (const char* wrong : {"0.02", "2", "", "%", "0%", "-1%", "101%", "nan%", "2%%", "two%"}) {
        EXPECT_THROW(static_cast<void>(parse_percentage(wrong)), Error) << wrong;
    }
}

TEST(TargetOptions, DurationsAreSecondsMinutesOrHours) {
    EXPECT_DOUBLE_EQ(parse_duration("90"), 90);
    EXPECT_DOUBLE_EQ(parse_duration("60s"), 60);
    EXPECT_DOUBLE_EQ(parse_duration("1.5min"), 90);
    EXPECT_DOUBLE_EQ(parse_duration("2 h"), 7200);
    for (const char* wrong : {"", "s", "inf", "nan s", "60 sec", "1m", "1min30s"}) {
        EXPECT_THROW(static_cast<void>(parse_duration(wrong)), Error) << wrong;
    }
}

TEST(TargetOptions, OneOfThemAtMost) {
    EXPECT_EQ(parse_target({}).error, std::nullopt);
    EXPECT_DOUBLE_EQ(*parse_target({{}, "2%", "", true}).error, 0.02);
    EXPECT_THROW(static_cast<void>(parse_target({64, "2%", "", false})), Error);
    EXPECT_THROW(static_cast<void>(parse_target({{}, "2%", "60s", false})), Error);
    EXPECT_THROW(static_cast<void>(parse_target({64, "", "", true})), Error) << "nothing can be missed";
}

}  // namespace
}  // namespace lightgrid
