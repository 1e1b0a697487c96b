#include "fem/model/hinge.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace retractor::fem {

namespace {

    using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

    /// Length of an edge seen along the axis, over its length at rest, below which the edge has no angle.
    constexpr double kLeastWidth = 1e-6;

    Vec3 across(const Vec3& axis, const Vec3& v) { return v - axis * axis.dot(v); }

    bool has_angle(const Vec3& axis, const Vec3& along)
    {
        return across(axis, along).norm() > kLeastWidth * along.norm();
    }

    Vec3 along(const mesh::TetMesh& mesh, const HingeEdge& edge)
    {
        return point_at(mesh.vertices, edge.b) - point_at(mesh.vertices, edge.a);
    }

    Vec3 stretch(const HingeEdge& edge, const Eigen::VectorXd& u)
    {
        return u.segment<3>(3 * static_cast<Eigen::Index>(edge.b))
            - u.segment<3>(3 * static_cast<Eigen::Index>(edge.a));
    }

    /// An edge that has turned: its angle, its width seen along the axis, and the unit vectors across the axis along
    /// the edge and in the direction in which the edge turns.
    struct TurnedEdge {
        double angle = 0.0, width = 0.0;
        Vec3 outward = Vec3::Zero(), round = Vec3::Zero();

        bool has_angle() const { return width > 0.0; }
    };

    TurnedEdge turned(const Hinge& hinge, HingeAngle angle, const Vec3& at_rest, const Vec3& stretched)
    {
        const Vec3 before = across(hinge.axis, at_rest);
        const Vec3 now = angle == HingeAngle::linear ? before : Vec3(before + across(hinge.axis, stretched));
        TurnedEdge edge { .width = now.norm() };
        if (!(edge.width > kLeastWidth * at_rest.norm()))
            return {};
        edge.outward = now / edge.width;
        edge.round = hinge.axis.cross(edge.outward);
        edge.angle = angle == HingeAngle::linear ? edge.round.dot(stretched) / edge.width
                                                 : std::atan2(hinge.axis.dot(before.cross(now)), before.dot(now));
        return edge;
    }

    HingeTorque torque_of(const Hinge& hinge, HingeAngle angle, double turn)
    {
        if (angle == HingeAngle::swept)
            return hinge_torque(hinge, turn);
        return { 0.5 * hinge.stiffness * turn * turn, hinge.stiffness * turn, hinge.stiffness };
    }

    /// The pairs of nodes, smaller one first, that are edges of hinges.
    std::set<std::pair<VertexId, VertexId>> pairs_of(std::span<const Hinge> hinges)
    {
        std::set<std::pair<VertexId, VertexId>> pairs;
        for (const Hinge& hinge : hinges)
            for (const HingeEdge& edge : hinge.edges)
                pairs.emplace(std::min(edge.a, edge.b), std::max(edge.a, edge.b));
        return pairs;
    }

