#include "tests/verification/framework/condition.h"

#include "fem/linear_algebra/constrained_solver.h"

#include <cmath>

namespace retractor::verification {

namespace {

    /// Largest eigenvalue of a symmetric positive operator, by power iteration.
    template <class Apply> double largest_eigenvalue(const Eigen::VectorXd& free, const Apply& apply)
    {
        constexpr int kMostSteps = 300;
        constexpr double kSettled = 1e-4; // relative change of the eigenvalue per step
        Eigen::VectorXd q(free.size());
        for (Eigen::Index i = 0; i < q.size(); ++i) // a start vector without preferred direction, the same in every run
            q[i] = free[i] * std::sin(1.0 + 12.9898 * static_cast<double>(i));
        double value = 0.0;
        for (int k = 0; k < kMostSteps; ++k) {
            q /= q.norm();
            Eigen::VectorXd w = apply(q);
            const double before = value;
            value = q.dot(w);
            q.swap(w);
            if (k > 4 && std::abs(value - before) <= kSettled * value)
                break;
        }
        return value;
    }

    Eigen::VectorXd diagonal(const fem::BlockMatrix& K)
    {
        Eigen::VectorXd d = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * K.pattern.row_count()));
        for (std::size_t row = 0; row < K.pattern.row_count(); ++row)
            if (K.pattern.row_start[row] < K.pattern.row_start[row + 1])
                for (std::size_t axis = 0; axis < 3; ++axis)
                    d[static_cast<Eigen::Index>(3 * row + axis)]
                        = K.values[9 * static_cast<std::size_t>(K.pattern.row_start[row + 1] - 1) + 4 * axis];
        return d;
    }

} // namespace

ConditionEstimate estimate_condition(const fem::BlockMatrix& K, const std::vector<std::uint8_t>& prescribed)
{
    fem::ConstrainedSolver solver(K.pattern, prescribed);
    if (solver.free_count() == 0)
        return { 1.0, 1.0 };
    solver.factorise(K);
    const Eigen::VectorXd d = diagonal(K);
    Eigen::VectorXd free = (d.array() > 0.0).cast<double>();
    solver.mask(free);
    const Eigen::VectorXd root = free.cwiseProduct(d.cwiseSqrt());
    const Eigen::VectorXd inverse_root = free.cwiseQuotient(d.cwiseMax(1e-300).cwiseSqrt());
    const auto multiply = [&](const Eigen::VectorXd& x) { return Eigen::VectorXd(K.multiply(x).cwiseProduct(free)); };
    const auto solve = [&](const Eigen::VectorXd& x) { return solver.solve(x); };
    ConditionEstimate estimate;
    estimate.number = largest_eigenvalue(free, multiply) * largest_eigenvalue(free, solve);
    estimate.scaled = largest_eigenvalue(free, [&](const Eigen::VectorXd& x) {
        return Eigen::VectorXd(multiply(inverse_root.cwiseProduct(x)).cwiseProduct(inverse_root));
    }) * largest_eigenvalue(free, [&](const Eigen::VectorXd& x) {
        return Eigen::VectorXd(solve(root.cwiseProduct(x)).cwiseProduct(root));
    });
    return estimate;
}

} // namespace retractor::verification
