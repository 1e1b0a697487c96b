#pragma once
// Reads lists of numbers in published model files.

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

namespace retractor::verification {

/// The numbers of a line or of an element's text, separated by commas or blanks, up to the first word that is not a
/// number.
inline std::vector<double> number_list(std::string text)
{
    std::replace(text.begin(), text.end(), ',', ' ');
    std::istringstream stream(text);
    std::vector<double> values;
    for (double v = 0.0; stream >> v;)
        values.push_back(v);
    return values;
}

} // namespace retractor::verification
