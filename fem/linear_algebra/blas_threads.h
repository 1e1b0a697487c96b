#pragma once
// How BLAS (OpenBLAS) runs: the number of its threads, and its kernels. Both hold for the whole process.
//
// The default of this library is one thread. The default of OpenBLAS is one thread per core, and its threads spin while
// they wait for each other: where other processes use the cores, a small factorisation then takes twenty times as long.
// The solvers use a second core by themselves (parallel.h), with threads that sleep while they wait.
//
// OpenBLAS has kernels for many processors and chooses by the model number. Debian 12's version 0.3.21 takes an Intel
// processor that it does not know (most since 2022, and virtual machines on them) for a Pentium 4, whose kernels take
// twice to four times as long (OpenBLAS issue 4267, mended in 0.3.25). Where the processor has AVX2 and FMA, the
// kernels for Haswell are taken instead, which the mended version takes too. OPENBLAS_CORETYPE in the environment
// holds.
//
// The default is set when the program starts, before main(). A later request of the program or its user therefore
// holds: OPENBLAS_NUM_THREADS in the environment, set_blas_threads(), or openblas_set_num_threads() itself. Every
// source that calls BLAS, or a library over BLAS, includes this header, so that every such program has the default.

#include <string>

namespace retractor::fem {

/// Sets the thread count of the whole process from now on. At least one thread is set.
void set_blas_threads(int threads);
/// The number of threads that BLAS uses now.
int blas_threads();
/// Name, version, core type and number of threads of the BLAS library in use, for reports on the machine.
std::string blas_description();

/// Sets the number of threads, and restores the earlier number in the destructor. The number belongs to the whole
/// process, so only one thread of the program may use this class at a time.
class ScopedBlasThreads {
public:
    explicit ScopedBlasThreads(int threads)
        : before_(blas_threads())
    {
        set_blas_threads(threads);
    }
    ScopedBlasThreads(const ScopedBlasThreads&) = delete;
    ScopedBlasThreads& operator=(const ScopedBlasThreads&) = delete;
    ~ScopedBlasThreads() { set_blas_threads(before_); }

private:
    int before_;
};

/// Sets one thread, unless OPENBLAS_NUM_THREADS is a number of at least 1. @return true
bool use_one_blas_thread_unless_asked();
/// Takes the kernels for Haswell where OpenBLAS did not know the processor, unless OPENBLAS_CORETYPE is set.
/// @pre nobody uses BLAS meanwhile. @return true
bool use_known_blas_kernels_unless_asked();
/// Initialised once per program, before main(), wherever this header is included.
inline const bool kBlasIsSetUp = use_known_blas_kernels_unless_asked() && use_one_blas_thread_unless_asked();

} // namespace retractor::fem
