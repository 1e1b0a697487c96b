#pragma once
// The shapes of the thorax phantom: where skin and rib cage are, the courses of ribs and cartilages, spine and
// organs. World mm, patient LPS. Proportions were set for a chest of 330 x 225 x 300 mm ("nominal" coordinates) and
// follow the rib cage when the chest is larger or smaller.

#include "datasets/phantoms/phantom.h"
#include "datasets/phantoms/phantom_shapes.h"

#include <array>
#include <vector>

namespace retractor::datasets {

/// Radial build-up of the rib cage, counted outward from the pleura (mm).
inline constexpr double kPleuralCover = 3.0; ///< intercostal tissue between a rib and the pleura
inline constexpr double kRibThickness = 8.0;
inline constexpr double kRibHeight = 13.0;
inline constexpr double kShell = 10.0; ///< intercostal layer; ribs stand out of it by 1 mm into the muscle
inline constexpr double kRibMiddle = kPleuralCover + 0.5 * kRibThickness;
inline constexpr int kRibPairs = 12;

/// Closed surfaces are level sets that are 0 on the surface, negative inside and about linear across it.
class ThoraxSurfaces {
public:
    explicit ThoraxSurfaces(const ThoraxParameters& parameters);

    /// Cross-sections at height z: |x/a|^n + |(y - y0)/b|^n, cage with a dome term added.
    struct Section {
        double half_width = 1.0; ///< a, mm
        double centre_y = 0.0; ///< y0, mm
        double half_depth = 1.0; ///< b, mm
        double dome = 0.0; ///< squared height term of the pleural dome, 0 below it
    };
    Section body_section(double z) const;
    Section cage_section(double z) const;
    double squareness() const { return squareness_; }

    /// First-order signed distances from the skin and from the inner side of the rib cage.
    double body_distance(const Vec3& p) const;
    double cage_distance(const Vec3& p) const;

    /// The point at height z and angle phi (0 = back, pi = front, side +1 = left) that is `outward` mm outside the
    /// inner side of the rib cage.
    Vec3 cage_point(double phi, double z, double side, double outward) const;
    /// The angle of a point, as above.
    double cage_angle(const Vec3& p) const;
    /// The front of the chest at (x, z): the point `depth` mm under the skin.
    Vec3 under_front_skin(double x, double z, double depth) const;

    /// Nominal coordinates (organs are laid out in these) from world, and back.
    Vec3 nominal(const Vec3& world) const;
    Vec3 world(const Vec3& nominal) const;
    double scale() const { return scale_.minCoeff(); }
    double height_scale() const { return scale_.z(); }

private:
    double level(const Section& section, const Vec3& p) const;
    Vec3 scale_ = Vec3::Ones();
    double squareness_;
    double cage_half_width_ = 0.0;
    double cage_half_depth_ = 0.0;
    double cage_centre_y_ = 0.0;
    Profile body_half_width_;
    Profile body_front_;
    Profile body_back_;
};

/// One rib and the cartilage that continues it, as centrelines on the middle surface of the rib cage.
struct RibCourse {
    std::vector<Vec3> bone; ///< from the spine to the costochondral junction
    std::vector<Vec3> cartilage; ///< from there to the sternum or the cartilage above; empty for ribs 11 and 12
};

/// Ribs 1..12 (index 0..11) of one side; side +1 is the patient's left.
std::array<RibCourse, kRibPairs> rib_courses(const ThoraxSurfaces& surfaces, double side);

/// Half-width of the sternum at a nominal height, 0 where there is none.
double sternum_half_width(double nominal_z);

/// Distance to vertebrae, arches and processes (nominal mm), and whether a point of the spine lies in a disc.
double spine_distance(const Vec3& nominal);
bool in_disc(const Vec3& nominal);
/// y of the back wall of the cavity at the spine (nominal).
double spine_y(double nominal_z);

/// Shapes inside the chest, nominal coordinates.
class ThoraxOrgans {
public:
    ThoraxOrgans(const ThoraxParameters& parameters, const ThoraxSurfaces& surfaces);

    double heart(const Vec3& nominal) const;
    double coronary_target(const Vec3& nominal) const;
    double aneurysm(const Vec3& nominal) const;
    /// Height of the diaphragm's upper face above (x, y).
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
