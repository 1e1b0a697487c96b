#pragma once
// A multifrontal Cholesky factor of a body (Duff, Reid 1983, doi 10.1145/356044.356047), for wounds so large that one
// dense system on the touched vertices is costly. Nested dissection divides the body into a tree of parts. Separators
// run across the planned cut, and along the cut only where necessary, so that a cut touches small fronts. Vertices that
// no cut touches (closed) are condensed once, leaf by leaf. The fronts whose rows change, and the fronts above, are
// factored anew from the present stiffness. The factor is exact after any sequence of cuts; no error adds up. Units mm,
// N; three unknowns per vertex.

#include "fem/interactive/online_stiffness.h"
#include "fem/linear_algebra/dense_algebra.h"
#include "fem/linear_algebra/sparse_cholesky.h"

#include <Eigen/Core>

#include <array>
#include <map>
#include <set>
#include <vector>

namespace retractor::fem {

/// The division of a body. Leaves have closed vertices, which must not change; all other vertices are open and may
/// change.
struct Dissection {
    struct Part {
        std::int32_t parent = -1; ///< the parent comes before its children; -1: root
        std::vector<VertexId> closed; ///< of leaves only
        std::vector<VertexId> open; ///< open vertices of a leaf; all vertices of a separator
    };
    std::vector<Part> parts;
    double work = 0.0; ///< multiplications of a factorisation of all open vertices
};
/// Divides a body.
/// @param fixed per vertex id: 1 where the vertex does not move; ids beyond the end are free
/// @param open living free vertices where cuts are planned
/// @param part_vertices parts with fewer open vertices, or fewer than three times as many vertices in all, are not
/// divided
Dissection dissect(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& fixed,
    const std::vector<VertexId>& open, std::size_t part_vertices);
/// Measured on a graded chest wall: 100 takes a fifth longer, 30 saves no time.
inline constexpr std::size_t kPartVertices = 50;

class MultifrontalFactor {
public:
    /// Condenses the closed vertices. @throws SolverError when the body is not supported
    MultifrontalFactor(const OnlineStiffness& stiffness, const Dissection& dissection);

    bool has(VertexId v) const { return part_of(v) >= 0; } ///< free, as far as the factor knows
    bool closed(VertexId v) const { return closed_.contains(v); }
    /// Open vertices of the leaves, rising: planned vertices, and vertices that were added or opened later.
    std::vector<VertexId> open_vertices() const;
    std::size_t open_count() const;

    /// Reports that the row of a vertex has changed, or that the vertex has come or gone.
    /// @param before the row until then
    void touch(VertexId v, const OnlineStiffness::Row& before);
    /// Closed vertices whose rows have changed since they were condensed.
    std::vector<VertexId> changed_but_closed(const OnlineStiffness& stiffness) const;
    /// Opens closed vertices. Their leaves are condensed again. @pre all changed closed vertices are among `vertices`
    void open(const OnlineStiffness& stiffness, const std::vector<VertexId>& vertices);

    /// Factors the fronts that were touched since the last update.
    /// @param active per vertex id: 1 where a free vertex lives now
    /// @param held vertices whose displacement is given; must be open
    /// @return false when the matrix is not positive definite
    [[nodiscard]] bool update(
        const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active, const std::set<VertexId>& held);
    double reciprocal_condition() const; ///< of the worst front, estimated from the diagonal

    /// Displacements under loads on the free vertices, while held vertices do not move. Three rows per vertex id, one
    /// column per case.
    /// @pre update() returned true, and no vertex was touched since
    Eigen::MatrixXd solve(const Eigen::MatrixXd& load) const;

    std::size_t bytes() const;

private:
    struct Front {
        std::int32_t parent = -1, depth = 0;
        std::vector<std::int32_t> children;
        std::set<VertexId> members; ///< open vertices, alive or not
        std::vector<VertexId> closed, beside; ///< vertices condensed here, and the open vertices that they couple to
        SparseCholesky condensing; ///< factor of `closed`, condensed onto `beside`
        Eigen::MatrixXd taken; ///< lower triangle: the term that the condensed vertices contribute on `beside`
        bool dirty = true;
        /// Vertices eliminated here, and vertices of higher fronts that couple to them.
        std::vector<VertexId> own, bound;
        Eigen::MatrixXd L11, L21, update; ///< L11 and update: lower triangle only
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
    void place_added(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active);
    void raise_strangers(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active);
    bool factor(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active, std::int32_t number,
        std::vector<std::int32_t>& place, Cores cores);
    void collect(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active, std::int32_t number,
        std::vector<std::int32_t>& place);
    void share_out();
    static void reduce_closed(const Front& front, Eigen::MatrixXd& y, Eigen::MatrixXd& inside);
    void reduce(
        const std::vector<std::int32_t>& numbers, Eigen::MatrixXd& y, std::vector<Eigen::MatrixXd>& condensed) const;
    static void fill_closed(const Front& front, const Eigen::MatrixXd& reduced, Eigen::MatrixXd& x);
    void fill(const std::vector<std::int32_t>& numbers, const std::vector<Eigen::MatrixXd>& condensed,
        Eigen::MatrixXd& x) const;
    Eigen::MatrixXd moved_apart(const std::vector<std::int32_t>& numbers, Eigen::MatrixXd& x) const;

    std::vector<Front> fronts_; ///< parents come first
    std::vector<std::int32_t> part_; ///< front of each vertex id, or -1
    std::set<VertexId> planned_; ///< vertices of the dissection; these keep their place when they die
    std::map<VertexId, std::int32_t> closed_; ///< front in which each closed vertex is condensed
    std::map<VertexId, OnlineStiffness::Row> reference_; ///< original rows of closed vertices that were touched
    std::set<VertexId> touched_, held_;
    std::vector<std::int32_t> above_; ///< fronts after those of `below_`, children first
    /// Two independent groups of fronts, for two cores; children first.
    std::array<std::vector<std::int32_t>, 2> below_;
};

} // namespace retractor::fem
