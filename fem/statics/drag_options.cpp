#include "fem/statics/drag_options.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace retractor::fem {

namespace {

    struct Reach {
        double mm;
        std::size_t most;
    };
    constexpr std::array kReaches { Reach { 40.0, 60'000 }, Reach { 30.0, 60'000 }, Reach { 20.0, 100'000 } };
    /// Quasi-Newton steps per frame while the hand moves; the equilibrium is found when the hand is still.
    constexpr int kFrameIterations = 2;

} // namespace

DragRegion drag_region(const mesh::TetMesh& mesh, const Points& wound)
{
    std::size_t count = 0;
    for (const Reach& reach : kReaches) {
        std::vector<std::uint8_t> near = elements_near(mesh, wound, reach.mm);
        count = static_cast<std::size_t>(std::count(near.begin(), near.end(), std::uint8_t { 1 }));
        if (count <= reach.most)
            return { std::move(near), reach.mm };
    }
    throw InputError(
        std::to_string(count) + " elements lie near the wound: too many to be dragged", "nonlinear region");
}

NonlinearRegionOptions drag_options(Eigen::VectorXd load)
{
    return {
        .elasticity = Elasticity::corotational_linear, .frame_iterations = kFrameIterations, .load = std::move(load)
    };
}

} // namespace retractor::fem
