#pragma once
// Approaches by template or by points. Templates find their landmarks in the labels, so they work on another patient,
// and on the same one shifted and turned. Units mm; frame patient LPS.
//
//   median         full sternotomy: the sternum's midline from 10 mm above the notch to 10 mm below the xiphoid, blade
//                  square to the sternum, sternum sawn through.
//   intercostal:N  thoracotomy: the middle between rib N and rib N+1, left unless said otherwise, lateral (170 mm).
//   distal[:N]     left posterolateral thoracotomy for the distal arch and the descending aorta: the 6th space (or N)
//   between
//                  the back muscles and the side, slid along the space to face the target (160 mm).
//   midcab[:N]     left anterior mini-thoracotomy: the 4th or 5th space (or N), whichever lies nearer to the target,
//   centred
//                  over it (70 mm).

#include "planner/anatomy/anatomy.h"
#include "planner/case/approach.h"

#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

struct ApproachRequest {
    std::string template_name; ///< as above
    std::string name; ///< empty: the template's name, ":" replaced by "_"
    TargetSpec target;
    bool left = true; ///< intercostal only: the others have their side
    double length_mm = 0.0; ///< 0: the template's own
    SizingSpec sizing;
    ViewSpec view;
};

/// @throws InputError when the template is unknown, a landmark is missing, or the space has no room for the blade.
Approach approach_from_template(const mesh::LabelVolume& labels, const ApproachRequest& request);
/// The same with landmarks found before.
Approach approach_from_template(
    const mesh::LabelVolume& labels, const Anatomy& anatomy, const ApproachRequest& request);

struct PointsApproach {
    Approach approach; ///< template_name "points"
    std::vector<double> moved_mm; ///< per given point: how far it was from the skin
};

/// An incision through given points, moved onto the skin; the blade goes in square to the skin.
/// @param depth_mm 0: through the wall, as measured. @throws InputError when a point is more than `reach_mm` off the
/// skin, or when no cavity lies behind the wall and no depth is given.
PointsApproach approach_from_points(const mesh::LabelVolume& labels, const std::vector<Vec3>& points,
    const ApproachRequest& request, double depth_mm = 0.0, double reach_mm = 40.0);

} // namespace retractor::planner
