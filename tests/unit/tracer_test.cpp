#include "core/tracer.h"

#include "core/error.h"
#include "core/sampling.h"
#include "tests/scene_builder.h"
#include "tests/sphere.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace lightgrid {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

glm::vec3 any_direction(RandomStream& random) {
    return sphere_direction(random.next2());
}

/// A random point in the cube [-1, 1]^3.
glm::vec3 any_point(RandomStream& random) {
    const glm::vec2 xy = random.next2();
    return 2.0F * glm::vec3(xy, random.next()) - 1.0F;
}

float transmitted(const Tracer& tracer, glm::vec3 origin, glm::vec3 direction, float distance = infinity) {
    return tracer.transmittance(origin, direction, distance).x;
}

Material grey(float albedo) {
    Material material;
    material.base_color = glm::vec3(albedo);
    return material;
}

Material blend(float albedo, float alpha) {
    Material material = grey(albedo);
    material.alpha_mode = AlphaMode::blend;
    material.alpha = alpha;
    return material;
}

TEST(Tracer, FindsTheNearestTriangleAndWhereOnIt) {
    Scene scene;
    const int material = add_grey(scene, 0.5F);
    RandomStream random(1);
    for (int i = 0; i < 200; ++i) {
        const glm::vec3 a = 3.0F * any_point(random);
        add_triangle(scene, material, a, a + any_point(random), a + any_point(random));
    }
    const Tracer tracer(scene);
    EXPECT_EQ(tracer.triangle_count(), 200U);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
        const glm::vec3 origin = 4.0F * any_point(random);
        const glm::vec3 direction = any_direction(random) * (0.1F + 10 * random.next());
        // Every triangle in double, from the text book: o + t d = a + u (b - a) + v (c - a).
        double nearest = HUGE_VAL;
        double edge = HUGE_VAL;  // how near to an edge a hit or miss was decided
        glm::dvec3 point(0);
        for (const Mesh& mesh : scene.meshes) {
            const glm::dvec3 a(mesh.positions[0]);
            const glm::dvec3 t = glm::inverse(glm::dmat3(glm::dvec3(mesh.positions[1]) - a,
                                                         glm::dvec3(mesh.positions[2]) - a, -glm::dvec3(direction))) *
                                 (glm::dvec3(origin) - a);
            const double inside = std::min({t.x, t.y, 1 - t.x - t.y});
            if (t.z > 0) edge = std::min(edge, std::abs(inside));
            if (inside >= 0 && t.z > 0 && t.z < nearest) {
                nearest = t.z;
                point = a + t.x * (glm::dvec3(mesh.positions[1]) - a) + t.y * (glm::dvec3(mesh.positions[2]) - a);
            }
        }
        if (edge < 1e-5) continue;
        const Hit hit = tracer.closest_hit(origin, direction);
        ASSERT_EQ(hit.found(), std::isfinite(nearest));
        EXPECT_EQ(transmitted(tracer, origin, direction), hit.found() ? 0 : 1);
        if (!hit.found()) continue;
        ++hits;
        EXPECT_NEAR(hit.distance, nearest, 1e-5 * nearest + 1e-5);
        const Surface surface = tracer.surface(hit, direction);
        EXPECT_LT(glm::distance(glm::dvec3(surface.position), point), 1e-5);
        EXPECT_EQ(surface.mesh, &scene.meshes[scene.placed[hit.id.geometry]]);
        EXPECT_NEAR(glm::length(surface.normal), 1, 1e-6);
        EXPECT_EQ(surface.front, glm::dot(surface.normal, direction) < 0);
    }
    EXPECT_GT(hits, 300);
}

