// Levels that meshoptimizer has packed, by both names of the extension.

#include "core/error.h"
#include "core/gltf.h"
#include "tests/gltf_builder.h"

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <array>

namespace lightgrid {
namespace {

using nlohmann::json;
using Stream = std::vector<unsigned char>;

template <typename T>
Stream packed_vertices(const std::vector<T>& values) {
    Stream stream(meshopt_encodeVertexBufferBound(values.size(), sizeof(T)));
    stream.resize(meshopt_encodeVertexBuffer(stream.data(), stream.size(), values.data(), values.size(), sizeof(T)));
    return stream;
}

/// A triangle whose buffer views a test packs.
class PackedTriangle {
  public:
    explicit PackedTriangle(std::string extension) : extension_(std::move(extension)) {
        builder_.require(extension_);
        builder_.node({{"mesh", builder_.mesh({{"attributes", json::object()}})}});
    }

    /// The view's plain data is in a buffer that has none: the second one.
    int accessor(const Stream& stream, std::size_t count, std::size_t stride, const char* mode, json accessor,
                 const char* filter = "NONE") {
        const int packed = builder_.view(stream);
        const json source = builder_.json["bufferViews"][static_cast<std::size_t>(packed)];
        json view{{"buffer", 1}, {"byteOffset", plain_}, {"byteLength", count * stride}};
        plain_ += (count * stride + 3) / 4 * 4;
        view["extensions"][extension_] = {{"buffer", 0},
                                          {"byteOffset", source["byteOffset"]},
                                          {"byteLength", source["byteLength"]},
                                          {"count", count},
                                          {"byteStride", stride},
                                          {"mode", mode},
                                          {"filter", filter}};
        accessor["bufferView"] = builder_.add("bufferViews", std::move(view));
        accessor["count"] = count;
        return builder_.add("accessors", std::move(accessor));
    }
    void positions(const Stream& stream) {
        primitive()["attributes"]["POSITION"] =
            accessor(stream, 3, sizeof(glm::vec3), "ATTRIBUTES", {{"componentType", 5126}, {"type", "VEC3"}});
    }
    json& primitive() { return builder_.json["meshes"][0]["primitives"][0]; }

    [[nodiscard]] Scene load() const {
        json document = builder_.finished();
        document["buffers"].push_back(
            {{"byteLength", std::max<std::size_t>(plain_, 4)}, {"extensions", {{extension_, {{"fallback", true}}}}}});
        const TemporaryFolder folder;
        write_bytes(folder.path() / "level.gltf", document.dump());
        return load_level(folder.path() / "level.gltf");
    }

  private:
    std::string extension_;
    GltfBuilder builder_;
    std::size_t plain_ = 0;
};

class Meshopt : public testing::TestWithParam<const char*> {};

TEST_P(Meshopt, UnpacksVerticesAndIndices) {
    const std::vector<glm::vec3> corners{{0, 0, 0}, {3, 0, 0}, {0, 2, 0}};
    const std::vector<std::uint32_t> indices{0, 1, 2};
    PackedTriangle level(GetParam());
    level.positions(packed_vertices(corners));
    Stream triangles(meshopt_encodeIndexBufferBound(3, 3));
    triangles.resize(meshopt_encodeIndexBuffer(triangles.data(), triangles.size(), indices.data(), 3));
    level.primitive()["indices"] =
        level.accessor(triangles, 3, 2, "TRIANGLES", {{"componentType", 5123}, {"type", "SCALAR"}});
    const Scene scene = level.load();
    ASSERT_EQ(scene.meshes.size(), 1U);
    EXPECT_EQ(scene.bounds.min, glm::dvec3(0));
    EXPECT_EQ(scene.bounds.max, glm::dvec3(3, 2, 0));
    EXPECT_EQ(scene.meshes[0].triangles, std::vector<glm::uvec3>{glm::uvec3(0, 1, 2)});
}

TEST_P(Meshopt, AttributesThatTheLibraryCannotReadAreRefusedByTheirVersion) {
#if MESHOPTIMIZER_VERSION >= 230
    GTEST_SKIP() << "this meshoptimizer reads version 1";
#else
    PackedTriangle level(GetParam());
    Stream stream = packed_vertices(GltfBuilder::corners());
    stream[0] = 0xa1;
    level.positions(stream);
    try {
        static_cast<void>(level.load());
        ADD_FAILURE() << "no error";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("packed by version 1 of the format"), std::string::npos)
            << error.what();
    }
#endif
}

INSTANTIATE_TEST_SUITE_P(Of, Meshopt, testing::Values("EXT_meshopt_compression", "KHR_meshopt_compression"),
                         [](const auto& named) { return std::string(named.param, 3); });

/// Y, Co, Cg and alpha with K bits, of the highest bit of alpha.
TEST(KhrMeshopt, ColorsAreUnpackedFromLumaAndChroma) {
    const auto colors_of = [](const auto& packed, int component) {
        PackedTriangle level("KHR_meshopt_compression");
        level.positions(packed_vertices(GltfBuilder::corners()));
        level.primitive()["attributes"]["COLOR_0"] =
            level.accessor(packed_vertices(packed), 3, sizeof(packed[0]), "ATTRIBUTES",
                           {{"componentType", component}, {"type", "VEC4"}, {"normalized", true}}, "COLOR");
        return level.load().meshes.at(0).colors;
    };
    // 8 bits: 113 + 75 + 12, 113 - 12, 113 - 75 + 12. 4 bits: 7 + 2 - 1, 7 + 1, 7 - 2 - 1 of 15, alpha 3 of 7 is 7 of 15.
    const std::vector<std::array<std::uint8_t, 4>> bytes{
        {113, 75, static_cast<std::uint8_t>(-12), 255}, {7, 2, 1, 8 | 3}, {0, 0, 0, 128}};
    const std::vector<glm::u16vec4> got = colors_of(bytes, 5121);
    ASSERT_EQ(got.size(), 3U);
    EXPECT_EQ(got[0], glm::u16vec4(200 * 257, 101 * 257, 50 * 257, 65535));
    EXPECT_EQ(got[1], glm::u16vec4(136 * 257, 136 * 257, 68 * 257, 119 * 257));
    EXPECT_EQ(got[2], glm::u16vec4(0));
    const std::vector<std::array<std::uint16_t, 4>> words{
        {30000, 10000, static_cast<std::uint16_t>(-5000), 65535}, {0, 0, 0, 1 << 15}, {0, 0, 0, 1 << 15}};
    EXPECT_EQ(colors_of(words, 5123).at(0), glm::u16vec4(45000, 25000, 25000, 65535));
}

}  // namespace
}  // namespace lightgrid
