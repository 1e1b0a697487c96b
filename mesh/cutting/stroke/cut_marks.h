#pragma once
// Marks the position of vertices, edges and elements with respect to a blade. A sign is decided once and remembered.
// All combinatorics uses the remembered signs and never the numbers, so that every stage of a stroke gives the same
// answers. The tolerance kOnBlade decides whether a point is on the blade. Beyond the tolerance, the sign of the
// double-precision distance is that of the exact orientation with respect to the nearest triangle, because the
// tolerance is a hundred thousand times the round-off of the distance. blade_predicates_test.cpp compares the signs
// with CGAL's exact predicate on straight, kinked, twisted and round blades, at creases, ends and front. Units mm.

#include "mesh/base/open_address_map.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/cutting/store/cut_store.h"

#include <array>
#include <cstdint>
#include <memory>
#include <set>
#include <span>
#include <utility>
#include <vector>

namespace retractor::mesh {

using FaceKey = std::array<VertexId, 3>; ///< sorted
using EdgeKey = std::pair<VertexId, VertexId>; ///< sorted

/// Key of the face opposite a corner.
FaceKey face_key(const TetSlot& tet, int corner);

/// Sorts edges by falling length and removes duplicates. Halving long edges first gives better elements.
void sort_longest_first(std::vector<EdgeKey>& edges, const CutStore& store);

/// A point nearer to the blade (or to its border) than this share of the blade's size counts as on the blade (or on the
/// border).
inline constexpr double kOnBlade = 1e-8;
/// Largest share in further attempts at a stroke that would leave elements without volume.
inline constexpr double kMostOnBlade = 8e-8;

/// The sign of x: -1, 0 (within the tolerance) or 1.
int sign(double x, double tolerance);

/// The borders of a blade: the start and the end of its line, and its front in depth.
inline constexpr std::size_t kStart = 0, kEnd = 1, kFront = 2;

struct Mark {
    int side = 0; ///< -1, 0 (on the blade) or 1
    std::array<int, 3> beyond {}; ///< per border: +1 outside the blade, -1 inside
    std::array<double, 3> distance {}; ///< per border: signed distance beyond the border (mm)
    double height = 0.0; ///< signed distance (mm) from the blade
};

struct Crossing {
    bool real = false; ///< true when the sign changes because the edge meets the blade
    double t = 0.0; ///< place on the edge, 0 to 1
    Vec3 point = Vec3::Zero();
    std::array<double, 3> distance {}; ///< as Mark::distance
};

class BladeMarks {
public:
    /// @param store is not changed; lends a table
    BladeMarks(CutStore& store, const SweptBlade& blade, double on_blade = kOnBlade);
    ~BladeMarks();
    BladeMarks(const BladeMarks&) = delete;
    BladeMarks& operator=(const BladeMarks&) = delete;

    /// The mark of a vertex, computed on first use.
    const Mark& at(VertexId v)
    {
        const Entry* entry = find(v);
        return entry != nullptr ? entry->mark : look_at(v);
    }
    /// The crossing of an edge with the blade, computed on first use.
    const Crossing& crossing(const EdgeKey& edge);
    /// The side of an element: the common side of its vertices off the blade. The centroid decides when all four
    /// vertices are on the blade (at a kink), or when the vertices are on both sides (an element beyond the border,
    /// which needs no cut).
    int side(const TetSlot& tet);
    struct Edges {
        std::array<EdgeKey, 6> keys;
        std::size_t count = 0;
        const EdgeKey* begin() const { return keys.data(); }
        const EdgeKey* end() const { return keys.data() + count; }
    };
    Edges crossed_edges(const TetSlot& tet);
    /// True when the blade, within its borders, runs through the element. The corners of the section (where the blade
    /// meets edges and vertices) must reach inside each border. At a corner of the blade the answer errs on the safe
    /// side.
    /// @param completely also requires that no corner of the section lies beyond the blade's end
    bool crossed(const TetSlot& tet, bool completely = false);

