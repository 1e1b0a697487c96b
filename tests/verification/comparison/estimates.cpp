#include "tests/verification/comparison/estimates.h"

#include "fem/error_estimation/body_estimate.h"
#include "fem/error_estimation/error_estimate.h"
#include "fem/model/pre_strain.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/cutting/cut_session.h"
#include "tests/support/cutting/cut_mesh.h"
#include "tests/verification/framework/element_stress.h"
#include "tests/verification/framework/meshes.h"
#include "tests/verification/framework/tension.h"
#include "tests/verification/framework/vessel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace retractor::verification {

namespace {

    constexpr double kLeast = 0.5, kMost = 3.0; // limits of the ratio of estimate to error

    /// Conditions at corners, extended to ten-node elements: a midpoint is held along an axis where both ends of its
    /// edge are held.
    std::vector<std::uint8_t> with_midpoints_held(const mesh::TetMesh& fine, const std::vector<std::uint8_t>& corners)
    {
        std::vector<std::uint8_t> held(3 * fine.vertex_count(), 0);
        std::copy(corners.begin(), corners.end(), held.begin());
        for (TetId t = 0; t < static_cast<TetId>(fine.tet_count()); ++t) {
            const auto nodes = fine.tet(t);
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const auto end = [&](std::size_t i) {
                        return corners[3
                                * static_cast<std::size_t>(nodes[static_cast<std::size_t>(mesh::kTetEdges[e][i])])
                            + axis];
                    };
                    held[3 * static_cast<std::size_t>(nodes[4 + e]) + axis]
                        = static_cast<std::uint8_t>(end(0) != 0 && end(1) != 0);
                }
        }
        return held;
    }

    /// The estimate from the change by ten-node elements.
    JudgedEstimate judged(double answer, double better, double right)
    {
        return { answer, std::abs(better - answer) / fem::kErrorShare, right };
    }

    VerificationRow without_estimate(VerificationRow row, const std::string& why)
    {
        row.note = why;
        row.error = std::numeric_limits<double>::quiet_NaN();
        return row;
    }

    VerificationRow tube(int around, int through, double nu, const Job& job)
    {
        constexpr double E = 0.5; // MPa
        const VerificationLaw law = linear_law(E, nu);
        const QuarterTube coarse = quarter_tube(4, kVesselInner, kVesselOuter, around, through, 1);
        fem::ElasticBody body = make_body(coarse.mesh, VerificationElement::p1, law);
        body.set_loads({ {}, { fem::FollowerPressure(coarse.mesh, coarse.inner_faces, kPulse) } });
        const VerificationSolve solve = solve_problem(body, coarse.held.prescribed, {}, { .tolerance = 1e-9 }, job);
        VerificationRow row
            = make_row("error estimate, pressed tube", VerificationElement::p1, law, coarse.mesh, solve);
        const mesh::TetMesh fine = with_midpoints(coarse.mesh);
        fem::ElasticBody fine_body = make_body(fine, VerificationElement::p2, law);
        fine_body.set_loads({ {}, { fem::FollowerPressure(fine, coarse.inner_faces, kPulse) } });
        const fem::BodyEstimate estimate = fem::estimate_error(body, coarse.held.prescribed, fine_body,
            with_midpoints_held(fine, coarse.held.prescribed), solve.equilibrium.displacement, job);
        if (estimate.status != fem::EstimateStatus::done)
            return without_estimate(std::move(row), estimate.message);
        check_estimate(row, "the inner wall's displacement",
            judged(inner_displacement(coarse, solve.equilibrium.displacement),
                inner_displacement(coarse, estimate.displacement.head(3 * coarse.mesh.vertices.rows())),
                vessel_displacement(E, nu, kPulse)));
        return row;
    }

    /// Distance between the lips at the middle of the cut, mean over the thickness.
    double sheet_gape_of(const SheetProblem& sheet, const test_support::CutMesh& cut, const Eigen::VectorXd& u)
    {
        double sum = 0.0;
        int faces = 0;
        for (const mesh::LipFace& lip : cut.lips)
            for (const VertexId v : mesh::face_vertices(cut.mesh, lip.face))
                if (std::abs(cut.mesh.vertices(v, 0)) < 1e-6 * sheet.cut_length) {
                    sum += lip.side * u[3 * v + 1];
                    ++faces;
                }
        return faces > 0 ? 2.0 * sum / faces : 0.0;
    }

    VerificationRow gaping_sheet(int around, const Job& job)
    {
        constexpr double strain = 0.02, E = 0.2, nu = 0.25;
        const VerificationLaw law = linear_law(E, nu);
        SheetProblem sheet;
        sheet.around = around;
        const std::vector<fem::Material> materials(2, { "skin", E, nu, 1.1e-9, "verification" });
        const test_support::CutMesh cut = test_support::cut(sheet_mesh(sheet), sheet_blade(sheet));
        if (cut.status != mesh::CutStatus::done)
            throw SolverError("the sheet was not cut: " + cut.message);
        const std::vector<Mat3> stresses = stress_of_elements(cut.mesh, materials,
            std::vector<fem::PreStrain>(
                2, { fem::PreStrainKind::uniaxial_stress, strain, Vec3::UnitY(), Vec3::UnitZ() }));
        std::vector<mesh::TetFace> lips;
        for (const mesh::LipFace& lip : cut.lips)
            lips.push_back(lip.face);
        Held held = hold_nothing(cut.mesh);
        for (const VertexId v : sheet_rim(sheet, cut.mesh)) {
            const Vec3 u
                = sheet_displacement(sheet.cut_length, E * strain, E, nu, cut.mesh.vertices.row(v).transpose());
            for (int axis = 0; axis < 3; ++axis)
                hold(held, v, axis, u[axis]);
        }
        for (const VertexId v : sheet_middle_plane(cut.mesh))
            hold(held, v, 2);
        fem::ElasticBody body = make_body(cut.mesh, VerificationElement::p1, law);
        body.set_loads({ fem::traction_loads(cut.mesh, fem::released_tractions(cut.mesh, lips, stresses)), {} });
        const VerificationSolve solve = solve_problem(body, held.prescribed, held.target, { .tolerance = 1e-9 }, job);
        VerificationRow row = make_row("error estimate, gaping cut", VerificationElement::p1, law, cut.mesh, solve);
        const mesh::TetMesh fine = with_midpoints(cut.mesh);
        fem::ElasticBody fine_body = make_body(fine, VerificationElement::p2, law);
        fine_body.set_loads({ fem::traction_loads(fine, fem::released_tractions(fine, lips, stresses)), {} });
        const fem::BodyEstimate estimate = fem::estimate_error(body, held.prescribed, fine_body,
            with_midpoints_held(fine, held.prescribed), solve.equilibrium.displacement, job);
        if (estimate.status != fem::EstimateStatus::done)
            return without_estimate(std::move(row), estimate.message);
        check_estimate(row, "the gape in the middle",
            judged(std::abs(sheet_gape_of(sheet, cut, solve.equilibrium.displacement)),
                std::abs(sheet_gape_of(sheet, cut, estimate.displacement.head(3 * cut.mesh.vertices.rows()))),
                sheet_gape(fem::PreStrainKind::uniaxial_stress, strain, sheet.cut_length, nu)));
        return row;
    }

    /// A column of 20 x 20 x 40 mm, pressed between two plates that do not slip. Divided at its mirror plane, the
    /// column becomes two columns that press on each other. The answer is the same: frictionless contact carries the
    /// same pressure as the mirror plane.
    struct Column {
        double cell = 5.0, plate = 10.0, poissons_ratio = 0.4; ///< edge lengths of the elements and of the plates, mm
        bool divided = false;
    };

    constexpr double kSide = 20.0, kHalf = 20.0, kPush = 1.0; // mm; each plate moves by kPush
    constexpr double kColumn = 0.04; // MPa

    fem::ElasticProblem pressed_column(int nodes_per_tet, const Column& column)
    {
        constexpr double kTiny = 1e-9;
        const int across = static_cast<int>(std::lround(kSide / column.cell)),
                  up = static_cast<int>(std::lround(kHalf / column.cell));
        const auto scaled = [&](const Vec3& p) -> Vec3 { return column.cell * p; };
        fem::ElasticProblem problem;
        if (column.divided) {
            problem.mesh = mapped_box(nodes_per_tet, across, across, up, scaled);
            // The other half is the mirror image, so equal triangles lie on each other.
            const mesh::TetMesh lower = problem.mesh;
            const auto before = static_cast<VertexId>(lower.vertex_count());
            problem.mesh.vertices.conservativeResize(2 * lower.vertices.rows(), 3);
            for (Eigen::Index v = 0; v < lower.vertices.rows(); ++v)
                problem.mesh.vertices.row(lower.vertices.rows() + v) = Eigen::RowVector3d(
                    lower.vertices(v, 0), lower.vertices(v, 1), 2.0 * kHalf - lower.vertices(v, 2));
            for (TetId t = 0; t < static_cast<TetId>(lower.tet_count()); ++t) {
                const auto nodes = lower.tet(t);
                for (const std::size_t a : { 1U, 0U, 2U, 3U })
                    problem.mesh.nodes.push_back(nodes[a] + before);
            }
            problem.mesh.labels.insert(problem.mesh.labels.end(), lower.labels.begin(), lower.labels.end());
        } else {
            problem.mesh = mapped_box(nodes_per_tet, across, across, 2 * up, scaled);
        }
        const fem::Material tissue { "muscle", kColumn, column.poissons_ratio, 1.06e-9, "verification" };
        problem.material_of_label = { tissue, tissue };
        problem.hooks = { { "below", -1, {}, Vec3(0.0, 0.0, kPush) }, { "above", 1, {}, Vec3(0.0, 0.0, -kPush) } };
        for (VertexId v = 0; v < static_cast<VertexId>(problem.mesh.vertex_count()); ++v) {
            const Vec3 p = problem.mesh.vertices.row(v).transpose();
            const bool under
                = std::max(std::abs(p.x() - 0.5 * kSide), std::abs(p.y() - 0.5 * kSide)) < 0.5 * column.plate + kTiny;
            if (under && p.z() < kTiny)
                problem.hooks[0].nodes.push_back(v);
            else if (under && p.z() > 2.0 * kHalf - kTiny)
                problem.hooks[1].nodes.push_back(v);
        }
        return problem;
    }

    fem::OpeningResult pressed(const fem::ElasticProblem& problem, const fem::OpeningOptions& options, const Job& job)
    {
        fem::Opening opening(problem.mesh, problem.material_of_label, problem.supports, options);
        fem::OpeningResult result = opening.open(problem.hooks, job);
        if (result.status != fem::OpeningStatus::converged)
            throw SolverError("the columns were not pressed: " + result.message);
        return result;
    }

    VerificationRow columns_row(const Column& column, VerificationElement element, const mesh::TetMesh& mesh,
        const fem::OpeningResult& answer, const Stopwatch& watch)
    {
        VerificationRow row;
        row.problem = column.plate < kSide ? "error estimate, columns pressed together"
                                           : "error estimate, columns pressed evenly";
        row.element = element_name(element);
        row.law = "linear, contact";
        row.tets = mesh.tet_count();
        row.nodes = mesh.vertex_count();
        row.residual = answer.residual;
        row.seconds = watch.seconds();
        return row;
    }

    VerificationRow pressed_columns(const Column& column, double right, const Job& job)
    {
        fem::OpeningOptions options { .elasticity = fem::Elasticity::linear, .load_steps = 2, .tolerance = 1e-9 };
        options.contact.emplace();
        const fem::ElasticProblem problem = pressed_column(4, column);
        const Stopwatch watch;
        const fem::OpeningResult answer = pressed(problem, options, job);
        VerificationRow row = columns_row(column, VerificationElement::p1, problem.mesh, answer, watch);
        const fem::ErrorEstimate estimate
            = fem::estimate_error(problem, fem::Elasticity::linear, answer.displacement, job, options.contact);
        if (estimate.status != fem::EstimateStatus::done)
            return without_estimate(std::move(row), estimate.message);
        check_estimate(
            row, "a plate's force, N", judged(answer.hook_forces_N[1].norm(), estimate.hook_forces_N[1].norm(), right));
        return row;
    }

    /// The estimate for ten-node elements, by the share that remains relative to the change from plain elements.
    VerificationRow pressed_ten_node_columns(const Column& column, double right, const Job& job)
    {
        fem::OpeningOptions options { .elasticity = fem::Elasticity::linear, .load_steps = 2, .tolerance = 1e-9 };
        options.contact.emplace();
        const fem::ElasticProblem problem = pressed_column(4, column), fine = with_midpoints(problem);
        const fem::OpeningResult plain = pressed(problem, options, job);
        const Stopwatch watch;
        const fem::OpeningResult answer = pressed(fine, options, job);
        VerificationRow row = columns_row(column, VerificationElement::p2, fine.mesh, answer, watch);
        const Points& u = answer.displacement;
        const double share = fem::ten_node_share(
            fine, fem::Elasticity::linear, Eigen::Map<const Eigen::VectorXd>(u.data(), u.size()), plain.displacement);
        const double force = answer.hook_forces_N[1].norm();
        check_estimate(
            row, "a plate's force, N", { force, share * std::abs(plain.hook_forces_N[1].norm() - force), right });
        return row;
    }

    std::vector<VerificationRow> pressed_columns_series(const VerificationOptions& options, const Job& job)
    {
        // The reference is one undivided column with ten-node elements on two meshes. At the plate's rim the error is
        // proportional to the edge length, so the last answer is extrapolated by its change between the meshes.
        const auto whole = [&](double cell) {
            const fem::OpeningOptions linear { .elasticity = fem::Elasticity::linear, .tolerance = 1e-9 };
            return pressed(pressed_column(10, { .cell = cell }), linear, job).hook_forces_N[1].norm();
        };
        const double coarse = whole(5.0), fine = whole(2.5), right = fine - (coarse - fine);
        std::vector<VerificationRow> rows;
        for (const double cell : options.fine ? std::vector { 5.0, 2.5, 5.0 / 3.0 } : std::vector { 5.0, 2.5 })
            if (!job.cancelled())
                rows.push_back(pressed_columns({ .cell = cell, .divided = true }, right, job));
        if (!job.cancelled())
            rows.push_back(pressed_ten_node_columns({ .cell = 5.0, .divided = true }, right, job));
        // An even press without sideways motion has the force E A d / L, which the elements represent exactly; the
        // remaining error is that of the penalty.
        const double even = kColumn * kSide * kSide * kPush / kHalf;
        for (const double cell : { 5.0, 2.5 })
            if (!job.cancelled())
                rows.push_back(pressed_columns(
                    { .cell = cell, .plate = kSide, .poissons_ratio = 0.0, .divided = true }, even, job));
        return rows;
    }

} // namespace

