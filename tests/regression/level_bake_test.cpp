// Runs the built `level-bake` as a user or a script does.

#include "probes/volume_file.h"
#include "tests/regression/program_test.h"

#include <glm/gtc/constants.hpp>

#include <cmath>
#include <optional>
#include <set>
#include <sstream>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

const std::string cornell = LIGHTGRID_SCENES "/cornell.glb";

class LevelBake : public ProgramTest {
  protected:
    LevelBake() : ProgramTest(LEVEL_BAKE_PROGRAM) {}

    [[nodiscard]] std::set<std::string> files() const {
        std::set<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder())) names.insert(entry.path().filename().string());
        return names;
    }
    [[nodiscard]] std::string bytes(const std::string& name) const { return read_whole_file(folder() / name); }

    /// A square floor of 2 m at y = 0 that reflects half of the light, and nodes of a test's own.
    ///
    /// lights  of KHR_lights_punctual, for the nodes
    void write_floor(const std::string& name, const std::vector<nlohmann::json>& nodes = {},
                     const std::vector<nlohmann::json>& lights = {}) const {
        write_level(name, {{-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}}, {0, 1, 2, 0, 2, 3}, nodes, lights);
    }
    /// A solid cube of 2 m about the origin.
    void write_block(const std::string& name) const {
        std::vector<glm::vec3> corners;
        for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
        write_level(name, corners, {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                    2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5});
    }

    /// A floor of 20 m with a block of 4 m on it.
    ///
    /// unit  in so many units of the file is a metre
    void write_yard(const std::string& name, float unit) const {
        std::vector<glm::vec3> corners{{-10, 0, 10}, {10, 0, 10}, {10, 0, -10}, {-10, 0, -10}};
        for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? 4 : 0, i & 2 ? 4 : 0, i & 4 ? 3 : -1);
        std::vector<std::uint32_t> triangles{0, 1, 2, 0, 2, 3};
        for (const std::uint32_t corner :
             {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5})
            triangles.push_back(4 + corner);
        for (glm::vec3& corner : corners) corner *= unit;
        write_level(name, corners, triangles);
    }

    /// A closed room of 6 x 3 x 6 m with a lamp of 100 cd.
    ///
    /// albedo  none: without a material
    /// unit    in so many units of the file is a metre
    void write_room(const std::string& name, std::optional<double> albedo, float unit = 1) const {
        GltfBuilder gltf;
        std::vector<glm::vec3> corners;
        for (int i = 0; i < 8; ++i) corners.push_back(unit * glm::vec3(i & 1 ? 3 : -3, i & 2 ? 3 : 0, i & 4 ? 3 : -3));
        nlohmann::json primitive = {{"attributes", {{"POSITION", gltf.vec3s(corners)}}},
                                    {"indices", gltf.indices({0, 1, 2, 1, 3, 2, 4, 6, 5, 5, 6, 7, 0, 4, 1, 1, 4, 5,
                                                              2, 3, 6, 3, 7, 6, 0, 2, 4, 2, 6, 4, 1, 5, 3, 3, 5, 7})}};
        if (albedo) {
            gltf.add("materials", {{"pbrMetallicRoughness", {{"baseColorFactor", {*albedo, *albedo, *albedo, 1}}}}});
            primitive["material"] = 0;
        }
        gltf.node({{"mesh", gltf.mesh(primitive)}});
        gltf.use("KHR_lights_punctual");
        gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 100}}};
        gltf.json["scenes"][0]["nodes"].push_back(gltf.node(
            {{"translation", {0, 2.5F * unit, 0}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}));
        write(name, gltf.glb());
    }

  private:
    void write_level(const std::string& name, const std::vector<glm::vec3>& corners,
                     const std::vector<std::uint32_t>& triangles, const std::vector<nlohmann::json>& nodes = {},
                     const std::vector<nlohmann::json>& lights = {}) const {
        GltfBuilder gltf;
        if (!lights.empty()) {
            gltf.use("KHR_lights_punctual");
            gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = lights;
        }
        const int grey = gltf.add("materials", {{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.5, 0.5, 1}}}}});
        const int mesh = gltf.mesh({{"attributes", {{"POSITION", gltf.vec3s(corners)}}},
                                    {"indices", gltf.indices(triangles)},
                                    {"material", grey}});
        gltf.node({{"mesh", mesh}});
        for (const nlohmann::json& node : nodes) gltf.json["scenes"][0]["nodes"].push_back(gltf.node(node));
        write(name, gltf.glb());
    }
};

// ---- Input and output

TEST_F(LevelBake, WritesIntoTheCurrentFolderUnderTheLevelsName) {
    fs::create_directory(folder() / "levels");
    write_floor("levels/hall.v2.glb");
    const Result result = run("levels/hall.v2.glb --sky 1,1,1 --samples 16 --spacing 1");
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(result.out, "") << "results of a bake are its file";
    EXPECT_EQ(files(), (std::set<std::string>{"levels", "hall.v2.probes.exr"}));
    EXPECT_EQ(load_volume(folder() / "hall.v2.probes.exr").settings.at("level"), "hall.v2.glb");
}

TEST_F(LevelBake, TakesOptionsBeforeAndAfterTheLevelWithSpaceOrEqualsSign) {
    write_floor("floor.glb");
    EXPECT_EQ(run("--sky=1,1,1 --samples 32 floor.glb --spacing=1 -o a.exr --quiet").status, 0);
    EXPECT_EQ(run("floor.glb --samples=32 --spacing 1 --output=b.exr --sky 1,1,1 --quiet").status, 0);
    EXPECT_EQ(bytes("a.exr"), bytes("b.exr"));
}

TEST_F(LevelBake, BakesOneProbeOfAnEnvironmentWithoutALevel) {
    ASSERT_EQ(run("--sky 1,2,3 -o sky.exr --quiet").status, 0);
    const Volume volume = load_volume(folder() / "sky.exr");
    ASSERT_EQ(volume.slots(), 1U);
    for (int channel = 0; channel < 3; ++channel) {
        const double exact = 2 * std::sqrt(glm::pi<double>()) * (channel + 1);
        EXPECT_NEAR(volume.sh(0)[0][channel], exact, 5e-4 * exact) << "rounded to half";
    }
    ASSERT_EQ(run("--sun-sky 45,0").status, 0);
    EXPECT_TRUE(fs::exists(folder() / "sun-sky.probes.exr"));
}

