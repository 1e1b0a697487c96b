#pragma once
// Opens a wound with contact where its surfaces would pass through each other, and without contact elsewhere.
//
// The wound is first solved without contact: by four-node elements where ten-node elements begin with them. Where
// surfaces then pass through each other by more than they are known, the wound is solved again with contact. Soft
// organs give way: contact leaves out those into which the wall sinks no deeper than gives_way_mm(). The
// solution begins at the solution without contact: the pairs are followed from rest to there, since contact that begins
// with a point deep behind a face takes the point to have been inside all along. Where this finds no equilibrium, where
// only four-node elements were solved of ten-node elements, or where hooks hold nodes of the surface (these may collide
// on their way), it begins at rest. The solution by ten-node elements is tested as well. Where contact finds no
// equilibrium in its time, the solution without contact is kept, and the deepest place is reported.
//
// Error. Penetration is found by the points of both surfaces (fem/model/contact.h). An edge that passes through an edge
// between the points is not seen. Units mm, N, s; frame patient LPS.

#include "fem/model/contact.h"
#include "fem/statics/elastic_problem.h"
#include "mesh/base/job.h"
#include "mesh/image/volume.h"
#include "planner/case/approach.h"
#include "planner/case/patient.h"
#include "planner/case/solver_settings.h"
#include "planner/measures/field_metrics.h"
#include "planner/plan/opened_wall.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

/// Surfaces that pass through each other by no more than this beyond their overlap at rest do not touch. Contact
/// changes forces and openings by less than their error bars there. Surfaces from labels are known to half a voxel at
/// best, which takes the place of a smaller number, up to the second one: what is deeper would be seen.
inline constexpr double kPenetrationToleranceMm = 0.2, kMostToleranceMm = 0.75;

/// An organ gives way as long as it bears less than this (ours: 2 to 5 % of a retractor's force on the demo and on a
/// chest). A rigid organ would bear tens of newtons.
inline constexpr double kBornByOrganN = 2.0;
/// Radius of the circle over which the wall presses on an organ, ours.
inline constexpr double kPressedRadiusMm = 30.0;
/// Deepest that any organ gives way: the test follows surfaces to 12 mm.
inline constexpr double kMostGivesWayMm = 8.0;

/// How deep the wall may sink into an organ before it bears kBornByOrganN: a flat punch of kPressedRadiusMm on a half
/// space, F = 2 E a d / (1 - nu^2). A liver of 5.4 kPa gives way by 4.7 mm, a heart of 20 kPa by 1.3 mm.
double gives_way_mm(const fem::Material& organ);

/// The time for contact, in times of what was solved without contact before, and at least. Newton's method finds one by
/// one which points touch, and each set of points takes a solution of its own. Ours: a plan must not wait long for
/// contact that may not be found, and says where it was not found.
inline constexpr double kContactTimes = 2.0, kLeastContactS = 60.0;
/// The same for ten-node elements, from where four-node elements have found their contact.
inline constexpr double kTenNodeContactTimes = 8.0, kLeastTenNodeContactS = 120.0;

/// The organs that stay in place, as rigid surfaces.
struct ContactSurfaces {
    fem::ContactOptions options;
    std::vector<std::string> names; ///< label of each surface of options.fixed
    std::vector<double> gives_way_mm {}; ///< of each surface; empty: all are rigid
    double tolerance_mm = kPenetrationToleranceMm; ///< to which the surfaces are known
};

/// The surfaces of the labels that are no wall, are not full of air, and that the approach does not hold aside.
/// @throws as Patient::organ()
ContactSurfaces contact_surfaces(const mesh::LabelTable& table, const Approach& approach, Patient& patient);

/// The deepest place at which surfaces pass through each other.
struct Penetration {
    double depth_mm = 0.0; ///< beyond the overlap at rest; 0: nothing passes. Depths beyond 12 mm count as 12 mm
    Vec3 at = Vec3::Zero(); ///< in the opened wound, mm
    std::string with {}; ///< label of the organ; empty: the wall passes through itself
    double overlap_at_rest_mm = 0.0;
};

/// Finds where a displacement lets surfaces pass through each other. The body is moved there in steps along straight
/// lines, so that a point that ends deep behind a face is seen to pass through it.
/// @param problem four-node elements
/// @param displacement n x 3, mm
/// @throws InputError as fem::Contact does
Penetration find_penetration(
    const fem::ElasticProblem& problem, const ContactSurfaces& surfaces, const Points& displacement);

/// Opens the wound once.
/// @param contact empty: without contact
/// @param start, goes_on as open_wall() (opened_wound.h)
using OpenOnce = std::function<OpenedWall(const std::optional<fem::ContactOptions>& contact, const OpenedWall* start,
    const StageTest& goes_on, const Job& job)>;

struct ContactOpening {
    OpenedWall opened;
    std::optional<ContactMetrics> contact {}; ///< nothing with ContactMode::never, and with a cancelled job
};

/// Opens a wound, with contact as the mode says.
/// @param problem that `open` opens
/// @param can_touch whether `open` takes contact: not with a condensed region, where contact is only tested
/// @throws as `open`; what `open` throws with ContactMode::automatic and contact is reported as ContactMetrics::message
ContactOpening open_with_contact(const fem::ElasticProblem& problem, ContactMode mode, const ContactSurfaces& surfaces,
    const OpenOnce& open, bool can_touch, const Job& job);

/// Opens a wound with contact from an opening of the same wall with other tissue that has contact. All hooks are blades
/// in contact: others begin at rest (open_wall()).
/// @param surfaces all of them; the wall is held off those that the start could touch
/// @returns nothing where this finds no equilibrium within kLeastTenNodeContactS, and where the wall passes through
/// another organ than before: open_with_contact() then begins at rest
/// @pre start.touchable is set
std::optional<ContactOpening> open_touching_from(const OpenedWall& start, const fem::ElasticProblem& problem,
    const ContactSurfaces& surfaces, const OpenOnce& open, const Job& job);

/// Opens a wound without contact from an opening of the same wall with other tissue.
/// @returns nothing where this finds no equilibrium, or where surfaces then pass through each other and the mode is not
/// `never`: open_with_contact() then begins at rest
/// @throws as `open`
std::optional<ContactOpening> open_without_contact_from(const OpenedWall& start, const fem::ElasticProblem& problem,
    ContactMode mode, const ContactSurfaces& surfaces, const OpenOnce& open, const Job& job);

} // namespace retractor::planner
