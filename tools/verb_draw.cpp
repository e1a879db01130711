#include "core/error.h"
#include "core/gltf.h"
#include "core/whole_file.h"
#include "probes/sampler.h"
#include "probes/volume_file.h"
#include "tools/error_chart.h"
#include "tools/pictures.h"
#include "tools/program.h"
#include "tools/verbs.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <vector>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

double finest_spacing(const Volume& volume) {
    double spacing = volume.grids.front().spacing.x;
    for (const Grid& grid : volume.grids) {
        spacing = std::min({spacing, grid.spacing.x, grid.spacing.y, grid.spacing.z});
    }
    return spacing;
}

glm::dvec3 middle_of(const Volume& volume) {
    Box box;
    for (const Grid& grid : volume.grids) {
        box.extend(grid.origin);
        box.extend(grid.position(grid.counts - 1));
    }
    return box.min + glm::dvec3(0.5, 0.4, 0.5) * box.size();
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
    pictures.at = options.at.value_or(middle_of(volume));
    const ChosenLight light = choose_light(options.light);

    const Scene scene = load_level(options.level, {options.scene});
    const Tracer tracer(scene);
    const Sampler sampler(volume);
    const double spacing = finest_spacing(volume);
    const std::vector<glm::vec3> sky = environment_sh(light.environment, volume.bands);
    const SampleOptions look_up{.normal_bias = options.normal_bias.value_or(static_cast<float>(0.3 * spacing)),
                                .outside = Outside::fade,
                                .fade_distance = static_cast<float>(4 * spacing),
                                .environment = sky};
    const LitLevel level{&tracer, &sampler, &light.environment, look_up};

    const fs::path folder = options.folder;
    fs::create_directories(folder);
    const auto save = [&](const Canvas& canvas, const char* name) {
        canvas.write_png(folder / name);
        print(fmt::format("{}\n", (folder / name).string()));
    };
    if (!options.camera.empty()) {
        const std::vector<double>& n = options.camera;
        const glm::dvec3 eye(n[0], n[1], n[2]);
        const glm::dvec3 target(n[3], n[4], n[5]);
        if (eye == target) throw Error("eye and target are the same point", "--camera");
        save(draw_view(level, Camera::looking_at(eye, target, options.angle_deg), pictures), "view.png");
    }
    save(draw_slices(level, volume, pictures), "slices.png");
    save(draw_probes(level, volume, pictures), "probes.png");
    if (!options.report.empty()) {
        nlohmann::json report;
        try {
            report = nlohmann::json::parse(read_whole_file(options.report));
        } catch (const nlohmann::json::exception& problem) {
            throw Error(problem.what(), options.report, "Give the file that --report-json wrote");
        }
        write_whole_file(folder / "error.svg", error_chart(report, options.report));
        print(fmt::format("{}\n", (folder / "error.svg").string()));
    }
}

}  // namespace lightgrid
