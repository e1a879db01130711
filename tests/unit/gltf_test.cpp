#include "core/gltf.h"

#include "core/error.h"
#include "tests/gltf_builder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lightgrid {
namespace {

using nlohmann::json;

constexpr float ulp = 1.2e-7F;

Scene load(const std::string& file, const std::string& name = "level.gltf", const LoadOptions& options = {}) {
    const TemporaryFolder folder;
    write_bytes(folder.path() / name, file);
    return load_level(folder.path() / name, options);
}
Scene load(const GltfBuilder& builder, const LoadOptions& options = {}) {
    return load(builder.finished().dump(), "level.gltf", options);
}

std::string error_of(const std::string& file) {
    try {
        load(file);
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::input);
        return error.what();
    }
    return "no error";
}
std::string error_of(const GltfBuilder& builder) {
    return error_of(builder.finished().dump());
}

testing::AssertionResult contains(const std::string& text, const std::string& part) {
    if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
    return testing::AssertionFailure() << "no `" << part << "` in: " << text;
}

std::string joined(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    return text;
}

bool leaves_out(const Scene& scene, const std::string& what) {
    return std::any_of(scene.left_out.begin(), scene.left_out.end(),
                       [&](const LeftOut& entry) { return entry.what == what; });
}

/// Where a vertex stands in the level.
glm::dvec3 position(const Scene& scene, std::size_t vertex, std::size_t mesh = 0) {
    return glm::dvec3(scene.meshes.at(mesh).positions.at(vertex)) + scene.origin;
}
/// Twice the area of a triangle times the normal of its front.
glm::dvec3 front(const Scene& scene, std::size_t triangle = 0, std::size_t mesh = 0) {
    const glm::uvec3 corners = scene.meshes.at(mesh).triangles.at(triangle);
    const glm::dvec3 a = position(scene, corners.x, mesh);
    return glm::cross(position(scene, corners.y, mesh) - a, position(scene, corners.z, mesh) - a);
}

void expect_near(glm::dvec3 got, glm::dvec3 wanted, double tolerance = 1e-6) {
    for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(got[i], wanted[i], tolerance) << "of (" << got.x << ", " << got.y << ", " << got.z << ")";
}

GltfBuilder triangle() {
    GltfBuilder builder;
    builder.node({{"mesh", builder.triangle_mesh()}});
    return builder;
}

/// A triangle with this material.
GltfBuilder with_material(json material) {
    GltfBuilder builder;
    builder.add("materials", std::move(material));
    const int uv = builder.vec2s({{0, 0}, {1, 0}, {0, 1}});
    const int mesh = builder.mesh(
        {{"attributes", {{"POSITION", builder.vec3s(builder.corners())}, {"TEXCOORD_0", uv}}}, {"material", 0}});
    builder.node({{"mesh", mesh}});
    return builder;
}

ByteImage two_texels() {
    return {2, 1, {{255, 0, 0, 255}, {0, 0, 255, 128}}};
}

// Files

TEST(Gltf, ReadsJsonAndBinary) {
    for (const Scene& scene : {load(triangle()), load(triangle().glb(), "level.glb"), load(triangle().glb())}) {
        ASSERT_EQ(scene.placed.size(), 1U);
        ASSERT_EQ(scene.meshes[0].triangles.size(), 1U);
        EXPECT_EQ(scene.bounds.min, glm::dvec3(0));
        EXPECT_EQ(scene.bounds.max, glm::dvec3(1, 1, 0));
        EXPECT_EQ(scene.origin, glm::dvec3(0.5, 0.5, 0));
        EXPECT_EQ(front(scene), glm::dvec3(0, 0, 1));
        EXPECT_GT(scene.meshes[0].positions.capacity(), scene.meshes[0].positions.size());
    }
}

TEST(Gltf, FindsFilesByPercentEncodedPlainAndMovedNames) {
    for (const char* name : {"a b.bin", "a%20b.bin"})
        for (const char* uri : {"a%20b.bin", "a b.bin", "gone/a%20b.bin"}) {
            if (std::string(name) == "a%20b.bin" && std::string(uri) != "a%20b.bin") continue;
            const TemporaryFolder folder;
            GltfBuilder builder = triangle();
            builder.json["buffers"] = {{{"uri", uri}, {"byteLength", builder.data().size()}}};
            write_bytes(folder.path() / name, builder.data());
            write_bytes(folder.path() / "level.gltf", builder.json.dump());
            const Scene scene = load_level(folder.path() / "level.gltf");
            EXPECT_EQ(scene.placed.size(), 1U) << uri;
            EXPECT_EQ(
                static_cast<bool>(contains(joined(scene.notices), "\"a b.bin\" beside the level is read instead")),
                std::string(uri).starts_with("gone"));
        }
}

TEST(Gltf, FindsFilesAsExportersOnOtherSystemsNameThem) {
    struct Case {
        const char* file;
        const char* uri;
        const char* notice;
    };
    const Case cases[] = {
        {"textures/a b.bin", "textures\\a%20b.bin", "backslashes"},
        {"textures/a b.bin", ".\\textures\\a b.bin", "backslashes"},
        {"textures/a b.bin", "textures%5Ca%20b.bin", "backslashes"},
        {"sub/textures/a b.bin", "sub/textures\\a b.bin", "backslashes"},
        {"textures/a b.bin", "./textures/a b.bin", ""},
        {"textures/a b.bin", "Textures/A%20B.BIN", "upper and lower case"},
        {"textures/a b.bin", "TEXTURES\\A%20B.bin", "upper and lower case"},
        {"textures/a b.bin", "C:\\work\\level\\textures\\a b.bin", "\"textures/a b.bin\" beside the level"},
        {"a b.bin", "C:\\work\\textures\\a b.bin", "\"a b.bin\" beside the level"},
        {"a b.bin", "C:a b.bin", "\"a b.bin\" beside the level"},
        {"textures/a b.bin", "D:/Work/Textures/A b.bin", "\"textures/a b.bin\" beside the level"},
        {"textures/a b.bin", "file:///C:/work/textures/a%20b.bin", "\"textures/a b.bin\" beside the level"},
        {"textures/a b.bin", "\\\\server\\share\\textures\\a b.bin", "\"textures/a b.bin\" beside the level"},
        {"textures/a b.bin", "/home/somebody/textures/a b.bin", "\"textures/a b.bin\" beside the level"},
        {"textures\\a b.bin", "textures\\a b.bin", ""},
    };
    for (const Case& c : cases) {
        const TemporaryFolder folder;
        GltfBuilder builder = triangle();
        builder.json["buffers"] = {{{"uri", c.uri}, {"byteLength", builder.data().size()}}};
        std::filesystem::create_directories((folder.path() / c.file).parent_path());
        write_bytes(folder.path() / c.file, builder.data());
        write_bytes(folder.path() / "level.gltf", builder.json.dump());
        const Scene scene = load_level(folder.path() / "level.gltf");
        EXPECT_EQ(scene.placed.size(), 1U) << c.uri;
        EXPECT_TRUE(contains(joined(scene.notices), c.notice)) << c.uri;
        for (const char* word : {"backslashes", "upper and lower case", "beside the level"}) {
            const bool said = joined(scene.notices).find(word) != std::string::npos;
            EXPECT_FALSE(said && c.notice[0] == '\0') << c.uri << ": " << joined(scene.notices);
        }
    }
}

TEST(Gltf, ANameInAnotherCaseMustMeanOneFile) {
    const TemporaryFolder folder;
    GltfBuilder builder = triangle();
    builder.json["buffers"] = {{{"uri", "DATA.bin"}, {"byteLength", builder.data().size()}}};
    write_bytes(folder.path() / "level.gltf", builder.json.dump());
    for (const char* name : {"data.bin", "Data.bin"}) write_bytes(folder.path() / name, builder.data());
    EXPECT_THROW(static_cast<void>(load_level(folder.path() / "level.gltf")), Error);
    std::filesystem::remove(folder.path() / "Data.bin");
    EXPECT_EQ(load_level(folder.path() / "level.gltf").placed.size(), 1U);
}

TEST(Gltf, NamesWhatIsMissing) {
    GltfBuilder builder = triangle();
    builder.json["buffers"] = {{{"uri", "gone.bin"}, {"byteLength", 36}}};
    EXPECT_TRUE(contains(error_of(builder), "gone.bin"));
    builder.json["buffers"] = {{{"uri", "http://example.com/a.bin"}, {"byteLength", 36}}};
    EXPECT_TRUE(contains(error_of(builder), "neither a relative path nor a data URI"));
    builder.json["buffers"] = {{{"uri", "data:application/octet-stream;base64,AAAA"}, {"byteLength", 36}}};
    EXPECT_TRUE(contains(error_of(builder), "has 3 bytes of data, but byteLength is 36"));
    builder.json["buffers"] = {{{"uri", "/dev/zero"}, {"byteLength", 36}}};
    EXPECT_TRUE(contains(error_of(builder), "is not a regular file"));
    EXPECT_THROW(static_cast<void>(load_level("/no/such/file.glb")), Error);
    EXPECT_THROW(static_cast<void>(load_level("/")), Error);
}

