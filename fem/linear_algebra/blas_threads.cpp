#include "fem/linear_algebra/blas_threads.h"

#include <cblas.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

// OpenBLAS exports how it chooses its kernels, but declares it in no header. Without these functions nothing is chosen.
extern "C" {
[[gnu::weak]] void gotoblas_dynamic_quit();
[[gnu::weak]] void gotoblas_dynamic_init();
}

namespace retractor::fem {

void set_blas_threads(int threads) { openblas_set_num_threads(std::max(threads, 1)); }

int blas_threads() { return openblas_get_num_threads(); }

std::string blas_description()
{
    return std::string(openblas_get_config()) + ", core " + openblas_get_corename() + ", "
        + std::to_string(blas_threads()) + " thread(s)";
}

bool use_known_blas_kernels_unless_asked()
{
#if defined(__x86_64__)
    constexpr const char* kVariable = "OPENBLAS_CORETYPE";
    const bool unknown = std::string_view(openblas_get_corename()) == "Prescott";
    if (!unknown || std::getenv(kVariable) != nullptr || !__builtin_cpu_supports("avx2")
        || !__builtin_cpu_supports("fma") || gotoblas_dynamic_quit == nullptr || gotoblas_dynamic_init == nullptr)
        return true;
    setenv(kVariable, "Haswell", 1);
    gotoblas_dynamic_quit();
    gotoblas_dynamic_init(); // reads the variable
    unsetenv(kVariable);
#endif
    return true;
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
