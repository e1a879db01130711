#include "viewer/overlay_panel.h"

#include "tools/false_color.h"

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>

namespace lightgrid {
namespace {

/// Where numbers begin, and how wide a control is: shares of the panel.
constexpr float number_column = 0.36F;
constexpr float control_width = 0.5F;

std::string key_of(Action action) {
    for (const KeyBinding& binding : key_bindings()) {
        if (binding.action == action) return std::string(binding.name);
    }
    return {};
}

/// A label that names the key, too.
std::string with_key(std::string_view label, Action action) {
    return fmt::format("{} ({})", label, key_of(action));
}

void number(const char* name, const std::string& value) {
    ImGui::TextDisabled("%s", name);
    ImGui::SameLine(number_column * ImGui::GetWindowContentRegionMax().x);
    ImGui::TextWrapped("%s", value.c_str());
}

bool section(const char* name, bool open = true) {
    return ImGui::CollapsingHeader(name, open ? ImGuiTreeNodeFlags_DefaultOpen : ImGuiTreeNodeFlags_None);
}

/// One of an enumeration's values, which count from 0.
template <typename Value>
bool choose(const std::string& label, Value& value, std::span<const char* const> names) {
    int chosen = static_cast<int>(value);
    if (!ImGui::Combo(label.c_str(), &chosen, names.data(), static_cast<int>(names.size()))) return false;
    value = static_cast<Value>(chosen);
    return true;
}

bool button(const std::string& label, float share = 1) {
    const float gap = ImGui::GetStyle().ItemSpacing.x;
    return ImGui::Button(label.c_str(), ImVec2(share * (ImGui::GetContentRegionAvail().x + gap) - gap, 0));
}

std::string bytes_in_words(std::size_t bytes) {
    const double kib = static_cast<double>(bytes) / 1024;
    return kib < 1024 ? fmt::format("{:.0f} KiB", kib) : fmt::format("{:.1f} MiB", kib / 1024);
}

std::string setting(const Volume& volume, const char* name) {
    const auto found = volume.settings.find(name);
    return found == volume.settings.end() ? "" : found->second;
}

void lay_out_volume(const Volume& volume, const VolumeSummary& summary, double metres_per_unit) {
    for (const Grid& grid : volume.grids) {
        number("grid", fmt::format("{} x {} x {}, {:.3g} m", grid.counts.x, grid.counts.y, grid.counts.z,
                                   metres_per_unit * std::max({grid.spacing.x, grid.spacing.y, grid.spacing.z})));
    }
    number("probes", fmt::format("{}: {} valid, {} moved", summary.probes(), summary.count(ProbeState::valid),
                                 summary.count(ProbeState::moved)));
    number("bands", fmt::format("{}, stored as {}", volume.bands, volume.half ? "half" : "float"));
    for (const auto& [key, name] : {std::pair("samples", "rays/probe"), std::pair("environment", "environment")}) {
        if (const std::string value = setting(volume, key); !value.empty()) number(name, value);
    }
    number("noise", fmt::format("{:.2g} % of irradiance", 100 * summary.relative_noise));
}

void lay_out_statistics(const Facts& facts) {
    number("frame", fmt::format("{:.1f} ms", facts.frame_ms));
    number("look-ups", fmt::format("{} a frame", facts.look_ups));
    number("light", bytes_in_words(facts.bytes));
    if (!facts.baking.empty()) number("bakes", facts.baking);
    if (facts.volume != nullptr && !facts.environment) {
        lay_out_volume(facts.volume->volume, facts.summary, facts.metres_per_unit);
    }
}

/// The panel while it is laid out.
struct Panel {
    Session& session;
    const Facts& facts;
    PanelText& text;
    Requests& requests;

