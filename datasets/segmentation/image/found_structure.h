#pragma once
// One structure of a segmentation, and how the structure was found. The steps report these records to autosegment(),
// and the result lists them.

#include <string>

namespace retractor::datasets {

/// How a structure was found, for the report and the contact sheet.
struct FoundStructure {
    std::string name; ///< as in the label table
    double volume_ml = 0.0; ///< ml
    bool rough = false; ///< true: the region is estimated from its neighbours, the image does not show the structure
    std::string how; ///< one line: "threshold 200 HU, connected to the spine"
};

} // namespace retractor::datasets
