#include "planner/wall/joint_places.h"

#include "mesh/image/skeleton.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <queue>
#include <string>
#include <unordered_map>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kFar = std::numeric_limits<double>::infinity();

    /// Voxels of one label with their neighbours.
    struct BoneVoxels {
        std::vector<std::array<int, 3>> index;
        std::vector<std::vector<std::pair<std::uint32_t, double>>> next; ///< neighbour and distance, mm

        std::size_t size() const { return index.size(); }
    };

    BoneVoxels neighbours_of(const mesh::ImageGrid& grid, std::vector<std::array<int, 3>> index)
    {
        BoneVoxels bone { std::move(index), {} };
        bone.next.resize(bone.size());
        std::unordered_map<std::size_t, std::uint32_t> number;
        for (std::size_t v = 0; v < bone.size(); ++v)
            number.emplace(
                grid.offset(bone.index[v][0], bone.index[v][1], bone.index[v][2]), static_cast<std::uint32_t>(v));
        for (std::size_t v = 0; v < bone.size(); ++v)
            for (int dk = -1; dk <= 1; ++dk)
                for (int dj = -1; dj <= 1; ++dj)
                    for (int di = -1; di <= 1; ++di) {
                        const int i = bone.index[v][0] + di, j = bone.index[v][1] + dj, k = bone.index[v][2] + dk;
                        if ((di == 0 && dj == 0 && dk == 0) || !grid.contains(i, j, k))
                            continue;
                        if (const auto found = number.find(grid.offset(i, j, k)); found != number.end())
                            bone.next[v].emplace_back(
                                found->second, grid.spacing.cwiseProduct(Vec3(di, dj, dk)).norm());
                    }
        return bone;
    }

    /// The shortest ways from some voxels to all voxels, mm [Dijkstra 1959, doi 10.1007/BF01386390].
    std::vector<double> ways_from(const BoneVoxels& bone, const std::vector<std::uint32_t>& from)
    {
        using Entry = std::pair<double, std::uint32_t>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
        std::vector<double> way(bone.size(), kFar);
        for (const std::uint32_t v : from) {
            way[v] = 0.0;
            queue.emplace(0.0, v);
        }
        while (!queue.empty()) {
            const auto [done, v] = queue.top();
            queue.pop();
            if (done > way[v])
                continue;
            for (const auto& [w, step] : bone.next[v])
                if (const double longer = done + step; longer < way[w]) {
                    way[w] = longer;
                    queue.emplace(longer, w);
                }
        }
        return way;
    }

    std::uint32_t farthest(const std::vector<double>& way)
    {
        std::uint32_t at = 0;
        double most = -1.0;
        for (std::size_t v = 0; v < way.size(); ++v)
            if (way[v] != kFar && way[v] > most) {
                most = way[v];
                at = static_cast<std::uint32_t>(v);
            }
        return at;
    }

    /// A voxel near the spine.
    struct NearVoxel {
        std::uint32_t voxel = 0;
        double gap = 0.0; ///< distance from the spine, mm
    };

    /// The joint of one connected part of a bone. @param near its voxels near the spine, one within kJointGapMm at
    /// least
    JointPlaces joint_of(const mesh::ImageGrid& grid, const BoneVoxels& bone, const std::vector<NearVoxel>& near)
    {
        std::vector<std::uint32_t> at_spine;
        for (const NearVoxel& v : near)
            if (v.gap <= kJointGapMm)
                at_spine.push_back(v.voxel);
        const std::vector<double> from_spine = ways_from(bone, at_spine);
        const std::uint32_t front = farthest(from_spine);
        const std::vector<double> from_front = ways_from(bone, { front });
        double end = 0.0;
        for (const std::uint32_t v : at_spine)
            end = std::max(end, from_front[v]);
        const auto along = [&](std::uint32_t v) { return end - from_front[v]; };
        const auto middle = [&](double begin, double finish, double gap) {
            Vec3 sum = Vec3::Zero();
            double count = 0.0;
            for (const NearVoxel& v : near)
                if (v.gap <= gap && along(v.voxel) >= begin && along(v.voxel) <= finish) {
                    const std::array<int, 3>& at = bone.index[v.voxel];
                    sum += grid.world(Vec3(at[0], at[1], at[2]));
                    count += 1.0;
                }
            return Vec3(sum / count);
        };
        JointPlaces places { .head = middle(0.0, kJointLengthMm, kJointGapMm) };
        if (from_spine[front] < kLeastNeckMm) // a scrap beside the spine, without a shaft
            return places;
        for (const double gap : { kJointGapMm, kTubercleGapMm }) {
            double last = 0.0;
            for (const NearVoxel& v : near)
                if (v.gap <= gap && along(v.voxel) <= kTubercleReachMm)
                    last = std::max(last, along(v.voxel));
            if (last < kLeastNeckMm)
                continue;
            const Vec3 tubercle = middle(last - std::min(kJointLengthMm, last / 3.0), last, gap);
            // A rib that only leaves the spine is within the wider gap until this far from its head.
            const double shortest = gap > kJointGapMm ? kTubercleGapMm : kShortestAxisMm;
            if ((tubercle - places.head).norm() >= shortest) {
                places.tubercle = tubercle;
                break;
            }
        }
        return places;
    }

    /// The joints of all parts of one bone.
    void add_joints(const mesh::LabelVolume& labels, const mesh::LabelFlags& spine, Label label,
        std::vector<std::array<int, 3>> index, std::vector<JointPlaces>& joints)
    {
        std::vector<NearVoxel> near;
        for (std::size_t v = 0; v < index.size(); ++v) {
            const Vec3 place = labels.grid.world(Vec3(index[v][0], index[v][1], index[v][2]));
            if (const double gap = distance_to_labels(labels, spine, place, kTubercleGapMm); gap <= kTubercleGapMm)
                near.push_back({ static_cast<std::uint32_t>(v), gap });
        }
        const auto at_spine = [](const NearVoxel& v) { return v.gap <= kJointGapMm; };
        if (std::ranges::none_of(near, at_spine))
            return;
        const BoneVoxels bone = neighbours_of(labels.grid, std::move(index));
        while (true) {
            const auto first = std::ranges::find_if(near, at_spine);
            if (first == near.end())
                return;
            const std::vector<double> way = ways_from(bone, { first->voxel });
            const auto other = std::stable_partition(
                near.begin(), near.end(), [&](const NearVoxel& v) { return way[v.voxel] != kFar; });
            joints.push_back(joint_of(labels.grid, bone, { near.begin(), other }));
            joints.back().label = label;
            near.erase(near.begin(), other);
        }
    }

    /// "rib_left_" of "rib_left_5"; empty for ribs 11 and 12, which have no tubercle, and for other bones.
    std::string side_of_rib(const mesh::LabelTable& table, Label label)
    {
        const mesh::LabelInfo* info = mesh::find_label(table, label);
        if (info == nullptr || !info->name.starts_with("rib_") || info->name.ends_with("_11")
            || info->name.ends_with("_12"))
            return {};
        return info->name.substr(0, info->name.rfind('_') + 1);
    }

    /// Gives ribs without a tubercle the axis of the nearest rib of their side.
    void take_axes_of_neighbours(const mesh::LabelTable& table, std::vector<JointPlaces>& joints)
    {
        for (JointPlaces& joint : joints) {
            const std::string side = side_of_rib(table, joint.label);
            if (joint.tubercle || side.empty() || std::ranges::count(joints, joint.label, &JointPlaces::label) > 1)
                continue; // a rib in pieces: which of them is its head is not known
            const JointPlaces* nearest = nullptr;
            for (const JointPlaces& other : joints)
                if (other.tubercle && !other.axis_of_neighbour && side_of_rib(table, other.label) == side
                    && (nearest == nullptr || (other.head - joint.head).norm() < (nearest->head - joint.head).norm()))
                    nearest = &other;
            if (nearest == nullptr)
                continue;
            joint.tubercle = joint.head + (*nearest->tubercle - nearest->head);
            joint.axis_of_neighbour = true;
        }
    }

} // namespace

