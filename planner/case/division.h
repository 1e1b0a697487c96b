#pragma once
// How far the muscles between two ribs are divided: along the skin incision only, or beyond its ends, as surgeons do to
// spread ribs without breaking them. Plain data; the extent and the distances are written to and read from case.json.
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
enum class DivisionExtent { skin, full };

/// "skin" or "full", and back; nothing for another word.
std::string_view to_string(DivisionExtent extent);
std::optional<DivisionExtent> division_extent_from_string(std::string_view text);

/// One stroke along an intercostal space, beyond one end of the incision. The blade lies inside the chest and cuts
/// outwards, as far as the outer side of the ribs: whatever covers the ribs stays whole.
struct DivisionStroke {
    bool forwards = true; ///< towards the sternum; false: towards the spine
    std::vector<Vec3> line {}; ///< inside the chest, from the incision's end; at least two points
    std::vector<Vec3> directions {}; ///< out of the chest, unit; one per point
    double depth_mm = 0.0; ///< from the line to the outer side of the ribs
    double length_mm = 0.0; ///< along the middle of the space
};

/// How an approach divides the intercostal space.
struct Division {
    DivisionExtent extent = DivisionExtent::skin;
    /// Distances along the space beyond the incision's ends, towards the sternum and towards the spine. Not set: as far
    /// as find_space_division() allows.
    std::optional<double> forwards_mm {}, backwards_mm {};

    // Found in the labels by find_space_division(); not a part of case.json.
    std::vector<DivisionStroke> strokes {}; ///< empty: only the skin's length is divided
    std::string words {}; ///< what was found, or the reason why nothing is divided beyond the skin
};

/// The tissue that a division severs beyond the skin.
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
