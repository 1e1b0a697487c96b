#include "planner/measures/metrics.h"

#include "fem/material/tissue_law.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/measures/accuracy.h"
#include "planner/measures/ball_strain.h"
#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/hook_opening.h"
#include "planner/measures/metric_table.h"
#include "planner/measures/region_text.h"
#include "planner/measures/risk_distances.h"
#include "planner/measures/rupture.h"
#include "planner/measures/tissue_values.h"
#include "planner/measures/verdict.h"
#include "planner/wall/wall_tension.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace retractor::planner {

namespace {

    using Json = nlohmann::ordered_json;

    void put(Json& json, const FieldMetrics& field, const char* key, double value)
    {
        if (!std::isfinite(value))
            throw InputError(std::string("the number ") + key + " is not finite", "approach " + field.name);
        json[key] = value;
    }

    void put(Json& json, const FieldMetrics& field, MetricGroup group)
    {
        for (const MetricField& metric : metric_fields())
            if (metric.group == group)
                put(json, field, metric.key, metric.of(field));
    }

    Json error_document(const FieldMetrics& field, const ErrorBars& error)
    {
        Json json;
        if (!error.message.empty()) {
            json["message"] = error.message;
        } else {
            put(json, field, "opening_width_mm", error.opening_width_mm);
            put(json, field, "opening_area_mm2", error.opening_area_mm2);
            put(json, field, "seen_best_eye", error.seen_best_eye);
            json["hook_forces_N"] = error.hook_forces_N;
            json["hook_moved_mm"] = error.hook_moved_mm;
            json["side_forces_N"] = { error.side_forces_N[0], error.side_forces_N[1] };
            put(json, field, "hook_force_N", error.hook_force_N);
            if (error.energy) {
                put(json, field, "energy_norm_relative", error.energy->energy_error);
                put(json, field, "algebraic_relative", error.energy->algebraic_error);
            }
            json["holds_for"] = "discretisation, to first order at the solution";
        }
        put(json, field, "seconds", error.seconds);
        return json;
    }

    Json accuracy_document(const FieldMetrics& field, const AccuracyMetrics& accuracy)
    {
        Json json;
        for (const AccuracyField& row : accuracy_fields())
            if (const std::optional<double> value = row.of(accuracy))
                put(json, field, row.key, *value);
        json["rounds"] = accuracy.rounds;
        json["ended_by"] = to_string(accuracy.ended_by);
        if (!accuracy.message.empty())
            json["message"] = accuracy.message;
        return json;
    }

    Json tension_document(const FieldMetrics& field, const TensionMetrics& tension)
    {
        Json json;
        json["tissues"] = Json::array();
        for (const auto& [material, strain] : tension.tissues)
            json["tissues"].push_back({ { "material", material }, { "pre_strain", pre_strain_text(strain) } });
        if (!tension.message.empty()) {
            json["message"] = tension.message;
        } else {
            put(json, field, "gape_mm", tension.gape_mm);
            put(json, field, "gape_area_mm2", tension.gape_area_mm2);
        }
        put(json, field, "seconds", tension.seconds);
        return json;
    }

    Json whole_document(const FieldMetrics& field, const WholeMetrics& whole)
    {
        Json json;
        if (!whole.message.empty()) {
            json["message"] = whole.message;
        } else {
            put(json, field, "opening_width_mm", whole.opening_width_mm);
            put(json, field, "opening_area_mm2", whole.opening_area_mm2);
            put(json, field, "hook_force_N", whole.hook_force_N);
            put(json, field, "lips_difference", whole.lips_difference);
        }
        put(json, field, "seconds", whole.seconds);
        return json;
    }

    std::string whole_text(const WholeMetrics& whole)
    {
        if (!whole.message.empty())
            return whole.message;
        return formatted("opening %.1f mm, force %.1f N, lips within %.1f %% of the largest displacement (%.1f s)",
            whole.opening_width_mm, whole.hook_force_N, 100.0 * whole.lips_difference, whole.seconds);
    }

    Json far_document(const FieldMetrics& field, const CondensedRegionMetrics& far)
    {
        Json json { { "linear", far.linear } };
        if (!far.message.empty()) {
            json["message"] = far.message;
        } else if (far.linear) {
            Json& estimate = json["error_estimate"];
            put(estimate, field, "opening_width_mm", far.opening_width_mm);
            put(estimate, field, "opening_area_mm2", far.opening_area_mm2);
            put(estimate, field, "hook_force_N", far.hook_force_N);
        } else {
            put(json, field, "linear_share", far.linear_share);
        }
        return json;
    }

    std::string far_text(const FieldMetrics& field, const CondensedRegionMetrics& far)
    {
        if (!far.message.empty())
            return "; the error of the linear region was not estimated: " + far.message;
        if (far.linear)
            return formatted("; error of the linear region: %.2g mm of opening and %.2g N (estimated, to first order)",
                far.opening_width_mm, far.hook_force_N);
        return formatted(
            "; the error of the linear region was too large at %.0f %% of the hooks' motion; from there on all %zu "
            "elements are nonlinear",
            100.0 * far.linear_share, field.tets);
    }

    Json volume_document(const FieldMetrics& field, const VolumeFailures& failures)
    {
        Json json { { "elements", failures.elements } };
        put(json, field, "share", failures.share);
        put(json, field, "smallest_ratio", failures.smallest_ratio);
        put(json, field, "largest_ratio", failures.largest_ratio);
        if (failures.elements > 0)
            json["at_mm"] = { failures.at.x(), failures.at.y(), failures.at.z() };
        if (!failures.place.empty())
            json["place"] = failures.place;
        json["believable"] = failures.believable;
        return json;
    }

