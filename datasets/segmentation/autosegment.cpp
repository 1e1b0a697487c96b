#include "datasets/segmentation/autosegment.h"

#include "datasets/io/volume_io.h"
#include "datasets/segmentation/body.h"
#include "datasets/segmentation/bones/bones.h"
#include "datasets/segmentation/cavity.h"
#include "datasets/segmentation/given_labels.h"
#include "datasets/segmentation/vessels.h"
#include "datasets/segmentation/wall_layers.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace retractor::datasets {

using namespace segmentation;

namespace {

    struct Known {
        const char* name;
        const char* material;
        mesh::Role role;
    };
    constexpr std::array<Known, 4> kLayers { { { "skin", "skin", mesh::Role::wall }, { "fat", "fat", mesh::Role::wall },
        { "muscle", "muscle", mesh::Role::wall }, { "intercostal", "intercostal", mesh::Role::wall } } };
    constexpr std::array<Known, 7> kOrgans { { { "lung_left", "lung", mesh::Role::voxel },
        { "lung_right", "lung", mesh::Role::voxel }, { "trachea", "cartilage", mesh::Role::voxel },
        { "heart", "heart", mesh::Role::at_risk }, { "aorta", "vessel", mesh::Role::at_risk },
        { "mediastinum", "fat", mesh::Role::voxel }, { "upper_abdomen", "liver", mesh::Role::voxel } } };
    constexpr const char* kGiven = "given";
    constexpr const char* kBody = "body"; // a given label of this name marks the body, not an organ

    void check(const mesh::Volume& ct, const AutosegmentOptions& options)
    {
        mesh::check_grid(ct.grid);
        if (ct.voxels.size() != ct.grid.voxel_count())
            throw InputError("the CT's grid and its voxels do not agree in number", "ct");
        if (!(options.spacing_mm >= 0.5 && options.spacing_mm <= 4.0)) {
            std::ostringstream message;
            message << "spacing_mm must be between 0.5 and 4, got " << options.spacing_mm;
            throw InputError(message.str(), "spacing_mm");
        }
        constexpr double kMostVoxels = 120e6; // about 3 GB of working memory
        if (segmentation::working_voxels(ct.grid, options.spacing_mm) > kMostVoxels)
            throw InputError("the labels would have more than 120 million voxels (counted in the box along the world's "
                             "axes round the CT): use a larger spacing",
                "spacing_mm");
    }

    /// Finds the labels, step by step.
    class Segmenter {
    public:
        Segmenter(const mesh::Volume& ct, const AutosegmentOptions& options, const Job& job)
            : job_(job)
            , image_(segmentation::working_image(ct, options.spacing_mm, job.threads))
            , extent_(image_.extent())
        {
            if (options.given)
                given_ = segmentation::with_parts_joined(resample_labels_to(*options.given, image_.grid));
            out_.labels.grid = image_.grid;
            out_.labels.voxels.assign(image_.grid.voxel_count(), 0);
            name_labels();
        }

        Segmentation run();

    private:
        void name_labels();
        Label add_label(const std::string& name, const std::string& material, mesh::Role role);
        Label id_of(std::string_view name) const { return mesh::find_label(out_.labels.table, name)->id; }

        bool is_given(std::string_view name) const;
        segmentation::Mask given_mask(std::string_view name) const;
        void keep_given(std::string_view name, segmentation::Mask& mask) const;
        void paint(const segmentation::Mask& mask, std::string_view name);
        void paint_given();
        void drop_unused_labels();
        void note(const std::string& name, bool rough, const std::string& how);
        void warn(const std::vector<std::string>& lines)
        {
            out_.warnings.insert(out_.warnings.end(), lines.begin(), lines.end());
        }

        void find_body();
        void take_off_electrodes();
        void find_lungs();
        void find_bones();
        void find_cavity();
        void find_organs();
        void find_wall();
        void take_bone_by_threshold();
        segmentation::Mask named_bones(const std::function<bool(const std::string&)>& wanted) const;
        void give_airless_lung_back();
        void keep_wall_closed();

        const Job& job_;
        segmentation::WorkingImage image_;
        segmentation::Extent extent_;
        std::optional<mesh::LabelVolume> given_;
        segmentation::Mask body_;
        segmentation::Lungs lungs_;
        segmentation::Bones bones_;
        segmentation::Mask all_bones_;
        segmentation::Mask ribs_;
        segmentation::Cavity cavity_;
        std::vector<float> depth_; ///< depth under the body's surface, mm
        Segmentation out_;
    };

