#include "ui/cli/case/case_files.h"
#include "ui/cli/commands.h"
#include "ui/cli/framework/number_range.h"
#include "ui/cli/framework/out_folder.h"

#include "datasets/dicom/study_search.h"
#include "datasets/io/archive.h"
#include "datasets/labels/label_presets.h"
#include "mesh/base/error.h"
#include "planner/case/case_io.h"
#include "planner/case/import_case.h"
#include "ui/plan_scene/contact_sheet.h"
#include "ui/scene/vtk/render.h"

#include <CLI/CLI.hpp>

#include <memory>
#include <optional>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    struct ImportOptions {
        std::string input, preset, series, out;
        std::vector<std::string> labels;
        double spacing_mm = datasets::AutosegmentOptions {}.spacing_mm;
        bool autosegment = false, repair_labels = false, keep_tilt = false, with_identity = false;
        bool list_series = false, contact_sheet = true, replace = false, accept_implausible = false,
             accept_labels = false;
    };

    planner::ImportRequest request_of(const ImportOptions& options)
    {
        planner::ImportRequest request;
        request.ct = options.input;
        request.labels.assign(options.labels.begin(), options.labels.end());
        request.preset = options.preset;
        request.series = options.series;
        request.rectify_tilt = !options.keep_tilt;
        request.repair_labels = options.repair_labels;
        request.autosegment = options.autosegment;
        request.autosegment_spacing_mm = options.spacing_mm;
        request.with_identity = options.with_identity;
        request.accept_implausible = options.accept_implausible;
        request.accept_labels = options.accept_labels;
        return request;
    }

    ContactSheetOptions sheet_options(const planner::ImportedCase& imported)
    {
        ContactSheetOptions sheet;
        sheet.warnings = imported.warnings;
        for (const datasets::FoundStructure& structure : imported.structures)
            if (structure.rough) {
                sheet.rough.insert(structure.name);
                sheet.notes.push_back("rough: " + structure.name + ": " + structure.how);
            }
        for (const datasets::LabelFragments& f : imported.fragments)
            // Smaller specks are only in the printed list.
            if (f.stray_voxels > f.voxels / 50 || f.hole_voxels > f.voxels / 50)
                sheet.notes.push_back(f.name + ": " + std::to_string(f.pieces) + " pieces, "
                    + std::to_string(f.stray_voxels) + " of " + std::to_string(f.voxels)
                    + " voxels outside the largest piece, " + std::to_string(f.hole_voxels) + " in holes");
        for (const datasets::LabelFragments& f : imported.repaired)
            sheet.notes.push_back("repaired: " + f.name + ": " + std::to_string(f.stray_voxels)
                + " stray voxels removed, " + std::to_string(f.hole_voxels) + " voxels of holes filled");
        sheet.notes.insert(sheet.notes.end(), imported.notes.begin(), imported.notes.end());
        return sheet;
    }

    Image draw_contact_sheet(const planner::ImportedCase& imported, const Job& job)
    {
        job.report("contact sheet", 0.0);
        OffscreenRenderer renderer(make_offscreen_context(), job);
        return renderer.render(contact_sheet(imported.ct, imported.labels, sheet_options(imported), job));
    }

    /// Refuses to replace planned approaches without an explicit option, because approaches are work. The check comes
    /// before the long reading.
    void refuse_to_replace_approaches(const fs::path& case_file)
    {
        std::error_code error;
        if (!fs::exists(case_file, error))
            return;
        std::size_t approaches = 0;
        try {
            approaches = planner::read_case(case_file, { .verify_checksums = false }).approaches.size();
        } catch (const Error&) {
            if (case_file.filename() == planner::kCaseFileName)
                return; // an unreadable file is reported when it is replaced
            throw InputError(
                "this file exists and is not a case: name another file, or add --replace", case_file.string());
        }
        if (approaches > 0)
            throw InputError("the existing case has " + std::to_string(approaches)
                    + " planned approach(es), which would be lost: write to another folder, or add --replace",
                case_file.string());
    }

    /// A line about the case that is replaced, with its number of approaches; nothing when there is no file.
    std::optional<std::string> replaced_case(const fs::path& case_file)
    {
        std::error_code error;
        if (!fs::exists(case_file, error))
            return std::nullopt;
        try {
            const planner::Case old = planner::read_case(case_file, { .verify_checksums = false });
            return "replaced the existing case with its " + std::to_string(old.approaches.size())
                + " approach(es); old images that differ are kept beside the new images";
        } catch (const Error&) {
            return "replaced the " + case_file.filename().string() + ", which could not be read";
        }
    }

    /// The images of an archive, or of a folder with its subfolders.
    struct Images {
        std::unique_ptr<const datasets::UnpackedArchive> unpacked; ///< null: the input is no archive
        fs::path ct;
        std::string series;
    };

    /// The series of the study with the wished UID, number, or place in the list ("#2").
    const datasets::StudySeries& wished_series(const std::vector<datasets::StudySeries>& study, const std::string& wish)
    {
        if (const std::size_t patients = datasets::patients_of(study); wish.empty() && patients > 1)
            throw InputError("holds images of " + std::to_string(patients)
                    + " patients: choose a series (--series; --list-series tells the patients apart)",
                "input");
        if (wish.empty())
            return study.front();
        const datasets::StudySeries* found = nullptr;
        for (std::size_t n = 0; n < study.size(); ++n) {
            if (wish == study[n].series.uid || wish == "#" + std::to_string(n + 1))
                return study[n];
            if (wish != study[n].series.number)
                continue;
            if (found != nullptr)
                throw InputError(
                    "several series have the number " + wish + ": choose one by its place, as in #2", "--series");
            found = &study[n];
        }
        if (found == nullptr)
            throw InputError("no series is named \"" + wish + "\"; see --list-series", "--series");
        return *found;
    }

    /// Whether a folder holds images itself, and not only in its subfolders, as a disc does.
    bool holds_series(const fs::path& folder)
    {
        try {
            return !datasets::list_dicom_series(folder).empty();
        } catch (const InputError&) {
            return false;
        }
    }

    Images images_of(const ImportOptions& options, const Job& job)
    {
        Images images { .unpacked = nullptr, .ct = options.input, .series = options.series };
        if (!fs::is_directory(images.ct)) {
            if (!datasets::is_zip_archive(images.ct))
                return images;
            images.unpacked = std::make_unique<const datasets::UnpackedArchive>(images.ct, job);
            images.ct = images.unpacked->folder();
        }
        if (options.series.empty() && holds_series(images.ct))
            return images;
        const std::vector<datasets::StudySeries> study = datasets::find_study_series(images.ct, job);
        refuse_if_cancelled(job);
        const datasets::StudySeries& chosen = wished_series(study, options.series);
        images.ct = chosen.path;
        images.series = chosen.series.uid;
        return images;
    }

    Outcome list_series(const ImportOptions& options, const Job& job)
    {
        if (!options.labels.empty() || options.autosegment || !options.out.empty())
            throw InputError("only lists the series of a folder: omit the other options", "--list-series");
        std::unique_ptr<const datasets::UnpackedArchive> unpacked;
        fs::path folder = options.input;
        if (!fs::is_directory(folder)) {
            if (!datasets::is_zip_archive(folder))
                throw InputError("is neither a folder of DICOM files nor a ZIP archive", options.input);
            unpacked = std::make_unique<const datasets::UnpackedArchive>(folder, job);
            folder = unpacked->folder();
        }
        const std::vector<datasets::StudySeries> study = datasets::find_study_series(folder, job);
        refuse_if_cancelled(job);
        std::vector<datasets::DicomSeries> series;
        const std::size_t patients = datasets::patients_of(study);
        for (const datasets::StudySeries& found : study) {
            series.push_back(found.series);
            if (patients > 1)
                series.back().description
                    = "patient " + std::to_string(found.patient) + ": " + found.series.description;
        }
        Outcome outcome;
        outcome.document["series"] = series_document(series);
        outcome.document["patients"] = patients;
        for (std::size_t n = 0; n < study.size(); ++n) {
            outcome.document["series"][n]["patient"] = study[n].patient;
            outcome.document["series"][n]["description"] = study[n].series.description;
        }
        outcome.text = series_text(series);
        if (patients > 1)
            outcome.text += "These are series of " + std::to_string(patients) + " patients.\n";
        return outcome;
    }

    void check_out(const ImportOptions& options)
    {
        if (options.out.empty())
            throw InputError("is missing: name the case file to write, e.g. patient/case.json", "--out");
        planner::check_case_file_name(options.out);
        // A plan or a cut writes these files into the case's folder, and would overwrite a case file of this name.
        for (const char* written : { "metrics.json", "report.json" })
            if (fs::path(options.out).filename() == written)
                throw InputError("the case file must not be named " + std::string(written)
                        + ", because plan or cut writes a file of this name",
                    options.out);
    }

    Outcome import_images(const ImportOptions& options, const Job& job)
    {
        if (options.list_series)
            return list_series(options, job);
        check_out(options);
        const fs::path case_file = options.out;
        if (!options.replace)
            refuse_to_replace_approaches(case_file);
        const Images images = images_of(options, job);
        planner::ImportRequest request = request_of(options);
        request.ct = images.ct;
        request.series = images.series;
        planner::ImportedCase imported = planner::read_import(request, job);
        refuse_if_cancelled(job);
        if (const auto warning = planner::identity_warning(options.input, case_file))
            imported.warnings.push_back(*warning);
        std::optional<Image> sheet;
        if (options.contact_sheet)
            sheet = draw_contact_sheet(imported, job);
        refuse_if_cancelled(job);

        // Everything is known from here on. The remaining work is short and must not be interrupted.
        if (const auto replaced = replaced_case(case_file))
            imported.notes.push_back(*replaced);
        job.report("write case", 0.0);
        planner::write_import(imported, case_file);
        Outcome outcome;
        outcome.document["case"] = options.out;
        outcome.document.update(import_document(imported));
        outcome.text = import_text(imported);
        if (sheet) {
            const fs::path file = case_file.parent_path() / "contact_sheet.png";
            write_png(file, *sheet);
            outcome.document["contact_sheet"] = file.string();
            outcome.text += "contact sheet: " + file.string() + "\n";
        }
        outcome.text += "case: " + options.out + "\n";
        return outcome;
    }

    std::string preset_help()
    {
        std::string text = "Names and roles of the labels of another tool:";
        for (const std::string& name : datasets::label_preset_names())
            text += " " + name;
        return text;
    }

} // namespace

