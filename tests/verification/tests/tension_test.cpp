#include "tests/verification/framework/tension.h"

#include "fem/springs/edge_springs.h"
#include "fem/springs/spring_relaxation.h"
#include "mesh/base/error.h"
#include "mesh/cutting/cut_session.h"
#include "tests/support/reference_problems.h"
#include "tests/verification/framework/element_stress.h"

#include <gtest/gtest.h>

#include <cmath>

namespace retractor::verification {
namespace tension_test {

    using test_support::material;

    constexpr double kModulus = 0.2, kCentral = 0.25, kStrain = 0.02;
    constexpr double kSuperposition = 1e-9; // round-off of two solves

    struct CutSheet {
        SheetProblem problem;
        mesh::TetMesh uncut, mesh;
        std::vector<fem::Material> materials
            = std::vector<fem::Material>(2, test_support::material(kModulus, kCentral));
        std::vector<Mat3> stresses; ///< of the uncut mesh
        mesh::CutSession session;
        mesh::MeshDelta delta;
        mesh::SlotMap map;

        explicit CutSheet(int around,
            const fem::PreStrain& tension
            = { fem::PreStrainKind::uniaxial_stress, kStrain, Vec3::UnitY(), Vec3::UnitZ() })
            : problem { .around = around }
            , uncut(sheet_mesh(problem))
            , stresses(stress_of_elements(uncut, materials, std::vector<fem::PreStrain>(2, tension)))
            , session(uncut)
        {
            mesh::CutResult cut = session.cut(sheet_blade(problem));
            EXPECT_EQ(cut.status, mesh::CutStatus::done) << cut.message;
            delta = std::move(cut.delta);
            mesh = session.compact_mesh(&map);
        }
        Points rim_displacement(const mesh::TetMesh& m) const
        {
            Points u = Points::Zero(m.vertices.rows(), 3);
            for (const VertexId v : sheet_rim(problem, m))
                u.row(v) = sheet_displacement(
                    problem.cut_length, stresses.front()(1, 1), kModulus, kCentral, m.vertices.row(v).transpose())
                               .transpose();
            return u;
        }
        /// Mean over the thickness at the middle; one row per id of the session.
        double gape(const Points& u) const
        {
            double sum = 0.0;
            int count = 0;
            for (const auto& born : delta.vertices_born)
                if (born.origin == mesh::MeshDelta::Origin::copy && std::abs(born.position.x()) < 1e-9) {
                    sum += std::abs(u(born.id, 1) - u(born.a, 1));
                    ++count;
                }
            EXPECT_GT(count, 0);
            return sum / count;
        }
        double finite_element_gape() const
        {
            std::vector<mesh::TetFace> faces;
            for (const mesh::LipFace& lip : session.lips())
                faces.push_back({ map.compact_tet[static_cast<std::size_t>(lip.face.tet)], lip.face.corner });
            std::vector<Mat3> carried;
            for (const TetId slot : map.tet_slot)
                carried.push_back(stresses[static_cast<std::size_t>(session.origin(slot))]);
            const ReleasedWound wound = release_wound(
                mesh, faces, carried, materials, { .fixed = sheet_rim(problem, mesh) }, rim_displacement(mesh));
            EXPECT_LT(wound.relative_residual, 1e-9);
            Points u = Points::Zero(static_cast<Eigen::Index>(map.compact_vertex.size()), 3);
            for (std::size_t v = 0; v < map.vertex_slot.size(); ++v)
                u.row(map.vertex_slot[v]) = wound.displacement.row(static_cast<Eigen::Index>(v));
            return gape(u);
        }
        double spring_gape() const
        {
            fem::SpringNetwork network(mesh::CutSession { uncut }, materials, stresses);
            network.set_displacement(rim_displacement(uncut));
            network.fix(sheet_rim(problem, uncut));
            network.fix(sheet_middle_plane(uncut), 4);
            network.apply(delta);
            network.set_wound(session.lips());
            EXPECT_EQ(fem::relax(network, { .tolerance = 1e-4 }).status, fem::RelaxStatus::converged);
            return gape(network.displacement());
        }
    };

