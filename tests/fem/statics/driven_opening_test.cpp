#include "fem/statics/driven_opening.h"

#include "fem/statics/nonlinear_region.h"
#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"
#include "tests/support/wounds/hooked_block.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <atomic>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::fem {
namespace driven_opening_test {

    using namespace test_support;

    constexpr double kLinear = 1e-6; // hooks rest where one solve puts them; openings are solved to 1e-9
    constexpr double kNonlinear = 1e-3; // Newton's next step is at most half of it

    const OpeningOptions kLinearOptions { .elasticity = Elasticity::linear, .tolerance = 1e-9 };

    /// The block with its first hook alone, whose stiffness by the opening itself is R.
    struct OneHook {
        ElasticProblem problem = test_support::hooked_block(4, 4);
        Mat3 R;
        OneHook()
        {
            problem.hooks.resize(1);
            Opening opening(problem.mesh, problem.material_of_label, problem.supports, kLinearOptions);
            for (int axis = 0; axis < 3; ++axis) {
                problem.hooks[0].displacement = Vec3::Unit(axis);
                R.col(axis) = opening.open(problem.hooks).hook_forces_N[0];
            }
        }
    };

    std::vector<HookDrive> by_position(const ElasticProblem& problem)
    {
        std::vector<HookDrive> drives;
        for (const HookPatch& hook : problem.hooks)
            drives.push_back({ .displacement = hook.displacement });
        return drives;
    }

    TEST(DrivenOpening, HooksMeetTheStiffnessThatOpeningsShow)
    {
        const OneHook one;
        const Points rest = Points::Zero(one.problem.mesh.vertices.rows(), 3);
        const Eigen::MatrixXd R = hook_response(one.problem, { Elasticity::linear }, rest).stiffness;
        EXPECT_LT((R - one.R).norm(), kLinear * one.R.norm());
    }

    TEST(DrivenOpening, TheStiffnessOfStretchedTissueIsTheDerivativeOfItsForces)
    {
        ElasticProblem problem = test_support::hooked_block(4, 4);
        Opening opening(problem.mesh, problem.material_of_label, problem.supports,
            { .elasticity = Elasticity::hyperelastic, .tolerance = 1e-10 });
        const OpeningResult here = opening.open(problem.hooks);
        ASSERT_EQ(here.status, OpeningStatus::converged);
        const Eigen::MatrixXd R = hook_response(problem, { Elasticity::hyperelastic }, here.displacement).stiffness;
        constexpr double kStep = 1e-3, kTruncation = 1e-4; // mm; of the second order, in a motion of millimetres
        for (const int column : { 0, 2, 4 }) {
            std::vector<Eigen::VectorXd> forces;
            for (const double way : { kStep, -kStep }) {
                std::vector<HookPatch> hooks = problem.hooks;
                hooks[static_cast<std::size_t>(column / 3)].displacement[column % 3] += way;
                const OpeningResult there = opening.open(hooks);
                Eigen::VectorXd f(6);
                f << there.hook_forces_N[0], there.hook_forces_N[1];
                forces.push_back(f);
            }
            const Eigen::VectorXd slope = (forces[0] - forces[1]) / (2.0 * kStep);
            EXPECT_LT((slope - R.col(column)).norm(), kTruncation * R.norm());
        }
    }

