#include "tests/haptics/allocation_count.h"

#include <cstdlib>

<<<<<<< HEAD
// glibc's own functions under ours: operator new and Eigen end here too. Sanitizers bring their own.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

std::size_t retractor::testing::allocation_count() noexcept { return 0; }
=======
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

namespace retractor {
bool allocations_are_counted() noexcept { return false; }
std::size_t allocation_count() noexcept { return 0; }
} // namespace retractor
>>>>>>> fd3ed8f (Add the servo: coupling within the device's limits, passivity observer, fault latch, tick thread and histograms)

#else

namespace {
<<<<<<< HEAD

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

=======
thread_local constinit std::size_t count = 0;
}

namespace retractor {
bool allocations_are_counted() noexcept { return true; }
std::size_t allocation_count() noexcept { return count; }
} // namespace retractor

// glibc's own names for what they replace; operator new calls malloc.
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

>>>>>>> fd3ed8f (Add the servo: coupling within the device's limits, passivity observer, fault latch, tick thread and histograms)
#endif
