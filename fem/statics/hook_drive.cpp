#include "fem/statics/hook_drive.h"

#include "fem/linear_algebra/dense_algebra.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace retractor::fem {

namespace {

    constexpr double kSoftest = 1e-6; // relative to the stiffest mode of the hooks

    /// Minimises x^T H x / 2 + c^T x over x >= 0 by an active set, from a given x. H is raised by round-off.
    Eigen::VectorXd lowest_over_positive(Eigen::MatrixXd H, const Eigen::VectorXd& c, Eigen::VectorXd x)
    {
        constexpr double kLift = 1e-13;
        H.diagonal() = ((1.0 + kLift) * H.diagonal()).cwiseMax(std::numeric_limits<double>::min());
        std::vector<Eigen::Index> free;
        for (Eigen::Index i = 0; i < x.size(); ++i)
            if (x[i] > 0.0)
                free.push_back(i);
        // Bounds the turns, since round-off can free and stop the same unknown in turns.
        const int most = 10 * static_cast<int>(x.size()) + 10;
        for (int turn = 0; turn < most; ++turn) {
            if (!free.empty()) {
                const Eigen::MatrixXd of_free = H(free, free);
                const Eigen::VectorXd downhill = -(H(free, Eigen::all) * x + c(free));
                const Eigen::VectorXd way = of_free.llt().solve(downhill);
                double share = 1.0;
                for (Eigen::Index i = 0; i < way.size(); ++i)
                    if (way[i] < 0.0)
                        share = std::min(share, -x[free[static_cast<std::size_t>(i)]] / way[i]);
                for (Eigen::Index i = 0; i < way.size(); ++i) {
                    double& moved = x[free[static_cast<std::size_t>(i)]];
                    moved = -way[i] * share >= moved ? 0.0 : moved + share * way[i];
                }
                if (std::erase_if(free, [&](Eigen::Index i) { return !(x[i] > 0.0); }) > 0)
                    continue;
            }
            const Eigen::VectorXd slope = H * x + c;
            Eigen::Index steepest = -1;
            for (Eigen::Index i = 0; i < x.size(); ++i)
                if (x[i] == 0.0 && slope[i] < (steepest < 0 ? 0.0 : slope[steepest]))
                    steepest = i;
            if (steepest < 0)
                break;
            free.push_back(steepest);
        }
        return x;
    }

    /// The hooks that move to a target. The force f of a hook gives its slip, target - d = (1 / grip + rho) f, where
    /// rho >= 0 is the smallest number that keeps |f| within the limit. Hence f = (1 + R M)^-1 f_0, with M = 1 / grip +
    /// rho and f_0 the forces with all hooks at their targets. rho minimises the dual of the hooks' energy. The dual is
    /// smooth and convex, in one unknown per hook that may yield; its slope is (limit^2 - |f|^2) / 2, its curvature F^T
    /// (1 + R M)^-1 R F, with the force of each hook in a column of F.
    class YieldSearch {
    public:
        /// @param R, at_targets of the rows that the hooks prescribe: one of a hook along which only it prescribes,
        /// three of another
        YieldSearch(const Eigen::MatrixXd& R, Eigen::VectorXd at_targets, const std::vector<HookDrive>& drives)
            : R_(R)
            , at_targets_(std::move(at_targets))
            , grip_(at_targets_.size())
        {
            Eigen::Index at = 0;
            for (std::size_t h = 0; h < drives.size(); ++h) {
                const Eigen::Index rows = drives[h].only_along ? 1 : 3;
                grip_.segment(at, rows).setConstant(1.0 / drives[h].grip_N_per_mm);
                if (std::isfinite(drives[h].force_limit_N))
                    may_yield_.push_back({ h, at, rows, drives[h].force_limit_N });
                at += rows;
            }
            RETRACTOR_ASSERT(at == at_targets_.size());
            rho_ = Eigen::VectorXd::Zero(count());
        }

