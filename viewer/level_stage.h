#pragma once

#include "probes/paths.h"
#include "viewer/background_answer.h"
#include "viewer/background_bake.h"
#include "viewer/default_flight.h"
#include "viewer/facts.h"
#include "viewer/reference_probe.h"
#include "viewer/renderer.h"
#include "viewer/session.h"
#include "viewer/volume_watch.h"

#include <glm/glm.hpp>

#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>

namespace lightgrid {

/// A level to be shown, and where its light comes from.
struct LevelShow {
    const PathTracer& paths;                  // with the level and its environment; must outlive the show
    std::string environment;                  // in words, for the header of what is baked
    std::shared_ptr<const LitVolume> volume;  // none: one is baked while it is shown
    std::optional<VolumeWatch> watch;         // of the file that it came from
};

/// A level while it is shown: brings what other threads bake, reload and trace before the renderer.
class LevelStage {
  public:
    /// Keeps references to all but `show`.
    LevelStage(LevelShow show, Renderer& renderer, Session& session, Tell tell);
    ~LevelStage();

    [[nodiscard]] const std::string& name() const { return scene_.name; }

    /// What other threads have finished. Before every frame.
    void update();
    /// Asks for the light where a person clicked: at the surface there, or at the object; where nothing is, as far from
    /// the eye as an object that follows.
    void ask(const Click& click);
    void forget_click();
    /// Takes an environment for the sky, where the volume has layers for any.
    void take_sky(const std::filesystem::path& file);
    /// Turns such a sky on, or shows the next one.
    void next_sky();
    /// Moves the camera to where the volume differs most from the path tracer, of what is known yet; then to the next such
    /// place. Asks for the light there.
    void show_next_worst();
    void complete(Frame& frame) const;
    void complete(Facts& facts) const;

    static constexpr int reference_bands = 5;  // A_5 = 0, and A_6 is 1.6 % of A_0

  private:
    void take(const std::shared_ptr<const LitVolume>& volume);
    /// Lights the level as the session mixes layers.
    void mix();
    void show_sky(SkyShown shown);
    void follow_object();
    /// Has the map of differences traced where it is wanted, and brings the renderer what is known of it.
    void follow_map();
    [[nodiscard]] std::optional<ClickedLight> clicked_light() const;

    LevelShow show_;
    const Scene& scene_;
    Renderer& renderer_;
    Session& session_;
    Tell tell_;
    std::shared_ptr<const LitVolume> baked_;
    std::shared_ptr<const LitVolume> volume_;  // that is shown: as baked, or its layers mixed anew
    LayerMix mix_as_baked_;
    LayerMix mixed_;  // that volume_ is
    Environment sky_of_file_;
    std::optional<SkyShown> sky_shown_;
    Sh36 sky_radiance_{};  // of that
    VolumeSummary summary_;
    std::optional<double> spacing_;  // that the level has been divided for
    std::optional<BackgroundBake> bake_;
    std::future<DefaultFlight> default_flight_;
    bool default_flight_known_ = false;

    /// One point at a time.
    struct Reference {
        std::optional<glm::dvec3> asked;  // where
        std::optional<ReferenceLight> light;
        std::optional<ReferenceProbe> probe;  // since it was first wanted; last: its thread ends first

        void ask(const PathTracer& paths, glm::dvec3 position, glm::vec3 normal);
        void update();
    };
    std::shared_ptr<const ReferenceMap> map_;
    std::shared_ptr<const ReferenceMap> map_shown_;  // none while the light is not as it was baked
    bool map_is_wanted_ = false;                     // since somebody asked for it
    std::vector<glm::vec3> worst_shown_;             // places that have been gone to
    struct MapQuestion {
        std::shared_ptr<const LitVolume> volume;
    };
    std::optional<BackgroundAnswer<MapQuestion, std::shared_ptr<const ReferenceMap>>> map_tracer_;

    Reference at_object_;
    Reference at_click_;
    bool clicked_surface_ = false;
};

}  // namespace lightgrid
