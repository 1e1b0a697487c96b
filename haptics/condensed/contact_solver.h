#pragma once
// Finds the points of a contact that press, and their forces: f >= 0, C f >= d and f (C f - d) = 0. C is the compliance
// of the points along their normals (mm/N), and d is the required displacement of each point (mm). Contact pushes and
// never pulls.
//
// Method: block principal pivoting with a warm start (Portugal, Judice, Vicente, Math Comp 63, 1994). All infeasible
// points change sides at once. When this does not lessen their number, only the last infeasible point changes side
// (Murty 1974). C is positive definite, so the method ends.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace retractor::haptics {

class ContactSolver {
public:
    /// Reserves memory for `capacity` points; no later call allocates.
    explicit ContactSolver(std::size_t capacity);

    /// Compliance between points a and b. Only b <= a is read.
    double& compliance(std::size_t a, std::size_t b) noexcept { return compliance_[a * capacity_ + b]; }
    /// Required displacement of point a, mm.
    double& demand(std::size_t a) noexcept { return demand_[a]; }
    /// Whether point a presses: a guess before solve(), the result after solve().
    std::uint8_t& pressing(std::size_t a) noexcept { return pressing_[a]; }
    /// Force of point a, N.
    double force(std::size_t a) const noexcept { return force_[a]; }

    /// @return false when no solution was found, because the compliance is not positive definite
    [[nodiscard]] bool solve(std::size_t points) noexcept;
    /// Computes the forces of the points marked as pressing when each moves exactly by its demand; forces may pull.
    [[nodiscard]] bool hold(std::size_t points) noexcept;

    /// Sum of the forces on points [first, last) per unit of their common displacement, while the other pressing points
    /// stay in place, N/mm.
    /// @pre solve() succeeded
    double stiffness(std::size_t first, std::size_t last) noexcept;

    int factorisations() const noexcept { return factorisations_; } ///< in the last solve()

private:
    bool factorise() noexcept;
    void find_forces(std::size_t points) noexcept;
    void substitute(std::vector<double>& x) const noexcept;

    std::size_t capacity_, points_ = 0, active_count_ = 0;
    std::vector<double> compliance_, demand_, force_, factor_, right_, inverse_diagonal_;
    std::vector<std::uint8_t> pressing_;
    std::vector<std::size_t> active_;
    int factorisations_ = 0;
};

} // namespace retractor::haptics