    void do_it(Action action) const { act(session, action, requests); }
    void action_button(std::string_view label, Action action, float share = 1) const {
        if (button(with_key(label, action), share)) do_it(action);
    }
};

void lay_out_environment(const Panel& panel) {
    EnvironmentChoice& choice = *panel.session.environment;
    const EnvironmentFacts& facts = *panel.facts.environment;
    ImGui::TextWrapped("%s", facts.loading ? "being read ..." : facts.file.c_str());
    ImGui::SliderInt("samples", &choice.samples, fewest_environment_samples, most_environment_samples, "%d",
                     ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
    constexpr std::array samplings{"by brightness", "evenly"};
    choose("drawn", choice.sampling, samplings);
    number("error", fmt::format("{:.2g} % of irradiance", 100 * facts.error));
    auto turned = static_cast<float>(choice.turned_deg);
    if (ImGui::SliderFloat("turned [ ]", &turned, 0, 360, "%.0f deg", ImGuiSliderFlags_AlwaysClamp)) {
        choice.turned_deg = turned;
    }
    ImGui::Checkbox("turns by itself", &panel.session.turning);
    std::string& path = panel.text.environment;
    const bool entered =
        ImGui::InputTextWithHint("file", "path, or drop one", &path, ImGuiInputTextFlags_EnterReturnsTrue);
    if ((button("Read", 0.5F) || entered) && !path.empty()) panel.requests.files.push_back(path);
    ImGui::SameLine();
    panel.action_button("Next", Action::next_environment);
}

void lay_out_light(const Panel& panel) {
    Settings& settings = panel.session.settings;
    if (!panel.session.environment) {
        constexpr std::array level{"none", "constant", "per vertex", "per pixel"};
        choose(with_key("level", Action::level_light), settings.level_light, level);
    }
    constexpr std::array object{"constant", "one look-up", "per pixel", "path-traced"};
    choose(with_key("object", Action::object_light), settings.object_light, object);
    if (settings.object_light == ObjectLight::reference && !panel.facts.object_reference.empty()) {
        number("reference", panel.facts.object_reference);
    }
    constexpr std::array filters{"trilinear", "nearest"};
    choose(with_key("probes", Action::filter), settings.filter, filters);
    ImGui::SliderInt(with_key("bands", Action::bands).c_str(), &settings.bands, 1, panel.session.bands, "%d",
                     ImGuiSliderFlags_AlwaysClamp);
    ImGui::Checkbox(with_key("deringed", Action::dering).c_str(), &settings.dering);
    ImGui::Checkbox(with_key("self-shadowing", Action::self_shadowing).c_str(), &settings.self_shadowing);
    if (!panel.session.environment) {
        ImGui::Checkbox(with_key("contact shadow", Action::contact_shadow).c_str(), &settings.contact_shadow);
    }
    ImGui::Checkbox(with_key("rounded to half", Action::half).c_str(), &settings.half);
    float stops = std::log2(settings.gain);
    if (ImGui::SliderFloat("gain (, .)", &stops, -8, 8, "%+.2f stops")) settings.gain = std::exp2(stops);
}

/// As much of a name as the panel has room for.
std::string short_name(const std::string& name) {
    constexpr std::size_t longest = 14;
    return name.size() <= longest ? name : name.substr(0, longest - 2) + "..";
}

void lay_out_layers(const Panel& panel) {
    LayerMix& mix = panel.session.layers;
    for (std::size_t i = 0; i < mix.knobs.size(); ++i) {
        LayerKnob& knob = mix.knobs[i];
        ImGui::PushID(static_cast<int>(i));
        ImGui::ColorEdit3("##colour", &knob.color.r, ImGuiColorEditFlags_NoInputs);
        ImGui::SameLine();
        ImGui::SetNextItemWidth(ImGui::CalcItemWidth() - ImGui::GetFrameHeight() - ImGui::GetStyle().ItemSpacing.x);
        ImGui::SliderFloat(short_name(knob.name).c_str(), &knob.weight, 0, most_layer_weight, "%.2f",
                           ImGuiSliderFlags_AlwaysClamp);
        if (knob.name == sky_knob) {
            constexpr std::array skies{"as given", "uniform", "of a file"};
            choose("from", mix.sky, skies);
            auto turned = static_cast<float>(mix.sky_turned_deg);
            if (ImGui::SliderFloat("turned", &turned, 0, 360, "%.0f deg", ImGuiSliderFlags_AlwaysClamp)) {
                mix.sky_turned_deg = turned;
            }
            std::string& path = panel.text.environment;
            if (ImGui::InputTextWithHint("file", "path, or drop one", &path, ImGuiInputTextFlags_EnterReturnsTrue)) {
                panel.requests.files.push_back(path);
            }
        }
        ImGui::PopID();
    }
}

ImVec4 color_of(ProbeState state) {
    const glm::vec3 color = state_color(state);
    return {color.r, color.g, color.b, 1};
}

/// What the rims of probes mean.
void lay_out_states() {
    for (const auto& [state, name] :
         {std::pair(ProbeState::valid, "valid"), std::pair(ProbeState::moved, "moved"),
          std::pair(ProbeState::filled, "filled"), std::pair(ProbeState::missing, "missing")}) {
        if (state != ProbeState::valid) ImGui::SameLine();
        ImGui::TextColored(color_of(state), "%s", name);
    }
}

/// Of the probes that answer, four a line.
void lay_out_weights(const LookUp& from, glm::dvec3 position) {
    const Sampler::Corners corners = corners_of(from, position);
    for (std::size_t i = 0; i < static_cast<std::size_t>(corners.count); ++i) {
        if (i % 4 != 0) ImGui::SameLine();
        ImGui::TextColored(color_of(from.volume->volume.states[corners.slots[i]]), "%5.1f %%",
                           100.0 * static_cast<double>(corners.weights[i]));
    }
}

void lay_out_data(const Panel& panel) {
    Settings& settings = panel.session.settings;
    constexpr std::array colors{"as it looks", "irradiance", "standard error", "off from path tracer"};
    static_assert(colors.size() == level_colors_count);
    choose(with_key("level", Action::level_colors), settings.level_colors, colors);
    if (!panel.facts.map.empty()) number("reference", panel.facts.map);
    panel.action_button("Worst place", Action::next_worst);
    constexpr std::array probes{"none", "in sight", "through walls"};
    choose(with_key("probes", Action::probes), settings.probes, probes);
    if (settings.probes != ProbesShown::none) lay_out_states();
    ImGui::Checkbox(with_key("a thousand objects", Action::crowd).c_str(), &settings.show_crowd);
    ImGui::Checkbox(with_key("the object's cell", Action::cell).c_str(), &settings.show_cell);
    if (settings.show_cell && panel.facts.volume != nullptr) {
        lay_out_weights(look_up(*panel.facts.volume, settings), panel.session.object.position);
    }
}

void lay_out_picture(const Panel& panel) {
    Settings& settings = panel.session.settings;
    ImGui::SliderFloat("exposure (- =)", &settings.exposure_stops, -8, 8, "%+.2f stops");
    ImGui::Checkbox("follows the light", &settings.automatic_exposure);
    constexpr std::array tones{"film", "Reinhard", "linear"};
    choose(with_key("tone map", Action::tone), settings.tone, tones);
    constexpr std::array backgrounds{"none", "environment", "coefficients"};
    choose(with_key("behind", Action::background), settings.background, backgrounds);
}

void lay_out_split(const Panel& panel) {
    Session& session = panel.session;
    if (bool split = session.split; ImGui::Checkbox(with_key("split screen", Action::split).c_str(), &split)) {
        panel.do_it(Action::split);
    }
    constexpr std::array pairs{"nearest | trilinear", "bands",     "ringing | deringed",
                               "half | float",        "reference", "as set | from now on"};
    static_assert(pairs.size() == comparisons);
    ImGui::SetNextItemWidth(0.8F * ImGui::GetContentRegionAvail().x);
    if (choose(with_key("", Action::comparison), session.comparison, pairs)) {
        session.split = true;
        session.earlier = session.settings;
    }
    if (session.split && session.comparison == Comparison::reference) {
        ImGui::TextWrapped("%s", session.environment
                                     ? "Right: the object in the light of all directions, not of samples."
                                     : "Right: the object in the path tracer's light at its centre (5 bands). The "
                                       "level is lit by the volume on both sides; click on it to compare.");
        number("reference", panel.facts.object_reference);
    }
}

void lay_out_object(const Panel& panel) {
    Session& session = panel.session;
    panel.action_button("Sphere", Action::sphere, 0.5F);
    ImGui::SameLine();
    panel.action_button("Bunny", Action::bunny);
    panel.action_button("Own", Action::own_object, 0.5F);
    ImGui::SameLine();
    panel.action_button("None", Action::no_object);
    bool follows = session.object_mode == ObjectMode::follows;
    if (ImGui::Checkbox(with_key("follows the camera", Action::follow).c_str(), &follows)) panel.do_it(Action::follow);
    const auto metres_per_unit = static_cast<float>(panel.facts.metres_per_unit);
    float size = session.object.size * metres_per_unit;
    if (ImGui::SliderFloat("size", &size, size / 2, size * 2, "%.3g m", ImGuiSliderFlags_Logarithmic)) {
        session.object.size = size / metres_per_unit;
    }
}

void lay_out_flight(const Panel& panel) {
    Session& session = panel.session;
    const glm::dvec3 eye = session.pose.eye;
    number("eye", fmt::format("{:.2f} {:.2f} {:.2f}", eye.x, eye.y, eye.z));
    number("speed", fmt::format("{:.3g} m/s (wheel)", session.motion.speed * panel.facts.metres_per_unit));
    panel.action_button(session.flown_s ? "Stop" : "Fly", Action::fly, 0.5F);
    ImGui::SameLine();
    panel.action_button(session.recorded ? "Save" : "Record", Action::record);
    if (session.flown_s) {
        const auto done = static_cast<float>(*session.flown_s / std::max(session.flight->duration_s(), 1e-9));
        ImGui::ProgressBar(done, ImVec2(-1, 0),
                           fmt::format("{:.1f} of {:.1f} s", *session.flown_s, session.flight->duration_s()).c_str());
    }
    if (session.recorded) number("recorded", fmt::format("{:.1f} s", session.recorded_s));
}

}  // namespace

void lay_out_panel(Session& session, const Facts& facts, PanelText& text, Requests& requests) {
    const Panel panel{session, facts, text, requests};
    ImGui::PushItemWidth(control_width * ImGui::GetWindowContentRegionMax().x);
    if (section("Statistics")) lay_out_statistics(facts);
    if (session.environment && facts.environment && section("Environment")) lay_out_environment(panel);
    if (section("Light")) lay_out_light(panel);
    if (!session.layers.knobs.empty() && section("Layers")) lay_out_layers(panel);
    if (!session.environment && section("Data")) lay_out_data(panel);
    if (section("Compare")) lay_out_split(panel);
    if (section("Picture")) lay_out_picture(panel);
    if (section("Flight")) lay_out_flight(panel);
    if (section("Object")) lay_out_object(panel);
    ImGui::Separator();
    panel.action_button("Photograph", Action::screenshot);
    panel.action_button("Help", Action::help, 0.5F);
    ImGui::SameLine();
    panel.action_button("Hide", Action::panel);
    ImGui::PopItemWidth();
}

}  // namespace lightgrid