    Label Segmenter::add_label(const std::string& name, const std::string& material, mesh::Role role)
    {
        mesh::LabelTable& table = out_.labels.table;
        if (const mesh::LabelInfo* there = mesh::find_label(table, name))
            return there->id;
        const auto id = static_cast<Label>(table.size() + 1);
        table.push_back({ id, name, material, role });
        return id;
    }

    void Segmenter::name_labels()
    {
        for (const Known& known : kLayers)
            add_label(known.name, known.material, known.role);
        for (const Known& known : kOrgans)
            add_label(known.name, known.material, known.role);
        if (given_)
            for (const mesh::LabelInfo& info : given_->table)
                if (info.name != kBody)
                    add_label(info.name, info.material, info.role);
    }

    bool Segmenter::is_given(std::string_view name) const
    {
        if (!given_)
            return false;
        const mesh::LabelInfo* info = mesh::find_label(given_->table, name);
        return info != nullptr
            && std::find(given_->voxels.begin(), given_->voxels.end(), info->id) != given_->voxels.end();
    }

    segmentation::Mask Segmenter::given_mask(std::string_view name) const
    {
        segmentation::Mask mask(image_.hu.size(), 0);
        if (!given_)
            return mask;
        if (const mesh::LabelInfo* info = mesh::find_label(given_->table, name))
            for (std::size_t v = 0; v < mask.size(); ++v)
                mask[v] = given_->voxels[v] == info->id ? 1 : 0;
        return mask;
    }

    /// Replaces a mask by the given label of this name.
    void Segmenter::keep_given(std::string_view name, segmentation::Mask& mask) const
    {
        if (is_given(name))
            mask = given_mask(name);
    }

    void Segmenter::paint(const segmentation::Mask& mask, std::string_view name)
    {
        const Label id = id_of(name);
        for (std::size_t v = 0; v < mask.size(); ++v)
            if (mask[v] != 0)
                out_.labels.voxels[v] = id;
    }

    void Segmenter::paint_given()
    {
        if (!given_)
            return;
        for (const mesh::LabelInfo& info : given_->table)
            if (info.name != kBody && is_given(info.name))
                paint(given_mask(info.name), info.name);
    }

    void Segmenter::note(const std::string& name, bool rough, const std::string& how)
    {
        out_.structures.push_back({ name, 0.0, rough && !is_given(name), is_given(name) ? kGiven : how });
    }

    void Segmenter::drop_unused_labels()
    {
        std::vector<std::size_t> count(out_.labels.table.size() + 1, 0);
        for (const Label label : out_.labels.voxels)
            ++count[label];
        std::vector<Label> renumbered(count.size(), 0);
        mesh::LabelTable table;
        for (mesh::LabelInfo info : out_.labels.table)
            if (count[info.id] > 0) {
                renumbered[info.id] = static_cast<Label>(table.size() + 1);
                for (FoundStructure& found : out_.structures)
                    if (found.name == info.name)
                        found.volume_ml = static_cast<double>(count[info.id]) * image_.grid.voxel_volume() / 1000.0;
                info.id = renumbered[info.id];
                table.push_back(std::move(info));
            }
        for (Label& label : out_.labels.voxels)
            label = renumbered[label];
        out_.labels.table = std::move(table);
        std::erase_if(out_.structures, [](const FoundStructure& found) { return found.volume_ml == 0.0; });
    }

    void Segmenter::find_body()
    {
        if (is_given(kBody)) {
            body_ = given_mask(kBody);
        } else {
            segmentation::Body body = segmentation::segment_body(image_, job_.threads);
            body_ = std::move(body.mask);
            warn(body.warnings);
        }
        if (given_)
            for (std::size_t v = 0; v < body_.size(); ++v)
                if (given_->voxels[v] != 0)
                    body_[v] = 1;
        segmentation::Mask outside(body_.size());
        std::transform(body_.begin(), body_.end(), outside.begin(), [](std::uint8_t b) { return b == 0 ? 1 : 0; });
        depth_ = segmentation::distance_to(extent_, outside);
        take_off_electrodes();
    }

