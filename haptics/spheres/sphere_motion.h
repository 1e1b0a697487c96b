#pragma once
// Motion of sphere-filled organs under fingertips (Suzuki et al., see sphere_filling.h). Units mm, s, N.
//
// Step. Every displaced sphere moves back towards its rest place. Spheres under a finger are put on its surface. Those
// spheres displace their neighbours, and so on, layer by layer down to the depth limit. A sphere with displacement d
// demands of a neighbour in direction n (at rest) the displacement T ((1 - s) d + 2 s n (n.d)). T = `transmission` is
// the transmitted share; s = kSpread is the share that is deflected sideways, as in packed balls. The demands of
// several neighbours are averaged, so that the order does not matter. Demands count from the rest place, so that
// nothing creeps. Spheres of different organs push each other when their reaches overlap (an outer sphere reaches to
// the surface), so neighbouring organs need no separate calculation. The number of spheres is constant. The volume is
// not constrained.
//
// Force. The force on a finger is -stiffness times the sum of the displacements of its spheres. A sphere belongs to the
// finger that reached it first, or to the lower finger number when two fingers reached it at once.
// calibrate_sphere_force() sets the stiffness so that a press has the force of an elastic half-space.
//
// Surface. Each surface vertex moves with the spheres nearest to it at rest, weighted by inverse squared distance. A
// finger can pinch the exact surface point under it: the polygon is divided at this point, and the finger holds the new
// vertex and the spheres beneath.

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
    int depth_limit = 8; ///< number of sphere layers that a contact moves, 1 to 250
    double transmission = 0.75; ///< share of a displacement that a sphere passes on, above 0 to kMostTransmission
    double recovery_time = 0.15; ///< time constant with which displacements fade when nothing presses, s
    std::size_t fingers = 1;
};

/// The contact of one finger.
struct SphereContact {
    Vec3 force = Vec3::Zero(); ///< on the finger, N
    double depth = 0.0; ///< largest displacement among the finger's spheres, mm
    double radius = 0.0; ///< radius of the sphere with the largest displacement, mm; 0 without contact
    std::size_t spheres = 0; ///< number of spheres that the finger displaces, in all layers
    bool touching = false;
};

class SphereMotion {
public:
    static constexpr std::size_t kMostFingers = 6;
    static constexpr double kSpread = 0.25;
    /// (1 + kSpread) times kMostTransmission is 1: straight ahead a displacement never grows.
    static constexpr double kMostTransmission = 0.8;

    /// @throws InputError on no organs, a law out of range, a filling without spheres, or a stiffness that is not
    /// positive, naming the organ
    SphereMotion(std::vector<SphereOrgan> organs, const SphereLaw& law);

    /// Makes one step; a finger that moves far is moved in several sub-steps. Allocates nothing.
    /// @pre fingers.size() == contacts.size() == law().fingers, positions are finite, dt >= 0
    void advance(double dt, std::span<const Fingertip> fingers, std::span<SphereContact> contacts) noexcept;

    /// From the next step on the finger holds the exact surface point nearest to its tip. The point becomes a new
    /// vertex unless a vertex is there already.
    /// @return the vertex
    /// @throws InputError on a finger out of range, a finger that pinches already, or a surface farther than `reach`
    /// (mm) from the tip's surface
    VertexId pinch(std::size_t finger, const Fingertip& tip, double reach = 2.0);
    void release(std::size_t finger) noexcept;
    bool pinches(std::size_t finger) const { return pinches_[finger].vertex >= 0; }

    /// The surfaces of all organs in one mesh. Triangle labels are organ numbers from 1. The mesh changes when a pinch
    /// divides a polygon.
    const TriMesh& surface() const { return surface_; }
    /// Writes the deformed surface, mm. Allocates only when `deformed` has another number of rows.
    void deform(Points& deformed) const;

    std::size_t sphere_count() const { return static_cast<std::size_t>(rest_.rows()); }
    std::size_t organ_count() const { return organs_.size(); }
    const SphereOrgan& organ(std::size_t i) const { return organs_[i]; }
    std::size_t organ_of(std::size_t sphere) const { return organ_of_[sphere]; }
    double radius_of(std::size_t sphere) const { return organs_[organ_of_[sphere]].filling.radius; }
    const Points& rest() const { return rest_; }
    const Points& positions() const { return now_; }
    /// Layer in which the last step moved sphere i; -1: not moved.
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
        Vec3 offset = Vec3::Zero(); ///< from the finger's centre to the vertex, mm
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
    std::vector<double> asked_; ///< three per sphere: sum of the displacements that neighbours demand
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
    std::vector<Vec3> last_; ///< last position of each finger
    std::vector<Pinch> pinches_;
    bool started_ = false;
};

/// The stiffness of one sphere (N/mm) that gives a press Sneddon's force on a half-space with E and nu. The function
/// presses a finger of `finger_radius` by `depth` into the middle of a block of such spheres, with this radius and law,
/// and scales the result. Lengths in mm.
double calibrate_sphere_force(double sphere_radius, const SphereLaw& law, double youngs_modulus_MPa,
    double poissons_ratio, double finger_radius = 8.0, double depth = 4.0);

} // namespace retractor::haptics
