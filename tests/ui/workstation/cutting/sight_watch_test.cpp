#include "ui/workstation/cutting/sight_watch.h"

#include "mesh/base/error.h"
#include "tests/support/window/window_help.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

namespace retractor::ui {
namespace sight_watch_test {

    /// A wall of one triangle whose first corner lies at a height.
    std::shared_ptr<const planner::WallPicture> wall_at(double height_mm)
    {
        auto surface = std::make_shared<planner::WallSurface>();
        surface->triangles = { { 0, 1, 2 } };
        auto wall = std::make_shared<planner::WallPicture>();
        wall->shown.resize(3, 3);
        wall->shown << 0.0, 0.0, height_mm, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0;
        surface->rest = wall->shown;
        wall->surface = std::move(surface);
        return wall;
    }

    class SightWatchTest : public testing::Test {
    protected:
        /// Sees one percent for each millimetre of height, when it is let.
        SightWatch::Look look()
        {
            return [this](const TriMesh& wall, const TriMesh&, const Job& job) {
                ++begun_;
                while (held_ && !job.cancelled())
                    std::this_thread::sleep_for(std::chrono::milliseconds(1));
                if (wall.vertices(0, 2) < 0.0)
                    throw InputError("there is no target");
                return planner::SeenNow { .seen_fraction = 0.01 * wall.vertices(0, 2), .sampling_error = 0.02 };
            };
        }
        std::string text() const { return watch_.text().toStdString(); }
        void wait()
        {
            ASSERT_TRUE(QTest::qWaitFor([&] { return watch_.idle(); }, test_support::kPatienceMs));
        }

        std::atomic<bool> held_ = false;
        std::atomic<int> begun_ = 0;
        SightWatch watch_; ///< declared last: its thread uses the others
    };

    TEST_F(SightWatchTest, TheNumberFollowsTheWoundAndSaysItsAgeMeanwhile)
    {
        watch_.watch(wall_at(10.0), {}, look());
        wait();
        EXPECT_EQ(text().find("The best eye sees 10 % of the target"), 0U) << text();
        EXPECT_EQ(text().find("s ago"), std::string::npos) << text();
        held_ = true;
        watch_.watch(wall_at(40.0), {}, look());
        ASSERT_TRUE(QTest::qWaitFor([&] { return begun_ == 2; }, test_support::kPatienceMs));
        EXPECT_EQ(text().find("The best eye sees 10 % of the target"), 0U) << text();
        EXPECT_NE(text().find("s ago."), std::string::npos) << "it is of an earlier wound: " << text();
        held_ = false;
        wait();
        EXPECT_EQ(text().find("The best eye sees 40 % of the target"), 0U) << text();
        EXPECT_EQ(text().find("s ago"), std::string::npos) << text();
    }

    TEST_F(SightWatchTest, OfManyWoundsTheNewestIsMeasured)
    {
        held_ = true;
        for (int height_mm = 1; height_mm <= 20; ++height_mm)
            watch_.watch(wall_at(height_mm), {}, look());
        held_ = false;
        wait();
        EXPECT_EQ(begun_, 2) << "the first, and the newest of those that came meanwhile";
        EXPECT_EQ(text().find("The best eye sees 20 % of the target"), 0U) << text();
    }

    TEST_F(SightWatchTest, AFailureIsSaidAndForgottenWithTheWound)
    {
        watch_.watch(wall_at(-1.0), {}, look());
        wait();
        EXPECT_EQ(text(), "What is seen cannot be measured: there is no target");
        watch_.forget();
        watch_.watch(wall_at(5.0), {}, look());
        wait();
        EXPECT_EQ(text().find("The best eye sees 5 % of the target"), 0U) << text();
    }

} // namespace sight_watch_test
} // namespace retractor::ui
