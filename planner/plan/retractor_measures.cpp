#include "planner/plan/retractor_measures.h"

#include "mesh/base/assert.h"
#include "mesh/cutting/store/blade.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

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

    /// The edge of a blade to which a place is nearest, within a quarter of the blade's size.
    std::string edge_of(double along_share, double deep_share)
    {
        constexpr double kNearEdge = 0.5; // of the half size: the outer quarter on each side
        if (std::max(std::abs(along_share), std::abs(deep_share)) < kNearEdge)
            return "middle";
        if (std::abs(deep_share) > std::abs(along_share))
            return deep_share > 0.0 ? "deep" : "skin";
        return along_share > 0.0 ? "end" : "start";
    }

    std::optional<BladePressure> pressure_of(const PlannedField& field, std::size_t hook)
    {
        constexpr double kKiloPascals = 1e3; // in a megapascal
        const std::vector<fem::BladeSurface>& blades = field.problem.blades;
        for (std::size_t b = 0; b < blades.size() && b < field.opening.blades.size(); ++b) {
            const fem::BladeSurface& blade = blades[b];
            if (blade.name != field.hooks[hook].name)
                continue;
            const fem::BladeBearing& bearing = field.opening.blades[b];
            // The width of a blade may run against the incision, so that the tissue lies on its front.
            const PatchPlace place = patch_place(field.approach, field.approach.hooks[hook]);
            const Vec3 along
                = (field.problem.mesh.vertices.row(blade.nodes[1]) - field.problem.mesh.vertices.row(blade.nodes[0]))
                      .transpose();
            const double sign = along.dot(place.along) < 0.0 ? -1.0 : 1.0;
            std::array<double, 3> thirds = bearing.thirds_N;
            if (sign < 0.0)
                std::swap(thirds.front(), thirds.back());
            return BladePressure { .mean_kPa = kKiloPascals * bearing.pressure_mean_MPa,
                .largest_kPa = kKiloPascals * bearing.pressure_largest_MPa,
                .largest_at = edge_of(sign * bearing.largest_along_mm / blade.half_width_mm,
                    bearing.largest_deep_mm / blade.half_height_mm),
                .touching_mm2 = bearing.area_mm2,
                .on_bone_N = bearing.bone_force_N,
                .thirds_N = thirds,
                .penetration_mm = bearing.penetration_mm };
        }
        return std::nullopt;
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
        .residual_moment_Nm = retractor.direction_is_held ? 0.0 : kMPerMm * retractor.residual_moment_Nmm,
        .hand_moment_Nm
        = retractor.direction_is_held ? std::optional<double>(kMPerMm * retractor.residual_moment_Nmm) : std::nullopt,
        .tilt_deg = kDegrees * Eigen::AngleAxisd(retractor.state.rotation).angle(),
        .contact_was_lost = field.contact_was_lost };
    const WoundEdges edges = wound_edges(field.wall, field.lips, mesh::SweptBlade(blade_of(field.approach)));
    constexpr double kAtStop = 1e-6; // rad
    for (std::size_t k = 0; k < retractor.loads.size(); ++k) {
        const double turn = retractor.state.turn[k];
        metrics.blades.push_back({ .name = field.hooks[k].name,
            .force_N = retractor.loads[k].force_N,
            .moment_Nm = kMPerMm * retractor.loads[k].moment_Nmm,
            .turn_deg = kDegrees * turn,
            .at_stop = std::abs(turn) >= retractor.frame[k].play - kAtStop,
            .lip_deviation_mm = lip_deviation_mm(field, retractor, edges, k),
            .pressure = pressure_of(field, k) });
    }
    return metrics;
}

} // namespace retractor::planner
