#include "probes/paths.h"

#include "probes/surface_cache.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <cmath>

namespace lightgrid {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float uniform_sphere_pdf = 0.25F * glm::one_over_pi<float>();

/// Paths whose throughput stays above this never end by chance; below it they survive in proportion to it.
constexpr float roulette_threshold = 0.25F;

/// Of light that passes surfaces straight on, less than this share is not followed up.
constexpr float least_share = 1e-4F;

float largest(glm::vec3 v) {
    return std::max({v.x, v.y, v.z});
}

bool is_finite(glm::vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void add(const LightSample& sample, std::vector<LightSample>& out, PathCounts& counts) {
    if (!is_finite(sample.radiance)) {
        ++counts.dropped;
        return;
    }
    if (sample.radiance != glm::vec3(0)) out.push_back(sample);
}

}  // namespace

/// A place where light is collected from all directions: a probe (no surface) or a point on a Lambertian surface.
struct PathTracer::Vertex {
    glm::vec3 position{0};
    const Surface* surface = nullptr;
    glm::vec3 normal{0};              // on the side of the path; 0 at a probe
    const EmitterCut* cut = nullptr;  // see Receiver

    /// Density with which the path goes on in `direction`, per steradian.
    [[nodiscard]] float pdf(glm::vec3 direction) const {
        if (surface == nullptr) return uniform_sphere_pdf;
        return std::max(0.0F, glm::dot(normal, direction)) * glm::one_over_pi<float>();
    }
    /// What radiance from `direction` counts for: 1 at a probe; cosine / pi on a surface, whose albedo is in the
    /// throughput.
    [[nodiscard]] float response(glm::vec3 direction) const { return surface == nullptr ? 1.0F : pdf(direction); }
    [[nodiscard]] Receiver receiver() const { return {position, normal, cut}; }
    /// Of all rays that count for something.
    [[nodiscard]] glm::vec3 origin() const { return surface == nullptr ? position : surface->leave(normal); }
};

/// What a gather's random numbers are for: each has a stream of its own.
enum Stream : std::uint64_t { turning, stratified, independent, lighting };

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

/// Light as if nothing were in the way, and the way from the vertex's origin that it takes; black where there is none.
struct PathTracer::Aimed {
    LightSample light;
    Tracer::Way way;
    LightSet of = 0;  // where it comes from
};

PathTracer::PathTracer(const Tracer& tracer, const Environment& environment, LightSources sources)
    : tracer_(&tracer), environment_(&environment), sources_(std::move(sources)), emitters_(tracer, sources_) {
    const Scene& scene = tracer.scene();
    use_.emitters = !emitters_.empty();
    use_.sky = !environment.is_black() && sources_.of_sky != LightSources::off;
    use_.environment = use_.sky && !environment.is_uniform();
    if (use_.emitters) lights_ |= emissive_light;
    if (use_.sky) lights_ |= sky_light;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        if (sources_.light(i) == LightSources::off || scene.lights[i].intensity == glm::vec3(0)) continue;
        use_.lights = true;
        lights_ |= punctual_light(i);
    }
    use_.reflection = std::any_of(scene.meshes.begin(), scene.meshes.end(), [&](const Mesh& mesh) {
        return scene.materials[mesh.material].base_color != glm::vec3(0);
    });
    for (const Material& material : scene.materials) {
        // What MASK cuts away is never met.
        const bool passes = material.alpha_mode == AlphaMode::blend || material.transmission > 0;
        only_reflects_.push_back(!passes && !material.emits());
    }
}

