#pragma once
// How many threads BLAS (OpenBLAS) uses. OpenBLAS has one thread count for the whole process.
//
// The library's own default is one thread. OpenBLAS's default is one thread per core, and its threads spin while they
// wait for each other: where other processes use the cores, a small factorisation then takes twenty times as long. The
// solvers use a second core by themselves (parallel.h), with threads that sleep while they wait.
//
// The default is set when the program starts, before main(). So whatever the program or its user asks for holds:
// OPENBLAS_NUM_THREADS in the environment, set_blas_threads(), or openblas_set_num_threads() itself. Every source that
// calls BLAS, or a library over BLAS, includes this header, so that no program gets one without the default.

#include <string>

namespace retractor::fem {

/// Asks for this many threads, at least one, from now on and in the whole process.
void set_blas_threads(int threads);
/// The number of threads that BLAS uses now.
int blas_threads();
/// Name, version, core type and number of threads of the BLAS that is bound, e.g. for a report on what the machine
/// can do.
std::string blas_description();

/// Sets the number of threads, and at the end of its life sets the number back that was there before. Only for one
/// thread of the program at a time, as the number belongs to the whole process.
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

/// Sets one thread, unless OPENBLAS_NUM_THREADS is a number from 1. @return true.
bool use_one_blas_thread_unless_asked();
/// Initialised once in a program, before main(), wherever this header is included.
inline const bool kBlasThreadsAreSet = use_one_blas_thread_unless_asked();

} // namespace retractor::fem
