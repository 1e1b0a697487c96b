#include "planner/plan/gape.h"

#include "mesh/base/error.h"
#include "planner/wall/wall_tension.h"

#include <algorithm>
#include <utility>

namespace retractor::planner {

namespace {

    /// The reason why an opening gives no numbers. An inverted opening in equilibrium reports only its inverted
    /// elements.
    std::string why_unusable(const fem::OpeningResult& opening)
    {
        return opening.status == fem::OpeningStatus::inverted
            ? std::to_string(opening.inverted_elements) + " elements are inside out"
            : opening.message;
    }

    /// The field as cut and supported, without hooks and before it is opened.
    PlannedField without_hooks(const PlannedField& field)
    {
        PlannedField bare;
        bare.approach = field.approach;
        bare.approach.hooks.clear();
        bare.approach.retractor.reset();
        bare.wall = field.wall;
        bare.lips = field.lips;
        bare.problem = problem_with_fixed_hooks(field);
        bare.problem.hooks.clear();
        return bare;
    }

} // namespace

std::vector<std::pair<std::string, fem::PreStrain>> tissues_under_tension(const fem::ElasticProblem& problem)
{
    std::vector<std::pair<std::string, fem::PreStrain>> tissues;
    for (const Label label : fem::labels_met(problem.mesh)) {
        const fem::Material& material = problem.material_of_label[label];
        const auto same = [&](const auto& other) { return other.first == material.name; };
        if (under_tension(material) && std::none_of(tissues.begin(), tissues.end(), same))
            tissues.emplace_back(material.name, material.pre_strain);
    }
    return tissues;
}

TensionMetrics measure_gape(
    const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice, const Job& job)
{
    const Stopwatch watch;
    TensionMetrics tension { .tissues = tissues_under_tension(field.problem) };
    try {
        WoundMeasures gape;
        if (field.hooks.empty()) {
            if (is_usable(field.opening))
                gape = measures_of(field);
            else
                tension.message = why_unusable(field.opening);
        } else {
            PlannedField bare = without_hooks(field);
            fem::OpeningOptions options = opening_options(choice);
            options.contact = wound.contact;
            bare.opening
                = open_wall(bare, choice.near_mm, {}, options, as_stage(job, "opening, without hooks")).opening;
            if (is_usable(bare.opening))
                gape = measures_of(bare, wound.rigid, bare.opening.displacement, {});
            else
                tension.message = why_unusable(bare.opening);
        }
        tension.gape_mm = gape.width_mm;
        tension.gape_area_mm2 = gape.area_mm2;
    } catch (const Error& error) { // the plan itself is good
        tension.message = error.what();
    }
    tension.seconds = watch.seconds();
    return tension;
}

} // namespace retractor::planner
