#include "tests/fuzz/mutations.h"

#include <nlohmann/json.hpp>

#include <array>
#include <string_view>
#include <vector>

namespace retractor::fuzz {

namespace {

    using Json = nlohmann::ordered_json;

    std::size_t below(std::mt19937_64& random, std::size_t end)
    {
        return static_cast<std::size_t>(random() % end); // the bias of 2^-50 does not matter here
    }

    constexpr std::array<std::string_view, 18> kAwkwardTokens { "null", "true", "-0", "1e999", "-1e400", "1e-320",
        "NaN", "18446744073709551616", "-9223372036854775809", "\"\"", "\"\\ud800\"", "\"\xff\xfe\"", "{}", "[]",
        "{\"a\":1,\"a\":2}", "[[[[[[[[[[[[[[[[", "\"../../etc\"", "\x00" };

    const std::vector<Json>& awkward_values()
    {
        static const std::vector<Json> values { nullptr, true, 0, -1, 1, 65536, 1e308, -1e-308, 0.5, 1ULL << 63, ~0ULL,
            -1LL << 62, "", "LPS", "/", "..", "a~b/c", std::string("nul\0inside", 10), Json::array(), Json::object(),
            Json::array({ 1, 2 }), Json { { "label", "rib" } } };
        return values;
    }

    /// Every value of the document, itself included.
    void collect(Json& value, std::vector<Json*>& all)
    {
        all.push_back(&value);
        if (value.is_structured())
            for (Json& child : value)
                collect(child, all);
    }

    void damage_children(Json& value, std::mt19937_64& random)
    {
        const std::size_t chosen = below(random, value.size());
        const bool doubled = random() % 2 == 0;
        if (value.is_array()) {
            if (doubled)
                value.push_back(Json(value[chosen]));
            else
                value.erase(chosen);
            return;
        }
        auto at = value.begin();
        std::advance(at, static_cast<std::ptrdiff_t>(chosen));
        const std::string key = at.key();
        if (doubled)
            value[key + "x"] = Json(at.value());
        else
            value.erase(key);
    }

} // namespace

std::string damage_bytes(const std::string& text, std::mt19937_64& random)
{
    std::string damaged = text;
    if (damaged.empty())
        return std::string(kAwkwardTokens[below(random, kAwkwardTokens.size())]);
    const std::size_t at = below(random, damaged.size());
    const std::size_t length = 1 + below(random, std::min<std::size_t>(64, damaged.size() - at));
    switch (below(random, 6)) {
    case 0:
        damaged[at] = static_cast<char>(static_cast<unsigned char>(damaged[at]) ^ (1U << below(random, 8)));
        break;
    case 1:
        damaged[at] = static_cast<char>(below(random, 256));
        break;
    case 2:
        damaged.resize(at); // a write that was cut short
        break;
    case 3:
        damaged.erase(at, length);
        break;
    case 4:
        damaged.insert(below(random, damaged.size()), damaged.substr(at, length));
        break;
    default:
        damaged.replace(at, length, kAwkwardTokens[below(random, kAwkwardTokens.size())]);
    }
    return damaged;
}

std::string damage_values(const std::string& text, std::mt19937_64& random)
{
    Json document = Json::parse(text);
    std::vector<Json*> all;
    collect(document, all);
    Json& chosen = *all[below(random, all.size())];
    switch (below(random, 3)) {
    case 0:
        chosen = awkward_values()[below(random, awkward_values().size())];
        break;
    case 1: {
        const Json other = *all[below(random, all.size())];
        chosen = other;
        break;
    }
    default:
        if (chosen.is_structured() && !chosen.empty())
            damage_children(chosen, random);
        else
            chosen = Json::array({ chosen });
    }
    return document.dump();
}

} // namespace retractor::fuzz
