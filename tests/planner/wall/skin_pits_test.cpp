#include "planner/wall/skin_pits.h"

#include "mesh/base/triangle.h"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

namespace retractor::planner {
namespace skin_pits_test {

    constexpr Label kSkin = 1, kFat = 2;
    constexpr double kStepMm = 5.0, kPitMm = 3.0;
    constexpr int kSide = 9; ///< vertices along a side

    VertexId at(int i, int j) { return static_cast<VertexId>(j * kSide + i); }

    /// A flat sheet of skin at z = 0.
    TriMesh sheet()
    {
        TriMesh mesh;
        mesh.vertices.resize(kSide * kSide, 3);
        for (int j = 0; j < kSide; ++j)
            for (int i = 0; i < kSide; ++i)
                mesh.vertices.row(at(i, j)) << kStepMm * i, kStepMm * j, 0.0;
        for (int j = 0; j + 1 < kSide; ++j)
            for (int i = 0; i + 1 < kSide; ++i) {
                mesh.triangles.push_back({ at(i, j), at(i + 1, j), at(i + 1, j + 1) });
                mesh.triangles.push_back({ at(i, j), at(i + 1, j + 1), at(i, j + 1) });
            }
        mesh.labels.assign(mesh.triangles.size(), kSkin);
        return mesh;
    }

    TEST(SkinPits, AreLiftedToTheBodyWhateverTheWoundDoes)
    {
        const TriMesh body = sheet();
        TriMesh at_rest = sheet();
        at_rest.vertices(at(6, 4), 2) = -kPitMm;
        at_rest.vertices(at(7, 4), 2) = -kPitMm; // two in one pit
        at_rest.vertices(at(6, 6), 2) = -0.3; // within the step between two surfaces of the same voxels
        TriMesh drawn = at_rest;
        const Vec3 moved(1.0, -2.0, 4.0);
        drawn.vertices.rowwise() += moved.transpose();
        lift_pits(drawn, at_rest, body, { { 0.0, 0.0, 0.0 }, { 0.0, 40.0, 0.0 } }, kSkin);
        constexpr double kRound = 1e-12;
        EXPECT_NEAR(drawn.vertices(at(6, 4), 2), moved.z(), kRound);
        EXPECT_NEAR(drawn.vertices(at(7, 4), 2), moved.z(), kRound);
        EXPECT_NEAR(drawn.vertices(at(6, 6), 2), moved.z() - 0.3, kRound);
        EXPECT_NEAR(drawn.vertices(at(6, 4), 0), 6.0 * kStepMm + moved.x(), kRound);
        EXPECT_NEAR(drawn.vertices(at(2, 2), 2), moved.z(), kRound);
    }

    TEST(SkinPits, APitThatReachesUnderItsRimIsNotFoldedOver)
    {
        const TriMesh body = sheet();
        TriMesh at_rest = sheet();
        at_rest.vertices.row(at(6, 4)) << 6.0 * kStepMm + 1.3 * kStepMm, 4.0 * kStepMm, -kPitMm; // under (7, 4)
        TriMesh drawn = at_rest;
        lift_pits(drawn, at_rest, body, { { 0.0, 0.0, 0.0 }, { 0.0, 40.0, 0.0 } }, kSkin);
        for (const auto& t : drawn.triangles) {
            const auto [a, b, c] = triangle_corners(drawn.vertices, t);
            EXPECT_GT((b - a).cross(c - a).z(), 0.0) << t[0] << ' ' << t[1] << ' ' << t[2];
        }
        EXPECT_NEAR(drawn.vertices(at(6, 4), 2), 0.0, 1e-12);
    }

    TEST(SkinPits, AShallowPitIsLiftedWhereItIsSteep)
    {
        TriMesh at_rest = sheet();
        at_rest.vertices.row(at(6, 4)) << 7.0 * kStepMm - 0.5, 4.0 * kStepMm, -0.6; // a short steep side
        TriMesh drawn = at_rest;
        lift_pits(drawn, at_rest, sheet(), { { 0.0, 0.0, 0.0 }, { 0.0, 40.0, 0.0 } }, kSkin);
        EXPECT_NEAR(drawn.vertices(at(6, 4), 2), 0.0, 1e-12);
    }

    TEST(SkinPits, LipsOtherTissueAndOtherSurfacesStay)
    {
        const TriMesh body = sheet();
        TriMesh at_rest = sheet();
        at_rest.vertices(at(1, 4), 2) = -kPitMm; // beside the cut
        at_rest.vertices(at(5, 2), 2) = -kPitMm; // at the bottom of the skin, where fat begins
        at_rest.vertices(at(6, 6), 2) = -7.0; // the inner side of a fold
        for (std::size_t t = 0; t < at_rest.triangles.size(); ++t)
            if (at_rest.triangles[t][0] == at(5, 2))
                at_rest.labels[t] = kFat;
        TriMesh drawn = at_rest;
        lift_pits(drawn, at_rest, body, { { 0.0, 0.0, 0.0 }, { 0.0, 40.0, 0.0 } }, kSkin);
        EXPECT_EQ(drawn.vertices, at_rest.vertices);
    }

} // namespace skin_pits_test
} // namespace retractor::planner
