#include "ui/plan_scene/vessel_surfaces.h"

#include "mesh/base/statistics.h"
#include "mesh/base/triangle.h"
#include "mesh/cutting/store/blade.h"
#include "planner/anatomy/assumed_vessels.h"
#include "planner/approach/smooth_line.h"
#include "ui/scene/tissue_colors.h"
#include "ui/scene/vtk/tube.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr Color kVessel { 0.80, 0.08, 0.08 }, kNerve { 0.93, 0.78, 0.22 };
    constexpr double kStepMm = 2.0; ///< between places of a vessel that follow the tissue
    constexpr double kNearIncisionMm = 60.0;
    /// Tissue farther from a vessel than this does not carry it.
    constexpr double kCarriedMm = 12.0;

    Color color_of(const planner::AssumedVessel& vessel)
    {
        const bool has_nerve
            = planner::is_neurovascular_bundle(vessel.name) || vessel.name.find("nerve") != std::string::npos;
        return has_nerve ? kNerve : kVessel;
    }

    SurfaceItem item_of(const planner::AssumedVessel& vessel, const std::vector<Vec3>& line)
    {
        SurfaceItem item;
        item.name = vessel.name + std::string(planner::kAssumedPlace);
        item.mesh = std::make_shared<const TriMesh>(tube(line, vessel.radius_mm));
        item.look = tissue_look("vessel");
        item.look.color = color_of(vessel);
        return item;
    }

    bool is_near(const std::vector<Vec3>& places, const std::vector<Vec3>& incision)
    {
        return std::ranges::any_of(places, [&](const Vec3& p) {
            return std::ranges::any_of(incision, [&](const Vec3& q) { return (p - q).norm() < kNearIncisionMm; });
        });
    }

    /// The surfaces along which the approach cuts, at rest.
    std::vector<TriMesh> cuts_of(const planner::Approach& approach)
    {
        std::vector<TriMesh> cuts { mesh::SweptBlade(planner::blade_of(approach)).surface() };
        for (const planner::DivisionStroke& stroke : approach.division.strokes)
            cuts.push_back(mesh::SweptBlade(planner::blade_of(stroke)).surface());
        return cuts;
    }

    bool is_cut_between(const Vec3& from, const Vec3& to, const std::vector<TriMesh>& cuts)
    {
        const auto meets = [&](const TriMesh& cut) {
            return std::ranges::any_of(cut.triangles, [&](const auto& triangle) {
                const auto hit = line_hit(from, to - from, triangle_corners(cut.vertices, triangle));
                return hit && hit->distance >= 0.0 && hit->distance <= 1.0;
            });
        };
        return std::ranges::any_of(cuts, meets);
    }

    /// The pieces into which the cuts divide a vessel.
    std::vector<std::vector<Vec3>> pieces_of(const std::vector<Vec3>& places, const std::vector<TriMesh>& cuts)
    {
        std::vector<std::vector<Vec3>> pieces(1);
        for (std::size_t n = 0; n < places.size(); ++n) {
            if (n > 0 && is_cut_between(places[n - 1], places[n], cuts))
                pieces.emplace_back();
            pieces.back().push_back(places[n]);
        }
        return pieces;
    }

    /// How the tissue round a place moves: an element belongs to one lip.
    class TissueMotion {
    public:
        explicit TissueMotion(const planner::PlannedField& field)
            : field_(field)
            , centres_(Points::Zero(static_cast<Eigen::Index>(field.wall.tet_count()), 3))
        {
            for (std::size_t t = 0; t < field.wall.tet_count(); ++t)
                for (const VertexId v : field.wall.tet(static_cast<TetId>(t)))
                    centres_.row(static_cast<Eigen::Index>(t)) += 0.25 * field.wall.vertices.row(v);
        }
        /// Along a piece of a vessel. Where elements of the other lip lie nearer to a few places, the median leaves
        /// them out; the mean takes the steps from element to element away.
        std::vector<Vec3> along(const std::vector<Vec3>& piece) const
        {
            constexpr std::size_t kReach = 4; // places on both sides, 8 mm
            constexpr double kSigmaPlaces = 3.0;
            std::vector<Vec3> motion;
            for (const Vec3& place : piece)
                motion.push_back(at(place));
            std::vector<Vec3> middle(motion.size());
            for (std::size_t n = 0; n < motion.size(); ++n)
                for (Eigen::Index axis = 0; axis < 3; ++axis) {
                    std::vector<double> values;
                    for (std::size_t m = n - std::min(n, kReach); m < std::min(motion.size(), n + kReach + 1); ++m)
                        values.push_back(motion[m][axis]);
                    middle[n][axis] = upper_median(values);
                }
            return planner::smoothed(middle, kSigmaPlaces);
        }

    private:
        Vec3 at(const Vec3& place) const
        {
            Eigen::Index nearest = 0;
            const double squared = (centres_.rowwise() - place.transpose()).rowwise().squaredNorm().minCoeff(&nearest);
            if (!(squared < kCarriedMm * kCarriedMm))
                return Vec3::Zero();
            Vec3 motion = Vec3::Zero();
            for (const VertexId v : field_.wall.tet(static_cast<TetId>(nearest)))
                motion += 0.25 * field_.opening.displacement.row(v).transpose();
            return motion;
        }
        const planner::PlannedField& field_;
        Points centres_; ///< of the elements, at rest
    };

} // namespace

std::vector<SurfaceItem> vessel_surfaces(const planner::Case& planned_case)
{
    std::vector<SurfaceItem> items;
    for (const planner::AssumedVessel& vessel : planned_case.assumed_vessels)
        items.push_back(item_of(vessel, vessel.line));
    return items;
}

std::vector<SurfaceItem> vessel_surfaces(const planner::Case& planned_case, const planner::PlannedField& field)
{
    std::vector<SurfaceItem> items;
    const bool is_open = field.wall.tet_count() > 0 && field.opening.displacement.rows() == field.wall.vertices.rows();
    if (!is_open || planned_case.assumed_vessels.empty())
        return items;
    const std::vector<TriMesh> cuts = cuts_of(field.approach);
    const TissueMotion motion(field);
    for (const planner::AssumedVessel& vessel : planned_case.assumed_vessels) {
        const std::vector<Vec3> places = planner::places_along(vessel, kStepMm);
        if (!is_near(places, field.approach.incision))
            continue;
        for (std::vector<Vec3>& piece : pieces_of(places, cuts)) {
            if (piece.size() < 2)
                continue;
            const std::vector<Vec3> by = motion.along(piece);
            for (std::size_t n = 0; n < piece.size(); ++n)
                piece[n] += by[n];
            items.push_back(item_of(vessel, piece));
        }
    }
    return items;
}

std::vector<LineItem> vessel_lines(const planner::Case& planned_case)
{
    constexpr double kNearVesselMm = 2.5, kWidthPx = 8.0;
    std::vector<LineItem> lines;
    for (const planner::AssumedVessel& vessel : planned_case.assumed_vessels)
        lines.push_back({ .name = vessel.name + std::string(planner::kAssumedPlace),
            .points = vessel.line,
            .color = color_of(vessel),
            .width_px = kWidthPx,
            .on_top = true,
            .near_slice_mm = kNearVesselMm });
    return lines;
}

void remove_vessels(Scene& scene)
{
    std::erase_if(scene.surfaces, [](const SurfaceItem& item) { return item.name.ends_with(planner::kAssumedPlace); });
}

} // namespace retractor::ui
