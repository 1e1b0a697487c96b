#pragma once
// Equilibrium of a pre-strained spring network, frame by frame. Units mm, N.
//
// Newton's method: each step solves with the springs' tangent by conjugate gradients (blocks of the diagonal as
// preconditioner) and is shortened until the energy falls [Armijo]. Tension stiffens a spring across its direction and
// compression weakens it; the weakening is left out of the matrix, so that it is positive semidefinite and every step
// descends, however slack the springs are. An implicit Euler step with an infinite time step is the same, so there is
// no bound on the step; the explicit scheme, which has one, is in tests/verification/framework/spring_dynamics.h.
// A frame may stop after so many iterations of conjugate gradients; what is reached is kept and the next frame goes on.

#include "fem/springs/edge_springs.h"
#include "mesh/base/job.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

namespace retractor::fem {

/// The springs round some vertices of a network, packed; the other vertices stand where they stand now.
/// Vectors have three entries per active vertex, in the order given; those along fixed axes are zero.
class SpringPatch {
public:
    /// @throws InputError on a fixed vertex, one of no element, or one out of range; @pre sorted, each once.
    SpringPatch(const SpringNetwork& network, std::vector<VertexId> active);

    const std::vector<VertexId>& active() const { return active_; }

    struct Response {
        double energy = 0.0; ///< N mm, against the rest state, less the work of the loads on the lips
        Eigen::VectorXd forces; ///< derivative of the energy, N: zero in equilibrium
        int crushed = 0; ///< elements below SpringNetwork::kCrushed of their volume
        int inverted = 0; ///< of these, with no volume or a negative one
    };
    Response response(const Eigen::VectorXd& u) const;

    /// Keeps the tangent at u for multiply(). @param true_tangent with the weakening by compression (it may then be
    /// indefinite); the penalty on crushed elements enters by its first derivatives only.
    void linearise(const Eigen::VectorXd& u, bool true_tangent = false);
    Eigen::VectorXd multiply(const Eigen::VectorXd& x) const;
    /// The inverses of the diagonal blocks: a preconditioner.
    std::vector<Mat3> inverse_diagonal() const;
    /// Upper bound on the largest eigenvalue of M^-1/2 K M^-1/2, by blocks [Gershgorin]; one mass per active vertex.
    double gershgorin(const std::vector<double>& masses) const;

    Eigen::VectorXd displacement() const { return start_; } ///< of the active vertices, when the patch was made
    void store(const Eigen::VectorXd& u, SpringNetwork& network) const; ///< writes it back

private:
    struct End {
        std::int32_t other = 0; ///< among the active ones and, behind these, the rim
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
            Vec3::Zero() }; ///< of the corners' shape functions, 1/mm
        double stiffness = 0.0; ///< N mm: volume times brace
        std::array<std::int32_t, 16> entry {}; ///< see entry(); per pair of corners
    };
    struct Crushed {
        std::array<std::int32_t, 4> nodes {};
        std::array<Vec3, 4> slope; ///< of the volume ratio by the corners, 1/mm
        double force = 0.0, stiffness = 0.0;
    };
    using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    /// Where a pair of corners lies in the matrix: the end, or ends_.size() + vertex on the diagonal; -1: in no row.
    std::int32_t entry(std::int32_t row, std::int32_t column) const;
    Block& block(std::int32_t entry);
    Vec3 moved(std::int32_t node, const Eigen::VectorXd& u) const;
    Mat3 deformation(const Braced& element, const Eigen::VectorXd& u) const;
    std::vector<Crushed> crushed_elements(const Eigen::VectorXd& u, double& energy, int& inverted) const;

    void mask(Eigen::VectorXd& vector) const;

    std::vector<VertexId> active_, rim_;
    std::vector<Eigen::Index> held_; ///< unknowns of active vertices along axes that are fixed
    Eigen::VectorXd start_, rim_displacement_, load_;
    Points rest_; ///< active, then rim
    std::vector<std::size_t> row_;
    std::vector<End> ends_;
    std::vector<Block> diagonal_, coupling_; ///< of the tangent: per active vertex, and per end
    std::vector<Element> elements_;
    std::vector<Braced> braced_;
};

struct RelaxOptions {
    /// Largest unbalanced force of a free vertex over the largest force released at a lip.
    double tolerance = 1e-3;
    int max_iterations = 5000; ///< of conjugate gradients, all Newton steps together: the budget of a frame
    /// Only vertices within this distance of the wound, along edges at rest, move; 0: all. A wound draws on tissue as
    /// far away as it is long: of the gape of an 80 mm cut in a free sheet a reach of 10, 20, 40 mm gives 12, 23, 47 %
    /// (`retractor-bench gape`), so this is for a first glance only.
    double reach_mm = 0.0;
};

enum class RelaxStatus { converged, out_of_iterations, no_descent, cancelled };

struct [[nodiscard]] RelaxResult {
    RelaxStatus status = RelaxStatus::converged;
    std::string message;
    double residual = 0.0; ///< as in RelaxOptions::tolerance
    double energy = 0.0; ///< N mm, never above that at the start
    int iterations = 0, newton_steps = 0;
    std::size_t active = 0; ///< vertices
    int crushed = 0, inverted = 0; ///< elements
    double gape_mm = 0.0; ///< widest_gape()
    double seconds = 0.0;
};

/// Moves the network towards equilibrium from where it is. Without a wound nothing moves at all.
/// @throws InputError on options that are NaN or out of range.
RelaxResult relax(SpringNetwork& network, const RelaxOptions& options = {}, const Job& job = {});

/// The same for vertices of one's own choice, without loads that a tolerance could refer to: until the unbalanced force
/// is that share of what it was. @returns the energy, N mm. @throws SolverError when it does not get there.
double settle(SpringNetwork& network, std::vector<VertexId> active, double tolerance, const Job& job = {});

/// Free vertices of some element within `reach_mm` of the wound along edges at rest, by id; 0: all.
std::vector<VertexId> vertices_near_wound(const SpringNetwork& network, double reach_mm);

} // namespace retractor::fem