TEST_F(LevelBake, LosesNothingWhereAnInputOrOutputIsWrong) {
    write("hall.probes.exr", "an earlier bake");
    write("hall.glb", "glTF no longer");
    write_floor("floor.glb");
    const std::string floor = bytes("floor.glb");
    const std::set<std::string> before = files();
    expect_refused("hall.glb", "hall.glb: ");
    expect_refused("nowhere.glb", "nowhere.glb: cannot be read: No such file");
    expect_refused("floor.glb --sky 1,1,1 -o floor.glb", "floor.glb: would replace what is to be baked");
    expect_refused("floor.glb --sky 1,1,1 --report-json floor.glb", "floor.glb: would replace what is to be baked");
    expect_refused("floor.glb --sky 1,1,1 --report floor.glb", "floor.glb: would replace what is to be baked");
    expect_refused("floor.glb --sky 1,1,1 --report nowhere/page.html", "nowhere/page.html: cannot be written");
    expect_refused("floor.glb --sky 1,1,1 --report a --report-json ./a", "a: is named for two outputs");
    expect_refused("floor.glb --sky 1,1,1 -o a --report a", "a: is named for two outputs");
    expect_refused("floor.glb --sky 1,1,1 -o nowhere/floor.exr", "nowhere/floor.exr: cannot be written");
    expect_refused("floor.glb --environment nowhere.hdr", "nowhere.hdr: cannot be read");
    expect_refused("floor.glb --scene 7", "scene 7");
    expect_refused("floor.glb --sky 1,1,1 --probes hall.glb", "hall.glb: ");
    EXPECT_EQ(run("floor.glb --sky 1,1,1 --samples 16 --spacing 1 -o /dev/full").status, 1);
    EXPECT_EQ(files(), before);
    EXPECT_EQ(bytes("hall.probes.exr"), "an earlier bake");
    EXPECT_EQ(bytes("floor.glb"), floor);
}

TEST_F(LevelBake, LeavesOutNodesByNameAndTheOtherProgramsFollowTheVolume) {
    const nlohmann::json lamp{
        {"name", "lamp"}, {"translation", {0, 3, 0}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}};
    const nlohmann::json lid{{"name", "lid"}, {"mesh", 0}, {"translation", {0, 2, 0}}};
    const std::vector<nlohmann::json> lights{{{"type", "point"}, {"intensity", 100}}};
    write_floor("lid.glb", {lamp, lid}, lights);
    write_floor("open.glb", {lamp}, lights);
    write("p.csv", "x,y,z,nx,ny,nz\n0,1,0,0,1,0\n");
    const std::string bake = "lid.glb --probes p.csv --samples 32 --quiet ";
    ASSERT_EQ(run(bake + "--ignore 'l?d' -o p.exr").status, 0);
    EXPECT_EQ(load_volume(folder() / "p.exr").settings.at("ignore"), "[\"l?d\"]");
    const auto direct = [&](const std::string& options) {
        const Result result = shell(
            fmt::format("{} reference lid.glb --points p.csv --samples 32 {} | tail -n 1", LIGHTGRID_PROGRAM, options));
        EXPECT_EQ(result.status, 0) << result.err;
        return result.out;
    };
    EXPECT_EQ(direct("--ignore lid").rfind("0,1,0,0,1,0,25,25,25,", 0), 0U) << "100 cd from 2 m";
    EXPECT_EQ(direct("").rfind("0,1,0,0,1,0,25,25,25,", 0), std::string::npos) << "the lid is in between";
    expect_refused(bake + "--ignore lit", "no node's name fits \"lit\"");
    expect_refused("--sky 1,1,1 --ignore lid", "no LEVEL that --ignore could be for");

    // The pattern goes with the volume: a level without such a node is not the one that was baked.
    ASSERT_EQ(run("lid.glb --ignore lid --spacing 1 --samples 32 --quiet -o v.exr").status, 0);
    const std::string draw = fmt::format("{} draw {{}} v.exr --width 320 {{}}", LIGHTGRID_PROGRAM);
    EXPECT_EQ(shell(fmt::format(fmt::runtime(draw), "lid.glb", "")).status, 0);
    const Result other = shell(fmt::format(fmt::runtime(draw), "open.glb", ""));
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("no node's name fits \"lid\""), std::string::npos) << other.err;
    EXPECT_EQ(shell(fmt::format(fmt::runtime(draw), "open.glb", "--ignore ''")).status, 0);
}

TEST_F(LevelBake, NamesAMeshThatKeepsTheSunFromAllProbes) {
    const double s = std::sqrt(0.5);  // a quarter turn: shines down
    const nlohmann::json sun{
        {"name", "Sun"}, {"rotation", {-s, 0, 0, s}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}};
    GltfBuilder gltf;
    gltf.use("KHR_lights_punctual");
    gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "directional"}, {"intensity", 1e5}}};
    std::vector<glm::vec3> corners;
    for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? 9 : -9, i & 2 ? 9 : -9, i & 4 ? 9 : -9);
    gltf.add("materials", {{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.5, 0.5, 1}}}}});
    const int box = gltf.mesh({{"attributes", {{"POSITION", gltf.vec3s(corners)}}},
                               {"material", 0},
                               {"indices", gltf.indices({1, 2, 0, 3, 2, 1, 6, 5, 4, 6, 7, 5, 4, 1, 0, 4, 5, 1,
                                                         3, 6, 2, 7, 6, 3, 2, 4, 0, 6, 4, 2, 5, 3, 1, 7, 3, 5})}});
    const int floor =
        gltf.mesh({{"attributes", {{"POSITION", gltf.vec3s({{-4, 0, 4}, {4, 0, 4}, {0, 0, -4}})}}}, {"material", 0}});
    gltf.json["scenes"][0]["nodes"] = {gltf.node({{"mesh", floor}, {"name", "yard"}}), gltf.node(sun),
                                       gltf.node({{"mesh", box}, {"name", "my dome*"}})};
    write("dome.glb", gltf.glb());
    const std::string bake = "dome.glb --volume -1,0.5,-1,1,1,1 --spacing 1 --samples 32 --method path -o v.exr --json";
    const Result result = run(bake);
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_NE(
        result.err.find("no light of the sun \"Sun\" was found at any of 18 probes: mesh \"my dome*\" is all around "
                        "and stops it. Where it should not, --ignore 'my dome\\*' leaves it out"),
        std::string::npos)
        << result.err;
    const nlohmann::json shut_out{
        {{"light", "the sun \"Sun\""}, {"mesh", "my dome*"}, {"node", 2}, {"from_all_points", true}}};
    EXPECT_EQ(nlohmann::json::parse(result.out).at("shut_out"), shut_out);
    EXPECT_EQ(json(bake + " --ignore 'my dome\\*'").at("shut_out"), nlohmann::json::array());
}

TEST_F(LevelBake, ALevelWithoutMaterialsIsGreyAndSaysSo) {
    write_room("blockout.glb", {});
    write_room("grey.glb", 0.8);
    const std::string few = " --samples 64 --spacing 1.5 -o ";
    const Result blockout = run("blockout.glb" + few + "blockout.exr");
    ASSERT_EQ(blockout.status, 0) << blockout.err;
    EXPECT_NE(blockout.err.find("no primitive has a material: albedo 0.8 is taken (--default-albedo)"),
              std::string::npos)
        << blockout.err;
    ASSERT_EQ(run("grey.glb" + few + "grey.exr --quiet").status, 0);
    EXPECT_EQ(load_volume(folder() / "blockout.exr").coefficients, load_volume(folder() / "grey.exr").coefficients);

    ASSERT_EQ(run("blockout.glb --default-albedo 0.4" + few + "dark.exr --quiet").status, 0);
    ASSERT_EQ(run("grey.glb --default-albedo 0.4" + few + "same.exr --quiet").status, 0);
    const Volume dark = load_volume(folder() / "dark.exr");
    EXPECT_EQ(dark.settings.at("default_albedo"), "0.4");
    EXPECT_LT(dark.sh(0)[0].g, 0.8F * load_volume(folder() / "grey.exr").sh(0)[0].g);
    EXPECT_EQ(load_volume(folder() / "same.exr").coefficients, load_volume(folder() / "grey.exr").coefficients)
        << "where a primitive has a material, the option changes nothing";
    expect_refused("blockout.glb --default-albedo 1.5", "1.5 is not a finite number from 0 to 1");
}

