#include "core/gltf/meshes.h"

#include "core/error.h"
#include "core/gltf/accessors.h"
#include "core/gltf/compression.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

namespace lightgrid::gltf {
namespace {

using Triangles = std::vector<glm::uvec3>;

/// The vertex data of one primitive, wherever the file keeps it.
class Primitive {
  public:
    Primitive(const Document& document, const PrimitiveRequest& request)
        : document_(document),
          pointer_(fmt::format("/meshes/{}/primitives/{}", request.mesh, request.primitive)),
          source_(document.mesh(request.mesh).primitives[static_cast<std::size_t>(request.primitive)]) {
        const tinygltf::Value* draco = find_extension(source_.extensions, "KHR_draco_mesh_compression");
        // Where the file has the data uncompressed too, that is quicker to read, and exact.
        if (draco == nullptr || (!document.requires_extension("KHR_draco_mesh_compression") && has_plain_data()))
            return;
        const tinygltf::Value& ids = draco->Get("attributes");
        std::map<std::string, int> draco_ids;
        for (const std::string& name : ids.Keys())
            if (is_read(name, request)) draco_ids.emplace(name, ids.Get(name).GetNumberAsInt());
        draco_ = unpack_draco(document.bytes(draco->Get("bufferView").GetNumberAsInt()), draco_ids);
    }

    [[nodiscard]] const tinygltf::Primitive& source() const { return source_; }
    [[nodiscard]] bool has(const std::string& attribute) const { return source_.attributes.contains(attribute); }

    [[nodiscard]] Elements elements(const std::string& attribute) const {
        const auto found = source_.attributes.find(attribute);
        if (found == source_.attributes.end()) throw Error("is missing", attribute, "Export the mesh again.");
        const int accessor = found->second;
        const std::string where = fmt::format("{} (accessor {})", attribute, accessor);
        document_.require(fmt::format("{}/attributes/{}", pointer_, attribute));
        const auto unpacked =
            draco_ ? draco_->attributes.find(attribute) : std::map<std::string, DracoMesh::Attribute>::const_iterator();
        if (!draco_ || unpacked == draco_->attributes.end()) {
            Elements elements = elements_of(document_, accessor, attribute);
            if (draco_ && elements.count != draco_->vertex_count)
                throw Error(fmt::format("has {} elements, but the Draco data has {} vertices", elements.count,
                                        draco_->vertex_count),
                            where);
            return elements;
        }
        const DracoMesh::Attribute& data = unpacked->second;
        const tinygltf::Accessor& declared = document_.accessor(accessor);
        Elements elements;
        elements.where = where;
        elements.data = data.data;
        elements.count = draco_->vertex_count;
        elements.component_type = data.component_type;
        elements.components = data.components;
        elements.stride = component_bytes(data.component_type) * static_cast<std::size_t>(data.components);
        elements.normalized = declared.normalized;
        const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(declared.type));
        if (data.components != components)
            throw Error(fmt::format("the Draco data has {} components, not {}", data.components, components), where);
        return elements;
    }

    /// Of the morph target's vertices; nothing where it does not move them.
    [[nodiscard]] std::optional<Elements> target_positions(std::size_t target) const {
        const auto found = source_.targets[target].find("POSITION");
        if (found == source_.targets[target].end()) return std::nullopt;
        document_.require(fmt::format("{}/targets/{}/POSITION", pointer_, target));
        return elements_of(document_, found->second, fmt::format("morph target {}, POSITION", target));
    }

    /// Three for each triangle, whatever the mode; each checked to be a vertex.
    [[nodiscard]] Triangles triangles(std::size_t vertex_count, std::size_t& left_over) const {
        std::vector<std::uint32_t> indices;
        if (draco_) {
            indices = draco_->indices;
        } else if (source_.indices >= 0) {
            indices = read_indices(elements_of(document_, source_.indices, "indices"));
        } else {
            indices.resize(vertex_count);
            std::iota(indices.begin(), indices.end(), 0U);
        }
        const auto most = std::max_element(indices.begin(), indices.end());
        if (most != indices.end() && *most >= vertex_count)
            throw Error(fmt::format("index {}, but only {} vertices", *most, vertex_count),
                        fmt::format("indices (accessor {})", source_.indices), "Export the mesh again.");
        return assemble(indices, draco_ ? TINYGLTF_MODE_TRIANGLES : source_.mode, left_over);
    }

