// Computes the place of the rib cage: the distance (mm) outside the convex hulls of the lungs' sections. The hull is
// extended below the lungs, where ribs still cover liver and spleen.

#include "datasets/segmentation/bones/bones_steps.h"

#include "mesh/base/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace retractor::datasets::segmentation {

namespace {

    using Point = std::array<int, 2>;

    /// The corners of the convex hull, counter-clockwise (monotone chain).
    std::vector<Point> convex_hull(std::vector<Point> points)
    {
        std::sort(points.begin(), points.end());
        points.erase(std::unique(points.begin(), points.end()), points.end());
        if (points.size() < 3)
            return points;
        const auto turn = [](const Point& a, const Point& b, const Point& c) {
            return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        };
        std::vector<Point> hull;
        for (int pass = 0; pass < 2; ++pass) {
            const std::size_t start = hull.size();
            for (const Point& p : points) {
                while (hull.size() >= start + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0)
                    hull.pop_back();
                hull.push_back(p);
            }
            hull.pop_back();
            std::reverse(points.begin(), points.end());
        }
        return hull;
    }

    /// Fills a convex polygon in slice k.
    void fill(const mesh::ImageGrid& grid, const std::vector<Point>& hull, int k, Mask& mask)
    {
        for (int j = 0; j < grid.size[1]; ++j) {
            double low = std::numeric_limits<double>::infinity(), high = -low;
            for (std::size_t n = 0; n < hull.size(); ++n) {
                const Point &a = hull[n], &b = hull[(n + 1) % hull.size()];
                if (std::min(a[1], b[1]) > j || std::max(a[1], b[1]) < j)
                    continue;
                if (a[1] == b[1]) {
                    low = std::min<double>(low, std::min(a[0], b[0]));
                    high = std::max<double>(high, std::max(a[0], b[0]));
                } else {
                    const double x = a[0] + static_cast<double>(b[0] - a[0]) * (j - a[1]) / (b[1] - a[1]);
                    low = std::min(low, x);
                    high = std::max(high, x);
                }
            }
            for (int i = static_cast<int>(std::ceil(low - 1e-9)); i <= high + 1e-9; ++i)
                mask[grid.offset(i, j, k)] = 1;
        }
    }

    std::vector<std::vector<Point>> lung_outlines(const CoarseImage& image, int& widest)
    {
        constexpr double kLeastSection = 600.0; // mm2; a smaller section is only the windpipe
        const mesh::ImageGrid& grid = image.grid;
        std::vector<std::vector<Point>> outlines(static_cast<std::size_t>(grid.size[2]));
        std::size_t most = 0;
        for (int k = 0; k < grid.size[2]; ++k) {
            std::vector<Point> ends; // ends of the rows
            std::size_t count = 0;
            for (int j = 0; j < grid.size[1]; ++j) {
                int first = -1, last = -1;
                for (int i = 0; i < grid.size[0]; ++i)
                    if (image.lungs[grid.offset(i, j, k)]) {
                        first = first < 0 ? i : first;
                        last = i;
                        ++count;
                    }
                if (first >= 0) {
                    ends.push_back({ first, j });
                    ends.push_back({ last, j });
                }
            }
            if (static_cast<double>(count) * grid.spacing.x() * grid.spacing.y() < kLeastSection)
                continue;
            outlines[static_cast<std::size_t>(k)] = convex_hull(std::move(ends));
            if (count > most) {
                most = count;
                widest = k;
            }
        }
        return outlines;
    }

