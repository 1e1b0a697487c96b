#include "fem/springs/spring_relaxation.h"

#include "fem/model/pre_strain.h"
#include "mesh/base/error.h"
#include "mesh/cutting/cut_session.h"
#include "tests/support/reference_problems.h"
#include "tests/verification/framework/element_stress.h"
#include "tests/verification/framework/spring_dynamics.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include <atomic>
#include <cmath>

namespace retractor::fem {
namespace spring_relaxation_test {

    using test_support::material;

    constexpr double kStrain = 0.04;

    /// A block cut to half its depth, its sides and bottom held, under tension across the cut.
    struct Wound {
        mesh::TetMesh mesh = verification::distorted_box(6, 3.0, 0.2, 21);
        std::vector<Material> materials = std::vector<Material>(2, test_support::material(0.2, 0.25));
        mesh::CutSession session { mesh };
        std::vector<Mat3> stresses;
        SpringNetwork network = make();
        std::vector<std::pair<VertexId, VertexId>> parted; ///< pairs of vertices that the cut separated

        SpringNetwork make()
        {
            const PreStrain tension { PreStrainKind::uniaxial_stress, kStrain, Vec3::UnitY(), Vec3::UnitZ() };
            stresses = verification::stress_of_elements(mesh, materials, std::vector<PreStrain>(2, tension));
            SpringNetwork net(session, materials, stresses);
            std::vector<VertexId> held;
            for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
                if (const auto p = mesh.vertices.row(v);
                    p.head<2>().minCoeff() == 0.0 || p.head<2>().maxCoeff() == 18.0 || p.z() == 0.0)
                    held.push_back(v);
            net.fix(held);
            return net;
        }
        void cut()
        {
            const mesh::CutResult result = session.cut({ .line = { Vec3(3.5, 9.2, 18.0), Vec3(14.5, 8.8, 18.0) },
                .directions = { -Vec3::UnitZ() },
                .depth_mm = 9.0 });
            ASSERT_EQ(result.status, mesh::CutStatus::done) << result.message;
            network.apply(result.delta);
            for (const mesh::MeshDelta::VertexBorn& born : result.delta.vertices_born)
                if (born.origin == mesh::MeshDelta::Origin::copy)
                    parted.emplace_back(born.a, born.id);
            network.set_wound(session.lips());
        }
        double gape() const
        {
            const Points now = network.positions();
            double widest = 0.0;
            for (const auto& [a, b] : parted)
                widest = std::max(widest, (now.row(a) - now.row(b)).norm());
            return widest;
        }
    };

    TEST(Relax, MovesNothingBeforeACut)
    {
        Wound wound;
        const RelaxResult result = relax(wound.network);
        EXPECT_EQ(result.status, RelaxStatus::converged);
        EXPECT_EQ(result.iterations, 0);
        EXPECT_TRUE(wound.network.displacement().isZero(0.0));
    }

    TEST(Relax, OpensTheWoundAndLowersTheEnergy)
    {
        Wound wound;
        wound.cut();
        const RelaxResult result = relax(wound.network, { .tolerance = 1e-6 });
        EXPECT_EQ(result.status, RelaxStatus::converged) << result.message;
        EXPECT_LE(result.residual, 1e-6);
        EXPECT_LT(result.energy, 0.0);
        EXPECT_EQ(result.inverted, 0);
        // Less than a cut of this length through a large sheet: 2 e L = 0.9 mm.
        EXPECT_GT(wound.gape(), 0.2);
        EXPECT_LT(wound.gape(), 2.0 * kStrain * 11.1);
        // It is the equilibrium: another call has nothing to do.
        EXPECT_EQ(relax(wound.network, { .tolerance = 1e-6 }).iterations, 0);
    }

    TEST(Relax, FramesOfFewIterationsArriveWhereOneLongOneDoes)
    {
        Wound whole, frames;
        whole.cut();
        frames.cut();
        ASSERT_EQ(relax(whole.network, { .tolerance = 1e-6 }).status, RelaxStatus::converged);
        double energy = 0.0;
        RelaxResult result;
        int frame = 0;
        do {
            result = relax(frames.network, { .tolerance = 1e-6, .max_iterations = 10 });
            EXPECT_LE(result.energy, energy + 1e-12 * std::abs(energy));
            EXPECT_LE(result.iterations, 10);
            energy = result.energy;
        } while (result.status == RelaxStatus::out_of_iterations && ++frame < 200);
        EXPECT_EQ(result.status, RelaxStatus::converged);
        EXPECT_GT(frame, 1);
        EXPECT_LT((whole.network.displacement() - frames.network.displacement()).cwiseAbs().maxCoeff(), 1e-4);
    }