  private:
    [[nodiscard]] bool has_plain_data() const {
        const auto position = source_.attributes.find("POSITION");
        return position != source_.attributes.end() &&
               document_.view(document_.accessor(position->second).bufferView).buffer >= 0;
    }
    /// Source: glTF 2.0, 3.7.2.1 "Overview" of mesh primitives.
    static Triangles assemble(const std::vector<std::uint32_t>& indices, int mode, std::size_t& left_over) {
        Triangles triangles;
        const std::size_t count = indices.size();
        if (mode == TINYGLTF_MODE_TRIANGLES) {
            left_over = count % 3;
            triangles.resize(count / 3);
            for (std::size_t i = 0; i < triangles.size(); ++i)
                triangles[i] = {indices[3 * i], indices[3 * i + 1], indices[3 * i + 2]};
            return triangles;
        }
        left_over = count < 3 ? count : 0;
        if (count < 3) return triangles;
        triangles.resize(count - 2);
        for (std::size_t i = 0; i + 2 < count; ++i)
            triangles[i] = mode == TINYGLTF_MODE_TRIANGLE_STRIP
                               ? glm::uvec3(indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2])
                               : glm::uvec3(indices[i + 1], indices[i + 2], indices[0]);
        return triangles;
    }

    const Document& document_;
    std::string pointer_;
    const tinygltf::Primitive& source_;
    std::optional<DracoMesh> draco_;
};

/// Renumbers the vertices of triangles so that only those in use remain, in their order. Returns their old numbers, or
/// nothing if all are in use. Many primitives may share one large array of vertices: then the cost is that of their
/// triangles, not of the array. There is at least one triangle.
std::vector<std::uint32_t> keep_used_vertices(Triangles& triangles, std::size_t vertex_count) {
    std::vector<std::uint32_t> used;
    const std::span<std::uint32_t> corners(&triangles.data()->x, 3 * triangles.size());
    if (corners.size() < vertex_count / 8) {
        used.assign(corners.begin(), corners.end());
        std::sort(used.begin(), used.end());
        used.erase(std::unique(used.begin(), used.end()), used.end());
        for (std::uint32_t& corner : corners)
            corner = static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), corner) - used.begin());
        return used;
    }
    std::vector<std::uint32_t> numbers(vertex_count);
    for (const std::uint32_t corner : corners) numbers[corner] = 1;
    std::uint32_t next = 0;
    for (std::uint32_t& number : numbers) number = std::exchange(next, next + number);
    if (next == vertex_count) return {};
    used.resize(next);
    for (const std::uint32_t corner : corners) used[numbers[corner]] = corner;
    for (std::uint32_t& corner : corners) corner = numbers[corner];
    return used;
}

/// The same for a mesh that has positions already, read from the vertices `picks`.
void keep_used_vertices(Mesh& mesh, std::vector<std::uint32_t>& picks) {
    const std::vector<std::uint32_t> used = keep_used_vertices(mesh.triangles, mesh.positions.size());
    if (used.empty()) return;
    std::vector<std::uint32_t> still_picked(used.size());
    std::vector<glm::vec3> positions(used.size());
    for (std::size_t i = 0; i < used.size(); ++i) {
        positions[i] = mesh.positions[used[i]];
        still_picked[i] = picks.empty() ? used[i] : picks[used[i]];
    }
    mesh.positions = std::move(positions);
    picks = std::move(still_picked);
}

void morph(const Primitive& primitive, const PrimitiveRequest& request, Picks picks, std::vector<glm::vec3>& positions,
           std::size_t vertex_count) {
    for (std::size_t target = 0; target < request.weights.size(); ++target) {
        const auto weight = static_cast<float>(request.weights[target]);
        if (weight == 0) continue;
        const std::optional<Elements> moves = primitive.target_positions(target);
        if (!moves) continue;
        if (moves->count != vertex_count)
            throw Error(fmt::format("has {} elements, but there are {} vertices", moves->count, vertex_count),
                        moves->where);
        const std::vector<glm::vec3> offsets = read_vectors<3>(*moves, picks);
        for (std::size_t i = 0; i < positions.size(); ++i) positions[i] += weight * offsets[i];
    }
}

