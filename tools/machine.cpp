#include "tools/machine.h"

#include <fmt/format.h>

#include <fstream>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <thread>
#include <unistd.h>

namespace lightgrid {
namespace {

/// What follows the first `key` and `separator` at the start of a line of a file; empty where there is none.
std::string value_in(const char* file, const std::string& key, char separator) {
    std::ifstream lines(file);
    for (std::string line; std::getline(lines, line);) {
        const std::size_t end = line.find(separator);
        if (line.rfind(key, 0) != 0 || end == std::string::npos) continue;
        const std::size_t first = line.find_first_not_of(" \"", end + 1);
        const std::size_t last = line.find_last_not_of(" \"");
        return first == std::string::npos ? std::string() : line.substr(first, last + 1 - first);
    }
    return {};
}

}  // namespace

Machine this_machine() {
    Machine machine;
    utsname kernel{};
    const bool known = uname(&kernel) == 0;
    machine.processor = value_in("/proc/cpuinfo", "model name", ':');
    if (machine.processor.empty() && known) machine.processor = kernel.machine;
    machine.logical_processors = static_cast<int>(std::thread::hardware_concurrency());
    const long pages = sysconf(_SC_PHYS_PAGES);
    const long page_bytes = sysconf(_SC_PAGESIZE);
    if (pages > 0 && page_bytes > 0) {
        machine.memory_bytes = static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes);
    }
    machine.system = value_in("/etc/os-release", "PRETTY_NAME", '=');
    if (known) {
        machine.system += fmt::format("{}{} {} {}", machine.system.empty() ? "" : ", ", kernel.sysname, kernel.release,
                                      kernel.machine);
    }
#ifdef __clang__
    machine.built_with = "Clang " __clang_version__ " " LIGHTGRID_BUILD_TYPE;
#else
    machine.built_with = "GCC " __VERSION__ " " LIGHTGRID_BUILD_TYPE;
#endif
    machine.libraries = LIGHTGRID_LIBRARIES;
    return machine;
}

std::uint64_t peak_memory_bytes() {
    rusage usage{};
    if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts in kilobytes
}

}  // namespace lightgrid
