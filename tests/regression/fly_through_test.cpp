// Runs the built `fly-through` as a user or a script does.

#include "core/image.h"
#include "probes/volume_file.h"
#include "tests/regression/program_test.h"

#include <set>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

const std::string cornell = LIGHTGRID_SCENES "/cornell.glb";

class FlyThrough : public ProgramTest {
  protected:
    FlyThrough() : ProgramTest(FLY_THROUGH_PROGRAM) {}

    void bake(const std::string& level, const std::string& volume, const std::string& options = {}) const {
        const Result result = shell(fmt::format("{} {} -o {} --samples 32 --max-probes 300 --quiet {}",
                                                LEVEL_BAKE_PROGRAM, level, volume, options));
        ASSERT_EQ(result.status, 0) << result.err;
    }
    [[nodiscard]] std::set<std::string> files(const std::string& name) const {
        std::set<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder() / name))
            names.insert(entry.path().filename().string());
        return names;
    }
    [[nodiscard]] ByteImage picture(const std::string& name) const {
        const std::string bytes = read_whole_file(folder() / name);
        return decode_image(std::as_bytes(std::span(bytes)), name);
    }
    /// Brightest less darkest channel of the picture: a picture of nothing has none.
    [[nodiscard]] static int contrast(const ByteImage& image) {
        int least = 255;
        int most = 0;
        for (const glm::u8vec4& pixel : image.pixels) {
            least = std::min<int>(least, pixel.g);
            most = std::max<int>(most, pixel.g);
        }
        return most - least;
    }
};

TEST_F(FlyThrough, WritesAsManyFramesAsAskedForAndNoOtherPicture) {
    bake(cornell, "cornell.probes.exr");
    const Result result = run(cornell + " cornell.probes.exr --headless --out frames --frames 3 --size 96x54");
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(files("frames"), (std::set<std::string>{"frame_00000.png", "frame_00001.png", "frame_00002.png"}));
    for (const std::string& name : files("frames")) {
        const ByteImage image = picture("frames/" + name);
        EXPECT_EQ(image.width, 96);
        EXPECT_EQ(image.height, 54);
        EXPECT_GT(contrast(image), 50) << name;
    }
}

TEST_F(FlyThrough, FramesOfAnEarlierRunAreRemovedAndOtherFilesStay) {
    bake(cornell, "cornell.probes.exr");
    fs::create_directory(folder() / "frames");
    for (int i = 0; i < 4; ++i) write(fmt::format("frames/frame_{:05}.png", i), "old");
    write("frames/notes.txt", "mine");
    ASSERT_EQ(run(cornell + " cornell.probes.exr --headless --out frames --frames 1 --size 32x18").status, 0);
    EXPECT_EQ(files("frames"), (std::set<std::string>{"frame_00000.png", "notes.txt"}));
}

TEST_F(FlyThrough, RendersTheSamePicturesEveryTime) {
    bake(cornell, "cornell.probes.exr");
    const std::string call = cornell + " cornell.probes.exr --headless --frames 2 --size 64x36 --out ";
    ASSERT_EQ(run(call + "a").status, 0);
    ASSERT_EQ(run(call + "b").status, 0);
    for (const std::string& name : files("a")) {
        EXPECT_EQ(read_whole_file(folder() / "a" / name), read_whole_file(folder() / "b" / name)) << name;
    }
}

TEST_F(FlyThrough, BakesARoughVolumeWhereNoneIsGiven) {
    const Result result = run(cornell + " --headless --out frames --frames 1 --size 64x36");
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.err.find("no VOLUME"), std::string::npos) << result.err;
    EXPECT_GT(contrast(picture("frames/frame_00000.png")), 50);
    EXPECT_EQ(run(cornell + " --headless --out frames --frames 1 --size 64x36 --quiet").err, "");
}

TEST_F(FlyThrough, FollowsAPathAtItsOwnRate) {
    bake(cornell, "cornell.probes.exr");
    write("path.json", R"({"frames_per_second": 2, "keys": [
        {"time_s": 0, "eye": [0, 1, 0.9], "look_at": [0, 1, 0]},
        {"time_s": 1, "eye": [0.3, 1, 0.9], "look_at": [0, 1, 0]}]})");
    const std::string call = cornell + " cornell.probes.exr --headless --size 32x18 --path path.json --out ";
    ASSERT_EQ(run(call + "frames").status, 0);
    EXPECT_EQ(files("frames").size(), 3U);
    ASSERT_EQ(run(call + "five --frames 5").status, 0);
    EXPECT_EQ(files("five").size(), 5U);
    // Frames are spread over the same path: ends and middle are the same pictures.
    for (const auto& [a, b] : {std::pair(0, 0), std::pair(1, 2), std::pair(2, 4)}) {
        EXPECT_EQ(read_whole_file(folder() / fmt::format("frames/frame_{:05}.png", a)),
                  read_whole_file(folder() / fmt::format("five/frame_{:05}.png", b)));
    }
}

