#pragma once
// What is divided beyond the skin incision, under intact skin: the muscles between two ribs, as surgeons do to spread
// ribs without breaking them, or the sternum from its midline to its edge, as in a hemisternotomy. Plain data; the
// extent and the distances are written to and read from case.json.
// Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/image/volume.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// - skin: every layer of the wall is divided as far as the skin.
/// - full: intercostal muscle and pleura are divided beyond both ends of the skin incision, under intact skin.
/// - sternum_right, sternum_left, sternum_across: at the lower end of an incision over the sternum the bone is sawn
///   across, from the incision to its right edge, to its left edge, or to both. The first is the J of an upper
///   hemisternotomy, the last its T.
enum class DivisionExtent { skin, full, sternum_right, sternum_left, sternum_across };

bool divides_sternum(DivisionExtent extent);

/// "skin", "full", "sternum-right", "sternum-left" or "sternum-across", and back; nothing for another word.
std::string_view to_string(DivisionExtent extent);
std::optional<DivisionExtent> division_extent_from_string(std::string_view text);

/// Where a stroke leads: along an intercostal space towards the sternum or towards the spine, or across the sternum
/// towards the patient's right or left.
enum class StrokeWay { forwards, backwards, right, left };

/// "forwards", "backwards", "right" or "left".
std::string_view to_string(StrokeWay way);

/// One stroke beyond an end of the incision. The blade lies inside the chest and cuts outwards, as far as the outer
/// side of the bones: whatever covers them stays whole.
struct DivisionStroke {
    StrokeWay way = StrokeWay::forwards;
    std::vector<std::string> severs {}; ///< labels that the stroke severs
    std::vector<Vec3> line {}; ///< inside the chest, from the incision's end; at least two points
    std::vector<Vec3> directions {}; ///< out of the chest, unit; one per point
    double depth_mm = 0.0; ///< from the line to the outer side of the ribs
    double length_mm = 0.0; ///< along the space, or across the sternum
};

/// How an approach divides the intercostal space or the sternum.
struct Division {
    DivisionExtent extent = DivisionExtent::skin;
    /// Distances along the space beyond the incision's ends, towards the sternum and towards the spine. Not set: as far
    /// as find_division() allows.
    std::optional<double> forwards_mm {}, backwards_mm {};

    // Found in the labels by find_division(); not a part of case.json.
    std::vector<DivisionStroke> strokes {}; ///< empty: only the skin's length is divided
    std::string words {}; ///< what was found, or the reason why nothing is divided beyond the skin
};

/// The tissue that the division of an intercostal space severs beyond the skin.
struct DividedLabels {
    std::vector<Label> ids {};
    std::vector<std::string> names {}; ///< in the same order
    /// True: intercostal muscle and pleura have labels of their own. False: all soft tissue of the wall but the skin
    /// counts, and the depth of the strokes alone keeps the tissue over the ribs whole.
    bool has_own = false;
};
DividedLabels divided_labels(const mesh::LabelTable& table);

/// The blade of a stroke, as the cutter takes it.
mesh::Blade blade_of(const DivisionStroke& stroke);

/// @param pointer JSON pointer of the division, put before the failing key
/// @throws InputError on distances that are NaN or out of range, or that are given without full division
void check_division(const Division& division, const std::string& pointer = {});

} // namespace retractor::planner
