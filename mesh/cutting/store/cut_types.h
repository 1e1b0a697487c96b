#pragma once
// The data that the modules of a cut pass to each other: options (CutOptions), changes (MeshDelta, LipFace) and results
// (CutReport, CutResult). No algorithm is declared here. Ids are ids of the cutting session. Units mm; frame patient
// LPS (the rest configuration).

#include "mesh/tetrahedra/tet_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace retractor::mesh {

/// All changes of one operation. "Born" means added and "gone" means removed. The order is: vertices born, vertices
/// moved, elements gone, elements born, vertices gone. A vertex may be born and then moved (onto the curve where the
/// blade ends).
struct MeshDelta {
    /// Origin of a vertex. Ask for the origin instead of comparing a with b.
    enum class Origin : std::uint8_t {
        on_edge, ///< lies on the former edge a-b
        copy, ///< copies a (== b) for another lip, at the same position
        /// With a == b == id. Of a vertex born: undo of an ablation brings the vertex back. Of a vertex gone: an
        /// ablation removes the vertex.
        restored,
    };
    struct VertexBorn {
        VertexId id = 0;
        Vec3 position; ///< rest position, mm
        VertexId a = 0, b = 0; ///< parents: alive before the delta, or born earlier in the delta
        /// For a vertex on an edge: position = (1 - t) a + t b, up to the round-off of putting the vertex on the blade,
        /// as long as nothing moved. Two things make the equation true only to the length of an edge: vertices that
        /// moved in the same delta, and parents merged into other vertices (neither happens with snap = 0). When both
        /// parents were merged into one vertex, a == b and t == 0, and that vertex is merely near. For other origins t
        /// is 0.
        double t = 0.0;
        Origin origin = Origin::on_edge;
        bool operator==(const VertexBorn&) const = default;
    };
    struct VertexMoved {
        VertexId id = 0;
        Vec3 from, to;
        bool operator==(const VertexMoved&) const = default;
    };
    struct Tet {
        TetId id = 0;
        std::array<VertexId, 4> nodes {};
        Label label = 0;
        TetId origin = 0; ///< element of the session's first mesh that contains this element
        bool operator==(const Tet&) const = default;
    };
    std::vector<VertexBorn> vertices_born;
    std::vector<VertexMoved> vertices_moved;
    std::vector<Tet> tets_gone;
    std::vector<Tet> tets_born; ///< a divided or rewired element is gone and born under another id
    /// After undo: the vertices that the operation had added, the last first. After an ablation: vertices that no
    /// element uses any more.
    std::vector<VertexBorn> vertices_gone;
    bool operator==(const MeshDelta&) const = default;
};

/// The delta that takes a delta back.
MeshDelta inverse(const MeshDelta& delta);

/// A face of a wound, with tissue on one side only. The face lies on the blade or was bared by an ablation.
struct LipFace {
    TetFace face; ///< session ids
    int side = 0; ///< sign of BladeCoordinates::side; 0: bared by an ablation
    int cut = 0; ///< number of the cut in this session, from 0
};

enum class CutStatus { done, missed_body, cancelled };

struct CutOptions {
    /// A vertex nearer to the blade than this share of its shortest edge is moved onto the blade, which avoids slivers
    /// and keeps elements few. Between 0 and 0.5. With 0 no vertex moves, and volumes are kept to round-off. The
    /// default gave the best angles for random strokes through Kuhn boxes. No move takes more than 75 % of an element's
    /// volume, or carries a surface or an interface farther than 5 % of the shortest edge at the vertex; all moves
    /// together carry it no farther than 5 % of the mean edge. Vertices on earlier wounds do not move.
    double snap = 0.35;
    /// No move onto the blade makes a dihedral angle below this limit, unless the angle was smaller before.
    double snap_angle_deg = 12.0;
    /// Elements near the blade with a smaller dihedral angle are opened by shifting and merging vertices, unless snap
    /// is 0.
    double improve_below_deg = 12.0;
    /// Limit for bends that become edges of the mesh. A bend's ray becomes an edge when a chord as long as the local
    /// edges would lie as far off the blade as at a single bend of this angle in the chord's middle. Faces with their
    /// corners on the blade span gentler bends, and the twist between neighbouring rays of different directions; these
    /// faces lie at most 0.1 edges off the blade where no strip is twisted (CutReport::lip_to_blade reports the
    /// distance). With 0 every bend and twist is followed, at the cost of slivers where bends meet.
    double crease_deg = 20.0;
    /// Labels that the blade does not sever (a scalpel does not cut bone). Their elements stay connected.
    std::vector<Label> uncut_labels {};
    /// Largest number of elements of the session; a cut that needs more is refused (SolverError). Repeated cuts through
    /// one place divide elements again and again. At least 1.
    std::size_t element_limit = 20'000'000;
};

/// Counts and quality of a cut, for the user and the benchmark. Angles are dihedral angles of elements.
struct CutReport {
    std::size_t tets_crossed = 0; ///< crossed elements before vertices are moved
    std::size_t tets_before = 0, tets_after = 0;
    std::size_t tets_created = 0, tets_removed = 0; ///< elements born and gone
    std::size_t vertices_moved = 0, vertices_merged = 0;
    double largest_move_mm = 0.0;
    /// Largest distance by which all moves of a vertex carried its surface, in local edges (mean edges of the session's
    /// first elements there).
    double surface_deviation = 0.0;
    double lip_area_mm2 = 0.0; ///< area of one lip, or area bared by an ablation; rest configuration
    double removed_volume_mm3 = 0.0; ///< volume that an ablation removed; rest configuration
    double lip_to_blade = 0.0; ///< largest distance of a lip face's middle from the blade, in edges of the face
    double worst_dihedral_before_deg = 180.0; ///< smallest angle of the elements gone
    double worst_dihedral_deg = 180.0; ///< smallest angle of the elements born
    double p01_dihedral_deg = 180.0; ///< 1st percentile of all angles of the elements born
    /// Number of elements born whose smallest angle is below the default of CutOptions::improve_below_deg, and below
    /// half the smallest angle of the elements gone that they are made of. Where the blade grazes, geometry forbids
    /// better angles.
    std::size_t tets_below_half_parent = 0;
    double smallest_volume_ratio = 1.0; ///< smallest volume of an element born over the mean volume of elements gone
    /// Attempts at the stroke. After an attempt that broke a guarantee, fewer vertices were moved, more bends were
    /// followed, or elements were halved.
    int attempts = 1;
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
