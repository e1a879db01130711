// Runs the built `lightgrid` as a user or a script does.

#include "core/image.h"
#include "core/sh.h"
#include "probes/half_storage.h"
#include "probes/volume_file.h"
#include "tests/regression/program_test.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fcntl.h>
#include <unistd.h>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

// A folder with a volume and a probe list, and the program run in it.
class Cli : public ProgramTest {
  protected:
    Cli() : ProgramTest(LIGHTGRID_PROGRAM) {}
    void SetUp() override {
        save_volume(linear_volume(), folder() / "hall.probes.exr");
        save_volume(list(), folder() / "list.probes.exr");
        save_volume(layered_volume(), folder() / "layers.probes.exr");
        write("points.csv", "x,y,z\n0.5,1,1.5\n-9,1,1\n");
    }

    // Uniform radiance at each probe, growing with x: irradiance is pi (1 + x) in red, half of that in green.
    static Volume linear_volume() {
        Volume volume = make_volume({{{0, 0, 0}, {1, 1, 1}, {5, 3, 3}}}, 3);
        for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
            if (volume.states[slot] == ProbeState::absent) continue;
            const double radiance = 1 + lattice_position(volume, slot).x;
            volume.coefficients[slot * 9] = glm::vec3(2 * std::sqrt(M_PI) * radiance * glm::dvec3(1, 0.5, 0));
            volume.errors[slot * 9] = glm::vec3(0.01);
            for (std::size_t axis = 0; axis < 6; ++axis) volume.axis_errors[slot * 6 + axis] = glm::vec3(0.02);
        }
        volume.states[1] = ProbeState::missing;  // at (1, 0, 0)
        volume.settings = {{"level", "hall.glb"}, {"replicates", "16"}, {"seed", "7"}};
        return volume;
    }

    /// The same light in layers: red and green as they are, and a sky.
    static Volume layered_volume() {
        Volume volume = linear_volume();
        volume.layers = {{"red", volume.coefficients, 0.125}, {"green", volume.coefficients, 0}};
        for (glm::vec3& c : volume.layers[0].coefficients) c *= glm::vec3(1, 0, 0);
        for (glm::vec3& c : volume.layers[1].coefficients) c *= glm::vec3(0, 1, 0);
        for (int i = 0; i < 9; ++i) {
            Layer layer{sky_layer(i), std::vector<glm::vec3>(volume.coefficients.size()), 0};
            for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
                layer.coefficients[slot * 9 + i] = glm::vec3(0.5F);
            }
            volume.layers.push_back(layer);
        }
        return volume;
    }

    static Volume list() {
        Volume volume = make_probe_list({{1, 0.5, 0.5}, {0.1, 0.2, 0.3}, {1, 0.5, 0.5}}, 3);
        for (std::size_t i = 0; i < 3; ++i) volume.coefficients[9 * i] = glm::vec3(2 * std::sqrt(M_PI));
        volume.states[1] = ProbeState::missing;
        return volume;
    }
};

// ---- query

TEST_F(Cli, QueryPrintsIrradianceForTheGivenNormals) {
    write("normals.csv", "nx,ny,nz,x,y,z\n0,0,2,0.5,1,1.5\n");
    const Result result = run("query hall.probes.exr --points normals.csv");
    EXPECT_EQ(first_line(result.out), "x,y,z,nx,ny,nz,r,g,b,valid");
    const CsvTable table(result.out, "out");
    ASSERT_EQ(table.rows(), 1U);
    EXPECT_EQ(table.number(0, table.column("x")), 0.5);
    EXPECT_EQ(table.number(0, table.column("nz")), 2) << "normals come back as they were given";
    EXPECT_NEAR(table.number(0, table.column("r")), M_PI * 1.5, 1e-5);
    EXPECT_NEAR(table.number(0, table.column("g")), M_PI * 0.75, 1e-5);
    EXPECT_EQ(table.number(0, table.column("b")), 0);
    EXPECT_EQ(table.number(0, table.column("valid")), 1);
}

TEST_F(Cli, QueryTakesTheSixAxesWhereNoNormalsAreGiven) {
    const CsvTable table = csv("query hall.probes.exr --points points.csv");
    ASSERT_EQ(table.rows(), 12U);
    for (std::size_t row = 0; row < 12; ++row) {
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(table.number(row, 3 + axis), axis_normals[row % 6][axis]);
        }
    }
    EXPECT_NEAR(table.number(6, table.column("r")), M_PI, 1e-5) << "clamped to x = 0";
}

