// level-bake: a glTF level in, a volume of SH probes out.

#include "core/error.h"
#include "core/gltf.h"
#include "core/near_names.h"
#include "core/parallel.h"
#include "core/sh.h"
#include "core/stopwatch.h"
#include "core/tracer.h"
#include "core/whole_file.h"
#include "probes/bake.h"
#include "probes/kept_transport.h"
#include "probes/layers.h"
#include "probes/shut_out.h"
#include "probes/unit_hint.h"
#include "probes/volume_file.h"
#include "tools/bake_report.h"
#include "tools/csv.h"
#include "tools/level_options.h"
#include "tools/light_options.h"
#include "tools/program.h"
#include "tools/progress.h"
#include "tools/report_page.h"
#include "tools/target_options.h"

#include <CLI/CLI.hpp>
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

struct Call {
    std::string level;
    std::string output;
    LevelOptions level_options;
    LightOptions light;
    std::optional<double> spacing;
    std::vector<std::string> volumes;
    std::string probes;
    std::optional<std::int64_t> max_probes;
    TargetOptions target;
    std::optional<int> bands;
    std::string method = "cache";
    std::uint64_t seed = 0;
    int threads = 0;
    std::string layers = "combined";
    std::string keep_transport;
    std::string report;
    std::string report_json;
    bool json = false;
    bool quiet = false;
    bool verbose = false;
    std::string command;  // as it was typed, for the report
};

constexpr double slice_pixels = 480;  // along the longest side of the volume

Box parse_box(const std::string& text) {
    const std::vector<double> n = parse_numbers(text, 6, "0,0,0,10,3,8");
    Box box;
    box.extend({n[0], n[1], n[2]});
    box.extend({n[3], n[4], n[5]});
    return box;
}

/// Throws Error for what is no length above 0.
void parse_spacing(const std::string& text) {
    constexpr double least = std::numeric_limits<float>::min();
    if (parse_numbers(text, 1, "0.5")[0] < least) {
        throw Error(fmt::format("{} is no distance between probes: it must be above 0, like 0.5", text));
    }
}

Method parse_method(const std::string& name) {
    for (const Method method : {Method::path, Method::cache}) {
        if (name == name_of(method)) return method;
    }
    throw Error(fmt::format("{} is not known: there are path and cache", name));
}

void add_options(CLI::App& app, Call& call) {
    app.add_option("level", call.level, "The level, .gltf or .glb; none: one probe of the environment")
        ->type_name("LEVEL");
    app.add_option("-o,--output", call.output, "Where the volume goes (default: LEVEL's name + .probes.exr, here)")
        ->type_name("FILE");
    add_level_options(app, call.level_options);
    add_light_options(app, call.light);

    const char* where = "Where";
    app.add_option("--spacing", call.spacing,
                   "Metres between probes at most, of which --scale makes units (default: chosen, and said why)")
        ->type_name("M")
        ->check(checked(parse_spacing))
        ->group(where);
    app.add_option("--volume", call.volumes, "A box to fill with probes, in the file's units; may be repeated")
        ->type_name("x0,y0,z0,x1,y1,z1")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->allow_extra_args(false)
        ->check(checked(parse_box))
        ->group(where);
    app.add_option("--probes", call.probes,
                   "Gather at these points instead, just where they are: CSV with x,y,z; - is standard input")
        ->type_name("FILE")
        ->group(where);
    app.add_option("--max-probes", call.max_probes,
                   fmt::format("Never more probes than this (default: {} in grids)", PlacementOptions{}.max_probes))
        ->type_name("N")
        ->check(number(1, 1e15, true))
        ->group(where);

    add_target_options(app, call.target);

    const char* how = "How";
    app.add_option("--bands", call.bands,
                   "SH bands: 3 are nine coefficients (default: 3; with --max-error 5 where 3 cannot meet it)")
        ->type_name("N")
        ->check(number(1, max_sh_bands, true))
        ->group(how);
    app.add_option("--method", call.method,
                   "path: the unbiased path tracer; cache: light of surfaces solved once for all probes, fast")
        ->type_name("NAME")
        ->check(checked(parse_method))
        ->capture_default_str()
        ->group(how);
    app.add_option("--seed", call.seed, "Other seeds give other noise")
        ->type_name("N")
        ->capture_default_str()
        ->group(how);
    app.add_option("--threads", call.threads, "0: all of the machine; the result is the same")
        ->type_name("N")
        ->check(number(0, 4096, true))
        ->group(how);
    app.add_option("--layers", call.layers,
                   "Parts of the light to be mixed at run time, besides all light in one (combined): direct,indirect; "
                   "or any of sky (any sky can be put in), groups (all groups of lights), and names of groups")
        ->type_name("NAMES")
        ->check(checked([](const std::string& names) { static_cast<void>(parse_layers(names)); }))
        ->capture_default_str()
        ->group(how);
    app.add_option(
           "--keep-transport", call.keep_transport,
           "Keeps in FILE how light travels; where it is kept already, a change of lights alone is solved without "
           "tracing it again. Of the error only the noise is known then")
        ->type_name("FILE")
        ->group(how);

    const char* out = "Output";
    app.add_option("--report", call.report,
                   "Writes a page (HTML, nothing else needed): error, time, slices and what was left out; measures the "
                   "error")
        ->type_name("FILE")
        ->group(out);
    app.add_option("--report-json", call.report_json, "Writes the same as JSON, without pictures")
        ->type_name("FILE")
        ->group(out);
    app.add_flag("--json", call.json, "The summary on standard output, as JSON")->group(out);
    app.set_version_flag("--version", "level-bake " LIGHTGRID_VERSION);
    CLI::Option* quiet = app.add_flag("--quiet", call.quiet, "Nothing but errors")->group(out);
    app.add_flag("--verbose", call.verbose, "Every decision and why, stages, parts of the error, all that was left out")
        ->excludes(quiet)
        ->group(out);
}

