#include "fem/model/blade_contact.h"

#include "fem/element/tet_element.h"
#include "fem/model/contact.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace retractor::fem {

namespace {

    constexpr double kNeverMPa = 1e9; ///< no tissue bears this stress

    using Vec12 = Eigen::Matrix<double, 12, 1>; // the place of the sample, and the three nodes of the blade
    using Mat12 = Eigen::Matrix<double, 12, 12>;

    void check(const mesh::TetMesh& mesh, const BladeSurface& blade)
    {
        const std::string where = "blade '" + blade.name + "'";
        for (const VertexId v : blade.nodes)
            if (v < 0 || v >= mesh.vertices.rows())
                throw InputError("node " + std::to_string(v) + " is out of range", where);
        if (!(blade.half_width_mm > 0.0 && std::isfinite(blade.half_width_mm) && blade.half_height_mm > 0.0
                && std::isfinite(blade.half_height_mm)))
            throw InputError("a blade needs a positive width and height", where);
        if (!(blade.friction >= 0.0 && std::isfinite(blade.friction)))
            throw InputError("the friction of a blade must be finite and not negative", where);
        constexpr double kSkew = 1e-6; // of the sides' lengths and of the cosine between them
        const Vec3 middle = point_at(mesh.vertices, blade.nodes[0]);
        const Vec3 along = point_at(mesh.vertices, blade.nodes[1]) - middle,
                   deep = point_at(mesh.vertices, blade.nodes[2]) - middle;
        if (!(std::abs(along.norm() - blade.half_width_mm) <= kSkew * blade.half_width_mm
                && std::abs(deep.norm() - blade.half_height_mm) <= kSkew * blade.half_height_mm
                && std::abs(along.dot(deep)) <= kSkew * along.norm() * deep.norm()))
            throw InputError("the nodes of the blade are not its middle and the ends of its half sides", where);
        for (const BladeSample& sample : blade.samples) {
            if (sample.tet < 0 || static_cast<std::size_t>(sample.tet) >= mesh.tet_count())
                throw InputError("element " + std::to_string(sample.tet) + " is out of range", where);
            if (!(sample.area > 0.0 && sample.stiffness > 0.0 && std::isfinite(sample.area)
                    && std::isfinite(sample.stiffness) && std::isfinite(sample.bears_at_mm)))
                throw InputError("a sample of the blade has a number that is out of range", where);
        }
    }

    /// Fades from 1 to 0 where `beyond` (mm beyond the edge) goes from minus half of the band to plus half of it.
    double fade(double beyond)
    {
        const double t = std::clamp(0.5 - beyond / kBladeFadeMm, 0.0, 1.0);
        return t * t * (3.0 - 2.0 * t);
    }

    /// The way of a point along an axis of the blade that goes from its middle through another of its nodes.
    struct AxisWay {
        Vec3 axis; ///< unit
        Vec3 across_by_length; ///< part of the point's place across the axis, over the length of the axis
        double way, length;

        AxisWay(const Vec3& from_middle, const Vec3& unit, double length_mm)
            : axis(unit)
            , across_by_length((from_middle - unit * unit.dot(from_middle)) / length_mm)
            , way(unit.dot(from_middle))
            , length(length_mm)
        {
        }

        /// @param node 1 or 2: the node through which the axis goes
        Vec12 gradient(int node) const
        {
            Vec12 g = Vec12::Zero();
            g.head<3>() = axis;
            g.segment<3>(3) = -axis - across_by_length;
            g.segment<3>(3 + 3 * node) = across_by_length;
            return g;
        }

        Mat12 hessian(int node) const
        {
            const Mat3 P = Mat3::Identity() - axis * axis.transpose();
            const Mat3 mixed = P / length;
            const Mat3 own = -(axis * across_by_length.transpose() + across_by_length * axis.transpose()) / length
                - way * P / (length * length);
            Mat12 H = Mat12::Zero();
            const int at = 3 + 3 * node;
            // by the point and the middle through their difference, by the axis through its end and the middle
            H.block<3, 3>(0, at) = mixed;
            H.block<3, 3>(0, 3) = -mixed;
            H.block<3, 3>(at, at) = own;
            H.block<3, 3>(3, at) = -mixed - own;
            H.block<3, 3>(3, 3) = 2.0 * mixed + own;
            H.block<3, 3>(at, 0) = H.block<3, 3>(0, at).transpose();
            H.block<3, 3>(3, 0) = H.block<3, 3>(0, 3).transpose();
            H.block<3, 3>(at, 3) = H.block<3, 3>(3, at).transpose();
            return H;
        }
    };

