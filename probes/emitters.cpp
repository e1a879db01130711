#include "probes/emitters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <utility>

namespace lightgrid {
namespace {

/// Squared distance from a triangle up to which it is sampled by solid angle, of the square of its longest side.
constexpr double near_sides_squared = 2;
/// How far off its plane, of the triangle's largest coordinate: receivers that are closer may lie on the triangle itself,
/// or on one beside it, and would by their rounding see half a space of it.
constexpr double least_height = 0x1p-16;
/// Steradians: a smaller one has too little left in double to be divided evenly.
constexpr double least_solid_angle = 1e-6;

/// Twice the area, along the normal of the front side.
glm::dvec3 double_area(const Tracer::Corners& corners) {
    const glm::dvec3 cross = glm::cross(corners.b - corners.a, corners.c - corners.a);
    return corners.mirrored ? -cross : cross;
}

double longest_side_squared(const Tracer::Corners& corners) {
    const auto squared = [](glm::dvec3 v) { return glm::dot(v, v); };
    return std::max({squared(corners.b - corners.a), squared(corners.c - corners.b), squared(corners.a - corners.c)});
}

double largest_coordinate(const Tracer::Corners& corners) {
    const glm::dvec3 v = glm::max(glm::max(glm::abs(corners.a), glm::abs(corners.b)), glm::abs(corners.c));
    return std::max({v.x, v.y, v.z});
}

/// Where a ray from the origin meets the plane of a triangle, as barycentric coordinates (b1, b2), within it whatever
/// the rounding (Moeller, Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997).
glm::vec2 met_at(glm::dvec3 direction, glm::dvec3 a, glm::dvec3 ab, glm::dvec3 ac) {
    const glm::dvec3 across = glm::cross(direction, ac);
    const double volume = glm::dot(ab, across);
    const double b1 = volume != 0 ? std::clamp(-glm::dot(a, across) / volume, 0.0, 1.0) : 0.0;
    const double b2 = volume != 0 ? std::clamp(-glm::dot(direction, glm::cross(a, ab)) / volume, 0.0, 1 - b1) : 0.0;
    return {b1, b2};
}

glm::vec3 center_of(const Tracer::Corners& t) {
    return glm::vec3((t.a + t.b + t.c) / 3.0);
}

float near_squared_of(const Tracer::Corners& t) {
    return static_cast<float>(near_sides_squared * longest_side_squared(t));
}

/// The same place by the corners of a triangle that coincides with the one whose barycentric coordinates these are.
glm::vec2 on_coincident(const Tracer::Corners& on, const Tracer::Corners& of, glm::vec2 barycentric) {
    const std::array<std::pair<glm::dvec3, float>, 3> weights = {
        {{of.a, 1 - barycentric.x - barycentric.y}, {of.b, barycentric.x}, {of.c, barycentric.y}}};
    const auto weight_of = [&](glm::dvec3 corner) {
        const auto same = [&](const auto& w) { return w.first == corner; };
        return std::find_if(weights.begin(), weights.end() - 1, same)->second;
    };
    return {weight_of(on.b), weight_of(on.c)};
}

/// The same for triangles whose corners are the same, whatever their order.
std::array<double, 9> corner_key(const Tracer::Corners& t) {
    std::array<std::array<double, 3>, 3> corners = {
        {{t.a.x, t.a.y, t.a.z}, {t.b.x, t.b.y, t.b.z}, {t.c.x, t.c.y, t.c.z}}};
    std::sort(corners.begin(), corners.end());
    std::array<double, 9> key;
    for (std::size_t i = 0; i < key.size(); ++i) key[i] = corners[i / 3][i % 3];
    return key;
}

/// Calls what(meshes, instance) for all that stands in the level: what is placed once first, then each instance.
template <typename What>
void for_each_placement(const Scene& scene, What what) {
    what(scene.placed, SurfaceId::none);
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        what(scene.models[scene.instances[i].model].meshes, static_cast<std::uint32_t>(scene.placed.size()) + i);
    }
}

bool is_emissive(const Scene& scene, const Mesh& mesh, const LightSources& sources) {
    return scene.materials[mesh.material].emits() && sources.material(mesh.material) != LightSources::off;
}

/// How often they stand in the level, by mesh; 0 for others.
std::vector<std::uint32_t> uses_of_emissive_meshes(const Scene& scene, const LightSources& sources) {
    std::vector<std::uint32_t> uses(scene.meshes.size(), 0);
    for_each_placement(scene, [&](const std::vector<int>& meshes, std::uint32_t) {
        for (const int mesh : meshes) uses[mesh] += is_emissive(scene, scene.meshes[mesh], sources) ? 1 : 0;
    });
    return uses;
}

/// Its index in Scene::meshes.
int mesh_of(const Tracer& tracer, const SurfaceId& id) {
    return static_cast<int>(&tracer.mesh(id) - tracer.scene().meshes.data());
}

}  // namespace

