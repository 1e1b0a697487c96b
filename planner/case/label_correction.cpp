#include "planner/case/label_correction.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <vector>

namespace retractor::planner {

namespace {

    void require_label(const Case& planned_case, const std::string& name)
    {
        static_cast<void>(mesh::label_named(planned_case.label_table, name));
    }

    /// Puts one name in the place of another; a name that is there already is not listed twice.
    void replace_name(std::vector<std::string>& names, const std::string& name, const std::string& by)
    {
        const auto at = std::find(names.begin(), names.end(), name);
        if (at == names.end())
            return;
        if (std::find(names.begin(), names.end(), by) != names.end())
            names.erase(at);
        else
            *at = by;
    }

    void replace_everywhere(Case& planned_case, const std::string& name, const std::string& by)
    {
        replace_name(planned_case.estimated_labels, name, by);
        replace_name(planned_case.supports.labels, name, by);
        for (PressureSpec& pressure : planned_case.pressures)
            if (pressure.label == name)
                pressure.label = by;
        for (Approach& approach : planned_case.approaches) {
            if (approach.target.label == name)
                approach.target.label = by;
            replace_name(approach.retracted, name, by);
            replace_name(approach.uncut_labels, name, by);
            for (AblationSpec& ablation : approach.ablations)
                if (ablation.label == name)
                    ablation.label = by;
        }
    }

} // namespace

void rename_label(Case& planned_case, const std::string& name, const std::string& new_name)
{
    require_label(planned_case, name);
    if (new_name.empty())
        throw InputError("a label needs a name");
    if (mesh::find_label(planned_case.label_table, new_name) != nullptr)
        throw InputError("there is a label \"" + new_name + "\" already: join the two, or rename that one first");
    for (mesh::LabelInfo& info : planned_case.label_table)
        if (info.name == name)
            info.name = new_name;
    replace_everywhere(planned_case, name, new_name);
}

void join_label(Case& planned_case, const std::string& name, const std::string& into)
{
    require_label(planned_case, name);
    require_label(planned_case, into);
    if (name == into)
        throw InputError("\"" + name + "\" cannot be joined with itself");
    std::erase_if(planned_case.label_table, [&](const mesh::LabelInfo& info) { return info.name == name; });
    const auto listed = [&](const std::string& label) {
        return std::ranges::any_of(
            planned_case.pressures, [&](const PressureSpec& pressure) { return pressure.label == label; });
    };
    if (listed(name) && listed(into)) // one label has one pressure
        std::erase_if(planned_case.pressures, [&](const PressureSpec& pressure) { return pressure.label == name; });
    // An estimated part makes the whole estimated: the mark moves with the name.
    replace_everywhere(planned_case, name, into);
}

void confirm_label(Case& planned_case, const std::string& name)
{
    require_label(planned_case, name);
    if (std::erase(planned_case.estimated_labels, name) == 0)
        throw InputError("the label \"" + name + "\" is not estimated");
}

} // namespace retractor::planner
