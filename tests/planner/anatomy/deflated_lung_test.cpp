#include "planner/anatomy/deflated_lung.h"

#include "datasets/io/volume_io.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"
#include "planner/case/case_io.h"
#include "planner/plan/wound_view.h"
#include "tests/support/synthetic_chest.h"
#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace retractor::planner {
namespace deflated_lung_test {

    constexpr double kTolerance = 1e-9; // rounding, of lengths of 100 mm

    AnatomicalFrame axes()
    {
        return { .origin = { 0, 0, 0 }, .superior = Vec3::UnitZ(), .anterior = -Vec3::UnitY(), .left = Vec3::UnitX() };
    }

    double volume_of(const TriMesh& mesh)
    {
        double six = 0.0;
        for (const auto& triangle : mesh.triangles) {
            const auto c = triangle_corners(mesh.vertices, triangle);
            six += c[0].dot(c[1].cross(c[2]));
        }
        return six / 6.0;
    }

    TEST(DeflatedLung, KeepsItsShareOfTheVolumeAndItsHilum)
    {
        const TriMesh lung = sphere_surface({ 80, 10, 20 }, 60.0);
        for (const double share : { 0.2, 0.3, 0.5, 1.0 }) {
            const Vec3 hilum(20, 10, 20);
            const TriMesh small = shrunk(lung, hilum, share);
            EXPECT_NEAR(volume_of(small) / volume_of(lung), share, 1e-9);
            // What touched the hilum still does.
            EXPECT_NEAR((small.vertices.rowwise() - hilum.transpose()).rowwise().norm().minCoeff(),
                std::cbrt(share) * (lung.vertices.rowwise() - hilum.transpose()).rowwise().norm().minCoeff(),
                kTolerance);
        }
        for (const double bad : { 0.0, -0.1, 1.1, std::nan("") })
            EXPECT_THROW(shrunk(lung, Vec3::Zero(), bad), InputError);
    }

