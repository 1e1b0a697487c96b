#pragma once
// Equilibrium of a pre-strained spring network, frame by frame. Units mm, N.
//
// Newton's method: each step is solved with the springs' tangent by conjugate gradients, preconditioned by the
// diagonal blocks, and shortened until the energy falls [Armijo]. Tension stiffens a spring across its direction, and
// compression weakens the spring. The matrix omits the weakening and so is positive semidefinite: every step
// descends, however slack the springs are. Such a step equals an implicit Euler step with infinite time step, so the
// time step has no bound; the explicit scheme of tests/verification/framework/spring_dynamics.h has one. A frame may
// stop at its limit of conjugate gradient iterations; the next frame continues from the state reached.

#include "fem/springs/edge_springs.h"
#include "mesh/base/job.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace retractor::fem {

/// The springs round some vertices of a network, packed. All other vertices stay at their present positions. Vectors
/// have three entries per active vertex in the order given; entries along fixed axes are zero.
class SpringPatch {
public:
    /// @throws InputError on a vertex that is fixed, belongs to no element or is out of range.
    /// @pre `active` is sorted and has no duplicates
    SpringPatch(const SpringNetwork& network, std::vector<VertexId> active);

    const std::vector<VertexId>& active() const { return active_; }

    struct Response {
        double energy = 0.0; ///< energy relative to the rest state, minus the work of the loads on the lips, N mm
        Eigen::VectorXd forces; ///< derivative of the energy, N; zero in equilibrium
        int crushed = 0; ///< number of elements below SpringNetwork::kCrushed of their volume
        int inverted = 0; ///< number of these elements with zero or negative volume
    };
    Response response(const Eigen::VectorXd& u) const;

    /// Stores the tangent at u for multiply().
    /// @param true_tangent includes the weakening by compression; the tangent may then be indefinite. The penalty on
    /// crushed elements enters by its first derivatives only.
    void linearise(const Eigen::VectorXd& u, bool true_tangent = false);
    Eigen::VectorXd multiply(const Eigen::VectorXd& x) const;
    /// The inverses of the diagonal blocks, for use as a preconditioner.
    std::vector<Mat3> inverse_diagonal() const;
    /// displacement of the active vertices when the patch was made, mm
    Eigen::VectorXd displacement() const { return start_; }
    /// writes the displacement u (mm) into the network
    void store(const Eigen::VectorXd& u, SpringNetwork& network) const;

private:
    struct End {
        std::int32_t other = 0; ///< index of the other vertex: active vertices first, then the rim
        double length = 0.0, stiffness = 0.0, force_density = 0.0;
        Vec3 at_rest;
    };
    struct Element {
        std::array<std::int32_t, 4> nodes {};
        double volume = 0.0, penalty = 0.0;
    };
    struct Braced {
        std::array<std::int32_t, 4> nodes {};
        std::array<Vec3, 4> gradients { Vec3::Zero(), Vec3::Zero(), Vec3::Zero(),
            Vec3::Zero() }; ///< gradients of the corners' shape functions, 1/mm
        double stiffness = 0.0; ///< volume times brace, N mm
        std::array<std::int32_t, 16> entry {}; ///< entry() of each pair of corners
    };
    struct Crushed {
        std::array<std::int32_t, 4> nodes {};
        std::array<Vec3, 4> slope; ///< derivative of the volume ratio by each corner, 1/mm
        double force = 0.0, stiffness = 0.0;
    };
    using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    /// Place of a pair of corners in the matrix: the index of a spring end, or ends_.size() + vertex on the diagonal;
    /// -1: in no row.
    std::int32_t entry(std::int32_t row, std::int32_t column) const;
    Block& block(std::int32_t entry);
    Vec3 moved(std::int32_t node, const Eigen::VectorXd& u) const;
    Mat3 deformation(const Braced& element, const Eigen::VectorXd& u) const;
    std::vector<Crushed> crushed_elements(const Eigen::VectorXd& u, double& energy, int& inverted) const;

    void mask(Eigen::VectorXd& vector) const;

    std::vector<VertexId> active_, rim_;
    std::vector<Eigen::Index> held_; ///< unknowns of active vertices along fixed axes
    Eigen::VectorXd start_, rim_displacement_, load_;
    Points rest_; ///< rest positions of the active vertices, then of the rim, mm
    std::vector<std::size_t> row_;
    std::vector<End> ends_;
    /// blocks of the tangent: diagonal per active vertex, coupling per spring end
    std::vector<Block> diagonal_, coupling_;
    std::vector<Element> elements_;
    std::vector<Braced> braced_;
};

struct RelaxOptions {
    /// Largest unbalanced force of a free vertex, relative to the largest force released at a lip.
    double tolerance = 1e-3;
    int max_iterations = 5000; ///< conjugate gradient iterations of all Newton steps together: the budget of a frame
    /// Distance from the wound, mm, along edges at rest, within which vertices move; 0: all vertices move. A wound
    /// affects tissue as far away as the wound is long: with a reach of 10, 20, 40 mm an 80 mm cut in a free sheet
    /// gapes by 12, 23, 47 % of its full gape (`retractor-bench gape`). A limited reach therefore serves for a first
    /// impression only.
    double reach_mm = 0.0;
};

enum class RelaxStatus { converged, out_of_iterations, no_descent, cancelled };

struct [[nodiscard]] RelaxResult {
    RelaxStatus status = RelaxStatus::converged;
    std::string message;
    double residual = 0.0; ///< unbalanced force, relative as in RelaxOptions::tolerance
    double energy = 0.0; ///< N mm, never above the energy at the start
    int iterations = 0; ///< at least one per step of Newton's method
    std::size_t active = 0; ///< number of active vertices
    int inverted = 0; ///< number of elements with zero or negative volume
    double seconds = 0.0;
};

/// Moves the network from its present positions towards equilibrium. An undeformed network without a wound does not
/// move.
/// @throws InputError on options that are NaN or out of range.
RelaxResult relax(SpringNetwork& network, const RelaxOptions& options = {}, const Job& job = {});

/// Vertices that are free and belong to an element, within `reach_mm` of the wound along edges at rest, sorted by id;
/// 0: at any distance.
std::vector<VertexId> vertices_near_wound(const SpringNetwork& network, double reach_mm);

} // namespace retractor::fem
