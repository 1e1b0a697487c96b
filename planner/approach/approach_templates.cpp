#include "planner/approach/approach_templates.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/statistics.h"
#include "mesh/base/text_format.h"
#include "mesh/image/skeleton.h"
#include "planner/anatomy/body_probe.h"
#include "planner/approach/blade_sweep.h"
#include "planner/approach/intercostal_space.h"
#include "planner/approach/smooth_line.h"
#include "planner/case/target_site.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>

namespace retractor::planner {

namespace {

    constexpr double kLargestTurnDeg = 35.0; ///< a blade further from square to the skin is another incision
    constexpr double kPointSpacingMm = 6.0; ///< between incision points
    constexpr double kDepthMarginMm = 5.0; ///< distance of the blade's end beyond the thickest wall
    constexpr double kBeyondSternumMm = 10.0; ///< distance at both ends, so that the saw leaves the bone
    constexpr double kLeastClearanceMm = 1.0; ///< between the blade and bone
    /// Multiple of the median thickness; a thicker wall is no chest wall (shoulder, belly).
    constexpr double kThickWall = 2.0;

    constexpr int kHemisternotomySpace = 4; ///< where the saw turns, unless the request says otherwise
    constexpr int kLowestSternalSpace = 6; ///< the cartilages of the eighth rib and below end on the arch of the ribs
    /// A level outside these shares of the sternum's length has no hemisternotomy.
    constexpr double kHighestLevel = 0.2, kLowestLevel = 0.9;
    /// A rib whose front end lies farther from the sternum's midline has no labelled cartilage.
    constexpr double kCartilageMm = 45.0;

    constexpr std::array<std::string_view, 9> kTemplateKinds { "median", "hemisternotomy-j", "hemisternotomy-j-left",
        "hemisternotomy-t", "intercostal", "distal", "midcab", "right-anterior", "right-lateral" };

    bool is_sternal(std::string_view kind) { return kind == "median" || kind.starts_with("hemisternotomy"); }

    struct ParsedTemplate {
        std::string kind;
        int space = 0; ///< 0: not given
    };

    ParsedTemplate parse_template(const std::string& text)
    {
        const auto refuse = [&](const std::string& why) -> ParsedTemplate {
            throw InputError(why + " \"" + text
                    + "\": use median, hemisternotomy-j, hemisternotomy-j-left, hemisternotomy-t, intercostal:N, "
                      "distal, midcab, right-anterior or right-lateral; all but median also with a space of their "
                      "own, such as midcab:4",
                "template", { "template_name" });
        };
        ParsedTemplate parsed;
        const auto colon = text.find(':');
        parsed.kind = text.substr(0, colon);
        if (std::ranges::find(kTemplateKinds, parsed.kind) == kTemplateKinds.end())
            return refuse("unknown template");
        if (colon == std::string::npos)
            return parsed.kind == "intercostal" ? refuse("no intercostal space given in") : parsed;
        const char* first = text.data() + colon + 1;
        const char* last = text.data() + text.size();
        const auto [end, error] = std::from_chars(first, last, parsed.space);
        if (parsed.kind == "median" || error != std::errc {} || end != last || parsed.space < 1 || parsed.space > 11)
            return refuse("the intercostal space must be 1 to 11 in");
        return parsed;
    }

    std::vector<std::string> bone_names(const mesh::LabelTable& table)
    {
        std::vector<std::string> names;
        for (const mesh::LabelInfo& info : table)
            if (info.material == "bone" && info.role == mesh::Role::wall)
                names.push_back(info.name);
        return names;
    }

    mesh::LabelFlags hard_labels(const mesh::LabelTable& table)
    {
        return mesh::flagged_labels(
            table, [](const mesh::LabelInfo& info) { return mesh::is_wall(info) && mesh::is_skeleton(info); });
    }

    Vec3 target_centre(const mesh::LabelVolume& labels, const TargetSpec& target)
    {
        return target.is_sphere() || target.is_site() ? target.centre : label_centroid(labels, target.label);
    }

    /// Sets depth and wall thickness along the finished line.
    /// @returns the number of places without a chest wall before a cavity, or thicker than kThickWall times the median.
    /// These places do not count in the depth.
    std::size_t measure_wall(const BodyProbe& probe, Approach& approach)
    {
        std::vector<double> found;
        approach.wall_thickness_mm.assign(approach.incision.size(), std::numeric_limits<double>::infinity());
        for (std::size_t n = 0; n < approach.incision.size(); ++n)
            if (const auto wall = probe.wall_thickness(approach.incision[n], approach.directions[n])) {
                approach.wall_thickness_mm[n] = *wall;
                found.push_back(*wall);
            }
        if (2 * found.size() < approach.incision.size())
            throw InputError("no cavity lies behind the wall along most of the incision: check the roles of the "
                             "labels, or give a depth",
                "depth", { "depth_mm" });
        std::sort(found.begin(), found.end());
        const double limit = kThickWall * found[found.size() / 2];
        double thickest = 0.0;
        std::size_t omitted = 0;
        for (const double wall : approach.wall_thickness_mm)
            if (wall <= limit)
                thickest = std::max(thickest, wall);
            else
                ++omitted;
        approach.depth_mm = thickest + kDepthMarginMm;
        for (double& wall : approach.wall_thickness_mm)
            wall = std::min(wall, approach.depth_mm);
        return omitted;
    }

