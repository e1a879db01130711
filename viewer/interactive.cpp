#include "viewer/interactive.h"

#include "core/error.h"
#include "core/near_names.h"
#include "viewer/background_object.h"
#include "viewer/overlay.h"
#include "viewer/session.h"
#include "viewer/sphere_pair.h"
#include "viewer/window.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <utility>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double title_every_s = 0.5;

/// The first of NAME_0001.EXTENSION ... that is not there yet, in the current folder.
fs::path unused_name(const std::string& stem, const std::string& extension) {
    for (int number = 1;; ++number) {
        fs::path path = fmt::format("{}_{:04}.{}", stem, number, extension);
        if (!fs::exists(path)) return path;
    }
}

std::string extension_of(const fs::path& file) {
    return lower_case(file.extension().string());
}

/// 1 m large.
ObjectMesh load_fitted(const fs::path& file) {
    ObjectMesh object = load_object(file);
    fit(object, 1);
    return object;
}

class Interactive {
  public:
    explicit Interactive(Show show)
        : quiet_(show.quiet),
          own_object_(std::move(show.object)),
          window_("fly-through", show.size),
          samples_(is_software(window_.gl()) ? 1 : 4),
          renderer_(window_.gl(), show.shaders),
          spheres_(window_.gl(), show.shaders),
          overlay_(window_),
          session_(std::move(show.session)) {
        if (show.flight) {
            session_.flight = std::move(show.flight);
            start_flight(session_);
            session_.touched = true;
        }
        if (own_object_) {
            show_own_object();
        } else {
            show_object([] { return make_sphere(); });
        }
        const Tell tell = [this](const std::string& text) { this->tell(text); };
        if (LevelShow* level = std::get_if<LevelShow>(&show.what)) {
            level_.emplace(std::move(*level), renderer_, session_, tell);
        } else {
            environment_.emplace(std::move(std::get<EnvironmentShow>(show.what)), renderer_, session_, tell);
        }
        tell_terminal("F1 lists what keys and mouse do");
    }

    void run() {
        Clock::time_point before = Clock::now();
        while (!window_.should_close()) {
            const Input raw = window_.poll();
            const Clock::time_point now = Clock::now();
            const double seconds = std::chrono::duration<double>(now - before).count();
            before = now;
            update_object();
            if (level_) level_->update();
            if (environment_) environment_->update();
            const glm::ivec2 size = window_.size();
            if (size.x < 1 || size.y < 1) continue;  // minimised
            time_frame(seconds);
            const bool photograph = std::exchange(photograph_, false);

            const Overlay::Layout layout = overlay_.begin(session_, size);
            Requests requests = step(session_, overlay_.what_is_left(raw, layout), seconds, layout.picture);
            const Facts facts = find_facts();
            overlay_.lay_out(session_, facts, layout, spheres_.texture(), requests);
            carry_out(requests);
            draw(layout, facts);
            if (photograph) save_screenshot();
            window_.swap();
        }
    }

  private:
    void tell_terminal(const std::string& text) const {
        if (!quiet_) fmt::print(stderr, "fly-through: {}\n", text);
    }
    void tell(const std::string& text) {
        tell_terminal(text);
        overlay_.tell(text);
    }

    [[nodiscard]] std::string name() const { return level_ ? level_->name() : environment_->name(); }

    [[nodiscard]] Facts find_facts() const {
        Facts facts;
        facts.frame_ms = frame_ms_;
        facts.look_ups = renderer_.look_ups();
        facts.bytes = renderer_.bytes_of_light();
        if (level_) level_->complete(facts);
        if (environment_) environment_->complete(facts);
        return facts;
    }

    void draw(const Overlay::Layout& layout, const Facts& facts) {
        Frame frame = frame_of(session_);
        if (level_) level_->complete(frame);
        if (environment_) environment_->complete(frame);
        renderer_.draw(frame, panes_of(session_, layout.picture), layout.picture, samples_);
        if (const std::optional<ClickedLight>& clicked = facts.clicked; clicked && clicked->samples > 0) {
            spheres_.draw(clicked->volume, clicked->reference, session_.pose,
                          renderer_.exposure() * session_.settings.gain, session_.settings.tone);
        }
        renderer_.target().show({layout.panel, 0});
        overlay_.draw();
    }

    void carry_out(const Requests& requests) {
        for (const Action action : requests.actions) carry_out(action);
        if (requests.recording) save_recording(*requests.recording);
        if (requests.click && level_) level_->ask(*requests.click);
        if (requests.forget_click && level_) level_->forget_click();
        for (const std::string& file : requests.files) take_file(file);
    }

