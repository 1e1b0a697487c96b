#include "tests/benchmarks/segmentation/bench_segment.h"

#include "datasets/io/volume_io.h"
#include "datasets/phantoms/phantom.h"
#include "datasets/segmentation/autosegment.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/text_format.h"
#include "mesh/image/volume.h"
#include "ui/cli/framework/out_folder.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace retractor::benchmarks {

namespace {

    struct Shape {
        const char* name;
        double width_mm, depth_mm, height_mm, fat_mm, muscle_mm;
    };
    constexpr std::array<Shape, 3> kShapes { { { "slim", 300.0, 200.0, 300.0, 4.0, 7.0 },
        { "average", 330.0, 225.0, 300.0, 8.0, 10.0 }, { "large", 410.0, 290.0, 330.0, 26.0, 13.0 } } };
    constexpr std::array<double, 3> kNoisesHu { 5.0, 20.0, 40.0 };

    struct Resolution {
        const char* name;
        Vec3 spacing_mm;
    };
    const std::array<Resolution, 2> kResolutions { { { "1.5 mm", Vec3::Constant(1.5) },
        { "0.7 x 0.7 x 1.25 mm", Vec3(0.7, 0.7, 1.25) } } };

    /// Voxels of a name in what is found, in the truth, and in both.
    struct Overlap {
        double found = 0.0, truth = 0.0, both = 0.0;
        double dice() const { return found + truth > 0.0 ? 2.0 * both / (found + truth) : 0.0; }
    };

    /// The aneurysm is a part of the aorta that only a reader of the image names.
    std::string compared_name(const std::string& name) { return name == "aneurysm" ? "aorta" : name; }

    /// @pre both on one grid
    std::map<std::string, Overlap> overlaps(const mesh::LabelVolume& truth, const mesh::LabelVolume& found)
    {
        std::map<std::string, Overlap> result;
        const auto slots = [&](const mesh::LabelTable& table) {
            std::vector<Overlap*> of_label(mesh::kLabelCount, nullptr);
            for (const mesh::LabelInfo& info : table)
                of_label[info.id] = &result[compared_name(info.name)];
            return of_label;
        };
        const std::vector<Overlap*> in_truth = slots(truth.table), in_found = slots(found.table);
        for (std::size_t v = 0; v < truth.voxels.size(); ++v) {
            Overlap *const real = in_truth[truth.voxels[v]], *const seen = in_found[found.voxels[v]];
            if (real != nullptr)
                real->truth += 1.0;
            if (seen != nullptr)
                seen->found += 1.0;
            if (real != nullptr && real == seen)
                real->both += 1.0;
        }
        return result;
    }

    struct Row {
        std::string shape, resolution, worst_rib;
        double noise_hu = 0.0, least_rib = 1.0, mean_rib = 0.0, seconds = 0.0;
        std::map<std::string, double> dice {};
    };

    constexpr std::array<const char*, 7> kStructures { "sternum", "costal_cartilages", "spine", "lung_left",
        "lung_right", "heart", "aorta" };

    Row measured(const Shape& shape, double noise_hu, const Resolution& resolution,
        const datasets::AutosegmentOptions& options, const Job& job)
    {
        datasets::ThoraxParameters parameters;
        parameters.width_mm = shape.width_mm;
        parameters.depth_mm = shape.depth_mm;
        parameters.height_mm = shape.height_mm;
        parameters.fat_mm = shape.fat_mm;
        parameters.muscle_mm = shape.muscle_mm;
        parameters.noise_hu = noise_hu;
        parameters.spacing_mm = resolution.spacing_mm;
        const datasets::Phantom phantom = datasets::make_thorax_phantom(parameters, job);
        Row row { .shape = shape.name, .resolution = resolution.name, .worst_rib = {}, .noise_hu = noise_hu };
        Stopwatch watch;
        const datasets::Segmentation found = datasets::autosegment(phantom.ct, options, job);
        row.seconds = watch.seconds();
        if (job.cancelled())
            return row;
        const std::map<std::string, Overlap> overlap
            = overlaps(phantom.labels, datasets::resample_labels_to(found.labels, phantom.labels.grid));
        constexpr int kRibs = 12;
        for (const char* side : { "left", "right" })
            for (int n = 1; n <= kRibs; ++n) {
                const std::string name = std::string("rib_") + side + "_" + std::to_string(n);
                const double dice = overlap.at(name).dice();
                row.dice[name] = dice;
                row.mean_rib += dice / (2 * kRibs);
                if (dice < row.least_rib) {
                    row.least_rib = dice;
                    row.worst_rib = name;
                }
            }
        for (const char* name : kStructures)
            row.dice[name] = overlap.at(name).dice();
        return row;
    }

