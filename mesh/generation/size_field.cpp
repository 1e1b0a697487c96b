#include "mesh/generation/size_field.h"

#include "mesh/base/assert.h"
#include "mesh/base/corridor.h"
#include "mesh/image/local_thickness.h"
#include "mesh/image/skeleton.h"

#include <algorithm>
#include <limits>

namespace retractor::mesh {

namespace {

    /// Largest edge length over thickness for a label. A sheet keeps its volume with edges of two or three times its
    /// thickness; a rib is curved and must stay in one piece; other thin labels follow their neighbours.
    double edge_per_thickness(const LabelInfo& info)
    {
        if (is_skeleton(info))
            return 0.8;
        if (info.material == "skin")
            return 2.5;
        return 4.0;
    }

    /// Growth of the wanted edge (mm) per mm of distance from the corridor. Neighbours then differ by about a third,
    /// and refinement makes no slivers.
    constexpr double kEdgeGrowth = 0.4;

    /// Coarser edges for bones beyond the region, or in the coarse model: these bones bend, but nobody looks at them.
    constexpr double kBareFactor = 1.4;

    /// Growth of the edges (mm) per mm of distance in the coarse model, and the largest of these edges over
    /// coarse_edge_mm. Longer edges would save few elements, because bones keep theirs.
    constexpr double kFarGrowth = 0.15;
    constexpr double kMostFarGrowth = 2.0;

    /// Allowed facet distance as a share of the edge. A chord of length h has a sagitta of h^2 / (8 R); with this
    /// share, edges get shorter only on surfaces with a radius R below h. The facets are shifted onto the surface
    /// afterwards (mesh/generation/mesh_polish.h).
    constexpr double kDistancePerEdge = 0.12;

    CorridorDistance of_wall(const WallVoxels& wall, std::vector<Vec3> polyline)
    {
        return { std::move(polyline), wall.centre(0, 0, 0),
            wall.centre(wall.size[0] - 1, wall.size[1] - 1, wall.size[2] - 1) };
    }

    std::vector<Vec3> joined(std::vector<Vec3> line, const std::vector<Vec3>& more)
    {
        line.insert(line.end(), more.begin(), more.end());
        return line;
    }

} // namespace

SizeField::SizeField(const WallVoxels& wall, const LabelTable& table, const MeshSizing& sizing,
    std::vector<Vec3> local_corridor, std::vector<Vec3> local_places, std::vector<Vec3> local_path)
    : wall_(wall)
    , sizing_(sizing)
    , corridor_(of_wall(wall, local_corridor))
    , path_(of_wall(wall, local_path))
    , region_line_(of_wall(wall, joined(std::move(local_corridor), local_path)))
    , places_(std::move(local_places))
    , edges_per_thickness_(wall.labels.size() + 1, 0.0)
    , thickness_(local_thickness(wall))
{
    for (std::size_t n = 0; n < wall.labels.size(); ++n) {
        const LabelInfo& info = *find_label(table, wall.labels[n]);
        edges_per_thickness_[n + 1] = edge_per_thickness(info);
        is_bone_.push_back(is_skeleton(info) ? 1 : 0);
    }
}

double SizeField::into_coarse(const Vec3& local) const
{
    if (sizing_.coarse_beyond_mm <= 0.0)
        return 0.0;
    return std::max(0.0, region_line_.distance(local) - sizing_.coarse_beyond_mm);
}

double SizeField::corridor_edge(const Vec3& local, double into_coarse_mm) const
{
    const double beyond = corridor_.distance(local) - sizing_.corridor_radius_mm;
    const double longest
        = std::min(sizing_.coarse_edge_mm + kFarGrowth * into_coarse_mm, kMostFarGrowth * sizing_.coarse_edge_mm);
    return std::clamp(sizing_.corridor_edge_mm + kEdgeGrowth * beyond, sizing_.corridor_edge_mm, longest);
}

double SizeField::path_edge(const Vec3& local) const
{
    const double beyond = std::max(0.0, path_.distance(local) - sizing_.coarse_path_radius_mm);
    return sizing_.coarse_path_edge_mm + kEdgeGrowth * beyond;
}

double SizeField::fine_edge(const Vec3& local) const
{
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& place : places_)
        nearest = std::min(nearest, (local - place).norm());
    return sizing_.fine_edge_mm + kEdgeGrowth * std::max(0.0, nearest - sizing_.fine_radius_mm);
}

double SizeField::thin_limit(const Vec3& local, int label) const
{
    RETRACTOR_ASSERT(label > 0 && static_cast<std::size_t>(label) < edges_per_thickness_.size());
    std::array<int, 3> cell {};
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        const double index = local[axis] / wall_.spacing[axis] - wall_.first[a];
        cell[a] = static_cast<int>(std::clamp(index, 0.0, wall_.size[a] - 2.0));
    }
    float thickness = std::numeric_limits<float>::infinity();
    for (int corner = 0; corner < 8; ++corner) {
        const std::size_t at
            = wall_.offset(cell[0] + (corner & 1), cell[1] + ((corner >> 1) & 1), cell[2] + ((corner >> 2) & 1));
        if (wall_.voxels[at] == label)
            thickness = std::min(thickness, thickness_[at]);
    }
    return thickness * edges_per_thickness_[static_cast<std::size_t>(label)];
}

double SizeField::bare_factor(const Vec3& local) const
{
    const bool is_bare = sizing_.region_mm > 0.0 && region_line_.distance(local) > sizing_.region_mm;
    return is_bare ? kBareFactor : 1.0;
}

double SizeField::edge(const Vec3& local, int a, int b) const
{
    const double into_coarse_mm = into_coarse(local);
    double wanted = std::min(corridor_edge(local, into_coarse_mm), path_edge(local));
    for (const int label : { a, b }) {
        if (label == 0)
            continue;
        if (into_coarse_mm <= 0.0)
            wanted = std::min(wanted, bare_factor(local) * thin_limit(local, label));
        else if (is_bone_[static_cast<std::size_t>(label - 1)] != 0) // soft tissues have no layers there
            wanted = std::min(wanted, kBareFactor * thin_limit(local, label));
    }
    return std::min(std::max(wanted, sizing_.corridor_edge_mm), fine_edge(local));
}

double SizeField::facet_distance(const Vec3& local, int a, int b) const { return kDistancePerEdge * edge(local, a, b); }

} // namespace retractor::mesh
