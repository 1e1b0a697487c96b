#include "planner/plan/plan.h"
#include "planner/approach/divided_bones.h"
#include "planner/approach/hook_mesh.h"

#include "mesh/base/assert.h"
#include "mesh/base/corridor.h"
#include "mesh/base/error.h"
#include "mesh/base/memory.h"
#include "mesh/base/text_format.h"
#include "mesh/base/time_limit.h"
#include "mesh/generation/hybrid_model.h"
#include "mesh/image/skeleton.h"
#include "planner/approach/bearing_points.h"
#include "planner/approach/blade_fit.h"
#include "planner/approach/find_division.h"
#include "planner/approach/retractors.h"
#include "planner/case/plausible_input.h"
#include "planner/measures/force_moments.h"
#include "planner/measures/metrics.h"
#include "planner/measures/region_text.h"
#include "planner/measures/risk_distances.h"
#include "planner/measures/sight/table_position.h"
#include "planner/measures/tissue_values.h"
#include "planner/measures/verdict.h"
#include "planner/measures/volume_failures.h"
#include "planner/plan/accurate_plan.h"
#include "planner/plan/bone_loads.h"
#include "planner/plan/error_bars.h"
#include "planner/plan/explanation.h"
#include "planner/plan/found_region.h"
#include "planner/plan/gape.h"
#include "planner/plan/lip_measures.h"
#include "planner/plan/opened_wound.h"
#include "planner/plan/parameter_interval.h"
#include "planner/plan/plan_forecast.h"
#include "planner/plan/reduction_error.h"
#include "planner/plan/retractor_measures.h"
#include "planner/plan/tissue_measures.h"
#include "planner/plan/uninjured_opening.h"
#include "planner/plan/wound_view.h"
#include "planner/wall/bones_through_skin.h"
#include "planner/wall/parted_bones.h"
#include "planner/wall/rim_motion.h"
#include "planner/wall/slack_spaces.h"
#include "planner/wall/supports.h"
#include "planner/wall/unmeshed_wall.h"
#include "planner/wall/wall_pressure.h"
#include "planner/wall/wall_tension.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <exception>
#include <functional>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace retractor::planner {

namespace {

    /// A bone across a smaller share of the lines of sight is no obstacle.
    constexpr double kSmallestBoneShare = 0.01;

    /// Appends "stage: seconds" to the metrics at the end of the scope.
    class StageTimer {
    public:
        StageTimer(FieldMetrics& metrics, std::string stage)
            : metrics_(metrics)
            , stage_(std::move(stage))
        {
        }
        StageTimer(const StageTimer&) = delete;
        StageTimer& operator=(const StageTimer&) = delete;
        ~StageTimer() { metrics_.seconds.emplace_back(stage_, watch_.seconds()); }

    private:
        FieldMetrics& metrics_;
        std::string stage_;
        Stopwatch watch_;
    };

    /// Takes over the cut wall. @returns false, with status and message set, when the blade does not meet the wall
    bool take_cut(PlannedField& field, CutWall& cut)
    {
        if (cut.status != mesh::CutStatus::done) {
            field.status = cut.status == mesh::CutStatus::cancelled ? PlanStatus::cancelled : PlanStatus::cut_missed;
            field.message = cut.message;
            return false;
        }
        field.metrics.division = std::move(cut.divided);
        if (!field.metrics.division && !field.approach.division.words.empty()) { // asked for, and not possible
            field.metrics.division = DividedTissue { .length_mm = incision_length(field.approach),
                .words = field.approach.division.words };
            remark(field.message, field.approach.division.words);
        }
        remark(field.message, cut.message);
        field.wall = std::move(cut.wall);
        field.lips = std::move(cut.lips);
        field.hooks = std::move(cut.hooks);
        field.pieces = std::move(cut.pieces);
        field.metrics.removed = std::move(cut.removed);
        field.metrics.removed_skin_mm2 = cut.removed_skin_mm2;
        field.metrics.loose_pieces = std::move(cut.loose);
        return true;
    }

    /// The wall before the cut.
    struct UncutWall {
        mesh::TetMesh mesh;
        std::vector<VertexId> held; ///< fixed, or where the wall was cut off from the rest of the body
    };

    WallTension tension_of(const UncutWall& uncut, Patient& patient, const Approach& approach)
    {
        Vec3 inward = Vec3::Zero();
        for (const Vec3& direction : approach.directions)
            inward += direction;
        return wall_tension(uncut.mesh, materials_as_solved(patient), patient.planned_case().label_table, uncut.held,
            -inward.normalized());
    }

    /// Loads the wound with the tension that the cut released.
    void release_tension(PlannedField& field, CutWall& cut, const UncutWall& uncut, Patient& patient)
    {
        const WallTension tension = tension_of(uncut, patient, field.approach);
        ReleasedTension released = released_tension(field.wall, cut.origin, cut.wound, tension);
        if (tension.without_skin)
            remark(field.message,
                "no label has the material \"skin\": tissue under tension without its own normal is assumed to lie in "
                "the plane across the blade");
        if (released.without_direction > 0)
            remark(field.message,
                "at " + std::to_string(released.without_direction)
                    + " faces of the wound the direction of the pre-strain points through the tissue: the mean "
                      "pre-stress acts in both directions of the tissue's plane there");
        cut.released = std::move(released.tractions);
    }

    /// Refuses a wound without an edge on the skin before it is opened, because it cannot be measured.
    void check_lips(const PlannedField& field, const std::array<std::string, 2>& took_lip)
    {
        for (const std::size_t side : { 0U, 1U })
            if (!took_lip[side].empty() || !field.metrics.removed.empty())
                try {
                    static_cast<void>(wound_edges(field.wall, field.lips, mesh::SweptBlade(blade_of(field.approach))));
                } catch (const InputError& error) {
                    if (error.where() != (side == 0 ? "left lip" : "right lip"))
                        continue;
                    throw InputError(std::string(error.what())
                            + (took_lip[side].empty()
                                    ? "; an ablation may have removed this lip (" + removed_text(field.metrics.removed)
                                        + "): ablate less there, or choose another incision"
                                    : ": this lip was part of a removed loose piece (" + took_lip[side]
                                        + "); keep loose pieces held or rigid (\"loose_pieces\" of the approach), or "
                                          "choose another incision"),
                        error.where());
                }
    }

