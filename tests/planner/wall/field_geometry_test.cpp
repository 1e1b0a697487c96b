#include "mesh/cutting/cut_session.h"
#include "planner/wall/field_geometry.h"

#include "mesh/base/error.h"
#include "planner/measures/sight/exposure.h"
#include "tests/support/cutting/cut_mesh.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace retractor::planner {
namespace field_geometry_test {

    constexpr double kPi = std::numbers::pi;

    /// The lips of an elliptic gap in the plane z = 0, cut along x from -a to a; n pieces each.
    std::array<LipLine, 2> ellipse(double a, double b_left, double b_right, int n)
    {
        std::array<LipLine, 2> lips;
        for (int i = 0; i <= n; ++i) {
            const double t = kPi * i / n, x = -a * std::cos(t);
            lips[0].points.push_back(Vec3(x, b_left * std::sin(t), 0));
            lips[1].points.push_back(Vec3(x, -b_right * std::sin(t), 0));
            for (LipLine& lip : lips)
                lip.along_mm.push_back(x);
        }
        return lips;
    }

    void move(LipLine& lip, const Eigen::Isometry3d& pose)
    {
        for (Vec3& p : lip.points)
            p = pose * p;
    }

    TEST(OpeningGeometry, EllipseConvergesToItsClosedForm)
    {
        constexpr double a = 40.0, b = 12.0;
        std::array<double, 2> error {};
        for (std::size_t level = 0; level < 2; ++level) {
            const auto lips = ellipse(a, b, b, level == 0 ? 20 : 80);
            const OpeningGeometry opening = opening_geometry(lips[0], lips[1], Vec3(0.2, 0, 1));
            error[level] = std::abs(opening.area_mm2 - kPi * a * b) / (kPi * a * b);
            EXPECT_NEAR(opening.width_mm, 2.0 * b, 1e-12);
            EXPECT_NEAR(opening.length_mm, 2.0 * a, 1e-12);
            EXPECT_NEAR(opening.overlap_area_mm2, 0.0, 0.0);
            EXPECT_NEAR((opening.normal - Vec3::UnitZ()).norm(), 0.0, 1e-12);
            EXPECT_NEAR((opening.along - Vec3::UnitX()).norm(), 0.0, 1e-12);
            EXPECT_NEAR(opening.centre.norm(), 0.0, 1e-9);
        }
        EXPECT_LT(error[1], 5e-4);
        EXPECT_NEAR(error[0] / error[1], 16.0, 0.5); // second order in the length of the pieces
        // Circumference of the ellipse [Ramanujan 1914], half of it per lip.
        const auto lips = ellipse(a, b, b, 400);
        const double h = (a - b) * (a - b) / ((a + b) * (a + b));
        EXPECT_NEAR(opening_geometry(lips[0], lips[1], Vec3::UnitZ()).incision_length_mm,
            0.5 * kPi * (a + b) * (1.0 + 3.0 * h / (10.0 + std::sqrt(4.0 - 3.0 * h))), 0.01);
    }

    TEST(OpeningFromTarget, ACircleOverAPointHasItsClosedForm)
    {
        // Half angle of the cone: the solid angle is 2 pi (1 - cos), and the angles of attack are twice the half angle.
        constexpr double kRadius = 30.0, kDepth = 80.0;
        const double half = std::atan(kRadius / kDepth), exact = 2.0 * kPi * (1.0 - std::cos(half));
        std::array<double, 2> error {};
        for (std::size_t level = 0; level < 2; ++level) {
            const auto lips = ellipse(kRadius, kRadius, kRadius, level == 0 ? 20 : 40);
            const OpeningGeometry opening = opening_geometry(lips[0], lips[1], Vec3::UnitZ());
            const OpeningFromTarget seen = opening_from(opening, lips[0], lips[1], Vec3(0.0, 0.0, -kDepth));
            error[level] = std::abs(seen.solid_angle_sr - exact) / exact;
            EXPECT_NEAR(seen.along_deg, 2.0 * half * 180.0 / kPi, 1e-9);
            EXPECT_NEAR(seen.across_deg, 2.0 * half * 180.0 / kPi, 1e-9);
            EXPECT_NEAR(seen.offset_mm, 0.0, 1e-9);
        }
        EXPECT_LT(error[1], 2e-3);
        EXPECT_NEAR(error[0] / error[1], 4.0, 0.1) << "second order in the length of the pieces";
    }

