#include "core/simplify.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

namespace lightgrid {
namespace {

struct Range {
    float least = 1;
    float most = 0;

    void extend(Range other) {
        least = std::min(least, other.least);
        most = std::max(most, other.most);
    }
};

/// Of the alpha of colours whose greatest value is `one`.
template <typename Color>
Range alpha_range(const std::vector<Color>& colors, float one) {
    auto least = colors.front().a;
    auto most = least;
    for (const Color& color : colors) {
        least = std::min(least, color.a);
        most = std::max(most, color.a);
    }
    return {static_cast<float>(least) / one, static_cast<float>(most) / one};
}

struct Saved {
    std::size_t count = 0;
    std::size_t bytes = 0;
};

std::string megabytes(std::size_t bytes) {
    return fmt::format("{:.1f} MB", static_cast<double>(bytes) * 1e-6);
}

class Simplifier {
  public:
    explicit Simplifier(Scene& scene)
        : scene_(scene), vertex_alpha_(scene.materials.size()), verdicts_(scene.materials.size(), Verdict::as_it_is) {}

    void run() {
        std::vector<bool> in_use(scene_.materials.size(), false);
        for (const Mesh& mesh : scene_.meshes) {
            if (mesh.triangles.empty()) continue;
            const auto material = static_cast<std::size_t>(mesh.material);
            in_use[material] = true;
            if (scene_.materials[material].alpha_mode != AlphaMode::opaque)
                vertex_alpha_[material].extend(mesh.colors.empty() ? Range{1, 1} : alpha_range(mesh.colors, 65535));
        }
        for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
            Material& material = scene_.materials[i];
            if (in_use[i]) {
                simplify_alpha(i);
                simplify_textures(material);
            } else {
                material.base_color_texture = material.transmission_texture = material.emission_texture = {};
            }
        }
        for (std::size_t i = 0; i < scene_.meshes.size(); ++i) simplify_mesh(i);
        drop_unused_textures();
        report();
    }

  private:
    enum class Verdict { as_it_is, opaque_after_all, invisible };

    [[nodiscard]] const std::vector<glm::u8vec4>& texels(const TextureUse& use) const {
        return scene_.textures[static_cast<std::size_t>(use.texture)].image.pixels;
    }
    /// Whether all texels are the same in what `part` makes of them.
    template <typename Part>
    [[nodiscard]] bool is_constant(const TextureUse& use, Part part) const {
        const auto& all = texels(use);
        return std::all_of(all.begin(), all.end(), [&](const glm::u8vec4& t) { return part(t) == part(all.front()); });
    }
    static glm::vec3 linear(glm::u8vec4 color) {
        return {decode_srgb(color.r), decode_srgb(color.g), decode_srgb(color.b)};
    }

    void simplify_alpha(std::size_t index) {
        Material& material = scene_.materials[index];
        if (material.alpha_mode == AlphaMode::opaque) return;
        Range alpha = vertex_alpha_[index];
        if (material.base_color_texture.used()) {
            const Range texture = alpha_range(texels(material.base_color_texture), 255);
            alpha.least *= texture.least;
            alpha.most *= texture.most;
        }
        alpha.least *= material.alpha;
        alpha.most *= material.alpha;
        const bool masked = material.alpha_mode == AlphaMode::mask;
        if (masked ? alpha.least >= material.alpha_cutoff : alpha.least >= 1) {
            material.alpha_mode = AlphaMode::opaque;
            verdicts_[index] = Verdict::opaque_after_all;
            ++opaque_materials_;
        } else if (masked ? alpha.most < material.alpha_cutoff : alpha.most <= 0) {
            verdicts_[index] = Verdict::invisible;
        }
    }

    void simplify_textures(Material& material) {
        if (TextureUse& use = material.base_color_texture; use.used()) {
            const bool is_black = material.base_color == glm::vec3(0);
            const bool is_opaque = material.alpha_mode == AlphaMode::opaque;
            const auto part = [&](const glm::u8vec4& texel) {
                return glm::u8vec4(is_black ? glm::u8vec3(0) : glm::u8vec3(texel), is_opaque ? 0 : texel.a);
            };
            if (is_constant(use, part)) {
                material.base_color *= linear(texels(use).front());
                material.alpha *= static_cast<float>(texels(use).front().a) * (1.0F / 255);
                use = {};
            }
        }
        if (TextureUse& use = material.transmission_texture; use.used()) {
            if (is_constant(use, [](const glm::u8vec4& texel) { return texel.r; })) {
                material.transmission *= static_cast<float>(texels(use).front().r) * (1.0F / 255);
                use = {};
            }
        }
        if (TextureUse& use = material.emission_texture; use.used()) {
            const auto& all = texels(use);
            if (std::all_of(all.begin(), all.end(), [&](const glm::u8vec4& texel) {
                    return material.emission * linear(texel) == glm::vec3(0);
                })) {
                material.emission = glm::vec3(0);
                use = {};
                ++black_emitters_;
            } else if (is_constant(use, [](const glm::u8vec4& texel) { return glm::u8vec3(texel); })) {
                material.emission *= linear(all.front());
                use = {};
            }
        }
    }

