#include "ui/cli/case_files.h"

#include "datasets/volume_io.h"
#include "mesh/base/error.h"
#include "planner/case_io.h"
#include "ui/cli/field_files.h"

#include <cmath>

namespace retractor::cli {

namespace {

    namespace fs = std::filesystem;

    bool lies_inside(const fs::path& path, const fs::path& folder)
    {
        const fs::path relative = fs::weakly_canonical(path).lexically_relative(fs::weakly_canonical(folder));
        return !relative.empty() && *relative.begin() != "..";
    }

    /// The two images must show the same place: at least one corner-to-corner overlap of their world boxes.
    void check_overlap(const Volume& ct, const LabelVolume& labels)
    {
        for (std::size_t i = 0; i < labels.voxels.size(); ++i) {
            if (labels.voxels[i] == 0)
                continue;
            const auto nx = static_cast<std::size_t>(labels.grid.size[0]);
            const auto ny = static_cast<std::size_t>(labels.grid.size[1]);
            const Vec3 index(
                static_cast<double>(i % nx), static_cast<double>(i / nx % ny), static_cast<double>(i / nx / ny));
            const Vec3 at = ct.grid.index(labels.grid.world(index));
            if (ct.grid.contains(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())),
                    static_cast<int>(std::lround(at.z()))))
                return;
        }
        throw InputError("no labelled voxel lies inside the CT: are both of the same patient and frame?", "--labels");
    }

} // namespace

Case make_case(const fs::path& ct_path, const fs::path& labels_path, const fs::path& case_file, const Job& job)
{
    const fs::path folder = case_file.has_parent_path() ? case_file.parent_path() : fs::path(".");
    make_folder(folder);
    Case planned_case;
    planned_case.folder = folder;
    job.report("import", 0.0);
    const LabelVolume labels = read_label_volume(labels_path);
    planned_case.label_table = labels.table;
    std::erase_if(planned_case.supports.labels,
        [&](const std::string& name) { return find_label(labels.table, name) == nullptr; });
    fs::path stored_labels = labels_path;
    if (!lies_inside(labels_path, folder)) {
        stored_labels = folder / "labels.nrrd";
        write_label_volume(stored_labels, labels);
    }
    planned_case.labels = make_reference(folder, stored_labels);
    if (!ct_path.empty()) {
        const Volume ct = read_volume(ct_path);
        check_overlap(ct, labels);
        job.report("import", 0.5);
        fs::path stored_ct = ct_path;
        if (!lies_inside(ct_path, folder)) {
            stored_ct = folder / "ct.nrrd";
            write_volume(stored_ct, ct);
        }
        planned_case.ct = make_reference(folder, stored_ct);
    }
    job.report("import", 1.0);
    write_case(planned_case);
    return planned_case;
}

} // namespace retractor::cli
