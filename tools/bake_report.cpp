#include "tools/bake_report.h"

#include "core/parallel.h"
#include "tools/markup.h"
#include "tools/remedies.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

namespace lightgrid {
namespace {

using nlohmann::json;

/// What a reader gets: an unbiased estimate of a square may be negative, an error may not. Squares keep their sign.
ErrorPart shown(const ErrorPart& part) {
    return {std::max(part.relrmse, 0.0), {std::max(part.interval.low, 0.0), std::max(part.interval.high, 0.0)}};
}

json to_json(const ErrorPart& part) {
    const auto [relrmse, interval] = shown(part);
    return {{"relrmse", relrmse}, {"interval", {interval.low, interval.high}}};
}

json to_json(glm::dvec3 v) {
    return {v.x, v.y, v.z};
}

double square(const ErrorPart& part) {
    return part.relrmse * std::abs(part.relrmse);
}

std::string with_interval(const ErrorPart& part) {
    return fmt::format("{} ({} to {})", percent_text(part.relrmse), percent_text(part.interval.low),
                       percent_text(part.interval.high));
}

json error_json(const BakeResult& result) {
    json error;
    error["target_met"] = result.verdict.target_met ? json(*result.verdict.target_met) : json(nullptr);
    if (!result.error) {
        error["relrmse"] = nullptr;
        error["interval"] = nullptr;
        error["not_measured"] = result.no_error_because;
        error["parts"] = {{"noise", to_json(result.noise)},
                          {"bands", nullptr},
                          {"interpolation", nullptr},
                          {"bias", nullptr},
                          {"storage", nullptr}};
        return error;
    }
    const ErrorReport& measured = *result.error;
    error.update(to_json(measured.total));
    error["parts"] = {{"noise", to_json(measured.noise)},
                      {"bands", to_json(measured.bands)},
                      {"interpolation", to_json(measured.interpolation)},
                      {"bias", measured.bias ? to_json(*measured.bias) : json(nullptr)},
                      {"storage", to_json(measured.storage)}};
    error["squares"] = {{"noise", square(measured.noise)},
                        {"bands", square(measured.bands)},
                        {"interpolation", square(measured.interpolation)},
                        {"storage", square(measured.storage)},
                        {"bias", measured.bias ? square(*measured.bias) : 0},
                        {"cross", square(measured.cross)},
                        {"total", square(measured.total)}};
    error["points"] = measured.points;
    error["normals"] = measured.normals;
    error["p50"] = measured.p50;
    error["p95"] = measured.p95;
    error["p99"] = measured.p99;
    error["worst"] = json::array();
    for (const ErrorReport::Worst& worst : measured.worst) {
        error["worst"].push_back({{"position", to_json(worst.position)}, {"relative_error", worst.relative_error}});
    }
    return error;
}

json halving_json(const BakeResult& result, double gather_seconds) {
    const std::optional<Halving> halving = find_halving(result, gather_seconds);
    if (!halving) return nullptr;
    const auto or_null = [](const std::optional<double>& value) { return value ? json(*value) : json(nullptr); };
    return {{"relrmse", halving->relrmse},
            {"floor", halving->floor},
            {"samples_factor", or_null(halving->samples_factor)},
            {"seconds", or_null(halving->seconds)}};
}

json remedies_json(const std::vector<Remedy>& found) {
    json remedies = json::array();
    for (const Remedy& remedy : found) {
        remedies.push_back({{"part", remedy.part},
                            {"change", remedy.change},
                            {"option", remedy.option},
                            {"relrmse", remedy.relrmse},
                            {"assumes", remedy.assumes},
                            {"seconds", remedy.seconds},
                            {"size_factor", remedy.size_factor}});
    }
    return remedies;
}

json look_ups_json(const BakeResult& result) {
    json look_ups = json::array();
    for (const LookUpCost& look_up : result.look_ups) {
        const bool trilinear = look_up.interpolation == Interpolation::trilinear;
        json entry = to_json(look_up.error);
        entry["interpolation"] = trilinear ? "trilinear" : "nearest";
        entry["bands"] = look_up.bands;
        entry["storage"] = look_up.half ? "half" : "float";
        entry["nanoseconds"] = look_up.nanoseconds;
        entry["bytes_per_probe"] = look_up.bytes;
        entry["this_bake"] = trilinear && look_up.bands == result.volume.bands && look_up.half == result.volume.half;
        look_ups.push_back(std::move(entry));
    }
    return look_ups;
}

json machine_json(const Machine& machine) {
    return {{"processor", machine.processor},
            {"logical_processors", machine.logical_processors},
            {"memory_bytes", machine.memory_bytes},
            {"system", machine.system},
            {"built_with", machine.built_with},
            {"libraries", machine.libraries},
            {"threads", thread_count()},
            {"peak_memory_bytes", peak_memory_bytes()}};
}

/// null where --samples fixed everything.
json target_json(const BakePlan& plan, const BakeResult& result, const BakeOptions& options) {
    if (!plan.steering) return nullptr;
    const Steering& steering = *plan.steering;
    json target{{"error", options.target.error ? json(*options.target.error) : json(nullptr)},
                {"seconds", options.target.seconds ? json(*options.target.seconds) : json(nullptr)},
                {"error_without_bands", nullptr},
                {"verdict", result.verdict.sentence},
                {"why_bands", steering.why_bands},
                {"why_refined", steering.why_refined},
                {"expected_bands", steering.bands_error},
                {"rounds", json::array()}};
    if (!options.target.error && !options.target.seconds) target["error_without_bands"] = default_error;
    for (const Round& round : steering.rounds) {
        target["rounds"].push_back(
            {{"probes", round.probes}, {"interpolation", round.interpolation}, {"blocks_divided", round.blocks}});
    }
    return target;
}

void print_left_out(const Messages& messages, std::span<const LeftOut> items) {
    for (const LeftOut& item : items) {
        messages.line(fmt::format("left out   {}: {}; saves {}", item.what, item.evidence, item.saved));
    }
}

/// Grids, samples and bands, and why.
void print_decisions(const Messages& messages, const BakePlan& plan, double metres_per_unit) {
    for (const Grid& grid : plan.volume.grids) {
        const glm::dvec3 spacing = metres_per_unit * grid.spacing;
        messages.line(fmt::format("grid       {} x {} x {} probes, {:.4g} x {:.4g} x {:.4g} m apart", grid.counts.x,
                                  grid.counts.y, grid.counts.z, spacing.x, spacing.y, spacing.z));
    }
    messages.line(fmt::format("spacing    {}", plan.why_spacing));
    if (plan.steering) {
        for (const Round& round : plan.steering->rounds) {
            messages.line(fmt::format("refining   {} probes leave {} of interpolation{}", round.probes,
                                      percent_text(round.interpolation),
                                      round.blocks > 0 ? fmt::format(": {} blocks are divided", round.blocks) : ""));
        }
        if (!plan.steering->why_refined.empty()) messages.line("refined    " + plan.steering->why_refined);
        if (!plan.steering->why_bands.empty()) messages.line("bands      " + plan.steering->why_bands);
    }
    messages.line(fmt::format("probes     {} to gather ({} valid, {} moved), {} inside solids", plan.points.size(),
                              plan.placement.valid, plan.placement.moved, plan.placement.invalid));
    messages.line(fmt::format("samples    {} per probe in {} replicates ({}), {} bands", plan.samples,
                              GatherOptions{}.replicates, plan.why_samples, plan.volume.bands));
}

/// "probes     61,366 in 5 grids, 0.36 to 0.021 m apart; 912 rays each, 3 bands"
std::string probes_in_short(const BakePlan& plan, double metres_per_unit) {
    std::string apart;
    if (plan.volume.has_cells()) {
        const auto widest = [&](const Grid& grid) {
            return metres_per_unit * std::max({grid.spacing.x, grid.spacing.y, grid.spacing.z});
        };
        const auto wider = [&](const Grid& a, const Grid& b) { return widest(a) < widest(b); };
        const auto [finest, coarsest] = std::minmax_element(plan.volume.grids.begin(), plan.volume.grids.end(), wider);
        apart =
            plan.volume.grids.size() == 1 ? " in a grid, " : fmt::format(" in {} grids, ", plan.volume.grids.size());
        apart += fmt::format("{:.2g}", widest(*coarsest));
        if (widest(*finest) < widest(*coarsest)) apart += fmt::format(" to {:.2g}", widest(*finest));
        apart += " m apart";
    }
    return fmt::format("probes     {}{}; {} rays each, {} bands", grouped(plan.points.size()), apart, plan.samples,
                       plan.volume.bands);
}

/// Seconds and rays of all stages.
std::string totals(const std::vector<Stage>& stages) {
    Stage sum;
    for (const Stage& stage : stages) {
        sum.seconds += stage.seconds;
        sum.rays += stage.rays;
    }
    return fmt::format("{}, with {:.3g} million rays", duration_text(sum.seconds),
                       1e-6 * static_cast<double>(sum.rays));
}

void print_stages(const Messages& messages, const BakeResult& result, double metres_per_unit) {
    for (const Stage& stage : result.stages) {
        const double rate = stage.seconds > 0 ? static_cast<double>(stage.rays) * 1e-6 / stage.seconds : 0;
        messages.line(stage.rays == 0
                          ? fmt::format("{:<10} {:8.3f} s", stage.name, stage.seconds)
                          : fmt::format("{:<10} {:8.3f} s  {:8.2f} million rays  {:6.2f} Mrays/s", stage.name,
                                        stage.seconds, static_cast<double>(stage.rays) * 1e-6, rate));
    }
    if (result.cache) {
        messages.line(fmt::format("cache      {} patches of {} samples, {:.3g} m wide, solved in {} sweeps to {:.1e}",
                                  result.cache->patches, result.cache->samples,
                                  metres_per_unit * static_cast<double>(result.cache->width), result.cache->sweeps,
                                  result.cache->residual));
    }
    if (result.filled > 0)
        messages.line(fmt::format("filled     {} invalid probes from their neighbours", result.filled));
}

void print_parts(const Messages& messages, const ErrorReport& error) {
    messages.line(fmt::format("           all but bands {}", with_interval(error.without_bands)));
    messages.line(fmt::format("           noise {}", with_interval(error.noise)));
    messages.line(fmt::format("           bands {}", with_interval(error.bands)));
    messages.line(fmt::format("           interpolation {}", with_interval(error.interpolation)));
    if (error.bias) messages.line(fmt::format("           bias {}", with_interval(*error.bias)));
    messages.line(fmt::format("           storage {}", percent_text(error.storage.relrmse)));
    const auto squared = [](const ErrorPart& part) { return 1e4 * square(part); };
    messages.line(fmt::format(
        "           in squares: {:.3g} noise + {:.3g} bands + {:.3g} interpolation + {:.3g} bias + {:.3g} storage "
        "{} {:.3g} cross = {:.3g} %^2",
        squared(error.noise), squared(error.bands), squared(error.interpolation),
        squared(error.bias.value_or(ErrorPart{})), squared(error.storage), error.cross.relrmse < 0 ? "-" : "+",
        std::abs(squared(error.cross)), squared(error.total)));
}

void print_layers(const Messages& messages, const Volume& volume) {
    constexpr std::size_t few = 4;
    if (volume.layers.size() > few && !messages.verbose()) {
        messages.line(fmt::format("layers     {}", volume.layers.size()));
        return;
    }
    for (const Layer& layer : volume.layers) {
        messages.line(fmt::format("layer      {}: {}, noise {}", layer.name,
                                  bytes_text(static_cast<double>(stored_bytes(volume, layer.coefficients))),
                                  percent_text(layer.noise)));
    }
}

}  // namespace

void print_plan(const Messages& messages, const Scene& scene, const Tracer& tracer, const BakePlan& plan,
                const BakeOptions& options) {
    const glm::dvec3 size = scene.metres_per_unit * scene.bounds.size();
    messages.line(fmt::format("level      {}: {} triangles, {:.4g} x {:.4g} x {:.4g} m, {} punctual lights", scene.name,
                              tracer.triangle_count(), size.x, size.y, size.z, scene.lights.size()));
    messages.line(fmt::format("light      {}{}", options.environment.empty() ? "the level's own" : options.environment,
                              options.environment.empty() ? "" : ", and the level's own"));
    messages.verbose() ? print_decisions(messages, plan, scene.metres_per_unit)
                       : messages.line(probes_in_short(plan, scene.metres_per_unit));
    messages.line(fmt::format("estimate   {}, {} of memory", duration_text(plan.seconds_estimate),
                              bytes_text(plan.bytes_estimate)));
    for (const std::string& line : why_slow(plan, options.target)) messages.line("           " + line);
    if (messages.verbose()) print_left_out(messages, plan.left_out);
}

void print_result(const Messages& messages, const Scene& scene, const BakePlan& plan, const BakeResult& result,
                  const std::filesystem::path& output) {
    if (messages.verbose()) {
        print_stages(messages, result, scene.metres_per_unit);
    } else {
        messages.line("baked in   " + totals(result.stages));
    }
    if (result.counts.dropped > 0) {
        messages.warning(fmt::format("{} samples were not finite and count as black", result.counts.dropped));
    }
    if (messages.verbose() || !result.error) {
        messages.line(fmt::format("noise      {} of the irradiance at the probes (standard error)",
                                  percent_text(result.noise.relrmse)));
    }
    if (result.error) {
        const ErrorReport& error = *result.error;
        messages.line(fmt::format("error      {} relRMSE at {} held-out points, 95 % interval",
                                  with_interval(error.total), error.points));
        if (messages.verbose()) print_parts(messages, error);
        messages.line(fmt::format("           half of all values are within {}, 95 % within {}, 99 % within {}",
                                  percent_text(error.p50), percent_text(error.p95), percent_text(error.p99)));
    } else {
        messages.line("error      " + result.no_error_because);
    }
    print_layers(messages, result.volume);
    if (!result.verdict.sentence.empty()) messages.line("verdict    " + result.verdict.sentence);
    if (messages.verbose()) {
        print_left_out(messages, std::span(result.left_out).subspan(plan.left_out.size()));
    } else if (!result.left_out.empty()) {
        const std::size_t count = result.left_out.size();
        messages.line(fmt::format("left out   {} thing{}: --verbose lists {}", count, count == 1 ? "" : "s",
                                  count == 1 ? "it" : "them"));
    }
    messages.line(fmt::format("written    {} ({})", output.string(),
                              bytes_text(static_cast<double>(std::filesystem::file_size(output)))));
}

json bake_report(const Tracer& tracer, const BakePlan& plan, const BakeResult& result, const BakeOptions& options,
                 const BakeCall& call) {
    const Scene& scene = tracer.scene();
    json report;
    report["version"] = LIGHTGRID_VERSION;
    report["command"] = call.command;
    report["date"] = call.date;
    report["machine"] = machine_json(call.machine);
    report["scene"] = {{"triangles", tracer.triangle_count()}, {"meshes", scene.meshes.size()},
                       {"materials", scene.materials.size()},  {"punctual_lights", scene.lights.size()},
                       {"size", to_json(scene.bounds.size())}, {"metres_per_unit", scene.metres_per_unit}};
    report["level"] = result.volume.settings.at("level");
    report["environment"] = result.volume.settings.at("environment");
    report["output"] = call.output.filename().string();
    report["bytes"] = std::filesystem::file_size(call.output);
    report["storage"] = result.volume.half ? "half" : "float";
    report["bands"] = result.volume.bands;
    report["seed"] = options.seed;
    report["samples"] = plan.samples / GatherOptions{}.replicates * result.replicates;
    report["method"] = name_of(result.method);
    report["transport"] = result.from_kept ? json("kept") : result.kept ? json("traced") : json(nullptr);
    if (result.cache) {
        report["cache"] = {{"patches", result.cache->patches},     {"samples", result.cache->samples},
                           {"cut_cubes", result.cache->cut_cubes}, {"generations", result.cache->generations},
                           {"sweeps", result.cache->sweeps},       {"residual", result.cache->residual},
                           {"width", result.cache->width}};
    }
    report["replicates"] = result.replicates;
    report["why_samples"] = plan.why_samples;
    report["spacing"] = plan.why_spacing;
    report["estimate"] = {{"seconds", plan.seconds_estimate}, {"bytes", plan.bytes_estimate}};
    report["grids"] = json::array();
    for (const Grid& grid : result.volume.grids) {
        report["grids"].push_back({{"origin", to_json(grid.origin)},
                                   {"spacing", to_json(grid.spacing)},
                                   {"counts", {grid.counts.x, grid.counts.y, grid.counts.z}}});
    }
    report["probes"] = {{"gathered", plan.points.size()},
                        {"valid", plan.placement.valid},
                        {"moved", plan.placement.moved},
                        {"invalid", plan.placement.invalid},
                        {"filled", result.filled}};
    report["noise"] = result.noise.relrmse;
    report["layers"] = json::array();
    for (const Layer& layer : result.volume.layers) {
        report["layers"].push_back(
            {{"name", layer.name}, {"bytes", stored_bytes(result.volume, layer.coefficients)}, {"noise", layer.noise}});
    }
    report["error"] = error_json(result);
    report["target"] = target_json(plan, result, options);
    report["curve"] = json::array();
    for (const CurvePoint& point : result.curve) {
        json entry = to_json(ErrorPart{point.relrmse, point.interval});
        entry.update({{"seconds", point.seconds}, {"samples", point.samples}, {"rays", point.rays}});
        report["curve"].push_back(std::move(entry));
    }
    const double gather_seconds = result.curve.empty() ? 0 : result.curve.back().seconds;
    report["halving"] = halving_json(result, gather_seconds);
    report["remedies"] = remedies_json(find_remedies(plan, result, options, gather_seconds, scene.metres_per_unit));
    report["look_ups"] = look_ups_json(result);
    report["left_out"] = json::array();
    for (const LeftOut& item : result.left_out) {
        report["left_out"].push_back({{"what", item.what}, {"evidence", item.evidence}, {"saved", item.saved}});
    }
    report["stages"] = json::array();
    for (const Stage& stage : result.stages) {
        report["stages"].push_back({{"name", stage.name}, {"seconds", stage.seconds}, {"rays", stage.rays}});
    }
    report["rays"] = {
        {"gather", result.counts.rays}, {"shadow", result.counts.shadow_rays}, {"dropped", result.counts.dropped}};
    return report;
}

}  // namespace lightgrid
