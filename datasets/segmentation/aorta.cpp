#include "datasets/segmentation/aorta.h"

#include "datasets/segmentation/midline.h"
#include "mesh/base/assert.h"
#include "mesh/base/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace retractor::datasets::segmentation {

namespace {

    constexpr int kContrastHu = 150; // above every tissue except bone
    constexpr int kPlaneStep = 2;

    /// The image that scores the discs: HU clamped to the range that matters. Bone and air have the lowest value.
    struct Look {
        const WorkingImage& image;
        std::vector<float> value;
        bool contrast = false;

        float at(double i, double j, double k) const
        {
            const int x = static_cast<int>(std::lround(i));
            const int y = static_cast<int>(std::lround(j));
            const int z = static_cast<int>(std::lround(k));
            return image.grid.contains(x, y, z) ? value[image.grid.offset(x, y, z)] : kLow;
        }
        static constexpr float kLow = -100.0F;
    };

    Look look_at(const AortaInput& input)
    {
        constexpr double kContrastMl = 80.0; // more than all calcifications, less than an aorta
        Look look { input.image, std::vector<float>(input.image.hu.size(), Look::kLow), false };
        Mask bright(input.room.size());
        for (std::size_t v = 0; v < bright.size(); ++v)
            bright[v] = input.room[v] != 0 && input.image.hu[v] > kContrastHu ? 1 : 0;
        look.contrast = volume_ml(input.image.extent(), bright) > kContrastMl;
        const float high = look.contrast ? 350.0F : 80.0F;
        for (std::size_t v = 0; v < look.value.size(); ++v)
            if (input.bones[v] == 0 && input.room[v] != 0)
                look.value[v] = std::clamp(static_cast<float>(input.image.hu[v]), Look::kLow, high);
        return look;
    }

    struct Disc {
        Vec3 centre = Vec3::Zero(); ///< index in the working grid
        double radius = 0.0; ///< mm
    };

    constexpr int kSpokes = 16;

    /// Likeness of a disc to the section of a vessel. The unit axes u and w (index space scaled to mm) span the disc.
    double likeness(const Look& look, const Disc& disc, const Vec3& u, const Vec3& w)
    {
        constexpr double kRim = 3.0; // mm outside the disc
        constexpr double kLeastSoft = 5.0;
        constexpr double kLeastContrast = 130.0;
        const Vec3& spacing = look.image.grid.spacing;
        std::array<double, 2 * kSpokes + 1> inside {};
        double mean = inside[0] = look.at(disc.centre.x(), disc.centre.y(), disc.centre.z());
        std::array<double, kSpokes> outside {};
        for (int s = 0; s < kSpokes; ++s) {
            const double turn = 2.0 * std::numbers::pi * s / kSpokes;
            const Vec3 out = (std::cos(turn) * u + std::sin(turn) * w).cwiseQuotient(spacing);
            const auto sample = [&](double r) {
                const Vec3 p = disc.centre + r * out;
                return static_cast<double>(look.at(p.x(), p.y(), p.z()));
            };
            const auto n = static_cast<std::size_t>(s);
            mean += inside[1 + 2 * n] = sample(0.5 * disc.radius);
            mean += inside[2 + 2 * n] = sample(0.85 * disc.radius);
            outside[n] = sample(disc.radius + kRim);
        }
        mean /= static_cast<double>(inside.size());
        double spread = 0.0;
        for (const double value : inside)
            spread += std::abs(value - mean);
        spread /= static_cast<double>(inside.size());
        double edge = 0.0;
        for (const double value : outside)
            edge += std::clamp(mean - value, 0.0, 120.0);
        edge /= kSpokes;
        const double least = look.contrast ? kLeastContrast : kLeastSoft;
        return edge - 1.5 * spread - std::max(0.0, least - mean);
    }

    /// The search region of one plane: a window of centres, and a likely centre.
    struct Window {
        int k = 0;
        std::array<int, 2> low {};
        std::array<int, 2> high {};
        std::array<double, 2> likely {};
    };

    constexpr std::array<double, 7> kRadii { 8.0, 10.0, 12.0, 14.0, 16.0, 18.5, 21.0 };

