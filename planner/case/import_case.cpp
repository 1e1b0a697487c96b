#include "planner/case/import_case.h"

#include "datasets/io/volume_io.h"
#include "datasets/labels/label_import.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/anatomy/assumed_vessels.h"
#include "planner/anatomy/rib_checks.h"
#include "planner/case/case_io.h"
#include "planner/case/plausible_input.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <system_error>

#include <signal.h>
#include <unistd.h>

namespace retractor::planner {

namespace {

    namespace fs = std::filesystem;

    void check_request(const ImportRequest& request)
    {
        if (request.labels.empty() && !request.autosegment)
            throw InputError("a case needs labels: give a label map, or have the labels found in the CT", "labels",
                { "labels", "autosegment" });
        if (request.ct.empty() && request.autosegment)
            throw InputError("there is no CT to segment", "automatic segmentation", { "autosegment" });
        if (request.labels.empty() && !request.preset.empty())
            throw InputError(
                "a preset names the labels of a label map: give a label map as well", "preset", { "preset", "labels" });
        if (request.labels.empty() && request.repair_labels)
            throw InputError("there are no labels to repair: give a label map as well", "repair of labels",
                { "repair_labels", "labels" });
        if (request.ct.empty() && (!request.series.empty() || request.with_identity))
            throw InputError("there is no CT", "input");
        if (request.ct.empty() && request.labels.size() > 1)
            throw InputError(
                "several label maps are joined on the CT's grid, and there is no CT", "labels", { "labels" });
    }

    /// The first twelve names, and the number of the others.
    std::string first_names(std::vector<std::string> names)
    {
        constexpr std::size_t kMost = 12;
        const std::size_t others = names.size() - std::min(names.size(), kMost);
        names.resize(names.size() - others);
        return joined(names) + (others > 0 ? " and " + std::to_string(others) + " more" : "");
    }

    /// @param what "CT" or "labels"
    void check_extent(
        const mesh::ImageGrid& grid, const std::string& what, const ImportRequest& request, ImportedCase& imported)
    {
        const std::optional<std::string> implausible = implausible_extent(grid);
        if (!implausible)
            return;
        if (!request.accept_implausible)
            throw InputError(*implausible
                    + "; if the image is right, import it as one that is accepted although "
                      "implausible",
                what, { "accept_implausible" });
        imported.warnings.push_back(what + ": " + *implausible);
    }

    // ---- the CT ----------------------------------------------------------------------------------------------------

    void read_ct(const ImportRequest& request, ImportedCase& imported, const Job& job)
    {
        if (request.ct.empty())
            return;
        if (fs::is_directory(request.ct))
            imported.series = datasets::list_dicom_series(request.ct);
        if (request.with_identity)
            imported.patient = datasets::read_dicom_identity(request.ct);
        datasets::ImportedVolume read = datasets::import_volume(
            request.ct, { .series = request.series, .rectify_tilt = request.rectify_tilt }, job);
        if (job.cancelled())
            return;
        imported.notes.insert(imported.notes.end(), read.notes.begin(), read.notes.end());
        check_extent(read.volume.grid, "CT", request, imported);
        imported.ct = std::make_shared<const mesh::Volume>(std::move(read.volume));
    }

    // ---- labels ----------------------------------------------------------------------------------------------------

    std::vector<std::size_t> voxel_counts(const mesh::LabelVolume& labels)
    {
        std::vector<std::size_t> counts(mesh::kLabelCount, 0);
        for (const Label label : labels.voxels)
            ++counts[label];
        return counts;
    }

    /// Whether the grid holds the index. The comparison is made in double: a far index does not fit into an int.
    bool holds_index(const mesh::ImageGrid& grid, const Vec3& index)
    {
        return index.minCoeff() >= 0.0 && index.x() < grid.size[0] && index.y() < grid.size[1]
            && index.z() < grid.size[2];
    }

