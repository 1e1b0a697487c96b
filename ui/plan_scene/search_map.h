#pragma once
// A map of a search for incisions: the skin in the colours of the scores that incisions with their middle there reach,
// and the best incisions drawn on it. Units mm; frame patient LPS.

#include "planner/case/patient.h"
#include "planner/search/incision_search.h"
#include "ui/scene/scene.h"

#include <string>
#include <vector>

namespace retractor::ui {

/// An incision on the map.
struct MappedIncision {
    std::string sign; ///< "A"
    std::string words; ///< for the legend
    std::vector<Vec3> points;
};

/// The patient from the right, from the left and from behind. An incision is drawn where it faces the reader. Where
/// every incision shows too little or comes too near a structure, the map says so and gives no score.
Picture search_map(planner::Patient& patient, const planner::IncisionSearch& search,
    const std::vector<MappedIncision>& incisions, int width, int height);

} // namespace retractor::ui
