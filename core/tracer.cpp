#include "core/tracer.h"

#include "core/embree.h"
#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <vector>

namespace lightgrid {
namespace {

/// Rays that Embree is given at once.
constexpr std::size_t packet_size = 8;

/// A mesh with a filter: light may pass it, or it has triangles so large that Embree's word is checked.
struct FilteredMesh {
    const Scene* scene;
    const Mesh* mesh;
    bool huge;

    [[nodiscard]] const Material& material() const { return scene->materials[mesh->material]; }
};

/// A hit as a filter sees it, the i-th of those that Embree asks about at once.
struct Candidate {
    const FilteredMesh& mesh;
    unsigned ray;  // in its packet
    SurfaceId id;
    float distance;
    glm::vec2 barycentric;
    glm::vec3 origin, direction, normal;  // in the mesh's own space; normal of any length

    Candidate(const RTCFilterFunctionNArguments* args, unsigned i)
        : Candidate(args, args->ray, args->hit, args->N, i) {}

    /// Whether the ray really crosses the triangle's plane within max_distance, in double. Embree's own distance to a
    /// huge triangle is off by units in the last place of its corners' coordinates: 1 cm where they are at 1e5 m.
    [[nodiscard]] bool crosses(float max_distance) const {
        const glm::uvec3& triangle = mesh.mesh->triangles[id.triangle];
        const glm::dvec3 a(mesh.mesh->positions[triangle.x]);
        const glm::dvec3 b(mesh.mesh->positions[triangle.y]);
        const glm::dvec3 c(mesh.mesh->positions[triangle.z]);
        const glm::dvec3 up = glm::cross(b - a, c - a);
        const double height = glm::dot(glm::dvec3(origin) - a, up);
        const double climb = glm::dot(glm::dvec3(direction), up);
        return height * climb < 0 && std::abs(height) < std::abs(climb) * max_distance;
    }

    /// On the edge of its triangle but for rounding.
    [[nodiscard]] bool on_edge() const {
        return std::min({barycentric.x, barycentric.y, 1 - barycentric.x - barycentric.y}) < 0x1p-20F;
    }

  private:
    Candidate(const RTCFilterFunctionNArguments* args, RTCRayN* rays, RTCHitN* hits, unsigned n, unsigned i)
        : mesh(*static_cast<const FilteredMesh*>(args->geometryUserPtr)),
          ray(RTCRayN_id(rays, n, i)),
          id{RTCHitN_instID(hits, n, i, 0), RTCHitN_geomID(hits, n, i), RTCHitN_primID(hits, n, i)},
          distance(RTCRayN_tfar(rays, n, i)),
          barycentric(RTCHitN_u(hits, n, i), RTCHitN_v(hits, n, i)),
          origin(RTCRayN_org_x(rays, n, i), RTCRayN_org_y(rays, n, i), RTCRayN_org_z(rays, n, i)),
          direction(RTCRayN_dir_x(rays, n, i), RTCRayN_dir_y(rays, n, i), RTCRayN_dir_z(rays, n, i)),
          normal(RTCHitN_Ng_x(hits, n, i), RTCHitN_Ng_y(hits, n, i), RTCHitN_Ng_z(hits, n, i)) {}
};

/// Takes candidates away from Embree that are no hits.
template <typename IsHit>
void keep_hits(const RTCFilterFunctionNArguments* args, IsHit is_hit) {
    for (unsigned i = 0; i < args->N; ++i) {
        if (args->valid[i] != 0 && !is_hit(Candidate(args, i))) args->valid[i] = 0;
    }
}

/// Where rays start: beyond a surface that their origin is exactly on. Small enough for any level, and large enough not
/// to be flushed to zero when Embree scales it by a triangle's area.
constexpr float ray_start = 1e-25F;

/// The order in which a ray meets surfaces.
struct Depth {
    float distance = -1;
    SurfaceId id;

