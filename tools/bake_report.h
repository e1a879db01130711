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

/// Level, light, probes, time and memory; where messages are verbose, every decision and why, and what is left out.
void print_plan(const Messages& messages, const Scene& scene, const Tracer& tracer, const BakePlan& plan,
                const BakeOptions& options);

/// What it took, how wrong the volume is, the verdict, how many things were left out, and the file; where messages are
/// verbose, stages, parts of the error, and what was left out since the plan was printed.
void print_result(const Messages& messages, const Scene& scene, const BakePlan& plan, const BakeResult& result,
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
