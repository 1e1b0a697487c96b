#include "ui/cli/case/case_files.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <limits>

namespace retractor::ui::cli {

namespace {

    Json numbers(const Vec3& v) { return Json::array({ v.x(), v.y(), v.z() }); }

    Json grid_document(const mesh::ImageGrid& grid)
    {
        Json direction = Json::array();
        for (int column = 0; column < 3; ++column)
            direction.push_back(numbers(grid.direction.col(column)));
        return { { "size", grid.size }, { "spacing_mm", numbers(grid.spacing) }, { "origin_mm", numbers(grid.origin) },
            { "axes", direction } };
    }

    std::string grid_text(const mesh::ImageGrid& grid)
    {
        return formatted("%d x %d x %d at %.4g x %.4g x %.4g mm", grid.size[0], grid.size[1], grid.size[2],
            grid.spacing.x(), grid.spacing.y(), grid.spacing.z());
    }

    struct HounsfieldRange {
        int least = 0, most = 0;
        int low = 0, high = 0; ///< values with one voxel in a hundred below, or above
    };

    HounsfieldRange hounsfield_range(const mesh::Volume& ct)
    {
        constexpr int kOffset = -std::numeric_limits<std::int16_t>::min();
        std::vector<std::size_t> histogram(1U << 16U, 0);
        for (const std::int16_t hu : ct.voxels)
            ++histogram[static_cast<std::size_t>(hu + kOffset)];
        const auto value_at = [&](double share) {
            const auto wanted = static_cast<std::size_t>(share * static_cast<double>(ct.voxels.size() - 1));
            std::size_t below = 0;
            for (std::size_t bin = 0; bin < histogram.size(); ++bin) {
                below += histogram[bin];
                if (below > wanted)
                    return static_cast<int>(bin) - kOffset;
            }
            return 0;
        };
        return { value_at(0.0), value_at(1.0), value_at(0.01), value_at(0.99) };
    }

    const datasets::LabelFragments* fragments_of(const planner::ImportedCase& imported, const std::string& name)
    {
        const auto found = std::find_if(imported.fragments.begin(), imported.fragments.end(),
            [&](const datasets::LabelFragments& fragments) { return fragments.name == name; });
        return found == imported.fragments.end() ? nullptr : &*found;
    }

    const datasets::FoundStructure* structure_of(const planner::ImportedCase& imported, const std::string& name)
    {
        const auto found = std::find_if(imported.structures.begin(), imported.structures.end(),
            [&](const datasets::FoundStructure& structure) { return structure.name == name; });
        return found == imported.structures.end() ? nullptr : &*found;
    }

    Json fragments_document(const std::vector<datasets::LabelFragments>& list)
    {
        Json document = Json::array();
        for (const datasets::LabelFragments& f : list)
            document.push_back({ { "name", f.name }, { "voxels", f.voxels }, { "pieces", f.pieces },
                { "stray_voxels", f.stray_voxels }, { "hole_voxels", f.hole_voxels } });
        return document;
    }

