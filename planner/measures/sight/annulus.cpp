#include "planner/measures/sight/annulus.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::planner {

namespace {

    /// Moments of a surface: area, centre of area, and second moments about it per area.
    struct Moments {
        double area_mm2 = 0.0;
        Vec3 centre = Vec3::Zero();
        Mat3 second = Mat3::Zero();
    };

    Moments moments_of(const TriMesh& surface)
    {
        Moments moments;
        for (const auto& [a, b, c] : surface.triangles) {
            const Vec3 p = surface.vertices.row(a), q = surface.vertices.row(b), r = surface.vertices.row(c);
            const double area = 0.5 * (q - p).cross(r - p).norm();
            moments.area_mm2 += area;
            moments.centre += area / 3.0 * (p + q + r);
            // Exact for a triangle: twelve times the mean of x x^T is the sum over the corners and their sum.
            const Vec3 sum = p + q + r;
            moments.second
                += area / 12.0 * (p * p.transpose() + q * q.transpose() + r * r.transpose() + sum * sum.transpose());
        }
        if (moments.area_mm2 > 0.0) {
            moments.centre /= moments.area_mm2;
            moments.second = Mat3(moments.second / moments.area_mm2 - moments.centre * moments.centre.transpose());
        }
        return moments;
    }

    /// The direction in which a ring is thinnest; nothing where no direction is clearly the thinnest.
    std::optional<Vec3> thinnest(const Mat3& second)
    {
        constexpr double kClear = 0.7; // ratio of the two smallest moments
        const Eigen::SelfAdjointEigenSolver<Mat3> solver(second);
        const Vec3& values = solver.eigenvalues(); // increasing
        if (!(values[0] < kClear * values[1]))
            return std::nullopt;
        return Vec3(solver.eigenvectors().col(0));
    }

    double angle_deg(const Vec3& unit, const Vec3& towards)
    {
        return 180.0 / std::numbers::pi * std::acos(std::clamp(unit.dot(towards.normalized()), -1.0, 1.0));
    }

    /// Whether a surface is the wall of a tube round an axis: its normals point from the axis, where those of a patch
    /// beside a vessel's axis do not.
    bool lies_round(const TriMesh& surface, const Vec3& centre, const Vec3& axis)
    {
        constexpr double kLeastRadial = 0.7; // mean of the normals' part along the line from the axis
        double area_mm2 = 0.0, radial = 0.0;
        for (const auto& [a, b, c] : surface.triangles) {
            const Vec3 p = surface.vertices.row(a), q = surface.vertices.row(b), r = surface.vertices.row(c);
            const Vec3 twice_area = (q - p).cross(r - p);
            Vec3 from_axis = (p + q + r) / 3.0 - centre;
            from_axis -= from_axis.dot(axis) * axis;
            if (!(from_axis.norm() > 0.0))
                continue;
            area_mm2 += 0.5 * twice_area.norm();
            radial += 0.5 * std::abs(twice_area.dot(from_axis.normalized()));
        }
        return area_mm2 > 0.0 && radial > kLeastRadial * area_mm2;
    }

    /// Twice the mean distance of the surface from the axis.
    double mean_diameter(const TriMesh& surface, const Vec3& centre, const Vec3& axis)
    {
        double area_mm2 = 0.0, sum = 0.0;
        for (const auto& [a, b, c] : surface.triangles) {
            const Vec3 p = surface.vertices.row(a), q = surface.vertices.row(b), r = surface.vertices.row(c);
            const double area = 0.5 * (q - p).cross(r - p).norm();
            area_mm2 += area;
            sum += area * ((p + q + r) / 3.0 - centre).cross(axis).norm();
        }
        return area_mm2 > 0.0 ? 2.0 * sum / area_mm2 : 0.0;
    }

} // namespace

bool is_annulus(const TargetSpec& target)
{
    return target.is_site() && (target.site.find("annulus") != std::string::npos || target.normal.has_value());
}

AnnulusAccess annulus_access(const TargetSpec& target, const TriMesh& ring, const Vec3& opening, const Vec3& eye)
{
    const Moments moments = moments_of(ring);
    AnnulusAccess access { .centre = moments.centre, .given = target.normal.has_value() };
    std::optional<Vec3> normal = target.normal ? target.normal : thinnest(moments.second);
    if (!target.normal && normal && !lies_round(ring, moments.centre, *normal))
        normal.reset();
    if (!normal) {
        access.message = "the " + target.site
            + " does not tell its plane, because its surface is no ring: move it, change how far it reaches, or give a "
              "normal";
        return access;
    }
    access.normal = normal->normalized();
    if (access.normal.dot(opening - access.centre) < 0.0)
        access.normal = -access.normal;
    access.diameter_mm = mean_diameter(ring, access.centre, access.normal);
    access.opening_off_axis_deg = angle_deg(access.normal, opening - access.centre);
    access.sight_off_axis_deg = angle_deg(access.normal, eye - access.centre);
    access.distance_mm = (opening - access.centre).norm();
    return access;
}

} // namespace retractor::planner