TEST_F(Cli, QueryPrintsCoefficients) {
    const Result result = run("query --sh --points points.csv hall.probes.exr");
    EXPECT_EQ(first_line(result.out).rfind("x,y,z,valid,c0r,c0g,c0b,c1r,", 0), 0U) << result.out;
    const CsvTable table(result.out, "out");
    EXPECT_NEAR(table.number(0, table.column("c0r")), 2 * std::sqrt(M_PI) * 1.5, 1e-5);
    EXPECT_EQ(table.number(0, table.column("c8b")), 0);
    EXPECT_EQ(table.rows(), 2U);
}

TEST_F(Cli, QueryReadsStandardInputAndPrintsNumbersThatReadBack) {
    const Result result = shell("printf 'x,y,z\\n0.1,1e-3,0.30000000000000004\\n' | " LIGHTGRID_PROGRAM
                                " query --points=- --sh hall.probes.exr");
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.out.find("\n0.1,0.001,0.30000000000000004,1,"), std::string::npos) << result.out;
}

TEST_F(Cli, QueryFadesToTheSkyOutside) {
    const CsvTable dark = csv("query hall.probes.exr --points points.csv --outside fade");
    EXPECT_EQ(dark.number(6, dark.column("r")), 0);
    const CsvTable sky = csv("query hall.probes.exr --points points.csv --outside=fade --fade-distance 18 --sky 3,0,0");
    EXPECT_NEAR(sky.number(6, sky.column("r")), M_PI * 2, 1e-5) << "half way from 1 to 3";
    EXPECT_NEAR(sky.number(0, sky.column("r")), M_PI * 1.5, 1e-5);
}

TEST_F(Cli, QueryMovesPointsByTheNormalBias) {
    write("normals.csv", "x,y,z,nx,ny,nz\n2,1,1,1,0,0\n");
    const CsvTable table = csv("query hall.probes.exr --points normals.csv --normal-bias 0.5");
    EXPECT_EQ(table.number(0, table.column("x")), 2);
    EXPECT_NEAR(table.number(0, table.column("r")), M_PI * 3.5, 1e-5);
    EXPECT_NEAR(csv("query hall.probes.exr --points normals.csv --normal-bias=-0.5").number(0, 6), M_PI * 2.5, 1e-5);
    EXPECT_NEAR(csv("query hall.probes.exr --points normals.csv --normal-bias -0.5").number(0, 6), M_PI * 2.5, 1e-5);
}

TEST_F(Cli, LengthsInMetresHeedTheVolumesScale) {
    Volume volume = linear_volume();
    volume.settings["scale"] = "0.5";
    save_volume(volume, folder() / "small.probes.exr");
    write("normals.csv", "x,y,z,nx,ny,nz\n2,1,1,1,0,0\n-1,1,1,1,0,0\n");
    const CsvTable moved = csv("query small.probes.exr --points normals.csv --normal-bias 0.5");
    EXPECT_EQ(moved.number(0, moved.column("x")), 2) << "coordinates are the file's";
    EXPECT_NEAR(moved.number(0, moved.column("r")), M_PI * 4, 1e-5) << "0.5 m are a unit";
    const CsvTable sky =
        csv("query small.probes.exr --points normals.csv --outside fade --fade-distance 1 --sky 3,0,0");
    EXPECT_NEAR(sky.number(1, sky.column("r")), M_PI * 2, 1e-5) << "half way from 1 to 3";
    EXPECT_NE(run("info small.probes.exr").out.find("spacing 0.5 x 0.5 x 0.5 m, from (0, 0, 0) to (4, 2, 2)"),
              std::string::npos);
    EXPECT_EQ(json("info small.probes.exr --json")["metres_per_unit"], 0.5);
    EXPECT_EQ(json("info hall.probes.exr --json")["metres_per_unit"], 1);
}

