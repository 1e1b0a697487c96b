#include "fem/model/blade_contact.h"

#include "fem/model/blade_samples.h"
#include "fem/statics/elastic_problem.h"
#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace retractor::fem {
namespace blade_contact_test {

    constexpr double kRoundOff = 1e-9;
    constexpr double kSpacingMm = 5.0;

    /// A block of 20 x 20 x 10 mm and a blade of 12 x 8 mm that presses on its upper side, from z = 10 mm downwards.
    struct PressedBlock {
        ElasticProblem problem;

        explicit PressedBlock(int nodes_per_tet = 4, double friction = kBladeFriction)
        {
            problem.mesh = mesh::kuhn_box(4, 4, 2, kSpacingMm);
            problem.material_of_label = { { "tissue", 0.1, 0.3, 1e-9, "test" } };
            std::fill(problem.mesh.labels.begin(), problem.mesh.labels.end(), Label { 0 });
            problem.hooks.push_back({ .name = "blade", .side = 1, .nodes = {} });
            add_blade(problem, 0, mesh::boundary_faces(problem.mesh), {},
                { .name = "blade",
                    .middle = Vec3(10.0, 11.0, 10.0),
                    .along = Vec3::UnitX(),
                    .deep = Vec3::UnitY(),
                    .outward = -Vec3::UnitZ(),
                    .width_mm = 12.0,
                    .height_mm = 8.0,
                    .friction = friction });
            if (nodes_per_tet == 10) {
                const auto corners = problem.mesh;
                problem.mesh = mesh::with_midpoints(corners);
            }
        }

        BladeContact contact() const { return { problem.mesh, problem.blades }; }

        /// Random displacements, and the blade turned a little and pushed `depth_mm` into the block.
        Eigen::VectorXd state(double depth_mm, unsigned seed = 1) const
        {
            std::mt19937 random(seed);
            std::uniform_real_distribution<double> some(-0.05, 0.05);
            Eigen::VectorXd u(3 * problem.mesh.vertices.rows());
            for (double& entry : u)
                entry = some(random);
            HookPatch blade = problem.hooks[0];
            blade.displacement = Vec3(0.2, -0.1, -depth_mm);
            blade.rotation = Eigen::AngleAxisd(0.02, Vec3(1.0, 2.0, 0.5).normalized()).toRotationMatrix();
            blade.pivot = Vec3(10.0, 11.0, 30.0);
            for (const VertexId v : problem.blades[0].nodes)
                u.segment<3>(3 * v) = blade.displacement_of(problem.mesh.vertices.row(v).transpose());
            return u;
        }
    };

    Eigen::VectorXd forces_of(const BladeContact& contact, const Eigen::VectorXd& u)
    {
        Eigen::VectorXd forces = Eigen::VectorXd::Zero(u.size());
        (void)contact.add_response(u, forces);
        return forces;
    }

    TEST(BladeContact, ForcesAreTheDerivativeOfTheEnergyAndStiffnessThatOfTheForces)
    {
        for (const int nodes_per_tet : { 4, 10 }) {
            const PressedBlock block(nodes_per_tet);
            BladeContact contact = block.contact();
            const Eigen::VectorXd u = block.state(0.4);
            contact.renew(u);
            std::mt19937 random(7);
            std::uniform_real_distribution<double> some(-1.0, 1.0);
            BlockMatrix K { contact.pattern(block_pattern(block.problem.mesh)), {} };
            K.values.assign(9 * K.pattern.block_count(), 0.0);
            contact.add_stiffness(u, 0.0, K);
            const Eigen::VectorXd forces = forces_of(contact, u);
            ASSERT_GT(forces.norm(), 0.0);
            for (int trial = 0; trial < 4; ++trial) {
                Eigen::VectorXd way(u.size());
                for (double& entry : way)
                    entry = some(random);
                // so small that no sample begins or ends to touch or to slip
                constexpr double kStep = 1e-6, kTruncation = 1e-5;
                const double slope = (contact.energy(u + kStep * way) - contact.energy(u - kStep * way)) / (2 * kStep);
                EXPECT_NEAR(slope, forces.dot(way), kTruncation * forces.norm() * way.norm());
                const Eigen::VectorXd change
                    = (forces_of(contact, u + kStep * way) - forces_of(contact, u - kStep * way)) / (2 * kStep);
                EXPECT_LT((change - K.multiply(way)).norm(), kTruncation * change.norm()) << nodes_per_tet;
            }
        }
    }

