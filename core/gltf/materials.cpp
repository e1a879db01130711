#include "core/gltf/materials.h"

#include "core/error.h"
#include "core/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

namespace lightgrid::gltf {
namespace {

struct TextureKey {
    int image = -1;  // -1: there is none to read
    Wrap wrap_u = Wrap::repeat;
    Wrap wrap_v = Wrap::repeat;
    bool nearest = false;
    int broken = -1;  // index of the texture that names no image

    bool operator<(const TextureKey& other) const {
        return std::tie(image, wrap_u, wrap_v, nearest, broken) <
               std::tie(other.image, other.wrap_u, other.wrap_v, other.nearest, other.broken);
    }
};

Wrap wrap_of(int mode) {
    if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::clamp;
    return mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::mirror : Wrap::repeat;
}

int image_of(const Document& document, int index) {
    const tinygltf::Texture& texture = document.texture(index);
    if (const tinygltf::Value* webp = find_extension(texture.extensions, "EXT_texture_webp");
        webp && webp->Has("source"))
        return webp->Get("source").GetNumberAsInt();
    if (texture.source >= 0) return texture.source;
    const std::string where = name_of("texture", static_cast<std::size_t>(index), texture.name);
    for (const auto& [kind, extension] :
         {std::pair{"KTX2", "KHR_texture_basisu"}, {"DDS", "MSFT_texture_dds"}, {"AVIF", "EXT_texture_avif"}})
        if (find_extension(texture.extensions, extension) != nullptr)
            throw Error(fmt::format("is {} ({}), which cannot be read", kind, extension), where,
                        "Convert it to PNG, JPEG or WebP.");
    throw Error("has no image", where, "Give it one, or remove it from the material.");
}

TextureKey key_of(const Document& document, int index) {
    TextureKey key;
    key.image = image_of(document, index);
    if (const int sampler = document.texture(index).sampler; sampler >= 0) {
        const tinygltf::Sampler& source = document.sampler(sampler);
        key.wrap_u = wrap_of(source.wrapS);
        key.wrap_v = wrap_of(source.wrapT);
        key.nearest = source.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    }
    return key;
}

/// uv' = offset + rotation (scale uv): KHR_texture_transform. The rotation is counter-clockwise for a viewer who sees v
/// grow downwards, as TextureTransformTest of the glTF sample models has it.
glm::mat3x2 transform_of(const tinygltf::Value& transform) {
    const auto number = [&](const char* name, int i, double fallback) {
        return transform.Has(name) ? transform.Get(name).Get(i).GetNumberAsDouble() : fallback;
    };
    const double angle = number_in(transform, "rotation", 0);
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const glm::dvec2 scale(number("scale", 0, 1), number("scale", 1, 1));
    return glm::mat3x2(glm::dmat3x2(c * scale.x, -s * scale.x, s * scale.y, c * scale.y, number("offset", 0, 0),
                                    number("offset", 1, 0)));
}

double strength_of(const tinygltf::Material& source) {
    const tinygltf::Value* extension = find_extension(source.extensions, "KHR_materials_emissive_strength");
    return extension == nullptr ? 1 : number_in(*extension, "emissiveStrength", 1);
}

class MaterialReader {
  public:
    MaterialReader(const Document& document, Notices& notices) : document_(document), notices_(notices) {}

    Material read(int index) {
        const tinygltf::Material& source = document_.material(index);
        place_ = name_of("material", static_cast<std::size_t>(index), source.name);
        try {
            return read(source);
        } catch (const Error& error) {
            throw error.inside(place_);
        }
    }

    /// What the materials read so far look up, by TextureUse::texture.
    [[nodiscard]] const std::vector<TextureKey>& textures() const { return textures_; }
    /// Of those that name no image that could be read.
    [[nodiscard]] const std::map<int, Error>& broken() const { return broken_; }

  private:
    Material read(const tinygltf::Material& source) {
        Material material;
        material.name = source.name;
        material.double_sided = source.doubleSided;
        read_alpha_mode(source, material);
        read_base_color(source, material);
        read_transmission(source, material);
        check_diffuse_transmission(source);
        read_emission(source, material);
        if (find_extension(source.extensions, "KHR_materials_unlit") != nullptr)
            notices_.add(place_, "KHR_materials_unlit is not followed: it is lit like any other surface");
        return material;
    }