    const double kRight = sheet_gape(fem::PreStrainKind::uniaxial_stress, kStrain, 80.0, kCentral);

    TEST(SheetProblem, ClosedFormsAgree)
    {
        EXPECT_NEAR(sheet_gape(fem::PreStrainKind::uniaxial_stress, 0.02, 80.0, 0.3), 3.2, 1e-12);
        EXPECT_NEAR(sheet_gape(fem::PreStrainKind::uniaxial_stress, 0.06, 80.0, 0.3), 9.6, 1e-12);
        EXPECT_NEAR(sheet_gape(fem::PreStrainKind::held_width, 0.04, 80.0, 0.5), 6.4 / 0.75, 1e-12);
        EXPECT_NEAR(sheet_gape(fem::PreStrainKind::equibiaxial, 0.04, 80.0, 0.5), 12.8, 1e-12);
        EXPECT_NEAR(sheet_gape(fem::PreStrainKind::biaxial, 0.04, 80.0, 0.5, 0.02), 8.0 / 0.75, 1e-12);
        EXPECT_THROW(sheet_gape(fem::PreStrainKind::isotropic, 0.04, 80.0, 0.5), InputError);
        // Just above and below the cut the field is an ellipse; far away it dies out.
        for (const double x : { 0.0, 20.0, 39.0 }) {
            const double half = 0.5 * 3.2 * std::sqrt(1.0 - x * x / 1600.0);
            EXPECT_NEAR(sheet_displacement(80.0, 0.02, 1.0, 0.3, Vec3(x, 1e-9, 0.0)).y(), half, 1e-6);
            EXPECT_NEAR(sheet_displacement(80.0, 0.02, 1.0, 0.3, Vec3(x, -1e-9, 0.0)).y(), -half, 1e-6);
        }
        EXPECT_LT(sheet_displacement(80.0, 0.02, 1.0, 0.3, Vec3(3000.0, 9000.0, 0.0)).norm(), 0.01);
    }

    TEST(SheetProblem, IsCutFromTipToTip)
    {
        const CutSheet sheet(32);
        double left = 0.0, right = 0.0;
        for (const mesh::LipFace& lip : sheet.session.lips())
            for (const VertexId v : mesh::face_vertices(
                     sheet.mesh, { sheet.map.compact_tet[static_cast<std::size_t>(lip.face.tet)], lip.face.corner })) {
                EXPECT_NEAR(sheet.mesh.vertices(v, 1), 0.0, 1e-9);
                left = std::min(left, sheet.mesh.vertices(v, 0));
                right = std::max(right, sheet.mesh.vertices(v, 0));
            }
        EXPECT_NEAR(left, -40.0, 1e-9);
        EXPECT_NEAR(right, 40.0, 1e-9);
    }

    TEST(Tension, OnlyTheStressAcrossTheCutCountsWhereStrainsDiffer)
    {
        constexpr double kMore = 0.04, kLess = 0.01;
        const double mesh = CutSheet(32).finite_element_gape() / kRight; // 32 cells round the cut are 4 % stiff
        for (const auto& [across_cut, along_cut] : { std::pair { kMore, kLess }, std::pair { kLess, kMore } }) {
            // Told by the direction of the larger strain, whichever way that is.
            const bool larger_across = across_cut > along_cut;
            const CutSheet sheet(32,
                { fem::PreStrainKind::biaxial, kMore, larger_across ? Vec3::UnitY() : Vec3::UnitX(), Vec3::UnitZ(),
                    kLess });
            const double right = sheet_gape(fem::PreStrainKind::biaxial, across_cut, 80.0, kCentral, along_cut);
            EXPECT_NEAR(sheet.finite_element_gape() / right, mesh, kSuperposition);
        }
    }