TEST(Gltf, SaysWhatIsWrongInOneLine) {
    GltfBuilder builder = triangle();
    builder.json["bufferViews"][0]["byteStride"] = 5;
    EXPECT_TRUE(contains(error_of(builder), "byteStride"));
    EXPECT_FALSE(contains(error_of(builder), "\n"));
}

TEST(Gltf, RefusesOtherVersionsAndOtherFiles) {
    EXPECT_TRUE(contains(error_of(std::string("")), "JSON"));
    EXPECT_TRUE(contains(error_of(std::string("PK\3\4")), "neither binary glTF nor valid JSON"));
    EXPECT_TRUE(contains(error_of(std::string(R"({"asset": {"version": "1.0"}})")), "1.0"));
    EXPECT_TRUE(contains(error_of(std::string(R"({"asset": {"version": "2.1", "minVersion": "2.1"}})")), "2.1"));
    EXPECT_TRUE(contains(error_of(std::string("{}")), "asset"));
    std::string version_1 = triangle().glb();
    version_1[4] = 1;
    EXPECT_TRUE(contains(error_of(version_1), "version 1"));
}

TEST(Gltf, DeeplyNestedJsonIsNoDanger) {
    std::string deep = R"({"asset": {"version": "2.0"}, "extras": )";
    const std::size_t levels = 200000;
    deep += std::string(levels, '[') + std::string(levels, ']') + "}";
    EXPECT_TRUE(load(deep).placed.empty());
}

TEST(Gltf, ALevelWithoutTrianglesIsNoticed) {
    const Scene scene = load(R"({"asset": {"version": "2.0"}})");
    EXPECT_TRUE(scene.placed.empty());
    EXPECT_TRUE(scene.bounds.empty());
    EXPECT_EQ(scene.materials.size(), 1U);
    EXPECT_TRUE(contains(joined(scene.notices), "no triangles"));
}

// Scenes and nodes

TEST(Gltf, LoadsTheDefaultSceneOrTheOneAskedFor) {
    GltfBuilder builder = triangle();
    builder.node({{"mesh", 0}, {"translation", {10, 0, 0}}});
    builder.json["scenes"] = {{{"nodes", {0}}, {"name", "hall"}}, {{"nodes", {1}}}};
    builder.json["scene"] = 1;
    EXPECT_EQ(load(builder).bounds.min.x, 10);
    EXPECT_EQ(load(builder, {.scene = 0, .ignore = {}}).bounds.min.x, 0);
    builder.json.erase("scene");
    EXPECT_EQ(load(builder).bounds.min.x, 0);
    try {
        load(builder, {.scene = 2, .ignore = {}});
        FAIL();
    } catch (const Error& error) {
        EXPECT_TRUE(contains(error.what(), "scene 2 is asked for, but the file has: 0 \"hall\", 1"));
    }
}

TEST(Gltf, WithoutScenesAllNodesAreTheLevel) {
    GltfBuilder builder = triangle();
    builder.json.erase("scenes");
    builder.json.erase("scene");
    EXPECT_EQ(load(builder).placed.size(), 1U);
}

TEST(Gltf, ComposesTransformsInDouble) {
    GltfBuilder builder;
    const double s = std::sqrt(0.5);
    builder.node({{"children", {1}}, {"translation", {1e5 + 0.125, 0, 0}}, {"rotation", {0, 0, s, s}}});
    builder.node({{"children", {2}}, {"scale", {2, 3, 4}}});
    builder.node({{"mesh", builder.triangle_mesh()}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1}}});
    const Scene scene = load(builder);
    // (x, y) -> (2x, 3y) -> a quarter turn about z.
    expect_near(position(scene, 0), {1e5 + 0.125, 0, 20});
    expect_near(position(scene, 1), {1e5 + 0.125, 2, 20});
    expect_near(position(scene, 2), {1e5 + 0.125 - 3, 0, 20});
    expect_near(front(scene), {0, 0, 6}, 1e-5);
}

TEST(Gltf, MirroringKeepsTheFrontInFront) {
    GltfBuilder builder = triangle();
    builder.json["nodes"][0]["scale"] = {-1, 1, 1};
    expect_near(front(load(builder)), {0, 0, 1});
    builder.json["nodes"][0]["scale"] = {-1, -1, -1};
    expect_near(front(load(builder)), {0, 0, -1});
}

TEST(Gltf, RefusesRingsAndSecondParents) {
    GltfBuilder builder = triangle();
    builder.json["nodes"][0]["children"] = {1};
    builder.node({{"children", {0}}});
    EXPECT_TRUE(contains(error_of(builder), "child of node 1"));
    builder.json["nodes"] = {{{"children", {1, 2}}}, {{"children", {2}}}, json::object()};
    EXPECT_TRUE(contains(error_of(builder), "node 2 (/nodes/2): is a child of two nodes, 0 and 1"));
}

TEST(Gltf, AChainOfManyNodesIsNoDanger) {
    GltfBuilder builder;
    const int count = 100000;
    for (int i = 0; i + 1 < count; ++i) builder.node({{"children", {i + 1}}});
    builder.node({{"mesh", builder.triangle_mesh()}});
    EXPECT_EQ(load(builder).placed.size(), 1U);
}

// Geometry

TEST(Gltf, ReadsEveryTriangleModeWithItsWinding) {
    const std::vector<glm::vec3> strip = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    const std::vector<glm::vec3> fan = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    for (const int mode : {5, 6})
        for (const bool indexed : {false, true}) {
            GltfBuilder builder;
            json primitive = {{"attributes", {{"POSITION", builder.vec3s(mode == 5 ? strip : fan)}}}, {"mode", mode}};
            if (indexed) primitive["indices"] = builder.indices({0, 1, 2, 3});
            builder.node({{"mesh", builder.mesh(primitive)}});
            const Scene scene = load(builder);
            ASSERT_EQ(scene.meshes[0].triangles.size(), 2U);
            EXPECT_EQ(front(scene, 0), glm::dvec3(0, 0, 1));
            EXPECT_EQ(front(scene, 1), glm::dvec3(0, 0, 1));
        }
}

TEST(Gltf, IgnoresPointsAndLinesWithANotice) {
    GltfBuilder builder = triangle();
    for (const int mode : {0, 1, 2, 3}) {
        builder.json["meshes"][0]["primitives"][0]["mode"] = mode;
        const Scene scene = load(builder);
        EXPECT_TRUE(scene.meshes.empty());
        EXPECT_TRUE(contains(joined(scene.notices), "points and lines"));
    }
    builder.json["meshes"][0]["primitives"][0]["mode"] = 7;
    EXPECT_TRUE(contains(error_of(builder), "mode"));
}

