#include "planner/anatomy/rib_checks.h"

#include "mesh/base/text_format.h"
#include "planner/anatomy/rib_name.h"

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <cstddef>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <queue>
#include <utility>

namespace retractor::planner {

namespace {

    // Ours. Ribs of the two sides differ by a few per cent; a rib that lost an end differs by more.
    constexpr double kShorterThanOtherSide = 0.75, kShorterThanNeighbours = 0.65;
    constexpr double kLeastPieceMl = 0.4; ///< smaller pieces are noise
    constexpr double kThickestRibMm = 20.0, kRibSlenderness = 3.0, kLeastRibMm = 25.0;
    constexpr double kBelongsMm = 25.0; ///< farthest gap between a rib and its lost part
    /// Other bone that is worth a sentence: calcified cartilage is smaller than a lost part of a rib, and a stump of a
    /// clavicle smaller than a rib without a number.
    constexpr double kLeastLostMl = 2.5, kLeastUnnumberedMl = 6.0;

    /// A part of a grid: first and last voxel along each axis.
    struct VoxelBox {
        std::array<int, 3> first { INT_MAX, INT_MAX, INT_MAX }, last { -1, -1, -1 };

        void take(int i, int j, int k)
        {
            const std::array at { i, j, k };
            for (std::size_t axis = 0; axis < 3; ++axis) {
                first[axis] = std::min(first[axis], at[axis]);
                last[axis] = std::max(last[axis], at[axis]);
            }
        }
        std::size_t offset(const std::array<int, 3>& at) const
        {
            std::size_t offset = 0;
            for (std::size_t axis = 3; axis-- > 0;)
                offset = offset * static_cast<std::size_t>(last[axis] - first[axis] + 1)
                    + static_cast<std::size_t>(at[axis] - first[axis]);
            return offset;
        }
    };

    /// Ways inside one label, voxel by voxel.
    class Walk {
    public:
        /// @param box that holds all voxels of the label
        Walk(const mesh::LabelVolume& labels, Label label, const VoxelBox& box)
            : labels_(labels)
            , label_(label)
            , box_(box)
            , way_(box.offset(box.last) + 1, kUnseen)
        {
            for (int k = -1; k <= 1; ++k)
                for (int j = -1; j <= 1; ++j)
                    for (int i = -1; i <= 1; ++i)
                        if (i != 0 || j != 0 || k != 0)
                            steps_.push_back({ { i, j, k }, Vec3(i, j, k).cwiseProduct(labels.grid.spacing).norm() });
        }
        bool is_new(const std::array<int, 3>& voxel) const
        {
            return has_label(voxel) && way_[box_.offset(voxel)] == kUnseen;
        }

        struct Reached {
            std::vector<std::array<int, 3>> voxels;
            std::array<int, 3> farthest {};
            double farthest_mm = 0.0;
        };
        /// All voxels of the label that hang together with the first, by Dijkstra's algorithm. A cancelled job ends
        /// early.
        /// @param again the piece was walked before
        Reached from(const std::array<int, 3>& first, const Job& job, const std::vector<std::array<int, 3>>& again = {})
        {
            for (const std::array<int, 3>& voxel : again)
                way_[box_.offset(voxel)] = kUnseen;
            using Entry = std::pair<float, std::array<int, 3>>;
            std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
            way_[box_.offset(first)] = 0.0F;
            open.push({ 0.0F, first });
            Reached reached;
            while (!open.empty()) {
                const auto [way, at] = open.top();
                open.pop();
                if (way > way_[box_.offset(at)])
                    continue;
                if (reached.voxels.size() % 65536 == 0 && job.cancelled())
                    break;
                reached.voxels.push_back(at);
                reached.farthest = at;
                reached.farthest_mm = way;
                for (const auto& [step, length] : steps_) {
                    const std::array next { at[0] + step[0], at[1] + step[1], at[2] + step[2] };
                    if (!has_label(next))
                        continue;
                    float& known = way_[box_.offset(next)];
                    const float there = way + static_cast<float>(length);
                    if (known != kUnseen && known <= there)
                        continue;
                    known = there;
                    open.push({ there, next });
                }
            }
            return reached;
        }

