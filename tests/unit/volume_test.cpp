#include "probes/volume.h"

#include "core/error.h"
#include "core/sh.h"
#include "core/whole_file.h"
#include "probes/half_storage.h"
#include "probes/volume_file.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sys/resource.h>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

// A folder of this test's own, gone with it.
class Folder {
  public:
    Folder() {
        std::string name = (fs::temp_directory_path() / "lightgrid-volume-XXXXXX").string();
        path_ = ::mkdtemp(name.data());
    }
    ~Folder() { fs::remove_all(path_); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    [[nodiscard]] fs::path operator/(const char* name) const { return path_ / name; }
    [[nodiscard]] std::size_t files() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(path_), fs::directory_iterator()));
    }

  private:
    fs::path path_;
};

// Two grids that no brick fits exactly, coloured light in all bands with errors, moved and invalid probes.
Volume example(int bands = 3) {
    Volume volume =
        make_volume({{{-1e5, 2.5, 3}, {0.5, 0.25, 1}, {6, 5, 9}}, {{0, 0, 0}, {2, 2, 2}, {1, 4, 3}}}, bands);
    std::mt19937 random(7);
    std::normal_distribution<float> normal(0, 1);
    for (auto* values : {&volume.coefficients, &volume.errors, &volume.axis_errors}) {
        for (glm::vec3& v : *values) v = {normal(random), normal(random), normal(random)};
    }
    for (auto* values : {&volume.errors, &volume.axis_errors}) {
        for (glm::vec3& v : *values) v = 0.02F * glm::abs(v);
    }
    volume.offsets.assign(volume.slots(), glm::vec3(0));
    const std::size_t size = volume.sh_size();
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        volume.states[slot] = static_cast<ProbeState>(1 + slot % 4);
        if (volume.states[slot] == ProbeState::moved) volume.offsets[slot] = {0.1F, -0.2F, 0.3F};
        if (volume.states[slot] == ProbeState::missing) {
            for (std::size_t i = 0; i < size; ++i) volume.coefficients[slot * size + i] = glm::vec3(0);
        }
    }
    volume.settings = {{"level", "hall \"é\".glb"}, {"seed", "1"}, {"equation", "a=b"}, {"empty", ""}};
    return volume;
}

Volume example_list(std::size_t count = 100) {
    std::vector<glm::dvec3> positions;
    for (std::size_t i = 0; i < count; ++i) positions.emplace_back(1e5 + i / 3.0, -0.1 * i, 1.0 / (1 + i));
    Volume volume = make_probe_list(std::move(positions), 3);
    for (std::size_t i = 0; i < volume.coefficients.size(); ++i) volume.coefficients[i] = glm::vec3(i, -0.5F * i, 0.1F);
    for (std::size_t i = 0; i < volume.errors.size(); ++i) volume.errors[i] = glm::vec3(0.001F * i);
    volume.states[count / 2] = ProbeState::missing;
    return volume;
}

// Grids, and single probes beside them.
Volume example_both(std::size_t count) {
    Volume volume = example();
    const Volume list = example_list(count);
    volume.list = list.list;
    volume.states.insert(volume.states.end(), list.states.begin(), list.states.end());
    volume.coefficients.insert(volume.coefficients.end(), list.coefficients.begin(), list.coefficients.end());
    volume.errors.insert(volume.errors.end(), list.errors.begin(), list.errors.end());
    volume.axis_errors.insert(volume.axis_errors.end(), list.axis_errors.begin(), list.axis_errors.end());
    volume.offsets.resize(volume.slots());
    return volume;
}

// The same with layers: one that is grey and has two bands, one of large numbers.
Volume with_layers(Volume volume) {
    Layer dim{"lamps", volume.coefficients, 0.25};
    for (std::size_t i = 0; i < dim.coefficients.size(); ++i) {
        dim.coefficients[i] = i % volume.sh_size() < 4 ? glm::vec3(0.5F * dim.coefficients[i].g) : glm::vec3(0);
    }
    Layer bright{"sky.0", volume.coefficients, 0};
    for (glm::vec3& v : bright.coefficients) v *= glm::vec3(-1e6F, 2e6F, 3);
    volume.layers = {dim, bright};
    return volume;
}

bool same_bits(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec3)) == 0);
}

