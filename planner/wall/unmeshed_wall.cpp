#include "planner/wall/unmeshed_wall.h"

#include "mesh/base/assert.h"
#include "mesh/base/corridor.h"
#include "mesh/base/spatial_hash.h"
#include "mesh/base/triangle.h"
#include "mesh/image/plane_holes.h"
#include "mesh/image/skeleton.h"
#include "mesh/surface/surface_normals.h"
#include "mesh/surface/wound_surface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kOverlapMm = 4.0; ///< length of the surface under the meshed tissue that is drawn
    /// Depth below the meshed tissue, so that the two surfaces do not flicker through each other.
    constexpr double kSunkMm = 0.2;
    constexpr double kCoverMm = 1.0; ///< tissue over the bones that are meshed outside the region
    constexpr double kFadeMm = 40.0; ///< beyond this distance from the rim only points carried by bones move
    constexpr double kTouchMm = 1.5; ///< points nearer than this to the tetrahedra move exactly with them
    /// Points farther than this follow the smooth field between the tetrahedra and the part at rest.
    constexpr double kReachMm = 5.0;
    constexpr double kNodeMm = 4.0; ///< node distance of the smooth field
    constexpr double kSampleMm = 2.0; ///< between samples of the tetrahedra's surface
    /// Band of the region's own surface that is sampled, where the overlap can touch.
    constexpr double kRimBandMm = 12.0;

    /// A point of the displaced surface of the tetrahedra, at or outside the rim.
    struct MovedPoint {
        Vec3 rest, moved_by, normal;
        bool is_bone;
    };
    using MovedPoints = SpatialHash<MovedPoint>;

    /// The point nearest to `p`; null when none is within kReachMm.
    const MovedPoint* nearest_to(const Vec3& p, const MovedPoints& points)
    {
        const MovedPoint* nearest = nullptr;
        double least = kReachMm * kReachMm;
        points.visit_near(p, kReachMm, [&](const MovedPoint& point) {
            if (const double d = (point.rest - p).squaredNorm(); d < least) {
                least = d;
                nearest = &point;
            }
            return true;
        });
        return nearest;
    }

    MovedPoints moved_points(const mesh::TetMesh& wall, const Points& displacement, const std::vector<Vec3>& corridor,
        double from_mm, const std::vector<Label>& bones)
    {
        const mesh::TetSurface rest = mesh::boundary_surface(wall, {});
        RETRACTOR_ASSERT(displacement.rows() == 0 || displacement.rows() == wall.vertices.rows());
        const bool moves = displacement.rows() > 0;
        MovedPoints points(kReachMm);
        for (std::size_t f = 0; f < rest.surface.triangles.size(); ++f) {
            const auto& triangle = rest.surface.triangles[f];
            const bool is_bone = std::find(bones.begin(), bones.end(), rest.surface.labels[f]) != bones.end();
            std::array<Vec3, 3> at, by;
            for (std::size_t c = 0; c < 3; ++c) {
                at[c] = rest.surface.vertices.row(triangle[c]).transpose();
                by[c] = moves
                    ? Vec3(displacement.row(rest.vertex_of[static_cast<std::size_t>(triangle[c])]).transpose())
                    : Vec3::Zero();
            }
            if (polyline_distance(corridor, (at[0] + at[1] + at[2]) / 3.0) < from_mm)
                continue;
            const Vec3 normal = unit_normal(at[0], at[1], at[2]);
            const double longest = std::max({ (at[0] - at[1]).norm(), (at[1] - at[2]).norm(), (at[2] - at[0]).norm() });
            const int n = std::max(1, static_cast<int>(std::ceil(longest / kSampleMm)));
            for (int a = 0; a <= n; ++a)
                for (int b = 0; a + b <= n; ++b) {
                    const double s = static_cast<double>(a) / n, t = static_cast<double>(b) / n;
                    const Vec3 rest_point = s * at[0] + t * at[1] + (1.0 - s - t) * at[2];
                    points.add(rest_point,
                        { .rest = rest_point,
                            .moved_by = s * by[0] + t * by[1] + (1.0 - s - t) * by[2],
                            .normal = normal,
                            .is_bone = is_bone });
                }
        }
        return points;
    }

    /// How far the tetrahedra's surface lies above a point of the body's surface, along its normal, mm; nothing when no
    /// surface with a like normal is near. The two surfaces are made from the same voxels in two ways.
    std::optional<double> step_to_tetrahedra(const Vec3& p, const Vec3& normal, const MovedPoints& points)
    {
        constexpr double kLikeNormal = 0.95; // the tetrahedra end in a ragged slope
        std::optional<double> step;
        double least = kReachMm * kReachMm;
        points.visit_near(p, kReachMm, [&](const MovedPoint& point) {
            const Vec3 line = point.rest - p;
            const double height = line.dot(normal);
            const double beside = (line - height * normal).norm();
            if (point.normal.dot(normal) > kLikeNormal && beside < kSampleMm && line.squaredNorm() < least) {
                least = line.squaredNorm();
                step = height;
            }
            return true;
        });
        return step;
    }

    /// A place under the rim, and how far the tetrahedra's surface lies above it.
    struct RimStep {
        Vec3 at, normal;
        double step;
    };
    using RimSteps = SpatialHash<RimStep>;

    /// The median of the steps within a distance, on the same side of the wall; nothing when there is none.
    std::optional<double> median_step(const Vec3& p, const Vec3& normal, double within_mm, const RimSteps& steps)
    {
        std::vector<double> found;
        steps.visit_near(p, within_mm, [&](const RimStep& step) {
            if (step.normal.dot(normal) > 0.0 && (step.at - p).norm() <= within_mm)
                found.push_back(step.step);
            return true;
        });
        if (found.empty())
            return std::nullopt;
        const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
        std::nth_element(found.begin(), middle, found.end());
        return *middle;
    }

    /// Heights by which the surface is lifted along its normals, so that it meets the tetrahedra at the rim without a
    /// step: a little below them up to the distance where they end in the picture, and fading to zero beyond it.
    std::vector<double> lifts_to_meet(const TriMesh& rest, const Points& normals, const CorridorDistance& corridor,
        double end_mm, const MovedPoints& moved)
    {
        constexpr double kMeetMm = 25.0; // beyond this distance from the rim nothing is lifted
        constexpr double kBlurMm = 8.0; // over which the steps at the rim are averaged
        const auto count = static_cast<std::size_t>(rest.vertices.rows());
        std::vector<double> lifts(count, 0.0);
        const auto place = [&](std::size_t v) -> Vec3 { return rest.vertices.row(static_cast<Eigen::Index>(v)); };
        const auto normal = [&](std::size_t v) -> Vec3 { return normals.row(static_cast<Eigen::Index>(v)); };
        std::vector<char> under(count, 0);
        std::vector<std::optional<double>> own(count);
        RimSteps raw(kBlurMm), smooth(kMeetMm);
        for (std::size_t v = 0; v < count; ++v) {
            under[v] = corridor.within(place(v), end_mm) ? 1 : 0;
            if (under[v] != 0)
                own[v] = step_to_tetrahedra(place(v), normal(v), moved);
            if (own[v])
                raw.add(place(v), { place(v), normal(v), *own[v] });
        }
        for (std::size_t v = 0; v < count; ++v)
            if (under[v] != 0) {
                const double step = median_step(place(v), normal(v), kBlurMm, raw).value_or(0.0);
                lifts[v] = std::min(step, own[v].value_or(step)) - kSunkMm;
                smooth.add(place(v), { place(v), normal(v), step - kSunkMm });
            }
        for (std::size_t v = 0; v < count; ++v) {
            if (under[v] != 0)
                continue;
            const Vec3 p = place(v), n = normal(v);
            const auto distance = [&](const RimStep& step) {
                return step.normal.dot(n) > 0.0 ? (step.at - p).norm() : kMeetMm + kBlurMm;
            };
            double nearest = kMeetMm, sum = 0.0, weight = 0.0;
            smooth.visit_near(p, kMeetMm, [&](const RimStep& step) {
                nearest = std::min(nearest, distance(step));
                return true;
            });
            if (nearest >= kMeetMm)
                continue;
            smooth.visit_near(p, kMeetMm + kBlurMm, [&](const RimStep& step) {
                const double share = std::max(0.0, 1.0 - (distance(step) - nearest) / kBlurMm);
                sum += share * step.step;
                weight += share;
                return true;
            });
            const double t = 1.0 - nearest / kMeetMm;
            lifts[v] = t * t * (3.0 - 2.0 * t) * sum / weight;
        }
        return lifts;
    }

    /// Below the tetrahedra of a whole rim, whose slopes nothing can be fitted to; unchanged beyond it.
    std::vector<double> lifts_under(const TriMesh& rest, const CorridorDistance& corridor, double region_mm)
    {
        std::vector<double> lifts;
        for (Eigen::Index v = 0; v < rest.vertices.rows(); ++v)
            lifts.push_back(corridor.within(rest.vertices.row(v).transpose(), region_mm) ? -2.0 * kSunkMm : 0.0);
        return lifts;
    }

    /// The part of the surface farther than `limit_mm` from the corridor. Triangles across this limit are cut there,
    /// because whole triangles would cover tissue that the user cuts.
    TriMesh part_beyond(const TriMesh& surface, const CorridorDistance& corridor, double limit_mm)
    {
        const auto at = [&](VertexId v) -> Vec3 { return surface.vertices.row(v).transpose(); };
        std::vector<char> beyond(static_cast<std::size_t>(surface.vertices.rows()));
        for (std::size_t v = 0; v < beyond.size(); ++v)
            beyond[v] = corridor.within(at(static_cast<VertexId>(v)), limit_mm) ? 0 : 1;
        std::vector<Vec3> points;
        std::vector<VertexId> number(beyond.size(), -1);
        const auto kept = [&](VertexId v) {
            VertexId& n = number[static_cast<std::size_t>(v)];
            if (n < 0) {
                n = static_cast<VertexId>(points.size());
                points.push_back(at(v));
            }
            return n;
        };
        std::map<std::pair<VertexId, VertexId>, VertexId> crossings;
        const auto crossing = [&](VertexId out, VertexId in) {
            const auto [entry, is_new] = crossings.try_emplace({ out, in }, static_cast<VertexId>(points.size()));
            if (is_new) {
                const double far = polyline_distance(corridor.polyline(), at(out)) - limit_mm;
                const double near = limit_mm - polyline_distance(corridor.polyline(), at(in));
                points.push_back(at(out) + far / (far + near) * (at(in) - at(out)));
            }
            return entry->second;
        };
        TriMesh part;
        for (const auto& triangle : surface.triangles) {
            std::vector<VertexId> corners; // corners of the remaining part: none, three or four
            for (std::size_t c = 0; c < 3; ++c) {
                const VertexId a = triangle[c], b = triangle[(c + 1) % 3];
                const bool a_out = beyond[static_cast<std::size_t>(a)] != 0;
                if (a_out)
                    corners.push_back(kept(a));
                if (a_out != (beyond[static_cast<std::size_t>(b)] != 0))
                    corners.push_back(a_out ? crossing(a, b) : crossing(b, a));
            }
            for (std::size_t c = 2; c < corners.size(); ++c)
                part.triangles.push_back({ corners[0], corners[c - 1], corners[c] });
        }
        part.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
        for (std::size_t v = 0; v < points.size(); ++v)
            part.vertices.row(static_cast<Eigen::Index>(v)) = points[v].transpose();
        return part;
    }

    /// A smooth displacement between the moved tetrahedra and the part at rest. The displacement is harmonic on a
    /// regular grid, independent of the triangles.
    class FadingField {
    public:
        FadingField(const MovedPoints& moved, const CorridorDistance& corridor, double rest_from_mm)
            : low_(Vec3::Constant(std::numeric_limits<double>::infinity()))
        {
            Vec3 high = -low_;
            for (const Vec3& p : corridor.polyline()) {
                low_ = low_.cwiseMin(p);
                high = high.cwiseMax(p);
            }
            low_.array() -= rest_from_mm + 2.0 * kNodeMm;
            high.array() += rest_from_mm + 2.0 * kNodeMm;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto a = static_cast<Eigen::Index>(axis);
                size_[axis] = 2 + static_cast<int>((high[a] - low_[a]) / kNodeMm);
            }
            values_.assign(offset(0, 0, size_[2]), Vec3::Zero());
            std::vector<std::size_t> free;
            for (int k = 0; k < size_[2]; ++k)
                for (int j = 0; j < size_[1]; ++j)
                    for (int i = 0; i < size_[0]; ++i) {
                        const Vec3 p = low_ + kNodeMm * Vec3(i, j, k);
                        if (const MovedPoint* sample = nearest_to(p, moved))
                            values_[offset(i, j, k)] = sample->moved_by;
                        else if (i > 0 && j > 0 && k > 0 && i + 1 < size_[0] && j + 1 < size_[1] && k + 1 < size_[2]
                            && corridor.within(p, rest_from_mm))
                            free.push_back(offset(i, j, k));
                    }
            relax(free);
        }

        Vec3 at(const Vec3& p) const
        {
            const Vec3 index = (p - low_) / kNodeMm;
            std::array<int, 3> cell {};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double at = index[static_cast<Eigen::Index>(axis)];
                if (!(at >= 0.0) || !(at < size_[axis] - 1))
                    return Vec3::Zero();
                cell[axis] = static_cast<int>(at);
            }
            const Vec3 f = index - Vec3(cell[0], cell[1], cell[2]);
            Vec3 sum = Vec3::Zero();
            for (int corner = 0; corner < 8; ++corner) {
                const int a = corner & 1, b = (corner >> 1) & 1, c = corner >> 2;
                sum += (a ? f.x() : 1.0 - f.x()) * (b ? f.y() : 1.0 - f.y()) * (c ? f.z() : 1.0 - f.z())
                    * values_[offset(cell[0] + a, cell[1] + b, cell[2] + c)];
            }
            return sum;
        }

    private:
        std::size_t offset(int i, int j, int k) const
        {
            return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size_[1]) + static_cast<std::size_t>(j))
                * static_cast<std::size_t>(size_[0])
                + static_cast<std::size_t>(i);
        }

        /// Successive over-relaxation. The free nodes lie between two fixed sheets some 20 nodes apart, so 60 sweeps
        /// leave less than 1 %.
        void relax(const std::vector<std::size_t>& free)
        {
            constexpr int kSweeps = 60;
            constexpr double kOverRelaxation = 1.8;
            const std::size_t row = offset(0, 1, 0), layer = offset(0, 0, 1);
            for (int sweep = 0; sweep < kSweeps; ++sweep)
                for (const std::size_t n : free) {
                    const Vec3 mean = (values_[n - 1] + values_[n + 1] + values_[n - row] + values_[n + row]
                                          + values_[n - layer] + values_[n + layer])
                        / 6.0;
                    values_[n] += kOverRelaxation * (mean - values_[n]);
                }
        }

        Vec3 low_;
        std::array<int, 3> size_ { 0, 0, 0 };
        std::vector<Vec3> values_;
    };

    /// Tells the air round the body from cavities without a label: what axial slices do not enclose.
    struct OutsideOfBody {
        const mesh::ImageGrid& grid;
        std::vector<std::uint8_t> enclosed; ///< per voxel

        explicit OutsideOfBody(const mesh::LabelVolume& labels)
            : grid(labels.grid)
        {
            Eigen::Index along = 0; // the image axis along the body; an unlabelled cavity may be open at its ends
            grid.direction.row(2).cwiseAbs().maxCoeff(&along);
            std::vector<std::uint8_t> mask(labels.voxels.size());
            std::transform(labels.voxels.begin(), labels.voxels.end(), mask.begin(),
                [](Label voxel) { return static_cast<std::uint8_t>(voxel != 0); });
            enclosed = mesh::holes_filled_in_planes(grid.size, mask, static_cast<int>(along));
        }

        bool contains(const Vec3& p) const
        {
            const Vec3 at = grid.index(p);
            const int i = static_cast<int>(std::lround(at.x())), j = static_cast<int>(std::lround(at.y())),
                      k = static_cast<int>(std::lround(at.z()));
            return grid.contains(i, j, k) && enclosed[grid.offset(i, j, k)] == 0;
        }
    };

    /// Gives each triangle the label of the wall voxel slightly inside it. Bone is only bare, and soft tissue without
    /// skin, where the image ends. Elsewhere this means that the labels lack one voxel of skin or pleura.
    void label_triangles(TriMesh& surface, const mesh::LabelVolume& labels)
    {
        const mesh::LabelFlags is_wall = mesh::flagged_labels(labels.table, mesh::is_wall),
                               is_skeleton = mesh::flagged_labels(labels.table, mesh::is_skeleton);
        Label skin = 0, muscle = 0;
        for (const mesh::LabelInfo& info : labels.table) {
            if (info.role != mesh::Role::wall)
                continue;
            skin = info.material == "skin" || skin == 0 ? info.id : skin;
            muscle = info.material == "muscle" || muscle == 0 ? info.id : muscle;
        }
        const OutsideOfBody outside(labels);
        const double voxel = labels.grid.spacing.maxCoeff();
        const auto ends_here = [&](const Vec3& p) {
            const Vec3 at = labels.grid.index(p);
            return !labels.grid.contains(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())),
                static_cast<int>(std::lround(at.z())));
        };
        surface.labels.reserve(surface.triangles.size());
        for (const auto& triangle : surface.triangles) {
            const auto [a, b, c] = triangle_corners(surface.vertices, triangle);
            const Vec3 inward = -unit_normal(a, b, c), middle = (a + b + c) / 3.0;
            Label label = 0;
            for (const double voxels : { 0.7, 1.4, 0.0 }) {
                label = mesh::label_at(labels, middle + voxels * voxel * inward);
                if (is_wall[label] != 0)
                    break;
            }
            const Vec3 beyond = middle - 2.0 * voxel * inward;
            if (is_wall[label] == 0)
                label = skin;
            else if (outside.contains(beyond))
                label = skin;
            else if (is_skeleton[label] != 0 && !ends_here(beyond))
                label = mesh::label_at(labels, beyond) == 0 ? skin : muscle;
            surface.labels.push_back(label);
        }
    }

} // namespace

