#include "fem/model/contact.h"

#include "fem/error_estimation/error_estimate.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/equilibrium.h"
#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"
#include "tests/support/wounds/hooked_block.h"
#include "tests/support/wounds/pushed_lips.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

namespace retractor::fem {
namespace contact_test {

    using namespace test_support;

    constexpr double kTight = 1e-10; // residual
    constexpr double kSame = 1e-7; // what that leaves of displacements and forces, relative

    /// Two meshes in one, not joined: the second moved by `offset`, its labels 2.
    mesh::TetMesh both(const mesh::TetMesh& lower, const mesh::TetMesh& upper, const Vec3& offset)
    {
        mesh::TetMesh mesh = lower;
        const auto before = static_cast<VertexId>(lower.vertex_count());
        mesh.vertices.conservativeResize(lower.vertices.rows() + upper.vertices.rows(), 3);
        mesh.vertices.bottomRows(upper.vertices.rows()) = upper.vertices.rowwise() + offset.transpose();
        for (const VertexId v : upper.nodes)
            mesh.nodes.push_back(v + before);
        mesh.labels.insert(mesh.labels.end(), upper.tet_count(), Label { 2 });
        return mesh;
    }

    std::vector<VertexId> nodes_at(const mesh::TetMesh& mesh, int axis, double plane, VertexId from, VertexId to)
    {
        constexpr double kRoundOff = 1e-9;
        std::vector<VertexId> nodes;
        for (VertexId v = from; v < to; ++v)
            if (std::abs(mesh.vertices(v, axis) - plane) < kRoundOff)
                nodes.push_back(v);
        return nodes;
    }

    constexpr double kEdge = 2.5, kSide = 10.0, kLow = 5.0, kHigh = 7.5; // mm

    /// A block on the floor and one above it, `gap` between them, whose top goes down by 1.5 mm.
    ElasticProblem stack(double gap, double poissons_ratio, const Vec3& sideways = Vec3::Zero())
    {
        ElasticProblem problem;
        const mesh::TetMesh lower = mesh::kuhn_box(4, 4, 2, kEdge), upper = mesh::kuhn_box(4, 4, 3, kEdge);
        problem.mesh = both(lower, upper, Vec3(0.0, 0.0, kLow + gap) + sideways);
        problem.material_of_label
            = { {}, test_support::material(0.05, poissons_ratio), test_support::material(0.02, poissons_ratio) };
        const auto split = static_cast<VertexId>(lower.vertex_count()),
                   end = static_cast<VertexId>(problem.mesh.vertex_count());
        problem.supports.fixed = nodes_at(problem.mesh, 2, 0.0, 0, split);
        problem.hooks
            = { { "press", 1, nodes_at(problem.mesh, 2, kLow + gap + kHigh, split, end), Vec3(0.0, 0.0, -1.5) } };
        return problem;
    }

    OpeningOptions with_contact(Elasticity elasticity, ContactOptions contact = {})
    {
        OpeningOptions options;
        options.elasticity = elasticity;
        options.tolerance = kTight;
        options.contact = std::move(contact);
        return options;
    }

    OpeningResult opened(const ElasticProblem& problem, const OpeningOptions& options)
    {
        Opening opening(problem.mesh, problem.material_of_label, problem.supports, options);
        return opening.open(problem.hooks);
    }

