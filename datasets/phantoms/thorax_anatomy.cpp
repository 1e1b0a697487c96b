#include "datasets/phantoms/thorax_anatomy.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::datasets {

namespace {

    constexpr double kPi = std::numbers::pi;

    // The nominal chest.
    constexpr double kNominalHalfWidth = 132.0; // half-width of the cavity, mm
    constexpr double kNominalHalfDepth = 72.0;
    constexpr double kNominalCentreY = -7.5;
    constexpr double kNominalHeight = 300.0;
    constexpr double kDomeStart = -10.0; // the pleural dome curves inwards above this height
    constexpr double kDomeHeight = 138.0; // height of the dome above kDomeStart
    constexpr double kVertebraPitch = 20.5;
    constexpr double kFirstThoracicZ = 112.0; // middle of vertebra T1

    /// Erector spinae: thickness of the muscle behind the ribs, relative to the muscle in front of the ribs.
    constexpr double kBackMuscle = 2.5;
    /// Additional width at the flanks (mm), so that the fat never touches the rib cage.
    constexpr double kFlankReserve = 2.0;

    double radians(double degrees) { return degrees * kPi / 180.0; }

    double nominal_centre_y(double z)
    {
        // The upper chest leans back (sternal angle), and the neck is in front of the mid-thoracic kyphosis.
        const double above = std::max(0.0, z - 10.0);
        return kNominalCentreY + 0.0012 * above * above;
    }

    double dome_term(double z)
    {
        const double t = std::max(0.0, z - kDomeStart) / kDomeHeight;
        return t * t;
    }

    /// Factor of the half-depth of the cavity's front wall at height z.
    double dome_factor(double z) { return std::sqrt(std::max(0.0, 1.0 - dome_term(z))); }

    double cage_width_factor(double z)
    {
        // The cavity is widest at the lower ribs and a little narrower towards the loin.
        return 1.0 - 0.05 * smooth_step(-60.0, -160.0, z);
    }

    double layers(const ThoraxParameters& p) { return p.skin_mm + p.fat_mm + p.muscle_mm; }

    Profile half_width_profile(const ThoraxParameters& p)
    {
        const double h = 0.5 * p.width_mm;
        const double k = p.height_mm / kNominalHeight;
        return Profile(
            { { -150 * k, 0.945 * h }, { -80 * k, 0.972 * h }, { -20 * k, h }, { 40 * k, h }, { 80 * k, 0.97 * h },
                { 105 * k, 0.86 * h }, { 125 * k, 0.66 * h }, { 140 * k, 0.48 * h }, { 150 * k, 0.40 * h } });
    }

    Profile back_profile(const ThoraxParameters& p)
    {
        const double h = 0.5 * p.depth_mm;
        const double k = p.height_mm / kNominalHeight;
        return Profile({ { -150 * k, 0.92 * h }, { -90 * k, 0.965 * h }, { 0.0, h }, { 55 * k, 0.985 * h },
            { 95 * k, 0.90 * h }, { 125 * k, 0.75 * h }, { 150 * k, 0.66 * h } });
    }

    Profile front_profile(const ThoraxParameters& p, double half_depth, double centre_y)
    {
        const double k = p.height_mm / kNominalHeight;
        // Down to the jugular notch the skin follows the sternum, at the distance of the layers.
        const auto over_sternum = [&](double z) {
            const double scaled = half_depth / kNominalHalfDepth;
            return centre_y + scaled * (nominal_centre_y(z) - kNominalCentreY) - half_depth * dome_factor(z) - kShell
                - layers(p);
        };
        return Profile({ { -150 * k, over_sternum(-150) }, { -60 * k, over_sternum(-60) - 1.0 },
            { -10 * k, over_sternum(-10) }, { 20 * k, over_sternum(20) }, { 45 * k, over_sternum(45) },
            { 70 * k, over_sternum(70) }, { 92 * k, over_sternum(92) }, { 108 * k, over_sternum(92) + 14.0 },
            { 128 * k, over_sternum(92) + 24.0 }, { 150 * k, over_sternum(92) + 28.0 } });
    }

