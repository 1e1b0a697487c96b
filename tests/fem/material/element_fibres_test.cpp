#include "fem/material/element_fibres.h"

#include "fem/statics/elastic_problem.h"
#include "mesh/base/error.h"
#include "mesh/cutting/cut_session.h"
#include "tests/support/random_strokes.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <random>
#include <string>

namespace retractor::fem {
namespace element_fibres_test {

    using namespace test_support;

    constexpr double kRoundOff = 1e-14;

    TissueLaw winding(const FibresAround& around)
    {
        return { .law = HolzapfelGasserOgden { .mu = 0.01, .k1 = 0.02, .k2 = 1.0 }, .around = around };
    }

    Vec3 middle_of(const mesh::TetMesh& mesh, TetId t)
    {
        Vec3 middle = Vec3::Zero();
        for (const VertexId v : mesh.tet(t).first(4))
            middle += 0.25 * mesh.vertices.row(v).transpose();
        return middle;
    }

    TEST(ElementFibres, WindRoundTheAxisAtTheirAngle)
    {
        const FibresAround around { .point = Vec3(40.0, -30.0, 7.0), .axis = Vec3(0.2, -0.4, 3.0), .angle_deg = 30.0 };
        const Vec3 along = around.axis.normalized();
        const mesh::TetMesh box = mesh::kuhn_box(3, 2, 2, 5.0);
        for (const mesh::TetMesh& mesh : { box, mesh::with_midpoints(box) })
            for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
                const FibreDirections f = element_fibres(mesh, t, winding(around));
                const Vec3 arm = middle_of(mesh, t) - around.point, out = (arm - along * along.dot(arm)).normalized();
                for (const Vec3& fibre : { f.first, f.second }) {
                    EXPECT_NEAR(fibre.norm(), 1.0, kRoundOff);
                    EXPECT_NEAR(fibre.dot(out), 0.0, kRoundOff);
                }
                EXPECT_NEAR(f.first.dot(along), 0.5, kRoundOff); // sin 30
                EXPECT_NEAR(f.second.dot(along), -0.5, kRoundOff);
                EXPECT_NEAR(f.first.dot(f.second), 0.5, kRoundOff); // 60 degrees between them
            }
    }

