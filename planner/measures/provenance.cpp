#include "planner/measures/provenance.h"

#include "datasets/dicom/dicom_identity.h"
#include "fem/material/material.h"
#include "mesh/base/text_format.h"
#include "planner/wall/wall_tension.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <ctime>

namespace retractor::planner {

namespace {

    using Json = nlohmann::ordered_json;

    fem::MaterialTable wall_materials(const Case& planned_case)
    {
        fem::MaterialTable used;
        for (const mesh::LabelInfo& info : planned_case.label_table) {
            const auto same = [&](const fem::Material& material) { return material.name == info.material; };
            if (info.role != mesh::Role::wall || std::any_of(used.begin(), used.end(), same))
                continue;
            used.push_back(
                as_solved(fem::find_material(planned_case.materials, info.material), planned_case.solution.element));
        }
        return used;
    }

    std::string supports_text(const SupportSpec& supports)
    {
        std::string text = joined(supports.labels);
        if (supports.region_border)
            text += (text.empty() ? "" : "; ") + std::string("the border of the meshed region");
        return text.empty() ? "none" : text;
    }

    std::string pressures_text(const std::vector<PressureSpec>& pressures)
    {
        std::vector<std::string> each;
        for (const PressureSpec& pressure : pressures)
            each.push_back(pressure.label + " " + in_words(pressure.pressure_kPa, 2) + " kPa");
        return each.empty() ? "none" : joined(each);
    }

    std::string file_text(const FileReference& file)
    {
        constexpr std::size_t kDigits = 16; // these digits tell images apart; metrics.json has all of them
        return file.path.generic_string()
            + (file.sha256.empty() ? std::string() : ", SHA-256 " + file.sha256.substr(0, kDigits) + "...");
    }

    std::string contact_text(ContactMode contact)
    {
        switch (contact) {
        case ContactMode::automatic:
            return "computed where surfaces would pass through each other";
        case ContactMode::always:
            return "computed";
        case ContactMode::never:
            break;
        }
        return "none: surfaces pass through each other";
    }

    Json file_document(const FileReference& file)
    {
        return { { "path", file.path.generic_string() }, { "sha256", file.sha256 } };
    }

} // namespace

std::string utc_text(std::chrono::system_clock::time_point when)
{
    const std::time_t time = std::chrono::system_clock::to_time_t(when);
    std::tm parts {};
    gmtime_r(&time, &parts);
    std::array<char, 32> text {};
    std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
    return text.data();
}

Provenance provenance_of(const Case& planned_case, std::string program, std::chrono::system_clock::time_point when)
{
    Provenance made;
    made.date = utc_text(when);
    made.program = std::move(program);
    // Only the folder's own name is shown, because the path to it may be private.
    const std::filesystem::path file = std::filesystem::absolute(planned_case.file()).lexically_normal();
    made.case_file = (file.parent_path().filename() / file.filename()).generic_string();
    made.identity_in_case = planned_case.patient.has_value();
    if (planned_case.patient)
        made.case_file = datasets::without_identity(made.case_file, { *planned_case.patient });
    made.labels = planned_case.labels;
    made.ct = planned_case.ct;
    made.solution = planned_case.solution;
    made.contact = planned_case.contact;
    made.pressures = planned_case.pressures;
    made.supports = planned_case.supports;
    made.materials = wall_materials(planned_case);
    return made;
}

std::vector<std::pair<std::string, std::string>> provenance_rows(const Provenance& provenance)
{
    std::vector<std::pair<std::string, std::string>> rows {
        { "Computed", provenance.date + ", by " + provenance.program },
        { "Case", provenance.case_file },
        { "Patient",
            provenance.identity_in_case ? "name and id are kept in the case file and not repeated here"
                                        : "the case keeps no name and no id" },
        { "Labels", file_text(provenance.labels) },
        { "CT", provenance.ct ? file_text(*provenance.ct) : "none" },
        { "Solved as", solution_text(provenance.solution) },
        { "Contact of lips and organs", contact_text(provenance.contact) },
        { "Pressure on the wall", pressures_text(provenance.pressures) },
        { "Held at", supports_text(provenance.supports) },
    };
    if (!provenance.stiffness.empty())
        rows.emplace_back("Stiffness in multiples of the case's", provenance.stiffness);
    return rows;
}

std::string law_text(const Provenance& provenance, const fem::Material& material)
{
    return provenance.solution.elasticity == fem::Elasticity::hyperelastic
        ? fem::law_in_words(material)
        : std::string(to_string(provenance.solution.elasticity));
}

nlohmann::ordered_json provenance_document(const Provenance& provenance)
{
    Json json;
    json["date"] = provenance.date;
    json["program"] = provenance.program;
    json["case"] = provenance.case_file;
    json["identity_in_case"] = provenance.identity_in_case;
    json["labels"] = file_document(provenance.labels);
    json["ct"] = provenance.ct ? file_document(*provenance.ct) : Json();
    json["solution"] = { { "elasticity", to_string(provenance.solution.elasticity) },
        { "element", to_string(provenance.solution.element) }, { "near_mm", provenance.solution.near_mm } };
    json["contact"] = to_string(provenance.contact);
    json["pressures"] = Json::array();
    for (const PressureSpec& pressure : provenance.pressures)
        json["pressures"].push_back({ { "label", pressure.label }, { "pressure_kPa", pressure.pressure_kPa } });
    json["supports"]
        = { { "labels", provenance.supports.labels }, { "region_border", provenance.supports.region_border } };
    if (!provenance.stiffness.empty())
        json["stiffness_factors"] = provenance.stiffness;
    json["materials"] = Json::array();
    for (const fem::Material& material : provenance.materials)
        json["materials"].push_back({ { "name", material.name }, { "youngs_modulus_MPa", material.youngs_modulus_MPa },
            { "poissons_ratio", material.poissons_ratio }, { "law", law_text(provenance, material) },
            { "tension", pre_strain_text(material.pre_strain) }, { "source", material.source } });
    return json;
}

} // namespace retractor::planner
