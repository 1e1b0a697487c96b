#include "planner/anatomy/body_probe.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

namespace retractor::planner {

namespace {

    constexpr double kLeastKernelMm = 3.0; ///< below this the staircase of common CT labels shows
    constexpr double kKernelVoxels = 1.8; ///< kernel radius in voxels: enough to cover several layers
    constexpr double kSkinKernelFactor = 3.5; ///< factor of the wider kernel that averages the skin
    constexpr double kStepMm = 1.0; ///< ray sampling; smaller than the kernel radius, so that nothing is missed
    constexpr int kBisections = 40; ///< 1 mm / 2^40: below round-off of the coordinates
    constexpr double kProjectionReachMm = 60.0;

    /// Calls visit(label, offset from the point in mm in grid axes, weight) for all lattice places within `radius` of a
    /// point. Beyond the grid the labels of its border continue. The weight falls smoothly to zero at the radius.
    template <typename Visit>
    void visit_ball(const mesh::LabelVolume& labels, const Vec3& point, double radius, Visit&& visit)
    {
        const mesh::ImageGrid& grid = labels.grid;
        const Vec3 centre = grid.index(point);
        std::array<int, 3> low {}, high {};
        for (int a = 0; a < 3; ++a) {
            low[static_cast<std::size_t>(a)] = static_cast<int>(std::ceil(centre[a] - radius / grid.spacing[a]));
            high[static_cast<std::size_t>(a)] = static_cast<int>(std::floor(centre[a] + radius / grid.spacing[a]));
        }
        const double scale = 1.0 / (radius * radius);
        for (int k = low[2]; k <= high[2]; ++k)
            for (int j = low[1]; j <= high[1]; ++j)
                for (int i = low[0]; i <= high[0]; ++i) {
                    const Vec3 offset = grid.spacing.cwiseProduct(Vec3(i, j, k) - centre);
                    const double inside = 1.0 - offset.squaredNorm() * scale;
                    if (inside <= 0.0)
                        continue;
                    const Label label = labels.voxels[grid.offset(std::clamp(i, 0, grid.size[0] - 1),
                        std::clamp(j, 0, grid.size[1] - 1), std::clamp(k, 0, grid.size[2] - 1))];
                    visit(label, offset, inside * inside * inside);
                }
    }

