#include "viewer/level_stage.h"

#include "core/environment_file.h"
#include "core/error.h"
#include "core/sh.h"
#include "tools/level_options.h"
#include "viewer/environment_light.h"
#include "viewer/outlines.h"

#include <fmt/format.h>
#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

namespace lightgrid {
namespace {

/// A volume that is baked while one looks is no larger than that a person waits for it.
constexpr std::int64_t probes_while_shown = 8192;
/// An object that has moved by this share of its size is at another place.
constexpr double same_place = 0.02;
/// Of the level's diagonal: how far apart the worst places are, and from how far they are looked at.
constexpr double worst_apart = 0.05;
constexpr double look_from = 0.08;
constexpr std::size_t most_worst = 16;

/// An eye that looks at a place of a surface, aslant, from where there is most room.
Pose in_sight_of(const Tracer& tracer, const MapPlace& place, float distance) {
    const glm::vec3 aside = glm::normalize(
        glm::cross(place.normal, std::abs(place.normal.y) < 0.7F ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0)));
    const glm::vec3 along = glm::cross(place.normal, aside);
    glm::vec3 best = place.normal;
    float most = 0;
    for (int i = 0; i < 8; ++i) {
        const float angle = static_cast<float>(i) * glm::pi<float>() / 4;
        const glm::vec3 way = glm::normalize(place.normal + 0.7F * (std::cos(angle) * aside + std::sin(angle) * along));
        const Hit hit = tracer.closest_hit(place.position, way, distance);
        const float free = hit.found() ? hit.distance : distance;
        if (free > most) {
            most = free;
            best = way;
        }
    }
    const glm::dvec3 target = tracer.scene().origin + glm::dvec3(place.position);
    return looking_at(target + 0.8 * most * glm::dvec3(best), target);
}

}  // namespace

void LevelStage::Reference::ask(const PathTracer& paths, glm::dvec3 position, glm::vec3 normal) {
    if (!probe) probe.emplace(paths, reference_bands);
    probe->ask(position, normal);
    asked = position;
}

void LevelStage::Reference::update() {
    if (!probe) return;
    if (std::optional<ReferenceLight> better = probe->take()) light = std::move(better);
}

LevelStage::LevelStage(LevelShow show, Renderer& renderer, Session& session, Tell tell)
    : show_(std::move(show)),
      scene_(show_.paths.tracer().scene()),
      renderer_(renderer),
      session_(session),
      tell_(std::move(tell)) {
    const double diagonal = glm::length(scene_.bounds.size());
    session_.motion.speed = 0.1 * diagonal;
    session_.object.size = static_cast<float>(0.03 * diagonal);
    session_.lens = lens_for(diagonal, session_.object.size);
    if (!session_.flight)
        session_.pose = looking_at(scene_.bounds.center(), scene_.bounds.center() + glm::dvec3(0, 0, -1));
    renderer_.set_environment(show_.paths.environment());
    if (show_.volume != nullptr) {
        take(show_.volume);
        return;
    }
    renderer_.set_level(scene_, std::numeric_limits<double>::infinity(),
                        std::vector<bool>(scene_.materials.size(), false));
    BakeOptions options;
    options.placement.max_probes = probes_while_shown;
    options.environment = show_.environment;
    bake_.emplace(show_.paths, options);
}

LevelStage::~LevelStage() = default;

void LevelStage::take(const std::shared_ptr<const LitVolume>& volume) {
    if (spacing_ != volume->spacing) {
        renderer_.set_level(scene_, volume->spacing, find_outlines(show_.paths.tracer(), volume->volume));
        spacing_ = volume->spacing;
    }
    baked_ = volume;
    summary_ = summarize(volume->volume);
    session_.bands = std::clamp(volume->volume.bands, 1, most_bands);
    LayerMix as_baked = mix_of(volume->volume, !show_.paths.environment().is_black());
    if (as_baked != mix_as_baked_) session_.layers = as_baked;
    mix_as_baked_ = std::move(as_baked);
    mix();
    if (default_flight_known_) return;
    default_flight_known_ = true;
    default_flight_ = std::async(
        std::launch::async, [&tracer = show_.paths.tracer(), volume] { return make_default_flight(tracer, *volume); });
}