    std::string label_table_text(const planner::ImportedCase& imported)
    {
        std::string text = formatted(
            "%-26s %-8s %-12s %10s %7s  %s\n", "label", "role", "material", "volume ml", "pieces", "found by");
        for (const planner::LabelSize& size : planner::label_sizes(*imported.labels)) {
            const datasets::LabelFragments* fragments = fragments_of(imported, size.info.name);
            const datasets::FoundStructure* structure = structure_of(imported, size.info.name);
            text += formatted("%-26s %-8s %-12s %10.1f %7zu  %s%s\n", size.info.name.c_str(),
                std::string(to_string(size.info.role)).c_str(), size.info.material.c_str(), size.volume_ml,
                fragments == nullptr ? std::size_t { 1 } : fragments->pieces,
                structure != nullptr && structure->rough ? "ROUGH: " : "",
                structure != nullptr ? structure->how.c_str() : "");
        }
        return text;
    }

} // namespace

Json series_document(const std::vector<datasets::DicomSeries>& series)
{
    Json list = Json::array();
    for (const datasets::DicomSeries& s : series)
        list.push_back({ { "uid", s.uid }, { "number", s.number }, { "description", s.description },
            { "modality", s.modality }, { "files", s.files }, { "frames", s.frames }, { "columns", s.columns_rows[0] },
            { "rows", s.columns_rows[1] }, { "axial", s.axial }, { "kind", s.kind } });
    return list;
}

std::string series_text(const std::vector<datasets::DicomSeries>& series)
{
    std::string text = formatted("%-8s %-7s %-9s %7s %12s %-6s %-17s %s\n", "--series", "number", "modality", "slices",
        "size", "axial", "kind", "description");
    for (std::size_t n = 0; n < series.size(); ++n) {
        const datasets::DicomSeries& s = series[n];
        text += formatted("#%-7zu %-7s %-9s %7zu %5d x %-5d %-6s %-17s %s\n", n + 1, s.number.c_str(),
            s.modality.c_str(), s.frames, s.columns_rows[0], s.columns_rows[1], s.axial ? "yes" : "no",
            s.kind.empty() ? "slices" : s.kind.c_str(), s.description.c_str());
    }
    return text;
}

Json import_document(const planner::ImportedCase& imported)
{
    Json document;
    document["frame"] = "LPS";
    if (!imported.series.empty())
        document["series"] = series_document(imported.series);
    if (imported.ct != nullptr) {
        const HounsfieldRange hu = hounsfield_range(*imported.ct);
        document["ct"] = grid_document(imported.ct->grid);
        document["ct"]["hu"]
            = { { "min", hu.least }, { "max", hu.most }, { "percentile_1", hu.low }, { "percentile_99", hu.high } };
    }
    document["labels_grid"] = grid_document(imported.labels->grid);
    document["labels"] = Json::array();
    for (const planner::LabelSize& size : planner::label_sizes(*imported.labels)) {
        const datasets::LabelFragments* fragments = fragments_of(imported, size.info.name);
        document["labels"].push_back(
            { { "id", size.info.id }, { "name", size.info.name }, { "material", size.info.material },
                { "role", to_string(size.info.role) }, { "voxels", size.voxels }, { "volume_ml", size.volume_ml },
                { "pieces", fragments == nullptr ? std::size_t { 1 } : fragments->pieces } });
    }
    document["fragments"] = fragments_document(imported.fragments);
    document["repaired"] = fragments_document(imported.repaired);
    document["structures"] = Json::array();
    for (const datasets::FoundStructure& s : imported.structures)
        document["structures"].push_back(
            { { "name", s.name }, { "volume_ml", s.volume_ml }, { "rough", s.rough }, { "how", s.how } });
    document["notes"] = imported.notes;
    document["warnings"] = imported.warnings;
    return document;
}

std::string import_text(const planner::ImportedCase& imported)
{
    std::string text;
    if (imported.series.size() > 1)
        text += series_text(imported.series);
    if (imported.ct != nullptr) {
        const HounsfieldRange hu = hounsfield_range(*imported.ct);
        text += "CT:     " + grid_text(imported.ct->grid)
            + formatted(", %d to %d HU (99 %% above %d, 99 %% below %d)\n", hu.least, hu.most, hu.low, hu.high);
    }
    text += "labels: " + grid_text(imported.labels->grid) + "\n" + label_table_text(imported);
    for (const datasets::LabelFragments& f : imported.fragments)
        text += formatted(
            "in pieces: %s: %zu pieces, %zu of %zu voxels outside the largest piece, %zu voxels in holes\n",
            f.name.c_str(), f.pieces, f.stray_voxels, f.voxels, f.hole_voxels);
    for (const datasets::LabelFragments& f : imported.repaired)
        text += formatted("repaired: %s: %zu stray voxels removed of %zu pieces, %zu voxels of holes filled\n",
            f.name.c_str(), f.stray_voxels, f.pieces, f.hole_voxels);
    for (const std::string& note : imported.notes)
        text += "note: " + note + "\n";
    for (const std::string& warning : imported.warnings)
        text += "warning: " + warning + "\n";
    return text;
}

} // namespace retractor::ui::cli
