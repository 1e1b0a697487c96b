#include "haptics/condensed/contact_solver.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <cmath>

namespace retractor::haptics {

ContactSolver::ContactSolver(std::size_t capacity)
    : capacity_(capacity)
    , compliance_(capacity * capacity, 0.0)
    , demand_(capacity, 0.0)
    , force_(capacity, 0.0)
    , factor_(capacity * capacity, 0.0)
    , right_(capacity, 0.0)
    , inverse_diagonal_(capacity, 0.0)
    , pressing_(capacity, 0)
    , active_(capacity, 0)
{
}

bool ContactSolver::factorise() noexcept
{
    ++factorisations_;
    active_count_ = 0;
    for (std::size_t a = 0; a < points_; ++a)
        if (pressing_[a] != 0)
            active_[active_count_++] = a;
    for (std::size_t i = 0; i < active_count_; ++i) {
        double* row = factor_.data() + i * capacity_;
        const double* from = compliance_.data() + active_[i] * capacity_;
        for (std::size_t j = 0; j <= i; ++j) {
            const double* other = factor_.data() + j * capacity_;
            double sum = from[active_[j]];
            for (std::size_t k = 0; k < j; ++k)
                sum -= row[k] * other[k];
            if (j < i) {
                row[j] = sum * inverse_diagonal_[j];
            } else {
                if (!(sum > 0.0))
                    return false;
                row[i] = std::sqrt(sum);
                inverse_diagonal_[i] = 1.0 / row[i];
            }
        }
    }
    return true;
}

void ContactSolver::substitute(std::vector<double>& x) const noexcept
{
    for (std::size_t i = 0; i < active_count_; ++i) {
        const double* row = factor_.data() + i * capacity_;
        double sum = x[i];
        for (std::size_t k = 0; k < i; ++k)
            sum -= row[k] * x[k];
        x[i] = sum * inverse_diagonal_[i];
    }
    for (std::size_t i = active_count_; i-- > 0;) {
        x[i] *= inverse_diagonal_[i];
        const double* row = factor_.data() + i * capacity_;
        for (std::size_t k = 0; k < i; ++k)
            x[k] -= row[k] * x[i];
    }
}

void ContactSolver::find_forces(std::size_t points) noexcept
{
    RETRACTOR_ASSERT(active_count_ <= points);
    for (std::size_t i = 0; i < active_count_; ++i)
        right_[i] = demand_[active_[i]];
    substitute(right_);
    std::fill(force_.begin(), force_.begin() + static_cast<std::ptrdiff_t>(points), 0.0);
    for (std::size_t i = 0; i < active_count_; ++i)
        force_[active_[i]] = right_[i];
}

bool ContactSolver::hold(std::size_t points) noexcept
{
    RETRACTOR_ASSERT(points <= capacity_);
    points_ = points;
    factorisations_ = 0;
    if (!factorise())
        return false;
    find_forces(points);
    return true;
}

bool ContactSolver::solve(std::size_t points) noexcept
{
    RETRACTOR_ASSERT(points <= capacity_);
    points_ = points;
    factorisations_ = 0;
    double largest = 0.0;
    for (std::size_t a = 0; a < points; ++a)
        largest = std::max(largest, std::abs(demand_[a]));
    const double slack = 1e-12 * largest; // mm; round-off of C f - d
    constexpr int kTries = 3;
    const int limit = 20 + 4 * static_cast<int>(points);
    std::size_t fewest = points + 1;
    for (int tries = kTries; factorisations_ < limit;) {
        if (!factorise())
            return false;
        find_forces(points);
        std::size_t wrong = 0, last = 0;
        const auto infeasible = [&](std::size_t a) {
            if (pressing_[a] != 0)
                return force_[a] < 0.0;
            double gap = -demand_[a];
            for (std::size_t i = 0; i < active_count_; ++i) {
                const std::size_t b = active_[i];
                gap += (b <= a ? compliance_[a * capacity_ + b] : compliance_[b * capacity_ + a]) * right_[i];
            }
            return gap < -slack;
        };
        for (std::size_t a = 0; a < points; ++a)
            if (infeasible(a)) {
                ++wrong;
                last = a;
                pressing_[a] = static_cast<std::uint8_t>(pressing_[a] | 2U);
            }
        if (wrong == 0)
            return true;
        const bool all = wrong < fewest || tries > 0;
        tries = wrong < fewest ? kTries : tries - 1;
        fewest = std::min(fewest, wrong);
        for (std::size_t a = 0; a < points; ++a)
            if ((pressing_[a] & 2U) != 0)
                pressing_[a]
                    = static_cast<std::uint8_t>(all || a == last ? 1U - (pressing_[a] & 1U) : pressing_[a] & 1U);
    }
    return false;
}

double ContactSolver::stiffness(std::size_t first, std::size_t last) noexcept
{
    RETRACTOR_ASSERT(first <= last);
    double sum = 0.0;
    for (std::size_t i = 0; i < active_count_; ++i)
        right_[i] = active_[i] >= first && active_[i] < last ? 1.0 : 0.0;
    substitute(right_);
    for (std::size_t i = 0; i < active_count_; ++i)
        if (active_[i] >= first && active_[i] < last)
            sum += right_[i];
    return sum;
}

} // namespace retractor::haptics