        /// Newton's method over rho >= 0; each step is shortened until the energy falls enough. The energy is strictly
        /// convex, so the method ends at its minimum from any start. Where the forces of stiff tissue are many times
        /// the limit, a step from a small rho enlarges rho by half.
        /// @return false where round-off leaves no digits, R is not positive definite, or numbers are NaN
        bool search()
        {
            constexpr int kSearchSteps = 400; // forces of 1e9 times the limit take about 60 steps
            constexpr double kExact = 1e-13, kRoundOff = 1e-6; // relative to a limit
            if (!forces(rho_, force_))
                return false;
            double off = off_limits();
            for (int step = 0; step < kSearchSteps && off > kExact; ++step) {
                if (!newton_step())
                    break;
                const double was = std::exchange(off, off_limits());
                // Steps near the end square the error; a slower step is round-off.
                if (was <= kRoundOff && !(off < 0.5 * was))
                    break;
            }
            return off <= kRoundOff;
        }

        Eigen::VectorXd slip() const { return yielding(rho_).cwiseProduct(force_); }
        std::vector<std::size_t> yielded() const
        {
            std::vector<std::size_t> yielded;
            for (Eigen::Index i = 0; i < count(); ++i)
                if (rho_[i] > 0.0)
                    yielded.push_back(limited(i).hook);
            return yielded;
        }

    private:
        struct Limited {
            std::size_t hook = 0;
            Eigen::Index at = 0, rows = 3; ///< first row of the hook, and number of rows
            double limit_N = 0.0;
        };

        Eigen::Index count() const { return static_cast<Eigen::Index>(may_yield_.size()); }
        const Limited& limited(Eigen::Index i) const { return may_yield_[static_cast<std::size_t>(i)]; }
        Eigen::VectorXd force_of(Eigen::Index i) const { return force_.segment(limited(i).at, limited(i).rows); }

        Eigen::VectorXd yielding(const Eigen::VectorXd& rho) const
        {
            Eigen::VectorXd M = grip_;
            for (Eigen::Index i = 0; i < count(); ++i)
                M.segment(limited(i).at, limited(i).rows).array() += rho[i];
            return M;
        }

        bool forces(const Eigen::VectorXd& rho, Eigen::VectorXd& found)
        {
            Eigen::MatrixXd system = R_ * yielding(rho).asDiagonal();
            system.diagonal().array() += 1.0;
            factor_.compute(system);
            found = factor_.solve(at_targets_);
            return found.allFinite();
        }

        /// Largest deviation of a force from its limit, relative to the limit.
        double off_limits() const
        {
            double worst = 0.0;
            for (Eigen::Index i = 0; i < count(); ++i) {
                const double over = force_of(i).norm() / limited(i).limit_N - 1.0;
                worst = std::max(worst, rho_[i] > 0.0 ? std::abs(over) : over);
            }
            return worst;
        }

        bool newton_step()
        {
            Eigen::MatrixXd F = Eigen::MatrixXd::Zero(force_.size(), count());
            Eigen::VectorXd slope(count());
            for (Eigen::Index i = 0; i < count(); ++i) {
                F.col(i).segment(limited(i).at, limited(i).rows) = force_of(i);
                const double force = force_of(i).norm(), limit = limited(i).limit_N;
                slope[i] = 0.5 * (limit - force) * (limit + force);
            }
            Eigen::MatrixXd curvature = F.transpose() * factor_.solve(R_ * F);
            curvature = (0.5 * (curvature + curvature.transpose())).eval();
            return go_towards(lowest_over_positive(curvature, slope - curvature * rho_, rho_), slope);
        }

        bool go_towards(const Eigen::VectorXd& to, const Eigen::VectorXd& slope)
        {
            const Eigen::VectorXd way = to - rho_;
            const double predicted = slope.dot(way);
            if (!(predicted < 0.0))
                return false;
            constexpr double kArmijo = 1e-4, kShortest = 1e-9;
            Eigen::VectorXd there, force;
            for (double share = 1.0; share > kShortest; share *= 0.5) {
                there = share == 1.0 ? to : Eigen::VectorXd(rho_ + share * way);
                if (!forces(there, force))
                    continue;
                double change = 0.0; // of the energy, computed without a difference of large numbers
                for (Eigen::Index i = 0; i < count(); ++i) {
                    const double limit = limited(i).limit_N;
                    const auto new_force = force.segment(limited(i).at, limited(i).rows);
                    change += 0.5 * share * way[i] * (limit * limit - force_of(i).dot(new_force));
                }
                if (change <= kArmijo * share * predicted) {
                    rho_ = there;
                    force_ = force;
                    return true;
                }
            }
            return false;
        }

