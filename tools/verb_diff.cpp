#include "core/error.h"
#include "core/sh.h"
#include "core/whole_file.h"
#include "probes/sampler.h"
#include "probes/volume_file.h"
#include "tools/csv.h"
#include "tools/difference.h"
#include "tools/program.h"
#include "tools/verbs.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <tuple>

namespace lightgrid {
namespace {

// What is known of the reference at a place: coefficients, or irradiance for some normals.
struct ReferencePoint {
    glm::dvec3 position{0};
    std::vector<glm::vec3> sh;
    struct Irradiance {
        glm::vec3 normal;
        glm::vec3 value;
        glm::vec3 error;
    };
    std::vector<Irradiance> irradiance;
};

struct Reference {
    std::vector<ReferencePoint> points;
    std::size_t unknown = 0;  // places where it knows no light itself
};

using PositionKey = std::tuple<double, double, double>;
PositionKey key_of(glm::dvec3 position) {
    return {position.x, position.y, position.z};
}

// The normals at which coefficients are compared: a spherical Fibonacci set.
std::vector<glm::vec3> comparison_normals() {
    constexpr int count = 64;
    std::vector<glm::vec3> normals;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1) / static_cast<double>(count);
        const double angle = 2 * std::numbers::pi * i / std::numbers::phi;
        const double radius = std::sqrt(1 - z * z);
        normals.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
    return normals;
}

// The valid probes, each at its place in the lattice, where interpolation has to reproduce it.
Reference reference_from(const Volume& volume) {
    Reference reference;
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        if (!is_valid(volume.states[slot])) {
            ++reference.unknown;
            continue;
        }
        const auto sh = volume.sh(slot);
        reference.points.push_back({lattice_position(volume, slot), {sh.begin(), sh.end()}, {}});
    }
    return reference;
}

glm::vec3 color_at(const CsvTable& table, std::size_t row, const std::array<std::size_t, 3>& columns) {
    return {table.number(row, columns[0]), table.number(row, columns[1]), table.number(row, columns[2])};
}

std::array<std::size_t, 3> color_columns(const CsvTable& table, const std::string& prefix) {
    return {table.column(prefix + "r"), table.column(prefix + "g"), table.column(prefix + "b")};
}

// The columns c0r c0g c0b c1r ...; as many as there are must make a square.
std::vector<std::array<std::size_t, 3>> coefficient_columns(const CsvTable& table) {
    std::vector<std::array<std::size_t, 3>> columns;
    while (table.find_column(fmt::format("c{}r", columns.size()))) {
        columns.push_back(color_columns(table, fmt::format("c{}", columns.size())));
    }
    if (columns.size() > static_cast<std::size_t>(sh_size(max_sh_bands)) ||
        sh_size(sh_bands(columns.size())) != static_cast<int>(columns.size())) {
        throw Error(fmt::format("{} coefficients are not the square of a number of bands from 1 to {}", columns.size(),
                                max_sh_bands),
                    table.name());
    }
    return columns;
}

// What query, reference and probes print.
Reference reference_from(const CsvTable& table) {
    const bool has_sh = table.find_column("c0r").has_value();
    if (!has_sh && !table.find_column("r")) {
        throw Error("has neither columns r, g, b nor c0r, c0g, c0b, ...", table.name(),
                    "Give what lightgrid query or reference printed.");
    }
    const Points places = to_points(table);
    if (!has_sh && places.normals.empty()) throw Error("has irradiance, but no normals nx, ny, nz", table.name());
    const auto coefficients = has_sh ? coefficient_columns(table) : std::vector<std::array<std::size_t, 3>>();
    const auto irradiance = has_sh ? std::array<std::size_t, 3>() : color_columns(table, "");
    const bool has_errors = !has_sh && table.find_column("er");
    const auto errors = has_errors ? color_columns(table, "e") : std::array<std::size_t, 3>();
    const auto valid = table.find_column("valid");

    Reference reference;
    std::map<PositionKey, std::size_t> points;
    for (std::size_t row = 0; row < table.rows(); ++row) {
        if (valid && table.number(row, *valid) == 0) {
            ++reference.unknown;
            continue;
        }
        const auto [found, is_new] = points.try_emplace(key_of(places.positions[row]), reference.points.size());
        if (is_new) reference.points.push_back({places.positions[row], {}, {}});
        ReferencePoint& point = reference.points[found->second];
        if (has_sh) {
            point.sh.clear();  // a place given twice counts once
            for (const auto& columns : coefficients) point.sh.push_back(color_at(table, row, columns));
        } else {
            point.irradiance.push_back({unit_normal(places.normals[row]), color_at(table, row, irradiance),
                                        has_errors ? color_at(table, row, errors) : glm::vec3(0)});
        }
    }
    return reference;
}

bool is_openexr(std::string_view bytes) {
    return bytes.starts_with("\x76\x2f\x31\x01");
}

