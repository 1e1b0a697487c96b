#pragma once
// Hinges of bones: a bone resists a turn about one axis, weakly in a range and strongly at a stop beyond it. Units mm,
// N, rad; frame of the mesh. The springs that hold the hinge's points in place are supports of their own
// (boundary_conditions.h).
//
// A hinge is a torque that is spread over edges of the bone. The energy of an edge is its share of W(theta). Here theta
// is the angle that the edge, seen along the axis, has swept about the axis. The shares of a hinge add up to one, so a
// bone that turns as a rigid body by theta has the energy W(theta) and the torque dW/dtheta, wherever the axis lies and
// however large the turn is (below half a turn). A translation has no energy. Two nodes of an element are coupled
// already, so a hinge adds no entries to the stiffness.
//
// The torque is linear with a stop. Beyond the range the stop adds T(phi), with phi the angle beyond the range:
//   T = K phi^2 / (4 l)  up to phi = 2 l,   T = K (phi - l)  beyond,
// the law of a ligament with a toe region [Blankevoort and Huiskes 1991, doi 10.1115/1.2894883]. Its torque and
// stiffness are continuous.

#include "fem/linear_algebra/block_matrix.h"
#include "mesh/base/geometry.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace retractor::fem {

struct HingeEdge {
    VertexId a = 0, b = 0; ///< two nodes of one element, not on a line along the axis
    double share = 0.0; ///< of the hinge's torque, > 0
};

struct Hinge {
    std::string name {}; ///< of the bone
    Vec3 axis = Vec3::UnitX(); ///< unit vector at rest; it does not turn
    double stiffness = 0.0; ///< N mm/rad, at every angle, >= 0
    double range = 0.0; ///< angle without a stop, rad, >= 0
    double stop_stiffness = 0.0; ///< N mm/rad, K above, >= 0
    double toe = 0.0; ///< l above, rad, > 0
    /// The shares add up to one. In a part of a body (hinges_within()) they add up to the part's share of the torque.
    std::vector<HingeEdge> edges {};
};

/// Energy (N mm), torque (N mm) and stiffness (N mm/rad) of a hinge at an angle (rad).
struct HingeTorque {
    double energy = 0.0, torque = 0.0, stiffness = 0.0;
};
HingeTorque hinge_torque(const Hinge& hinge, double angle);

/// Checks hinges against a mesh.
/// @throws InputError naming the hinge: an axis that is no unit vector, a parameter out of range, shares that add
/// up to more than one, an edge whose nodes share no element, or an edge along the axis
void check_hinges(const mesh::TetMesh& mesh, std::span<const Hinge> hinges);

/// The hinges of a part of a body: without the edges whose nodes share no element of the part. A hinge without edges is
/// left out.
/// @param hinges nodes that are not in the mesh are negative
std::vector<Hinge> hinges_within(const mesh::TetMesh& mesh, std::vector<Hinge> hinges);

/// The hinges on a mesh that was cut: as hinges_within(), and the shares of the edges that are left grow in proportion
/// until they add up to one.
std::vector<Hinge> joined_hinges(const mesh::TetMesh& mesh, std::vector<Hinge> hinges);

/// How a hinge's angle depends on the displacement.
enum class HingeAngle {
    swept, ///< the angle between the edges, at any size
    linear, ///< its derivative at rest times the displacement, and no stop: for linear bodies
};

/// The mean of the angle over the edges, by their shares, rad. @param displacement three per node, mm
double hinge_turn(const mesh::TetMesh& mesh, const Hinge& hinge, const Eigen::VectorXd& displacement);

/// Adds the derivative of the energy to `forces` (N). @return the energy, N mm; infinite where an edge lies along the
/// axis and has no angle
double add_hinge_response(const mesh::TetMesh& mesh, const Hinge& hinge, HingeAngle angle,
    const Eigen::VectorXd& displacement, Eigen::VectorXd& forces);

/// Adds the second derivative of the energy. @param projected as ElasticBody::stiffness()
/// @pre the pattern couples the nodes of each element
void add_hinge_stiffness(const mesh::TetMesh& mesh, const Hinge& hinge, HingeAngle angle,
    const Eigen::VectorXd& displacement, double projected, BlockMatrix& stiffness);

/// An edge of a hinge at rest as a spring: the energy is (spring . (u_b - u_a))^2 / 2.
/// @param along the vector from node a to node b at rest, mm
/// @return the square root of N/mm
Vec3 hinge_spring(const Hinge& hinge, const HingeEdge& edge, const Vec3& along);

} // namespace retractor::fem
