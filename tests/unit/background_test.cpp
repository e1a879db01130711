// What the viewer does beside its frame loop: bakes, traces references, watches a file.

#include "core/error.h"
#include "probes/volume_file.h"
#include "tests/scene_builder.h"
#include "tests/traced_level.h"
#include "viewer/background_answer.h"
#include "viewer/background_bake.h"
#include "viewer/background_object.h"
#include "viewer/reference_probe.h"
#include "viewer/transfer.h"
#include "viewer/volume_watch.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

/// A room of 4 m with a lamp and a crate.
struct Room : TracedLevel {
    Room() : TracedLevel(made()) {}
    static Scene made() {
        Scene room;
        room.name = "room.glb";
        const int wall = add_grey(room, 0.5F);
        const int lamp = add_grey(room, 0, 10);
        add_box(room, wall, {0, 0, 0}, {4, 4, 4}, Facing::inward);
        add_box(room, wall, {2.5F, 0, 2.5F}, {3.5F, 1, 3.5F}, Facing::outward);
        add_quad(room, lamp, {1.5F, 3.9F, 1.5F}, {1, 0, 0}, {0, 0, 1});
        return room;
    }
};

BakeOptions small_bake() {
    BakeOptions options;
    options.placement.spacing = 1;
    return options;
}

/// What `ask` gives, as soon as it gives anything; nothing after a minute.
template <typename Ask>
auto wait_for(Ask ask) {
    const auto give_up = Clock::now() + 60s;
    auto answer = ask();
    while (!answer && Clock::now() < give_up) {
        std::this_thread::sleep_for(2ms);
        answer = ask();
    }
    return answer;
}

TEST(BackgroundBake, HandsOverBetterAndBetterVolumesThatRunBakeWouldMake) {
    const Room room;
    BackgroundBake bake(room.paths, small_bake(), 256);
    std::vector<BakedVolume> volumes;
    while (volumes.empty() || !volumes.back().last) {
        auto baked = wait_for([&] { return bake.take(); });
        ASSERT_TRUE(baked);
        volumes.push_back(std::move(*baked));
    }
    EXPECT_EQ(volumes.back().samples, 256U);
    EXPECT_FALSE(bake.take()) << "each once";
    EXPECT_TRUE(wait_for([&] { return !bake.status().working; }));
    BakeOptions options = small_bake();
    options.measure_error = false;
    options.target.samples = 256;
    BakePlan plan = plan_bake(room.paths, options);
    double noise = 1e9;
    for (const BakedVolume& baked : volumes) {
        check_volume(baked.volume);
        EXPECT_LT(baked.noise, noise);
        noise = baked.noise;
        set_samples(plan, baked.samples);
        EXPECT_EQ(baked.volume.coefficients, run_bake(room.paths, plan, options).volume.coefficients);
    }
}

TEST(BackgroundBake, StopsWhenAsked) {
    const Room room;
    const auto start = Clock::now();
    {
        BakeOptions options = small_bake();
        options.placement.spacing = 0.25;  // 4,913 probes: the whole would take hours
        BackgroundBake bake(room.paths, options, 1U << 30U);
        ASSERT_TRUE(wait_for([&] { return bake.take(); })) << "the first volume is there soon";
        const std::string stage = bake.status().stage;
        EXPECT_TRUE(stage == "cache" || stage == "gather") << stage;
        bake.stop();
        EXPECT_TRUE(wait_for([&] { return !bake.status().working; }));
    }
    { const BackgroundBake dies_at_once(room.paths, small_bake(), 1U << 30U); }
    EXPECT_LT(Clock::now() - start, 60s);
}

TEST(BackgroundBake, ThrowsWhatTheBakeThrew) {
    const Room room;
    BakeOptions options;
    options.placement.spacing = 1e-4;
    BackgroundBake bake(room.paths, options);
    EXPECT_TRUE(wait_for([&] { return !bake.status().working; }));
    EXPECT_THROW(static_cast<void>(bake.take()), Error);
    EXPECT_FALSE(bake.take()) << "once";
}

TEST(Bake, EndsByWhatItsProgressThrows) {
    const Room room;
    struct Enough {};
    const BakeOptions options = small_bake();
    EXPECT_THROW(static_cast<void>(plan_bake(room.paths, options, [](const Doing&) { throw Enough(); })), Enough);
    const BakePlan plan = plan_bake(room.paths, options);
    for (const char* const last_stage : {"reference", "gather"}) {
        const auto progress = [&](const Doing& doing) {
            if (doing.stage == last_stage) throw Enough();
        };
        EXPECT_THROW(static_cast<void>(run_bake(room.paths, plan, options, progress)), Enough) << last_stage;
    }
}