    Json mesh_document(const FieldMetrics& field, const SizingSpec& sizing)
    {
        Json json;
        put(json, field, "corridor_radius_mm", sizing.corridor_radius_mm);
        put(json, field, "corridor_edge_mm", sizing.corridor_edge_mm);
        put(json, field, "coarse_edge_mm", sizing.coarse_edge_mm);
        put(json, field, "region_mm", sizing.region_mm.value_or(kFirstRegionMm));
        json["seed"] = sizing.mesh_seed;
        return json;
    }

    Json solution_document(const FieldMetrics& field, const SolutionMetrics& solution)
    {
        const SolverSettings& choice = solution.choice;
        Json json;
        json["elasticity"] = to_string(choice.elasticity);
        json["element"] = to_string(choice.element);
        json["draft"] = solution.draft;
        json["mesh"] = mesh_document(field, solution.mesh);
        json["nodes"] = solution.nodes;
        constexpr double kAny = 0.5; // at this limit the elements restrict no Poisson's ratio
        if (const double most = largest_poissons_ratio(choice.element); most < kAny)
            put(json, field, "poissons_ratio_at_most", most);
        for (const auto& [material, law] : solution.laws)
            json["laws"][material] = law;
        if (choice.near_mm > 0.0) {
            put(json, field, "near_mm", choice.near_mm);
            json["near_tets"] = solution.near_tets;
        }
        if (solution.far)
            json["far_field"] = far_document(field, *solution.far);
        if (solution.whole)
            json["whole"] = whole_document(field, *solution.whole);
        return json;
    }

    Json opinion_document(const FieldMetrics& field, const SecondOpinion& opinion)
    {
        Json json { { "program", opinion.program }, { "status", opinion.status } };
        if (!opinion.message.empty())
            json["message"] = opinion.message;
        if (opinion.status != "failed") {
            put(json, field, "displacement_difference", opinion.displacement_difference);
            put(json, field, "force_difference", opinion.force_difference);
            put(json, field, "largest_displacement_mm", opinion.largest_displacement_mm);
            json["hook_forces_N"] = opinion.hook_forces_N;
            json["own_hook_forces_N"] = opinion.own_hook_forces_N;
        }
        put(json, field, "seconds", opinion.seconds);
        put(json, field, "own_seconds", opinion.own_seconds);
        return json;
    }

    Json hooks_document(const FieldMetrics& field)
    {
        Json all = Json::array();
        for (const HookForce& hook : field.hooks) {
            Json json { { "name", hook.name }, { "side", hook.side } };
            put(json, field, "force_N", hook.force_N);
            json["bears_on"] = hook.bears_on;
            if (hook.pushes)
                json["pushes"] = true;
            put(json, field, "moved_mm", hook.moved_mm);
            if (hook.pull.force_N)
                put(json, field, "asked_force_N", *hook.pull.force_N);
            else
                put(json, field, "asked_mm", hook.asked_mm);
            if (hook.pull.grip_N_per_mm)
                put(json, field, "grip_N_per_mm", *hook.pull.grip_N_per_mm);
            if (hook.pull.force_limit_N) {
                put(json, field, "force_limit_N", *hook.pull.force_limit_N);
                json["yielded"] = hook.yielded;
            }
            all.push_back(json);
        }
        return all;
    }

    Json retractor_document(const FieldMetrics& field, const RetractorMetrics& retractor)
    {
        const auto vector = [](const Vec3& v) { return Json { v.x(), v.y(), v.z() }; };
        Json json { { "kind", retractor.kind } };
        if (retractor.asked_force_N)
            put(json, field, "asked_force_N", *retractor.asked_force_N);
        put(json, field, "opening_mm", retractor.opening_mm);
        put(json, field, "rack_force_N", retractor.rack_force_N);
        json["blades"] = Json::array();
        for (const BladeMetrics& blade : retractor.blades) {
            Json of_blade { { "name", blade.name }, { "force_N", vector(blade.force_N) },
                { "moment_Nm", vector(blade.moment_Nm) } };
            put(of_blade, field, "turn_deg", blade.turn_deg);
            of_blade["at_stop"] = blade.at_stop;
            put(of_blade, field, "lip_deviation_mm", blade.lip_deviation_mm);
            of_blade["hold"] = to_string(blade.pressure ? HookHold::contact : HookHold::fixed);
            if (blade.pressure) {
                put(of_blade, field, "pressure_mean_kPa", blade.pressure->mean_kPa);
                put(of_blade, field, "pressure_largest_kPa", blade.pressure->largest_kPa);
                of_blade["pressure_largest_at"] = blade.pressure->largest_at;
                put(of_blade, field, "touching_mm2", blade.pressure->touching_mm2);
                put(of_blade, field, "on_bone_N", blade.pressure->on_bone_N);
                of_blade["thirds_N"] = blade.pressure->thirds_N;
                put(of_blade, field, "penetration_mm", blade.pressure->penetration_mm);
            }
            json["blades"].push_back(std::move(of_blade));
        }
        put(json, field, "residual_force_N", retractor.residual_force_N);
        put(json, field, "residual_moment_Nm", retractor.residual_moment_Nm);
        if (retractor.hand_moment_Nm)
            put(json, field, "hand_moment_Nm", *retractor.hand_moment_Nm);
        put(json, field, "tilt_deg", retractor.tilt_deg);
        json["contact_was_lost"] = retractor.contact_was_lost;
        return json;
    }

