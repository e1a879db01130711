#include "viewer/environment_stage.h"

#include "core/error.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <numbers>

namespace lightgrid {
namespace {

constexpr double orbit_s = 12;
constexpr double orbit_radius = 2.2;  // metres
constexpr double orbit_height = 0.5;
constexpr int orbit_keys = 24;

}  // namespace

Flight orbit() {
    Flight flight;
    for (int i = 0; i <= orbit_keys; ++i) {
        const double angle = 2 * std::numbers::pi * i / orbit_keys;
        FlightKey key;
        key.time_s = orbit_s * i / orbit_keys;
        key.eye = {orbit_radius * std::sin(angle), orbit_height, orbit_radius * std::cos(angle)};
        key.look_at = glm::dvec3(0);
        key.object = glm::dvec3(0);
        flight.keys.push_back(key);
    }
    return flight;
}

Lens orbit_lens() {
    return {.vertical_angle_deg = 45, .near = 0.02, .far = 1000};
}

EnvironmentStage::EnvironmentStage(EnvironmentShow show, Renderer& renderer, Session& session, Tell tell)
    : show_(std::move(show)),
      renderer_(renderer),
      session_(session),
      tell_(std::move(tell)),
      reference_(reference_environment(show_.environment)),
      tried_(show_.file) {
    session_.environment = show_.choice;
    session_.bands = most_bands;
    session_.settings.bands = std::min(session_.settings.bands, most_bands);
    session_.object_mode = ObjectMode::stays;
    session_.object = {};
    session_.motion.speed = 1;
    session_.lens = orbit_lens();
    if (!session_.flight) {
        session_.flight = orbit();
        session_.pose = evaluate(*session_.flight, 0).pose;
    }
    renderer_.set_environment(show_.environment);
}

EnvironmentStage::Loaded EnvironmentStage::load_whole(const std::filesystem::path& file,
                                                      const EnvironmentOptions& options) {
    Loaded loaded;
    loaded.file = file;
    try {
        loaded.environment = load_environment(file, options).environment;
        loaded.reference = reference_environment(loaded.environment);
    } catch (const Error& error) {
        loaded.problem = error.what();
    }
    return loaded;
}

void EnvironmentStage::load(const std::filesystem::path& file) {
    if (loading_.valid()) return;
    tried_ = file;
    loading_ = std::async(std::launch::async, &EnvironmentStage::load_whole, file, show_.options);
}

void EnvironmentStage::load_next() {
    if (loading_.valid()) return;
    if (tried_.empty()) {
        tell_("this light is from no file: drop one on the window");
    } else if (const std::optional<std::filesystem::path> next = next_environment(tried_)) {
        load(*next);
    } else {
        tell_(fmt::format("{}: there is no other .hdr or .exr file in its folder", tried_.string()));
    }
}

void EnvironmentStage::update() {
    if (loading_.valid() && loading_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
        Loaded loaded = loading_.get();
        if (!loaded.problem.empty()) {
            tell_(loaded.problem);
        } else {
            show_.environment = std::move(loaded.environment);
            show_.file = loaded.file;
            show_.name = loaded.file.filename().string();
            reference_ = loaded.reference;
            renderer_.set_environment(show_.environment);
            shown_.reset();
            tell_(show_.name);
        }
    }
    const EnvironmentChoice& choice = *session_.environment;
    if (shown_ == choice) return;
    if (!shown_ || shown_->samples != choice.samples || shown_->sampling != choice.sampling) {
        sampled_ = sample_environment(show_.environment, choice.samples, choice.sampling);
    }
    volume_ = volume_of(turned(sampled_, choice.turned_deg));
    renderer_.set_volume(volume_);
    shown_ = choice;
}

void EnvironmentStage::complete(Frame& frame) const {
    frame.reference = turned(reference_, session_.environment->turned_deg);
}

void EnvironmentStage::complete(Facts& facts) const {
    facts.volume = volume_;
    facts.object_reference = "2^18 samples";
    facts.environment = EnvironmentFacts{show_.file.empty() ? show_.name : show_.file.string(), loading_.valid(),
                                         irradiance_difference(sampled_, reference_)};
}

}  // namespace lightgrid