void LevelStage::show_sky(SkyShown shown) {
    Environment sky = show_.paths.environment();
    if (shown == SkyShown::uniform) sky = Environment::uniform(glm::vec3(1));
    if (shown == SkyShown::file) {
        if (sky_of_file_.is_black()) tell_("drop an .hdr or .exr file on the window: until then the sky is black");
        sky = sky_of_file_;
    }
    sky_radiance_ = reference_environment(sky);
    renderer_.set_environment(sky);
    sky_shown_ = shown;
}

void LevelStage::mix() {
    const LayerMix& wanted = session_.layers;
    const Volume& volume = baked_->volume;
    if (const LayerKnob* sky = find_sky(session_.layers)) {
        const SkyShown shown = sky->weight > 0 ? wanted.sky : SkyShown::given;
        if (sky_shown_ != shown) show_sky(shown);
    }
    volume_ = baked_;
    if (wanted != mix_as_baked_) {
        volume_ = std::make_shared<const LitVolume>(mixed_volume(volume, weights_of(wanted, volume, sky_radiance_)));
    }
    renderer_.set_volume(volume_);
    std::vector<glm::vec3> emission;
    for (const Material& material : scene_.materials) {
        const std::string_view group =
            material.group < 0 ? std::string_view() : scene_.groups[static_cast<std::size_t>(material.group)];
        emission.push_back(emission_weight(wanted, group));
    }
    renderer_.set_emission_weights(std::move(emission));
    mixed_ = wanted;
}

void LevelStage::take_sky(const std::filesystem::path& file) {
    LayerKnob* sky = find_sky(session_.layers);
    if (sky == nullptr) {
        tell_(fmt::format("{}: this volume keeps the sky that it was baked with; level-bake --layers sky has others",
                          file.string()));
        return;
    }
    try {
        sky_of_file_ = load_environment(file).environment;
        session_.layers.sky = SkyShown::file;
        if (sky->weight == 0) sky->weight = 1;
        sky_shown_.reset();
        mix();
        tell_(fmt::format("{} is the sky now", file.filename().string()));
    } catch (const Error& error) {
        tell_(error.what());
    }
}

void LevelStage::next_sky() {
    LayerMix& mix = session_.layers;
    LayerKnob* sky = find_sky(mix);
    if (sky == nullptr) {
        tell_("a level keeps the environment that it was baked with; level-bake --layers sky lights it by any");
    } else if (sky->weight == 0) {
        sky->weight = 1;
    } else {
        std::vector<SkyShown> skies{SkyShown::uniform};
        if (!show_.paths.environment().is_black()) skies.push_back(SkyShown::given);
        if (!sky_of_file_.is_black()) skies.push_back(SkyShown::file);
        const auto shown = std::find(skies.begin(), skies.end(), mix.sky);
        mix.sky = shown == skies.end() || shown + 1 == skies.end() ? skies.front() : shown[1];
    }
}

void LevelStage::update() {
    if (bake_) {
        if (std::optional<BakedVolume> baked = bake_->take()) {
            tell_(fmt::format("baked with {} rays a probe, noise {:.2g} %", baked->samples, 100 * baked->noise));
            take(std::make_shared<const LitVolume>(std::move(baked->volume)));
        }
    }
    if (show_.watch) {
        if (std::optional<VolumeWatch::News> news = show_.watch->poll()) {
            if (news->volume) {
                const std::vector<std::string> other = settings_that_differ(baked_->volume, *news->volume);
                if (!other.empty()) {
                    news->notice +=
                        fmt::format("; it was baked with other settings than what is shown ({}): start anew",
                                    fmt::join(other, ", "));
                }
                take(std::make_shared<const LitVolume>(std::move(*news->volume)));
            }
            tell_(news->notice);
        }
    }
    if (default_flight_.valid() && default_flight_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
        DefaultFlight found = default_flight_.get();
        session_.object.size = static_cast<float>(found.object_size);
        session_.lens = lens_for(glm::length(scene_.bounds.size()), found.object_size);
        session_.motion.speed = 4 * found.object_size;
        if (!session_.flight) {
            session_.flight = std::move(found.flight);
            if (!session_.touched) start_flight(session_);
        }
    }
    if (baked_ != nullptr && session_.layers != mixed_) mix();
    at_click_.update();
    follow_object();
    follow_map();
}

