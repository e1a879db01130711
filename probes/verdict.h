#pragma once

#include "probes/error_report.h"
#include "probes/target.h"

#include <cstddef>
#include <optional>
#include <string>

/// Whether a bake reached its target, in one sentence: a pure function of what was measured.
namespace lightgrid {

/// What a verdict rests on.
struct Evidence {
    const ErrorReport* error = nullptr;  // none: only the noise is known
    double noise = 0;                    // relRMSE over all probes
    std::size_t points = 0;              // where light was gathered: probes, and points of the reference
    bool is_black = false;               // no light came to any of them
    bool is_tested = true;               // rays asked for every light of the level (PathTracer::lights)
    bool has_light = true;               // something shines: the level's own lights, or an environment
    bool is_shut_out = false;            // one mesh keeps a light out (find_shut_out)
    bool is_all_shut_out = false;        // and so it is with every light
    std::size_t missing_textures = 0;    // whose light is not in the reference either
};

struct Verdict {
    bool is_judged = true;           // false: nothing that was measured can tell how good the light is
    std::optional<bool> target_met;  // none: samples or seconds were asked for, which nothing can miss; or not judged
    std::string sentence;  // empty where nothing can be missed, unless no light was found or nothing is judged
};

/// Black samples are no evidence where a light was never asked for: whatever the error is said to be, the target is not
/// met. What shadow rays found dark is dark, and has no relative error to judge by: it counts as met. Nothing is judged
/// where a texture is missing, where nothing shines, where one mesh keeps every light out, or one of them while all is
/// dark.
[[nodiscard]] Verdict judge(const Target& target, const Evidence& evidence);

}  // namespace lightgrid
