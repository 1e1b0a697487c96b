#include "ui/plan_scene/field_map.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/base/triangle.h"
#include "mesh/surface/proximity.h"
#include "mesh/surface/wound_surface.h"
#include "planner/approach/approach_draft.h"
#include "planner/measures/ball_strain.h"
#include "planner/measures/comparison.h"
#include "planner/measures/risk_distances.h"
#include "planner/plan/wound_view.h"
#include "ui/plan_scene/plan_scene.h"
#include "ui/scene/color_scale.h"
#include "ui/scene/tissue_colors.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr double kFarRiskMm = 30.0;
    constexpr double kEyeBallMm = 7.0; ///< radius of the ball of an eye
    constexpr double kEyesFromSideDeg = 55.0; ///< the eyes are where the camera of the overview looks along
    constexpr double kFarthestSampleMm = 25.0; ///< farthest sample that colours a part of the target

    const ColorClasses& strain_classes()
    {
        // Percent. Torn samples of skin failed between kSkinTearsFrom and kSkinTearsTo.
        static const ColorClasses classes { .limits
            = { 5, 10, 20, 100 * planner::kSkinTearsFrom, 100 * planner::kSkinTearsTo } };
        return classes;
    }
    const ColorClasses& pressure_classes()
    {
        // kPa. Blades on bone press with some 100 kPa on average, and with several times as much at an end.
        static const ColorClasses classes { .limits = { 50, 100, 200, 400, 800 } };
        return classes;
    }
    const ColorClasses& risk_classes()
    {
        static const ColorClasses classes { .limits = { 2, 5, 10, 20, kFarRiskMm }, .low_is_bright = true }; // mm
        return classes;
    }
    const ColorClasses& share_classes()
    {
        static const ColorClasses classes { .limits = { 1, 20, 40, 60, 80 } }; // percent
        return classes;
    }

    /// Labels for the classes of a map beside the labels of tissues.
    struct MapLabels {
        const ColorClasses& classes;
        std::map<Label, Look> looks; ///< of the tissues, and of the classes
        Label first = 0; ///< label of the lowest class

        explicit MapLabels(const ColorClasses& of, std::map<Label, Look> tissues = {})
            : classes(of)
            , looks(std::move(tissues))
        {
            first = looks.empty() ? Label {} : static_cast<Label>(looks.rbegin()->first + 1);
            for (std::size_t index = 0; index < classes.count(); ++index)
                looks[label(index)] = { .color = classes.color(index) };
        }
        Label label(std::size_t index) const { return static_cast<Label>(first + index); }
        Label of(double number) const { return label(classes.of(number)); }
    };

    Vec3 middle_of(const TriMesh& mesh, std::size_t triangle)
    {
        const auto corners = triangle_corners(mesh.vertices, mesh.triangles[triangle]);
        return (corners[0] + corners[1] + corners[2]) / 3.0;
    }

    /// The elongation at each vertex of the wall, in percent: mean of the elements round it, by volume.
    std::vector<double> elongations(const planner::PlannedField& field)
    {
        const auto vertices = static_cast<std::size_t>(field.wall.vertices.rows());
        std::vector<double> sum(vertices), weight(vertices);
        for (std::size_t t = 0; t < field.wall.tet_count(); ++t) {
            const auto tet = field.wall.tet(static_cast<TetId>(t));
            const auto corner = [&](std::size_t n) { return Vec3(field.wall.vertices.row(tet[n]).transpose()); };
            const double volume
                = std::abs((corner(1) - corner(0)).dot((corner(2) - corner(0)).cross(corner(3) - corner(0))));
            // Green's strain E of a stretch s is (s^2 - 1) / 2.
            const double stretch = std::sqrt(std::max(0.0, 1.0 + 2.0 * field.opening.strain[t]));
            for (const VertexId v : tet) {
                sum[static_cast<std::size_t>(v)] += volume * 100.0 * (stretch - 1.0);
                weight[static_cast<std::size_t>(v)] += volume;
            }
        }
        for (std::size_t v = 0; v < vertices; ++v)
            sum[v] /= weight[v] > 0.0 ? weight[v] : 1.0;
        return sum;
    }

    /// @param plain class that keeps the colours of tissues, and has no line
    void add_legend(SceneMap& map, const ColorClasses& classes, const std::string& unit,
        std::optional<std::size_t> plain, int digits = 0)
    {
        const std::vector<LegendLine> lines = classes.legend(unit, digits); // the highest class first
        for (std::size_t n = 0; n < lines.size(); ++n)
            if (plain != lines.size() - 1 - n)
                map.legend.push_back(lines[n]);
    }

    std::optional<SceneMap> strain_map(planner::Patient& patient, const planner::PlannedField& field)
    {
        if (field.opening.strain.size() != field.wall.tet_count())
            return std::nullopt;
        auto wall = std::make_shared<TriMesh>(drawn_wall(patient, field, field.opening.displacement));
        const std::vector<double> at = elongations(field);
        const std::vector<VertexId> vertex_of = mesh::boundary_surface(field.wall, {}).vertex_of;
        const MapLabels labels(strain_classes(), tissue_looks(patient.planned_case().label_table));
        for (std::size_t t = 0; t < wall->triangles.size(); ++t) {
            double mean = 0.0;
            for (const VertexId v : wall->triangles[t])
                mean += at[static_cast<std::size_t>(vertex_of[static_cast<std::size_t>(v)])] / 3.0;
            if (strain_classes().of(mean) > 0) // little strained tissue keeps its colours
                wall->labels[t] = labels.of(mean);
        }
        SceneMap map { .surfaces = { { .name = std::string(kWallName), .mesh = wall, .look_of_label = labels.looks } },
            .legend = { { "largest elongation", "" } } };
        add_legend(map, strain_classes(), "%", 0U);
        map.legend.push_back({ "samples of skin tore",
            formatted("%.0f to %.0f %%", 100.0 * planner::kSkinTearsFrom, 100.0 * planner::kSkinTearsTo) });
        map.legend.push_back({ "colours: single places; the verdict takes means over balls", "" });
        return map;
    }

    /// The part of a blade against the lip in thirds from the start of the incision to its end; 3: the rest of it.
    std::shared_ptr<const TriMesh> thirds_of(const planner::HookShape& hook, const Vec3& along)
    {
        auto mesh = std::make_shared<TriMesh>(planner::hook_mesh(hook));
        const Vec3 outward = hook.outward.normalized();
        const Vec3 across = (along - along.dot(outward) * outward).normalized();
        mesh->labels.assign(mesh->triangles.size(), 3);
        for (std::size_t t = 0; t < mesh->triangles.size(); ++t) {
            const Vec3 from_middle = middle_of(*mesh, t) - hook.position;
            if (from_middle.dot(outward) > hook.height_mm)
                continue;
            const double share = from_middle.dot(across) / hook.width_mm + 0.5;
            mesh->labels[t] = static_cast<Label>(std::clamp(static_cast<int>(3.0 * share), 0, 2));
        }
        return mesh;
    }

    std::optional<SceneMap> pressure_map(const planner::PlannedField& field)
    {
        if (!field.metrics.retractor)
            return std::nullopt;
        SceneMap map { .legend = { { "pressure of the blades on the lips", "" } } };
        add_legend(map, pressure_classes(), "kPa", std::nullopt);
        for (const planner::HookShape& hook : planner::placed_hooks(field, field.opening.displacement, field.geometry))
            for (const planner::BladeMetrics& blade : field.metrics.retractor->blades) {
                if (blade.name != hook.name || !blade.pressure || blade.pressure->touching_mm2 <= 0.0)
                    continue;
                const planner::BladePressure& pressure = *blade.pressure;
                SurfaceItem steel { .name = hook.name, .mesh = thirds_of(hook, field.geometry.along) };
                for (std::size_t third = 0; third < 3; ++third) {
                    constexpr double kKiloPascal = 1e3; // N/mm2
                    const double mean = kKiloPascal * pressure.thirds_N[third] / (pressure.touching_mm2 / 3.0);
                    steel.look_of_label[static_cast<Label>(third)]
                        = { .color = pressure_classes().color(pressure_classes().of(mean)), .finish = Finish::unlit };
                }
                steel.look_of_label[3] = steel_look();
                map.surfaces.push_back(std::move(steel));
                map.legend.push_back(
                    { readable(blade.name) + ", largest", in_words(pressure.largest_kPa, 0) + " kPa" });
            }
        map.legend.push_back({ "colours: force of a third over a third of what touches", "" });
        return map.surfaces.empty() ? std::nullopt : std::optional(std::move(map));
    }

    /// The surfaces of all structures at risk as one.
    TriMesh structures_at_risk(planner::Patient& patient)
    {
        TriMesh all;
        for (const mesh::LabelInfo& info : patient.planned_case().label_table) {
            if (info.role != mesh::Role::at_risk || !patient.has_voxels(info.name))
                continue;
            const auto organ = patient.organ(info.name);
            const auto first = static_cast<VertexId>(all.vertices.rows());
            all.vertices.conservativeResize(first + organ->vertices.rows(), 3);
            all.vertices.bottomRows(organ->vertices.rows()) = organ->vertices;
            for (const auto& [a, b, c] : organ->triangles)
                all.triangles.push_back({ a + first, b + first, c + first });
        }
        return all;
    }

    std::optional<SceneMap> risk_map(planner::Patient& patient, const planner::PlannedField& field)
    {
        const TriMesh risks = structures_at_risk(patient);
        if (risks.triangles.empty())
            return std::nullopt;
        const mesh::TriangleProximity near(risks.vertices, risks.triangles, kFarRiskMm);
        constexpr Label kSteel = 0;
        const MapLabels on_wall(risk_classes(), tissue_looks(patient.planned_case().label_table)),
            on_steel(risk_classes(), { { kSteel, steel_look() } });
        SceneMap map { .legend = { { "nearest structure at risk", "" } } };
        const auto add = [&](const std::string& name, TriMesh surface, const MapLabels& labels) {
            for (std::size_t t = 0; t < surface.triangles.size(); ++t) // what is far keeps its colours
                if (const auto found = near.within(middle_of(surface, t), kFarRiskMm); !found.empty())
                    surface.labels[t] = labels.of(std::min(found.front().point.distance, 0.999 * kFarRiskMm));
            map.surfaces.push_back({ .name = name,
                .mesh = std::make_shared<const TriMesh>(std::move(surface)),
                .look_of_label = labels.looks });
        };
        add(std::string(kWallName), drawn_wall(patient, field, field.opening.displacement), on_wall);
        for (const planner::HookShape& hook :
            planner::placed_hooks(field, field.opening.displacement, field.geometry)) {
            TriMesh steel = planner::hook_mesh(hook);
            steel.labels.assign(steel.triangles.size(), kSteel);
            add(hook.name, std::move(steel), on_steel);
        }
        add_legend(map, risk_classes(), "mm", risk_classes().count() - 1);
        const auto add_nearest = [&](const char* what, const std::vector<planner::RiskDistance>& distances) {
            map.legend.push_back(distances.empty()
                    ? LegendLine { what, "none within " + in_words(planner::kFarthestRiskMm, 0) + " mm" }
                    : LegendLine { what,
                        planner::risk_name(distances.front()) + " " + in_words(distances.front().distance_mm, 0)
                            + " mm" });
        };
        add_nearest("nearest to the steel", field.metrics.steel_at_risk);
        add_nearest("nearest to the cut, at rest", field.metrics.at_risk);
        map.legend.push_back({ "organs where the CT shows them", "" });
        return map;
    }

    constexpr Label kNotMeasured = 0; ///< of parts of the target that no sample is near

    /// The target, each triangle with the label of the nearest sample.
    TriMesh labelled_target(planner::Patient& patient, const planner::PlannedField& field,
        const std::function<Label(std::size_t sample)>& label_of)
    {
        TriMesh target = *patient.target(field.approach.target);
        target.labels.assign(target.triangles.size(), kNotMeasured);
        const std::vector<planner::SurfaceSample>& samples = field.exposure.sample_points;
        for (std::size_t t = 0; t < target.triangles.size(); ++t) {
            const Vec3 at = middle_of(target, t);
            double nearest = kFarthestSampleMm * kFarthestSampleMm;
            for (std::size_t s = 0; s < samples.size(); ++s)
                if (const double squared = (samples[s].position - at).squaredNorm(); squared < nearest) {
                    nearest = squared;
                    target.labels[t] = label_of(s);
                }
        }
        return target;
    }

    std::optional<SceneMap> sight_map(planner::Patient& patient, const planner::PlannedField& field)
    {
        const planner::Exposure& exposure = field.exposure;
        if (exposure.sample_points.empty() || exposure.sample_seen.size() != exposure.sample_points.size())
            return std::nullopt;
        const MapLabels labels(share_classes(), { { kNotMeasured, { .color = target_color() } } });
        const auto target = std::make_shared<const TriMesh>(labelled_target(
            patient, field, [&](std::size_t sample) { return labels.of(100.0 * exposure.sample_seen[sample]); }));
        SceneMap map { .on_target = true, .legend = { { "eyes that see the place", "" } } };
        map.surfaces.push_back({ .name = "target", .mesh = target, .look_of_label = labels.looks });
        add_legend(map, share_classes(), "%", std::nullopt);
        map.legend.push_back({ "eyes of the cone", std::to_string(exposure.eyes.size()) });
        return map;
    }

    /// Colours that colour-blind people tell apart, the brightest for what both reach.
    std::optional<SceneMap> reach_map(planner::Patient& patient, const planner::PlannedField& field)
    {
        const std::size_t count = field.exposure.sample_points.size();
        if (count == 0)
            return std::nullopt;
        constexpr Label kNeither = 1, kFinger = 2, kInstruments = 4; // the labels of a sample's reach are added
        std::vector<Label> reach(count, kNeither);
        const auto add = [&](const std::vector<std::uint32_t>& samples, Label by) {
            for (const std::uint32_t sample : samples)
                if (sample < count)
                    reach[sample] = static_cast<Label>(reach[sample] + by);
        };
        add(field.best_eye.finger_touches, kFinger);
        add(field.best_eye.two_instruments_reach, kInstruments);
        const std::map<Label, Look> looks { { kNotMeasured, { .color = target_color() } },
            { kNeither, { .color = { 0.27, 0.00, 0.33 } } }, { kNeither + kFinger, { .color = { 0.13, 0.57, 0.55 } } },
            { kNeither + kInstruments, { .color = { 0.93, 0.53, 0.18 } } },
            { kNeither + kFinger + kInstruments, { .color = { 0.99, 0.91, 0.14 } } } };
        SceneMap map { .on_target = true, .legend = { { "reach through the wound", "" } } };
        map.surfaces.push_back({ .name = "target",
            .mesh = std::make_shared<const TriMesh>(
                labelled_target(patient, field, [&](std::size_t sample) { return reach[sample]; })),
            .look_of_label = looks });
        const auto line = [&](const char* words, Label label) {
            map.legend.push_back({ words, " ", looks.at(label).color });
        };
        line("finger and two instruments", kNeither + kFinger + kInstruments);
        line("two instruments", kNeither + kInstruments);
        line("a finger", kNeither + kFinger);
        line("neither", kNeither);
        map.legend.push_back({ "instruments: where the best eye sees the place", "" });
        return map;
    }

    void add_ball(TriMesh& mesh, const Vec3& middle, double radius, Label label)
    {
        constexpr int kAround = 12, kRings = 7; // rings between the poles
        const auto first = static_cast<VertexId>(mesh.vertices.rows());
        mesh.vertices.conservativeResize(first + kAround * kRings + 2, 3);
        for (int ring = 0; ring < kRings; ++ring)
            for (int n = 0; n < kAround; ++n) {
                const double polar = std::numbers::pi * (ring + 1) / (kRings + 1),
                             angle = 2.0 * std::numbers::pi * n / kAround;
                mesh.vertices.row(first + ring * kAround + n) = (middle
                    + radius
                        * Vec3(std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), std::cos(polar)))
                                                                    .transpose();
            }
        const VertexId top = first + kAround * kRings, bottom = top + 1;
        mesh.vertices.row(top) = (middle + radius * Vec3::UnitZ()).transpose();
        mesh.vertices.row(bottom) = (middle - radius * Vec3::UnitZ()).transpose();
        for (int n = 0; n < kAround; ++n) {
            const int next = (n + 1) % kAround, last = (kRings - 1) * kAround;
            mesh.triangles.push_back({ top, first + n, first + next });
            mesh.triangles.push_back({ bottom, first + last + next, first + last + n });
            for (int ring = 0; ring + 1 < kRings; ++ring) {
                const VertexId a = first + ring * kAround + n, b = first + ring * kAround + next;
                mesh.triangles.push_back({ a, a + kAround, b });
                mesh.triangles.push_back({ b, a + kAround, b + kAround });
            }
        }
        mesh.labels.resize(mesh.triangles.size(), label);
    }

    std::optional<SceneMap> eye_map(const planner::PlannedField& field)
    {
        const planner::Exposure& exposure = field.exposure;
        if (exposure.eyes.empty())
            return std::nullopt;
        double most = 0.0;
        for (const planner::EyeView& eye : exposure.eyes)
            most = std::max(most, 100.0 * eye.visible_fraction);
        // Shares of the whole target are small: one eye sees half of a closed body at most.
        const double step = std::max(0.5, std::ceil(2.0 * most / 5.0) / 2.0);
        const ColorClasses classes { .limits = { step, 2 * step, 3 * step, 4 * step } };
        constexpr Label kBest = 0;
        const Look best { .color = { 1.0, 1.0, 1.0 } };
        const MapLabels labels(classes, { { kBest, best } });
        auto balls = std::make_shared<TriMesh>();
        for (const planner::EyeView& eye : exposure.eyes)
            add_ball(*balls, eye.eye, kEyeBallMm, labels.of(100.0 * eye.visible_fraction));
        add_ball(*balls, field.best_eye.eye, 1.5 * kEyeBallMm, kBest);
        SceneMap map { .surfaces = { { .name = "eyes", .mesh = balls, .look_of_label = labels.looks } },
            .legend = { { "share of the target's area seen from there", "" } },
            .from_side_deg = kEyesFromSideDeg };
        add_legend(map, classes, "%", std::nullopt, step == std::floor(step) ? 0 : 1);
        map.legend.push_back({ formatted("the best place of the eye: %.0f %% of what could be seen",
                                   100.0 * field.metrics.seen_best_eye),
            " ", best.color });
        map.legend.push_back(
            { "the other places: distance from the target", in_words(exposure.cone.eye_distance_mm, 0) + " mm" });
        return map;
    }

} // namespace

