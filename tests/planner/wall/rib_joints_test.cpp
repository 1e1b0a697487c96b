// A rib as a curved bar of bone, whose joints are found in its labels and which is solved on its joints.
#include "planner/wall/rib_joints.h"

#include "fem/statics/elastic_problem.h"
#include "fem/statics/opening.h"
#include "tests/support/reference_problems.h"
#include "tests/verification/framework/meshes.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace retractor::planner {
namespace rib_joints_test {

    constexpr Label kRib = 1, kSpine = 2;
    constexpr double kDegree = std::numbers::pi / 180.0;
    constexpr double kNeckMm = 32.0, kRadiusMm = 70.0, kLengthMm = 150.0, kHalfWidth = 5.0, kHalfHeight = 4.0;
    constexpr double kModulus = 5000.0; // MPa: homogenised bone of a rib

    /// Place of the point at (s, y, z): along the rib, behind its middle line, and above.
    Vec3 on_rib(const Vec3& p)
    {
        const double turn = std::max(0.0, p.x() - kNeckMm) / kRadiusMm;
        const Vec3 centre(kNeckMm, -kRadiusMm, 0.0);
        if (turn == 0.0)
            return { p.x(), p.y(), p.z() };
        const double r = kRadiusMm + p.y();
        return centre + Vec3(r * std::sin(turn), r * std::cos(turn), p.z());
    }

    bool in_rib(const Vec3& p)
    {
        if (std::abs(p.z()) > kHalfHeight)
            return false;
        if (p.x() <= kNeckMm)
            return p.x() >= 0.0 && std::abs(p.y()) <= kHalfWidth;
        const double r = std::hypot(p.x() - kNeckMm, p.y() + kRadiusMm);
        const double turn = std::atan2(p.x() - kNeckMm, p.y() + kRadiusMm);
        return std::abs(r - kRadiusMm) <= kHalfWidth && turn <= (kLengthMm - kNeckMm) / kRadiusMm;
    }

    struct Rib {
        mesh::TetMesh mesh;
        mesh::LabelVolume labels;
        Eigen::Isometry3d pose;
    };

    /// @param process whether the spine has a transverse process behind the tubercle
    Rib rib(double edge, int pose, bool process = true)
    {
        Rib made { {}, {}, Eigen::Isometry3d::Identity() };
        if (pose == 1) {
            made.pose.translate(Vec3(31.0, -170.0, 1042.5));
            made.pose.rotate(Eigen::AngleAxisd(1.1, Vec3(0.4, 1.0, -0.6).normalized()));
        }
        const auto cells = [&](double length) { return std::max(2, static_cast<int>(std::lround(length / edge))); };
        const int nx = cells(kLengthMm), ny = cells(2.0 * kHalfWidth), nz = cells(2.0 * kHalfHeight);
        made.mesh = verification::mapped_box(4, nx, ny, nz, [&](const Vec3& p) {
            return Vec3(made.pose
                * on_rib({ p.x() / nx * kLengthMm, (2.0 * p.y() / ny - 1.0) * kHalfWidth,
                    (2.0 * p.z() / nz - 1.0) * kHalfHeight }));
        });
        std::fill(made.mesh.labels.begin(), made.mesh.labels.end(), kRib);
        made.labels.table
            = { { kRib, "rib_left_5", "bone", mesh::Role::wall }, { kSpine, "spine", "bone", mesh::Role::wall } };
        mesh::ImageGrid& grid = made.labels.grid;
        grid.spacing = Vec3(1.2, 1.2, 1.5);
        grid.size = { 130, 130, 25 };
        grid.direction = made.pose.linear();
        grid.origin = made.pose * Vec3(-22.0, -115.0, -18.0);
        made.labels.voxels.assign(grid.voxel_count(), 0);
        for (int k = 0; k < grid.size[2]; ++k)
            for (int j = 0; j < grid.size[1]; ++j)
                for (int i = 0; i < grid.size[0]; ++i) {
                    const Vec3 p = made.pose.inverse() * grid.world(Vec3(i, j, k));
                    Label& label = made.labels.voxels[grid.offset(i, j, k)];
                    if (in_rib(p))
                        label = kRib;
                    else if (p.x() < -2.0 || (process && p.y() > 7.0 && p.x() > 22.0 && p.x() < 30.0))
                        label = kSpine;
                }
        return made;
    }

    RibJoints joints_of(const Rib& rib) { return rib_joints(rib.mesh, rib.labels, std::array { kSpine }); }

