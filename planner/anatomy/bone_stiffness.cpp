#include "planner/anatomy/bone_stiffness.h"

#include "mesh/base/error.h"
#include "mesh/base/statistics.h"
#include "mesh/base/text_format.h"
#include "mesh/image/skeleton.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <queue>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr double kSliceMm = 8.0; // three voxels of a CT at half resolution
    constexpr double kEndMm = 16.0; // head and neck at the spine; the front end, blurred with cartilage
    constexpr std::size_t kFewestSections = 4;
    /// Inner voxels that are brighter than marrow and differ by less are one value with noise, as in a phantom. The
    /// inside of a real rib is dark, or differs by hundreds where cortex and trabeculae are near.
    constexpr double kLeastContrastHU = 100.0, kBrightHU = 300.0;
    constexpr std::size_t kFewestInner = 30;
    /// A smaller share of cortex than any rib has: the values are not Hounsfield units of bone.
    constexpr double kLeastShare = 0.03;
    constexpr double kLeastBlurMm = 1.5; // cortex that blurring has moved outside the label lies within

    using Index = std::array<int, 3>;

    /// A CT value between voxel centres, trilinear; at the border of the image the nearest value.
    double value_at(const mesh::Volume& ct, const Vec3& world)
    {
        const Vec3 at = ct.grid.index(world);
        std::array<int, 3> low {};
        std::array<double, 3> share {};
        for (std::size_t a = 0; a < 3; ++a) {
            const double last = ct.grid.size[a] - 1.0;
            const double clamped = std::clamp(at[static_cast<Eigen::Index>(a)], 0.0, last);
            low[a] = std::min(static_cast<int>(clamped), std::max(0, ct.grid.size[a] - 2));
            share[a] = clamped - low[a];
        }
        double value = 0.0;
        for (int corner = 0; corner < 8; ++corner) {
            std::array<int, 3> voxel {};
            double weight = 1.0;
            for (std::size_t a = 0; a < 3; ++a) {
                const int step = (corner >> a) & 1;
                voxel[a] = std::min(low[a] + step, ct.grid.size[a] - 1);
                weight *= step == 1 ? share[a] : 1.0 - share[a];
            }
            if (weight > 0.0)
                value += weight * ct.voxels[ct.grid.offset(voxel[0], voxel[1], voxel[2])];
        }
        return value;
    }

    /// The voxels of one label with a box round them.
    class LabelVoxels {
    public:
        static constexpr std::int32_t kNone = -1;

        LabelVoxels(const mesh::LabelVolume& labels, std::vector<Index> voxels)
            : labels_(labels)
            , voxels_(std::move(voxels))
        {
            constexpr int kMargin = 4; // more than the reach of blurring
            low_ = high_ = voxels_.front();
            for (const Index& v : voxels_)
                for (std::size_t a = 0; a < 3; ++a) {
                    low_[a] = std::min(low_[a], v[a]);
                    high_[a] = std::max(high_[a], v[a]);
                }
            std::size_t count = 1;
            for (std::size_t a = 0; a < 3; ++a) {
                low_[a] = std::max(0, low_[a] - kMargin);
                high_[a] = std::min(labels.grid.size[a] - 1, high_[a] + kMargin);
                count *= static_cast<std::size_t>(high_[a] - low_[a] + 1);
            }
            id_.assign(count, kNone);
            for (std::size_t i = 0; i < voxels_.size(); ++i)
                id_[place(voxels_[i])] = static_cast<std::int32_t>(i);
        }

        const std::vector<Index>& voxels() const { return voxels_; }
        bool contains(const Index& v) const
        {
            for (std::size_t a = 0; a < 3; ++a)
                if (v[a] < low_[a] || v[a] > high_[a])
                    return false;
            return true;
        }
        /// Number of the voxel in voxels(), or kNone. @pre contains(v)
        std::int32_t id(const Index& v) const { return id_[place(v)]; }
        Label label(const Index& v) const { return labels_.voxels[labels_.grid.offset(v[0], v[1], v[2])]; }
        /// A flag per voxel of the box.
        std::vector<std::uint8_t> flags() const { return std::vector<std::uint8_t>(id_.size(), 0); }
        std::size_t place(const Index& v) const
        {
            const auto side = [&](std::size_t a) { return static_cast<std::size_t>(high_[a] - low_[a] + 1); };
            const auto from = [&](std::size_t a) { return static_cast<std::size_t>(v[a] - low_[a]); };
            return (from(2) * side(1) + from(1)) * side(0) + from(0);
        }

        /// Distance through the voxels from one of them, over their 26 neighbours, mm; infinite where not connected.
        std::vector<double> distances(std::size_t from) const
        {
            std::vector<double> distance(voxels_.size(), std::numeric_limits<double>::infinity());
            using Entry = std::pair<double, std::size_t>;
            std::priority_queue<Entry, std::vector<Entry>, std::greater<>> next;
            distance[from] = 0.0;
            next.emplace(0.0, from);
            while (!next.empty()) {
                const auto [d, at] = next.top();
                next.pop();
                if (d > distance[at])
                    continue;
                for (int dk = -1; dk <= 1; ++dk)
                    for (int dj = -1; dj <= 1; ++dj)
                        for (int di = -1; di <= 1; ++di) {
                            const Index v { voxels_[at][0] + di, voxels_[at][1] + dj, voxels_[at][2] + dk };
                            if (!contains(v) || id(v) == kNone)
                                continue;
                            const auto to = static_cast<std::size_t>(id(v));
                            const double there = d + labels_.grid.spacing.cwiseProduct(Vec3(di, dj, dk)).norm();
                            if (there < distance[to]) {
                                distance[to] = there;
                                next.emplace(there, to);
                            }
                        }
            }
            return distance;
        }

    private:
        const mesh::LabelVolume& labels_;
        std::vector<Index> voxels_;
        Index low_ {}, high_ {};
        std::vector<std::int32_t> id_;
    };

    std::vector<Index> voxels_of(const mesh::LabelVolume& labels, Label wanted)
    {
        std::vector<Index> voxels;
        mesh::visit_voxels(labels, [&](int i, int j, int k, Label label) {
            if (label == wanted)
                voxels.push_back({ i, j, k });
        });
        return voxels;
    }

    /// The number of the farthest voxel; voxels that are not connected do not count.
    std::size_t farthest(const std::vector<double>& distance)
    {
        std::size_t most = 0;
        for (std::size_t i = 0; i < distance.size(); ++i)
            if (std::isfinite(distance[i]) && (!std::isfinite(distance[most]) || distance[i] > distance[most]))
                most = i;
        return most;
    }

    /// Distance of each voxel from an end of the label's largest piece; infinite outside this piece.
    std::vector<double> along_largest_piece(const LabelVoxels& rib)
    {
        std::vector<std::uint8_t> seen(rib.voxels().size(), 0);
        std::vector<double> largest;
        std::size_t most = 0;
        for (std::size_t start = 0; start < seen.size(); ++start) {
            if (seen[start] != 0)
                continue;
            std::vector<double> distance = rib.distances(start);
            std::size_t count = 0;
            for (std::size_t i = 0; i < distance.size(); ++i)
                if (std::isfinite(distance[i])) {
                    seen[i] = 1;
                    ++count;
                }
            if (count > most) {
                most = count;
                largest = std::move(distance);
            }
            if (2 * most > seen.size())
                break;
        }
        return rib.distances(farthest(largest));
    }

    /// Steps to neighbours within `reach`, the shortest first.
    std::vector<Index> steps_within(const Vec3& spacing, double reach)
    {
        std::vector<std::pair<double, Index>> steps;
        Index most {};
        for (std::size_t a = 0; a < 3; ++a)
            most[a] = static_cast<int>(std::min(4.0, std::floor(reach / spacing[static_cast<Eigen::Index>(a)] + 1e-9)));
        for (int k = -most[2]; k <= most[2]; ++k)
            for (int j = -most[1]; j <= most[1]; ++j)
                for (int i = -most[0]; i <= most[0]; ++i)
                    if (const double d = spacing.cwiseProduct(Vec3(i, j, k)).norm(); d > 0.0 && d <= reach + 1e-9)
                        steps.push_back({ d, { i, j, k } });
        std::sort(steps.begin(), steps.end());
        std::vector<Index> sorted;
        for (const auto& [d, step] : steps)
            sorted.push_back(step);
        return sorted;
    }

    Index moved(const Index& v, const Index& step) { return { v[0] + step[0], v[1] + step[1], v[2] + step[2] }; }

    double ct_at(const mesh::LabelVolume& labels, const mesh::Volume& ct, const Index& v)
    {
        return value_at(ct, labels.grid.world(Vec3(v[0], v[1], v[2])));
    }

    /// Why values of a rib tell nothing about its cortex; empty: they do.
    std::string without_contrast(const mesh::LabelVolume& labels, const mesh::Volume& ct, const LabelVoxels& rib)
    {
        std::vector<double> inner, all;
        for (const Index& v : rib.voxels()) {
            const double value = ct_at(labels, ct, v);
            all.push_back(value);
            bool inside = true;
            for (int n = 0; n < 27 && inside; ++n) {
                const Index next = moved(v, { n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1 });
                inside = rib.contains(next) && rib.id(next) != LabelVoxels::kNone;
            }
            if (inside)
                inner.push_back(value);
        }
        std::vector<double>& values = inner.size() >= kFewestInner ? inner : all;
        const std::size_t tenth = values.size() / 10;
        const double low = value_of_rank(values, tenth), high = value_of_rank(values, values.size() - 1 - tenth);
        return low > kBrightHU && high - low < kLeastContrastHU
            ? formatted("the CT shows no marrow: it has %.0f to %.0f HU all through the bone", low, high)
            : "";
    }

    void check_share(double share)
    {
        if (!(share >= 0.0 && share <= 1.0))
            throw InputError(formatted("a share must lie between 0 and 1, got %g", share), "share");
    }

    bool is_rib_label(const mesh::LabelInfo& info)
    {
        return info.material == "bone" && info.role == mesh::Role::wall && info.name.starts_with("rib_");
    }

    /// A default of earlier versions, which case files still contain.
    struct FormerDefault {
        std::string_view name;
        double youngs_modulus_MPa;
        std::string_view source; ///< its beginning
    };
    constexpr std::array kFormerDefaults {
        FormerDefault { "bone", 1000.0, "PMC6584379: whole rib, homogenised" },
        FormerDefault { "cartilage", 15.0, "costal cartilage, range 5 - 25 MPa, small strain" },
    };

    /// Whether the case has its own modulus for the material.
    bool is_own(const fem::Material& material)
    {
        const fem::MaterialTable& defaults = fem::default_materials();
        return std::none_of(defaults.begin(), defaults.end(), [&](const fem::Material& known) {
            return known.name == material.name && known.youngs_modulus_MPa == material.youngs_modulus_MPa;
        }) && std::none_of(kFormerDefaults.begin(), kFormerDefaults.end(), [&](const FormerDefault& known) {
            return known.name == material.name && known.youngs_modulus_MPa == material.youngs_modulus_MPa
                && material.source.starts_with(known.source);
        });
    }

    double cut_off(double modulus) { return std::clamp(modulus, kSoftestRibMPa, kStiffestRibMPa); }

    constexpr const char* kRangeSource = "2 to 8 GPa for whole ribs in bending [Pezowicz 2012]";

    void take_middle(BoneStiffness& bone, const std::string& why)
    {
        const bool rib = bone.material == "bone";
        bone.modulus_MPa = rib ? kMiddleRibMPa : cartilage_modulus_MPa(0.0);
        bone.low_MPa = rib ? kSoftestRibMPa : kPerichondrium * kSoftestCartilageMPa;
        bone.high_MPa = rib ? kStiffestRibMPa : kPerichondrium * kStiffestCartilageMPa;
        bone.words = rib ? std::string("the middle of ") + kRangeSource
                         : "15 MPa (5 to 25) times 1.9 for the perichondrium [Forman 2010], without calcification";
        bone.words += ", because " + why;
    }

    struct Hounsfield {
        double marrow = kMarrowHU, cortex = kCortexHU;
    };

    /// The sections of a rib by each pair of Hounsfield values.
    struct SectionsByValues {
        std::vector<std::vector<double>> shares; ///< one list per pair
        std::string unknown; ///< as RibSections::unknown
    };

    SectionsByValues measure_sections(const mesh::LabelVolume& labels, std::vector<Index> all, const mesh::Volume& ct,
        std::span<const Hounsfield> pairs)
    {
        SectionsByValues found;
        if (all.size() < kFewestInner) {
            found.unknown = "the label has too few voxels";
            return found;
        }
        const LabelVoxels rib(labels, std::move(all));
        found.unknown = without_contrast(labels, ct, rib);
        if (!found.unknown.empty())
            return found;
        const std::vector<double> along = along_largest_piece(rib);
        const double length = along[farthest(along)];
        const auto count = static_cast<std::size_t>(std::max(0.0, std::floor((length - 2.0 * kEndMm) / kSliceMm)));
        if (count < kFewestSections) {
            found.unknown = formatted("only %.0f mm of the bone lie in the image", length);
            return found;
        }
        const double slice_mm = (length - 2.0 * kEndMm) / static_cast<double>(count);
        std::vector<double> outline(count, 0.0);
        std::vector<std::vector<double>> cortex(pairs.size(), outline);
        const auto add = [&](std::size_t voxel, const Index& v, double area) {
            const double at = (along[voxel] - kEndMm) / slice_mm;
            if (!(at >= 0.0 && at < static_cast<double>(count))) // also where not connected
                return;
            const auto slice = static_cast<std::size_t>(at);
            outline[slice] += area;
            const double value = ct_at(labels, ct, v);
            for (std::size_t p = 0; p < pairs.size(); ++p)
                cortex[p][slice]
                    += std::clamp((value - pairs[p].marrow) / (pairs[p].cortex - pairs[p].marrow), 0.0, 1.0);
        };
        std::vector<std::uint8_t> taken = rib.flags();
        for (std::size_t i = 0; i < rib.voxels().size(); ++i) {
            taken[rib.place(rib.voxels()[i])] = 1;
            add(i, rib.voxels()[i], 1.0);
        }
        // Blurring moves a part of the cortex into the voxels round the label; those of other bones are theirs.
        const mesh::LabelFlags skeleton = mesh::flagged_labels(labels.table, mesh::is_skeleton);
        for (const Index& step :
            steps_within(labels.grid.spacing, std::max(kLeastBlurMm, labels.grid.spacing.maxCoeff())))
            for (std::size_t i = 0; i < rib.voxels().size(); ++i) {
                const Index next = moved(rib.voxels()[i], step);
                if (!rib.contains(next) || taken[rib.place(next)] != 0 || skeleton[rib.label(next)] != 0)
                    continue;
                taken[rib.place(next)] = 1;
                add(i, next, 0.0);
            }
        found.shares.resize(pairs.size());
        for (std::size_t p = 0; p < pairs.size(); ++p)
            for (std::size_t s = 0; s < count; ++s)
                if (outline[s] > 0.0)
                    found.shares[p].push_back(std::min(1.0, cortex[p][s] / outline[s]));
        std::vector<double> shares = found.shares.front();
        if (const double median = upper_median(shares); median < kLeastShare)
            found.unknown = formatted("only %.0f %% of its section looks like cortex in the CT", 100.0 * median);
        return found;
    }

    void find_rib(
        BoneStiffness& bone, const mesh::LabelVolume& labels, std::vector<Index> voxels, const mesh::Volume& ct)
    {
        constexpr std::array kPairs { Hounsfield {}, Hounsfield { kMostMarrowHU, kMostCortexHU },
            Hounsfield { kLeastMarrowHU, kLeastCortexHU } };
        SectionsByValues sections = measure_sections(labels, std::move(voxels), ct, kPairs);
        if (!sections.unknown.empty())
            return take_middle(bone, sections.unknown);
        bone.origin = StiffnessOrigin::image;
        bone.sections = sections.shares[0].size();
        bone.share = upper_median(sections.shares[0]);
        const double found = section_modulus_MPa(bone.share);
        bone.modulus_MPa = cut_off(found);
        bone.low_MPa = cut_off(section_modulus_MPa(upper_median(sections.shares[1])));
        bone.high_MPa = cut_off(section_modulus_MPa(upper_median(sections.shares[2])));
        bone.words = formatted("cortex of 13.5 GPa [Subit 2013] over %.0f %% of the section, median of %zu sections in "
                               "the CT",
            100.0 * bone.share, bone.sections);
        if (found != bone.modulus_MPa) {
            bone.cut_off_MPa = found;
            bone.words += formatted(": %.1f GPa, cut off to ", 1e-3 * found) + kRangeSource;
        }
    }

    void find_cartilage(BoneStiffness& bone, const mesh::LabelVolume& labels, const mesh::Volume& ct)
    {
        const std::optional<double> share = calcified_share(labels, bone.label, ct);
        if (!share)
            return take_middle(bone, "no voxel of it lies clear of bone");
        bone.origin = StiffnessOrigin::image;
        bone.share = *share;
        bone.modulus_MPa = cartilage_modulus_MPa(*share);
        bone.low_MPa = bone.modulus_MPa * kSoftestCartilageMPa / kCartilageSubstanceMPa;
        bone.high_MPa = bone.modulus_MPa * kStiffestCartilageMPa / kCartilageSubstanceMPa;
        bone.words = formatted("15 MPa (5 to 25) times 1.9 for the perichondrium [Forman 2010] times %.2f for the "
                               "calcified share of %.1f %% [doi 10.1080/10255842.2012.671307]",
            bone.modulus_MPa / (kCartilageSubstanceMPa * kPerichondrium), 100.0 * *share);
        if (bone.modulus_MPa == cartilage_modulus_MPa(1.0))
            bone.words += ", cut off to the largest ratio measured";
    }

} // namespace

