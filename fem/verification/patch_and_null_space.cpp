// Validation problems 1 and 2: what an element must do exactly.

#include "fem/verification/meshes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor {

namespace {

    constexpr double kYoung = 1.0, kPoisson = 0.3;

    const std::vector<VerificationElement>& all_elements()
    {
        static const std::vector<VerificationElement> elements { VerificationElement::p1,
            VerificationElement::locking_free, VerificationElement::nodal, VerificationElement::p2 };
        return elements;
    }

    std::vector<VerificationLaw> all_laws()
    {
        const Lame l = linear_law(kYoung, kPoisson).lame;
        const double bulk = l.lambda + 2.0 / 3.0 * l.mu;
        return { linear_law(kYoung, kPoisson), { "corotational", Elasticity::corotational, l, {}, {} },
            hyperelastic_law("neo-Hookean", NeoHookean { l.mu, l.lambda }),
            hyperelastic_law("Mooney-Rivlin", MooneyRivlin { 0.4 * l.mu, 0.1 * l.mu, bulk }),
            hyperelastic_law("Holzapfel-Gasser-Ogden", HolzapfelGasserOgden { l.mu, l.mu, 2.0, 0.1, bulk }),
            hyperelastic_law("Guccione", Guccione { 0.1 * l.mu, 8.0, 2.0, 4.0, bulk }) };
    }

    TetMesh for_element(const TetMesh& mesh, VerificationElement element)
    {
        return nodes_per_tet(element) == 10 ? with_midpoints(mesh) : mesh;
    }

    Vec3 linear_field(const Vec3& p)
    {
        Mat3 gradient;
        gradient << 0.01, 0.02, -0.03, 0.005, -0.01, 0.015, 0.02, 0.0, 0.03;
        return gradient * p + Vec3(0.1, 0.2, 0.3);
    }

    VerificationRow patch_row(VerificationElement element, const VerificationLaw& law, int cells, const Job& job)
    {
        const TetMesh mesh = for_element(distorted_box(cells, 1.0, 0.15, 1), element);
        const Held held = hold_boundary(mesh, linear_field);
        ElasticBody body = make_body(mesh, element, law);
        const VerificationSolve solve = solve_problem(body, held.prescribed, held.target, { .tolerance = 1e-12 }, job);
        VerificationRow row = make_row("patch test", element, law, mesh, solve);
        const Eigen::VectorXd exact = nodal_values(mesh, linear_field);
        compare(row, "largest error of the displacement, mm",
            (solve.equilibrium.displacement - exact).cwiseAbs().maxCoeff(), 0.0);
        row.bound = law.model == Elasticity::linear ? 1e-12 : 1e-9; // round-off; Newton's tolerance
        return row;
    }

    VerificationRow describe(const std::string& problem, VerificationElement element, const VerificationLaw& law,
        const TetMesh& mesh, const Stopwatch& watch)
    {
        VerificationRow row = make_row(problem, element, law, mesh, {});
        row.seconds = watch.seconds();
        return row;
    }

    VerificationRow null_space_row(VerificationElement element, const VerificationLaw& law, int pieces)
    {
        const Stopwatch watch;
        const TetMesh mesh = side_by_side(for_element(distorted_box(2, 1.0, 0.2, 2), element), pieces);
        ElasticBody body = make_body(mesh, element, law);
        const Eigen::MatrixXd K = dense(body.stiffness(Eigen::VectorXd::Zero(3 * mesh.vertices.rows()), 0.0));
        const Eigen::VectorXd values
            = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K, Eigen::EigenvaluesOnly).eigenvalues();
        constexpr double kZero = 1e-11; // of the largest
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
        const TetMesh mesh = for_element(distorted_box(3, 1.0, 0.2, 3), element);
        const Mat3 R = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3(1, 1, 0).normalized()).toRotationMatrix();
        ElasticBody body = make_body(mesh, element, law);
        const double energy
            = body.response(nodal_values(mesh, [&](const Vec3& p) -> Vec3 { return R * p - p + Vec3(5, 0, 0); }))
                  .energy;
        VerificationRow row = describe("rotation by 90 degrees", element, law, mesh, watch);
        const double scale = linear_law(kYoung, kPoisson).lame.mu * 27.0; // shear modulus times volume
        compare(row, "energy / (mu V)", energy / scale, 0.0);
        if (law.model == Elasticity::linear)
            row.note = "small strain is not free of rotation: the linear model must show an energy here";
        else
            row.bound = 1e-12; // round-off
        return row;
    }

} // namespace

VerificationProblem patch_test_problem()
{
    return { "patch test", "a linear displacement field on a distorted mesh comes back exactly",
        [](const VerificationOptions&, const Job& job) {
            std::vector<VerificationRow> rows;
            for (const VerificationElement element : all_elements())
                for (const VerificationLaw& law : all_laws())
                    for (const int cells : { 2, 3, law.model == Elasticity::linear ? 5 : 4 })
                        if (!job.cancelled())
                            rows.push_back(patch_row(element, law, cells, job));
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

} // namespace retractor
