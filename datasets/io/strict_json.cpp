#include "datasets/io/strict_json.h"

#include "mesh/base/error.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <set>
#include <vector>

namespace retractor::datasets {

nlohmann::ordered_json parse_strictly(const std::string& text, const std::string& where)
{
    using Json = nlohmann::ordered_json;
    std::vector<std::set<std::string>> keys; // keys of each open object
    std::optional<std::string> twice;
    const auto watch = [&](int, Json::parse_event_t event, Json& value) {
        if (event == Json::parse_event_t::object_start)
            keys.emplace_back();
        else if (event == Json::parse_event_t::object_end)
            keys.pop_back();
        else if (event == Json::parse_event_t::key && !keys.back().insert(value.get<std::string>()).second)
            twice = value.get<std::string>();
        return true;
    };
    try {
        Json json = Json::parse(text, watch);
        if (twice)
            throw InputError("the key \"" + *twice + "\" is given twice in one object", where);
        return json;
    } catch (const Json::exception& error) {
        throw InputError(std::string("not JSON: ") + error.what(), where);
    }
}

} // namespace retractor::datasets
