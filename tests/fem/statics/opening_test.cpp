#include "fem/statics/opening.h"

#include "fem/model/floating_components.h"
#include "fem/statics/hook.h"
#include "fem/statics/hooks_apart.h"
#include "fem/statics/nonlinear_region.h"
#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"
#include "tests/verification/framework/incision.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace retractor::fem {
namespace opening_test {

    using test_support::material;

    struct Wound {
        mesh::TetMesh mesh;
        std::vector<std::array<VertexId, 3>> left, right; ///< lip faces, x falling and rising away from the cut
        Supports supports; ///< bottom and outer sides
        double spacing = 0.0;
    };

    /// A box of 2n x 2n x n cells cut at mid-width, over the middle two thirds of its length and of its depth.
    Wound slit_box(int n, double spacing)
    {
        Wound wound;
        wound.spacing = spacing;
        mesh::TetMesh& mesh = wound.mesh;
        mesh = mesh::kuhn_box(2 * n, 2 * n, n, spacing);
        const double width = 2 * n * spacing, middle = 0.5 * width, top = n * spacing, tiny = 1e-9;
        const auto old_count = mesh.vertices.rows();
        const auto cut = [&](VertexId v) {
            const auto p = mesh.vertices.row(v);
            return std::abs(p.x() - middle) < tiny && std::abs(p.y() - middle) < width / 3 - tiny
                && p.z() > top / 3 + tiny;
        };
        std::map<VertexId, VertexId> copy;
        for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
            double x = 0.0;
            for (const VertexId v : mesh.tet(static_cast<TetId>(t)))
                x += 0.25 * mesh.vertices(v, 0);
            for (std::size_t a = 4 * t; x > middle && a < 4 * t + 4; ++a)
                if (cut(mesh.nodes[a]))
                    mesh.nodes[a] = copy.try_emplace(mesh.nodes[a],
                                            static_cast<VertexId>(old_count) + static_cast<VertexId>(copy.size()))
                                        .first->second;
        }
        mesh.vertices.conservativeResize(old_count + static_cast<Eigen::Index>(copy.size()), Eigen::NoChange);
        for (const auto& [from, to] : copy)
            mesh.vertices.row(to) = mesh.vertices.row(from);
        for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
            const auto v = mesh::face_vertices(mesh, face);
            if (std::all_of(
                    v.begin(), v.end(), [&](VertexId i) { return std::abs(mesh.vertices(i, 0) - middle) < tiny; })) {
                double x = 0.0;
                for (const VertexId i : mesh.tet(face.tet))
                    x += 0.25 * mesh.vertices(i, 0);
                (x < middle ? wound.left : wound.right).push_back(v);
            }
        }
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
            const auto p = mesh.vertices.row(v);
            if (p.z() < tiny || std::min(p.x(), p.y()) < tiny || std::max(p.x(), p.y()) > width - tiny)
                wound.supports.fixed.push_back(static_cast<VertexId>(v));
        }
        return wound;
    }

    Wound with_ten_nodes(Wound wound)
    {
        wound.mesh = mesh::with_midpoints(wound.mesh);
        const double width = wound.mesh.vertices.col(0).maxCoeff(), tiny = 1e-9;
        wound.supports.fixed.clear();
        for (Eigen::Index v = 0; v < wound.mesh.vertices.rows(); ++v) {
            const auto p = wound.mesh.vertices.row(v);
            if (p.z() < tiny || std::min(p.x(), p.y()) < tiny || std::max(p.x(), p.y()) > width - tiny)
                wound.supports.fixed.push_back(static_cast<VertexId>(v));
        }
        return wound;
    }

    std::vector<HookPatch> two_hooks(const Wound& wound, double pull)
    {
        const Vec3 high = wound.mesh.vertices.colwise().maxCoeff().transpose();
        const Vec3 centre(0.5 * high.x(), 0.5 * high.y(), high.z() - 0.75 * wound.spacing);
        const auto patch = [&](const auto& lip) {
            return hook_patch_nodes(
                wound.mesh, lip, centre, Vec3::UnitY(), Vec3::UnitZ(), 2.5 * wound.spacing, 1.75 * wound.spacing);
        };
        return { { "left", -1, patch(wound.left), { -pull, 0, 0 } },
            { "right", 1, patch(wound.right), { pull, 0, 0 } } };
    }

    std::vector<Material> tissue(double nu = 0.45) { return { {}, test_support::material(0.02, nu) }; }

    OpeningResult open(const Wound& wound, double pull, OpeningOptions options = {}, double nu = 0.45)
    {
        Opening opening(wound.mesh, tissue(nu), wound.supports, options);
        return opening.open(two_hooks(wound, pull));
    }

    // -- Closed form and invariants.

    TEST(Opening, HomogeneousStretchOfABarHasTheClosedForm)
    {
        const int n = 4;
        const double spacing = 5.0, length = n * spacing, area = length * length, stretch = 1.5, E = 0.1;
        const mesh::TetMesh bar = mesh::kuhn_box(n, n, n, spacing);
        // nu = 0: no lateral contraction, so clamped ends do not disturb: P = E (l - 1), with lambda = 0 and 2 mu = E.
        Supports supports;
        HookPatch end { "end", 1, {}, { (stretch - 1) * length, 0, 0 } };
        for (Eigen::Index v = 0; v < bar.vertices.rows(); ++v) {
            if (bar.vertices(v, 0) == 0.0)
                supports.fixed.push_back(static_cast<VertexId>(v));
            if (bar.vertices(v, 0) == length)
                end.nodes.push_back(static_cast<VertexId>(v));
        }
        Opening opening(bar, std::vector<Material> { {}, test_support::material(E, 0.0) }, supports);
        const OpeningResult result = opening.open(std::vector { end });
        ASSERT_EQ(result.status, OpeningStatus::converged) << result.message;
        EXPECT_NEAR(result.hook_forces_N[0].x(), E * (stretch - 1) * area, 1e-6 * E * area);
        EXPECT_NEAR(result.max_volume_ratio, stretch, 1e-6);
        EXPECT_NEAR(result.min_volume_ratio, stretch, 1e-6);
        EXPECT_NEAR(result.strain_p99, 0.5 * (stretch * stretch - 1), 1e-6);
        EXPECT_EQ(result.inverted_elements, 0);
    }

    TEST(Opening, ABarOnABedIsTwoSpringsInSeries)
    {
        const int n = 4;
        const double spacing = 5.0, length = n * spacing, area = length * length, E = 0.1, bed = 0.02, pull = 2.0;
        const mesh::TetMesh bar = mesh::kuhn_box(n, n, n, spacing);
        Supports supports;
        HookPatch end { "end", 1, {}, { pull, 0, 0 } };
        std::vector<double> share(bar.vertex_count(), 0.0); // of the face x = 0
        for (const mesh::TetFace& face : mesh::boundary_faces(bar)) {
            const auto v = mesh::face_vertices(bar, face);
            if (std::all_of(v.begin(), v.end(), [&](VertexId i) { return bar.vertices(i, 0) == 0.0; }))
                for (const VertexId i : v)
                    share[static_cast<std::size_t>(i)] += 0.5 * spacing * spacing / 3.0;
        }
        for (Eigen::Index v = 0; v < bar.vertices.rows(); ++v) {
            if (share[static_cast<std::size_t>(v)] > 0.0)
                supports.bedded.push_back({ static_cast<VertexId>(v), bed * share[static_cast<std::size_t>(v)] });
            if (bar.vertices(v, 0) == length)
                end.nodes.push_back(static_cast<VertexId>(v));
        }
        // nu = 0: uniform tension, F = d / (L / (E A) + 1 / (b A)).
        const double force = pull * area / (length / E + 1.0 / bed);
        for (const Elasticity model : { Elasticity::linear, Elasticity::corotational }) {
            Opening opening(bar, std::vector<Material> { {}, test_support::material(E, 0.0) }, supports,
                { .elasticity = model, .tolerance = 1e-8 });
            const OpeningResult result = opening.open(std::vector { end });
            ASSERT_EQ(result.status, OpeningStatus::converged) << result.message;
            EXPECT_NEAR(result.hook_forces_N[0].x(), force, 1e-5 * force);
            for (const BeddedVertex& bedded : supports.bedded)
                EXPECT_NEAR(result.displacement(bedded.vertex, 0), force / (bed * area), 1e-4 * pull);
        }
        supports.bedded.front().stiffness = -1.0;
        EXPECT_THROW(Opening(bar, std::vector<Material> { {}, test_support::material(E, 0.0) }, supports), InputError);
    }

    TEST(Opening, MovingTheOnlyHookOfAFreeBlockCostsNoForce)
    {
        const mesh::TetMesh block = mesh::kuhn_box(3, 3, 3, 4.0);
        HookPatch hook { "hook", 1, {}, { 30, -20, 10 } };
        for (Eigen::Index v = 0; v < block.vertices.rows(); ++v)
            if (block.vertices(v, 0) == 0.0)
                hook.nodes.push_back(static_cast<VertexId>(v));
        Opening opening(block, tissue(), {});
        const OpeningResult result = opening.open(std::vector { hook });
        EXPECT_EQ(result.status, OpeningStatus::converged) << result.message;
        EXPECT_LE((result.displacement.rowwise() - hook.displacement.transpose()).cwiseAbs().maxCoeff(), 1e-9);
        EXPECT_LE(result.hook_forces_N[0].norm(), 1e-9);
    }

    TEST(Opening, HooksAtRestMoveNothing)
    {
        for (const Elasticity model : { Elasticity::linear, Elasticity::corotational }) {
            const OpeningResult result = open(slit_box(3, 5.0), 0.0, { .elasticity = model });
            EXPECT_EQ(result.status, OpeningStatus::converged);
            EXPECT_EQ(result.displacement.cwiseAbs().maxCoeff(), 0.0);
            EXPECT_EQ(result.hook_forces_N[0].norm(), 0.0);
        }
    }

    TEST(Opening, LargeHookDisplacementNeitherInvertsNorSwells)
    {
        const Wound wound = slit_box(6, 4.0);
        const OpeningResult large = open(wound, 8.0), linear = open(wound, 8.0, { .elasticity = Elasticity::linear });
        ASSERT_EQ(large.status, OpeningStatus::converged) << large.message;
        EXPECT_LE(large.residual, OpeningOptions {}.tolerance);
        EXPECT_EQ(large.inverted_elements, 0);
        EXPECT_LT(large.max_volume_ratio, 1.5);
        EXPECT_LT(large.max_volume_ratio, linear.max_volume_ratio);
        EXPECT_GT(large.min_volume_ratio, 0.0);
        // The hooks pull outwards, and the hooks and the supports are in balance.
        EXPECT_LT(large.hook_forces_N[0].x(), 0.0);
        EXPECT_GT(large.hook_forces_N[1].x(), 0.0);
    }

    TEST(Opening, QuadraticElementsOpenTheSameWoundMoreSoftly)
    {
        const Wound wound = slit_box(3, 8.0);
        const OpeningResult p1 = open(wound, 4.0, {}, 0.49), p2 = open(with_ten_nodes(wound), 4.0, {}, 0.49);
        ASSERT_EQ(p1.status, OpeningStatus::converged) << p1.message;
        ASSERT_EQ(p2.status, OpeningStatus::converged) << p2.message;
        EXPECT_LT(p2.hook_forces_N[1].x(), p1.hook_forces_N[1].x()); // a minimum over a larger space
        EXPECT_GT(p2.hook_forces_N[1].x(), 0.0);
    }

    TEST(Opening, NonlinearTissueTendsToLinearWithTheLoad)
    {
        const Wound wound = slit_box(3, 5.0);
        for (const Elasticity elasticity : { Elasticity::corotational, Elasticity::hyperelastic }) {
            const auto difference = [&](double pull) {
                const OpeningOptions tight { .elasticity = elasticity, .load_steps = 1, .tolerance = 1e-10 };
                OpeningOptions linear = tight;
                linear.elasticity = Elasticity::linear;
                return (open(wound, pull, tight).displacement - open(wound, pull, linear).displacement).norm() / pull;
            };
            const double coarse = difference(0.2), fine = difference(0.1);
            constexpr double kSlack = 0.1;
            EXPECT_NEAR(std::log2(coarse / fine), 1.0, kSlack) << coarse << " " << fine;
        }
    }

    TEST(Opening, AStretchedBarFollowsItsMaterialsLaw)
    {
        // Free sides, nearly incompressible: P = 2 (l - 1/l^2) (c10 + c01 / l) of the rest area [Treloar 1975].
        const int n = 2;
        const double spacing = 5.0, length = n * spacing, area = length * length, stretch = 1.3;
        const mesh::TetMesh bar = mesh::kuhn_box(n, n, n, spacing);
        constexpr double c10 = 0.02, c01 = 0.01;
        Material rubber = test_support::material(6.0 * (c10 + c01), 0.4999);
        rubber.law = TissueLaw { MooneyRivlin { .c10 = c10, .c01 = c01 } };
        // The surface is moved as the closed form says, the middle is free to find its place.
        const double across = 1.0 / std::sqrt(stretch);
        Supports supports;
        std::vector<HookPatch> hooks;
        for (VertexId v = 0; v < static_cast<VertexId>(bar.vertex_count()); ++v) {
            const Vec3 p = bar.vertices.row(v).transpose();
            if (p.minCoeff() > 0.0 && p.maxCoeff() < length)
                continue;
            hooks.push_back({ "end " + std::to_string(v), 1, { v },
                { (stretch - 1.0) * p.x(), (across - 1.0) * p.y(), (across - 1.0) * p.z() } });
        }
        Opening opening(bar, std::vector { Material {}, rubber }, supports,
            { .elasticity = Elasticity::hyperelastic, .tolerance = 1e-9 });
        const OpeningResult result = opening.open(hooks);
        ASSERT_EQ(result.status, OpeningStatus::converged) << result.message;
        double force = 0.0;
        for (std::size_t h = 0; h < hooks.size(); ++h)
            if (bar.vertices(hooks[h].nodes[0], 0) == length)
                force += result.hook_forces_N[h].x();
        double side = 0.0; // the volume being kept, the law fixes only the difference of the true stresses
        for (std::size_t h = 0; h < hooks.size(); ++h)
            if (bar.vertices(hooks[h].nodes[0], 1) == length)
                side += result.hook_forces_N[h].y();
        const double expected = 2.0 * (stretch - 1.0 / (stretch * stretch)) * (c10 + c01 / stretch);
        EXPECT_NEAR(force / area - side / area * across / stretch, expected, 1e-6 * expected);
    }

    TEST(Opening, NearEverythingIsTheWholeNonlinear)
    {
        const Wound wound = slit_box(3, 5.0);
        for (const Elasticity elasticity : { Elasticity::corotational, Elasticity::hyperelastic }) {
            OpeningOptions options { .elasticity = elasticity, .tolerance = 1e-8 };
            const OpeningResult whole = open(wound, 3.0, options);
            options.near.assign(wound.mesh.tet_count(), 1);
            const OpeningResult near = open(wound, 3.0, options);
            ASSERT_EQ(near.status, OpeningStatus::converged) << near.message;
            EXPECT_LE((near.displacement - whole.displacement).cwiseAbs().maxCoeff(), 1e-5);
            EXPECT_LE((near.hook_forces_N[0] - whole.hook_forces_N[0]).norm(), 1e-5 * whole.hook_forces_N[0].norm());
            EXPECT_NEAR(near.strain_p99, whole.strain_p99, 1e-5);
            EXPECT_NEAR(near.min_volume_ratio, whole.min_volume_ratio, 1e-5);
        }
    }

    TEST(Opening, ALinearCondensedRegionIsKeptOnlyWhereItIsGood)
    {
        const Wound wound = slit_box(3, 5.0);
        for (const Elasticity elasticity : { Elasticity::corotational, Elasticity::hyperelastic }) {
            OpeningOptions options { .elasticity = elasticity, .tolerance = 1e-7 };
            const OpeningResult whole = open(wound, 3.0, options);
            Points held(0, 3);
            for (const HookPatch& hook : two_hooks(wound, 3.0))
                for (const VertexId v : hook.nodes) {
                    held.conservativeResize(held.rows() + 1, 3);
                    held.row(held.rows() - 1) = wound.mesh.vertices.row(v);
                }
            options.near = elements_near(wound.mesh, held, 6.0);
            ASSERT_NE(std::count(options.near.begin(), options.near.end(), 0), 0);
            const auto off = [&](const OpeningResult& result) {
                return (result.hook_forces_N[0] - whole.hook_forces_N[0]).norm() / whole.hook_forces_N[0].norm();
            };
            options.far_tolerance = 1e9;
            const OpeningResult linear = open(wound, 3.0, options);
            ASSERT_TRUE(linear.far.has_value()) << linear.message;
            EXPECT_TRUE(linear.far->kept);
            const double told = linear.far->hook_force_changes_N[0].norm() / linear.hook_forces_N[0].norm(),
                         is = off(linear);
            EXPECT_GT(told, 0.5 * is);
            EXPECT_LT(told, 3.0 * is);
            for (const double share : { 0.01, 0.5 }) { // given up on the way, and at rest
                options.far_tolerance = share * linear.far->change;
                const OpeningResult given_up = open(wound, 3.0, options);
                ASSERT_EQ(given_up.status, OpeningStatus::converged) << given_up.message;
                ASSERT_TRUE(given_up.far.has_value());
                EXPECT_FALSE(given_up.far->kept);
                EXPECT_EQ(given_up.far->share < 1.0, share < 0.1);
                EXPECT_LT(off(given_up), 1e-5);
                EXPECT_LE((given_up.displacement - whole.displacement).cwiseAbs().maxCoeff(), 1e-4);
            }
        }
    }

    TEST(Opening, HyperelasticTissueIsNeverTurnedOver)
    {
        const Wound wound = slit_box(3, 5.0);
        const OpeningResult result = open(wound, 7.0, { .elasticity = Elasticity::hyperelastic });
        EXPECT_EQ(result.status, OpeningStatus::converged) << result.message;
        EXPECT_GT(result.min_volume_ratio, 0.0);
        EXPECT_EQ(result.inverted_elements, 0);
        EXPECT_TRUE(result.displacement.allFinite());
    }

    TEST(Opening, LockingFreeElementsDoNotLock)
    {
        // Softer than plain four-node ones, which lock, and near ten-node ones.
        const Wound wound = slit_box(3, 8.0);
        constexpr double kSkin = 0.499;
        const auto force = [&](const Wound& of, OpeningOptions options) {
            options.elasticity = Elasticity::hyperelastic;
            const OpeningResult result = open(of, 2.0, options, kSkin);
            EXPECT_EQ(result.status, OpeningStatus::converged) << result.message;
            return result.hook_forces_N[1].x();
        };
        const double plain = force(wound, {}), free = force(wound, { .locking_free = true }),
                     right = force(with_ten_nodes(wound), {});
        EXPECT_LT(std::abs(free - right), 0.5 * std::abs(plain - right)) << plain << " " << free << " " << right;
    }

    TEST(Opening, LoadStepsAndWarmStartDoNotChangeTheAnswer)
    {
        const Wound wound = slit_box(4, 5.0);
        constexpr double kTight = 1e-9;
        const OpeningOptions one { .load_steps = 1, .tolerance = kTight },
            many { .load_steps = 5, .tolerance = kTight };
        const OpeningResult direct = open(wound, 5.0, one), stepped = open(wound, 5.0, many);
        Opening opening(wound.mesh, tissue(), wound.supports, one);
        (void)opening.open(two_hooks(wound, 3.0));
        const OpeningResult warm = opening.open(two_hooks(wound, 5.0));
        for (const OpeningResult* r : { &direct, &stepped, &warm }) {
            ASSERT_EQ(r->status, OpeningStatus::converged) << r->message;
            EXPECT_LE((r->displacement - direct.displacement).cwiseAbs().maxCoeff(), 1e-6);
        }
    }

    TEST(Opening, AStartFromFourNodeElementsDoesNotChangeTheAnswer)
    {
        const Wound coarse = slit_box(3, 8.0), wound = with_ten_nodes(coarse);
        const OpeningOptions options { .tolerance = 1e-9 };
        const OpeningResult four = open(coarse, 5.0, options), ten = open(wound, 5.0, options);
        Points start = Points::Zero(wound.mesh.vertices.rows(), 3);
        start.topRows(four.displacement.rows()) = four.displacement;
        for (TetId t = 0; t < static_cast<TetId>(wound.mesh.tet_count()); ++t)
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e) {
                const auto nodes = wound.mesh.tet(t);
                const auto end = [&](std::size_t i) { return nodes[static_cast<std::size_t>(mesh::kTetEdges[e][i])]; };
                start.row(nodes[4 + e]) = 0.5 * (start.row(end(0)) + start.row(end(1)));
            }
        Opening opening(wound.mesh, tissue(), wound.supports, options);
        opening.start_from(start);
        const OpeningResult started = opening.open(two_hooks(wound, 5.0));
        ASSERT_EQ(ten.status, OpeningStatus::converged) << ten.message;
        ASSERT_EQ(started.status, OpeningStatus::converged) << started.message;
        EXPECT_LE((started.displacement - ten.displacement).cwiseAbs().maxCoeff(), 1e-6);
        EXPECT_LT(started.newton_iterations, ten.newton_iterations);
    }

    TEST(Opening, AStartThatIsNoDisplacementIsRefused)
    {
        const Wound wound = slit_box(3, 8.0);
        Opening opening(wound.mesh, tissue(), wound.supports);
        EXPECT_THROW(opening.start_from(Points::Zero(3, 3)), InputError);
        Points bad = Points::Zero(wound.mesh.vertices.rows(), 3);
        bad(0, 0) = std::numeric_limits<double>::quiet_NaN();
        EXPECT_THROW(opening.start_from(bad), InputError);
    }

    TEST(Opening, TurningThePatientTurnsTheAnswer)
    {
        const Wound wound = slit_box(3, 5.0);
        const Mat3 R = Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
        Wound turned = wound;
        turned.mesh.vertices = wound.mesh.vertices * R.transpose();
        std::vector<HookPatch> hooks = two_hooks(wound, 4.0);
        Opening straight(wound.mesh, tissue(), wound.supports), oblique(turned.mesh, tissue(), wound.supports);
        const OpeningResult a = straight.open(hooks);
        for (HookPatch& hook : hooks)
            hook.displacement = R * hook.displacement;
        const OpeningResult b = oblique.open(hooks);
        EXPECT_LE((a.displacement * R.transpose() - b.displacement).cwiseAbs().maxCoeff(), 1e-6);
        EXPECT_LE((R * a.hook_forces_N[0] - b.hook_forces_N[0]).norm(), 1e-6 * a.hook_forces_N[0].norm());
    }

    TEST(Opening, BoneBesideFat)
    {
        Wound wound = slit_box(6, 4.0);
        for (std::size_t t = 0; t < wound.mesh.tet_count(); ++t) {
            const Vec3 p = wound.mesh.vertices.row(wound.mesh.tet(static_cast<TetId>(t))[0]).transpose();
            if (std::abs(p.x() - 24.0) > 7.0 && std::abs(p.x() - 24.0) < 15.0 && p.z() > 7.0 && p.z() < 15.0
                && p.y() < 40.0)
                wound.mesh.labels[t] = 2;
        }
        const std::vector<Material> materials { {}, find_material(default_materials(), "fat"),
            find_material(default_materials(), "bone") };
        Opening opening(wound.mesh, materials, wound.supports);
        const OpeningResult result = opening.open(two_hooks(wound, 6.0));
        EXPECT_EQ(result.status, OpeningStatus::converged) << result.message;
        EXPECT_TRUE(result.displacement.allFinite());
        EXPECT_EQ(result.inverted_elements, 0);
    }

    /// A bar of bone through soft tissue, 60 mm long and held at one end, beside which the tissue is cut.
    OpeningResult swing_a_bar(double pull, OpeningOptions options)
    {
        const double spacing = 5.0;
        mesh::TetMesh mesh = mesh::kuhn_box(14, 8, 3, spacing); // x along the bar, the bar pulled along y
        HookPatch hook { "hook", 1, {}, { 0, pull, 0 } };
        Supports supports;
        std::vector<std::uint8_t> in_bar(mesh.vertex_count(), 0);
        for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
            Vec3 centre = Vec3::Zero();
            for (const VertexId v : mesh.tet(static_cast<TetId>(t)))
                centre += 0.25 * mesh.vertices.row(v).transpose();
            if (centre.x() > 5.0 && centre.x() < 65.0 && centre.y() > 10.0 && centre.y() < 15.0 && centre.z() > 5.0
                && centre.z() < 10.0) {
                mesh.labels[t] = 2;
                for (const VertexId v : mesh.tet(static_cast<TetId>(t)))
                    in_bar[static_cast<std::size_t>(v)] = 1;
            }
        }
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
            const auto p = mesh.vertices.row(v);
            if (p.x() == 0.0 || p.y() == 40.0) // the side behind the bar stays; the side before it is the open lip
                supports.fixed.push_back(static_cast<VertexId>(v));
            else if (in_bar[static_cast<std::size_t>(v)] != 0 && p.x() > 64.0)
                hook.nodes.push_back(static_cast<VertexId>(v));
        }
        Opening opening(mesh,
            std::vector<Material> { {}, test_support::material(0.02, 0.45), test_support::material(1000.0, 0.3) },
            supports, options);
        return opening.open(std::vector { hook });
    }

    TEST(Opening, ABarOfBoneSwingsWithoutInvertingTheTissueRoundIt)
    {
        const OpeningResult result = swing_a_bar(20.0, {});
        ASSERT_EQ(result.status, OpeningStatus::converged) << result.message;
        EXPECT_LE(result.residual, OpeningOptions {}.tolerance);
        EXPECT_EQ(result.inverted_elements, 0);
        EXPECT_GT(result.min_volume_ratio, 0.0);
        // Seven load steps of 3 mm, up to four iterations each on the way, and a quadratic end.
        constexpr int kBound = 7 * 4 + 12;
        EXPECT_LE(result.newton_iterations, kBound) << result.message;
        EXPECT_GT(result.hook_forces_N[0].y(), 0.0);
    }

    TEST(Opening, TheWorkIsBounded)
    {
        constexpr int kLast = 2;
        const OpeningResult result = swing_a_bar(20.0, { .max_newton_iterations = kLast, .tolerance = 1e-14 });
        EXPECT_EQ(result.status, OpeningStatus::not_converged);
        EXPECT_NE(result.message.find("100 %"), std::string::npos) << result.message;
        EXPECT_LE(result.newton_iterations, 7 * kLast);
    }

    // -- Outcomes that are statuses, and what is built when.

    TEST(Opening, AnAbsurdPullEndsInAStatusWithoutNaN)
    {
        const OpeningResult result = open(slit_box(3, 5.0), 200.0, { .load_steps = 2, .max_newton_iterations = 5 });
        EXPECT_TRUE(result.displacement.allFinite());
        EXPECT_TRUE(std::isfinite(result.residual));
        EXPECT_TRUE(std::isfinite(result.strain_p99));
        EXPECT_TRUE(result.status == OpeningStatus::not_converged || result.status == OpeningStatus::inverted
            || result.residual <= 1e-5);
        EXPECT_FALSE(result.message.empty());
    }

    TEST(Opening, ElementsInsideOutAreAStatusOfTheirOwn)
    {
        // Linear elasticity knows nothing of det F: it answers any pull, here with elements that are turned over.
        const OpeningResult turned = open(slit_box(3, 5.0), 200.0, { .elasticity = Elasticity::linear });
        EXPECT_EQ(turned.status, OpeningStatus::inverted);
        EXPECT_GT(turned.inverted_elements, 0);
        EXPECT_LE(turned.min_volume_ratio, 0.0);
        EXPECT_NE(turned.message.find("element(s) inside out"), std::string::npos) << turned.message;
        const OpeningResult sound = open(slit_box(3, 5.0), 1.0, { .elasticity = Elasticity::linear });
        EXPECT_EQ(sound.status, OpeningStatus::converged);
        EXPECT_EQ(sound.inverted_elements, 0);
        EXPECT_EQ(sound.message.find("inside out"), std::string::npos) << sound.message;
    }

    TEST(Opening, AStateInsideOutIsNoStartForTheNext)
    {
        const Wound wound = slit_box(3, 5.0);
        Opening used(wound.mesh, tissue(), wound.supports, { .elasticity = Elasticity::linear });
        ASSERT_EQ(used.open(two_hooks(wound, 200.0)).status, OpeningStatus::inverted);
        Opening fresh(wound.mesh, tissue(), wound.supports, { .elasticity = Elasticity::linear });
        EXPECT_EQ(used.open(two_hooks(wound, 1.0)).displacement, fresh.open(two_hooks(wound, 1.0)).displacement);
    }

    TEST(Opening, TooFewIterationsAreNotConverged)
    {
        const OpeningResult result
            = open(slit_box(3, 5.0), 5.0, { .load_steps = 1, .max_newton_iterations = 1, .tolerance = 1e-12 });
        EXPECT_EQ(result.status, OpeningStatus::not_converged);
        EXPECT_GT(result.residual, 1e-12);
        EXPECT_NE(result.message.find("not converged"), std::string::npos);
        EXPECT_NE(result.message.find("the largest force left is"), std::string::npos) << result.message;
        EXPECT_GT(result.displacement.cwiseAbs().maxCoeff(), 0.0);
    }

    TEST(Opening, CancelledIsAStatus)
    {
        const Wound wound = slit_box(3, 5.0);
        const std::atomic<bool> cancel = true;
        Opening opening(wound.mesh, tissue(), wound.supports);
        EXPECT_EQ(opening.open(two_hooks(wound, 5.0), { {}, &cancel, nullptr }).status, OpeningStatus::cancelled);
    }

    TEST(Opening, CancelledOnTheWayIsCancelledThoughWhatWasReachedIsAtRest)
    {
        const Wound wound = slit_box(3, 5.0);
        constexpr double kLoose = 0.5; // any state is at rest by it
        OpeningOptions options { .load_steps = 4, .tolerance = kLoose };
        options.near.assign(wound.mesh.tet_count(), 1);
        std::atomic<bool> cancel = false;
        const Job job { [&](std::string_view stage, double) { cancel = stage == "opening"; }, &cancel, nullptr };
        const OpeningResult result
            = Opening(wound.mesh, tissue(), wound.supports, options).open(two_hooks(wound, 3.0), job);
        EXPECT_EQ(result.status, OpeningStatus::cancelled) << result.message;
    }

    TEST(Opening, PartsAreBuiltWhenFirstNeededAndOnce)
    {
        const Wound wound = slit_box(3, 5.0);
        Ledger ledger;
        Opening opening(wound.mesh, tissue(), wound.supports);
        EXPECT_TRUE(ledger.parts().empty());
        (void)opening.open(two_hooks(wound, 1.0), { {}, nullptr, &ledger });
        for (const char* part : { "solver", "assembly", "factorisation" })
            EXPECT_TRUE(ledger.has(part)) << part;
        const auto count = ledger.parts().size();
        (void)opening.open(two_hooks(wound, 2.0), { {}, nullptr, &ledger });
        EXPECT_EQ(ledger.parts().size(), count);
    }

    // -- Bad input.

    template <class E, class F> std::string refusal(const F& f)
    {
        try {
            f();
        } catch (const E& error) {
            return error.where() + ": " + error.what();
        }
        return "accepted";
    }

    TEST(Opening, AFloatingPieceIsNamedWithItsSizeAndPlace)
    {
        Wound wound = slit_box(3, 5.0);
        const std::vector<HookPatch> hooks = two_hooks(wound, 1.0);
        const auto n = wound.mesh.vertices.rows();
        wound.mesh.vertices.conservativeResize(n + 4, Eigen::NoChange);
        wound.mesh.vertices.bottomRows(4) << 100, 0, 0, 106, 0, 0, 100, 1, 0, 100, 0, 1;
        for (int i = 0; i < 4; ++i)
            wound.mesh.nodes.push_back(static_cast<VertexId>(n + i));
        wound.mesh.labels.push_back(1);
        Opening opening(wound.mesh, tissue(), wound.supports);
        const std::string message = refusal<SolverError>([&] { (void)opening.open(hooks); });
        EXPECT_NE(message.find("piece 1 round (101.5, 0.25, 0.25) mm"), std::string::npos) << message;
        EXPECT_NE(message.find("1 element(s), 1 mm^3"), std::string::npos) << message;
    }

    TEST(HeldPieces, ThreeNodesOnALineDoNotHold)
    {
        const mesh::TetMesh box = mesh::kuhn_box(2, 2, 2, 1.0);
        const auto missing = [&](const std::vector<VertexId>& held) {
            return refusal<SolverError>([&] { check_no_floating_component(box, held); });
        };
        const auto has = [](const std::string& message, const std::string& words) {
            return message.find(words) != std::string::npos;
        };
        EXPECT_PRED2(has, missing({}), "has neither a support nor a hook");
        EXPECT_PRED2(has, missing({ 4 }), "is held at one vertex alone");
        EXPECT_PRED2(has, missing({ 0, 1, 2 }), "is held at 3 vertices on one line alone");
        EXPECT_PRED2(has, missing({ 0, 5 }), "is held at 2 vertices on one line alone");
        EXPECT_NO_THROW(check_no_floating_component(box, std::vector<VertexId> { 0, 1, 3 }));
    }

    TEST(Opening, ConflictingHooksAreRefused)
    {
        const Wound wound = slit_box(3, 5.0);
        Opening opening(wound.mesh, tissue(), wound.supports);
        std::vector<HookPatch> hooks = two_hooks(wound, 2.0);
        hooks[1].nodes.push_back(hooks[0].nodes[0]);
        const std::string message = refusal<InputError>([&] { (void)opening.open(hooks); });
        EXPECT_NE(message.find("hook 'right': node"), std::string::npos) << message;
        EXPECT_NE(message.find("already held by hook 'left'"), std::string::npos) << message;
        hooks = two_hooks(wound, 2.0);
        hooks[0].nodes.push_back(wound.supports.fixed[0]);
        EXPECT_NE(refusal<InputError>([&] { (void)opening.open(hooks); }).find("a support"), std::string::npos);
    }

    TEST(Opening, BadHooksAreRefusedByName)
    {
        const Wound wound = slit_box(3, 5.0);
        Opening opening(wound.mesh, tissue(), wound.supports);
        const auto with = [&](auto change) {
            std::vector<HookPatch> hooks = two_hooks(wound, 2.0);
            change(hooks[1]);
            return refusal<InputError>([&] { (void)opening.open(hooks); });
        };
        EXPECT_NE(with([](HookPatch& h) { h.nodes.clear(); }).find("hook 'right': the hook's patch has no nodes"),
            std::string::npos);
        EXPECT_NE(with([](HookPatch& h) { h.nodes.push_back(-1); }).find("out of range"), std::string::npos);
        EXPECT_NE(with([](HookPatch& h) {
            h.displacement.x() = std::numeric_limits<double>::quiet_NaN();
        }).find("not finite"),
            std::string::npos);
    }

    TEST(Opening, BadMaterialsSupportsAndOptionsAreRefused)
    {
        const Wound wound = slit_box(2, 5.0);
        const auto refuse = [&](std::vector<Material> materials, Supports supports, OpeningOptions options) {
            return refusal<InputError>([&] { Opening opening(wound.mesh, materials, std::move(supports), options); });
        };
        constexpr double nan = std::numeric_limits<double>::quiet_NaN();
        EXPECT_NE(refuse(tissue(0.5), {}, {}).find("Poisson's ratio"), std::string::npos);
        EXPECT_NE(refuse({ {}, test_support::material(-1.0, 0.3) }, {}, {}).find("Young's modulus"), std::string::npos);
        EXPECT_NE(refuse({ {}, test_support::material(nan, 0.3) }, {}, {}).find("Young's modulus"), std::string::npos);
        EXPECT_NE(refuse({ {} }, {}, {}).find("label 1 has no material"), std::string::npos);
        EXPECT_NE(
            refuse(tissue(), { { 100000 } }, {}).find("supports: node 100000 is out of range"), std::string::npos);
        EXPECT_NE(refuse(tissue(), {}, { .load_steps = 0 }).find("load step"), std::string::npos);
        EXPECT_NE(refuse(tissue(), {}, { .tolerance = nan }).find("tolerance"), std::string::npos);
        const std::vector<std::uint8_t> near(wound.mesh.tet_count(), 1);
        EXPECT_NE(refuse(tissue(), {}, { .elasticity = Elasticity::linear, .near = near }).find("nothing is nonlinear"),
            std::string::npos);
        EXPECT_NE(refuse(tissue(), {}, { .near = near, .far_tolerance = -1.0 }).find("is not zero or more"),
            std::string::npos);
        EXPECT_NE(refuse(tissue(), {}, { .locking_free = true, .near = near }).find("with locking-free"),
            std::string::npos);
        EXPECT_NE(refuse(tissue(), {}, { .near = near, .contact = ContactOptions {} }).find("with contact"),
            std::string::npos);
    }

    TEST(Opening, HooksOnFacingLipsDoNotPassThroughEachOther)
    {
        const verification::IncisedBlock block;
        const ElasticProblem problem = verification::hooked_open(block,
            verification::incise(verification::uncut_block(block), verification::incision_blade(block)),
            test_support::material(0.04, 0.45), Vec3(0.0, -2.0, 0.0));
        const std::string said = test_support::message_of([&] {
            Opening opening(problem.mesh, problem.material_of_label, problem.supports);
            (void)opening.open(problem.hooks);
        });
        EXPECT_NE(said.find("'right' and 'left' would pass through each other by 4.0"), std::string::npos) << said;
        std::vector<HookPatch> together = problem.hooks; // both the same way: they stay where they are to each other
        together[0].displacement = together[1].displacement = Vec3(0.0, -2.0, 0.0);
        EXPECT_NO_THROW(check_hooks_apart(problem.mesh, together));
        together[1].displacement.y() = -1.0; // the one that is ahead moves less
        EXPECT_NO_THROW(check_hooks_apart(problem.mesh, together));
        together[1].displacement.y() = -3.0;
        EXPECT_THROW(check_hooks_apart(problem.mesh, together), InputError);
    }

    TEST(Opening, SaysWhenElementsAreInsideOut)
    {
        const verification::IncisedBlock block;
        const ElasticProblem problem = verification::hooked_open(block,
            verification::incise(verification::uncut_block(block), verification::incision_blade(block)),
            test_support::material(0.04, 0.45), Vec3(0.0, 100.0, 0.0));
        Opening opening(
            problem.mesh, problem.material_of_label, problem.supports, { .elasticity = Elasticity::linear });
        const OpeningResult result = opening.open(problem.hooks);
        EXPECT_GT(result.inverted_elements, 0);
        EXPECT_NE(
            result.message.find(std::to_string(result.inverted_elements) + " element(s) inside out"), std::string::npos)
            << result.message;
    }

} // namespace opening_test
} // namespace retractor::fem
