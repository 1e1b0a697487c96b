#pragma once
// How the patient lies on the table: which way is up, how far organs sink, and what is seen then, in words. Angles in
// degrees about the patient's long axis: 0 is supine, as in the CT; positive: the left side is up; 90: lying on the
// right side. Units mm; frame patient LPS.
//
// Organs sink with the change of gravity since the CT. From supine to prone, twice gravity's size, the heart moved by
// 19 mm in the mean [Chino and Marks 2008, Int J Radiat Oncol Biol Phys 70:916, 16 patients].

#include "planner/anatomy/anatomy.h"
#include "planner/measures/field_metrics.h"

#include <string>
#include <vector>

namespace retractor::planner {

inline constexpr double kSinkMmPerGravity = 19.0 / 2.0;

struct TablePosition {
    double left_side_up_deg = 0.0;
    Vec3 up = Vec3::UnitY(); ///< away from the floor, unit
    Vec3 sink = Vec3::Zero(); ///< motion of the organs since the CT, mm
};

/// The position that is turned by this angle.
TablePosition table_position(const AnatomicalFrame& frame, double left_side_up_deg);

/// The positions in which a surgeon works through an opening with this outward normal: supine; where it lies on one
/// side, also turned by 15 and 30 degrees with this side up, and on the other side. Empty for an opening on the back:
/// the patient lies prone, and the CT does not show that.
std::vector<TablePosition> positions_for(const Vec3& outward, const AnatomicalFrame& frame);

/// "supine", "with the left side up by 30 degrees", "lying on the right side".
std::string position_words(double left_side_up_deg);

/// What the best eye sees in each position on the table; empty: not computed.
std::string turned_sight_text(const FieldMetrics& field);

} // namespace retractor::planner
