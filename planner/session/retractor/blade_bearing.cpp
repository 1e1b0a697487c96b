#include "planner/session/retractor/blade_bearing.h"

#include "mesh/base/assert.h"
#include "planner/approach/bearing_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

namespace retractor::planner {

namespace {

    /// A lip is as rough as the mesh: its own bone may lie this far before its mean plane.
    constexpr double kBeforeMm = 2.0;
    /// At rest the other lip lies against this one. Bone that is not a part of this lip is behind it from here on.
    constexpr double kBehindMm = 0.5;
    /// The blade's end moves at least a little more slowly than its arm: without that, what it bears on would not tell
    /// how far the arms are open.
    constexpr double kLongestLever = 0.9; // of the blade
    /// Bone this much farther behind the lip than the nearest still bears: about half an element at the wound.
    constexpr double kContactMm = 2.0;
    /// Nodes from the skin to this far below the level at which the blade bears move with it.
    constexpr double kBandMm = 8.0;
    /// Half of the blade, in its middle, decides, as in bearing_points().
    constexpr double kMiddle = 0.25;
    constexpr std::size_t kFewestNodes = 3;

    /// A place in the frame of a blade: along the wound, below the arm, and behind the lip.
    struct BladePlace {
        double along = 0.0, depth = 0.0, behind = 0.0;
    };

    BladePlace place_on(const HookPlacement& blade, const Vec3& point)
    {
        const Vec3 from = point - blade.arm;
        return { from.dot(blade.along), from.dot(blade.inward), from.dot(blade.pull) };
    }

    /// The places of bone before the blade's middle half.
    /// @pre the arm lies on the mean plane of the nodes
    std::vector<BladePlace> bone_before(
        const HookPlacement& blade, const mesh::CutSession& session, std::span<const Label> skeleton)
    {
        const std::set<VertexId> lip(blade.nodes.begin(), blade.nodes.end());
        std::set<VertexId> vertices;
        for (TetId t = 0; t < static_cast<TetId>(session.tet_slots()); ++t)
            if (session.has_tet(t)) {
                const mesh::MeshDelta::Tet tet = session.tet(t);
                if (std::ranges::find(skeleton, tet.label) != skeleton.end())
                    vertices.insert(tet.nodes.begin(), tet.nodes.end());
            }
        std::vector<BladePlace> places;
        for (const VertexId v : vertices) {
            const BladePlace place = place_on(blade, session.position(v));
            if (std::abs(place.along) <= kMiddle * blade.width_mm && place.depth >= 0.0 && place.depth <= blade.reach_mm
                && place.behind >= (lip.contains(v) ? -kBeforeMm : kBehindMm) && place.behind <= kBearingMm)
                places.push_back(place);
        }
        return places;
    }

} // namespace

bool bear_on_bone(HookPlacement& placement, const mesh::CutSession& session, std::span<const Label> skeleton)
{
    RETRACTOR_ASSERT(!placement.nodes.empty());
    double lip_mm = 0.0, depth = 0.0;
    placement.reach_mm = 0.0;
    for (const VertexId v : placement.nodes) {
        const BladePlace node = place_on(placement, session.position(v));
        lip_mm += node.behind / static_cast<double>(placement.nodes.size());
        depth += node.depth / static_cast<double>(placement.nodes.size());
        placement.reach_mm = std::max(placement.reach_mm, node.depth);
    }
    placement.arm += lip_mm * placement.pull;
    placement.height_mm = std::min(placement.height_mm, placement.reach_mm);
    placement.lever_mm = std::clamp(depth, 0.0, kLongestLever * placement.reach_mm);
    const std::vector<BladePlace> bone = bone_before(placement, session, skeleton);
    if (bone.empty())
        return false;
    const double nearest = std::ranges::min_element(bone, {}, &BladePlace::behind)->behind;
    double sum = 0.0, weights = 0.0;
    for (const BladePlace& place : bone) {
        const double weight = std::max(0.0, nearest + kContactMm - place.behind);
        sum += weight * place.depth;
        weights += weight;
    }
    placement.lever_mm = std::min(sum / weights, kLongestLever * placement.reach_mm);
    std::vector<VertexId> pushed;
    for (const VertexId v : placement.nodes)
        if (place_on(placement, session.position(v)).depth <= placement.lever_mm + kBandMm)
            pushed.push_back(v);
    if (pushed.size() >= kFewestNodes)
        placement.nodes = std::move(pushed);
    return true;
}

double blade_turn(const HookPlacement& blade, double opening_mm, double play_rad)
{
    if (!(blade.reach_mm > 0.0))
        return 0.0;
    const double ends_meet = std::asin(std::clamp(0.5 * opening_mm / blade.reach_mm, 0.0, 1.0));
    return std::min(play_rad, ends_meet);
}

double behind_arm_mm(const HookPlacement& blade, double opening_mm, double play_rad)
{
    return blade.lever_mm * std::sin(blade_turn(blade, opening_mm, play_rad));
}

double opening_of_arms(const std::array<const HookPlacement*, 2>& blades, double apart_mm, double play_rad)
{
    // The way behind the arms grows with the opening, at most as fast as the opening (a lever is no longer than the
    // blade), and ends with the play.
    double low = apart_mm, high = apart_mm;
    for (const HookPlacement* blade : blades)
        high += blade->lever_mm * std::sin(play_rad);
    constexpr int kHalvings = 60; // to round-off
    for (int i = 0; i < kHalvings; ++i) {
        const double middle = 0.5 * (low + high);
        double apart = middle;
        for (const HookPlacement* blade : blades)
            apart -= behind_arm_mm(*blade, middle, play_rad);
        (apart < apart_mm ? low : high) = middle;
    }
    return high;
}

} // namespace retractor::planner