std::string_view to_string(StiffnessOrigin origin)
{
    switch (origin) {
    case StiffnessOrigin::own:
        return "case";
    case StiffnessOrigin::image:
        return "CT";
    case StiffnessOrigin::middle:
        break;
    }
    return "published range";
}

RibSections measure_rib_sections(
    const mesh::LabelVolume& labels, Label rib, const mesh::Volume& ct, double marrow_HU, double cortex_HU)
{
    if (!(std::isfinite(marrow_HU) && std::isfinite(cortex_HU) && marrow_HU < cortex_HU))
        throw InputError(
            formatted("the value of cortex (%g HU) must be above that of marrow (%g HU)", cortex_HU, marrow_HU),
            "cortex_HU");
    const std::array pair { Hounsfield { marrow_HU, cortex_HU } };
    SectionsByValues found = measure_sections(labels, voxels_of(labels, rib), ct, pair);
    return { found.shares.empty() ? std::vector<double>() : std::move(found.shares.front()), std::move(found.unknown) };
}

double section_modulus_MPa(double cortex_share)
{
    check_share(cortex_share);
    const double marrow = 1.0 - cortex_share;
    return kCorticalBoneMPa * (1.0 - marrow * marrow);
}

std::optional<double> calcified_share(const mesh::LabelVolume& labels, Label cartilage, const mesh::Volume& ct)
{
    constexpr double kNoneHU = 150.0, kAllHU = 250.0; // 50 HU above cartilage, beyond noise, and 50 HU below marrow
    const mesh::LabelFlags bone
        = mesh::flagged_labels(labels.table, [](const mesh::LabelInfo& info) { return info.material == "bone"; });
    std::vector<Index> all = voxels_of(labels, cartilage);
    if (all.empty())
        return std::nullopt;
    const std::vector<Index> steps = steps_within(labels.grid.spacing, 1.5 * labels.grid.spacing.maxCoeff());
    const LabelVoxels voxels(labels, std::move(all));
    double calcified = 0.0;
    std::size_t count = 0;
    for (const Index& v : voxels.voxels()) {
        const bool beside_bone = std::any_of(steps.begin(), steps.end(), [&](const Index& step) {
            const Index next = moved(v, step);
            return voxels.contains(next) && bone[voxels.label(next)] != 0;
        });
        if (beside_bone)
            continue;
        calcified += std::clamp((ct_at(labels, ct, v) - kNoneHU) / (kAllHU - kNoneHU), 0.0, 1.0);
        ++count;
    }
    return count > 0 ? std::optional(calcified / static_cast<double>(count)) : std::nullopt;
}

