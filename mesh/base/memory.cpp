#include "mesh/base/memory.h"

#include <algorithm>
#include <fstream>
#include <string>

namespace retractor {

namespace {

    /// The number after a key of /proc/meminfo, which counts in kB of 1024 bytes.
    std::optional<double> meminfo(const std::string& key)
    {
        std::ifstream in("/proc/meminfo");
        double value = 0.0;
        for (std::string word; in >> word;)
            if (word == key)
                return in >> value ? std::optional(1024.0 * value) : std::nullopt;
        return std::nullopt;
    }

    /// The first number of a file of limits; nothing when the file contains "max".
    std::optional<double> limit_in(const char* file)
    {
        std::ifstream in(file);
        double value = 0.0;
        return in >> value ? std::optional(value) : std::nullopt;
    }

} // namespace

Memory memory_of_machine()
{
    Memory memory { meminfo("MemTotal:"), meminfo("MemAvailable:"), std::nullopt };
    if (const auto limit = limit_in("/sys/fs/cgroup/memory.max"))
        memory.left_in_container = std::max(0.0, *limit - limit_in("/sys/fs/cgroup/memory.current").value_or(0.0));
    return memory;
}

std::optional<double> available_memory()
{
    const Memory memory = memory_of_machine();
    if (memory.available && memory.left_in_container)
        return std::min(*memory.available, *memory.left_in_container);
    return memory.available ? memory.available : memory.left_in_container;
}

} // namespace retractor
