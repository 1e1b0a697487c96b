#include "planner/measures/sight/table_position.h"

#include "mesh/base/text_format.h"

#include <cmath>
#include <numbers>
#include <vector>

namespace retractor::planner {

TablePosition table_position(const AnatomicalFrame& frame, double left_side_up_deg)
{
    const double angle = left_side_up_deg * std::numbers::pi / 180.0;
    TablePosition position { .left_side_up_deg = left_side_up_deg,
        .up = std::cos(angle) * frame.anterior + std::sin(angle) * frame.left };
    position.sink = kSinkMmPerGravity * (frame.anterior - position.up);
    return position;
}

std::vector<TablePosition> positions_for(const Vec3& outward, const AnatomicalFrame& frame)
{
    constexpr double kOnOneSide = 0.3, kOnTheBack = -0.5; // of the normal's part to the left, and to the front
    const Vec3 normal = outward.normalized();
    if (normal.dot(frame.anterior) < kOnTheBack)
        return {};
    std::vector<TablePosition> positions { table_position(frame, 0.0) };
    const double to_left = normal.dot(frame.left);
    if (std::abs(to_left) > kOnOneSide)
        for (const double turn : { 15.0, 30.0, 90.0 })
            positions.push_back(table_position(frame, std::copysign(turn, to_left)));
    return positions;
}

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
        words.push_back(formatted("%.1f %% ", 100.0 * turned.seen_best_eye) + position_words(turned.left_side_up_deg));
    return words.empty() ? std::string() : "from above the table the best eye sees " + joined(words);
}

} // namespace retractor::planner
