#include "fem/hook_drive.h"

#include "mesh/base/error.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace retractor {

namespace {

    struct OneRest {
        Vec3 displacement = Vec3::Zero();
        bool yielded = false;
    };

    /// One hook alone: its force is R d + c.
    OneRest rest_of_one(const Mat3& R, const Vec3& c, const HookDrive& drive)
    {
        if (drive.force_N)
            return { R.llt().solve(*drive.force_N - c), false };
        const bool stiff = std::isinf(drive.grip_N_per_mm);
        OneRest rest { drive.displacement, false };
        if (!stiff) {
            const Mat3 both = R + drive.grip_N_per_mm * Mat3::Identity();
            rest.displacement = both.llt().solve(drive.grip_N_per_mm * drive.displacement - c);
        }
        const double limit = drive.force_limit_N;
        if (!((R * rest.displacement + c).norm() > limit))
            return rest;
        // force = limit n and d = target - rho n, n a unit vector: (limit + rho R) n = b. |n| falls as rho grows.
        const Vec3 b = R * drive.displacement + c;
        const Eigen::SelfAdjointEigenSolver<Mat3> modes(R);
        const Vec3 in_modes = modes.eigenvectors().transpose() * b;
        const auto direction = [&](double rho) {
            return Vec3((in_modes.array() / (limit + rho * modes.eigenvalues().array())).matrix());
        };
        double low = stiff ? 0.0 : limit / drive.grip_N_per_mm, high = std::max(low, 1e-6);
        while (direction(high).norm() > 1.0)
            high *= 2.0;
        constexpr int kHalvings = 200; // to the last bit; ends when there is nothing left to halve
        for (int i = 0; i < kHalvings && high - low > 1e-15 * high; ++i) {
            const double middle = 0.5 * (low + high);
            (direction(middle).norm() > 1.0 ? low : high) = middle;
        }
        return { drive.displacement - high * (modes.eigenvectors() * direction(high).normalized()), true };
    }

    bool good(double positive) { return positive > 0.0; } // false for NaN

} // namespace

bool HookDrive::prescribes() const { return !force_N && std::isinf(grip_N_per_mm) && std::isinf(force_limit_N); }

void check_drive(const HookDrive& drive, const std::string& name)
{
    const std::string where = "hook '" + name + "'";
    if (!drive.displacement.allFinite() || (drive.force_N && !drive.force_N->allFinite()))
        throw InputError("a hook's displacement and force must be finite", where);
    if (!good(drive.grip_N_per_mm) || !good(drive.force_limit_N))
        throw InputError("a hook's grip and force limit must be positive", where);
}

HookRest rest_of_hooks(const Eigen::MatrixXd& R, const Eigen::VectorXd& r, const std::vector<HookDrive>& drives)
{
    HookRest rest;
    rest.displacement = Eigen::VectorXd::Zero(r.size());
    rest.yielded.assign(drives.size(), false);
    for (std::size_t h = 0; h < drives.size(); ++h)
        if (!drives[h].force_N)
            rest.displacement.segment<3>(3 * static_cast<Eigen::Index>(h)) = drives[h].displacement;
    constexpr int kTurns = 10000; // neighbours on one lip pull on each other: dozens are usual
    constexpr double kSettled = 1e-13; // of the largest displacement
    for (int turn = 0; turn < kTurns; ++turn) {
        double change = 0.0;
        for (std::size_t h = 0; h < drives.size(); ++h) {
            const auto at = 3 * static_cast<Eigen::Index>(h);
            const Mat3 own = R.block<3, 3>(at, at);
            const Vec3 d = rest.displacement.segment<3>(at);
            const Vec3 others = R.middleRows<3>(at) * rest.displacement + r.segment<3>(at) - own * d;
            const OneRest one = rest_of_one(own, others, drives[h]);
            rest.displacement.segment<3>(at) = one.displacement;
            rest.yielded[h] = one.yielded;
            change = std::max(change, (one.displacement - d).lpNorm<Eigen::Infinity>());
        }
        if (change <= kSettled * rest.displacement.lpNorm<Eigen::Infinity>())
            return rest;
    }
    rest.converged = false;
    return rest;
}

} // namespace retractor
