#pragma once
// The rest of hooks that pull with a force, grip softly, or yield at a limit. The problem has three unknowns per hook,
// on the stiffness of the tissue at the hooks. Units mm, N.

#include "mesh/base/geometry.h"

#include <Eigen/Core>

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace retractor::fem {

/// The drive of a hook. The tissue under the hook moves rigidly by a displacement d. With `force_N`, the hook pulls
/// with this force. Otherwise the hook moves to `displacement`, and a grip (a spring) connects hook and lip. The hook
/// slips where the force would exceed the limit: the force then has the magnitude of the limit and the direction of the
/// slip.
struct HookDrive {
    Vec3 displacement = Vec3::Zero(); ///< mm
    std::optional<Vec3> force_N {};
    /// Stiffness of the grip, > 0; infinite: the lip follows completely.
    double grip_N_per_mm = std::numeric_limits<double>::infinity();
    double force_limit_N = std::numeric_limits<double>::infinity(); ///< > 0
    /// Unit vector; not set: the hook prescribes the whole displacement. Set, as for the blade of a retractor: the hook
    /// prescribes the displacement along it, and the tissue slides across it without friction. A hook that pulls with a
    /// force lets tissue slide in any case.
    std::optional<Vec3> only_along {};

    bool prescribes() const; ///< d is `displacement`, whatever the tissue does
    bool operator==(const HookDrive&) const = default;
};

std::vector<HookDrive> prescribed_drives(std::span<const Vec3> displacements);

/// The drive at `share` of the way from `from` to `to`, in displacement or force. Grip and limit are those of `to`.
HookDrive between(const HookDrive& from, const HookDrive& to, double share);

/// @throws InputError naming the hook when a number is NaN or out of range.
void check_drive(const HookDrive& drive, const std::string& name);

/// The equilibrium of the hooks.
struct HookRest {
    Eigen::VectorXd displacement; ///< d, three per hook
    bool converged = true; ///< false: unusable, because R is not positive definite or almost singular
    std::vector<bool> yielded; ///< per hook: the force limit is reached
};

/// The displacement at which the force R d + r of each hook satisfies its drive. This is the minimum of a convex
/// energy, found by Newton's method on the dual (Boyd, Vandenberghe 2004, Convex Optimization, 5.5 and 9.5), for any
/// stiffness and any number of yielding hooks. Forces stay within their limits to 1e-6 at worst, and to round-off where
/// R allows.
/// @param R stiffness at the hooks, symmetric positive definite, N/mm
/// @param r forces at d = 0, N
HookRest rest_of_hooks(const Eigen::MatrixXd& R, const Eigen::VectorXd& r, const std::vector<HookDrive>& drives);

/// Returns R with the absolute values of its eigenvalues, at least a millionth of the largest. The rest of hooks needs
/// a positive definite stiffness. The tangent of nonlinear tissue near a limit point is not definite, and nothing
/// resists hooks on a body that floats.
Eigen::MatrixXd definite(const Eigen::MatrixXd& R);

/// Returns the forces without their part along modes without stiffness, where definite() raises an eigenvalue near
/// zero. Such forces are round-off.
Eigen::VectorXd resisted(const Eigen::MatrixXd& R, const Eigen::VectorXd& forces);

/// Conversion between one vector per hook and a vector of three unknowns per hook.
Eigen::VectorXd packed(const std::vector<Vec3>& of_hooks);
std::vector<Vec3> per_hook(const Eigen::VectorXd& unknowns);

} // namespace retractor::fem
