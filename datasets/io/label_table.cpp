#include "datasets/io/label_table.h"

#include "datasets/io/strict_json.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"

#include <nlohmann/json.hpp>

#include <fstream>
#include <limits>
#include <set>
#include <sstream>

namespace retractor::datasets {

namespace {

    using json = nlohmann::ordered_json;

    const json& member(const json& object, const char* key, const std::string& where)
    {
        if (!object.is_object() || !object.contains(key))
            throw InputError(std::string("missing \"") + key + "\"", where);
        return object.at(key);
    }

    std::string text_member(const json& object, const char* key, const std::string& where)
    {
        const json& value = member(object, key, where);
        if (!value.is_string() || value.get<std::string>().empty())
            throw InputError("must be a text that is not empty", where + "/" + key);
        return value.get<std::string>();
    }

    mesh::LabelInfo read_label(const json& entry, const std::string& where)
    {
        const json& id = member(entry, "id", where);
        if (!id.is_number_integer() || id.get<std::int64_t>() < 1
            || id.get<std::int64_t>() > std::numeric_limits<Label>::max())
            throw InputError("a label's id must be a whole number from 1 to 65535", where + "/id");
        const std::string role = text_member(entry, "role", where);
        if (!mesh::role_from_string(role))
            throw InputError("unknown role \"" + role + "\": use wall, voxel, target or at-risk", where + "/role");
        return { id.get<Label>(), text_member(entry, "name", where), text_member(entry, "material", where),
            *mesh::role_from_string(role) };
    }

} // namespace

mesh::LabelTable label_table_from_json(const std::string& text, const std::string& where)
{
    const json document = parse_strictly(text, where);
    const std::string frame = text_member(document, "frame", where);
    if (frame != "LPS")
        throw InputError("unknown frame \"" + frame + "\", this program works in LPS", where + "/frame");
    const json& entries = member(document, "labels", where);
    if (!entries.is_array())
        throw InputError("must be a list", where + "/labels");
    mesh::LabelTable table;
    std::set<Label> ids;
    std::set<std::string> names;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const std::string at = where + "/labels/" + std::to_string(i);
        mesh::LabelInfo info = read_label(entries[i], at);
        if (!ids.insert(info.id).second)
            throw InputError("id " + std::to_string(info.id) + " is given twice", at + "/id");
        if (!names.insert(info.name).second)
            throw InputError("name \"" + info.name + "\" is given twice", at + "/name");
        table.push_back(std::move(info));
    }
    return table;
}

mesh::LabelTable read_label_table(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    if (!file)
        throw IoError("no label table: a label image needs this file beside it", path.string());
    std::ostringstream text;
    text << file.rdbuf();
    return label_table_from_json(text.str(), path.string() + ":");
}

std::string label_table_to_json(const mesh::LabelTable& table)
{
    json entries = json::array();
    for (const mesh::LabelInfo& info : table)
        entries.push_back({ { "id", info.id }, { "name", info.name }, { "material", info.material },
            { "role", std::string(to_string(info.role)) } });
    try {
        return json { { "frame", "LPS" }, { "labels", entries } }.dump(1) + "\n";
    } catch (const json::exception& error) {
        throw InputError(std::string("a text is not valid UTF-8: ") + error.what(), "label table");
    }
}

void write_label_table(const std::filesystem::path& path, const mesh::LabelTable& table)
{
    write_file_atomically(path, label_table_to_json(table));
}

void check_labels_named(const mesh::LabelVolume& labels, const std::string& where)
{
    std::vector<bool> seen(std::size_t { std::numeric_limits<Label>::max() } + 1, false);
    for (const Label label : labels.voxels)
        seen[label] = true;
    for (const mesh::LabelInfo& info : labels.table)
        seen[info.id] = false;
    seen[0] = false;
    std::string unknown;
    int count = 0;
    for (std::size_t id = 0; id < seen.size(); ++id)
        if (seen[id] && ++count <= 8)
            unknown += (unknown.empty() ? "" : ", ") + std::to_string(id);
    if (count > 0)
        throw InputError("the image has " + std::to_string(count) + " label(s) that the table does not name: " + unknown
                + (count > 8 ? ", ..." : ""),
            where);
}

} // namespace retractor::datasets
