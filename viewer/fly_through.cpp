// fly-through: looks at a level and at what its volume of light is worth.

#include "core/error.h"
#include "core/gltf.h"
#include "core/tracer.h"
#include "probes/bake.h"
#include "probes/gather.h"
#include "probes/volume_file.h"
#include "tools/level_options.h"
#include "tools/light_options.h"
#include "tools/program.h"
#include "viewer/controls.h"
#include "viewer/default_flight.h"
#include "viewer/headless.h"
#include "viewer/interactive.h"
#include "viewer/outlines.h"
#include "viewer/session.h"
#include "viewer/transfer.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

struct Call {
    std::string level;
    std::string volume;
    LevelOptions level_options;
    LightOptions light;
    std::string object = "sphere";
    std::string path;
    std::optional<int> samples;
    std::optional<int> bands;
    std::string comparison;
    bool headless = false;
    std::string out;
    std::optional<int> frames;
    std::string size = "1280x720";
    std::string shaders;
    std::string press;
    bool quiet = false;
};

/// Without a VOLUME and without a person who could wait for a better one.
constexpr std::int64_t quick_probes = 4096;
constexpr std::uint32_t quick_samples = 128;

constexpr int samples_per_pixel = 4;
/// Of the reference at the object, in pictures that show it.
constexpr std::uint32_t reference_samples = 1U << 14U;

constexpr std::array<std::pair<std::string_view, Comparison>, 5> comparison_names{{
    {"filter", Comparison::filter},
    {"bands", Comparison::bands},
    {"dering", Comparison::dering},
    {"half", Comparison::half},
    {"reference", Comparison::reference},
}};

constexpr int most_frames = 100'000;  // as many as five digits number

glm::ivec2 parse_size(const std::string& text) {
    glm::ivec2 size(0);
    char rest = 0;
    if (std::sscanf(text.c_str(), "%6dx%6d%c", &size.x, &size.y, &rest) != 2 || size.x < 1 || size.y < 1 ||
        size.x > 16384 || size.y > 16384) {
        throw Error(fmt::format("\"{}\" is no size in pixels, like 1280x720, from 1x1 to 16384x16384", text));
    }
    return size;
}

Comparison parse_comparison(const std::string& text) {
    std::string names;
    for (const auto& [name, comparison] : comparison_names) {
        if (name == text) return comparison;
        names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
    }
    throw Error(fmt::format("\"{}\" is nothing to compare: {}", text, names));
}

void add_options(CLI::App& app, Call& call) {
    app.add_option("level", call.level, "The level, .gltf or .glb; none: the object in an --environment alone")
        ->type_name("LEVEL");
    app.add_option("volume", call.volume, "Its light, as level-bake wrote it; none: a quick one is baked")
        ->type_name("VOLUME");
    add_level_options(app, call.level_options);
    app.add_option("--object", call.object, "What flies through: sphere, bunny, or a .glb, .gltf or .obj file")
        ->type_name("OBJECT")
        ->capture_default_str();
    app.add_option("--path", call.path, "Flies along this path (default: one through the level's free space)")
        ->type_name("P.json");
    app.add_option("--bands", call.bands, "SH bands of the light that are used (default 3)")
        ->type_name("N")
        ->check(number(1, most_bands, true));
    app.add_option("--samples", call.samples, "Without a LEVEL: directions of the environment that are looked at")
        ->type_name("N")
        ->check(number(fewest_environment_samples, most_environment_samples, true));
    app.add_option("--compare", call.comparison, "Split screen: filter, bands, dering, half or reference")
        ->type_name("WHAT")
        ->check(checked([](const std::string& text) { static_cast<void>(parse_comparison(text)); }));
    app.add_option("--size", call.size, "Of window or pictures")
        ->type_name("WxH")
        ->check(checked([](const std::string& text) { static_cast<void>(parse_size(text)); }))
        ->capture_default_str();
    app.add_option("--shaders", call.shaders, "Takes shaders from this folder that have the name of a built-in one")
        ->type_name("DIR");
    app.add_option("--press", call.press, "Starts with the settings that these keys switch to (help: F1 in the window)")
        ->type_name("KEYS")
        ->check(checked([](const std::string& text) { static_cast<void>(settings_after(text)); }));
    add_light_options(app, call.light);

    const char* pictures = "Pictures without a display";
    app.add_flag("--headless", call.headless, "Renders frame_00000.png ... instead of opening a window")
        ->group(pictures);
    app.add_option("--out", call.out, "The folder for them; made if need be. Frames of an earlier run are removed")
        ->type_name("DIR")
        ->group(pictures);
    app.add_option("--frames", call.frames, "How many, spread evenly over the path (default: as its rate asks for)")
        ->type_name("N")
        ->check(number(1, most_frames, true))
        ->group(pictures);
    app.set_version_flag("--version", "fly-through " LIGHTGRID_VERSION);
    app.add_flag("--quiet", call.quiet, "Nothing but errors");
    app.footer("In the window:\n" + controls_help());
}

