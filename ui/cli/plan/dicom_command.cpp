#include "ui/cli/commands.h"

#include "datasets/dicom/objects/document_objects.h"
#include "datasets/dicom/objects/segmentation_object.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/case/patient.h"
#include "ui/cli/framework/open_case.h"
#include "ui/cli/framework/out_folder.h"
#include "ui/cli/framework/run_program.h"
#include "ui/cli/framework/staged_results.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string_view>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    struct DicomExportOptions {
        std::string case_file, plan, out, source;
        bool with_identity = false;
    };

    /// The pictures of a plan, by name.
    std::vector<fs::path> pictures_in(const fs::path& folder)
    {
        std::vector<fs::path> pictures;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder))
            if (entry.is_regular_file() && entry.path().extension() == ".png")
                pictures.push_back(entry.path());
        std::ranges::sort(pictures);
        return pictures;
    }

    fs::path chromium()
    {
        for (const char* name : { "chromium", "chromium-browser", "google-chrome" })
            if (fs::path found = program_on_path(name); !found.empty())
                return found;
        return {};
    }

    /// A path as a browser takes it.
    std::string file_url(const fs::path& path)
    {
        std::string url = "file://";
        for (const char c : fs::absolute(path).string()) {
            const auto byte = static_cast<unsigned char>(c);
            const bool plain = std::isalnum(byte) != 0 || std::string_view("/-_.~").find(c) != std::string_view::npos;
            url += plain ? std::string(1, c) : formatted("%%%02X", byte);
        }
        return url;
    }

    /// Prints the report. @returns why there is no PDF; empty: it was written
    std::string print_report(const fs::path& report, const fs::path& pdf, const Job& job)
    {
        if (!fs::exists(report))
            return "the plan has no report.html (plan with --render)";
        const fs::path browser = chromium();
        if (browser.empty())
            return "printing the report needs Chromium, which is not installed (package chromium)";
        constexpr std::chrono::minutes kLimit { 5 };
        // Its profile goes with it; run as root it works without its sandbox only, and it opens nothing but our file.
        const ProgramRun run
            = run_program({ browser.string(), "--headless=new", "--no-sandbox", "--disable-gpu",
                              "--user-data-dir=" + (pdf.parent_path() / "browser").string(), "--no-pdf-header-footer",
                              "--virtual-time-budget=30000", "--print-to-pdf=" + pdf.string(), file_url(report) },
                kLimit, {}, [&] { return job.cancelled(); });
        std::error_code ignored; // the folder is temporary
        fs::remove_all(pdf.parent_path() / "browser", ignored);
        refuse_if_cancelled(job);
        if (run.timed_out)
            return "Chromium did not print the report in time";
        if (run.exit_code != 0 || !fs::exists(pdf) || fs::file_size(pdf) == 0)
            return formatted("Chromium did not print the report (exit code %d)", run.exit_code);
        return {};
    }

    /// Refuses a plan of another case, or of other labels.
    void check_plan_of(const fs::path& plan, const planner::Case& planned_case)
    {
        std::ifstream in(plan / "metrics.json");
        const Json metrics = in ? Json::parse(in, nullptr, false) : Json();
        const Json computed = metrics.is_object() ? metrics.value("computed", Json::object()) : Json();
        if (!computed.is_object() || !computed.contains("labels"))
            throw InputError("the folder holds no plan (no metrics.json)", "--plan " + plan.string());
        if (computed["labels"].value("sha256", std::string()) != planned_case.labels.sha256)
            throw InputError("the plan is of other labels than those of this case", "--plan " + plan.string());
    }

    /// The patient and study to write under. No message names the patient.
    datasets::DicomStudy study_for(const DicomExportOptions& options, const planner::Case& planned_case)
    {
        if (options.with_identity == options.source.empty())
            throw InputError(options.with_identity
                    ? "the identity is copied from the source series: give its folder with --source"
                    : "a source series is used with --with-identity only: pseudonyms take nothing from it",
                options.with_identity ? "--with-identity" : "--source");
        if (!options.with_identity)
            return datasets::pseudonymous_study();
        datasets::DicomStudy study = datasets::study_of_series(options.source);
        if (planned_case.patient
            && (planned_case.patient->name != study.patient_name || planned_case.patient->id != study.patient_id))
            throw InputError("the series is of another patient than the case", "--source " + options.source);
        return study;
    }

    /// Refuses a source series that does not show the place of the labels.
    void check_place(const datasets::DicomStudy& study, const mesh::ImageGrid& grid, const std::string& source)
    {
        constexpr double kBeyondMm = 20.0; // a case may be cut out of its series, and its slices have a thickness
        const Vec3 far = Vec3(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
        for (const Vec3& index : { Vec3(Vec3::Zero()), far, Vec3(0.5 * far) }) {
            const Vec3 p = grid.world(index);
            if (((p - study.low).array() < -kBeyondMm).any() || ((p - study.high).array() > kBeyondMm).any())
                throw InputError("the series lies elsewhere than the labels of the case: it is not the series that the "
                                 "case was imported from",
                    "--source " + source);
        }
    }

    /// Refuses a folder with DICOM files of an earlier run, which may name a patient.
    void refuse_earlier_files(const fs::path& folder)
    {
        if (!fs::is_directory(folder))
            return;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder))
            if (entry.path().extension() == ".dcm")
                throw InputError("the folder holds DICOM files already: name a new one", "--out " + folder.string());
    }

    Outcome write_dicom(const DicomExportOptions& options, const Job& job)
    {
        const planner::Case planned_case = open_case(options.case_file);
        const fs::path plan = options.plan;
        check_plan_of(plan, planned_case);
        refuse_earlier_files(options.out);
        const datasets::DicomStudy study = study_for(options, planned_case);
        const std::vector<fs::path> pictures = pictures_in(plan);
        planner::Patient patient(planned_case, job);
        if (options.with_identity)
            check_place(study, patient.labels()->grid, options.source);
        const OutFolder out(options.out);
        Outcome outcome { .document = { { "files", Json::array() }, { "pseudonym", study.is_pseudonymous } },
            .text = {} };
        StagedResults staged(options.out);
        const auto wrote = [&](const std::string& name) { outcome.document["files"].push_back(name); };
        int series = datasets::kFirstResultSeries;

        job.report("labels", 0.0);
        datasets::write_segmentation(staged.folder() / "labels.dcm", *patient.labels(), planned_case.estimated_labels,
            study, datasets::new_series(series++, "Labels for incision planning"));
        wrote("labels.dcm");
        refuse_if_cancelled(job);

        const datasets::ResultSeries shown = datasets::new_series(series++, "Planned surgical fields, pictures");
        for (std::size_t n = 0; n < pictures.size(); ++n) {
            job.report("pictures", static_cast<double>(n) / static_cast<double>(pictures.size()));
            const std::string name = pictures[n].stem().string() + ".dcm";
            datasets::write_secondary_capture(staged.folder() / name, pictures[n], study, shown,
                static_cast<int>(n) + 1,
                "Planned field, not a medical device: " + readable(pictures[n].stem().string()));
            wrote(name);
            refuse_if_cancelled(job);
        }

        job.report("report", 0.0);
        const fs::path pdf = staged.folder() / "report.pdf";
        if (const std::string why = print_report(plan / "report.html", pdf, job); why.empty()) {
            datasets::write_encapsulated_pdf(staged.folder() / "report.dcm", pdf, study,
                datasets::new_series(series++, "Planned surgical fields, report"), "Planned surgical fields");
            fs::remove(pdf);
            wrote("report.dcm");
        } else {
            outcome.document["report_missing"] = why;
            outcome.text += "caution: no report as DICOM: " + why + "\n";
        }
        staged.publish("labels.dcm");
        outcome.text
            += formatted("wrote %zu DICOM files into %s, ", outcome.document["files"].size(), options.out.c_str())
            + (study.is_pseudonymous ? "under the pseudonym " + study.patient_id + "\n"
                                     : "under patient and study of the source series\n");
        return outcome;
    }

} // namespace

