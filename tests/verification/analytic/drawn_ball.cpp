// A rigid ball that is moved within an elastic ball with a fixed outside. The closed form is smooth in all of space
// and needs no planes of symmetry, so OnlineOpening can solve the problem too, with the inner ball as a hook.
//
// The field is linear in the direction e of the motion: u = A e + B r^2 e + C (e . r) r with constants for the
// regular part, and Kelvin's and the dipole's field for the singular part [Love, Mathematical theory of elasticity,
// 1927, art. 174]. The four constants follow from u = d e at the ball and u = 0 outside.

#include "tests/verification/analytic/analytic_problems.h"

#include "fem/interactive/online_opening.h"
#include "mesh/base/error.h"
#include "mesh/base/job.h"
#include "mesh/cutting/cut_session.h"
#include "tests/verification/framework/meshes.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace retractor::verification {

namespace {

    constexpr double kBall = 10.0, kShell = 30.0; // mm
    const fem::Material kBallTissue { "tissue", 0.01, 0.3, 1e-9, "reference" };
    constexpr double kDrawn = 2.0; // mm
    const Vec3 kDirection(0.6, 0.0, 0.8);
    constexpr double kOnBall = 1e-6; // relative to the radius

    /// Force on the ball, N. Each term has a part along e and a part along (e . r) r / r^2, at the two radii.
    double exact_force()
    {
        const double nu = kBallTissue.poissons_ratio;
        const double mu = fem::lame(kBallTissue).mu;
        const double alpha = -(4.0 - 6.0 * nu) / (3.0 - 2.0 * nu); // keeps r^2 e + alpha (e . r) r in equilibrium
        Eigen::Matrix4d A;
        for (const int end : { 0, 1 }) {
            const double r = end == 0 ? kBall : kShell;
            A.row(2 * end) << 1.0, r * r, (3.0 - 4.0 * nu) / r, 1.0 / (r * r * r);
            A.row(2 * end + 1) << 0.0, alpha * r * r, 1.0 / r, -3.0 / (r * r * r);
        }
        const Eigen::Vector4d c = A.fullPivLu().solve(Eigen::Vector4d(kDrawn, 0.0, 0.0, 0.0));
        return 16.0 * std::numbers::pi * mu * (1.0 - nu) * c[2]; // only Kelvin's part carries a force
    }

    /// The cube -m .. m without the cube -hole .. hole. Each octant is a mirror image of the first, whose elements
    /// lie on one side of the planes where two coordinates are equal.
    mesh::TetMesh mirrored_cube(int m, int hole)
    {
        const mesh::TetMesh octant = mesh::kuhn_box(m, m, m, 1.0);
        mesh::TetMesh mesh;
        std::map<std::array<long, 3>, VertexId> id_at;
        std::vector<Vec3> places;
        const auto id = [&](const Vec3& p) {
            const auto [at, added] = id_at.try_emplace(
                { std::lround(p.x()), std::lround(p.y()), std::lround(p.z()) }, static_cast<VertexId>(places.size()));
            if (added)
                places.push_back(p);
            return at->second;
        };
        for (int image = 0; image < 8; ++image) {
            const Vec3 sign(
                (image & 1) != 0 ? -1.0 : 1.0, (image & 2) != 0 ? -1.0 : 1.0, (image & 4) != 0 ? -1.0 : 1.0);
            for (TetId t = 0; t < static_cast<TetId>(octant.tet_count()); ++t) {
                std::array<Vec3, 4> corners;
                double farthest = 0.0;
                for (std::size_t a = 0; a < 4; ++a) {
                    corners[a] = octant.vertices.row(octant.tet(t)[a]).transpose();
                    farthest = std::max(farthest, corners[a].maxCoeff());
                }
                if (farthest < hole + 0.5)
                    continue;
                if (sign.prod() < 0.0)
                    std::swap(corners[2], corners[3]);
                for (const Vec3& corner : corners)
                    mesh.nodes.push_back(id(sign.cwiseProduct(corner)));
                mesh.labels.push_back(1);
            }
        }
        mesh.vertices.resize(static_cast<Eigen::Index>(places.size()), 3);
        for (std::size_t v = 0; v < places.size(); ++v)
            mesh.vertices.row(static_cast<Eigen::Index>(v)) = places[v].transpose();
        return mesh;
    }

