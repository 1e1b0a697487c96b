#pragma once
// A lung that is held aside does not vanish: without air it shrinks towards its hilum, where bronchus and vessels
// enter, and a hand or a pad holds it away from the line of sight. Units mm; frame patient LPS.
//
// The deflated lung is the lung of the CT, made smaller about its hilum and shifted straight away from the line from
// the incision's middle to the target's, within the room that it had. How a lung folds and sinks is left out. The share
// of the volume that it keeps and the reach of the hand are assumptions of ours, so views are compared at three shares.

#include "mesh/base/geometry.h"
#include "planner/anatomy/anatomy.h"
#include "planner/case/approach.h"
#include "planner/case/patient.h"

#include <array>
#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// Share of its volume in the CT that a lung without air keeps (ours: tissue and blood are a tenth to a fifth of a lung
/// in inspiration, and some air stays).
inline constexpr double kDeflatedLungShare = 0.3;
/// Other shares that views are compared at.
inline constexpr std::array<double, 2> kOtherLungShares { 0.2, 0.5 };
/// How far a hand holds a lung away, mm (ours).
inline constexpr double kHeldAwayMm = 60.0;

/// About the hilum of a lung: the place of its surface that is nearest to the lower end of the windpipe, where the
/// bronchi part; without a windpipe, nearest to the chest's middle at the height of the lung's own middle, and a third
/// of the lung's depth from its back.
/// @param lung surfaces of the lung or of its lobes; at least one vertex
/// @param windpipe may be null
Vec3 hilum(std::span<const TriMesh* const> lung, const TriMesh* windpipe, const AnatomicalFrame& frame);

/// The surface made smaller towards a point, so that it holds this share of its volume.
/// @throws InputError on a share that is not above 0 and at most 1
TriMesh shrunk(TriMesh surface, const Vec3& towards, double volume_share);

/// The shift, mm, of a deflated lung straight away from the line through two places: at most kHeldAwayMm, and no
/// farther than the lung reached before to the patient's left or right, front or back, head or feet.
/// @param whole, deflated the lung or its lobes, before and after; at least one vertex each
Vec3 held_away(std::span<const TriMesh* const> whole, std::span<const TriMesh> deflated, const Vec3& from,
    const Vec3& to, const AnatomicalFrame& frame);

/// The label of a deflated lung's name: "lung_left" of "lung_left_deflated"; another name is its own label.
std::string label_of_deflated(const std::string& name);

struct DeflatedLung {
    std::string label; ///< lung or lobe
    std::string name; ///< "lung_left_deflated"
    std::string material;
    TriMesh surface;
};

/// The lungs and lobes that the approach holds aside, but for the one that is operated on. Lobes of one side shrink
/// towards one hilum and are held away together.
/// @pre the approach has an incision
/// @throws as Patient::organ(), Patient::target() and Patient::frame(), and as shrunk()
std::vector<DeflatedLung> deflated_lungs(
    const Approach& approach, Patient& patient, double volume_share = kDeflatedLungShare);

} // namespace retractor::planner
