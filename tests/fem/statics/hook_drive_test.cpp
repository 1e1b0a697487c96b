#include "fem/statics/hook_drive.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <tuple>
#include <vector>

namespace retractor::fem {
namespace hook_drive_test {

    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    constexpr double kSettled = 1e-10; // Newton's steps end at 1e-13 of the limit

    Eigen::MatrixXd stiffness_of(int hooks)
    {
        std::srand(3);
        const Eigen::MatrixXd a = Eigen::MatrixXd::Random(3 * hooks, 3 * hooks);
        return a * a.transpose() + 0.2 * Eigen::MatrixXd::Identity(3 * hooks, 3 * hooks);
    }

    TEST(HookDrive, OneSpringAgainstAnotherHasTheClosedForm)
    {
        const Eigen::MatrixXd R = 2.0 * Mat3::Identity();
        const Eigen::VectorXd none = Vec3::Zero();
        const auto rest = [&](const HookDrive& drive) { return rest_of_hooks(R, none, { drive }); };
        const Vec3 target(3.0, 0.0, 4.0); // 5 mm, 10 N
        EXPECT_LT((rest({ .force_N = Vec3(1.0, 0.0, -2.0) }).displacement - Vec3(0.5, 0.0, -1.0)).norm(), kSettled);
        EXPECT_LT(
            (rest({ .displacement = target, .grip_N_per_mm = 6.0 }).displacement - 0.75 * target).norm(), kSettled);
        const HookRest limited = rest({ .displacement = target, .force_limit_N = 4.0 });
        EXPECT_TRUE(limited.yielded[0]);
        EXPECT_LT((limited.displacement - 0.4 * target).norm(), kSettled); // 2 mm, 4 N
        EXPECT_FALSE(rest({ .displacement = target, .force_limit_N = 10.1 }).yielded[0]);
        const HookRest both = rest({ .displacement = target, .grip_N_per_mm = 6.0, .force_limit_N = 4.0 });
        EXPECT_LT((both.displacement - 0.4 * target).norm(), kSettled);
    }

    TEST(HookDrive, TissueSlidesAcrossTheOneDirectionThatAHookPrescribes)
    {
        const Vec3 along = Vec3(1.0, 2.0, -2.0) / 3.0, target = 6.0 * along;
        for (const int hooks : { 1, 3 }) {
            const Eigen::MatrixXd R = stiffness_of(hooks);
            const Eigen::VectorXd r = Eigen::VectorXd::LinSpaced(3 * hooks, -0.5, 0.7);
            std::vector<HookDrive> drives(static_cast<std::size_t>(hooks), HookDrive { .displacement = target });
            drives[0].only_along = along;
            drives[0].displacement += Vec3(2.0, -1.0, 0.0); // across: it is not prescribed
            ASSERT_NEAR(Vec3(2.0, -1.0, 0.0).dot(along), 0.0, kSettled);
            const HookRest rest = rest_of_hooks(R, r, drives);
            ASSERT_TRUE(rest.converged);
            const Vec3 moved = rest.displacement.head<3>(), force = (R * rest.displacement + r).head<3>();
            EXPECT_NEAR(moved.dot(along), 6.0, kSettled);
            EXPECT_LT((force - force.dot(along) * along).norm(), kSettled) << "without friction";
            for (int h = 1; h < hooks; ++h)
                EXPECT_LT((Vec3(rest.displacement.segment<3>(3 * h)) - target).norm(), kSettled);

            drives[0].force_limit_N = 0.5 * std::abs(force.dot(along));
            const HookRest limited = rest_of_hooks(R, r, drives);
            ASSERT_TRUE(limited.converged);
            EXPECT_TRUE(limited.yielded[0]);
            EXPECT_LT(((R * limited.displacement + r).head<3>() - 0.5 * force).norm(), kSettled * force.norm());
        }
        EXPECT_FALSE((HookDrive { .only_along = along }.prescribes()));
        EXPECT_THROW(check_drive({ .only_along = Vec3(1.0, 1.0, 0.0) }, "blade"), InputError);
        EXPECT_THROW(check_drive({ .only_along = Vec3::Constant(kInfinite) }, "blade"), InputError);
    }