    TEST(DrivenOpening, HooksLetGoInSofterTissueRestWhereItsOwnOpeningSays)
    {
        const ElasticProblem stiff = test_support::hooked_block(4, 4);
        ElasticProblem soft = stiff;
        for (Material& material : soft.material_of_label)
            material.youngs_modulus_MPa *= 0.6;
        for (BeddedVertex& bedded : soft.supports.bedded)
            bedded.stiffness *= 0.6;
        const OpeningResult told
            = Opening(stiff.mesh, stiff.material_of_label, stiff.supports, kLinearOptions).open(stiff.hooks);
        const std::vector<HookDrive> drives { { .force_N = 0.7 * told.hook_forces_N[0] },
            { .displacement = stiff.hooks[1].displacement, .force_limit_N = 0.5 * told.hook_forces_N[1].norm() } };
        const DrivenOpening here = open_driven(stiff, drives, kLinearOptions),
                            there = open_driven(soft, drives, kLinearOptions);
        ASSERT_TRUE(here.yielded[1]);
        const OpeningResult held
            = Opening(soft.mesh, soft.material_of_label, soft.supports, kLinearOptions).open(here.hooks);
        const HookResponse response = hook_response(stiff, { Elasticity::linear }, here.opening.displacement);
        std::vector<Vec3> at, expected;
        for (std::size_t h = 0; h < drives.size(); ++h) {
            at.push_back(here.hooks[h].displacement);
            expected.push_back(there.hooks[h].displacement);
        }
        const auto gone = release_hooks(
            response, packed(at), packed(here.opening.hook_forces_N), packed(held.hook_forces_N), drives);
        ASSERT_TRUE(gone.has_value());
        constexpr double kFarther = 0.3; // 1 / 0.6 of the way, less where the limit's hook reaches its place
        EXPECT_GT(gone->way.norm(), kFarther * packed(at).norm());
        EXPECT_LT((packed(at) + gone->way - packed(expected)).norm(), kLinear * packed(expected).norm());
        EXPECT_LT((gone->forces - packed(there.opening.hook_forces_N)).norm(), kLinear * gone->forces.norm());
        // The tissue goes along.
        const Eigen::VectorXd moved = response.displacement * gone->way;
        const Points after = held.displacement + Eigen::Map<const Points>(moved.data(), moved.size() / 3, 3);
        EXPECT_LT((after - there.opening.displacement).norm(), kLinear * after.norm());
    }

    TEST(DrivenOpening, HooksNearTheGapeOfTensionLetGoWhereTheirOwnOpeningSays)
    {
        // Tension gapes the wound by nearly as much as a small force does: what the hooks bear is little, whatever the
        // stiffness.
        ElasticProblem stiff = test_support::hooked_block(4, 4);
        for (const mesh::TetFace& face : mesh::boundary_faces(stiff.mesh)) {
            const auto corners = mesh::face_vertices(stiff.mesh, face);
            const auto is_hooked = [&](const HookPatch& hook) {
                return std::all_of(corners.begin(), corners.end(),
                    [&](VertexId v) { return std::find(hook.nodes.begin(), hook.nodes.end(), v) != hook.nodes.end(); });
            };
            for (const HookPatch& hook : stiff.hooks)
                if (is_hooked(hook))
                    stiff.loads.push_back({ face, Vec3(hook.side * 4e-3, 0.0, 0.0) });
        }
        ASSERT_FALSE(stiff.loads.empty());
        ElasticProblem soft = stiff;
        for (Material& material : soft.material_of_label)
            material.youngs_modulus_MPa *= 0.6;
        for (BeddedVertex& bedded : soft.supports.bedded)
            bedded.stiffness *= 0.6;
        const std::vector<HookDrive> drives { { .force_N = Vec3(-0.01, 0.0, 0.0) },
            { .force_N = Vec3(0.01, 0.0, 0.0) } };
        const DrivenOpening here = open_driven(stiff, drives, kLinearOptions),
                            there = open_driven(soft, drives, kLinearOptions);
        const OpeningResult held = Opening(soft, kLinearOptions).open(here.hooks);
        const Eigen::VectorXd forces = packed(here.opening.hook_forces_N), other = packed(held.hook_forces_N);
        ASSERT_GT(other.norm(), 10.0 * forces.norm()) << "more than could be told by the forces alone";
        std::vector<Vec3> at, expected;
        for (std::size_t h = 0; h < drives.size(); ++h) {
            at.push_back(here.hooks[h].displacement);
            expected.push_back(there.hooks[h].displacement);
        }
        const HookResponse response = hook_response(stiff, { Elasticity::linear }, here.opening.displacement);
        const auto gone = release_hooks(response, packed(at), forces, other, drives);
        ASSERT_TRUE(gone.has_value());
        EXPECT_LT((packed(at) + gone->way - packed(expected)).norm(), kLinear * packed(expected).norm());
    }

