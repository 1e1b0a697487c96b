#pragma once
// The shape of the opened wound: its edge on the skin, and the measures taken on this edge.
// Units mm, degrees, steradian; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/cutting/store/cut_types.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <optional>
#include <span>
#include <vector>

namespace retractor::planner {

/// One lip's edge on the skin, ordered from the start of the blade's line to its end.
struct WoundEdge {
    std::vector<VertexId> vertices; ///< corners of the mesh (midpoints of ten-node elements are left out)
    std::vector<double> along_mm; ///< BladeCoordinates::along of each vertex at rest
};

struct WoundEdges {
    WoundEdge left; ///< edge of side +1
    WoundEdge right; ///< edge of side -1
    Vec3 outward = Vec3::Zero(); ///< mean unit vector against the blade's direction (rest configuration)
};

/// Whether a face of the mesh faces the side from which the blade came, as skin does. The far side of the wall and the
/// end faces of a piece of tissue do not.
bool faces_blade(const mesh::TetMesh& mesh, const mesh::TetFace& face, const mesh::SweptBlade& blade);

/// Finds the edges between the lips and the surface through which the blade entered. An edge qualifies when one of its
/// two boundary faces is a lip, and the other face is no lip and faces the blade. Where several edges lie above each
/// other (a blade through two walls), the edge nearest the top of the blade is taken.
/// @param lips faces of `mesh` from one cut (ids of `mesh`)
/// @throws InputError when a side has no such edge (the blade went in below the skin), or ids are out of range
WoundEdges wound_edges(const mesh::TetMesh& mesh, std::span<const mesh::LipFace> lips, const mesh::SweptBlade& blade);

/// The edge of a lip as points, with a parameter. Points of both lips with the same parameter lay together before the
/// cut opened.
struct LipLine {
    std::vector<Vec3> points;
    std::vector<double> along_mm; ///< parameter of each point, not decreasing
};

struct OpeningGeometry {
    /// Area of the closed loop of both lips, projected on the plane of its vector area, where the area is largest.
    double area_mm2 = 0.0;
    double overlap_area_mm2 = 0.0; ///< above 0 when the lips cross over instead of gaping; area_mm2 is then 0
    double width_mm = 0.0; ///< largest distance between matching points of the lips, across the field and in the plane
    double length_mm = 0.0; ///< straight distance between the ends of the deformed opening
    double incision_length_mm = 0.0; ///< length along the skin before opening: mean of the two lips
    Vec3 centre = Vec3::Zero(); ///< middle of the opening, weighted by its width
    Vec3 normal = Vec3::UnitZ(); ///< outward unit normal of the skin plane
    Vec3 along = Vec3::UnitX(); ///< unit vector in the plane, from start to end of the cut
    Vec3 start = Vec3::Zero(), end = Vec3::Zero(); ///< ends of the opening, half way between the lips
};

/// @param outward roughly out of the body; tells gaping from overlapping, and is the normal of a closed slit
/// @throws InputError on fewer than two points per lip, different lengths, NaN, a decreasing parameter or zero length
OpeningGeometry opening_geometry(const LipLine& left, const LipLine& right, const Vec3& outward);

/// The geometry of the opening of a mesh. incision_length_mm is measured at rest.
/// @param displacement n x 3 (mm); no rows: no displacement
OpeningGeometry opening_geometry(const WoundEdges& edges, const mesh::TetMesh& mesh, const Points& displacement);

/// The opening as the target sees it: only the lips on the skin count, not what lies between.
struct OpeningFromTarget {
    double solid_angle_sr = 0.0; ///< of the loop of both lips (Van Oosterom, Strackee 1983, IEEE TBME 30:125)
    // Angles between the outermost straight lines from the target to the lips, in the two planes that hold the line to
    // the opening's centre.
    double along_deg = 0.0; ///< in the plane along the cut
    double across_deg = 0.0; ///< in the plane across it
    double offset_mm = 0.0; ///< of the target from the line through the opening's centre, square to the skin plane
};

/// @param from a place on the target; all angles are 0 where it is not below the opening, or where the lips cross over
OpeningFromTarget opening_from(
    const OpeningGeometry& opening, const LipLine& left, const LipLine& right, const Vec3& from);
/// @param displacement as opening_geometry()
OpeningFromTarget opening_from(const OpeningGeometry& opening, const WoundEdges& edges, const mesh::TetMesh& mesh,
    const Points& displacement, const Vec3& from);

/// Distance from the skin plane to the target along the optical axis through `aim`. The distance ends at the first
/// point of the target that is met from outside, or at the aim when the axis misses the target (a hollow one). The
/// distance is negative when the target stands out of the body.
/// @returns nothing when the axis lies within 3 degrees of the skin plane
std::optional<double> working_distance_mm(
    const OpeningGeometry& opening, const TriMesh& target, const Vec3& aim, const Vec3& axis);

/// Area-weighted centre of a surface. @throws InputError on zero area.
Vec3 surface_centre(const TriMesh& surface);

/// Possible positions of the surgeon's eye: a spherical cap round `aim`. The eyes are spread evenly over the cap's area
/// in a sunflower pattern, the first on the axis. The eyes turn with aim, axis and up.
struct ViewCone {
    Vec3 aim = Vec3::Zero(); ///< point that is looked at, on the target (aim_through())
    Vec3 axis = Vec3::UnitZ(); ///< from the aim to the central eye, of any length
    Vec3 up = Vec3::UnitY(); ///< fixes the rotation of the pattern about the axis; not parallel to the axis
    double eye_distance_mm = 400.0; ///< distance of the eyes from the aim
    double half_angle_deg = 15.0; ///< from 0 to below 90
    int eyes = 32; ///< at least 1
};

/// The cone of a surgeon who looks at `aim` through the middle of the opening; its up vector is the cut's direction.
/// @throws InputError when the aim lies in the opening's centre.
ViewCone cone_through_opening(
    const OpeningGeometry& opening, const Vec3& aim, double eye_distance_mm, double half_angle_deg, int eyes);

} // namespace retractor::planner
