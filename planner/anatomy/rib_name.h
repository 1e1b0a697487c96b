#pragma once
// Side and number of a rib, from the name of its label.

#include <charconv>
#include <compare>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace retractor::planner {

struct RibName {
    bool left = true;
    int number = 0; ///< 1 to 13: some people have one rib more

    auto operator<=>(const RibName&) const = default;
};

/// Reads "rib_left_5". Nothing: the label is no rib.
inline std::optional<RibName> rib_name(std::string_view label)
{
    constexpr int kLowest = 13;
    for (const auto& [prefix, left] : { std::pair<std::string_view, bool> { "rib_left_", true },
             std::pair<std::string_view, bool> { "rib_right_", false } }) {
        if (!label.starts_with(prefix))
            continue;
        RibName rib { .left = left, .number = 0 };
        const char* const end = label.data() + label.size();
        const auto [read, error] = std::from_chars(label.data() + prefix.size(), end, rib.number);
        if (error == std::errc {} && read == end && rib.number >= 1 && rib.number <= kLowest)
            return rib;
    }
    return std::nullopt;
}

/// "rib 8 on the right".
inline std::string rib_in_words(const RibName& rib)
{
    return "rib " + std::to_string(rib.number) + (rib.left ? " on the left" : " on the right");
}

} // namespace retractor::planner
