#include "mesh/base/text_format.h"
#include "ui/cli/commands.h"
#include "ui/cli/doctor/doctor_checks.h"

#include <CLI/CLI.hpp>

#include <memory>

namespace retractor::ui::cli {

namespace {

    std::vector<Finding> all_findings(const Job& job)
    {
        std::vector<Finding> findings;
        const auto add = [&](std::vector<Finding> more) {
            findings.insert(findings.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
            job.report("doctor", static_cast<double>(findings.size()) / 23.0); // approximate number of findings
        };
        add(check_machine());
        add(check_linear_algebra());
        add(check_images());
        add({ check_own_drawing() });
        add(check_other_drawing());
        add(check_window());
        add(check_references());
        add(check_devices());
        return findings;
    }

    Outcome report(const std::vector<Finding>& findings)
    {
        Outcome outcome;
        outcome.document["version"] = RETRACTOR_VERSION;
        bool can_run = true;
        Json checks = Json::array();
        for (const Finding& finding : findings) {
            can_run = can_run && !(finding.essential && finding.health == Health::missing);
            checks.push_back(
                { { "topic", finding.topic }, { "name", finding.name }, { "status", to_string(finding.health) },
                    { "found", finding.found }, { "advice", finding.advice }, { "essential", finding.essential } });
            outcome.text += formatted("%-8s %-8s %-22s ", to_string(finding.health).c_str(), finding.topic.c_str(),
                                finding.name.c_str())
                + finding.found + "\n";
            if (!finding.advice.empty())
                outcome.text += std::string(18, ' ') + "-> " + finding.advice + "\n";
        }
        outcome.document["can_run"] = can_run;
        outcome.document["checks"] = checks;
        outcome.text += can_run ? "\nThis machine can import, plan and render.\n"
                                : "\nThis machine cannot import, plan and render: see what is missing above.\n";
        outcome.exit_code = can_run ? 0 : 1;
        return outcome;
    }

} // namespace

void add_doctor_command(Commands& commands)
{
    auto own_drawing = std::make_shared<bool>(false);
    CLI::App* command
        = commands.app.add_subcommand("doctor", "Check this machine, and advise how to add what is missing");
    command->footer("Example: retractor doctor");
    // An option for the other program, which draws with the other kind of context.
    command->add_flag("--own-drawing", *own_drawing)->group("");
    commands.on(command, [own_drawing](const Job& job) {
        return report(*own_drawing ? std::vector { check_own_drawing() } : all_findings(job));
    });
}

} // namespace retractor::ui::cli
