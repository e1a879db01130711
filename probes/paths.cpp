#include "probes/paths.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <cmath>

namespace lightgrid {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float uniform_sphere_pdf = 0.25F * glm::one_over_pi<float>();

/// Paths whose throughput stays above this never end by chance; below it they survive in proportion to it.
constexpr float roulette_threshold = 0.25F;

float largest(glm::vec3 v) {
    return std::max({v.x, v.y, v.z});
}

bool is_finite(glm::vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

/// A place where light is collected from all directions: a probe (no surface) or a point on a Lambertian surface.
struct PathTracer::Vertex {
    glm::vec3 position{0};
    const Surface* surface = nullptr;
    glm::vec3 normal{0};  // on the side of the path; 0 at a probe

    /// Density with which the path goes on in `direction`, per steradian.
    [[nodiscard]] float pdf(glm::vec3 direction) const {
        if (surface == nullptr) return uniform_sphere_pdf;
        return std::max(0.0F, glm::dot(normal, direction)) * glm::one_over_pi<float>();
    }
    /// What radiance from `direction` counts for: 1 at a probe; cosine / pi on a surface, whose albedo is in the
    /// throughput.
    [[nodiscard]] float response(glm::vec3 direction) const { return surface == nullptr ? 1.0F : pdf(direction); }
    [[nodiscard]] Receiver receiver() const { return {position, normal}; }
    [[nodiscard]] glm::vec3 origin(glm::vec3 direction) const {
        return surface == nullptr ? position : surface->leave(direction);
    }
};

/// What a gather's random numbers are for: each has a stream of its own.
enum Stream : std::uint64_t { turning, stratified, independent };

/// The random numbers of one path: its first decisions by low-discrepancy points, so that they are stratified over all
/// paths of a replicate; the others by independent numbers.
class PathTracer::Dimensions {
  public:
    Dimensions(std::uint64_t key, std::uint32_t index)
        : key_(mix_bits(key, stratified)), index_(index), tail_(mix_bits(mix_bits(key, independent), index)) {}

    [[nodiscard]] glm::vec2 next2() {
        if (pair_ == stratified_pairs) return tail_.next2();
        const std::uint64_t seed = mix_bits(key_, pair_++);
        return sobol_point(shuffled_index(index_, static_cast<std::uint32_t>(mix_bits(seed, 0))), seed);
    }
    /// One number of a pair, in double: stratified in its upper 24 bits.
    [[nodiscard]] double next_choice() { return next2().x + 0x1p-24 * tail_.next_double(); }
    [[nodiscard]] float next() { return tail_.next(); }

  private:
    static constexpr std::uint32_t stratified_pairs = 8;

    std::uint64_t key_;
    std::uint32_t index_;
    std::uint32_t pair_ = 0;
    RandomStream tail_;
};

PathTracer::PathTracer(const Tracer& tracer, const Environment& environment)
    : tracer_(&tracer), environment_(&environment), emitters_(tracer) {
    const Scene& scene = tracer.scene();
    use_.emitters = !emitters_.empty();
    use_.sky = !environment.is_black();
    use_.environment = use_.sky && !environment.is_uniform();
    use_.lights = !scene.lights.empty();
    use_.reflection = std::any_of(scene.meshes.begin(), scene.meshes.end(), [&](const Mesh& mesh) {
        return scene.materials[mesh.material].base_color != glm::vec3(0);
    });
}

PunctualLight punctual_light_at(const Light& light, glm::vec3 point) noexcept {
    PunctualLight result;
    if (light.kind == LightKind::directional) {
        result.direction = -light.direction;
        result.irradiance = light.intensity;
        result.free_distance = infinity;
        return result;
    }
    const glm::vec3 to_light = light.position - point;
    const float squared = glm::dot(to_light, to_light);
    if (!(squared > 0)) return result;
    const float distance = std::sqrt(squared);
    result.direction = to_light / distance;
    // Up to the rounding of its place: a light exactly on a ceiling is not behind it.
    const float rounding = 0x1p-20F * (distance + largest(glm::abs(light.position)));
    result.free_distance = std::max(0.0F, distance - rounding);
    const float ratio = distance / light.range;  // 0 for an unlimited range
    const float window = std::clamp(1 - ratio * ratio * ratio * ratio, 0.0F, 1.0F);
    float cone = 1;
    if (light.kind == LightKind::spot) {
        const float cosine = -glm::dot(result.direction, light.direction);
        const float t =
            std::clamp((cosine - light.cos_outer) / std::max(0.001F, light.cos_inner - light.cos_outer), 0.0F, 1.0F);
        cone = t * t;
    }
    result.irradiance = light.intensity * (window * cone / squared);
    return result;
}

LightSample PathTracer::from_emitters(const Vertex& vertex, Dimensions& dimensions, PathCounts& counts) const {
    const double pick = dimensions.next_choice();
    const Emitters::Sample emitter = emitters_.sample(vertex.receiver(), pick, dimensions.next2());
    if (emitter.radiance == glm::vec3(0)) return {};
    const glm::vec3 direction = glm::normalize(emitter.position - vertex.position);
    const float response = vertex.response(direction);
    if (!(response > 0)) return {};
    const glm::vec3 origin = vertex.origin(direction);
    ++counts.shadow_rays;
    const glm::vec3 passed = tracer_->transmittance(origin, emitter.position - origin, 1);
    return {direction, passed * emitter.radiance * (response / (emitter.pdf + vertex.pdf(direction)))};
}

LightSample PathTracer::from_environment(const Vertex& vertex, Dimensions& dimensions, PathCounts& counts) const {
    const float pick = dimensions.next2().x;
    const Environment::Sample sky = environment_->sample({pick, dimensions.next2()});
    if (!(sky.pdf > 0)) return {};
    const float response = vertex.response(sky.direction);
    if (!(response > 0)) return {};
    ++counts.shadow_rays;
    const glm::vec3 passed = tracer_->transmittance(vertex.origin(sky.direction), sky.direction, infinity);
    return {sky.direction, passed * sky.radiance * (response / (sky.pdf + vertex.pdf(sky.direction)))};
}

LightSample PathTracer::from_lights(const Vertex& vertex, Dimensions& dimensions, PathCounts& counts) const {
    const std::vector<Light>& lights = tracer_->scene().lights;
    // One light, picked in proportion to what it would bring if nothing were in the way.
    const auto brings = [&](const Light& light) {
        const PunctualLight arriving = punctual_light_at(light, vertex.position);
        return luminance(arriving.irradiance) * vertex.response(arriving.direction);
    };
    float sum = 0;
    for (const Light& light : lights) sum += brings(light);
    if (!(sum > 0)) return {};
    float left = dimensions.next2().x * sum;
    float share = 0;
    const Light* picked = nullptr;
    for (const Light& light : lights) {
        const float brought = brings(light);
        if (!(brought > 0)) continue;
        picked = &light;
        share = brought;
        left -= brought;
        if (left < 0) break;
    }
    const PunctualLight arriving = punctual_light_at(*picked, vertex.position);
    ++counts.shadow_rays;
    const glm::vec3 passed =
        tracer_->transmittance(vertex.origin(arriving.direction), arriving.direction, arriving.free_distance);
    return {arriving.direction, passed * arriving.irradiance * (vertex.response(arriving.direction) * sum / share)};
}

glm::vec3 PathTracer::radiance_along(glm::vec3 origin, glm::vec3 direction, Dimensions& dimensions, PathCounts& counts,
                                     std::uint32_t most_bounces) const {
    const Scene& scene = tracer_->scene();
    glm::vec3 radiance(0);
    glm::vec3 throughput(1);
    Receiver scattered_at{origin, {}};         // where the path last chose a direction,
    float scattered_pdf = uniform_sphere_pdf;  // and how densely
    Hit passed_through;                        // since then, the last surface
    for (std::uint32_t bounce = 0;;) {
        ++counts.rays;
        const Hit hit = tracer_->closest_hit(origin, direction, infinity, passed_through);
        if (!hit.found()) {
            if (use_.sky) {
                const Environment::Sample sky = environment_->look_up(direction);
                const float other = use_.environment ? sky.pdf : 0.0F;
                radiance += throughput * sky.radiance * (scattered_pdf / (scattered_pdf + other));
            }
            return radiance;
        }
        const Surface surface = tracer_->surface(hit, direction);
        const SurfacePoint point = surface_at(scene, *surface.mesh, hit.id.triangle, hit.barycentric);
        if (point.emission != glm::vec3(0) && emitters_.emits(hit, surface.front)) {
            const float other = emitters_.pdf(scattered_at, hit, surface);
            radiance += throughput * point.alpha * point.emission * (scattered_pdf / (scattered_pdf + other));
        }

        // Straight on, or reflected.
        const glm::vec3 passed = passed_share(point);
        const glm::vec3 reflected = reflected_share(point);
        if (passed != glm::vec3(0)) {
            const float pass_probability = luminance(passed) / (luminance(passed) + luminance(reflected));
            if (dimensions.next() < pass_probability) {
                throughput *= passed / pass_probability;
                passed_through = hit;
                continue;
            }
            throughput /= 1 - pass_probability;
        }
        throughput *= reflected;
        if (bounce++ == most_bounces) return radiance;

        const float brightest = largest(throughput);
        if (brightest < roulette_threshold) {
            const float survival = brightest / roulette_threshold;
            if (!(dimensions.next() < survival)) return radiance;
            throughput /= survival;
        }

        const Vertex vertex{surface.position, &surface, surface.front ? surface.normal : -surface.normal};
        if (use_.lights) radiance += throughput * from_lights(vertex, dimensions, counts).radiance;
        if (use_.emitters) radiance += throughput * from_emitters(vertex, dimensions, counts).radiance;
        if (use_.environment) radiance += throughput * from_environment(vertex, dimensions, counts).radiance;

        direction = cosine_direction(vertex.normal, dimensions.next2());
        origin = surface.leave(direction);
        scattered_at = vertex.receiver();
        passed_through = {};
        scattered_pdf = vertex.pdf(direction);
        if (!(scattered_pdf > 0)) return radiance;
    }
}

void PathTracer::gather(glm::vec3 point, std::uint64_t key, std::span<const glm::vec3> even,
                        std::vector<LightSample>& out, PathCounts& counts, std::uint32_t most_bounces) const {
    const Vertex probe{point, nullptr, {}};
    const float share = 1 / static_cast<float>(even.size());
    const glm::mat3 rotation = random_rotation(mix_bits(key, turning));
    const auto add = [&](LightSample sample, float weight) {
        sample.radiance *= weight;
        if (!is_finite(sample.radiance)) {
            ++counts.dropped;
            return;
        }
        if (sample.radiance != glm::vec3(0)) out.push_back(sample);
    };
    for (std::uint32_t i = 0; i < even.size(); ++i) {
        Dimensions dimensions(key, i);
        const glm::vec3 direction = rotation * even[i];
        if (use_.emitters) add(from_emitters(probe, dimensions, counts), share);
        if (use_.environment) add(from_environment(probe, dimensions, counts), share);
        add({direction, radiance_along(point, direction, dimensions, counts, most_bounces)},
            share / uniform_sphere_pdf);
    }
}

void PathTracer::gather_punctual(glm::vec3 point, std::vector<LightSample>& out, PathCounts& counts) const {
    for (const Light& light : tracer_->scene().lights) {
        const PunctualLight arriving = punctual_light_at(light, point);
        if (arriving.irradiance == glm::vec3(0)) continue;
        ++counts.shadow_rays;
        const glm::vec3 passed = tracer_->transmittance(point, arriving.direction, arriving.free_distance);
        if (passed != glm::vec3(0)) out.push_back({arriving.direction, passed * arriving.irradiance});
    }
}

}  // namespace lightgrid
