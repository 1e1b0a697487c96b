#include "ui/cli/framework/number_range.h"

#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"

#include <string>

namespace retractor::ui::cli {

CLI::Validator in_range(double low, double high)
{
    RETRACTOR_ASSERT(low <= high);
    const std::string words = formatted("%g to %g", low, high);
    return CLI::Validator(
        [low, high, words](std::string& text) {
            double value = 0.0;
            const bool is_number = CLI::detail::lexical_cast(text, value);
            return is_number && value >= low && value <= high ? std::string()
                                                              : "must be a number from " + words + ", not " + text;
        },
        "FLOAT in [" + words + "]");
}

} // namespace retractor::ui::cli
