#include "scenes/levels.h"
#include "scenes/shapes.h"

#include <glm/gtc/constants.hpp>

namespace lightgrid::scenes {
namespace {

constexpr float half_side = 10;  // of the square sheets, m

/// A square sheet of 20 m x 20 m around the Y axis whose front looks up.
void add_sheet(Shape& shape, int material, float height, float half = half_side) {
    add_quad(shape, material, {-half, height, half}, {2 * half, 0, 0}, {0, 0, -2 * half});
}

/// The sun of `ground` and `occluder`: 3 lx, travelling down, 30 degrees from the vertical towards -X.
void place_sun(Glb& glb) {
    const glm::quat down = glm::angleAxis(-glm::half_pi<float>(), glm::vec3(1, 0, 0));
    const glm::quat tilt = glm::angleAxis(-glm::pi<float>() / 6, glm::vec3(0, 0, 1));
    glb.place_light({.name = "sun", .type = "directional", .intensity = 3}, {.rotation = tilt * down});
}

Glb sheet_under_sky(const Material& cover) {
    Glb glb;
    Shape shape;
    add_sheet(shape, glb.add_material(cover), 3);
    glb.place(glb.add_mesh(shape, "cover"), "cover");
    return glb;
}

}  // namespace

Glb furnace(float albedo) {
    Glb glb;
    const int wall = glb.add_material({.name = "glowing", .color = glm::vec3(albedo), .emission = glm::vec3(1)});
    Blocks room({wall, wall, wall});
    room.fill({-1.1F, -0.1F, -1.6F}, {1.1F, 2.6F, 1.6F});
    room.carve({-1, 0, -1.5F}, {1, 2.5F, 1.5F}, {wall, wall, wall});
    Shape shape;
    room.add_to(shape);
    glb.place(glb.add_mesh(shape, "room"), "room");
    Shape block;
    add_box(block, wall, {-0.3F, 0, -0.2F}, {0.3F, 0.8F, 0.2F});
    glb.place(glb.add_mesh(block, "block"), "block",
              {{0.35F, 0, -0.5F}, glm::angleAxis(0.4F, glm::vec3(0, 1, 0)), glm::vec3(1)});
    return glb;
}

Glb ground() {
    Glb glb;
    Shape shape;
    add_sheet(shape, glb.add_material({.name = "ground", .color = {0.5F, 0.4F, 0.3F}}), 0);
    glb.place(glb.add_mesh(shape, "ground"), "ground");
    place_sun(glb);
    return glb;
}

Glb occluder() {
    Glb glb = ground();
    Shape shape;
    add_sheet(shape, glb.add_material({.name = "black", .color = glm::vec3(0)}), 2, 1);
    glb.place(glb.add_mesh(shape, "occluder"), "occluder");
    return glb;
}

Glb point_light() {
    Glb glb;
    Shape shape;
    add_sheet(shape, glb.add_material({.name = "black", .color = glm::vec3(0)}), 0);
    glb.place(glb.add_mesh(shape, "ground"), "ground");
    glb.place_light({.name = "bulb", .type = "point", .intensity = 100, .color = {1, 0.5F, 0.25F}, .range = 8},
                    {.translation = {0, 2, 0}});
    return glb;
}

Glb spot_light() {
    Glb glb;
    Shape shape;
    add_sheet(shape, glb.add_material({.name = "black", .color = glm::vec3(0)}), 0);
    glb.place(glb.add_mesh(shape, "ground"), "ground");
    glb.place_light({.name = "spot",
                     .type = "spot",
                     .intensity = 200,
                     .color = {1, 0.8F, 0.6F},
                     .range = 12,
                     .inner_cone = glm::radians(20.0F),
                     .outer_cone = glm::radians(40.0F)},
                    {{0, 5, 0}, glm::angleAxis(-glm::half_pi<float>(), glm::vec3(1, 0, 0)), glm::vec3(1)});
    return glb;
}

Glb emitter_rect() {
    Glb glb;
    const int lamp = glb.add_material({.name = "lamp", .color = glm::vec3(0), .emission = {10, 8, 6}});
    Shape shape;
    add_quad(shape, lamp, {-1, 3, -0.5F}, {2, 0, 0}, {0, 0, 1});  // looks down
    glb.place(glb.add_mesh(shape, "lamp"), "lamp");
    return glb;
}

Glb blend_cover() {
    return sheet_under_sky({.name = "veil", .color = {0.6F, 0.4F, 0.2F}, .alpha = 0.25F});
}

Glb glass_cover() {
    return sheet_under_sky({.name = "glass", .color = {0.6F, 0.8F, 0.4F}, .transmission = 0.75F});
}

}  // namespace lightgrid::scenes