    TEST(Contact, DistanceFromAPlaneAndItsDerivatives)
    {
        std::mt19937 random(7);
        std::uniform_real_distribution<double> place(-1.0, 1.0);
        const auto at = [&] { return Vec3(place(random), place(random), place(random)); };
        for (int i = 0; i < 20; ++i) {
            const std::array<Vec3, 4> x { at(), at(), at(), at() };
            const auto moved = [&](const Eigen::Matrix<double, 12, 1>& d) {
                std::array<Vec3, 4> y = x;
                for (std::size_t k = 0; k < 4; ++k)
                    y[k] += d.segment<3>(3 * static_cast<Eigen::Index>(k));
                return plane_distance(y[0], { y[1], y[2], y[3] });
            };
            const PlaneDistance s = plane_distance(x[0], { x[1], x[2], x[3] });
            const Vec3 n = (x[2] - x[1]).cross(x[3] - x[1]).normalized();
            EXPECT_NEAR(s.value, n.dot(x[0] - x[1]), 1e-14);
            constexpr double kStep = 1e-6, kCentral = 1e-6; // of derivatives of order one; small triangles have larger
            const double size = 1.0 + s.hessian.cwiseAbs().maxCoeff();
            for (int k = 0; k < 12; ++k) {
                const auto d = kStep * Eigen::Matrix<double, 12, 1>::Unit(k);
                const PlaneDistance more = moved(d), less = moved(-d);
                EXPECT_NEAR((more.value - less.value) / (2.0 * kStep), s.gradient[k], kCentral * size);
                EXPECT_LT(((more.gradient - less.gradient) / (2.0 * kStep) - s.hessian.col(k)).cwiseAbs().maxCoeff(),
                    kCentral * size * size);
            }
        }
    }

    /// Two blocks pressed into each other a little and shaken, with a floor through the lower one.
    struct Pressed {
        mesh::TetMesh mesh;
        std::vector<Lame> lame;
        Eigen::VectorXd u;
        Contact contact;

        static TriMesh floor()
        {
            TriMesh floor;
            floor.vertices.resize(4, 3);
            floor.vertices << -5.0, -5.0, 0.0, 15.0, -5.0, 0.0, 15.0, 15.0, 0.0, -5.0, 15.0, 0.0;
            floor.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
            return floor;
        }
        explicit Pressed(bool with_floor)
            : mesh(stack(0.5, 0.3, Vec3(0.8, 0.3, 0.0)).mesh)
            , lame(mesh.tet_count(), Lame { 0.01, 0.03 })
            , u(3 * mesh.vertices.rows())
            , contact(mesh, lame, with_floor ? ContactOptions { .fixed = { floor() } } : ContactOptions {})
        {
            std::mt19937 random(3);
            std::uniform_real_distribution<double> shake(-0.1, 0.1);
            for (Eigen::Index i = 0; i < u.size(); ++i)
                u[i] = shake(random) - (i % 3 != 2 ? 0.0 : mesh.vertices(i / 3, 2) > kLow + 0.1 ? 0.9 : 0.2);
            (void)contact.find(u);
        }
    };

    TEST(Contact, ForcesAreTheDerivativeOfTheEnergyAndTheStiffnessTheirs)
    {
        const Pressed p(true);
        EXPECT_GT(p.contact.state(p.u).touching, 20U);
        const auto response = [&](const Eigen::VectorXd& u) {
            std::pair<double, Eigen::VectorXd> r { 0.0, Eigen::VectorXd::Zero(u.size()) };
            r.first = p.contact.add_response(u, r.second);
            return r;
        };
        const auto here = response(p.u);
        BlockMatrix K { p.contact.pattern(block_pattern(p.mesh)), {} };
        K.values.assign(9 * K.pattern.block_count(), 0.0);
        p.contact.add_stiffness(p.u, 0.0, K);
        std::mt19937 random(5);
        std::uniform_real_distribution<double> any(-1.0, 1.0);
        for (int i = 0; i < 5; ++i) {
            Eigen::VectorXd d(p.u.size());
            for (double& x : d)
                x = any(random);
            constexpr double kStep = 1e-6, kCentral = 1e-6;
            const auto more = response(p.u + kStep * d), less = response(p.u - kStep * d);
            EXPECT_NEAR((more.first - less.first) / (2.0 * kStep), here.second.dot(d),
                kCentral * here.second.norm() * d.norm());
            const Eigen::VectorXd Kd = K.multiply(d);
            EXPECT_LT(((more.second - less.second) / (2.0 * kStep) - Kd).norm(), 1e-5 * Kd.norm());
        }
        BlockMatrix definite = K;
        std::fill(definite.values.begin(), definite.values.end(), 0.0);
        p.contact.add_stiffness(p.u, 1.0, definite);
        for (int i = 0; i < 20; ++i) {
            Eigen::VectorXd d(p.u.size());
            for (double& x : d)
                x = any(random);
            EXPECT_GE(d.dot(definite.multiply(d)), 0.0);
        }
    }