double drawn_rim_width_mm(double region_mm, double cut_depth_mm)
{
    // The region's line runs along the incision and half way down the cut, so that the cut ends this far from it.
    const double cut_mm = 0.5 * cut_depth_mm;
    constexpr double kLeftOutMm = 15.0, kShareOfRegion = 0.3, kBesideCutMm = 10.0;
    return std::max(0.0, std::min({ kLeftOutMm, kShareOfRegion * region_mm, region_mm - cut_mm - kBesideCutMm }));
}

TriMesh without_rim(TriMesh boundary, const TriMesh& at_rest, const mesh::MeshSizing& sizing, double rim_mm)
{
    RETRACTOR_ASSERT(boundary.triangles == at_rest.triangles && boundary.labels.size() == boundary.triangles.size());
    if (sizing.region_mm <= 0.0 || rim_mm <= 0.0)
        return boundary;
    const std::vector<Vec3> line = mesh::region_line(sizing);
    const double limit = sizing.region_mm - rim_mm;
    std::vector<char> inside(static_cast<std::size_t>(at_rest.vertices.rows()));
    for (std::size_t v = 0; v < inside.size(); ++v)
        inside[v]
            = polyline_distance(line, at_rest.vertices.row(static_cast<Eigen::Index>(v)).transpose()) < limit ? 1 : 0;
    std::size_t kept = 0;
    for (std::size_t t = 0; t < boundary.triangles.size(); ++t) {
        const auto& corners = boundary.triangles[t];
        const bool is_rim = std::none_of(
            corners.begin(), corners.end(), [&](VertexId v) { return inside[static_cast<std::size_t>(v)] != 0; });
        const auto& whole = sizing.whole_labels; // bones beyond the region are meshed, too
        if (is_rim && std::find(whole.begin(), whole.end(), boundary.labels[t]) == whole.end())
            continue;
        boundary.triangles[kept] = corners;
        boundary.labels[kept++] = boundary.labels[t];
    }
    boundary.triangles.resize(kept);
    boundary.labels.resize(kept);
    return boundary;
}

