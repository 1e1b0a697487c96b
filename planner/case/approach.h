#pragma once
// An approach: where the surgeon cuts, how the blade goes in, what is looked at, which hooks hold the wound open.
// Plain data, written to and read from case.json. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/cutting/store/cut_types.h"
#include "mesh/generation/mesh_sizing.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// What a hook does besides going where it is told (fem/hook_drive.h). Set: > 0 and finite.
struct HookPull {
    std::optional<double> force_N {}; ///< it pulls with this force along its direction, however far that goes
    std::optional<double> force_limit_N {}; ///< it yields where the force would be more; not with force_N
    std::optional<double> grip_N_per_mm {}; ///< the lip follows through this; not with force_N. None: completely

    bool prescribes() const { return !force_N && !force_limit_N && !grip_N_per_mm; }
};

/// @param where put before the failing key in InputError::where(). @throws InputError on what is out of range, or does
/// not go together.
void check_pull(const HookPull& pull, const std::string& where);

/// A hook: a rigid rectangular patch on one lip, given in the blade's own coordinates.
struct HookSpec {
    std::string name;
    int side = 1; ///< +1 or -1: the lip it holds, see BladeCoordinates::side
    double along_mm = 0.0; ///< patch centre along the incision
    double depth_mm = 0.0; ///< patch centre below the skin, along the blade direction
    double patch_width_mm = 10.0; ///< along the incision
    double patch_height_mm = 15.0; ///< along the blade direction
    Vec3 direction = Vec3::Zero(); ///< unit; away from the other lip
    double opening_mm = 0.0; ///< how far this patch moves along `direction`; nothing with force_N
    HookPull pull {};
};

/// What the surgeon wants to see: a label, or a sphere where no label was drawn.
struct TargetSpec {
    std::string label; ///< empty: the sphere
    Vec3 centre = Vec3::Zero(); ///< mm; sphere only
    double radius_mm = 0.0; ///< > 0; sphere only
    bool is_sphere() const { return label.empty(); }
};

/// How finely the wall is meshed round this incision; see MeshSizing.
/// The defaults give 50,000 to 80,000 elements on an adult chest, in a few seconds.
struct SizingSpec {
    double corridor_radius_mm = 12.0;
    double corridor_edge_mm = 4.5;
    double coarse_edge_mm = 15.0;
    double region_mm = 50.0; ///< only tissue within this distance of the incision, and its bones; 0: all of it
};

/// The eye positions over which the visible fraction is averaged: a cone about the view axis.
struct ViewSpec {
    double eye_distance_mm = 400.0; ///< from the middle of the incision outwards
    double half_angle_deg = 20.0; ///< 0 <= angle < 90
    int eye_count = 61; ///< >= 1
};

/// Tissue that is taken out after the cut: a segment of one label (a rib), or what lies in a ball.
/// A segment lies between two distances across the incision and two along it, as deep as the blade goes; the label is
/// sawn through at these four places first, so that the segment is as long as it is said to be.
struct AblationSpec {
    std::string label {}; ///< what is removed; a ball without a label removes all tissue of the wall
    double from_mm = 0.0, to_mm = 0.0; ///< across the incision, from < to; sign as BladeCoordinates::side
    std::optional<double> along_from_mm {}, along_to_mm {}; ///< along the incision; default: its ends
    Vec3 centre = Vec3::Zero(); ///< mm; ball only
    double radius_mm = 0.0; ///< > 0 makes it a ball
    bool is_ball() const { return radius_mm > 0.0; }
};

/// What becomes of pieces that the cut has left without support, bed or hook (find_wall_pieces):
/// - held: on a bed as soft as resting muscle (kBedModulus per mm^2 of their surface), which keeps the stiffness
/// regular
///   and hardly hinders them; they are measured and drawn where that takes them;
/// - removed: taken out, like an ablation;
/// - rigid: left out of the elastic solution and moved as one body with the tissue that lay against them (the rigid
///   motion that fits the wound's faces which they were cut from best; at rest where there are none).
enum class LoosePieces { held, removed, rigid };

struct Approach {
    std::string name; ///< unique in its case
    std::string template_name; ///< "median", "intercostal:5", ... or "points"
    std::vector<Vec3> incision; ///< on the skin, in cutting order; at least two points
    std::vector<Vec3> directions; ///< into the body, unit; one per incision point
    double depth_mm = 0.0; ///< the whole wall everywhere along the incision, and a margin
    std::vector<double> wall_thickness_mm; ///< per incision point, along its direction; empty: not measured
    std::vector<double> hook_depth_mm; ///< per incision point: where a hook finds hold; empty: half of depth_mm
    TargetSpec target;
    std::vector<HookSpec> hooks;
    std::vector<std::string> retracted; ///< organs held aside: they do not block the view
    std::vector<std::string> uncut_labels; ///< what this blade does not sever (a scalpel does not cut bone)
    std::vector<AblationSpec> ablations {}; ///< in this order, after the cut
    LoosePieces loose_pieces = LoosePieces::held;
    SizingSpec sizing;
    ViewSpec view;
    std::string rationale; ///< why the incision is where it is, in words
};

/// The approach's blade as the cutter takes it.
mesh::Blade blade_of(const Approach& approach);

/// How the approach's blade cuts: what it does not sever. @throws InputError naming a label that is not in the table.
mesh::CutOptions cut_options_of(const Approach& approach, const mesh::LabelTable& table);

/// "rib from -10.0 to 10.0 mm across and 0.0 to 50.0 mm along the incision", "tissue in a ball of 5.0 mm at (1, 2, 3)".
std::string ablation_text(const AblationSpec& ablation, double incision_length_mm);

/// "held", "removed" or "rigid", and back; nothing for another word.
std::string_view to_string(LoosePieces policy);
std::optional<LoosePieces> loose_pieces_from_string(std::string_view text);

/// The approach's sizing as the mesher takes it. The corridor follows the incision on the skin and comes back half way
/// down the blade; bones and cartilages are kept whole, the sternum only where the approach divides it (elsewhere it is
/// the firm end of the cartilages).
mesh::MeshSizing mesh_sizing_of(const Approach& approach, const mesh::LabelTable& table);

/// Length of the incision, mm.
double incision_length(const Approach& approach);

/// @throws InputError on NaN or sizes out of range, its JSON pointer beginning with `pointer`.
void check_sizing(const SizingSpec& sizing, const std::string& pointer = {});

/// @param pointer JSON pointer of the approach, put before the failing key in InputError::where().
/// @throws InputError on NaN, values out of range, lists of unequal length, a malformed hook, target or cone.
void check_approach(const Approach& approach, const std::string& pointer = {});

} // namespace retractor::planner
