#include "fem/springs/edge_springs.h"

#include "fem/model/pre_strain.h"
#include "fem/springs/spring_relaxation.h"
#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"
#include "tests/verification/framework/element_stress.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <random>

namespace retractor::fem {
namespace edge_springs_test {

    using test_support::material;
    using test_support::message_of;

    constexpr double kModulus = 0.2;

    std::array<Vec3, 4> regular_tet(double edge)
    {
        const double h = edge / std::sqrt(2.0);
        return { Vec3(0, 0, 0), Vec3(h, h, 0), Vec3(h, 0, h), Vec3(0, h, h) };
    }

    /// The stress-strain tensor of springs, applied to a strain: sum k L^2 (d.e.d) d d^T / V.
    Mat3 stress_of(const std::array<Vec3, 4>& x, const ElementSprings& s, const Mat3& strain)
    {
        Mat3 sum = Mat3::Zero();
        for (std::size_t e = 0; e < 6; ++e) {
            const Vec3 edge = x[static_cast<std::size_t>(mesh::kTetEdges[e][1])]
                - x[static_cast<std::size_t>(mesh::kTetEdges[e][0])];
            const Vec3 d = edge.normalized();
            sum += s.stiffness[e] * edge.squaredNorm() * d.dot(strain * d) * d * d.transpose();
        }
        return sum / std::abs(mesh::tet_volume(x[0], x[1], x[2], x[3]));
    }

    TEST(ElementSprings, HaveLloydsStiffnessInARegularTetrahedron)
    {
        std::array<Vec3, 4> x = regular_tet(3.0);
        if (mesh::tet_volume(x[0], x[1], x[2], x[3]) < 0.0)
            std::swap(x[2], x[3]);
        const ElementSprings s = element_springs(x, kModulus, Mat3::Zero());
        for (const double k : s.stiffness)
            EXPECT_NEAR(k, 2.0 * std::sqrt(2.0) / 25.0 * kModulus * 3.0, 1e-14);
        for (const double q : s.force_density)
            EXPECT_EQ(q, 0.0);
    }

    /// Averaged over all orientations of regular tetrahedra the tensor is isotropic with lambda = mu; Lloyd's springs
    /// have 0.96 of 2 E / 5.
    TEST(ElementSprings, AreIsotropicOnTheAverage)
    {
        std::mt19937 random(5);
        std::normal_distribution<double> normal;
        Mat3 strain = Mat3::Zero();
        strain(0, 0) = 1.0;
        Mat3 mean = Mat3::Zero();
        constexpr int kTurns = 20000;
        for (int i = 0; i < kTurns; ++i) {
            const Eigen::Quaterniond turn
                = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
            std::array<Vec3, 4> x = regular_tet(1.0);
            if (mesh::tet_volume(x[0], x[1], x[2], x[3]) < 0.0)
                std::swap(x[2], x[3]);
            for (Vec3& corner : x)
                corner = turn * corner;
            mean += stress_of(x, element_springs(x, 1.0, Mat3::Zero()), strain) / kTurns;
        }
        constexpr double kSampling = 0.01;
        EXPECT_NEAR(mean(0, 0), 0.96 * 1.2, kSampling);
        EXPECT_NEAR(mean(1, 1), 0.96 * 0.4, kSampling);
        EXPECT_NEAR(mean(2, 2), 0.96 * 0.4, kSampling);
    }

    TEST(ElementSprings, CarryAnyStressExactly)
    {
        std::mt19937 random(1);
        std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
        int tried = 0;
        while (tried < 50) {
            std::array<Vec3, 4> x;
            for (Vec3& corner : x)
                corner = Vec3(coordinate(random), coordinate(random), coordinate(random));
            if (mesh::tet_volume(x[0], x[1], x[2], x[3]) < 0.05)
                continue;
            ++tried;
            Mat3 stress = Mat3::NullaryExpr([&] { return coordinate(random); });
            stress = (stress + stress.transpose()).eval();
            const ElementSprings s = element_springs(x, 1.0, stress);
            Mat3 virial = Mat3::Zero();
            for (std::size_t e = 0; e < 6; ++e) {
                const Vec3 edge = x[static_cast<std::size_t>(mesh::kTetEdges[e][1])]
                    - x[static_cast<std::size_t>(mesh::kTetEdges[e][0])];
                virial += s.force_density[e] * edge * edge.transpose();
                EXPECT_GE(s.stiffness[e], 0.0);
            }
            EXPECT_LT((virial / mesh::tet_volume(x[0], x[1], x[2], x[3]) - stress).norm(), 1e-12);
        }
    }

