#include "ui/cli/framework/field_options.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstddef>
#include <iterator>

namespace retractor::ui::cli {

namespace {

    struct FieldOption {
        const char* field;
        const char* option;
    };

    /// Fields and options. A field with different options in two commands comes twice.
    constexpr FieldOption kFieldOptions[] = {
        { "accept_implausible", "--accept-implausible" },
        { "accept_labels", "--accept-labels" },
        { "accuracy", "--accuracy" },
        { "anywhere", "--anywhere" },
        { "autosegment", "--autosegment" },
        { "check", "--check" },
        { "contact", "--contact" },
        { "corridor_edge_mm", "--edge" },
        { "depth_mm", "--depth" },
        { "edge_mm", "--edge" },
        { "elasticity", "--elasticity" },
        { "element", "--element" },
        { "from_risk_mm", "--from-risk" },
        { "held", "--held" },
        { "hook_template", "--hooks" },
        { "hook_template", "--template" },
        { "labels", "--labels" },
        { "least_seen", "--least-seen" },
        { "length_mm", "--length" },
        { "model", "--model" },
        { "near_mm", "--near" },
        { "opening_mm", "--opening" },
        { "points", "--points" },
        { "poissons_ratio", "--poisson" },
        { "preset", "--preset" },
        { "pressures", "--pressure" },
        { "radius_mm", "--radius" },
        { "repair_labels", "--repair-labels" },
        { "retracted", "--retract" },
        { "retractor", "--retractor" },
        { "side", "--side" },
        { "sites", "--site" },
        { "spaces", "--spaces" },
        { "stiff", "--stiff" },
        { "structure", "--structure" },
        { "target", "--target" },
        { "template_name", "--template" },
        { "time", "--time" },
        { "wall_mm", "--wall" },
        { "weights", "--weights" },
        { "youngs_modulus_MPa", "--young" },
    };

    /// The innermost command of the arguments.
    const CLI::App& given_command(const CLI::App& app)
    {
        const std::vector<CLI::App*> given = app.get_subcommands();
        return given.empty() ? app : given_command(*given.front());
    }

    /// The option of the command that sets the field; empty when there is none.
    std::string option_of(const CLI::App& command, const std::string& field)
    {
        const auto* const found
            = std::find_if(std::begin(kFieldOptions), std::end(kFieldOptions), [&](const FieldOption& entry) {
                  return entry.field == field && command.get_option_no_throw(entry.option) != nullptr;
              });
        return found == std::end(kFieldOptions) ? std::string() : found->option;
    }

} // namespace

std::string option_hint(const CLI::App& app, const std::vector<std::string>& fields)
{
    const CLI::App& command = given_command(app);
    std::string options;
    std::size_t count = 0;
    for (const std::string& field : fields)
        if (const std::string option = option_of(command, field); !option.empty()) {
            options += (options.empty() ? "" : ", ") + option;
            ++count;
        }
    return count == 0 ? std::string() : (count == 1 ? " (option " : " (options ") + options + ")";
}

} // namespace retractor::ui::cli
