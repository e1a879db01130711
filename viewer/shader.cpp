#include "viewer/shader.h"

#include "core/error.h"
#include "core/whole_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <regex>
#include <sstream>
#include <utility>

namespace lightgrid {
namespace {

/// The `name` of a line `#include "name"`; empty for any other line.
std::string included_name(const std::string& line) {
    static const std::regex include(R"re(\s*#\s*include\s+"([^"]+)"\s*)re");
    std::smatch match;
    return std::regex_match(line, match, include) ? match[1].str() : std::string();
}

/// #endif, #else and #elif.
bool ends_part(const std::string& line) {
    static const std::regex end(R"(\s*#\s*(endif|else|elif)\b.*)");
    return std::regex_match(line, end);
}

void append(const ShaderSources& sources, const std::string& name, ExpandedShader& out) {
    const int number = static_cast<int>(out.files.size());
    out.files.push_back(name);
    std::istringstream lines(sources.at(name));
    if (number > 0) out.text += fmt::format("#line {}\n", lines_per_file * number + 1);
    std::string line;
    for (int at = 1; std::getline(lines, line); ++at) {
        const std::string included = included_name(line);
        if (included.empty()) {
            out.text += line + "\n";
            // An include that is skipped takes its directives with it.
            if (ends_part(line)) out.text += fmt::format("#line {}\n", lines_per_file * number + at + 1);
            continue;
        }
        if (!sources.contains(included)) {
            throw Error(fmt::format("includes \"{}\", which is not there", included), fmt::format("{}:{}", name, at));
        }
        if (std::find(out.files.begin(), out.files.end(), included) == out.files.end()) {
            append(sources, included, out);
        }
        out.text += fmt::format("#line {}\n", lines_per_file * number + at + 1);
    }
}

/// Behind the first line, which says the version.
void define(ExpandedShader& shader, std::span<const std::string> names) {
    if (names.empty()) return;
    std::string lines;
    for (const std::string& name : names) lines += fmt::format("#define {}\n", name);
    shader.text.insert(shader.text.find('\n') + 1, lines + "#line 2\n");
}

Shader compile(const Gl& gl, const ShaderSources& sources, GLenum kind, const std::string& name,
               std::span<const std::string> defines) {
    if (!sources.contains(name)) throw Error("there is no such shader", name, {}, Fault::work);
    ExpandedShader expanded = expand_includes(sources, name);
    define(expanded, defines);
    Shader shader(gl, gl.CreateShader(kind));
    const char* text = expanded.text.c_str();
    gl.ShaderSource(shader.name(), 1, &text, nullptr);
    gl.CompileShader(shader.name());
    GLint compiled = GL_FALSE;
    gl.GetShaderiv(shader.name(), GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_TRUE) return shader;

    GLint length = 0;
    gl.GetShaderiv(shader.name(), GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
    gl.GetShaderInfoLog(shader.name(), length, nullptr, log.data());
    log.erase(std::find(log.begin(), log.end(), '\0'), log.end());
    throw Error("does not compile:\n" + name_places(log, expanded.files), "shader " + name);
}

}  // namespace

ShaderSources read_shaders(const std::filesystem::path& folder) {
    ShaderSources sources = built_in_shaders();
    bool found = false;
    for (auto& [name, text] : sources) {
        if (!std::filesystem::exists(folder / name)) continue;
        text = read_whole_file(folder / name);
        found = true;
    }
    if (!found) {
        throw Error("holds none of the viewer's shaders", folder.string(), "Copy those to change from viewer/shaders");
    }
    return sources;
}

ExpandedShader expand_includes(const ShaderSources& sources, const std::string& name) {
    ExpandedShader expanded;
    append(sources, name, expanded);
    return expanded;
}

std::string name_places(const std::string& log, const std::vector<std::string>& files) {
    // At the start of a line: an optional word, a number that is always 0, a separator, the number of the line, and what
    // closes it (with Mesa's column).
    static const std::regex place(R"(^(?:(?:ERROR|WARNING):\s*)?\d+[:(](\d{1,9})\)?(?:\(\d+\))?\s*:\s*)");
    std::string named;
    std::istringstream lines(log);
    std::string line;
    while (std::getline(lines, line)) {
        std::smatch match;
        const bool found = std::regex_search(line, match, place);
        const int at = found ? std::stoi(match[1]) : 0;
        const auto file = static_cast<std::size_t>(at / lines_per_file);
        if (found && file < files.size()) {
            line = fmt::format("{}:{}: {}", files[file], at % lines_per_file, match.suffix().str());
        }
        named += (named.empty() ? "" : "\n") + line;
    }
    return named;
}

Program compile_program(const Gl& gl, const ShaderSources& sources, const std::string& vertex,
                        const std::string& fragment, std::span<const std::string> defines) {
    const Shader vertex_shader = compile(gl, sources, GL_VERTEX_SHADER, vertex, defines);
    const Shader fragment_shader = compile(gl, sources, GL_FRAGMENT_SHADER, fragment, defines);
    Program program(gl, gl.CreateProgram());
    gl.AttachShader(program.name(), vertex_shader.name());
    gl.AttachShader(program.name(), fragment_shader.name());
    // A second output, where a shader has one, is what the picture behind is multiplied by.
    gl.BindFragDataLocationIndexed(program.name(), 0, 0, "color");
    gl.BindFragDataLocationIndexed(program.name(), 0, 1, "passes");
    gl.LinkProgram(program.name());
    GLint linked = GL_FALSE;
    gl.GetProgramiv(program.name(), GL_LINK_STATUS, &linked);
    if (linked == GL_TRUE) return program;

    GLint length = 0;
    gl.GetProgramiv(program.name(), GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
    gl.GetProgramInfoLog(program.name(), length, nullptr, log.data());
    log.erase(std::find(log.begin(), log.end(), '\0'), log.end());
    throw Error("do not link:\n" + log, fmt::format("shaders {} and {}", vertex, fragment));
}

ShaderVariants::ShaderVariants(const Gl& gl, ShaderSources sources, std::string vertex, std::string fragment)
    : gl_(gl), sources_(std::move(sources)), vertex_(std::move(vertex)), fragment_(std::move(fragment)) {}

const Program& ShaderVariants::with(const std::vector<std::string>& defines) {
    auto known = programs_.find(defines);
    if (known == programs_.end()) {
        known = programs_.emplace(defines, compile_program(gl_, sources_, vertex_, fragment_, defines)).first;
    }
    return known->second;
}

}  // namespace lightgrid
