#pragma once

#include "probes/error_report.h"
#include "probes/target.h"

#include <optional>
#include <string>

/// Whether a bake reached its target, in one sentence: a pure function of what was measured.
namespace lightgrid {

/// What a verdict rests on.
struct Evidence {
    const ErrorReport* error = nullptr;  // none: only the noise is known
    double noise = 0;                    // relRMSE over all probes
};

struct Verdict {
    std::optional<bool> target_met;  // none: samples or seconds were asked for, which nothing can miss
    std::string sentence;            // empty as well then
};

[[nodiscard]] Verdict judge(const Target& target, const Evidence& evidence);

}  // namespace lightgrid