void check_estimate(VerificationRow& row, const std::string& quantity, const JudgedEstimate& judged)
{
    const double effectivity = judged.estimate / judged.error;
    const bool known = !std::isnan(row.error) && std::isfinite(judged.estimate) && std::isfinite(judged.error);
    compare(row, "estimated over true error of " + quantity, effectivity, 1.0);
    // The row's error is the ratio of the factor to the nearer limit.
    row.error = std::max(effectivity / kMost, kLeast / effectivity);
    // Errors below the digits of a plan can be the remainder of cancelling errors.
    constexpr double kSeen = 1e-4;
    const bool seen = judged.error > kSeen * std::abs(judged.right);
    if (!seen) // an answer without a visible error must not have a visible bar
        row.error = std::max(judged.error, judged.estimate / kMost) / (kSeen * std::abs(judged.right));
    if (!known)
        row.error = std::numeric_limits<double>::quiet_NaN();
    row.bound = 1.0;
    if (!row.note.empty())
        row.note += "; ";
    const bool of_vector = judged.error > (1.0 + 1e-9) * std::abs(judged.right - judged.answer);
    row.note += formatted("%.5g +- %.2g; right is %.5g", judged.answer, judged.estimate, judged.right);
    if (of_vector)
        row.note += formatted(", as a vector %.2g away", judged.error);
    if (!seen)
        row.note += ", within 0.01 %: judged is that the estimate stays below 0.03 %";
}

VerificationProblem estimate_problem()
{
    return { "error estimate", "the estimate is half to three times the error, where that is known",
        [](const VerificationOptions& options, const Job& job) {
            std::vector<VerificationRow> rows;
            for (const double nu : { 0.30, 0.45 })
                for (const int through : { 1, 2, 4 })
                    if (!job.cancelled())
                        rows.push_back(tube(12 * through, through, nu, job));
            for (const int around : { 16, 32, options.fine ? 128 : 64 })
                if (!job.cancelled())
                    rows.push_back(gaping_sheet(around, job));
            const std::vector<VerificationRow> pressed = pressed_columns_series(options, job);
            rows.insert(rows.end(), pressed.begin(), pressed.end());
            const std::vector<VerificationRow> elements = element_estimates(options, job);
            rows.insert(rows.end(), elements.begin(), elements.end());
            return rows;
        },
        "nodal P1, which `plan` does not offer; fibres: estimates are made from the field, whatever the law" };
}

} // namespace retractor::verification
