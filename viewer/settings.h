#pragma once

#include <cstdint>

/// Everything that a person can switch while looking. The renderer reads it; keys, command line and overlay write it.
namespace lightgrid {

enum class LevelLight : std::uint8_t { none, constant, vertex, pixel };
/// object: one look-up for all of it. reference: what the path tracer says there, where the frame knows (Frame).
enum class ObjectLight : std::uint8_t { constant, object, pixel, reference };
/// In false colours: irradiance, its standard error, and by how much it differs from the path tracer (ReferenceMap).
enum class LevelColors : std::uint8_t { surface, irradiance, standard_error, difference };
inline constexpr int level_colors_count = 4;
enum class ProbesShown : std::uint8_t { none, in_sight, all };  // all: through walls, too
enum class Filter : std::uint8_t { trilinear, nearest };
enum class Background : std::uint8_t { none, picture, light };  // light: as the coefficients at the eye have it
enum class Tone : std::uint8_t { film, reinhard, linear };

/// How one picture is lit and drawn; split screen draws two.
struct Settings {
    LevelLight level_light = LevelLight::vertex;
    ObjectLight object_light = ObjectLight::object;
    Filter filter = Filter::trilinear;
    int bands = 3;  // that are used of those there are, 1 .. most_bands; the level's surfaces use 3 at most
    bool dering = true;
    bool half = false;           // rounded as half storage would
    bool contact_shadow = true;  // of the object on the level
    bool self_shadowing = true;  // of the object
    LevelColors level_colors = LevelColors::surface;
    ProbesShown probes = ProbesShown::none;
    bool show_cell = false;   // that the object is in
    bool show_crowd = false;  // a thousand objects
    bool show_object = true;
    Background background = Background::picture;

    float gain = 1;  // of the light from the volume, against emission and background
    float exposure_stops = 0;
    bool automatic_exposure = true;  // by the light around the eye; else 1 cd/m^2 is white
    Tone tone = Tone::film;

    bool operator==(const Settings&) const = default;
};

/// Of exposure and gain, either way: what exceeds it is cut off.
inline constexpr float most_stops = 16;
inline constexpr int most_bands = 6;

}  // namespace lightgrid
