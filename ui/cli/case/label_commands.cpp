#include "ui/cli/commands.h"
#include "ui/cli/framework/arguments.h"
#include "ui/cli/framework/number_range.h"
#include "ui/cli/framework/open_case.h"

#include "datasets/labels/label_edit.h"
#include "fem/material/material.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/case/case_io.h"
#include "planner/case/import_case.h"
#include "planner/case/label_correction.h"
#include "planner/case/label_session.h"
#include "planner/case/patient.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace retractor::ui::cli {

namespace {

    constexpr double kLargestBrushMm = 200.0;
    constexpr int kLargestRadius = 10; // as in datasets::smoothed()

    struct LabelOptions {
        std::string case_file, label, to, plane = "axial", material = "vessel", role = "target";
        std::vector<std::string> path, kept;
        double radius_mm = 0.0;
        int voxels = 1;
        bool slice = false;
    };

    const mesh::LabelInfo& label_of(const planner::Case& planned_case, const std::string& name, const char* option)
    {
        try {
            return mesh::label_named(planned_case.label_table, name);
        } catch (const InputError& error) {
            throw InputError(error.what(), std::string(option) + " " + name);
        }
    }

    std::string label_line(const planner::LabelSize& size, const Vec3& middle, const planner::Case& planned_case)
    {
        return formatted("%5d  %-28s %-14s %-8s %10.1f ml, middle %.0f,%.0f,%.0f%s\n", static_cast<int>(size.info.id),
            size.info.name.c_str(), size.info.material.c_str(), std::string(to_string(size.info.role)).c_str(),
            size.volume_ml, middle.x(), middle.y(), middle.z(),
            planner::is_estimated(planned_case, size.info.name) ? "  estimated" : "");
    }

    Outcome list(const planner::Case& planned_case)
    {
        planner::Patient patient(planned_case);
        const auto labels = patient.labels();
        std::vector<Vec3> sums(mesh::kLabelCount, Vec3::Zero());
        mesh::visit_voxels(*labels, [&](int i, int j, int k, Label label) { sums[label] += Vec3(i, j, k); });
        Outcome outcome;
        outcome.document["labels"] = Json::array();
        for (const planner::LabelSize& size : planner::label_sizes(*labels)) {
            const Vec3 middle
                = labels->grid.world(sums[size.info.id] / std::max(1.0, static_cast<double>(size.voxels)));
            outcome.document["labels"].push_back(
                { { "id", size.info.id }, { "name", size.info.name }, { "material", size.info.material },
                    { "role", to_string(size.info.role) }, { "volume_ml", size.volume_ml },
                    { "estimated", planner::is_estimated(planned_case, size.info.name) } });
            outcome.text += label_line(size, middle, planned_case);
        }
        return outcome;
    }

    Vec3 normal_of(const std::string& plane)
    {
        return plane == "sagittal" ? Vec3::UnitX() : plane == "coronal" ? Vec3::UnitY() : Vec3::UnitZ();
    }

    datasets::BrushStroke stroke_of(const LabelOptions& options, const mesh::ImageGrid& grid)
    {
        datasets::BrushStroke stroke { .path = {}, .radius_mm = options.radius_mm };
        for (const std::string& text : options.path) {
            stroke.path.push_back(parse_point(text, "--at"));
            const Vec3 at = grid.index(stroke.path.back());
            for (int axis = 0; axis < 3; ++axis)
                if (!(at[axis] >= -0.5 && at[axis] <= grid.size[static_cast<std::size_t>(axis)] - 0.5))
                    throw InputError("the place lies outside the image", "--at " + text);
        }
        if (options.slice)
            stroke.normal = normal_of(options.plane);
        return stroke;
    }

    mesh::LabelFlags kept_of(const planner::Case& planned_case, const LabelOptions& options)
    {
        std::vector<Label> ids;
        for (const std::string& name : options.kept)
            ids.push_back(label_of(planned_case, name, "--keep").id);
        return mesh::flagged_labels(ids);
    }

    using MakeEdit = std::function<datasets::LabelEdit(const mesh::LabelVolume&, const planner::Case&, Label)>;

    /// Makes an edit and writes the labels and the case.
    Outcome edit(const LabelOptions& options, const MakeEdit& make)
    {
        planner::Case planned_case = open_case(options.case_file);
        const Label label = label_of(planned_case, options.label, "--label").id;
        planner::Patient patient(planned_case);
        mesh::LabelVolume labels = *patient.labels();
        const datasets::LabelEdit made = make(labels, planned_case, label);
        Outcome outcome;
        outcome.document = { { "edit", made.what }, { "voxels", made.voxels.size() },
            { "volume_ml", static_cast<double>(made.voxels.size()) * labels.grid.voxel_volume() / 1000.0 } };
        if (made.empty()) {
            outcome.text = made.what + ": nothing to change\n";
            return outcome;
        }
        datasets::make_edit(labels, made);
        planned_case = planner::write_corrected_labels(std::move(planned_case), labels);
        outcome.document["labels"] = planned_case.labels.path.string();
        outcome.text = made.what
            + formatted(": %zu voxels, %.1f ml; the labels are in %s, those before stay beside them\n",
                made.voxels.size(), outcome.document["volume_ml"].get<double>(),
                planned_case.labels.path.string().c_str());
        return outcome;
    }