    /// Extends the hull to the ribs. The hull is too small when lungs do not reach the chest wall (fluid,
    /// consolidation). Seen from the middle, the first bone outside the hull is a rib or, between two ribs, the
    /// scapula. The nearest bone over the height of one intercostal space is therefore a rib, and the hull is extended
    /// to this bone.
    void extend_to_ribs(const CoarseImage& image, const Cage& cage, std::vector<std::vector<Point>>& outlines)
    {
        constexpr int kRays = 90, kBoneHu = 200;
        constexpr double kInward = 12.0, kOutward = 32.0, kWindow = 12.0, kPleura = 5.0, kWorth = 4.0,
                         kUnderClavicles = 25.0; // mm
        constexpr double kFromSpine = 24.0; // degrees; nearer to the back the rays meet vertebrae
        constexpr double kNothing = 1e9;
        const mesh::ImageGrid& grid = image.grid;
        const auto slices = static_cast<std::size_t>(grid.size[2]);
        std::vector<std::array<double, kRays>> hit(slices), hull_radius(slices);
        Mask hull(grid.voxel_count(), 0);
        const auto ray = [](int n) {
            const double a = 2.0 * std::numbers::pi * n / kRays;
            return Eigen::Vector2d(std::sin(a), std::cos(a));
        };
        const auto voxel = [&](const Eigen::Vector2d& p, int k) {
            const Vec3 x = grid.index(Vec3(p.x(), p.y(), grid.origin.z()));
            return std::array<int, 3> { static_cast<int>(std::lround(x[0])), static_cast<int>(std::lround(x[1])), k };
        };
        for (int k = 0; k < grid.size[2]; ++k) {
            const auto& outline = outlines[static_cast<std::size_t>(k)];
            auto& hits = hit[static_cast<std::size_t>(k)];
            hits.fill(kNothing);
            if (outline.empty())
                continue;
            fill(grid, outline, k, hull);
            const Eigen::Vector2d centre = cage.centre(grid.origin.z() + grid.spacing.z() * k);
            for (int n = 0; n < kRays; ++n) {
                double edge = 0.0;
                for (double r = 0.0; r < 250.0; r += 2.0) {
                    const auto v = voxel(centre + r * ray(n), k);
                    if (!grid.contains(v[0], v[1], v[2]))
                        break;
                    if (hull[grid.offset(v[0], v[1], v[2])])
                        edge = r;
                }
                hull_radius[static_cast<std::size_t>(k)][static_cast<std::size_t>(n)] = edge;
                if (360.0 * std::min(n, kRays - n) / kRays < kFromSpine || edge == 0.0)
                    continue;
                for (double r = edge - kInward; r < edge + kOutward; r += 1.5) {
                    const auto v = voxel(centre + r * ray(n), k);
                    if (!grid.contains(v[0], v[1], v[2]))
                        break;
                    if (image.body[grid.offset(v[0], v[1], v[2])]
                        && image.hu[grid.offset(v[0], v[1], v[2])] > kBoneHu) {
                        hits[static_cast<std::size_t>(n)] = r;
                        break;
                    }
                }
            }
        }
        const int window = static_cast<int>(std::lround(kWindow / grid.spacing.z()));
        for (int k = 0; k < grid.size[2]; ++k) {
            auto& outline = outlines[static_cast<std::size_t>(k)];
            const double z = grid.origin.z() + grid.spacing.z() * k;
            if (outline.empty() || z > cage.sternum.top() - kUnderClavicles)
                continue;
            const Eigen::Vector2d centre = cage.centre(z);
            for (int n = 0; n < kRays; ++n) {
                double nearest = kNothing;
                for (int c = std::max(0, k - window); c <= std::min(grid.size[2] - 1, k + window); ++c)
                    nearest = std::min(nearest, hit[static_cast<std::size_t>(c)][static_cast<std::size_t>(n)]);
                nearest -= kPleura;
                if (nearest > 0.5 * kNothing
                    || nearest < hull_radius[static_cast<std::size_t>(k)][static_cast<std::size_t>(n)] + kWorth)
                    continue;
                const auto v = voxel(centre + nearest * ray(n), k);
                if (grid.contains(v[0], v[1], v[2]))
                    outline.push_back({ v[0], v[1] });
            }
            outline = convex_hull(std::move(outline));
        }
    }

    struct Section {
        double shift = 0.0, half_width = 0.0; ///< mm
    };

    double share_of(std::vector<double> values, std::size_t tenths)
    {
        return value_of_rank(values, (values.size() - 1) * tenths / 10);
    }