    std::string line_of(const Row& row)
    {
        std::string line = formatted("%-8s %5.0f  %-20s %8.3f  %-13s %8.3f", row.shape.c_str(), row.noise_hu,
            row.resolution.c_str(), row.least_rib, row.worst_rib.c_str(), row.mean_rib);
        for (const char* name : kStructures)
            line += formatted("  %*.3f", static_cast<int>(std::string(name).size()), row.dice.at(name));
        return line + formatted("  %6.1f\n", row.seconds);
    }

    ui::cli::Json document_of(const Row& row)
    {
        return { { "shape", row.shape }, { "noise_hu", row.noise_hu }, { "resolution", row.resolution },
            { "least_rib", row.least_rib }, { "worst_rib", row.worst_rib }, { "mean_rib", row.mean_rib },
            { "dice", row.dice }, { "seconds", row.seconds } };
    }

} // namespace

ui::cli::Outcome bench_segment(const SegmentBenchOptions& options, const Job& job)
{
    std::vector<Row> rows;
    datasets::AutosegmentOptions segmentation;
    Job steps = job; // the progress counts phantoms, not their steps
    steps.on_progress = nullptr;
    if (options.quick) {
        constexpr double kCoarseMm = 3.0;
        segmentation.spacing_mm = kCoarseMm;
        rows.push_back(measured(kShapes[1], kNoisesHu[0], { "3 mm", Vec3::Constant(kCoarseMm) }, segmentation, steps));
        ui::cli::refuse_if_cancelled(job);
    } else {
        const auto count = static_cast<double>(kShapes.size() * kNoisesHu.size() * kResolutions.size());
        for (const Resolution& resolution : kResolutions)
            for (const Shape& shape : kShapes)
                for (const double noise_hu : kNoisesHu) {
                    job.report("segment", static_cast<double>(rows.size()) / count);
                    rows.push_back(measured(shape, noise_hu, resolution, segmentation, steps));
                    ui::cli::refuse_if_cancelled(job);
                }
    }
    ui::cli::Outcome outcome;
    outcome.text = "Dice's coefficient of what is found in phantoms of a chest, without any label given\n";
    outcome.text
        += formatted("%-8s %5s  %-20s %8s  %-13s %8s", "shape", "HU", "resolution", "least", "rib", "mean rib");
    for (const char* name : kStructures)
        outcome.text += std::string("  ") + name;
    outcome.text += "  seconds\n";
    outcome.document["results"] = ui::cli::Json::array();
    for (const Row& row : rows) {
        outcome.text += line_of(row);
        outcome.document["results"].push_back(document_of(row));
    }
    const auto least = std::ranges::min_element(rows, {}, &Row::least_rib);
    outcome.text += formatted("least of all ribs: %.3f (%s, %s, %.0f HU)\n", least->least_rib, least->worst_rib.c_str(),
        least->shape.c_str(), least->noise_hu);
    outcome.document["least_rib"] = least->least_rib;
    if (!options.out.empty()) {
        const std::filesystem::path folder = options.out;
        ui::cli::make_folder(folder);
        write_file_atomically(folder / "bench_segment.json", outcome.document.dump(2) + "\n");
    }
    return outcome;
}

} // namespace retractor::benchmarks
