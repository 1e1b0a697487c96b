// Each slow family of `retractor-verify` on its coarsest meshes: errors stay within a tenth of the measured ones. The
// command itself judges the finest meshes.

#include "tests/verification/analytic/analytic_problems.h"
#include "tests/verification/comparison/solver_problems.h"
#include "tests/verification/framework/problem.h"
#include "tests/verification/problem_list.h"
#include "tests/verification/reference/given_files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace retractor::verification {
namespace verification_families_test {

    /// Limits for rows whose problem, element and quantity begin with these words. An error has no lower limit,
    /// except where an error must appear.
    struct Measured {
        std::string problem, element, quantity;
        double error = 0.0;
    };
    constexpr double kMore = 1.1; // largest error relative to the measured one

    std::vector<VerificationRow> expect_measured(
        const VerificationProblem& problem, std::size_t meshes, const std::vector<Measured>& measured)
    {
        const std::vector<VerificationRow> rows = problem.run({ .shared_data = {}, .meshes = meshes }, Job {});
        EXPECT_FALSE(rows.empty()) << problem.name;
        std::vector<bool> met(measured.size(), false);
        for (const VerificationRow& row : rows) {
            bool known = false;
            for (std::size_t i = 0; i < measured.size() && !known; ++i) {
                const Measured& m = measured[i];
                known = row.problem.starts_with(m.problem) && row.element == m.element
                    && row.quantity.starts_with(m.quantity);
                if (!known)
                    continue;
                met[i] = true;
                EXPECT_LE(row.error, kMore * m.error) << row.problem << ", " << row.element << ", " << row.quantity
                                                      << ", " << row.tets << " tets: " << row.note;
            }
            EXPECT_TRUE(known) << row.problem << ", " << row.element << ", " << row.quantity << ": " << row.error;
        }
        for (std::size_t i = 0; i < measured.size(); ++i)
            EXPECT_TRUE(met[i]) << measured[i].problem << ", " << measured[i].element << ", " << measured[i].quantity;
        return rows;
    }

    void expect_passed(const std::vector<VerificationRow>& rows)
    {
        EXPECT_FALSE(rows.empty());
        for (const VerificationRow& row : rows)
            EXPECT_TRUE(row.passed()) << row.problem << ", " << row.element << ", " << row.law << ": " << row.value
                                      << " for " << row.expected << " " << row.note;
    }

    TEST(VerificationFamilies, StretchedTube)
    {
        expect_measured(stretched_tube_problem(), 1,
            { { "stretched tube", "P1", "", 0.19 }, { "stretched tube", "locking-free P1", "", 2.3e-3 },
                { "stretched tube", "nodal P1", "", 0.11 }, { "stretched tube", "P2", "", 2.5e-4 } });
    }

    TEST(VerificationFamilies, TubeBeyondItsLimit) { expect_passed(tube_limit_problem().run({ .meshes = 1 }, Job {})); }

    TEST(VerificationFamilies, TubeWithFibres)
    {
        const std::string round = "tube with fibres round it, at 0 deg", wound = "tube with fibres round it, at 40 deg";
        expect_measured(fibre_tube_problem(), 1,
            { { round, "P1", "", 0.0323 }, { round, "locking-free P1", "", 2.31e-3 }, { round, "P2", "", 2.22e-3 },
                { wound, "P1", "", 0.0285 }, { wound, "locking-free P1", "", 5.33e-3 }, { wound, "P2", "", 1.33e-3 } });
    }

    TEST(VerificationFamilies, PennyShapedCut)
    {
        expect_measured(penny_problem(), 1,
            { { "penny", "P1", "opening", 0.286 }, { "penny", "P1", "error in energy", 0.713 },
                { "penny", "P1", "opened", 0.508 }, { "penny", "locking-free P1", "opening", 0.0205 },
                { "penny", "locking-free P1", "error in energy", 0.478 },
                { "penny", "locking-free P1", "opened", 0.229 }, { "penny", "nodal P1", "opening", 0.189 },
                { "penny", "nodal P1", "error in energy", 0.473 }, { "penny", "nodal P1", "opened", 0.224 },
                { "penny", "P2", "opening", 0.0497 }, { "penny", "P2", "error in energy", 0.545 },
                { "penny", "P2", "opened", 0.297 } });
    }

