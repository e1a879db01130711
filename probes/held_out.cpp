#include "probes/held_out.h"

#include "core/parallel.h"
#include "core/sampling.h"

#include <algorithm>
#include <span>

namespace lightgrid {
namespace {

constexpr std::size_t normals_per_point = 64;
constexpr int most_tries_per_point = 64;

/// Of the points, those that are spread evenly: what a look has missed, and leaks into the dark, is for them to find.
constexpr double even_share = 0.5;
/// Parts are divided while they hold more than this of the space, or of the squared light.
constexpr double most_space = 1.0 / 512;
constexpr double most_light = 1.0 / 256;
/// By 64 along each axis: what falls off quicker holds hardly any space.
constexpr int most_divisions = 6;
constexpr int looks_per_part = 4;
/// For each point.
constexpr int candidates = 4;
/// Of a look: paths, and bounces of each.
constexpr std::uint32_t look_paths = 16;
constexpr std::uint32_t look_bounces = 2;

/// A part of the boxes of a volume's grids.
struct Part {
    Box box;
    double spacing = 0;        // of its grid, the least
    double space = 0;          // m^3
    double light = 0;          // squared, times space
    std::size_t division = 0;  // that made it, by number
};

double space_of(const Part& part) {
    return part.space;
}
double light_of(const Part& part) {
    return part.light;
}

template <typename Quantity>
double sum_of(std::span<const Part> parts, Quantity&& quantity) {
    double sum = 0;
    for (const Part& part : parts) sum += quantity(part);
    return sum;
}

glm::dvec3 place_in(const Box& box, RandomStream& random) {
    const glm::dvec3 u(random.next_double(), random.next_double(), random.next_double());
    return box.min + u * box.size();
}

/// Light at a point from few short paths: R + G + B of its mean radiance, times 4 pi. 0 inside of something.
double look_at(glm::vec3 point, const PathTracer& paths, std::uint64_t key, PathCounts& counts) {
    static const std::vector<glm::vec3> directions = even_directions(look_paths);
    std::vector<LightSample> light;
    paths.gather({point}, key, directions, light, counts, {.most_bounces = look_bounces});
    paths.gather_punctual(point, light, counts);
    double sum = 0;
    for (const LightSample& sample : light) sum += sample.radiance.x + sample.radiance.y + sample.radiance.z;
    return sum;
}

/// Divides a volume's boxes into parts, the smaller the brighter.
class Parts {
  public:
    Parts(const PathTracer& paths, std::uint64_t seed) : paths_(paths), seed_(seed) {}

    std::vector<Part> of(std::span<const Grid> grids, PathCounts& counts) {
        for (const Grid& grid : grids) {
            const Box box{grid.origin, grid.position(grid.counts - 1)};
            const glm::dvec3 size = box.size();
            parts_.push_back({box, std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z}),
                              std::max(size.x * size.y * size.z, 1e-300)});
        }
        const double all_space = sum_of(parts_, space_of);
        while (divide_where(space_of, most_space * all_space) > 0) {
        }
        look(parts_, counts);
        for (int i = 0; i < most_divisions; ++i) {
            const std::size_t fresh = divide_where(light_of, most_light * sum_of(parts_, light_of));
            if (fresh == 0) break;
            look(std::span(parts_).last(fresh), counts);
        }
        return std::move(parts_);
    }

  private:
    /// Replaces parts of more than `most` by their halves, which are the last then; returns how many these are.
    template <typename Quantity>
    std::size_t divide_where(Quantity&& quantity, double most) {
        std::vector<Part> kept;
        std::vector<Part> divided;
        for (const Part& part : parts_) {
            if (quantity(part) > most) {
                divide(part, divided);
            } else {
                kept.push_back(part);
            }
        }
        parts_ = std::move(kept);
        parts_.insert(parts_.end(), divided.begin(), divided.end());
        return divided.size();
    }

    /// In halves along each axis that is longer than half of the longest.
    void divide(const Part& part, std::vector<Part>& out) {
        const glm::dvec3 size = part.box.size();
        const double longest = std::max({size.x, size.y, size.z});
        std::vector<Part> halves{part};
        for (int axis = 0; axis < 3; ++axis) {
            if (size[axis] <= 0.5 * longest) continue;
            for (std::size_t i = halves.size(); i-- > 0;) {
                Part upper = halves[i];
                upper.box.min[axis] = halves[i].box.max[axis] = upper.box.center()[axis];
                halves.push_back(upper);
            }
        }
        ++divisions_;
        for (Part& half : halves) {
            half.space = part.space / static_cast<double>(halves.size());
            half.division = divisions_;
            out.push_back(half);
        }
    }

