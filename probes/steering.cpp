#include "probes/steering.h"

#include "core/parallel.h"
#include "core/stopwatch.h"
#include "probes/error_report.h"
#include "probes/refine.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <tuple>

namespace lightgrid {
namespace {

/// What the random numbers are for: each has a stream of its own.
enum Stream : std::uint64_t { noise, probe_light, places, place_light, bands, check };

constexpr int most_levels = 5;
/// Of a pilot's gathers. With 1,024 the volumes were hardly better (Cornell box, breakfast room, default level), and
/// the looks at a Cornell box took more rays than its gathers.
constexpr std::uint32_t most_pilot_samples = 256;
/// Gathers that a probe takes before the bake: its own, and those at points in the cells around it.
constexpr double gathers_per_probe = 3;
/// Of the rays or the time, at most, for the looks at the grids as they were given.
constexpr double first_share = 0.5;
/// Of a gather for the bake itself.
constexpr std::uint32_t most_samples = 1U << 20;
/// At a list, each with as many rays as the last one asked for.
constexpr int most_looks_at_list = 8;
/// In a row that see no more noise than is wanted: where few rays meet what differs, one may have missed it.
constexpr int looks_that_confirm = 2;
/// Expected of a division where none has been made: between what smooth light (16) and an edge (2) give.
constexpr double first_gain = 4;
constexpr double least_gain = 1.5;
/// Bands that leave more than this of the error are not worth their place.
constexpr double worthwhile = 0.87;
/// The error has to fall at least as this power of the probes: with half of what a straight edge gives (1/4: twice as
/// fine takes four times as many along it, and halves the square), noise of the estimate included.
constexpr double least_yield = 0.125;
/// Looks in a row that tell so, before it is believed: of one, a few points beside lamps may decide.
constexpr int most_stalled = 2;
/// Of the probes, before it is told whether the error falls: a few blocks say little of the others.
constexpr double least_growth = 1.5;
/// Further points in a block, at most, for each that it has anyway.
constexpr int most_more = 8;
constexpr int most_confirmations = 4;
constexpr std::size_t band_points = 512;
constexpr std::uint32_t band_samples = 512;
constexpr std::uint32_t band_samples_in_time = 128;  // with a time budget
constexpr int most_bands = 5;

/// A point in a block, drawn once: what is not free there has no part in the error.
struct Place {
    std::size_t block = 0;
    double share = 0;  // of the block's size, m^3
    int points = 0;    // of the block
    glm::dvec3 position{0};
    bool open = false;
};

/// Of all probes of a level together.
struct LevelNoise {
    double variance = 0;  // of irradiance, with one sample
    double probes = 0;
};

class Pilot {
  public:
    Pilot(const PathTracer& paths, Volume& volume, const SteeringOptions& options, Steering& result)
        : paths_(paths), volume_(volume), options_(options), result_(result) {
        rays_.cache = options.cache;
        for (std::size_t grid = 0; grid < volume.grids.size(); ++grid) {
            levels_left_.push_back(options.may_refine ? most_levels : 0);
            finer_.push_back(-1);
            result.levels.push_back(0);
            const glm::dvec3 spacing = volume.grids[grid].spacing;
            first_spacing_.push_back(std::min({spacing.x, spacing.y, spacing.z}));
        }
    }

    void run(const std::function<void(double)>& progress) {
        const std::vector<std::size_t> slots = valid_slots(volume_);
        first_points_ = places_of(volume_, slots);
        law_ = measure_noise(paths_, first_points_, rays_, mix_bits(options_.seed, noise), result_.counts);
        if (!volume_.has_cells() || slots.empty()) {
            if (options_.seconds) light_up(volume_, slots, samples_for(law_, 1, most_samples));
            const double goal = options_.target.seconds ? 0.0 : aimed_error(options_.target);
            result_.samples = {samples_for_list(goal)};
            result_.why_samples = fmt::format("for a noise of {} at the probes", rounded_percent(goal));
            return;
        }
        for (std::size_t slot = 0; slot < volume_.list_start(); ++slot) {
            probes_ += volume_.states[slot] == ProbeState::absent ? 0 : 1;
        }
        const double all_gathers = gathers_per_probe * static_cast<double>(slots.size());
        most_samples_ = static_cast<std::uint32_t>(
            std::clamp(first_share * rays_left() / (law_.rays * all_gathers), 0.0, double{most_pilot_samples}));
        light_up(volume_, slots, pilot_samples(first_look));
        for (int grid = 0; grid < static_cast<int>(volume_.grids.size()); ++grid) {
            const std::vector<Block> blocks = blocks_of(volume_, grid);
            blocks_.insert(blocks_.end(), blocks.begin(), blocks.end());
        }
        look(undivided(0), 8);
        choose_bands();
        refine(progress);
        result_.interpolation = expected_;
        for (const Block& block : blocks_) {
            if (block.divided) continue;
            ++(block.open > 0 ? result_.open_blocks : result_.solid_blocks);
        }
        const double rest = std::hypot(result_.interpolation, bands_left());
        choose_samples(noise_goal(options_.target, rest));
    }

