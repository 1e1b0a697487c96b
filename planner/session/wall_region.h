#pragma once
// Where the wall that the knife cuts ends: tissue is meshed within some distance of the planned incision only. Its
// border on the skin, as a line; and the body beyond it, which is drawn and goes along with the rim, but is not cut.
// Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/session/wall_picture.h"

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// The knife keeps this far from the rim of the mesh: the surface drawn beyond it reaches some millimetres under the
/// rim, and a wound there would gape over it.
inline constexpr double kRimMarginMm = 6.0;

struct WallRegion {
    std::vector<Vec3> corridor; ///< the planned incision, as meshed
    double meshed_mm = 0.0; ///< tissue within this distance of it is meshed; 0: all of it is

    bool has_limit() const { return meshed_mm > 0.0 && !corridor.empty(); }
    /// Whether the knife may cut there (at rest).
    bool can_cut(const Vec3& rest) const;
    /// Of the meshed region's rim, from inside; infinite without a limit.
    double rim_distance(const Vec3& rest) const;
};

/// Why nothing is done there, for the surgeon. @param what is not done, e.g. "the knife cannot cut here".
std::string outside_the_outline(std::string_view what);

/// A place on an edge of the uncut wall: (1 - t) a + t b.
struct EdgePlace {
    VertexId a = 0, b = 0;
    double t = 0.0;
    Vec3 rest_a = Vec3::Zero(), rest_b = Vec3::Zero(); ///< of the ends; ids may be others' later
};

/// The border of where the knife may cut, on the skin (on what looks `outward` where the wall has none): the ends of
/// its pieces, two by two. Empty without a limit.
std::vector<EdgePlace> region_outline(
    const mesh::TetMesh& wall, const WallRegion& region, const mesh::LabelTable& labels, const Vec3& outward);
/// Where they are shown; pieces on tissue that was taken out are left out.
std::vector<Vec3> shown_places(const std::vector<EdgePlace>& places, const WallPicture& picture);

/// The body beyond the region. Near the rim it moves as what is left of the rim does, which springs and hooks carry
/// along, and 40 mm away it is at rest: smooth, no mechanics.
class BeyondSurface {
public:
    /// @param surface at rest, with labels. @param wall uncut.
    BeyondSurface(std::shared_ptr<const TriMesh> surface, const mesh::TetMesh& wall, const WallRegion& region);

    const std::shared_ptr<const TriMesh>& rest() const { return surface_; }
    /// Its vertices, as many rows as at rest.
    Points shown(const WallPicture& picture) const;

private:
    struct RimVertex {
        VertexId vertex = 0; ///< of the uncut wall
        Vec3 rest = Vec3::Zero();
    };
    struct Anchor {
        std::size_t rim = 0; ///< number of the rim's vertex
        double share = 0.0; ///< of its displacement
    };
    std::shared_ptr<const TriMesh> surface_;
    std::vector<RimVertex> rim_;
    std::vector<std::size_t> first_; ///< per vertex: its first anchor; one more than there are vertices
    std::vector<Anchor> anchors_;
};

} // namespace retractor::planner