    constexpr float kNever = -1e9F; ///< score of a state outside its window

    /// The states of one plane: every centre in the box of all windows, with every radius.
    struct StateGrid {
        std::array<int, 2> low { std::numeric_limits<int>::max(), std::numeric_limits<int>::max() };
        int nx = 0, ny = 0;
        static constexpr int kRadiusCount = static_cast<int>(kRadii.size());

        bool contains(int x, int y, int r) const
        {
            return x >= 0 && y >= 0 && r >= 0 && x < nx && y < ny && r < kRadiusCount;
        }
        std::size_t state(int x, int y, int r) const
        {
            RETRACTOR_ASSERT(contains(x, y, r));
            return (static_cast<std::size_t>(r) * static_cast<std::size_t>(ny) + static_cast<std::size_t>(y))
                * static_cast<std::size_t>(nx)
                + static_cast<std::size_t>(x);
        }
        std::size_t count() const { return state(nx - 1, ny - 1, kRadiusCount - 1) + 1; }
        Disc disc(std::size_t state, int k) const
        {
            const auto row = static_cast<std::size_t>(nx), column = static_cast<std::size_t>(ny);
            return { Vec3(static_cast<double>(state % row) + low[0], static_cast<double>(state / row % column) + low[1],
                         k),
                kRadii[state / (row * column)] };
        }
    };

    StateGrid states_of(const std::vector<Window>& windows)
    {
        StateGrid grid;
        std::array<int, 2> high { 0, 0 };
        for (const Window& w : windows)
            for (std::size_t a = 0; a < 2; ++a) {
                grid.low[a] = std::min(grid.low[a], w.low[a]);
                high[a] = std::max(high[a], w.high[a]);
            }
        grid.nx = high[0] - grid.low[0] + 1;
        grid.ny = high[1] - grid.low[1] + 1;
        return grid;
    }

    /// Scores all states of one window.
    std::vector<float> scores_in(
        const Look& look, const Window& w, const StateGrid& grid, std::size_t first_radius, double pull_per_mm)
    {
        const Vec3& spacing = look.image.grid.spacing;
        std::vector<float> score(grid.count(), kNever);
        for (auto r = static_cast<int>(first_radius); r < StateGrid::kRadiusCount; ++r)
            for (int y = w.low[1]; y <= w.high[1]; ++y)
                for (int x = w.low[0]; x <= w.high[0]; ++x) {
                    const Disc disc { Vec3(x, y, w.k), kRadii[static_cast<std::size_t>(r)] };
                    const double away = std::hypot((x - w.likely[0]) * spacing.x(), (y - w.likely[1]) * spacing.y());
                    score[grid.state(x - grid.low[0], y - grid.low[1], r)]
                        = static_cast<float>(likeness(look, disc, Vec3::UnitX(), Vec3::UnitY()) - pull_per_mm * away);
                }
        return score;
    }

    /// A state of the previous plane, and the value of the best chain that comes from it.
    struct Predecessor {
        std::int32_t state = -1;
        float value = 2.0F * kNever;
    };

    /// Finds the best of the states from which one step leads to (x, y, r).
    Predecessor best_predecessor(const StateGrid& grid, const std::vector<float>& best, int x, int y, int r)
    {
        constexpr double kStepCost = 2.0; // per voxel of shift between windows, and per step of radius
        constexpr int kShift = 2;
        Predecessor found;
        for (int dr = -1; dr <= 1; ++dr)
            for (int dy = -kShift; dy <= kShift; ++dy)
                for (int dx = -kShift; dx <= kShift; ++dx) {
                    if (!grid.contains(x + dx, y + dy, r + dr))
                        continue;
                    const std::size_t there = grid.state(x + dx, y + dy, r + dr);
                    const float value
                        = best[there] - static_cast<float>(kStepCost * (std::abs(dx) + std::abs(dy) + std::abs(dr)));
                    if (value > found.value)
                        found = { static_cast<std::int32_t>(there), value };
                }
        return found;
    }

