#pragma once

#include "core/image.h"

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

namespace lightgrid {

/// A folder of its own for a test, removed with all that is in it.
class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "lightgrid-test-XXXXXX").string();
        path_ = mkdtemp(name.data());
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path_); }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

inline void write_bytes(const std::filesystem::path& path, std::string_view bytes) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

inline std::string read_bytes(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

inline std::string base64(std::string_view bytes) {
    static constexpr char alphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k)
            bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? alphabet[bits >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

/// Writes small glTF files: `json` is the document, with one scene that has one node until a test says otherwise; the
/// functions add to its one buffer and to the arrays, and return the index of what they added.
class GltfBuilder {
  public:
    nlohmann::json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}};

    template <typename T>
    int view(const std::vector<T>& values) {
        data_.resize((data_.size() + 3) / 4 * 4);
        const std::size_t offset = data_.size();
        data_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        return add("bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", values.size() * sizeof(T)}});
    }
    /// component: glTF's number for T
    template <typename T>
    int accessor(const std::vector<T>& values, const char* type, int component, std::size_t count,
                 bool normalized = false) {
        nlohmann::json entry = {
            {"bufferView", view(values)}, {"componentType", component}, {"count", count}, {"type", type}};
        if (normalized) entry["normalized"] = true;
        return add("accessors", std::move(entry));
    }
    int vec2s(const std::vector<glm::vec2>& values) { return accessor(values, "VEC2", 5126, values.size()); }
    int vec3s(const std::vector<glm::vec3>& values) { return accessor(values, "VEC3", 5126, values.size()); }
    int vec4s(const std::vector<glm::vec4>& values) { return accessor(values, "VEC4", 5126, values.size()); }
    int indices(const std::vector<std::uint32_t>& values) { return accessor(values, "SCALAR", 5125, values.size()); }

    int add(const std::string& array, nlohmann::json entry) {
        json[array].push_back(std::move(entry));
        return static_cast<int>(json[array].size()) - 1;
    }
    /// The triangle (0,0,0) (1,0,0) (0,1,0), without indices: its front faces +Z.
    int triangle_mesh() { return mesh({{"attributes", {{"POSITION", vec3s(corners())}}}}); }
    int mesh(nlohmann::json primitive) { return add("meshes", {{"primitives", {std::move(primitive)}}}); }
    static std::vector<glm::vec3> corners() { return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}; }
    int node(nlohmann::json entry) { return add("nodes", std::move(entry)); }
    /// An image of these texels in a data URI, and a texture of it.
    int texture(const ByteImage& image, nlohmann::json texture_entry = nlohmann::json::object()) {
        const TemporaryFolder folder;
        write_png(image, folder.path() / "texture.png");
        const std::string png = read_bytes(folder.path() / "texture.png");
        texture_entry["source"] = add("images", {{"uri", "data:image/png;base64," + base64(png)}});
        return add("textures", std::move(texture_entry));
    }
    void use(const std::string& extension) { json["extensionsUsed"].push_back(extension); }
    void require(const std::string& extension) {
        use(extension);
        json["extensionsRequired"].push_back(extension);
    }

    std::string& data() { return data_; }
    [[nodiscard]] nlohmann::json finished() const {
        nlohmann::json document = json;
        if (!data_.empty() && !document.contains("buffers"))
            document["buffers"] = {
                {{"uri", "data:application/octet-stream;base64," + base64(data_)}, {"byteLength", data_.size()}}};
        return document;
    }
    /// The same as .glb.
    [[nodiscard]] std::string glb() const {
        nlohmann::json document = json;
        if (!data_.empty()) document["buffers"] = {{{"byteLength", data_.size()}}};
        std::string text = document.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        std::string binary = data_;
        binary.resize((binary.size() + 3) / 4 * 4);
        const auto number = [](std::uint32_t value) { return std::string(reinterpret_cast<const char*>(&value), 4); };
        const std::string chunks = number(static_cast<std::uint32_t>(text.size())) + "JSON" + text +
                                   number(static_cast<std::uint32_t>(binary.size())) + std::string("BIN\0", 4) + binary;
        return "glTF" + number(2) + number(static_cast<std::uint32_t>(chunks.size() + 12)) + chunks;
    }

  private:
    std::string data_;
};

}  // namespace lightgrid
