#include "datasets/segmentation/bones/bones.h"

#include "datasets/segmentation/bones/bones_steps.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace retractor::datasets::segmentation {

namespace {

    constexpr int kMostRibs = 12;

    /// The ids of all possible labels. Labels without voxels are dropped at the end.
    struct Names {
        mesh::LabelTable table;
        std::array<std::array<Label, kMostRibs>, 2> rib {};
        Label cartilage = 0, sternum = 0, spine = 0;
        GirdleIds girdle;

        Label add(const std::string& name, const char* material = "bone")
        {
            const auto id = static_cast<Label>(table.size() + 1);
            table.push_back({ id, name, material, mesh::Role::wall });
            return id;
        }
    };

    Names make_names()
    {
        const std::array<std::string, 2> sides { "left", "right" };
        Names names;
        for (std::size_t side = 0; side < 2; ++side)
            for (std::size_t rib = 0; rib < kMostRibs; ++rib)
                names.rib[side][rib] = names.add("rib_" + sides[side] + "_" + std::to_string(rib + 1));
        names.cartilage = names.add("costal_cartilages", "cartilage");
        names.sternum = names.add("sternum");
        names.spine = names.add("spine");
        for (std::size_t side = 0; side < 2; ++side)
            names.girdle.scapula[side] = names.add("scapula_" + sides[side]);
        for (std::size_t side = 0; side < 2; ++side)
            names.girdle.clavicle[side] = names.add("clavicle_" + sides[side]);
        names.girdle.other = names.add("bone_other");
        return names;
    }

    /// Runs the steps and holds their shared data.
    class BoneFinder {
    public:
        BoneFinder(const BonesInput& input, const Job& job)
            : input_(input)
            , job_(job)
            , grid_(input.image.grid)
            , names_(make_names())
        {
        }

        Bones find();

    private:
        bool find_landmarks();
        void seed_midline();
        void seed_clavicles();
        bool beside_clavicle(const Vec3& p) const;
        void seed_ribs();
        void seed_outside();
        void grow();
        void shape();
        void take_given();
        void warn_of_missing_ribs(const std::vector<std::size_t>& count);
        void explain_cartilages(FoundStructure& found);
        Bones collect();
        bool stop(double done) const
        {
            job_.report("bones", done);
            return job_.cancelled();
        }
        std::size_t rib_of(Label label) const; ///< index in ribs_, or npos
        bool rib_may_enter(const RibTrack& rib, const Vec3& p) const;
        Vec3 position(Voxel v) const
        {
            const auto nx = static_cast<Voxel>(grid_.size[0]), ny = static_cast<Voxel>(grid_.size[1]);
            return grid_.world(Vec3(
                static_cast<double>(v % nx), static_cast<double>((v / nx) % ny), static_cast<double>(v / (nx * ny))));
        }

        const BonesInput& input_;
        const Job& job_;
        const mesh::ImageGrid& grid_;
        Names names_;
        CoarseImage coarse_;
        Cage cage_;
        std::vector<std::int16_t> smooth_;
        Mask bone_;
        std::vector<RibTrack> ribs_;
        std::vector<CartilagePath> cartilages_;
        std::array<std::vector<Vec3>, 2> clavicles_;
        std::vector<const RibTrack*> rib_of_label_;
        std::vector<Label> labels_;
        std::vector<Label> given_; ///< labels from the caller
        std::vector<std::string> warnings_;
    };

    bool BoneFinder::find_landmarks()
    {
        coarse_ = coarsened(input_);
        const auto given_path = [this](const char* name) {
            const mesh::LabelInfo* info
                = input_.given != nullptr ? mesh::find_label(input_.given->table, name) : nullptr;
            return info != nullptr ? path_of_label(coarse_, *input_.given, info->id) : MidlinePath {};
        };
        MidlinePath spine = given_path("spine");
        if (!spine.found())
            spine = find_spine(coarse_);
        if (!spine.found()) {
            warnings_.push_back("spine not found: no bone was separated");
            return false;
        }
        MidlinePath sternum = given_path("sternum");
        if (!sternum.found())
            sternum = find_sternum(coarse_, spine);
        if (!sternum.found()) {
            warnings_.push_back("sternum not found: no bone was separated");
            return false;
        }
        cage_ = make_cage(coarse_, spine, sternum);
        return true;
    }

