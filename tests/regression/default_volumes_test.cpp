// Volumes as a bake without options makes them, in several levels of grids: what shaders read of them, what is outside
// of them, and what the default flight shows. Pictures of them have no references on disk, as those of volumes with a
// fixed spacing have (flown_pictures_test.cpp): another seed or a better planner refines elsewhere. They are compared
// with rays and the Sampler instead.

#include "core/gltf.h"
#include "core/image.h"
#include "core/tracer.h"
#include "core/whole_file.h"
#include "probes/volume_file.h"
#include "tests/regression/program_test.h"
#include "tests/unit/card.h"
#include "viewer/default_flight.h"
#include "viewer/normals.h"
#include "viewer/renderer.h"

#include <algorithm>
#include <map>
#include <memory>
#include <numbers>
#include <ostream>
#include <random>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

class DefaultVolumes : public testing::TestWithParam<std::string> {
  protected:
    void SetUp() override {
        const fs::path file = fs::path(LIGHTGRID_DEFAULT_VOLUMES) / (GetParam() + ".probes.exr");
        if (!fs::exists(file)) GTEST_SKIP() << file << " is missing: ctest bakes it, if its level is there";
        volume_ = load_volume(file);
        ASSERT_GT(volume_.grids.size(), 1U);
    }
    Volume volume_;
};

TEST_P(DefaultVolumes, AnswerOnTheCardAsTheSamplerDoes) {
    Card card;
    const VolumeTextures textures = pack_volume(volume_);
    const auto check = [&](const std::vector<Query>& queries, const char* where) {
        const std::vector<double> sorted = differences(card, volume_, textures, queries);
        fmt::print("{} {}: {}\n", GetParam(), where, spread(sorted));
        // Light jumps on faces between levels of grids, and float may see a point on the other side.
        EXPECT_LT(sorted[sorted.size() * 999 / 1000], 1e-3) << where;
    };
    check(random_queries(volume_, textures.origin, card_points), "inside");
    check(queries_around(volume_, textures.origin, card_points), "around");
}

TEST_P(DefaultVolumes, KeepTheLightOfTheirFacesOutside) {
    const Sampler sampler(volume_);
    glm::dvec3 low = volume_.grids.front().origin;
    glm::dvec3 high = low;
    for (const Grid& grid : volume_.grids) {
        low = glm::min(low, grid.origin);
        high = glm::max(high, grid.position(grid.counts - 1));
    }
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0, 1);
    const SampleOptions fade{.outside = Outside::fade, .fade_distance = 2};
    int lit = 0;
    for (int i = 0; i < 6000; ++i) {
        const int axis = i % 3;
        const bool upper = i % 2 == 0;
        glm::dvec3 face = glm::mix(low, high, glm::dvec3(uniform(random), uniform(random), uniform(random)));
        face[axis] = upper ? high[axis] : low[axis];
        const Sample wanted = sampler.sample(face);
        lit += wanted.sh[0] != glm::vec3(0) ? 1 : 0;
        for (const double distance : {0.001, 1.0}) {
            glm::dvec3 outside = face;
            outside[axis] += upper ? distance : -distance;
            const Sample got = sampler.sample(outside);
            const float scale = 1e-4F * glm::length(wanted.sh[0]);
            EXPECT_LE(glm::distance(got.sh[0], wanted.sh[0]), scale) << face.x << " " << face.y << " " << face.z;
            EXPECT_NEAR(got.weight, wanted.weight, 1e-4);
            const glm::vec3 faded = sampler.sample(outside, fade).sh[0];
            EXPECT_LE(glm::distance(faded, (1 - static_cast<float>(distance) / 2) * wanted.sh[0]), scale);
        }
    }
    EXPECT_GT(lit, 3000);
}

fs::path level_of(const std::string& name) {
    const bool is_shared = name == "modern_hall";
    return is_shared ? fs::path(LIGHTGRID_SHARED) / "data/level-bitterli-modern-hall/scene.gltf"
                     : fs::path(LIGHTGRID_SCENES) / (name + ".glb");
}

/// The level with all its surfaces white, opaque and dark: a picture of it shows the volume's light and nothing else.
Scene painted_white(Scene scene) {
    for (Material& material : scene.materials) material = Material();
    for (Mesh& mesh : scene.meshes) mesh.colors.clear();
    return scene;
}

/// Triangles that pictures show with their own normal; those of curved surfaces have others at each corner.
std::vector<bool> flat_triangles(const Mesh& mesh) {
    const auto normals = corner_normals(mesh.positions, mesh.triangles, level_crease_deg);
    std::vector<bool> flat;
    for (const auto& [a, b, c] : normals) flat.push_back(glm::dot(a, b) > 0.99999F && glm::dot(a, c) > 0.99999F);
    return flat;
}

