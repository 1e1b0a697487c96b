#include "planner/measures/bones/joint_loads.h"

#include "mesh/base/assert.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <set>
#include <vector>

namespace retractor::planner {

namespace {

    constexpr double kNmPerNmm = 1e-3;

    struct PointForce {
        Vec3 at = Vec3::Zero(), force = Vec3::Zero();
    };

    /// The sum of forces, and of their moments about the mean of their points, with a couple (N mm) beside them.
    std::optional<JointLoad> sum_of(const std::vector<PointForce>& forces, const Vec3& couple = Vec3::Zero())
    {
        if (forces.empty())
            return std::nullopt;
        Vec3 middle = Vec3::Zero(), force = Vec3::Zero(), moment = couple;
        for (const PointForce& point : forces)
            middle += point.at / static_cast<double>(forces.size());
        for (const PointForce& point : forces) {
            force += point.force;
            moment += (point.at - middle).cross(point.force);
        }
        return JointLoad { .force_N = force.norm(), .moment_Nm = kNmPerNmm * moment.norm() };
    }

} // namespace

std::optional<JointLoad> spine_joint_load(const BoneForces& bone, const mesh::TetMesh& wall,
    const fem::Supports& supports, const Eigen::VectorXd& displacement)
{
    const auto node_of_bone = [&](VertexId v) -> std::optional<VertexId> {
        const auto node = std::lower_bound(bone.node_of.begin(), bone.node_of.end(), v);
        if (node == bone.node_of.end() || *node != v)
            return std::nullopt;
        return static_cast<VertexId>(node - bone.node_of.begin());
    };
    std::vector<PointForce> forces;
    for (const fem::BeddedVertex& spring : supports.bedded)
        if (const auto node = node_of_bone(spring.vertex)) {
            const Vec3 u = displacement.segment<3>(3 * static_cast<Eigen::Index>(spring.vertex));
            forces.push_back({ point_at(bone.positions, *node), -spring.stiffness * u });
        }
    Vec3 couple = Vec3::Zero();
    const fem::Hinge* first = nullptr;
    for (const fem::Hinge& hinge : supports.hinges) {
        if (hinge.edges.empty() || !node_of_bone(hinge.edges.front().a) || !node_of_bone(hinge.edges.front().b))
            continue;
        Eigen::VectorXd of_hinge = Eigen::VectorXd::Zero(displacement.size());
        (void)fem::add_hinge_response(wall, hinge, fem::HingeAngle::swept, displacement, of_hinge);
        std::set<VertexId> nodes;
        for (const fem::HingeEdge& edge : hinge.edges)
            nodes.insert({ edge.a, edge.b });
        for (const VertexId v : nodes) // the forces of a hinge have no sum
            if (const auto node = node_of_bone(v))
                couple -= point_at(bone.positions, *node).cross(of_hinge.segment<3>(3 * static_cast<Eigen::Index>(v)));
        if (first == nullptr)
            first = &hinge;
    }
    std::optional<JointLoad> load = sum_of(forces, couple);
    if (load && first != nullptr) {
        const double turn = fem::hinge_turn(wall, *first, displacement);
        load->turn_deg = std::abs(turn) * 180.0 / std::numbers::pi;
        load->at_stop = std::abs(turn) > first->range;
    }
    return load;
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