    TEST(DrivenOpening, ForcesTooFarApartTellNoRest)
    {
        const HookResponse R { Eigen::MatrixXd::Identity(3, 3), {} };
        const Eigen::VectorXd at = Vec3(2.0, 0.0, 0.0), forces = R.stiffness * at;
        const std::vector<HookDrive> pulled { { .force_N = Vec3(2.0, 0.0, 0.0) } };
        const auto gone = release_hooks(R, at, forces, 0.5 * forces, pulled);
        ASSERT_TRUE(gone.has_value());
        EXPECT_LT((gone->way - at).norm(), kLinear); // half as stiff: twice as far
        for (const double ratio : { 0.05, 20.0, -1.0, std::numeric_limits<double>::quiet_NaN() })
            EXPECT_FALSE(release_hooks(R, at, forces, ratio * forces, pulled).has_value()) << ratio;
    }

    TEST(DrivenOpening, OneHookYieldsAtItsLimitAndGripsAsSpringsInSeries)
    {
        const OneHook one;
        // Along a principal direction of the stiffness, force and way are numbers: f = k d.
        const Eigen::SelfAdjointEigenSolver<Mat3> modes(0.5 * (one.R + one.R.transpose()));
        const Vec3 n = modes.eigenvectors().col(1);
        const double k = modes.eigenvalues()[1], way = 4.0;
        for (const double share : { 0.3, 0.7, 1.4 }) {
            const double limit = share * k * way;
            const DrivenOpening found = open_driven(one.problem,
                std::vector { HookDrive { .displacement = way * n, .force_limit_N = limit } }, kLinearOptions);
            ASSERT_EQ(found.opening.status, OpeningStatus::converged) << found.opening.message;
            EXPECT_EQ(found.openings, 1);
            EXPECT_EQ(found.yielded[0], share < 1.0);
            const double force = std::min(limit, k * way);
            EXPECT_LT((found.opening.hook_forces_N[0] - force * n).norm(), kLinear * force);
            EXPECT_LT((found.hooks[0].displacement - force / k * n).norm(), kLinear * way);
        }
        const double grip = 0.4 * k;
        const DrivenOpening soft = open_driven(
            one.problem, std::vector { HookDrive { .displacement = way * n, .grip_N_per_mm = grip } }, kLinearOptions);
        EXPECT_FALSE(soft.yielded[0]);
        EXPECT_LT((soft.hooks[0].displacement - grip / (grip + k) * way * n).norm(), kLinear * way);
    }

    TEST(DrivenOpening, TheForceOfAPositionLeadsBackToIt)
    {
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        for (const Elasticity elasticity : { Elasticity::linear, Elasticity::corotational, Elasticity::hyperelastic }) {
            const OpeningOptions options { .elasticity = elasticity, .tolerance = 1e-9 };
            const DrivenOpening there = open_driven(problem, by_position(problem), options);
            ASSERT_EQ(there.opening.status, OpeningStatus::converged) << there.opening.message;
            for (std::size_t h = 0; h < problem.hooks.size(); ++h)
                EXPECT_EQ(there.hooks[h].displacement, problem.hooks[h].displacement);
            std::vector<HookDrive> pulls;
            for (const Vec3& force : there.opening.hook_forces_N)
                pulls.push_back({ .force_N = force });
            const DrivenOpening back = open_driven(problem, pulls, options);
            ASSERT_EQ(back.opening.status, OpeningStatus::converged) << back.opening.message;
            const double same = elasticity == Elasticity::linear ? kLinear : kNonlinear;
            for (std::size_t h = 0; h < problem.hooks.size(); ++h) {
                const Vec3 way = problem.hooks[h].displacement;
                EXPECT_LT((back.hooks[h].displacement - way).norm(), same * way.norm());
                EXPECT_LT((back.opening.hook_forces_N[h] - *pulls[h].force_N).norm(), same * pulls[h].force_N->norm());
            }
            EXPECT_LE((back.opening.displacement - there.opening.displacement).cwiseAbs().maxCoeff(),
                same * there.opening.displacement.cwiseAbs().maxCoeff());
        }
    }

