// Extreme cuts: pieces that come off, cuts along the grid, through a hook, and a hundred cuts in one place.

#include "tests/verification/stability/stability_families.h"
#include "tests/verification/stability/stability_meshes.h"

#include "fem/interactive/online_opening.h"
#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "tests/verification/framework/incision.h"
#include "tests/verification/framework/stability.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

namespace retractor::verification {

namespace {

    const fem::Material kCutTissue { "tissue", 0.04, 0.45, 1e-9, "verification" };
    const std::vector<fem::Material> kTissues { kCutTissue, kCutTissue };

    /// Checks that the mesh after a cut is sound. A failure is misbehaviour, not a refusal.
    void expect_sound(const mesh::TetMesh& mesh)
    {
        try {
            mesh::check_mesh(mesh);
        } catch (const Error& error) {
            throw PromiseNotKept(std::string("the mesh after the cut: ") + error.what() + " [" + error.where() + "]");
        }
    }

    double volume(const mesh::TetMesh& mesh)
    {
        double sum = 0.0;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            sum += mesh::tet_volume(mesh, t);
        return sum;
    }

    std::vector<VertexId> bottom(const mesh::TetMesh& mesh)
    {
        std::vector<VertexId> found;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (mesh.vertices(v, 2) < 1e-6)
                found.push_back(v);
        return found;
    }

    /// A horizontal blade from end to end: the top half comes off.
    mesh::Blade severing_blade(const IncisedBlock& block)
    {
        const double z = 0.62 * block.size.z();
        return { .line = { Vec3(-5.0, -2.0, z), Vec3(block.size.x() + 5.0, -2.0, z) },
            .directions = { Vec3::UnitY() },
            .depth_mm = block.size.y() + 10.0 };
    }

    /// A hook on vertices of a mesh.
    fem::OnlineHook hook_on(const mesh::TetMesh& mesh, const Vec3& pull, const std::function<bool(const Vec3&)>& inside)
    {
        fem::OnlineHook hook;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (inside(mesh.vertices.row(v).transpose()))
                hook.nodes.push_back(v);
        hook.drive.displacement = pull;
        return hook;
    }

    /// A hook patch in the middle of the top.
    fem::OnlineHook top_hook(const IncisedBlock& block, const Vec3& pull)
    {
        fem::OnlineHook hook = hook_on(uncut_block(block), pull, [&](const Vec3& p) {
            return p.z() > block.size.z() - 1e-6 && (p - 0.5 * block.size).head<2>().cwiseAbs().maxCoeff() < 5.1;
        });
        hook.name = "middle";
        return hook;
    }

    /// A hook on one whole side that pulls away from the middle.
    fem::OnlineHook side_hook(const IncisedBlock& block, const mesh::TetMesh& mesh)
    {
        fem::OnlineHook hook = hook_on(
            mesh, Vec3(0.0, 3.0, 0.0), [&](const Vec3& p) { return p.y() > block.size.y() - 1e-6 && p.z() > 1e-6; });
        hook.name = "side";
        hook.side = 1;
        return hook;
    }

    /// The block to be cut, held at the bottom and by a hook. The first ids of a session are those of its mesh.
    struct HookedOnline {
        mesh::TetMesh mesh;
        mesh::CutSession session;
        fem::Supports supports;
        fem::OnlineOpening opening;
        fem::OnlineHook hook;

        HookedOnline(const IncisedBlock& block, fem::OnlineHook held)
            : mesh(uncut_block(block))
            , session(mesh)
            , supports { bottom(mesh), {} }
            , opening(session, kTissues, supports, {})
            , hook(std::move(held))
        {
            (void)opening.attach(hook);
        }

        mesh::CutResult cut(const mesh::Blade& blade)
        {
            mesh::CutResult made = session.cut(blade);
            if (made.status == mesh::CutStatus::done)
                opening.follow(made.delta);
            return made;
        }

        /// The whole answer, with residual and condition in the row.
        fem::OnlineAnswer answer(StabilityRow& row)
        {
            fem::OnlineAnswer answer = opening.answer();
            opening.complete(answer);
            set_condition(row, problem_now(session, kTissues, supports, { hook }), fem::Elasticity::linear);
            row.residual = answer.residual;
            return answer;
        }

