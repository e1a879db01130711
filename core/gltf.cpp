#include "core/gltf.h"

#include "core/error.h"
#include "core/gltf/accessors.h"
#include "core/gltf/document.h"
#include "core/gltf/extensions.h"
#include "core/gltf/materials.h"
#include "core/gltf/meshes.h"
#include "core/gltf/nodes.h"
#include "core/parallel.h"
#include "core/simplify.h"
#include "core/whole_file.h"

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <compare>
#include <map>
#include <optional>
#include <utility>

namespace lightgrid {
namespace {

using gltf::Document;
using gltf::name_of;
using gltf::Notices;
using gltf::PlacedNode;

/// Whether a transform can be undone in float, as tracing an instance does.
bool can_be_undone(const glm::dmat4& transform) {
    const auto volume = static_cast<float>(glm::determinant(glm::dmat3(transform)));
    return std::isnormal(volume) && std::isnormal(1 / volume);
}

/// A mesh in one shape (morphed, posed), and everywhere that it stands.
struct Shape {
    struct Key {
        int mesh;
        int posed_node;  // skinned meshes stand where their joints are: each node has a shape of its own; else -1
        std::vector<double> weights;
        auto operator<=>(const Key&) const = default;
    };
    Key key;
    int skin = -1;
    std::vector<glm::dmat4> transforms;

    [[nodiscard]] bool is_instanced() const { return transforms.size() > 1; }
};

enum class Marker { none, volume, probe };

Marker marker_of(const tinygltf::Node& node) {
    if (!node.extras.Has("lightgrid")) return Marker::none;
    return node.extras.Get("lightgrid").Get<std::string>() == "volume" ? Marker::volume : Marker::probe;
}

class LevelReader {
  public:
    LevelReader(const Document& document, Scene& scene) : document_(document), scene_(scene) {}

    void read(int wanted_scene) {
        gltf::check_extensions(document_, notices_);
        const int chosen = gltf::choose_scene(document_, wanted_scene);
        if (chosen < 0) notices_.add("", "the file has no scene: all its nodes are the level");
        nodes_ = gltf::place_nodes(document_, chosen);
        find_shapes();
        read_materials();
        read_meshes();
        simplify(scene_);
        place();
        read_lights();
        finish_report();
    }

  private:
    [[nodiscard]] const tinygltf::Mesh& mesh_of(const Shape& shape) const { return document_.mesh(shape.key.mesh); }

    void find_shapes() {
        node_transforms_.resize(document_.model().nodes.size());
        for (const PlacedNode& placed : nodes_)
            node_transforms_[static_cast<std::size_t>(placed.index)] = placed.transform;
        std::map<Shape::Key, std::size_t> known;
        for (const PlacedNode& placed : nodes_) {
            const tinygltf::Node& node = document_.node(placed.index);
            if (const Marker marker = marker_of(node); marker != Marker::none) {
                read_marker(marker, placed);
                continue;
            }
            if (node.mesh < 0) continue;
            const tinygltf::Mesh& mesh = document_.mesh(node.mesh);
            Shape shape;
            shape.key = {node.mesh, node.skin >= 0 && is_skinned(mesh) ? placed.index : -1,
                         node.weights.empty() ? mesh.weights : node.weights};
            if (std::all_of(shape.key.weights.begin(), shape.key.weights.end(), [](double w) { return w == 0; }))
                shape.key.weights.clear();
            if (shape.key.posed_node >= 0) {
                shape.skin = node.skin;
                shape.transforms = {placed.transform};
                shapes_.push_back(std::move(shape));
                continue;
            }
            for (const glm::dmat4& transform : gltf::transforms_of(document_, placed)) {
                if (!can_be_undone(transform)) {
                    // It may be flat: then it has to be in the level itself.
                    Shape& flat = shapes_.emplace_back(shape);
                    flat.transforms = {transform};
                    continue;
                }
                const auto [entry, added] = known.emplace(shape.key, shapes_.size());
                if (added) shapes_.push_back(shape);
                shapes_[entry->second].transforms.push_back(transform);
            }
        }
    }