TEST(BackgroundAnswer, EndsWorkOnWhatIsNoLongerAskedAndTellsNothingOfIt) {
    std::atomic<bool> begun = false;
    BackgroundAnswer<int, int> answer([&](int question, const auto& turn) {
        if (question < 0) {
            begun = true;
            while (true) turn.check();  // until something else is asked
        }
        turn.tell([&](std::optional<int>& news) { news = news.value_or(0) + question; });
        turn.tell([&](std::optional<int>& news) { news = news.value_or(0) + question; });
    });
    answer.ask(-1);
    ASSERT_TRUE(wait_for([&] { return begun.load(); }));
    EXPECT_FALSE(answer.take());
    answer.ask(3);
    int told = 0;
    while (told < 6) {
        const std::optional<int> news = wait_for([&] { return answer.take(); });
        ASSERT_TRUE(news);
        told += *news;
    }
    EXPECT_EQ(told, 6);
    answer.ask(-1);  // its end, too, ends the work
}

TEST(BackgroundObject, ComesAsItIsAndThenWithItsShadowsUnlessAnotherIsWanted) {
    const ObjectMesh large = make_sphere(192);
    const ObjectMesh small = make_sphere(8);
    BackgroundObject object;
    EXPECT_FALSE(object.take()) << "nothing was asked";
    const auto expect_all_of = [&](const ObjectMesh& mesh) {
        bool has_come = false;
        std::optional<std::vector<float>> transfer;
        while (!transfer) {
            std::optional<ObjectNews> news = wait_for([&] { return object.take(); });
            ASSERT_TRUE(news);
            if (news->mesh) {
                EXPECT_FALSE(has_come) << "once";
                EXPECT_EQ(news->mesh->positions, mesh.positions);
                has_come = true;
            }
            transfer = std::move(news->transfer);
        }
        EXPECT_TRUE(has_come);
        EXPECT_EQ(*transfer, self_shadowed_transfer(mesh, shown_transfer(mesh)));
        EXPECT_FALSE(object.take());
    };
    object.ask([&] { return large; });
    expect_all_of(large);

    object.ask([&] { return large; });
    ASSERT_TRUE(wait_for([&] { return object.take(); }));
    object.ask([]() -> ObjectMesh { throw Error("nobody asks for this any more"); });
    object.ask([&] { return small; });
    expect_all_of(small);
}

TEST(BackgroundObject, ThrowsWhatLoadingThrew) {
    BackgroundObject object;
    object.ask([] { return load_object("no such file.glb"); });
    const auto fails = [&] {
        try {
            return object.take().has_value();
        } catch (const Error&) {
            return true;
        }
    };
    EXPECT_TRUE(wait_for(fails));
    EXPECT_FALSE(object.take()) << "once";
    object.ask([] { return make_sphere(8); });
    EXPECT_TRUE(wait_for([&] { return object.take(); })) << "and goes on";
}

TEST(ReferenceProbe, ImprovesItsAnswerToTheLatestQuestion) {
    const Room room;
    ReferenceProbe probe(room.paths);
    EXPECT_FALSE(probe.take()) << "nothing was asked";
    probe.ask({3.9, 2, 2}, {-1, 0, 0});
    const glm::dvec3 under_the_lamp(2, 1, 2);
    probe.ask(under_the_lamp, {0, 1, 0});
    auto first = wait_for([&] { return probe.take(); });
    ASSERT_TRUE(first);
    EXPECT_EQ(first->position, under_the_lamp) << "the question before it was given up";
    ReferenceLight best = *first;
    while (!best.last) {
        auto next = wait_for([&] { return probe.take(); });
        ASSERT_TRUE(next);
        EXPECT_GT(next->samples, best.samples);
        best = *next;
    }
    EXPECT_LE(best.irradiance.error.g, first->irradiance.error.g);
    EXPECT_NEAR(best.irradiance.mean.g, first->irradiance.mean.g, 6 * first->irradiance.error.g);
    GatherOptions options;
    options.normals = {best.normal};
    options.samples = 1U << 16U;
    options.seed = 99;
    const Estimate other = gather(room.paths, {glm::vec3(under_the_lamp - room.scene.origin)}, options).irradiance[0];
    EXPECT_NEAR(best.irradiance.mean.g, other.mean.g, 5 * (other.error.g + best.irradiance.error.g));
    probe.ask(under_the_lamp, {0, -1, 0});
    auto below = wait_for([&] { return probe.take(); });
    ASSERT_TRUE(below) << "it goes on answering";
    EXPECT_LT(below->irradiance.mean.g, best.irradiance.mean.g);
}