    /// Checks that a labelled voxel lies inside the CT. Otherwise one of the two images is of another patient or frame.
    void check_overlap(const mesh::Volume& ct, const mesh::LabelVolume& labels, const fs::path& where)
    {
        std::size_t at = 0;
        for (int k = 0; k < labels.grid.size[2]; ++k)
            for (int j = 0; j < labels.grid.size[1]; ++j)
                for (int i = 0; i < labels.grid.size[0]; ++i, ++at) {
                    if (labels.voxels[at] == 0)
                        continue;
                    const Vec3 index = ct.grid.index(labels.grid.world(Vec3(i, j, k)));
                    if (holds_index(ct.grid, index.array().round()))
                        return;
                }
        throw InputError(
            "no labelled voxel lies inside the CT: are both of the same patient and frame?", where.string());
    }

    Label free_id(const mesh::LabelTable& table)
    {
        for (Label id = 1; id < std::numeric_limits<Label>::max(); ++id)
            if (mesh::find_label(table, id) == nullptr)
                return id;
        throw InputError("there are more labels than ids", "labels", { "labels" });
    }

    /// Writes `later` over `labels`, on the grid of `labels`. Labels with the same name become one label.
    /// @returns the number of voxels that had another label before
    std::size_t write_over(mesh::LabelVolume& labels, const mesh::LabelVolume& later)
    {
        const mesh::LabelVolume moved = datasets::resample_labels_to(later, labels.grid);
        RETRACTOR_ASSERT(moved.voxels.size() == labels.voxels.size());
        std::vector<Label> id_of(mesh::kLabelCount, 0);
        for (const mesh::LabelInfo& info : later.table) {
            if (const mesh::LabelInfo* same = mesh::find_label(labels.table, info.name)) {
                id_of[info.id] = same->id;
                continue;
            }
            mesh::LabelInfo added = info;
            if (mesh::find_label(labels.table, info.id) != nullptr)
                added.id = free_id(labels.table);
            id_of[info.id] = added.id;
            labels.table.push_back(added);
        }
        std::size_t changed = 0;
        for (std::size_t v = 0; v < labels.voxels.size(); ++v) {
            if (moved.voxels[v] == 0)
                continue;
            const Label id = id_of[moved.voxels[v]];
            changed += labels.voxels[v] != 0 && labels.voxels[v] != id ? 1 : 0;
            labels.voxels[v] = id;
        }
        return changed;
    }

    std::optional<mesh::LabelVolume> read_labels(const ImportRequest& request, ImportedCase& imported, const Job& job)
    {
        std::optional<mesh::LabelVolume> labels;
        for (const fs::path& path : request.labels) {
            datasets::ImportedLabels read = datasets::import_labels(path, { .preset = request.preset }, job);
            if (job.cancelled())
                return std::nullopt;
            imported.notes.insert(imported.notes.end(), read.notes.begin(), read.notes.end());
            // A label map that only corrects or completes others may be a small part of the body.
            if (request.labels.size() == 1 && !request.autosegment)
                check_extent(read.labels.grid, "labels", request, imported);
            if (imported.ct != nullptr)
                check_overlap(*imported.ct, read.labels, path);
            if (request.labels.size() == 1)
                return std::move(read.labels);
            if (!labels)
                labels = mesh::LabelVolume { imported.ct->grid, std::vector<Label>(imported.ct->grid.voxel_count(), 0),
                    {} };
            if (const std::size_t changed = write_over(*labels, read.labels); changed > 0)
                imported.notes.push_back(std::to_string(changed)
                    + " voxels of earlier label maps were overruled by number "
                    // The name of a file may be the patient's name.
                    + std::to_string(&path - request.labels.data() + 1));
        }
        return labels;
    }

    void prune_table(mesh::LabelVolume& labels, ImportedCase& imported)
    {
        const std::vector<std::size_t> counts = voxel_counts(labels);
        std::vector<std::string> absent;
        for (const mesh::LabelInfo& info : labels.table)
            if (counts[info.id] == 0)
                absent.push_back(info.name);
        std::erase_if(labels.table, [&](const mesh::LabelInfo& info) { return counts[info.id] == 0; });
        if (labels.table.empty())
            throw InputError("no voxel is labelled", "labels", { "labels" });
        if (!absent.empty())
            imported.notes.push_back("named in the label table but without voxels: " + first_names(absent));
    }