    static bool is_skinned(const tinygltf::Mesh& mesh) {
        return std::any_of(mesh.primitives.begin(), mesh.primitives.end(), [](const tinygltf::Primitive& primitive) {
            return primitive.attributes.contains("JOINTS_0");
        });
    }

    void read_marker(Marker marker, const PlacedNode& placed) {
        if (marker == Marker::probe) {
            scene_.probe_markers.emplace_back(placed.transform[3]);
            return;
        }
        std::vector<glm::vec3> corners;
        const tinygltf::Node& node = document_.node(placed.index);
        if (node.mesh < 0) {
            for (int i = 0; i < 8; ++i) corners.emplace_back(glm::vec3(i & 1, i >> 1 & 1, i >> 2) - 0.5F);
        } else {
            const std::size_t count = document_.mesh(node.mesh).primitives.size();
            for (std::size_t i = 0; i < count; ++i) {
                const auto positions = gltf::load_positions(document_, node.mesh, static_cast<int>(i));
                corners.insert(corners.end(), positions.begin(), positions.end());
            }
        }
        Box box;
        for (const glm::vec3& corner : corners) box.extend(placed.transform * glm::dvec4(corner, 1));
        if (box.empty())
            notices_.add(name_of("node", static_cast<std::size_t>(placed.index), node.name),
                         "marks a volume, but its mesh has no vertices");
        else
            scene_.volume_markers.push_back(box);
    }

    void read_materials() {
        std::vector<bool> used(document_.model().materials.size() + 1, false);
        for (const Shape& shape : shapes_)
            for (const tinygltf::Primitive& primitive : mesh_of(shape).primitives)
                if (gltf::makes_triangles(primitive)) used[static_cast<std::size_t>(primitive.material + 1)] = true;
        material_indices_ = gltf::load_materials(document_, used, scene_, notices_);
    }

    /// A primitive of a shape; its index is that of its mesh in the scene.
    struct Part {
        std::size_t shape;
        gltf::PrimitiveRequest request;
        gltf::LoadedPrimitive loaded;
    };

    void read_meshes() {
        for (std::size_t i = 0; i < shapes_.size(); ++i) {
            const std::vector<tinygltf::Primitive>& primitives = mesh_of(shapes_[i]).primitives;
            for (std::size_t j = 0; j < primitives.size(); ++j) {
                if (gltf::makes_triangles(primitives[j]))
                    parts_.push_back({i, request_of(shapes_[i], j), {}});
                else
                    notices_.add(mesh_name(shapes_[i].key.mesh), "points and lines are not part of the level");
            }
        }
        for_each_index(parts_.size(),
                       [&](std::size_t i) { parts_[i].loaded = gltf::load_primitive(document_, parts_[i].request); });
        for (Part& part : parts_) {
            scene_.meshes.push_back(std::move(part.loaded.mesh));
            const std::string place = mesh_name(part.request.mesh);
            if (part.loaded.left_over > 0) notices_.add(place, "its last vertices make no whole triangle");
            if (part.loaded.unweighted)
                notices_.add(place, "vertices without weights follow the first joint that they name");
            if (part.loaded.colors_clamped)
                notices_.add(place, "its vertex colours are outside [0, 1] and are clamped to it");
            for (const int set : part.loaded.missing_uv_sets)
                notices_.add(
                    place,
                    fmt::format("it has no TEXCOORD_{}, which its material reads: its texture is that of (0, 0)", set));
            without_area_ += part.loaded.without_area;
        }
    }

