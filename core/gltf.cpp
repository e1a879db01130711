#include "core/gltf.h"

#include "core/error.h"
#include "core/gltf/accessors.h"
#include "core/gltf/document.h"
#include "core/gltf/extensions.h"
#include "core/gltf/lights.h"
#include "core/gltf/markers.h"
#include "core/gltf/materials.h"
#include "core/gltf/meshes.h"
#include "core/gltf/nodes.h"
#include "core/gltf/placing.h"
#include "core/gltf/shapes.h"
#include "core/parallel.h"
#include "core/simplify.h"
#include "core/whole_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace lightgrid {
namespace {

using namespace gltf;

LoadedMaterials load_used_materials(const Document& document, const std::vector<Shape>& shapes,
                                    const LoadOptions& options, Scene& scene, Notices& notices) {
    std::set<MaterialUse> used;
    for (const Shape& shape : shapes)
        for (const tinygltf::Primitive& primitive : document.mesh(shape.key.mesh).primitives)
            if (makes_triangles(primitive)) used.insert(material_use(document, primitive.material, shape.key.group));
    return load_materials(document, used, options, scene, notices);
}

/// The UV sets that a material reads, increasing.
std::vector<int> uv_sets_of(const Material& material) {
    std::vector<int> sets;
    for (const TextureUse* use :
         {&material.base_color_texture, &material.transmission_texture, &material.emission_texture})
        if (use->used()) sets.push_back(use->uv_set);
    std::sort(sets.begin(), sets.end());
    sets.erase(std::unique(sets.begin(), sets.end()), sets.end());
    return sets;
}

/// All primitives that make triangles, loaded on all threads.
std::vector<Part> load_parts(const Document& document, const std::vector<Shape>& shapes,
                             const LoadedMaterials& materials, const Scene& scene,
                             const std::vector<std::optional<glm::dmat4>>& node_transforms, Notices& notices) {
    std::vector<Part> parts;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        const Shape& shape = shapes[i];
        const std::vector<tinygltf::Primitive>& primitives = document.mesh(shape.key.mesh).primitives;
        for (std::size_t j = 0; j < primitives.size(); ++j) {
            if (!makes_triangles(primitives[j])) {
                notices.add(document.mesh_name(shape.key.mesh), "points and lines are not part of the level");
                continue;
            }
            Part& part = parts.emplace_back();
            part.shape = i;
            part.request.mesh = shape.key.mesh;
            part.request.primitive = static_cast<int>(j);
            part.request.material =
                materials.indices.at(material_use(document, primitives[j].material, shape.key.group));
            part.request.uv_sets = uv_sets_of(scene.materials[static_cast<std::size_t>(part.request.material)]);
            part.request.weights = shape.key.weights;
            part.request.skin = shape.skin;
            part.request.node_transforms = node_transforms;
        }
    }
    for_each_index(parts.size(), [&](std::size_t i) { parts[i].loaded = load_primitive(document, parts[i].request); });
    return parts;
}

void note_repairs(const Document& document, const std::vector<Part>& parts, Notices& notices) {
    for (const Part& part : parts) {
        const std::string place = document.mesh_name(part.request.mesh);
        if (part.loaded.left_over > 0) notices.add(place, "its last vertices make no whole triangle");
        if (part.loaded.unweighted)
            notices.add(place, "vertices without weights follow the first joint that they name");
        if (part.loaded.colors_clamped)
            notices.add(place, "its vertex colours are outside [0, 1] and are clamped to it");
        for (const int set : part.loaded.missing_uv_sets)
            notices.add(place,
                        fmt::format("it has no TEXCOORD_{}, which its material reads: all of it has the texture's "
                                    "colour at (0, 0)",
                                    set));
    }
}

void note_clamped_albedo(const Scene& scene, const LoadedMaterials& materials, Notices& notices) {
    std::vector<bool> bright(scene.materials.size(), false);
    for (const Mesh& mesh : scene.meshes) {
        const Material& material = scene.materials[static_cast<std::size_t>(mesh.material)];
        const float factor = std::max({material.base_color.r, material.base_color.g, material.base_color.b});
        if (factor > max_albedo && !material.base_color_texture.used() && mesh.colors.empty())
            bright[static_cast<std::size_t>(mesh.material)] = true;
    }
    for (std::size_t i = 0; i < bright.size(); ++i)
        if (bright[i])
            notices.add(materials.names[i],
                        fmt::format("its albedo is clamped to {:.4f}, so that light dies away", max_albedo));
}

/// Whether a node has a mesh of its own that is no marker, to be seen or not.
bool has_mesh(const tinygltf::Node& node) {
    const Marker marker = marker_of(node);
    return node.mesh >= 0 && marker != Marker::volume && marker != Marker::probe;
}