    Json lips_document(const FieldMetrics& field)
    {
        Json all = Json::array();
        for (const LipDeviation& lip : field.lip_deviation) {
            Json json { { "side", lip.side } };
            put(json, field, "largest_mm", lip.largest_mm);
            put(json, field, "mean_mm", lip.mean_mm);
            put(json, field, "at_mm", lip.at_mm);
            json["between_mm"] = { lip.from_mm, lip.to_mm };
            json["curve"] = Json::array();
            for (const auto& [along, deviation] : lip.curve)
                json["curve"].push_back({ along, deviation });
            all.push_back(std::move(json));
        }
        return all;
    }

    void put_forces(Json& json, const FieldMetrics& field)
    {
        json["hook_forces_N"] = Json::array();
        json["hook_names"] = Json::array();
        double per_side[2] = { 0.0, 0.0 };
        for (const HookForce& hook : field.hooks) {
            json["hook_forces_N"].push_back(hook.force_N);
            json["hook_names"].push_back(hook.name);
            if (!hook.pushes)
                per_side[hook.side > 0 ? 0 : 1] += hook.force_N;
        }
        json["side_forces_N"] = { per_side[0], per_side[1] };
        json["hooks"] = hooks_document(field);
        if (field.retractor)
            json["retractor"] = retractor_document(field, *field.retractor);
        if (!field.lip_deviation.empty())
            json["lip_deviation"] = lips_document(field);
    }

    Json moments_document(const FieldMetrics& field, const ForceMoments& moments)
    {
        Json json;
        if (!moments.message.empty()) {
            json["message"] = "not applicable: " + moments.message;
            return json;
        }
        put(json, field, "peak_N", moments.peak_N);
        put(json, field, "held_N", moments.held_N);
        json["held_range_N"] = { moments.held_least_N, moments.held_most_N };
        put(json, field, "opened_in_s", moments.opened_in_s);
        put(json, field, "held_for_s", moments.hold_s);
        json["protocol"] = moments.protocol;
        json["faster_than_half_a_turn_in_10_s"] = moments.is_fast;
        json["source"] = moments.source;
        return json;
    }

    Json contact_document(const FieldMetrics& field, const ContactMetrics& contact)
    {
        Json json;
        if (contact.needed)
            json["needed"] = *contact.needed;
        json["computed"] = contact.computed;
        json["touching_points"] = contact.touching;
        put(json, field, "largest_penetration_mm", contact.largest_penetration_mm);
        if (contact.largest_penetration_mm > 0.0) {
            json["at_mm"] = { contact.at.x(), contact.at.y(), contact.at.z() };
            if (!contact.place.empty())
                json["place"] = contact.place;
            json["with"] = contact.with;
        }
        put(json, field, "force_N", contact.force_N);
        put(json, field, "overlap_at_rest_mm", contact.overlap_at_rest_mm);
        if (!contact.message.empty())
            json["message"] = contact.message;
        return json;
    }

    void put_surfaces(Json& json, const FieldMetrics& field)
    {
        if (field.contact)
            json["contact"] = contact_document(field, *field.contact);
        for (const PressureMetrics& pressure : field.pressures)
            json["pressures"].push_back({ { "label", pressure.label }, { "pressure_kPa", pressure.pressure_kPa },
                { "area_mm2", pressure.area_mm2 },
                { "force_N", { pressure.force_N.x(), pressure.force_N.y(), pressure.force_N.z() } },
                { "follows_surface", pressure.follows }, { "behind_gap_mm2", pressure.behind_gap_mm2 } });
    }

    void put_removed(Json& json, const FieldMetrics& field)
    {
        json["removed"] = Json::array();
        double volume = 0.0;
        for (const RemovedTissue& tissue : field.removed) {
            json["removed"].push_back(
                { { "what", tissue.what }, { "label", tissue.label }, { "volume_mm3", tissue.volume_mm3 } });
            volume += tissue.volume_mm3;
        }
        put(json, field, "removed_volume_mm3", volume);
        put(json, field, "removed_skin_mm2", field.removed_skin_mm2);
        json["loose_pieces"] = field.loose_pieces;
    }

    Json division_document(const FieldMetrics& field, const DividedTissue& division)
    {
        Json json { { "labels", division.labels } };
        put(json, field, "length_mm", division.length_mm);
        put(json, field, "forwards_mm", division.forwards_mm);
        put(json, field, "backwards_mm", division.backwards_mm);
        put(json, field, "right_mm", division.right_mm);
        put(json, field, "left_mm", division.left_mm);
        put(json, field, "severed_mm2", division.severed_mm2);
        json["message"] = division.words;
        return json;
    }

    Json joint_document(const FieldMetrics& field, const JointLoad& load)
    {
        Json json;
        put(json, field, "force_N", load.force_N);
        put(json, field, "moment_Nm", load.moment_Nm);
        if (load.turn_deg) {
            put(json, field, "turn_deg", *load.turn_deg);
            json["at_stop"] = load.at_stop;
        }
        return json;
    }

