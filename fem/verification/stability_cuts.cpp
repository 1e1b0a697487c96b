// Cuts at their limits: pieces that come off, cuts on the grid, through a hook, a hundred in one place.

#include "fem/online_opening.h"
#include "fem/opening.h"
#include "fem/verification/incision.h"
#include "fem/verification/stability.h"
#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

namespace retractor {

namespace {

    const Material kTissue { "tissue", 0.04, 0.45, 1e-9, "verification" };
    const std::vector<Material> kTissues { kTissue, kTissue };

    template <class... Values> std::string text(const char* pattern, Values... values)
    {
        std::array<char, 256> buffer {};
        (void)std::snprintf(buffer.data(), buffer.size(), pattern, values...);
        return buffer.data();
    }

    /// What a cut leaves is sound, whatever was cut: no refusal.
    void expect_sound(const TetMesh& mesh)
    {
        try {
            check_mesh(mesh);
        } catch (const Error& error) {
            throw PromiseNotKept(std::string("the mesh after the cut: ") + error.what() + " [" + error.where() + "]");
        }
    }

    double volume(const TetMesh& mesh)
    {
        double sum = 0.0;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            sum += tet_volume(mesh, t);
        return sum;
    }

    std::vector<VertexId> bottom(const TetMesh& mesh)
    {
        std::vector<VertexId> found;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (mesh.vertices(v, 2) < 1e-6)
                found.push_back(v);
        return found;
    }

    /// Horizontal, from end to end: the top half comes off.
    Blade severing_blade(const IncisedBlock& block)
    {
        const double z = 0.62 * block.size.z();
        return { .line = { Vec3(-5.0, -2.0, z), Vec3(block.size.x() + 5.0, -2.0, z) },
            .directions = { Vec3::UnitY() },
            .depth_mm = block.size.y() + 10.0 };
    }

    /// A patch of the top round a place, as the session knows it.
    OnlineHook top_hook(const CutSession& session, const IncisedBlock& block, const Vec3& middle, const Vec3& pull)
    {
        OnlineHook hook;
        hook.name = "middle";
        for (VertexId v = 0; v < static_cast<VertexId>(session.vertex_slots()); ++v)
            if (session.has_vertex(v)) {
                const Vec3 p = session.position(v);
                if (p.z() > block.size.z() - 1e-6 && (p - middle).head<2>().cwiseAbs().maxCoeff() < 5.1)
                    hook.nodes.push_back(v);
            }
        hook.drive.displacement = pull;
        return hook;
    }

    /// The block, held below and by a hook in the middle of its top, that is cut.
    struct HookedOnline {
        TetMesh mesh;
        CutSession session;
        Supports supports;
        OnlineOpening opening;
        OnlineHook hook;

        HookedOnline(const IncisedBlock& block, const Vec3& pull)
            : mesh(uncut_block(block))
            , session(mesh)
            , supports { bottom(mesh), {} }
            , opening(session, kTissues, supports, {})
            , hook(top_hook(session, block, 0.5 * block.size, pull))
        {
            (void)opening.attach(hook);
        }

        /// The whole answer, its residual and condition in the row.
        OnlineAnswer cut(StabilityRow& row, const Blade& blade)
        {
            const CutResult made = session.cut(blade);
            opening.follow(made.delta);
            OnlineAnswer answer = opening.answer();
            opening.complete(answer);
            set_condition(row, problem_now(session, kTissues, supports, { hook }), Elasticity::linear);
            row.residual = answer.residual;
            return answer;
        }
    };

    void severed_whole(StabilityRow& row, const IncisedBlock& block, const Job& job)
    {
        const Incision cut = incise(uncut_block(block), severing_blade(block));
        set_condition(row, { cut.mesh, kTissues, { bottom(cut.mesh), {} }, {} }, Elasticity::linear);
        Opening opening(cut.mesh, kTissues, { bottom(cut.mesh), {} }, {});
        row.residual = opening.open({}, job).residual;
    }

    void severed_online(StabilityRow& row, const IncisedBlock& block)
    {
        const TetMesh mesh = uncut_block(block);
        CutSession session(mesh);
        OnlineOpening opening(session, kTissues, { bottom(mesh), {} }, {});
        const CutResult cut = session.cut(severing_blade(block));
        opening.follow(cut.delta);
        const OnlineAnswer answer = opening.answer();
        set_condition(row, problem_now(session, kTissues, { bottom(mesh), {} }, {}), Elasticity::linear);
        if (answer.status == OnlineStatus::unsupported)
            refuse(row, answer.message);
    }

