// bench_load_level LEVEL
//
// Loading a level (load_level, then the tracer) beside the least that loading can be: reading and decoding the images
// that light paths need, and Embree's build of the same triangles; both on all threads, in alternating rounds.

#include "core/error.h"
#include "core/gltf.h"
#include "core/image.h"
#include "core/parallel.h"
#include "core/tracer.h"
#include "core/whole_file.h"
#include "tests/bench/measure.h"
#include "tests/bench/raw_scene.h"
#include "tools/program.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <regex>
#include <set>
#include <vector>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int rounds = 9;

/// The image files that base colour, emission and transmission name.
std::vector<fs::path> needed_images(const fs::path& level) {
    std::string file = read_whole_file(level);
    if (file.starts_with("glTF")) {
        std::uint32_t size = 0;  // of the JSON chunk
        std::memcpy(&size, file.data() + 12, sizeof(size));
        file = file.substr(20, size);
    }
    const json document = json::parse(file);
    std::set<fs::path> files;
    for (const json& material : document.value("materials", json::array())) {
        for (const char* use : {"/pbrMetallicRoughness/baseColorTexture/index", "/emissiveTexture/index",
                                "/extensions/KHR_materials_transmission/transmissionTexture/index"}) {
            const json::json_pointer pointer(use);
            if (!material.contains(pointer)) continue;
            const json& texture = document["textures"][material[pointer].get<std::size_t>()];
            const json& image = document["images"][texture["source"].get<std::size_t>()];
            if (!image.contains("uri")) throw Error("has images within buffers: measure another level", level.string());
            const std::string name = std::regex_replace(image["uri"].get<std::string>(), std::regex("%20"), " ");
            files.insert(level.parent_path() / name);
        }
    }
    return {files.begin(), files.end()};
}

std::size_t pixels_of(const Scene& scene) {
    std::size_t count = 0;
    for (const Texture& texture : scene.textures) count += texture.image.pixels.size();
    return count;
}

struct Column {
    std::vector<double> wall, processor;

    void add(Seconds seconds) {
        wall.push_back(seconds.wall);
        processor.push_back(seconds.processor);
    }
    void print(const char* name) const {
        const Spread w = spread(wall);
        const Spread p = spread(processor);
        fmt::print("{:24} {:7.1f} ms ({:.1f} to {:.1f}), {:7.1f} ms of processor time ({:.1f} to {:.1f})\n", name,
                   1e3 * w.median, 1e3 * w.least, 1e3 * w.most, 1e3 * p.median, 1e3 * p.least, 1e3 * p.most);
    }
};

int run(int argc, char** argv) {
    if (argc != 2) throw Error("call it with LEVEL");
    const fs::path level = argv[1];
    const std::vector<fs::path> files = needed_images(level);
    Column load, build, decode, commit;
    std::vector<double> wall_ratio, processor_ratio;
    std::size_t triangles = 0;
    std::size_t our_pixels = 0;
    std::vector<std::size_t> pixels(files.size());
    for (int round = 0; round <= rounds; ++round) {
        std::optional<Scene> scene;
        const Seconds loading = seconds_of([&] { scene = load_level(level); });
        const Seconds building = seconds_of([&] { triangles = Tracer(*scene).triangle_count(); });
        const Seconds decoding = seconds_of([&] {
            std::vector<ByteImage> images(files.size());
            for_each_index(files.size(), [&](std::size_t i) {
                const std::string bytes = read_whole_file(files[i]);
                images[i] = decode_image(std::as_bytes(std::span(bytes)), files[i].string());
            });
            for (std::size_t i = 0; i < files.size(); ++i) pixels[i] = images[i].pixels.size();
        });
        const Seconds committing = seconds_of([&] { const RawScene raw(*scene); });
        our_pixels = pixels_of(*scene);
        if (round == 0) continue;  // warm-up
        load.add(loading);
        build.add(building);
        decode.add(decoding);
        commit.add(committing);
        wall_ratio.push_back((loading.wall + building.wall) / (decoding.wall + committing.wall));
        processor_ratio.push_back((loading.processor + building.processor) /
                                  (decoding.processor + committing.processor));
    }
    std::size_t all_pixels = 0;
    for (const std::size_t count : pixels) all_pixels += count;
    fmt::print("{}: {} triangles, {} images of {:.1f} million pixels ({:.1f} kept), {} threads, {} rounds\n",
               level.filename().string(), triangles, files.size(), 1e-6 * static_cast<double>(all_pixels),
               1e-6 * static_cast<double>(our_pixels), thread_count(), rounds);
    load.print("load_level");
    build.print("tracer");
    decode.print("decoding images alone");
    commit.print("Embree's build alone");
    const Spread w = spread(wall_ratio);
    const Spread p = spread(processor_ratio);
    fmt::print("ratio                    {:7.2f} ({:.2f} to {:.2f}), {:.2f} by processor time ({:.2f} to {:.2f})\n",
               w.median, w.least, w.most, p.median, p.least, p.most);
    return 0;
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    return lightgrid::run_program("bench_load_level", [&] { return lightgrid::run(argc, argv); });
}
