#include "planner/wall/rib_joints.h"

#include "mesh/base/assert.h"
#include "mesh/base/segment.h"
#include "mesh/base/text_format.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace retractor::planner {

namespace {

    /// The springs of a place lie within this distance of the place, on about this many vertices at least.
    constexpr double kPlaceMm = 10.0;
    constexpr std::size_t kPlaceVertices = 6;
    /// Standard deviation of the springs' stiffness round a place, at first.
    constexpr double kSpreadMm = 3.0;
    /// The edges of a hinge have their middle within this distance of the axis, at least this number of edges.
    constexpr double kNeckRadiusMm = 8.0;
    constexpr std::size_t kHingeEdges = 12;
    /// Least length of a hinge's edge seen along the axis, over its length. Edges nearly along the axis tell little of
    /// the bone's turn about the axis.
    constexpr double kLeastAcross = 0.7;

    /// A vertex of a joint.
    struct JointVertex {
        VertexId id = 0;
        Vec3 place = Vec3::Zero();
        double share = 0.0; ///< mm^3: volume of bone round the vertex
    };

    double sum_of(const std::vector<double>& stiffness)
    {
        double sum = 0.0;
        for (const double k : stiffness)
            sum += k;
        return sum;
    }

    Vec3 centre_of(const std::vector<JointVertex>& joint, const std::vector<double>& stiffness)
    {
        Vec3 centre = Vec3::Zero();
        for (std::size_t i = 0; i < joint.size(); ++i)
            centre += stiffness[i] * joint[i].place;
        return centre / sum_of(stiffness);
    }

    // ---- a joint with one place ----

    /// Springs whose stiffness falls with the squared distance from the joint's middle, at the rate `decay` (1/mm^2).
    std::vector<double> round_springs(const std::vector<JointVertex>& joint, const Vec3& middle, double decay)
    {
        std::vector<double> stiffness;
        for (const JointVertex& vertex : joint)
            stiffness.push_back(vertex.share * std::exp(-decay * (vertex.place - middle).squaredNorm()));
        const double scale = kJointN_per_mm / sum_of(stiffness);
        for (double& k : stiffness)
            k *= scale;
        return stiffness;
    }

    /// Resistance to turning about the springs' own centre, the mean over all axes, N mm / rad.
    double mean_turning(const std::vector<JointVertex>& joint, const std::vector<double>& stiffness)
    {
        const Vec3 centre = centre_of(joint, stiffness);
        double sum = 0.0;
        for (std::size_t i = 0; i < joint.size(); ++i)
            sum += stiffness[i] * (joint[i].place - centre).squaredNorm();
        return 2.0 / 3.0 * sum;
    }