TEST_F(LevelBake, MissingTexturesAreNamedAndNoErrorIsJudged) {
    GltfBuilder gltf;
    gltf.add("images", {{"uri", "gone.png"}});
    gltf.add("textures", {{"source", 0}});
    gltf.add("materials", {{"pbrMetallicRoughness",
                            {{"baseColorFactor", {0.5, 0.5, 0.5, 1}}, {"baseColorTexture", {{"index", 0}}}}}});
    gltf.node({{"mesh", gltf.mesh({{"attributes",
                                    {{"POSITION", gltf.vec3s({{-1, 0, 1}, {1, 0, 1}, {0, 0, -1}})},
                                     {"TEXCOORD_0", gltf.vec2s({{0, 0}, {1, 0}, {0, 1}})}}},
                                   {"material", 0}})}});
    write("floor.glb", gltf.glb());
    const std::string bake = "floor.glb --sky 1,1,1 --spacing 1 --max-error 50% ";
    const Result result = run(bake + "--json");
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.err.find("missing texture: "), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("gone.png"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("not judged: 1 texture missing"), std::string::npos) << result.err;
    EXPECT_TRUE(nlohmann::json::parse(result.out).at("error").at("target_met").is_null());
    EXPECT_EQ(run(bake + "--strict").status, 1);
    expect_refused(bake + "--missing-textures error", "gone.png");
    expect_refused(bake + "--missing-textures maybe", "maybe is not known: there are warn and error");
}

TEST_F(LevelBake, AnOpenFloorHasHeadroom) {
    write_floor("floor.glb");
    const auto top = [&](const std::string& options) {
        EXPECT_EQ(run("floor.glb --sky 1,1,1 --samples 64 -o floor.exr --quiet " + options).status, 0);
        const Grid grid = load_volume(folder() / "floor.exr").grids.at(0);
        return grid.position(grid.counts - 1).y;
    };
    EXPECT_NEAR(top(""), 0.5, 1e-4) << "a quarter of the width";
    EXPECT_NEAR(top("--spacing 0.5"), 0.5, 1e-4);
    EXPECT_NEAR(top("--volume=-1,0,-1,1,0.25,1"), 0.25, 1e-6) << "a box that was asked for";
}

TEST_F(LevelBake, OfALevelInOtherUnitsTheSameProbesGetTheSameLight) {
    // A power of two, so that rounding is the same, too.
    write_yard("metres.glb", 1);
    write_yard("small.glb", 128);
    const std::string bake = " --sky 1,2,3 --spacing 1.25 --samples 64 --seed 3 --verbose --report-json ";
    const Result metres = run("metres.glb -o metres.exr" + bake + "metres.json");
    ASSERT_EQ(metres.status, 0) << metres.err;
    const Result small = run("small.glb --scale 0.0078125 -o small.exr" + bake + "small.json");
    ASSERT_EQ(small.status, 0) << small.err;
    const Volume wanted = load_volume(folder() / "metres.exr");
    const Volume volume = load_volume(folder() / "small.exr");
    ASSERT_EQ(volume.grids.size(), wanted.grids.size());
    for (std::size_t i = 0; i < wanted.grids.size(); ++i) {
        EXPECT_EQ(volume.grids[i].counts, wanted.grids[i].counts);
        EXPECT_EQ(volume.grids[i].origin, 128.0 * wanted.grids[i].origin);
        EXPECT_EQ(volume.grids[i].spacing, 128.0 * wanted.grids[i].spacing);
    }
    EXPECT_EQ(volume.states, wanted.states);
    EXPECT_EQ(volume.coefficients, wanted.coefficients);
    EXPECT_EQ(volume.settings.at("scale"), "0.0078125");
    EXPECT_EQ(wanted.settings.count("scale"), 0U);
    const nlohmann::json report = nlohmann::json::parse(bytes("small.json"));
    EXPECT_EQ(report.at("scene").at("metres_per_unit"), 0.0078125);
    EXPECT_EQ(report.at("scene").at("size"), nlohmann::json({2560, 512, 2560}));
    const nlohmann::json wanted_report = nlohmann::json::parse(bytes("metres.json"));
    EXPECT_EQ(report.at("spacing"), wanted_report.at("spacing"));
    EXPECT_EQ(report.at("remedies").at(2).at("option"), wanted_report.at("remedies").at(2).at("option"));
    const auto lengths = [](const std::string& said) {
        std::vector<std::string> lines;
        for (const char* name : {"level  ", "grid  ", "spacing  ", "cache  "}) {
            const std::size_t line = said.rfind(std::string("\n") + name);
            if (line != std::string::npos) lines.push_back(said.substr(line + 1, said.find('\n', line + 1) - line));
        }
        lines.at(0).erase(0, lines.at(0).find(':'));
        return lines;
    };
    EXPECT_EQ(lengths(small.err), lengths(metres.err));
    EXPECT_EQ(lengths(metres.err).size(), 4U) << metres.err;
    const auto view = [&](const std::string& name) {
        const Result drawn = shell(fmt::format("{} draw {}.glb {}.exr -o {} --width 320 --normal-bias 0.5",
                                               LIGHTGRID_PROGRAM, name, name, name));
        EXPECT_EQ(drawn.status, 0) << drawn.err;
        return bytes(name + "/view.png");
    };
    EXPECT_EQ(view("small"), view("metres")) << "eyes at 1.6 m, and a bias of 0.5 m";

    ASSERT_EQ(
        run("small.glb --quiet -o unscaled.exr --max-probes 100000 --spacing 160 --sky 1,2,3 --samples 64").status, 0);
    const Grid unscaled = load_volume(folder() / "unscaled.exr").grids.at(0);
    EXPECT_LT(unscaled.position(unscaled.counts - 1).y, 515) << "headroom of 2 units above the block";
    expect_refused("small.glb --scale 0 --sky 1,1,1", "--scale: 0 is not a finite number from 1e-06 to 1000000");
    expect_refused("--scale 0.01 --sky 1,1,1", "no LEVEL that --scale could be for");
}