    /// Squared light: that of the mean of the looks that find any, for as much of the part as these are of all: the
    /// rest is inside of something. (A mean of squares would follow the few looks that come close to a light.) Looks
    /// miss what is in a corner: half of it counts for all that were one part.
    void look(std::span<Part> parts, PathCounts& counts) {
        std::vector<PathCounts> counted(parts.size());
        for_each_index(parts.size(), [&](std::size_t i) {
            const std::uint64_t key = mix_bits(seed_, looked_at_ + i);
            RandomStream random(key);
            double sum = 0;
            int lit = 0;
            for (int k = 0; k < looks_per_part; ++k) {
                const glm::dvec3 place = place_in(parts[i].box, random);
                const glm::vec3 point(place - paths_.tracer().scene().origin);
                if (is_at_light(paths_.tracer(), point, parts[i].spacing)) continue;
                const double light = look_at(point, paths_, mix_bits(key, k), counted[i]);
                sum += light;
                lit += light > 0 ? 1 : 0;
            }
            parts[i].light = lit > 0 ? parts[i].space * sum * sum / (lit * looks_per_part) : 0.0;
        });
        for (const PathCounts& c : counted) counts += c;
        looked_at_ += parts.size();
        for (std::size_t i = 0; i < parts.size();) {
            std::size_t end = i;
            while (end < parts.size() && parts[end].division == parts[i].division) ++end;
            const std::span<Part> halves = parts.subspan(i, end - i);
            const double mean = sum_of(halves, light_of) / static_cast<double>(halves.size());
            for (Part& half : halves) half.light = 0.5 * (half.light + mean);
            i = end;
        }
    }

    const PathTracer& paths_;
    std::uint64_t seed_;
    std::vector<Part> parts_;
    std::size_t divisions_ = 0;
    std::uint64_t looked_at_ = 0;
};

struct Drawn {
    glm::dvec3 place{0};
    double weight = 0;  // 0: no open place was found
};

/// Places with density even_share + (1 - even_share) * squared light, about, over what they would have if all were
/// drawn evenly: the parts' densities are known, and of some candidates from these one is taken by a look at just its
/// place. Source: Talbot, Cline, Egbert, "Importance Resampling for Global Illumination", 2005.
std::vector<Drawn> draw_places(std::span<const Part> parts, const PathTracer& paths, const LightEvidence& evidence,
                               const HeldOutOptions& options, PathCounts& counts) {
    const double all_space = sum_of(parts, space_of);
    const double all_light = sum_of(parts, light_of);
    const auto density = [&](double light_per_space) {
        return all_light > 0 ? even_share + (1 - even_share) * light_per_space * all_space / all_light : 1.0;
    };
    std::vector<double> chances;
    for (const Part& part : parts) chances.push_back(part.space / all_space * density(part.light / part.space));
    const AliasTable pick(chances);

    std::vector<Drawn> drawn(options.points);
    std::vector<PathCounts> counted(options.points);
    for_each_index(options.points, [&](std::size_t i) {
        const std::uint64_t key = mix_bits(mix_bits(options.seed, 2), i);
        RandomStream random(key);
        double sum = 0;
        double chosen = 0;  // density
        int open = 0;
        for (int k = 0; k < most_tries_per_point && open < candidates; ++k) {
            const Part& part = parts[pick.sample(random.next_double())];
            const glm::dvec3 place = place_in(part.box, random);
            const double u = random.next_double();
            const glm::vec3 point(place - paths.tracer().scene().origin);
            if (!is_open(paths.tracer(), point, part.spacing, evidence)) continue;
            ++open;
            const double light = look_at(point, paths, mix_bits(key, k), counted[i]);
            const double wanted = density(light * light);
            const double share = wanted / density(part.light / part.space);
            sum += share;
            if (u * sum >= share) continue;
            drawn[i].place = place;
            chosen = wanted;
        }
        if (open > 0) drawn[i].weight = sum / open / chosen;
    });
    for (const PathCounts& c : counted) counts += c;
    return drawn;
}

}  // namespace

const std::vector<glm::vec3>& held_out_normals() {
    static const std::vector<glm::vec3> normals = [] {
        std::vector<glm::vec3> made;
        for (std::uint32_t i = 0; i < normals_per_point; ++i) made.push_back(sphere_direction(sobol_point(i, 0)));
        return made;
    }();
    return normals;
}

HeldOut trace_held_out(const Volume& volume, const PathTracer& paths, const LightEvidence& light,
                       const HeldOutOptions& options) {
    HeldOut held_out;
    const std::span<const Grid> grids = std::span(volume.grids).first(std::min(options.grids, volume.grids.size()));
    if (grids.empty()) return held_out;
    const std::vector<Part> parts = Parts(paths, mix_bits(options.seed, 14)).of(grids, held_out.counts);
    std::vector<glm::vec3> relative;
    for (const auto& [place, weight] : draw_places(parts, paths, light, options, held_out.counts)) {
        if (weight == 0) continue;
        held_out.points.push_back(place);
        held_out.weights.push_back(weight);
        relative.emplace_back(place - paths.tracer().scene().origin);
    }
    if (relative.empty()) return held_out;

    GatherOptions gather_options;
    gather_options.bands = options.bands;
    gather_options.samples = options.samples;
    gather_options.normals = held_out_normals();
    gather_options.seed = mix_bits(options.seed, 3);
    held_out.a = gather(paths, relative, gather_options, &held_out.counts);
    gather_options.seed = mix_bits(options.seed, 4);
    held_out.b = gather(paths, relative, gather_options, &held_out.counts);
    return held_out;
}

void trace_bias(HeldOut& held_out, const PathTracer& paths, const SurfaceCache& cache, const BiasOptions& options) {
    std::vector<glm::vec3> relative;
    for (const glm::dvec3& point : held_out.points) relative.emplace_back(point - paths.tracer().scene().origin);
    held_out.bias = measure_bias(paths, cache, relative, held_out_normals(), options);
    held_out.counts += held_out.bias->counts;
}

}  // namespace lightgrid
