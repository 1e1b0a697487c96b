#pragma once
// A supernodal Cholesky factor in the layout of CHOLMOD, for operations that CHOLMOD does not offer. Only
// sparse_cholesky.cpp and partial_factor.cpp use this header.

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

struct cholmod_factor_struct;

namespace retractor::fem {

/// The arrays of a supernodal factor: dense blocks of columns with common rows, the diagonal block first.
struct Supernodes {
    explicit Supernodes(const cholmod_factor_struct& factor);
    Eigen::Index columns(std::size_t s) const { return first[s + 1] - first[s]; }
    Eigen::Index rows(std::size_t s) const { return row_start[s + 1] - row_start[s]; }
    Eigen::Index row(std::size_t s, Eigen::Index i) const { return row_list[row_start[s] + i]; }
    Eigen::Map<const Eigen::MatrixXd> block(std::size_t s) const
    {
        return { values + value_start[s], rows(s), columns(s) };
    }

    /// The supernode of the first row below the diagonal block, or -1. All further rows belong to ancestors of this
    /// parent.
    std::int32_t parent(std::size_t s) const { return rows(s) == columns(s) ? -1 : supernode_of(row(s, columns(s))); }
    std::int32_t supernode_of(Eigen::Index unknown) const
    {
        return static_cast<std::int32_t>(
            std::upper_bound(first, first + count + 1, static_cast<int>(unknown)) - first - 1);
    }

    std::size_t count;
    Eigen::Index size, most_rows = 0;
    const int *first, *row_start, *value_start, *row_list;
    const double* values;
};

/// An order of supernodes for back substitution: first the supernodes of `above`, then the two independent parts of
/// `below`. Each list falls.
struct TwoParts {
    std::vector<std::size_t> above;
    std::array<std::vector<std::size_t>, 2> below;
};

/// Divides the supernodes that have columns before `given`. Subtrees are split until none is a large share of the
/// whole.
TwoParts two_parts(const Supernodes& f, Eigen::Index given);

} // namespace retractor::fem
