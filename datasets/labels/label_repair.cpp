// Finds connected pieces over runs of voxels. Every row of the image is divided into runs of one label, and touching
// runs are united (union-find). Time is linear in the voxels, memory in the runs. Pieces of a label connect over faces,
// edges and corners. Pieces of the background connect over faces only, as the complement requires.

#include "datasets/labels/label_repair.h"

#include "datasets/io/label_table.h"
#include "mesh/base/disjoint_sets.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <set>

namespace retractor::datasets {

namespace {

    using RunIndex = std::uint32_t;

    struct Run {
        std::int32_t from = 0; ///< first voxel in the row
        std::int32_t to = 0; ///< voxel after the last in the row
        Label label = 0;
    };

    /// Values of surroundings() besides labels.
    constexpr std::uint32_t kNothing = 0;
    constexpr std::uint32_t kManyOrBorder = std::numeric_limits<std::uint32_t>::max();

    class Pieces {
    public:
        explicit Pieces(const mesh::LabelVolume& labels)
            : size_(labels.grid.size)
        {
            cut_into_runs(labels.voxels);
            // The first run of a piece is its root, so that the choice among equal pieces is the same on every machine.
            DisjointSets<RunIndex> sets(runs_.size());
            for (int k = 0; k < size_[2]; ++k)
                for (int j = 0; j < size_[1]; ++j) {
                    unite_rows(sets, j, k, j - 1, k);
                    for (int dj = -1; dj <= 1; ++dj)
                        unite_rows(sets, j, k, j + dj, k - 1);
                }
            voxels_.assign(runs_.size(), 0);
            root_ = sets.roots();
            for (RunIndex run = 0; run < runs_.size(); ++run)
                voxels_[root_[run]] += length(run);
        }

        std::size_t run_count() const { return runs_.size(); }
        const Run& run(RunIndex run) const { return runs_[run]; }
        std::size_t length(RunIndex run) const { return static_cast<std::size_t>(runs_[run].to - runs_[run].from); }
        std::size_t piece_voxels(RunIndex run) const { return voxels_[root_[run]]; }
        bool is_root(RunIndex run) const { return root_[run] == run; }
        RunIndex piece(RunIndex run) const { return root_[run]; }

        /// Calls visit(run, offset of the run's first voxel) for every run.
        template <typename Visit> void for_runs(const Visit& visit) const
        {
            for (std::size_t row = 0; row + 1 < row_start_.size(); ++row)
                for (RunIndex run = row_start_[row]; run < row_start_[row + 1]; ++run)
                    visit(run, row * static_cast<std::size_t>(size_[0]) + static_cast<std::size_t>(runs_[run].from));
        }

        /// Per root of a background piece: the label of all its neighbours over faces, kNothing without neighbours, or
        /// kManyOrBorder.
        std::vector<std::uint32_t> surroundings() const
        {
            std::vector<std::uint32_t> around(runs_.size(), kNothing);
            const auto met = [&](RunIndex background, std::uint32_t label) {
                std::uint32_t& seen = around[root_[background]];
                if (seen != label)
                    seen = seen == kNothing ? label : kManyOrBorder;
            };
            for (int k = 0; k < size_[2]; ++k)
                for (int j = 0; j < size_[1]; ++j) {
                    const bool border = j == 0 || k == 0 || j + 1 == size_[1] || k + 1 == size_[2];
                    const auto [first, last] = row(j, k);
                    for (RunIndex run = first; run < last; ++run) {
                        if (runs_[run].label != 0)
                            continue;
                        met(run, border || run == first || run + 1 == last ? kManyOrBorder : runs_[run - 1].label);
                        if (run + 1 < last)
                            met(run, runs_[run + 1].label);
                    }
                    const auto both = [&](RunIndex a, RunIndex b) {
                        if (runs_[a].label == 0 && runs_[b].label != 0)
                            met(a, runs_[b].label);
                        if (runs_[b].label == 0 && runs_[a].label != 0)
                            met(b, runs_[a].label);
                    };
                    if (j > 0)
                        for_touching(row(j, k), row(j - 1, k), 0, both);
                    if (k > 0)
                        for_touching(row(j, k), row(j, k - 1), 0, both);
                }
            return around;
        }

    private:
        using Row = std::pair<RunIndex, RunIndex>;

        Row row(int j, int k) const
        {
            const std::size_t at
                = static_cast<std::size_t>(k) * static_cast<std::size_t>(size_[1]) + static_cast<std::size_t>(j);
            return { row_start_[at], row_start_[at + 1] };
        }

