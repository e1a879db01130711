// What the volume's light costs a picture: the same frames with constant ambient, lit per object, per vertex and per
// pixel, in turns; and a thousand objects that move. Processor time of all threads: llvmpipe draws with several.
//
//     bench_viewer_light LEVEL [ROUNDS]

#include "core/error.h"
#include "core/gltf.h"
#include "core/tracer.h"
#include "probes/bake.h"
#include "tests/bench/measure.h"
#include "tools/program.h"
#include "viewer/crowd.h"
#include "viewer/default_flight.h"
#include "viewer/headless.h"
#include "viewer/outlines.h"
#include "viewer/renderer.h"
#include "viewer/transfer.h"

#include <fmt/format.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace lightgrid {
namespace {

constexpr glm::ivec2 size(1280, 720);
constexpr int frames = 6;

struct Way {
    std::string name;
    Settings settings;
};

std::vector<Way> all_ways() {
    Settings constant;
    constant.level_light = LevelLight::constant;
    constant.object_light = ObjectLight::constant;
    constant.contact_shadow = false;
    constant.self_shadowing = false;
    std::vector<Way> ways{{"constant ambient", constant}, {"constant ambient again", constant}};
    const auto add = [&](const char* name, auto change) {
        ways.push_back({name, constant});
        change(ways.back().settings);
    };
    add("object by one look-up", [](Settings& s) { s.object_light = ObjectLight::object; });
    add("object by one look-up, level per vertex", [](Settings& s) {
        s.object_light = ObjectLight::object;
        s.level_light = LevelLight::vertex;
    });
    add("with contact shadow", [](Settings& s) {
        s = Settings();
        s.self_shadowing = false;
    });
    add("with contact shadow and self-shadowing", [](Settings& s) { s = Settings(); });
    add("object per pixel", [](Settings& s) { s.object_light = ObjectLight::pixel; });
    add("level and object per pixel", [](Settings& s) {
        s.object_light = ObjectLight::pixel;
        s.level_light = LevelLight::pixel;
    });
    add("a thousand objects, level per vertex", [](Settings& s) {
        s.object_light = ObjectLight::object;
        s.level_light = LevelLight::vertex;
        s.show_crowd = true;
    });
    return ways;
}

void run(const std::string& level, int rounds) {
    const Scene scene = load_level(level);
    const Tracer tracer(scene);
    const Environment sky = Environment::uniform(glm::vec3(1));
    const PathTracer paths(tracer, sky);
    BakeOptions options;
    options.placement.max_probes = 4096;
    options.target.samples = 64;
    options.measure_error = false;
    const auto volume = std::make_shared<const LitVolume>(run_bake(paths, plan_bake(paths, options), options).volume);
    const Headless surface;
    const Gl& gl = surface.gl();
    Renderer renderer(gl, built_in_shaders());
    renderer.set_level(scene, volume->spacing, find_outlines(tracer, volume->volume));
    renderer.set_volume(volume);
    renderer.set_environment(sky);
    const ObjectMesh sphere = make_sphere();
    renderer.set_object(sphere);
    renderer.set_object_transfer(self_shadowed_transfer(sphere));
    const DefaultFlight flight = make_default_flight(tracer, *volume);
    const Lens lens = lens_for(glm::length(scene.bounds.size()), flight.object_size);

    const auto draw = [&](const Settings& settings) {
        for (int i = 0; i < frames; ++i) {
            const double time_s = frame_time_s(flight.flight, i, frames);
            const FlightMoment moment = evaluate(flight.flight, time_s);
            const ObjectPlace object{.position = moment.object.value_or(moment.pose.eye),
                                     .size = static_cast<float>(flight.object_size)};
            const Pane pane{{glm::ivec2(0), size}, settings};
            renderer.draw({moment.pose, lens, object, time_s}, std::span(&pane, 1), size, 1);
            std::uint32_t pixel = 0;
            gl.ReadPixels(0, 0, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, &pixel);  // waits until all is drawn
        }
    };
    const std::vector<Way> ways = all_ways();
    for (const Way& way : ways) draw(way.settings);  // compiles, uploads, and computes what stays

    std::vector<std::vector<double>> ratios(ways.size());
    std::vector<double> plain_ms;
    std::vector<double> shares;
    for (int round = 0; round < rounds; ++round) {
        std::vector<double> seconds;
        seconds.reserve(ways.size());
        for (const Way& way : ways) seconds.push_back(seconds_of([&] { draw(way.settings); }).processor);
        plain_ms.push_back(1000 * seconds[0] / frames);
        for (std::size_t w = 0; w < ways.size(); ++w) ratios[w].push_back(seconds[w] / seconds[0]);

        const LookUp light = look_up(*volume, ways.back().settings);
        std::vector<Ball> crowd = crowd_at(*volume, round, scene.origin);
        constexpr int times = 20;
        const double lighting = seconds_of([&] {
                                    for (int i = 0; i < times; ++i) light_crowd(light, scene.origin, crowd);
                                }).processor /
                                times;
        shares.push_back(lighting / (seconds.back() / frames));
    }
    fmt::print("{}: {} probes, {} x {}, {} frames of {} rounds\n", scene.name, volume->volume.slots(), size.x, size.y,
               frames, rounds);
    const Spread ms = spread(plain_ms);
    fmt::print("{:45} {:.1f} ms of processor a frame ({:.1f} to {:.1f})\n", ways[0].name, ms.median, ms.least, ms.most);
    for (std::size_t w = 1; w < ways.size(); ++w) {
        const Spread ratio = spread(ratios[w]);
        fmt::print("{:45} {:.3f} ({:.3f} to {:.3f}) of that\n", ways[w].name, ratio.median, ratio.least, ratio.most);
    }
    const Spread share = spread(shares);
    fmt::print("{:45} {:.2f} % ({:.2f} to {:.2f}) of the last\n", "looking light up for the thousand",
               100 * share.median, 100 * share.least, 100 * share.most);
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    using namespace lightgrid;
    return run_program("bench_viewer_light", [&] {
        if (argc < 2) throw Error("no LEVEL", {}, "bench_viewer_light LEVEL [ROUNDS]");
        run(argv[1], argc > 2 ? std::atoi(argv[2]) : 7);
        return 0;
    });
}
