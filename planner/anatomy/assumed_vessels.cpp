#include "planner/anatomy/assumed_vessels.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/statistics.h"
#include "planner/anatomy/body_probe.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kLevelMm = 5.0; ///< between places of a mammary artery along the sternum
    /// Share of the sternum's length, from the notch, along which the artery runs: it divides above the xiphoid.
    constexpr double kFirstShare = 0.05, kLastShare = 0.85;
    /// The sternum's edge is taken over this distance up and down, so that notches for the cartilages leave no wave.
    constexpr double kEdgeMeanMm = 20.0;
    /// The artery lies on the inner side of the wall, and the wall's inner side at most this far behind the sternum's
    /// middle. Labels that hide the lung's border would move it into the chest.
    constexpr double kInWallMm = 2.0, kFarthestBehindMm = 20.0;
    /// The bundle joins the rib's groove about here; nearer to the spine it runs in the middle of the space (ours).
    constexpr double kGrooveFromDeg = 45.0;
    constexpr double kMarchMm = 0.5, kHighestRibMm = 12.0;
    /// The groove is on the inner side of the rib's lower edge: vein and artery lie in it, the nerve at the edge.
    constexpr double kBelowEdgeMm = 0.5, kInwardMm = 2.5;
    constexpr int kSmoothings = 3;

    /// Each place but the ends moves to the mean of its neighbours and itself.
    void smooth(std::vector<Vec3>& line)
    {
        for (int n = 0; n < kSmoothings; ++n) {
            std::vector<Vec3> before = line;
            for (std::size_t i = 1; i + 1 < line.size(); ++i)
                line[i] = (before[i - 1] + before[i] + before[i + 1]) / 3.0;
        }
    }

    /// A place of the sternum's midline at a distance from its top, linear between points.
    Vec3 midline_at(const std::vector<Vec3>& midline, double share)
    {
        const double at = share * static_cast<double>(midline.size() - 1);
        const auto n = std::min(static_cast<std::size_t>(at), midline.size() - 2);
        return midline[n] + (at - static_cast<double>(n)) * (midline[n + 1] - midline[n]);
    }

    /// Where the sternum's edges are, by the distance from its top, as distances to the patient's left.
    class SternumEdges {
    public:
        SternumEdges(const mesh::LabelVolume& labels, const Anatomy& anatomy)
            : sternum_(anatomy.sternum)
            , half_voxel_(0.5 * labels.grid.spacing.minCoeff())
        {
            const mesh::LabelInfo& info = mesh::label_named(labels.table, "sternum");
            mesh::visit_voxels(labels, [&](int i, int j, int k, Label label) {
                if (label != info.id)
                    return;
                const Vec3 p = labels.grid.world(Vec3(i, j, k));
                lateral_[bin(sternum_.axis.dot(sternum_.top - p))].push_back(anatomy.frame.left.dot(p));
            });
        }
        double length() const { return (sternum_.top - sternum_.bottom).norm(); }
        /// Labels of the sternum often run into a calcified cartilage of one side. So the nearer edge counts at each
        /// height, from the middle of most of the bone, and of the heights around the median.
        /// @returns middle and half width, mm; nothing where no sternum is labelled near this height
        std::optional<std::pair<double, double>> middle_and_half_width(double down_mm) const
        {
            std::vector<double> all, half_widths;
            const int reach = static_cast<int>(kEdgeMeanMm / kLevelMm), here = bin(down_mm);
            const auto visit = [&](const auto& take) {
                for (int b = here - reach; b <= here + reach; ++b)
                    if (const auto found = lateral_.find(b); found != lateral_.end())
                        take(found->second);
            };
            visit([&](const std::vector<double>& level) { all.insert(all.end(), level.begin(), level.end()); });
            if (all.empty())
                return std::nullopt;
            const double middle = upper_median(all);
            visit([&](const std::vector<double>& level) {
                const auto [least, most] = std::ranges::minmax(level);
                half_widths.push_back(std::max(0.0, std::min(most - middle, middle - least)) + half_voxel_);
            });
            return std::pair(middle, upper_median(half_widths));
        }

    private:
        static int bin(double down_mm) { return static_cast<int>(std::floor(down_mm / kLevelMm)); }

        const SternumAxis& sternum_;
        double half_voxel_;
        std::map<int, std::vector<double>> lateral_; ///< of the voxels at each height
    };

    std::vector<Vec3> mammary_line(
        const SternumEdges& edges, const BodyProbe& probe, const Anatomy& anatomy, bool is_left)
    {
        std::vector<Vec3> line;
        const Vec3 aside = is_left ? anatomy.frame.left : Vec3(-anatomy.frame.left);
        const Vec3& anterior = anatomy.frame.anterior;
        for (double down = kFirstShare * edges.length(); down <= kLastShare * edges.length(); down += kLevelMm) {
            const auto edge = edges.middle_and_half_width(down);
            if (!edge)
                continue;
            Vec3 beside = midline_at(anatomy.sternum.midline, down / edges.length());
            beside += (edge->first - anatomy.frame.left.dot(beside)) * anatomy.frame.left;
            beside += (edge->second + kMammaryFromSternumMm) * aside;
            const auto to_skin = probe.first_skin_along(beside, anterior);
            if (!to_skin)
                continue;
            const Vec3 skin = beside + *to_skin * anterior;
            const auto thickness = probe.wall_thickness(skin, -anterior);
            const double behind = thickness ? *thickness - *to_skin - kInWallMm : kFarthestBehindMm;
            line.push_back(beside - std::clamp(behind, 0.0, kFarthestBehindMm) * anterior);
        }
        smooth(line);
        return line;
    }

    /// The way from the middle of a rib to its lower edge; nothing where the place is not in the rib's bone.
    std::optional<double> below_middle(const mesh::LabelVolume& labels, Label rib, const Vec3& middle, const Vec3& down)
    {
        if (mesh::label_at(labels, middle) != rib)
            return std::nullopt;
        double last = 0.0;
        for (double way = 0.0; way <= kHighestRibMm; way += kMarchMm)
            if (mesh::label_at(labels, middle + way * down) == rib)
                last = way;
        return last + kMarchMm;
    }

    std::vector<Vec3> bundle_line(const mesh::LabelVolume& labels, const RibLine& rib, const AnatomicalFrame& frame)
    {
        std::vector<Vec3> line, downwards;
        for (std::size_t n = 1; n + 1 < rib.points.size(); ++n) {
            if (rib.angle_deg[n] < kGrooveFromDeg)
                continue;
            const Vec3& middle = rib.points[n];
            const Vec3 along = (rib.points[n + 1] - rib.points[n - 1]).normalized();
            Vec3 outward = middle - frame.origin;
            outward -= outward.dot(frame.superior) * frame.superior;
            outward = (outward - outward.dot(along) * along).normalized();
            Vec3 down = along.cross(outward).normalized();
            if (down.dot(frame.superior) > 0.0)
                down = -down;
            if (const auto edge = below_middle(labels, rib.label, middle, down)) {
                line.push_back(middle + (*edge + kBelowEdgeMm) * down - kInwardMm * outward);
                downwards.push_back(down);
            }
        }
        smooth(line);
        for (std::size_t n = 0; n < line.size(); ++n) // smoothing may have moved it into the bone
            for (double way = 0.0; way < kHighestRibMm && mesh::label_at(labels, line[n]) == rib.label; way += kMarchMm)
                line[n] += kMarchMm * downwards[n];
        return line;
    }

    void add_named(std::vector<AssumedVessel>& vessels, const mesh::LabelTable& table, std::string name,
        std::vector<Vec3> line, double radius_mm)
    {
        if (line.size() >= 2 && !is_labelled(name, table))
            vessels.push_back({ .name = std::move(name), .line = std::move(line), .radius_mm = radius_mm });
    }

} // namespace

