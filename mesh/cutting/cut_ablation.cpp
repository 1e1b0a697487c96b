#include "mesh/cutting/cut_ablation.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"
#include "mesh/cutting/stroke/cut_groups.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <algorithm>
#include <set>
#include <string>

namespace retractor::mesh {

namespace {

    const CutFaces kNothingCut; ///< empty: only removed elements separate others

    /// Number of elements between two tests for cancellation.
    constexpr std::size_t kCheckEvery = 4096;

    class Ablation {
    public:
        Ablation(CutStore& store, int cut_number)
            : store_(store)
            , cut_number_(cut_number)
        {
        }
        CutResult run(std::span<const TetId> marked, const Job& job);

    private:
        bool remove(std::span<const TetId> marked, const Job& job);
        void remove_unused_vertices();
        void part_edges();
        void part_vertices();

        CutStore& store_;
        int cut_number_;
        std::set<VertexId> rim_; ///< vertices of removed elements that are still in use
        CutReport report_ {};
    };

    bool Ablation::remove(std::span<const TetId> marked, const Job& job)
    {
        const auto is_marked = [&](TetId t) { return std::binary_search(marked.begin(), marked.end(), t); };
        for (std::size_t i = 0; i < marked.size(); ++i) {
            if (i % kCheckEvery == 0 && job.cancelled())
                return false;
            const TetSlot& tet = store_.tet(marked[i]);
            report_.removed_volume_mm3 += store_.volume(marked[i]);
            for (int corner = 0; corner < 4; ++corner) {
                const TetId other = store_.across({ marked[i], corner });
                if (other < 0 || is_marked(other))
                    continue;
                std::array<LipTag, 4> lips = store_.tet(other).lips;
                for (std::size_t k = 0; k < 4; ++k) // the corner of the neighbour that this element does not have
                    if (store_.corner(marked[i], store_.tet(other).nodes[k]) < 0)
                        lips[k] = { cut_number_, 0 };
                store_.set_lips(other, lips);
                const auto [a, b, c] = face_corners(tet.nodes, corner);
                report_.lip_area_mm2 += triangle_area(store_.position(a), store_.position(b), store_.position(c));
            }
            rim_.insert(tet.nodes.begin(), tet.nodes.end());
        }
        for (const TetId t : marked)
            store_.remove_tet(t);
        return true;
    }

    void Ablation::remove_unused_vertices()
    {
        for (auto v = rim_.begin(); v != rim_.end();) {
            if (!store_.unsorted_star(*v).empty()) {
                ++v;
                continue;
            }
            store_.remove_vertex(*v);
            v = rim_.erase(v);
        }
    }

    /// Gives an edge a vertex of its own when several fans of elements remain round the edge and would still share both
    /// ends.
    void Ablation::part_edges()
    {
        std::set<EdgeKey> edges;
        for (const VertexId v : rim_)
            for (const TetId t : store_.unsorted_star(v))
                for (const VertexId w : store_.tet(t).nodes)
                    if (w > v && rim_.contains(w))
                        edges.emplace(v, w);
        for (const EdgeKey& edge : edges) {
            const Groups fans = groups_round(edge, store_, kNothingCut);
            if (fans.size() < 2)
                continue;
            if (pinned(fans, groups_round(edge.first, store_, kNothingCut),
                    groups_round(edge.second, store_, kNothingCut)))
                rim_.insert(store_.bisect(edge.first, edge.second,
                    Vec3(0.5 * (store_.position(edge.first) + store_.position(edge.second))), 0.5));
        }
    }

    /// Gives groups of elements that are connected in a vertex only vertices of their own.
    void Ablation::part_vertices()
    {
        for (const VertexId v : rim_) {
            const Groups groups = groups_round(v, store_, kNothingCut);
            for (std::size_t g = 1; g < groups.size(); ++g) {
                const VertexId copy = store_.copy_vertex(v);
                for (const TetId t : groups[g]) {
                    TetSlot slot = store_.tet(t);
                    slot.nodes[static_cast<std::size_t>(store_.corner(t, v))] = copy;
                    store_.remove_tet(t);
                    store_.add_tet(slot);
                }
            }
        }
    }

    CutResult Ablation::run(std::span<const TetId> marked, const Job& job)
    {
        CutResult result;
        report_.tets_before = store_.counts().tets;
        job.report("ablate", 0.0);
        if (!remove(marked, job)) {
            result.status = CutStatus::cancelled;
            result.message = "the ablation was cancelled";
            return result;
        }
        remove_unused_vertices();
        part_edges();
        part_vertices();
        job.report("ablate", 1.0);
        report_.tets_after = store_.counts().tets;
        result.report = report_;
        return result;
    }

} // namespace

std::vector<TetId> checked_marks(const CutStore& store, std::span<const TetId> tets)
{
    std::vector<TetId> marked(tets.begin(), tets.end());
    std::sort(marked.begin(), marked.end());
    marked.erase(std::unique(marked.begin(), marked.end()), marked.end());
    if (marked.empty())
        throw InputError("nothing is marked: there is no element to remove");
    for (const TetId t : marked)
        if (!store.has_tet(t))
            throw InputError("there is no such element", "element " + std::to_string(t));
    if (marked.size() == store.counts().tets)
        throw InputError("everything is marked: nothing of the body would be left");
    return marked;
}

CutResult ablate_elements(CutStore& store, std::span<const TetId> marked, int cut_number, const Job& job)
{
    RETRACTOR_ASSERT(!marked.empty() && std::is_sorted(marked.begin(), marked.end()));
    return Ablation(store, cut_number).run(marked, job);
}

} // namespace retractor::mesh