TEST(Gltf, ReadsIndicesOfEveryType) {
    GltfBuilder bytes;
    GltfBuilder shorts;
    GltfBuilder integers;
    for (GltfBuilder* builder : {&bytes, &shorts, &integers}) {
        const int position = builder->vec3s({{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
        const int indices = builder == &bytes ? builder->accessor(std::vector<std::uint8_t>{1, 2, 3}, "SCALAR", 5121, 3)
                            : builder == &shorts
                                ? builder->accessor(std::vector<std::uint16_t>{1, 2, 3}, "SCALAR", 5123, 3)
                                : builder->indices({1, 2, 3});
        builder->node({{"mesh", builder->mesh({{"attributes", {{"POSITION", position}}}, {"indices", indices}})}});
        const Scene scene = load(*builder);
        EXPECT_EQ(front(scene), glm::dvec3(0, 0, 1));
        // The vertex that no triangle uses is gone, and does not count in the bounds.
        EXPECT_EQ(scene.meshes[0].positions.size(), 3U);
        EXPECT_EQ(scene.bounds.max, glm::dvec3(1, 1, 0));
    }
}

TEST(Gltf, ManyPrimitivesOfOneVertexArrayKeepOnlyTheirOwn) {
    GltfBuilder builder;
    std::vector<glm::vec3> corners;
    for (int i = 0; i < 100; ++i)
        for (const glm::vec3& corner : GltfBuilder::corners()) corners.push_back(corner + glm::vec3(i, 0, 0));
    const int positions = builder.vec3s(corners);
    json primitives = json::array();
    for (std::uint32_t i = 0; i < 100; ++i)
        primitives.push_back(
            {{"attributes", {{"POSITION", positions}}}, {"indices", builder.indices({3 * i + 1, 3 * i + 2, 3 * i})}});
    builder.add("meshes", {{"primitives", primitives}});
    builder.node({{"mesh", 0}});
    const Scene scene = load(builder);
    ASSERT_EQ(scene.meshes.size(), 100U);
    for (std::size_t i = 0; i < 100; ++i) {
        EXPECT_EQ(scene.meshes[i].positions.size(), 3U);
        expect_near(position(scene, 0, i), {static_cast<double>(i), 0, 0}, 1e-5);
        expect_near(front(scene, 0, i), {0, 0, 1}, 1e-5);
    }
}

TEST(Gltf, ReadsInterleavedVertices) {
    GltfBuilder builder;
    const int view = builder.view(std::vector<float>{0, 0, 0, 7, 8, 1, 0, 0, 7, 8, 0, 1, 0, 7, 8});
    builder.json["bufferViews"][static_cast<std::size_t>(view)]["byteStride"] = 20;
    const int position =
        builder.add("accessors", {{"bufferView", view}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
    builder.node({{"mesh", builder.mesh({{"attributes", {{"POSITION", position}}}})}});
    EXPECT_EQ(front(load(builder)), glm::dvec3(0, 0, 1));
}

TEST(Gltf, ReadsQuantizedPositionsAndCoordinates) {
    GltfBuilder builder = with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    builder.require("KHR_mesh_quantization");
    builder.texture(two_texels());
    json& attributes = builder.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["POSITION"] =
        builder.accessor(std::vector<std::int16_t>{0, 0, 0, 0, 32767, 0, 0, 0, 0, -32768, 0, 0}, "VEC3", 5122, 3, true);
    builder.json["bufferViews"].back()["byteStride"] = 8;
    attributes["TEXCOORD_0"] =
        builder.accessor(std::vector<std::uint8_t>{0, 0, 0, 0, 255, 51, 0, 0, 3, 0, 0, 0}, "VEC2", 5121, 3, true);
    builder.json["bufferViews"].back()["byteStride"] = 4;
    const Scene scene = load(builder);
    expect_near(position(scene, 1), {1, 0, 0});
    expect_near(position(scene, 2), {0, -1, 0});  // -32768 is -1 too
    EXPECT_EQ(scene.meshes[0].uv_sets[0][1], glm::vec2(1, 0.2F));
    builder.json["accessors"].back()["normalized"] = false;
    EXPECT_EQ(load(builder).meshes[0].uv_sets[0][1], glm::vec2(255, 51));
}

TEST(Gltf, ReadsSparsePositionsWithAndWithoutABase) {
    for (const bool has_base : {true, false}) {
        GltfBuilder builder = triangle();
        json& accessor = builder.json["accessors"][0];
        const int indices = builder.view(std::vector<std::uint16_t>{1, 2});
        const int values = builder.view(std::vector<glm::vec3>{{2, 0, 0}, {0, 3, 0}});
        accessor["sparse"] = {{"count", 2},
                              {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                              {"values", {{"bufferView", values}}}};
        if (!has_base) accessor.erase("bufferView");
        EXPECT_EQ(front(load(builder)), glm::dvec3(0, 0, 6));
        // Through indices that pick some vertices out of many.
        builder.json["meshes"][0]["primitives"][0]["indices"] = builder.indices({2, 0, 1});
        EXPECT_EQ(front(load(builder)), glm::dvec3(0, 0, 6));
    }
}

TEST(Gltf, SparseIndicesMustGrowAndStayInside) {
    for (const std::vector<std::uint16_t>& wrong : {std::vector<std::uint16_t>{2, 1}, {1, 1}, {1, 3}}) {
        GltfBuilder builder = triangle();
        const int indices = builder.view(wrong);
        const int values = builder.view(std::vector<glm::vec3>{{2, 0, 0}, {0, 3, 0}});
        builder.json["accessors"][0]["sparse"] = {{"count", 2},
                                                  {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                                                  {"values", {{"bufferView", values}}}};
        EXPECT_TRUE(contains(error_of(builder), "sparse index 1"));
    }
}

TEST(Gltf, DropsTrianglesWithoutAreaAndTheirVertices) {
    GltfBuilder builder;
    const int position = builder.vec3s({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {100, 0, 0}, {200, 0, 0}});
    const int indices = builder.indices({0, 3, 4, 0, 1, 2, 1, 1, 2});
    builder.node({{"mesh", builder.mesh({{"attributes", {{"POSITION", position}}}, {"indices", indices}})}});
    const Scene scene = load(builder);
    EXPECT_EQ(scene.meshes[0].triangles.size(), 1U);
    EXPECT_EQ(front(scene), glm::dvec3(0, 0, 1));
    EXPECT_EQ(scene.bounds.max.x, 1);
    EXPECT_TRUE(contains(joined(scene.notices), "2 triangles have no area"));
}

TEST(Gltf, AMeshWithoutAreaIsNotThere) {
    GltfBuilder builder = triangle();
    builder.json["scenes"][0]["nodes"] = {0, 1, 2};
    const int flat = builder.mesh({{"attributes", {{"POSITION", builder.vec3s({{5, 5, 5}, {6, 6, 6}, {7, 7, 7}})}}}});
    builder.node({{"mesh", flat}});
    builder.node({{"mesh", 0}, {"scale", {0, 1, 1}}, {"translation", {0, 0, 3}}});
    const Scene scene = load(builder);
    EXPECT_EQ(scene.meshes.size(), 1U);
    EXPECT_EQ(scene.placed.size(), 1U);
    EXPECT_EQ(scene.bounds.max.x, 1);
    EXPECT_TRUE(contains(joined(scene.notices), "2 triangles have no area"));
}

TEST(Gltf, KeepsOnlyTheVertexDataThatLightReads) {
    GltfBuilder builder = with_material(
        {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}, {"normalTexture", {{"index", 1}}}});
    builder.texture(two_texels());
    builder.texture(two_texels());
    json& attributes = builder.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["TEXCOORD_1"] = builder.vec2s({{5, 5}, {5, 5}, {5, 5}});
    attributes["NORMAL"] = builder.vec3s({{0, 0, 1}, {0, 0, 1}, {0, 0, 1}});
    attributes["COLOR_0"] = builder.vec3s({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
    const Scene scene = load(builder);
    EXPECT_EQ(scene.textures.size(), 1U);
    ASSERT_EQ(scene.meshes[0].uv_sets.size(), 1U);
    EXPECT_EQ(scene.meshes[0].uv_sets[0].size(), 3U);
    EXPECT_TRUE(scene.meshes[0].colors.empty());
    EXPECT_TRUE(leaves_out(scene, "normals, tangents and other vertex data"));
    EXPECT_TRUE(leaves_out(scene, "images of normals, roughness and the like"));
    EXPECT_TRUE(leaves_out(scene, "vertex colours"));
}

TEST(Gltf, ReadsVertexColoursOfAnyType) {
    const auto color = [](auto add) {
        GltfBuilder builder = triangle();
        builder.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = add(builder);
        return load(builder);
    };
    const Scene floats = color([](GltfBuilder& b) { return b.vec3s({{0.2F, 1, 0}, {1, 1, 1}, {1, 1, 1}}); });
    EXPECT_EQ(floats.meshes[0].colors[0], glm::u16vec4(13107, 65535, 0, 65535));
    const Scene bytes = color([](GltfBuilder& b) {
        return b.accessor(std::vector<std::uint8_t>{51, 255, 0, 102, 1, 2, 3, 4, 5, 6, 7, 8}, "VEC4", 5121, 3, true);
    });
    EXPECT_EQ(bytes.meshes[0].colors[0], glm::u16vec4(13107, 65535, 0, 26214));
    const Scene shorts = color([](GltfBuilder& b) {
        return b.accessor(std::vector<std::uint16_t>{1, 2, 3, 40000, 5, 6, 7, 8, 9, 10, 11, 12}, "VEC4", 5123, 3, true);
    });
    EXPECT_EQ(shorts.meshes[0].colors[0], glm::u16vec4(1, 2, 3, 40000));
    const Scene clamped = color([](GltfBuilder& b) { return b.vec3s({{2, -1, 0}, {1, 1, 1}, {1, 1, 1}}); });
    EXPECT_EQ(clamped.meshes[0].colors[0], glm::u16vec4(65535, 0, 0, 65535));
    EXPECT_TRUE(contains(joined(clamped.notices), "vertex colours are outside [0, 1]"));
}

// Instances

TEST(Gltf, MeshesUsedSeveralTimesAreInstancedAndNotCopied) {
    GltfBuilder builder = triangle();
    builder.json["scenes"][0]["nodes"] = {0, 1, 2};
    builder.node({{"mesh", 0}, {"translation", {10, 0, 0}}, {"scale", {-1, 1, 1}}});
    builder.node({{"mesh", builder.triangle_mesh()}});
    const Scene scene = load(builder);
    ASSERT_EQ(scene.models.size(), 1U);
    ASSERT_EQ(scene.instances.size(), 2U);
    EXPECT_EQ(scene.placed.size(), 1U);
    EXPECT_EQ(scene.meshes.size(), 2U);
    EXPECT_FALSE(scene.instances[0].mirrored);
    EXPECT_TRUE(scene.instances[1].mirrored);
    expect_near(glm::dvec3(scene.instances[1].to_level[3]) + scene.origin, {10, 0, 0});
    EXPECT_EQ(scene.instances[1].to_level[0], glm::vec3(-1, 0, 0));
    const Mesh& mesh = scene.meshes[static_cast<std::size_t>(scene.models[0].meshes.at(0))];
    EXPECT_EQ(mesh.positions, GltfBuilder::corners());  // in its own space
    EXPECT_EQ(scene.bounds.min, glm::dvec3(0));
    EXPECT_EQ(scene.bounds.max, glm::dvec3(10, 1, 0));
}

TEST(Gltf, GpuInstancingMultipliesANodesMesh) {
    GltfBuilder builder = triangle();
    builder.use("EXT_mesh_gpu_instancing");
    const auto s = static_cast<float>(std::sqrt(0.5));
    builder.json["nodes"][0]["translation"] = {0, 0, 5};
    builder.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", builder.vec3s({{0, 0, 0}, {2, 0, 0}})},
        {"ROTATION", builder.vec4s({{0, 0, 0, 1}, {0, 0, s, s}})},
        {"SCALE", builder.vec3s({{1, 1, 1}, {3, 1, 1}})}};
    const Scene scene = load(builder);
    ASSERT_EQ(scene.instances.size(), 2U);
    const glm::mat4x3& second = scene.instances[1].to_level;
    expect_near(glm::dvec3(second * glm::vec4(1, 0, 0, 1)) + scene.origin, {2, 3, 5});
}

TEST(Gltf, AFlatInstanceStandsInTheLevelItself) {
    GltfBuilder builder = triangle();
    builder.json["scenes"][0]["nodes"] = {0, 1, 2};
    builder.node({{"mesh", 0}, {"translation", {2, 0, 0}}});
    builder.node({{"mesh", 0}, {"translation", {4, 0, 0}}, {"scale", {1, 1, 0}}});
    const Scene scene = load(builder);
    EXPECT_EQ(scene.instances.size(), 2U);
    ASSERT_EQ(scene.placed.size(), 1U);
    expect_near(position(scene, 0, static_cast<std::size_t>(scene.placed[0])), {4, 0, 0});
}

// Morphs and skins

TEST(Gltf, MorphsStandAtTheirDefaultWeights) {
    GltfBuilder builder = triangle();
    json& mesh = builder.json["meshes"][0];
    const int up = builder.vec3s({{0, 0, 0}, {0, 0, 0}, {0, 4, 0}});
    const int right = builder.vec3s({{0, 0, 0}, {2, 0, 0}, {0, 0, 0}});
    mesh["primitives"][0]["targets"] = {{{"POSITION", up}}, {{"POSITION", right}}};
    EXPECT_EQ(front(load(builder)), glm::dvec3(0, 0, 1));
    mesh["weights"] = {0.5, 0};
    EXPECT_EQ(front(load(builder)), glm::dvec3(0, 0, 3));
    builder.json["nodes"][0]["weights"] = {0.5, 1};
    EXPECT_EQ(front(load(builder)), glm::dvec3(0, 0, 9));
    builder.json["nodes"][0]["weights"] = {0.5};
    EXPECT_TRUE(contains(error_of(builder), "1 weights, but the mesh has 2 morph targets"));
}

TEST(Gltf, NodesThatMorphDifferentlyShareNoModel) {
    GltfBuilder builder = triangle();
    builder.json["meshes"][0]["primitives"][0]["targets"] = {
        {{"POSITION", builder.vec3s({{0, 0, 0}, {0, 0, 0}, {0, 4, 0}})}}};
    builder.json["scenes"][0]["nodes"] = {0, 1};
    builder.node({{"mesh", 0}, {"weights", {1}}});
    const Scene scene = load(builder);
    EXPECT_EQ(scene.placed.size(), 2U);
    EXPECT_EQ(front(scene, 0, 1), glm::dvec3(0, 0, 5));
}

/// A triangle on two joints: its first two vertices follow the first, its third is halfway between both.
GltfBuilder skinned() {
    GltfBuilder builder = triangle();
    json& attributes = builder.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] =
        builder.accessor(std::vector<std::uint8_t>{0, 9, 9, 9, 0, 9, 9, 9, 0, 1, 9, 9}, "VEC4", 5121, 3);
    attributes["WEIGHTS_0"] = builder.vec4s({{1, 0, 0, 0}, {1, 0, 0, 0}, {0.5F, 0.5F, 0, 0}});
    builder.node({{"translation", {0, 0, 10}}, {"children", {2}}});
    builder.node({{"translation", {0, 4, 0}}});
    builder.json["nodes"][0]["skin"] = 0;
    builder.json["nodes"][0]["translation"] = {77, 77, 77};  // has no part in it
    builder.json["scenes"][0]["nodes"] = {0, 1};
    builder.add("skins", {{"joints", {1, 2}}});
    return builder;
}

TEST(Gltf, SkinsStandWhereTheirJointsRest) {
    const Scene scene = load(skinned());
    expect_near(position(scene, 0), {0, 0, 10});
    expect_near(position(scene, 1), {1, 0, 10});
    expect_near(position(scene, 2), {0, 3, 10});
    expect_near(front(scene), {0, 0, 3});
}

TEST(Gltf, SkinsApplyInverseBindMatrices) {
    GltfBuilder builder = skinned();
    const std::vector<float> matrices = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  -10, 1,
                                         1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -4, -10, 1};
    builder.json["skins"][0]["inverseBindMatrices"] = builder.accessor(matrices, "MAT4", 5126, 2);
    const Scene scene = load(builder);
    expect_near(position(scene, 0), {0, 0, 0});
    expect_near(position(scene, 2), {0, 1, 0});
}

TEST(Gltf, MirroredJointsKeepTheFrontInFront) {
    GltfBuilder builder = skinned();
    builder.json["nodes"][1]["scale"] = {-1, 1, 1};
    expect_near(front(load(builder)), {0, 0, 3});
}

TEST(Gltf, RefusesJointsThatAreNotThere) {
    GltfBuilder builder = skinned();
    builder.json["skins"][0]["joints"] = {1};
    EXPECT_TRUE(contains(error_of(builder), "joint 1, but the skin has only 1"));
    builder = skinned();
    builder.json["scenes"][0]["nodes"] = {0};
    EXPECT_TRUE(contains(error_of(builder), "node 1, is not in the scene"));
    builder = skinned();
    builder.json["meshes"][0]["primitives"][0]["attributes"].erase("WEIGHTS_0");
    EXPECT_TRUE(contains(error_of(builder), "1 sets of joints, but 0 of weights"));
}

// Materials

TEST(Gltf, ReadsFactors) {
    const Scene scene = load(with_material({{"name", "brick"},
                                            {"pbrMetallicRoughness", {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}}}},
                                            {"emissiveFactor", {0.5, 0.25, 0}},
                                            {"doubleSided", true},
                                            {"alphaMode", "BLEND"}}));
    const Material& material = scene.materials.at(0);
    EXPECT_EQ(material.name, "brick");
    EXPECT_EQ(material.base_color, glm::vec3(0.1F, 0.2F, 0.3F));
    EXPECT_EQ(material.alpha, 0.4F);
    EXPECT_EQ(material.alpha_mode, AlphaMode::blend);
    EXPECT_EQ(material.emission, glm::vec3(0.5F, 0.25F, 0));
    EXPECT_TRUE(material.double_sided);
}

TEST(Gltf, WhereNothingHasAMaterialTheDefaultAlbedoIsTaken) {
    GltfBuilder builder = triangle();
    const Scene grey = load(builder);
    EXPECT_EQ(grey.materials.at(0).base_color, glm::vec3(0.8F));
    EXPECT_TRUE(contains(joined(grey.notices), "no primitive has a material: albedo 0.8 is taken (--default-albedo)"));
    const TemporaryFolder folder;
    write_bytes(folder.path() / "level.gltf", builder.finished().dump());
    LoadOptions options;
    options.default_albedo = 0.25F;
    EXPECT_EQ(load_level(folder.path() / "level.gltf", options).materials.at(0).base_color, glm::vec3(0.25F));
    // A material that only another scene uses is none of this level.
    builder.add("materials", {{"name", "elsewhere"}});
    const int other = builder.mesh({{"attributes", {{"POSITION", builder.vec3s(builder.corners())}}}, {"material", 0}});
    const int node = builder.node({{"mesh", other}});
    builder.json["scenes"].push_back({{"nodes", {node}}});
    EXPECT_EQ(load(builder).materials.at(0).base_color, glm::vec3(0.8F));
    // Where a primitive has one, glTF's white is meant.
    builder.json["scenes"][0]["nodes"].push_back(node);
    builder.json["scenes"].erase(1);
    const Scene mixed = load(builder);
    ASSERT_EQ(mixed.materials.size(), 2U);
    for (const Material& material : mixed.materials) EXPECT_EQ(material.base_color, glm::vec3(1));
    EXPECT_EQ(joined(mixed.notices).find("--default-albedo"), std::string::npos);
}

TEST(Gltf, ClampsBaseColourWithANotice) {
    const Scene scene =
        load(with_material({{"name", "chalk"}, {"pbrMetallicRoughness", {{"baseColorFactor", {2, -1, 0.5, 1}}}}}));
    EXPECT_EQ(scene.materials[0].base_color, glm::vec3(1, 0, 0.5F));
    EXPECT_TRUE(contains(joined(scene.notices), "material \"chalk\": its base colour is outside [0, 1]"));
}

TEST(Gltf, EmissiveStrengthMultiplies) {
    GltfBuilder builder = with_material({{"emissiveFactor", {1, 0.5, 0}}});
    builder.use("KHR_materials_emissive_strength");
    json& material = builder.json["materials"][0];
    material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 1e4;
    EXPECT_EQ(load(builder).materials[0].emission, glm::vec3(1e4F, 5e3F, 0));
    material["emissiveFactor"] = {1e30, 0, 0};
    material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 1e30;
    EXPECT_TRUE(contains(error_of(builder), "1e+30 x 1e+30"));
}

TEST(Gltf, ReadsTransmission) {
    GltfBuilder builder = with_material({});
    builder.use("KHR_materials_transmission");
    builder.texture({2, 1, {{0, 0, 0, 255}, {255, 0, 0, 255}}});
    json& transmission = builder.json["materials"][0]["extensions"]["KHR_materials_transmission"];
    transmission = {{"transmissionFactor", 0.5}, {"transmissionTexture", {{"index", 0}}}};
    const Scene scene = load(builder);
    EXPECT_EQ(scene.materials[0].transmission, 0.5F);
    EXPECT_EQ(surface_at(scene, scene.meshes[0], 0, {0.75F, 0}).transmission, 0.5F);
    EXPECT_EQ(surface_at(scene, scene.meshes[0], 0, {0.25F, 0}).transmission, 0);
    transmission["transmissionFactor"] = 0;
    EXPECT_TRUE(load(builder).textures.empty());
}

TEST(Gltf, ReadsAlphaOfMaskAndBlend) {
    GltfBuilder builder = with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    builder.texture({2, 1, {{255, 255, 255, 0}, {255, 0, 255, 255}}});
    EXPECT_EQ(load(builder).materials[0].alpha_mode, AlphaMode::opaque);
    builder.json["materials"][0]["alphaMode"] = "MASK";
    EXPECT_EQ(load(builder).materials[0].alpha_cutoff, 0.5F);
    builder.json["materials"][0]["alphaCutoff"] = 0.75;
    const Scene scene = load(builder);
    EXPECT_EQ(scene.materials[0].alpha_mode, AlphaMode::mask);
    EXPECT_EQ(alpha_at(scene, scene.meshes[0], 0, {0.65F, 0}), 1);
    EXPECT_EQ(alpha_at(scene, scene.meshes[0], 0, {0.6F, 0}), 0);
    builder.json["materials"][0]["alphaMode"] = "GLOW";
    EXPECT_TRUE(contains(error_of(builder), "\"GLOW\""));
}

TEST(Gltf, SpecularGlossinessStandsInForAMissingBaseColour) {
    GltfBuilder builder = with_material({});
    builder.use("KHR_materials_pbrSpecularGlossiness");
    builder.texture(two_texels());
    json& material = builder.json["materials"][0];
    material["extensions"]["KHR_materials_pbrSpecularGlossiness"] = {{"diffuseFactor", {0.1, 0.2, 0.3, 1}},
                                                                     {"diffuseTexture", {{"index", 0}}}};
    const Scene old = load(builder);
    EXPECT_EQ(old.materials[0].base_color, glm::vec3(0.1F, 0.2F, 0.3F));
    EXPECT_TRUE(old.materials[0].base_color_texture.used());
    material["pbrMetallicRoughness"]["baseColorFactor"] = {0.5, 0.5, 0.5, 1};
    const Scene both = load(builder);
    EXPECT_EQ(both.materials[0].base_color, glm::vec3(0.5F));
    EXPECT_FALSE(both.materials[0].base_color_texture.used());
}

TEST(Gltf, UnlitIsNamedInANotice) {
    GltfBuilder builder = with_material({{"name", "sign"}});
    builder.require("KHR_materials_unlit");
    builder.json["materials"][0]["extensions"]["KHR_materials_unlit"] = json::object();
    EXPECT_TRUE(contains(joined(load(builder).notices), "material \"sign\": KHR_materials_unlit"));
}

// Textures

TEST(Gltf, ReadsSamplers) {
    GltfBuilder builder = with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    builder.texture(two_texels(), {{"sampler", 0}});
    builder.add("samplers", {{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}});
    const Scene scene = load(builder);
    EXPECT_EQ(scene.textures.at(0).wrap_u, Wrap::clamp);
    EXPECT_EQ(scene.textures[0].wrap_v, Wrap::mirror);
    EXPECT_TRUE(scene.textures[0].nearest);
    EXPECT_EQ(scene.textures[0].image.pixels, two_texels().pixels);
}

TEST(Gltf, TexturesWithTheSameImageAndSamplerAreOne) {
    GltfBuilder builder = with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                                         {"emissiveFactor", {1, 1, 1}},
                                         {"emissiveTexture", {{"index", 1}}}});
    builder.texture(two_texels());
    builder.add("textures", {{"source", 0}});
    EXPECT_EQ(load(builder).textures.size(), 1U);
    builder.add("samplers", {{"wrapS", 33071}});
    builder.json["textures"][1]["sampler"] = 0;
    EXPECT_EQ(load(builder).textures.size(), 2U);
}

TEST(Gltf, TextureTransformMovesTurnsAndScales) {
    GltfBuilder builder = with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    builder.use("KHR_texture_transform");
    builder.texture(two_texels());
    json& transform =
        builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"];
    transform = {{"offset", {0.25, 0.5}}, {"rotation", std::acos(-1.0) / 2}, {"scale", {2, 3}}};
    const glm::mat3x2 matrix = load(builder).materials[0].base_color_texture.transform;
    // A quarter turn, counter-clockwise on a picture whose v grows downwards, takes u to -v and v to u.
    const glm::vec2 u = matrix * glm::vec3(1, 0, 1);
    const glm::vec2 v = matrix * glm::vec3(0, 1, 1);
    EXPECT_NEAR(u.x, 0.25, ulp);
    EXPECT_NEAR(u.y, 0.5 - 2, 2 * ulp);
    EXPECT_NEAR(v.x, 0.25 + 3, 4 * ulp);
    EXPECT_NEAR(v.y, 0.5, 4 * ulp);
}

TEST(Gltf, TextureTransformMayChooseAnotherUvSet) {
    GltfBuilder builder =
        with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}, {"texCoord", 0}}}}}});
    builder.use("KHR_texture_transform");
    builder.texture(two_texels());
    builder.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_3"] =
        builder.vec2s({{0.25F, 0}, {0.25F, 0}, {0.25F, 0}});
    builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"]
                ["texCoord"] = 3;
    const Scene scene = load(builder);
    EXPECT_EQ(surface_at(scene, scene.meshes[0], 0, {0.9F, 0}).tint, glm::vec3(1, 0, 0));
}

