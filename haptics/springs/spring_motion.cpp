#include "haptics/springs/spring_motion.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace retractor::haptics {

DeviceVoigt device_voigt(const DeviceLimits& device)
{
    constexpr double kStiffness = 0.15, kDamping = 0.9;
    const double stiffness = kStiffness * device.max_stiffness;
    return { stiffness, kDamping * device.max_damping / stiffness };
}

void check_element_law(const ElementLaw& law)
{
    const auto refuse = [](const char* name, double value) {
        throw InputError(std::string("the elements' ") + name + " is out of range: " + std::to_string(value));
    };
    if (!(law.voigt_time >= 0.0) || !std::isfinite(law.voigt_time))
        refuse("voigt_time", law.voigt_time);
    if (!(law.arm_ratio >= 0.0) || !std::isfinite(law.arm_ratio))
        refuse("arm_ratio", law.arm_ratio);
    if (!(law.arm_time > 0.0) || !std::isfinite(law.arm_time))
        refuse("arm_time", law.arm_time);
    if (!(law.drag >= 0.0) || !std::isfinite(law.drag))
        refuse("drag", law.drag);
    if (!law.gravity.allFinite())
        throw InputError("gravity is not finite");
}

SpringMotion::SpringMotion(SpringBody body, const ElementLaw& law)
    : body_(std::move(body))
    , law_(law)
{
    check_spring_body(body_);
    check_element_law(law);
    const std::size_t particles = body_.mass.size();
    for (auto* values : { &position_, &velocity_, &next_, &force_, &load_ })
        values->assign(3 * particles, 0.0);
    for (auto* values : { &damping_, &inertia_, &inverse_inertia_ })
        values->assign(particles, 0.0);
    arm_force_.assign(body_.springs.size(), 0.0);
    length_.assign(body_.springs.size(), 0.0);
    for (const TissueSpring& spring : body_.springs) {
        damping_[static_cast<std::size_t>(spring.a)] += law_.voigt_time * spring.stiffness;
        damping_[static_cast<std::size_t>(spring.b)] += law_.voigt_time * spring.stiffness;
    }
    compute_bound();
    back_to_rest();
}

void SpringMotion::compute_bound()
{
    std::vector<double> disc(body_.mass.size(), 0.0);
    for (const TissueSpring& spring : body_.springs) {
        const double k = spring.stiffness * (1.0 + law_.arm_ratio);
        disc[static_cast<std::size_t>(spring.a)] += is_held(spring.b) ? k : 2.0 * k;
        disc[static_cast<std::size_t>(spring.b)] += is_held(spring.a) ? k : 2.0 * k;
    }
    double highest = 0.0;
    for (std::size_t v = 0; v < disc.size(); ++v)
        if (body_.held[v] == 0)
            highest = std::max(highest, disc[v] / body_.mass[v]);
    stable_step_ = highest > 0.0 ? 2.0 / std::sqrt(highest) : std::numeric_limits<double>::infinity();
    dt_ = 0.0;
    mass_ = std::accumulate(body_.mass.begin(), body_.mass.end(), 0.0);
    is_free_ = std::count(body_.held.begin(), body_.held.end(), 1) == 0;
}

void SpringMotion::compute_inertia(double dt) noexcept
{
    RETRACTOR_ASSERT(dt > 0.0);
    dt_ = dt;
    for (std::size_t v = 0; v < body_.mass.size(); ++v) {
        inertia_[v] = body_.mass[v] + dt * damping_[v];
        inverse_inertia_[v] = body_.held[v] != 0 ? 0.0 : 1.0 / inertia_[v];
    }
}

void SpringMotion::add_element_forces(double dt) noexcept
{
    const double ratio = dt / law_.arm_time;
    const double decay = std::exp(-ratio), gain = law_.arm_ratio * (-std::expm1(-ratio) / ratio);
    const bool arms = law_.arm_ratio > 0.0;
    const double* x = position_.data();
    const double* v = velocity_.data();
    double* f = force_.data();
    for (std::size_t s = 0; s < body_.springs.size(); ++s) {
        const TissueSpring& spring = body_.springs[s];
        const std::size_t a = 3 * static_cast<std::size_t>(spring.a), b = 3 * static_cast<std::size_t>(spring.b);
        const double dx = x[b] - x[a], dy = x[b + 1] - x[a + 1], dz = x[b + 2] - x[a + 2];
        const double squared = dx * dx + dy * dy + dz * dz;
        if (squared == 0.0)
            continue; // the spring has no direction
        const double length = std::sqrt(squared), inverse = 1.0 / length;
        const double closing
            = dx * (v[b] - v[a]) + dy * (v[b + 1] - v[a + 1]) + dz * (v[b + 2] - v[a + 2]); // length times its rate
        double pull = spring.stiffness * (length - spring.length + law_.voigt_time * closing * inverse);
        if (arms) {
            arm_force_[s] = decay * arm_force_[s] + gain * spring.stiffness * (length - length_[s]);
            length_[s] = length;
            pull += arm_force_[s];
        }
        pull *= inverse;
        f[a] += pull * dx;
        f[a + 1] += pull * dy;
        f[a + 2] += pull * dz;
        f[b] -= pull * dx;
        f[b + 1] -= pull * dy;
        f[b + 2] -= pull * dz;
    }
}

