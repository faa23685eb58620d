#include "app/machine.h"

#include <sched.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>

namespace firn {

namespace fs = std::filesystem;

// The value of "name: value" in one of the kernel's lists; empty if it is not there.
static std::string value_of(const char* file, const std::string& name) {
    std::ifstream lines(file);
    for (std::string line; std::getline(lines, line);) {
        const std::size_t colon = line.find(':');
        if (!line.starts_with(name) || colon == std::string::npos) continue;
        const std::size_t from = line.find_first_not_of(" \t", colon + 1);
        return from == std::string::npos ? "" : line.substr(from);
    }
    return "";
}

static std::uint64_t kilobytes(const char* file, const std::string& name) {
    std::istringstream words(value_of(file, name));
    std::uint64_t value = 0;
    words >> value;
    return value * 1024;
}

static std::optional<std::uint64_t> number_in(const fs::path& file) {
    std::ifstream in(file);
    std::uint64_t value = 0;
    if (in >> value) return value;
    return {};
}

Machine this_machine() {
    cpu_set_t cores;
    Machine machine;
    machine.cpu = value_of("/proc/cpuinfo", "model name");
    machine.cores = sched_getaffinity(0, sizeof cores, &cores) == 0 ? CPU_COUNT(&cores) : 1;
    machine.memory = kilobytes("/proc/meminfo", "MemTotal");
    return machine;
}

// What the process's cgroup (version 2, or 1's memory controller) and those around it leave.
static std::uint64_t cgroup_room() {
    std::uint64_t room = std::numeric_limits<std::uint64_t>::max();
    std::ifstream groups("/proc/self/cgroup");
    for (std::string line; std::getline(groups, line);) {
        const std::size_t path_at = line.rfind(':');
        const bool version2 = line.starts_with("0::"), memory = line.find(":memory:") != std::string::npos;
        if (path_at == std::string::npos || !(version2 || memory)) continue;
        const fs::path root = version2 ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory";
        fs::path group = root / line.substr(std::min(line.size(), path_at + 2));
        for (;; group = group.parent_path()) {
            const auto limit = number_in(group / (version2 ? "memory.max" : "memory.limit_in_bytes"));
            const auto used = number_in(group / (version2 ? "memory.current" : "memory.usage_in_bytes"));
            if (limit) room = std::min(room, *limit - std::min(*limit, used.value_or(0)));
            if (group == root || group == group.parent_path()) break;
        }
    }
    return room;
}

std::uint64_t available_memory() {
    std::uint64_t room = std::min(kilobytes("/proc/meminfo", "MemAvailable"), cgroup_room());
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
        const std::uint64_t used = kilobytes("/proc/self/status", "VmSize");
        room = std::min<std::uint64_t>(room, limit.rlim_cur - std::min<std::uint64_t>(limit.rlim_cur, used));
    }
    return room;
}

std::uint64_t available_disk(fs::path path) {
    path = fs::absolute(path);
    std::error_code error;
    while (!fs::exists(path, error) && path.has_relative_path()) path = path.parent_path();
    struct statvfs disk{};
    if (::statvfs(path.c_str(), &disk) != 0) return std::numeric_limits<std::uint64_t>::max();
    return static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
}

}  // namespace firn