    std::string status_text(const PlannedField& field)
    {
        switch (field.opening.status) {
        case fem::OpeningStatus::converged:
            return "converged";
        case fem::OpeningStatus::inverted:
            return is_usable(field.opening) ? "converged" : "inverted, though " + field.opening.message;
        case fem::OpeningStatus::not_converged:
        case fem::OpeningStatus::cancelled:
            break;
        }
        return field.opening.message; // begins with the event
    }

    /// The middle, at rest, of the element whose strain is strain_p99; nothing when no element is strained.
    std::optional<Vec3> place_of_strain(const PlannedField& field)
    {
        const auto& strain = field.opening.strain;
        const auto at = std::find(strain.begin(), strain.end(), field.opening.strain_p99);
        if (at == strain.end() || !(field.opening.strain_p99 > 0.0))
            return std::nullopt;
        Vec3 middle = Vec3::Zero();
        for (const VertexId v : field.wall.tet(static_cast<TetId>(at - strain.begin())).first(4))
            middle += 0.25 * field.wall.vertices.row(v).transpose();
        return middle;
    }

    std::vector<SightBlocker> sight_blockers(const std::vector<SightShare>& shares, const mesh::LabelTable& table)
    {
        std::vector<SightBlocker> blockers;
        for (const SightShare& blocker : shares) {
            const mesh::LabelInfo* info = mesh::find_label(table, blocker.name);
            // Of cartilages those of the wall: the trachea's is no obstacle like bone.
            blockers.push_back({ blocker.name, blocker.share,
                info != nullptr && mesh::is_skeleton(*info) && (info->material == "bone" || mesh::is_wall(*info)) });
        }
        return blockers;
    }

    void fill_best_eye(
        FieldMetrics& m, const PlannedField& field, const AnatomicalFrame& frame, const mesh::LabelTable& table)
    {
        constexpr double kDegrees = 180.0 / std::numbers::pi;
        const SurgeonEye& best = field.best_eye;
        m.seen_best_eye = best.seen_fraction;
        m.seen_two_eyes = best.two_eyes_fraction;
        m.reached_by_two_instruments = best.two_instruments_fraction;
        m.reached_by_finger = best.finger_fraction;
        m.finger_lacks_mm = best.finger_lacks_mm;
        m.surgical_freedom_mm2 = best.freedom_mm2;
        m.best_eye_picture = best.picture_share;
        m.best_eye = { .at = best.eye,
            .aim = best.aim,
            .distance_mm = (best.eye - field.geometry.centre).norm(),
            .incidence_deg = best.incidence_deg,
            .bound_area_mm2 = best.bound_area_mm2,
            .hidden_by = sight_blockers(best.hidden_by, table) };
        const Vec3 access = field.geometry.centre - best.aim;
        const double left = access.dot(frame.left), ahead = access.dot(frame.anterior);
        m.access_horizontal_deg = kDegrees * std::atan2(left, ahead);
        m.access_vertical_deg = kDegrees * std::atan2(access.dot(frame.superior), std::hypot(left, ahead));
        const double cosine = (best.eye - best.aim).normalized().dot(field.geometry.normal);
        m.coaxiality_deg = kDegrees * std::acos(std::clamp(cosine, -1.0, 1.0));
    }

    void fill_sight(FieldMetrics& m, const Exposure& seen, const mesh::LabelTable& table)
    {
        m.visible_fraction = seen.visible_fraction;
        m.visible_fraction_mean_eye = seen.mean_visible_fraction;
        m.visible_fraction_central_eye = seen.central_eye_fraction;
        m.visible_fraction_wall_removed = seen.visible_fraction_unobstructed;
        m.eye_distance_mm = seen.cone.eye_distance_mm;
        m.cone_half_angle_deg = seen.cone.half_angle_deg;
        m.eyes = seen.cone.eyes;
        m.target_samples = static_cast<int>(seen.samples);
        m.blockers = sight_blockers(seen.blocked_by, table);
        for (const SightShare& bone : seen.bone_in_sight)
            if (bone.share >= kSmallestBoneShare)
                m.bone_in_sight.push_back(bone.name);
    }

    std::vector<HookForce> hook_forces(const PlannedField& field)
    {
        RETRACTOR_ASSERT(field.opening.hook_forces_N.size() == field.hooks.size());
        RETRACTOR_ASSERT(field.approach.hooks.size() == field.hooks.size());
        RETRACTOR_ASSERT(field.yielded.empty() || field.yielded.size() == field.hooks.size());
        const std::vector<bool> pushing = pushing_hooks(field.approach, field.opening.hook_forces_N);
        std::vector<HookForce> forces;
        for (std::size_t i = 0; i < field.hooks.size(); ++i) {
            const HookSpec& spec = field.approach.hooks[i];
            forces.push_back({ .name = field.hooks[i].name,
                .side = field.hooks[i].side,
                .force_N = field.opening.hook_forces_N[i].norm(),
                .pushes = pushing[i],
                // A retractor drifts as a whole; only the motion outwards opens the wound.
                .moved_mm = field.retractor ? field.hooks[i].displacement.dot(spec.direction)
                                            : field.hooks[i].displacement.norm(),
                .asked_mm = spec.opening_mm,
                .pull = spec.pull,
                .yielded = !field.yielded.empty() && field.yielded[i],
                .bears_on = spec.bears_on });
        }
        return forces;
    }

    /// The soft tissue that does not keep its volume; nothing when the solver gave no volumes.
    std::optional<VolumeFailures> volume_failures(const PlannedField& field, const Case& planned_case)
    {
        const std::vector<double>& ratios = field.opening.volume_ratio;
        if (ratios.size() != field.wall.tet_count())
            return std::nullopt;
        const ElementKind element = planned_case.solution.element;
        const bool patches = element == ElementKind::locking_free || element == ElementKind::p1;
        VolumeFailures failures
            = find_volume_failures(field.wall, patches ? averaged_volume_ratios(field.wall, ratios) : ratios,
                planned_case.label_table, field.opening.inverted_elements);
        if (failures.elements > 0)
            failures.place = place_beside_incision(field.approach, failures.at);
        return failures;
    }

    /// The way of a saw through the sternum: to the inner side of the wall, where that was measured. Fewer than two
    /// places: this is a knife's cut.
    struct SawWay {
        std::vector<Vec3> skin, inner;
    };
    SawWay saw_way(const Approach& approach, const mesh::LabelVolume& labels)
    {
        const std::vector<std::string> sawn = divided_bones(labels, approach);
        SawWay way;
        if (std::ranges::find(sawn, "sternum") == sawn.end()
            || approach.wall_thickness_mm.size() != approach.incision.size())
            return way;
        for (std::size_t n = 0; n < approach.incision.size(); ++n)
            if (approach.wall_thickness_mm[n] < approach.depth_mm) { // else no cavity lies behind the wall there
                way.skin.push_back(approach.incision[n]);
                way.inner.push_back(approach.incision[n] + approach.wall_thickness_mm[n] * approach.directions[n]);
            }
        return way;
    }