/// What is wrong with the call beyond single values: all of it in one message.
void check(const Call& call) {
    std::vector<std::string> wrong;
    if (!call.probes.empty() && (call.spacing || !call.volumes.empty())) {
        wrong.emplace_back("--probes is a list of its own: it excludes --spacing and --volume");
    }
    if (call.level.empty() && call.light.environment.empty() && call.light.sky.empty() && call.light.sun_sky.empty()) {
        wrong.emplace_back("no LEVEL: name a .gltf or .glb file, or an --environment");
    }
    if (const std::vector<std::string> names = names_of(call.level_options); call.level.empty() && !names.empty()) {
        wrong.push_back(fmt::format("no LEVEL that {} could be for", fmt::join(names, ", ")));
    }
    if (!call.keep_transport.empty() && !call.target.time_budget.empty()) {
        wrong.emplace_back("--keep-transport excludes --time-budget: it keeps what was traced, whatever that takes");
    }
    if (!call.keep_transport.empty() && call.target.strict) {
        wrong.emplace_back("--keep-transport excludes --strict: with kept transport no error is measured");
    }
    if (!call.keep_transport.empty() && parse_method(call.method) != Method::cache) {
        wrong.emplace_back("--keep-transport needs --method cache: paths have nothing to keep");
    }
    if (parse_layers(call.layers).any()) {
        if (parse_method(call.method) != Method::cache) {
            wrong.emplace_back("--layers needs --method cache: paths do not tell the layers apart");
        }
        if (!call.target.time_budget.empty()) {
            wrong.emplace_back("--layers excludes --time-budget: layers are traced whole, whatever that takes");
        }
        if (!call.keep_transport.empty()) {
            wrong.emplace_back("--layers excludes --keep-transport: kept transport tells other sources apart");
        }
    }
    try {
        static_cast<void>(parse_target(call.target));
    } catch (const Error& error) {
        wrong.emplace_back(error.what());
    }
    if (!wrong.empty()) throw Error(fmt::format("{}", fmt::join(wrong, "; ")), "", "See level-bake --help");
}

std::vector<glm::dvec3> read_probes(const Call& call) {
    std::vector<glm::dvec3> positions = read_points(call.probes).positions;
    if (positions.empty()) throw Error("has no points", call.probes, "Give a row for each probe.");
    if (call.max_probes && positions.size() > static_cast<std::size_t>(*call.max_probes)) {
        throw Error(fmt::format("{} points, more than --max-probes {}", positions.size(), *call.max_probes),
                    call.probes);
    }
    return positions;
}

