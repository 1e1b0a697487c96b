#include "fem/linear_algebra/blas_threads.h"

#include <cblas.h>

#include <algorithm>
#include <cstdlib>

namespace retractor::fem {

void set_blas_threads(int threads) { openblas_set_num_threads(std::max(threads, 1)); }

int blas_threads() { return openblas_get_num_threads(); }

std::string blas_description()
{
    return std::string(openblas_get_config()) + ", core " + openblas_get_corename() + ", "
        + std::to_string(blas_threads()) + " thread(s)";
}

bool use_one_blas_thread_unless_asked()
{
    // OpenBLAS has already read the variable. OpenBLAS ignores a value that is not a number.
    const char* asked = std::getenv("OPENBLAS_NUM_THREADS");
    if (asked == nullptr || std::atoi(asked) < 1)
        set_blas_threads(1);
    return true;
}

} // namespace retractor::fem
