// Validation problems 1 and 2: properties that an element must have exactly.

#include "tests/verification/analytic/analytic_problems.h"

#include "fem/linear_algebra/dense_algebra.h"
#include "mesh/base/error.h"
#include "mesh/base/job.h"
#include "mesh/cutting/cut_session.h"
#include "tests/support/dense_matrix.h"
#include "tests/verification/framework/condition.h"
#include "tests/verification/framework/meshes.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <numeric>

namespace retractor::verification {

namespace {

    constexpr double kPatchYoung = 1.0, kPatchPoisson = 0.3;

    const std::vector<VerificationElement>& all_elements()
    {
        static const std::vector<VerificationElement> elements { VerificationElement::p1,
            VerificationElement::locking_free, VerificationElement::nodal, VerificationElement::p2 };
        return elements;
    }

    std::vector<VerificationLaw> all_laws()
    {
        const fem::Lame l = linear_law(kPatchYoung, kPatchPoisson).lame;
        const double bulk = l.lambda + 2.0 / 3.0 * l.mu;
        return { linear_law(kPatchYoung, kPatchPoisson), { "corotational", fem::Elasticity::corotational, l, {}, {} },
            hyperelastic_law("neo-Hookean", fem::NeoHookean { l.mu, l.lambda }),
            hyperelastic_law("Mooney-Rivlin", fem::MooneyRivlin { 0.4 * l.mu, 0.1 * l.mu, bulk }),
            hyperelastic_law("Holzapfel-Gasser-Ogden", fem::HolzapfelGasserOgden { l.mu, l.mu, 2.0, 0.1, bulk }),
            hyperelastic_law("Guccione", fem::Guccione { 0.1 * l.mu, 8.0, 2.0, 4.0, bulk }) };
    }

    mesh::TetMesh for_element(const mesh::TetMesh& mesh, VerificationElement element)
    {
        return nodes_per_tet(element) == 10 ? mesh::with_midpoints(mesh) : mesh;
    }

    Vec3 linear_field(const Vec3& p)
    {
        Mat3 gradient;
        gradient << 0.01, 0.02, -0.03, 0.005, -0.01, 0.015, 0.02, 0.0, 0.03;
        return gradient * p + Vec3(0.1, 0.2, 0.3);
    }

    constexpr double kNewton = 1e-9; // mm: error that Newton's tolerance of 1e-12 leaves

    VerificationRow patch_row(VerificationElement element, const VerificationLaw& law, int cells, const Job& job)
    {
        const mesh::TetMesh mesh = for_element(distorted_box(cells, 1.0, 0.15, 1), element);
        const Held held = hold_boundary(mesh, linear_field);
        fem::ElasticBody body = make_body(mesh, element, law);
        const VerificationSolve solve = solve_problem(body, held.prescribed, held.target, { .tolerance = 1e-12 }, job);
        VerificationRow row = make_row("patch test", element, law, mesh, solve);
        const Eigen::VectorXd exact = nodal_values(mesh, linear_field);
        compare(row, "largest error of the displacement, mm",
            (solve.equilibrium.displacement - exact).cwiseAbs().maxCoeff(), 0.0);
        row.bound = law.model == fem::Elasticity::linear ? 1e-12 : kNewton; // round-off
        return row;
    }

    /// A rotation by 90 degrees and then the linear field, solved from a rotated start. The strain is that of the
    /// linear field.
    VerificationRow turned_patch_row(VerificationElement element, const VerificationLaw& law, int cells, const Job& job)
    {
        const mesh::TetMesh mesh = for_element(distorted_box(cells, 1.0, 0.15, 1), element);
        const Mat3 R = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3(1, 1, 0).normalized()).toRotationMatrix();
        const auto turned = [&](const Vec3& p) -> Vec3 { return R * p - p; };
        const auto field = [&](const Vec3& p) -> Vec3 { return R * (p + linear_field(p)) - p; };
        const Held held = hold_boundary(mesh, field);
        fem::ElasticBody body = make_body(mesh, element, law);
        const Stopwatch watch;
        fem::EquilibriumSolver solver;
        VerificationSolve solve;
        solve.equilibrium
            = solver.solve(body, held.prescribed, held.target, nodal_values(mesh, turned), { .tolerance = 1e-12 }, job);
        solve.seconds = watch.seconds();
        VerificationRow row = make_row("patch test, turned by 90 degrees", element, law, mesh, solve);
        compare(row, "largest error of the displacement, mm",
            (solve.equilibrium.displacement - nodal_values(mesh, field)).cwiseAbs().maxCoeff(), 0.0);
        row.bound = kNewton;
        return row;
    }

