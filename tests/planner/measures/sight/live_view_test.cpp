#include "planner/measures/sight/live_view.h"

#include "datasets/phantoms/phantom.h"
#include "tests/support/block_case.h"

#include <gtest/gtest.h>

#include <atomic>

namespace retractor::planner {
namespace live_view_test {

    /// A plate at the skin with a slit of this half width along the incision (x), open to infinity as far as eyes go.
    TriMesh slit(double half_width)
    {
        constexpr double kFarMm = 2000.0;
        TriMesh mesh;
        for (const double side : { -1.0, 1.0 }) {
            const auto first = static_cast<VertexId>(mesh.vertices.rows());
            Points more(first + 4, 3);
            more.topRows(first) = mesh.vertices;
            more.row(first) << -kFarMm, 0.0, side * half_width;
            more.row(first + 1) << kFarMm, 0.0, side * half_width;
            more.row(first + 2) << kFarMm, 0.0, side * kFarMm;
            more.row(first + 3) << -kFarMm, 0.0, side * kFarMm;
            mesh.vertices = more;
            mesh.triangles.push_back({ first, first + 1, first + 2 });
            mesh.triangles.push_back({ first, first + 2, first + 3 });
        }
        return mesh;
    }

    TEST(LiveView, SeesAllWithoutAWallNothingThroughAClosedOneAndMoreThroughAWiderSlit)
    {
        Patient patient(test_support::block_case("live", datasets::make_block_phantom(test_support::small_block())));
        constexpr double kOpeningMm = 20.0;
        const Approach approach
            = test_support::block_approach(*patient.labels(), Eigen::Isometry3d::Identity(), kOpeningMm);
        const LiveView view(patient, approach);
        constexpr double kOfSamples = 0.02;
        const SeenNow open = view.look({}, {});
        EXPECT_EQ(open.status, ExposureStatus::done);
        EXPECT_NEAR(open.seen_fraction, 1.0, kOfSamples);
        EXPECT_EQ(view.look(slit(0.0), {}).seen_fraction, 0.0);
        EXPECT_EQ(view.look({}, slit(0.0)).seen_fraction, 0.0) << "the wall beyond hides it as well";
        double before = 0.0;
        for (const double half_width : { 2.0, 5.0, 10.0 }) {
            const SeenNow seen = view.look(slit(half_width), {});
            EXPECT_GT(seen.seen_fraction, before) << half_width;
            EXPECT_GE(seen.sampling_error, 0.0);
            EXPECT_LT(seen.sampling_error, 0.05);
            EXPECT_LT(seen.off_straight_deg, 45.0);
            EXPECT_GT(seen.seconds, 0.0);
            before = seen.seen_fraction;
        }
        const std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_EQ(view.look(slit(5.0), {}, job).status, ExposureStatus::cancelled);
    }

} // namespace live_view_test
} // namespace retractor::planner
