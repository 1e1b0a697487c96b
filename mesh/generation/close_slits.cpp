#include "mesh/generation/close_slits.h"

#include "mesh/base/triangle.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace retractor::mesh {

namespace {

    constexpr int kMostPasses = 3; ///< an element may leave the next slit beside itself

    std::size_t u(VertexId v) { return static_cast<std::size_t>(v); }

    const Vec3& at(const LocalMesh& mesh, VertexId v) { return mesh.vertices[u(v)]; }

    using FaceKey = std::array<VertexId, 3>; ///< sorted

    FaceKey key_of(FaceKey corners)
    {
        std::sort(corners.begin(), corners.end());
        return corners;
    }

    struct Face {
        FaceKey key {};
        std::array<VertexId, 3> corners {}; ///< seen from outside of its element anticlockwise
    };

    /// All faces of all elements, sorted by their keys.
    std::vector<Face> sorted_faces(const LocalMesh& mesh)
    {
        std::vector<Face> faces;
        faces.reserve(4 * mesh.tets.size());
        for (const auto& tet : mesh.tets)
            for (int corner = 0; corner < 4; ++corner) {
                const std::array<VertexId, 3> corners = face_corners(tet, corner);
                faces.push_back({ key_of(corners), corners });
            }
        std::ranges::sort(faces, {}, &Face::key);
        return faces;
    }

    /// The faces with this key: none, that of the surface, or those of two neighbours.
    std::span<const Face> faces_of(const std::vector<Face>& sorted, const FaceKey& key)
    {
        const auto found = std::ranges::equal_range(sorted, key, {}, &Face::key);
        return { found.begin(), found.end() };
    }

    /// Two faces of the surface that share an edge, and how sharply they meet.
    struct Fold {
        std::array<VertexId, 2> edge {};
        std::array<VertexId, 2> tips {}; ///< third corners of the faces
        std::array<FaceKey, 2> faces {};
        double cosine = 1.0; ///< of the angle between the outward normals
    };

    VertexId tip_of(const FaceKey& face, const std::array<VertexId, 2>& edge)
    {
        for (const VertexId v : face)
            if (v != edge[0] && v != edge[1])
                return v;
        return face[0];
    }

    /// An edge of a face of the surface.
    struct SurfaceEdge {
        std::array<VertexId, 2> ends {}; ///< sorted
        const Face* face = nullptr;
    };

    /// All edges of all faces of the surface, sorted by their ends.
    std::vector<SurfaceEdge> surface_edges(const std::vector<Face>& sorted)
    {
        std::vector<SurfaceEdge> edges;
        for (std::size_t i = 0; i < sorted.size(); ++i) {
            if (i + 1 < sorted.size() && sorted[i + 1].key == sorted[i].key) {
                ++i; // within the mesh
                continue;
            }
            for (std::size_t k = 0; k < 3; ++k) {
                const VertexId a = sorted[i].corners[k], b = sorted[i].corners[(k + 1) % 3];
                edges.push_back({ { std::min(a, b), std::max(a, b) }, &sorted[i] });
            }
        }
        std::ranges::sort(edges, [](const SurfaceEdge& a, const SurfaceEdge& b) {
            return a.ends != b.ends ? a.ends < b.ends : a.face->key < b.face->key;
        });
        return edges;
    }

    Vec3 normal_of(const LocalMesh& mesh, const std::array<VertexId, 3>& corners)
    {
        return unit_normal(at(mesh, corners[0]), at(mesh, corners[1]), at(mesh, corners[2]));
    }