    struct TiedMesh {
        mesh::TetMesh mesh;
        std::size_t pairs = 0; ///< number of vertex pairs on the lips
    };

    /// A distorted box with an oblique, incomplete cut by a session. The vertices that the cut doubled are tied
    /// together again.
    TiedMesh cut_and_tied_box(int cells)
    {
        mesh::CutSession session(distorted_box(cells, 1.0, 0.15, 1));
        const double size = cells;
        const mesh::CutResult cut
            = session.cut({ .line = { { -0.5, 0.43 * size, size }, { 0.7 * size, 0.55 * size, size } },
                .directions = { { 0.1, 0.2, -1.0 } },
                .depth_mm = 0.6 * size });
        if (cut.status != mesh::CutStatus::done)
            throw SolverError("the box was not cut: " + cut.message);
        mesh::SlotMap map;
        const mesh::TetMesh open = session.compact_mesh(&map);
        std::vector<VertexId> one(open.vertex_count());
        std::iota(one.begin(), one.end(), 0);
        TiedMesh tied;
        for (const auto& born : cut.delta.vertices_born)
            if (born.origin == mesh::MeshDelta::Origin::copy && session.has_vertex(born.id)
                && session.has_vertex(born.a)) {
                const auto at = [&](VertexId id) {
                    return static_cast<std::size_t>(map.compact_vertex[static_cast<std::size_t>(id)]);
                };
                one[at(born.id)] = one[at(born.a)]; // the parent of a copy precedes the copy
                ++tied.pairs;
            }
        std::vector<VertexId> renumbered(one.size(), 0);
        VertexId next = 0;
        tied.mesh = open;
        for (std::size_t v = 0; v < one.size(); ++v)
            if (one[v] == static_cast<VertexId>(v)) {
                tied.mesh.vertices.row(next) = open.vertices.row(static_cast<Eigen::Index>(v));
                renumbered[v] = next++;
            }
        tied.mesh.vertices.conservativeResize(next, 3);
        for (VertexId& v : tied.mesh.nodes)
            v = renumbered[static_cast<std::size_t>(one[static_cast<std::size_t>(v)])];
        mesh::check_mesh(tied.mesh);
        const std::vector<mesh::TetFace> inside = faces_where(
            tied.mesh, [&](const Vec3& p) { return p.minCoeff() > 1e-6 * size && p.maxCoeff() < (1.0 - 1e-6) * size; });
        // lips that are held like a boundary would pass the test with anything between them
        if (tied.pairs == 0 || !inside.empty())
            throw SolverError("the lips were not tied again");
        return tied;
    }

    VerificationRow tied_patch_row(
        const TiedMesh& tied, VerificationElement element, const VerificationLaw& law, const Job& job)
    {
        const mesh::TetMesh mesh = for_element(tied.mesh, element);
        const Held held = hold_boundary(mesh, linear_field);
        fem::ElasticBody body = make_body(mesh, element, law);
        const VerificationSolve solve = solve_problem(body, held.prescribed, held.target, { .tolerance = 1e-12 }, job);
        VerificationRow row = make_row("patch test, cut and its lips tied", element, law, mesh, solve);
        const Eigen::VectorXd exact = nodal_values(mesh, linear_field);
        compare(row, "largest error of the displacement, mm",
            (solve.equilibrium.displacement - exact).cwiseAbs().maxCoeff(), 0.0);
        const double condition
            = estimate_condition(body.stiffness(Eigen::VectorXd::Zero(exact.size()), 0.0), held.prescribed).scaled;
        constexpr double kRoundings = 4.0 * std::numeric_limits<double>::epsilon();
        const double round_off = kRoundings * condition * exact.cwiseAbs().maxCoeff();
        row.bound = law.model == fem::Elasticity::linear ? round_off : std::max(kNewton, round_off);
        char text[96];
        (void)std::snprintf(text, sizeof text,
            "%zu pairs of vertices tied; condition %.1e: the bound is round-off times that", tied.pairs, condition);
        row.note = text;
        return row;
    }

    VerificationRow describe(const std::string& problem, VerificationElement element, const VerificationLaw& law,
        const mesh::TetMesh& mesh, const Stopwatch& watch)
    {
        VerificationRow row = make_row(problem, element, law, mesh, {});
        row.seconds = watch.seconds();
        return row;
    }

