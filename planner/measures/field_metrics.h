#pragma once
// The numbers of one planned surgical field, as plain data for metrics.json, the report and the legends.
// Units mm, N; fractions 0 to 1. Definitions: docs/user/numbers.md.

#include "fem/material/tissue_tension.h"
#include "mesh/base/geometry.h"
#include "planner/anatomy/bone_stiffness.h"
#include "planner/case/approach.h"
#include "planner/case/solver_settings.h"
#include "planner/measures/sight/annulus.h"
#include "planner/wall/bones_through_skin.h"
#include "planner/wall/divided_tissue.h"
#include "planner/wall/removed_tissue.h"
#include "planner/wall/wall_pressure.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

/// A structure between the eyes and the target. The share counts the sight lines that meet this structure first.
struct SightBlocker {
    std::string name;
    double share = 0.0;
    bool bone = false;
};

/// A structure with the role at-risk, beside the blade at rest.
struct RiskDistance {
    std::string name;
    double distance_mm = 0.0; ///< 0: the blade passes through the structure
    Vec3 at = Vec3::Zero(); ///< the place of the structure that is nearest to the blade, mm
    std::string from {}; ///< the hook or the retractor's blade; empty: the blade that cuts
    bool is_assumed = false; ///< no label shows it, and its place is assumed (Case::assumed_vessels)
};

struct HookForce {
    std::string name;
    int side = 0; ///< lip that the hook pulls, +1 or -1
    double force_N = 0.0;
    /// The hook holds the lip back, which would move farther without it; its force is no part of the side's sum.
    bool pushes = false;
    double moved_mm = 0.0; ///< motion of the tissue under the hook
    double asked_mm = 0.0; ///< prescribed motion of the hook; 0 for a hook that pulls with a force
    HookPull pull {};
    bool yielded = false; ///< the force limit holds the hook back
    std::vector<std::string> bears_on {}; ///< labels of bones that the hook moves with it; empty: soft tissue only
};

/// Pressure between a blade in contact and the tissue (fem/model/blade_contact.h).
struct BladePressure {
    double mean_kPa = 0.0; ///< normal force over the area that touches
    double largest_kPa = 0.0; ///< mean over a square of 5 mm, where it is largest
    /// Where: "skin", "deep", "start" or "end" (of the incision), the edge within a quarter of the blade; or "middle".
    std::string largest_at {};
    double touching_mm2 = 0.0; ///< area of the lip that touches
    double on_bone_N = 0.0; ///< part of the normal force on bone behind soft tissue
    std::array<double, 3> thirds_N {}; ///< normal force on each third of the blade, in the direction of the incision
    double penetration_mm = 0.0; ///< depth to which tissue passes into the blade: an error of the computation
};

/// One blade of a retractor.
struct BladeMetrics {
    std::string name; ///< of the hook in FieldMetrics::hooks
    Vec3 force_N = Vec3::Zero(); ///< that the blade applies to the tissue; patient LPS
    Vec3 moment_Nm = Vec3::Zero(); ///< about the place of the blade's arm, N m
    double turn_deg = 0.0; ///< turn about the arm
    bool at_stop = false; ///< the play ends here, and the arm bears a moment
    /// Largest distance of the lip's edge, over the width of the blade, from the straight line of the blade: how far
    /// the lip does not follow.
    double lip_deviation_mm = 0.0;
    std::optional<BladePressure> pressure {}; ///< of a blade in contact
};

/// The retractor that holds the wound open.
struct RetractorMetrics {
    std::string kind;
    std::optional<double> asked_force_N {}; ///< force along the rack, where the retractor was driven by force
    double opening_mm = 0.0; ///< distance that the rack has opened
    double rack_force_N = 0.0; ///< force along the rack at each blade
    std::vector<BladeMetrics> blades {}; ///< two
    double residual_force_N = 0.0; ///< resultant of the blade forces; zero in balance
    double residual_moment_Nm = 0.0; ///< resultant moment that nothing bears; zero in balance
    /// Moment with which a hand or an arm at the table holds the frame's direction; not set: the tissue holds it.
    std::optional<double> hand_moment_Nm {};
    double tilt_deg = 0.0; ///< by which the frame has turned as a whole
    bool contact_was_lost = false; ///< the blades hold the tissue, because their contact had no equilibrium
};

