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
#include "planner/case/patient.h"
#include "planner/measures/ranking.h"
#include "planner/search/search_request.h"

#include <cstddef>
#include <string>
#include <vector>

namespace retractor::planner {

/// A place that was tried, for the map.
struct TriedPlace {
    Vec3 middle = Vec3::Zero();
    double points_of_100 = 0.0;
    bool near_risk = false; ///< FoundIncision::near_risk
    bool shows_little = false; ///< less than SearchLimits::least_seen
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
