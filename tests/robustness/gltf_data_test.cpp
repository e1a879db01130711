// Real levels, torture tests and broken files that lie outside the repository.

#include "core/error.h"
#include "core/gltf.h"
#include "tests/gltf_builder.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path data_folder = fs::path(LIGHTGRID_SHARED) / "data";

/// A row of the tables of levels in INDEX.md.
struct Listed {
    std::string file;
    std::string triangles;
    std::string size;
    std::string lights;
    std::string extensions;
};

std::vector<Listed> read_index() {
    std::vector<Listed> rows;
    std::ifstream index(data_folder / "INDEX.md");
    for (std::string line; std::getline(index, line);) {
        std::vector<std::string> cells;
        std::istringstream stream(line);
        for (std::string cell; std::getline(stream, cell, '|');) {
            const std::size_t begin = cell.find_first_not_of(' ');
            cells.push_back(begin == std::string::npos ? ""
                                                       : cell.substr(begin, cell.find_last_not_of(' ') + 1 - begin));
        }
        // | file | triangles | mesh nodes | size | lights | emit | images | alpha | extensions |
        if (cells.size() >= 10 && (cells[1].ends_with(".glb") || cells[1].ends_with(".gltf")))
            rows.push_back({cells[1], cells[2], cells[4], cells[5], cells[9]});
    }
    return rows;
}

std::size_t triangles_of(const Scene& scene) {
    std::size_t count = 0;
    for (const int mesh : scene.placed) count += scene.meshes[static_cast<std::size_t>(mesh)].triangles.size();
    for (const Instance& instance : scene.instances)
        for (const int mesh : scene.models[static_cast<std::size_t>(instance.model)].meshes)
            count += scene.meshes[static_cast<std::size_t>(mesh)].triangles.size();
    // Those without area, or that cannot be seen, are counted in what the loader says about them.
    for (const std::string& notice : scene.notices)
        if (notice.ends_with(" triangles have no area and are left out")) count += std::stoul(notice);
    for (const LeftOut& entry : scene.left_out)
        if (entry.what == "invisible surfaces") count += std::stoul(entry.saved);
    return count;
}

TEST(GltfData, EveryListedFileLoadsWithItsTrianglesLightsAndSize) {
    const std::vector<Listed> rows = read_index();
    if (rows.empty()) GTEST_SKIP() << "no levels in " << data_folder;
    EXPECT_GT(rows.size(), 90U);
    // INDEX.md lists sizes of the stored vertices: before skins and morphs, with points, lines and triangles without
    // area.
    const std::set<std::string> other_size = {"level-littlest-tokyo/LittlestTokyo.glb",
                                              "feat-SimpleMorph/glTF/SimpleMorph.gltf",
                                              "feat-SimpleSkin/glTF/SimpleSkin.gltf"};
    for (const Listed& row : rows) {
        SCOPED_TRACE(row.file);
        Scene scene;
        try {
            scene = load_level(data_folder / row.file);
        } catch (const Error& error) {
            ADD_FAILURE() << error.what();
            continue;
        }
        std::size_t times =
            1;  // INDEX.md counts what a node's mesh has, however often EXT_mesh_gpu_instancing repeats it
        if (row.extensions.find("mesh_gpu_instancing") != std::string::npos) times = scene.instances.size();
        EXPECT_EQ(triangles_of(scene), times * std::stoul(row.triangles));
        EXPECT_EQ(scene.lights.size(), std::stoul(row.lights));
        double x = 0;
        double y = 0;
        double z = 0;
        const bool comparable = times == 1 && !other_size.contains(row.file) && row.triangles != "0" &&
                                row.file.find("PrimitiveModes") == std::string::npos;
        if (comparable && std::sscanf(row.size.c_str(), "%lf x %lf x %lf", &x, &y, &z) == 3) {
            // Three digits are listed.
            EXPECT_NEAR(scene.bounds.size().x, x, 0.0051 * x + 1e-6);
            EXPECT_NEAR(scene.bounds.size().y, y, 0.0051 * y + 1e-6);
            EXPECT_NEAR(scene.bounds.size().z, z, 0.0051 * z + 1e-6);
        }
        for (const Mesh& mesh : scene.meshes) EXPECT_GT(mesh.positions.capacity(), mesh.positions.size());
    }
}