double cartilage_modulus_MPa(double calcified_share)
{
    check_share(calcified_share);
    return kCartilageSubstanceMPa * kPerichondrium
        * std::min(kMostStiffening, 1.0 + kStiffeningPerShare * calcified_share);
}

std::vector<BoneStiffness> find_bone_stiffness(const mesh::LabelVolume& labels, const mesh::Volume* ct,
    const fem::MaterialTable& materials, std::string_view without_ct)
{
    const auto is_cartilage
        = [](const mesh::LabelInfo& info) { return info.material == "cartilage" && info.role == mesh::Role::wall; };
    const mesh::LabelFlags ribs = mesh::flagged_labels(labels.table, is_rib_label);
    const mesh::LabelFlags cartilages = mesh::flagged_labels(labels.table, is_cartilage);
    std::map<Label, std::vector<Index>> voxels;
    mesh::visit_voxels(labels, [&](int i, int j, int k, Label label) {
        if (ribs[label] != 0 || cartilages[label] != 0)
            voxels[label].push_back({ i, j, k });
    });
    std::vector<BoneStiffness> bones;
    for (const mesh::LabelInfo& info : labels.table) {
        const auto of_label = voxels.find(info.id);
        if (of_label == voxels.end())
            continue;
        BoneStiffness bone { .label = info.id, .name = info.name, .material = info.material, .words = {} };
        const fem::Material& material = fem::find_material(materials, info.material);
        if (is_own(material)) {
            bone.origin = StiffnessOrigin::own;
            bone.modulus_MPa = bone.low_MPa = bone.high_MPa = material.youngs_modulus_MPa;
            bone.words = "the case's own value: " + material.source;
        } else if (ct == nullptr) {
            take_middle(bone, std::string(without_ct));
        } else if (ribs[info.id] != 0) {
            find_rib(bone, labels, std::move(of_label->second), *ct);
        } else {
            find_cartilage(bone, labels, *ct);
        }
        bones.push_back(std::move(bone));
    }
    return bones;
}

void apply_bone_stiffness(std::span<const BoneStiffness> bones, std::vector<fem::Material>& material_of_label)
{
    for (const BoneStiffness& bone : bones) {
        if (bone.label >= material_of_label.size() || bone.origin == StiffnessOrigin::own)
            continue;
        material_of_label[bone.label].youngs_modulus_MPa = bone.modulus_MPa;
        material_of_label[bone.label].source = bone.words;
    }
}

} // namespace retractor::planner
