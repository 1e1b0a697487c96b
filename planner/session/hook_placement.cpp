#include "planner/session/hook_placement.h"

#include "fem/statics/hook.h"
#include "mesh/base/error.h"
#include "mesh/base/geometry.h"
#include "mesh/base/triangle.h"
#include "planner/approach/hook_patches.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <optional>
#include <queue>
#include <set>
#include <utility>

namespace retractor::planner {

namespace {

    /// Largest distance between the touched place and the wound's edge.
    constexpr double kReachMm = 20.0;
    /// The direction of a lip is the mean over its faces within this distance.
    constexpr double kLipRadiusMm = 12.0;
    /// Distance by which the patch reaches beyond the wound's edge, so that the edge lies under the patch.
    constexpr double kAboveEdgeMm = 1.0;

    using Lip = std::pair<int, int>; ///< number of the cut, and side

    /// Vertices where both lips of a cut meet. No hook can hold these vertices, and the way from lip to lip leads
    /// through them.
    std::set<VertexId> meeting_vertices(std::span<const LipTriangle> lips)
    {
        std::map<VertexId, std::set<Lip>> lips_of;
        for (const LipTriangle& lip : lips)
            for (const VertexId v : lip.vertices)
                lips_of[v].insert({ lip.cut, lip.side });
        std::set<VertexId> meeting;
        for (const auto& [v, of] : lips_of)
            for (const auto& [cut, side] : of)
                if (of.contains({ cut, -side }) && side != 0)
                    meeting.insert(v);
        return meeting;
    }

    Vec3 place(const WallSurface& surface, VertexId v) { return surface.rest.row(v).transpose(); }

    /// The vertex on a wound's edge nearest to a place, by the distance along the surface; -1: none within reach. Two
    /// lips that touch at rest are far apart along the surface.
    VertexId nearest_on_edge(
        const WallSurface& surface, const std::set<VertexId>& edge, const std::set<VertexId>& meeting, const Touch& at)
    {
        std::map<VertexId, std::vector<VertexId>> neighbours;
        for (const auto& triangle : surface.triangles)
            if (std::any_of(triangle.begin(), triangle.end(),
                    [&](VertexId v) { return (place(surface, v) - at.rest).norm() < kReachMm; }))
                for (const VertexId a : triangle)
                    for (const VertexId b : triangle)
                        if (a != b)
                            neighbours[a].push_back(b);
        std::map<VertexId, double> way;
        using Step = std::pair<double, VertexId>;
        std::priority_queue<Step, std::vector<Step>, std::greater<>> front;
        const auto reach = [&](VertexId v, double distance) {
            const auto [known, fresh] = way.try_emplace(v, distance);
            if (!fresh && known->second <= distance)
                return;
            known->second = distance;
            front.emplace(distance, v);
        };
        for (const VertexId v : at.triangle)
            if (neighbours.contains(v))
                reach(v, (place(surface, v) - at.rest).norm());
        while (!front.empty()) {
            const auto [distance, v] = front.top();
            front.pop();
            if (distance > kReachMm || meeting.contains(v))
                continue;
            if (edge.contains(v))
                return v;
            for (const VertexId next : neighbours[v])
                reach(next, distance + (place(surface, next) - place(surface, v)).norm());
        }
        return -1;
    }

    /// The edges of all wounds.
    struct WoundEdges {
        std::vector<std::array<VertexId, 2>> rims;
        std::set<VertexId> edge, meeting;
    };

    /// @param outward out of the body. Where a cut goes through the wall, its inner edges do not count: nobody sets an
    /// instrument there.
    std::optional<WoundEdges> edges_of(
        const WallSurface& surface, std::span<const LipTriangle> lips, const Vec3& outward, std::string& why_not)
    {
        if (lips.empty()) {
            why_not = "there is no wound to open: cut first";
            return std::nullopt;
        }
        WoundEdges edges { .rims = wound_rims(surface), .edge = {}, .meeting = meeting_vertices(lips) };
        for (const auto& rim : edges.rims)
            edges.edge.insert(rim.begin(), rim.end());
        std::map<VertexId, double> outside; // how far the faces around an edge, but for lips, look out of the body
        for (std::size_t t = 0; t < surface.triangles.size(); ++t)
            if (surface.is_lip[t] == 0) {
                const auto& triangle = surface.triangles[t];
                const Vec3 a = place(surface, triangle[0]);
                const double out
                    = (place(surface, triangle[1]) - a).cross(place(surface, triangle[2]) - a).dot(outward);
                for (const VertexId v : triangle)
                    if (edges.edge.contains(v))
                        outside[v] += out;
            }
        std::erase_if(edges.edge, [&](VertexId v) { return outside[v] < 0.0; });
        return edges;
    }

    /// A vertex of a wound's edge, and its lip.
    struct Grip {
        VertexId vertex = -1;
        Lip lip;
    };

