#pragma once
// Keeps the surface of a body (skin, inner side, lips of wounds) up to date from the deltas of a cutting session. The
// follower looks only at the parts that a delta touched, so that the cost grows with the cut. Units mm; frame patient
// LPS (the rest configuration).

#include "mesh/cutting/store/cut_types.h"

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace retractor::mesh {

/// A face with tissue on one side only. Ids are ids of the session.
struct SurfaceFace {
    TetFace face;
    std::array<VertexId, 3> vertices {}; ///< counter-clockwise seen from outside
    Label label = 0;
};

class SurfaceFollower {
public:
    /// @param mesh the first mesh of the session, whose ids are the session's ids
    /// @throws InputError when a face belongs to more than two elements
    explicit SurfaceFollower(const TetMesh& mesh);

    /// Takes the next delta of the session: of cut(), extend_stroke(), finish_stroke(), abandon_stroke(), ablate(),
    /// undo() or redo().
    /// @pre called once for every delta, in order
    /// @throws InputError when the delta does not fit; the follower must not be used afterwards
    void follow(const MeshDelta& delta);

    /// The faces of the surface. A face keeps its place as long as it exists; the order is the same on every run.
    const std::vector<SurfaceFace>& faces() const { return faces_; }
    /// The places in faces() that the last delta filled anew, ascending. A view has to send these faces again, with the
    /// positions of added and moved vertices.
    const std::vector<std::size_t>& changed() const { return changed_; }
    /// Rest position (mm) of a living vertex, by id.
    const Vec3& position(VertexId v) const { return positions_[static_cast<std::size_t>(v)]; }

private:
    using Key = std::array<VertexId, 3>; ///< sorted
    struct KeyHash {
        std::size_t operator()(const Key& key) const;
    };
    /// A face of an element, numbered 4 * element + corner.
    using Half = std::int64_t;

    Half& mate(Half half) { return mates_[static_cast<std::size_t>(half)]; }
    Key key(Half half) const;
    void pair_all();
    void take(const MeshDelta::Tet& tet);
    void put(const MeshDelta::Tet& tet);
    void show(Half half);
    void hide(const Key& key);

    std::vector<Vec3> positions_;
    std::vector<std::array<VertexId, 4>> nodes_; ///< per element; -1 for a missing element
    std::vector<Label> labels_;
    std::vector<Half> mates_; ///< per face: the same face of the neighbour, or kSurface, or kOpen
    std::vector<SurfaceFace> faces_;
    std::unordered_map<Key, std::size_t, KeyHash> place_; ///< places in faces_; never iterated
    std::unordered_map<Key, Half, KeyHash> open_; ///< faces that lost their neighbour in the current delta
    std::vector<std::size_t> changed_;
};

} // namespace retractor::mesh