    /// Distances from the skin cut and from the strokes of the division. A saw along the sternum ends where the wall
    /// does; the blade of a knife is deeper, by the margin of Approach::depth_mm.
    std::vector<RiskDistance> risks_of(const Approach& approach, Patient& patient)
    {
        const auto surface_of = [&](std::string_view name) { return patient.organ(name); };
        const auto labels = patient.labels();
        const SawWay saw = saw_way(approach, *labels);
        std::vector<RiskDistance> risks = saw.skin.size() >= 2
            ? saw_risk_distances(saw.skin, saw.inner, *labels, surface_of)
            : risk_distances(blade_of(approach), *labels, surface_of);
        const auto add_assumed = [&](const TriMesh& cut) {
            for (RiskDistance& risk : assumed_distances(cut, patient.planned_case().assumed_vessels))
                risks.push_back(std::move(risk));
        };
        add_assumed(
            saw.skin.size() >= 2 ? saw_surface(saw.skin, saw.inner) : mesh::SweptBlade(blade_of(approach)).surface());
        for (const DivisionStroke& stroke : approach.division.strokes) {
            for (RiskDistance& risk : risk_distances(blade_of(stroke), *labels, surface_of))
                risks.push_back(std::move(risk));
            add_assumed(mesh::SweptBlade(blade_of(stroke)).surface());
        }
        risks = nearest_risks(std::move(risks));
        keep_nearest_bundle(risks);
        return risks;
    }

    /// Distances from the hooks or the retractor's blades, where they stand in the opened wound.
    std::vector<RiskDistance> steel_risks_of(const PlannedField& field, Patient& patient)
    {
        const auto surface_of = [&](std::string_view name) { return patient.organ(name); };
        std::vector<RiskDistance> risks;
        for (const HookShape& hook : placed_hooks(field, field.opening.displacement, field.geometry))
            for (RiskDistance& risk : risk_distances(hook_mesh(hook), hook.name, patient.labels()->table, surface_of))
                risks.push_back(std::move(risk));
        return nearest_risks(std::move(risks));
    }

    /// The estimated labels that the field's numbers rest on: target, what hides it, and what is at risk.
    std::vector<std::string> estimated_among(const FieldMetrics& m, const Case& planned_case)
    {
        std::vector<std::string> names;
        const auto add = [&](const std::string& name) {
            if (is_estimated(planned_case, name) && std::find(names.begin(), names.end(), name) == names.end())
                names.push_back(name);
        };
        add(m.target_spec.label);
        for (const SightBlocker& blocker : m.best_eye.hidden_by)
            add(label_of_deflated(blocker.name));
        for (const RiskDistance& risk : m.at_risk)
            add(risk.name);
        return names;
    }

    void fill_metrics(PlannedField& field, Patient& patient)
    {
        FieldMetrics& m = field.metrics;
        m.name = field.approach.name;
        m.target = target_name(field.approach.target);
        m.target_spec = field.approach.target;
        fill_best_eye(m, field, patient.frame(), patient.planned_case().label_table);
        fill_sight(m, field.exposure, patient.planned_case().label_table);
        m.at_risk = risks_of(field.approach, patient);
        m.steel_at_risk = steel_risks_of(field, patient);
        m.retracted = field.approach.retracted;
        m.estimated = estimated_among(m, patient.planned_case());
        m.opening_area_mm2 = field.geometry.area_mm2;
        m.opening_width_mm = field.geometry.width_mm;
        const double drawn = incision_length(field.approach), found = field.geometry.incision_length_mm;
        m.incision_length_mm = std::min(found, drawn); // the edges of the elements wind about the line
        m.cut_depth_mm = field.approach.depth_mm;
        m.crossed_bones = crossed_bones(*patient.labels(), field.approach);
        m.divided_cartilages = divided_cartilages(*patient.labels(), field.approach);
        constexpr double kWholeEdge = 0.8; // a wound begins and ends within a few elements of the incision's ends
        if (found < kWholeEdge * drawn)
            remark(field.message,
                formatted("the edge of the wound was found over %.0f mm of the incision's %.0f mm: opening, area and "
                          "view are those of this part",
                    found, drawn));
        m.hooks = hook_forces(field);
        m.retractor = retractor_metrics(field);
        if (is_usable(field.opening))
            m.lip_deviation = lip_deviations(field);
        m.hook_force_N = measures_of(field).larger_side_N();
        m.force_moments = compute_force_moments(m, field.approach.opening_protocol);
        m.strain_p99 = field.opening.strain_p99;
        m.strain_p99_at = place_of_strain(field);
        m.inverted_elements = field.opening.inverted_elements;
        m.max_volume_ratio = field.opening.max_volume_ratio;
        m.volume_failures = volume_failures(field, patient.planned_case());
        remark(field.message, volume_failure_text(m));
        if (m.contact && m.contact->largest_penetration_mm > 0.0)
            m.contact->place = place_beside_incision(field.approach, m.contact->at);
        m.bone_stiffness = bones_in_wall(*patient.bone_stiffness(), fem::labels_met(field.wall));
        remark(field.message, cut_off_text(m.bone_stiffness));
        m.residual = field.opening.residual;
        m.mechanics_status = status_text(field);
        m.tets = field.wall.tet_count();
        m.explanation = explain_field(field, patient.frame());
    }

    // ---- the stages of a plan: each returns false, with status and message set, when the plan ends there -----------

    /// Meshes the wall. The forecast of the plan accompanies the progress of the mesher.
    /// @param memory_bytes memory that the plan may take; not set: not known
    bool mesh_wall(PlannedField& field, const mesh::LabelVolume& labels, const mesh::MeshSizing& sizing,
        ElementKind element, std::optional<double> memory_bytes, const Job& job)
    {
        const StageTimer timer(field.metrics, "mesh");
        std::string forecast;
        Job meshing = job;
        meshing.on_progress
            = [&](std::string_view stage, double fraction) { job.report(std::string(stage) + forecast, fraction); };
        const auto on_forecast = [&](double tetrahedra) {
            const PlanForecast expected = forecast_plan(tetrahedra, element);
            forecast = " (" + forecast_text(expected) + ")";
            check_memory(expected, memory_bytes);
        };
        mesh::HybridModel model = build_wall(labels, sizing, meshing, on_forecast);
        field.mesh_statistics = model.statistics;
        field.message = std::move(model.message);
        field.wall = std::move(model.wall);
        if (model.status != mesh::MeshStatus::done)
            field.status
                = model.status == mesh::MeshStatus::cancelled ? PlanStatus::cancelled : PlanStatus::nothing_to_mesh;
        return field.status == PlanStatus::done;
    }

