#pragma once

#include "probes/gather.h"
#include "viewer/background_answer.h"
#include "viewer/look_up.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace lightgrid {

/// What the path tracer says of the light at a point.
struct ReferenceLight {
    glm::dvec3 position{0};
    glm::vec3 normal{0, 1, 0};
    Estimate irradiance;        // on a surface facing `normal`, lux: integrated with the cosine, not through SH
    std::vector<Estimate> sh;   // of incident radiance
    std::uint32_t samples = 0;  // gather rays so far
    bool last = false;          // no better one will follow
};

/// Traces the light at one point at a time beside the frame loop; the answer improves while it works.
class ReferenceProbe {
  public:
    static constexpr std::uint32_t samples_per_replicate = 256;
    static constexpr std::uint32_t first_replicates = 16;   // a standard error from fewer means little
    static constexpr std::uint32_t most_replicates = 1024;  // 262,144 rays

    /// Keeps a reference to `paths`, which must outlive this.
    explicit ReferenceProbe(const PathTracer& paths, int bands = 3);

    /// Asks for the light at a point; see BackgroundAnswer.
    ///
    /// position  level coordinates, in front of any surface
    /// normal    unit length
    void ask(glm::dvec3 position, glm::vec3 normal) { answer_.ask({position, normal}); }
    /// The best answer yet.
    [[nodiscard]] std::optional<ReferenceLight> take() { return answer_.take(); }

  private:
    struct Question {
        glm::dvec3 position{0};
        glm::vec3 normal{0};
    };
    using Answer = BackgroundAnswer<Question, ReferenceLight>;
    static void trace(const PathTracer& paths, int bands, const Question& question, const Answer::Turn& turn);

    Answer answer_;
};

/// Their means; coefficients that are not there are zero.
[[nodiscard]] Sh36 means(std::span<const Estimate> coefficients);

/// A volume's irradiance beside the reference's.
struct LightComparison {
    glm::vec3 volume{0};           // lux
    glm::vec3 reference{0};        // lux
    glm::vec3 reference_error{0};  // its standard error, lux
    float relative = 0;            // luminance of the volume's over that of the reference, less 1; 0 where both are 0
};
/// volume  irradiance that a volume has for the reference's place and normal, lux
[[nodiscard]] LightComparison compare(const ReferenceLight& reference, glm::vec3 volume);

}  // namespace lightgrid
