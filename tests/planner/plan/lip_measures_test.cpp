#include "planner/plan/lip_measures.h"

#include "planner/measures/metrics.h"
#include "tests/support/reference_problems.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace retractor::planner {
namespace lip_measures_test {

    constexpr double kLength = 100.0, kFrom = 10.0, kTo = 90.0; // mm
    constexpr double kRoundOff = 1e-12;

    Eigen::Isometry3d any_pose()
    {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.linear() = Eigen::AngleAxisd(0.8, Vec3(1.0, -0.5, 2.0).normalized()).matrix();
        pose.translation() = Vec3(40.0, -120.0, 300.0);
        return pose;
    }

    /// A lip along x that stands `out(x)` mm off the incision, towards y.
    LipLine lip(const std::function<double(double)>& out, int points, const Eigen::Isometry3d& pose)
    {
        LipLine line;
        for (int i = 0; i < points; ++i) {
            const double x = kLength * i / (points - 1);
            line.along_mm.push_back(x);
            line.points.push_back(pose * Vec3(x, out(x), 0.2 * out(x)));
        }
        return line;
    }

    std::vector<LipHook> hooks(const std::vector<double>& places, double out, const Eigen::Isometry3d& pose)
    {
        std::vector<LipHook> all;
        for (const double x : places)
            all.push_back({ x, pose * Vec3(x, out, 0.0), pose.linear() * Vec3::UnitY() });
        return all;
    }

    TEST(LipMeasures, AStraightLipFollowsItsHooks)
    {
        const LipDeviation found = lip_deviation(
            lip([](double) { return 20.0; }, 26, any_pose()), hooks({ 30.0, 70.0 }, 20.0, any_pose()), 1, kFrom, kTo);
        constexpr double kFarFromOrigin = 1e-10;
        EXPECT_NEAR(found.largest_mm, 0.0, kFarFromOrigin);
        EXPECT_NEAR(found.mean_mm, 0.0, kFarFromOrigin);
        EXPECT_EQ(found.side, 1);
        ASSERT_GT(found.curve.size(), 50U);
        EXPECT_EQ(found.curve.front().first, 0.0);
        EXPECT_EQ(found.curve.back().first, kLength);
    }

    TEST(LipMeasures, ALipThatSagsBetweenHooksHasTheSagOfTheBow)
    {
        // Between hooks 20 mm apart the lip hangs back as a half sine of 3 mm: 3 mm at most, 6/pi mm in the mean.
        for (const Eigen::Isometry3d& pose : { Eigen::Isometry3d(Eigen::Isometry3d::Identity()), any_pose() }) {
            const auto out
                = [](double x) { return 20.0 - 3.0 * std::abs(std::sin(std::numbers::pi * (x - 10.0) / 20.0)); };
            const LipDeviation found = lip_deviation(
                lip(out, 1001, pose), hooks({ 50.0, 10.0, 90.0, 30.0, 70.0 }, 20.0, pose), -1, kFrom, kTo);
            EXPECT_NEAR(found.largest_mm, 3.0, 1e-9);
            constexpr double kTrapezoid = 0.02; // ten steps a bow
            EXPECT_NEAR(found.mean_mm, 6.0 / std::numbers::pi, kTrapezoid);
            EXPECT_GT(found.curve[found.curve.size() / 5].second, 0.0) << "behind the hooks is positive";
            EXPECT_NEAR(std::fmod(found.at_mm, 20.0), 0.0, 1e-9) << "half way between two hooks";
        }
    }