void add_dicom_command(Commands& commands)
{
    auto options = std::make_shared<DicomExportOptions>();
    CLI::App* command = commands.app.add_subcommand(
        "dicom", "Write a plan for the hospital's archive: pictures, report and labels as DICOM");
    command->footer("Pictures become Secondary Captures, the report an Encapsulated PDF (printed by Chromium, where it "
                    "is installed), "
                    "the labels a Segmentation. Without --with-identity no DICOM value leads to the patient; pictures "
                    "and report are taken as they are.\n"
                    "Example: retractor dicom C/case.json --plan D --out E\n"
                    "Example: retractor dicom C/case.json --plan D --out E --with-identity --source dicom/series7");
    command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    command->add_option("--plan", options->plan, "Folder that retractor plan --render has written")
        ->required()
        ->check(CLI::ExistingDirectory);
    command->add_option("--out", options->out, "Folder for the DICOM files")->required();
    command->add_flag("--with-identity", options->with_identity,
        "Copy patient, study and frame of reference from --source, so that the results are filed beside it (default: "
        "pseudonyms)");
    command
        ->add_option(
            "--source", options->source, "With --with-identity: folder of the series that the case was imported from")
        ->check(CLI::ExistingPath);
    commands.on(command, [options](const Job& job) { return write_dicom(*options, job); });
}

} // namespace retractor::ui::cli