TEST(Tracer, FrontIsCounterClockwiseAlsoInMirroredInstances) {
    Scene scene;
    const int material = add_grey(scene, 0.5F);
    const glm::vec3 x(1, 0, 0);
    const glm::vec3 y(0, 1, 0);
    const glm::vec3 z(0, 0, 1);
    add_quad(scene, material, {-1, -1, 0}, 2.0F * x, 2.0F * y);  // faces +z
    const int mesh = store_mesh(scene, material, {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}}, {{0, 1, 2}});
    add_instance(scene, mesh, {x, y, z, {10, 0, 0}});
    add_instance(scene, mesh, {x, y, -z, {20, 0, 0}});   // mirrored in its own plane: what was in front is now behind
    add_instance(scene, mesh, {-x, y, z, {30, 0, 0}});   // mirrored across: clockwise, but still the +z side
    add_instance(scene, mesh, {-x, y, -z, {40, 0, 0}});  // turned about y: faces -z
    const Tracer tracer(scene);
    const std::array<float, 5> normal_z = {1, 1, -1, 1, -1};
    const std::array<bool, 5> mirrored = {false, false, true, true, false};
    for (int i = 0; i < 5; ++i) {
        for (const float side : {1.0F, -1.0F}) {
            const glm::vec3 direction(0, 0, -side);
            const Hit hit = tracer.closest_hit({10.0F * i + (i > 2 ? -0.5F : 0.5F), -0.25F, 3 * side}, direction);
            ASSERT_TRUE(hit.found()) << i;
            // Embree divides with its processor's approximate reciprocal: the last bits differ between their makers.
            EXPECT_FLOAT_EQ(hit.distance, 3);
            const Surface surface = tracer.surface(hit, direction);
            EXPECT_EQ(surface.normal.z, normal_z[i]) << i;
            EXPECT_EQ(surface.front, side == normal_z[i]) << i;
            EXPECT_EQ(tracer.corners(hit.id).mirrored, mirrored[i]) << i;
            EXPECT_GT(side * surface.leave({0, 0, side}).z, 0) << "leaves on the side that the ray goes to";
            EXPECT_LT(side * surface.leave({0, 0, -side}).z, 0);
        }
    }
}

TEST(Tracer, InstancesAreWhereTheirTransformPutsThem) {
    RandomStream random(2);
    Scene placed;
    Scene instanced;
    const int material = add_grey(placed, 0.5F);
    add_grey(instanced, 0.5F);
    for (int i = 0; i < 20; ++i) {
        // Sheared, scaled unevenly, some of them mirrored.
        const glm::mat4x3 to_level(any_direction(random), 0.3F * any_direction(random), 2.0F * any_direction(random),
                                   10.0F * any_point(random));
        BoxShape box = box_shape(glm::vec3(-1), glm::vec3(1), Facing::outward);
        add_instance(instanced, store_mesh(instanced, material, box.positions, box.triangles), to_level);
        for (glm::vec3& p : box.positions) p = to_level * glm::vec4(p, 1);
        if (glm::determinant(glm::mat3(to_level)) < 0) {
            for (glm::uvec3& t : box.triangles) std::swap(t.y, t.z);
        }
        add_mesh(placed, material, box.positions, box.triangles);
    }
    const Tracer a(placed);
    const Tracer b(instanced);
    EXPECT_EQ(a.triangle_count(), b.triangle_count());
    int hits = 0;
    int different = 0;
    for (int i = 0; i < 5000; ++i) {
        const glm::vec3 origin = 10.0F * any_point(random);
        const glm::vec3 direction = any_direction(random);
        const Hit hit_a = a.closest_hit(origin, direction);
        const Hit hit_b = b.closest_hit(origin, direction);
        if (hit_a.found() != hit_b.found()) ++different;
        if (!hit_a.found() || !hit_b.found()) continue;
        ++hits;
        const Surface surface_a = a.surface(hit_a, direction);
        const Surface surface_b = b.surface(hit_b, direction);
        if (glm::distance(surface_a.position, surface_b.position) > 1e-3F) {
            ++different;  // grazed an edge
            continue;
        }
        EXPECT_NEAR(hit_a.distance, hit_b.distance, 1e-4);
        EXPECT_GT(glm::dot(surface_a.normal, surface_b.normal), 1 - 1e-4F);
        EXPECT_EQ(surface_a.front, surface_b.front);
    }
    EXPECT_GT(hits, 500);
    EXPECT_LE(different, 5);
}