    gltf::PrimitiveRequest request_of(const Shape& shape, std::size_t primitive) const {
        gltf::PrimitiveRequest request;
        request.mesh = shape.key.mesh;
        request.primitive = static_cast<int>(primitive);
        request.material =
            material_indices_[static_cast<std::size_t>(mesh_of(shape).primitives[primitive].material + 1)];
        request.weights = shape.key.weights;
        request.skin = shape.skin;
        request.node_transforms = node_transforms_;
        const Material& material = scene_.materials[static_cast<std::size_t>(request.material)];
        for (const TextureUse* use :
             {&material.base_color_texture, &material.transmission_texture, &material.emission_texture})
            if (use->used()) request.uv_sets.push_back(use->uv_set);
        std::sort(request.uv_sets.begin(), request.uv_sets.end());
        request.uv_sets.erase(std::unique(request.uv_sets.begin(), request.uv_sets.end()), request.uv_sets.end());
        return request;
    }

    std::string mesh_name(int mesh) const {
        return name_of("mesh", static_cast<std::size_t>(mesh),
                       document_.model().meshes[static_cast<std::size_t>(mesh)].name);
    }

    /// From a part's own space to the level's coordinates; for parts that stand there once.
    glm::dmat4 transform_of(const Part& part) const {
        const Shape& shape = shapes_[part.shape];
        return shape.skin < 0 ? shape.transforms[0] : glm::translate(glm::dmat4(1), part.loaded.offset);
    }

    static void extend(Box& box, const Mesh& mesh, const glm::dmat4& transform) {
        for (const glm::vec3& position : mesh.positions) box.extend(transform * glm::dvec4(position, 1));
    }

    void find_bounds() {
        std::vector<Box> boxes(parts_.size());  // of instanced parts in their own space
        for_each_index(parts_.size(), [&](std::size_t i) {
            extend(boxes[i], scene_.meshes[i],
                   shapes_[parts_[i].shape].is_instanced() ? glm::dmat4(1) : transform_of(parts_[i]));
        });
        for (std::size_t i = 0; i < parts_.size(); ++i)
            if (!shapes_[parts_[i].shape].is_instanced() && !boxes[i].empty()) {
                scene_.bounds.extend(boxes[i].min);
                scene_.bounds.extend(boxes[i].max);
            }
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            if (!shapes_[parts_[i].shape].is_instanced() || boxes[i].empty()) continue;
            for (const glm::dmat4& transform : shapes_[parts_[i].shape].transforms) {
                // Few of many instances reach beyond the others: only those are looked at vertex by vertex.
                Box around = scene_.bounds;
                for (int corner = 0; corner < 8; ++corner)
                    around.extend(transform * glm::dvec4(corner & 1 ? boxes[i].max.x : boxes[i].min.x,
                                                         corner & 2 ? boxes[i].max.y : boxes[i].min.y,
                                                         corner & 4 ? boxes[i].max.z : boxes[i].min.z, 1));
                if (around.min != scene_.bounds.min || around.max != scene_.bounds.max)
                    extend(scene_.bounds, scene_.meshes[i], transform);
            }
        }
        constexpr double largest = 1e15;  // Embree's limit is 1.8e18; squares of distances stay in float's range
        if (!scene_.bounds.empty() && !(glm::all(glm::lessThan(glm::abs(scene_.bounds.min), glm::dvec3(largest))) &&
                                        glm::all(glm::lessThan(glm::abs(scene_.bounds.max), glm::dvec3(largest)))))
            throw Error(fmt::format("the level reaches from ({:g}, {:g}, {:g}) to ({:g}, {:g}, {:g}) m",
                                    scene_.bounds.min.x, scene_.bounds.min.y, scene_.bounds.min.z, scene_.bounds.max.x,
                                    scene_.bounds.max.y, scene_.bounds.max.z),
                        "", "Remove what lies that far out.");
    }