void expect_same(const Volume& got, const Volume& wanted) {
    EXPECT_EQ(got.bands, wanted.bands);
    EXPECT_EQ(got.half, wanted.half);
    EXPECT_EQ(got.settings, wanted.settings);
    EXPECT_EQ(got.list, wanted.list);
    EXPECT_EQ(got.states, wanted.states);
    EXPECT_TRUE(same_bits(got.coefficients, wanted.coefficients));
    EXPECT_TRUE(same_bits(got.errors, wanted.errors));
    EXPECT_TRUE(same_bits(got.axis_errors, wanted.axis_errors));
    EXPECT_TRUE(same_bits(got.offsets, wanted.offsets));
    ASSERT_EQ(got.layers.size(), wanted.layers.size());
    for (std::size_t i = 0; i < wanted.layers.size(); ++i) {
        EXPECT_EQ(got.layers[i].name, wanted.layers[i].name);
        EXPECT_EQ(got.layers[i].noise, wanted.layers[i].noise);
        EXPECT_TRUE(same_bits(got.layers[i].coefficients, wanted.layers[i].coefficients)) << i;
    }
    ASSERT_EQ(got.grids.size(), wanted.grids.size());
    for (std::size_t g = 0; g < wanted.grids.size(); ++g) {
        EXPECT_EQ(got.grids[g].origin, wanted.grids[g].origin);
        EXPECT_EQ(got.grids[g].spacing, wanted.grids[g].spacing);
        EXPECT_EQ(got.grids[g].counts, wanted.grids[g].counts);
    }
    ASSERT_EQ(got.bricks.size(), wanted.bricks.size());
    for (std::size_t b = 0; b < wanted.bricks.size(); ++b) {
        EXPECT_EQ(got.bricks[b].grid, wanted.bricks[b].grid);
        EXPECT_EQ(got.bricks[b].origin, wanted.bricks[b].origin);
    }
}

Volume reread(const std::string& bytes) {
    return decode_volume(std::as_bytes(std::span(bytes)), "test.exr");
}

// What load says about bytes that are no good volume.
std::string complaint(const std::string& bytes) {
    try {
        static_cast<void>(reread(bytes));
    } catch (const Error& error) {
        return error.what();
    }
    return "nothing";
}

std::string complaint(const Volume& volume) {
    try {
        check_volume(volume);
    } catch (const Error& error) {
        return error.what();
    }
    return "nothing";
}

#define EXPECT_MENTIONS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

// ---- Volume

TEST(Volume, HoldsEveryProbeOfItsGridsOnce) {
    const Volume volume = make_volume({{{0, 0, 0}, {1, 1, 1}, {6, 5, 9}}, {{9, 9, 9}, {1, 1, 1}, {4, 4, 4}}}, 2);
    EXPECT_EQ(volume.bricks.size(), 2U * 2 * 3 + 1);
    std::size_t probes = 0;
    for (const ProbeState state : volume.states) probes += state != ProbeState::absent;
    EXPECT_EQ(probes, 6U * 5 * 9 + 4 * 4 * 4);
    const SlotTable table(volume);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        const int grid = volume.bricks[slot / probes_per_brick].grid;
        EXPECT_EQ(table.slot(grid, lattice_index(volume, slot)), static_cast<std::ptrdiff_t>(slot));
    }
}

TEST(Volume, PlacesProbesOnTheLatticeAndGathersBesideIt) {
    const Volume volume = example();
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] != ProbeState::moved) continue;
        const glm::dvec3 expected = lattice_position(volume, slot) + glm::dvec3(volume.offsets[slot]);
        EXPECT_EQ(gather_position(volume, slot), expected);
    }
    const Grid& grid = volume.grids[0];
    EXPECT_EQ(lattice_position(volume, 1 + 2 * 4 + 3 * 16), grid.origin + glm::dvec3(1, 2, 3) * grid.spacing);
}

