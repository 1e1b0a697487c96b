#include "planner/session/tissue_choice.h"

#include "mesh/base/error.h"

#include <algorithm>

namespace retractor {

const std::vector<std::string>& tissue_models()
{
    static const std::vector<std::string> models { "fem", "springs", "spheres" };
    return models;
}

Label surface_label(const PalpationScene& scene, std::size_t organ, const TissueResponse& tissue)
{
    return tissue.name() == "spheres" ? static_cast<Label>(organ + 1) : scene.organs[organ].label;
}

PulsePressure pulse_of(const PalpationScene& scene, const TissueChoice& choice)
{
    if (!choice.pressure_csv.empty())
        return PulsePressure::read_csv(choice.pressure_csv, choice.heart_rate_per_min);
    return PulsePressure::aortic(choice.heart_rate_per_min > 0.0 ? choice.heart_rate_per_min : scene.heart_rate_per_min,
        scene.diastolic_mmHg, scene.systolic_mmHg);
}

CondensedOptions condensed_options(const PalpationScene& scene, const TissueChoice& choice)
{
    CondensedOptions options;
    options.element = choice.element == "p1" ? TouchElement::p1
        : choice.element == "locking-free"   ? TouchElement::locking_free
                                             : TouchElement::p2;
    options.fingertip = choice.fingertip == "sphere" ? FingertipShape::sphere
        : choice.fingertip == "held"                 ? FingertipShape::held
                                                     : FingertipShape::pad;
    options.fingers = choice.fingers;
    options.force_gain = choice.force_gain;
    options.rest_pressure = scene.rest_mmHg * kMPaPerMmHg;
    return options;
}

ChosenTissue make_tissue(const PalpationScene& scene, const TissueChoice& choice, const Job& job)
{
    if (choice.model == "fem")
        return { std::make_unique<CondensedTissue>(
                     scene.body, pulse_of(scene, choice), condensed_options(scene, choice), job),
            {} };
    if (choice.model == "springs")
        return make_springs(scene, choice, job);
    if (choice.model == "spheres")
        return make_spheres(scene, choice, job);
    throw InputError("there is no model \"" + choice.model + '"', "model", { "model" });
}

} // namespace retractor
