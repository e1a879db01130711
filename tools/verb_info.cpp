#include "core/whole_file.h"
#include "probes/volume_file.h"
#include "tools/level_options.h"
#include "tools/program.h"
#include "tools/verbs.h"
#include "tools/volume_summary.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace lightgrid {
namespace {

// Nine digits for people: a millimetre in a thousand kilometres. --json has them all.
template <typename Vector>
std::string by(const Vector& v) {
    return fmt::format("{:.9g} x {:.9g} x {:.9g}", static_cast<double>(v.x), static_cast<double>(v.y),
                       static_cast<double>(v.z));
}

std::string place(const glm::dvec3& v) {
    return fmt::format("({:.9g}, {:.9g}, {:.9g})", v.x, v.y, v.z);
}

template <typename Vector>
nlohmann::ordered_json to_json(const Vector& v) {
    return {v.x, v.y, v.z};
}

const char* storage(const Volume& volume) {
    return volume.half ? "half" : "float";
}

void print_text(const std::string& path, std::size_t bytes, const Volume& volume) {
    const VolumeSummary summary = summarize(volume);
    const auto line = [](const char* label, const std::string& text) { print(fmt::format("{:<16}{}\n", label, text)); };
    line("file", fmt::format("{}, {} bytes, format {}", path, bytes, volume_format));
    if (!volume.list.empty()) {
        line("probe list", fmt::format("{} places{}", volume.list.size(), volume.has_cells() ? "" : ", no cells"));
    }
    for (std::size_t g = 0; g < volume.grids.size(); ++g) {
        const Grid& grid = volume.grids[g];
        line(fmt::format("grid {}", g).c_str(), fmt::format("{} probes, spacing {} m, from {} to {}", by(grid.counts),
                                                            by(metres_per_unit(volume) * grid.spacing),
                                                            place(grid.origin), place(grid.position(grid.counts - 1))));
    }
    if (volume.has_cells()) line("bricks", fmt::format("{} of {}^3 probes", volume.bricks.size(), brick_size));
    line("probes", fmt::format("{}: {} valid ({} of them moved), {} filled, {} missing", summary.probes(),
                               summary.valid(), summary.count(ProbeState::moved), summary.count(ProbeState::filled),
                               summary.count(ProbeState::missing)));
    line("bands", fmt::format("{}, {} coefficients of {}, stored as {}", volume.bands, volume.sh_size(),
                              is_grey(volume.coefficients) ? "grey" : "RGB", storage(volume)));
    line("irradiance", fmt::format("{:.4g} {:.4g} {:.4g} lux, mean of the valid probes and six axes",
                                   summary.irradiance.r, summary.irradiance.g, summary.irradiance.b));
    line("standard error",
         fmt::format("{:.3g} lux, {:.3g} % of the irradiance", summary.noise, 100 * summary.relative_noise));
    if (summary.worst_noise > 0) {
        line("",
             fmt::format("{:.3g} % at the worst probe, {}", 100 * summary.worst_noise, place(summary.worst_position)));
    }
    for (const Layer& layer : volume.layers) {
        line(("layer " + layer.name).c_str(),
             fmt::format("{} bytes before compression, standard error {:.3g} % of its irradiance",
                         stored_bytes(volume, layer.coefficients), 100 * layer.noise));
    }
    line("conventions", std::string(volume_conventions));
    for (const auto& [name, value] : volume.settings) line(name.c_str(), value);
}

// The number of independent replicates behind the standard errors, if the settings say so.
nlohmann::ordered_json replicates(const Volume& volume) {
    const auto found = volume.settings.find("replicates");
    if (found == volume.settings.end()) return nullptr;
    return nlohmann::ordered_json::parse(found->second, nullptr, false);
}

void print_json(const std::string& path, std::size_t bytes, const Volume& volume) {
    const VolumeSummary summary = summarize(volume);
    nlohmann::ordered_json json;
    json["file"] = path;
    json["bytes"] = bytes;
    json["format"] = volume_format;
    json["kind"] = volume.has_cells() ? "grid" : "list";
    json["grids"] = nlohmann::ordered_json::array();
    for (const Grid& grid : volume.grids) {
        json["grids"].push_back(
            {{"origin", to_json(grid.origin)}, {"spacing", to_json(grid.spacing)}, {"counts", to_json(grid.counts)}});
    }
    json["bricks"] = volume.bricks.size();
    json["list"] = volume.list.size();
    json["probes"] = {{"total", summary.probes()},
                      {"valid", summary.valid()},
                      {"moved", summary.count(ProbeState::moved)},
                      {"filled", summary.count(ProbeState::filled)},
                      {"missing", summary.count(ProbeState::missing)}};
    json["metres_per_unit"] = metres_per_unit(volume);
    json["bands"] = volume.bands;
    json["storage"] = {{"type", storage(volume)},
                       {"grey", is_grey(volume.coefficients)},
                       {"bands", used_bands(volume.coefficients, volume.bands)}};
    json["replicates"] = replicates(volume);
    json["irradiance"] = {{"mean", to_json(summary.irradiance)},
                          {"standard_error", summary.noise},
                          {"relative_error", summary.relative_noise},
                          {"worst_relative_error", summary.worst_noise},
                          {"worst_position", nullptr}};
    if (summary.worst_noise > 0) json["irradiance"]["worst_position"] = to_json(summary.worst_position);
    json["layers"] = nlohmann::ordered_json::array();
    for (const Layer& layer : volume.layers) {
        json["layers"].push_back({{"name", layer.name},
                                  {"bytes", stored_bytes(volume, layer.coefficients)},
                                  {"relative_error", layer.noise}});
    }
    json["conventions"] = volume_conventions;
    json["settings"] = volume.settings;
    // Paths need not be UTF-8.
    print(json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

}  // namespace

void run_info(const std::string& volume_path, bool json) {
    const std::string bytes = read_whole_file(volume_path);
    const Volume volume = decode_volume(std::as_bytes(std::span(bytes)), volume_path);
    json ? print_json(volume_path, bytes.size(), volume) : print_text(volume_path, bytes.size(), volume);
}

}  // namespace lightgrid