TEST(Gltf, AMissingUvSetIsNoticedAndReadsOnePoint) {
    GltfBuilder builder =
        with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}, {"texCoord", 1}}}}}});
    builder.texture(two_texels());
    const Scene scene = load(builder);
    EXPECT_TRUE(contains(joined(scene.notices), "has no TEXCOORD_1"));
    EXPECT_EQ(surface_at(scene, scene.meshes[0], 0, {0.9F, 0}).tint,
              surface_at(scene, scene.meshes[0], 0, {0, 0}).tint);
}

TEST(Gltf, ReadsImagesFromBufferViews) {
    const TemporaryFolder folder;
    write_png(two_texels(), folder.path() / "a.png");
    const std::string png = read_bytes(folder.path() / "a.png");
    GltfBuilder builder = with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    const int view = builder.view(std::vector<char>(png.begin(), png.end()));
    builder.add("images", {{"bufferView", view}, {"mimeType", "image/png"}});
    builder.add("textures", {{"source", 0}});
    EXPECT_EQ(load(builder.glb(), "level.glb").textures.at(0).image.pixels, two_texels().pixels);
}

TEST(Gltf, Ktx2IsMissingUnlessThereIsAnotherImage) {
    GltfBuilder builder = with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    builder.require("KHR_texture_basisu");
    builder.texture(two_texels());
    builder.json["textures"][0]["extensions"]["KHR_texture_basisu"]["source"] = 0;
    EXPECT_EQ(load(builder).textures.size(), 1U);
    builder.json["textures"][0].erase("source");
    const Scene scene = load(builder);
    EXPECT_EQ(scene.missing_textures, std::vector<std::string>{"texture 0"});
    EXPECT_TRUE(contains(joined(scene.notices), "texture 0: is KTX2 (KHR_texture_basisu)"));
}

