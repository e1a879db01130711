#pragma once

#include "probes/paths.h"
#include "probes/volume.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

/// Light at points, as SH and as irradiance, with standard errors from independent replicates.
namespace lightgrid {

struct GatherOptions {
    int bands = 3;
    std::uint32_t samples = 1024;   // gather rays per point, all replicates together; rounded up to whole replicates
    std::uint32_t replicates = 16;  // independent randomisations; with few, a standard error means little
    std::uint64_t seed = 0;
    /// Normals for which irradiance is integrated with the clamped cosine itself, never through SH: the same for all
    /// points, or (one_normal_each) the i-th for point i.
    std::vector<glm::vec3> normals;
    bool one_normal_each = false;
    GatherRays rays;  // paths or cache

    [[nodiscard]] std::uint32_t samples_per_replicate() const { return (samples + replicates - 1) / replicates; }
    [[nodiscard]] std::size_t normals_per_point() const { return one_normal_each ? 1 : normals.size(); }
};

/// A mean and its standard error.
struct Estimate {
    glm::dvec3 mean{0};
    glm::dvec3 error{0};
};

struct Gather {
    int bands = 0;
    std::size_t normals = 0;                // per point
    std::vector<Estimate> coefficients;     // per point bands^2: incident radiance
    std::vector<Estimate> irradiance;       // per point, per normal: lux
    std::vector<Estimate> axis_irradiance;  // per point 6: through the SH, along +x -x +y -y +z -z

    [[nodiscard]] std::span<const Estimate> sh(std::size_t point) const {
        const std::size_t n = static_cast<std::size_t>(bands) * bands;
        return std::span(coefficients).subspan(point * n, n);
    }
    /// No light was found at any point.
    [[nodiscard]] bool is_black() const noexcept;
};

/// The running sums of a gather, replicate by replicate, so that a caller can look at the result while it improves.
class GatherSums {
  public:
    /// points  relative to Scene::origin; random numbers follow from (seed, index of the point, replicate)
    GatherSums(const PathTracer& paths, std::vector<glm::vec3> points, GatherOptions options);

    /// Adds the next `count` replicates of all points, in parallel; the result does not depend on how they are divided
    /// among calls or threads. `done` is called now and then with how many points have been gathered since the start of
    /// this call (count times all points in the end), from any thread.
    void add_replicates(std::uint32_t count, const std::function<void(std::size_t)>& done = {});

    [[nodiscard]] std::uint32_t replicates() const noexcept { return replicates_; }
    [[nodiscard]] std::span<const glm::vec3> points() const noexcept { return points_; }
    [[nodiscard]] const PathCounts& counts() const noexcept { return counts_; }

    /// Mean of the replicates so far; standard errors are 0 with fewer than two.
    [[nodiscard]] Gather result() const;

  private:
    struct Moments {
        glm::dvec3 sum{0};
        glm::dvec3 squares{0};  // of deviations from the first replicate: no cancellation where all agree
        glm::dvec3 first{0};
    };

    void project(std::size_t point, std::span<const LightSample> light, std::span<glm::dvec3> values) const;
    /// As the emitters' tree is opened for a point: the same for all its replicates.
    [[nodiscard]] EmitterCut cut_at(std::size_t point) const;
    /// Light of one replicate.
    void trace(std::size_t point, std::uint32_t replicate, const EmitterCut& cut, std::span<glm::dvec3> values,
               PathCounts& counts) const;
    /// A replicate's values of a point into its moments, in the order of the replicates.
    void add(std::size_t point, std::uint32_t replicate, std::span<const glm::dvec3> values);

    const PathTracer* paths_;
    std::vector<glm::vec3> points_;
    GatherOptions options_;
    std::vector<glm::vec3> directions_;  // of a replicate's gather rays, before they are turned
    std::size_t values_per_point_;       // coefficients, then irradiances, then the six axes
    std::vector<glm::dvec3> punctual_;   // the exact part, the same in every replicate
    std::vector<Moments> moments_;
    std::uint32_t replicates_ = 0;
    PathCounts counts_;
};

/// All replicates at once.
[[nodiscard]] Gather gather(const PathTracer& paths, std::vector<glm::vec3> points, const GatherOptions& options,
                            PathCounts* counts = nullptr);

/// Light of one point into a slot: coefficients, and irradiance along the six axes. Bands that only one of them has are
/// left alone.
void store(std::span<const Estimate> coefficients, std::span<const Estimate> axis_irradiance, std::size_t slot,
           Volume& volume);
/// Light of the i-th point into the i-th of `slots`.
void store(const Gather& gather, std::span<const std::size_t> slots, Volume& volume);

}  // namespace lightgrid