TEST(Volume, RefusesWhatBreaksItsInvariants) {
    Volume volume = example();
    EXPECT_EQ(complaint(volume), "nothing");
    volume.coefficients[9 * 64 + 4].g = std::numeric_limits<float>::quiet_NaN();
    EXPECT_MENTIONS(complaint(volume), "grid 0, probe (4, 0, 0): coefficient 4, component 1, is nan");
    volume = example();
    volume.errors[3].r = -1;
    EXPECT_MENTIONS(complaint(volume), "standard error of coefficient 3");
    volume = example();
    volume.coefficients.pop_back();
    EXPECT_MENTIONS(complaint(volume), "values for");
    volume = example();
    volume.bricks[1] = volume.bricks[0];
    EXPECT_MENTIONS(complaint(volume), "stored again");
    volume = example();
    volume.bricks[1].origin.x = 5;
    EXPECT_MENTIONS(complaint(volume), "no multiple of 4");
    volume = example();
    volume.bricks[1].origin.y = -4;
    EXPECT_MENTIONS(complaint(volume), "inside grid 0");
    volume = example();
    volume.states[0] = ProbeState::absent;
    EXPECT_MENTIONS(complaint(volume), "lies inside its grid");
    volume = example();
    volume.grids[0].spacing.y = 0;
    EXPECT_MENTIONS(complaint(volume), "spacing 0.5 x 0 x 1 m");
    volume = example();
    volume.list.emplace_back(0);
    EXPECT_MENTIONS(complaint(volume), "states for");
    volume = example_list(3);
    volume.bricks.push_back({0, {0, 0, 0}});
    EXPECT_MENTIONS(complaint(volume), "bricks without a grid");
    volume = example_both(2);
    volume.states.back() = ProbeState::absent;
    EXPECT_MENTIONS(complaint(volume), "probe 1: absent");
    volume = example();
    volume.settings["a=b"] = "c";
    EXPECT_MENTIONS(complaint(volume), "equals sign");
    volume = with_layers(example());
    EXPECT_EQ(complaint(volume), "nothing");
    volume.layers[1].coefficients.pop_back();
    EXPECT_MENTIONS(complaint(volume), "layer \"sky.0\": ");
    volume = with_layers(example());
    volume.layers[0].coefficients[3].b = std::numeric_limits<float>::infinity();
    EXPECT_MENTIONS(complaint(volume), "layer \"lamps\" 3, component 2, is inf");
    for (const char* name : {"", "sky.0", "combined", "index", "validity"}) {
        volume = with_layers(example());
        volume.layers[0].name = name;
        EXPECT_MENTIONS(complaint(volume), "name");
    }
    volume = with_layers(example());
    volume.layers[0].noise = -1;
    EXPECT_MENTIONS(complaint(volume), "noise -1");
}

TEST(Volume, TakesLayersAlong) {
    Volume volume = with_layers(example());
    volume.list = {glm::dvec3(7)};
    const auto add_row = [&](std::vector<glm::vec3>& values, std::size_t per_slot) {
        values.insert(values.end(), per_slot, glm::vec3(9));
    };
    volume.states.push_back(ProbeState::valid);
    add_row(volume.coefficients, 9);
    add_row(volume.errors, 9);
    add_row(volume.axis_errors, 6);
    add_row(volume.offsets, 1);
    for (Layer& layer : volume.layers) add_row(layer.coefficients, 9);
    Volume more =
        make_volume({volume.grids[0], volume.grids[1], {{0, 0, 0}, {1, 1, 1}, {4, 4, 4}}}, {{2, {0, 0, 0}}}, 3);
    for (const Layer& layer : volume.layers) more.layers.push_back({layer.name, {}, 0});
    set_bands(more, 3);
    more.layers[1].coefficients[0] = glm::vec3(5);
    append(volume, more);
    check_volume(volume);
    for (const Layer& layer : volume.layers) EXPECT_EQ(layer.coefficients.back(), glm::vec3(9));
    EXPECT_EQ(volume.layers[1].coefficients[(volume.bricks.size() - 1) * probes_per_brick * 9], glm::vec3(5));
}

TEST(Volume, MixesLayersColourByColour) {
    const Volume volume = with_layers(example());
    const std::array<glm::vec3, 2> weights{glm::vec3(2, 0, 1), glm::vec3(0.5F, 1, -1)};
    const std::vector<glm::vec3> sum = mix_layers(volume, weights);
    ASSERT_EQ(sum.size(), volume.coefficients.size());
    for (const std::size_t i : {std::size_t{0}, std::size_t{5}, sum.size() - 1}) {
        EXPECT_EQ(sum[i].r, 2 * volume.layers[0].coefficients[i].r + 0.5F * volume.layers[1].coefficients[i].r);
        EXPECT_EQ(sum[i].g, volume.layers[1].coefficients[i].g);
        EXPECT_EQ(sum[i].b, volume.layers[0].coefficients[i].b - volume.layers[1].coefficients[i].b);
    }
    EXPECT_EQ(find_layer(volume, "sky.0"), 1U);
    EXPECT_FALSE(find_layer(volume, "sky"));
}