    void simplify_mesh(std::size_t index) {
        Mesh& mesh = scene_.meshes[index];
        const auto material_index = static_cast<std::size_t>(mesh.material);
        const Material& material = scene_.materials[material_index];
        if (verdicts_[material_index] == Verdict::invisible) {
            invisible_triangles_ += mesh.triangles.size();
            const int kept = mesh.material;
            mesh = Mesh();
            mesh.material = kept;
            return;
        }
        if (verdicts_[material_index] == Verdict::opaque_after_all) opaque_triangles_ += mesh.triangles.size();
        const bool is_black = material.base_color == glm::vec3(0);
        const bool is_opaque = material.alpha_mode == AlphaMode::opaque;
        const auto changes_nothing = [&](const glm::u16vec4& color) {
            return (is_black || glm::u16vec3(color) == glm::u16vec3(65535)) && (is_opaque || color.a == 65535);
        };
        if (!mesh.colors.empty() && std::all_of(mesh.colors.begin(), mesh.colors.end(), changes_nothing))
            add_and_clear(white_colors_, mesh.colors);
        for (std::size_t set = 0; set < mesh.uv_sets.size(); ++set) {
            const auto reads = [&](const TextureUse& use) { return use.used() && use.uv_set == static_cast<int>(set); };
            if (!mesh.uv_sets[set].empty() && !reads(material.base_color_texture) &&
                !reads(material.transmission_texture) && !reads(material.emission_texture))
                add_and_clear(uv_sets_, mesh.uv_sets[set]);
        }
    }

    static void add(Saved& saved, std::size_t bytes) {
        ++saved.count;
        saved.bytes += bytes;
    }
    template <typename T>
    static void add_and_clear(Saved& saved, std::vector<T>& list) {
        add(saved, list.size() * sizeof(T));
        std::vector<T>().swap(list);
    }

    void drop_unused_textures() {
        std::vector<int> numbers(scene_.textures.size(), -1);
        std::vector<Texture> kept;
        for (Material& material : scene_.materials)
            for (TextureUse* use :
                 {&material.base_color_texture, &material.transmission_texture, &material.emission_texture}) {
                if (!use->used()) continue;
                int& number = numbers[static_cast<std::size_t>(use->texture)];
                if (number < 0) {
                    number = static_cast<int>(kept.size());
                    kept.push_back(std::move(scene_.textures[static_cast<std::size_t>(use->texture)]));
                }
                use->texture = number;
            }
        for (const Texture& texture : scene_.textures)
            if (!texture.image.pixels.empty()) add(textures_, texture.image.pixels.size() * sizeof(glm::u8vec4));
        scene_.textures = std::move(kept);
    }

    void report() {
        const auto line = [&](bool saved, std::string what, std::string evidence, std::string gain) {
            if (saved) scene_.left_out.push_back({std::move(what), std::move(evidence), std::move(gain)});
        };
        line(opaque_materials_ > 0, "alpha tests",
             fmt::format("the least alpha of {} materials lets nothing pass", opaque_materials_),
             fmt::format("a filter at {} triangles", opaque_triangles_));
        line(invisible_triangles_ > 0, "invisible surfaces", "their greatest alpha lets everything pass",
             fmt::format("{} triangles", invisible_triangles_));
        line(black_emitters_ > 0, "emission",
             fmt::format("the textures of {} materials make it black", black_emitters_),
             "sampling of those materials as lights");
        line(textures_.count > 0, "textures", "they are of one colour, or nothing reads them",
             fmt::format("{} textures, {}", textures_.count, megabytes(textures_.bytes)));
        line(white_colors_.count > 0, "vertex colours", "white, or on a black surface",
             fmt::format("those of {} meshes, {}", white_colors_.count, megabytes(white_colors_.bytes)));
        line(uv_sets_.count > 0, "texture coordinates", "their textures are left out",
             fmt::format("{} sets, {}", uv_sets_.count, megabytes(uv_sets_.bytes)));
    }

    Scene& scene_;
    std::vector<Range> vertex_alpha_;  // by material
    std::vector<Verdict> verdicts_;    // by material
    std::size_t opaque_materials_ = 0;
    std::size_t opaque_triangles_ = 0;
    std::size_t invisible_triangles_ = 0;
    std::size_t black_emitters_ = 0;
    Saved textures_;
    Saved white_colors_;
    Saved uv_sets_;
};

}  // namespace

void simplify(Scene& scene) {
    Simplifier(scene).run();
}

}  // namespace lightgrid
