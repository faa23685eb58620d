#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

namespace firn {

struct Machine {
    std::string cpu;            ///< model name.
    int cores = 1;              ///< that this process may use.
    std::uint64_t memory = 0;   ///< of the whole machine [bytes].
};
Machine this_machine();

/// Memory that this process can still take [bytes]: the least of what is free, of the cgroups' limits and of
/// the limit on its address space.
std::uint64_t available_memory();

/// Space that the user may still fill on the disk where the path is or will be [bytes].
std::uint64_t available_disk(std::filesystem::path);

}  // namespace firn
