#include "tests/verification/framework/spring_dynamics.h"

#include "mesh/base/error.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace retractor::verification {

namespace {

    /// Largest eigenvalue of a symmetric operator by Lanczos' method, plus its residual.
    template <class Apply> double largest_eigenvalue(Eigen::Index size, const Apply& apply)
    {
        constexpr int kMostSteps = 120;
        constexpr double kSharp = 1e-6; // accuracy relative to the eigenvalue
        Eigen::VectorXd q(size), before = Eigen::VectorXd::Zero(size);
        for (Eigen::Index i = 0; i < size; ++i) // a start vector without preferred direction, the same on every run
            q[i] = std::sin(1.0 + 12.9898 * static_cast<double>(i));
        q.normalize();
        std::vector<double> alpha, beta;
        double bound = 0.0, off = 0.0;
        for (int k = 0; k < kMostSteps; ++k) {
            Eigen::VectorXd w = apply(q) - off * before;
            alpha.push_back(q.dot(w));
            w -= alpha.back() * q;
            off = w.norm();
            const auto n = static_cast<Eigen::Index>(alpha.size());
            Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen;
            eigen.computeFromTridiagonal(Eigen::Map<const Eigen::VectorXd>(alpha.data(), n),
                Eigen::Map<const Eigen::VectorXd>(beta.data(), n - 1), Eigen::ComputeEigenvectors);
            const double value = eigen.eigenvalues()[n - 1];
            const double residual = off * std::abs(eigen.eigenvectors()(n - 1, n - 1));
            bound = value + residual;
            if (!(residual > kSharp * value) || !(off > 0.0) || n == size)
                break;
            beta.push_back(off);
            before = std::exchange(q, w / off);
        }
        return bound;
    }

} // namespace

SpringDynamics::SpringDynamics(
    const fem::SpringNetwork& network, std::span<const fem::Material> material_of_label, double damping)
    : patch_(network, fem::vertices_near_wound(network, 0.0))
    , damping_(damping)
    , shortest_(std::numeric_limits<double>::infinity())
    , u_(patch_.displacement())
    , v_(Eigen::VectorXd::Zero(u_.size()))
{
    if (!(damping >= 0.0 && std::isfinite(damping)))
        throw InputError("damping must be finite and not negative", "damping");
    for (const VertexId v : patch_.active()) {
        double mass = 0.0;
        for (const TetId t : network.elements(v)) {
            if (network.label(t) >= material_of_label.size())
                throw InputError("there is no material for a label", "label " + std::to_string(network.label(t)));
            const fem::Material& material = material_of_label[network.label(t)];
            fem::check_material(material);
            mass += 0.25 * network.rest_volume(t) * material.density_tonne_per_mm3;
        }
        mass_.push_back(mass);
        for (const fem::SpringEnd& end : network.springs(v))
            shortest_ = std::min(shortest_, end.length);
    }
    compute_bound();
}

void SpringDynamics::compute_bound()
{
    patch_.linearise(u_);
    const auto scaled = [&](const Eigen::VectorXd& x) {
        Eigen::VectorXd y(x.size());
        for (std::size_t i = 0; i < mass_.size(); ++i)
            y.segment<3>(3 * static_cast<Eigen::Index>(i))
                = x.segment<3>(3 * static_cast<Eigen::Index>(i)) / std::sqrt(mass_[i]);
        return y;
    };
    const double largest
        = largest_eigenvalue(u_.size(), [&](const Eigen::VectorXd& x) { return scaled(patch_.multiply(scaled(x))); });
    bound_.largest_frequency = std::sqrt(largest);
    bound_.stable_step = 2.0 / bound_.largest_frequency;
    bound_at_ = u_;
}

void SpringDynamics::step(double dt)
{
    if ((u_ - bound_at_).lpNorm<Eigen::Infinity>() > kRecheck * shortest_)
        compute_bound();
    if (!(dt > 0.0) || !(dt <= bound_.stable_step))
        throw InputError("a time step of " + std::to_string(dt * 1e6) + " us is not within (0, "
                + std::to_string(bound_.stable_step * 1e6)
                + "] us, where the explicit scheme is stable on this network; relax() has no such bound",
            "dt");
    const Eigen::VectorXd force = patch_.response(u_).forces;
    for (std::size_t i = 0; i < mass_.size(); ++i) {
        const auto at = 3 * static_cast<Eigen::Index>(i);
        v_.segment<3>(at) = (v_.segment<3>(at) - dt / mass_[i] * force.segment<3>(at)) / (1.0 + damping_ * dt);
    }
    u_ += dt * v_;
}

double SpringDynamics::kinetic_energy() const
{
    double energy = 0.0;
    for (std::size_t i = 0; i < mass_.size(); ++i)
        energy += 0.5 * mass_[i] * v_.segment<3>(3 * static_cast<Eigen::Index>(i)).squaredNorm();
    return energy;
}

double SpringDynamics::potential_energy() const { return patch_.response(u_).energy; }

void SpringDynamics::set_state(Eigen::VectorXd displacement, Eigen::VectorXd velocity)
{
    if (displacement.size() != u_.size() || velocity.size() != v_.size())
        throw InputError("a state needs three entries per active vertex", "state");
    if (!displacement.allFinite() || !velocity.allFinite())
        throw InputError("a state must be finite", "state");
    u_ = std::move(displacement);
    v_ = std::move(velocity);
    compute_bound();
}

} // namespace retractor::verification