    TEST(HookDrive, EachHookGetsItsLawsForce)
    {
        const Eigen::MatrixXd R = stiffness_of(4);
        const Eigen::VectorXd r = Eigen::VectorXd::LinSpaced(12, -0.5, 0.7);
        const Vec3 force(0.3, -0.2, 0.1), target(1.0, 2.0, -1.0);
        const std::vector<HookDrive> drives { { .displacement = target }, { .force_N = force },
            { .displacement = target, .grip_N_per_mm = 0.7 }, { .displacement = target, .force_limit_N = 0.4 } };
        const HookRest rest = rest_of_hooks(R, r, drives);
        ASSERT_TRUE(rest.converged);
        const Eigen::VectorXd f = R * rest.displacement + r;
        EXPECT_EQ(Vec3(rest.displacement.head<3>()), target);
        EXPECT_LT((Vec3(f.segment<3>(3)) - force).norm(), kSettled);
        EXPECT_LT((Vec3(f.segment<3>(6)) - 0.7 * (target - Vec3(rest.displacement.segment<3>(6)))).norm(), kSettled);
        const Vec3 slip = target - Vec3(rest.displacement.tail<3>()), held = f.tail<3>();
        EXPECT_TRUE(rest.yielded[3]);
        EXPECT_NEAR(held.norm(), 0.4, kSettled);
        EXPECT_NEAR(slip.dot(held), slip.norm() * held.norm(), kSettled * slip.norm());
    }

    /// How far hooks are from their laws: forces in limits, and in their own size across the slip.
    struct OffLaw {
        double force = 0.0, direction = 0.0;
        int yielded = 0;
    };

    OffLaw off_law(const Eigen::MatrixXd& R, const Eigen::VectorXd& r, const std::vector<HookDrive>& drives)
    {
        const HookRest rest = rest_of_hooks(R, r, drives);
        EXPECT_TRUE(rest.converged);
        const Eigen::VectorXd f = R * rest.displacement + r;
        OffLaw off;
        for (std::size_t h = 0; h < drives.size(); ++h) {
            const auto at = 3 * static_cast<Eigen::Index>(h);
            const Vec3 force = f.segment<3>(at), slip = drives[h].displacement - Vec3(rest.displacement.segment<3>(at));
            const double over = force.norm() / drives[h].force_limit_N - 1.0;
            if (!rest.yielded[h]) {
                EXPECT_EQ(slip, Vec3::Zero());
                off.force = std::max(off.force, over);
                continue;
            }
            ++off.yielded;
            off.force = std::max(off.force, std::abs(over));
            off.direction = std::max(off.direction, (force.normalized() - slip.normalized()).norm());
        }
        return off;
    }

    /// Stiffness with one random direction per power, from 1 to the ratio.
    Eigen::MatrixXd badly_scaled(int hooks, double ratio)
    {
        const Eigen::Index n = 3 * hooks;
        const Eigen::MatrixXd q = Eigen::HouseholderQR<Eigen::MatrixXd>(Eigen::MatrixXd::Random(n, n)).householderQ();
        Eigen::VectorXd stiffness(n);
        for (Eigen::Index i = 0; i < n; ++i)
            stiffness[i] = std::pow(ratio, static_cast<double>(i) / static_cast<double>(n - 1));
        const Eigen::MatrixXd R = q * stiffness.asDiagonal() * q.transpose();
        return 0.5 * (R + R.transpose());
    }

    TEST(HookDrive, BadlyScaledTissueComesToRestToo)
    {
        constexpr double kRoundOff = 1e-6; // what is promised, in limits
        constexpr double kDigits = 1e-13; // N per N/mm: d = target - slip is known to some 1e-15 of 50 mm
        std::srand(7);
        int some = 0, all = 0;
        for (const double ratio : { 1.0, 1e3, 1e6, 1e8 })
            for (const double limit : { 1e-1, 1e1, 1e3, 1e5 })
                for (const int hooks : { 1, 2, 4, 8, 12 }) {
                    const Eigen::MatrixXd R = badly_scaled(hooks, ratio);
                    const Eigen::VectorXd r = 3.0 * Eigen::VectorXd::Random(3 * hooks);
                    std::vector<HookDrive> drives;
                    for (int h = 0; h < hooks; ++h)
                        drives.push_back({ .displacement = 30.0 * Vec3::Random(),
                            .force_limit_N = limit * (h % 3 == 1 ? 7.0 : 1.0) });
                    SCOPED_TRACE(testing::Message() << ratio << " " << limit << " N, " << hooks << " hooks");
                    const OffLaw off = off_law(R, r, drives);
                    EXPECT_LT(off.force, kRoundOff + kDigits * ratio / limit);
                    EXPECT_LT(off.direction, kRoundOff + kDigits * ratio / limit);
                    some += off.yielded > 0 && off.yielded < hooks ? 1 : 0;
                    all += off.yielded == hooks ? 1 : 0;
                }
        EXPECT_GT(some, 5);
        EXPECT_GT(all, 20);
    }