        /// The same answer, compared with a newly set-up problem.
        void judge(StabilityRow& row, const fem::OnlineAnswer& answer)
        {
            if (answer.status != fem::OnlineStatus::solved)
                return refuse(row, answer.message);
            fem::OnlineOpening anew(session, kTissues, supports, {});
            (void)anew.attach(hook);
            fem::OnlineAnswer expected = anew.answer();
            anew.complete(expected);
            row.quantity = "displacement against a fresh factorisation, relative";
            row.error = (answer.displacement - expected.displacement).cwiseAbs().maxCoeff()
                / expected.displacement.cwiseAbs().maxCoeff();
            row.bound = 1e-8; // error that residuals of round-off leave
        }
    };

    void severed_whole(StabilityRow& row, const IncisedBlock& block, const Job& job)
    {
        const Incision cut = incise(uncut_block(block), severing_blade(block));
        set_condition(row, { cut.mesh, kTissues, { bottom(cut.mesh), {} }, {} }, fem::Elasticity::linear);
        fem::Opening opening(cut.mesh, kTissues, { bottom(cut.mesh), {} }, {});
        row.residual = opening.open({}, job).residual;
    }

    void severed_online(StabilityRow& row, const IncisedBlock& block)
    {
        const mesh::TetMesh mesh = uncut_block(block);
        mesh::CutSession session(mesh);
        fem::OnlineOpening opening(session, kTissues, { bottom(mesh), {} }, {});
        const mesh::CutResult cut = session.cut(severing_blade(block));
        opening.follow(cut.delta);
        const fem::OnlineAnswer answer = opening.answer();
        set_condition(row, problem_now(session, kTissues, { bottom(mesh), {} }, {}), fem::Elasticity::linear);
        if (answer.status == fem::OnlineStatus::unsupported)
            refuse(row, answer.message);
    }

    /// A hook holds the piece that came off, so there is an answer again.
    void severed_hooked(StabilityRow& row, const IncisedBlock& block)
    {
        HookedOnline online(block, top_hook(block, Vec3(0.0, 1.0, 3.0)));
        (void)online.cut(severing_blade(block));
        const fem::OnlineAnswer answer = online.answer(row);
        if (answer.status != fem::OnlineStatus::solved)
            return refuse(row, answer.message);
        row.quantity = "hook force of a piece that hangs free, N";
        row.error = answer.hook_forces_N.front().norm();
        row.bound = 1e-9; // the piece moves rigidly; round-off of forces of 1 N
    }

    fem::ElasticProblem pulled_aside(const IncisedBlock& block, const mesh::TetMesh& mesh)
    {
        const fem::OnlineHook hook = side_hook(block, mesh);
        return { mesh, kTissues, { bottom(mesh), {} },
            { { hook.name, hook.side, hook.nodes, hook.drive.displacement } } };
    }

    struct GridCut {
        const char* name;
        mesh::Blade blade;
        double lip_area; ///< area of one lip, mm^2
    };

    std::vector<GridCut> grid_cuts(const IncisedBlock& block)
    {
        const double x = block.size.x(), y = 0.5 * block.size.y(), z = block.size.z(), h = block.cell;
        const auto blade = [](const Vec3& a, const Vec3& b, const Vec3& direction, double depth) {
            return mesh::Blade { .line = { a, b }, .directions = { direction }, .depth_mm = depth };
        };
        const Vec3 diagonal = Vec3(0.0, -1.0, -1.0) / std::numbers::sqrt2;
        return {
            { "cut along faces", incision_blade(block), block.length * block.depth },
            { "cut along faces, from end to end", blade({ -h, y, z }, { x + h, y, z }, -Vec3::UnitZ(), 2 * h),
                x * 2 * h },
            // The cut contains diagonals of the cells' sides, and edges along x.
            { "cut along edges, aslant", blade({ 2 * h, y, z }, { 6 * h, y, z }, diagonal, 2 * h * std::numbers::sqrt2),
                4 * h * 2 * h * std::numbers::sqrt2 },
            // The cut runs from one vertex to another, through vertices, edges and faces of other elements.
            { "cut from vertex to vertex", blade({ 2 * h, 2 * h, z }, { 8 * h, 6 * h, z }, -Vec3::UnitZ(), 2 * h),
                std::hypot(6 * h, 4 * h) * 2 * h },
            // The front and one end of the cut run along edges in the middle of the body.
            { "cut that ends on an edge", blade({ -h, 3 * h, z }, { 6 * h, 3 * h, z }, -Vec3::UnitZ(), 3 * h),
                6 * h * 3 * h },
        };
    }

