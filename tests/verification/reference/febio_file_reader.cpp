#include "tests/verification/reference/febio_file_reader.h"

#include "mesh/base/error.h"
#include "tests/verification/reference/xml_element.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace retractor::verification {

namespace {

    constexpr std::array<const char*, 3> kAxes { "x", "y", "z" };

    std::string place(const XmlElement& element)
    {
        return "<" + element.name + "> in line " + std::to_string(element.line);
    }

    template <class Number> Number parsed(std::string_view word, const XmlElement& element)
    {
        const std::size_t begin = word.find_first_not_of(" \t\r\n");
        const std::size_t end = word.find_last_not_of(" \t\r\n");
        word = begin == std::string_view::npos ? std::string_view() : word.substr(begin, end - begin + 1);
        Number value {};
        const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc() || stop != word.data() + word.size())
            throw InputError("\"" + std::string(word.substr(0, 40)) + "\" is not a number", place(element));
        return value;
    }

    template <class Number> std::vector<Number> list(const XmlElement& element)
    {
        std::vector<Number> values;
        for (std::string_view rest = element.text;;) {
            const std::size_t comma = rest.find(',');
            values.push_back(parsed<Number>(rest.substr(0, comma), element));
            if (comma == std::string_view::npos)
                return values;
            rest.remove_prefix(comma + 1);
        }
    }

    VertexId vertex(std::int64_t id, std::size_t vertices, const XmlElement& element)
    {
        if (id < 1 || static_cast<std::size_t>(id) > vertices)
            throw InputError("there is no node " + std::to_string(id), place(element));
        return static_cast<VertexId>(id - 1);
    }

    std::vector<VertexId> vertices_of(const XmlElement& element, std::size_t vertices)
    {
        std::vector<VertexId> all;
        for (const std::int64_t id : list<std::int64_t>(element))
            all.push_back(vertex(id, vertices, element));
        return all;
    }

    const XmlElement& named(const XmlElement& section, const std::string& kind, const std::string& name)
    {
        for (const XmlElement* one : section.all(kind))
            if (one->attribute("name") == name)
                return *one;
        throw InputError("there is no <" + kind + "> with the name " + name, place(section));
    }

    Label label_of(const std::string& name, const XmlElement& element)
    {
        constexpr std::string_view kPrefix = "label";
        const std::string_view digits = std::string_view(name).substr(std::min(kPrefix.size(), name.size()));
        if (!name.starts_with(kPrefix))
            throw InputError("\"" + name + "\" is not the name of a label's part", place(element));
        return parsed<Label>(digits.substr(0, digits.find(':')), element);
    }

    void read_nodes(const XmlElement& mesh_section, mesh::TetMesh& mesh)
    {
        const auto nodes = named(mesh_section, "Nodes", "wall").all("node");
        mesh.vertices.resize(static_cast<Eigen::Index>(nodes.size()), 3);
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const std::vector<double> p = list<double>(*nodes[i]);
            if (p.size() != 3 || parsed<std::size_t>(nodes[i]->attribute("id"), *nodes[i]) != i + 1)
                throw InputError("nodes must be numbered from 1, with three coordinates", place(*nodes[i]));
            mesh.vertices.row(static_cast<Eigen::Index>(i)) << p[0], p[1], p[2];
        }
    }

    void read_elements(const XmlElement& mesh_section, mesh::TetMesh& mesh)
    {
        const auto parts = mesh_section.all("Elements");
        std::size_t count = 0;
        for (const XmlElement* one : parts)
            count += one->children.size();
        if (parts.empty() || count == 0)
            throw InputError("there are no elements", place(mesh_section));
        mesh.nodes_per_tet = parts.front()->attribute("type") == "tet10" ? 10 : 4;
        const auto per_tet = static_cast<std::size_t>(mesh.nodes_per_tet);
        mesh.nodes.assign(count * per_tet, -1);
        mesh.labels.assign(count, 0);
        for (const XmlElement* one : parts) {
            if (one->attribute("type") != (per_tet == 10 ? "tet10" : "tet4"))
                throw InputError("elements must be all tet4 or all tet10", place(*one));
            const Label label = label_of(one->attribute("name"), *one);
            for (const XmlElement& elem : one->children) {
                const auto id = parsed<std::size_t>(elem.attribute("id"), elem);
                const std::vector<VertexId> nodes = vertices_of(elem, mesh.vertex_count());
                if (id < 1 || id > count || nodes.size() != per_tet || mesh.nodes[(id - 1) * per_tet] >= 0)
                    throw InputError("elements must be numbered once each, with all their nodes", place(elem));
                std::copy(
                    nodes.begin(), nodes.end(), mesh.nodes.begin() + static_cast<std::ptrdiff_t>((id - 1) * per_tet));
                mesh.labels[id - 1] = label;
            }
        }
    }

    void read_materials(const XmlElement& section, fem::ElasticProblem& problem)
    {
        for (const XmlElement* one : section.all("material")) {
            if (one->attribute("type") != "neo-Hookean")
                throw InputError("the material is not neo-Hookean", place(*one));
            const std::string& name = one->attribute("name");
            const Label label = label_of(name, *one);
            if (problem.material_of_label.size() <= label)
                problem.material_of_label.resize(static_cast<std::size_t>(label) + 1);
            const std::size_t colon = name.find(": ");
            problem.material_of_label[label] = { .name = colon == std::string::npos ? "" : name.substr(colon + 2),
                .youngs_modulus_MPa = parsed<double>(one->child("E").text, *one),
                .poissons_ratio = parsed<double>(one->child("v").text, *one),
                .density_tonne_per_mm3 = parsed<double>(one->child("density").text, *one),
                .source = {} };
        }
    }

    /// Hooks are three conditions in a row on one node set.
    void read_boundary(const XmlElement& section, const XmlElement& mesh_section, fem::ElasticProblem& problem)
    {
        std::map<std::string, std::size_t> hook_of_set;
        for (const XmlElement* bc : section.all("bc")) {
            const std::string& set = bc->attribute("node_set");
            if (bc->attribute("type") == "zero displacement") {
                if (set == "fixed")
                    problem.supports.fixed
                        = vertices_of(named(mesh_section, "NodeSet", set), problem.mesh.vertex_count());
                continue;
            }
            if (bc->attribute("type") != "prescribed displacement")
                throw InputError("a condition of another kind", place(*bc));
            const auto [hook, is_new] = hook_of_set.emplace(set, problem.hooks.size());
            if (is_new)
                problem.hooks.push_back({ .name = bc->attribute("name"),
                    .side = 0,
                    .nodes = vertices_of(named(mesh_section, "NodeSet", set), problem.mesh.vertex_count()) });
            const auto axis = std::find(kAxes.begin(), kAxes.end(), bc->child("dof").text) - kAxes.begin();
            if (axis == static_cast<std::ptrdiff_t>(kAxes.size()))
                throw InputError("a direction that is none of x, y, z", place(*bc));
            problem.hooks[hook->second].displacement[axis] = parsed<double>(bc->child("value").text, *bc);
        }
    }

    void read_beds(const XmlElement& root, const XmlElement& mesh_section, fem::ElasticProblem& problem)
    {
        const auto sections = root.all("Discrete");
        if (sections.empty())
            return;
        std::map<VertexId, std::pair<double, int>> bed; // stiffness and number of springs
        for (const XmlElement* discrete : sections.front()->all("discrete")) {
            double stiffness = 0.0;
            for (const XmlElement* material : sections.front()->all("discrete_material"))
                if (material->attribute("id") == discrete->attribute("dmat"))
                    stiffness = parsed<double>(material->child("E").text, *material);
            for (const XmlElement* spring :
                named(mesh_section, "DiscreteSet", discrete->attribute("discrete_set")).all("delem")) {
                auto& [k, springs]
                    = bed[vertex(list<std::int64_t>(*spring).front(), problem.mesh.vertex_count(), *spring)];
                k = stiffness;
                ++springs;
            }
        }
        for (const auto& [v, spring] : bed) {
            if (spring.second != 3)
                throw InputError(
                    "node " + std::to_string(v + 1) + " does not hang on three springs", place(*sections.front()));
            problem.supports.bedded.push_back({ v, spring.first });
        }
    }

    fem::Supports sorted(fem::Supports supports)
    {
        std::sort(supports.bedded.begin(), supports.bedded.end(),
            [](const fem::BeddedVertex& a, const fem::BeddedVertex& b) { return a.vertex < b.vertex; });
        return supports;
    }

    bool same_elastic(const fem::Material& a, const fem::Material& b)
    {
        return a.name == b.name && a.youngs_modulus_MPa == b.youngs_modulus_MPa && a.poissons_ratio == b.poissons_ratio
            && a.density_tonne_per_mm3 == b.density_tonne_per_mm3;
    }

} // namespace

