// CalculiX's own cantilever of ten-node tetrahedra: every displacement of its printed result.

#include "tests/support/reference_problems.h"
#include "tests/verification/reference/calculix_reference.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace retractor::verification {
namespace calculix_test {

    using namespace test_support;

    std::filesystem::path shared_data()
    {
        const char* set = std::getenv("RETRACTOR_SHARED_DATA");
        return set != nullptr ? set : RETRACTOR_SHARED_DATA_DEFAULT;
    }

    TEST(CalculiX, CantileverOfTenNodeTetrahedra)
    {
        const auto folder = shared_data() / "fem" / "calculix";
        if (!std::filesystem::exists(folder / "beam10p.inp"))
            GTEST_SKIP() << "no reference file " << folder / "beam10p.inp"
                         << ": set RETRACTOR_SHARED_DATA";
        const CalculixModel model = read_calculix(folder / "beam10p.inp");
        ASSERT_EQ(model.mesh.tet_count(), 31U);
        fem::ElasticBody body(
            model.mesh, fem::Elasticity::linear, std::vector<fem::Lame>(model.mesh.tet_count(), model.lame));
        const Eigen::VectorXd u
            = test_support::solve_linear(body, model.held.prescribed, model.held.target, model.loads);
        const std::vector<Vec3> printed = read_calculix_displacements(folder / "beam10p.dat.ref", model);
        constexpr double kLargest = 0.0877863;
        constexpr double kTol = 1e-6 * kLargest; // the file prints seven digits
        for (std::size_t v = 0; v < printed.size(); ++v)
            EXPECT_LE((u.segment<3>(3 * static_cast<Eigen::Index>(v)) - printed[v]).cwiseAbs().maxCoeff(), kTol)
                << "node " << v;
    }

} // namespace calculix_test
} // namespace retractor::verification
