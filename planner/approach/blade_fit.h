#pragma once
// Fits the blades of a retractor to the bones beside the wound, as a surgeon does. She turns a rib spreader until each
// blade lies along its rib: a blade across a rib bears on it at one end only, and the wound turns the retractor. And
// the blades reach as deep as the bone, also where the wall beside the bone is thinner. Units mm; frame patient LPS.

#include "mesh/image/volume.h"
#include "planner/case/approach.h"

namespace retractor::planner {

/// What the bones beside a wound ask of the blades.
struct BladeFit {
    /// Turn of both blades about PatchPlace::depth, right-handed, rad: the mean of the two sides' bones, at most 15
    /// degrees. A side counts where the edge of a bone lies along three fifths of its blade or more; a bone that is cut
    /// asks for no turn. 0 where no side counts.
    double yaw = 0.0;
    /// Depth below the skin, within the wall, at which both blades meet nine tenths of the bone behind them; 0 where
    /// each blade as it is meets three fifths of it, and where there is none.
    double reach_mm = 0.0;
};

/// @pre approach.retractor, and approach.hooks are blades_of() the approach
BladeFit blade_fit(const Approach& approach, const mesh::LabelVolume& labels);

/// Turns and lengthens the blades as blade_fit() says. No blade becomes longer than the retractor's. @pre as
/// blade_fit()
void fit_blades(Approach& approach, const mesh::LabelVolume& labels);

} // namespace retractor::planner
