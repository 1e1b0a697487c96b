#pragma once
// Memory of this process as reported by the system.

#include <string>

namespace retractor::benchmarks {

/// An entry of /proc/self/status that is given in kB ("VmRSS", "VmHWM"), in MiB; 0 when there is no such entry.
double status_mb(const std::string& key);

} // namespace retractor::benchmarks