    TEST(DeflatedLung, TheHilumIsTheMedialSurfaceWhereTheBronchiPart)
    {
        const TriMesh left = sphere_surface({ 80, 10, 20 }, 60.0), right = sphere_surface({ -80, 10, 20 }, 60.0);
        const TriMesh* const of_left[] = { &left };
        const TriMesh* const of_right[] = { &right };
        constexpr double kEdge = 6.0; // of the spheres
        const auto towards
            = [](const Vec3& centre, const Vec3& root) { return Vec3(centre + 60.0 * (root - centre).normalized()); };
        // The back is at y = 70, the front at y = -50.
        const Vec3 root(0, 30, 20);
        EXPECT_LT((hilum(of_left, nullptr, axes()) - towards({ 80, 10, 20 }, root)).norm(), kEdge);
        EXPECT_LT((hilum(of_right, nullptr, axes()) - towards({ -80, 10, 20 }, root)).norm(), kEdge);
        const TriMesh windpipe = sphere_surface({ 0, 40, 60 }, 10.0); // ends at z = 50
        EXPECT_LT((hilum(of_left, &windpipe, axes()) - towards({ 80, 10, 20 }, { 0, 40, 50 })).norm(), kEdge);
        // Two lobes have one hilum, between them.
        const TriMesh upper = sphere_surface({ 80, 10, 60 }, 40.0), lower = sphere_surface({ 80, 10, -20 }, 40.0);
        const TriMesh* const lobes[] = { &upper, &lower };
        const Vec3 between = hilum(lobes, nullptr, axes());
        EXPECT_GT(between.x(), 40.0 - kEdge);
        EXPECT_GT(between.y(), 10.0);
        EXPECT_LT(between.y(), 30.0 + kEdge);
        // Moved with the patient, it moves alike.
        const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, 3).normalized());
        AnatomicalFrame turned = axes();
        for (Vec3* axis : { &turned.superior, &turned.anterior, &turned.left })
            *axis = turn * *axis;
        TriMesh moved = left;
        moved.vertices = (turn.toRotationMatrix() * left.vertices.transpose()).transpose();
        const TriMesh* const of_moved[] = { &moved };
        EXPECT_LT((hilum(of_moved, nullptr, turned) - turn * hilum(of_left, nullptr, axes())).norm(), 1e-6);
    }

    TEST(DeflatedLung, IsHeldStraightAwayFromTheLineOfSightWithinItsRoom)
    {
        const TriMesh whole = sphere_surface({ 80, 10, 20 }, 60.0);
        const TriMesh* const before[] = { &whole };
        const TriMesh after[] = { shrunk(whole, { 20, 10, 20 }, 0.3) };
        // A line along y at x = 20: away is to the left, as far as the lung reached there.
        const Vec3 shift = held_away(before, after, { 20, -200, 20 }, { 20, 200, 20 }, axes());
        const double room = whole.vertices.col(0).maxCoeff() - after[0].vertices.col(0).maxCoeff();
        EXPECT_LT((shift - Vec3(std::min(room, kHeldAwayMm), 0, 0)).norm(), 1e-6);
        EXPECT_GT(shift.x(), 10.0);
        // Through the middle of what is left there is no way aside.
        const Vec3 middle = after[0].vertices.colwise().mean().transpose();
        EXPECT_LT(held_away(before, after, middle - Vec3(0, 100, 0), middle + Vec3(0, 100, 0), axes()).norm(), 1e-9);
    }

    Case chest_with_lungs()
    {
        const mesh::LabelVolume labels = test_support::synthetic_chest();
        Case planned_case;
        planned_case.folder = std::filesystem::path(testing::TempDir()) / "deflated_lung";
        std::filesystem::create_directories(planned_case.folder);
        datasets::write_label_volume(planned_case.folder / "labels.nrrd", labels);
        planned_case.labels = make_reference(planned_case.folder, planned_case.folder / "labels.nrrd");
        planned_case.label_table = labels.table;
        return planned_case;
    }

    TEST(DeflatedLung, ALungThatIsHeldAsideHidesWhereItShrinksTo)
    {
        Patient patient(chest_with_lungs());
        Approach approach;
        approach.target.label = "aneurysm";
        approach.incision = { { 0, -120, 30 }, { 0, -120, 0 }, { 0, -120, -30 } };
        EXPECT_TRUE(deflated_lungs(approach, patient).empty()) << "it is not held aside";
        const auto names = [&] {
            std::vector<std::string> all;
            for (const Occluder& organ : organ_occluders(approach, patient))
                all.push_back(organ.name);
            return all;
        };
        const auto has = [&](const char* name) {
            const std::vector<std::string> all = names();
            return std::find(all.begin(), all.end(), name) != all.end();
        };
        EXPECT_TRUE(has("lung_left"));
        approach.retracted = { "lung_left", "heart" };
        const std::vector<DeflatedLung> lungs = deflated_lungs(approach, patient);
        ASSERT_EQ(lungs.size(), 1U);
        const TriMesh whole = *patient.organ("lung_left");
        EXPECT_NEAR(volume_of(lungs[0].surface) / volume_of(whole), kDeflatedLungShare, 1e-6);
        constexpr double kTiltMm = 0.5; // the axes found from voxels lean by some tenths of a degree
        for (int axis = 0; axis < 3; ++axis) { // within the room that it had; this chest stands along the axes
            EXPECT_GE(lungs[0].surface.vertices.col(axis).minCoeff(), whole.vertices.col(axis).minCoeff() - kTiltMm);
            EXPECT_LE(lungs[0].surface.vertices.col(axis).maxCoeff(), whole.vertices.col(axis).maxCoeff() + kTiltMm);
        }
        EXPECT_FALSE(has("lung_left"));
        EXPECT_TRUE(has("lung_left_deflated"));
        const std::vector<Occluder> unhidden = organ_occluders(approach, patient, { .lung_share = 0.0 });
        EXPECT_TRUE(std::none_of(unhidden.begin(), unhidden.end(),
            [](const Occluder& organ) { return organ.name.starts_with("lung_left"); }));
        EXPECT_EQ(label_of_deflated("lung_left_deflated"), "lung_left");
        EXPECT_EQ(label_of_deflated("aorta"), "aorta");
        approach.target.label = "lung_left"; // what is operated on is not deflated
        EXPECT_TRUE(deflated_lungs(approach, patient).empty());
        approach.target = { .label = {}, .centre = whole.vertices.colwise().mean().transpose(), .radius_mm = 5.0 };
        ASSERT_EQ(mesh::label_at(*patient.labels(), approach.target.centre),
            mesh::find_label(patient.labels()->table, "lung_left")->id);
        EXPECT_TRUE(deflated_lungs(approach, patient).empty()) << "the sphere lies in it";
    }

} // namespace deflated_lung_test
} // namespace retractor::planner
