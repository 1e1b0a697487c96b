#include "fem/material/element_fibres.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <numbers>

namespace retractor::fem {

namespace {

    using Corners = std::array<Vec3, 4>;

    /// Whether the axis, seen as a point along its own direction, lies within one of the element's faces.
    bool axis_meets(const Corners& corners, const FibresAround& around, const Vec3& along)
    {
        const auto side = [&](std::size_t i, std::size_t j) {
            return (corners[i] - around.point).cross(corners[j] - around.point).dot(along);
        };
        for (const auto& face : mesh::kTetFaces) {
            const auto a = static_cast<std::size_t>(face[0]), b = static_cast<std::size_t>(face[1]),
                       c = static_cast<std::size_t>(face[2]);
            const std::array<double, 3> s { side(a, b), side(b, c), side(c, a) };
            // a face seen edge-on: an axis that runs through the element also meets another face
            constexpr double kEdgeOn = 1e-9;
            if (std::abs(s[0] + s[1] + s[2]) <= kEdgeOn * (corners[a] - corners[b]).squaredNorm())
                continue;
            if ((s[0] >= 0.0 && s[1] >= 0.0 && s[2] >= 0.0) || (s[0] <= 0.0 && s[1] <= 0.0 && s[2] <= 0.0))
                return true;
        }
        return false;
    }

    [[noreturn]] void refuse(TetId element, const Vec3& middle)
    {
        throw InputError(
            "the axis that this material's fibres turn round runs through it: they have no direction there",
            formatted(
                "element %d at (%.1f, %.1f, %.1f) mm", static_cast<int>(element), middle.x(), middle.y(), middle.z()));
    }

} // namespace

void check_fibres_around(const FibresAround& around, const std::string& where)
{
    if (!around.point.allFinite() || !around.axis.allFinite())
        throw InputError("the point and the axis that fibres turn round must be finite", where);
    if (!(around.axis.stableNorm() > 0.0))
        throw InputError("the axis that fibres turn round must not be zero", where);
    if (!(around.angle_deg >= 0.0 && around.angle_deg <= 90.0))
        throw InputError("the fibres' angle to the circumference must be between 0 and 90 degrees", where);
}

FibreDirections element_fibres(const mesh::TetMesh& mesh, TetId element, const TissueLaw& tissue)
{
    if (!tissue.around)
        return tissue.fibres;
    const Corners corners = mesh::tet_corners(mesh, element);
    const Vec3 along = tissue.around->axis.stableNormalized(),
               middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
    if (axis_meets(corners, *tissue.around, along))
        refuse(element, middle);
    const Vec3 round = along.cross(middle - tissue.around->point).normalized();
    const double angle = tissue.around->angle_deg * std::numbers::pi / 180.0;
    return { std::cos(angle) * round + std::sin(angle) * along, std::cos(angle) * round - std::sin(angle) * along };
}

} // namespace retractor::fem
