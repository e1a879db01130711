#define GLM_ENABLE_EXPERIMENTAL  // glm::rotation between two vectors
#include "scenes/furniture.h"
#include "scenes/levels.h"
#include "scenes/pictures.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtx/quaternion.hpp>

#include <array>
#include <random>
#include <string>
#include <vector>

namespace lightgrid::scenes {
namespace {

constexpr float ceiling = 2.8F;
constexpr float door_height = 2.1F;
// Bodies stand this far apart where they would touch: two faces in one plane are seen in no certain order, and from
// within a solid the other body's front would look like free space.
constexpr float hair = 0.001F;

// Light of 2700 K and 4000 K in linear Rec.709, red = 1.
constexpr glm::vec3 warm{1, 0.62F, 0.3F};
constexpr glm::vec3 neutral{1, 0.84F, 0.68F};

struct Palette {
    int plaster, ceiling, terracotta, teal, skirting, stone, grass, hedge, facade;
    int parquet, tiles, paving, rug, painting, print, leaf;
    int oak, walnut, steel, china, glass, linen, navy, mustard, rust, clay, soil, orange, glaze, paper;
    int bulb, shade, lantern, strip, sconce;
    std::array<int, 5> covers;
};

Palette add_palette(Glb& glb) {
    const auto plain = [&](const char* name, float r, float g, float b) {
        return glb.add_material({.name = name, .color = {r, g, b}});
    };
    const auto pictured = [&](const char* name, const Picture& picture, glm::vec2 size, bool mask = false) {
        return glb.add_material({.name = name,
                                 .color = glm::vec3(1),
                                 .picture = glb.add_picture(picture, name),
                                 .picture_size = size,
                                 .mask = mask});
    };
    const auto shining = [&](const char* name, glm::vec3 radiance) {
        return glb.add_material({.name = name, .color = glm::vec3(0.8F), .emission = radiance});
    };
    Palette p{};
    p.plaster = plain("plaster", 0.76F, 0.73F, 0.67F);
    p.ceiling = plain("ceiling", 0.82F, 0.81F, 0.79F);
    p.terracotta = plain("terracotta", 0.55F, 0.2F, 0.12F);
    p.teal = plain("teal", 0.12F, 0.32F, 0.34F);
    p.skirting = plain("skirting", 0.8F, 0.79F, 0.76F);
    p.stone = plain("stone", 0.62F, 0.6F, 0.56F);
    p.grass = plain("grass", 0.12F, 0.2F, 0.06F);
    p.hedge = plain("hedge", 0.1F, 0.17F, 0.07F);
    p.facade = plain("facade", 0.7F, 0.66F, 0.6F);
    p.parquet = pictured("parquet", wood_planks(), {1.92F, 1.92F});
    p.tiles = pictured("tiles", checkered_tiles(), {0.8F, 0.8F});
    p.paving = pictured("paving", paving(), {1.8F, 1.8F});
    p.rug = pictured("rug", rug(), {3, 2});
    p.painting = pictured("painting", painting(), {1.2F, 0.9F});
    p.print = pictured("print", print(), {0.6F, 0.8F});
    p.leaf = pictured("leaf", leaf(), {1, 1}, true);
    p.oak = plain("oak", 0.45F, 0.28F, 0.14F);
    p.walnut = plain("walnut", 0.2F, 0.115F, 0.065F);
    p.steel = plain("steel", 0.25F, 0.25F, 0.26F);
    p.china = plain("china", 0.82F, 0.81F, 0.78F);
    p.glass = glb.add_material({.name = "glass", .color = {0.96F, 0.98F, 0.97F}, .transmission = 0.94F});
    p.linen = plain("linen", 0.72F, 0.66F, 0.55F);
    p.navy = plain("navy", 0.11F, 0.16F, 0.28F);
    p.mustard = plain("mustard", 0.68F, 0.42F, 0.1F);
    p.rust = plain("rust", 0.58F, 0.2F, 0.1F);
    p.clay = plain("clay", 0.6F, 0.34F, 0.22F);
    p.soil = plain("soil", 0.12F, 0.1F, 0.09F);
    p.orange = plain("orange", 0.75F, 0.3F, 0.1F);
    p.glaze = plain("glaze", 0.16F, 0.38F, 0.42F);
    p.paper = plain("paper", 0.78F, 0.74F, 0.64F);
    // A body of area A and radiance L gives pi A L lumens.
    p.bulb = shining("bulb", 700.0F * warm);              // 560 lm from a pendant
    p.shade = shining("lamp shade", 300.0F * warm);       // 450 lm
    p.lantern = shining("paper lantern", 450.0F * warm);  // 1,100 lm
    p.strip = shining("light strip", 600.0F * neutral);
    p.sconce = shining("sconce", 900.0F * warm);  // 200 lm
    p.covers = {plain("red cover", 0.5F, 0.12F, 0.1F), plain("green cover", 0.13F, 0.3F, 0.2F),
                plain("blue cover", 0.12F, 0.2F, 0.42F), plain("cream cover", 0.72F, 0.62F, 0.44F),
                plain("black cover", 0.1F, 0.1F, 0.11F)};
    return p;
}

Placement at(glm::vec3 translation, float degrees = 0, float scale = 1) {
    return {translation, glm::angleAxis(glm::radians(degrees), glm::vec3(0, 1, 0)), glm::vec3(scale)};
}

/// Turns -Z, the way a glTF light shines, into `direction`.
glm::quat shine_along(glm::vec3 direction) {
    return glm::rotation(glm::vec3(0, 0, -1), glm::normalize(direction));
}

/// Living room and kitchen to the south (+Z), study and hall to the north.
void add_house(Glb& glb, const Palette& p) {
    Blocks house({p.facade, p.facade, p.facade});
    house.fill({-0.5F, -0.3F, -0.5F}, {10.5F, 3.1F, 8.5F});
    const Paint living{p.parquet, p.plaster, p.ceiling};
    const Paint kitchen{p.tiles, p.plaster, p.ceiling};
    const Paint study{p.parquet, p.terracotta, p.ceiling};
    const Paint hall{p.parquet, p.teal, p.ceiling};
    const Paint opening{p.parquet, p.skirting, p.skirting};
    house.carve({0, -hair, 3.08F}, {5.92F, ceiling, 8}, living);
    house.carve({6.08F, -hair, 3.08F}, {10, ceiling, 8}, kitchen);
    house.carve({0, -hair, 0}, {4.42F, ceiling, 2.92F}, study);
    house.carve({4.58F, -hair, 0}, {10, ceiling, 2.92F}, hall);

    house.carve({5.92F, -hair, 4.3F}, {6.08F, 2.35F, 6.9F}, opening);          // living room - kitchen
    house.carve({0.5F, -hair, 2.92F}, {1.4F, door_height, 3.08F}, opening);    // living room - study
    house.carve({4.75F, -hair, 2.92F}, {5.65F, door_height, 3.08F}, opening);  // living room - hall
    house.carve({8.7F, -hair, 2.92F}, {9.6F, door_height, 3.08F}, opening);    // kitchen - hall

    const Paint reveal{p.skirting, p.plaster, p.plaster};
    house.carve({0.9F, 0.35F, 8}, {5.1F, 2.45F, 8.5F}, reveal);                              // living room, south
    house.carve({-0.5F, 0.9F, 4.6F}, {0, 2.3F, 6.4F}, reveal);                               // living room, west
    house.carve({7.2F, -hair, 8}, {8.8F, 2.35F, 8.5F}, {p.skirting, p.plaster, p.plaster});  // kitchen, garden door
    house.carve({10, 1, 4.6F}, {10.5F, 2.3F, 6.6F}, reveal);                                 // kitchen, east
    house.carve({7.7F, ceiling, 0.8F}, {9.1F, 3.1F, 2.1F}, reveal);                          // hall, skylight

    // Four steps up to a landing at the hall's east end.
    for (int step = 0; step < 4; ++step) {
        const auto index = static_cast<float>(step);
        house.fill({7.4F + 0.3F * index, 0.16F * index - hair, 0}, {10, 0.16F * (index + 1), 1.45F});
    }
    Shape shape;
    house.add_to(shape);
    glb.place(glb.add_mesh(shape, "house"), "house");

    // Skirting boards.
    Shape boards;
    const auto board = [&](glm::vec2 from, glm::vec2 to) {
        add_box(boards, p.skirting, {from.x + hair, 0, from.y + hair}, {to.x - hair, 0.09F, to.y - hair});
    };
    constexpr float deep = 0.014F;
    board({1.4F, 3.08F}, {4.75F, 3.08F + deep});
    board({0, 3.08F}, {0.5F, 3.08F + deep});
    board({0, 3.08F + deep}, {deep, 8});
    board({deep, 8 - deep}, {5.92F, 8});
    board({5.92F - deep, 3.08F}, {5.92F, 4.3F});
    board({5.92F - deep, 6.9F}, {5.92F, 8 - deep});
    board({0, 0}, {deep, 2.92F});
    board({deep, 0}, {4.42F, deep});
    board({4.42F - deep, deep}, {4.42F, 2.92F});
    board({4.58F, 0}, {4.58F + deep, 2.92F});
    board({4.58F + deep, 0}, {7.4F, deep});
    board({5.65F, 2.92F - deep}, {8.7F, 2.92F});
    board({10 - deep, 3.08F}, {10, 8});
    board({6.08F, 6.9F}, {6.08F + deep, 8});
    glb.place(glb.add_mesh(boards, "skirting"), "skirting");

    const auto window = [&](const char* name, glm::vec2 size, glm::ivec2 panes, const Placement& placement) {
        glb.place(glb.add_mesh(window_frame(p.skirting, p.glass, size, panes), name), name, placement);
    };
    window("south window", {4.2F, 2.1F}, {4, 1}, at({0.9F, 0.35F, 8.36F}));
    window("west window", {1.8F, 1.4F}, {2, 1}, at({-0.36F, 0.9F, 6.4F}, 90));
    window("garden door", {1.6F, 2.35F}, {2, 1}, at({7.2F, 0, 8.36F}));
    window("east window", {2, 1.3F}, {2, 1}, at({10.36F, 1, 6.6F}, 90));
    window("skylight", {1.4F, 1.3F}, {2, 1},
           {{7.7F, 3, 2.1F}, glm::angleAxis(-glm::half_pi<float>(), glm::vec3(1, 0, 0)), glm::vec3(1)});
}

void add_garden(Glb& glb, const Palette& p) {
    Shape garden;
    Blocks ground({p.grass, p.grass, p.grass});
    ground.fill({-4.5F, -0.5F, -4.5F}, {14.5F, -0.3F - hair, 13});
    ground.add_to(garden);
    add_box(garden, p.paving, {0.2F, -0.3F, 8.5F + hair}, {9.8F, -0.06F, 10.6F});
    Blocks hedge({p.hedge, p.hedge, p.hedge});
    hedge.fill({-4.4F, -0.3F, -4.4F}, {14.4F, 1.5F, 12.9F});
    hedge.carve({-3.7F, -0.3F, -3.7F}, {13.7F, 1.5F, 12.2F}, {p.hedge, p.hedge, p.hedge});
    hedge.add_to(garden);
    glb.place(glb.add_mesh(garden, "garden"), "garden");
}

/// Books that fill a shelf's boards from the left, one instanced mesh a colour.
class Library {
  public:
    /// board  the board's left end, facing +Z; the row turns with `degrees`
    void add_row(glm::vec3 board, float degrees, float length, float tallest) {
        const glm::quat turn = glm::angleAxis(glm::radians(degrees), glm::vec3(0, 1, 0));
        float along = 0.01F;
        while (true) {
            const glm::vec3 size{0.02F + 0.034F * next(), tallest * (0.68F + 0.3F * next()), 0.14F + 0.05F * next()};
            if (along + size.x > length) return;
            const auto color = static_cast<std::size_t>(next() * static_cast<float>(rows_.size()));
            if (next() < 0.94F) {
                const glm::vec3 local{along + 0.5F * size.x, 0, 0.11F};
                rows_[color].push_back({board + turn * local, turn, size});
            } else {
                along += 0.08F;  // a gap
            }
            along += size.x + 0.001F;
        }
    }
    /// A pile on a table.
    void add_pile(glm::vec3 base, int books) {
        for (int i = 0; i < books; ++i) {
            const float thick = 0.022F + 0.012F * next();
            const glm::quat lay = glm::angleAxis(glm::half_pi<float>(), glm::vec3(0, 0, 1));
            const glm::quat turn = glm::angleAxis(0.8F * (next() - 0.5F), glm::vec3(0, 1, 0));
            const auto color = static_cast<std::size_t>(next() * static_cast<float>(rows_.size()));
            rows_[color].push_back(
                {base + turn * glm::vec3(0.12F, 0.5F * thick, 0), turn * lay, {thick, 0.24F, 0.17F}});
            base.y += thick;
        }
    }
    void place(Glb& glb, const Palette& p) const {
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            const int mesh = glb.add_mesh(book(p.covers[i], p.paper), "book " + std::to_string(i));
            glb.place_instances(mesh, "books " + std::to_string(i), rows_[i]);
        }
    }

