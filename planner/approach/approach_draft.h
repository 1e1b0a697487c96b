#pragma once
// A new or changed approach as a surgeon asks for it: where the incision is, what is divided, the target, and what
// opens the wound. Units mm; frame patient LPS.

#include "planner/case/approach.h"
#include "planner/case/patient.h"

#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// What the blade of a drawn incision divides.
enum class Divides {
    soft_tissue, ///< every layer but bone, as far as the skin incision
    space, ///< also the intercostal muscle and pleura beyond both ends of the skin incision
    bone, ///< also bone under the incision, as a saw does
};

/// What opens the wound.
struct OpenedBy {
    std::string retractor {}; ///< kind of the built-in table; empty: hooks
    std::string hooks = "4"; ///< hook template; hooks only
    double opening_mm = 0.0; ///< 0: the wound is cut and not opened
};

struct ApproachDraft {
    std::string name {}; ///< empty: the template's name or "drawn", with a number where that name is taken
    std::string template_name {}; ///< see approach_templates.h; empty: through the points
    bool left = true; ///< intercostal templates only
    std::vector<Vec3> points {}; ///< on or near the skin, in cutting order; used without a template
    Divides divides = Divides::soft_tissue; ///< used without a template
    bool organs_aside = true; ///< lungs and pericardium are held aside; used without a template
    double depth_mm = 0.0; ///< of a drawn incision; 0: through the wall
    std::string target {}; ///< a label
    OpenedBy opened_by {};
};

/// Makes the approach. @throws InputError as approach_from_template(), approach_from_points(), make_hooks() and
/// set_retractor() do
Approach approach_from_draft(Patient& patient, const Case& planned_case, const ApproachDraft& draft);

/// The same approach opened by something else. @throws InputError as make_hooks() and set_retractor() do
Approach opened_by(Approach approach, const OpenedBy& opening);

/// How far the retractor of an approach opens, or its hooks: the mean of one lip and the mean of the other, as
/// hook_opening(). 0 where they pull with a force, and where there are none.
double asked_opening_mm(const Approach& approach);

/// The same hooks or retractor with another opening. Hooks keep their shares of it.
/// @pre asked_opening_mm(approach) > 0, opening_mm > 0
/// @throws InputError as check_approach() does
Approach with_opening(Approach approach, double opening_mm);

/// Begin of the rationale of an incision that was moved.
inline constexpr std::string_view kMovedByHand = "Incision moved by hand. ";

/// The same approach with its incision through other points. Hooks or retractor, target, organs and divided layers
/// stay; tissue that was to be removed stays where it is along the incision.
/// @throws InputError as approach_from_points() does, where hooks or blades no longer fit, and where hooks were not
/// placed by a template
Approach with_incision_through(Patient& patient, const Approach& approach, const std::vector<Vec3>& points);

/// The same approach with the incision, blade and wall of another, and with its rationale. Target, organs, division,
/// views and settings stay; hooks and retractor are placed anew.
/// @throws InputError where hooks or blades do not fit, and where hooks were not placed by a template
Approach with_incision_of(const Approach& approach, const Approach& placed);

/// The same approach with another target. An organ that is operated on is not held aside, and what the rationale says
/// of the old target goes.
Approach with_target(Approach approach, TargetSpec target);

/// A few points of the incision, by which it can be moved: its ends, and points about `spacing_mm` apart between them.
std::vector<Vec3> incision_handles(const Approach& approach, double spacing_mm = 25.0);

/// The name, or the name with the first number ("-2") that no approach of the case has.
std::string free_approach_name(const Case& planned_case, const std::string& name);

/// The approach as surgeons call it: "Median sternotomy", "Left thoracotomy, 4th space".
std::string surgical_name(const Approach& approach);

/// The name for people: the title, or else the surgical name, where the approach has no name of its own.
std::string spoken_name(const Approach& approach);

/// Gives an approach of a case another title, or none. Its name stays, and with it its plan, cuts, views and choice.
/// @throws InputError when there is no such approach, or people call another one so
void set_title(Case& planned_case, std::string_view name, const std::string& title);

} // namespace retractor::planner
