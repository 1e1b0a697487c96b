// The quick problems of `retractor-verify`, and the functions on which the command depends.

#include "mesh/base/error.h"
#include "mesh/cutting/cut_session.h"
#include "tests/support/cutting/cut_mesh.h"
#include "tests/verification/analytic/analytic_problems.h"
#include "tests/verification/comparison/estimates.h"
#include "tests/verification/framework/problem.h"
#include "tests/verification/framework/stability.h"
#include "tests/verification/framework/tension.h"
#include "tests/verification/framework/uniform_tissue.h"
#include "tests/verification/problem_list.h"
#include "tests/verification/reference/febio_reference.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace retractor::verification {
namespace verification_test {

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

    TEST(Verification, AnIncisionGapesAsTheClosedFormSaysAlsoWhileItIsCut)
    {
        const std::vector<VerificationRow> rows = gape_problem().run({ shared_data(), false }, Job {});
        EXPECT_FALSE(rows.empty());
        for (const VerificationRow& row : rows) {
            EXPECT_TRUE(row.passed()) << row.problem << ", " << row.element << ", " << row.tets
                                      << " tets: " << row.error;
            // The solved mesh is the cut mesh, whose lips have doubled vertices.
            SheetProblem sheet { .around = static_cast<int>(std::lround(1.0 / row.size)) };
            if (row.element.find("while cut") != std::string::npos)
                sheet.radius = 600.0;
            const test_support::CutMesh cut = test_support::cut(sheet_mesh(sheet), sheet_blade(sheet));
            ASSERT_EQ(cut.status, mesh::CutStatus::done) << cut.message;
            EXPECT_EQ(row.tets, cut.mesh.tet_count());
            EXPECT_EQ(row.nodes,
                row.element == "P2" ? mesh::with_midpoints(cut.mesh).vertex_count() : cut.mesh.vertex_count());
        }
    }

    TEST(Verification, ErrorEstimatesAreHalfToThreeTimesTheError) { expect_all_pass(estimate_problem()); }

    TEST(Stability, NaNForeignExceptionsAndUnexpectedOutcomesDoNotPass)
    {
        const StabilityRow nan
            = attempt("case", "model", [](StabilityRow& row) { row.residual = row.error = std::nan(""); });
        EXPECT_EQ(nan.outcome, StabilityOutcome::misbehaved);
        EXPECT_FALSE(nan.passed());
        const StabilityRow thrown = attempt("case", "model", [](StabilityRow&) { throw std::runtime_error("lost"); });
        EXPECT_EQ(thrown.outcome, StabilityOutcome::misbehaved);
        EXPECT_EQ(thrown.reason, "lost");
        const StabilityRow refused
            = attempt("case", "model", [](StabilityRow&) { throw SolverError("no", "piece 1"); });
        EXPECT_EQ(refused.outcome, StabilityOutcome::refused);
        EXPECT_EQ(refused.reason, "no [piece 1]");
        EXPECT_FALSE(refused.passed()) << "an answer was to come";
        const StabilityRow accepted
            = expect_refusal("case", "model", "no", [](StabilityRow& row) { row.residual = row.error = 0.0; });
        EXPECT_FALSE(accepted.passed()) << "a refusal was to come";
        const auto other = [](StabilityRow& row) {
            row.unconditioned = Unconditioned::no_factor;
            throw SolverError("not converged");
        };
        EXPECT_TRUE(expect_refusal("case", "model", "converged", other).passed());
        EXPECT_FALSE(expect_refusal("case", "model", "piece 1", other).passed()) << "refused for something else";
        const StabilityRow broken
            = attempt("case", "model", [](StabilityRow&) { throw PromiseNotKept("volume lost"); });
        EXPECT_EQ(broken.outcome, StabilityOutcome::misbehaved) << "no refusal";
    }

