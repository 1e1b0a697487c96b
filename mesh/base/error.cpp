#include "mesh/base/error.h"

#include "mesh/base/assert.h"

#include <exception>
#include <new>

namespace retractor {

std::string to_string(const Failure& failure)
{
    return failure.where.empty() ? failure.what : failure.where + ": " + failure.what;
}

Failure current_failure()
{
    RETRACTOR_ASSERT(std::current_exception() != nullptr);
    try {
        throw;
    } catch (const Error& error) {
        return { error.what(), error.where(), error.fields() };
    } catch (const std::bad_alloc&) {
        return { "out of memory" };
    } catch (const std::exception& error) {
        return { error.what() };
    }
}

} // namespace retractor