    /// First-order distance from a level set, with the gradient by central differences.
    template <typename Level> double distance_from_level(const Level& level, const Vec3& p)
    {
        constexpr double kStep = 0.5;
        Vec3 gradient;
        for (int axis = 0; axis < 3; ++axis) {
            const Vec3 d = kStep * Vec3::Unit(axis);
            gradient[axis] = (level(p + d) - level(p - d)) / (2.0 * kStep);
        }
        return level(p) / std::max(gradient.norm(), 1e-9);
    }

    template <typename F> double bisect(double low, double high, const F& rising)
    {
        for (int step = 0; step < 40; ++step) {
            const double middle = 0.5 * (low + high);
            (rising(middle) < 0.0 ? low : high) = middle;
        }
        return 0.5 * (low + high);
    }

} // namespace

ThoraxSurfaces::ThoraxSurfaces(const ThoraxParameters& p)
    : cage_half_width_(0.5 * p.width_mm - layers(p) - kFlankReserve - kShell)
    , cage_half_depth_(0.5
          * ((0.5 * p.depth_mm - layers(p) - kShell)
              + (0.5 * p.depth_mm - p.skin_mm - p.fat_mm - kBackMuscle * p.muscle_mm - kShell)))
    , cage_centre_y_((0.5 * p.depth_mm - p.skin_mm - p.fat_mm - kBackMuscle * p.muscle_mm - kShell) - cage_half_depth_)
    , body_half_width_(half_width_profile(p))
    , body_front_(front_profile(p, cage_half_depth_, cage_centre_y_))
    , body_back_(back_profile(p))
{
    // In a smaller cavity (mm) the heart, the great vessels and the aneurysm do not fit between sternum and spine.
    constexpr double kLeastHalfWidth = 95.0;
    constexpr double kLeastHalfDepth = 55.0;
    if (cage_half_width_ < kLeastHalfWidth || cage_half_depth_ < kLeastHalfDepth)
        throw InputError(
            "skin, fat and muscle leave no room for a chest of this width and depth: use thinner layers or a "
            "larger chest",
            "fat_mm");
    scale_
        = { cage_half_width_ / kNominalHalfWidth, cage_half_depth_ / kNominalHalfDepth, p.height_mm / kNominalHeight };
}

ThoraxSurfaces::Section ThoraxSurfaces::body_section(double z) const
{
    const double front = body_front_(z);
    const double back = body_back_(z);
    return { body_half_width_(z), 0.5 * (front + back), 0.5 * (back - front), 0.0 };
}

ThoraxSurfaces::Section ThoraxSurfaces::cage_section(double z) const
{
    const double n = z / scale_.z();
    return { cage_half_width_ * cage_width_factor(n),
        cage_centre_y_ + scale_.y() * (nominal_centre_y(n) - kNominalCentreY), cage_half_depth_, dome_term(n) };
}

double ThoraxSurfaces::level(const Section& s, const Vec3& p) const
{
    const double sum = std::pow(std::abs(p.x()) / s.half_width, kSquareness)
        + std::pow(std::abs(p.y() - s.centre_y) / s.half_depth, kSquareness);
    return std::sqrt(std::pow(sum, 2.0 / kSquareness) + s.dome) - 1.0;
}

double ThoraxSurfaces::body_distance(const Vec3& p) const
{
    return distance_from_level([this](const Vec3& q) { return level(body_section(q.z()), q); }, p);
}

double ThoraxSurfaces::cage_distance(const Vec3& p) const
{
    return distance_from_level([this](const Vec3& q) { return level(cage_section(q.z()), q); }, p);
}

