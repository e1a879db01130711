#include "viewer/flight.h"

#include "core/error.h"
#include "core/whole_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace lightgrid {
namespace {

using nlohmann::json;

/// The key before a time, or the last but one; and how far it is from there to the next, in [0, 1].
struct Place {
    std::size_t before = 0;
    double share = 0;
};

Place place_of(const Flight& flight, double time_s) {
    const auto after = std::upper_bound(flight.keys.begin(), flight.keys.end(), time_s,
                                        [](double time, const FlightKey& key) { return time < key.time_s; });
    if (after == flight.keys.begin() || flight.keys.size() == 1) return {0, 0};
    const std::size_t before =
        std::min(static_cast<std::size_t>(after - flight.keys.begin()) - 1, flight.keys.size() - 2);
    const double from = flight.keys[before].time_s;
    const double to = flight.keys[before + 1].time_s;
    return {before, std::clamp((time_s - from) / (to - from), 0.0, 1.0)};
}

/// value_of(i) of key i, between two keys.
template <typename ValueOf>
auto interpolate(const Flight& flight, const Place& place, ValueOf value_of) {
    const std::size_t last = flight.keys.size() - 1;
    if (last == 0) return value_of(std::size_t{0});
    const auto tangent = [&](std::size_t i) {
        const std::size_t a = i == 0 ? 0 : i - 1;
        const std::size_t b = std::min(i + 1, last);
        return (value_of(b) - value_of(a)) / (flight.keys[b].time_s - flight.keys[a].time_s);
    };
    const std::size_t i = place.before;
    const double length = flight.keys[i + 1].time_s - flight.keys[i].time_s;
    const double t = place.share;
    const double t2 = t * t;
    const double t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * value_of(i) + (3 * t2 - 2 * t3) * value_of(i + 1) +
           (t3 - 2 * t2 + t) * length * tangent(i) + (t3 - t2) * length * tangent(i + 1);
}

Pose pose_of(const FlightKey& key) {
    if (key.look_at) return looking_at(key.eye, *key.look_at);
    return {key.eye, key.yaw_deg, key.pitch_deg};
}

/// Yaw of key i, continued from the key `from` without a jump. Only neighbours of a place are ever asked for.
double continued_yaw(const Flight& flight, std::size_t from, std::size_t i) {
    const double yaw = pose_of(flight.keys[i]).yaw_deg;
    if (i == from) return yaw;
    const std::size_t nearer = i < from ? i + 1 : i - 1;
    const double neighbour = continued_yaw(flight, from, nearer);
    return neighbour + std::remainder(yaw - neighbour, 360);
}

// ---- JSON ----------------------------------------------------------------------------------------------------------

double number_of(const json& value, const std::string& name) {
    if (!value.is_number() || !std::isfinite(value.get<double>())) {
        throw Error(fmt::format("\"{}\" is not a finite number", name));
    }
    return value.get<double>();
}

glm::dvec3 point_of(const json& value, const std::string& name) {
    if (!value.is_array() || value.size() != 3) throw Error(fmt::format("\"{}\" is not three numbers [x, y, z]", name));
    return {number_of(value[0], name), number_of(value[1], name), number_of(value[2], name)};
}

void check_names(const json& object, std::initializer_list<const char*> known) {
    if (!object.is_object()) throw Error("is no JSON object");
    for (const auto& [name, value] : object.items()) {
        if (std::find(known.begin(), known.end(), name) == known.end()) {
            throw Error(fmt::format("\"{}\" is not known", name), "",
                        fmt::format("Known are {}", fmt::join(known, ", ")));
        }
    }
}

FlightKey key_of(const json& entry) {
    check_names(entry, {"time_s", "eye", "look_at", "yaw_deg", "pitch_deg", "object"});
    FlightKey key;
    if (!entry.contains("time_s") || !entry.contains("eye")) throw Error("needs \"time_s\" and \"eye\"");
    key.time_s = number_of(entry["time_s"], "time_s");
    key.eye = point_of(entry["eye"], "eye");
    const bool turned = entry.contains("yaw_deg") || entry.contains("pitch_deg");
    if (entry.contains("look_at") == turned) {
        throw Error("needs either \"look_at\" or \"yaw_deg\" and \"pitch_deg\"");
    }
    if (entry.contains("look_at")) key.look_at = point_of(entry["look_at"], "look_at");
    if (entry.contains("yaw_deg")) key.yaw_deg = number_of(entry["yaw_deg"], "yaw_deg");
    if (entry.contains("pitch_deg")) key.pitch_deg = number_of(entry["pitch_deg"], "pitch_deg");
    if (std::abs(key.pitch_deg) > most_pitch_deg) {
        throw Error(fmt::format("\"pitch_deg\" is not within {} and {}", -most_pitch_deg, most_pitch_deg));
    }
    if (entry.contains("object")) key.object = point_of(entry["object"], "object");
    return key;
}

Flight flight_of(const json& document) {
    check_names(document, {"frames_per_second", "keys"});
    Flight flight;
    if (document.contains("frames_per_second")) {
        flight.frames_per_second = number_of(document["frames_per_second"], "frames_per_second");
        if (!(flight.frames_per_second > 0)) throw Error("\"frames_per_second\" is not positive");
    }
    if (!document.contains("keys") || !document["keys"].is_array() || document["keys"].empty()) {
        throw Error("has no \"keys\"", "", "Give at least one");
    }
    for (const json& entry : document["keys"]) {
        const std::string where = fmt::format("key {}", flight.keys.size());
        try {
            flight.keys.push_back(key_of(entry));
        } catch (const Error& error) {
            throw error.inside(where);
        }
        const FlightKey& first = flight.keys.front();
        const FlightKey& key = flight.keys.back();
        if (flight.keys.size() > 1 && !(key.time_s > flight.keys[flight.keys.size() - 2].time_s)) {
            throw Error(fmt::format("\"time_s\" {} is not after that of the key before", key.time_s), where);
        }
        if (key.object.has_value() != first.object.has_value()) {
            throw Error("\"object\" is in some keys and not in others", where, "Give it in all keys or in none");
        }
    }
    return flight;
}

json point_json(glm::dvec3 point) {
    return json::array({point.x, point.y, point.z});
}

}  // namespace

