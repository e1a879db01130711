#pragma once

#include "core/gltf/finding.h"
#include "core/image.h"

#include <nlohmann/json_fwd.hpp>
#include <tiny_gltf.h>

#include <cstddef>
#include <deque>
#include <filesystem>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <vector>

namespace lightgrid::gltf {

using Bytes = std::span<const std::byte>;
using OwnedBytes = std::vector<std::byte>;

/// Bytes that a document names: in a data URI, in a file, or elsewhere.
struct Resource {
    std::string name;            // of the buffer or image
    std::string data_uri;        // where it is one
    std::filesystem::path file;  // where it is one

    [[nodiscard]] bool is_elsewhere() const { return data_uri.empty() && file.empty(); }
};

struct BufferSource {
    Resource resource;  // elsewhere: the binary chunk of a .glb
    std::size_t byte_length = 0;
    bool placeholder = false;  // has no data: what reads it is compressed
};

struct ImageSource {
    Resource resource;     // elsewhere: in a buffer view
    int buffer_view = -1;  // where it is
};

/// A value made when first asked for, by whichever thread asks. If making it throws, the next one tries again.
template <typename T>
class Lazy {
  public:
    template <typename Make>
    const T& get(Make make) {
        std::call_once(once_, [&] {
            value_ = make();
            made_ = true;
        });
        return value_;
    }
    /// Not while another thread may be making it.
    [[nodiscard]] bool made() const { return made_; }

  private:
    std::once_flag once_;
    T value_;
    bool made_ = false;
};

/// A .gltf or .glb file: its structure checked and parsed, its bytes read from disc and unpacked when asked for.
///
/// tinygltf parses what check_structure leaves of the document, all but buffers and images: tinygltf would read each of
/// them at once, needed or not, and refuses buffers that only hold a place for compressed data.
///
/// Getting a thing throws the Error that was found in it. Reading is safe from several threads.
class Document {
  public:
    /// file    all bytes of it
    /// folder  where it lies: other files are named relative to it
    Document(std::string file, const std::filesystem::path& folder);
    Document(const Document&) = delete;
    Document& operator=(const Document&) = delete;

    /// Everything, including things with findings.
    [[nodiscard]] const tinygltf::Model& model() const { return model_; }
    [[nodiscard]] const std::vector<BufferSource>& buffers() const { return buffers_; }
    [[nodiscard]] const std::vector<ImageSource>& images() const { return images_; }
    [[nodiscard]] const Findings& findings() const { return findings_; }
    [[nodiscard]] bool requires_extension(const char* name) const;
    /// Throws the Error that was found in the thing or part with this JSON pointer, if any. The functions below do so
    /// for what they return.
    void require(const std::string& pointer) const;

    [[nodiscard]] const tinygltf::Accessor& accessor(int index) const;
    [[nodiscard]] const tinygltf::BufferView& view(int index) const;
    [[nodiscard]] const tinygltf::Light& light(int index) const;
    [[nodiscard]] const tinygltf::Material& material(int index) const;
    [[nodiscard]] const tinygltf::Mesh& mesh(int index) const;
    [[nodiscard]] const tinygltf::Node& node(int index) const;
    [[nodiscard]] const tinygltf::Sampler& sampler(int index) const;
    [[nodiscard]] const tinygltf::Scene& scene(int index) const;
    [[nodiscard]] const tinygltf::Skin& skin(int index) const;
    [[nodiscard]] const tinygltf::Texture& texture(int index) const;
    /// `node "lamp"`, `mesh 7`: for people.
    [[nodiscard]] std::string node_name(int index) const;
    [[nodiscard]] std::string mesh_name(int index) const;
    /// Throws if the file's own choice of a scene is wrong.
    [[nodiscard]] int default_scene() const;

    /// The bytes of a buffer view, unpacked if it is compressed; empty for the view of accessors without data.
    [[nodiscard]] Bytes bytes(int view) const;
    /// Reads and decodes an image; keeps nothing of it.
    [[nodiscard]] ByteImage image(int index) const;
    [[nodiscard]] bool was_read(std::size_t image) const { return images_read_[image] != 0; }
    /// Encoded size of an image; 0 where it does not exist.
    [[nodiscard]] std::size_t encoded_bytes(const ImageSource& image) const;

    /// Problems of buffers and images that nothing has read.
    [[nodiscard]] Findings check_unread() const;

  private:
    void parse(Bytes text);
    template <typename T>
    const T& get(const std::vector<T>& list, const char* array, int index) const;
    [[nodiscard]] Bytes buffer_bytes(int index) const;
    [[nodiscard]] Resource resource_of(const std::string& kind, std::size_t index, const nlohmann::json& source);

    std::filesystem::path folder_;
    std::string file_;
    bool binary_ = false;
    Bytes binary_chunk_;  // in file_
    tinygltf::Model model_;
    std::vector<BufferSource> buffers_;
    std::vector<ImageSource> images_;
    Findings findings_;
    std::map<std::string, std::size_t> broken_;  // JSON pointer of a thing -> its first finding
    mutable std::deque<Lazy<std::string>> buffer_data_;
    mutable std::deque<Lazy<OwnedBytes>> unpacked_views_;
    mutable std::vector<char> images_read_;
};

/// A number of an extension's object, or `fallback`.
[[nodiscard]] double number_in(const tinygltf::Value& object, const char* name, double fallback);
/// The object of an extension, or nullptr.
[[nodiscard]] const tinygltf::Value* find_extension(const tinygltf::ExtensionMap& extensions, const char* name);

/// How a buffer view is packed: by KHR_meshopt_compression, or by EXT_meshopt_compression, whose formats it includes. Null:
/// it is not.
[[nodiscard]] const tinygltf::Value* find_meshopt(const tinygltf::BufferView& view);

}  // namespace lightgrid::gltf
