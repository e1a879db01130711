#include "tools/program.h"

#include "core/error.h"
#include "core/near_names.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <unistd.h>
#include <vector>

namespace lightgrid {
namespace {

// The reader of standard output has seen enough.
struct OutputClosed {};

[[noreturn]] void throw_output_failure(int error) {
    if (error == EPIPE) throw OutputClosed{};
    throw Error("cannot be written: " + std::generic_category().message(error), "standard output",
                "Free some space, or send the results elsewhere.", Fault::work);
}

void print_message(const std::string& name, const char* color, std::string_view message) {
    const bool colored = wants_color(STDERR_FILENO);
    fmt::print(stderr, "{}{}:{} {}\n", colored ? color : "", name, colored ? "\x1b[0m" : "", message);
}

std::string suggestion(const std::string& wrong, const std::vector<std::string>& known) {
    const std::vector<std::string> nearest = nearest_names(wrong, known, 1);
    // A third of the letters wrong is a slip of the finger; more is another word.
    if (nearest.empty() || edit_distance(wrong, nearest[0]) * 3 > wrong.size()) return {};
    return fmt::format(" (did you mean {}?)", nearest[0]);
}

std::vector<std::string> long_options(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options()) {
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
    return names;
}

std::vector<std::string> verbs(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
        names.push_back(verb->get_name());
    }
    return names;
}

std::string joined(const std::vector<std::string>& texts, const char* separator) {
    return fmt::format("{}", fmt::join(texts, separator));
}

// What was given, but belongs to nothing. An unknown option's value looks like an argument too many: only the option
// counts.
void find_unknown(const CLI::App& app, std::vector<std::string>& problems) {
    std::vector<std::string> extras = app.remaining();
    const auto end_of_options = std::find(extras.begin(), extras.end(), "--");
    for (auto extra = end_of_options; extra != extras.end(); ++extra) {
        if (extra == end_of_options) continue;
        problems.push_back(
            fmt::format("argument \"{}\" is one too many: what follows -- is a file's name, so options "
                        "go before it",
                        *extra));
    }
    extras.erase(end_of_options, extras.end());
    const auto is_option = [](const std::string& text) { return text.size() > 1 && text[0] == '-'; };
    const bool options = std::any_of(extras.begin(), extras.end(), is_option);
    const std::vector<std::string> known_verbs = verbs(app);
    const bool verb_is_wrong = !options && !known_verbs.empty() && app.get_subcommands().empty();
    for (const std::string& extra : extras) {
        if (is_option(extra)) {
            const std::string name = extra.substr(0, extra.find('='));
            std::error_code unreadable;
            problems.push_back(
                std::filesystem::exists(extra, unreadable)
                    ? fmt::format("{} reads as an option: for the file of that name, write ./{}", extra, extra)
                    : fmt::format("unknown option {}{}", name, suggestion(name, long_options(app))));
        } else if (verb_is_wrong) {
            problems.push_back(fmt::format("unknown verb {}{}", extra, suggestion(extra, known_verbs)));
            return;
        } else if (!options) {
            problems.push_back(fmt::format("argument \"{}\" is one too many", extra));
        }
    }
}

// Every value that does not convert or is out of range, and every option that has to be given and is not.
void find_wrong_values(const CLI::App& app, std::vector<std::string>& problems) {
    for (const CLI::Option* const_option : app.get_options()) {
        if (const_option->count() == 0) {
            if (const_option->get_required()) problems.push_back(const_option->get_name() + " is required");
            continue;
        }
        try {
            // What the parser does with each option until the first fails; it left them with their texts.
            const_cast<CLI::Option*>(const_option)->run_callback();
        } catch (const CLI::ParseError& error) {
            problems.emplace_back(error.what());
        }
    }
}

Error describe(const CLI::App& app, const CLI::ParseError& first) {
    std::vector<std::string> problems;
    std::string program = app.get_name();
    const CLI::App* chosen = &app;
    find_unknown(app, problems);
    for (const CLI::App* verb : app.get_subcommands()) {
        find_unknown(*verb, problems);
        chosen = verb;
        program += " " + verb->get_name();
    }
    find_wrong_values(*chosen, problems);
    if (problems.empty() && chosen == &app && !verbs(app).empty()) {
        problems.push_back(fmt::format("no verb: one of {} is needed", joined(verbs(app), ", ")));
    }
    if (problems.empty()) problems.emplace_back(first.what());  // options that exclude each other, and the like
    return Error(joined(problems, "; "), {}, fmt::format("See {} --help.", program));
}

}  // namespace

int run_program(const std::string& name, const std::function<int()>& body) {
    // A closed pipe is then seen by the write that fails.
    std::signal(SIGPIPE, SIG_IGN);
    constexpr const char* red = "\x1b[1;31m";
    try {
        const int status = body();
        if (std::fflush(stdout) != 0) throw_output_failure(errno);
        return status;
    } catch (const OutputClosed&) {
        return 0;
    } catch (const Error& error) {
        print_message(name, red, error.what());
        return static_cast<int>(error.fault());
    } catch (const std::bad_alloc&) {
        print_message(name, red, "needs more memory than there is");
        return static_cast<int>(Fault::work);
    } catch (const std::exception& error) {
        print_message(name, red, fmt::format("failed unexpectedly: {}", error.what()));
        return static_cast<int>(Fault::work);
    }
}

bool parse_command_line(CLI::App& app, int argc, const char* const* argv) {
    try {
        app.parse(argc, argv);
        return true;
    } catch (const CLI::CallForHelp&) {
        print(app.help());
    } catch (const CLI::CallForVersion& version) {
        print(fmt::format("{}\n", version.what()));
    } catch (const CLI::ParseError& error) {
        throw describe(app, error);
    }
    return false;
}

void print(std::string_view text) {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) throw_output_failure(errno);
}

void warn(const std::string& name, const std::string& message) {
    constexpr const char* yellow = "\x1b[1;33m";
    print_message(name, yellow, "warning: " + message);
}

bool wants_color(int stream) {
    const char* no_color = std::getenv("NO_COLOR");
    const char* terminal = std::getenv("TERM");
    if (no_color != nullptr && *no_color != '\0') return false;
    if (terminal == nullptr || std::string_view(terminal) == "dumb") return false;
    return ::isatty(stream) == 1;
}

}  // namespace lightgrid
