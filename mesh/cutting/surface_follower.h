#pragma once
// The surface of a body that is being cut (skin, inner side, lips of wounds), kept up to date from the cutting
// session's deltas: what a delta did not touch is not looked at, so the cost follows the cut. Units mm; frame patient
// LPS (the rest configuration).

#include "mesh/cutting/store/cut_types.h"

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace retractor::mesh {

/// A face with tissue on one side only; ids of the session.
struct SurfaceFace {
    TetFace face;
    std::array<VertexId, 3> vertices {}; ///< counter-clockwise seen from outside
    Label label = 0;
};

class SurfaceFollower {
public:
    /// @param mesh as the session was given it: its ids are the session's.
    /// @throws InputError when a face belongs to more than two elements.
    explicit SurfaceFollower(const TetMesh& mesh);

    /// Every delta of the session, each once and in order: of cut(), extend_stroke(), finish_stroke(),
    /// abandon_stroke(), ablate(), undo() and redo().
    /// @throws InputError when the delta does not fit; then the follower must not be used any more.
    void follow(const MeshDelta& delta);

    /// In places that stay while their face does; the order is the same on every run.
    const std::vector<SurfaceFace>& faces() const { return faces_; }
    /// The places of faces() that the last delta filled anew, ascending: what a view has to send again, beside the
    /// positions of born and moved vertices.
    const std::vector<std::size_t>& changed() const { return changed_; }
    /// Rest position (mm) of a living vertex, by id.
    const Vec3& position(VertexId v) const { return positions_[static_cast<std::size_t>(v)]; }

private:
    using Key = std::array<VertexId, 3>; ///< sorted
    struct KeyHash {
        std::size_t operator()(const Key& key) const;
    };
    /// A face of an element, as 4 * element + corner.
    using Half = std::int64_t;

    Half& mate(Half half) { return mates_[static_cast<std::size_t>(half)]; }
    Key key(Half half) const;
    void pair_all();
    void take(const MeshDelta::Tet& tet);
    void put(const MeshDelta::Tet& tet);
    void show(Half half);
    void hide(const Key& key);

    std::vector<Vec3> positions_;
    std::vector<std::array<VertexId, 4>> nodes_; ///< by element; -1 where there is none
    std::vector<Label> labels_;
    std::vector<Half> mates_; ///< of each face: the face of the neighbour, or kSurface, or kOpen
    std::vector<SurfaceFace> faces_;
    std::unordered_map<Key, std::size_t, KeyHash> place_; ///< in faces_; looked up only, never walked
    std::unordered_map<Key, Half, KeyHash> open_; ///< while a delta is followed: faces that lost their neighbour
    std::vector<std::size_t> changed_;
};

} // namespace retractor::mesh
