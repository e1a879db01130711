#include "viewer/interactive.h"

#include "core/error.h"
#include "viewer/background_bake.h"
#include "viewer/default_flight.h"
#include "viewer/outlines.h"
#include "viewer/session.h"
#include "viewer/window.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <future>
#include <limits>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// A volume that is baked while one looks is no larger than that a person waits for it.
constexpr std::int64_t probes_while_shown = 8192;
constexpr double title_every_s = 0.5;

/// The first of NAME_0001.EXTENSION ... that is not there yet, in the current folder.
fs::path unused_name(const std::string& stem, const std::string& extension) {
    for (int number = 1;; ++number) {
        fs::path path = fmt::format("{}_{:04}.{}", stem, number, extension);
        if (!fs::exists(path)) return path;
    }
}

class Interactive {
  public:
    explicit Interactive(Show show)
        : show_(std::move(show)),
          scene_(show_.paths.tracer().scene()),
          window_("fly-through: " + scene_.name, show_.size),
          renderer_(window_.gl(), show_.shaders) {
        const double diagonal = glm::length(scene_.bounds.size());
        session_.motion.speed = 0.1 * diagonal;
        session_.object.size = static_cast<float>(0.03 * diagonal);
        session_.lens = lens_for(diagonal, session_.object.size);
        session_.pose = looking_at(scene_.bounds.center(), scene_.bounds.center() + glm::dvec3(0, 0, -1));
        if (show_.flight) {
            session_.flight = std::move(show_.flight);
            session_.pose = evaluate(*session_.flight, session_.flight->start_s()).pose;
            session_.touched = true;
        }
        renderer_.set_environment(show_.paths.environment());
        renderer_.set_object(show_.object ? *show_.object : make_sphere());
        if (show_.volume == nullptr) {
            renderer_.set_level(scene_, std::numeric_limits<double>::infinity(),
                                std::vector<bool>(scene_.materials.size(), false));
            BakeOptions options;
            options.placement.max_probes = probes_while_shown;
            options.environment = show_.environment;
            bake_.emplace(show_.paths, options);
        } else {
            take(show_.volume);
        }
        tell("F1 lists what keys and mouse do");
    }

    void run() {
        Clock::time_point before = Clock::now();
        while (!window_.should_close()) {
            const Input input = window_.poll();
            const Clock::time_point now = Clock::now();
            const double seconds = std::chrono::duration<double>(now - before).count();
            before = now;
            look_for_news();
            const glm::ivec2 size = window_.size();
            const Requests requests = step(session_, input, seconds, size);
            for (const Action action : requests.actions) act(action);
            if (requests.recording) save_recording(*requests.recording);
            if (size.x < 1 || size.y < 1) continue;  // minimised
            renderer_.draw(frame_of(session_), panes_of(session_, size), size, is_software(window_.gl()) ? 1 : 4);
            renderer_.target().show();
            window_.swap();
            show_time(seconds);
        }
    }

  private:
    void tell(const std::string& text) const {
        if (!show_.quiet) fmt::print(stderr, "fly-through: {}\n", text);
    }

    void take(const std::shared_ptr<const LitVolume>& volume) {
        if (!has_spacing_ || volume->spacing != spacing_) {
            renderer_.set_level(scene_, volume->spacing, find_outlines(show_.paths.tracer(), volume->volume));
            spacing_ = volume->spacing;
            has_spacing_ = true;
        }
        renderer_.set_volume(volume);
        if (!default_flight_known_) {
            default_flight_known_ = true;
            default_flight_ = std::async(std::launch::async, [&tracer = show_.paths.tracer(), volume] {
                return make_default_flight(tracer, *volume);
            });
        }
    }

    /// What other threads have finished.
    void look_for_news() {
        if (bake_) {
            if (std::optional<BakedVolume> baked = bake_->take()) {
                tell(fmt::format("baked with {} rays a probe, noise {:.2g} %", baked->samples, 100 * baked->noise));
                take(std::make_shared<const LitVolume>(std::move(baked->volume)));
            }
        }
        if (show_.watch) {
            if (std::optional<VolumeWatch::News> news = show_.watch->poll()) {
                tell(news->notice);
                if (news->volume) take(std::make_shared<const LitVolume>(std::move(*news->volume)));
            }
        }
        if (default_flight_.valid() && default_flight_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
            DefaultFlight found = default_flight_.get();
            session_.object.size = static_cast<float>(found.object_size);
            session_.lens = lens_for(glm::length(scene_.bounds.size()), found.object_size);
            session_.motion.speed = 4 * found.object_size;
            if (!session_.flight) session_.flight = std::move(found.flight);
            if (!session_.touched) session_.pose = evaluate(*session_.flight, session_.flight->start_s()).pose;
        }
    }

    void act(Action action) {
        switch (action) {
            case Action::quit:
                window_.close();
                break;
            case Action::help:
                fmt::print(stderr, "{}", controls_help());
                break;
            case Action::screenshot:
                save_screenshot();
                break;
            case Action::sphere:
                show_object(make_sphere());
                break;
            case Action::bunny:
                show_bunny();
                break;
            case Action::own_object:
                if (show_.object) show_object(*show_.object);
                break;
            case Action::no_object:
                session_.settings.show_object = false;
                break;
            default:
                break;
        }
    }

    void show_object(const ObjectMesh& object) {
        renderer_.set_object(object);
        session_.settings.show_object = true;
    }

    void show_bunny() {
        const std::optional<fs::path> path = find_bunny();
        if (!path) {
            tell("the bunny is not installed: it comes with Debian's glmark2-data");
            return;
        }
        try {
            ObjectMesh bunny = load_object(*path);
            fit(bunny, 1);
            show_object(bunny);
        } catch (const Error& error) {
            tell(error.what());
        }
    }

    /// A full disk ends no show.
    void save_screenshot() {
        try {
            const std::string stem = fs::path(scene_.name).stem().string();
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
            const fs::path path = unused_name(fs::path(scene_.name).stem().string() + "_path", "json");
            save_flight(flight, path);
            session_.flight = flight;
            tell(fmt::format("saved {}; P flies along it", path.string()));
        } catch (const Error& error) {
            tell(error.what());
        }
    }

    void show_time(double seconds) {
        ++frames_;
        since_title_s_ += seconds;
        if (since_title_s_ < title_every_s) return;
        window_.set_title(
            fmt::format("fly-through: {}, {:.1f} ms a frame", scene_.name, 1000 * since_title_s_ / frames_));
        since_title_s_ = 0;
        frames_ = 0;
    }

    Show show_;
    const Scene& scene_;
    Window window_;
    Renderer renderer_;
    Session session_;
    std::optional<BackgroundBake> bake_;
    std::future<DefaultFlight> default_flight_;
    bool default_flight_known_ = false;
    bool has_spacing_ = false;
    double spacing_ = 0;
    double since_title_s_ = 0;
    int frames_ = 0;
};

}  // namespace

void show_in_window(Show show) {
    Interactive(std::move(show)).run();
}

}  // namespace lightgrid
