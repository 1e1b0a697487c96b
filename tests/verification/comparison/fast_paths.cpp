// Problems 3, 6, 7 and 11 by the fast paths: OnlineOpening (condensed body and multifrontal factor) after a cut that
// is undone, by a solution and dragged; and NonlinearRegion with linear tissue round a nonlinear region. Each answer
// is compared with the closed form and with the exact path's answer to the same equations. Four-node elements only,
// as in the fast paths.
//
// The fast paths hold vertices and patches, not single axes. Planes of symmetry therefore become whole bodies,
// tractions become forces of hooks that each hold the nodes through the thickness, and a frictionless punch becomes a
// bonded punch.

#include "tests/verification/comparison/solver_problems.h"

#include "fem/interactive/online_opening.h"
#include "fem/model/loads.h"
#include "fem/statics/nonlinear_region.h"
#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "mesh/base/job.h"
#include "mesh/cutting/cut_session.h"
#include "tests/verification/framework/half_space.h"
#include "tests/verification/framework/incision.h"
#include "tests/verification/framework/vessel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

namespace retractor::verification {

namespace {

    constexpr double kTiny = 1e-6; // mm
    // relative to the largest displacement or force: residuals are 1e-8, and forces are computed from them
    constexpr double kSame = 1e-7;

    /// A body that hooks pull, and a cut that is made and undone before.
    struct Scene {
        std::string problem, quantity;
        mesh::TetMesh mesh {};
        std::vector<fem::Material> materials {};
        fem::Supports supports {};
        std::vector<fem::OnlineHook> hooks {};
        mesh::Blade blade {};
        double size = 0.0, expected = 0.0;
        /// The compared quantity.
        /// @param displacements of the hooks, mm.
        /// @param forces that the hooks apply, N.
        std::function<double(const std::vector<Vec3>& displacements, const std::vector<Vec3>& forces)> value {};
    };

    /// The largest difference from Opening with the hooks at the answer's positions: of displacements relative to the
    /// largest displacement, and of hook forces relative to the largest force.
    double apart_from_exact(
        const Scene& scene, const mesh::CutSession& session, const fem::OnlineAnswer& answer, const Job& job)
    {
        std::vector<fem::OnlineHook> held = scene.hooks;
        for (std::size_t i = 0; i < held.size(); ++i)
            held[i].drive = { .displacement = answer.hook_displacements[i] };
        const fem::ElasticProblem problem = problem_now(session, scene.materials, scene.supports, held);
        mesh::SlotMap map;
        (void)session.compact_mesh(&map);
        fem::Opening opening(problem.mesh, problem.material_of_label, problem.supports,
            { .elasticity = fem::Elasticity::linear, .tolerance = 1e-9 });
        const fem::OpeningResult exact = opening.open(problem.hooks, job);
        if (exact.status != fem::OpeningStatus::converged && exact.status != fem::OpeningStatus::inverted)
            throw SolverError("the exact path found no answer: " + exact.message);
        double moved = 0.0, pulled = 0.0, strongest = 0.0;
        for (std::size_t v = 0; v < map.vertex_slot.size(); ++v)
            moved = std::max(moved,
                (answer.displacement.segment<3>(3 * map.vertex_slot[v]).transpose()
                    - exact.displacement.row(static_cast<Eigen::Index>(v)))
                    .cwiseAbs()
                    .maxCoeff());
        for (std::size_t i = 0; i < held.size(); ++i) {
            pulled = std::max(pulled, (answer.hook_forces_N[i] - exact.hook_forces_N[i]).norm());
            strongest = std::max(strongest, exact.hook_forces_N[i].norm());
        }
        return std::max(moved / exact.displacement.cwiseAbs().maxCoeff(), pulled / strongest);
    }

