#include "viewer/shader.h"

#include "core/error.h"
#include "tests/gltf_builder.h"
#include "viewer/headless.h"

#include <gtest/gtest.h>

#include <cstring>

namespace lightgrid {
namespace {

void some_function() {}

TEST(Gl, EveryMissingFunctionIsNamed) {
    const auto find = [](const char* name) -> void* {
        const bool missing = std::strcmp(name, "glTexBuffer") == 0 || std::strcmp(name, "glUseProgram") == 0;
        return missing ? nullptr : reinterpret_cast<void*>(&some_function);
    };
    try {
        static_cast<void>(load_gl(find));
        FAIL() << "nothing was thrown";
    } catch (const Error& error) {
        const std::string message = error.what();
        EXPECT_NE(message.find("has no glTexBuffer, glUseProgram"), std::string::npos) << message;
        EXPECT_NE(message.find("OpenGL 3.3"), std::string::npos) << message;
        EXPECT_EQ(error.fault(), Fault::input);
    }
}

TEST(Gl, ErrorsAreToldWithWhatWasDone) {
    const Headless surface;
    EXPECT_NO_THROW(check_gl(surface.gl(), "doing nothing"));
    surface.gl().Enable(GL_TEXTURE_BUFFER);  // is nothing that can be enabled
    try {
        check_gl(surface.gl(), "drawing the test");
        FAIL() << "nothing was thrown";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("invalid enum while drawing the test"), std::string::npos);
    }
}

TEST(Shader, IncludesAreNumberedAndPutInOnce) {
    const ShaderSources sources{{"a.frag", "#version 330 core\n#include \"b.glsl\"\n#include \"c.glsl\"\nlast\n"},
                                {"b.glsl", "#include \"c.glsl\"\nin b\n"},
                                {"c.glsl", "in c\n"}};
    const ExpandedShader expanded = expand_includes(sources, "a.frag");
    EXPECT_EQ(expanded.files, (std::vector<std::string>{"a.frag", "b.glsl", "c.glsl"}));
    EXPECT_EQ(expanded.text,
              "#version 330 core\n"
              "#line 10001\n"
              "#line 20001\nin c\n"
              "#line 10002\nin b\n"
              "#line 3\n"
              "#line 4\nlast\n");
}

TEST(Shader, IncludesThatAreSkippedCountNoLines) {
    const ShaderSources sources{
        {"a.frag",
         "#version 330 core\n#ifdef X\n#include \"b.glsl\"\n#endif\nout vec4 color;\nvoid main() { color = no; }\n"},
        {"b.glsl", "one\ntwo\nthree\n"},
        {"a.vert", "#version 330 core\nvoid main() { gl_Position = vec4(0.0); }\n"}};
    const Headless surface;
    try {
        static_cast<void>(compile_program(surface.gl(), sources, "a.vert", "a.frag"));
        FAIL() << "nothing was thrown";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("a.frag:6:"), std::string::npos) << error.what();
    }
}

TEST(Shader, VariantsDifferInWhatIsDefined) {
    const Headless surface;
    ShaderVariants variants(surface.gl(),
                            {{"a.vert", "#version 330 core\nvoid main() { gl_Position = vec4(0.0); }\n"},
                             {"a.frag",
                              "#version 330 core\nout vec4 color;\nvoid main() {\n    color = vec4(0.0);\n"
                              "#ifdef BROKEN\n    color = no;\n#endif\n}\n"}},
                            "a.vert", "a.frag");
    const GLuint plain = variants.with({}).name();
    EXPECT_EQ(variants.with({}).name(), plain);
    EXPECT_NE(variants.with({"OTHER"}).name(), plain);
    try {
        static_cast<void>(variants.with({"OTHER", "BROKEN"}));
        FAIL() << "nothing was thrown";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("a.frag:6:"), std::string::npos) << error.what();
    }
}

TEST(Shader, AnIncludeThatIsNotThereIsNamedWithItsLine) {
    const ShaderSources sources{{"a.frag", "#version 330 core\n\n  # include  \"gone.glsl\"\n"}};
    try {
        static_cast<void>(expand_includes(sources, "a.frag"));
        FAIL() << "nothing was thrown";
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).find("a.frag:3: includes \"gone.glsl\""), 0U) << error.what();
    }
}

TEST(Shader, PlacesOfAllDriversBecomeFilesAndLines) {
    const std::vector<std::string> files{"a.frag", "b.glsl"};
    EXPECT_EQ(name_places("0:10012(5): error: no", files), "b.glsl:12: error: no");
    EXPECT_EQ(name_places("0(7) : error C1503: no", files), "a.frag:7: error C1503: no");
    EXPECT_EQ(name_places("ERROR: 0:10003: 'x' : no", files), "b.glsl:3: 'x' : no");
    EXPECT_EQ(name_places("0:70003: of a file that is not there\nno place", files),
              "0:70003: of a file that is not there\nno place");
}

class BrokenShader : public testing::Test {
  protected:
    /// What the compiler says of the built-in shaders with one of them replaced.
    [[nodiscard]] std::string message(const std::string& name, const std::string& from, const std::string& to) const {
        ShaderSources sources = built_in_shaders();
        std::string& text = sources.at(name);
        const std::size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos);
        text.replace(at, from.size(), to);
        line_ = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
        try {
            static_cast<void>(compile_program(surface_.gl(), sources, "object.vert", "object.frag"));
        } catch (const Error& error) {
            return error.what();
        }
        return "compiled";
    }
    [[nodiscard]] std::string place(const std::string& name) const { return name + ":" + std::to_string(line_) + ":"; }

  private:
    Headless surface_;
    mutable std::ptrdiff_t line_ = 0;
};

TEST_F(BrokenShader, IsNamedWithFileAndLine) {
    const std::string message = this->message("object.frag", "vec3 shown =", "vec3 shown = nonsense *");
    EXPECT_NE(message.find(place("object.frag")), std::string::npos) << message;
    EXPECT_NE(message.find("nonsense"), std::string::npos) << message;
}

TEST_F(BrokenShader, IsNamedAlsoInAnInclude) {
    const std::string message = this->message("sh.glsl", "return 0.282095", "return nonsense + 0.282095");
    EXPECT_NE(message.find(place("sh.glsl")), std::string::npos) << message;
}

TEST_F(BrokenShader, ThatDoesNotLinkIsNamed) {
    const std::string message = this->message("object.vert", "out vec3 turned_normal;",
                                              "out vec4 turned_normal;\n#define turned_normal turned_normal.xyz");
    EXPECT_NE(message.find("object.vert and object.frag"), std::string::npos) << message;
}

TEST(Shader, FoldersReplaceBuiltInFilesByName) {
    const TemporaryFolder folder;
    EXPECT_THROW(static_cast<void>(read_shaders(folder.path())), Error);
    write_bytes(folder.path() / "object.frag", "mine");
    const ShaderSources sources = read_shaders(folder.path());
    EXPECT_EQ(sources.at("object.frag"), "mine");
    EXPECT_EQ(sources.at("object.vert"), built_in_shaders().at("object.vert"));
}

}  // namespace
}  // namespace lightgrid
