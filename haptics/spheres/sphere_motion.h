#pragma once
// Organs of spheres under fingertips [Suzuki et al.]. Units mm, s, N.
//
// One step: every displaced sphere goes back towards its place; spheres under a finger are put on its surface; those
// displace their neighbours, those theirs, layer by layer down to the depth limit. A sphere displaced by d asks of a
// neighbour that lies along n at rest a displacement of T ((1 - s) d + 2 s n (n.d)): the share T = `transmission` of
// its own, bent aside by the share s = kSpread, as packed balls do. What several neighbours ask is averaged, so that
// the order does not matter, and counts from the place at rest, so that nothing creeps. Spheres of another organ are
// pushed alike by what closes the gap between their reaches (an outer sphere reaches to the surface): neighbouring
// organs need no calculation of their own. All spheres stay; how much volume they keep is measured, not imposed
// (volumes()).
//
// The force on a finger is -stiffness times the sum of the displacements of the spheres it displaced (each counts for
// the finger that reached it first, the lower number where two did at once). calibrate_sphere_force() sets the
// stiffness so that a press has the force of an elastic half-space.
//
// The surface follows: each of its vertices moves with the spheres nearest to it at rest, by inverse squared distance.
// A finger can pinch the exact point of the surface under it: the polygon there is divided at that point, and the new
// vertex is held where the finger is, with the spheres beneath it.

#include "haptics/servo/tissue_response.h"
#include "haptics/spheres/sphere_filling.h"
#include "haptics/spheres/surface_locator.h"

#include <array>
#include <string>
#include <vector>

namespace retractor::haptics {

struct SphereOrgan {
    std::string name;
    TriMesh surface;
    SphereFilling filling;
    double stiffness = 0.02; ///< N per mm of displacement of one sphere
};

struct SphereLaw {
    int depth_limit = 8; ///< layers of spheres that a contact moves; 1 to 250
    double transmission = 0.75; ///< share of a displacement that is passed on, above 0 to kMostTransmission
    double recovery_time = 0.15; ///< s: displacements fade with it when nothing presses
    std::size_t fingers = 1;
};

/// What a finger meets.
struct SphereContact {
    Vec3 force = Vec3::Zero(); ///< on the finger, N
    double depth = 0.0; ///< largest displacement among its spheres, mm
    double radius = 0.0; ///< of the sphere displaced so far, mm; 0: it touches none
    std::size_t spheres = 0; ///< displaced by it, in all layers
    bool touching = false;
};

class SphereMotion {
public:
    static constexpr std::size_t kMostFingers = 6;
    static constexpr double kSpread = 0.25;
    /// (1 + kSpread) times this is 1: straight ahead a displacement never grows.
    static constexpr double kMostTransmission = 0.8;

    /// @throws InputError on no organs, a law out of its range, a filling without spheres or a stiffness that is not
    /// positive, naming the organ.
    SphereMotion(std::vector<SphereOrgan> organs, const SphereLaw& law);

    /// One step; a finger that moves far is taken there in several. Allocates nothing.
    /// @pre fingers.size() == contacts.size() == law().fingers, positions finite; dt >= 0
    void advance(double dt, std::span<const Fingertip> fingers, std::span<SphereContact> contacts) noexcept;

    /// From the next step on the finger holds the exact point of the surface nearest to its tip: a new vertex, or the
    /// one that is there already. @returns the vertex. @throws InputError on a finger out of range, one that pinches
    /// already, or a surface farther from the tip's surface than `reach` (mm).
    VertexId pinch(std::size_t finger, const Fingertip& tip, double reach = 2.0);
    void release(std::size_t finger) noexcept;
    bool pinches(std::size_t finger) const { return pinches_[finger].vertex >= 0; }

    /// All organs' surfaces in one; triangle labels are organ numbers from 1. Changes when a pinch divides a polygon.
    const TriMesh& surface() const { return surface_; }
    /// Writes the deformed surface; allocates only when `deformed` has another number of rows.
    void deform(Points& deformed) const;