    /// Removes the pairs whose nodes share an element.
    void erase_joined(const mesh::TetMesh& mesh, std::set<std::pair<VertexId, VertexId>>& pairs)
    {
        std::vector<std::uint8_t> wanted(mesh.vertex_count(), 0);
        for (const auto& [a, b] : pairs)
            for (const VertexId v : { a, b })
                if (v >= 0 && static_cast<std::size_t>(v) < wanted.size())
                    wanted[static_cast<std::size_t>(v)] = 1;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()) && !pairs.empty(); ++t) {
            const auto nodes = mesh.tet(t);
            for (std::size_t i = 0; i < nodes.size(); ++i)
                if (wanted[static_cast<std::size_t>(nodes[i])] != 0)
                    for (std::size_t j = 0; j < i; ++j)
                        if (wanted[static_cast<std::size_t>(nodes[j])] != 0)
                            pairs.erase({ std::min(nodes[i], nodes[j]), std::max(nodes[i], nodes[j]) });
        }
    }

    void check_hinge(const mesh::TetMesh& mesh, const Hinge& hinge, const std::string& where)
    {
        constexpr double kUnit = 1e-9; // round-off of a normalised vector, and of a sum of shares
        if (!(std::abs(hinge.axis.norm() - 1.0) <= kUnit))
            throw InputError("the axis of a hinge must be a unit vector", where);
        for (const double value : { hinge.stiffness, hinge.range, hinge.stop_stiffness })
            if (!(value >= 0.0 && std::isfinite(value)))
                throw InputError("a hinge's stiffness and range must be finite and not negative", where);
        if (!(hinge.toe > 0.0 && std::isfinite(hinge.toe)))
            throw InputError("the toe of a hinge's stop must be positive", where);
        double sum = 0.0;
        for (const HingeEdge& edge : hinge.edges) {
            if (!(edge.share > 0.0))
                throw InputError("the share of an edge in a hinge must be positive", where);
            sum += edge.share;
            if (!has_angle(hinge.axis, along(mesh, edge)))
                throw InputError("an edge of a hinge lies along the axis", where);
        }
        if (!(sum <= 1.0 + kUnit))
            throw InputError("the shares of a hinge's edges add up to more than one", where);
    }

    void add_block(BlockMatrix& matrix, VertexId row, VertexId column, const RowMat3& block)
    {
        const bool lower = row >= column;
        const auto r = static_cast<std::size_t>(std::max(row, column));
        const auto begin = matrix.pattern.column.begin() + matrix.pattern.row_start[r];
        const auto end = matrix.pattern.column.begin() + matrix.pattern.row_start[r + 1];
        const auto at = std::lower_bound(begin, end, std::min(row, column));
        RETRACTOR_ASSERT(at != end && *at == std::min(row, column));
        double* values = matrix.values.data() + 9 * (at - matrix.pattern.column.begin());
        Eigen::Map<RowMat3> target(values);
        if (lower)
            target += block;
        else
            target += block.transpose();
    }

} // namespace

HingeTorque hinge_torque(const Hinge& hinge, double angle)
{
    HingeTorque sum { 0.5 * hinge.stiffness * angle * angle, hinge.stiffness * angle, hinge.stiffness };
    const double beyond = std::abs(angle) - hinge.range;
    if (!(beyond > 0.0) || hinge.stop_stiffness == 0.0)
        return sum;
    const double K = hinge.stop_stiffness, l = hinge.toe;
    HingeTorque stop;
    if (beyond < 2.0 * l) {
        stop = { K * beyond * beyond * beyond / (12.0 * l), K * beyond * beyond / (4.0 * l), K * beyond / (2.0 * l) };
    } else {
        const double energy_of_toe = 2.0 / 3.0 * K * l * l;
        stop = { energy_of_toe + 0.5 * K * ((beyond - l) * (beyond - l) - l * l), K * (beyond - l), K };
    }
    sum.energy += stop.energy;
    sum.torque += std::copysign(stop.torque, angle);
    sum.stiffness += stop.stiffness;
    return sum;
}

void check_hinges(const mesh::TetMesh& mesh, std::span<const Hinge> hinges)
{
    auto pairs = pairs_of(hinges);
    erase_joined(mesh, pairs);
    for (const Hinge& hinge : hinges) {
        const std::string where = "hinge of " + hinge.name;
        for (const HingeEdge& edge : hinge.edges)
            if (edge.a == edge.b || pairs.contains({ std::min(edge.a, edge.b), std::max(edge.a, edge.b) }))
                throw InputError("nodes " + std::to_string(edge.a) + " and " + std::to_string(edge.b)
                        + " of a hinge's edge share no element",
                    where);
        check_hinge(mesh, hinge, where);
    }
}