/// The force on a side at two moments (force_moments.h).
struct ForceMoments {
    std::string message {}; ///< reason for missing forces; empty: the forces are there
    double peak_N = 0.0; ///< at the last turn of the crank
    double held_N = 0.0; ///< `hold_s` later
    double held_least_N = 0.0, held_most_N = 0.0; ///< one standard deviation between animals about held_N
    double opened_in_s = 0.0; ///< from the first turn to the last
    double hold_s = 0.0;
    std::string protocol {}; ///< "half a turn of the crank (7 mm) every 10 s"
    bool is_fast = false; ///< faster than half a turn of the crank in 10 s
    std::string source {}; ///< of the relaxation
};

/// The same wound solved with the whole wall nonlinear, to measure the effect of the linear region.
struct WholeMetrics {
    std::string message {}; ///< reason for missing numbers; empty: the numbers are there
    double opening_width_mm = 0.0, opening_area_mm2 = 0.0, hook_force_N = 0.0;
    /// Largest distance between the two solutions at the lips, divided by the largest displacement.
    double lips_difference = 0.0;
    double seconds = 0.0;
};

/// The linear tissue far from the lips.
struct CondensedRegionMetrics {
    bool linear = true; ///< false: the linear tissue was too inexact, and the whole wall was made nonlinear
    double linear_share = 1.0; ///< if not linear: share of the hooks' motion that was solved with linear tissue
    std::string message {}; ///< if linear: reason for a missing estimate; empty: the estimate is there
    /// If linear: the change by the tissue's own law there, to first order (OpeningOptions::far_tolerance).
    double opening_width_mm = 0.0, opening_area_mm2 = 0.0, hook_force_N = 0.0;
};

/// Tension of the tissue before the cut, and its effect on the wound without hooks.
struct TensionMetrics {
    /// Materials of the wall under tension, with their pre-strain.
    std::vector<std::pair<std::string, fem::PreStrain>> tissues;
    std::string message {}; ///< reason for a missing gape; empty: the gape is there
    double gape_mm = 0.0, gape_area_mm2 = 0.0; ///< opening width and area before any hook pulls
    double seconds = 0.0; ///< time of the computation
};

/// How the wound was solved.
struct SolutionMetrics {
    SolverSettings choice {};
    SizingSpec mesh {}; ///< the sizes that were asked of the mesh, and its seed
    bool draft = false; ///< a quick plan: coarse mesh, four-node elements, no error bars
    std::size_t nodes = 0; ///< number of nodes of the wall, with midpoints
    std::vector<std::pair<std::string, std::string>> laws {}; ///< material and law of hyperelastic tissue
    std::size_t near_tets = 0; ///< number of nonlinear elements, where the rest is linear
    std::optional<CondensedRegionMetrics> far {}; ///< filled when there was linear tissue and an equilibrium
    std::optional<WholeMetrics> whole {}; ///< the whole wall nonlinear; filled on request
};

/// Error in energy of a solution by plain four-node elements with one elasticity.
struct EnergyBars {
    double energy_error = 0.0; ///< relative error in energy norm
    double algebraic_error = 0.0; ///< the part of energy_error that comes from the unsolved residual
};

/// Error bars of the mechanics: the first-order change of the solution by ten-node elements on the same mesh
/// (fem/error_estimation/error_estimate.h). The bars cover the discretisation only; the model, its materials and its
/// supports may be off by more. Hooks that pull with a force follow the changed solution
/// (hook_equilibrium_correction.h).
struct ErrorBars {
    std::string message; ///< reason for a missing estimate; empty: the estimate is there
    double opening_width_mm = 0.0, opening_area_mm2 = 0.0;
    double seen_best_eye = 0.0; ///< of FieldMetrics::seen_best_eye
    std::vector<double> hook_forces_N; ///< in the order of the hooks; 0 where the force is prescribed
    std::vector<double> hook_moved_mm; ///< in the order of the hooks; 0 where the place of the hook is prescribed
    double side_forces_N[2] = { 0.0, 0.0 }; ///< sides +1 and -1
    double hook_force_N = 0.0; ///< sum of the larger side
    std::optional<EnergyBars> energy; ///< filled where it is known
    double seconds = 0.0;
};

