// Pictures along fixed paths through three levels, beside the references in pictures/expected.
//
// The same driver draws the same bytes. Others may round and sample edges differently: a bound of 1 in 255 (root mean
// square over a picture) and of 6 in its worst 16 x 16 pixels leaves them that, and each of the broken shaders below is
// beyond it. pictures/update draws the references anew.

#include "core/image.h"
#include "tests/regression/program_test.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <ostream>
#include <set>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

const fs::path pictures = LIGHTGRID_TEST_DIR "/pictures";
constexpr double most_rmse = 1;
constexpr double most_block_rmse = 6;
constexpr int block = 16;

struct Case {
    std::string name;
    int frames = 0;
};
std::ostream& operator<<(std::ostream& out, const Case& drawn) {
    return out << drawn.name;
}

std::vector<Case> all_cases() {
    std::vector<Case> cases;
    std::ifstream table(pictures / "cases");
    for (std::string line; std::getline(table, line);) {
        if (line.empty() || line[0] == '#') continue;
        cases.push_back({line.substr(0, line.find(' ')), std::stoi(line.substr(line.rfind('|') + 1))});
    }
    return cases;
}

/// Root mean squares of sRGB values from 0 to 255.
struct Difference {
    double whole = 0;
    double worst_block = 0;

    [[nodiscard]] bool within_bounds() const { return whole <= most_rmse && worst_block <= most_block_rmse; }
};

Difference compare(const ByteImage& a, const ByteImage& b) {
    Difference difference;
    double sum = 0;
    for (int top = 0; top < a.height; top += block) {
        for (int left = 0; left < a.width; left += block) {
            double in_block = 0;
            int count = 0;
            for (int y = top; y < std::min(top + block, a.height); ++y) {
                for (int x = left; x < std::min(left + block, a.width); ++x) {
                    const glm::dvec3 off = glm::dvec3(a.at(x, y)) - glm::dvec3(b.at(x, y));
                    in_block += glm::dot(off, off) / 3;
                    ++count;
                }
            }
            sum += in_block;
            difference.worst_block = std::max(difference.worst_block, std::sqrt(in_block / count));
        }
    }
    difference.whole = std::sqrt(sum / (static_cast<double>(a.width) * a.height));
    return difference;
}

ByteImage read_picture(const fs::path& path) {
    const std::string bytes = read_whole_file(path);
    return decode_image(std::as_bytes(std::span(bytes)), path.string());
}

class FlownPictures : public ProgramTest {
  protected:
    FlownPictures() : ProgramTest(FLY_THROUGH_PROGRAM) {}

    /// Draws a case and says how far its farthest frame is from the reference.
    [[nodiscard]] Difference farthest(const Case& drawn, const std::string& options = {}) const {
        const fs::path programs = fs::path(FLY_THROUGH_PROGRAM).parent_path();
        const Result result = shell(fmt::format("{}/render {} {} {} frames {}", pictures.string(), programs.string(),
                                                LIGHTGRID_SCENES, drawn.name, options));
        EXPECT_EQ(result.status, 0) << result.err;
        Difference farthest;
        for (int i = 0; i < drawn.frames; ++i) {
            const ByteImage got = read_picture(folder() / fmt::format("frames/frame_{:05}.png", i));
            const ByteImage want = read_picture(pictures / fmt::format("expected/{}_{}.png", drawn.name, i));
            EXPECT_EQ(glm::ivec2(got.width, got.height), glm::ivec2(want.width, want.height));
            const Difference here = compare(got, want);
            farthest.whole = std::max(farthest.whole, here.whole);
            farthest.worst_block = std::max(farthest.worst_block, here.worst_block);
        }
        return farthest;
    }
};

class Cases : public FlownPictures, public testing::WithParamInterface<Case> {};

TEST_P(Cases, AreAsTheirReferences) {
    const Difference difference = farthest(GetParam());
    EXPECT_LE(difference.whole, most_rmse);
    EXPECT_LE(difference.worst_block, most_block_rmse);
}

INSTANTIATE_TEST_SUITE_P(FlownPictures, Cases, testing::ValuesIn(all_cases()),
                         [](const auto& drawn) { return drawn.param.name; });

TEST(FlownPicturesReferences, AreOfTheCasesAndNothingElse) {
    std::set<std::string> wanted;
    for (const Case& drawn : all_cases()) {
        for (int i = 0; i < drawn.frames; ++i) wanted.insert(fmt::format("{}_{}.png", drawn.name, i));
    }
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(pictures / "expected")) {
        found.insert(entry.path().filename().string());
    }
    EXPECT_EQ(found, wanted);
    EXPECT_FALSE(wanted.empty());
}

/// A mistake in a shader, and a case that must not pass with it.
struct Mistake {
    std::string name;
    std::string file;  // below the repository's root
    std::string from;
    std::string to;
    std::string seen_in;
};
std::ostream& operator<<(std::ostream& out, const Mistake& mistake) {
    return out << mistake.name;
}

class BrokenShaders : public FlownPictures, public testing::WithParamInterface<Mistake> {};

TEST_P(BrokenShaders, AreSeen) {
    const Mistake& mistake = GetParam();
    const fs::path file = fs::path(LIGHTGRID_SOURCE_DIR) / mistake.file;
    std::string text = read_whole_file(file);
    const std::size_t at = text.find(mistake.from);
    ASSERT_NE(at, std::string::npos);
    text.replace(at, mistake.from.size(), mistake.to);
    fs::create_directory(folder() / "shaders");
    write("shaders/" + file.filename().string(), text);
    const std::vector<Case> cases = all_cases();
    const auto drawn =
        std::find_if(cases.begin(), cases.end(), [&](const Case& c) { return c.name == mistake.seen_in; });
    ASSERT_NE(drawn, cases.end());
    const Difference difference = farthest(*drawn, "--shaders shaders");
    fmt::print("{:.2f}, in the worst block {:.1f}\n", difference.whole, difference.worst_block);
    EXPECT_FALSE(difference.within_bounds());
}

INSTANTIATE_TEST_SUITE_P(
    FlownPictures, BrokenShaders,
    testing::Values(
        Mistake{"AxesOfShSwapped", "viewer/shaders/sh.glsl", "n.y * c[1] + n.z * c[2]", "n.z * c[1] + n.y * c[2]",
                "default"},
        Mistake{"AnotherDisplayCurve", "viewer/shaders/develop.frag", "1.0 / 2.4", "1.0 / 2.2", "courtyard"},
        Mistake{"LightOfOneSideOnly", "viewer/shaders/level.frag", "gl_FrontFacing ? light_in_front : light_behind",
                "light_behind", "cornell"},
        Mistake{"NoContactShadow", "viewer/shaders/contact_shadow.glsl", "opacity = 0.85", "opacity = 0.0", "cornell"},
        Mistake{"InvalidProbesCount", "probes/lightgrid.glsl", "last.w == state ? weight : 0.0f", "weight",
                "default_pixel"},
        Mistake{"LastCoefficientLeftOut", "probes/lightgrid.glsl", "float last = factors.z *", "float last = 0.0f *",
                "default_pixel"},
        Mistake{"AnotherScale", "viewer/shaders/false_color.glsl", "7.0 * clamp", "6.0 * clamp", "cornell_lux"},
        Mistake{"RimsOfAnotherColour", "viewer/shaders/ball.frag", "light_shown_as(rim)", "light_shown_as(rim.bgr)",
                "default_probes"}),
    [](const auto& broken) { return broken.param.name; });

}  // namespace
}  // namespace lightgrid
