#pragma once

#include <GL/glcorearb.h>

#include <functional>
#include <string>

/// OpenGL 3.3 core. Functions are loaded in one place, into a table that is passed on: nothing here is global.
namespace lightgrid {

/// Everything that the viewer calls; X(type, name) for glName.
#define LIGHTGRID_GL_FUNCTIONS(X)                                        \
    X(PFNGLACTIVETEXTUREPROC, ActiveTexture)                             \
    X(PFNGLATTACHSHADERPROC, AttachShader)                               \
    X(PFNGLBINDBUFFERPROC, BindBuffer)                                   \
    X(PFNGLBINDFRAGDATALOCATIONINDEXEDPROC, BindFragDataLocationIndexed) \
    X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                         \
    X(PFNGLBINDTEXTUREPROC, BindTexture)                                 \
    X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                         \
    X(PFNGLBLENDFUNCPROC, BlendFunc)                                     \
    X(PFNGLBLITFRAMEBUFFERPROC, BlitFramebuffer)                         \
    X(PFNGLBUFFERDATAPROC, BufferData)                                   \
    X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus)           \
    X(PFNGLCLEARPROC, Clear)                                             \
    X(PFNGLCLEARCOLORPROC, ClearColor)                                   \
    X(PFNGLCOMPILESHADERPROC, CompileShader)                             \
    X(PFNGLCREATEPROGRAMPROC, CreateProgram)                             \
    X(PFNGLCREATESHADERPROC, CreateShader)                               \
    X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                             \
    X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                   \
    X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                             \
    X(PFNGLDELETESHADERPROC, DeleteShader)                               \
    X(PFNGLDELETETEXTURESPROC, DeleteTextures)                           \
    X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                   \
    X(PFNGLDEPTHFUNCPROC, DepthFunc)                                     \
    X(PFNGLDEPTHMASKPROC, DepthMask)                                     \
    X(PFNGLDISABLEPROC, Disable)                                         \
    X(PFNGLDRAWARRAYSPROC, DrawArrays)                                   \
    X(PFNGLDRAWARRAYSINSTANCEDPROC, DrawArraysInstanced)                 \
    X(PFNGLDRAWELEMENTSPROC, DrawElements)                               \
    X(PFNGLDRAWELEMENTSINSTANCEDPROC, DrawElementsInstanced)             \
    X(PFNGLENABLEPROC, Enable)                                           \
    X(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray)         \
    X(PFNGLFRAMEBUFFERTEXTURE2DPROC, FramebufferTexture2D)               \
    X(PFNGLFRONTFACEPROC, FrontFace)                                     \
    X(PFNGLGENBUFFERSPROC, GenBuffers)                                   \
    X(PFNGLGENERATEMIPMAPPROC, GenerateMipmap)                           \
    X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)                         \
    X(PFNGLGENTEXTURESPROC, GenTextures)                                 \
    X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                         \
    X(PFNGLGETERRORPROC, GetError)                                       \
    X(PFNGLGETINTEGERVPROC, GetIntegerv)                                 \
    X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                     \
    X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                               \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                       \
    X(PFNGLGETSHADERIVPROC, GetShaderiv)                                 \
    X(PFNGLGETSTRINGPROC, GetString)                                     \
    X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                   \
    X(PFNGLLINKPROGRAMPROC, LinkProgram)                                 \
    X(PFNGLPIXELSTOREIPROC, PixelStorei)                                 \
    X(PFNGLREADPIXELSPROC, ReadPixels)                                   \
    X(PFNGLSHADERSOURCEPROC, ShaderSource)                               \
    X(PFNGLTEXBUFFERPROC, TexBuffer)                                     \
    X(PFNGLTEXIMAGE2DPROC, TexImage2D)                                   \
    X(PFNGLTEXIMAGE2DMULTISAMPLEPROC, TexImage2DMultisample)             \
    X(PFNGLTEXIMAGE3DPROC, TexImage3D)                                   \
    X(PFNGLTEXPARAMETERIPROC, TexParameteri)                             \
    X(PFNGLUNIFORM1FPROC, Uniform1f)                                     \
    X(PFNGLUNIFORM1IPROC, Uniform1i)                                     \
    X(PFNGLUNIFORM3FVPROC, Uniform3fv)                                   \
    X(PFNGLUNIFORM4FVPROC, Uniform4fv)                                   \
    X(PFNGLUNIFORMMATRIX3FVPROC, UniformMatrix3fv)                       \
    X(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv)                       \
    X(PFNGLUSEPROGRAMPROC, UseProgram)                                   \
    X(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer)                 \
    X(PFNGLVIEWPORTPROC, Viewport)

struct Gl {
#define LIGHTGRID_GL_MEMBER(type, name) type name = nullptr;
    LIGHTGRID_GL_FUNCTIONS(LIGHTGRID_GL_MEMBER)
#undef LIGHTGRID_GL_MEMBER
};

/// Finds a function by its full name ("glClear") in the current context; null where there is none.
using FindGlFunction = std::function<void*(const char* name)>;

/// Loads all functions of the current context. Throws Error (Fault::input) that names every one that is missing: the
/// driver has no OpenGL 3.3.
[[nodiscard]] Gl load_gl(const FindGlFunction& find);

/// Throws Error (Fault::work) if OpenGL has recorded an error since the last look.
///
/// doing  what was done, for the message: "drawing the level"
void check_gl(const Gl& gl, const std::string& doing);

/// The processor draws: every pixel costs.
[[nodiscard]] bool is_software(const Gl& gl);

/// Version and device, as the driver names them: for messages.
[[nodiscard]] std::string describe_gl(const Gl& gl);

}  // namespace lightgrid
