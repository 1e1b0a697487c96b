#pragma once
// Motion of mass-spring tissue: Voigt elements (a spring beside a dashpot), each with a Maxwell arm for relaxation, in
// explicit time steps. Units mm, N, s, tonne.
//
// Force. An element of stiffness k at length l pulls with k (l - l0) + c l' + q, with c = k `voigt_time`. The force q
// of the arm follows q' = k1 l' - q / `arm_time` with k1 = k `arm_ratio`; q is integrated exactly over a step of
// constant l'. Without the arm the element is a Kelvin-Voigt element, which creeps but does not relax. With the arm and
// without the dashpot the element is the standard linear solid.
//
// Step. v' = v + dt f / (m + dt D), x' = x + dt v'. The force f has the dashpots at the old velocities, and D is the
// sum of the dashpot coefficients at the particle. A particle's own velocity is thus taken at the new time. As a side
// effect each particle carries dt D more inertia. The added inertia vanishes with dt and changes no equilibrium, but
// slows large oscillations (with the defaults of ElementLaw, 9 times the mass in the sheet of Tang et al. 2020). A body
// without supports falls with its mass alone, which no dashpot resists.
//
// Stability. The dashpot matrix C obeys C <= 2 D. Stability needs dt^2 K + 2 dt C <= 4 (M + dt D), and dt^2 K <= 4 M is
// enough. The bound is therefore dt <= 2 / w for any dashpots. Gershgorin's discs bound w^2 by the largest sum of 2 (k
// + k1) / m over a particle's springs, with 1 instead of 2 for a spring whose other end is held. The tangent stiffness
// of an element never exceeds its k along or across its direction, so the bound holds for any deformation. The bound is
// sharp for chains and sheets.

#include "haptics/device/device.h"
#include "haptics/springs/spring_body.h"

#include <vector>

namespace retractor::haptics {

/// The law of all elements of a body. Dashpots and arms are proportional to their springs.
struct ElementLaw {
    double voigt_time = 0.001; ///< c / k, s: time constant of the creep of a Voigt element; >= 0
    double arm_ratio = 0.0; ///< k1 / k; 0 means no arm
    double arm_time = 1.0; ///< time constant of the relaxation of an arm, s; > 0
    double drag = 10.0; ///< drag of the surrounding air, as a rate of velocity decay, 1/s; >= 0
    Vec3 gravity = Vec3::Zero(); ///< mm/s^2
};
inline constexpr double kGravity = 9806.65; ///< mm/s^2

/// A Voigt element by the two numbers of Tang et al. 2020: 0.15 of the largest stiffness and 0.9 of the largest damping
/// that a device can render.
struct DeviceVoigt {
    double stiffness = 0.0; ///< N/mm
    double voigt_time = 0.0; ///< s
};
DeviceVoigt device_voigt(const DeviceLimits& device);

/// @throws InputError naming the value that is negative or not finite
void check_element_law(const ElementLaw& law);

class SpringMotion {
public:
    /// Starts at rest. @throws InputError as check_spring_body() and check_element_law()
    SpringMotion(SpringBody body, const ElementLaw& law);

    double stable_step() const { return stable_step_; } ///< largest stable step, s; infinite when nothing can move

    /// Makes one step; allocates nothing.
    /// @throws InputError naming both values when dt is not positive or exceeds stable_step(); no particle has moved
    /// then
    void step(double dt)
    {
        begin_step(dt);
        end_step();
    }
    /// The two halves of a step. Between them the caller may change next(), to hold a particle at a place.
    void begin_step(double dt);
    void end_step() noexcept;
    /// New position of particle v in this step, mm.
    Eigen::Map<Vec3> next(VertexId v) { return Eigen::Map<Vec3>(&next_[3 * static_cast<std::size_t>(v)]); }
    /// Moves next(v) to `place`.
    /// @return the force that this takes, N; zero when v is held already
    Vec3 hold_next(VertexId v, const Vec3& place) noexcept;

    Eigen::Map<const Vec3> position(VertexId v) const
    {
        return Eigen::Map<const Vec3>(&position_[3 * static_cast<std::size_t>(v)]);
    }
    Eigen::Map<const Points> positions() const { return { position_.data(), body_.surface.vertices.rows(), 3 }; }
    Eigen::Map<const Vec3> velocity(VertexId v) const
    {
        return Eigen::Map<const Vec3>(&velocity_[3 * static_cast<std::size_t>(v)]);
    }
    /// Sets a steady force on a particle, N, until the next change. @throws InputError on an index out of range or NaN
    void set_load(VertexId v, const Vec3& force);
    /// Moves a particle to a position, at rest; for tests and for loading. @throws InputError as set_load()
    void place(VertexId v, const Vec3& position);
    bool is_held(VertexId v) const { return body_.held[static_cast<std::size_t>(v)] != 0; }
    void back_to_rest() noexcept;
    /// Force of the elements at v on v, N: springs, arms and dashpots at the last begin_step().
    Vec3 element_force(VertexId v) const { return Eigen::Map<const Vec3>(&force_[3 * static_cast<std::size_t>(v)]); }

    const SpringBody& body() const { return body_; }

private:
    void compute_bound();
    void compute_inertia(double dt) noexcept;
    Vec3 common_acceleration() const noexcept;
    void add_element_forces(double dt) noexcept;
    void check_id(VertexId v) const;

    SpringBody body_;
    ElementLaw law_;
    std::vector<double> position_, velocity_, next_, force_, load_; ///< three numbers per particle
    /// Per particle; inverse_inertia_ is zero for a held particle.
    std::vector<double> damping_, inertia_, inverse_inertia_;
    std::vector<double> arm_force_, length_; ///< per spring
    double stable_step_ = 0.0, dt_ = 0.0, mass_ = 0.0;
    bool is_free_ = false; ///< no particle is held
};

/// Multiplies every mass by one factor, so that steps of `step_s` are stable. Slow presses feel the same; fast motion
/// is heavier.
/// @return the factor, at least 1; 1 when the steps are stable already
double slow_down_to(SpringBody& body, double step_s, double arm_ratio = 0.0);

} // namespace retractor::haptics