    mesh::LabelVolume find_labels(
        const ImportRequest& request, std::optional<mesh::LabelVolume> given, ImportedCase& imported, const Job& job)
    {
        RETRACTOR_ASSERT(given.has_value() || request.autosegment); // check_request() refuses it
        if (!request.autosegment)
            return *std::move(given);
        datasets::AutosegmentOptions options;
        options.spacing_mm = request.autosegment_spacing_mm;
        options.given = std::move(given);
        datasets::Segmentation found = datasets::autosegment(*imported.ct, options, job);
        imported.structures = std::move(found.structures);
        imported.warnings.insert(imported.warnings.end(), found.warnings.begin(), found.warnings.end());
        return std::move(found.labels);
    }

    /// Mean of the CT over a label, in the common part of the two images.
    struct LabelValues {
        std::size_t inside = 0, outside = 0;
        double sum_hu = 0.0;
        double mean_hu() const { return sum_hu / static_cast<double>(std::max<std::size_t>(inside, 1)); }
    };

    std::vector<LabelValues> values_of_labels(const mesh::Volume& ct, const mesh::LabelVolume& labels)
    {
        std::vector<LabelValues> values(mesh::kLabelCount);
        const Vec3 start = ct.grid.index(labels.grid.origin);
        Mat3 step; // change of the CT's index per index of the labels
        for (int axis = 0; axis < 3; ++axis)
            step.col(axis) = ct.grid.index(labels.grid.world(Vec3::Unit(axis))) - start;
        mesh::visit_voxels(labels, [&](int i, int j, int k, Label label) {
            if (label == 0)
                return;
            LabelValues& value = values[label];
            const Vec3 index = (start + step * Vec3(i, j, k)).array().round();
            if (!holds_index(ct.grid, index)) {
                ++value.outside;
                return;
            }
            const Eigen::Vector3i v = index.cast<int>();
            ++value.inside;
            value.sum_hu += ct.voxels[ct.grid.offset(v.x(), v.y(), v.z())];
        });
        return values;
    }

    /// Whether the labels belong to another image or are shifted: bone that is not dense, lungs that are not air,
    /// organs in air.
    bool is_implausible(const mesh::LabelInfo& info, double mean_hu)
    {
        if (info.material == "bone")
            return mean_hu < 50.0;
        if (info.material == "lung")
            return mean_hu > -300.0;
        // The wall of an airway is thinner than a voxel, and the gut is full of gas.
        const bool hollow
            = info.material == "cartilage" || (info.material == "muscle" && info.role == mesh::Role::voxel);
        return !hollow && mean_hu < -300.0;
    }

    /// Warns when the labels do not fit the values of the CT, and refuses them when most do not. Labels of another
    /// patient may well have the same grid.
    void check_plausibility(
        const mesh::Volume& ct, const mesh::LabelVolume& labels, bool insisted, ImportedCase& imported)
    {
        constexpr std::size_t kEnoughVoxels = 100, kEnoughLabels = 3;
        constexpr double kMuchOutside = 0.05, kMost = 0.5;
        const std::string kInsist = "; if they are of this CT, insist on them";
        const std::vector<LabelValues> values = values_of_labels(ct, labels);
        std::vector<std::string> odd;
        std::size_t inside = 0, outside = 0, known = 0;
        for (const mesh::LabelInfo& info : labels.table) {
            const LabelValues& value = values[info.id];
            known += value.inside >= kEnoughVoxels ? 1 : 0;
            inside += value.inside;
            outside += value.outside;
            if (value.inside >= kEnoughVoxels && is_implausible(info, value.mean_hu()))
                odd.push_back(info.name + " (mean " + in_words(value.mean_hu()) + " HU)");
        }
        const double share = static_cast<double>(outside) / static_cast<double>(inside + outside);
        if (share > kMost && !insisted)
            throw InputError("these labels belong to other images: " + in_words(100.0 * share)
                    + " % of their voxels lie outside the CT" + kInsist,
                "labels", { "accept_labels" });
        if (known >= kEnoughLabels && static_cast<double>(odd.size()) > kMost * static_cast<double>(known) && !insisted)
            throw InputError("these labels belong to another patient or to other images: " + std::to_string(odd.size())
                    + " of " + std::to_string(known) + " are not what the CT shows: " + first_names(odd) + kInsist,
                "labels", { "accept_labels" });
        if (!odd.empty())
            imported.warnings.push_back(
                "the CT does not show what these labels say; are both of the same images? " + first_names(odd));
        if (share > kMuchOutside)
            imported.warnings.push_back(in_words(100.0 * share) + " % of the labelled voxels lie outside the CT");
    }

