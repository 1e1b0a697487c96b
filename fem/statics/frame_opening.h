#pragma once
// Opens a wound with a retractor that nothing but the tissue holds, or whose direction a hand holds (blade_frame.h).
// The rack is driven by distance or by force.
//
// The first opening holds the frame where it was placed and moves the blades straight apart. Its forces are seldom in
// balance: one lip is stiffer, or the bone under a blade is farther to one end. Newton's method then moves the frame
// and turns the blades until resultant force and moment vanish; each evaluation is an opening that starts from the last
// one. While much force is missing an opening is solved roughly; the last one is solved to the full tolerance. The
// first stiffness of the frame comes from the linearised tissue. Broyden's update (Broyden 1965,
// doi 10.1090/S0025-5718-1965-0198670-6) corrects the stiffness from step to step, and the tissue is linearised again
// where the updated stiffness predicts badly.
//
// A blade turns freely until its play ends. At the end the arm holds the blade with a moment that only pushes it back.
// In each step the nine combinations of two blades, each free or at one of its two stops, are tried in turn.
//
// A hand, or an arm at the table, may hold the frame in the direction in which it was placed. The frame then drifts and
// does not tilt, and the resultant moment is what the hand bears. Where a free frame finds no balance, the search can
// go on with a held one.
//
// The answer is a balance, and need not be a stable one: a frame that carries much pressure may tip over.
//
// Units mm, N, rad; frame patient LPS.

#include "fem/statics/blade_frame.h"
#include "fem/statics/boundary_conditions.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/opening_types.h"
#include "mesh/base/job.h"

#include <array>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

namespace retractor::fem {

/// How the rack is driven: by the distance it opens, or by the force along the rack at each blade. One of the two.
struct RackDrive {
    std::optional<double> distance_mm {}; ///< 0 to 2 kFarthestHookMm
    std::optional<double> force_N {}; ///< >= 0
};

struct FrameOptions {
    /// Largest resultant force, or moment over the lever of the frame, relative to the larger blade force. The
    /// discretisation error of a blade force is ten times larger.
    double tolerance = 1e-3;
    int most_openings = 20; ///< the first one included, without those of may_stiffen
    double most_turned = std::numbers::pi; ///< rad: the search ends where the frame turns further
    bool direction_is_held = false; ///< by a hand or an arm at the table: the frame drifts, and does not tilt
    bool hold_without_balance = false; ///< a free frame without balance is held, and the search goes on
    /// One flag per label; 1: once the frame is in balance, elements of this label that are turned over are made ten
    /// times stiffer and the frame is balanced again, up to three times over, with up to five openings each
    /// (OpeningResult::stiffened). Empty: none. Only corotational elements that are not locking-free.
    std::vector<std::uint8_t> may_stiffen {};
};

/// A state from which a further search begins: the answer of other elements, or a place for the frame.
struct FrameStart {
    FrameState state;
    Points displacement; ///< n x 3, mm, all nodes; empty: the tissue is at rest, and the frame is placed first
    /// FrameOpening::stiffness of the same elements and blades; empty: the tissue is linearised.
    std::optional<FrameMatrix> stiffness {};
};

struct FrameOpening {
    /// Without a balance it is not converged, or cancelled: the state is the nearest to balance, and a message says so.
    OpeningResult opening;
    std::vector<HookPatch> blades; ///< the two blades at their final places
    FrameState state;
    std::array<BladeLoad, 2> loads; ///< that the retractor applies to the tissue
    Vec3 residual_force_N = Vec3::Zero(); ///< resultant of the blade forces
    /// Resultant moment about the frame's present centre; with FrameOptions::direction_is_held what the hand bears.
    Vec3 residual_moment_Nmm = Vec3::Zero();
    double rack_force_N = 0.0; ///< force along the rack at each blade
    double imbalance = 0.0; ///< as FrameOptions::tolerance
    FrameMatrix stiffness = FrameMatrix::Zero(); ///< of the frame in this tissue, N/mm
    int openings = 0;
    bool direction_is_held = false; ///< as asked, or because the free frame found no balance
};

/// Opens the wound with a retractor.
/// @param problem its two hooks are the blades; their displacements are not used
/// @param start empty: the search begins at rest
/// @throws InputError on a number of hooks other than two, a bad frame or drive, and with a condensed region; as
/// Opening does
FrameOpening open_with_frame(const ElasticProblem& problem, const BladeFrame& frame, const RackDrive& drive,
    const OpeningOptions& options, const FrameOptions& how = {}, const Job& job = {},
    const std::optional<FrameStart>& start = {});

} // namespace retractor::fem