    VerificationRow null_space_row(VerificationElement element, const VerificationLaw& law, int pieces)
    {
        const Stopwatch watch;
        const mesh::TetMesh mesh = side_by_side(for_element(distorted_box(2, 1.0, 0.2, 2), element), pieces);
        fem::ElasticBody body = make_body(mesh, element, law);
        const Eigen::MatrixXd K
            = test_support::dense(body.stiffness(Eigen::VectorXd::Zero(3 * mesh.vertices.rows()), 0.0));
        const Eigen::VectorXd values = fem::symmetric_modes(K).values;
        constexpr double kZero = 1e-11; // relative to the largest eigenvalue
        const auto count = (values.array() < kZero * values.maxCoeff()).count();
        VerificationRow row
            = describe("null space, " + std::to_string(pieces) + " piece(s)", element, law, mesh, watch);
        compare(row, "zero eigenvalues", static_cast<double>(count), 6.0 * pieces);
        row.bound = 0.0;
        return row;
    }

    VerificationRow rotation_row(VerificationElement element, const VerificationLaw& law)
    {
        const Stopwatch watch;
        const mesh::TetMesh mesh = for_element(distorted_box(3, 1.0, 0.2, 3), element);
        const Mat3 R = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3(1, 1, 0).normalized()).toRotationMatrix();
        fem::ElasticBody body = make_body(mesh, element, law);
        const double energy
            = body.response(nodal_values(mesh, [&](const Vec3& p) -> Vec3 { return R * p - p + Vec3(5, 0, 0); }))
                  .energy;
        VerificationRow row = describe("rotation by 90 degrees", element, law, mesh, watch);
        const fem::Lame l = linear_law(kPatchYoung, kPatchPoisson).lame;
        const double scale = l.mu * 27.0; // shear modulus times volume, N mm
        if (law.model == fem::Elasticity::linear) {
            const Mat3 strain = 0.5 * (R + R.transpose()) - Mat3::Identity();
            compare(row, "energy / (mu V)", energy / scale,
                strain.squaredNorm() + 0.5 * l.lambda / l.mu * std::pow(strain.trace(), 2));
            row.note = "small strain is not free of rotation: the linear model must show this energy";
        } else {
            compare(row, "energy / (mu V)", energy / scale, 0.0);
        }
        row.bound = 1e-12; // round-off
        return row;
    }

} // namespace

VerificationProblem patch_test_problem()
{
    return { "patch test",
        "a linear displacement field on a distorted mesh comes back exactly, also after a quarter of a turn and across "
        "a cut whose lips are tied again",
        [](const VerificationOptions&, const Job& job) {
            std::vector<VerificationRow> rows;
            const std::array<TiedMesh, 3> tied { cut_and_tied_box(3), cut_and_tied_box(4), cut_and_tied_box(5) };
            for (const VerificationElement element : all_elements())
                for (const VerificationLaw& law : all_laws())
                    for (const int cells : { 2, 3, law.model == fem::Elasticity::linear ? 5 : 4 })
                        if (!job.cancelled())
                            rows.push_back(patch_row(element, law, cells, job));
            for (const VerificationElement element : all_elements())
                for (const VerificationLaw& law : all_laws())
                    // linear elasticity strains under a rotation
                    for (const int cells : { 2, 3, 4 })
                        if (!job.cancelled() && law.model != fem::Elasticity::linear)
                            rows.push_back(turned_patch_row(element, law, cells, job));
            for (const VerificationElement element : all_elements())
                for (const VerificationLaw& law : all_laws())
                    for (const TiedMesh& box : tied)
                        if (!job.cancelled() && law.model != fem::Elasticity::hyperelastic)
                            rows.push_back(tied_patch_row(box, element, law, job));
            return rows;
        } };
}

VerificationProblem null_space_problem()
{
    return { "null space", "six zero eigenvalues per free piece; a rotation costs no energy",
        [](const VerificationOptions&, const Job& job) {
            std::vector<VerificationRow> rows;
            for (const VerificationElement element : all_elements())
                for (const VerificationLaw& law : all_laws()) {
                    for (int pieces = 1; pieces <= 2 && !job.cancelled(); ++pieces)
                        rows.push_back(null_space_row(element, law, pieces));
                    rows.push_back(rotation_row(element, law));
                }
            return rows;
        } };
}

} // namespace retractor::verification
