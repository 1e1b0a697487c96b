#pragma once
// Problems with known answers, each solved on several meshes with every element and law that applies: the error of an
// answer beside the time it takes. Units mm, N, MPa, s.

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

/// `locking_free`: edge_patch_domains(); `nodal`: nodal_domains().
enum class VerificationElement { p1, p2, locking_free, nodal };
/// "P1", "P2", "locking-free P1", "nodal P1".
std::string element_name(VerificationElement element);
int nodes_per_tet(VerificationElement element);

/// What the measured order of a series says.
enum class OrderVerdict {
    not_judged, ///< none is expected, or the row's note says why it is not judged
    reached,
    mixed_signs, ///< the error passes through zero: no order between two meshes; over all of them it is high enough
    at_floor, ///< as small as the reference itself is exact
    falling, ///< no order is to be seen on such meshes; the error falls with every one
    missed, ///< the row fails
};
/// "", "reached", "mixed signs", "at the floor", "falling", "MISSED".
std::string order_verdict_name(OrderVerdict verdict);

constexpr double kNoBound = std::numeric_limits<double>::infinity();

/// One solve: a point on a curve of error against run time.
struct VerificationRow {
    std::string problem; ///< of VerificationProblem::name, with its variant: "tube, nu 0.499"
    std::string element; ///< element_name(), or what is measured instead
    std::string law;
    std::string quantity; ///< what is compared, with its unit
    std::size_t nodes = 0, tets = 0;
    double size = 0.0; ///< of the elements, relative to the coarsest mesh of the series; 0: no series
    double value = 0.0, expected = 0.0;
    double error = 0.0; ///< relative to the expected size
    double bound = kNoBound; ///< what the error must stay below
    double order = std::numeric_limits<double>::quiet_NaN(); ///< measured between this mesh and the one before
    double expected_order = std::numeric_limits<double>::quiet_NaN();
    OrderVerdict order_verdict = OrderVerdict::not_judged; ///< of the whole series, in its finest row
    bool in_series = false; ///< a coarser mesh: the series is judged in its finest row
    bool only_shown = false; ///< nothing judges it; the note says why
    double residual = 0.0; ///< of the solver
    double seconds = 0.0; ///< assembly, factorisation and solution
    std::string note;

    bool passed() const { return error <= bound && order_verdict != OrderVerdict::missed; } // false for NaN
};

struct VerificationOptions {
    std::filesystem::path shared_data {}; ///< the folder with published files; problems that need them are skipped
    bool fine = false; ///< one more refinement
    /// Of each series that is refined, so many of the coarsest. Fewer than there are: bounds and orders, which are
    /// those of the whole series, say nothing.
    std::size_t meshes = std::numeric_limits<std::size_t>::max();
};
template <class Mesh> std::vector<Mesh> coarsest(std::vector<Mesh> meshes, const VerificationOptions& options)
{
    if (meshes.size() > options.meshes)
        meshes.erase(meshes.begin() + static_cast<std::ptrdiff_t>(options.meshes), meshes.end());
    return meshes;
}

struct VerificationProblem {
    std::string name, about; ///< about: what the right answer is and where it comes from
    /// Rows of one series follow each other, coarse to fine. A row without an answer says why in `note`.
    std::function<std::vector<VerificationRow>(const VerificationOptions&, const Job&)> run;
    std::string omitted {}; ///< elements and laws that it is not solved with, and why
};

/// Runs the problems one after the other. @return all rows; fewer when the job was cancelled.
std::vector<VerificationRow> run_verification(
    const std::vector<VerificationProblem>& problems, const VerificationOptions& options, const Job& job);

/// The material of a whole problem.
struct VerificationLaw {
    std::string name;
    fem::Elasticity model = fem::Elasticity::linear;
    fem::Lame lame {};
    fem::Hyperelastic hyperelastic {};
    fem::FibreDirections fibres {}; ///< or
    std::optional<fem::FibresAround> around {};
};
VerificationLaw linear_law(double youngs_modulus, double poissons_ratio);
VerificationLaw hyperelastic_law(std::string name, const fem::Hyperelastic& law);

/// A body on a mesh of the element's nodes; locking-free where asked for.
fem::ElasticBody make_body(const mesh::TetMesh& mesh, VerificationElement element, const VerificationLaw& law);

struct VerificationSolve {
    fem::Equilibrium equilibrium;
    double seconds = 0.0;
};
/// Solves from rest. @param target of prescribed unknowns; empty: zero.
VerificationSolve solve_problem(fem::ElasticBody& body, const std::vector<std::uint8_t>& prescribed,
    const Eigen::VectorXd& target, const fem::EquilibriumOptions& options, const Job& job);

/// Fills in mesh, value, error relative to |expected|, residual and time.
VerificationRow make_row(std::string problem, VerificationElement element, const VerificationLaw& law,
    const mesh::TetMesh& mesh, const VerificationSolve& solve);
void compare(VerificationRow& row, std::string quantity, double value, double expected);
/// Marks a row that has no bound, and says why in its note.
void show_only(VerificationRow& row, const std::string& why);
/// Sets the measured orders of consecutive rows with sizes.
void set_orders(std::vector<VerificationRow>& series, double expected);

/// How the order of a series is judged.
struct OrderRule {
    enum class Asks {
        order,
        fall, ///< of the error, with every mesh; for elements that are too far off to show an order
        nothing,
    } asks
        = Asks::order;
    /// The last order may be so much below the expected one: the meshes are coarse.
    double slack = 0.5;
    /// Where the error passes through zero, the order from the coarsest to the finest mesh may be so much below.
    double mixed_slack = 1.0;
    double floor = 0.0; ///< relative error of the reference itself; at twice that no order is left to be seen
    std::string why {}; ///< for the note: what makes the floor, or why no order is asked for
};
/// Sets the orders and judges the series by its last one: a missed order fails the finest row, and its note says so.
/// Without at least three meshes, two where it must only fall, nothing is judged.
void check_orders(std::vector<VerificationRow>& series, double expected, const OrderRule& rule);
/// The same, gives the finest row its bound, marks what is in a series and what is only shown, for the rule's reason,
/// and appends the series to the rows.
void append_series(std::vector<VerificationRow>& rows, std::vector<VerificationRow>& series, double expected,
    double bound, const OrderRule& rule = {});

} // namespace retractor::verification