    /// Adds the scores of one plane to the best chains that end in the plane before. Returns the predecessors.
    std::vector<std::int32_t> advance(
        const StateGrid& grid, const std::vector<float>& score, std::vector<float>& best, int threads)
    {
        RETRACTOR_ASSERT(score.size() == grid.count() && best.size() == grid.count());
        std::vector<std::int32_t> from(score.size(), -1);
        std::vector<float> next(score.size(), kNever);
        for_planes(StateGrid::kRadiusCount, threads, [&](int r) {
            for (int y = 0; y < grid.ny; ++y)
                for (int x = 0; x < grid.nx; ++x) {
                    const std::size_t here = grid.state(x, y, r);
                    if (score[here] <= kNever)
                        continue;
                    const Predecessor before = best_predecessor(grid, best, x, y, r);
                    from[here] = before.state;
                    next[here] = score[here] + before.value;
                }
        });
        best = std::move(next);
        return from;
    }

    /// Finds the best chain of discs through the windows by dynamic programming.
    std::vector<Disc> best_chain(
        const Look& look, const std::vector<Window>& windows, std::size_t first_radius, double pull_per_mm, int threads)
    {
        RETRACTOR_ASSERT(first_radius < kRadii.size());
        const StateGrid grid = states_of(windows);
        if (windows.empty() || grid.nx <= 0 || grid.ny <= 0)
            return {};
        std::vector<std::vector<float>> score(windows.size());
        for_planes(static_cast<int>(windows.size()), threads, [&](int n) {
            const auto w = static_cast<std::size_t>(n);
            score[w] = scores_in(look, windows[w], grid, first_radius, pull_per_mm);
        });
        std::vector<std::vector<std::int32_t>> from(windows.size());
        std::vector<float> best = score[0];
        for (std::size_t n = 1; n < windows.size(); ++n)
            from[n] = advance(grid, score[n], best, threads);
        auto at = static_cast<std::size_t>(std::max_element(best.begin(), best.end()) - best.begin());
        if (best[at] <= kNever)
            return {};
        std::vector<Disc> chain(windows.size());
        for (std::size_t n = windows.size(); n-- > 0;) {
            chain[n] = grid.disc(at, windows[n].k);
            if (n > 0) {
                RETRACTOR_ASSERT(from[n][at] >= 0);
                at = static_cast<std::size_t>(from[n][at]);
            }
        }
        return chain;
    }

    /// Landmarks of the search, as indices.
    struct Landmarks {
        std::vector<double> spine_x; ///< middle of the spine per plane
        std::vector<double> spine_y; ///< front of the spine per plane
        int carina = 0; ///< plane of the carina
        double sternum_y = 0.0; ///< back of the sternum at the height of the carina
        int lowest = 0; ///< lowest plane of the room
    };

    Window window_in(const WorkingImage& image, int k, const Vec3& low_mm, const Vec3& high_mm, double x, double y)
    {
        Window w { k, {}, {}, { x, y } };
        const std::array<double, 2> middle { x, y };
        for (int axis = 0; axis < 2; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            w.low[a] = std::max(1, static_cast<int>(middle[a] + low_mm[axis] / image.grid.spacing[axis]));
            w.high[a] = std::min(
                image.grid.size[a] - 2, static_cast<int>(middle[a] + high_mm[axis] / image.grid.spacing[axis]));
        }
        return w;
    }