    TEST(Stability, ARowHasConditionNumbersOrSaysWhyItHasNone)
    {
        const StabilityRow silent
            = expect_refusal("case", "model", "loose", [](StabilityRow&) { throw SolverError("a loose piece"); });
        EXPECT_EQ(silent.outcome, StabilityOutcome::refused);
        EXPECT_FALSE(silent.passed()) << "it has none, and does not say why";
        EXPECT_EQ(unconditioned_name(silent.unconditioned), "");
        const StabilityRow refused
            = expect_refusal("case", "model", "no", [](StabilityRow&) { throw InputError("no number"); });
        EXPECT_TRUE(refused.passed()) << "what is refused as input has no matrix yet";
        EXPECT_EQ(unconditioned_name(refused.unconditioned), "no matrix");

        const fem::ElasticProblem loose { mesh::kuhn_box(1, 1, 1, 1.0),
            std::vector<fem::Material>(2, { "tissue", 1.0, 0.3, 1e-9, "" }), {}, {} };
        const auto conditioned = [](const fem::ElasticProblem& problem) {
            return attempt("case", "model", [&](StabilityRow& row) {
                row.residual = row.error = 0.0;
                set_condition(row, problem, fem::Elasticity::linear);
            });
        };
        EXPECT_EQ(unconditioned_name(conditioned(loose).unconditioned), "no factor");
        fem::ElasticProblem held = loose;
        held.supports.fixed = { 0, 1, 2, 3 };
        EXPECT_GT(conditioned(held).condition, 1.0);
        EXPECT_TRUE(conditioned(held).passed());
        const StabilityRow predicted = attempt("case", "model", [&](StabilityRow& row) {
            row.unconditioned = Unconditioned::no_matrix; // in case no condition number is found
            set_condition(row, held, fem::Elasticity::linear);
        });
        EXPECT_GT(predicted.condition, 1.0);
        EXPECT_EQ(unconditioned_name(predicted.unconditioned), "") << "it has one";
        constexpr double kStiffBed = 1e6; // between the condition numbers without and with a bed of 1e9
        EXPECT_LT(conditioned(held).condition, kStiffBed);
        held.supports.bedded = { { 7, 1e9 } };
        EXPECT_GT(conditioned(held).condition, kStiffBed) << "the bed is part of it";
    }

    TEST(Stability, SecondsAreWithoutTheConditionNumbers)
    {
        fem::ElasticProblem problem { mesh::kuhn_box(12, 12, 12, 1.0),
            std::vector<fem::Material>(2, { "tissue", 1.0, 0.3, 1e-9, "" }), {}, {} };
        problem.supports.fixed = { 0, 1, 13, 169 };
        // relative to the whole run time; body and stiffness alone take several times as much
        constexpr double kRest = 0.005;
        // Wall times: a busy machine may halt the process between two looks at the clock, but not in every attempt.
        constexpr int kAttempts = 20;
        bool without = false;
        for (int i = 0; i < kAttempts && !without; ++i) {
            const StabilityRow row = attempt(
                "case", "model", [&](StabilityRow& r) { set_condition(r, problem, fem::Elasticity::linear); });
            ASSERT_GT(row.condition, 1.0);
            without = row.seconds < kRest * row.condition_seconds;
        }
        EXPECT_TRUE(without) << "in none of " << kAttempts << " attempts";
    }

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

    TEST(Verification, AnEstimateIsJudgedOnlyWhereAnswerAndEstimateAreNumbers)
    {
        const auto passes = [](const JudgedEstimate& judged, VerificationRow row = {}) {
            check_estimate(row, "a number", judged);
            return row.passed();
        };
        EXPECT_TRUE(passes({ 1.1, 0.1, 1.0 }));
        EXPECT_FALSE(passes({ 1.1, 0.04, 1.0 }));
        EXPECT_FALSE(passes({ 1.1, 0.31, 1.0 }));
        EXPECT_TRUE(passes({ 1.0, 0.0, 1.0 })); // right, with an estimate of zero error
        EXPECT_FALSE(passes({ 1.0, 0.1, 1.0 }));
        EXPECT_FALSE(passes({ 1.0, std::nan(""), 1.0 }));
        EXPECT_FALSE(passes({ 1.0, INFINITY, 1.0 }));
        EXPECT_FALSE(passes({ 1.0, 0.001, 1.0, 0.1 })); // a vector of the right length in another direction
        VerificationRow not_solved;
        not_solved.error = std::nan("");
        not_solved.note = "stopped";
        EXPECT_FALSE(passes({ 1.1, 0.1, 1.0 }, not_solved));
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
        fem::ElasticBody body(model.mesh, uniform_tissue(model.mesh, model.law));
        body.set_loads({ model.loads, {} });
        const VerificationSolve solve
            = solve_problem(body, model.held.prescribed, model.held.target, { .tolerance = 1e-10 }, Job {});
        // FEBio's displacement tolerance is 1e-3 of a step
        EXPECT_NEAR(solve.equilibrium.displacement.norm(), 0.44268188785, 1e-7);
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

} // namespace verification_test
} // namespace retractor::verification