TEST(Gltf, OfAMissingTextureTheFactorIsLeftAndNoEmission) {
    GltfBuilder builder = with_material(
        {{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 1, 0.5}}, {"baseColorTexture", {{"index", 0}}}}},
         {"alphaMode", "BLEND"},
         {"emissiveFactor", {1, 1, 1}},
         {"emissiveTexture", {{"index", 1}}},
         {"extensions",
          {{"KHR_materials_transmission", {{"transmissionFactor", 0.5}, {"transmissionTexture", {{"index", 2}}}}}}}});
    builder.use("KHR_materials_transmission");
    for (int i = 0; i < 3; ++i) builder.texture(two_texels());
    EXPECT_EQ(load(builder).textures.size(), 3U);

    const std::string whole = builder.json["images"][0]["uri"];
    const std::string webp = "data:image/webp;base64," + base64("RIFF\x20\0\0\0WEBPVP8 ");
    const std::string broken[] = {"gone.png",
                                  whole.substr(0, whole.size() - 40),
                                  "data:image/png;base64,",
                                  "data:image/jpeg;base64,/9j/4AAQ",
                                  webp,
                                  "http://example.com/a.png",
                                  "data:image/ktx2;base64," + base64("\xabKTX 20\xbb\r\n\x1a\n")};
    for (const std::string& uri : broken) {
        for (int missing = 0; missing < 3; ++missing) {
            GltfBuilder level = builder;
            level.json["images"][missing] = {{"uri", uri}, {"name", "wood"}};
            const Scene scene = load(level);
            const Material& material = scene.materials.at(0);
            EXPECT_EQ(scene.missing_textures.size(), 1U) << uri;
            EXPECT_TRUE(contains(joined(scene.notices), "missing texture: image \"wood\"")) << uri;
            EXPECT_EQ(scene.textures.size(), 2U);
            EXPECT_EQ(material.base_color, glm::vec3(0.5F, 0.25F, 1));
            EXPECT_EQ(material.base_color_texture.used(), missing != 0);
            EXPECT_EQ(material.alpha_mode, missing == 0 ? AlphaMode::opaque : AlphaMode::blend);
            EXPECT_EQ(material.emission, glm::vec3(missing == 1 ? 0 : 1));
            EXPECT_EQ(material.transmission_texture.used(), missing != 2);
            EXPECT_EQ(material.transmission, 0.5F);
            for (const TextureUse* use :
                 {&material.base_color_texture, &material.emission_texture, &material.transmission_texture})
                EXPECT_LT(use->texture, 2);
            const TemporaryFolder folder;
            write_bytes(folder.path() / "level.gltf", level.finished().dump());
            LoadOptions options;
            options.missing_textures = MissingTextures::error;
            EXPECT_THROW(static_cast<void>(load_level(folder.path() / "level.gltf", options)), Error) << uri;
        }
    }
}

