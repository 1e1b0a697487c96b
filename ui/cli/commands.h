#pragma once
// The commands of `retractor`. Each function adds a command, or commands that belong together.

#include "ui/cli/framework/command.h"

namespace retractor::ui::cli {

void add_phantom_command(Commands& commands);
void add_import_command(Commands& commands);
/// Adds `labels`: lists and corrects labels.
void add_label_commands(Commands& commands);
void add_approach_commands(Commands& commands);
void add_hooks_command(Commands& commands);
void add_tension_command(Commands& commands);
/// Adds `vessels`: lists and sets vessels whose places are assumed.
void add_vessel_command(Commands& commands);
void add_mesh_command(Commands& commands);
void add_cut_command(Commands& commands);
void add_plan_command(Commands& commands);
void add_render_command(Commands& commands);
/// Compares saved plans.
void add_compare_command(Commands& commands);
/// Searches for incisions.
void add_search_command(Commands& commands);
/// Proposes ports.
void add_ports_command(Commands& commands);
/// Plans many approaches.
void add_batch_command(Commands& commands);
/// Plans a case with many values of tissue stiffness.
void add_sensitivity_command(Commands& commands);
/// Writes a plan as DICOM.
void add_dicom_command(Commands& commands);
/// Adds `choose` and `questionnaire`: what a team decided.
void add_decision_commands(Commands& commands);
void add_demo_command(Commands& commands);
/// Makes a scene for `palpate` from a patient's case.
void add_palpable_command(Commands& commands);
void add_palpate_command(Commands& commands);
/// Serves a device on another computer to `palpate --device udp:...`.
void add_relay_command(Commands& commands);
/// Adds `train`: elasticity trials and their statistics.
void add_train_command(Commands& commands);
/// Adds `evidence`: what happened to earlier patients.
void add_evidence_commands(Commands& commands);
void add_doctor_command(Commands& commands);

} // namespace retractor::ui::cli
