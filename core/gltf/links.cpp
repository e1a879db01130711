#include "core/gltf/links.h"

#include "core/gltf/accessors.h"
#include "core/gltf/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <set>
#include <string_view>

namespace lightgrid::gltf {
namespace {

using tinygltf::Accessor;

constexpr int float_type = TINYGLTF_COMPONENT_TYPE_FLOAT;
constexpr int byte_type = TINYGLTF_COMPONENT_TYPE_BYTE;
constexpr int short_type = TINYGLTF_COMPONENT_TYPE_SHORT;
constexpr int ubyte_type = TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
constexpr int ushort_type = TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
constexpr int uint_type = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;

bool is_one_of(int value, std::initializer_list<int> list) {
    return std::find(list.begin(), list.end(), value) != list.end();
}

bool is_float_or_normalized(const Accessor& accessor) {
    return accessor.componentType == float_type ||
           (accessor.normalized && is_one_of(accessor.componentType, {ubyte_type, ushort_type}));
}

/// What KHR_mesh_quantization adds to floats. Files that forget to name the extension are read all the same.
bool is_float_or_quantized(const Accessor& accessor) {
    return is_one_of(accessor.componentType, {float_type, byte_type, short_type, ubyte_type, ushort_type});
}

/// Whether an attribute may look like this; true for those that no light path reads.
bool has_format(std::string_view attribute, const Accessor& accessor) {
    if (attribute == "POSITION") return accessor.type == TINYGLTF_TYPE_VEC3 && is_float_or_quantized(accessor);
    if (attribute.starts_with("TEXCOORD_"))
        return accessor.type == TINYGLTF_TYPE_VEC2 && is_float_or_quantized(accessor);
    if (attribute.starts_with("COLOR_"))
        return is_one_of(accessor.type, {TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4}) && is_float_or_normalized(accessor);
    if (attribute.starts_with("JOINTS_"))
        return accessor.type == TINYGLTF_TYPE_VEC4 && is_one_of(accessor.componentType, {ubyte_type, ushort_type});
    if (attribute.starts_with("WEIGHTS_"))
        return accessor.type == TINYGLTF_TYPE_VEC4 && is_float_or_normalized(accessor);
    return true;
}

/// The same for EXT_mesh_gpu_instancing.
bool has_instancing_format(std::string_view attribute, const Accessor& accessor) {
    if (attribute == "TRANSLATION" || attribute == "SCALE")
        return accessor.type == TINYGLTF_TYPE_VEC3 && accessor.componentType == float_type;
    if (attribute != "ROTATION") return true;
    return accessor.type == TINYGLTF_TYPE_VEC4 &&
           (accessor.componentType == float_type ||
            (accessor.normalized && is_one_of(accessor.componentType, {byte_type, short_type})));
}

std::string format_of(const Accessor& accessor) {
    static const std::map<int, const char*> types = {{TINYGLTF_TYPE_SCALAR, "SCALAR"}, {TINYGLTF_TYPE_VEC2, "VEC2"},
                                                     {TINYGLTF_TYPE_VEC3, "VEC3"},     {TINYGLTF_TYPE_VEC4, "VEC4"},
                                                     {TINYGLTF_TYPE_MAT2, "MAT2"},     {TINYGLTF_TYPE_MAT3, "MAT3"},
                                                     {TINYGLTF_TYPE_MAT4, "MAT4"}};
    static const std::map<int, const char*> components = {
        {float_type, "float"},           {byte_type, "byte"},
        {short_type, "short"},           {ubyte_type, "unsigned byte"},
        {ushort_type, "unsigned short"}, {uint_type, "unsigned int"}};
    return fmt::format("{} of {}{}", types.at(accessor.type), accessor.normalized ? "normalised " : "",
                       components.at(accessor.componentType));
}

class Links {
  public:
    Links(const tinygltf::Model& model, std::span<const BufferSource> buffers, std::span<const ImageSource> images,
          Findings& findings)
        : model_(model), buffers_(buffers), images_(images), findings_(findings) {
        for (const Finding& finding : findings) broken_.insert(finding.thing);
    }

    void check() {
        for (std::size_t i = 0; i < buffers_.size(); ++i) check_buffer(i);
        for (std::size_t i = 0; i < model_.bufferViews.size(); ++i) check_view(i);
        for (std::size_t i = 0; i < images_.size(); ++i) check_image(i);
        for (std::size_t i = 0; i < model_.accessors.size(); ++i) check_accessor(i);
        for (std::size_t i = 0; i < model_.meshes.size(); ++i) check_mesh(i);
        check_hierarchy();
        for (std::size_t i = 0; i < model_.skins.size(); ++i) check_skin(i);
        for (std::size_t i = 0; i < model_.nodes.size(); ++i) check_node(i);
    }

