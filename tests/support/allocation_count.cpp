#include "tests/support/allocation_count.h"

#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

bool retractor::test_support::allocations_are_counted() noexcept { return false; }
std::size_t retractor::test_support::allocation_count() noexcept { return 0; }

#else

namespace {

thread_local constinit std::size_t count = 0;

} // namespace

bool retractor::test_support::allocations_are_counted() noexcept { return true; }
std::size_t retractor::test_support::allocation_count() noexcept { return count; }

// Our functions replace malloc and call glibc's functions. operator new and Eigen use malloc too.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size)
{
    ++count;
    return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size)
{
    ++count;
    return __libc_calloc(n, size);
}
void* realloc(void* old, std::size_t size)
{
    ++count;
    return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size)
{
    ++count;
    return __libc_memalign(alignment, size);
}
}

#endif
