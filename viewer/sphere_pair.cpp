#include "viewer/sphere_pair.h"

#include <glm/gtc/matrix_transform.hpp>

namespace lightgrid {

SpherePair::SpherePair(const Gl& gl, const ShaderSources& shaders)
    : gl_(gl), target_(gl, shaders), sphere_(gl, shaders, make_sphere()) {}

void SpherePair::draw(const Sh36& left, const Sh36& right, const Pose& pose, float exposure, Tone tone) {
    target_.resize(size, 4);
    target_.begin();
    Eye eye;
    eye.exposure = exposure;
    const double half = 0.54;  // a sphere of diameter 1, and a margin
    const glm::dmat4 view = glm::lookAt(-forward(pose), glm::dvec3(0), glm::dvec3(0, 1, 0));
    eye.clip_from_level = glm::mat4(glm::ortho(-half, half, -half, half, 0.1, 2.0) * view);
    gl_.Viewport(0, 0, size.y, size.y);
    sphere_.draw(eye, {}, {.radiance = left});
    gl_.Viewport(size.x - size.y, 0, size.y, size.y);
    sphere_.draw(eye, {}, {.radiance = right});
    target_.resolve();
    target_.develop({{0, 0}, size}, tone);
    check_gl(gl_, "drawing two spheres");
}

}  // namespace lightgrid
