#include "viewer/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace lightgrid {
namespace {

/// The part of the picture that a pixel is in, and where in it.
struct PointedAt {
    glm::dvec2 pixel;
    glm::ivec2 size;
};

PointedAt pointed_at(const Session& session, glm::dvec2 cursor, glm::ivec2 size) {
    for (const Pane& pane : panes_of(session, size)) {
        // Every one is as high as the picture.
        const double left = pane.part.corner.x;
        if (cursor.x < left + pane.part.size.x) return {{cursor.x - left, cursor.y}, pane.part.size};
    }
    return {cursor, size};
}

/// A ray that hits the object's sphere.
bool points_at_object(const Session& session, glm::dvec3 direction) {
    const glm::dvec3 to = session.object.position - session.pose.eye;
    const double along = glm::dot(to, direction);
    return along > 0 && glm::length(to - along * direction) < 0.6 * session.object.size;
}

/// Follows the left button: what it drags, and where it clicks.
void follow_press(Session& session, const Input& input, glm::ivec2 size, Requests& requests) {
    const PointedAt at = pointed_at(session, input.cursor, size);
    if (at.size.x < 1 || at.size.y < 1) return;
    const glm::dvec3 direction = ray_through(session.pose, session.lens, at.pixel, at.size);
    if (std::find(input.clicked.begin(), input.clicked.end(), MouseButton::left) != input.clicked.end()) {
        session.press = Press{input.cursor, session.settings.show_object && points_at_object(session, direction)};
    }
    if (!session.press) return;
    const bool moved = glm::length(input.cursor - session.press->cursor) > click_pixels;
    if (moved && session.press->on_object) session.dragged = true;
    if (!input.buttons.contains(MouseButton::left)) {
        if (!moved && !session.dragged) requests.click = Click{direction, session.press->on_object};
        session.press.reset();
        session.dragged = false;
    }
    if (!session.dragged) return;
    session.object_mode = ObjectMode::stays;
    // In the plane through its centre that faces the eye.
    const glm::dvec3 ahead = forward(session.pose);
    const double depth = glm::dot(session.object.position - session.pose.eye, ahead);
    session.object.position = session.pose.eye + depth / glm::dot(direction, ahead) * direction;
}

void turn_light(Session& session, const Input& input, double seconds) {
    if (!session.environment && find_sky(session.layers) == nullptr) return;
    const auto held = [&](Key key) { return input.held.contains(key) ? 1.0 : 0.0; };
    const double turns = held(Key::right_bracket) - held(Key::left_bracket) + (session.turning ? 1 : 0);
    double& turned = session.environment ? session.environment->turned_deg : session.layers.sky_turned_deg;
    turned = std::fmod(turned + turns * turn_deg_per_s * std::clamp(seconds, 0.0, 0.1) + 360, 360);
}

void fly_path(Session& session, double seconds) {
    if (!session.flown_s || !session.flight) return;
    *session.flown_s += seconds;
    const FlightMoment moment = evaluate(*session.flight, session.flight->start_s() + *session.flown_s);
    session.pose = moment.pose;
    if (moment.object && session.object_mode == ObjectMode::on_path) session.object.position = *moment.object;
    if (*session.flown_s < session.flight->duration_s()) return;
    session.flown_s.reset();
    if (session.object_mode == ObjectMode::on_path) session.object_mode = ObjectMode::stays;
}

void record(Session& session, double seconds) {
    if (!session.recorded) return;
    session.recorded_s += seconds;
    std::vector<FlightKey>& keys = session.recorded->keys;
    if (!keys.empty() && session.recorded_s < keys.back().time_s + record_step_s) return;
    FlightKey key;
    key.time_s = session.recorded_s;
    key.eye = session.pose.eye;
    key.yaw_deg = session.pose.yaw_deg;
    key.pitch_deg = session.pose.pitch_deg;
    key.object = session.object.position;
    keys.push_back(key);
}

}  // namespace

void start_flight(Session& session) {
    if (!session.flight) return;
    session.flown_s = 0;
    session.object_mode = session.flight->keys.front().object ? ObjectMode::on_path : ObjectMode::follows;
    session.pose = evaluate(*session.flight, session.flight->start_s()).pose;
}