    /// A spring that slips: its stress by the way, and the derivative of the stress.
    struct Stick {
        Eigen::Vector2d stress = Eigen::Vector2d::Zero(); ///< MPa
        Eigen::Matrix2d slope = Eigen::Matrix2d::Zero(); ///< N/mm^3, not negative
        double energy = 0.0; ///< N/mm
        double secant = 0.0; ///< stress over way, N/mm^3

        Stick(const Eigen::Vector2d& way, double stiffness, double slips_at)
        {
            const double r = way.norm();
            if (slips_at <= 0.0)
                return;
            if (stiffness * r <= slips_at) {
                stress = stiffness * way;
                slope = stiffness * Eigen::Matrix2d::Identity();
                energy = 0.5 * stiffness * r * r;
                secant = stiffness;
                return;
            }
            const Eigen::Vector2d direction = way / r;
            stress = slips_at * direction;
            slope = slips_at / r * (Eigen::Matrix2d::Identity() - direction * direction.transpose());
            energy = slips_at * (r - 0.5 * slips_at / stiffness);
            secant = slips_at / r;
        }
    };

} // namespace

BladeContact::BladeContact(const mesh::TetMesh& mesh, std::vector<BladeSurface> blades)
    : rest_(mesh.vertices)
    , blades_(std::move(blades))
    , groups_(blades_.size())
{
    constexpr double kNothing = 1e-12; // weight of a node that is not on the face of the sample
    first_.push_back(0);
    const Eigen::VectorXd at_rest = Eigen::VectorXd::Zero(3 * rest_.rows());
    for (std::size_t b = 0; b < blades_.size(); ++b) {
        check(mesh, blades_[b]);
        for (const BladeSample& given : blades_[b].samples) {
            Sample sample { .blade = static_cast<std::int32_t>(b), .begin = static_cast<std::int32_t>(node_.size()) };
            const Eigen::VectorXd weights = shape_values(mesh, given.tet, given.barycentric);
            const auto nodes = mesh.tet(given.tet);
            for (std::size_t a = 0; a < nodes.size(); ++a)
                if (const double weight = weights[static_cast<Eigen::Index>(a)]; std::abs(weight) > kNothing) {
                    node_.push_back(nodes[a]);
                    weight_.push_back(weight);
                }
            sample.end = static_cast<std::int32_t>(node_.size());
            samples_.push_back(sample);
        }
        first_.push_back(samples_.size());
    }
    const std::vector<Pose> all = poses(at_rest);
    for (std::size_t i = 0; i < samples_.size(); ++i) {
        const Place there = place(at_rest, all[static_cast<std::size_t>(samples_[i].blade)], i);
        samples_[i].along_at_rest = there.along;
        samples_[i].deep_at_rest = there.deep;
        samples_[i].share = share_at(there, static_cast<std::size_t>(samples_[i].blade));
        groups_[static_cast<std::size_t>(samples_[i].blade)][given(i).bone ? 1 : 0].area
            += given(i).area * samples_[i].share;
    }
}

const BladeSample& BladeContact::given(std::size_t sample) const
{
    const auto blade = static_cast<std::size_t>(samples_[sample].blade);
    return blades_[blade].samples[sample - first_[blade]];
}

const BladeContact::Group& BladeContact::group(std::size_t sample) const
{
    return groups_[static_cast<std::size_t>(samples_[sample].blade)][given(sample).bone ? 1 : 0];
}

double BladeContact::slips_at(std::size_t sample) const
{
    const Group& of = group(sample);
    if (of.slips)
        return of.slips_at;
    return blades_[static_cast<std::size_t>(samples_[sample].blade)].friction > 0.0 ? kNeverMPa : 0.0;
}

Vec3 BladeContact::moved(VertexId v, const Eigen::VectorXd& u) const
{
    return rest_.row(v).transpose() + u.segment<3>(3 * static_cast<Eigen::Index>(v));
}