        void cut_into_runs(const std::vector<Label>& voxels)
        {
            const auto nx = static_cast<std::size_t>(size_[0]);
            row_start_.reserve(voxels.size() / nx + 1);
            for (std::size_t first = 0; first < voxels.size(); first += nx) {
                row_start_.push_back(static_cast<RunIndex>(runs_.size()));
                for (std::size_t i = 0; i < nx;) {
                    const Label label = voxels[first + i];
                    std::size_t end = i + 1;
                    while (end < nx && voxels[first + end] == label)
                        ++end;
                    runs_.push_back({ static_cast<std::int32_t>(i), static_cast<std::int32_t>(end), label });
                    i = end;
                }
            }
            row_start_.push_back(static_cast<RunIndex>(runs_.size()));
        }

        /// Calls visit(a, b) for runs of two rows whose voxels are at most `reach` apart along the row.
        template <typename Visit> void for_touching(Row a, Row b, int reach, const Visit& visit) const
        {
            RunIndex other = b.first;
            for (RunIndex run = a.first; run < a.second; ++run) {
                while (other < b.second && runs_[other].to + reach <= runs_[run].from)
                    ++other;
                for (RunIndex near = other; near < b.second && runs_[near].from < runs_[run].to + reach; ++near)
                    visit(run, near);
            }
        }

        void unite_rows(DisjointSets<RunIndex>& sets, int j, int k, int other_j, int other_k)
        {
            if (other_j < 0 || other_k < 0 || other_j >= size_[1])
                return;
            const bool over_face = (j == other_j) != (k == other_k);
            for_touching(row(j, k), row(other_j, other_k), 1, [&](RunIndex a, RunIndex b) {
                const bool overlap = runs_[a].from < runs_[b].to && runs_[b].from < runs_[a].to;
                if (runs_[a].label == runs_[b].label && (runs_[a].label != 0 || (over_face && overlap)))
                    sets.join(a, b);
            });
        }

        std::array<int, 3> size_;
        std::vector<Run> runs_;
        std::vector<RunIndex> row_start_;
        std::vector<RunIndex> root_;
        std::vector<std::size_t> voxels_; ///< voxels per root
    };

    /// True for structures that have several pieces by nature.
    bool comes_in_pieces(const mesh::LabelInfo& info)
    {
        static const std::set<std::string_view> kTissues { "skin", "fat", "muscle", "intercostal" };
        static const std::set<std::string_view> kNames { "spine", "skeleton", "bone", "bone_other", "costal_cartilages",
            "intervertebral_discs", "vertebrae_body", "lungs", "lung_vessels", "pulmonary_vein", "pulmonary_vessels",
            "coronary_arteries", "scapula", "clavicle", "humerus", "hip", "femur", "kidney", "adrenal_gland",
            "heart_atrium", "heart_ventricle", "atrial_appendage", "bronchus_main", "body_extremities",
            "pleural_effusion" };
        static constexpr std::array<std::string_view, 7> kMany { "arteries", "veins", "vessels", "nodules", "lesions",
            "metastases", "targets" };
        return (kTissues.contains(info.material) && info.role == mesh::Role::wall) || kNames.contains(info.name)
            || info.name.starts_with("ribs") || std::any_of(kMany.begin(), kMany.end(), [&](std::string_view word) {
                   return info.name.find(word) != std::string::npos;
               });
    }

    /// False for skin, because skin is a shell and the enclosed body is no hole.
    bool may_have_holes(const mesh::LabelInfo& info) { return info.material != "skin"; }

    struct LabelPieces {
        std::size_t voxels = 0;
        std::size_t pieces = 0;
        RunIndex largest = 0; ///< root of the largest piece
        std::size_t largest_voxels = 0;
    };

    std::map<Label, LabelPieces> pieces_per_label(const Pieces& pieces)
    {
        std::map<Label, LabelPieces> found;
        for (RunIndex run = 0; run < pieces.run_count(); ++run) {
            const Label label = pieces.run(run).label;
            if (label == 0 || !pieces.is_root(run))
                continue;
            LabelPieces& here = found[label];
            const std::size_t voxels = pieces.piece_voxels(run);
            here.voxels += voxels;
            ++here.pieces;
            if (voxels > here.largest_voxels) {
                here.largest_voxels = voxels;
                here.largest = run;
            }
        }
        return found;
    }

    /// Calls visit(run, label, offset) for each background run that only `label` encloses.
    template <typename Visit> void for_holes(const Pieces& pieces, const mesh::LabelTable& table, const Visit& visit)
    {
        std::vector<bool> holes_of(std::size_t { std::numeric_limits<Label>::max() } + 1, false);
        for (const mesh::LabelInfo& info : table)
            holes_of[info.id] = may_have_holes(info);
        const std::vector<std::uint32_t> around = pieces.surroundings();
        pieces.for_runs([&](RunIndex run, std::size_t offset) {
            if (pieces.run(run).label != 0)
                return;
            const std::uint32_t by = around[pieces.piece(run)];
            if (by != kNothing && by != kManyOrBorder && holes_of[by])
                visit(run, static_cast<Label>(by), offset);
        });
    }