TEST(Gltf, ATextureWhoseImageIsNotThereIsMissing) {
    GltfBuilder builder = with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    builder.add("samplers", {{"wrapS", 10497}});
    builder.add("textures", {{"source", 0}, {"sampler", 0}});
    const Scene scene = load(builder);
    EXPECT_EQ(scene.missing_textures.size(), 1U);
    EXPECT_TRUE(contains(joined(scene.notices), "refers to element 0 of images, but there are 0"));
}

TEST(Gltf, AMissingImageOfSeveralTexturesIsNamedOnce) {
    GltfBuilder builder = with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                                         {"emissiveFactor", {1, 1, 1}},
                                         {"emissiveTexture", {{"index", 1}}}});
    builder.add("samplers", {{"wrapS", 33071}});
    builder.add("images", {{"uri", "gone.png"}});
    builder.add("textures", {{"source", 0}});
    builder.add("textures", {{"source", 0}, {"sampler", 0}});
    const Scene scene = load(builder);
    EXPECT_EQ(scene.missing_textures.size(), 1U);
    EXPECT_TRUE(scene.textures.empty());
    EXPECT_FALSE(scene.materials.at(0).emits());
    EXPECT_TRUE(contains(joined(scene.notices),
                         "; material 0: its base colour is the factor, opaque; material 0: it emits nothing"))
        << joined(scene.notices);
}

TEST(Gltf, ARefusalForMissingTexturesNamesAllImages) {
    GltfBuilder builder = with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                                         {"emissiveFactor", {1, 1, 1}},
                                         {"emissiveTexture", {{"index", 1}}}});
    for (const char* uri : {"a.png", "b.png"})
        builder.add("textures", {{"source", builder.add("images", {{"uri", uri}})}});
    const TemporaryFolder folder;
    write_bytes(folder.path() / "level.gltf", builder.finished().dump());
    LoadOptions options;
    options.missing_textures = MissingTextures::error;
    try {
        static_cast<void>(load_level(folder.path() / "level.gltf", options));
        ADD_FAILURE();
    } catch (const Error& error) {
        EXPECT_TRUE(contains(error.what(), "image 0")) << error.what();
        EXPECT_TRUE(contains(error.what(), "also missing: image 1")) << error.what();
    }
}

TEST(Gltf, WebpTakesTheImageOfItsExtension) {
    GltfBuilder builder = with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    builder.use("EXT_texture_webp");
    builder.texture(two_texels());
    builder.texture({2, 1, {{1, 2, 3, 255}, {4, 5, 6, 255}}});
    builder.json["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = 1;
    EXPECT_EQ(load(builder).textures.at(0).image.pixels[0], glm::u8vec4(1, 2, 3, 255));
}

TEST(Gltf, LightThatAMaterialWouldLetThroughDiffuselyIsNamedOrRefused) {
    const char* const name = "KHR_materials_diffuse_transmission";
    const auto leaf = [&](double factor) {
        GltfBuilder builder = with_material({{"name", "leaf"}});
        builder.json["materials"][0]["extensions"][name] = {{"diffuseTransmissionFactor", factor},
                                                            {"diffuseTransmissionColorFactor", {0.2, 0.8, 0.4}}};
        return builder;
    };
    GltfBuilder used = leaf(0.25);
    used.use(name);
    const std::string notices = joined(load(used).notices);
    EXPECT_TRUE(contains(notices,
                         "material \"leaf\": KHR_materials_diffuse_transmission is not followed: behind it, "
                         "up to 20 % of the light that meets it is missing"));
    EXPECT_TRUE(contains(notices, "up to 25 % of what it reflects is too much"));
    GltfBuilder required = leaf(0.25);
    required.require(name);
    EXPECT_TRUE(contains(error_of(required), "material \"leaf\": KHR_materials_diffuse_transmission is not followed"));
    GltfBuilder opaque = leaf(0);
    opaque.require(name);
    EXPECT_FALSE(contains(joined(load(opaque).notices), name));
}

// Lights and markers

GltfBuilder with_light(json light, json node = json::object()) {
    GltfBuilder builder;
    builder.use("KHR_lights_punctual");
    builder.json["extensions"]["KHR_lights_punctual"]["lights"] = {std::move(light)};
    node["extensions"]["KHR_lights_punctual"]["light"] = 0;
    builder.node(std::move(node));
    return builder;
}

TEST(Gltf, ReadsPointLights) {
    const Scene scene = load(with_light({{"type", "point"}, {"color", {1, 0.5, 0}}, {"intensity", 40}, {"range", 7}},
                                        {{"translation", {1, 2, 3}}, {"scale", {9, 9, 9}}, {"name", "lamp"}}));
    const Light& light = scene.lights.at(0);
    EXPECT_EQ(light.kind, LightKind::point);
    EXPECT_EQ(light.name, "lamp");
    EXPECT_EQ(light.intensity, glm::vec3(40, 20, 0));
    EXPECT_EQ(glm::dvec3(light.position) + scene.origin, glm::dvec3(1, 2, 3));
    EXPECT_EQ(light.range, 7);
}

TEST(Gltf, LightsShineAlongMinusZOfTheirNode) {
    const double s = std::sqrt(0.5);
    // A quarter turn about x takes -z to +y; the node's scale has no say, be it negative.
    const Scene scene =
        load(with_light({{"type", "directional"}}, {{"rotation", {s, 0, 0, s}}, {"scale", {1, 1, -3}}}));
    expect_near(glm::dvec3(scene.lights.at(0).direction), {0, 1, 0});
    EXPECT_EQ(scene.lights[0].kind, LightKind::directional);
    EXPECT_EQ(scene.lights[0].intensity, glm::vec3(1));
    EXPECT_EQ(scene.lights[0].range, std::numeric_limits<float>::infinity());
}

TEST(Gltf, ReadsSpotLights) {
    const Scene scene =
        load(with_light({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}}));
    EXPECT_EQ(scene.lights.at(0).kind, LightKind::spot);
    EXPECT_EQ(scene.lights[0].cos_inner, static_cast<float>(std::cos(0.25)));
    EXPECT_EQ(scene.lights[0].cos_outer, static_cast<float>(std::cos(0.5)));
    const Scene plain = load(with_light({{"type", "spot"}, {"spot", json::object()}}));
    EXPECT_EQ(plain.lights.at(0).cos_inner, 1);
    EXPECT_NEAR(plain.lights[0].cos_outer, std::sqrt(0.5), ulp);
}

TEST(Gltf, DarkLightsAreLeftOut) {
    const Scene scene = load(with_light({{"type", "point"}, {"intensity", 0}}));
    EXPECT_TRUE(scene.lights.empty());
    EXPECT_TRUE(leaves_out(scene, "lights"));
}

TEST(Gltf, RefusesWrongLights) {
    EXPECT_TRUE(contains(error_of(with_light({{"type", "laser"}})), "\"laser\""));
    EXPECT_TRUE(contains(error_of(with_light({{"type", "point"}, {"intensity", -1}})), "intensity"));
    EXPECT_TRUE(
        contains(error_of(with_light({{"type", "spot"}, {"spot", {{"outerConeAngle", 2}}}})), "outerConeAngle"));
}

