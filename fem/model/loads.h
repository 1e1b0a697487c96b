#pragma once
// External loads: nodal forces with fixed direction and size, and pressure that follows the surface on which the
// pressure acts. Units mm, N, MPa. Vectors have three entries per node.
//
// Follower pressure exerts the traction -p n per deformed area. Up to a term of the rim, its force is the derivative
// of p V, where V is 1/3 of the integral of x . n over the faces. The rim's term is p/3 of the integral of dl x x
// along the rim. The symmetric part of the rim's stiffness has an energy: a quadratic form of the rim's motion since
// the last renewal, with the rim's shape at that renewal. The rest is skew, p/2 of the integral of dl . (a x b) for
// motions a and b [Bonet, Wood, Nonlinear continuum mechanics, 1997, ch. 6.5], and vanishes where the rim is held or
// lies in a plane of symmetry. The skew part has no energy. Its force is constant within a Newton step and renewed
// after the step (equilibrium.h). These renewals converge linearly, wherever the rim lies; the factor is a small
// multiple of the pressure over the modulus of the tissue at a free rim.

#include "fem/linear_algebra/block_matrix.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <span>
#include <string>
#include <vector>

namespace retractor::fem {

/// Consistent nodal loads of a traction, MPa, on boundary faces at rest.
/// @throws InputError as FollowerPressure does.
Eigen::VectorXd traction_loads(
    const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& faces, const Vec3& traction);

/// A force per area at rest that keeps its direction.
struct FaceTraction {
    mesh::TetFace face;
    Vec3 traction = Vec3::Zero(); ///< MPa
};

/// Consistent nodal loads of tractions, each on its own face, for four-node and ten-node elements.
/// @throws InputError on a face that is not in the mesh, or a traction that is not finite.
Eigen::VectorXd traction_loads(const mesh::TetMesh& mesh, std::span<const FaceTraction> tractions);

inline constexpr double kKiloPascal = 1e-3; ///< MPa

class FollowerPressure {
public:
    /// @param pressure MPa; positive pushes into the body.
    /// @throws InputError naming the face that is not on the boundary, and on a pressure that is not finite.
    FollowerPressure(const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& faces, double pressure);

    /// Sets the rim's shape in the energy to the shape at u. Before the first call the shape at rest is used.
    void renew_rim(const Eigen::VectorXd& u);
    /// Adds `share` times the derivative of the energy to `gradient`.
    /// @return the energy without the factor `share`: p times the increase of volume since rest, plus the rim's part,
    /// N mm.
    double add_response(const Eigen::VectorXd& u, double share, Eigen::VectorXd& gradient) const;
    /// Adds `share` times the second derivative of the energy.
    void add_stiffness(const Eigen::VectorXd& u, double share, BlockMatrix& K) const;
    /// The full force, including the part without energy, N.
    Eigen::VectorXd force(const Eigen::VectorXd& u) const;

private:
    template <class F> void for_each_point(const Eigen::VectorXd& u, const F& f) const;
    template <class F> void for_each_rim_point(const Eigen::VectorXd& u, const F& f) const;

    Points rest_; ///< rest positions relative to the middle of the faces; V is computed about this middle
    std::vector<VertexId> nodes_; ///< nodes of each face: 3, or 6 with the midpoints after the corners
    std::size_t nodes_per_face_ = 3;
    /// sides that belong to one face only: two ends in the order of the face, then the midpoint
    std::vector<VertexId> rim_;
    Eigen::VectorXd rim_at_; ///< displacement at the last renewal
    double pressure_ = 0.0;
};

/// Pressure on a part of a body's surface; the pressure follows the surface.
struct SurfacePressure {
    std::string name; ///< source of the pressure, for messages
    std::vector<mesh::TetFace> faces; ///< faces on the boundary
    double pressure = 0.0; ///< MPa; positive pushes into the body
};

struct ExternalLoads {
    Eigen::VectorXd nodal {}; ///< nodal forces, N; empty: none
    std::vector<FollowerPressure> pressures {};

    bool empty() const { return nodal.size() == 0 && pressures.empty(); }
};

} // namespace retractor::fem
