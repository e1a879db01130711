#pragma once

#include "probes/light_sources.h"
#include "probes/placement.h"
#include "probes/surface_cache.h"
#include "probes/volume.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

/// What of a bake depends on geometry and albedo alone, kept so that other lights are solved for without tracing it
/// again: how light goes from patch to patch, and from patches to probes. And what each source of light brought
/// straight to both, which is in proportion to its intensity.
namespace lightgrid {

struct BakeOptions;
struct BakePlan;

/// Where a gather ray went besides the one place that KeptGather::landed has room for.
struct RayEnd {
    std::uint32_t ray = 0;  // of the replicate
    std::uint32_t at = 0;   // patch, Transport::sky, or RayEnd::emitter + source
    glm::vec3 share{0};     // of the light there; of an emitter: its radiance, weighted
    static constexpr std::uint32_t emitter = 0x80000000U;
};

/// A mean and its standard error.
struct KeptEstimate {
    glm::vec3 mean{0};
    glm::vec3 error{0};
};

/// The gather of a batch of probes.
struct KeptGather {
    std::vector<std::uint64_t> slots;
    std::uint32_t rays = 0;                // of a replicate
    std::uint64_t seed = 0;                // directions follow from it
    std::vector<std::uint32_t> landed;     // by point, replicate and ray: patch, Transport::none, or Transport::sky
    std::vector<RayEnd> ends;              // by point and replicate
    std::vector<std::uint64_t> first_end;  // by point and replicate, and the end
    /// What samples aimed at a source brought: by source, point, and value: bands^2 coefficients, then the irradiance
    /// of these along the six axes. Their noise is independent of that of the rays, and of other sources'.
    std::vector<std::vector<KeptEstimate>> aimed;
};

struct KeptTransport {
    std::uint64_t fingerprint = 0;  // of what must be the same: level but for its lights, options, version
    LightState light;               // that it was traced in
    CacheOptions options;
    Transport transport;
    std::vector<PatchPlace> places;
    std::vector<std::vector<glm::vec3>> direct;  // E, by source and patch
    CacheMade made;
    std::vector<KeptGather> gathers;

    // The plan that it was made for.
    Volume volume;  // places and states
    std::uint32_t samples = 0;
    PlacementCounts placement;
    std::string why_spacing;
    std::string why_samples;
};

/// A number for all that a bake with other lights must have in common with this: the level but for what shines in it,
/// the options, and the version of the program.
[[nodiscard]] std::uint64_t transport_fingerprint(const Scene& scene, const BakeOptions& options,
                                                  const std::string& version);

/// Traces the transport of a plan's probes, and the light of the sources of `paths` apart.
///
/// surfaces  of the plan's points, found with `options`; what gathers meet besides is added to them
/// done      called with how many points have been gathered so far, from any thread, one at a time
[[nodiscard]] KeptTransport trace_transport(const PathTracer& paths, const BakePlan& plan, Surfaces surfaces,
                                            const CacheOptions& options, std::uint64_t seed, PathCounts& counts,
                                            const std::function<void(std::size_t)>& done = {});

/// The light of a level's lights as they are now.
struct KeptLight {
    std::vector<glm::vec3> radiance;  // that patches reflect
    bool traced = false;              // light that is new or has moved: shadow rays
    CacheMade made;                   // counts: of those
};

/// Solves for it and stores it at the probes of a volume that has the places of kept.volume. Without new light no ray
/// is traced; unchanged light gives the same bits again.
KeptLight light_probes(const KeptTransport& kept, const Tracer& tracer, const Environment& environment, Volume& volume);

/// Where probes may stand depends on whether there is a sky: transport that was kept without one is not for light with
/// one.
[[nodiscard]] bool has_places_for(const KeptTransport& kept, const Environment& environment) noexcept;

/// A plan that does what was done when transport was traced.
[[nodiscard]] BakePlan plan_of(const KeptTransport& kept, const Scene& scene);

/// Whole or not at all. Throws Error (Fault::work) when the disk refuses.
void save_transport(const KeptTransport& kept, const std::filesystem::path& path);

/// None where the file holds the transport of something else. Throws Error where it holds no transport, or is damaged.
[[nodiscard]] std::optional<KeptTransport> load_transport(const std::filesystem::path& path, std::uint64_t fingerprint);

}  // namespace lightgrid
