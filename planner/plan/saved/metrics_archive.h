#pragma once
// How cereal writes and reads an approach, the numbers of its planned field, and the meshes that its pictures need.

#include "fem/statics/boundary_conditions.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/measures/field_metrics.h"
#include "planner/measures/sight/exposure.h"
#include "planner/measures/sight/surgeon_eye.h"
#include "planner/wall/field_geometry.h"

#include <cereal/types/array.hpp>
#include <cereal/types/optional.hpp>
#include <cereal/types/string.hpp>
#include <cereal/types/utility.hpp>
#include <cereal/types/vector.hpp>

#include <Eigen/Core>

namespace Eigen {

template <class Archive, int Rows, int Columns, int Options, int MaxRows, int MaxColumns>
void save(Archive& archive, const Matrix<double, Rows, Columns, Options, MaxRows, MaxColumns>& matrix)
{
    archive(matrix.rows(), matrix.cols());
    archive(cereal::binary_data(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double)));
}

template <class Archive, int Rows, int Columns, int Options, int MaxRows, int MaxColumns>
void load(Archive& archive, Matrix<double, Rows, Columns, Options, MaxRows, MaxColumns>& matrix)
{
    Index rows = 0, columns = 0;
    archive(rows, columns);
    if (rows < 0 || columns < 0 || (Rows != Dynamic && rows != Rows) || (Columns != Dynamic && columns != Columns))
        throw cereal::Exception("a matrix of another shape");
    matrix.resize(rows, columns);
    archive(cereal::binary_data(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double)));
}

} // namespace Eigen

/// The members of a struct in their order. A member that is missing here does not compile.
#define RETRACTOR_ARCHIVE(Struct, ...)                                                                                 \
    template <class Archive> void serialize(Archive& archive, Struct& archived)                                        \
    {                                                                                                                  \
        auto& [__VA_ARGS__] = archived;                                                                                \
        archive(__VA_ARGS__);                                                                                          \
    }

namespace retractor {
RETRACTOR_ARCHIVE(TriMesh, vertices, triangles, labels)
}

namespace retractor::mesh {
RETRACTOR_ARCHIVE(TetMesh, vertices, nodes_per_tet, nodes, labels)
}

namespace retractor::fem {
RETRACTOR_ARCHIVE(PreStrain, kind, strain, pull, normal, across)
RETRACTOR_ARCHIVE(HookPatch, name, side, nodes, displacement, rotation, pivot)
} // namespace retractor::fem