    TEST(Relax, ALargerReachComesNearerToTheWhole)
    {
        Wound whole;
        whole.cut();
        ASSERT_EQ(relax(whole.network, { .tolerance = 1e-6 }).status, RelaxStatus::converged);
        const double right = whole.gape();
        double before = 0.0;
        for (const double reach : { 2.0, 4.0, 6.0 }) {
            Wound local;
            local.cut();
            const RelaxResult result = relax(local.network, { .tolerance = 1e-6, .reach_mm = reach });
            EXPECT_LT(result.active, vertices_near_wound(whole.network, 0.0).size());
            EXPECT_GT(local.gape(), before); // what stands still holds the wound closed
            EXPECT_LT(local.gape(), right);
            before = local.gape();
        }
        EXPECT_GT(before, 0.8 * right); // 6 mm beside a cut 11 mm long and 9 mm deep
    }

    TEST(Relax, ClosesTheWoundThatWasTakenBack)
    {
        Wound wound;
        wound.cut();
        ASSERT_EQ(relax(wound.network, { .tolerance = 1e-6 }).status, RelaxStatus::converged);
        wound.network.apply(wound.session.undo());
        wound.network.set_wound(wound.session.lips());
        const double before = wound.network.displacement().cwiseAbs().maxCoeff();
        EXPECT_GT(before, 0.05);
        EXPECT_EQ(relax(wound.network, { .tolerance = 1e-6 }).status, RelaxStatus::converged);
        EXPECT_LT(wound.network.displacement().cwiseAbs().maxCoeff(), 1e-4 * before);
    }

    /// Vertices thrown about by up to two thirds of an edge turn many elements over; further out the springs may catch
    /// in a tangle, which `inverted` tells.
    TEST(Relax, ComesBackFromATangle)
    {
        for (const double amount : { 1.0, 2.0 }) {
            Wound wound;
            Points tangled = wound.network.displacement();
            for (Eigen::Index v = 0; v < tangled.rows(); ++v)
                for (Eigen::Index axis = 0; axis < 3; ++axis)
                    tangled(v, axis) = amount * std::sin(static_cast<double>((7 + 4 * axis) * v + axis));
            wound.network.set_displacement(tangled);
            const SpringPatch patch(wound.network, vertices_near_wound(wound.network, 0.0));
            EXPECT_GT(patch.response(patch.displacement()).inverted, 10);
            const RelaxResult result = relax(wound.network, { .tolerance = 1e-5, .max_iterations = 20000 });
            EXPECT_EQ(result.status, RelaxStatus::converged) << result.message;
            EXPECT_EQ(result.inverted, 0) << amount;
            EXPECT_LT(wound.network.displacement().cwiseAbs().maxCoeff(), 0.01 * amount) << amount;
        }
    }

    TEST(Relax, CanBeCancelledAndRefusesBadOptions)
    {
        Wound wound;
        wound.cut();
        const std::atomic<bool> stop { true };
        EXPECT_EQ(relax(wound.network, {}, { .on_progress = {}, .cancel = &stop }).status, RelaxStatus::cancelled);
        EXPECT_THROW(static_cast<void>(relax(wound.network, { .tolerance = std::nan("") })), InputError);
        EXPECT_THROW(static_cast<void>(relax(wound.network, { .max_iterations = 0 })), InputError);
        EXPECT_THROW(static_cast<void>(relax(wound.network, { .reach_mm = -1.0 })), InputError);
    }

    // ---- motion in time

    constexpr double kDamping = 50.0;

