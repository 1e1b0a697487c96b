#include "ui/cli/commands.h"

#include "datasets/phantoms/palpation_scene_file.h"
#include "mesh/base/error.h"
#include "planner/case/patient.h"
#include "planner/palpation/palpable.h"
#include "ui/cli/framework/arguments.h"
#include "ui/cli/framework/number_range.h"
#include "ui/cli/framework/open_case.h"
#include "ui/cli/framework/out_folder.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>

namespace retractor::ui::cli {

namespace {

    struct PalpableOptions {
        std::string case_file, structure, out, held;
        std::vector<std::string> stiff, sites;
        planner::PalpableRequest request;
        double heart_rate = 75.0;
        std::string pressure = "80,120";
    };

    /// Splits "TEXT=REST".
    std::pair<std::string, std::string> halves(const std::string& text, const char* where, const char* example)
    {
        const std::size_t at = text.rfind('=');
        if (at == std::string::npos || at == 0)
            throw InputError(std::string("is written ") + example + ": \"" + text + '"', where);
        return { text.substr(0, at), text.substr(at + 1) };
    }

    planner::PalpableRequest request_of(const PalpableOptions& options)
    {
        planner::PalpableRequest request = options.request;
        request.structure = split(options.structure, '+');
        if (!options.held.empty())
            request.held = split(options.held, ',');
        for (const std::string& text : options.stiff) {
            const auto [where, modulus] = halves(text, "--stiff", "LABEL=MPA or x,y,z,r=MPA");
            request.stiff.push_back({ parse_target(where), parse_numbers(modulus, 1, "--stiff")[0] });
        }
        for (const std::string& text : options.sites) {
            const auto [name, point] = halves(text, "--site", "NAME=x,y,z");
            request.sites.emplace_back(name, parse_point(point, "--site"));
        }
        return request;
    }

    /// Diastolic and systolic pressure, mmHg.
    std::vector<double> pressures_of(const PalpableOptions& options)
    {
        std::vector<double> pressures = parse_numbers(options.pressure, 2, "--pressure");
        if (!(pressures[0] >= 0.0 && pressures[1] > pressures[0] && pressures[1] <= 400.0))
            throw InputError("is DIASTOLIC,SYSTOLIC in mmHg, such as 80,120", "--pressure");
        return pressures;
    }

    void set_pulse(
        datasets::PalpationScene& scene, const std::vector<double>& pressures, const PalpableOptions& options)
    {
        scene.diastolic_mmHg = scene.rest_mmHg = pressures[0];
        scene.systolic_mmHg = pressures[1];
        scene.heart_rate_per_min = options.heart_rate;
    }

    /// Makes a file name from a name: "aorta and heart".
    std::string file_stem(std::string name)
    {
        std::replace_if(
            name.begin(), name.end(), [](char c) { return c == ' ' || c == '/' || c == '\\' || c == '.'; }, '_');
        return name;
    }

    Outcome make_palpable_scene(const PalpableOptions& options, const Job& job)
    {
        const planner::PalpableRequest request = request_of(options);
        const std::vector<double> pressures = pressures_of(options);
        job.report("read case", 0.0);
        planner::Patient patient(open_case(options.case_file), job);
        if (request.structure.empty())
            throw InputError("is missing: name the structure to palpate; there are "
                    + planner::names_of(patient.planned_case().label_table),
                "--structure");
        const std::filesystem::path case_file = patient.planned_case().file();
        make_folder(options.out);
        planner::Palpable made = planner::make_palpable(patient, request, job);
        set_pulse(made.scene, pressures, options);
        const std::filesystem::path file = std::filesystem::path(options.out) / (file_stem(made.scene.name) + ".json");
        if (std::error_code none; std::filesystem::equivalent(file, case_file, none))
            throw InputError("the scene would overwrite the case file: name another folder", "--out");
        datasets::write_palpation_scene(file, made.scene);
        const bool hollow = datasets::has_inner_wall(made.scene.body);
        Outcome outcome;
        outcome.document = { { "scene", file.string() }, { "frame", "LPS" },
            { "vertices", made.scene.body.mesh.vertex_count() }, { "tets", made.scene.body.mesh.tet_count() },
            { "hollow", hollow }, { "sites", Json::array() }, { "notes", made.notes } };
        std::string sites;
        for (const datasets::TouchSite& site : made.scene.sites) {
            outcome.document["sites"].push_back(site.name);
            sites += (sites.empty() ? "" : ", ") + site.name;
        }
        for (const std::string& note : made.notes)
            outcome.text += note + "\n";
        outcome.text += std::to_string(made.scene.body.mesh.vertex_count()) + " vertices, "
            + std::to_string(made.scene.body.mesh.tet_count()) + " tetrahedra; places to press: " + sites
            + "\nscene: " + file.string() + "\n";
        return outcome;
    }

} // namespace

void add_palpable_command(Commands& commands)
{
    auto options = std::make_shared<PalpableOptions>();
    CLI::App* command = commands.app.add_subcommand(
        "palpable", "Prepare a structure of a case for palpation: a vessel under blood pressure, or a solid organ");
    command->footer("Example: retractor palpable patient/case.json --structure aorta --out A && retractor palpate "
                    "A/aorta.json --press front --out forces.csv\n"
                    "         retractor palpable patient/case.json --structure aorta --stiff 20,-30,110,12=3 --held "
                    "heart,spine,border --out A\n"
                    "         retractor palpable patient/case.json --structure liver+stomach --out A");
    command->add_option("case", options->case_file, "case.json, or the folder it lies in")->required();
    command->add_option("--structure", options->structure,
        "Label of the structure to palpate. NAME+NAME takes several: vessels become one body, solid organs touch each "
        "other. Without this option, the error message lists the labels of the case");
    command->add_option("--out", options->out, "Folder to write to")->required();
    command->add_option("--wall", options->request.wall_mm,
        "Thickness of the wall of a hollow structure, in mm, measured inwards from its outline; 0 makes it solid "
        "(default: 2 for vessels, 0 for others)");
    command->add_option("--edge", options->request.edge_mm,
        "Edge length of the elements, in mm (default: 5 for a wall, a tenth of its size for a solid)");
    command->add_option("--held", options->held,
        "Where the structure is held, NAME,...: a label beside the structure, border (where the image cuts the "
        "structure off), a side and a depth in mm (head:10, foot:10, front:, back:, left:, right:), or ends:20 (the "
        "two ends of a vessel) (default: border,heart,spine,ends:20 for a wall; border,back:12 for a solid)");
    command->add_option("--young", options->request.youngs_modulus_MPa,
        "Young's modulus, MPa (default: from the material in the case)");
    command->add_option(
        "--poisson", options->request.poissons_ratio, "Poisson's ratio (default: from the material in the case)");
    command->add_option("--stiff", options->stiff,
        "Region with another stiffness, LABEL=MPA or x,y,z,r=MPA (mm, patient LPS); its site to press is stiff-1, ...; "
        "repeatable");
    command->add_option("--site", options->sites,
        "Additional site to press, NAME=x,y,z; the site is the nearest point of the surface; repeatable");
    command->add_option("--pressure", options->pressure, "Blood pressure in vessels, DIASTOLIC,SYSTOLIC, mmHg")
        ->capture_default_str();
    command->add_option("--heart-rate", options->heart_rate, "Heart rate for vessels, beats per minute")
        ->check(in_range(20.0, 300.0))
        ->capture_default_str();
    commands.on(command, [options](const Job& job) { return make_palpable_scene(*options, job); });
}

} // namespace retractor::ui::cli