    std::optional<Lip> lip_of(std::span<const LipTriangle> lips, VertexId vertex)
    {
        const auto own = std::find_if(lips.begin(), lips.end(), [&](const LipTriangle& lip) {
            return std::find(lip.vertices.begin(), lip.vertices.end(), vertex) != lip.vertices.end();
        });
        return own == lips.end() ? std::nullopt : std::optional(Lip { own->cut, own->side });
    }

    std::optional<Grip> grip_near(const WallSurface& surface, std::span<const LipTriangle> lips,
        const WoundEdges& edges, const Touch& at, std::string& why_not)
    {
        const VertexId vertex = nearest_on_edge(surface, edges.edge, edges.meeting, at);
        if (vertex < 0) {
            why_not = "there is no wound within 20 mm of here: press on the skin beside its edge";
            return std::nullopt;
        }
        const auto lip = lip_of(lips, vertex);
        if (!lip) // the surface is older than the cut
            why_not = "the wound has just changed: press again";
        return lip ? std::optional(Grip { vertex, *lip }) : std::nullopt;
    }

    /// The place of the other lip that lay beside the grip before the cut.
    std::optional<Grip> grip_opposite(const WallSurface& surface, std::span<const LipTriangle> lips,
        const WoundEdges& edges, const Grip& grip, std::string& why_not)
    {
        if (grip.lip.second == 0) { // bared by taking tissue out
            why_not = "the wound has no other lip opposite: a retractor needs two";
            return std::nullopt;
        }
        const Lip other { grip.lip.first, -grip.lip.second };
        Grip nearest { -1, other };
        double least = kReachMm;
        for (const LipTriangle& lip : lips)
            if (Lip { lip.cut, lip.side } == other)
                for (const VertexId v : lip.vertices)
                    if (const double distance = (place(surface, v) - place(surface, grip.vertex)).norm();
                        distance < least && edges.edge.contains(v) && !edges.meeting.contains(v)) {
                        least = distance;
                        nearest.vertex = v;
                    }
        if (nearest.vertex < 0) {
            why_not = "the wound has no other lip opposite: a retractor needs two";
            return std::nullopt;
        }
        return nearest;
    }

    /// Turns a patch so that it pulls this way. @pre the patch has a direction along the wound
    void turn_to_pull(HookPlacement& placement, const Vec3& pull, const Vec3& inward)
    {
        placement.pull = pull;
        placement.along = (placement.along - placement.along.dot(pull) * pull).normalized();
        placement.inward = pull.cross(placement.along).normalized();
        if (placement.inward.dot(inward) < 0.0)
            placement.inward = -placement.inward;
    }

    /// Turns a patch as the lip lies at the grip. @return false, with the reason, where the edge has no direction
    bool turn_to_lip(const WallSurface& surface, std::span<const LipTriangle> lips, const WoundEdges& edges,
        const Grip& grip, const Vec3& inward, HookPlacement& placement, std::string& why_not)
    {
        placement.cut = grip.lip.first;
        placement.side = grip.lip.second;
        Vec3 gap = Vec3::Zero(), along = Vec3::Zero();
        for (const LipTriangle& lip : lips) {
            if (Lip { lip.cut, lip.side } != grip.lip)
                continue;
            const Vec3 a = place(surface, lip.vertices[0]);
            if ((a - place(surface, grip.vertex)).norm() < kLipRadiusMm)
                gap += (place(surface, lip.vertices[1]) - a).cross(place(surface, lip.vertices[2]) - a);
        }
        for (const auto& [a, b] : edges.rims)
            if (a == grip.vertex || b == grip.vertex) {
                const Vec3 piece = place(surface, b) - place(surface, a);
                along += along.dot(piece) < 0.0 ? Vec3(-piece) : piece;
            }
        if (!(gap.norm() > 0.0 && along.norm() > 0.0)) {
            why_not = "the edge of the wound has no direction here: press elsewhere on it";
            return false;
        }
        placement.along = along;
        turn_to_pull(placement, -gap.normalized(), inward);
        return true;
    }

