#include "viewer/session.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

namespace lightgrid {
namespace {

constexpr glm::ivec2 size(800, 600);

Input pressing(Key key) {
    Input input;
    input.pressed = {key};
    return input;
}

void press(Session& session, Key key) {
    static_cast<void>(step(session, pressing(key), 0.01, size));
}

TEST(Controls, EveryKeyDoesOneThingAndIsInTheHelp) {
    std::set<Key> keys;
    std::set<Action> actions;
    const std::string help = controls_help();
    for (const KeyBinding& binding : key_bindings()) {
        EXPECT_TRUE(keys.insert(binding.key).second) << binding.name;
        EXPECT_TRUE(actions.insert(binding.action).second) << binding.name;
        EXPECT_EQ(action_of(binding.key), binding.action);
        EXPECT_NE(help.find(binding.help), std::string::npos);
        // Flying has its own keys.
        for (const Key key : {Key::w, Key::a, Key::s, Key::d, Key::q, Key::e}) EXPECT_NE(binding.key, key);
    }
    EXPECT_FALSE(action_of(Key::left_shift));
}

TEST(Controls, FlyingIsAsFastWhateverTheDirectionAndTheFrameRate) {
    Motion motion{2};
    Input input;
    input.held = {Key::w, Key::d};
    Pose pose;
    for (int i = 0; i < 10; ++i) pose = fly(pose, input, motion, 0.05);
    EXPECT_NEAR(glm::length(pose.eye), 1, 1e-12);
    input.held.insert(Key::left_shift);
    EXPECT_NEAR(glm::length(fly({}, input, motion, 0.05).eye), 0.1 * run_factor, 1e-12);
    EXPECT_NEAR(glm::length(fly({}, input, motion, 60).eye), 0.2 * run_factor, 1e-12);  // a pause is no leap
}

TEST(Controls, MouseTurnsOnlyWhileItsButtonIsDown) {
    Motion motion;
    Input input;
    input.moved = {10, -20};
    EXPECT_EQ(fly({}, input, motion, 0.1).yaw_deg, 0);
    input.buttons = {MouseButton::right};
    const Pose pose = fly({}, input, motion, 0.1);
    EXPECT_NEAR(pose.yaw_deg, 360 - 10 * look_deg_per_pixel, 1e-12);  // to the right
    EXPECT_NEAR(pose.pitch_deg, 20 * look_deg_per_pixel, 1e-12);      // and up
}

TEST(Controls, WheelChangesTheSpeedAndBack) {
    Motion motion{3};
    Input input;
    input.wheel = 2;
    static_cast<void>(fly({}, input, motion, 0.1));
    EXPECT_GT(motion.speed, 3);
    input.wheel = -2;
    static_cast<void>(fly({}, input, motion, 0.1));
    EXPECT_NEAR(motion.speed, 3, 1e-12);
}

TEST(Controls, SettingsComeRoundAgain) {
    for (const auto& [action, presses] :
         {std::pair(Action::tone, 3), std::pair(Action::level_light, 4), std::pair(Action::object_light, 4),
          std::pair(Action::bands, 3), std::pair(Action::filter, 2), std::pair(Action::dering, 2),
          std::pair(Action::half, 2), std::pair(Action::background, 3), std::pair(Action::contact_shadow, 2),
          std::pair(Action::self_shadowing, 2), std::pair(Action::level_colors, level_colors_count),
          std::pair(Action::probes, 3), std::pair(Action::cell, 2), std::pair(Action::crowd, 2)}) {
        Settings settings;
        int changed = 0;
        for (int i = 0; i < presses; ++i) {
            ASSERT_TRUE(apply(action, settings));
            changed += settings == Settings{} ? 0 : 1;
        }
        EXPECT_EQ(changed, presses - 1);
        EXPECT_EQ(settings, Settings{});
    }
    Settings settings;
    for (int i = 0; i < 1000; ++i) static_cast<void>(apply(Action::more_gain, settings));
    EXPECT_EQ(settings.gain, std::exp2(most_stops));
    for (int bands = 1; bands <= most_bands; ++bands) {
        settings.bands = bands;
        ASSERT_TRUE(apply(Action::bands, settings, most_bands));
        EXPECT_EQ(settings.bands, bands % most_bands + 1);
    }
    EXPECT_FALSE(apply(Action::quit, settings));
}

TEST(Session, BracketsTurnTheSkyOfALevelThatHasOne) {
    Session session;
    Input input;
    input.held = {Key::right_bracket};
    static_cast<void>(step(session, input, 0.1, size));
    EXPECT_EQ(session.layers.sky_turned_deg, 0) << "there is none";
    session.layers.knobs = {{"lamps"}, {sky_knob}};
    static_cast<void>(step(session, input, 0.1, size));
    EXPECT_GT(session.layers.sky_turned_deg, 0);
    input.held = {Key::left_bracket};
    static_cast<void>(step(session, input, 0.1, size));
    EXPECT_NEAR(session.layers.sky_turned_deg, 0, 1e-9);
}

TEST(Session, TheObjectFollowsOrStays) {
    Session session;
    Input input;
    input.held = {Key::w};
    static_cast<void>(step(session, input, 0.1, size));
    EXPECT_NEAR(session.object.position.z, session.pose.eye.z - follow_sizes, 1e-12);
    press(session, Key::f);
    const glm::dvec3 before = session.object.position;
    static_cast<void>(step(session, input, 0.1, size));
    EXPECT_EQ(session.object.position, before);
}

TEST(Session, TheObjectIsDraggedInThePlaneThatFacesTheEye) {
    Session session;
    press(session, Key::f);
    session.object.position = {0, 0, -4};
    Input input;
    input.cursor = {400, 300};
    input.clicked = {MouseButton::left};
    input.buttons = {MouseButton::left};
    static_cast<void>(step(session, input, 0.01, size));
    EXPECT_EQ(session.object.position, glm::dvec3(0, 0, -4)) << "it may become a click yet";
    input.clicked.clear();
    input.cursor = {599.5, 149.5};
    static_cast<void>(step(session, input, 0.01, size));
    EXPECT_TRUE(session.dragged);
    const double half_height = 4 * std::tan(glm::radians(session.lens.vertical_angle_deg / 2));
    EXPECT_NEAR(session.object.position.x, 200.0 / 300 * half_height, 1e-9);
    EXPECT_NEAR(session.object.position.y, 150.0 / 300 * half_height, 1e-9);
    EXPECT_NEAR(session.object.position.z, -4, 1e-9);
    input.buttons.clear();
    input.cursor = {0, 0};
    const glm::dvec3 dropped = session.object.position;
    EXPECT_FALSE(step(session, input, 0.01, size).click) << "this was a drag";
    EXPECT_EQ(session.object.position, dropped);
}

TEST(Session, APressThatDoesNotMoveIsAClick) {
    Session session;
    press(session, Key::f);
    session.object.position = {0, 0, -4};
    Input input;
    for (const auto& [cursor, on_object] :
         {std::pair(glm::dvec2(399.5, 299.5), true), std::pair(glm::dvec2(20.5, 20.5), false)}) {
        input.cursor = cursor;
        input.clicked = {MouseButton::left};
        input.buttons = {MouseButton::left};
        EXPECT_FALSE(step(session, input, 0.01, size).click);
        input.clicked.clear();
        input.cursor += glm::dvec2(click_pixels / 2, 0);
        EXPECT_FALSE(step(session, input, 0.01, size).click);
        input.buttons.clear();
        const std::optional<Click> click = step(session, input, 0.01, size).click;
        ASSERT_TRUE(click);
        EXPECT_EQ(click->on_object, on_object);
        const glm::dvec3 seen = ray_through(session.pose, session.lens, input.cursor, size);
        EXPECT_NEAR(glm::length(click->direction - seen), 0, 1e-12);
        EXPECT_FALSE(step(session, input, 0.01, size).click) << "once";
    }
    // Down and up between two frames.
    input.clicked = {MouseButton::left};
    EXPECT_TRUE(step(session, input, 0.01, size).click);
    EXPECT_EQ(session.object.position, glm::dvec3(0, 0, -4));
}

TEST(Session, AClickBesideTheObjectDragsNothing) {
    Session session;
    press(session, Key::f);
    session.object.position = {0, 0, -4};
    Input input;
    input.cursor = {20, 20};
    input.clicked = {MouseButton::left};
    input.buttons = {MouseButton::left};
    static_cast<void>(step(session, input, 0.01, size));
    EXPECT_FALSE(session.dragged);
    EXPECT_EQ(session.object.position, glm::dvec3(0, 0, -4));
}

TEST(Session, SplitScreenShowsOneDifferenceOnSidesOfOneWidth) {
    Session session;
    session.settings.gain = 2;
    EXPECT_EQ(panes_of(session, size).size(), 1U);
    press(session, Key::x);
    std::set<std::string> names;
    for (int i = 0; i < comparisons; ++i) {
        const std::vector<Side> sides = sides_of(session);
        ASSERT_EQ(sides.size(), session.comparison == Comparison::bands ? 3U : 2U);
        const std::vector<Pane> panes = panes_of(session, {801, 600});
        ASSERT_EQ(panes.size(), sides.size());
        int left = 0;
        for (std::size_t k = 0; k < panes.size(); ++k) {
            EXPECT_EQ(panes[k].part.corner.x, left);
            EXPECT_NEAR(panes[k].part.size.x, 801.0 / static_cast<double>(panes.size()), 1);
            left += panes[k].part.size.x;
            EXPECT_EQ(panes[k].settings, sides[k].settings);
            EXPECT_EQ(sides[k].settings.gain, 2);
            EXPECT_TRUE(names.insert(sides[k].name).second) << sides[k].name;
        }
        EXPECT_EQ(left, 801);
        EXPECT_EQ(sides[0].settings == sides[1].settings, session.comparison == Comparison::earlier);
        press(session, Key::m);
    }
    EXPECT_EQ(session.comparison, Session().comparison) << "they come round again";
    EXPECT_EQ(panes_of(session, {1, 600}).size(), 1U) << "no room for two";
    press(session, Key::x);
    EXPECT_EQ(panes_of(session, size).size(), 1U);
}

TEST(Session, SplitScreenComparesWithWhatWasSetBefore) {
    Session session;
    session.comparison = Comparison::earlier;
    press(session, Key::x);
    press(session, Key::b);
    const std::vector<Pane> panes = panes_of(session, size);
    ASSERT_EQ(panes.size(), 2U);
    EXPECT_EQ(panes[0].settings.bands, 3);
    EXPECT_EQ(panes[1].settings.bands, 1);
}

TEST(Session, TheLightTurnsWhileItsKeyIsHeldOrByItself) {
    Session session;
    Input input;
    input.held = {Key::right_bracket};
    static_cast<void>(step(session, input, 0.1, size));
    EXPECT_FALSE(session.environment) << "a level's light stays";
    session.environment.emplace();
    static_cast<void>(step(session, input, 0.1, size));
    EXPECT_NEAR(session.environment->turned_deg, 0.1 * turn_deg_per_s, 1e-9);
    const glm::vec3 turned = frame_of(session).environment_turn * glm::vec3(1, 0, 0);
    EXPECT_LT(turned.z, 0) << "counter-clockwise seen from above: from +X towards -Z";
    input.held = {Key::left_bracket};
    for (int i = 0; i < 2; ++i) static_cast<void>(step(session, input, 0.1, size));
    EXPECT_NEAR(session.environment->turned_deg, 360 - 0.1 * turn_deg_per_s, 1e-9);
    session.turning = true;
    static_cast<void>(step(session, {}, 0.1, size));
    EXPECT_NEAR(std::remainder(session.environment->turned_deg, 360), 0, 1e-9);
}

TEST(Session, FliesThePathToItsEndUnlessAPersonSteers) {
    Session session;
    session.flight.emplace();
    for (int i = 0; i < 3; ++i) {
        FlightKey key;
        key.time_s = i;
        key.eye = {i, 0, 0};
        key.object = glm::dvec3(i, 1, 0);
        session.flight->keys.push_back(key);
    }
    start_flight(session);
    EXPECT_EQ(session.pose.eye.x, 0);
    static_cast<void>(step(session, {}, 1, size));
    EXPECT_EQ(session.pose.eye.x, 1);
    EXPECT_EQ(session.object.position, glm::dvec3(1, 1, 0));
    EXPECT_FALSE(session.touched) << "flying is no steering";

    press(session, Key::p);
    EXPECT_FALSE(session.flown_s);
    press(session, Key::p);
    static_cast<void>(step(session, {}, 1, size));
    EXPECT_NEAR(session.pose.eye.x, 1.01, 1e-9);
    EXPECT_NEAR(session.object.position.x, 1.01, 1e-9);
    static_cast<void>(step(session, {}, 5, size));
    EXPECT_EQ(session.pose.eye.x, 2);
    EXPECT_FALSE(session.flown_s);

    press(session, Key::p);
    ASSERT_TRUE(session.flown_s);
    Input input;
    input.held = {Key::w};
    static_cast<void>(step(session, input, 0.1, size));
    EXPECT_FALSE(session.flown_s);
}

TEST(Session, ARecordedPathIsTheOneThatWasFlown) {
    Session session;
    press(session, Key::r);
    Input input;
    input.held = {Key::w};
    for (int i = 0; i < 100; ++i) static_cast<void>(step(session, input, 0.05, size));
    const Requests requests = step(session, pressing(Key::r), 0.05, size);
    ASSERT_TRUE(requests.recording);
    EXPECT_FALSE(session.recorded);
    const Flight& flight = *requests.recording;
    EXPECT_NEAR(flight.duration_s(), 5, record_step_s);
    for (const FlightKey& key : flight.keys) {
        EXPECT_NEAR(key.eye.z, -session.motion.speed * key.time_s, 0.011);  // it began with a step of 0.01 s
    }
}

TEST(Session, WhatIsForTheProgramIsPassedOn) {
    Session session;
    Input input;
    input.pressed = {Key::f12, Key::digit_2, Key::b, Key::space, Key::f1, Key::tab, Key::i, Key::escape};
    input.dropped = {"sky.hdr"};
    const Requests requests = step(session, input, 0.01, size);
    EXPECT_EQ(requests.actions, (std::vector{Action::screenshot, Action::bunny, Action::next_worst,
                                             Action::next_environment, Action::quit}));
    EXPECT_EQ(requests.files, std::vector<std::string>{"sky.hdr"});
    EXPECT_TRUE(session.show_help);
    EXPECT_FALSE(session.show_panel);
}

}  // namespace
}  // namespace lightgrid