    Json bone_document(const FieldMetrics& field, const BoneMetrics& bone)
    {
        Json json { { "name", bone.name } };
        put(json, field, "moment_Nm", bone.moment_Nm);
        put(json, field, "bending_Nm", bone.bending_Nm);
        put(json, field, "torsion_Nm", bone.torsion_Nm);
        if (!bone.part.empty())
            json["part"] = bone.part;
        put(json, field, "at_mm", bone.at_mm);
        put(json, field, "length_mm", bone.length_mm);
        json["place_mm"] = { bone.place.x(), bone.place.y(), bone.place.z() };
        put(json, field, "section_mm2", bone.section_mm2);
        if (bone.capacity_Nm) {
            put(json, field, "capacity_Nm", *bone.capacity_Nm);
            put(json, field, "utilisation", bone.utilisation);
        } else {
            json["capacity"] = "no published number";
        }
        if (bone.opening_at_limit_mm)
            put(json, field, "opening_at_limit_mm", *bone.opening_at_limit_mm);
        if (bone.spine_joint)
            json["spine_joint"] = joint_document(field, *bone.spine_joint);
        if (bone.cartilage)
            json["cartilage"] = joint_document(field, *bone.cartilage);
        return json;
    }

    Json uninjured_document(const FieldMetrics& field, const UninjuredOpening& uninjured)
    {
        Json json;
        if (!uninjured.message.empty()) {
            json["message"] = uninjured.message;
        } else {
            put(json, field, "opening_mm", uninjured.opening_mm);
            json["bone"] = uninjured.bone;
            put(json, field, "utilisation", uninjured.utilisation);
            put(json, field, "hook_force_N", uninjured.hook_force_N);
        }
        json["solves"] = uninjured.solves;
        put(json, field, "seconds", uninjured.seconds);
        return json;
    }

    void put_tissue_strain(Json& json, const FieldMetrics& field)
    {
        json["tissue_strain"] = Json::array();
        for (const TissueStrain& tissue : field.tissue_strain) {
            Json of_tissue { { "tissue", tissue.tissue } };
            put(of_tissue, field, "strain", tissue.strain);
            of_tissue["at_mm"] = { tissue.at.x(), tissue.at.y(), tissue.at.z() };
            of_tissue["place"] = tissue.place;
            if (const auto torn = tearing_range(tissue))
                of_tissue["torn_between"] = { torn->from, torn->to };
            json["tissue_strain"].push_back(std::move(of_tissue));
        }
        if (const std::string tearing = tearing_text(field); !tearing.empty())
            json["tearing"] = tearing;
    }

    void put_bones(Json& json, const FieldMetrics& field)
    {
        json["attainable"] = to_string(field.attainable);
        if (field.largest_uninjured_opening_mm) {
            put(json, field, "largest_uninjured_opening_mm", *field.largest_uninjured_opening_mm);
            json["largest_uninjured_opening_is_estimate"] = breaks_bone(field) && !is_uninjured_opening_solved(field);
        }
        if (field.uninjured_opening)
            json["uninjured_opening"] = uninjured_document(field, *field.uninjured_opening);
        json["bones"] = Json::array();
        for (const BoneMetrics& bone : field.bones)
            json["bones"].push_back(bone_document(field, bone));
        if (!field.bones.empty())
            json["bones_rough"] = field.bones_rough;
        if (!field.bones_message.empty())
            json["bones_message"] = field.bones_message;
    }

    Json stiffness_document(const FieldMetrics& field, const BoneStiffness& bone)
    {
        Json json { { "name", bone.name } };
        put(json, field, "modulus_MPa", bone.modulus_MPa);
        json["range_MPa"] = { bone.low_MPa, bone.high_MPa };
        json["found_by"] = to_string(bone.origin);
        if (bone.cut_off_MPa)
            put(json, field, "cut_off_from_MPa", *bone.cut_off_MPa);
        if (bone.origin == StiffnessOrigin::image) {
            put(json, field, bone.material == "bone" ? "cortex_share" : "calcified_share", bone.share);
            if (bone.sections > 0)
                json["sections"] = bone.sections;
        }
        json["source"] = bone.words;
        return json;
    }

    Json parameters_document(const FieldMetrics& field, const ParameterInterval& interval)
    {
        Json json;
        if (!interval.message.empty()) {
            json["message"] = interval.message;
            return json;
        }
        put(json, field, "force_low_N", interval.force_low_N);
        put(json, field, "force_high_N", interval.force_high_N);
        put(json, field, "opening_low_mm", interval.opening_low_mm);
        put(json, field, "opening_high_mm", interval.opening_high_mm);
        json["decided_by"] = deciding_parameters(interval);
        json["parameters"] = Json::array();
        for (const ParameterInfluence& parameter : interval.parameters) {
            Json row { { "name", parameter.name }, { "unit", parameter.unit } };
            put(row, field, "value", parameter.value);
            put(row, field, "low", parameter.low);
            put(row, field, "high", parameter.high);
            put(row, field, "force_exponent", parameter.force_exponent);
            put(row, field, "opening_exponent", parameter.opening_exponent);
            put(row, field, "force_change_percent", parameter.force_change_percent);
            put(row, field, "opening_change_percent", parameter.opening_change_percent);
            row["source"] = parameter.source;
            json["parameters"].push_back(std::move(row));
        }
        json["holds_for"] = "tissue values, to first order at the solution; no part of error_estimate";
        put(json, field, "seconds", interval.seconds);
        return json;
    }

