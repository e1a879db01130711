#include "viewer/object.h"

#include "core/error.h"
#include "tests/scene_builder.h"
#include "viewer/normals.h"
#include "viewer/obj.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

/// A file of this test's own, gone with it.
class TextFile {
  public:
    TextFile(const std::string& name, const std::string& text)
        : folder_(fs::temp_directory_path() / ("lightgrid-object-" + std::to_string(::getpid()))),
          path_(folder_ / name) {
        fs::create_directories(folder_);
        std::ofstream(path_) << text;
    }
    ~TextFile() {
        std::error_code none;
        fs::remove(path_, none);
        fs::remove(folder_, none);
    }
    TextFile(const TextFile&) = delete;
    TextFile& operator=(const TextFile&) = delete;
    [[nodiscard]] const fs::path& path() const { return path_; }

  private:
    fs::path folder_;
    fs::path path_;
};

/// What holds for every object: sizes agree, indices are within, normals are of unit length and on the front side.
void expect_sound(const ObjectMesh& object) {
    const std::size_t vertices = object.positions.size();
    ASSERT_EQ(object.normals.size(), vertices);
    ASSERT_EQ(object.uvs.size(), vertices);
    ASSERT_EQ(object.emission_uvs.size(), vertices);
    ASSERT_EQ(object.colors.size(), vertices);
    std::uint32_t next_triangle = 0;
    std::uint32_t next_vertex = 0;
    for (const ObjectDraw& draw : object.draws) {
        EXPECT_EQ(draw.first_triangle, next_triangle);
        EXPECT_EQ(draw.first_vertex, next_vertex);
        next_triangle += draw.triangle_count;
        next_vertex += draw.vertex_count;
        ASSERT_LT(static_cast<std::size_t>(draw.material), object.materials.size());
        for (std::uint32_t t = draw.first_triangle; t < next_triangle; ++t) {
            for (int k = 0; k < 3; ++k) {
                EXPECT_GE(object.triangles[t][k], draw.first_vertex);
                EXPECT_LT(object.triangles[t][k], next_vertex);
            }
        }
    }
    EXPECT_EQ(next_triangle, object.triangles.size());
    EXPECT_EQ(next_vertex, vertices);
    for (const glm::vec3& normal : object.normals) EXPECT_NEAR(glm::length(normal), 1, 1e-5);
}

TEST(Normals, AreSmoothOverAFineSphereAndFlatOnABox) {
    Scene scene;
    const int sphere = add_sphere(scene, 0, {1, 2, 3}, 0.5F, Facing::outward, 32, 64);
    const Mesh& mesh = scene.meshes[sphere];
    const auto normals = corner_normals(mesh.positions, mesh.triangles);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const glm::vec3 outward = (mesh.positions[mesh.triangles[t][k]] - glm::vec3(1, 2, 3)) / 0.5F;
            EXPECT_LT(glm::distance(normals[t][k], outward), 0.01);
        }
    }
    const BoxShape box = box_shape({0, 0, 0}, {1, 2, 3}, Facing::outward);
    const auto flat = corner_normals(box.positions, box.triangles);
    for (std::size_t t = 0; t < box.triangles.size(); ++t) {
        glm::vec3 wanted(0);
        wanted[static_cast<int>(t / 4)] = t / 2 % 2 == 0 ? -1.0F : 1.0F;
        for (const glm::vec3& normal : flat[t]) EXPECT_LT(glm::distance(normal, wanted), 1e-6) << "triangle " << t;
    }
    // The same box with no creases: each corner looks along its diagonal, however the faces are cut.
    const auto round = corner_normals(box.positions, box.triangles, 91);
    for (std::size_t t = 0; t < box.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const glm::vec3 corner = box.positions[box.triangles[t][k]];
            const glm::vec3 diagonal = glm::sign(corner - glm::vec3(0.5F, 1, 1.5F)) / std::sqrt(3.0F);
            EXPECT_LT(glm::distance(round[t][k], diagonal), 1e-5);
        }
    }
}

