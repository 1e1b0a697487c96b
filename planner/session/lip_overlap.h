#pragma once
// Whether the lips of a wound that is shown pass through each other: live answers have no contact between them
// (fem/contact.h has). Looked at where a cut has parted a vertex: how far its halves have moved into each other's lip,
// along the normal at rest, which is right for lips that have not turned far. Units mm; frame patient LPS.

#include "planner/session/hook_placement.h"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace retractor::planner {

/// The two halves of a vertex on facing lips.
struct LipPair {
    VertexId a = 0, b = 0;
    Vec3 normal = Vec3::UnitX(); ///< unit, from a's lip to b's
};

/// @param lips lip_triangles() of the session.
std::vector<LipPair> lip_pairs(const mesh::CutSession& session, std::span<const LipTriangle> lips);

/// The deepest overlap; 0 where none. @param displacement three per vertex id of the session, mm.
double lip_overlap_mm(std::span<const LipPair> pairs, const Eigen::VectorXd& displacement);

} // namespace retractor::planner
