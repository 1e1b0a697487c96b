#include "planner/case/draft_case.h"

#include <algorithm>

namespace retractor::planner {

void make_draft(Case& planned_case)
{
    constexpr double kEdgeMm = 12.0, kCoarseEdgeMm = 24.0; // round the incision and far
    // Edges of ten-node elements have a node in their middle.
    const double parts = has_ten_nodes(planned_case.solution.element) ? 2.0 : 1.0;
    planned_case.solution.element = ElementKind::p1;
    planned_case.contact = ContactMode::never; // contact takes several times as long as the plan without it
    for (Approach& approach : planned_case.approaches) {
        SizingSpec& sizing = approach.sizing;
        sizing.corridor_edge_mm = std::max(sizing.corridor_edge_mm / parts, kEdgeMm);
        sizing.coarse_edge_mm = std::max({ sizing.coarse_edge_mm / parts, sizing.corridor_edge_mm, kCoarseEdgeMm });
    }
}

} // namespace retractor::planner
