// The numbering of drawn ribs, and its messages.
#include "datasets/segmentation/bones/bones_steps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::datasets::segmentation {
namespace bones_rib_numbers_test {

    constexpr double kPitch = 25.0, kHighest = 0.0; // mm: of two levels; of the uppermost rib's head
    constexpr double kArch = 100.0, kFirstArch = 60.0; // mm: half width of a rib, of the first one

    /// Spine and sternum as upright lines, 120 mm apart.
    Cage upright_cage()
    {
        const auto line = [](double y) {
            MidlinePath path;
            path.at.assign(2, { 0.0, y });
            path.first = 0;
            path.last = 1;
            path.z0 = -1000.0;
            path.dz = 2000.0;
            return path;
        };
        Cage cage;
        cage.spine = line(60.0);
        cage.sternum = line(-60.0);
        return cage;
    }

    RibTrack rib(bool left, double head, double radius)
    {
        RibTrack track;
        track.left = left;
        for (double angle = 20.0; angle <= 140.0; angle += 5.0) {
            const double phi = angle * std::numbers::pi / 180.0;
            track.angle.push_back(angle);
            track.line.emplace_back(
                (left ? 1.0 : -1.0) * radius * std::sin(phi), radius * std::cos(phi), head - 0.4 * (angle - 20.0));
        }
        return track;
    }

    std::vector<RibTrack> pairs(int count, bool with_first)
    {
        std::vector<RibTrack> ribs;
        for (int n = 0; n < count; ++n)
            for (const bool left : { true, false })
                ribs.push_back(rib(left, kHighest - kPitch * n, n == 0 && with_first ? kFirstArch : kArch));
        return ribs;
    }

    struct Numbered {
        std::vector<int> left, right; ///< from the uppermost
        std::vector<std::string> warnings;

        bool warns(const std::string& text) const
        {
            return std::any_of(warnings.begin(), warnings.end(),
                [&](const std::string& line) { return line.find(text) != std::string::npos; });
        }
    };

    /// The image reaches from `below` the lowest head to `above` the uppermost, mm.
    Numbered number(std::vector<RibTrack> ribs, double above, double below)
    {
        const double lowest = ribs.back().line.front().z();
        mesh::ImageGrid grid;
        grid.size = { 10, 10, static_cast<int>(kHighest + above - (lowest - below)) + 1 };
        grid.origin = Vec3(0.0, 0.0, lowest - below);
        grid.spacing = Vec3::Ones();
        Numbered result;
        number_ribs(ribs, upright_cage(), grid, result.warnings);
        for (const RibTrack& track : ribs)
            (track.left ? result.left : result.right).push_back(track.number);
        return result;
    }

    std::vector<int> from_to(int first, int last)
    {
        std::vector<int> numbers;
        for (int n = first; n <= last; ++n)
            numbers.push_back(n);
        return numbers;
    }

    constexpr double kFar = 100.0, kNear = 10.0; // mm: room for another rib, and none

    TEST(RibNumbers, TwelvePairsAreNumberedWithoutAWord)
    {
        for (const double room : { kFar, kNear }) {
            const Numbered result = number(pairs(12, true), room, room);
            EXPECT_EQ(result.left, from_to(1, 12));
            EXPECT_EQ(result.right, from_to(1, 12));
            EXPECT_TRUE(result.warnings.empty()) << result.warnings.front();
        }
    }

    TEST(RibNumbers, AFirstRibThatIsNotRecognisedInViewIsMentioned)
    {
        const Numbered result = number(pairs(11, false), kFar, kFar);
        EXPECT_EQ(result.left, from_to(1, 11));
        ASSERT_EQ(result.warnings.size(), 1U);
        EXPECT_TRUE(result.warns("rib numbers may be one too low: the first rib was not recognised"));
    }

    TEST(RibNumbers, AnUppermostRibOfDoubtfulSizeShiftsNothing)
    {
        constexpr double kSecondArch = 0.91 * kArch; // a second rib beside a third
        std::vector<RibTrack> ribs = pairs(10, false);
        ribs[0] = rib(true, kHighest, kSecondArch);
        ribs[1] = rib(false, kHighest, kSecondArch);
        for (const double above : { kNear, kFar }) {
            const Numbered result = number(ribs, above, kFar);
            EXPECT_EQ(result.left, from_to(1, 10));
            ASSERT_EQ(result.warnings.size(), 1U);
            EXPECT_TRUE(result.warns("rib numbers may be one too low"));
        }
    }

    TEST(RibNumbers, AFirstRibOutOfViewIsCountedFromTheLowest)
    {
        const Numbered result = number(pairs(10, false), kNear, kFar);
        EXPECT_EQ(result.left, from_to(3, 12));
        EXPECT_EQ(result.right, from_to(3, 12));
        ASSERT_EQ(result.warnings.size(), 1U);
        EXPECT_TRUE(result.warns("numbered from the lowest, taken as 12"));
    }

    TEST(RibNumbers, NeitherEndInViewIsMentioned)
    {
        const Numbered result = number(pairs(6, false), kNear, kNear);
        EXPECT_EQ(result.left, from_to(1, 6));
        ASSERT_EQ(result.warnings.size(), 1U);
        EXPECT_TRUE(result.warns("neither the first nor the last rib is in view"));
    }

    TEST(RibNumbers, MoreThanTwelveLevelsAreNotLeftOutInSilence)
    {
        std::vector<int> expected = from_to(1, 12);
        expected.insert(expected.end(), { 0, 0 });
        for (const bool with_first : { true, false }) {
            const Numbered result = number(pairs(14, with_first), kNear, kFar);
            EXPECT_EQ(result.left, expected);
            EXPECT_TRUE(result.warns("ribs at 14 levels were found"));
            EXPECT_FALSE(result.warns("taken as 12")); // nothing was counted from the lowest
            EXPECT_EQ(result.warns("it is called rib 1"), !with_first);
        }
    }

    TEST(RibNumbers, OneLevelIsAGuess)
    {
        const Numbered result = number(pairs(1, false), kNear, kNear);
        EXPECT_EQ(result.left, from_to(1, 1));
        EXPECT_TRUE(result.warns("which is a guess"));
    }

} // namespace bones_rib_numbers_test
} // namespace retractor::datasets::segmentation