TEST_F(Cli, QueryDerings) {
    Volume volume = make_volume({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}, 3);
    const std::vector<glm::vec3> lamp = delta_light_sh(3, {0, 1, 0}, glm::vec3(1));
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        std::copy(lamp.begin(), lamp.end(), volume.coefficients.begin() + static_cast<std::ptrdiff_t>(slot * 9));
    }
    save_volume(volume, folder() / "lamp.probes.exr");
    write("normals.csv", "x,y,z,nx,ny,nz\n0.5,0.5,0.5,0.846,-0.533,0\n");  // 122.2 degrees from the light
    EXPECT_NEAR(csv("query lamp.probes.exr --points normals.csv").number(0, 6), -0.0396, 1e-4);
    EXPECT_GE(csv("query lamp.probes.exr --points normals.csv --dering").number(0, 6), 0);
    EXPECT_NEAR(csv("query lamp.probes.exr --points normals.csv --sh --dering").number(0, 4), lamp[0].x, 1e-6);
}

TEST_F(Cli, QueryAnswersAtAMissingProbeAsBesideIt) {
    write("normals.csv", "x,y,z,nx,ny,nz\n1,0,0,1,0,0\n1,0,0.5,1,0,0\n");
    const CsvTable table = csv("query hall.probes.exr --points normals.csv");
    EXPECT_EQ(table.number(0, table.column("valid")), 1);
    EXPECT_GT(table.number(0, table.column("r")), M_PI * 1) << "the probe's neighbours are from 1 to 3";
    EXPECT_LT(table.number(0, table.column("r")), M_PI * 3);
    EXPECT_EQ(table.number(1, table.column("valid")), 1);
    EXPECT_NEAR(table.number(1, table.column("r")), M_PI * 2, 1e-5) << "from the valid corners alone";
}

TEST_F(Cli, QuerySaysWhereNoLightIsKnown) {
    Volume dark = linear_volume();
    std::replace(dark.states.begin(), dark.states.end(), ProbeState::valid, ProbeState::missing);
    save_volume(dark, folder() / "dark.probes.exr");
    write("normals.csv", "x,y,z,nx,ny,nz\n1,0,0,1,0,0\n-9,1,1,1,0,0\n");
    const CsvTable table = csv("query dark.probes.exr --points normals.csv");
    for (const std::size_t row : {0U, 1U}) {
        EXPECT_EQ(table.number(row, table.column("valid")), 0);
        EXPECT_EQ(table.number(row, table.column("r")), 0);
    }
}

TEST_F(Cli, QueryRefusesWhatItCannotAnswer) {
    expect_refused("query list.probes.exr --points points.csv", "is a probe list: it has no cells");
    expect_refused("query hall.probes.exr", "--points is required");
    expect_refused("query hall.probes.exr --points nowhere.csv",
                   "nowhere.csv: cannot be read: No such file or directory");
    write("bad.csv", "x,y,z\n1,2,3\n1,nan,3\n");
    expect_refused("query hall.probes.exr --points bad.csv", "bad.csv: line 3: column y: \"nan\" is not finite");
    expect_refused("query hall.probes.exr --points hall.probes.exr", "is not a text file");
    expect_refused("query points.csv --points points.csv", "points.csv: is not an OpenEXR file");
    expect_refused("query hall.probes.exr --points points.csv --outside wrap", "wrap");
    expect_refused("query hall.probes.exr --points points.csv --sky 1,2", "--sky");
    expect_refused("query hall.probes.exr --points points.csv --normal-bias inf", "inf is not a finite number");
    expect_refused("query hall.probes.exr --points points.csv --sh --normal-bias 1", "--sh");
}

TEST_F(Cli, QueryMixesLayers) {
    write("point.csv", "x,y,z,nx,ny,nz\n0.5,1,1.5,0,1,0\n");
    const auto mixed = [&](const std::string& layers) {
        const CsvTable table = csv("query layers.probes.exr --points point.csv" + layers);
        return glm::dvec3(table.number(0, 6), table.number(0, 7), table.number(0, 8));
    };
    const auto expect = [](glm::dvec3 found, glm::dvec3 wanted) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], wanted[c], 1e-4) << c;
    };
    expect(mixed(""), M_PI * glm::dvec3(1.5, 0.75, 0));
    expect(mixed(" --layers red=1,green=1"), M_PI * glm::dvec3(1.5, 0.75, 0));
    expect(mixed(" --layers red=2"), M_PI * glm::dvec3(3, 0, 0));
    expect(mixed(" --layers green=5,4,3,red=0.5"), M_PI * glm::dvec3(0.75, 3, 0));
    // Half of a sky comes through.
    expect(mixed(" --layers sky=1,2,3"), M_PI * glm::dvec3(0.5, 1, 1.5));
    expect(mixed(" --layers sky=4,red=1"), M_PI * glm::dvec3(3.5, 2, 2));
    RadianceImage image{8, 4, std::vector<glm::vec3>(32, glm::vec3(2, 4, 6))};
    write_exr(image, folder() / "sky.exr");
    expect(mixed(" --layers sky=sky.exr"), M_PI * glm::dvec3(1, 2, 3));
}