  private:
    struct Place {
        std::string thing;  // JSON pointer
        std::string name;   // for people
    };

    /// `part`: a JSON pointer from the thing on.
    void bad(const Place& place, const std::string& part, const std::string& problem) {
        findings_.push_back({place.thing, fmt::format("{} ({}{})", place.name, place.thing, part), problem});
    }
    /// The part is read by itself: the rest of the thing may be read without it.
    void bad_part(const Place& place, const std::string& part, const std::string& problem) {
        findings_.push_back({place.thing + part, fmt::format("{} ({}{})", place.name, place.thing, part), problem});
    }
    void harmless(const Place& place, const std::string& part, const std::string& problem) {
        findings_.push_back({"", fmt::format("{} ({}{})", place.name, place.thing, part), problem});
    }

    const Accessor& accessor(int index) const { return model_.accessors[static_cast<std::size_t>(index)]; }
    bool is_broken(int accessor_index) const {
        return !broken_.empty() && broken_.contains(fmt::format("/accessors/{}", accessor_index));
    }
    const tinygltf::BufferView& view(int index) const { return model_.bufferViews[static_cast<std::size_t>(index)]; }

    void check_buffer(std::size_t i) {
        const BufferSource& buffer = buffers_[i];
        const Place place{fmt::format("/buffers/{}", i), buffer.resource.name};
        const std::string_view uri = buffer.resource.data_uri;
        if (!uri.empty() && !uri.starts_with("data:application/octet-stream") &&
            !uri.starts_with("data:application/gltf-buffer"))
            harmless(place, "/uri", "its media type is not that of a buffer");
    }

    void check_image(std::size_t i) {
        const ImageSource& image = images_[i];
        if (image.buffer_view >= 0 && view(image.buffer_view).byteStride != 0)
            harmless({fmt::format("/images/{}", i), image.resource.name}, "/bufferView", "has a byteStride");
    }

    void check_view(std::size_t i) {
        const tinygltf::BufferView& checked = model_.bufferViews[i];
        if (checked.buffer < 0) return;
        const Place place{fmt::format("/bufferViews/{}", i), name_of("buffer view", i, checked.name)};
        const auto check_range = [&](int buffer, std::size_t offset, std::size_t length, const std::string& part) {
            const std::size_t size = buffers_[static_cast<std::size_t>(buffer)].byte_length;
            if (offset > size || length > size - offset)
                bad(place, part,
                    fmt::format("bytes {} to {} of buffer {}, which has only {}", offset, offset + length, buffer,
                                size));
        };
        if (checked.byteStride > checked.byteLength) bad(place, "/byteStride", "is greater than the view");
        if (checked.byteStride != 0 && checked.target == TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER)
            harmless(place, "/byteStride", "means nothing for indices");
        const tinygltf::Value* packed = find_meshopt(checked);
        if (packed == nullptr) return check_range(checked.buffer, checked.byteOffset, checked.byteLength, "");
        const bool ratified = checked.extensions.contains("KHR_meshopt_compression");
        const std::string part = fmt::format("/extensions/{}_meshopt_compression", ratified ? "KHR" : "EXT");
        const auto number = [&](const char* name) { return static_cast<std::size_t>(number_in(*packed, name, 0)); };
        check_range(static_cast<int>(number("buffer")), number("byteOffset"), number("byteLength"), part);
        if (number("count") > checked.byteLength || number("count") * number("byteStride") != checked.byteLength)
            bad(place, part,
                fmt::format("{} elements of {} bytes do not fill the view's {} bytes", number("count"),
                            number("byteStride"), checked.byteLength));
    }

    void check_fit(const Place& place, const std::string& part, int view_index, std::size_t offset, std::size_t count,
                   std::size_t element, std::size_t component) {
        const tinygltf::BufferView& in = view(view_index);
        if (in.buffer < 0) return;
        const std::size_t stride = in.byteStride == 0 ? element : in.byteStride;
        if (stride < element)
            return bad(place, part,
                       fmt::format("its elements have {} bytes, but stand only {} apart", element, stride));
        const std::size_t end = offset + (count - 1) * stride + element;
        if (end > in.byteLength)
            bad(place, part,
                fmt::format("reaches byte {} of buffer view {}, which has {}", end, view_index, in.byteLength));
        else if ((offset + in.byteOffset) % component != 0 || stride % component != 0)
            harmless(place, part, "is not aligned to its component type");
    }

