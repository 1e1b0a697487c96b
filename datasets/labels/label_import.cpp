#include "datasets/labels/label_import.h"

#include "datasets/io/image_reader.h"
#include "datasets/io/label_table.h"
#include "datasets/io/volume_io.h"
#include "datasets/labels/dicom_labels.h"
#include "datasets/labels/label_file_names.h"
#include "datasets/labels/label_masks.h"
#include "datasets/labels/label_presets.h"
#include "datasets/labels/seg_nrrd.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    using Notes = std::vector<std::string>;
    using Names = std::map<Label, std::string>;
    using Counts = std::map<Label, std::size_t>; ///< voxels per id, without id 0

    constexpr std::size_t kMostTold = 8; ///< most names or ids in one line

    std::string counted(std::size_t count, const std::string& what)
    {
        return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
    }

    /// The first entries of a list, and the number of the other entries.
    std::string listed(const std::vector<std::string>& items)
    {
        std::string text;
        for (std::size_t n = 0; n < std::min(items.size(), kMostTold); ++n)
            text += (n == 0 ? "" : ", ") + items[n];
        return items.size() > kMostTold ? text + " and " + std::to_string(items.size() - kMostTold) + " more" : text;
    }

    Counts count_voxels(const std::vector<Label>& voxels)
    {
        std::vector<std::size_t> counts(std::size_t { std::numeric_limits<Label>::max() } + 1, 0);
        for (const Label voxel : voxels)
            ++counts[voxel];
        Counts present;
        for (std::size_t id = 1; id < counts.size(); ++id)
            if (counts[id] > 0)
                present.emplace(static_cast<Label>(id), counts[id]);
        return present;
    }

    std::string ids_with_counts(const Counts& counts)
    {
        std::vector<std::string> items;
        for (const auto& [id, count] : counts)
            items.push_back(std::to_string(id) + " (" + counted(count, "voxel") + ")");
        return listed(items);
    }

    std::string what_to_do(const fs::path& image)
    {
        std::string presets;
        // This preset needs names in the file.
        for (const std::string& preset : label_preset_names())
            if (preset != "slicer")
                presets += (presets.empty() ? "" : ", ") + preset;
        return "give a preset (" + presets + ") or put a table beside the image ("
            + label_table_path(image).filename().string() + ")";
    }

    /// Makes a table from the names in a file. When two ids have the same structure, the id is appended to the later
    /// name.
    mesh::LabelTable named_table(const Names& names, Notes& notes)
    {
        mesh::LabelTable table;
        std::vector<std::string> renamed;
        for (const auto& [id, name] : names) {
            mesh::LabelInfo info = describe_structure(name, id);
            if (mesh::find_label(table, info.name) != nullptr) {
                notes.push_back("the structure " + info.name + " occurs twice, id " + std::to_string(id) + " becomes "
                    + info.name + "_" + std::to_string(id));
                info.name += "_" + std::to_string(id);
            }
            if (info.name != name)
                renamed.push_back(name + " -> " + info.name);
            table.push_back(std::move(info));
        }
        if (!renamed.empty())
            notes.push_back("renamed: " + listed(renamed));
        return table;
    }

    void keep_present(mesh::LabelTable& table, const Counts& present)
    {
        std::erase_if(table, [&](const mesh::LabelInfo& info) { return !present.contains(info.id); });
    }

    void check_all_named(
        const mesh::LabelTable& table, const Counts& present, const std::string& by, const fs::path& image)
    {
        Counts unnamed = present;
        for (const mesh::LabelInfo& info : table)
            unnamed.erase(info.id);
        if (!unnamed.empty())
            throw InputError(counted(unnamed.size(), "label") + " without a name in " + by + ": "
                    + ids_with_counts(unnamed) + "; " + what_to_do(image),
                image.string());
    }

    /// Refuses a preset that contradicts the names in the file. The image may come from another version of a tool than
    /// the user chose.
    void check_preset_agrees(
        const mesh::LabelTable& table, const Names& own, const std::string& preset, const fs::path& image)
    {
        for (const mesh::LabelInfo& info : table) {
            const auto name = own.find(info.id);
            if (name != own.end() && describe_structure(name->second, info.id).name != info.name)
                throw InputError("preset " + preset + " says that id " + std::to_string(info.id) + " is " + info.name
                        + ", the file itself says " + name->second + ": leave the preset out, or choose another",
                    image.string());
        }
    }

    std::string type_name(Label type)
    {
        static const std::map<Label, std::string> kTypes { { 1, "normal parenchyma" }, { 2, "airway" }, { 3, "vessel" },
            { 4, "emphysema" }, { 5, "ground glass" }, { 8, "oblique fissure" }, { 9, "horizontal fissure" },
            { 38, "trachea" }, { 39, "main bronchus" }, { 49, "calcification" }, { 50, "artery" }, { 51, "vein" },
            { 70, "subcutaneous fat" }, { 71, "visceral fat" }, { 80, "muscle" }, { 83, "bone" } };
        const auto found = kTypes.find(type);
        return found == kTypes.end() ? "type " + std::to_string(type) : found->second;
    }

    /// Keeps the region of the Chest Imaging Platform's packed labels, region + (type << 8).
    void keep_regions(std::vector<Label>& voxels, Notes& notes)
    {
        constexpr Label kOutsideBody = 30;
        Counts types;
        std::size_t without_region = 0, outside = 0;
        for (Label& voxel : voxels) {
            const auto type = static_cast<Label>(voxel >> 8);
            const auto region = static_cast<Label>(voxel & 0xff);
            if (type != 0) {
                ++types[type];
                without_region += region == 0 ? 1 : 0;
            }
            outside += region == kOutsideBody ? 1 : 0;
            voxel = region == kOutsideBody ? Label { 0 } : region;
        }
        std::vector<std::string> items;
        for (const auto& [type, count] : types)
            items.push_back(type_name(type) + " (" + counted(count, "voxel") + ")");
        if (!items.empty())
            notes.push_back("the regions are kept, the tissue types in them are not: " + listed(items));
        if (without_region > 0)
            notes.push_back(counted(without_region, "voxel") + " have a type but no region: they have no label now");
        if (outside > 0)
            notes.push_back(counted(outside, "voxel") + " lie outside the body by their label: they have none now");
    }

    void name_by_preset(mesh::LabelVolume& labels, const std::string& preset, const fs::path& path, Notes& notes)
    {
        mesh::LabelTable table;
        try {
            table = preset_table(preset);
        } catch (const InputError& error) {
            throw InputError(std::string(error.what()) + " (" + error.where() + ")", path.string());
        }
        if (preset == "cip")
            keep_regions(labels.voxels, notes);
        const Counts present = count_voxels(labels.voxels);
        check_all_named(table, present, "preset " + preset, path);
        const std::size_t all = table.size();
        keep_present(table, present);
        check_preset_agrees(table, label_names_in_file(path), preset, path);
        notes.push_back("names by preset " + preset + ": " + std::to_string(table.size()) + " of its "
            + std::to_string(all) + " structures have voxels");
        if (fs::exists(label_table_path(path)))
            notes.push_back("the table beside the image (" + label_table_path(path).filename().string()
                + ") is not used: the preset was asked for");
        labels.table = std::move(table);
    }

    void name_by_file(mesh::LabelVolume& labels, const fs::path& path, Notes& notes)
    {
        const Counts present = count_voxels(labels.voxels);
        if (fs::exists(label_table_path(path))) {
            labels.table = read_label_table(label_table_path(path));
            check_all_named(labels.table, present, label_table_path(path).filename().string(), path);
            notes.push_back(
                "names from the table beside the image (" + label_table_path(path).filename().string() + ")");
            return;
        }
        Names names = label_names_in_file(path);
        if (names.empty())
            throw InputError(
                "the labels have no names: " + ids_with_counts(present) + "; " + what_to_do(path), path.string());
        const std::size_t all = names.size();
        std::erase_if(names, [&](const auto& entry) { return !present.contains(entry.first); });
        notes.push_back("names from the file's header: " + std::to_string(names.size()) + " of its "
            + std::to_string(all) + " structures have voxels");
        labels.table = named_table(names, notes);
        check_all_named(labels.table, present, "the file's header", path);
    }

    /// Names segments that the user did not name, by their coded terms.
    void name_by_terms(SegmentedImage& image, Notes& notes)
    {
        for (Segment& segment : image.segments) {
            const auto entry = segment.tags.find("TerminologyEntry");
            const bool automatic
                = segment.name.empty() || segment.name == segment.id || segment.name.starts_with("Segment_");
            if (!automatic || entry == segment.tags.end())
                continue;
            const std::string terms = structure_from_terminology(entry->second);
            if (terms.empty())
                continue;
            notes.push_back("segment \"" + segment.name + "\" is " + terms + " by its terminology");
            segment.name = terms;
        }
    }

    ImportedLabels import_segments(const fs::path& path, const LabelImportOptions& options, const Job& job)
    {
        if (!options.preset.empty() && options.preset != "slicer") {
            preset_table(options.preset); // throws for a misspelt preset
            throw InputError("preset " + options.preset
                    + " goes by ids, but this file names its segments: leave the preset out, or use slicer",
                path.string());
        }
        const Stopwatch watch;
        SegmentedImage image = is_seg_nrrd(path) ? read_seg_nrrd(path, job) : read_dicom_labels(path, job);
        if (job.cancelled())
            return {};
        ImportedLabels imported;
        name_by_terms(image, imported.notes);
        MergedSegments merged = merge_segments(image, job);
        if (job.cancelled())
            return {};
        imported.labels = std::move(merged.labels);
        imported.notes.insert(imported.notes.end(), merged.notes.begin(), merged.notes.end());
        record_part(job, "labels", watch, imported.labels.voxels.size() * sizeof(Label));
        mesh::LabelTable& table = imported.labels.table;
        const Counts present = count_voxels(imported.labels.voxels);
        std::vector<std::string> empty;
        for (const mesh::LabelInfo& info : table)
            if (!present.contains(info.id))
                empty.push_back(info.name);
        if (!empty.empty())
            imported.notes.push_back(counted(empty.size(), "segment") + " without a voxel, left out: " + listed(empty));
        keep_present(table, present);
        imported.notes.push_back("names from the segments of the file");
        if (fs::exists(label_table_path(path))) {
            table = read_label_table(label_table_path(path));
            check_all_named(table, present, label_table_path(path).filename().string(), path);
            imported.notes.back()
                = "names from the table beside the image (" + label_table_path(path).filename().string() + ")";
        }
        return imported;
    }

    ImportedLabels import_image(const fs::path& path, const LabelImportOptions& options, const Job& job)
    {
        ImportedLabels imported;
        if (is_seg_nrrd(path) || is_dicom_labels(path))
            imported = import_segments(path, options, job);
        else {
            imported.labels = read_label_voxels(path, &imported.notes, job);
            if (job.cancelled())
                return {};
            if (count_voxels(imported.labels.voxels).empty())
                throw InputError("no voxel is labelled: all are 0", path.string());
            if (options.preset.empty())
                name_by_file(imported.labels, path, imported.notes);
            else
                name_by_preset(imported.labels, options.preset, path, imported.notes);
        }
        if (!imported.labels.voxels.empty() && count_voxels(imported.labels.voxels).empty())
            throw InputError("no voxel has a label", path.string());
        return imported;
    }

    // --- A folder of masks ---

    std::vector<fs::path> images_in(const fs::path& folder, Notes& notes)
    {
        std::vector<fs::path> images;
        std::vector<std::string> others;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
            if (entry.is_regular_file() && is_image_name(entry.path()) && !is_seg_nrrd(entry.path()))
                images.push_back(entry.path());
            else
                others.push_back(entry.path().filename().string());
        }
        std::sort(images.begin(), images.end());
        std::sort(others.begin(), others.end());
        if (images.empty())
            throw InputError(
                "the folder has no image of labels (.nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd, .vti)", folder.string());
        if (!others.empty())
            notes.push_back("not read, no mask: " + listed(others));
        return images;
    }

    /// The names for the values of one image in a folder, from the image's header or from its file name.
    Names names_of_masks(const fs::path& path, const Counts& present)
    {
        Names names = label_names_in_file(path);
        const bool all_named = std::all_of(
            present.begin(), present.end(), [&](const auto& entry) { return names.contains(entry.first); });
        if (!all_named && present.size() > 1)
            throw InputError("a mask has one value besides 0, this image has " + std::to_string(present.size()) + ": "
                    + ids_with_counts(present) + "; import it by itself, or take it out of the folder",
                path.string());
        if (!all_named)
            return { { present.begin()->first, image_stem(path) } };
        std::erase_if(names, [&](const auto& entry) { return !present.contains(entry.first); });
        return names;
    }

    /// Reads all masks of a folder. Returns nothing when cancelled.
    std::vector<StructureMask> read_masks(const fs::path& folder, Notes& notes, const Job& job)
    {
        std::vector<StructureMask> masks;
        const std::vector<fs::path> images = images_in(folder, notes);
        std::vector<std::string> empty;
        Job silent; // reading one of many masks records no part of its own
        silent.cancel = job.cancel;
        for (std::size_t n = 0; n < images.size(); ++n) {
            job.report("read labels", static_cast<double>(n) / static_cast<double>(images.size()));
            if (job.cancelled())
                return {};
            std::vector<std::string> told;
            const mesh::LabelVolume image = read_label_voxels(images[n], &told, silent);
            if (job.cancelled())
                return {};
            // All masks of a tool may give the same note.
            for (const std::string& note : told)
                if (std::find(notes.begin(), notes.end(), note) == notes.end())
                    notes.push_back(note);
            if (image.voxels.size() > std::numeric_limits<std::uint32_t>::max())
                throw InputError("the image is too large", images[n].string());
            const Counts present = count_voxels(image.voxels);
            if (present.empty()) {
                empty.push_back(image_stem(images[n]));
                continue;
            }
            for (const auto& [id, name] : names_of_masks(images[n], present))
                masks.push_back({ describe_structure(name, 1).name, images[n].filename().string(), image.grid,
                    runs_of(image.grid, image.voxels, id) });
        }
        if (!empty.empty())
            notes.push_back(counted(empty.size(), "mask") + " without a voxel, left out: " + listed(empty));
        if (masks.empty())
            throw InputError("no mask of the folder has a labelled voxel", folder.string());
        return masks;
    }

    void note_joined(const std::vector<StructureMask>& masks, Notes& notes)
    {
        std::map<std::string, std::vector<std::string>> sources;
        for (const StructureMask& mask : masks)
            sources[mask.name].push_back(mask.source);
        for (const auto& [name, files] : sources)
            if (files.size() > 1)
                notes.push_back(name + " is joined from " + listed(files));
    }

    void note_grid(const MergedMasks& merged, const std::vector<StructureMask>& masks, Notes& notes)
    {
        std::set<std::array<int, 3>> sizes;
        for (const StructureMask& mask : masks)
            sizes.insert(mask.grid.size);
        if (sizes.size() < 2 && !merged.extended)
            return;
        const auto& size = merged.grid.size;
        notes.push_back("the masks lie on different grids: that of " + merged.grid_source + " is kept, the finest"
            + (merged.extended ? ", extended to hold all labelled voxels" : "") + " (" + std::to_string(size[0]) + " x "
            + std::to_string(size[1]) + " x " + std::to_string(size[2]) + ")");
    }

    void note_overlaps(const MergedMasks& merged, Notes& notes)
    {
        for (std::size_t from = 0; from < merged.names.size(); ++from) {
            std::size_t all = 0;
            std::vector<std::string> takers;
            for (const LostVoxels& lost : merged.lost[from]) {
                all += lost.voxels;
                takers.push_back(merged.names[lost.to] + " (" + std::to_string(lost.voxels) + ")");
            }
            if (all == 0)
                continue;
            notes.push_back(merged.names[from] + ": " + counted(all, "voxel")
                + " that smaller structures claim too went to " + listed(takers)
                + (merged.counts[from] == 0 ? "; none is left, it is left out" : ""));
        }
    }

    ImportedLabels import_folder(const fs::path& folder, const LabelImportOptions& options, const Job& job)
    {
        // Throws for a misspelt preset, although the names of the files are used.
        if (!options.preset.empty() && options.preset != "slicer")
            preset_table(options.preset);
        const Stopwatch watch;
        ImportedLabels imported;
        const std::vector<StructureMask> masks = read_masks(folder, imported.notes, job);
        if (masks.empty())
            return {};
        note_joined(masks, imported.notes);
        MergedMasks merged;
        try {
            merged = merge_masks(masks, job);
        } catch (const InputError& error) {
            throw InputError(error.what(), error.where().empty() ? folder.string() : (folder / error.where()).string());
        }
        if (merged.voxels.empty())
            return {};
        note_grid(merged, masks, imported.notes);
        note_overlaps(merged, imported.notes);
        mesh::LabelVolume& labels = imported.labels;
        for (std::size_t n = 0; n < merged.names.size(); ++n)
            if (merged.counts[n] > 0)
                labels.table.push_back(describe_structure(merged.names[n], static_cast<Label>(n + 1)));
        labels.grid = merged.grid;
        labels.voxels = std::move(merged.voxels);
        record_part(job, "labels", watch, labels.voxels.size() * sizeof(Label));
        return imported;
    }

} // namespace

ImportedLabels import_labels(const fs::path& path, const LabelImportOptions& options, const Job& job)
{
    job.report("read labels", 0.0);
    if (!fs::exists(path))
        throw IoError("no such file", path.string());
    ImportedLabels imported
        = fs::is_directory(path) ? import_folder(path, options, job) : import_image(path, options, job);
    job.report("read labels", 1.0);
    return imported;
}

} // namespace retractor::datasets
