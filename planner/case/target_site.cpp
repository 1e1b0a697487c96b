#include "planner/case/target_site.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace retractor::planner {

namespace {

    double distance_from_centre(const TriMesh& organ, const std::array<VertexId, 3>& triangle, const TargetSpec& site)
    {
        Vec3 middle = Vec3::Zero();
        for (const VertexId v : triangle)
            middle += organ.vertices.row(v).transpose() / 3.0;
        return (middle - site.centre).norm();
    }

    /// The triangles on one side of the site's border, with the vertices that they use.
    TriMesh part_of(const TriMesh& organ, const TargetSpec& site, bool inside)
    {
        TriMesh part;
        std::vector<VertexId> new_of(static_cast<std::size_t>(organ.vertices.rows()), -1);
        std::vector<VertexId> used;
        for (std::size_t t = 0; t < organ.triangles.size(); ++t) {
            if ((distance_from_centre(organ, organ.triangles[t], site) <= site.radius_mm) != inside)
                continue;
            std::array<VertexId, 3> triangle = organ.triangles[t];
            for (VertexId& v : triangle) {
                VertexId& number = new_of[static_cast<std::size_t>(v)];
                if (number < 0) {
                    number = static_cast<VertexId>(used.size());
                    used.push_back(v);
                }
                v = number;
            }
            part.triangles.push_back(triangle);
            if (!organ.labels.empty())
                part.labels.push_back(organ.labels[t]);
        }
        part.vertices = organ.vertices(used, Eigen::all);
        return part;
    }

    /// Calls visit(distance, label) for the voxels within a distance of a place, mm.
    template <class Visit>
    void visit_round(const mesh::LabelVolume& labels, const Vec3& place, double farthest_mm, Visit&& visit)
    {
        const Vec3 middle = labels.grid.index(place);
        std::array<int, 3> first {}, last {};
        for (std::size_t a = 0; a < 3; ++a) {
            const auto axis = static_cast<Eigen::Index>(a);
            const double reach = farthest_mm / labels.grid.spacing[axis], end = labels.grid.size[a] - 1.0;
            first[a] = static_cast<int>(std::ceil(std::clamp(middle[axis] - reach, 0.0, end + 1.0)));
            last[a] = static_cast<int>(std::floor(std::clamp(middle[axis] + reach, -1.0, end)));
        }
        for (int k = first[2]; k <= last[2]; ++k)
            for (int j = first[1]; j <= last[1]; ++j)
                for (int i = first[0]; i <= last[0]; ++i)
                    if (const double distance = (labels.grid.world(Vec3(i, j, k)) - place).norm();
                        distance <= farthest_mm)
                        visit(distance, labels.voxels[labels.grid.offset(i, j, k)]);
    }

} // namespace

TriMesh site_surface(const TriMesh& organ, const TargetSpec& site)
{
    TriMesh part = part_of(organ, site, true);
    if (part.triangles.empty()) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& triangle : organ.triangles)
            nearest = std::min(nearest, distance_from_centre(organ, triangle, site));
        throw InputError("the " + site.site + " lies " + in_words(nearest) + " mm from the surface of \"" + site.label
                + "\", and reaches only " + in_words(site.radius_mm) + " mm: choose a place on this surface",
            "target", { "target" });
    }
    return part;
}

void check_site(const mesh::LabelVolume& labels, const TargetSpec& site)
{
    const Label organ = mesh::label_named(labels.table, site.label).id;
    // A radius that holds a voxel of the organ and one of something else holds a piece of the surface.
    bool inside = false, outside = false;
    visit_round(labels, site.centre, site.radius_mm, [&](double, Label label) {
        inside = inside || label == organ;
        outside = outside || label != organ;
    });
    if (!inside || !outside)
        throw InputError("the " + site.site + " reaches " + in_words(site.radius_mm) + " mm, and the surface of \""
                + site.label + "\" is farther away: choose a place nearer to it, or let the site reach farther",
            "target", { "target" });
}

TargetSpec site_at(const mesh::LabelVolume& labels, const Vec3& place)
{
    constexpr double kFarthestMm = 60.0; // half the width of any vessel, and of a heart
    constexpr double kRoundMm = 3.0; // beyond the surface, so that the site is a patch and not a point
    const auto nearest_of = [&](const mesh::LabelFlags& wanted) {
        Label found = mesh::label_at(labels, place);
        double nearest = wanted[found] != 0 ? 0.0 : kSiteMm;
        found = wanted[found] != 0 ? found : Label { 0 };
        visit_round(labels, place, kSiteMm, [&](double distance, Label label) {
            if (wanted[label] != 0 && distance < nearest) {
                nearest = distance;
                found = label;
            }
        });
        return found;
    };
    Label organ = nearest_of(mesh::flagged_labels(labels.table, [](const mesh::LabelInfo& info) {
        return info.role == mesh::Role::target || info.role == mesh::Role::at_risk;
    }));
    if (organ == 0)
        organ = nearest_of(mesh::flagged_labels(labels.table,
            [](const mesh::LabelInfo& info) { return info.role == mesh::Role::voxel && info.material != "bone"; }));
    const mesh::LabelInfo* info = organ == 0 ? nullptr : mesh::find_label(labels.table, organ);
    if (info == nullptr)
        throw InputError("there is no organ or vessel here: choose a place on one", "target", { "target" });
    double depth = kFarthestMm;
    visit_round(labels, place, kFarthestMm, [&](double distance, Label label) {
        if (label != organ)
            depth = std::min(depth, distance);
    });
    return { .label = info->name, .centre = place, .radius_mm = std::ceil(std::max(kSiteMm, depth + kRoundMm)) };
}

TriMesh surface_beside_site(const TriMesh& organ, const TargetSpec& site) { return part_of(organ, site, false); }

} // namespace retractor::planner
