#pragma once
// What a search for incisions is asked for, and an incision that it has found. Units mm, degrees; frame patient LPS.

#include "mesh/base/geometry.h"
#include "planner/approach/intercostal_space.h"
#include "planner/case/approach.h"
#include "planner/measures/ranking.h"

#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

struct SearchLimits {
    double shortest_mm = 60.0, longest_mm = 180.0; ///< of incisions over spaces and on the skin
    bool left = true, right = true; ///< sides whose spaces are tried
    int highest_space = 1, lowest_space = 11;
    bool saw = true; ///< the sternum may be sawn through
    /// The blade keeps this distance from structures at risk, about a voxel. A saw through the sternum need not,
    /// because its foot runs between bone and heart, as long as nothing at risk lies in its way.
    double from_risk_mm = 2.0;
    /// What shows a smaller share is no proposal; of the same area as the shares of FoundIncision::candidate.
    double least_seen = 0.05;
};

/// Openings that a plan can compute on most patients, mm. Surgeons may open wider.
inline constexpr double kSternumOpeningMm = 30.0, kRibOpeningMm = 20.0;

/// A wound opens by half of its length at most: skin that is not stretched spans no more than a flat slit.
inline constexpr double kWidestShare = 0.5;

/// With rays and picture, a search then ends within 300 s on two cores (287 s at most on ct/chest_half; ours).
inline constexpr double kDraftTimeS = 260.0;

struct SearchRequest {
    TargetSpec target;
    SearchLimits limits {};
    Weights weights = default_weights();
    /// Between hooks or blades; 0: kSternumOpeningMm and kRibOpeningMm. A short incision opens less.
    double opening_mm = 0.0;
    std::string retractor {}, hooks {}; ///< as OpenedBy; both empty: the retractor that is usual there
    SizingSpec sizing {};
    ViewSpec view {};
    std::vector<std::string> retracted {}; ///< organs held aside besides lungs, pericardium and fat of the mediastinum
    bool anywhere = false; ///< straight lines on the skin instead of spaces and sternum
    unsigned seed = 0;
    /// Time for the draft plans, s. Incisions that are not planned by then are named. Not set: all the time they need.
    std::optional<double> draft_s = kDraftTimeS;
};

/// An incision that was tried.
struct FoundIncision {
    enum class Kind { space, sternum, skin };
    Kind kind = Kind::skin;
    std::optional<SpaceNumber> space {};
    double angle_deg = 0.0; ///< of the middle round the chest; over a space
    double along_mm = 0.0; ///< of the middle, along the space's line
    Vec3 middle = Vec3::Zero(); ///< on the skin
    std::vector<Vec3> points {}; ///< on the skin
    double length_mm = 0.0;
    double opening_mm = 0.0; ///< between hooks or blades on the skin; the hole is narrower by their steel
    double own_seen = 0.0, own_reached = 0.0; ///< shares of what the eyes at this incision could see
    /// A labelled structure at risk lies nearer to the blade than the limits allow, or in the way of a saw.
    bool near_risk = false;
    /// What rays tell. Here the shares of the target are of the largest area that an eye at any of the incisions would
    /// see with the wall removed, so that an incision on the side where organs hide the target gets what it shows.
    /// Its at_risk has assumed vessels only in what the search ends with.
    Candidate candidate {};
    double points_of_100 = 0.0; ///< score without the force
};

} // namespace retractor::planner