    /// Cuts the wall. The tension that this releases comes afterwards (release_tension()).
    bool cut_meshed_wall(PlannedField& field, CutWall& cut, UncutWall& uncut, const mesh::LabelVolume& labels,
        Patient& patient, const mesh::MeshSizing& sizing, const Job& job)
    {
        const StageTimer timer(field.metrics, "cut");
        const Case& planned_case = patient.planned_case();
        insert_bearing_points(field.wall, planned_case.label_table, field.approach);
        fem::Supports supports = supports_of(field.wall, labels, planned_case, sizing, &field.message);
        if (supports.fixed.empty() && supports.bedded.empty())
            remark(field.message,
                "only the hooks hold this wall: name supports in case.json, \"supports\" (the spine, or the border of "
                "the region)");
        std::vector<VertexId> cut_off = cut_off_vertices(field.wall, labels);
        field.rim = rim_places(field.wall, cut_off, { mesh::region_line(sizing), sizing.region_mm }, labels.grid);
        uncut = { .mesh = field.wall, .held = std::move(cut_off) };
        uncut.held.insert(uncut.held.end(), supports.fixed.begin(), supports.fixed.end());
        cut = cut_wall(std::move(field.wall), field.approach, planned_case.label_table, std::move(supports), job);
        if (!take_cut(field, cut))
            return false;
        check_lips(field, cut.took_lip);
        remark(field.message, slacken_other_spaces(field.wall, patient, field.approach));
        return true;
    }

    /// @param start as open_wound()
    /// @param time_s as PlanChecks::opening_time_s
    bool open_cut_wall(PlannedField& field, OpenedWound& wound, CutWall cut, Patient& patient,
        const mesh::LabelVolume& labels, const OpenedWall* start, double time_s, const Job& job)
    {
        const StageTimer timer(field.metrics, "open");
        TimeLimit limit(job, time_s);
        wound = open_wound(field, patient, labels, std::move(cut), limit.job(), start);
        if (limit.is_over() && field.status == PlanStatus::cancelled)
            end_unfinished(field, wound, formatted("no equilibrium was found in %.0f s", time_s));
        const bool lacks_contact = field.metrics.contact && !field.metrics.contact->message.empty();
        if (limit.is_over() && field.status == PlanStatus::done
            && (lacks_contact || field.opening.inverted_elements > 0)) {
            field.ended_by_time = true;
            remark(field.message,
                formatted("the opening's time of %.0f s was up before ", time_s)
                    + (lacks_contact ? "contact was computed" : "elements inside out were turned back"));
        }
        if (field.status != PlanStatus::done && field.status != PlanStatus::cancelled)
            remark(field.message, field.opening.message);
        if (const auto& stiffened = field.opening.stiffened; !stiffened.empty())
            remark(field.message,
                formatted(
                    "%zu element(s) that the blades turned inside out are computed up to %.0f times stiffer, which "
                    "changes the force by ",
                    stiffened.size(), std::ranges::max(stiffened, {}, &fem::StiffenedElement::factor).factor)
                    + two_digits(field.opening.stiffening_changed_N) + " N");
        return field.status != PlanStatus::cancelled;
    }

    /// "muscle, 85 mm from the incision towards the back".
    std::string place_in_words(const RimMotion& rim, const std::vector<Vec3>& line, const mesh::LabelTable& table,
        const AnatomicalFrame& frame)
    {
        Vec3 middle = Vec3::Zero();
        for (const Vec3& point : line)
            middle += point / static_cast<double>(line.size());
        const Vec3 way = rim.at - middle;
        const std::array<std::pair<double, const char*>, 6> directions { { { frame.anterior.dot(way), "the front" },
            { -frame.anterior.dot(way), "the back" }, { frame.superior.dot(way), "the head" },
            { -frame.superior.dot(way), "the feet" }, { frame.left.dot(way), "the left" },
            { -frame.left.dot(way), "the right" } } };
        const mesh::LabelInfo* info = mesh::find_label(table, rim.label);
        return formatted("%s, %.0f mm from the incision towards %s",
            info != nullptr ? readable(info->name).c_str() : "tissue", polyline_distance(line, rim.at),
            std::ranges::max_element(directions)->second);
    }

    /// Measures what the end of the region does: motion of the rim, and bones that come out through the skin.
    /// @pre field.remaining_wall is known
    void measure_region(
        PlannedField& field, const mesh::LabelVolume& labels, const mesh::MeshSizing& sizing, Patient& patient)
    {
        const Case& planned_case = patient.planned_case();
        const Points& displacement = field.opening.displacement;
        const std::vector<std::uint8_t> is_rim = rim_flags(field.wall, field.rim);
        const RimMotions rim = rim_motions(field.wall, displacement, field.problem.supports.fixed, is_rim, labels.grid);
        RegionMetrics& region = field.metrics.region;
        region.region_mm = sizing.region_mm;
        region.ended_by = field.approach.sizing.region_mm ? RegionEnd::given : RegionEnd::not_searched;
        region.rim_motion_mm = rim.region.moved_mm;
        region.rim_at = rim.region.at;
        region.image_end_motion_mm = rim.image.moved_mm;
        if (rim.region.label != 0)
            region.rim_place
                = place_in_words(rim.region, field.approach.incision, planned_case.label_table, patient.frame());
        region.piercing
            = bones_through_skin(field.wall, displacement, is_rim, field.remaining_wall, planned_case.label_table);
        remark(field.message, piercing_text(field.metrics));
    }