    TEST(SpringDynamics, BoundIsThatOfTheStiffestMotion)
    {
        Wound wound;
        const verification::SpringDynamics motion(wound.network, wound.materials, 0.0);
        // The whole spectrum of a small network, by a dense solver.
        SpringPatch patch(wound.network, motion.patch().active());
        patch.linearise(patch.displacement());
        const Eigen::Index n = patch.displacement().size();
        Eigen::MatrixXd K(n, n);
        for (Eigen::Index i = 0; i < n; ++i)
            K.col(i) = patch.multiply(Eigen::VectorXd::Unit(n, i));
        Eigen::VectorXd mass(n);
        for (std::size_t i = 0; i < patch.active().size(); ++i) {
            double m = 0.0;
            for (const TetId t : wound.network.elements(patch.active()[i]))
                m += 0.25 * wound.network.rest_volume(t) * wound.materials[1].density_tonne_per_mm3;
            mass.segment<3>(3 * static_cast<Eigen::Index>(i)).setConstant(m);
        }
        const Eigen::VectorXd root = mass.cwiseSqrt().cwiseInverse();
        const Eigen::VectorXd values
            = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(root.asDiagonal() * K * root.asDiagonal()).eigenvalues();
        const double frequency = std::sqrt(values[n - 1]);
        EXPECT_GE(motion.bound().largest_frequency, frequency * (1.0 - 1e-9));
        EXPECT_LE(motion.bound().largest_frequency, frequency * 1.001);
    }

    /// A small push in the stiffest direction, found by applying the bound itself: just below it dies out, just above
    /// it is refused, and an integrator that does not refuse it blows up.
    TEST(SpringDynamics, DecaysBelowTheBoundAndIsRefusedAboveIt)
    {
        Wound wound;
        verification::SpringDynamics motion(wound.network, wound.materials, kDamping);
        const double limit = motion.bound().stable_step;
        const Eigen::Index n = motion.displacement().size();
        Eigen::VectorXd push(n);
        for (Eigen::Index i = 0; i < n; ++i)
            push[i] = 1e-7 * std::sin(12.9898 * static_cast<double>(i));
        motion.set_state(push, Eigen::VectorXd::Zero(n));
        const double first = motion.potential_energy();
        for (int i = 0; i < 1500; ++i)
            motion.step(0.999 * limit);
        EXPECT_LT(motion.kinetic_energy() + motion.potential_energy(), first);
        try {
            motion.step(1.001 * limit);
            FAIL() << "a step beyond the bound was taken";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("stable"), std::string::npos) << error.what();
            EXPECT_EQ(error.where(), "dt");
        }
        // The bound is sharp: the same scheme without its guard and without damping, 1 % above.
        SpringPatch patch(wound.network, motion.patch().active());
        Eigen::VectorXd u = push, v = Eigen::VectorXd::Zero(n);
        verification::SpringDynamics undamped(wound.network, wound.materials, 0.0);
        const double beyond = 1.01 * undamped.bound().stable_step;
        for (int i = 0; i < 400; ++i) {
            const Eigen::VectorXd f = patch.response(u).forces;
            for (std::size_t k = 0; k < patch.active().size(); ++k) {
                double m = 0.0;
                for (const TetId t : wound.network.elements(patch.active()[k]))
                    m += 0.25 * wound.network.rest_volume(t) * wound.materials[1].density_tonne_per_mm3;
                v.segment<3>(3 * static_cast<Eigen::Index>(k))
                    -= beyond / m * f.segment<3>(3 * static_cast<Eigen::Index>(k));
            }
            u += beyond * v;
        }
        EXPECT_FALSE(u.norm() < 100.0 * push.norm()); // or no number any more
    }

    TEST(SpringDynamics, ComesToRestWhereRelaxDoes)
    {
        Wound wound;
        wound.cut();
        verification::SpringDynamics motion(wound.network, wound.materials, 1500.0);
        for (int i = 0; i < 1500; ++i)
            motion.step(0.9 * motion.bound().stable_step);
        Wound still;
        still.cut();
        ASSERT_EQ(relax(still.network, { .tolerance = 1e-7 }).status, RelaxStatus::converged);
        motion.store(wound.network);
        const double largest = still.network.displacement().cwiseAbs().maxCoeff();
        EXPECT_LT((wound.network.displacement() - still.network.displacement()).cwiseAbs().maxCoeff(), 0.01 * largest);
    }

    TEST(SpringDynamics, RefusesBadInput)
    {
        Wound wound;
        EXPECT_THROW(verification::SpringDynamics(wound.network, wound.materials, -1.0), InputError);
        EXPECT_THROW(verification::SpringDynamics(wound.network, wound.materials, std::nan("")), InputError);
        verification::SpringDynamics motion(wound.network, wound.materials, 0.0);
        EXPECT_THROW(motion.step(0.0), InputError);
        EXPECT_THROW(motion.step(std::nan("")), InputError);
        EXPECT_THROW(motion.set_state(Eigen::VectorXd::Zero(3), Eigen::VectorXd::Zero(3)), InputError);
    }

} // namespace spring_relaxation_test
} // namespace retractor::fem
