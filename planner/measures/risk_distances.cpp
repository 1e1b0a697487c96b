#include "planner/measures/risk_distances.h"

#include "mesh/base/assert.h"
#include "mesh/surface/proximity.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace retractor::planner {

namespace {

    /// The labels that the blade passes through, sampled at half the smallest voxel.
    std::set<Label> labels_on_blade(const mesh::SweptBlade& blade, const mesh::LabelVolume& labels)
    {
        const double step = 0.5 * labels.grid.spacing.minCoeff();
        const auto along_steps = static_cast<int>(std::ceil(blade.length() / step));
        const auto depth_steps = static_cast<int>(std::ceil(blade.depth() / step));
        std::set<Label> met;
        for (int i = 0; i <= along_steps; ++i)
            for (int j = 0; j <= depth_steps; ++j)
                met.insert(mesh::label_at(
                    labels, blade.at(blade.length() * i / along_steps, blade.depth() * j / depth_steps)));
        return met;
    }

    /// The vertex nearest to the blade; nothing beyond kFarthestRiskMm.
    std::optional<RiskDistance> nearest_vertex(const TriMesh& surface, const mesh::TriangleProximity& blade)
    {
        std::optional<RiskDistance> nearest;
        for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v) {
            const Vec3 point = surface.vertices.row(v).transpose();
            const auto found = blade.within(point, nearest ? nearest->distance_mm : kFarthestRiskMm);
            if (!found.empty())
                nearest = { .name = {}, .distance_mm = found.front().point.distance, .at = point, .from = {} };
        }
        return nearest;
    }

} // namespace

std::vector<RiskDistance> risk_distances(const mesh::Blade& blade, const mesh::LabelVolume& labels,
    const std::function<std::shared_ptr<const TriMesh>(std::string_view)>& surface_of)
{
    const mesh::SweptBlade swept(blade);
    const mesh::TriangleProximity proximity(swept.surface().vertices, swept.surface().triangles, kFarthestRiskMm);
    const std::set<Label> met = labels_on_blade(swept, labels);
    std::vector<RiskDistance> distances;
    for (const mesh::LabelInfo& info : labels.table) {
        if (info.role != mesh::Role::at_risk)
            continue;
        const std::shared_ptr<const TriMesh> surface = surface_of(info.name);
        RETRACTOR_ASSERT(surface != nullptr);
        std::optional<RiskDistance> nearest = nearest_vertex(*surface, proximity);
        if (!nearest)
            continue;
        nearest->name = info.name;
        if (met.contains(info.id))
            nearest->distance_mm = 0.0;
        distances.push_back(*std::move(nearest));
    }
    std::stable_sort(distances.begin(), distances.end(),
        [](const RiskDistance& a, const RiskDistance& b) { return a.distance_mm < b.distance_mm; });
    return distances;
}

std::vector<RiskDistance> risk_distances(const TriMesh& instrument, const std::string& name,
    const mesh::LabelTable& table, const std::function<std::shared_ptr<const TriMesh>(std::string_view)>& surface_of)
{
    const mesh::TriangleProximity proximity(instrument.vertices, instrument.triangles, kFarthestRiskMm);
    std::vector<RiskDistance> distances;
    for (const mesh::LabelInfo& info : table) {
        if (info.role != mesh::Role::at_risk)
            continue;
        if (std::optional<RiskDistance> nearest = nearest_vertex(*surface_of(info.name), proximity)) {
            nearest->name = info.name;
            nearest->from = name;
            distances.push_back(*std::move(nearest));
        }
    }
    return nearest_risks(std::move(distances));
}

std::vector<RiskDistance> nearest_risks(std::vector<RiskDistance> of_all_blades)
{
    std::stable_sort(of_all_blades.begin(), of_all_blades.end(),
        [](const RiskDistance& a, const RiskDistance& b) { return a.distance_mm < b.distance_mm; });
    std::set<std::string> named;
    std::erase_if(of_all_blades, [&](const RiskDistance& risk) { return !named.insert(risk.name).second; });
    return of_all_blades;
}

} // namespace retractor::planner