    std::vector<double> one_point_springs(const std::vector<JointVertex>& joint)
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
            (mean_turning(joint, round_springs(joint, middle, decay)) > kJointNmm_per_rad ? outer : inner) = decay;
        }
        return round_springs(joint, middle, outer);
    }

    // ---- a joint with two places ----

    /// Tilts weights by exp(tilt . (x - place)) until their centre is the place, as far as the vertices surround the
    /// place: the weights nearest in entropy [Jaynes 1957]. Without convergence the weights stay as they are.
    std::vector<double> centred(const std::vector<JointVertex>& near, std::vector<double> weight, const Vec3& place)
    {
        constexpr int kSteps = 40;
        constexpr double kStep = 0.3; // 1/mm: longer steps overshoot
        constexpr double kSteepest = 1.5; // 1/mm: a steeper tilt leaves single vertices
        constexpr double kCentredMm = 1e-6;
        Vec3 tilt = Vec3::Zero();
        for (int step = 0; step < kSteps; ++step) {
            std::vector<double> tilted = weight;
            Vec3 mean = Vec3::Zero();
            Mat3 square = Mat3::Zero();
            for (std::size_t i = 0; i < near.size(); ++i) {
                const Vec3 d = near[i].place - place;
                tilted[i] *= std::exp(tilt.dot(d));
                mean += tilted[i] * d;
                square += tilted[i] * d * d.transpose();
            }
            const double sum = sum_of(tilted);
            mean /= sum;
            if (mean.norm() < kCentredMm)
                return tilted;
            const Mat3 spread = square / sum - mean * mean.transpose() + 1e-9 * Mat3::Identity();
            Vec3 move = -spread.ldlt().solve(mean);
            if (move.norm() > kStep)
                move *= kStep / move.norm();
            tilt += move;
            if (!(tilt.norm() < kSteepest))
                break;
        }
        return weight;
    }

    /// Springs round one place with this sum. @param spread standard deviation of the stiffness, mm
    std::vector<double> place_springs(
        const std::vector<JointVertex>& bone, const Vec3& place, double spread, double stiffness)
    {
        std::vector<double> distance;
        for (const JointVertex& vertex : bone)
            distance.push_back((vertex.place - place).norm());
        std::vector<double> sorted = distance;
        std::ranges::sort(sorted);
        const double reach = std::max(kPlaceMm, sorted[std::min(kPlaceVertices, sorted.size()) - 1]);
        // Where vertices are sparse the nearest of them would bear nearly all; they share by a wider bell instead.
        const double wide = std::max(spread, 0.7 * sorted[std::min(std::size_t { 3 }, sorted.size()) - 1]);
        std::vector<JointVertex> near;
        std::vector<double> weight;
        std::vector<std::size_t> index;
        for (std::size_t i = 0; i < bone.size(); ++i)
            if (distance[i] <= reach) {
                near.push_back(bone[i]);
                index.push_back(i);
                weight.push_back(bone[i].share * std::exp(-0.5 * distance[i] * distance[i] / (wide * wide)));
            }
        weight = centred(near, std::move(weight), place);
        const double scale = stiffness / sum_of(weight);
        std::vector<double> all(bone.size(), 0.0);
        for (std::size_t n = 0; n < index.size(); ++n)
            all[index[n]] = scale * weight[n];
        return all;
    }

    /// The axis about which springs resist turning least, and their resistance about it.
    struct SpringAxis {
        Vec3 axis = Vec3::UnitX();
        double turning = 0.0; ///< N mm/rad
    };

    SpringAxis weakest_axis(
        const std::vector<JointVertex>& bone, const std::vector<double>& stiffness, const Vec3& towards)
    {
        const Vec3 centre = centre_of(bone, stiffness);
        Mat3 turning = Mat3::Zero();
        for (std::size_t i = 0; i < bone.size(); ++i) {
            const Vec3 d = bone[i].place - centre;
            turning += stiffness[i] * (d.squaredNorm() * Mat3::Identity() - d * d.transpose());
        }
        const Eigen::SelfAdjointEigenSolver<Mat3> principal(turning);
        const Vec3 axis = principal.eigenvectors().col(0);
        return { axis.dot(towards) < 0.0 ? Vec3(-axis) : axis, principal.eigenvalues()[0] };
    }

    /// The edges of bone round the line between both places, with shares in proportion to their squared length seen
    /// along the axis: each bears a force in proportion to this length.
    std::vector<fem::HingeEdge> neck_edges(const mesh::TetMesh& mesh,
        const std::set<std::pair<VertexId, VertexId>>& edges, const Vec3& axis, const Vec3& head, const Vec3& tubercle)
    {
        struct Candidate {
            fem::HingeEdge edge;
            double distance = 0.0;
        };
        std::vector<Candidate> candidates;
        for (const auto& [a, b] : edges) {
            const Vec3 from = point_at(mesh.vertices, a), to = point_at(mesh.vertices, b);
            const double width = axis.cross(to - from).norm();
            if (width >= kLeastAcross * (to - from).norm())
                candidates.push_back(
                    { { a, b, width * width }, distance_to_segment(0.5 * (from + to), head, tubercle) });
        }
        std::ranges::stable_sort(candidates, {}, &Candidate::distance);
        std::vector<fem::HingeEdge> chosen;
        double sum = 0.0;
        for (const Candidate& candidate : candidates)
            if (candidate.distance <= kNeckRadiusMm || chosen.size() < kHingeEdges) {
                chosen.push_back(candidate.edge);
                sum += candidate.edge.share;
            }
        for (fem::HingeEdge& edge : chosen)
            edge.share /= sum;
        return chosen;
    }

    // ---- all joints ----

    /// Vertices and edges of the elements with one label.
    struct BoneOfMesh {
        std::vector<JointVertex> vertices;
        std::set<std::pair<VertexId, VertexId>> edges;
    };

    /// The part of a bone within some distance of places.
    BoneOfMesh bone_near(const mesh::TetMesh& mesh, Label label, std::span<const Vec3> places, double reach)
    {
        const auto near = [&](VertexId v) {
            return std::ranges::any_of(
                places, [&](const Vec3& place) { return (point_at(mesh.vertices, v) - place).norm() <= reach; });
        };
        BoneOfMesh bone;
        std::map<VertexId, double> volume;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            if (mesh.labels[static_cast<std::size_t>(t)] != label)
                continue;
            const auto nodes = mesh.tet(t);
            if (std::ranges::none_of(nodes, near))
                continue;
            for (std::size_t i = 0; i < 4; ++i) {
                volume[nodes[i]] += 0.25 * mesh::tet_volume(mesh, t);
                for (std::size_t j = 0; j < i; ++j)
                    bone.edges.emplace(std::min(nodes[i], nodes[j]), std::max(nodes[i], nodes[j]));
            }
        }
        for (const auto& [v, share] : volume)
            bone.vertices.push_back({ v, point_at(mesh.vertices, v), share });
        return bone;
    }

    struct Joint {
        std::vector<JointVertex> vertices;
        std::vector<double> stiffness; ///< per vertex
        std::optional<fem::Hinge> hinge {};
    };

    Joint two_point_joint(const mesh::TetMesh& mesh, BoneOfMesh bone, const JointPlaces& places)
    {
        const auto springs = [&](double spread) {
            std::vector<double> sum = place_springs(bone.vertices, places.head, spread, 0.5 * kJointN_per_mm);
            const std::vector<double> other
                = place_springs(bone.vertices, *places.tubercle, spread, 0.5 * kJointN_per_mm);
            for (std::size_t i = 0; i < sum.size(); ++i)
                sum[i] += other[i];
            return sum;
        };
        const Vec3 towards = *places.tubercle - places.head;
        double spread = kSpreadMm;
        std::vector<double> stiffness = springs(spread);
        SpringAxis weakest = weakest_axis(bone.vertices, stiffness, towards);
        constexpr double kNarrower = 0.8, kNarrowestMm = 0.5;
        while (weakest.turning > kJointNmm_per_rad && spread > kNarrowestMm) {
            spread *= kNarrower;
            stiffness = springs(spread);
            weakest = weakest_axis(bone.vertices, stiffness, towards);
        }
        fem::Hinge hinge { .axis = weakest.axis,
            .stiffness = std::max(0.0, kJointNmm_per_rad - weakest.turning),
            .range = kJointRangeRad,
            .stop_stiffness = kStopNmm_per_rad,
            .toe = kStopToeRad,
            .edges = neck_edges(mesh, bone.edges, weakest.axis, places.head, *places.tubercle) };
        return { std::move(bone.vertices), std::move(stiffness), std::move(hinge) };
    }

    Joint one_point_joint(const mesh::LabelVolume& labels, const mesh::LabelFlags& spine, const BoneOfMesh& bone)
    {
        Joint joint;
        for (JointVertex vertex : bone.vertices) {
            const double distance = distance_to_labels(labels, spine, vertex.place, kJointReachMm);
            if (distance < kJointReachMm) {
                vertex.share *= 1.0 - distance / kJointReachMm;
                joint.vertices.push_back(vertex);
            }
        }
        if (!joint.vertices.empty())
            joint.stiffness = one_point_springs(joint.vertices);
        return joint;
    }

} // namespace

