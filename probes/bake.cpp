#include "probes/bake.h"

#include "core/stopwatch.h"
#include "probes/half_storage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lightgrid {
namespace {

/// With a time budget: replicates that it shall pay for (more if they turn out cheaper), and what tells too little.
constexpr std::uint32_t least_replicates = 4;
/// Each has a quarter of the area for a patch, twice the rays that find them and twice the samples of lights.
constexpr int most_finer_caches = 2;
/// In measurements of the total error: of all its parts, and comparing look-ups for each band (8 to 12 on three levels:
/// four are measured, and timed).
constexpr double measures_of_parts = 9;
constexpr double measures_per_band = 12;

/// Of irradiance, over all directions of all gathered probes.
ErrorPart noise_at_probes(const Volume& volume, std::span<const Batch> batches) {
    double variance = 0;
    double energy = 0;
    for (const Batch& batch : batches) {
        for (const std::size_t slot : batch.slots) {
            variance +=
                mean_square_irradiance(std::span(volume.errors).subspan(slot * volume.sh_size(), volume.sh_size()));
            energy += mean_square_irradiance(volume.sh(slot));
        }
    }
    ErrorPart noise;
    if (energy > 0) noise.relrmse = std::sqrt(variance / energy);
    noise.interval = {noise.relrmse, noise.relrmse};
    return noise;
}

bool is_black(std::span<const glm::vec3> light) {
    return std::all_of(light.begin(), light.end(), [](glm::vec3 l) { return l == glm::vec3(0); });
}

/// The bake itself, stage by stage.
class Bake {
  public:
    Bake(const PathTracer& paths, const BakePlan& plan, const BakeOptions& options, const Progress& progress)
        : paths_(paths), plan_(plan), options_(options), progress_(progress) {
        result_.volume = plan.volume;
        result_.left_out = plan.left_out;
        result_.stages = plan.stages;
    }

    BakeResult run() {
        trace_reference();
        solve_surfaces();
        if (surfaces_) {
            gather_transport();
        } else {
            gather();
        }
        finish();
        measure();
        judge();
        describe();
        return std::move(result_);
    }

    BakeResult run_from(const KeptTransport& kept) {
        result_.no_error_because =
            "solved with kept transport: no path was traced, only the noise at the probes is known";
        result_.from_kept = true;
        light_from(kept);
        finish();
        judge();
        describe();
        return std::move(result_);
    }

  private:
    void tell(const Doing& doing) const {
        if (progress_) progress_(doing);
    }
    void add_stage(const std::string& name, double seconds, const PathCounts& counts) {
        result_.counts += counts;
        result_.stages.push_back({name, seconds, counts.rays + counts.shadow_rays});
    }

    void trace_reference() {
        if (!plan_.volume.has_cells()) {
            result_.no_error_because = "a list has no cells to interpolate in: only the noise at the probes is known";
        } else if (!options_.measure_error) {
            result_.no_error_because = "not asked for: only the noise at the probes is known";
        } else {
            const Stopwatch watch;
            tell({"reference"});
            held_out_ = trace_held_out(plan_.volume, paths_, plan_.light, plan_.held_out);
            add_stage("reference", watch.seconds(), held_out_.counts);
            if (held_out_.points.empty()) result_.no_error_because = "no free point was found in the volume";
        }
    }

    /// The light of surfaces, known well enough for the target: finer while its bias is certainly too large, and in the
    /// end not at all where an error is asked for. Samples or time that are given are kept to.
    void solve_surfaces() {
        if (plan_.method != Method::cache) return;
        const bool is_free = plan_.steering && !options_.clock && !held_out_.points.empty();
        CacheOptions cache_options = plan_.cache;
        for (int finer = 0;; ++finer) {
            solve_surfaces(cache_options);
            measure_bias(finer);
            if (!is_free) return;
            const double goal = bias_goal(options_.target, rest_expected());
            const double bias = bias_of(held_out_).interval.low;
            if (bias <= goal) return;
            const std::string too_much =
                fmt::format("its bias is at least {}, above {}", rounded_percent(bias), rounded_percent(goal));
            if (finer == most_finer_caches) {
                if (options_.target.error && options_.layers.empty()) leave_out_cache(too_much);
                return;
            }
            cache_options.width /= 2;
            cache_options.rays_per_probe *= 2;
            cache_options.light_samples *= 2;
            cache_options.seed = mix_bits(plan_.cache.seed, finer);
        }
    }

    void solve_surfaces(const CacheOptions& cache_options) {
        const Stopwatch watch;
        tell({"cache"});
        Surfaces surfaces = find_surfaces(paths_, plan_.points, cache_options);
        if (options_.keep_transport || !options_.layers.empty()) {
            surfaces_ = surfaces;
            surfaces_options_ = cache_options;
        }
        cache_ = light_surfaces(std::move(surfaces), cache_options);
        result_.method = Method::cache;
        result_.cache = cache_->made();
        add_stage("cache", watch.seconds(), result_.cache->counts);
    }