    Json region_document(const FieldMetrics& field, const RegionMetrics& region)
    {
        const auto vector = [](const Vec3& v) { return Json { v.x(), v.y(), v.z() }; };
        Json json;
        put(json, field, "region_mm", region.region_mm);
        json["ended_by"] = to_string(region.ended_by);
        if (!region.message.empty())
            json["message"] = region.message;
        put(json, field, "rim_motion_mm", region.rim_motion_mm);
        if (!region.rim_place.empty()) {
            json["rim_at_mm"] = vector(region.rim_at);
            json["rim_place"] = region.rim_place;
        }
        put(json, field, "image_end_motion_mm", region.image_end_motion_mm);
        json["bones_through_skin"] = Json::array();
        for (const PiercingBone& bone : region.piercing) {
            Json of_bone { { "name", bone.name }, { "at_mm", vector(bone.at) } };
            put(of_bone, field, "out_mm", bone.out_mm);
            json["bones_through_skin"].push_back(std::move(of_bone));
        }
        if (region.drafts > 0) {
            json["drafts"] = region.drafts;
            put(json, field, "seconds", region.seconds);
        }
        if (region.force_change)
            put(json, field, "force_change", *region.force_change);
        return json;
    }

    Json blockers_document(const std::vector<SightBlocker>& blockers)
    {
        Json all = Json::array();
        for (const SightBlocker& blocker : blockers)
            all.push_back({ { "name", blocker.name }, { "share", blocker.share }, { "bone", blocker.bone } });
        return all;
    }

    Json best_eye_document(const FieldMetrics& field, const BestEye& eye)
    {
        Json json { { "at_mm", { eye.at.x(), eye.at.y(), eye.at.z() } },
            { "aim_mm", { eye.aim.x(), eye.aim.y(), eye.aim.z() } } };
        put(json, field, "distance_mm", eye.distance_mm);
        put(json, field, "incidence_deg", eye.incidence_deg);
        put(json, field, "bound_area_mm2", eye.bound_area_mm2);
        json["hidden_by"] = blockers_document(eye.hidden_by);
        return json;
    }

    Json annulus_document(const FieldMetrics& field, const AnnulusAccess& annulus)
    {
        if (!annulus.message.empty())
            return { { "message", annulus.message } };
        Json json { { "centre_mm", { annulus.centre.x(), annulus.centre.y(), annulus.centre.z() } },
            { "normal", { annulus.normal.x(), annulus.normal.y(), annulus.normal.z() } },
            { "normal_is_given", annulus.given } };
        put(json, field, "diameter_mm", annulus.diameter_mm);
        put(json, field, "opening_off_axis_deg", annulus.opening_off_axis_deg);
        if (field.seen_best_eye > 0.0)
            put(json, field, "sight_off_axis_deg", annulus.sight_off_axis_deg);
        put(json, field, "distance_mm", annulus.distance_mm);
        return json;
    }

    Json field_document(const FieldMetrics& field)
    {
        Json json;
        json["name"] = field.name;
        json["target"] = field.target;
        put(json, field, MetricGroup::sight);
        if (field.finger_lacks_mm)
            put(json, field, "finger_lacks_mm", *field.finger_lacks_mm);
        if (field.best_eye_pixels)
            put(json, field, "best_eye_pixels", *field.best_eye_pixels);
        json["best_eye"] = best_eye_document(field, field.best_eye);
        if (field.annulus)
            json["annulus"] = annulus_document(field, *field.annulus);
        json["if_organs_shift"] = Json::array();
        for (const ShiftedSight& shifted : field.if_organs_shift)
            json["if_organs_shift"].push_back(
                { { "shift_mm", shifted.shift_mm }, { "seen_best_eye", shifted.seen_best_eye } });
        if (!field.if_lung_keeps.empty())
            json["if_lung_keeps"] = Json::array();
        for (const LungSight& lung : field.if_lung_keeps)
            json["if_lung_keeps"].push_back(
                { { "volume_share", lung.lung_share }, { "seen_best_eye", lung.seen_best_eye } });
        json["if_turned"] = Json::array();
        for (const TurnedSight& turned : field.if_turned)
            json["if_turned"].push_back(
                { { "left_side_up_deg", turned.left_side_up_deg }, { "seen_best_eye", turned.seen_best_eye } });
        json["estimated"] = field.estimated;
        json["cone"] = { { "eye_distance_mm", field.eye_distance_mm }, { "half_angle_deg", field.cone_half_angle_deg },
            { "eyes", field.eyes }, { "target_samples", field.target_samples } };
        put(json, field, MetricGroup::opening);
        const HookOpening hooks = hook_opening(field);
        if (hooks.asked_mm)
            put(json, field, "hook_opening_asked_mm", *hooks.asked_mm);
        put(json, field, "hook_opening_reached_mm", hooks.reached_mm);
        put(json, field, MetricGroup::distances);
        put(json, field, MetricGroup::force);
        put_forces(json, field);
        if (field.force_moments)
            json["force_moments"] = moments_document(field, *field.force_moments);
        put(json, field, MetricGroup::strain);
        if (field.strain_p99_at) {
            const Vec3& at = *field.strain_p99_at;
            json["strain_p99_at_mm"] = { at.x(), at.y(), at.z() };
        }
        put_tissue_strain(json, field);
        json["may_rupture"] = may_rupture(field);
        put_bones(json, field);
        json["inverted_elements"] = field.inverted_elements;
        if (field.volume_failures)
            json["volume_failures"] = volume_document(field, *field.volume_failures);
        put(json, field, MetricGroup::soundness);
        json["mechanics_status"] = field.mechanics_status;
        json["solution"] = solution_document(field, field.solution);
        json["region"] = region_document(field, field.region);
        put_surfaces(json, field);
        if (field.tension)
            json["tension"] = tension_document(field, *field.tension);
        if (field.error)
            json["error_estimate"] = error_document(field, *field.error);
        if (field.parameters)
            json["parameter_interval"] = parameters_document(field, *field.parameters);
        if (!field.bone_stiffness.empty()) {
            json["bone_stiffness"] = Json::array();
            for (const BoneStiffness& bone : field.bone_stiffness)
                json["bone_stiffness"].push_back(stiffness_document(field, bone));
        }
        if (field.accuracy)
            json["accuracy"] = accuracy_document(field, *field.accuracy);
        if (field.second_opinion)
            json["second_opinion"] = opinion_document(field, *field.second_opinion);
        json["bone_in_sight"] = field.bone_in_sight;
        json["crossed_bones"] = field.crossed_bones;
        json["divided_cartilages"] = field.divided_cartilages;
        json["blockers"] = blockers_document(field.blockers);
        json["at_risk"] = Json::array();
        for (const RiskDistance& risk : field.at_risk)
            json["at_risk"].push_back({ { "name", risk.name }, { "distance_mm", risk.distance_mm },
                { "at_mm", { risk.at.x(), risk.at.y(), risk.at.z() } }, { "is_assumed", risk.is_assumed } });
        json["steel_at_risk"] = Json::array();
        for (const RiskDistance& risk : field.steel_at_risk)
            json["steel_at_risk"].push_back({ { "name", risk.name }, { "from", risk.from },
                { "distance_mm", risk.distance_mm }, { "at_mm", { risk.at.x(), risk.at.y(), risk.at.z() } } });
        json["retracted"] = field.retracted;
        if (field.division)
            json["division"] = division_document(field, *field.division);
        put_removed(json, field);
        json["tets"] = field.tets;
        if (!field.implausible.empty())
            json["implausible"] = field.implausible;
        json["explanation"] = field.explanation;
        const Verdict verdict = verdict_of(field);
        json["verdict"] = { { "light", to_string(verdict.light) }, { "sentences", verdict.sentences } };
        json["seconds"] = Json::object();
        for (const auto& [stage, time] : field.seconds)
            json["seconds"][stage] = time;
        return json;
    }

