#include "fem/statics/local_relaxation.h"

#include "fem/material/material.h"
#include "fem/statics/equilibrium.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <gtest/gtest.h>

#include <numeric>

namespace retractor::fem {
namespace local_relaxation_test {

    constexpr int kCells = 8; // per side, of 1 mm

    /// A stretched block: the displacement is linear, so that only its sides bear forces.
    struct Block {
        explicit Block(bool ten_nodes = false)
            : mesh(ten_nodes ? mesh::with_midpoints(mesh::kuhn_box(kCells, kCells, kCells, 1.0))
                             : mesh::kuhn_box(kCells, kCells, kCells, 1.0))
            , body(mesh, Elasticity::corotational,
                  std::vector<Lame>(mesh.tet_count(), lame(find_material(default_materials(), "fat"))))
            , prescribed(3 * mesh.vertex_count(), 0)
            , stretched(3 * mesh.vertices.rows())
        {
            for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
                const Vec3 x = mesh.vertices.row(v).transpose();
                stretched.segment<3>(3 * v) = Vec3(0.1 * x.x(), -0.04 * x.y(), -0.04 * x.z());
                if (x.minCoeff() <= 0.0 || x.maxCoeff() >= kCells)
                    for (Eigen::Index axis = 0; axis < 3; ++axis)
                        prescribed[static_cast<std::size_t>(3 * v + axis)] = 1;
            }
        }
        Eigen::VectorXd free_forces(const Eigen::VectorXd& u) const
        {
            Eigen::VectorXd forces = body.response(u).forces;
            for (Eigen::Index i = 0; i < forces.size(); ++i)
                if (prescribed[static_cast<std::size_t>(i)] != 0)
                    forces[i] = 0.0;
            return forces;
        }
        Eigen::Index node_at(const Vec3& place) const
        {
            Eigen::Index nearest = 0;
            (mesh.vertices.rowwise() - place.transpose()).rowwise().norm().minCoeff(&nearest);
            return nearest;
        }

        mesh::TetMesh mesh;
        ElasticBody body;
        std::vector<std::uint8_t> prescribed;
        Eigen::VectorXd stretched;
    };

    /// The block with the node in its middle out of place.
    Eigen::VectorXd with_a_node_pushed(const Block& block)
    {
        Eigen::VectorXd u = block.stretched;
        u.segment<3>(3 * block.node_at(Vec3(4.0, 4.0, 4.0))) += Vec3(0.5, 0.2, 0.1);
        return u;
    }

    TEST(LocalRelaxation, BringsANodeThatWasPushedBackToRest)
    {
        for (const bool ten_nodes : { false, true }) {
            const Block block(ten_nodes);
            const Eigen::VectorXd u = with_a_node_pushed(block), forces = block.free_forces(u);
            const auto relaxed = LocalRelaxation(block.body, block.prescribed).relax(u, forces);
            ASSERT_TRUE(relaxed);
            constexpr double kAtRestMm = 1e-3; // the relaxation ends at a thousandth of the force
            EXPECT_LT((*relaxed - block.stretched).lpNorm<Eigen::Infinity>(), kAtRestMm) << ten_nodes;
            EXPECT_LT(block.free_forces(*relaxed).norm(), 0.01 * forces.norm()) << ten_nodes;
        }
    }

    TEST(LocalRelaxation, MovesOnlyNodesNearLargeForces)
    {
        const Block block;
        const Eigen::VectorXd u = with_a_node_pushed(block);
        const auto relaxed = LocalRelaxation(block.body, block.prescribed).relax(u, block.free_forces(u));
        ASSERT_TRUE(relaxed);
        constexpr double kTwoRingsMm = 3.5; // the node's neighbours have large forces too, and move theirs
        int moved = 0;
        for (Eigen::Index v = 0; v < block.mesh.vertices.rows(); ++v) {
            if ((*relaxed - u).segment<3>(3 * v).norm() == 0.0)
                continue;
            ++moved;
            EXPECT_LE(
                (block.mesh.vertices.row(v) - Eigen::RowVector3d(4.0, 4.0, 4.0)).cwiseAbs().maxCoeff(), kTwoRingsMm);
            EXPECT_EQ(block.prescribed[static_cast<std::size_t>(3 * v)], 0);
        }
        EXPECT_GT(moved, 0);
    }