    /// A point that slides over the edge of its face finds the blocks of the next face in the pattern, and more blocks
    /// change nothing but zeros.
    TEST(Contact, ThePatternHoldsTheFacesRoundThoseOfThePairs)
    {
        Pressed p(true);
        const BlockPattern body = block_pattern(p.mesh);
        BlockMatrix exact { p.contact.pattern(body), {} }, wide { p.contact.pattern_with_neighbours(body), {} };
        EXPECT_FALSE(p.contact.is_within(body));
        EXPECT_TRUE(p.contact.is_within(exact.pattern));
        EXPECT_TRUE(p.contact.is_within(wide.pattern));
        for (BlockMatrix* K : { &exact, &wide }) {
            K->values.assign(9 * K->pattern.block_count(), 0.0);
            p.contact.add_stiffness(p.u, 0.0, *K);
        }
        std::mt19937 random(11);
        std::uniform_real_distribution<double> any(-1.0, 1.0);
        Eigen::VectorXd d(p.u.size());
        for (double& x : d)
            x = any(random);
        EXPECT_LT((exact.multiply(d) - wide.multiply(d)).norm(), 1e-12 * exact.multiply(d).norm());
        Eigen::VectorXd slid = p.u;
        for (Eigen::Index v = 0; v < p.mesh.vertices.rows(); ++v)
            if (p.mesh.vertices(v, 2) > kLow + 0.1) { // the upper block alone, away from faces that it was not over
                slid[3 * v] += 0.3 * kEdge;
                slid[3 * v + 1] += 0.2 * kEdge;
            }
        EXPECT_TRUE(p.contact.find(slid));
        EXPECT_TRUE(p.contact.is_within(wide.pattern));
        EXPECT_GT(wide.pattern.block_count(), exact.pattern.block_count());
    }

    TEST(Contact, TheDeepestPlaceNamesItsSurface)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(4, 4, 3, kEdge);
        TriMesh floor = Pressed::floor(), wall;
        floor.vertices.col(2).setConstant(-1.0);
        wall.vertices.resize(4, 3);
        wall.vertices << 12, -50, -50, 12, -50, 60, 12, 60, 60, 12, 60, -50;
        wall.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
        Contact contact(mesh, std::vector<Lame>(mesh.tet_count(), Lame { 0.01, 0.03 }), { .fixed = { floor, wall } });
        const auto moved = [&](const Vec3& by) {
            Eigen::VectorXd u(3 * mesh.vertices.rows());
            for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
                u.segment<3>(3 * v) = by;
            (void)contact.find(u);
            return contact.state(u);
        };
        EXPECT_FALSE(moved(Vec3::Zero()).fixed);
        EXPECT_EQ(moved(Vec3(0.0, 0.0, -1.5)).fixed, 0U);
        EXPECT_EQ(moved(Vec3(3.0, 0.0, -1.5)).fixed, 1U) << "1 mm behind the wall, and half a mm behind the floor";
        Pressed both(false);
        EXPECT_GT(both.contact.state(both.u).penetration, 0.0);
        EXPECT_FALSE(both.contact.state(both.u).fixed) << "the two blocks are one body";
    }

