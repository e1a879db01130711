#include "viewer/reference_probe.h"

#include "core/sampling.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace lightgrid {

ReferenceProbe::ReferenceProbe(const PathTracer& paths, int bands)
    : answer_([&paths, bands](const Question& question, const Answer::Turn& turn) {
          trace(paths, bands, question, turn);
      }) {}

void ReferenceProbe::trace(const PathTracer& paths, int bands, const Question& question, const Answer::Turn& turn) {
    GatherOptions options;
    options.bands = bands;
    options.replicates = most_replicates;
    options.samples = most_replicates * samples_per_replicate;
    options.normals = {question.normal};
    GatherSums sums(paths, {glm::vec3(question.position - paths.tracer().scene().origin)}, options);
    for (std::uint32_t target = first_replicates; target <= most_replicates; target *= 2) {
        sums.add_replicates(target - sums.replicates(), [&](std::size_t) { turn.check(); });
        const Gather gathered = sums.result();
        ReferenceLight light;
        light.position = question.position;
        light.normal = question.normal;
        light.irradiance = gathered.irradiance[0];
        light.sh = gathered.coefficients;
        light.samples = sums.replicates() * samples_per_replicate;
        light.last = target == most_replicates;
        turn.tell([&](std::optional<ReferenceLight>& answer) { answer = std::move(light); });
    }
}

Sh36 means(std::span<const Estimate> coefficients) {
    Sh36 sh{};
    for (std::size_t i = 0; i < std::min(sh.size(), coefficients.size()); ++i) sh[i] = glm::vec3(coefficients[i].mean);
    return sh;
}

LightComparison compare(const ReferenceLight& reference, glm::vec3 volume) {
    LightComparison result;
    result.volume = volume;
    result.reference = glm::vec3(reference.irradiance.mean);
    result.reference_error = glm::vec3(reference.irradiance.error);
    const float looked_up = luminance(volume);
    const float traced = luminance(result.reference);
    if (traced > 0) {
        result.relative = looked_up / traced - 1;
    } else if (looked_up != 0) {
        result.relative = std::numeric_limits<float>::infinity();
    }
    return result;
}

}  // namespace lightgrid