    /// Turns metal on the skin into soft tissue, because metal looks like bone. Pieces of metal are as bright as bone,
    /// begin at the surface of the body and end just below.
    void Segmenter::take_off_electrodes()
    {
        constexpr int kBright = 150;
        const float surface = std::max(3.0F, 1.01F * static_cast<float>(extent_.spacing[0])); // mm
        constexpr float kDeepest = 12.0F;
        constexpr std::int16_t kSkinHu = 40;
        const segmentation::Pieces pieces = segmentation::connected_pieces(
            extent_, segmentation::common(segmentation::threshold(image_.hu, kBright, 32767), body_));
        std::vector<float> least(pieces.voxels.size() + 1, kDeepest);
        std::vector<float> most(pieces.voxels.size() + 1, 0.0F);
        for (std::size_t v = 0; v < depth_.size(); ++v) {
            const auto piece = static_cast<std::size_t>(pieces.piece_of[v]);
            least[piece] = std::min(least[piece], depth_[v]);
            most[piece] = std::max(most[piece], depth_[v]);
        }
        double taken = 0.0;
        for (std::size_t v = 0; v < depth_.size(); ++v) {
            const auto piece = static_cast<std::size_t>(pieces.piece_of[v]);
            if (piece == 0 || least[piece] > surface || most[piece] > kDeepest)
                continue;
            image_.hu[v] = kSkinHu;
            taken += image_.grid.voxel_volume() / 1000.0;
        }
        constexpr double kNoticedMl = 0.5;
        if (taken > kNoticedMl) {
            std::ostringstream line;
            line << std::fixed << std::setprecision(1) << taken
                 << " ml of metal on the skin (electrodes, leads) were counted as soft tissue";
            out_.warnings.push_back(line.str());
        }
    }

    void Segmenter::find_lungs()
    {
        if (is_given("lung_left") && is_given("lung_right") && is_given("trachea")) {
            lungs_ = { given_mask("lung_left"), given_mask("lung_right"), given_mask("trachea"), std::nullopt, {} };
        } else {
            lungs_ = segmentation::segment_lungs(image_, body_);
            warn(lungs_.warnings);
        }
        keep_given("lung_left", lungs_.left);
        keep_given("lung_right", lungs_.right);
        keep_given("trachea", lungs_.trachea);
        lungs_.right = segmentation::without(lungs_.right, lungs_.left);
        lungs_.left = segmentation::without(lungs_.left, lungs_.trachea);
        lungs_.right = segmentation::without(lungs_.right, lungs_.trachea);
        note("lung_left", false, "air below -400 HU inside the body, vessels filled, gas of the bowel left out");
        note("lung_right", false, "as the left one, parted from it where they touch");
        note("trachea", false, "the tube of air followed from the neck to the main bronchi");
    }

    void Segmenter::find_bones()
    {
        const segmentation::Mask lungs = segmentation::united(lungs_.both(), lungs_.trachea);
        bones_ = segmentation::segment_bones({ image_, body_, lungs, given_ ? &*given_ : nullptr }, job_);
        warn(bones_.warnings);
        out_.structures.insert(out_.structures.end(), bones_.structures.begin(), bones_.structures.end());
        std::vector<Label> renumbered(static_cast<std::size_t>(65536), 0);
        for (const mesh::LabelInfo& info : bones_.table)
            renumbered[info.id] = add_label(info.name, info.material, info.role);
        for (std::size_t v = 0; v < body_.size(); ++v)
            if (bones_.labels[v] != 0 && body_[v] != 0 && lungs[v] == 0)
                out_.labels.voxels[v] = renumbered[bones_.labels[v]];
        if (mesh::find_label(bones_.table, "spine") == nullptr)
            take_bone_by_threshold();
        all_bones_ = named_bones([](const std::string&) { return true; });
        ribs_ = named_bones(
            [](const std::string& name) { return name.starts_with("rib") || name == "costal_cartilages"; });
    }

    /// Finds bone by a threshold. Bones that could not be separated still bound the cavity.
    void Segmenter::take_bone_by_threshold()
    {
        constexpr int kBoneHu = 180;
        constexpr const char* kName = "bone_other";
        const segmentation::Mask bright = segmentation::majority(
            extent_, segmentation::common(segmentation::threshold(image_.hu, kBoneHu, 32767), body_), 1, job_.threads);
        const Label id = add_label(kName, "bone", mesh::Role::wall);
        if (mesh::find_label(bones_.table, kName) == nullptr)
            bones_.table.push_back({ id, kName, "bone", mesh::Role::wall });
        for (std::size_t v = 0; v < bright.size(); ++v)
            if (bright[v] != 0 && body_[v] != 0 && out_.labels.voxels[v] == 0)
                out_.labels.voxels[v] = id;
        std::erase_if(out_.structures, [&](const FoundStructure& found) { return found.name == kName; });
        note(kName, true, "everything above 180 HU: bones could not be told apart");
        out_.warnings.emplace_back(
            "no spine was found: bone is a threshold only, not told apart, and the wall is rough");
    }

