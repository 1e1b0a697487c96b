#pragma once
// A planned field in one sentence or two, and a light: what it means for use. The words are a surgeon's, the numbers
// have two digits.

#include "planner/measures/field_metrics.h"

#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

enum class Light {
    clear, ///< nothing found that speaks against this field
    caution, ///< read the sentences before this field is used
    injury, ///< something breaks, tears or is cut that must not be; or the target is not seen
    unknown, ///< the numbers are not to be relied on
};

/// "clear", "caution", "injury" or "unknown": the words of metrics.json.
std::string_view to_string(Light light);

/// "No objection", "Caution", "Objection" or "Not usable".
const char* words_of(Light light);

struct Verdict {
    Light light = Light::unknown;
    std::vector<std::string> sentences; ///< the worst first
};

/// The light is `unknown` where the computation found no equilibrium, elements are inverted, soft tissue does not keep
/// its volume, or an implausible number was accepted. It is never `clear` beside an impossible number.
/// @pre set_attainable() was called
Verdict verdict_of(const FieldMetrics& field);

/// The sentences of the verdict that mean injury, joined: "Rib 4 on the left would break from 28 mm on." Empty: none.
std::string objections_of(const FieldMetrics& field);

/// The interval of the force from the mesh (ErrorBars) and from the tissue values (ParameterInterval), added as
/// independent errors are; equal ends where neither is known.
struct ForceInterval {
    double low_N = 0.0, high_N = 0.0;
    bool is_known() const { return high_N > low_N; }
};
ForceInterval force_interval(const FieldMetrics& field);

/// A larger force on a side is no retraction: rib and sternal spreaders were measured at up to some 600 N (ours).
inline constexpr double kImpossibleForceN = 2000.0;

/// Why the numbers of a field are not to be used, in a sentence; empty: nothing speaks against them.
std::string why_not_to_use(const FieldMetrics& field);

/// "0.34" as 34, "1234" as 1200: two significant digits, and no digits behind the point from 10 on.
std::string two_digits(double value);

} // namespace retractor::planner