Vec3 ThoraxSurfaces::cage_point(double phi, double z, double side, double outward) const
{
    const Section s = cage_section(z);
    const Vec3 centre(0.0, s.centre_y, z);
    const Vec3 direction(side * s.half_width * std::sin(phi), s.half_depth * std::cos(phi), 0.0);
    const double t = bisect(0.02, 1.6, [&](double r) { return cage_distance(centre + r * direction) - outward; });
    return centre + t * direction;
}

double ThoraxSurfaces::cage_angle(const Vec3& p) const
{
    const Section s = cage_section(p.z());
    return std::atan2(std::abs(p.x()) / s.half_width, (p.y() - s.centre_y) / s.half_depth);
}

Vec3 ThoraxSurfaces::under_front_skin(double x, double z, double depth) const
{
    const Section s = body_section(z);
    const double reach = bisect(0.0, 1.3 * s.half_depth, [&](double d) {
        return body_distance({ x, s.centre_y - d, z }) + depth;
    });
    return { x, s.centre_y - reach, z };
}

Vec3 ThoraxSurfaces::nominal(const Vec3& w) const
{
    return { w.x() / scale_.x(), kNominalCentreY + (w.y() - cage_centre_y_) / scale_.y(), w.z() / scale_.z() };
}

Vec3 ThoraxSurfaces::world(const Vec3& n) const
{
    return { n.x() * scale_.x(), cage_centre_y_ + (n.y() - kNominalCentreY) * scale_.y(), n.z() * scale_.z() };
}

namespace {

    /// The end of a bony rib: angle in degrees (180 = front), nominal height.
    struct RibEnd {
        double angle;
        double z;
    };
    constexpr std::array<RibEnd, kRibPairs> kRibEnds { { { 150, 80 }, { 151, 49 }, { 149, 24 }, { 147, -1 },
        { 144, -25 }, { 140, -49 }, { 134, -73 }, { 126, -95 }, { 117, -112 }, { 107, -125 }, { 88, -132 },
        { 56, -128 } } };
    /// Nominal heights at which the cartilages of ribs 1 to 7 reach the sternum.
    constexpr std::array<double, 7> kSternalZ { 79, 51, 32, 13, -5, -22, -38 };
    constexpr double kRibHeadX = 21.0; // nominal distance of the rib's head from the midline

    /// Nominal height of a rib. A rib lies roughly in a plane that descends to the front, so its height follows its
    /// depth.
    double rib_z(int rib, double phi)
    {
        const auto depth = [](double angle) { return 0.5 * (1.0 - std::cos(angle)); };
        const RibEnd end = kRibEnds[static_cast<std::size_t>(rib)];
        const double start_z = kFirstThoracicZ + 6.0 - kVertebraPitch * rib;
        return start_z + (end.z - start_z) * depth(phi) / depth(radians(end.angle));
    }

    std::vector<Vec3> bone_course(const ThoraxSurfaces& surfaces, int rib, double side)
    {
        constexpr int kPieces = 56;
        const double end = radians(kRibEnds[static_cast<std::size_t>(rib)].angle);
        const auto at = [&](double phi) {
            return surfaces.cage_point(phi, rib_z(rib, phi) * surfaces.height_scale(), side, kRibMiddle);
        };
        const double head_x = surfaces.world({ kRibHeadX, 0.0, 0.0 }).x();
        const double start
            = bisect(radians(2.0), radians(50.0), [&](double phi) { return std::abs(at(phi).x()) - head_x; });
        std::vector<Vec3> course;
        for (int i = 0; i <= kPieces; ++i)
            course.push_back(at(start + (end - start) * i / kPieces));
        return course;
    }

