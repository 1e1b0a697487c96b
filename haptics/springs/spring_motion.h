#pragma once
// Mass-spring tissue in motion: Voigt elements (a spring beside a dashpot), each with a Maxwell arm for relaxation,
// stepped explicitly. Units mm, N, s, tonne.
//
// An element of stiffness k at length l pulls with k (l - l0) + c l' + q: c = k `voigt_time`; the arm's force q follows
// q' = k1 l' - q / `arm_time` with k1 = k `arm_ratio`, integrated exactly over a step of constant l'. Without the arm
// it is Kelvin and Voigt's, which creeps but does not relax; with it and without the dashpot the standard linear solid.
//
// Step. v' = v + dt f / (m + dt D), x' = x + dt v', where f has the dashpots at the old velocities and D is the sum of
// their coefficients at the particle. So what a particle's own velocity meets is taken at the new time; what remains is
// that each particle carries dt D more inertia, which vanishes with dt and moves no equilibrium, but makes large swings
// slower (ElementLaw's defaults in the source's sheet: 9 times the mass); a body that nothing holds falls as one by its
// mass alone, which no dashpot resists. As the dashpots'
// matrix C obeys C <= 2 D, stability needs dt^2 K + 2 dt C <= 4 (M + dt D), for which dt^2 K <= 4 M is enough: the
// bound is 2 / w whatever the dashpots are. w^2 is bounded by Gershgorin's discs, max over particles of sum (k + k1)
// times 2 (1 where the other end is held) over m. An element's tangent never exceeds its k along or across its
// direction, so that bound is certain however the tissue is deformed; it is sharp for chains and sheets.

#include "haptics/device/device.h"
#include "haptics/springs/spring_body.h"

#include <vector>

namespace retractor::haptics {

/// Of all elements of a body; dashpots and arms in proportion to their springs.
struct ElementLaw {
    double voigt_time = 0.001; ///< c / k, s: a Voigt element creeps with it; >= 0
    double arm_ratio = 0.0; ///< k1 / k; 0: no arm
    double arm_time = 1.0; ///< s: an arm relaxes with it; > 0
    double drag = 10.0; ///< per second, of the velocity: the air's part; >= 0
    Vec3 gravity = Vec3::Zero(); ///< mm/s^2
};
inline constexpr double kGravity = 9806.65; ///< mm/s^2

/// A Voigt element by the source's two numbers: its stiffness and damping as fractions of what a device can render.
struct DeviceVoigt {
    double stiffness = 0.0; ///< N/mm
    double voigt_time = 0.0; ///< s
};
inline constexpr double kSourceStiffness = 0.15, kSourceDamping = 0.9;
/// @throws InputError on a fraction outside 0 (stiffness: not 0) to 1.
DeviceVoigt device_voigt(
    const DeviceLimits& device, double stiffness_fraction = kSourceStiffness, double damping_fraction = kSourceDamping);

/// @throws InputError naming what is negative or not finite.
void check_element_law(const ElementLaw& law);

class SpringMotion {
public:
    /// At rest. @throws InputError as check_spring_body() and check_element_law().
    SpringMotion(SpringBody body, const ElementLaw& law);

    double stable_step() const { return stable_step_; } ///< s; infinite when nothing can move

    /// One step; nothing is allocated. @throws InputError when dt is not positive or beyond stable_step(), naming both;
    /// nothing has moved then.
    void step(double dt)
    {
        begin_step(dt);
        end_step();
    }
    /// The same in two halves: between them next() may be changed, to hold a particle at a place.
    void begin_step(double dt);
    void end_step() noexcept;
    /// Where particle v arrives in this step.
    Eigen::Map<Vec3> next(VertexId v) { return Eigen::Map<Vec3>(&next_[3 * static_cast<std::size_t>(v)]); }
    /// Moves next(v) to `place`. @returns the force that takes, N; zero when v is held already.
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
    double largest_speed() const noexcept; ///< mm/s
    /// All velocities become zero: towards an equilibrium, whenever the kinetic energy has peaked.
    void stop() noexcept;
    double energy() const noexcept; ///< kinetic, of springs and arms, and of gravity from the rest positions; N mm

    /// A steady force on a particle, N, until changed. @throws InputError on an id out of range or NaN.
    void set_load(VertexId v, const Vec3& force);
    /// Puts a particle somewhere, at rest: for tests and for loading. @throws InputError as set_load().
    void place(VertexId v, const Vec3& position);
    /// What held it lets go, or holds it where it is. @throws InputError on an id out of range.
    void set_held(VertexId v, bool held);
    bool is_held(VertexId v) const { return body_.held[static_cast<std::size_t>(v)] != 0; }
    void back_to_rest() noexcept;
    /// Of the elements at v, on v, N: springs, arms and dashpots as they were at the last begin_step().
    Vec3 element_force(VertexId v) const { return Eigen::Map<const Vec3>(&force_[3 * static_cast<std::size_t>(v)]); }

    /// The particles one shortest spring from v, rising.
    std::vector<VertexId> ring(VertexId v) const;
    const SpringBody& body() const { return body_; }
    const ElementLaw& law() const { return law_; }

private:
    void compute_bound();
    void compute_inertia(double dt) noexcept;
    Vec3 common_acceleration() const noexcept;
    void add_element_forces(double dt) noexcept;
    void check_id(VertexId v) const;

    SpringBody body_;
    ElementLaw law_;
    std::vector<double> position_, velocity_, next_, force_, load_; ///< three per particle
    std::vector<double> damping_, inertia_, inverse_inertia_; ///< per particle; zero inverse: held
    std::vector<double> arm_force_, length_; ///< per spring
    double stable_step_ = 0.0, dt_ = 0.0, mass_ = 0.0;
    bool is_free_ = false; ///< nothing is held
};

/// Makes every mass `factor` times what it was so that steps of `step_s` are stable, where they are not yet: what is
/// pressed slowly is answered alike, what moves fast is heavier. @return the factor, at least 1.
double slow_down_to(SpringBody& body, double step_s, double arm_ratio = 0.0);

} // namespace retractor::haptics