BladeContact::Pose BladeContact::pose(const Eigen::VectorXd& u, std::size_t blade) const
{
    Pose p;
    for (std::size_t i = 0; i < p.node.size(); ++i)
        p.node[i] = moved(blades_[blade].nodes[i], u);
    p.along = p.node[1] - p.node[0];
    p.deep = p.node[2] - p.node[0];
    p.along_mm = p.along.norm();
    p.deep_mm = p.deep.norm();
    p.normal = p.along.cross(p.deep).normalized();
    p.along /= p.along_mm;
    p.deep /= p.deep_mm;
    return p;
}

std::vector<BladeContact::Pose> BladeContact::poses(const Eigen::VectorXd& u) const
{
    RETRACTOR_ASSERT(u.size() == 3 * rest_.rows());
    std::vector<Pose> all;
    for (std::size_t b = 0; b < blades_.size(); ++b)
        all.push_back(pose(u, b));
    return all;
}

BladeContact::Place BladeContact::place(const Eigen::VectorXd& u, const Pose& pose, std::size_t sample) const
{
    const Sample& s = samples_[sample];
    Vec3 x = Vec3::Zero();
    for (auto i = static_cast<std::size_t>(s.begin); i < static_cast<std::size_t>(s.end); ++i)
        x += weight_[i] * moved(node_[i], u);
    const Vec3 w = x - pose.node[0];
    return { x, w.dot(pose.normal) - given(sample).bears_at_mm, w.dot(pose.along), w.dot(pose.deep) };
}

double BladeContact::share_at(const Place& place, std::size_t blade) const
{
    return fade(std::abs(place.along) - blades_[blade].half_width_mm)
        * fade(std::abs(place.deep) - blades_[blade].half_height_mm);
}

namespace {

    /// Depth that counts: a sample that is expected to touch is pulled, too.
    double depth_of(double gap, bool expected) { return expected ? gap : std::min(gap, 0.0); }

} // namespace

/// The derivative of the energy by the place of the sample, N.
Vec3 BladeContact::force_on(const Pose& pose, const Place& place, std::size_t sample) const
{
    const Sample& s = samples_[sample];
    const BladeSample& own = given(sample);
    const Stick stick(
        { place.along - s.along_at_rest, place.deep - s.deep_at_rest }, kStickShare * own.stiffness, slips_at(sample));
    return own.area * s.share
        * (own.stiffness * depth_of(place.gap, s.expected) * pose.normal + stick.stress[0] * pose.along
            + stick.stress[1] * pose.deep);
}

std::vector<std::array<double, 2>> BladeContact::group_forces(const Eigen::VectorXd& u) const
{
    const std::vector<Pose> all = poses(u);
    std::vector<std::array<double, 2>> forces(blades_.size());
    for (std::size_t i = 0; i < samples_.size(); ++i) {
        const auto blade = static_cast<std::size_t>(samples_[i].blade);
        const BladeSample& own = given(i);
        if (samples_[i].share > 0.0)
            forces[blade][own.bone ? 1 : 0]
                += own.area * samples_[i].share * own.stiffness * std::max(-place(u, all[blade], i).gap, 0.0);
    }
    return forces;
}

void BladeContact::renew(const Eigen::VectorXd& u, double share)
{
    const std::vector<std::array<double, 2>> forces = group_forces(u);
    for (std::size_t b = 0; b < blades_.size(); ++b)
        for (std::size_t k = 0; k < 2; ++k) {
            Group& group = groups_[b][k];
            const double whole = group.area > 0.0 ? blades_[b].friction * forces[b][k] / group.area : 0.0;
            const bool at_once = !group.slips || group.slips_at == 0.0 || whole == 0.0;
            group.slips_at += (at_once ? 1.0 : share) * (whole - group.slips_at);
            group.slips = true;
        }
}

