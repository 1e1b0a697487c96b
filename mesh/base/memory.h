#pragma once
// The memory that this machine has and this process may still take. A computation that knows its need refuses before
// it begins: Linux grants memory that is not there, and ends the process that uses it.

#include <optional>

namespace retractor {

constexpr double kGiB = 1024.0 * 1024.0 * 1024.0;

/// Bytes; nothing where the system does not tell.
struct Memory {
    std::optional<double> total; ///< of the machine
    std::optional<double> available; ///< of the machine, without swapping
    std::optional<double> left_in_container; ///< of the container's limit; nothing without a limit
};

/// Reads /proc/meminfo and the limits of cgroups, version 2.
Memory memory_of_machine();

/// The less of what the machine has available and what the container's limit leaves.
std::optional<double> available_memory();

} // namespace retractor