    TEST(VerificationFamilies, Indentation)
    {
        expect_measured(indentation_problem(), 1,
            { { "flat punch", "P1", "", 1.26 }, { "flat punch", "locking-free P1", "", 0.127 },
                { "flat punch", "nodal P1", "", 0.0764 }, { "flat punch", "P2", "", 0.202 },
                { "pressed by a ball", "P1", "", 0.843 }, { "pressed by a ball", "locking-free P1", "", 0.015 },
                { "pressed by a ball", "nodal P1", "", 0.124 }, { "pressed by a ball", "P2", "", 0.0758 },
                { "disc of pressure", "P1", "", 0.504 }, { "disc of pressure", "locking-free P1", "", 0.114 },
                { "disc of pressure", "nodal P1", "mean", 0.121 }, { "disc of pressure", "nodal P1", "", 0.0472 },
                { "disc of pressure", "P2", "", 0.0845 }, { "point load", "P1", "", 0.132 },
                { "point load", "locking-free P1", "", 0.0383 }, { "point load", "nodal P1", "", 0.692 },
                { "point load", "P2", "", 0.0234 } });
    }

    TEST(VerificationFamilies, HomogeneousStates) { expect_passed(homogeneous_problem().run({ .meshes = 1 }, Job {})); }

    TEST(VerificationFamilies, CooksMembrane)
    {
        expect_measured(cook_problem(), 1,
            { { "Cook", "P1", "", 0.315 }, { "Cook", "locking-free P1", "", 0.0481 },
                { "Cook", "nodal P1", "", 3.62e-3 }, { "Cook", "P2", "", 0.0219 } });
    }

    TEST(VerificationFamilies, CantileverInALargeRotation)
    {
        expect_measured(cantilever_problem(), 1,
            { { "cantilever", "P1", "", 0.841 }, { "cantilever", "locking-free P1", "", 0.567 },
                { "cantilever", "nodal P1", "", 0.142 }, { "cantilever", "P2", "", 5.2e-4 } });
    }

    TEST(VerificationFamilies, CardiacBeam)
    {
        expect_measured(cardiac_beam_problem(), 1,
            { { "cardiac", "P1", "", 0.725 }, { "cardiac", "locking-free P1", "", 0.428 },
                { "cardiac", "nodal P1", "", 0.23 }, { "cardiac", "P2", "", 0.069 } });
    }

    TEST(VerificationFamilies, BallDrawnWithinABallAlsoAsAHook)
    {
        const std::vector<VerificationRow> rows = expect_measured(drawn_ball_problem(), 1,
            { { "ball", "P1", "", 0.18 }, { "ball", "locking-free P1", "", 0.612 }, { "ball", "nodal P1", "", 0.556 },
                { "ball", "P2", "", 0.025 }, { "ball", "P1, cut undone", "", 0.18 },
                { "ball", "P1, dragged, cut undone", "", 0.18 }, { "ball", "P1, cut undone, in parts", "", 0.18 },
                { "ball", "P1, dragged, cut undone, in parts", "", 0.18 } });
        constexpr double kSame = 1e-8; // relative to the force: one discrete problem, solved to residuals of 1e-9
        for (const VerificationRow& row : rows)
            if (row.element.starts_with("P1, ")) {
                EXPECT_NEAR(row.value, rows[0].value, kSame * rows[0].value) << row.element;
            }
    }

    TEST(VerificationFamilies, FastPathsGiveTheAnswersOfTheExactPath)
    {
        const std::vector<VerificationRow> rows = fast_paths_problem().run({ .meshes = 1 }, Job {});
        int compared = 0;
        for (const VerificationRow& row : rows)
            if (row.quantity.starts_with("apart from the exact path")) {
                EXPECT_TRUE(row.passed()) << row.problem << ", " << row.element << ": " << row.value;
                compared += std::isfinite(row.bound) ? 1 : 0;
            }
        EXPECT_EQ(compared, 3 * 4 + 1) << "three problems by two bodies, solved and dragged; the near field";
    }