TEST(Gltf, MarkersBoundVolumesAndPlaceProbes) {
    GltfBuilder builder = triangle();
    builder.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
    builder.node({{"extras", {{"lightgrid", "volume"}}}, {"scale", {2, 4, 6}}, {"translation", {10, 0, 0}}});
    builder.node({{"extras", {{"lightgrid", "volume"}}}, {"mesh", builder.triangle_mesh()}, {"scale", {5, 5, 5}}});
    builder.node({{"extras", {{"lightgrid", "probe"}}}, {"translation", {1, 2, 3}}, {"mesh", 0}});
    const Scene scene = load(builder);
    ASSERT_EQ(scene.volume_markers.size(), 2U);
    expect_near(scene.volume_markers[0].min, {9, -2, -3});
    expect_near(scene.volume_markers[0].max, {11, 2, 3});
    expect_near(scene.volume_markers[1].max, {5, 5, 0});
    ASSERT_EQ(scene.probe_markers.size(), 1U);
    EXPECT_EQ(scene.probe_markers[0], glm::dvec3(1, 2, 3));
    // Their meshes are not part of the level.
    EXPECT_EQ(scene.placed.size(), 1U);
    EXPECT_TRUE(scene.instances.empty());
    builder.json["nodes"][3]["extras"]["lightgrid"] = "prboe";
    EXPECT_TRUE(contains(joined(load(builder).notices), "\"prboe\""));
}

// What an author or a user leaves out

/// Names of the scene's lights, each with a blank behind.
std::string lights_of(const Scene& scene) {
    std::string names;
    for (const Light& light : scene.lights) names += light.name + " ";
    return names;
}

/// Nodes: 0 "yard" (a triangle), 1 "house" {2, 3}, 2 "lamp" (a light), 3 nameless (a mesh "wall", 10 m off); 4 "sun" (a
/// light). A test changes one of them.
GltfBuilder yard_and_house(const json& change = {}, std::size_t node = 1) {
    GltfBuilder builder = triangle();
    builder.use("KHR_lights_punctual");
    builder.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "spot"}}};
    const auto light = [&](const char* name) {
        builder.node({{"name", name}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    };
    builder.json["scenes"][0]["nodes"] = {0, 1, 4};
    builder.json["nodes"][0]["name"] = "yard";
    builder.node({{"name", "house"}, {"children", {2, 3}}});
    light("lamp");
    const int wall = builder.triangle_mesh();
    builder.json["meshes"][static_cast<std::size_t>(wall)]["name"] = "wall";
    builder.node({{"mesh", wall}, {"translation", {0, 0, 10}}});
    light("sun");
    if (!change.is_null()) builder.json["nodes"][node].merge_patch(change);
    return builder;
}

json visible(bool shown) {
    return {{"extensions", {{"KHR_node_visibility", {{"visible", shown}}}}}};
}

TEST(Gltf, HiddenNodesAndAllBelowThemNeitherShineNorBlock) {
    for (const bool required : {false, true}) {
        GltfBuilder builder = yard_and_house(visible(false));
        required ? builder.require("KHR_node_visibility") : builder.use("KHR_node_visibility");
        // What is visible below a hidden node is hidden all the same.
        builder.json["nodes"][2].merge_patch(visible(true));
        const Scene scene = load(builder);
        EXPECT_EQ(lights_of(scene), "sun ");
        EXPECT_EQ(scene.placed.size(), 1U);
        EXPECT_EQ(scene.bounds.max.z, 0) << "what is hidden has no part in the bounds";
        EXPECT_TRUE(leaves_out(scene, "hidden nodes"));
        EXPECT_FALSE(contains(joined(scene.notices), "KHR_node_visibility"));
    }
    EXPECT_EQ(lights_of(load(yard_and_house(visible(true)))), "lamp sun ");
    EXPECT_EQ(lights_of(load(yard_and_house({{"extensions", {{"KHR_node_visibility", json::object()}}}}))),
              "lamp sun ");
    EXPECT_EQ(lights_of(load(yard_and_house(visible(false), 4))), "lamp ");
    EXPECT_TRUE(contains(error_of(yard_and_house({{"extensions", {{"KHR_node_visibility", {{"visible", 0}}}}}})),
                         "is not true or false"));
}

TEST(Gltf, NodesThatAreScaledToNothingAreHiddenAndFlatOnesAreNot) {
    const json matrix = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 1};
    for (const json& change : {json{{"scale", {0, 0, 0}}}, json{{"matrix", matrix}}}) {
        const Scene scene = load(yard_and_house(change));
        EXPECT_EQ(lights_of(scene), "sun ");
        EXPECT_EQ(scene.placed.size(), 1U);
        EXPECT_EQ(scene.bounds.max.z, 0);
        EXPECT_TRUE(leaves_out(scene, "vanished nodes"));
    }
    // A node's own scale hides its light, too.
    EXPECT_EQ(lights_of(load(yard_and_house({{"scale", {0, 0, 0}}}, 4))), "lamp ");
    const Scene flat = load(yard_and_house({{"scale", {1, 0, 1}}}));
    EXPECT_EQ(lights_of(flat), "lamp sun ");
    EXPECT_FALSE(leaves_out(flat, "vanished nodes"));
    // Nothing is left of three axes where two nodes take some each.
    GltfBuilder by_two = yard_and_house({{"scale", {0, 0, 1}}});
    by_two.json["nodes"][2]["scale"] = {1, 1, 0};
    EXPECT_EQ(lights_of(load(by_two)), "sun ");
    // Of many instances, those of no size.
    GltfBuilder many = triangle();
    many.use("EXT_mesh_gpu_instancing");
    const int scales = many.vec3s({{1, 1, 1}, {0, 0, 0}, {2, 2, 2}});
    const int places = many.vec3s({{0, 0, 0}, {0, 0, 100}, {0, 0, 0}});
    many.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"SCALE", scales},
                                                                                    {"TRANSLATION", places}};
    const Scene scene = load(many);
    EXPECT_EQ(scene.instances.size(), 2U);
    EXPECT_EQ(scene.bounds.max, glm::dvec3(2, 2, 0));
}

TEST(Gltf, IgnoredNodesAreLeftOutWithAllBelowThem) {
    const Scene marked = load(yard_and_house({{"extras", {{"lightgrid", "ignore"}}}}));
    EXPECT_EQ(lights_of(marked), "sun ");
    EXPECT_EQ(marked.bounds.max.z, 0);
    EXPECT_TRUE(leaves_out(marked, "ignored nodes"));
    const auto ignore = [](std::vector<std::string> patterns) {
        return load(yard_and_house(), LoadOptions{.ignore = std::move(patterns)});
    };
    const Scene named = ignore({"house"});
    EXPECT_EQ(lights_of(named), "sun ");
    EXPECT_EQ(named.bounds.max.z, 0);
    EXPECT_TRUE(leaves_out(named, "ignored nodes"));
    EXPECT_EQ(lights_of(ignore({"l?mp"})), "sun ");
    EXPECT_EQ(lights_of(ignore({"s*", "[k-m]amp"})), "");
    // A nameless node goes by its mesh's name; the pattern has to fit as a whole.
    EXPECT_EQ(ignore({"wall"}).placed.size(), 1U);
    EXPECT_EQ(lights_of(ignore({"[lw]a*"})), "sun ");
}

TEST(Gltf, PatternsThatFitNothingOrLeaveNothingAreRefused) {
    const auto problem = [](std::vector<std::string> patterns) {
        try {
            load(yard_and_house(), LoadOptions{.ignore = std::move(patterns)});
        } catch (const Error& error) {
            EXPECT_EQ(error.fault(), Fault::input);
            return std::string(error.what());
        }
        return std::string("no error");
    };
    EXPECT_TRUE(contains(problem({"House", "lamp"}),
                         "no node's name fits \"House\", which is to be left out (the "
                         "nearest names: \"house\", "));
    EXPECT_TRUE(contains(problem({"gate", "garden"}), "\"garden\""));
    EXPECT_TRUE(contains(problem({"*"}), "nothing is left of the level"));
}

TEST(Gltf, MarkersCountWhereTheyAreHiddenButNotWhereTheyAreIgnored) {
    GltfBuilder builder = yard_and_house(visible(false));
    builder.json["nodes"][2]["extras"]["lightgrid"] = "probe";
    EXPECT_EQ(load(builder).probe_markers.size(), 1U);
    EXPECT_EQ(load(builder, LoadOptions{.ignore = {"house"}}).probe_markers.size(), 0U);
}

// Groups of lights

/// Nodes: 0 "hall" {1, 2}, 1 "lamps" (group) {3, 4}, 2 a light, 3 a light, 4 "red" (group) {5}, 5 a light.
GltfBuilder grouped_lights() {
    GltfBuilder builder;
    builder.use("KHR_lights_punctual");
    builder.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
    const auto light = [&] { builder.node({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}); };
    const auto group = [](const char* name) { return json{{"lightgrid", {{"group", name}}}}; };
    builder.node({{"children", {1, 2}}});
    builder.node({{"children", {3, 4}}, {"extras", group("lamps")}});
    light();
    light();
    builder.node({{"children", {5}}, {"extras", group("red")}});
    light();
    return builder;
}

TEST(Gltf, GroupsOfIgnoredNodesAreNone) {
    GltfBuilder builder = grouped_lights();
    builder.json["nodes"][4]["name"] = "lamp";
    EXPECT_EQ(load(builder, LoadOptions{.ignore = {"lamp"}}).groups, std::vector<std::string>{"lamps"});
}

