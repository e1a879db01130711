#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

/// How light goes from patch to patch, sparse: the equation that reflected light solves.
namespace lightgrid {

struct TransportSolution {
    std::vector<glm::dvec3> light;  // by patch
    double residual = 0;            // of (I - T) B = E, relative (linear_solver.h)
    int sweeps = 0;
};

/// B = E + T B over patches. B: the mean radiance that a patch's samples reflect, E: what of it came straight from
/// emitters, sky and lights. A row of T is the mean over the patch's samples of albedo / rays times the rays that
/// landed on each patch: geometry and albedo alone decide it.
struct Transport {
    static constexpr std::uint32_t none = 0xffffffffU;  // it is black there, or not known
    static constexpr std::uint32_t sky = 0xfffffffeU;   // left the level

    /// A ray that passed tinted or blended surfaces, or went on behind one that reflects as well.
    struct PassedRay {
        std::uint32_t from = 0;   // sample
        std::uint32_t ray = 0;    // of the sample
        std::uint32_t patch = 0;  // where it landed, or sky
        glm::vec3 share{0};
    };

    std::uint32_t rays = 0;                   // of each sample
    std::vector<std::uint32_t> first_sample;  // by patch, and the end: samples of a patch lie together
    std::vector<glm::vec3> weights;           // by sample: albedo / (rays that count * samples of its patch)
    std::vector<std::uint32_t> landed;        // by sample and ray: patch, none, or sky
    std::vector<PassedRay> passed;            // in the order of samples

    [[nodiscard]] std::size_t patches() const noexcept { return first_sample.empty() ? 0 : first_sample.size() - 1; }
};

/// light + T light
void add_transported(const Transport& transport, std::span<const glm::dvec3> light, std::span<glm::dvec3> sum);

/// All bounces at once. An error of the result is at most the error of one bounce / (1 - largest albedo), so that is
/// how much smaller than `accuracy` the residual is made.
///
/// direct  E, by patch
[[nodiscard]] TransportSolution solve(const Transport& transport, std::span<const glm::dvec3> direct, double accuracy);

}  // namespace lightgrid