    TEST(LipMeasures, ATriangleHeldByOneHookFallsBackToTheEnds)
    {
        // One hook in the middle holds 20 mm off; the lip runs straight to both ends of the incision.
        const auto out = [](double x) { return 20.0 - 0.4 * std::abs(x - 50.0); };
        const LipDeviation found
            = lip_deviation(lip(out, 101, any_pose()), hooks({ 50.0 }, 20.0, any_pose()), 1, kFrom, kTo);
        EXPECT_NEAR(found.largest_mm, 16.0, 1e-9);
        EXPECT_NEAR(found.mean_mm, 8.0, 1e-9);
        EXPECT_NEAR(found.curve.front().second, 20.0, 1e-9);
        // More hooks on the same triangle: what they do not move is no different.
        const LipDeviation bare
            = lip_deviation(lip(out, 101, any_pose()), hooks({ 50.0 }, 18.0, any_pose()), 1, 44.0, 56.0);
        EXPECT_NEAR(bare.curve[bare.curve.size() / 2].second, -2.0, 1e-9) << "the lip stands before its hook";
        EXPECT_NEAR(bare.largest_mm, 2.0, 1e-9);
    }

    TEST(LipMeasures, TheLineBetweenTwoHooksMayLean)
    {
        // The lip leans with its hooks: 10 mm off at one, 30 mm at the other.
        const auto out = [](double x) { return 0.5 * x - 5.0; };
        std::vector<LipHook> leaning = hooks({ 30.0 }, 10.0, any_pose());
        leaning.push_back(hooks({ 70.0 }, 30.0, any_pose()).front());
        const LipDeviation found = lip_deviation(lip(out, 101, any_pose()), leaning, 1, 30.0, 70.0);
        EXPECT_NEAR(found.largest_mm, 0.0, 1e-9);
    }

    TEST(LipMeasures, BadLipsAreRefused)
    {
        const auto message = [](const LipLine& line, double from, double to) {
            return test_support::message_of(
                [&] { (void)lip_deviation(line, hooks({ 50.0 }, 1.0, any_pose()), 1, from, to); });
        };
        const LipLine good = lip([](double) { return 1.0; }, 11, any_pose());
        LipLine short_one = good, unequal = good, backwards = good, nan = good;
        short_one.points.resize(1);
        short_one.along_mm.resize(1);
        unequal.along_mm.pop_back();
        std::swap(backwards.along_mm[3], backwards.along_mm[4]);
        nan.points[2].x() = std::numeric_limits<double>::quiet_NaN();
        EXPECT_NE(message(short_one, kFrom, kTo).find("at least two points"), std::string::npos);
        EXPECT_NE(message(unequal, kFrom, kTo).find("got 11 and 10"), std::string::npos);
        EXPECT_NE(message(backwards, kFrom, kTo).find("decrease"), std::string::npos);
        EXPECT_NE(message(nan, kFrom, kTo).find("not finite"), std::string::npos);
        EXPECT_NE(message(good, 200.0, 300.0).find("nothing of the lip"), std::string::npos);
    }

    TEST(LipMeasures, AreWrittenAsNumbersAndCurve)
    {
        FieldMetrics field;
        field.name = "median";
        EXPECT_TRUE(lips_text(field).empty());
        EXPECT_FALSE(metrics_document({ field })["approaches"][0].contains("lip_deviation"));
        field.lip_deviation.push_back({ .side = -1,
            .largest_mm = 4.5,
            .mean_mm = 1.5,
            .at_mm = 40.0,
            .from_mm = 10.0,
            .to_mm = 90.0,
            .curve = { { 0.0, 6.0 }, { 2.0, 5.5 } } });
        const auto document = metrics_document({ field });
        const auto& json = document["approaches"][0]["lip_deviation"][0];
        EXPECT_EQ(json["side"], -1);
        EXPECT_EQ(json["largest_mm"], 4.5);
        EXPECT_EQ(json["mean_mm"], 1.5);
        EXPECT_EQ(json["at_mm"], 40.0);
        EXPECT_EQ(json["between_mm"][1], 90.0);
        EXPECT_EQ(json["curve"][1][1], 5.5);
        EXPECT_NE(lips_text(field).find("the right lip lies up to 4.5 mm (mean 1.5 mm)"), std::string::npos);
    }

} // namespace lip_measures_test
} // namespace retractor::planner
