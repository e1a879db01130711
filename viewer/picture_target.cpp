#include "viewer/picture_target.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace lightgrid {

static_assert(static_cast<int>(Tone::film) == 0 && static_cast<int>(Tone::reinhard) == 1, "as develop.frag has them");

PictureTarget::PictureTarget(const Gl& gl, const ShaderSources& shaders)
    : gl_(gl),
      develop_program_(compile_program(gl, shaders, "develop.vert", "develop.frag")),
      vertex_array_(make_vertex_array(gl)) {}

PictureTarget::Layer PictureTarget::make_layer(GLenum format, int samples, bool with_depth) const {
    const GLenum target = samples > 1 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D;
    const auto texture = [&](GLenum internal, GLenum channels, GLenum type) {
        GlTexture result = make_texture(gl_);
        gl_.BindTexture(target, result.name());
        if (samples > 1) {
            gl_.TexImage2DMultisample(target, samples, internal, size_.x, size_.y, GL_TRUE);
        } else {
            gl_.TexImage2D(target, 0, static_cast<GLint>(internal), size_.x, size_.y, 0, channels, type, nullptr);
            gl_.TexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
            gl_.TexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        }
        return result;
    };
    Layer layer;
    layer.color = texture(format, GL_RGBA, GL_FLOAT);
    layer.framebuffer = make_framebuffer(gl_);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, layer.framebuffer.name());
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, target, layer.color.name(), 0);
    if (with_depth) {
        layer.depth = texture(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT);
        gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, target, layer.depth.name(), 0);
    }
    if (const GLenum status = gl_.CheckFramebufferStatus(GL_FRAMEBUFFER); status != GL_FRAMEBUFFER_COMPLETE) {
        throw Error(fmt::format("refuses a picture of {} x {} pixels (status {:#x})", size_.x, size_.y, status),
                    "OpenGL", "Ask for a smaller one", Fault::work);
    }
    return layer;
}

void PictureTarget::resize(glm::ivec2 size, int samples) {
    GLint most_pixels = 0;
    GLint most_samples = 1;
    gl_.GetIntegerv(GL_MAX_TEXTURE_SIZE, &most_pixels);
    gl_.GetIntegerv(GL_MAX_SAMPLES, &most_samples);
    samples = std::clamp(samples, 1, std::max(most_samples, 1));
    if (size == size_ && samples == samples_) return;
    if (size.x < 1 || size.y < 1 || size.x > most_pixels || size.y > most_pixels) {
        throw Error(fmt::format("{} x {} pixels are none or too many: up to {} each way", size.x, size.y, most_pixels),
                    "picture");
    }
    size_ = size;
    samples_ = samples;
    drawn_ = samples > 1 ? make_layer(GL_RGBA16F, samples, true) : Layer{};
    light_ = make_layer(GL_RGBA16F, 1, samples == 1);
    picture_ = make_layer(GL_RGBA8, 1, false);
}

void PictureTarget::begin() const {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, samples_ > 1 ? drawn_.framebuffer.name() : light_.framebuffer.name());
    gl_.Viewport(0, 0, size_.x, size_.y);
    gl_.Enable(GL_DEPTH_TEST);
    gl_.DepthMask(GL_TRUE);
    gl_.ClearColor(0, 0, 0, 1);
    gl_.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void PictureTarget::resolve() const {
    if (samples_ == 1) return;
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, drawn_.framebuffer.name());
    gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, light_.framebuffer.name());
    gl_.BlitFramebuffer(0, 0, size_.x, size_.y, 0, 0, size_.x, size_.y, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void PictureTarget::develop(const Rectangle& part, Tone tone) const {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, picture_.framebuffer.name());
    gl_.Viewport(part.corner.x, part.corner.y, part.size.x, part.size.y);
    gl_.Disable(GL_DEPTH_TEST);
    gl_.UseProgram(develop_program_.name());
    const Uniforms uniforms(gl_, develop_program_);
    uniforms.set("light", 0);
    uniforms.set("tone", static_cast<int>(tone));
    gl_.ActiveTexture(GL_TEXTURE0);
    gl_.BindTexture(GL_TEXTURE_2D, light_.color.name());
    gl_.BindVertexArray(vertex_array_.name());
    gl_.DrawArrays(GL_TRIANGLES, 0, 3);
    gl_.BindVertexArray(0);
    gl_.Enable(GL_DEPTH_TEST);
}

void PictureTarget::show(glm::ivec2 corner) const {
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, picture_.framebuffer.name());
    gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    const glm::ivec2 end = corner + size_;
    gl_.BlitFramebuffer(0, 0, size_.x, size_.y, corner.x, corner.y, end.x, end.y, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
}

ByteImage PictureTarget::read_picture() const {
    const std::size_t width = static_cast<std::size_t>(size_.x);
    std::vector<glm::u8vec4> rows(width * static_cast<std::size_t>(size_.y));
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, picture_.framebuffer.name());
    gl_.PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl_.ReadPixels(0, 0, size_.x, size_.y, GL_RGBA, GL_UNSIGNED_BYTE, rows.data());
    ByteImage image{size_.x, size_.y, {}};
    image.pixels.reserve(rows.size());
    for (int y = size_.y - 1; y >= 0; --y) {
        const auto row = rows.begin() + static_cast<std::ptrdiff_t>(width * static_cast<std::size_t>(y));
        image.pixels.insert(image.pixels.end(), row, row + size_.x);
    }
    return image;
}

RadianceImage PictureTarget::read_light(float exposure) const {
    const std::size_t width = static_cast<std::size_t>(size_.x);
    std::vector<glm::vec3> rows(width * static_cast<std::size_t>(size_.y));
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, light_.framebuffer.name());
    gl_.PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl_.ReadPixels(0, 0, size_.x, size_.y, GL_RGB, GL_FLOAT, rows.data());
    RadianceImage image{size_.x, size_.y, {}};
    image.pixels.reserve(rows.size());
    for (int y = size_.y - 1; y >= 0; --y) {
        for (std::size_t x = 0; x < width; ++x) {
            image.pixels.push_back(rows[width * static_cast<std::size_t>(y) + x] / exposure);
        }
    }
    return image;
}

}  // namespace lightgrid
