#pragma once
// Which points of a contact press, and how hard: forces f >= 0 with C f >= d and f (C f - d) = 0, C the compliance of
// the points along their normals (mm/N) and d how far each must give way (mm). Contact pushes and never pulls.
//
// Block principal pivoting [Portugal, Judice, Vicente 1994], warm: all infeasible points change sides at once, and one
// at a time (the last, after [Murty 1974]) where that does not lessen them; C is positive definite, so it ends.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace retractor::haptics {

class ContactSolver {
public:
    /// Makes room for so many points; nothing is allocated later.
    explicit ContactSolver(std::size_t capacity);

    /// The compliance between points a and b. Only b <= a is read.
    double& compliance(std::size_t a, std::size_t b) noexcept { return compliance_[a * capacity_ + b]; }
    double& demand(std::size_t a) noexcept { return demand_[a]; }
    /// Whether a point presses: a guess before solve(), the answer after it.
    std::uint8_t& pressing(std::size_t a) noexcept { return pressing_[a]; }
    double force(std::size_t a) const noexcept { return force_[a]; }

    /// @return false when no answer was found (the compliance is not positive definite).
    [[nodiscard]] bool solve(std::size_t points) noexcept;
    /// The forces of the points marked as pressing when these give way exactly by their demand, pulled where need be.
    [[nodiscard]] bool hold(std::size_t points) noexcept;

    /// Sum of the forces on points [first, last) per unit that these give way together, the other pressing points held.
    /// @pre solve() succeeded.
    double stiffness(std::size_t first, std::size_t last) noexcept;

    int factorisations() const noexcept { return factorisations_; } ///< of the last solve()

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
