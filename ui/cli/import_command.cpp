#include "ui/cli/case_files.h"
#include "ui/cli/command.h"

#include "mesh/base/error.h"

#include <memory>

namespace retractor::cli {

namespace {

    struct ImportOptions {
        std::string input, labels, out;
    };

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
    command->callback(
        [&commands, options] { commands.run = [options](const Job& job) { return import_images(*options, job); }; });
}

} // namespace retractor::cli
