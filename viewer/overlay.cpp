#include "viewer/overlay.h"

#include "viewer/overlay_panel.h"
#include "viewer/sphere_pair.h"
#include "viewer/window.h"

#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <deque>
#include <string_view>
#include <vector>

namespace lightgrid {
namespace {

using Clock = std::chrono::steady_clock;

// In units of the display's scale.
constexpr float font_pixels = 13;
constexpr float least_width = 640;  // of a window that has room for the panel
constexpr float margin = 8;

constexpr std::chrono::seconds told_for{8};
constexpr std::size_t most_told = 3;

constexpr ImGuiWindowFlags fixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav |
                                   ImGuiWindowFlags_NoFocusOnAppearing;
constexpr ImGuiWindowFlags only_seen = fixed | ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_AlwaysAutoResize;

ImTextureID texture_id(GLuint name) {
    return reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(name));  // NOLINT(performance-no-int-to-ptr)
}

std::string lux(glm::vec3 light) {
    return fmt::format("{:7.3g} {:7.3g} {:7.3g}", light.r, light.g, light.b);
}

/// The picture's place, in the library's units.
struct Area {
    ImVec2 corner;
    ImVec2 size;
    float scale = 1;

    [[nodiscard]] float right() const { return corner.x + size.x; }
    [[nodiscard]] float bottom() const { return corner.y + size.y; }
};

void label(ImDrawList& list, ImVec2 at, const std::string& text, float rim) {
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    list.AddRectFilled({at.x - rim, at.y - rim}, {at.x + size.x + rim, at.y + size.y + rim}, IM_COL32(0, 0, 0, 170),
                       rim);
    list.AddText(at, IM_COL32_WHITE, text.c_str());
}

/// What each side of a split screen is, at its foot; lines between them.
void lay_out_names(const std::vector<Side>& sides, const Area& area) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const float width = area.size.x / static_cast<float>(sides.size());
    for (std::size_t i = 0; i < sides.size(); ++i) {
        const float from = area.corner.x + width * static_cast<float>(i);
        if (i > 0) list.AddLine({from, area.corner.y}, {from, area.bottom()}, IM_COL32(255, 255, 255, 160));
        if (sides[i].name.empty()) continue;
        const ImVec2 size = ImGui::CalcTextSize(sides[i].name.c_str());
        label(list, {from + 0.5F * (width - size.x), area.bottom() - margin * area.scale - size.y}, sides[i].name,
              4 * area.scale);
    }
}

/// A ring round a point of the level, on every side that sees it.
void mark(const Session& session, glm::dvec3 position, std::size_t sides, const Area& area) {
    const float width = area.size.x / static_cast<float>(sides);
    const glm::vec4 clip =
        clip_from_level(session.pose, session.lens, width / area.size.y, position) * glm::vec4(0, 0, 0, 1);
    if (clip.w <= 0 || std::abs(clip.x) > clip.w || std::abs(clip.y) > clip.w) return;
    const glm::vec2 at = 0.5F + 0.5F * glm::vec2(clip.x, -clip.y) / clip.w;
    for (std::size_t i = 0; i < sides; ++i) {
        const ImVec2 center(area.corner.x + width * (static_cast<float>(i) + at.x), area.corner.y + area.size.y * at.y);
        ImDrawList& list = *ImGui::GetBackgroundDrawList();
        list.AddCircle(center, 6 * area.scale, IM_COL32_BLACK, 0, 3 * area.scale);
        list.AddCircle(center, 6 * area.scale, IM_COL32_WHITE, 0, 1.5F * area.scale);
    }
}

/// Light that was clicked at, in the upper left: two spheres and their numbers. (Legends are in the upper right.)
void lay_out_clicked(const ClickedLight& clicked, GLuint spheres, const Area& area, Requests& requests) {
    const ImVec2 picture(static_cast<float>(SpherePair::size.x) * area.scale,
                         static_cast<float>(SpherePair::size.y) * area.scale);
    ImGui::SetNextWindowPos({area.corner.x + margin * area.scale, margin * area.scale});
    ImGui::SetNextWindowBgAlpha(0.8F);
    ImGui::Begin("clicked", nullptr, fixed | ImGuiWindowFlags_AlwaysAutoResize);
    ImGui::Text("Light %s", clicked.on_surface ? "on the surface" : "towards the eye");
    ImGui::SameLine(picture.x);
    if (ImGui::SmallButton("x")) requests.forget_click = true;
    ImGui::TextDisabled("%.2f %.2f %.2f", clicked.position.x, clicked.position.y, clicked.position.z);
    if (clicked.samples == 0) {
        ImGui::TextUnformatted("is being traced ...");
    } else {
        if (spheres != 0) ImGui::Image(texture_id(spheres), picture, {0, 1}, {1, 0});
        ImGui::TextUnformatted("volume");
        ImGui::SameLine(0.5F * picture.x + ImGui::GetStyle().WindowPadding.x);
        ImGui::TextUnformatted("path tracer");
        ImGui::TextDisabled("lux       R       G       B");
        ImGui::Text("vol %s", lux(clicked.irradiance.volume).c_str());
        ImGui::Text("ref %s", lux(clicked.irradiance.reference).c_str());
        ImGui::TextDisabled(" +- %s", lux(clicked.irradiance.reference_error).c_str());
        if (std::isfinite(clicked.irradiance.relative)) {
            ImGui::Text("difference %+.1f %%", 100.0 * static_cast<double>(clicked.irradiance.relative));
        } else {
            ImGui::TextUnformatted("it should be dark here");
        }
        ImGui::TextDisabled("%u rays%s", clicked.samples, clicked.last ? "" : " ...");
    }
    ImGui::End();
}

