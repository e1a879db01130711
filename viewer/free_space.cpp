#include "viewer/free_space.h"

#include "core/parallel.h"
#include "tools/ground.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace lightgrid {
namespace {

/// Of the lattice; as many as rays can look around in a second.
constexpr double most_points = 40'000;

const std::array<glm::ivec3, 26>& neighbours() {
    static const std::array<glm::ivec3, 26> steps = [] {
        std::array<glm::ivec3, 26> all{};
        std::size_t count = 0;
        for (int i = 0; i < 27; ++i) {
            const glm::ivec3 step = glm::ivec3(i % 3, i / 3 % 3, i / 9) - 1;
            if (step != glm::ivec3(0)) all[count++] = step;
        }
        return all;
    }();
    return steps;
}

struct Lattice {
    glm::dvec3 first{0};  // relative to Scene::origin
    double spacing = 1;
    glm::ivec3 counts{1};

    [[nodiscard]] std::size_t size() const {
        return static_cast<std::size_t>(counts.x) * static_cast<std::size_t>(counts.y) *
               static_cast<std::size_t>(counts.z);
    }
    [[nodiscard]] bool holds(glm::ivec3 at) const {
        return glm::all(glm::greaterThanEqual(at, glm::ivec3(0))) && glm::all(glm::lessThan(at, counts));
    }
    [[nodiscard]] std::size_t index(glm::ivec3 at) const {
        return (static_cast<std::size_t>(at.z) * counts.y + at.y) * counts.x + at.x;
    }
    [[nodiscard]] glm::ivec3 at(std::size_t index) const {
        const auto i = static_cast<int>(index);
        return {i % counts.x, i / counts.x % counts.y, i / (counts.x * counts.y)};
    }
    [[nodiscard]] glm::vec3 position(std::size_t index) const {
        return glm::vec3(first + spacing * glm::dvec3(at(index)));
    }
};

Lattice lattice_over(const Volume& volume, glm::dvec3 origin) {
    Box box;
    double finest = std::numeric_limits<double>::infinity();
    for (const Grid& grid : volume.grids) {
        box.extend(grid.origin - origin);
        box.extend(grid.position(grid.counts - 1) - origin);
        for (int axis = 0; axis < 3; ++axis) {
            if (grid.counts[axis] > 1) finest = std::min(finest, grid.spacing[axis]);
        }
    }
    Lattice lattice;
    if (box.empty()) return lattice;
    const glm::dvec3 size = glm::max(box.size(), glm::dvec3(1e-6 * glm::length(box.size())));
    lattice.spacing = std::min(finest, std::cbrt(size.x * size.y * size.z / most_points));
    // What is flat or long has more points than its volume says.
    const auto counts = [&] { return glm::dvec3(glm::floor(size / lattice.spacing)) + 1.0; };
    while (counts().x * counts().y * counts().z > most_points) lattice.spacing *= 1.1;
    lattice.counts = glm::ivec3(counts());
    lattice.first = box.min + 0.5 * (size - lattice.spacing * glm::dvec3(lattice.counts - 1));
    return lattice;
}

/// Lattice points next to a valid probe that it sees.
std::vector<std::size_t> seen_by_probes(const Tracer& tracer, const Volume& volume, const Lattice& lattice) {
    std::vector<std::size_t> seen;
    for (std::size_t slot = 0; slot < volume.list_start(); ++slot) {
        if (!is_valid(volume.states[slot])) continue;
        const glm::dvec3 probe = gather_position(volume, slot) - tracer.scene().origin;
        const glm::ivec3 lower(glm::floor((probe - lattice.first) / lattice.spacing));
        for (int corner = 0; corner < 8; ++corner) {
            const glm::ivec3 at = lower + glm::ivec3(corner & 1, corner / 2 & 1, corner / 4);
            if (!lattice.holds(at)) continue;
            if (is_clear(tracer, glm::vec3(probe), lattice.position(lattice.index(at))))
                seen.push_back(lattice.index(at));
        }
    }
    return seen;
}

}  // namespace

bool is_clear(const Tracer& tracer, glm::vec3 a, glm::vec3 b) {
    return a == b || !tracer.closest_hit(a, b - a, 1).found();
}

float clearance_at(const Tracer& tracer, glm::vec3 point, float most) {
    float nearest = most;
    for (const glm::ivec3& step : neighbours()) {
        const Hit hit = tracer.closest_hit(point, glm::normalize(glm::vec3(step)), nearest);
        if (hit.found()) nearest = std::min(nearest, hit.distance);
    }
    return nearest;
}

