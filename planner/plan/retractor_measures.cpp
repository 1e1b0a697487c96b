#include "planner/plan/retractor_measures.h"

#include "mesh/base/assert.h"
#include "mesh/cutting/store/blade.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::planner {

namespace {

    constexpr double kDegrees = 180.0 / std::numbers::pi;
    constexpr double kMPerMm = 1e-3;

    /// Largest distance of a lip's edge from the straight line of its blade, in the direction in which the blade opens.
    /// @param blade index of the blade and of its hook
    double lip_deviation_mm(
        const PlannedField& field, const PlacedRetractor& retractor, const WoundEdges& edges, std::size_t blade)
    {
        const HookSpec& spec = field.approach.hooks[blade];
        const WoundEdge& edge = spec.side > 0 ? edges.left : edges.right;
        const Vec3 outward = retractor.state.rotation * retractor.frame[blade].outward;
        const Vec3 arm = field.hooks[blade].pivot + field.hooks[blade].displacement;
        double largest = 0.0;
        for (std::size_t i = 0; i < edge.vertices.size(); ++i) {
            if (std::abs(edge.along_mm[i] - spec.along_mm) > 0.5 * spec.patch_width_mm)
                continue;
            const VertexId v = edge.vertices[i];
            const Vec3 there = (field.wall.vertices.row(v) + field.opening.displacement.row(v)).transpose();
            largest = std::max(largest, std::abs((there - arm).dot(outward)));
        }
        return largest;
    }

} // namespace

std::optional<RetractorMetrics> retractor_metrics(const PlannedField& field)
{
    if (!field.retractor || !field.approach.retractor)
        return std::nullopt;
    const PlacedRetractor& retractor = *field.retractor;
    RETRACTOR_ASSERT(field.hooks.size() == retractor.loads.size());
    RetractorMetrics metrics { .kind = field.approach.retractor->kind,
        .asked_force_N = field.approach.retractor->force_N,
        .opening_mm = retractor.state.distance,
        .rack_force_N = retractor.rack_force_N,
        .residual_force_N = retractor.residual_force_N,
        .residual_moment_Nm = kMPerMm * retractor.residual_moment_Nmm,
        .tilt_deg = kDegrees * Eigen::AngleAxisd(retractor.state.rotation).angle() };
    const WoundEdges edges = wound_edges(field.wall, field.lips, mesh::SweptBlade(blade_of(field.approach)));
    constexpr double kAtStop = 1e-6; // rad
    for (std::size_t k = 0; k < retractor.loads.size(); ++k) {
        const double turn = retractor.state.turn[k];
        metrics.blades.push_back({ .name = field.hooks[k].name,
            .force_N = retractor.loads[k].force_N,
            .moment_Nm = kMPerMm * retractor.loads[k].moment_Nmm,
            .turn_deg = kDegrees * turn,
            .at_stop = std::abs(turn) >= retractor.frame[k].play - kAtStop,
            .lip_deviation_mm = lip_deviation_mm(field, retractor, edges, k) });
    }
    return metrics;
}

} // namespace retractor::planner
