#include "datasets/segmentation/given_labels.h"

#include <limits>
#include <optional>
#include <string_view>
#include <vector>

namespace retractor::datasets::segmentation {

namespace {

    /// The structure to which a label belongs as a part; nothing for other labels.
    std::optional<mesh::LabelInfo> whole_of(std::string_view name)
    {
        if (name.starts_with("lung_") && name.find("lobe") != std::string_view::npos) {
            if (name.ends_with("_left"))
                return mesh::LabelInfo { 0, "lung_left", "lung", mesh::Role::voxel };
            if (name.ends_with("_right"))
                return mesh::LabelInfo { 0, "lung_right", "lung", mesh::Role::voxel };
        }
        if (name.starts_with("vertebrae_"))
            return mesh::LabelInfo { 0, "spine", "bone", mesh::Role::wall };
        return std::nullopt;
    }

} // namespace

mesh::LabelVolume with_parts_joined(mesh::LabelVolume labels)
{
    std::vector<Label> id_of(std::size_t { std::numeric_limits<Label>::max() } + 1);
    for (std::size_t id = 0; id < id_of.size(); ++id)
        id_of[id] = static_cast<Label>(id);
    mesh::LabelTable table;
    for (const mesh::LabelInfo& info : labels.table)
        if (!whole_of(info.name))
            table.push_back(info);
    for (const mesh::LabelInfo& info : labels.table) {
        std::optional<mesh::LabelInfo> whole = whole_of(info.name);
        if (!whole)
            continue;
        if (const mesh::LabelInfo* known = mesh::find_label(table, whole->name)) {
            id_of[info.id] = known->id;
        } else { // the first part's id stands for the whole
            whole->id = info.id;
            table.push_back(*whole);
        }
    }
    for (Label& voxel : labels.voxels)
        voxel = id_of[voxel];
    labels.table = std::move(table);
    return labels;
}

} // namespace retractor::datasets::segmentation