fs::path output_path(const Call& call) {
    if (!call.output.empty()) return call.output;
    fs::path source = !call.level.empty() ? call.level : call.light.environment;
    if (source.empty()) source = call.light.sky.empty() ? "sun-sky" : "sky";
    return source.filename().replace_extension(".probes.exr");
}

/// Fails before the bake, not after it, where a result could not be written or would replace what it is made from.
void check_output(const fs::path& file, const Call& call) {
    for (const std::string& input : {call.level, call.light.environment, call.probes}) {
        std::error_code not_there;
        if (!input.empty() && fs::equivalent(file, input, not_there)) {
            throw Error("would replace what is to be baked", file.string(), "Name another file.");
        }
    }
    check_writable(file);
}

/// A name that promises another kind of file would be opened by what cannot read it.
void check_volume_name(const fs::path& file) {
    const std::string ending = lower_case(file.extension().string());
    if (ending.empty() || ending == ".exr") return;
    throw Error(fmt::format("a volume is an OpenEXR file, not a {} file", ending), file.string(),
                fmt::format("Name it {}.", fs::path(file).replace_extension(".probes.exr").string()));
}

/// The same for all outputs, which also must not replace each other.
void check_outputs(const fs::path& volume, const Call& call) {
    std::vector<fs::path> files{volume};
    for (const std::string& report : {call.report, call.report_json, call.keep_transport}) {
        if (!report.empty()) files.emplace_back(report);
    }
    for (auto file = files.begin(); file != files.end(); ++file) {
        check_output(*file, call);
        const auto same = [&](const fs::path& other) {
            return fs::absolute(other).lexically_normal() == fs::absolute(*file).lexically_normal();
        };
        if (std::any_of(files.begin(), file, same)) {
            throw Error("is named for two outputs", file->string(), "Name another file.");
        }
    }
}

/// A word as a shell takes it.
std::string quoted(const std::string& word) {
    const char* plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_@%+=:,./-";
    if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
    std::string safe = "'";
    for (const char c : word) safe += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return safe + "'";
}

/// A pattern of --ignore that fits this name and no other.
std::string exact_pattern(const std::string& name) {
    std::string pattern;
    for (const char c : name)
        pattern += std::strchr("*?[\\", c) != nullptr ? fmt::format("\\{}", c) : std::string(1, c);
    return pattern;
}

std::string name_of_mesh(const Scene& scene, const ShutOut& shut_out) {
    return shut_out.node < 0 ? "" : scene.node_names[static_cast<std::size_t>(shut_out.node)];
}

/// What tells the user of a light that brings nothing, and how to let it in.
std::string shut_out_text(const ShutOut& shut_out, const Scene& scene, std::size_t probes) {
    const std::string nowhere = fmt::format("no light of {} was found at any", shut_out.light);
    if (shut_out.node < 0) return fmt::format("{} of {} probes", nowhere, probes);
    const std::string name = name_of_mesh(scene, shut_out);
    const std::string mesh =
        name.empty() ? fmt::format("the mesh of node {}", shut_out.node) : fmt::format("mesh \"{}\"", name);
    const std::string what = shut_out.from_all_points
                                 ? fmt::format("{} of {} probes: {} is all around and stops it", nowhere, probes, mesh)
                                 : fmt::format("{} probe within {}, which is all around and stops it", nowhere, mesh);
    if (name.empty()) return what + ". Where it should not, give the node a name, and --ignore leaves it out";
    return fmt::format("{}. Where it should not, --ignore {} leaves it out", what, quoted(exact_pattern(name)));
}

nlohmann::json shut_out_json(const std::vector<ShutOut>& shut_out, const Scene& scene) {
    nlohmann::json list = nlohmann::json::array();
    for (const ShutOut& out : shut_out) {
        list.push_back({{"light", out.light},
                        {"mesh", name_of_mesh(scene, out)},
                        {"node", out.node < 0 ? nlohmann::json() : nlohmann::json(out.node)},
                        {"from_all_points", out.from_all_points}});
    }
    return list;
}

std::string command_line(int argc, char** argv) {
    std::string command = "level-bake";
    for (int i = 1; i < argc; ++i) command += " " + quoted(argv[i]);
    return command;
}