    /// The voxels of all bones with a wanted name.
    segmentation::Mask Segmenter::named_bones(const std::function<bool(const std::string&)>& wanted) const
    {
        std::vector<std::uint8_t> take(out_.labels.table.size() + 1, 0);
        for (const mesh::LabelInfo& info : bones_.table)
            if (wanted(info.name))
                take[id_of(info.name)] = 1;
        segmentation::Mask mask(out_.labels.voxels.size());
        std::transform(out_.labels.voxels.begin(), out_.labels.voxels.end(), mask.begin(),
            [&](Label label) { return take[label]; });
        return mask;
    }

    void Segmenter::find_cavity()
    {
        const segmentation::Mask spine = named_bones([](const std::string& name) { return name == "spine"; });
        const segmentation::Mask sternum = named_bones([](const std::string& name) { return name == "sternum"; });
        segmentation::Mask cage = segmentation::united(segmentation::united(ribs_, spine), sternum);
        if (segmentation::count_set(spine) == 0) {
            constexpr float kDeepestRib = 55.0F; // mm; a deeper bright voxel may be a vessel or a kidney
            cage = all_bones_;
            for (std::size_t v = 0; v < cage.size(); ++v)
                if (depth_[v] > kDeepestRib)
                    cage[v] = 0;
        }
        cavity_
            = segmentation::segment_cavity({ image_, body_, lungs_, cage, spine, sternum, all_bones_ }, job_.threads);
        warn(cavity_.warnings);
        keep_wall_closed();
        give_airless_lung_back();
    }

    /// Turns lung and cavity near the skin into wall, so that neither opens to the skin.
    void Segmenter::keep_wall_closed()
    {
        constexpr float kLeastWall = 5.0F;
        constexpr double kMuchMl = 2.0;
        double moved = 0.0;
        for (std::size_t v = 0; v < body_.size(); ++v)
            if ((cavity_.thorax[v] != 0 || cavity_.abdomen[v] != 0) && depth_[v] <= kLeastWall) {
                moved += image_.grid.voxel_volume() / 1000.0;
                cavity_.thorax[v] = cavity_.abdomen[v] = lungs_.left[v] = lungs_.right[v] = 0;
            }
        if (moved > kMuchMl)
            out_.warnings.push_back("the lung comes within 5 mm of the skin (" + std::to_string(std::lround(moved))
                + " ml): a wall of 5 mm was kept there; look for a wound or for air under the skin");
    }

    /// Returns lung without air (consolidation, collapse, fluid) from the mediastinum to the lung. Two regions are
    /// returned: narrow pockets between the lungs and the wall, away from the midline, and voxels far to the right,
    /// where no heart reaches.
    void Segmenter::give_airless_lung_back()
    {
        constexpr int kCells = 2;
        constexpr double kPocket = 9.0; // half the width of a pocket, mm
        constexpr double kFromMidline = 50.0;
        constexpr double kFarRight = 65.0;
        constexpr double kMuchMl = 30.0;
        const segmentation::Extent cells = segmentation::coarse_extent(extent_, kCells);
        const segmentation::Mask lungs = lungs_.both();
        segmentation::Mask around(lungs.size()); // lungs and wall, without the abdomen
        double middle = 0.0;
        double count = 0.0;
        const auto nx = static_cast<std::size_t>(extent_.size[0]);
        for (std::size_t v = 0; v < lungs.size(); ++v) {
            around[v] = lungs[v] != 0 || (cavity_.thorax[v] == 0 && cavity_.abdomen[v] == 0) ? 1 : 0;
            if (all_bones_[v] != 0) {
                middle += static_cast<double>(v % nx);
                count += 1.0;
            }
        }
        middle = count > 0.0 ? middle / count : 0.5 * extent_.size[0];
        const segmentation::Mask pockets = segmentation::fine_values(extent_,
            segmentation::closed(cells, segmentation::coarse_mask(extent_, around, kCells, 0.5), kPocket), kCells);
        double filled = 0.0;
        for (std::size_t v = 0; v < lungs.size(); ++v) {
            if (cavity_.thorax[v] == 0 || lungs[v] != 0 || lungs_.trachea[v] != 0)
                continue;
            const double x = (static_cast<double>(v % nx) - middle) * extent_.spacing[0];
            if ((pockets[v] != 0 && std::abs(x) > kFromMidline) || x < -kFarRight) {
                (x > 0.0 ? lungs_.left : lungs_.right)[v] = 1;
                filled += image_.grid.voxel_volume() / 1000.0;
            }
        }
        if (filled > kMuchMl)
            out_.warnings.push_back(std::to_string(std::lround(filled))
                + " ml without air (consolidation, collapse or fluid) were counted to the lungs");
    }