TEST(GltfData, GeometryTakesAtMost32BytesAVertexAnd16ATriangle) {
    const std::vector<Listed> rows = read_index();
    if (rows.empty()) GTEST_SKIP() << "no levels in " << data_folder;
    for (const Listed& row : rows) {
        if (!row.file.starts_with("level-") && !row.file.starts_with("map-")) continue;
        const Scene scene = load_level(data_folder / row.file);
        std::size_t vertices = 0;
        std::size_t triangles = 0;
        std::size_t bytes = 0;
        for (const Mesh& mesh : scene.meshes) {
            vertices += mesh.positions.size();
            triangles += mesh.triangles.size();
            bytes += mesh.positions.capacity() * sizeof(glm::vec3) + mesh.triangles.capacity() * sizeof(glm::uvec3) +
                     mesh.colors.capacity() * sizeof(glm::u16vec4);
            for (const auto& set : mesh.uv_sets) bytes += set.capacity() * sizeof(glm::vec2);
        }
        EXPECT_LE(bytes, 32 * vertices + 16 * triangles) << row.file;
    }
}

/// What the loader says to a file beyond what it says to any file like it that is whole.
std::string remarks(const fs::path& file) {
    try {
        const Scene scene = load_level(file);
        std::string text;
        for (const std::string& notice : scene.notices) {
            const auto says = [&](const char* part) { return notice.find(part) != std::string::npos; };
            if (!says("the file has no scene") && !says("the level has no triangles") &&
                !says("its albedo is clamped") && !says("no primitive has a material"))
                text += notice + "\n";
        }
        return text;
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::input);
        return error.what();
    }
}

/// Codes of the official validator that pass without a remark, because nothing that light paths read depends on them.
const std::map<std::string, std::string> unremarked = {
    // Data that nothing in the scene reads is not looked at.
    {"ACCESSOR_INVALID_FLOAT", "data"},
    {"ACCESSOR_ELEMENT_OUT_OF_MAX_BOUND", "data"},
    {"ACCESSOR_ELEMENT_OUT_OF_MIN_BOUND", "data"},
    {"ACCESSOR_MAX_MISMATCH", "data"},
    {"ACCESSOR_MIN_MISMATCH", "data"},
    {"ACCESSOR_INVALID_IBM", "data"},
    {"ACCESSOR_INDEX_OOB", "data"},
    {"ACCESSOR_INDEX_PRIMITIVE_RESTART", "data"},
    {"ACCESSOR_NON_CLAMPED", "data"},
    {"ACCESSOR_INVALID_SIGN", "data"},
    {"ACCESSOR_VECTOR3_NON_UNIT", "data"},
    {"IMAGE_DATA_INVALID", "data"},
    {"IMAGE_UNEXPECTED_EOS", "data"},
    {"MESH_PRIMITIVE_TOO_FEW_TEXCOORDS", "data"},
    // Images are known by their content, not by what is said about it.
    {"IMAGE_MIME_TYPE_INVALID", "media type"},
    {"INVALID_URI", "media type of a data URI"},
    // Skins are posed by their joints alone.
    {"SKIN_SKELETON_INVALID", "skeleton root"},
};

TEST(GltfData, BrokenFilesGetAnErrorOrANotice) {
    const fs::path folder = data_folder / "invalid-gltf-validator";
    if (!fs::is_directory(folder)) GTEST_SKIP() << "no " << folder;
    int broken = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        const std::string suffix = ".report.json";
        const std::string name = entry.path().string();
        if (!name.ends_with(suffix)) continue;
        const fs::path file = name.substr(0, name.size() - suffix.size());
        std::set<std::string> codes;
        const json report = json::parse(std::ifstream(entry.path()));
        for (const json& message : report.at("issues").at("messages"))
            if (message["severity"] == 0) codes.insert(message["code"]);
        const std::string said = remarks(file);  // for whole files too: no crash
        broken += codes.empty() ? 0 : 1;
        if (codes.empty() || !said.empty()) continue;
        for (const std::string& code : codes) EXPECT_TRUE(unremarked.contains(code)) << file << ": " << code;
    }
    EXPECT_GT(broken, 150);
}