    bool expose_target(PlannedField& field, Patient& patient, const mesh::LabelVolume& labels,
        const mesh::MeshSizing& sizing, const Job& job)
    {
        const StageTimer timer(field.metrics, "expose");
        field.remaining_wall = unmeshed_wall_region(*patient.body(), labels, sizing, field.wall,
            field.opening.displacement, drawn_rim_width_mm(sizing.region_mm, field.approach.depth_mm), job);
        measure_region(field, labels, sizing, patient);
        WoundView view = look_through(field, field.opening.displacement, patient, job);
        field.geometry = std::move(view.geometry);
        field.best_eye = std::move(view.best);
        field.exposure = std::move(view.exposure);
        field.metrics.working_distance_mm = view.working_distance_mm;
        field.metrics.opening_solid_angle_sr = view.from_target.solid_angle_sr;
        field.metrics.attack_along_deg = view.from_target.along_deg;
        field.metrics.attack_across_deg = view.from_target.across_deg;
        field.metrics.target_offset_mm = view.from_target.offset_mm;
        if (const TargetSpec& target = field.approach.target; is_annulus(target))
            field.metrics.annulus
                = annulus_access(target, *patient.target(target), field.geometry.centre, field.best_eye.eye);
        remark(field.message, view.message);
        if (field.exposure.status == ExposureStatus::cancelled || field.best_eye.status == ExposureStatus::cancelled)
            field.status = PlanStatus::cancelled;
        return field.status != PlanStatus::cancelled;
    }

    /// What the best eye would see with the organs nearer to the head, as under anaesthesia in expiration.
    std::vector<ShiftedSight> sight_if_organs_shift(const PlannedField& field, Patient& patient, const Job& job)
    {
        constexpr std::array kShiftsMm { 10.0,
            20.0 }; // on expiration xiphoid to pericardium grows by 12 mm [PMC12310301]
        std::vector<ShiftedSight> sights;
        for (const double shift_mm : kShiftsMm) {
            if (job.cancelled())
                return {};
            sights.push_back({ .shift_mm = shift_mm,
                .seen_best_eye = seen_from_best_eye(field, field.opening.displacement, patient,
                    as_stage(job, "expose, organs higher"), { .by = shift_mm * patient.frame().superior }) });
        }
        return sights;
    }

    /// What the best eye would see past lungs that keep another share of their volume; nothing where no lung is held
    /// aside.
    std::vector<LungSight> sight_past_other_lungs(const PlannedField& field, Patient& patient, const Job& job)
    {
        std::vector<LungSight> sights;
        if (deflated_lungs(field.approach, patient).empty())
            return sights;
        for (const double share : kOtherLungShares) {
            if (job.cancelled())
                return {};
            sights.push_back({ .lung_share = share,
                .seen_best_eye = seen_from_best_eye(field, field.opening.displacement, patient,
                    as_stage(job, "expose, other lungs"), { .lung_share = share }) });
        }
        return sights;
    }

    /// What the best eye would see in each position on the table.
    std::vector<TurnedSight> sight_if_turned(const PlannedField& field, Patient& patient, const Job& job)
    {
        std::vector<TurnedSight> sights;
        for (const TablePosition& position : positions_for(field.geometry.normal, patient.frame())) {
            if (job.cancelled())
                return {};
            sights.push_back({ .left_side_up_deg = position.left_side_up_deg,
                .seen_best_eye = seen_from_best_eye(field, field.opening.displacement, patient,
                    as_stage(job, "expose, turned"), { .by = position.sink }, position.up) });
        }
        return sights;
    }

    /// Estimates gape and errors of the field from further solutions of the wound.
    bool estimate(
        PlannedField& field, const OpenedWound& wound, Patient& patient, const PlanChecks& checks, const Job& job)
    {
        const SolverSettings& choice = patient.planned_case().solution;
        field.metrics.solution.draft = checks.draft;
        const auto goes_on = [&] {
            if (job.cancelled())
                field.status = PlanStatus::cancelled;
            return field.status != PlanStatus::cancelled;
        };
        if (!tissues_under_tension(field.problem).empty()) {
            const StageTimer timer(field.metrics, "gape");
            field.metrics.tension = measure_gape(field, wound, choice, job);
            if (!goes_on())
                return false;
        }
        if (checks.error_bars) {
            const StageTimer timer(field.metrics, "estimate error");
            const SeenShare seen_share = [&](const Points& displacement) {
                return seen_from_best_eye(field, displacement, patient, as_stage(job, "expose, other elements"));
            };
            field.metrics.error = estimate_errors(field, wound, choice, seen_share, job);
            if (!goes_on())
                return false;
        }
        if (checks.error_bars) {
            const StageTimer timer(field.metrics, "organs higher");
            field.metrics.if_organs_shift = sight_if_organs_shift(field, patient, job);
            field.metrics.if_lung_keeps = sight_past_other_lungs(field, patient, job);
            field.metrics.if_turned = sight_if_turned(field, patient, job);
            if (!goes_on())
                return false;
        }
        if (checks.error_bars) {
            const StageTimer timer(field.metrics, "tissue values");
            field.metrics.parameters = patient.stiffness_factors().empty()
                ? estimate_parameter_interval(
                    field, wound, choice, patient.planned_case().label_table, *patient.bone_stiffness())
                : ParameterInterval { .message = "the plan is made with chosen factors on the stiffness" };
            if (!goes_on())
                return false;
        }
        if (field.opening.far) {
            const StageTimer timer(field.metrics, "estimate condensed region");
            field.metrics.solution.far = estimate_condensed_region_error(field, wound, choice);
        }
        if (checks.linear_region) {
            const StageTimer timer(field.metrics, "compare with nonlinear wall");
            field.metrics.solution.whole = compare_with_whole(field, wound.rigid, choice, job);
            return goes_on();
        }
        return true;
    }

    /// The implausible numbers that the case accepts, one sentence each.
    std::vector<std::string> implausible_texts(
        const Case& planned_case, const Approach& approach, const mesh::ImageGrid& labels)
    {
        std::vector<std::string> texts;
        for (const ImplausibleValue& value : find_implausible(planned_case))
            texts.push_back(value.text);
        for (const ImplausibleValue& value : find_implausible(approach))
            texts.push_back(value.text);
        if (const std::optional<std::string> extent = implausible_extent(labels))
            texts.push_back(*extent);
        return texts;
    }

    void check_retractor_settings(const SolverSettings& choice)
    {
        if (choice.near_mm > 0.0)
            throw InputError("a retractor needs the whole wall with the same law, since the balance of its blades "
                             "depends on tissue far away: leave near_mm out",
                "solution", { "near_mm" });
    }

    /// The same error, with the name of the approach added to its place.
    template <class Kind> std::exception_ptr at_approach(const Approach& approach, const Kind& error)
    {
        return std::make_exception_ptr(Kind(error.what(),
            "approach " + approach.name + (error.where().empty() ? "" : ": " + error.where()), error.fields()));
    }

