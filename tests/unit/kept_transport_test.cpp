// Light that is solved with kept transport, against bakes in the same light.

#include "probes/kept_transport.h"

#include "core/error.h"
#include "core/parallel.h"
#include "probes/bake.h"
#include "tests/gltf_builder.h"
#include "tests/scene_builder.h"
#include "tests/unit/lit_room.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>

namespace lightgrid {
namespace {

BakeOptions options() {
    BakeOptions options;
    options.placement.spacing = 0.6;
    options.target.samples = 512;
    options.measure_error = false;
    options.keep_transport = true;
    return options;
}

/// A bake of its own.
BakeResult bake(const Room& room, const BakeOptions& options) {
    const Tracer tracer(room.scene);
    const PathTracer paths(tracer, room.sky, separate_sources(room.scene, room.sky));
    return run_bake(paths, plan_bake(paths, options), options);
}

BakeResult bake_again(const KeptTransport& kept, const Room& room) {
    const Tracer tracer(room.scene);
    const PathTracer paths(tracer, room.sky);
    return bake_from(kept, paths, plan_of(kept, room.scene), options());
}

struct Change {
    const char* name;
    std::function<void(Room&)> make;
    bool traces;
};

const std::vector<Change>& changes() {
    static const std::vector<Change> all = {
        {"nothing", [](Room&) {}, false},
        {"a lamp's intensity", [](Room& room) { room.scene.materials[lamp].emission *= 5.0F; }, false},
        {"a lamp's colour",
         [](Room& room) {
             room.scene.materials[lamp].emission = {12, 6, 0};
         },
         false},
        {"a lamp is off", [](Room& room) { room.scene.materials[lamp].emission = glm::vec3(0); }, false},
        {"the sky is scaled",
         [](Room& room) {
             room.sky = Environment::uniform({2, 1, 0.25F});
         },
         false},
        {"the sky is black", [](Room& room) { room.sky = Environment(); }, false},
        {"a point light's colour",
         [](Room& room) {
             room.scene.lights[0].intensity = {1, 9, 2};
         },
         false},
        {"no point light", [](Room& room) { room.scene.lights.clear(); }, false},
        {"a point light has moved",
         [](Room& room) {
             room.scene.lights[0].position = {-1, 0.5F, 1.5F};
         },
         true},
        {"another point light",
         [](Room& room) {
             room.scene.lights.insert(room.scene.lights.begin(), point_light({-1.5F, 0.4F, 1}, 2));
         },
         true},
        {"a tube is on",
         [](Room& room) {
             room.scene.materials[neon].emission = {2, 8, 8};
         },
         true},
        {"another sky",
         [](Room& room) {
             RadianceImage image{4, 2, std::vector<glm::vec3>(8, glm::vec3(0.2F))};
             image.pixels[1] = {9, 4, 1};
             room.sky = Environment::from_image(image);
         },
         true},
    };
    return all;
}

class KeptTransportTest : public testing::Test {
  protected:
    static void SetUpTestSuite() { first_ = new BakeResult(bake(room(), options())); }
    static void TearDownTestSuite() { delete first_; }

    static const BakeResult& first() { return *first_; }
    static const KeptTransport& kept() { return *first_->kept; }

