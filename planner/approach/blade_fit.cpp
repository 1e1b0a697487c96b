#include "planner/approach/blade_fit.h"

#include "mesh/base/assert.h"
#include "mesh/base/statistics.h"
#include "mesh/image/skeleton.h"
#include "planner/approach/hook_patches.h"
#include "planner/approach/hooks.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

namespace retractor::planner {

namespace {

    constexpr double kBehindMm = 20.0; ///< bone farther behind a blade belongs to another space
    constexpr double kBeforeMm = 4.0; ///< the edge of a bone may stand this far before the blade, which then bends it
    constexpr double kColumnMm = 2.0, kDepthStepMm = 1.0, kRayStepMm = 0.5;
    constexpr double kLeastShare = 0.6; ///< of a blade's columns: with bone behind them, and bearing on it
    constexpr double kMostYaw = 0.2618; ///< rad; 15 degrees: a rack that lies more askew is in the surgeon's way
    constexpr double kGiveMm = 1.0; ///< so much do muscle and periosteum between blade and bone give
    constexpr double kPastBoneMm = 3.0; ///< a blade reaches this much past the place of bone that is nearest to it
    constexpr double kReachedShare = 0.9; ///< of the columns whose bone a longer blade reaches: one place is no rib

    /// A column of a blade, and the nearest bone behind it.
    struct Column {
        double along = 0.0; ///< from the blade's middle
        double behind = 0.0; ///< distance of the bone; negative where its edge stands before the blade
        bool cut = false; ///< the bone is cut: it goes through the blade's plane
        double depth = 0.0; ///< of the bone, below the skin
        bool bears = false; ///< the blade as it is meets bone here, as near as a longer one would
    };

    std::vector<double> steps_over(double from, double to, double spacing)
    {
        const int count = std::max(1, static_cast<int>(std::lround((to - from) / spacing)));
        std::vector<double> steps;
        for (int n = 0; n <= count; ++n)
            steps.push_back(from + (to - from) * n / count);
        return steps;
    }

    /// The columns of a blade that have bone behind them.
    class BoneBehind {
    public:
        BoneBehind(const Approach& approach, const mesh::LabelVolume& labels)
            : approach_(approach)
            , labels_(labels)
            , is_bone_(mesh::flagged_labels(labels.table,
                  [](const mesh::LabelInfo& info) { return mesh::is_wall(info) && mesh::is_skeleton(info); }))
        {
        }

        std::vector<Column> columns(const HookSpec& blade) const
        {
            const RetractorSpec& retractor = *approach_.retractor;
            const PatchPlace place = patch_place(approach_, blade);
            const Vec3 skin = place.centre - blade.depth_mm * place.depth;
            const double top = blade.depth_mm - 0.5 * blade.patch_height_mm, end = top + blade.patch_height_mm;
            const double wall = depth_through_wall(approach_, blade.along_mm, blade.patch_width_mm);
            const double bottom = std::max(top + kDepthStepMm, std::min(retractor.blade_depth_mm, wall));
            std::vector<Column> columns;
            for (const double along : steps_of(blade)) {
                std::optional<Column> nearest;
                double nearest_above_end = kBehindMm + 1.0;
                for (const double depth : steps_over(top, bottom, kDepthStepMm)) {
                    const Vec3 from = skin + along * place.along + depth * place.depth;
                    std::optional<Column> met = first_bone(from, blade.direction);
                    if (!met)
                        continue;
                    met->along = along;
                    met->depth = depth;
                    if (depth <= end)
                        nearest_above_end = std::min(nearest_above_end, met->behind);
                    if (!nearest || met->behind < nearest->behind)
                        nearest = met;
                }
                if (!nearest)
                    continue;
                nearest->bears = nearest_above_end <= nearest->behind + kGiveMm;
                columns.push_back(*nearest);
            }
            return columns;
        }

        static std::vector<double> steps_of(const HookSpec& blade)
        {
            return steps_over(-0.5 * blade.patch_width_mm, 0.5 * blade.patch_width_mm, kColumnMm);
        }

