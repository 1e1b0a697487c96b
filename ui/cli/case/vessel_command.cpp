#include "ui/cli/commands.h"
#include "ui/cli/framework/arguments.h"
#include "ui/cli/framework/number_range.h"
#include "ui/cli/framework/open_case.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/anatomy/assumed_vessels.h"
#include "planner/case/case_io.h"
#include "planner/case/patient.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace retractor::ui::cli {

namespace {

    struct VesselOptions {
        std::string case_file, set;
        std::vector<std::string> points, removed;
        std::optional<double> radius_mm;
        bool assume = false;
    };

    double length_of(const std::vector<Vec3>& line)
    {
        double length = 0.0;
        for (std::size_t n = 1; n < line.size(); ++n)
            length += (line[n] - line[n - 1]).norm();
        return length;
    }

    std::string place(const Vec3& p) { return formatted("%.0f,%.0f,%.0f", p.x(), p.y(), p.z()); }

    Outcome list(const planner::Case& planned_case)
    {
        Outcome outcome;
        outcome.document["assumed_vessels"] = Json::array();
        for (const planner::AssumedVessel& vessel : planned_case.assumed_vessels) {
            Json line = Json::array();
            for (const Vec3& p : vessel.line)
                line.push_back({ p.x(), p.y(), p.z() });
            outcome.document["assumed_vessels"].push_back(
                { { "name", vessel.name }, { "line_mm", std::move(line) }, { "radius_mm", vessel.radius_mm } });
            outcome.text += formatted("%-32s %4.0f mm long, radius %.1f mm, from %s to %s\n", vessel.name.c_str(),
                length_of(vessel.line), vessel.radius_mm, place(vessel.line.front()).c_str(),
                place(vessel.line.back()).c_str());
        }
        if (planned_case.assumed_vessels.empty())
            outcome.text
                = "no vessel is assumed; --assume puts mammary arteries, and vessels and nerves under the ribs, "
                  "where they usually are\n";
        return outcome;
    }

    /// Those that the bones give, and those of other kinds that were set by hand.
    void assume(planner::Case& planned_case)
    {
        planner::Patient patient(planned_case);
        std::vector<planner::AssumedVessel> vessels = planner::assumed_vessels(*patient.labels(), *patient.anatomy());
        for (planner::AssumedVessel& before : planned_case.assumed_vessels)
            if (!planner::is_mammary(before.name) && !planner::is_neurovascular_bundle(before.name))
                vessels.push_back(std::move(before));
        planned_case.assumed_vessels = std::move(vessels);
    }

    void remove(planner::Case& planned_case, const std::vector<std::string>& names)
    {
        for (const std::string& name : names)
            if (std::erase_if(planned_case.assumed_vessels,
                    [&](const planner::AssumedVessel& vessel) { return vessel.name == name; })
                == 0)
                throw InputError("no vessel of this name is assumed", "--remove " + name);
    }

    void set(planner::Case& planned_case, const VesselOptions& options)
    {
        std::vector<Vec3> line;
        for (const std::string& text : options.points)
            line.push_back(parse_point(text, "--points"));
        const auto before = std::ranges::find(planned_case.assumed_vessels, options.set, &planner::AssumedVessel::name);
        if (before == planned_case.assumed_vessels.end()) {
            if (line.empty())
                throw InputError("a new vessel needs its line", "--points");
            planned_case.assumed_vessels.push_back(
                { .name = options.set, .line = std::move(line), .radius_mm = options.radius_mm.value_or(1.0) });
            return;
        }
        if (line.empty() && !options.radius_mm)
            throw InputError("give the line or the radius that is to change", "--points");
        if (!line.empty())
            before->line = std::move(line);
        before->radius_mm = options.radius_mm.value_or(before->radius_mm);
    }

    Outcome change(const VesselOptions& options)
    {
        if (options.set.empty() && (!options.points.empty() || options.radius_mm))
            throw InputError("name the vessel", "--set");
        planner::Case planned_case = open_case(options.case_file);
        if (options.assume)
            assume(planned_case);
        remove(planned_case, options.removed);
        if (!options.set.empty())
            set(planned_case, options);
        if (options.assume || !options.removed.empty() || !options.set.empty())
            planner::write_case(planned_case);
        return list(planned_case);
    }

} // namespace

void add_vessel_command(Commands& commands)
{
    auto options = std::make_shared<VesselOptions>();
    CLI::App* command = commands.app.add_subcommand("vessels",
        "List or set vessels and nerves that no label shows: their places are assumed, and distances to them reported");
    command->footer("Example: retractor vessels C/case.json\n"
                    "Example: retractor vessels C/case.json --assume\n"
                    "Example: retractor vessels C/case.json --set mammary_artery_left --points 22,-105,90 24,-112,40 "
                    "26,-112,-20\n"
                    "Example: retractor vessels C/case.json --remove neurovascular_bundle_left_1");
    command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    command->add_flag("--assume", options->assume,
        "Put mammary arteries, and vessels and nerves under the ribs, where they usually are beside the labelled "
        "bones; "
        "lines of the same names are lost");
    command->add_option("--set", options->set, "Vessel that gets the line or the radius; a new name adds it");
    command
        ->add_option("--points", options->points, "Its line as x,y,z x,y,z ... (mm, patient LPS), two places or more")
        ->expected(2, 1000);
    command->add_option("--radius", options->radius_mm, "Its radius, mm (default: as before; 1 for a new one)")
        ->check(in_range(0.1, planner::kLargestVesselRadiusMm));
    command->add_option("--remove", options->removed, "Vessels that are no longer assumed")->expected(1, 1000);
    commands.on(command, [options](const Job&) { return change(*options); });
}

} // namespace retractor::ui::cli