  private:
    /// Of interpolation, before anything is known.
    static constexpr double first_look = 0.05;

    /// So that noise at points is what shall be seen there: it is known, and many points together tell both apart.
    [[nodiscard]] std::uint32_t pilot_samples(double interpolation) const {
        return samples_for(law_, interpolation, most_samples_);
    }

    [[nodiscard]] static std::vector<std::size_t> valid_slots(const Volume& volume) {
        std::vector<std::size_t> slots;
        for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
            if (is_valid(volume.states[slot])) slots.push_back(slot);
        }
        return slots;
    }

    [[nodiscard]] std::vector<glm::vec3> places_of(const Volume& volume, std::span<const std::size_t> slots) const {
        std::vector<glm::vec3> points;
        for (const std::size_t slot : slots) {
            points.emplace_back(gather_position(volume, slot) - paths_.tracer().scene().origin);
        }
        return points;
    }

    /// Two pilots with few rays may foretell too little for many: pilots with as many as they ask for look again. Where
    /// one sees more noise than that, more rays are taken, as if it fell no faster than that of random rays.
    std::uint32_t samples_for_list(double goal) {
        std::uint32_t samples = samples_for(law_, goal, most_samples);
        int confirmations = 0;
        for (int look = 0; goal > 0 && look < most_looks_at_list && samples < most_samples; ++look) {
            const double variance = variance_at(paths_, first_points_, rays_, samples,
                                                mix_bits(mix_bits(options_.seed, check), look), result_.counts);
            confirmations = variance <= goal * goal ? confirmations + 1 : 0;
            if (confirmations == looks_that_confirm) break;
            if (confirmations == 0) samples = samples_for({variance, samples, 1, law_.rays}, goal, most_samples);
        }
        return samples;
    }

    /// The pilot's own light of these probes.
    void light_up(Volume& volume, std::span<const std::size_t> slots, std::uint32_t samples) {
        GatherOptions gather_options;
        gather_options.bands = std::min(volume.bands, 3);
        gather_options.samples = samples;
        gather_options.seed = mix_bits(mix_bits(options_.seed, probe_light), volume_.slots());
        gather_options.rays = rays_;
        const Stopwatch watch;
        store(gather(paths_, places_of(volume, slots), gather_options, &result_.counts), slots, volume);
        gather_seconds_ += watch.seconds();
        gathered_ += static_cast<double>(slots.size()) * gather_options.samples;
        result_.seconds_per_sample = gather_seconds_ / std::max(gathered_, 1.0);
        const double samples_scale = std::pow(gather_options.samples, law_.exponent);
        for (const std::size_t slot : slots) {
            const bool listed = slot >= volume.list_start();
            const int level = listed ? 0 : result_.levels[volume.bricks[slot / probes_per_brick].grid];
            if (noise_.size() <= static_cast<std::size_t>(level)) noise_.resize(level + 1);
            LevelNoise& noise = noise_[level];
            noise.variance +=
                samples_scale *
                mean_square_irradiance(std::span(volume.errors).subspan(slot * volume.sh_size(), volume.sh_size()));
            noise.probes += 1;
        }
    }

