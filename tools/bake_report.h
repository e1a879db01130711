#pragma once

#include "core/tracer.h"
#include "probes/bake.h"
#include "tools/progress.h"

#include <nlohmann/json.hpp>

#include <filesystem>

/// What level-bake says about a bake: before it, after it, and as JSON.
namespace lightgrid {

/// Probes, time, memory, and what is left out and why.
void print_plan(const Messages& messages, const Scene& scene, const Tracer& tracer, const BakePlan& plan,
                const BakeOptions& options);

/// Seconds and rays per stage, standard error, error with its parts, file size.
/// What the plan had left out already is not said again.
void print_result(const Messages& messages, const BakePlan& plan, const BakeResult& result,
                  const std::filesystem::path& output);

/// The report of `--report-json` and `--json`: error, curve, left_out, stages, and what was baked.
[[nodiscard]] nlohmann::json bake_report(const BakePlan& plan, const BakeResult& result, const BakeOptions& options,
                                         const std::filesystem::path& output);

}  // namespace lightgrid
