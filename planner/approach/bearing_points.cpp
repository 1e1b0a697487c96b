#include "planner/approach/bearing_points.h"

#include "mesh/base/triangle.h"
#include "mesh/image/label_share.h"
#include "mesh/image/skeleton.h"
#include "mesh/surface/proximity.h"
#include "mesh/tetrahedra/insert_vertex.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kRaySpacingMm = 1.0;
    constexpr double kRayStepMm = 0.1;
    /// Spacing of the points on which a wide patch bears.
    constexpr double kBearingSpacingMm = 10.0;
    /// Share of the patch's width, to either side of the middle, over which the patch bears.
    constexpr double kBearingShare = 0.25;
    /// Bone this much farther behind the patch than the nearest bone still bears in part: so much do muscle and
    /// periosteum give. The mean over this depth does not jump where the nearest places of a bone are equally near.
    constexpr double kContactDepthMm = 1.0;
    /// A rigid patch does not reach bone that lies this much farther behind it than the nearest bone.
    constexpr double kGapMm = 2.0;
    /// A blade that spares bone may pass this deep through the edge of a rib that then moves with the lip.
    constexpr double kGrazeMm = 2.0;
    /// The surface of a mesh lies this near to the surface of its labels.
    constexpr double kMeshMm = 4.0;

    class Bones {
    public:
        explicit Bones(const mesh::LabelVolume& labels)
            : labels_(labels)
            , is_bone_(mesh::flagged_labels(labels.table,
                  [](const mesh::LabelInfo& info) { return mesh::is_wall(info) && mesh::is_skeleton(info); }))
        {
        }

        /// The share of bone round a point; the surface is where it is a half.
        double share(const Vec3& point) const { return mesh::label_share(labels_, is_bone_, point); }

        /// The name of the bone at a point; empty where there is none.
        std::string name_at(const Vec3& point) const
        {
            const Label label = mesh::label_at(labels_, point);
            return is_bone_[label] != 0 ? mesh::find_label(labels_.table, label)->name : std::string();
        }

    private:
        const mesh::LabelVolume& labels_;
        mesh::LabelFlags is_bone_;
    };

    class Rays {
    public:
        Rays(const Bones& bones, const Approach& approach, const HookSpec& hook)
            : bones_(bones)
            , spared_(approach.uncut_labels)
            , direction_(hook.direction)
            , place_(patch_place(approach, hook))
        {
        }

        Vec3 start(double along, double depth) const
        {
            return place_.centre + along * place_.along + depth * place_.depth;
        }

        /// Distance from a point of the patch to the nearest bone behind it, mm.
        std::optional<double> meet(double along, double depth) const
        {
            const Vec3 from = start(along, depth);
            double before = bones_.share(from - kGrazeMm * direction_);
            for (double behind = -kGrazeMm + kRayStepMm; behind <= kBearingMm + 0.5 * kRayStepMm;
                 behind += kRayStepMm) {
                const double here = bones_.share(from + behind * direction_);
                if (before < 0.5 && here >= 0.5) {
                    const double at = behind - kRayStepMm * (here - 0.5) / (here - before);
                    if (at >= 0.0 || is_spared(from + (at + kContactDepthMm) * direction_))
                        return at;
                }
                before = here;
            }
            return std::nullopt;
        }

    private:
        bool is_spared(const Vec3& point) const
        {
            return std::ranges::find(spared_, bones_.name_at(point)) != spared_.end();
        }

        const Bones& bones_;
        const std::vector<std::string>& spared_;
        Vec3 direction_;
        PatchPlace place_;
    };

    /// Midpoints of equal intervals of about `spacing` between -half and half.
    std::vector<double> midpoints(double half, double spacing)
    {
        const int count = std::max(1, static_cast<int>(std::lround(2.0 * half / spacing)));
        std::vector<double> middle;
        for (int i = 0; i < count; ++i)
            middle.push_back(half * ((2.0 * i + 1.0) / count - 1.0));
        return middle;
    }

    /// A place of the patch, mm from its centre, and the distance of the bone behind it.
    struct Touch {
        double along = 0.0, depth = 0.0, behind = 0.0;
    };

    /// Where a strip across the patch touches bone: the mean place of the bone that lies nearest to it.
    std::optional<Touch> touch_of_strip(const Rays& rays, double middle, double half_width, double half_height)
    {
        std::vector<Touch> met;
        for (const double along : midpoints(half_width, kRaySpacingMm))
            for (const double depth : midpoints(half_height, kRaySpacingMm))
                if (const std::optional<double> behind = rays.meet(middle + along, depth))
                    met.push_back({ middle + along, depth, *behind });
        if (met.empty())
            return std::nullopt;
        const Touch first = *std::ranges::min_element(met, {}, &Touch::behind);
        double sum = 0.0, along = 0.0, depth = 0.0;
        for (const Touch& touch : met) {
            const double weight = std::max(0.0, first.behind + kContactDepthMm - touch.behind);
            sum += weight;
            along += weight * touch.along;
            depth += weight * touch.depth;
        }
        // Between two bones there is no bone at the mean place.
        const std::optional<double> behind = rays.meet(along / sum, depth / sum);
        if (behind && *behind <= first.behind + kContactDepthMm)
            return Touch { along / sum, depth / sum, *behind };
        return first;
    }

    /// The surface of bone and cartilage in a wall: faces of skeletal elements that no other skeletal element shares.
    std::vector<std::array<VertexId, 3>> bone_surface(const mesh::TetMesh& wall, const mesh::LabelTable& table)
    {
        std::vector<Label> skeleton;
        for (const mesh::LabelInfo& info : table)
            if (mesh::is_skeleton(info))
                skeleton.push_back(info.id);
        const mesh::TetMesh bones = mesh::part_with_labels(wall, skeleton);
        std::vector<std::array<VertexId, 3>> surface;
        for (const mesh::TetFace& face : mesh::boundary_faces(bones))
            surface.push_back(mesh::face_vertices(bones, face));
        return surface;
    }

    /// The bones under at least a tenth of the patch: a divided sternum is held by its own cut face.
    std::vector<std::string> bones_under_patch(const Bones& bones, const Rays& rays, const HookSpec& hook)
    {
        constexpr double kLeastShare = 0.1;
        std::map<std::string, double> share;
        const std::vector<double> along = midpoints(0.5 * hook.patch_width_mm, kRaySpacingMm),
                                  depth = midpoints(0.5 * hook.patch_height_mm, kRaySpacingMm);
        for (const double a : along)
            for (const double d : depth)
                if (std::string name = bones.name_at(rays.start(a, d) + kContactDepthMm * hook.direction);
                    !name.empty())
                    share[std::move(name)] += 1.0 / static_cast<double>(along.size() * depth.size());
        std::vector<std::string> names;
        for (const auto& [name, of_patch] : share)
            if (of_patch >= kLeastShare)
                names.push_back(name);
        return names;
    }

} // namespace