    TEST(VerificationFamilies, SolverLadder)
    {
        expect_measured(solver_ladder_problem(), 1,
            { { "solver ladder", "springs", "", 0.079 }, { "solver ladder", "P1", "", 0.146 },
                { "solver ladder", "locking-free P1", "", 0.0604 }, { "solver ladder", "P2", "", 0.0342 } });
    }

    TEST(VerificationFamilies, FebioTe03)
    {
        const char* set = std::getenv("RETRACTOR_SHARED_DATA");
        const std::filesystem::path shared = set != nullptr ? set : RETRACTOR_SHARED_DATA_DEFAULT;
        const std::filesystem::path file = std::filesystem::path("fem") / "febio" / "te03.feb";
        if (!std::filesystem::exists(shared / file))
            GTEST_SKIP() << "no reference file " << shared / file << ": set RETRACTOR_SHARED_DATA";
        // Without te02, which takes ten times as long and is left to the command.
        const std::filesystem::path alone = std::filesystem::path(testing::TempDir()) / "verification_families";
        std::filesystem::create_directories((alone / file).parent_path());
        std::filesystem::copy_file(shared / file, alone / file, std::filesystem::copy_options::overwrite_existing);
        int bounded = 0;
        for (const VerificationRow& row : febio_problem().run({ .shared_data = alone }, Job {}))
            if (row.problem == "FEBio te03") {
                EXPECT_TRUE(row.passed()) << row.element << ": " << row.value << " for " << row.expected << row.note;
                bounded += std::isfinite(row.bound) ? 1 : 0;
            }
        EXPECT_EQ(bounded, 2) << "locking-free and nodal";
        std::filesystem::remove_all(alone);
    }

    TEST(VerificationFamilies, AProblemSaysWhatItIsNotSolvedWith)
    {
        std::vector<VerificationProblem> problems = verification_problems();
        for (VerificationProblem& problem : ladder_problems())
            problems.push_back(std::move(problem));
        int whole = 0;
        for (const VerificationProblem& problem : problems)
            if (problem.omitted.empty()) {
                ++whole;
                std::set<std::string> elements, laws;
                for (const VerificationRow& row : problem.run({ .meshes = 1 }, Job {})) {
                    elements.insert(row.element);
                    laws.insert(row.law);
                }
                EXPECT_EQ(elements.size(), 4U) << problem.name;
                EXPECT_EQ(laws.size(), 6U) << problem.name;
            }
        EXPECT_EQ(whole, 2) << "patch test and null space, which take no time";
    }

    // Orders.

    std::vector<VerificationRow> series(const std::vector<double>& values, double expected)
    {
        std::vector<VerificationRow> rows(values.size());
        for (std::size_t i = 0; i < rows.size(); ++i) {
            rows[i].size = std::pow(0.5, static_cast<double>(i));
            compare(rows[i], "u, mm", values[i], expected);
        }
        return rows;
    }

    OrderVerdict judged(std::vector<VerificationRow> rows, double expected, const OrderRule& rule = {})
    {
        check_orders(rows, expected, rule);
        return rows.back().order_verdict;
    }

    TEST(VerificationOrders, AreJudgedByTheLastOneWithinTheSlack)
    {
        EXPECT_EQ(judged(series({ 1.16, 1.04, 1.01 }, 1.0), 2.0), OrderVerdict::reached);
        EXPECT_EQ(judged(series({ 1.16, 1.04, 1.01 }, 1.0), 2.4), OrderVerdict::reached);
        std::vector<VerificationRow> slow = series({ 1.16, 1.04, 1.01 }, 1.0);
        check_orders(slow, 3.0, {});
        EXPECT_EQ(slow.back().order_verdict, OrderVerdict::missed);
        EXPECT_FALSE(slow.back().passed());
        EXPECT_NE(slow.back().note.find("too slowly"), std::string::npos);
        EXPECT_EQ(judged(series({ 1.16, 1.04, 1.01 }, 1.0), std::nan("")), OrderVerdict::not_judged);
        EXPECT_EQ(judged(series({ 1.16, 1.04 }, 1.0), 3.0), OrderVerdict::not_judged) << "two meshes";
        std::vector<VerificationRow> locked = series({ 0.1, 0.11, 0.12 }, 1.0);
        check_orders(locked, 2.0, { .asks = OrderRule::Asks::nothing, .why = "locks" });
        EXPECT_EQ(locked.back().order_verdict, OrderVerdict::not_judged);
        std::vector<VerificationRow> lost = series({ 1.16, 1.04, 1.01 }, 1.0);
        lost.back().error = std::nan("");
        EXPECT_EQ(judged(lost, 2.0), OrderVerdict::missed) << "not converged";
    }

