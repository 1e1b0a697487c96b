#include "planner/case/case.h"

#include "fem/model/pre_strain.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/image/skeleton.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace retractor::planner {

namespace {

    void check_label_name(const Case& planned_case, const std::string& name, const std::string& where)
    {
        if (mesh::find_label(planned_case.label_table, name) == nullptr)
            throw InputError("there is no label \"" + name + "\" in the label table", where);
    }

    void check_label_names(const Case& planned_case, const std::vector<std::string>& names, const std::string& where)
    {
        for (std::size_t n = 0; n < names.size(); ++n)
            check_label_name(planned_case, names[n], where + "/" + std::to_string(n));
    }

    void check_approach_in_case(const Case& planned_case, const Approach& approach, const std::string& pointer)
    {
        check_approach(approach, pointer);
        if (!approach.target.is_sphere())
            check_label_name(planned_case, approach.target.label, pointer + "/target/label");
        check_label_names(planned_case, approach.retracted, pointer + "/retracted");
        check_label_names(planned_case, approach.uncut_labels, pointer + "/uncut_labels");
        for (std::size_t n = 0; n < approach.ablations.size(); ++n) {
            const std::string where = pointer + "/ablations/" + std::to_string(n) + "/label";
            const std::string& label = approach.ablations[n].label;
            if (label.empty())
                continue;
            check_label_name(planned_case, label, where);
            if (mesh::find_label(planned_case.label_table, label)->role != mesh::Role::wall)
                throw InputError("only tissue of the wall can be removed, and \"" + label + "\" is none", where);
        }
    }

    void check_labels(const Case& planned_case)
    {
        if (planned_case.label_table.empty())
            throw InputError("the label table is empty", "/labels/table");
        std::set<Label> ids;
        std::set<std::string> names;
        for (std::size_t n = 0; n < planned_case.label_table.size(); ++n) {
            const mesh::LabelInfo& info = planned_case.label_table[n];
            const std::string where = "/labels/table/" + std::to_string(n);
            if (info.id == 0)
                throw InputError("label 0 is \"nothing\" and cannot be named", where + "/id");
            if (!ids.insert(info.id).second)
                throw InputError("label " + std::to_string(info.id) + " is named twice", where + "/id");
            if (info.name.empty() || !names.insert(info.name).second)
                throw InputError("label names must be present and different: \"" + info.name + "\"", where + "/name");
            const auto known = [&](const fem::Material& m) { return m.name == info.material; };
            if (info.role == mesh::Role::wall
                && std::none_of(planned_case.materials.begin(), planned_case.materials.end(), known))
                throw InputError(
                    "there is no material \"" + info.material + "\" in the material table", where + "/material");
        }
    }

    void check_materials(const Case& planned_case)
    {
        std::set<std::string> names;
        for (std::size_t n = 0; n < planned_case.materials.size(); ++n) {
            const std::string where = "/materials/" + std::to_string(n);
            const fem::Material& material = planned_case.materials[n];
            if (material.name.empty() || !names.insert(material.name).second)
                throw InputError(
                    "material names must be present and different: \"" + material.name + "\"", where + "/name");
            if (!(material.youngs_modulus_MPa > 0.0 && std::isfinite(material.youngs_modulus_MPa)))
                throw InputError("must be positive and finite", where + "/youngs_modulus_MPa");
            if (!(material.poissons_ratio > -1.0 && material.poissons_ratio < 0.5))
                throw InputError("must be above -1 and below 0.5", where + "/poissons_ratio");
            if (!(material.density_tonne_per_mm3 > 0.0 && material.density_tonne_per_mm3 < 1.0))
                throw InputError("must be positive and finite", where + "/density_tonne_per_mm3");
            try {
                fem::check_material(material);
            } catch (const InputError& error) {
                throw InputError(error.what(), where + "/law");
            }
            try {
                fem::check_pre_strain(material.pre_strain);
            } catch (const InputError& error) {
                throw InputError(
                    "material \"" + material.name + "\": " + error.what(), where + "/pre_strain/" + error.where());
            }
        }
    }

