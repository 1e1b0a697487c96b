#include "fem/model/pre_strain.h"

#include "fem/model/elastic_body.h"
#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <limits>

namespace retractor::fem {
namespace pre_strain_test {

    using test_support::material;
    using test_support::message_of;

    constexpr double kModulus = 0.2, kRatio = 0.3, kStrain = 0.04;
    constexpr double kRoundOff = 1e-13;

    PreStrain tension(PreStrainKind kind) { return { kind, kStrain, Vec3::UnitY(), Vec3::UnitZ() }; }

    std::vector<Mat3> everywhere(const mesh::TetMesh& mesh, const Mat3& stress)
    {
        return std::vector<Mat3>(mesh.tet_count(), stress);
    }

    /// Internal nodal forces of the stresses at rest: the integral of B^T sigma0.
    Eigen::VectorXd pre_stress_forces(const mesh::TetMesh& mesh, const std::vector<Mat3>& stresses)
    {
        Eigen::VectorXd forces = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        NodeGradients rest(mesh.nodes_per_tet, 3);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            const auto nodes = mesh.tet(t);
            for (std::size_t a = 0; a < nodes.size(); ++a)
                rest.row(static_cast<Eigen::Index>(a)) = mesh.vertices.row(nodes[a]);
            for (const QuadraturePoint& point : quadrature(mesh.nodes_per_tet)) {
                const ShapeGradients shape = shape_gradients(rest, point);
                for (std::size_t a = 0; a < nodes.size(); ++a)
                    forces.segment<3>(3 * static_cast<Eigen::Index>(nodes[a])) += shape.volume
                        * (stresses[static_cast<std::size_t>(t)]
                            * shape.gradients.row(static_cast<Eigen::Index>(a)).transpose());
            }
        }
        return forces;
    }

    TEST(PreStrain, IsHookesLawOfThePlane)
    {
        const Material m = test_support::material(kModulus, kRatio);
        const double s = kModulus * kStrain;
        const Mat3 uniaxial = pre_stress(tension(PreStrainKind::uniaxial_stress), m);
        EXPECT_NEAR(uniaxial(1, 1), s, kRoundOff);
        EXPECT_NEAR(uniaxial.trace(), s, kRoundOff);
        const Mat3 held = pre_stress(tension(PreStrainKind::held_width), m);
        EXPECT_NEAR(held(1, 1), s / (1.0 - kRatio * kRatio), kRoundOff);
        EXPECT_NEAR(held(0, 0), kRatio * s / (1.0 - kRatio * kRatio), kRoundOff);
        EXPECT_NEAR(held(2, 2), 0.0, kRoundOff);
        const Mat3 both = pre_stress(tension(PreStrainKind::equibiaxial), m);
        EXPECT_NEAR(both(0, 0), s / (1.0 - kRatio), kRoundOff);
        EXPECT_NEAR(both(2, 2), 0.0, kRoundOff);
        EXPECT_NEAR(pre_stress(tension(PreStrainKind::isotropic), m)(2, 2), s / (1.0 - 2.0 * kRatio), kRoundOff);
        EXPECT_TRUE(pre_stress({}, m).isZero(0.0));
    }

    TEST(PreStrain, TwoStrainsThatDifferAreHookesLawOfThePlaneToo)
    {
        const Material m = test_support::material(kModulus, kRatio);
        constexpr double kAcross = 0.015;
        PreStrain unequal = tension(PreStrainKind::biaxial);
        unequal.across = kAcross;
        const double stiffness = kModulus / (1.0 - kRatio * kRatio);
        const Mat3 stress = pre_stress(unequal, m);
        EXPECT_NEAR(stress(1, 1), stiffness * (kStrain + kRatio * kAcross), kRoundOff);
        EXPECT_NEAR(stress(0, 0), stiffness * (kAcross + kRatio * kStrain), kRoundOff);
        EXPECT_NEAR(stress(2, 2), 0.0, kRoundOff);
        EXPECT_NEAR(stress(0, 1), 0.0, kRoundOff);
        // The same tissue told the other way round.
        const PreStrain turned { PreStrainKind::biaxial, kAcross, Vec3::UnitX(), Vec3::UnitZ(), kStrain };
        EXPECT_LT((pre_stress(turned, m) - stress).norm(), kRoundOff);
        unequal.across = 0.0;
        EXPECT_LT((pre_stress(unequal, m) - pre_stress(tension(PreStrainKind::held_width), m)).norm(), kRoundOff);
        unequal.across = kStrain; // needs no pull then
        unequal.pull.setZero();
        EXPECT_LT((pre_stress(unequal, m) - pre_stress(tension(PreStrainKind::equibiaxial), m)).norm(), kRoundOff);
    }

