#pragma once
// The data that the modules of a cut pass to each other: what a cut is asked to do (CutOptions), what it changed
// (MeshDelta, LipFace) and how it went (CutReport, CutResult). No algorithm is declared here. Ids are those of the
// cutting session. Units mm; frame patient LPS (the rest configuration).

#include "mesh/tetrahedra/tet_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace retractor::mesh {

/// Everything that one cut changed, in the order: vertices born, vertices moved, tets gone, tets born, vertices
/// gone. A vertex may be born and then moved (onto the curve where the blade ends).
struct MeshDelta {
    /// Where a vertex comes from; to be asked instead of comparing a with b.
    enum class Origin : std::uint8_t {
        on_edge, ///< on the former edge a-b
        copy, ///< of a (== b) on another lip, in the same place
        restored, ///< a == b == id: back from an ablation that is undone; of a vertex gone: taken by an ablation
    };
    struct VertexBorn {
        VertexId id = 0;
        Vec3 position; ///< rest position, mm
        VertexId a = 0, b = 0; ///< parents: alive before the delta, or born earlier in it
        /// Of a vertex on an edge: position = (1 - t) a + t b, up to the round-off of putting it on the blade, as long
        /// as nothing moved. Vertices that moved in the same delta, and parents merged into others (neither with
        /// snap = 0), leave it true to an edge's length. When both parents were merged into one vertex, a == b and
        /// t == 0: that vertex is near, no more. Of the other kinds 0.
        double t = 0.0;
        Origin origin = Origin::on_edge;
    };
    struct VertexMoved {
        VertexId id = 0;
        Vec3 from, to;
    };
    struct Tet {
        TetId id = 0;
        std::array<VertexId, 4> nodes {};
        Label label = 0;
        TetId origin = 0; ///< the element of the session's first mesh that it is a part of
    };
    std::vector<VertexBorn> vertices_born;
    std::vector<VertexMoved> vertices_moved;
    std::vector<Tet> tets_gone;
    std::vector<Tet> tets_born; ///< a split or rewired element is gone and born again under a new or freed id
    /// By undo: what was born before, last born first. By ablation: what no element uses any more.
    std::vector<VertexBorn> vertices_gone;
};

/// The same change taken back: what was born is gone. Needs no mesh.
MeshDelta inverse(const MeshDelta& delta);

/// A face of the wound: on the blade, or bared by an ablation, with tissue on one side only.
struct LipFace {
    TetFace face; ///< ids of the session
    int side = 0; ///< +1 or -1, see BladeCoordinates::side; 0: bared by an ablation
    int cut = 0; ///< number of the cut in this session, from 0
};

enum class CutStatus { done, missed_body, cancelled };

/// How crossed elements are divided. `adaptive` is the product's way; the others are the source's comparison, defined
/// in cut_patterns.h: they snap and improve nothing, whatever the other options say.
enum class Subdivision { adaptive, intermediate_11, intermediate_5, general };

struct CutOptions {
    Subdivision subdivision = Subdivision::adaptive;
    /// A vertex nearer to the blade than this share of its shortest incident edge is moved onto it, which
    /// avoids slivers and keeps elements few; 0 never moves any vertex, and then volumes are kept to round-off. Between
    /// 0 and 0.5. The default is where random strokes through Kuhn boxes give the best angles. No move takes more than
    /// 75 % of an element's volume, or carries a surface or an interface further than 5 % of the shortest edge at the
    /// vertex (5 % of the mean edge by all moves together). Vertices on earlier wounds stay where they are.
    double snap = 0.35;
    double snap_angle_deg = 12.0; ///< no move onto the blade makes a dihedral angle smaller than this (or than it was)
    /// Elements near the blade with a smaller dihedral angle are opened as far as shifting and merging vertices can,
    /// unless snap is 0.
    double improve_below_deg = 12.0;
    /// Where the blade's line bends so much that a chord as long as the edges there would lie as far off the blade as
    /// at a single bend of this angle in its middle, the bend's ray is made an edge of the mesh. Gentler bends, and the
    /// twist between neighbouring rays whose directions differ, are spanned by faces with their corners on the blade:
    /// 0.1 edges off it at most where no strip is twisted (CutReport::lip_to_blade tells how far). 0: every bend is
    /// followed, twists too, at the cost of slivers where they meet.
    double crease_deg = 20.0;
    /// Labels the blade does not sever (a scalpel does not cut bone): their elements stay tied together.
    std::vector<Label> uncut_labels {};
    /// A cut during which the session would have more elements than this is refused (SolverError): cuts that cross
    /// again and again in one place divide what they divided before. At least 1.
    std::size_t element_limit = 20'000'000;
};

/// What a cut did, for the user and the bench. Angles are dihedral angles of elements.
struct CutReport {
    std::size_t tets_crossed = 0; ///< before snapping
    std::size_t tets_before = 0, tets_after = 0;
    std::size_t tets_created = 0, tets_removed = 0; ///< born and gone
    std::size_t vertices_moved = 0, vertices_merged = 0;
    double largest_move_mm = 0.0;
    /// Largest, all moves of a vertex together, in local edges: mean edges of the session's first elements there.
    double surface_deviation = 0.0;
    double lip_area_mm2 = 0.0; ///< of one lip (of an ablation: the area bared), rest configuration
    double removed_volume_mm3 = 0.0; ///< by an ablation, rest configuration
    double lip_to_blade = 0.0; ///< largest distance of a lip face's middle from the blade, in edges of that face
    double worst_dihedral_before_deg = 180.0; ///< among the elements gone
    double worst_dihedral_deg = 180.0; ///< among the elements born
    double p01_dihedral_deg = 180.0; ///< 1st percentile of all angles of the elements born
    /// Elements born whose smallest dihedral angle is below CutOptions::improve_below_deg's default and below half the
    /// smallest of the elements gone that they are made of: where the blade grazes, geometry forbids better.
    std::size_t tets_below_half_parent = 0;
    double smallest_volume_ratio = 1.0; ///< smallest volume of an element born, in mean volumes of those gone
    int attempts
        = 1; ///< more than one: a promise was not kept at first, less was snapped, more bends followed, elements halved
    double seconds = 0.0;

    /// (created - removed) / crossed; 0 when nothing was crossed.
    double mean_increase() const;
};

struct [[nodiscard]] CutResult {
    CutStatus status = CutStatus::done;
    std::string message;
    MeshDelta delta;
    CutReport report;
};

} // namespace retractor::mesh
