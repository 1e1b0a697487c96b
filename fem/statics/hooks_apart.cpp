#include "fem/statics/hooks_apart.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace retractor::fem {

namespace {

    /// The patch of a hook as a disc: middle, radius, and outward unit normal of the surface under the patch (zero
    /// without surface).
    struct PatchPlane {
        Vec3 middle = Vec3::Zero(), normal = Vec3::Zero();
        double radius = 0.0;
    };

    Vec3 middle_of(const mesh::TetMesh& mesh, const HookPatch& hook)
    {
        Vec3 middle = Vec3::Zero();
        for (const VertexId v : hook.nodes)
            middle += mesh.vertices.row(v).transpose() / static_cast<double>(hook.nodes.size());
        return middle;
    }

    std::vector<PatchPlane> patch_planes(const mesh::TetMesh& mesh, std::span<const HookPatch> hooks)
    {
        std::vector<PatchPlane> planes(hooks.size());
        std::vector<int> hook_of_node(mesh.vertex_count(), -1);
        for (std::size_t h = 0; h < hooks.size(); ++h) {
            planes[h].middle = middle_of(mesh, hooks[h]);
            for (const VertexId v : hooks[h].nodes)
                hook_of_node[static_cast<std::size_t>(v)] = static_cast<int>(h);
            for (const VertexId v : hooks[h].nodes)
                planes[h].radius
                    = std::max(planes[h].radius, (mesh.vertices.row(v).transpose() - planes[h].middle).norm());
        }
        for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
            const auto corners = mesh::face_vertices(mesh, face);
            const int hook = hook_of_node[static_cast<std::size_t>(corners[0])];
            if (hook < 0 || hook_of_node[static_cast<std::size_t>(corners[1])] != hook
                || hook_of_node[static_cast<std::size_t>(corners[2])] != hook)
                continue;
            planes[static_cast<std::size_t>(hook)].normal += area_vector(mesh.vertices, corners);
        }
        for (PatchPlane& plane : planes)
            plane.normal.normalize(); // a zero vector stays zero
        return planes;
    }

    bool on_two_sides(std::span<const HookPatch> hooks)
    {
        return std::any_of(
            hooks.begin(), hooks.end(), [&](const HookPatch& hook) { return hook.side * hooks.front().side < 0; });
    }

    Eigen::Index row_of(std::size_t hook) { return 3 * static_cast<Eigen::Index>(hook); }

    /// The direction, in the unknowns of all hooks, that separates a pair.
    Eigen::VectorXd parting(const FacingHooks& pair, Eigen::Index unknowns)
    {
        Eigen::VectorXd way = Eigen::VectorXd::Zero(unknowns);
        way.segment<3>(row_of(pair.a)) = -pair.normal;
        way.segment<3>(row_of(pair.b)) = pair.normal;
        return way;
    }

    /// Overlap of two hooks that move and turn: their common normal turns with them.
    double crossing_of_turned(
        const mesh::TetMesh& mesh, const FacingHooks& pair, const HookPatch& a, const HookPatch& b)
    {
        const Vec3 normal = (a.rotation * pair.normal + b.rotation * pair.normal).normalized();
        const Vec3 from = middle_of(mesh, a), to = middle_of(mesh, b);
        const Vec3 apart = to + b.displacement_of(to) - from - a.displacement_of(from);
        const double slack = (to - from).dot(pair.normal) - pair.gap_mm; // negative where they overlap at rest
        return slack - apart.dot(normal);
    }

    double crossing_of(const FacingHooks& pair, const Eigen::VectorXd& d)
    {
        return crossing_mm(pair, d.segment<3>(row_of(pair.a)), d.segment<3>(row_of(pair.b)));
    }

    /// Separates hooks that prescribe their displacement. @return the pairs that were moved back
    std::vector<FacingHooks> draw_prescribed_back(std::span<const FacingHooks> facing, std::vector<HookDrive>& drives)
    {
        std::vector<FacingHooks> both;
        for (const FacingHooks& pair : facing)
            if (drives[pair.a].prescribes() && drives[pair.b].prescribes())
                both.push_back(pair);
        std::vector<Vec3> moved;
        for (const HookDrive& drive : drives)
            moved.push_back(drive.displacement);
        std::vector<FacingHooks> met = draw_back(both, std::vector<double>(drives.size(), 1.0), moved);
        for (std::size_t h = 0; h < drives.size(); ++h)
            drives[h].displacement = moved[h];
        return met;
    }

    /// Contact of hooks that a force, a grip or a limit controls (augmented Lagrangian: Nocedal, Wright 2006, Numerical
    /// Optimization, 17.4). A stiff spring acts between the planes of each pair that presses. The force of the spring
    /// is added to the start of the next solution, which removes the rest of the overlap.
    class PressingPairs {
    public:
        PressingPairs(const Eigen::MatrixXd& R, std::vector<FacingHooks> pairs)
            : pairs_(std::move(pairs))
            , presses_(pairs_.size(), 0)
            , ahead_mm_(pairs_.size(), 0.0)
        {
            // A larger factor loses digits of the tissue, a smaller factor takes more rounds.
            constexpr double kStiff = 1e4;
            if (!pairs_.empty())
                spring_ = kStiff * R.diagonal().maxCoeff();
        }

        void add_to(Eigen::MatrixXd& R, Eigen::VectorXd& r) const
        {
            for (std::size_t i = 0; i < pairs_.size(); ++i) {
                if (presses_[i] == 0)
                    continue;
                const Eigen::VectorXd way = parting(pairs_[i], r.size());
                R += spring_ * way * way.transpose();
                r += spring_ * (pairs_[i].gap_mm - ahead_mm_[i]) * way;
            }
        }

        /// Updates which pairs press. @return whether the same pairs press as before
        bool stay(const Eigen::VectorXd& d)
        {
            bool same = true;
            for (std::size_t i = 0; i < pairs_.size(); ++i) {
                const double slack = presses_[i] != 0 ? 0.0 : pairs_[i].round_off_mm;
                const auto now = static_cast<char>(crossing_of(pairs_[i], d) + ahead_mm_[i] > slack);
                same = same && now == presses_[i];
                presses_[i] = now;
                if (now == 0)
                    ahead_mm_[i] = 0.0;
            }
            return same;
        }

        /// Adds the spring forces. @return whether no pair overlaps any more
        bool press_on(const Eigen::VectorXd& d)
        {
            constexpr double kRoundOff = 100.0; // forces at their limits are less exact than displacements
            bool apart = true;
            for (std::size_t i = 0; i < pairs_.size(); ++i) {
                if (presses_[i] == 0)
                    continue;
                const double crossing = crossing_of(pairs_[i], d);
                apart = apart && std::abs(crossing) <= kRoundOff * pairs_[i].round_off_mm;
                ahead_mm_[i] += crossing;
            }
            return apart;
        }

        void gather(std::vector<FacingHooks>& meeting) const
        {
            for (std::size_t i = 0; i < pairs_.size(); ++i)
                if (presses_[i] != 0)
                    meeting.push_back(pairs_[i]);
        }

    private:
        std::vector<FacingHooks> pairs_;
        std::vector<char> presses_;
        std::vector<double> ahead_mm_; ///< per pair: accumulated force divided by the spring stiffness
        double spring_ = 0.0; ///< N/mm
    };

} // namespace