    TEST(PreStrain, TakesNoNormalsFromWhereTheBodyWasCutOff)
    {
        const mesh::TetMesh mesh = mesh::kuhn_box(4, 4, 2, 1.0, 1);
        std::vector<VertexId> held;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (mesh.vertices(v, 0) == 0.0 || mesh.vertices(v, 0) == 4.0 || mesh.vertices(v, 1) == 0.0
                || mesh.vertices(v, 1) == 4.0 || mesh.vertices(v, 2) == 0.0)
                held.push_back(v);
        const std::vector<Label> skin { 1 };
        for (const Vec3& normal : surface_normals(mesh, skin, held))
            EXPECT_NEAR(normal.z(), 1.0, 1e-9);
    }

    TEST(PreStrain, PullsInThePlaneOfTheTissue)
    {
        PreStrain slanted = tension(PreStrainKind::uniaxial_stress);
        slanted.pull = Vec3(0.0, 1.0, 5.0);
        EXPECT_NEAR(pre_stress(slanted, test_support::material(kModulus, kRatio))(2, 2), 0.0, kRoundOff);
    }

    TEST(PreStrain, FindsTheNormalOfASkinOverOtherTissue)
    {
        mesh::TetMesh mesh = mesh::kuhn_box(8, 8, 3, 1.0, 1);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            double height = 0.0;
            for (const VertexId v : mesh.tet(t))
                height += 0.25 * mesh.vertices(v, 2);
            mesh.labels[static_cast<std::size_t>(t)] = height > 2.0 ? 2 : 1;
        }
        const std::vector<Vec3> normals = surface_normals(mesh);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            const Vec3 centre = 0.25
                * (mesh.vertices.row(mesh.tet(t)[0]) + mesh.vertices.row(mesh.tet(t)[1])
                    + mesh.vertices.row(mesh.tet(t)[2]) + mesh.vertices.row(mesh.tet(t)[3]))
                      .transpose();
            const bool away_from_sides
                = (centre.head<2>().array() > 2.0).all() && (centre.head<2>().array() < 6.0).all();
            if (mesh.labels[static_cast<std::size_t>(t)] == 2 && away_from_sides) {
                EXPECT_NEAR(normals[static_cast<std::size_t>(t)].z(), 1.0, 1e-9) << t;
            }
        }
    }

    /// The nodal forces are the derivative of the stress's work, and a uniform stress has none inside.
    TEST(PreStrain, ForcesBalanceInsideAndDoTheStressesWork)
    {
        Mat3 stress;
        stress << 0.03, 0.01, -0.02, 0.01, 0.05, 0.004, -0.02, 0.004, -0.01;
        Mat3 gradient;
        gradient << 0.1, 0.2, -0.3, 0.05, -0.1, 0.2, 0.3, 0.1, 0.2;
        for (const bool quadratic : { false, true }) {
            mesh::TetMesh mesh = verification::distorted_box(3, 2.0, 0.25, 7);
            if (quadratic)
                mesh = mesh::with_midpoints(mesh);
            const Eigen::VectorXd f = pre_stress_forces(mesh, everywhere(mesh, stress));
            const auto rim = test_support::boundary_unknowns(mesh);
            const double largest = f.lpNorm<Eigen::Infinity>();
            for (std::size_t i = 0; i < rim.size(); ++i)
                if (rim[i] == 0) {
                    EXPECT_NEAR(f[static_cast<Eigen::Index>(i)], 0.0, kRoundOff * 100.0 * largest);
                }
            const Eigen::VectorXd u
                = verification::nodal_values(mesh, [&](const Vec3& x) { return Vec3(gradient * x); });
            constexpr double kVolume = 216.0;
            EXPECT_NEAR(f.dot(u), kVolume * stress.cwiseProduct(gradient).sum(), 1e-10);
        }
    }

    /// All faces let go: the load is minus the internal force of the stress.
    TEST(PreStrain, ReleaseOfTheWholeSurfaceIsTheWholeForce)
    {
        const Mat3 stress = pre_stress(tension(PreStrainKind::equibiaxial), test_support::material(kModulus, kRatio));
        for (const bool quadratic : { false, true }) {
            const mesh::TetMesh linear = verification::distorted_box(3, 2.0, 0.25, 3);
            const mesh::TetMesh mesh = quadratic ? mesh::with_midpoints(linear) : linear;
            const Eigen::VectorXd f = pre_stress_forces(mesh, everywhere(mesh, stress));
            const Eigen::VectorXd r
                = traction_loads(mesh, released_tractions(mesh, mesh::boundary_faces(mesh), everywhere(mesh, stress)));
            EXPECT_LT((f + r).lpNorm<Eigen::Infinity>(), 1e-12);
            EXPECT_GT(f.lpNorm<Eigen::Infinity>(), 1e-3);
        }
    }

    /// A body under uniform stress whose boundary is held does not move.
    TEST(PreStrain, HeldBoundaryKeepsTheUncutBodyStill)
    {
        const mesh::TetMesh mesh = verification::distorted_box(4, 2.0, 0.25, 11);
        ElasticBody body(
            mesh, Elasticity::linear, test_support::uniform(mesh, test_support::material(kModulus, kRatio)));
        const Mat3 stress
            = pre_stress(tension(PreStrainKind::uniaxial_stress), test_support::material(kModulus, kRatio));
        const Eigen::VectorXd u = test_support::solve_linear(body, test_support::boundary_unknowns(mesh),
            Eigen::VectorXd::Zero(3 * mesh.vertices.rows()), -pre_stress_forces(mesh, everywhere(mesh, stress)));
        EXPECT_LT(u.lpNorm<Eigen::Infinity>(), 1e-13);
    }

    TEST(PreStrain, RefusesWhatIsNoTension)
    {
        const Material m = test_support::material(kModulus, kRatio);
        for (const double bad : { -0.01, 0.51, std::numeric_limits<double>::quiet_NaN() }) {
            PreStrain t = tension(PreStrainKind::uniaxial_stress);
            t.strain = bad;
            EXPECT_NE(
                test_support::message_of([&] { pre_stress(t, m); }).find("must lie between 0 and"), std::string::npos)
                << bad;
        }
        for (const double bad : { -0.01, 0.51, std::numeric_limits<double>::quiet_NaN() }) {
            PreStrain t = tension(PreStrainKind::biaxial);
            t.across = bad;
            EXPECT_NE(test_support::message_of([&] { check_pre_strain(t); }).find("across: "), std::string::npos)
                << bad;
            EXPECT_NE(test_support::message_of([&] { pre_stress(t, m); }).find("pre-strain, across"), std::string::npos)
                << bad;
        }
        PreStrain unequal = tension(PreStrainKind::biaxial);
        unequal.pull.setZero();
        EXPECT_NE(test_support::message_of([&] { check_pre_strain(unequal); }).find("direction: "), std::string::npos);
        unequal.pull.x() = std::numeric_limits<double>::infinity();
        EXPECT_NE(test_support::message_of([&] { check_pre_strain(unequal); }).find("direction: "), std::string::npos);
        PreStrain none = tension(PreStrainKind::uniaxial_stress);
        none.pull.setZero();
        EXPECT_NE(test_support::message_of([&] { pre_stress(none, m); }).find("the pull"), std::string::npos);
        PreStrain along = tension(PreStrainKind::uniaxial_stress);
        along.pull = Vec3::UnitZ();
        EXPECT_NE(test_support::message_of([&] { pre_stress(along, m); }).find("along the normal"), std::string::npos);
        PreStrain flat = tension(PreStrainKind::equibiaxial);
        flat.normal.setZero();
        EXPECT_NE(test_support::message_of([&] { pre_stress(flat, m); }).find("the normal"), std::string::npos);
        const mesh::TetMesh mesh = mesh::kuhn_box(1, 1, 1, 1.0, 3);
        EXPECT_NE(test_support::message_of([&] {
            traction_loads(mesh, released_tractions(mesh, mesh::boundary_faces(mesh), {}));
        }).find("one pre-stress per element"),
            std::string::npos);
        const std::vector<mesh::TetFace> beyond { { 99, 0 } };
        EXPECT_NE(test_support::message_of([&] {
            traction_loads(mesh, released_tractions(mesh, beyond, everywhere(mesh, Mat3::Zero())));
        }).find("element 99"),
            std::string::npos);
    }

} // namespace pre_strain_test
} // namespace retractor::fem
