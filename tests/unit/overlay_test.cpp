#include "viewer/overlay_panel.h"

#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>

#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace lightgrid {
namespace {

/// The panel without a window: the library lays it out all the same.
class PanelTest : public testing::Test {
  protected:
    PanelTest() {
        ImGui::CreateContext();
        ImGuiIO& io = ImGui::GetIO();
        io.IniFilename = nullptr;
        io.DeltaTime = 0.05F;
        unsigned char* pixels = nullptr;
        int width = 0, height = 0;
        io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
        Volume volume = make_volume({{{0, 0, 0}, {1, 1, 1}, {28, 8, 23}}}, 3);
        volume.settings = {{"environment", "none"}, {"samples", "4096"}};
        facts_.summary = summarize(volume);
        facts_.volume = std::make_shared<const LitVolume>(std::move(volume));
    }
    ~PanelTest() override { ImGui::DestroyContext(); }
    PanelTest(const PanelTest&) = delete;
    PanelTest& operator=(const PanelTest&) = delete;

    /// A frame; the mouse is where it is, pressed or not.
    Requests lay_out(ImVec2 size, ImVec2 mouse = {-1, -1}, bool pressed = false) {
        ImGuiIO& io = ImGui::GetIO();
        io.DisplaySize = {size.x, size.y};
        io.MousePos = mouse;
        io.MouseDown[0] = pressed;
        ImGui::NewFrame();
        ImGui::SetNextWindowPos({0, 0});
        ImGui::SetNextWindowSize({panel_width, size.y});
        ImGui::Begin("panel", nullptr,
                     ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove);
        if (std::exchange(forget_sections_, false)) ImGui::GetStateStorage()->Clear();
        Requests requests;
        ImGui::LogToBuffer(0);
        lay_out_panel(session_, facts_, text_, requests);
        words_ = ImGui::GetCurrentContext()->LogBuffer.c_str();
        ImGui::LogFinish();
        const ImGuiWindow* window = ImGui::GetCurrentWindow();
        content_ = window->ContentSize;
        room_ = window->ContentRegionRect.GetSize();
        ImGui::End();
        ImGui::EndFrame();
        return requests;
    }

    void look_at_an_environment() {
        session_.environment.emplace();
        session_.bands = most_bands;
        facts_.environment = EnvironmentFacts{"/a/long/way/down/to/an/environment/of/a/park.hdr", false, 0.0123};
    }

    void look_at_layers() {
        session_.layers.knobs = {{"a_group_of_lamps_with_a_name_that_is_longer_than_any_label"}, {sky_knob}};
    }

