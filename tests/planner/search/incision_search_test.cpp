#include "planner/search/incision_search.h"

#include "mesh/base/error.h"
#include "planner/search/found_approach.h"
#include "planner/search/search_plans.h"
#include "tests/support/block_case.h"
#include "tests/support/label_shapes.h"
#include "tests/support/synthetic_chest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <numbers>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {
namespace incision_search_test {

    // ---- a plate with one window over a ball -----------------------------------------------------------------------

    constexpr double kWindowLength = 50.0, kWindowWidth = 24.0;
    constexpr double kTurn = 30.0 * std::numbers::pi / 180.0; ///< of the window's long axis, from x
    const Vec3 kWindow(103.0, 83.0, 0.0); ///< its middle

    /// Muscle over a plate of bone over a cavity; the plate has one window, which is a lens as an
    /// opened incision is, and a ball that is wider lies behind it.
    Patient& plate()
    {
        static Patient made([] {
            datasets::Phantom phantom {};
            phantom.labels = test_support::sampled_labels({ 120, 110, 46 }, Vec3::Constant(1.6),
                { { 1, "muscle", "muscle", mesh::Role::wall }, { 2, "plate", "bone", mesh::Role::wall },
                    { 3, "lung_left", "lung", mesh::Role::voxel } },
                [](const Vec3& p) -> Label {
                    if (p.z() > 60.0)
                        return 0;
                    if (p.z() < 35.0)
                        return 3;
                    const double x = p.x() - kWindow.x(), y = p.y() - kWindow.y();
                    const double along = std::cos(kTurn) * x + std::sin(kTurn) * y,
                                 across = std::cos(kTurn) * y - std::sin(kTurn) * x;
                    const double t = 2.0 * along / kWindowLength;
                    const bool window = std::abs(across) < 0.5 * kWindowWidth * (1.0 - t * t);
                    return p.z() < 43.0 && !window ? Label { 2 } : Label { 1 };
                });
            return test_support::block_case("search_plate", phantom);
        }());
        return made;
    }

    TEST(IncisionSearch, FindsTheOneWindowOverABall)
    {
        SearchRequest request;
        request.target = { .label = {}, .centre = Vec3(kWindow.x(), kWindow.y(), 2.0), .radius_mm = 30.0 };
        request.limits.shortest_mm = request.limits.longest_mm = kWindowLength;
        request.opening_mm = kWindowWidth;
        request.hooks = "2"; // the hole is as wide as the window, and lies well in one place only
        request.anywhere = true;
        for (const unsigned seed : { 1U, 2U, 3U }) {
            request.seed = seed;
            const IncisionSearch search = search_incisions(plate(), request);
            ASSERT_FALSE(search.found.empty());
            const FoundIncision& best = search.found.front();
            EXPECT_LT((best.middle - kWindow).head<2>().norm(), 2.0) << "seed " << seed;
            const Vec3 along = (best.points.back() - best.points.front()).normalized();
            EXPECT_GT(std::abs(along.dot(Vec3(std::cos(kTurn), std::sin(kTurn), 0.0))), std::cos(0.2)) << seed;
            EXPECT_GT(search.tried.size(), 500U);
        }
    }

    TEST(IncisionSearch, DraftsEndWhenTheirTimeIsOverAndSayWhatIsMissing)
    {
        SearchRequest request;
        request.target = { .label = {}, .centre = Vec3(kWindow.x(), kWindow.y(), 2.0), .radius_mm = 30.0 };
        request.limits.shortest_mm = request.limits.longest_mm = kWindowLength;
        request.opening_mm = 12.0;
        request.hooks = "2";
        request.anywhere = true;
        const IncisionSearch search = search_incisions(plate(), request);
        std::vector<std::string> refused;
        const std::vector<Proposal> proposals = proposals_of(plate(), search, request, 2, refused);
        ASSERT_FALSE(proposals.empty()) << (refused.empty() ? "" : refused.front());
        request.draft_s = 0.0;
        const SearchPlans late = draft_plans(plate().planned_case(), proposals, 2, search, request);
        EXPECT_EQ(late.status, SearchStatus::done) << "nobody has cancelled it";
        EXPECT_TRUE(late.best_first.empty());
        EXPECT_TRUE(late.failed.empty()) << "nothing was judged";
        ASSERT_FALSE(late.not_planned.empty());
        EXPECT_EQ(late.not_planned.front(), proposals.front().words);
        request.draft_s.reset();
        std::mutex guard; // two plans report at a time
        std::set<std::string> stages;
        const SearchPlans plans = draft_plans(plate().planned_case(), proposals, 2, search, request,
            { .on_progress = [&](std::string_view stage, double) {
                const std::scoped_lock lock(guard);
                stages.emplace(stage);
            } });
        ASSERT_FALSE(stages.empty());
        for (const std::string& stage : stages)
            EXPECT_NE(stage.find(" of "), std::string::npos) << stage << " is a stage of one plan";
        EXPECT_TRUE(std::ranges::any_of(
            stages, [](const std::string& stage) { return stage.ends_with("incisions found by lines of sight"); }));
        EXPECT_GE(plans.best_first.size() + plans.failed.size(), std::min<std::size_t>(2, proposals.size()));
        EXPECT_TRUE(plans.not_planned.empty());
        const std::atomic<bool> asked { true };
        request.draft_s = 1e6;
        const SearchPlans cancelled = draft_plans(
            plate().planned_case(), proposals, 2, search, request, { .on_progress = {}, .cancel = &asked });
        EXPECT_EQ(cancelled.status, SearchStatus::cancelled);
        request.draft_s = -1.0;
        EXPECT_THROW((void)draft_plans(plate().planned_case(), proposals, 2, search, request), InputError);
    }