/// The transforms of a skin's joints at rest: global transform times inverse bind matrix, to level coordinates.
std::vector<glm::dmat4> joint_transforms(const Document& document, const PrimitiveRequest& request) {
    const tinygltf::Skin& skin = document.skin(request.skin);
    const std::string where = name_of("skin", static_cast<std::size_t>(request.skin), skin.name);
    std::vector<glm::dmat4> result(skin.joints.size(), glm::dmat4(1));
    if (skin.inverseBindMatrices >= 0) {
        const Elements elements = elements_of(document, skin.inverseBindMatrices, "inverseBindMatrices");
        const std::vector<glm::dmat4> inverse = read_matrices(elements);
        std::copy_n(inverse.begin(), result.size(), result.begin());
    }
    for (std::size_t i = 0; i < result.size(); ++i) {
        constexpr double most_error = 1e-3;
        const glm::dvec4 last_row(result[i][0].w, result[i][1].w, result[i][2].w, result[i][3].w - 1);
        if (glm::length(last_row) > most_error)
            throw Error(fmt::format("inverse bind matrix {} is not affine: its last row is not 0 0 0 1", i), where);
        const int joint = skin.joints[i];
        const std::optional<glm::dmat4>& global = request.node_transforms[static_cast<std::size_t>(joint)];
        if (!global)
            throw Error(fmt::format("its joint, node {}, is not in the scene", joint), where,
                        "Export the scene with its skeleton.");
        result[i][0].w = result[i][1].w = result[i][2].w = 0;
        result[i][3].w = 1;
        result[i] = *global * result[i];
    }
    return result;
}

/// Moves vertices to where their joints take them, relative to where the first comes to be. The transform of the mesh's
/// own node has no part in it. Source: glTF 2.0, 3.7.3.3 "Skinned Mesh Attributes".
void skin(const Document& document, const Primitive& primitive, const PrimitiveRequest& request, Picks picks,
          LoadedPrimitive& loaded) {
    const std::vector<glm::dmat4> joints = joint_transforms(document, request);
    const auto joint_of = [&](std::uint32_t joint) -> const glm::dmat4& {
        if (joint < joints.size()) return joints[joint];
        throw Error(fmt::format("joint {}, but the skin has only {}", joint, joints.size()), "JOINTS",
                    "Export the mesh again.");
    };
    std::vector<glm::vec3>& positions = loaded.mesh.positions;
    std::vector<glm::dvec4> sums(positions.size(), glm::dvec4(0));  // weighted positions; w: the weights
    std::vector<std::uint32_t> first_joints;
    for (int set = 0; primitive.has(fmt::format("JOINTS_{}", set)); ++set) {
        const std::vector<glm::uvec4> indices = read_joints(primitive.elements(fmt::format("JOINTS_{}", set)), picks);
        const std::vector<glm::vec4> weights =
            read_vectors<4>(primitive.elements(fmt::format("WEIGHTS_{}", set)), picks);
        if (set == 0)
            for (const glm::uvec4& joint : indices) first_joints.push_back(joint.x);
        for (std::size_t i = 0; i < positions.size(); ++i)
            for (int k = 0; k < 4; ++k)
                if (const double weight = weights[i][k]; weight != 0)
                    sums[i] += weight * (joint_of(indices[i][k]) * glm::dvec4(positions[i], 1));
    }
    for (std::size_t i = 0; i < positions.size(); ++i) {
        if (sums[i].w == 0) {
            sums[i] = joint_of(first_joints[i]) * glm::dvec4(positions[i], 1);
            loaded.unweighted = true;
        }
        if (!(sums[i].w > 0))
            throw Error(fmt::format("the weights of vertex {} add up to {}", picks.empty() ? i : picks[i], sums[i].w),
                        "WEIGHTS", "Export the mesh again.");
        const glm::dvec3 position = glm::dvec3(sums[i]) / sums[i].w;
        if (i == 0) loaded.offset = position;
        positions[i] = glm::vec3(position - loaded.offset);
    }
    loaded.turned = glm::determinant(glm::dmat3(joint_of(first_joints[0]))) < 0;
}

std::vector<glm::u16vec4> read_colors(const Elements& elements, Picks picks, bool& clamped) {
    std::vector<glm::vec4> numbers;
    if (elements.components == 4) {
        numbers = read_vectors<4>(elements, picks);
    } else {
        const std::vector<glm::vec3> rgb = read_vectors<3>(elements, picks);
        numbers.resize(rgb.size());
        for (std::size_t i = 0; i < rgb.size(); ++i) numbers[i] = glm::vec4(rgb[i], 1);
    }
    std::vector<glm::u16vec4> colors(numbers.size());
    glm::vec4 least(0);
    glm::vec4 most(1);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        least = glm::min(least, numbers[i]);
        most = glm::max(most, numbers[i]);
        colors[i] = glm::u16vec4(glm::clamp(numbers[i], 0.0F, 1.0F) * 65535.0F + 0.5F);
    }
    clamped = least != glm::vec4(0) || most != glm::vec4(1);
    return colors;
}

