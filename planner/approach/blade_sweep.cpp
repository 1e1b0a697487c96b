#include "planner/approach/blade_sweep.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <string>

namespace retractor::planner {

std::optional<Vec3> fold_of(const Approach& approach)
{
    for (std::size_t n = 0; n + 1 < approach.incision.size(); ++n) {
        const Vec3 step = approach.incision[n + 1] - approach.incision[n];
        const Vec3 below = step + approach.depth_mm * (approach.directions[n + 1] - approach.directions[n]);
        if (!(below.dot(step) > 0.0))
            return approach.incision[n];
    }
    return std::nullopt;
}

void check_sweep(const Approach& approach)
{
    if (const std::optional<Vec3> fold = fold_of(approach))
        throw InputError("the blade folds over itself " + in_words(approach.depth_mm) + " mm below the skin near "
            + in_words(*fold) + ": the skin bends too sharply there for this depth");
}

} // namespace retractor::planner