    /// Muscle over a cavity.
    Patient& slab()
    {
        static Patient made([] {
            datasets::Phantom phantom {};
            phantom.labels = test_support::sampled_labels({ 120, 110, 36 }, Vec3::Constant(1.6),
                { { 1, "muscle", "muscle", mesh::Role::wall }, { 2, "lung_left", "lung", mesh::Role::voxel } },
                [](const Vec3& p) -> Label { return p.z() > 50.0 ? 0
                                                 : p.z() < 35.0  ? 2
                                                                 : 1; });
            return test_support::block_case("search_slab", phantom);
        }());
        return made;
    }

    TEST(IncisionSearch, TheBestIsPlannedWiderAndLessWide)
    {
        SearchRequest request;
        request.target = { .label = {}, .centre = Vec3(96.0, 88.0, 2.0), .radius_mm = 30.0 };
        request.limits.shortest_mm = request.limits.longest_mm = 80.0;
        request.limits.least_seen = 0.0;
        request.hooks = "4";
        request.anywhere = true;
        request.draft_s.reset();
        const IncisionSearch search = search_incisions(slab(), request);
        std::vector<std::string> refused;
        const std::vector<Proposal> proposals = proposals_of(slab(), search, request, 1, refused);
        ASSERT_FALSE(proposals.empty());
        EXPECT_EQ(proposals.front().incision.opening_mm, kRibOpeningMm);
        const SearchPlans plans = draft_plans(slab().planned_case(), { proposals.front() }, 1, search, request);
        std::string all;
        for (const PlannedProposal& planned : plans.best_first)
            all += planned.proposal.words + "\n";
        for (const std::string& failed : plans.failed)
            all += failed + "\n";
        ASSERT_FALSE(plans.best_first.empty()) << all;
        EXPECT_NE(all.find("opened 13 mm"), std::string::npos) << all;
        EXPECT_NE(all.find("opened 26 mm"), std::string::npos) << all;
    }

    // ---- a chest ---------------------------------------------------------------------------------------------------

    const test_support::ChestShape kShape {};

    Patient& chest()
    {
        static Patient made([] {
            datasets::Phantom phantom {};
            phantom.labels = test_support::synthetic_chest(kShape);
            return test_support::block_case("search_chest", phantom);
        }());
        return made;
    }

    SearchRequest chest_request()
    {
        SearchRequest request;
        request.target.label = "aneurysm";
        request.limits.shortest_mm = 60.0;
        request.limits.longest_mm = 120.0;
        request.limits.saw = false;
        return request;
    }

    TEST(IncisionSearch, KeepsItsLimits)
    {
        SearchRequest request = chest_request();
        request.limits.right = false;
        request.limits.highest_space = 3;
        request.limits.lowest_space = 5;
        request.limits.from_risk_mm = 4.0;
        const IncisionSearch search = search_incisions(chest(), request);
        EXPECT_EQ(search.status, SearchStatus::done);
        ASSERT_FALSE(search.found.empty());
        for (const FoundIncision& incision : search.found) {
            ASSERT_TRUE(incision.space);
            EXPECT_TRUE(incision.space->left);
            EXPECT_GE(incision.space->number, 3);
            EXPECT_LE(incision.space->number, 5);
            EXPECT_GE(incision.length_mm, 60.0);
            EXPECT_LE(incision.length_mm, 120.0);
            EXPECT_LE(incision.opening_mm, 0.5 * incision.length_mm);
            EXPECT_GE(incision.candidate.field.seen_best_eye, request.limits.least_seen);
            for (const RiskDistance& risk : incision.candidate.field.at_risk)
                EXPECT_GE(risk.distance_mm, 4.0);
        }
        for (std::size_t n = 1; n < search.found.size(); ++n)
            EXPECT_GE(search.found[n - 1].points_of_100, search.found[n].points_of_100);
    }