    /// By other paths for each cache, so that none is chosen for its luck with them.
    void measure_bias(int attempt) {
        if (held_out_.points.empty()) return;
        const Stopwatch watch;
        tell({"bias"});
        BiasOptions bias_options;
        bias_options.samples = std::max(1U, plan_.held_out.samples / 2);
        bias_options.seed = mix_bits(mix_bits(options_.seed, 10), attempt);
        trace_bias(held_out_, paths_, *cache_, bias_options);
        add_stage("bias", watch.seconds(), held_out_.bias->counts);
    }

    void leave_out_cache(const std::string& why) {
        cache_.reset();
        surfaces_.reset();
        held_out_.bias.reset();
        result_.cache.reset();
        result_.method = Method::path;
        result_.left_out.push_back({"the surface cache", why, "a bias that more samples would not lower"});
    }

    /// Of bands and interpolation.
    [[nodiscard]] double rest_expected() const {
        const Steering& steering = *plan_.steering;
        const double bands =
            steering.bands_error.empty() ? 0 : steering.bands_error[static_cast<std::size_t>(steering.bands) - 1];
        return std::hypot(steering.interpolation, bands);
    }

    /// What time allows of `more` replicates, or all of them where it is no matter.
    [[nodiscard]] std::uint32_t affordable(std::uint32_t done, std::uint32_t more, double seconds) const {
        if (!options_.clock) return more;
        if (done < least_replicates) return 1;
        const double measures =
            measures_of_parts + (options_.compare_look_ups ? measures_per_band * plan_.volume.bands : 0);
        const double left = *options_.target.seconds * (1 - finishing_share) - measures * measuring_seconds_ -
                            options_.clock->seconds();
        const auto affordable = static_cast<std::uint32_t>(std::max(0.0, left * done / seconds));
        // Half of what is left at once: other programs may come and go meanwhile.
        return std::min({more, affordable, std::max(1U, affordable / 2)});
    }

    void gather() {
        const Stopwatch watch;
        GatherOptions gather_options;
        gather_options.bands = plan_.volume.bands;
        gather_options.rays.cache = cache_ ? &*cache_ : nullptr;
        double all = 0;
        for (const Batch& batch : plan_.batches) {
            gather_options.samples = batch.samples;
            gather_options.seed = sums_.empty() ? options_.seed : mix_bits(mix_bits(options_.seed, 13), sums_.size());
            sums_.emplace_back(paths_, batch.points, gather_options);
            all += static_cast<double>(batch.points.size()) * batch.samples;
        }
        std::uint32_t done = 0;
        std::optional<double> error;
        double seconds = 0;
        while (true) {
            const std::uint32_t wanted = done == 0 ? 1 : done;
            const std::uint32_t most = options_.clock ? wanted : std::min(wanted, gather_options.replicates - done);
            const std::uint32_t more = affordable(done, most, seconds);
            if (more == 0) break;
            double gathered = done * all;
            for (std::size_t b = 0; b < sums_.size(); ++b) {
                const Batch& batch = plan_.batches[b];
                sums_[b].add_replicates(more, [&](std::size_t points) {
                    const double now = gathered + static_cast<double>(points) * batch.samples;
                    tell({"gather", now / (all * std::max(done + more, gather_options.replicates)), rays_gathered(),
                          error});
                });
                gathered += static_cast<double>(more * batch.points.size()) * batch.samples;
                store(sums_[b].result(), batch.slots, result_.volume);
            }
            done += more;
            seconds = watch.seconds();
            result_.noise = noise_at_probes(result_.volume, plan_.batches);
            if (done > 1) error = result_.noise.relrmse;
            if (!held_out_.points.empty()) {
                const Stopwatch measuring;
                const ErrorPart total = measure_total(result_.volume, held_out_);
                measuring_seconds_ = measuring.seconds();
                error = std::max(total.relrmse, 0.0);
                result_.curve.push_back({seconds, done * plan_.samples / gather_options.replicates, rays_gathered(),
                                         total.relrmse, total.interval});
            }
        }
        result_.replicates = done;
        PathCounts counts;
        for (const GatherSums& sums : sums_) counts += sums.counts();
        add_stage("gather", watch.seconds(), counts);
    }

    /// In place of gathering with the cache: what is traced can be lit again by other lights, and by each alone.
    void gather_transport() {
        Stopwatch watch;
        PathCounts counts;
        const auto all = static_cast<double>(plan_.points.size());
        KeptTransport kept = trace_transport(paths_, plan_, std::move(*surfaces_), surfaces_options_, options_.seed,
                                             counts, [&](std::size_t points) {
                                                 tell({"gather", static_cast<double>(points) / all});
                                             });
        add_stage("gather", watch.lap(), counts);
        light_from(kept);
        if (options_.keep_transport) result_.kept = std::move(kept);
        const double seconds = watch.seconds();
        if (held_out_.points.empty()) return;
        const ErrorPart total = measure_total(result_.volume, held_out_);
        result_.curve.push_back(
            {seconds, plan_.samples, counts.rays + counts.shadow_rays, total.relrmse, total.interval});
    }