void act(Session& session, Action action, Requests& requests) {
    if (apply(action, session.settings, session.bands)) return;
    switch (action) {
        case Action::fly:
            if (session.flown_s) {
                session.flown_s.reset();
            } else {
                start_flight(session);
            }
            break;
        case Action::record:
            if (session.recorded) {
                if (!session.recorded->keys.empty()) requests.recording = std::move(session.recorded);
                session.recorded.reset();
            } else {
                session.recorded.emplace();
                session.recorded_s = 0;
            }
            break;
        case Action::follow:
            session.object_mode = session.object_mode == ObjectMode::follows ? ObjectMode::stays : ObjectMode::follows;
            break;
        case Action::split:
            session.split = !session.split;
            session.earlier = session.settings;
            break;
        case Action::comparison:
            if (session.split) {
                session.comparison = static_cast<Comparison>((static_cast<int>(session.comparison) + 1) % comparisons);
            }
            session.split = true;
            session.earlier = session.settings;
            break;
        case Action::help:
            session.show_help = !session.show_help;
            break;
        case Action::panel:
            session.show_panel = !session.show_panel;
            break;
        default:
            requests.actions.push_back(action);
    }
}

Requests step(Session& session, const Input& input, double seconds, glm::ivec2 size) {
    Requests requests;
    requests.files = input.dropped;
    for (const Key key : input.pressed) {
        if (const std::optional<Action> action = action_of(key)) act(session, *action, requests);
    }
    session.time_s += seconds;
    const Pose before = session.pose;
    session.pose = fly(session.pose, input, session.motion, seconds);
    if (session.pose.eye != before.eye || session.pose.yaw_deg != before.yaw_deg ||
        session.pose.pitch_deg != before.pitch_deg) {
        session.touched = true;
        session.flown_s.reset();
        if (session.object_mode == ObjectMode::on_path) session.object_mode = ObjectMode::follows;
    }
    fly_path(session, seconds);
    if (session.object_mode == ObjectMode::follows) {
        session.object.position = session.pose.eye + follow_sizes * session.object.size * forward(session.pose);
    }
    follow_press(session, input, size, requests);
    turn_light(session, input, seconds);
    record(session, seconds);
    return requests;
}

Frame frame_of(const Session& session) {
    Frame frame{.pose = session.pose, .lens = session.lens, .object = session.object, .time_s = session.time_s};
    if (session.environment) frame.environment_turn = glm::mat3(turn_about_up(session.environment->turned_deg));
    return frame;
}

std::vector<Side> sides_of(const Session& session) {
    if (!session.split) return {{session.settings, ""}};
    std::vector<Side> sides;
    const auto add = [&](std::string name, auto change) {
        sides.push_back({session.settings, std::move(name)});
        change(sides.back().settings);
    };
    switch (session.comparison) {
        case Comparison::filter:
            add("nearest probe", [](Settings& s) { s.filter = Filter::nearest; });
            add("trilinear", [](Settings& s) { s.filter = Filter::trilinear; });
            break;
        case Comparison::bands:
            for (int bands = 1; bands <= std::min(session.bands, 3); ++bands) {
                add(bands == 1 ? "1 band" : fmt::format("{} bands", bands), [&](Settings& s) { s.bands = bands; });
            }
            if (session.bands > 3) {
                add(fmt::format("{} bands", session.bands), [&](Settings& s) { s.bands = session.bands; });
            }
            break;
        case Comparison::dering:
            add("as it rings", [](Settings& s) { s.dering = false; });
            add("deringed", [](Settings& s) { s.dering = true; });
            break;
        case Comparison::half:
            add("half", [](Settings& s) { s.half = true; });
            add("float", [](Settings& s) { s.half = false; });
            break;
        case Comparison::reference:
            add(session.environment ? "its samples" : "volume", [](Settings& s) {
                if (s.object_light == ObjectLight::reference) s.object_light = ObjectLight::object;
            });
            add("reference", [](Settings& s) { s.object_light = ObjectLight::reference; });
            break;
        case Comparison::earlier:
            sides.push_back({session.earlier, "as it was set"});
            sides.push_back({session.settings, "as it is set"});
            break;
    }
    return sides;
}

std::vector<Pane> panes_of(const Session& session, glm::ivec2 size) {
    std::vector<Side> sides = sides_of(session);
    // Exposure is the first one's: of one picture, on all sides.
    if (size.x < static_cast<int>(sides.size())) sides.resize(1);
    const int count = static_cast<int>(sides.size());
    std::vector<Pane> panes;
    for (int i = 0; i < count; ++i) {
        const int left = size.x * i / count;
        const int right = size.x * (i + 1) / count;
        panes.push_back({{{left, 0}, {right - left, size.y}}, sides[static_cast<std::size_t>(i)].settings});
    }
    return panes;
}

}  // namespace lightgrid
