#include "tools/pictures.h"

#include "core/parallel.h"
#include "core/sampling.h"
#include "core/sh.h"
#include "tools/false_color.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace lightgrid {
namespace {

const glm::vec3 paper = hex_color(0xF4F2EE);
const glm::vec3 ink = hex_color(0x22252A);
const glm::vec3 faint_ink = hex_color(0x7B7F86);
const glm::vec3 section_fill = hex_color(0x2E3238);
constexpr int margin = 36;
constexpr int line_height = 24;

Canvas developed(const View& view, float exposure) {
    Canvas canvas(view.light.width, view.light.height, paper);
    for (std::size_t i = 0; i < canvas.pixels.size(); ++i) {
        canvas.pixels[i] = glm::mix(tone_map(view.light.pixels[i], exposure), section_fill, view.section[i]);
    }
    return canvas;
}

// ---- slices ---------------------------------------------------------------------------------------------------------

struct SlicePixel {
    float lux = 0;
    bool solid = false;
    SurfaceId behind;  // what is seen beyond the plane, for outlines
    glm::vec3 normal{0};
};

std::vector<SlicePixel> sample_slice(const LitLevel& level, const Slice& slice) {
    const glm::ivec2 size = slice.size();
    std::vector<SlicePixel> pixels(static_cast<std::size_t>(size.x) * size.y);
    glm::vec3 away(0);
    away[slice.axis] = -1;
    for_each_index(static_cast<std::size_t>(size.y), [&](std::size_t y) {
        for (int x = 0; x < size.x; ++x) {
            SlicePixel& pixel = pixels[y * size.x + x];
            const glm::dvec3 point = slice.point({x + 0.5, static_cast<double>(y) + 0.5});
            pixel.solid = looks_solid(*level.tracer, point);
            if (pixel.solid) continue;
            pixel.lux = std::max(luminance(mean_irradiance(*level.sampler, point)), 0.0F);
            const Hit hit = level.tracer->closest_hit(glm::vec3(point - level.tracer->scene().origin), away);
            pixel.behind = hit.id;
            pixel.behind.triangle = 0;
            if (hit.found()) pixel.normal = level.tracer->surface(hit, away).normal;
        }
    });
    return pixels;
}

LogScale scale_for(const std::vector<std::vector<SlicePixel>>& slices) {
    std::vector<float> values;
    for (const std::vector<SlicePixel>& pixels : slices) {
        for (const SlicePixel& pixel : pixels) {
            if (!pixel.solid) values.push_back(pixel.lux);
        }
    }
    return scale_of(std::move(values));
}

Canvas color_slice(const Slice& slice, const std::vector<SlicePixel>& pixels, const LogScale& scale) {
    const glm::ivec2 size = slice.size();
    Canvas canvas(size.x, size.y, section_fill);
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
            const SlicePixel& pixel = pixels[static_cast<std::size_t>(y) * size.x + x];
            if (pixel.solid) continue;
            glm::vec3 color = false_color(static_cast<float>(scale.place(pixel.lux)));
            for (const glm::ivec2 step : {glm::ivec2(1, 0), glm::ivec2(0, 1)}) {
                if (x + step.x >= size.x || y + step.y >= size.y) continue;
                const SlicePixel& next = pixels[static_cast<std::size_t>(y + step.y) * size.x + x + step.x];
                if (next.solid) continue;
                const bool contour = pixel.lux > 0 && next.lux > 0 && mark_below(pixel.lux) != mark_below(next.lux);
                const bool outline = next.behind != pixel.behind || glm::dot(next.normal, pixel.normal) < 0.7F;
                if (contour) color = glm::mix(color, paper, 0.55F);
                if (outline) color = glm::mix(color, ink, 0.35F);
            }
            canvas.at(x, y) = color;
        }
    }
    return canvas;
}

/// One metre, or a power of ten of it that suits the width.
void draw_metre(Canvas& canvas, glm::ivec2 corner, double pixels_per_metre, int width) {
    const double length = std::pow(10.0, std::floor(std::log10(0.4 * width / pixels_per_metre)));
    const int pixels = static_cast<int>(std::lround(length * pixels_per_metre));
    canvas.fill(corner, {pixels, 3}, ink);
    canvas.fill(corner - glm::ivec2(0, 4), {1, 11}, ink);
    canvas.fill(corner + glm::ivec2(pixels, -4), {1, 11}, ink);
    canvas.text(corner + glm::ivec2(pixels + 10, -4), fmt::format("{} m", length), ink);
}

// ---- probes --------------------------------------------------------------------------------------------------------

/// Lattice places of the plane of probes nearest to `at` across `axis`: slots, and where the plane is.
struct LatticePlane {
    double position = 0;
    std::vector<std::size_t> slots;
};