    struct Volume {
        double rest = 0.0, now = 0.0; ///< enclosed by the surface, mm^3
        double error() const { return now / rest - 1.0; }
    };
    /// One per organ.
    std::vector<Volume> volumes() const;

    std::size_t sphere_count() const { return static_cast<std::size_t>(rest_.rows()); }
    std::size_t organ_count() const { return organs_.size(); }
    const SphereOrgan& organ(std::size_t i) const { return organs_[i]; }
    std::size_t organ_of(std::size_t sphere) const { return organ_of_[sphere]; }
    double radius_of(std::size_t sphere) const { return organs_[organ_of_[sphere]].filling.radius; }
    const Points& rest() const { return rest_; }
    const Points& positions() const { return now_; }
    /// Layer in which the last step moved sphere i; -1: it did not.
    int layer(std::size_t i) const { return layer_[i] == kUntouched ? -1 : layer_[i]; }
    double reach_of(std::size_t sphere) const { return reach_[sphere]; }
    const SphereLaw& law() const { return law_; }

private:
    static constexpr std::uint8_t kUntouched = 255;
    struct Binding {
        std::array<std::int32_t, 4> sphere {};
        std::array<double, 4> weight {};
    };
    struct Pinch {
        VertexId vertex = -1;
        Vec3 offset = Vec3::Zero(); ///< of the vertex from the finger's centre
        std::array<std::int32_t, 4> sphere {};
        std::array<Vec3, 4> sphere_offset {};
    };

    Binding bind(const Vec3& rest, std::size_t organ) const;
    void build_grid() noexcept;
    template <class Visit> void near(const Vec3& p, double distance, Visit&& visit) const noexcept;
    void recover(double dt) noexcept;
    void touch(std::span<const Fingertip> fingers) noexcept;
    void claim(std::int32_t sphere, std::size_t finger, int layer) noexcept;
    void propagate() noexcept;
    void ask(std::int32_t i, std::int32_t j, const Vec3& displacement) noexcept;
    void measure(std::span<SphereContact> contacts) const noexcept;
    VertexId divide_at(const NearestOnSurface& at);
    VertexId add_vertex(const NearestOnSurface& at, std::size_t organ);

    std::vector<SphereOrgan> organs_;
    SphereLaw law_;
    Points rest_, now_;
    std::vector<std::uint32_t> organ_of_;
    std::vector<double> reach_; ///< per sphere
    std::vector<std::int32_t> first_, neighbours_;
    std::vector<std::uint8_t> layer_, owner_;
    std::vector<double> asked_; ///< three per sphere: sum of what its neighbours ask
    std::vector<std::uint16_t> askers_;
    std::vector<std::int32_t> frontier_, next_frontier_, displaced_;
    std::vector<std::uint8_t> is_displaced_;
    std::size_t frontier_count_ = 0, next_count_ = 0, displaced_count_ = 0;
    double largest_radius_ = 0.0, largest_reach_ = 0.0;

    Vec3 grid_low_ = Vec3::Zero();
    double grid_cell_ = 1.0;
    std::array<int, 3> grid_size_ { 1, 1, 1 };
    std::vector<std::int32_t> grid_first_, grid_items_, grid_at_;

    TriMesh surface_;
    std::vector<Binding> bindings_; ///< per vertex of the surface
    std::vector<Vec3> last_; ///< per finger
    std::vector<Pinch> pinches_;
    bool started_ = false;
};

/// The stiffness of one sphere (N/mm) with which pressing `finger_radius` into the middle of a block of such spheres by
/// `depth` has Sneddon's force on a half-space of E, nu; by doing it, for a filling of this radius and law.
double calibrate_sphere_force(double sphere_radius, const SphereLaw& law, double youngs_modulus_MPa,
    double poissons_ratio, double finger_radius = 8.0, double depth = 4.0);

} // namespace retractor::haptics