    /// The course of a cartilage from a rib's end to a target on the cage's middle surface. The cartilage first
    /// continues in the rib's direction (down) and then turns up. `dip` (nominal mm) scales its distance below the
    /// straight line.
    std::vector<Vec3> cartilage_course(
        const ThoraxSurfaces& surfaces, const Vec3& from, double to_phi, double to_z, double dip, double side)
    {
        constexpr int kPieces = 24;
        const double phi0 = surfaces.cage_angle(from);
        const double z0 = from.z();
        std::vector<Vec3> course;
        for (int i = 0; i <= kPieces; ++i) {
            const double t = static_cast<double>(i) / kPieces;
            const double sag = dip * surfaces.height_scale() * std::sin(kPi * t) * (1.0 - 0.5 * t);
            course.push_back(
                surfaces.cage_point(phi0 + (to_phi - phi0) * t, z0 + (to_z - z0) * t - sag, side, kRibMiddle));
        }
        return course;
    }

} // namespace

std::array<RibCourse, kRibPairs> rib_courses(const ThoraxSurfaces& surfaces, double side)
{
    constexpr std::array<double, 10> kDip { 0, 0, 0, 3, 6, 8, 8, 4, 3, 2 };
    constexpr double kJoinFraction = 0.42; // position along the cartilage above at which the next cartilage joins
    std::array<RibCourse, kRibPairs> courses;
    for (std::size_t rib = 0; rib < courses.size(); ++rib) {
        RibCourse& course = courses[rib];
        course.bone = bone_course(surfaces, static_cast<int>(rib), side);
        if (rib >= 10)
            continue;
        Vec3 target;
        if (rib < kSternalZ.size()) {
            const double z = kSternalZ[rib] * surfaces.height_scale();
            const double x = sternum_half_width(kSternalZ[rib]) * surfaces.world({ 1.0, 0.0, 0.0 }).x() - 2.0;
            const auto section = surfaces.cage_section(z);
            target = { side * x, section.centre_y - section.half_depth, z };
        } else {
            const std::vector<Vec3>& above = courses[rib - 1].cartilage;
            target = above[static_cast<std::size_t>(kJoinFraction * static_cast<double>(above.size() - 1))];
        }
        // The angle of a point near the midline is the angle of the surface point with the same x.
        const auto on_surface_x = [&](double phi) {
            return std::abs(target.x()) - std::abs(surfaces.cage_point(phi, target.z(), side, kRibMiddle).x());
        };
        const double phi = bisect(0.5 * kPi, kPi, on_surface_x);
        course.cartilage = cartilage_course(surfaces, course.bone.back(), phi, target.z(), kDip[rib], side);
    }
    return courses;
}

double sternum_half_width(double z)
{
    static const Profile kWidth({ { -82, 2.5 }, { -62, 6.5 }, { -52, 8.5 }, { -46, 14.0 }, { -30, 18.0 }, { -5, 17.0 },
        { 35, 14.0 }, { 51, 15.0 }, { 66, 21.0 }, { 82, 28.0 }, { 90, 26.0 }, { 95, 20.0 } });
    return z < -82.0 || z > 95.0 ? 0.0 : kWidth(z);
}

double spine_y(double z)
{
    static const Profile kSpine(
        { { -160, 57 }, { -100, 62 }, { -20, 64.5 }, { 30, 62.5 }, { 60, 58 }, { 95, 49 }, { 125, 38 }, { 160, 24 } });
    return kSpine(z);
}

namespace {

    /// Height above the middle of the nearest vertebra.
    double from_vertebra(double z)
    {
        const double level = (z - kFirstThoracicZ) / kVertebraPitch;
        return (level - std::round(level)) * kVertebraPitch;
    }

} // namespace

bool in_disc(const Vec3& p)
{
    const bool in_body = p.y() < spine_y(p.z()) + 6.0; // arches and processes have no discs
    return in_body && std::abs(from_vertebra(p.z())) > 0.5 * kVertebraPitch - 2.2;
}