    /// Measures the sides of the vertebral body in its front half, where no rib touches the body. When one side does
    /// not end (the aorta with contrast touches it), the other side counts for both.
    Section vertebra_section(const CoarseImage& image, const Eigen::Vector2d& middle, int k)
    {
        constexpr double kWidest = 30.0, kStep = 0.75, kLikely = 24.0; // mm
        constexpr int kBoneHu = 140;
        const mesh::ImageGrid& grid = image.grid;
        std::vector<double> shifts, widths;
        for (const double y : { -9.0, -6.0, -3.0, 0.0 }) {
            std::array<double, 2> side {};
            for (std::size_t s = 0; s < 2; ++s) {
                double x = 3.0;
                for (; x < kWidest; x += kStep) {
                    const Vec3 at = grid.index(Vec3(middle.x() + (s == 0 ? -x : x), middle.y() + y, grid.origin.z()));
                    const int i = static_cast<int>(std::lround(at.x())), j = static_cast<int>(std::lround(at.y()));
                    if (!grid.contains(i, j, k) || image.hu[grid.offset(i, j, k)] < kBoneHu)
                        break;
                }
                side[s] = x;
            }
            const double most = std::max(side[0], side[1]), least = std::min(side[0], side[1]);
            const bool runs_on = most >= kWidest;
            widths.push_back(runs_on ? std::min(least, kLikely) : 0.5 * (most + least));
            shifts.push_back(runs_on ? 0.0 : 0.5 * (side[1] - side[0]));
        }
        return { share_of(shifts, 5), share_of(widths, 8) };
    }

    /// Moves the spine's path to the middle of the vertebral bodies and returns their half-widths. Both are medians
    /// over about the height of a vertebra.
    std::vector<double> centre_on_vertebrae(const CoarseImage& image, MidlinePath& spine)
    {
        constexpr double kNarrowest = 11.0, kWindow = 18.0, kMostShift = 10.0; // mm
        const mesh::ImageGrid& grid = image.grid;
        const int half = static_cast<int>(std::lround(kWindow / grid.spacing.z()));
        const auto smooth = [&](const std::vector<double>& raw, std::size_t tenths) {
            std::vector<double> out;
            for (int k = 0; k < grid.size[2]; ++k)
                out.push_back(share_of(
                    { raw.begin() + std::max(0, k - half), raw.begin() + std::min(grid.size[2], k + half + 1) },
                    tenths));
            return out;
        };
        std::vector<double> widths;
        for (int pass = 0; pass < 2; ++pass) {
            std::vector<double> shifts;
            widths.clear();
            for (int k = 0; k < grid.size[2]; ++k) {
                const Section section = vertebra_section(image, spine(grid.origin.z() + grid.spacing.z() * k), k);
                shifts.push_back(section.shift);
                widths.push_back(section.half_width);
            }
            shifts = smooth(shifts, 5);
            for (int k = spine.first; pass == 0 && k <= spine.last; ++k)
                spine.at[static_cast<std::size_t>(k)].x()
                    += std::clamp(shifts[static_cast<std::size_t>(k)], -kMostShift, kMostShift);
        }
        widths = smooth(widths, 6);
        for (double& w : widths)
            w = std::max(w, kNarrowest);
        return widths;
    }

} // namespace

Eigen::Vector2d Cage::centre(double z) const { return 0.5 * (spine(z) + sternum(z)); }

double Cage::half_width(double z) const
{
    const auto k = std::lround((z - spine.z0) / spine.dz);
    return vertebra_half_width[static_cast<std::size_t>(
        std::clamp<long>(k, 0, static_cast<long>(vertebra_half_width.size()) - 1))];
}

double Cage::rib_limit(double z) const
{
    constexpr double kClose = 13.5, kFar = 18.0, kBelow = 40.0, kOver = 40.0; // mm
    return kClose + std::clamp((widest_z - kBelow - z) / kOver, 0.0, 1.0) * (kFar - kClose);
}

double Cage::angle(const Vec3& p) const
{
    const Eigen::Vector2d c = centre(p.z());
    return std::atan2(std::abs(p.x() - c.x()), p.y() - c.y()) * 180.0 / std::numbers::pi;
}

