#include "probes/unit_hint.h"

#include "core/sampling.h"
#include "core/tracer.h"
#include "tests/scene_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

namespace lightgrid {
namespace {

std::optional<UnitHint> hint_of(const Scene& scene) {
    return find_unit_hint(Tracer(scene));
}

/// A room with a crate in it.
///
/// height  of the room, in the level's unit
Scene room(float height, float emission_of_ceiling = 0) {
    Scene scene;
    const int wall = add_grey(scene, 0.5F);
    add_box(scene, wall, {0, 0, 0}, {2 * height, height, 3 * height}, Facing::inward);
    add_box(scene, wall, {0.5F * height, 0, 0.5F * height}, {height, 0.3F * height, height}, Facing::outward);
    add_quad(scene, add_grey(scene, 0.5F, emission_of_ceiling), {0, 0.999F * height, 0}, {2 * height, 0, 0},
             {0, 0, 3 * height});
    return scene;
}

/// Many lumps of eight triangles, as many as `layers` of them above each other.
void add_heap(Scene& scene, glm::vec3 size, float least, float most, double layers) {
    RandomStream random(7);
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;
    for (double area = 0; area < layers * static_cast<double>(size.x * size.z);) {
        const auto first = static_cast<unsigned>(positions.size());
        const float radius = least + (most - least) * random.next();
        const glm::vec2 v = random.next2();
        const glm::vec3 u(v, random.next());
        const glm::vec3 centre = glm::vec3(most) + u * (size - 2 * most);
        const float turn = 6.3F * random.next();
        const glm::vec3 a(radius * std::cos(turn), 0.3F * radius, radius * std::sin(turn));
        const glm::vec3 b(-a.z, 0.2F * radius, a.x);
        const glm::vec3 up(0, radius, 0);
        for (const glm::vec3& corner : {a, b, -a, -b, up, -up}) positions.push_back(centre + corner);
        for (unsigned i = 0; i < 4; ++i) {
            triangles.emplace_back(first + 4, first + (i + 1) % 4, first + i);
            triangles.emplace_back(first + 5, first + i, first + (i + 1) % 4);
        }
        area += 2.0 * static_cast<double>(radius * radius);
    }
    add_mesh(scene, add_grey(scene, 0.5F), std::move(positions), std::move(triangles));
}

/// Hills in a square of this width, seen from above.
void add_terrain(Scene& scene, float width, unsigned cells) {
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;
    for (unsigned i = 0; i <= cells; ++i) {
        for (unsigned k = 0; k <= cells; ++k) {
            const glm::vec2 at = width / static_cast<float>(cells) * glm::vec2(i, k);
            positions.emplace_back(at.x, 0.02F * width * (std::sin(20 * at.x / width) + std::sin(31 * at.y / width)),
                                   at.y);
        }
    }
    for (unsigned i = 0; i < cells; ++i) {
        for (unsigned k = 0; k < cells; ++k) {
            const unsigned at = i * (cells + 1) + k;
            triangles.emplace_back(at, at + 1, at + cells + 2);
            triangles.emplace_back(at, at + cells + 2, at + cells + 1);
        }
    }
    add_mesh(scene, add_grey(scene, 0.5F), std::move(positions), std::move(triangles));
}

TEST(UnitHint, RoomsAreAsHighAsPeopleNeedThem) {
    for (const float height : {2.5F, 9.0F, 40.0F, 70.0F}) EXPECT_FALSE(hint_of(room(height))) << height;
    const std::optional<UnitHint> centimetre = hint_of(room(549));
    ASSERT_TRUE(centimetre);
    EXPECT_EQ(centimetre->metres_per_unit, 0.01);
    EXPECT_EQ(centimetre->unit, "centimetre");
    EXPECT_EQ(centimetre->evidence, "its rooms would be 548 m high");
    for (const float height : {181.0F, 250.0F, 1500.0F}) EXPECT_EQ(hint_of(room(height))->unit, "centimetre") << height;
    for (const float height : {72.0F, 110.0F, 179.0F}) EXPECT_EQ(hint_of(room(height))->unit, "inch") << height;
    for (const float height : {1900.0F, 2700.0F}) EXPECT_EQ(hint_of(room(height))->unit, "millimetre") << height;
    EXPECT_EQ(hint_of(room(110))->metres_per_unit, 0.0254);
    EXPECT_EQ(hint_of(room(2700))->metres_per_unit, 0.001);
}

TEST(UnitHint, ASkyIsNoCeiling) {
    EXPECT_FALSE(hint_of(room(500, 1))) << "a box that shines";
    Scene dome;
    add_quad(dome, add_grey(dome, 0.5F), {-250, 0, 250}, {500, 0, 0}, {0, 0, -500});
    add_sphere(dome, add_grey(dome, 0.5F), {0, 0, 0}, 400, Facing::inward, 64, 64);
    EXPECT_FALSE(hint_of(dome));
}

TEST(UnitHint, TerrainIsAsWideAsItIs) {
    for (const float width : {545.0F, 20000.0F}) {
        Scene scene;
        add_terrain(scene, width, 100);
        EXPECT_FALSE(hint_of(scene)) << width;
        add_box(scene, add_grey(scene, 0.5F), {0, -0.2F * width, 0}, {width, -0.1F * width, width}, Facing::outward);
        EXPECT_FALSE(hint_of(scene)) << "on a socket";
    }
}

TEST(UnitHint, TownsAndWoodsHaveFewLayers) {
    Scene town;
    const int wall = add_grey(town, 0.5F);
    add_quad(town, wall, {0, 0, 1000}, {1000, 0, 0}, {0, 0, -1000});
    for (int i = 0; i < 600; ++i) {
        const glm::vec3 corner(40 * (i % 25), 0, 40 * (i / 25));
        add_box(town, wall, corner, corner + glm::vec3(30, 10 + i % 50, 30), Facing::outward);
    }
    EXPECT_FALSE(hint_of(town));
    Scene woods;
    add_terrain(woods, 545, 100);
    add_heap(woods, {545, 30, 545}, 2, 4, 0.8);
    EXPECT_FALSE(hint_of(woods));
}

TEST(UnitHint, ThousandsOfThingsAreNotAllLarge) {
    Scene large;
    add_heap(large, {545, 400, 545}, 2, 20, 3);
    const std::optional<UnitHint> hint = hint_of(large);
    ASSERT_TRUE(hint);
    EXPECT_EQ(hint->metres_per_unit, 0.01);
    EXPECT_NE(hint->evidence.find("hardly one of its"), std::string::npos) << hint->evidence;

    Scene metres;
    add_heap(metres, {5.45F, 4, 5.45F}, 0.02F, 0.2F, 3);
    EXPECT_FALSE(hint_of(metres)) << "the same in metres";

    Scene with_small_things;
    add_heap(with_small_things, {545, 400, 545}, 2, 20, 3);
    add_heap(with_small_things, {2, 2, 2}, 0.05F, 0.2F, 40);
    EXPECT_FALSE(hint_of(with_small_things));

    Scene warren;
    const int wall = add_grey(warren, 0.5F);
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 corner(6 * (i % 10), 4 * (i / 100), 6 * (i / 10 % 10));
        add_box(warren, wall, corner, corner + glm::vec3(5, 3, 5), Facing::inward);
    }
    EXPECT_FALSE(hint_of(warren)) << "rooms of 3 m, however many";
}

TEST(UnitHint, InstancesCountAsWhatTheyAre) {
    Scene scene;
    Scene piece;
    add_heap(piece, {1, 1, 1}, 0.02F, 0.04F, 5);
    Mesh mesh = piece.meshes[0];
    mesh.material = add_grey(scene, 0.5F);
    const int stored = store_mesh(scene, mesh.material, mesh.positions, mesh.triangles);
    const auto place = [&](float size) { add_instance(scene, stored, glm::mat4x3(glm::mat3(size))); };
    place(1);
    EXPECT_FALSE(hint_of(scene));
    scene.instances.clear();
    scene.models.clear();
    place(100);
    EXPECT_TRUE(hint_of(scene));
}

TEST(UnitHint, LevelsWithoutSurfacesHaveNone) {
    EXPECT_FALSE(hint_of({}));
    Scene flat;
    add_quad(flat, add_grey(flat, 0.5F), {0, 0, 500}, {500, 0, 0}, {0, 0, -500});
    EXPECT_FALSE(hint_of(flat));
}

}  // namespace
}  // namespace lightgrid
