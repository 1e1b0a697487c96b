#pragma once
// JSON as people and programs write it into our files, read without guessing.

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace retractor::datasets {

/// The document, the order of its keys kept.
/// @throws InputError, its where() as given: not JSON, not UTF-8, or a key given twice in one object (of which the
/// parser alone would keep the last in silence).
nlohmann::ordered_json parse_strictly(const std::string& text, const std::string& where);

} // namespace retractor::datasets
