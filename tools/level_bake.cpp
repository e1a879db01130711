// level-bake: a glTF level in, a volume of SH probes out.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/gltf.h"
#include "core/parallel.h"
#include "core/sh.h"
#include "core/tracer.h"
#include "core/whole_file.h"
#include "probes/bake.h"
#include "probes/volume_file.h"
#include "tools/bake_report.h"
#include "tools/csv.h"
#include "tools/light_options.h"
#include "tools/program.h"
#include "tools/progress.h"

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

struct Call {
    std::string level;
    std::string output;
    int scene = -1;
    LightOptions light;
    std::optional<double> spacing;
    std::vector<std::string> volumes;
    std::string probes;
    std::int64_t max_probes = PlacementOptions{}.max_probes;
    std::optional<std::uint32_t> samples;
    int bands = 3;
    std::string method = "path";
    std::uint64_t seed = 0;
    int threads = 0;
    std::string layers = "combined";
    std::string report_json;
    bool json = false;
    bool quiet = false;
    std::string max_error, time_budget, report;  // not in this version: refused by name
};

void add_options(CLI::App& app, Call& call) {
    app.add_option("level", call.level, "The level, .gltf or .glb; none: one probe of the --environment")->type_name("LEVEL");
    app.add_option("-o,--output", call.output, "Where the volume goes (default: LEVEL's name + .probes.exr, here)")
        ->type_name("FILE");
    app.add_option("--scene", call.scene, "Which of the file's scenes (default: the file's own choice)")->type_name("N");
    add_light_options(app, call.light);

    const char* where = "Where";
    app.add_option("--spacing", call.spacing, "Metres between probes at most (default: chosen, and said why)")
        ->type_name("M")
        ->group(where);
    app.add_option("--volume", call.volumes, "A box to fill with probes; may be repeated")
        ->type_name("x0,y0,z0,x1,y1,z1")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->allow_extra_args(false)
        ->group(where);
    app.add_option("--probes", call.probes, "Gather at these points instead, just where they are: CSV with x,y,z; - is standard input")
        ->type_name("FILE")
        ->group(where);
    app.add_option("--max-probes", call.max_probes, "Never more probes than this")->type_name("N")->capture_default_str()->group(where);

    const char* how = "How much and how";
    app.add_option("--samples", call.samples, "Gather rays per probe, all replicates together (default: 64 to 4096, by a budget of rays)")
        ->type_name("N")
        ->group(how);
    app.add_option("--bands", call.bands, "SH bands: 3 are nine coefficients")->type_name("N")->capture_default_str()->group(how);
    app.add_option("--method", call.method, "path: the unbiased path tracer")->type_name("NAME")->capture_default_str()->group(how);
    app.add_option("--seed", call.seed, "Other seeds give other noise")->type_name("N")->capture_default_str()->group(how);
    app.add_option("--threads", call.threads, "0: all of the machine; the result is the same")->type_name("N")->group(how);
    app.add_option("--max-error", call.max_error, "Not in this version")->type_name("P%")->group(how);
    app.add_option("--time-budget", call.time_budget, "Not in this version")->type_name("T")->group(how);
    app.add_option("--layers", call.layers, "combined: all light in one")->type_name("NAMES")->capture_default_str()->group(how);

    const char* out = "Output";
    app.add_option("--report-json", call.report_json, "Writes error, curve, what was left out and stages; measures the error")
        ->type_name("FILE")
        ->group(out);
    app.add_option("--report", call.report, "Not in this version")->type_name("FILE")->group(out);
    app.add_flag("--json", call.json, "The summary on standard output, as JSON")->group(out);
    app.set_version_flag("--version", "level-bake " LIGHTGRID_VERSION);
    app.add_flag("--quiet", call.quiet, "Nothing but errors")->group(out);
}

/// Every option that makes no sense, in one message.
void check(const Call& call) {
    std::vector<std::string> wrong;
    if (!call.max_error.empty()) wrong.push_back("--max-error is not in this version: use --samples and read the reported error");
    if (!call.time_budget.empty()) wrong.push_back("--time-budget is not in this version: use --samples");
    if (!call.report.empty()) wrong.push_back("--report is not in this version: use --report-json");
    if (call.method == "cache") wrong.push_back("--method cache is not in this version: use --method path");
    else if (call.method != "path") wrong.push_back(fmt::format("--method {}: there is only path", call.method));
    if (call.layers != "combined") wrong.push_back("--layers other than combined are not in this version");
    if (call.spacing && !(*call.spacing > 0 && std::isfinite(*call.spacing))) {
        wrong.push_back(fmt::format("--spacing {}: must be a positive number of metres", *call.spacing));
    }
    if (call.max_probes < 1) wrong.push_back(fmt::format("--max-probes {}: must be at least 1", call.max_probes));
    if (call.samples && *call.samples < 1) wrong.push_back("--samples 0: must be at least 1");
    if (call.bands < 1 || call.bands > max_sh_bands) {
        wrong.push_back(fmt::format("--bands {}: must be 1 to {}", call.bands, max_sh_bands));
    }
    if (call.threads < 0) wrong.push_back(fmt::format("--threads {}: must be 0 or more", call.threads));
    if (!call.probes.empty() && (call.spacing || !call.volumes.empty())) {
        wrong.push_back("--probes is a list of its own: it excludes --spacing and --volume");
    }
    if (call.level.empty() && call.light.environment.empty()) wrong.push_back("no LEVEL: name a .gltf or .glb file, or an --environment");
    if (wrong.empty()) return;
    std::string text;
    for (const std::string& line : wrong) text += (text.empty() ? "" : "\n  ") + line;
    throw Error(text, "", "See --help");
}

