#include "tools/level_options.h"

#include "core/error.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace lightgrid {
namespace {

LevelOptions parsed(std::vector<std::string> arguments) {
    LevelOptions options;
    CLI::App app;
    add_level_options(app, options);
    std::reverse(arguments.begin(), arguments.end());
    app.parse(arguments);
    return options;
}

TEST(LevelOptions, AreTakenFromAVolumeWhereTheyAreNotGiven) {
    Volume volume;
    record(parsed({}), volume);
    EXPECT_TRUE(volume.settings.empty()) << "what was not given is not written";
    const std::vector<std::string> odd{"sky=\"dome\", west", "*", ""};
    record(parsed({"--ignore", odd[0], "--ignore", odd[1], "--ignore", odd[2], "--scene=2"}), volume);

    const LoadOptions same = load_options(with_recorded(parsed({}), volume));
    EXPECT_EQ(same.ignore, (std::vector<std::string>{odd[0], odd[1]})) << "an empty pattern fits nothing";
    EXPECT_EQ(same.scene, 2);
    const LoadOptions given = load_options(with_recorded(parsed({"--ignore", "tree"}), volume));
    EXPECT_EQ(given.ignore, std::vector<std::string>{"tree"});
    EXPECT_EQ(given.scene, 2);
    EXPECT_TRUE(load_options(with_recorded(parsed({"--ignore", ""}), volume)).ignore.empty());
}

TEST(LevelOptions, AlbedoAndTexturesAreTakenFromAVolumeToo) {
    Volume volume;
    record(parsed({"--default-albedo", "0.25", "--missing-textures", "error"}), volume);
    const LoadOptions same = load_options(with_recorded(parsed({}), volume));
    EXPECT_EQ(same.default_albedo, 0.25F);
    EXPECT_EQ(same.missing_textures, MissingTextures::error);
    const LoadOptions given = load_options(with_recorded(parsed({"--default-albedo", "1"}), volume));
    EXPECT_EQ(given.default_albedo, 1);
    EXPECT_EQ(load_options({}).default_albedo, 0.8F);
    EXPECT_EQ(load_options({}).missing_textures, MissingTextures::warn);
}

TEST(LevelOptions, TheScaleIsThatOfTheVolumesCoordinates) {
    Volume volume;
    EXPECT_EQ(metres_per_unit(volume), 1);
    record(parsed({"--scale", "0.01"}), volume);
    EXPECT_EQ(metres_per_unit(volume), 0.01);
    EXPECT_EQ(load_options(with_recorded(parsed({}), volume)).metres_per_unit, 0.01);
    EXPECT_EQ(load_options(with_recorded(parsed({"--scale", "1"}), volume)).metres_per_unit, 1);
    for (const char* wrong : {"0", "-1", "nan", "inf", "cm", "1e-9"})
        EXPECT_THROW(static_cast<void>(parsed({"--scale", wrong})), CLI::Error) << wrong;
    for (const char* wrong : {"0", "-1", "1e300", "cm", "[1]", "\"1\""}) {
        volume.settings["scale"] = wrong;
        EXPECT_THROW(static_cast<void>(metres_per_unit(volume)), Error) << wrong;
        EXPECT_THROW(static_cast<void>(with_recorded({}, volume)), Error) << wrong;
    }
}

TEST(LevelOptions, SettingsThatDifferAreNamed) {
    Volume a;
    Volume b;
    EXPECT_TRUE(settings_that_differ(a, b).empty());
    record(parsed({"--ignore", "dome"}), a);
    a.settings["environment"] = "none";
    b.settings["environment"] = "uniform sky 1,1,1 cd/m^2";
    a.settings["seed"] = "1";
    EXPECT_EQ(settings_that_differ(a, b), (std::vector<std::string>{"ignore", "environment"}));
    EXPECT_TRUE(settings_that_differ(a, a).empty());
}

TEST(LevelOptions, SettingsThatDoNotReadAreRefusedByName) {
    const std::vector<std::pair<std::string, std::string>> settings{
        {"ignore", "dome"},        {"ignore", "{}"},
        {"ignore", "[1]"},         {"ignore", "[\"dome\""},
        {"scene", "-2"},           {"scene", "\"hall\""},
        {"default_albedo", "7"},   {"default_albedo", "null"},
        {"missing_textures", "1"}, {"missing_textures", "\"refuse\""}};
    for (const auto& [name, wrong] : settings) {
        Volume volume;
        volume.settings[name] = wrong;
        try {
            static_cast<void>(with_recorded({}, volume));
            ADD_FAILURE() << name << " " << wrong;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find(fmt::format("setting \"{}\"", name)), std::string::npos)
                << error.what();
        }
    }
}

}  // namespace
}  // namespace lightgrid