    void check_reference(const FileReference& file, const std::string& where)
    {
        if (file.path.empty() || file.path.is_absolute())
            throw InputError("must be a path relative to the case folder", where + "/path");
        if (*file.path.lexically_normal().begin() == "..")
            throw InputError("must lie inside the case folder, so that the folder can be handed on", where + "/path");
        const auto hexadecimal = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
        if (file.sha256.size() != 64 || !std::all_of(file.sha256.begin(), file.sha256.end(), hexadecimal))
            throw InputError("must be 64 lower-case hexadecimal digits", where + "/sha256");
    }

} // namespace

bool has_soft_wall(const mesh::LabelTable& table)
{
    return std::any_of(table.begin(), table.end(),
        [](const mesh::LabelInfo& info) { return info.role == mesh::Role::wall && !mesh::is_skeleton(info); });
}

std::vector<fem::Material> materials_as_solved(const Case& planned_case, ElementKind element)
{
    std::vector<fem::Material> materials;
    for (const mesh::LabelInfo& info : planned_case.label_table) {
        if (materials.size() <= info.id)
            materials.resize(static_cast<std::size_t>(info.id) + 1);
        if (info.role == mesh::Role::wall)
            materials[info.id] = as_solved(fem::find_material(planned_case.materials, info.material), element);
    }
    return materials;
}

std::vector<fem::Material> materials_as_solved(const Case& planned_case)
{
    return materials_as_solved(planned_case, planned_case.solution.element);
}

const Approach& find_approach(const Case& planned_case, std::string_view name)
{
    std::vector<std::string> known;
    for (const Approach& approach : planned_case.approaches) {
        if (approach.name == name)
            return approach;
        known.push_back(approach.name);
    }
    throw InputError(
        "there is no approach \"" + std::string(name) + "\"; the case has: " + (known.empty() ? "none" : joined(known)),
        "/approaches");
}

Approach& find_approach(Case& planned_case, std::string_view name)
{
    return const_cast<Approach&>(find_approach(static_cast<const Case&>(planned_case), name));
}

void add_approach(Case& planned_case, Approach approach)
{
    const std::string where = "/approaches/" + std::to_string(planned_case.approaches.size());
    check_approach_in_case(planned_case, approach, where);
    for (const Approach& other : planned_case.approaches)
        if (other.name == approach.name)
            throw InputError(
                "there is already an approach \"" + approach.name + "\": remove it first or give another name",
                where + "/name");
    planned_case.approaches.push_back(std::move(approach));
}

void remove_approach(Case& planned_case, std::string_view name)
{
    const Approach& approach = find_approach(planned_case, name);
    planned_case.approaches.erase(planned_case.approaches.begin() + (&approach - planned_case.approaches.data()));
}

bool under_pressure(const Case& planned_case)
{
    return std::any_of(planned_case.pressures.begin(), planned_case.pressures.end(),
        [](const PressureSpec& spec) { return spec.pressure_kPa != 0.0; });
}