TEST(Volume, RefusesAGridTooLargeBeforeAllocatingIt) {
    const int huge = std::numeric_limits<int>::max();
    EXPECT_THROW(static_cast<void>(make_volume({{{0, 0, 0}, {1, 1, 1}, {huge, huge, huge}}}, 3)), Error);
    EXPECT_THROW(static_cast<void>(make_volume({{{0, 0, 0}, {1, 1, 1}, {2, 0, 2}}}, 3)), Error);
    EXPECT_THROW(static_cast<void>(make_volume({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}, 52)), Error);
}

// ---- Its file

TEST(VolumeFile, ReturnsEveryBitThatWasSaved) {
    for (const int bands : {1, 3, 5, 8}) {
        const Volume volume = example(bands);
        expect_same(reread(encode_volume(volume)), volume);
    }
}

TEST(VolumeFile, ReturnsProbeListsInTheirOrderWithExactPositions) {
    for (const std::size_t count : {1, 63, 64, 65, 1000}) {
        const Volume volume = example_list(count);
        expect_same(reread(encode_volume(volume)), volume);
    }
}

TEST(VolumeFile, ReturnsSingleProbesBesideGrids) {
    for (const std::size_t count : {1U, 64U, 100U}) {
        Volume volume = example_both(count);
        expect_same(reread(encode_volume(volume)), volume);
        for (std::size_t row = 0; row < count; ++row) {
            EXPECT_EQ(gather_position(volume, volume.list_start() + row), volume.list[row]);
        }
        store_as_half(volume);
        expect_same(reread(encode_volume(volume)), volume);
    }
}

TEST(VolumeFile, ReturnsLayers) {
    for (const Volume& volume : {with_layers(example()), with_layers(example_list()), with_layers(example(2))}) {
        expect_same(reread(encode_volume(volume)), volume);
        Volume half = volume;
        store_as_half(half);
        EXPECT_FALSE(same_bits(half.layers[1].coefficients, volume.layers[1].coefficients));
        expect_same(reread(encode_volume(half)), half);
    }
    // A layer costs what is in it.
    const Volume volume = with_layers(example(4));
    EXPECT_EQ(stored_bytes(volume, volume.layers[0].coefficients), volume.slots() * 4 * 4);
    EXPECT_EQ(stored_bytes(volume, volume.layers[1].coefficients), volume.slots() * 16 * 3 * 4);
}

TEST(VolumeFile, NamesALayerThatIsMissingOrDamaged) {
    const std::string whole = encode_volume(with_layers(example()));
    // The list of layers is the one place where a name stands behind its length.
    std::string listed = whole;
    const std::string entry("\5\0\0\0lamps", 9);
    const std::size_t at = listed.find(entry, listed.find("lightgrid.layers"));
    ASSERT_NE(at, std::string::npos);
    listed.replace(at + 4, 5, "lumps");
    EXPECT_MENTIONS(complaint(listed), "has no part \"lumps\"");
    listed.replace(at + 4, 5, "sky.0");
    EXPECT_MENTIONS(complaint(listed), "layer \"sky.0\" is listed twice");
    listed.replace(at + 4, 5, "index");
    EXPECT_MENTIONS(complaint(listed), "part \"index\"");
    std::string silent = whole;
    silent.replace(silent.find("lightgrid.noise"), 15, "lightgrid.moise");
    EXPECT_MENTIONS(complaint(silent), "part \"lamps\": attribute \"lightgrid.noise\" is missing");
}

TEST(VolumeFile, HasTheSameBytesForTheSameVolume) {
    EXPECT_EQ(encode_volume(example()), encode_volume(example()));
}

TEST(VolumeFile, PutsBackColourAndBandsAndErrorsThatItLeftOut) {
    Volume volume = example(4);
    for (glm::vec3& v : volume.coefficients) v = glm::vec3(v.r);
    for (std::size_t i = 0; i < volume.coefficients.size(); ++i) {
        if (i % 16 >= 4) volume.coefficients[i] = glm::vec3(0);
    }
    for (auto* values : {&volume.errors, &volume.axis_errors, &volume.offsets}) {
        std::fill(values->begin(), values->end(), glm::vec3(0));
    }
    const std::string lean = encode_volume(volume);
    for (const char* channel : {"c0.R", "c4.Y", "combined.error", "offset.x"}) {
        EXPECT_EQ(lean.find(channel), std::string::npos) << channel;
    }
    EXPECT_NE(lean.find("c3.Y"), std::string::npos);
    EXPECT_LT(lean.size(), encode_volume(example(4)).size() / 8);
    volume.offsets.clear();
    expect_same(reread(lean), volume);
}