TEST_F(LevelBake, ALevelInCentimetresGetsAHintAndNothingElse) {
    write_room("metres.glb", 0.5);
    write_room("centimetres.glb", 0.5, 100);
    const std::string bake = " --max-probes 60 --samples 64 -o v.exr ";
    const auto said = [&](const std::string& call) {
        const Result result = run(call + bake);
        EXPECT_EQ(result.status, 0) << result.err;
        return result.err;
    };
    const std::string hint =
        "the unit of this level may not be the metre: its rooms would be 300 m high. If it is the centimetre: --scale "
        "0.01; if the metre: --scale 1";
    EXPECT_NE(said("centimetres.glb").find(hint), std::string::npos);
    EXPECT_EQ(load_volume(folder() / "v.exr").settings.count("scale"), 0U) << "it is only said";
    EXPECT_EQ(said("centimetres.glb --scale 0.01").find("may not be"), std::string::npos);
    EXPECT_EQ(said("centimetres.glb --scale 1").find("may not be"), std::string::npos);
    EXPECT_EQ(said("metres.glb").find("may not be"), std::string::npos);
}

TEST_F(LevelBake, LeavesNothingHalfWrittenWhenItIsStopped) {
    write("hall.probes.exr", "an earlier bake");
    // A test may itself run with SIGINT ignored, which a program inherits, hence `env`.
    for (const auto& [signal, status] : {std::pair("INT", 130), std::pair("TERM", 143)}) {
        const Result result =
            shell(fmt::format("timeout --preserve-status --kill-after=20 --signal={} 0.5 env --default-signal=INT {} "
                              "{} --samples 100000000 "
                              "--spacing 1 -o hall.probes.exr",
                              signal, LEVEL_BAKE_PROGRAM, cornell));
        EXPECT_EQ(result.status, status) << result.err;
        EXPECT_EQ(files(), (std::set<std::string>{"hall.probes.exr"}));
        EXPECT_EQ(bytes("hall.probes.exr"), "an earlier bake");
    }
}

// ---- What is printed

TEST_F(LevelBake, TellsBeforeAndAfterTheBakeWhatItDoes) {
    const Result result = run(cornell + " --samples 20 --spacing 1 --verbose");
    for (const char* part : {"level      cornell.glb: ", "probes     ", " inside solids", "estimate   ", " of memory",
                             "left out   environment look-ups: ", "32 per probe in 16 replicates (20 asked, rounded up",
                             "\nload ", "\ngather ", "Mrays/s", "noise      ", "written    cornell.probes.exr ("}) {
        EXPECT_NE(result.err.find(part), std::string::npos) << part << "\n" << result.err;
    }
    EXPECT_LT(result.err.find("estimate   "), result.err.find("gather ..."));
    EXPECT_EQ(result.err.find_first_of("\r\x1b"), std::string::npos) << "no terminal: plain lines\n" << result.err;
}

TEST_F(LevelBake, SaysTheEssentialsOnAScreenful) {
    const Result result = run(cornell + " --max-error 30% --spacing 1");
    for (const char* part :
         {"level      cornell.glb: ", "\nprobes     ", " in a grid, ", "\nestimate   ", "\nbaked in   ",
          "\nerror      ", "\nverdict    target ", " things: --verbose lists them\n", "\nwritten    "}) {
        EXPECT_NE(result.err.find(part), std::string::npos) << part << "\n" << result.err;
    }
    std::size_t lines = 0;  // without those that a terminal shows as one moving bar
    std::istringstream text(result.err);
    for (std::string line; std::getline(text, line);) {
        const bool is_progress = line.ends_with(" ...") || line.find(" %, ") != std::string::npos ||
                                 line.ends_with("0 %") || line.ends_with("5 %");
        lines += is_progress ? 0 : 1;
        EXPECT_EQ(line.find("-0"), std::string::npos) << line;
    }
    EXPECT_LE(lines, 14U) << result.err;
    EXPECT_EQ(result.err.find("left out   environment"), std::string::npos) << result.err;
}

TEST_F(LevelBake, TheOnlyLightBeingOutOfSightIsNotATargetMet) {
    write_floor("floor.glb");
    const nlohmann::json report = json("floor.glb --volume=-1,0.5,-1,1,1,1 --json");
    EXPECT_TRUE(report["error"]["target_met"].is_null());
    EXPECT_EQ(report["target"]["verdict"], "not judged: nothing shines, all is black");
}