    TEST(IncisionSearch, OtherSeedsEndAtTheSameScore)
    {
        SearchRequest request = chest_request();
        request.limits.right = false;
        double first = 0.0;
        for (const unsigned seed : { 0U, 1U, 2U }) {
            request.seed = seed;
            const IncisionSearch search = search_incisions(chest(), request);
            ASSERT_FALSE(search.found.empty());
            first = seed == 0U ? search.found.front().points_of_100 : first;
            EXPECT_NEAR(search.found.front().points_of_100, first, 2.0); // points of 100
        }
    }

    TEST(IncisionSearch, ASternumIsSawnAlsoWhereAStructureAtRiskLiesAgainstIt)
    {
        SearchRequest request = chest_request();
        request.limits.left = request.limits.right = false;
        request.limits.saw = true;
        request.limits.from_risk_mm = 100.0; // more than any blade keeps
        const IncisionSearch search = search_incisions(chest(), request);
        ASSERT_EQ(search.found.size(), 1U);
        EXPECT_EQ(search.found.front().kind, FoundIncision::Kind::sternum);
        EXPECT_FALSE(search.found.front().near_risk) << "nothing forbids it";
        ASSERT_FALSE(search.found.front().candidate.field.at_risk.empty()) << "but the distance is told";
        EXPECT_LT(search.found.front().candidate.field.at_risk.front().distance_mm, 100.0);
    }

    TEST(IncisionSearch, NamesTheAssumedVesselsThatABladeMayCut)
    {
        SearchRequest request = chest_request();
        request.limits.right = false;
        const IncisionSearch without = search_incisions(chest(), request);
        ASSERT_FALSE(without.found.empty());
        const FoundIncision& best = without.found.front();
        Case with_vessel = chest().planned_case();
        const Vec3 across = Vec3::UnitZ(); // a space runs round the chest
        with_vessel.assumed_vessels
            = { { .name = "vessel", .line = { best.middle - 60.0 * across, best.middle + 60.0 * across } } };
        Patient patient(with_vessel);
        const IncisionSearch with = search_incisions(patient, request);
        ASSERT_FALSE(with.found.empty());
        EXPECT_DOUBLE_EQ(with.found.front().points_of_100, best.points_of_100) << "assumed places do not count";
        const std::vector<RiskDistance>& risks = with.found.front().candidate.field.at_risk;
        ASSERT_FALSE(risks.empty());
        EXPECT_EQ(risks.front().name, "vessel");
        EXPECT_TRUE(risks.front().is_assumed);
        EXPECT_EQ(risks.front().distance_mm, 0.0);
    }

    TEST(IncisionSearch, MakesTheApproachThatItFound)
    {
        SearchRequest request = chest_request();
        request.limits.saw = true;
        const IncisionSearch search = search_incisions(chest(), request);
        bool sternum = false;
        int made = 0;
        for (const FoundIncision& incision : search.found) {
            sternum = sternum || incision.kind == FoundIncision::Kind::sternum;
            Approach approach;
            try {
                approach = approach_of(chest(), incision, request);
            } catch (const InputError&) { // the template's own checks: no room for the blade
                continue;
            }
            ++made;
            const double length = incision_length(approach);
            EXPECT_LT((incision_place(approach, 0.5 * length).of(approach.incision) - incision.middle).norm(), 4.0)
                << place_in_words(incision);
            EXPECT_NEAR(length, incision.length_mm, 0.05 * incision.length_mm);
            EXPECT_TRUE(approach.retractor);
            EXPECT_TRUE(approach.rationale.starts_with("Found by a search"));
        }
        EXPECT_TRUE(sternum);
        EXPECT_GE(made, 3);
    }

    TEST(IncisionSearch, RefusesWhatLeavesNothingToTry)
    {
        const auto refuses = [](const SearchRequest& request) {
            EXPECT_THROW(static_cast<void>(search_incisions(chest(), request)), InputError);
        };
        SearchRequest request = chest_request();
        request.limits.left = request.limits.right = false;
        refuses(request);
        request = chest_request();
        request.limits.shortest_mm = 130.0;
        refuses(request);
        request = chest_request();
        request.limits.lowest_space = 12;
        refuses(request);
        request = chest_request();
        request.opening_mm = std::nan("");
        refuses(request);
        request = chest_request();
        request.target.label = "no such label";
        refuses(request);
        request = chest_request();
        request.weights.fill(0.0);
        request.weights.back() = 1.0; // the force, which rays do not know
        refuses(request);
    }

    TEST(IncisionSearch, StopsWhenAsked)
    {
        const std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_EQ(search_incisions(chest(), chest_request(), job).status, SearchStatus::cancelled);
    }

} // namespace incision_search_test
} // namespace retractor::planner
