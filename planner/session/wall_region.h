#pragma once
// The region of the wall that the knife can cut, because only tissue near the planned incision is meshed: its border on
// the skin as a line, and the wall outside the mesh, which is drawn and follows the rim but cannot be cut. Units mm;
// frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/session/wall_picture.h"

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// Width of the mesh's rim over which the surface drawn outside the mesh is fitted to the wall. The tetrahedra end
/// there in ragged slopes, and the surface closes the gaps between them.
inline constexpr double kFittedRimMm = 6.0;
/// Distance that the knife keeps from the rim of the mesh. The surface drawn outside the mesh reaches under the wall a
/// little farther than the fitted rim, and would show in a wound there.
inline constexpr double kRimMarginMm = kFittedRimMm + 6.0;

struct WallRegion {
    std::vector<Vec3> corridor; ///< planned incision, as used for the mesh
    double meshed_mm = 0.0; ///< tissue within this distance of `corridor` is meshed; 0: all tissue

    bool has_limit() const { return meshed_mm > 0.0 && !corridor.empty(); }
    /// Whether the knife may cut at this place (at rest).
    bool can_cut(const Vec3& rest) const;
    /// Distance from inside to the rim of the meshed region, mm; infinite without a limit.
    double rim_distance(const Vec3& rest) const;
};

/// Message for the surgeon that a place is outside the region.
/// @param what the refused action, e.g. "the knife cannot cut here"
std::string outside_the_outline(std::string_view what);

/// A place on an edge of the uncut wall: (1 - t) a + t b.
struct EdgePlace {
    VertexId a = 0, b = 0;
    double t = 0.0;
    Vec3 rest_a = Vec3::Zero(), rest_b = Vec3::Zero(); ///< rest positions of the ends; a later cut may reuse the ids
};

/// The border of the region that the knife may cut, on the skin (on faces towards `outward` when the wall has no skin),
/// as line segments: two places per segment. Empty without a limit.
std::vector<EdgePlace> region_outline(
    const mesh::TetMesh& wall, const WallRegion& region, const mesh::LabelTable& labels, const Vec3& outward);
/// Shown positions of the places; segments on removed tissue are left out.
std::vector<Vec3> shown_places(const std::vector<EdgePlace>& places, const WallPicture& picture);

/// The wall outside the mesh. Near the rim it moves with the remaining rim, which springs and hooks move. The motion
/// decreases smoothly to zero at a distance of 40 mm, without mechanics.
class BeyondSurface {
public:
    /// @param surface at rest, with labels
    /// @param wall the uncut wall
    BeyondSurface(std::shared_ptr<const TriMesh> surface, const mesh::TetMesh& wall, const WallRegion& region);

    const std::shared_ptr<const TriMesh>& rest() const { return surface_; }
    /// Shown vertices, as many rows as at rest.
    Points shown(const WallPicture& picture) const;
    /// Per triangle of the wall, 1: soft tissue of the fitted rim, which the surface replaces in a picture. Lips of
    /// cuts are never replaced.
    std::vector<std::uint8_t> replaces(const WallSurface& wall, const mesh::LabelTable& labels) const;

private:
    struct RimVertex {
        VertexId vertex = 0; ///< vertex of the uncut wall
        Vec3 rest = Vec3::Zero();
    };
    struct Anchor {
        std::size_t rim = 0; ///< index into rim_
        double share = 0.0; ///< share of the rim vertex's displacement
    };
    std::shared_ptr<const TriMesh> surface_;
    WallRegion region_;
    std::vector<RimVertex> rim_;
    std::vector<std::size_t> first_; ///< per vertex: first entry in anchors_; vertex count + 1 entries
    std::vector<Anchor> anchors_;
};

} // namespace retractor::planner
