// What another baking tool does: uses the libraries behind level-bake.

#include "core/error.h"
#include "core/gltf.h"
#include "probes/bake.h"
#include "probes/grid_choice.h"

#include <cstdio>

int main() {
    lightgrid::Scene scene;
    scene.bounds.extend({0, 0, 0});
    scene.bounds.extend({4, 3, 2});
    lightgrid::PlacementOptions options;
    options.spacing = 1;
    const glm::ivec3 counts = lightgrid::choose_grids(scene, options).grids.at(0).counts;
    std::printf("%d x %d x %d probes\n", counts.x, counts.y, counts.z);
    try {
        static_cast<void>(lightgrid::load_level("nowhere.glb"));
    } catch (const lightgrid::Error& error) {
        std::printf("%s\n", error.what());
        return counts == glm::ivec3(5, 4, 3) ? 0 : 1;
    }
    return 1;
}