TEST_F(Cli, QueryRefusesLayersThatThereAreNot) {
    const std::string query = "query layers.probes.exr --points points.csv --layers ";
    expect_refused(query + "blue=1", "there is no layer \"blue\". Choose among: sky, red, green, sky.0");
    expect_refused(query + "red", "\"red\" is no list of layers and weights, like lamps=2,signs=1,0.5,0");
    expect_refused(query + "red=1,2", "\"1,2\" is not 3 numbers");
    expect_refused(query + "red=much", "--layers");
    expect_refused(query + "red=1,red=2", "layer red is given twice");
    expect_refused(query + "sky=none.hdr", "sky=none.hdr is neither a file that there is nor radiance");
    expect_refused("query hall.probes.exr --points points.csv --layers red=1", "the volume has no layers");
}

// ---- probes, info

TEST_F(Cli, ProbesPrintsTheGridWithXFastest) {
    const Result result = run("probes hall.probes.exr");
    EXPECT_EQ(first_line(result.out).rfind("x,y,z,valid,c0r,c0g,c0b,c1r,", 0), 0U);
    EXPECT_NE(first_line(result.out).find(",c8b,e0r,e0g,e0b,"), std::string::npos);
    const CsvTable table(result.out, "out");
    ASSERT_EQ(table.rows(), 45U);
    for (std::size_t row = 0; row < 45; ++row) {
        EXPECT_EQ(table.number(row, 0), row % 5);
        EXPECT_EQ(table.number(row, 1), row / 5 % 3);
        EXPECT_EQ(table.number(row, 2), row / 15);
        EXPECT_EQ(table.number(row, 3), row == 1 ? 0 : 1);
    }
    EXPECT_NE(result.out.find(",0.01,"), std::string::npos) << "the shortest text of a float";
}

TEST_F(Cli, ProbesKeepsTheRowsOfAList) {
    const CsvTable table = csv("probes list.probes.exr");
    ASSERT_EQ(table.rows(), 3U);
    EXPECT_EQ(table.number(1, 0), 0.1);
    EXPECT_EQ(table.number(1, 3), 0);
    EXPECT_NEAR(table.number(1, 4), 2 * std::sqrt(M_PI), 1e-6) << "not valid, but gathered";
    EXPECT_EQ(table.number(2, 0), table.number(0, 0));
}

TEST_F(Cli, InfoTellsEverythingAsTextAndAsJson) {
    const Result text = run("info hall.probes.exr");
    EXPECT_EQ(text.status, 0);
    for (const char* part : {"5 x 3 x 3 probes", "45: 44 valid", "1 missing", "float", "hall.glb", "standard error"}) {
        EXPECT_NE(text.out.find(part), std::string::npos) << part << "\n" << text.out;
    }
    const nlohmann::json info = json("info --json hall.probes.exr");
    EXPECT_EQ(info["grids"][0]["counts"], nlohmann::json({5, 3, 3}));
    EXPECT_EQ(info["probes"]["total"], 45);
    EXPECT_EQ(info["probes"]["missing"], 1);
    EXPECT_EQ(info["replicates"], 16);
    EXPECT_EQ(info["settings"]["seed"], "7");
    EXPECT_EQ(info["bytes"], fs::file_size(folder() / "hall.probes.exr"));
    EXPECT_NEAR(info["irradiance"]["standard_error"].get<double>(), 0.02, 1e-6);
    EXPECT_EQ(json("info list.probes.exr --json")["kind"], "list");
    EXPECT_EQ(info["layers"], nlohmann::json::array());
    const nlohmann::json layers = json("info layers.probes.exr --json")["layers"];
    ASSERT_EQ(layers.size(), 11U);
    EXPECT_EQ(layers[0], nlohmann::json({{"name", "red"}, {"bytes", 128 * 3 * 4}, {"relative_error", 0.125}}));
    EXPECT_NE(run("info layers.probes.exr").out.find("layer green     1536 bytes before compression"),
              std::string::npos);
}