    /// The approach as its mesh needs it: with blades for hooks, places of bearing, and the strokes of its division.
    void prepare(Approach& approach, Patient& patient)
    {
        if (approach.retractor) {
            check_retractor_settings(patient.planned_case().solution);
            approach.hooks = blades_of(approach);
            fit_blades(approach, *patient.labels());
        }
        find_bearing_points(approach, *patient.labels());
        find_division(approach, patient);
    }

    // Of the drafts that find a region: what moves far away depends little on the mesh at the wound.
    constexpr double kDraftEdgeMm = 12.0, kDraftCoarseMm = 20.0, kDraftPatchMm = 6.0;

    SizingSpec draft_sizing(SizingSpec sizing, double region_mm)
    {
        sizing.corridor_edge_mm = std::max(sizing.corridor_edge_mm, kDraftEdgeMm);
        sizing.coarse_edge_mm = std::max(sizing.coarse_edge_mm, kDraftCoarseMm);
        sizing.patch_edge_mm = std::max(sizing.patch_edge_mm, kDraftPatchMm);
        return found_sizing(sizing, region_mm);
    }

    /// A draft of the plan with linear four-node elements.
    /// @param prepared by prepare()
    RegionDraft draft_of_region(Patient& patient, const Approach& prepared, double region_mm,
        std::optional<double> memory_bytes, const Job& job)
    {
        using Status = RegionDraft::Status;
        Case planned_case = patient.planned_case();
        planned_case.solution = { .elasticity = fem::Elasticity::linear, .element = ElementKind::p1 };
        planned_case.contact = ContactMode::never;
        const auto labels = patient.labels();
        PlannedField field;
        field.approach = prepared;
        for (HookSpec& hook : field.approach.hooks)
            hook.hold = HookHold::fixed; // one linear solution
        field.approach.sizing = draft_sizing(prepared.sizing, region_mm);
        mesh::MeshSizing sizing = mesh_sizing_of(field.approach, planned_case.label_table);
        sizing.most_tetrahedra = tetrahedra_limit(memory_bytes, ElementKind::p1);
        const Job named = as_stage(job, "draft of the wall");
        CutWall cut;
        UncutWall uncut;
        try {
            if (!mesh_wall(field, *labels, sizing, ElementKind::p1, memory_bytes, named)
                || !cut_meshed_wall(field, cut, uncut, *labels, patient, sizing, named))
                return { .status = field.status == PlanStatus::cancelled ? Status::cancelled : Status::failure,
                    .message = field.message };
            release_tension(field, cut, uncut, patient);
            static_cast<void>(open_wound(field, patient, planned_case, *labels, std::move(cut), named));
        } catch (const MemoryRefusal&) {
            return { .status = Status::memory };
        } catch (const InputError& error) {
            return { .status = Status::failure, .message = error.what() };
        } catch (const SolverError& error) {
            return { .status = Status::failure, .message = error.what() };
        }
        if (field.status == PlanStatus::cancelled || job.cancelled())
            return { .status = Status::cancelled };
        const Points& displacement = field.opening.displacement;
        const std::vector<Vec3> line = mesh::region_line(sizing);
        const RimMotions rim = rim_motions(
            field.wall, displacement, field.problem.supports.fixed, rim_flags(field.wall, field.rim), labels->grid);
        const std::array<double, 2> sides = side_forces(field, field.opening.hook_forces_N);
        return { .moving_mm = moving_reach(field.wall, displacement, line, kStillRimMm),
            .farthest_mm = moving_reach(field.wall, displacement, line, -1.0),
            .rim_motion_mm = rim.region.moved_mm,
            .force_N = std::max(sides[0], sides[1]) };
    }

    /// A region that holds the wall: the distance of its farthest voxel, of the two ends of each row of voxels.
    double whole_region_mm(const mesh::LabelVolume& labels, const std::vector<Vec3>& line)
    {
        const mesh::ImageGrid& grid = labels.grid;
        const mesh::LabelFlags in_wall = mesh::flagged_labels(labels.table, mesh::is_wall);
        const auto is_in_wall = [&](Label label) { return in_wall[label] != 0; };
        const auto width = static_cast<std::size_t>(grid.size[0]);
        double farthest = 0.0;
        for (int k = 0; k < grid.size[2]; ++k)
            for (int j = 0; j < grid.size[1]; ++j) {
                const std::span<const Label> row(labels.voxels.data() + grid.offset(0, j, k), width);
                const auto first = std::ranges::find_if(row, is_in_wall);
                if (first == row.end())
                    continue;
                const auto last = std::find_if(row.rbegin(), row.rend(), is_in_wall).base() - 1;
                for (const auto end : { first, last })
                    farthest = std::max(farthest,
                        polyline_distance(line, grid.world(Vec3(static_cast<double>(end - row.begin()), j, k))));
            }
        const double voxel_mm = grid.spacing.norm(); // the surface lies less than this beyond the voxel's middle
        return std::max(std::ceil(farthest + voxel_mm), kFirstRegionMm);
    }

    /// The approach with its wall meshed and cut, which does not depend on the stiffness of the tissue.
    struct CutApproach {
        PlannedField field; ///< with the wall, not yet opened
        CutWall cut; ///< without the parts that the field took over
        UncutWall uncut;
        mesh::MeshSizing sizing;
    };

    /// Meshes and cuts the wall of an approach. @returns false, with the field's status set, when the plan ends there
    bool mesh_and_cut(
        CutApproach& made, Patient& patient, const Approach& approach, const Job& job, const PlanChecks& checks)
    {
        const Case& planned_case = patient.planned_case();
        check_approach(approach);
        check_plan(planned_case, checks);
        check_plausible(planned_case, approach);
        PlannedField& field = made.field;
        field.approach = approach;
        const auto labels = patient.labels();
        field.metrics.implausible = implausible_texts(planned_case, approach, labels->grid);
        prepare(field.approach, patient);
        const ElementKind element = planned_case.solution.element;
        const std::optional<double> memory_bytes = checks.memory_bytes ? checks.memory_bytes : available_memory();
        made.sizing = mesh_sizing_of(field.approach, planned_case.label_table);
        made.sizing.most_tetrahedra = tetrahedra_limit(memory_bytes, element);
        return mesh_wall(field, *labels, made.sizing, element, memory_bytes, job)
            && cut_meshed_wall(field, made.cut, made.uncut, *labels, patient, made.sizing, job);
    }

