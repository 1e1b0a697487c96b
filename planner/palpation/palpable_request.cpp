#include "planner/palpation/palpable_request.h"

#include "mesh/base/error.h"

namespace retractor::planner {

std::string names_of(const mesh::LabelTable& table)
{
    std::string names;
    for (const mesh::LabelInfo& info : table)
        names += (names.empty() ? "" : ", ") + info.name;
    return names;
}

const mesh::LabelInfo& label_of(const mesh::LabelVolume& labels, const std::string& name, const char* field)
{
    if (const mesh::LabelInfo* info = mesh::find_label(labels.table, name))
        return *info;
    throw InputError("there is no structure \"" + name + "\"; there are " + names_of(labels.table), field, { field });
}

} // namespace retractor::planner
