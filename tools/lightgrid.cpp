#include "core/error.h"
#include "tools/program.h"
#include "tools/verbs.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <memory>

namespace lightgrid {
namespace {

CLI::Validator finite(float least = std::numeric_limits<float>::lowest()) {
    const auto check = [least](const std::string& text) {
        float value = 0;
        const bool fine = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value >= least;
        return fine ? std::string() : fmt::format("{} is not a finite number{}", text, least == 0 ? " from 0 on" : "");
    };
    return {check, "", "finite"};
}

constexpr const char* volume_help = "Probe volume (*.probes.exr)";

// Each adds a verb: its options, and what it does with them.

void add_info(CLI::App& program) {
    struct Options {
        std::string volume;
        bool json = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* verb = program.add_subcommand("info", "What a volume holds: grids, probes, errors, settings");
    verb->add_option("VOLUME", options->volume, volume_help)->type_name("")->required();
    verb->add_flag("--json", options->json, "As JSON");
    verb->callback([options] { run_info(options->volume, options->json); });
}

void add_probes(CLI::App& program) {
    const auto volume = std::make_shared<std::string>();
    CLI::App* verb = program.add_subcommand("probes", "All stored probes as CSV");
    verb->add_option("VOLUME", *volume, volume_help)->type_name("")->required();
    verb->callback([volume] { run_probes(*volume); });
}

void add_query(CLI::App& program) {
    const auto options = std::make_shared<QueryOptions>();
    const auto sky = std::make_shared<std::vector<float>>();
    CLI::App* verb = program.add_subcommand("query", "Light at points, interpolated, as CSV");
    verb->add_option("VOLUME", options->volume, volume_help)->type_name("")->required();
    verb->add_option("--points", options->points,
                     "CSV with columns x, y, z and perhaps nx, ny, nz (else the six axes); - is standard input")
        ->type_name("FILE")
        ->required();
    CLI::Option* sh = verb->add_flag("--sh", options->sh, "Coefficients of radiance instead of irradiance");
    verb->add_option("--normal-bias", options->normal_bias, "Metres that points are moved along their normals")
        ->type_name("M")
        ->check(finite())
        ->excludes(sh);
    verb->add_option("--outside", options->outside, "Where no light is known: clamp (the nearest) or fade (to the sky)")
        ->type_name("HOW")
        ->check(CLI::IsMember({"clamp", "fade"}))
        ->capture_default_str();
    verb->add_option("--fade-distance", options->fade_distance,
                     "Metres from the nearest light over which fade goes to the sky")
        ->type_name("M")
        ->check(finite(0))
        ->capture_default_str();
    verb->add_option("--sky", *sky, "Radiance R,G,B of the sky that fade goes to (default black)")
        ->type_name("R,G,B")
        ->delimiter(',')
        ->check(finite())
        ->expected(3);
    verb->add_option("--layers", options->layers,
                     "Mixes layers: weights or colours by name, lamps=2,signs=1,0.5,0; others are off. sky=R,G,B or "
                     "sky=FILE: the sky of a transfer (default: the combined light)")
        ->type_name("NAME=W,...");
    verb->add_flag("--dering", options->dering, "Window the light at each point so that irradiance is never negative");
    verb->callback([options, sky] {
        if (!sky->empty()) options->sky = {(*sky)[0], (*sky)[1], (*sky)[2]};
        run_query(*options);
    });
}

void add_reference(CLI::App& program) {
    const auto options = std::make_shared<ReferenceOptions>();
    CLI::App* verb = program.add_subcommand("reference", "The path tracer's answer at points, as CSV");
    verb->add_option("LEVEL", options->level, "The level, .gltf or .glb")->required();
    verb->add_option("--points", options->points,
                     "CSV with columns x, y, z and perhaps nx, ny, nz (else the six axes); - is standard input")
        ->required();
    verb->add_flag("--sh", options->sh, "Coefficients of radiance instead of irradiance");
    add_light_options(*verb, options->light);
    add_level_options(*verb, options->level_options);
    verb->add_option("--samples", options->samples, "Gather rays per point, all replicates together")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    verb->add_option("--bands", options->bands, "SH bands, with --sh")->capture_default_str();
    verb->add_option("--seed", options->seed, "Other seeds give other noise")->capture_default_str();
    verb->add_option("--threads", options->threads, "0: all of the machine; the result is the same")
        ->check(CLI::NonNegativeNumber);
    verb->callback([options] { run_reference(*options); });
}

void add_draw(CLI::App& program) {
    const auto options = std::make_shared<DrawOptions>();
    const auto at = std::make_shared<std::vector<double>>();
    CLI::App* verb = program.add_subcommand("draw", "Pictures of a volume in its level: false colours, probes, a view");
    verb->add_option("LEVEL", options->level, "The level that was baked, .gltf or .glb")->required();
    verb->add_option("VOLUME", options->volume, "Its volume (*.probes.exr)")->required();
    verb->add_option("-o,--output", options->folder, "Folder for the pictures (default: this one)")->type_name("DIR");
    verb->add_option("--at", *at, "x,y,z that slices and cuts go through (default: the volume's middle)")
        ->delimiter(',')
        ->check(finite())
        ->expected(3);
    verb->add_option("--camera", options->camera, "The view: x,y,z of the eye and of what it looks at (default: found)")
        ->delimiter(',')
        ->check(finite())
        ->expected(6);
    verb->add_option("--angle", options->angle_deg, "Horizontal angle of that view, degrees")
        ->check(CLI::Range(1, 170))
        ->capture_default_str();
    verb->add_option("--exposure", options->exposure, "Brightness of 1 cd/m^2 (default: automatic)")->check(finite(0));
    verb->add_option("--normal-bias", options->normal_bias,
                     "Metres that look-ups move off surfaces (default: 0.3 spacings)")
        ->check(finite());
    verb->add_option("--width", options->width, "Pixels across")->check(CLI::Range(320, 8192))->capture_default_str();
    verb->add_option("--report", options->report, "Report of level-bake (--report-json): draws error against time");
    add_light_options(*verb, options->light);
    add_level_options(*verb, options->level_options);
    verb->callback([options, at] {
        if (!at->empty()) options->at = glm::dvec3((*at)[0], (*at)[1], (*at)[2]);
        run_draw(*options);
    });
}

void add_diff(CLI::App& program) {
    struct Options {
        std::string a;
        std::string b;
        bool json = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* verb = program.add_subcommand("diff", "Error of volume B against A");
    verb->add_option("A", options->a, "Reference: a volume, or CSV that lightgrid query, reference or probes printed")
        ->type_name("")
        ->required();
    verb->add_option("B", options->b, volume_help)->type_name("")->required();
    verb->add_flag("--json", options->json, "As JSON");
    verb->callback([options] { run_diff(options->a, options->b, options->json); });
}

int run(int argc, const char* const* argv) {
    CLI::App program("Reads probe volumes that level-bake wrote.", "lightgrid");
    program.set_version_flag("--version", "lightgrid " LIGHTGRID_VERSION);
    program.require_subcommand(1);
    program.get_formatter()->label("SUBCOMMAND", "VERB");
    add_info(program);
    add_probes(program);
    add_query(program);
    add_reference(program);
    add_draw(program);
    add_diff(program);
    parse_command_line(program, argc, argv);
    return 0;
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    return lightgrid::run_program("lightgrid", [&] { return lightgrid::run(argc, argv); });
}