    /// Sets the side of a vertex to 0 after the vertex has been put on the blade, regardless of round-off.
    void put_on_blade(VertexId v);
    /// Marks a vertex as on a border, neither outside nor inside.
    void put_on_border(VertexId v, std::size_t border);
    /// Forgets the mark of a vertex that has moved or is gone, and the crossings of its edges to `neighbours`.
    void forget(VertexId v, std::span<const VertexId> neighbours);
    /// Forgets the crossing of an edge that is gone, because moves of its ends would no longer clear the crossing.
    void forget(const EdgeKey& edge);
    /// The vertices on the blade.
    const std::set<VertexId>& on_blade() const { return on_blade_; }
    /// Number of changes of the vertices on the blade or of their marks, without first marks.
    std::uint64_t changes() const { return changes_; }
    /// Vertices whose first mark was on the blade; some may have been forgotten since.
    const std::vector<VertexId>& found_on_blade() const { return found_; }
    /// Signed distances (mm) of a point beyond the borders.
    std::array<double, 3> beyond(const BladeCoordinates& c) const;
    /// Distance (mm) below which a point counts as on the blade.
    double tolerance() const { return share_ * size_; }

private:
    struct Entry {
        VertexId vertex = -1; ///< -1: forgotten
        Mark mark;
    };
    static constexpr std::size_t kChunk = 64;
    using Chunk = std::array<Entry, kChunk>;

    /// Finds the entry of a vertex, or null. The table gives the index of a candidate, which is the entry only when it
    /// names the vertex. The table therefore needs no clearing, and a look-up costs a few instructions (Briggs and
    /// Torczon 1993, doi 10.1145/176454.176484).
    Entry* find(VertexId v)
    {
        const auto i = static_cast<std::size_t>(v);
        if (i >= table_.size() || table_[i] >= count_)
            return nullptr;
        Entry& entry = (*chunks_[table_[i] / kChunk])[table_[i] % kChunk];
        return entry.vertex == v ? &entry : nullptr;
    }
    Mark& add(VertexId v);
    const Mark& look_at(VertexId v);
    Mark measure(const Vec3& p) const;

    CutStore& store_;
    const SweptBlade& blade_;
    double size_, share_;
    std::vector<std::uint32_t> table_; ///< per vertex: index of its entry
    std::vector<std::unique_ptr<Chunk>> chunks_; ///< the entries, which never move in memory
    std::uint32_t count_ = 0; ///< number of entries
    OpenAddressMap<Crossing> crossings_; ///< crossings by edge
    std::set<VertexId> on_blade_;
    std::vector<VertexId> found_;
    std::uint64_t changes_ = 0;
};

/// Root in (0, 1) of a continuous f with f(0) f(1) < 0, by regula falsi (Illinois variant), with a bisection when the
/// iteration stalls. The iteration stops when |f| <= tolerance.
/// @param f0, f1 values of f at 0 and 1
template <class F> double find_root(F&& f, double f0, double f1, double tolerance)
{
    constexpr int kRootIterations = 100;
    double a = 0.0, b = 1.0, best = 0.5, f_best = f0 < 0.0 ? -f0 : f0;
    int same_end = 0;
    for (int i = 0; i < kRootIterations; ++i) {
        double t = (a * f1 - b * f0) / (f1 - f0);
        if (i % 8 == 7 || !(t > a && t < b))
            t = 0.5 * (a + b);
        if (t <= a || t >= b)
            break;
        const double ft = f(t), size = ft < 0.0 ? -ft : ft;
        if (i == 0 || size < f_best) {
            best = t;
            f_best = size;
        }
        if (f_best <= tolerance)
            break;
        if ((ft > 0.0) == (f1 > 0.0)) {
            b = t;
            f1 = ft;
            if (same_end == 1)
                f0 *= 0.5;
            same_end = 1;
        } else {
            a = t;
            f0 = ft;
            if (same_end == -1)
                f1 *= 0.5;
            same_end = -1;
        }
    }
    return best;
}

} // namespace retractor::mesh
