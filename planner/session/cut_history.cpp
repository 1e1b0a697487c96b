#include "planner/session/cut_history.h"

#include "mesh/base/assert.h"
#include "mesh/base/triangle.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace retractor::planner {

namespace {

    /// Share of the removed tissue that counts as round-off of divided elements, and not as another tissue.
    constexpr double kNoVolume = 1e-6;

    double volume_of(const mesh::MeshDelta::Tet& tet, const Points& vertices)
    {
        const auto p = [&](std::size_t i) { return Vec3(vertices.row(tet.nodes[i])); };
        return mesh::tet_volume(p(0), p(1), p(2), p(3));
    }

} // namespace

std::vector<LipsOfCut> lips_of_cuts(const mesh::CutSession& session, std::size_t cuts)
{
    std::vector<LipsOfCut> found(cuts);
    for (const mesh::LipFace& lip : session.lips()) {
        if (lip.side < 0 || static_cast<std::size_t>(lip.cut) >= cuts)
            continue;
        const auto nodes = session.tet(lip.face.tet).nodes;
        std::array<Vec3, 3> p;
        for (std::size_t i = 0; i < 3; ++i)
            p[i] = session.position(
                nodes[static_cast<std::size_t>(mesh::kTetFaces[static_cast<std::size_t>(lip.face.corner)][i])]);
        LipsOfCut& of = found[static_cast<std::size_t>(lip.cut)];
        of.area_mm2 += triangle_area(p);
        of.bared = of.bared || lip.side == 0;
    }
    return found;
}

std::string label_name(const mesh::LabelTable& table, Label label)
{
    const mesh::LabelInfo* info = mesh::find_label(table, label);
    return info == nullptr ? "nothing" : info->name;
}

CutEntry restored_entry(const mesh::MeshDelta& delta, const LipsOfCut& lips, const mesh::LabelTable& labels,
    const Points& rest, const std::function<void()>& take)
{
    CutEntry entry { .restored = true };
    entry.report.lip_area_mm2 = lips.area_mm2;
    std::map<Label, double> lost;
    for (const mesh::MeshDelta::Tet& tet : delta.tets_gone)
        lost[tet.label] += volume_of(tet, rest);
    take();
    for (const mesh::MeshDelta::Tet& tet : delta.tets_born)
        lost[tet.label] -= volume_of(tet, rest);
    // An ablation removes vertices, or exposes faces, or both; a cut does neither.
    const bool ablation = lips.bared
        || std::any_of(delta.vertices_gone.begin(), delta.vertices_gone.end(),
            [](const auto& gone) { return gone.origin == mesh::MeshDelta::Origin::restored; });
    if (!ablation || lost.empty())
        return entry;
    double most = 0.0;
    for (const auto& [label, volume] : lost)
        entry.report.removed_volume_mm3 += volume;
    for (const auto& [label, volume] : lost) {
        if (volume < kNoVolume * entry.report.removed_volume_mm3)
            continue;
        entry.several_tissues = most > 0.0;
        if (volume > most) {
            most = volume;
            entry.taken_out = label_name(labels, label);
        }
    }
    return entry;
}

void CutHistory::add(CutEntry entry)
{
    std::erase_if(entries_, [](const CutEntry& cut) { return !cut.in_force; });
    append(std::move(entry));
}

void CutHistory::append(CutEntry entry)
{
    entry.number = static_cast<int>(entries_.size()) + 1;
    entries_.push_back(std::move(entry));
}

void CutHistory::set_in_force(std::size_t index, bool in_force)
{
    RETRACTOR_ASSERT(index < entries_.size());
    entries_[index].in_force = in_force;
}

} // namespace retractor::planner
