#pragma once
// The shape of the opened field: its edge on the skin, and the measures taken on it.
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
    std::vector<VertexId> vertices; ///< corners of the mesh (P2 midpoints are left out)
    std::vector<double> along_mm; ///< per vertex: BladeCoordinates::along of its rest position
};

struct WoundEdges {
    WoundEdge left; ///< side +1
    WoundEdge right; ///< side -1
    Vec3 outward = Vec3::Zero(); ///< unit: mean direction from which the blade came (rest configuration)
};

/// Whether a face of the mesh lies towards where the blade came from, as skin does; the far side of the wall and the
/// end faces of a piece of tissue do not.
bool faces_blade(const mesh::TetMesh& mesh, const mesh::TetFace& face, const mesh::SweptBlade& blade);

/// Finds the edges between the lips and the surface that the blade entered by. An edge qualifies when one of its
/// two boundary faces is a lip and the other is not, and that other one faces the blade; where several lie above
/// each other (a blade through two walls) the one nearest the top of the blade is taken.
/// @param lips faces of `mesh` (compact ids, as of CutMesh), of one cut.
/// @throws InputError when a side has no such edge (the blade went in below the skin), or ids are out of range.
WoundEdges wound_edges(const mesh::TetMesh& mesh, std::span<const mesh::LipFace> lips, const mesh::SweptBlade& blade);

/// A lip's edge as points, with a parameter that matches points that lay together before the cut opened.
struct LipLine {
    std::vector<Vec3> points;
    std::vector<double> along_mm; ///< one per point, not decreasing
};

struct OpeningGeometry {
    double area_mm2
        = 0.0; ///< of the closed loop of both lips, projected on the plane of its vector area (where it is largest)
    double overlap_area_mm2 = 0.0; ///< above 0 when the lips cross over instead of gaping; area_mm2 is then 0
    double width_mm = 0.0; ///< largest distance between matching points of the lips, across the field, in the plane
    double length_mm = 0.0; ///< end to end, straight, of the deformed opening
    double incision_length_mm = 0.0; ///< along the skin before opening: mean of the two lips
    Vec3 centre = Vec3::Zero(); ///< middle of the opening, weighted by its width
    Vec3 normal = Vec3::UnitZ(); ///< of the skin plane, unit, outward
    Vec3 along = Vec3::UnitX(); ///< unit, in the plane, from start to end of the cut
    Vec3 start = Vec3::Zero(), end = Vec3::Zero(); ///< the opening's two ends (half-way between the lips there)
    Vec3 widest_left = Vec3::Zero(), widest_right = Vec3::Zero(); ///< the lips where the field is widest
    std::vector<Vec3> loop; ///< right lip forward, left lip back; counter-clockwise seen from outside
};

/// @param outward roughly out of the body: tells gaping from overlapping, and is the normal of a closed slit.
/// @throws InputError on fewer than two points per lip, lengths that differ, NaN, a decreasing parameter, zero length.
OpeningGeometry opening_geometry(const LipLine& left, const LipLine& right, const Vec3& outward);

/// The same on a mesh; incision_length_mm is measured at rest.
/// @param displacement n x 3 (mm), or without rows for none.
OpeningGeometry opening_geometry(const WoundEdges& edges, const mesh::TetMesh& mesh, const Points& displacement);

/// From the skin plane to the target along the optical axis through `aim`: to the first point of the target met
/// from outside, or to the aim itself when the axis misses the target (a hollow one).
/// Nothing when the axis lies within 3 degrees of the skin plane. Negative when the target stands out of the body.
std::optional<double> working_distance_mm(
    const OpeningGeometry& opening, const TriMesh& target, const Vec3& aim, const Vec3& axis);

/// How the opening presents itself to a point of the target.
struct ApproachAngles {
    double solid_angle_sr = 0.0; ///< of the opening [van Oosterom and Strackee 1983]
    double along_deg = 0.0; ///< angle of attack: between the rays to the two ends of the opening
    double across_deg = 0.0; ///< between the rays to the two lips where the field is widest
    double tilt_deg = 0.0; ///< between the ray to the opening's centre and the skin plane's normal
    double offset_mm = 0.0; ///< of the point from the normal through the opening's centre
};
ApproachAngles approach_angles(const OpeningGeometry& opening, const Vec3& target_point);

/// Area-weighted centre of a surface. @throws InputError on zero area.
Vec3 surface_centre(const TriMesh& surface);

/// Where the surgeon's eye may be: a spherical cap round `aim`, eyes spread evenly over its area (a sunflower
/// pattern, the first on the axis). Turning aim, axis and up with the patient turns the eyes with it.
struct ViewCone {
    Vec3 aim = Vec3::Zero(); ///< what is looked at, usually the target's centre
    Vec3 axis = Vec3::UnitZ(); ///< from the aim to the central eye; made unit
    Vec3 up = Vec3::UnitY(); ///< fixes the pattern's rotation about the axis; not parallel to it
    double eye_distance_mm = 400.0; ///< from the aim
    double half_angle_deg = 15.0; ///< 0 to 90 (exclusive)
    int eyes = 32; ///< at least 1
};

/// The cone of a surgeon who looks at `aim` through the middle of the opening; its up vector is the cut's direction.
/// @throws InputError when the aim lies in the opening's centre.
ViewCone cone_through_opening(
    const OpeningGeometry& opening, const Vec3& aim, double eye_distance_mm, double half_angle_deg, int eyes);

} // namespace retractor::planner