    /// Finds the bow from the ascending to the descending aorta that looks most like a vessel.
    std::vector<Disc> best_arch(const Look& look, const Disc& ascending, const Disc& descending)
    {
        constexpr int kSteps = 14;
        const Vec3& spacing = look.image.grid.spacing;
        std::vector<Disc> best;
        double most = -std::numeric_limits<double>::infinity();
        for (double height = 8.0; height <= 50.0; height += 3.0)
            for (double bulge = -6.0; bulge <= 24.0; bulge += 5.0) {
                std::vector<Disc> arch;
                double sum = 0.0;
                const auto place = [&](double t) {
                    const double lift = std::sin(std::numbers::pi * t);
                    // The bow is steep at both ends and flat on top.
                    const double rise = std::sqrt(std::max(0.0, 1.0 - std::pow(2.0 * t - 1.0, 2.0)));
                    return Vec3(ascending.centre + t * (descending.centre - ascending.centre)
                        + Vec3(bulge * lift, 0.0, height * rise).cwiseQuotient(spacing));
                };
                for (int n = 1; n < kSteps; ++n) {
                    const double t = static_cast<double>(n) / kSteps;
                    const Disc disc { place(t), ascending.radius + t * (descending.radius - ascending.radius) };
                    const Vec3 along = (place(t + 0.02) - place(t - 0.02)).cwiseProduct(spacing).normalized();
                    const Vec3 side
                        = along.cross(std::abs(along.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitX()).normalized();
                    sum += likeness(look, disc, side, along.cross(side));
                    arch.push_back(disc);
                }
                if (sum > most) {
                    most = sum;
                    best = std::move(arch);
                }
            }
        return best;
    }

    /// The union of balls along the chain, with `factor` times the radius of the discs plus `more_mm`.
    Mask tube(const WorkingImage& image, const std::vector<Disc>& chain, double factor, double more_mm)
    {
        Mask out(image.hu.size(), 0);
        for (std::size_t n = 0; n + 1 < chain.size(); ++n)
            for (const double t : { 0.0, 0.25, 0.5, 0.75, 1.0 }) {
                const Vec3 centre = chain[n].centre + t * (chain[n + 1].centre - chain[n].centre);
                const double radius
                    = factor * (chain[n].radius + t * (chain[n + 1].radius - chain[n].radius)) + more_mm;
                const Vec3 reach = Vec3::Constant(radius).cwiseQuotient(image.grid.spacing);
                const Eigen::Vector3i low = (centre - reach).array().floor().cast<int>();
                const Eigen::Vector3i high = (centre + reach).array().ceil().cast<int>();
                for (int k = low.z(); k <= high.z(); ++k)
                    for (int j = low.y(); j <= high.y(); ++j)
                        for (int i = low.x(); i <= high.x(); ++i)
                            if (image.grid.contains(i, j, k)
                                && (Vec3(i, j, k) - centre).cwiseProduct(image.grid.spacing).norm() <= radius)
                                out[image.grid.offset(i, j, k)] = 1;
            }
        return out;
    }

    Landmarks landmarks_of(const AortaInput& input)
    {
        // Share of the lungs' height, used when the windpipe could not be followed.
        constexpr double kCarinaShare = 0.62;
        const Extent extent = input.image.extent();
        Landmarks marks;
        const std::vector<PlaneExtents> spine = plane_extents(extent, input.spine);
        for (const PlaneExtents& plane : spine)
            marks.spine_x.push_back(plane.empty() ? std::nan("") : 0.5 * (plane.low_x + plane.high_x));
        const int reach = static_cast<int>(15.0 / extent.spacing[2]);
        marks.spine_x = smooth_line(marks.spine_x, reach);
        marks.spine_y = smooth_line(spine_front(extent, input.spine, marks.spine_x), reach);
        const auto [low, high] = plane_range(plane_extents(extent, input.lungs.both()));
        marks.carina = input.lungs.carina_z
            ? static_cast<int>(std::lround(input.image.grid.index(Vec3(0.0, 0.0, *input.lungs.carina_z)).z()))
            : low + static_cast<int>(kCarinaShare * (high - low));
        const std::vector<PlaneExtents> sternum = plane_extents(extent, input.sternum);
        const auto at = static_cast<std::size_t>(std::clamp(marks.carina, 0, extent.size[2] - 1));
        marks.sternum_y = sternum[at].empty() ? marks.spine_y[at] - 95.0 / extent.spacing[1] : sternum[at].high_y;
        marks.lowest = std::max(0, plane_range(plane_extents(extent, input.room)).first);
        return marks;
    }

    std::vector<Disc> follow(const AortaInput& input, const Look& look, const Landmarks& marks, int threads)
    {
        constexpr double kIntoArch = 4.0; // mm above the carina, where both limbs are still upright
        constexpr double kRoot = 45.0; // mm below the carina, at the root of the aorta
        constexpr double kLeastLikeness = 25.0; // HU of difference at the edge
        // The window, in mm from the front of the spine. In old patients the aorta leaves the spine to the left and to
        // the back.
        const Vec3 kLow(-14.0, -34.0, 0.0);
        const Vec3 kHigh(62.0, 42.0, 0.0);
        const WorkingImage& image = input.image;
        const double dz = image.grid.spacing.z();
        const int top = marks.carina + static_cast<int>(kIntoArch / dz);
        std::vector<Window> windows;
        for (int k = marks.lowest; k <= top; k += kPlaneStep) {
            const auto n = static_cast<std::size_t>(k);
            Window w = window_in(image, k, kLow, kHigh, marks.spine_x[n], marks.spine_y[n]);
            w.likely
                = { marks.spine_x[n] + 16.0 / image.grid.spacing.x(), marks.spine_y[n] - 6.0 / image.grid.spacing.y() };
            windows.push_back(w);
        }
        std::vector<Disc> descending = best_chain(look, windows, 0, 0.2, threads);
        const auto unlike
            = [&](const Disc& disc) { return likeness(look, disc, Vec3::UnitX(), Vec3::UnitY()) < kLeastLikeness; };
        // Discs below the lowest disc that looks like a vessel are dropped.
        descending.erase(descending.begin(), std::find_if_not(descending.begin(), descending.end(), unlike));
        windows.clear();
        for (int k = top - static_cast<int>(kRoot / dz); k <= top; k += kPlaneStep) {
            if (k < 0)
                continue;
            const auto n = static_cast<std::size_t>(std::min(k, image.grid.size[2] - 1));
            const double y = marks.sternum_y + 0.42 * (marks.spine_y[n] - marks.sternum_y);
            windows.push_back(window_in(image, k, Vec3(-26.0, -28.0, 0.0), Vec3(26.0, 24.0, 0.0),
                marks.spine_x[n] - 10.0 / image.grid.spacing.x(), y));
        }
        std::vector<Disc> ascending = best_chain(look, windows, 2, 0.6, threads);
        if (descending.empty() || ascending.empty())
            return {};
        std::vector<Disc> chain = ascending;
        const std::vector<Disc> arch = best_arch(look, ascending.back(), descending.back());
        chain.insert(chain.end(), arch.begin(), arch.end());
        chain.insert(chain.end(), descending.rbegin(), descending.rend());
        return chain;
    }

} // namespace

Aorta find_aorta(const AortaInput& input, int threads)
{
    const Extent extent = input.image.extent();
    RETRACTOR_ASSERT(input.room.size() == extent.voxel_count() && input.bones.size() == extent.voxel_count());
    Aorta aorta;
    aorta.mask.assign(input.room.size(), 0);
    const Landmarks marks = landmarks_of(input);
    if (std::isnan(marks.spine_y.front()) || marks.carina <= marks.lowest || marks.carina >= extent.size[2] - 2)
        return aorta;
    const Look look = look_at(input);
    const std::vector<Disc> chain = follow(input, look, marks, threads);
    if (chain.empty())
        return aorta;
    std::vector<float> along;
    for (const Disc& disc : chain) {
        along.push_back(look.at(disc.centre.x(), disc.centre.y(), disc.centre.z()));
        aorta.radius_mm += disc.radius / static_cast<double>(chain.size());
    }
    aorta.usual_hu = upper_median(along);
    aorta.contrast = look.contrast && aorta.usual_hu > kContrastHu;
    if (aorta.contrast) {
        // Share of the contrast in the aorta; darker voxels are more likely heart or vein.
        constexpr double kShare = 0.76;
        constexpr double kRoom = 14.0; // mm around the tube, for bulges
        constexpr double kNeck = 3.0;
        Mask bright = common(tube(input.image, chain, 1.1, kRoom), input.room);
        for (std::size_t v = 0; v < bright.size(); ++v)
            if (input.image.hu[v] < kShare * aorta.usual_hu)
                bright[v] = 0;
        aorta.mask = reached_from(extent, opened(extent, bright, kNeck), tube(input.image, chain, 0.5, 0.0));
    } else {
        aorta.mask = common(tube(input.image, chain, 1.0, 1.0), input.room);
        for (std::size_t v = 0; v < aorta.mask.size(); ++v)
            if (input.image.hu[v] < -40)
                aorta.mask[v] = 0;
        aorta.mask = largest_piece(extent, aorta.mask);
    }
    return aorta;
}

} // namespace retractor::datasets::segmentation
