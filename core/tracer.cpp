#include "core/tracer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace lightgrid {
namespace {

// Embree 3 and 4 differ in how a query's own filter is passed; everything else here is the same for both.
#if RTC_VERSION_MAJOR >= 4
using QueryContext = RTCRayQueryContext;
constexpr RTCSceneFlags query_filter_flag = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;

void intersect(RTCScene scene, QueryContext* context, RTCRayHit* ray) {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = context;
    rtcIntersect1(scene, ray, &arguments);
}

void occluded(RTCScene scene, QueryContext* context, RTCRay* ray, RTCFilterFunctionN filter) {
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = context;
    arguments.filter = filter;
    if (filter != nullptr) arguments.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
    rtcOccluded1(scene, ray, &arguments);
}

void init(QueryContext* context) { rtcInitRayQueryContext(context); }
#else
using QueryContext = RTCIntersectContext;
constexpr RTCSceneFlags query_filter_flag = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;

void intersect(RTCScene scene, QueryContext* context, RTCRayHit* ray) { rtcIntersect1(scene, context, ray); }

void occluded(RTCScene scene, QueryContext* context, RTCRay* ray, RTCFilterFunctionN filter) {
    context->filter = filter;
    rtcOccluded1(scene, context, ray);
}

void init(QueryContext* context) { rtcInitIntersectContext(context); }
#endif

struct ShadowQuery {
    QueryContext context;  // first: Embree hands this address to the filters
    SurfaceId source;
    glm::vec3 transmittance;
};

/// What Embree's filters need of a geometry that light may pass.
struct FilteredMesh {
    const Scene* scene;
    const Mesh* mesh;
};

void cut_masked(const RTCFilterFunctionNArguments* args) {
    const auto& filtered = *static_cast<const FilteredMesh*>(args->geometryUserPtr);
    const glm::vec2 barycentric(RTCHitN_u(args->hit, 1, 0), RTCHitN_v(args->hit, 1, 0));
    const std::uint32_t triangle = RTCHitN_primID(args->hit, 1, 0);
    if (alpha_at(*filtered.scene, *filtered.mesh, triangle, barycentric) == 0) args->valid[0] = 0;
}

bool is_source(const RTCFilterFunctionNArguments* args, const SurfaceId& source) {
    return RTCHitN_primID(args->hit, 1, 0) == source.triangle && RTCHitN_geomID(args->hit, 1, 0) == source.geometry &&
           RTCHitN_instID(args->hit, 1, 0, 0) == source.instance;
}

void skip_source(const RTCFilterFunctionNArguments* args) {
    if (is_source(args, reinterpret_cast<const ShadowQuery*>(args->context)->source)) args->valid[0] = 0;
}

void attenuate(const RTCFilterFunctionNArguments* args) {
    auto& query = *reinterpret_cast<ShadowQuery*>(args->context);
    if (is_source(args, query.source)) {
        args->valid[0] = 0;
        return;
    }
    const auto& filtered = *static_cast<const FilteredMesh*>(args->geometryUserPtr);
    const glm::vec2 barycentric(RTCHitN_u(args->hit, 1, 0), RTCHitN_v(args->hit, 1, 0));
    query.transmittance *=
        passed_share(surface_at(*filtered.scene, *filtered.mesh, RTCHitN_primID(args->hit, 1, 0), barycentric));
    if (query.transmittance != glm::vec3(0)) args->valid[0] = 0;
}

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

/// Triangles larger than this many times the median take their ray offset from that bound, and shadow rays that start on
/// them are told to ignore them: Embree's rounding there grows with the triangle and would exceed small neighbours.
constexpr float extent_limit_in_medians = 1024;

/// The largest extent along an axis of every triangle in the level, as placed.
std::vector<float> triangle_extents(const Scene& scene) {
    std::vector<float> extents;
    const auto add = [&](int mesh_index, const Instance* instance) {
        const Mesh& mesh = scene.meshes[mesh_index];
        for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
            const auto [a, b, c, mirrored] = corners_of(mesh, i, instance);
            extents.push_back(largest(glm::max(glm::max(a, b), c) - glm::min(glm::min(a, b), c)));
        }
    };
    for (const int mesh : scene.placed) add(mesh, nullptr);
    for (const Instance& instance : scene.instances) {
        for (const int mesh : scene.models[instance.model].meshes) add(mesh, &instance);
    }
    return extents;
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
    std::size_t triangles = 0;
    float extent_limit = 0;
    bool has_huge_triangles = false;  // beyond extent_limit

    [[nodiscard]] const Instance* instance(const SurfaceId& id) const {
        return id.instance == SurfaceId::none ? nullptr : &scene->instances[id.instance - scene->placed.size()];
    }
    [[nodiscard]] const Mesh& mesh(const SurfaceId& id) const {
        const Instance* placed_by = instance(id);
        const std::vector<int>& list = placed_by == nullptr ? scene->placed : scene->models[placed_by->model].meshes;
        return scene->meshes[list[id.geometry]];
    }

