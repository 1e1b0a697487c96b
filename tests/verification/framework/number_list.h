#pragma once
// Numbers in published model files.

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

namespace retractor::verification {

/// Those of a line or an element's text, divided by commas or blanks, up to the first that is none.
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
