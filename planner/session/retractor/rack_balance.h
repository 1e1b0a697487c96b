#pragma once
// Where the rack of a retractor comes to rest that only the tissue carries: both blades then bear the same force along
// it. Units mm, N.

#include <optional>
#include <utility>

namespace retractor::planner {

/// The shift of a rack along itself, found step by step from the forces of its blades (secant method). In linear tissue
/// the second step is exact.
class RackBalance {
public:
    /// Largest difference of the blades' forces at rest, relative to the larger force: as plans with blades in contact
    /// ask for.
    static constexpr double kTolerance = 0.02;

    void start_at(double shift_mm) { shift_mm_ = shift_mm; }
    double shift_mm() const { return shift_mm_; } ///< towards the first blade's side
    /// The rack opens further, or less: in linear tissue the shift grows in proportion.
    void open(double from_mm, double to_mm);
    /// Takes the forces by which the rack pushes its blades outwards at the present shift.
    /// @return whether the rack has moved, because they are not in balance
    bool step(double first_N, double second_N);
    /// The tissue has changed: what was learned of it no longer holds.
    void forget()
    {
        last_.reset();
        slope_N_per_mm_ = 0.0;
    }

private:
    double shift_mm_ = 0.0;
    double slope_N_per_mm_ = 0.0; ///< growth of the difference of the forces with the shift; 0: unknown
    std::optional<std::pair<double, double>> last_; ///< shift and difference
};

} // namespace retractor::planner
