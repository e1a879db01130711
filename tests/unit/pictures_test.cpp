#include "tools/pictures.h"

#include "core/error.h"
#include "core/sh.h"
#include "tests/scene_builder.h"
#include "tools/error_chart.h"
#include "tools/lettering.h"
#include "tools/viewpoint.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lightgrid {
namespace {

/// A floor of albedo 0.5 at y = 0, 4 m x 4 m, and a volume of 2 m above it in which radiance 1 arrives from everywhere.
struct Floor {
    Scene scene;
    Volume volume;

    Floor() {
        Mesh mesh;
        mesh.positions.reserve(5);
        mesh.positions = {{-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}};
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        scene.meshes.push_back(std::move(mesh));  // with the room behind its last vertex
        scene.placed = {0};
        scene.materials.emplace_back();
        scene.materials[0].base_color = glm::vec3(0.5F);
        scene.bounds.extend({-2, 0, -2});
        scene.bounds.extend({2, 0, 2});
        volume = make_volume({{{-2, 0, -2}, {1, 1, 1}, {5, 3, 5}}}, 3);
        for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
            volume.coefficients[9 * slot] = glm::vec3(2 * std::sqrt(std::numbers::pi_v<float>));
        }
    }
};

TEST(Camera, RaysGoThroughWhatTheyShow) {
    const Camera camera = Camera::looking_at({1, 2, 3}, {-4, 1, -2}, 60);
    const glm::dvec3 point(-3, 1.5, -2.5);
    const glm::dvec3 seen = camera.project(point);
    const Camera::Ray ray = camera.ray({seen.x, seen.y});
    EXPECT_LT(glm::length(glm::cross(point - ray.origin, ray.direction)), 1e-12);
    EXPECT_NEAR(seen.z, glm::dot(point - camera.eye, camera.forward), 1e-12);
}

TEST(Camera, AroundShowsAllOfTheBoxAndLittleElse) {
    Box box;
    box.extend({-3, 0, 2});
    box.extend({7, 2.5, 9});
    const Camera camera = Camera::around(box, {0.1, -1, -0.5}, 40, 1.6);
    double farthest = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 seen =
            camera.project(box.min + glm::dvec3(corner & 1, corner / 2 & 1, corner / 4) * box.size());
        farthest = std::max({farthest, std::abs(seen.x), 1.6 * std::abs(seen.y)});
    }
    EXPECT_LT(farthest, 1);
    EXPECT_GT(farthest, 0.9);
}

TEST(Camera, CutTakesAwayWhatIsOnItsSide) {
    Camera camera = Camera::looking_at({0, 10, 0}, {0, 0, 0}, 40);
    camera.cut = Cut{{0, 1, 0}, 2};
    EXPECT_NEAR(camera.ray({0.3, -0.2}).origin.y, 2, 1e-12);
}

TEST(Viewpoint, LooksAlongACorridor) {
    Scene scene;
    Mesh mesh;
    mesh.positions.reserve(9);
    for (const float z : {-1.0F, 1.0F}) {
        for (const glm::vec2 corner : {glm::vec2(-8, 0), glm::vec2(8, 0), glm::vec2(8, 3), glm::vec2(-8, 3)}) {
            mesh.positions.emplace_back(corner.x, corner.y, z);
        }
    }
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
    scene.meshes.push_back(std::move(mesh));
    scene.placed = {0};
    scene.materials.emplace_back();
    scene.bounds.extend({-8, 0, -1});
    scene.bounds.extend({8, 3, 1});
    Volume volume = make_volume({{{-7.5, 0.5, -0.5}, {1, 0.5, 0.5}, {16, 5, 3}}}, 3);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) volume.coefficients[9 * slot] = glm::vec3(1);
    const Camera camera = find_viewpoint(Tracer(scene), volume, 60);
    EXPECT_GT(std::abs(camera.forward.x), 0.8);
    EXPECT_LT(camera.forward.x * camera.eye.x, -3 * 0.8) << "it stands aside of the middle, and looks the longer way";
}

TEST(Viewpoint, StandsInTheRoomNotBelowItOrInTheOpen) {
    // A room of 4 x 3 x 4 m with a way out, on a plate of 16 m, over a void that the volume reaches into.
    Scene scene;
    const int stone = add_grey(scene, 0.5F);
    add_box(scene, stone, {-8, -0.5F, -8}, {8, 0, 8}, Facing::outward);
    add_box(scene, stone, {-2.2F, 0, -2.2F}, {-2, 3, 2.2F}, Facing::outward);
    add_box(scene, stone, {2, 0, -2.2F}, {2.2F, 3, 2.2F}, Facing::outward);
    add_box(scene, stone, {-2.2F, 0, -2.2F}, {2.2F, 3, -2}, Facing::outward);
    add_box(scene, stone, {-2.2F, 3, -2.2F}, {2.2F, 3.2F, 2.2F}, Facing::outward);
    Volume volume = make_volume({{{-7.75, -7.75, -7.75}, {0.5, 0.5, 0.5}, {32, 26, 32}}}, 1);
    for (glm::vec3& c : volume.coefficients) c = glm::vec3(1);
    for (const auto& [unit, height] : {std::pair(1.0, 1.5), std::pair(2.0, 0.8)}) {  // half of the headroom; 1.6 m
        scene.metres_per_unit = unit;
        const Camera camera = find_viewpoint(Tracer(scene), volume, 60);
        EXPECT_LT(std::abs(camera.eye.x), 2) << unit;
        EXPECT_LT(std::abs(camera.eye.z), 2) << unit;
        EXPECT_NEAR(camera.eye.y, height, 1e-3) << unit;
    }
}

