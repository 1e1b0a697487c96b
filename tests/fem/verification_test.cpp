// The problems of `retractor verify` that take no time, and what the command relies on.

#include "fem/verification/febio_reference.h"
#include "fem/verification/problem.h"
#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace retractor {
namespace {

    std::filesystem::path shared_data()
    {
        const char* set = std::getenv("RETRACTOR_SHARED_DATA");
        return set != nullptr ? set : RETRACTOR_SHARED_DATA_DEFAULT;
    }

    void expect_all_pass(const VerificationProblem& problem)
    {
        const std::vector<VerificationRow> rows = problem.run({ shared_data(), false }, Job {});
        EXPECT_FALSE(rows.empty()) << problem.name;
        for (const VerificationRow& row : rows)
            EXPECT_TRUE(row.passed()) << row.problem << ", " << row.element << ", " << row.law << ", " << row.tets
                                      << " tets: " << row.value << " for " << row.expected << " " << row.note;
    }

    TEST(Verification, PatchTestAndNullSpaceHoldForEveryElementAndLaw)
    {
        expect_all_pass(patch_test_problem());
        expect_all_pass(null_space_problem());
    }

    TEST(Verification, ThickTubeHasItsClosedForm) { expect_all_pass(pressed_tube_problem()); }

    TEST(Verification, OrdersAreThoseOfErrorsThatFallByPowers)
    {
        std::vector<VerificationRow> series(3);
        for (std::size_t i = 0; i < 3; ++i) {
            series[i].size = std::pow(0.5, static_cast<double>(i));
            series[i].error = std::pow(series[i].size, 3);
        }
        set_orders(series, 3.0);
        EXPECT_TRUE(std::isnan(series[0].order));
        EXPECT_NEAR(series[1].order, 3.0, 1e-12);
        EXPECT_NEAR(series[2].order, 3.0, 1e-12);
    }

    TEST(Verification, AnErrorThatIsNoNumberDoesNotPass)
    {
        VerificationRow row;
        row.error = std::nan("");
        EXPECT_FALSE(row.passed());
    }

    TEST(Verification, StopsWhenCancelled)
    {
        const std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_TRUE(run_verification(verification_problems(), {}, job).empty());
    }

    TEST(Febio, OneElementHasItsPublishedDisplacement)
    {
        const auto file = shared_data() / "fem" / "febio" / "te01.feb";
        if (!std::filesystem::exists(file))
            GTEST_SKIP() << "no reference file " << file << ": set RETRACTOR_SHARED_DATA";
        const FebioModel model = read_febio(file);
        EXPECT_EQ(model.mesh.tet_count(), 1U);
        ElasticBody body(model.mesh, uniform_tissue(model.mesh, model.law));
        body.set_loads({ model.loads, {} });
        const VerificationSolve solve
            = solve_problem(body, model.held.prescribed, model.held.target, { .tolerance = 1e-10 }, Job {});
        EXPECT_NEAR(solve.equilibrium.displacement.norm(), 0.44268188785, 1e-7); // FEBio stops at 1e-3 of a step
    }

    TEST(Febio, DamagedFilesAreRefusedByName)
    {
        const auto folder = std::filesystem::temp_directory_path() / "retractor_febio_test";
        std::filesystem::create_directories(folder);
        const auto refused = [&](const std::string& text) {
            std::ofstream(folder / "bad.feb") << text;
            try {
                (void)read_febio(folder / "bad.feb");
            } catch (const IoError& error) {
                return error.where() + ": " + error.what();
            }
            return std::string("accepted");
        };
        EXPECT_NE(refused("<febio_spec><Mesh>").find("not well-formed"), std::string::npos);
        EXPECT_NE(refused("<febio_spec></febio_spec>").find("has no <Mesh>"), std::string::npos);
        EXPECT_NE(refused("").find("bad.feb"), std::string::npos);
        std::filesystem::remove_all(folder);
        EXPECT_THROW((void)read_febio(folder / "none.feb"), IoError);
    }

} // namespace
} // namespace retractor