TEST_F(FlyThrough, RefusesWrongCalls) {
    bake(cornell, "cornell.probes.exr");
    const std::string headless = " --headless --out frames ";
    expect_refused("", "no LEVEL");
    expect_refused(cornell + " --headless", "--out DIR");
    expect_refused(cornell + " --out frames", "--out belongs to --headless");
    expect_refused(cornell + " --frames 3", "--frames belongs to --headless");
    expect_refused(cornell + headless + "--size 0x54", "0x54");
    expect_refused(cornell + headless + "--size 96", "is no size in pixels");
    expect_refused(cornell + headless + "--size 96x54x3", "is no size in pixels");
    expect_refused(cornell + headless + "--frames 0", "0 is not a whole number from 1");
    expect_refused(cornell + headless + "--sizes 96x54", "did you mean --size?");
    expect_refused("gone.glb" + headless, "gone.glb");
    expect_refused(cornell + " gone.exr" + headless, "gone.exr");
    expect_refused(cornell + headless + "--path gone.json", "gone.json");
    expect_refused(cornell + headless + "--object gone.obj", "gone.obj");
    expect_refused(cornell + headless + "--shaders gone", "gone");
    write("broken.json", "{");
    expect_refused(cornell + headless + "--path broken.json", "broken.json");
    write("file", "");
    expect_refused(cornell + " --headless --out file/frames", "file/frames");
}

TEST_F(FlyThrough, RefusesAVolumeThatIsNotOfTheLevel) {
    write("probes.csv", "x,y,z\n0,1,0\n");
    bake(cornell, "elsewhere.probes.exr", "--volume 100,100,100,101,101,101");
    expect_refused(cornell + " elsewhere.probes.exr --headless --out frames", "lies wholly outside of cornell.glb");
    ASSERT_EQ(shell(fmt::format("{} {} -o list.probes.exr --probes probes.csv --samples 16 --quiet", LEVEL_BAKE_PROGRAM,
                                cornell))
                  .status,
              0);
    expect_refused(cornell + " list.probes.exr --headless --out frames", "probe list");
}

TEST_F(FlyThrough, WarnsOfAVolumeThatNamesAnotherLevel) {
    bake(cornell, "cornell.probes.exr");
    fs::copy_file(cornell, folder() / "renamed.glb");
    const Result result = run("renamed.glb cornell.probes.exr --headless --out frames --frames 1 --size 32x18");
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.err.find("warning: cornell.probes.exr: was baked for cornell.glb"), std::string::npos)
        << result.err;
}

TEST_F(FlyThrough, ABrokenShaderIsRefusedByFileAndLine) {
    fs::create_directory(folder() / "shaders");
    write("shaders/level.glsl", "// one\n// two\nout vec4 color;\nvoid main() { color = nonsense; }\n");
    expect_refused(cornell + " --headless --out frames --frames 1 --size 32x18 --quiet --shaders shaders",
                   "level.glsl:4:");
}

TEST_F(FlyThrough, WithoutADisplayItTellsOfHeadless) {
    bake(cornell, "cornell.probes.exr");
    const Result result =
        shell(fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {} {} cornell.probes.exr", FLY_THROUGH_PROGRAM, cornell));
    EXPECT_EQ(result.status, 2);
    EXPECT_NE(result.err.find("--headless"), std::string::npos) << result.err;
}

/// What people do, by xdotool on a display of its own.
TEST_F(FlyThrough, AWindowIsFlownResizedPhotographedAndClosed) {
    if (shell("command -v Xvfb xdotool").status != 0) GTEST_SKIP() << "Xvfb or xdotool is not installed";
    bake(cornell, "cornell.probes.exr");
    write("start.json", R"({"keys": [{"time_s": 0, "eye": [0, 1, 0.9], "look_at": [0, 1, 0]}]})");
    write("act", fmt::format(R"(
        set -eu
        wait_for() {{ for i in $(seq 600); do [ -s "$1" ] && return; sleep 0.1; done; echo "no $1" >&2; exit 9; }}
        Xvfb -displayfd 3 -screen 0 1280x800x24 3>display >/dev/null 2>&1 &
        server=$!
        trap 'kill $server' EXIT
        wait_for display
        export DISPLAY=:$(cat display)
        {} {} cornell.probes.exr --size 320x180 --path start.json 2>said &
        program=$!
        window=$(timeout 60 xdotool search --sync --name 'ms a frame' | head -1)
        xdotool mousemove 100 100 key F12
        wait_for cornell_0001.exr
        xdotool windowsize --sync $window 400 300
        xdotool keydown w keydown shift mousemove 150 90 mousedown 3 mousemove 200 110 mouseup 3 keyup shift keyup w
        xdotool mousemove 200 150 mousedown 1 mousemove 260 140 mouseup 1 click 4 click 5
        xdotool key x key b key n key g key h key l key o key t key comma key period key minus key equal key f
        xdotool key 2 key 4 key 1 key r
        xdotool keydown s
        xdotool key F12
        wait_for cornell_0002.exr
        xdotool keyup s key r
        wait_for cornell_path_0001.json
        xdotool key p key F1 key Escape
        status=0
        wait $program || status=$?
        cat said >&2
        exit $status
        )",
                             FLY_THROUGH_PROGRAM, cornell));
    const Result result = shell("bash ./act");
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.err.find("saved cornell_0001.png and cornell_0001.exr"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("split screen"), std::string::npos) << "the help that F1 asks for: " << result.err;
    const ByteImage first = picture("cornell_0001.png");
    EXPECT_EQ(glm::ivec2(first.width, first.height), glm::ivec2(320, 180));
    EXPECT_GT(contrast(first), 50);
    const ByteImage second = picture("cornell_0002.png");
    EXPECT_EQ(glm::ivec2(second.width, second.height), glm::ivec2(400, 300));
    const RadianceFile light = read_radiance(folder() / "cornell_0001.exr");
    EXPECT_EQ(light.image.width, 320);
    EXPECT_NE(read_whole_file(folder() / "cornell_path_0001.json").find("yaw_deg"), std::string::npos);
}

}  // namespace
}  // namespace lightgrid
