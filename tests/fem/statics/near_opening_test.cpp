#include "fem/statics/near_opening.h"

#include "fem/statics/opening.h"
#include "tests/support/wounds/hooked_block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace retractor::fem {
namespace near_opening_test {

    using namespace test_support;

    /// The block, and what lies within 9 mm of its hooks.
    struct Near {
        ElasticProblem problem = test_support::hooked_block(4, 4);
        OpeningOptions options { .elasticity = Elasticity::corotational, .tolerance = 1e-7 };
        Near() { options.near = test_support::near_hooks(problem); }
        OpeningResult open(const Job& job = {}) const
        {
            return Opening(problem.mesh, problem.material_of_label, problem.supports, options).open(problem.hooks, job);
        }
        double change() const
        {
            Near lenient = *this;
            lenient.options.far_tolerance = 1e9;
            const OpeningResult result = lenient.open();
            EXPECT_EQ(result.status, OpeningStatus::converged) << result.message;
            return result.far ? result.far->change : 0.0;
        }
        void pull(double times)
        {
            for (HookPatch& hook : problem.hooks)
                hook.displacement *= times;
        }
    };

    TEST(NearOpening, CancelledAnywhereItEndsWithAFieldAndNoClaim)
    {
        Near near;
        near.pull(2.0);
        const double change = near.change();
        for (const double share : { 0.01, 0.5 }) { // the far field is given up on the way, and at rest
            near.options.far_tolerance = share * change;
            const OpeningResult undisturbed = near.open();
            ASSERT_EQ(undisturbed.status, OpeningStatus::converged) << undisturbed.message;
            ASSERT_TRUE(undisturbed.far && !undisturbed.far->kept);
            int cancelled_at = 0;
            for (int k = 1;; ++k) {
                std::atomic<bool> cancel = false;
                int reports = 0;
                Job job;
                job.cancel = &cancel;
                job.on_progress = [&](std::string_view, double) { cancel = cancel || ++reports == k; };
                const OpeningResult result = near.open(job);
                ASSERT_EQ(result.displacement.rows(), near.problem.mesh.vertices.rows());
                ASSERT_EQ(result.hook_forces_N.size(), near.problem.hooks.size());
                EXPECT_TRUE(result.displacement.allFinite());
                EXPECT_EQ(result.strain.size(), near.problem.mesh.tet_count());
                if (result.status == OpeningStatus::converged) { // after all was done
                    EXPECT_EQ(result.displacement, undisturbed.displacement);
                    break;
                }
                ASSERT_EQ(result.status, OpeningStatus::cancelled) << k << ": " << result.message;
                EXPECT_NE(result.message.find("cancelled"), std::string::npos);
                cancelled_at = k;
            }
            EXPECT_GE(cancelled_at, near.options.load_steps);
        }
    }

    TEST(NearOpening, CancelledWhereTheCondensedRegionIsGivenUpItKeepsTheLastGoodState)
    {
        Near near;
        near.pull(2.0);
        near.options.far_tolerance = 0.5 * near.change();
        std::atomic<bool> cancel = false;
        Job job;
        job.cancel = &cancel;
        job.on_progress = [&](std::string_view, double fraction) { cancel = cancel || fraction == 1.0; };
        const OpeningResult result = near.open(job);
        EXPECT_EQ(result.status, OpeningStatus::cancelled);
        EXPECT_FALSE(result.far.has_value()) << "what was not solved with all elements does not say so";
        const auto& nodes = near.problem.hooks[1].nodes;
        EXPECT_LT((result.displacement.row(nodes.front()).transpose() - near.problem.hooks[1].displacement).norm(),
            1e-9); // it was given up at rest
        EXPECT_GT(result.hook_forces_N[1].norm(), 0.0);
    }

    TEST(NearOpening, FarElementsThatAreTurnedOverAreNeverKept)
    {
        // The hooks crush the far tissue under them.
        Near near;
        near.options.elasticity = Elasticity::hyperelastic;
        near.options.far_tolerance = std::numeric_limits<double>::infinity();
        Points points(0, 3);
        for (const HookPatch& hook : near.problem.hooks)
            for (const VertexId v : hook.nodes) {
                points.conservativeResize(points.rows() + 1, 3);
                points.row(points.rows() - 1) = near.problem.mesh.vertices.row(v);
            }
        near.options.near = elements_near(near.problem.mesh, points, 1.0);
        bool any = false;
        for (const double down : { 6.0, 9.0, 12.0, 14.0 }) {
            for (HookPatch& hook : near.problem.hooks)
                hook.displacement = Vec3(0.0, 0.0, -down);
            const OpeningResult result = near.open();
            if (!result.far)
                continue;
            any = any || std::isinf(result.far->change);
            EXPECT_EQ(result.far->kept, std::isfinite(result.far->change)) << down << " mm";
            EXPECT_EQ(result.far->displacement_change.rows() > 0, result.far->kept);
        }
        EXPECT_TRUE(any) << "no far element was turned over";
    }

    TEST(NearOpening, TheChangeIsToldWithTheStiffnessOfTheAnswer)
    {
        Near near;
        near.pull(3.0);
        near.options.load_steps = 1;
        near.options.far_tolerance = 1e9;
        const OpeningResult linear = near.open();
        ASSERT_TRUE(linear.far && linear.far->kept);
        NonlinearRegion field(near.problem.mesh, near.problem.material_of_label, near.problem.supports,
            near.problem.hooks, near.options.near,
            { .elasticity = near.options.elasticity, .tolerance = near.options.tolerance });
        std::vector<Vec3> to;
        for (const HookPatch& hook : near.problem.hooks)
            to.push_back(hook.displacement);
        (void)drag_in_steps(field, std::vector<HookDrive>(to.size()), prescribed_drives(to), { .least_steps = 1 }, {});
        ASSERT_EQ(field.settle().status, NearStatus::settled);
        const FarChange stale = field.far_change();
        field.refresh();
        const FarChange fresh = field.far_change();
        constexpr double kSame = 1e-4; // two ways to one rest, to the tolerance
        const auto off = [&](const FarChange& change) {
            const Points told = Eigen::Map<const Points>(change.displacement.data(), change.displacement.size() / 3, 3);
            return (linear.far->displacement_change - told).norm() / told.norm();
        };
        EXPECT_LT(off(fresh), kSame);
        EXPECT_GT(off(stale), 10.0 * kSame) << "the two do not differ here: nothing is tested";
    }

    TEST(NearOpening, WhereNoRestIsFoundTheLargestForceLeftIsNamed)
    {
        Near near;
        near.options.max_newton_iterations = 1;
        near.options.tolerance = 1e-15; // less than round-off leaves
        for (const bool all : { false, true }) {
            if (all)
                near.options.near.assign(near.problem.mesh.tet_count(), 1);
            const OpeningResult result = near.open();
            ASSERT_EQ(result.status, OpeningStatus::not_converged);
            EXPECT_NE(result.message.find("the largest force left is"), std::string::npos) << result.message;
        }
    }

} // namespace near_opening_test
} // namespace retractor::fem