    void check_accessor(std::size_t i) {
        const Accessor& checked = model_.accessors[i];
        const Place place{fmt::format("/accessors/{}", i), name_of("accessor", i, checked.name)};
        const std::size_t component = component_bytes(checked.componentType);
        check_fit(place, "", checked.bufferView, checked.byteOffset, checked.count,
                  element_bytes(checked.type, checked.componentType), component);
        if (checked.normalized && is_one_of(checked.componentType, {float_type, uint_type}))
            harmless(place, "/normalized", "is meant for small integers only");
        if (!checked.sparse.isSparse) return;
        const auto& sparse = checked.sparse;
        const auto count = static_cast<std::size_t>(sparse.count);
        if (count > checked.count)
            bad(place, "/sparse/count", fmt::format("is {}, but the accessor has {} elements", count, checked.count));
        for (const int part : {sparse.indices.bufferView, sparse.values.bufferView})
            if (view(part).byteStride != 0) bad(place, "/sparse", "reads a buffer view with a byteStride");
        const std::size_t index = component_bytes(sparse.indices.componentType);
        check_fit(place, "/sparse/indices", sparse.indices.bufferView,
                  static_cast<std::size_t>(sparse.indices.byteOffset), count, index, index);
        check_fit(place, "/sparse/values", sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset),
                  count, element_bytes(checked.type, checked.componentType), component);
    }

    void check_mesh(std::size_t i) {
        const tinygltf::Mesh& mesh = model_.meshes[i];
        const Place place{fmt::format("/meshes/{}", i), name_of("mesh", i, mesh.name)};
        for (std::size_t j = 0; j < mesh.primitives.size(); ++j) {
            const tinygltf::Primitive& primitive = mesh.primitives[j];
            const std::string part = fmt::format("/primitives/{}", j);
            check_attributes(place, part, primitive);
            if (primitive.targets.size() != mesh.primitives[0].targets.size())
                bad(place, part + "/targets", "has another number of morph targets than the first primitive");
        }
        if (!mesh.weights.empty() && mesh.primitives.size() > 0 &&
            mesh.weights.size() != mesh.primitives[0].targets.size())
            bad(place, "/weights",
                fmt::format("has {} weights, but there are {} morph targets", mesh.weights.size(),
                            mesh.primitives[0].targets.size()));
    }

    void check_attributes(const Place& place, const std::string& part, const tinygltf::Primitive& primitive) {
        const auto position = primitive.attributes.find("POSITION");
        std::map<std::string, int> sets;  // how many of "TEXCOORD" etc. there are
        for (const auto& [name, index] : primitive.attributes) {
            const std::string here = fmt::format("{}/attributes/{}", part, name);
            const Accessor& data = accessor(index);
            if (is_broken(index)) continue;
            if (!has_format(name, data))
                bad_part(place, here, fmt::format("is {} (accessor {})", format_of(data), index));
            else if (position != primitive.attributes.end() && !is_broken(position->second) &&
                     data.count != accessor(position->second).count)
                bad_part(place, here,
                         fmt::format("has {} elements (accessor {}), but there are {} positions", data.count, index,
                                     accessor(position->second).count));
            check_vertex_data(place, here, name, index);
            const std::size_t digits = name.find_last_not_of("0123456789") + 1;
            if (digits > 1 && digits < name.size() && name[digits - 1] == '_' && name[0] != '_')
                ++sets[name.substr(0, digits - 1)];
        }
        for (const auto& [name, count] : sets)
            for (int set = 0; set < count; ++set)
                if (!primitive.attributes.contains(fmt::format("{}_{}", name, set)))
                    harmless(place, part + "/attributes",
                             fmt::format("has {} sets of {}, but not {}_{}", count, name, name, set));
        if (sets["JOINTS"] != sets["WEIGHTS"])
            bad_part(place, part + "/attributes/JOINTS_0",
                     fmt::format("there are {} sets of joints, but {} of weights", sets["JOINTS"], sets["WEIGHTS"]));
        if (primitive.indices >= 0) check_indices(place, part + "/indices", primitive.indices);
        for (std::size_t k = 0; k < primitive.targets.size(); ++k)
            for (const auto& [name, index] : primitive.targets[k]) {
                const std::string here = fmt::format("{}/targets/{}/{}", part, k, name);
                const Accessor& data = accessor(index);
                if (is_broken(index)) continue;
                if (name == "POSITION" && !has_format(name, data))
                    bad_part(place, here, fmt::format("is {} (accessor {})", format_of(data), index));
                const auto base = primitive.attributes.find(name);
                if (base == primitive.attributes.end())
                    harmless(place, here, "has no attribute of that name to change");
                else if (data.count != accessor(base->second).count)
                    bad_part(place, here,
                             fmt::format("has {} elements, but there are {} vertices", data.count,
                                         accessor(base->second).count));
                check_vertex_data(place, here, name, index);
            }
    }