TEST(Tracer, LimitsTheDistance) {
    Scene scene;
    add_quad(scene, add_grey(scene, 0.5F), {-1, 2, -1}, {0, 0, 2}, {2, 0, 0});
    const Tracer tracer(scene);
    const glm::vec3 up(0, 0.5F, 0);  // distances are in units of its length
    EXPECT_TRUE(tracer.closest_hit({0.1F, 0, 0}, up, 4.001F).found());
    EXPECT_FALSE(tracer.closest_hit({0.1F, 0, 0}, up, 3.999F).found());
    EXPECT_EQ(transmitted(tracer, {0.1F, 0, 0}, up, 4.001F), 0);
    EXPECT_EQ(transmitted(tracer, {0.1F, 0, 0}, up, 3.999F), 1);
    EXPECT_EQ(transmitted(tracer, {0.1F, 0, 0}, -up), 1);
}

/// A texture of one row: opaque black left, transparent right; nearest, so that the border is sharp.
int add_half_transparent(Scene& scene) {
    Texture texture;
    texture.image = {2, 1, {{255, 255, 255, 255}, {255, 255, 255, 0}}};
    texture.nearest = true;
    scene.textures.push_back(texture);
    return static_cast<int>(scene.textures.size()) - 1;
}

TEST(Tracer, MaskCutsHolesForAllRays) {
    Scene scene;
    Material material = grey(0.5F);
    material.alpha_mode = AlphaMode::mask;
    material.base_color_texture.texture = add_half_transparent(scene);
    const int masked = add_material(scene, material);
    const int solid = add_grey(scene, 0.5F);
    const int mesh = add_quad(scene, masked, {0, 1, 0}, {0, 0, 1}, {1, 0, 0});
    scene.meshes[mesh].uv_sets = {{{0, 0}, {0, 1}, {1, 1}, {1, 0}}};  // u along x
    add_quad(scene, solid, {-1, 3, -1}, {0, 0, 3}, {3, 0, 0});
    const Tracer tracer(scene);
    const glm::vec3 up(0, 1, 0);
    EXPECT_FLOAT_EQ(tracer.closest_hit({0.25F, 0, 0.4F}, up).distance, 1);
    EXPECT_FLOAT_EQ(tracer.closest_hit({0.75F, 0, 0.4F}, up).distance, 3);
    EXPECT_EQ(transmitted(tracer, {0.25F, 0, 0.4F}, up, 2), 0);
    EXPECT_EQ(transmitted(tracer, {0.75F, 0, 0.4F}, up, 2), 1);
    EXPECT_EQ(transmitted(tracer, {0.75F, 0, 0.4F}, up, 4), 0);
}

TEST(Tracer, TransmittanceIsTheProductOfWhatSurfacesPass) {
    Scene scene;
    const int half = add_material(scene, blend(0.9F, 0.5F));
    Material glass;
    glass.base_color = {1, 0.5F, 0};
    glass.transmission = 0.8F;
    const int tinted = add_material(scene, glass);
    glass.alpha_mode = AlphaMode::blend;
    glass.alpha = 0.25F;
    const int both = add_material(scene, glass);  // passes 1 - alpha + alpha t tint
    const int solid = add_grey(scene, 0.5F);
    const auto cover = [&](int material, float y) { add_quad(scene, material, {-1, y, -1}, {0, 0, 2}, {2, 0, 0}); };
    cover(half, 1);
    cover(tinted, 2);
    cover(both, 3);
    cover(half, 4);
    cover(solid, 5);
    const Tracer tracer(scene);
    const glm::vec3 origin(0.3F, 0, 0.1F);
    const glm::vec3 up(0, 1, 0);
    const glm::vec3 glass_share(0.8F, 0.4F, 0);
    const glm::vec3 both_share = glm::vec3(0.75F) + 0.25F * glass_share;
    const auto expect_near = [](glm::vec3 ours, glm::vec3 wanted) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(ours[c], wanted[c], 1e-6);
    };
    expect_near(tracer.transmittance(origin, up, 0.9F), glm::vec3(1));
    expect_near(tracer.transmittance(origin, up, 1.1F), glm::vec3(0.5F));
    expect_near(tracer.transmittance(origin, up, 2.1F), 0.5F * glass_share);
    expect_near(tracer.transmittance(origin, up, 3.1F), 0.5F * glass_share * both_share);
    expect_near(tracer.transmittance(origin, up, 4.1F), 0.25F * glass_share * both_share);
    expect_near(tracer.transmittance(origin, up, 5.1F), glm::vec3(0));
    expect_near(tracer.transmittance({0.3F, 6, 0.1F}, -up, infinity), glm::vec3(0));
    expect_near(tracer.transmittance({0.3F, 4.5F, 0.1F}, -up, 4), 0.25F * glass_share * both_share);
    EXPECT_FLOAT_EQ(tracer.closest_hit(origin, up).distance, 1) << "what passes light is a hit all the same";
}

