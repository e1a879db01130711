#include "viewer/renderer.h"

#include "probes/half_storage.h"
#include "viewer/exposure.h"

#include <algorithm>
#include <numbers>
#include <utility>

namespace lightgrid {
namespace {

/// As many of them as two panes can ask for, and the two before.
constexpr std::size_t most_light_tables = 4;

}  // namespace

Renderer::Renderer(const Gl& gl, ShaderSources shaders)
    : gl_(gl), shaders_(std::move(shaders)), target_(gl, shaders_), background_(gl, shaders_) {}

void Renderer::set_level(const Scene& scene, double longest_edge, const std::vector<bool>& outlines) {
    light_tables_.clear();
    level_.reset();
    level_.emplace(gl_, shaders_, scene, build_level_mesh(scene, longest_edge), outlines);
    origin_ = scene.origin;
}

void Renderer::set_volume(std::shared_ptr<const LitVolume> volume) {
    light_tables_.clear();
    half_volume_.reset();
    volume_ = std::move(volume);
}

void Renderer::set_environment(const Environment& environment) {
    background_.set_environment(environment);
}

void Renderer::set_object(const ObjectMesh& mesh) {
    object_.reset();
    object_.emplace(gl_, shaders_, mesh);
}

const LitVolume* Renderer::volume(const Settings& settings) {
    if (!settings.half || volume_ == nullptr || volume_->volume.half) return volume_.get();
    if (half_volume_ == nullptr) {
        Volume rounded = volume_->volume;
        store_as_half(rounded);
        half_volume_ = std::make_shared<const LitVolume>(std::move(rounded));
    }
    return half_volume_.get();
}

LookUp Renderer::look_up_with(const Settings& settings) {
    const LitVolume* lit = volume(settings);
    return lit == nullptr ? LookUp{} : look_up(*lit, settings);
}

const TexelBuffer& Renderer::light_table(const Settings& settings) {
    const auto known = std::find_if(light_tables_.begin(), light_tables_.end(), [&](const LightTable& table) {
        return table.filter == settings.filter && table.bands == settings.bands && table.half == settings.half;
    });
    if (known != light_tables_.end()) return known->table;
    look_ups_ += 2 * level_->mesh().light_rows;
    if (light_tables_.size() == most_light_tables) light_tables_.erase(light_tables_.begin());
    light_tables_.push_back({settings.filter, settings.bands, settings.half,
                             level_->make_light_table(light_level(level_->mesh(), origin_, look_up_with(settings))),
                             level_->mesh().light_rows * sizeof(VertexLight)});
    return light_tables_.back().table;
}

void Renderer::draw_pane(const Frame& frame, const Pane& pane) {
    const Settings& settings = pane.settings;
    const LookUp light = look_up_with(settings);
    const glm::ivec2 size = pane.part.size;
    const Eye eye = make_eye(frame.pose, frame.lens, static_cast<double>(size.x) / size.y, origin_, exposure_);
    gl_.Viewport(pane.part.corner.x, pane.part.corner.y, size.x, size.y);

    LevelDrawing::Light level_light{.kind = settings.level_light, .gain = settings.gain};
    level_light.constant = light.volume != nullptr ? light.volume->usual_light : glm::vec3(std::numbers::pi_v<float>);
    if (level_ && light.volume == nullptr) level_light.kind = LevelLight::constant;
    if (level_ && level_light.kind == LevelLight::vertex) level_light.table = &light_table(settings);

    if (level_) level_->draw_opaque(eye, level_light);
    if (object_ && frame.object && settings.show_object) {
        Sh36 irradiance{};
        if (frame.reference && settings.object_light == ObjectLight::reference) {
            irradiance = irradiance_sh(*frame.reference, settings.dering);
        } else if (light.volume != nullptr && settings.object_light != ObjectLight::constant) {
            irradiance = irradiance_sh(all_radiance_sh(light, frame.object->position), settings.dering);
            ++look_ups_;
        } else {
            irradiance[0] = level_light.constant / 0.282095F;
        }
        for (glm::vec3& coefficient : irradiance) coefficient *= settings.gain;
        object_->draw(eye, *frame.object, irradiance);
    }
    if (settings.background != Background::none) {
        const Sh36 radiance = light.volume != nullptr ? all_radiance_sh(light, frame.pose.eye) : Sh36{};
        if (light.volume != nullptr) ++look_ups_;
        background_.draw(eye, settings.background == Background::picture, frame.environment_turn, radiance);
    }
    if (level_) level_->draw_blended(eye, level_light);
}

void Renderer::draw(const Frame& frame, std::span<const Pane> panes, glm::ivec2 size, int samples) {
    target_.resize(size, samples);
    const Settings& first = panes.front().settings;
    exposure_ = exposure_of(first, look_up_with(first), frame.pose);
    look_ups_ = 0;
    target_.begin();
    for (const Pane& pane : panes) draw_pane(frame, pane);
    target_.resolve();
    for (const Pane& pane : panes) target_.develop(pane.part, pane.settings.tone);
    check_gl(gl_, "drawing a picture");
}

std::size_t Renderer::bytes_of_light() const {
    std::size_t bytes = 0;
    for (const LitVolume* lit : {volume_.get(), half_volume_.get()}) {
        if (lit == nullptr) continue;
        const Volume& volume = lit->volume;
        bytes += volume.states.size() * sizeof(ProbeState) + volume.coefficients.size() * sizeof(glm::vec3);
    }
    for (const LightTable& table : light_tables_) bytes += table.bytes;
    return bytes;
}

}  // namespace lightgrid