TEST_F(LevelBake, ALitWindowInADarkFacadeIsNotMissed) {
    // A facade of 16 x 16 m, all black but 2 x 2 of its 512 x 512 texels.
    constexpr int texels = 512;
    constexpr float radiance = 1e5F;
    ByteImage image{texels, texels, std::vector<glm::u8vec4>(std::size_t{texels} * texels, glm::u8vec4(0, 0, 0, 255))};
    for (const glm::ivec2 lit : {glm::ivec2(351, 167), {352, 167}, {351, 168}, {352, 168}})
        image.at(lit.x, lit.y) = glm::u8vec4(255);
    GltfBuilder gltf;
    gltf.use("KHR_materials_emissive_strength");
    gltf.add("samplers", {{"magFilter", 9728}, {"minFilter", 9728}});
    const int texture = gltf.texture(image, {{"sampler", 0}});
    gltf.add("materials", {{"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}}},
                           {"emissiveFactor", {1, 1, 1}},
                           {"emissiveTexture", {{"index", texture}}},
                           {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", radiance}}}}}});
    const int positions = gltf.vec3s({{-8, 0, 0}, {8, 0, 0}, {8, 16, 0}, {-8, 16, 0}});
    const int coordinates = gltf.vec2s({{0, 1}, {1, 1}, {1, 0}, {0, 0}});
    gltf.node({{"mesh", gltf.mesh({{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", coordinates}}},
                                   {"material", 0},
                                   {"indices", gltf.indices({0, 1, 2, 0, 2, 3})}})}});
    write("facade.glb", gltf.glb());
    // The window's centre is at 352 / 512 of the width from the left, and 168 / 512 of the height from above: (3, 10.75, 0).
    const Result baked = run("facade.glb --volume 2,9.75,4,4,11.75,6 --report-json r.json -o v.exr");
    ASSERT_EQ(baked.status, 0) << baked.err;
    EXPECT_EQ(baked.err.find("no light"), std::string::npos) << baked.err;
    EXPECT_EQ(baked.err.find("no surface emits"), std::string::npos) << baked.err;
    write("p.csv", "x,y,z,nx,ny,nz\n3,10.75,5,0,0,-1\n");
    const auto irradiance = [&](const std::string& call) {
        const Result result =
            shell(fmt::format("{} {} --points p.csv | tail -n 1 | cut -d, -f7", LIGHTGRID_PROGRAM, call));
        EXPECT_EQ(result.status, 0) << result.err;
        return std::stod(result.out);
    };
    const double side = 2 * 16.0 / texels;
    const double exact = radiance * side * side / (5 * 5);
    EXPECT_NEAR(irradiance("reference facade.glb --samples 256"), exact, 0.01 * exact);
    // Three bands of a distant light peak at 17/16 of it.
    EXPECT_NEAR(irradiance("query v.exr"), 1.0625 * exact, 0.03 * exact);
}

TEST_F(LevelBake, AdviceOfTheReportIsAccepted) {
    // A limit that half the spacing does not fit, and grids that are refined.
    for (const auto& [fixed, instead] :
         {std::pair<std::string, std::string>{"--spacing 2 --samples 32 --max-probes 100", "--samples 16"},
          std::pair<std::string, std::string>{"--volume 0.3,0.3,0.3,5.2,3,5.2 --max-error 30% --bands 2", ""}}) {
        const nlohmann::json report = json(cornell + " --seed 3 " + fixed + " --report-json r.json --json -o a.exr");
        ASSERT_GE(report["remedies"].size(), 2U);
        for (const nlohmann::json& remedy : report["remedies"]) {
            const std::string option = remedy["option"];
            std::string call = cornell + " " + option + " -o b.exr --quiet";
            if (option.find("--samples") == std::string::npos) call += " " + instead;
            if (option.find("--max-error") == std::string::npos && instead.empty()) call += " --spacing 2";
            if (option.find("--spacing") == std::string::npos) call += " --volume 0.3,0.3,0.3,1.2,1,1.2";
            const Result followed = run(call);
            EXPECT_EQ(followed.status, 0) << option << "\n" << followed.err;
        }
    }
}

TEST_F(LevelBake, PrintsTheSummaryAsJsonAndNothingElseWithJson) {
    const Result result = run(cornell + " --samples 16 --spacing 1 --json --quiet");
    EXPECT_EQ(result.err, "");
    const auto summary = nlohmann::json::parse(result.out);
    EXPECT_EQ(summary["output"], "cornell.probes.exr");
    EXPECT_EQ(summary["samples"], 16);
    EXPECT_EQ(summary["bytes"], fs::file_size(folder() / "cornell.probes.exr"));
    EXPECT_TRUE(summary["error"]["relrmse"].is_null()) << "not asked for";
    EXPECT_GT(summary["error"]["parts"]["noise"]["relrmse"], 0.0);
}

TEST_F(LevelBake, ReportsErrorCurveStagesAndWhatItLeftOut) {
    ASSERT_EQ(run(cornell + " --samples 64 --spacing 1 --report-json report.json --quiet").status, 0);
    const auto report = nlohmann::json::parse(bytes("report.json"));
    const auto& error = report["error"];
    EXPECT_LE(error["interval"][0], error["relrmse"]);
    EXPECT_GE(error["interval"][1], error["relrmse"]);
    for (const char* part : {"noise", "bands", "interpolation"}) {
        EXPECT_GT(error["parts"][part]["relrmse"], 0.0) << part;
        EXPECT_EQ(error["parts"][part]["interval"].size(), 2U) << part;
    }
    EXPECT_TRUE(error["target_met"].is_null()) << "no target was given";
    ASSERT_GE(report["curve"].size(), 2U);
    EXPECT_GT(report["curve"].front()["relrmse"], report["curve"].back()["relrmse"]);
    EXPECT_LT(report["curve"].front()["seconds"], report["curve"].back()["seconds"]);
    EXPECT_EQ(report["curve"].back()["interval"].size(), 2U);
    std::set<std::string> stages;
    for (const auto& stage : report["stages"]) {
        stages.insert(stage["name"]);
        EXPECT_GE(stage["seconds"], 0.0);
        EXPECT_GE(stage["rays"], 0);
    }
    for (const char* name : {"load", "gather", "reference", "save"}) EXPECT_EQ(stages.count(name), 1U) << name;
    ASSERT_FALSE(report["left_out"].empty());
    for (const auto& item : report["left_out"]) {
        for (const char* key : {"what", "evidence", "saved"}) EXPECT_NE(item[key], "") << item;
    }
}

TEST_F(LevelBake, SaysWhatTheErrorIsMadeOfInSquares) {
    const Result result = run(cornell + " --samples 64 --spacing 1 --report-json report.json --verbose");
    const auto squares = nlohmann::json::parse(bytes("report.json"))["error"]["squares"];
    double sum = 0;
    for (const char* part : {"noise", "bands", "interpolation", "bias", "storage", "cross"}) {
        sum += squares[part].get<double>();
    }
    EXPECT_NEAR(sum, squares["total"].get<double>(), 1e-9);
    EXPECT_NE(result.err.find("in squares: "), std::string::npos) << result.err;
}

TEST_F(LevelBake, ComparesTheWaysToKeepAndReadTheVolume) {
    ASSERT_EQ(run(cornell + " --samples 64 --spacing 1 --report-json report.json --quiet").status, 0);
    const auto report = nlohmann::json::parse(bytes("report.json"));
    ASSERT_EQ(report["look_ups"].size(), 12U) << "L0 to L2, float and half, trilinear and nearest";
    int own = 0;
    for (const auto& look_up : report["look_ups"]) {
        if (!look_up["this_bake"]) continue;
        ++own;
        EXPECT_EQ(look_up["storage"], report["storage"]);
        EXPECT_EQ(look_up["bands"], 3);
        EXPECT_NEAR(look_up["relrmse"].get<double>(), report["error"]["relrmse"].get<double>(), 1e-9);
    }
    EXPECT_EQ(own, 1);
}

TEST_F(LevelBake, WritesAPageThatNeedsNothingElse) {
    ASSERT_EQ(run(cornell + " --samples 64 --spacing 1 --report page.html --quiet").status, 0);
    EXPECT_EQ(files(), (std::set<std::string>{"cornell.probes.exr", "page.html"}));
    const std::string page = bytes("page.html");
    EXPECT_EQ(page.rfind("<!DOCTYPE html>", 0), 0U);
    EXPECT_EQ(page.find("</html>\n"), page.size() - 8) << "whole";
    EXPECT_EQ(page.find("://"), std::string::npos) << "no address of anything";
    EXPECT_EQ(page.find("<script"), std::string::npos);
    EXPECT_NE(page.find("cornell.glb"), std::string::npos);
}

TEST_F(LevelBake, LeavesAnEarlierPageWhereItCannotWriteAnother) {
    write("page.html", "an earlier page");
    EXPECT_EQ(run(cornell + " --samples 16 --spacing 1 -o /dev/full --report page.html").status, 1);
    EXPECT_EQ(bytes("page.html"), "an earlier page");
    EXPECT_EQ(run(cornell + " --samples 16 --spacing 1 --report /dev/full").status, 1);
}

TEST_F(LevelBake, WritesAPageWithoutAMeasuredErrorToo) {
    write_floor("floor.glb");
    write("points.csv", "x,y,z\n0,0.5,0\n");
    for (const char* call : {"floor.glb --sky 1,1,1 --samples 16 --probes points.csv", "--sky 1,1,1"}) {
        ASSERT_EQ(run(std::string(call) + " -o list.exr --report page.html --quiet").status, 0) << call;
        EXPECT_NE(bytes("page.html").find("a list has no cells"), std::string::npos) << call;
    }
}

TEST_F(LevelBake, EscapesWhatItIsCalledWith) {
    write_floor("a<b>&'c'.glb");
    ASSERT_EQ(run("\"a<b>&'c'.glb\" --sky 1,1,1 --samples 16 --spacing 1 --report page.html --quiet").status, 0);
    EXPECT_EQ(bytes("page.html").find("<b>&"), std::string::npos);
    EXPECT_NE(bytes("page.html").find("<h1>a&lt;b&gt;&amp;&#39;c&#39;.glb</h1>"), std::string::npos);
}

TEST_F(LevelBake, SaysNothingButErrorsWithQuiet) {
    write_floor("floor.glb");
    const Result result = run("floor.glb --samples 16 --spacing 1 --quiet");  // without light: a warning otherwise
    EXPECT_EQ(result.status, 0);
    EXPECT_EQ(result.out + result.err, "");
    EXPECT_NE(run("nowhere.glb --quiet").err, "");
}

TEST_F(LevelBake, AnswersForHelpAndVersionOnStandardOutput) {
    EXPECT_EQ(run("--version").out.rfind("level-bake ", 0), 0U);
    const Result help = run("--help");
    EXPECT_EQ(help.status, 0);
    EXPECT_EQ(help.err, "");
    for (const char* option : {"--environment ",
                               "--environment-layout",
                               "--environment-rotation",
                               "--environment-intensity",
                               "--sky ",
                               "--sun-sky",
                               "--spacing",
                               "--volume",
                               "--probes",
                               "--scene",
                               "--ignore",
                               "--max-probes",
                               "--samples",
                               "--max-error",
                               "--time-budget",
                               "--bands",
                               "--method",
                               "--seed",
                               "--threads",
                               "--layers",
                               "--report ",
                               "--report-json",
                               "--json",
                               "--quiet"}) {
        EXPECT_NE(help.out.find(option), std::string::npos) << option;
    }
}

TEST_F(LevelBake, ReportsEveryWrongOptionAndWhatItMayHaveMeant) {
    const Result result =
        run("a.glb --smaples 3 --bands 99 --sky 1,2 --threads -1 --spacing 0 --volume 0,0,0,1,1 --samples much");
    EXPECT_EQ(result.status, 2);
    for (const char* part : {"--smaples (did you mean --samples?)", "--bands: ", "--sky: ", "--threads: ",
                             "--spacing: ", "--volume: ", "--samples: ", "See level-bake --help."}) {
        EXPECT_NE(result.err.find(part), std::string::npos) << part << "\n" << result.err;
    }
    expect_refused("", "no LEVEL");
    expect_refused("a.glb --probes p.csv --spacing 1", "--probes is a list of its own");
    expect_refused("a.glb b.glb", "argument \"b.glb\" is one too many");
    expect_refused("a.glb --spacing 0", "--spacing: 0 is no distance between probes: it must be above 0, like 0.5");
    expect_refused("a.glb --quiet --verbose", "--quiet excludes --verbose");
    expect_refused("-- a.glb --samples 4", "\"--samples\" is one too many: what follows -- is a file's name");
    write_floor("-dash.glb");
    expect_refused("-dash.glb", "-dash.glb reads as an option: for the file of that name, write ./-dash.glb");
    EXPECT_EQ(run("--sky 1,1,1 --samples 16 --spacing 1 --quiet -- -dash.glb").status, 0);
    EXPECT_TRUE(fs::exists(folder() / "-dash.probes.exr"));
    expect_refused("-o out.png -- -dash.glb",
                   "out.png: a volume is an OpenEXR file, not a .png file. Name it out.probes.exr.");
    expect_refused("a.glb --spacing nan", "--spacing: ");
    expect_refused("a.glb --sky 1,1,inf", "--sky: ");
}

TEST_F(LevelBake, RefusesAGridTooLargeToBeMeantBeforeItAllocatesAnything) {
    expect_refused(cornell + " --spacing 1e-5", "GB), more than --max-probes 65536");
    expect_refused(cornell + " --volume 0,0,0,1e9,1e9,1e9 --spacing 1e-9", "more than --max-probes 65536");
}

// ---- Where and how much

TEST_F(LevelBake, GathersListedProbesWhereTheyAreInTheirOrder) {
    write_floor("floor.glb");
    const std::string points = "z,name,x,y\n0,a,0.5,1\n0.25,b,0,2\n0,c,0.5,1\n";
    write("points.csv", points);
    ASSERT_EQ(run("floor.glb --sky 1,1,1 --samples 64 --probes points.csv -o list.exr --quiet").status, 0);
    const Volume list = load_volume(folder() / "list.exr");
    EXPECT_EQ(list.list, (std::vector<glm::dvec3>{{0.5, 1, 0}, {0, 2, 0.25}, {0.5, 1, 0}}));
    ASSERT_EQ(shell("printf '" + points +
                    "' | " LEVEL_BAKE_PROGRAM " floor.glb --sky 1,1,1 --samples 64 --probes - -o piped.exr --quiet")
                  .status,
              0);
    EXPECT_EQ(bytes("list.exr"), bytes("piped.exr"));
    write("empty.csv", "x,y,z\n");
    expect_refused("floor.glb --sky 1,1,1 --probes empty.csv", "empty.csv: has no points");
    expect_refused("floor.glb --sky 1,1,1 --probes points.csv --max-probes 2", "3 points, more than --max-probes 2");
}

TEST_F(LevelBake, PlacesProbesWhereTheLevelsMarkersAre) {
    // A marked node's box is that of its mesh, or the unit cube without one: here 2 m about (0, 1, 0).
    write_floor(
        "floor.glb",
        {{{"name", "here"}, {"translation", {0, 1, 0}}, {"scale", {2, 2, 2}}, {"extras", {{"lightgrid", "volume"}}}},
         {{"name", "spot"}, {"translation", {0.1, 5, 0.2}}, {"extras", {{"lightgrid", "probe"}}}}});
    const Result result = run("floor.glb --sky 1,1,1 --samples 16 --spacing 1 --verbose");
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.err.find("over the box marked in the level"), std::string::npos) << result.err;
    const Volume volume = load_volume(folder() / "floor.probes.exr");
    ASSERT_EQ(volume.grids.size(), 1U);
    EXPECT_EQ(volume.grids[0].counts, glm::ivec3(3));
    EXPECT_NEAR(volume.grids[0].origin.y, 0, 1e-6);
    ASSERT_EQ(volume.list.size(), 1U);
    EXPECT_LT(glm::distance(volume.list[0], glm::dvec3(0.1, 5, 0.2)), 1e-6);
}

TEST_F(LevelBake, FillsEveryGivenBox) {
    write_floor("floor.glb");
    ASSERT_EQ(
        run("floor.glb --sky 1,1,1 --samples 16 --spacing 0.5 --volume 1,2,3,0,1,2 --volume=-2,0,0,-1,1,0.5 --quiet")
            .status,
        0);
    const Volume volume = load_volume(folder() / "floor.probes.exr");
    ASSERT_EQ(volume.grids.size(), 2U);
    EXPECT_EQ(volume.grids[0].origin, glm::dvec3(0, 1, 2)) << "corners in any order";
    EXPECT_EQ(volume.grids[1].counts, glm::ivec3(3, 3, 2));
}

TEST_F(LevelBake, WarnsWhereThereIsNoLight) {
    write_floor("floor.glb");
    const Result result = run("floor.glb --samples 16 --spacing 1");
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.err.find("warning: the level has no light of its own"), std::string::npos) << result.err;
}

TEST_F(LevelBake, WarnsWhereNoProbeIsValidAndKeepsWhatWasGathered) {
    write_block("block.glb");
    write("inside.csv", "x,y,z\n0,0,0\n");
    const Result result = run("block.glb --sky 1,1,1 --probes inside.csv --samples 16 -o inside.exr");
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.err.find("warning: no probe is valid"), std::string::npos) << result.err;
    const Volume list = load_volume(folder() / "inside.exr");
    ASSERT_EQ(list.slots(), 1U);
    EXPECT_FALSE(is_valid(list.states[0]));
    EXPECT_EQ(list.sh(0)[0], glm::vec3(0)) << "no light gets in";
}

// ---- The same bits

TEST_F(LevelBake, TheBytesDependOnLevelOptionsAndSeedOnly) {
    const auto bake = [&](const std::string& options) {
        EXPECT_EQ(run(options + " --samples 32 --spacing 0.8 --quiet").status, 0) << options;
    };
    bake(cornell + " -o one.exr --threads 1");
    bake(cornell + " -o two.exr --threads 2");
    fs::create_directories(folder() / "elsewhere");
    fs::copy_file(cornell, folder() / "elsewhere/cornell.glb");
    bake("elsewhere/cornell.glb -o there.exr --report-json report.json");
    bake(cornell + " -o other.exr --seed 1");
    EXPECT_EQ(bytes("one.exr"), bytes("two.exr"));
    EXPECT_EQ(bytes("one.exr"), bytes("there.exr"));
    EXPECT_NE(bytes("one.exr"), bytes("other.exr"));
}

TEST_F(LevelBake, TheCacheGivesTheLightOfPathsAndTheSameBytesForAnyNumberOfThreads) {
    const auto bake = [&](const std::string& arguments) {
        const Result result = run(cornell + " --spacing 1 --samples 1024 --quiet " + arguments);
        EXPECT_EQ(result.status, 0) << result.err;
        return result;
    };
    bake("--method path -o path.exr");
    bake("--method cache -o cache.exr --threads 1");
    bake("--method cache -o two.exr --threads 2");
    EXPECT_EQ(bytes("cache.exr"), bytes("two.exr"));
    const Volume paths = load_volume(folder() / "path.exr");
    const Volume cached = load_volume(folder() / "cache.exr");
    EXPECT_EQ(paths.settings.at("method"), "path");
    EXPECT_EQ(cached.settings.at("method"), "cache");
    double squares = 0;
    double power = 0;
    for (std::size_t slot = 0; slot < paths.slots(); ++slot) {
        if (!is_valid(paths.states[slot])) continue;
        const glm::dvec3 difference(cached.sh(slot)[0] - paths.sh(slot)[0]);
        squares += glm::dot(difference, difference);
        power += glm::dot(glm::dvec3(paths.sh(slot)[0]), glm::dvec3(paths.sh(slot)[0]));
    }
    EXPECT_LT(std::sqrt(squares / power), 0.03) << "1,024 rays leave a percent or two of noise";
}

// ---- Kept transport

TEST_F(LevelBake, KeepsTransportAndSolvesAChangeOfLightsWithoutARay) {
    const std::string call = "'" + cornell + "' --spacing 0.8 --samples 64 --keep-transport kept --json ";
    const auto first = json(call + "-o a.exr --sky 0.1,0.1,0.1");
    EXPECT_EQ(first.at("transport"), "traced");
    EXPECT_EQ(json(call + "-o b.exr --sky 0.1,0.1,0.1 --threads 1").at("transport"), "kept");
    EXPECT_EQ(bytes("a.exr"), bytes("b.exr"));
    const std::string kept = bytes("kept");

    const auto under_sky = json(call + "-o c.exr --sky 1,1,1");
    EXPECT_EQ(under_sky.at("transport"), "kept");
    EXPECT_EQ(under_sky.at("rays").at("gather"), 0);
    EXPECT_TRUE(under_sky.at("error").at("relrmse").is_null());
    EXPECT_NE(under_sky.at("error").at("not_measured").get<std::string>().find("kept transport"), std::string::npos);
    EXPECT_NE(bytes("a.exr"), bytes("c.exr"));
    EXPECT_EQ(bytes("kept"), kept) << "it is of the light of the first bake";
}

TEST_F(LevelBake, TransportOfSomethingElseIsMadeAnewAndSaidSo) {
    const std::string call = "'" + cornell + "' --samples 64 --keep-transport kept --json ";
    ASSERT_EQ(json(call + "--spacing 0.8 -o a.exr").at("transport"), "traced");
    const Result other = run(call + "--spacing 0.9 -o b.exr");
    EXPECT_EQ(nlohmann::json::parse(other.out).at("transport"), "traced");
    EXPECT_NE(other.err.find("kept: is of another level, other options or another version"), std::string::npos);
    EXPECT_EQ(json(call + "--spacing 0.9 -o c.exr").at("transport"), "kept");
    EXPECT_EQ(bytes("b.exr"), bytes("c.exr"));
}

TEST_F(LevelBake, RefusesTransportThatIsDamagedOrDoesNotFit) {
    write("kept", "lightgrid.keep.1 and no more");
    write("other", "notes");
    const std::string call = "'" + cornell + "' --spacing 0.8 --samples 64 -o a.exr ";
    expect_refused(call + "--keep-transport kept", "kept: is damaged");
    expect_refused(call + "--keep-transport other", "other: holds no transport");
    expect_refused(call + "--keep-transport a.exr", "a.exr: is named for two outputs");
    expect_refused(call + "--keep-transport k --method path", "--keep-transport needs --method cache");
    expect_refused("'" + cornell + "' --time-budget 60 --keep-transport k", "--keep-transport excludes --time-budget");
    expect_refused("'" + cornell + "' --max-error 5% --strict --keep-transport k",
                   "--keep-transport excludes --strict");
    EXPECT_EQ(bytes("other"), "notes");
    EXPECT_EQ(files(), (std::set<std::string>{"kept", "other"}));
    ASSERT_EQ(run(call + "--keep-transport k").status, 0);
    const Result under_sky = run(call + "--keep-transport k --sky 1,1,1 --json");
    EXPECT_NE(under_sky.err.find("k: is of a level without a sky"), std::string::npos) << under_sky.err;
    EXPECT_EQ(nlohmann::json::parse(under_sky.out).at("transport"), "traced");
    fs::remove(folder() / "k");
    const Result few = run("'" + cornell + "' --spacing 5 --samples 64 -o a.exr --keep-transport k");
    EXPECT_EQ(few.status, 0) << few.err;
    EXPECT_NE(few.err.find("k: is not written"), std::string::npos) << few.err;
    EXPECT_FALSE(fs::exists(folder() / "k"));
}

TEST_F(LevelBake, FewProbesAreGatheredByPathsEvenWhereACacheIsAskedFor) {
    write("points.csv", "x,y,z\n0,2,0\n1,1,1\n");
    const std::string same = cornell + " --probes points.csv --samples 256 --quiet";
    ASSERT_EQ(run(same + " --method path -o path.exr").status, 0);
    ASSERT_EQ(run(same + " --method cache -o cache.exr").status, 0);
    EXPECT_EQ(bytes("path.exr"), bytes("cache.exr"));
}

// ---- Targets

TEST_F(LevelBake, MeetsAnErrorByFinerGridsWithTheSameBytesForAnyNumberOfThreads) {
    // Without the lamp and what is next to it: single points there decide what is measured.
    const std::string call = cornell + " --volume 0.3,0.3,0.3,5.2,3,5.2 --max-error 8% --strict --quiet";
    ASSERT_EQ(run(call + " --threads 2 -o two.exr --report-json report.json").status, 0);
    const auto report = nlohmann::json::parse(bytes("report.json"));
    EXPECT_TRUE(report["error"]["target_met"].get<bool>());
    EXPECT_LT(report["error"]["interval"][1], 0.08);
    EXPECT_GT(report["target"]["rounds"][0]["interpolation"], report["target"]["rounds"].back()["interpolation"]);
    ASSERT_GE(report["grids"].size(), 2U);
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(report["grids"][1]["spacing"][axis], report["grids"][0]["spacing"][axis].get<double>() / 2);
    }
    ASSERT_EQ(run(call + " --threads 1 -o one.exr").status, 0);
    EXPECT_EQ(bytes("one.exr"), bytes("two.exr"));
    check_volume(load_volume(folder() / "one.exr"));
}

TEST_F(LevelBake, WithoutATargetAimsAtTheDefaultForAllButBands) {
    write_floor("floor.glb");
    const Result result = run("floor.glb --sky 1,1,1 --volume=-0.9,0.2,-0.9,0.9,1,0.9 --json --quiet");
    ASSERT_EQ(result.status, 0) << result.err;
    const auto summary = nlohmann::json::parse(result.out);
    EXPECT_EQ(summary["target"]["error_without_bands"], 0.02);
    EXPECT_TRUE(summary["error"]["target_met"].get<bool>()) << summary["target"];
    EXPECT_EQ(summary["bands"], 3);
    EXPECT_GT(summary["error"]["parts"]["bands"]["relrmse"], 0.0) << "what the missing bands cost";
}

TEST_F(LevelBake, SaysWhyAnErrorIsNotReachedAndWritesTheVolume) {
    const std::string call = cornell + " --max-error 4% --spacing 1 --report-json report.json";
    const Result result = run(call);
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.err.find("target not reached: interpolation "), std::string::npos) << result.err;
    EXPECT_FALSE(nlohmann::json::parse(bytes("report.json"))["error"]["target_met"].get<bool>());
    fs::remove(folder() / "cornell.probes.exr");
    EXPECT_EQ(run(call + " --strict").status, 1);
    EXPECT_EQ(load_volume(folder() / "cornell.probes.exr").grids.size(), 1U) << "the spacing was given";
}