    /// Withholds the patient's name in texts that the notes quote (series descriptions, file names).
    void withhold_identity(const ImportRequest& request, ImportedCase& imported)
    {
        if (request.ct.empty() || !datasets::holds_dicom(request.ct))
            return;
        const std::vector<datasets::PatientIdentity> identities = datasets::dicom_identities(request.ct);
        for (std::string& note : imported.notes)
            note = datasets::without_identity(note, identities);
        for (std::string& warning : imported.warnings)
            warning = datasets::without_identity(warning, identities);
        for (datasets::DicomSeries& series : imported.series)
            series.description = datasets::without_identity(series.description, identities);
    }

    void read_all(const ImportRequest& request, ImportedCase& imported, const Job& job)
    {
        read_ct(request, imported, job);
        if (job.cancelled())
            return;
        std::optional<mesh::LabelVolume> given = read_labels(request, imported, job);
        if (given && request.repair_labels && !job.cancelled())
            imported.repaired = datasets::repair_labels(*given, 0.02, job);
        if (job.cancelled())
            return;
        mesh::LabelVolume labels = find_labels(request, std::move(given), imported, job);
        if (job.cancelled())
            return;
        prune_table(labels, imported);
        imported.fragments = datasets::find_fragments(labels, job);
        for (std::string& doubt : rib_doubts(labels, job))
            imported.warnings.push_back(std::move(doubt));
        if (!has_soft_wall(labels.table))
            imported.warnings.push_back("no label has the role wall (bones alone are none): the case can be looked at, "
                                        "but no approach can be planned through it");
        if (imported.ct != nullptr)
            check_plausibility(*imported.ct, labels, request.accept_labels, imported);
        imported.assumed_vessels = assumed_vessels(labels);
        if (!imported.assumed_vessels.empty())
            imported.notes.push_back(
                "mammary arteries, and vessels and nerves under the ribs, are not seen in the image: "
                "they are assumed where they usually are");
        withhold_identity(request, imported);
        imported.labels = std::make_shared<const mesh::LabelVolume>(std::move(labels));
    }

    // ---- writing ---------------------------------------------------------------------------------------------------

    void make_folder(const fs::path& folder)
    {
        std::error_code code;
        fs::create_directories(folder, code);
        if (code)
            throw IoError("cannot make the folder: " + code.message(), folder.string());
    }

    /// A hidden folder for incomplete files. The destructor deletes the folder with its content.
    class Staging {
    public:
        explicit Staging(const fs::path& parent)
            : folder_(parent / (kPrefix + std::to_string(::getpid())))
        {
            remove_abandoned(parent);
            make_folder(folder_);
        }
        ~Staging()
        {
            std::error_code ignored;
            fs::remove_all(folder_, ignored);
        }
        Staging(const Staging&) = delete;
        Staging& operator=(const Staging&) = delete;
        const fs::path& folder() const { return folder_; }

    private:
        static inline const std::string kPrefix = ".retractor-import-";

        /// Removes the folders of imports that were killed.
        static void remove_abandoned(const fs::path& parent)
        {
            std::error_code error;
            for (const auto& entry : fs::directory_iterator(parent, error)) {
                const std::string name = entry.path().filename().string();
                if (!name.starts_with(kPrefix))
                    continue;
                const long process = std::strtol(name.c_str() + kPrefix.size(), nullptr, 10);
                if (process > 0 && ::kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH)
                    fs::remove_all(entry.path(), error);
            }
        }
        fs::path folder_;
    };

    std::string content_of(const fs::path& file)
    {
        std::ifstream stream(file, std::ios::binary);
        return { std::istreambuf_iterator<char>(stream), {} };
    }

    bool same_labels(const fs::path& a, const fs::path& b)
    {
        return fs::exists(datasets::label_table_path(b))
            && content_of(datasets::label_table_path(a)) == content_of(datasets::label_table_path(b))
            && checksum(a) == checksum(b);
    }