TEST(ReferenceProbe, ComparesWithTheVolume) {
    ReferenceLight reference;
    reference.irradiance.mean = glm::dvec3(6);
    reference.irradiance.error = glm::dvec3(0.01);
    const LightComparison comparison = compare(reference, glm::vec3(3));
    EXPECT_EQ(comparison.volume, glm::vec3(3));
    EXPECT_NEAR(comparison.relative, -0.5, 1e-6);
    EXPECT_FLOAT_EQ(comparison.reference_error.g, 0.01F);
    reference.irradiance.mean = glm::dvec3(0);
    EXPECT_EQ(compare(reference, glm::vec3(0)).relative, 0);
    EXPECT_TRUE(std::isinf(compare(reference, glm::vec3(1)).relative));
}

/// A folder with a volume of the room's, gone in the end.
class VolumeFile {
  public:
    VolumeFile() {
        fs::create_directories(folder_);
        save(volume_);
    }
    ~VolumeFile() {
        std::error_code none;
        fs::remove_all(folder_, none);
    }
    VolumeFile(const VolumeFile&) = delete;
    VolumeFile& operator=(const VolumeFile&) = delete;

    static Volume make(const std::string& level) {
        Volume volume = make_volume({{{0, 0, 0}, {2, 2, 2}, {3, 3, 3}}}, 1);
        volume.settings = {{"level", level}};
        return volume;
    }
    void save(const Volume& volume) const { save_volume(volume, path_); }
    [[nodiscard]] const fs::path& path() const { return path_; }

  private:
    fs::path folder_ = fs::temp_directory_path() / ("lightgrid-watch-" + std::to_string(::getpid()));
    fs::path path_ = folder_ / "room.probes.exr";
    Volume volume_ = make("room.glb");
};

TEST(VolumeWatch, ReloadsANewBakeOfTheSameLevelOnce) {
    const Scene level = Room::made();
    const VolumeFile file;
    VolumeWatch watch(file.path(), level);
    EXPECT_FALSE(watch.poll());
    Volume brighter = VolumeFile::make("room.glb");
    for (glm::vec3& value : brighter.coefficients) value = glm::vec3(7);
    file.save(brighter);
    const auto news = wait_for([&] { return watch.poll(); });
    ASSERT_TRUE(news);
    ASSERT_TRUE(news->volume) << news->notice;
    EXPECT_EQ(news->volume->coefficients[0], glm::vec3(7));
    std::this_thread::sleep_for(VolumeWatch::settle);
    EXPECT_FALSE(watch.poll()) << "nothing new";
    file.save(VolumeFile::make("room.glb"));
    const auto again = wait_for([&] { return watch.poll(); });
    ASSERT_TRUE(again);
    EXPECT_TRUE(again->volume);
}

TEST(VolumeWatch, KeepsTheOldVolumeWhereTheNewOneIsNone) {
    const Scene level = Room::made();
    const VolumeFile file;
    VolumeWatch watch(file.path(), level);
    const auto expect_notice = [&](const std::string& words) {
        const auto news = wait_for([&] { return watch.poll(); });
        ASSERT_TRUE(news) << words;
        EXPECT_FALSE(news->volume) << words;
        EXPECT_NE(news->notice.find(words), std::string::npos) << news->notice;
        EXPECT_NE(news->notice.find("room.probes.exr"), std::string::npos) << news->notice;
    };
    file.save(VolumeFile::make("hall.glb"));
    expect_notice("hall.glb");
    Volume far = VolumeFile::make("room.glb");
    far.grids[0].origin = {100, 0, 0};
    file.save(far);
    expect_notice("none of its grids");
    Volume list = make_probe_list({{1, 1, 1}}, 1);
    file.save(list);
    expect_notice("list");
    fs::resize_file(file.path(), fs::file_size(file.path()) / 2);
    expect_notice("The old volume stays");
    std::ofstream(file.path()) << "hello";
    expect_notice("The old volume stays");
    fs::remove(file.path());
    expect_notice("gone");
    file.save(VolumeFile::make("room.glb"));
    const auto news = wait_for([&] { return watch.poll(); });
    ASSERT_TRUE(news);
    EXPECT_TRUE(news->volume) << "it is back: " << news->notice;
}

}  // namespace
}  // namespace lightgrid