    private:
        bool is_bone(const Vec3& place) const { return is_bone_[mesh::label_at(labels_, place)] != 0; }

        /// The edge of the first bone that stands behind a place of the blade, or reaches to behind it. Bone that ends
        /// before the blade belongs to the other lip.
        std::optional<Column> first_bone(const Vec3& from, const Vec3& direction) const
        {
            bool within = is_bone(from - kBeforeMm * direction);
            Column met { .cut = within };
            for (double behind = -kBeforeMm; behind <= kBehindMm; behind += kRayStepMm) {
                const bool here = is_bone(from + behind * direction);
                if (here && !within)
                    met = { .behind = behind };
                within = here;
                if (here && behind >= 0.0)
                    return met;
            }
            return std::nullopt;
        }

        const Approach& approach_;
        const mesh::LabelVolume& labels_;
        mesh::LabelFlags is_bone_;
    };

    /// Slope of the bone behind a blade: the median of the slopes between two columns (Sen 1968,
    /// doi 10.1080/01621459.1968.10480934), which a notch or a voxel's step does not move.
    double slope_of(const std::vector<Column>& columns)
    {
        std::vector<double> slopes;
        for (std::size_t a = 0; a < columns.size(); ++a)
            for (std::size_t b = a + 1; b < columns.size(); ++b)
                slopes.push_back((columns[b].behind - columns[a].behind) / (columns[b].along - columns[a].along));
        return upper_median(slopes);
    }

} // namespace

BladeFit blade_fit(const Approach& approach, const mesh::LabelVolume& labels)
{
    RETRACTOR_ASSERT(approach.retractor && approach.hooks.size() == 2);
    const BoneBehind bone(approach, labels);
    BladeFit fit;
    int sides = 0;
    for (const HookSpec& blade : approach.hooks) {
        const std::vector<Column> columns = bone.columns(blade);
        const double most = kLeastShare * static_cast<double>(BoneBehind::steps_of(blade).size());
        if (columns.size() < 2 || static_cast<double>(columns.size()) < most)
            continue;
        std::vector<Column> edge;
        std::ranges::copy_if(columns, std::back_inserter(edge), [](const Column& column) { return !column.cut; });
        if (edge.size() >= 2 && static_cast<double>(edge.size()) >= most) {
            // depth x along points away from the left of the cut: a turn towards the left, side +1, is negative.
            fit.yaw -= blade.side * std::atan(slope_of(edge));
            ++sides;
        }
        const auto bearing = static_cast<double>(std::ranges::count(columns, true, &Column::bears));
        if (bearing >= kLeastShare * static_cast<double>(columns.size()))
            continue;
        std::vector<double> depths;
        std::ranges::transform(columns, std::back_inserter(depths), &Column::depth);
        const auto rank = static_cast<std::size_t>(kReachedShare * static_cast<double>(depths.size() - 1));
        fit.reach_mm = std::max(fit.reach_mm,
            std::min(value_of_rank(depths, rank) + kPastBoneMm,
                depth_through_wall(approach, blade.along_mm, blade.patch_width_mm)));
    }
    fit.yaw = std::clamp(fit.yaw / std::max(1, sides), -kMostYaw, kMostYaw);
    return fit;
}

void fit_blades(Approach& approach, const mesh::LabelVolume& labels)
{
    const BladeFit fit = blade_fit(approach, labels);
    for (HookSpec& blade : approach.hooks) {
        blade.direction = Eigen::AngleAxisd(fit.yaw, patch_place(approach, blade).depth) * blade.direction;
        blade.name = blade_name(blade.direction);
        const double top = blade.depth_mm - 0.5 * blade.patch_height_mm, bottom = top + blade.patch_height_mm;
        const double reach = std::max(bottom, std::min(fit.reach_mm, approach.retractor->blade_depth_mm));
        blade.patch_height_mm = reach - top;
        blade.depth_mm = top + 0.5 * blade.patch_height_mm;
    }
}

} // namespace retractor::planner