TEST(VolumeFile, HoldsADarkVolume) {
    const Volume volume = make_volume({{{0, 0, 0}, {1, 1, 1}, {1, 1, 1}}}, 3);
    expect_same(reread(encode_volume(volume)), volume);
}

TEST(VolumeFile, SaysWhatIsNoVolume) {
    EXPECT_EQ(complaint(std::string()), "test.exr: is empty. Give a volume that level-bake wrote (*.probes.exr).");
    EXPECT_MENTIONS(complaint(std::string("x,y,z\n1,2,3\n")), "is not an OpenEXR file");
    const fs::path stock = fs::path(LIGHTGRID_SHARED) / "data/exr-magnum-tiny/rgba32f.exr";
    if (!fs::exists(stock)) GTEST_SKIP() << stock << " is not here";
    EXPECT_MENTIONS(complaint(read_whole_file(stock)), "is an OpenEXR image but not a probe volume");
}

TEST(VolumeFile, RefusesALaterFormatByItsNumber) {
    std::string bytes = encode_volume(example());
    const std::string attribute = std::string("lightgrid.format\0int\0\4\0\0\0", 25);
    const std::size_t at = bytes.find(attribute);
    ASSERT_NE(at, std::string::npos);
    bytes[at + attribute.size()] = 7;
    EXPECT_MENTIONS(complaint(bytes), "is a probe volume of format 7, but this program reads format 1");
}

TEST(VolumeFile, NamesAMissingFile) {
    try {
        static_cast<void>(load_volume("/nowhere/hall.probes.exr"));
        FAIL();
    } catch (const Error& error) {
        EXPECT_STREQ(error.what(), "/nowhere/hall.probes.exr: cannot be read: No such file or directory");
        EXPECT_EQ(error.fault(), Fault::input);
    }
}

TEST(VolumeFile, ReplacesAnOldFileAndLeavesNothingBeside) {
    const Folder folder;
    std::ofstream(folder / "a.exr") << "old";
    fs::create_symlink(folder / "a.exr", folder / "link.exr");
    save_volume(example(), folder / "link.exr");
    EXPECT_TRUE(fs::is_symlink(folder / "link.exr"));
    expect_same(load_volume(folder / "a.exr"), example());
    EXPECT_EQ(folder.files(), 2U);
}

TEST(VolumeFile, BlamesTheDiskAndKeepsTheOldFile) {
    const Folder folder;
    const auto fault_of = [&](const fs::path& path) {
        try {
            save_volume(example(), path);
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos) << error.what();
            return error.fault();
        }
        return Fault::input;
    };
    std::ofstream(folder / "a.exr") << "old";
    EXPECT_EQ(fault_of("/dev/full"), Fault::work);
    EXPECT_EQ(fault_of(folder / "none/b.exr"), Fault::work);
    EXPECT_EQ(fault_of(folder / "a.exr/b.exr"), Fault::work);
    EXPECT_EQ(fault_of(folder / ""), Fault::work);

    rlimit old_limit{};
    getrlimit(RLIMIT_FSIZE, &old_limit);
    const rlimit small{4096, old_limit.rlim_max};
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    EXPECT_EQ(fault_of(folder / "a.exr"), Fault::work);
    setrlimit(RLIMIT_FSIZE, &old_limit);
    std::signal(SIGXFSZ, old_handler);

    EXPECT_EQ(read_whole_file(folder / "a.exr"), "old");
    EXPECT_EQ(folder.files(), 1U);
}

TEST(VolumeFile, WritesToADeviceWithoutReplacingIt) {
    save_volume(example(), "/dev/null");
    EXPECT_FALSE(fs::is_regular_file("/dev/null"));
}

// ---- Half storage

TEST(HalfStorage, KeepsElevenBitsOverTheWholeRangeOfFloat) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> mantissa(1, 2);
    for (int exponent = -100; exponent <= 126; ++exponent) {
        std::vector<glm::vec3> brick(64);
        for (std::size_t i = 0; i < brick.size(); ++i) {
            // The brick spans 2^20: all of it is normal.
            brick[i] = glm::vec3(std::ldexp(mantissa(random), exponent - static_cast<int>(i % 20)));
        }
        const float scale = half_scale(brick);
        for (const glm::vec3& v : brick) {
            const float stored = from_half(to_half(v.r, scale), scale);
            EXPECT_LE(std::abs(stored - v.r), std::ldexp(v.r, -11)) << v.r << " at scale " << scale;
        }
    }
}

