// bench_load_level LEVEL [IMAGE...]
//
// From the file to a level that can be traced, beside what no loader can do without: decoding the images that the
// level's materials read (to be named) and Embree's own commit, all on all threads. Medians of alternating rounds, and
// their ratio.

#include "core/error.h"
#include "core/gltf.h"
#include "core/image.h"
#include "core/parallel.h"
#include "core/tracer.h"
#include "core/whole_file.h"
#include "tests/bench/raw_scene.h"
#include "tests/bench/measure.h"

#include <fmt/format.h>

#include <span>
#include <string>
#include <vector>

namespace lightgrid {
namespace {

constexpr int rounds = 7;

int run(int argc, char** argv) {
    if (argc < 2) throw Error("no LEVEL given", "bench_load_level");
    const std::vector<std::string> images(argv + 2, argv + argc);
    const Scene scene = load_level(argv[1]);
    std::vector<double> load;
    std::vector<double> decode;
    std::vector<double> commit;
    for (int round = 0; round < rounds; ++round) {
        load.push_back(seconds_of([&] {
            const Scene loaded = load_level(argv[1]);
            const Tracer tracer(loaded);
        }).wall);
        decode.push_back(seconds_of([&] {
            for_each_index(images.size(), [&](std::size_t i) {
                const std::string bytes = read_whole_file(images[i]);
                static_cast<void>(decode_image(std::as_bytes(std::span(bytes)), images[i]));
            });
        }).wall);
        commit.push_back(seconds_of([&] { const RawScene raw(scene); }).wall);
    }
    const double whole = spread(load).median;
    const double least = spread(decode).median + spread(commit).median;
    fmt::print("{}: {} threads, {} rounds\n", scene.name, thread_count(), rounds);
    fmt::print("load and build              {:7.1f} ms ({:.1f} to {:.1f})\n", 1e3 * whole, 1e3 * spread(load).least,
               1e3 * spread(load).most);
    fmt::print("decode {:2} images            {:7.1f} ms\n", images.size(), 1e3 * spread(decode).median);
    fmt::print("Embree's commit             {:7.1f} ms\n", 1e3 * spread(commit).median);
    fmt::print("ratio                       {:7.2f}\n", whole / least);
    return 0;
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    try {
        return lightgrid::run(argc, argv);
    } catch (const lightgrid::Error& error) {
        fmt::print(stderr, "bench_load_level: {}\n", error.what());
        return static_cast<int>(error.fault());
    }
}
