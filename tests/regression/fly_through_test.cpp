// Runs the built `fly-through` as a user or a script does.

#include "core/image.h"
#include "probes/volume_file.h"
#include "tests/regression/program_test.h"

#include <regex>
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

TEST_F(FlyThrough, WarnsOfAVolumeOfOtherLight) {
    bake(cornell, "cornell.probes.exr", "--sky 1,2,3");
    const std::string call = cornell + " cornell.probes.exr --headless --frames 1 --size 64x36 --out shots";
    EXPECT_NE(
        run(call).err.find(R"(its environment was "uniform sky 1,2,3 cd/m^2", and what is traced here has "none")"),
        std::string::npos);
    EXPECT_EQ(run(call + " --sky 1,2,3").err.find("its environment was"), std::string::npos);
}

TEST_F(FlyThrough, ColorsTheLevelByHowMuchTheVolumeDiffersFromThePathTracer) {
    bake(cornell, "cornell.probes.exr");
    write("still.json", R"({"keys": [{"time_s": 0, "eye": [2.7, 2, 5], "look_at": [2.7, 2, 0]}]})");  // no object
    const std::string call = cornell + " cornell.probes.exr --headless --path still.json --frames 1 --size 64x36";
    ASSERT_EQ(run(call + " --press vvv --out differences").status, 0);
    ASSERT_EQ(run(call + " --press vv --out errors").status, 0);
    const ByteImage differences = picture("differences/frame_00000.png");
    EXPECT_GT(contrast(differences), 30) << "the light is as right everywhere";
    EXPECT_NE(differences.pixels, picture("errors/frame_00000.png").pixels);
}

TEST_F(FlyThrough, ABrokenShaderIsRefusedByFileAndLine) {
    fs::create_directory(folder() / "shaders");
    write("shaders/level.frag", "#version 330 core\n// two\nout vec4 color;\nvoid main() { color = nonsense; }\n");
    expect_refused(cornell + " --headless --out frames --frames 1 --size 32x18 --quiet --shaders shaders",
                   "level.frag:4:");
}

TEST_F(FlyThrough, WithoutADisplayItTellsOfHeadless) {
    bake(cornell, "cornell.probes.exr");
    const Result result =
        shell(fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {} {} cornell.probes.exr", FLY_THROUGH_PROGRAM, cornell));
    EXPECT_EQ(result.status, 2);
    EXPECT_NE(result.err.find("--headless"), std::string::npos) << result.err;
}

TEST_F(FlyThrough, WhatIsWrongIsToldBeforeAWindowOpens) {
    bake(cornell, "elsewhere.probes.exr", "--volume 100,100,100,101,101,101");
    expect_refused("gone.glb", "gone.glb");
    expect_refused(cornell + " gone.exr", "gone.exr");
    expect_refused(cornell + " elsewhere.probes.exr", "lies wholly outside of cornell.glb");
    expect_refused(cornell + " --size 0x54", "0x54");
    expect_refused(cornell + " --object gone.obj", "gone.obj");
    expect_refused(cornell + " --shaders gone", "gone");
}

/// An environment that is red above.
class EnvironmentAlone : public FlyThrough {
  protected:
    EnvironmentAlone() {
        RadianceImage image{16, 8, {}};
        for (int y = 0; y < image.height; ++y) {
            for (int x = 0; x < image.width; ++x) image.pixels.push_back(y < 4 ? glm::vec3(6, 3, 3) : glm::vec3(1));
        }
        write_exr(image, folder() / "a.exr");
    }
};

TEST_F(EnvironmentAlone, LightsAnObjectOnAnOrbit) {
    const std::string call = "--environment a.exr --headless --frames 3 --size 96x54 --out ";
    const Result result = run(call + "frames");
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(files("frames").size(), 3U);
    const ByteImage image = picture("frames/frame_00001.png");
    EXPECT_GT(contrast(image), 50);
    EXPECT_GT(image.at(48, 2).r, image.at(48, 2).g + 20) << "the environment is behind it";
    EXPECT_GT(image.at(48, 20).r, image.at(48, 20).g + 10) << "and lights it from above";
    // Bands and samples count.
    ASSERT_EQ(run(call + "one --bands 1 --samples 10").status, 0);
    EXPECT_NE(read_whole_file(folder() / "one/frame_00001.png"), read_whole_file(folder() / "frames/frame_00001.png"));
    ASSERT_EQ(run(call + "split --compare bands").status, 0);
    EXPECT_NE(read_whole_file(folder() / "split/frame_00001.png"),
              read_whole_file(folder() / "frames/frame_00001.png"));
    ASSERT_EQ(run("--sky 1,2,3 --headless --frames 1 --size 32x18 --out sky").status, 0) << "a sky will do, too";
}

TEST_F(EnvironmentAlone, RefusesWhatBelongsToALevelAndTheOtherWayRound) {
    const std::string headless = " --headless --out frames ";
    expect_refused("--environment gone.hdr" + headless, "gone.hdr");
    expect_refused("--environment a.exr --scene 0" + headless, "--scene belongs to a LEVEL");
    expect_refused("--environment a.exr --samples 9" + headless, "9 is not a whole number from 10");
    expect_refused("--environment a.exr --samples 100001" + headless, "100001 is not");
    expect_refused("--environment a.exr --bands 7" + headless, "7 is not a whole number from 1");
    expect_refused("--environment a.exr --compare colours" + headless, "nothing to compare: filter, bands");
    expect_refused(cornell + " --samples 100" + headless, "--samples is for an --environment without a LEVEL");
}

TEST_F(FlyThrough, SplitScreenShowsBothSidesWithoutADisplay) {
    bake(cornell, "cornell.probes.exr");
    write("path.json", R"({"keys": [{"time_s": 0, "eye": [0, 1, 0.9], "look_at": [0, 1, 0], "object": [0, 1, 0]}]})");
    for (const char* what : {"filter", "bands", "dering", "half", "reference"}) {
        const Result result =
            run(fmt::format("{} cornell.probes.exr --headless --size 96x54 --path path.json --out {} --compare {}",
                            cornell, what, what));
        ASSERT_EQ(result.status, 0) << result.err;
        EXPECT_GT(contrast(picture(fmt::format("{}/frame_00000.png", what))), 50) << what;
    }
}

/// Shell: a display that nobody else has, and that goes with the shell. The file that tells its number may be there from
/// another one.
constexpr const char* own_display = R"(
            rm -f display
            Xvfb -displayfd 3 -screen 0 1280x800x24 3>display >/dev/null 2>&1 &
            server=$!
            trap 'kill $server' EXIT
            for i in $(seq 600); do [ -s display ] && break; sleep 0.1; done
            export DISPLAY=:$(cat display))";

