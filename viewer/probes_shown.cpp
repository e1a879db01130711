#include "viewer/probes_shown.h"

#include "tools/false_color.h"

#include <algorithm>
#include <cmath>

namespace lightgrid {
namespace {

constexpr double probe_radius = 0.12;  // spacings
/// Of the ball of a probe that answers alone: one of eight equal ones is half as large.
constexpr double heaviest_radius = 0.2;
constexpr glm::vec3 edge_color(0.95F);

Ball ball_of(const Volume& volume, std::size_t slot, glm::dvec3 origin, double radius) {
    Ball ball;
    ball.center = glm::vec3(gather_position(volume, slot) - origin);
    ball.radius = static_cast<float>(radius);
    ball.rim = state_color(volume.states[slot]);
    const std::span<const glm::vec3> sh = volume.sh(slot);
    std::copy_n(sh.begin(), std::min(sh.size(), ball.radiance.size()), ball.radiance.begin());
    return ball;
}

/// The twelve edges of the cell of a grid that a position is in, or that is nearest to it.
void add_edges(std::vector<LineEnd>& lines, const Grid& grid, glm::dvec3 position, glm::dvec3 origin) {
    const glm::dvec3 at = glm::floor((position - grid.origin) / grid.spacing);
    const glm::ivec3 lower = glm::ivec3(glm::clamp(at, glm::dvec3(0), glm::dvec3(glm::max(grid.counts - 2, 0))));
    const auto corner = [&](int i) {
        const glm::ivec3 upper(i & 1, (i >> 1) & 1, i >> 2);
        return LineEnd{glm::vec3(grid.position(glm::min(lower + upper, grid.counts - 1)) - origin), edge_color};
    };
    for (int i = 0; i < 8; ++i) {
        for (const int axis : {1, 2, 4}) {
            if ((i & axis) == 0) lines.insert(lines.end(), {corner(i), corner(i | axis)});
        }
    }
}

}  // namespace

std::vector<Ball> probe_balls(const LitVolume& lit, glm::dvec3 origin) {
    std::vector<Ball> balls;
    for (std::size_t slot = 0; slot < lit.volume.slots(); ++slot) {
        if (lit.volume.states[slot] == ProbeState::absent) continue;
        balls.push_back(ball_of(lit.volume, slot, origin, probe_radius * lit.spacing));
    }
    return balls;
}

ShownCell cell_shown(const LookUp& from, glm::dvec3 position, glm::dvec3 origin) {
    const Volume& volume = from.volume->volume;
    const Sampler::Corners corners = corners_of(from, position);
    ShownCell cell;
    if (corners.count == 0) return cell;
    const int answering = volume.bricks[corners.slots[0] / probes_per_brick].grid;
    const Grid& grid = volume.grids[static_cast<std::size_t>(answering)];
    add_edges(cell.lines, grid, position, origin);
    const double spacing = std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
    for (int c = 0; c < corners.count; ++c) {
        const auto i = static_cast<std::size_t>(c);
        const double radius = heaviest_radius * spacing * std::cbrt(static_cast<double>(corners.weights[i]));
        const Ball ball = ball_of(volume, corners.slots[i], origin, radius);
        cell.lines.insert(cell.lines.end(), {{glm::vec3(position - origin), ball.rim}, {ball.center, ball.rim}});
        cell.balls.push_back(ball);
    }
    return cell;
}

}  // namespace lightgrid
