// A slender cantilever whose tip turns by 45 degrees under a dead load: the elastica [Euler 1744; Bisshopp, Drucker
// 1945, doi 10.1090/qam/13360]. Corotational and hyperelastic elements are compared.

#include "tests/verification/analytic/analytic_problems.h"

#include "fem/model/loads.h"
#include "tests/verification/framework/meshes.h"

#include <cmath>
#include <limits>

namespace retractor::verification {

namespace {

    // mm, MPa; Poisson's ratio is zero, as in a beam
    constexpr double kBeamLength = 20.0, kBeamHeight = 1.0, kBeamYoung = 1.0;
    constexpr double kLoad = 2.0; // P L^2 / (E I)
    constexpr double kDeflection = 0.49346; // relative to the length [Mattiasson 1981, doi 10.1002/nme.1620170113]
    /// Additional deflection by shear, 0.6 (h / L)^2 of the deflection, and by stretching, which the elastica omits.
    constexpr double kSlender = 0.6 * kBeamHeight * kBeamHeight / (kBeamLength * kBeamLength);

    VerificationRow cantilever(VerificationElement element, const VerificationLaw& law, int n, const Job& job)
    {
        const mesh::TetMesh mesh = mapped_box(nodes_per_tet(element), 10 * n, n, n, [&](const Vec3& p) -> Vec3 {
            return { 0.1 * kBeamLength / n * p.x(), p.y() / n, p.z() / n };
        });
        constexpr double kTiny = 1e-9;
        Held held = hold_nothing(mesh);
        std::vector<VertexId> corners; // corners of the free end
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v) {
            const Vec3 p = mesh.vertices.row(v).transpose();
            const auto at_rim = [](double x) { return x < kTiny || x > kBeamHeight - kTiny; };
            if (p.x() < kTiny)
                for (int axis = 0; axis < 3; ++axis)
                    hold(held, v, axis);
            else if (p.x() > kBeamLength - kTiny && at_rim(p.y()) && at_rim(p.z()))
                corners.push_back(v);
        }
        fem::ElasticBody body = make_body(mesh, element, law);
        const double inertia = std::pow(kBeamHeight, 4) / 12.0;
        const double force = kLoad * kBeamYoung * inertia / (kBeamLength * kBeamLength);
        const auto end = faces_where(mesh, [](const Vec3& p) { return p.x() > kBeamLength - kTiny; });
        body.set_loads({ fem::traction_loads(mesh, end, { 0.0, 0.0, force / (kBeamHeight * kBeamHeight) }), {} });
        const VerificationSolve solve
            = solve_problem(body, held.prescribed, {}, { .load_steps = 4, .tolerance = 1e-6 }, job);
        VerificationRow row = make_row("cantilever, large rotation", element, law, mesh, solve);
        double moved = 0.0;
        for (const VertexId v : corners)
            moved += solve.equilibrium.displacement[3 * v + 2] / static_cast<double>(corners.size());
        compare(row, "deflection of the tip, mm", moved, kDeflection * kBeamLength);
        row.size = 1.0 / n;
        return row;
    }

} // namespace

VerificationProblem cantilever_problem()
{
    return { "large rotation",
        "cantilever of 20 x 1 x 1 mm under a dead tip load of 2 E I / L^2: 0.49346 L [elastica]; exact to what shear "
        "adds, 0.15 %",
        [](const VerificationOptions& options, const Job& job) {
            VerificationLaw corotational = linear_law(kBeamYoung, 0.0);
            corotational.name = "corotational";
            corotational.model = fem::Elasticity::corotational;
            const VerificationLaw hyperelastic
                = hyperelastic_law("neo-Hookean", fem::NeoHookean { corotational.lame.mu, corotational.lame.lambda });
            struct Run {
                VerificationElement element;
                std::vector<int> meshes;
                double order, bound;
                std::string why_falls {}; ///< reason why no order is visible
            };
            const Run runs[] = { { VerificationElement::p1, { 1, 2, 3 }, 2.0, kNoBound, "far too stiff in bending" },
                { VerificationElement::locking_free, { 1, 2, 3 }, 2.0, 0.05 },
                { VerificationElement::nodal, { 1, 2, 3 }, 2.0, kNoBound,
                    "too soft on so few cells, and on one too stiff" },
                { VerificationElement::p2, { 1, 2, 3 }, 3.0, 0.005 } };
            std::vector<VerificationRow> rows;
            for (const Run& run : runs)
                for (const VerificationLaw& law : { corotational, hyperelastic }) {
                    std::vector<VerificationRow> series;
                    for (const int n : coarsest(run.meshes, options))
                        if (!job.cancelled())
                            series.push_back(cantilever(run.element, law, n, job));
                    append_series(rows, series, run.order, run.bound,
                        run.why_falls.empty()
                            ? OrderRule { .floor = kSlender, .why = "shear, which the elastica does not know" }
                            : OrderRule { .asks = OrderRule::Asks::fall, .why = run.why_falls });
                }
            return rows;
        },
        "linear tissue, which does not turn; laws but neo-Hookean: a slender beam strains little, and all isotropic "
        "laws are alike there" };
}

} // namespace retractor::verification
