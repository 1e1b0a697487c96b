#include "planner/gape.h"

#include "mesh/base/error.h"
#include "planner/wall_tension.h"

#include <algorithm>
#include <utility>

namespace retractor {

namespace {

    /// An opening that came to rest with elements inside out says so of the rest alone.
    std::string why_unusable(const OpeningResult& opening)
    {
        return opening.status == OpeningStatus::inverted
            ? std::to_string(opening.inverted_elements) + " elements turned inside out"
            : opening.message;
    }

    /// On the wall's vertices. @throws as Opening does.
    OpeningResult open_without_hooks(
        const PlannedField& field, const OpenedWound& wound, const SolutionChoice& choice, const Job& job)
    {
        const bool local = field.metrics.local.has_value();
        ElasticProblem problem = local ? wound.part.problem : field.problem;
        problem.hooks.clear();
        OpeningOptions options = opening_options(choice);
        options.contact = wound.contact;
        if (choice.near_mm > 0.0)
            options.near = near_elements(field, choice.near_mm);
        Opening opening(problem, options);
        OpeningResult result = opening.open({}, as_stage(job, "opening, without hooks"));
        if (local)
            result.displacement = on_the_whole(result.displacement, wound.part, field.problem.mesh);
        result.displacement.conservativeResize(field.wall.vertices.rows(), 3); // without midpoints, which come last
        return result;
    }

} // namespace

std::vector<std::pair<std::string, PreStrain>> tissues_under_tension(const ElasticProblem& problem)
{
    std::vector<std::pair<std::string, PreStrain>> tissues;
    for (const Label label : labels_met(problem.mesh)) {
        const Material& material = problem.material_of_label[label];
        const auto same = [&](const auto& other) { return other.first == material.name; };
        if (under_tension(material) && std::none_of(tissues.begin(), tissues.end(), same))
            tissues.emplace_back(material.name, material.pre_strain);
    }
    return tissues;
}

TensionMetrics measure_gape(PlannedField& field, const OpenedWound& wound, const SolutionChoice& choice, const Job& job)
{
    const Stopwatch watch;
    TensionMetrics tension { .tissues = tissues_under_tension(field.problem) };
    const std::vector<Vec3> no_force(field.hooks.size(), Vec3::Zero());
    try {
        WoundMeasures gape;
        if (field.hooks.empty()) {
            if (is_usable(field.opening))
                gape = measures_of(field);
            else
                tension.message = why_unusable(field.opening);
        } else {
            OpeningResult opening = open_without_hooks(field, wound, choice, job);
            if (is_usable(opening))
                gape = measures_of(field, wound.rigid, opening.displacement, no_force);
            else
                tension.message = why_unusable(opening);
        }
        tension.gape_mm = gape.width_mm;
        tension.gape_area_mm2 = gape.area_mm2;
    } catch (const Error& error) { // the plan itself is good
        tension.message = error.what();
    }
    if (job.cancelled())
        field.status = PlanStatus::cancelled;
    tension.seconds = watch.seconds();
    return tension;
}

} // namespace retractor
