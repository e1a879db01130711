#include "probes/unit_hint.h"

#include "core/parallel.h"
#include "core/sampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace lightgrid {
namespace {

constexpr std::size_t columns = 4096;
constexpr int most_surfaces = 256;  // of a column
/// Cosine of the slope of floors and ceilings, 2.6 degrees: hardly anything of a dome is as level.
constexpr float level = 0.999F;
/// Rooms count where as many columns go through them as this share; of single ones no level's unit is known.
constexpr double least_rooms = 0.05;
/// Of rooms, in which people can stand.
constexpr double least_height = 1.8;  // metres
struct Unit {
    const char* name;
    double metres;
};
constexpr Unit millimetre{"millimetre", 0.001};
constexpr Unit centimetre{"centimetre", 0.01};
constexpr Unit inch{"inch", 0.0254};
/// No room of a level in metres is higher. One whose unit is the largest of those is high enough to stand in, then.
constexpr double high_room = least_height / inch.metres;

/// A level in which nothing is small: there are many triangles, hardly an edge is short, and there are so many surfaces
/// above each other that it is neither terrain (1 or 2) nor a town of blocks (less than 3). Of 12 levels in metres with
/// as many triangles these edges are 0.6 mm to 0.1 m long; of a level in centimetres with 6 surfaces, 0.94 units.
constexpr std::size_t many_triangles = 5000;
constexpr double short_edges = 0.05;  // of all
constexpr double long_edge = 0.5;
constexpr double many_surfaces = 4;
constexpr double usual_height = 15;  // metres; rooms below speak for that unit
constexpr std::size_t most_edges = 1 << 18;

struct Column {
    std::vector<double> rooms;  // heights
    int surfaces = 0;
};

Column look_down(const Tracer& tracer, glm::vec3 from) {
    constexpr glm::vec3 down(0, -1, 0);
    Column column;
    std::optional<float> ceiling;  // y of the surface before, if it is one
    while (column.surfaces < most_surfaces) {
        const Hit hit = tracer.closest_hit(from, down);
        if (!hit.found()) break;
        ++column.surfaces;
        const Surface surface = tracer.surface(hit, down);
        const float y = surface.position.y;
        const bool is_level = std::abs(surface.normal.y) > level;
        if (ceiling && is_level && surface.front && *ceiling - y >= least_height) column.rooms.push_back(*ceiling - y);
        ceiling.reset();
        if (is_level && !surface.front && !tracer.scene().materials[surface.mesh->material].emits()) ceiling = y;
        from = surface.leave(down);
    }
    return column;
}

std::vector<Column> look_down(const Tracer& tracer) {
    const Scene& scene = tracer.scene();
    const glm::dvec3 size = scene.bounds.size();
    const double above = 0.01 * std::max({size.x, size.y, size.z});
    std::vector<Column> result(columns);
    for_each_index(columns, [&](std::size_t i) {
        const glm::dvec2 u(sobol_point(static_cast<std::uint32_t>(i), 0));
        const glm::dvec3 share(u.x, 1, u.y);
        result[i] =
            look_down(tracer, glm::vec3(scene.bounds.min + share * size + glm::dvec3(0, above, 0) - scene.origin));
    });
    return result;
}

/// Of half of the space in rooms; 0 where there are none.
double usual_height_of_rooms(const std::vector<Column>& all) {
    std::vector<double> heights;
    double space = 0;
    for (const Column& column : all) {
        for (const double height : column.rooms) {
            heights.push_back(height);
            space += height;
        }
    }
    std::sort(heights.begin(), heights.end());
    double below = 0;
    for (const double height : heights) {
        below += height;
        if (below >= 0.5 * space) return height;
    }
    return 0;
}

/// That only a share of short_edges is below.
double length_of_short_edges(const Scene& scene, std::size_t triangles) {
    const std::size_t stride = 1 + 3 * triangles / most_edges;
    std::vector<double> lengths;
    std::size_t passed = 0;
    const auto add = [&](const Mesh& mesh, const auto& in_level) {
        for (const glm::uvec3& triangle : mesh.triangles) {
            if (passed++ % stride != 0) continue;
            for (int i = 0; i < 3; ++i) {
                const glm::dvec3 a = in_level(mesh.positions[triangle[i]]);
                const glm::dvec3 b = in_level(mesh.positions[triangle[(i + 1) % 3]]);
                if (a != b) lengths.push_back(glm::distance(a, b));
            }
        }
    };
    for (const int mesh : scene.placed) add(scene.meshes[mesh], [](glm::vec3 p) { return glm::dvec3(p); });
    for (const Instance& instance : scene.instances) {
        for (const int mesh : scene.models[instance.model].meshes)
            add(scene.meshes[mesh], [&](glm::vec3 p) { return glm::dvec3(instance.to_level * glm::vec4(p, 1)); });
    }
    if (lengths.empty()) return 0;
    const auto at = lengths.begin() + static_cast<std::ptrdiff_t>(short_edges * static_cast<double>(lengths.size()));
    std::nth_element(lengths.begin(), at, lengths.end());
    return *at;
}

}  // namespace

std::optional<UnitHint> find_unit_hint(const Tracer& tracer) {
    if (tracer.scene().bounds.empty()) return {};
    const std::vector<Column> all = look_down(tracer);
    const double height = usual_height_of_rooms(all);
    const auto is_high = [](const Column& column) {
        return std::any_of(column.rooms.begin(), column.rooms.end(), [](double room) { return room >= high_room; });
    };
    const auto rooms = static_cast<double>(std::count_if(all.begin(), all.end(), is_high));
    if (height >= high_room && rooms >= least_rooms * columns) {
        const auto can_stand = [&](const Unit& unit) { return unit.metres * height >= least_height; };
        const Unit& unit = can_stand(millimetre) ? millimetre : can_stand(centimetre) ? centimetre : inch;
        return UnitHint{fmt::format("its rooms would be {:.0f} m high", height), unit.name, unit.metres};
    }
    double surfaces = 0;
    for (const Column& column : all) surfaces += column.surfaces;
    if (tracer.triangle_count() < many_triangles || surfaces < many_surfaces * columns ||
        (height > 0 && height < usual_height))
        return {};
    const double edge = length_of_short_edges(tracer.scene(), tracer.triangle_count());
    if (edge < long_edge) return {};
    return UnitHint{
        fmt::format("hardly one of its {} triangles would have an edge below {:.2g} m", tracer.triangle_count(), edge),
        centimetre.name, centimetre.metres};
}

}  // namespace lightgrid