/// Slices through the worst point; nothing where there are no cells to look light up in.
std::optional<SlicePictures> draw_report_slices(const nlohmann::json& report, const Volume& volume,
                                                const Tracer& tracer, const Environment& environment) {
    if (!volume.has_cells()) return {};
    const Sampler sampler(volume);
    const LitLevel level{&tracer, &sampler, &environment, {}};
    const glm::dvec3 size = bounds_of(volume).size();
    const double longest = std::max({size.x, size.y, size.z});
    if (!(longest > 0)) return {};
    return picture_slices(level, volume, slice_point(report, volume), slice_pixels / longest);
}

bool has_light(const PathTracer& paths) {
    return paths.estimators().emitters || paths.estimators().sky || paths.estimators().lights;
}

/// What FILE keeps, if it is there and fits; says where it does not.
std::optional<KeptTransport> find_transport(const Call& call, std::uint64_t fingerprint, const Environment& environment,
                                            const Messages& messages) {
    const fs::path file = call.keep_transport;
    if (!fs::exists(file)) return {};
    std::optional<KeptTransport> kept = load_transport(file, fingerprint);
    if (kept && has_places_for(*kept, environment)) return kept;
    messages.notice(fmt::format("{}: is of {}: it is made anew", file.string(),
                                kept ? "a level without a sky, where fewer probes are free"
                                     : "another level, other options or another version"));
    return {};
}

std::string unit_hint_text(const UnitHint& hint) {
    return fmt::format(
        "the unit of this level may not be the metre: {}. If it is the {}: --scale {:g}; if the metre: --scale 1",
        hint.evidence, hint.unit, hint.metres_per_unit);
}

/// A bake of a level full of oddities still fits on a screen.
///
/// print  messages.notice or messages.warning
void print_some(const Messages& messages, const std::vector<std::string>& texts,
                void (Messages::*print)(const std::string&) const) {
    constexpr std::size_t most = 6;
    const std::size_t told = messages.verbose() || texts.size() <= most ? texts.size() : most - 1;
    for (const std::string& text : std::span(texts).first(told)) (messages.*print)(text);
    if (told < texts.size())
        (messages.*print)(fmt::format("and {} more like these: --verbose lists them", texts.size() - told));
}

Scene empty_scene() {
    Scene scene;
    scene.name = "none";
    scene.materials.emplace_back();
    return scene;
}