    /// Opens the cut wall and measures the field.
    /// @param start as open_wound()
    /// @param wound set to the data of the opening
    void open_and_measure(CutApproach& made, OpenedWound& wound, Patient& patient, const OpenedWall* start,
        const Job& job, const PlanChecks& checks)
    {
        const Case& planned_case = patient.planned_case();
        const auto labels = patient.labels();
        PlannedField& field = made.field;
        release_tension(field, made.cut, made.uncut, patient);
        if (!open_cut_wall(field, wound, std::move(made.cut), patient, *labels, start, checks.opening_time_s, job)
            || !expose_target(field, patient, *labels, made.sizing, job)
            || !estimate(field, wound, patient, checks, job))
            return;
        fill_metrics(field, patient);
        const StageTimer timer(field.metrics, "strain and bones");
        measure_tissue_strain(field, wound, planned_case.label_table);
        measure_bones(field, wound, planned_case.solution, planned_case.label_table, patient.frame());
        if (checks.injury_options)
            solve_uninjured_opening(
                field, wound, planned_case.solution, planned_case.label_table, patient.frame(), job);
    }

    /// The region by drafts.
    FoundRegion find_region_of(
        Patient& patient, const Approach& approach, double whole_mm, const PlanChecks& checks, const Job& job)
    {
        const Stopwatch watch;
        Approach prepared = approach;
        prepare(prepared, patient);
        FoundRegion found = find_region(whole_mm,
            [&](double region_mm) { return draft_of_region(patient, prepared, region_mm, checks.memory_bytes, job); });
        found.measures.seconds = watch.seconds();
        return found;
    }

    /// Notes how the region of a field was found.
    void take_region(RegionMetrics& region, const RegionMetrics& found)
    {
        region.ended_by = found.ended_by;
        region.message = found.message;
        region.drafts = found.drafts;
        region.force_change = found.force_change;
        region.seconds = found.seconds;
    }

    /// The whole wall where it is small enough, or the region by drafts.
    FoundRegion whole_or_found_region(
        Patient& patient, const Approach& approach, double whole_mm, const PlanChecks& checks, const Job& job)
    {
        const bool is_coarse = approach.sizing.corridor_edge_mm >= kDraftEdgeMm; // a draft saves less than it takes
        return is_coarse && whole_mm <= checks.whole_wall_mm
            ? FoundRegion { .region_mm = whole_mm, .measures = { .ended_by = RegionEnd::whole } }
            : find_region_of(patient, approach, whole_mm, checks, job);
    }

    /// Plans one approach, with its region known, once, or on finer and finer meshes where an accuracy is asked.
    PlannedField plan_as_accurately_as_asked(
        Patient& patient, const Approach& approach, const Job& job, const PlanChecks& checks, const Stopwatch& watch)
    {
        if (!checks.accuracy)
            return plan_approach(patient, approach, job, checks);
        const AccuracySearch search { .goal = *checks.accuracy,
            .element = patient.planned_case().solution.element,
            .memory_bytes = checks.memory_bytes,
            .elapsed_s = [&watch] { return watch.seconds(); } };
        return plan_to_accuracy(search, [&](double edge_factor) {
            Approach finer = approach;
            finer.sizing = with_scaled_edges(approach.sizing, edge_factor);
            return plan_approach(patient, finer, job, checks);
        });
    }

    /// The approach with the bone divided that would break, planned once, in the region of the approach's own field.
    /// Where this plan cannot be made, the field's message says why.
    std::optional<PlannedField> plan_with_divided_bone(
        Patient& patient, const Approach& approach, PlannedField& field, const Job& job, PlanChecks checks)
    {
        const std::optional<Approach> divided = with_divided_bone(approach, field);
        if (!divided || job.cancelled())
            return std::nullopt;
        checks.injury_options = false;
        PlannedField planned;
        try {
            planned = plan_approach(patient, *divided, job, checks);
        } catch (const InputError& error) {
            remark(field.message, divided->name + " gave no plan: " + error.what());
            return std::nullopt;
        } catch (const SolverError& error) {
            remark(field.message, divided->name + " gave no plan: " + error.what());
            return std::nullopt;
        }
        const RegionMetrics& found = field.metrics.region;
        RegionMetrics& region = planned.metrics.region;
        region.ended_by = found.ended_by;
        region.message = found.message;
        region.force_change = found.force_change;
        return planned;
    }

} // namespace

void check_plan(const Case& planned_case, const PlanChecks& checks)
{
    check_solution(planned_case.solution, planned_case.contact);
    check_pressures(planned_case);
    check_plausible(planned_case);
    if (checks.accuracy) {
        check_accuracy(*checks.accuracy);
        if (!checks.error_bars)
            throw InputError("a plan without error bars, such as a draft, promises no accuracy", "accuracy",
                { "accuracy", "draft" });
    }
    if (checks.linear_region && planned_case.solution.near_mm == 0.0)
        throw InputError(
            "there is nothing to check: near_mm is 0, so the whole wall follows the same law", "check", { "check" });
}

PlannedField plan_approach(Patient& patient, const Approach& approach, const Job& job, const PlanChecks& checks)
{
    CutApproach made;
    OpenedWound wound;
    if (mesh_and_cut(made, patient, approach, job, checks))
        open_and_measure(made, wound, patient, nullptr, job, checks);
    return std::move(made.field);
}

PlannedField plan_in_region(Patient& patient, const Approach& approach, const Job& job, const PlanChecks& checks)
{
    const Stopwatch watch;
    if (!checks.find_region || approach.sizing.region_mm)
        return plan_as_accurately_as_asked(patient, approach, job, checks, watch);
    check_approach(approach);
    check_plausible(patient.planned_case(), approach);
    const double whole_mm = whole_region_mm(*patient.labels(), approach.incision);
    FoundRegion found = whole_or_found_region(patient, approach, whole_mm, checks, job);
    while (!found.cancelled) {
        Approach with_region = approach;
        with_region.sizing = found_sizing(approach.sizing, found.region_mm);
        try {
            PlannedField field = plan_as_accurately_as_asked(patient, with_region, job, checks, watch);
            take_region(field.metrics.region, found.measures);
            return field;
        } catch (const MemoryRefusal&) {
            if (found.measures.drafts == 0)
                found = find_region_of(patient, approach, whole_mm, checks, job);
            else if (!shrink_region(found))
                throw;
        }
    }
    PlannedField field;
    field.approach = approach;
    field.status = PlanStatus::cancelled;
    return field;
}

namespace {