LatticePlane nearest_plane(const Volume& volume, int axis, double at) {
    const auto place = [&](std::size_t slot) { return lattice_position(volume, slot)[axis]; };
    LatticePlane plane;
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        const double distance = std::abs(place(slot) - at);
        if (distance < best) {
            best = distance;
            plane.position = place(slot);
        }
    }
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] != ProbeState::absent && place(slot) == plane.position) plane.slots.push_back(slot);
    }
    return plane;
}

/// Spheres under the light of their probes, hidden by what is nearer in `view`.
void draw_spheres(Canvas& canvas, const View& view, const Camera& camera, const Volume& volume,
                  const LatticePlane& plane, float radius, float exposure) {
    const double to_pixels = 0.5 * canvas.width;
    std::vector<float> depth = view.depth;
    for (const std::size_t slot : plane.slots) {
        const glm::dvec3 center = gather_position(volume, slot);
        const glm::dvec3 seen = camera.project(center);
        const glm::dvec2 middle(to_pixels + seen.x * to_pixels, 0.5 * canvas.height - seen.y * to_pixels);
        const double pixels = radius / (camera.half_width * (camera.orthographic ? 1 : seen.z)) * to_pixels;
        const glm::vec3 ring = state_color(volume.states[slot]);
        const int reach = static_cast<int>(std::ceil(pixels)) + 1;
        for (int dy = -reach; dy <= reach; ++dy) {
            for (int dx = -reach; dx <= reach; ++dx) {
                const glm::ivec2 at = glm::ivec2(glm::floor(middle)) + glm::ivec2(dx, dy);
                if (at.x < 0 || at.y < 0 || at.x >= canvas.width || at.y >= canvas.height) continue;
                const glm::dvec2 offset = (glm::dvec2(at) + 0.5 - middle) / pixels;  // in radii
                const double from_center = glm::length(offset);
                const auto cover = static_cast<float>(glm::clamp((1 - from_center) * pixels + 0.5, 0.0, 1.0));
                if (cover <= 0) continue;
                const double bulge = std::sqrt(std::max(0.0, 1 - from_center * from_center));
                const auto near = static_cast<float>(seen.z - radius * bulge);
                float& nearest = depth[static_cast<std::size_t>(at.y) * canvas.width + at.x];
                if (near > nearest) continue;
                const glm::dvec3 normal =
                    glm::normalize(offset.x * camera.right - offset.y * camera.up - bulge * camera.forward);
                const glm::vec3 irradiance = glm::max(irradiance_from_sh(volume.sh(slot), glm::vec3(normal)), 0.0F);
                const glm::vec3 lit = tone_map(0.8F * irradiance * std::numbers::inv_pi_v<float>, exposure);
                const auto in_ring = static_cast<float>(glm::clamp((from_center - 0.8) * pixels + 0.5, 0.0, 1.0));
                canvas.blend(at.x, at.y, glm::mix(lit, ring, in_ring), cover);
                if (cover > 0.5F) nearest = near;
            }
        }
    }
}

}  // namespace

glm::ivec2 Slice::size() const {
    return glm::ivec2(glm::round(scale * glm::dvec2(box.size()[right()], box.size()[up()])));
}

glm::dvec3 Slice::point(glm::dvec2 pixel) const {
    const glm::dvec2 at = pixel / scale;
    glm::dvec3 p(0);
    p[axis] = position;
    p[right()] = axis == 0 ? box.max[2] - at.x : box.min[0] + at.x;
    p[up()] = axis == 1 ? box.min[2] + at.y : box.max[1] - at.y;
    return p;
}

glm::dvec2 Slice::pixel(glm::dvec3 point) const {
    const double x = axis == 0 ? box.max[2] - point.z : point.x - box.min[0];
    const double y = axis == 1 ? point.z - box.min[2] : box.max[1] - point.y;
    return scale * glm::dvec2(x, y);
}

std::string Slice::title() const {
    return fmt::format("{} at {} = {:.2f}", axis == 1 ? "Plan" : "Section", "xyz"[axis], position);
}

SlicePictures picture_slices(const LitLevel& level, const Volume& volume, glm::dvec3 at, double scale) {
    SlicePictures result;
    std::vector<std::vector<SlicePixel>> pixels;
    for (const int axis : {1, 2, 0}) {
        const Slice slice{axis, at[axis], bounds_of(volume), scale};
        if (slice.size().x < 1 || slice.size().y < 1) continue;
        result.slices.push_back(slice);
        pixels.push_back(sample_slice(level, slice));
    }
    result.lux = scale_for(pixels);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        result.pictures.push_back(color_slice(result.slices[i], pixels[i], result.lux));
    }
    return result;
}

Box bounds_of(const Volume& volume) {
    Box box;
    for (const Grid& grid : volume.grids) {
        box.extend(grid.origin);
        box.extend(grid.position(grid.counts - 1));
    }
    return box;
}