/// What a stiffness that may be other than it is does to force and opening (planner/plan/parameter_interval.h).
struct ParameterInfluence {
    std::string name; ///< of the tissue, or of the springs
    std::string unit; ///< of the values: "MPa", "N m/rad" or "1"
    double value = 0.0; ///< as planned with
    double low = 0.0, high = 0.0; ///< one standard deviation of the value's logarithm to either side
    /// Derivatives of the logarithms of force and opening by that of the value: the share by which the force grows over
    /// the share by which the value grows.
    double force_exponent = 0.0, opening_exponent = 0.0;
    double force_change_percent = 0.0, opening_change_percent = 0.0; ///< with the value `high`
    std::string source; ///< of the range
};

/// The interval of force and opening from the ranges of the tissue values. It stands beside the error bars of the
/// discretisation and is no part of them.
struct ParameterInterval {
    std::string message {}; ///< reason for a missing interval; empty: the interval is there
    double force_low_N = 0.0, force_high_N = 0.0; ///< of the larger side
    double opening_low_mm = 0.0, opening_high_mm = 0.0; ///< of the opening's width
    std::vector<ParameterInfluence> parameters {}; ///< the largest influence first
    double seconds = 0.0; ///< time of the computation
};

/// Why a search for an accuracy ended (planner/plan/accurate_plan.h).
enum class AccuracyEnd {
    reached, ///< the bars are as small as asked
    time, ///< the next mesh would take longer than asked
    memory, ///< the next mesh would need more memory than there is
    rounds, ///< on the finest of the meshes that a search may make
    failure, ///< the plan has no equilibrium, or the next mesh gave no answer
};

/// Why a region is as large as it is (planner/plan/found_region.h).
enum class RegionEnd {
    not_searched, ///< the plan was made with the first region
    given, ///< the approach gives it
    still, ///< the tissue beyond hardly moves in a draft of the whole wall
    whole, ///< the region is the whole wall in the image
    memory, ///< a larger region needs more memory than there is
    failure, ///< the draft of the whole wall gave no answer
};

/// The meshed region of the wall, and what its limit does to the plan.
struct RegionMetrics {
    double region_mm = 0.0; ///< largest distance of its soft tissue from the incision; 0: the whole wall
    RegionEnd ended_by = RegionEnd::not_searched;
    std::string message {}; ///< if ended by a failure: the reason
    double rim_motion_mm = 0.0; ///< largest motion of tissue or bone where the region ends inside the image
    Vec3 rim_at = Vec3::Zero(); ///< where, at rest, mm
    std::string rim_place {}; ///< where, in words; empty: the region has no rim inside the image
    double image_end_motion_mm = 0.0; ///< largest motion where the image ends
    std::vector<PiercingBone> piercing {}; ///< bones that come out through the skin: a failure
    int drafts = 0; ///< number of drafts by which the region was found
    /// Change of the force between the draft of the whole wall and that of the region, over the force: the error that
    /// the region leaves. Not set: there were fewer than two drafts, or there is no force.
    std::optional<double> force_change {};
    double seconds = 0.0; ///< time of the search
};

/// The asked accuracy, and the reached one.
struct AccuracyMetrics {
    AccuracyGoal asked {};
    /// Half-width of the force's bar over the force; not set: the force is known or missing, or there are no bars.
    std::optional<double> reached_force {};
    std::optional<double> reached_opening_mm {}; ///< half-width of the opening's bar; not set: there are no bars
    int rounds = 1; ///< number of meshes that gave an answer
    double edge_mm = 0.0; ///< edge length round the incision in the finest of these meshes
    AccuracyEnd ended_by = AccuracyEnd::reached;
    std::string message {}; ///< if ended by a failure: the reason
};

/// The opened wound solved again, linearly, by another program with the same mesh, element, supports and hooks.
struct SecondOpinion {
    std::string program;
    std::string status; ///< "agrees", "differs", "failed"
    std::string message; ///< reason of a failure, and the remedy
    double displacement_difference = 0.0; ///< largest difference divided by the largest displacement
    double force_difference = 0.0; ///< largest difference of a hook divided by the largest hook force
    double largest_displacement_mm = 0.0;
    std::vector<double> hook_forces_N, own_hook_forces_N; ///< of the linear solutions, in the order of the hooks
    double seconds = 0.0, own_seconds = 0.0;
};