/// What people do, by xdotool on a display of its own.
class InAWindow : public FlyThrough {
  protected:
    void SetUp() override {
        if (shell("command -v Xvfb && command -v xdotool").status != 0)
            GTEST_SKIP() << "Xvfb or xdotool is not installed";
    }
    /// Starts the program with `arguments`, does as `script` says and awaits the program's end. In the script, $window
    /// is its window; `wait_for FILE` waits until there is something in it, `wait_for_word WORD` until it was said.
    [[nodiscard]] Result act(const std::string& arguments, const std::string& script) const {
        write("act", fmt::format(R"(
            set -eu
            wait_for() {{ for i in $(seq 600); do [ -s "$1" ] && return; sleep 0.1; done; echo "no $1" >&2; exit 9; }}
            wait_for_word() {{
                for i in $(seq 600); do grep -q -- "$1" said && return; sleep 0.1; done
                cat said >&2; echo "nothing said of $1" >&2; exit 9
            }}
            {}
            {} {} 2>said &
            program=$!
            window=$(timeout 60 xdotool search --sync --name 'ms a frame' | head -1)
            {}
            status=0
            wait $program || status=$?
            cat said >&2
            exit $status
            )",
                                 own_display, FLY_THROUGH_PROGRAM, arguments, script));
        return shell("bash ./act");
    }
    [[nodiscard]] glm::ivec2 size_of(const std::string& name) const {
        const ByteImage image = picture(name);
        return {image.width, image.height};
    }
};