    auto operator<=>(const Depth&) const = default;
};

struct ClosestRay {
    float max_distance = std::numeric_limits<float>::infinity();
    Depth behind;                                               // what came before
    Depth nearest{std::numeric_limits<float>::infinity(), {}};  // of the surfaces that pass light
};

/// Of one ray or a packet.
struct ClosestQuery {
    embree::QueryContext context;  // first: Embree hands this address to the filters
    ClosestRay* rays;              // by RTCRay::id
};

void filter_closest(const RTCFilterFunctionNArguments* args) {
    keep_hits(args, [&](const Candidate& hit) {
        ClosestRay& ray = reinterpret_cast<ClosestQuery*>(args->context)->rays[hit.ray];
        if (hit.mesh.huge && !hit.crosses(ray.max_distance)) return false;
        if (!hit.mesh.material().passes_light()) return true;
        if (hit.mesh.material().alpha_mode == AlphaMode::mask &&
            alpha_at(*hit.mesh.scene, *hit.mesh.mesh, hit.id.triangle, hit.barycentric) == 0) {
            return false;
        }
        const Depth depth{hit.distance, hit.id};
        if (depth <= ray.behind || depth > ray.nearest) return false;
        ray.nearest = depth;
        return true;
    });
}

/// Where a shadow ray has met the edge of a triangle. All triangles that share the edge, or the vertex, are met; the
/// surface passes light only once.
struct EdgePassed {
    SurfaceId mesh;  // triangle left out
    float distance;
    bool front;
};

struct ShadowRay {
    static constexpr std::size_t most_edges = 8;

    float max_distance = 0;
    glm::vec3 transmittance{1};
    std::array<EdgePassed, most_edges> edges;
    std::size_t edge_count = 0;

    [[nodiscard]] bool has_passed(const Candidate& hit) {
        const EdgePassed here{
            {hit.id.instance, hit.id.geometry}, hit.distance, glm::dot(hit.direction, hit.normal) < 0};
        for (std::size_t i = 0; i < edge_count; ++i) {
            if (edges[i].mesh == here.mesh && edges[i].front == here.front &&
                std::abs(edges[i].distance - here.distance) <= 0x1p-16F * here.distance) {
                return true;
            }
        }
        if (edge_count < most_edges) edges[edge_count++] = here;
        return false;
    }
};

/// Of one ray or a packet.
struct ShadowQuery {
    embree::QueryContext context;  // first: Embree hands this address to the filters
    ShadowRay* rays;               // by RTCRay::id
};

void filter_shadow(const RTCFilterFunctionNArguments* args) {
    keep_hits(args, [&](const Candidate& hit) {
        ShadowRay& ray = reinterpret_cast<ShadowQuery*>(args->context)->rays[hit.ray];
        if (hit.mesh.huge && !hit.crosses(ray.max_distance)) return false;
        if (!hit.mesh.material().passes_light()) return true;
        if (hit.on_edge() && ray.has_passed(hit)) return false;
        ray.transmittance *=
            passed_share(surface_at(*hit.mesh.scene, *hit.mesh.mesh, hit.id.triangle, hit.barycentric));
        return ray.transmittance == glm::vec3(0);
    });
}

/// One of a packet's rays.
template <typename Packet>
void set_ray(Packet& packet, std::size_t i, glm::vec3 origin, glm::vec3 direction, float max_distance) {
    packet.org_x[i] = origin.x;
    packet.org_y[i] = origin.y;
    packet.org_z[i] = origin.z;
    packet.tnear[i] = ray_start;
    packet.dir_x[i] = direction.x;
    packet.dir_y[i] = direction.y;
    packet.dir_z[i] = direction.z;
    packet.time[i] = 0;
    packet.tfar[i] = max_distance;
    packet.mask[i] = ~0U;
    packet.id[i] = static_cast<unsigned>(i);
    packet.flags[i] = 0;
}

/// Which of a packet's rays there are, as Embree wants to know it.
struct alignas(4 * packet_size) PacketMask {
    std::array<int, packet_size> valid{};