    TEST(Contact, PairsAreKeptWhereOnlyNewOnesAreAskedFor)
    {
        Pressed p(true);
        const std::vector<ContactPair> before = p.contact.pairs();
        Eigen::VectorXd slid = p.u;
        for (Eigen::Index v = 0; v < p.mesh.vertices.rows(); ++v)
            if (p.mesh.vertices(v, 2) > kLow + 0.1) // the upper block alone, over a whole edge
                slid[3 * v] -= kEdge;
        const auto kept = [&] {
            return std::count_if(before.begin(), before.end(), [&](const ContactPair& pair) {
                return std::find(p.contact.pairs().begin(), p.contact.pairs().end(), pair) != p.contact.pairs().end();
            });
        };
        EXPECT_TRUE(p.contact.find(slid, Contact::Pairing::new_only)); // points that came over the lower block
        EXPECT_EQ(kept(), static_cast<std::ptrdiff_t>(before.size()));
        EXPECT_GT(p.contact.pairs().size(), before.size());
        EXPECT_FALSE(p.contact.find(slid, Contact::Pairing::new_only));
        // Back where it was nothing is new: what leads there and back ends.
        EXPECT_FALSE(p.contact.find(p.u, Contact::Pairing::new_only));
        EXPECT_TRUE(p.contact.find(slid));
        EXPECT_LT(kept(), static_cast<std::ptrdiff_t>(before.size()));
    }

    TEST(Contact, ForcesOfABodyOnItselfAreOppositeAndEqual)
    {
        const Pressed p(false);
        Eigen::VectorXd forces = Eigen::VectorXd::Zero(p.u.size());
        (void)p.contact.add_response(p.u, forces);
        Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
        double size = 0.0;
        for (Eigen::Index v = 0; v < p.mesh.vertices.rows(); ++v) {
            const Vec3 f = forces.segment<3>(3 * v);
            sum += f;
            moment += Vec3(p.mesh.vertices.row(v).transpose() + p.u.segment<3>(3 * v)).cross(f);
            size += f.norm();
        }
        EXPECT_GT(size, 0.0);
        EXPECT_LT(sum.norm(), 1e-12 * size);
        EXPECT_LT(moment.norm(), 1e-11 * size * kSide);
    }

    TEST(Contact, TwoBlocksPressedTogetherAreSpringsInARow)
    {
        struct Solved {
            Elasticity elasticity;
            bool locking_free;
        };
        for (const auto [elasticity, locking_free] :
            { Solved { Elasticity::linear, false }, Solved { Elasticity::corotational, false },
                Solved { Elasticity::linear, true }, Solved { Elasticity::corotational, true } }) {
            const double gap = 0.4;
            ElasticProblem problem = stack(gap, 0.0);
            if (elasticity == Elasticity::corotational) // of so small a motion that it is linear
                problem.hooks[0].displacement.z() = -gap - 1e-4;
            OpeningOptions options = with_contact(elasticity);
            options.locking_free = locking_free;
            const OpeningResult result = opened(problem, options);
            ASSERT_EQ(result.status, OpeningStatus::converged) << result.message;
            const double E1 = 0.05, E2 = 0.02;
            const double k = 0.5 * 20.0 * (E1 + E2) / kEdge; // half of each surface's; nu = 0: the P-wave modulus is E
            const double pressed = -problem.hooks[0].displacement.z() - gap;
            const double pressure = pressed / (kLow / E1 + kHigh / E2 + 1.0 / k);
            const double same = elasticity == Elasticity::linear ? kSame : 1e-4; // the strain of the second
            EXPECT_NEAR(result.hook_forces_N[0].z(), -pressure * kSide * kSide, same * pressure * kSide * kSide);
            EXPECT_LT(result.hook_forces_N[0].head<2>().norm(), same * pressure * kSide * kSide);
            EXPECT_NEAR(result.contact.penetration, pressure / k, same * pressure / k);
            for (Eigen::Index v = 0; v < problem.mesh.vertices.rows(); ++v) {
                const double z = problem.mesh.vertices(v, 2);
                const bool below = z <= kLow;
                const double expected
                    = below ? -pressure * z / E1 : -gap - pressed + pressure * (kLow + gap + kHigh - z) / E2;
                EXPECT_NEAR(result.displacement(v, 2), expected, same * (pressed + gap));
            }
        }
    }

