#include "tools/bake_report.h"

#include <fmt/format.h>

namespace lightgrid {
namespace {

using nlohmann::json;

json to_json(const ErrorPart& part) {
    return {{"relrmse", part.relrmse}, {"interval", {part.interval.low, part.interval.high}}};
}

std::string percent(double share) {
    return fmt::format("{:.2f} %", 100 * share);
}

std::string with_interval(const ErrorPart& part) {
    return fmt::format("{} ({} to {})", percent(part.relrmse), percent(part.interval.low), percent(part.interval.high));
}

json error_json(const BakeResult& result) {
    json error;
    error["target_met"] = nullptr;
    if (!result.error) {
        error["relrmse"] = nullptr;
        error["interval"] = nullptr;
        error["not_measured"] = result.no_error_because;
        error["parts"] = {{"noise", to_json(result.noise)},
                          {"bands", nullptr},
                          {"interpolation", nullptr},
                          {"storage", nullptr},
                          {"bias", nullptr}};
        return error;
    }
    const ErrorReport& measured = *result.error;
    error["relrmse"] = measured.total.relrmse;
    error["interval"] = {measured.total.interval.low, measured.total.interval.high};
    error["parts"] = {{"noise", to_json(measured.noise)},
                      {"bands", to_json(measured.bands)},
                      {"interpolation", to_json(measured.interpolation)},
                      {"storage", to_json(measured.storage)},
                      {"bias", measured.bias ? to_json(*measured.bias) : json(nullptr)}};
    error["points"] = measured.points;
    error["normals"] = measured.normals;
    error["p50"] = measured.p50;
    error["p95"] = measured.p95;
    error["p99"] = measured.p99;
    error["worst"] = json::array();
    for (const ErrorReport::Worst& worst : measured.worst) {
        error["worst"].push_back({{"position", {worst.position.x, worst.position.y, worst.position.z}},
                                  {"relative_error", worst.relative_error}});
    }
    return error;
}

void print_left_out(const Messages& messages, const LeftOut& item) {
    messages.line(fmt::format("left out   {}: {}; saves {}", item.what, item.evidence, item.saved));
}

}  // namespace

void print_plan(const Messages& messages, const Scene& scene, const Tracer& tracer, const BakePlan& plan,
                const BakeOptions& options) {
    const glm::dvec3 size = scene.bounds.size();
    messages.line(fmt::format("level      {}: {} triangles, {:.4g} x {:.4g} x {:.4g} m, {} punctual lights", scene.name,
                              tracer.triangle_count(), size.x, size.y, size.z, scene.lights.size()));
    messages.line(fmt::format("light      {}{}", options.environment.empty() ? "the level's own" : options.environment,
                              options.environment.empty() ? "" : ", and the level's own"));
    for (const Grid& grid : plan.volume.grids) {
        messages.line(fmt::format("grid       {} x {} x {} probes, {:.4g} x {:.4g} x {:.4g} m apart", grid.counts.x,
                                  grid.counts.y, grid.counts.z, grid.spacing.x, grid.spacing.y, grid.spacing.z));
    }
    messages.line(fmt::format("spacing    {}", plan.why_spacing));
    messages.line(fmt::format("probes     {} to gather ({} valid, {} moved), {} inside solids", plan.points.size(),
                              plan.placement.valid, plan.placement.moved, plan.placement.invalid));
    messages.line(fmt::format("samples    {} per probe in {} replicates ({}), {} bands", plan.samples,
                              GatherOptions{}.replicates, plan.why_samples, options.bands));
    messages.line(fmt::format("estimate   {}, {} of memory", duration_text(plan.seconds_estimate),
                              bytes_text(plan.bytes_estimate)));
    for (const LeftOut& item : plan.left_out) print_left_out(messages, item);
}

void print_result(const Messages& messages, const BakePlan& plan, const BakeResult& result,
                  const std::filesystem::path& output) {
    for (const Stage& stage : result.stages) {
        const double rate = stage.seconds > 0 ? static_cast<double>(stage.rays) * 1e-6 / stage.seconds : 0;
        messages.line(stage.rays == 0
                          ? fmt::format("{:<10} {:8.3f} s", stage.name, stage.seconds)
                          : fmt::format("{:<10} {:8.3f} s  {:8.2f} million rays  {:6.2f} Mrays/s", stage.name,
                                        stage.seconds, static_cast<double>(stage.rays) * 1e-6, rate));
    }
    if (result.cache) {
        messages.line(fmt::format("cache      {} patches of {} samples, {:.3g} m wide, solved in {} sweeps to {:.1e}",
                                  result.cache->patches, result.cache->samples, plan.cache.width, result.cache->sweeps,
                                  result.cache->residual));
    }
    if (result.counts.dropped > 0) {
        messages.warning(fmt::format("{} samples were not finite and count as black", result.counts.dropped));
    }
    if (result.filled > 0)
        messages.line(fmt::format("filled     {} invalid probes from their neighbours", result.filled));
    messages.line(
        fmt::format("noise      {} of the irradiance at the probes (standard error)", percent(result.noise.relrmse)));
    if (result.error) {
        const ErrorReport& error = *result.error;
        messages.line(fmt::format("error      {} relRMSE at {} held-out points, 95 % interval",
                                  with_interval(error.total), error.points));
        messages.line(fmt::format("           noise {}", with_interval(error.noise)));
        messages.line(fmt::format("           bands {}", with_interval(error.bands)));
        messages.line(fmt::format("           interpolation {}", with_interval(error.interpolation)));
        if (error.bias) messages.line(fmt::format("           bias {}", with_interval(*error.bias)));
        messages.line(fmt::format("           storage {}", percent(error.storage.relrmse)));
        messages.line(fmt::format("           half of all values are within {}, 95 % within {}, 99 % within {}",
                                  percent(error.p50), percent(error.p95), percent(error.p99)));
    } else {
        messages.line("error      " + result.no_error_because);
    }
    for (std::size_t i = plan.left_out.size(); i < result.left_out.size(); ++i)
        print_left_out(messages, result.left_out[i]);
    messages.line(fmt::format("written    {} ({})", output.string(),
                              bytes_text(static_cast<double>(std::filesystem::file_size(output)))));
}

json bake_report(const BakePlan& plan, const BakeResult& result, const BakeOptions& options,
                 const std::filesystem::path& output) {
    json report;
    report["level"] = result.volume.settings.at("level");
    report["environment"] = result.volume.settings.at("environment");
    report["output"] = output.filename().string();
    report["bytes"] = std::filesystem::file_size(output);
    report["bands"] = options.bands;
    report["seed"] = options.seed;
    report["samples"] = plan.samples;
    report["method"] = name_of(plan.method);
    if (result.cache) {
        report["cache"] = {{"patches", result.cache->patches},
                           {"samples", result.cache->samples},
                           {"cut_cubes", result.cache->cut_cubes},
                           {"generations", result.cache->generations},
                           {"sweeps", result.cache->sweeps},
                           {"residual", result.cache->residual},
                           {"width", plan.cache.width}};
    }
    report["spacing"] = plan.why_spacing;
    report["estimate"] = {{"seconds", plan.seconds_estimate}, {"bytes", plan.bytes_estimate}};
    report["grids"] = json::array();
    for (const Grid& grid : result.volume.grids) {
        report["grids"].push_back({{"origin", {grid.origin.x, grid.origin.y, grid.origin.z}},
                                   {"spacing", {grid.spacing.x, grid.spacing.y, grid.spacing.z}},
                                   {"counts", {grid.counts.x, grid.counts.y, grid.counts.z}}});
    }
    report["probes"] = {{"gathered", plan.points.size()},
                        {"valid", plan.placement.valid},
                        {"moved", plan.placement.moved},
                        {"invalid", plan.placement.invalid},
                        {"filled", result.filled}};
    report["noise"] = result.noise.relrmse;
    report["error"] = error_json(result);
    report["curve"] = json::array();
    for (const CurvePoint& point : result.curve) {
        report["curve"].push_back({{"seconds", point.seconds},
                                   {"samples", point.samples},
                                   {"rays", point.rays},
                                   {"relrmse", point.relrmse},
                                   {"interval", {point.interval.low, point.interval.high}}});
    }
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
