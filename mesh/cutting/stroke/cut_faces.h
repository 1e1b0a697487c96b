#pragma once
// The faces that a stroke will cut, decided once. Later steps (merging vertices, bisecting edges) update the faces by
// id, so that no later decision by geometry can lose a face or exchange its sides.

#include "mesh/cutting/stroke/cut_marks.h"

#include <map>
#include <unordered_map>
#include <vector>

namespace retractor::mesh {

class CutFaces {
public:
    /// Adds the face opposite `corner` of an element on the blade's minus side; the plus side lies beyond the face.
    void insert(const TetSlot& minus, int corner);
    bool empty() const { return faces_.empty(); }
    bool contains(const FaceKey& key) const { return faces_.contains(key); }
    /// True when v is a corner of a face that will be cut.
    bool has(VertexId v) const { return !around(v).empty(); }
    /// The side (-1 or +1) of an element at its face opposite a corner; 0 when the face is not cut.
    int side(const TetSlot& tet, int corner) const;
    /// The cut faces at a vertex.
    const std::vector<FaceKey>& around(VertexId v) const;
    /// All faces by key. The value is +1 when the corners, in the order of the key, turn left seen from the plus side.
    const std::map<FaceKey, int>& all() const { return faces_; }

    /// Replaces vertex a by b; faces with both vertices vanish.
    void merge(VertexId a, VertexId b);
    /// Divides the faces at an edge that vertex m now bisects.
    void bisect(const EdgeKey& edge, VertexId m);

private:
    void add(std::array<VertexId, 3> corners, int turn);
    int remove(const FaceKey& key);

    std::map<FaceKey, int> faces_;
    std::unordered_map<VertexId, std::vector<FaceKey>> around_; // never iterated
};

} // namespace retractor::mesh