TriMesh unmeshed_wall_region(const TriMesh& body, const mesh::LabelVolume& labels, const mesh::MeshSizing& sizing,
    const mesh::TetMesh& wall, const Points& displacement, double rim_mm, const Job& job)
{
    if (sizing.region_mm <= 0.0 || body.triangles.empty())
        return {};
    const Stopwatch watch;
    const std::vector<Vec3> line = mesh::region_line(sizing);
    const CorridorDistance corridor(
        line, body.vertices.colwise().minCoeff().transpose(), body.vertices.colwise().maxCoeff().transpose());
    const double begin_mm = sizing.region_mm - rim_mm - kOverlapMm;
    TriMesh rest = part_beyond(body, corridor, begin_mm);
    if (rest.triangles.empty() || job.cancelled())
        return {};
    label_triangles(rest, labels);

    const MovedPoints moved
        = moved_points(wall, displacement, line, sizing.region_mm - rim_mm - kRimBandMm, sizing.whole_labels);
    const FadingField field(moved, corridor, sizing.region_mm + kFadeMm);
    const Points normals = mesh::vertex_normals(rest);
    const std::vector<double> lifts = rim_mm > 0.0
        ? lifts_to_meet(rest, normals, corridor, sizing.region_mm - 0.5 * rim_mm, moved)
        : lifts_under(rest, corridor, sizing.region_mm);
    for (Eigen::Index row = 0; row < rest.vertices.rows(); ++row) {
        const Vec3 p = rest.vertices.row(row), normal = normals.row(row);
        Vec3 by = field.at(p);
        double lift = lifts[static_cast<std::size_t>(row)];
        if (const MovedPoint* sample = nearest_to(p, moved)) {
            const double off = (sample->rest - p).norm();
            const double share = std::clamp((off - kTouchMm) / (kReachMm - kTouchMm), 0.0, 1.0);
            by = share * by + (1.0 - share) * sample->moved_by;
            if (sample->is_bone && !corridor.within(p, sizing.region_mm)) {
                const double above = (p - sample->rest).dot(normal);
                const double beside = (p - sample->rest - above * normal).norm();
                lift += std::max(0.0, kCoverMm - above) * std::clamp(2.0 - beside / kSampleMm, 0.0, 1.0);
            }
        }
        rest.vertices.row(row) += (by + lift * normal).transpose();
    }
    record_part(job, "wall beyond the region", watch,
        static_cast<std::size_t>(rest.vertices.size()) * sizeof(double)
            + rest.triangles.size() * sizeof(rest.triangles[0]));
    return rest;
}

