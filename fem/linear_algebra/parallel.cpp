#include "fem/linear_algebra/parallel.h"

#include <atomic>

namespace retractor::fem {

namespace {

    std::atomic<bool> second_thread { std::thread::hardware_concurrency() >= 2 };

} // namespace

void set_solver_threads(int threads) { second_thread = threads >= 2; }
bool solver_has_second_thread() { return second_thread; }

} // namespace retractor::fem
