#pragma once
// An approach: the incision, the blade, the target and the hooks that hold the wound open. Plain data, written to and
// read from case.json. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/cutting/store/cut_types.h"
#include "mesh/generation/mesh_sizing.h"
#include "planner/case/division.h"
#include "planner/case/opening_protocol.h"

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

/// How a hook or blade holds its lip:
/// - fixed: the tissue under the patch, and the bone on which it bears, moves with the patch as if glued to it. This is
///   the hold of hooks that grip, such as rakes.
/// - contact: the patch pushes and never pulls. Tissue may lift off and, beyond friction, slide along the patch; bone
///   rolls on it (fem/model/blade_contact.h). So a blade holds.
enum class HookHold { fixed, contact };

/// "fixed" or "contact", and back; nothing for another word.
std::string_view to_string(HookHold hold);
std::optional<HookHold> hook_hold_from_string(std::string_view text);

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
    HookHold hold = HookHold::fixed;
    /// Places on bones on which the patch bears, mm; set by find_bearing_points(), not a part of case.json.
    std::vector<Vec3> bearing {};
    std::vector<std::string> bears_on {}; ///< names of these bones; set with `bearing`
};

/// A retractor in place of hooks: a rigid frame with two blades, which the tissue holds
/// (fem/statics/blade_frame.h). The sizes come from the table of instruments (planner/approach/retractors.h) when the
/// retractor is placed, and may be changed here.
struct RetractorSpec {
    std::string kind; ///< name of the instrument in the table, such as "finochietto"
    double opening_mm = 0.0; ///< distance by which the rack moves the blades apart; 0 with force_N
    std::optional<double> force_N {}; ///< force along the rack at each blade; the opening follows from the force
    double along_mm = 0.0; ///< middle of the blades along the incision
    double blade_width_mm = 0.0; ///< along the incision
    double blade_depth_mm = 0.0; ///< from the arm at the skin into the wound; a thinner wall takes a part of the blade
    double play_deg = 0.0; ///< largest turn of a blade about its arm, to either side
    double greatest_opening_mm = 0.0;
    HookHold hold = HookHold::contact; ///< of both blades
};

/// The instrument as surgeons call it: "Finochietto rib spreader" for "finochietto", "sternal spreader", "MIDCAB
/// retractor". Another kind is one of the user's own table: "small retractor" for "small".
std::string instrument_name(const std::string& kind);

/// What the surgeon wants to see: a label, a site on a label's surface, or a sphere where no label was drawn.
struct TargetSpec {
    std::string label; ///< empty: the sphere
    Vec3 centre = Vec3::Zero(); ///< mm; of the sphere or the site
    double radius_mm = 0.0; ///< > 0; of the sphere, or of the part of the surface round the site's centre
    std::string site {}; ///< what is done on the label, in words: "anastomosis site"; empty: the whole label
    /// Of the plane of a valve's annulus; not set: the plane fits the site's surface. Any length but zero.
    std::optional<Vec3> normal {};
    bool is_sphere() const { return label.empty(); }
    bool is_site() const { return !label.empty() && !site.empty(); }
};

/// Words for sites; others are allowed.
inline constexpr std::string_view kSites[]
    = { "anastomosis site", "clamp site", "proximal neck", "distal neck", "annulus" };

/// Name of the target: "sphere", "aneurysm", "anastomosis site on heart".
std::string target_name(const TargetSpec& target);

/// The region of an approach for which none was given and none was found, mm.
inline constexpr double kFirstRegionMm = 50.0;
/// Beyond this distance from the incision a larger region that was found is a coarse model, mm.
inline constexpr double kCoarseBeyondMm = 30.0;

/// Mesh sizes of the wall round this incision; see MeshSizing.
/// A new case has edges of 8 mm for ten-node elements (write_import()); they give about 190,000 elements on an adult
/// chest.
struct SizingSpec {
    double corridor_radius_mm = 12.0;
    double corridor_edge_mm = 4.5;
    double coarse_edge_mm = 15.0;
    /// The mesh holds tissue within this distance of the incision, and its whole bones; 0: all of the wall. Not set:
    /// kFirstRegionMm, or what the plan finds (PlanChecks::find_region).
    std::optional<double> region_mm {};
    double coarse_beyond_mm = 0.0; ///< MeshSizing::coarse_beyond_mm, of a found region; not a part of case.json
    unsigned mesh_seed = 0; ///< MeshSizing::seed; not a part of case.json
    double patch_edge_mm = 3.0; ///< MeshSizing::fine_edge_mm, round the hooks' patches; not a part of case.json
};

/// The same sizes with all edges multiplied by this factor. @pre factor > 0
SizingSpec with_scaled_edges(SizingSpec sizing, double factor);

/// The same sizes with a region that was found: a coarse model beyond kCoarseBeyondMm, where it is larger than
/// kFirstRegionMm.
SizingSpec found_sizing(SizingSpec sizing, double region_mm);

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
    std::string name; ///< unique in its case; files and decisions are found by it
    std::string title {}; ///< what people call it; empty: see spoken_name()
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
    /// In place of hooks: an approach of a case has either. A plan adds the two blades as hooks (blades_of()).
    std::optional<RetractorSpec> retractor {};
    /// Steps in which hooks or a rack are moved to their opening; not set: OpeningProtocol {}.
    std::optional<OpeningProtocol> opening_protocol {};
    std::vector<std::string> retracted; ///< organs held aside; they do not block the view
    std::vector<std::string> uncut_labels; ///< labels that this blade does not sever (a scalpel does not cut bone)
    Division division {}; ///< of the intercostal space beyond the skin, carried out after the cut
    std::vector<AblationSpec> ablations {}; ///< carried out in this order, after the cut and the division
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
/// it; elsewhere the sternum is the firm end of the cartilages. Where the division's strokes are known, the mesh
/// reaches along them, with edges one and a half times as long as in the corridor.
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

/// The patch of a hook on the blade: its centre, and unit vectors along it and into the body. A hook lies along its
/// piece of the incision; the straight blade of a retractor lies square to its pull.
struct PatchPlace {
    Vec3 centre, along, depth;
};
PatchPlace patch_place(const Approach& approach, const HookSpec& hook);

/// @param pointer JSON pointer of the sizing, put before the failing key
/// @throws InputError on NaN or sizes out of range
void check_sizing(const SizingSpec& sizing, const std::string& pointer = {});

/// @param pointer JSON pointer of the approach, put before the failing key in InputError::where()
/// @throws InputError on NaN, values out of range, lists of unequal length, or a malformed hook, target or cone
void check_approach(const Approach& approach, const std::string& pointer = {});

} // namespace retractor::planner