TEST_F(InAWindow, IsFlownResizedPhotographedAndClosed) {
    bake(cornell, "cornell.probes.exr");
    write("start.json", R"({"keys": [{"time_s": 0, "eye": [0, 1, 0.9], "look_at": [0, 1, 0]}]})");
    const Result result = act(cornell + " cornell.probes.exr --size 320x180 --path start.json", R"(
        xdotool mousemove 100 100 key F12
        wait_for cornell_0001.exr
        xdotool windowsize --sync $window 400 300
        xdotool keydown w keydown shift mousemove 150 90 mousedown 3 mousemove 200 110 mouseup 3 keyup shift keyup w
        xdotool mousemove 200 150 mousedown 1 mousemove 260 140 mouseup 1 click 4 click 5
        xdotool key x key b key n key g key h key l key o key t key u key k key comma key period key minus key equal key f
        xdotool key 2 key 4 key 1 key 3 key i key j key v key z key c key r
        xdotool keydown s
        xdotool key F12
        wait_for cornell_0002.exr
        xdotool keyup s key r
        wait_for cornell_path_0001.json
        xdotool key p key F1 key Escape)");
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.err.find("saved cornell_0001.png and cornell_0001.exr"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("no object of your own"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("a level keeps the environment"), std::string::npos) << result.err;
    EXPECT_EQ(size_of("cornell_0001.png"), glm::ivec2(320, 180));
    EXPECT_GT(contrast(picture("cornell_0001.png")), 50);
    EXPECT_EQ(size_of("cornell_0002.png"), glm::ivec2(400, 300));
    const RadianceFile light = read_radiance(folder() / "cornell_0001.exr");
    EXPECT_EQ(light.image.width, 320);
    EXPECT_NE(read_whole_file(folder() / "cornell_path_0001.json").find("yaw_deg"), std::string::npos);
}

TEST_F(InAWindow, SpaceGoesToWhereTheVolumeIsWorst) {
    bake(cornell, "cornell.probes.exr");
    write("start.json", R"({"keys": [{"time_s": 0, "eye": [2.7, 2, 5], "look_at": [2.7, 2, 0]}]})");
    const Result result = act(cornell + " cornell.probes.exr --size 320x180 --path start.json", R"(
        xdotool mousemove 100 100 key F12
        wait_for cornell_0001.exr
        for i in $(seq 600); do
            xdotool key space
            sleep 0.1
            grep -q 'worst place 1 of' said && break
        done
        xdotool key F12
        wait_for cornell_0002.exr
        xdotool key space
        for i in $(seq 100); do [ $(grep -c 'worst place' said) -ge 2 ] && break; sleep 0.1; done
        xdotool key Escape)");
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_NE(read_whole_file(folder() / "cornell_0001.exr"), read_whole_file(folder() / "cornell_0002.exr"));
    std::set<std::string> places;
    const std::regex told("worst place [0-9]+ of [0-9]+, at ([-0-9. ]+)");
    for (std::sregex_iterator at(result.err.begin(), result.err.end(), told), end; at != end; ++at)
        EXPECT_TRUE(places.insert((*at)[1]).second) << result.err;
    EXPECT_GE(places.size(), 2U) << result.err;
}

TEST_F(InAWindow, TheBunnyTakesThePlaceOfTheSphereWhileThePictureGoesOn) {
    if (shell("test -e /usr/share/glmark2/models/bunny.obj").status != 0) GTEST_SKIP() << "the bunny is not installed";
    bake(cornell, "cornell.probes.exr");
    write("start.json", R"({"keys": [{"time_s": 0, "eye": [2.7, 2, 5], "look_at": [2.7, 2, 0]}]})");
    // Self-shadowing is off, so that it is not that which changes.
    const Result result = act(cornell + " cornell.probes.exr --size 320x180 --path start.json", R"(
        xdotool key k key F12
        wait_for cornell_0001.exr
        xdotool key F12
        wait_for cornell_0002.exr
        xdotool key 2
        for i in $(seq 3 99); do
            xdotool key F12
            picture=$(printf 'cornell_%04d.exr' $i)
            wait_for $picture
            cmp -s cornell_0002.exr $picture || break
        done
        cp $picture bunny.exr
        xdotool key Escape)");
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(read_whole_file(folder() / "cornell_0001.exr"), read_whole_file(folder() / "cornell_0002.exr"));
    EXPECT_NE(read_whole_file(folder() / "bunny.exr"), read_whole_file(folder() / "cornell_0002.exr"));
}

TEST_F(InAWindow, ABrokenShaderIsRefusedByFileAndLine) {
    bake(cornell, "cornell.probes.exr");
    fs::create_directory(folder() / "shaders");
    write("shaders/level.frag", "#version 330 core\n// two\nout vec4 color;\nvoid main() { color = nonsense; }\n");
    const Result result = shell(fmt::format("{}\n timeout 60 {} {} cornell.probes.exr --shaders shaders", own_display,
                                            FLY_THROUGH_PROGRAM, cornell));
    EXPECT_EQ(result.status, 2) << result.err;
    EXPECT_NE(result.err.find("level.frag:4:"), std::string::npos) << result.err;
}

TEST_F(InAWindow, ThePanelStandsBesideThePictureAndTabHidesIt) {
    bake(cornell, "cornell.probes.exr");
    const Result result = act(cornell + " cornell.probes.exr --size 800x600", R"(
        xdotool mousemove 600 300 click 1 key F12
        wait_for cornell_0001.exr
        xdotool key Tab key F12
        wait_for cornell_0002.exr
        xdotool key Tab key x key m key m key F1 key F1 mousemove 100 300 mousedown 1 mousemove 130 310 mouseup 1 click 5
        xdotool key m key m mousemove 400 300 mousedown 1 mousemove 500 310 mouseup 1 key F12
        wait_for cornell_0003.exr
        xdotool windowsize --sync $window 1 1
        xdotool windowsize --sync $window 700 500
        xdotool key F12
        wait_for cornell_0004.exr
        xdotool key Escape)");
    EXPECT_EQ(result.status, 0) << result.err;
    const glm::ivec2 beside = size_of("cornell_0001.png");
    EXPECT_LT(beside.x, 600);
    EXPECT_EQ(beside.y, 600);
    EXPECT_EQ(size_of("cornell_0002.png"), glm::ivec2(800, 600));
    EXPECT_EQ(size_of("cornell_0003.png"), beside);
    EXPECT_EQ(size_of("cornell_0004.png"), glm::ivec2(700 - (800 - beside.x), 500));
}

TEST_F(InAWindow, BakesWhileItShowsAndShowsAReplacedVolume) {
    const Result baked = act(cornell + " --size 320x180", R"(
        wait_for_word 'baked with 64 rays'
        xdotool key Escape)");
    EXPECT_EQ(baked.status, 0) << baked.err;
    bake(cornell, "a.probes.exr");
    bake(cornell, "b.probes.exr", "--seed 1");
    const Result result = act(cornell + " a.probes.exr --size 320x180", R"(
        mv b.probes.exr a.probes.exr
        wait_for_word 'a.probes.exr'
        echo broken > c && mv c a.probes.exr
        sleep 1
        xdotool key F12
        wait_for cornell_0001.exr
        xdotool key Escape)");
    EXPECT_EQ(result.status, 0) << result.err;
}

TEST_F(InAWindow, TheSkyOfALevelIsPutInLater) {
    bake(cornell, "cornell.probes.exr", "--layers sky");
    write("start.json", R"({"keys": [{"time_s": 0, "eye": [0, 1, 0.9], "look_at": [0, 1, 0]}]})");
    const Result result = act(cornell + " cornell.probes.exr --size 320x180 --path start.json", R"(
        xdotool key F12
        wait_for cornell_0001.exr
        xdotool key i keydown bracketright key F12
        wait_for cornell_0002.exr
        xdotool keyup bracketright key i key Escape)");
    EXPECT_EQ(result.status, 0) << result.err;
    const auto light = [&](const char* name) {
        glm::vec3 sum(0);
        for (const glm::vec3 pixel : read_radiance(folder() / name).image.pixels) sum += pixel;
        return sum.r + sum.g + sum.b;
    };
    EXPECT_GT(light("cornell_0002.exr"), 1.001F * light("cornell_0001.exr"));
}

TEST_F(InAWindow, AnEnvironmentAloneIsTurnedAndExchanged) {
    fs::create_directory(folder() / "skies");
    for (const auto& [name, color] : {std::pair("a.exr", glm::vec3(4, 1, 1)), std::pair("b.exr", glm::vec3(1, 4, 1))}) {
        RadianceImage image{16, 8, {}};
        image.pixels.assign(128, color);
        image.pixels.front() = glm::vec3(1);
        write_exr(image, folder() / "skies" / name);
    }
    write("skies/c.exr", "broken");
    const Result result = act("--environment skies/a.exr --size 320x180", R"(
        xdotool key F12
        wait_for a_0001.exr
        xdotool keydown bracketright key b key k key b key x key m keyup bracketright key i
        wait_for_word 'b.exr'
        xdotool key F12
        wait_for b_0001.exr
        xdotool key i
        wait_for_word 'c.exr'
        xdotool key i
        wait_for_word ': a.exr'
        xdotool key p key Escape)");
    EXPECT_EQ(result.status, 0) << result.err;
    const auto mean = [&](const char* name) {
        glm::vec3 sum(0);
        for (const glm::vec3 pixel : read_radiance(folder() / name).image.pixels) sum += pixel;
        return sum;
    };
    EXPECT_GT(mean("a_0001.exr").r, mean("a_0001.exr").g);
    EXPECT_GT(mean("b_0001.exr").g, mean("b_0001.exr").r);
}

}  // namespace
}  // namespace lightgrid