    /// As plan_samples(), in the region of the approach.
    void plan_samples_in_region(Patient& patient, const Approach& approach, std::span<const StiffnessFactors> samples,
        const std::function<void(std::size_t, PlanAttempt)>& on_planned, const Job& job, const PlanChecks& checks)
    {
        CutApproach made;
        if (!mesh_and_cut(made, patient, approach, job, checks)) {
            for (std::size_t s = 0; s < samples.size() && !job.cancelled(); ++s)
                on_planned(s, { .field = made.field, .failure = {} });
            return;
        }
        const auto is_own = [](const StiffnessFactors& factors) { return factors.empty(); };
        std::optional<OpenedWall> start;
        {
            CutApproach own = made;
            OpenedWound wound;
            if (std::ranges::any_of(samples, is_own)) {
                open_and_measure(own, wound, patient, nullptr, job, checks);
            } else {
                release_tension(own.field, own.cut, own.uncut, patient);
                open_cut_wall(own.field, wound, std::move(own.cut), patient, *patient.labels(), nullptr,
                    checks.opening_time_s, job);
            }
            if (job.cancelled())
                return;
            if (is_usable(own.field.opening) && !own.field.contact_was_lost)
                start = opened_wall_of(own.field, wound);
            for (std::size_t s = 0; s < samples.size(); ++s)
                if (is_own(samples[s]))
                    on_planned(s, { .field = own.field, .failure = {} });
        }
        made.field.metrics.seconds.clear(); // mesh and cut were made once
        for (std::size_t s = 0; s < samples.size() && !job.cancelled(); ++s) {
            if (samples[s].empty())
                continue;
            patient.set_stiffness_factors(samples[s]);
            PlanAttempt sample;
            try {
                CutApproach own = made;
                OpenedWound wound;
                open_and_measure(own, wound, patient, start ? &*start : nullptr, job, checks);
                sample.field = std::move(own.field);
            } catch (const SolverError& error) {
                sample.failure = error.what();
            } catch (const InputError& error) {
                sample.failure = error.what();
            }
            if (!job.cancelled())
                on_planned(s, std::move(sample));
        }
    }

} // namespace

void plan_samples(Patient& patient, const Approach& approach, std::span<const StiffnessFactors> samples,
    const std::function<void(std::size_t, PlanAttempt)>& on_planned, const Job& job, const PlanChecks& checks)
{
    patient.set_stiffness_factors({});
    if (!checks.find_region || approach.sizing.region_mm) {
        plan_samples_in_region(patient, approach, samples, on_planned, job, checks);
        return;
    }
    check_approach(approach);
    check_plausible(patient.planned_case(), approach);
    const double whole_mm = whole_region_mm(*patient.labels(), approach.incision);
    const FoundRegion found = whole_or_found_region(patient, approach, whole_mm, checks, job);
    if (found.cancelled || job.cancelled())
        return;
    Approach with_region = approach;
    with_region.sizing = found_sizing(approach.sizing, found.region_mm);
    plan_samples_in_region(
        patient, with_region, samples,
        [&](std::size_t sample, PlanAttempt planned) {
            take_region(planned.field.metrics.region, found.measures);
            on_planned(sample, std::move(planned));
        },
        job, checks);
}

namespace {

    /// What came of the approaches of a case, in its order.
    struct AllPlans {
        std::vector<PlannedField> fields;
        std::vector<std::optional<PlannedField>> divided;
        std::vector<std::exception_ptr> failures;
    };

    AllPlans plan_approaches(Patient& patient, const Job& job, const PlanChecks& checks, bool stop_at_failure)
    {
        const std::vector<Approach>& approaches = patient.planned_case().approaches;
        const std::size_t workers = std::min<std::size_t>({ 2, approaches.size(),
            std::max(1U, std::thread::hardware_concurrency()), static_cast<std::size_t>(std::max(1, job.threads)) });
        PlanChecks shared = checks;
        if (!shared.memory_bytes && workers > 0)
            // Measured once: what a plan finds available depends on how far the other has come.
            if (const std::optional<double> available = available_memory())
                shared.memory_bytes = *available / static_cast<double>(workers);
        AllPlans all { .fields = std::vector<PlannedField>(approaches.size()),
            .divided = std::vector<std::optional<PlannedField>>(approaches.size()),
            .failures = std::vector<std::exception_ptr>(approaches.size()) };
        std::atomic<std::size_t> next { 0 };
        const auto work = [&] {
            for (std::size_t i = next.fetch_add(1); i < approaches.size(); i = next.fetch_add(1)) {
                try {
                    all.fields[i] = plan_in_region(patient, approaches[i], job, shared);
                    if (shared.injury_options)
                        all.divided[i] = plan_with_divided_bone(patient, approaches[i], all.fields[i], job, shared);
                } catch (const InputError& error) {
                    all.failures[i] = at_approach(approaches[i], error);
                } catch (const SolverError& error) {
                    all.failures[i] = at_approach(approaches[i], error);
                } catch (...) {
                    all.failures[i] = std::current_exception();
                }
                if (all.failures[i] && stop_at_failure)
                    next.store(approaches.size());
            }
        };
        {
            std::vector<std::jthread> threads;
            for (std::size_t w = 1; w < workers; ++w)
                threads.emplace_back(work);
            work();
        }
        return all;
    }

} // namespace

std::vector<PlannedField> plan_all(Patient& patient, const Job& job, const PlanChecks& checks)
{
    AllPlans planned = plan_approaches(patient, job, checks, true);
    for (const std::exception_ptr& failure : planned.failures)
        if (failure)
            std::rethrow_exception(failure);
    std::vector<PlannedField> all;
    for (std::size_t i = 0; i < planned.fields.size(); ++i) {
        all.push_back(std::move(planned.fields[i]));
        if (planned.divided[i])
            all.push_back(std::move(*planned.divided[i]));
    }
    return all;
}

std::vector<PlanAttempt> plan_each(Patient& patient, const Job& job, const PlanChecks& checks)
{
    PlanChecks own = checks;
    own.injury_options = false;
    AllPlans planned = plan_approaches(patient, job, own, false);
    std::vector<PlanAttempt> attempts(planned.fields.size());
    for (std::size_t i = 0; i < attempts.size(); ++i) {
        attempts[i].field = std::move(planned.fields[i]);
        if (planned.failures[i])
            try {
                std::rethrow_exception(planned.failures[i]);
            } catch (const InputError& error) {
                attempts[i].failure = error.what();
            } catch (const SolverError& error) {
                attempts[i].failure = error.what();
            }
    }
    return attempts;
}

} // namespace retractor::planner
