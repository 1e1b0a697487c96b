#include "haptics/device/hand_path.h"

#include "tests/support/test_help.h"

#include <gtest/gtest.h>

namespace retractor::haptics {
namespace hand_path_test {

    HandPath there()
    {
        return HandPath({ { 1.0, Vec3::Zero() }, { 2.0, Vec3(10.0, 0.0, 0.0), 1 }, { 4.0, Vec3(10.0, 8.0, 0.0) } });
    }

    TEST(HandPath, MovesWithLeastJerkBetweenItsKeysAndRestsOutside)
    {
        const HandPath path = there();
        EXPECT_EQ(path.position(-5.0), Vec3::Zero());
        EXPECT_EQ(path.position(99.0), Vec3(10.0, 8.0, 0.0));
        EXPECT_DOUBLE_EQ(path.position(1.5).x(), 5.0);
        // [Flash, Hogan 1985], eq. 3 at a quarter of the way: 10 t^3 - 15 t^4 + 6 t^5.
        EXPECT_DOUBLE_EQ(path.position(1.25).x(), 10.0 * (10.0 / 64.0 - 15.0 / 256.0 + 6.0 / 1024.0));
        EXPECT_EQ(path.end_s(), 4.0);
        constexpr double kDt = 1e-5, kStill = 1e-6; // mm/s: it leaves and arrives at rest
        EXPECT_LT((path.position(2.0 + kDt) - path.position(2.0)).norm() / kDt, kStill);
        EXPECT_LT((path.position(2.0) - path.position(2.0 - kDt)).norm() / kDt, kStill);
    }

    TEST(HandPath, PressesButtonsFromTheirKeyOn)
    {
        const HandPath path = there();
        EXPECT_EQ(path.buttons(0.0), 0u);
        EXPECT_EQ(path.buttons(1.99), 0u);
        EXPECT_EQ(path.buttons(2.0), 1u);
        EXPECT_EQ(path.buttons(5.0), 0u);
    }

    TEST(HandPath, RefusesWhatIsNoPath)
    {
        EXPECT_EQ(test_support::message_of([] { HandPath({}); }), "a hand's path needs at least one key");
        EXPECT_EQ(test_support::message_of([] {
            HandPath({ { 0.0, Vec3::Zero() }, { 0.0, Vec3::Zero() } });
        }),
            "key 1: the times of a hand's path do not increase");
        EXPECT_EQ(test_support::message_of([] {
            HandPath({ { 0.0, Vec3(NAN, 0.0, 0.0) } });
        }),
            "key 0: a hand's path has a number that is not finite");
    }

} // namespace hand_path_test
} // namespace retractor::haptics