bool PathTracer::only_reflects(const Hit& hit) const noexcept {
    return only_reflects_[static_cast<std::size_t>(tracer_->mesh(hit.id).material)] != 0;
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

PathTracer::Aimed PathTracer::at_emitters(const Vertex& vertex, Dimensions& dimensions, float rays_per_sample) const {
    const double pick = dimensions.next_choice();
    const Emitters::Sample emitter = emitters_.sample(vertex.receiver(), pick, dimensions.next2());
    if (emitter.radiance == glm::vec3(0)) return {};
    const glm::vec3 direction = glm::normalize(emitter.position - vertex.position);
    const float response = vertex.response(direction);
    if (!(response > 0)) return {};
    const glm::vec3 radiance = emitter.radiance * (response / (emitter.pdf + rays_per_sample * vertex.pdf(direction)));
    return {{direction, radiance, sources_.material(tracer_->mesh(emitter.id).material)},
            {emitter.position - vertex.origin(), 1},
            emissive_light};
}

PathTracer::Aimed PathTracer::at_sky(const Vertex& vertex, const SkyLight::Sample& sample) const {
    const float response = vertex.response(sample.direction);
    if (!(response > 0)) return {};
    return {{sample.direction, sample.radiance * response, sources_.of_sky}, {sample.direction, infinity}, sky_light};
}

PathTracer::Aimed PathTracer::at_environment(const Vertex& vertex, Dimensions& dimensions) const {
    const float pick = dimensions.next2().x;
    const Environment::Sample sky = environment_->sample({pick, dimensions.next2()});
    if (!(sky.pdf > 0)) return {};
    const float response = vertex.response(sky.direction);
    if (!(response > 0)) return {};
    return {{sky.direction, sky.radiance * (response / (sky.pdf + vertex.pdf(sky.direction))), sources_.of_sky},
            {sky.direction, infinity},
            sky_light};
}

PathTracer::Aimed PathTracer::at_lights(const Vertex& vertex, Dimensions& dimensions) const {
    const std::vector<Light>& lights = tracer_->scene().lights;
    // One light, picked in proportion to what it would bring if nothing were in the way.
    const auto brings = [&](const Light& light) {
        if (sources_.light(static_cast<std::size_t>(&light - lights.data())) == LightSources::off) return 0.0F;
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
    const auto index = static_cast<std::size_t>(picked - lights.data());
    return {{arriving.direction, arriving.irradiance * (vertex.response(arriving.direction) * sum / share),
             sources_.light(index)},
            {arriving.direction, arriving.free_distance},
            punctual_light(index)};
}

glm::vec3 PathTracer::arriving(const Vertex& vertex, const Aimed& aimed, PathCounts& counts) const {
    if (aimed.light.radiance == glm::vec3(0)) return glm::vec3(0);
    ++counts.shadow_rays;
    counts.tested |= aimed.of;
    return aimed.light.radiance * tracer_->transmittance(vertex.origin(), aimed.way.direction, aimed.way.max_distance);
}

void PathTracer::aim(const Aimed& sample, float weight, std::vector<Aimed>& aimed) {
    if (sample.light.radiance == glm::vec3(0)) return;
    aimed.push_back(sample);
    aimed.back().light.radiance *= weight;
}

void PathTracer::let_through(const Vertex& vertex, std::span<const Aimed> aimed, std::vector<LightSample>& out,
                             PathCounts& counts) const {
    std::vector<Tracer::Way> ways;
    ways.reserve(aimed.size());
    for (const Aimed& a : aimed) {
        ways.push_back(a.way);
        counts.tested |= a.of;
    }
    std::vector<glm::vec3> shares(ways.size());
    counts.shadow_rays += ways.size();
    tracer_->transmittances(vertex.origin(), ways, shares);
    for (std::size_t i = 0; i < aimed.size(); ++i) {
        LightSample light = aimed[i].light;
        light.radiance *= shares[i];
        add(light, out, counts);
    }
}

glm::vec3 PathTracer::sky_along(glm::vec3 share, glm::vec3 direction, float pdf) const {
    if (!use_.sky) return glm::vec3(0);
    const Environment::Sample sky = environment_->look_up(direction);
    const float other = use_.environment ? sky.pdf : 0.0F;
    return share * sky.radiance * (pdf / (pdf + other));
}

glm::vec3 PathTracer::emission_of(glm::vec3 share, const Hit& hit, const Surface& surface, const SurfacePoint& point,
                                  const Receiver& from, float pdf, float samples_per_ray) const {
    if (point.emission == glm::vec3(0) || !emitters_.emits(hit, surface.front)) return glm::vec3(0);
    const float other = samples_per_ray * emitters_.pdf(from, hit, surface);
    return share * point.alpha * point.emission * (pdf / (pdf + other));
}

std::vector<Hit> PathTracer::closest_hits(glm::vec3 origin, std::span<const glm::vec3> directions,
                                          PathCounts& counts) const {
    std::vector<Hit> hits(directions.size());
    counts.rays += hits.size();
    // A sky that is the same from everywhere is asked for by every ray, in whatever direction; others by samples of them.
    if (use_.sky && !use_.environment) counts.tested |= sky_light;
    tracer_->closest_hits(origin, directions, hits);
    return hits;
}

void PathTracer::look_along(const Receiver& from, glm::vec3 origin, glm::vec3 direction, const Hit& first,
                            float samples_per_ray, const SkyLight& sky, std::span<glm::vec3> light,
                            std::vector<Met>& met, PathCounts& counts) const {
    const bool on_surface = from.normal != glm::vec3(0);
    const float pdf =
        on_surface ? std::max(0.0F, glm::dot(from.normal, direction)) * glm::one_over_pi<float>() : uniform_sphere_pdf;
    Met now{first};
    for (;;) {
        met.push_back(now);
        if (!now.hit.found()) {
            if (use_.sky && !light.empty()) light[sources_.of_sky] += now.share * sky.along(direction);
            return;
        }
        if (only_reflects(now.hit)) return;
        const Surface surface = tracer_->surface(now.hit, direction);
        const SurfacePoint point =
            surface_at(tracer_->scene(), *surface.mesh, now.hit.id.triangle, now.hit.barycentric);
        const std::uint32_t source = sources_.material(surface.mesh->material);
        if (!light.empty() && source != LightSources::off) {
            light[source] += emission_of(now.share, now.hit, surface, point, from, pdf, samples_per_ray);
        }
        now.share *= passed_share(point);
        if (largest(now.share) < least_share) return;
        ++counts.rays;
        now.hit = tracer_->closest_hit(origin, direction, infinity, now.hit);
    }
}

void PathTracer::direct_light(const Surface& surface, const Receiver& at, std::uint64_t key, std::uint32_t i,
                              std::uint32_t count, float rays_per_sample, const SkyLight& sky,
                              std::span<glm::vec3> light, PathCounts& counts) const {
    const Vertex vertex{at.position, &surface, at.normal, at.cut};
    const float share = 1 / static_cast<float>(count);
    std::vector<Aimed> aimed;
    if (use_.emitters || use_.lights) {
        for (std::uint32_t k = i * count; k < (i + 1) * count; ++k) {
            Dimensions dimensions(key, k);
            if (use_.emitters) aim(at_emitters(vertex, dimensions, rays_per_sample), share, aimed);
            if (use_.lights) aim(at_lights(vertex, dimensions), share, aimed);
        }
    }
    if (use_.sky && sky.has_samples()) {
        for (const SkyLight::Sample& sample : sky.samples(key + i, count)) aim(at_sky(vertex, sample), share, aimed);
    }
    std::vector<LightSample> arrived;
    let_through(vertex, aimed, arrived, counts);
    for (const LightSample& sample : arrived) light[sample.source] += sample.radiance;
}

glm::vec3 PathTracer::reflected_radiance(const Hit& hit, glm::vec3 direction, std::uint64_t key, std::uint32_t i,
                                         PathCounts& counts) const {
    const Surface surface = tracer_->surface(hit, direction);
    const SurfacePoint point = surface_at(tracer_->scene(), *surface.mesh, hit.id.triangle, hit.barycentric);
    const glm::vec3 reflected = reflected_share(point);
    if (reflected == glm::vec3(0)) return glm::vec3(0);
    Dimensions dimensions(key, i);
    const Vertex vertex{surface.position, &surface, surface.front ? surface.normal : -surface.normal};
    glm::vec3 radiance(0);
    if (use_.lights) radiance += arriving(vertex, at_lights(vertex, dimensions), counts);
    if (use_.emitters) radiance += arriving(vertex, at_emitters(vertex, dimensions), counts);
    if (use_.environment) radiance += arriving(vertex, at_environment(vertex, dimensions), counts);
    const glm::vec3 onwards = cosine_direction(vertex.normal, dimensions.next2());
    const float pdf = vertex.pdf(onwards);
    if (pdf > 0) {
        const glm::vec3 origin = surface.leave(onwards);
        ++counts.rays;
        radiance += radiance_along(origin, onwards, tracer_->closest_hit(origin, onwards), {vertex.receiver(), pdf},
                                   dimensions, counts, {});
    }
    return reflected * radiance;
}

glm::vec3 PathTracer::radiance_along(glm::vec3 origin, glm::vec3 direction, Hit hit, Scattering scattering,
                                     Dimensions& dimensions, PathCounts& counts, const GatherRays& rays) const {
    const Scene& scene = tracer_->scene();
    glm::vec3 radiance(0);
    glm::vec3 throughput(1);
    for (std::uint32_t bounce = 0;;) {
        if (!hit.found()) {
            const bool from_probe = rays.cache != nullptr && bounce == 0;
            return radiance + (from_probe ? throughput * rays.cache->sky().along(direction)
                                          : sky_along(throughput, direction, scattering.pdf));
        }
        const Surface surface = tracer_->surface(hit, direction);
        const SurfacePoint point = surface_at(scene, *surface.mesh, hit.id.triangle, hit.barycentric);
        radiance +=
            emission_of(throughput, hit, surface, point, scattering.at, scattering.pdf, scattering.samples_per_ray);

        // Straight on, or reflected.
        const glm::vec3 passed = passed_share(point);
        const glm::vec3 reflected = reflected_share(point);
        if (passed != glm::vec3(0)) {
            const float pass_probability = luminance(passed) / (luminance(passed) + luminance(reflected));
            if (dimensions.next() < pass_probability) {
                throughput *= passed / pass_probability;
                ++counts.rays;
                hit = tracer_->closest_hit(origin, direction, infinity, hit);
                continue;
            }
            throughput /= 1 - pass_probability;
        }
        if (rays.cache != nullptr) {
            const glm::vec3* known = rays.cache->look_up(*tracer_, hit, origin, direction, counts);
            if (known != nullptr) return radiance + throughput * *known;
        }
        throughput *= reflected;
        if (bounce++ == rays.most_bounces) return radiance;

        const float brightest = largest(throughput);
        if (brightest < roulette_threshold) {
            const float survival = brightest / roulette_threshold;
            if (!(dimensions.next() < survival)) return radiance;
            throughput /= survival;
        }

        const Vertex vertex{surface.position, &surface, surface.front ? surface.normal : -surface.normal};
        if (use_.lights) radiance += throughput * arriving(vertex, at_lights(vertex, dimensions), counts);
        if (use_.emitters) radiance += throughput * arriving(vertex, at_emitters(vertex, dimensions), counts);
        if (use_.environment) radiance += throughput * arriving(vertex, at_environment(vertex, dimensions), counts);

        direction = cosine_direction(vertex.normal, dimensions.next2());
        origin = surface.leave(direction);
        scattering = {vertex.receiver(), vertex.pdf(direction)};
        if (!(scattering.pdf > 0)) return radiance;
        ++counts.rays;
        hit = tracer_->closest_hit(origin, direction);
    }
}

void PathTracer::gather(const Receiver& at, std::uint64_t key, std::span<const glm::vec3> even,
                        std::vector<LightSample>& out, PathCounts& counts, const GatherRays& rays) const {
    if (at.cut == nullptr) {
        const EmitterCut cut = emitters_.open(at, static_cast<std::uint32_t>(even.size()));
        return gather({at.position, {}, &cut}, key, even, out, counts, rays);
    }
    if (rays.cache != nullptr) {
        gather_cached(at, key, even, out, counts, rays);
    } else {
        gather_paths(at, key, even, out, counts, rays);
    }
}

void PathTracer::gather_paths(const Receiver& at, std::uint64_t key, std::span<const glm::vec3> even,
                              std::vector<LightSample>& out, PathCounts& counts, const GatherRays& rays) const {
    const Vertex probe{at.position, nullptr, {}, at.cut};
    const float share = 1 / static_cast<float>(even.size());
    const std::vector<glm::vec3> directions = turned(even, random_rotation(mix_bits(key, turning)));
    const std::vector<Hit> hits = closest_hits(at.position, directions, counts);
    std::vector<Aimed> aimed;
    for (std::uint32_t i = 0; i < even.size(); ++i) {
        Dimensions dimensions(key, i);
        if (use_.emitters) aim(at_emitters(probe, dimensions), share, aimed);
        if (use_.environment) aim(at_environment(probe, dimensions), share, aimed);
        const glm::vec3 radiance =
            radiance_along(at.position, directions[i], hits[i], {at, uniform_sphere_pdf}, dimensions, counts, rays);
        add({directions[i], radiance * (share / uniform_sphere_pdf)}, out, counts);
    }
    let_through(probe, aimed, out, counts);
}

void PathTracer::gather_cached(const Receiver& at, std::uint64_t key, std::span<const glm::vec3> even,
                               std::vector<LightSample>& out, PathCounts& counts, const GatherRays& rays) const {
    const SkyLight& sky = rays.cache->sky();
    const auto count = static_cast<std::uint32_t>(even.size());
    const std::uint32_t emitter_samples = std::max(1U, count / rays.rays_per_emitter_sample);
    const float emitter_samples_per_ray = static_cast<float>(emitter_samples) / static_cast<float>(count);
    gather_lights(at, key, emitter_samples, 1 / emitter_samples_per_ray, sky,
                  std::max(1U, count / rays.rays_per_sky_sample), out, counts);

    // Step by step for all rays, because what is read at random places of memory is then waited for together.
    const float share = 1 / (static_cast<float>(count) * uniform_sphere_pdf);
    const std::vector<glm::vec3> directions = turned(even, random_rotation(mix_bits(key, turning)));
    const std::vector<Hit> hits = closest_hits(at.position, directions, counts);
    std::vector<const glm::vec3*> known(count, nullptr);
    for (std::uint32_t i = 0; i < count; ++i) {
        if (!hits[i].found()) {
            known[i] = &sky.along(directions[i]);
        } else if (only_reflects(hits[i])) {
            known[i] = rays.cache->look_up(*tracer_, hits[i], at.position, directions[i], counts);
        }
    }
    out.reserve(out.size() + count);
    for (std::uint32_t i = 0; i < count; ++i) {
        if (known[i] != nullptr) {
            out.push_back({directions[i], share * *known[i]});
            continue;
        }
        Dimensions dimensions(key, i);
        const glm::vec3 radiance =
            radiance_along(at.position, directions[i], hits[i], {at, uniform_sphere_pdf, emitter_samples_per_ray},
                           dimensions, counts, rays);
        add({directions[i], share * radiance}, out, counts);
    }
}

void PathTracer::gather_lights(const Receiver& at, std::uint64_t key, std::uint32_t emitter_samples,
                               float rays_per_emitter_sample, const SkyLight& sky, std::uint32_t sky_samples,
                               std::vector<LightSample>& out, PathCounts& counts) const {
    const Vertex probe{at.position, nullptr, {}, at.cut};
    const std::uint64_t lights_key = mix_bits(key, lighting);  // so that these are stratified by themselves
    std::vector<Aimed> aimed;
    for (std::uint32_t i = 0; i < emitter_samples && use_.emitters; ++i) {
        Dimensions dimensions(lights_key, i);
        aim(at_emitters(probe, dimensions, rays_per_emitter_sample), 1 / static_cast<float>(emitter_samples), aimed);
    }
    if (use_.sky && sky.has_samples()) {
        for (const SkyLight::Sample& sample : sky.samples(lights_key, sky_samples)) {
            aim(at_sky(probe, sample), 1 / static_cast<float>(sky_samples), aimed);
        }
    }
    let_through(probe, aimed, out, counts);
}

void PathTracer::gather_punctual(glm::vec3 point, std::vector<LightSample>& out, PathCounts& counts) const {
    const std::vector<Light>& lights = tracer_->scene().lights;
    std::vector<Aimed> aimed;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        if (sources_.light(i) == LightSources::off) continue;
        const PunctualLight light = punctual_light_at(lights[i], point);
        aim({{light.direction, light.irradiance, sources_.light(i)},
             {light.direction, light.free_distance},
             punctual_light(i)},
            1, aimed);
    }
    let_through({point}, aimed, out, counts);
}

}  // namespace lightgrid
