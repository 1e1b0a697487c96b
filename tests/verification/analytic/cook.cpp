// Validation problem 11: Cook's membrane [Cook 1974].

#include "tests/verification/analytic/analytic_problems.h"

#include "tests/verification/framework/meshes.h"

namespace retractor::verification {

namespace {

    constexpr double kPublished = 23.96, kDigits = 0.005; // mm

    VerificationRow membrane(VerificationElement element, int cells, const Job& job)
    {
        const mesh::TetMesh mesh = mapped_box(nodes_per_tet(element), cells, cells, 1, [&](const Vec3& p) -> Vec3 {
            const double s = p.x() / cells, t = p.y() / cells;
            return { 48.0 * s, 44.0 * s + t * (44.0 - 28.0 * s), p.z() };
        });
        const double tiny = 1e-6;
        Held held = hold_nothing(mesh);
        VertexId middle = 0;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v) {
            const Vec3 p = mesh.vertices.row(v).transpose();
            if (p.x() < tiny)
                for (const int axis : { 0, 1 })
                    hold(held, v, axis);
            if (p.z() < tiny) // one face is held in its plane, the other is free: plane stress
                hold(held, v, 2);
            if ((p - Vec3(48.0, 52.0, 0.0)).norm() < tiny)
                middle = v;
        }
        const VerificationLaw law = linear_law(1.0, 1.0 / 3.0);
        fem::ElasticBody body = make_body(mesh, element, law);
        const auto right = faces_where(mesh, [&](const Vec3& p) { return p.x() > 48.0 - tiny; });
        body.set_loads({ fem::traction_loads(mesh, right, { 0.0, 1.0 / 16.0, 0.0 }), {} });
        const VerificationSolve solve = solve_problem(body, held.prescribed, {}, { .tolerance = 1e-9 }, job);
        VerificationRow row = make_row("Cook's membrane", element, law, mesh, solve);
        compare(row, "displacement at (48, 52), mm", solve.equilibrium.displacement[3 * middle + 1], kPublished);
        row.size = 1.0 / cells;
        return row;
    }

} // namespace

VerificationProblem cook_problem()
{
    return { "Cook's membrane",
        "plane stress, 23.96 mm (four digits); its clamped corners hold P1 to an order of about 1.4 in the end",
        [](const VerificationOptions& options, const Job& job) {
            std::vector<VerificationRow> rows;
            for (const VerificationElement element : { VerificationElement::p1, VerificationElement::locking_free,
                     VerificationElement::nodal, VerificationElement::p2 }) {
                const bool quadratic = element == VerificationElement::p2;
                std::vector<int> meshes = quadratic ? std::vector<int> { 4, 8, 16 } : std::vector<int> { 8, 16, 32 };
                if (options.fine)
                    meshes.push_back(2 * meshes.back());
                std::vector<VerificationRow> series;
                for (const int cells : coarsest(meshes, options))
                    if (!job.cancelled())
                        series.push_back(membrane(element, cells, job));
                append_series(rows, series, 1.4, element == VerificationElement::p1 ? 0.05 : 0.01,
                    { .floor = kDigits / kPublished, .why = "the published value has four digits" });
            }
            return rows;
        },
        "laws but linear: the published value is linear" };
}

} // namespace retractor::verification