    TEST(OpeningFromTarget, ATargetBesideSeesLessAndOneAboveNothing)
    {
        const auto lips = ellipse(40.0, 12.0, 12.0, 40);
        const OpeningGeometry opening = opening_geometry(lips[0], lips[1], Vec3::UnitZ());
        const OpeningFromTarget below = opening_from(opening, lips[0], lips[1], Vec3(0.0, 0.0, -60.0)),
                                beside = opening_from(opening, lips[0], lips[1], Vec3(0.0, 50.0, -60.0)),
                                above = opening_from(opening, lips[0], lips[1], Vec3(0.0, 0.0, 60.0));
        EXPECT_NEAR(below.along_deg, 2.0 * std::atan(40.0 / 60.0) * 180.0 / kPi, 1e-9);
        EXPECT_NEAR(below.across_deg, 2.0 * std::atan(12.0 / 60.0) * 180.0 / kPi, 1e-9);
        EXPECT_LT(beside.solid_angle_sr, below.solid_angle_sr);
        EXPECT_NEAR(beside.offset_mm, 50.0, 1e-9);
        EXPECT_NEAR(beside.across_deg, (std::atan2(62.0, 60.0) - std::atan2(38.0, 60.0)) * 180.0 / kPi, 1e-9);
        EXPECT_EQ(above.solid_angle_sr, 0.0);
        EXPECT_EQ(above.along_deg, 0.0);
        const auto crossed = ellipse(40.0, -5.0, -5.0, 40);
        const OpeningGeometry closed = opening_geometry(crossed[0], crossed[1], Vec3::UnitZ());
        EXPECT_EQ(opening_from(closed, crossed[0], crossed[1], Vec3(0.0, 0.0, -60.0)).solid_angle_sr, 0.0);
    }

    TEST(OpeningGeometry, OneLipMovesTheCentre)
    {
        const auto lips = ellipse(40.0, 12.0, 0.0, 200); // only the left lip is pulled
        const OpeningGeometry opening = opening_geometry(lips[0], lips[1], Vec3::UnitZ());
        EXPECT_NEAR(opening.area_mm2, 0.5 * kPi * 40.0 * 12.0, 0.5);
        EXPECT_NEAR(opening.width_mm, 12.0, 1e-12);
        EXPECT_NEAR(opening.centre.y(), 4.0 * 12.0 / (3.0 * kPi), 0.05); // centroid of a half ellipse
    }

    TEST(OpeningGeometry, CurvedGapIsMeasuredAcross)
    {
        // Two arcs of one centre, 10 mm apart, over 120 degrees: 10 mm wide everywhere, area (R2^2 - R1^2) / 2 * angle.
        LipLine inner, outer;
        constexpr int n = 200;
        for (int i = 0; i <= n; ++i) {
            const double t = 2.0 * kPi / 3.0 * i / n;
            inner.points.push_back(
                35.0 * Vec3(std::cos(t), std::sin(t), 0)); // going round anticlockwise the centre is left
            outer.points.push_back(45.0 * Vec3(std::cos(t), std::sin(t), 0));
            inner.along_mm.push_back(i);
            outer.along_mm.push_back(i);
        }
        const OpeningGeometry opening = opening_geometry(inner, outer, Vec3::UnitZ());
        EXPECT_NEAR(opening.width_mm, 10.0, 1e-6);
        EXPECT_NEAR(opening.area_mm2, 0.5 * (45.0 * 45.0 - 35.0 * 35.0) * 2.0 * kPi / 3.0, 0.1);
        EXPECT_GT(opening.normal.z(), 0.999999);
    }