double BladeContact::friction_error(const Eigen::VectorXd& u) const
{
    const std::vector<std::array<double, 2>> forces = group_forces(u);
    double largest = 0.0, error = 0.0;
    for (std::size_t b = 0; b < blades_.size(); ++b)
        for (std::size_t k = 0; k < 2; ++k) {
            const Group& group = groups_[b][k];
            if (blades_[b].friction == 0.0 || group.area <= 0.0)
                continue;
            if (!group.slips || (forces[b][k] == 0.0 && group.slips_at > 0.0))
                return std::numeric_limits<double>::infinity();
            largest = std::max(largest, forces[b][0] + forces[b][1]);
            error = std::max(error, std::abs(blades_[b].friction * forces[b][k] - group.slips_at * group.area));
        }
    return largest > 0.0 ? error / largest : 0.0;
}

void BladeContact::expect(const Eigen::VectorXd& u)
{
    const std::vector<Pose> all = poses(u);
    for (std::size_t i = 0; i < samples_.size(); ++i)
        samples_[i].expected = place(u, all[static_cast<std::size_t>(samples_[i].blade)], i).gap < 0.0;
}

void BladeContact::prepare_search(const Eigen::VectorXd& u)
{
    constexpr double kAsNearMm = 0.5; // samples this much farther than the nearest touch with it
    secant_friction_ = true;
    const std::vector<Pose> all = poses(u);
    for (std::size_t b = 0; b < blades_.size(); ++b) {
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t i = first_[b]; i < first_[b + 1]; ++i)
            if (samples_[i].share > 0.0)
                nearest = std::min(nearest, place(u, all[b], i).gap);
        if (nearest < 0.0)
            continue;
        for (std::size_t i = first_[b]; i < first_[b + 1]; ++i)
            samples_[i].expected = place(u, all[b], i).gap <= nearest + kAsNearMm;
    }
}

void BladeContact::expect_nothing()
{
    for (Sample& s : samples_)
        s.expected = false;
    secant_friction_ = false;
}

double BladeContact::energy_of(const Place& place, std::size_t sample) const
{
    const Sample& s = samples_[sample];
    const BladeSample& own = given(sample);
    const double depth = depth_of(place.gap, s.expected);
    const Stick stick(
        { place.along - s.along_at_rest, place.deep - s.deep_at_rest }, kStickShare * own.stiffness, slips_at(sample));
    return own.area * s.share * (0.5 * own.stiffness * depth * depth + stick.energy);
}

double BladeContact::energy(const Eigen::VectorXd& u) const
{
    const std::vector<Pose> all = poses(u);
    double energy = 0.0;
    for (std::size_t i = 0; i < samples_.size(); ++i)
        if (samples_[i].share > 0.0)
            energy += energy_of(place(u, all[static_cast<std::size_t>(samples_[i].blade)], i), i);
    return energy;
}

double BladeContact::add_response(const Eigen::VectorXd& u, Eigen::VectorXd& forces) const
{
    RETRACTOR_ASSERT(forces.size() == u.size());
    const std::vector<Pose> all = poses(u);
    double energy = 0.0;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
        const Sample& s = samples_[i];
        const auto blade = static_cast<std::size_t>(s.blade);
        if (s.share == 0.0)
            continue;
        const Pose& pose = all[blade];
        const Place there = place(u, pose, i);
        const Vec3 force = force_on(pose, there, i);
        if (force.isZero(0.0))
            continue;
        energy += energy_of(there, i);
        for (auto n = static_cast<std::size_t>(s.begin); n < static_cast<std::size_t>(s.end); ++n)
            forces.segment<3>(3 * static_cast<Eigen::Index>(node_[n])) += weight_[n] * force;
        // The opposite force on the blade, distributed to its nodes so that the moment is that of the force at x.
        const Vec3 from_middle = there.x - pose.node[0];
        const AxisWay along(from_middle, pose.along, pose.along_mm), deep(from_middle, pose.deep, pose.deep_mm);
        const double normal = force.dot(pose.normal), a = force.dot(pose.along), d = force.dot(pose.deep);
        // Edges of the blade stay at right angles while it moves rigidly; between two poses they may differ a little.
        const double cosine = pose.along.dot(pose.deep), sine2 = 1.0 - cosine * cosine;
        const double first = (there.along - cosine * there.deep) / (sine2 * pose.along_mm),
                     second = (there.deep - cosine * there.along) / (sine2 * pose.deep_mm);
        const double in_along = (a - cosine * d) / sine2, in_deep = (d - cosine * a) / sine2;
        Vec12 on = Vec12::Zero();
        on += in_along * along.gradient(1) + in_deep * deep.gradient(2);
        on.segment<3>(3) -= (1.0 - first - second) * normal * pose.normal;
        on.segment<3>(6) -= first * normal * pose.normal;
        on.segment<3>(9) -= second * normal * pose.normal;
        for (std::size_t n = 0; n < pose.node.size(); ++n)
            forces.segment<3>(3 * static_cast<Eigen::Index>(blades_[blade].nodes[n]))
                += on.segment<3>(3 + 3 * static_cast<Eigen::Index>(n));
    }
    return energy;
}