FlightMoment evaluate(const Flight& flight, double time_s) {
    const Place place = place_of(flight, time_s);
    const glm::dvec3 eye = interpolate(flight, place, [&](std::size_t i) { return flight.keys[i].eye; });
    FlightMoment moment;
    if (std::all_of(flight.keys.begin(), flight.keys.end(), [](const FlightKey& key) { return key.look_at; })) {
        moment.pose =
            looking_at(eye, interpolate(flight, place, [&](std::size_t i) { return flight.keys[i].look_at.value(); }));
    } else {
        const double yaw =
            interpolate(flight, place, [&](std::size_t i) { return continued_yaw(flight, place.before, i); });
        const double pitch =
            interpolate(flight, place, [&](std::size_t i) { return pose_of(flight.keys[i]).pitch_deg; });
        moment.pose = turned({eye, yaw, 0}, 0, pitch);
    }
    if (flight.keys.front().object) {
        moment.object = interpolate(flight, place, [&](std::size_t i) { return flight.keys[i].object.value(); });
    }
    return moment;
}

double frame_time_s(const Flight& flight, int frame, int frames) {
    return flight.start_s() + (frames > 1 ? flight.duration_s() * frame / (frames - 1) : 0);
}

int frame_count(const Flight& flight) {
    return 1 + static_cast<int>(std::floor(flight.duration_s() * flight.frames_per_second + 1e-9));
}

Flight load_flight(const std::filesystem::path& path) {
    const std::string text = read_whole_file(path);
    try {
        return flight_of(json::parse(text));
    } catch (const json::exception& problem) {
        throw Error(problem.what(), path.string(), "A path is JSON: see fly-through --help");
    } catch (const Error& error) {
        throw error.inside(path.string());
    }
}

void save_flight(const Flight& flight, const std::filesystem::path& path) {
    json keys = json::array();
    for (const FlightKey& key : flight.keys) {
        json entry{{"time_s", key.time_s}, {"eye", point_json(key.eye)}};
        if (key.look_at) {
            entry["look_at"] = point_json(*key.look_at);
        } else {
            entry["yaw_deg"] = key.yaw_deg;
            entry["pitch_deg"] = key.pitch_deg;
        }
        if (key.object) entry["object"] = point_json(*key.object);
        keys.push_back(std::move(entry));
    }
    const json document{{"frames_per_second", flight.frames_per_second}, {"keys", keys}};
    write_whole_file(path, document.dump(1) + "\n");
}

}  // namespace lightgrid
