#pragma once
// One structure of a segmentation and how the segmentation found it: what the steps report to autosegment() and what
// the result lists. Units ml.

#include <string>

namespace retractor::datasets {

/// How a structure was found, for the report and the contact sheet.
struct FoundStructure {
    std::string name; ///< as in the label table
    double volume_ml = 0.0;
    bool rough = false; ///< a region estimated from its neighbours, not seen in the image
    std::string how; ///< one line: "threshold 200 HU, connected to the spine"
};

} // namespace retractor::datasets
