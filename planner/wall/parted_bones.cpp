#include "planner/wall/parted_bones.h"

#include "mesh/base/assert.h"
#include "mesh/image/skeleton.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace retractor::planner {

namespace {

    bool is_rib(const mesh::LabelInfo& info) { return info.material == "bone" && info.name.starts_with("rib_"); }

    bool is_other_bone(const mesh::LabelInfo& info) { return info.material == "bone" && !is_rib(info); }

    bool is_soft(const mesh::LabelInfo& info) { return mesh::is_wall(info) && !mesh::is_skeleton(info); }

    /// The most frequent of the counted labels; of equal ones, the smallest.
    Label most_frequent(const std::map<Label, int>& count)
    {
        return std::ranges::max_element(count, {}, [](const auto& entry) { return entry.second; })->first;
    }

} // namespace

std::size_t part_ribs_from_other_bones(mesh::TetMesh& mesh, const mesh::LabelTable& table)
{
    RETRACTOR_ASSERT(mesh.labels.size() == mesh.tet_count());
    const mesh::LabelFlags ribs = mesh::flagged_labels(table, is_rib),
                           others = mesh::flagged_labels(table, is_other_bone),
                           soft = mesh::flagged_labels(table, is_soft);
    std::vector<std::uint8_t> on_rib(mesh.vertex_count(), 0);
    const auto tets = static_cast<TetId>(mesh.tet_count());
    const auto label_of = [&](TetId t) { return mesh.labels[static_cast<std::size_t>(t)]; };
    for (TetId t = 0; t < tets; ++t)
        if (ribs[label_of(t)] != 0)
            for (const VertexId v : mesh.tet(t))
                on_rib[static_cast<std::size_t>(v)] = 1;
    std::map<VertexId, std::map<Label, int>> soft_round; // the vertices of ribs that other bones touch
    for (TetId t = 0; t < tets; ++t)
        if (others[label_of(t)] != 0)
            for (const VertexId v : mesh.tet(t))
                if (on_rib[static_cast<std::size_t>(v)] != 0)
                    soft_round.try_emplace(v);
    std::map<Label, int> soft_round_all;
    for (TetId t = 0; t < tets; ++t)
        if (soft[label_of(t)] != 0)
            for (const VertexId v : mesh.tet(t))
                if (const auto found = soft_round.find(v); found != soft_round.end()) {
                    ++found->second[label_of(t)];
                    ++soft_round_all[label_of(t)];
                }
    if (soft_round_all.empty())
        return 0;
    std::vector<std::pair<TetId, Label>> changes;
    for (TetId t = 0; t < tets; ++t) {
        if (others[label_of(t)] == 0)
            continue;
        bool touches = false;
        std::map<Label, int> count;
        for (const VertexId v : mesh.tet(t))
            if (const auto found = soft_round.find(v); found != soft_round.end()) {
                touches = true;
                for (const auto& [label, elements] : found->second)
                    count[label] += elements;
            }
        if (touches)
            changes.emplace_back(t, most_frequent(count.empty() ? soft_round_all : count));
    }
    for (const auto& [t, label] : changes)
        mesh.labels[static_cast<std::size_t>(t)] = label;
    return changes.size();
}

mesh::HybridModel build_wall(const mesh::LabelVolume& labels, const mesh::MeshSizing& sizing, const Job& job,
    const std::function<void(double expected)>& on_forecast)
{
    mesh::HybridModel model = mesh::build_hybrid_model(labels, sizing, job, on_forecast);
    part_ribs_from_other_bones(model.wall, labels.table);
    return model;
}

} // namespace retractor::planner