        const Eigen::MatrixXd& R_;
        Eigen::VectorXd at_targets_, grip_, rho_, force_;
        std::vector<Limited> may_yield_;
        Eigen::PartialPivLU<Eigen::MatrixXd> factor_; ///< of 1 + R M at the last call of forces()
    };

    bool good(double positive) { return positive > 0.0; } // false for NaN

    bool slides(const HookDrive& drive) { return !drive.force_N && drive.only_along.has_value(); }

    /// A basis of the hooks' unknowns in which a hook with HookDrive::only_along prescribes its first one.
    Eigen::MatrixXd axes_of(const std::vector<HookDrive>& drives)
    {
        const auto unknowns = 3 * static_cast<Eigen::Index>(drives.size());
        Eigen::MatrixXd axes = Eigen::MatrixXd::Identity(unknowns, unknowns);
        for (std::size_t h = 0; h < drives.size(); ++h)
            if (slides(drives[h])) {
                const auto at = 3 * static_cast<Eigen::Index>(h);
                axes.block<3, 3>(at, at)
                    = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitX(), *drives[h].only_along).toRotationMatrix();
            }
        return axes;
    }

    std::vector<HookDrive> along_axes(std::vector<HookDrive> drives, const Eigen::MatrixXd& axes)
    {
        for (std::size_t h = 0; h < drives.size(); ++h)
            if (slides(drives[h])) {
                const auto at = 3 * static_cast<Eigen::Index>(h);
                drives[h].displacement = axes.block<3, 3>(at, at).transpose() * drives[h].displacement;
                drives[h].only_along = Vec3::UnitX();
            }
        return drives;
    }

    /// rest_of_hooks() of hooks that prescribe along the first of their axes, or along all.
    HookRest rest_along_axes(const Eigen::MatrixXd& R, const Eigen::VectorXd& r, const std::vector<HookDrive>& drives)
    {
        RETRACTOR_ASSERT(R.rows() == r.size() && R.cols() == r.size());
        std::vector<Eigen::Index> forced, drawn; // rows with a force, which is 0 where tissue slides, and with a target
        std::vector<HookDrive> drawing;
        std::vector<std::size_t> hook_of_drawing;
        Eigen::VectorXd given = Eigen::VectorXd::Zero(r.size()); // per row: the force or the target
        for (std::size_t h = 0; h < drives.size(); ++h) {
            const auto at = 3 * static_cast<Eigen::Index>(h);
            given.segment<3>(at) = drives[h].force_N.value_or(drives[h].displacement);
            if (slides(drives[h]))
                given.segment<2>(at + 1).setZero();
            for (Eigen::Index row = at; row < at + 3; ++row)
                (drives[h].force_N || (slides(drives[h]) && row > at) ? forced : drawn).push_back(row);
            if (drives[h].force_N)
                continue;
            drawing.push_back(drives[h]);
            hook_of_drawing.push_back(h);
        }
        HookRest rest { .displacement = given, .yielded = std::vector<bool>(drives.size(), false) };
        // Hooks with a given force move freely under this force. The other hooks therefore feel the stiffness with the
        // force-driven hooks condensed.
        Eigen::MatrixXd seen = R(drawn, drawn);
        Eigen::VectorXd offset = r(drawn);
        Eigen::LLT<Eigen::MatrixXd> free;
        if (!forced.empty()) {
            free.compute(R(forced, forced));
            const Eigen::MatrixXd across = R(forced, drawn);
            seen -= across.transpose() * free.solve(across);
            const Eigen::VectorXd pull = given(forced) - r(forced);
            offset += across.transpose() * free.solve(pull);
            seen = (0.5 * (seen + seen.transpose())).eval();
        }
        YieldSearch search(seen, seen * given(drawn) + offset, drawing);
        rest.converged = (forced.empty() || free.info() == Eigen::Success) && search.search();
        rest.displacement(drawn) -= search.slip();
        if (!forced.empty()) {
            const Eigen::VectorXd pull = given(forced) - r(forced) - R(forced, drawn) * rest.displacement(drawn);
            const Eigen::VectorXd along = free.solve(pull);
            rest.displacement(forced) = along;
        }
        for (const std::size_t i : search.yielded())
            rest.yielded[hook_of_drawing[i]] = true;
        if (!rest.displacement.allFinite()) {
            rest.displacement.setZero();
            rest.converged = false;
        }
        return rest;
    }

} // namespace

