#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace CLI {  // NOLINT(readability-identifier-naming)
class App;
}

/// What the programs share: exit status, messages, results, command lines.
namespace lightgrid {

/// Runs a program: its results go to standard output, everything else to standard error.
///
/// body     does the work; returns the exit status
/// returns  what main should return: body's own; for Error its fault (1 the work failed, 2 the call or an input was
///          wrong) after "NAME: message" on standard error; 0 where the reader of standard output has closed it
int run_program(const std::string& name, const std::function<int()>& body);

/// Reads the command line into `app` and runs the callbacks of the verb that it names.
///
/// returns  false: help or version was asked for, and is printed; there is nothing else to do
/// Throws Error that lists everything wrong with it, and suggests what an unknown option may have meant.
bool parse_command_line(CLI::App& app, int argc, const char* const* argv);

/// Results, to standard output. Throws what run_program understands if that is closed or full.
void print(std::string_view text);

/// "NAME: warning: message" on standard error.
void warn(const std::string& name, const std::string& message);

/// Whether escape sequences for colour are welcome on a stream (1 standard output, 2 standard error): it is a terminal
/// that understands them, and NO_COLOR is not set (no-color.org).
[[nodiscard]] bool wants_color(int stream);

}  // namespace lightgrid