std::vector<AssumedVessel> assumed_vessels(const mesh::LabelVolume& labels, const Anatomy& anatomy)
{
    std::vector<AssumedVessel> vessels;
    if (anatomy.sternum.midline.size() >= 2) {
        const SternumEdges edges(labels, anatomy);
        const BodyProbe probe(labels);
        for (const bool is_left : { true, false })
            add_named(vessels, labels.table, std::string("mammary_artery_") + (is_left ? "left" : "right"),
                mammary_line(edges, probe, anatomy, is_left), kMammaryRadiusMm);
    }
    for (const RibLine& rib : anatomy.ribs)
        if (rib.number <= kLastRibWithBundle)
            add_named(vessels, labels.table,
                std::string("neurovascular_bundle_") + (rib.left ? "left_" : "right_") + std::to_string(rib.number),
                bundle_line(labels, rib, anatomy.frame), kBundleRadiusMm);
    return vessels;
}

std::vector<AssumedVessel> assumed_vessels(const mesh::LabelVolume& labels)
{
    try {
        return assumed_vessels(labels, find_anatomy(labels));
    } catch (const InputError&) { // no chest, or one whose bones have other names
        return {};
    }
}

bool is_mammary(std::string_view name)
{
    const auto has = [&](std::string_view word) { return name.find(word) != std::string_view::npos; };
    return has("mammary_artery") || has("internal_mammary") || has("internal_thoracic") || has("thoracica_interna");
}

bool is_labelled(std::string_view vessel, const mesh::LabelTable& table)
{
    const auto is_other_side = [&](std::string_view label) {
        const auto has = [](std::string_view name, const char* side) { return name.find(side) != name.npos; };
        return (has(label, "left") && has(vessel, "right")) || (has(label, "right") && has(vessel, "left"));
    };
    return std::ranges::any_of(table, [&](const mesh::LabelInfo& info) {
        return info.name == vessel || (is_mammary(vessel) && is_mammary(info.name) && !is_other_side(info.name));
    });
}

bool is_neurovascular_bundle(std::string_view name) { return name.starts_with("neurovascular_bundle"); }

std::vector<Vec3> places_along(const AssumedVessel& vessel, double step_mm)
{
    RETRACTOR_ASSERT(step_mm > 0.0);
    std::vector<Vec3> places;
    for (std::size_t n = 0; n + 1 < vessel.line.size(); ++n) {
        const Vec3 &from = vessel.line[n], to = vessel.line[n + 1];
        const int steps = std::max(1, static_cast<int>(std::ceil((to - from).norm() / step_mm)));
        for (int i = 0; i < steps; ++i)
            places.push_back(from + (to - from) * i / steps);
    }
    if (!vessel.line.empty())
        places.push_back(vessel.line.back());
    return places;
}

} // namespace retractor::planner