    /// A mesh with n cells from the ball's middle to its edge along its surface, and n growing cells from its surface
    /// to the outside.
    mesh::TetMesh ball_mesh(int nodes_per_tet, int n)
    {
        mesh::TetMesh mesh = mirrored_cube(2 * n, n);
        if (nodes_per_tet == 10)
            mesh = mesh::with_midpoints(mesh);
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
            const Vec3 p = mesh.vertices.row(v).transpose();
            const double outwards = p.cwiseAbs().maxCoeff() / n - 1.0; // 0 to 1
            mesh.vertices.row(v) *= kBall * std::pow(kShell / kBall, outwards) / p.norm();
        }
        mesh::check_mesh(mesh);
        return mesh;
    }

    std::vector<VertexId> at_radius(const mesh::TetMesh& mesh, double radius)
    {
        std::vector<VertexId> nodes;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (std::abs(mesh.vertices.row(v).norm() - radius) < kOnBall * radius)
                nodes.push_back(v);
        return nodes;
    }

    void compare_force(VerificationRow& row, const Vec3& force, int n)
    {
        compare(row, "force, N", force.dot(kDirection), exact_force());
        row.size = 1.0 / n;
    }

    VerificationRow at_once(VerificationElement element, int n, const Job& job)
    {
        const mesh::TetMesh mesh = ball_mesh(nodes_per_tet(element), n);
        const std::vector<VertexId> ball = at_radius(mesh, kBall);
        Held held = hold_nothing(mesh);
        for (int axis = 0; axis < 3; ++axis) {
            for (const VertexId v : at_radius(mesh, kShell))
                hold(held, v, axis);
            for (const VertexId v : ball)
                hold(held, v, axis, kDrawn * kDirection[axis]);
        }
        const VerificationLaw law = linear_law(kBallTissue.youngs_modulus_MPa, kBallTissue.poissons_ratio);
        fem::ElasticBody body = make_body(mesh, element, law);
        const VerificationSolve solve = solve_problem(body, held.prescribed, held.target, { .tolerance = 1e-9 }, job);
        VerificationRow row = make_row("ball drawn within a ball", element, law, mesh, solve);
        Vec3 force = Vec3::Zero();
        for (const VertexId v : ball)
            force += solve.equilibrium.forces.segment<3>(3 * v);
        compare_force(row, force, n);
        return row;
    }

    /// A cut from the top, half way to the ball.
    mesh::Blade blade()
    {
        const double top = kShell + 1.0, deep = 0.5 * (kShell + kBall);
        return {
            .line = { { -8.0, 0.7, top }, { 8.0, 1.3, top } }, .directions = { -Vec3::UnitZ() }, .depth_mm = top - deep
        };
    }

    /// The fast path: the body was factored before, is cut, and the cut is undone; the solver follows every step.
    /// Then the ball is moved. Two rows: the hook's force with the whole field after attaching the hook, and after
    /// dragging the hook by its columns.
    std::array<VerificationRow, 2> drawn_after_cutting(fem::BodyKept kept, const std::string& name, int n)
    {
        mesh::CutSession session(ball_mesh(4, n));
        const mesh::TetMesh uncut = session.compact_mesh();
        const std::vector<VertexId> ball = at_radius(uncut, kBall);
        fem::OnlineOptions options;
        options.body = kept;
        fem::OnlineOpening opening(
            session, std::vector<fem::Material>(2, kBallTissue), { .fixed = at_radius(uncut, kShell) }, ball, options);
        const fem::HookId hook = opening.attach({ .name = "ball", .side = 1, .nodes = ball, .drive = {} });
        const auto solved = [&](const fem::OnlineAnswer& answer) {
            if (answer.status != fem::OnlineStatus::solved)
                throw SolverError("the ball's pull was not followed: " + answer.message);
        };
        const mesh::CutResult cut = session.cut(blade());
        if (cut.status != mesh::CutStatus::done)
            throw SolverError("the ball was not cut: " + cut.message);
        opening.follow(cut.delta, session.lips());
        solved(opening.answer());
        const Stopwatch watch;
        opening.follow(session.undo(), session.lips());
        opening.drive(hook, { .displacement = kDrawn * kDirection });
        fem::OnlineAnswer answer = opening.answer();
        solved(answer);
        opening.complete(answer);
        VerificationRow row;
        row.problem = "ball drawn within a ball";
        row.element = "P1, " + name;
        row.law = "linear";
        row.nodes = uncut.vertex_count();
        row.tets = uncut.tet_count();
        row.seconds = watch.seconds();
        row.residual = answer.residual;
        compare_force(row, answer.hook_forces_N.at(0), n);
        (void)opening.prepare_drag();
        opening.drive(hook, { .displacement = kDrawn * kDirection });
        const Stopwatch frame;
        const fem::OnlineAnswer dragged = opening.drag_answer();
        VerificationRow drag = row;
        drag.seconds = frame.seconds();
        solved(dragged);
        drag.element = "P1, dragged, " + name;
        drag.residual = dragged.residual;
        compare_force(drag, dragged.hook_forces_N.at(0), n);
        return { row, drag };
    }

} // namespace

