#include "viewer/reference_probe.h"

#include "core/sampling.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace lightgrid {
namespace {

/// Thrown through the gather to end it.
struct Stopped {};

}  // namespace

ReferenceProbe::ReferenceProbe(const PathTracer& paths, int bands)
    : paths_(paths), bands_(bands), thread_([this](const std::stop_token& stop) { work(stop); }) {}

ReferenceProbe::~ReferenceProbe() = default;  // a jthread asks to stop, and waits

void ReferenceProbe::ask(glm::dvec3 position, glm::vec3 normal) {
    {
        const std::lock_guard lock(mutex_);
        question_ = {position, normal, question_.number + 1};
        answer_.reset();
    }
    asked_.notify_one();
}

std::optional<ReferenceLight> ReferenceProbe::take() {
    const std::lock_guard lock(mutex_);
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    return std::exchange(answer_, std::nullopt);
}

void ReferenceProbe::work(const std::stop_token& stop) {
    std::uint64_t answered = 0;
    while (true) {
        Question question;
        {
            std::unique_lock lock(mutex_);
            if (!asked_.wait(lock, stop, [&] { return question_.number != answered; })) return;
            question = question_;
        }
        answered = question.number;
        try {
            answer(stop, question);
        } catch (const Stopped&) {  // as asked
        } catch (...) {
            const std::lock_guard lock(mutex_);
            failure_ = std::current_exception();
        }
    }
}

void ReferenceProbe::answer(const std::stop_token& stop, const Question& question) {
    const auto is_current = [&] {
        const std::lock_guard lock(mutex_);
        return question_.number == question.number;
    };
    GatherOptions options;
    options.bands = bands_;
    options.replicates = most_replicates;
    options.samples = most_replicates * samples_per_replicate;
    options.normals = {question.normal};
    GatherSums sums(paths_, {glm::vec3(question.position - paths_.tracer().scene().origin)}, options);
    for (std::uint32_t target = first_replicates; target <= most_replicates; target *= 2) {
        sums.add_replicates(target - sums.replicates(), [&](std::size_t) {
            if (stop.stop_requested() || !is_current()) throw Stopped();
        });
        const Gather gathered = sums.result();
        ReferenceLight light;
        light.position = question.position;
        light.normal = question.normal;
        light.irradiance = gathered.irradiance[0];
        light.sh = gathered.coefficients;
        light.samples = sums.replicates() * samples_per_replicate;
        light.last = target == most_replicates;
        const std::lock_guard lock(mutex_);
        if (question_.number != question.number) return;
        answer_ = std::move(light);
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
