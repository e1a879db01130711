#pragma once

#include "viewer/gl_objects.h"

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace lightgrid {

/// Texts of shaders by file name: "level.vert", "lightgrid.glsl".
using ShaderSources = std::map<std::string, std::string>;

/// What is in viewer/shaders and probes/lightgrid.glsl, built into the program.
[[nodiscard]] const ShaderSources& built_in_shaders();

/// The same, with the files of a folder in the place of those that have their name: to work on shaders without building
/// anew. Throws Error where there is no such folder, or none of its files is one of ours.
[[nodiscard]] ShaderSources read_shaders(const std::filesystem::path& folder);

/// A shader's text as the driver gets it.
struct ExpandedShader {
    std::string text;
    std::vector<std::string> files;
};

/// Line 3 of file 2 is line 20003 to the driver: Mesa loses the number that #line can give a file as such.
inline constexpr int lines_per_file = 10'000;

/// Puts in the files that lines `#include "name"` ask for, once each, with #line directives; a `#version` line stays
/// first. Throws Error naming file and line for a file that is not there.
[[nodiscard]] ExpandedShader expand_includes(const ShaderSources& sources, const std::string& name);

/// A driver's message with places as "file:line": "0:10012(5): error: ..." (Mesa, Intel), "0(10012) : error ..." (NVIDIA)
/// and "ERROR: 0:10012: ..." (AMD, Apple) all become "level.frag:12: ...".
[[nodiscard]] std::string name_places(const std::string& log, const std::vector<std::string>& files);

/// Compiles and links two of `sources`, each of `defines` defined in both. Throws Error that names file and line, with the
/// driver's words.
[[nodiscard]] Program compile_program(const Gl& gl, const ShaderSources& sources, const std::string& vertex,
                                      const std::string& fragment, std::span<const std::string> defines = {});

/// Two shaders as programs that differ in what is defined, each compiled when it is first asked for.
class ShaderVariants {
  public:
    ShaderVariants(const Gl& gl, ShaderSources sources, std::string vertex, std::string fragment);

    /// Throws as compile_program does.
    [[nodiscard]] const Program& with(const std::vector<std::string>& defines);

  private:
    const Gl& gl_;
    ShaderSources sources_;
    std::string vertex_;
    std::string fragment_;
    std::map<std::vector<std::string>, Program> programs_;
};

}  // namespace lightgrid