    void light_from(const KeptTransport& kept) {
        const Stopwatch watch;
        tell({"light"});
        const Tracer& tracer = paths_.tracer();
        const Environment& environment = paths_.environment();
        const KeptLight light = options_.layers.empty()
                                    ? light_probes(kept, tracer, environment, result_.volume)
                                    : light_layers(kept, tracer, environment, options_.layers, result_.volume);
        result_.method = Method::cache;
        result_.cache = light.made;
        result_.replicates = GatherOptions{}.replicates;
        result_.noise = noise_at_probes(result_.volume, plan_.batches);
        add_stage("light", watch.seconds(), light.made.counts);
    }

    [[nodiscard]] std::uint64_t rays_gathered() const {
        std::uint64_t rays = 0;
        for (const GatherSums& sums : sums_) rays += sums.counts().rays + sums.counts().shadow_rays;
        return rays;
    }

    void finish() {
        const Stopwatch watch;
        Volume& volume = result_.volume;
        result_.filled = volume.has_cells() ? fill_invalid(volume, paths_.tracer()) : 0;
        const StorageChoice storage = choose_storage(volume);
        if (storage.half) {
            if (!held_out_.points.empty()) unrounded_ = volume;
            store_as_half(volume);
            result_.left_out.push_back({"float coefficients: half serves",
                                        fmt::format("rounding adds at most {} of any brick's standard error",
                                                    rounded_percent(storage.worst_share)),
                                        "half of the bytes"});
        }
        add_stage("finish", watch.seconds(), {});
    }

    void measure() {
        if (held_out_.points.empty()) return;
        Stopwatch watch;
        result_.error = measure_error(result_.volume, held_out_, unrounded_ ? &*unrounded_ : nullptr);
        add_stage("measure", watch.lap(), {});
        if (!options_.compare_look_ups) return;
        result_.look_ups = compare_look_ups(unrounded_ ? *unrounded_ : result_.volume, held_out_, options_.seed);
        add_stage("look-ups", watch.lap(), {});
    }

    /// Where transport is kept, only light that nothing measures is told of: no target can be missed.
    void judge() {
        Evidence evidence{result_.error ? &*result_.error : nullptr, result_.noise.relrmse};
        evidence.points = plan_.points.size() + held_out_.points.size();
        evidence.is_black = is_black(result_.volume.coefficients) && held_out_.a.is_black() && held_out_.b.is_black();
        evidence.is_tested = result_.from_kept || (paths_.lights() & ~result_.counts.tested) == 0;
        evidence.has_light = paths_.lights() != 0;
        evidence.is_shut_out =
            std::any_of(plan_.shut_out.begin(), plan_.shut_out.end(), [](const ShutOut& out) { return out.node >= 0; });
        evidence.is_all_shut_out = is_all_shut_out(paths_, plan_.shut_out);
        evidence.missing_textures = paths_.tracer().scene().missing_textures.size();
        Target target = options_.target;
        if (result_.from_kept) target.samples = plan_.samples;
        result_.verdict = lightgrid::judge(target, evidence);
    }

    void describe() {
        const std::uint32_t per_replicate = plan_.samples / GatherOptions{}.replicates;
        result_.volume.settings = {
            {"level", paths_.tracer().scene().name},
            {"environment", options_.environment.empty() ? "none" : options_.environment},
            {"method", name_of(result_.method)},
            {"samples", fmt::format("{}", per_replicate * result_.replicates)},
            {"replicates", fmt::format("{}", result_.replicates)},
            {"seed", fmt::format("{}", options_.seed)},
            {"spacing", plan_.why_spacing},
        };
    }

    const PathTracer& paths_;
    const BakePlan& plan_;
    const BakeOptions& options_;
    const Progress& progress_;
    BakeResult result_;
    HeldOut held_out_;
    std::optional<SurfaceCache> cache_;
    std::optional<Surfaces> surfaces_;  // it is of, where transport is to be kept, or lit layer by layer
    CacheOptions surfaces_options_;     // of these
    std::vector<GatherSums> sums_;      // by batch
    double measuring_seconds_ = 0;      // of the error, once
    std::optional<Volume> unrounded_;
};

}  // namespace

BakeResult run_bake(const PathTracer& paths, const BakePlan& plan, const BakeOptions& options,
                    const Progress& progress) {
    return Bake(paths, plan, options, progress).run();
}

BakeResult bake_from(const KeptTransport& kept, const PathTracer& paths, const BakePlan& plan,
                     const BakeOptions& options, const Progress& progress) {
    return Bake(paths, plan, options, progress).run_from(kept);
}

}  // namespace lightgrid
