#include "planner/measures/sight/finger_text.h"

#include "mesh/base/text_format.h"

#include <algorithm>

namespace retractor::planner {

std::string finger_text(const FieldMetrics& field)
{
    constexpr double kNothing = 0.005; // a share that rounds to nothing
    const std::string target = readable(field.target);
    if (field.reached_by_finger >= kNothing)
        return formatted("A finger touches %.0f %%.", 100.0 * field.reached_by_finger);
    if (field.finger_lacks_mm)
        return formatted("A finger ends %.0f mm before the %s.", std::max(1.0, *field.finger_lacks_mm), target.c_str());
    return field.reached_by_finger > 0.0 ? "A finger touches less than 1 %."
                                         : "No straight finger comes to the " + target + " through the opening.";
}

} // namespace retractor::planner
