#pragma once
// Text as a field of a CSV file (RFC 4180).

#include <string>

namespace retractor::haptics {

/// In quotes where it holds a comma, a quote or an end of line; quotes inside are doubled.
std::string csv_field(const std::string& text);

} // namespace retractor::haptics
