#include "scenes/levels.h"
#include "scenes/shapes.h"

#include <array>

namespace lightgrid::scenes {
namespace {

/// A downward lamp: a closed box of which only the underside shines. Its top is at `top`.
void add_ceiling_lamp(Shape& shape, int shining, int dull, glm::vec3 top, glm::vec2 half) {
    constexpr float thickness = 0.02F;
    Blocks lamp({dull, dull, shining});
    lamp.fill({top.x - half.x, top.y - thickness, top.z - half.y}, {top.x + half.x, top.y, top.z + half.y});
    lamp.add_to(shape);
}

Placement turned(glm::vec3 translation, float degrees) {
    return {translation, glm::angleAxis(glm::radians(degrees), glm::vec3(0, 1, 0)), glm::vec3(1)};
}

}  // namespace

/// The box measured at Cornell University, here ten times as large. Colours are the published reflectance spectra seen
/// under equal-energy light, in linear Rec.709.
Glb cornell() {
    Glb glb;
    const int white = glb.add_material({.name = "white", .color = {0.725F, 0.71F, 0.68F}});
    const int red = glb.add_material({.name = "red", .color = {0.63F, 0.065F, 0.05F}});
    const int green = glb.add_material({.name = "green", .color = {0.14F, 0.45F, 0.091F}});
    const int lamp = glb.add_material({.name = "lamp", .color = glm::vec3(0.78F), .emission = {1700, 1200, 400}});

    constexpr float width = 5.528F;
    constexpr float height = 5.488F;
    constexpr float depth = 5.592F;
    constexpr float wall = 0.1F;
    const Paint plain{white, white, white};
    // Each coloured wall is a body of its own that ends where the white body's inner faces begin.
    Blocks shell(plain);
    shell.fill({0, -wall, -wall}, {width, height + wall, depth});
    shell.carve({0, 0, 0}, {width, height, depth}, plain);
    Shape shape;
    shell.add_to(shape);
    add_box(shape, red, {-wall, -wall, -wall}, {0, height + wall, depth});
    add_box(shape, green, {width, -wall, -wall}, {width + wall, height + wall, depth});
    glb.place(glb.add_mesh(shape, "walls"), "walls");

    Shape light;
    add_ceiling_lamp(light, lamp, white, {0.5F * width, height, 0.5F * depth}, {0.65F, 0.525F});
    glb.place(glb.add_mesh(light, "lamp"), "lamp");

    // Boxes with the centres, sides and angles of the published blocks, whose corners are not quite square.
    Shape blocks;
    add_box(blocks, white, {-0.824F, 0, -0.835F}, {0.824F, 1.65F, 0.835F});
    glb.place(glb.add_mesh(blocks, "short block"), "short block", turned({3.673F, 0, 3.902F}, -16.6F));
    Shape tall;
    add_box(tall, white, {-0.827F, 0, -0.837F}, {0.827F, 3.3F, 0.837F});
    glb.place(glb.add_mesh(tall, "tall block"), "tall block", turned({1.843F, 0, 2.080F}, 17.2F));
    return glb;
}

Glb thin_wall() {
    Glb glb;
    const int white = glb.add_material({.name = "white", .color = {0.7F, 0.7F, 0.65F}});
    const int lamp = glb.add_material({.name = "lamp", .color = glm::vec3(0.7F), .emission = glm::vec3(400)});
    const Paint plain{white, white, white};
    Blocks house(plain);
    house.fill({-4.2F, -0.2F, -2.2F}, {4.2F, 3.2F, 2.2F});
    house.carve({-4, 0, -2}, {-0.005F, 3, 2}, plain);
    house.carve({0.005F, 0, -2}, {4, 3, 2}, plain);
    Shape shape;
    house.add_to(shape);
    add_ceiling_lamp(shape, lamp, white, {-1.5F, 3, 0}, {0.5F, 0.5F});
    glb.place(glb.add_mesh(shape, "house"), "house");
    return glb;
}

Glb door_ajar() {
    Glb glb;
    const int white = glb.add_material({.name = "white", .color = {0.7F, 0.7F, 0.7F}});
    const int ochre = glb.add_material({.name = "ochre", .color = {0.6F, 0.42F, 0.2F}});
    const int oak = glb.add_material({.name = "oak", .color = {0.35F, 0.22F, 0.12F}});
    const int lamp = glb.add_material({.name = "lamp", .color = glm::vec3(0.7F), .emission = {900, 800, 650}});
    Blocks house({white, white, white});
    house.fill({-4.3F, -0.2F, -2.2F}, {4.3F, 3, 2.2F});
    house.carve({-4.1F, 0, -2}, {-0.1F, 2.8F, 2}, {oak, white, white});
    house.carve({0.1F, 0, -2}, {4.1F, 2.8F, 2}, {oak, ochre, white});
    house.carve({-0.1F, 0, -0.45F}, {0.1F, 2.1F, 0.45F}, {oak, white, white});
    Shape shape;
    house.add_to(shape);
    add_ceiling_lamp(shape, lamp, white, {-2.5F, 2.8F, 0}, {0.4F, 0.4F});
    glb.place(glb.add_mesh(shape, "house"), "house");

    // Hinged at the doorway's edge on the dark side, half a centimetre above the floor, open by 7 degrees.
    Shape door;
    add_box(door, oak, {-0.04F, 0, 0}, {0, 2.09F, 0.885F});
    glb.place(glb.add_mesh(door, "door"), "door", turned({0.1F, 0.005F, -0.445F}, 7));
    return glb;
}

Glb inn(bool lamps) {
    Glb glb;
    const int plaster = glb.add_material({.name = "plaster", .color = {0.7F, 0.65F, 0.55F}});
    const int oak = glb.add_material({.name = "oak", .color = {0.35F, 0.22F, 0.12F}});
    const int green = glb.add_material({.name = "green", .color = {0.25F, 0.45F, 0.3F}});
    const int dull = glb.add_material({.name = "dull", .color = glm::vec3(0.7F)});
    const int lamp = glb.add_material({.name = "lamp", .color = glm::vec3(0.7F), .emission = {1000, 800, 500}});
    const int red = glb.add_material({.name = "red sign", .color = glm::vec3(0.2F), .emission = {450, 30, 45}});
    const int blue = glb.add_material({.name = "blue sign", .color = glm::vec3(0.2F), .emission = {20, 75, 300}});

    // A taproom with a window, and a back room behind an open door.
    Blocks house({plaster, plaster, plaster});
    house.fill({-5.2F, -0.2F, -2.7F}, {4.2F, 3, 2.7F});
    house.carve({-5, 0, -2.5F}, {-0.1F, 2.8F, 2.5F}, {oak, plaster, plaster});
    house.carve({0.1F, 0, -2.5F}, {4, 2.8F, 2.5F}, {oak, green, plaster});
    house.carve({-0.1F, 0, -0.5F}, {0.1F, 2.1F, 0.5F}, {oak, plaster, plaster});
    house.carve({-5.2F, 0.9F, -1.2F}, {-5, 2.2F, 1.2F}, {plaster, plaster, plaster});
    Shape shape;
    house.add_to(shape);
    glb.place(glb.add_mesh(shape, "house"), "house");
    Shape counter;
    add_box(counter, oak, {-3.5F, 0, 1.3F}, {-1, 1.1F, 1.8F});
    glb.place(glb.add_mesh(counter, "counter"), "counter");

    // Two lamps in a group; one of the same material in the back room is in none.
    Shape of_group;
    add_ceiling_lamp(of_group, lamps ? lamp : dull, dull, {0, 0, 0}, {0.3F, 0.3F});
    const int mesh = glb.add_mesh(of_group, "lamp of the taproom");
    glb.place(mesh, "lamp by the window", {.translation = {-3.6F, 2.8F, 0}});
    glb.place(mesh, "lamp by the door", {.translation = {-1.5F, 2.8F, 0}});
    glb.group(2, "lamps");
    Shape lone;
    add_ceiling_lamp(lone, lamp, dull, {2.5F, 2.8F, -1}, {0.3F, 0.3F});
    glb.place(glb.add_mesh(lone, "lamp of the back room"), "lamp of the back room");

    // Boards that shine on all sides, one in each room, and a spot on a third that does not.
    Shape signs;
    add_box(signs, red, {-3.5F, 1.6F, -2.45F}, {-2, 2, -2.4F});
    add_box(signs, blue, {3.9F, 1.4F, 0.6F}, {3.95F, 1.9F, 1.6F});
    add_box(signs, dull, {-1.2F, 1.5F, -2.45F}, {-0.4F, 2.1F, -2.4F});
    glb.place(glb.add_mesh(signs, "signs"), "signs");
    glb.place_light({.name = "spot",
                     .type = "spot",
                     .intensity = 120,
                     .color = {0.6F, 1, 0.7F},
                     .inner_cone = glm::radians(15.0F),
                     .outer_cone = glm::radians(30.0F)},
                    {.translation = {-0.8F, 1.8F, -1.2F}});
    glb.group(2, "signs");
    return glb;
}

Glb courtyard() {
    Glb glb;
    const int paving = glb.add_material({.name = "paving", .color = {0.42F, 0.38F, 0.33F}});
    const int plaster = glb.add_material({.name = "plaster", .color = {0.75F, 0.62F, 0.45F}});
    const int reveal = glb.add_material({.name = "reveal", .color = {0.7F, 0.68F, 0.64F}});
    const int blue = glb.add_material({.name = "blue", .color = {0.16F, 0.28F, 0.5F}});
    const int roof = glb.add_material({.name = "roof", .color = {0.5F, 0.2F, 0.12F}});
    const int stone = glb.add_material({.name = "stone", .color = {0.6F, 0.57F, 0.52F}});

    // Four wings of 5 m around a court of 12 m x 10 m; a gallery behind columns on the north side, a gate to the south.
    Blocks wings({roof, plaster, reveal});
    wings.fill({-9, -0.3F, -8}, {9, 5, 8});
    wings.carve({-6, 0, -5}, {6, 5, 5}, {paving, plaster, reveal});
    wings.carve({-6, 0, -7.5F}, {6, 3, -5}, {paving, blue, reveal});  // gallery
    wings.carve({-1, 0, 5}, {1, 3, 8}, {paving, reveal, reveal});     // gate
    for (const float z : {-3.0F, 0.0F, 3.0F}) {                       // blind windows east and west
        wings.carve({6, 1, z - 0.5F}, {6.3F, 2.6F, z + 0.5F}, {reveal, reveal, reveal});
        wings.carve({-6.3F, 1, z - 0.5F}, {-6, 2.6F, z + 0.5F}, {reveal, reveal, reveal});
    }
    Shape shape;
    wings.add_to(shape);
    glb.place(glb.add_mesh(shape, "wings"), "wings");

    Shape column;
    constexpr std::array<glm::vec2, 14> profile{{{0, 0},
                                                 {0.28F, 0},
                                                 {0.28F, 0.12F},
                                                 {0.23F, 0.16F},
                                                 {0.2F, 0.22F},
                                                 {0.19F, 1.2F},
                                                 {0.175F, 2.5F},
                                                 {0.18F, 2.62F},
                                                 {0.23F, 2.7F},
                                                 {0.26F, 2.78F},
                                                 {0.26F, 2.84F},
                                                 {0.28F, 2.86F},
                                                 {0.28F, 3},
                                                 {0, 3}}};
    add_lathe(column, stone, profile, 24);
    std::array<Placement, 5> columns;
    for (std::size_t i = 0; i < 5; ++i) columns[i].translation = {-4.8F + 2.4F * static_cast<float>(i), 0, -5.3F};
    glb.place_instances(glb.add_mesh(column, "column"), "colonnade", columns);

    Shape basin;
    constexpr std::array<glm::vec2, 8> bowl{
        {{0, 0}, {1.3F, 0}, {1.3F, 0.5F}, {1.1F, 0.5F}, {1.1F, 0.25F}, {0.2F, 0.25F}, {0.15F, 1.1F}, {0, 1.1F}}};
    add_lathe(basin, stone, bowl, 32);
    glb.place(glb.add_mesh(basin, "basin"), "basin", {.translation = {0, 0, 0.5F}});
    return glb;
}

}  // namespace lightgrid::scenes