TEST_F(LevelBake, TheTargetOfAListIsForItsProbes) {
    write("points.csv", "x,y,z\n1,1,1\n2,3,1\n");
    const Result result = run(cornell + " --max-error 3% --probes points.csv --json --report-json report.json");
    ASSERT_EQ(result.status, 0) << result.err;
    const auto summary = nlohmann::json::parse(result.out);
    EXPECT_TRUE(summary["error"]["target_met"].get<bool>()) << summary["target"];
    EXPECT_LT(summary["noise"], 0.03);
    EXPECT_FALSE(summary["error"]["not_measured"].get<std::string>().empty());
}

TEST_F(LevelBake, TargetsExcludeEachOther) {
    expect_refused("a.glb --samples 64 --max-error 2%", "exclude each other");
    expect_refused("a.glb --max-error 2", "2 is not a percentage");
    expect_refused("a.glb --time-budget 5s", "--time-budget: ");
    expect_refused("a.glb --samples 64 --strict", "--strict needs an error to reach");
}

TEST_F(LevelBake, PlacesProbesTheSameWithAnyNumberOfThreads) {
    // With bricks of probes that depend on their neighbours: under the ground, and behind outer walls.
    for (const int threads : {1, 2, 2, 4}) {
        const Result result = run(fmt::format("{} --sky 1,1,1 --samples 16 --threads {} -o {}.exr --quiet",
                                              LIGHTGRID_SCENES "/courtyard.glb", threads, threads));
        EXPECT_EQ(result.status, 0) << result.err;
        EXPECT_EQ(bytes("1.exr"), bytes(fmt::format("{}.exr", threads))) << threads << " threads";
    }
}

