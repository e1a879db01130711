#include "viewer/renderer.h"

#include "core/sh.h"
#include "probes/half_storage.h"
#include "tools/false_color.h"
#include "viewer/crowd.h"
#include "viewer/dominant_light.h"
#include "viewer/probes_shown.h"

#include <algorithm>
#include <numbers>
#include <utility>

namespace lightgrid {
namespace {

/// As many of them as two panes can ask for, and the two before.
constexpr std::size_t most_light_tables = 4;
/// As it was baked, and as two panes can ask for it, for objects and for the level.
constexpr std::size_t most_stored = 5;

/// Of light that gives every surface the same irradiance E: L_0 = E / (A_0 Y_00) = 2 E / sqrt(pi).
constexpr float uniform_first_coefficient = 2 * std::numbers::inv_sqrtpi_v<float>;

constexpr glm::ivec2 legend_size(134, 220);
const glm::vec3 paper = hex_color(0xF4F2EE);
const glm::vec3 ink = hex_color(0x22252A);

}  // namespace

Renderer::Renderer(const Gl& gl, ShaderSources shaders)
    : gl_(gl),
      shaders_(std::move(shaders)),
      target_(gl, shaders_),
      background_(gl, shaders_),
      balls_(gl, shaders_),
      lines_(gl, shaders_) {}

void Renderer::set_level(const Scene& scene, double longest_edge, const std::vector<bool>& outlines) {
    light_tables_.clear();
    emission_weights_.clear();
    level_.reset();
    level_.emplace(gl_, shaders_, scene, build_level_mesh(scene, longest_edge), outlines);
    origin_ = scene.origin;
    level_size_ = static_cast<float>(glm::length(scene.bounds.size()));
    albedo_ = mean_albedo(scene);
}

void Renderer::set_volume(std::shared_ptr<const LitVolume> volume) {
    light_tables_.clear();
    scales_.reset();
    irradiance_legend_.reset();
    error_legend_.reset();
    stored_.clear();
    stored_.push_back({.volume = std::move(volume)});
}

void Renderer::set_reference(std::shared_ptr<const ReferenceMap> map) {
    reference_ = std::move(map);
    std::erase_if(light_tables_, [](const LightTable& table) { return table.is_difference; });
}

void Renderer::set_environment(const Environment& environment) {
    background_.set_environment(environment);
}

void Renderer::set_object(const ObjectMesh& mesh) {
    object_.emplace(gl_, shaders_, mesh);
}

void Renderer::set_object_transfer(std::span<const float> transfer) {
    object_->set_transfer(transfer);
}

Renderer::Storage Renderer::storage_of(const Settings& settings) const {
    return {.half = settings.half && !stored_.empty() && !stored_.front().volume->volume.half};
}

Renderer::Storage Renderer::level_storage_of(const Settings& settings) const {
    Storage storage = storage_of(settings);
    if (settings.dering) storage.deringed = std::min(settings.bands, max_texture_bands);
    return storage;
}

Renderer::Stored& Renderer::stored(const Storage& storage) {
    const auto known = std::ranges::find_if(stored_, [&](const Stored& one) { return one.storage == storage; });
    if (known != stored_.end()) return *known;
    Volume volume = stored_.front().volume->volume;
    if (storage.half) store_as_half(volume);
    if (storage.deringed > 0) volume = deringed(std::move(volume), storage.deringed);
    stored_.push_back({storage, std::make_shared<const LitVolume>(std::move(volume))});
    return stored_.back();
}

LookUp Renderer::look_up_with(const Settings& settings) {
    return stored_.empty() ? LookUp{} : look_up(*stored(storage_of(settings)).volume, settings);
}

LookUp Renderer::level_look_up(const Settings& settings) {
    return stored_.empty() ? LookUp{} : look_up(*stored(level_storage_of(settings)).volume, settings);
}

PixelLight Renderer::pixel_light(const Settings& settings) {
    Stored& from = stored(level_storage_of(settings));
    const LookUp light = look_up(*from.volume, settings);
    if (!from.on_card) from.on_card = upload_for_pixels(gl_, from.volume->volume, origin_, from.volume->volume.half);
    return {.volume = &*from.on_card, .filter = light.filter, .bands = light.bands, .normal_bias = light.normal_bias};
}

const TexelBuffer& Renderer::light_table(const Settings& settings) {
    const Storage storage = level_storage_of(settings);
    const bool is_difference = settings.level_colors == LevelColors::difference;
    const auto known = std::find_if(light_tables_.begin(), light_tables_.end(), [&](const LightTable& table) {
        return table.filter == settings.filter && table.bands == settings.bands && table.storage == storage &&
               table.is_difference == is_difference;
    });
    if (known != light_tables_.end()) return known->table;
    look_ups_ += 2 * level_->mesh().light_rows;
    if (light_tables_.size() == most_light_tables) light_tables_.erase(light_tables_.begin());
    const std::vector<VertexLight> light =
        is_difference ? differences(settings) : light_level(level_->mesh(), origin_, level_look_up(settings));
    if (!scales_ && !is_difference) scales_ = scales_of(light);
    light_tables_.push_back({settings.filter, settings.bands, storage, is_difference, level_->make_light_table(light),
                             light.size() * sizeof(VertexLight)});
    return light_tables_.back().table;
}

std::vector<VertexLight> Renderer::differences(const Settings& settings) {
    constexpr glm::vec4 unknown(0, 0, 0, -1);
    const LookUp light = level_look_up(settings);
    const std::size_t traced = reference_ == nullptr ? 0 : reference_->traced;
    const std::vector<float> known = traced == 0 ? std::vector<float>() : differences_of(*reference_, origin_, light);
    return light_level(level_->mesh(), origin_, [&](glm::dvec3 position, glm::vec3 normal) {
        if (traced == 0) return unknown;
        const std::span places = std::span(reference_->places).first(traced);
        const auto nearest = nearest_place(places, glm::vec3(position - origin_), normal, level_size_);
        return nearest ? glm::vec4(0, 0, 0, known[*nearest]) : unknown;
    });
}

LevelDrawing::Light Renderer::level_light(const Frame& frame, const Settings& settings, const LookUp& light) {
    LevelDrawing::Light result{
        .kind = settings.level_light, .gain = settings.gain, .emission_weights = emission_weights_};
    if (light.volume == nullptr) {
        result.kind = LevelLight::constant;
        result.constant = glm::vec3(std::numbers::pi_v<float>);
        return result;
    }
    result.constant = light.volume->usual_light;
    const bool data = settings.level_colors != LevelColors::surface;
    // Errors and differences are known at vertices only.
    const bool of_vertices = data && settings.level_colors != LevelColors::irradiance;
    if (of_vertices) result.kind = LevelLight::vertex;
    if (result.kind == LevelLight::vertex || data) result.table = &light_table(settings);
    if (result.kind == LevelLight::pixel) result.pixel = pixel_light(settings);
    if (data) {
        result.colors = FalseColors{settings.level_colors, scale_for(settings.level_colors), settings.tone};
    } else if (frame.object && settings.show_object && settings.contact_shadow && result.kind != LevelLight::none) {
        const Sh9 radiance = radiance_sh(light, frame.object->position);
        const glm::vec3 center(frame.object->position - origin_);
        result.shadow = ObjectShadow{center, 0.5F * frame.object->size, dominant_light(radiance)};
    }
    return result;
}

LogScale Renderer::scale_for(LevelColors what) const {
    if (what == LevelColors::difference) return difference_scale();
    return what == LevelColors::irradiance ? scales_->irradiance : scales_->standard_error;
}

void Renderer::draw_object(const Eye& eye, const Frame& frame, const Settings& settings, const LookUp& light) {
    ObjectLighting lighting{.self_shadowing = settings.self_shadowing, .gain = settings.gain};
    if (frame.reference && settings.object_light == ObjectLight::reference) {
        lighting.radiance = settings.dering ? deringed(*frame.reference) : *frame.reference;
    } else if (light.volume != nullptr && settings.object_light != ObjectLight::constant) {
        lighting.radiance = all_radiance_sh(light, frame.object->position);
        ++look_ups_;
        if (settings.dering) lighting.radiance = deringed(lighting.radiance);
        if (settings.object_light == ObjectLight::pixel) lighting.pixel = pixel_light(settings);
    } else {
        const glm::vec3 irradiance =
            light.volume != nullptr ? light.volume->usual_light : glm::vec3(std::numbers::pi_v<float>);
        lighting.radiance[0] = uniform_first_coefficient * irradiance;
    }
    object_->draw(eye, *frame.object, lighting);
}

/// Probes, cells and the crowd.
void Renderer::draw_data(const Eye& eye, const Frame& frame, const Settings& settings, const LookUp& light) {
    BallLook look{.bands = light.bands, .gain = settings.gain, .tone = settings.tone};
    if (settings.probes != ProbesShown::none) {
        Stored& from = stored(storage_of(settings));
        if (!from.probes) from.probes = balls_.upload(probe_balls(*from.volume, origin_));
        look.before_all = settings.probes == ProbesShown::all;
        balls_.draw(eye, *from.probes, look);
    }
    if (settings.show_crowd) {
        std::vector<Ball> crowd = crowd_at(*light.volume, frame.time_s, origin_);
        light_crowd(light, origin_, crowd);
        balls_.draw(eye, balls_.upload(crowd), {.bands = light.bands, .gain = settings.gain, .rims = false});
    }
    if (settings.show_cell && frame.object) {
        const ShownCell cell = cell_shown(light, frame.object->position, origin_);
        lines_.draw(eye, cell.lines, settings.tone);
        look.before_all = true;
        balls_.draw(eye, balls_.upload(cell.balls), look);
    }
}

void Renderer::draw_legend(const Pane& pane) {
    const LevelColors what = pane.settings.level_colors;
    if (what == LevelColors::surface || (what != LevelColors::difference && !scales_)) return;
    if (pane.part.size.x < 4 * legend_size.x || 2 * pane.part.size.y < 3 * legend_size.y)
        return;  // it would hide too much
    std::optional<LabelDrawing>& legend = what == LevelColors::irradiance       ? irradiance_legend_
                                          : what == LevelColors::standard_error ? error_legend_
                                                                                : difference_legend_;
    if (!legend) {
        Canvas canvas(legend_size.x, legend_size.y, paper);
        lightgrid::draw_legend(canvas, {14, 40}, legend_size.y - 54, scale_for(what),
                               what == LevelColors::irradiance       ? "lux"
                               : what == LevelColors::standard_error ? "std error / E"
                                                                     : "difference / E",
                               ink);
        legend.emplace(gl_, shaders_, canvas);
    }
    legend->draw(pane.part);
}

void Renderer::draw_pane(const Frame& frame, const Pane& pane) {
    const Settings& settings = pane.settings;
    const LookUp light = look_up_with(settings);
    const glm::ivec2 size = pane.part.size;
    const Eye eye = make_eye(frame.pose, frame.lens, static_cast<double>(size.x) / size.y, origin_, exposure_);
    gl_.Viewport(pane.part.corner.x, pane.part.corner.y, size.x, size.y);

    LevelDrawing::Light on_level;
    if (level_) on_level = level_light(frame, settings, light);
    if (level_) level_->draw_opaque(eye, on_level);
    if (object_ && frame.object && settings.show_object) draw_object(eye, frame, settings, light);
    if (settings.background != Background::none) {
        const Sh36 radiance = light.volume != nullptr ? all_radiance_sh(light, frame.pose.eye) : Sh36{};
        if (light.volume != nullptr) ++look_ups_;
        background_.draw(eye, settings.background == Background::picture, frame.environment_turn, radiance);
    }
    if (level_) level_->draw_blended(eye, on_level);
    if (light.volume != nullptr) draw_data(eye, frame, settings, light);
}

void Renderer::draw(const Frame& frame, std::span<const Pane> panes, glm::ivec2 size, int samples) {
    target_.resize(size, samples);
    const Settings& first = panes.front().settings;
    exposure_ = exposure_of(first, look_up_with(first), frame.pose, albedo_);
    look_ups_ = 0;
    // Not while a pane is drawn, which reads them.
    if (stored_.size() > most_stored) stored_.erase(stored_.begin() + 1, stored_.end());
    target_.begin();
    for (const Pane& pane : panes) draw_pane(frame, pane);
    target_.resolve();
    for (const Pane& pane : panes) {
        target_.develop(pane.part, pane.settings.tone);
        draw_legend(pane);
    }
    check_gl(gl_, "drawing a picture");
}

std::size_t Renderer::bytes_of_light() const {
    std::size_t bytes = 0;
    for (const Stored& stored : stored_) {
        const Volume& volume = stored.volume->volume;
        if (stored.on_card) bytes += stored.on_card->bytes;
        bytes += volume.states.size() * sizeof(ProbeState) + volume.coefficients.size() * sizeof(glm::vec3);
    }
    for (const LightTable& table : light_tables_) bytes += table.bytes;
    return bytes;
}

}  // namespace lightgrid
