#pragma once
// Parses JSON without guessing.

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace retractor::datasets {

/// Parses a document and keeps the order of its keys.
/// @param where place for the messages of errors
/// @throws InputError when the text is not JSON or not UTF-8, and when a key occurs twice in one object. The JSON
/// library alone would keep the last of two equal keys without a message.
nlohmann::ordered_json parse_strictly(const std::string& text, const std::string& where);

} // namespace retractor::datasets
