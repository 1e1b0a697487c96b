#include "mesh/cutting/stroke/cut_groups.h"

#include "mesh/base/assert.h"
#include "mesh/base/disjoint_sets.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

namespace retractor::mesh {

namespace {

    /// Groups of elements that are connected by uncut faces. Elements are in ascending order, and groups are ordered by
    /// their first element. Only faces that contain `core` (a vertex or an edge that all the elements share) count.
    Groups groups_of_star(
        std::span<const VertexId> core, const std::vector<TetId>& star, const CutStore& store, const CutFaces& cut)
    {
        DisjointSets sets(star.size());
        struct Face {
            std::uint64_t key; ///< key of the face's corners outside the core
            std::size_t element;
        };
        const auto key_of = [](VertexId a, VertexId b) { // b < 0: one corner only
            const auto least = static_cast<std::uint32_t>(std::min(a, b)),
                       most = static_cast<std::uint32_t>(std::max(a, b));
            return std::uint64_t { least } << 32U | most;
        };
        const auto others = [&](const auto& corners) {
            std::array<VertexId, 3> rest { -1, -1, -1 };
            std::size_t n = 0;
            for (const VertexId v : corners)
                if (std::find(core.begin(), core.end(), v) == core.end())
                    rest[n++] = v;
            return rest;
        };
        std::vector<std::uint64_t> cut_here;
        for (const FaceKey& key : cut.around(core.front()))
            if (std::all_of(core.begin(), core.end(),
                    [&](VertexId v) { return std::find(key.begin(), key.end(), v) != key.end(); })) {
                const auto rest = others(key);
                cut_here.push_back(key_of(rest[0], rest[1]));
            }
        std::vector<Face> faces;
        faces.reserve(3 * star.size());
        for (std::size_t i = 0; i < star.size(); ++i) {
            const auto rest = others(store.tet(star[i]).nodes);
            if (core.size() == 1) {
                faces.push_back({ key_of(rest[0], rest[1]), i });
                faces.push_back({ key_of(rest[1], rest[2]), i });
                faces.push_back({ key_of(rest[2], rest[0]), i });
            } else {
                faces.push_back({ key_of(rest[0], -1), i });
                faces.push_back({ key_of(rest[1], -1), i });
            }
        }
        std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.key < b.key; });
        for (std::size_t f = 0; f + 1 < faces.size(); ++f)
            if (faces[f].key == faces[f + 1].key
                && std::find(cut_here.begin(), cut_here.end(), faces[f].key) == cut_here.end())
                sets.join(faces[f].element, faces[f + 1].element);
        Groups groups; // a root is the first element of its group
        std::vector<std::size_t> group_of(star.size());
        for (std::size_t i = 0; i < star.size(); ++i) {
            const std::size_t root = sets.root(i);
            if (root == i) {
                group_of[i] = groups.size();
                groups.emplace_back();
            }
            groups[group_of[root]].push_back(star[i]);
        }
        return groups;
    }

    std::size_t group_of(TetId t, const Groups& groups)
    {
        for (std::size_t g = 0; g < groups.size(); ++g)
            if (std::binary_search(groups[g].begin(), groups[g].end(), t))
                return g;
        return groups.size();
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

bool pinned(const Groups& fans, const Groups& at_a, const Groups& at_b)
{
    for (std::size_t i = 0; i < fans.size(); ++i) {
        RETRACTOR_ASSERT(group_of(fans[i].front(), at_a) < at_a.size());
        RETRACTOR_ASSERT(group_of(fans[i].front(), at_b) < at_b.size());
        for (std::size_t j = 0; j < i; ++j)
            if (group_of(fans[i].front(), at_a) == group_of(fans[j].front(), at_a)
                && group_of(fans[i].front(), at_b) == group_of(fans[j].front(), at_b))
                return true;
    }
    return false;
}

} // namespace retractor::mesh
