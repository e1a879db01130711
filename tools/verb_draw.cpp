#include "core/error.h"
#include "core/gltf.h"
#include "core/whole_file.h"
#include "probes/sampler.h"
#include "probes/volume_file.h"
#include "tools/error_chart.h"
#include "tools/pictures.h"
#include "tools/program.h"
#include "tools/verbs.h"
#include "tools/viewpoint.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <system_error>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

Camera choose_camera(const DrawOptions& options, const Tracer& tracer, const Volume& volume) {
    if (options.camera.empty()) return find_viewpoint(tracer, volume, options.angle_deg);
    const glm::dvec3 eye(options.camera[0], options.camera[1], options.camera[2]);
    const glm::dvec3 target(options.camera[3], options.camera[4], options.camera[5]);
    if (eye == target) throw Error("eye and target are the same point", "--camera");
    return Camera::looking_at(eye, target, options.angle_deg);
}

nlohmann::json read_report(const std::string& path) {
    try {
        return nlohmann::json::parse(read_whole_file(path));
    } catch (const nlohmann::json::exception& problem) {
        throw Error(problem.what(), path, "Give the file that --report-json wrote");
    }
}

}  // namespace

void run_draw(const DrawOptions& options) {
    const Volume volume = load_volume(options.volume);
    if (!volume.has_cells()) {
        throw Error("is a probe list: it has no cells to look light up in", options.volume,
                    "Bake a volume with a grid");
    }
    PictureOptions pictures;
    pictures.width = options.width;
    pictures.exposure = options.exposure;
    const Box box = bounds_of(volume);
    pictures.at = options.at.value_or(box.min + glm::dvec3(0.5, 0.4, 0.5) * box.size());
    const ChosenLight light = choose_light(options.light);

    const Scene scene = load_level(options.level, load_options(with_recorded(options.level_options, volume)));
    const Tracer tracer(scene);
    const Sampler sampler(volume);
    const double spacing = finest_spacing(volume);
    const double normal_bias = options.normal_bias ? *options.normal_bias / scene.metres_per_unit : 0.3 * spacing;
    const SampleOptions look_up{.normal_bias = static_cast<float>(normal_bias)};
    const LitLevel level{&tracer, &sampler, &light.environment, look_up};

    const std::string chart =
        options.report.empty() ? std::string() : error_chart(read_report(options.report), options.report);
    const Camera camera = choose_camera(options, tracer, volume);

    const fs::path folder = options.folder;
    std::error_code problem;
    fs::create_directories(folder, problem);
    if (problem)
        throw Error("cannot be created: " + problem.message(), options.folder, "Choose another --output", Fault::work);
    const auto save = [&](const Canvas& canvas, const char* name) {
        canvas.write_png(folder / name);
        print(fmt::format("{}\n", (folder / name).string()));
    };
    save(draw_view(level, camera, pictures), "view.png");
    save(draw_slices(level, volume, pictures), "slices.png");
    save(draw_probes(level, volume, pictures), "probes.png");
    if (!chart.empty()) {
        write_whole_file(folder / "error.svg", chart);
        print(fmt::format("{}\n", (folder / "error.svg").string()));
    }
}

}  // namespace lightgrid