// ---- Layers

TEST_F(LevelBake, BakesLayersOfGroupsAndListsThem) {
    const nlohmann::json lamp = {{"translation", {0, 1, 0}},
                                 {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}},
                                 {"extras", {{"lightgrid", {{"group", "lamps"}}}}}};
    nlohmann::json sign = lamp;
    sign["extras"]["lightgrid"]["group"] = "signs";
    write_floor("lit.glb", {lamp, sign}, {{{"type", "point"}, {"intensity", 5}}});
    const std::string call = "lit.glb --sky 1,1,1 --spacing 0.5 --samples 64 ";
    const nlohmann::json report = json(call + "--layers groups --json -o lit.exr");
    ASSERT_EQ(report["layers"].size(), 3U);
    EXPECT_EQ(report["layers"][0]["name"], "lamps");
    EXPECT_EQ(report["layers"][1]["name"], "signs");
    EXPECT_EQ(report["layers"][2]["name"], "other");
    EXPECT_GT(report["layers"][0]["bytes"], 0);
    EXPECT_GT(report["layers"][2]["noise"], 0);
    const Volume volume = load_volume(folder() / "lit.exr");
    ASSERT_EQ(volume.layers.size(), 3U);
    // Both lights stand at one place.
    EXPECT_EQ(volume.layers[0].coefficients, volume.layers[1].coefficients);
    EXPECT_NE(run(call + "--layers lamps -o lit.exr --verbose")
                  .err.find("layers of 1 groups of lights: nobody asked for them"),
              std::string::npos);
    expect_refused("lit.glb --layers lmaps",
                   "lit.glb: there is no group \"lmaps\" of lights. Choose among: lamps, signs.");
}

TEST_F(LevelBake, BakesTheLightOfSkiesToCome) {
    write_floor("floor.glb");
    const Result result = run("floor.glb --layers sky --spacing 0.5 --samples 64 -o floor.exr");
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.err.find("there is no light but that of skies to come"), std::string::npos) << result.err;
    const Volume volume = load_volume(folder() / "floor.exr");
    ASSERT_EQ(volume.layers.size(), 9U);
    EXPECT_NE(volume.layers[0].coefficients[0], glm::vec3(0));
}

TEST_F(LevelBake, RefusesLayersThatDoNotGoWithTheRest) {
    expect_refused(cornell + " --layers direct", "direct,indirect are two halves");
    expect_refused(cornell + " --layers sky --method path", "--layers needs --method cache");
    expect_refused(cornell + " --layers sky --time-budget 60s", "--layers excludes --time-budget");
    expect_refused(cornell + " --layers sky --keep-transport k", "--layers excludes --keep-transport");
    expect_refused(cornell + " --layers groups", "has no groups of lights");
    expect_refused(cornell + " --method photon", "photon is not known");
}

}  // namespace
}  // namespace lightgrid
