#include "planner/measures/risk_distances.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/surface/proximity.h"
#include "planner/anatomy/assumed_vessels.h"

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

    /// @param met labels through which the blade goes
    std::vector<RiskDistance> distances_from(const TriMesh& blade, const std::set<Label>& met,
        const mesh::LabelTable& table,
        const std::function<std::shared_ptr<const TriMesh>(std::string_view)>& surface_of)
    {
        const mesh::TriangleProximity proximity(blade.vertices, blade.triangles, kFarthestRiskMm);
        std::vector<RiskDistance> distances;
        for (const mesh::LabelInfo& info : table) {
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

} // namespace

std::vector<RiskDistance> risk_distances(const mesh::Blade& blade, const mesh::LabelVolume& labels,
    const std::function<std::shared_ptr<const TriMesh>(std::string_view)>& surface_of)
{
    const mesh::SweptBlade swept(blade);
    return distances_from(swept.surface(), labels_on_blade(swept, labels), labels.table, surface_of);
}

TriMesh saw_surface(std::span<const Vec3> skin, std::span<const Vec3> inner)
{
    if (skin.size() < 2 || skin.size() != inner.size())
        throw InputError("a saw's way needs two places or more on the skin, and as many on the inner side of the wall");
    TriMesh way;
    way.vertices.resize(2 * static_cast<Eigen::Index>(skin.size()), 3);
    for (std::size_t n = 0; n < skin.size(); ++n) {
        const auto v = static_cast<VertexId>(2 * n);
        way.vertices.row(v) = skin[n].transpose();
        way.vertices.row(v + 1) = inner[n].transpose();
        if (n == 0)
            continue;
        way.triangles.push_back({ v - 2, v, v + 1 });
        way.triangles.push_back({ v - 2, v + 1, v - 1 });
    }
    return way;
}

std::vector<RiskDistance> saw_risk_distances(std::span<const Vec3> skin, std::span<const Vec3> inner,
    const mesh::LabelVolume& labels, const std::function<std::shared_ptr<const TriMesh>(std::string_view)>& surface_of)
{
    constexpr double kRoundOffMm = 1e-6;
    const double step = 0.5 * labels.grid.spacing.minCoeff(), margin = 0.5 * labels.grid.spacing.maxCoeff();
    const TriMesh way = saw_surface(skin, inner);
    std::set<Label> met;
    for (std::size_t n = 1; n < skin.size(); ++n) {
        // Between two places, without the last half voxel at the inner side, which may hold what lies against the bone.
        const double along_mm = std::max((skin[n] - skin[n - 1]).norm(), (inner[n] - inner[n - 1]).norm());
        const int along_steps = std::max(1, static_cast<int>(std::ceil(along_mm / step)));
        for (int i = 0; i <= along_steps; ++i) {
            const double t = static_cast<double>(i) / along_steps;
            const Vec3 top = (1.0 - t) * skin[n - 1] + t * skin[n], foot = (1.0 - t) * inner[n - 1] + t * inner[n];
            const double depth = (foot - top).norm() - margin - kRoundOffMm;
            for (double at = 0.0; at < depth; at += step)
                met.insert(mesh::label_at(labels, top + at * (foot - top).normalized()));
        }
    }
    return distances_from(way, met, labels.table, surface_of);
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

std::vector<RiskDistance> assumed_distances(
    const TriMesh& surface, std::span<const AssumedVessel> vessels, const std::string& name)
{
    constexpr double kLongestStepMm = 0.5;
    std::vector<RiskDistance> distances;
    if (vessels.empty())
        return distances;
    const mesh::TriangleProximity proximity(surface.vertices, surface.triangles, kFarthestRiskMm);
    for (const AssumedVessel& vessel : vessels) {
        std::optional<RiskDistance> nearest;
        // Half a step is less than the radius: what is cut has the distance 0.
        for (const Vec3& place : places_along(vessel, std::min(kLongestStepMm, vessel.radius_mm))) {
            const auto found = proximity.within(place, nearest ? nearest->distance_mm : kFarthestRiskMm);
            if (!found.empty())
                nearest = { .name = vessel.name,
                    .distance_mm = found.front().point.distance,
                    .at = place,
                    .from = name,
                    .is_assumed = true };
        }
        if (!nearest)
            continue;
        nearest->distance_mm = std::max(0.0, nearest->distance_mm - vessel.radius_mm);
        distances.push_back(*std::move(nearest));
    }
    return nearest_risks(std::move(distances));
}

std::string risk_name(const RiskDistance& risk)
{
    return readable(risk.name) + (risk.is_assumed ? std::string(kAssumedPlace) : "");
}

void keep_nearest_bundle(std::vector<RiskDistance>& nearest_first)
{
    bool is_first = true;
    std::erase_if(nearest_first, [&](const RiskDistance& risk) {
        if (!risk.is_assumed || !is_neurovascular_bundle(risk.name))
            return false;
        return !std::exchange(is_first, false) && risk.distance_mm > 0.0;
    });
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