    void place() {
        find_bounds();
        if (scene_.bounds.empty())
            notices_.add("", "the level has no triangles");
        else
            scene_.origin = scene_.bounds.center();
        const glm::dmat4 recentre = glm::translate(glm::dmat4(1), -scene_.origin);

        std::vector<std::size_t> collapsed(parts_.size());
        for_each_index(parts_.size(), [&](std::size_t i) {
            if (shapes_[parts_[i].shape].is_instanced()) return;
            Mesh& mesh = scene_.meshes[i];
            const glm::dmat4 transform = recentre * transform_of(parts_[i]);
            for (glm::vec3& position : mesh.positions) position = glm::vec3(transform * glm::dvec4(position, 1));
            if (parts_[i].loaded.turned || glm::determinant(glm::dmat3(transform)) < 0)
                for (glm::uvec3& triangle : mesh.triangles) std::swap(triangle.y, triangle.z);
            collapsed[i] = gltf::drop_triangles_without_area(mesh);
        });
        for (const std::size_t count : collapsed) without_area_ += count;

        std::vector<Mesh> kept;
        std::vector<std::vector<int>> meshes_of_shape(shapes_.size());
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            if (scene_.meshes[i].triangles.empty()) continue;
            meshes_of_shape[parts_[i].shape].push_back(static_cast<int>(kept.size()));
            kept.push_back(std::move(scene_.meshes[i]));
        }
        scene_.meshes = std::move(kept);
        for (std::size_t i = 0; i < shapes_.size(); ++i) {
            if (meshes_of_shape[i].empty()) continue;
            if (!shapes_[i].is_instanced()) {
                scene_.placed.insert(scene_.placed.end(), meshes_of_shape[i].begin(), meshes_of_shape[i].end());
                continue;
            }
            for (const glm::dmat4& transform : shapes_[i].transforms)
                scene_.instances.push_back({static_cast<int>(scene_.models.size()), glm::mat4x3(recentre * transform),
                                            glm::determinant(glm::dmat3(transform)) < 0});
            scene_.models.push_back({meshes_of_shape[i]});
        }
    }

    void read_lights() {
        std::size_t dark = 0;
        for (const PlacedNode& placed : nodes_) {
            const tinygltf::Node& node = document_.node(placed.index);
            const tinygltf::Value* extension = gltf::find_extension(node.extensions, "KHR_lights_punctual");
            if (extension == nullptr) continue;
            const tinygltf::Light& source = document_.light(extension->Get("light").GetNumberAsInt());
            Light light;
            light.name = node.name.empty() ? source.name : node.name;
            light.kind = source.type == "directional" ? LightKind::directional
                         : source.type == "spot"      ? LightKind::spot
                                                      : LightKind::point;
            for (int i = 0; i < 3; ++i)
                light.intensity[i] = static_cast<float>(
                    source.intensity * (source.color.empty() ? 1 : source.color[static_cast<std::size_t>(i)]));
            light.position = glm::vec3(glm::dvec3(placed.unscaled[3]) - scene_.origin);
            const glm::dvec3 direction = -glm::dvec3(placed.unscaled[2]);
            const std::string place = name_of("node", static_cast<std::size_t>(placed.index), node.name);
            if (light.kind != LightKind::point) {
                if (!(glm::length(direction) > 0))
                    throw Error("its light has no direction: its parents scale it to nothing", place);
                light.direction = glm::vec3(glm::normalize(direction));
            }
            if (source.range > 0) light.range = static_cast<float>(source.range);
            if (light.kind == LightKind::spot) {
                light.cos_inner = static_cast<float>(std::cos(source.spot.innerConeAngle));
                light.cos_outer = static_cast<float>(std::cos(source.spot.outerConeAngle));
                if (source.spot.innerConeAngle >= source.spot.outerConeAngle)
                    notices_.add(place, "the inner cone of its light is not inside the outer one: its edge is sharp");
            }
            if (light.intensity == glm::vec3(0))
                ++dark;
            else
                scene_.lights.push_back(std::move(light));
        }
        if (dark > 0) scene_.left_out.push_back({"lights", "their intensity is 0", fmt::format("{} lights", dark)});
    }

