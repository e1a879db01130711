#include "core/environment_file.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace lightgrid {
namespace {

EnvironmentLayout recognise(const RadianceFile& file, std::vector<std::string>& notices) {
    if (file.envmap != Envmap::unspecified) {
        const EnvironmentLayout layout =
            file.envmap == Envmap::cube ? EnvironmentLayout::openexr_cube : EnvironmentLayout::openexr_latlong;
        notices.push_back(fmt::format("read as {}, as its envmap attribute says", name_of(layout)));
        return layout;
    }
    const int width = file.image.width;
    const int height = file.image.height;
    const EnvironmentLayout layout = layout_of_shape(width, height);
    if (layout == EnvironmentLayout::automatic)
        throw Error(fmt::format("{} x {} pixels are the shape of no environment", width, height), "",
                    "Scale it to 2:1, or name its layout.");
    if (width != 2 * height) {
        const char* const remark = layout == EnvironmentLayout::angular ? " (a square may be something else)" : "";
        notices.push_back(fmt::format("{} x {} pixels: taken for layout {}{}", width, height, name_of(layout), remark));
    }
    return layout;
}

void clamp_negative(RadianceImage& image, std::vector<std::string>& notices) {
    std::size_t count = 0;
    float lowest = 0;
    for (glm::vec3& pixel : image.pixels) {
        const float least = std::min({pixel.r, pixel.g, pixel.b});
        if (!(least < 0)) continue;
        ++count;
        lowest = std::min(lowest, least);
        pixel = glm::max(pixel, glm::vec3(0));
    }
    if (count > 0) notices.push_back(fmt::format("{} negative pixels, down to {:g}, set to 0", count, lowest));
}

}  // namespace

LoadedEnvironment load_environment(const std::filesystem::path& path, const EnvironmentOptions& options) {
    RadianceFile file = read_radiance(path, options.layer);
    LoadedEnvironment loaded;
    loaded.notices = std::move(file.notices);
    try {
        loaded.layout =
            options.layout == EnvironmentLayout::automatic ? recognise(file, loaded.notices) : options.layout;
        clamp_negative(file.image, loaded.notices);
        loaded.environment = Environment::from_image(to_equirectangular(std::move(file.image), loaded.layout),
                                                     options.rotation_deg, options.scale);
    } catch (const Error& error) {
        throw error.inside(path.string());
    }
    return loaded;
}

}  // namespace lightgrid