TEST(LitLevel, ShowsAlbedoTimesIrradianceOverPi) {
    const Floor floor;
    const Tracer tracer(floor.scene);
    const Sampler sampler(floor.volume);
    const Environment sky = Environment::uniform({0.1F, 0.2F, 0.3F});
    const LitLevel level{&tracer, &sampler, &sky, {}};
    const View view = render(level, Camera::looking_at({0, 1, 0}, {0, 0, 0}, 60), {8, 6}, 1);
    for (const glm::vec3& pixel : view.light.pixels) EXPECT_NEAR(pixel.r, 0.5F, 1e-4F);  // E = pi, albedo 0.5
    for (const float depth : view.depth) EXPECT_NEAR(depth, 1, 1e-4F);

    const View up = render(level, Camera::looking_at({0, 1, 0}, {0, 2, 0}, 60), {2, 2}, 1);
    EXPECT_EQ(up.light.pixels[0], glm::vec3(0.1F, 0.2F, 0.3F));
    EXPECT_TRUE(std::isinf(up.depth[0]));
}

TEST(LitLevel, MeanIrradianceOfUniformLightIsPi) {
    const Floor floor;
    EXPECT_NEAR(mean_irradiance(Sampler(floor.volume), {0.3, 0.7, -0.4}).g, std::numbers::pi, 1e-5);
}

TEST(LitLevel, ToneMapKeepsOrderWithinTheDisplay) {
    float last = -1;
    for (float radiance = 0; radiance < 100; radiance = radiance * 1.2F + 1e-4F) {
        const float shown = tone_map(glm::vec3(radiance), 1).r;
        EXPECT_GE(shown, last) << radiance;
        EXPECT_LE(shown, 1);
        last = shown;
    }
    EXPECT_EQ(tone_map(glm::vec3(0), 1), glm::vec3(0));
}

TEST(Pictures, SlicesOfUniformLightHaveOneColour) {
    const Floor floor;
    const Tracer tracer(floor.scene);
    const Sampler sampler(floor.volume);
    const Environment black;
    const LitLevel level{&tracer, &sampler, &black, {}};
    PictureOptions options;
    options.at = {0.1, 1.1, 0.1};
    options.width = 400;
    const Canvas slices = draw_slices(level, floor.volume, options);
    // The plan, 208 pixels square, is the largest picture.
    const glm::vec3 middle = slices.pixels[static_cast<std::size_t>(200) * 400 + 120];
    const auto same = std::count_if(slices.pixels.begin(), slices.pixels.end(),
                                    [&](glm::vec3 pixel) { return glm::distance(pixel, middle) < 1e-3F; });
    EXPECT_GT(same, 208 * 208);
}

TEST(Pictures, ProbesAreDrawnWhereTheyStand) {
    Floor floor;
    floor.volume.states[21] = ProbeState::filled;  // probe (1, 1, 1) of the first brick
    const Tracer tracer(floor.scene);
    const Sampler sampler(floor.volume);
    const Environment black;
    const LitLevel level{&tracer, &sampler, &black, {}};
    PictureOptions options;
    options.at = {0, 1, -1};
    options.width = 400;
    const auto red_pixels = [&] {
        const Canvas canvas = draw_probes(level, floor.volume, options);
        return std::count(canvas.pixels.begin(), canvas.pixels.end(), hex_color(0xE5484D));
    };
    const auto with = red_pixels();
    floor.volume.states[21] = ProbeState::valid;
    const auto without = red_pixels();  // the key's own ring
    EXPECT_GT(with, without + 20);
}

TEST(Lettering, EveryLetterStaysOnItsLine) {
    for (char c = '!'; c <= '~'; ++c) {
        const Lettering lettering = letter(std::string(1, c), 12);
        for (const Stroke& stroke : lettering.strokes) {
            EXPECT_NE(stroke.from, stroke.to) << c;
            for (const glm::vec2 end : {stroke.from, stroke.to}) {
                EXPECT_TRUE(end.x >= 0 && end.x < lettering.width && end.y >= 0 && end.y <= 16) << c;
            }
        }
    }
    EXPECT_EQ(letter("ab", 10).width, letter("a", 10).width + letter("b", 10).width);
}

nlohmann::json report_of(int points) {
    nlohmann::json part{{"relrmse", 0.02}, {"interval", {0.018, 0.022}}};
    nlohmann::json report{{"level", "hall.glb"}, {"error", part}, {"curve", nlohmann::json::array()}};
    report["error"]["parts"] = {{"noise", part}, {"bands", part}, {"interpolation", part}, {"storage", nullptr}};
    for (int i = 1; i <= points; ++i) {
        report["curve"].push_back({{"seconds", i}, {"relrmse", 0.1 / i}, {"interval", {0.09 / i, 0.11 / i}}});
    }
    return report;
}

TEST(ErrorChart, HasADotForEachPointOfTheCurve) {
    const std::string svg = error_chart(report_of(5), "report.json");
    std::size_t dots = 0;
    for (std::size_t at = 0; (at = svg.find("<circle", at)) != std::string::npos; ++at) ++dots;
    EXPECT_EQ(dots, 5U);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(ErrorChart, RefusesReportsWithoutAMeasuredError) {
    EXPECT_THROW((void)error_chart(report_of(0), "report.json"), Error);
    EXPECT_THROW((void)error_chart(nlohmann::json::object(), "report.json"), Error);
    nlohmann::json unmeasured = report_of(3);
    unmeasured["error"]["relrmse"] = nullptr;
    EXPECT_THROW((void)error_chart(unmeasured, "report.json"), Error);
}

}  // namespace
}  // namespace lightgrid