    void Segmenter::find_organs()
    {
        const segmentation::Mask lungs = lungs_.both();
        segmentation::Mask mediastinum
            = segmentation::without(segmentation::without(cavity_.thorax, lungs), lungs_.trachea);
        const segmentation::Mask spine = named_bones([](const std::string& name) { return name == "spine"; });
        const segmentation::Mask sternum = named_bones([](const std::string& name) { return name == "sternum"; });
        const segmentation::Vessels vessels = segmentation::find_vessels(
            { image_, mediastinum, cavity_.abdomen, lungs_, spine, sternum, all_bones_ }, job_.threads);
        if (!is_given("heart") || !is_given("aorta"))
            warn(vessels.warnings);
        paint(cavity_.abdomen, "upper_abdomen");
        paint(mediastinum, "mediastinum");
        if (!is_given("heart"))
            paint(vessels.heart, "heart");
        if (!is_given("aorta"))
            paint(vessels.aorta, "aorta");
        paint(segmentation::common(lungs_.left, body_), "lung_left");
        paint(segmentation::common(lungs_.right, body_), "lung_right");
        paint(lungs_.trachea, "trachea");
        note("heart", true, vessels.heart_how);
        note("aorta", !vessels.contrast, vessels.aorta_how);
        note("mediastinum", true, "what the cavity holds between the lungs and is nothing else");
        note("upper_abdomen", true,
            "inside the wall, below the lungs' lower faces; the diaphragm is stretched under the heart");
    }

    void Segmenter::find_wall()
    {
        segmentation::Mask wall(body_.size());
        for (std::size_t v = 0; v < wall.size(); ++v)
            wall[v] = body_[v] != 0 && out_.labels.voxels[v] == 0 ? 1 : 0;
        const std::vector<segmentation::Layer> layers = segmentation::wall_layers(
            { image_, wall, depth_, ribs_, cavity_.shell, segmentation::united(lungs_.both(), lungs_.trachea) },
            job_.threads);
        std::array<Label, 5> id {};
        for (std::size_t n = 0; n < kLayers.size(); ++n)
            // A given layer is complete. Voxels that would be added to this layer become muscle.
            id[n + 1] = id_of(is_given(kLayers[n].name) ? "muscle" : kLayers[n].name);
        for (std::size_t v = 0; v < wall.size(); ++v)
            if (wall[v] != 0)
                out_.labels.voxels[v] = id[static_cast<std::size_t>(layers[v])];
        note("skin", true, "the outer 3 mm of the body (two voxels at the usual spacing), not seen as a layer");
        note("fat", false, "below -30 HU, specks smoothed away");
        note("muscle", false, "soft tissue of the wall that is nothing else, arms included");
        note("intercostal", true, "muscle within 10 mm of the cavity, between ribs");
    }

    Segmentation Segmenter::run()
    {
        const Stopwatch watch;
        const std::array<void (Segmenter::*)(), 6> steps { &Segmenter::find_body, &Segmenter::find_lungs,
            &Segmenter::find_bones, &Segmenter::find_cavity, &Segmenter::find_organs, &Segmenter::find_wall };
        for (std::size_t step = 0; step < steps.size(); ++step) {
            job_.report("segmentation", static_cast<double>(step) / steps.size());
            if (job_.cancelled())
                return {};
            (this->*steps[step])();
        }
        paint_given();
        drop_unused_labels();
        job_.report("segmentation", 1.0);
        record_part(job_, "segmentation", watch,
            image_.hu.size() * (sizeof(std::int16_t) + sizeof(float) + 8 * sizeof(std::uint8_t)));
        record_part(job_, "labels", watch, out_.labels.voxels.size() * sizeof(Label));
        return std::move(out_);
    }

} // namespace

Segmentation autosegment(const mesh::Volume& ct, const AutosegmentOptions& options, const Job& job)
{
    check(ct, options);
    segmentation::set_filter_threads(std::max(1, job.threads));
    const segmentation::EmptyEnds ends = segmentation::empty_ends(ct);
    if (ends.before + ends.after == 0)
        return Segmenter(ct, options, job).run();
    Segmentation found = Segmenter(segmentation::without(ct, ends), options, job).run();
    found.warnings.insert(found.warnings.begin(),
        "the image has " + std::to_string(ends.before + ends.after)
            + " empty slices at its ends: they were left out, and the body is taken to go on there");
    return found;
}

} // namespace retractor::datasets