double distance_to_labels(
    const mesh::LabelVolume& labels, const mesh::LabelFlags& wanted, const Vec3& point, double reach)
{
    const Vec3 centre = labels.grid.index(point);
    std::array<int, 3> low {}, high {};
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        const double radius = reach / labels.grid.spacing[axis];
        low[a] = std::max(0, static_cast<int>(std::ceil(centre[axis] - radius)));
        high[a] = std::min(labels.grid.size[a] - 1, static_cast<int>(std::floor(centre[axis] + radius)));
    }
    double nearest = std::numeric_limits<double>::infinity();
    for (int k = low[2]; k <= high[2]; ++k)
        for (int j = low[1]; j <= high[1]; ++j)
            for (int i = low[0]; i <= high[0]; ++i)
                if (wanted[labels.voxels[labels.grid.offset(i, j, k)]] != 0)
                    nearest = std::min(nearest, labels.grid.spacing.cwiseProduct(Vec3(i, j, k) - centre).norm());
    return nearest <= reach ? nearest : std::numeric_limits<double>::infinity();
}

std::vector<JointPlaces> joint_places(const mesh::LabelVolume& labels, std::span<const Label> fixed_labels)
{
    const mesh::LabelFlags spine = mesh::flagged_labels(fixed_labels);
    const mesh::LabelFlags bone = mesh::flagged_labels(labels.table, [&](const mesh::LabelInfo& info) {
        return mesh::is_wall(info) && mesh::is_skeleton(info) && spine[info.id] == 0;
    });
    std::map<Label, std::vector<std::array<int, 3>>> voxels;
    mesh::visit_voxels(labels, [&](int i, int j, int k, Label label) {
        if (bone[label] != 0)
            voxels[label].push_back({ i, j, k });
    });
    std::vector<JointPlaces> joints;
    for (auto& [label, index] : voxels)
        add_joints(labels, spine, label, std::move(index), joints);
    take_axes_of_neighbours(labels.table, joints);
    return joints;
}

} // namespace retractor::planner
