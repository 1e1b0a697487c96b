#pragma once
// Four-node tetrahedra that do not lock in nearly incompressible tissue: strain is averaged over domains that span
// several elements. Units mm, N, MPa.
//
// edge_patch_domains() takes the distortional energy at the volume-weighted mean strain of the elements round each
// edge [edge-based smoothing, after the face-based smoothing of Nguyen-Thoi, Liu, Vu-Do, Nguyen-Xuan 2009, doi
// 10.1016/j.cma.2009.07.001]. The volumetric energy is taken at the mean volume ratio of disjoint patches of up to
// eight elements [de Souza Neto, Andrade Pires, Owen 2005, doi 10.1002/nme.1187; here derived from an energy, so that
// the stiffness is symmetric]. A share of 0.05 of the distortional energy is taken element by element, which keeps
// elements from turning over. No domain spans two laws. A caller can give other domains: retractor-verify also solves
// with domains round each node ("nodal P1").
//
// Edges and patches were chosen by measurement. `retractor-verify` still shows these errors:
// - Thick tube, 288 elements, at nu 0.3 / 0.49 / 0.4999: plain P1 0.4 / 4.7 / 17 %, edges and patches below 0.01 % at
//   each, nodal 0.3 / 0.3 / 3.0 %, P2 below 0.01 %.
// - Cook's membrane, 1,536 elements: plain P1 -11.9 %, edges and patches -1.1 %, nodal +0.03 %.
// - Bending beam of 3,973 elements, nu 0.49 (FEBio te02), deflection in mm: plain P1 48.05, edges and patches 89.97,
//   nodal 97.91.
// Two schemes were measured and rejected. Volume averaged round nodes alone [Bonet, Burton 1998] has errors of 0.3 /
// 0.4 / 4.6 % in the tube and deflects the beam by 77.1 mm. Volume averaged over patches alone has errors of 0.3 /
// 0.5 / 0.5 % and deflects the beam by 78.1 mm. A mixed element with pressure unknowns (MINI) was not measured:
// CHOLMOD does not factorise its indefinite matrix.
// The matrix has about four times the entries of plain P1, and a solution takes several times as long (24,576
// elements, linear: retractor-verify --problem manufactured). P2 on the same mesh takes longer still.

#include "fem/linear_algebra/block_matrix.h"
#include "fem/material/elasticity.h"
#include "fem/material/hyperelasticity.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace retractor::fem {

/// A set of elements of one law, round an edge or a node, over which strain is averaged.
struct AveragingDomain {
    std::int32_t law = 0;
    /// share of each element's volume that belongs to this domain; the shares of an element sum to 1
    double part = 1.0;
    std::vector<TetId> tets {};
    std::int32_t patch = 0; ///< all domains with the same patch and law have one common volume ratio
};

/// Divides the elements of a mesh into domains.
/// @param law_of_element one per element.
/// @param volume one per element, mm^3.
using AveragingScheme = std::function<std::vector<AveragingDomain>(
    const mesh::TetMesh& mesh, const std::vector<std::int32_t>& law_of_element, const std::vector<double>& volume)>;

/// One domain of elements round each edge, in the order of the edges. The domain belongs to the patch that contains
/// most of its volume.
std::vector<AveragingDomain> edge_patch_domains(
    const mesh::TetMesh& mesh, const std::vector<std::int32_t>& law_of_element, const std::vector<double>& volume);

/// The elasticity at a point: Lame's parameters for the linear and corotational models, otherwise a hyperelastic law.
struct PointLaw {
    Elasticity model = Elasticity::linear;
    Lame lame {};
    Hyperelastic hyperelastic {};
};

class LockingFree {
public:
    struct Elements;

    /// @param law_of_element index into `laws`, one per element.
    /// @param fibres one per element; empty: laws without fibres.
    /// @throws InputError when the mesh does not consist of four-node elements.
    LockingFree(const mesh::TetMesh& mesh, const AveragingScheme& scheme, std::vector<PointLaw> laws,
        const std::vector<std::int32_t>& law_of_element, const std::vector<FibreDirections>& fibres);

    /// Adds the derivative of the energy by u to `forces` (N). @return the energy, N mm.
    double add_response(const Eigen::VectorXd& u, Eigen::VectorXd& forces) const;

    BlockPattern pattern() const;
    /// Adds the stiffness to the zeroed values of pattern(). Negative eigenvalues are raised as in
    /// ElasticBody::stiffness().
    void add_stiffness(const Eigen::VectorXd& u, double projected, BlockMatrix& matrix);

    std::size_t bytes() const;

private:
    struct VolumeState {
        double energy = 0.0;
        /// derivatives of the volumetric energy by the volume ratio, per volume domain
        std::vector<double> slope, curvature;
        std::vector<double> pressure; ///< per strain point: mean slope of its volume domains, MPa
    };
    std::int32_t add_point(const mesh::TetMesh& mesh, const Elements& elements, const AveragingDomain& domain,
        double scale, const std::vector<FibreDirections>& fibres);
    void gather_volumes(std::vector<std::pair<std::array<std::int32_t, 2>, std::int32_t>> members);
    Mat3 deformation_gradient(const Eigen::VectorXd& u, std::size_t point) const;
    VolumeState volumes(const Eigen::VectorXd& u) const;
    void add_points(const Eigen::VectorXd& u, const VolumeState& state, double projected, std::size_t begin,
        std::size_t end, double* values) const;
    void add_volumes(
        const Eigen::VectorXd& u, const VolumeState& state, std::size_t begin, std::size_t end, double* values) const;

    std::size_t node_count_ = 0;
    std::vector<PointLaw> laws_; ///< laws without their volumetric energy
    std::vector<double> stiffness_; ///< bulk stiffness of the volumetric energy, per law, MPa

    // Strain points, at which the distortional energy is taken.
    NodeGroups points_; ///< nodes of each strain point
    std::vector<double> gradients_; ///< gradients of the shape functions, three per entry of points_.node, 1/mm
    std::vector<double> weights_; ///< weight of each strain point, mm^3
    std::vector<std::int32_t> law_of_point_;
    std::vector<FibreDirections> fibres_;

    // Volume domains, at which the volumetric energy is taken. Each domain is a set of strain points.
    NodeGroups domains_; ///< nodes of each volume domain
    std::vector<double> domain_volume_; ///< mm^3
    std::vector<std::int32_t> law_of_domain_;
    std::vector<std::int32_t> member_start_, member_; ///< strain points of each volume domain
    double share_ = 1.0; ///< share of a strain point's weight that counts in its domain

    std::vector<std::int32_t> point_map_, domain_map_;
    std::vector<double> second_half_;
};

} // namespace retractor::fem