    TEST(DrivenOpening, ALimitHoldsInNonlinearTissueToo)
    {
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        const OpeningOptions options { .elasticity = Elasticity::hyperelastic, .tolerance = 1e-8 };
        std::vector<HookDrive> drives = by_position(problem);
        const DrivenOpening free = open_driven(problem, drives, options);
        const double limit = 0.5 * free.opening.hook_forces_N[0].norm();
        drives[0].force_limit_N = limit;
        const DrivenOpening held = open_driven(problem, drives, options);
        ASSERT_EQ(held.opening.status, OpeningStatus::converged) << held.opening.message;
        EXPECT_TRUE(held.yielded[0]);
        EXPECT_FALSE(held.yielded[1]);
        EXPECT_NEAR(held.opening.hook_forces_N[0].norm(), limit, kNonlinear * limit);
        EXPECT_LT(held.hooks[0].displacement.norm(), problem.hooks[0].displacement.norm());
        const Vec3 slip = drives[0].displacement - held.hooks[0].displacement, force = held.opening.hook_forces_N[0];
        EXPECT_GT(slip.dot(force), (1.0 - kNonlinear) * slip.norm() * force.norm()); // it slips the way it is pulled
    }

    TEST(DrivenOpening, HooksYieldInTissueThatIsNonlinearNearThemOnly)
    {
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        std::vector<HookDrive> drives = by_position(problem);
        OpeningOptions options { .elasticity = Elasticity::hyperelastic, .far_tolerance = 1.0, .tolerance = 1e-8 };
        const DrivenOpening whole = open_driven(problem, drives, options);
        const double limit = 0.5 * whole.opening.hook_forces_N[0].norm();
        drives[0].force_limit_N = limit;
        drives[1].grip_N_per_mm = 0.5;
        options.near = test_support::near_hooks(problem);
        ASSERT_NE(std::count(options.near.begin(), options.near.end(), 0), 0);
        const DrivenOpening near = open_driven(problem, drives, options);
        ASSERT_EQ(near.opening.status, OpeningStatus::converged) << near.opening.message;
        ASSERT_TRUE(near.opening.far && near.opening.far->kept);
        EXPECT_EQ(near.yielded, (std::vector<bool> { true, false }));
        const Vec3 slip = drives[0].displacement - near.hooks[0].displacement, force = near.opening.hook_forces_N[0];
        EXPECT_NEAR(force.norm(), limit, kNonlinear * limit);
        EXPECT_GT(slip.dot(force), (1.0 - kNonlinear) * slip.norm() * force.norm());
        const Vec3 stretched = drives[1].displacement - near.hooks[1].displacement;
        EXPECT_LT((0.5 * stretched - near.opening.hook_forces_N[1]).norm(),
            kNonlinear * near.opening.hook_forces_N[1].norm());
    }

    TEST(DrivenOpening, ACondensedRegionThatIsGivenUpStaysSo)
    {
        const ElasticProblem problem = test_support::hooked_block(4, 4);
        std::vector<HookDrive> drives = by_position(problem);
        drives[0].grip_N_per_mm = drives[1].grip_N_per_mm = 0.5;
        OpeningOptions options { .elasticity = Elasticity::hyperelastic, .tolerance = 1e-8 };
        const DrivenOpening whole = open_driven(problem, drives, options);
        options.near = test_support::near_hooks(problem);
        options.far_tolerance = 1e9;
        const DrivenOpening linear = open_driven(problem, drives, options);
        ASSERT_TRUE(linear.opening.far && linear.opening.far->kept);
        for (const double share :
            { 0.01, 0.99, 1.01 }) { // by the first opening; at rest, where it was asked for; never
            options.far_tolerance = share * linear.opening.far->change;
            const DrivenOpening found = open_driven(problem, drives, options);
            ASSERT_EQ(found.opening.status, OpeningStatus::converged) << found.opening.message;
            ASSERT_TRUE(found.opening.far);
            EXPECT_EQ(found.opening.far->kept, share > 1.0) << share;
            const DrivenOpening& same = share > 1.0 ? linear : whole;
            for (std::size_t h = 0; h < 2; ++h)
                EXPECT_LT((found.opening.hook_forces_N[h] - same.opening.hook_forces_N[h]).norm(),
                    kNonlinear * same.opening.hook_forces_N[h].norm());
        }
    }

