#include "ui/cli/case_files.h"
#include "ui/cli/command.h"

#include "mesh/base/error.h"
#include "planner/patient.h"
#include "ui/plan_scene/contact_sheet.h"
#include "ui/scene/render.h"

#include <memory>

namespace retractor::cli {

namespace {

    struct ImportOptions {
        std::string input, labels, out;
        bool contact_sheet = true;
    };

    /// Beside the case file: what was read, for a reader to judge before anything is planned on it.
    std::filesystem::path draw_contact_sheet(const Case& planned_case, const Job& job)
    {
        Patient patient(planned_case, job);
        OffscreenRenderer renderer(make_offscreen_context(), job);
        const std::filesystem::path file = planned_case.folder / "contact_sheet.png";
        write_png(file, renderer.render(contact_sheet(patient.ct(), patient.labels(), {}, job)));
        return file;
    }

    Outcome import_images(const ImportOptions& options, const Job& job)
    {
        if (std::filesystem::path(options.out).filename() != "case.json")
            throw InputError("the case file must be named case.json", "--out");
        const Case planned_case = make_case(options.input, options.labels, options.out, job);
        Outcome outcome;
        outcome.document["case"] = options.out;
        outcome.document["frame"] = "LPS";
        Json table = Json::array();
        outcome.text = options.out + ": " + std::to_string(planned_case.label_table.size()) + " labels\n";
        for (const LabelInfo& info : planned_case.label_table) {
            table.push_back({ { "id", info.id }, { "name", info.name }, { "material", info.material },
                { "role", to_string(info.role) } });
            outcome.text += "  " + info.name + " (" + info.material + ", " + std::string(to_string(info.role)) + ")\n";
        }
        outcome.document["labels"] = table;
        if (options.contact_sheet) {
            const std::string file = draw_contact_sheet(planned_case, job).string();
            outcome.document["contact_sheet"] = file;
            outcome.text += "contact sheet: " + file + "\n";
        }
        return outcome;
    }

} // namespace

void add_import_command(Commands& commands)
{
    auto options = std::make_shared<ImportOptions>();
    CLI::App* command = commands.app.add_subcommand(
        "import", "Make a case from a CT (DICOM folder, NIfTI, NRRD, MetaImage) and its labels");
    command->footer("Example: retractor import patient/ct --labels patient/labels.nrrd --out patient/case.json");
    command->add_option("input", options->input, "DICOM folder or image file")->required()->check(CLI::ExistingPath);
    command->add_option("--labels", options->labels, "Label map with its table <stem>.labels.json beside it")
        ->required()
        ->check(CLI::ExistingPath);
    command->add_option("--out", options->out, "The case file to write, named case.json")->required();
    command->add_flag(
        "!--no-contact-sheet", options->contact_sheet, "Draw no picture of the images beside the case file");
    command->callback(
        [&commands, options] { commands.run = [options](const Job& job) { return import_images(*options, job); }; });
}

} // namespace retractor::cli