    /// How far the corners of a block's cells are from each other, in irradiance: what interpolation says there can
    /// hardly be wrong by more.
    [[nodiscard]] double contrast(const Sampler& sampler, const Block& block) const {
        const Grid& grid = volume_.grids[block.grid];
        std::vector<glm::vec3> mean(volume_.sh_size());
        std::vector<glm::vec3> difference(volume_.sh_size());
        double sum = 0;
        for (const glm::ivec3 cell : cells_of(grid, block)) {
            const glm::dvec3 centre = grid.origin + (glm::dvec3(cell) + 0.5) * grid.spacing;
            sampler.sample(centre, mean);
            const Sampler::Corners corners = sampler.corners(centre);
            for (int c = 0; c < corners.count; ++c) {
                const auto corner = volume_.sh(corners.slots[c]);
                std::transform(corner.begin(), corner.end(), mean.begin(), difference.begin(), std::minus<>());
                sum += corners.weights[c] * mean_square_irradiance(difference);
            }
        }
        return std::sqrt(sum);
    }

    [[nodiscard]] double size_of(const Block& block) const {
        const Grid& grid = volume_.grids[block.grid];
        return grid.spacing.x * grid.spacing.y * grid.spacing.z * static_cast<double>(cells_of(grid, block).size());
    }

    /// `each` points in each of these blocks, and as many again where corners differ most (the allocation that has least
    /// variance if what interpolation is wrong by is in proportion to that: Neyman 1934).
    std::vector<Place> draw_places(std::span<const std::size_t> blocks, int each) {
        const Sampler sampler(volume_);
        std::vector<double> weights(blocks.size());
        for_each_index(blocks.size(), [&](std::size_t i) {
            weights[i] = size_of(blocks_[blocks[i]]) * contrast(sampler, blocks_[blocks[i]]);
        });
        double sum = 0;
        for (const double weight : weights) sum += weight;
        std::vector<Place> drawn;
        for (std::size_t i = 0; i < blocks.size(); ++i) {
            const Block& block = blocks_[blocks[i]];
            const Grid& grid = volume_.grids[block.grid];
            const std::vector<glm::ivec3> cells = cells_of(grid, block);
            const double more = sum > 0 ? each * static_cast<double>(blocks.size()) * weights[i] / sum : 0;
            const int points = each + static_cast<int>(std::min(more, double{most_more} * each));
            for (int k = 0; k < points; ++k) {
                RandomStream random(mix_bits(mix_bits(options_.seed, places), draws_++));
                const auto any = static_cast<std::size_t>(random.next_double() * static_cast<double>(cells.size()));
                const glm::ivec3 cell = points >= static_cast<int>(cells.size()) ? cells[k % cells.size()] : cells[any];
                const glm::dvec3 u(random.next_double(), random.next_double(), random.next_double());
                drawn.push_back(
                    {blocks[i], size_of(block) / points, points, grid.origin + (glm::dvec3(cell) + u) * grid.spacing});
            }
        }
        for_each_index(drawn.size(), [&](std::size_t i) {
            const glm::vec3 point(drawn[i].position - paths_.tracer().scene().origin);
            drawn[i].open =
                is_open(paths_.tracer(), point, first_spacing_[blocks_[drawn[i].block].grid], options_.light);
        });
        return drawn;
    }