fem::ElasticProblem read_febio_file(std::string_view text)
{
    const XmlElement root = parse_xml(text);
    if (root.name != "febio_spec" || root.attribute("version") != "4.0")
        throw InputError("this is no FEBio file of version 4.0", place(root));
    fem::ElasticProblem problem;
    const XmlElement& mesh_section = root.child("Mesh");
    read_nodes(mesh_section, problem.mesh);
    read_elements(mesh_section, problem.mesh);
    read_materials(root.child("Material"), problem);
    read_boundary(root.child("Boundary"), mesh_section, problem);
    read_beds(root, mesh_section, problem);
    fem::check_problem(problem);
    return problem;
}

std::string first_difference(const fem::ElasticProblem& a, const fem::ElasticProblem& b)
{
    if (a.mesh.vertices.rows() != b.mesh.vertices.rows() || a.mesh.vertices != b.mesh.vertices)
        return "the vertices differ";
    if (a.mesh.nodes_per_tet != b.mesh.nodes_per_tet || a.mesh.nodes != b.mesh.nodes)
        return "the elements differ";
    if (a.mesh.labels != b.mesh.labels)
        return "the labels differ";
    for (const Label label : fem::labels_met(a.mesh))
        if (!same_elastic(a.material_of_label.at(label), b.material_of_label.at(label)))
            return "the materials of label " + std::to_string(label) + " differ";
    if (a.supports.fixed != b.supports.fixed)
        return "the fixed nodes differ";
    const fem::Supports left = sorted(a.supports), right = sorted(b.supports);
    if (!std::equal(left.bedded.begin(), left.bedded.end(), right.bedded.begin(), right.bedded.end(),
            [](const fem::BeddedVertex& x, const fem::BeddedVertex& y) {
                return x.vertex == y.vertex && x.stiffness == y.stiffness;
            }))
        return "the beds differ";
    if (!std::equal(a.hooks.begin(), a.hooks.end(), b.hooks.begin(), b.hooks.end(),
            [](const fem::HookPatch& x, const fem::HookPatch& y) {
                return x.name == y.name && x.nodes == y.nodes && x.displacement == y.displacement;
            }))
        return "the hooks differ";
    return {};
}

} // namespace retractor::verification