    void grid_cut(StabilityRow& row, const IncisedBlock& block, const GridCut& cut, const Job& job)
    {
        const mesh::TetMesh before = uncut_block(block);
        const Incision incision = incise(before, cut.blade);
        expect_sound(incision.mesh);
        row.quantity = "volume and area of the lips, relative";
        row.error = std::max(std::abs(volume(incision.mesh) / volume(before) - 1.0),
            std::abs(incision.report.lip_area_mm2 / cut.lip_area - 1.0));
        row.bound = 1e-12; // round-off
        const fem::ElasticProblem problem = pulled_aside(block, incision.mesh);
        fem::Opening opening(problem.mesh, problem.material_of_label, problem.supports, {});
        const fem::OpeningResult result = opening.open(problem.hooks, job);
        row.residual = result.residual;
        row.reason = formatted("%zu elements, smallest angle of those born %.1f degrees", incision.mesh.tet_count(),
            incision.report.worst_dihedral_deg);
        set_condition(row, problem, fem::Elasticity::corotational, result.displacement);
        if (result.status != fem::OpeningStatus::converged)
            refuse(row, result.message);
    }

    void through_hook(StabilityRow& row, const IncisedBlock& block)
    {
        HookedOnline online(block, top_hook(block, Vec3(0.0, 2.0, 1.0)));
        (void)online.cut(incision_blade(block));
        const fem::OnlineAnswer answer = online.answer(row);
        row.reason = formatted("hook force %.3f N; it keeps the vertices it had, their copies on the other lip go free",
            answer.hook_forces_N.front().norm());
        online.judge(row, answer);
    }

    constexpr int kCuts = 100;

    enum class Hundred {
        fan, ///< from one line outwards, 3.6 degrees apart
        slices, ///< side by side, a tenth of a millimetre apart
        crossing, ///< all cuts cross each other within a millimetre
    };

    /// A blade straight down in the middle of the top, off the planes of the grid.
    mesh::Blade hundredth_blade(const IncisedBlock& block, int i, Hundred series)
    {
        mesh::Blade blade = incision_blade(block);
        const Vec3 middle = 0.5 * (blade.line[0] + blade.line[1]);
        switch (series) {
        case Hundred::slices:
            for (Vec3& p : blade.line)
                p = middle + 0.3 * (p - middle) + Vec3(0.0, 0.1 * (i - kCuts / 2) + 0.03, 0.0);
            break;
        case Hundred::fan: {
            const double angle = 2.0 * std::numbers::pi * i / kCuts + 0.013;
            blade.line[0] = middle + Vec3(0.3, 0.2, 0.0);
            blade.line[1] = blade.line[0] + 3.0 * Vec3(std::cos(angle), std::sin(angle), 0.0);
            blade.depth_mm = 2.0;
            break;
        }
        case Hundred::crossing: {
            const double turn = 2.399963 * i; // the golden angle: no two blades are parallel
            for (Vec3& p : blade.line)
                p = middle + Vec3(0.7 * std::cos(turn), 0.7 * std::sin(turn), 0.0)
                    + Vec3(Eigen::AngleAxisd(0.15 * std::sin(turn), Vec3::UnitZ()) * (p - middle));
            break;
        }
        }
        return blade;
    }

    /// largest sum of volume changes by moved skin vertices; a plane is kept to round-off
    constexpr double kVolumeKept = 1e-9;