std::vector<Vec3> bearing_points(const mesh::LabelVolume& labels, const Approach& approach, const HookSpec& hook)
{
    const Bones bones(labels);
    const Rays rays(bones, approach, hook);
    const double half = kBearingShare * hook.patch_width_mm;
    const std::vector<double> middles = midpoints(half, kBearingSpacingMm);
    std::vector<Touch> touches;
    double nearest = std::numeric_limits<double>::infinity();
    for (const double middle : middles)
        if (const std::optional<Touch> touch
            = touch_of_strip(rays, middle, half / static_cast<double>(middles.size()), 0.5 * hook.patch_height_mm)) {
            touches.push_back(*touch);
            nearest = std::min(nearest, touch->behind);
        }
    std::vector<Vec3> points;
    for (const Touch& touch : touches)
        if (touch.behind <= nearest + kGapMm)
            points.push_back(rays.start(touch.along, touch.depth) + touch.behind * hook.direction);
    return points;
}

void find_bearing_points(Approach& approach, const mesh::LabelVolume& labels)
{
    const Bones bones(labels);
    for (HookSpec& hook : approach.hooks) {
        hook.bearing = bearing_points(labels, approach, hook);
        hook.bears_on = bones_under_patch(bones, Rays(bones, approach, hook), hook);
        for (const Vec3& point : hook.bearing)
            if (std::string name = bones.name_at(point + kContactDepthMm * hook.direction);
                !name.empty() && std::ranges::find(hook.bears_on, name) == hook.bears_on.end())
                hook.bears_on.push_back(std::move(name));
    }
}

void insert_bearing_points(mesh::TetMesh& wall, const mesh::LabelTable& table, const Approach& approach)
{
    for (const HookSpec& hook : approach.hooks)
        for (const Vec3& point : hook.bearing) {
            // A vertex may divide the face that holds the next point, so each point is looked for in the present mesh.
            const std::vector<std::array<VertexId, 3>> surface = bone_surface(wall, table);
            const mesh::TriangleProximity proximity(wall.vertices, surface, kMeshMm);
            const auto near = proximity.within(point, kMeshMm);
            if (!near.empty())
                (void)mesh::insert_vertex(
                    wall, surface[static_cast<std::size_t>(near.front().triangle)], near.front().point.barycentric);
        }
}

std::vector<VertexId> bearing_vertices(const mesh::TetMesh& wall, const mesh::LabelTable& table, const HookSpec& hook)
{
    std::set<VertexId> vertices;
    if (hook.bearing.empty())
        return {};
    const std::vector<std::array<VertexId, 3>> surface = bone_surface(wall, table);
    for (const Vec3& point : hook.bearing) {
        double nearest = kMeshMm;
        std::optional<VertexId> vertex;
        for (const std::array<VertexId, 3>& face : surface)
            for (const VertexId v : face)
                if (const double distance = (point_at(wall.vertices, v) - point).norm(); distance < nearest) {
                    nearest = distance;
                    vertex = v;
                }
        if (vertex)
            vertices.insert(*vertex);
    }
    return { vertices.begin(), vertices.end() };
}

} // namespace retractor::planner