TEST(Normals, OfSheetsThatTouchInAPointStayApart) {
    // Two triangles that share one corner and face 45 degrees apart: no edge joins them.
    const std::vector<glm::vec3> positions{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 1, 0}, {0, 0, 0}, {0, 0, -1}};
    const std::vector<glm::uvec3> triangles{{0, 1, 2}, {3, 4, 5}};
    const auto normals = corner_normals(positions, triangles);
    EXPECT_LT(glm::distance(normals[0][0], glm::vec3(0, 1, 0)), 1e-6);
    EXPECT_LT(glm::distance(normals[1][1], normals[1][0]), 1e-6);
}

TEST(Object, SphereIsRoundAndClosed) {
    ObjectMesh sphere = make_sphere(32);
    fit(sphere, 2);
    expect_sound(sphere);
    std::map<std::array<float, 6>, int> edges;
    double volume = 0;
    for (const glm::uvec3& t : sphere.triangles) {
        for (int k = 0; k < 3; ++k) {
            const glm::vec3 a = sphere.positions[t[k]] + 0.0F;
            const glm::vec3 b = sphere.positions[t[(k + 1) % 3]] + 0.0F;
            EXPECT_NEAR(glm::length(a), 1, 1e-6);
            ++edges[{a.x, a.y, a.z, b.x, b.y, b.z}];
            --edges[{b.x, b.y, b.z, a.x, a.y, a.z}];
        }
        const glm::dvec3 a = sphere.positions[t.x];
        volume += glm::dot(a, glm::cross(glm::dvec3(sphere.positions[t.y]), glm::dvec3(sphere.positions[t.z]))) / 6;
    }
    for (const auto& edge : edges) EXPECT_EQ(edge.second, 0);
    // Facets are at most pi / 16 wide and high: a sphere of radius cos(pi / 16 / sqrt 2) fits within.
    const double ball = 4 * std::acos(-1.0) / 3;
    EXPECT_GT(volume, 0.971 * ball) << "positive: fronts are outside";
    EXPECT_LT(volume, ball);
    for (std::size_t i = 0; i < sphere.positions.size(); ++i) {
        EXPECT_LT(glm::distance(sphere.normals[i], sphere.positions[i]), 1e-6);
    }
}

TEST(Object, FitsTheWantedSizeAroundZero) {
    Scene scene;
    scene.materials.emplace_back();
    add_box(scene, 0, {10, 20, 30}, {11, 24, 32}, Facing::outward);
    ObjectMesh box = object_from_scene(scene);
    fit(box, 0.5);
    expect_sound(box);
    Box bounds;
    for (const glm::vec3& p : box.positions) bounds.extend(p);
    EXPECT_LT(glm::distance(bounds.center(), glm::dvec3(0)), 1e-6);
    EXPECT_LT(glm::distance(bounds.size(), glm::dvec3(0.125, 0.5, 0.25)), 1e-6);
    EXPECT_EQ(box.positions.size(), 24U) << "a vertex for each corner of each side, no more";
}

TEST(Object, TakesInstancesMirrorsAndMaterialsOfAScene) {
    Scene scene;
    add_grey(scene, 0.5F);
    add_grey(scene, 0.25F);
    add_box(scene, 1, {0, 0, 0}, {1, 1, 1}, Facing::outward);
    const BoxShape shape = box_shape({0, 0, 0}, {1, 1, 1}, Facing::outward);
    const int mesh = store_mesh(scene, 0, shape.positions, shape.triangles);
    add_instance(scene, mesh, {-1, 0, 0, 0, 1, 0, 0, 0, 1, -3, 0, 0});
    const ObjectMesh object = object_from_scene(scene);
    expect_sound(object);
    ASSERT_EQ(object.draws.size(), 2U);
    EXPECT_EQ(object.draws[0].material, 0);
    for (std::uint32_t i = 0; i < object.draws[0].vertex_count; ++i) EXPECT_LE(object.positions[i].x, -3);
    for (std::size_t i = 0; i < object.positions.size(); ++i) {
        const glm::vec3 center(object.positions[i].x < -2 ? -3.5F : 0.5F, 0.5F, 0.5F);
        EXPECT_GT(glm::dot(object.normals[i], object.positions[i] - center), 0.4F) << "outward, mirrored or not";
    }
    const Scene again = scene_from_object(object);
    EXPECT_EQ(object_from_scene(again).triangles, object.triangles);
    EXPECT_EQ(object_from_scene(again).positions, object.positions);
    EXPECT_THROW(static_cast<void>(object_from_scene(Scene{})), Error);
}

