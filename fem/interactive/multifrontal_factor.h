#pragma once
// A body taken apart into a tree of parts (nested dissection), for wounds so large that what they touch is costly as
// one dense system: separators run across the planned cut, never along it where that can be helped, so that what a cut
// touches falls into small fronts. What no cut touches is condensed once, leaf by leaf; the fronts whose rows change,
// and those above them, are factored anew from the stiffness as it is now. Exact, whatever was cut before: nothing adds
// up. Multifrontal Cholesky as in Duff and Reid (1983). Units mm, N; three unknowns per vertex.

#include "fem/interactive/online_stiffness.h"
#include "fem/linear_algebra/dense_algebra.h"
#include "fem/linear_algebra/sparse_cholesky.h"

#include <Eigen/Core>

#include <array>
#include <map>
#include <set>
#include <vector>

namespace retractor::fem {

/// How a body is taken apart. A leaf has vertices that stay closed; all others may change.
struct Dissection {
    struct Part {
        std::int32_t parent = -1; ///< comes before its children
        std::vector<VertexId> closed; ///< of leaves
        std::vector<VertexId> open; ///< of leaves; of a separator all
    };
    std::vector<Part> parts;
    double work = 0.0; ///< multiplications that factoring all that is open takes
};
/// @param fixed per vertex id: 1 where the vertex does not move; shorter: the others are free.
/// @param open living free vertices where cuts are planned. @param part_vertices parts with fewer open vertices, or
/// fewer than three times as many of any, are not divided.
Dissection dissect(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& fixed,
    const std::vector<VertexId>& open, std::size_t part_vertices);
inline constexpr std::size_t kPartVertices
    = 50; ///< measured on a graded chest wall: 100 takes a fifth longer, 30 no less

class MultifrontalFactor {
public:
    /// Condenses the closed vertices. @throws SolverError when the body is not held.
    MultifrontalFactor(const OnlineStiffness& stiffness, const Dissection& dissection);

    bool has(VertexId v) const { return part_of(v) >= 0; } ///< free, as far as this knows
    bool closed(VertexId v) const { return closed_.contains(v); }
    std::vector<VertexId> open_vertices() const; ///< rising, the leaves' alone: what was planned, and what came to it
    std::size_t open_count() const;

    /// The row of this vertex has changed, or the vertex has come or gone. @param before its row until then.
    void touch(VertexId v, const OnlineStiffness::Row& before);
    /// Closed vertices that are not as they were condensed.
    std::vector<VertexId> changed_but_closed(const OnlineStiffness& stiffness) const;
    /// Opens closed vertices: their leaves are condensed again. @pre all that have changed are among them.
    void open(const OnlineStiffness& stiffness, const std::vector<VertexId>& vertices);

    /// Factors what has been touched since the last time. @param active per vertex id: 1 where a free vertex lives now.
    /// @param held those whose displacement is given; they must be open. @return false: not positive definite.
    [[nodiscard]] bool update(
        const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active, const std::set<VertexId>& held);
    double reciprocal_condition() const; ///< of the worst front, from its diagonal: an estimate

    /// Displacements under loads on the free vertices, the held at rest. By vertex id, three rows each, one column per
    /// case. @pre update() was true, and nothing was touched since.
    Eigen::MatrixXd solve(const Eigen::MatrixXd& load) const;

    double factor_entries() const;
    std::size_t bytes() const;

private:
    struct Front {
        std::int32_t parent = -1, depth = 0;
        std::vector<std::int32_t> children;
        std::set<VertexId> members; ///< open, alive or not
        std::vector<VertexId> closed, beside; ///< condensed here, and those they couple to
        SparseCholesky condensing; ///< of closed, then beside
        Eigen::MatrixXd taken; ///< what condensing adds to the stiffness of those beside; lower triangle
        bool dirty = true;
        std::vector<VertexId> own, bound; ///< eliminated here; coupled to these, which lie above
        Eigen::MatrixXd L11, L21, update; ///< lower triangles
    };
    std::int32_t part_of(VertexId v) const
    {
        return v >= 0 && static_cast<std::size_t>(v) < part_.size() ? part_[static_cast<std::size_t>(v)] : -1;
    }
    Front& front_of(VertexId v) { return fronts_[static_cast<std::size_t>(part_of(v))]; }
    void put(VertexId v, std::int32_t part);
    std::int32_t meet(std::int32_t a, std::int32_t b) const;
    bool comparable(std::int32_t a, std::int32_t b) const;
    void condense(const OnlineStiffness& stiffness, Front& front);
    void place_newborn(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active);
    void raise_strangers(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active);
    bool factor(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active, std::int32_t number,
        std::vector<std::int32_t>& place, Cores cores);
    void collect(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active, std::int32_t number,
        std::vector<std::int32_t>& place);
    void share_out();

    std::vector<Front> fronts_; ///< parents first
    std::vector<std::int32_t> part_; ///< per vertex id: its front, or -1
    std::set<VertexId> planned_; ///< came with the dissection: keep their place when they die
    std::map<VertexId, std::int32_t> closed_; ///< and the front they are condensed in
    std::map<VertexId, OnlineStiffness::Row> reference_; ///< of closed vertices that were touched
    std::set<VertexId> touched_, held_;
    std::vector<std::int32_t> above_; ///< fronts, children first; those of `below_` before them
    std::array<std::vector<std::int32_t>, 2> below_;
};

} // namespace retractor::fem