namespace {

/// Free space without ground below is left out where at least this share of it has some: below and beside a level, and
/// over its edges, nobody is. In a level of things that float in the void all of it stays.
constexpr double enough_ground = 0.02;

/// What is round each point of a lattice.
struct Survey {
    std::vector<float> clearance;     // 0: not to be flown through
    std::vector<std::uint32_t> open;  // bit k: the line to neighbour k is clear
};

void leave_out_groundless(const Tracer& tracer, const Lattice& lattice, float wanted, std::vector<float>& clearance) {
    std::vector<char> has_ground(lattice.size());
    for_each_index(lattice.size(), [&](std::size_t i) {
        has_ground[i] = clearance[i] >= wanted && height_above_ground(tracer, lattice.position(i)) ? 1 : 0;
    });
    const auto with = static_cast<double>(std::count(has_ground.begin(), has_ground.end(), 1));
    const auto all =
        static_cast<double>(std::count_if(clearance.begin(), clearance.end(), [&](float c) { return c >= wanted; }));
    if (with < enough_ground * all) return;
    for (std::size_t i = 0; i < lattice.size(); ++i) {
        if (has_ground[i] == 0) clearance[i] = 0;
    }
}

Survey look_around(const Tracer& tracer, const Lattice& lattice, float least) {
    Survey survey{std::vector<float>(lattice.size()), std::vector<std::uint32_t>(lattice.size())};
    const auto most = static_cast<float>(most_clearance * lattice.spacing);
    const auto wanted = static_cast<float>(least * lattice.spacing);
    for_each_index(lattice.size(),
                   [&](std::size_t i) { survey.clearance[i] = clearance_at(tracer, lattice.position(i), most); });
    leave_out_groundless(tracer, lattice, wanted, survey.clearance);
    for_each_index(lattice.size(), [&](std::size_t i) {
        if (survey.clearance[i] < wanted) return;
        for (std::size_t k = 0; k < neighbours().size(); ++k) {
            const glm::ivec3 to = lattice.at(i) + neighbours()[k];
            if (!lattice.holds(to) || survey.clearance[lattice.index(to)] < wanted) continue;
            if (is_clear(tracer, lattice.position(i), lattice.position(lattice.index(to)))) survey.open[i] |= 1U << k;
        }
    });
    return survey;
}

/// Calls body(neighbour, k) for all that one gets to from point i straight on.
template <typename Body>
void for_each_open(const Lattice& lattice, const Survey& survey, std::size_t i, const Body& body) {
    for (std::size_t k = 0; k < neighbours().size(); ++k) {
        if ((survey.open[i] >> k & 1U) != 0) body(lattice.index(lattice.at(i) + neighbours()[k]), k);
    }
}

/// What probes see spreads along open lines; the largest part stays.
std::vector<std::size_t> largest_part(const Lattice& lattice, const Survey& survey, std::span<const std::size_t> seeds,
                                      float clearance) {
    const auto least = static_cast<float>(clearance * lattice.spacing);
    std::vector<bool> met(lattice.size());
    std::vector<std::size_t> largest;
    for (const std::size_t seed : seeds) {
        if (met[seed] || survey.clearance[seed] < least) continue;
        std::vector<std::size_t> reached{seed};
        met[seed] = true;
        for (std::size_t next = 0; next < reached.size(); ++next) {
            for_each_open(lattice, survey, reached[next], [&](std::size_t to, std::size_t) {
                if (met[to] || survey.clearance[to] < least) return;
                met[to] = true;
                reached.push_back(to);
            });
        }
        if (reached.size() > largest.size()) largest = std::move(reached);
    }
    return largest;
}

FreeSpace space_of(const Lattice& lattice, const Survey& survey, std::span<const std::size_t> part, float clearance) {
    FreeSpace space;
    space.spacing = lattice.spacing;
    space.room = static_cast<float>(clearance * lattice.spacing);
    constexpr std::uint32_t none = 0xffffffffU;
    std::vector<std::uint32_t> number(lattice.size(), none);
    for (const std::size_t i : part) {
        number[i] = static_cast<std::uint32_t>(space.points.size());
        space.points.push_back(lattice.position(i));
        space.clearance.push_back(survey.clearance[i]);
    }
    for (const std::size_t i : part) {
        space.first_link.push_back(static_cast<std::uint32_t>(space.links.size()));
        for_each_open(lattice, survey, i, [&](std::size_t to, std::size_t k) {
            if (number[to] == none) return;
            space.links.push_back(
                {number[to], static_cast<float>(lattice.spacing * glm::length(glm::dvec3(neighbours()[k])))});
        });
    }
    space.first_link.push_back(static_cast<std::uint32_t>(space.links.size()));
    return space;
}

}  // namespace

FreeSpace find_free_space(const Tracer& tracer, const Volume& volume, std::span<const float> clearances,
                          double enough) {
    const Lattice lattice = lattice_over(volume, tracer.scene().origin);
    const Survey survey = look_around(tracer, lattice, clearances.back());
    const std::vector<std::size_t> seeds = seen_by_probes(tracer, volume, lattice);
    const std::size_t all = largest_part(lattice, survey, seeds, clearances.back()).size();
    for (const float clearance : clearances) {
        std::vector<std::size_t> part = largest_part(lattice, survey, seeds, clearance);
        if (part.empty() || static_cast<double>(part.size()) < enough * static_cast<double>(all)) continue;
        std::sort(part.begin(), part.end());
        return space_of(lattice, survey, part, clearance);
    }
    return {};
}

}  // namespace lightgrid
