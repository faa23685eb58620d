#include "app/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

namespace firn {

namespace fs = std::filesystem;

[[noreturn]] static void fail(const std::string& what, const fs::path& path, int error) {
    throw FileError(
        fmt::format("cannot {} {}: {}", what, path.string(), std::generic_category().message(error)));
}

// An open file, closed at the end of its life.
class Descriptor {
public:
    explicit Descriptor(int number) : number_(number) {}
    ~Descriptor() { if (number_ >= 0) ::close(number_); }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int number() const { return number_; }
    int close() { return ::close(std::exchange(number_, -1)); }

private:
    int number_;
};

std::string read_file(const fs::path& path, std::size_t most) {
    struct stat status{};
    if (::stat(path.c_str(), &status) != 0) fail("read", path, errno);
    if (S_ISDIR(status.st_mode)) fail("read", path, EISDIR);
    if (!S_ISREG(status.st_mode))
        throw FileError(fmt::format("cannot read {}: not a regular file", path.string()));
    if (static_cast<std::uintmax_t>(status.st_size) > most)
        throw FileError(fmt::format("cannot read {}: it has {} bytes, more than the {} that it may have",
                                    path.string(), status.st_size, most));
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (file.number() < 0) fail("read", path, errno);
    std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t n = ::read(file.number(), bytes.data() + done, bytes.size() - done);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) fail("read", path, errno);
        if (n == 0) bytes.resize(done);
        done += static_cast<std::size_t>(n);
    }
    return bytes;
}

static void write_all(int file, std::string_view bytes, const fs::path& path) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(file, bytes.data(), std::min<std::size_t>(bytes.size(), 1u << 30));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) fail("write", path, n < 0 ? errno : EIO);
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
}

static fs::path unfinished(const fs::path& path) {
    return path.parent_path() / fmt::format(".{}.{}.unfinished", path.filename().string(), ::getpid());
}

bool is_unfinished(const fs::path& path) {
    return path.filename().string().starts_with(".") && path.extension() == ".unfinished";
}

static void sync_folder(const fs::path& folder) {
    const Descriptor file(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (file.number() < 0) fail("open", folder, errno);
    if (::fsync(file.number()) != 0 && errno != EINVAL)
        fail("write", folder, errno);  // EINVAL: it cannot be synced
}

void write_file(const fs::path& path, const std::vector<std::string_view>& pieces) {
    const fs::path beside = unfinished(path);
    try {
        Descriptor file(::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
        if (file.number() < 0) fail("write", path, errno);
        for (const auto piece : pieces) write_all(file.number(), piece, path);
        if (::fsync(file.number()) != 0) fail("write", path, errno);
        if (file.close() != 0) fail("write", path, errno);
        if (::rename(beside.c_str(), path.c_str()) != 0) fail("write", path, errno);
    } catch (...) {
        ::unlink(beside.c_str());
        throw;
    }
    sync_folder(path.has_parent_path() ? path.parent_path() : ".");
}

void make_folder(const fs::path& path) {
    std::error_code error;
    fs::create_directories(path, error);
    if (error) fail("make the folder", path, error.value());
    if (!fs::is_directory(path)) fail("make the folder", path, ENOTDIR);
}

void print_result(const std::string& text) {
    if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) return;
    if (errno != EPIPE) fail("write to", "standard output", errno);
}

void ignore_write_signals() {
    ::signal(SIGPIPE, SIG_IGN);
    ::signal(SIGXFSZ, SIG_IGN);
}

// The process that holds a lock on the file, as the kernel lists them: "1: FLOCK ADVISORY WRITE PID
// 08:01:INODE 0 EOF".
static std::string holder(const struct stat& file) {
    std::ifstream locks("/proc/locks");
    const std::string inode = fmt::format(":{}", file.st_ino);
    for (std::string line; std::getline(locks, line);) {
        std::istringstream words(line);
        std::string number, kind, mode, access, process, where;
        words >> number >> kind >> mode >> access >> process >> where;
        if (kind == "FLOCK" && where.ends_with(inode)) return "process " + process;
    }
    return "another process";
}

FolderLock::FolderLock(const fs::path& folder)
    : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (descriptor_ < 0) fail("open", folder, errno);
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
    const int error = errno;
    struct stat status{};
    ::fstat(descriptor_, &status);
    ::close(descriptor_);
    if (error != EWOULDBLOCK) fail("lock", folder, error);
    throw FileError(fmt::format("{} is in use: {} is writing to it; wait for it, or choose another with -o",
                                folder.string(), holder(status)));
}

FolderLock::~FolderLock() { ::close(descriptor_); }

}  // namespace firn
