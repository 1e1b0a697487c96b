// Numbers the ribs by level, from the top. Both ribs of a level belong to one vertebra, so a rib that is missing on one
// side does not shift the numbers below.

#include "datasets/segmentation/bones/bones_steps.h"

#include "mesh/base/statistics.h"

#include <algorithm>
#include <cmath>

namespace retractor::datasets::segmentation {

namespace {

    constexpr int kMostRibs = 12;

    double z_at(const RibTrack& rib, double angle)
    {
        const auto above = std::upper_bound(rib.angle.begin(), rib.angle.end(), angle);
        const auto n = static_cast<std::size_t>(std::distance(rib.angle.begin(), above));
        if (n == 0)
            return rib.line.front().z();
        if (n == rib.angle.size())
            return rib.line.back().z();
        const double t = (angle - rib.angle[n - 1]) / (rib.angle[n] - rib.angle[n - 1]);
        return (1.0 - t) * rib.line[n - 1].z() + t * rib.line[n].z();
    }

    /// Height of rib a over rib b (mm), compared near the spine, at an angle that both ribs reach.
    double higher(const RibTrack& a, const RibTrack& b)
    {
        // Degrees. The angle is far from the spine, because the first two ribs start at the same height, side by side.
        constexpr double kClear = 70.0;
        const double angle = std::min(
            std::max({ kClear, a.angle.front(), b.angle.front() }), std::min(a.angle.back(), b.angle.back()));
        return z_at(a, angle) - z_at(b, angle);
    }

    double widest(const RibTrack& rib, const Cage& cage)
    {
        double most = 0.0;
        for (const Vec3& p : rib.line)
            most = std::max(most, std::abs(p.x() - cage.spine(p.z()).x()));
        return most;
    }

    struct Level {
        std::array<RibTrack*, 2> rib { nullptr, nullptr }; ///< left, right
    };

    /// True for a rib that starts beside the spine, and is not a part of another rib.
    bool starts_at_spine(const RibTrack& rib, const Cage& cage)
    {
        constexpr double kFarthestStart = 60.0, kLargestAngle = 60.0; // mm from the middle, degrees
        const Vec3& p = rib.line.front();
        return std::abs(p.x() - cage.spine(p.z()).x()) < kFarthestStart && cage.angle(p) < kLargestAngle;
    }

    std::vector<Level> levels_of(const std::array<std::vector<RibTrack*>, 2>& sides, double pitch)
    {
        constexpr double kSameLevel = 0.62; // share of the distance between two levels
        std::vector<Level> levels;
        std::array<std::size_t, 2> at { 0, 0 };
        while (at[0] < sides[0].size() || at[1] < sides[1].size()) {
            RibTrack* left = at[0] < sides[0].size() ? sides[0][at[0]] : nullptr;
            RibTrack* right = at[1] < sides[1].size() ? sides[1][at[1]] : nullptr;
            const double difference = left == nullptr ? -1e9 : right == nullptr ? 1e9 : higher(*left, *right);
            Level level;
            if (difference > -kSameLevel * pitch) {
                level.rib[0] = left;
                ++at[0];
            }
            if (difference < kSameLevel * pitch) {
                level.rib[1] = right;
                ++at[1];
            }
            levels.push_back(level);
        }
        return levels;
    }