    EmbreeScene new_scene() const {
        EmbreeScene result(rtcNewScene(device.get()));
        rtcSetSceneFlags(result.get(), has_huge_triangles ? RTC_SCENE_FLAG_ROBUST | query_filter_flag
                                                          : RTC_SCENE_FLAG_ROBUST);
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
        const Material& material = scene->materials[source.material];
        if (material.passes_light()) {
            rtcSetGeometryUserData(geometry, &meshes[mesh_index]);
            rtcSetGeometryOccludedFilterFunction(geometry, attenuate);
            if (material.alpha_mode == AlphaMode::mask) rtcSetGeometryIntersectFilterFunction(geometry, cut_masked);
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
        impl_->meshes.push_back({&scene, &mesh});
    }
    const std::vector<float> extents = triangle_extents(scene);
    impl_->triangles = extents.size();
    impl_->extent_limit = extent_limit_in_medians * median(extents);
    impl_->has_huge_triangles =
        std::any_of(extents.begin(), extents.end(), [&](float e) { return e > impl_->extent_limit; });

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
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, impl_->models[instance.model].get());
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, &instance.to_level);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(impl_->root.get(), geometry, id++);
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(impl_->root.get());
    check(device, "building the ray-tracing structure");
}

Tracer::~Tracer() = default;
Tracer::Tracer(Tracer&&) noexcept = default;
Tracer& Tracer::operator=(Tracer&&) noexcept = default;

const Scene& Tracer::scene() const noexcept { return *impl_->scene; }
std::size_t Tracer::triangle_count() const noexcept { return impl_->triangles; }
const Mesh& Tracer::mesh(SurfaceId id) const noexcept { return impl_->mesh(id); }

Tracer::Corners Tracer::corners(SurfaceId id) const noexcept {
    return corners_of(impl_->mesh(id), id.triangle, impl_->instance(id));
}

Hit Tracer::closest_hit(glm::vec3 origin, glm::vec3 direction, SurfaceId source, float max_distance) const noexcept {
    QueryContext context;
    init(&context);
    RTCRayHit query;
    query.ray = {origin.x, origin.y, origin.z, 0, direction.x, direction.y, direction.z, 0, max_distance, ~0U, 0, 0};
    while (true) {
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        intersect(impl_->root.get(), &context, &query);
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
        const SurfaceId id{query.hit.instID[0], query.hit.geomID, query.hit.primID};
        if (id != source) return {id, query.ray.tfar, {query.hit.u, query.hit.v}};
        query.ray.tnear = std::nextafter(query.ray.tfar, std::numeric_limits<float>::infinity());
        query.ray.tfar = max_distance;
    }
}

Surface Tracer::surface(const Hit& hit, glm::vec3 direction) const noexcept {
    const Mesh& mesh = impl_->mesh(hit.id);
    const Instance* instance = impl_->instance(hit.id);
    const auto [a, b, c, mirrored] = corners_of(mesh, hit.id.triangle, instance);
    const glm::dvec2 weight(hit.barycentric);
    const glm::dvec3 position = a + weight.x * (b - a) + weight.y * (c - a);
    glm::dvec3 normal = glm::normalize(glm::cross(b - a, c - a));
    if (mirrored) normal = -normal;

    Surface surface;
    surface.mesh = &mesh;
    surface.position = glm::vec3(position);
    surface.normal = glm::vec3(normal);
    surface.front = glm::dot(direction, surface.normal) < 0;
    // Rounding of the position (half a unit in the last place of its coordinates) and of Embree's own distance to the
    // triangle (units of the triangle's extent; an instance's rays are rounded in its own space).
    const double extent = std::min<double>(
        std::max({largest(a - position), largest(b - position), largest(c - position)}), impl_->extent_limit);
    const double frame = instance == nullptr ? 0.0 : largest(glm::dvec3(instance->to_level[3]));
    surface.offset = static_cast<float>((largest(position) + extent + frame) * 0x1p-22);
    return surface;
}

glm::vec3 Tracer::transmittance(glm::vec3 origin, glm::vec3 direction, float max_distance,
                                SurfaceId source) const noexcept {
    ShadowQuery query;
    init(&query.context);
    query.source = source;
    query.transmittance = glm::vec3(1);
    RTCRay ray{origin.x, origin.y, origin.z, 0, direction.x, direction.y, direction.z, 0, max_distance, ~0U, 0, 0};
    occluded(impl_->root.get(), &query.context, &ray, impl_->has_huge_triangles ? skip_source : nullptr);
    return ray.tfar < 0 ? glm::vec3(0) : query.transmittance;
}

}  // namespace lightgrid
