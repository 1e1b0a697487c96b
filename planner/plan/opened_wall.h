#pragma once
// The result of one opening of a field's wall (opened_wound.h). Plain data. Units mm, N; frame patient LPS.

#include "fem/statics/boundary_conditions.h"
#include "fem/statics/opening_types.h"
#include "planner/plan/planned_field.h"

#include <Eigen/Core>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

/// The result of one opening of a field's wall.
struct OpenedWall {
    /// Displacement of all nodes of ten-node elements, mm, three per node; empty with four-node elements.
    Eigen::VectorXd ten_node {};
    /// The solution by four-node elements from which ten-node elements began; none: they began at rest.
    std::optional<fem::OpeningResult> coarse {};
    Mat3 coarse_turn = Mat3::Identity(); ///< turns a retractor from where it is in `coarse` to where it is at the end
    std::vector<fem::HookPatch> hooks {}; ///< the hooks at their final places
    /// per hook: the force limit is reached; empty when all hooks prescribe displacements
    std::vector<bool> yielded {};
    std::size_t near_tets = 0; ///< number of nonlinear elements of an opening with a linear region; else 0
    fem::OpeningResult opening {}; ///< displacements of the wall's vertices, without midpoints
    std::optional<PlacedRetractor> retractor {}; ///< with a retractor; its blades are the hooks
    /// With a retractor whose blades are in contact: the largest force of a blade where the blades hold the tissue, in
    /// four-node elements, N; 0: not known. Contact begins there.
    double held_force_N = 0.0;
    /// Labels of the organs that the wall could touch; not set: without contact.
    std::optional<std::vector<std::string>> touchable {};
    /// A StageTest ended the opening: only `coarse` is filled, and with a retractor `hooks` and `retractor` of it.
    bool ended_by_test = false;
};

/// Decides with a usable solution by four-node elements whether ten-node elements go on from there.
using StageTest = std::function<bool(const fem::OpeningResult& four_node)>;

/// Whether the opening is in equilibrium and at most two elements in 1,000 are inverted.
bool is_usable(const fem::OpeningResult& opening);

} // namespace retractor::planner