    Outcome join(const LabelOptions& options)
    {
        planner::Case planned_case = open_case(options.case_file);
        label_of(planned_case, options.label, "--label");
        label_of(planned_case, options.to, "--to");
        planner::Patient patient(planned_case);
        planner::LabelSession session(planned_case, patient.labels());
        session.join(options.label, options.to);
        planned_case = planner::write_corrected_labels(session.corrected(planned_case), *session.labels());
        return { .document = { { "labels", planned_case.labels.path.string() } },
            .text = options.label + " is a part of " + options.to + " now\n" };
    }

    Outcome rename(const LabelOptions& options)
    {
        planner::Case planned_case = open_case(options.case_file);
        label_of(planned_case, options.label, "--label");
        planner::Patient patient(planned_case);
        planner::LabelSession session(planned_case, patient.labels());
        session.rename(options.label, options.to);
        planned_case = planner::write_corrected_labels(session.corrected(planned_case), *session.labels());
        return { .document = { { "labels", planned_case.labels.path.string() } },
            .text = options.label + " is " + options.to + " now\n" };
    }

    Outcome add_label(const LabelOptions& options)
    {
        planner::Case planned_case = open_case(options.case_file);
        static_cast<void>(fem::find_material(planned_case.materials, options.material)); // refuses an unknown one
        planner::Patient patient(planned_case);
        planner::LabelSession session(planned_case, patient.labels());
        session.add_label(options.label, options.material, mesh::role_from_string(options.role).value());
        planned_case = planner::write_corrected_labels(session.corrected(planned_case), *session.labels());
        return { .document = { { "labels", planned_case.labels.path.string() } },
            .text = options.label + " is added; paint it\n" };
    }

    Outcome confirm(const LabelOptions& options)
    {
        planner::Case planned_case = open_case(options.case_file);
        label_of(planned_case, options.label, "--label");
        planner::confirm_label(planned_case, options.label);
        planner::write_case(planned_case);
        return { .document = { { "confirmed", options.label } },
            .text = options.label + " no longer counts as estimated\n" };
    }

    class LabelCommands {
    public:
        explicit LabelCommands(Commands& commands)
            : commands_(commands)
            , labels_(commands.app.add_subcommand("labels", "List and correct the labels of a case"))
        {
            labels_->require_subcommand(1);
        }

        void add_all()
        {
            CLI::App* list_command = add("list", "List the labels with their volumes and marks", "");
            commands_.on(
                list_command, [options = options_](const Job&) { return list(open_case(options->case_file)); });
            add_brush("paint", "Give the voxels under a brush a label",
                "--label rib_left_4 --at 80,-20,140 --at 85,-10,140 --radius 4 --slice --plane axial");
            add_brush("erase", "Take a label away under a brush; its voxels get the label beside them",
                "--label aorta --at 10,20,150 --radius 6");
            add_fill();
            add_smooth();
            CLI::App* largest = add("largest", "Keep the largest piece of a label; islands get the label around them",
                "--label rib_left_4");
            require_label(largest);
            commands_.on(largest, [options = options_](const Job&) {
                return edit(*options, [](const mesh::LabelVolume& labels, const planner::Case&, Label label) {
                    return datasets::without_islands(labels, label);
                });
            });
            add_interpolate();
            CLI::App* join_command
                = add("join", "Make one label a part of another", "--label bone_other --to rib_right_8");
            require_label(join_command);
            join_command->add_option("--to", options_->to, "The label that stays")->required();
            commands_.on(join_command, [options = options_](const Job&) { return join(*options); });
            CLI::App* add_command = add(
                "add", "Add a label without voxels, to be painted", "--label aneurysm --material vessel --role target");
            require_label(add_command);
            add_command->add_option("--material", options_->material, "Material of the case, such as bone")
                ->capture_default_str();
            add_command->add_option("--role", options_->role, "What it is to the planner")
                ->check(CLI::IsMember({ "wall", "voxel", "target", "at-risk" }))
                ->capture_default_str();
            commands_.on(add_command, [options = options_](const Job&) { return add_label(*options); });
            CLI::App* rename_command = add(
                "rename", "Give a label another name, also in the approaches", "--label rib_left_5 --to rib_left_4");
            require_label(rename_command);
            rename_command->add_option("--to", options_->to, "The new name")->required();
            commands_.on(rename_command, [options = options_](const Job&) { return rename(*options); });
            CLI::App* confirm_command
                = add("confirm", "Take the mark \"estimated\" off a label that somebody has checked", "--label aorta");
            require_label(confirm_command);
            commands_.on(confirm_command, [options = options_](const Job&) { return confirm(*options); });
        }

