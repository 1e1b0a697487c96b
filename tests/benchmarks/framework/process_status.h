#pragma once
// What the system says of this process.

#include <string>

namespace retractor::benchmarks {

/// An entry in kB of /proc/self/status ("VmRSS", "VmHWM"), MiB; 0 when there is none.
double status_mb(const std::string& key);

} // namespace retractor::benchmarks
