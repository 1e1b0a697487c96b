#include "ui/cli/commands.h"
#include "ui/cli/framework/command.h"

namespace {

void add_commands(retractor::ui::cli::Commands& commands)
{
    using namespace retractor::ui::cli;
    commands.require_one();
    add_demo_command(commands);
    add_phantom_command(commands);
    add_import_command(commands);
    add_label_commands(commands);
    add_approach_commands(commands);
    add_hooks_command(commands);
    add_tension_command(commands);
    add_vessel_command(commands);
    add_mesh_command(commands);
    add_cut_command(commands);
    add_plan_command(commands);
    add_render_command(commands);
    add_compare_command(commands);
    add_search_command(commands);
    add_ports_command(commands);
    add_batch_command(commands);
    add_sensitivity_command(commands);
    add_decision_commands(commands);
    add_dicom_command(commands);
    add_palpable_command(commands);
    add_palpate_command(commands);
    add_relay_command(commands);
    add_train_command(commands);
    add_evidence_commands(commands);
    add_doctor_command(commands);
}

} // namespace

int main(int argc, char** argv)
{
    return retractor::ui::cli::run_command_line(
        { "retractor", "Retractor plans surgical incisions: cut, open, look, compare. Not a medical device.",
            add_commands },
        argc, argv);
}
