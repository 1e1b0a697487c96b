#include "tests/verification/cli/retraction_problem.h"

#include "datasets/io/volume_io.h"
#include "datasets/phantoms/phantom.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/hooks.h"
#include "planner/case/case_io.h"
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
        double opening_mm;
        MeasuredForces measured;
    };
    constexpr Spread kSpreads[]
        = { { "measured forces, sternotomy spread to 100 mm", "median", 100.0, kSternotomyForces },
              { "measured forces, thoracotomy spread to 50 mm", "intercostal:5", 50.0, kThoracotomyForces } };

    planner::Case chest(const fs::path& folder, bool fine, const Job& job)
    {
        constexpr double kVoxel = 3.0; // mm: smaller than the ribs' thickness and than the elements
        datasets::ThoraxParameters thorax;
        thorax.spacing_mm.setConstant(kVoxel);
        const datasets::Phantom phantom = datasets::make_thorax_phantom(thorax, job);
        planner::Case chest;
        chest.folder = folder;
        datasets::write_label_volume(folder / "labels.nrrd", phantom.labels);
        chest.labels = planner::make_reference(folder, folder / "labels.nrrd");
        chest.label_table = phantom.labels.table;
        for (const Spread& spread : kSpreads) {
            planner::ApproachRequest request;
            request.template_name = spread.approach;
            request.target.label = "aneurysm";
            request.sizing.corridor_edge_mm = fine ? 5.5 : 8.0;
            request.sizing.coarse_edge_mm = fine ? 18.0 : 22.0;
            request.sizing.region_mm = 25.0;
            request.view.eye_count = 1; // this problem does not use the view
            planner::Approach approach = planner::approach_from_template(phantom.labels, request);
            approach.hooks = planner::make_hooks(approach, "blade", spread.opening_mm);
            planner::add_approach(chest, std::move(approach));
        }
        return chest;
    }

    /// The materials of the wall: "bone 1000, cartilage 15, ... MPa".
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
        row.element = element_name(VerificationElement::p1);
        row.law = planner::to_string(chest.solution.elasticity);
        row.nodes = field.wall.vertex_count();
        row.tets = field.wall.tet_count();
        row.residual = m.residual;
        for (const auto& [stage, seconds] : m.seconds)
            row.seconds += stage == "open" ? seconds : 0.0;
        row.quantity = "force of the spreader on a side, N; error: factor outside the measured range, less 1";
        row.value = m.hook_force_N;
        row.expected = spread.measured.mean;
        const bool measured = field.status == planner::PlanStatus::done;
        row.error = measured ? outside(m.hook_force_N, spread.measured) : std::numeric_limits<double>::quiet_NaN();
        row.bound = kMostOutside;
        const std::string bars = !m.error ? std::string()
            : m.error->message.empty() ? "; +- " + std::to_string(std::lround(m.error->hook_force_N)) + " N by the mesh"
                                       : "; " + m.error->message;
        row.note = measured ? beside(m.hook_force_N, spread.measured) + bars + "; " + stiffness_text(chest)
                            : field.message + " " + m.mechanics_status;
        return row;
    }

} // namespace

double outside(double force_N, const MeasuredForces& measured)
{
    if (!(force_N > 0.0))
        return std::numeric_limits<double>::quiet_NaN();
    if (force_N < measured.least)
        return measured.least / force_N - 1.0;
    return force_N > measured.most ? force_N / measured.most - 1.0 : 0.0;
}

std::string beside(double force_N, const MeasuredForces& measured)
{
    std::array<char, 96> place {};
    if (force_N < measured.least)
        (void)std::snprintf(
            place.data(), place.size(), "BELOW: the smallest measured is %.2f times that", measured.least / force_N);
    else if (force_N > measured.most)
        (void)std::snprintf(
            place.data(), place.size(), "ABOVE: %.2f times the largest measured", force_N / measured.most);
    else
        (void)std::snprintf(place.data(), place.size(), "within what was measured");
    std::array<char, 256> text {};
    (void)std::snprintf(text.data(), text.size(),
        "%.0f N, %s; measured %.0f to %.0f N (%s); passes up to a factor of %.0f outside, %.0f to %.0f N", force_N,
        place.data(), measured.least, measured.most, measured.source, 1.0 + kMostOutside,
        measured.least / (1.0 + kMostOutside), measured.most * (1.0 + kMostOutside));
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
            const std::vector<planner::PlannedField> fields = planner::plan_all(patient, job);
            for (std::size_t i = 0; i < fields.size() && !job.cancelled(); ++i)
                rows.push_back(row_of(kSpreads[i], fields[i], patient.planned_case()));
            return rows;
        } };
}

} // namespace retractor::verification