void check_pressures(const Case& planned_case)
{
    std::set<std::string> labels;
    for (std::size_t i = 0; i < planned_case.pressures.size(); ++i) {
        const PressureSpec& spec = planned_case.pressures[i];
        const std::string where = "/pressures/" + std::to_string(i);
        const mesh::LabelInfo* info = mesh::find_label(planned_case.label_table, spec.label);
        if (info == nullptr)
            throw InputError("there is no label \"" + spec.label + "\"", where + "/label");
        if (info->role == mesh::Role::wall)
            throw InputError("the label \"" + spec.label
                    + "\" belongs to the wall: pressure acts from a label that borders on the wall, such as a cavity "
                      "or a lumen",
                where + "/label");
        if (!labels.insert(spec.label).second)
            throw InputError("the label \"" + spec.label + "\" is listed twice", where + "/label");
        if (!(spec.pressure_kPa >= -kMostSuctionKPa && spec.pressure_kPa <= kMostPressureKPa)) // refuses NaN too
            throw InputError("the pressure of \"" + spec.label + "\" must be between " + in_words(-kMostSuctionKPa)
                    + " (suction) and " + in_words(kMostPressureKPa) + " kPa",
                where + "/pressure_kPa");
    }
    if (under_pressure(planned_case) && planned_case.solution.near_mm > 0.0)
        throw InputError(
            "pressure acts on the whole wall, but the tissue beyond near_mm is condensed without pressure: remove "
            "the pressures or near_mm",
            "/solution/near_mm, pressures", { "near_mm", "pressures" });
}

bool is_estimated(const Case& planned_case, std::string_view label)
{
    const std::vector<std::string>& estimated = planned_case.estimated_labels;
    return std::find(estimated.begin(), estimated.end(), label) != estimated.end();
}

namespace {

    void check_assumed_vessels(const Case& planned_case)
    {
        std::set<std::string> names;
        for (std::size_t n = 0; n < planned_case.assumed_vessels.size(); ++n) {
            const AssumedVessel& vessel = planned_case.assumed_vessels[n];
            const std::string where = "/assumed_vessels/" + std::to_string(n);
            if (vessel.name.empty())
                throw InputError("an assumed vessel needs a name", where + "/name");
            if (mesh::find_label(planned_case.label_table, vessel.name) != nullptr)
                throw InputError(
                    "\"" + vessel.name + "\" is a label: a vessel is either seen or assumed", where + "/name");
            if (!names.insert(vessel.name).second)
                throw InputError("two assumed vessels are named \"" + vessel.name + "\"", where + "/name");
            if (vessel.line.size() < 2)
                throw InputError("the line of an assumed vessel needs two points or more", where + "/line_mm");
            if (!std::ranges::all_of(vessel.line, [](const Vec3& p) { return p.allFinite(); }))
                throw InputError("the line of an assumed vessel must be finite", where + "/line_mm");
            if (!(vessel.radius_mm > 0.0 && vessel.radius_mm <= kLargestVesselRadiusMm))
                throw InputError("the radius of an assumed vessel must be above 0, and "
                        + in_words(kLargestVesselRadiusMm) + " mm at most",
                    where + "/radius_mm");
        }
    }

} // namespace

void check_case(const Case& planned_case)
{
    if (planned_case.ct)
        check_reference(*planned_case.ct, "/ct");
    check_reference(planned_case.labels, "/labels");
    check_materials(planned_case);
    check_labels(planned_case);
    check_label_names(planned_case, planned_case.supports.labels, "/supports/labels");
    check_label_names(planned_case, planned_case.estimated_labels, "/labels/estimated");
    check_assumed_vessels(planned_case);
    check_sizing(planned_case.sizing, "/sizing");
    check_solution(planned_case.solution, planned_case.contact);
    check_pressures(planned_case);
    std::set<std::string> names;
    for (std::size_t n = 0; n < planned_case.approaches.size(); ++n) {
        const std::string where = "/approaches/" + std::to_string(n);
        check_approach_in_case(planned_case, planned_case.approaches[n], where);
        if (!names.insert(planned_case.approaches[n].name).second)
            throw InputError("two approaches are named \"" + planned_case.approaches[n].name + "\"", where + "/name");
    }
    for (std::size_t n = 0; n < planned_case.views.size(); ++n)
        if (std::find(std::begin(kViewNames), std::end(kViewNames), planned_case.views[n]) == std::end(kViewNames))
            throw InputError("unknown view \"" + planned_case.views[n] + "\": use surgeon, overview or slices",
                "/views/" + std::to_string(n));
}

} // namespace retractor::planner
