#include "core/error.h"
#include "core/whole_file.h"
#include "probes/half_storage.h"
#include "probes/volume_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

namespace lightgrid {
namespace {

// A small file of each kind: every byte of it is met.
struct Kind {
    const char* name;
    Volume volume;
};

// Numbers of a kind that compresses: then a changed byte breaks its block's checksum instead of passing as other light.
void fill(Volume& volume) {
    for (auto* values : {&volume.coefficients, &volume.errors, &volume.axis_errors}) {
        for (std::size_t i = 0; i < values->size(); ++i) (*values)[i] = glm::vec3(i % 4, 1, 0.5F);
    }
    volume.settings = {{"level", "hall.glb"}, {"seed", "1"}};
}

std::vector<Kind> kinds() {
    Volume grid = make_volume({{{1, 2, 3}, {0.5, 0.5, 0.5}, {5, 3, 2}}}, 2);
    fill(grid);
    grid.offsets.assign(grid.slots(), glm::vec3(0.125F));
    Volume half = make_volume({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, {{0, 0, 0}, {2, 2, 2}, {2, 2, 2}}}, 2);
    fill(half);
    store_as_half(half);
    Volume list = make_probe_list({{0.1, 0.2, 0.3}, {1e5, -1e5, 0}, {0, 0, 0}}, 1);
    fill(list);
    Volume both = make_volume({{{0, 0, 0}, {1, 1, 1}, {2, 3, 2}}}, 1, {{0.1, 0.2, 0.3}, {1e5, -1e5, 0}});
    fill(both);
    Volume layers = half;
    layers.layers = {{"a", half.coefficients, 0.5}, {"b", half.coefficients, 0}};
    return {{"grid", grid}, {"half", half}, {"list", list}, {"both", both}, {"layers", layers}};
}

enum class Outcome { refused, accepted };

// Either a volume that keeps its promises or an Error that names the file; anything else ends the program.
Outcome read(const std::string& bytes) {
    // From an allocation of just this size, so that an address sanitizer sees reads beyond it.
    const std::vector<std::byte> exact(reinterpret_cast<const std::byte*>(bytes.data()),
                                       reinterpret_cast<const std::byte*>(bytes.data()) + bytes.size());
    try {
        check_volume(decode_volume(exact, "fuzz.exr"));
        return Outcome::accepted;
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).rfind("fuzz.exr: ", 0), 0U) << error.what();
        return Outcome::refused;
    }
}

TEST(VolumeFileFuzz, RefusesEveryPrefix) {
    for (const Kind& kind : kinds()) {
        const std::string whole = encode_volume(kind.volume);
        ASSERT_EQ(read(whole), Outcome::accepted);
        for (std::size_t size = 0; size < whole.size(); ++size) {
            ASSERT_EQ(read(whole.substr(0, size)), Outcome::refused) << kind.name << " of " << size << " bytes";
        }
    }
}

TEST(VolumeFileFuzz, SurvivesEveryAlteredByte) {
    for (const Kind& kind : kinds()) {
        const std::string whole = encode_volume(kind.volume);
        std::size_t refused = 0;
        for (std::size_t at = 0; at < whole.size(); ++at) {
            for (const int flip : {0x01, 0x80}) {
                std::string altered = whole;
                altered[at] = static_cast<char>(altered[at] ^ flip);
                refused += read(altered) == Outcome::refused;
            }
        }
        // A third of all bytes is text that nobody reads and the last digits of places; the rest is seen.
        EXPECT_GT(refused, whole.size()) << kind.name << " has " << whole.size() << " bytes";
    }
}

TEST(VolumeFileFuzz, SurvivesManyAlterationsAtOnce) {
    std::mt19937 random(2);
    for (const Kind& kind : kinds()) {
        const std::string whole = encode_volume(kind.volume);
        for (int round = 0; round < 2000; ++round) {
            std::string altered = whole;
            for (int i = 0; i < 1 + round % 20; ++i) altered[random() % altered.size()] = static_cast<char>(random());
            if (round % 3 == 0) altered.resize(random() % altered.size());
            read(altered);
        }
    }
}

TEST(VolumeFileFuzz, RefusesOrdinaryImages) {
    namespace fs = std::filesystem;
    const fs::path folder = fs::path(LIGHTGRID_SHARED) / "data/exr-magnum-tiny";
    if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not here";
    std::size_t images = 0;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        if (entry.path().extension() != ".exr") continue;
        ++images;
        EXPECT_EQ(read(read_whole_file(entry.path())), Outcome::refused) << entry.path();
    }
    EXPECT_GT(images, 0U);
}

}  // namespace
}  // namespace lightgrid
