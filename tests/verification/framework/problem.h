#pragma once
// Problems with known answers, each solved on several meshes with every element and law that applies. Each row has
// the error of an answer and the run time. Units mm, N, MPa, s.

#include "fem/model/elastic_body.h"
#include "fem/statics/equilibrium.h"
#include "mesh/base/job.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace retractor::verification {

/// The elements of four nodes (p1, locking_free with edge_patch_domains(), nodal with nodal_domains()) and of ten
/// nodes (p2).
enum class VerificationElement { p1, p2, locking_free, nodal };
/// The name of an element: "P1", "P2", "locking-free P1" or "nodal P1".
std::string element_name(VerificationElement element);
int nodes_per_tet(VerificationElement element);

/// Verdict on the measured order of convergence of a series.
enum class OrderVerdict {
    not_judged, ///< no order is expected, or the row's note says why the order is not judged
    reached,
    /// the error passes through zero, so two meshes have no order; the order over all meshes is high enough
    mixed_signs,
    at_floor, ///< the error is as small as the error of the reference
    falling, ///< the meshes are too coarse for an order; the error falls with every mesh
    missed, ///< the row fails
};
/// The name of a verdict: "", "reached", "mixed signs", "at the floor", "falling" or "MISSED".
std::string order_verdict_name(OrderVerdict verdict);

/// A range that was measured on bodies, and the bar of the computed value. The comparison is no test of the program:
/// bodies differ, and the model is none of them.
struct MeasuredComparison {
    double least = 0.0, most = 0.0; ///< ends of the measured range
    double bar = std::numeric_limits<double>::infinity(); ///< half width of the computed value's interval
};
/// "inside" when the whole interval value +- bar lies in the range, "outside" when none of it does, otherwise
/// "undecided".
std::string measured_verdict(double value, const MeasuredComparison& measured);

constexpr double kNoBound = std::numeric_limits<double>::infinity();

/// One solution: a point on a curve of error against run time.
struct VerificationRow {
    std::string problem; ///< VerificationProblem::name with its variant: "tube, nu 0.499"
    std::string element; ///< element_name(), or the part of the program that is measured
    std::string law;
    std::string quantity; ///< compared quantity with its unit
    std::size_t nodes = 0, tets = 0;
    double size = 0.0; ///< element size relative to the coarsest mesh of the series; 0 without a series
    double value = 0.0, expected = 0.0;
    double error = 0.0; ///< relative to the size of the expected value
    double bound = kNoBound; ///< largest error that passes
    double order = std::numeric_limits<double>::quiet_NaN(); ///< measured order between this mesh and the one before
    double expected_order = std::numeric_limits<double>::quiet_NaN();
    OrderVerdict order_verdict = OrderVerdict::not_judged; ///< verdict on the whole series, in its finest row
    bool in_series = false; ///< a coarser mesh, whose series is judged in its finest row
    bool only_shown = false; ///< the row is not judged; the note says why
    std::optional<MeasuredComparison> measured {}; ///< the verdict is measured_verdict(); such a row has no bound
    double residual = 0.0; ///< residual of the solver
    double seconds = 0.0; ///< assembly, factorisation and solution
    std::string note;

    bool passed() const { return error <= bound && order_verdict != OrderVerdict::missed; } // false for NaN
};

struct VerificationOptions {
    /// folder with published files; problems that need the files are skipped without it
    std::filesystem::path shared_data {};
    bool fine = false; ///< adds one refinement
    /// Number of meshes of each refined series, from the coarsest. With fewer meshes than the series has, bounds and
    /// orders have no meaning, because they hold for the whole series.
    std::size_t meshes = std::numeric_limits<std::size_t>::max();
};
template <class Mesh> std::vector<Mesh> coarsest(std::vector<Mesh> meshes, const VerificationOptions& options)
{
    if (meshes.size() > options.meshes)
        meshes.erase(meshes.begin() + static_cast<std::ptrdiff_t>(options.meshes), meshes.end());
    return meshes;
}

struct VerificationProblem {
    std::string name, about; ///< about: the right answer and its origin
    /// Runs the problem. Rows of one series are consecutive, from coarse to fine. A row without an answer gives the
    /// reason in `note`.
    std::function<std::vector<VerificationRow>(const VerificationOptions&, const Job&)> run;
    std::string omitted {}; ///< elements and laws that it is not solved with, and why
};

/// Runs the problems one after the other.
/// @return all rows; fewer when the job was cancelled.
std::vector<VerificationRow> run_verification(
    const std::vector<VerificationProblem>& problems, const VerificationOptions& options, const Job& job);

/// The material of a whole problem.
struct VerificationLaw {
    std::string name;
    fem::Elasticity model = fem::Elasticity::linear;
    fem::Lame lame {};
    fem::Hyperelastic hyperelastic {};
    fem::FibreDirections fibres {}; ///< the same in all elements, unless `around` is set
    /// fibres that wind round an axis
    std::optional<fem::FibresAround> around {};
};
VerificationLaw linear_law(double youngs_modulus, double poissons_ratio);
VerificationLaw hyperelastic_law(std::string name, const fem::Hyperelastic& law);

/// A body on a mesh with the nodes of the element; locking-free for the averaged elements.
fem::ElasticBody make_body(const mesh::TetMesh& mesh, VerificationElement element, const VerificationLaw& law);

struct VerificationSolve {
    fem::Equilibrium equilibrium;
    double seconds = 0.0;
};
/// Solves from rest.
/// @param target displacements of the prescribed unknowns, mm; empty: zero.
VerificationSolve solve_problem(fem::ElasticBody& body, const std::vector<std::uint8_t>& prescribed,
    const Eigen::VectorXd& target, const fem::EquilibriumOptions& options, const Job& job);

/// Fills in mesh size, value, error relative to |expected|, residual and time.
VerificationRow make_row(std::string problem, VerificationElement element, const VerificationLaw& law,
    const mesh::TetMesh& mesh, const VerificationSolve& solve);
void compare(VerificationRow& row, std::string quantity, double value, double expected);
/// Marks a row that is not judged, and puts the reason into its note.
void show_only(VerificationRow& row, const std::string& why);
/// Sets the measured orders between consecutive rows that have a size.
void set_orders(std::vector<VerificationRow>& series, double expected);

/// Rule by which the order of a series is judged.
struct OrderRule {
    enum class Asks {
        order,
        fall, ///< the error must fall with every mesh; for elements whose error is too large to show an order
        nothing,
    } asks
        = Asks::order;
    /// Amount by which the last order may be below the expected one, because the meshes are coarse.
    double slack = 0.5;
    /// Amount by which the order from the coarsest to the finest mesh may be below the expected one where the error
    /// passes through zero.
    double mixed_slack = 1.0;
    double floor = 0.0; ///< relative error of the reference; no order is visible below twice this error
    std::string why {}; ///< reason for the note: the origin of the floor, or why no order is expected
};
/// Sets the orders and judges the series by its last one: a missed order fails the finest row, and its note says so.
/// Without at least three meshes, two where it must only fall, nothing is judged.
void check_orders(std::vector<VerificationRow>& series, double expected, const OrderRule& rule);
/// The same, gives the finest row its bound, marks what is in a series and what is only shown, for the rule's reason,
/// and appends the series to the rows.
void append_series(std::vector<VerificationRow>& rows, std::vector<VerificationRow>& series, double expected,
    double bound, const OrderRule& rule = {});

} // namespace retractor::verification