    std::string wall_words(const Approach& approach, std::size_t omitted)
    {
        RETRACTOR_ASSERT(!approach.wall_thickness_mm.empty());
        const auto [thin, thick]
            = std::minmax_element(approach.wall_thickness_mm.begin(), approach.wall_thickness_mm.end());
        std::string text = " The wall along it is " + in_words(*thin) + " to " + in_words(*thick) + " mm thick"
            + std::string(kBladeGoes) + in_words(approach.depth_mm) + std::string(kDeep) + ".";
        if (omitted > 0)
            text += " At " + std::to_string(omitted) + " of its " + std::to_string(approach.incision.size())
                + " points no cavity lies near behind the wall, and the blade ends inside it.";
        return text;
    }

    /// Unit directions square to the incision, turned from `inward` towards their common mean.
    /// @param share 0: as they are, 1: as near to the mean as they can be
    std::vector<Vec3> blade_directions(const std::vector<Vec3>& inward, const std::vector<Vec3>& along, double share)
    {
        Vec3 mean = Vec3::Zero();
        for (const Vec3& direction : inward)
            mean += direction;
        mean.normalize();
        std::vector<Vec3> directions;
        for (std::size_t n = 0; n < inward.size(); ++n) {
            const Vec3 turned = (1.0 - share) * inward[n] + share * mean;
            directions.push_back((turned - along[n].dot(turned) * along[n]).normalized());
        }
        return directions;
    }

    double largest_turn_deg(const std::vector<Vec3>& from, const std::vector<Vec3>& to)
    {
        double largest = 0.0;
        for (std::size_t n = 0; n < from.size(); ++n)
            largest = std::max(largest, std::acos(std::clamp(from[n].dot(to[n]), -1.0, 1.0)));
        return largest * 180.0 / std::numbers::pi;
    }

    /// Name of a point for people: the index 2 gives "point 3".
    std::string point_name(std::size_t index) { return "point " + std::to_string(index + 1); }

    /// Refuses a blade that crosses itself, by the cutter's own check.
    /// @param given last given point at or before each incision point
    void check_crossing(
        const Approach& approach, const std::vector<Vec3>& points, const std::vector<std::size_t>& given)
    {
        const auto blade_to = [&](std::size_t count) {
            mesh::Blade blade = blade_of(approach);
            blade.line.resize(count, Vec3::Zero());
            blade.directions.resize(count, Vec3::Zero());
            return blade;
        };
        try {
            static_cast<void>(mesh::SweptBlade(blade_of(approach)));
        } catch (const InputError&) {
            for (std::size_t count = 2; count <= approach.incision.size(); ++count)
                try {
                    static_cast<void>(mesh::SweptBlade(blade_to(count)));
                } catch (const InputError& error) {
                    const std::size_t from = given[count - 2];
                    RETRACTOR_ASSERT(from + 1 < points.size());
                    const Vec3 ends = approach.incision.back() - approach.incision.front();
                    throw InputError(std::string(error.what()) + " on the way from the point " + in_words(points[from])
                            + " to " + in_words(points[from + 1]) + ", with a depth of " + in_words(approach.depth_mm)
                            + " mm: "
                            + (ends.norm() < kPointSpacingMm
                                    ? "an incision does not close; end it some way before its first point"
                                    : "move these points, or cut less deep"),
                        point_name(from + 1), { "points", "depth_mm" });
                }
            throw;
        }
    }

    // ---- through the sternum ---------------------------------------------------------------------------------------