    /// The piece that came off is held by a hook: an answer again.
    void severed_hooked(StabilityRow& row, const IncisedBlock& block)
    {
        HookedOnline online(block, Vec3(0.0, 1.0, 3.0));
        const OnlineAnswer answer = online.cut(row, severing_blade(block));
        if (answer.status != OnlineStatus::solved)
            return refuse(row, answer.message);
        row.quantity = "hook force of a piece that hangs free, N";
        row.error = answer.hook_forces_N.front().norm();
        row.bound = 1e-9; // it moves as one; round-off of forces of 1 N
    }

    /// By its whole side.
    ElasticProblem pulled_aside(const IncisedBlock& block, const TetMesh& mesh)
    {
        HookPatch hook { "side", 1, {}, Vec3(0.0, 3.0, 0.0) };
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (mesh.vertices(v, 1) > block.size.y() - 1e-6 && mesh.vertices(v, 2) > 1e-6)
                hook.nodes.push_back(v);
        return { mesh, kTissues, { bottom(mesh), {} }, { hook } };
    }

    struct GridCut {
        const char* name;
        Blade blade;
        double lip_area; ///< mm^2, of one lip
    };

    std::vector<GridCut> grid_cuts(const IncisedBlock& block)
    {
        const double x = block.size.x(), y = 0.5 * block.size.y(), z = block.size.z(), h = block.cell;
        const auto blade = [](const Vec3& a, const Vec3& b, const Vec3& direction, double depth) {
            return Blade { .line = { a, b }, .directions = { direction }, .depth_mm = depth };
        };
        const Vec3 diagonal = Vec3(0.0, -1.0, -1.0) / std::numbers::sqrt2;
        return {
            { "cut along faces", incision_blade(block), block.length * block.depth },
            { "cut along faces, from end to end", blade({ -h, y, z }, { x + h, y, z }, -Vec3::UnitZ(), 2 * h),
                x * 2 * h },
            // The diagonals of the cells' sides lie in it, and edges along x.
            { "cut along edges, aslant", blade({ 2 * h, y, z }, { 6 * h, y, z }, diagonal, 2 * h * std::numbers::sqrt2),
                4 * h * 2 * h * std::numbers::sqrt2 },
            // Through vertices, edges and faces of other elements, from one vertex to another.
            { "cut from vertex to vertex", blade({ 2 * h, 2 * h, z }, { 8 * h, 6 * h, z }, -Vec3::UnitZ(), 2 * h),
                std::hypot(6 * h, 4 * h) * 2 * h },
            // Its front and one end run along edges in the middle of the body.
            { "cut that ends on an edge", blade({ -h, 3 * h, z }, { 6 * h, 3 * h, z }, -Vec3::UnitZ(), 3 * h),
                6 * h * 3 * h },
        };
    }

    void grid_cut(StabilityRow& row, const IncisedBlock& block, const GridCut& cut, const Job& job)
    {
        const TetMesh before = uncut_block(block);
        const Incision incision = incise(before, cut.blade);
        expect_sound(incision.mesh);
        row.quantity = "volume and area of the lips, relative";
        row.error = std::max(std::abs(volume(incision.mesh) / volume(before) - 1.0),
            std::abs(incision.report.lip_area_mm2 / cut.lip_area - 1.0));
        row.bound = 1e-12; // round-off
        const ElasticProblem problem = pulled_aside(block, incision.mesh);
        Opening opening(problem.mesh, problem.material_of_label, problem.supports, {});
        const OpeningResult result = opening.open(problem.hooks, job);
        row.residual = result.residual;
        row.reason = text("%zu elements, smallest angle of those born %.1f degrees", incision.mesh.tet_count(),
            incision.report.worst_dihedral_deg);
        set_condition(row, problem, Elasticity::corotational, result.displacement);
        if (result.status != OpeningStatus::converged)
            refuse(row, result.message);
    }

    /// What is online against the same problem set up anew.
    void through_hook(StabilityRow& row, const IncisedBlock& block)
    {
        HookedOnline online(block, Vec3(0.0, 2.0, 1.0));
        const OnlineAnswer answer = online.cut(row, incision_blade(block));
        if (answer.status != OnlineStatus::solved)
            return refuse(row, answer.message);
        OnlineOpening anew(online.session, kTissues, online.supports, {});
        (void)anew.attach(online.hook);
        OnlineAnswer expected = anew.answer();
        anew.complete(expected);
        row.quantity = "displacement against a fresh solver, relative";
        row.error = (answer.displacement - expected.displacement).cwiseAbs().maxCoeff()
            / expected.displacement.cwiseAbs().maxCoeff();
        row.bound = 1e-8;
        row.reason = text("hook force %.3f N; it keeps the vertices it had, their copies on the other lip go free",
            answer.hook_forces_N.front().norm());
    }