    /// Motion of a hook's tissue: "31.2", or with its bar "31.2 +- 4.1".
    std::string moved_text(const FieldMetrics& field, std::size_t hook)
    {
        const double moved = field.hooks[hook].moved_mm;
        RETRACTOR_ASSERT(!field.error || !field.error->message.empty() || hook < field.error->hook_moved_mm.size());
        if (field.error && field.error->message.empty())
            return formatted("%.1f +- %.1f", moved, field.error->hook_moved_mm[hook]);
        return in_words(moved, 1);
    }

} // namespace

std::string removed_text(const std::vector<RemovedTissue>& removed)
{
    std::vector<RemovedTissue> sums; // several loose pieces are reported as one
    for (const RemovedTissue& tissue : removed) {
        const auto same = std::find_if(sums.begin(), sums.end(),
            [&](const RemovedTissue& sum) { return sum.what == tissue.what && sum.label == tissue.label; });
        if (same == sums.end())
            sums.push_back(tissue);
        else
            same->volume_mm3 += tissue.volume_mm3;
    }
    std::string text;
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const bool goes_on = i > 0 && sums[i].what == sums[i - 1].what;
        text += (i == 0           ? "taken out: "
                        : goes_on ? ", "
                                  : "; ")
            + (goes_on ? std::string() : sums[i].what + ": ") + volume_text(sums[i].volume_mm3) + " of "
            + sums[i].label;
    }
    return text;
}

std::string division_text(const FieldMetrics& field)
{
    if (!field.division)
        return {};
    const DividedTissue& division = *field.division;
    if (!(division.beyond_mm() > 0.0))
        return division.words;
    return (division.words.empty() ? "divided beyond the skin: " + division_cell(field) : division.words)
        + formatted("; the division is %.0f mm long with the incision, and severs %.1f cm2 beyond it",
            division.length_mm, 1e-2 * division.severed_mm2);
}

std::string estimated_text(const FieldMetrics& field)
{
    if (field.estimated.empty())
        return {};
    std::vector<std::string> names;
    for (const std::string& name : field.estimated)
        names.push_back(readable(name));
    return "estimated, not seen in the image: " + joined(names);
}

std::string shifted_sight_text(const FieldMetrics& field)
{
    std::string text;
    for (const ShiftedSight& shifted : field.if_organs_shift)
        text += (text.empty() ? "with the organs " : ", ") + formatted("%.0f mm", shifted.shift_mm)
            + (text.empty() ? " nearer to the head the best eye sees " : " ")
            + formatted("%.1f %%", 100.0 * shifted.seen_best_eye);
    for (const LungSight& lung : field.if_lung_keeps)
        text += (text.empty()                                   ? ""
                        : &lung == &field.if_lung_keeps.front() ? "; "
                                                                : ", ")
            + formatted(
                "past a lung of %.0f %% of its volume %.1f %%", 100.0 * lung.lung_share, 100.0 * lung.seen_best_eye);
    return text;
}

std::string division_cell(const FieldMetrics& field)
{
    if (!field.division)
        return "skin only";
    if (!(field.division->beyond_mm() > 0.0))
        return "skin only, although more was asked for";
    if (const double across = field.division->right_mm + field.division->left_mm; across > 0.0)
        return formatted("%.0f mm across the sternum", across);
    return formatted("%.0f mm backwards, %.0f mm forwards", field.division->backwards_mm, field.division->forwards_mm);
}

