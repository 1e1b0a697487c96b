#include "mesh/cutting/stroke/cut_extent.h"

#include "mesh/cutting/store/blade.h"
#include "mesh/cutting/store/cut_store.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <sstream>
#include <vector>

namespace retractor::mesh {

namespace {

    constexpr double kSurface = 0.05; ///< permitted deviation of a surface, in local edges
    /// Distance of samples on a flat and on a bent blade, in local edges.
    constexpr double kFlatSpacing = 1.0, kBentSpacing = 0.35;
    /// Distance of samples after attempts that showed strong bends within an element, in local edges.
    constexpr double kCloseSpacing = 0.15;
    /// Smaller bends (degrees) are round-off of points on a straight line; 10,000 such bends turn the line by 10
    /// degrees.
    constexpr double kLeastBend = 1e-3;
    /// A point nearer to an element than this share of the element's height counts as inside; for boxes the share is of
    /// the blade's size. The share is above round-off and far below the permitted error of a wound.
    constexpr double kOnBoundary = 1e-8;
    /// Numbers of samples in one direction. A hole that bends leave in a small wound lies between few samples.
    constexpr int kLeastSamples = 5, kLeastBentSamples = 12, kMostSamples = 400;

    double distance(const std::array<Vec3, 3>& t, const Vec3& p)
    {
        const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
        bool inside = n.squaredNorm() > 0.0;
        double best = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 e = t[(i + 1) % 3] - t[i];
            inside = inside && n.dot(e.cross(p - t[i])) >= 0.0;
            const double s = std::clamp(e.dot(p - t[i]) / e.squaredNorm(), 0.0, 1.0);
            best = std::min(best, (t[i] + s * e - p).norm());
        }
        return inside ? std::abs(n.dot(p - t[0])) / n.norm() : best;
    }

    Eigen::AlignedBox3d box_round(const Vec3& p, double reach)
    {
        return { p - Vec3::Constant(reach), p + Vec3::Constant(reach) };
    }

    /// True also for points on the boundary, because a blade in the plane of faces is in tissue but strictly inside no
    /// element.
    bool is_inside(const std::array<Vec3, 4>& corners, const Vec3& p)
    {
        const double slack = kOnBoundary * tet_volume(corners[0], corners[1], corners[2], corners[3]);
        for (std::size_t i = 0; i < 4; ++i) {
            std::array<Vec3, 4> q = corners;
            q[i] = p;
            if (!(tet_volume(q[0], q[1], q[2], q[3]) > -slack))
                return false;
        }
        return true;
    }

    class Look {
    public:
        explicit Look(const StrokeState& stroke)
            : store_(stroke.store)
            , blade_(stroke.blade)
        {
        }

        /// The local edge (mm) at p, or 0 outside tissue. Where elements of different sizes share p, the smallest edge
        /// counts.
        double local_edge(const Vec3& p)
        {
            store_.gather_near(box_round(p, kOnBoundary * std::max(blade_.length(), blade_.depth())), near_);
            double least = std::numeric_limits<double>::infinity();
            bool inside = false;
            for (const TetId t : near_) {
                inside = inside || is_inside(corners_of(store_, t), p);
                least = std::min(least, store_.first_edge(t));
            }
            return inside ? least : 0.0;
        }

        /// True when a face of a wound is within `reach` (mm).
        bool near_wound(const Vec3& p, double reach)
        {
            return any_face(p, reach,
                [&](TetId t, int corner) { return store_.tet(t).lips[static_cast<std::size_t>(corner)].cut >= 0; });
        }

        bool near_surface(const Vec3& p, double reach)
        {
            return any_face(p, reach, [&](TetId t, int corner) {
                return store_.tet(t).lips[static_cast<std::size_t>(corner)].cut < 0 && store_.across({ t, corner }) < 0;
            });
        }

        /// True when there was no tissue before the cut: p is in no element, and no wound is near.
        bool outside(double along, double depth, double reach)
        {
            const Vec3 p = blade_.at(along, depth);
            return local_edge(p) == 0.0 && !near_wound(p, reach);
        }