    /// Four rows: the answer by a solution, the answer by the columns of a drag, and the difference of both from the
    /// exact path.
    std::array<VerificationRow, 4> through_online(
        const Scene& scene, fem::BodyKept kept, const std::string& name, const Job& job)
    {
        mesh::CutSession session(scene.mesh);
        fem::OnlineOptions options;
        options.body = kept;
        std::vector<VertexId> held;
        for (const fem::OnlineHook& hook : scene.hooks)
            held.insert(held.end(), hook.nodes.begin(), hook.nodes.end());
        fem::OnlineOpening opening(session, scene.materials, scene.supports, held, options);
        for (const fem::OnlineHook& hook : scene.hooks)
            (void)opening.attach(hook);
        const mesh::CutResult cut = session.cut(scene.blade);
        if (cut.status != mesh::CutStatus::done)
            throw SolverError("the body was not cut: " + cut.message);
        opening.follow(cut.delta, session.lips());
        const auto solved = [&](const fem::OnlineAnswer& answer) {
            if (answer.status != fem::OnlineStatus::solved)
                throw SolverError("the hooks were not followed: " + answer.message);
        };
        solved(opening.answer());
        const Stopwatch watch;
        opening.follow(session.undo(), session.lips());
        fem::OnlineAnswer answer = opening.answer();
        solved(answer);
        opening.complete(answer);
        VerificationRow row;
        row.problem = scene.problem;
        row.element = "P1, " + name;
        row.law = "linear";
        row.nodes = scene.mesh.vertex_count();
        row.tets = scene.mesh.tet_count();
        row.size = scene.size;
        row.seconds = watch.seconds();
        std::array<VerificationRow, 4> rows;
        const auto fill = [&](std::size_t at, const fem::OnlineAnswer& a) {
            row.residual = a.residual;
            rows[at] = rows[at + 1] = row;
            compare(rows[at], scene.quantity, scene.value(a.hook_displacements, a.hook_forces_N), scene.expected);
            compare(rows[at + 1], "apart from the exact path, relative", apart_from_exact(scene, session, a, job), 0.0);
            rows[at + 1].bound = kSame;
            rows[at + 1].size = 0.0; // no curve of errors for this row
        };
        fill(0, answer);
        (void)opening.prepare_drag();
        const Stopwatch frame;
        const fem::OnlineAnswer dragged = opening.drag_answer();
        row.seconds = frame.seconds();
        solved(dragged);
        row.element = "P1, dragged, " + name;
        fill(2, dragged);
        return rows;
    }

    fem::OnlineHook driven_hook(std::vector<VertexId> nodes, const fem::HookDrive& drive, std::size_t number)
    {
        return { .name = "hook " + std::to_string(number), .side = 1, .nodes = std::move(nodes), .drive = drive };
    }

    Vec3 sum_at(const Eigen::VectorXd& loads, const std::vector<VertexId>& nodes)
    {
        Vec3 sum = Vec3::Zero();
        for (const VertexId v : nodes)
            sum += loads.segment<3>(3 * v);
        return sum;
    }

    /// Cook's membrane with two layers of elements, clamped at the left. The sheet is thin enough for plane stress.
    Scene hooked_membrane(int cells)
    {
        Scene scene { .problem = "Cook's membrane", .quantity = "displacement at (48, 52), mm" };
        scene.mesh = mapped_box(4, cells, cells, 2, [&](const Vec3& p) -> Vec3 {
            const double s = p.x() / cells, t = p.y() / cells;
            return { 48.0 * s, 44.0 * s + t * (44.0 - 28.0 * s), 0.5 * p.z() };
        });
        scene.materials.assign(2, { "membrane", 1.0, 1.0 / 3.0, 1e-9, "reference" });
        std::map<long, std::vector<VertexId>> rows; // vertices of the right edge, by height
        for (VertexId v = 0; v < static_cast<VertexId>(scene.mesh.vertex_count()); ++v) {
            const Vec3 p = scene.mesh.vertices.row(v).transpose();
            if (p.x() < kTiny)
                scene.supports.fixed.push_back(v);
            if (p.x() > 48.0 - kTiny)
                rows[std::lround(1e3 * p.y())].push_back(v);
        }
        const Eigen::VectorXd loads = fem::traction_loads(scene.mesh,
            faces_where(scene.mesh, [](const Vec3& p) { return p.x() > 48.0 - kTiny; }), { 0.0, 1.0 / 16.0, 0.0 });
        std::size_t middle = 0;
        for (const auto& [height, nodes] : rows) {
            if (height == 52000)
                middle = scene.hooks.size();
            scene.hooks.push_back(driven_hook(nodes, { .force_N = sum_at(loads, nodes) }, scene.hooks.size()));
        }
        scene.blade = {
            .line = { { 20.0, 36.0, 1.0 }, { 29.0, 40.0, 1.0 } }, .directions = { -Vec3::UnitZ() }, .depth_mm = 2.0
        };
        scene.size = 1.0 / cells;
        scene.expected = 23.96;
        scene.value = [middle](const auto& moved, const auto&) { return moved[middle].y(); };
        return scene;
    }