/// Contact of the lips with each other, and of the wall with organs that stay; filled unless contact was refused.
struct ContactMetrics {
    /// Whether surfaces pass through each other where contact is not computed; not set: not tested, because contact was
    /// asked for in any case, or because of `message`.
    std::optional<bool> needed {};
    bool computed = true; ///< false: surfaces may pass through each other
    std::size_t touching = 0; ///< number of points in contact; 0 without contact
    /// Where contact is computed: what the penalty leaves. Where it is not: how far surfaces pass through each other.
    double largest_penetration_mm = 0.0;
    Vec3 at = Vec3::Zero(); ///< place of the largest penetration in the opened wound, mm; zero without one
    std::string place {}; ///< the same place in words, beside the incision at rest; empty: not known
    std::string with {}; ///< label of the organ of the largest penetration; empty: of the wall with itself
    double force_N = 0.0; ///< sum of the magnitudes of the points' forces
    /// Largest overlap of the surfaces at rest; the solution keeps this overlap, without a force.
    double overlap_at_rest_mm = 0.0;
    std::string message {}; ///< why contact is needed and not computed, or why it was not tested
};

/// Soft tissue that does not keep its volume (volume_failures.h).
struct VolumeFailures {
    std::size_t elements = 0; ///< soft elements outside 0.9 to 1.1 of their volume at rest
    double share = 0.0; ///< their share of the soft tissue's volume at rest
    double smallest_ratio = 1.0, largest_ratio = 1.0; ///< of all soft elements
    Vec3 at = Vec3::Zero(); ///< middle, at rest, of the element that changes most, mm; zero without failures
    std::string place {}; ///< the same place beside the incision, in words; empty: not known
    bool believable = true; ///< false: too much tissue fails, or an element is inside out
};

/// The load of a joint, or of the junction of a rib with its cartilage.
struct JointLoad {
    double force_N = 0.0;
    double moment_Nm = 0.0; ///< about the middle of the joint
    /// Turn of a rib about the axis of its joint with the spine; not set: the joint has no axis (rib_joints.h).
    std::optional<double> turn_deg {};
    bool at_stop = false; ///< the rib has turned beyond the range in which its joint turns nearly freely
};

/// Loads of one bone of the wall at its worst section, and what tested bones bore (bone_limits.h).
struct BoneMetrics {
    std::string name; ///< label, "rib_left_5"
    double at_mm = 0.0; ///< place of the section: from the spine's end of a rib, from the upper end of a sternum
    double length_mm = 0.0; ///< length of the bone, or of the piece that bears most
    std::string part {}; ///< of a rib: "posterior", "lateral" or "anterior"; empty for other bones
    Vec3 place = Vec3::Zero(); ///< middle of the section at rest, mm
    double section_mm2 = 0.0; ///< outer area of the section
    double bending_Nm = 0.0, torsion_Nm = 0.0;
    double moment_Nm = 0.0; ///< bending moment with the same largest tension as bending and torsion together
    std::optional<double> capacity_Nm {}; ///< not set: there is no published number
    double utilisation = 0.0; ///< moment over capacity; 0 without a capacity
    /// Opening of the hooks at which the bone reaches its capacity, if it does: an estimate in proportion.
    std::optional<double> opening_at_limit_mm {};
    std::optional<JointLoad> spine_joint {}; ///< of a rib that rests on the springs of its joints
    std::optional<JointLoad> cartilage {}; ///< of a bone that is joined to cartilage
};

/// The largest strain of one tissue, averaged over balls (ball_strain.h).
struct TissueStrain {
    std::string tissue; ///< material of the labels, "skin"
    double strain = 0.0; ///< elongation over length
    Vec3 at = Vec3::Zero(); ///< centre of the ball at rest, mm
    std::string place {}; ///< the same place in words: "38 mm along the incision, 4 mm beside it"
};

/// How far a lip follows its hooks or blade (planner/plan/lip_deviation.h).
struct LipDeviation {
    int side = 0; ///< +1 or -1
    double largest_mm = 0.0; ///< largest magnitude of the deviation between from_mm and to_mm
    double mean_mm = 0.0; ///< mean magnitude there
    double at_mm = 0.0; ///< place of the largest, along the incision
    double from_mm = 0.0, to_mm = 0.0; ///< the middle part of the incision, in which hooks stand
    /// Place along the incision and deviation there, from one end of the lip to the other, mm. Positive: the lip hangs
    /// behind the line of the hooks, towards the other lip.
    std::vector<std::pair<double, double>> curve {};
};