    /// Edges of the surface at which it folds inwards or outwards by more than a right angle; the sharpest first.
    std::vector<Fold> sharp_folds(const LocalMesh& mesh, const std::vector<SurfaceEdge>& edges, bool inwards)
    {
        std::vector<Fold> folds;
        for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
            while (end < edges.size() && edges[end].ends == edges[begin].ends)
                ++end;
            if (end - begin != 2)
                continue; // the surface touches itself there
            const Face &f = *edges[begin].face, &g = *edges[begin + 1].face;
            const Vec3 n = normal_of(mesh, f.corners);
            Fold fold {
                .edge = edges[begin].ends, .faces = { f.key, g.key }, .cosine = n.dot(normal_of(mesh, g.corners))
            };
            fold.tips = { tip_of(f.key, fold.edge), tip_of(g.key, fold.edge) };
            const bool is_inwards = (at(mesh, fold.tips[1]) - at(mesh, fold.edge[0])).dot(n) > 0.0;
            if (is_inwards == inwards && fold.cosine < 0.0)
                folds.push_back(fold);
        }
        std::ranges::stable_sort(folds, {}, &Fold::cosine);
        return folds;
    }

    /// How sharply the surface folds at the edges of an element, before and after it is added: the sum of the squares
    /// of 1 - cosine of the angle between the normals, and more where the surface touches itself.
    struct Sharpness {
        double before = 0.0, after = 0.0;
    };

    double sharpness_of(const LocalMesh& mesh, const std::vector<std::array<VertexId, 3>>& faces_at_edge)
    {
        constexpr double kTouching = 4.0; // as folded flat
        if (faces_at_edge.size() < 2)
            return 0.0; // within the mesh
        if (faces_at_edge.size() > 2)
            return kTouching;
        const double cosine = normal_of(mesh, faces_at_edge[0]).dot(normal_of(mesh, faces_at_edge[1]));
        return (1.0 - cosine) * (1.0 - cosine);
    }

    enum class Change : std::uint8_t { add, remove };

    /// Of an element that is added or removed.
    Sharpness sharpness_at(
        const LocalMesh& mesh, const std::vector<SurfaceEdge>& edges, const std::array<VertexId, 4>& tet, Change change)
    {
        std::array<std::array<VertexId, 3>, 4> own {}; // as faces of the surface
        for (std::size_t corner = 0; corner < own.size(); ++corner) {
            own[corner] = face_corners(tet, static_cast<int>(corner));
            if (change == Change::remove)
                std::swap(own[corner][0], own[corner][1]);
        }
        Sharpness sum;
        for (const auto& [i, j] : kTetEdges) {
            const VertexId a = tet[static_cast<std::size_t>(i)], b = tet[static_cast<std::size_t>(j)];
            const std::array<VertexId, 2> ends { std::min(a, b), std::max(a, b) };
            std::vector<std::array<VertexId, 3>> before, after;
            for (const SurfaceEdge& edge : std::ranges::equal_range(edges, ends, {}, &SurfaceEdge::ends)) {
                before.push_back(edge.face->corners);
                const auto covers = [&](const auto& face) { return key_of(face) == edge.face->key; };
                if (std::ranges::none_of(own, covers))
                    after.push_back(edge.face->corners);
            }
            for (const auto& face : own) {
                const bool at_edge
                    = std::ranges::find(face, ends[0]) != face.end() && std::ranges::find(face, ends[1]) != face.end();
                const auto is_covered = [&](const auto& old) { return key_of(old) == key_of(face); };
                if (at_edge && std::ranges::none_of(before, is_covered))
                    after.push_back(face);
            }
            sum.before += sharpness_of(mesh, before);
            const bool touches_anew = after.size() > 2 && before.size() <= 2;
            sum.after += touches_anew ? std::numeric_limits<double>::infinity() : sharpness_of(mesh, after);
        }
        return sum;
    }

    bool gets_smoother(
        const LocalMesh& mesh, const std::vector<SurfaceEdge>& edges, const std::array<VertexId, 4>& tet, Change change)
    {
        const Sharpness sharpness = sharpness_at(mesh, edges, tet, change);
        return sharpness.after < sharpness.before;
    }

    /// The element that closes a fold, with positive volume; nothing when one of its angles is smaller than asked.
    std::optional<std::array<VertexId, 4>> element_in(const LocalMesh& mesh, const Fold& fold, double smallest_deg)
    {
        std::array<VertexId, 4> tet { fold.edge[0], fold.edge[1], fold.tips[0], fold.tips[1] };
        const auto corner = [&](std::size_t k) { return at(mesh, tet[k]); };
        if (tet_volume(corner(0), corner(1), corner(2), corner(3)) < 0.0)
            std::swap(tet[0], tet[1]);
        if (!(tet_volume(corner(0), corner(1), corner(2), corner(3)) > 0.0))
            return std::nullopt;
        const auto angles = dihedral_angles_deg(corner(0), corner(1), corner(2), corner(3));
        return *std::ranges::min_element(angles) >= smallest_deg ? std::optional(tet) : std::nullopt;
    }

    Vec3 centre_of(const LocalMesh& mesh, std::span<const VertexId> corners)
    {
        Vec3 sum = Vec3::Zero();
        for (const VertexId v : corners)
            sum += at(mesh, v) / static_cast<double>(corners.size());
        return sum;
    }

    /// Whether p lies inside the element, not on its surface.
    bool holds(const LocalMesh& mesh, const std::array<VertexId, 4>& tet, const Vec3& p)
    {
        constexpr double kInside = 1e-6; // of the element's volume: more than round-off
        const std::array<Vec3, 4> corners { at(mesh, tet[0]), at(mesh, tet[1]), at(mesh, tet[2]), at(mesh, tet[3]) };
        const double least = kInside * tet_volume(corners[0], corners[1], corners[2], corners[3]);
        for (std::size_t k = 0; k < 4; ++k) {
            std::array<Vec3, 4> with = corners;
            with[k] = p;
            if (!(tet_volume(with[0], with[1], with[2], with[3]) > least))
                return false;
        }
        return true;
    }

    /// The elements round each vertex.
    std::vector<std::vector<std::uint32_t>> stars_of(const LocalMesh& mesh)
    {
        std::vector<std::vector<std::uint32_t>> stars(mesh.vertices.size());
        for (std::size_t t = 0; t < mesh.tets.size(); ++t)
            for (const VertexId v : mesh.tets[t])
                stars[u(v)].push_back(static_cast<std::uint32_t>(t));
        return stars;
    }

    /// Whether an element would lie in others round its corners, or they in it: by its centre, those of its new faces
    /// and of the new edge, and by the other vertices.
    bool overlaps(const LocalMesh& mesh, const std::vector<std::vector<std::uint32_t>>& stars, const Fold& fold,
        const std::array<VertexId, 4>& tet)
    {
        const std::array<Vec3, 4> places { centre_of(mesh, tet), centre_of(mesh, fold.tips),
            centre_of(mesh, std::array { fold.edge[0], fold.tips[0], fold.tips[1] }),
            centre_of(mesh, std::array { fold.edge[1], fold.tips[0], fold.tips[1] }) };
        for (const VertexId v : tet)
            for (const std::uint32_t t : stars[u(v)]) {
                for (const Vec3& place : places)
                    if (holds(mesh, mesh.tets[t], place))
                        return true;
                for (const VertexId w : mesh.tets[t])
                    if (std::ranges::find(tet, w) == tet.end() && holds(mesh, tet, at(mesh, w)))
                        return true;
            }
        return false;
    }

    /// Whether every face of the element is new, or one of the surface that it covers from outside.
    bool fits(const std::vector<Face>& sorted, const std::array<VertexId, 4>& tet)
    {
        for (int corner = 0; corner < 4; ++corner) {
            const std::array<VertexId, 3> corners = face_corners(tet, corner);
            const std::span<const Face> there = faces_of(sorted, key_of(corners));
            if (there.size() > 1)
                return false;
            // Seen from its own element, the face that is covered turns the other way.
            if (there.size() == 1)
                for (std::size_t k = 0; k < 3; ++k)
                    if (there.front().corners[k] == corners[0] && there.front().corners[(k + 1) % 3] == corners[1])
                        return false;
        }
        return true;
    }

    std::size_t close_once(LocalMesh& mesh, const LabelField& field, double smallest_deg)
    {
        const std::vector<Face> sorted = sorted_faces(mesh);
        const std::vector<SurfaceEdge> edges = surface_edges(sorted);
        const auto stars = stars_of(mesh);
        std::vector<bool> taken(mesh.vertices.size(), false); // one element at a vertex: the others see an old surface
        std::size_t added = 0;
        for (const Fold& fold : sharp_folds(mesh, edges, true)) {
            const auto tet = element_in(mesh, fold, smallest_deg);
            if (!tet || std::ranges::any_of(*tet, [&](VertexId v) { return taken[u(v)]; }))
                continue;
            const int label = field.at(centre_of(mesh, *tet));
            if (label == 0 || !fits(sorted, *tet) || overlaps(mesh, stars, fold, *tet))
                continue;
            if (!gets_smoother(mesh, edges, *tet, Change::add))
                continue;
            mesh.tets.push_back(*tet);
            mesh.labels.push_back(static_cast<std::uint8_t>(label));
            for (const VertexId v : *tet)
                taken[u(v)] = true;
            ++added;
        }
        return added;
    }

    double smallest_angle_deg(const LocalMesh& mesh, const std::array<VertexId, 4>& tet)
    {
        const auto angles = dihedral_angles_deg(at(mesh, tet[0]), at(mesh, tet[1]), at(mesh, tet[2]), at(mesh, tet[3]));
        return *std::ranges::min_element(angles);
    }

    /// Elements round an edge that have a face of the surface there.
    std::vector<std::uint32_t> owners(
        const LocalMesh& mesh, const std::vector<std::vector<std::uint32_t>>& stars, const Fold& fold)
    {
        std::vector<std::uint32_t> found;
        for (const std::uint32_t t : stars[u(fold.edge[0])])
            for (const FaceKey& face : fold.faces)
                if (std::ranges::all_of(
                        face, [&](VertexId v) { return std::ranges::find(mesh.tets[t], v) != mesh.tets[t].end(); })
                    && std::ranges::find(found, t) == found.end())
                    found.push_back(t);
        return found;
    }

    std::vector<bool> on_surface(const LocalMesh& mesh, const std::vector<SurfaceEdge>& edges)
    {
        std::vector<bool> on(mesh.vertices.size(), false);
        for (const SurfaceEdge& edge : edges)
            on[u(edge.ends[0])] = on[u(edge.ends[1])] = true;
        return on;
    }

    /// Whether an element has one face on the surface, and its other corner there too: without it the surface would
    /// touch itself at this corner.
    bool is_a_bridge(const std::vector<Face>& sorted, const std::vector<bool>& on, const std::array<VertexId, 4>& tet)
    {
        int faces = 0;
        VertexId opposite = tet[0];
        for (std::size_t corner = 0; corner < tet.size(); ++corner)
            if (faces_of(sorted, key_of(face_corners(tet, static_cast<int>(corner)))).size() == 1) {
                ++faces;
                opposite = tet[corner];
            }
        return faces == 1 && on[u(opposite)];
    }

    std::size_t trim_once(LocalMesh& mesh, const LabelField& field)
    {
        constexpr double kFlatDeg = 20.0; // a fin that is thicker is tissue where the field has tissue
        const std::vector<Face> sorted = sorted_faces(mesh);
        const std::vector<SurfaceEdge> edges = surface_edges(sorted);
        const auto stars = stars_of(mesh);
        const std::vector<bool> on = on_surface(mesh, edges);
        std::vector<bool> taken(mesh.vertices.size(), false), gone(mesh.tets.size(), false);
        std::size_t removed = 0;
        for (const Fold& fold : sharp_folds(mesh, edges, false))
            for (const std::uint32_t t : owners(mesh, stars, fold)) {
                const std::array<VertexId, 4>& tet = mesh.tets[t];
                const bool stays
                    = std::ranges::any_of(tet, [&](VertexId v) { return taken[u(v)] || stars[u(v)].size() < 2; })
                    || (field.at(centre_of(mesh, tet)) != 0 && smallest_angle_deg(mesh, tet) > kFlatDeg)
                    || is_a_bridge(sorted, on, tet) || !gets_smoother(mesh, edges, tet, Change::remove);
                if (stays)
                    continue;
                gone[t] = true;
                for (const VertexId v : tet)
                    taken[u(v)] = true;
                ++removed;
                break;
            }
        std::size_t kept = 0;
        for (std::size_t t = 0; t < mesh.tets.size(); ++t)
            if (!gone[t]) {
                mesh.tets[kept] = mesh.tets[t];
                mesh.labels[kept++] = mesh.labels[t];
            }
        mesh.tets.resize(kept);
        mesh.labels.resize(kept);
        return removed;
    }

} // namespace

std::size_t close_slits(LocalMesh& mesh, const LabelField& field, double smallest_deg, const Job& job)
{
    std::size_t added = 0;
    for (int pass = 0; pass < kMostPasses && !job.cancelled(); ++pass) {
        const std::size_t now = close_once(mesh, field, smallest_deg);
        if (now == 0)
            break;
        added += now;
    }
    return added;
}

std::size_t trim_fins(LocalMesh& mesh, const LabelField& field, const Job& job)
{
    std::size_t removed = 0;
    for (int pass = 0; pass < kMostPasses && !job.cancelled(); ++pass) {
        const std::size_t now = trim_once(mesh, field);
        if (now == 0)
            break;
        removed += now;
    }
    return removed;
}

} // namespace retractor::mesh
