#include "fem/hook_drive.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include <cmath>
#include <limits>

namespace retractor {
namespace {

    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    constexpr double kSettled = 1e-10; // the turns end at 1e-13 of the displacement

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

} // namespace
} // namespace retractor
