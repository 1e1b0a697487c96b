#include "planner/measures/sight/position_text.h"

#include "mesh/base/text_format.h"

#include <cmath>
#include <vector>

namespace retractor::planner {

std::string position_words(double left_side_up_deg)
{
    constexpr double kOnOneSideDeg = 90.0;
    const double turn = std::abs(left_side_up_deg);
    if (!(turn > 0.0))
        return "supine";
    const bool is_left_up = left_side_up_deg > 0.0;
    if (turn < kOnOneSideDeg)
        return formatted("with the %s side up by %.0f degrees", is_left_up ? "left" : "right", turn);
    return std::string("lying on the ") + (is_left_up ? "right" : "left") + " side";
}

std::string turned_sight_text(const FieldMetrics& field)
{
    std::vector<std::string> words;
    for (const TurnedSight& turned : field.if_turned)
        words.push_back(position_words(turned.left_side_up_deg) + formatted(" %.1f %%", 100.0 * turned.seen_best_eye));
    return words.empty() ? std::string() : "an eye above the table sees " + joined(words);
}

} // namespace retractor::planner