void LevelStage::follow_map() {
    const std::vector<Side> sides = sides_of(session_);
    map_is_wanted_ = map_is_wanted_ || std::any_of(sides.begin(), sides.end(), [](const Side& side) {
                         return side.settings.level_colors == LevelColors::difference;
                     });
    if (!map_is_wanted_ || baked_ == nullptr) return;
    if (!map_tracer_) {
        map_tracer_.emplace([&paths = show_.paths](const MapQuestion& question, const auto& turn) {
            ReferenceMap map;
            map.places = choose_map_places(paths.tracer(), question.volume->volume, map_places);
            trace_map(
                paths, std::move(map),
                [&](const ReferenceMap& known) {
                    turn.tell([&](auto& news) { news = std::make_shared<const ReferenceMap>(known); });
                },
                [&] { turn.check(); });
        });
        // The light of the path tracer does not depend on the volume: another one of the level needs no other map.
        map_tracer_->ask({baked_});
    }
    if (std::optional<std::shared_ptr<const ReferenceMap>> known = map_tracer_->take()) {
        map_ = std::move(*known);
    }
    std::shared_ptr<const ReferenceMap> valid = session_.layers == mix_as_baked_ ? map_ : nullptr;
    if (valid == map_shown_) return;
    map_shown_ = std::move(valid);
    renderer_.set_reference(map_shown_);
}

void LevelStage::show_next_worst() {
    map_is_wanted_ = true;
    if (session_.layers != mix_as_baked_) {
        tell_("the path tracer knows the light as it was baked only: set the layers back");
        return;
    }
    if (map_ == nullptr) {
        tell_("the path tracer looks for where the volume is worst: ask again in a few seconds");
        return;
    }
    const double diagonal = glm::length(scene_.bounds.size());
    const LookUp light = renderer_.level_look_up(session_.settings);
    const std::vector<float> differences = differences_of(*map_, scene_.origin, light);
    const std::vector<std::size_t> worst = worst_places(*map_, differences, worst_apart * diagonal, most_worst);
    if (worst.empty()) {
        tell_("no place is known to differ");
        return;
    }
    const auto is_new = [&](std::size_t i) {
        return std::none_of(worst_shown_.begin(), worst_shown_.end(), [&](glm::vec3 shown) {
            return glm::distance(shown, map_->places[i].position) < worst_apart * diagonal;
        });
    };
    auto next = std::find_if(worst.begin(), worst.end(), is_new);
    if (next == worst.end()) {
        worst_shown_.clear();
        next = worst.begin();
    }
    const MapPlace& place = map_->places[*next];
    worst_shown_.push_back(place.position);
    const glm::dvec3 position = scene_.origin + glm::dvec3(place.position);
    session_.pose = in_sight_of(show_.paths.tracer(), place, static_cast<float>(look_from * diagonal));
    session_.touched = true;
    session_.flown_s.reset();
    clicked_surface_ = true;
    at_click_.light.reset();
    at_click_.ask(show_.paths, position, place.normal);
    tell_(fmt::format("worst place {} of {}, at {:.2f} {:.2f} {:.2f}: {:.3g} lux, {:.3g} by the path tracer{}",
                      next - worst.begin() + 1, worst.size(), position.x, position.y, position.z,
                      luminance(surface_irradiance(light, position, place.normal)),
                      luminance(glm::vec3(place.irradiance.mean)),
                      map_->last ? "" : "; there may be worse, more is being traced"));
}

