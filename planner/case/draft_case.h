#pragma once
// A case that is planned quickly: a draft.

#include "planner/case/case.h"

namespace retractor::planner {

/// Changes the case to one that is planned quickly: four-node elements on a coarse mesh, without contact.
void make_draft(Case& planned_case);

} // namespace retractor::planner