    void check_input(const mesh::LabelVolume& labels)
    {
        mesh::check_grid(labels.grid);
        if (labels.voxels.size() != labels.grid.voxel_count())
            throw InputError("the labels have " + std::to_string(labels.voxels.size()) + " voxels, their grid "
                + std::to_string(labels.grid.voxel_count()));
        if (labels.voxels.size() > std::numeric_limits<RunIndex>::max())
            throw InputError("the label image is too large");
        check_labels_named(labels, "labels");
    }

    std::vector<LabelFragments> in_order_of(
        const mesh::LabelTable& table, const std::map<Label, LabelFragments>& by_label)
    {
        std::vector<LabelFragments> list;
        for (const mesh::LabelInfo& info : table) {
            const auto found = by_label.find(info.id);
            if (found == by_label.end()
                || (found->second.pieces < 2 && found->second.stray_voxels == 0 && found->second.hole_voxels == 0))
                continue;
            list.push_back(found->second);
            list.back().name = info.name;
        }
        return list;
    }

    std::map<Label, LabelFragments> measure(const Pieces& pieces)
    {
        std::map<Label, LabelFragments> by_label;
        for (const auto& [label, found] : pieces_per_label(pieces))
            by_label[label] = { .name = {},
                .voxels = found.voxels,
                .pieces = found.pieces,
                .stray_voxels = found.voxels - found.largest_voxels,
                .hole_voxels = 0 };
        return by_label;
    }

    /// Sets the voxels of pieces that are not kept to 0. Returns the number of these voxels per label.
    std::map<Label, std::size_t> remove_strays(mesh::LabelVolume& labels, const Pieces& pieces, double keep_fraction)
    {
        const std::map<Label, LabelPieces> found = pieces_per_label(pieces);
        std::vector<bool> many(std::size_t { std::numeric_limits<Label>::max() } + 1, false);
        for (const mesh::LabelInfo& info : labels.table)
            many[info.id] = comes_in_pieces(info);
        std::map<Label, std::size_t> removed;
        pieces.for_runs([&](RunIndex run, std::size_t offset) {
            const Label label = pieces.run(run).label;
            if (label == 0)
                return;
            const LabelPieces& all = found.at(label);
            const RunIndex piece = pieces.piece(run);
            if (piece == all.largest
                || (many[label]
                    && static_cast<double>(pieces.piece_voxels(piece))
                        >= keep_fraction * static_cast<double>(all.largest_voxels)))
                return;
            std::fill_n(labels.voxels.begin() + static_cast<std::ptrdiff_t>(offset), pieces.length(run), Label { 0 });
            removed[label] += pieces.length(run);
        });
        return removed;
    }

} // namespace

std::vector<LabelFragments> find_fragments(const mesh::LabelVolume& labels, const Job& job)
{
    check_input(labels);
    job.report("look for fragments", 0.0);
    const Pieces pieces(labels);
    if (job.cancelled())
        return {};
    job.report("look for fragments", 0.5);
    std::map<Label, LabelFragments> by_label = measure(pieces);
    for_holes(pieces, labels.table,
        [&](RunIndex run, Label label, std::size_t) { by_label[label].hole_voxels += pieces.length(run); });
    job.report("look for fragments", 1.0);
    return in_order_of(labels.table, by_label);
}

std::vector<LabelFragments> repair_labels(mesh::LabelVolume& labels, double keep_fraction, const Job& job)
{
    check_input(labels);
    if (!(keep_fraction >= 0.0 && keep_fraction <= 1.0))
        throw InputError("the fraction must be between 0 and 1, got " + std::to_string(keep_fraction), "keep_fraction");
    job.report("repair labels", 0.0);
    std::map<Label, LabelFragments> by_label;
    {
        const Pieces pieces(labels);
        if (job.cancelled())
            return {};
        by_label = measure(pieces);
        for (auto& [label, fragments] : by_label)
            fragments.stray_voxels = 0;
        for (const auto& [label, voxels] : remove_strays(labels, pieces, keep_fraction))
            by_label[label].stray_voxels = voxels;
    }
    job.report("repair labels", 0.5);
    // Removed strays may leave holes in other labels, so the pieces are computed again.
    const Pieces pieces(labels);
    for_holes(pieces, labels.table, [&](RunIndex run, Label label, std::size_t offset) {
        by_label[label].hole_voxels += pieces.length(run);
        std::fill_n(labels.voxels.begin() + static_cast<std::ptrdiff_t>(offset), pieces.length(run), label);
    });
    job.report("repair labels", 1.0);
    std::vector<LabelFragments> changed = in_order_of(labels.table, by_label);
    std::erase_if(
        changed, [](const LabelFragments& label) { return label.stray_voxels == 0 && label.hole_voxels == 0; });
    return changed;
}

} // namespace retractor::datasets
