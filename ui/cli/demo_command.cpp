#include "mesh/base/text_format.h"
#include "ui/cli/commands.h"
#include "ui/cli/framework/out_folder.h"
#include "ui/cli/framework/staged_results.h"
#include "ui/cli/plan/field_table.h"
#include "ui/cli/plan/saved_plans.h"
#include "ui/results/field_files.h"

#include "planner/approach/demo_patient.h"
#include "planner/plan/plan.h"

#include <CLI/CLI.hpp>

#include <memory>
#include <optional>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    /// Durations of stages outside the approaches, for the time table.
    using StageTimes = std::vector<std::pair<std::string, double>>;

    std::string time_table(const StageTimes& times, const std::vector<planner::PlannedField>& fields, double total)
    {
        std::string text = "\nseconds per stage\n";
        const auto add = [&](const std::string& name, double seconds) {
            text += formatted("  %-34s %7.2f\n", name.c_str(), seconds);
        };
        for (const auto& [stage, seconds] : times)
            add(stage, seconds);
        for (const planner::PlannedField& field : fields)
            for (const auto& [stage, seconds] : field.metrics.seconds)
                add(field.approach.name + ": " + stage, seconds);
        add("whole demo (approaches run side by side)", total);
        return text;
    }

    Outcome demo(const std::string& out, const Job& job)
    {
        const Stopwatch whole;
        const fs::path folder = out;
        make_folder(folder);
        std::optional<planner::DemoPatient> made = planner::write_demo_patient(folder / "patient", job);
        refuse_if_cancelled(job);
        const planner::Case& planned_case = made.value().planned_case;
        StageTimes times = std::move(made->seconds);
        Stopwatch watch;
        planner::Patient patient(planned_case, job);
        std::vector<planner::PlannedField> fields = plan_all(patient, job, { .find_region = true });
        refuse_if_cancelled(job);
        times.emplace_back("plan", watch.seconds());
        watch = {};
        const std::string saved = save_plans(planned_case, planned_case, fields);
        StagedResults staged(folder);
        write_field_meshes(staged.folder(), patient, fields);
        times.emplace_back("write meshes", watch.seconds());
        watch = {};
        const FieldViews request { .views = planned_case.views };
        const std::vector<planner::ReportPicture> pictures
            = render_fields(staged.folder(), patient, fields, request, job);
        refuse_if_cancelled(job);
        times.emplace_back("render", watch.seconds());
        const planner::Provenance computed = provenance_now(patient.planned_case());
        write_field_report(staged.folder() / "report.html", patient, computed, fields, pictures);

        Outcome outcome;
        outcome.document = write_metrics(staged.folder(), computed, patient, fields);
        staged.publish("metrics.json");
        Json seconds = Json::object();
        for (const auto& [stage, time] : times)
            seconds[stage] = time;
        seconds["whole"] = whole.seconds();
        outcome.document["seconds"] = seconds;
        outcome.document["report"] = (folder / "report.html").string();
        outcome.text = field_table(fields) + time_table(times, fields, whole.seconds())
            + "\nreport: " + (folder / "report.html").string() + "\n" + saved;
        outcome.exit_code = exit_code_of(fields);
        return outcome;
    }

} // namespace

void add_demo_command(Commands& commands)
{
    auto out = std::make_shared<std::string>("demo");
    CLI::App* command = commands.app.add_subcommand(
        "demo", "Plan three approaches on a phantom patient: cut, open, measure and draw them");
    command->footer("Example: retractor demo --out demo    (then open demo/report.html)");
    command->add_option("--out", *out, "Folder to write to")->capture_default_str();
    commands.on(command, [out](const Job& job) { return demo(*out, job); });
}

} // namespace retractor::ui::cli