    private:
        static constexpr float kUnseen = -1.0F;
        struct Step {
            std::array<int, 3> by;
            double length = 0.0;
        };
        bool has_label(const std::array<int, 3>& voxel) const
        {
            const mesh::ImageGrid& grid = labels_.grid;
            return grid.contains(voxel[0], voxel[1], voxel[2])
                && labels_.voxels[grid.offset(voxel[0], voxel[1], voxel[2])] == label_;
        }

        const mesh::LabelVolume& labels_;
        Label label_ = 0;
        VoxelBox box_;
        std::vector<float> way_;
        std::vector<Step> steps_;
    };

    BonePiece measured(Walk& walk, const mesh::LabelVolume& labels, const std::array<int, 3>& first, const Job& job)
    {
        const mesh::ImageGrid& grid = labels.grid;
        const Walk::Reached whole = walk.from(first, job);
        const Walk::Reached along = walk.from(whole.farthest, job, whole.voxels);
        BonePiece piece { .label = labels.voxels[grid.offset(first[0], first[1], first[2])] };
        piece.volume_ml = 1e-3 * static_cast<double>(whole.voxels.size()) * grid.voxel_volume();
        piece.length_mm = along.farthest_mm;
        const auto place = [&](const std::array<int, 3>& v) { return grid.world(Vec3(v[0], v[1], v[2])); };
        piece.first_end = place(whole.farthest);
        piece.second_end = place(along.farthest);
        piece.at_image_end = std::any_of(whole.voxels.begin(), whole.voxels.end(), [&](const auto& v) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                if (v[axis] == 0 || v[axis] + 1 == grid.size[axis])
                    return true;
            return false;
        });
        return piece;
    }

    double gap_between(const BonePiece& a, const BonePiece& b)
    {
        return std::min({ (a.first_end - b.first_end).norm(), (a.first_end - b.second_end).norm(),
            (a.second_end - b.first_end).norm(), (a.second_end - b.second_end).norm() });
    }

    bool has_rib_shape(const BonePiece& piece)
    {
        return piece.volume_ml >= kLeastPieceMl && piece.length_mm >= kLeastRibMm
            && piece.thickness_mm() <= kThickestRibMm && piece.length_mm >= kRibSlenderness * piece.thickness_mm();
    }

    using Ribs = std::map<RibName, std::vector<BonePiece>>; ///< pieces of each rib, the largest first

    double length_of(const Ribs& ribs, const RibName& rib)
    {
        const auto found = ribs.find(rib);
        return found == ribs.end() || found->second.front().at_image_end ? 0.0 : found->second.front().length_mm;
    }

    /// What the rib's length is short of; empty: nothing.
    std::string short_of(const Ribs& ribs, const RibName& rib)
    {
        constexpr int kShortFromAbove = 2, kShortFromBelow = 10; // ribs 1, 2 and 10 to 12 are shorter than the next
        const double length = length_of(ribs, rib);
        if (length == 0.0)
            return {};
        const RibName other { !rib.left, rib.number };
        if (const double mirrored = length_of(ribs, other); length < kShorterThanOtherSide * mirrored)
            return rib_in_words(rib) + " is " + in_words(length) + " mm long, and " + rib_in_words(other) + " "
                + in_words(mirrored) + " mm";
        const double above = length_of(ribs, { rib.left, rib.number - 1 }),
                     below = length_of(ribs, { rib.left, rib.number + 1 });
        if (rib.number <= kShortFromAbove || rib.number >= kShortFromBelow || above == 0.0 || below == 0.0
            || length >= kShorterThanNeighbours * std::min(above, below))
            return {};
        return rib_in_words(rib) + " is " + in_words(length) + " mm long, and its neighbours " + in_words(above)
            + " and " + in_words(below) + " mm";
    }