    void carry_out(Action action) {
        switch (action) {
            case Action::quit:
                window_.close();
                break;
            case Action::screenshot:
                photograph_ = true;
                break;
            case Action::sphere:
                show_object([] { return make_sphere(); });
                break;
            case Action::bunny:
                show_bunny();
                break;
            case Action::own_object:
                if (own_object_) {
                    show_own_object();
                } else {
                    tell("no object of your own: start with --object, or drop a .glb, .gltf or .obj on the window");
                }
                break;
            case Action::no_object:
                session_.settings.show_object = false;
                break;
            case Action::next_worst:
                if (level_) level_->show_next_worst();
                break;
            case Action::next_environment:
                if (environment_) {
                    environment_->load_next();
                } else {
                    level_->next_sky();
                }
                break;
            default:
                break;
        }
    }

    /// As soon as it is loaded; until then, the old one.
    ///
    /// dropped  the file that it is taken from, to be the own object from then on; empty: none
    void show_object(BackgroundObject::Load load, fs::path dropped = {}) {
        loading_.ask(std::move(load));
        dropped_ = std::move(dropped);
        session_.settings.show_object = true;
    }
    void show_own_object() {
        show_object([object = *own_object_] { return object; });
    }

    /// Brings the renderer what has been loaded.
    void update_object() {
        try {
            std::optional<ObjectNews> news = loading_.take();
            if (!news) return;
            if (news->mesh) {
                renderer_.set_object(*news->mesh);
                if (!dropped_.empty()) {
                    own_object_ = std::move(news->mesh);
                    tell(fmt::format("{} is the object now (3)", dropped_.filename().string()));
                    dropped_.clear();
                }
            }
            if (news->transfer) renderer_.set_object_transfer(*news->transfer);
        } catch (const Error& error) {
            tell(error.what());
        }
    }

    /// An object or an environment, by its name's end.
    void take_file(const fs::path& file) {
        const std::string extension = extension_of(file);
        if (extension == ".glb" || extension == ".gltf" || extension == ".obj") {
            show_object([file] { return load_fitted(file); }, file);
        } else if (environment_) {
            environment_->load(file);
        } else if (extension == ".hdr" || extension == ".exr") {
            level_->take_sky(file);
        } else {
            tell(fmt::format("{}: only objects (.glb, .gltf, .obj) and skies (.hdr, .exr) can be dropped into a level",
                             file.string()));
        }
    }

    void show_bunny() {
        const std::optional<fs::path> path = find_bunny();
        if (!path) {
            tell("the bunny is not installed: it comes with Debian's glmark2-data");
            return;
        }
        show_object([file = *path] { return load_fitted(file); });
    }

    /// A full disk ends no show.
    void save_screenshot() {
        try {
            const std::string stem = fs::path(name()).stem().string();
            const fs::path png = unused_name(stem, "png");
            write_png(renderer_.target().read_picture(), png);
            const fs::path exr = fs::path(png).replace_extension("exr");
            write_exr(renderer_.read_light(), exr);
            tell(fmt::format("saved {} and {}", png.string(), exr.string()));
        } catch (const Error& error) {
            tell(error.what());
        }
    }

    void save_recording(const Flight& flight) {
        try {
            const fs::path path = unused_name(fs::path(name()).stem().string() + "_path", "json");
            save_flight(flight, path);
            session_.flight = flight;
            tell(fmt::format("saved {}; P flies along it", path.string()));
        } catch (const Error& error) {
            tell(error.what());
        }
    }

    void time_frame(double seconds) {
        ++frames_;
        since_title_s_ += seconds;
        if (since_title_s_ < title_every_s) return;
        frame_ms_ = 1000 * since_title_s_ / frames_;
        window_.set_title(fmt::format("fly-through: {}, {:.1f} ms a frame", name(), frame_ms_));
        since_title_s_ = 0;
        frames_ = 0;
    }

    bool quiet_;
    std::optional<ObjectMesh> own_object_;
    Window window_;
    int samples_;  // a pixel
    Renderer renderer_;
    SpherePair spheres_;
    Overlay overlay_;
    Session session_;
    std::optional<LevelStage> level_;  // one of the two
    std::optional<EnvironmentStage> environment_;
    fs::path dropped_;  // that the object being loaded is from
    BackgroundObject loading_;
    bool photograph_ = false;  // the next picture, which shows all that was set before
    double frame_ms_ = 0;
    double since_title_s_ = 0;
    int frames_ = 0;
};

}  // namespace

void show_in_window(Show show) {
    Interactive(std::move(show)).run();
}

}  // namespace lightgrid
