#include "tests/haptics/allocation_count.h"

#include <cstdlib>

// glibc's own functions under ours: operator new and Eigen end here too. Sanitizers bring their own.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

std::size_t retractor::testing::allocation_count() noexcept { return 0; }

#else

namespace {

thread_local std::size_t allocations = 0;

} // namespace

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);

void* malloc(std::size_t size)
{
    ++allocations;
    return __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size)
{
    ++allocations;
    return __libc_calloc(count, size);
}

void* realloc(void* memory, std::size_t size)
{
    ++allocations;
    return __libc_realloc(memory, size);
}
}

std::size_t retractor::testing::allocation_count() noexcept { return allocations; }

#endif
