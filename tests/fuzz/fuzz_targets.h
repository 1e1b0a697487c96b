#pragma once
// What the readers of our own JSON files guarantee, whatever they are given: a value, or an InputError that says what
// and where. The same functions are fed by libFuzzer (tests/fuzz/README.md) and by the seeded mutations that ctest
// runs.

#include <string>
#include <vector>

namespace retractor::fuzz {

enum class Answer { accepted, refused };

/// Reads the text as case.json. What is accepted must come back unchanged when it is written and read again.
/// @throws std::logic_error when a guarantee is broken; whatever else the reader throws passes through.
Answer feed_case(const std::string& text);
/// The same for a label table.
Answer feed_label_table(const std::string& text);

/// Valid files, made by the writers: where mutation starts.
std::vector<std::string> case_seeds();
std::vector<std::string> label_table_seeds();

} // namespace retractor::fuzz
