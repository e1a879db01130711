#include "viewer/session.h"

#include <algorithm>
#include <cmath>

namespace lightgrid {
namespace {

/// The part of the picture that a pixel is in, and where in it.
struct PointedAt {
    glm::dvec2 pixel;
    glm::ivec2 size;
};

PointedAt pointed_at(const Session& session, glm::dvec2 cursor, glm::ivec2 size) {
    for (const Pane& pane : panes_of(session, size)) {
        // Both halves are as high as the picture.
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

void drag_object(Session& session, const Input& input, glm::ivec2 size) {
    const PointedAt at = pointed_at(session, input.cursor, size);
    if (at.size.x < 1 || at.size.y < 1) return;
    const glm::dvec3 direction = ray_through(session.pose, session.lens, at.pixel, at.size);
    const bool pressed =
        std::find(input.clicked.begin(), input.clicked.end(), MouseButton::left) != input.clicked.end();
    if (pressed && session.settings.show_object && points_at_object(session, direction)) session.dragged = true;
    if (!input.buttons.contains(MouseButton::left)) session.dragged = false;
    if (!session.dragged) return;
    session.object_mode = ObjectMode::stays;
    // In the plane through its centre that faces the eye.
    const glm::dvec3 ahead = forward(session.pose);
    const double depth = glm::dot(session.object.position - session.pose.eye, ahead);
    session.object.position = session.pose.eye + depth / glm::dot(direction, ahead) * direction;
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

void act(Session& session, Action action, Requests& requests) {
    if (apply(action, session.settings)) return;
    switch (action) {
        case Action::fly:
            if (session.flown_s) {
                session.flown_s.reset();
            } else if (session.flight) {
                session.flown_s = 0;
                session.object_mode = session.flight->keys.front().object ? ObjectMode::on_path : ObjectMode::follows;
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
            if (session.left) {
                session.left.reset();
            } else {
                session.left = session.settings;
            }
            break;
        default:
            requests.actions.push_back(action);
    }
}

}  // namespace

Requests step(Session& session, const Input& input, double seconds, glm::ivec2 size) {
    Requests requests;
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
    drag_object(session, input, size);
    record(session, seconds);
    return requests;
}

Frame frame_of(const Session& session) {
    return {.pose = session.pose, .lens = session.lens, .object = session.object, .time_s = session.time_s};
}

std::vector<Pane> panes_of(const Session& session, glm::ivec2 size) {
    if (!session.left || size.x < 2) return {Pane{{{0, 0}, size}, session.settings}};
    const int middle = size.x / 2;
    // Exposure is the first one's: of one picture, on both sides.
    return {Pane{{{0, 0}, {middle, size.y}}, *session.left},
            Pane{{{middle, 0}, {size.x - middle, size.y}}, session.settings}};
}

}  // namespace lightgrid
