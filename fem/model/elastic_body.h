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
#include "fem/model/blade_contact.h"
#include "fem/model/contact.h"
#include "fem/model/hinge.h"
#include "fem/model/loads.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace retractor::fem {

/// Hyperelastic laws and fibre directions of the elements of a mesh.
struct HyperelasticTissue {
    std::vector<Hyperelastic> laws;
    std::vector<std::int32_t> law_of_element; ///< index into `laws`, one per element
    std::vector<FibreDirections> fibres {}; ///< one per element; empty: along x, which only laws with fibres use
};

/// Treatment of points that are stretched or pressed beyond twice.
enum class Extremes { as_they_are, raised };

class ElasticBody {
public:
    /// A body of the linear, corotational or corotational_linear model.
    /// @param lame_of_element one per element.
    /// @throws InputError naming an element that is inverted at a quadrature point.
    ElasticBody(const mesh::TetMesh& mesh, Elasticity model, std::vector<Lame> lame_of_element);

    /// A hyperelastic body. The energy is infinite where det F <= 0 at a quadrature point, so a line search on the
    /// energy never inverts an element.
    /// @throws InputError as above, and naming a law, element or fibre that is out of range.
    ElasticBody(const mesh::TetMesh& mesh, HyperelasticTissue tissue);

    /// Adds springs that pull each node back to its rest position: a Winkler bed that stands for tissue outside the
    /// model.
    /// @param stiffness one per node, N/mm, equal in all directions; empty: no springs.
    /// @throws InputError on a wrong number of values, or a negative or infinite value.
    void set_bed(std::vector<double> stiffness);

    /// Adds hinges (hinge.h). A linear body receives their stiffness at rest, without stops.
    /// @throws InputError as check_hinges()
    void set_hinges(std::vector<Hinge> hinges);

    /// External loads. response() and stiffness() include their energy, forces and stiffness. On a linear body
    /// pressure acts on the shape at rest. The share of the loads that acts starts at 1.
    /// @throws InputError on a wrong number of nodal loads, or a load that is not finite.
    void set_loads(ExternalLoads loads);
    bool has_loads() const { return !loads_.empty(); }
    void set_load_share(double share) { load_share_ = share; }
    /// Updates the part of follower pressure that has no energy (loads.h).
    /// @return the largest change of the force at a node, N.
    double renew_follower_loads(const Eigen::VectorXd& displacement);

    /// Contact of the body's surface. response() and stiffness() include its energy, forces and stiffness.
    /// Locking-free elements are then assembled separately, as with blades: their pattern is a part of the whole one.
    void set_contact(Contact contact);
    const Contact* contact() const { return contact_ ? &*contact_ : nullptr; }
    /// Calls Contact::find(). A change of the pairs changes the pattern of the stiffness where the present pattern does
    /// not couple the nodes of a pair.
    /// @return whether the pairs changed.
    bool find_contact(const Eigen::VectorXd& displacement, Contact::Pairing pairing = Contact::Pairing::all_anew);
    /// How often the pattern of the stiffness was made. A solver analyses the pattern again when the number changes.
    std::size_t patterns_made() const { return patterns_made_; }

    /// Rigid blades that push the body. response() and stiffness() include their energy, forces and stiffness, also at
    /// the blades' own nodes.
    void set_blades(BladeContact blades);
    const BladeContact* blades() const { return blades_ ? &*blades_ : nullptr; }
    /// Calls BladeContact::renew().
    void renew_blades(const Eigen::VectorXd& displacement, double share = 1.0)
    {
        if (blades_)
            blades_->renew(displacement, share);
    }
    /// Calls BladeContact::expect() or, without a displacement, expect_nothing().
    void expect_blades(const Eigen::VectorXd* displacement);
    /// Calls BladeContact::prepare_search().
    void prepare_blade_search(const Eigen::VectorXd& displacement);

    /// Replaces four-node elements by locking-free elements (locking_free.h), whose matrix has more entries.
    /// @throws InputError on ten-node elements and on the corotational_linear model.
    void avoid_locking(const AveragingScheme& scheme = edge_patch_domains);

    Elasticity model() const { return model_; }
    const mesh::TetMesh& mesh() const { return mesh_; }

    /// Whether part() can be taken: of linear and corotational elements without avoid_locking().
    bool has_parts() const { return model_ != Elasticity::hyperelastic && !corotational_linear_ && !locking_free_; }
    /// Multiplies the stiffness of some elements. @pre has_parts()
    void stiffen(std::span<const TetId> elements, double factor);
    /// Some elements as a body of their own, without bed, hinges, loads, contact and blades.
    /// @param nodes receives the node of this body for each node of the part, ascending. @pre has_parts()
    ElasticBody part(const std::vector<TetId>& elements, std::vector<VertexId>& nodes) const;
    /// One flag per node: 1 where something else than elements acts at this displacement, such as a load, a spring, a
    /// contact or a blade.
    std::vector<std::uint8_t> touched_nodes(const Eigen::VectorXd& displacement) const;