/// Whether the opening can be had.
enum class Attainable {
    unknown, ///< the bones' moments were not computed; FieldMetrics::bones_message gives the reason
    yes,
    with_injury, ///< a bone is loaded beyond its capacity, or skin is stretched beyond the range in which it tears
    no, ///< no equilibrium was found
};

/// The largest opening at which no bone reaches its capacity, solved (planner/plan/uninjured_opening.h).
struct UninjuredOpening {
    std::string message {}; ///< reason for missing numbers; empty: the numbers are there
    double opening_mm = 0.0; ///< of the hooks, as hook_opening() gives it
    std::string bone {}; ///< label of the bone that is loaded most
    double utilisation = 0.0; ///< of this bone
    double hook_force_N = 0.0; ///< on the larger side
    int solves = 0; ///< number of openings that were computed
    double seconds = 0.0;
};

/// The best place of the surgeon's eye (sight/surgeon_eye.h).
struct BestEye {
    Vec3 at = Vec3::Zero(), aim = Vec3::Zero(); ///< the eye, and where it looks on the target, mm
    double distance_mm = 0.0; ///< from the middle of the opening
    double incidence_deg = 0.0; ///< mean angle between line of sight and normal, over what is seen
    double bound_area_mm2 = 0.0; ///< area that FieldMetrics::seen_best_eye is a share of
    std::vector<SightBlocker> hidden_by; ///< what hides the target from here, largest share first
};

/// FieldMetrics::seen_best_eye with all organs shifted towards the head.
struct ShiftedSight {
    double shift_mm = 0.0;
    double seen_best_eye = 0.0;
};

/// FieldMetrics::seen_best_eye past lungs that keep another share of their volume (anatomy/deflated_lung.h).
struct LungSight {
    double lung_share = 0.0;
    double seen_best_eye = 0.0;
};

/// FieldMetrics::seen_best_eye on the table, from an eye above the wound (kLowestSightDeg), with the patient turned
/// about the long axis. Organs sink towards the floor.
struct TurnedSight {
    double left_side_up_deg = 0.0; ///< 0: supine; 90: on the right side; negative: the right side is up
    double seen_best_eye = 0.0;
};

struct FieldMetrics {
    std::string name; ///< name of the approach
    std::string target; ///< target_name() of the target
    TargetSpec target_spec {}; ///< the target, as the approach gives it

    // Shares of the largest area that the wall's removal would show to an eye, at less than 60 degrees of incidence.
    double seen_best_eye = 0.0; ///< from the best place of the eye
    double seen_two_eyes = 0.0; ///< with two eyes round this place, and light from between them
    double reached_by_two_instruments = 0.0; ///< seen, and within reach of two straight shafts at once
    double reached_by_finger = 0.0; ///< touched by a straight finger, seen or not; at most 1
    /// Where a finger touches nothing: how much longer it would have to be; not set: it does not fit, or it touches.
    std::optional<double> finger_lacks_mm;
    double best_eye_picture = 0.0; ///< projected area seen from the best place, over that of the target alone
    /// The same share, counted in the picture that is drawn from there; not set: no picture was drawn.
    std::optional<double> best_eye_pixels;
    BestEye best_eye;
    std::optional<AnnulusAccess> annulus; ///< of a target that is a valve's annulus
    // The direction from the target to the middle of the opening.
    double access_horizontal_deg = 0.0; ///< in the axial plane, from straight ahead towards the patient's left
    double access_vertical_deg = 0.0; ///< out of the axial plane, towards the head
    double coaxiality_deg
        = 0.0; ///< angle between the best eye's line of sight and the normal of the opening's skin plane
    // Shares of the target's whole area.
    double visible_fraction = 0.0; ///< share of the target's area that is seen from at least one eye of the cone
    double visible_fraction_mean_eye = 0.0; ///< mean over the eyes of the cone
    double visible_fraction_central_eye = 0.0; ///< from the eye on the axis
    double visible_fraction_wall_removed = 0.0; ///< upper bound: the same cone without the wall
    double eye_distance_mm = 0.0, cone_half_angle_deg = 0.0;
    int eyes = 0, target_samples = 0;
    std::vector<SightBlocker> blockers; ///< largest share first
    std::vector<std::string> bone_in_sight;
    /// What the best eye would see if heart, diaphragm and all other organs stood higher: the CT is taken in
    /// inspiration. Smallest shift first.
    std::vector<ShiftedSight> if_organs_shift;
    std::vector<LungSight> if_lung_keeps {}; ///< empty where no lung is held aside
    /// See positions_for(); supine first.
    std::vector<TurnedSight> if_turned {};
    /// Labels among target, what hides it and what is at risk that were estimated, not seen in the image.
    std::vector<std::string> estimated;
    /// From hooks and blades of a retractor where they stand, each structure once, nearest first.
    std::vector<RiskDistance> steel_at_risk;
    std::vector<RiskDistance> at_risk; ///< nearest first; structures beyond kFarthestRiskMm are not listed
    std::vector<std::string> retracted; ///< organs that this approach holds aside

