#pragma once

#include "core/scene.h"
#include "viewer/gl_objects.h"

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace lightgrid {

enum class Encoding : std::uint8_t { srgb, linear };

/// The textures of a scene or an object on the card, with mipmaps, each as often as it is read differently.
class MaterialTextures {
  public:
    /// where  what messages call the file
    MaterialTextures(const Gl& gl, std::string where);

    /// Uploads a texture where it is not there yet; white where `use` names none. Throws Error where the card cannot
    /// hold it.
    [[nodiscard]] GLuint use(const std::vector<Texture>& textures, const TextureUse& use, Encoding encoding);

  private:
    const Gl& gl_;
    std::string where_;
    GlTexture white_;
    std::map<std::pair<int, Encoding>, GlTexture> uploaded_;
};

}  // namespace lightgrid
