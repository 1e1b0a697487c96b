#pragma once
// An approach: the incision, the blade, the target and the hooks that hold the wound open. Plain data, written to and
// read from case.json. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/cutting/store/cut_types.h"
#include "mesh/generation/mesh_sizing.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// How a hook pulls besides moving to its place (fem/statics/hook_drive.h). A value that is set is finite and above 0.
struct HookPull {
    std::optional<double> force_N {}; ///< the hook pulls with this constant force along its direction
    std::optional<double> force_limit_N {}; ///< the hook yields above this force; not with force_N
    /// Stiffness of the grip between hook and lip; not set: rigid; not with force_N.
    std::optional<double> grip_N_per_mm {};

    bool prescribes() const { return !force_N && !force_limit_N && !grip_N_per_mm; }
};

/// @param where put before the failing key in InputError::where()
/// @throws InputError on values out of range or values that contradict each other
void check_pull(const HookPull& pull, const std::string& where);

/// A hook: a rigid rectangular patch on one lip. Positions are in the coordinates of the blade.
struct HookSpec {
    std::string name;
    int side = 1; ///< lip that the hook holds, +1 or -1 as in BladeCoordinates::side
    double along_mm = 0.0; ///< centre of the patch along the incision
    double depth_mm = 0.0; ///< centre of the patch below the skin, along the blade direction
    double patch_width_mm = 10.0; ///< along the incision
    double patch_height_mm = 15.0; ///< along the blade direction
    Vec3 direction = Vec3::Zero(); ///< unit vector, away from the other lip
    double opening_mm = 0.0; ///< motion of the patch along `direction`; 0 with force_N
    HookPull pull {};
};

/// What the surgeon wants to see: a label, or a sphere where no label was drawn.
struct TargetSpec {
    std::string label; ///< empty: the sphere
    Vec3 centre = Vec3::Zero(); ///< mm; sphere only
    double radius_mm = 0.0; ///< > 0; sphere only
    bool is_sphere() const { return label.empty(); }
};

/// Mesh sizes of the wall round this incision; see MeshSizing.
/// The defaults give 50,000 to 80,000 elements on an adult chest, in a few seconds.
struct SizingSpec {
    double corridor_radius_mm = 12.0;
    double corridor_edge_mm = 4.5;
    double coarse_edge_mm = 15.0;
    /// The mesh holds tissue within this distance of the incision, and its whole bones; 0: all of the wall.
    double region_mm = 50.0;
};

/// The eye positions over which the visible fraction is averaged. The eyes lie in a cone about the view axis.
struct ViewSpec {
    double eye_distance_mm = 400.0; ///< distance of the eyes from the middle of the incision, outwards
    double half_angle_deg = 20.0; ///< 0 <= angle < 90
    int eye_count = 61; ///< >= 1
};

/// Tissue that is removed after the cut: a segment of one label (a rib), or the content of a ball.
/// A segment lies between two distances across the incision and two along it, and is as deep as the blade. The label is
/// sawn through at these four places first, so that the segment gets exactly this length.
struct AblationSpec {
    std::string label {}; ///< label that is removed; a ball without a label removes all tissue of the wall
    double from_mm = 0.0, to_mm = 0.0; ///< limits across the incision, from < to; sign as in BladeCoordinates::side
    /// Limits along the incision; default: the ends of the incision.
    std::optional<double> along_from_mm {}, along_to_mm {};
    Vec3 centre = Vec3::Zero(); ///< centre of the ball
    double radius_mm = 0.0; ///< radius of the ball; 0: a segment
    bool is_ball() const { return radius_mm > 0.0; }
};

/// Treatment of pieces that the cut leaves without support, bed or hook (find_wall_pieces()):
/// - held: the piece rests on a bed as soft as resting muscle (kBedModulus per mm^2 of its surface). The bed keeps the
///   stiffness regular and hardly hinders the piece. The piece is measured and drawn where the bed lets it go.
/// - removed: the piece is deleted, like an ablation.
/// - rigid: the piece is left out of the elastic solution and moves as one body with the tissue that lay against it.
///   Its motion is the rigid motion that fits best the wound faces from which the piece was cut; without such faces the
///   piece stays at rest.
enum class LoosePieces { held, removed, rigid };

struct Approach {
    std::string name; ///< unique in its case
    std::string template_name; ///< "median", "intercostal:5", ... or "points"
    std::vector<Vec3> incision; ///< on the skin, in cutting order; at least two points
    std::vector<Vec3> directions; ///< into the body, unit; one per incision point
    double depth_mm = 0.0; ///< depth of the blade: the whole wall everywhere along the incision, and a margin
    /// Thickness at each incision point, along its direction; empty: not measured.
    std::vector<double> wall_thickness_mm;
    /// Depth at which a hook finds hold, at each incision point; empty: half of depth_mm.
    std::vector<double> hook_depth_mm;
    TargetSpec target;
    std::vector<HookSpec> hooks;
    std::vector<std::string> retracted; ///< organs held aside; they do not block the view
    std::vector<std::string> uncut_labels; ///< labels that this blade does not sever (a scalpel does not cut bone)
    std::vector<AblationSpec> ablations {}; ///< carried out in this order, after the cut
    LoosePieces loose_pieces = LoosePieces::held;
    SizingSpec sizing;
    ViewSpec view;
    std::string rationale; ///< reason for the place of the incision, in words
};

/// The blade of the approach, as the cutter takes it.
mesh::Blade blade_of(const Approach& approach);

/// The cut options of the approach: the labels that the blade does not sever.
/// @throws InputError naming a label that is not in the table
mesh::CutOptions cut_options_of(const Approach& approach, const mesh::LabelTable& table);

/// Text for people: "rib from -10.0 to 10.0 mm across and 0.0 to 50.0 mm along the incision", "tissue in a ball of 5.0
/// mm at (1, 2, 3)".
std::string ablation_text(const AblationSpec& ablation, double incision_length_mm);

/// "held", "removed" or "rigid", and back; nothing for another word.
std::string_view to_string(LoosePieces policy);
std::optional<LoosePieces> loose_pieces_from_string(std::string_view text);

/// The sizing of the approach, as the mesher takes it. The corridor follows the incision on the skin and returns half
/// way down the blade. Bones and cartilages are kept whole. The sternum is kept whole only where the approach divides
/// it; elsewhere the sternum is the firm end of the cartilages.
mesh::MeshSizing mesh_sizing_of(const Approach& approach, const mesh::LabelTable& table);

/// Length of the incision, mm.
double incision_length(const Approach& approach);

/// A place on the incision, between two of its points.
struct IncisionPlace {
    std::size_t segment = 0; ///< index of the point before the place
    double t = 0.0; ///< 0 at this point, 1 at the next one

    /// Interpolates values at the incision's points. @pre one value per point
    template <class Value> Value of(const std::vector<Value>& values) const
    {
        return (1.0 - t) * values[segment] + t * values[segment + 1];
    }
};
/// The place at a distance (mm) along the incision. A distance beyond an end gives the end.
/// @pre the incision has at least two points
IncisionPlace incision_place(const Approach& approach, double along_mm);

/// @param pointer JSON pointer of the sizing, put before the failing key
/// @throws InputError on NaN or sizes out of range
void check_sizing(const SizingSpec& sizing, const std::string& pointer = {});

/// @param pointer JSON pointer of the approach, put before the failing key in InputError::where()
/// @throws InputError on NaN, values out of range, lists of unequal length, or a malformed hook, target or cone
void check_approach(const Approach& approach, const std::string& pointer = {});

} // namespace retractor::planner