    private:
        template <class Counts> bool any_face(const Vec3& p, double reach, Counts&& counts)
        {
            store_.gather_near(box_round(p, reach), near_);
            for (const TetId t : near_) {
                const std::array<Vec3, 4> c = corners_of(store_, t);
                for (int corner = 0; corner < 4; ++corner)
                    if (counts(t, corner) && distance(face_corners(c, corner), p) <= reach)
                        return true;
            }
            return false;
        }

        const CutStore& store_;
        const SweptBlade& blade_;
        std::vector<TetId> near_;
    };

    int samples(double extent, double spacing, bool bent)
    {
        return std::clamp(
            static_cast<int>(std::ceil(extent / spacing)), bent ? kLeastBentSamples : kLeastSamples, kMostSamples);
    }

    /// Places of samples along the line (mm): evenly, and at the bends, where chords are farthest from the blade.
    std::vector<double> places(double from, double to, double spacing, const std::vector<SweptBlade::Crease>& bends)
    {
        std::vector<double> along;
        const int count = samples(to - from, spacing, !bends.empty());
        for (int i = 0; i < count; ++i)
            along.push_back(from + (to - from) * i / count);
        along.push_back(to);
        for (const SweptBlade::Crease& bend : bends)
            if (bend.ray && bend.along > from && bend.along < to)
                along.push_back(bend.along);
        std::sort(along.begin(), along.end());
        along.erase(std::unique(along.begin(), along.end()), along.end());
        return along;
    }

} // namespace

double wound_edge(const StrokeState& stroke)
{
    double sum = 0.0;
    std::size_t count = 0;
    for (const auto& [key, turn] : stroke.cut_faces.all()) {
        double least = std::numeric_limits<double>::infinity();
        for (const TetId t : stroke.store.unsorted_star(key[0]))
            least = std::min(least, stroke.store.first_edge(t));
        if (std::isfinite(least)) {
            sum += least;
            ++count;
        }
    }
    return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

void check_extent(const StrokeState& stroke, std::span<const UncutElement> left, const StrokeSettings& settings,
    double from, double to, const std::function<void()>& poll)
{
    const SweptBlade& blade = stroke.blade;
    const double edge = wound_edge(stroke), most = largest_blade_deviation(settings);
    const std::vector<SweptBlade::Crease> bends = blade.creases(kLeastBend);
    if (!(edge > 0.0) || !(to > from))
        return;
    Look look(stroke);
    const auto local_edge_at = [&](const Vec3& p, bool on_border) {
        if (on_border || !bends.empty())
            return look.local_edge(p);
        const auto it = std::find_if(
            left.begin(), left.end(), [&](const UncutElement& element) { return is_inside(element.corners, p); });
        return it == left.end() ? 0.0 : it->local_edge;
    };
    const double spacing = edge * (bends.empty() ? kFlatSpacing : settings.chord > 0.0 ? kCloseSpacing : kBentSpacing);
    const std::vector<double> columns = places(from, to, spacing, bends);
    const int rows = samples(blade.depth(), spacing, !bends.empty());
    for (const double along : columns) {
        poll();
        for (int j = 0; j <= rows; ++j) {
            const double depth = blade.depth() * j / rows;
            const Vec3 p = blade.at(along, depth);
            const double unit = local_edge_at(p, along == from || along == to || j == rows), least = 0.1 * unit;
            if (unit == 0.0)
                continue;
            if (look.near_wound(p, most * unit))
                continue;
            const bool touched = (along == from && look.outside(along + least, depth, most * unit))
                || (along == to && look.outside(along - least, depth, most * unit))
                || (j == rows && look.outside(along, depth - least, most * unit));
            if (touched || look.near_surface(p, kSurface * unit))
                continue;
            std::ostringstream where;
            where << "at " << along << " mm along the line, " << depth << " mm deep";
            throw CutQualityError(
                CutQualityError::Kind::extent, quality_message("stay", most, "short of"), where.str());
        }
    }
}

} // namespace retractor::mesh