    /// Finds the change of inside(t) between a t that is inside and one that is outside.
    template <typename Inside> double bisect(double inside_t, double outside_t, Inside&& inside)
    {
        for (int n = 0; n < kBisections; ++n) {
            const double middle = 0.5 * (inside_t + outside_t);
            (inside(middle) ? inside_t : outside_t) = middle;
        }
        return 0.5 * (inside_t + outside_t);
    }

} // namespace

BodyProbe::BodyProbe(const mesh::LabelVolume& labels)
    : labels_(labels)
    , wall_(mesh::flagged_labels(labels.table, mesh::is_wall))
    , body_(mesh::flagged_labels(labels.table, [](const mesh::LabelInfo&) { return true; }))
{
    mesh::check_grid(labels.grid);
    const mesh::ImageGrid& grid = labels.grid;
    if (labels.voxels.size() != grid.voxel_count())
        throw InputError("the label volume's voxel count does not match its size");
    radius_ = std::max(kLeastKernelMm, kKernelVoxels * grid.spacing.maxCoeff());
    reach_ = grid.spacing.cwiseProduct(Vec3(grid.size[0], grid.size[1], grid.size[2])).norm() + 2.0 * radius_;
    // Whole-number sums are exact, so a mirrored or turned grid gives the same centroid to the last bits.
    Vec3 sum = Vec3::Zero();
    double count = 0.0;
    mesh::visit_voxels(labels, [&](int i, int j, int k, Label label) {
        if (wall_[label] != 0) {
            sum += Vec3(i, j, k);
            count += 1.0;
        }
    });
    if (count == 0.0)
        throw InputError("no voxel has a label of role wall: give the chest wall's labels (skin, muscle, ribs ...) the "
                         "role \"wall\"");
    wall_centroid_ = grid.world(sum / count);
}

double BodyProbe::share(const mesh::LabelFlags& mask, const Vec3& point) const
{
    return share_within(mask, point, radius_);
}

double BodyProbe::share_within(const mesh::LabelFlags& mask, const Vec3& point, double radius) const
{
    RETRACTOR_ASSERT(mask.size() == mesh::kLabelCount && radius > 0.0);
    const mesh::ImageGrid& grid = labels_.grid;
    const Vec3 centre = grid.index(point);
    for (int a = 0; a < 3; ++a) {
        const double margin = radius / grid.spacing[a];
        if (!(centre[a] > -margin && centre[a] < grid.size[static_cast<std::size_t>(a)] - 1 + margin))
            return 0.0;
    }
    double inside = 0.0, all = 0.0;
    visit_ball(labels_, point, radius, [&](Label label, const Vec3&, double weight) {
        all += weight;
        if (mask[label] != 0)
            inside += weight;
    });
    return all > 0.0 ? inside / all : 0.0;
}

/// The passage from body to outside for the wider kernel, nearest to the passage for the narrow kernel.
double BodyProbe::averaged_skin_distance(const Vec3& from, const Vec3& direction, double distance) const
{
    const double radius = kSkinKernelFactor * radius_;
    const auto inside = [&](double t) { return share_within(body_, from + t * direction, radius) >= 0.5; };
    const int reach = static_cast<int>(std::ceil(radius / kStepMm));
    for (int off = 0; off <= reach; ++off)
        for (const int n : { off, -off })
            if (inside(distance + n * kStepMm) && !inside(distance + (n + 1) * kStepMm))
                return bisect(distance + n * kStepMm, distance + (n + 1) * kStepMm, inside);
    return distance;
}

std::optional<double> BodyProbe::skin_along(const Vec3& from, const Vec3& direction) const
{
    const auto inside = [&](double t) { return share(wall_, from + t * direction) >= 0.5; };
    for (int n = static_cast<int>(std::ceil(reach_ / kStepMm)); n >= 0; --n)
        if (inside(n * kStepMm))
            return averaged_skin_distance(from, direction, bisect(n * kStepMm, (n + 1) * kStepMm, inside));
    return std::nullopt;
}

std::optional<double> BodyProbe::first_skin_along(const Vec3& from, const Vec3& direction) const
{
    constexpr double kGapMm = 3.0; // a pore or a speck is no skin
    const auto inside = [&](double t) { return share(wall_, from + t * direction) >= 0.5; };
    double last_inside = -1.0;
    for (int n = 0; n * kStepMm <= reach_; ++n) {
        if (inside(n * kStepMm))
            last_inside = n * kStepMm;
        else if (last_inside >= 0.0 && n * kStepMm - last_inside > kGapMm)
            return averaged_skin_distance(from, direction, bisect(last_inside, last_inside + kStepMm, inside));
    }
    return skin_along(from, direction);
}

std::optional<Vec3> BodyProbe::skin_seen(const Vec3& from, const Vec3& direction) const
{
    const mesh::ImageGrid& grid = labels_.grid;
    const Vec3 middle = grid.world(0.5 * Vec3(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1));
    const double nearest = (middle - from).dot(direction); // the image lies within half of reach_ of its middle
    const auto inside = [&](double t) { return share(body_, from + t * direction) >= 0.5; };
    const double first = std::max(0.0, nearest - 0.5 * reach_), last = nearest + 0.5 * reach_;
    for (double t = first; t <= last; t += kStepMm) {
        if (body_[mesh::label_at(labels_, from + t * direction)] == 0)
            continue;
        // The smooth skin lies near the first voxel, unless that is a speck.
        for (double s = std::max(0.0, t - radius_); s <= t + 2.0 * radius_; s += kStepMm)
            if (inside(s))
                return from + (s > 0.0 ? bisect(s, s - kStepMm, inside) : s) * direction;
    }
    return std::nullopt;
}

std::optional<double> BodyProbe::wall_thickness(const Vec3& skin, const Vec3& direction, double limit_mm) const
{
    const auto inside = [&](double t) { return share(wall_, skin + t * direction) >= 0.5; };
    const int cavity_steps = static_cast<int>(kCavityMm / kStepMm);
    double last_inside = 0.0;
    int outside = 0;
    for (int n = static_cast<int>(std::ceil(radius_ / kStepMm)); n * kStepMm <= limit_mm; ++n) {
        if (inside(n * kStepMm)) {
            last_inside = n * kStepMm;
            outside = 0;
        } else if (++outside == cavity_steps && last_inside > 0.0)
            return bisect(last_inside, last_inside + kStepMm, inside);
    }
    return std::nullopt;
}

Vec3 BodyProbe::skin_normal(const Vec3& skin, double radius_mm) const
{
    // A weighted straight-line fit of the body's indicator, which is also correct where the image ends.
    Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
    Eigen::Vector4d values = Eigen::Vector4d::Zero();
    visit_ball(labels_, skin, std::max(radius_mm, 2.0 * radius_), [&](Label label, const Vec3& offset, double weight) {
        const Eigen::Vector4d row(1.0, offset.x(), offset.y(), offset.z());
        moments += weight * row * row.transpose();
        if (body_[label] != 0)
            values += weight * row;
    });
    const Vec3 slope = moments.ldlt().solve(values).tail<3>();
    if (!slope.allFinite() || slope.norm() < 1e-6)
        throw InputError("no skin near the point " + in_words(skin));
    return -(labels_.grid.direction * slope).normalized();
}

Vec3 BodyProbe::project_to_skin(const Vec3& point) const
{
    const auto refuse = [&]() -> Vec3 { throw InputError("no skin found near the point " + in_words(point)); };
    if (!point.allFinite() || (point - wall_centroid_).norm() < radius_)
        return refuse();
    const Vec3 outward = (point - wall_centroid_).normalized();
    const auto first = skin_along(wall_centroid_, outward);
    if (!first)
        return refuse();
    Vec3 skin = wall_centroid_ + *first * outward;
    // Fixed-point iteration: the normal at the nearest point leads back to the given point.
    for (int n = 0; n < 12; ++n) {
        const Vec3 normal = skin_normal(skin);
        const Vec3 start = point - kProjectionReachMm * normal;
        const auto inside = [&](double t) { return share(wall_, start + t * normal) >= 0.5; };
        double found = -1.0;
        for (double t = 2.0 * kProjectionReachMm; t >= 0.0 && found < 0.0; t -= kStepMm)
            if (inside(t))
                found = bisect(t, t + kStepMm, inside);
        if (found < 0.0)
            return refuse();
        skin = start + averaged_skin_distance(start, normal, found) * normal;
    }
    return skin;
}

} // namespace retractor::planner