// ---- diff

TEST_F(Cli, DiffOfAVolumeWithItselfIsZero) {
    const nlohmann::json same = json("diff hall.probes.exr hall.probes.exr --json");
    EXPECT_EQ(same["relrmse"], 0);
    EXPECT_EQ(same["points"], 44);
    EXPECT_EQ(same["unknown_in_reference"], 1);
    EXPECT_EQ(json("diff list.probes.exr list.probes.exr --json")["relrmse"], 0);
}

TEST_F(Cli, DiffMeasuresTheShareThatLightIsOff) {
    Volume brighter = linear_volume();
    for (glm::vec3& c : brighter.coefficients) c *= 1.03F;
    save_volume(brighter, folder() / "bright.probes.exr");
    const nlohmann::json off = json("diff hall.probes.exr bright.probes.exr --json");
    EXPECT_NEAR(off["relrmse"].get<double>(), 0.03, 1e-5);
    EXPECT_NEAR(off["mean_error"].get<double>(), 0.03, 1e-5);
    EXPECT_NE(run("diff hall.probes.exr bright.probes.exr").out.find("relRMSE         3 %"), std::string::npos);
}

TEST_F(Cli, DiffTakesWhatTheOtherVerbsPrint) {
    for (const char* verb : {"query hall.probes.exr --points points.csv",
                             "query hall.probes.exr --points points.csv --sh", "probes hall.probes.exr"}) {
        const Result printed = run(verb);
        write("a.csv", printed.out);
        EXPECT_LT(json("diff a.csv hall.probes.exr --json")["relrmse"].get<double>(), 1e-6) << verb;
    }
}

TEST_F(Cli, DiffTakesTheStatedNoiseOfAReferenceOut) {
    // Twice the same truth, once too bright and once too dark by exactly the stated error: nothing is left.
    const double truth = M_PI * 1.5;
    write("a.csv", fmt::format("x,y,z,nx,ny,nz,r,g,b,er,eg,eb\n0.5,1,1.5,0,1,0,{},{},0,0.1,0.1,0\n"
                               "0.5,1,1.5,1,0,0,{},{},0,0.1,0.1,0\n",
                               truth + 0.1, truth / 2 + 0.1, truth - 0.1, truth / 2 - 0.1));
    const nlohmann::json found = json("diff a.csv hall.probes.exr --json");
    EXPECT_LT(found["relrmse"].get<double>(), 1e-3);
    EXPECT_GT(found["reference_noise"].get<double>(), 0.02);
}

TEST_F(Cli, DiffRefusesWhatItCannotCompare) {
    expect_refused("diff hall.probes.exr list.probes.exr", "is a probe list and has no probe at 0, 0, 0");
    expect_refused("diff hall.probes.exr points.csv", "points.csv: is not an OpenEXR file");
    expect_refused("diff points.csv hall.probes.exr", "has neither columns r, g, b nor c0r");
    write("odd.csv", "x,y,z,c0r,c0g,c0b,c1r,c1g,c1b\n0,0,0,1,1,1,1,1,1\n");
    expect_refused("diff odd.csv hall.probes.exr", "2 coefficients are not the square");
    write("nothing.csv", "x,y,z,c0r,c0g,c0b\n");
    expect_refused("diff nothing.csv hall.probes.exr", "nothing.csv: has no rows");
    expect_refused("diff hall.probes.exr", "B is required");
}

// ---- The program

TEST_F(Cli, AnswersForHelpAndVersionOnStandardOutput) {
    for (const char* call : {"--help", "info --help", "query -h", "--version"}) {
        const Result result = run(call);
        EXPECT_EQ(result.status, 0) << call;
        EXPECT_NE(result.out, "") << call;
        EXPECT_EQ(result.err, "") << call;
    }
    EXPECT_EQ(run("--version").out.rfind("lightgrid ", 0), 0U);
    EXPECT_NE(run("query --help").out.find("--points"), std::string::npos);
}

