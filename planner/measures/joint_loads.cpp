#include "planner/measures/joint_loads.h"

#include "mesh/base/assert.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace retractor::planner {

namespace {

    constexpr double kNmPerNmm = 1e-3;

    struct PointForce {
        Vec3 at = Vec3::Zero(), force = Vec3::Zero();
    };

    /// The sum of forces, and of their moments about the mean of their points.
    std::optional<JointLoad> sum_of(const std::vector<PointForce>& forces)
    {
        if (forces.empty())
            return std::nullopt;
        Vec3 middle = Vec3::Zero(), force = Vec3::Zero(), moment = Vec3::Zero();
        for (const PointForce& point : forces)
            middle += point.at / static_cast<double>(forces.size());
        for (const PointForce& point : forces) {
            force += point.force;
            moment += (point.at - middle).cross(point.force);
        }
        return JointLoad { .force_N = force.norm(), .moment_Nm = kNmPerNmm * moment.norm() };
    }

} // namespace

std::optional<JointLoad> spring_load(
    const BoneForces& bone, std::span<const fem::BeddedVertex> bedded, const Eigen::VectorXd& displacement)
{
    std::vector<PointForce> forces;
    for (const fem::BeddedVertex& spring : bedded) {
        const auto node = std::lower_bound(bone.node_of.begin(), bone.node_of.end(), spring.vertex);
        if (node == bone.node_of.end() || *node != spring.vertex)
            continue;
        const Vec3 u = displacement.segment<3>(3 * static_cast<Eigen::Index>(spring.vertex));
        forces.push_back(
            { point_at(bone.positions, static_cast<VertexId>(node - bone.node_of.begin())), -spring.stiffness * u });
    }
    return sum_of(forces);
}

std::optional<JointLoad> cartilage_load(const BoneForces& bone, std::span<const std::uint8_t> is_cartilage)
{
    std::vector<PointForce> forces;
    for (std::size_t v = 0; v < bone.node_of.size(); ++v) {
        RETRACTOR_ASSERT(static_cast<std::size_t>(bone.node_of[v]) < is_cartilage.size());
        if (is_cartilage[static_cast<std::size_t>(bone.node_of[v])] != 0)
            forces.push_back({ point_at(bone.positions, static_cast<VertexId>(v)),
                point_at(bone.forces, static_cast<VertexId>(v)) });
    }
    return sum_of(forces);
}

} // namespace retractor::planner
