#pragma once
// Makes an approach from a template or from points. A template finds its landmarks in the labels, so the same template
// serves every patient, in any position. Units mm; frame patient LPS.
//
// - median: full sternotomy. The incision follows the sternum's midline from 10 mm above the notch to 10 mm below the
//   xiphoid. The blade is square to the sternum and saws it through.
// - hemisternotomy-j[:N], hemisternotomy-j-left[:N], hemisternotomy-t[:N]: upper hemisternotomy. The incision follows
// the
//   sternum's midline from 10 mm above the notch to the level of space N (the 4th by default), where the saw turns
//   under the skin: to the right edge (J), to the left one, or to both (T) [Onan 2020,
//   doi 10.5606/tgkdc.dergisi.2020.19614].
// - intercostal:N: lateral thoracotomy along the upper edge of rib N+1, 170 mm long, on the left unless the
//   request says otherwise.
// - distal[:N]: left posterolateral thoracotomy for the distal arch and the descending aorta, 160 mm long, in space N
//   (the 6th by default). The incision lies between the back muscles and the side, where it faces the target.
// - midcab[:N]: left anterior mini-thoracotomy, 70 mm long, centred over the target. The space is N, or whichever of
//   the 4th and 5th is nearer to the target.
// - right-anterior[:N]: right anterior mini-thoracotomy for the aortic valve, 60 mm long, where space N, or the nearer
// of
//   the 2nd and 3rd, faces the target. Surgeons choose it where more than half of the ascending aorta lies right of the
//   sternum's edge, less than 100 mm from the chest wall [Gilmanov 2013, Ann Thorac Surg 96:837].
// - right-lateral[:N]: right lateral mini-thoracotomy for mitral and tricuspid valve, 70 mm long, in space N (the 4th
// by
//   default), centred about the anterior axillary line [Onan 2020, doi 10.5606/tgkdc.dergisi.2020.19614].
//
// The templates between ribs divide intercostal muscle and pleura beyond the skin incision, as surgeons do to spread
// ribs (DivisionExtent::full).

#include "planner/anatomy/anatomy.h"
#include "planner/case/approach.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

struct ApproachRequest {
    std::string template_name; ///< one of the templates above
    std::string name; ///< empty: the template's name, ":" replaced by "_"
    TargetSpec target;
    bool left = true; ///< side of an intercostal approach; the other templates have a fixed side
    double length_mm = 0.0; ///< length of the incision; 0: the template's own length
    /// Distance along the space from the template's own place, towards the front; templates between ribs only.
    double shift_mm = 0.0;
    std::optional<DivisionExtent> division {}; ///< not set: the template's own; points divide the skin's length
    SizingSpec sizing;
    ViewSpec view;
};

/// Begin of the sentence of a rationale that speaks of the target; it ends with the next full stop.
inline constexpr std::string_view kTargetWords = " The target's centre lies ";

/// The organs that stand in front of the target and are held aside: lungs of the given sides, the fat of the
/// mediastinum, and the pericardium. Lungs may be one label per lung or per lobe ("lung_upper_lobe_left").
std::vector<std::string> retracted_organs(
    const mesh::LabelTable& table, bool left_lung, bool right_lung, bool pericardium);

/// @throws InputError when the template is unknown, a landmark is missing, or the space has no room for the blade.
Approach approach_from_template(const mesh::LabelVolume& labels, const ApproachRequest& request);
/// Makes the approach from landmarks that were found before.
Approach approach_from_template(
    const mesh::LabelVolume& labels, const Anatomy& anatomy, const ApproachRequest& request);

struct PointsApproach {
    Approach approach; ///< template_name "points"
    std::vector<double> moved_mm; ///< distance of each given point from the skin
};

/// Makes an incision through the given points, which are moved onto the skin. The blade goes in square to the skin.
/// Where the skin bends so sharply that the blade would fold over itself, its directions are turned towards their mean,
/// as far as needed and by at most 35 degrees.
/// @param depth_mm depth of the blade; 0: through the wall, as measured
/// @throws InputError when a point is more than `reach_mm` from the skin, or when no cavity lies behind the wall and no
/// depth is given
PointsApproach approach_from_points(const mesh::LabelVolume& labels, const std::vector<Vec3>& points,
    const ApproachRequest& request, double depth_mm = 0.0, double reach_mm = 40.0);

} // namespace retractor::planner