  private:
    /// In [0, 1), the same on every machine.
    float next() { return static_cast<float>(random_() >> 8) / 16777216.0F; }

    std::mt19937 random_{7};
    std::array<std::vector<Placement>, 5> rows_;
};

void add_living_room(Glb& glb, const Palette& p, Library& library, int plant_mesh) {
    const auto show = [&](const Shape& shape, const char* name, const Placement& placement) {
        glb.place(glb.add_mesh(shape, name), name, placement);
    };
    Shape carpet;
    add_box(carpet, p.rug, {0, 0, 0}, {3, 0.012F, 2});
    show(carpet, "rug", at({1.75F, 0, 4.35F}));
    show(sofa(p.navy, p.mustard, p.walnut, 2.2F), "sofa", at({3, 0, 3.62F}));
    show(armchair(p.mustard, p.linen, p.walnut), "armchair", at({4.85F, 0, 6.45F}, 215));
    show(round_table(p.oak, p.walnut, 0.5F, 0.4F), "coffee table", at({3.2F, 0.012F, 5.2F}));
    show(bowl(p.glaze, p.orange, 0.15F), "fruit bowl", at({3.38F, 0.412F, 5.05F}));
    library.add_pile({2.9F, 0.412F, 5.3F}, 4);
    show(floor_lamp(p.steel, p.shade, 1.6F), "floor lamp", at({1.75F, 0, 3.5F}));
    show(pendant(p.steel, p.lantern, 0.3F, 0.3F), "paper lantern", at({3.2F, ceiling, 5.4F}));
    show(round_table(p.oak, p.walnut, 0.24F, 0.5F), "side table", at({4.6F, 0, 3.5F}));
    show(vase(p.clay, 0.36F), "vase", at({4.6F, 0.5F, 3.5F}));
    show(picture_frame(p.oak, p.painting, {1.2F, 0.9F}), "painting", at({3, 1.65F, 3.08F + hair}));
    show(column(p.stone, 0.13F, 2.35F), "column", at({6, 0, 5.6F}));

    constexpr glm::vec3 shelf_size{1, 2.1F, 0.3F};
    show(shelf(p.walnut, shelf_size, 6), "living room shelf", at({5.92F - hair, 0, 7.46F}, -90));
    const float pitch = (shelf_size.y - 0.025F) / 6;
    for (int board = 0; board < 6; ++board) {
        if (board == 3) continue;
        library.add_row({5.92F - 0.03F, 0.025F + pitch * static_cast<float>(board), 6.985F}, -90, 0.95F, pitch - 0.04F);
    }
    show(bowl(p.china, p.glaze, 0.12F), "bowl", at({5.75F, 0.025F + 3 * pitch, 7.45F}));

    glb.place(plant_mesh, "tall plant", at({0.65F, 0, 7.35F}, 20, 1.25F));
    glb.place(plant_mesh, "plant", at({5.5F, 0, 3.5F}, 140, 0.9F));
    show(curtain(p.linen, 0.6F, 2.35F), "curtain", at({0.32F, 0.1F, 7.9F}));
    glb.place(glb.add_mesh(curtain(p.linen, 0.48F, 2.35F), "curtain, right"), "curtain, right",
              at({5.06F, 0.1F, 7.9F}));

    glb.place_light({.name = "picture spot",
                     .type = "spot",
                     .intensity = 130,
                     .color = neutral,
                     .range = 6,
                     .inner_cone = glm::radians(12.0F),
                     .outer_cone = glm::radians(26.0F)},
                    {{3, 2.78F, 4.5F}, shine_along(glm::vec3(0, -1.13F, -1.4F)), glm::vec3(1)});
}

void add_kitchen(Glb& glb, const Palette& p, int chair_mesh, int plant_mesh) {
    const auto show = [&](const Shape& shape, const char* name, const Placement& placement) {
        glb.place(glb.add_mesh(shape, name), name, placement);
    };
    constexpr glm::vec3 table_size{0.95F, 0.75F, 2};
    constexpr glm::vec3 middle{8.05F, 0, 5.7F};
    show(table(p.oak, p.walnut, table_size), "dining table", at(middle));
    std::vector<Placement> chairs;
    std::vector<Placement> plates;
    for (const float z : {-0.62F, 0.0F, 0.62F}) {
        for (const float side : {-1.0F, 1.0F}) {
            const float pushed = z == 0 && side > 0 ? 0.72F : 0.58F;  // somebody has left the table
            chairs.push_back(at(middle + glm::vec3(side * pushed, 0, z), side > 0 ? -90 : 90));
            plates.push_back(at(middle + glm::vec3(side * 0.3F, table_size.y, z)));
        }
    }
    chairs.push_back(at({3.1F, 0, 1.15F}, 195));  // the study's
    glb.place_instances(chair_mesh, "chairs", chairs);
    glb.place_instances(glb.add_mesh(plate(p.china), "plate"), "plates", plates);
    show(bowl(p.china, p.orange, 0.17F), "table bowl", at(middle + glm::vec3(0, table_size.y, 0.1F)));
    show(vase(p.glaze, 0.3F), "table vase", at(middle + glm::vec3(0.03F, table_size.y, -0.35F)));

    const int lamp = glb.add_mesh(pendant(p.steel, p.bulb, 0.9F, 0.17F), "pendant");
    std::vector<Placement> pendants;
    for (const float z : {-0.65F, 0.0F, 0.65F}) pendants.push_back(at(middle + glm::vec3(0, ceiling, z)));
    glb.place_instances(lamp, "pendants", pendants);

    // Counter along the north wall, a board above it with a light strip below.
    Shape counter;
    add_box(counter, p.linen, {6.1F, 0.1F, 3.09F}, {8.4F, 0.87F, 3.66F});
    add_rounded_box(counter, p.walnut, {6.085F, 0.87F, 3.085F}, {8.44F, 0.91F, 3.7F}, 0.008F);
    add_box(counter, p.oak, {6.1F, 1.5F, 3.085F}, {8.4F, 1.54F, 3.36F});
    add_box(counter, p.strip, {6.2F, 1.475F, 3.2F}, {8.3F, 1.495F, 3.23F});
    for (const float x : {6.68F, 7.25F, 7.83F})
        add_box(counter, p.oak, {x - 0.006F, 0.13F, 3.66F}, {x + 0.006F, 0.85F, 3.668F});
    glb.place(glb.add_mesh(counter, "counter"), "counter");
    const int jar = glb.add_mesh(vase(p.china, 0.26F), "jar");
    std::array<Placement, 5> jars;
    for (std::size_t i = 0; i < jars.size(); ++i) {
        const glm::vec3 place{6.4F + 0.42F * static_cast<float>(i), 1.54F, 3.22F};
        jars[i] = at(place, 0, 0.8F + 0.12F * static_cast<float>(i % 3));
    }
    glb.place_instances(jar, "jars", jars);
    show(bowl(p.glaze, p.rust, 0.14F), "counter bowl", at({7.7F, 0.91F, 3.4F}));
    glb.place(plant_mesh, "kitchen plant", at({9.5F, 0, 7.5F}, 75, 1.0F));
    show(picture_frame(p.walnut, p.print, {0.6F, 0.8F}), "print", at({6.08F + hair, 1.6F, 7.45F}, 90));
}

void add_study(Glb& glb, const Palette& p, Library& library) {
    const auto show = [&](const Shape& shape, const char* name, const Placement& placement) {
        glb.place(glb.add_mesh(shape, name), name, placement);
    };
    constexpr glm::vec3 shelf_size{1.5F, 2.2F, 0.3F};
    const int wide_shelf = glb.add_mesh(shelf(p.oak, shelf_size, 6), "study shelf");
    const float pitch = (shelf_size.y - 0.025F) / 6;
    for (const float x : {0.8F, 2.32F}) {
        glb.place(wide_shelf, "study shelf", at({x, 0, 0.005F}));
        for (int board = 0; board < 6; ++board) {
            library.add_row({x - 0.725F, 0.025F + pitch * static_cast<float>(board), 0.035F}, 0, 1.45F, pitch - 0.04F);
        }
    }
    show(table(p.walnut, p.steel, {1.3F, 0.74F, 0.65F}), "desk", at({3.55F, 0, 1.75F}));
    show(desk_lamp(p.steel, p.bulb), "desk lamp", at({3.25F, 0.74F, 1.62F}, 0));
    library.add_pile({3.85F, 0.74F, 1.8F}, 3);
    // The lamp's light itself: bulbs that small are better a point.
    glb.place_light({.name = "desk light", .type = "point", .intensity = 25, .color = warm}, at({3.5F, 1.08F, 1.62F}));
    show(armchair(p.rust, p.linen, p.walnut), "reading chair", at({0.75F, 0, 2.0F}, 120));
    show(floor_lamp(p.steel, p.shade, 1.55F), "reading lamp", at({0.35F, 0, 1.2F}));
    show(picture_frame(p.walnut, p.print, {0.6F, 0.8F}), "study print", at({4.42F - hair, 1.55F, 1.75F}, -90));
}

void add_hall(Glb& glb, const Palette& p, int plant_mesh) {
    const int sconce = glb.add_mesh(
        [&] {
            Shape shape;
            constexpr std::array<glm::vec2, 6> cup{
                {{0, -0.14F}, {0.03F, -0.12F}, {0.06F, 0}, {0.056F, 0}, {0.026F, -0.1F}, {0, -0.1F}}};
            add_lathe(shape, p.steel, cup, 20);
            constexpr std::array<glm::vec2, 7> glow{{{0, -0.09F},
                                                     {0.028F, -0.09F},
                                                     {0.055F, 0.01F},
                                                     {0.07F, 0.08F},
                                                     {0.06F, 0.14F},
                                                     {0.03F, 0.17F},
                                                     {0, 0.175F}}};
            add_lathe(shape, p.sconce, glow, 20);
            return shape;
        }(),
        "sconce");
    const std::array<Placement, 3> sconces{at({4.66F, 1.7F, 1.2F}), at({6.2F, 1.7F, 0.08F}), at({7.1F, 1.7F, 2.84F})};
    glb.place_instances(sconce, "sconces", sconces);

    // A vase on a plinth upon the landing, below the skylight.
    Shape plinth;
    add_box(plinth, p.stone, {-0.19F, 0, -0.19F}, {0.19F, 0.75F, 0.19F});
    glb.place(glb.add_mesh(plinth, "plinth"), "plinth", at({9.45F, 0.64F + hair, 0.55F}, 12));
    glb.place(glb.add_mesh(vase(p.mustard, 0.5F), "great vase"), "great vase", at({9.45F, 1.391F, 0.55F}));
    glb.place(plant_mesh, "hall plant", at({5.15F, 0, 0.6F}, 200, 1.1F));
    glb.place(glb.add_mesh(picture_frame(p.oak, p.painting, {1.2F, 0.9F}), "hall painting"), "hall painting",
              at({6.9F, 1.65F, hair}));
}

}  // namespace

Glb default_level() {
    Glb glb;
    const Palette palette = add_palette(glb);
    add_house(glb, palette);
    add_garden(glb, palette);
    const int plant_mesh = glb.add_mesh(plant(palette.clay, palette.soil, palette.leaf, 20, 1), "plant");
    const int chair_mesh = glb.add_mesh(chair(palette.walnut, palette.linen), "chair");
    Library library;
    add_living_room(glb, palette, library, plant_mesh);
    add_kitchen(glb, palette, chair_mesh, plant_mesh);
    add_study(glb, palette, library);
    add_hall(glb, palette, plant_mesh);
    library.place(glb, palette);
    // The outer layers are within the outer walls, the inner walls midway between two layers.
    glb.mark_volume({5, 1.4F, 4}, {10.5F, 2.7F, 8.5F});
    return glb;
}

}  // namespace lightgrid::scenes