double finest_spacing(const Volume& volume) {
    double spacing = std::numeric_limits<double>::infinity();
    for (const Grid& grid : volume.grids) {
        spacing = std::min({spacing, grid.spacing.x, grid.spacing.y, grid.spacing.z});
    }
    return spacing;
}

Canvas draw_view(const LitLevel& level, const Camera& camera, const PictureOptions& options) {
    const View view = render(level, camera, {options.width, options.width * 9 / 16}, 3);
    return developed(view, options.exposure.value_or(automatic_exposure(view.light)));
}

Canvas draw_slices(const LitLevel& level, const Volume& volume, const PictureOptions& options) {
    constexpr int legend = 120;
    const Box box = bounds_of(volume);
    const double scale = (options.width - 2 * margin - legend) / std::max(box.size().x, box.size().z);
    const SlicePictures slices = picture_slices(level, volume, options.at, scale);

    int height = 2 * margin + 2 * line_height;
    for (const Canvas& picture : slices.pictures) height += picture.height + 2 * line_height;
    Canvas canvas(options.width, height, paper);
    glm::ivec2 corner(margin, margin);
    canvas.text(corner, "Irradiance in the volume, mean over all directions", ink, 17);
    corner.y += 2 * line_height;
    const glm::ivec2 bar(options.width - margin - legend + 30, corner.y + 2 * line_height);
    for (std::size_t i = 0; i < slices.pictures.size(); ++i) {
        canvas.text(corner, slices.slices[i].title(), faint_ink);
        canvas.paste(slices.pictures[i], corner + glm::ivec2(0, line_height));
        corner.y += slices.pictures[i].height + 2 * line_height;
    }
    if (!slices.pictures.empty())
        draw_legend(canvas, bar, slices.pictures[0].height - line_height, slices.lux, "lux", ink);
    draw_metre(canvas, {margin, corner.y + 4}, scale / level.tracer->scene().metres_per_unit, options.width);
    return canvas;
}

Canvas draw_probes(const LitLevel& level, const Volume& volume, const PictureOptions& options) {
    const Box box = bounds_of(volume);
    const float radius = static_cast<float>(0.2 * finest_spacing(volume));
    const int width = options.width - 2 * margin;
    const LatticePlane plan = nearest_plane(volume, 1, options.at.y);
    const LatticePlane front = nearest_plane(volume, 2, options.at.z);

    // From above and a little from the south.
    Box below = box;
    below.max.y = plan.position;
    const glm::ivec2 plan_size(width, width * 5 / 8);
    Camera above = Camera::around(below, {0, -1, -0.42}, 30, 1.6);
    above.cut = Cut{{0, 1, 0}, plan.position};

    Camera south;
    south.orthographic = true;
    south.half_width = 0.52 * box.size().x;
    south.eye = {box.center().x, box.center().y, box.max.z + box.size().z};
    south.cut = Cut{{0, 0, 1}, front.position};
    const glm::ivec2 front_size(width,
                                static_cast<int>(std::lround(width * 1.06 * box.size().y / (1.04 * box.size().x))));

    const View plan_view = render(level, above, plan_size, 3);
    const View front_view = render(level, south, front_size, 3);
    const float exposure = options.exposure.value_or(automatic_exposure(front_view.light));

    Canvas canvas(options.width, 2 * margin + plan_size.y + front_size.y + 7 * line_height, paper);
    glm::ivec2 corner(margin, margin);
    canvas.text(corner, "Probes under their own light", ink, 17);
    corner.y += 2 * line_height;
    const auto draw = [&](const std::string& title, const View& view, const Camera& camera, const LatticePlane& plane) {
        canvas.text(corner, title, faint_ink);
        corner.y += line_height;
        Canvas picture = developed(view, exposure);
        draw_spheres(picture, view, camera, volume, plane, radius, exposure);
        canvas.paste(picture, corner);
        corner.y += picture.height + line_height / 2;
    };
    draw(fmt::format("Layer at y = {:.2f}", plan.position), plan_view, above, plan);
    draw(fmt::format("Layer at z = {:.2f}", front.position), front_view, south, front);

    corner.y += line_height / 2;
    constexpr std::array<std::pair<ProbeState, const char*>, 4> keys{
        {{ProbeState::valid, "valid"},
         {ProbeState::filled, "inside a solid, filled from neighbours"},
         {ProbeState::moved, "moved out of a solid"},
         {ProbeState::missing, "no light known"}}};
    for (std::size_t i = 0; i < keys.size(); ++i) {
        const glm::ivec2 at = corner + glm::ivec2(i / 2 * 330, i % 2 * line_height);
        canvas.disc(glm::vec2(at) + glm::vec2(8, 6), 6, paper, state_color(keys[i].first), 3);
        canvas.text(at + glm::ivec2(24, 0), keys[i].second, ink);
    }
    return canvas;
}

}  // namespace lightgrid
