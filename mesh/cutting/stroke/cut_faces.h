#pragma once
// The faces that a stroke will cut, decided once: what comes after (merging vertices, bisecting edges) carries them
// along by name, so that no later look at the geometry can lose one or tell its sides differently.

#include "mesh/cutting/stroke/cut_marks.h"

#include <cstddef>
#include <map>
#include <unordered_map>
#include <vector>

namespace retractor::mesh {

class CutFaces {
public:
    /// The face of an element on the blade's minus side; beyond it lies the plus side.
    void insert(const TetSlot& minus, int corner);
    bool empty() const { return faces_.empty(); }
    bool contains(const FaceKey& key) const { return faces_.contains(key); }
    /// Is v a corner of a face that will be cut?
    bool has(VertexId v) const { return !around(v).empty(); }
    /// On which side (-1, +1) of its face opposite to a corner an element lies; 0 when that face is not cut.
    int side(const TetSlot& tet, int corner) const;
    /// The cut faces at a vertex.
    const std::vector<FaceKey>& around(VertexId v) const;
    /// All, by key, with +1 where the corners in that order turn left seen from the plus side.
    const std::map<FaceKey, int>& all() const { return faces_; }

    /// Vertex a becomes b; faces with both vanish.
    void merge(VertexId a, VertexId b);
    /// The vertex m now divides the edge.
    void bisect(const EdgeKey& edge, VertexId m);

private:
    void add(std::array<VertexId, 3> corners, int turn);
    int remove(const FaceKey& key);

    std::map<FaceKey, int> faces_;
    std::unordered_map<VertexId, std::vector<FaceKey>> around_; // looked up only, never walked
};

} // namespace retractor::mesh