    /// An incision on the sternum's midline, from kBeyondSternumMm above the notch to a distance below the notch.
    void incise_sternum(const BodyProbe& probe, const Anatomy& anatomy, double to_mm, Approach& approach)
    {
        const SternumAxis& sternum = anatomy.sternum;
        const Vec3& forward = anatomy.frame.anterior;
        const Vec3 back = -(forward - sternum.axis.dot(forward) * sternum.axis).normalized();
        const double bone = (sternum.top - sternum.bottom).dot(sternum.axis);
        const double length = to_mm + kBeyondSternumMm;
        const int count = std::max(2, static_cast<int>(std::ceil(length / kPointSpacingMm - 0.0123)));
        const auto& midline = sternum.midline;
        for (int n = 0; n <= count; ++n) {
            // Distance below the notch, in midline nodes. The line continues straight beyond both ends.
            const double depth = length * n / count - kBeyondSternumMm;
            const double place = depth / bone * static_cast<double>(midline.size() - 1);
            const auto node
                = static_cast<std::size_t>(std::clamp(std::floor(place), 0.0, static_cast<double>(midline.size() - 2)));
            const Vec3 middle
                = midline[node] + (place - static_cast<double>(node)) * (midline[node + 1] - midline[node]);
            const auto skin = probe.skin_along(middle, -back);
            if (!skin) {
                if (depth < 0.0 || depth > bone)
                    continue; // the image ends here
                throw InputError("no skin in front of the sternum near " + in_words(middle), "sternum");
            }
            approach.incision.push_back(middle - *skin * back);
            approach.directions.push_back(back);
            approach.hook_depth_mm.push_back(*skin);
        }
    }

    void place_median(const BodyProbe& probe, const Anatomy& anatomy, Approach& approach)
    {
        const SternumAxis& sternum = anatomy.sternum;
        incise_sternum(probe, anatomy, (sternum.top - sternum.bottom).dot(sternum.axis) + kBeyondSternumMm, approach);
        const std::size_t omitted = measure_wall(probe, approach);
        approach.rationale = "Full median sternotomy: the midline of the sternum, found in its label, from "
            + in_words(kBeyondSternumMm) + " mm above the notch to " + in_words(kBeyondSternumMm)
            + " mm below the xiphoid, put on the skin square to the bone. The sternum ("
            + in_words((sternum.top - sternum.bottom).norm()) + " mm long) is sawn through; ribs and spine are not cut."
            + wall_words(approach, omitted);
    }

    /// Where a space meets the sternum.
    struct SternalLevel {
        double below_notch_mm = 0.0;
        bool by_cartilage = true; ///< false: by the bony ribs' front ends, because no cartilage is labelled there
    };

    SternalLevel level_of_space(const Anatomy& anatomy, bool left, int space)
    {
        const SternumAxis& sternum = anatomy.sternum;
        SternalLevel level;
        for (const int number : { space, space + 1 }) {
            const Vec3& front = find_rib(anatomy, left, number).points.back();
            const double below = (sternum.top - front).dot(sternum.axis);
            level.below_notch_mm += 0.5 * below;
            level.by_cartilage
                = level.by_cartilage && std::abs((front - sternum.top).dot(anatomy.frame.left)) < kCartilageMm;
        }
        return level;
    }

    /// An upper hemisternotomy: the midline as far as a space, and the saw's turn there.
    void place_hemisternotomy(
        const BodyProbe& probe, const Anatomy& anatomy, const ParsedTemplate& parsed, Approach& approach)
    {
        const int space = parsed.space > 0 ? parsed.space : kHemisternotomySpace;
        if (space > kLowestSternalSpace)
            throw InputError("intercostal space " + std::to_string(space) + " does not reach the sternum: give 2 to "
                    + std::to_string(kLowestSternalSpace),
                "template", { "template_name" });
        const bool across = parsed.kind == "hemisternotomy-t", left = parsed.kind == "hemisternotomy-j-left";
        SternalLevel level = level_of_space(anatomy, left, space);
        if (across) {
            const SternalLevel other = level_of_space(anatomy, true, space);
            level.below_notch_mm = 0.5 * (level.below_notch_mm + other.below_notch_mm);
            level.by_cartilage = level.by_cartilage && other.by_cartilage;
        }
        const double bone = (anatomy.sternum.top - anatomy.sternum.bottom).dot(anatomy.sternum.axis);
        if (!(level.below_notch_mm > kHighestLevel * bone && level.below_notch_mm < kLowestLevel * bone))
            throw InputError("intercostal space " + std::to_string(space) + " meets the sternum "
                    + in_words(level.below_notch_mm) + " mm below the notch of a sternum of " + in_words(bone)
                    + " mm: choose another space for a hemisternotomy",
                "template", { "template_name" });
        incise_sternum(probe, anatomy, level.below_notch_mm, approach);
        approach.division.extent = across ? DivisionExtent::sternum_across
            : left                        ? DivisionExtent::sternum_left
                                          : DivisionExtent::sternum_right;
        approach.template_name = parsed.kind + ":" + std::to_string(space);
        const std::size_t omitted = measure_wall(probe, approach);
        approach.rationale = std::string("Upper hemisternotomy, ")
            + (across      ? "T"
                    : left ? "J to the left"
                           : "J")
            + ": the midline of the sternum from " + in_words(kBeyondSternumMm) + " mm above the notch to the level of "
            + (across ? "both intercostal spaces " + std::to_string(space) : space_name(left, space)) + ", "
            + in_words(level.below_notch_mm) + " mm below the notch"
            + (level.by_cartilage ? "" : " by the front ends of the bony ribs, because their cartilages have no labels")
            + "; there the saw turns under the skin "
            + (across      ? "to both edges of the sternum."
                    : left ? "to the sternum's left edge."
                           : "to the sternum's right edge.")
            + " The skin is cut as far as the bone is sawn; in theatre a shorter cut is moved over the bone."
            + wall_words(approach, omitted);
    }