    /// The rib whose end lies nearest to a piece, and the distance.
    std::pair<std::optional<RibName>, double> nearest_rib(const Ribs& ribs, const BonePiece& piece)
    {
        std::pair<std::optional<RibName>, double> nearest { std::nullopt, kBelongsMm };
        for (const auto& [name, pieces] : ribs)
            if (const double gap = gap_between(pieces.front(), piece); gap < nearest.second)
                nearest = { name, gap };
        return nearest;
    }

} // namespace

double BonePiece::thickness_mm() const
{
    return length_mm > 0.0 ? 2.0 * std::sqrt(1e3 * volume_ml / length_mm / std::numbers::pi) : 0.0;
}

std::vector<BonePiece> bone_pieces(const mesh::LabelVolume& labels, const mesh::LabelFlags& flags, const Job& job)
{
    std::map<Label, VoxelBox> boxes;
    mesh::visit_voxels(labels, [&](int i, int j, int k, Label label) {
        if (flags[label] != 0)
            boxes[label].take(i, j, k);
    });
    std::vector<BonePiece> pieces;
    for (const auto& [label, box] : boxes) {
        Walk walk(labels, label, box);
        for (int k = box.first[2]; k <= box.last[2]; ++k)
            for (int j = box.first[1]; j <= box.last[1]; ++j)
                for (int i = box.first[0]; i <= box.last[0]; ++i) {
                    if (job.cancelled())
                        return {};
                    if (walk.is_new({ i, j, k }))
                        pieces.push_back(measured(walk, labels, { i, j, k }, job));
                }
    }
    std::stable_sort(pieces.begin(), pieces.end(), [](const BonePiece& a, const BonePiece& b) {
        return a.label != b.label ? a.label < b.label : a.volume_ml > b.volume_ml;
    });
    return pieces;
}

std::vector<std::string> rib_doubts(const mesh::LabelVolume& labels, const Job& job)
{
    const auto is_other = [](const mesh::LabelInfo& info) { return info.name == "bone_other"; };
    const mesh::LabelFlags flags = mesh::flagged_labels(
        labels.table, [&](const mesh::LabelInfo& info) { return rib_name(info.name) || is_other(info); });
    Ribs ribs;
    std::vector<BonePiece> others;
    for (const BonePiece& piece : bone_pieces(labels, flags, job)) {
        const std::optional<RibName> name = rib_name(mesh::find_label(labels.table, piece.label)->name);
        if (name)
            ribs[*name].push_back(piece);
        else if (has_rib_shape(piece))
            others.push_back(piece);
    }
    std::vector<std::string> doubts;
    for (const auto& [name, pieces] : ribs) {
        for (std::size_t n = 1; n < pieces.size(); ++n)
            if (pieces[n].volume_ml >= kLeastPieceMl)
                doubts.push_back(rib_in_words(name) + " is in pieces: " + in_words(pieces[n].volume_ml, 1)
                    + " ml lie apart from the other " + in_words(pieces.front().volume_ml, 1) + " ml");
        if (const std::string words = short_of(ribs, name); !words.empty())
            doubts.push_back(words + ": it may be cut in two");
    }
    for (const BonePiece& piece : others) {
        const auto [rib, gap] = nearest_rib(ribs, piece);
        if (piece.volume_ml < (rib ? kLeastLostMl : kLeastUnnumberedMl) || (!rib && piece.at_image_end))
            continue;
        doubts.push_back(in_words(piece.volume_ml, 1) + " ml of other bone have the shape of a rib, "
            + (rib ? in_words(gap) + " mm from the end of " + rib_in_words(*rib) + " and may belong to it"
                   : "and no rib ends near: a rib may have no number"));
    }
    return doubts;
}

} // namespace retractor::planner
