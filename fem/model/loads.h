#pragma once
// Loads from outside: forces that keep their direction and size, given per node, and pressure that follows the surface
// it acts on. Units mm, N, MPa. Vectors have three entries per node.
//
// Follower pressure pushes with -p n per deformed area. Its force is the derivative of p V, V = 1/3 of the integral of
// x . n over the faces, but for what their rim adds: p/3 of the integral of dl x x along it. Of the stiffness of that
// the symmetric part is given an energy, a quadratic form of how the rim moves on, with the rim's shape that of the
// last renewal. What is left is skew, p/2 of the integral of dl . (a x b) for motions a and b [Bonet, Wood 1997, ch.
// 6.5]: nothing where the rim is held or in a plane of symmetry. It has no energy, and is a constant force within a
// Newton step, renewed after it (equilibrium.h). That converges by a constant factor per step, some small multiple of
// the pressure over the modulus of a free rim's tissue, wherever the rim lies.

#include "fem/linear_algebra/block_matrix.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <span>
#include <string>
#include <vector>

namespace retractor::fem {

/// Consistent nodal loads of a traction, MPa, on boundary faces at rest. @throws InputError as FollowerPressure does.
Eigen::VectorXd traction_loads(
    const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& faces, const Vec3& traction);

/// A force per area at rest that keeps its direction.
struct FaceTraction {
    mesh::TetFace face;
    Vec3 traction = Vec3::Zero(); ///< MPa
};

/// Consistent nodal loads of tractions, each on its own face. P1 and P2.
/// @throws InputError on a face that is not in the mesh, or a traction that is not finite.
Eigen::VectorXd traction_loads(const mesh::TetMesh& mesh, std::span<const FaceTraction> tractions);

inline constexpr double kKiloPascal = 1e-3; ///< MPa

class FollowerPressure {
public:
    /// @param pressure MPa; positive pushes into the body.
    /// @throws InputError naming the face that is not on the boundary, and on a pressure that is not finite.
    FollowerPressure(const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& faces, double pressure);

    /// Takes the rim's shape at u for the rim's part of the energy; until then it is that at rest.
    void renew_rim(const Eigen::VectorXd& u);
    /// Energy, p times the volume gained since rest and the rim's part; its derivative is added to `gradient`, times
    /// `share`.
    double add_response(const Eigen::VectorXd& u, double share, Eigen::VectorXd& gradient) const;
    /// Adds `share` times the second derivative of the energy.
    void add_stiffness(const Eigen::VectorXd& u, double share, BlockMatrix& K) const;
    /// The force itself.
    Eigen::VectorXd force(const Eigen::VectorXd& u) const;

private:
    template <class F> void for_each_point(const Eigen::VectorXd& u, const F& f) const;
    template <class F> void for_each_rim_point(const Eigen::VectorXd& u, const F& f) const;

    Points rest_; ///< from the middle of the faces, which V is taken about
    std::vector<VertexId> nodes_; ///< of each face: 3, or 6 with the midpoints after the corners
    std::size_t nodes_per_face_ = 3;
    std::vector<VertexId> rim_; ///< of each side that one face has: its ends as the face goes round, and its midpoint
    Eigen::VectorXd rim_at_; ///< displacement at the last renewal
    double pressure_ = 0.0;
};

/// Pressure on part of a body's surface, which it follows.
struct SurfacePressure {
    std::string name; ///< what presses, for messages
    std::vector<mesh::TetFace> faces; ///< on the boundary
    double pressure = 0.0; ///< MPa; positive pushes into the body
};

struct ExternalLoads {
    Eigen::VectorXd nodal {}; ///< N; empty: none
    std::vector<FollowerPressure> pressures {};

    bool empty() const { return nodal.size() == 0 && pressures.empty(); }
};

} // namespace retractor::fem