namespace retractor::planner {
RETRACTOR_ARCHIVE(AccuracyGoal, force, opening_mm, time_s)
RETRACTOR_ARCHIVE(SolverSettings, elasticity, element, near_mm, accuracy)
RETRACTOR_ARCHIVE(SizingSpec, corridor_radius_mm, corridor_edge_mm, coarse_edge_mm, region_mm, coarse_beyond_mm,
    mesh_seed, patch_edge_mm)
RETRACTOR_ARCHIVE(HookPull, force_N, force_limit_N, grip_N_per_mm)
RETRACTOR_ARCHIVE(OpeningProtocol, turn_mm, turns_per_step, wait_s, hold_s)
RETRACTOR_ARCHIVE(DivisionStroke, way, severs, line, directions, depth_mm, length_mm)
RETRACTOR_ARCHIVE(Division, extent, forwards_mm, backwards_mm, strokes, words)
RETRACTOR_ARCHIVE(HookSpec, name, side, along_mm, depth_mm, patch_width_mm, patch_height_mm, direction, opening_mm,
    pull, hold, bearing, bears_on)
RETRACTOR_ARCHIVE(RetractorSpec, kind, opening_mm, force_N, along_mm, blade_width_mm, blade_depth_mm, play_deg,
    greatest_opening_mm, hold)
RETRACTOR_ARCHIVE(TargetSpec, label, centre, radius_mm, site, normal)
RETRACTOR_ARCHIVE(ViewSpec, eye_distance_mm, half_angle_deg, eye_count)
RETRACTOR_ARCHIVE(AblationSpec, label, from_mm, to_mm, along_from_mm, along_to_mm, centre, radius_mm)
/// Without the title: it is another one as soon as somebody renames the approach, and the case knows it.
template <class Archive> void serialize(Archive& archive, Approach& approach)
{
    auto& [name, title, template_name, incision, directions, depth_mm, wall_thickness_mm, hook_depth_mm, target, hooks,
        retractor, opening_protocol, retracted, uncut_labels, division, ablations, loose_pieces, sizing, view,
        rationale]
        = approach;
    archive(name, template_name, incision, directions, depth_mm, wall_thickness_mm, hook_depth_mm, target, hooks,
        retractor, opening_protocol, retracted, uncut_labels, division, ablations, loose_pieces, sizing, view,
        rationale);
}
RETRACTOR_ARCHIVE(PressureMetrics, label, pressure_kPa, area_mm2, behind_gap_mm2, force_N, follows)
RETRACTOR_ARCHIVE(
    BoneStiffness, label, name, material, origin, modulus_MPa, low_MPa, high_MPa, cut_off_MPa, share, sections, words)
RETRACTOR_ARCHIVE(DividedTissue, labels, length_mm, forwards_mm, backwards_mm, right_mm, left_mm, severed_mm2, words)
RETRACTOR_ARCHIVE(RemovedTissue, what, label, volume_mm3)
RETRACTOR_ARCHIVE(PiercingBone, name, out_mm, at)
RETRACTOR_ARCHIVE(OpeningGeometry, area_mm2, overlap_area_mm2, width_mm, length_mm, incision_length_mm, centre, normal,
    along, start, end)
RETRACTOR_ARCHIVE(SightShare, name, share)
RETRACTOR_ARCHIVE(SurgeonEye, status, eye, aim, seen_fraction, bound_area_mm2, picture_share, incidence_deg,
    two_eyes_fraction, two_instruments_fraction, finger_fraction, finger_lacks_mm, freedom_mm2, two_instruments_reach,
    finger_touches, hidden_by)
RETRACTOR_ARCHIVE(ViewCone, aim, axis, up, eye_distance_mm, half_angle_deg, eyes)
RETRACTOR_ARCHIVE(EyeView, eye, visible_fraction)
RETRACTOR_ARCHIVE(SurfaceSample, position, triangle)
RETRACTOR_ARCHIVE(SightBlocker, name, share, bone)
RETRACTOR_ARCHIVE(RiskDistance, name, distance_mm, at, from, is_assumed)
RETRACTOR_ARCHIVE(HookForce, name, side, force_N, pushes, moved_mm, asked_mm, pull, yielded, bears_on)
RETRACTOR_ARCHIVE(BladePressure, mean_kPa, largest_kPa, largest_at, touching_mm2, on_bone_N, thirds_N, penetration_mm)
RETRACTOR_ARCHIVE(BladeMetrics, name, force_N, moment_Nm, turn_deg, at_stop, lip_deviation_mm, pressure)
RETRACTOR_ARCHIVE(RetractorMetrics, kind, asked_force_N, opening_mm, rack_force_N, blades, residual_force_N,
    residual_moment_Nm, hand_moment_Nm, tilt_deg, contact_was_lost)
RETRACTOR_ARCHIVE(
    ForceMoments, message, peak_N, held_N, held_least_N, held_most_N, opened_in_s, hold_s, protocol, is_fast, source)
RETRACTOR_ARCHIVE(WholeMetrics, message, opening_width_mm, opening_area_mm2, hook_force_N, lips_difference, seconds)
RETRACTOR_ARCHIVE(
    CondensedRegionMetrics, linear, linear_share, message, opening_width_mm, opening_area_mm2, hook_force_N)
RETRACTOR_ARCHIVE(TensionMetrics, tissues, message, gape_mm, gape_area_mm2, seconds)
RETRACTOR_ARCHIVE(SolutionMetrics, choice, mesh, draft, nodes, laws, near_tets, far, whole)
RETRACTOR_ARCHIVE(EnergyBars, energy_error, algebraic_error)
RETRACTOR_ARCHIVE(ErrorBars, message, opening_width_mm, opening_area_mm2, seen_best_eye, hook_forces_N, hook_moved_mm,
    side_forces_N, hook_force_N, energy, seconds)
RETRACTOR_ARCHIVE(ParameterInfluence, name, unit, value, low, high, force_exponent, opening_exponent,
    force_change_percent, opening_change_percent, source)
RETRACTOR_ARCHIVE(
    ParameterInterval, message, force_low_N, force_high_N, opening_low_mm, opening_high_mm, parameters, seconds)
RETRACTOR_ARCHIVE(RegionMetrics, region_mm, ended_by, message, rim_motion_mm, rim_at, rim_place, image_end_motion_mm,
    piercing, drafts, force_change, seconds)
RETRACTOR_ARCHIVE(AccuracyMetrics, asked, reached_force, reached_opening_mm, rounds, edge_mm, ended_by, message)
RETRACTOR_ARCHIVE(SecondOpinion, program, status, message, displacement_difference, force_difference,
    largest_displacement_mm, hook_forces_N, own_hook_forces_N, seconds, own_seconds)
RETRACTOR_ARCHIVE(ContactMetrics, needed, computed, touching, largest_penetration_mm, at, place, with, force_N,
    overlap_at_rest_mm, message)
RETRACTOR_ARCHIVE(VolumeFailures, elements, share, smallest_ratio, largest_ratio, at, place, believable)
RETRACTOR_ARCHIVE(JointLoad, force_N, moment_Nm, turn_deg, at_stop)
RETRACTOR_ARCHIVE(BoneMetrics, name, at_mm, length_mm, part, place, section_mm2, bending_Nm, torsion_Nm, moment_Nm,
    capacity_Nm, utilisation, opening_at_limit_mm, spine_joint, cartilage)
RETRACTOR_ARCHIVE(TissueStrain, tissue, strain, at, place)
RETRACTOR_ARCHIVE(LipDeviation, side, largest_mm, mean_mm, at_mm, from_mm, to_mm, curve)
RETRACTOR_ARCHIVE(UninjuredOpening, message, opening_mm, bone, utilisation, hook_force_N, solves, seconds)
RETRACTOR_ARCHIVE(BestEye, at, aim, distance_mm, incidence_deg, bound_area_mm2, hidden_by)
RETRACTOR_ARCHIVE(ShiftedSight, shift_mm, seen_best_eye)
RETRACTOR_ARCHIVE(LungSight, lung_share, seen_best_eye)
RETRACTOR_ARCHIVE(TurnedSight, left_side_up_deg, seen_best_eye)
RETRACTOR_ARCHIVE(
    AnnulusAccess, message, centre, normal, given, diameter_mm, opening_off_axis_deg, sight_off_axis_deg, distance_mm)
RETRACTOR_ARCHIVE(FieldMetrics, name, target, target_spec, seen_best_eye, seen_two_eyes, reached_by_two_instruments,
    reached_by_finger, finger_lacks_mm, surgical_freedom_mm2, best_eye_picture, best_eye_pixels, best_eye, annulus,
    access_horizontal_deg, access_vertical_deg, coaxiality_deg, visible_fraction, visible_fraction_mean_eye,
    visible_fraction_central_eye, visible_fraction_wall_removed, eye_distance_mm, cone_half_angle_deg, eyes,
    target_samples, blockers, bone_in_sight, if_organs_shift, if_lung_keeps, if_turned, estimated, steel_at_risk,
    at_risk, retracted, opening_area_mm2, opening_width_mm, working_distance_mm, opening_solid_angle_sr,
    attack_along_deg, attack_across_deg, target_offset_mm, incision_length_mm, cut_depth_mm, crossed_bones,
    divided_cartilages, hooks, retractor, hook_force_N, force_moments, strain_p99, strain_p99_at, tissue_strain,
    lip_deviation, bones, bones_rough, bones_message, attainable, largest_uninjured_opening_mm, uninjured_opening,
    inverted_elements, max_volume_ratio, volume_failures, residual, mechanics_status, solution, division, removed,
    removed_skin_mm2, loose_pieces, region, tets, seconds, contact, pressures, tension, error, parameters,
    bone_stiffness, accuracy, second_opinion, implausible, explanation)
} // namespace retractor::planner

#undef RETRACTOR_ARCHIVE
