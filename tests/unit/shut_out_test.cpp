#include "probes/shut_out.h"

#include "core/gltf.h"
#include "tests/gltf_builder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lightgrid {
namespace {

using nlohmann::json;

/// A yard of 20 x 20 m, lights, and boxes of a test's own, each a node of its own.
class Yard {
  public:
    Yard() {
        builder_.use("KHR_lights_punctual");
        builder_.json["scenes"][0]["nodes"] = json::array();
        add("ground", {{-10, 0, 10}, {10, 0, 10}, {10, 0, -10}, {-10, 0, -10}}, {0, 1, 2, 0, 2, 3});
    }
    void add(const std::string& name, const std::vector<glm::vec3>& corners,
             const std::vector<std::uint32_t>& indices) {
        const int mesh = builder_.mesh(
            {{"attributes", {{"POSITION", builder_.vec3s(corners)}}}, {"indices", builder_.indices(indices)}});
        stand({{"name", name}, {"mesh", mesh}});
    }
    /// A box, closed or without its upper side.
    void add_box(const std::string& name, glm::vec3 min, glm::vec3 max, bool open = false) {
        std::vector<glm::vec3> corners;
        for (int i = 0; i < 8; ++i)
            corners.emplace_back(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z);
        std::vector<std::uint32_t> indices{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4,
                                           1, 5, 4, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
        if (!open) indices.insert(indices.end(), {2, 6, 3, 3, 6, 7});
        add(name, corners, indices);
    }
    void add_light(const std::string& name, json light, glm::dvec3 at) {
        json& lights = builder_.json["extensions"]["KHR_lights_punctual"]["lights"];
        lights.push_back(std::move(light));
        const double s = std::sqrt(0.5);  // a quarter turn: shines down
        stand({{"name", name},
               {"translation", {at.x, at.y, at.z}},
               {"rotation", {-s, 0, 0, s}},
               {"extensions", {{"KHR_lights_punctual", {{"light", lights.size() - 1}}}}}});
    }
    void add_sun() { add_light("Sun", {{"type", "directional"}, {"intensity", 1e5}}, {0, 5, 0}); }
    void add_lamp(glm::dvec3 at) { add_light("Bulb", {{"type", "point"}, {"intensity", 100}}, at); }

    /// "the sun: dome; ", for probes in the yard and `more`; "the sun: dome, all; " where is_all_shut_out.
    [[nodiscard]] std::string shut_out(const Environment& environment = {},
                                       const std::vector<glm::dvec3>& more = {}) const {
        const TemporaryFolder folder;
        write_bytes(folder.path() / "level.gltf", builder_.finished().dump());
        const Scene scene = load_level(folder.path() / "level.gltf");
        const Tracer tracer(scene);
        const PathTracer paths(tracer, environment);
        std::vector<glm::vec3> points;
        for (int x = -4; x <= 4; ++x)
            for (int z = -4; z <= 4; ++z)
                for (int y = 0; y < 3; ++y)
                    points.emplace_back(glm::dvec3(2 * x + 0.3, 2 * y + 1.1, 2 * z + 0.2) - scene.origin);
        for (const glm::dvec3& point : more) points.emplace_back(point - scene.origin);
        std::string text;
        const std::vector<ShutOut> found = find_shut_out(paths, points);
        for (const ShutOut& out : found) {
            const std::string mesh = out.node < 0 ? "no mesh" : scene.node_names[static_cast<std::size_t>(out.node)];
            text += out.light + ": " + mesh + (out.from_all_points ? "; " : ", but not from all; ");
        }
        return text + (is_all_shut_out(paths, found) ? "all" : "");
    }

  private:
    void stand(json node) { builder_.json["scenes"][0]["nodes"].push_back(builder_.node(std::move(node))); }

    GltfBuilder builder_;
};

TEST(ShutOut, ADomeRoundTheLevelIsNamedForSunAndSky) {
    const Environment sky = Environment::uniform(glm::vec3(1));
    Yard open;
    open.add_sun();
    EXPECT_EQ(open.shut_out(sky), "");
    Yard full = open;
    full.add_box("dome", {-300, -300, -300}, {300, 300, 300});
    full.add_box("crate", {-2, 3, -2}, {2, 5, 2});
    EXPECT_EQ(full.shut_out(sky), "the sky: dome; the sun \"Sun\": dome; all");
    EXPECT_EQ(full.shut_out(), "the sun \"Sun\": dome; all");
    // A dome that ends at the horizon: below it the ground is in the way.
    Yard half = open;
    half.add_box("dome", {-20, -0.1, -20}, {20, 300, 20});
    EXPECT_EQ(half.shut_out(sky), "the sky: dome; the sun \"Sun\": dome; all");
}

TEST(ShutOut, ADomeIsNamedThoughProbesInTheCornersRoundItAreLit) {
    Yard yard;
    yard.add_sun();
    yard.add_box("dome", {-12, -12, -12}, {12, 12, 12});
    const std::vector<glm::dvec3> corners{{13, 1, 13}, {-13, 1, 13}, {13, 1, -13}, {-13, 1, -13}};
    EXPECT_EQ(yard.shut_out({}, corners), "the sun \"Sun\": dome, but not from all; all");
    yard.add_lamp({1, 3, 1});
    EXPECT_EQ(yard.shut_out({}, corners), "the sun \"Sun\": dome, but not from all; ") << "the lamp lights the yard";
}

TEST(ShutOut, AHouseInALargerLevelIsAllowedToBeDark) {
    Yard street;
    street.add_sun();
    street.add_box("house", {-9, 0.01, -9}, {9, 8, 9});
    EXPECT_EQ(street.shut_out(), "") << "the yard reaches beyond it";
}

TEST(ShutOut, AMeshWithoutANameIsNamedByItsNode) {
    Yard yard;
    yard.add_lamp({1, 3, 1});
    yard.add_box("", {0.8, 2.8, 0.8}, {1.2, 3.2, 1.2});
    EXPECT_EQ(yard.shut_out(), "the lamp \"Bulb\": ; all");
}

TEST(ShutOut, LightThatComesInByAHoleOrASurfaceIsNotShutOut) {
    Yard pit;
    pit.add_sun();
    pit.add_box("pit", {-300, -300, -300}, {300, 300, 300}, true);
    EXPECT_EQ(pit.shut_out(Environment::uniform(glm::vec3(1))), "") << "from above";
    // A roof over all probes with a sunlit floor beside it: the sun comes by way of the floor.
    Yard roofed;
    roofed.add_sun();
    roofed.add_box("roof", {-9.5, 7, -9.5}, {9.5, 8, 9.5});
    EXPECT_EQ(roofed.shut_out(), "");
}

TEST(ShutOut, WallsAndRoofThatOnlyTogetherKeepTheSunOutAreNotNamed) {
    Yard house;
    house.add_light("Sun", {{"type", "directional"}, {"intensity", 1e5}}, {0, 5, 0});
    house.add_box("shell", {-10, -1, -10}, {10, 9, 10}, true);
    house.add_box("roof", {-11, 9, -11}, {11, 10, 11});
    EXPECT_EQ(house.shut_out(), "");
}

TEST(ShutOut, ALampWithinAClosedMeshIsNamedWithIt) {
    Yard yard;
    yard.add_lamp({1, 3, 1});
    EXPECT_EQ(yard.shut_out(), "");
    Yard closed = yard;
    closed.add_box("shade", {0.8, 2.8, 0.8}, {1.2, 3.2, 1.2});
    EXPECT_EQ(closed.shut_out(), "the lamp \"Bulb\": shade; all");
    Yard open = yard;
    open.add_box("shade", {0.8, 2.8, 0.8}, {1.2, 3.2, 1.2}, true);
    EXPECT_EQ(open.shut_out(), "") << "its upper side is open";
}

TEST(ShutOut, ALampThatShinesByASurfaceOnlyIsNotShutIn) {
    // No probe sees the lamp, which shines onto the ground between two plates.
    Yard yard;
    yard.add_light("Spot", {{"type", "spot"}, {"intensity", 100}, {"spot", {{"outerConeAngle", 0.3}}}}, {0, 0.5, 0});
    EXPECT_EQ(yard.shut_out(), "");
}

}  // namespace
}  // namespace lightgrid