    TEST(OpeningGeometry, ClosedAndCrossedLips)
    {
        const auto closed = ellipse(40.0, 3.0, -3.0, 50); // both lips on the same curve
        const OpeningGeometry slit = opening_geometry(closed[0], closed[1], Vec3(0, 0, 2));
        EXPECT_NEAR(slit.area_mm2, 0.0, 1e-9);
        EXPECT_EQ(slit.width_mm, 0.0);
        EXPECT_EQ((slit.normal - Vec3::UnitZ()).norm(), 0.0);
        EXPECT_NEAR(slit.centre.x(), 0.0, 1e-9);
        EXPECT_GT(slit.centre.y(), 1.0);

        const auto lips = ellipse(40.0, 5.0, 5.0, 100);
        const OpeningGeometry crossed = opening_geometry(lips[1], lips[0], Vec3::UnitZ());
        EXPECT_EQ(crossed.area_mm2, 0.0);
        EXPECT_EQ(crossed.width_mm, 0.0);
        EXPECT_NEAR(crossed.overlap_area_mm2, kPi * 200.0, 0.5);
        EXPECT_GT(crossed.normal.z(), 0.999);
    }

    TEST(OpeningGeometry, SameUnderRigidMotion)
    {
        constexpr double kRoundOff = 1e-9; // relative to 1 m away from the origin
        auto lips = ellipse(40.0, 12.0, 7.0, 31);
        for (std::size_t i = 0; i < lips[0].points.size(); ++i)
            lips[0].points[i].z() = 3.0 + 0.002 * lips[0].points[i].x() * lips[0].points[i].x(); // not flat
        TriMesh target;
        target.vertices.resize(3, 3);
        target.vertices << -10, -10, -70, 10, -10, -75, 0, 20, -65;
        target.triangles = { { 0, 1, 2 } };
        const Vec3 aim = surface_centre(target), axis(0.1, -0.2, 1.0);
        const OpeningGeometry a = opening_geometry(lips[0], lips[1], Vec3::UnitZ());

        Eigen::Isometry3d pose(Eigen::AngleAxisd(2.0, Vec3(1, 2, -1).normalized()));
        pose.pretranslate(Vec3(-300, 700, 900));
        auto turned = lips;
        move(turned[0], pose);
        move(turned[1], pose);
        TriMesh turned_target = target;
        for (int v = 0; v < 3; ++v)
            turned_target.vertices.row(v) = (pose * Vec3(target.vertices.row(v).transpose())).transpose();
        const OpeningGeometry b = opening_geometry(turned[0], turned[1], pose.linear() * Vec3::UnitZ());
        EXPECT_NEAR(a.area_mm2, b.area_mm2, kRoundOff * a.area_mm2);
        EXPECT_NEAR(a.width_mm, b.width_mm, kRoundOff * a.width_mm);
        EXPECT_NEAR((pose * a.centre - b.centre).norm(), 0.0, kRoundOff);
        EXPECT_NEAR((pose.linear() * a.normal - b.normal).norm(), 0.0, kRoundOff);
        const auto distance_a = working_distance_mm(a, target, aim, axis);
        const auto distance_b = working_distance_mm(b, turned_target, pose * aim, pose.linear() * axis);
        ASSERT_TRUE(distance_a && distance_b);
        EXPECT_NEAR(*distance_a, *distance_b, kRoundOff * 100.0);
    }

    TEST(WorkingDistance, AlongTheAxisToTheFirstPointOfTheTarget)
    {
        const auto lips = ellipse(40.0, 12.0, 12.0, 50);
        const OpeningGeometry opening = opening_geometry(lips[0], lips[1], Vec3::UnitZ());
        TriMesh plates; // two large triangles at z = -80 and z = -95
        plates.vertices.resize(6, 3);
        plates.vertices << -300, -300, -80, 300, -300, -80, 0, 500, -80, -300, -300, -95, 300, -300, -95, 0, 500, -95;
        plates.triangles = { { 3, 4, 5 }, { 0, 1, 2 } };
        const Vec3 aim(0, 0, -90);
        EXPECT_NEAR(*working_distance_mm(opening, plates, aim, Vec3(0, 0, 3)), 80.0, 1e-12);
        const Vec3 oblique(0, std::sin(0.5), std::cos(0.5));
        EXPECT_NEAR(*working_distance_mm(opening, plates, aim, oblique), 80.0 / std::cos(0.5), 1e-9);
        EXPECT_NEAR(*working_distance_mm(opening, {}, aim, Vec3::UnitZ()), 90.0, 1e-12); // to the aim itself
        EXPECT_FALSE(working_distance_mm(opening, plates, aim, Vec3::UnitX()).has_value());
    }

