#pragma once
// Four-node tetrahedra that do not lock where tissue is nearly incompressible: strain is averaged over domains that
// span several elements. Units mm, N, MPa.
//
// edge_patch_domains: the energy of shape is taken at the strain averaged over the elements round each edge, by
// volume [edge-based smoothing: Nguyen-Thoi, Liu, Vu-Do, Nguyen-Xuan 2009, doi 10.1016/j.cma.2009.07.001 for faces],
// and the energy of volume at the mean volume ratio of disjoint patches of up to eight elements [de Souza Neto, Andrade
// Pires, Owen 2005, doi 10.1002/nme.1187, here with an energy, so that the stiffness is symmetric].
// A share of 0.05 of the energy of shape is taken element by element, which keeps elements from turning over. No domain
// spans two laws. Other domains can be given: retractor-verify solves with those round each node ("nodal P1").
//
// Why edges and patches, measured. `retractor-verify` shows what was kept: thick tube, 288 elements, error at nu 0.3
// / 0.49 / 0.4999: plain P1 0.4 / 4.7 / 17 %, edges and patches below 0.01 % at each, nodal 0.3 / 0.3 / 3.0 %, P2
// below 0.01 %; Cook's membrane, 1,536 elements: plain P1 -11.9 %, edges and patches -1.1 %, nodal +0.03 %; bending
// beam of 3,973 elements, nu 0.49 (FEBio te02), mm: plain P1 48.05, edges and patches 89.97, nodal 97.91. What was
// not kept, measured once: volume averaged round nodes alone [Bonet, Burton 1998] 0.3 / 0.4 / 4.6 % in the tube and
// 77.1 in the beam, over patches alone 0.3 / 0.5 / 0.5 % and 78.1. A mixed element with pressure unknowns (MINI) was
// not measured: its matrix is indefinite, which CHOLMOD does not factorise.
// The price is a matrix with about four times the entries of plain P1, and several times its run time (the same 24,576
// elements, linear: retractor-verify --problem manufactured); P2 on the same mesh takes longer still.

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

/// What strain is averaged over: elements of one law round an edge or a node.
struct AveragingDomain {
    std::int32_t law = 0;
    double part = 1.0; ///< of each element's volume that belongs to this domain; the parts of an element add up to 1
    std::vector<TetId> tets {};
    std::int32_t patch = 0; ///< domains of one patch and one law have one volume ratio
};

/// Divides the elements of a mesh into domains. @param law_of_element, volume one per element, mm^3.
using AveragingScheme = std::function<std::vector<AveragingDomain>(
    const mesh::TetMesh& mesh, const std::vector<std::int32_t>& law_of_element, const std::vector<double>& volume)>;

/// Elements round each edge, in the order of the edges; each domain is in the patch that most of its volume lies in.
std::vector<AveragingDomain> edge_patch_domains(
    const mesh::TetMesh& mesh, const std::vector<std::int32_t>& law_of_element, const std::vector<double>& volume);

/// What a point is made of: Lame's parameters for the linear and corotational models, else a law.
struct PointLaw {
    Elasticity model = Elasticity::linear;
    Lame lame {};
    Hyperelastic hyperelastic {};
};

class LockingFree {
public:
    struct Elements;

    /// @param law_of_element index into `laws`, one per element. @param fibres one per element; empty: none.
    /// @throws InputError when the mesh is not of four-node elements.
    LockingFree(const mesh::TetMesh& mesh, const AveragingScheme& scheme, std::vector<PointLaw> laws,
        const std::vector<std::int32_t>& law_of_element, const std::vector<FibreDirections>& fibres);

    /// Energy, N mm; its derivative is added to `forces`.
    double add_response(const Eigen::VectorXd& u, Eigen::VectorXd& forces) const;

    BlockPattern pattern() const;
    /// Adds the stiffness to zeroed values of pattern(); negative eigenvalues lifted as in ElasticBody::stiffness().
    void add_stiffness(const Eigen::VectorXd& u, double projected, BlockMatrix& matrix);

    std::size_t bytes() const;

private:
    struct VolumeState {
        double energy = 0.0;
        std::vector<double> slope, curvature; ///< of the volumetric energy by the volume ratio, per volume domain
        std::vector<double> pressure; ///< per strain point: the mean of its domains' slopes
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
    std::vector<PointLaw> laws_; ///< without their volumetric part
    std::vector<double> stiffness_; ///< of the volumetric part, per law, MPa

    // Strain points: where the energy of shape is taken.
    NodeGroups points_; ///< nodes of each
    std::vector<double> gradients_; ///< three per entry of points_.node
    std::vector<double> weights_; ///< mm^3
    std::vector<std::int32_t> law_of_point_;
    std::vector<FibreDirections> fibres_;

    // Volume domains: where the energy of volume is taken. Each is a set of strain points.
    NodeGroups domains_; ///< nodes of each
    std::vector<double> domain_volume_; ///< mm^3
    std::vector<std::int32_t> law_of_domain_;
    std::vector<std::int32_t> member_start_, member_; ///< strain points of each
    double share_ = 1.0; ///< what a strain point's weight counts for in its domain

    std::vector<std::int32_t> point_map_, domain_map_;
    std::vector<double> second_half_;
};

} // namespace retractor::fem