TEST_P(DefaultVolumes, LightPicturesAsTheSamplerDoes) {
    constexpr glm::ivec2 size(160, 90);
    constexpr int frames = 6;
    constexpr float tolerance = 0.02F;  // of the light
    const Scene scene = painted_white(load_level(level_of(GetParam())));
    const Tracer tracer(scene);
    const auto lit = std::make_shared<const LitVolume>(std::move(volume_));
    const DefaultFlight flight = make_default_flight(tracer, *lit);
    std::map<const Mesh*, std::vector<bool>> flat;
    for (const Mesh& mesh : scene.meshes) flat[&mesh] = flat_triangles(mesh);

    Headless surface;
    Renderer renderer(surface.gl(), built_in_shaders());
    renderer.set_level(scene, lit->spacing, std::vector<bool>(scene.materials.size(), false));
    renderer.set_volume(lit);
    Settings settings;
    settings.level_light = LevelLight::pixel;
    settings.show_object = false;
    const LookUp light = renderer.level_look_up(settings);
    Frame frame;
    frame.lens = lens_for(glm::length(scene.bounds.size()), flight.object_size);
    int compared = 0;
    int differing = 0;
    for (int i = 0; i < frames; ++i) {
        frame.pose = evaluate(flight.flight, frame_time_s(flight.flight, i, frames)).pose;
        const Pane pane{{glm::ivec2(0), size}, settings};
        renderer.draw(frame, std::span(&pane, 1), size, 1);
        const RadianceImage drawn = renderer.read_light();
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                const glm::vec3 ray(ray_through(frame.pose, frame.lens, glm::dvec2(x, y), size));
                const Hit hit = tracer.closest_hit(glm::vec3(frame.pose.eye - scene.origin), ray);
                if (!hit.found()) continue;
                const Surface seen = tracer.surface(hit, ray);
                if (!flat[seen.mesh][hit.id.triangle]) continue;
                const glm::vec3 wanted =
                    std::numbers::inv_pi_v<float> * surface_irradiance(light, glm::dvec3(seen.position) + scene.origin,
                                                                       seen.front ? seen.normal : -seen.normal);
                ++compared;
                const float off = glm::distance(drawn.at(x, y), wanted);
                differing += off > tolerance * glm::length(wanted) ? 1 : 0;
            }
        }
    }
    fmt::print("{}: {} of {} pixels differ by more than {} %\n", GetParam(), differing, compared, 100 * tolerance);
    EXPECT_GT(compared, frames * size.x * size.y / 4);
    EXPECT_LT(differing, 0.002 * compared)
        << "at edges, and where float sees a point on the other side of a cell's face";
}

INSTANTIATE_TEST_SUITE_P(Baked, DefaultVolumes, testing::Values("default", "inn", "courtyard", "modern_hall"),
                         [](const auto& name) { return name.param; });

class DefaultFlight : public ProgramTest {
  protected:
    DefaultFlight() : ProgramTest(FLY_THROUGH_PROGRAM) {}
};

TEST_F(DefaultFlight, SeesHardlyAnythingBlack) {
    const fs::path volume = fs::path(LIGHTGRID_DEFAULT_VOLUMES) / "default.probes.exr";
    if (!fs::exists(volume)) GTEST_SKIP() << volume << " is missing: ctest bakes it";
    constexpr int frames = 16;
    const Result result =
        run(fmt::format(LIGHTGRID_SCENES "/default.glb {} --headless --out frames --frames {} --size 320x180",
                        volume.string(), frames));
    ASSERT_EQ(result.status, 0) << result.err;
    double sum = 0;
    double most = 0;
    for (int i = 0; i < frames; ++i) {
        const fs::path file = folder() / fmt::format("frames/frame_{:05}.png", i);
        const std::string bytes = read_whole_file(file);
        const ByteImage image = decode_image(std::as_bytes(std::span(bytes)), file.string());
        const auto black = std::count_if(image.pixels.begin(), image.pixels.end(), [](const glm::u8vec4& pixel) {
            return std::max({pixel.r, pixel.g, pixel.b}) <= 2;
        });
        const double share = static_cast<double>(black) / static_cast<double>(image.pixels.size());
        sum += share;
        most = std::max(most, share);
    }
    fmt::print("black: {:.2f} % of all pixels, {:.2f} % of the worst frame\n", 100 * sum / frames, 100 * most);
    EXPECT_LE(sum / frames, 0.03);
    EXPECT_LE(most, 0.10);
}

}  // namespace
}  // namespace lightgrid