/// Embree reads 16 bytes at each 12-byte vertex: one more must fit behind the last.
void make_room_for_embree(std::vector<glm::vec3>& positions) {
    positions.reserve(positions.size() + 1);
}

void load(const Document& document, const PrimitiveRequest& request, LoadedPrimitive& loaded) {
    const Primitive primitive(document, request);
    if (!primitive.has("POSITION")) return;
    const Elements position = primitive.elements("POSITION");
    Mesh& mesh = loaded.mesh;
    mesh.triangles = primitive.triangles(position.count, loaded.left_over);
    if (mesh.triangles.empty()) return;
    std::vector<std::uint32_t> picks = keep_used_vertices(mesh.triangles, position.count);

    mesh.positions = read_vectors<3>(position, picks);
    morph(primitive, request, picks, mesh.positions, position.count);
    if (request.skin >= 0 && primitive.has("JOINTS_0")) skin(document, primitive, request, picks, loaded);
    loaded.without_area = drop_triangles_without_area(mesh);
    if (mesh.triangles.empty()) {
        mesh.positions.clear();
        return;
    }
    if (loaded.without_area > 0) keep_used_vertices(mesh, picks);
    make_room_for_embree(mesh.positions);

    if (primitive.has("COLOR_0"))
        mesh.colors = read_colors(primitive.elements("COLOR_0"), picks, loaded.colors_clamped);
    for (const int set : request.uv_sets) {
        mesh.uv_sets.resize(static_cast<std::size_t>(set) + 1);
        const std::string name = fmt::format("TEXCOORD_{}", set);
        if (primitive.has(name)) {
            mesh.uv_sets.back() = read_vectors<2>(primitive.elements(name), picks);
        } else {
            loaded.missing_uv_sets.push_back(set);
            mesh.uv_sets.back().assign(mesh.positions.size(), glm::vec2(0));
        }
    }
}

std::string place_of(const Document& document, int mesh, int primitive) {
    return fmt::format("{}, primitive {}", document.mesh_name(mesh), primitive);
}

}  // namespace

std::size_t drop_triangles_without_area(Mesh& mesh) {
    const auto has_no_area = [&](const glm::uvec3& corners) {
        const glm::dvec3 a = mesh.positions[corners.x];
        return glm::cross(glm::dvec3(mesh.positions[corners.y]) - a, glm::dvec3(mesh.positions[corners.z]) - a) ==
               glm::dvec3(0);
    };
    const std::size_t dropped = std::erase_if(mesh.triangles, has_no_area);
    if (dropped > 0) mesh.triangles.shrink_to_fit();
    return dropped;
}

bool makes_triangles(const tinygltf::Primitive& primitive) {
    return primitive.mode == TINYGLTF_MODE_TRIANGLES || primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP ||
           primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN;
}

bool is_read(const std::string& attribute, const PrimitiveRequest& request) {
    if (attribute == "POSITION" || attribute == "COLOR_0") return true;
    if (attribute.starts_with("JOINTS_") || attribute.starts_with("WEIGHTS_")) return request.skin >= 0;
    return std::any_of(request.uv_sets.begin(), request.uv_sets.end(),
                       [&](int set) { return attribute == fmt::format("TEXCOORD_{}", set); });
}

LoadedPrimitive load_primitive(const Document& document, const PrimitiveRequest& request) {
    LoadedPrimitive loaded;
    loaded.mesh.name = document.model().meshes[static_cast<std::size_t>(request.mesh)].name;
    loaded.mesh.material = request.material;
    try {
        load(document, request, loaded);
    } catch (const Error& error) {
        throw error.inside(place_of(document, request.mesh, request.primitive));
    }
    return loaded;
}

std::vector<glm::vec3> load_positions(const Document& document, int mesh, int primitive) {
    try {
        PrimitiveRequest request;
        request.mesh = mesh;
        request.primitive = primitive;
        const Primitive source(document, request);
        return source.has("POSITION") ? read_vectors<3>(source.elements("POSITION")) : std::vector<glm::vec3>();
    } catch (const Error& error) {
        throw error.inside(place_of(document, mesh, primitive));
    }
}

}  // namespace lightgrid::gltf
