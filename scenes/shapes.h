#pragma once

#include "scenes/glb.h"

#include <glm/glm.hpp>

#include <span>
#include <vector>

/// Shapes of metres, +Y up, whose front sides (counter-clockwise) look outward. Everything but quads and leaves is
/// closed.
namespace lightgrid::scenes {

/// The parallelogram corner, corner + right, corner + right + up, corner + up; its front looks along right x up.
/// Texture coordinates run from (0, 0) at its upper left to the lengths of its sides.
void add_quad(Shape& shape, int material, glm::vec3 corner, glm::vec3 right, glm::vec3 up);

void add_box(Shape& shape, int material, glm::vec3 low, glm::vec3 high);

/// A box whose edges and corners are rounded by `radius`, at most half its smallest side.
void add_rounded_box(Shape& shape, int material, glm::vec3 low, glm::vec3 high, float radius);

/// Turns a profile of (radius, height) about +Y. The profile is followed with the solid on its left, so upwards on the
/// outside; closed where it starts and ends at radius 0. Corners of less than 45 degrees are shaded smoothly.
void add_lathe(Shape& shape, int material, std::span<const glm::vec2> profile, int segments);

/// A strip along a polyline: a leaf that bends. Two-sided by nature, not closed.
/// across  half the width, at right angles to the spine
void add_strip(Shape& shape, int material, std::span<const glm::vec3> spine, glm::vec3 across);

/// Adds `other`, moved.
void append(Shape& shape, const Shape& other, const glm::mat4& transform);

/// What a room's faces are made of.
struct Paint {
    int floor = 0;    // faces that look up
    int wall = 0;     // sideways
    int ceiling = 0;  // down
};

/// A solid made of axis-aligned boxes, some filled, some carved out again, in order. Its surface is closed, has no
/// inner faces and no T-junctions: no ray slips into a wall.
class Blocks {
  public:
    explicit Blocks(Paint outside) : outside_(outside) {}

    void fill(glm::vec3 low, glm::vec3 high);
    /// Faces that look into the box get its paint.
    void carve(glm::vec3 low, glm::vec3 high, Paint paint);

    void add_to(Shape& shape) const;

  private:
    struct Step {
        glm::vec3 low;
        glm::vec3 high;
        bool solid;
        Paint paint;
    };
    Paint outside_;
    std::vector<Step> steps_;
};

}  // namespace lightgrid::scenes
