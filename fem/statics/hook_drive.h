#pragma once
// Where hooks come to rest that do not simply prescribe a displacement: driven by force, gripping softly, or yielding
// at a limit. A problem in three unknowns per hook, on the stiffness that the tissue shows them. Units mm, N.

#include "mesh/base/geometry.h"

#include <Eigen/Core>

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace retractor::fem {

/// What drives a hook. The tissue under it moves as one, by some d. With `force_N` set, the hook pulls with this force.
/// Otherwise it is drawn to `displacement` through a grip (how well the lip follows), and slips when the force would
/// pass the limit: then the force has the limit's size and the slip its direction.
struct HookDrive {
    Vec3 displacement = Vec3::Zero(); ///< mm
    std::optional<Vec3> force_N {};
    double grip_N_per_mm = std::numeric_limits<double>::infinity(); ///< > 0; infinite: it follows completely
    double force_limit_N = std::numeric_limits<double>::infinity(); ///< > 0

    bool prescribes() const; ///< d is `displacement`, whatever the tissue does
    bool operator==(const HookDrive&) const = default;
};

std::vector<HookDrive> prescribed_drives(std::span<const Vec3> displacements);

/// Drawn so far, or pulled so hard, between `from` and `to`: 1 is `to`, whose grip and limit hold throughout.
HookDrive between(const HookDrive& from, const HookDrive& to, double share);

/// @throws InputError naming the hook when a number is NaN or out of range.
void check_drive(const HookDrive& drive, const std::string& name);

struct HookRest {
    Eigen::VectorXd displacement; ///< d, three per hook
    bool converged = true; ///< else it is of no use: R is not positive definite, or as good as singular
    std::vector<bool> yielded; ///< per hook: the limit holds it back
};

/// The d at which each hook's force R d + r is what its drive gives: the minimum of a convex energy, found by Newton's
/// method on its dual (Boyd, Vandenberghe, Convex Optimization, 5.5 and 9.5), however stiff the tissue and however many
/// yield. Forces keep to their limits to 1e-6 at worst, to round-off where R allows it. @param R symmetric positive
/// definite, N/mm; @param r forces at d = 0, N.
HookRest rest_of_hooks(const Eigen::MatrixXd& R, const Eigen::VectorXd& r, const std::vector<HookDrive>& drives);

/// R with the sizes of its eigenvalues in their place, none below a millionth of the largest: near a limit point the
/// tangent of nonlinear tissue is not definite, nothing resists hooks that a body floats on, and where hooks rest needs
/// a stiffness that is definite.
Eigen::MatrixXd definite(const Eigen::MatrixXd& R);

/// Forces without what would move the hooks where nothing resists: where definite() raises an eigenvalue from about
/// zero, forces are round-off.
Eigen::VectorXd resisted(const Eigen::MatrixXd& R, const Eigen::VectorXd& forces);

/// Three unknowns per hook, one hook after the other; and back.
Eigen::VectorXd packed(const std::vector<Vec3>& of_hooks);
std::vector<Vec3> per_hook(const Eigen::VectorXd& unknowns);

} // namespace retractor::fem