std::string skin_hole_text(const FieldMetrics& field)
{
    if (!(field.removed_skin_mm2 > 0.0))
        return {};
    return formatted(
        "the hole of the removed skin (%.1f cm2 at rest) is not part of the opening", 1e-2 * field.removed_skin_mm2);
}

std::string error_text(const FieldMetrics& field)
{
    if (!field.error)
        return "error not estimated";
    if (!field.error->message.empty())
        return "error not estimated: " + field.error->message;
    const ErrorBars& error = *field.error;
    return formatted("opening %.1f mm +- %.1f", field.opening_width_mm, error.opening_width_mm)
        + (forces_are_known(field) ? formatted(" under a known force of %.1f N", field.hook_force_N)
                                   : formatted(", force %.1f N +- %.1f", field.hook_force_N, error.hook_force_N))
        + formatted(", seen %.1f %% +- %.1f", 100.0 * field.seen_best_eye, 100.0 * error.seen_best_eye)
        + formatted(" (discretisation error, estimated in %.1f s)", error.seconds);
}

bool forces_are_known(const FieldMetrics& field)
{
    return !field.hooks.empty() && std::all_of(field.hooks.begin(), field.hooks.end(), [](const HookForce& hook) {
        return hook.pull.force_N.has_value() || hook.yielded;
    });
}

std::string tension_text(const FieldMetrics& field)
{
    RETRACTOR_ASSERT(field.tension);
    const TensionMetrics& tension = *field.tension;
    std::string text = "tension before the cut: ";
    for (std::size_t i = 0; i < tension.tissues.size(); ++i)
        text += (i == 0 ? "" : "; ") + tension.tissues[i].first + " " + pre_strain_text(tension.tissues[i].second);
    if (!tension.message.empty())
        return text + "; the gape without hooks was not computed: " + tension.message;
    return text
        + (field.pressures.empty() ? "; by this tension alone the wound gapes "
                                   : "; by tension and pressure, without hooks, the wound gapes ")
        + in_words(tension.gape_mm, 1) + " mm (" + in_words(tension.gape_area_mm2 / 100.0, 1) + " cm2)";
}

std::string contact_text(const FieldMetrics& field)
{
    RETRACTOR_ASSERT(field.contact);
    const ContactMetrics& contact = *field.contact;
    std::string text = "contact: nothing touches";
    if (!contact.computed && !contact.needed)
        text = "contact: not tested: " + contact.message;
    else if (!contact.computed && *contact.needed)
        text = "contact: "
            + (contact.with.empty() ? std::string("the wall passes through itself")
                                    : "the wall passes through the " + readable(contact.with))
            + formatted(" by up to %.1f mm, %s in the opened wound, which contact would prevent; contact was not "
                        "computed: %s",
                contact.largest_penetration_mm,
                (contact.place.empty() ? "at " + in_words(contact.at) : contact.place).c_str(),
                contact.message.c_str());
    else if (sinks_in(contact))
        text = formatted("contact: the wall sinks up to %.1f mm into the %s, which gives way",
            contact.largest_penetration_mm, readable(contact.with).c_str());
    else if (contact.touching != 0)
        text = formatted("contact: %zu points touch, with %.1f N in total and a penetration of at most %.2f mm",
            contact.touching, contact.force_N, contact.largest_penetration_mm);
    if (contact.overlap_at_rest_mm > 0.0)
        text += formatted(
            "; surfaces that overlap by up to %.2f mm at rest keep this overlap", contact.overlap_at_rest_mm);
    return text;
}

bool sinks_in(const ContactMetrics& contact)
{
    constexpr double kWorthSayingMm = 1.0;
    return !contact.computed && !contact.needed.value_or(true) && !contact.with.empty()
        && contact.largest_penetration_mm >= kWorthSayingMm;
}

bool passes_through(const FieldMetrics& field)
{
    return field.contact && !field.contact->computed && field.contact->needed.value_or(false);
}

std::string hooks_text(const FieldMetrics& field)
{
    std::string text;
    for (std::size_t i = 0; i < field.hooks.size(); ++i) {
        const HookForce& hook = field.hooks[i];
        if (hook.pull.prescribes() && !hook.pushes)
            continue;
        text += (text.empty() ? "hook " : "; ") + hook.name
            + (hook.pushes ? " holds back its lip, which would move farther without the hook:" : "");
        if (hook.pull.prescribes())
            text += formatted(" %.1f N", hook.force_N);
        else if (hook.pull.force_N)
            text += formatted(" pulls with %.1f N: %s mm", hook.force_N, moved_text(field, i).c_str());
        else
            text += formatted("%s at %.1f N: %s of %.1f mm",
                hook.yielded ? " yields" : (hook.pull.grip_N_per_mm ? " grips softly" : " holds"), hook.force_N,
                moved_text(field, i).c_str(), hook.asked_mm);
    }
    return text;
}

std::string thirds_text(const BladePressure& pressure)
{
    const auto& [first, middle, last] = pressure.thirds_N;
    if (!(first + middle + last > 0.0))
        return {};
    return formatted(
        "%.0f, %.0f and %.0f N on its first, middle and last third along the incision", first, middle, last);
}

