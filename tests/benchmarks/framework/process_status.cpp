#include "tests/benchmarks/framework/process_status.h"

#include <fstream>

namespace retractor::benchmarks {

double status_mb(const std::string& key)
{
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with(key + ":"))
            return std::stod(line.substr(key.size() + 1)) / 1024.0;
    return 0.0;
}

} // namespace retractor::benchmarks