    TEST(LocalRelaxation, LeavesNodesWhereSomethingElseActs)
    {
        Block block;
        std::vector<double> bed(block.mesh.vertex_count(), 1e-3);
        block.body.set_bed(bed);
        const Eigen::VectorXd u = with_a_node_pushed(block);
        EXPECT_FALSE(LocalRelaxation(block.body, block.prescribed).relax(u, block.free_forces(u)));
        std::fill(bed.begin(), bed.end(), 0.0);
        const Eigen::Index pushed = block.node_at(Vec3(4.0, 4.0, 4.0));
        bed[static_cast<std::size_t>(pushed)] = 1e-3;
        block.body.set_bed(bed);
        const auto touched = block.body.touched_nodes(u);
        EXPECT_EQ(std::accumulate(touched.begin(), touched.end(), 0), 1);
        const auto relaxed = LocalRelaxation(block.body, block.prescribed).relax(u, block.free_forces(u));
        ASSERT_TRUE(relaxed); // the neighbours move, the node itself does not
        EXPECT_EQ((*relaxed - u).segment<3>(3 * pushed).norm(), 0.0);
    }

    TEST(LocalRelaxation, LeavesABodyAtRestAndForcesThatAreEverywhere)
    {
        const Block block(true);
        const LocalRelaxation relaxation(block.body, block.prescribed);
        EXPECT_FALSE(relaxation.relax(block.stretched, Eigen::VectorXd::Zero(block.stretched.size())));
        Eigen::VectorXd u = block.stretched;
        for (Eigen::Index i = 0; i < u.size(); ++i)
            if (block.prescribed[static_cast<std::size_t>(i)] == 0)
                u[i] += i % 2 == 0 ? 0.1 : -0.1;
        EXPECT_FALSE(relaxation.relax(u, block.free_forces(u)));
    }

    TEST(LocalRelaxation, NewtonsMethodEndsAtTheSameEquilibriumInNoMoreSteps)
    {
        Block with(true), without(true);
        const Eigen::VectorXd start = with_a_node_pushed(with);
        EquilibriumOptions options;
        options.load_steps = 1;
        options.tolerance = 1e-8;
        const auto solve = [&](Block& block) {
            return EquilibriumSolver().solve(block.body, block.prescribed, start, start, options, Job {});
        };
        const Equilibrium plain = solve(without);
        options.relax_locally_from = 0;
        const Equilibrium relaxed = solve(with);
        ASSERT_EQ(plain.status, EquilibriumStatus::converged);
        ASSERT_EQ(relaxed.status, EquilibriumStatus::converged);
        constexpr double kSameMm = 1e-6;
        EXPECT_LT((relaxed.displacement - plain.displacement).lpNorm<Eigen::Infinity>(), kSameMm);
        EXPECT_LT((relaxed.displacement - with.stretched).lpNorm<Eigen::Infinity>(), kSameMm);
        EXPECT_LE(relaxed.newton_iterations, plain.newton_iterations);
    }

    TEST(LocalRelaxation, APartHasTheEnergyOfItsElements)
    {
        for (const bool ten_nodes : { false, true }) {
            const Block block(ten_nodes);
            const Eigen::VectorXd u = with_a_node_pushed(block);
            double sum = 0.0;
            for (const int first : { 0, 1 }) { // every other element
                std::vector<TetId> elements;
                for (std::size_t t = static_cast<std::size_t>(first); t < block.mesh.tet_count(); t += 2)
                    elements.push_back(static_cast<TetId>(t));
                std::vector<VertexId> nodes;
                const ElasticBody part = block.body.part(elements, nodes);
                Eigen::VectorXd of_part(3 * static_cast<Eigen::Index>(nodes.size()));
                for (std::size_t n = 0; n < nodes.size(); ++n)
                    of_part.segment<3>(3 * static_cast<Eigen::Index>(n))
                        = u.segment<3>(3 * static_cast<Eigen::Index>(nodes[n]));
                sum += part.response(of_part).energy;
            }
            const double whole = block.body.response(u).energy;
            constexpr double kRoundOff = 1e-12;
            EXPECT_NEAR(sum, whole, kRoundOff * whole) << ten_nodes;
        }
    }

} // namespace local_relaxation_test
} // namespace retractor::fem