    struct Sample {
        mesh::TetMesh mesh;
        std::vector<Material> materials;
        std::vector<Mat3> stresses;
    };

    Sample sample(int n = 4, double strain = 0.05)
    {
        Sample s { verification::distorted_box(n, 3.0, 0.2, 9),
            std::vector<Material>(2, test_support::material(kModulus, 0.3)), {} };
        const PreStrain tension { PreStrainKind::equibiaxial, strain, Vec3::Zero(), Vec3::UnitZ() };
        s.stresses = verification::stress_of_elements(s.mesh, s.materials, std::vector<PreStrain>(2, tension));
        return s;
    }

    std::vector<VertexId> all_vertices(const mesh::TetMesh& mesh)
    {
        std::vector<VertexId> all;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            all.push_back(v);
        return all;
    }

    Eigen::VectorXd random_state(Eigen::Index size, double amount, unsigned seed)
    {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> move(-amount, amount);
        return Eigen::VectorXd::NullaryExpr(size, [&] { return move(random); });
    }

    TEST(SpringNetwork, IsAtRestBeforeAnyCut)
    {
        const Sample s = sample();
        const SpringNetwork network(mesh::CutSession { s.mesh }, s.materials, s.stresses);
        const SpringPatch patch(network, all_vertices(s.mesh));
        const auto state = patch.response(patch.displacement());
        EXPECT_LT(state.forces.lpNorm<Eigen::Infinity>(), 1e-14);
        EXPECT_EQ(state.energy, 0.0);
    }

    TEST(SpringNetwork, ForcesAndTangentAreDerivativesOfTheEnergy)
    {
        const Sample s = sample(2);
        const SpringNetwork network(mesh::CutSession { s.mesh }, s.materials, s.stresses);
        SpringPatch patch(network, all_vertices(s.mesh));
        const Eigen::VectorXd u = random_state(patch.displacement().size(), 0.3, 2);
        ASSERT_EQ(patch.response(u).crushed, 0);
        const Eigen::VectorXd d = random_state(u.size(), 1.0, 3);
        constexpr double kStep = 1e-5;
        const auto plus = patch.response(u + kStep * d), minus = patch.response(u - kStep * d);
        const Eigen::VectorXd forces = patch.response(u).forces;
        constexpr double kSecondOrder = 1e-8; // of the central difference, relative
        EXPECT_NEAR((plus.energy - minus.energy) / (2 * kStep), forces.dot(d), kSecondOrder * forces.norm() * d.norm());
        patch.linearise(u, true);
        const Eigen::VectorXd change = (plus.forces - minus.forces) / (2 * kStep), product = patch.multiply(d);
        EXPECT_LT((change - product).norm(), 1e-7 * product.norm());
        const Eigen::VectorXd other = random_state(u.size(), 1.0, 4);
        EXPECT_NEAR(other.dot(product), d.dot(patch.multiply(other)), 1e-12 * product.norm() * other.norm());
    }

