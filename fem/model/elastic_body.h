#pragma once
// A mesh with its materials: energy, internal forces and stiffness as functions of the displacement, assembled by
// direct scatter. Units mm, N, MPa. Vectors have three entries per node. Results do not depend on the number of
// threads: elements are always summed in the same two halves.

#include "fem/element/corotational_elements.h"
#include "fem/element/locking_free.h"
#include "fem/element/tet_element.h"
#include "fem/linear_algebra/block_matrix.h"
#include "fem/material/elasticity.h"
#include "fem/material/hyperelasticity.h"
#include "fem/model/contact.h"
#include "fem/model/loads.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace retractor::fem {

/// What the elements of a mesh are made of, by hyperelastic laws.
struct HyperelasticTissue {
    std::vector<Hyperelastic> laws;
    std::vector<std::int32_t> law_of_element; ///< index into `laws`, one per element
    std::vector<FibreDirections> fibres {}; ///< one per element; empty: along x (laws without fibres do not ask)
};

class ElasticBody {
public:
    /// Linear, corotational or bounded. @param lame_of_element one per element.
    /// @throws InputError naming the element that is turned over at a quadrature point.
    ElasticBody(const mesh::TetMesh& mesh, Elasticity model, std::vector<Lame> lame_of_element);

    /// Hyperelastic. The energy is infinite where det F <= 0 at a quadrature point, and a line search on it never turns
    /// one over.
    /// @throws InputError as above, and naming the law, element or fibre that is out of its range.
    ElasticBody(const mesh::TetMesh& mesh, HyperelasticTissue tissue);

    /// Springs that draw each node back to where it was: what the body rests on and is not modelled (a Winkler bed).
    /// @param stiffness one per node, N/mm, the same in every direction; empty: none.
    /// @throws InputError on a wrong number, a negative or infinite value.
    void set_bed(std::vector<double> stiffness);

    /// Loads from outside; their energy, forces and stiffness are part of what response() and stiffness() give. On a
    /// linear body pressure acts on the shape at rest. The share that acts starts at 1.
    /// @throws InputError on a wrong number of nodal loads or one that is not finite.
    void set_loads(ExternalLoads loads);
    bool has_loads() const { return !loads_.empty(); }
    void set_load_share(double share) { load_share_ = share; }
    /// Renews the part of follower pressure that has no energy (loads.h). @return the largest change at a node, N.
    double renew_follower_loads(const Eigen::VectorXd& displacement);

    /// Contact of the body's surface; its energy, forces and stiffness are part of what response() and stiffness()
    /// give.
    /// Locking-free elements are assembled by themselves then: their pattern is a part of the whole.
    void set_contact(Contact contact);
    const Contact* contact() const { return contact_ ? &*contact_ : nullptr; }
    /// Contact::find(); where the pairs are others, the pattern of the stiffness is too.
    bool find_contact(const Eigen::VectorXd& displacement, Contact::Pairing pairing = Contact::Pairing::all_anew);

    /// Replaces four-node elements by locking-free ones (locking_free.h), whose matrix has more entries.
    /// @throws InputError on other than four-node elements and bounded elasticity.
    void avoid_locking(const AveragingScheme& scheme = edge_patch_domains);

    Elasticity model() const { return model_; }
    const mesh::TetMesh& mesh() const { return mesh_; }

    struct Response {
        double energy = 0.0; ///< of tissue, bed, loads and contact, N mm
        Eigen::VectorXd forces; ///< the derivative of the energy: internal forces less external ones, N
    };
    Response response(const Eigen::VectorXd& displacement) const;

    /// The stiffness at this displacement; its negative eigenvalues, element by element, are lifted by the share
    /// `projected` of their size (0: the true stiffness, 1: the nearest positive semidefinite one).
    /// The pattern and the element map are built by the first call; the result is overwritten by the next.
    const BlockMatrix& stiffness(const Eigen::VectorXd& displacement, double projected);
    const BlockMatrix& last_stiffness() const { return stiffness_; }

    /// Deformation of each element.
    struct Deformation {
        std::vector<double> strain; ///< largest principal Green-Lagrange strain, mean over the element
        std::vector<double> smallest_ratio, largest_ratio; ///< of det F over the quadrature points
        std::vector<double> volume; ///< rest, mm^3
    };
    Deformation deformation(const Eigen::VectorXd& displacement) const;

    std::size_t bytes() const;

private:
    void measure_elements();
    void make_pattern();
    template <int Nodes>
    void add_stiffness(
        const Eigen::VectorXd& u, double projected, std::size_t begin, std::size_t end, double* values) const;
    template <int Nodes> void add_linear(std::size_t begin, std::size_t end, double* values) const;
    template <int Nodes>
    void add_corotational(
        const Eigen::VectorXd& u, double projected, std::size_t begin, std::size_t end, double* values) const;
    template <int Nodes>
    void add_hyperelastic(
        const Eigen::VectorXd& u, double projected, std::size_t begin, std::size_t end, double* values) const;
    /// Calls f(element, quadrature point, F, energy density, stress) for a range of elements.
    template <class F>
    void for_each_point(const Eigen::VectorXd& u, std::size_t begin, std::size_t end, const F& f) const;
    void add_loads(const Eigen::VectorXd& u, Response& response) const;
    Mat3 deformation_gradient(const Eigen::VectorXd& u, std::size_t element, std::size_t point) const;
    const double* gradients(std::size_t element, std::size_t point) const;

    mesh::TetMesh mesh_;
    Elasticity model_;
    std::vector<Lame> lame_; ///< one per element; empty: hyperelastic
    HyperelasticTissue tissue_;
    std::vector<double> bed_; ///< per node, N/mm; empty: none
    ExternalLoads loads_;
    Eigen::VectorXd follower_; ///< nodal loads of pressure beyond the derivative of its energy; empty: none
    double load_share_ = 1.0;
    std::size_t nodes_per_tet_ = 0, points_per_tet_ = 0;
    std::vector<double> gradients_; ///< element, quadrature point, node, axis
    std::vector<double> weights_; ///< element, quadrature point: rest volume, mm^3
    std::optional<CorotationalElements> bounded_; ///< four-node elements of the bounded model
    std::optional<LockingFree> locking_free_;
    std::optional<Contact> contact_;
    BlockPattern elements_pattern_; ///< without contact; kept where there is some
    std::vector<std::int32_t> map_;
    BlockMatrix stiffness_;
    std::vector<double> second_half_; ///< values of the elements' second half, before they are added
};

} // namespace retractor::fem