void lay_out_help(const Area& area, bool& open) {
    const ImVec2 middle(area.corner.x + 0.5F * area.size.x, area.corner.y + 0.5F * area.size.y);
    ImGui::SetNextWindowPos(middle, ImGuiCond_Always, {0.5F, 0.5F});
    ImGui::SetNextWindowSizeConstraints({0, 0}, {area.size.x, area.size.y});
    ImGui::SetNextWindowBgAlpha(0.92F);
    ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, ImVec2(4 * area.scale, area.scale));
    ImGui::Begin("Keys and mouse", &open,
                 ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoNav);
    if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
        const auto row = [](std::string_view name, std::string_view help) {
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(name.data(), name.data() + name.size());
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(help.data(), help.data() + help.size());
        };
        for (const auto& [name, help] : motion_bindings()) row(name, help);
        for (const KeyBinding& binding : key_bindings()) row(binding.name, binding.help);
        ImGui::EndTable();
    }
    ImGui::End();
    ImGui::PopStyleVar();
}

}  // namespace

struct Overlay::State {
    struct Told {
        std::string text;
        Clock::time_point until;
    };
    Window& window;
    float scale = 1;
    std::deque<Told> told;
    PanelText text;

    /// Where a pixel of the framebuffer is to the library, which counts in the window's own units.
    [[nodiscard]] static float units(int pixels) {
        return static_cast<float>(pixels) / ImGui::GetIO().DisplayFramebufferScale.x;
    }

    /// Messages of the last seconds, in the lower left, above the names of sides.
    void lay_out_told(const Area& area);
};

Overlay::Overlay(Window& window) : state_(std::make_unique<State>(State{window, 1, {}, {}})) {
    float y = 1;
    glfwGetWindowContentScale(window.handle(), &state_->scale, &y);
    state_->scale = std::max(state_->scale, 1.0F);
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;  // leaves no file behind
    ImFontConfig font;
    font.SizePixels = std::floor(font_pixels * state_->scale);
    io.Fonts->AddFontDefault(&font);
    ImGui::StyleColorsDark();
    ImGuiStyle& style = ImGui::GetStyle();
    style.WindowRounding = style.FrameRounding = 3;
    style.WindowBorderSize = 0;
    style.FramePadding = {4, 2};
    style.ItemSpacing = {8, 3};
    style.ScaleAllSizes(state_->scale);
    ImGui_ImplGlfw_InitForOpenGL(window.handle(), true);
    ImGui_ImplOpenGL3_Init("#version 330 core");
}

Overlay::~Overlay() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
}

Overlay::Layout Overlay::begin(const Session& session, glm::ivec2 size) {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    Layout layout{0, size};
    if (session.show_panel && State::units(size.x) >= least_width * state_->scale) {
        layout.panel = static_cast<int>(panel_width * state_->scale * ImGui::GetIO().DisplayFramebufferScale.x);
        layout.picture.x -= layout.panel;
    }
    return layout;
}

Input Overlay::what_is_left(Input input, const Layout& layout) const {
    const ImGuiIO& io = ImGui::GetIO();
    input.cursor.x -= layout.panel;
    if (io.WantCaptureMouse) {
        input.clicked.clear();
        input.buttons.clear();
        input.wheel = 0;
    }
    if (io.WantTextInput) {
        input.pressed.clear();
        input.held.clear();
    }
    return input;
}

void Overlay::lay_out(Session& session, const Facts& facts, const Layout& layout, GLuint spheres, Requests& requests) {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const float panel = State::units(layout.panel);
    const Area area{{panel, 0}, {display.x - panel, display.y}, state_->scale};
    if (layout.panel > 0) {
        ImGui::SetNextWindowPos({0, 0});
        ImGui::SetNextWindowSize({panel, display.y});
        ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
        ImGui::Begin("panel", nullptr, fixed);
        lay_out_panel(session, facts, state_->text, requests);
        ImGui::End();
        ImGui::PopStyleVar();
    }
    const std::vector<Side> sides = sides_of(session);
    if (session.show_help) {
        lay_out_help(area, session.show_help);
        return;
    }
    lay_out_names(sides, area);
    if (facts.clicked) {
        mark(session, facts.clicked->position, sides.size(), area);
        lay_out_clicked(*facts.clicked, spheres, area, requests);
    }
    state_->lay_out_told(area);
}

void Overlay::State::lay_out_told(const Area& area) {
    while (!told.empty() && told.front().until < Clock::now()) told.pop_front();
    if (told.empty()) return;
    const float width = area.size.x - 2 * margin * scale;
    const float foot = area.bottom() - 2 * margin * scale - 2 * ImGui::GetTextLineHeight();
    ImGui::SetNextWindowPos({area.corner.x + margin * scale, foot}, ImGuiCond_Always, {0, 1});
    ImGui::SetNextWindowBgAlpha(0.7F);
    ImGui::Begin("told", nullptr, only_seen);
    ImGui::PushTextWrapPos(width - 2 * ImGui::GetStyle().WindowPadding.x);
    for (const Told& one : told) ImGui::TextUnformatted(one.text.data(), one.text.data() + one.text.size());
    ImGui::PopTextWrapPos();
    ImGui::End();
}

void Overlay::draw() {
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Overlay::tell(const std::string& text) {
    if (state_->told.size() == most_told) state_->told.pop_front();
    state_->told.push_back({text, Clock::now() + told_for});
}

}  // namespace lightgrid