TEST(Obj, GivesPolygonsColoursAndMaterials) {
    const TextFile materials("square.mtl", "newmtl glow\nKd 0.5 0.25 0.125\nKe 1 2 3\nd 0.5\n");
    const TextFile file("square.obj",
                        "mtllib square.mtl\n"
                        "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\n"
                        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                        "usemtl glow\nf 1/1 2/2 3/3 4/4\n"
                        "l 1 2\n");
    const ObjectMesh object = load_object(file.path());
    expect_sound(object);
    EXPECT_EQ(object.triangles.size(), 2U);
    ASSERT_EQ(object.positions.size(), 4U);
    ASSERT_EQ(object.draws.size(), 1U);
    const Material& material = object.materials[object.draws[0].material];
    EXPECT_EQ(material.base_color, glm::vec3(0.5F, 0.25F, 0.125F));
    EXPECT_EQ(material.emission, glm::vec3(1, 2, 3));
    EXPECT_EQ(material.alpha_mode, AlphaMode::blend);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(object.normals[i], glm::vec3(0, 0, 1));
        const glm::vec3 p = object.positions[i];
        const glm::vec3 color = p.y == 0 ? glm::vec3(1 - p.x, p.x, 0) : glm::vec3(1 - p.x, 1 - p.x, 1);
        EXPECT_EQ(glm::vec3(object.colors[i]), color);
    }
}

TEST(Obj, NamesWhatIsBroken) {
    EXPECT_THROW(static_cast<void>(load_obj("nowhere.obj")), Error);
    for (const char* text : {"", "hello\n", "v 0 0 0\nf 1 1 1\n", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
                             "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n", "f 1 2 3\n", "v 0 0 0\nf -5 -6 -7\n"}) {
        const TextFile file("broken.obj", text);
        try {
            const Scene scene = load_obj(file.path());
            FAIL() << text << " became " << scene.meshes.size() << " meshes";
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("broken.obj"), std::string::npos) << error.what();
        }
    }
}

TEST(Obj, NoticesAMissingMaterialFile) {
    const TextFile file("lone.obj", "mtllib gone.mtl\nusemtl gone\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const ObjectMesh object = load_object(file.path());
    expect_sound(object);
    ASSERT_FALSE(object.notices.empty());
    EXPECT_NE(object.notices[0].find("gone"), std::string::npos);
}

TEST(Object, BunnyIsSound) {
    const auto path = find_bunny();
    if (!path) GTEST_SKIP() << "the Debian package glmark2-data is not installed";
    ObjectMesh bunny = load_object(*path);
    fit(bunny, 0.4);
    expect_sound(bunny);
    EXPECT_GT(bunny.triangles.size(), 60000U);
    EXPECT_LT(bunny.positions.size(), bunny.triangles.size()) << "smooth: two triangles a vertex";
}

TEST(Object, LoadsGltf) {
    const fs::path file = fs::path(LIGHTGRID_SHARED) / "data/feat-BoxVertexColors";
    if (!fs::exists(file)) GTEST_SKIP() << file << " is absent";
    for (const auto& entry : fs::recursive_directory_iterator(file)) {
        const std::string extension = entry.path().extension().string();
        if (extension != ".glb" && extension != ".gltf") continue;
        const ObjectMesh object = load_object(entry.path());
        expect_sound(object);
        EXPECT_EQ(object.triangles.size(), 12U);
        return;
    }
    FAIL() << "no glTF in " << file;
}

}  // namespace
}  // namespace lightgrid
