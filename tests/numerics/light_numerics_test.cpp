#include "core/gltf.h"
#include "probes/bake.h"
#include "probes/placement.h"
#include "probes/sampler.h"
#include "tests/cached_light.h"
#include "tests/gltf_builder.h"
#include "tests/numerics/naive_light.h"
#include "tests/numerics/numerics_row.h"
#include "tests/polygon_light.h"
#include "tests/scene_builder.h"

#include <cmath>
#include <numbers>

namespace lightgrid {
namespace {

using std::numbers::pi;

const Environment no_sky;
const Environment white_sky = Environment::uniform(glm::vec3(1));

GatherOptions options_for(glm::vec3 normal, std::uint32_t samples) {
    GatherOptions options;
    options.samples = samples;
    options.replicates = 32;
    options.normals = {normal};
    return options;
}

/// The same cases by paths and by the surface cache.
class LightNumerics : public testing::TestWithParam<Method> {
  protected:
    /// patch  metres, the width of a cache's patches
    [[nodiscard]] static Gather light_at(const Scene& scene, const Environment& sky, glm::vec3 point, glm::vec3 normal,
                                         std::uint32_t samples = 16384, float patch = 0.25F) {
        const Tracer tracer(scene);
        const PathTracer paths(tracer, sky);
        const GatherOptions options = options_for(normal, samples);
        PathCounts counts;
        const Gather light = GetParam() == Method::path
                                 ? gather(paths, {point}, options, &counts)
                                 : gather_by_cache(paths, {point}, {.width = patch}, options, &counts);
        EXPECT_EQ(counts.dropped, 0U) << "samples that were not finite";
        return light;
    }

    [[nodiscard]] static double irradiance_at(const Scene& scene, const Environment& sky, glm::vec3 point,
                                              glm::vec3 normal, std::uint32_t samples = 16384, float patch = 0.25F) {
        return light_at(scene, sky, point, normal, samples, patch).irradiance[0].mean.x;
    }

    /// naive  what a textbook implementation gives, whatever our method
    static void row(const std::string& name, double exact, double ours, double error, double tolerance,
                    const std::string& naive = "-") {
        if (GetParam() == Method::path) {
            numerics_row(name, exact, ours, error, tolerance, naive);
        } else {
            numerics_row("by cache: " + name, exact, ours, error, tolerance);
        }
    }