    /// How far interpolation is off in these blocks: the light at points of theirs against what the corners say, less
    /// what the noise of both makes of it. Returns the sum of squares; the blocks keep the mean of all looks.
    double look(std::span<const std::size_t> blocks, int each) {
        fill_invalid(volume_, paths_.tracer());
        const std::vector<Place> drawn = draw_places(blocks, each);
        std::vector<glm::vec3> points;
        for (const Place& place : drawn) {
            if (place.open) points.emplace_back(place.position - paths_.tracer().scene().origin);
        }
        if (band_places_.empty()) band_places_ = points;
        GatherOptions gather_options;
        gather_options.bands = std::min(volume_.bands, 3);
        gather_options.samples = pilot_samples(expected_);
        gather_options.seed = mix_bits(mix_bits(options_.seed, place_light), draws_);
        gather_options.rays = rays_;
        const Gather light = gather(paths_, points, gather_options, &result_.counts);

        const Sampler sampler(volume_);
        const std::size_t n = volume_.sh_size();
        const auto known = static_cast<std::size_t>(light.bands) * light.bands;
        std::vector<glm::vec3> sh(n);
        std::vector<glm::vec3> difference(known);
        std::vector<glm::vec3> errors(known);
        std::vector<double> squares(blocks_.size());
        double energy = 0;
        std::size_t i = 0;
        for (const Place& place : drawn) {
            if (!place.open) continue;
            sampler.sample(place.position, sh);
            for (std::size_t k = 0; k < known; ++k) {
                const Estimate& estimate = light.sh(i)[k];
                difference[k] = sh[k] - glm::vec3(estimate.mean);
                sh[k] = glm::vec3(estimate.mean);
                errors[k] = glm::vec3(estimate.error);
            }
            const double own_noise = mean_square_irradiance(errors);
            double noise = 0;
            const Sampler::Corners corners = sampler.corners(place.position);
            for (int c = 0; c < corners.count; ++c) {
                const double weight = corners.weights[c];
                noise += weight * weight *
                         mean_square_irradiance(std::span(volume_.errors).subspan(corners.slots[c] * n, known));
            }
            squares[place.block] += place.share * (mean_square_irradiance(difference) - own_noise - noise);
            energy += place.share * (mean_square_irradiance(std::span(sh).first(known)) - own_noise);
            ++i;
        }
        if (energy_ == 0) {
            energy_ = energy;
            for (const Place& place : drawn) open_ += place.open ? place.share : 0;
        }
        std::vector<int> count(blocks_.size());
        for (const Place& place : drawn) {
            count[place.block] = place.points;
            blocks_[place.block].open += place.open ? 1 : 0;
        }
        double sum = 0;
        for (const std::size_t b : blocks) {
            const double square = energy_ > 0 ? squares[b] / energy_ : 0.0;
            sum += square;
            Block& block = blocks_[b];
            block.square = (block.points * block.square + count[b] * square) / (block.points + count[b]);
            block.points += count[b];
        }
        return sum;
    }

    [[nodiscard]] std::vector<std::size_t> undivided(std::size_t first) const {
        std::vector<std::size_t> found;
        for (std::size_t b = first; b < blocks_.size(); ++b) {
            if (!blocks_[b].divided) found.push_back(b);
        }
        return found;
    }

    [[nodiscard]] double interpolation() const {
        double square = 0;
        for (const Block& block : blocks_) square += block.divided ? 0 : block.square;
        return std::sqrt(std::max(square, 0.0));
    }

    void choose_bands() {
        result_.bands = options_.bands.value_or(3);
        if (options_.bands || !(options_.target.error || options_.target.seconds) || band_places_.empty()) return;
        result_.bands_error = measure_bands(paths_, spread_over<glm::vec3>(band_places_, band_points), most_bands,
                                            options_.seconds ? band_samples_in_time : band_samples, rays_,
                                            mix_bits(options_.seed, bands), result_.counts);
        const auto error = [&](int bands) { return result_.bands_error[static_cast<std::size_t>(bands) - 1]; };
        // Odd bands beyond the second bring no irradiance: nothing is lost by leaving them out.
        const double goal = aimed_share * options_.target.error.value_or(0);
        if (!options_.target.error || error(3) <= goal) {
            result_.why_bands = fmt::format("3 leave {}", rounded_percent(error(3)));
        } else if (error(5) < worthwhile * error(3)) {
            result_.bands = 5;
            result_.why_bands =
                fmt::format("3 would leave {}, 5 leave {}", rounded_percent(error(3)), rounded_percent(error(5)));
        } else {
            result_.why_bands = fmt::format("3 leave {}, and 5 would hardly leave less", rounded_percent(error(3)));
        }
    }

    [[nodiscard]] double bands_left() const {
        return result_.bands_error.empty() ? 0 : result_.bands_error[static_cast<std::size_t>(result_.bands) - 1];
    }

