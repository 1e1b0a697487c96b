#include "mesh/cutting/pieces.h"

#include "mesh/base/error.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <algorithm>
#include <array>
#include <map>

namespace retractor::mesh {

namespace {

    std::array<Vec3, 4> corners(const CutSession& session, const MeshDelta::Tet& tet)
    {
        std::array<Vec3, 4> p;
        for (std::size_t i = 0; i < 4; ++i)
            p[i] = session.position(tet.nodes[i]);
        return p;
    }

    template <class Inside>
    std::vector<TetId> mark(const CutSession& session, std::span<const Label> labels, Inside&& inside)
    {
        std::vector<TetId> marked;
        for (TetId t = 0; t < static_cast<TetId>(session.tet_slots()); ++t) {
            if (!session.has_tet(t))
                continue;
            const MeshDelta::Tet tet = session.tet(t);
            if (!labels.empty() && std::find(labels.begin(), labels.end(), tet.label) == labels.end())
                continue;
            const auto p = corners(session, tet);
            if (inside(Vec3(0.25 * (p[0] + p[1] + p[2] + p[3]))))
                marked.push_back(t);
        }
        return marked;
    }

    void measure(const TetMesh& mesh, const std::vector<TetId>& tets, Piece& piece)
    {
        std::map<Label, double> volume;
        for (const TetId t : tets) {
            const double v = tet_volume(mesh, t);
            piece.volume_mm3 += v;
            volume[mesh.labels[static_cast<std::size_t>(t)]] += v;
            for (const VertexId n : mesh.tet(t))
                piece.centroid += 0.25 * v * mesh.vertices.row(n).transpose();
        }
        piece.centroid /= piece.volume_mm3;
        piece.labels.assign(volume.begin(), volume.end());
        std::stable_sort(
            piece.labels.begin(), piece.labels.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
    }

    bool holds(const std::array<Vec3, 4>& p, const Vec3& point)
    {
        for (std::size_t i = 0; i < 4; ++i) {
            std::array<Vec3, 4> q = p;
            q[i] = point;
            if (tet_volume(q[0], q[1], q[2], q[3]) < 0.0)
                return false;
        }
        return true;
    }

    /// Which side of `blade` the middle of the other blade lies on.
    double side_of_middle(const SweptBlade& blade, const SweptBlade& other)
    {
        const double side = blade.coordinates(other.at(0.5 * other.length(), 0.5 * other.depth())).side;
        if (side == 0.0)
            throw InputError("the middle of one blade lies on the other: nothing is between them");
        return side;
    }

} // namespace

std::vector<Piece> find_pieces(const CutSession& session)
{
    SlotMap map;
    const TetMesh mesh = session.compact_mesh(&map);
    const std::vector<int> number = connected_pieces(mesh);
    std::vector<std::vector<TetId>> tets;
    for (TetId t = 0; t < static_cast<TetId>(number.size()); ++t) {
        const auto n = static_cast<std::size_t>(number[static_cast<std::size_t>(t)]);
        tets.resize(std::max(tets.size(), n + 1));
        tets[n].push_back(t);
    }
    std::vector<Piece> pieces(tets.size());
    for (std::size_t i = 0; i < tets.size(); ++i) {
        measure(mesh, tets[i], pieces[i]);
        for (const TetId t : tets[i])
            pieces[i].tets.push_back(map.tet_slot[static_cast<std::size_t>(t)]);
    }
    return pieces;
}

std::size_t piece_at(const CutSession& session, std::span<const Piece> pieces, const Vec3& point)
{
    for (std::size_t i = 0; i < pieces.size(); ++i)
        for (const TetId t : pieces[i].tets)
            if (holds(corners(session, session.tet(t)), point))
                return i;
    throw InputError("there is no tissue at this point");
}

std::vector<TetId> mark_ball(
    const CutSession& session, const Vec3& centre, double radius_mm, std::span<const Label> labels)
{
    if (!centre.allFinite())
        throw InputError("must be a finite point", "centre_mm");
    if (!(radius_mm > 0.0))
        throw InputError("must be positive", "radius_mm");
    return mark(session, labels, [&](const Vec3& p) { return (p - centre).squaredNorm() < radius_mm * radius_mm; });
}

std::vector<TetId> mark_box(const CutSession& session, const Eigen::AlignedBox3d& box, std::span<const Label> labels)
{
    if (!box.min().allFinite() || !box.max().allFinite() || box.isEmpty())
        throw InputError("the box is empty or not finite");
    return mark(session, labels, [&](const Vec3& p) { return box.contains(p); });
}

std::vector<TetId> mark_between(
    const CutSession& session, const SweptBlade& a, const SweptBlade& b, std::span<const Label> labels)
{
    const double side_of_b = side_of_middle(a, b), side_of_a = side_of_middle(b, a);
    return mark(session, labels, [&](const Vec3& p) {
        return a.coordinates(p).side * side_of_b > 0.0 && b.coordinates(p).side * side_of_a > 0.0;
    });
}

} // namespace retractor::mesh