TEST(HalfStorage, FlushesNothingThatMattersInItsBrick) {
    const float scale = half_scale(std::vector{glm::vec3(1e6F, 0, -3e-6F)});
    EXPECT_LE(std::abs(from_half(to_half(-3e-6F, scale), scale) + 3e-6F), std::ldexp(scale, -25));
    EXPECT_NE(to_half(1e-3F, scale), 0);
    EXPECT_EQ(half_scale(std::vector{glm::vec3(0)}), 1);
    EXPECT_GE(half_scale(std::vector{glm::vec3(1e-45F)}), std::numeric_limits<float>::min());
}

TEST(HalfStorage, ServesOnlyWhereItIsATenthOfTheNoise) {
    Volume volume = example();
    const StorageChoice noisy = choose_storage(volume);
    EXPECT_TRUE(noisy.half);
    EXPECT_LE(noisy.worst_share, 0.1);
    EXPECT_GT(noisy.irradiance_rms, 0);
    for (glm::vec3& error : volume.errors) error *= 1e-3F;  // 2e-5 of the light, below 2^-12
    EXPECT_FALSE(choose_storage(volume).half);
    std::fill(volume.errors.begin(), volume.errors.end(), glm::vec3(0));
    EXPECT_FALSE(choose_storage(volume).half);
    EXPECT_TRUE(std::isinf(choose_storage(volume).worst_share));
}

TEST(HalfStorage, IsFloatIfOneBrickHasNoNoise) {
    Volume volume = example();
    std::fill_n(volume.errors.begin(), probes_per_brick * volume.sh_size(), glm::vec3(0));
    EXPECT_FALSE(choose_storage(volume).half);
}

TEST(HalfStorage, ReportsTheIrradianceThatItChanges) {
    const Volume exact = example();
    Volume stored = exact;
    store_as_half(stored);
    // Over many normals, against the closed form over all of them.
    double sum = 0;
    std::size_t count = 0;
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    for (std::size_t slot = 0; slot < exact.slots(); ++slot) {
        if (!is_valid(exact.states[slot])) continue;
        for (int i = 0; i < 400; ++i) {
            const glm::vec3 n(glm::normalize(glm::dvec3(normal(random), normal(random), normal(random))));
            std::vector<glm::vec3> change(exact.sh_size());
            for (std::size_t k = 0; k < change.size(); ++k) change[k] = stored.sh(slot)[k] - exact.sh(slot)[k];
            const glm::dvec3 e(irradiance_from_sh(change, n));
            sum += glm::dot(e, e);
            count += 3;
        }
    }
    // 1e5 normals: a percent is ten standard errors of the mean square.
    EXPECT_NEAR(std::sqrt(sum / count) / choose_storage(exact).irradiance_rms, 1, 0.01);
}

TEST(HalfStorage, AddsWhatItChangedToTheErrors) {
    const Volume exact = example();
    Volume stored = exact;
    store_as_half(stored);
    EXPECT_TRUE(stored.half);
    for (std::size_t i = 0; i < exact.errors.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            const float change = stored.coefficients[i][c] - exact.coefficients[i][c];
            const float wanted = std::hypot(exact.errors[i][c], change);
            EXPECT_NEAR(stored.errors[i][c], wanted, std::ldexp(wanted, -10));  // it is itself rounded to half
        }
    }
}

TEST(HalfStorage, ReturnsEveryBitThatItRoundedBefore) {
    Volume volume = example();
    store_as_half(volume);
    const std::string bytes = encode_volume(volume);
    expect_same(reread(bytes), volume);
    EXPECT_LT(bytes.size(), 0.6 * encode_volume(example()).size());
    EXPECT_EQ(encode_volume(reread(bytes)), bytes);
}

TEST(HalfStorage, IsExactOnWhatRoundsUpToAPowerOfTwo) {
    Volume volume = make_volume({{{0, 0, 0}, {1, 1, 1}, {2, 1, 1}}}, 1);
    volume.coefficients[0] = glm::vec3(0.99999F, 1e-7F, 3e-8F);
    store_as_half(volume);
    EXPECT_EQ(volume.coefficients[0].r, 1);
    const Volume once = volume;
    store_as_half(volume);
    EXPECT_TRUE(same_bits(volume.coefficients, once.coefficients));
    EXPECT_TRUE(same_bits(reread(encode_volume(volume)).coefficients, once.coefficients));
}

}  // namespace
}  // namespace lightgrid