    // ---- between two ribs ------------------------------------------------------------------------------------------

    /// A place in an intercostal space.
    struct SpaceNode {
        double angle_deg = 0.0; ///< angle round the chest, see RibLine
        Vec3 cut = Vec3::Zero(); ///< above the lower rib, see SpacePlace
        Vec3 outward = Vec3::Zero(); ///< unit vector at right angles to the space and to the line between the ribs
        Vec3 skin = Vec3::Zero();
        double gap_mm = 0.0; ///< between the two ribs' surfaces
        double along = 0.0; ///< mm along the skin from the first node
        bool free = true; ///< no bone lies over the place (the shoulder blade)
    };

    /// The whole space from back to front, over the length of both ribs.
    std::vector<SpaceNode> space_nodes(const BodyProbe& probe, const Anatomy& anatomy, bool left, int space)
    {
        std::vector<SpaceNode> nodes;
        for (const SpacePlace& place : find_intercostal_space(probe, anatomy, left, space).places) {
            const auto skin = probe.first_skin_along(place.cut, place.outward);
            if (!skin)
                throw InputError("no skin outside the " + space_name(left, space) + " near " + in_words(place.cut));
            SpaceNode node { .angle_deg = place.angle_deg,
                .cut = place.cut,
                .outward = place.outward,
                .skin = place.cut + *skin * place.outward,
                .gap_mm = place.gap_mm };
            if (!nodes.empty())
                node.along = nodes.back().along + (node.skin - nodes.back().skin).norm();
            nodes.push_back(node);
        }
        return nodes;
    }

    /// Smallest distance (mm) from a stretch of the blade to a voxel of the mask, at most `reach`.
    double clearance(const mesh::LabelVolume& labels, const mesh::LabelFlags& mask, const Vec3& skin,
        const Vec3& inward, double depth, double reach)
    {
        const mesh::ImageGrid& grid = labels.grid;
        double least = reach;
        for (double t = 0.0; t <= depth; t += 2.0) {
            const Vec3 centre = grid.index(skin + t * inward);
            const auto low = [&](int a) { return static_cast<int>(std::ceil(centre[a] - least / grid.spacing[a])); };
            const auto high = [&](int a) { return static_cast<int>(std::floor(centre[a] + least / grid.spacing[a])); };
            for (int k = std::max(low(2), 0); k <= std::min(high(2), grid.size[2] - 1); ++k)
                for (int j = std::max(low(1), 0); j <= std::min(high(1), grid.size[1] - 1); ++j)
                    for (int i = std::max(low(0), 0); i <= std::min(high(0), grid.size[0] - 1); ++i)
                        if (const Label label = labels.voxels[grid.offset(i, j, k)]; mask[label] != 0)
                            least = std::min(least, grid.spacing.cwiseProduct(Vec3(i, j, k) - centre).norm());
        }
        return least - 0.5 * grid.spacing.maxCoeff();
    }

    /// Marks the places where no incision is possible: bone or cartilage is in the way (the shoulder blade, ribs that
    /// join), or the line would cross the shoulder or an arm.
    void mark_covered(const mesh::LabelVolume& labels, std::vector<SpaceNode>& nodes)
    {
        constexpr double kReachMm = 4.0, kBelowRibsMm = 8.0;
        const mesh::LabelFlags hard = hard_labels(labels.table);
        const auto cover = [](const SpaceNode& node) { return (node.skin - node.cut).norm(); };
        std::vector<double> covers;
        for (const SpaceNode& node : nodes)
            covers.push_back(cover(node));
        const double thickest = kThickWall * upper_median(covers);
        for (SpaceNode& node : nodes)
            node.free = cover(node) <= thickest
                && clearance(
                       labels, hard, node.skin, -node.outward, (node.skin - node.cut).norm() + kBelowRibsMm, kReachMm)
                    >= 1.25 * kLeastClearanceMm;
        // A jump of the skin means that the line would cross the fold to an arm.
        constexpr double kSteepest = 1.5;
        for (std::size_t n = 1; n < nodes.size(); ++n)
            if (std::abs(cover(nodes[n]) - cover(nodes[n - 1])) > kSteepest * (nodes[n].cut - nodes[n - 1].cut).norm())
                nodes[n].free = nodes[n - 1].free = false;
    }

    struct Window {
        double from = 0.0, to = 0.0; ///< mm along the nodes
        bool slid = false; ///< the window could not stay centred at the wanted place
    };

