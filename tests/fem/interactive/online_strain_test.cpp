#include "fem/interactive/online_strain.h"

#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

namespace retractor::fem {
namespace online_strain_test {

    using namespace test_support;

    const std::vector<Material> kTissue(2, test_support::material(0.02, 0.45));

    Eigen::VectorXd field(const OnlineStiffness& K, const Mat3& F)
    {
        Eigen::VectorXd u(3 * static_cast<Eigen::Index>(K.slot_count()));
        for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v)
            u.segment<3>(3 * v) = F * K.position(v) - K.position(v);
        return u;
    }

    TEST(StrainPeak, AUniformStretchIsItsOwnPercentileAndATurnIsNone)
    {
        const OnlineStiffness K(mesh::CutSession(mesh::kuhn_box(4, 4, 4, 2.0)), kTissue);
        Mat3 stretch = Mat3::Identity();
        stretch(1, 1) = 1.2;
        constexpr double kRoundOff = 1e-12;
        EXPECT_NEAR(strain_peak(K, field(K, stretch), {}).p99, 0.5 * (1.44 - 1.0), kRoundOff);
        const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
        EXPECT_NEAR(strain_peak(K, field(K, turn), {}).p99, 0.0, kRoundOff);
        EXPECT_NEAR(strain_peak(K, field(K, turn * stretch), {}).p99, 0.22, kRoundOff);
    }

    TEST(StrainPeak, IsFoundWhereTheTissueIsStretchedButNotUnderHooks)
    {
        mesh::CutSession session(mesh::kuhn_box(5, 5, 5, 2.0)); // the outer layer at x = 10 is a fifth of the volume
        const OnlineStiffness K(session, kTissue);
        Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(K.slot_count()));
        std::vector<VertexId> end;
        for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v)
            if (K.position(v).x() > 9.9) {
                u[3 * v] = 0.4; // 20 % of the layer
                end.push_back(v);
            }
        const StrainPeak peak = strain_peak(K, u, {});
        EXPECT_NEAR(peak.p99, 0.22, 1e-12);
        EXPECT_GT(peak.where.x(), 8.0);
        EXPECT_NEAR(strain_peak(K, u, end).p99, 0.0, 1e-12);
        EXPECT_THROW(strain_peak(K, Eigen::VectorXd::Zero(7), {}), InputError);
    }

} // namespace online_strain_test
} // namespace retractor::fem
