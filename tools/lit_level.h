#pragma once

#include "core/environment.h"
#include "core/image.h"
#include "core/tracer.h"
#include "probes/sampler.h"

#include <glm/glm.hpp>

#include <optional>
#include <vector>

/// Pictures of a level as its volume lights it: emission + albedo E(n) / pi, with E from the Sampler and nothing else.
/// What a dynamic object gets, seen on the level itself.
namespace lightgrid {

struct LitLevel {
    const Tracer* tracer;
    const Sampler* sampler;
    const Environment* environment;
    SampleOptions look_up;
};

/// Everything on the side of the plane that `normal` points to is cut away: dot(normal, p) > offset, level coordinates.
struct Cut {
    glm::dvec3 normal{0, 1, 0};
    double offset = 0;
};

struct Camera {
    glm::dvec3 eye{0};
    glm::dvec3 right{1, 0, 0};  // unit vectors; the picture's width and height run along right and -up
    glm::dvec3 up{0, 1, 0};
    glm::dvec3 forward{0, 0, -1};
    double half_width = 1;  // perspective: tangent of half the horizontal angle; orthographic: metres
    bool orthographic = false;
    std::optional<Cut> cut;

    [[nodiscard]] static Camera looking_at(glm::dvec3 eye, glm::dvec3 target, double horizontal_angle_deg);
    /// Looks along `direction` (towards it, horizontally centred) from as far as shows all of `box`.
    [[nodiscard]] static Camera around(const Box& box, glm::dvec3 direction, double horizontal_angle_deg,
                                       double aspect);

    struct Ray {
        glm::dvec3 origin;
        glm::dvec3 direction;  // unit length
    };
    /// Through a point of the picture; x in [-1, 1] to the right, y upwards in the same unit.
    [[nodiscard]] Ray ray(glm::dvec2 at) const;
    /// Where a point appears, in the same unit, and its distance along `forward`.
    [[nodiscard]] glm::dvec3 project(glm::dvec3 position) const;
};

/// A rendered picture, row-major, top row first.
struct View {
    RadianceImage light;         // cd/m^2
    std::vector<float> section;  // share of the pixel where the cut goes through a solid
    std::vector<float> depth;    // along forward to what is seen at the pixel's centre, metres; infinite: nothing
};

/// samples  along each side of a pixel
[[nodiscard]] View render(const LitLevel& level, const Camera& camera, glm::ivec2 size, int samples);

/// Scalar irradiance over four: the mean of E over all normals, lux. Black where no light is known.
[[nodiscard]] glm::vec3 mean_irradiance(const Sampler& sampler, glm::dvec3 position);

/// A point that sees back faces along four or more of the six axes. Good for drawing, no proof.
[[nodiscard]] bool looks_solid(const Tracer& tracer, glm::dvec3 position);

/// 0.16 over the geometric mean of the luminance: puts what is seen in the middle of the display's range.
[[nodiscard]] float automatic_exposure(const RadianceImage& light);

/// Linear radiance to sRGB in [0, 1], highlights rolled off as film does (fit by Narkowicz 2015 to ACES).
[[nodiscard]] glm::vec3 tone_map(glm::vec3 radiance, float exposure);

}  // namespace lightgrid
