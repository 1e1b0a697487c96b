#pragma once
// Finding a patient's name in text. Text is UTF-8; letters are compared whatever their case (Latin with accents, Greek
// and Cyrillic too).

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace retractor::datasets {

/// The parts of a name as DICOM writes it ("Family^Given=..."), each once.
std::vector<std::string> name_parts(const std::string& name);

/// In lower case. Takes as many bytes as `text`.
std::string fold_case(std::string text);

/// Where `word` stands in `text` as a whole word: not as part of a longer one. Both folded.
std::vector<std::size_t> whole_words(const std::string& text, const std::string& word);

/// Parts and ids below this length (bytes) are found everywhere, as units and abbreviations: alone they name nobody.
inline constexpr std::size_t kShortestTelling = 3;

/// The parts of a name that stand in `text`, and by which it is told: long ones as whole words; any, when there are
/// at least two ("Ng Li").
std::vector<std::string> telling_parts(const std::string& text, const std::string& name);

} // namespace retractor::datasets
