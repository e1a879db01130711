#include "viewer/outlines.h"

#include "core/parallel.h"
#include "core/sampling.h"

#include <algorithm>

namespace lightgrid {
namespace {

constexpr std::size_t most_eyes = 512;
constexpr std::uint32_t rays_per_eye = 256;
constexpr double close = 0.01;          // of the level's diagonal
constexpr double nearly_always = 0.85;  // 0.93 in a level that has them; 0.3 is the most of all other materials seen
constexpr std::size_t least_seen = 32;  // rays; fewer prove nothing

struct Seen {
    int material;
    bool shell;  // from behind, and close behind it the front of something else
};

}  // namespace

std::vector<bool> find_outlines(const Tracer& tracer, const Volume& volume) {
    const Scene& scene = tracer.scene();
    std::vector<bool> outlines(scene.materials.size(), false);
    const auto is_candidate = [&](int material) {
        const Material& m = scene.materials[static_cast<std::size_t>(material)];
        return !m.double_sided && !m.passes_light();
    };
    const auto reach = static_cast<float>(close * glm::length(scene.bounds.size()));

    std::vector<std::size_t> eyes;
    for (std::size_t slot = 0; slot < volume.list_start(); ++slot) {
        if (is_valid(volume.states[slot])) eyes.push_back(slot);
    }
    const std::size_t stride = std::max<std::size_t>(1, eyes.size() / most_eyes);
    const std::vector<glm::vec3> directions = even_directions(rays_per_eye);
    std::vector<std::vector<Seen>> seen(eyes.size() / stride);
    for_each_index(seen.size(), [&](std::size_t i) {
        const glm::vec3 eye(gather_position(volume, eyes[i * stride]) - scene.origin);
        for (const glm::vec3& direction : directions) {
            const Hit hit = tracer.closest_hit(eye, direction);
            if (!hit.found()) continue;
            const int material = tracer.mesh(hit.id).material;
            if (!is_candidate(material)) continue;
            const Surface surface = tracer.surface(hit, direction);
            bool shell = false;
            if (!surface.front) {
                const Hit behind = tracer.closest_hit(surface.leave(direction), direction, reach);
                shell = behind.found() && tracer.mesh(behind.id).material != material &&
                        tracer.surface(behind, direction).front;
            }
            seen[i].push_back({material, shell});
        }
    });

    std::vector<std::size_t> all(outlines.size(), 0);
    std::vector<std::size_t> shells(outlines.size(), 0);
    for (const std::vector<Seen>& from_eye : seen) {
        for (const Seen& s : from_eye) {
            ++all[static_cast<std::size_t>(s.material)];
            shells[static_cast<std::size_t>(s.material)] += s.shell ? 1 : 0;
        }
    }
    for (std::size_t m = 0; m < outlines.size(); ++m) {
        outlines[m] =
            all[m] >= least_seen && static_cast<double>(shells[m]) >= nearly_always * static_cast<double>(all[m]);
    }
    return outlines;
}

}  // namespace lightgrid