    double opening_area_mm2 = 0.0;
    double opening_width_mm = 0.0;
    double working_distance_mm = 0.0;
    // The opening as the target sees it (OpeningFromTarget).
    double opening_solid_angle_sr = 0.0;
    double attack_along_deg = 0.0, attack_across_deg = 0.0;
    double target_offset_mm = 0.0;
    double surgical_freedom_mm2 = 0.0; ///< area for the near end of an instrument (sight/instruments.h)
    double incision_length_mm = 0.0;
    double cut_depth_mm = 0.0;
    std::vector<std::string> crossed_bones; ///< bones of the wall that the blade meets and leaves whole
    std::vector<std::string> divided_cartilages; ///< cartilages of the wall that the blade severs

    std::vector<HookForce> hooks;
    std::optional<RetractorMetrics> retractor {}; ///< where a retractor opens the wound; its blades are the hooks
    double hook_force_N = 0.0; ///< sum of the larger side
    std::optional<ForceMoments> force_moments {}; ///< filled where hooks or a retractor open the wound
    double strain_p99 = 0.0;
    std::optional<Vec3> strain_p99_at; ///< middle of the element with this strain, at rest, mm
    std::vector<TissueStrain> tissue_strain; ///< the largest strain first; empty without an equilibrium
    std::vector<LipDeviation> lip_deviation; ///< one entry per lip with hooks, side +1 first

    std::vector<BoneMetrics> bones; ///< ribs and sternum, the largest utilisation first
    bool bones_rough = false; ///< by plain four-node elements, which are too stiff
    std::string bones_message; ///< reason for missing moments; empty: the moments are there
    Attainable attainable = Attainable::unknown;
    /// Largest opening of the hooks at which no bone reaches its capacity: the reached opening, or an estimate below.
    std::optional<double> largest_uninjured_opening_mm;
    std::optional<UninjuredOpening> uninjured_opening; ///< filled on request, where the plan injures

    int inverted_elements = 0;
    double max_volume_ratio = 1.0;
    std::optional<VolumeFailures> volume_failures; ///< filled where the solver gave the volumes
    double residual = 0.0; ///< relative residual of the mechanical equilibrium
    std::string mechanics_status; ///< "converged", or the reason of a failure
    SolutionMetrics solution;

    /// The division of the intercostal space beyond the incision; empty where only the skin's length is divided.
    std::optional<DividedTissue> division;
    std::vector<RemovedTissue> removed; ///< tissue removed by ablations and as loose pieces
    double removed_skin_mm2 = 0.0; ///< area of the removed skin at rest; no part of the opening, which the lips bound
    std::vector<std::string> loose_pieces; ///< pieces that the cut left without support, and their treatment

    RegionMetrics region;

    std::size_t tets = 0;
    std::vector<std::pair<std::string, double>> seconds; ///< duration of each stage, in order

    std::optional<ContactMetrics> contact;
    std::vector<PressureMetrics> pressures; ///< pressures on the wall
    std::optional<TensionMetrics> tension; ///< filled where tissue of the wall is under tension
    std::optional<ErrorBars> error;
    /// What tissue values out of their ranges do; filled where hooks open the wound and errors were estimated.
    std::optional<ParameterInterval> parameters;
    std::vector<BoneStiffness> bone_stiffness; ///< moduli of the ribs and cartilages in the wall
    std::optional<AccuracyMetrics> accuracy; ///< filled when an accuracy was asked
    std::optional<SecondOpinion> second_opinion; ///< filled on request

    /// Implausible numbers that the case accepts, one sentence each (planner/case/plausible_input.h).
    std::vector<std::string> implausible;
    std::string explanation; ///< the reasons for what is seen and what is not, in words
};

} // namespace retractor::planner