/// Common acceleration of the particles of a body without supports: gravity, and the momentum that is missing because
/// particles resist forces with more than their mass.
Vec3 SpringMotion::common_acceleration() const noexcept
{
    if (!is_free_)
        return Vec3::Zero();
    Vec3 missing = Vec3::Zero();
    for (std::size_t v = 0; v < body_.mass.size(); ++v)
        missing += (1.0 - body_.mass[v] * inverse_inertia_[v])
            * (Eigen::Map<const Vec3>(&force_[3 * v]) + Eigen::Map<const Vec3>(&load_[3 * v]));
    return law_.gravity + missing / mass_;
}

void SpringMotion::begin_step(double dt)
{
    if (!(dt > 0.0) || dt > stable_step_) {
        throw InputError(formatted(
            "a time step of %g s is not positive or beyond the springs' stability bound, %g s", dt, stable_step_));
    }
    if (dt != dt_)
        compute_inertia(dt);
    std::fill(force_.begin(), force_.end(), 0.0);
    add_element_forces(dt);
    const double kept = 1.0 / (1.0 + law_.drag * dt);
    const Vec3 common = common_acceleration();
    const Vec3 weight = is_free_ ? Vec3(Vec3::Zero()) : law_.gravity; // per mass; supports and springs carry the weight
    for (std::size_t v = 0; v < body_.mass.size(); ++v)
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = 3 * v + i;
            const double force = force_[j] + load_[j] + body_.mass[v] * weight[static_cast<Eigen::Index>(i)];
            const double velocity = inverse_inertia_[v] > 0.0
                ? kept * (velocity_[j] + dt * (inverse_inertia_[v] * force + common[static_cast<Eigen::Index>(i)]))
                : 0.0;
            next_[j] = position_[j] + dt * velocity;
        }
}

Vec3 SpringMotion::hold_next(VertexId v, const Vec3& place) noexcept
{
    const auto i = static_cast<std::size_t>(v);
    if (inverse_inertia_[i] == 0.0)
        return Vec3::Zero();
    RETRACTOR_ASSERT(dt_ > 0.0);
    const Vec3 force = (place - next(v)) * (inertia_[i] / (dt_ * dt_));
    next(v) = place;
    return force;
}

void SpringMotion::end_step() noexcept
{
    RETRACTOR_ASSERT(dt_ > 0.0);
    const double rate = 1.0 / dt_;
    for (std::size_t j = 0; j < next_.size(); ++j)
        velocity_[j] = rate * (next_[j] - position_[j]);
    std::swap(position_, next_);
}

void SpringMotion::check_id(VertexId v) const
{
    if (v < 0 || static_cast<std::size_t>(v) >= body_.mass.size())
        throw InputError("particle " + std::to_string(v) + " does not exist");
}

void SpringMotion::set_load(VertexId v, const Vec3& force)
{
    check_id(v);
    if (!force.allFinite())
        throw InputError("the load on particle " + std::to_string(v) + " is not finite");
    std::copy(force.begin(), force.end(), load_.begin() + 3 * static_cast<std::ptrdiff_t>(v));
}

void SpringMotion::place(VertexId v, const Vec3& position)
{
    check_id(v);
    if (!position.allFinite())
        throw InputError("the place for particle " + std::to_string(v) + " is not finite");
    const std::ptrdiff_t first = 3 * static_cast<std::ptrdiff_t>(v);
    std::copy(position.begin(), position.end(), position_.begin() + first);
    std::fill_n(velocity_.begin() + first, 3, 0.0);
}

void SpringMotion::back_to_rest() noexcept
{
    for (Eigen::Index v = 0; v < body_.surface.vertices.rows(); ++v)
        for (Eigen::Index i = 0; i < 3; ++i)
            position_[static_cast<std::size_t>(3 * v + i)] = body_.surface.vertices(v, i);
    std::fill(velocity_.begin(), velocity_.end(), 0.0);
    std::fill(arm_force_.begin(), arm_force_.end(), 0.0);
    for (std::size_t s = 0; s < body_.springs.size(); ++s)
        length_[s] = (position(body_.springs[s].b) - position(body_.springs[s].a)).norm();
}

double slow_down_to(SpringBody& body, double step_s, double arm_ratio)
{
    if (!(step_s > 0.0) || !std::isfinite(step_s))
        throw InputError("a step must be positive, got " + std::to_string(step_s));
    const double stable = SpringMotion(body, { .arm_ratio = arm_ratio }).stable_step();
    const double factor
        = std::max(1.0, (step_s / stable) * (step_s / stable) * (1.0 + 1e-9)); // the bound is proportional to sqrt(m)
    for (double& mass : body.mass)
        mass *= factor;
    return factor;
}

} // namespace retractor::haptics