TEST(GltfData, OtherBrokenFilesDoNoHarm) {
    const fs::path folder = data_folder / "invalid-assimp";
    if (!fs::is_directory(folder)) GTEST_SKIP() << "no " << folder;
    for (const char* broken :
         {"IndexOutOfRange/IndexOutOfRange.gltf", "IndexOutOfRange/AllIndicesOutOfRange.gltf",
          "RecursiveNodes/RecursiveNodes.gltf", "MissingBin/BoxTextured.gltf", "wrongTypes/badArray.gltf",
          "wrongTypes/badUint.gltf", "wrongTypes/badObject.gltf", "wrongTypes/badExtension.gltf",
          "BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb", "SchemaFailures/sceneWrongType.gltf"})
        EXPECT_THROW(static_cast<void>(load_level(folder / broken)), Error) << broken;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.path().extension() == ".gltf" || entry.path().extension() == ".glb") remarks(entry.path());
}

/// A small file, and which file of its folder to spoil.
struct Sample {
    const char* level;
    const char* spoiled;
};

constexpr Sample samples[] = {
    {"feat-Box/glTF-Binary/Box.glb", "Box.glb"},
    {"feat-gltf-transform/BoxMeshopt.glb", "BoxMeshopt.glb"},
    {"feat-meshoptimizer/fuzz.glb", "fuzz.glb"},
    {"feat-SimpleInstancing/glTF-Binary/SimpleInstancing.glb", "SimpleInstancing.glb"},
    {"feat-gltf-transform/BoxDraco.gltf", "BoxDraco.gltf"},
    {"feat-Box/glTF-Draco/Box.gltf", "Box.bin"},
    {"feat-SimpleSkin/glTF/SimpleSkin.gltf", "SimpleSkin.gltf"},
    {"feat-SimpleSkin/glTF/SimpleSkin.gltf", "skinGeometry.bin"},
    {"feat-SimpleMorph/glTF/SimpleMorph.gltf", "SimpleMorph.gltf"},
};

/// Calls spoil(whole bytes, try) for each sample; try(bytes) loads the level with the spoiled file as given, and
/// anything but a scene or an Error fails the test.
template <typename Spoil>
void spoil_samples(Spoil spoil) {
    for (const Sample& sample : samples) {
        SCOPED_TRACE(sample.spoiled);
        const fs::path level = data_folder / sample.level;
        const TemporaryFolder folder;
        for (const auto& entry : fs::directory_iterator(level.parent_path()))
            if (entry.is_regular_file() && entry.file_size() < 1000000)
                fs::copy(entry.path(), folder.path() / entry.path().filename());
        const fs::path spoiled = folder.path() / sample.spoiled;
        const std::string whole = read_bytes(spoiled);
        ASSERT_FALSE(whole.empty());
        spoil(whole, [&](const std::string& bytes) {
            fs::remove(spoiled);  // some file systems wait for the disk where a file is overwritten
            write_bytes(spoiled, bytes);
            try {
                static_cast<void>(load_level(folder.path() / level.filename()));
            } catch (const Error&) {
            }
        });
    }
}

TEST(GltfData, EveryPrefixOfAFileIsSafe) {
    if (!fs::is_directory(data_folder)) GTEST_SKIP() << "no " << data_folder;
    spoil_samples([](const std::string& whole, auto load) {
        const std::size_t step = std::max<std::size_t>(1, whole.size() / 500);
        for (std::size_t length = 0; length < whole.size(); length += step) load(whole.substr(0, length));
    });
}

TEST(GltfData, EveryFlippedByteIsSafe) {
    if (!fs::is_directory(data_folder)) GTEST_SKIP() << "no " << data_folder;
    spoil_samples([](const std::string& whole, auto load) {
        const std::size_t step = std::max<std::size_t>(1, whole.size() / 300);
        for (std::size_t i = 0; i < whole.size(); i += step)
            for (const char change : {'\x01', '\x80', '\xFF'}) {
                std::string changed = whole;
                changed[i] = static_cast<char>(changed[i] ^ change);
                load(changed);
            }
    });
}

}  // namespace
}  // namespace lightgrid