std::vector<Hinge> hinges_within(const mesh::TetMesh& mesh, std::vector<Hinge> hinges)
{
    auto parted = pairs_of(hinges);
    erase_joined(mesh, parted);
    for (Hinge& hinge : hinges)
        std::erase_if(hinge.edges, [&](const HingeEdge& edge) {
            return edge.a < 0 || edge.b < 0 || parted.contains({ std::min(edge.a, edge.b), std::max(edge.a, edge.b) })
                || !has_angle(hinge.axis, along(mesh, edge));
        });
    std::erase_if(hinges, [](const Hinge& hinge) { return hinge.edges.empty(); });
    return hinges;
}

std::vector<Hinge> joined_hinges(const mesh::TetMesh& mesh, std::vector<Hinge> hinges)
{
    hinges = hinges_within(mesh, std::move(hinges));
    for (Hinge& hinge : hinges) {
        double sum = 0.0;
        for (const HingeEdge& edge : hinge.edges)
            sum += edge.share;
        for (HingeEdge& edge : hinge.edges)
            edge.share /= sum;
    }
    return hinges;
}

double hinge_turn(const mesh::TetMesh& mesh, const Hinge& hinge, const Eigen::VectorXd& displacement)
{
    double mean = 0.0;
    for (const HingeEdge& edge : hinge.edges)
        mean += edge.share * turned(hinge, HingeAngle::swept, along(mesh, edge), stretch(edge, displacement)).angle;
    return mean;
}

double add_hinge_response(const mesh::TetMesh& mesh, const Hinge& hinge, HingeAngle angle,
    const Eigen::VectorXd& displacement, Eigen::VectorXd& forces)
{
    double energy = 0.0;
    for (const HingeEdge& edge : hinge.edges) {
        const TurnedEdge now = turned(hinge, angle, along(mesh, edge), stretch(edge, displacement));
        if (!now.has_angle())
            return std::numeric_limits<double>::infinity();
        const HingeTorque there = torque_of(hinge, angle, now.angle);
        energy += edge.share * there.energy;
        const Vec3 force = edge.share * there.torque / now.width * now.round;
        forces.segment<3>(3 * static_cast<Eigen::Index>(edge.b)) += force;
        forces.segment<3>(3 * static_cast<Eigen::Index>(edge.a)) -= force;
    }
    return energy;
}

void add_hinge_stiffness(const mesh::TetMesh& mesh, const Hinge& hinge, HingeAngle angle,
    const Eigen::VectorXd& displacement, double projected, BlockMatrix& stiffness)
{
    for (const HingeEdge& edge : hinge.edges) {
        const TurnedEdge now = turned(hinge, angle, along(mesh, edge), stretch(edge, displacement));
        if (!now.has_angle())
            continue; // the energy is infinite, and no step ends here
        const HingeTorque there = torque_of(hinge, angle, now.angle);
        // In the directions outward and round: [0, -m; -m, k], with one negative eigenvalue unless m is zero.
        const double k = edge.share * there.stiffness / (now.width * now.width);
        const double m = angle == HingeAngle::linear ? 0.0 : edge.share * there.torque / (now.width * now.width);
        RowMat3 block = k * now.round * now.round.transpose()
            - m * (now.outward * now.round.transpose() + now.round * now.outward.transpose());
        if (m != 0.0 && projected > 0.0) {
            const double largest = 0.5 * k + std::hypot(0.5 * k, m);
            const double lowest = -m * m / largest;
            const Vec3 direction = (m * now.outward - lowest * now.round).normalized();
            block += projected * -lowest * direction * direction.transpose();
        }
        add_block(stiffness, edge.a, edge.a, block);
        add_block(stiffness, edge.b, edge.b, block);
        add_block(stiffness, edge.b, edge.a, -block);
    }
}

Vec3 hinge_spring(const Hinge& hinge, const HingeEdge& edge, const Vec3& along)
{
    const TurnedEdge rest = turned(hinge, HingeAngle::linear, along, Vec3::Zero());
    return std::sqrt(edge.share * hinge.stiffness) / rest.width * rest.round;
}

} // namespace retractor::fem
