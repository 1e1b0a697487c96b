#include "planner/case/label_correction.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cctype>
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
    check_label_name(new_name);
    if (mesh::find_label(planned_case.label_table, new_name) != nullptr)
        throw InputError("there is a label \"" + new_name + "\" already: join the two, or rename that one first");
    for (mesh::LabelInfo& info : planned_case.label_table)
        if (info.name == name)
            info.name = new_name;
    replace_everywhere(planned_case, name, new_name);
}

void check_label_name(const std::string& name)
{
    const auto is_word = [](char c) {
        const auto byte = static_cast<unsigned char>(c);
        return std::isalnum(byte) != 0 || byte >= 0x80; // letters of other scripts, in UTF-8
    };
    const bool good = !name.empty() && is_word(name.front()) && std::ranges::all_of(name, [&](char c) {
        return is_word(c) || c == '_' || c == '-' || c == '.' || c == '+';
    });
    if (!good)
        throw InputError("\"" + name + "\" cannot be a label's name: use letters, digits and _ - . +");
}

void join_label(Case& planned_case, const std::string& name, const std::string& into)
{
    require_label(planned_case, name);
    require_label(planned_case, into);
    if (name == into)
        throw InputError("\"" + name + "\" cannot be joined with itself");
    const mesh::LabelInfo &from = mesh::label_named(planned_case.label_table, name),
                          &to = mesh::label_named(planned_case.label_table, into);
    if (mesh::is_wall(from) != mesh::is_wall(to) || (mesh::is_wall(from) && from.material != to.material))
        throw InputError("\"" + name + "\" (" + from.material + ") cannot become a part of \"" + into + "\" ("
            + to.material + "): they are different tissue");
    for (const Approach& approach : planned_case.approaches)
        if (approach.target.label == name && std::ranges::find(approach.retracted, into) != approach.retracted.end())
            throw InputError("the approach " + approach.name + " looks at \"" + name + "\" and holds \"" + into
                + "\" aside: change its target first");
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