    void refine(const std::function<void(double)>& progress) {
        const double goal = interpolation_goal(options_.target, bands_left());
        double gain = first_gain;
        int confirmations = 0;
        int stalled = 0;
        while (true) {
            expected_ = interpolation();
            // The blocks that were left as they are were chosen because their points looked good: only fresh points tell.
            if (expected_ <= goal) {
                expected_ = std::sqrt(std::max(look(undivided(0), 1), 0.0));
                ++confirmations;
            }
            result_.rounds.push_back({probes_, expected_, 0});
            if (progress) progress(1 - 1 / (1.0 + static_cast<double>(result_.rounds.size())));
            if (!options_.may_refine) return;
            if (expected_ <= goal || confirmations > most_confirmations) {
                result_.why_refined = fmt::format("interpolation leaves {}", rounded_percent(expected_));
                return;
            }
            stalled = buys_too_little() ? stalled + 1 : 0;
            if (stalled == most_stalled) {
                result_.why_refined = fmt::format(
                    "interpolation leaves {}, and more probes would hardly lower it: walls leak, or edges are sharp",
                    rounded_percent(expected_));
                return;
            }
            const double known = interpolation();
            const double aim = goal * goal * std::min(1.0, known * known / std::max(expected_ * expected_, 1e-30));
            const Division division = choose_blocks(blocks_, levels_left_, gain, aim, probes_left());
            const std::size_t first = blocks_.size();
            const double before = divide_blocks(division);
            if (blocks_.size() == first) {
                result_.why_refined =
                    fmt::format("interpolation leaves {}: {}", rounded_percent(expected_), what_ended());
                return;
            }
            const double after = look(undivided(first), 8);
            gain = std::clamp(before / std::max(after, before / first_gain), least_gain, first_gain);
        }
    }

    [[nodiscard]] const char* what_ended() const {
        if (static_cast<double>(options_.max_probes - probes_) <= probes_left()) {
            return "no probe or level is left to divide more";
        }
        return options_.seconds ? "to look where more probes serve took its share of the time"
                                : "to look where more probes serve took its share of the rays";
    }

    /// Since there were a third fewer probes, divisions hardly lowered the error. Where it is much larger than it was,
    /// new points found what all others had missed, and there is more to do.
    [[nodiscard]] bool buys_too_little() const {
        const auto before = std::find_if(result_.rounds.rbegin(), result_.rounds.rend(), [&](const Round& round) {
            return least_growth * static_cast<double>(round.probes) <= static_cast<double>(probes_);
        });
        if (before == result_.rounds.rend()) return false;
        const double fallen = std::log(before->interpolation / expected_);
        return std::abs(fallen) <
               least_yield * std::log(static_cast<double>(probes_) / static_cast<double>(before->probes));
    }

    /// That may still be traced; where time is given, what it pays for at the rate so far.
    [[nodiscard]] double rays_left() const {
        const PathCounts& counts = result_.counts;
        const auto traced = static_cast<double>(counts.rays + counts.shadow_rays + result_.placed.rays);
        if (!options_.seconds) return options_.rays - traced;
        return traced * (*options_.seconds / watch_.seconds() - 1);
    }

    /// That may be added: what the limit leaves, and the rays.
    [[nodiscard]] double probes_left() const {
        const auto left = static_cast<double>(options_.max_probes - probes_);
        return std::min(left, rays_left() / (law_.rays * gathers_per_probe * pilot_samples(expected_)));
    }

    /// Divides the blocks, in order, while there are probes left; returns what their squares were.
    double divide_blocks(const Division& division) {
        const auto key = [](const Brick& b) { return std::tuple(b.grid, b.origin.z, b.origin.y, b.origin.x); };
        const auto less = [&](const Brick& a, const Brick& b) { return key(a) < key(b); };
        const std::set<Brick, decltype(less)> known(volume_.bricks.begin(), volume_.bricks.end(), less);
        std::set<Brick, decltype(less)> added(less);
        std::vector<Block> parts;
        double squares = 0;
        const double most = probes_left();
        for (const std::size_t b : division.blocks) {
            const int grid = blocks_[b].grid;
            if (finer_[grid] < 0) add_finer(grid);
            std::vector<Brick> missing = bricks_over(volume_, blocks_[b], finer_[grid]);
            std::erase_if(missing, [&](const Brick& brick) { return known.count(brick) + added.count(brick) > 0; });
            if (static_cast<double>((added.size() + missing.size()) * probes_per_brick) > most) break;
            added.insert(missing.begin(), missing.end());
            blocks_[b].divided = true;
            squares += blocks_[b].square;
            ++result_.rounds.back().blocks;
            for (const Block& part : divide(volume_, blocks_[b], finer_[grid])) parts.push_back(part);
        }
        add_probes({added.begin(), added.end()});
        blocks_.insert(blocks_.end(), parts.begin(), parts.end());
        return squares;
    }

