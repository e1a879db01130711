#pragma once

#include "viewer/camera.h"
#include "viewer/input.h"
#include "viewer/settings.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

/// What keys and mouse do. The tables are all that there is: help, overlay and program read them.
namespace lightgrid {

enum class Action : std::uint8_t {
    quit,
    help,
    panel,
    screenshot,
    next_worst,
    fly,
    record,
    sphere,
    bunny,
    own_object,
    no_object,
    follow,
    split,
    comparison,
    less_gain,
    more_gain,
    less_exposure,
    more_exposure,
    tone,
    level_light,
    object_light,
    bands,
    filter,
    dering,
    half,
    background,
    next_environment,
    contact_shadow,
    self_shadowing,
    level_colors,
    probes,
    cell,
    crowd,
};

struct KeyBinding {
    Key key;
    Action action;
    std::string_view name;  // as people call the key
    std::string_view help;
};

/// Every key that does something when it goes down.
[[nodiscard]] std::span<const KeyBinding> key_bindings();
[[nodiscard]] std::optional<Action> action_of(Key key);

/// What is done while something is held or moved.
struct MotionBinding {
    std::string_view name;
    std::string_view help;
};
[[nodiscard]] std::span<const MotionBinding> motion_bindings();

/// A line for everything that keys and mouse do.
[[nodiscard]] std::string controls_help();

/// How one flies by hand.
struct Motion {
    double speed = 1;  // per second, level coordinates
};
inline constexpr double run_factor = 4;       // with shift
inline constexpr double wheel_factor = 1.25;  // of speed, per notch
inline constexpr double look_deg_per_pixel = 0.15;
inline constexpr double turn_deg_per_s = 45;  // of the light

/// One step of flying: WASD, Q and E along the camera's own axes, faster with shift; the mouse turns it while its right
/// button is down; the wheel changes the speed.
///
/// seconds  since the last step; what is longer than a tenth of a second counts as that, so that a pause is no leap
[[nodiscard]] Pose fly(const Pose& pose, const Input& input, Motion& motion, double seconds);

/// Carries out an action that is about settings alone; false: it is about something else.
///
/// bands  as many as there are to choose from
bool apply(Action action, Settings& settings, int bands = 3);

/// The default settings after keys, named as they are printed ("zv"), have been pressed. Throws Error (Fault::input) for a
/// key that no setting is switched by.
[[nodiscard]] Settings settings_after(std::string_view keys);

}  // namespace lightgrid