    TEST(Contact, ABlockStandsOnAFixedSurface)
    {
        // Held at its top alone, pressed onto a plane 0.3 mm below it. Tissue sinks by its modulus, bone by 0.2 mm/MPa:
        // the plane's own corners, which hold half of the stiffness, lie beside the block.
        const double stiffest = ContactOptions().stiffest_N_mm3;
        for (const double E : { 0.02, 5000.0 }) {
            ElasticProblem problem;
            problem.mesh = mesh::kuhn_box(4, 4, 3, kEdge);
            problem.material_of_label = { {}, test_support::material(E, 0.0) };
            problem.hooks = { { "press", 1,
                nodes_at(problem.mesh, 2, kHigh, 0, static_cast<VertexId>(problem.mesh.vertex_count())),
                Vec3(0.0, 0.0, -1.0) } };
            TriMesh plane = Pressed::floor();
            plane.vertices.col(2).setConstant(-0.3);
            const OpeningResult result = opened(problem, with_contact(Elasticity::linear, { .fixed = { plane } }));
            ASSERT_EQ(result.status, OpeningStatus::converged) << result.message;
            const double k = 0.5 * std::min(20.0 * E / kEdge, stiffest);
            const double pressure = 0.7 / (kHigh / E + 1.0 / k), force = pressure * kSide * kSide;
            EXPECT_NEAR(result.hook_forces_N[0].z(), -force, kSame * force) << E;
            EXPECT_NEAR(result.contact.force_N, force, kSame * force) << E;
            EXPECT_NEAR(result.contact.penetration, pressure / k, kSame * pressure / k) << E;
        }
    }

    TEST(Contact, PenetrationFallsAsThePenaltyRises)
    {
        std::vector<double> depth;
        for (const double stiffness : { 20.0, 200.0 }) {
            const OpeningResult result = opened(
                stack(0.4, 0.3, Vec3(0.9, 0.4, 0.0)), with_contact(Elasticity::linear, { .stiffness = stiffness }));
            ASSERT_EQ(result.status, OpeningStatus::converged) << result.message;
            depth.push_back(result.contact.penetration);
        }
        EXPECT_NEAR(depth[0] / depth[1], 10.0, 3.0); // the force is nearly the same
    }