    TEST(ViewCone, LooksThroughTheMiddleOfTheOpening)
    {
        constexpr double r = 25.0, h = 60.0;
        const auto lips = ellipse(r, r, r, 360);
        const OpeningGeometry opening = opening_geometry(lips[0], lips[1], Vec3::UnitZ());
        const ViewCone cone = cone_through_opening(opening, Vec3(0, 0, -h), 400.0, 15.0, 8);
        EXPECT_NEAR((cone.axis - Vec3::UnitZ()).norm(), 0.0, 1e-9);
        EXPECT_NEAR((eye_positions(cone)[0] - Vec3(0, 0, 400 - h)).norm(), 0.0, 1e-6);
        EXPECT_THROW((void)cone_through_opening(opening, opening.centre, 400.0, 15.0, 8), InputError);
    }

    // ---- the edge on a mesh ---------------------------------------------------------------------------

    /// A box of 60 x 40 x 20 mm, cut in the plane y = 20 where low <= x <= high and z >= bottom: vertices strictly
    /// inside that rectangle (or on its rim on the skin) are doubled, the copies going to the side y > 20.
    struct Slit {
        mesh::TetMesh mesh;
        std::vector<mesh::LipFace> lips;
        mesh::Blade blade;
    };

    constexpr double kSpacing = 5.0;

    Slit slit_box(double low, double high, double bottom)
    {
        Slit slit;
        slit.mesh = mesh::kuhn_box(12, 8, 4, kSpacing);
        slit.blade = { { Vec3(low, 20, 20), Vec3(high, 20, 20) }, { Vec3(0, 0, -1) }, 20.0 - bottom, 10.0 };
        std::vector<VertexId> copy(slit.mesh.vertex_count(), -1);
        std::vector<Vec3> born;
        for (Eigen::Index v = 0; v < slit.mesh.vertices.rows(); ++v) {
            const Vec3 p = slit.mesh.vertices.row(v).transpose();
            if (p.y() == 20.0 && p.x() > low && p.x() < high && p.z() > bottom) {
                copy[static_cast<std::size_t>(v)] = static_cast<VertexId>(slit.mesh.vertex_count() + born.size());
                born.push_back(p);
            }
        }
        const Eigen::Index first = slit.mesh.vertices.rows();
        slit.mesh.vertices.conservativeResize(first + static_cast<Eigen::Index>(born.size()), 3);
        for (std::size_t i = 0; i < born.size(); ++i)
            slit.mesh.vertices.row(first + static_cast<Eigen::Index>(i)) = born[i].transpose();
        for (TetId t = 0; t < static_cast<TetId>(slit.mesh.tet_count()); ++t) {
            double y = 0.0;
            for (const VertexId v : slit.mesh.tet(t))
                y += 0.25 * slit.mesh.vertices(v, 1);
            for (std::size_t i = 0; i < 4 && y > 20.0; ++i) {
                VertexId& v = slit.mesh.nodes[4 * static_cast<std::size_t>(t) + i];
                if (copy[static_cast<std::size_t>(v)] >= 0)
                    v = copy[static_cast<std::size_t>(v)];
            }
        }
        for (const mesh::TetFace& face : mesh::boundary_faces(slit.mesh)) {
            bool on_blade = true;
            for (const VertexId v : mesh::face_vertices(slit.mesh, face))
                on_blade = on_blade && slit.mesh.vertices(v, 1) == 20.0;
            double y = 0.0;
            for (const VertexId v : slit.mesh.tet(face.tet))
                y += 0.25 * slit.mesh.vertices(v, 1);
            if (on_blade)
                slit.lips.push_back({ face, y > 20.0 ? +1 : -1, 0 });
        }
        return slit;
    }