    /// Takes the free vertices of the lip under the patch, or under a wider one up to three times its size.
    /// @return false, with the reason, where there are fewer than three; there are no nodes then
    bool take_nodes(const WallSurface& surface, std::span<const LipTriangle> lips, const WoundEdges& edges,
        std::span<const char> held, VertexId grip, HookPlacement& placement, std::string& why_not)
    {
        placement.arm = place(surface, grip) - kAboveEdgeMm * placement.inward;
        placement.centre = placement.arm + 0.5 * placement.height_mm * placement.inward;
        std::vector<std::array<VertexId, 3>> faces;
        for (const LipTriangle& lip : lips)
            if (lip.cut == placement.cut && lip.side == placement.side)
                faces.push_back(lip.vertices);
        mesh::TetMesh vertices; // in the form that hook_patch_nodes() takes
        vertices.vertices = surface.rest;
        // Where the mesh is coarser than the hook, the hook holds what a wider one would.
        for (const double wider : { 1.0, 1.5, 2.0, 3.0 }) {
            try {
                placement.nodes = fem::hook_patch_nodes(vertices, faces, placement.centre, placement.along,
                    placement.inward, wider * placement.width_mm, wider * placement.height_mm);
            } catch (const InputError&) {
                why_not = "the edge of the wound gives no hold here: press elsewhere on it";
                continue;
            }
            std::erase_if(placement.nodes, [&](VertexId v) {
                return edges.meeting.contains(v)
                    || (static_cast<std::size_t>(v) < held.size() && held[static_cast<std::size_t>(v)] != 0);
            });
            if (placement.nodes.size() >= 3) {
                why_not.clear();
                return true;
            }
            why_not = "the wound is too small here: fewer than three of its places are free to be held";
        }
        placement.nodes.clear();
        return false;
    }

    /// Whether a lip lies under both halves of a blade. @return false, with the reason, where the blade is longer than
    /// the wound
    bool reaches_both_ends(const WallSurface& surface, const HookPlacement& blade, std::string& why_not)
    {
        constexpr double kShare = 0.5; // of each half: a mesh is coarse, and a short wound is held by a broad blade
        double least = 0.0, most = 0.0;
        for (const VertexId v : blade.nodes) {
            const double along = (place(surface, v) - blade.centre).dot(blade.along);
            least = std::min(least, along);
            most = std::max(most, along);
        }
        const bool reaches = std::min(-least, most) >= kShare * 0.5 * blade.width_mm;
        if (!reaches)
            why_not = "the blade would reach beyond the end of the wound: press nearer to its middle";
        return reaches;
    }

    /// The mean direction into the body near a place; on the inner side of the wall, against `outward`.
    Vec3 into_body(const Touch& at, const Vec3& outward)
    {
        return at.inward.dot(outward) > 0.0 ? Vec3(-outward) : at.inward;
    }

    /// Numbers the lips as the plan of a hook does: the hook's side is the lip that looks against its pull. A line that
    /// was drawn by hand may run either way, and each face by itself may look anywhere, because a lip is as rough as
    /// the mesh: a lip as a whole decides, by its faces near the hook. Cuts across the pull, and cuts elsewhere, have
    /// no lip that could be held this way, and are left out.
    void number_lips_for(
        const HookSpec& spec, const Vec3& centre, const mesh::TetMesh& wall, std::vector<mesh::LipFace>& lips)
    {
        constexpr double kAgainst = 0.5; // share of a lip's area that looks against the pull
        struct Looks {
            double against = 0.0, area = 0.0;
            bool hold() const { return std::abs(against) >= kAgainst * area && area > 0.0; }
        };
        const auto looks = [&](const mesh::LipFace& lip) {
            const Vec3 area = area_vector(wall.vertices, mesh::face_vertices(wall, lip.face));
            return Looks { .against = -area.dot(spec.direction), .area = area.norm() };
        };
        const double near = std::max(spec.patch_width_mm, spec.patch_height_mm);
        std::map<int, Looks> of_cut; // against > 0: side +1 of the cut looks against the pull
        for (const mesh::LipFace& lip : lips) {
            const auto corners = mesh::face_vertices(wall, lip.face);
            if (std::ranges::none_of(
                    corners, [&](VertexId v) { return (point_at(wall.vertices, v) - centre).norm() < near; }))
                continue;
            const Looks face = looks(lip);
            of_cut[lip.cut].against += lip.side * face.against;
            of_cut[lip.cut].area += lip.side != 0 ? face.area : 0.0;
        }
        std::erase_if(lips, [&](mesh::LipFace& lip) {
            Looks whole = lip.side != 0 ? of_cut[lip.cut] : looks(lip); // 0: bared by taking tissue out
            if (lip.side != 0)
                whole.against *= lip.side;
            lip.side = whole.against > 0.0 ? spec.side : -spec.side;
            return !whole.hold();
        });
    }