    TEST(HookDrive, HooksOnOneStiffBarYieldTogether)
    {
        // Four hooks side by side on a bar (springs of 1e6 N/mm between them) that soft tissue holds (1 N/mm): turn by
        // turn, each would be held back by the other three.
        constexpr double kBar = 1e6, kSoft = 1.0, kLimit = 2.0, kPull = 25.0;
        constexpr double kDigits = 1e-9; // six of them lie between bar and tissue
        constexpr int kHooks = 4;
        Eigen::MatrixXd R = Eigen::MatrixXd::Zero(3 * kHooks, 3 * kHooks);
        for (int h = 0; h < kHooks; ++h) {
            R.block<3, 3>(3 * h, 3 * h) += kSoft * Mat3::Identity();
            if (h + 1 == kHooks)
                break;
            for (const auto& [a, b, sign] : { std::tuple { h, h, 1.0 }, std::tuple { h + 1, h + 1, 1.0 },
                     std::tuple { h, h + 1, -1.0 }, std::tuple { h + 1, h, -1.0 } })
                R.block<3, 3>(3 * a, 3 * b) += sign * kBar * Mat3::Identity();
        }
        const HookRest rest = rest_of_hooks(R, Eigen::VectorXd::Zero(3 * kHooks),
            std::vector<HookDrive>(kHooks, { .displacement = Vec3(0.0, kPull, 0.0), .force_limit_N = kLimit }));
        ASSERT_TRUE(rest.converged);
        for (int h = 0; h < kHooks; ++h) {
            EXPECT_TRUE(rest.yielded[static_cast<std::size_t>(h)]);
            EXPECT_LT((rest.displacement.segment<3>(3 * h) - Vec3(0.0, kLimit / kSoft, 0.0)).norm(), kDigits);
        }
    }

    TEST(HookDrive, HooksThatYieldToNextToNothingComeToRest)
    {
        // A bridge between stiff bone: 25 mm would take 1.4 MN, and 200 N move it by 3.6 um.
        constexpr double kBone = 5.6e4, kLimit = 200.0;
        const Mat3 K = kBone * Mat3::Identity();
        Eigen::MatrixXd R(6, 6);
        R << K, 0.5 * K, 0.5 * K, K;
        const Vec3 pull(25.0, 0.0, 0.0);
        const HookRest rest = rest_of_hooks(R, Eigen::VectorXd::Zero(6),
            { { .displacement = pull, .force_limit_N = kLimit }, { .displacement = -pull, .force_limit_N = kLimit } });
        ASSERT_TRUE(rest.converged);
        const Vec3 there = kLimit / (0.5 * kBone) * Vec3::UnitX();
        EXPECT_LT((rest.displacement.head<3>() - there).norm(), kSettled * there.norm());
        EXPECT_LT((rest.displacement.tail<3>() + there).norm(), kSettled * there.norm());
    }

    TEST(HookDrive, WhatNothingHoldsFindsNoRest)
    {
        const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(3, 3);
        EXPECT_FALSE(rest_of_hooks(none, Vec3::Zero(), { { .force_N = Vec3(1.0, 0.0, 0.0) } }).converged);
        // Drawn to somewhere, it just goes there.
        const HookRest goes
            = rest_of_hooks(none, Vec3::Zero(), { { .displacement = Vec3(1.0, 0.0, 0.0), .force_limit_N = 1.0 } });
        EXPECT_TRUE(goes.converged);
        EXPECT_EQ(Vec3(goes.displacement), Vec3(1.0, 0.0, 0.0));
        const double nan = std::numeric_limits<double>::quiet_NaN();
        EXPECT_FALSE(rest_of_hooks(
            nan * Mat3::Identity(), Vec3::Zero(), { { .displacement = Vec3(1.0, 0.0, 0.0), .force_limit_N = 1.0 } })
                         .converged);
    }

    TEST(HookDrive, BadNumbersNameTheHook)
    {
        const double nan = std::numeric_limits<double>::quiet_NaN();
        for (const HookDrive& bad :
            { HookDrive { .displacement = Vec3(nan, 0.0, 0.0) }, HookDrive { .force_N = Vec3(0.0, kInfinite, 0.0) },
                HookDrive { .grip_N_per_mm = 0.0 }, HookDrive { .force_limit_N = nan } })
            try {
                check_drive(bad, "left 2");
                ADD_FAILURE() << "accepted";
            } catch (const InputError& error) {
                EXPECT_EQ(error.where(), "hook 'left 2'");
            }
    }

} // namespace hook_drive_test
} // namespace retractor::fem