TEST(Tracer, ASurfacePassesLightOnceAlsoAlongTheEdgesOfItsTriangles) {
    Scene scene;
    const int half = add_material(scene, blend(0.9F, 0.5F));
    add_quad(scene, half, {-1, 1, -1}, {0, 0, 2}, {2, 0, 0});       // the diagonal is over the origin
    add_sphere(scene, half, {10, 0, 0}, 1, Facing::outward, 4, 8);  // straight up is a vertex of eight triangles
    const int mesh = store_mesh(scene, half, {{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}}, {{0, 1, 2}, {0, 2, 3}});
    add_instance(scene, mesh, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {20, 1, 0}});
    const Tracer tracer(scene);
    const glm::vec3 up(0, 1, 0);
    EXPECT_EQ(transmitted(tracer, {0, 0, 0}, up), 0.5F);
    EXPECT_EQ(transmitted(tracer, {0.25F, 0, 0.25F}, up), 0.5F);
    EXPECT_EQ(transmitted(tracer, {10, 0, 0}, up), 0.5F);
    EXPECT_EQ(transmitted(tracer, {10, -2, 0}, up), 0.25F) << "in at the lower pole and out at the upper";
    EXPECT_EQ(transmitted(tracer, {20.25F, 0, 0.25F}, up), 0.5F);
    RandomStream random(3);
    for (int i = 0; i < 1000; ++i) {
        const float along = 2 * random.next() - 1;
        const glm::vec3 origin = 5.0F * any_point(random) - glm::vec3(0, 5, 0);
        const glm::vec3 direction = glm::vec3(along, 1, along) - origin;
        ASSERT_EQ(transmitted(tracer, origin, direction, 2), 0.5F) << "towards " << along << " along the diagonal";
    }
}

TEST(Tracer, CoincidentSurfacesOfTwoMeshesBothPassLight) {
    Scene scene;
    const int half = add_material(scene, blend(0.9F, 0.5F));
    add_quad(scene, half, {-1, 1, -1}, {0, 0, 2}, {2, 0, 0});
    add_quad(scene, half, {-1, 1, -1}, {0, 0, 2}, {2, 0, 0});
    const Tracer tracer(scene);
    EXPECT_EQ(transmitted(tracer, {0.5F, 0, 0.25F}, {0, 1, 0}), 0.25F);
    EXPECT_EQ(transmitted(tracer, {0, 0, 0}, {0, 1, 0}), 0.25F);
}

TEST(Tracer, ARayGoesOnBehindSurfacesThatPassLight) {
    Scene scene;
    const int half = add_material(scene, blend(0.9F, 0.5F));
    const int solid = add_grey(scene, 0.5F);
    const auto cover = [&](int material, float y) { add_quad(scene, material, {-1, y, -1}, {0, 0, 2}, {2, 0, 0}); };
    cover(half, 1);
    cover(half, 2);
    cover(half, 2);
    cover(half, 2);
    cover(half, 3);
    cover(solid, 3);  // a decal lies on it
    const Tracer tracer(scene);
    RandomStream random(13);
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 origin(0.5F * random.next() + 0.1F, 0, -0.5F * random.next());
        const glm::vec3 direction = glm::vec3(0, 1, 0) + 0.1F * any_point(random);
        std::vector<std::uint32_t> met;
        Hit hit;
        do {
            hit = tracer.closest_hit(origin, direction, infinity, hit);
            met.push_back(hit.id.geometry);
        } while (hit.found() && hit.id.geometry != 5);
        met.erase(std::remove(met.begin(), met.end(), 4U), met.end());  // before or behind what it lies on
        ASSERT_EQ(met, (std::vector<std::uint32_t>{0, 1, 2, 3, 5}));
    }
}

