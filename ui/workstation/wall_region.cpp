#include "ui/workstation/wall_region.h"

#include "mesh/corridor.h"
#include "mesh/wound_surface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace retractor {

namespace {

    constexpr double kFadeMm = 40.0; ///< from the rim to what is at rest
    constexpr double kRimBandMm
        = 4.0; ///< how far the mesh's border may lie inside the region's: its elements are coarse
    /// Anchors nearer than this count about alike, and there are many: bones at rest may lie close under skin that
    /// moves.
    constexpr double kNearMm = 4.0;
    constexpr std::size_t kAnchors = 40; ///< per vertex

    std::vector<char> skin_flags(const LabelTable& labels)
    {
        std::vector<char> skin(static_cast<std::size_t>(std::numeric_limits<Label>::max()) + 1, 0);
        for (const LabelInfo& info : labels)
            skin[info.id] = info.material == "skin" ? 1 : 0;
        return skin;
    }

    /// 1 at no distance, 0 at kFadeMm, flat at both ends.
    double fade(double distance_mm)
    {
        const double x = std::clamp(distance_mm / kFadeMm, 0.0, 1.0);
        return 1.0 - x * x * (3.0 - 2.0 * x);
    }

    /// Vertices of the wall's surface on its rim, and of what is meshed beyond it (bones kept whole).
    std::vector<VertexId> rim_vertices(const TetMesh& wall, const WallRegion& region)
    {
        if (!region.has_limit())
            return {};
        const TetSurface boundary = boundary_surface(wall, {});
        std::vector<VertexId> rim;
        for (std::size_t v = 0; v < boundary.vertex_of.size(); ++v)
            if (region.rim_distance(boundary.surface.vertices.row(static_cast<Eigen::Index>(v)).transpose())
                <= kRimBandMm)
                rim.push_back(boundary.vertex_of[v]);
        return rim;
    }

} // namespace

double WallRegion::rim_distance(const Vec3& rest) const
{
    return has_limit() ? meshed_mm - polyline_distance(corridor, rest) : std::numeric_limits<double>::infinity();
}

bool WallRegion::can_cut(const Vec3& rest) const { return rim_distance(rest) >= kRimMarginMm; }

std::vector<EdgePlace> region_outline(
    const TetMesh& wall, const WallRegion& region, const LabelTable& labels, const Vec3& outward)
{
    if (!region.has_limit())
        return {};
    const TetSurface boundary = boundary_surface(wall, {});
    const TriMesh& mesh = boundary.surface;
    const std::vector<char> is_skin = skin_flags(labels);
    const bool any_skin = std::any_of(mesh.labels.begin(), mesh.labels.end(), [&](Label l) { return is_skin[l] != 0; });
    std::vector<double> inside(static_cast<std::size_t>(mesh.vertices.rows()));
    for (std::size_t v = 0; v < inside.size(); ++v)
        inside[v] = region.rim_distance(mesh.vertices.row(static_cast<Eigen::Index>(v)).transpose()) - kRimMarginMm;
    std::vector<EdgePlace> places;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
        const auto& t = mesh.triangles[f];
        const Vec3 a = mesh.vertices.row(t[0]), b = mesh.vertices.row(t[1]), c = mesh.vertices.row(t[2]);
        if (any_skin ? is_skin[mesh.labels[f]] == 0 : (b - a).cross(c - a).dot(outward) <= 0.0)
            continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto from = static_cast<std::size_t>(t[k]), to = static_cast<std::size_t>(t[(k + 1) % 3]);
            if ((inside[from] >= 0.0) != (inside[to] >= 0.0))
                places.push_back(
                    { boundary.vertex_of[from], boundary.vertex_of[to], inside[from] / (inside[from] - inside[to]) });
        }
    }
    return places;
}

std::vector<Vec3> shown_places(const std::vector<EdgePlace>& places, const WallPicture& picture)
{
    std::vector<Vec3> shown;
    shown.reserve(places.size());
    for (const EdgePlace& place : places)
        shown.emplace_back(
            ((1.0 - place.t) * picture.shown.row(place.a) + place.t * picture.shown.row(place.b)).transpose());
    return shown;
}

BeyondSurface::BeyondSurface(std::shared_ptr<const TriMesh> surface, const TetMesh& wall, const WallRegion& region)
    : surface_(std::move(surface))
{
    const std::vector<VertexId> rim = rim_vertices(wall, region);
    std::vector<std::pair<double, VertexId>> near;
    for (Eigen::Index v = 0; v < surface_->vertices.rows(); ++v) {
        first_.push_back(anchors_.size());
        const Vec3 p = surface_->vertices.row(v).transpose();
        near.clear();
        for (const VertexId r : rim)
            if (const double d2 = (wall.vertices.row(r).transpose() - p).squaredNorm(); d2 < kFadeMm * kFadeMm)
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

Points BeyondSurface::shown(const WallPicture& picture) const
{
    Points shown = surface_->vertices;
    for (Eigen::Index v = 0; v < shown.rows(); ++v)
        for (std::size_t i = first_[static_cast<std::size_t>(v)]; i < first_[static_cast<std::size_t>(v) + 1]; ++i) {
            const Anchor& anchor = anchors_[i];
            shown.row(v)
                += anchor.share * (picture.shown.row(anchor.vertex) - picture.surface->rest.row(anchor.vertex));
        }
    return shown;
}

} // namespace retractor
