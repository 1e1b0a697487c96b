#pragma once
// A blade: a polyline swept into the body. The swept surface is triangulated once, so that the side of a point has a
// unique answer. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"

#include <Eigen/Geometry>

#include <array>
#include <vector>

namespace retractor::mesh {

/// A cutting line on the skin, with the directions and the depth of the blade.
struct Blade {
    std::vector<Vec3> line; ///< at least two points, mm, in cutting order
    std::vector<Vec3> directions; ///< into the body; one for all points or one per point; any length
    double depth_mm = 0.0; ///< reach of the blade below the line, along its direction
    double above_mm = 10.0; ///< start of the blade above the line: skin bulges between points
};

/// A point in the coordinates of the blade.
struct BladeCoordinates {
    double along = 0.0; ///< mm along the line; negative before the start, above length() after the end
    double depth = 0.0; ///< mm below the line, along the direction; negative above
    /// Signed distance (mm) from the extended blade; positive on the left of the cutting direction, seen against the
    /// blade direction (looking down on the skin).
    double side = 0.0;
};

/// The surface of a blade, extended straight past its two ends, its top and its front, so that the surface divides the
/// tissue near it into two sides. The true blade is the part with 0 <= along <= length() and depth <= depth_mm. The
/// coordinates `along` and `depth` are interpolated in the triangle with the nearest point of the surface. The sign of
/// `side` is that of the angle-weighted pseudo-normal there (Baerentzen and Aanaes 2005, doi 10.1109/TVCG.2005.49), so
/// that the sign has no jump at creases.
class SweptBlade {
public:
    /// @throws InputError on fewer than two points, zero length, zero depth, NaN, a direction along the line, a line
    /// that turns back on itself, or rays or strips that cross each other within the blade
    explicit SweptBlade(const Blade& blade);

    BladeCoordinates coordinates(const Vec3& point) const;
    /// The nearest point on the extended surface.
    Vec3 project(const Vec3& point) const;
    /// Corners of the triangle (of the extended surface) nearest to the point.
    const std::array<Vec3, 3>& nearest_triangle(const Vec3& point) const;
    /// Unit normal of the nearest triangle.
    Vec3 normal(const Vec3& point) const;
    /// The point of the extended surface with these coordinates, which are clamped to the extent of the surface.
    Vec3 at(double along, double depth) const;
    /// Box round the part of the blade, without extension, between two places along its line (mm).
    Eigen::AlignedBox3d box(double from_along, double to_along) const;
    double length() const; ///< of the line, mm
    double depth() const; ///< mm
    /// The triangulated blade without extension, for pictures and tests.
    const TriMesh& surface() const;

    /// An edge at which the surface bends.
    struct Crease {
        Vec3 origin, direction; ///< start (mm) and unit direction of the edge
        double length = 0.0; ///< mm
        Vec3 normal; ///< unit normal of the plane through the edge that halves the bend
        double along = 0.0; ///< position of the edge's middle along the line (mm)
        bool ray = false; ///< true: along a point's direction; false: within a twisted strip or along the line
    };
    /// Edges within the blade's borders with a bend of more than this angle.
    std::vector<Crease> creases(double least_angle_deg) const;

private:
    struct Nearest {
        std::size_t triangle = 0;
        std::array<double, 3> weights {};
        Vec3 point;
    };
    /// Data of a triangle of the extended surface for nearest-point queries.
    struct Patch {
        std::array<Vec3, 3> corner;
        std::array<Vec3, 7> normal; ///< normals at the corners, at the edges 01, 12, 20, and of the face
        std::array<bool, 6> border {}; ///< true for corners and edges on the border
        Mat3 frame; ///< rows: along the edge 01, across the edge in the plane, normal
        std::array<double, 4> extent {}; ///< low and high along the first two rows, from corner 0 (mm)
        std::array<double, 3> along {}, depth {};
        /// Squared distance (mm^2) of a point from the rectangle round the triangle; a lower bound for the triangle.
        double least_distance(const Vec3& point) const;
    };
    /// The patches between two neighbouring rays: at most four rows of two triangles.
    struct Strip {
        std::size_t first = 0, last = 0; ///< range in patches_
        Eigen::AlignedBox3d box; ///< box round the patches, in frame_
    };
    static constexpr std::size_t kMostPatches = 8; ///< largest number of patches of a strip
    static constexpr std::size_t kBlock = 8; ///< strips per block
    void build_grid(double reach);
    void build_normals();
    std::size_t edge_index(VertexId a, VertexId b) const;
    void build_strips();
    Nearest nearest(const Vec3& point) const;

    Blade blade_;
    TriMesh surface_;
    TriMesh extended_;
    std::vector<double> along_; ///< along (mm) of each column of the extended grid
    std::vector<double> depth_; ///< depth (mm) of each row
    std::vector<Patch> patches_;
    std::vector<Strip> strips_;
    std::vector<Strip> blocks_; ///< groups of strips; `first` and `last` count strips
    Mat3 frame_ = Mat3::Identity(); ///< rows: mean directions across the strips, along the rays, off the blade
    double reach_squared_ = 0.0; ///< squared diagonal of the extended surface (mm^2)
};

} // namespace retractor::mesh