TEST(Tracer, RaysOfOnePointTogetherMeetWhatEachMeetsAlone) {
    Scene scene;
    RandomStream random(14);
    Material cut_out = grey(0.5F);
    cut_out.alpha_mode = AlphaMode::mask;
    cut_out.base_color_texture.texture = add_half_transparent(scene);
    Material glass;
    glass.base_color = {1, 0.5F, 0};
    glass.transmission = 0.8F;
    const std::array<int, 4> materials = {add_grey(scene, 0.5F), add_material(scene, cut_out),
                                          add_material(scene, blend(0.9F, 0.5F)), add_material(scene, glass)};
    for (int i = 0; i < 80; ++i) {
        const int mesh =
            add_quad(scene, materials[i % 4], 3.0F * any_point(random), any_point(random), any_point(random));
        scene.meshes[mesh].uv_sets = {{{0, 0}, {0, 1}, {1, 1}, {1, 0}}};
        if (i % 8 > 3) add_instance(scene, mesh, {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}, any_point(random)});
    }
    add_quad(scene, materials[0], {-1e5F, -4, -1e5F}, {0, 0, 2e5F}, {2e5F, 0, 0});  // huge: checked by a filter
    const Tracer tracer(scene);
    int hits = 0;
    int shaded = 0;
    for (std::size_t count = 0; count < 200; ++count) {
        const glm::vec3 origin = 3.0F * any_point(random);
        std::vector<glm::vec3> directions;
        std::vector<Tracer::Way> ways;
        for (std::size_t i = 0; i < count; ++i) {
            directions.push_back(any_direction(random) * (0.1F + random.next()));
            ways.push_back({any_direction(random), i % 3 == 0 ? infinity : 4 * random.next()});
        }
        std::vector<Hit> together(count);
        std::vector<glm::vec3> shares(count);
        tracer.closest_hits(origin, directions, together);
        tracer.transmittances(origin, ways, shares);
        for (std::size_t i = 0; i < count; ++i) {
            const Hit alone = tracer.closest_hit(origin, directions[i]);
            ASSERT_EQ(together[i].id, alone.id);
            if (alone.found()) {
                ++hits;
                ASSERT_NEAR(together[i].distance / alone.distance, 1, 1e-5);
                ASSERT_LT(glm::distance(together[i].barycentric, alone.barycentric), 1e-4);
                ASSERT_NEAR(glm::dot(glm::normalize(together[i].normal), glm::normalize(alone.normal)), 1, 1e-6);
            }
            const glm::vec3 share = tracer.transmittance(origin, ways[i].direction, ways[i].max_distance);
            shaded += share != glm::vec3(0) && share != glm::vec3(1) ? 1 : 0;
            ASSERT_LT(glm::distance(shares[i], share), 1e-6F);
        }
    }
    EXPECT_GT(hits, 10000);
    EXPECT_GT(shaded, 500);
}

/// Follows rays that start on one triangle of the scene, both sides, all directions: they must not meet it again.
void expect_no_self_hits(const Scene& scene, glm::vec3 target, float reach, const std::string& what) {
    const Tracer tracer(scene);
    RandomStream random(4);
    int starts = 0;
    int shadows = 0;
    int hits = 0;
    for (int i = 0; i < 4000; ++i) {
        const glm::vec3 in = any_direction(random);
        const Hit hit = tracer.closest_hit(target - reach * in + 0.01F * reach * any_point(random), in);
        if (!hit.found()) continue;
        const Surface surface = tracer.surface(hit, in);
        ++starts;
        for (int k = 0; k < 8; ++k) {
            glm::vec3 out = any_direction(random);
            if (k > 4) out = glm::normalize(out - glm::dot(out, surface.normal) * surface.normal * 0.9999F);  // grazing
            if (transmitted(tracer, surface.leave(out), out) != 1) ++shadows;
            if (tracer.closest_hit(surface.leave(out), out).found()) ++hits;
        }
    }
    EXPECT_GT(starts, 500) << what;
    EXPECT_EQ(shadows, 0) << what;
    EXPECT_EQ(hits, 0) << what;
}