    /// Second order in the cells round the cut, which are made for its tips; less as far as the sheet, one cell thick,
    /// is not thin.
    TEST(Tension, FiniteElementsConvergeToTheClosedForm)
    {
        const double coarse = CutSheet(32).finite_element_gape() / kRight - 1.0;
        const double middle = CutSheet(64).finite_element_gape() / kRight - 1.0;
        const double fine = CutSheet(128).finite_element_gape() / kRight - 1.0;
        EXPECT_LT(coarse, middle);
        EXPECT_LT(middle, fine);
        EXPECT_LT(std::abs(fine), 0.006);
        const double order = std::log2((coarse - middle) / (middle - fine));
        EXPECT_GT(order, 1.5);
        EXPECT_LT(order, 2.6);
    }

    TEST(Tension, SpringsGapeAsTheClosedFormSays)
    {
        for (const int around : { 32, 64 })
            EXPECT_NEAR(CutSheet(around).spring_gape(), kRight, 0.04 * kRight) << around;
    }

    TEST(Tension, SpringsAreCalibratedAgainstFiniteElements)
    {
        for (const int around : { 32, 64 }) {
            const CutSheet sheet(around);
            const double factor = spring_calibration(sheet.uncut, sheet.materials,
                sheet_rim(sheet.problem, sheet.uncut), Vec3::UnitY(), sheet_middle_plane(sheet.uncut));
            EXPECT_NEAR(factor, 1.0, 0.06) << around;
        }
        // Whatever the modulus: it is a ratio.
        const mesh::TetMesh box = distorted_box(4, 2.0, 0.2, 3);
        std::vector<VertexId> ends;
        for (VertexId v = 0; v < static_cast<VertexId>(box.vertex_count()); ++v)
            if (box.vertices(v, 0) == 0.0 || box.vertices(v, 0) == 8.0)
                ends.push_back(v);
        const auto factor = [&](double modulus) {
            return spring_calibration(
                box, std::vector<fem::Material>(2, test_support::material(modulus, 0.4)), ends, Vec3::UnitX());
        };
        EXPECT_NEAR(factor(0.01), factor(10.0), 1e-3);
        EXPECT_NEAR(factor(1.0), 1.0, 0.15);
    }

    TEST(Tension, RefusesBadInput)
    {
        EXPECT_THROW(sheet_mesh({ .cut_length = 80.0, .radius = 30.0 }), InputError);
        EXPECT_THROW(sheet_mesh({ .around = 30 }), InputError);
        const mesh::TetMesh mesh = mesh::kuhn_box(2, 2, 2, 1.0);
        const std::vector<fem::Material> materials(2, test_support::material(kModulus, kCentral));
        const std::vector<Mat3> none(mesh.tet_count(), Mat3::Zero());
        EXPECT_THROW(static_cast<void>(release_wound(mesh, {}, none, materials, {})), SolverError);
        const std::vector<VertexId> beyond { 500 };
        EXPECT_THROW(spring_calibration(mesh, materials, beyond, Vec3::UnitX()), InputError);
        const std::vector<VertexId> held { 0, 1, 2, 3 };
        EXPECT_THROW(spring_calibration(mesh, materials, held, Vec3::Zero()), InputError);
        for (const VertexId bad : { -1, 500 }) {
            const std::vector<VertexId> symmetry { bad };
            EXPECT_THROW(spring_calibration(mesh, materials, held, Vec3::UnitX(), symmetry), InputError);
            const fem::Supports bedded { .fixed = held, .bedded = { { bad, 1.0 } } };
            EXPECT_THROW(static_cast<void>(release_wound(mesh, {}, none, materials, bedded)), InputError);
        }
        EXPECT_THROW(static_cast<void>(release_wound(mesh, {}, none, materials, { .fixed = held }, Points::Zero(3, 3))),
            InputError);
    }

} // namespace tension_test
} // namespace retractor::verification