  private:
    static inline BakeResult* first_ = nullptr;
};

TEST_F(KeptTransportTest, OtherLightIsThatOfABakeInIt) {
    for (const Change& change : changes()) {
        Room changed = room();
        change.make(changed);
        const BakeResult again = bake_again(kept(), changed);
        BakeOptions other_noise = options();
        other_noise.seed = 1;
        const BakeResult fresh = bake(changed, other_noise);
        other_noise.seed = 2;
        const BakeResult another = bake(changed, other_noise);
        // As far as two bakes of other seeds are from each other: noise of gathers, which they tell, and of caches.
        const double usual = difference(another.volume, fresh.volume);
        const double found = difference(again.volume, fresh.volume);
        fmt::print("{}: {:.2f} %, two bakes {:.2f} %, noise {:.2f} % and {:.2f} %\n", change.name, 100 * found,
                   100 * usual, 100 * again.noise.relrmse, 100 * fresh.noise.relrmse);
        ASSERT_GT(usual, 0);
        EXPECT_LT(found, 1.3 * usual) << change.name;
        EXPECT_NEAR(again.noise.relrmse, fresh.noise.relrmse, 0.2 * fresh.noise.relrmse) << change.name;
    }
}

TEST_F(KeptTransportTest, TracesNothingButLightThatIsNew) {
    for (const Change& change : changes()) {
        Room changed = room();
        change.make(changed);
        const PathCounts counts = bake_again(kept(), changed).counts;
        EXPECT_EQ(counts.rays, 0U) << change.name;
        EXPECT_EQ(counts.shadow_rays > 0, change.traces) << change.name;
    }
}

TEST_F(KeptTransportTest, UnchangedLightGivesTheSameBits) {
    const BakeResult again = bake_again(kept(), room());
    EXPECT_EQ(again.volume.coefficients, first().volume.coefficients);
    EXPECT_EQ(again.volume.errors, first().volume.errors);
    EXPECT_EQ(again.volume.axis_errors, first().volume.axis_errors);
    EXPECT_EQ(again.volume.states, first().volume.states);
    EXPECT_EQ(again.volume.settings, first().volume.settings);
}

TEST_F(KeptTransportTest, ABakeThatKeepsItsTransportHasTheLightOfOneThatDoesNot) {
    BakeOptions without = options();
    without.keep_transport = false;
    const BakeResult plain = bake(room(), without);
    EXPECT_FALSE(plain.kept);
    // The same rays and samples; what differs is what gathers do where they meet no patch.
    EXPECT_LT(difference(first().volume, plain.volume), 0.1 * plain.noise.relrmse);
    EXPECT_NEAR(first().noise.relrmse, plain.noise.relrmse, 0.2 * plain.noise.relrmse);
}

TEST_F(KeptTransportTest, AnyNumberOfThreadsGivesTheSameBits) {
    const TemporaryFolder folder;
    Room changed = room();
    changes().back().make(changed);
    std::vector<std::string> files;
    std::vector<std::vector<glm::vec3>> light;
    for (const int threads : {1, 2}) {
        const ThreadLimit limit(threads);
        const BakeResult made = bake(room(), options());
        save_transport(*made.kept, folder.path() / "kept");
        files.push_back(read_bytes(folder.path() / "kept"));
        light.push_back(bake_again(*made.kept, changed).volume.coefficients);
    }
    EXPECT_TRUE(files[0] == files[1]);
    EXPECT_EQ(light[0], light[1]);
}

// ---- The file

TEST_F(KeptTransportTest, AFileGivesBackWhatWasKept) {
    const TemporaryFolder folder;
    const auto file = folder.path() / "kept";
    KeptTransport marked = kept();
    marked.fingerprint = 7;
    save_transport(marked, file);
    const std::optional<KeptTransport> read = load_transport(file, 7);
    ASSERT_TRUE(read);
    const auto again = folder.path() / "again";
    save_transport(*read, again);
    EXPECT_TRUE(read_bytes(file) == read_bytes(again));
    EXPECT_EQ(bake_again(*read, room()).volume.coefficients, first().volume.coefficients);
    EXPECT_FALSE(load_transport(file, 8)) << "of something else";
}

TEST_F(KeptTransportTest, ADamagedFileIsAnError) {
    const TemporaryFolder folder;
    const auto file = folder.path() / "kept";
    save_transport(kept(), file);
    const std::string whole = read_bytes(file);
    const auto expect_error = [&](const std::string& bytes, const char* what, std::size_t at) {
        write_bytes(file, bytes);
        try {
            static_cast<void>(load_transport(file, kept().fingerprint));
            FAIL() << "no error: " << what << " " << at;
        } catch (const Error& error) {
            EXPECT_EQ(error.problem(), what) << at;
            EXPECT_EQ(error.where(), file.string());
            EXPECT_FALSE(error.remedy().empty());
        }
    };
    expect_error("", "holds no transport", 0);
    expect_error("glTF and not this", "holds no transport", 0);
    expect_error(whole.substr(0, 15), "holds no transport", 15);
    for (std::size_t i = 0; i < 24; ++i) {
        const std::size_t size = 16 + i * (whole.size() - 17) / 23;
        expect_error(whole.substr(0, size), "is damaged", size);
        std::string flipped = whole;
        flipped[size] = static_cast<char>(flipped[size] ^ 1);
        expect_error(flipped, "is damaged", size);
    }
}

TEST(TransportFingerprint, IsOfEverythingButWhatShines) {
    const Room usual = room();
    const std::uint64_t same = transport_fingerprint(usual.scene, options(), "1");
    for (const Change& change : changes()) {
        Room changed = room();
        change.make(changed);
        EXPECT_EQ(transport_fingerprint(changed.scene, options(), "1"), same) << change.name;
    }
    const std::vector<std::function<void(Scene&, BakeOptions&, std::string&)>> others = {
        [](Scene&, BakeOptions&, std::string& version) { version = "2"; },
        [](Scene& scene, BakeOptions&, std::string&) { scene.meshes[2].positions[1].x += 0x1p-20F; },
        [](Scene& scene, BakeOptions&, std::string&) {
            std::swap(scene.meshes[0].triangles[0].x, scene.meshes[0].triangles[0].y);
        },
        [](Scene& scene, BakeOptions&, std::string&) { scene.meshes[1].material = lamp; },
        [](Scene& scene, BakeOptions&, std::string&) { scene.materials[wall].base_color.y *= 0.99F; },
        [](Scene& scene, BakeOptions&, std::string&) { scene.materials[wall].transmission = 0.1F; },
        [](Scene& scene, BakeOptions&, std::string&) { scene.materials[lamp].double_sided = true; },
        [](Scene& scene, BakeOptions&, std::string&) { scene.probe_markers.emplace_back(0); },
        [](Scene& scene, BakeOptions&, std::string&) { add_instance(scene, 0, glm::mat4x3(1)); },
        [](Scene&, BakeOptions& bake, std::string&) { bake.seed = 1; },
        [](Scene&, BakeOptions& bake, std::string&) { bake.placement.spacing = 0.61; },
        [](Scene&, BakeOptions& bake, std::string&) { bake.target.samples = 1024; },
        [](Scene&, BakeOptions& bake, std::string&) { bake.target = {}; },
        [](Scene&, BakeOptions& bake, std::string&) { bake.bands = 4; },
        [](Scene&, BakeOptions& bake, std::string&) { bake.probes.emplace(); },
    };
    for (std::size_t i = 0; i < others.size(); ++i) {
        Room changed = room();
        BakeOptions bake_options = options();
        std::string version = "1";
        others[i](changed.scene, bake_options, version);
        EXPECT_NE(transport_fingerprint(changed.scene, bake_options, version), same) << "change " << i;
    }
}

// ---- Sources

TEST(LightSources, EachLightThatIsNotBlackIsOne) {
    const Room level = room();
    const LightSources sources = separate_sources(level.scene, level.sky);
    EXPECT_EQ(sources.count, 3U);
    EXPECT_EQ(sources.material(wall), LightSources::off);
    EXPECT_EQ(sources.material(neon), LightSources::off);
    EXPECT_NE(sources.material(lamp), LightSources::off);
    EXPECT_NE(sources.light(0), sources.material(lamp));
    EXPECT_NE(sources.of_sky, sources.material(lamp));
    EXPECT_EQ(separate_sources(level.scene, Environment()).of_sky, LightSources::off);
}

TEST(LightSources, MoreThanThereIsRoomForShareOne) {
    Room level = room();
    level.scene.lights.assign(100, point_light({0, 1, 0}, 1));
    for (std::size_t i = 0; i < level.scene.lights.size(); ++i) level.scene.lights[i].position.x = 0.01F * i;
    const LightSources sources = separate_sources(level.scene, level.sky);
    EXPECT_EQ(sources.count, LightSources::most);
    EXPECT_EQ(sources.light(98), sources.light(99));
    const LightState before = light_of(level.scene, level.sky, sources);

    for (Light& light : level.scene.lights) light.intensity *= 2.0F;
    const LightChange together = compare_light(before, level.scene, level.sky);
    EXPECT_FALSE(together.any_other);
    EXPECT_EQ(together.factor[sources.light(99)], glm::vec3(2));

    level.scene.lights[99].intensity *= 2.0F;
    const LightChange apart = compare_light(before, level.scene, level.sky);
    EXPECT_TRUE(apart.any_other);
    EXPECT_EQ(apart.factor[sources.light(99)], glm::vec3(0));
    EXPECT_EQ(apart.factor[sources.light(0)], glm::vec3(2));
    EXPECT_EQ(apart.others.light(98), 0U);
    EXPECT_EQ(apart.others.light(99), 0U);
    EXPECT_EQ(apart.others.light(0), LightSources::off);
    EXPECT_EQ(apart.others.of_sky, LightSources::off);
}

TEST(LightSources, AColourThatWasBlackIsTracedAgain) {
    Room level = room();
    level.scene.materials[lamp].emission = {1, 1, 0};
    const LightState before = light_of(level.scene, level.sky, separate_sources(level.scene, level.sky));
    level.scene.materials[lamp].emission = {2, 3, 0};
    EXPECT_EQ(compare_light(before, level.scene, level.sky).factor[before.sources.material(lamp)], glm::vec3(2, 3, 0));
    level.scene.materials[lamp].emission = {2, 3, 1};
    EXPECT_EQ(compare_light(before, level.scene, level.sky).others.material(lamp), 0U);
}

}  // namespace
}  // namespace lightgrid