    /// What the specification asks of vertex data, but nothing here depends on.
    void check_vertex_data(const Place& place, const std::string& part, const std::string& name, int index) {
        static constexpr std::string_view known[] = {"POSITION", "NORMAL", "TANGENT"};
        static constexpr std::string_view sets[] = {"TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"};
        const bool is_known = name.starts_with('_') ||
                              std::find(std::begin(known), std::end(known), name) != std::end(known) ||
                              std::any_of(std::begin(sets), std::end(sets), [&](std::string_view set) {
                                  return name.starts_with(set) && name.size() > set.size() &&
                                         name.find_first_not_of("0123456789", set.size()) == std::string::npos;
                              });
        if (!is_known) harmless(place, part, "is no attribute that glTF knows");
        const Accessor& data = accessor(index);
        if (name == "POSITION" && (data.minValues.empty() || data.maxValues.empty()))
            harmless(place, part, "does not declare its bounds (min and max)");
        if (data.componentType == uint_type) harmless(place, part, "is of unsigned integers");
        const tinygltf::BufferView& in = view(data.bufferView);
        if (in.buffer < 0) return;
        if ((in.byteOffset + data.byteOffset) % 4 != 0 || stride_of(data, in) % 4 != 0)
            harmless(place, part, "is not aligned to 4 bytes");
        const auto [reader, first] = view_readers_.emplace(data.bufferView, index);
        if (!first && reader->second != index && in.byteStride == 0 && reader->second != indices_reader)
            harmless(place, part, "shares a buffer view without byteStride");
        if (!first && reader->second == indices_reader) harmless(place, part, "shares a buffer view with indices");
    }

    void check_indices(const Place& place, const std::string& part, int index) {
        const Accessor& data = accessor(index);
        if (is_broken(index)) return;
        if (data.type != TINYGLTF_TYPE_SCALAR || !is_one_of(data.componentType, {ubyte_type, ushort_type, uint_type}))
            bad(place, part, fmt::format("are {} (accessor {})", format_of(data), index));
        if (view(data.bufferView).buffer < 0) return;
        if (view(data.bufferView).byteStride != 0) harmless(place, part, "read a buffer view with a byteStride");
        const auto [reader, first] = view_readers_.emplace(data.bufferView, indices_reader);
        if (!first && reader->second != indices_reader) harmless(place, part, "share a buffer view with vertices");
    }

    void check_skin(std::size_t i) {
        const tinygltf::Skin& skin = model_.skins[i];
        const Place place{fmt::format("/skins/{}", i), name_of("skin", i, skin.name)};
        const auto other_root = [&](int joint) { return root_of(joint) != root_of(skin.joints[0]); };
        if (std::any_of(skin.joints.begin(), skin.joints.end(), other_root))
            harmless(place, "/joints", "have no common root");
        if (skin.inverseBindMatrices < 0) return;
        const Accessor& data = accessor(skin.inverseBindMatrices);
        if (is_broken(skin.inverseBindMatrices)) return;
        if (data.type != TINYGLTF_TYPE_MAT4 || data.componentType != float_type)
            bad(place, "/inverseBindMatrices", fmt::format("are {}", format_of(data)));
        else if (data.count < skin.joints.size())
            bad(place, "/inverseBindMatrices",
                fmt::format("there are {}, but {} joints", data.count, skin.joints.size()));
        if (view(data.bufferView).byteStride != 0)
            harmless(place, "/inverseBindMatrices", "read a buffer view with a byteStride");
    }

    /// Every node has one parent at most, and scenes list nodes that have none: then walking down from a scene's nodes
    /// meets each node once, and ends.
    void check_hierarchy() {
        parents_.assign(model_.nodes.size(), -1);
        for (std::size_t i = 0; i < model_.nodes.size(); ++i)
            for (const int child : model_.nodes[i].children) {
                int& parent = parents_[static_cast<std::size_t>(child)];
                if (parent >= 0)
                    bad(place_of_node(static_cast<std::size_t>(child)), "",
                        fmt::format("is a child of two nodes, {} and {}", parent, i));
                parent = static_cast<int>(i);
            }
        for (std::size_t i = 0; i < model_.scenes.size(); ++i)
            for (const int node : model_.scenes[i].nodes)
                if (parents_[static_cast<std::size_t>(node)] >= 0)
                    bad({fmt::format("/scenes/{}", i), name_of("scene", i, model_.scenes[i].name)}, "/nodes",
                        fmt::format("names node {}, which is a child of node {}", node,
                                    parents_[static_cast<std::size_t>(node)]));
        for (std::size_t i = 0; i < model_.nodes.size(); ++i)
            if (root_of(static_cast<int>(i)) < 0) harmless(place_of_node(i), "", "is its own ancestor");
    }