    void read_base_color(const tinygltf::Material& source, Material& material) {
        const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
        const bool names_color = source.values.contains("baseColorFactor") || pbr.baseColorTexture.index >= 0;
        const tinygltf::Value* old = find_extension(source.extensions, "KHR_materials_pbrSpecularGlossiness");
        const bool is_old = old != nullptr && !names_color;
        glm::dvec4 factor(1);
        for (int i = 0; i < 4; ++i) {
            if (!is_old)
                factor[i] = pbr.baseColorFactor[static_cast<std::size_t>(i)];
            else if (old->Has("diffuseFactor"))
                factor[i] = old->Get("diffuseFactor").Get(i).GetNumberAsDouble();
        }
        const glm::dvec4 clamped = glm::clamp(factor, 0.0, 1.0);
        if (clamped != factor) notices_.add(place_, "its base colour is outside [0, 1] and is clamped to it");
        material.base_color = glm::vec3(clamped);
        material.alpha = static_cast<float>(clamped.a);
        // Of black, no texture makes anything else.
        if (material.base_color == glm::vec3(0) && material.alpha_mode == AlphaMode::opaque) return;
        if (!is_old)
            material.base_color_texture = use(pbr.baseColorTexture);
        else if (old->Has("diffuseTexture"))
            material.base_color_texture = use(old->Get("diffuseTexture"));
    }

    void read_alpha_mode(const tinygltf::Material& source, Material& material) {
        if (source.alphaMode == "MASK") material.alpha_mode = AlphaMode::mask;
        if (source.alphaMode == "BLEND") material.alpha_mode = AlphaMode::blend;
        material.alpha_cutoff = static_cast<float>(source.alphaCutoff);
        if (material.alpha_mode == AlphaMode::mask && source.alphaCutoff < 0)
            notices_.add(place_, "its alphaCutoff is below 0: nothing of it is cut off");
    }

    void read_transmission(const tinygltf::Material& source, Material& material) {
        const tinygltf::Value* transmission = find_extension(source.extensions, "KHR_materials_transmission");
        if (transmission == nullptr) return;
        const double factor = number_in(*transmission, "transmissionFactor", 0);
        material.transmission = static_cast<float>(std::clamp(factor, 0.0, 1.0));
        if (factor != std::clamp(factor, 0.0, 1.0))
            notices_.add(place_, "its transmissionFactor is outside [0, 1] and is clamped to it");
        if (material.transmission == 0) return;
        if (transmission->Has("transmissionTexture"))
            material.transmission_texture = use(transmission->Get("transmissionTexture"));
        if (const tinygltf::Value* volume = find_extension(source.extensions, "KHR_materials_volume");
            volume != nullptr && number_in(*volume, "thicknessFactor", 0) > 0)
            notices_.add(place_, "KHR_materials_volume is not followed: nothing is absorbed inside of it");
    }

    /// No path, cache or kept transport lets light through a surface diffusely: it is said what that leaves out.
    void check_diffuse_transmission(const tinygltf::Material& source) {
        const char* const name = "KHR_materials_diffuse_transmission";
        const tinygltf::Value* transmission = find_extension(source.extensions, name);
        if (transmission == nullptr) return;
        const double factor = number_in(*transmission, "diffuseTransmissionFactor", 0);
        double brightest = transmission->Has("diffuseTransmissionColorFactor") ? 0 : 1;
        for (int i = 0; i < 3 && brightest < 1; ++i)
            brightest =
                std::max(brightest, transmission->Get("diffuseTransmissionColorFactor").Get(i).GetNumberAsDouble());
        if (factor == 0) return;
        const std::string problem = fmt::format(
            "{} is not followed: behind it, up to {:.3g} % of the light that meets it is missing; before "
            "it, up to {:.3g} % of what it reflects is too much",
            name, 100 * factor * std::min(brightest, 1.0), 100 * factor);
        if (document_.requires_extension(name))
            throw Error(
                problem + ", and the file requires it", "",
                "Export the level without it, or take KHR_materials_transmission, which lets light straight on.");
        notices_.add(place_, problem);
    }

    void read_emission(const tinygltf::Material& source, Material& material) {
        const double strength = strength_of(source);
        for (int i = 0; i < 3; ++i) {
            const double factor = source.emissiveFactor[static_cast<std::size_t>(i)];
            if (factor < 0) notices_.add(place_, "its emissiveFactor is negative and is clamped to 0");
            if (factor > 1)
                notices_.add(place_, "its emissiveFactor is above 1, which glTF forbids; it is taken as it is");
            material.emission[i] = static_cast<float>(std::max(factor, 0.0) * strength);
            if (!std::isfinite(material.emission[i]))
                throw Error(fmt::format("emits {:g} x {:g} cd/m^2", factor, strength), "",
                            "Lower its emissiveStrength.");
        }
        if (material.emits()) material.emission_texture = use(source.emissiveTexture);
    }

