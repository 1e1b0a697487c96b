#include "planner/session/wall_region.h"

#include "mesh/base/assert.h"
#include "mesh/base/corridor.h"
#include "mesh/base/triangle.h"
#include "mesh/image/skeleton.h"
#include "mesh/surface/wound_surface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kFadeMm = 40.0; ///< distance from the rim at which the motion is zero
    /// Width of the band whose motion the surface outside follows: where it lies under the wall, and the largest
    /// distance between the border of the mesh and of the region, because elements are coarse.
    constexpr double kRimBandMm = kFittedRimMm + 4.0;
    /// Anchors nearer than this weigh about the same. Many anchors are needed, because bones at rest may lie close
    /// under moving skin.
    constexpr double kNearMm = 4.0;
    constexpr std::size_t kAnchors = 40; ///< for each vertex
    /// Largest motion of an end of an outline edge onto the blade, as a share of the edge.
    constexpr double kMovedShare = 0.5;

    std::vector<char> skin_flags(const mesh::LabelTable& labels)
    {
        std::vector<char> skin(static_cast<std::size_t>(std::numeric_limits<Label>::max()) + 1, 0);
        for (const mesh::LabelInfo& info : labels)
            skin[info.id] = info.material == "skin" ? 1 : 0;
        return skin;
    }

    /// 1 at distance 0, 0 at kFadeMm, with zero slope at both ends.
    double fade(double distance_mm)
    {
        const double x = std::clamp(distance_mm / kFadeMm, 0.0, 1.0);
        return 1.0 - x * x * (3.0 - 2.0 * x);
    }

    /// Vertices of the wall's surface on its rim, and of parts that are meshed outside the region (whole bones).
    std::vector<VertexId> rim_vertices(const mesh::TetMesh& wall, const WallRegion& region)
    {
        if (!region.has_limit())
            return {};
        const mesh::TetSurface boundary = mesh::boundary_surface(wall, {});
        std::vector<VertexId> rim;
        for (std::size_t v = 0; v < boundary.vertex_of.size(); ++v)
            if (region.rim_distance(boundary.surface.vertices.row(static_cast<Eigen::Index>(v)).transpose())
                <= kRimBandMm)
                rim.push_back(boundary.vertex_of[v]);
        return rim;
    }

    /// Whether each vertex is on the surface. Vertices of the uncut wall's surface stay on the surface unless a cut or
    /// an ablation removes them.
    std::vector<char> on_surface(const WallSurface& surface)
    {
        std::vector<char> on(static_cast<std::size_t>(surface.rest.rows()), 0);
        for (const auto& triangle : surface.triangles)
            for (const VertexId v : triangle)
                on[static_cast<std::size_t>(v)] = 1;
        return on;
    }

    /// Whether the vertex is the same as before, moved by a cut at most. After a removal another vertex may have taken
    /// the id.
    bool still_there(
        VertexId v, const Vec3& rest, double moved_mm, const WallSurface& surface, const std::vector<char>& on)
    {
        const auto id = static_cast<std::size_t>(v);
        return id < on.size() && on[id] != 0 && (surface.rest.row(v).transpose() - rest).norm() <= moved_mm;
    }

} // namespace

std::string outside_the_outline(std::string_view what)
{
    return std::string(what) + ": the wall is modelled only inside the outline, round the planned incision";
}

double WallRegion::rim_distance(const Vec3& rest) const
{
    return has_limit() ? meshed_mm - polyline_distance(corridor, rest) : std::numeric_limits<double>::infinity();
}

bool WallRegion::can_cut(const Vec3& rest) const { return rim_distance(rest) >= kRimMarginMm; }

std::vector<EdgePlace> region_outline(
    const mesh::TetMesh& wall, const WallRegion& region, const mesh::LabelTable& labels, const Vec3& outward)
{
    if (!region.has_limit())
        return {};
    const mesh::TetSurface boundary = mesh::boundary_surface(wall, {});
    const TriMesh& mesh = boundary.surface;
    const std::vector<char> is_skin = skin_flags(labels);
    const bool any_skin = std::any_of(mesh.labels.begin(), mesh.labels.end(), [&](Label l) { return is_skin[l] != 0; });
    std::vector<double> inside(static_cast<std::size_t>(mesh.vertices.rows()));
    for (std::size_t v = 0; v < inside.size(); ++v)
        inside[v] = region.rim_distance(mesh.vertices.row(static_cast<Eigen::Index>(v)).transpose()) - kRimMarginMm;
    std::vector<EdgePlace> places;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
        const auto& t = mesh.triangles[f];
        if (any_skin ? is_skin[mesh.labels[f]] == 0 : area_vector(mesh.vertices, t).dot(outward) <= 0.0)
            continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto from = static_cast<std::size_t>(t[k]), to = static_cast<std::size_t>(t[(k + 1) % 3]);
            if ((inside[from] >= 0.0) != (inside[to] >= 0.0))
                places.push_back(
                    { boundary.vertex_of[from], boundary.vertex_of[to], inside[from] / (inside[from] - inside[to]),
                        mesh.vertices.row(t[k]), mesh.vertices.row(t[(k + 1) % 3]) });
        }
    }
    return places;
}