/// Nodes with meshes or lights that are no part of the level because its author or user says so.
void list_hidden(const Document& document, const Placement& placement, Scene& scene) {
    const auto list = [&](const std::vector<PlacedNode>& nodes, const char* what, const char* evidence,
                          const auto& is_hidden) {
        const auto count = std::count_if(nodes.begin(), nodes.end(), [&](const PlacedNode& node) {
            const tinygltf::Node& source = document.node(node.index);
            return is_hidden(node) &&
                   (has_mesh(source) || find_extension(source.extensions, "KHR_lights_punctual") != nullptr);
        });
        if (count > 0) scene.left_out.push_back({what, evidence, fmt::format("{} nodes", count)});
    };
    list(placement.ignored, "ignored nodes", "--ignore or extras {\"lightgrid\": \"ignore\"} name them or a parent",
         [](const PlacedNode&) { return true; });
    list(placement.nodes, "hidden nodes", "KHR_node_visibility hides them or a parent",
         [](const PlacedNode& node) { return node.hidden; });
    list(placement.nodes, "vanished nodes", "they or a parent are scaled to 0 along all axes",
         [&](const PlacedNode& node) {
             return !node.hidden && document.node(node.index).skin < 0 && is_scaled_away(node.transform);
         });
}

double megabytes(std::size_t bytes) {
    return static_cast<double>(bytes) * 1e-6;
}

void list_unread_images(const Document& document, Scene& scene) {
    std::size_t count = 0;
    std::size_t bytes = 0;
    for (std::size_t i = 0; i < document.images().size(); ++i) {
        if (document.was_read(i)) continue;
        ++count;
        bytes += document.encoded_bytes(document.images()[i]);
    }
    if (count > 0)
        scene.left_out.push_back({"images of normals, roughness and the like", "no light path reads them",
                                  fmt::format("{} images, {:.1f} MB encoded", count, megabytes(bytes))});
}

/// Vertex data of meshes in the scene that was not converted.
void list_unread_attributes(const Document& document, const std::vector<Part>& parts, Scene& scene) {
    std::map<int, bool> read;  // by accessor
    for (const Part& part : parts) {
        const tinygltf::Mesh& mesh = document.mesh(part.request.mesh);
        for (const auto& [name, accessor] :
             mesh.primitives[static_cast<std::size_t>(part.request.primitive)].attributes)
            read[accessor] |= is_read(name, part.request);
    }
    std::size_t count = 0;
    std::size_t bytes = 0;
    for (const auto& [index, was_read] : read) {
        if (was_read) continue;
        const tinygltf::Accessor& accessor = document.model().accessors[static_cast<std::size_t>(index)];
        ++count;
        bytes += accessor.count * element_bytes(accessor.type, accessor.componentType);
    }
    if (count > 0)
        scene.left_out.push_back({"normals, tangents and other vertex data", "no light path reads them",
                                  fmt::format("{} accessors, {:.1f} MB", count, megabytes(bytes))});
}

Scene read_scene(const Document& document, const LoadOptions& options) {
    Scene scene;
    Notices notices;
    check_extensions(document, notices);
    const int chosen = choose_scene(document, options.scene);
    if (chosen < 0) notices.add("", "the file has no scene: all its nodes are the level");
    Placement placement = place_nodes(document, chosen, options.ignore);
    const std::vector<PlacedNode>& nodes = placement.nodes;
    scene.groups = std::move(placement.groups);
    for (const tinygltf::Node& node : document.model().nodes)
        scene.node_names.push_back(ignorable_name(document, node));
    list_hidden(document, placement, scene);
    std::vector<std::optional<glm::dmat4>> node_transforms(document.model().nodes.size());
    for (const std::vector<PlacedNode>* placed : {&placement.nodes, &placement.ignored})
        for (const PlacedNode& node : *placed) node_transforms[static_cast<std::size_t>(node.index)] = node.transform;
    read_markers(document, nodes, scene, notices);

    const std::vector<Shape> shapes = find_shapes(document, nodes);
    if (shapes.empty() && !options.ignore.empty() &&
        std::any_of(placement.ignored.begin(), placement.ignored.end(),
                    [&](const PlacedNode& node) { return has_mesh(document.node(node.index)); }))
        throw Error("nothing is left of the level: every mesh is to be left out", "",
                    "Give names that fit fewer nodes.");
    const LoadedMaterials materials = load_used_materials(document, shapes, options, scene, notices);
    std::vector<Part> parts = load_parts(document, shapes, materials, scene, node_transforms, notices);
    note_repairs(document, parts, notices);
    std::size_t without_area = 0;
    for (Part& part : parts) {
        scene.meshes.push_back(std::move(part.loaded.mesh));
        without_area += part.loaded.without_area;
    }
    simplify(scene);
    without_area += place_parts(shapes, parts, scene);
    read_lights(document, nodes, scene, notices);

    if (scene.meshes.empty()) notices.add("", "the level has no triangles");
    if (without_area > 0) notices.add("", fmt::format("{} triangles have no area and are left out", without_area));
    note_clamped_albedo(scene, materials, notices);
    list_unread_images(document, scene);
    list_unread_attributes(document, parts, scene);
    for (const Findings& findings : {document.findings(), document.check_unread()})
        for (const Finding& finding : findings) notices.add(finding.place, finding.problem);
    scene.notices = notices.lines();
    return scene;
}

}  // namespace

Scene load_level(const std::filesystem::path& path, const LoadOptions& options) {
    std::string file = read_whole_file(path);
    try {
        Scene scene = read_scene(Document(std::move(file), path.parent_path()), options);
        scene.name = path.filename().string();
        scene.metres_per_unit = options.metres_per_unit;
        return scene;
    } catch (const Error& error) {
        throw error.inside(path.string());
    }
}

}  // namespace lightgrid
