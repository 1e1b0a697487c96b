#include "fem/statics/blade_frame.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>

namespace retractor::fem {

namespace {

    constexpr Eigen::Index kBladeMotions = 6; // three translations and three rotations

    /// The matrix of the cross product: skew(a) b = a x b.
    Mat3 skew(const Vec3& a)
    {
        Mat3 m;
        m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
        return m;
    }

    Mat3 turned(double angle, const Vec3& axis) { return Eigen::AngleAxisd(angle, axis).toRotationMatrix(); }

    /// Where the pivot of a blade is.
    Vec3 pivot_at(const BladeFrame& frame, const FrameState& state, std::size_t blade)
    {
        const Vec3 centre = frame_centre(frame);
        return centre + state.translation
            + state.rotation * (frame[blade].pivot + 0.5 * state.distance * frame[blade].outward - centre);
    }

    /// The pivot of a blade, seen from the present centre of the frame.
    Vec3 lever_of(const BladeFrame& frame, const FrameState& state, std::size_t blade)
    {
        return pivot_at(frame, state, blade) - frame_centre(frame) - state.translation;
    }

    Eigen::Matrix<double, 2 * kBladeMotions, 1> packed_loads(const std::array<BladeLoad, 2>& loads)
    {
        Eigen::Matrix<double, 2 * kBladeMotions, 1> all;
        all << loads[0].force_N, loads[0].moment_Nmm, loads[1].force_N, loads[1].moment_Nmm;
        return all;
    }

} // namespace

void check_frame(const BladeFrame& frame)
{
    constexpr double kUnit = 1e-6; // directions may be typed to a few digits
    constexpr double kMostPlay = 1.5708; // a quarter turn: beyond, the blade lies along the skin
    for (std::size_t k = 0; k < frame.size(); ++k) {
        const FrameBlade& blade = frame[k];
        const std::string where = "blade " + std::to_string(k + 1);
        if (!blade.pivot.allFinite())
            throw InputError("the place of the blade's arm is not finite", where);
        if (!(std::abs(blade.arm.norm() - 1.0) < kUnit) || !(std::abs(blade.outward.norm() - 1.0) < kUnit))
            throw InputError("the axis of the arm and the direction of the rack must be unit vectors", where);
        if (!(blade.play >= 0.0 && blade.play <= kMostPlay))
            throw InputError("the play of the blade must be between 0 and 90 degrees", where);
    }
    if (!((frame[0].outward + frame[1].outward).norm() < kUnit))
        throw InputError("the rack must move the two blades in opposite directions", "blades");
}

Vec3 frame_centre(const BladeFrame& frame) { return 0.5 * (frame[0].pivot + frame[1].pivot); }

double frame_lever(const mesh::TetMesh& mesh, const BladeFrame& frame, std::span<const HookPatch> blades)
{
    const Vec3 centre = frame_centre(frame);
    double lever = 0.0;
    for (const HookPatch& blade : blades)
        for (const VertexId v : blade.nodes)
            lever = std::max(lever, (mesh.vertices.row(v).transpose() - centre).norm());
    return lever;
}

std::vector<HookPatch> blades_at(const BladeFrame& frame, const FrameState& state, std::vector<HookPatch> blades)
{
    RETRACTOR_ASSERT(blades.size() == frame.size());
    for (std::size_t k = 0; k < frame.size(); ++k) {
        blades[k].pivot = frame[k].pivot;
        blades[k].displacement = pivot_at(frame, state, k) - frame[k].pivot;
        blades[k].rotation = state.rotation * turned(state.turn[k], frame[k].arm);
    }
    return blades;
}

FrameState moved_by(const FrameState& state, const FrameVector& step, double lever)
{
    FrameState next = state;
    next.translation += step.head<3>();
    const Vec3 rotation = step.segment<3>(kFrameRotation) / lever;
    if (const double angle = rotation.norm(); angle > 0.0)
        // A product of many rotations drifts off the rotations by round-off; a quaternion of unit length does not.
        next.rotation
            = Eigen::Quaterniond(turned(angle, rotation / angle) * state.rotation).normalized().toRotationMatrix();
    for (std::size_t k = 0; k < next.turn.size(); ++k)
        next.turn[k] += step[kFrameTurns + static_cast<Eigen::Index>(k)] / lever;
    next.distance += step[kFrameDistance];
    return next;
}

std::array<BladeLoad, 2> blade_loads(
    const mesh::TetMesh& mesh, std::span<const HookPatch> blades, const Eigen::VectorXd& nodal_forces_N)
{
    std::array<BladeLoad, 2> loads;
    RETRACTOR_ASSERT(blades.size() == loads.size() && nodal_forces_N.size() == 3 * mesh.vertices.rows());
    for (std::size_t k = 0; k < loads.size(); ++k)
        for (const VertexId v : blades[k].nodes) {
            const Vec3 force = nodal_forces_N.segment<3>(3 * static_cast<Eigen::Index>(v));
            const Vec3 lever = blades[k].rotation * (mesh.vertices.row(v).transpose() - blades[k].pivot);
            loads[k].force_N += force;
            loads[k].moment_Nmm += lever.cross(force);
            loads[k].dyad_Nmm += lever * force.transpose();
        }
    return loads;
}

FrameVector generalised_forces(
    const BladeFrame& frame, const FrameState& state, const std::array<BladeLoad, 2>& loads, double lever)
{
    return blades_by_state(frame, state, lever).transpose() * packed_loads(loads);
}

Eigen::MatrixXd blade_motions(const mesh::TetMesh& mesh, std::span<const HookPatch> blades)
{
    Eigen::MatrixXd motions
        = Eigen::MatrixXd::Zero(3 * mesh.vertices.rows(), kBladeMotions * static_cast<Eigen::Index>(blades.size()));
    for (std::size_t k = 0; k < blades.size(); ++k)
        for (const VertexId v : blades[k].nodes) {
            const Eigen::Index row = 3 * static_cast<Eigen::Index>(v);
            const Eigen::Index column = kBladeMotions * static_cast<Eigen::Index>(k);
            motions.block<3, 3>(row, column).setIdentity();
            motions.block<3, 3>(row, column + 3)
                = -skew(blades[k].rotation * (mesh.vertices.row(v).transpose() - blades[k].pivot));
        }
    return motions;
}

Eigen::Matrix<double, 2 * kBladeMotions, kFrameUnknowns> blades_by_state(
    const BladeFrame& frame, const FrameState& state, double lever)
{
    Eigen::Matrix<double, 2 * kBladeMotions, kFrameUnknowns> B;
    B.setZero();
    for (std::size_t k = 0; k < frame.size(); ++k) {
        const Eigen::Index row = kBladeMotions * static_cast<Eigen::Index>(k);
        B.block<3, 3>(row, 0).setIdentity();
        B.block<3, 3>(row, kFrameRotation) = -skew(lever_of(frame, state, k)) / lever;
        B.block<3, 1>(row, kFrameDistance) = 0.5 * state.rotation * frame[k].outward;
        B.block<3, 3>(row + 3, kFrameRotation) = Mat3::Identity() / lever;
        B.block<3, 1>(row + 3, kFrameTurns + static_cast<Eigen::Index>(k)) = state.rotation * frame[k].arm / lever;
    }
    return B;
}

FrameMatrix frame_stiffness(const BladeFrame& frame, const FrameState& state, const std::array<BladeLoad, 2>& loads,
    const Eigen::MatrixXd& stiffness, double lever)
{
    RETRACTOR_ASSERT(stiffness.rows() == 2 * kBladeMotions && stiffness.cols() == 2 * kBladeMotions);
    const auto B = blades_by_state(frame, state, lever);
    Eigen::Matrix<double, 2 * kBladeMotions, 2 * kBladeMotions> K = stiffness;
    // Levers turn with the blade while forces stay: d(lever x f) = (rotation x lever) x f.
    for (std::size_t k = 0; k < loads.size(); ++k) {
        const Eigen::Index at = kBladeMotions * static_cast<Eigen::Index>(k) + 3;
        const Mat3& dyad = loads[k].dyad_Nmm;
        K.block<3, 3>(at, at) += dyad - dyad.trace() * Mat3::Identity();
    }
    FrameMatrix J = B.transpose() * K * B;
    // The levers of the pivots, the arms and the rack turn with the frame while forces and moments stay.
    for (std::size_t k = 0; k < loads.size(); ++k) {
        const Eigen::Index row = kBladeMotions * static_cast<Eigen::Index>(k);
        const Eigen::Index turn = kFrameTurns + static_cast<Eigen::Index>(k);
        const Vec3 &force = loads[k].force_N, &moment = loads[k].moment_Nmm;
        Eigen::Matrix<double, 3, kFrameUnknowns> pivot = B.block<3, kFrameUnknowns>(row, 0);
        pivot.leftCols<3>().setZero(); // the centre moves by the same translation
        J.block<3, kFrameUnknowns>(kFrameRotation, 0) -= skew(force) * pivot / lever;
        const Vec3 arm = state.rotation * frame[k].arm, outward = state.rotation * frame[k].outward;
        J.block<1, 3>(turn, kFrameRotation) += arm.cross(moment).transpose() / (lever * lever);
        J.block<1, 3>(kFrameDistance, kFrameRotation) += 0.5 * outward.cross(force).transpose() / lever;
    }
    return J;
}

} // namespace retractor::fem