    explicit PacketMask(std::size_t count) { std::fill_n(valid.begin(), count, -1); }
};

struct DeviceDeleter {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneDeleter {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using Device = std::unique_ptr<RTCDeviceTy, DeviceDeleter>;
using EmbreeScene = std::unique_ptr<RTCSceneTy, SceneDeleter>;

void check(RTCDevice device, const char* doing) {
    const RTCError code = rtcGetDeviceError(device);
    if (code == RTC_ERROR_NONE) return;
    const bool memory = code == RTC_ERROR_OUT_OF_MEMORY;
    throw Error(memory ? fmt::format("not enough memory for {}", doing)
                       : fmt::format("Embree error {} while {}", static_cast<int>(code), doing),
                "", memory ? "Bake a smaller level, or on a machine with more memory." : "", Fault::work);
}

float largest(glm::dvec3 v) {
    const glm::dvec3 a = glm::abs(v);
    return static_cast<float>(std::max({a.x, a.y, a.z}));
}

glm::dvec3 transform(const glm::mat4x3& m, glm::vec3 p) {
    return glm::dvec3(m[0]) * double(p.x) + glm::dvec3(m[1]) * double(p.y) + glm::dvec3(m[2]) * double(p.z) +
           glm::dvec3(m[3]);
}

Tracer::Corners corners_of(const Mesh& mesh, std::uint32_t triangle, const Instance* instance) {
    const glm::uvec3 index = mesh.triangles[triangle];
    const glm::vec3& a = mesh.positions[index.x];
    const glm::vec3& b = mesh.positions[index.y];
    const glm::vec3& c = mesh.positions[index.z];
    if (instance == nullptr) return {a, b, c, false};
    return {transform(instance->to_level, a), transform(instance->to_level, b), transform(instance->to_level, c),
            instance->mirrored};
}

/// Axes of an instance in the level.
glm::dmat3 axes_of(const Instance& instance) {
    return {glm::dvec3(instance.to_level[0]), glm::dvec3(instance.to_level[1]), glm::dvec3(instance.to_level[2])};
}

/// Triangles larger than this many times the median are huge: Embree's rounding at them would exceed small neighbours,
/// so that rays cannot start beyond it; they are checked in double instead.
constexpr float extent_limit_in_medians = 1024;

float extent_of(const Tracer::Corners& t) {
    return largest(glm::max(glm::max(t.a, t.b), t.c) - glm::min(glm::min(t.a, t.b), t.c));
}

/// Calls what(mesh index, extent along an axis) for every triangle in the level, as placed.
template <typename What>
void for_each_extent(const Scene& scene, What what) {
    const auto visit = [&](int mesh_index, const Instance* instance) {
        const Mesh& mesh = scene.meshes[mesh_index];
        for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
            what(mesh_index, extent_of(corners_of(mesh, i, instance)));
        }
    };
    for (const int mesh : scene.placed) visit(mesh, nullptr);
    for (const Instance& instance : scene.instances) {
        for (const int mesh : scene.models[instance.model].meshes) visit(mesh, &instance);
    }
}

/// The point with these weights of b and c, moved by about `distance` where an edge is nearer than that: in a corner, a
/// ray must not start within the rounding of the next wall. Slivers have no such place and stay.
///
/// extent  the largest coordinate of a way from the point to a corner: edges are at most 2 sqrt(3) times as long
glm::dvec3 off_edges(const Tracer::Corners& t, glm::dvec2 weight, double doubled_area, double extent, double distance) {
    glm::dvec3 weights(1 - weight.x - weight.y, weight);
    const double nearest = std::min({weights.x, weights.y, weights.z}) * doubled_area;  // times its edge
    if (nearest < 4 * extent * distance) {
        const glm::dvec3 edges(glm::distance(t.b, t.c), glm::distance(t.c, t.a), glm::distance(t.a, t.b));
        if (3 * distance * std::max({edges.x, edges.y, edges.z}) < doubled_area) {
            weights = glm::max(weights, edges * (distance / doubled_area));  // heights over the edges are area / edge
            weights /= weights.x + weights.y + weights.z;
        }
    }
    return t.a + weights.y * (t.b - t.a) + weights.z * (t.c - t.a);
}

glm::dmat3 absolute(const glm::dmat3& m) {
    return {glm::abs(m[0]), glm::abs(m[1]), glm::abs(m[2])};
}

float median(std::vector<float> values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

struct Tracer::Impl {
    const Scene* scene;
    Device device;
    std::vector<FilteredMesh> meshes;  // by mesh index
    std::vector<EmbreeScene> models;
    EmbreeScene root;
    std::vector<glm::mat3> normals;  // by instance: of its models' normals into the level
    std::size_t triangles = 0;
    float extent_limit = 0;  // beyond: huge

    [[nodiscard]] const Instance* instance(const SurfaceId& id) const {
        return id.instance == SurfaceId::none ? nullptr : &scene->instances[id.instance - scene->placed.size()];
    }
    [[nodiscard]] const Mesh& mesh(const SurfaceId& id) const {
        const Instance* placed_by = instance(id);
        const std::vector<int>& list = placed_by == nullptr ? scene->placed : scene->models[placed_by->model].meshes;
        return scene->meshes[list[id.geometry]];
    }

    /// What Embree found; the normal as it gives it, in the mesh's own space.
    [[nodiscard]] Hit hit(SurfaceId id, float distance, glm::vec2 barycentric, glm::vec3 normal) const {
        if (id.instance != SurfaceId::none) normal = normals[id.instance - scene->placed.size()] * normal;
        return {id, distance, barycentric, normal};
    }

    EmbreeScene new_scene() const {
        EmbreeScene result(rtcNewScene(device.get()));
        rtcSetSceneFlags(result.get(), RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(result.get(), RTC_BUILD_QUALITY_MEDIUM);
        return result;
    }

    void attach_mesh(RTCScene target, int mesh_index, unsigned id) {
        const Mesh& source = scene->meshes[mesh_index];
        RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, source.positions.data(), 0,
                                   sizeof(glm::vec3), source.positions.size());
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, source.triangles.data(), 0,
                                   sizeof(glm::uvec3), source.triangles.size());
        FilteredMesh& filtered = meshes[mesh_index];
        if (filtered.huge || filtered.material().passes_light()) {
            rtcSetGeometryUserData(geometry, &filtered);
            rtcSetGeometryIntersectFilterFunction(geometry, filter_closest);
            rtcSetGeometryOccludedFilterFunction(geometry, filter_shadow);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(target, geometry, id);
        rtcReleaseGeometry(geometry);
    }
};

Tracer::Tracer(const Scene& scene) : impl_(std::make_unique<Impl>()) {
    impl_->scene = &scene;
    impl_->device.reset(rtcNewDevice(nullptr));
    if (!impl_->device) throw Error("Embree could not start", "", "Does this processor have SSE2?", Fault::work);
    RTCDevice device = impl_->device.get();
    for (const Mesh& mesh : scene.meshes) {
        if (mesh.positions.capacity() <= mesh.positions.size()) {
            throw Error("mesh \"" + mesh.name + "\" has no room behind its last vertex", scene.name, "", Fault::work);
        }
        impl_->meshes.push_back({&scene, &mesh, false});
    }
    std::vector<float> extents;
    for_each_extent(scene, [&](int, float extent) { extents.push_back(extent); });
    impl_->triangles = extents.size();
    impl_->extent_limit = extent_limit_in_medians * median(std::move(extents));
    for_each_extent(scene, [&](int mesh, float extent) {
        if (extent > impl_->extent_limit) impl_->meshes[mesh].huge = true;
    });

    for (const Model& model : scene.models) {
        impl_->models.push_back(impl_->new_scene());
        for (unsigned i = 0; i < model.meshes.size(); ++i) {
            impl_->attach_mesh(impl_->models.back().get(), model.meshes[i], i);
        }
        rtcCommitScene(impl_->models.back().get());
    }
    impl_->root = impl_->new_scene();
    unsigned id = 0;
    for (const int mesh : scene.placed) impl_->attach_mesh(impl_->root.get(), mesh, id++);
    for (const Instance& instance : scene.instances) {
        if (is_flat(axes_of(instance))) {
            throw Error(fmt::format("an instance of model {} is flat", instance.model), scene.name, "", Fault::work);
        }
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, impl_->models[instance.model].get());
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, &instance.to_level);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(impl_->root.get(), geometry, id++);
        rtcReleaseGeometry(geometry);
        glm::dmat3 normals = glm::inverse(glm::transpose(axes_of(instance)));
        normals /= std::max({largest(normals[0]), largest(normals[1]), largest(normals[2])});
        impl_->normals.emplace_back(normals);
    }
    rtcCommitScene(impl_->root.get());
    check(device, "building the ray-tracing structure");
}

Tracer::~Tracer() = default;
Tracer::Tracer(Tracer&&) noexcept = default;
Tracer& Tracer::operator=(Tracer&&) noexcept = default;

const Scene& Tracer::scene() const noexcept {
    return *impl_->scene;
}
std::size_t Tracer::triangle_count() const noexcept {
    return impl_->triangles;
}
const Mesh& Tracer::mesh(SurfaceId id) const noexcept {
    return impl_->mesh(id);
}

Tracer::Corners Tracer::corners(SurfaceId id) const noexcept {
    return corners_of(impl_->mesh(id), id.triangle, impl_->instance(id));
}

Hit Tracer::closest_hit(glm::vec3 origin, glm::vec3 direction, float max_distance, const Hit& behind) const noexcept {
    ClosestRay state;
    state.max_distance = max_distance;
    ClosestQuery query;
    embree::init(query.context);
    query.rays = &state;
    float start = ray_start;
    if (behind.found()) {
        state.behind = {behind.distance, behind.id};
        start = std::nextafter(behind.distance, 0.0F);  // what is opaque and coincides comes next
    }
    RTCRayHit ray;
    ray.ray = {origin.x, origin.y, origin.z, start, direction.x, direction.y, direction.z, 0, max_distance, ~0U, 0, 0};
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    embree::intersect(impl_->root.get(), query.context, ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
    return impl_->hit({ray.hit.instID[0], ray.hit.geomID, ray.hit.primID}, ray.ray.tfar, {ray.hit.u, ray.hit.v},
                      {ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z});
}

void Tracer::closest_hits(glm::vec3 origin, std::span<const glm::vec3> directions, std::span<Hit> hits) const noexcept {
    for (std::size_t first = 0; first < directions.size(); first += packet_size) {
        const std::size_t count = std::min(packet_size, directions.size() - first);
        std::array<ClosestRay, packet_size> states;
        ClosestQuery query;
        embree::init(query.context);
        query.rays = states.data();
        RTCRayHit8 rays;
        for (std::size_t i = 0; i < count; ++i) {
            set_ray(rays.ray, i, origin, directions[first + i], std::numeric_limits<float>::infinity());
            rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
            rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
        const PacketMask mask(count);
        embree::intersect(mask.valid.data(), impl_->root.get(), query.context, rays);
        for (std::size_t i = 0; i < count; ++i) {
            const auto& hit = rays.hit;
            hits[first + i] = hit.geomID[i] == RTC_INVALID_GEOMETRY_ID
                                  ? Hit{}
                                  : impl_->hit({hit.instID[0][i], hit.geomID[i], hit.primID[i]}, rays.ray.tfar[i],
                                               {hit.u[i], hit.v[i]}, {hit.Ng_x[i], hit.Ng_y[i], hit.Ng_z[i]});
        }
    }
}

Surface Tracer::surface(const Hit& hit, glm::vec3 direction) const noexcept {
    const Mesh& mesh = impl_->mesh(hit.id);
    const Instance* instance = impl_->instance(hit.id);
    const auto [a, b, c, mirrored] = corners_of(mesh, hit.id.triangle, instance);
    const glm::dvec2 weight(hit.barycentric);
    const glm::dvec3 position = a + weight.x * (b - a) + weight.y * (c - a);
    const glm::dvec3 cross = glm::cross(b - a, c - a);
    const double doubled_area = glm::length(cross);
    glm::dvec3 normal = cross / doubled_area;
    if (mirrored) normal = -normal;
    // No area is left in double where rounding let Embree meet it: such a triangle faces the ray.
    if (!(doubled_area > 0)) normal = -glm::normalize(glm::dvec3(direction));

    Surface surface;
    surface.mesh = &mesh;
    surface.normal = glm::vec3(normal);
    surface.front = glm::dot(direction, surface.normal) < 0;
    // Rounding of the position, half a unit in the last place of its coordinates, and of Embree's own distance to the
    // triangle, some units of its extent. The rays of an instance are rounded in its own space, where they are sums of
    // these terms; what that is along the normal counts.
    const double extent = std::max({largest(a - position), largest(b - position), largest(c - position)});
    double rounding = largest(position) + std::min<double>(extent, impl_->extent_limit);
    if (instance != nullptr) {
        const glm::dmat3 axes = axes_of(*instance);
        const glm::dvec3 place(instance->to_level[3]);
        const glm::dvec3 terms = absolute(glm::inverse(axes)) * (glm::abs(position) + glm::abs(place));
        rounding += glm::dot(glm::abs(normal * axes), terms);
    }
    surface.offset = static_cast<float>(rounding * 0x1p-22);
    surface.position = glm::vec3(off_edges({a, b, c, mirrored}, weight, doubled_area, extent, surface.offset));
    return surface;
}

glm::vec3 Tracer::transmittance(glm::vec3 origin, glm::vec3 direction, float max_distance) const noexcept {
    ShadowRay state;
    state.max_distance = max_distance;
    ShadowQuery query;
    embree::init(query.context);
    query.rays = &state;
    RTCRay ray{origin.x,    origin.y, origin.z,     ray_start, direction.x, direction.y,
               direction.z, 0,        max_distance, ~0U,       0,           0};
    embree::occluded(impl_->root.get(), query.context, ray);
    return ray.tfar < 0 ? glm::vec3(0) : state.transmittance;
}

void Tracer::transmittances(glm::vec3 origin, std::span<const Way> ways, std::span<glm::vec3> shares) const noexcept {
    for (std::size_t first = 0; first < ways.size(); first += packet_size) {
        const std::size_t count = std::min(packet_size, ways.size() - first);
        std::array<ShadowRay, packet_size> states;
        ShadowQuery query;
        embree::init(query.context);
        query.rays = states.data();
        RTCRay8 rays;
        for (std::size_t i = 0; i < count; ++i) {
            const Way& way = ways[first + i];
            states[i].max_distance = way.max_distance;
            set_ray(rays, i, origin, way.direction, way.max_distance);
        }
        const PacketMask mask(count);
        embree::occluded(mask.valid.data(), impl_->root.get(), query.context, rays);
        for (std::size_t i = 0; i < count; ++i) {
            shares[first + i] = rays.tfar[i] < 0 ? glm::vec3(0) : states[i].transmittance;
        }
    }
}

}  // namespace lightgrid