    Vec3 mean_direction(const Approach& approach)
    {
        Vec3 sum = Vec3::Zero();
        for (const Vec3& direction : approach.directions)
            sum += direction;
        return sum.normalized();
    }

} // namespace

std::vector<LipTriangle> lip_triangles(const mesh::CutSession& session)
{
    std::vector<LipTriangle> triangles;
    for (const mesh::LipFace& lip : session.lips()) {
        const auto nodes = session.tet(lip.face.tet).nodes;
        LipTriangle triangle { {}, lip.cut, lip.side };
        for (std::size_t i = 0; i < 3; ++i)
            triangle.vertices[i]
                = nodes[static_cast<std::size_t>(mesh::kTetFaces[static_cast<std::size_t>(lip.face.corner)][i])];
        triangles.push_back(triangle);
    }
    return triangles;
}

HookPlacement find_hook_placement(const WallSurface& surface, std::span<const LipTriangle> lips,
    std::span<const char> held, const Vec3& outward, const Touch& at, std::string& why_not)
{
    HookPlacement placement;
    if (const auto edges = edges_of(surface, lips, outward, why_not)) {
        const auto grip = grip_near(surface, lips, *edges, at, why_not);
        if (grip && turn_to_lip(surface, lips, *edges, *grip, into_body(at, outward), placement, why_not))
            take_nodes(surface, lips, *edges, held, grip->vertex, placement, why_not);
    }
    return placement;
}

std::array<HookPlacement, 2> find_blade_placements(const WallSurface& surface, std::span<const LipTriangle> lips,
    std::span<const char> held, const Vec3& outward, const Touch& at, double width_mm, double depth_mm,
    std::string& why_not)
{
    HookPlacement blade;
    blade.width_mm = width_mm;
    blade.height_mm = depth_mm;
    std::array<HookPlacement, 2> blades { blade, blade };
    const auto edges = edges_of(surface, lips, outward, why_not);
    if (!edges)
        return blades;
    const auto first = grip_near(surface, lips, *edges, at, why_not);
    if (!first)
        return blades;
    const auto second = grip_opposite(surface, lips, *edges, *first, why_not);
    if (!second)
        return blades;
    const std::array grips { *first, *second };
    for (std::size_t i = 0; i < 2; ++i)
        if (!turn_to_lip(surface, lips, *edges, grips[i], into_body(at, outward), blades[i], why_not))
            return blades;
    const Vec3 apart = blades[0].pull - blades[1].pull; // the lips of a bent wound are not quite parallel
    if (!(apart.norm() > 1.0)) { // more than 120 degrees between them
        why_not = "the lips do not face each other here: press elsewhere on the edge";
        blades[0].nodes.clear();
        return blades;
    }
    const Vec3 rack = apart.normalized();
    for (std::size_t i = 0; i < 2; ++i) {
        turn_to_pull(blades[i], i == 0 ? rack : Vec3(-rack), into_body(at, outward));
        if (!take_nodes(surface, lips, *edges, held, grips[i].vertex, blades[i], why_not)
            || !reaches_both_ends(surface, blades[i], why_not)) {
            blades[0].nodes.clear();
            return blades;
        }
    }
    return blades;
}

PlannedPlacements planned_placements(const mesh::CutSession& session, const Approach& approach,
    const mesh::LabelTable& table, std::span<const char> held)
{
    PlannedPlacements planned;
    mesh::SlotMap map;
    const mesh::TetMesh wall = session.compact_mesh(&map);
    fem::Supports supports;
    for (std::size_t v = 0; v < map.vertex_slot.size(); ++v)
        if (const auto id = static_cast<std::size_t>(map.vertex_slot[v]); id < held.size() && held[id] != 0)
            supports.fixed.push_back(static_cast<VertexId>(v));
    for (const HookSpec& spec : approach.hooks) {
        std::vector<mesh::LipFace> lips = session.lips();
        for (mesh::LipFace& lip : lips)
            lip.face.tet = map.compact_tet[static_cast<std::size_t>(lip.face.tet)];
        number_lips_for(spec, patch_place(approach, spec).centre, wall, lips);
        Approach one = approach;
        one.hooks = { spec };
        if (approach.retractor) // a blade pushes the lip, and bone through it
            one.hooks[0].bearing.clear();
        try {
            const fem::HookPatch patch = hook_patches(wall, lips, one, table, supports).front();
            HookPlacement placement { .side = spec.side,
                .pull = spec.direction,
                .width_mm = spec.patch_width_mm,
                .height_mm = spec.patch_height_mm };
            for (const VertexId v : patch.nodes) {
                placement.nodes.push_back(map.vertex_slot[static_cast<std::size_t>(v)]);
                placement.centre += wall.vertices.row(v).transpose() / static_cast<double>(patch.nodes.size());
            }
            std::sort(placement.nodes.begin(), placement.nodes.end());
            const Vec3 inward = mean_direction(approach);
            placement.along = inward.cross(spec.direction).normalized();
            placement.inward = spec.direction.cross(placement.along).normalized();
            const PatchPlace planned_place = patch_place(approach, spec);
            placement.arm = planned_place.centre - spec.depth_mm * planned_place.depth;
            planned.placements.push_back(std::move(placement));
            planned.names.push_back(spec.name);
            planned.drives.push_back(drive_of(spec));
        } catch (const InputError& error) {
            planned.omitted += (planned.omitted.empty() ? "" : "; ") + error.where() + ": " + error.what();
        }
    }
    return planned;
}

} // namespace retractor::planner