    TEST(BladeContact, TheBladeBearsTheOppositeForceAndMomentOfTheTissue)
    {
        const PressedBlock block;
        BladeContact contact = block.contact();
        const Eigen::VectorXd u = block.state(0.4);
        contact.renew(u);
        const Eigen::VectorXd forces = forces_of(contact, u);
        Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
        for (VertexId v = 0; v < block.problem.mesh.vertices.rows(); ++v) {
            const Vec3 f = forces.segment<3>(3 * v);
            const Vec3 x = block.problem.mesh.vertices.row(v).transpose() + u.segment<3>(3 * v);
            sum += f;
            moment += x.cross(f);
        }
        EXPECT_LT(sum.norm(), kRoundOff * forces.norm());
        EXPECT_LT(moment.norm(), kRoundOff * 100.0 * forces.norm());
    }

    TEST(BladeContact, ABladePushesAndNeverPulls)
    {
        const PressedBlock block;
        BladeContact contact = block.contact();
        const Eigen::VectorXd away = block.state(-1.0);
        contact.renew(away);
        EXPECT_EQ(contact.energy(away), 0.0);
        EXPECT_EQ(forces_of(contact, away).norm(), 0.0);
        EXPECT_EQ(contact.bearing(away)[0].force_N, 0.0);
        const Eigen::VectorXd into = block.state(0.5);
        contact.renew(into);
        const BladeBearing bearing = contact.bearing(into)[0];
        EXPECT_GT(bearing.force_N, 0.0);
        const Eigen::VectorXd forces = forces_of(contact, into);
        // The tissue's force on the blade: along the normal of the blade, up.
        Vec3 on_blade = Vec3::Zero();
        for (const VertexId v : block.problem.blades[0].nodes)
            on_blade += forces.segment<3>(3 * v);
        EXPECT_LT(on_blade.z(), 0.0); // the derivative is what must be applied to the blade: downwards
    }