    /// The first of <stem>.nrrd, <stem>-2.nrrd ... that does not exist or already has the wanted content.
    template <typename Same> fs::path place_for(const fs::path& folder, const std::string& stem, Same&& same)
    {
        for (int n = 1;; ++n) {
            const fs::path path = folder / (stem + (n == 1 ? "" : "-" + std::to_string(n)) + ".nrrd");
            if ((!fs::exists(path) && !fs::exists(datasets::label_table_path(path)))
                || (fs::exists(path) && same(path)))
                return path;
        }
    }

    /// Files that an import moves into the case's folder. Unless keep() is called, the destructor deletes them again.
    class Arrivals {
    public:
        Arrivals() = default;
        Arrivals(const Arrivals&) = delete;
        Arrivals& operator=(const Arrivals&) = delete;
        ~Arrivals()
        {
            std::error_code ignored;
            for (const fs::path& path : arrived_)
                fs::remove(path, ignored);
        }
        /// @pre there is no file at `to`
        void move(const fs::path& from, const fs::path& to)
        {
            arrived_.reserve(arrived_.size() + 1); // push_back() then cannot fail after the file was moved
            std::error_code code;
            fs::rename(from, to, code);
            if (code)
                throw IoError("cannot rename the finished file: " + code.message(), to.string());
            arrived_.push_back(to);
        }
        void keep() { arrived_.clear(); }

    private:
        std::vector<fs::path> arrived_;
    };

    /// Writes a file into the folder for incomplete files. A failure names the file in the case's folder, since the
    /// user does not know the other.
    template <typename Write>
    fs::path stage(const std::string& name, const fs::path& folder, const Staging& staging, Write&& write)
    {
        fs::path staged = staging.folder() / name;
        try {
            write(staged);
        } catch (const IoError& error) {
            throw IoError(error.what(), (folder / name).string());
        }
        return staged;
    }

    /// The images of a case, complete, and not yet in its folder.
    struct StagedImages {
        fs::path labels, ct; ///< `ct` is empty without a CT
    };

    StagedImages stage_images(
        const mesh::LabelVolume& labels, const mesh::Volume* ct, const fs::path& folder, const Staging& staging)
    {
        StagedImages staged;
        staged.labels = stage(
            "labels.nrrd", folder, staging, [&](const fs::path& path) { datasets::write_label_volume(path, labels); });
        if (ct != nullptr)
            staged.ct
                = stage("ct.nrrd", folder, staging, [&](const fs::path& path) { datasets::write_volume(path, *ct); });
        return staged;
    }

    FileReference settle_ct(const fs::path& staged, const fs::path& folder, Arrivals& arrivals)
    {
        const fs::path path
            = place_for(folder, "ct", [&](const fs::path& other) { return checksum(staged) == checksum(other); });
        if (!fs::exists(path))
            arrivals.move(staged, path);
        return make_reference(folder, path);
    }

    FileReference settle_labels(const fs::path& staged, const fs::path& folder, Arrivals& arrivals)
    {
        const fs::path path
            = place_for(folder, "labels", [&](const fs::path& other) { return same_labels(staged, other); });
        if (!fs::exists(path)) {
            arrivals.move(datasets::label_table_path(staged), datasets::label_table_path(path));
            arrivals.move(staged, path);
        }
        return make_reference(folder, path);
    }

    /// Writes the case file, which refers to what has arrived. Where only its name could not be flushed to disk, the
    /// file is in place although its writing failed: what it refers to then stays.
    void write_case_of(const Case& planned_case, Arrivals& arrivals)
    {
        try {
            write_case(planned_case);
        } catch (const IoError&) {
            if (content_of(planned_case.file()) == case_to_json(planned_case))
                arrivals.keep();
            throw;
        }
        arrivals.keep();
    }