double spine_distance(const Vec3& p)
{
    const double x = std::abs(p.x());
    const double back = spine_y(p.z());
    const double h = from_vertebra(p.z());
    const double waist = 1.0 - 0.09 * std::cos(2.0 * kPi * h / kVertebraPitch);
    const auto ellipse = [](double u, double v, double ru, double rv) {
        return (std::hypot(u / ru, v / rv) - 1.0) * std::min(ru, rv);
    };
    const double body = ellipse(x, p.y() - (back - 8.0), 17.0 * waist, 15.0 * waist);
    const double arch = ellipse(x, p.y() - (back + 15.0), 13.0, 9.0);
    double processes = 1e9;
    for (const double level : { h, h - kVertebraPitch, h + kVertebraPitch }) {
        // Transverse and spinous processes of one vertebra, in the frame of the vertebra.
        const Vec3 q(x, p.y() - back, level);
        const double transverse = nearest_on_segment(q, { 6.0, 14.0, 0.0 }, { 31.0, 21.0, 3.0 }).distance - 4.5;
        const double spinous = nearest_on_segment(q, { 0.0, 20.0, -2.0 }, { 0.0, 33.0, -13.0 }).distance - 4.0;
        processes = std::min({ processes, transverse, spinous });
    }
    return smooth_min(smooth_min(body, arch, 4.0), processes, 3.0);
}

namespace {

    const Vec3 kVentricleCentre(27.0, -18.0, -36.0);

    Mat3 ventricle_axes()
    {
        const Vec3 axis = Vec3(0.74, -0.42, -0.53).normalized(); // from base to apex: left, forward, down
        const Vec3 side = axis.cross(Vec3::UnitZ()).normalized();
        Mat3 axes;
        axes << axis, side, axis.cross(side);
        return axes;
    }

    Tube smooth_tube(const std::vector<Vec3>& corners, double first_radius, double last_radius)
    {
        std::vector<Vec3> points = smooth_polyline(corners, 5);
        const auto count = static_cast<double>(points.size() - 1);
        std::vector<double> radii;
        for (std::size_t i = 0; i < points.size(); ++i)
            radii.push_back(first_radius + (last_radius - first_radius) * static_cast<double>(i) / count);
        return make_tube(std::move(points), std::move(radii));
    }

} // namespace

double ThoraxOrgans::heart(const Vec3& p) const
{
    static const Mat3 kAxes = ventricle_axes();
    const double ventricles = ellipsoid_distance(p, kVentricleCentre, kAxes, { 60.0, 41.0, 41.0 });
    const double right = ellipsoid_distance(p, { -14.0, -22.0, -30.0 }, Mat3::Identity(), { 36.0, 36.0, 40.0 });
    const double left_atrium = ellipsoid_distance(p, { 6.0, 8.0, -10.0 }, Mat3::Identity(), { 34.0, 20.0, 24.0 });
    return smooth_min(smooth_min(ventricles, right, 18.0), left_atrium, 14.0);
}

double ThoraxOrgans::coronary_target(const Vec3& p) const { return (p - coronary_centre_).norm() - coronary_radius_; }

double ThoraxOrgans::aneurysm(const Vec3& p) const
{
    return ellipsoid_distance(p, aneurysm_centre_, Mat3::Identity(), aneurysm_radii_);
}

double ThoraxOrgans::diaphragm_height(double x, double y)
{
    const auto dome
        = [&](double cx, double top) { return top - 0.0115 * ((x - cx) * (x - cx) + 0.9 * (y + 5.0) * (y + 5.0)); };
    const double central = -88.0 - 0.006 * (x * x + y * y);
    return -smooth_min(smooth_min(-dome(-62.0, -52.0), -dome(64.0, -65.0), 16.0), -central, 16.0);
}

/// Diameter of the anastomosis site on the anterior descending artery, mm.
constexpr double kCoronaryTarget = 12.0;