    TEST(WoundEdges, SlitThatOpensToATriangle)
    {
        const Slit slit = slit_box(15.0, 45.0, 10.0);
        const WoundEdges edges = wound_edges(slit.mesh, slit.lips, mesh::SweptBlade(slit.blade));
        ASSERT_EQ(edges.left.vertices.size(), 7U); // 30 mm in steps of 5
        ASSERT_EQ(edges.right.vertices.size(), 7U);
        EXPECT_NEAR((edges.outward - Vec3::UnitZ()).norm(), 0.0, 1e-6);
        for (std::size_t i = 0; i < 7; ++i)
            for (const WoundEdge* edge : { &edges.left, &edges.right }) {
                EXPECT_NEAR(edge->along_mm[i], kSpacing * static_cast<double>(i), 1e-9);
                EXPECT_EQ(slit.mesh.vertices(edge->vertices[i], 2), 20.0);
            }
        EXPECT_EQ(edges.left.vertices.front(), edges.right.vertices.front()); // the lips meet at the ends
        EXPECT_EQ(edges.left.vertices.back(), edges.right.vertices.back());

        const OpeningGeometry closed = opening_geometry(edges, slit.mesh, {});
        EXPECT_EQ(closed.area_mm2, 0.0);
        EXPECT_EQ(closed.width_mm, 0.0);
        EXPECT_NEAR(closed.incision_length_mm, 30.0, 1e-9);

        Points pulled = Points::Zero(slit.mesh.vertices.rows(), 3);
        for (std::size_t i = 1; i < 6; ++i) {
            const double pull = 5.0 - std::abs(static_cast<double>(i) - 3.0) * 5.0 / 3.0;
            pulled(edges.left.vertices[i], 1) = pull; // the left of a cut along x, seen from above, is +y
            pulled(edges.right.vertices[i], 1) = -pull;
        }
        const OpeningGeometry open = opening_geometry(edges, slit.mesh, pulled);
        EXPECT_NEAR(open.area_mm2, 150.0, 1e-9); // a rhombus of 30 by 10
        EXPECT_NEAR(open.width_mm, 10.0, 1e-9);
        EXPECT_NEAR(open.incision_length_mm, 30.0, 1e-9);
        EXPECT_NEAR((open.centre - Vec3(30, 20, 20)).norm(), 0.0, 1e-9);
        EXPECT_NEAR((open.normal - Vec3::UnitZ()).norm(), 0.0, 1e-9);
    }

    TEST(WoundEdges, CutThroughAndOffBothEndsTakesTheSkinOnly)
    {
        const Slit slit = slit_box(-10.0, 70.0, -5.0); // two pieces: the rim runs round top, ends and bottom
        const WoundEdges edges = wound_edges(slit.mesh, slit.lips, mesh::SweptBlade(slit.blade));
        for (const WoundEdge* edge : { &edges.left, &edges.right }) {
            ASSERT_EQ(edge->vertices.size(), 13U);
            for (const VertexId v : edge->vertices)
                EXPECT_EQ(slit.mesh.vertices(v, 2), 20.0);
        }
        Points apart = Points::Zero(slit.mesh.vertices.rows(), 3);
        for (const VertexId v : edges.left.vertices)
            apart(v, 1) = 8.0;
        const OpeningGeometry open = opening_geometry(edges, slit.mesh, apart);
        EXPECT_NEAR(open.area_mm2, 60.0 * 8.0, 1e-9);
        EXPECT_NEAR(open.width_mm, 8.0, 1e-9);
    }