    /// The labels that hold the ribs: the spine, or the vertebrae when each has its own label. Without them, only the
    /// border of the meshed region holds the wall.
    std::vector<std::string> supporting_labels(const mesh::LabelTable& table)
    {
        if (mesh::find_label(table, "spine") != nullptr)
            return { "spine" };
        std::vector<std::string> vertebrae;
        for (const mesh::LabelInfo& info : table)
            if (info.name.starts_with("vertebrae") && info.role == mesh::Role::wall)
                vertebrae.push_back(info.name);
        return vertebrae;
    }

} // namespace

std::optional<std::string> identity_warning(const fs::path& ct, const fs::path& case_file)
{
    const fs::path folder = fs::weakly_canonical(case_file).parent_path();
    const fs::path relative = fs::weakly_canonical(ct).lexically_relative(folder);
    if (ct.empty() || relative.empty() || *relative.begin() == ".." || !datasets::holds_dicom(ct))
        return std::nullopt;
    return "the DICOM files lie inside the case folder and carry the patient's name and id: the case does not need "
           "them, take them out before handing the folder on";
}

ImportedCase read_import(const ImportRequest& request, const Job& job)
{
    check_request(request);
    ImportedCase imported;
    imported.accept_implausible = request.accept_implausible;
    try {
        read_all(request, imported, job);
    } catch (const Error&) {
        if (!job.cancelled()) // a cancelled step may complain about incomplete data
            datasets::rethrow_without_identity(request.ct);
    }
    imported.cancelled = job.cancelled();
    return imported;
}

void check_case_file_name(const fs::path& case_file)
{
    // Name of a label table: labels.labels.json lies beside the case file.
    constexpr std::string_view kTable = ".labels.json";
    const std::string name = case_file.filename().string();
    if (case_file.extension() != ".json" || name.ends_with(kTable))
        throw InputError(
            "the case file must have a name that ends in .json, and not in " + std::string(kTable), case_file.string());
    std::error_code none;
    if (fs::is_directory(case_file, none))
        throw InputError("is a folder: name the case file in it", case_file.string());
}

Case write_import(const ImportedCase& imported, const fs::path& case_file)
{
    check_case_file_name(case_file);
    if (imported.cancelled || imported.labels == nullptr)
        throw InputError("a cancelled import cannot be written", case_file.string());
    Case made;
    made.folder = case_file.has_parent_path() ? case_file.parent_path() : fs::path(".");
    made.file_name = case_file.filename().string();
    made.label_table = imported.labels->table;
    for (const datasets::FoundStructure& structure : imported.structures)
        if (structure.rough && mesh::find_label(made.label_table, structure.name) != nullptr)
            made.estimated_labels.push_back(structure.name);
    made.supports.labels = supporting_labels(made.label_table);
    made.assumed_vessels = imported.assumed_vessels;
    made.patient = imported.patient;
    made.accept_implausible = imported.accept_implausible;
    // For one wound of a patient, forces of four-node elements are about twice too large and stay so when the mesh is
    // refined. Ten nodes at bone and lips give the forces of ten nodes everywhere in about half of the time
    // (docs/method/verification.md).
    made.solution.element = ElementKind::mixed;
    made.sizing.corridor_edge_mm = 8.0;
    make_folder(made.folder);
    const Staging staging(made.folder);
    // Both are written before one is moved: a full disk leaves the folder as it was.
    const StagedImages staged = stage_images(*imported.labels, imported.ct.get(), made.folder, staging);
    Arrivals arrivals;
    made.labels = settle_labels(staged.labels, made.folder, arrivals);
    if (!staged.ct.empty())
        made.ct = settle_ct(staged.ct, made.folder, arrivals);
    write_case_of(made, arrivals);
    return made;
}

Case write_corrected_labels(Case planned_case, const mesh::LabelVolume& labels)
{
    planned_case.label_table = labels.table;
    std::erase_if(planned_case.assumed_vessels, // a label that someone has made of it takes its place
        [&](const AssumedVessel& vessel) { return is_labelled(vessel.name, labels.table); });
    check_case(planned_case);
    const Staging staging(planned_case.folder);
    const StagedImages staged = stage_images(labels, nullptr, planned_case.folder, staging);
    Arrivals arrivals;
    planned_case.labels = settle_labels(staged.labels, planned_case.folder, arrivals);
    write_case_of(planned_case, arrivals);
    return planned_case;
}

std::vector<LabelSize> label_sizes(const mesh::LabelVolume& labels)
{
    const std::vector<std::size_t> counts = voxel_counts(labels);
    std::vector<LabelSize> sizes;
    for (const mesh::LabelInfo& info : labels.table)
        sizes.push_back(
            { info, counts[info.id], static_cast<double>(counts[info.id]) * labels.grid.voxel_volume() / 1000.0 });
    return sizes;
}

} // namespace retractor::planner