    Place place_of_node(std::size_t i) const {
        return {fmt::format("/nodes/{}", i), name_of("node", i, model_.nodes[i].name)};
    }

    /// The topmost ancestor of a node, or -1 where there is none because the nodes form a ring. Amortised O(1).
    int root_of(int node) {
        if (roots_.empty()) roots_.assign(model_.nodes.size(), unknown_root);
        std::vector<int> path;
        int at = node;
        while (roots_[static_cast<std::size_t>(at)] == unknown_root && parents_[static_cast<std::size_t>(at)] >= 0) {
            roots_[static_cast<std::size_t>(at)] = -1;  // what is met again on the way is a ring
            path.push_back(at);
            at = parents_[static_cast<std::size_t>(at)];
        }
        int& top = roots_[static_cast<std::size_t>(at)];
        if (top == unknown_root) top = at;
        const int root = top;
        for (const int below : path) roots_[static_cast<std::size_t>(below)] = root;
        return root;
    }

    void check_node(std::size_t i) {
        const tinygltf::Node& node = model_.nodes[i];
        const Place place = place_of_node(i);
        if (const std::vector<double>& m = node.matrix;
            m.size() == 16 && (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1))
            bad(place, "/matrix", "is no affine transform: its last row is not 0 0 0 1");
        if (const std::vector<double>& q = node.rotation; q.size() == 4) {
            const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
            if (length < 1e-6)
                bad(place, "/rotation", "is zero");
            else if (std::abs(length - 1) > 1e-3)
                harmless(place, "/rotation", fmt::format("is a quaternion of length {:.3g}: it is normalised", length));
        }
        if (node.mesh >= 0) check_mesh_use(place, node);
        if (const tinygltf::Value* instancing = find_extension(node.extensions, "EXT_mesh_gpu_instancing"))
            check_instancing(place, *instancing);
    }

    void check_mesh_use(const Place& place, const tinygltf::Node& node) {
        const std::vector<tinygltf::Primitive>& primitives =
            model_.meshes[static_cast<std::size_t>(node.mesh)].primitives;
        const std::size_t targets = primitives.empty() ? 0 : primitives[0].targets.size();
        if (!node.weights.empty() && node.weights.size() != targets)
            bad(place, "/weights",
                fmt::format("has {} weights, but the mesh has {} morph targets", node.weights.size(), targets));
        const auto skinned = [](const tinygltf::Primitive& primitive) {
            return primitive.attributes.contains("JOINTS_0");
        };
        if (node.skin >= 0 && std::none_of(primitives.begin(), primitives.end(), skinned))
            harmless(place, "/skin", "its mesh has no joints: the skin is ignored");
    }

    void check_instancing(const Place& place, const tinygltf::Value& instancing) {
        const std::string part = "/extensions/EXT_mesh_gpu_instancing/attributes";
        const tinygltf::Value& attributes = instancing.Get("attributes");
        std::size_t count = 0;
        for (const std::string& name : attributes.Keys()) {
            const Accessor& data = accessor(attributes.Get(name).GetNumberAsInt());
            if (!has_instancing_format(name, data))
                bad(place, fmt::format("{}/{}", part, name), fmt::format("is {}", format_of(data)));
            if (count != 0 && data.count != count)
                bad(place, part, fmt::format("{} has {} elements, but others have {}", name, data.count, count));
            count = data.count;
        }
    }

    static constexpr int indices_reader = -1;
    static constexpr int unknown_root = -2;

    const tinygltf::Model& model_;
    std::span<const BufferSource> buffers_;
    std::span<const ImageSource> images_;
    Findings& findings_;
    std::set<std::string> broken_;  // things that had findings before
    std::vector<int> parents_;
    std::vector<int> roots_;
    std::map<int, int> view_readers_;  // buffer view -> the accessor that reads vertices from it, or indices_reader
};

}  // namespace

void check_links(const tinygltf::Model& model, std::span<const BufferSource> buffers,
                 std::span<const ImageSource> images, Findings& findings) {
    Links(model, buffers, images, findings).check();
}

}  // namespace lightgrid::gltf