    /// A window of the wanted length, centred at the wanted place as far as the free stretch between two angles allows.
    Window window_in(const std::vector<SpaceNode>& nodes, double centre, double length, double from_deg, double to_deg)
    {
        Window free_stretch, stretch;
        bool open = false;
        for (const SpaceNode& node : nodes) {
            const bool usable = node.free && node.angle_deg >= from_deg && node.angle_deg <= to_deg;
            if (usable && !open)
                stretch.from = node.along;
            if (usable)
                stretch.to = node.along;
            open = usable;
            if (stretch.to - stretch.from > free_stretch.to - free_stretch.from)
                free_stretch = stretch;
        }
        const double room = free_stretch.to - free_stretch.from;
        if (room < 0.5 * length)
            throw InputError("only " + in_words(room) + " mm of the space are free for an incision of "
                    + in_words(length) + " mm: give a shorter length or another space",
                "length", { "length_mm", "template_name" });
        const double taken = std::min(length, room);
        const double from = std::clamp(centre - 0.5 * taken, free_stretch.from, free_stretch.to - taken);
        return { from, from + taken, std::abs(from + 0.5 * taken - centre) > 1.0 };
    }

    /// Interpolates the node values at places along the space, and projects the places onto the skin.
    void sample_window(
        const BodyProbe& probe, const std::vector<SpaceNode>& nodes, const Window& window, Approach& approach)
    {
        const double length = window.to - window.from;
        const int count = std::max(2, static_cast<int>(std::ceil(length / kPointSpacingMm - 0.0123)));
        std::size_t n = 0;
        for (int i = 0; i <= count; ++i) {
            const double along = window.from + length * i / count;
            while (n + 2 < nodes.size() && nodes[n + 1].along < along)
                ++n;
            const double t = std::clamp((along - nodes[n].along) / (nodes[n + 1].along - nodes[n].along), 0.0, 1.0);
            const Vec3 cut = (1.0 - t) * nodes[n].cut + t * nodes[n + 1].cut;
            const Vec3 outward = ((1.0 - t) * nodes[n].outward + t * nodes[n + 1].outward).normalized();
            const auto skin = probe.first_skin_along(cut, outward);
            if (!skin)
                throw InputError("no skin outside the ribs near " + in_words(cut));
            approach.incision.push_back(cut + *skin * outward);
            approach.directions.push_back(-outward);
            approach.hook_depth_mm.push_back(*skin);
        }
    }

    /// Refuses a blade that would touch bone. @returns the clearance beside the blade, in words
    std::string check_clearance(const mesh::LabelVolume& labels, const Approach& approach, const std::string& space)
    {
        constexpr double kReachMm = 12.0;
        const mesh::LabelFlags hard = hard_labels(labels.table);
        double room = kReachMm;
        for (std::size_t n = 0; n < approach.incision.size(); ++n)
            room = std::min(room,
                clearance(labels, hard, approach.incision[n], approach.directions[n], approach.depth_mm, kReachMm));
        if (room < kLeastClearanceMm)
            throw InputError("the " + space + " is too narrow: the blade would pass " + in_words(std::max(room, 0.0), 1)
                    + " mm from bone or cartilage; choose another space or give the incision by points",
                "template", { "template_name", "points" });
        return " The blade keeps at least " + in_words(room, 1) + " mm from every bone and cartilage.";
    }

    /// Distance (mm) of the target's centre from the space, and the nearest place along the space.
    std::pair<double, double> nearest_to(const std::vector<SpaceNode>& nodes, const Vec3& target)
    {
        std::pair<double, double> best { std::numeric_limits<double>::infinity(), 0.0 };
        for (const SpaceNode& node : nodes)
            best = std::min(best, std::pair((node.cut - target).norm(), node.along));
        return best;
    }

    /// Mean height of the cut above the lower rib in a window, mm.
    double mean_height(const std::vector<SpaceNode>& nodes, const Window& window)
    {
        double sum = 0.0, count = 0.0;
        for (const SpaceNode& node : nodes)
            if (node.along >= window.from && node.along <= window.to) {
                sum += height_of_cut(node.gap_mm);
                count += 1.0;
            }
        return count > 0.0 ? sum / count : 0.0;
    }

    double along_at_angle(const std::vector<SpaceNode>& nodes, double angle_deg)
    {
        RETRACTOR_ASSERT(!nodes.empty());
        for (std::size_t n = 1; n < nodes.size(); ++n)
            if (nodes[n].angle_deg >= angle_deg) {
                const double t = (angle_deg - nodes[n - 1].angle_deg) / (nodes[n].angle_deg - nodes[n - 1].angle_deg);
                return nodes[n - 1].along + t * (nodes[n].along - nodes[n - 1].along);
            }
        return nodes.back().along;
    }