Reference load_reference(const std::string& path) {
    if (path == "-") return reference_from(read_csv(path));
    std::string bytes = read_whole_file(path);
    if (is_openexr(bytes)) return reference_from(decode_volume(std::as_bytes(std::span(bytes)), path));
    return reference_from(CsvTable(std::move(bytes), path));
}

// Light at a place: of exactly that row of a list, or by interpolation.
class LightAt {
  public:
    LightAt(const Volume& volume, const std::string& name) : volume_(volume), name_(name) {
        if (volume.has_cells()) sampler_ = std::make_unique<Sampler>(volume);
        for (std::size_t row = 0; row < volume.list.size(); ++row) rows_.try_emplace(key_of(volume.list[row]), row);
    }

    // Writes coefficients; false: no valid probe is behind them.
    bool operator()(glm::dvec3 position, std::span<glm::vec3> sh) const {
        const auto found = rows_.find(key_of(position));
        if (found == rows_.end() && sampler_) return sampler_->sample(position, sh) > 0;
        if (found == rows_.end()) {
            throw Error(
                fmt::format("is a probe list and has no probe at {}, {}, {}", position.x, position.y, position.z),
                name_, "Compare it with a list of the same places, or bake a volume with a grid.");
        }
        const std::size_t slot = volume_.list_start() + found->second;
        const auto light = volume_.sh(slot);
        std::copy(light.begin(), light.end(), sh.begin());
        return is_valid(volume_.states[slot]);
    }

  private:
    const Volume& volume_;
    std::string name_;
    std::unique_ptr<Sampler> sampler_;  // for a volume with cells
    std::map<PositionKey, std::size_t> rows_;
};

std::string percent(double share) {
    return fmt::format("{:.3g} %", 100 * share);
}

void print_text(const Difference& d, std::size_t unknown_in_reference, std::size_t unknown) {
    print(fmt::format("relRMSE         {}", percent(d.relrmse)));
    if (d.interval) {
        print(fmt::format("   (95 % interval {} to {})", percent(d.interval->first), percent(d.interval->second)));
    }
    print(fmt::format("\nmean error      {}\n", percent(d.mean_error)));
    print(
        fmt::format("largest errors  {} median, {} at 95 %, {} at 99 % of the values, relative to each point's mean\n",
                    percent(d.p50), percent(d.p95), percent(d.p99)));
    if (d.reference_noise > 0) print(fmt::format("noise of A      {}, taken out above\n", percent(d.reference_noise)));
    print(fmt::format("points          {} ({} values)", d.points, d.values));
    if (unknown > 0) print(fmt::format(", {} without a valid probe in B", unknown));
    if (unknown_in_reference > 0) print(fmt::format("; {} invalid ones of A left out", unknown_in_reference));
    print("\n");
}

void print_json(const Difference& d, std::size_t unknown_in_reference, std::size_t unknown) {
    nlohmann::ordered_json json;
    json["relrmse"] = d.relrmse;  // null where it is infinite
    json["interval"] = nullptr;
    if (d.interval) json["interval"] = {d.interval->first, d.interval->second};
    json["mean_error"] = d.mean_error;
    json["p50"] = d.p50;
    json["p95"] = d.p95;
    json["p99"] = d.p99;
    json["reference_noise"] = d.reference_noise;
    json["points"] = d.points;
    json["values"] = d.values;
    json["unknown"] = unknown;
    json["unknown_in_reference"] = unknown_in_reference;
    print(json.dump(2) + "\n");
}

}  // namespace

void run_diff(const std::string& reference_path, const std::string& volume_path, bool json) {
    const Volume volume = load_volume(volume_path);
    const Reference reference = load_reference(reference_path);
    if (reference.points.empty()) {
        throw Error(reference.unknown > 0 ? "has no valid probe to compare with" : "has no rows", reference_path);
    }
    const LightAt light_at(volume, volume_path);
    const std::vector<glm::vec3> normals = comparison_normals();
    std::vector<glm::vec3> sh(volume.sh_size());
    DifferenceMeter meter;
    std::size_t unknown = 0;
    for (const ReferencePoint& point : reference.points) {
        if (!light_at(point.position, sh)) ++unknown;
        std::vector<ComparedIrradiance> compared;
        if (!point.sh.empty()) {
            for (const glm::vec3& n : normals) {
                compared.push_back({irradiance_from_sh(point.sh, n), glm::vec3(0), irradiance_from_sh(sh, n)});
            }
        }
        for (const ReferencePoint::Irradiance& known : point.irradiance) {
            compared.push_back({known.value, known.error, irradiance_from_sh(sh, known.normal)});
        }
        meter.add_point(compared);
    }
    const Difference difference = meter.measure();
    json ? print_json(difference, reference.unknown, unknown) : print_text(difference, reference.unknown, unknown);
}

}  // namespace lightgrid
