#pragma once
// The mesh of a cutting session: slots with free lists, and the elements round each vertex. The store records every
// change between begin() and finish(), so that a change can be undone and redone bit for bit. Units mm.

#include "mesh/cutting/store/cut_types.h"
#include "mesh/tetrahedra/tet_grid.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace retractor::mesh {

/// The wound that a face of an element belongs to; a negative `cut` means no wound.
struct LipTag {
    int cut = -1;
    int side = 0;
    bool operator==(const LipTag&) const = default;
};

struct TetSlot {
    std::array<VertexId, 4> nodes {};
    Label label = 0;
    TetId origin = 0; ///< element of the first mesh that contains this element
    std::array<LipTag, 4> lips {}; ///< per face, by the opposite corner
    bool alive = false;
};

struct VertexSlot {
    Vec3 position = Vec3::Zero();
    bool alive = false;
};

template <class Slot> struct SlotChange {
    std::int32_t id = 0;
    Slot before, after;
};

struct SlotCounts {
    std::size_t vertex_slots = 0, tet_slots = 0;
    std::size_t vertices = 0, tets = 0; ///< living vertices and elements
};

/// Slots that may be used again, the last freed slot first.
class FreeList {
public:
    /// All changes since begin(): the first `kept` entries stayed, and the rest was replaced.
    struct Change {
        std::size_t kept = 0;
        std::vector<std::int32_t> before, after;
    };
    bool empty() const { return ids_.empty(); }
    void begin();
    std::int32_t pop();
    void push(std::int32_t id) { ids_.push_back(id); }
    Change change() const;
    void replace_end(std::size_t kept, const std::vector<std::int32_t>& end);
    std::size_t bytes() const;
    /// Joins two successive changes.
    static Change merged(const Change& first, const Change& second);

private:
    std::vector<std::int32_t> ids_;
    std::size_t kept_ = 0;
    std::vector<std::int32_t>
        popped_; ///< entries from before begin() that were popped, the last entry of the list first
};

/// The record of a finished cut. Its size grows with the cut, not with the mesh or with earlier cuts.
struct CutRecord {
    MeshDelta delta;
    std::vector<SlotChange<VertexSlot>> vertices; ///< by id
    std::vector<SlotChange<TetSlot>> tets; ///< by id
    SlotCounts before, after;
    FreeList::Change free_vertices, free_tets;

    std::size_t bytes() const;
};

class CutStore {
public:
    explicit CutStore(const TetMesh& mesh);

    const TetSlot& tet(TetId t) const { return tets_[static_cast<std::size_t>(t)]; }
    const VertexSlot& vertex(VertexId v) const { return vertices_[static_cast<std::size_t>(v)]; }
    const Vec3& position(VertexId v) const { return vertex(v).position; }
    const SlotCounts& counts() const { return counts_; }
    /// True for the id of a living element.
    bool has_tet(TetId t) const { return t >= 0 && static_cast<std::size_t>(t) < tets_.size() && tet(t).alive; }
    bool has_vertex(VertexId v) const
    {
        return v >= 0 && static_cast<std::size_t>(v) < vertices_.size() && vertex(v).alive;
    }
    /// Memory (bytes) without records.
    std::size_t bytes() const;
    /// The element on the other side of a face, or -1 at the surface.
    TetId across(const TetFace& face) const;
    /// Elements round a vertex, ascending.
    std::vector<TetId> star(VertexId v) const;
    /// Elements round a vertex in no particular order; valid until the next change.
    const std::vector<TetId>& unsorted_star(VertexId v) const { return stars_[static_cast<std::size_t>(v)]; }
    /// Elements round an edge, ascending.
    std::vector<TetId> star(VertexId a, VertexId b) const;
    double volume(TetId t) const; ///< mm^3
    /// The mean edge (mm) of the element of the first mesh that contains t: the local edge length of the guarantees.
    double first_edge(TetId t) const { return first_edge_[static_cast<std::size_t>(tet(t).origin)]; }
    /// Local index of v among the nodes of t, or -1.
    int corner(TetId t, VertexId v) const;

    /// Living elements whose boxes meet the box, ascending.
    std::vector<TetId> tets_near(const Eigen::AlignedBox3d& box) const;
    /// Replaces `tets` by the same elements in no particular order; an element may occur several times.
    void gather_near(const Eigen::AlignedBox3d& box, std::vector<TetId>& tets) const;

    /// Elements round any of the vertices, each once, in no particular order.
    template <class Vertices> std::vector<TetId> tets_round(const Vertices& vertices)
    {
        std::vector<TetId> tets;
        begin_walk(tet_walk_, tets_.size());
        for (const VertexId v : vertices)
            for (const TetId t : unsorted_star(v))
                if (first_visit(tet_walk_, t))
                    tets.push_back(t);
        return tets;
    }
    /// Corners of any of the elements, each once, in no particular order.
    std::vector<VertexId> corners_of_all(std::span<const TetId> tets);