std::vector<Vec3> shown_places(const std::vector<EdgePlace>& places, const WallPicture& picture)
{
    std::vector<Vec3> shown;
    shown.reserve(places.size());
    const std::vector<char> on = on_surface(*picture.surface);
    const auto whole = [&](const EdgePlace& place) {
        const double moved_mm = kMovedShare * (place.rest_b - place.rest_a).norm();
        return still_there(place.a, place.rest_a, moved_mm, *picture.surface, on)
            && still_there(place.b, place.rest_b, moved_mm, *picture.surface, on);
    };
    const auto add = [&](const EdgePlace& place) {
        shown.emplace_back(
            ((1.0 - place.t) * picture.shown.row(place.a) + place.t * picture.shown.row(place.b)).transpose());
    };
    for (std::size_t i = 0; i + 1 < places.size(); i += 2)
        if (whole(places[i]) && whole(places[i + 1])) {
            add(places[i]);
            add(places[i + 1]);
        }
    return shown;
}

BeyondSurface::BeyondSurface(
    std::shared_ptr<const TriMesh> surface, const mesh::TetMesh& wall, const WallRegion& region)
    : surface_(std::move(surface))
    , region_(region)
{
    for (const VertexId v : rim_vertices(wall, region))
        rim_.push_back({ v, wall.vertices.row(v).transpose() });
    std::vector<std::pair<double, std::size_t>> near;
    for (Eigen::Index v = 0; v < surface_->vertices.rows(); ++v) {
        first_.push_back(anchors_.size());
        const Vec3 p = surface_->vertices.row(v).transpose();
        near.clear();
        for (std::size_t r = 0; r < rim_.size(); ++r)
            if (const double d2 = (rim_[r].rest - p).squaredNorm(); d2 < kFadeMm * kFadeMm)
                near.emplace_back(d2, r);
        const auto count = static_cast<std::ptrdiff_t>(std::min(kAnchors, near.size()));
        std::partial_sort(near.begin(), near.begin() + count, near.end());
        near.resize(static_cast<std::size_t>(count));
        double sum = 0.0;
        for (const auto& [d2, r] : near)
            sum += 1.0 / (d2 + kNearMm * kNearMm);
        for (const auto& [d2, r] : near)
            anchors_.push_back({ r, fade(std::sqrt(near.front().first)) / (sum * (d2 + kNearMm * kNearMm)) });
    }
    first_.push_back(anchors_.size());
}

std::vector<std::uint8_t> BeyondSurface::replaces(const WallSurface& wall, const mesh::LabelTable& labels) const
{
    std::vector<std::uint8_t> in_rim(static_cast<std::size_t>(wall.rest.rows()), 0);
    for (Eigen::Index v = 0; v < wall.rest.rows(); ++v)
        in_rim[static_cast<std::size_t>(v)] = region_.rim_distance(wall.rest.row(v).transpose()) < kFittedRimMm ? 1 : 0;
    std::vector<std::uint8_t> replaced(wall.triangles.size(), 0);
    for (std::size_t t = 0; t < replaced.size(); ++t) {
        const mesh::LabelInfo* const info = mesh::find_label(labels, wall.labels[t]);
        const bool is_bone = info != nullptr && mesh::is_skeleton(*info); // bones are meshed outside the region, too
        const bool is_rim = std::ranges::all_of(
            wall.triangles[t], [&](VertexId v) { return in_rim[static_cast<std::size_t>(v)] != 0; });
        replaced[t] = is_rim && wall.is_lip[t] == 0 && !is_bone ? 1 : 0;
    }
    return replaced;
}

Points BeyondSurface::shown(const WallPicture& picture) const
{
    const WallSurface& wall = *picture.surface;
    const std::vector<char> on = on_surface(wall);
    RETRACTOR_ASSERT(first_.size() == static_cast<std::size_t>(surface_->vertices.rows()) + 1);
    std::vector<char> left(rim_.size(), 0);
    std::vector<Vec3> moved(rim_.size(), Vec3::Zero());
    for (std::size_t r = 0; r < rim_.size(); ++r) {
        const VertexId v = rim_[r].vertex;
        left[r] = still_there(v, rim_[r].rest, kNearMm, wall, on) ? 1 : 0;
        if (left[r] != 0)
            moved[r] = (picture.shown.row(v) - wall.rest.row(v)).transpose();
    }
    Points shown = surface_->vertices;
    for (Eigen::Index v = 0; v < shown.rows(); ++v) {
        double all = 0.0, of_those_left = 0.0;
        Vec3 sum = Vec3::Zero();
        for (std::size_t i = first_[static_cast<std::size_t>(v)]; i < first_[static_cast<std::size_t>(v) + 1]; ++i) {
            const Anchor& anchor = anchors_[i];
            all += anchor.share;
            if (left[anchor.rim] == 0)
                continue;
            of_those_left += anchor.share;
            sum += anchor.share * moved[anchor.rim];
        }
        if (of_those_left > 0.0)
            shown.row(v) += all / of_those_left * sum.transpose();
    }
    return shown;
}

} // namespace retractor::planner
