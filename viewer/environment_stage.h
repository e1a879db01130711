#pragma once

#include "core/environment_file.h"
#include "viewer/environment_light.h"
#include "viewer/facts.h"
#include "viewer/renderer.h"
#include "viewer/session.h"

#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>

namespace lightgrid {

/// An environment to be shown without a level.
struct EnvironmentShow {
    Environment environment;
    std::string name;            // in words
    std::filesystem::path file;  // that it came from; empty: none
    EnvironmentOptions options;  // that others are read with, too
    EnvironmentChoice choice;
};

/// A flight round an object of 1 m at (0, 0, 0).
[[nodiscard]] Flight orbit();
/// What sees all of it.
[[nodiscard]] Lens orbit_lens();

/// An environment while it is shown: its coefficients follow what the session chooses.
class EnvironmentStage {
  public:
    /// Keeps references to all but `show`.
    EnvironmentStage(EnvironmentShow show, Renderer& renderer, Session& session, Tell tell);

    [[nodiscard]] const std::string& name() const { return show_.name; }

    /// Brings the renderer what has changed. Before every frame.
    void update();
    /// Reads another environment meanwhile; one that cannot be read leaves the old one in place.
    void load(const std::filesystem::path& file);
    /// The next one of its folder.
    void load_next();
    void complete(Frame& frame) const;
    void complete(Facts& facts) const;

  private:
    /// An environment with what takes long to find out of it.
    struct Loaded {
        Environment environment;
        Sh36 reference{};
        std::filesystem::path file;
        std::string problem;  // why there is none
    };
    [[nodiscard]] static Loaded load_whole(const std::filesystem::path& file, const EnvironmentOptions& options);

    EnvironmentShow show_;
    Renderer& renderer_;
    Session& session_;
    Tell tell_;
    Sh36 reference_{};
    Sh36 sampled_{};
    std::shared_ptr<const LitVolume> volume_;
    std::optional<EnvironmentChoice> shown_;  // what volume_ is for; none: nothing yet
    std::filesystem::path tried_;             // the last file that was asked for
    std::future<Loaded> loading_;
};

}  // namespace lightgrid
