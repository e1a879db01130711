#pragma once

#include "core/image.h"
#include "viewer/gl_objects.h"
#include "viewer/settings.h"
#include "viewer/shader.h"

#include <glm/glm.hpp>

namespace lightgrid {

/// A rectangle of a picture, pixels from its lower left corner, as OpenGL counts.
struct Rectangle {
    glm::ivec2 corner{0};
    glm::ivec2 size{0};
};

/// What is drawn into: linear light (half floats, times exposure) and depth, several samples a pixel where asked for;
/// and the picture that a display shows of it.
class PictureTarget {
  public:
    PictureTarget(const Gl& gl, const ShaderSources& shaders);

    /// size     pixels, at least 1 x 1
    /// samples  a pixel: 1, or as many of 4 as the driver has
    void resize(glm::ivec2 size, int samples);
    [[nodiscard]] glm::ivec2 size() const noexcept { return size_; }

    /// Binds and clears it.
    void begin() const;
    /// The mean over the samples of each pixel, if there are several: before `develop` and `read_light`.
    void resolve() const;
    /// Tone-maps a part of the light into the same part of the picture.
    void develop(const Rectangle& part, Tone tone) const;

    /// Copies the picture to the window's own framebuffer.
    ///
    /// corner  of the window that its lower left corner comes to
    void show(glm::ivec2 corner = {0, 0}) const;
    /// Its texture.
    [[nodiscard]] GLuint picture() const noexcept { return picture_.color.name(); }
    [[nodiscard]] ByteImage read_picture() const;
    /// The light of a pixel is what was drawn, divided by `exposure`: cd/m^2.
    [[nodiscard]] RadianceImage read_light(float exposure) const;

  private:
    struct Layer {
        GlTexture color;
        GlTexture depth;
        Framebuffer framebuffer;
    };
    [[nodiscard]] Layer make_layer(GLenum format, int samples, bool with_depth) const;

    const Gl& gl_;
    Program develop_program_;
    VertexArray vertex_array_;
    glm::ivec2 size_{0};
    int samples_ = 0;
    Layer drawn_;  // several samples; empty where there is one
    Layer light_;
    Layer picture_;
};

}  // namespace lightgrid