    TEST(DrivenOpening, LinearTissueThatTouchesIsPressedByTheForceAskedFor)
    {
        // A block above another, 0.3 mm between them; its own bed is softer than what it comes to rest on.
        constexpr double kGap = 0.3, kEdge = 2.5, kHeight = 5.0, kSoftBed = 3e-3, kPushN = 0.25;
        const mesh::TetMesh block = mesh::kuhn_box(4, 4, 2, kEdge);
        ElasticProblem problem;
        problem.mesh = block;
        const auto split = static_cast<VertexId>(block.vertex_count());
        problem.mesh.vertices.conservativeResize(2 * block.vertices.rows(), 3);
        problem.mesh.vertices.bottomRows(split)
            = block.vertices.rowwise() + Eigen::RowVector3d(0.0, 0.0, kHeight + kGap);
        for (const VertexId v : block.nodes)
            problem.mesh.nodes.push_back(v + split);
        problem.mesh.labels.insert(problem.mesh.labels.end(), block.labels.begin(), block.labels.end());
        problem.material_of_label = { {}, test_support::material(0.05, 0.3) };
        problem.hooks = { { .name = "press", .side = 1, .nodes = {} } };
        constexpr double kRoundOff = 1e-9;
        for (VertexId v = 0; v < 2 * split; ++v) {
            const double z = problem.mesh.vertices(v, 2);
            if (z < kRoundOff)
                problem.supports.fixed.push_back(v);
            else if (z > 2.0 * kHeight + kGap - kRoundOff)
                problem.hooks[0].nodes.push_back(v);
            else if (v >= split)
                problem.supports.bedded.push_back({ v, kSoftBed });
        }
        const OpeningOptions options {
            .elasticity = Elasticity::linear, .tolerance = 1e-8, .contact = ContactOptions {}
        };
        const DrivenOpening found
            = open_driven(problem, std::vector { HookDrive { .force_N = Vec3(0.0, 0.0, -kPushN) } }, options);
        ASSERT_EQ(found.opening.status, OpeningStatus::converged) << found.opening.message;
        EXPECT_GT(found.opening.contact.touching, 0);
        EXPECT_LT((found.opening.hook_forces_N[0] - Vec3(0.0, 0.0, -kPushN)).norm(), 0.01 * kPushN);
        const Eigen::MatrixXd R
            = hook_response(problem, { Elasticity::linear }, found.opening.displacement, options.contact).stiffness;
        std::vector<HookPatch> hooks = found.hooks;
        constexpr double kStep = 1e-3;
        hooks[0].displacement.z() -= kStep;
        const OpeningResult lower
            = Opening(problem.mesh, problem.material_of_label, problem.supports, options).open(hooks);
        ASSERT_EQ(lower.status, OpeningStatus::converged) << lower.message;
        EXPECT_NEAR((found.opening.hook_forces_N[0] - lower.hook_forces_N[0]).z() / kStep, R(2, 2), 0.02 * R(2, 2));
    }

    TEST(DrivenOpening, HooksThatShareANodeAreRefusedUnlessTheyAreMovedAlike)
    {
        ElasticProblem problem = test_support::hooked_block(4, 4);
        problem.hooks[1].nodes.push_back(problem.hooks[0].nodes.front());
        std::vector<HookDrive> drives(2, HookDrive { .displacement = Vec3(0.0, 0.0, 1.0) });
        const DrivenOpening alike = open_driven(problem, drives, kLinearOptions);
        EXPECT_EQ(alike.opening.status, OpeningStatus::converged);
        drives[1].grip_N_per_mm = 0.5;
        try {
            (void)open_driven(problem, drives, kLinearOptions);
            FAIL() << "nothing was thrown";
        } catch (const InputError& error) {
            const std::string what = error.what();
            for (const HookPatch& hook : problem.hooks)
                EXPECT_NE(what.find("'" + hook.name + "'"), std::string::npos) << what;
            EXPECT_NE(what.find("share node"), std::string::npos) << what;
        }
    }