std::vector<FacingHooks> facing_hooks(const mesh::TetMesh& mesh, std::span<const HookPatch> hooks)
{
    std::vector<FacingHooks> facing;
    if (hooks.empty() || !on_two_sides(hooks))
        return facing;
    const std::vector<PatchPlane> planes = patch_planes(mesh, hooks);
    constexpr double kFacing = -0.5, kRoundOff = 1e-9;
    // Relative to the reach, for bent lips; with a larger overlap there is tissue between the hooks.
    constexpr double kOverlap = 0.25;
    for (std::size_t a = 0; a < hooks.size(); ++a)
        for (std::size_t b = a + 1; b < hooks.size(); ++b) {
            if (hooks[a].side * hooks[b].side >= 0 || planes[a].normal.dot(planes[b].normal) > kFacing)
                continue;
            const Vec3 normal = (planes[a].normal - planes[b].normal).normalized();
            const Vec3 apart = planes[b].middle - planes[a].middle;
            const double gap = apart.dot(normal), reach = planes[a].radius + planes[b].radius;
            if ((apart - gap * normal).norm() > reach || gap > reach || gap < -kOverlap * reach)
                continue; // the two patches do not face each other
            facing.push_back({ a, b, normal, std::max(gap, 0.0), kRoundOff * reach });
        }
    return facing;
}