    void BoneFinder::seed_midline()
    {
        labels_.assign(bone_.size(), 0);
        Voxel v = 0;
        for (int k = 0; k < grid_.size[2]; ++k)
            for (int j = 0; j < grid_.size[1]; ++j)
                for (int i = 0; i < grid_.size[0]; ++i, ++v) {
                    if (!bone_[v])
                        continue;
                    const Vec3 p = grid_.world(Vec3(i, j, k));
                    if (in_spine_core(cage_, p))
                        labels_[v] = names_.spine;
                    else if (in_sternum_core(cage_, p))
                        labels_[v] = names_.sternum;
                }
    }

    void BoneFinder::seed_ribs()
    {
        rib_of_label_.assign(names_.table.size() + 1, nullptr);
        // Near the spine a rib and the transverse process are one piece in the image, so seeds of ribs begin farther
        // out and grow towards the spine.
        constexpr double kFree = 42.0; // mm from the middle of the spine
        for (const RibTrack& rib : ribs_) {
            if (rib.number == 0)
                continue;
            const Label id = names_.rib[rib.left ? 0 : 1][static_cast<std::size_t>(rib.number - 1)];
            rib_of_label_[id] = &rib;
            for (const Voxel u : rib.voxels) {
                const Vec3 p = position(u);
                if (labels_[u] == 0 && std::abs(p.x() - cage_.spine(p.z()).x()) > kFree && !in_sternum_reach(cage_, p))
                    labels_[u] = id;
            }
        }
    }

    /// Seeds the bone outside the ribs: shoulder blades and arms.
    void BoneFinder::seed_outside()
    {
        constexpr double kBeyond = 4.0; // mm
        constexpr double kBesideNotch = 60.0, kBehindNotch = 30.0,
                         kUnderNotch = 30.0; // mm; clavicles and manubrium meet in this region
        const double top = cage_.sternum.top();
        const Eigen::Vector2d notch = cage_.sternum(top);
        for (Voxel v = 0; v < bone_.size(); ++v) {
            if (!bone_[v] || labels_[v] != 0)
                continue;
            const Vec3 p = position(v);
            const bool at_notch = std::abs(p.x() - notch.x()) < kBesideNotch && p.y() < notch.y() + kBehindNotch
                && p.z() > top - kUnderNotch;
            if (!at_notch && cage_.outside_at(p) > cage_.rib_limit(p.z()) + kBeyond && !in_spine_reach(cage_, p)
                && !in_sternum_reach(cage_, p) && !beside_clavicle(p))
                labels_[v] = names_.girdle.other;
        }
    }

    void BoneFinder::seed_clavicles()
    {
        Mask not_rib = bone_;
        for (const RibTrack& rib : ribs_)
            for (const Voxel v : rib.voxels)
                not_rib[v] = 0;
        for (std::size_t side = 0; side < 2; ++side) {
            clavicles_[side] = seed_clavicle(
                grid_, bone_, cage_, side == 0, names_.girdle.other, names_.girdle.clavicle[side], not_rib, labels_);
            if (clavicles_[side].empty())
                warnings_.push_back(side == 0 ? "clavicle_left not found" : "clavicle_right not found");
        }
    }

    /// True near the line of a clavicle. The seeds of a clavicle are thinner than the clavicle.
    bool BoneFinder::beside_clavicle(const Vec3& p) const
    {
        constexpr double kReach = 14.0; // mm
        return std::any_of(clavicles_.begin(), clavicles_.end(), [&](const std::vector<Vec3>& line) {
            return std::any_of(line.begin(), line.end(), [&](const Vec3& q) {
                return std::abs(p.x() - q.x()) <= kReach && (p - q).squaredNorm() <= kReach * kReach;
            });
        });
    }

    bool BoneFinder::rib_may_enter(const RibTrack& rib, const Vec3& p) const
    {
        constexpr double kPastEndDeg = 1.0, kOffLine = 19.0, kOutside = 2.5, kInside = -28.0;
        const Eigen::Vector2d spine = cage_.spine(p.z());
        if (std::abs(p.x() - spine.x()) < cage_.half_width(p.z()) + 1.0 && p.y() > spine.y() - 30.0)
            return false;
        const double angle = cage_.angle(p);
        if (angle > rib.angle.back() + 0.5 * 4.0 + kPastEndDeg || (p.x() > cage_.centre(p.z()).x()) != rib.left)
            return false;
        const double out = cage_.outside_at(p);
        if (out > cage_.rib_limit(p.z()) + kOutside || out < kInside)
            return false;
        // A voxel may be rib only near the rib's line at this angle.
        const auto above = std::upper_bound(rib.angle.begin(), rib.angle.end(), angle);
        const auto n = static_cast<std::size_t>(std::distance(rib.angle.begin(), above));
        const Vec3& near = rib.line[std::min(n, rib.line.size() - 1)];
        const Vec3& other = rib.line[n == 0 ? 0 : n - 1];
        const Vec3 along = other - near;
        const double t
            = along.squaredNorm() > 0.0 ? std::clamp((p - near).dot(along) / along.squaredNorm(), 0.0, 1.0) : 0.0;
        return (p - near - t * along).norm() < kOffLine || (n == 0 && (p - near).norm() < 2.0 * kOffLine);
    }

