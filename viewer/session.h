#pragma once

#include "viewer/controls.h"
#include "viewer/environment_light.h"
#include "viewer/flight.h"
#include "viewer/layer_mix.h"
#include "viewer/renderer.h"

#include <glm/glm.hpp>

#include <optional>
#include <string>
#include <vector>

namespace lightgrid {

enum class ObjectMode : std::uint8_t { follows, stays, on_path };

/// What split screen shows side by side; all else is the same. earlier: the settings of when it was chosen.
enum class Comparison : std::uint8_t { filter, bands, dering, half, reference, earlier };
inline constexpr int comparisons = 6;

/// A press of the left button that may become a click or a drag.
struct Press {
    glm::dvec2 cursor{0};
    bool on_object = false;
};

/// What a person is doing with the viewer: all state that input changes and a frame is drawn from. No OpenGL here.
struct Session {
    Settings settings;
    bool split = false;
    Comparison comparison = Comparison::filter;
    Settings earlier;  // for Comparison::earlier
    int bands = 3;     // that there are to choose from

    Pose pose;
    Lens lens;
    Motion motion;
    bool touched = false;  // a person has flown: nothing else moves the camera any more

    double time_s = 0;  // since the start

    ObjectMode object_mode = ObjectMode::follows;
    ObjectPlace object;
    std::optional<Press> press;
    bool dragged = false;  // the object is, right now

    std::optional<Flight> flight;    // to fly along; none known yet
    std::optional<double> flown_s;   // since the flight's start, while it is flown
    std::optional<Flight> recorded;  // so far, while a path is recorded
    double recorded_s = 0;

    std::optional<EnvironmentChoice> environment;  // where an environment alone is looked at
    bool turning = false;                          // it goes on by itself
    LayerMix layers;                               // of the volume; no knobs: it has none

    bool show_panel = true;
    bool show_help = false;
};

/// How far before the eye an object that follows is, in its own size.
inline constexpr double follow_sizes = 4;
/// Between the keys of a recorded path.
inline constexpr double record_step_s = 0.25;
/// A press that moves less is a click.
inline constexpr double click_pixels = 4;

/// Where a person clicked.
struct Click {
    glm::dvec3 direction{0};  // seen from the eye, unit length
    bool on_object = false;
};

/// What is left to the program.
struct Requests {
    std::vector<Action> actions;      // quit, screenshot, those that choose an object or environment
    std::optional<Flight> recording;  // ended just now: to be saved
    std::optional<Click> click;
    bool forget_click = false;       // its answer has been seen
    std::vector<std::string> files;  // objects and environments to take
};

/// Flies the session's flight, if it has one, from its start; the object goes its own way where it has one.
void start_flight(Session& session);

/// Carries an action out, or passes it on.
void act(Session& session, Action action, Requests& requests);

/// Moves everything on by `seconds`.
///
/// size  of the picture, pixels: what the cursor points into
[[nodiscard]] Requests step(Session& session, const Input& input, double seconds, glm::ivec2 size);

[[nodiscard]] Frame frame_of(const Session& session);

/// A part of the screen and what it shows, in words.
struct Side {
    Settings settings;
    std::string name;
};
/// One without a name; or two and more, from left to right, while the screen is split.
[[nodiscard]] std::vector<Side> sides_of(const Session& session);
/// The same as parts of a picture, as wide as one another to a pixel.
[[nodiscard]] std::vector<Pane> panes_of(const Session& session, glm::ivec2 size);

}  // namespace lightgrid