std::vector<Box> parse_boxes(const std::vector<std::string>& texts) {
    std::vector<Box> boxes;
    for (const std::string& text : texts) {
        const std::vector<double> n = parse_numbers(text, 6, "--volume", "0,0,0,10,3,8");
        Box box;
        box.extend({n[0], n[1], n[2]});
        box.extend({n[3], n[4], n[5]});
        boxes.push_back(box);
    }
    return boxes;
}

/// Fails before the bake, not after it, where the result could not be written.
void check_folder(const fs::path& file) {
    const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    if (!fs::is_directory(folder)) {
        throw Error("there is no folder " + folder.string(), file.string(), "Make it, or choose another place with -o");
    }
    if (fs::is_directory(file)) throw Error("is a folder", file.string(), "Name a file");
}

bool has_light(const PathTracer& paths) {
    return paths.estimators().emitters || paths.estimators().sky || paths.estimators().lights;
}

int bake(const Call& call) {
    check(call);
    const ThreadLimit threads(call.threads);
    Messages messages(call.quiet);

    BakeOptions options;
    options.placement.spacing = call.spacing;
    options.placement.boxes = parse_boxes(call.volumes);
    options.placement.max_probes = call.max_probes;
    if (!call.probes.empty()) options.probes = read_points(call.probes).positions;
    options.bands = call.bands;
    options.samples = call.samples;
    options.seed = call.seed;
    options.measure_error = !call.samples || !call.report_json.empty();

    Stopwatch watch;
    const ChosenLight light = choose_light(call.light);
    options.environment = light.description;
    Scene scene;
    if (call.level.empty()) {
        scene.name = "none";
        scene.materials.emplace_back();
        if (!options.probes) options.probes = std::vector<glm::dvec3>{glm::dvec3(0)};
    } else {
        scene = load_level(call.level, {call.scene});
    }
    std::vector<Stage> stages{{"load", watch.lap(), 0}};
    const Tracer tracer(scene);
    const PathTracer paths(tracer, light.environment);
    stages.push_back({"build", watch.lap(), 0});
    for (const std::string& notice : light.notices) messages.notice(notice);
    for (const std::string& notice : scene.notices) messages.notice(notice);
    if (!has_light(paths)) {
        messages.warning("the level has no light of its own and none was given: all probes will be black. "
                         "Add --sky 1,1,1 or --environment FILE");
    }

    BakePlan plan = plan_bake(paths, options);
    plan.stages.insert(plan.stages.begin(), stages.begin(), stages.end());
    print_plan(messages, scene, tracer, plan, options);
    if (plan.volume.has_cells() && plan.slots.empty()) {
        messages.warning("no probe is valid: all are inside solids. Check the level's winding, or give a --volume");
    }

    const fs::path output = !call.output.empty() ? fs::path(call.output)
                                                 : fs::path(call.level.empty() ? call.light.environment : call.level)
                                                       .filename()
                                                       .replace_extension(".probes.exr");
    check_folder(output);
    if (!call.report_json.empty()) check_folder(call.report_json);

    ProgressLine line(messages);
    BakeResult result = run_bake(paths, plan, options, [&](const std::string& stage, double share, std::uint64_t rays) {
        line.update(stage, share, rays);
    });
    line.finish();
    watch.lap();
    save_volume(result.volume, output);
    result.stages.push_back({"save", watch.lap(), 0});

    const nlohmann::json report = bake_report(plan, result, options, output);
    if (!call.report_json.empty()) write_whole_file(call.report_json, report.dump(2) + "\n");
    print_result(messages, plan, result, output);
    if (call.json) print(report.dump(2) + "\n");
    return 0;
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    using namespace lightgrid;
    return run_program("level-bake", [&] {
        Call call;
        CLI::App app{"Bakes the light of a level into a volume of SH probes.", "level-bake"};
        add_options(app, call);
        return parse_command_line(app, argc, argv) ? bake(call) : 0;
    });
}