double Cage::outside_at(const Vec3& p) const
{
    const Vec3 x = grid.index(p);
    const auto near = [&](int a) {
        return std::clamp(static_cast<int>(std::lround(x[a])), 0, grid.size[static_cast<std::size_t>(a)] - 1);
    };
    return outside[grid.offset(near(0), near(1), near(2))];
}

Cage make_cage(const CoarseImage& image, const MidlinePath& spine, const MidlinePath& sternum)
{
    Cage cage { .grid = image.grid, .outside = {}, .spine = spine, .sternum = sternum, .vertebra_half_width = {} };
    cage.vertebra_half_width = centre_on_vertebrae(image, cage.spine);
    int widest = 0;
    auto outlines = lung_outlines(image, widest);
    for (int k = widest - 1; k >= 0; --k) {
        auto& here = outlines[static_cast<std::size_t>(k)];
        const auto& above = outlines[static_cast<std::size_t>(k) + 1];
        here.insert(here.end(), above.begin(), above.end());
        here = convex_hull(std::move(here));
    }
    extend_to_ribs(image, cage, outlines);
    Mask hull(image.grid.voxel_count(), 0);
    for (int k = 0; k < image.grid.size[2]; ++k)
        if (!outlines[static_cast<std::size_t>(k)].empty())
            fill(image.grid, outlines[static_cast<std::size_t>(k)], k, hull);
    cage.outside = distance_to(image.extent(), hull);
    for (auto& h : hull)
        h = !h;
    const std::vector<float> inside = distance_to(image.extent(), hull);
    for (std::size_t v = 0; v < inside.size(); ++v)
        cage.outside[v] -= inside[v];
    cage.widest_z = image.grid.origin.z() + image.grid.spacing.z() * widest;
    return cage;
}

// Boxes around the paths. A vertebral body reaches 12 to 22 mm to each side; arch and processes lie behind the body.
// The rib's head touches the rear corner of the body, and the rib's tubercle touches the transverse process 30 to 35 mm
// from the middle.
bool in_spine_core(const Cage& cage, const Vec3& p)
{
    const Eigen::Vector2d c = cage.spine(p.z());
    const double x = std::abs(p.x() - c.x()), y = p.y() - c.y(), half = cage.half_width(p.z());
    return (x < half - 4.0 && y > -14.0 && y <= 14.0) || (x < 10.0 && y > 14.0 && y < 60.0);
}

bool in_spine_reach(const Cage& cage, const Vec3& p)
{
    const Eigen::Vector2d c = cage.spine(p.z());
    const double x = std::abs(p.x() - c.x()), y = p.y() - c.y();
    const double half = cage.half_width(p.z()) + 4.0;
    if (y >= 75.0 || x >= (y < 12.0 ? half : 38.0))
        return false;
    const double depth = std::max(22.0, half); // the front of the body is round, and the aorta lies against it
    return y > 0.0 || x * x / (half * half) + y * y / (depth * depth) < 1.0;
}

bool in_sternum_core(const Cage& cage, const Vec3& p)
{
    if (p.z() < cage.sternum.bottom() || p.z() > cage.sternum.top())
        return false;
    const Eigen::Vector2d c = cage.sternum(p.z());
    return std::abs(p.x() - c.x()) < 7.0 && std::abs(p.y() - c.y()) < 8.0;
}

bool in_sternum_reach(const Cage& cage, const Vec3& p)
{
    constexpr double kManubrium = 55.0; // mm from the top; this part is wide
    if (p.z() < cage.sternum.bottom() - 6.0 || p.z() > cage.sternum.top() + 8.0)
        return false;
    const Eigen::Vector2d c = cage.sternum(p.z());
    const double half = p.z() > cage.sternum.top() - kManubrium ? 36.0 : 25.0;
    return std::abs(p.x() - c.x()) < half && std::abs(p.y() - c.y()) < 16.0;
}

} // namespace retractor::datasets::segmentation