    TEST(VerificationOrders, AnErrorThatMustOnlyFallFallsWithEveryMesh)
    {
        const OrderRule falls { .asks = OrderRule::Asks::fall, .why = "locks" };
        EXPECT_EQ(judged(series({ 0.5, 0.6, 0.65 }, 1.0), 2.0, falls), OrderVerdict::falling);
        EXPECT_EQ(judged(series({ 0.5, 0.6 }, 1.0), std::nan(""), falls), OrderVerdict::falling) << "two meshes";
        EXPECT_EQ(judged(series({ 0.5, 0.7, 0.65 }, 1.0), 2.0, falls), OrderVerdict::missed);
        EXPECT_EQ(judged(series({ 0.5, 0.5 }, 1.0), 2.0, falls), OrderVerdict::missed);
        EXPECT_EQ(judged(series({ 0.5 }, 1.0), 2.0, falls), OrderVerdict::not_judged);
        std::vector<VerificationRow> lost = series({ 0.5, 0.6, 0.65 }, 1.0);
        lost[1].error = std::nan("");
        EXPECT_EQ(judged(lost, 2.0, falls), OrderVerdict::missed) << "not converged";
    }

    TEST(VerificationOrders, ARowIsJudgedOrInAJudgedSeriesOrSaysWhyNot)
    {
        const auto appended = [](double bound, const OrderRule& rule) {
            std::vector<VerificationRow> rows, some = series({ 1.16, 1.04, 1.01 }, 1.0);
            append_series(rows, some, 2.0, bound, rule);
            return rows;
        };
        for (const OrderRule::Asks asks : { OrderRule::Asks::order, OrderRule::Asks::fall, OrderRule::Asks::nothing }) {
            const std::vector<VerificationRow> bounded = appended(0.02, { .asks = asks, .why = "rough" });
            EXPECT_TRUE(bounded[0].in_series && bounded[1].in_series && !bounded[2].in_series);
            EXPECT_EQ(bounded[2].bound, 0.02);
            EXPECT_FALSE(bounded[0].only_shown || bounded[2].only_shown);
            const std::vector<VerificationRow> unbounded = appended(kNoBound, { .asks = asks, .why = "rough" });
            for (const VerificationRow& row : unbounded) {
                EXPECT_EQ(row.only_shown, asks == OrderRule::Asks::nothing);
                EXPECT_EQ(row.note == "rough", asks == OrderRule::Asks::nothing) << row.note;
            }
            EXPECT_EQ(unbounded[0].in_series, asks != OrderRule::Asks::nothing);
        }
        EXPECT_EQ(
            appended(0.02, { .asks = OrderRule::Asks::nothing, .why = "rough" })[2].note, "order not judged: rough");
    }

    TEST(VerificationOrders, AFloorIsNamedAndAnErrorOfTwoSignsIsJudgedOverAllMeshes)
    {
        const OrderRule digits { .floor = 1e-3, .why = "three digits" };
        EXPECT_EQ(judged(series({ 1.1, 1.002, 1.0019 }, 1.0), 2.0, digits), OrderVerdict::at_floor);
        EXPECT_EQ(judged(series({ 1.1, 1.004, 1.0039 }, 1.0), 2.0, digits), OrderVerdict::missed) << "above the floor";
        EXPECT_EQ(judged(series({ 0.9, 1.01, 1.01 }, 1.0), 2.0), OrderVerdict::mixed_signs);
        EXPECT_EQ(judged(series({ 0.9, 1.06, 1.06 }, 1.0), 2.0), OrderVerdict::missed) << "not falling over all either";
        EXPECT_EQ(judged(series({ 0.1, 0.01, 0.01 }, 0.0), 2.0), OrderVerdict::missed)
            << "sizes of errors have no sign";
    }

} // namespace verification_families_test
} // namespace retractor::verification
