#include "mesh/cutting/pieces.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <algorithm>
#include <map>

namespace retractor::mesh {

namespace {

    void measure(const TetMesh& mesh, const std::vector<TetId>& tets, Piece& piece)
    {
        RETRACTOR_ASSERT(!tets.empty());
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

} // namespace

std::vector<Piece> find_pieces(const CutSession& session)
{
    SlotMap map;
    const TetMesh mesh = session.compact_mesh(&map);
    const std::vector<int> number = connected_pieces(mesh);
    RETRACTOR_ASSERT(number.size() == map.tet_slot.size());
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

std::vector<TetId> mark_ball(
    const CutSession& session, const Vec3& centre, double radius_mm, std::span<const Label> labels)
{
    if (!centre.allFinite())
        throw InputError("must be a finite point", "centre_mm");
    if (!(radius_mm > 0.0))
        throw InputError("must be positive", "radius_mm");
    std::vector<TetId> marked;
    for (TetId t = 0; t < static_cast<TetId>(session.tet_slots()); ++t) {
        if (!session.has_tet(t))
            continue;
        const MeshDelta::Tet tet = session.tet(t);
        if (!labels.empty() && std::find(labels.begin(), labels.end(), tet.label) == labels.end())
            continue;
        Vec3 sum = Vec3::Zero();
        for (const VertexId v : tet.nodes)
            sum += session.position(v);
        if ((0.25 * sum - centre).squaredNorm() < radius_mm * radius_mm)
            marked.push_back(t);
    }
    return marked;
}

} // namespace retractor::mesh
