#include "fem/statics/frame_opening.h"

#include "fem/statics/driven_opening.h"
#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "tests/support/wounds/hooked_block.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::fem {
namespace frame_opening_test {

    constexpr double kOpeningMm = 6.0;
    constexpr double kDegree = std::numbers::pi / 180.0;
    constexpr double kRoundOff = 1e-12;
    /// Search and openings are much more exact than a plan needs, so that two ways to one answer can be compared.
    const FrameOptions kExact { .tolerance = 1e-6 };
    constexpr double kSame = 1e-4; // relative; openings are solved to 1e-8, searches to 1e-6
    const OpeningOptions kExactOpening { .elasticity = Elasticity::corotational, .tolerance = 1e-8 };

    /// A frame over the block: its two hooks become blades whose arms run along y, 10 mm above the block.
    struct FramedBlock {
        ElasticProblem problem = test_support::hooked_block(4, 4);
        BladeFrame frame;

        explicit FramedBlock(double play = 30.0 * kDegree)
        {
            frame[0]
                = { .pivot = Vec3(15.0, 20.0, 30.0), .arm = Vec3::UnitY(), .outward = -Vec3::UnitX(), .play = play };
            frame[1]
                = { .pivot = Vec3(45.0, 20.0, 30.0), .arm = Vec3::UnitY(), .outward = Vec3::UnitX(), .play = play };
        }

        FrameOpening open(const RackDrive& drive = { .distance_mm = kOpeningMm },
            const OpeningOptions& options = kExactOpening, const FrameOptions& how = kExact) const
        {
            return open_with_frame(problem, frame, drive, options, how);
        }
    };

    double blade_force(const FrameOpening& opened)
    {
        return std::max(opened.loads[0].force_N.norm(), opened.loads[1].force_N.norm());
    }

    /// Moment of a blade's load about its arm, N mm.
    double moment_about_arm(const FramedBlock& block, const FrameOpening& opened, std::size_t blade)
    {
        return opened.loads[blade].moment_Nmm.dot(opened.state.rotation * block.frame[blade].arm);
    }

    TEST(BladeFrame, ABladeThatTurnsAQuarterCarriesItsNodesRound)
    {
        const BladeFrame frame { FrameBlade { .pivot = Vec3(-1.0, 0.0, 0.0), .outward = -Vec3::UnitX() },
            FrameBlade { .pivot = Vec3(1.0, 0.0, 0.0), .outward = Vec3::UnitX() } };
        FrameState state;
        state.distance = 4.0;
        state.turn = { 0.0, 0.5 * std::numbers::pi }; // about y: z goes to x
        const std::vector<HookPatch> blades = blades_at(frame, state, std::vector<HookPatch>(2));
        EXPECT_LT((blades[0].displacement - Vec3(-2.0, 0.0, 0.0)).norm(), kRoundOff);
        EXPECT_FALSE(blades[0].turns());
        EXPECT_LT((blades[1].displacement_of(Vec3(1.0, 0.0, -3.0)) - Vec3(2.0 - 3.0, 0.0, 3.0)).norm(), kRoundOff);
    }

