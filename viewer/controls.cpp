#include "viewer/controls.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

namespace lightgrid {
namespace {

constexpr std::array bindings{
    KeyBinding{Key::f1, Action::help, "F1", "what keys and mouse do"},
    KeyBinding{Key::tab, Action::panel, "Tab", "the panel with all controls, or the picture alone"},
    KeyBinding{Key::space, Action::next_worst, "Space", "go to where the volume is worst, then to the next such place"},
    KeyBinding{Key::p, Action::fly, "P", "fly along the path, or stop"},
    KeyBinding{Key::r, Action::record, "R", "record a path, or end and save it"},
    KeyBinding{Key::f12, Action::screenshot, "F12", "save the picture (PNG) and its light (EXR)"},
    KeyBinding{Key::digit_1, Action::sphere, "1", "a sphere as the object"},
    KeyBinding{Key::digit_2, Action::bunny, "2", "the bunny"},
    KeyBinding{Key::digit_3, Action::own_object, "3", "the object that --object names"},
    KeyBinding{Key::digit_4, Action::no_object, "4", "no object"},
    KeyBinding{Key::f, Action::follow, "F", "the object follows the camera, or stays"},
    KeyBinding{Key::x, Action::split, "X", "split screen, or one picture"},
    KeyBinding{Key::m, Action::comparison, "M", "what split screen compares"},
    KeyBinding{Key::l, Action::level_light, "L", "light of the level: per vertex, per pixel, none, constant"},
    KeyBinding{Key::o, Action::object_light, "O", "light of the object: one look-up, per pixel, path-traced, constant"},
    KeyBinding{Key::b, Action::bands, "B", "bands that are used: 1, 2, 3"},
    KeyBinding{Key::n, Action::filter, "N", "nearest probe or trilinear"},
    KeyBinding{Key::g, Action::dering, "G", "deringing of the light of object and level"},
    KeyBinding{Key::h, Action::half, "H", "coefficients rounded to half"},
    KeyBinding{Key::j, Action::contact_shadow, "J", "contact shadow of the object"},
    KeyBinding{Key::k, Action::self_shadowing, "K", "what the object hides and reflects of itself"},
    KeyBinding{Key::v, Action::level_colors, "V",
               "false colours on the level: none, irradiance, standard error, off from the path tracer"},
    KeyBinding{Key::z, Action::probes, "Z", "probes: none, in sight, through walls"},
    KeyBinding{Key::c, Action::cell, "C", "the cell that the object is in, with its weights"},
    KeyBinding{Key::y, Action::crowd, "Y", "a thousand objects, each lit by a look-up of its own"},
    KeyBinding{Key::u, Action::background, "U", "background: environment, its coefficients, none"},
    KeyBinding{Key::i, Action::next_environment, "I", "the next environment of its folder; of a level, the next sky"},
    KeyBinding{Key::comma, Action::less_gain, ",", "less light from the volume"},
    KeyBinding{Key::period, Action::more_gain, ".", "more light from the volume"},
    KeyBinding{Key::minus, Action::less_exposure, "-", "shorter exposure"},
    KeyBinding{Key::equal, Action::more_exposure, "=", "longer exposure"},
    KeyBinding{Key::t, Action::tone, "T", "tone map: film, Reinhard, linear"},
    KeyBinding{Key::escape, Action::quit, "Esc", "quit"},
};

constexpr std::array motions{
    MotionBinding{"W A S D", "fly forward, left, back, right"},
    MotionBinding{"Q E", "down, up"},
    MotionBinding{"Shift", "faster"},
    MotionBinding{"Wheel", "speed"},
    MotionBinding{"Right", "button of the mouse, held: look round"},
    MotionBinding{"Left", "button, held: drag the object"},
    MotionBinding{"Click", "path-traced light there, beside the volume's"},
    MotionBinding{"[ ]", "turn the environment's light"},
    MotionBinding{"Drop", "an environment or an object onto the window"},
};

constexpr float stops_per_press = 0.25F;

/// The value after this one of an enumeration with so many.
template <typename Value>
Value next(Value value, int count) {
    return static_cast<Value>((static_cast<int>(value) + 1) % count);
}

void scale_gain(Settings& settings, float stops) {
    const float most = std::exp2(most_stops);
    settings.gain = std::clamp(settings.gain * std::exp2(stops), 1 / most, most);
}

}  // namespace

std::span<const KeyBinding> key_bindings() {
    return bindings;
}

std::span<const MotionBinding> motion_bindings() {
    return motions;
}

std::optional<Action> action_of(Key key) {
    for (const KeyBinding& binding : bindings) {
        if (binding.key == key) return binding.action;
    }
    return {};
}

std::string controls_help() {
    std::string text;
    for (const auto& [name, help] : motions) text += fmt::format("  {:8} {}\n", name, help);
    for (const KeyBinding& binding : bindings) text += fmt::format("  {:8} {}\n", binding.name, binding.help);
    return text;
}

Pose fly(const Pose& pose, const Input& input, Motion& motion, double seconds) {
    if (input.wheel != 0) motion.speed *= std::pow(wheel_factor, input.wheel);
    const auto held = [&](Key key) { return input.held.contains(key) ? 1.0 : 0.0; };
    const glm::dvec3 along(held(Key::d) - held(Key::a), held(Key::e) - held(Key::q), held(Key::w) - held(Key::s));
    const bool runs = input.held.contains(Key::left_shift) || input.held.contains(Key::right_shift);
    const double way = motion.speed * (runs ? run_factor : 1) * std::clamp(seconds, 0.0, 0.1);
    Pose result = along == glm::dvec3(0) ? pose : moved(pose, way * glm::normalize(along));
    if (input.buttons.contains(MouseButton::right)) {
        result = turned(result, -look_deg_per_pixel * input.moved.x, -look_deg_per_pixel * input.moved.y);
    }
    return result;
}

bool apply(Action action, Settings& settings, int bands) {
    switch (action) {
        case Action::less_gain:
            scale_gain(settings, -stops_per_press);
            return true;
        case Action::more_gain:
            scale_gain(settings, stops_per_press);
            return true;
        case Action::less_exposure:
            settings.exposure_stops = std::max(settings.exposure_stops - stops_per_press, -most_stops);
            return true;
        case Action::more_exposure:
            settings.exposure_stops = std::min(settings.exposure_stops + stops_per_press, most_stops);
            return true;
        case Action::tone:
            settings.tone = next(settings.tone, 3);
            return true;
        case Action::level_light:
            settings.level_light = next(settings.level_light, 4);
            return true;
        case Action::object_light:
            settings.object_light = next(settings.object_light, 4);
            return true;
        case Action::bands:
            settings.bands = settings.bands % bands + 1;
            return true;
        case Action::filter:
            settings.filter = next(settings.filter, 2);
            return true;
        case Action::dering:
            settings.dering = !settings.dering;
            return true;
        case Action::half:
            settings.half = !settings.half;
            return true;
        case Action::background:
            settings.background = next(settings.background, 3);
            return true;
        case Action::contact_shadow:
            settings.contact_shadow = !settings.contact_shadow;
            return true;
        case Action::self_shadowing:
            settings.self_shadowing = !settings.self_shadowing;
            return true;
        case Action::level_colors:
            settings.level_colors = next(settings.level_colors, level_colors_count);
            return true;
        case Action::probes:
            settings.probes = next(settings.probes, 3);
            return true;
        case Action::cell:
            settings.show_cell = !settings.show_cell;
            return true;
        case Action::crowd:
            settings.show_crowd = !settings.show_crowd;
            return true;
        default:
            return false;
    }
}

Settings settings_after(std::string_view keys) {
    Settings settings;
    for (const char printed : keys) {
        const auto key = static_cast<Key>(std::toupper(static_cast<unsigned char>(printed)));
        const std::optional<Action> action = action_of(key);
        if (!action || !apply(*action, settings)) {
            throw Error(fmt::format("no setting is switched by the key \"{}\"", printed), {},
                        "fly-through shows the keys with F1; README.md lists them");
        }
    }
    return settings;
}

}  // namespace lightgrid