VerificationProblem drawn_ball_problem()
{
    return { "ball drawn within a ball",
        "rigid ball of 10 mm drawn by 2 mm within one of 30 mm that is held outside, closed form; also as a hook, "
        "after a cut that is undone, with the body condensed and divided, and dragged by its columns",
        [](const VerificationOptions& options, const Job& job) {
            constexpr double kBound = 0.05, kQuadratic = 0.01;
            std::vector<VerificationRow> rows;
            for (const VerificationElement element : { VerificationElement::p1, VerificationElement::locking_free,
                     VerificationElement::nodal, VerificationElement::p2 }) {
                const bool linear = element == VerificationElement::p1;
                std::vector<int> meshes = linear ? std::vector<int> { 2, 3, 4 } : std::vector<int> { 1, 2, 3 };
                if (options.fine)
                    meshes.push_back(meshes.back() + 2);
                std::vector<VerificationRow> series;
                for (const int n : coarsest(meshes, options))
                    if (!job.cancelled())
                        series.push_back(at_once(element, n, job));
                const bool quadratic = element == VerificationElement::p2;
                // With one to three cells from the ball to the outside P2 approaches its order from below.
                if (element == VerificationElement::nodal)
                    append_series(rows, series, 2.0, kNoBound,
                        { .asks = OrderRule::Asks::fall,
                            .why = "too soft on so few cells: five make 4 %, at an order of 1.5" });
                else
                    append_series(rows, series, quadratic ? 4.0 : 2.0, quadratic ? kQuadratic : kBound,
                        { .slack = quadratic ? 0.7 : 0.5 });
            }
            for (const auto& [kept, name] : { std::pair { fem::BodyKept::condensed, "cut undone" },
                     std::pair { fem::BodyKept::dissected, "cut undone, in parts" } }) {
                std::array<std::vector<VerificationRow>, 2> series;
                for (const int n : coarsest(std::vector<int> { 2, 3, 4 }, options)) {
                    if (job.cancelled())
                        break;
                    const std::array<VerificationRow, 2> both = drawn_after_cutting(kept, name, n);
                    for (std::size_t i = 0; i < 2; ++i)
                        series[i].push_back(both[i]);
                }
                for (std::vector<VerificationRow>& s : series)
                    append_series(rows, s, 2.0, kBound);
            }
            return rows;
        },
        "laws but linear: the closed form is of small strain" };
}

} // namespace retractor::verification
