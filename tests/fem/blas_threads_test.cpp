#include "fem/linear_algebra/blas_threads.h"
#include "fem/linear_algebra/sparse_cholesky.h"

#include <gtest/gtest.h>

#include <omp.h>

#include <algorithm>
#include <cstdlib>
#include <thread>

// CMakeLists.txt runs each of these tests in a process of its own, with and without OPENBLAS_NUM_THREADS.

namespace retractor::fem {
namespace {

    constexpr const char* kVariable = "OPENBLAS_NUM_THREADS";

    /// Factors a diagonal matrix, which has the solver go through CHOLMOD and BLAS.
    void use_the_solver()
    {
        SparseCholesky cholesky;
        cholesky.analyse({ .column_start = { 0, 1, 2 }, .row = { 0, 1 } });
        cholesky.factorise({ 1.0, 2.0 });
    }

    TEST(BlasThreads, OneUnlessAsked)
    {
        ASSERT_EQ(std::getenv(kVariable), nullptr) << "run this test through ctest";
        EXPECT_EQ(blas_threads(), 1);
        use_the_solver();
        EXPECT_EQ(blas_threads(), 1);
        EXPECT_NE(blas_description().find("1 thread"), std::string::npos) << blas_description();
    }

    TEST(BlasThreads, TheProgramMayAskForMore)
    {
        ASSERT_EQ(std::getenv(kVariable), nullptr) << "run this test through ctest";
        set_blas_threads(2);
        const int levels = omp_get_max_active_levels();
        use_the_solver();
        EXPECT_EQ(blas_threads(), 2);
        EXPECT_EQ(omp_get_max_active_levels(), levels) << "the caller's OpenMP is as it was";
        {
            const ScopedBlasThreads three(3);
            EXPECT_EQ(blas_threads(), 3);
        }
        EXPECT_EQ(blas_threads(), 2);
        set_blas_threads(0); // at least one
        EXPECT_EQ(blas_threads(), 1);
    }

    TEST(BlasThreads, TheEnvironmentMayAskForMore)
    {
        ASSERT_STREQ(std::getenv(kVariable), "2") << "run this test through ctest";
        // OpenBLAS takes no more from the environment than the process may use cores.
        const int expected = std::min(2, static_cast<int>(std::thread::hardware_concurrency()));
        EXPECT_EQ(blas_threads(), expected);
        use_the_solver();
        EXPECT_EQ(blas_threads(), expected);
    }

    constexpr const char* kKernels = "OPENBLAS_CORETYPE";

    bool is_of_a_pentium() { return blas_description().find("core Prescott") != std::string::npos; }

    TEST(BlasKernels, FitTheProcessorUnlessAsked)
    {
        ASSERT_EQ(std::getenv(kKernels), nullptr) << "run this test through ctest";
#if defined(__x86_64__)
        const bool has_avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
        EXPECT_FALSE(has_avx2 && is_of_a_pentium()) << blas_description();
#endif
        use_the_solver();
    }

    TEST(BlasKernels, TheEnvironmentMayAskForOthers)
    {
        ASSERT_STREQ(std::getenv(kKernels), "Prescott") << "run this test through ctest";
#if defined(__x86_64__)
        EXPECT_TRUE(is_of_a_pentium()) << blas_description();
#endif
        use_the_solver();
    }

} // namespace
} // namespace retractor::fem