    struct SpacePlan {
        bool left = true;
        std::vector<int> spaces; ///< candidates; the space nearest to the target is taken
        double length_mm = 0.0;
        double shift_mm = 0.0; ///< of the centre, towards the front
        double centre_deg = -1.0; ///< negative: nearest to the target
        double from_deg = 0.0, to_deg = 360.0; ///< allowed range of the incision on the chest
        std::string words; ///< description of the template
    };

    void place_in_space(
        const BodyProbe& probe, const Anatomy& anatomy, const SpacePlan& plan, const Vec3& target, Approach& approach)
    {
        int space = 0;
        std::vector<SpaceNode> nodes;
        double nearest = std::numeric_limits<double>::infinity();
        for (const int candidate : plan.spaces) {
            auto these = space_nodes(probe, anatomy, plan.left, candidate);
            if (const double distance = nearest_to(these, target).first; distance < nearest) {
                nearest = distance;
                space = candidate;
                nodes = std::move(these);
            }
        }
        mark_covered(probe.labels(), nodes);
        const bool faces = plan.centre_deg < 0.0;
        const double centre = faces ? nearest_to(nodes, target).second : along_at_angle(nodes, plan.centre_deg);
        Window window = window_in(nodes, centre, plan.length_mm, plan.from_deg, plan.to_deg);
        const double unmoved = window.from;
        if (plan.shift_mm != 0.0) // from where the incision has come to lie, which may not be the wanted centre
            window = window_in(
                nodes, 0.5 * (window.from + window.to) + plan.shift_mm, plan.length_mm, plan.from_deg, plan.to_deg);
        sample_window(probe, nodes, window, approach);
        const std::size_t omitted = measure_wall(probe, approach);
        const std::string name = space_name(plan.left, space);
        approach.template_name
            = approach.template_name.substr(0, approach.template_name.find(':')) + ":" + std::to_string(space);
        const std::string room = check_clearance(probe.labels(), approach, name);
        approach.rationale = plan.words + " The line lies about " + in_words(mean_height(nodes, window))
            + " mm above rib " + std::to_string(space + 1) + " in the " + name + ", for "
            + in_words(incision_length(approach)) + " mm."
            + (plan.spaces.size() > 1 ? " Of the spaces offered this one lies nearest to the target." : "")
            + (faces ? " It is centred where the space comes nearest to the target (" + in_words(nearest) + " mm)" : "")
            + (faces
                    ? (window.slid ? ", as far as the shoulder blade, the back muscles and the ribs' ends allow." : ".")
                    : "")
            + (window.to - window.from < plan.length_mm - 1.0
                    ? " The space leaves no room for the " + in_words(plan.length_mm) + " mm that were asked."
                    : "")
            + (plan.shift_mm != 0.0 ? " It is moved along the space by " + in_words(std::abs(window.from - unmoved))
                        + " mm towards the " + (plan.shift_mm > 0.0 ? "front." : "back.")
                                    : "")
            + room + wall_words(approach, omitted);
    }

    SpacePlan plan_for(const ParsedTemplate& parsed, const ApproachRequest& request)
    {
        RETRACTOR_ASSERT(parsed.kind != "intercostal" || parsed.space > 0); // parse_template() refuses it
        const auto length = [&](double standard) { return request.length_mm > 0.0 ? request.length_mm : standard; };
        if (parsed.kind == "distal")
            return { .left = true,
                .spaces = { parsed.space > 0 ? parsed.space : 6 },
                .length_mm = length(160.0),
                .shift_mm = request.shift_mm,
                .from_deg = 35.0, // lateral to the long muscles of the back
                .to_deg = 135.0,
                .words = "Left posterolateral thoracotomy for the distal arch and the descending aorta." };
        if (parsed.kind == "midcab")
            return { .left = true,
                .spaces = parsed.space > 0 ? std::vector { parsed.space } : std::vector { 4, 5 },
                .length_mm = length(70.0),
                .shift_mm = request.shift_mm,
                .from_deg = 95.0,
                .to_deg = 163.0, // the internal thoracic artery runs beside the sternum
                .words = "MIDCAB: left anterior mini-thoracotomy." };
        if (parsed.kind == "right-anterior")
            return { .left = false,
                .spaces = parsed.space > 0 ? std::vector { parsed.space } : std::vector { 2, 3 },
                .length_mm = length(60.0),
                .shift_mm = request.shift_mm,
                .from_deg = 110.0,
                .to_deg = 163.0,
                .words = "Right anterior mini-thoracotomy." };
        if (parsed.kind == "right-lateral")
            return { .left = false,
                .spaces = { parsed.space > 0 ? parsed.space : 4 },
                .length_mm = length(70.0),
                .shift_mm = request.shift_mm,
                .centre_deg = 112.0, // about the anterior axillary line
                .from_deg = 75.0,
                .to_deg = 150.0,
                .words = "Right lateral mini-thoracotomy, centred about the anterior axillary line." };
        return { .left = request.left,
            .spaces = { parsed.space },
            .length_mm = length(170.0),
            .shift_mm = request.shift_mm,
            .centre_deg = 95.0,
            .from_deg = 35.0,
            .words = "Lateral thoracotomy, centred just in front of the mid-axillary line." };
    }

