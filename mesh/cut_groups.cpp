#include "mesh/cut_groups.h"

#include <algorithm>
#include <array>
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
        std::vector<std::pair<FaceKey, std::size_t>> faces;
        faces.reserve(3 * star.size());
        for (std::size_t i = 0; i < star.size(); ++i)
            for (int corner = 0; corner < 4; ++corner) {
                const TetSlot& tet = store.tet(star[i]);
                if (std::find(core.begin(), core.end(), tet.nodes[static_cast<std::size_t>(corner)]) == core.end())
                    faces.emplace_back(face_key(tet, corner), i);
            }
        std::sort(faces.begin(), faces.end());
        for (std::size_t f = 0; f + 1 < faces.size(); ++f)
            if (faces[f].first == faces[f + 1].first && !cut.contains(faces[f].first)) {
                const std::size_t a = root(faces[f].second), b = root(faces[f + 1].second);
                parent[std::max(a, b)] = std::min(a, b);
            }
        Groups groups; // a root is the first of its group
        std::vector<std::size_t> group_of(star.size());
        for (std::size_t i = 0; i < star.size(); ++i) {
            if (root(i) == i) {
                group_of[i] = groups.size();
                groups.emplace_back();
            }
            groups[group_of[root(i)]].push_back(star[i]);
        }
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