    void BoneFinder::grow()
    {
        grow_seeds(input_.image, bone_, smooth_, labels_, [this](Label label, Voxel v) {
            const Vec3 p = position(v);
            if (label == names_.spine)
                return in_spine_reach(cage_, p);
            if (label == names_.sternum)
                return in_sternum_reach(cage_, p);
            if (label == names_.girdle.clavicle[0] || label == names_.girdle.clavicle[1])
                return p.z() > cage_.sternum.top() - 25.0 && !in_spine_reach(cage_, p);
            if (label == names_.girdle.other)
                return cage_.outside_at(p) > cage_.rib_limit(p.z()) - 1.0 && !in_spine_reach(cage_, p);
            return rib_may_enter(*rib_of_label_[label], p);
        });
    }

    void BoneFinder::shape()
    {
        for (const Label id : { names_.sternum, names_.spine })
            make_solid(grid_, labels_, id);
        cartilages_ = add_cartilages(
            input_.image, coarse_, cage_, bone_, smooth_, ribs_, names_.sternum, names_.cartilage, labels_);
        label_girdle(input_.image, bone_, cage_, names_.girdle, names_.cartilage, labels_);
        std::vector<Label> rib_ids;
        for (std::size_t id = 1; id < rib_of_label_.size(); ++id)
            if (rib_of_label_[id] != nullptr)
                rib_ids.push_back(static_cast<Label>(id));
        const GirdleIds& girdle = names_.girdle;
        const std::vector<Label> girdle_ids { girdle.scapula[0], girdle.scapula[1], girdle.clavicle[0],
            girdle.clavicle[1], girdle.other };
        const auto is_rib = [this](Label l) { return rib_of_label_[l] != nullptr; };
        const auto from_frame
            = [&](Label a, Label b) { return b == names_.spine || b == names_.sternum || (is_rib(b) && a > b); };
        part_bones(grid_, labels_, rib_ids, true, from_frame);
        for (const Label id : rib_ids)
            make_solid(grid_, labels_, id, rib_of_label_[id]->line, girdle_ids);
        part_bones(grid_, labels_, rib_ids, true, from_frame);
        part_bones(grid_, labels_, girdle_ids, false, [&](Label, Label b) { return is_rib(b); });
        keep_largest_pieces(grid_, labels_, { girdle_ids.begin(), girdle_ids.end() - 1 }, girdle.other);
        std::vector<Label> frame = rib_ids;
        frame.push_back(names_.sternum);
        frame.push_back(names_.spine);
        keep_largest_pieces(grid_, labels_, frame, 0);
    }

    void BoneFinder::explain_cartilages(FoundStructure& found)
    {
        constexpr double kSeen = 0.5; // share of the path
        std::string hidden, unseen;
        int n = 0;
        const auto list
            = [](std::string& names, const std::string& name) { names += (names.empty() ? "" : ", ") + name; };
        for (const CartilagePath& path : cartilages_) {
            const std::string name = std::string(path.left ? "left " : "right ") + std::to_string(path.number);
            if (path.line.empty())
                list(unseen, name);
            else if (path.seen < kSeen)
                list(hidden, name);
            n += !path.line.empty();
        }
        if (!unseen.empty())
            warnings_.push_back("costal cartilages not found (the rib's front end is not in view or has no way to the "
                                "sternum): "
                + unseen);
        found.rough = !hidden.empty();
        found.how = std::to_string(n) + " followed from the ribs' ends in the rib cage";
        if (found.rough) {
            found.how += "; hardly visible, drawn as rods: " + hidden;
            warnings_.push_back("costal cartilages hardly visible, drawn as rods: " + hidden);
        }
    }

    /// Gives given labels precedence over bones found under the same name, and over every other bone.
    void BoneFinder::take_given()
    {
        if (input_.given == nullptr)
            return;
        const mesh::LabelVolume& given = *input_.given;
        std::vector<Label> id_of(std::size_t { 1 } << 16, 0);
        for (const mesh::LabelInfo& info : names_.table)
            if (const mesh::LabelInfo* known = mesh::find_label(given.table, info.name)) {
                id_of[known->id] = info.id;
                given_.push_back(info.id);
            }
        std::vector<bool> replaced(names_.table.size() + 1, false);
        for (const Label id : given_)
            replaced[id] = true;
        for (Voxel v = 0; v < labels_.size(); ++v) {
            if (replaced[labels_[v]])
                labels_[v] = 0;
            if (id_of[given.voxels[v]] != 0)
                labels_[v] = id_of[given.voxels[v]];
        }
    }