    struct Response {
        double energy = 0.0; ///< energy of tissue, bed, hinges, loads, contact and blades, N mm
        Eigen::VectorXd forces; ///< derivative of the energy: internal forces minus external forces, N
    };
    Response response(const Eigen::VectorXd& displacement) const;

    /// The stiffness at a displacement. The first call builds the pattern and the element map; the next call
    /// overwrites the result.
    /// @param projected the share of their size by which negative eigenvalues are raised, element by element: 0 gives
    /// the true stiffness, 1 the nearest positive semidefinite one.
    /// @param extremes as they are, or with tangent_raised_at_extremes(): a stiffness for iterations. Locking-free and
    /// hyperelastic elements are always taken as they are.
    const BlockMatrix& stiffness(
        const Eigen::VectorXd& displacement, double projected, Extremes extremes = Extremes::as_they_are);
    const BlockMatrix& last_stiffness() const { return stiffness_; }

    /// Deformation of each element.
    struct Deformation {
        /// largest principal value of the Green-Lagrange strain, which is averaged over the element
        std::vector<double> strain;
        std::vector<double> smallest_ratio, largest_ratio; ///< extremes of det F over the quadrature points
        std::vector<double> volume; ///< rest volume, mm^3
        std::vector<double> volume_ratio; ///< deformed volume over rest volume: the mean of det F over the element
    };
    Deformation deformation(const Eigen::VectorXd& displacement) const;

    std::size_t bytes() const;

private:
    void measure_elements();
    void make_pattern();
    void add_elements(const Eigen::VectorXd& u, double projected, Extremes extremes);
    template <int Nodes>
    void add_stiffness(const Eigen::VectorXd& u, double projected, Extremes extremes, std::size_t begin,
        std::size_t end, double* values) const;
    template <int Nodes> void add_linear(std::size_t begin, std::size_t end, double* values) const;
    template <int Nodes>
    void add_corotational(const Eigen::VectorXd& u, double projected, Extremes extremes, std::size_t begin,
        std::size_t end, double* values) const;
    template <int Nodes>
    void add_hyperelastic(
        const Eigen::VectorXd& u, double projected, std::size_t begin, std::size_t end, double* values) const;
    /// Calls f(element, quadrature point, F, energy density, stress) for a range of elements.
    template <class F>
    void for_each_point(const Eigen::VectorXd& u, std::size_t begin, std::size_t end, const F& f) const;
    void add_surroundings(const Eigen::VectorXd& u, Response& response) const;
    void add_loads(const Eigen::VectorXd& u, Response& response) const;
    Mat3 deformation_gradient(const Eigen::VectorXd& u, std::size_t element, std::size_t point) const;
    const double* gradients(std::size_t element, std::size_t point) const;
    std::size_t points_of(std::size_t element) const; ///< quadrature points
    std::size_t nodes_of(std::size_t element) const; ///< nodes whose functions are not zero: they come first
    HingeAngle hinge_angle() const { return model_ == Elasticity::linear ? HingeAngle::linear : HingeAngle::swept; }

    mesh::TetMesh mesh_;
    Elasticity model_;
    std::vector<Lame> lame_; ///< one per element; empty for a hyperelastic body
    HyperelasticTissue tissue_;
    std::vector<double> bed_; ///< stiffness per node, N/mm; empty: no bed
    std::vector<Hinge> hinges_;
    ExternalLoads loads_;
    Eigen::VectorXd follower_; ///< nodal loads of the pressure without energy, N; empty: none
    double load_share_ = 1.0;
    std::size_t nodes_per_tet_ = 0, points_per_tet_ = 0;
    std::vector<double> gradients_; ///< ordered by element, quadrature point, node, axis; 1/mm
    /// rest volume by element and quadrature point, mm^3; an element whose edges are straight has all at its first
    /// point
    std::vector<double> weights_;
    std::vector<std::uint8_t> is_straight_; ///< one per element: 1 where ten entries have no midpoint (tet_mesh.h)
    std::optional<CorotationalElements>
        corotational_linear_; ///< set for four-node elements of the corotational_linear model
    std::optional<LockingFree> locking_free_;
    std::optional<Contact> contact_;
    std::optional<BladeContact> blades_;
    BlockPattern elements_pattern_; ///< pattern of the elements alone, kept when there is contact or a blade
    std::vector<std::int32_t> map_;
    std::size_t patterns_made_ = 0;
    BlockMatrix stiffness_;
    std::vector<double> second_half_; ///< matrix values of the second half of the elements, before they are added
};

} // namespace retractor::fem