    Vec3 spring_centre(const mesh::TetMesh& mesh, const RibJoints& joints)
    {
        Vec3 centre = Vec3::Zero();
        for (const fem::BeddedVertex& spring : joints.springs)
            centre += spring.stiffness / kJointN_per_mm * point_at(mesh.vertices, spring.vertex);
        return centre;
    }

    /// Dead forces on the vertices within 40 mm of the spine, with a moment (N mm) and no sum.
    Eigen::VectorXd moment_load(const mesh::TetMesh& mesh, const Vec3& centre, const Vec3& moment)
    {
        std::vector<VertexId> nodes;
        Vec3 middle = Vec3::Zero();
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if ((point_at(mesh.vertices, v) - centre).norm() < 30.0) {
                nodes.push_back(v);
                middle += point_at(mesh.vertices, v);
            }
        middle /= static_cast<double>(nodes.size());
        Mat3 inertia = Mat3::Zero();
        for (const VertexId v : nodes) {
            const Vec3 r = point_at(mesh.vertices, v) - middle;
            inertia += r.squaredNorm() * Mat3::Identity() - r * r.transpose();
        }
        const Vec3 rate = inertia.ldlt().solve(moment);
        Eigen::VectorXd load = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
        for (const VertexId v : nodes)
            load.segment<3>(3 * static_cast<Eigen::Index>(v)) = rate.cross(point_at(mesh.vertices, v) - middle);
        return load;
    }

    fem::OpeningResult solved(const Rib& rib, const RibJoints& joints, const Eigen::VectorXd& load)
    {
        const fem::Material bone = test_support::material(kModulus, 0.3);
        fem::Opening opening(rib.mesh, std::vector { bone, bone },
            fem::Supports { .bedded = joints.springs, .hinges = joints.hinges },
            { .elasticity = fem::Elasticity::corotational, .load = load });
        fem::OpeningResult result = opening.open({});
        EXPECT_EQ(result.status, fem::OpeningStatus::converged) << result.message;
        return result;
    }

    /// The turn about an axis of the vertices within 40 mm of the spine, degrees: by the best rotation of their
    /// displacement, and not by the hinge.
    double turn_of(const mesh::TetMesh& mesh, const Points& displacement, const Vec3& centre, const Vec3& axis)
    {
        Vec3 before = Vec3::Zero(), after = Vec3::Zero();
        std::vector<VertexId> nodes;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if ((point_at(mesh.vertices, v) - centre).norm() < 30.0) {
                nodes.push_back(v);
                before += point_at(mesh.vertices, v);
                after += point_at(mesh.vertices, v) + point_at(displacement, v);
            }
        before /= static_cast<double>(nodes.size());
        after /= static_cast<double>(nodes.size());
        double sine = 0.0, cosine = 0.0;
        for (const VertexId v : nodes) {
            const Vec3 p = point_at(mesh.vertices, v) - before;
            const Vec3 q = point_at(mesh.vertices, v) + point_at(displacement, v) - after;
            const Vec3 flat_p = p - axis * axis.dot(p), flat_q = q - axis * axis.dot(q);
            sine += axis.dot(flat_p.cross(flat_q));
            cosine += flat_p.dot(flat_q);
        }
        return std::atan2(sine, cosine) / kDegree;
    }

    constexpr std::array<double, 3> kEdges { 5.0, 4.0, 2.5 };

    TEST(RibJoints, ASingleRibTurnsByThePublishedAngleOnEveryMesh)
    {
        for (const double edge : kEdges)
            for (const int pose : { 0, 1 }) {
                const Rib one = rib(edge, pose);
                const RibJoints joints = joints_of(one);
                ASSERT_EQ(joints.hinges.size(), 1U);
                EXPECT_TRUE(joints.one_point.empty());
                const fem::Hinge& hinge = joints.hinges.front();
                EXPECT_EQ(hinge.name, "rib_left_5");
                const Vec3 along = one.pose.linear().transpose() * hinge.axis;
                EXPECT_GT(along.x(), 0.9) << along.transpose(); // from the head to the tubercle
                const Vec3 centre = spring_centre(one.mesh, joints);
                // A dead moment acts with its cosine.
                const double moment = 100.0 / std::cos(kJointRangeRad);
                double range = 0.0;
                constexpr double kNeckBends = 0.4; // degrees: the bone between joint and shaft bends, too
                for (const double sign : { 1.0, -1.0 }) {
                    const fem::OpeningResult result
                        = solved(one, joints, moment_load(one.mesh, centre, sign * moment * hinge.axis));
                    const double turn = turn_of(one.mesh, result.displacement, centre, hinge.axis);
                    range += sign * turn;
                    const Eigen::VectorXd u
                        = Eigen::Map<const Eigen::VectorXd>(result.displacement.data(), result.displacement.size());
                    EXPECT_NEAR(fem::hinge_turn(one.mesh, hinge, u) / kDegree, turn, kNeckBends);
                }
                EXPECT_NEAR(range, 13.2, 0.05 * 13.2) << "edge " << edge << ", pose " << pose;
            }
    }

