#pragma once
// Moving vertices near a blade without doing harm: what holds a vertex (surfaces, interfaces, earlier wounds, the blade
// itself) and what a move does to the elements round it. Units mm.

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

/// A face on the blade with elements on both its sides.
struct BladeFace {
    FaceKey key {};
    TetFace minus, plus;
};

using OpenFace = std::pair<FaceKey, TetFace>;
/// What faces_on_blade() found when it last looked.
struct LookOnBlade {
    /// CutStore::changes() and BladeMarks::changes() then.
    std::array<std::uint64_t, 2> changes { std::numeric_limits<std::uint64_t>::max(), 0 };
    std::size_t found = 0; ///< of BladeMarks::found_on_blade(), how many had been found before
    std::vector<OpenFace> open; ///< with every corner on the blade, each from one side; in order
    std::vector<BladeFace> faces;
};

/// What the stages of one stroke share.
struct StrokeState {
    CutStore& store;
    const SweptBlade& blade;
    const CutOptions& options;
    BladeMarks marks;
    std::vector<SweptBlade::Crease> creases {}; ///< bends that are made edges of the mesh
    std::set<VertexId> on_crease {}; ///< in the plane that halves a bend
    CutFaces cut_faces {}; ///< empty until they are decided
    std::map<VertexId, double> drift {}; ///< how far (mm) the moves of a vertex carried its surfaces away so far
    double border = 1.0; ///< StrokeSettings::border
    int cut_number = 0;
    bool goes_on = false; ///< former steps may have cut under the same number
    bool resolve_end = true; ///< the cut ends where the blade does; else, while it grows, before that
    /// Where the faces begin (mm along the line) that wait for the blade to go on.
    double waits_from = std::numeric_limits<double>::infinity();
    double lips_off = 0.0; ///< largest distance of the lips from the blade, in local edges of either side
    double lips_beyond = 0.0; ///< and beyond its borders
    /// The larger of both at the corners of what former steps have cut, where this one has changed it.
    double former_lips_off = 0.0;
    /// Round each vertex of the faces that will be cut, the elements that stay together: of the last look at them.
    std::map<VertexId, Groups> groups {};
    LookOnBlade look_on_blade {};
    CutReport report {};
};

/// @throws SolverError when there are more elements than CutOptions::element_limit.
void check_element_limit(const StrokeState& stroke);

/// A stroke that makes more elements than this for each that it crosses (and it may always make as many as for
/// kLeastCrossed) is given up: it would take seconds. Strokes that need no second attempt make 1 to 10.
inline constexpr std::size_t kMostGrowth = 100, kLeastCrossed = 50;
/// @throws CutQualityError (growth) when there are more.
void check_growth(const StrokeState& stroke);

/// The largest cosine among the six dihedral angles: that of the smallest angle. Cheaper than the angle, and orders
/// elements the same way (a smaller cosine is a better element). 1 for an element without volume.
/// @param enough (> 0) a cosine that is clearly larger than this need not be exact: then 1.
double smallest_dihedral_cosine(const std::array<Vec3, 4>& corners, double enough = 2.0);
/// Is that angle clearly larger than the one of `cosine` (> 0)? Neither divides nor takes a root.
bool smallest_dihedral_is_larger(const std::array<Vec3, 4>& corners, double cosine);
/// The cosines of all six dihedral angles, in no particular order; 1 for an element without volume.
std::array<double, 6> dihedral_cosines(const std::array<Vec3, 4>& corners);
/// Corners of an element.
std::array<Vec3, 4> corners_of(const CutStore& store, const std::array<VertexId, 4>& nodes);
std::array<Vec3, 4> corners_of(const CutStore& store, TetId t);

/// Vertices that share an edge with v, by id.
std::vector<VertexId> neighbours(const CutStore& store, VertexId v, std::span<const TetId> star);
bool on_lip(const CutStore& store, VertexId v, std::span<const TetId> star);
double shortest_edge(const CutStore& store, VertexId v, std::span<const TetId> star);
double mean_edge(const CutStore& store, VertexId v, std::span<const TetId> star);

/// A face that a vertex may only slide along: of the outer surface, or between two labels.
struct HeldFace {
    FaceKey key {};
    Vec3 normal = Vec3::Zero(); ///< unit
    bool outer = false; ///< of the outer surface
};
std::vector<HeldFace> held_faces(const CutStore& store, VertexId v, std::span<const TetId> star);
/// How far a move of v to `to` carries the surfaces it lies on away from where they are (mm): measured along the
/// normals before and after, as they turn on a curved surface.
/// @param most more than this need not be exact
double surface_deviation(const CutStore& store, VertexId v, std::span<const HeldFace> faces, const Vec3& to,
    double most = std::numeric_limits<double>::infinity());
/// Faces that an edge lies on, of those.
std::vector<HeldFace> held_faces(const CutStore& store, const EdgeKey& edge);

/// Is it an edge of a lip of what former steps of the stroke have cut, whose mirror image is another edge? Those on
/// the rim belong to a face of the one lip and to its mirror image.
bool is_parted(const StrokeState& stroke, const EdgeKey& edge);

/// Is the edge on the outer surface or between two labels?
bool is_held(const CutStore& store, const EdgeKey& edge);

/// A surface may be carried away by this share of the shortest edge at the vertex by one move, and by kSurfaceDrift of
/// the local edge (the mean edge at the vertex, and no more than CutStore::first_edge() of any element there) by all
/// moves of a stroke together: less than the promise of cut_types.h, as normals turn while vertices move one after
/// the other.
inline constexpr double kSurfaceDeviation = 0.05, kSurfaceDrift = 0.04;

/// Bisects an edge; the new vertex is as far from where its surfaces were as the ends of the edge may be.
/// @throws SolverError when the edge is_parted(): the lips would not mirror each other.
VertexId bisect(StrokeState& stroke, const EdgeKey& edge, const Vec3& p, double t);

/// Moves v to the best candidate: least surface deviation and shortest way. A candidate is refused when it carries a
/// surface too far, takes more than 75 % of an element's volume, or makes a dihedral angle smaller than
/// CutOptions::snap_angle_deg (or than it was). False when none is left.
bool move_to_best(StrokeState& stroke, VertexId v, std::span<const Vec3> candidates, std::span<const TetId> star);
/// May a move that carries surfaces away by `deviation` (mm) follow those that v made before? Of one vertex with the
/// elements round it, which is asked of many moves.
/// @param share of kSurfaceDrift that may be used up: what is left serves the moves to come
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
    bool keeps(double deviation);

private:
    const StrokeState& stroke_;
    VertexId v_;
    double unit_;
    std::span<const TetId> star_;
    double share_;
    std::optional<double> local_ {}; ///< edge, when it has been asked for
};
/// Puts into the report that a surface is `deviation` (mm) away from where it was at v.
void report_surface(StrokeState& stroke, VertexId v, double deviation);
/// Notes that surfaces were carried away by `deviation` (mm) at v, which is on them.
void carry_surface(StrokeState& stroke, VertexId v, double deviation);
/// Moves v and forgets what was known of it. For callers that have checked.
void move_checked(StrokeState& stroke, VertexId v, const Vec3& to, std::span<const TetId> star, double deviation);

} // namespace retractor::mesh