    /// Warns of missing ribs. Between the first and the last rib found on either side, both sides should have every
    /// rib.
    void BoneFinder::warn_of_missing_ribs(const std::vector<std::size_t>& count)
    {
        std::size_t first = kMostRibs, last = 0;
        for (const auto& side : names_.rib)
            for (std::size_t n = 0; n < side.size(); ++n)
                if (count[side[n]] > 0) {
                    first = std::min(first, n);
                    last = std::max(last, n);
                }
        if (first == kMostRibs) {
            if (!rib_of_label_.empty()) // another warning says when no bone was separated
                warnings_.push_back("no rib was found");
            return;
        }
        constexpr std::size_t kMany = 4; // one or two missing ribs leave the levels clear, more may hide a whole level
        std::size_t missing = 0;
        for (std::size_t n = first; n <= last; ++n)
            for (std::size_t side = 0; side < 2; ++side)
                if (const Label id = names_.rib[side][n]; count[id] == 0) {
                    warnings_.push_back(names_.table[id - 1U].name + " not found");
                    ++missing;
                }
        if (missing >= kMany)
            warnings_.push_back("many ribs were not found (a coarse image?): the numbers of the others may be wrong");
        if (first > 0)
            warnings_.push_back("ribs above rib " + std::to_string(first + 1) + " not found");
        if (last + 1 < kMostRibs)
            warnings_.push_back("ribs below rib " + std::to_string(last + 1) + " not found");
    }

    Bones BoneFinder::collect()
    {
        take_given();
        std::vector<std::size_t> count(names_.table.size() + 1, 0);
        for (const Label l : labels_)
            ++count[l];
        Bones bones;
        for (const mesh::LabelInfo& info : names_.table) {
            const std::size_t n = count[info.id];
            if (n == 0)
                continue;
            bones.table.push_back(info);
            FoundStructure found;
            found.name = info.name;
            found.volume_ml = static_cast<double>(n) * grid_.voxel_volume() / 1000.0;
            const RibTrack* rib = rib_of_label_.empty() ? nullptr : rib_of_label_[info.id];
            found.how = rib != nullptr ? "bone above 150 HU followed round the rib cage from the spine, marrow filled"
                : info.id == names_.spine        ? "bone above 150 HU along the vertebral bodies, with discs and canal"
                : info.id == names_.sternum      ? "bone above 150 HU along the middle of the front"
                : info.id == names_.girdle.other ? "bone above 150 HU that is none of the others"
                                                 : "bone above 150 HU outside the rib cage, by its place";
            if (rib != nullptr && rib->bridged_mm > 5.0
                && std::find(given_.begin(), given_.end(), info.id) == given_.end()) {
                std::ostringstream text;
                text << info.name << " bridged over " << std::lround(rib->bridged_mm) << " mm";
                warnings_.push_back(text.str());
            }
            const bool is_given = std::find(given_.begin(), given_.end(), info.id) != given_.end();
            if (is_given)
                found.how = "given";
            else if (info.id == names_.cartilage)
                explain_cartilages(found);
            bones.structures.push_back(std::move(found));
        }
        warn_of_missing_ribs(count);
        bones.labels = std::move(labels_);
        bones.warnings = std::move(warnings_);
        return bones;
    }

    Bones BoneFinder::find()
    {
        if (input_.given != nullptr && input_.given->voxels.size() != grid_.voxel_count())
            throw InputError("the given labels are not on the grid of the image");
        if (stop(0.0) || !find_landmarks()) {
            labels_.assign(grid_.voxel_count(), 0);
            return collect();
        }
        smooth_ = smoothed(input_.image.extent(), input_.image.hu, 0.8);
        if (stop(0.3))
            return {};
        bone_ = bone_mask(input_, cage_, smooth_);
        if (stop(0.5))
            return {};
        ribs_ = track_ribs(input_.image, bone_, cage_);
        number_ribs(ribs_, cage_, grid_, warnings_);
        seed_midline();
        seed_clavicles();
        seed_ribs();
        seed_outside();
        if (stop(0.7))
            return {};
        grow();
        shape();
        job_.report("bones", 1.0);
        return collect();
    }

} // namespace

Bones segment_bones(const BonesInput& input, const Job& job) { return BoneFinder(input, job).find(); }

} // namespace retractor::datasets::segmentation
