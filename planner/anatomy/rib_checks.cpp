#include "planner/anatomy/rib_checks.h"

#include "mesh/base/text_format.h"
#include "planner/anatomy/rib_name.h"

#include <algorithm>
#include <array>
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

    /// Ways inside one label, voxel by voxel.
    class Walk {
    public:
        explicit Walk(const mesh::LabelVolume& labels)
            : labels_(labels)
            , way_(labels.voxels.size(), kUnseen)
        {
            for (int k = -1; k <= 1; ++k)
                for (int j = -1; j <= 1; ++j)
                    for (int i = -1; i <= 1; ++i)
                        if (i != 0 || j != 0 || k != 0)
                            steps_.push_back({ { i, j, k }, Vec3(i, j, k).cwiseProduct(labels.grid.spacing).norm() });
        }
        bool seen(std::size_t voxel) const { return way_[voxel] != kUnseen; }

        struct Reached {
            std::vector<std::array<int, 3>> voxels;
            std::array<int, 3> farthest {};
            double farthest_mm = 0.0;
        };
        /// All voxels of the label that hang together with the first, by Dijkstra's algorithm.
        /// @param again the piece was walked before
        Reached from(const std::array<int, 3>& first, const std::vector<std::array<int, 3>>& again = {})
        {
            const mesh::ImageGrid& grid = labels_.grid;
            for (const auto& [i, j, k] : again)
                way_[grid.offset(i, j, k)] = kUnseen;
            const Label label = labels_.voxels[grid.offset(first[0], first[1], first[2])];
            using Entry = std::pair<float, std::array<int, 3>>;
            std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
            way_[grid.offset(first[0], first[1], first[2])] = 0.0F;
            open.push({ 0.0F, first });
            Reached reached;
            while (!open.empty()) {
                const auto [way, at] = open.top();
                open.pop();
                if (way > way_[grid.offset(at[0], at[1], at[2])])
                    continue;
                reached.voxels.push_back(at);
                reached.farthest = at;
                reached.farthest_mm = way;
                for (const auto& [step, length] : steps_) {
                    const std::array next { at[0] + step[0], at[1] + step[1], at[2] + step[2] };
                    if (!grid.contains(next[0], next[1], next[2]))
                        continue;
                    const std::size_t voxel = grid.offset(next[0], next[1], next[2]);
                    const float there = way + static_cast<float>(length);
                    if (labels_.voxels[voxel] != label || (way_[voxel] != kUnseen && way_[voxel] <= there))
                        continue;
                    way_[voxel] = there;
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
        const mesh::LabelVolume& labels_;
        std::vector<float> way_;
        std::vector<Step> steps_;
    };

    BonePiece measured(Walk& walk, const mesh::LabelVolume& labels, const std::array<int, 3>& first)
    {
        const mesh::ImageGrid& grid = labels.grid;
        const Walk::Reached whole = walk.from(first);
        const Walk::Reached along = walk.from(whole.farthest, whole.voxels);
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
        constexpr int kFirstLong = 2, kLastLong = 10; // ribs 1, 11 and 12 are short by nature
        const double length = length_of(ribs, rib);
        if (length == 0.0)
            return {};
        const RibName other { !rib.left, rib.number };
        if (const double mirrored = length_of(ribs, other); length < kShorterThanOtherSide * mirrored)
            return rib_in_words(rib) + " is " + in_words(length) + " mm long, and " + rib_in_words(other) + " "
                + in_words(mirrored) + " mm";
        const double above = length_of(ribs, { rib.left, rib.number - 1 }),
                     below = length_of(ribs, { rib.left, rib.number + 1 });
        if (rib.number <= kFirstLong || rib.number >= kLastLong || above == 0.0 || below == 0.0
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
    Walk walk(labels);
    std::vector<BonePiece> pieces;
    std::size_t voxel = 0;
    for (int k = 0; k < labels.grid.size[2]; ++k) {
        if (job.cancelled())
            return {};
        for (int j = 0; j < labels.grid.size[1]; ++j)
            for (int i = 0; i < labels.grid.size[0]; ++i, ++voxel)
                if (flags[labels.voxels[voxel]] != 0 && !walk.seen(voxel))
                    pieces.push_back(measured(walk, labels, { i, j, k }));
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
                doubts.push_back(rib_in_words(name) + " is in pieces: " + in_words(pieces[n].volume_ml, 1) + " ml lie "
                    + in_words(gap_between(pieces.front(), pieces[n])) + " mm from the other "
                    + in_words(pieces.front().volume_ml, 1) + " ml");
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