    TEST(SpringNetwork, CrushedElementsPushBackWithTheDerivativeOfTheirEnergy)
    {
        const Sample s = sample(1);
        const SpringNetwork network(mesh::CutSession { s.mesh }, s.materials, s.stresses);
        const SpringPatch patch(network, all_vertices(s.mesh));
        Eigen::VectorXd u = Eigen::VectorXd::Zero(patch.displacement().size());
        for (VertexId v = 0; v < 8; ++v) // flat, and a little through itself
            u[3 * v + 2] = -1.1 * s.mesh.vertices(v, 2);
        u += random_state(u.size(), 0.1, 5);
        const auto state = patch.response(u);
        EXPECT_GT(state.crushed, 0);
        EXPECT_GT(state.inverted, 0);
        const Eigen::VectorXd d = random_state(u.size(), 1.0, 6);
        constexpr double kStep = 1e-6;
        const double slope
            = (patch.response(u + kStep * d).energy - patch.response(u - kStep * d).energy) / (2 * kStep);
        EXPECT_NEAR(slope, state.forces.dot(d), 1e-6 * state.forces.norm() * d.norm());
    }

    TEST(SpringNetwork, HasSixRigidMotionsAndTheTangentNoNegativeOnes)
    {
        const Sample s = sample(2, 0.0);
        const SpringNetwork network(mesh::CutSession { s.mesh }, s.materials);
        SpringPatch patch(network, all_vertices(s.mesh));
        const Eigen::Index n = patch.displacement().size();
        const auto spectrum = [&](const Eigen::VectorXd& u) {
            patch.linearise(u);
            Eigen::MatrixXd K(n, n);
            for (Eigen::Index i = 0; i < n; ++i)
                K.col(i) = patch.multiply(Eigen::VectorXd::Unit(n, i));
            return Eigen::VectorXd(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues());
        };
        const Eigen::VectorXd values = spectrum(Eigen::VectorXd::Zero(n));
        int zero = 0;
        for (const double value : values)
            zero += std::abs(value) < 1e-10 * values[n - 1] ? 1 : 0;
        EXPECT_EQ(zero, 6);
        // Squeezed to half its width: compressed springs, and still nothing to fall down.
        Eigen::VectorXd squeezed = Eigen::VectorXd::Zero(n);
        for (VertexId v = 0; v < static_cast<VertexId>(s.mesh.vertex_count()); ++v)
            squeezed[3 * v] = -0.5 * s.mesh.vertices(v, 0);
        const Eigen::VectorXd there = spectrum(squeezed);
        EXPECT_GT(there[0], -1e-10 * there[n - 1]);
    }

    TEST(SpringNetwork, TurningCostsNothing)
    {
        const Sample s = sample(2, 0.0);
        const SpringNetwork network(mesh::CutSession { s.mesh }, s.materials);
        const SpringPatch patch(network, all_vertices(s.mesh));
        const Mat3 turn = Eigen::AngleAxisd(1.57, Vec3(1, 2, 3).normalized()).toRotationMatrix();
        const Eigen::VectorXd u = verification::nodal_values(s.mesh, [&](const Vec3& x) { return Vec3(turn * x - x); });
        const auto state = patch.response(u);
        EXPECT_LT(std::abs(state.energy), 1e-12);
        EXPECT_LT(state.forces.lpNorm<Eigen::Infinity>(), 1e-12);
    }

    mesh::Blade oblique_blade(double size)
    {
        return { .line = { Vec3(0.21 * size, 0.32 * size, size), Vec3(0.83 * size, 0.64 * size, size) },
            .directions = { Vec3(0.1, 0.15, -1.0) },
            .depth_mm = 0.6 * size };
    }

    void expect_same(const SpringNetwork& a, const SpringNetwork& b)
    {
        ASSERT_LE(b.vertex_slots(), a.vertex_slots());
        EXPECT_EQ(a.spring_count(), b.spring_count());
        for (VertexId v = 0; v < static_cast<VertexId>(b.vertex_slots()); ++v) {
            const auto x = a.springs(v), y = b.springs(v);
            ASSERT_EQ(x.size(), y.size()) << v;
            for (std::size_t i = 0; i < x.size(); ++i) {
                EXPECT_EQ(x[i].other, y[i].other);
                EXPECT_EQ(x[i].length, y[i].length);
                EXPECT_EQ(x[i].stiffness, y[i].stiffness);
                EXPECT_EQ(x[i].force_density, y[i].force_density);
            }
            EXPECT_EQ(a.release(v), b.release(v)) << v;
            EXPECT_EQ(a.fixed_axes(v), b.fixed_axes(v)) << v;
        }
    }

