// bench_memory LEVEL ...
//
// Memory of a level once it is loaded, besides textures and what Embree takes for the same triangles by itself, as a
// share of 32 bytes a vertex and 16 a triangle; and all memory at the worst moment on the way.
//
// Method: malloc and its kin are replaced by ones that count the usable bytes of every live block in the process, those
// of libraries included. What is mapped without malloc (Embree's larger blocks) is not counted on either side; files
// are read, not mapped.

#include "core/error.h"
#include "core/gltf.h"
#include "core/tracer.h"
#include "probes/paths.h"
#include "tests/bench/raw_scene.h"
#include "tools/program.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <malloc.h>
#include <memory>

namespace {

std::atomic<std::ptrdiff_t> live_bytes{0};
std::atomic<std::ptrdiff_t> most_bytes{0};

void* counted(void* block) {
    if (block == nullptr) return nullptr;
    const std::ptrdiff_t live = live_bytes += static_cast<std::ptrdiff_t>(malloc_usable_size(block));
    std::ptrdiff_t most = most_bytes;
    while (live > most && !most_bytes.compare_exchange_weak(most, live)) {
    }
    return block;
}

void uncount(void* block) {
    if (block != nullptr) live_bytes -= static_cast<std::ptrdiff_t>(malloc_usable_size(block));
}

}  // namespace

// glibc's own allocator under other names: a program may define these functions for itself and all its libraries.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* block);

void* malloc(std::size_t size) {
    return counted(__libc_malloc(size));
}
void* calloc(std::size_t count, std::size_t size) {
    return counted(__libc_calloc(count, size));
}
void* realloc(void* block, std::size_t size) {
    uncount(block);
    return counted(__libc_realloc(block, size));
}
void* memalign(std::size_t alignment, std::size_t size) {
    return counted(__libc_memalign(alignment, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
    return counted(__libc_memalign(alignment, size));
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
    *block = counted(__libc_memalign(alignment, size));
    return *block == nullptr ? ENOMEM : 0;
}
void free(void* block) {
    uncount(block);
    __libc_free(block);
}
}

namespace lightgrid {
namespace {

/// What was live when a part began, then what it left and the most that it held.
class Part {
  public:
    Part() { most_bytes = before_; }
    [[nodiscard]] double kept() const { return static_cast<double>(live_bytes - before_); }
    [[nodiscard]] double most() const { return static_cast<double>(most_bytes - before_); }

  private:
    std::ptrdiff_t before_ = live_bytes;
};

void measure(const char* path) {
    { const Scene warm_up = load_level(path); }
    const Part whole;
    const Scene scene = load_level(path);
    const double loaded = whole.kept();
    const double while_loading = whole.most();

    double vertices = 0;
    double triangles = 0;
    for (const Mesh& mesh : scene.meshes) {
        vertices += static_cast<double>(mesh.positions.size());
        triangles += static_cast<double>(mesh.triangles.size());
    }
    double textures = 0;
    for (const Texture& texture : scene.textures)
        textures += static_cast<double>(texture.image.pixels.size() * sizeof(glm::u8vec4));

    double raw = 0;
    double raw_most = 0;
    {
        const Part part;
        const RawScene embree(scene);
        raw = part.kept();
        raw_most = part.most();
    }
    const Part building;
    const Tracer tracer(scene);
    const double built = building.kept();
    const double while_building = building.most();
    const Part preparing;
    const Environment black;
    const PathTracer paths(tracer, black);
    const double prepared = preparing.kept();

    const double allowed = 32 * vertices + 16 * triangles;
    const double kept = loaded - textures + (built - raw) + prepared;
    const auto megabytes = [](double bytes) { return fmt::format("{:.2f} MB", 1e-6 * bytes); };
    fmt::print("{}: {:.0f} vertices, {:.0f} triangles, {} emitters\n", path, vertices, triangles,
               paths.emitters().size());
    fmt::print("  kept     scene {}, tracer {}, emitters {}: {:.0f} % of the {} allowed\n",
               megabytes(loaded - textures), megabytes(built - raw), megabytes(prepared), 100 * kept / allowed,
               megabytes(allowed));
    fmt::print("  besides  textures {}, Embree {}\n", megabytes(textures), megabytes(raw));
    fmt::print("  at most  {} while loading, {} while building, where Embree alone has {} besides scene and textures\n",
               megabytes(while_loading), megabytes(loaded + while_building), megabytes(raw_most));
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    return lightgrid::run_program("bench_memory", [&] {
        for (int i = 1; i < argc; ++i) lightgrid::measure(argv[i]);
        return 0;
    });
}
