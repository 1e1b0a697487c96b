#include "planner/approach/find_division.h"

#include "mesh/base/error.h"
#include "planner/approach/space_division.h"
#include "planner/approach/sternum_division.h"

#include <memory>
#include <string>
#include <vector>

namespace retractor::planner {

void find_division(Approach& approach, Patient& patient)
{
    Division& division = approach.division;
    division.strokes.clear();
    division.words.clear();
    if (division.extent == DivisionExtent::skin)
        return;
    const bool sternum = divides_sternum(division.extent);
    std::shared_ptr<const Anatomy> anatomy;
    try {
        anatomy = patient.anatomy();
    } catch (const InputError& error) {
        division.words = std::string(sternum ? "the sternum" : "the intercostal space")
            + " was not found, and nothing is divided beyond the skin: " + error.what();
        return;
    }
    if (sternum)
        find_sternum_division(approach, *patient.labels(), *anatomy);
    else
        find_space_division(approach, *patient.labels(), *anatomy, patient.planned_case().assumed_vessels);
}

void set_division(Approach& approach, const Division& division)
{
    approach.division = division;
    if (divides_sternum(division.extent))
        for (const char* sawn : { "sternum", "bone_other" })
            std::erase(approach.uncut_labels, sawn);
}

} // namespace retractor::planner
