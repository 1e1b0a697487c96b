#include "planner/case/solver_settings.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr std::array<std::pair<fem::Elasticity, std::string_view>, 3> kElasticities { {
        { fem::Elasticity::linear, "linear" },
        { fem::Elasticity::corotational, "corotational" },
        { fem::Elasticity::hyperelastic, "hyperelastic" },
    } };
    constexpr std::array<std::pair<ElementKind, std::string_view>, 4> kElements { {
        { ElementKind::p1, "p1" },
        { ElementKind::locking_free, "locking-free" },
        { ElementKind::p2, "p2" },
        { ElementKind::mixed, "mixed" },
    } };
    constexpr std::array<std::pair<ContactMode, std::string_view>, 3> kContactModes { {
        { ContactMode::automatic, "auto" },
        { ContactMode::always, "on" },
        { ContactMode::never, "off" },
    } };

    template <class Value, class Names> std::string_view name_of(const Names& names, Value value)
    {
        for (const auto& [known, name] : names)
            if (known == value)
                return name;
        return {};
    }

    template <class Value, class Names> std::optional<Value> value_of(const Names& names, std::string_view text)
    {
        for (const auto& [known, name] : names)
            if (name == text)
                return known;
        return std::nullopt;
    }

} // namespace

std::string_view to_string(fem::Elasticity elasticity) { return name_of(kElasticities, elasticity); }
std::string_view to_string(ElementKind element) { return name_of(kElements, element); }
std::string_view to_string(ContactMode contact) { return name_of(kContactModes, contact); }

std::optional<fem::Elasticity> elasticity_from_string(std::string_view text)
{
    return value_of<fem::Elasticity>(kElasticities, text);
}

std::optional<ElementKind> element_from_string(std::string_view text) { return value_of<ElementKind>(kElements, text); }

std::optional<ContactMode> contact_mode_from_string(std::string_view text)
{
    return value_of<ContactMode>(kContactModes, text);
}

double largest_poissons_ratio(ElementKind element)
{
    constexpr double kFourNodes = 0.45, kAny = 0.5;
    return element == ElementKind::p1 || element == ElementKind::mixed ? kFourNodes : kAny;
}

fem::Material as_solved(fem::Material material, ElementKind element)
{
    // Above this ratio four-node elements lock and fold.
    material.poissons_ratio = std::min(material.poissons_ratio, largest_poissons_ratio(element));
    return material;
}

std::string solution_text(const SolverSettings& choice)
{
    std::string text(to_string(choice.elasticity));
    if (choice.near_mm > 0.0) {
        text += formatted(" within %g mm of the lips, linear beyond", choice.near_mm);
    }
    switch (choice.element) {
    case ElementKind::p1:
        return text + "; four-node elements, Poisson's ratios at most 0.45";
    case ElementKind::locking_free:
        return text + "; locking-free four-node elements";
    case ElementKind::p2:
        return text + "; ten-node elements";
    case ElementKind::mixed:
        return text
            + "; ten-node elements at bone, and at lips unless blades bear on cut bone, four-node elements elsewhere, "
              "Poisson's ratios at most 0.45";
    }
    return text;
}

void check_accuracy(const AccuracyGoal& goal)
{
    const std::string place = "/solution/accuracy/";
    if (!(goal.force >= kFinestForce && goal.force <= kCoarsestForce))
        throw InputError(formatted("the accuracy of the force must be a share from %g to %g (%g to %g %%), got %g",
                             kFinestForce, kCoarsestForce, 100.0 * kFinestForce, 100.0 * kCoarsestForce, goal.force),
            place + "force", { "accuracy" });
    if (!(goal.opening_mm >= kFinestOpeningMm && goal.opening_mm <= kCoarsestOpeningMm))
        throw InputError(formatted("the accuracy of the opening must be from %g to %g mm, got %g", kFinestOpeningMm,
                             kCoarsestOpeningMm, goal.opening_mm),
            place + "opening", { "accuracy" });
    if (!(goal.time_s >= kShortestSearchS && goal.time_s <= kLongestSearchS))
        throw InputError(formatted("the time for the accuracy must be from %g to %g s, got %g", kShortestSearchS,
                             kLongestSearchS, goal.time_s),
            place + "time", { "time" });
}

void check_solution(const SolverSettings& choice, ContactMode contact)
{
    if (choice.accuracy)
        check_accuracy(*choice.accuracy);
    if (!(choice.near_mm >= 0.0) || !std::isfinite(choice.near_mm))
        throw InputError("the distance within which the wall is nonlinear must be finite and not negative",
            "/solution/near_mm", { "near_mm" });
    if (choice.elasticity == fem::Elasticity::corotational_linear)
        throw InputError("corotational_linear elasticity is for tissue that a hand drags, not for plans",
            "/solution/elasticity", { "elasticity" });
    const bool near = choice.near_mm > 0.0;
    if (near && choice.elasticity == fem::Elasticity::linear)
        throw InputError("nothing is nonlinear near the wound when the elasticity is linear: choose corotational or "
                         "hyperelastic, or remove near_mm",
            "/solution", { "elasticity", "near_mm" });
    if (near && choice.element == ElementKind::locking_free)
        throw InputError("locking-free elements are averaged across the border between nonlinear and linear tissue: "
                         "choose p1 or p2, or remove near_mm",
            "/solution", { "element", "near_mm" });
    if (near && contact == ContactMode::always)
        throw InputError(
            "contact needs the whole wall nonlinear, because the condensed tissue beyond near_mm has no surface for "
            "contact, and contact changes the matrix that near_mm factors once: let contact be auto, or remove near_mm",
            "/solution/near_mm", { "near_mm", "contact" });
}

} // namespace retractor::planner
