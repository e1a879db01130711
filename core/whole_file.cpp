#include "core/whole_file.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace lightgrid {
namespace {

std::string reason(int error) {
    return std::generic_category().message(error);
}

Error disk_error(const char* what, int error, const std::filesystem::path& path) {
    return Error(fmt::format("{}: {}", what, reason(error)), path.string(),
                 error == ENOSPC || error == EDQUOT || error == EFBIG ? "Free some space, or write to another place."
                                                                      : "Check the path and its permissions.",
                 Fault::work);
}

// An open file; a temporary name is removed again unless it was kept.
class File {
  public:
    File(std::filesystem::path path, int flags, bool temporary = false)
        : path_(std::move(path)), fd_(::open(path_.c_str(), flags, 0666)), temporary_(temporary && fd_ >= 0) {}
    ~File() {
        if (fd_ >= 0) ::close(fd_);
        if (temporary_) ::unlink(path_.c_str());
    }
    File(File&& other) noexcept
        : path_(std::move(other.path_)),
          fd_(std::exchange(other.fd_, -1)),
          temporary_(std::exchange(other.temporary_, false)) {}
    File& operator=(File&&) = delete;

    [[nodiscard]] bool is_open() const { return fd_ >= 0; }
    [[nodiscard]] int descriptor() const { return fd_; }
    [[nodiscard]] bool has_name() const { return temporary_; }
    void keep() { temporary_ = false; }
    // Gives a file without a name a temporary one. Returns 0 or errno.
    int set_name(std::filesystem::path path) {
        ::unlink(path.c_str());  // left by a killed process that had this one's number
        if (::linkat(AT_FDCWD, through_proc().c_str(), AT_FDCWD, path.c_str(), AT_SYMLINK_FOLLOW) != 0) return errno;
        path_ = std::move(path);
        temporary_ = true;
        return 0;
    }
    [[nodiscard]] std::string through_proc() const { return fmt::format("/proc/self/fd/{}", fd_); }
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

    // Each returns 0 or errno.
    int write(std::string_view bytes) {
        while (!bytes.empty()) {
            const ssize_t written = ::write(fd_, bytes.data(), bytes.size());
            if (written < 0 && errno == EINTR) continue;
            if (written < 0) return errno;
            bytes.remove_prefix(static_cast<std::size_t>(written));
        }
        return 0;
    }
    int close() {
        const int result = ::close(fd_);
        fd_ = -1;
        return result == 0 ? 0 : errno;
    }

  private:
    std::filesystem::path path_;
    int fd_ = -1;
    bool temporary_ = false;
};

void write_in_place(const std::filesystem::path& path, std::string_view bytes) {
    File file(path, O_WRONLY | O_CLOEXEC);
    if (!file.is_open()) throw disk_error("cannot be opened for writing", errno, path);
    if (const int error = file.write(bytes)) throw disk_error("cannot be written", error, path);
}

std::filesystem::path folder_of(const std::filesystem::path& path) {
    return path.has_parent_path() ? path.parent_path() : ".";
}

std::filesystem::path hidden_beside(const std::filesystem::path& path, int number) {
    return folder_of(path) / fmt::format(".{}.{}-{}.tmp", path.filename().string(), ::getpid(), number);
}

// A new file in the folder of `path`, without a name, so that nothing is left of it if the process dies; or, where
// there are no such files, with a hidden name. Names that a killed process left behind, or that another thread is
// using, are passed over.
File create_beside(const std::filesystem::path& path) {
    File unnamed(folder_of(path), O_WRONLY | O_TMPFILE | O_CLOEXEC);
    if (unnamed.is_open() && ::access(unnamed.through_proc().c_str(), F_OK) == 0) return unnamed;
    constexpr int attempts = 100;
    for (int attempt = 0;; ++attempt) {
        File file(hidden_beside(path, attempt), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, true);
        if (file.is_open() || errno != EEXIST || attempt == attempts) return file;
    }
}

void replace_file(const std::filesystem::path& path, std::string_view bytes) {
    File file = create_beside(path);
    if (!file.is_open()) throw disk_error("cannot be created", errno, path);
    int error = file.write(bytes);
    if (error == 0 && ::fsync(file.descriptor()) != 0) error = errno;
    if (error == 0 && !file.has_name()) error = file.set_name(hidden_beside(path, file.descriptor()));
    if (error == 0) error = file.close();
    if (error == 0 && ::rename(file.path().c_str(), path.c_str()) != 0) error = errno;
    if (error != 0) throw disk_error("cannot be written", error, path);
    file.keep();
    // The name is on the disk once its folder is; a file system that cannot sync folders keeps its own promise.
    const File directory(folder_of(path), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (directory.is_open()) ::fsync(directory.descriptor());
}

// What a write would end up replacing; a device or pipe is written to as it is.
std::filesystem::path target_of(const std::filesystem::path& path) {
    std::error_code ignored;
    const bool link = std::filesystem::is_symlink(std::filesystem::symlink_status(path, ignored));
    return link ? std::filesystem::weakly_canonical(path) : path;
}

bool is_special(const std::filesystem::path& path) {
    std::error_code ignored;
    const std::filesystem::file_status status = std::filesystem::status(path, ignored);
    return std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
}

}  // namespace

std::string read_whole_file(const std::filesystem::path& path) {
    const auto fail = [&](int error) { return Error("cannot be read: " + reason(error), path.string()); };
    const File file(path, O_RDONLY | O_CLOEXEC);
    if (!file.is_open()) throw fail(errno);
    std::string bytes;
    struct stat status {};
    if (::fstat(file.descriptor(), &status) == 0 && S_ISREG(status.st_mode)) {
        bytes.reserve(static_cast<std::size_t>(status.st_size) + 1);
    }
    constexpr std::size_t step = 1U << 16;
    for (;;) {
        const std::size_t size = bytes.size();
        bytes.resize(size < bytes.capacity() ? bytes.capacity() : size + step);
        const ssize_t count = ::read(file.descriptor(), bytes.data() + size, bytes.size() - size);
        const int error = errno;
        bytes.resize(size + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
        if (count == 0) return bytes;
        if (count < 0 && error != EINTR) throw fail(error);
    }
}

void write_whole_file(const std::filesystem::path& path, std::string_view bytes) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) throw disk_error("cannot be written", EISDIR, path);
    if (is_special(path)) {
        write_in_place(path, bytes);
    } else {
        replace_file(target_of(path), bytes);
    }
}

void check_writable(const std::filesystem::path& path) {
    std::error_code ignored;
    const auto refuse = [&](int error) {
        return Error("cannot be written: " + reason(error), path.string(), "Check the path and its permissions.");
    };
    if (std::filesystem::is_directory(path, ignored)) throw refuse(EISDIR);
    if (is_special(path)) {
        if (::access(path.c_str(), W_OK) != 0) throw refuse(errno);
    } else {
        if (!create_beside(target_of(path)).is_open()) throw refuse(errno);
    }
}

}  // namespace lightgrid
