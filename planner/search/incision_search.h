#pragma once
// Searches for incisions by rays alone: thousands of incisions are tried as holes in the wall at rest
// (sight/aperture.h) and scored as planned fields are, but for the forces, which no hole has. What the search proposes
// is then planned. Units mm, degrees; frame patient LPS.
//
// - With landmarks, incisions lie over the spaces between two ribs, and, where the sternum may be sawn through, in its
//   midline. The ribs count as held apart; all other bones stay.
// - Anywhere, incisions are straight lines on the skin, and every bone stays.
//
// The search starts from no template. It takes a grid of places and lengths over every line, or points spread over the
// skin, each shifted by the seed, and then steps from the best of them, halving the steps.

#include "mesh/base/job.h"
#include "planner/case/approach.h"
#include "planner/case/patient.h"
#include "planner/measures/ranking.h"
#include "planner/search/incision_lines.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

struct SearchLimits {
    double shortest_mm = 60.0, longest_mm = 180.0; ///< of incisions over spaces and on the skin
    bool left = true, right = true; ///< sides whose spaces are tried
    int highest_space = 1, lowest_space = 11;
    bool saw = true; ///< the sternum may be sawn through
    double from_risk_mm = 2.0; ///< the blade keeps this distance from structures at risk; about a voxel
    double least_seen = 0.05; ///< of FoundIncision::seen; what shows less is no proposal
};

/// Openings that a plan can compute on most patients, mm. Surgeons may open wider.
inline constexpr double kSternumOpeningMm = 40.0, kRibOpeningMm = 30.0;

/// With rays and picture, a search on a patient's chest then took 287 s on two cores (ct/chest_half; ours).
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
    double opening_mm = 0.0; ///< width of the hole
    double own_seen = 0.0, own_reached = 0.0; ///< shares of what the eyes at this incision could see
    bool near_risk = false; ///< a structure at risk lies nearer to the blade than the limits allow
    /// What rays tell. Here the shares of the target are of the largest area that an eye at any of the incisions would
    /// see with the wall removed, so that an incision on the side where organs hide the target gets what it shows.
    Candidate candidate {};
    double points_of_100 = 0.0; ///< score without the force
};

/// A place that was tried, for the map.
struct TriedPlace {
    Vec3 middle = Vec3::Zero();
    double points_of_100 = 0.0;
    bool near_risk = false; ///< FoundIncision::near_risk
};

enum class SearchStatus { done, cancelled };

struct [[nodiscard]] IncisionSearch {
    SearchStatus status = SearchStatus::done;
    /// Highest score first. A space is there with its best place, and again with a place that is far from it.
    std::vector<FoundIncision> found {};
    std::vector<TriedPlace> tried {};
    double largest_bound_mm2 = 0.0; ///< area of the target that FoundIncision's shares are of
    std::vector<std::string> missing {}; ///< spaces and sternum without an incision, with the reason
    double seconds = 0.0;
};

/// The weights without the force. @throws InputError where nothing else has a weight
Weights weights_without_force(Weights weights);

/// @throws InputError on limits out of order, a target or an organ that the case does not have, an unknown retractor,
/// and missing landmarks, unless the search is anywhere
IncisionSearch search_incisions(Patient& patient, const SearchRequest& request, const Job& job = {});

} // namespace retractor::planner