TEST(Tracer, NoRayMeetsTheTriangleThatItLeaves) {
    RandomStream random(5);
    for (const float size : {1e-4F, 1.0F, 1e4F}) {
        for (const float away : {0.0F, 1.0F, 1e3F, 1e5F}) {
            for (int k = 0; k < 5; ++k) {
                Scene scene;
                const glm::vec3 center = away * any_point(random);
                const glm::vec3 a = size * any_point(random);
                const glm::vec3 b = size * any_point(random);
                add_triangle(scene, add_grey(scene, 0.5F), center + a, center + b, center - a - b);
                // Smaller than the grid of floats at its place, it is a point or a line.
                if (size < 64 * away * 0x1p-23F) continue;
                expect_no_self_hits(scene, center, size,
                                    "size " + std::to_string(size) + " at " + std::to_string(away));
            }
        }
    }
}

TEST(Tracer, NoRayMeetsTheInstancedTriangleThatItLeaves) {
    RandomStream random(6);
    for (const float scale : {1e-3F, 1.0F, 1e3F}) {
        for (const float away : {0.0F, 1.0F, 1e3F}) {
            for (const float local_away : {0.0F, 10.0F}) {
                for (int k = 0; k < 5; ++k) {
                    Scene scene;
                    const glm::vec3 a = any_point(random);
                    const glm::vec3 b = any_point(random);
                    const glm::vec3 middle = local_away * any_point(random);
                    const glm::mat3 axes = random_rotation(static_cast<std::uint64_t>(k)) * scale *
                                           glm::mat3(1, 0, 0, 0, 0.1F, 0, 0, 0, 3) * random_rotation(100 + k);
                    const int mesh =
                        store_mesh(scene, add_grey(scene, 0.5F), {middle + a, middle + b, middle - a - b}, {{0, 1, 2}});
                    const glm::mat4x3 to_level(axes[0], axes[1], axes[2], away * any_point(random));
                    add_instance(scene, mesh, to_level);
                    if (0.1F * scale < 256 * away * 0x1p-23F) continue;
                    expect_no_self_hits(scene, to_level * glm::vec4(middle, 1), scale,
                                        "scale " + std::to_string(scale) + " at " + std::to_string(away));
                }
            }
        }
    }
}

TEST(Tracer, NoRayLeavesAClosedMeshThroughEdgesOrVertices) {
    for (const glm::vec3 center : {glm::vec3(0), glm::vec3(1000, -300, 77)}) {
        Scene scene;
        const int material = add_grey(scene, 0.5F);
        const int mesh = add_sphere(scene, material, center, 3, Facing::inward, 12, 24);
        const Tracer tracer(scene);
        RandomStream random(7);
        const std::vector<glm::vec3>& corners = scene.meshes[mesh].positions;
        for (int i = 0; i < 20000; ++i) {
            const glm::vec3 origin = center + any_point(random);
            const glm::uvec3 triangle =
                scene.meshes[mesh].triangles[static_cast<std::size_t>(i) % scene.meshes[mesh].triangles.size()];
            const float t = i % 3 == 0 ? 0 : random.next();
            const glm::vec3 target = glm::mix(corners[triangle.x], corners[triangle.y], t);
            ASSERT_TRUE(tracer.closest_hit(origin, target - origin).found()) << i;
            ASSERT_EQ(transmitted(tracer, origin, target - origin), 0) << i;
        }
    }
}

/// A path that is reflected a million times inside a closed mesh is still inside.
void expect_tight(const Scene& scene, glm::vec3 start, int bounces) {
    const Tracer tracer(scene);
    RandomStream random(8);
    glm::vec3 origin = start;
    glm::vec3 direction = any_direction(random);
    int escaped = 0;
    int from_outside = 0;
    for (int i = 0; i < bounces; ++i) {
        const Hit hit = tracer.closest_hit(origin, direction);
        if (!hit.found()) {
            ++escaped;
            origin = start;
            direction = any_direction(random);
            continue;
        }
        const Surface surface = tracer.surface(hit, direction);
        if (!surface.front) ++from_outside;
        direction = cosine_direction(surface.front ? surface.normal : -surface.normal, random.next2());
        origin = surface.leave(direction);
    }
    EXPECT_EQ(escaped, 0);
    EXPECT_EQ(from_outside, 0);
}

TEST(Tracer, PathsStayInsideAClosedBox) {
    Scene scene;
    add_box(scene, add_grey(scene, 0.5F), {-1, -2, -3}, {4, 5, 6}, Facing::inward);
    expect_tight(scene, {0, 0, 0}, 1000000);
}

