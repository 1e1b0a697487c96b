#pragma once
// A blade: a polyline swept into the body. The swept surface is triangulated once, so that "which
// side is this point on" has one answer. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"

#include <Eigen/Geometry>

#include <array>
#include <vector>

namespace retractor::mesh {

/// A cutting line on the skin and how the blade goes in from it.
struct Blade {
    std::vector<Vec3> line; ///< at least two points, mm, in cutting order
    std::vector<Vec3> directions; ///< into the body; one for all points, or one per point; need not be unit
    double depth_mm = 0.0; ///< how far below the line the blade reaches, along its direction
    double above_mm = 10.0; ///< how far above the line it starts: skin bulges between the points of a line
};

/// A point in the blade's own coordinates.
struct BladeCoordinates {
    double along = 0.0; ///< mm along the line; negative before its start, beyond its length after its end
    double depth = 0.0; ///< mm below the line, along the direction; negative above
    double side = 0.0; ///< signed distance (mm) from the extended blade; positive on the left of the
                       ///< cutting direction seen against the blade direction (looking down on the skin)
};

/// The blade's surface, extended straight past its two ends, its top and its front, so that it divides
/// the tissue near it into two sides; the true blade is where 0 <= along <= length() and depth <= depth_mm.
/// Along and depth are interpolated in the triangle that holds the nearest point of the surface. The sign of
/// the side is that of the angle-weighted pseudo-normal there (Baerentzen and Aanaes 2005, doi
/// 10.1109/TVCG.2005.49), so that it has no jump at the creases.
class SweptBlade {
public:
    /// @throws InputError on fewer than two points, zero length, zero depth, NaN, a direction along the line,
    /// a line that turns back on itself, or rays or strips that cross each other within the blade.
    explicit SweptBlade(const Blade& blade);

    BladeCoordinates coordinates(const Vec3& point) const;
    /// The nearest point on the extended surface.
    Vec3 project(const Vec3& point) const;
    /// Corners of the triangle (of the extended surface) nearest to the point.
    const std::array<Vec3, 3>& nearest_triangle(const Vec3& point) const;
    /// Its unit normal.
    Vec3 normal(const Vec3& point) const;
    /// The point of the extended surface with these coordinates; they are clamped to its extent.
    Vec3 at(double along, double depth) const;
    /// Box round the part of the blade (not extended) between two places along its line.
    Eigen::AlignedBox3d box(double from_along, double to_along) const;
    double length() const;
    double depth() const;
    /// The triangulated (not extended) blade, for pictures and tests.
    const TriMesh& surface() const;

    /// An edge of the surface where it bends.
    struct Crease {
        Vec3 origin, direction; ///< the edge's start; unit direction
        double length = 0.0; ///< mm
        Vec3 normal; ///< unit; of the plane through the edge that halves the bend
        double angle_deg = 0.0; ///< by which the blade bends there
        double along = 0.0; ///< mm along the line, of the edge's middle
        bool ray = false; ///< runs along a point's direction; else within a twisted strip, or along the line
    };
    /// Edges within the blade's borders where it bends by more than this angle.
    std::vector<Crease> creases(double least_angle_deg) const;

private:
    struct Nearest {
        std::size_t triangle = 0;
        std::array<double, 3> weights {};
        Vec3 point;
    };
    /// What a nearest-point query needs to know of one triangle of the extended surface.
    struct Patch {
        std::array<Vec3, 3> corner;
        std::array<Vec3, 7> normal; ///< of the corners, of the edges 01, 12, 20, and of the face
        std::array<bool, 6> border {}; ///< of the corners and the edges
        Mat3 frame; ///< rows: along the edge 01, across it in the plane, normal
        std::array<double, 4> extent {}; ///< from and to along the first two, from corner 0
        std::array<double, 3> along {}, depth {};
        /// Squared distance of a point from the rectangle round the triangle: no point of it is nearer.
        double least_distance(const Vec3& point) const;
    };
    /// Between two neighbouring rays: four rows of two triangles at most.
    struct Strip {
        std::size_t first = 0, last = 0; ///< patches
        Eigen::AlignedBox3d box; ///< of them, in frame_
    };
    static constexpr std::size_t kMostPatches = 8; ///< of a strip
    static constexpr std::size_t kBlock = 8; ///< strips
    void build_grid(double reach);
    void build_normals();
    std::size_t edge_index(VertexId a, VertexId b) const;
    void build_strips();
    Nearest nearest(const Vec3& point) const;

    Blade blade_;
    TriMesh surface_;
    TriMesh extended_;
    std::vector<double> along_; ///< of the columns of the extended grid
    std::vector<double> depth_; ///< of its rows
    std::vector<Patch> patches_;
    std::vector<Strip> strips_;
    std::vector<Strip> blocks_; ///< of strips, likewise
    Mat3 frame_ = Mat3::Identity(); ///< rows: across the strips, along the rays, off the blade, in the mean
    double reach_squared_ = 0.0; ///< of the extended surface's diagonal, mm^2
};

} // namespace retractor::mesh