BlockPattern BladeContact::pattern(const BlockPattern& body) const
{
    std::vector<std::pair<std::int32_t, std::int32_t>> more;
    const auto couple = [&](VertexId a, VertexId b) { more.emplace_back(std::max(a, b), std::min(a, b)); };
    for (const BladeSurface& blade : blades_)
        for (const VertexId a : blade.nodes)
            for (const VertexId b : blade.nodes)
                couple(a, b);
    for (const Sample& s : samples_)
        for (auto n = static_cast<std::size_t>(s.begin); n < static_cast<std::size_t>(s.end); ++n)
            for (const VertexId v : blades_[static_cast<std::size_t>(s.blade)].nodes)
                couple(node_[n], v);
    return extended_pattern(body, std::move(more)); // nodes of one face are coupled by their element
}

void BladeContact::add_stiffness(const Eigen::VectorXd& u, double projected, BlockMatrix& matrix) const
{
    RETRACTOR_ASSERT(matrix.values.size() == 9 * matrix.pattern.block_count());
    using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    const std::vector<Pose> all = poses(u);
    const BlockPattern& pattern = matrix.pattern;
    std::vector<std::array<std::int32_t, 2>> unknowns; // a node, and the point of the twelve coordinates that it moves
    std::vector<double> weights;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
        const Sample& s = samples_[i];
        const BladeSample& own = given(i);
        const Pose& pose = all[static_cast<std::size_t>(s.blade)];
        if (s.share == 0.0)
            continue;
        const Place there = place(u, pose, i);
        const bool touches = s.expected || there.gap < 0.0;
        if (!touches && slips_at(i) <= 0.0)
            continue;
        Mat12 K = Mat12::Zero();
        if (touches) {
            const PlaneDistance g = plane_distance(there.x, pose.node);
            K = own.stiffness * (g.gradient * g.gradient.transpose() + (1.0 - projected) * there.gap * g.hessian);
        }
        if (slips_at(i) > 0.0) {
            const Stick stick({ there.along - s.along_at_rest, there.deep - s.deep_at_rest },
                kStickShare * own.stiffness, slips_at(i));
            const Vec3 from_middle = there.x - pose.node[0];
            const AxisWay along(from_middle, pose.along, pose.along_mm), deep(from_middle, pose.deep, pose.deep_mm);
            Eigen::Matrix<double, 12, 2> J;
            J << along.gradient(1), deep.gradient(2);
            if (secant_friction_)
                K += stick.secant * J * J.transpose();
            else
                K += J * stick.slope * J.transpose();
            if (projected < 1.0)
                K += (1.0 - projected) * (stick.stress[0] * along.hessian(1) + stick.stress[1] * deep.hessian(2));
        }
        K *= own.area * s.share;
        unknowns.clear();
        weights.clear();
        for (auto n = static_cast<std::size_t>(s.begin); n < static_cast<std::size_t>(s.end); ++n) {
            unknowns.push_back({ node_[n], 0 });
            weights.push_back(weight_[n]);
        }
        for (std::size_t n = 0; n < pose.node.size(); ++n) {
            unknowns.push_back(
                { blades_[static_cast<std::size_t>(s.blade)].nodes[n], static_cast<std::int32_t>(n) + 1 });
            weights.push_back(1.0);
        }
        for (std::size_t a = 0; a < unknowns.size(); ++a)
            for (std::size_t b = 0; b < unknowns.size(); ++b) {
                const std::int32_t row = unknowns[a][0], column = unknowns[b][0];
                if (row < column)
                    continue;
                const auto begin = pattern.column.begin() + pattern.row_start[static_cast<std::size_t>(row)];
                const auto end = pattern.column.begin() + pattern.row_start[static_cast<std::size_t>(row) + 1];
                const auto block = std::lower_bound(begin, end, column) - pattern.column.begin();
                Eigen::Map<RowMat3>(matrix.values.data() + 9 * static_cast<std::size_t>(block))
                    += weights[a] * weights[b] * K.block<3, 3>(3 * unknowns[a][1], 3 * unknowns[b][1]);
            }
    }
}

