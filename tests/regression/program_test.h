#pragma once

#include "core/whole_file.h"
#include "tests/gltf_builder.h"
#include "tools/csv.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <sys/wait.h>

namespace lightgrid {

struct Result {
    int status = -1;
    std::string out;
    std::string err;
};

inline std::string first_line(const std::string& text) {
    return text.substr(0, text.find('\n'));
}

/// Runs a built program as a user or a script does, in a folder of its own.
class ProgramTest : public testing::Test {
  protected:
    /// program  its path
    explicit ProgramTest(const std::filesystem::path& program)
        : program_(program.string()), name_(program.filename().string()) {}

    [[nodiscard]] const std::filesystem::path& folder() const { return folder_.path(); }
    void write(const std::string& name, const std::string& text) const { write_bytes(folder() / name, text); }

    /// A line of shell, run in the folder with nothing on standard input.
    [[nodiscard]] Result shell(const std::string& command) const {
        const TemporaryFolder streams;
        const std::string line = fmt::format("cd '{}' && {{ {}\n}} >{}/out 2>{}/err </dev/null", folder().string(),
                                             command, streams.path().string(), streams.path().string());
        const int raw = std::system(line.c_str());
        return {WIFEXITED(raw) ? WEXITSTATUS(raw) : -1, read_whole_file(streams.path() / "out"),
                read_whole_file(streams.path() / "err")};
    }
    [[nodiscard]] Result run(const std::string& arguments) const { return shell(program_ + " " + arguments); }

    /// The call is wrong: status 2, nothing on standard output, one line that says what on standard error.
    void expect_refused(const std::string& arguments, const std::string& message) const {
        const Result result = run(arguments);
        EXPECT_EQ(result.status, 2) << arguments;
        EXPECT_EQ(result.out, "") << arguments;
        EXPECT_EQ(result.err.rfind(name_ + ": ", 0), 0U) << result.err;
        EXPECT_NE(result.err.find(message), std::string::npos)
            << arguments << "\nsaid:   " << result.err << "wanted: " << message;
    }

    [[nodiscard]] CsvTable csv(const std::string& arguments) const {
        const Result result = run(arguments);
        EXPECT_EQ(result.status, 0) << result.err;
        EXPECT_EQ(result.err, "");
        return {result.out, "standard output"};
    }

    [[nodiscard]] nlohmann::json json(const std::string& arguments) const {
        const Result result = run(arguments);
        EXPECT_EQ(result.status, 0) << result.err;
        return nlohmann::json::parse(result.out);
    }

  private:
    TemporaryFolder folder_;
    std::string program_;
    std::string name_;
};

}  // namespace lightgrid
