#include "mesh/cutting/stroke/cut_faces.h"

#include "mesh/base/assert.h"

#include <algorithm>

namespace retractor::mesh {

namespace {
    /// Sorts three corners; returns -1 after an odd permutation, else 1.
    int sort_corners(FaceKey& v)
    {
        int turn = 1;
        const auto order = [&](std::size_t i, std::size_t j) {
            if (v[i] > v[j]) {
                std::swap(v[i], v[j]);
                turn = -turn;
            }
        };
        order(0, 1);
        order(1, 2);
        order(0, 1);
        return turn;
    }
} // namespace

void CutFaces::add(std::array<VertexId, 3> corners, int turn)
{
    turn *= sort_corners(corners);
    if (!faces_.emplace(corners, turn).second)
        return;
    for (const VertexId v : corners)
        around_[v].push_back(corners);
}

int CutFaces::remove(const FaceKey& key)
{
    const auto it = faces_.find(key);
    RETRACTOR_ASSERT(it != faces_.end());
    const int turn = it->second;
    for (const VertexId v : key)
        std::erase(around_[v], key);
    faces_.erase(it);
    return turn;
}

void CutFaces::insert(const TetSlot& minus, int corner) { add(face_corners(minus.nodes, corner), 1); }

int CutFaces::side(const TetSlot& tet, int corner) const
{
    FaceKey key = face_corners(tet.nodes, corner);
    const int turn = sort_corners(key);
    const auto it = faces_.find(key);
    return it == faces_.end() ? 0 : -turn * it->second;
}

const std::vector<FaceKey>& CutFaces::around(VertexId v) const
{
    static const std::vector<FaceKey> none;
    const auto it = around_.find(v);
    return it == around_.end() ? none : it->second;
}

void CutFaces::merge(VertexId a, VertexId b)
{
    RETRACTOR_ASSERT(a != b);
    for (const FaceKey& key : std::vector<FaceKey>(around(a))) {
        const int turn = remove(key);
        if (std::find(key.begin(), key.end(), b) != key.end())
            continue;
        FaceKey corners = key;
        std::replace(corners.begin(), corners.end(), a, b);
        add(corners, turn);
    }
}

void CutFaces::bisect(const EdgeKey& edge, VertexId m)
{
    RETRACTOR_ASSERT(edge.first != edge.second && !has(m));
    for (const FaceKey& key : std::vector<FaceKey>(around(edge.first))) {
        if (std::find(key.begin(), key.end(), edge.second) == key.end())
            continue;
        const int turn = remove(key);
        for (const VertexId end : { edge.first, edge.second }) {
            FaceKey corners = key;
            std::replace(corners.begin(), corners.end(), end, m);
            add(corners, turn);
        }
    }
}

} // namespace retractor::mesh