    /// Names of the labels that do not belong to the wall.
    std::string possible_targets(const mesh::LabelTable& table)
    {
        std::vector<std::string> names;
        for (const mesh::LabelInfo& info : table)
            if (!mesh::is_wall(info))
                names.push_back(info.name);
        return names.empty() ? std::string("none") : joined(names);
    }

    /// Refuses a target that is not in the body, behind the wall.
    void check_target(const mesh::LabelVolume& labels, const TargetSpec& target)
    {
        if (target.is_sphere()) {
            if (mesh::label_at(labels, target.centre) == 0)
                throw InputError("the sphere's centre lies outside the body", "target", { "target" });
            return;
        }
        const mesh::LabelInfo* info = mesh::find_label(labels.table, target.label);
        if (info == nullptr)
            throw InputError("there is no label \"" + target.label + "\"; the labels that can be a target are "
                    + possible_targets(labels.table),
                "target", { "target" });
        if (info->role == mesh::Role::wall)
            throw InputError(
                "\"" + target.label + "\" is a part of the wall, which is cut: choose an organ, or a sphere", "target",
                { "target" });
        if (target.is_site())
            check_site(labels, target);
    }

    void check_request(const mesh::LabelVolume& labels, const ApproachRequest& request)
    {
        if (!(request.length_mm >= 0.0 && request.length_mm <= 1000.0))
            throw InputError("the length must be between 0 and 1000 mm, got " + std::to_string(request.length_mm),
                "length", { "length_mm" });
        check_target(labels, request.target);
    }

    Approach start(const ApproachRequest& request, const std::string& template_name)
    {
        Approach approach;
        approach.name = request.name;
        if (approach.name.empty())
            std::replace_copy(template_name.begin(), template_name.end(), std::back_inserter(approach.name), ':', '_');
        approach.template_name = template_name;
        approach.target = request.target;
        approach.division.extent = request.division.value_or(DivisionExtent::skin);
        approach.sizing = request.sizing;
        approach.view = request.view;
        return approach;
    }