    /// Checks that the mesh is sound, keeps its volume, and that all cuts can be undone.
    /// @return the relative change of volume.
    double expect_undone(mesh::CutSession& session, const mesh::TetMesh& before, double kept = kVolumeKept)
    {
        const mesh::TetMesh mesh = session.compact_mesh();
        expect_sound(mesh);
        const double change = std::abs(volume(mesh) / volume(before) - 1.0);
        if (!(change <= kept))
            throw PromiseNotKept(formatted("the cuts changed the volume by %.1e of it", change));
        while (session.can_undo())
            (void)session.undo();
        const mesh::TetMesh after = session.compact_mesh();
        if (after.vertices != before.vertices || after.nodes != before.nodes)
            throw PromiseNotKept("undoing the cuts did not give the first mesh back");
        return change;
    }

    /// All blades go straight down, so nothing pulls across the cuts when the block is stretched vertically.
    void stretch_upright(StabilityRow& row, const mesh::CutSession& session, double bound, const Job& job)
    {
        mesh::SlotMap map;
        const mesh::TetMesh mesh = session.compact_mesh(&map);
        std::vector<VertexId> lips;
        for (const mesh::LipFace& lip : session.lips()) {
            const mesh::MeshDelta::Tet tet = session.tet(lip.face.tet);
            for (std::size_t a = 0; a < 4; ++a)
                if (static_cast<int>(a) != lip.face.corner)
                    lips.push_back(map.compact_vertex[static_cast<std::size_t>(tet.nodes[a])]);
        }
        stretch_along(row, mesh, lips, 2, bound, job);
    }

    std::string mesh_text(const mesh::CutSession& session)
    {
        const std::vector<int> piece = mesh::connected_pieces(session.compact_mesh());
        return formatted(
            "%zu elements, %d piece(s)", session.tet_count(), 1 + *std::max_element(piece.begin(), piece.end()));
    }

    /// The first cut is made. The others are refused with a reason and change nothing.
    void same_cut(StabilityRow& row, const IncisedBlock& block)
    {
        const mesh::TetMesh before = uncut_block(block);
        HookedOnline online(block, side_hook(block, before));
        if (online.cut(incision_blade(block)).status != mesh::CutStatus::done)
            throw PromiseNotKept("the first cut was not made");
        const mesh::TetMesh once = online.session.compact_mesh();
        std::string said;
        for (int i = 1; i < kCuts; ++i) {
            const mesh::CutResult again = online.cut(incision_blade(block));
            if (again.status != mesh::CutStatus::missed_body || again.message.find("cut already") == std::string::npos)
                throw PromiseNotKept(formatted("cut %d of the same was not refused as one: ", i + 1) + again.message);
            said = again.message;
        }
        const mesh::TetMesh now = online.session.compact_mesh();
        if (now.vertices != once.vertices || now.nodes != once.nodes)
            throw PromiseNotKept("a cut that was refused changed the mesh");
        online.judge(row, online.answer(row));
        row.reason = formatted("1 cut made, the other %d refused, each: ", kCuts - 1) + said + "; "
            + mesh_text(online.session);
        (void)expect_undone(online.session, before);
    }

    /// All cuts are made.
    void hundred_cuts(StabilityRow& row, const IncisedBlock& block, const Job& job)
    {
        const mesh::TetMesh before = uncut_block(block);
        HookedOnline online(block, side_hook(block, before));
        int made = 0;
        for (; made < kCuts && !job.cancelled(); ++made) {
            const mesh::CutResult result = online.cut(hundredth_blade(block, made, Hundred::fan));
            if (result.status != mesh::CutStatus::done)
                throw PromiseNotKept(formatted("cut %d of %d was not made: ", made + 1, kCuts) + result.message);
        }
        row.reason = formatted("%d of %d cuts made, ", made, kCuts) + mesh_text(online.session);
        online.judge(row, online.answer(row));
        // Vertices of the skin move slightly onto each of a hundred blades (CutOptions::snap).
        constexpr double kMovedSkin = 1e-5;
        row.reason += formatted(", volume kept to %.1e", expect_undone(online.session, before, kMovedSkin));
    }