    TEST(DrivenOpening, AForceThatTissueCannotFollowIsGivenUpAndSaidHowFarItWent)
    {
        const ElasticProblem problem = test_support::hooked_block(2, 4);
        const OpeningOptions options { .elasticity = Elasticity::corotational };
        constexpr double kTorn = 4.0, kFarMoreN = 3e3; // some 10 N/mm resist in tissue of 0.04 to 0.2 MPa
        std::vector<HookDrive> drives(2);
        drives[0].displacement = Vec3(-3.0, 0.0, 0.0);
        drives[1].force_N = Vec3(kFarMoreN, 0.0, 0.0);
        const DrivenOpening found = open_driven(problem, drives, options);
        EXPECT_EQ(found.opening.status, OpeningStatus::not_converged);
        EXPECT_GT(found.opening.strain_p99, kTorn);
        const double reached = found.opening.hook_forces_N[1].norm();
        EXPECT_GT(reached, 0.0);
        EXPECT_LT(reached, kFarMoreN);
        EXPECT_LT(found.hooks[1].displacement.norm(), kFarthestHookMm);
        const std::string& message = found.opening.message;
        for (const char* said : { "hook 'right' has moved", "mm farther", "tissue tears before" })
            EXPECT_NE(message.find(said), std::string::npos) << message;
        drives[1].force_N = Vec3(1.0, 0.0, 0.0);
        EXPECT_EQ(open_driven(problem, drives, options).opening.status, OpeningStatus::converged);
    }

    TEST(DrivenOpening, HooksThatNothingHoldsBackAreGivenUpWhereNoWoundGoes)
    {
        ElasticProblem problem = test_support::hooked_block(2, 4); // on its beds alone it goes along, hardly strained
        problem.supports.fixed.clear();
        std::vector<HookDrive> drives(2);
        for (HookDrive& drive : drives)
            drive.force_N = Vec3(0.0, 0.0, 1.0e3);
        const DrivenOpening found = open_driven(problem, drives, { .elasticity = Elasticity::corotational });
        EXPECT_EQ(found.opening.status, OpeningStatus::not_converged);
        EXPECT_GT(std::max(found.hooks[0].displacement.norm(), found.hooks[1].displacement.norm()), kFarthestHookMm);
        EXPECT_NE(found.opening.message.find("a hook moves at most 150 mm"), std::string::npos)
            << found.opening.message;
    }

    TEST(DrivenOpening, ProgressOnlyRisesThroughAllItsOpenings)
    {
        const ElasticProblem problem = test_support::hooked_block(2, 4);
        std::vector<HookDrive> drives = by_position(problem);
        drives[1] = { .displacement = Vec3(25.0, 0.0, 0.0), .grip_N_per_mm = 1e3 };
        std::vector<double> fractions;
        Job job;
        job.on_progress = [&](std::string_view stage, double fraction) {
            EXPECT_EQ(stage, "opening");
            fractions.push_back(fraction);
        };
        const DrivenOpening found = open_driven(problem, drives, { .elasticity = Elasticity::corotational }, job);
        ASSERT_EQ(found.opening.status, OpeningStatus::converged) << found.opening.message;
        ASSERT_GT(found.openings, 2);
        ASSERT_FALSE(fractions.empty());
        EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
        EXPECT_EQ(fractions.back(), 1.0);
        EXPECT_LT(fractions.front(), 1.0 / 3.0);
    }

    TEST(DrivenOpening, SaysWhyItStoppedAndNamesWhatIsWrong)
    {
        const ElasticProblem problem = test_support::hooked_block(2, 4);
        const auto message = [&](std::vector<HookDrive> drives) -> std::string {
            try {
                (void)open_driven(problem, drives, kLinearOptions);
            } catch (const InputError& error) {
                return error.where() + ": " + error.what();
            }
            return "nothing was thrown";
        };
        EXPECT_NE(message({ HookDrive {} }).find("there are 2 hooks and 1 drives"), std::string::npos);
        std::vector<HookDrive> bad(2);
        bad[1].force_limit_N = std::numeric_limits<double>::quiet_NaN();
        EXPECT_NE(message(bad).find("hook '" + problem.hooks[1].name + "'"), std::string::npos) << message(bad);
        const std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        const DrivenOpening stopped
            = open_driven(problem, by_position(problem), { .elasticity = Elasticity::hyperelastic }, job);
        EXPECT_EQ(stopped.opening.status, OpeningStatus::cancelled);
    }

} // namespace driven_opening_test
} // namespace retractor::fem