int bake(const Call& call) {
    const Stopwatch clock;
    check(call);
    const fs::path output = output_path(call);
    check_outputs(output, call);
    check_volume_name(output);
    const ThreadLimit threads(call.threads);
    Messages messages(call.quiet, call.verbose);

    BakeOptions options;
    options.placement.spacing = call.spacing;
    for (const std::string& text : call.volumes) options.placement.boxes.push_back(parse_box(text));
    if (call.max_probes) options.placement.max_probes = *call.max_probes;
    if (!call.probes.empty()) options.probes = read_probes(call);
    options.bands = call.bands;
    options.target = parse_target(call.target);
    if (options.target.seconds) options.clock = clock;
    options.method = parse_method(call.method);
    options.seed = call.seed;
    options.keep_transport = !call.keep_transport.empty();
    const bool wants_report = !call.report.empty() || !call.report_json.empty();
    options.measure_error = !call.target.samples || wants_report;
    options.compare_look_ups = wants_report;

    Stopwatch watch;
    const ChosenLight light = choose_light(call.light);
    options.environment = light.description;
    const Scene scene = call.level.empty() ? empty_scene() : load_level(call.level, load_options(call.level_options));
    std::vector<Stage> stages{{"load", watch.lap(), 0}};
    const LayerChoice choice = parse_layers(call.layers);
    const LayersPlan layers = plan_layers(choice, scene, light.environment);
    options.layers = layers.layers;
    const Tracer tracer(scene);
    const PathTracer paths(tracer, light.environment,
                           options.keep_transport ? separate_sources(scene, light.environment) : layers.sources);
    // Where a sky is to be put in later, probes are placed and samples counted as if there were one.
    const Environment sky_to_come = Environment::uniform(glm::vec3(1));
    std::optional<PathTracer> under_sky;
    if (choice.sky && light.environment.is_black()) under_sky.emplace(tracer, sky_to_come);
    stages.push_back({"build", watch.lap(), 0});
    const std::optional<UnitHint> hint = call.level_options.scale ? std::nullopt : find_unit_hint(tracer);
    stages.push_back({"hints", watch.lap(), 0});
    print_some(messages, light.notices, &Messages::notice);
    print_some(messages, scene.notices, &Messages::notice);
    if (hint) messages.notice(unit_hint_text(*hint));
    if (!has_light(paths) && choice.sky) {
        messages.notice("there is no light but that of skies to come: the combined light will be black");
    } else if (!has_light(paths)) {
        messages.warning(
            "the level has no light of its own and none was given: all probes will be black. "
            "Add --sky 1,1,1 or --environment FILE");
    }

    ProgressLine line(messages);
    const auto progress = [&](const Doing& doing) { line.update(doing.stage, doing.share, doing.rays, doing.error); };
    const std::uint64_t fingerprint =
        options.keep_transport ? transport_fingerprint(scene, options, LIGHTGRID_VERSION) : 0;
    watch.lap();
    const std::optional<KeptTransport> kept =
        options.keep_transport ? find_transport(call, fingerprint, light.environment, messages) : std::nullopt;
    if (options.keep_transport) stages.push_back({"kept", watch.lap(), 0});
    BakePlan plan = kept ? plan_of(*kept, scene) : plan_bake(under_sky ? *under_sky : paths, options, progress);
    line.finish();
    plan.stages.insert(plan.stages.begin(), stages.begin(), stages.end());
    print_plan(messages, scene, tracer, plan, options);
    if (kept) {
        messages.line(
            fmt::format("transport  kept in {}: {} patches, {} sources of light; only light that is new or has "
                        "moved is traced",
                        call.keep_transport, kept->made.patches, kept->light.sources.count));
    }
    watch.lap();
    plan.shut_out = find_shut_out(paths, plan.points);
    plan.stages.push_back({"lights", watch.lap(), 0});
    std::vector<std::string> warnings;
    for (const ShutOut& out : plan.shut_out) warnings.push_back(shut_out_text(out, scene, plan.points.size()));
    print_some(messages, warnings, &Messages::warning);
    if (plan.placement.valid + plan.placement.moved == 0) {
        messages.warning("no probe is valid: all are inside solids. Check the level's winding, or give a --volume");
    }

    BakeResult result =
        kept ? bake_from(*kept, paths, plan, options, progress) : run_bake(paths, plan, options, progress);
    line.finish();
    watch.lap();
    if (result.kept) {
        result.kept->fingerprint = fingerprint;
        save_transport(*result.kept, call.keep_transport);
        result.stages.push_back({"keep", watch.lap(), 0});
    }
    record(call.level_options, result.volume);
    save_volume(result.volume, output);
    result.stages.push_back({"save", watch.lap(), 0});

    const std::string date = fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr)));
    nlohmann::json report = bake_report(tracer, plan, result, options, {call.command, date, output, this_machine()});
    report["shut_out"] = shut_out_json(plan.shut_out, scene);
    if (!call.report_json.empty()) write_whole_file(call.report_json, report.dump(2) + "\n");
    if (!call.report.empty()) {
        const auto slices = draw_report_slices(report, result.volume, tracer, light.environment);
        write_whole_file(call.report, report_page(report, slices));
    }
    print_result(messages, scene, plan, result, output);
    if (result.kept) {
        messages.line("kept       " + call.keep_transport);
    } else if (options.keep_transport && !kept) {
        messages.notice(fmt::format("{}: is not written: light was gathered by paths, which leave nothing to keep",
                                    call.keep_transport));
    }
    if (call.json) print(report.dump(2) + "\n");
    const bool is_missed = !result.verdict.is_judged || !result.verdict.target_met.value_or(true);
    return call.target.strict && is_missed ? 1 : 0;
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    using namespace lightgrid;
    return run_program("level-bake", [&] {
        Call call;
        CLI::App app{"Bakes the light of a level into a volume of SH probes.", "level-bake"};
        add_options(app, call);
        call.command = command_line(argc, argv);
        return parse_command_line(app, argc, argv) ? bake(call) : 0;
    });
}
