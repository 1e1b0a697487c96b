#pragma once
// Where a straight finger, or the shaft of an instrument, can be through an opening in solid surroundings. Units mm.
//
// Either is a round rod, and a finger tapers to its tip. It fits in a place where the tip, and the rod on a straight
// way through the opening into the hand, keep clear of all surroundings. Such a finger could have been put in along its
// own axis, so a place is allowed or not whichever way the finger came. Above the opening the finger stands upright.

#include "haptics/surroundings/distance_grid.h"
#include "mesh/base/geometry.h"

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

namespace retractor::haptics {

struct Opening {
    Vec3 centre = Vec3::Zero();
    Vec3 normal = Vec3::UnitZ(); ///< out of the body, unit
    Vec3 along = Vec3::UnitX(); ///< unit, across `normal`
    double length_mm = 0.0, width_mm = 0.0; ///< along `along` and across it
};

/// A finger, as the measure "touched by a finger" has it (planner/measures/sight/instruments.h), or an instrument.
struct StraightRod {
    double thickness_mm = 16.0;
    double taper_mm = 10.0; ///< from the tip to the full thickness
    double reach_mm = 80.0; ///< below the opening, while the hand stays outside
    double outside_mm = 30.0; ///< length outside that also needs room
};

/// What a rod meets beside an opening.
struct Surroundings {
    std::shared_ptr<const DistanceGrid> around; ///< everything that neither the tip nor the rod passes
    /// The touched structure at rest, which the tip may press in and the rod does not pass; null: not known.
    std::shared_ptr<const DistanceGrid> structure {};
};

class FingerAccess {
public:
    /// @throws InputError on an opening or a finger without extent
    FingerAccess(Surroundings surroundings, const Opening& opening, const StraightRod& finger = {});

    static constexpr int kTooFar = -2; ///< the finger is too short
    static constexpr int kStructure = -3; ///< the touched structure itself lies in the way
    struct Answer {
        bool fits = false;
        Vec3 outward = Vec3::Zero(); ///< from the tip to the hand, unit; where it fits
        /// Where it does not fit: number of a surface (DistanceGrid::names()), kTooFar or kStructure.
        int hindrance = DistanceGrid::kNone;
        Vec3 away = Vec3::Zero(); ///< where it does not fit: direction in which there is more room, unit or zero
        std::size_t gate = 0; ///< way through the opening; speeds the next question up
    };
    /// Ways through the opening that are tried: all, or the last one and the few in the middle.
    enum class Ways { all, few };
    /// Whether a finger fits with the centre of its tip at a place. Outside the grid it fits before the opening, and
    /// where a finger is put away (kAwayMm); elsewhere it is too far. Allocates nothing.
    /// @param tip_radius_mm of the ball at its end
    [[nodiscard]] Answer at(
        const Vec3& tip, double tip_radius_mm, std::size_t gate = 0, Ways ways = Ways::all) const noexcept;
    static constexpr double kAwayMm = 150.0; ///< from the grid

    /// A place where a finger fits, near to the wanted one: the way there from an allowed place as far as it is free,
    /// and then along what hinders. Where no finger fits at the allowed place, it begins outside(). Allocates nothing.
    struct Place {
        Vec3 tip = Vec3::Zero();
        Answer answer; ///< at `tip`; `hindrance` says what keeps the finger from the wanted place
    };
    [[nodiscard]] Place towards(
        const Vec3& allowed, const Vec3& wanted, double tip_radius_mm, std::size_t gate) const noexcept;

    /// A place outside, over the middle of the opening, where a finger fits.
    [[nodiscard]] Vec3 outside(double tip_radius_mm) const noexcept;
    [[nodiscard]] const DistanceGrid& around() const noexcept { return *surroundings_.around; }
    [[nodiscard]] const Opening& opening() const noexcept { return opening_; }
    [[nodiscard]] const StraightRod& finger() const noexcept { return finger_; }

private:
    /// The first hindrance of the rod from its tip on; nothing: it is free.
    struct Hindrance {
        double from_tip_mm = 0.0;
        Vec3 at = Vec3::Zero();
        bool is_structure = false;
    };
    [[nodiscard]] std::optional<Hindrance> hindrance(
        const Vec3& tip, double tip_radius_mm, const Vec3& outward, double length_mm) const noexcept;
    [[nodiscard]] Answer refused(const Hindrance& hindrance, std::size_t gate) const noexcept;

    Surroundings surroundings_;
    Opening opening_;
    StraightRod finger_;
    std::vector<Vec3> gates_; ///< in the opening, the middle one first
};

/// The distances from everything round an opening and a structure that is touched through it, for rods up to a
/// thickness. Steps are 1.5 mm, or larger where there would be more than four million points.
/// @param around everything that a rod cannot pass
/// @param structure surface of the structure at rest
/// @throws InputError as DistanceGrid; SolverError "cancelled" with a cancelled job
Surroundings make_surroundings(const std::vector<mesh::NamedSurface>& around, const Opening& opening,
    const TriMesh& structure, double thickest_mm, const Job& job = {});

} // namespace retractor::haptics