    private:
        CLI::App* add(const std::string& name, const std::string& help, const std::string& example)
        {
            options_ = std::make_shared<LabelOptions>();
            CLI::App* command = labels_->add_subcommand(name, help);
            command->footer(
                "Example: retractor labels " + name + " case.json" + (example.empty() ? "" : " ") + example);
            command->add_option("case", options_->case_file, "case.json")->required()->check(CLI::ExistingPath);
            return command;
        }
        void require_label(CLI::App* command)
        {
            command->add_option("--label", options_->label, "Name of the label")->required();
        }
        void add_places(CLI::App* command)
        {
            command->add_option("--at", options_->path, "Place x,y,z (mm, patient LPS); several make a way")
                ->required();
        }
        void add_plane(CLI::App* command)
        {
            command->add_option("--plane", options_->plane, "Plane of the slices: axial, coronal or sagittal")
                ->check(CLI::IsMember({ "axial", "coronal", "sagittal" }))
                ->capture_default_str();
        }
        void add_kept(CLI::App* command)
        {
            command->add_option("--keep", options_->kept, "Labels NAME,... that are not painted over")->delimiter(',');
        }
        void add_brush(const std::string& name, const std::string& help, const std::string& example)
        {
            CLI::App* command = add(name, help, example);
            require_label(command);
            add_places(command);
            command->add_option("--radius", options_->radius_mm, "Radius of the brush, mm")
                ->required()
                ->check(in_range(0.01, kLargestBrushMm));
            command->add_flag("--slice", options_->slice, "A disc in one slice in place of a ball");
            add_plane(command);
            const bool paints = name == "paint";
            if (paints)
                add_kept(command);
            commands_.on(command, [options = options_, paints](const Job&) {
                return edit(
                    *options, [&](const mesh::LabelVolume& labels, const planner::Case& planned_case, Label label) {
                        return paints ? datasets::painted(
                                   labels, stroke_of(*options, labels.grid), label, kept_of(planned_case, *options))
                                      : datasets::erased(labels, stroke_of(*options, labels.grid), label);
                    });
            });
        }
        void add_fill()
        {
            CLI::App* command = add("fill", "Give the connected region of equal labels in one slice another label",
                "--label rib_left_4 --at 80,-20,140");
            require_label(command);
            add_places(command);
            add_plane(command);
            commands_.on(command, [options = options_](const Job&) {
                if (options->path.size() != 1)
                    throw InputError("a region is filled from one place", "--at");
                return edit(*options, [&](const mesh::LabelVolume& labels, const planner::Case&, Label label) {
                    return datasets::region_filled(
                        labels, parse_point(options->path.front(), "--at"), normal_of(options->plane), label);
                });
            });
        }
        void add_smooth()
        {
            CLI::App* command
                = add("smooth", "Smooth the surface of a label", "--label aorta --voxels 2 --keep sternum");
            require_label(command);
            command->add_option("--voxels", options_->voxels, "How far to smooth, voxels")
                ->check(CLI::Range(1, kLargestRadius))
                ->capture_default_str();
            add_kept(command);
            commands_.on(command, [options = options_](const Job&) {
                return edit(
                    *options, [&](const mesh::LabelVolume& labels, const planner::Case& planned_case, Label label) {
                        return datasets::smoothed(labels, label, options->voxels, kept_of(planned_case, *options));
                    });
            });
        }
        void add_interpolate()
        {
            CLI::App* command = add("interpolate", "Fill the slices between those in which a label was drawn",
                "--label aneurysm --plane axial");
            require_label(command);
            add_plane(command);
            add_kept(command);
            commands_.on(command, [options = options_](const Job&) {
                return edit(
                    *options, [&](const mesh::LabelVolume& labels, const planner::Case& planned_case, Label label) {
                        return datasets::interpolated(labels, label,
                            datasets::nearest_axis(labels.grid, normal_of(options->plane)),
                            kept_of(planned_case, *options));
                    });
            });
        }

        Commands& commands_;
        CLI::App* labels_;
        std::shared_ptr<LabelOptions> options_;
    };

} // namespace

void add_label_commands(Commands& commands) { LabelCommands(commands).add_all(); }

} // namespace retractor::ui::cli