Emitters::Emitters(const Tracer& tracer, const LightSources& sources)
    : tracer_(&tracer), lit_(tracer.scene(), uses_of_emissive_meshes(tracer.scene(), sources)) {
    const Scene& scene = tracer.scene();
    std::vector<double> power;
    for_each_placement(scene, [&](const std::vector<int>& meshes, std::uint32_t instance) {
        std::vector<std::uint32_t>& first = first_.emplace_back(meshes.size(), none);
        for (std::uint32_t geometry = 0; geometry < meshes.size(); ++geometry) {
            const Mesh& mesh = scene.meshes[meshes[geometry]];
            if (!is_emissive(scene, mesh, sources)) continue;
            first[geometry] = static_cast<std::uint32_t>(triangles_.size());
            for (std::uint32_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
                const Tracer::Corners corners = tracer.corners({instance, geometry, triangle});
                const double area = 0.5 * glm::length(double_area(corners));
                const LitParts::Division& division = lit_.division(meshes[geometry], triangle);
                const bool both_sides = scene.materials[mesh.material].double_sided;
                triangles_.push_back({{instance, geometry, triangle},
                                      area,
                                      both_sides,
                                      static_cast<std::uint32_t>(triangles_.size()),
                                      center_of(corners),
                                      near_squared_of(corners),
                                      none,
                                      division.root});
                power.push_back(area * division.emission * (both_sides ? 2 : 1));
            }
        }
    });
    merge_coincident(power);
    add_parts(power);
    tree_ = tree_of(power);
}

/// Of triangles that are sampled: their parts have the power then.
void Emitters::add_parts(std::vector<double>& power) {
    const std::size_t count = triangles_.size();
    for (std::size_t i = 0; i < count; ++i) {
        if (triangles_[i].root == none || !(power[i] > 0)) continue;
        const Triangle whole = triangles_[i];
        const LitParts::Division& division = lit_.division(mesh_of(*tracer_, whole.id), whole.id.triangle);
        triangles_[i].first_part = static_cast<std::uint32_t>(triangles_.size());
        power[i] = 0;
        for (std::uint32_t k = 0; k < division.parts; ++k) {
            Triangle part = whole;
            part.sampled_as = static_cast<std::uint32_t>(triangles_.size());
            part.part = division.first_part + k;
            part.root = none;
            part.area *= lit_.part(part.part).area;
            const Tracer::Corners at = corners(part);
            part.center = center_of(at);
            part.near_squared = near_squared_of(at);
            power.push_back(part.area * lit_.part(part.part).emission * (part.both_sides ? 2 : 1));
            triangles_.push_back(part);
        }
    }
}

Tracer::Corners Emitters::corners(const Triangle& triangle) const noexcept {
    Tracer::Corners whole = tracer_->corners(triangle.id);
    if (triangle.part == none) return whole;
    const auto at = [&](glm::dvec2 b) { return whole.a + b.x * (whole.b - whole.a) + b.y * (whole.c - whole.a); };
    const auto& [a, b, c] = lit_.part(triangle.part).corners;
    return {at(a), at(b), at(c), whole.mirrored};
}

glm::vec2 Emitters::on_triangle(const Triangle& triangle, glm::vec2 barycentric) const noexcept {
    if (triangle.part == none) return barycentric;
    const auto& [a, b, c] = lit_.part(triangle.part).corners;
    return a + barycentric.x * (b - a) + barycentric.y * (c - a);
}

EmitterTree Emitters::tree_of(std::span<const double> power) const {
    std::vector<EmitterTree::Emitter> emitters(triangles_.size());
    for (std::size_t i = 0; i < emitters.size(); ++i) {
        if (!(power[i] > 0)) continue;
        const Tracer::Corners corners = this->corners(triangles_[i]);
        emitters[i].min = glm::min(glm::min(corners.a, corners.b), corners.c);
        emitters[i].max = glm::max(glm::max(corners.a, corners.b), corners.c);
        emitters[i].normal = glm::normalize(double_area(tracer_->corners(triangles_[i].id)));
        emitters[i].both_sides = triangles_[i].both_sides;
        emitters[i].power = power[i];
    }
    return EmitterTree(emitters);
}

void Emitters::merge_coincident(std::span<double> power) {
    struct Place {
        int material;
        std::array<double, 9> corners;
        std::uint32_t index;

        auto operator<=>(const Place&) const = default;
    };
    std::vector<Place> places;
    places.reserve(triangles_.size());
    for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
        const SurfaceId& id = triangles_[i].id;
        places.push_back({tracer_->mesh(id).material, corner_key(tracer_->corners(id)), i});
    }
    std::sort(places.begin(), places.end());
    for (std::size_t begin = 0, end = 0; begin < places.size(); begin = end) {
        const auto same = [&](const Place& p) {
            return p.material == places[begin].material && p.corners == places[begin].corners;
        };
        Triangle& sampled = triangles_[places[begin].index];
        for (end = begin + 1; end < places.size() && same(places[end]); ++end) {
            Triangle& other = triangles_[places[end].index];
            const bool opposite =
                glm::dot(double_area(tracer_->corners(sampled.id)), double_area(tracer_->corners(other.id))) < 0;
            if (opposite && !sampled.both_sides) {
                sampled.both_sides = true;
                power[places[begin].index] *= 2;
            }
            power[places[end].index] = 0;
            other.sampled_as = places[begin].index;
        }
        for (std::size_t i = begin + 1; i < end; ++i) triangles_[places[i].index].both_sides = sampled.both_sides;
    }
}

