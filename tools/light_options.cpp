#include "tools/light_options.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>

#include "core/environment_file.h"
#include "core/error.h"
#include "core/sun_sky.h"

namespace lightgrid {

void add_light_options(CLI::App& app, LightOptions& options) {
    const char* group = "Light (a level's own lights always count)";
    app.add_option("--environment", options.environment, "Image of what is around the level: .hdr, .exr, .png, .jpg")
        ->type_name("FILE")
        ->group(group);
    app.add_option("--environment-layout", options.layout,
                   "How the image wraps: auto, equirect, vertical-cross, horizontal-cross, strip, angular")
        ->type_name("LAYOUT")
        ->group(group);
    app.add_option("--environment-rotation", options.rotation_deg, "Turns it counter-clockwise about +Y, seen from above")
        ->type_name("DEG")
        ->group(group);
    app.add_option("--environment-intensity", options.intensity, "Multiplies its radiance")->type_name("S")->group(group);
    app.add_option("--sky", options.sky, "Uniform radiance over the whole sphere, cd/m^2")->type_name("R,G,B")->group(group);
    app.add_option("--sun-sky", options.sun_sky,
                   "Daylight: elevation and azimuth of the sun in degrees, turbidity (clear 2 .. hazy 10, default 3)")
        ->type_name("ELEVATION,AZIMUTH[,TURBIDITY]")
        ->group(group);
}

std::vector<double> parse_numbers(const std::string& text, std::size_t count, const std::string& option,
                                  const std::string& example) {
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
        if (at < end && *at++ != ',') break;
        if (at == end && numbers.size() == count) return numbers;
    }
    throw Error(fmt::format("\"{}\" is not {} numbers with commas between them", text, count), option,
                fmt::format("Write for example {} {}", option, example));
}

ChosenLight choose_light(const LightOptions& options) {
    const int given = (options.environment.empty() ? 0 : 1) + (options.sky.empty() ? 0 : 1) + (options.sun_sky.empty() ? 0 : 1);
    if (given > 1) {
        throw Error("--environment, --sky and --sun-sky exclude each other", "", "Give one of them");
    }
    ChosenLight light;
    if (!options.sky.empty()) {
        const std::vector<double> rgb = parse_numbers(options.sky, 3, "--sky", "1,1,1");
        if (rgb[0] < 0 || rgb[1] < 0 || rgb[2] < 0) throw Error("radiance cannot be negative", "--sky");
        light.environment = Environment::uniform(glm::vec3(rgb[0], rgb[1], rgb[2]));
        light.description = fmt::format("uniform sky {},{},{} cd/m^2", rgb[0], rgb[1], rgb[2]);
    } else if (!options.sun_sky.empty()) {
        const bool with_turbidity = std::count(options.sun_sky.begin(), options.sun_sky.end(), ',') == 2;
        const std::vector<double> numbers =
            parse_numbers(options.sun_sky, with_turbidity ? 3 : 2, "--sun-sky", "40,120,3");
        SunSky sun_sky;
        sun_sky.elevation_deg = static_cast<float>(numbers[0]);
        sun_sky.azimuth_deg = static_cast<float>(numbers[1]);
        if (with_turbidity) sun_sky.turbidity = static_cast<float>(numbers[2]);
        light.environment = make_sun_sky(sun_sky);
        light.description = fmt::format("sun at {} deg elevation, {} deg azimuth, turbidity {}", sun_sky.elevation_deg,
                                        sun_sky.azimuth_deg, sun_sky.turbidity);
    } else if (!options.environment.empty()) {
        if (!std::isfinite(options.rotation_deg)) throw Error("not a finite angle", "--environment-rotation");
        if (!(options.intensity >= 0) || !std::isfinite(options.intensity)) {
            throw Error("must be a finite number, 0 or more", "--environment-intensity");
        }
        EnvironmentOptions environment;
        environment.layout = parse_environment_layout(options.layout);
        environment.rotation_deg = static_cast<float>(options.rotation_deg);
        environment.scale = static_cast<float>(options.intensity);
        LoadedEnvironment loaded = load_environment(options.environment, environment);
        light.environment = std::move(loaded.environment);
        light.notices = std::move(loaded.notices);
        light.description = fmt::format("{}, turned {} deg, times {}",
                                        std::filesystem::path(options.environment).filename().string(),
                                        options.rotation_deg, options.intensity);
    }
    return light;
}

}  // namespace lightgrid
