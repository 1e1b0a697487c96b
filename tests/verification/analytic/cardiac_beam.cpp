// Validation problem 12: the first problem of the cardiac mechanics benchmark [Land et al. 2015, doi
// 10.1098/rspa.2015.0641].

#include "tests/verification/analytic/analytic_problems.h"

#include "mesh/base/text_format.h"
#include "tests/verification/framework/meshes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace retractor::verification {

namespace {

    constexpr double kC = 0.002, kBeamPressure = 4e-6; // MPa
    constexpr double kMuscleBulk = 0.5; // MPa: gives a volume change of 1e-4 at the stresses that occur
    constexpr double kLowest = 4.0, kHighest = 4.2; // mm, range of the eleven published codes
    constexpr double kHalfRange = (kHighest - kLowest) / (kHighest + kLowest); // relative to the middle of the range

    const OrderRule kCoarseBeam { .asks = OrderRule::Asks::fall,
        .why = "one to four cells of linear elements bend too little or, averaged, too much" };

    VerificationRow beam(VerificationElement element, int cells, const Job& job)
    {
        const mesh::TetMesh mesh = mapped_box(
            nodes_per_tet(element), 10 * cells, cells, cells, [&](const Vec3& p) -> Vec3 { return p / cells; });
        constexpr double kTiny = 1e-9;
        Held held = hold_nothing(mesh);
        VertexId tip = 0;
        double nearest = 1e9;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v) {
            const Vec3 p = mesh.vertices.row(v).transpose();
            if (p.x() < kTiny)
                for (int axis = 0; axis < 3; ++axis)
                    hold(held, v, axis);
            if (const double d = (p - Vec3(10.0, 0.5, 1.0)).norm(); d < nearest) {
                nearest = d;
                tip = v;
            }
        }
        const VerificationLaw law = hyperelastic_law("Guccione", fem::Guccione { kC, 8.0, 2.0, 4.0, kMuscleBulk });
        fem::ElasticBody body = make_body(mesh, element, law);
        const auto bottom = faces_where(mesh, [&](const Vec3& p) { return p.z() < kTiny; });
        body.set_loads({ {}, { fem::FollowerPressure(mesh, bottom, kBeamPressure) } });
        const VerificationSolve solve
            = solve_problem(body, held.prescribed, {}, { .load_steps = 5, .max_newton_iterations = 60 }, job);
        VerificationRow row = make_row("cardiac benchmark 1", element, law, mesh, solve);
        const double middle = 0.5 * (kLowest + kHighest);
        compare(row, "height of the deformed tip, mm",
            mesh.vertices(tip, 2) + solve.equilibrium.displacement[3 * tip + 2], middle);
        row.size = 1.0 / cells;
        if (nearest > kTiny)
            row.note = "tip taken at a node beside the middle";
        return row;
    }

    /// Note of a row without a bound: inside the published range, or the distance outside.
    void say_where(VerificationRow& row)
    {
        const double outside = std::max(kLowest - row.value, row.value - kHighest);
        row.note = outside > 0.0
            ? formatted("OUTSIDE the published %.1f to %.1f mm by %.3f mm", kLowest, kHighest, outside)
            : "within the published range";
    }

} // namespace

VerificationProblem cardiac_beam_problem()
{
    return { "cardiac benchmark 1", "beam under follower pressure, Guccione: 4.0 to 4.2 mm, compared with the middle",
        [](const VerificationOptions& options, const Job& job) {
            std::vector<VerificationRow> rows;
            for (const VerificationElement element : { VerificationElement::p1, VerificationElement::locking_free,
                     VerificationElement::nodal, VerificationElement::p2 }) {
                const bool quadratic = element == VerificationElement::p2;
                std::vector<int> meshes = quadratic ? std::vector<int> { 1, 2, 3 } : std::vector<int> { 1, 2, 4 };
                if (options.fine)
                    meshes.push_back(quadratic ? 4 : 6);
                std::vector<VerificationRow> series;
                for (const int cells : coarsest(meshes, options))
                    if (!job.cancelled())
                        series.push_back(beam(element, cells, job));
                if (!series.empty() && !quadratic)
                    say_where(series.back());
                append_series(rows, series, std::numeric_limits<double>::quiet_NaN(), quadratic ? kHalfRange : kNoBound,
                    quadratic ? OrderRule {} : kCoarseBeam);
            }
            return rows;
        },
        "laws but Guccione's: the benchmark is his" };
}

} // namespace retractor::verification