    TextureUse use(const tinygltf::TextureInfo& info) {
        return info.index < 0
                   ? TextureUse{}
                   : use(info.index, info.texCoord, find_extension(info.extensions, "KHR_texture_transform"));
    }
    /// The same as tinygltf leaves it within extensions.
    TextureUse use(const tinygltf::Value& info) {
        const tinygltf::Value& extensions = info.Get("extensions");
        const bool transformed = extensions.Has("KHR_texture_transform");
        return use(info.Get("index").GetNumberAsInt(), static_cast<int>(number_in(info, "texCoord", 0)),
                   transformed ? &extensions.Get("KHR_texture_transform") : nullptr);
    }
    TextureUse use(int texture, int uv_set, const tinygltf::Value* transform) {
        TextureUse result;
        TextureKey key;
        std::optional<Error> problem;
        try {
            key = key_of(document_, texture);
        } catch (const Error& error) {
            key = {};  // GCC 12 writes what the function returns right into it, also where it throws
            key.broken = texture;
            problem = error;
        }
        const auto [known, added] = indices_.emplace(key, static_cast<int>(textures_.size()));
        if (added) textures_.push_back(key);
        if (problem) broken_.emplace(known->second, *problem);
        result.texture = known->second;
        result.uv_set = uv_set;
        if (transform != nullptr) {
            result.uv_set = static_cast<int>(number_in(*transform, "texCoord", uv_set));
            result.transform = transform_of(*transform);
        }
        return result;
    }

    const Document& document_;
    Notices& notices_;
    std::string place_;
    std::vector<TextureKey> textures_;
    std::map<TextureKey, int> indices_;
    std::map<int, Error> broken_;
};

/// What is left of a material without a texture that is missing.
void leave_out_texture(Material& material, const TextureUse& use) {
    if (&use == &material.emission_texture) material.emission = glm::vec3(0);
    if (&use == &material.base_color_texture) material.alpha_mode = AlphaMode::opaque;
}

std::array<TextureUse*, 3> texture_uses(Material& material) {
    return {&material.base_color_texture, &material.transmission_texture, &material.emission_texture};
}

/// The first problem of each image, whatever samplers its textures have.
std::map<std::string, const Error*> by_image(const std::map<int, Error>& problems) {
    std::map<std::string, const Error*> found;
    for (const auto& [texture, problem] : problems) found.emplace(problem.where(), &problem);
    return found;
}

/// All that are missing, the first with what is wrong with it.
Error refusal_of(const std::map<int, Error>& problems) {
    constexpr std::size_t most_named = 5;
    const std::map<std::string, const Error*> images = by_image(problems);
    const Error& first = *images.begin()->second;
    if (images.size() == 1) return first;
    std::vector<std::string> others;
    for (auto image = std::next(images.begin()); image != images.end() && others.size() < most_named; ++image)
        others.push_back(image->first);
    if (images.size() - 1 > others.size()) others.push_back(fmt::format("{} more", images.size() - 1 - others.size()));
    return Error(fmt::format("{}; also missing: {}", first.problem(), fmt::join(others, ", ")), first.where(),
                 "Put the files there, or take --missing-textures warn.");
}

/// Takes the missing ones out of scene.textures and of the materials that read them.
///
/// problems  by index in scene.textures
void leave_out_missing(const std::map<int, Error>& problems, const LoadedMaterials& loaded, Scene& scene,
                       Notices& notices) {
    constexpr std::array what = {"its base colour is the factor, opaque", "it transmits by the factor alone",
                                 "it emits nothing"};
    struct Effect {
        std::string on;  // the first material
        std::size_t more = 0;
    };
    std::map<std::string, std::array<Effect, what.size()>> effects;  // by image
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
        const std::array<TextureUse*, what.size()> uses = texture_uses(scene.materials[m]);
        for (std::size_t i = 0; i < uses.size(); ++i) {
            const auto problem = problems.find(uses[i]->texture);
            if (problem == problems.end()) continue;
            Effect& effect = effects[problem->second.where()][i];
            if (effect.on.empty())
                effect.on = loaded.names[m];
            else
                ++effect.more;
            leave_out_texture(scene.materials[m], *uses[i]);
            *uses[i] = {};
        }
    }
    for (const auto& [image, problem] : by_image(problems)) {
        scene.missing_textures.push_back(image);
        std::string text = fmt::format("missing texture: {}: {}", image, problem->problem());
        for (std::size_t i = 0; i < what.size(); ++i) {
            const Effect& effect = effects[image][i];
            if (effect.on.empty()) continue;
            const std::string more = effect.more > 0 ? fmt::format(" and {} more", effect.more) : "";
            text += fmt::format("; {}{}: {}", effect.on, more, what[i]);
        }
        notices.add("", text);
    }