    /// Lends a table with one entry per vertex, or an empty table when the table is lent already. The contents are
    /// arbitrary, and the table may be too short.
    std::vector<std::uint32_t> lend_table() { return std::exchange(lent_table_, {}); }
    void give_back(std::vector<std::uint32_t> table) { lent_table_ = std::move(table); }

    /// Number of changes since the store was made, without changes by undo() and redo().
    std::uint64_t changes() const { return changes_; }

    /// Starts to record changes.
    void begin();
    /// Adds a vertex on the edge a-b. Slots that were freed since begin() are reused only after finish(), so that no id
    /// is removed and added in one delta.
    VertexId add_vertex(const Vec3& position, VertexId a, VertexId b, double t);
    /// Adds a vertex at the position of v, with MeshDelta::Origin::copy.
    VertexId copy_vertex(VertexId v);
    void move_vertex(VertexId v, const Vec3& to);
    /// @pre no element uses the vertex, and the vertex existed before begin()
    void remove_vertex(VertexId v);
    TetId add_tet(const TetSlot& tet);
    void remove_tet(TetId t);
    void set_lips(TetId t, const std::array<LipTag, 4>& lips);
    /// Bisects an edge, with every element round the edge, at `position`. The halves inherit label, origin and lips.
    VertexId bisect(VertexId a, VertexId b, const Vec3& position, double t);
    /// Living elements that were added or changed since begin(), each once, in no particular order.
    std::vector<TetId> changed_tets() const;
    /// True for a vertex that was added since begin().
    bool is_added(VertexId v) const { return vertex_birth_epoch_[static_cast<std::size_t>(v)] == epoch_; }
    /// Prepares to drop v, which was added since begin(), in favour of the nearby vertex w. In the record, vertices on
    /// edges that ended at v now lie on edges that end at w. If w was added after v, then w takes v's place in the
    /// order of additions.
    void replace_parent(VertexId v, VertexId w);
    /// Removes a vertex that was added since begin(), without a trace in the record.
    /// @pre no element uses the vertex, and replace_parent() has been called
    void drop_added(VertexId v);
    /// Ends the recording and returns all changes since begin().
    CutRecord finish();
    /// Takes back all changes since begin().
    void rollback();

    /// Joins two successive records.
    CutRecord merged(const CutRecord& first, const CutRecord& second) const;

    void undo(const CutRecord& record);
    void redo(const CutRecord& record);

private:
    VertexId add_vertex(const MeshDelta::VertexBorn& born); ///< gives the vertex its id
    TetSlot& touch_tet(TetId t);
    VertexSlot& touch_vertex(VertexId v);
    void attach(TetId t);
    void detach(TetId t);
    void resize(std::size_t vertex_slots, std::size_t tet_slots);
    void list(TetId t);
    Eigen::AlignedBox3d box_of(TetId t) const;
    /// A walk over slots: slots with the number of the walk have been visited.
    struct Walk {
        std::uint32_t number = 0;
        std::vector<std::uint32_t> visited {};
    };
    static void begin_walk(Walk& walk, std::size_t slots);
    static bool first_visit(Walk& walk, std::int32_t id)
    {
        std::uint32_t& visited = walk.visited[static_cast<std::size_t>(id)];
        return std::exchange(visited, walk.number) != walk.number;
    }
    void gather_changes(CutRecord& record) const;
    void apply(const CutRecord& record, bool forward);

    std::vector<TetSlot> tets_;
    std::vector<VertexSlot> vertices_;
    std::vector<std::vector<TetId>> stars_; ///< unordered
    std::vector<float> first_edge_; ///< mean edge (mm) of each element of the first mesh
    SlotCounts counts_;
    FreeList free_vertices_, free_tets_;
    TetGrid grid_; ///< living elements
    Walk tet_walk_, vertex_walk_;
    std::vector<std::uint32_t> lent_table_;

    // Changes since begin():
    std::uint64_t changes_ = 0;
    std::uint32_t epoch_ = 0;
    std::vector<std::uint32_t> tet_epoch_, vertex_epoch_; ///< epoch of the first change of each slot
    std::vector<std::uint32_t> birth_epoch_, vertex_birth_epoch_;
    std::vector<SlotChange<TetSlot>> touched_tets_;
    std::vector<SlotChange<VertexSlot>> touched_vertices_;
    std::vector<MeshDelta::VertexBorn> born_;
    std::vector<MeshDelta::VertexMoved> moved_;
    std::vector<MeshDelta::VertexBorn> gone_;
    std::vector<TetId> freed_tets_;
    std::vector<VertexId> freed_vertices_;
    SlotCounts before_;
};

} // namespace retractor::mesh
