#include "ui/cli/commands.h"
#include "ui/cli/framework/arguments.h"
#include "ui/cli/framework/number_range.h"

#include "fem/model/pre_strain.h"
#include "mesh/base/error.h"
#include "planner/case/case_io.h"
#include "planner/wall/wall_tension.h"
#include "ui/cli/framework/open_case.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <memory>
#include <optional>

namespace retractor::ui::cli {

namespace {

    struct TensionOptions {
        std::string case_file, material, direction, normal;
        std::optional<double> along, across;
        bool none = false;
    };

    bool is_in_wall(const planner::Case& planned_case, const std::string& material)
    {
        return std::any_of(planned_case.label_table.begin(), planned_case.label_table.end(),
            [&](const mesh::LabelInfo& info) { return info.role == mesh::Role::wall && info.material == material; });
    }

    Outcome list(const planner::Case& planned_case)
    {
        Outcome outcome;
        outcome.document["tension"] = Json::array();
        for (const fem::Material& material : planned_case.materials) {
            if (!is_in_wall(planned_case, material.name))
                continue;
            const std::string text = planner::pre_strain_text(material.pre_strain);
            outcome.document["tension"].push_back({ { "material", material.name }, { "pre_strain", text } });
            outcome.text += material.name + ": " + text + "\n";
        }
        return outcome;
    }

    fem::Material& material_of_wall(planner::Case& planned_case, const std::string& name)
    {
        std::string known;
        for (fem::Material& material : planned_case.materials) {
            if (!is_in_wall(planned_case, material.name))
                continue;
            if (material.name == name)
                return material;
            known += (known.empty() ? "" : ", ") + material.name;
        }
        throw InputError("no tissue of the wall has this material; the wall has: " + (known.empty() ? "none" : known),
            "--material " + name);
    }

    /// The requested pre-strain, as in case.json: tissue without a strain across is free to narrow.
    fem::PreStrain asked_for(const TensionOptions& options)
    {
        if (options.none) {
            if (options.along || options.across || !options.direction.empty() || !options.normal.empty())
                throw InputError(
                    "tissue without tension has no strain and no direction: omit the other options", "--none");
            return {};
        }
        if (!options.along)
            throw InputError("give --along, or --none", "command line");
        fem::PreStrain tension { .kind
            = options.across ? fem::PreStrainKind::biaxial : fem::PreStrainKind::uniaxial_stress,
            .strain = *options.along,
            .across = options.across.value_or(0.0) };
        if (!options.direction.empty())
            tension.pull = parse_point(options.direction, "--direction");
        if (!options.normal.empty()) {
            tension.normal = parse_point(options.normal, "--normal");
            if (tension.normal.isZero(0.0))
                throw InputError("a direction must not be zero", "--normal");
        }
        try {
            fem::check_pre_strain(tension);
        } catch (const InputError& error) {
            throw InputError(error.what(), "--" + error.where());
        }
        return tension;
    }

    Outcome change(const TensionOptions& options)
    {
        planner::Case planned_case = open_case(options.case_file);
        if (options.material.empty()) {
            if (options.none || options.along || options.across || !options.direction.empty()
                || !options.normal.empty())
                throw InputError("name the material", "--material");
            return list(planned_case);
        }
        material_of_wall(planned_case, options.material).pre_strain = asked_for(options);
        planner::write_case(planned_case);
        return list(planned_case);
    }

} // namespace

void add_tension_command(Commands& commands)
{
    auto options = std::make_shared<TensionOptions>();
    CLI::App* command = commands.app.add_subcommand("tension",
        "Show or set the strain of the tissue before the cut. A cut releases the strain, and the wound gapes");
    command->footer(
        "Example: retractor tension case.json\n"
        "Example: retractor tension case.json --material skin --along 0.04 --across 0.02 --direction 0,0,1\n"
        "Example: retractor tension case.json --material skin --along 0.04 --across 0.04\n"
        "Example: retractor tension case.json --material skin --none");
    command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    command->add_option(
        "--material", options->material, "Material of the wall that gets the tension (default: list the materials)");
    command->add_option("--along", options->along, "Strain along the direction, 0 to 0.5 (skin: 0.02 to 0.06)")
        ->check(in_range(0.0, fem::kLargestPreStrain));
    command
        ->add_option("--across", options->across,
            "Strain across the direction, in the plane of the tissue, 0 to 0.5 (default: the tissue narrows freely)")
        ->check(in_range(0.0, fem::kLargestPreStrain));
    command->add_option("--direction", options->direction,
        "Direction of the strain as x,y,z (patient LPS), projected onto the plane of the tissue; not needed when both "
        "strains are equal");
    command->add_option("--normal", options->normal,
        "Normal of the plane of the tissue as x,y,z (default: the normal of the nearest skin)");
    command->add_flag("--none", options->none, "Remove the tension of the material");
    commands.on(command, [options](const Job&) { return change(*options); });
}

} // namespace retractor::ui::cli
