#include "planner/wall/rib_joints.h"

#include "mesh/base/assert.h"
#include "mesh/base/disjoint_sets.h"
#include "mesh/image/skeleton.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

namespace retractor::planner {

namespace {

    /// A vertex of a joint.
    struct JointVertex {
        VertexId id = 0;
        Vec3 place = Vec3::Zero();
        double share = 0.0; ///< mm^3: volume of bone round the vertex, less with the distance from the spine
        double distance = 0.0; ///< from the spine, mm
    };

    /// Springs whose stiffness falls with the squared distance from the joint's middle, at the rate `decay` (1/mm^2).
    std::vector<double> springs(const std::vector<JointVertex>& joint, const Vec3& middle, double decay)
    {
        std::vector<double> stiffness;
        double sum = 0.0;
        for (const JointVertex& vertex : joint) {
            stiffness.push_back(vertex.share * std::exp(-decay * (vertex.place - middle).squaredNorm()));
            sum += stiffness.back();
        }
        for (double& k : stiffness)
            k *= kJointN_per_mm / sum;
        return stiffness;
    }

    /// Resistance to turning about the springs' own centre, the mean over all axes, N mm / rad.
    double turning(const std::vector<JointVertex>& joint, const std::vector<double>& stiffness)
    {
        Vec3 centre = Vec3::Zero();
        for (std::size_t i = 0; i < joint.size(); ++i)
            centre += stiffness[i] / kJointN_per_mm * joint[i].place;
        double sum = 0.0;
        for (std::size_t i = 0; i < joint.size(); ++i)
            sum += stiffness[i] * (joint[i].place - centre).squaredNorm();
        return 2.0 / 3.0 * sum;
    }

    std::vector<fem::BeddedVertex> joint_springs(const std::vector<JointVertex>& joint)
    {
        Vec3 middle = Vec3::Zero();
        double sum = 0.0;
        for (const JointVertex& vertex : joint) {
            middle += vertex.share * vertex.place;
            sum += vertex.share;
        }
        middle /= sum;
        // Springs near the middle resist turning less. The rate is bisected between springs at the rim and at the
        // middle alone.
        double outer = -0.05, inner = 1.0;
        for (int halving = 0; halving < 50; ++halving) {
            const double decay = 0.5 * (outer + inner);
            (turning(joint, springs(joint, middle, decay)) > kJointNmm_per_rad ? outer : inner) = decay;
        }
        const std::vector<double> stiffness = springs(joint, middle, outer);
        std::vector<fem::BeddedVertex> beds;
        for (std::size_t i = 0; i < joint.size(); ++i)
            if (stiffness[i] > 1e-9 * kJointN_per_mm) // exp() may vanish
                beds.push_back({ joint[i].id, stiffness[i] });
        return beds;
    }

} // namespace

double distance_to_labels(
    const mesh::LabelVolume& labels, const mesh::LabelFlags& wanted, const Vec3& point, double reach)
{
    const Vec3 centre = labels.grid.index(point);
    std::array<int, 3> low {}, high {};
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        const double radius = reach / labels.grid.spacing[axis];
        low[a] = std::max(0, static_cast<int>(std::ceil(centre[axis] - radius)));
        high[a] = std::min(labels.grid.size[a] - 1, static_cast<int>(std::floor(centre[axis] + radius)));
    }
    double nearest = std::numeric_limits<double>::infinity();
    for (int k = low[2]; k <= high[2]; ++k)
        for (int j = low[1]; j <= high[1]; ++j)
            for (int i = low[0]; i <= high[0]; ++i)
                if (wanted[labels.voxels[labels.grid.offset(i, j, k)]] != 0)
                    nearest = std::min(nearest, labels.grid.spacing.cwiseProduct(Vec3(i, j, k) - centre).norm());
    return nearest <= reach ? nearest : std::numeric_limits<double>::infinity();
}

std::vector<fem::BeddedVertex> rib_joints(
    const mesh::TetMesh& mesh, const mesh::LabelVolume& labels, std::span<const Label> fixed_labels)
{
    RETRACTOR_ASSERT(mesh.nodes_per_tet == 4 && mesh.labels.size() == mesh.tet_count());
    const mesh::LabelFlags spine = mesh::flagged_labels(fixed_labels);
    const mesh::LabelFlags bone
        = mesh::flagged_labels(labels.table, [&](const mesh::LabelInfo& info) { return is_skeleton(info); });
    constexpr double kUnknown = -1.0;
    std::vector<double> distance(mesh.vertex_count(), kUnknown), volume(mesh.vertex_count(), 0.0);
    DisjointSets<std::size_t> parts(mesh.vertex_count());
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
        const Label label = mesh.labels[static_cast<std::size_t>(t)];
        if (bone[label] == 0 || spine[label] != 0)
            continue;
        std::optional<std::size_t> near;
        for (const VertexId v : mesh.tet(t)) {
            double& known = distance[static_cast<std::size_t>(v)];
            if (known == kUnknown)
                known = distance_to_labels(labels, spine, point_at(mesh.vertices, v), kJointReachMm);
            volume[static_cast<std::size_t>(v)] += 0.25 * mesh::tet_volume(mesh, t);
            if (known > kJointReachMm)
                continue;
            if (near)
                parts.join(*near, static_cast<std::size_t>(v));
            near = static_cast<std::size_t>(v);
        }
    }
    std::map<std::size_t, std::vector<JointVertex>> joints;
    for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
        if (const double here = distance[static_cast<std::size_t>(v)]; here != kUnknown && here < kJointReachMm)
            joints[parts.root(static_cast<std::size_t>(v))].push_back({ v, point_at(mesh.vertices, v),
                volume[static_cast<std::size_t>(v)] * (1.0 - here / kJointReachMm), here });
    std::vector<fem::BeddedVertex> beds;
    for (const auto& [root, joint] : joints) {
        if (std::ranges::min(joint, {}, &JointVertex::distance).distance > kJointGapMm)
            continue;
        const std::vector<fem::BeddedVertex> added = joint_springs(joint);
        beds.insert(beds.end(), added.begin(), added.end());
    }
    return beds;
}

} // namespace retractor::planner
