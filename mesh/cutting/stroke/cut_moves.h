#pragma once
// Moves vertices near a blade safely: finds the constraints of a vertex (surfaces, interfaces, earlier wounds, the
// blade itself) and the effect of a move on the elements round the vertex. Units mm.

#include "mesh/cutting/store/cut_types.h"
#include "mesh/cutting/stroke/cut_faces.h"
#include "mesh/cutting/stroke/cut_groups.h"

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

namespace retractor::mesh {

/// A face on the blade with elements on both sides.
struct BladeFace {
    FaceKey key {};
    TetFace minus, plus; ///< the face as a face of the element on the minus side and on the plus side
};

using OpenFace = std::pair<FaceKey, TetFace>;
/// Result of the last call of faces_on_blade(), which the next call updates.
struct BladeFaceCache {
    /// CutStore::changes() and BladeMarks::changes() at the last call.
    std::array<std::uint64_t, 2> changes { std::numeric_limits<std::uint64_t>::max(), 0 };
    std::size_t found = 0; ///< size of BladeMarks::found_on_blade() at the last call
    std::vector<OpenFace> open; ///< faces with every corner on the blade, each from one side; sorted
    std::vector<BladeFace> faces;
};

/// The data that the stages of a stroke share.
struct StrokeState {
    CutStore& store;
    const SweptBlade& blade;
    const CutOptions& options;
    BladeMarks marks;
    std::vector<SweptBlade::Crease> creases {}; ///< bends that become edges of the mesh
    std::set<VertexId> on_crease {}; ///< vertices in the plane that halves a bend
    CutFaces cut_faces {}; ///< empty until decide_cut_faces()
    std::map<VertexId, double> drift {}; ///< distance (mm) by which moves carried the surfaces at a vertex
    double border = 1.0; ///< StrokeSettings::border
    int cut_number = 0;
    bool goes_on = false; ///< former steps may have cut under the same number
    bool resolve_end = true; ///< true: cut up to the blade's end; false: the blade still grows
    /// Start (mm along the line) of the faces that wait until the blade grows further.
    double waits_from = std::numeric_limits<double>::infinity();
    double lips_off = 0.0; ///< largest distance of the lips from the blade, in local edges
    double lips_beyond = 0.0; ///< largest distance of the lips beyond the blade's borders, in local edges
    /// The larger of both distances at corners of faces that former steps have cut and this step has changed.
    double former_lips_off = 0.0;
    /// Groups of elements that stay together round each vertex of the faces that will be cut, from the last search.
    std::map<VertexId, Groups> groups {};
    BladeFaceCache blade_face_cache {};
    CutReport report {};
};

/// @throws SolverError when there are more elements than CutOptions::element_limit
void check_element_limit(const StrokeState& stroke);

/// Limits on the growth of the mesh: a stroke may make kMostGrowth elements for each crossed element, counting at least
/// kLeastCrossed crossed elements. A stroke with more elements would take seconds and is given up. Strokes that need no
/// second attempt make 1 to 10 elements for each crossed element.
inline constexpr std::size_t kMostGrowth = 100, kLeastCrossed = 50;
/// @throws CutQualityError (growth) when the stroke exceeds the limits
void check_growth(const StrokeState& stroke);

/// Cosine of the smallest dihedral angle, the largest cosine of the six angles. The cosine is cheaper than the angle
/// and orders elements the same way: a smaller cosine means a better element. 1 for an element without volume.
/// @param enough (> 0) the function may return 1 for a cosine that is clearly larger than this value
double smallest_dihedral_cosine(const std::array<Vec3, 4>& corners, double enough = 2.0);
/// True when the smallest dihedral angle is clearly larger than the angle of `cosine` (> 0). The function needs no
/// division and no root.
bool smallest_dihedral_is_larger(const std::array<Vec3, 4>& corners, double cosine);
/// The cosines of all six dihedral angles, in no particular order; 1 for an element without volume.
std::array<double, 6> dihedral_cosines(const std::array<Vec3, 4>& corners);
/// Positions (mm) of the corners of an element.
std::array<Vec3, 4> corners_of(const CutStore& store, const std::array<VertexId, 4>& nodes);
std::array<Vec3, 4> corners_of(const CutStore& store, TetId t);

/// Vertices that share an edge with v, ascending. `star` holds the elements round v, here and below.
std::vector<VertexId> neighbours(const CutStore& store, VertexId v, std::span<const TetId> star);
/// True for a vertex on a lip of an earlier wound.
bool on_lip(const CutStore& store, VertexId v, std::span<const TetId> star);
/// Lengths (mm) of the edges at v.
double shortest_edge(const CutStore& store, VertexId v, std::span<const TetId> star);
double mean_edge(const CutStore& store, VertexId v, std::span<const TetId> star);

/// A face along which a vertex may slide but which it may not leave: a face of the outer surface or between two labels.
struct HeldFace {
    FaceKey key {};
    Vec3 normal = Vec3::Zero(); ///< unit
    bool outer = false; ///< true for a face of the outer surface
};
/// The held faces at a vertex.
std::vector<HeldFace> held_faces(const CutStore& store, VertexId v, std::span<const TetId> star);
/// Distance (mm) by which a move of v to `to` carries the surfaces at v away. The distance is measured along the
/// normals before and after the move, because normals turn on a curved surface.
/// @param most the result need not be exact above this distance
double surface_deviation(const CutStore& store, VertexId v, std::span<const HeldFace> faces, const Vec3& to,
    double most = std::numeric_limits<double>::infinity());
/// The held faces at an edge.
std::vector<HeldFace> held_faces(const CutStore& store, const EdgeKey& edge);

/// True for an edge of a lip that former steps of the stroke have cut, when the mirror image of the edge is another
/// edge. An edge on the rim belongs to a face of one lip and also to the mirror image of that face.
bool is_parted(const StrokeState& stroke, const EdgeKey& edge);

/// True for an edge on the outer surface or between two labels.
bool is_held(const CutStore& store, const EdgeKey& edge);

/// Limits on the distance by which moves carry a surface. One move: kSurfaceDeviation of the shortest edge at the
/// vertex. All moves of a stroke together: kSurfaceDrift of the local edge (the mean edge at the vertex, but at most
/// CutStore::first_edge() of any element there). kSurfaceDrift is below the 5 % that cut_types.h guarantees, because
/// normals turn while vertices move one after the other.
inline constexpr double kSurfaceDeviation = 0.05, kSurfaceDrift = 0.04;

/// Bisects an edge at p. The new vertex gets the larger drift of the two ends.
/// @throws CutQualityError when is_parted(edge), because the lips would not mirror each other
VertexId bisect(StrokeState& stroke, const EdgeKey& edge, const Vec3& p, double t);

/// Moves v to the candidate with the least surface deviation and the shortest way. A candidate is refused when it
/// carries a surface too far, takes more than 75 % of an element's volume, or makes a dihedral angle below
/// CutOptions::snap_angle_deg that was not smaller before. Returns false when all candidates are refused.
bool move_to_best(StrokeState& stroke, VertexId v, std::span<const Vec3> candidates, std::span<const TetId> star);
/// Tests for many moves of one vertex whether a move still keeps the limit kSurfaceDrift together with earlier moves.
/// @param share share of kSurfaceDrift that may be used; the rest is left for later moves
class SurfaceRoom {
public:
    SurfaceRoom(const StrokeState& stroke, VertexId v, double unit, std::span<const TetId> star, double share = 1.0)
        : stroke_(stroke)
        , v_(v)
        , unit_(unit)
        , star_(star)
        , share_(share)
    {
    }
    /// True when a move that carries surfaces away by `deviation` (mm) is allowed.
    bool keeps(double deviation);

private:
    const StrokeState& stroke_;
    VertexId v_;
    double unit_;
    std::span<const TetId> star_;
    double share_;
    std::optional<double> local_ {}; ///< local edge (mm), computed on first use
};
/// Reports that a surface at v is `deviation` (mm) away from its first place.
void report_surface(StrokeState& stroke, VertexId v, double deviation);
/// Adds `deviation` (mm) to the drift of the surfaces at v.
void carry_surface(StrokeState& stroke, VertexId v, double deviation);
/// Moves v without tests and forgets its marks. @pre the caller has tested the move
void move_checked(StrokeState& stroke, VertexId v, const Vec3& to, std::span<const TetId> star, double deviation);

} // namespace retractor::mesh
