#pragma once
// Checks of this project's own bugs: preconditions and invariants that no input can break. A failed check prints the
// condition with its place and aborts, so that a debugger, a sanitizer and a fuzzer stop there.
// The checks are compiled in debug builds and where RETRACTOR_ASSERTIONS is defined (presets dev, asan, tsan and fuzz);
// a release build does not evaluate them. What a user can cause is no bug: throw InputError instead.

#include <cstdio>
#include <cstdlib>

namespace retractor {

/// Prints the failed condition with its place and aborts. Called by RETRACTOR_ASSERT only.
[[noreturn]] inline void assertion_failed(const char* condition, const char* file, int line)
{
    std::fprintf(stderr, "%s:%d: this must hold: %s\n", file, line, condition);
    std::abort();
}

} // namespace retractor

#if defined(RETRACTOR_ASSERTIONS) || !defined(NDEBUG)
/// Aborts unless the condition holds. The condition must have no side effects.
#define RETRACTOR_ASSERT(...) \
    ((__VA_ARGS__) ? static_cast<void>(0) : ::retractor::assertion_failed(#__VA_ARGS__, __FILE__, __LINE__))
#else
#define RETRACTOR_ASSERT(...) static_cast<void>(sizeof((__VA_ARGS__) ? 1 : 0))
#endif