    TEST(RibJoints, ARibStiffensBeyondItsRange)
    {
        for (const double edge : kEdges) {
            const Rib one = rib(edge, 1);
            const RibJoints joints = joints_of(one);
            const fem::Hinge& hinge = joints.hinges.front();
            const Vec3 centre = spring_centre(one.mesh, joints);
            constexpr double kBeyondNmm = 1000.0;
            const fem::OpeningResult result
                = solved(one, joints, moment_load(one.mesh, centre, kBeyondNmm * hinge.axis));
            const double turn = turn_of(one.mesh, result.displacement, centre, hinge.axis);
            EXPECT_GT(turn, 7.6);
            EXPECT_LT(turn, 20.0); // 66 degrees without a stop; the neck bends, too
        }
    }

    TEST(RibJoints, ARibGivesWayAsMeasured)
    {
        for (const double edge : kEdges) {
            const Rib one = rib(edge, 0);
            const RibJoints joints = joints_of(one);
            double sum = 0.0;
            for (const fem::BeddedVertex& spring : joints.springs)
                sum += spring.stiffness;
            EXPECT_NEAR(sum, kJointN_per_mm, 1e-6 * kJointN_per_mm);
            constexpr double kForceN = 10.0;
            for (const Vec3& direction : { Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ()) }) {
                Eigen::VectorXd load = Eigen::VectorXd::Zero(3 * one.mesh.vertices.rows());
                for (const fem::BeddedVertex& spring : joints.springs)
                    load.segment<3>(3 * static_cast<Eigen::Index>(spring.vertex))
                        = kForceN * spring.stiffness / sum * direction;
                const fem::OpeningResult result = solved(one, joints, load);
                double moved = 0.0;
                for (const fem::BeddedVertex& spring : joints.springs)
                    moved += spring.stiffness / sum * point_at(result.displacement, spring.vertex).dot(direction);
                EXPECT_GT(kForceN / moved, 18.0) << edge;
                EXPECT_LT(kForceN / moved, 26.0) << edge;
            }
        }
    }

    TEST(RibJoints, TheAxisIsThatOfThePlacesAndNotOfTheMesh)
    {
        for (const int pose : { 0, 1 }) {
            std::vector<Vec3> axes, centres;
            for (const double edge : { 8.0, 5.0, 4.0, 3.0, 2.5 }) {
                const Rib one = rib(edge, pose);
                const RibJoints joints = joints_of(one);
                ASSERT_EQ(joints.hinges.size(), 1U) << edge;
                axes.push_back(joints.hinges.front().axis);
                centres.push_back(spring_centre(one.mesh, joints));
                EXPECT_NO_THROW(fem::check_hinges(one.mesh, joints.hinges)) << edge;
            }
            for (std::size_t i = 0; i < axes.size(); ++i) {
                EXPECT_LT(std::acos(std::min(1.0, axes[i].dot(axes.back()))) / kDegree, 8.0) << i;
                EXPECT_LT((centres[i] - centres.back()).norm(), 2.0) << i;
            }
        }
    }

    TEST(RibJoints, WithoutATubercleTheRibTurnsAboutItsHeadAndIsNamed)
    {
        const Rib one = rib(4.0, 1, false);
        const RibJoints joints = joints_of(one);
        EXPECT_TRUE(joints.hinges.empty());
        EXPECT_EQ(joints.one_point, std::vector<std::string> { "rib_left_5" });
        EXPECT_NE(guessed_joints_text(joints).find("left rib 5"), std::string::npos);
        EXPECT_TRUE(guessed_joints_text({}).empty());
        double sum = 0.0;
        for (const fem::BeddedVertex& spring : joints.springs)
            sum += spring.stiffness;
        EXPECT_NEAR(sum, kJointN_per_mm, 1e-6 * kJointN_per_mm);
    }

} // namespace rib_joints_test
} // namespace retractor::planner