TEST(Tracer, PathsStayInsideAClosedSphereFarAway) {
    Scene scene;
    add_sphere(scene, add_grey(scene, 0.5F), {1e4F, 2e4F, -1e4F}, 50, Facing::inward);
    expect_tight(scene, {1e4F, 2e4F, -1e4F}, 300000);
}

TEST(Tracer, PathsStayInsideAnInstancedTurnedBox) {
    Scene scene;
    const BoxShape box = box_shape({-1, -2, -3}, {4, 5, 6}, Facing::inward);
    const int mesh = store_mesh(scene, add_grey(scene, 0.5F), box.positions, box.triangles);
    const glm::mat3 axes = random_rotation(5) * 0.37F;
    add_instance(scene, mesh, {axes[0], axes[1], axes[2], {100, 20, -30}});
    expect_tight(scene, {100, 20, -30}, 300000);
}

/// Ground of 1e5 m under a box of 1 cm.
Scene huge_beside_tiny(glm::mat3 turned) {
    Scene scene;
    const int material = add_grey(scene, 0.5F);
    add_quad(scene, material, turned * glm::vec3(-5e4F, 0, -5e4F), turned * glm::vec3(0, 0, 1e5F),
             turned * glm::vec3(1e5F, 0, 0));
    for (int i = 0; i < 100; ++i) {  // so that the tiny ones are the common ones
        BoxShape box = box_shape({0.02F * i, 0.001F, 0.5F}, {0.02F * i + 0.01F, 0.011F, 0.51F}, Facing::outward);
        for (glm::vec3& p : box.positions) p = turned * p;
        add_mesh(scene, material, box.positions, box.triangles);
    }
    return scene;
}

TEST(Tracer, HugeTrianglesDoNotCoverTinyNeighbours) {
    for (const glm::mat3& turned : {glm::mat3(1), random_rotation(9)}) {
        const Scene scene = huge_beside_tiny(turned);
        const Tracer tracer(scene);
        const glm::vec3 up = turned * glm::vec3(0, 1, 0);
        RandomStream random(10);
        int wrong = 0;
        int blocked = 0;
        for (int i = 0; i < 20000; ++i) {
            // From the ground under and beside the boxes, 1 mm below them; from their lower sides back to the ground.
            const glm::vec2 where = random.next2();
            const glm::vec3 start = turned * glm::vec3(2 * where.x, 0.02F, 0.45F + 0.1F * where.y);
            const Hit down = tracer.closest_hit(start, -up);
            if (!down.found()) {
                ++wrong;
                continue;
            }
            const Surface surface = tracer.surface(down, -up);
            const glm::vec3 out = cosine_direction(surface.front ? surface.normal : -surface.normal, random.next2());
            const Hit next = tracer.closest_hit(surface.leave(out), out);
            const float passed = tracer.transmittance(surface.leave(out), out, infinity).x;
            // Only a box can be above the ground, and only the ground below a box.
            const bool on_ground = down.id.geometry == 0;
            if (next.found() && on_ground && next.id.geometry == 0) ++wrong;
            if ((passed == 0) != next.found()) ++wrong;
            blocked += on_ground && next.found() ? 1 : 0;
        }
        EXPECT_EQ(wrong, 0);
        EXPECT_GT(blocked, 100);
    }
}

TEST(Tracer, DuplicateHugeTrianglesDoNotTrapLight) {
    Scene scene = huge_beside_tiny(random_rotation(9));
    add_mesh(scene, 0, scene.meshes[0].positions, scene.meshes[0].triangles);
    const Tracer tracer(scene);
    const glm::vec3 up = random_rotation(9) * glm::vec3(0, 1, 0);
    RandomStream random(11);
    int wrong = 0;
    for (int i = 0; i < 20000; ++i) {
        const glm::vec2 where = random.next2();
        const glm::vec3 start = random_rotation(9) * glm::vec3(100 * where.x + 10, 1, 100 * where.y + 10);
        const Hit down = tracer.closest_hit(start, -up);
        ASSERT_TRUE(down.found());
        const Surface surface = tracer.surface(down, -up);
        const glm::vec3 out = cosine_direction(surface.front ? surface.normal : -surface.normal, random.next2());
        if (tracer.closest_hit(surface.leave(out), out).found()) ++wrong;
        if (tracer.transmittance(surface.leave(out), out, infinity) != glm::vec3(1)) ++wrong;
    }
    EXPECT_EQ(wrong, 0);
}