RibJoints rib_joints(const mesh::TetMesh& mesh, const mesh::LabelVolume& labels, std::span<const Label> fixed_labels)
{
    RETRACTOR_ASSERT(mesh.nodes_per_tet == 4 && mesh.labels.size() == mesh.tet_count());
    const mesh::LabelFlags spine = mesh::flagged_labels(fixed_labels);
    std::map<VertexId, double> springs;
    RibJoints joints;
    for (const JointPlaces& places : joint_places(labels, fixed_labels)) {
        constexpr double kRound = 2.0 * kJointReachMm; // the joint, and the nearest vertices of a coarse mesh
        std::vector<Vec3> points { places.head };
        if (places.tubercle)
            points.push_back(*places.tubercle);
        BoneOfMesh bone = bone_near(mesh, places.label, points, kRound);
        const auto has = [&](const Vec3& place) { // the mesh may hold another part of the bone only
            return std::ranges::any_of(
                bone.vertices, [&](const JointVertex& vertex) { return (vertex.place - place).norm() <= kPlaceMm; });
        };
        if (!has(places.head))
            continue;
        const mesh::LabelInfo* info = mesh::find_label(labels.table, places.label);
        const std::string name = info != nullptr ? info->name : "label " + std::to_string(places.label);
        const bool two = places.tubercle && has(*places.tubercle);
        Joint joint = two ? two_point_joint(mesh, std::move(bone), places) : one_point_joint(labels, spine, bone);
        for (std::size_t i = 0; i < joint.vertices.size(); ++i)
            if (joint.stiffness[i] > 1e-9 * kJointN_per_mm) // exp() may vanish
                springs[joint.vertices[i].id] += joint.stiffness[i];
        if (joint.hinge && !joint.hinge->edges.empty()) {
            joint.hinge->name = name;
            if (places.axis_of_neighbour)
                joints.neighbours_axis.push_back(name);
            joints.hinges.push_back(std::move(*joint.hinge));
        } else if (!joint.vertices.empty()) {
            joints.one_point.push_back(name);
        }
    }
    for (const auto& [v, stiffness] : springs)
        joints.springs.push_back({ v, stiffness });
    return joints;
}

std::string guessed_joints_text(const RibJoints& joints)
{
    std::string text;
    if (!joints.neighbours_axis.empty())
        text = "the labels show no joint of the tubercle with the spine for " + readable(joined(joints.neighbours_axis))
            + ": these ribs turn about the axis of the nearest rib that shows one";
    if (!joints.one_point.empty())
        text += (text.empty() ? "" : "; ") + std::string("the labels show one place of the joint with the spine for ")
            + readable(joined(joints.one_point))
            + ": these ribs turn about their heads, without an axis and without a stop";
    return text;
}

} // namespace retractor::planner