void add_import_command(Commands& commands)
{
    auto options = std::make_shared<ImportOptions>();
    CLI::App* command = commands.app.add_subcommand("import",
        "Make a case from a CT (DICOM folder, disc or ZIP archive, NIfTI, NRRD, MetaImage, VTI) and its labels, or "
        "find "
        "the labels in the CT");
    command->footer("Example: retractor import patient/ct --labels patient/labels.nrrd --out patient/case.json\n"
                    "         retractor import patient/ct --autosegment --out patient/case.json");
    command
        ->add_option(
            "input", options->input, "DICOM folder or disc (subfolders are searched), ZIP archive, or an image file")
        ->required()
        ->check(CLI::ExistingPath);
    command
        ->add_option("--labels", options->labels,
            "Label map (with its table <stem>.labels.json beside it), .seg.nrrd, DICOM SEG or RTSTRUCT, or a folder of "
            "masks. Repeat the "
            "option to correct earlier labels with later labels")
        ->check(CLI::ExistingPath)
        ->allow_extra_args(false);
    command->add_option("--preset", options->preset, preset_help())
        ->check(CLI::IsMember(datasets::label_preset_names()));
    command->add_flag("--autosegment", options->autosegment,
        "Find bones, lungs, heart, vessels and the layers of the wall in a chest CT; labels from --labels take "
        "precedence");
    command->add_option("--spacing", options->spacing_mm, "Voxel spacing of the labels that --autosegment finds, mm")
        ->capture_default_str()
        ->check(in_range(0.5, 4.0))
        ->needs("--autosegment");
    command->add_flag("--repair-labels", options->repair_labels,
        "Keep the largest piece of each given label and fill its holes; without this option, pieces and holes are only "
        "reported");
    command->add_option("--series", options->series,
        "Series of the folder: its UID, its number, or #2 for the second in --list-series");
    command->add_flag("--list-series", options->list_series, "List the series of a DICOM folder and do nothing else");
    command->add_flag("--no-rectify-tilt", options->keep_tilt, "Refuse a tilted gantry instead of straightening it");
    command->add_flag("--with-identity", options->with_identity,
        "Keep the patient's name and id from the DICOM files in case.json (by default, they are not stored)");
    command->add_flag("--accept-implausible", options->accept_implausible,
        "Import an image whose size is no patient's, and let the case hold numbers that no tissue and no operation "
        "has; each is recorded in metrics.json. Without this option, such input is refused as a slip of units");
    command->add_flag("--accept-labels", options->accept_labels,
        "Import labels of which most lie outside the CT, or do not show what the CT shows. Without this option they "
        "are refused as another patient's");
    command->add_flag(
        "!--no-contact-sheet", options->contact_sheet, "Do not draw the picture of the images beside the case file");
    command->add_option("--out", options->out,
        "Case file to write, e.g. patient/case.json; the images are written beside the case file");
    command->add_flag("--replace", options->replace,
        "Replace a case that has planned approaches, or a file of another name that is not a case; without this "
        "option, such files are kept (exit code 2)");
    commands.on(command, [options](const Job& job) { return import_images(*options, job); });
}

} // namespace retractor::ui::cli
