#include "viewer/false_colors.h"

#include "core/sampling.h"

#include <cmath>
#include <vector>

namespace lightgrid {

LightScales scales_of(std::span<const VertexLight> light) {
    std::vector<float> irradiance;
    std::vector<float> standard_error;
    for (const VertexLight& vertex : light) {
        for (const glm::vec4& side : {vertex.front, vertex.back}) {
            irradiance.push_back(luminance(glm::vec3(side)));
            standard_error.push_back(side.w);
        }
    }
    return {scale_of(std::move(irradiance)), scale_of(std::move(standard_error))};
}

LogScale difference_scale() {
    return {{0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1}};
}

void set_false_colors(const Uniforms& uniforms, const FalseColors& colors) {
    uniforms.set("ramp", false_color_ramp().data(), static_cast<int>(false_color_ramp().size()));
    uniforms.set("lowest", static_cast<float>(std::log(colors.scale.marks.front())));
    uniforms.set("highest", static_cast<float>(std::log(colors.scale.marks.back())));
    uniforms.set("of_error", colors.what == LevelColors::irradiance ? 0 : 1);
    uniforms.set("tone", static_cast<int>(colors.tone));
}

}  // namespace lightgrid
