#pragma once
// Where vertices, edges and elements lie with respect to a blade. What is decided once is remembered, and all
// combinatorics asks the remembered signs only, never the numbers: so every stage of a stroke gives the same answers.
// The tolerance kOnBlade chooses what is on the blade; beyond it the sign of the double-precision distance is that of
// the exact orientation with respect to the nearest triangle (the tolerance is a hundred thousand times the round-off
// of the distance; blade_predicates_test.cpp compares both with CGAL's exact predicate on straight, kinked, twisted and
// round blades, at creases, ends and front). Units mm.

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

FaceKey face_key(const TetSlot& tet, int corner);

/// Longest edges first, each once: their halves make the better elements.
void sort_longest_first(std::vector<EdgeKey>& edges, const CutStore& store);

/// A point nearer to the blade (or to its border) than this share of the blade's size is on it.
inline constexpr double kOnBlade = 1e-8;
/// A stroke that would leave elements without volume is tried again with a larger share, but none above this.
inline constexpr double kMostOnBlade = 8e-8;

/// -1, 0 (within the tolerance) or 1.
int sign(double x, double tolerance);

/// The borders of a blade: where its line starts and ends, and how deep it reaches.
inline constexpr std::size_t kStart = 0, kEnd = 1, kFront = 2;

struct Mark {
    int side = 0;
    std::array<int, 3> beyond {}; ///< per border: +1 outside the blade, -1 inside
    std::array<double, 3> distance {}; ///< the same in mm
    double height = 0.0; ///< signed distance (mm) from the blade
};

struct Crossing {
    bool real = false; ///< the sign changes because the edge meets the blade
    double t = 0.0;
    Vec3 point = Vec3::Zero();
    std::array<double, 3> distance {}; ///< as in Mark
};

class BladeMarks {
public:
    /// @param store is not changed; it lends a table.
    BladeMarks(CutStore& store, const SweptBlade& blade, double on_blade = kOnBlade);
    ~BladeMarks();
    BladeMarks(const BladeMarks&) = delete;
    BladeMarks& operator=(const BladeMarks&) = delete;

    const Mark& at(VertexId v)
    {
        const Entry* entry = find(v);
        return entry != nullptr ? entry->mark : look_at(v);
    }
    const Crossing& crossing(const EdgeKey& edge);
    /// The side of an element: that of its vertices off the blade, or of its centroid where they do not tell
    /// (all four on the blade, at a kink; or an element beyond the border, which nothing needs to cut).
    int side(const TetSlot& tet);
    struct Edges {
        std::array<EdgeKey, 6> keys;
        std::size_t count = 0;
        const EdgeKey* begin() const { return keys.data(); }
        const EdgeKey* end() const { return keys.data() + count; }
    };
    Edges crossed_edges(const TetSlot& tet);
    /// Does the blade, within its borders, run through the element? The corners of the section (where the blade
    /// meets edges and vertices) must reach inside each border. At a corner of the blade this is on the safe side.
    /// With `completely`, no corner may lie beyond the end either.
    bool crossed(const TetSlot& tet, bool completely = false);

    /// The vertex has been put on the blade: whatever round-off says, its side is 0.
    void put_on_blade(VertexId v);
    /// The vertex is on a border: neither outside nor inside of it.
    void put_on_border(VertexId v, std::size_t border);
    /// The vertex has moved or is gone: what was known of it and of the edges to `neighbours` is forgotten.
    void forget(VertexId v, std::span<const VertexId> neighbours);
    /// The edge is gone: its crossing would outlive moves of its ends.
    void forget(const EdgeKey& edge);
    const std::set<VertexId>& on_blade() const { return on_blade_; }
    /// Counts what changes the vertices on the blade or what is known of them, but for those that looking finds.
    std::uint64_t changes() const { return changes_; }
    /// Vertices that were on the blade when they were first looked at; some may have been forgotten since.
    const std::vector<VertexId>& found_on_blade() const { return found_; }
    /// Signed distances (mm) beyond the borders.
    std::array<double, 3> beyond(const BladeCoordinates& c) const;
    double tolerance() const { return share_ * size_; }

private:
    struct Entry {
        VertexId vertex = -1; ///< -1: forgotten
        Mark mark;
    };
    static constexpr std::size_t kChunk = 64;
    using Chunk = std::array<Entry, kChunk>;

    /// What a vertex's place in the table names is its entry only when that names the vertex: so the table need not be
    /// cleared, and looking up costs a few instructions (Briggs and Torczon 1993, doi 10.1145/176454.176484).
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
    std::vector<std::uint32_t> table_; ///< by vertex: its entry
    std::vector<std::unique_ptr<Chunk>> chunks_; ///< of entries, which stay where they are
    std::uint32_t count_ = 0; ///< of entries
    OpenAddressMap<Crossing> crossings_; ///< by edge
    std::set<VertexId> on_blade_;
    std::vector<VertexId> found_;
    std::uint64_t changes_ = 0;
};

/// Root in (0, 1) of a continuous f with f(0) f(1) < 0: regula falsi (Illinois), with bisection when it stalls. Stops
/// where |f| <= tolerance.
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
