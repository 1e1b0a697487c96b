#pragma once
// Formats text as a field of a CSV file (RFC 4180).

#include <string>

namespace retractor::haptics {

/// Puts the text in quotes when it contains a comma, a quote or an end of line, and doubles quotes inside.
std::string csv_field(const std::string& text);

} // namespace retractor::haptics
