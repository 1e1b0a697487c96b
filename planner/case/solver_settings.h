#pragma once
// How an opened wound is solved: the model of the tissue, the kind of element, and the size of the nonlinear region.
// All approaches of a case use the same settings, so that they can be compared. Units mm.

#include "fem/material/elasticity.h"
#include "fem/material/material.h"

#include <optional>
#include <string>
#include <string_view>

namespace retractor::planner {

enum class ElementKind {
    p1, ///< four nodes; Poisson's ratios at most 0.45, because these elements lock above
    locking_free, ///< four nodes, strain averaged over neighbours (fem/element/locking_free.h)
    p2, ///< ten nodes
    mixed, ///< ten nodes where elements touch bone, cartilage or the lips, four elsewhere; ratios as p1
};

/// Whether all or some elements have ten nodes.
inline bool has_ten_nodes(ElementKind element) { return element == ElementKind::p2 || element == ElementKind::mixed; }

/// Whether the lips of the wound, and wall and organs that stay, hold each other off (fem/model/contact.h). Without
/// contact they pass through each other.
enum class ContactMode {
    automatic, ///< where they would pass through each other (planner/plan/contact_where_needed.h)
    always,
    never,
};

/// How small the error bars of a plan shall be, and the time for it (planner/plan/accurate_plan.h).
struct AccuracyGoal {
    double force = 0.15; ///< half-width of the force's bar over the force; kFinestForce to 1
    double opening_mm = 2.0; ///< half-width of the opening's bar, mm; kFinestOpeningMm to kCoarsestOpeningMm
    double time_s = 600.0; ///< time for all meshes of one approach, s; up to kLongestSearchS

    bool operator==(const AccuracyGoal&) const = default;
};

/// Limits of an AccuracyGoal. Finer bars take more memory than machines have; coarser bars say nothing.
inline constexpr double kFinestForce = 0.005, kCoarsestForce = 1.0;
inline constexpr double kFinestOpeningMm = 0.1, kCoarsestOpeningMm = 20.0;
inline constexpr double kShortestSearchS = 1.0, kLongestSearchS = 86'400.0; // up to a day

struct SolverSettings {
    fem::Elasticity elasticity = fem::Elasticity::corotational;
    ElementKind element = ElementKind::p1;
    /// Tissue within this distance of the lips is nonlinear, and linear beyond; 0: the same law everywhere.
    double near_mm = 0.0;
    /// The accuracy that plans on request aim for; not set: the request's own (PlanChecks::accuracy).
    std::optional<AccuracyGoal> accuracy {};

    bool operator==(const SolverSettings&) const = default;
};

/// Names in files: "linear", "corotational", "hyperelastic"; "p1", "locking-free", "p2",
/// "mixed"; "auto", "on", "off".
std::string_view to_string(fem::Elasticity elasticity);
std::string_view to_string(ElementKind element);
std::string_view to_string(ContactMode contact);
std::optional<fem::Elasticity> elasticity_from_string(std::string_view text);
std::optional<ElementKind> element_from_string(std::string_view text);
std::optional<ContactMode> contact_mode_from_string(std::string_view text);

/// The largest Poisson's ratio of these elements. A larger ratio of a material is replaced by this one.
double largest_poissons_ratio(ElementKind element);

/// The material as elements of that kind can have it: its Poisson's ratio is cut off at largest_poissons_ratio().
fem::Material as_solved(fem::Material material, ElementKind element);

/// Text for people: "hyperelastic within 40 mm of the lips, linear beyond; ten-node elements".
std::string solution_text(const SolverSettings& choice);

/// @throws InputError naming the number of the goal that is out of range ("/solution/accuracy/force")
void check_accuracy(const AccuracyGoal& goal);

/// Checks that the settings can be combined.
/// @throws InputError naming two contradictory settings, or a distance that is negative or not finite; as
/// check_accuracy()
void check_solution(const SolverSettings& choice, ContactMode contact);

} // namespace retractor::planner
