#pragma once
// Finds a patient's name in text. Text is UTF-8. Upper and lower case are equal, also for accented Latin, Greek and
// Cyrillic letters.

#include <cstddef>
#include <string>
#include <vector>

namespace retractor::datasets {

/// The parts of a name as DICOM writes a name ("Family^Given=..."), without repetitions.
std::vector<std::string> name_parts(const std::string& name);

/// The text in lower case, with the same number of bytes.
std::string fold_case(std::string text);

/// Returns the byte positions at which `word` stands in `text` as a whole word. @pre Both come from fold_case().
std::vector<std::size_t> whole_words(const std::string& text, const std::string& word);

/// Names and ids shorter than this (bytes) occur everywhere as units and abbreviations, so one alone identifies nobody.
inline constexpr std::size_t kShortestTelling = 3;

/// Returns the parts of `name` that stand in `text` and identify the patient: long parts as whole words, and short
/// parts when at least two parts occur ("Ng Li").
std::vector<std::string> telling_parts(const std::string& text, const std::string& name);

} // namespace retractor::datasets
