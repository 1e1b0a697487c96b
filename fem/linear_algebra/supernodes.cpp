#include "fem/linear_algebra/supernodes.h"

#include "mesh/base/assert.h"

#include <cholmod.h>

namespace retractor::fem {

Supernodes::Supernodes(const cholmod_factor_struct& factor)
    : count(factor.nsuper)
    , size(static_cast<Eigen::Index>(factor.n))
    , first(static_cast<const int*>(factor.super))
    , row_start(static_cast<const int*>(factor.pi))
    , value_start(static_cast<const int*>(factor.px))
    , row_list(static_cast<const int*>(factor.s))
    , values(static_cast<const double*>(factor.x))
{
    for (std::size_t s = 0; s < count; ++s)
        most_rows = std::max(most_rows, rows(s));
}

TwoParts two_parts(const Supernodes& f, Eigen::Index given)
{
    RETRACTOR_ASSERT(given >= 0 && given <= f.size);
    constexpr double kMuch = 1.0 / 12.0;
    std::vector<std::int32_t> parent(f.count, -1);
    std::vector<double> entries(f.count, 0.0); // number of factor entries per subtree
    std::vector<std::vector<std::size_t>> children(f.count);
    std::vector<std::size_t> subtrees;
    double total = 0.0;
    for (std::size_t s = 0; s < f.count; ++s) { // children come before their parents
        const Eigen::Index columns = std::min<Eigen::Index>(f.columns(s), given - f.first[s]);
        if (columns <= 0)
            break;
        const double own = static_cast<double>(f.rows(s) * columns);
        total += own;
        entries[s] += own;
        const std::int32_t p = f.parent(s);
        if (p < 0 || f.first[p] >= given) {
            subtrees.push_back(s);
            continue;
        }
        parent[s] = p;
        entries[static_cast<std::size_t>(p)] += entries[s];
        children[static_cast<std::size_t>(p)].push_back(s);
    }
    const auto smaller = [&](std::size_t a, std::size_t b) { return entries[a] < entries[b]; };
    std::make_heap(subtrees.begin(), subtrees.end(), smaller);
    constexpr std::int8_t kAbove = 2, kAsParent = 3;
    std::vector<std::int8_t> part(f.count, kAsParent);
    while (!subtrees.empty() && entries[subtrees.front()] > kMuch * total) {
        std::pop_heap(subtrees.begin(), subtrees.end(), smaller);
        const std::size_t s = subtrees.back();
        subtrees.pop_back();
        part[s] = kAbove;
        for (const std::size_t child : children[s]) {
            subtrees.push_back(child);
            std::push_heap(subtrees.begin(), subtrees.end(), smaller);
        }
    }
    std::sort(subtrees.begin(), subtrees.end(), [&](std::size_t a, std::size_t b) { return smaller(b, a); });
    std::array<double, 2> load { 0.0, 0.0 };
    for (const std::size_t s : subtrees) {
        const std::size_t lighter = load[1] < load[0] ? 1 : 0;
        load[lighter] += entries[s];
        part[s] = static_cast<std::int8_t>(lighter);
    }
    TwoParts parts;
    for (std::size_t s = f.count; s-- > 0;) {
        if (f.first[s] >= given)
            continue;
        if (part[s] == kAsParent)
            part[s] = part[static_cast<std::size_t>(parent[s])];
        (part[s] == kAbove ? parts.above : parts.below[static_cast<std::size_t>(part[s])]).push_back(s);
    }
    return parts;
}

} // namespace retractor::fem
