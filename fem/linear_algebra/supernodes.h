#pragma once
// A supernodal Cholesky factor as CHOLMOD lays it out, for work on it that CHOLMOD has no function for. Only for
// sparse_cholesky.cpp and partial_factor.cpp.

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

struct cholmod_factor_struct;

namespace retractor::fem {

/// A supernodal factor's arrays: dense blocks of columns with the same rows, the diagonal block first.
struct Supernodes {
    explicit Supernodes(const cholmod_factor_struct& factor);
    Eigen::Index columns(std::size_t s) const { return first[s + 1] - first[s]; }
    Eigen::Index rows(std::size_t s) const { return row_start[s + 1] - row_start[s]; }
    Eigen::Index row(std::size_t s, Eigen::Index i) const { return row_list[row_start[s] + i]; }
    Eigen::Map<const Eigen::MatrixXd> block(std::size_t s) const
    {
        return { values + value_start[s], rows(s), columns(s) };
    }

    /// That of the first row below the diagonal block, which all further rows belong to ancestors of; -1: none.
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

/// Supernodes that are substituted back in the order given: first those above, then the two parts below, which do
/// not need each other. Each falling.
struct TwoParts {
    std::vector<std::size_t> above;
    std::array<std::vector<std::size_t>, 2> below;
};

/// Of those with columns before `given`: subtrees are split until none is much of the whole.
TwoParts two_parts(const Supernodes& f, Eigen::Index given);

} // namespace retractor::fem
