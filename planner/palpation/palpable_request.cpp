#include "planner/palpation/palpable_request.h"

#include "mesh/base/error.h"

namespace retractor {

std::string names_of(const LabelTable& table)
{
    std::string names;
    for (const LabelInfo& info : table)
        names += (names.empty() ? "" : ", ") + info.name;
    return names;
}

const LabelInfo& label_of(const LabelVolume& labels, const std::string& name, const char* field)
{
    if (const LabelInfo* info = find_label(labels.table, name))
        return *info;
    throw InputError("there is no structure \"" + name + "\"; there are " + names_of(labels.table), field, { field });
}

} // namespace retractor