    void finish_report() {
        if (without_area_ > 0)
            notices_.add("", fmt::format("{} triangles have no area and are left out", without_area_));
        note_clamped_albedo();
        list_unread_images();
        list_unread_attributes();
        for (const gltf::Findings& findings : {document_.findings(), document_.check_unread()})
            for (const gltf::Finding& finding : findings) notices_.add(finding.place, finding.problem);
        const std::vector<std::string> lines = notices_.lines();
        scene_.notices.insert(scene_.notices.end(), lines.begin(), lines.end());
    }

    void list_unread_images() {
        std::size_t count = 0;
        std::size_t bytes = 0;
        for (std::size_t i = 0; i < document_.images().size(); ++i) {
            if (document_.was_read(i)) continue;
            ++count;
            bytes += document_.encoded_bytes(document_.images()[i]);
        }
        if (count > 0)
            scene_.left_out.push_back({"images of normals, roughness and the like", "no light path reads them",
                                       fmt::format("{} images, {:.1f} MB encoded", count, megabytes(bytes))});
    }

    /// Vertex data of meshes in the scene that was not converted.
    void list_unread_attributes() {
        std::map<int, bool> read;  // by accessor
        for (const Part& part : parts_) {
            const tinygltf::Primitive& primitive =
                document_.mesh(part.request.mesh).primitives[static_cast<std::size_t>(part.request.primitive)];
            for (const auto& [name, accessor] : primitive.attributes)
                read[accessor] |= gltf::is_read(name, part.request);
        }
        std::size_t count = 0;
        std::size_t bytes = 0;
        for (const auto& [index, was_read] : read) {
            if (was_read) continue;
            const tinygltf::Accessor& accessor = document_.model().accessors[static_cast<std::size_t>(index)];
            ++count;
            bytes += accessor.count * gltf::element_bytes(accessor.type, accessor.componentType);
        }
        if (count > 0)
            scene_.left_out.push_back({"normals, tangents and other vertex data", "no light path reads them",
                                       fmt::format("{} accessors, {:.1f} MB", count, megabytes(bytes))});
    }
    static double megabytes(std::size_t bytes) { return static_cast<double>(bytes) * 1e-6; }

    void note_clamped_albedo() {
        std::vector<bool> bright(scene_.materials.size(), false);
        for (const Mesh& mesh : scene_.meshes) {
            const Material& material = scene_.materials[static_cast<std::size_t>(mesh.material)];
            const float factor = std::max({material.base_color.r, material.base_color.g, material.base_color.b});
            if (factor > max_albedo && !material.base_color_texture.used() && mesh.colors.empty())
                bright[static_cast<std::size_t>(mesh.material)] = true;
        }
        for (std::size_t i = 0; i < bright.size(); ++i)
            if (bright[i])
                notices_.add(
                    scene_.materials[i].name.empty() ? "no material" : "material \"" + scene_.materials[i].name + "\"",
                    fmt::format("its albedo is clamped to {:.4f}, so that light dies away", max_albedo));
    }

    const Document& document_;
    Scene& scene_;
    Notices notices_;
    std::vector<PlacedNode> nodes_;
    std::vector<std::optional<glm::dmat4>> node_transforms_;  // by index in the file
    std::vector<Shape> shapes_;
    std::vector<int> material_indices_;  // by index in the file plus one
    std::vector<Part> parts_;            // by index in scene_.meshes, until place()
    std::size_t without_area_ = 0;
};

}  // namespace

Scene load_level(const std::filesystem::path& path, const LoadOptions& options) {
    std::string file = read_whole_file(path);
    Scene scene;
    scene.name = path.filename().string();
    try {
        const Document document(std::move(file), path.parent_path());
        LevelReader(document, scene).read(options.scene);
    } catch (const Error& error) {
        throw error.inside(path.string());
    }
    return scene;
}

}  // namespace lightgrid
