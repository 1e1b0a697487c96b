#pragma once
// The shapes of the thorax phantom: skin, rib cage, ribs, cartilages, spine and organs. World mm, patient LPS. The
// proportions belong to a chest of 330 x 225 x 300 mm, in "nominal" coordinates. The shapes scale with the rib cage of
// a larger or smaller chest.

#include "datasets/phantoms/phantom.h"
#include "datasets/phantoms/phantom_shapes.h"

#include <array>
#include <vector>

namespace retractor::datasets {

/// Exponent of the cross-sections: 2 is an ellipse, 3 nearly a rounded box.
inline constexpr double kSquareness = 2.4;

/// Layers of the rib cage, counted outward from the pleura (mm).
inline constexpr double kPleuralCover = 3.0; ///< intercostal tissue between a rib and the pleura
inline constexpr double kRibThickness = 8.0;
inline constexpr double kRibHeight = 13.0;
inline constexpr double kShell = 10.0; ///< intercostal layer; ribs protrude from this layer by 1 mm into the muscle
inline constexpr double kRibMiddle = kPleuralCover + 0.5 * kRibThickness;
inline constexpr int kRibPairs = 12;

/// The surfaces of skin and rib cage. Closed surfaces are level sets: 0 on the surface, negative inside, and about
/// linear across the surface.
class ThoraxSurfaces {
public:
    /// @throws InputError when the layers leave no room for a chest.
    explicit ThoraxSurfaces(const ThoraxParameters& parameters);

    /// A cross-section at height z: |x/a|^n + |(y - y0)/b|^n, plus the dome term for the cage. n is kSquareness.
    struct Section {
        double half_width = 1.0; ///< a, mm
        double centre_y = 0.0; ///< y0, mm
        double half_depth = 1.0; ///< b, mm
        double dome = 0.0; ///< squared height term of the pleural dome; 0 below the dome
    };
    Section body_section(double z) const;
    Section cage_section(double z) const;

    /// First-order signed distances (mm) from the skin and from the inner side of the rib cage.
    double body_distance(const Vec3& p) const;
    double cage_distance(const Vec3& p) const;

    /// Returns the point at height z and angle phi that lies `outward` mm outside the inner side of the rib cage.
    /// @param phi angle: 0 is the back, pi the front
    /// @param side +1 is the patient's left, -1 the right
    Vec3 cage_point(double phi, double z, double side, double outward) const;
    /// The angle phi of a point, as in cage_point().
    double cage_angle(const Vec3& p) const;
    /// The point at (x, z) that lies `depth` mm under the skin of the chest's front.
    Vec3 under_front_skin(double x, double z, double depth) const;

    /// Convert world coordinates to nominal coordinates, in which the organs are defined, and back.
    Vec3 nominal(const Vec3& world) const;
    Vec3 world(const Vec3& nominal) const;
    /// Smallest ratio of world to nominal lengths over the three axes.
    double scale() const { return scale_.minCoeff(); }
    /// Ratio of world to nominal lengths along z.
    double height_scale() const { return scale_.z(); }

private:
    double level(const Section& section, const Vec3& p) const;
    Vec3 scale_ = Vec3::Ones();
    double cage_half_width_ = 0.0;
    double cage_half_depth_ = 0.0;
    double cage_centre_y_ = 0.0;
    Profile body_half_width_;
    Profile body_front_;
    Profile body_back_;
};

/// One rib and the cartilage that continues the rib, as centrelines on the middle surface of the rib cage (world mm).
struct RibCourse {
    std::vector<Vec3> bone; ///< from the spine to the costochondral junction
    /// From the junction to the sternum or to the cartilage above; empty for ribs 11 and 12.
    std::vector<Vec3> cartilage;
};

/// Ribs 1..12 (index 0..11) of one side. @param side +1 is the patient's left, -1 the right
std::array<RibCourse, kRibPairs> rib_courses(const ThoraxSurfaces& surfaces, double side);

/// Half-width of the sternum at a nominal height; 0 above and below the sternum.
double sternum_half_width(double nominal_z);

/// Signed distance to vertebrae, arches and processes (nominal mm).
double spine_distance(const Vec3& nominal);
/// True when a point of the spine lies in an intervertebral disc.
bool in_disc(const Vec3& nominal);
/// y of the cavity's back wall at the spine (nominal).
double spine_y(double nominal_z);

/// The organs in the chest, in nominal coordinates.
class ThoraxOrgans {
public:
    ThoraxOrgans(const ThoraxParameters& parameters, const ThoraxSurfaces& surfaces);

    /// Signed distances (nominal mm) to heart, coronary target and aneurysm.
    double heart(const Vec3& nominal) const;
    double coronary_target(const Vec3& nominal) const;
    double aneurysm(const Vec3& nominal) const;
    /// Height of the diaphragm's upper face at (x, y).
    static double diaphragm_height(double x, double y);

    Tube aorta;
    std::vector<Tube> arch_branches;
    std::vector<Tube> pulmonary_artery;
    Tube vena_cava;
    std::vector<Tube> trachea;
    Tube oesophagus;

private:
    Vec3 coronary_centre_;
    double coronary_radius_;
    Vec3 aneurysm_centre_;
    Vec3 aneurysm_radii_;
};

} // namespace retractor::datasets