    TEST(BladeContact, FrictionNeverExceedsItsShareOfThePressure)
    {
        const PressedBlock with(4, 0.4), without(4, 0.0);
        Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * with.problem.mesh.vertices.rows());
        for (const VertexId v : with.problem.blades[0].nodes)
            u.segment<3>(3 * v) = Vec3(3.0, 0.0, -0.2); // slides far
        BladeContact rough = with.contact(), smooth = without.contact();
        rough.renew(u);
        smooth.renew(u);
        const auto on_blade = [&](const BladeContact& contact) {
            const Eigen::VectorXd forces = forces_of(contact, u);
            Vec3 sum = Vec3::Zero();
            for (const VertexId v : with.problem.blades[0].nodes)
                sum += forces.segment<3>(3 * v);
            return sum;
        };
        EXPECT_NEAR(on_blade(smooth).x(), 0.0, kRoundOff);
        EXPECT_NEAR(on_blade(rough).x(), 0.4 * std::abs(on_blade(rough).z()), 1e-6 * std::abs(on_blade(rough).z()));
        EXPECT_NEAR(on_blade(rough).z(), on_blade(smooth).z(), kRoundOff);
    }

    TEST(BladeContact, FrictionComesFromTheForceOfTheBlade)
    {
        const PressedBlock block(4, 0.4);
        BladeContact contact = block.contact();
        const Eigen::VectorXd light = block.state(0.2), firm = block.state(0.4), away = block.state(-1.0);
        EXPECT_TRUE(std::isinf(contact.friction_error(light))); // nothing slips yet
        contact.renew(light);
        EXPECT_NEAR(contact.friction_error(light), 0.0, kRoundOff);
        const double before = contact.friction_error(firm);
        EXPECT_GT(before, 0.1); // about half of the friction is missing, which is 0.4 of the force
        contact.renew(firm, 0.5);
        EXPECT_NEAR(contact.friction_error(firm), 0.5 * before, kRoundOff);
        EXPECT_TRUE(std::isinf(contact.friction_error(away)));
        contact.renew(away, 0.5); // a blade that bears nothing has no friction at once
        EXPECT_EQ(contact.friction_error(away), 0.0);
        EXPECT_EQ(forces_of(contact, away).norm(), 0.0);
    }

    TEST(BladeContact, TheAreaUnderABladeDoesNotHangOnTheMesh)
    {
        // A blade pushed evenly into a flat side has the force of stiffness, area and depth, for every mesh.
        for (const int cubes : { 3, 4, 5, 7 }) {
            ElasticProblem problem;
            problem.mesh = mesh::kuhn_box(cubes, cubes, 1, 20.0 / cubes);
            std::fill(problem.mesh.labels.begin(), problem.mesh.labels.end(), Label { 0 });
            problem.material_of_label = { { "bone", 5000.0, 0.3, 1e-9, "test" } }; // capped: one stiffness for all
            problem.hooks.push_back({ .name = "blade", .side = 1, .nodes = {} });
            add_blade(problem, 0, mesh::boundary_faces(problem.mesh), {},
                { .name = "blade",
                    .middle = Vec3(10.0, 10.0, 20.0 / cubes),
                    .outward = -Vec3::UnitZ(),
                    .width_mm = 12.0,
                    .height_mm = 8.0 });
            BladeContact contact(problem.mesh, problem.blades);
            Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * problem.mesh.vertices.rows());
            for (const VertexId v : problem.blades[0].nodes)
                u[3 * v + 2] = -0.01;
            const double expected = kStiffestN_mm3 * 0.01 * 12.0 * 8.0;
            constexpr double kQuadrature = 0.04; // samples 1 to 2 mm apart across a band of 2 mm
            EXPECT_NEAR(contact.bearing(u)[0].force_N, expected, kQuadrature * expected) << cubes;
            EXPECT_NEAR(contact.bearing(u)[0].area_mm2, 12.0 * 8.0, kQuadrature * 12.0 * 8.0) << cubes;
        }
    }

    TEST(BladeContact, BoneBehindALayerBearsWhenTheLayerIsSqueezed)
    {
        // Bone below z = 5 mm, soft tissue of 5 mm above it.
        ElasticProblem problem;
        problem.mesh = mesh::kuhn_box(4, 4, 2, kSpacingMm);
        for (TetId t = 0; t < static_cast<TetId>(problem.mesh.tet_count()); ++t) {
            double z = 0.0;
            for (const VertexId v : problem.mesh.tet(t))
                z += 0.25 * problem.mesh.vertices(v, 2);
            problem.mesh.labels[static_cast<std::size_t>(t)] = z < kSpacingMm ? 1 : 0;
        }
        problem.material_of_label = { { "muscle", 0.05, 0.3, 1e-9, "test" }, { "bone", 5000.0, 0.3, 1e-9, "test" } };
        problem.hooks.push_back({ .name = "blade", .side = 1, .nodes = {} });
        const std::vector<Label> bones { 1 };
        add_blade(problem, 0, mesh::boundary_faces(problem.mesh), surface_of_labels(problem.mesh, bones),
            { .name = "blade",
                .middle = Vec3(10.0, 10.0, 10.0),
                .outward = -Vec3::UnitZ(),
                .width_mm = 12.0,
                .height_mm = 8.0 });
        BladeContact contact(problem.mesh, problem.blades);
        const auto bone_force = [&](double depth_mm) {
            Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * problem.mesh.vertices.rows());
            for (const VertexId v : problem.blades[0].nodes)
                u[3 * v + 2] = -depth_mm;
            return contact.bearing(u)[0].bone_force_N;
        };
        const double closed = (1.0 - kSqueezedTo) * kSpacingMm;
        EXPECT_EQ(bone_force(closed - 0.01), 0.0);
        EXPECT_GT(bone_force(closed + 0.01), 0.0);
    }

    TEST(BladeContact, BoneOnTheOtherLipOfACutIsPassedOver)
    {
        // The blade stands in a cut between two blocks and presses on the lower one. On the other lip bone looks the
        // same way, 1.5 mm behind the blade.
        constexpr double kBoneMm = 1.5;
        const mesh::TetMesh lower = mesh::kuhn_box(4, 4, 2, kSpacingMm);
        const auto bone_force = [&](bool joined) {
            ElasticProblem problem;
            problem.mesh = lower;
            const auto first = static_cast<VertexId>(lower.vertices.rows());
            problem.mesh.vertices.conservativeResize(2 * first, 3);
            std::vector<VertexId> at(static_cast<std::size_t>(first));
            for (VertexId v = 0; v < first; ++v) {
                Vec3 x = lower.vertices.row(v).transpose();
                x.z() = 10.0 + x.z() / kSpacingMm * kBoneMm;
                problem.mesh.vertices.row(first + v) = x.transpose();
                at[static_cast<std::size_t>(v)] = first + v;
                for (VertexId w = 0; joined && w < first; ++w)
                    if ((lower.vertices.row(w).transpose() - x).norm() < kRoundOff)
                        at[static_cast<std::size_t>(v)] = w;
            }
            for (const VertexId v : lower.nodes)
                problem.mesh.nodes.push_back(at[static_cast<std::size_t>(v)]);
            problem.mesh.labels.assign(2 * lower.tet_count(), 0);
            for (TetId t = static_cast<TetId>(lower.tet_count()); t < static_cast<TetId>(problem.mesh.tet_count());
                 ++t) {
                double z = 0.0;
                for (const VertexId v : problem.mesh.tet(t))
                    z += 0.25 * problem.mesh.vertices(v, 2);
                problem.mesh.labels[static_cast<std::size_t>(t)] = z < 10.0 + kBoneMm ? 1 : 0;
            }
            problem.material_of_label
                = { { "muscle", 0.05, 0.3, 1e-9, "test" }, { "bone", 5000.0, 0.3, 1e-9, "test" } };
            problem.hooks.push_back({ .name = "blade", .side = 1, .nodes = {} });
            const std::vector<Label> bones { 1 };
            add_blade(problem, 0, mesh::boundary_faces(lower), surface_of_labels(problem.mesh, bones),
                { .name = "blade",
                    .middle = Vec3(10.0, 10.0, 10.0),
                    .outward = -Vec3::UnitZ(),
                    .width_mm = 12.0,
                    .height_mm = 8.0 });
            Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * problem.mesh.vertices.rows());
            for (const VertexId v : problem.blades[0].nodes)
                u[3 * v + 2] = -1.0;
            return BladeContact(problem.mesh, problem.blades).bearing(u)[0].bone_force_N;
        };
        EXPECT_EQ(bone_force(false), 0.0);
        EXPECT_GT(bone_force(true), 0.0) << "one piece: a blade that grazes its bone";
    }

    TEST(BladeContact, BadInputNamesTheBlade)
    {
        using test_support::message_of;
        PressedBlock block;
        std::vector<BladeSurface> blades = block.problem.blades;
        blades[0].friction = -1.0;
        EXPECT_EQ(message_of([&] { (void)BladeContact(block.problem.mesh, blades); }),
            "blade 'blade': the friction of a blade must be finite and not negative");
        blades = block.problem.blades;
        blades[0].half_width_mm = 7.0;
        EXPECT_EQ(message_of([&] { (void)BladeContact(block.problem.mesh, blades); }),
            "blade 'blade': the nodes of the blade are not its middle and the ends of its half sides");
        EXPECT_EQ(message_of([] { (void)blade_nodes({ .name = "left", .width_mm = 0.0, .height_mm = 5.0 }); }),
            "blade 'left': a blade needs a positive width and height");
        EXPECT_EQ(message_of([&] {
            (void)make_blade_surface(block.problem.mesh,
                std::vector<Lame>(block.problem.mesh.tet_count(), Lame { 1.0, 1.0 }),
                mesh::boundary_faces(block.problem.mesh), {},
                { .name = "left", .middle = Vec3(0.0, 0.0, 500.0), .width_mm = 5.0, .height_mm = 5.0 }, { 0, 1, 2 });
        }),
            "blade 'left': no face of the lip looks at the blade");
    }

} // namespace blade_contact_test
} // namespace retractor::fem
