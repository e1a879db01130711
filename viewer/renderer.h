#pragma once

#include "core/environment.h"
#include "core/scene.h"
#include "viewer/draw_background.h"
#include "viewer/draw_balls.h"
#include "viewer/draw_label.h"
#include "viewer/draw_level.h"
#include "viewer/draw_lines.h"
#include "viewer/draw_object.h"
#include "viewer/exposure.h"
#include "viewer/picture_target.h"
#include "viewer/reference_map.h"

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace lightgrid {

/// What is looked at, and from where.
struct Frame {
    Pose pose;
    Lens lens;
    std::optional<ObjectPlace> object{};
    double time_s = 0;                // of what moves by itself
    std::optional<Sh36> reference{};  // radiance at the object as the path tracer has it: ObjectLight::reference
    glm::mat3 environment_turn{1};    // from the environment's own axes to the level's
};

/// A part of the picture with settings of its own: split screen is two of them.
struct Pane {
    Rectangle part;
    Settings settings;
};

/// Everything that is drawn; each kind of thing is a drawing of its own, in a file of its own.
class Renderer {
  public:
    /// `gl` must outlive it, and its context be current wherever it is used.
    Renderer(const Gl& gl, ShaderSources shaders);

    /// Keeps nothing of the scene.
    ///
    /// longest_edge  see build_level_mesh
    /// outlines      see find_outlines
    void set_level(const Scene& scene, double longest_edge, const std::vector<bool>& outlines);
    /// The light; the level is lit anew when it is next drawn.
    void set_volume(std::shared_ptr<const LitVolume> volume);
    /// What each of the level's materials emits is multiplied by; none: 1.
    void set_emission_weights(std::vector<glm::vec3> by_material) { emission_weights_ = std::move(by_material); }
    /// The path tracer's light that LevelColors::difference compares the volume with; none: nothing is known yet.
    void set_reference(std::shared_ptr<const ReferenceMap> map);
    void set_environment(const Environment& environment);
    void set_object(const ObjectMesh& mesh);
    /// The object shadows itself from now on: self_shadowed_transfer of its mesh, of three bands.
    void set_object_transfer(std::span<const float> transfer);

    /// Draws and develops a picture.
    ///
    /// size     pixels
    /// samples  a pixel: 4 smooths edges
    /// panes    at least one; exposure is the first one's
    void draw(const Frame& frame, std::span<const Pane> panes, glm::ivec2 size, int samples);

    /// How the level's surfaces look their light up under these settings: deringed where they say so.
    [[nodiscard]] LookUp level_look_up(const Settings& settings);

    [[nodiscard]] const PictureTarget& target() const noexcept { return target_; }
    /// The last picture's.
    [[nodiscard]] float exposure() const noexcept { return exposure_; }
    /// Look-ups in the volume for the last picture.
    [[nodiscard]] std::size_t look_ups() const noexcept { return look_ups_; }
    /// Of all light: coefficients in memory and tables on the card.
    [[nodiscard]] std::size_t bytes_of_light() const;
    [[nodiscard]] RadianceImage read_light() const { return target_.read_light(exposure_); }

  private:
    /// How a volume is stored for a look-up.
    struct Storage {
        bool half = false;
        int deringed = 0;  // so many bands; 0: as it rings

        bool operator==(const Storage&) const = default;
    };
    /// The level's light under some settings.
    struct LightTable {
        Filter filter;
        int bands;
        Storage storage;
        bool is_difference;  // its shares are differences from the reference
        TexelBuffer table;
        std::size_t bytes = 0;
    };
    /// A volume in one of its forms; what is made of it when it is first asked for.
    struct Stored {
        Storage storage{};
        std::shared_ptr<const LitVolume> volume{};
        std::optional<VolumeOnCard> on_card{};
        std::optional<BallTable> probes{};
    };

    void draw_pane(const Frame& frame, const Pane& pane);
    void draw_object(const Eye& eye, const Frame& frame, const Settings& settings, const LookUp& light);
    void draw_data(const Eye& eye, const Frame& frame, const Settings& settings, const LookUp& light);
    void draw_legend(const Pane& pane);
    [[nodiscard]] LogScale scale_for(LevelColors what) const;
    /// As `settings` want it for objects, which are deringed one by one, and for the level's surfaces.
    [[nodiscard]] Storage storage_of(const Settings& settings) const;
    [[nodiscard]] Storage level_storage_of(const Settings& settings) const;
    [[nodiscard]] Stored& stored(const Storage& storage);
    [[nodiscard]] LookUp look_up_with(const Settings& settings);
    [[nodiscard]] const TexelBuffer& light_table(const Settings& settings);
    [[nodiscard]] std::vector<VertexLight> differences(const Settings& settings);
    [[nodiscard]] PixelLight pixel_light(const Settings& settings);
    [[nodiscard]] LevelDrawing::Light level_light(const Frame& frame, const Settings& settings, const LookUp& light);

    const Gl& gl_;
    ShaderSources shaders_;
    PictureTarget target_;
    BackgroundDrawing background_;
    std::optional<LevelDrawing> level_;
    std::optional<ObjectDrawing> object_;
    std::shared_ptr<const ReferenceMap> reference_;
    glm::dvec3 origin_{0};
    float level_size_ = 0;        // diagonal, metres
    float albedo_ = grey_albedo;  // of the level
    std::vector<glm::vec3> emission_weights_;
    BallDrawing balls_;
    LineDrawing lines_;
    std::vector<Stored> stored_;  // as it was baked, and those that were asked for since
    std::vector<LightTable> light_tables_;
    std::optional<LightScales> scales_;  // of the first light table of the volume
    std::optional<LabelDrawing> irradiance_legend_;
    std::optional<LabelDrawing> error_legend_;
    std::optional<LabelDrawing> difference_legend_;
    float exposure_ = 1;
    std::size_t look_ups_ = 0;
};

}  // namespace lightgrid