ThoraxOrgans::ThoraxOrgans(const ThoraxParameters& parameters, const ThoraxSurfaces& surfaces)
    : coronary_centre_(Vec3::Zero())
    , coronary_radius_(0.5 * kCoronaryTarget / surfaces.scale())
    , aneurysm_centre_(surfaces.nominal(surfaces.world({ 48.0, 20.0, 47.0 })))
{
    // Diameters are world mm, so the scale of the nominal frame is removed.
    const Vec3 per_mm = surfaces.nominal({ 1.0, 1.0, 1.0 }) - surfaces.nominal(Vec3::Zero());
    aneurysm_radii_ = 0.5 * parameters.aneurysm_diameter_mm * Vec3(1.0, 0.96, 1.06).cwiseProduct(per_mm);

    // The course is: root, ascending part, arch to the left and back, descending part on the left of the spine.
    aorta = smooth_tube({ { 2.0, -14.0, -8.0 }, { -10.0, -22.0, 18.0 }, { -13.0, -23.0, 42.0 }, { -6.0, -18.0, 62.0 },
                            { 9.0, -6.0, 72.0 }, { 22.0, 10.0, 68.0 }, { 27.0, 25.0, 54.0 }, { 27.0, 34.0, 34.0 },
                            { 25.0, 37.0, 0.0 }, { 22.0, 37.0, -50.0 }, { 16.0, 34.0, -100.0 }, { 9.0, 26.0, -170.0 } },
        15.0, 11.5);
    arch_branches = { smooth_tube({ { -5.0, -17.0, 66.0 }, { -14.0, -10.0, 88.0 }, { -26.0, -2.0, 128.0 } }, 6.5, 5.0),
        smooth_tube({ { 6.0, -8.0, 74.0 }, { 11.0, -3.0, 95.0 }, { 16.0, 2.0, 128.0 } }, 4.5, 4.0),
        smooth_tube({ { 17.0, 4.0, 72.0 }, { 24.0, 7.0, 90.0 }, { 40.0, 8.0, 122.0 } }, 5.0, 4.5) };
    pulmonary_artery
        = { smooth_tube({ { 14.0, -34.0, 0.0 }, { 18.0, -28.0, 18.0 }, { 18.0, -14.0, 32.0 } }, 14.0, 12.0),
              smooth_tube({ { 18.0, -14.0, 32.0 }, { -4.0, -4.0, 30.0 }, { -44.0, 0.0, 20.0 } }, 11.0, 8.0),
              smooth_tube({ { 18.0, -14.0, 32.0 }, { 32.0, -2.0, 30.0 }, { 50.0, 2.0, 12.0 } }, 11.0, 8.0) };
    vena_cava = smooth_tube(
        { { -26.0, -16.0, -8.0 }, { -31.0, -18.0, 30.0 }, { -30.0, -18.0, 72.0 }, { -28.0, -14.0, 92.0 } }, 10.0, 8.0);
    trachea = { smooth_tube({ { 0.0, -6.0, 170.0 }, { -1.0, 4.0, 120.0 }, { -3.0, 10.0, 80.0 }, { -4.0, 13.0, 50.0 } },
                    9.0, 8.5),
        smooth_tube({ { -4.0, 13.0, 50.0 }, { -20.0, 13.0, 34.0 }, { -42.0, 13.0, 16.0 } }, 7.0, 5.5),
        smooth_tube({ { -4.0, 13.0, 50.0 }, { 14.0, 13.0, 34.0 }, { 44.0, 13.0, 12.0 } }, 6.5, 5.0) };
    oesophagus = smooth_tube({ { 3.0, 12.0, 170.0 }, { 3.0, 22.0, 110.0 }, { 2.0, 30.0, 60.0 }, { 2.0, 34.0, 10.0 },
                                 { 8.0, 28.0, -60.0 }, { 18.0, 14.0, -100.0 } },
        6.0, 7.0);

    // The anastomosis site is on the front of the heart, left of the midline, over the interventricular groove.
    const Vec3 inside(30.0, -22.0, -24.0);
    const Vec3 direction = Vec3(0.30, -1.0, 0.12).normalized();
    const double reach = bisect(0.0, 80.0, [&](double d) { return heart(inside + d * direction); });
    coronary_centre_ = inside + (reach - 0.15 * coronary_radius_) * direction;
}

} // namespace retractor::datasets