double BladeContact::largest_nodal_force(const Eigen::VectorXd& u) const
{
    const std::vector<Pose> all = poses(u);
    Eigen::VectorXd forces = Eigen::VectorXd::Zero(u.size());
    double largest = 0.0;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
        const Sample& s = samples_[i];
        if (s.share == 0.0)
            continue;
        const Pose& pose = all[static_cast<std::size_t>(s.blade)];
        const Vec3 force = force_on(pose, place(u, pose, i), i);
        for (auto n = static_cast<std::size_t>(s.begin); n < static_cast<std::size_t>(s.end); ++n)
            forces.segment<3>(3 * static_cast<Eigen::Index>(node_[n])) += weight_[n] * force;
    }
    for (const VertexId v : node_)
        largest = std::max(largest, forces.segment<3>(3 * static_cast<Eigen::Index>(v)).norm());
    return largest;
}

std::vector<BladeBearing> BladeContact::bearing(const Eigen::VectorXd& u) const
{
    const std::vector<Pose> all = poses(u);
    std::vector<BladeBearing> bearings;
    for (std::size_t b = 0; b < blades_.size(); ++b) {
        const BladeSurface& blade = blades_[b];
        BladeBearing bearing;
        const auto cells
            = [](double half) { return std::max(1, static_cast<int>(std::lround(2.0 * half / kPressureCellMm))); };
        const int columns = cells(blade.half_width_mm), rows = cells(blade.half_height_mm);
        Eigen::MatrixXd force = Eigen::MatrixXd::Zero(rows, columns);
        const auto cell = [](double at, double half, int count) {
            return std::clamp(static_cast<int>(std::floor((at / half + 1.0) * 0.5 * count)), 0, count - 1);
        };
        for (std::size_t i = first_[b]; i < first_[b + 1]; ++i) {
            const Place there = place(u, all[b], i);
            if (!(there.gap < 0.0) || samples_[i].share == 0.0)
                continue;
            const BladeSample& own = given(i);
            const double area = own.area * samples_[i].share, push = -area * own.stiffness * there.gap;
            bearing.force_N += push;
            bearing.thirds_N[static_cast<std::size_t>(cell(there.along, blade.half_width_mm, 3))] += push;
            if (own.bone)
                bearing.bone_force_N += push;
            else
                bearing.area_mm2 += area;
            bearing.penetration_mm = std::max(bearing.penetration_mm, -there.gap);
            force(cell(there.deep, blade.half_height_mm, rows), cell(there.along, blade.half_width_mm, columns))
                += push;
        }
        const double height = 2.0 * blade.half_height_mm / rows, width = 2.0 * blade.half_width_mm / columns;
        Eigen::Index row = 0, column = 0;
        bearing.pressure_largest_MPa = force.maxCoeff(&row, &column) / (width * height);
        if (const auto bearing_squares = (force.array() > 0.0).count(); bearing_squares > 0)
            bearing.pressure_mean_MPa = force.sum() / (static_cast<double>(bearing_squares) * width * height);
        bearing.largest_along_mm = (static_cast<double>(column) + 0.5) * width - blade.half_width_mm;
        bearing.largest_deep_mm = (static_cast<double>(row) + 0.5) * height - blade.half_height_mm;
        bearings.push_back(bearing);
    }
    return bearings;
}

std::vector<TetId> BladeContact::covered_elements() const
{
    const Eigen::VectorXd at_rest = Eigen::VectorXd::Zero(3 * rest_.rows());
    const std::vector<Pose> all = poses(at_rest);
    std::vector<TetId> tets;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
        const auto blade = static_cast<std::size_t>(samples_[i].blade);
        if (share_at(place(at_rest, all[blade], i), blade) > 0.0)
            tets.push_back(given(i).tet);
    }
    std::sort(tets.begin(), tets.end());
    tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
    return tets;
}

} // namespace retractor::fem
