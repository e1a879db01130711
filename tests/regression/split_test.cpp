// The report of `level-bake` names what its error is from, and the parts make up the error that is measured otherwise.

#include "core/sampling.h"
#include "tests/regression/program_test.h"

#include <cmath>

namespace lightgrid {
namespace {

const std::string cornell = LIGHTGRID_SCENES "/cornell.glb";

/// A bake of the free space below the lamp of a Cornell box in which one part is made larger than all others.
struct Cause {
    const char* part;
    const char* options;
};

class Split : public ProgramTest, public testing::WithParamInterface<Cause> {
  protected:
    Split() : ProgramTest(LEVEL_BAKE_PROGRAM) {}
};

TEST_P(Split, NamesTheLargestPartAndAddsUpToTheErrorAtOtherPoints) {
    const std::string bake = fmt::format("{} --volume 1.5,3.5,1.5,4,4.5,4 {} --report-json report.json -o out.exr",
                                         cornell, GetParam().options);
    const Result result = run(bake);
    ASSERT_EQ(result.status, 0) << result.err;
    const auto error = nlohmann::json::parse(read_whole_file(folder() / "report.json"))["error"];
    double largest = 0;
    std::string named;
    double sum = error["squares"]["cross"];
    for (const char* part : {"noise", "bands", "interpolation", "bias", "storage"}) {
        const double square = error["squares"][part];
        sum += square;
        if (square > largest) named = part;
        largest = std::max(largest, square);
    }
    EXPECT_EQ(named, GetParam().part) << error["squares"];

    std::string points = "x,y,z\n";
    for (std::uint32_t i = 0; i < 128; ++i) {
        const glm::dvec2 xz(sobol_point(i, 1));
        points += fmt::format("{},{},{}\n", 1.5 + 2.5 * xz.x, 3.5 + (i + 0.5) / 128, 1.5 + 2.5 * xz.y);
    }
    write("points.csv", points);
    const Result measured =
        shell(fmt::format("{0} reference {1} --points points.csv --samples 2048 --seed 1 > truth.csv && "
                          "{0} diff --json truth.csv out.exr",
                          LIGHTGRID_PROGRAM, cornell));
    ASSERT_EQ(measured.status, 0) << measured.err;
    const double relrmse = nlohmann::json::parse(measured.out)["relrmse"];
    EXPECT_NEAR(std::sqrt(sum), relrmse, 0.2 * relrmse) << error["squares"];
}

INSTANTIATE_TEST_SUITE_P(Causes, Split,
                         testing::Values(Cause{"noise", "--method path --samples 64 --spacing 0.3 --bands 5"},
                                         Cause{"bands", "--samples 1024 --spacing 0.3 --bands 2"},
                                         Cause{"interpolation", "--samples 2048 --spacing 5 --bands 5"}),
                         [](const auto& cause) { return std::string(cause.param.part); });

}  // namespace
}  // namespace lightgrid
