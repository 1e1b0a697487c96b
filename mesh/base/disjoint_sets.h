#pragma once
// Disjoint sets of the numbers 0 to size - 1, joined two by two: union-find with path halving.

#include "mesh/base/assert.h"

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <numeric>
#include <vector>

namespace retractor {

/// The root of a set is its smallest number, so that the roots do not depend on the order of joins.
template <std::unsigned_integral Index = std::size_t> class DisjointSets {
public:
    /// Every number is a set of its own.
    explicit DisjointSets(std::size_t size)
        : parent_(size)
    {
        std::iota(parent_.begin(), parent_.end(), Index { 0 });
    }

    /// Root of the set that holds a number. @pre number < size
    Index root(Index number)
    {
        RETRACTOR_ASSERT(number < parent_.size());
        while (parent_[number] != number)
            number = parent_[number] = parent_[parent_[number]];
        return number;
    }

    /// Joins the sets of two numbers; returns false when both were in one set already. @pre a, b < size
    bool join(Index a, Index b)
    {
        a = root(a);
        b = root(b);
        parent_[std::max(a, b)] = std::min(a, b);
        return a != b;
    }

    /// For every number the root of its set.
    std::vector<Index> roots()
    {
        for (std::size_t i = 0; i < parent_.size(); ++i)
            parent_[i] = root(static_cast<Index>(i));
        return parent_;
    }

private:
    std::vector<Index> parent_;
};

} // namespace retractor