FieldMapKind field_map_from_string(std::string_view text)
{
    std::string names;
    for (const FieldMapName& map : kFieldMaps) {
        if (text == map.name)
            return map.kind;
        names += (names.empty() ? "" : ", ") + std::string(map.name);
    }
    throw InputError("there is no map \"" + std::string(text) + "\"; there are " + names);
}

std::optional<SceneMap> field_map(planner::Patient& patient, const planner::PlannedField& field, FieldMapKind kind)
{
    RETRACTOR_ASSERT(planner::is_measured(field));
    if (!planner::is_solved(field.metrics))
        return std::nullopt;
    switch (kind) {
    case FieldMapKind::strain:
        return strain_map(patient, field);
    case FieldMapKind::pressure:
        return pressure_map(field);
    case FieldMapKind::risk:
        return risk_map(patient, field);
    case FieldMapKind::sight:
        return sight_map(patient, field);
    case FieldMapKind::reach:
        return reach_map(patient, field);
    case FieldMapKind::eyes:
        break;
    }
    return eye_map(field);
}

Picture map_picture(planner::Patient& patient, const planner::PlannedField& field, const SceneMap& map,
    const std::string& title, int width, int height)
{
    Picture picture { .width = width, .height = height, .viewports = {} };
    Scene outside = overview_scene(patient, field);
    outside.legend = estimated_lines(std::move(outside.legend)); // the numbers have pictures of their own
    outside = with_map(std::move(outside), map);
    constexpr double kLegendShare = 0.8; // of the narrower view
    outside.legend_share = kLegendShare;
    outside.title = map.from_side_deg != 0.0 ? planner::spoken_name(field.approach) + ": " + title : title;
    if (map.from_side_deg != 0.0) {
        picture.viewports.push_back({ .scene = std::move(outside) });
        return picture;
    }
    Scene seen = with_map(surgeon_scene(patient, field), map);
    seen.legend.clear(); // once is enough
    seen.title = planner::spoken_name(field.approach) + ", through the incision";
    constexpr double kSeenShare = 0.55;
    picture.viewports.push_back({ .right = kSeenShare, .scene = std::move(seen) });
    picture.viewports.push_back({ .left = kSeenShare, .scene = std::move(outside) });
    return picture;
}

} // namespace retractor::ui