    void add_target_words(const mesh::LabelVolume& labels, Approach& approach)
    {
        const Vec3 target = target_centre(labels, approach.target);
        double nearest = std::numeric_limits<double>::infinity();
        for (const Vec3& point : approach.incision)
            nearest = std::min(nearest, (point - target).norm());
        approach.rationale
            += std::string(kTargetWords) + in_words(nearest) + " mm from the nearest point of the incision.";
    }

} // namespace

std::vector<std::string> retracted_organs(
    const mesh::LabelTable& table, bool left_lung, bool right_lung, bool pericardium)
{
    std::vector<std::string> names;
    for (const mesh::LabelInfo& info : table) {
        if (info.role == mesh::Role::target || info.role == mesh::Role::wall)
            continue;
        const bool lung = info.name.starts_with("lung");
        const bool right = info.name.find("right") != std::string::npos;
        const bool left = info.name.find("left") != std::string::npos;
        if ((lung && ((left && left_lung) || (right && right_lung))) || info.name == "mediastinal_fat"
            || info.name == "mediastinum" || (pericardium && info.name == "pericardium"))
            names.push_back(info.name);
    }
    return names;
}

Approach approach_from_template(const mesh::LabelVolume& labels, const ApproachRequest& request)
{
    parse_template(request.template_name); // a misspelt template is refused before the search for landmarks
    check_request(labels, request);
    return approach_from_template(labels, find_anatomy(labels), request);
}

Approach approach_from_template(const mesh::LabelVolume& labels, const Anatomy& anatomy, const ApproachRequest& request)
{
    const ParsedTemplate parsed = parse_template(request.template_name);
    check_request(labels, request);
    if (is_sternal(parsed.kind) && request.length_mm > 0.0)
        throw InputError(parsed.kind == "median"
                ? "a median sternotomy is as long as the sternum: give no length, or give the incision by points"
                : "a hemisternotomy ends at its space: give no length but another space, or give the incision by "
                  "points",
            "length", { "length_mm", "points" });
    const BodyProbe probe(labels);
    Approach approach = start(request, request.template_name);
    approach.uncut_labels = bone_names(labels.table);
    if (is_sternal(parsed.kind)) {
        if (parsed.kind == "median")
            place_median(probe, anatomy, approach);
        else
            place_hemisternotomy(probe, anatomy, parsed, approach);
        approach.division.extent = request.division.value_or(approach.division.extent);
        // The saw goes through the sternum, and through calcified cartilage without a name of its own.
        for (const char* sawn : { "sternum", "bone_other" })
            std::erase(approach.uncut_labels, sawn);
        approach.retracted = retracted_organs(labels.table, true, true, true);
    } else {
        const SpacePlan plan = plan_for(parsed, request);
        place_in_space(probe, anatomy, plan, target_centre(labels, request.target), approach);
        approach.division.extent = request.division.value_or(DivisionExtent::full);
        const bool opens_pericardium = parsed.kind != "intercostal" && parsed.kind != "distal";
        approach.retracted = retracted_organs(labels.table, plan.left, !plan.left, opens_pericardium);
    }
    check_sweep(approach);
    static_cast<void>(mesh::SweptBlade(blade_of(approach))); // the cutter's own check, before planning
    add_target_words(labels, approach);
    check_approach(approach);
    return approach;
}

PointsApproach approach_from_points(const mesh::LabelVolume& labels, const std::vector<Vec3>& points,
    const ApproachRequest& request, double depth_mm, double reach_mm)
{
    check_request(labels, request);
    if (points.size() < 2)
        throw InputError(
            "an incision needs at least two points, got " + std::to_string(points.size()), "points", { "points" });
    if (!(depth_mm >= 0.0 && depth_mm <= 1000.0))
        throw InputError("the depth must be between 0 and 1000 mm", "depth", { "depth_mm" });
    const BodyProbe probe(labels);
    PointsApproach result { .approach = start(request, "points"), .moved_mm = {} };
    Approach& approach = result.approach;
    std::vector<Vec3> on_skin;
    for (std::size_t n = 0; n < points.size(); ++n) {
        const std::string where = point_name(n);
        if (!points[n].allFinite())
            throw InputError("the point is not a finite number of mm", where, { "points" });
        try {
            on_skin.push_back(probe.project_to_skin(points[n]));
        } catch (const InputError& error) {
            throw InputError(error.what(), where, { "points" });
        }
        result.moved_mm.push_back((on_skin.back() - points[n]).norm());
        if (result.moved_mm.back() > reach_mm)
            throw InputError("the point " + in_words(points[n]) + " is " + in_words(result.moved_mm.back())
                    + " mm off the skin; at most " + in_words(reach_mm) + " mm are allowed",
                where, { "points" });
        if (n > 0 && (on_skin[n] - on_skin[n - 1]).norm() < 1.0)
            throw InputError("two neighbouring points meet on the skin", where, { "points" });
    }
    std::vector<std::size_t> given;
    for (std::size_t n = 0; n + 1 < on_skin.size(); ++n) {
        const Vec3 step = on_skin[n + 1] - on_skin[n];
        const int count = std::max(1, static_cast<int>(std::ceil(step.norm() / kPointSpacingMm - 0.0123)));
        for (int i = n == 0 ? 0 : 1; i <= count; ++i) {
            given.push_back(i == count ? n + 1 : n);
            const bool is_given = i == 0 || i == count;
            const Vec3 between = on_skin[n] + step * i / count;
            approach.incision.push_back(is_given ? on_skin[n + (i == count ? 1 : 0)] : probe.project_to_skin(between));
        }
    }
    std::vector<Vec3> inward;
    for (const Vec3& point : approach.incision)
        inward.push_back(-probe.skin_normal(point, 30.0));
    inward = smoothed(inward, 1.5);
    const std::vector<Vec3> along = tangents(approach.incision), square = blade_directions(inward, along, 0.0);
    // Where the skin bends sharply, a deep blade square to it would fold over itself. A surgeon holds it straighter.
    std::size_t omitted = 0;
    double turned_deg = 0.0;
    for (const double share : { 0.0, 0.25, 0.5, 0.75, 1.0 }) {
        approach.directions = blade_directions(inward, along, share);
        turned_deg = largest_turn_deg(square, approach.directions);
        approach.depth_mm = depth_mm;
        if (!(depth_mm > 0.0))
            omitted = measure_wall(probe, approach);
        if (!fold_of(approach) || turned_deg > kLargestTurnDeg)
            break;
    }
    const double farthest = *std::max_element(result.moved_mm.begin(), result.moved_mm.end());
    constexpr double kSaidDeg = 0.5; // less is 0 in whole degrees
    approach.rationale = "Incision through " + std::to_string(points.size())
        + " given points, put on the skin (moved by at most " + in_words(farthest, 1) + " mm), blade square to the skin"
        + (turned_deg >= kSaidDeg ? " but for up to " + in_words(turned_deg)
                    + " degrees, by which it is straightened so as not to fold over "
                      "itself."
                                  : ".");
    if (!(depth_mm > 0.0))
        approach.rationale += wall_words(approach, omitted);
    approach.uncut_labels = bone_names(labels.table);
    check_sweep(approach);
    check_crossing(approach, points, given);
    add_target_words(labels, approach);
    check_approach(approach);
    return result;
}

} // namespace retractor::planner
