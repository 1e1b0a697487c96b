#include "planner/palpation/palpable_sites.h"

#include "mesh/base/triangle.h"

#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <optional>

namespace retractor::planner {

namespace {

    Vec3 centroid(const TriMesh& surface, std::size_t t)
    {
        Vec3 sum = Vec3::Zero();
        for (const VertexId v : surface.triangles[t])
            sum += surface.vertices.row(v).transpose();
        return sum / 3.0;
    }

    Vec3 area_normal(const TriMesh& surface, std::size_t t)
    {
        return area_vector(surface.vertices, surface.triangles[t]);
    }

    /// Finds places to press on the surface that fingers see.
    class Sites {
    public:
        Sites(datasets::PalpationScene& scene, const TriMesh& surface)
            : scene_(scene)
            , surface_(surface)
        {
            std::vector<Vec3> fixed;
            for (const auto& triangle : surface.triangles)
                for (const VertexId v : triangle)
                    if (scene.body.roles[static_cast<std::size_t>(v)] == datasets::VertexRole::fixed)
                        fixed.emplace_back(surface.vertices.row(v).transpose());
            for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
                double nearest = std::numeric_limits<double>::infinity();
                for (const Vec3& point : fixed)
                    nearest = std::min(nearest, (point - centroid(surface, t)).squaredNorm());
                from_fixed_.push_back(std::sqrt(nearest));
            }
        }

        /// Adds the place farthest towards `direction`. The surface there faces this direction, and a fingertip has
        /// room beside the supports.
        void add_towards(const std::string& name, const Vec3& direction)
        {
            constexpr double kLooks = 0.85; // cosine of the angle between the normal and the direction
            for (const double room : { 15.0, 8.0, 4.0 }) { // mm
                std::optional<std::size_t> best;
                for (std::size_t t = 0; t < surface_.triangles.size(); ++t)
                    if (from_fixed_[t] >= room && area_normal(surface_, t).normalized().dot(direction) > kLooks
                        && (!best || centroid(surface_, t).dot(direction) > centroid(surface_, *best).dot(direction)))
                        best = t;
                if (best)
                    return add(name, *best);
            }
        }

        void add_nearest(const std::string& name, const Vec3& point)
        {
            std::size_t best = 0;
            for (std::size_t t = 1; t < surface_.triangles.size(); ++t)
                if ((centroid(surface_, t) - point).squaredNorm() < (centroid(surface_, best) - point).squaredNorm())
                    best = t;
            add(name, best);
        }

    private:
        void add(const std::string& name, std::size_t t)
        {
            const Vec3 at = centroid(surface_, t), outward = area_normal(surface_, t).normalized();
            scene_.sites.push_back({ name, at, outward });
            // Adds the place of a second finger or thumb: within the span of a hand, where it would push in about the
            // opposite direction.
            constexpr double kSpan = 60.0, kAgainst = 0.5;
            std::optional<std::size_t> opposite;
            double aside = std::numeric_limits<double>::infinity();
            for (std::size_t o = 0; o < surface_.triangles.size(); ++o) {
                const Vec3 way = centroid(surface_, o) - at;
                const double through = -way.dot(outward);
                if (through <= 0.0 || through > kSpan || from_fixed_[o] <= 0.0
                    || area_normal(surface_, o).normalized().dot(outward) > -kAgainst)
                    continue;
                const double off = (way + through * outward).norm();
                const double cost = off + 0.1 * through; // prefers the near wall of the structure to tissue beyond
                if (off < 0.5 * through && cost < aside) {
                    aside = cost;
                    opposite = o;
                }
            }
            if (opposite)
                scene_.sites.push_back({ name + "-opposite", centroid(surface_, *opposite),
                    area_normal(surface_, *opposite).normalized() });
        }

        datasets::PalpationScene& scene_;
        const TriMesh& surface_;
        std::vector<double> from_fixed_;
    };

} // namespace

void add_sites(datasets::PalpationScene& scene, const TriMesh& surface, const mesh::LabelVolume& labels,
    const PalpableRequest& request)
{
    Sites sites(scene, surface);
    sites.add_towards("front", -Vec3::UnitY());
    sites.add_towards("left", Vec3::UnitX());
    sites.add_towards("right", -Vec3::UnitX());
    for (std::size_t p = 0; p < request.stiff.size(); ++p) {
        const TargetSpec& where = request.stiff[p].where;
        Vec3 middle = where.centre;
        if (!where.is_sphere()) {
            std::size_t count = 0;
            middle.setZero();
            const Label id = mesh::find_label(labels.table, where.label)->id;
            for (int k = 0; k < labels.grid.size[2]; ++k)
                for (int j = 0; j < labels.grid.size[1]; ++j)
                    for (int i = 0; i < labels.grid.size[0]; ++i)
                        if (labels.voxels[labels.grid.offset(i, j, k)] == id) {
                            middle += labels.grid.world(Vec3(i, j, k));
                            ++count;
                        }
            middle /= static_cast<double>(count); // elements lie there, so the label has voxels
        }
        sites.add_nearest("stiff-" + std::to_string(p + 1), middle);
    }
    for (const auto& [name, point] : request.sites)
        sites.add_nearest(name, point);
}

} // namespace retractor::planner