    TEST(SpringNetwork, FollowsCutsUndoAndRedoToTheBit)
    {
        const Sample s = sample(5);
        mesh::CutSession session(s.mesh);
        SpringNetwork network(mesh::CutSession { s.mesh }, s.materials, s.stresses);
        const SpringNetwork first = network;
        const auto follow = [&](const mesh::MeshDelta& delta) {
            network.apply(delta);
            network.set_wound(session.lips());
        };
        const auto expect_fresh = [&] { expect_same(network, SpringNetwork(session, s.materials, s.stresses)); };
        mesh::CutResult cut = session.cut(oblique_blade(15.0));
        ASSERT_EQ(cut.status, mesh::CutStatus::done) << cut.message;
        follow(cut.delta);
        expect_fresh();
        mesh::Blade across = oblique_blade(15.0);
        std::swap(across.line[0].x(), across.line[1].x());
        cut = session.cut(across);
        ASSERT_EQ(cut.status, mesh::CutStatus::done) << cut.message;
        follow(cut.delta);
        expect_fresh();
        const SpringNetwork twice = network;
        follow(session.undo());
        expect_fresh();
        follow(session.undo());
        expect_same(network, first);
        follow(session.redo());
        follow(session.redo());
        expect_same(network, twice);
    }

    TEST(SpringNetwork, FollowsAnAblationAndGivesBackWhatWasFixed)
    {
        const Sample s = sample(4);
        mesh::CutSession session(s.mesh);
        SpringNetwork network(mesh::CutSession { s.mesh }, s.materials, s.stresses);
        std::vector<VertexId> bottom;
        for (const VertexId v : all_vertices(s.mesh))
            if (s.mesh.vertices(v, 2) == 0.0)
                bottom.push_back(v);
        network.fix(bottom);
        const SpringNetwork first = network;
        std::vector<TetId> corner;
        for (TetId t = 0; t < static_cast<TetId>(s.mesh.tet_count()); ++t)
            if ((s.mesh.vertices(s.mesh.tet(t)[0], 0) < 4.0))
                corner.push_back(t);
        const mesh::CutResult ablation = session.ablate(corner);
        ASSERT_EQ(ablation.status, mesh::CutStatus::done);
        network.apply(ablation.delta);
        network.set_wound(session.lips());
        EXPECT_FALSE(network.lip_vertices().empty()); // bared tissue lets its tension go as a lip does
        network.apply(session.undo());
        network.set_wound(session.lips());
        expect_same(network, first);
    }

    TEST(SpringNetwork, StartedAfterAnAblationItFollowsWhenThatIsTakenBack)
    {
        const Sample s = sample(4);
        mesh::CutSession session(s.mesh);
        const mesh::CutResult ablation = session.ablate(session.tets_at(0));
        ASSERT_EQ(ablation.status, mesh::CutStatus::done);
        ASSERT_FALSE(ablation.delta.vertices_gone.empty());
        SpringNetwork network(session, s.materials, s.stresses);
        network.apply(session.undo());
        network.set_wound(session.lips());
        expect_same(network, SpringNetwork(mesh::CutSession { s.mesh }, s.materials, s.stresses));
        EXPECT_FALSE(network.is_fixed(0));
        network.apply(session.redo());
        network.set_wound(session.lips());
        expect_same(network, SpringNetwork(session, s.materials, s.stresses));
    }