std::uint32_t Emitters::index_of(const SurfaceId& id) const noexcept {
    const std::size_t placed = tracer_->scene().placed.size();
    const std::uint32_t first = first_[id.instance == SurfaceId::none ? 0 : 1 + id.instance - placed][id.geometry];
    return first == none ? none : first + id.triangle;
}

std::uint32_t Emitters::sampled_at(const Hit& hit) const noexcept {
    const std::uint32_t index = index_of(hit.id);
    if (index == none) return none;
    const std::uint32_t sampled_as = triangles_[index].sampled_as;
    const Triangle& sampled = triangles_[sampled_as];
    if (sampled.root == none) return sampled_as;
    if (sampled.first_part == none) return none;
    const glm::vec2 where =
        sampled_as == index ? hit.barycentric
                            : on_coincident(tracer_->corners(sampled.id), tracer_->corners(hit.id), hit.barycentric);
    const std::uint32_t part = lit_.find(sampled.root, where);
    return part == LitParts::none ? none : sampled.first_part + part;
}

bool Emitters::emits(const Hit& hit, bool front) const noexcept {
    const std::uint32_t index = index_of(hit.id);
    return index != none && (front || triangles_[index].both_sides);
}

std::optional<SphericalTriangle> Emitters::near_triangle(glm::vec3 receiver, const Triangle& triangle) const noexcept {
    const glm::vec3 away = triangle.center - receiver;
    if (!(glm::dot(away, away) <= triangle.near_squared)) return {};
    const Tracer::Corners corners = this->corners(triangle);
    const glm::dvec3 from(receiver);
    const glm::dvec3 normal = glm::normalize(double_area(corners));
    if (!(std::abs(glm::dot(corners.a - from, normal)) > least_height * largest_coordinate(corners))) return {};
    const SphericalTriangle seen(corners.a - from, corners.b - from, corners.c - from);
    if (!(seen.solid_angle() >= least_solid_angle)) return {};
    return seen;
}

Emitters::Sample Emitters::sample(const Receiver& receiver, double pick, glm::vec2 where) const noexcept {
    const auto [index, probability] = tree_.draw(receiver, pick);
    if (!(probability > 0)) return {};
    const Triangle& triangle = triangles_[index];
    const std::optional<SphericalTriangle> seen = near_triangle(receiver.position, triangle);
    glm::vec2 barycentric;
    if (seen) {
        const Tracer::Corners corners = this->corners(triangle);
        barycentric = met_at(seen->sample(where), corners.a - glm::dvec3(receiver.position), corners.b - corners.a,
                             corners.c - corners.a);
    } else {
        barycentric = triangle_point(where);
    }
    barycentric = on_triangle(triangle, barycentric);
    const Hit hit{triangle.id, 0, barycentric};
    Surface surface = tracer_->surface(hit, glm::vec3(0));
    const glm::vec3 to_emitter = surface.position - receiver.position;
    const float distance_squared = glm::dot(to_emitter, to_emitter);
    const float cosine = -glm::dot(to_emitter, surface.normal) / std::sqrt(distance_squared);
    if (cosine == 0 || !(distance_squared > 0)) return {};

    Sample sample;
    sample.id = hit.id;
    surface.offset += std::sqrt(distance_squared) * 0x1p-20F;  // Embree's rounding at the far end grows with the ray
    sample.position = surface.leave(-to_emitter);
    sample.pdf = seen ? static_cast<float>(probability / seen->solid_angle())
                      : static_cast<float>(probability / triangle.area) * distance_squared / std::abs(cosine);
    if (cosine > 0 || triangle.both_sides) {
        const SurfacePoint point = surface_at(tracer_->scene(), *surface.mesh, hit.id.triangle, barycentric);
        sample.radiance = point.alpha * point.emission;
    }
    return sample;
}

float Emitters::pdf(const Receiver& receiver, const Hit& hit, const Surface& surface) const noexcept {
    if (empty()) return 0;
    const std::uint32_t sampled_as = sampled_at(hit);
    if (sampled_as == none) return 0;
    const Triangle& sampled = triangles_[sampled_as];
    const float probability = tree_.probability(receiver, sampled_as);
    if (const auto seen = near_triangle(receiver.position, sampled)) {
        return static_cast<float>(probability / seen->solid_angle());
    }
    const glm::vec3 to_emitter = surface.position - receiver.position;
    const float distance_squared = glm::dot(to_emitter, to_emitter);
    const float cosine = std::abs(glm::dot(to_emitter, surface.normal)) / std::sqrt(distance_squared);
    if (!(cosine > 0)) return 0;
    return static_cast<float>(probability / sampled.area) * distance_squared / cosine;
}

}  // namespace lightgrid
