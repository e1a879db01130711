#include "probes/verdict.h"

#include <gtest/gtest.h>

namespace lightgrid {
namespace {

ErrorPart part(double relrmse, double high) {
    return {relrmse, {0, high}};
}

TEST(Verdict, NothingIsJudgedWhereSamplesOrSecondsWereAskedFor) {
    const ErrorReport error;
    for (const Target& target : {Target{512, {}, {}}, Target{{}, {}, 60.0}}) {
        const Verdict verdict = judge(target, {&error, 0.5});
        EXPECT_FALSE(verdict.target_met);
        EXPECT_EQ(verdict.sentence, "");
    }
}

TEST(Verdict, NoiseAloneDecidesWhereNothingElseIsKnown) {
    const Verdict met = judge({{}, 0.01, {}}, {nullptr, 0.009});
    EXPECT_EQ(met.target_met, true);
    EXPECT_EQ(met.sentence, "target met: noise 0.9 % of 1 %");
    const Verdict missed = judge({{}, 0.01, {}}, {nullptr, 0.011});
    EXPECT_EQ(missed.target_met, false);
    EXPECT_EQ(missed.sentence, "target not reached: noise 1.1 % of 1 %");
}

TEST(Verdict, TheUpperEndOfTheIntervalDecides) {
    ErrorReport error;
    error.total = part(0.05, 0.06);
    error.without_bands = part(0.01, 0.019);
    error.bands = part(0.048, 0.06);
    error.interpolation = part(0.009, 0.02);
    error.noise = part(0.004, 0.004);
    EXPECT_EQ(judge({}, {&error}).target_met, true) << "without a target of one's own, bands do not count";
    EXPECT_EQ(judge({}, {&error}).sentence, "target met: 1.9 % at most, of 2 %");
    EXPECT_EQ(judge({{}, 0.02, {}}, {&error}).target_met, false) << "with one they do";
    error.without_bands.interval.high = 0.0237;
    error.points = 512;
    EXPECT_EQ(judge({}, {&error}).target_met, false);
    EXPECT_EQ(judge({}, {&error}).sentence, "target 2 % missed: 1 %, but up to 2.4 % is possible with 512 places");
}

TEST(Verdict, WithMissingTexturesNothingIsJudged) {
    ErrorReport error;
    error.total = part(0.01, 0.011);
    error.without_bands = error.total;
    Evidence evidence{&error};
    EXPECT_EQ(judge({{}, 0.02, {}}, evidence).target_met, true);
    evidence.missing_textures = 1;
    const Verdict one = judge({{}, 0.02, {}}, evidence);
    EXPECT_FALSE(one.target_met.has_value());
    EXPECT_FALSE(one.is_judged);
    EXPECT_EQ(one.sentence, "not judged: 1 texture missing");
    evidence.missing_textures = 3;
    EXPECT_EQ(judge({}, evidence).sentence, "not judged: 3 textures missing");
    evidence.points = 7;
    evidence.is_black = true;
    evidence.is_tested = false;
    EXPECT_EQ(judge({}, evidence).target_met, false) << "light that nothing asked for is missing whatever else is";
}

TEST(Verdict, NothingIsJudgedWhereEveryLightIsKeptFromTheLevel) {
    ErrorReport error;
    error.total = part(0.01, 0.011);
    error.without_bands = error.total;
    Evidence evidence{&error, 0, 1234};
    evidence.is_shut_out = true;
    EXPECT_EQ(judge({}, evidence).target_met, true) << "other lights shine";
    EXPECT_TRUE(judge({}, evidence).is_judged);
    evidence.is_all_shut_out = true;
    EXPECT_FALSE(judge({}, evidence).target_met) << "what light there is, is outside of the mesh";
    EXPECT_FALSE(judge({}, evidence).is_judged);
    EXPECT_EQ(judge({}, evidence).sentence, "not judged: every light is kept from the level");
}

TEST(Verdict, DigitsTellAnErrorFromWhatWasWanted) {
    const Target target{{}, 0.02, {}};
    EXPECT_EQ(judge(target, {nullptr, 0.02004}).sentence, "target not reached: noise 2.004 % of 2 %");
    EXPECT_EQ(judge(target, {nullptr, 0.01996}).sentence, "target met: noise 1.996 % of 2 %");
    EXPECT_EQ(judge(target, {nullptr, 0.0203}).sentence, "target not reached: noise 2.03 % of 2 %");
}

TEST(Verdict, NamesThePartsThatAreInTheWay) {
    ErrorReport error;
    error.total = part(0.05, 0.06);
    error.bands = part(0.048, 0.06);
    error.interpolation = part(0.011, 0.02);
    error.noise = part(0.004, 0.004);
    error.bias = part(-0.003, 0.001);
    EXPECT_EQ(judge({{}, 0.02, {}}, {&error}).sentence, "target not reached: bands 4.8 %, interpolation 1.1 %");
}

TEST(Verdict, DarknessIsNoEvidenceWhereALightWasNeverTested) {
    const ErrorReport error;
    Evidence evidence{&error, 0, 1234, true, false};
    EXPECT_EQ(judge({}, evidence).sentence, "no light reached any of 1234 points");
    EXPECT_EQ(judge({}, evidence).target_met, false);
    EXPECT_EQ(judge({512, {}, {}}, evidence).sentence, "no light reached any of 1234 points");
    EXPECT_FALSE(judge({512, {}, {}}, evidence).target_met);
    evidence.is_black = false;
    EXPECT_EQ(judge({}, evidence).target_met, true);
    evidence = {&error, 0, 1234, true, true};
    EXPECT_EQ(judge({}, evidence).target_met, true) << "what shadow rays found dark is dark";
    EXPECT_EQ(judge({}, evidence).sentence, "all is dark: rays to every light were stopped at each of 1234 points");
    evidence.is_shut_out = true;
    EXPECT_FALSE(judge({}, evidence).target_met) << "one mesh in the way may be a mistake";
    EXPECT_FALSE(judge({}, evidence).is_judged);
    evidence.has_light = false;
    EXPECT_FALSE(judge({}, evidence).target_met);
    EXPECT_EQ(judge({}, evidence).sentence, "not judged: nothing shines, all is black");
}

}  // namespace
}  // namespace lightgrid