    TEST(SpringNetwork, ReleasesAtALipWhatFiniteElementsRelease)
    {
        const Sample s = sample(5);
        mesh::CutSession session(s.mesh);
        SpringNetwork network(mesh::CutSession { s.mesh }, s.materials, s.stresses);
        const mesh::CutResult cut = session.cut(oblique_blade(15.0));
        network.apply(cut.delta);
        network.set_wound(session.lips());
        mesh::SlotMap map;
        const mesh::TetMesh compact = session.compact_mesh(&map);
        std::vector<Mat3> stresses;
        for (const TetId slot : map.tet_slot)
            stresses.push_back(s.stresses[static_cast<std::size_t>(session.origin(slot))]);
        std::vector<mesh::TetFace> faces;
        for (const mesh::LipFace& lip : session.lips())
            faces.push_back({ map.compact_tet[static_cast<std::size_t>(lip.face.tet)], lip.face.corner });
        const Eigen::VectorXd loads = traction_loads(compact, released_tractions(compact, faces, stresses));
        double largest = 0.0;
        for (std::size_t v = 0; v < map.vertex_slot.size(); ++v) {
            const Vec3 load = loads.segment<3>(3 * static_cast<Eigen::Index>(v));
            EXPECT_LT((load - network.release(map.vertex_slot[v])).norm(), 1e-15);
            largest = std::max(largest, load.norm());
        }
        EXPECT_GT(largest, 1e-3);
    }

    TEST(SpringNetwork, NewVerticesLieWhereTheirTissueLies)
    {
        const Sample s = sample(4);
        mesh::CutSession session(s.mesh);
        SpringNetwork network(mesh::CutSession { s.mesh }, s.materials, s.stresses);
        Mat3 gradient = Mat3::Zero();
        gradient(0, 1) = 0.1;
        gradient(2, 2) = 0.2;
        network.set_displacement((s.mesh.vertices * gradient.transpose()).eval());
        const mesh::CutResult cut = session.cut(oblique_blade(12.0), { .snap = 0.0 });
        ASSERT_GT(cut.delta.vertices_born.size(), 10U);
        network.apply(cut.delta);
        for (const auto& born : cut.delta.vertices_born)
            EXPECT_LT(
                (network.displacement().row(born.id).transpose() - gradient * network.rest().row(born.id).transpose())
                    .norm(),
                1e-9);
    }

    TEST(SpringNetwork, RefusesBadInput)
    {
        const Sample s = sample(1);
        const auto with = [&](auto... arguments) {
            return test_support::message_of([&] { SpringNetwork network(mesh::CutSession { s.mesh }, arguments...); });
        };
        const std::span<const Material> good(s.materials);
        const std::vector<Material> soft(2, test_support::material(0.0, 0.3)),
            nan(2, test_support::material(std::nan(""), 0.3)), few(1, soft[0]);
        EXPECT_NE(with(std::span<const Material>(soft)).find("Young's modulus"), std::string::npos);
        EXPECT_NE(with(std::span<const Material>(nan)).find("Young's modulus"), std::string::npos);
        EXPECT_NE(with(std::span<const Material>(few)).find("label 1"), std::string::npos);
        const std::vector<Mat3> one(1, Mat3::Zero());
        EXPECT_NE(with(good, std::span<const Mat3>(one)).find("no pre-stress for an element"), std::string::npos);
        std::vector<Mat3> broken = s.stresses;
        broken[3](1, 1) = std::numeric_limits<double>::infinity();
        EXPECT_NE(with(good, std::span<const Mat3>(broken)).find("element 3"), std::string::npos);
        SpringNetwork network(mesh::CutSession { s.mesh }, s.materials);
        const std::vector<VertexId> beyond { 1000 };
        EXPECT_NE(test_support::message_of([&] { network.fix(beyond); }).find("vertex 1000"), std::string::npos);
        EXPECT_NE(test_support::message_of([&] { network.fix({}, 8); }).find("axes"), std::string::npos);
        EXPECT_NE(test_support::message_of([&] {
            network.set_displacement(Points::Zero(1, 3));
        }).find("one displacement per vertex"),
            std::string::npos);
        Points holes = network.displacement();
        holes(2, 1) = std::nan("");
        EXPECT_NE(
            test_support::message_of([&] { network.set_displacement(holes); }).find("not finite"), std::string::npos);
        const std::vector<mesh::LipFace> nowhere { { { 99, 0 }, 1, 0 } };
        EXPECT_NE(test_support::message_of([&] { network.set_wound(nowhere); }).find("element 99"), std::string::npos);
    }

} // namespace edge_springs_test
} // namespace retractor::fem