    /// The whole ring. A hook holds each line of nodes along the tube and moves the line as a whole, which gives
    /// plane strain. Hooks on the inner wall carry the pressure, the others carry nothing. A bed with about a
    /// hundred-thousandth of the wall's stiffness (0.01 E mm for each node on the wall) holds the ring.
    Scene ring(int around, int through)
    {
        constexpr double E = 0.5, nu = 0.45; // MPa
        Scene scene { .problem = "pressed tube, nu 0.45", .quantity = "inner wall's displacement, mm" };
        const auto everywhere = [](const Vec3&) { return true; };
        scene.mesh
            = mirrored(mirrored(quarter_tube(4, kVesselInner, kVesselOuter, around, through, 2).mesh, 0, everywhere), 1,
                everywhere);
        scene.materials.assign(2, { "vessel", E, nu, 1e-9, "reference" });
        const auto at_inner = [](const Vec3& p) { return std::hypot(p.x(), p.y()) < kVesselInner + kTiny; };
        std::map<std::array<long, 2>, std::vector<VertexId>> lines;
        for (VertexId v = 0; v < static_cast<VertexId>(scene.mesh.vertex_count()); ++v) {
            const Vec3 p = scene.mesh.vertices.row(v).transpose();
            lines[{ std::lround(1e3 * p.x()), std::lround(1e3 * p.y()) }].push_back(v);
            if (!at_inner(p))
                scene.supports.bedded.push_back({ v, 1e-7 * E });
        }
        const Eigen::VectorXd loads = fem::FollowerPressure(scene.mesh, faces_where(scene.mesh, at_inner), kPulse)
                                          .force(Eigen::VectorXd::Zero(3 * scene.mesh.vertices.rows()));
        std::vector<Vec3> outwards;
        for (const auto& [place, nodes] : lines) {
            Vec3 out = scene.mesh.vertices.row(nodes.front()).transpose();
            outwards.push_back(at_inner(out) ? Vec3(out.x(), out.y(), 0.0).normalized() : Vec3::Zero());
            scene.hooks.push_back(driven_hook(nodes, { .force_N = sum_at(loads, nodes) }, scene.hooks.size()));
        }
        const double high = scene.mesh.vertices.col(2).maxCoeff();
        scene.blade = { .line = { { 13.2, -1.5, high }, { 13.4, 1.6, high } },
            .directions = { -Vec3::UnitZ() },
            .depth_mm = 0.6 * high };
        scene.size = 1.0 / through;
        scene.expected = vessel_displacement(E, nu, kPulse);
        scene.value = [outwards](const auto& moved, const auto&) {
            double sum = 0.0, count = 0.0;
            for (std::size_t i = 0; i < moved.size(); ++i) {
                sum += outwards[i].dot(moved[i]);
                count += outwards[i].norm();
            }
            return sum / count;
        };
        return scene;
    }

    constexpr double kPunch = 5.0, kPunchYoung = 0.020, kPunchPoisson = 0.3;

    /// Reduction of the force of a bonded punch by a far side that moves under a unit force; see indentation.cpp.
    double taken_off_by_far_side(const QuarterCylinder& body, const Job& job)
    {
        Held held = with_far_side(symmetric(body), body, kPunchYoung, kPunchPoisson, 1.0);
        for (VertexId v = 0; v < static_cast<VertexId>(body.mesh.vertex_count()); ++v)
            if (body.in_circle(body.mesh.vertices.row(v).transpose()))
                for (int axis = 0; axis < 3; ++axis)
                    hold(held, v, axis);
        fem::ElasticBody elastic
            = make_body(body.mesh, VerificationElement::p1, linear_law(kPunchYoung, kPunchPoisson));
        const VerificationSolve solve
            = solve_problem(elastic, held.prescribed, held.target, { .tolerance = 1e-9 }, job);
        double force = 0.0;
        for (VertexId v = 0; v < static_cast<VertexId>(body.mesh.vertex_count()); ++v)
            if (body.in_circle(body.mesh.vertices.row(v).transpose()))
                force += 4.0 * solve.equilibrium.forces[3 * v + 2];
        return force;
    }

