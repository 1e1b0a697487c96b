// Finds the clavicles. The search begins beside the notch of the sternum and follows a rod of about 12 mm outwards,
// plane by plane. The clavicle ends where the bone widens into the shoulder.

#include "datasets/segmentation/bones/bones_steps.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace retractor::datasets::segmentation {

namespace {

    constexpr double kRodReach = 10.0; ///< mm from the middle of the rod
    constexpr double kSeedReach = 8.0; ///< mm; smaller, because the first rib may touch the rod
    constexpr double kShoulderReach = 20.0;

    class RodTracker {
    public:
        RodTracker(const mesh::ImageGrid& grid, const Mask& bone, const std::vector<Label>& labels, Label may_take)
            : grid_(grid)
            , bone_(bone)
            , labels_(labels)
            , may_take_(may_take)
        {
        }

        struct Section {
            Vec3 centre = Vec3::Zero();
            std::size_t count = 0;
        };

        /// Mean position and number of the free bone voxels in plane i within `radius` of a point.
        Section section(int i, const Vec3& near, double radius) const
        {
            Section found;
            Vec3 sum = Vec3::Zero();
            visit(i, near, radius, [&](Voxel, const Vec3& p) {
                sum += p;
                ++found.count;
            });
            if (found.count > 0)
                found.centre = sum / static_cast<double>(found.count);
            return found;
        }

        template <typename Visit> void visit(int i, const Vec3& near, double radius, const Visit& work) const
        {
            const Vec3 low = grid_.index(near.array() - radius), high = grid_.index(near.array() + radius);
            for (int k = std::max(0, static_cast<int>(std::ceil(low[2]))); k <= high[2] && k < grid_.size[2]; ++k)
                for (int j = std::max(0, static_cast<int>(std::ceil(low[1]))); j <= high[1] && j < grid_.size[1]; ++j) {
                    const Voxel v = grid_.offset(i, j, k);
                    const Vec3 p = grid_.world(Vec3(i, j, k));
                    if (bone_[v] && (labels_[v] == 0 || labels_[v] == may_take_)
                        && (p - near).tail<2>().norm() <= radius)
                        work(v, p);
                }
        }

    private:
        const mesh::ImageGrid& grid_;
        const Mask& bone_;
        const std::vector<Label>& labels_;
        Label may_take_;
    };

    /// Finds the rod beside the notch, at a distance where no other bone is near.
    std::optional<std::pair<int, Vec3>> start(
        const RodTracker& tracker, const mesh::ImageGrid& grid, const Cage& cage, double side)
    {
        constexpr double kFrom = 32.0, kTo = 56.0, kWindow = 30.0; // mm
        constexpr double kLeastArea = 50.0, kMostArea = 500.0; // mm2
        const double top = cage.sternum.top();
        const Eigen::Vector2d notch = cage.sternum(top);
        const double area = grid.spacing.y() * grid.spacing.z();
        for (double x = kFrom; x < kTo; x += grid.spacing.x()) {
            const Vec3 middle(notch.x() + side * x, notch.y() + 8.0, top + 12.0);
            const int i = static_cast<int>(std::lround(grid.index(middle)[0]));
            if (i < 0 || i >= grid.size[0])
                break;
            RodTracker::Section found = tracker.section(i, middle, kWindow);
            for (int pass = 0; pass < 6 && found.count > 0; ++pass)
                found = tracker.section(i, found.centre, kRodReach + 3.0 * std::max(0, 3 - pass));
            const double size = static_cast<double>(found.count) * area;
            if (size > kLeastArea && size < kMostArea)
                return std::pair(i, found.centre);
        }
        return std::nullopt;
    }

} // namespace

std::vector<Vec3> seed_clavicle(const mesh::ImageGrid& grid, const Mask& bone, const Cage& cage, bool left, Label other,
    Label clavicle, const Mask& not_rib, std::vector<Label>& labels)
{
    constexpr double kFewest = 25.0; // mm2
    constexpr double kMostGap = 5.0, kShoulder = 12.0, kLongest = 170.0; // mm
    constexpr double kWider = 3.2; // bone in the wide disc relative to the rod's disc; a larger ratio is no rod
    constexpr double kInner = 18.0, kUnderNotch = 12.0, kFarOut = 60.0;
    const RodTracker tracker(grid, bone, labels, other), shoulders(grid, not_rib, labels, other);
    const double outwards = left ? 1.0 : -1.0;
    const auto first = start(tracker, grid, cage, outwards);
    if (!first)
        return {};
    const Eigen::Vector2d notch = cage.sternum(cage.sternum.top());
    const double area = grid.spacing.y() * grid.spacing.z();
    std::vector<std::pair<int, Vec3>> rod;
    for (const double direction : { outwards, -outwards }) {
        std::vector<Vec3> centres { first->second };
        double gap = 0.0, shoulder = 0.0, length = 0.0;
        std::vector<std::pair<int, Vec3>> here;
        for (int i = first->first;; i += direction > 0.0 ? 1 : -1) {
            if (i < 0 || i >= grid.size[0])
                break;
            const std::size_t back = std::min<std::size_t>(centres.size() - 1, 8);
            const Vec3 slope = back == 0
                ? Vec3(Vec3::Zero())
                : Vec3((centres.back() - centres[centres.size() - 1 - back]) / static_cast<double>(back));
            const Vec3 expected = centres.back() + slope;
            const auto found = tracker.section(i, expected, kRodReach);
            if (static_cast<double>(found.count) * area < kFewest) {
                gap += grid.spacing.x();
                if (gap > kMostGap)
                    break;
                centres.push_back(expected);
                continue;
            }
            gap = 0.0;
            const Vec3 centre = 0.5 * (found.centre + tracker.section(i, found.centre, kRodReach).centre);
            const double beside = outwards * (centre.x() - notch.x());
            if (beside < kInner || (direction != outwards && centre.z() < cage.sternum.top() - kUnderNotch))
                break;
            const bool wide = static_cast<double>(shoulders.section(i, centre, kShoulderReach).count)
                > kWider * static_cast<double>(found.count);
            shoulder = wide && beside > kFarOut ? shoulder + grid.spacing.x() : 0.0;
            length += (centre - centres.back()).norm();
            if (shoulder > kShoulder || length > kLongest)
                break;
            centres.push_back(centre);
            here.emplace_back(i, centre);
        }
        // The last part already belongs to the shoulder.
        const auto drop = static_cast<std::size_t>(shoulder / grid.spacing.x());
        here.resize(here.size() - std::min(here.size(), drop));
        rod.insert(rod.end(), here.begin(), here.end());
    }
    constexpr std::size_t kFewestPlanes = 15;
    if (rod.size() < kFewestPlanes)
        return {};
    std::vector<Voxel> voxels;
    for (const auto& [i, centre] : rod)
        tracker.visit(i, centre, kSeedReach, [&](Voxel v, const Vec3&) { voxels.push_back(v); });
    for (const Voxel v : voxels)
        labels[v] = clavicle;
    std::vector<Vec3> line;
    for (const auto& [i, centre] : rod)
        line.push_back(centre);
    return line;
}

} // namespace retractor::datasets::segmentation