    void add_finer(int grid) {
        finer_[grid] = static_cast<int>(volume_.grids.size());
        volume_.grids.push_back(at_half_spacing(volume_.grids[grid]));
        finer_.push_back(-1);
        first_spacing_.push_back(first_spacing_[grid]);
        levels_left_.push_back(levels_left_[grid] - 1);
        result_.levels.push_back(result_.levels[grid] + 1);
    }

    void add_probes(std::vector<Brick> bricks) {
        Volume more = make_volume(volume_.grids, std::move(bricks), volume_.bands);
        const PlacementCounts placed = place_probes(more, paths_.tracer(), options_.light);
        result_.placed.valid += placed.valid;
        result_.placed.moved += placed.moved;
        result_.placed.invalid += placed.invalid;
        result_.placed.rays += placed.rays;
        probes_ += static_cast<std::int64_t>(placed.valid + placed.moved + placed.invalid);
        light_up(more, valid_slots(more), pilot_samples(expected_));
        append(volume_, more);
    }

    /// Of a probe's variance, what is left of it where eight probes are interpolated: the mean of squared weights.
    static constexpr double corner_share = 8.0 / 27;

    /// How much more variance than the law foretells there is with so many rays; 1 where it is less, or where looking
    /// would cost too much.
    double beyond_law(double samples) {
        const std::uint32_t rays = whole_replicates(samples, most_pilot_samples);
        const double foretold = law_.at(rays);
        if (rays >= most_pilot_samples || !(foretold > 0)) return 1;
        const double variance =
            variance_at(paths_, first_points_, rays_, rays, mix_bits(options_.seed, check), result_.counts);
        return std::max(variance / foretold, 1.0);
    }

    /// For noise at points (relRMSE): the variance of a level's probes counts by the space that they answer for, and
    /// rays go where they take most of it.
    void choose_samples(double goal) {
        std::vector<double> space(noise_.size());
        double all = 0;
        for (const Block& block : blocks_) {
            if (block.divided) continue;
            space[result_.levels[block.grid]] += size_of(block);
            all += size_of(block);
        }
        const double mean_square = open_ > 0 ? energy_ / open_ : 0;
        std::vector<double> wanted(noise_.size());
        double variance = 0;
        for (std::size_t level = 0; level < noise_.size(); ++level) {
            const LevelNoise& noise = noise_[level];
            if (!(noise.variance > 0 && mean_square > 0)) continue;
            const double part = corner_share * space[level] / all * noise.variance / (noise.probes * mean_square);
            wanted[level] = std::pow(part / noise.probes, 1 / (1 + law_.exponent));
            if (wanted[level] > 0) variance += part * std::pow(wanted[level], -law_.exponent);
        }
        double scale = most_samples;
        if (goal > 0) {
            scale = std::pow(variance / (goal * goal), 1 / law_.exponent);
            scale *= std::pow(beyond_law(scale * wanted.front()), 1 / law_.exponent);
        }
        for (const double rays : wanted) result_.samples.push_back(whole_replicates(scale * rays, most_samples));
        result_.why_samples = fmt::format("for a noise of {} at points", rounded_percent(goal));
    }

    const PathTracer& paths_;
    Volume& volume_;
    const SteeringOptions& options_;
    Steering& result_;
    GatherRays rays_;
    NoiseLaw law_;
    std::vector<glm::vec3> first_points_;  // of the probes before any is added
    std::vector<Block> blocks_;
    std::vector<int> finer_;  // by grid: that at half its spacing, or -1
    std::vector<int> levels_left_;
    std::vector<double> first_spacing_;  // by grid: the least of the one that it refines
    std::vector<glm::vec3> band_places_;
    std::int64_t probes_ = 0;  // of the grids
    std::vector<LevelNoise> noise_;
    double energy_ = 0;  // squared irradiance over all open space
    double open_ = 0;    // space, m^3
    double gather_seconds_ = 0;
    double gathered_ = 0;  // samples
    Stopwatch watch_;
    std::uint32_t most_samples_ = 0;  // of a gather here
    double expected_ = first_look;
    std::uint64_t draws_ = 0;
};

}  // namespace

Steering steer(const PathTracer& paths, Volume& volume, const SteeringOptions& options,
               const std::function<void(double)>& progress) {
    Steering result;
    Pilot(paths, volume, options, result).run(progress);
    return result;
}

}  // namespace lightgrid