    /// A hook does not slip. The force of a bonded punch is 4 mu a d ln(3 - 4 nu) / (1 - 2 nu) [Mossakovskii 1954;
    /// Johnson, Contact mechanics, 3.7]; at nu 0.5 this is the force of a frictionless punch.
    Scene punch(int n, const Job& job)
    {
        constexpr double pushed = 2.0;
        Scene scene { .problem = "flat punch that sticks, nu 0.3", .quantity = "force, N" };
        const QuarterCylinder quarter = quarter_cylinder(4, kPunch, n);
        const auto everywhere = [](const Vec3&) { return true; };
        scene.mesh = mirrored(mirrored(quarter.mesh, 0, everywhere), 1, everywhere);
        scene.materials.assign(2, { "tissue", kPunchYoung, kPunchPoisson, 1e-9, "reference" });
        std::vector<VertexId> circle;
        for (VertexId v = 0; v < static_cast<VertexId>(scene.mesh.vertex_count()); ++v) {
            const Vec3 p = scene.mesh.vertices.row(v).transpose();
            if (quarter.at_far_side(p))
                scene.supports.fixed.push_back(v);
            else if (quarter.in_circle(p))
                circle.push_back(v);
        }
        scene.hooks.push_back(driven_hook(circle, { .displacement = Vec3(0.0, 0.0, pushed) }, 0));
        // The body lies at z > 0, so the knife comes from below.
        scene.blade
            = { .line = { { 7.0, -4.0, 0.0 }, { 8.0, 4.0, 0.0 } }, .directions = { Vec3::UnitZ() }, .depth_mm = 4.0 };
        scene.size = 1.0 / n;
        const double mu = kPunchYoung / (2.0 * (1.0 + kPunchPoisson));
        scene.expected = 4.0 * mu * kPunch * pushed * std::log(3.0 - 4.0 * kPunchPoisson) / (1.0 - 2.0 * kPunchPoisson);
        scene.value = [taken_off = taken_off_by_far_side(quarter, job)](
                          const auto&, const auto& forces) { return forces[0].z() / (1.0 - taken_off); };
        return scene;
    }

    /// The whole body with the cut, nonlinear within two radii and opened by tension on its lips. The exact path
    /// solves one eighth of the body between planes of symmetry, all nonlinear. Two rows: the opening, and the
    /// difference of the two answers.
    std::array<VerificationRow, 2> near_penny(int n, const Job& job)
    {
        constexpr double a = 5.0, E = 1.0, nu = 0.3, stress = 1e-4; // MPa: small strain, as in the closed form
        const QuarterCylinder quarter = quarter_cylinder(4, a, n);
        const auto everywhere = [](const Vec3&) { return true; };
        const mesh::TetMesh mesh = mirrored(
            mirrored(
                mirrored(quarter.mesh, 2, [&](const Vec3& p) { return std::hypot(p.x(), p.y()) > a * (1.0 - 1e-6); }),
                0, everywhere),
            1, everywhere);
        std::vector<int> above(mesh.vertex_count(), 0); // the lip to which a vertex belongs
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            double z = 0.0;
            for (const VertexId v : mesh.tet(t))
                z += mesh.vertices(v, 2);
            for (const VertexId v : mesh.tet(t))
                above[static_cast<std::size_t>(v)] = z > 0.0 ? 1 : -1;
        }
        Eigen::VectorXd load = fem::traction_loads(mesh,
            faces_where(mesh, [&](const Vec3& p) { return std::abs(p.z()) < kTiny && quarter.in_circle(p); }),
            { 0.0, 0.0, stress });
        fem::Supports supports;
        std::array<VertexId, 2> middle { -1, -1 };
        const auto at = [&](VertexId v) -> Vec3 { return mesh.vertices.row(v).transpose(); };
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v) {
            if (quarter.at_far_side(at(v).cwiseAbs()))
                supports.fixed.push_back(v);
            if (above[static_cast<std::size_t>(v)] < 0)
                load[3 * v + 2] *= -1.0;
            if (at(v).norm() < kTiny)
                middle[above[static_cast<std::size_t>(v)] < 0 ? 0 : 1] = v;
            // on the crack front the tractions of the two lips cancel
            if (std::abs(at(v).z()) < kTiny && std::hypot(at(v).x(), at(v).y()) > a * (1.0 - 1e-6))
                load.segment<3>(3 * v).setZero();
        }
        const std::vector<fem::Material> materials(2, { "tissue", E, nu, 1e-9, "reference" });
        const Stopwatch watch;
        fem::NonlinearRegion field(mesh, materials, supports, {}, fem::elements_near(mesh, Points::Zero(1, 3), 2.0 * a),
            { .elasticity = fem::Elasticity::corotational, .tolerance = 1e-8, .load = load });
        const fem::NearFrame rest = field.settle(job);
        if (rest.status != fem::NearStatus::settled)
            throw SolverError("the penny-shaped cut did not settle: " + rest.message);
        VerificationRow row;
        row.problem = "penny-shaped cut";
        row.element = "P1, nonlinear region";
        row.law = "corotational, linear";
        row.nodes = mesh.vertex_count();
        row.tets = mesh.tet_count();
        row.size = 1.0 / n;
        row.seconds = watch.seconds();
        row.residual = rest.residual;
        std::array<VerificationRow, 2> rows { row, row };
        const double opened = rest.displacement[3 * middle[1] + 2] - rest.displacement[3 * middle[0] + 2];
        compare(
            rows[0], "opening in the middle, mm", opened, 8.0 * (1.0 - nu * nu) * stress * a / (std::numbers::pi * E));