    /// A row whose value has a standard error: it may be off by three of them, and they are below half a percent.
    static void estimate_row(const std::string& name, double exact, const Estimate& ours,
                             const std::string& naive = "-") {
        EXPECT_LE(ours.error.x, 0.005 * exact) << name;
        row(name, exact, ours.mean.x, std::abs(ours.mean.x - exact) / exact, std::max(3 * ours.error.x / exact, 1e-5),
            naive);
    }
};

INSTANTIATE_TEST_SUITE_P(, LightNumerics, testing::Values(Method::path, Method::cache),
                         [](const auto& method) { return std::string(name_of(method.param)); });

TEST_P(LightNumerics, WhiteFurnaceOfHighAlbedo) {
    for (const float albedo : {0.5F, 0.9F, 0.99F}) {
        Scene scene;
        add_box(scene, add_grey(scene, albedo, 1), {-1, -2, -3}, {1, 1, 2}, Facing::inward);
        const Gather light = light_at(scene, no_sky, {0.3F, 0.5F, -1}, {0, 1, 0}, 32768);
        const double naive = pi * (1 - std::pow(albedo, 9)) / (1 - albedo);
        estimate_row(fmt::format("white furnace, albedo {}: E, lx", albedo), pi / (1 - static_cast<double>(albedo)),
                     light.irradiance[0], fmt::format("8 bounces: {:.4g}", naive));
    }
}

TEST_P(LightNumerics, AlbedoZeroOneAndAbove) {
    // A convex body under a uniform sky of 1 has its albedo as radiance; inside a white bowl all is as bright as the
    // sky.
    for (const float albedo : {0.0F, 1.0F, 2.0F}) {
        Scene body;
        add_box(body, add_grey(body, albedo), glm::vec3(-1), glm::vec3(1), Facing::outward);
        const std::vector<glm::dvec3> top = {{-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}};
        const double covered = polygon_irradiance(top, {0, 1.5, 0}, {0, 1, 0});
        const Gather light = light_at(body, white_sky, {0, 1.5F, 0}, {0, -1, 0}, 65536);
        estimate_row(fmt::format("body of albedo {} under a sky of 1: E from below, lx", albedo),
                     pi - covered * (1 - std::min(albedo, max_albedo)), light.irradiance[0]);
    }
    for (const float albedo : {1.0F, 2.0F}) {
        Scene bowl;
        const int mesh = add_box(bowl, add_grey(bowl, albedo), glm::vec3(-1), glm::vec3(1), Facing::inward);
        std::vector<glm::uvec3>& sides = bowl.meshes[mesh].triangles;
        sides.erase(sides.begin() + 6, sides.begin() + 8);  // +y
        const double ours = irradiance_at(bowl, white_sky, {0, 0, 0}, {0, -1, 0});
        // Clamped to 0.9999, and a path is reflected some five times: 1e-3 too dark at most.
        row(fmt::format("bowl of albedo {} under a sky of 1: E from below, lx", albedo), pi, ours,
            std::abs(ours / pi - 1), 1e-3);
    }
}

/// A room of 4 x 3 x 5 m with a lamp of 60 cm and a crate, in grey of one half; all lengths times `scale`.
Scene room(float scale, glm::vec3 shift = glm::vec3(0)) {
    Scene scene;
    const int grey = add_grey(scene, 0.5F);
    const int lamp = add_grey(scene, 0.5F, 10);
    const auto at = [&](float x, float y, float z) { return scale * glm::vec3(x, y, z) + shift; };
    add_box(scene, grey, at(-2, -1.5F, -2.5F), at(2, 1.5F, 2.5F), Facing::inward);
    add_box(scene, grey, at(0.5F, -1.4F, 0.2F), at(1.3F, -0.5F, 1.1F), Facing::outward);
    const glm::vec3 corner = at(-0.3F, 1.45F, -0.3F);
    add_quad(scene, lamp, corner, at(0.3F, 1.45F, -0.3F) - corner, at(-0.3F, 1.45F, 0.3F) - corner);
    return scene;
}

const glm::vec3 room_point(-0.4F, -0.9F, 0.6F);
const glm::vec3 room_normal = glm::normalize(glm::vec3(0.2F, 1, -0.3F));
constexpr std::uint32_t room_samples = 32768;

TEST_P(LightNumerics, TheSameLevelAtAnyScale) {
    const Gather reference = light_at(room(1), no_sky, room_point, room_normal, room_samples);
    const Estimate& exact = reference.irradiance[0];
    for (const float scale : {1e-4F, 1e-2F, 1e2F, 1e4F}) {
        const Scene scene = room(scale);
        const double ours = irradiance_at(scene, no_sky, scale * room_point, room_normal, room_samples, scale * 0.25F);
        const std::string naive =
            scale > 1e-3F ? "-"
                          : fmt::format("rays start 1 mm off a surface: {:.3g}",
                                        naive_irradiance(Tracer(scene), scale * room_point, room_normal, {}));
        row(fmt::format("a room times {:g}, against itself times 1: E, lx", scale), exact.mean.x, ours,
            std::abs(ours / exact.mean.x - 1), 3 * exact.error.x / exact.mean.x, naive);
    }
}

/// The scene as glTF, one node for each mesh, moved by `translation`.
GltfBuilder as_gltf(const Scene& scene, glm::dvec3 translation) {
    GltfBuilder builder;
    builder.use("KHR_materials_emissive_strength");
    for (const Material& material : scene.materials) {
        const glm::vec3 c = material.base_color;
        nlohmann::json json = {{"pbrMetallicRoughness", {{"baseColorFactor", {c.x, c.y, c.z, 1}}}}};
        if (material.emits()) {
            json["emissiveFactor"] = {1, 1, 1};
            json["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = material.emission.x;
        }
        builder.add("materials", json);
    }
    builder.json["scenes"][0]["nodes"].clear();
    for (const Mesh& mesh : scene.meshes) {
        std::vector<std::uint32_t> indices;
        for (const glm::uvec3& t : mesh.triangles) indices.insert(indices.end(), {t.x, t.y, t.z});
        const int added = builder.mesh({{"attributes", {{"POSITION", builder.vec3s(mesh.positions)}}},
                                        {"indices", builder.indices(indices)},
                                        {"material", mesh.material}});
        builder.json["scenes"][0]["nodes"].push_back(
            builder.node({{"mesh", added}, {"translation", {translation.x, translation.y, translation.z}}}));
    }
    return builder;
}

TEST_P(LightNumerics, TheSameLevelFarAway) {
    // A doll's house of 40 x 30 x 50 cm, at the origin and 100 km from it.
    const glm::dvec3 away(1e5, -1e5, 1e5 + 0.3);
    const Scene doll = room(0.1F);
    const auto at = [&](glm::dvec3 shift) {
        const TemporaryFolder folder;
        write_bytes(folder.path() / "moved.glb", as_gltf(doll, shift).glb());
        const Scene scene = load_level(folder.path() / "moved.glb");
        const glm::vec3 point(glm::dvec3(0.1F * room_point) + shift - scene.origin);
        return light_at(scene, no_sky, point, room_normal, room_samples, 0.025F).irradiance[0];
    };
    const Estimate exact = at(glm::dvec3(0));
    const Estimate ours = at(away);
    const Scene in_float = room(0.1F, glm::vec3(away));
    const double naive =
        irradiance_at(in_float, no_sky, 0.1F * room_point + glm::vec3(away), room_normal, room_samples);
    row("a doll's house 1e5 m away, against itself at the origin: E, lx", exact.mean.x, ours.mean.x,
        std::abs(ours.mean.x / exact.mean.x - 1), 1e-4, fmt::format("world positions in float: {:.3g}", naive));
}

TEST_P(LightNumerics, LightFromFaintToBright) {
    const double reference = irradiance_at(room(1), no_sky, room_point, room_normal, 4096);
    for (const float factor : {1e-8F, 1e-4F, 1e4F, 1e8F}) {
        Scene scene = room(1);
        scene.materials[1].emission *= factor;
        const double ours = irradiance_at(scene, no_sky, room_point, room_normal, 4096);
        const double exact = reference * factor;
        row(fmt::format("light times {:g}, against light times 1: E, lx", factor), exact, ours,
            std::abs(ours / exact - 1), 1e-5);
        const double under_sky = irradiance_at(scene, Environment::uniform(glm::vec3(factor)), {0, 10, 0}, {0, 1, 0});
        row(fmt::format("sky of {:g} cd/m^2: E, lx", factor), pi * factor, under_sky,
            std::abs(under_sky / (pi * factor) - 1), 1e-4);
    }
}

TEST_P(LightNumerics, OneHotPixelInTheSky) {
    constexpr int width = 1024;
    constexpr int height = 512;
    constexpr double dim = 0.01;
    constexpr double hot = 1e6;
    constexpr int column = 700;
    constexpr int row = 150;
    RadianceImage image{width, height, std::vector<glm::vec3>(width * height, glm::vec3(dim))};
    image.at(column, row) = glm::vec3(hot);
    const Environment sky = Environment::from_image(image);
    // The pixel is a tent over its neighbours in both angles; u grows from +X towards +Z around the centre column.
    const auto direction = [&](double x, double y) {
        const double azimuth = 2 * pi * (x - width / 2.0) / width;
        const double polar = pi * y / height;
        return glm::dvec3(std::sin(polar) * std::cos(azimuth), std::cos(polar), std::sin(polar) * std::sin(azimuth));
    };
    const glm::dvec3 normal = glm::normalize(direction(column + 0.5, row + 0.5) + glm::dvec3(0.5, 0, 0));
    constexpr int cells = 400;
    double exact = pi * dim;
    for (int i = 0; i < cells; ++i) {
        for (int k = 0; k < cells; ++k) {
            const double x = -1 + 2 * (i + 0.5) / cells;
            const double y = -1 + 2 * (k + 0.5) / cells;
            const glm::dvec3 d = direction(column + 0.5 + x, row + 0.5 + y);
            const double solid_angle =
                2 * pi / width * (2.0 / cells) * pi / height * (2.0 / cells) * std::sin(pi * (row + 0.5 + y) / height);
            exact +=
                (hot - dim) * (1 - std::abs(x)) * (1 - std::abs(y)) * std::max(0.0, glm::dot(d, normal)) * solid_angle;
        }
    }
    double naive = 0;
    RandomStream random(2);
    for (int i = 0; i < 16384; ++i) {
        const glm::vec3 d = sphere_direction(random.next2());
        naive += 4 * pi / 16384 * sky.radiance(d).x * std::max(0.0F, glm::dot(d, glm::vec3(normal)));
    }
    const Gather light = light_at({}, sky, {0, 0, 0}, glm::vec3(normal));
    estimate_row("one pixel of 1e6 in a sky of 0.01, 1024 x 512: E, lx", exact, light.irradiance[0],
                 fmt::format("as many uniform directions: {:.3g}", naive));
}

TEST_P(LightNumerics, ATinyLampInALargeRoom) {
    Scene scene;
    add_box(scene, add_grey(scene, 0), glm::vec3(-5), glm::vec3(5), Facing::inward);
    add_quad(scene, add_grey(scene, 0, 1e9F), {1, 4.99F, 2}, {1e-3F, 0, 0}, {0, 0, 1e-3F});
    std::vector<glm::dvec3> corners;  // as they are rounded
    for (const glm::vec3& corner : scene.meshes[1].positions) corners.emplace_back(corner);
    const glm::dvec3 point(-4, -4.5, -3);
    const glm::dvec3 normal = glm::normalize(glm::dvec3(1, 1, 1));
    const double exact = 1e9 * polygon_irradiance(corners, point, normal);
    const Gather light = light_at(scene, no_sky, glm::vec3(point), glm::vec3(normal));
    estimate_row("lamp of 1 mm^2 and 1e9 cd/m^2 in a room of 10 m: E, lx", exact, light.irradiance[0],
                 fmt::format("met by chance, 65,536 paths: {:.3g}",
                             naive_irradiance(Tracer(scene), glm::vec3(point), glm::vec3(normal), {})));
}

TEST_P(LightNumerics, WallsOfOneMillimetre) {
    // A lit and a dark room, and a tight box in the brightest of skies.
    Scene rooms;
    const int grey = add_grey(rooms, 0.8F);
    add_box(rooms, grey, {-8, -2, -2}, {8, 2, 2}, Facing::inward);
    add_box(rooms, grey, {-5e-4F, -2.01F, -2.01F}, {5e-4F, 2.01F, 2.01F}, Facing::outward);
    add_quad(rooms, add_grey(rooms, 0, 1000), {-2, 1.9F, -1}, {1, 0, 0}, {0, 0, 1});
    const double dark = irradiance_at(rooms, no_sky, {0.01F, 0.3F, 0.2F}, {-1, 0, 0}, 65536);
    row("dark room 1 cm behind a wall of 1 mm: E, lx", 0, dark, dark, 0);

    Scene box;
    const int paint = add_grey(box, 0.9F);
    add_box(box, paint, glm::vec3(-1), glm::vec3(1), Facing::inward);
    add_box(box, paint, glm::vec3(-1.001F), glm::vec3(1.001F), Facing::outward);
    const double inside = irradiance_at(box, Environment::uniform(glm::vec3(1e8F)), {0, 0, 0}, {0, 1, 0}, 65536);
    row("box of 1 mm under a sky of 1e8: E inside, lx", 0, inside, inside, 0);
}

TEST_P(LightNumerics, ProbesOnFacesEdgesAndVertices) {
    Scene scene;
    add_box(scene, add_grey(scene, 0), glm::vec3(-1), glm::vec3(1), Facing::outward);
    const std::array<std::pair<const char*, glm::vec3>, 3> places = {
        {{"a face", {1, 0.3F, -0.2F}}, {"an edge", {1, 1, -0.2F}}, {"a vertex", {1, 1, 1}}}};
    double hidden = 0.5;
    for (const auto& [name, place] : places) {
        const Gather light = light_at(scene, white_sky, place, {1, 0, 0});
        estimate_row(fmt::format("probe exactly on {} of a black box under a sky of 1: L_0", name),
                     (1 - hidden) * 2 * std::sqrt(pi), light.sh(0)[0]);
        hidden /= 2;
    }
}

TEST_P(LightNumerics, TrianglesWithoutAreaSliversAndDuplicates) {
    Scene scene;
    Material wall;
    wall.base_color = glm::vec3(0.5F);
    wall.emission = glm::vec3(1);
    wall.double_sided = true;
    const int material = add_material(scene, wall);
    const int box = add_box(scene, material, {-1, -2, -3}, {1, 1, 2}, Facing::inward);
    add_mesh(scene, material, scene.meshes[box].positions, scene.meshes[box].triangles);
    RandomStream random(3);
    const auto any = [&] { return glm::vec3(random.next(), random.next(), random.next()) - 0.5F; };
    for (int i = 0; i < 100; ++i) {
        const glm::vec3 a = any();
        const glm::vec3 b = any();
        add_triangle(scene, material, a, a, a);
        add_triangle(scene, material, a, b, 0.5F * (a + b));
        add_triangle(scene, material, a, b, b + 1e-7F * any());
        add_triangle(scene, material, a, b, a + 1e-4F * any());
    }
    const Gather light = light_at(scene, no_sky, {0.3F, 0.5F, -1}, {0, 1, 0}, 32768);
    estimate_row("white furnace with doubled walls, 100 points, 100 lines, 200 slivers: E, lx", 2 * pi,
                 light.irradiance[0]);
}

TEST_P(LightNumerics, HugeTrianglesBesideTinyOnes) {
    // Ground of 1e5 m with albedo one half under a sky of 1, a few tiny crates on it, a probe 1 cm above.
    std::size_t k = 0;
    for (const glm::mat3& turned : {glm::mat3(1), random_rotation(7)}) {
        Scene scene;
        const int grey = add_grey(scene, 0.5F);
        add_quad(scene, grey, turned * glm::vec3(-4e4F, 0, -3e4F), turned * glm::vec3(0, 0, 1e5F),
                 turned * glm::vec3(1e5F, 0, 0));
        for (int i = 0; i < 100; ++i) {
            BoxShape crate = box_shape({10 + 0.02F * i, 0, 0}, {10.01F + 0.02F * i, 0.01F, 0.01F}, Facing::outward);
            for (glm::vec3& p : crate.positions) p = turned * p;
            add_mesh(scene, grey, crate.positions, crate.triangles);
        }
        const Gather light = light_at(scene, white_sky, turned * glm::vec3(0, 0.01F, 0), turned * glm::vec3(0, -1, 0));
        estimate_row(fmt::format("1 cm above {} ground of 1e5 m beside crates of 1 cm: E from below, lx",
                                 k++ == 0 ? "level" : "sloping"),
                     pi / 2, light.irradiance[0]);
    }
}

TEST_P(LightNumerics, OpenAndInvertedShells) {
    // Both sides of a surface reflect: a room lights its inside alike whichever way its walls are wound.
    Scene scene = room(1);
    const Gather proper = light_at(scene, no_sky, room_point, room_normal, room_samples);
    for (std::size_t mesh = 0; mesh < 2; ++mesh) {
        for (glm::uvec3& t : scene.meshes[mesh].triangles) std::swap(t.y, t.z);
    }
    const double inverted = irradiance_at(scene, no_sky, room_point, room_normal, room_samples);
    const Estimate& exact = proper.irradiance[0];
    row("room wound inside out, against the proper one: E, lx", exact.mean.x, inverted,
        std::abs(inverted / exact.mean.x - 1), 3 * exact.error.x / exact.mean.x);

    Scene tray;
    const int mesh = add_box(tray, add_grey(tray, 0), {-1, -1, -1}, {1, 0, 1}, Facing::outward);
    std::vector<glm::uvec3>& sides = tray.meshes[mesh].triangles;
    sides.erase(sides.begin() + 6, sides.begin() + 8);  // +y
    const Gather light = light_at(tray, white_sky, {0.2F, 0, 0.1F}, {1, 0, 0});
    estimate_row("black open shell wound inside out, at the height of its rim: E sideways, lx", pi / 2,
                 light.irradiance[0]);
}

TEST(Placement, ProbesOnFacesEdgesAndVerticesAreMoved) {
    Scene scene;
    add_box(scene, add_grey(scene, 0), glm::vec3(-1), glm::vec3(1), Facing::outward);
    Volume volume = make_volume({{glm::dvec3(-2), glm::dvec3(1), glm::ivec3(5)}}, 1);
    const Tracer tracer(scene);
    const LightEvidence dark = {[](glm::vec3) { return false; }, true};
    place_probes(volume, tracer, dark);
    double on = 0;
    double off = 0;
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        const glm::dvec3 place = glm::abs(lattice_position(volume, slot));
        const glm::dvec3 moved = glm::abs(gather_position(volume, slot));
        if (std::max({place.x, place.y, place.z}) != 1) continue;
        ++on;
        off += std::max({moved.x, moved.y, moved.z}) > 1.05 ? 1 : 0;
    }
    numerics_row("grid probes exactly on faces, edges and vertices: how many are moved off", on, off,
                 std::abs(on - off), 0);
}

TEST(Interpolation, CellsOfAspectAHundred) {
    // Trilinear interpolation is exact for a linear function, in flat cells as in cubes.
    Grid grid;
    grid.origin = {1e5, 0, -1e5};
    grid.spacing = {1, 0.01, 1};
    grid.counts = {5, 9, 6};
    Volume volume = make_volume({grid}, 1);
    const auto linear = [&](glm::dvec3 p) {
        const glm::dvec3 local = (p - grid.origin) / grid.spacing;
        return 3 + local.x - 0.5 * local.y + 0.25 * local.z;
    };
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        volume.coefficients[slot] = glm::vec3(linear(lattice_position(volume, slot)));
    }
    const Sampler sampler(volume);
    RandomStream random(4);
    double worst = 0;
    for (int i = 0; i < 10000; ++i) {
        const glm::dvec3 share(random.next_double(), random.next_double(), random.next_double());
        const glm::dvec3 place = grid.origin + share * grid.spacing * glm::dvec3(grid.counts - 1);
        worst = std::max(worst, std::abs(sampler.sample(place).sh[0].x - linear(place)));
    }
    // 1e5 m have 1.5e-11 m in double: 1.5e-9 of a flat cell. Coefficients are floats up to 8.
    numerics_row("cells of 1 x 0.01 x 1 m at 1e5 m: a linear function interpolated, largest error", 0, worst, worst,
                 4e-6);
}

}  // namespace
}  // namespace lightgrid
