#include "planner/session/tissue_choice.h"

#include "mesh/base/error.h"

namespace retractor::planner {

const std::vector<std::string>& tissue_models()
{
    static const std::vector<std::string> models { "fem", "springs", "spheres" };
    return models;
}

Label surface_label(const datasets::PalpationScene& scene, std::size_t organ, const haptics::TissueResponse& tissue)
{
    return tissue.name() == "spheres" ? static_cast<Label>(organ + 1) : scene.organs[organ].label;
}

haptics::PulsePressure pulse_of(const datasets::PalpationScene& scene, const TissueChoice& choice)
{
    if (!choice.pressure_csv.empty())
        return haptics::PulsePressure::read_csv(choice.pressure_csv, choice.heart_rate_per_min);
    return haptics::PulsePressure::aortic(
        choice.heart_rate_per_min > 0.0 ? choice.heart_rate_per_min : scene.heart_rate_per_min, scene.diastolic_mmHg,
        scene.systolic_mmHg);
}

haptics::CondensedOptions condensed_options(const datasets::PalpationScene& scene, const TissueChoice& choice)
{
    haptics::CondensedOptions options;
    options.element = choice.element == "p1" ? haptics::TouchElement::p1
        : choice.element == "locking-free"   ? haptics::TouchElement::locking_free
                                             : haptics::TouchElement::p2;
    options.fingertip = choice.fingertip == "sphere" ? haptics::FingertipShape::sphere
        : choice.fingertip == "held"                 ? haptics::FingertipShape::held
                                                     : haptics::FingertipShape::pad;
    options.fingers = choice.fingers;
    options.force_gain = choice.force_gain;
    options.rest_pressure = scene.rest_mmHg * haptics::kMPaPerMmHg;
    return options;
}

ChosenTissue make_tissue(const datasets::PalpationScene& scene, const TissueChoice& choice, const Job& job)
{
    if (choice.model == "fem")
        return { std::make_unique<haptics::CondensedTissue>(
                     scene.body, pulse_of(scene, choice), condensed_options(scene, choice), job),
            {} };
    if (choice.model == "springs")
        return make_springs(scene, choice, job);
    if (choice.model == "spheres")
        return make_spheres(scene, choice, job);
    throw InputError("there is no model \"" + choice.model + '"', "model", { "model" });
}

} // namespace retractor::planner