/// What is wrong with the call beyond single values: all of it in one message.
void check(const Call& call) {
    std::vector<std::string> wrong;
    const bool has_light = !call.light.environment.empty() || !call.light.sky.empty() || !call.light.sun_sky.empty();
    if (call.level.empty() && !has_light) {
        wrong.emplace_back("no LEVEL: name a .gltf or .glb file, or an --environment to look at alone");
    }
    if (call.level.empty()) {
        for (const std::string& name : names_of(call.level_options)) wrong.push_back(name + " belongs to a LEVEL");
    }
    if (!call.level.empty() && call.samples) wrong.emplace_back("--samples is for an --environment without a LEVEL");
    if (call.headless && call.out.empty()) wrong.emplace_back("--headless needs a folder for its pictures: --out DIR");
    if (!call.headless && !call.out.empty()) wrong.emplace_back("--out belongs to --headless");
    if (!call.headless && call.frames) wrong.emplace_back("--frames belongs to --headless");
    if (!wrong.empty()) throw Error(fmt::format("{}", fmt::join(wrong, "; ")), "", "See fly-through --help");
}

Box bounds_of_cells(const Volume& volume) {
    Box box;
    for (const Grid& grid : volume.grids) {
        box.extend(grid.origin);
        box.extend(grid.position(grid.counts - 1));
    }
    return box;
}

/// A volume of another level is told apart by its place, and suspected by its name; one of other light, by what it says.
///
/// environment  what is around the level, in words; empty: nothing is
void check_volume_of(const Scene& scene, const std::string& environment, const Volume& volume,
                     const std::string& path) {
    if (!volume.has_cells()) {
        throw Error("is a probe list: it has no cells to look light up in", path, "Bake a volume with a grid");
    }
    const Box cells = bounds_of_cells(volume);
    if (glm::any(glm::greaterThan(cells.min, scene.bounds.max)) ||
        glm::any(glm::lessThan(cells.max, scene.bounds.min))) {
        throw Error(fmt::format("lies wholly outside of {}: it was baked for another level", scene.name), path,
                    "Name the volume of this level, or bake it");
    }
    const auto level = volume.settings.find("level");
    if (level != volume.settings.end() && level->second != scene.name) {
        warn("fly-through", fmt::format("{}: was baked for {}, and this is {}", path, level->second, scene.name));
    }
    const auto light = volume.settings.find("environment");
    const std::string given = environment.empty() ? "none" : environment;
    if (light != volume.settings.end() && light->second != given && !has_sky_layers(volume)) {
        warn("fly-through",
             fmt::format(
                 "{}: its environment was \"{}\", and what is traced here has \"{}\": give the options of its bake",
                 path, light->second, given));
    }
}

Volume bake_quickly(const PathTracer& paths, const ChosenLight& light, bool quiet) {
    if (!quiet) fmt::print(stderr, "fly-through: no VOLUME: baking a rough one\n");
    BakeOptions options;
    options.placement.max_probes = quick_probes;
    options.target.samples = quick_samples;
    options.measure_error = false;
    options.environment = light.description;
    return run_bake(paths, plan_bake(paths, options), options).volume;
}