    enum class Series {
        same,
        slices, ///< side by side, a tenth of a millimetre apart
        crossing, ///< all through each other within a millimetre
    };

    Blade hundredth_blade(const IncisedBlock& block, int i, Series series)
    {
        Blade blade = incision_blade(block);
        const Vec3 middle = 0.5 * (blade.line[0] + blade.line[1]);
        const double turn = 2.399963 * i; // the golden angle: no two alike
        for (Vec3& p : blade.line) {
            if (series == Series::slices)
                p = middle + 0.3 * (p - middle) + Vec3(0.0, 0.1 * (i - 50) + 0.03, 0.0);
            if (series == Series::crossing)
                p = middle + Vec3(0.7 * std::cos(turn), 0.7 * std::sin(turn), 0.0)
                    + Vec3(Eigen::AngleAxisd(0.15 * std::sin(turn), Vec3::UnitZ()) * (p - middle));
        }
        return blade;
    }

    void hundred_cuts(StabilityRow& row, const IncisedBlock& block, Series series, const Job& job)
    {
        constexpr int kCuts = 100;
        // Cuts that all cross each other leave the square of their number in pieces.
        constexpr std::size_t kMostElements = 8000;
        const TetMesh before = uncut_block(block);
        CutSession session(before);
        int made = 0;
        std::string refused;
        int tried = 0;
        for (; tried < kCuts && session.tet_count() < kMostElements && !job.cancelled(); ++tried) {
            const CutResult result = session.cut(hundredth_blade(block, tried, series));
            made += result.status == CutStatus::done ? 1 : 0;
            if (result.status != CutStatus::done)
                refused = result.message;
        }
        const TetMesh mesh = session.compact_mesh();
        expect_sound(mesh);
        row.quantity = "volume, relative";
        row.error = std::abs(volume(mesh) / volume(before) - 1.0);
        row.bound = 1e-9; // what moves of the skin's vertices add up to; a plane is kept to round-off
        const std::vector<int> piece = connected_pieces(mesh);
        const int pieces = 1 + *std::max_element(piece.begin(), piece.end());
        row.reason = text("%d of %d cuts made, %zu elements, %d piece(s)%s%s%s", made, tried, mesh.tet_count(), pieces,
            tried < kCuts ? "; no more were tried, their pieces grow as the square" : "",
            refused.empty() ? "" : "; the others: ", refused.c_str());
        const ElasticProblem problem = pulled_aside(block, mesh);
        set_condition(row, problem, Elasticity::corotational);
        Opening opening(problem.mesh, problem.material_of_label, problem.supports, {});
        std::string said;
        try {
            const OpeningResult result = opening.open(problem.hooks, job);
            row.residual = result.residual;
            if (result.status != OpeningStatus::converged)
                said = result.message;
        } catch (const SolverError& error) { // a chip that came off: named
            said = error.what();
        }
        while (session.can_undo())
            (void)session.undo();
        const TetMesh after = session.compact_mesh();
        if (after.vertices != before.vertices || after.nodes != before.nodes)
            throw PromiseNotKept("undoing the cuts did not give the first mesh back");
        if (!(row.error <= row.bound))
            throw PromiseNotKept(text("the cuts changed the volume by %.1e of it", row.error));
        if (!said.empty())
            refuse(row, row.reason + "; " + said);
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
    return { "100 cuts in one place", "the mesh stays valid, and undo gives the first one back", [](const Job& job) {
                const IncisedBlock block;
                std::vector<StabilityRow> rows;
                for (const auto& [name, series] : { std::pair { "the same cut 100 times", Series::same },
                         std::pair { "slices of 0.1 mm", Series::slices },
                         std::pair { "cuts crossing within 1 mm", Series::crossing } }) {
                    rows.push_back(attempt(name, "cutter, P1 corotational",
                        [&, s = series](StabilityRow& row) { hundred_cuts(row, block, s, job); }));
                    rows.back().allowed = { StabilityOutcome::answered, StabilityOutcome::refused };
                }
                return rows;
            } };
}

} // namespace retractor
