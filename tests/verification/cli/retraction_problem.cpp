#include "tests/verification/cli/retraction_problem.h"

#include "datasets/io/volume_io.h"
#include "datasets/phantoms/phantom.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/retractors.h"
#include "planner/case/case_io.h"
#include "planner/measures/force_moments.h"
#include "planner/measures/metrics.h"
#include "planner/measures/volume_failures.h"
#include "planner/plan/plan.h"
#include "tests/support/temporary_folder.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <set>
#include <string>

namespace retractor::verification {

namespace {

    namespace fs = std::filesystem;

    struct Spread {
        const char* problem;
        const char* approach; ///< name of the approach's template
        const char* name; ///< name of the approach
        planner::DivisionExtent division;
        const char* retractor; ///< of planner::built_in_retractors()
        double opening_mm;
        MeasuredForces measured;
    };
    constexpr Spread kSpreads[] = {
        { "measured forces, sternotomy spread to 100 mm", "median", "median", planner::DivisionExtent::skin, "sternal",
            100.0, kSternotomyForces },
        { "measured forces, thoracotomy spread to 50 mm", "intercostal:5", "skin", planner::DivisionExtent::skin,
            "finochietto", 50.0, kThoracotomyForces },
        { "measured forces, thoracotomy spread to 50 mm, divided beyond the skin", "intercostal:5", "full",
            planner::DivisionExtent::full, "finochietto", 50.0, kThoracotomyForces },
    };

    planner::Case chest(const fs::path& folder, bool fine, const Job& job)
    {
        constexpr double kVoxel = 3.0; // mm: smaller than the ribs' thickness and than the elements
        datasets::ThoraxParameters thorax;
        thorax.spacing_mm.setConstant(kVoxel);
        const datasets::Phantom phantom = datasets::make_thorax_phantom(thorax, job);
        planner::Case chest;
        chest.folder = folder;
        chest.solution.element = planner::ElementKind::mixed; // as new cases have it
        datasets::write_label_volume(folder / "labels.nrrd", phantom.labels);
        chest.labels = planner::make_reference(folder, folder / "labels.nrrd");
        chest.label_table = phantom.labels.table;
        chest.contact = planner::ContactMode::never; // with organs; blades are in contact
        for (const Spread& spread : kSpreads) {
            planner::ApproachRequest request;
            request.template_name = spread.approach;
            request.name = spread.name;
            request.division = spread.division;
            request.target.label = "aneurysm";
            request.sizing.corridor_edge_mm = fine ? 12.0 : 16.0;
            request.sizing.coarse_edge_mm = fine ? 24.0 : 30.0;
            request.view.eye_count = 1; // this problem does not use the view
            planner::Approach approach = planner::approach_from_template(phantom.labels, request);
            planner::add_approach(chest, std::move(approach));
            planner::set_retractor(chest, spread.name,
                planner::find_retractor(planner::built_in_retractors(), spread.retractor),
                { .opening_mm = spread.opening_mm });
        }
        return chest;
    }

    /// The materials of the wall: "bone 4000, cartilage 28.5, ... MPa".
    std::string stiffness_text(const planner::Case& chest)
    {
        std::set<std::string> names;
        for (const mesh::LabelInfo& info : chest.label_table)
            if (info.role == mesh::Role::wall)
                names.insert(info.material);
        std::string text;
        for (const std::string& name : names) {
            std::array<char, 64> one {};
            (void)std::snprintf(one.data(), one.size(), "%s%s %g", text.empty() ? "" : ", ", name.c_str(),
                fem::find_material(chest.materials, name).youngs_modulus_MPa);
            text += one.data();
        }
        return text + " MPa";
    }

    VerificationRow row_of(const Spread& spread, const planner::PlannedField& field, const planner::Case& chest)
    {
        const planner::FieldMetrics& m = field.metrics;
        VerificationRow row;
        row.problem = spread.problem;
        row.element = planner::to_string(chest.solution.element);
        row.law = planner::to_string(chest.solution.elasticity);
        row.nodes = field.wall.vertex_count();
        row.tets = field.wall.tet_count();
        row.residual = m.residual;
        for (const auto& [stage, seconds] : m.seconds)
            row.seconds += stage == "open" ? seconds : 0.0;
        row.quantity = "force of the spreader on a side, N; beside the measured range";
        row.value = m.hook_force_N;
        row.expected = spread.measured.mean;
        const bool opened = field.status == planner::PlanStatus::done && m.hook_force_N > 0.0;
        row.error = opened ? 0.0 : std::numeric_limits<double>::quiet_NaN();
        const bool has_bar = m.error && m.error->message.empty();
        const double bar = has_bar ? m.error->hook_force_N : std::numeric_limits<double>::infinity();
        row.measured = { spread.measured.least, spread.measured.most, bar };
        const std::string failed = planner::volume_failure_text(m);
        row.note = opened ? beside(m.hook_force_N, bar, spread.measured)
                + (m.error && !has_bar ? "; " + m.error->message : std::string())
                + (m.division ? "; divided beyond the skin incision, " + planner::division_cell(m)
                              : std::string("; divided along the skin incision only"))
                + "; " + planner::force_moments_text(m) + "; " + planner::retractor_text(m) + "; "
                + stiffness_text(chest) + (failed.empty() ? "" : "; " + failed)
                          : field.message + " " + m.mechanics_status;
        return row;
    }

} // namespace

std::string beside(double force_N, double bar_N, const MeasuredForces& measured)
{
    std::array<char, 64> bar {};
    if (std::isfinite(bar_N))
        (void)std::snprintf(bar.data(), bar.size(), " +- %.0f", bar_N);
    else
        (void)std::snprintf(bar.data(), bar.size(), " (without a bar)");
    std::array<char, 256> text {};
    (void)std::snprintf(text.data(), text.size(), "%.0f%s N; measured %.0f to %.0f N (%s)", force_N, bar.data(),
        measured.least, measured.most, measured.source);
    return text.data();
}

VerificationProblem retraction_problem()
{
    return { "measured forces",
        "a chest held open by a rib spreader: the force beside what was measured on bodies; tissue here is elastic, "
        "and does not yield to spreading after spreading as theirs did",
        [](const VerificationOptions& options, const Job& job) {
            std::vector<VerificationRow> rows;
            if (job.cancelled())
                return rows;
            const test_support::TemporaryFolder folder; // for the labels, which are read from files like a patient's
            planner::Patient patient(chest(folder.path, options.fine, job), job);
            const std::vector<planner::PlannedField> fields = planner::plan_all(patient, job, { .find_region = true });
            for (std::size_t i = 0; i < fields.size() && !job.cancelled(); ++i)
                rows.push_back(row_of(kSpreads[i], fields[i], patient.planned_case()));
            return rows;
        } };
}

} // namespace retractor::verification