/// A metre large; none for the sphere, which is there anyway.
std::optional<ObjectMesh> choose_object(const std::string& name) {
    if (name == "sphere") return {};
    fs::path path = name;
    if (name == "bunny") {
        const std::optional<fs::path> bunny = find_bunny();
        if (!bunny) throw Error("is not installed", "bunny", "Install Debian's glmark2-data, or name a file");
        path = *bunny;
    }
    ObjectMesh mesh = load_object(path);
    fit(mesh, 1);
    return mesh;
}

std::string frame_name(int frame) {
    return fmt::format("frame_{:05}.png", frame);
}

fs::path prepare_folder(const std::string& name) {
    fs::path folder = name;
    std::error_code problem;
    fs::create_directories(folder, problem);
    if (problem) throw Error("cannot be made: " + problem.message(), name, "Choose another --out");
    for (int frame = 0; fs::remove(folder / frame_name(frame), problem); ++frame) {
    }
    return folder;
}

Session first_session(const Call& call) {
    Session session;
    session.settings = settings_after(call.press);
    session.split = !call.comparison.empty();
    if (session.split) session.comparison = parse_comparison(call.comparison);
    session.settings.bands = call.bands.value_or(session.settings.bands);
    return session;
}

/// Draws the session's flight frame by frame into the folder.
///
/// reference  radiance at an object's place, where a comparison asks for it
void render_frames(const Call& call, const fs::path& folder, Renderer& renderer, Session session,
                   const std::function<Sh36(glm::dvec3)>& reference) {
    const glm::ivec2 size = parse_size(call.size);
    const std::vector<Pane> panes = panes_of(session, size);
    const bool with_reference = session.split && session.comparison == Comparison::reference;
    const int frames = call.frames.value_or(frame_count(*session.flight));
    if (frames > most_frames) {
        throw Error(fmt::format("asks for {} frames; {} are the most", frames, most_frames), call.path,
                    "Give fewer with --frames");
    }
    for (int i = 0; i < frames; ++i) {
        const FlightMoment moment = evaluate(*session.flight, frame_time_s(*session.flight, i, frames));
        session.pose = moment.pose;
        Frame frame = frame_of(session);
        frame.time_s = frame_time_s(*session.flight, i, frames);
        frame.object->position = moment.object.value_or(session.object.position);
        if (!moment.object && !session.environment) frame.object.reset();
        if (with_reference && frame.object) frame.reference = reference(frame.object->position);
        renderer.draw(frame, panes, size, samples_per_pixel);
        write_png(renderer.target().read_picture(), folder / frame_name(i));
    }
}

void render_level(const Call& call, const fs::path& folder, const PathTracer& paths,
                  const std::shared_ptr<const LitVolume>& volume, std::optional<Flight> flight,
                  const ObjectMesh& object, const ShaderSources& shaders) {
    const Tracer& tracer = paths.tracer();
    const Headless surface;
    Renderer renderer(surface.gl(), shaders);
    renderer.set_level(tracer.scene(), volume->spacing, find_outlines(tracer, volume->volume));
    renderer.set_volume(volume);
    renderer.set_environment(paths.environment());
    renderer.set_object(object);
    renderer.set_object_transfer(self_shadowed_transfer(object, shown_transfer(object)));

    DefaultFlight default_flight = make_default_flight(tracer, *volume);
    Session session = first_session(call);
    session.bands = std::clamp(volume->volume.bands, 1, most_bands);
    session.flight = flight ? std::move(flight) : std::move(default_flight.flight);
    session.lens = lens_for(glm::length(tracer.scene().bounds.size()), default_flight.object_size);
    session.object.size = static_cast<float>(default_flight.object_size);
    const std::vector<Side> sides = sides_of(session);
    const bool wants_map = std::any_of(sides.begin(), sides.end(), [](const Side& side) {
        return side.settings.level_colors == LevelColors::difference;
    });
    if (wants_map) {
        ReferenceMap map;
        map.places = choose_map_places(tracer, volume->volume, map_places);
        trace_map(paths, std::move(map), [&](const ReferenceMap& known) {
            if (known.last) renderer.set_reference(std::make_shared<const ReferenceMap>(known));
        });
    }
    render_frames(call, folder, renderer, std::move(session), [&](glm::dvec3 position) {
        GatherOptions options;
        options.bands = LevelStage::reference_bands;
        options.samples = reference_samples;
        return means(gather(paths, {glm::vec3(position - tracer.scene().origin)}, options).coefficients);
    });
}