void LevelStage::follow_object() {
    at_object_.update();
    const std::vector<Side> sides = sides_of(session_);
    const bool wanted = std::any_of(sides.begin(), sides.end(), [](const Side& side) {
        return side.settings.object_light == ObjectLight::reference;
    });
    if (!wanted) return;
    // An object that keeps moving is asked for once the last answer is there, so that there is always one to come.
    const bool waiting = at_object_.asked && (!at_object_.light || at_object_.light->position != *at_object_.asked);
    const bool moved = !at_object_.asked ||
                       glm::distance(*at_object_.asked, session_.object.position) > same_place * session_.object.size;
    if (moved && !waiting) at_object_.ask(show_.paths, session_.object.position, {0, 1, 0});
}

void LevelStage::ask(const Click& click) {
    glm::dvec3 position = session_.pose.eye + follow_sizes * session_.object.size * click.direction;
    glm::vec3 normal(-click.direction);
    clicked_surface_ = false;
    if (click.on_object) {
        position = session_.object.position;
    } else {
        const glm::vec3 direction(click.direction);
        const Tracer& tracer = show_.paths.tracer();
        const Hit hit = tracer.closest_hit(glm::vec3(session_.pose.eye - scene_.origin), direction);
        if (hit.found()) {
            const Surface surface = tracer.surface(hit, direction);
            normal = glm::dot(surface.normal, direction) < 0 ? surface.normal : -surface.normal;
            position = scene_.origin + glm::dvec3(surface.leave(normal));
            clicked_surface_ = true;
        }
    }
    at_click_.light.reset();
    at_click_.ask(show_.paths, position, normal);
}

void LevelStage::forget_click() {
    at_click_.asked.reset();
    at_click_.light.reset();
}

void LevelStage::complete(Frame& frame) const {
    if (at_object_.light) frame.reference = means(at_object_.light->sh);
    frame.environment_turn = glm::mat3(turn_about_up(session_.layers.sky_turned_deg));
}

std::optional<ClickedLight> LevelStage::clicked_light() const {
    if (!at_click_.asked) return {};
    ClickedLight clicked;
    clicked.position = *at_click_.asked;
    clicked.on_surface = clicked_surface_;
    if (!at_click_.light || volume_ == nullptr) return clicked;
    const ReferenceLight& light = *at_click_.light;
    clicked.samples = light.samples;
    clicked.last = light.last;
    const LookUp from =
        clicked_surface_ ? renderer_.level_look_up(session_.settings) : look_up(*volume_, session_.settings);
    const double bias = clicked_surface_ ? from.normal_bias : 0;
    clicked.volume = all_radiance_sh(from, light.position + bias * glm::dvec3(light.normal));
    if (session_.settings.dering && !clicked_surface_) clicked.volume = deringed(clicked.volume);
    clicked.reference = means(light.sh);
    clicked.irradiance =
        compare(light, glm::max(irradiance_from_sh(std::span<const glm::vec3>(clicked.volume), light.normal), 0.0F));
    return clicked;
}

void LevelStage::complete(Facts& facts) const {
    facts.volume = volume_;
    facts.summary = summary_;
    facts.metres_per_unit = scene_.metres_per_unit;
    if (bake_) {
        const BackgroundBake::Status status = bake_->status();
        if (status.working && status.samples == 0) facts.baking = "looks for places of probes";
        if (status.working && status.samples > 0) {
            facts.baking = fmt::format("{} rays a probe, {:.0f} %", status.samples, 100 * status.share);
        }
    }
    if (map_is_wanted_) {
        facts.map = session_.layers != mix_as_baked_ ? "of the light as baked only"
                    : map_ == nullptr                ? "being traced"
                                      : fmt::format("{} of {} places{}", map_->traced, map_->places.size(),
                                                    map_->last ? "" : " so far");
    }
    if (at_object_.asked) {
        facts.object_reference = at_object_.light ? fmt::format("{} rays", at_object_.light->samples) : "being traced";
    }
    facts.clicked = clicked_light();
}

}  // namespace lightgrid
