#include "tools/light_options.h"

#include "core/environment_file.h"
#include "core/error.h"
#include "core/sun_sky.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

namespace lightgrid {
namespace {

bool has_turbidity(const std::string& sun_sky) {
    return std::count(sun_sky.begin(), sun_sky.end(), ',') == 2;
}

std::vector<double> parse_sun_sky(const std::string& text) {
    return parse_numbers(text, has_turbidity(text) ? 3 : 2, "40,120,3");
}

glm::vec3 parse_sky(const std::string& text) {
    const std::vector<double> rgb = parse_numbers(text, 3, "1,1,1");
    for (const double value : rgb) {
        if (value < 0) throw Error(fmt::format("{}: radiance cannot be negative", text));
        if (value > std::numeric_limits<float>::max()) throw Error(fmt::format("{}: too large a number", text));
    }
    return {rgb[0], rgb[1], rgb[2]};
}

}  // namespace

CLI::Validator checked(const std::function<void(const std::string&)>& parse) {
    return {[parse](const std::string& text) {
                try {
                    parse(text);
                    return std::string();
                } catch (const Error& error) {
                    return std::string(error.what());
                }
            },
            "", "checked"};
}

CLI::Validator number(double least, double most, bool whole) {
    return checked([=](const std::string& text) {
        double value = 0;
        const char* end = text.data() + text.size();
        const auto [stopped_at, problem] = std::from_chars(text.data(), end, value);
        const bool fits = problem == std::errc() && stopped_at == end && value >= least && value <= most;
        if (fits && (!whole || value == std::floor(value))) return;
        const bool has_least = least > std::numeric_limits<double>::lowest();
        const bool has_most = most < std::numeric_limits<double>::max();
        std::string wanted = whole ? "whole number" : "finite number";
        if (has_least) wanted += fmt::format(" from {}{}", least, has_most ? "" : " on");
        if (has_most) wanted += fmt::format(" to {}", most);
        throw Error(fmt::format("{} is not a {}", text, wanted));
    });
}

void add_light_options(CLI::App& app, LightOptions& options) {
    const char* group = "Light (a level's own lights always count)";
    app.add_option("--environment", options.environment, "Image of what is around the level: .hdr, .exr, .png, .jpg")
        ->type_name("FILE")
        ->group(group);
    app.add_option("--environment-layout", options.layout,
                   "How the image wraps: auto, equirect, vertical-cross, horizontal-cross, strip, angular")
        ->type_name("LAYOUT")
        ->check(checked(parse_environment_layout))
        ->group(group);
    app.add_option("--environment-layer", options.layer,
                   "Which layer of a multi-layer OpenEXR image (default: combined or beauty, and said)")
        ->type_name("NAME")
        ->group(group);
    app.add_option("--environment-rotation", options.rotation_deg,
                   "Turns it counter-clockwise about +Y, seen from above")
        ->type_name("DEG")
        ->check(number())
        ->group(group);
    app.add_option("--environment-intensity", options.intensity, "Multiplies its radiance")
        ->type_name("S")
        ->check(number(0))
        ->group(group);
    app.add_option("--sky", options.sky, "Uniform radiance over the whole sphere, cd/m^2")
        ->type_name("R,G,B")
        ->check(checked(parse_sky))
        ->group(group);
    app.add_option("--sun-sky", options.sun_sky,
                   "Daylight: elevation and azimuth of the sun in degrees, turbidity (clear 2 .. hazy 10, default 3)")
        ->type_name("ELEVATION,AZIMUTH[,TURBIDITY]")
        ->check(checked(parse_sun_sky))
        ->group(group);
}

std::vector<double> parse_numbers(const std::string& text, std::size_t count, const std::string& example) {
    std::vector<double> numbers;
    const char* at = text.data();
    const char* end = at + text.size();
    while (at < end) {
        while (at < end && *at == ' ') ++at;
        double number = 0;
        const auto [next, problem] = std::from_chars(at, end, number);
        if (problem != std::errc() || !std::isfinite(number)) break;
        numbers.push_back(number);
        at = next;
        while (at < end && *at == ' ') ++at;
        if (at == end && numbers.size() == count) return numbers;
        if (at < end && *at++ != ',') break;
    }
    if (count == 1) throw Error(fmt::format("\"{}\" is not a number, like {}", text, example));
    throw Error(fmt::format("\"{}\" is not {} numbers with commas between them, like {}", text, count, example));
}

ChosenLight choose_light(const LightOptions& options) {
    const int given =
        (options.environment.empty() ? 0 : 1) + (options.sky.empty() ? 0 : 1) + (options.sun_sky.empty() ? 0 : 1);
    if (given > 1) {
        throw Error("--environment, --sky and --sun-sky exclude each other", "", "Give one of them");
    }
    if (options.environment.empty() &&
        (options.layout != "auto" || !options.layer.empty() || options.rotation_deg != 0 || options.intensity != 1)) {
        throw Error(
            "--environment-layout, --environment-layer, --environment-rotation and --environment-intensity belong to "
            "an "
            "--environment",
            "", "Give one, or leave them out");
    }
    ChosenLight light;
    if (!options.sky.empty()) {
        const glm::vec3 radiance = parse_sky(options.sky);
        light.environment = Environment::uniform(radiance);
        light.description = fmt::format("uniform sky {},{},{} cd/m^2", radiance.r, radiance.g, radiance.b);
    } else if (!options.sun_sky.empty()) {
        const std::vector<double> numbers = parse_sun_sky(options.sun_sky);
        SunSky sun_sky;
        sun_sky.elevation_deg = static_cast<float>(numbers[0]);
        sun_sky.azimuth_deg = static_cast<float>(numbers[1]);
        if (numbers.size() == 3) sun_sky.turbidity = static_cast<float>(numbers[2]);
        try {
            light.environment = make_sun_sky(sun_sky);
        } catch (const Error& error) {
            throw error.inside("--sun-sky");
        }
        light.description = fmt::format("sun at {} deg elevation, {} deg azimuth, turbidity {}", sun_sky.elevation_deg,
                                        sun_sky.azimuth_deg, sun_sky.turbidity);
    } else if (!options.environment.empty()) {
        EnvironmentOptions environment;
        environment.layout = parse_environment_layout(options.layout);
        environment.layer = options.layer;
        environment.rotation_deg = static_cast<float>(options.rotation_deg);
        environment.scale = static_cast<float>(options.intensity);
        LoadedEnvironment loaded = load_environment(options.environment, environment);
        light.environment = std::move(loaded.environment);
        light.notices = std::move(loaded.notices);
        light.description =
            fmt::format("{}, turned {} deg, times {}", std::filesystem::path(options.environment).filename().string(),
                        options.rotation_deg, options.intensity);
    }
    return light;
}

}  // namespace lightgrid