double crossing_mm(const FacingHooks& pair, const Vec3& moved_a, const Vec3& moved_b)
{
    return -(moved_b - moved_a).dot(pair.normal) - pair.gap_mm;
}

void check_hooks_apart(const mesh::TetMesh& mesh, std::span<const HookPatch> hooks)
{
    for (const FacingHooks& pair : facing_hooks(mesh, hooks)) {
        const HookPatch &a = hooks[pair.a], &b = hooks[pair.b];
        const double crossing = crossing_of_turned(mesh, pair, a, b);
        if (crossing > pair.round_off_mm)
            throw InputError("hooks '" + a.name + "' and '" + b.name + "' would pass through each other by "
                    + std::to_string(crossing) + " mm: their lips meet before",
                "hook '" + a.name + "'");
    }
}

std::vector<FacingHooks> draw_back(
    std::span<const FacingHooks> facing, std::span<const double> gives_way, std::vector<Vec3>& moved)
{
    RETRACTOR_ASSERT(gives_way.size() == moved.size());
    // One round treats the pairs in turn; one pair takes one round, several pairs take some.
    constexpr int kRounds = 200;
    std::vector<char> met(facing.size(), 0);
    bool changed = true;
    for (int round = 0; round < kRounds && changed; ++round) {
        changed = false;
        for (std::size_t i = 0; i < facing.size(); ++i) {
            const FacingHooks& pair = facing[i];
            const double both = gives_way[pair.a] + gives_way[pair.b];
            const double crossing = crossing_mm(pair, moved[pair.a], moved[pair.b]);
            if (both <= 0.0 || !(crossing > pair.round_off_mm))
                continue;
            moved[pair.a] -= gives_way[pair.a] / both * crossing * pair.normal;
            moved[pair.b] += gives_way[pair.b] / both * crossing * pair.normal;
            met[i] = 1;
            changed = true;
        }
    }
    std::vector<FacingHooks> pairs;
    for (std::size_t i = 0; i < facing.size(); ++i)
        if (met[i] != 0)
            pairs.push_back(facing[i]);
    return pairs;
}

RestApart rest_of_hooks_apart(const Eigen::MatrixXd& R, const Eigen::VectorXd& r, std::vector<HookDrive> drives,
    std::span<const FacingHooks> facing)
{
    RestApart apart;
    apart.meeting = draw_prescribed_back(facing, drives);
    std::vector<FacingHooks> others;
    for (const FacingHooks& pair : facing)
        if ((!drives[pair.a].prescribes() || !drives[pair.b].prescribes())
            && !(drives[pair.a].only_along && drives[pair.b].only_along))
            others.push_back(pair);
    if (std::all_of(drives.begin(), drives.end(), [](const HookDrive& drive) { return drive.prescribes(); })) {
        std::vector<Vec3> told;
        for (const HookDrive& drive : drives)
            told.push_back(drive.displacement);
        apart.rest = { .displacement = packed(told), .yielded = std::vector<bool>(drives.size(), false) };
        return apart;
    }
    PressingPairs pressing(R, std::move(others));
    constexpr int kRounds = 60;
    for (int round = 0; round < kRounds; ++round) {
        Eigen::MatrixXd stiffness = R;
        Eigen::VectorXd forces = r;
        pressing.add_to(stiffness, forces);
        apart.rest = rest_of_hooks(stiffness, forces, drives);
        if (!apart.rest.converged)
            return apart;
        if (pressing.stay(apart.rest.displacement) && pressing.press_on(apart.rest.displacement)) {
            pressing.gather(apart.meeting);
            return apart;
        }
    }
    apart.rest.converged = false;
    return apart;
}

} // namespace retractor::fem