    Session session_;
    Facts facts_;
    PanelText text_;
    ImVec2 content_{0, 0};
    ImVec2 room_{0, 0};
    bool forget_sections_ = false;  // which are open
    std::string words_;             // all that was written in the last frame
};

TEST_F(PanelTest, NothingIsWiderThanThePanel) {
    for (const bool environment : {false, true}) {
        environment ? look_at_an_environment() : look_at_layers();
        session_.settings.show_cell = true;
        session_.settings.probes = ProbesShown::all;
        session_.split = true;
        session_.comparison = Comparison::reference;
        facts_.baking = "4096 rays a probe, 100 %";
        facts_.object_reference = "262144 rays";
        for (int i = 0; i < 3; ++i) static_cast<void>(lay_out({800, 600}));
        EXPECT_GT(content_.x, 0.6F * panel_width);
        EXPECT_LE(content_.x, room_.x);
    }
}

TEST_F(PanelTest, LengthsAreInMetresWhateverTheLevelsUnit) {
    session_.motion.speed = 150;
    session_.object.size = 25;
    session_.pose.eye = {100, 160, 0};
    facts_.metres_per_unit = 0.01;
    static_cast<void>(lay_out({800, 3000}));
    for (const char* length : {"28 x 8 x 23, 0.01 m", "1.5 m/s", "0.25 m", "100.00 160.00 0.00"})
        EXPECT_NE(words_.find(length), std::string::npos) << length << "\n" << words_;
    EXPECT_EQ(session_.object.size, 25);
}

/// Clicks at every few pixels reach every control of the light and its environment, and none leads to where settings must
/// not be.
class Sweep : public PanelTest, public testing::WithParamInterface<bool> {
  protected:
    void note(const char* name, bool differs) {
        if (differs) changed_.insert(name);
    }
    void note_changes(const Settings& was, const Session& before) {
        const Settings& now = session_.settings;
        note("level", now.level_light != was.level_light);
        note("object", now.object_light != was.object_light);
        note("filter", now.filter != was.filter);
        note("bands", now.bands != was.bands);
        note("dering", now.dering != was.dering);
        note("half", now.half != was.half);
        note("contact shadow", now.contact_shadow != was.contact_shadow);
        note("self-shadowing", now.self_shadowing != was.self_shadowing);
        note("colours", now.level_colors != was.level_colors);
        note("probes", now.probes != was.probes);
        note("cell", now.show_cell != was.show_cell);
        note("crowd", now.show_crowd != was.show_crowd);
        note("gain", now.gain != was.gain);
        note("exposure", now.exposure_stops != was.exposure_stops);
        note("automatic exposure", now.automatic_exposure != was.automatic_exposure);
        note("tone", now.tone != was.tone);
        note("background", now.background != was.background);
        note("split", session_.split != before.split);
        note("comparison", session_.comparison != before.comparison);
        note("follow", session_.object_mode != before.object_mode);
        note("size", session_.object.size != before.object.size);
        note("record", session_.recorded.has_value());
        note("fly", session_.flown_s.has_value());
        note("help", session_.show_help);
        note("panel", !session_.show_panel);
        for (std::size_t i = 0; i < session_.layers.knobs.size(); ++i) {
            note("layer", i == 0 && session_.layers.knobs[i].weight != before.layers.knobs[i].weight);
            note("sky", i == 1 && session_.layers.knobs[i].weight != before.layers.knobs[i].weight);
        }
        note("sky from", session_.layers.sky != before.layers.sky);
        note("sky turned", session_.layers.sky_turned_deg != before.layers.sky_turned_deg);
        if (!session_.environment) return;
        note("samples", session_.environment->samples != before.environment->samples);
        note("sampling", session_.environment->sampling != before.environment->sampling);
        note("turned", session_.environment->turned_deg != before.environment->turned_deg);
        note("turning", session_.turning);
    }
    [[nodiscard]] bool is_in_range() const {
        const Settings& now = session_.settings;
        const bool samples = !session_.environment || (session_.environment->samples >= fewest_environment_samples &&
                                                       session_.environment->samples <= most_environment_samples);
        for (const LayerKnob& knob : session_.layers.knobs) {
            if (knob.weight < 0 || knob.weight > most_layer_weight) return false;
        }
        return samples && now.bands >= 1 && now.bands <= session_.bands &&
               std::abs(std::log2(now.gain)) <= most_stops && std::abs(now.exposure_stops) <= most_stops &&
               session_.object.size > 0 && static_cast<int>(now.level_light) < 4 &&
               static_cast<int>(now.object_light) < 4;
    }

    std::set<std::string> changed_;
};

TEST_P(Sweep, ReachesEveryControl) {
    const bool environment = GetParam();
    environment ? look_at_an_environment() : look_at_layers();
    Flight flight;
    flight.keys.resize(2);
    flight.keys[1].time_s = 1;
    const Session before = session_;
    std::set<Action> actions;
    for (float x = 20; x < panel_width - 20; x += 45) {
        for (float y = 10; y < 1400; y += 5) {
            forget_sections_ = true;  // what was closed is open again
            const Settings was = session_.settings;
            session_.flight = flight;
            // There, and where a list that has come up may have an entry.
            for (const float below : {0.0F, 20.0F, 0.0F, 37.0F, 0.0F, 54.0F}) {
                for (const bool pressed : {false, true, false}) {
                    const Requests requests = lay_out({1280, 1500}, {x, y + below}, pressed);
                    actions.insert(requests.actions.begin(), requests.actions.end());
                    note_changes(was, before);
                }
            }
            ASSERT_TRUE(is_in_range()) << x << ", " << y;
        }
    }
    std::vector<const char*> names{"object",     "filter",     "bands",
                                   "dering",     "half",       "self-shadowing",
                                   "gain",       "exposure",   "automatic exposure",
                                   "tone",       "background", "split",
                                   "comparison", "follow",     "size",
                                   "record",     "fly",        "help",
                                   "panel"};
    if (environment) {
        names.insert(names.end(), {"samples", "sampling", "turned", "turning"});
    } else {
        names.insert(names.end(), {"level", "contact shadow", "colours", "probes", "cell", "crowd", "layer", "sky",
                                   "sky from", "sky turned"});
    }
    for (const char* name : names) EXPECT_TRUE(changed_.contains(name)) << name;
    for (const Action action :
         {Action::sphere, Action::bunny, Action::own_object, Action::no_object, Action::screenshot}) {
        EXPECT_TRUE(actions.contains(action)) << static_cast<int>(action);
    }
    EXPECT_EQ(actions.contains(Action::next_environment), environment);
}

INSTANTIATE_TEST_SUITE_P(LevelAndEnvironment, Sweep, testing::Bool());

}  // namespace
}  // namespace lightgrid