    TEST(WoundEdges, AShardAboveTheSkinDoesNotStandForItsEdge)
    {
        Slit slit = slit_box(15.0, 45.0, 10.0);
        const WoundEdges whole = wound_edges(slit.mesh, slit.lips, mesh::SweptBlade(slit.blade));
        // A tetrahedron of skin that the cut has left beside the edge, 1 mm above it, over 4 of its 30 mm.
        const auto first = static_cast<VertexId>(slit.mesh.vertices.rows());
        const Vec3 on_edge = point_at(slit.mesh.vertices, whole.left.vertices[2]);
        slit.mesh.vertices.conservativeResize(first + 4, 3);
        const Vec3 corners[] = { on_edge + Vec3(0.0, 0.0, 1.0), on_edge + Vec3(4.0, 0.0, 1.0),
            on_edge + Vec3(2.0, 2.0, 1.0), on_edge + Vec3(2.0, 0.0, -0.5) };
        for (int n = 0; n < 4; ++n)
            slit.mesh.vertices.row(first + n) = corners[n].transpose();
        std::array<VertexId, 4> tet { first, first + 1, first + 2, first + 3 };
        if (!((corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(corners[3] - corners[0]) > 0.0))
            std::swap(tet[0], tet[1]);
        slit.mesh.nodes.insert(slit.mesh.nodes.end(), tet.begin(), tet.end());
        slit.mesh.labels.push_back(slit.mesh.labels.front());
        // Its face in the plane of the cut is a lip: the face opposite to the third corner.
        const auto element = static_cast<TetId>(slit.mesh.tet_count() - 1);
        const int corner = static_cast<int>(std::find(tet.begin(), tet.end(), first + 2) - tet.begin());
        slit.lips.push_back({ .face = { element, corner }, .side = 1, .cut = 0 });
        const WoundEdges edges = wound_edges(slit.mesh, slit.lips, mesh::SweptBlade(slit.blade));
        EXPECT_EQ(edges.left.vertices, whole.left.vertices);
        EXPECT_NEAR(opening_geometry(edges, slit.mesh, {}).incision_length_mm, 30.0, 1e-9);
    }

    TEST(WoundEdges, PartsOfAnEdgeThatOverlapALittleAreJoined)
    {
        Slit slit = slit_box(15.0, 45.0, 10.0);
        const mesh::SweptBlade blade(slit.blade);
        const std::vector<VertexId> rim = wound_edges(slit.mesh, slit.lips, blade).left.vertices;
        ASSERT_EQ(rim.size(), 7U);
        // Between the fourth and the fifth vertex the lip is lost, and the fifth lies 1 mm before the fourth.
        std::erase_if(slit.lips, [&](const mesh::LipFace& lip) {
            const auto corners = mesh::face_vertices(slit.mesh, lip.face);
            return lip.side == 1 && std::ranges::count(corners, rim[3]) + std::ranges::count(corners, rim[4]) == 2;
        });
        slit.mesh.vertices(rim[4], 0) = slit.mesh.vertices(rim[3], 0) - 1.0;
        const WoundEdge edge = wound_edges(slit.mesh, slit.lips, blade).left;
        std::vector<VertexId> joined = rim;
        joined.erase(joined.begin() + 4); // it lies beside the end of the first part
        EXPECT_EQ(edge.vertices, joined);
        EXPECT_NEAR(edge.along_mm.front(), 0.0, 1e-9);
        EXPECT_NEAR(edge.along_mm.back(), 30.0, 1e-9);
    }

    TEST(WoundEdges, ObliqueCutInDomedSkin)
    {
        constexpr double kDome = 0.004; // 1/mm: the skin falls by 3 mm at the ends of the line
        mesh::TetMesh mesh = mesh::kuhn_box(24, 16, 5, 4.0);
        const auto drop
            = [](double x, double y) { return kDome * ((x - 48.0) * (x - 48.0) + (y - 32.0) * (y - 32.0)); };
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
            mesh.vertices(v, 2) -= drop(mesh.vertices(v, 0), mesh.vertices(v, 1));
        for (const double depth : { 9.0, 60.0 }) { // into the wall, and through it
            mesh::Blade blade { {}, { Vec3(0.1, 0.25, -1.0) }, depth, 10.0 };
            for (int i = 0; i <= 6; ++i) {
                const double x = 20.3 + 9.1 * i, y = 30.7 + 3.0 * std::sin(0.8 * i);
                blade.line.push_back(Vec3(x, y, 20.0 - drop(x, y)));
            }
            const mesh::SweptBlade swept(blade);
            const test_support::CutMesh wound = test_support::cut(mesh, blade);
            ASSERT_EQ(wound.status, mesh::CutStatus::done);
            const WoundEdges edges = wound_edges(wound.mesh, wound.lips, swept);
            ASSERT_EQ(edges.left.vertices.size(), edges.right.vertices.size());
            EXPECT_GT(edges.left.vertices.size(), 14U); // at least one per mesh cell crossed
            for (std::size_t i = 0; i < edges.left.vertices.size(); ++i) {
                const auto left = wound.mesh.vertices.row(edges.left.vertices[i]);
                EXPECT_EQ((left - wound.mesh.vertices.row(edges.right.vertices[i])).norm(), 0.0);
                const mesh::BladeCoordinates at = swept.coordinates(left.transpose());
                EXPECT_NEAR(at.side, 0.0, 1e-9);
                EXPECT_NEAR(at.depth, 0.0, 0.25); // the line is straight between its points, the skin is not
                EXPECT_TRUE(i == 0 || edges.left.along_mm[i] > edges.left.along_mm[i - 1]);
            }
            const OpeningGeometry closed = opening_geometry(edges, wound.mesh, {});
            EXPECT_NEAR(closed.incision_length_mm, swept.length(), 0.01 * swept.length());
            EXPECT_NEAR(closed.area_mm2, 0.0, 1e-9);
            EXPECT_GT(edges.outward.z(), 0.9);
            // The left lip moves by 6 mm along y, all but its two ends: 6 mm of field per mm of x, less two triangles
            // at the ends, each no longer than a mesh cell's diagonal.
            Points pulled = Points::Zero(wound.mesh.vertices.rows(), 3);
            for (std::size_t i = 1; i + 1 < edges.left.vertices.size(); ++i)
                pulled(edges.left.vertices[i], 1) = 6.0;
            const OpeningGeometry open = opening_geometry(edges, wound.mesh, pulled);
            EXPECT_LT(open.area_mm2, 6.0 * 6 * 9.1);
            EXPECT_GT(open.area_mm2, 6.0 * (6 * 9.1 - 4.0 * std::sqrt(2.0)));
            EXPECT_GT(open.normal.z(), 0.9);
            EXPECT_LE(open.width_mm, 6.0);
            EXPECT_GT(open.width_mm, 5.5); // where the wavy line runs along x
        }
    }

    template <class Call> std::string message_of(Call&& call)
    {
        try {
            call();
        } catch (const InputError& error) {
            return std::string(error.what()) + " | " + error.where();
        }
        return "nothing was thrown";
    }

    TEST(WoundEdges, RefusesLipsWithoutSkin)
    {
        const Slit slit = slit_box(15.0, 45.0, 10.0);
        const mesh::SweptBlade blade(slit.blade);
        EXPECT_EQ(message_of([&] { (void)wound_edges(slit.mesh, {}, blade); }),
            "the wound has no edge on the skin | left lip");
        std::vector<mesh::LipFace> lips = slit.lips;
        lips[0].face.tet = 1000000;
        EXPECT_EQ(message_of([&] { (void)wound_edges(slit.mesh, lips, blade); }),
            "a lip face is not a face of the mesh | element 1000000");
    }

    TEST(OpeningGeometry, RefusesBadInput)
    {
        const auto lips = ellipse(40.0, 12.0, 12.0, 10);
        const auto with_left = [&](auto&& change) {
            LipLine left = lips[0];
            change(left);
            return message_of([&] { (void)opening_geometry(left, lips[1], Vec3::UnitZ()); });
        };
        EXPECT_EQ(with_left([](LipLine& l) { l = {}; }), "a lip's edge needs at least two points | left lip");
        EXPECT_EQ(with_left([](LipLine& l) { l.along_mm.pop_back(); }),
            "a lip's edge needs one parameter per point | left lip");
        EXPECT_EQ(with_left([](LipLine& l) { l.points[3].y() = std::nan(""); }),
            "a lip's edge has a value that is not finite | left lip, point 3");
        EXPECT_EQ(with_left([](LipLine& l) { l.along_mm[4] = -100.0; }),
            "a lip's parameter runs backwards | left lip, point 4");
        EXPECT_NE(message_of([&] { (void)opening_geometry(lips[0], lips[1], Vec3::Zero()); }), "nothing was thrown");
        const Slit slit = slit_box(15.0, 45.0, 10.0);
        const WoundEdges edges = wound_edges(slit.mesh, slit.lips, mesh::SweptBlade(slit.blade));
        EXPECT_NE(
            message_of([&] { (void)opening_geometry(edges, slit.mesh, Points::Zero(2, 3)); }), "nothing was thrown");
        EXPECT_THROW((void)surface_centre({}), InputError);
    }

} // namespace field_geometry_test
} // namespace retractor::planner
