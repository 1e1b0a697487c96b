// Validation problem 10: a smooth displacement field on the unit box and the body force that belongs to the field.
// Orders of convergence.

#include "tests/verification/analytic/analytic_problems.h"

#include "tests/verification/framework/body_force.h"
#include "tests/verification/framework/meshes.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace retractor::verification {

namespace {

    Vec3 smooth(const Vec3& p)
    {
        return { std::sin(std::numbers::pi * p.x()) * std::sin(std::numbers::pi * p.y())
                * std::sin(std::numbers::pi * p.z()),
            0.0, 0.0 };
    }

    /// The body force - div sigma of `smooth`.
    Vec3 smooth_force(const fem::Lame& l, const Vec3& p)
    {
        const double sx = std::sin(std::numbers::pi * p.x()), sy = std::sin(std::numbers::pi * p.y()),
                     sz = std::sin(std::numbers::pi * p.z());
        const double cx = std::cos(std::numbers::pi * p.x()), cy = std::cos(std::numbers::pi * p.y()),
                     cz = std::cos(std::numbers::pi * p.z());
        const double shared = std::numbers::pi * std::numbers::pi * (l.lambda + l.mu);
        return { std::numbers::pi * std::numbers::pi * 3.0 * l.mu * sx * sy * sz + shared * sx * sy * sz,
            -shared * cx * cy * sz, -shared * cx * sy * cz };
    }

    struct ManufacturedSeries {
        std::vector<VerificationRow> l2, energy;
    };

    ManufacturedSeries series(VerificationElement element, const std::vector<int>& meshes, const Job& job)
    {
        const VerificationLaw law = linear_law(1.0, 0.3);
        ManufacturedSeries all;
        for (const int cells : meshes) {
            if (job.cancelled())
                break;
            const mesh::TetMesh mesh = mapped_box(
                nodes_per_tet(element), cells, cells, cells, [&](const Vec3& p) -> Vec3 { return p / cells; });
            const Held held = hold_boundary(mesh, [](const Vec3&) -> Vec3 { return Vec3::Zero(); });
            const Eigen::VectorXd loads
                = body_force_loads(mesh, [&](const Vec3& p) { return smooth_force(law.lame, p); });
            fem::ElasticBody body = make_body(mesh, element, law);
            body.set_loads({ loads, {} });
            const VerificationSolve solve = solve_problem(body, held.prescribed, {}, { .tolerance = 1e-10 }, job);
            VerificationRow row = make_row("manufactured", element, law, mesh, solve);
            row.size = 1.0 / cells;
            const double norm = std::sqrt(1.0 / 8.0); // norm of the exact field
            compare(row, "error in L2, relative", l2_error(mesh, solve.equilibrium.displacement, smooth) / norm, 0.0);
            all.l2.push_back(row);
            // By Galerkin orthogonality |u - u_h|^2 in energy = a(u, u) - a(u_h, u_h), where u_h minimises the true
            // energy.
            const double exact = std::numbers::pi * std::numbers::pi * (4.0 * law.lame.mu + law.lame.lambda) / 8.0;
            compare(row, "error in energy, relative",
                std::sqrt(std::max(0.0, exact - loads.dot(solve.equilibrium.displacement)) / exact), 0.0);
            all.energy.push_back(row);
        }
        return all;
    }

    const OrderRule kSmooth { .slack = 0.3 }; // these coarse meshes are not yet in the asymptotic range

} // namespace

VerificationProblem manufactured_problem()
{
    return { "manufactured", "smooth field on the unit box: orders 2 in L2 and 1 in energy for P1, 3 and 2 for P2",
        [](const VerificationOptions& options, const Job& job) {
            std::vector<VerificationRow> rows;
            for (const VerificationElement element : { VerificationElement::p1, VerificationElement::locking_free,
                     VerificationElement::nodal, VerificationElement::p2 }) {
                const bool quadratic = element == VerificationElement::p2;
                std::vector<int> meshes = quadratic ? std::vector<int> { 2, 4, 8 } : std::vector<int> { 4, 8, 16 };
                if (options.fine)
                    meshes.push_back(2 * meshes.back());
                ManufacturedSeries all = series(element, coarsest(meshes, options), job);
                append_series(rows, all.l2, quadratic ? 3.0 : 2.0, kNoBound, kSmooth);
                if (element == VerificationElement::p1 || quadratic)
                    append_series(rows, all.energy, quadratic ? 2.0 : 1.0, kNoBound, kSmooth);
            }
            return rows;
        },
        "laws but linear: orders are the element's" };
}

} // namespace retractor::verification