std::vector<Label> drawn_labels(
    const TriMesh& boundary, const mesh::LabelVolume& labels, const mesh::MeshSizing& sizing)
{
    RETRACTOR_ASSERT(boundary.labels.size() == boundary.triangles.size());
    const auto skin = std::ranges::find(labels.table, "skin", &mesh::LabelInfo::material);
    if (skin == labels.table.end())
        return boundary.labels;
    const std::vector<Vec3> line = mesh::region_line(sizing);
    const OutsideOfBody outside(labels);
    std::vector<Label> drawn = boundary.labels;
    for (std::size_t t = 0; t < drawn.size(); ++t) {
        const auto [a, b, c] = triangle_corners(boundary.vertices, boundary.triangles[t]);
        const Vec3 middle = (a + b + c) / 3.0, out = unit_normal(a, b, c);
        const mesh::LabelInfo* info = mesh::find_label(labels.table, drawn[t]);
        if (info == nullptr || is_skeleton(*info))
            continue;
        const bool is_coarse
            = sizing.coarse_beyond_mm > 0.0 && polyline_distance(line, middle) > sizing.coarse_beyond_mm;
        // A flat face of the coarse model lies up to this distance under the skin; where the mesh has a layer of skin,
        // single elements of it may be missing.
        constexpr double kDeepestMm = 8.0, kDeepestUnderLayerMm = 3.0, kStepMm = 1.0;
        const double deepest = is_coarse ? kDeepestMm : kDeepestUnderLayerMm;
        for (double d = kStepMm; d <= deepest; d += kStepMm)
            if (outside.contains(middle + d * out)) {
                drawn[t] = skin->id;
                break;
            }
    }
    return drawn;
}

} // namespace retractor::planner