        Held held = with_far_side(symmetric(quarter), quarter, E, nu, 0.0);
        for (VertexId v = 0; v < static_cast<VertexId>(quarter.mesh.vertex_count()); ++v)
            if (const Vec3 p = quarter.mesh.vertices.row(v).transpose();
                p.z() < kTiny && std::hypot(p.x(), p.y()) > a * (1.0 - 1e-6))
                hold(held, v, 2);
        VerificationLaw law = linear_law(E, nu);
        law.model = fem::Elasticity::corotational;
        fem::ElasticBody body = make_body(quarter.mesh, VerificationElement::p1, law);
        body.set_loads({ fem::traction_loads(quarter.mesh, quarter.circle(), { 0.0, 0.0, stress }), {} });
        const VerificationSolve exact
            = solve_problem(body, held.prescribed, held.target, { .load_steps = 1, .tolerance = 1e-9 }, job);
        if (exact.equilibrium.status != fem::EquilibriumStatus::converged)
            throw SolverError("the exact path found no answer: " + exact.equilibrium.message);
        const double right = 2.0 * exact.equilibrium.displacement[3 * quarter.nearest(Vec3::Zero()) + 2];
        compare(rows[1], "apart from the exact path, relative", std::abs(opened / right - 1.0), 0.0);
        rows[1].bound = stress / E; // the error of the linear condensed region is of the order of the strain
        rows[1].size = 0.0;
        return rows;
    }

    struct FastFamily {
        std::function<Scene(int mesh, const Job& job)> scene;
        std::vector<int> meshes;
        double order, bound;
    };

    std::vector<FastFamily> families()
    {
        // The force is smaller than for a punch that is wider by one cell: the effective edge of the patch lies
        // within the first ring round it.
        constexpr double kWider = 1.0 / 3.0;
        return { { [](int n, const Job&) { return hooked_membrane(n); }, { 8, 16, 32 }, 1.4, 0.06 },
            { [](int n, const Job& job) { return punch(n, job); }, { 1, 2, 3 }, 1.0, kWider },
            { [](int n, const Job&) { return ring(4 * n, n); }, { 1, 2, 3 }, 2.0, 0.02 } };
    }

} // namespace

VerificationProblem fast_paths_problem()
{
    return { "fast paths",
        "Cook's membrane, flat punch and pressed tube by OnlineOpening after a cut that is undone, penny-shaped cut by "
        "NonlinearRegion: against the closed form, and against the exact path on the same mesh",
        [](const VerificationOptions& options, const Job& job) {
            std::vector<VerificationRow> rows;
            for (const FastFamily& family : families())
                for (const auto& [kept, name] : { std::pair { fem::BodyKept::condensed, "cut undone" },
                         std::pair { fem::BodyKept::dissected, "cut undone, in parts" } }) {
                    std::array<std::vector<VerificationRow>, 4> series;
                    for (const int mesh : coarsest(family.meshes, options)) {
                        if (job.cancelled())
                            break;
                        const auto four = through_online(family.scene(mesh, job), kept, name, job);
                        for (std::size_t i = 0; i < series.size(); ++i)
                            series[i].push_back(four[i]);
                    }
                    for (const std::size_t i : { 0U, 2U }) {
                        append_series(rows, series[i], family.order, family.bound);
                        rows.insert(rows.end(), series[i + 1].begin(), series[i + 1].end());
                    }
                }
            std::array<std::vector<VerificationRow>, 2> cut;
            // The opening is larger than for a cut that is narrower by one cell: the effective front lies within the
            // last ring.
            constexpr double kNarrower = 1.0 / 3.0;
            for (const int n : coarsest(std::vector<int> { 1, 2, 3 }, options))
                if (!job.cancelled()) {
                    const auto two = near_penny(n, job);
                    for (std::size_t i = 0; i < 2; ++i)
                        cut[i].push_back(two[i]);
                }
            append_series(rows, cut[0], 1.0, kNarrower);
            rows.insert(rows.end(), cut[1].begin(), cut[1].end());
            return rows;
        },
        "elements but plain P1 and laws but linear, round corotational: the fast paths have no others. The "
        "penny-shaped cut by OnlineOpening: a knife goes in from the skin, and this cut lies within the body, where it "
        "is from the start; an incision that OnlineOpening cuts is under 'incision gape'" };
}

} // namespace retractor::verification