    /// How far the lips have passed through each other: elements' middles of each lip's side beyond the other's, by the
    /// pairs of vertices that were one at rest. The left lip's vertex of a pair is found by its elements.
    double passed_through(const PushedLips& lips, const Points& displacement)
    {
        const mesh::TetMesh& mesh = lips.problem.mesh;
        std::vector<double> side(mesh.vertex_count(), 0.0);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            double middle = 0.0;
            for (const VertexId v : mesh.tet(t))
                middle += 0.25 * mesh.vertices(v, 0);
            for (const VertexId v : mesh.tet(t))
                side[static_cast<std::size_t>(v)] += middle - 24.0;
        }
        double passed = 0.0;
        for (const auto& [v, w] : lips.pairs) {
            const bool v_left = side[static_cast<std::size_t>(v)] < side[static_cast<std::size_t>(w)];
            const VertexId left = v_left ? v : w, right = v_left ? w : v;
            passed = std::max(passed, displacement(left, 0) - displacement(right, 0));
        }
        return passed;
    }

    TEST(Contact, LipsPushedTogetherDoNotPassThroughEachOther)
    {
        const PushedLips lips = lips_pushed(3.0); // a quarter of what lies between the hooks, from each side
        ASSERT_GT(lips.pairs.size(), 10U);
        for (const Elasticity elasticity : { Elasticity::linear, Elasticity::corotational }) {
            OpeningOptions without = with_contact(elasticity);
            without.tolerance = 1e-6;
            const OpeningResult held = opened(lips.problem, without);
            ASSERT_EQ(held.status, OpeningStatus::converged) << held.message;
            without.contact.reset();
            const OpeningResult through = opened(lips.problem, without);
            EXPECT_GT(passed_through(lips, through.displacement), 4.0); // mm: so they would
            constexpr double kShare = 0.05; // of an edge of 4 mm
            EXPECT_LT(passed_through(lips, held.displacement), kShare * 4.0);
            EXPECT_LT(held.contact.penetration, kShare * 4.0);
            EXPECT_GT(held.contact.touching, 5U);
            EXPECT_GT(held.hook_forces_N[0].x(), through.hook_forces_N[0].x()); // harder to push
            EXPECT_EQ(held.inverted_elements, 0);
        }
    }

    TEST(Contact, LipsOfLockingFreeElementsHoldEachOtherOff)
    {
        PushedLips lips = lips_pushed(3.0);
        constexpr double kShare = 0.05; // of an edge of 4 mm
        const auto pushed = [&](double poissons_ratio, bool locking_free, bool ten_nodes) {
            lips.problem.material_of_label[1] = test_support::material(0.02, poissons_ratio);
            OpeningOptions options = with_contact(Elasticity::corotational);
            options.tolerance = 1e-4;
            options.locking_free = locking_free;
            OpeningResult result = opened(ten_nodes ? with_midpoints(lips.problem) : lips.problem, options);
            EXPECT_EQ(result.status, OpeningStatus::converged) << result.message;
            EXPECT_LT(passed_through(lips, result.displacement), kShare * 4.0);
            EXPECT_LT(result.contact.penetration, kShare * 4.0);
            EXPECT_GT(result.contact.touching, 5U);
            EXPECT_EQ(result.inverted_elements, 0);
            return result;
        };
        const auto force = [](const OpeningResult& result) { return result.hook_forces_N[0].x(); };
        const OpeningResult plain = pushed(0.3, false, false), averaged = pushed(0.3, true, false),
                            quadratic = pushed(0.3, false, true);
        // Coarse elements: the plain ones are too stiff, these are nearer to ten-node ones.
        EXPECT_LT(std::abs(force(averaged) - force(quadratic)), 0.5 * std::abs(force(plain) - force(quadratic)));
        EXPECT_LT((averaged.displacement - quadratic.displacement.topRows(averaged.displacement.rows())).norm(),
            (plain.displacement - quadratic.displacement.topRows(averaged.displacement.rows())).norm());
        const OpeningResult stiff = pushed(0.49, true, false);
        EXPECT_GT(force(stiff), force(averaged));
    }

    TEST(Contact, WhatLipsOfLockingFreeElementsPushEachOtherWithCancels)
    {
        const PushedLips lips = lips_pushed(3.0);
        const ElasticProblem& p = lips.problem;
        ElasticBody body = tissue_body(p.mesh, p.material_of_label, { Elasticity::corotational, true });
        body.set_contact(Contact(p.mesh, element_parameters(p.mesh, p.material_of_label), {}));
        const Prescribed held = prescribe(p.mesh, p.supports, p.hooks);
        const Equilibrium e = EquilibriumSolver().solve(
            body, held.flag, held.value, Eigen::VectorXd::Zero(held.value.size()), { .tolerance = 1e-8 }, {});
        ASSERT_EQ(e.status, EquilibriumStatus::converged) << e.message;
        Eigen::VectorXd push = Eigen::VectorXd::Zero(e.forces.size());
        (void)body.contact()->add_response(e.displacement, push);
        Vec3 left = Vec3::Zero(), right = Vec3::Zero(), all = Vec3::Zero();
        double size = 0.0;
        for (Eigen::Index v = 0; v < p.mesh.vertices.rows(); ++v)
            all += e.forces.segment<3>(3 * v);
        for (const auto& [v, w] : lips.pairs)
            for (const VertexId lip : { v, w }) {
                const Vec3 f = push.segment<3>(3 * lip);
                (f.x() > 0.0 ? left : right) += f; // the derivative: what the tissue feels has the other sign
                size += f.norm();
            }
        EXPECT_GT(size, 0.0);
        EXPECT_LT((left + right).norm(), 1e-10 * size);
        EXPECT_LT(all.norm(), 1e-10 * size); // hooks and floor bear no more than they press on
    }

    TEST(Contact, LipsDrawnApartAreNotHeldTogether)
    {
        const PushedLips lips = lips_pushed(-3.0);
        OpeningOptions options = with_contact(Elasticity::corotational);
        const OpeningResult with = opened(lips.problem, options);
        options.contact.reset();
        const OpeningResult without = opened(lips.problem, options);
        ASSERT_EQ(with.status, OpeningStatus::converged) << with.message;
        EXPECT_EQ(with.contact.touching, 0U);
        EXPECT_LT((with.displacement - without.displacement).cwiseAbs().maxCoeff(), 3.0 * kSame);
    }

    TEST(Contact, HooksThatMeetGoNoFarther)
    {
        // What both hold is prescribed, and no force keeps it apart: 1 mm between them, 3 mm asked for.
        ElasticProblem problem = stack(1.0, 0.3);
        const mesh::TetMesh& mesh = problem.mesh;
        const auto split = static_cast<VertexId>(mesh.vertex_count());
        problem.hooks = { { "lower", -1, nodes_at(mesh, 2, kLow, 0, split), Vec3::Zero() },
            { "upper", 1, nodes_at(mesh, 2, kLow + 1.0, 0, split), Vec3(0.0, 0.0, -3.0) } };
        OpeningOptions options = with_contact(Elasticity::corotational);
        const OpeningResult result = opened(problem, options);
        EXPECT_EQ(result.status, OpeningStatus::not_converged);
        EXPECT_NE(result.message.find("two hooks or supports collided after 33."), std::string::npos) << result.message;
        const double end = result.displacement(problem.hooks[1].nodes.front(), 2);
        EXPECT_NEAR(end, -1.0, 0.02); // to a hundredth of a mm behind, which no force has to hold
        EXPECT_LE(result.residual, kTight);
        EXPECT_LT(result.contact.penetration, 0.02);
        // Under pressure too it is they that end it, and not the tissue.
        problem.pressures = { { "gas",
            verification::faces_where(mesh, [](const Vec3& x) { return x.x() == 0.0 && x.z() <= kLow; }), 2e-4 } };
        const OpeningResult pressed = Opening(problem, options).open(problem.hooks);
        EXPECT_NE(pressed.message.find("two hooks or supports collided after 33."), std::string::npos)
            << pressed.message;
        EXPECT_EQ(pressed.message.find("kPa"), std::string::npos) << pressed.message;
    }

    TEST(Contact, WithNothingNearTheAnswerHasTheSameBits)
    {
        const ElasticProblem problem = test_support::hooked_block(2, 4);
        OpeningOptions options = with_contact(Elasticity::corotational);
        options.tolerance = 1e-6;
        const OpeningResult with = opened(problem, options);
        options.contact.reset();
        const OpeningResult without = opened(problem, options);
        EXPECT_EQ(with.displacement, without.displacement);
        EXPECT_EQ(with.hook_forces_N, without.hook_forces_N);
        EXPECT_EQ(with.contact.touching, 0U);
    }

    TEST(Contact, AThinSheetIsNotInContactWithItsOwnOtherSide)
    {
        const mesh::TetMesh sheet = mesh::kuhn_box(8, 8, 1, 2.0);
        Contact contact(sheet, std::vector<Lame>(sheet.tet_count(), Lame { 0.01, 0.03 }), {});
        Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * sheet.vertices.rows());
        for (Eigen::Index v = 0; v < sheet.vertices.rows(); ++v) // bent, and pressed to half its thickness
            u[3 * v + 2] = 0.02 * std::pow(sheet.vertices(v, 0) - 8.0, 2) - 0.5 * sheet.vertices(v, 2);
        EXPECT_FALSE(contact.find(u));
        EXPECT_TRUE(contact.pairs().empty());
    }

    TEST(Contact, AnOverlapAtRestIsKeptAndReported)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(4, 4, 3, kEdge);
        TriMesh floor = Pressed::floor();
        floor.vertices.col(2).setConstant(0.3);
        Contact contact(mesh, std::vector<Lame>(mesh.tet_count(), Lame { 0.01, 0.03 }), { .fixed = { floor } });
        EXPECT_NEAR(contact.overlap_at_rest(), 0.3, 1e-12);
        Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        (void)contact.find(u);
        EXPECT_EQ(contact.state(u).touching, 0U);
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
            u[3 * v + 2] = -0.25;
        (void)contact.find(u);
        EXPECT_NEAR(contact.state(u).penetration, 0.25, 1e-12); // beyond it there is a force
    }

    /// As a fold makes a point: behind a face, and never in front of it.
    TEST(Contact, APointThatFindsItselfBehindAFaceIsNotThrownOut)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(4, 4, 3, kEdge);
        TriMesh floor, wall;
        floor.vertices.resize(4, 3);
        floor.vertices << -50, -50, -1, 80, -50, -1, 80, 60, -1, -50, 60, -1;
        floor.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
        wall.vertices.resize(4, 3);
        wall.vertices << 30, -50, -50, 30, -50, 60, 30, 60, 60, 30, 60, -50;
        wall.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
        Contact contact(mesh, std::vector<Lame>(mesh.tet_count(), Lame { 0.01, 0.03 }), { .fixed = { floor, wall } });
        EXPECT_EQ(contact.overlap_at_rest(), 0.0);
        Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        (void)contact.find(u);
        ASSERT_FALSE(contact.pairs().empty()) << "the floor is near";
        const auto moved = [&](double x) {
            for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
                u[3 * v] = x;
            (void)contact.find(u);
            return contact.state(u);
        };
        constexpr double kTo = 30.0 - 4 * kEdge, kBehind = 1.0, kFurther = 0.4;
        EXPECT_EQ(moved(kTo + kBehind).touching, 0U) << "no force all at once";
        EXPECT_NEAR(contact.overlap_at_rest(), kBehind, 1e-12) << "and the overlap is reported";
        EXPECT_NEAR(moved(kTo + kBehind + kFurther).penetration, kFurther, 1e-12) << "farther in, it is held off";
        EXPECT_EQ(moved(kTo - kBehind).touching, 0U);
        EXPECT_EQ(moved(0.0).touching, 0U);
        (void)moved(kTo - kBehind); // seen in front now
        EXPECT_NEAR(moved(kTo + kBehind).penetration, kBehind, 1e-12);
    }

    TEST(Contact, TakesTenNodeElements)
    {
        ElasticProblem problem = stack(0.4, 0.0);
        problem.mesh = with_midpoints(problem.mesh);
        const auto end = static_cast<VertexId>(problem.mesh.vertex_count());
        problem.supports.fixed = nodes_at(problem.mesh, 2, 0.0, 0, end);
        problem.hooks[0].nodes = nodes_at(problem.mesh, 2, kLow + 0.4 + kHigh, 0, end);
        const OpeningResult result = opened(problem, with_contact(Elasticity::linear));
        ASSERT_EQ(result.status, OpeningStatus::converged) << result.message;
        // Springs in a row but for the penalty, whose shares at corners and midpoints are not those of a pressure.
        const double series = 1.1 / (kLow / 0.05 + kHigh / 0.02) * kSide * kSide;
        EXPECT_NEAR(-result.hook_forces_N[0].z() / series, 1.0, 0.03);
        EXPECT_LT(result.contact.penetration, 0.05 * kEdge);
    }

    TEST(Contact, RefusesBadInput)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(1, 1, 1, kEdge);
        const std::vector<Lame> lame(mesh.tet_count(), Lame { 0.01, 0.03 });
        const auto made = [&](const ContactOptions& options) {
            return test_support::message_of([&] { (void)Contact(mesh, lame, options); });
        };
        EXPECT_EQ(made({ .stiffness = 0.0 }), "contact: the penalty's stiffness and the reach must be positive");
        EXPECT_EQ(made({ .reach = std::numeric_limits<double>::infinity() }),
            "contact: the penalty's stiffness and the reach must be positive");
        TriMesh floor = Pressed::floor();
        floor.triangles[1] = { 0, 2, 2 };
        EXPECT_EQ(
            made({ .fixed = { Pressed::floor(), floor } }), "fixed surface 1, triangle 1: the triangle has no area");
        floor.triangles[1] = { 0, 2, 4 };
        EXPECT_EQ(made({ .fixed = { floor } }), "fixed surface 0, triangle 1: vertex 4 is out of range or not finite");
    }

} // namespace contact_test
} // namespace retractor::fem
