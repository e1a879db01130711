#include "scenes/levels.h"

#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

int main(int argc, char** argv) {
    using namespace lightgrid::scenes;
    if (argc != 2 || std::string(argv[1]).starts_with("-")) {
        std::fputs("usage: make_scenes FOLDER\nWrites the regression levels and the default level into FOLDER.\n",
                   stderr);
        return 2;
    }
    try {
        const std::filesystem::path folder = argv[1];
        std::filesystem::create_directories(folder);
        cornell().write(folder / "cornell.glb");
        thin_wall().write(folder / "thin_wall.glb");
        door_ajar().write(folder / "door_ajar.glb");
        courtyard().write(folder / "courtyard.glb");
        inn(true).write(folder / "inn.glb");
        inn(false).write(folder / "inn_without_lamps.glb");
        default_level().write(folder / "default.glb");
        furnace(0.5F).write(folder / "furnace_50.glb");
        furnace(0.9F).write(folder / "furnace_90.glb");
        furnace(0.99F).write(folder / "furnace_99.glb");
        ground().write(folder / "ground.glb");
        occluder().write(folder / "occluder.glb");
        point_light().write(folder / "point_light.glb");
        spot_light().write(folder / "spot_light.glb");
        emitter_rect().write(folder / "emitter_rect.glb");
        blend_cover().write(folder / "blend_cover.glb");
        glass_cover().write(folder / "glass_cover.glb");
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "make_scenes: %s\n", error.what());
        return 1;
    }
}