TEST_F(Cli, ReportsEveryWrongOptionAndWhatItMayHaveMeant) {
    const Result result = run("query hall.probes.exr --pionts points.csv --outside wrap --normal-bias much --quick");
    EXPECT_EQ(result.status, 2);
    for (const char* part : {"unknown option --pionts (did you mean --points?)", "unknown option --quick", "wrap",
                             "much", "--points is required", "See lightgrid query --help."}) {
        EXPECT_NE(result.err.find(part), std::string::npos) << part << "\n" << result.err;
    }
    EXPECT_EQ(result.err.find("--quick (did"), std::string::npos) << result.err;
    expect_refused("", "no verb: one of info, probes, query, ");
    expect_refused("inof hall.probes.exr", "unknown verb inof (did you mean info?)");
    expect_refused("info hall.probes.exr list.probes.exr", "argument \"list.probes.exr\" is one too many");
    expect_refused("info", "VOLUME is required");
    expect_refused("info hall.probes.exr --jsn=1", "unknown option --jsn (did you mean --json?)");
}

TEST_F(Cli, TakesAClosedPipeForAnAnswer) {
    std::string many = "x,y,z\n";
    for (int i = 0; i < 100000; ++i) many += "1,1,1\n";
    write("many.csv", many);
    const Result result =
        shell("(" LIGHTGRID_PROGRAM " query hall.probes.exr --points many.csv; echo $? >status.txt) | head -n 1");
    EXPECT_EQ(first_line(result.out), "x,y,z,nx,ny,nz,r,g,b,valid");
    EXPECT_EQ(result.err, "");
    EXPECT_EQ(read_whole_file(folder() / "status.txt"), "0\n");
}

TEST_F(Cli, FailsWhereResultsCannotBeWritten) {
    const Result result = shell(LIGHTGRID_PROGRAM " probes hall.probes.exr >/dev/full");
    EXPECT_EQ(result.status, 1);
    EXPECT_NE(result.err.find("standard output: cannot be written: No space left on device"), std::string::npos);
}

TEST_F(Cli, NamesBrokenVolumes) {
    write("empty.exr", "");
    expect_refused("info empty.exr", "empty.exr: is empty");
    const std::string whole = read_whole_file(folder() / "hall.probes.exr");
    write("half.exr", whole.substr(0, whole.size() / 2));
    expect_refused("info half.exr", "half.exr: is damaged");
    expect_refused("probes .", ".: cannot be read: Is a directory");
    const fs::path stock = fs::path(LIGHTGRID_SHARED) / "data/exr-magnum-tiny/rgba32f.exr";
    if (fs::exists(stock)) expect_refused("info " + stock.string(), "is an OpenEXR image but not a probe volume");
}

TEST_F(Cli, ColoursMessagesOnATerminalOnly) {
    const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY);
    ASSERT_EQ(::grantpt(terminal), 0);
    ASSERT_EQ(::unlockpt(terminal), 0);
    const std::string name = ::ptsname(terminal);
    const int other_end = ::open(name.c_str(), O_RDWR | O_NOCTTY);  // kept, or what was written is gone at its close
    const auto said_with = [&](const std::string& environment) {
        static_cast<void>(shell(environment + " " LIGHTGRID_PROGRAM " info nowhere.exr 2>" + name));
        std::array<char, 4096> text{};
        const ssize_t size = ::read(terminal, text.data(), text.size());
        return std::string(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
    };
    const char* const escape = "\x1b[";
    EXPECT_NE(said_with("NO_COLOR= TERM=xterm").find(escape), std::string::npos);
    EXPECT_EQ(said_with("NO_COLOR=1 TERM=xterm").find(escape), std::string::npos);
    EXPECT_EQ(said_with("NO_COLOR= TERM=dumb").find(escape), std::string::npos);
    EXPECT_EQ(shell("TERM=xterm NO_COLOR= " LIGHTGRID_PROGRAM " info nowhere.exr").err.find(escape), std::string::npos);
    ::close(other_end);
    ::close(terminal);
}

TEST_F(Cli, ReadsTheSameLightFromHalfStorage) {
    Volume volume = linear_volume();
    for (glm::vec3& error : volume.errors) error *= 100.0F;
    ASSERT_TRUE(choose_storage(volume).half);
    store_as_half(volume);
    save_volume(volume, folder() / "half.probes.exr");
    EXPECT_LT(json("diff hall.probes.exr half.probes.exr --json")["relrmse"].get<double>(), std::ldexp(1, -11));
    EXPECT_EQ(json("info half.probes.exr --json")["storage"]["type"], "half");
}

}  // namespace
}  // namespace lightgrid