TEST(Tracer, ASurfaceThatTheRayStartsExactlyOnIsNotMet) {
    for (const float size : {1e-3F, 1.0F, 1e4F}) {
        Scene scene;
        add_box(scene, add_grey(scene, 0.5F), glm::vec3(-size), glm::vec3(size), Facing::outward);
        const Tracer tracer(scene);
        RandomStream random(14);
        for (const glm::vec3 on : {glm::vec3(1, 0, 0.3F), glm::vec3(1, 1, 0.3F), glm::vec3(1, 1, 1)}) {
            for (int i = 0; i < 1000; ++i) {
                const glm::vec3 direction = any_direction(random);
                bool leaves = false;
                for (int axis = 0; axis < 3; ++axis) leaves = leaves || (on[axis] == 1 && direction[axis] > 0);
                ASSERT_EQ(tracer.closest_hit(size * on, direction).found(), !leaves);
                ASSERT_EQ(transmitted(tracer, size * on, direction), leaves ? 1 : 0);
            }
        }
    }
}

TEST(Tracer, ALevelWithoutSurfacesIsEmptySpace) {
    const Scene scene;
    const Tracer tracer(scene);
    EXPECT_EQ(tracer.triangle_count(), 0U);
    EXPECT_FALSE(tracer.closest_hit({0, 0, 0}, {0, 1, 0}).found());
    EXPECT_EQ(transmitted(tracer, {0, 0, 0}, {0, 1, 0}), 1);
}

TEST(Tracer, TrianglesWithoutAreaAreNotThere) {
    Scene scene;
    const int material = add_grey(scene, 0.5F);
    add_triangle(scene, material, {0, 1, 0}, {0, 1, 0}, {0, 1, 0});
    add_triangle(scene, material, {-1, 1, -1.1F}, {0.3F, 1, 0.33F}, {1.6F, 1, 1.76F});  // on a line but for rounding
    add_triangle(scene, material, {0.1F, 1, 0}, {0.1F, 1, 0}, {0.7F, 1, 0.3F});
    const Tracer tracer(scene);
    RandomStream random(12);
    for (int i = 0; i < 100000; ++i) {
        const float t = random.next();
        const glm::vec3 target = i % 2 == 0 ? glm::mix(glm::vec3(-1, 1, -1.1F), glm::vec3(1.6F, 1, 1.76F), t)
                                            : glm::mix(glm::vec3(0.1F, 1, 0), glm::vec3(0.7F, 1, 0.3F), t);
        const glm::vec3 origin = any_point(random) - glm::vec3(0, 1, 0);
        const Hit hit = tracer.closest_hit(origin, target - origin);
        if (!hit.found()) continue;
        const Surface surface = tracer.surface(hit, target - origin);  // one that rounding gave some area
        ASSERT_TRUE(std::isfinite(surface.normal.x)) << hit.id.geometry;
        ASSERT_NEAR(glm::length(surface.normal), 1, 1e-5);
    }
}

TEST(Tracer, RefusesAnInstanceWithoutAnInverse) {
    // Embree would abort on its rays. The loader lets flat things stand in the level itself.
    for (const float thickness : {0.0F, 1e-30F, 1e-10F}) {
        Scene scene;
        const BoxShape box = box_shape(glm::vec3(-1), glm::vec3(1), Facing::outward);
        const int mesh = store_mesh(scene, add_grey(scene, 0.5F), box.positions, box.triangles);
        add_instance(scene, mesh, {{1, 0, 0}, {0, thickness, 0}, {0, 0, 1}, {0, 5, 0}});
        EXPECT_THROW(Tracer{scene}, Error);
    }
}

TEST(Tracer, RefusesAMeshThatEmbreeWouldReadBeyond) {
    Scene scene;
    add_triangle(scene, add_grey(scene, 0.5F), {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    scene.meshes[0].positions.shrink_to_fit();
    EXPECT_THROW(Tracer{scene}, Error);
}

}  // namespace
}  // namespace lightgrid