TEST(Gltf, AGroupHoldsBelowItsNodeUpToTheNextGroup) {
    const Scene scene = load(grouped_lights());
    EXPECT_EQ(scene.groups, (std::vector<std::string>{"lamps", "red"}));
    ASSERT_EQ(scene.lights.size(), 3U);
    EXPECT_EQ(scene.lights[0].group, 0);
    EXPECT_EQ(scene.lights[1].group, 1);
    EXPECT_EQ(scene.lights[2].group, -1);
}

TEST(Gltf, ALampInSeveralGroupsIsSeveralMaterialsAndWhatIsDarkStaysOne) {
    GltfBuilder builder;
    builder.add("materials", {{"name", "wall"}});
    builder.add("materials", {{"name", "bulb"}, {"emissiveFactor", {1, 1, 1}}});
    const int positions = builder.vec3s(builder.corners());
    const int dark = builder.mesh({{"attributes", {{"POSITION", positions}}}, {"material", 0}});
    const int lamp = builder.mesh({{"attributes", {{"POSITION", positions}}}, {"material", 1}});
    builder.json["scenes"][0]["nodes"] = json::array();
    const auto stand = [&](int mesh, const char* group) {
        json node{{"mesh", mesh}};
        if (*group != 0) node["extras"]["lightgrid"]["group"] = group;
        builder.node(node);
        builder.json["scenes"][0]["nodes"].push_back(builder.json["nodes"].size() - 1);
    };
    for (const char* group : {"lamps", "signs", ""}) {
        stand(dark, group);
        stand(lamp, group);
        stand(lamp, group);
    }
    const Scene scene = load(builder);
    EXPECT_EQ(scene.groups, (std::vector<std::string>{"lamps", "signs"}));
    std::vector<std::pair<std::string, int>> found;
    for (const Material& material : scene.materials) found.emplace_back(material.name, material.group);
    EXPECT_EQ(found, (std::vector<std::pair<std::string, int>>{{"wall", -1}, {"bulb", -1}, {"bulb", 0}, {"bulb", 1}}));
    EXPECT_EQ(scene.models.size(), 4U);  // each of them stands several times
    EXPECT_EQ(scene.instances.size(), 9U);
}

TEST(Gltf, NoticesGroupsThatAreNone) {
    const auto noticed = [](json marker) {
        GltfBuilder builder = grouped_lights();
        builder.json["nodes"][1]["extras"]["lightgrid"] = std::move(marker);
        const Scene scene = load(builder);
        EXPECT_EQ(scene.groups, std::vector<std::string>{"red"});
        EXPECT_EQ(scene.lights[0].group, -1);
        return joined(scene.notices);
    };
    EXPECT_TRUE(contains(noticed({{"group", "sky"}}), "\"sky\" stands for something else"));
    EXPECT_TRUE(contains(noticed({{"group", "a,b"}}), "\"a,b\" is no name for a group: take 1 to 64 bytes without"));
    EXPECT_TRUE(contains(noticed({{"group", ""}}), "is no name for a group"));
    EXPECT_TRUE(contains(noticed({{"group", std::string(65, 'a')}}), "is no name for a group"));
    EXPECT_TRUE(contains(noticed({{"group", 7}}), "/nodes/1/extras/lightgrid/group"));
    EXPECT_TRUE(contains(noticed({{"grop", "lamps"}}), "has no group"));
    EXPECT_TRUE(contains(noticed(7), "is not a string"));
}

// Extensions

TEST(Gltf, RefusesUnknownRequiredExtensionsByName) {
    GltfBuilder builder = triangle();
    builder.require("EXT_from_the_future");
    builder.require("KHR_texture_transform");
    EXPECT_TRUE(contains(error_of(builder), "the file requires EXT_from_the_future, which cannot be read"));
}

TEST(Gltf, NoticesUnknownExtensionsUnlessTheyChangeNoLight) {
    GltfBuilder builder = triangle();
    builder.use("EXT_from_the_future");
    builder.require("KHR_materials_clearcoat");
    const std::string notices = joined(load(builder).notices);
    EXPECT_TRUE(contains(notices, "EXT_from_the_future"));
    EXPECT_FALSE(contains(notices, "clearcoat"));
}

// Broken things

TEST(Gltf, NamesThePlaceOfABrokenIndex) {
    GltfBuilder builder = triangle();
    builder.json["meshes"][0]["name"] = "arch";
    builder.json["meshes"][0]["primitives"][0]["indices"] = builder.indices({0, 1, 3});
    EXPECT_TRUE(contains(error_of(builder),
                         "level.gltf: mesh \"arch\", primitive 0: indices (accessor 1): index 3, but only 3 vertices"));
}

TEST(Gltf, NamesThePlaceOfAnInfinitePosition) {
    GltfBuilder builder;
    const float infinity = std::numeric_limits<float>::infinity();
    builder.node({{"mesh", builder.mesh({{"attributes",
                                          {{"POSITION", builder.vec3s({{0, 0, 0}, {1, infinity, 0}, {0, 1, 0}})}}}})}});
    EXPECT_TRUE(contains(error_of(builder), "mesh 0, primitive 0: POSITION (accessor 0): element 1 holds inf"));
}

TEST(Gltf, ChecksEveryBound) {
    const auto broken = [](auto change) {
        GltfBuilder builder = triangle();
        json document = builder.finished();
        change(document);
        return error_of(document.dump());
    };
    EXPECT_TRUE(contains(broken([](json& d) { d["accessors"][0]["count"] = 4; }),
                         "reaches byte 48 of buffer view 0, which has 36"));
    EXPECT_TRUE(contains(broken([](json& d) { d["accessors"][0]["count"] = 1e15; }), "accessor 0"));
    EXPECT_TRUE(contains(broken([](json& d) { d["accessors"][0]["count"] = 0; }), "count"));
    EXPECT_TRUE(contains(broken([](json& d) { d["accessors"][0]["byteOffset"] = 9007199254740992; }), "accessor 0"));
    EXPECT_TRUE(contains(broken([](json& d) { d["accessors"][0]["bufferView"] = 7; }), "element 7 of bufferViews"));
    EXPECT_TRUE(contains(broken([](json& d) { d["accessors"][0]["componentType"] = 5130; }), "componentType"));
    EXPECT_TRUE(contains(broken([](json& d) { d["accessors"][0]["componentType"] = 5125; }), "VEC3 of unsigned int"));
    EXPECT_TRUE(contains(broken([](json& d) { d["accessors"][0]["type"] = "VEC4"; }), "VEC4"));
    EXPECT_TRUE(contains(broken([](json& d) { d["accessors"][0].erase("type"); }), "has no type"));
    EXPECT_TRUE(contains(broken([](json& d) { d["bufferViews"][0]["byteLength"] = 40; }),
                         "bytes 0 to 40 of buffer 0, which has only 36"));
    EXPECT_TRUE(contains(broken([](json& d) { d["bufferViews"][0]["byteOffset"] = 1e18; }), "byteOffset"));
    EXPECT_TRUE(contains(broken([](json& d) { d["bufferViews"][0]["byteStride"] = 8; }), "stand only 8 apart"));
    EXPECT_TRUE(contains(broken([](json& d) { d["bufferViews"][0]["buffer"] = -1; }), "not an index"));
    EXPECT_TRUE(contains(broken([](json& d) { d["nodes"][0]["mesh"] = 1; }), "element 1 of meshes, but there are 1"));
    EXPECT_TRUE(contains(broken([](json& d) { d["nodes"][0]["scale"] = {1, 1}; }), "has 2 numbers, not 3"));
    EXPECT_TRUE(contains(broken([](json& d) { d["nodes"][0]["rotation"] = {0, 0, 0, 0}; }), "rotation"));
    EXPECT_TRUE(contains(broken([](json& d) {
                             d["nodes"][0]["matrix"] = json::array({1, 0, 0, 9, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
                         }),
                         "affine"));
    EXPECT_TRUE(contains(broken([](json& d) { d["scene"] = 3; }), "/scene"));
}

TEST(Gltf, AnAccessorWithoutDataCannotAskForMuchMemory) {
    GltfBuilder builder = triangle();
    builder.json["accessors"][0].erase("bufferView");
    builder.json["accessors"][0]["count"] = 4e9;
    EXPECT_TRUE(contains(error_of(builder), "4000000000 elements without data"));
}

TEST(Gltf, WhatNoLightPathReadsMayBeBroken) {
    GltfBuilder builder = with_material({{"normalTexture", {{"index", 99}}}});
    builder.json["asset"]["generator"] = 42;
    builder.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = builder.vec2s({{0, 0}});
    builder.add("materials", {{"alphaMode", "NOT ONE"}, {"name", "unused"}});
    builder.add("cameras", {{"type", "periscope"}});
    builder.json["animations"] = 7;
    builder.add("images", {{"uri", "gone.png"}});
    builder.add("accessors", {{"type", 3}});
    const Scene scene = load(builder);
    EXPECT_EQ(scene.placed.size(), 1U);
    const std::string notices = joined(scene.notices);
    for (const char* place : {"/asset/generator", "/materials/0/normalTexture/index", "/attributes/NORMAL",
                              "material \"unused\"", "/cameras/0/type", "/animations", "gone.png", "/accessors/3"})
        EXPECT_TRUE(contains(notices, place));
}

}  // namespace
}  // namespace lightgrid
