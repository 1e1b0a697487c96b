#include "mesh/cut_groups.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <span>
#include <utility>

namespace retractor {

namespace {

    /// Elements in groups joined by faces that are not cut, each by id; groups by their first element. Only faces
    /// with all of `core` (a vertex or an edge that all the elements have in common) count.
    Groups groups_of_star(
        std::span<const VertexId> core, const std::vector<TetId>& star, const CutStore& store, const CutFaces& cut)
    {
        std::vector<std::size_t> parent(star.size());
        std::iota(parent.begin(), parent.end(), std::size_t { 0 });
        const auto root = [&](std::size_t i) {
            while (parent[i] != i)
                i = parent[i] = parent[parent[i]];
            return i;
        };
        std::map<FaceKey, std::size_t> open;
        for (std::size_t i = 0; i < star.size(); ++i)
            for (int corner = 0; corner < 4; ++corner) {
                const TetSlot& tet = store.tet(star[i]);
                if (std::find(core.begin(), core.end(), tet.nodes[static_cast<std::size_t>(corner)]) != core.end())
                    continue;
                const FaceKey key = face_key(tet, corner);
                const auto [it, first] = open.try_emplace(key, i);
                if (!first && !cut.contains(key))
                    parent[std::max(root(i), root(it->second))] = std::min(root(i), root(it->second));
            }
        std::map<std::size_t, std::vector<TetId>> by_root;
        for (std::size_t i = 0; i < star.size(); ++i)
            by_root[root(i)].push_back(star[i]);
        Groups groups;
        for (auto& [first, group] : by_root)
            groups.push_back(std::move(group));
        return groups;
    }

} // namespace

Groups groups_round(VertexId v, const CutStore& store, const CutFaces& cut)
{
    return groups_of_star(std::span(&v, 1), store.star(v), store, cut);
}

Groups groups_round(const EdgeKey& edge, const CutStore& store, const CutFaces& cut)
{
    const std::array<VertexId, 2> core { edge.first, edge.second };
    return groups_of_star(core, store.star(edge.first, edge.second), store, cut);
}

} // namespace retractor