    /// Height of level a over level b (mm), on a side with both ribs, else between the sides.
    double step(const Level& a, const Level& b)
    {
        double sum = 0.0;
        int n = 0;
        for (const RibTrack* upper : a.rib)
            for (const RibTrack* lower : b.rib)
                if (upper != nullptr && lower != nullptr && upper->left == lower->left) {
                    sum += higher(*upper, *lower);
                    ++n;
                }
        if (n > 0)
            return sum / n;
        const RibTrack* upper = a.rib[0] != nullptr ? a.rib[0] : a.rib[1];
        const RibTrack* lower = b.rib[0] != nullptr ? b.rib[0] : b.rib[1];
        return higher(*upper, *lower);
    }

} // namespace

void number_ribs(
    std::vector<RibTrack>& ribs, const Cage& cage, const mesh::ImageGrid& grid, std::vector<std::string>& warnings)
{
    std::array<std::vector<RibTrack*>, 2> sides;
    for (RibTrack& rib : ribs) {
        rib.number = 0;
        if (starts_at_spine(rib, cage))
            sides[rib.left ? 0 : 1].push_back(&rib);
    }
    std::vector<double> steps;
    for (auto& side : sides) {
        // Heights are compared in pairs, at places that both ribs reach. An insertion sort needs only such comparisons.
        for (std::size_t n = 1; n < side.size(); ++n)
            for (std::size_t m = n; m > 0 && higher(*side[m], *side[m - 1]) > 0.0; --m)
                std::swap(side[m], side[m - 1]);
        for (std::size_t n = 1; n < side.size(); ++n)
            steps.push_back(higher(*side[n - 1], *side[n]));
    }
    const double pitch = steps.empty() ? 25.0 : upper_median(steps);
    std::vector<Level> levels = levels_of(sides, pitch);
    if (levels.empty())
        return;

    // The levels get consecutive numbers. A step of nearly two pitches skips a number.
    constexpr double kSkip = 1.75;
    std::vector<int> number(levels.size(), 1);
    for (std::size_t n = 1; n < levels.size(); ++n) {
        const bool skip = step(levels[n - 1], levels[n]) > kSkip * pitch;
        number[n] = number[n - 1] + (skip ? 2 : 1);
    }
    // The first rib is a much smaller arch than the second (measured ratio 0.83 to 0.85), and the second is a smaller
    // arch than the third (0.91). No other rib is a smaller arch than the next. When the uppermost level is no smaller
    // arch and lies at the border of the image, the first rib is out of view. Ratios between these limits decide
    // nothing, and no number is shifted.
    constexpr double kFirstArch = 0.88, kSmallerArch = 0.93;
    const auto arch = [&](const Level& level) {
        double most = 0.0;
        for (const RibTrack* rib : level.rib)
            most = rib != nullptr ? std::max(most, widest(*rib, cage)) : most;
        return most;
    };
    const double top = grid.origin.z() + grid.spacing.z() * (grid.size[2] - 1), bottom = grid.origin.z();
    const auto head
        = [](const Level& level) { return (level.rib[0] != nullptr ? level.rib[0] : level.rib[1])->line.front().z(); };
    if (levels.size() < 2) {
        warnings.push_back("only one level of ribs was found: it is called rib 1, which is a guess");
    } else if (const double size = arch(levels[0]) / arch(levels[1]); size >= kFirstArch) {
        const bool smaller = size < kSmallerArch;
        const bool neck_seen = head(levels.front()) + 1.5 * pitch <= top;
        const bool last_seen = head(levels.back()) - 1.5 * pitch > bottom;
        const int shift = kMostRibs - number.back();
        if (shift <= 0) {
            if (!smaller)
                warnings.push_back("the uppermost rib is no smaller than the next, as a first rib is: it is called rib "
                                   "1 since there are ribs enough below it, check the numbers");
        } else if (neck_seen || smaller) {
            warnings.push_back("rib numbers may be one too low: the first rib was not recognised");
        } else if (last_seen) {
            for (int& n : number)
                n += shift;
            warnings.push_back("the first rib is not in view: ribs are numbered from the lowest, taken as 12");
        } else {
            warnings.push_back("neither the first nor the last rib is in view: rib numbers may be shifted");
        }
    }
    if (number.back() > kMostRibs)
        warnings.push_back("ribs at " + std::to_string(number.back()) + " levels were found, there should be "
            + std::to_string(kMostRibs)
            + ": those below the twelfth carry no number and are left out, check the others");
    for (std::size_t n = 0; n < levels.size(); ++n)
        for (RibTrack* rib : levels[n].rib)
            if (rib != nullptr && number[n] <= kMostRibs)
                rib->number = number[n];
}

} // namespace retractor::datasets::segmentation