bool HookDrive::prescribes() const
{
    return !force_N && std::isinf(grip_N_per_mm) && std::isinf(force_limit_N) && !only_along;
}

std::vector<HookDrive> prescribed_drives(std::span<const Vec3> displacements)
{
    std::vector<HookDrive> drives;
    for (const Vec3& displacement : displacements)
        drives.push_back({ .displacement = displacement });
    return drives;
}

HookDrive between(const HookDrive& from, const HookDrive& to, double share)
{
    HookDrive drive = to;
    drive.displacement = from.displacement + share * (to.displacement - from.displacement);
    if (to.force_N) {
        const Vec3 force = from.force_N.value_or(Vec3::Zero());
        drive.force_N = force + share * (*to.force_N - force);
    }
    return drive;
}

void check_drive(const HookDrive& drive, const std::string& name)
{
    const std::string where = "hook '" + name + "'";
    if (!drive.displacement.allFinite() || (drive.force_N && !drive.force_N->allFinite()))
        throw InputError("a hook's displacement and force must be finite", where);
    if (!good(drive.grip_N_per_mm) || !good(drive.force_limit_N))
        throw InputError("a hook's grip and force limit must be positive", where);
    constexpr double kUnit = 1e-9; // round-off of a normalised vector
    if (drive.only_along && !(std::abs(drive.only_along->norm() - 1.0) <= kUnit))
        throw InputError("the direction along which a hook prescribes the displacement must be a unit vector", where);
}

HookRest rest_of_hooks(const Eigen::MatrixXd& R, const Eigen::VectorXd& r, const std::vector<HookDrive>& drives)
{
    if (std::none_of(drives.begin(), drives.end(), slides))
        return rest_along_axes(R, r, drives);
    const Eigen::MatrixXd axes = axes_of(drives);
    HookRest rest = rest_along_axes(axes.transpose() * R * axes, axes.transpose() * r, along_axes(drives, axes));
    rest.displacement = axes * rest.displacement;
    return rest;
}

Eigen::MatrixXd definite(const Eigen::MatrixXd& R)
{
    RETRACTOR_ASSERT(R.rows() == R.cols());
    const SymmetricModes modes = symmetric_modes(R);
    const double least = kSoftest * modes.values.cwiseAbs().maxCoeff();
    if (modes.values.minCoeff() >= least)
        return R;
    return modes.vectors * modes.values.cwiseAbs().cwiseMax(least).asDiagonal() * modes.vectors.transpose();
}

Eigen::VectorXd resisted(const Eigen::MatrixXd& R, const Eigen::VectorXd& forces)
{
    RETRACTOR_ASSERT(R.rows() == R.cols() && R.rows() == forces.size());
    const SymmetricModes modes = symmetric_modes(R);
    const double least = kSoftest * modes.values.cwiseAbs().maxCoeff();
    Eigen::VectorXd in_modes = modes.vectors.transpose() * forces;
    for (Eigen::Index m = 0; m < in_modes.size(); ++m)
        if (std::abs(modes.values[m]) < least)
            in_modes[m] = 0.0;
    return modes.vectors * in_modes;
}

Eigen::VectorXd packed(const std::vector<Vec3>& of_hooks)
{
    Eigen::VectorXd x(3 * static_cast<Eigen::Index>(of_hooks.size()));
    for (std::size_t h = 0; h < of_hooks.size(); ++h)
        x.segment<3>(3 * static_cast<Eigen::Index>(h)) = of_hooks[h];
    return x;
}

std::vector<Vec3> per_hook(const Eigen::VectorXd& unknowns)
{
    RETRACTOR_ASSERT(unknowns.size() % 3 == 0);
    std::vector<Vec3> of(static_cast<std::size_t>(unknowns.size() / 3));
    for (std::size_t h = 0; h < of.size(); ++h)
        of[h] = unknowns.segment<3>(3 * static_cast<Eigen::Index>(h));
    return of;
}

} // namespace retractor::fem