    std::vector<int> indices(scene.textures.size(), -1);
    std::vector<Texture> kept;
    for (std::size_t i = 0; i < scene.textures.size(); ++i) {
        if (problems.contains(static_cast<int>(i))) continue;
        indices[i] = static_cast<int>(kept.size());
        kept.push_back(std::move(scene.textures[i]));
    }
    scene.textures = std::move(kept);
    for (Material& material : scene.materials)
        for (TextureUse* use : texture_uses(material))
            if (use->used()) use->texture = indices[static_cast<std::size_t>(use->texture)];
}

/// problems  added to: of images that cannot be read, by index in the result
std::vector<Texture> decode_textures(const Document& document, const std::vector<TextureKey>& keys,
                                     std::map<int, Error>& problems) {
    std::map<int, std::vector<std::size_t>> uses;  // of each image
    for (std::size_t i = 0; i < keys.size(); ++i)
        if (keys[i].image >= 0) uses[keys[i].image].push_back(i);
    const std::vector<std::pair<int, std::vector<std::size_t>>> images(uses.begin(), uses.end());

    std::vector<Texture> textures(keys.size());
    std::vector<std::optional<Error>> failed(images.size());
    for_each_index(images.size(), [&](std::size_t i) {
        const auto& [image, users] = images[i];
        ByteImage decoded;
        try {
            decoded = document.image(image);
        } catch (const Error& error) {
            failed[i] = error;
            return;
        }
        for (const std::size_t user : users) {
            textures[user].wrap_u = keys[user].wrap_u;
            textures[user].wrap_v = keys[user].wrap_v;
            textures[user].nearest = keys[user].nearest;
            if (user != users.front()) textures[user].image = decoded;
        }
        textures[users.front()].image = std::move(decoded);
    });
    for (std::size_t i = 0; i < images.size(); ++i)
        if (failed[i])
            for (const std::size_t user : images[i].second) problems.emplace(static_cast<int>(user), *failed[i]);
    return textures;
}

}  // namespace

bool material_emits(const Document& document, int material) {
    if (material < 0) return false;
    const tinygltf::Material& source = document.material(material);
    return strength_of(source) > 0 && std::any_of(source.emissiveFactor.begin(), source.emissiveFactor.end(),
                                                  [](double factor) { return factor > 0; });
}

MaterialUse material_use(const Document& document, int material, int group) {
    return {material, group >= 0 && material_emits(document, material) ? group : -1};
}

LoadedMaterials load_materials(const Document& document, const std::set<MaterialUse>& used, const LoadOptions& options,
                               Scene& scene, Notices& notices) {
    MaterialReader reader(document, notices);
    LoadedMaterials loaded;
    std::map<int, Material> read;  // by index in the file
    for (const MaterialUse& use : used) {
        if (use.material >= 0 && !read.contains(use.material)) read.emplace(use.material, reader.read(use.material));
        loaded.indices[use] = static_cast<int>(scene.materials.size());
        scene.materials.push_back(use.material < 0 ? Material() : read.at(use.material));
        Material& material = scene.materials.back();
        material.group = use.group;
        loaded.names.push_back(use.material < 0
                                   ? "no material"
                                   : name_of("material", static_cast<std::size_t>(use.material), material.name));
    }
    if (scene.materials.empty()) {
        scene.materials.emplace_back();
        loaded.names.emplace_back("no material");
    }
    const bool has_material = std::any_of(used.begin(), used.end(), [](MaterialUse use) { return use.material >= 0; });
    if (!used.empty() && !has_material) {
        for (Material& material : scene.materials) material.base_color = glm::vec3(options.default_albedo);
        notices.add("", fmt::format("no primitive has a material: albedo {:g} is taken (--default-albedo)",
                                    options.default_albedo));
    }
    std::map<int, Error> problems = reader.broken();
    scene.textures = decode_textures(document, reader.textures(), problems);
    if (problems.empty()) return loaded;
    if (options.missing_textures == MissingTextures::error) throw refusal_of(problems);
    leave_out_missing(problems, loaded, scene, notices);
    return loaded;
}

}  // namespace lightgrid::gltf
