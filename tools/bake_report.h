#pragma once

#include "core/tracer.h"
#include "probes/bake.h"
#include "tools/machine.h"
#include "tools/progress.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>

/// What level-bake says about a bake: before it, after it, and as JSON.
namespace lightgrid {

/// Probes, time, memory, and what is left out and why.
void print_plan(const Messages& messages, const Scene& scene, const Tracer& tracer, const BakePlan& plan,
                const BakeOptions& options);

/// Seconds and rays per stage, standard error, error with its parts, file size.
/// What the plan had left out already is not said again.
void print_result(const Messages& messages, const BakePlan& plan, const BakeResult& result,
                  const std::filesystem::path& output);

/// How level-bake was called, and where.
struct BakeCall {
    std::string command;
    std::string date;  // UTC
    std::filesystem::path output;
    Machine machine;
};

/// The report of `--report-json` and `--json`, and all that `--report` shows but pictures: what was baked and how, error
/// with its parts, curve, what would lower it, look_ups, left_out, stages. report.schema.json describes it.
[[nodiscard]] nlohmann::json bake_report(const Tracer& tracer, const BakePlan& plan, const BakeResult& result,
                                         const BakeOptions& options, const BakeCall& call);

}  // namespace lightgrid