    /// A plan's path: by label, at rest, whatever part of the mesh is asked for.
    TEST(ElementFibres, AreThoseOfABodyMadeByItsMaterials)
    {
        const FibresAround around { .point = Vec3(-20.0, 5.0, 0.0), .axis = Vec3::UnitZ() };
        mesh::TetMesh mesh = mesh::kuhn_box(2, 2, 1, 5.0);
        for (std::size_t t = 0; t < mesh.tet_count(); t += 2)
            mesh.labels[t] = 2;
        std::vector<Material> materials { {}, test_support::material(0.05, 0.4), test_support::material(0.05, 0.4) };
        materials[2].law = winding(around);
        const HyperelasticTissue tissue = hyperelastic_tissue(mesh, materials);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            const Vec3 arm = middle_of(mesh, t) - around.point;
            const Vec3 expected = t % 2 == 0 ? Vec3(-arm.y(), arm.x(), 0.0).normalized() : Vec3(Vec3::UnitX());
            EXPECT_LT((tissue.fibres[static_cast<std::size_t>(t)].first - expected).norm(), kRoundOff);
        }
    }

    TEST(ElementFibres, TurnWithThePatient)
    {
        const FibresAround around { .point = Vec3(-20.0, 5.0, 1.0), .axis = Vec3(1.0, 2.0, 3.0), .angle_deg = 40.0 };
        const mesh::TetMesh mesh = mesh::kuhn_box(2, 1, 1, 5.0);
        Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
        X.rotate(Eigen::AngleAxisd(0.7, Vec3(1.0, -1.0, 0.5).normalized())).translate(Vec3(10.0, -3.0, 44.0));
        mesh::TetMesh there = mesh;
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
            there.vertices.row(v) = (X * mesh.vertices.row(v).transpose()).transpose();
        const FibresAround turned { X * around.point, X.linear() * around.axis, around.angle_deg };
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            EXPECT_LT((X.linear() * element_fibres(mesh, t, winding(around)).second
                          - element_fibres(there, t, winding(turned)).second)
                          .norm(),
                100.0 * kRoundOff);
    }

    TEST(ElementFibres, GiveForcesAndStiffnessThatAreDerivatives)
    {
        const mesh::TetMesh box = verification::distorted_box(3, 5.0, 0.2, 5);
        std::vector<Material> materials { {}, test_support::material(0.05, 0.45) };
        materials[1].law = winding({ .point = Vec3(-4.0, -3.0, 0.0), .axis = Vec3(0.1, 0.2, 1.0), .angle_deg = 35.0 });
        struct Solved {
            bool ten_nodes, locking_free;
        };
        for (const auto [ten_nodes, locking_free] :
            { Solved { false, false }, Solved { false, true }, Solved { true, false } }) {
            const mesh::TetMesh mesh = ten_nodes ? mesh::with_midpoints(box) : box;
            ElasticBody body = tissue_body(mesh, materials, { Elasticity::hyperelastic, locking_free });
            std::mt19937 random(4);
            std::uniform_real_distribution<double> entry(-1.0, 1.0);
            const auto size = 3 * mesh.vertices.rows();
            const Eigen::VectorXd u = Eigen::VectorXd::NullaryExpr(size, [&] { return 0.25 * entry(random); });
            const Eigen::VectorXd d = Eigen::VectorXd::NullaryExpr(size, [&] { return 5.0 * entry(random); });
            constexpr double h = 1e-6; // truncation h^2 meets round-off eps / h
            constexpr double kTol = 2e-6; // relative
            const auto plus = body.response(u + h * d), minus = body.response(u - h * d);
            const double slope = body.response(u).forces.dot(d);
            EXPECT_NEAR((plus.energy - minus.energy) / (2 * h), slope, kTol * std::abs(slope));
            const Eigen::VectorXd Kd = body.stiffness(u, 0.0).multiply(d);
            EXPECT_LE((Kd - (plus.forces - minus.forces) / (2 * h)).norm(), kTol * Kd.norm());
        }
    }

    /// Nothing of them is kept from before the cut: they are a function of the mesh.
    TEST(ElementFibres, OfACutMeshAreThoseAtItsOwnElements)
    {
        constexpr double kEdge = 5.0; // mm
        const Vec3 size(4 * kEdge, 4 * kEdge, 3 * kEdge);
        const mesh::TetMesh box = mesh::kuhn_box(4, 4, 3, kEdge);
        const FibresAround around { .point = Vec3(-40.0, 10.0, 0.0), .axis = Vec3::UnitZ(), .angle_deg = 20.0 };
        // Across an element, whose longest edge is the cube's diagonal, the circumference turns by less than this.
        const double turn = std::sqrt(3.0) * kEdge / 40.0;
        mesh::CutSession session(box);
        std::mt19937 random(2);
        std::size_t whole = 0, pieces = 0;
        for (int i = 0; i < 6; ++i) {
            test_support::random_change(session, random, size, [](const mesh::MeshDelta&) {});
            mesh::SlotMap slots;
            const mesh::TetMesh cut = session.compact_mesh(&slots);
            for (TetId t = 0; t < static_cast<TetId>(cut.tet_count()); ++t) {
                const TetId of = session.origin(slots.tet_slot[static_cast<std::size_t>(t)]);
                const FibreDirections now = element_fibres(cut, t, winding(around)),
                                      before = element_fibres(box, of, winding(around));
                const bool moved = (middle_of(cut, t) - middle_of(box, of)).norm() > 0.0;
                ++(moved ? pieces : whole);
                if (moved)
                    EXPECT_LT((now.first - before.first).norm(), turn);
                else
                    EXPECT_EQ(now.first, before.first);
            }
        }
        EXPECT_GT(whole, 100U);
        EXPECT_GT(pieces, 100U);
        while (session.can_undo())
            (void)session.undo();
        const mesh::TetMesh again = session.compact_mesh();
        for (TetId t = 0; t < static_cast<TetId>(again.tet_count()); ++t)
            EXPECT_EQ(element_fibres(again, t, winding(around)).second, element_fibres(box, t, winding(around)).second);
    }

    TEST(ElementFibres, AreSaidInWords)
    {
        Material m = test_support::material(0.05, 0.4);
        EXPECT_EQ(law_in_words(m), "neo-Hookean");
        m.law = TissueLaw { HolzapfelGasserOgden {} };
        EXPECT_EQ(law_in_words(m), "Holzapfel-Gasser-Ogden");
        m.law->around = FibresAround { .angle_deg = 37.5 };
        EXPECT_EQ(
            law_in_words(m), "Holzapfel-Gasser-Ogden with fibres at 37.5 degrees to the circumference round an axis");
    }

    TEST(ElementFibres, RefuseAnElementThatTheAxisRunsThrough)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(2, 1, 1, 10.0);
        std::vector<Material> materials { {}, test_support::material(0.05, 0.4) };
        materials[1].law = winding({ .point = Vec3(14.0, 3.0, -50.0), .axis = Vec3::UnitZ() });
        const std::string said = test_support::message_of([&] { (void)hyperelastic_tissue(mesh, materials); });
        EXPECT_NE(said.find("the axis that this material's fibres turn round runs through it"), std::string::npos)
            << said;
        EXPECT_NE(said.find(") mm"), std::string::npos) << said; // where
        EXPECT_EQ(said.find("material 'test', element "), 0U) << said;
        // Through a corner, along an edge, through the middle, just beside.
        const auto refused = [&](const Vec3& point, const Vec3& axis) {
            materials[1].law = winding({ .point = point, .axis = axis });
            return !test_support::message_of([&] { (void)hyperelastic_tissue(mesh, materials); }).empty();
        };
        EXPECT_TRUE(refused(Vec3(0.0, 0.0, 3.0), Vec3(1.0, -1.0, 0.0)));
        EXPECT_TRUE(refused(Vec3(20.0, 10.0, -7.0), Vec3::UnitZ()));
        EXPECT_TRUE(refused(middle_of(mesh, 5), Vec3(1e-200, 2e-200, -3e-200)));
        EXPECT_TRUE(refused(middle_of(mesh, 5), Vec3(1e200, 2e200, -3e200)));
        constexpr double kBeside = 1e-6; // mm
        EXPECT_FALSE(refused(Vec3(20.0 + kBeside, 10.0, -7.0), Vec3::UnitZ()));
        EXPECT_FALSE(refused(Vec3(5.0, 5.0, 10.0 + kBeside), Vec3(3.0, 1.0, 0.0)));
    }

    TEST(ElementFibres, RefuseWhatIsNoDirection)
    {
        const auto said = [](const FibresAround& around) {
            Material m = test_support::material(0.05, 0.4);
            m.law = winding(around);
            return test_support::message_of([&] { check_material(m); });
        };
        constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
        EXPECT_EQ(said({ .axis = Vec3::Zero() }), "material 'test': the axis that fibres turn round must not be zero");
        EXPECT_EQ(said({ .axis = Vec3(0.0, kNan, 1.0) }),
            "material 'test': the point and the axis that fibres turn round must be finite");
        EXPECT_EQ(said({ .point = Vec3(kNan, 0.0, 0.0) }),
            "material 'test': the point and the axis that fibres turn round must be finite");
        for (const double angle : { -1.0, 91.0, kNan })
            EXPECT_EQ(said({ .angle_deg = angle }),
                "material 'test': the fibres' angle to the circumference must be between 0 and 90 degrees");
    }

} // namespace element_fibres_test
} // namespace retractor::fem