    TEST(BladeFrame, TheMomentOfABladeIsLeverTimesForce)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(1, 1, 1, 10.0);
        std::vector<HookPatch> blades(2);
        blades[0].nodes = { 0 };
        blades[0].pivot = mesh.vertices.row(0).transpose() - Vec3(0.0, 0.0, 5.0);
        Eigen::VectorXd forces = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        forces.head<3>() = Vec3(2.0, 0.0, 0.0);
        const auto loads = blade_loads(mesh, blades, forces);
        EXPECT_LT((loads[0].force_N - Vec3(2.0, 0.0, 0.0)).norm(), kRoundOff);
        EXPECT_LT((loads[0].moment_Nmm - Vec3(0.0, 10.0, 0.0)).norm(), kRoundOff); // 5 mm along z times 2 N along x
        EXPECT_EQ(loads[1].force_N, Vec3(Vec3::Zero()));
    }

    TEST(BladeFrame, ItsStiffnessIsTheDerivativeOfItsForces)
    {
        const FramedBlock block;
        const OpeningOptions options { .elasticity = Elasticity::hyperelastic, .tolerance = 1e-10 };
        const double lever = frame_lever(block.problem.mesh, block.frame, block.problem.hooks);
        FrameState here;
        here.distance = kOpeningMm;
        here.turn = { 0.02, -0.03 };
        Opening opening(block.problem, options);
        const auto forces_at = [&](const FrameState& state, std::array<BladeLoad, 2>& loads, Points& displacement) {
            const std::vector<HookPatch> blades = blades_at(block.frame, state, block.problem.hooks);
            const OpeningResult opened = opening.open(blades);
            EXPECT_EQ(opened.status, OpeningStatus::converged) << opened.message;
            loads = blade_loads(block.problem.mesh, blades, opened.hook_nodal_forces_N);
            displacement = opened.displacement;
            return generalised_forces(block.frame, state, loads, lever);
        };
        std::array<BladeLoad, 2> loads, ignored;
        Points displacement, not_used;
        (void)forces_at(here, loads, displacement);
        const HookResponse response = motion_response(block.problem, { Elasticity::hyperelastic }, displacement,
            blade_motions(block.problem.mesh, blades_at(block.frame, here, block.problem.hooks)));
        const FrameMatrix J = frame_stiffness(block.frame, here, loads, response.stiffness, lever);
        constexpr double kStep = 1e-3, kTruncation = 1e-3; // mm; of the second order, in a motion of millimetres
        for (int i = 0; i < kFrameUnknowns; ++i) {
            FrameVector step = FrameVector::Zero();
            step[i] = kStep;
            const FrameVector slope = (forces_at(moved_by(here, step, lever), ignored, not_used)
                                          - forces_at(moved_by(here, -step, lever), ignored, not_used))
                / (2.0 * kStep);
            EXPECT_LT((slope - J.col(i)).norm(), kTruncation * J.norm()) << "unknown " << i;
        }
    }

    TEST(FrameOpening, ForcesAndMomentsOfAFreeFrameSumToZero)
    {
        // The beds of the block's two ends differ, so that a frame that stays in place is not in balance.
        const FramedBlock block;
        for (const Elasticity elasticity : { Elasticity::linear, Elasticity::corotational, Elasticity::hyperelastic }) {
            const FrameOptions how {};
            const FrameOpening opened = block.open({ .distance_mm = kOpeningMm }, { .elasticity = elasticity }, how);
            ASSERT_EQ(opened.opening.status, OpeningStatus::converged) << opened.opening.message;
            const double force = blade_force(opened);
            ASSERT_GT(force, 0.0);
            // Independently of the frame: the nodal forces at the nodes where they are.
            Vec3 resultant = Vec3::Zero(), moment = Vec3::Zero();
            for (const HookPatch& blade : opened.blades)
                for (const VertexId v : blade.nodes) {
                    const Vec3 f = opened.opening.hook_nodal_forces_N.segment<3>(3 * static_cast<Eigen::Index>(v));
                    const Vec3 x
                        = (block.problem.mesh.vertices.row(v) + opened.opening.displacement.row(v)).transpose();
                    resultant += f;
                    moment += (x - frame_centre(block.frame) - opened.state.translation).cross(f);
                }
            const double lever = frame_lever(block.problem.mesh, block.frame, block.problem.hooks);
            constexpr double kSlack = 1.01; // sums in another order
            EXPECT_LE(resultant.norm(), kSlack * how.tolerance * force);
            EXPECT_LE(moment.norm(), kSlack * how.tolerance * force * lever);
            EXPECT_LE(opened.imbalance, how.tolerance);
            EXPECT_DOUBLE_EQ(opened.state.distance, kOpeningMm);
        }
    }

    TEST(FrameOpening, ABladeTurnsFreelyWithinItsPlayAndIsHeldAtItsEnd)
    {
        const FrameOpening fixed = FramedBlock(0.0).open();
        EXPECT_EQ(fixed.state.turn[0], 0.0);
        EXPECT_EQ(fixed.state.turn[1], 0.0);

        const FramedBlock loose(80.0 * kDegree);
        const FrameOpening turned = loose.open();
        ASSERT_EQ(turned.opening.status, OpeningStatus::converged) << turned.opening.message;
        const double lever = frame_lever(loose.problem.mesh, loose.frame, loose.problem.hooks);
        for (const std::size_t k : { 0U, 1U })
            EXPECT_LE(std::abs(moment_about_arm(loose, turned, k)), kExact.tolerance * lever * blade_force(turned));
        // Tissue below the arm holds the blade back, so that a free blade turns.
        const double free_turn = std::min(std::abs(turned.state.turn[0]), std::abs(turned.state.turn[1]));
        ASSERT_GT(free_turn, 0.0);

        const FramedBlock stopped(0.5 * free_turn);
        const FrameOpening held = stopped.open();
        ASSERT_EQ(held.opening.status, OpeningStatus::converged) << held.opening.message;
        for (const std::size_t k : { 0U, 1U }) {
            EXPECT_NEAR(std::abs(held.state.turn[k]), stopped.frame[k].play, kRoundOff);
            EXPECT_LT(moment_about_arm(stopped, held, k) * held.state.turn[k], 0.0) << "the arm holds the blade back";
        }
    }

    TEST(FrameOpening, TheForceThatADistanceTakesOpensThisDistance)
    {
        const FramedBlock block;
        const FrameOpening by_distance = block.open();
        ASSERT_EQ(by_distance.opening.status, OpeningStatus::converged) << by_distance.opening.message;
        const FrameOpening by_force = block.open({ .force_N = by_distance.rack_force_N });
        ASSERT_EQ(by_force.opening.status, OpeningStatus::converged) << by_force.opening.message;
        EXPECT_NEAR(by_force.state.distance, kOpeningMm, kSame * kOpeningMm);
        EXPECT_NEAR(by_force.rack_force_N, by_distance.rack_force_N, kSame * by_distance.rack_force_N);
    }

    TEST(FrameOpening, RotatingTheWholeProblemRotatesTheAnswer)
    {
        const FramedBlock block;
        const Mat3 R = Eigen::AngleAxisd(0.7, Vec3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
        FramedBlock rotated = block;
        rotated.problem.mesh.vertices = block.problem.mesh.vertices * R.transpose();
        for (FrameBlade& blade : rotated.frame)
            blade
                = { .pivot = R * blade.pivot, .arm = R * blade.arm, .outward = R * blade.outward, .play = blade.play };
        const FrameOpening here = block.open(), there = rotated.open();
        ASSERT_EQ(there.opening.status, OpeningStatus::converged) << there.opening.message;
        const double force = blade_force(here),
                     lever = frame_lever(block.problem.mesh, block.frame, block.problem.hooks);
        for (const std::size_t k : { 0U, 1U }) {
            EXPECT_LT((there.loads[k].force_N - R * here.loads[k].force_N).norm(), kSame * force);
            EXPECT_LT((there.loads[k].moment_Nmm - R * here.loads[k].moment_Nmm).norm(), kSame * force * lever);
            EXPECT_NEAR(there.state.turn[k], here.state.turn[k], kSame);
        }
        EXPECT_LT((there.state.translation - R * here.state.translation).norm(), kSame * kOpeningMm);
    }

    TEST(FrameOpening, ASymmetricBlockHoldsTheFrameInTheMiddle)
    {
        // The cubes of this mesh are divided along one diagonal. The mesh is symmetric about its centre, and so are the
        // beds and the blades; it has no plane of symmetry.
        ElasticProblem problem;
        problem.mesh = mesh::kuhn_box(12, 8, 4, 5.0);
        std::fill(problem.mesh.labels.begin(), problem.mesh.labels.end(), Label { 1 });
        problem.material_of_label = { {}, { "tissue", 0.04, 0.3, 1e-9, "test" } };
        problem.hooks.resize(2);
        problem.hooks[0].side = -1;
        problem.hooks[1].side = 1;
        for (VertexId v = 0; v < problem.mesh.vertices.rows(); ++v) {
            const Vec3 p = problem.mesh.vertices.row(v).transpose();
            if (p.x() < kRoundOff || p.x() > 60.0 - kRoundOff)
                problem.hooks[p.x() < 30.0 ? 0 : 1].nodes.push_back(v);
            else
                problem.supports.bedded.push_back({ v, 0.01 });
        }
        const BladeFrame frame { FrameBlade { .pivot = Vec3(0.0, 20.0, 10.0), .outward = -Vec3::UnitX(), .play = 0.5 },
            FrameBlade { .pivot = Vec3(60.0, 20.0, 10.0), .outward = Vec3::UnitX(), .play = 0.5 } };
        const FrameOpening opened
            = open_with_frame(problem, frame, { .distance_mm = kOpeningMm }, kExactOpening, kExact);
        ASSERT_EQ(opened.opening.status, OpeningStatus::converged) << opened.opening.message;
        EXPECT_LT(opened.state.translation.norm(), kSame * kOpeningMm);
        EXPECT_NEAR(opened.loads[0].force_N.norm(), opened.loads[1].force_N.norm(), kSame * blade_force(opened));
        EXPECT_NEAR(opened.state.turn[0], opened.state.turn[1], kSame);
        constexpr double kMeshTurn = 1.0 * kDegree; // the diagonals of the cubes resist shear a little one-sidedly
        EXPECT_LT(std::abs(opened.state.turn[0]), kMeshTurn);
    }

    TEST(FrameOpening, ASearchThatBeginsAtItsAnswerEndsThere)
    {
        const FramedBlock block;
        const FrameOpening first = block.open();
        ASSERT_EQ(first.opening.status, OpeningStatus::converged) << first.opening.message;
        const FrameOpening again = open_with_frame(block.problem, block.frame, { .distance_mm = kOpeningMm },
            kExactOpening, { .tolerance = 10.0 * kExact.tolerance }, {},
            FrameStart { first.state, first.opening.displacement, first.stiffness });
        EXPECT_EQ(again.openings, 1);
        EXPECT_LT((again.opening.displacement - first.opening.displacement).norm(),
            kSame * first.opening.displacement.norm());
    }

    TEST(FrameOpening, ARoughBalanceIsSolvedToTheFullTolerance)
    {
        const FramedBlock block;
        const FrameOptions rough { .tolerance = 0.05 };
        const FrameOpening found = block.open({ .distance_mm = kOpeningMm }, kExactOpening, rough);
        ASSERT_EQ(found.opening.status, OpeningStatus::converged) << found.opening.message;
        EXPECT_LE(found.imbalance, rough.tolerance);
        EXPECT_LE(found.opening.residual, kExactOpening.tolerance);
        Opening opening(block.problem, kExactOpening);
        EXPECT_THROW(opening.set_tolerance(0.0, 0.0), InputError);
        EXPECT_THROW(opening.set_tolerance(1e-3, -1e-4), InputError);
        EXPECT_THROW(opening.set_tolerance(std::numeric_limits<double>::quiet_NaN(), 0.0), InputError);
    }

    TEST(FrameOpening, TheStiffnessOfAnOpeningIsTheDerivativeOfItsForces)
    {
        const FramedBlock block;
        FrameState state;
        state.distance = kOpeningMm;
        const std::vector<HookPatch> blades = blades_at(block.frame, state, block.problem.hooks);
        Opening opening(block.problem, kExactOpening);
        const OpeningResult opened = opening.open(blades);
        ASSERT_EQ(opened.status, OpeningStatus::converged) << opened.message;
        const Eigen::MatrixXd motions = blade_motions(block.problem.mesh, blades);
        const Eigen::MatrixXd stiffness = opening.stiffness(opened.displacement, motions);
        const Eigen::MatrixXd afresh
            = motion_response(block.problem, { Elasticity::corotational, {} }, opened.displacement, motions).stiffness;
        EXPECT_LT((stiffness - afresh).norm(), 1e-8 * afresh.norm());

        // Central differences of the forces, for translations of the first blade.
        constexpr double kStepMm = 0.01, kDifference = 1e-3;
        for (int axis = 0; axis < 3; ++axis) {
            std::array<Vec3, 2> forces;
            for (const std::size_t k : { 0U, 1U }) {
                std::vector<HookPatch> moved = blades;
                moved[0].displacement += (k == 0 ? -kStepMm : kStepMm) * Vec3::Unit(axis);
                forces[k] = opening.open(moved).hook_forces_N[0];
            }
            const Vec3 slope = (forces[1] - forces[0]) / (2.0 * kStepMm);
            EXPECT_LT((slope - stiffness.block<3, 1>(0, axis)).norm(), kDifference * slope.norm()) << axis;
        }
    }

    TEST(FrameOpening, AFrameThatFindsNoBalanceSaysHowFarItCame)
    {
        const FrameOpening opened = FramedBlock().open(
            { .distance_mm = kOpeningMm }, kExactOpening, { .tolerance = 1e-6, .most_openings = 1 });
        EXPECT_EQ(opened.opening.status, OpeningStatus::not_converged);
        EXPECT_NE(opened.opening.message.find("no balance in 1 opening"), std::string::npos) << opened.opening.message;
    }

    TEST(FrameOpening, ACancelledSearchEndsWithItsBestBalance)
    {
        const FramedBlock block;
        std::vector<double> imbalances; // of the searches that end after one, two, three openings
        for (const int openings : { 1, 2, 3 }) {
            std::atomic<bool> cancel { false };
            int done = 0;
            // Each opening reports its whole motion last.
            const Job job { .on_progress =
                                [&](std::string_view, double fraction) {
                                    if (fraction == 1.0 && ++done == openings)
                                        cancel = true;
                                },
                .cancel = &cancel };
            const FrameOpening ended = open_with_frame(
                block.problem, block.frame, { .distance_mm = kOpeningMm }, kExactOpening, kExact, job);
            ASSERT_EQ(ended.opening.status, OpeningStatus::cancelled) << openings;
            EXPECT_TRUE(ended.opening.displacement.allFinite());
            imbalances.push_back(ended.imbalance);
            if (openings > 1) {
                EXPECT_NE(ended.opening.message.find("found no balance"), std::string::npos) << ended.opening.message;
            }
        }
        EXPECT_LE(imbalances[2], imbalances[1]);
        EXPECT_GT(imbalances[2], kExact.tolerance);
    }

    TEST(FrameOpening, AFrameThatTurnsTooFarEndsWithItsBestBalance)
    {
        const FramedBlock block;
        const auto turn_of
            = [](const FrameOpening& opened) { return Eigen::AngleAxisd(opened.state.rotation).angle(); };
        const FrameOpening free = block.open();
        ASSERT_GT(turn_of(free), 0.0);
        const FrameOpening at_rest
            = block.open({ .distance_mm = kOpeningMm }, kExactOpening, { .tolerance = 1e-6, .most_openings = 1 });
        const FrameOpening ended = block.open(
            { .distance_mm = kOpeningMm }, kExactOpening, { .tolerance = 1e-6, .most_turned = 0.1 * turn_of(free) });
        EXPECT_EQ(ended.opening.status, OpeningStatus::not_converged);
        EXPECT_NE(ended.opening.message.find("and it turns by"), std::string::npos) << ended.opening.message;
        EXPECT_LE(turn_of(ended), 0.1 * turn_of(free));
        EXPECT_LE(ended.imbalance, at_rest.imbalance);
    }

    TEST(FrameOpening, AHeldFrameDriftsAndDoesNotTilt)
    {
        const FramedBlock block;
        for (const RackDrive& drive : { RackDrive { .distance_mm = kOpeningMm }, RackDrive { .force_N = 1.0 } }) {
            const FrameOpening held
                = block.open(drive, kExactOpening, { .tolerance = 1e-6, .direction_is_held = true });
            ASSERT_EQ(held.opening.status, OpeningStatus::converged) << held.opening.message;
            EXPECT_TRUE(held.direction_is_held);
            EXPECT_TRUE(held.state.rotation.isIdentity(kRoundOff));
            EXPECT_GT(held.state.translation.norm(), 0.01) << "the beds of the two ends differ";
            const double force = blade_force(held);
            // Independently of the frame: the nodal forces at the nodes where they are.
            const Vec3 centre = frame_centre(block.frame) + held.state.translation;
            Vec3 resultant = Vec3::Zero(), moment = Vec3::Zero();
            for (const HookPatch& blade : held.blades)
                for (const VertexId v : blade.nodes) {
                    const Vec3 f = held.opening.hook_nodal_forces_N.segment<3>(3 * static_cast<Eigen::Index>(v));
                    const Vec3 x = (block.problem.mesh.vertices.row(v) + held.opening.displacement.row(v)).transpose();
                    resultant += f;
                    moment += (x - centre).cross(f);
                }
            EXPECT_LT(resultant.norm(), kSame * force);
            EXPECT_GT(moment.norm(), 0.0);
            EXPECT_LT((moment - held.residual_moment_Nmm).norm(), kSame * moment.norm());
        }
    }

    TEST(FrameOpening, AFreeFrameWithoutBalanceIsHeldWhereThisIsAsked)
    {
        const FramedBlock block;
        const RackDrive drive { .distance_mm = kOpeningMm };
        const double free_turn = Eigen::AngleAxisd(block.open(drive).state.rotation).angle();
        const FrameOpening held = block.open(drive, kExactOpening, { .tolerance = 1e-6, .direction_is_held = true });
        const FrameOpening found = block.open(
            drive, kExactOpening, { .tolerance = 1e-6, .most_turned = 0.1 * free_turn, .hold_without_balance = true });
        ASSERT_EQ(found.opening.status, OpeningStatus::converged) << found.opening.message;
        EXPECT_TRUE(found.direction_is_held);
        EXPECT_TRUE(found.state.rotation.isIdentity(kRoundOff));
        EXPECT_LT((found.state.translation - held.state.translation).norm(), kSame * kOpeningMm);
        EXPECT_LT(
            (found.residual_moment_Nmm - held.residual_moment_Nmm).norm(), 1e-3 * held.residual_moment_Nmm.norm());
        EXPECT_GT(found.openings, held.openings);
        // A free frame in balance stays free.
        const FrameOpening free = block.open(drive, kExactOpening, { .tolerance = 1e-6, .hold_without_balance = true });
        EXPECT_FALSE(free.direction_is_held);
        EXPECT_NEAR(Eigen::AngleAxisd(free.state.rotation).angle(), free_turn, kRoundOff);
    }

    TEST(FrameOpening, WithoutElementsThatAreTurnedOverNoneIsMadeStiffer)
    {
        const FramedBlock block;
        FrameOptions how {};
        const OpeningOptions options { .elasticity = Elasticity::corotational };
        const FrameOpening plain = block.open({ .distance_mm = kOpeningMm }, options, how);
        how.may_stiffen.assign(block.problem.material_of_label.size(), 1);
        const FrameOpening same = block.open({ .distance_mm = kOpeningMm }, options, how);
        ASSERT_EQ(same.opening.status, OpeningStatus::converged) << same.opening.message;
        EXPECT_TRUE(same.opening.stiffened.empty());
        EXPECT_EQ(same.openings, plain.openings);
        EXPECT_NEAR(blade_force(same), blade_force(plain), kRoundOff * blade_force(plain));
    }

    TEST(FrameOpening, StiffenedElementsOfAnOpeningBearMore)
    {
        const FramedBlock block;
        Opening opening(block.problem, { .elasticity = Elasticity::corotational, .tolerance = 1e-8 });
        std::vector<HookPatch> hooks = block.problem.hooks;
        hooks[0].displacement = -3.0 * Vec3::UnitX();
        hooks[1].displacement = 3.0 * Vec3::UnitX();
        const OpeningResult before = opening.open(hooks);
        ASSERT_EQ(before.status, OpeningStatus::converged) << before.message;
        std::vector<TetId> all(block.problem.mesh.tet_count());
        std::iota(all.begin(), all.end(), 0);
        opening.stiffen(all, 2.0); // the beds at the ends stay as they are
        const OpeningResult after = opening.open(hooks);
        ASSERT_EQ(after.status, OpeningStatus::converged) << after.message;
        const double ratio = after.hook_forces_N[1].norm() / before.hook_forces_N[1].norm();
        EXPECT_GT(ratio, 1.0);
        EXPECT_LT(ratio, 2.0);
    }

    TEST(FrameOpening, BadInputIsNamed)
    {
        const FramedBlock good;
        const auto refused = [](const FramedBlock& block, const RackDrive& drive, const OpeningOptions& options = {}) {
            try {
                (void)open_with_frame(block.problem, block.frame, drive, options);
            } catch (const InputError& error) {
                return std::string(error.where()) + ": " + error.what();
            }
            return std::string("taken");
        };
        const RackDrive by_distance { .distance_mm = kOpeningMm };
        FramedBlock one = good;
        one.problem.hooks.resize(1);
        EXPECT_NE(refused(one, by_distance).find("two blades"), std::string::npos);
        EXPECT_NE(refused(good, {}).find("either by its opening or by its force"), std::string::npos);
        EXPECT_NE(refused(good, { .distance_mm = 1.0, .force_N = 1.0 }).find("either"), std::string::npos);
        EXPECT_NE(refused(good, { .distance_mm = -1.0 }).find("out of range"), std::string::npos);
        EXPECT_NE(refused(good, { .force_N = NAN }).find("not finite"), std::string::npos);
        FramedBlock loose = good;
        loose.frame[1].play = -0.1;
        EXPECT_NE(refused(loose, by_distance).find("blade 2"), std::string::npos);
        FramedBlock same_way = good;
        same_way.frame[1].outward = same_way.frame[0].outward;
        EXPECT_NE(refused(same_way, by_distance).find("opposite"), std::string::npos);
        OpeningOptions condensed;
        condensed.near = std::vector<std::uint8_t>(good.problem.mesh.tet_count(), 1);
        EXPECT_NE(refused(good, by_distance, condensed).find("condensed region"), std::string::npos);
        FramedBlock sheared = good;
        sheared.problem.hooks[0].rotation(0, 1) = 0.1;
        EXPECT_THROW(
            (void)prescribe(sheared.problem.mesh, sheared.problem.supports, sheared.problem.hooks), InputError);
    }

} // namespace frame_opening_test
} // namespace retractor::fem
