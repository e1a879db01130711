#pragma once

#include "viewer/controls.h"
#include "viewer/flight.h"
#include "viewer/renderer.h"

#include <glm/glm.hpp>

#include <optional>
#include <vector>

namespace lightgrid {

enum class ObjectMode : std::uint8_t { follows, stays, on_path };

/// What a person is doing with the viewer: all state that input changes and a frame is drawn from. No OpenGL here.
struct Session {
    Settings settings;             // of the whole picture, or of its right half
    std::optional<Settings> left;  // of the left half, while the screen is split
    Pose pose;
    Lens lens;
    Motion motion;
    bool touched = false;  // a person has flown: nothing else moves the camera any more

    double time_s = 0;  // since the start

    ObjectMode object_mode = ObjectMode::follows;
    ObjectPlace object;
    bool dragged = false;  // by the mouse, right now

    std::optional<Flight> flight;    // to fly along; none known yet
    std::optional<double> flown_s;   // since the flight's start, while it is flown
    std::optional<Flight> recorded;  // so far, while a path is recorded
    double recorded_s = 0;
};

/// How far before the eye an object that follows is, in its own size.
inline constexpr double follow_sizes = 4;
/// Between the keys of a recorded path.
inline constexpr double record_step_s = 0.25;

/// What step() leaves to the program.
struct Requests {
    std::vector<Action> actions;      // quit, help, screenshot and those that choose an object
    std::optional<Flight> recording;  // ended just now: to be saved
};

/// Moves everything on by `seconds`.
///
/// size  of the picture, pixels: what the cursor points into
[[nodiscard]] Requests step(Session& session, const Input& input, double seconds, glm::ivec2 size);

[[nodiscard]] Frame frame_of(const Session& session);
/// One part, or two halves while the screen is split.
[[nodiscard]] std::vector<Pane> panes_of(const Session& session, glm::ivec2 size);

}  // namespace lightgrid