    /// Cuts that cross each other, or the slivers beside each other's lips, become ever more expensive: each cut
    /// divides all elements that earlier cuts divided. The cutter must refuse the cut that exceeds the limit of
    /// elements, with a reason. The earlier cuts stay and have an answer.
    void cut_until_refused(StabilityRow& row, const IncisedBlock& block, Hundred series, double bound, const Job& job)
    {
        constexpr std::size_t kMostElements = 10'000; // four times the initial number
        const mesh::TetMesh before = uncut_block(block);
        mesh::CutSession session(before);
        std::string said;
        int made = 0;
        for (; made < kCuts && said.empty() && !job.cancelled(); made += said.empty() ? 1 : 0)
            try {
                const mesh::CutResult result
                    = session.cut(hundredth_blade(block, made, series), { .element_limit = kMostElements });
                if (result.status != mesh::CutStatus::done)
                    throw PromiseNotKept(formatted("cut %d of %d was not made: ", made + 1, kCuts) + result.message);
            } catch (const SolverError& error) {
                said = error.what() + (" [" + error.where() + "]");
            }
        row.reason = formatted("%d of %d cuts made, ", made, kCuts) + mesh_text(session);
        stretch_upright(row, session, bound, job);
        (void)expect_undone(session, before);
        if (!said.empty())
            refuse(row, formatted("cut number %d: ", made + 1) + said + "; those before stand: " + row.reason);
    }

} // namespace

StabilityCase severed_piece_case()
{
    return { "severed piece", "a piece that nothing holds is named, with its size and place", [](const Job& job) {
                const IncisedBlock block;
                return std::vector<StabilityRow> {
                    expect_refusal("piece without support", "opening", "has neither a support nor a hook",
                        [&](StabilityRow& row) { severed_whole(row, block, job); }),
                    expect_refusal("piece without support", "online opening", "has neither a support nor a hook",
                        [&](StabilityRow& row) { severed_online(row, block); }),
                    attempt("severed piece on a hook", "online opening",
                        [&](StabilityRow& row) { severed_hooked(row, block); }),
                };
            } };
}

StabilityCase cut_along_grid_case()
{
    return { "cut along the grid", "along existing faces, edges and vertices: nothing lost, nothing degenerate",
        [](const Job& job) {
            std::vector<StabilityRow> rows;
            const IncisedBlock block;
            for (const GridCut& cut : grid_cuts(block))
                rows.push_back(attempt(
                    cut.name, "cutter, P1 corotational", [&](StabilityRow& row) { grid_cut(row, block, cut, job); }));
            return rows;
        } };
}

StabilityCase cut_through_hook_case()
{
    return { "cut through a hook", "the hook keeps what it holds; the answer is that of a fresh solver",
        [](const Job&) {
            const IncisedBlock block;
            return std::vector<StabilityRow> { attempt(
                "cut through a hook", "online opening", [&](StabilityRow& row) { through_hook(row, block); }) };
        } };
}

StabilityCase hundred_cuts_case()
{
    return { "100 cuts in one place",
        "all 100 are made and the answer on what they leave is right, or the one that goes too far is refused by name; "
        "the mesh stays valid, and undo gives the first one back",
        [](const Job& job) {
            const IncisedBlock block;
            std::vector<StabilityRow> rows { attempt(
                "the same cut 100 times", "online opening", [&](StabilityRow& row) { same_cut(row, block); }) };
            // 1e-16 times the scaled condition number, with a margin
            constexpr double kRoundOff = 1e-9, kOfSlivers = 1e-4;
            rows.push_back(attempt(
                "100 cuts from one line", "online opening", [&](StabilityRow& row) { hundred_cuts(row, block, job); }));
            rows.push_back(expect_refusal("100 slices, 0.1 mm apart", "cutter; P1, linear", "element_limit",
                [&](StabilityRow& row) { cut_until_refused(row, block, Hundred::slices, kRoundOff, job); }));
            rows.push_back(expect_refusal("100 cuts crossing within 1 mm", "cutter; P1, linear", "element_limit",
                [&](StabilityRow& row) { cut_until_refused(row, block, Hundred::crossing, kOfSlivers, job); }));
            return rows;
        } };
}

} // namespace retractor::verification