std::string blade_text(const BladeMetrics& blade)
{
    return formatted(
               "%.1f N and %.2f N m, turned %.1f degrees", blade.force_N.norm(), blade.moment_Nm.norm(), blade.turn_deg)
        + (blade.at_stop ? " (the end of its play)" : "")
        + formatted(", the lip follows within %.1f mm", blade.lip_deviation_mm)
        + (blade.pressure ? formatted(", pressure %.0f kPa on average and %.0f kPa at most (%s)",
               blade.pressure->mean_kPa, blade.pressure->largest_kPa, blade.pressure->largest_at.c_str())
                          : "")
        + (blade.pressure && !thirds_text(*blade.pressure).empty() ? ", " + thirds_text(*blade.pressure) : "");
}

std::string retractor_text(const FieldMetrics& field)
{
    if (!field.retractor)
        return {};
    const RetractorMetrics& retractor = *field.retractor;
    std::string text = formatted("the %s opens %.1f mm with %.1f N along its rack",
        instrument_name(retractor.kind).c_str(), retractor.opening_mm, retractor.rack_force_N);
    for (const BladeMetrics& blade : retractor.blades)
        text += "; " + readable(blade.name) + ": " + blade_text(blade);
    return text
        + (retractor.hand_moment_Nm
                ? formatted("; the free frame found no balance: a hand or an arm at the table holds its direction with "
                            "%.2g N m, and %.2g N of its blade forces are not balanced",
                    *retractor.hand_moment_Nm, retractor.residual_force_N)
                : formatted("; the frame has tilted by %.1f degrees, and %.2g N of its blade forces are not balanced",
                    retractor.tilt_deg, retractor.residual_force_N))
        + (retractor.contact_was_lost
                ? "; blades that only push found no equilibrium, so the blades hold the tissue as if glued to it: "
                  "the force may be far off"
                : "");
}

std::string lip_name(const FieldMetrics& field, int side)
{
    if (field.retractor && field.retractor->blades.size() == 2)
        return "lip at the " + readable(field.retractor->blades[side > 0 ? 0 : 1].name);
    return side > 0 ? "left lip" : "right lip";
}

std::string lips_text(const FieldMetrics& field)
{
    std::string text;
    for (const LipDeviation& lip : field.lip_deviation)
        remark(text,
            formatted(
                "the %s lies up to %.1f mm (mean %.1f mm) off the line of its %s, most %.0f mm along the incision",
                lip_name(field, lip.side).c_str(), lip.largest_mm, lip.mean_mm, field.retractor ? "blade" : "hooks",
                lip.at_mm));
    return text;
}

std::string solution_text(const FieldMetrics& field)
{
    const SolutionMetrics& solution = field.solution;
    std::string text = (solution.draft ? "a draft, solved as " : "solved as ") + solution_text(solution.choice), others;
    for (const auto& [material, law] : solution.laws)
        if (law != fem::law_name(fem::NeoHookean {}))
            others += (others.empty() ? "" : ", ") + material + ": " + law;
    if (!solution.laws.empty())
        text += "; neo-Hookean" + (others.empty() ? "" : " but " + others);
    if (solution.choice.near_mm > 0.0)
        text += formatted("; %zu of %zu elements nonlinear", solution.near_tets, field.tets);
    if (solution.far)
        text += far_text(field, *solution.far);
    return solution.whole ? text + "; the whole wall nonlinear: " + whole_text(*solution.whole) : text;
}

std::string opinion_text(const SecondOpinion& opinion)
{
    if (opinion.status == "failed")
        return "second opinion: none, " + opinion.message;
    return formatted(
        "second opinion by %s %s: linear, displacements within %.1e of the largest (%.2f mm), hook forces within %.1e "
        "(%.1f s; ours %.1f s)",
        opinion.program.c_str(), opinion.status.c_str(), opinion.displacement_difference,
        opinion.largest_displacement_mm, opinion.force_difference, opinion.seconds, opinion.own_seconds);
}

nlohmann::ordered_json metrics_document(const std::vector<FieldMetrics>& fields)
{
    Json document;
    document["frame"] = "LPS";
    document["units"] = { { "length", "mm" }, { "force", "N" }, { "stress", "MPa" }, { "time", "s" } };
    document["approaches"] = Json::array();
    for (const FieldMetrics& field : fields)
        document["approaches"].push_back(field_document(field));
    return document;
}

std::string bearing_text(const HookForce& hook)
{
    std::vector<std::string> names;
    for (const std::string& name : hook.bears_on)
        names.push_back(readable(name));
    return names.empty() ? "soft tissue only" : joined(names);
}

std::vector<std::string> bones_in_sight(const FieldMetrics& field)
{
    std::vector<std::string> words;
    for (const std::string& bone : field.bone_in_sight)
        words.push_back(readable(bone));
    return words;
}

std::string risk_text(const RiskDistance& risk)
{
    const std::string name = risk_name(risk);
    if (!risk.from.empty())
        return readable(risk.from) + " to " + name + " " + in_words(risk.distance_mm, 1) + " mm";
    return risk.distance_mm > 0.0 ? name + " " + in_words(risk.distance_mm, 1) + " mm"
                                  : name + ": the blade passes through it";
}

std::string risks_text(const FieldMetrics& field)
{
    std::vector<std::string> words;
    for (const RiskDistance& risk : field.at_risk)
        words.push_back(risk_text(risk));
    std::string text = "from the blade to structures at risk: " + joined(words);
    words.clear();
    for (const RiskDistance& risk : field.steel_at_risk)
        words.push_back(risk_text(risk));
    return words.empty() ? text : text + "; in the opened wound: " + joined(words);
}

} // namespace retractor::planner