void render_environment(const Call& call, const fs::path& folder, const Environment& environment,
                        std::optional<Flight> flight, const ObjectMesh& object, const ShaderSources& shaders) {
    const Headless surface;
    Renderer renderer(surface.gl(), shaders);
    Session session = first_session(call);
    session.bands = most_bands;
    session.environment = EnvironmentChoice{};
    session.environment->samples = call.samples.value_or(session.environment->samples);
    session.flight = flight ? std::move(flight) : orbit();
    session.lens = orbit_lens();
    renderer.set_environment(environment);
    renderer.set_volume(
        volume_of(sample_environment(environment, session.environment->samples, session.environment->sampling)));
    renderer.set_object(object);
    renderer.set_object_transfer(self_shadowed_transfer(object, shown_transfer(object)));
    const Sh36 reference = reference_environment(environment);
    render_frames(call, folder, renderer, std::move(session), [&](glm::dvec3) { return reference; });
}

EnvironmentShow environment_show(const Call& call, ChosenLight light) {
    EnvironmentShow show;
    show.environment = std::move(light.environment);
    show.file = call.light.environment;
    show.name = show.file.empty() ? light.description : show.file.filename().string();
    show.options.layout = parse_environment_layout(call.light.layout);
    show.options.rotation_deg = static_cast<float>(call.light.rotation_deg);
    show.options.scale = static_cast<float>(call.light.intensity);
    show.choice.samples = call.samples.value_or(show.choice.samples);
    return show;
}

int run(const Call& call) {
    check(call);
    ShaderSources shaders = call.shaders.empty() ? built_in_shaders() : read_shaders(call.shaders);
    std::optional<Flight> flight;
    if (!call.path.empty()) flight = load_flight(call.path);
    std::optional<ObjectMesh> object = choose_object(call.object);
    ChosenLight light = choose_light(call.light);
    const auto show = [&](auto what) {
        show_in_window({.what = std::move(what),
                        .flight = std::move(flight),
                        .object = std::move(object),
                        .session = first_session(call),
                        .shaders = std::move(shaders),
                        .size = parse_size(call.size),
                        .quiet = call.quiet});
        return 0;
    };
    const auto mesh = [&] { return object ? *object : make_sphere(); };
    if (call.level.empty()) {
        if (!call.headless) return show(environment_show(call, std::move(light)));
        render_environment(call, prepare_folder(call.out), light.environment, std::move(flight), mesh(), shaders);
        return 0;
    }

    Scene scene;
    LevelOptions level_options = call.level_options;
    std::optional<VolumeWatch> watch;
    std::optional<Volume> volume;
    if (!call.volume.empty()) {
        watch.emplace(call.volume, scene);
        volume = load_volume(call.volume);
        level_options = with_recorded(std::move(level_options), *volume);
    }
    scene = load_level(call.level, load_options(level_options));
    if (volume) check_volume_of(scene, light.description, *volume, call.volume);
    const Tracer tracer(scene);
    const PathTracer paths(tracer, light.environment);
    std::shared_ptr<const LitVolume> lit;
    if (!call.headless) {
        if (volume) lit = std::make_shared<const LitVolume>(std::move(*volume));
        return show(LevelShow{paths, light.description, std::move(lit), std::move(watch)});
    }
    const fs::path folder = prepare_folder(call.out);
    if (!volume) volume = bake_quickly(paths, light, call.quiet);
    lit = std::make_shared<const LitVolume>(std::move(*volume));
    render_level(call, folder, paths, lit, std::move(flight), mesh(), shaders);
    return 0;
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    using namespace lightgrid;
    return run_program("fly-through", [&] {
        Call call;
        CLI::App app{"Flies through a level and the light of its volume.", "fly-through"};
        add_options(app, call);
        return parse_command_line(app, argc, argv) ? run(call) : 0;
    });
}
