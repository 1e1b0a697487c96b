#pragma once
// A linear body factored once, with everything condensed onto the few vertices that matter (where it will be cut and
// held): these come last in the elimination, so that the trailing block of the factor gives the Schur complement on
// them, and the whole field follows from their displacements by half a solve. What the body is like later, after cuts,
// is for its user to know: see OnlineOpening. Units mm, N; matrices over the kept vertices have three rows per vertex,
// in the order of kept().

#include "fem/interactive/online_stiffness.h"
#include "fem/linear_algebra/sparse_cholesky.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <vector>

namespace retractor::fem {

/// How vertices that are kept in addition hang on those kept before: u = follow u_before + own f.
struct AddedVertices {
    std::vector<VertexId> before, vertices;
    Eigen::MatrixXd follow; ///< 3 added x 3 before
    Eigen::MatrixXd own; ///< compliance with those before held still
};

class CondensedBody {
public:
    /// Factors the stiffness as it is now; takes as long as any factorisation.
    /// @param fixed per vertex id: 1 where the vertex does not move; shorter: the others are free.
    /// @param kept living free vertices, each once.
    /// @throws InputError when a kept vertex is not alive, fixed or named twice; SolverError naming the vertex and axis
    /// when the stiffness is not positive definite: something is not held.
    CondensedBody(
        const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& fixed, const std::vector<VertexId>& kept);

    /// Keeps further vertices, exactly: one solve per new unknown, in groups, and its column is stored.
    /// Those that are kept already are left out.
    AddedVertices keep_also(const std::vector<VertexId>& vertices);

    const std::vector<VertexId>& kept() const { return kept_; }
    /// Place among kept(); -1: condensed away, fixed or unknown here.
    std::int32_t place(VertexId v) const { return at(place_, v); }
    /// Free in this body, kept or condensed.
    bool has(VertexId v) const { return at(number_, v) >= 0; }
    std::size_t added() const { return kept_.size() - planned_; } ///< by keep_also()

    /// Forces on the kept vertices that hold them at unit displacements; all others are free.
    const Eigen::MatrixXd& stiffness() const { return stiffness_; }
    /// Its inverse: displacements by unit forces.
    const Eigen::MatrixXd& compliance() const { return *compliance_; }
    /// The same, and it stays as it is when further vertices are kept.
    std::shared_ptr<const Eigen::MatrixXd> shared_compliance() const { return compliance_; }

    /// The whole field under loads anywhere. Loads and result by vertex id, three entries each; those of vertices that
    /// are not in this body are left out and zero.
    Eigen::VectorXd solve(const Eigen::VectorXd& load) const;
    /// The whole field with the kept vertices at these displacements and no load elsewhere: half a solve per case.
    /// @param kept_displacement 3 x kept rows, one column per case. @return 3 x slots rows.
    Eigen::MatrixXd field(const Eigen::MatrixXd& kept_displacement, std::size_t slots) const;

    double factor_entries() const { return factor_.factor_entries(); }
    std::size_t bytes() const;

private:
    static std::int32_t at(const std::vector<std::int32_t>& of_vertex, VertexId v)
    {
        return v >= 0 && static_cast<std::size_t>(v) < of_vertex.size() ? of_vertex[static_cast<std::size_t>(v)] : -1;
    }

    std::vector<VertexId> free_; ///< per block of unknowns of the factored matrix: its vertex
    std::vector<std::int32_t> number_; ///< per vertex id: its place in free_, or -1
    std::vector<VertexId> kept_;
    std::vector<std::int32_t> place_; ///< per vertex id: its place in kept_, or -1
    std::size_t planned_ = 0; ///< kept vertices that come last in the factor; the rest were added
    mutable SparseCholesky factor_; ///< solving uses its work space
    Eigen::MatrixXd stiffness_;
    std::shared_ptr<const Eigen::MatrixXd> compliance_;
    Eigen::MatrixXd added_fields_; ///< per unknown that was added: the field of a unit force there
};

} // namespace retractor::fem
