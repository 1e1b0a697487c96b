#include "fem/io/febio_file.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <string_view>
#include <vector>

namespace retractor::fem {

namespace {

    constexpr int kSteps = 10; // FEBio is nonlinear, so the hooks move in steps

    constexpr std::array<const char*, 3> kAxes { "x", "y", "z" };

    std::string number(double value)
    {
        std::array<char, 64> text {};
        const auto end = std::to_chars(text.data(), text.data() + text.size(), value);
        return { text.data(), end.ptr };
    }

    std::string tag(const std::string& name, const std::string& text)
    {
        return "<" + name + ">" + text + "</" + name + ">";
    }

    /// Text as it stands in an attribute or an element of XML.
    std::string xml_escaped(std::string_view text)
    {
        std::string escaped;
        for (const char c : text)
            switch (c) {
            case '&':
                escaped += "&amp;";
                break;
            case '<':
                escaped += "&lt;";
                break;
            case '>':
                escaped += "&gt;";
                break;
            case '"':
                escaped += "&quot;";
                break;
            case '\'':
                escaped += "&apos;";
                break;
            default:
                escaped += c;
            }
        return escaped;
    }

    std::string part(Label label) { return "label" + std::to_string(label); }
    std::string hook_set(std::size_t hook) { return "hook" + std::to_string(hook + 1); }

    using NodesOfStiffness = std::map<double, std::vector<VertexId>>;

    NodesOfStiffness beds(const ElasticProblem& problem)
    {
        NodesOfStiffness beds;
        for (const BeddedVertex& bedded : problem.supports.bedded)
            beds[bedded.stiffness].push_back(bedded.vertex);
        for (auto& [stiffness, nodes] : beds)
            std::sort(nodes.begin(), nodes.end());
        return beds;
    }

    std::string materials_section(const ElasticProblem& problem)
    {
        std::string text = "<Material>\n";
        int id = 0;
        for (const Label label : labels_met(problem.mesh)) {
            const Material& m = problem.material_of_label[label];
            if (m.law)
                throw InputError(
                    "FEBio files are written for neo-Hookean tissue, not " + std::string(law_name(m.law->law)),
                    "material '" + m.name + "'");
            text += "<material id=\"" + std::to_string(++id) + "\" name=\"" + part(label) + ": " + xml_escaped(m.name)
                + "\" type=\"neo-Hookean\">" + tag("density", number(m.density_tonne_per_mm3))
                + tag("E", number(m.youngs_modulus_MPa)) + tag("v", number(m.poissons_ratio)) + "</material>\n";
        }
        return text + "</Material>\n";
    }

    std::string node(std::size_t id, const Vec3& p)
    {
        return "<node id=\"" + std::to_string(id) + "\">" + number(p.x()) + "," + number(p.y()) + "," + number(p.z())
            + "</node>\n";
    }

    std::string elements(const mesh::TetMesh& mesh, Label label)
    {
        std::string text = "<Elements type=\"" + std::string(mesh.nodes_per_tet == 10 ? "tet10" : "tet4") + "\" name=\""
            + part(label) + "\">\n";
        for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
            if (mesh.labels[t] != label)
                continue;
            text += "<elem id=\"" + std::to_string(t + 1) + "\">";
            for (const VertexId v : mesh.tet(static_cast<TetId>(t)))
                text += std::to_string(v + 1) + ",";
            text.back() = '<';
            text += "/elem>\n";
        }
        return text + "</Elements>\n";
    }

    std::string node_set(const std::string& name, const std::vector<std::size_t>& ids)
    {
        std::string text = "<NodeSet name=\"" + name + "\">\n";
        for (std::size_t i = 0; i < ids.size(); ++i)
            text += std::to_string(ids[i]) + (i + 1 < ids.size() ? ",\n" : "\n");
        return text + "</NodeSet>\n";
    }

    std::vector<std::size_t> ids_of(const std::vector<VertexId>& vertices)
    {
        std::vector<std::size_t> ids;
        ids.reserve(vertices.size());
        for (const VertexId v : vertices)
            ids.push_back(static_cast<std::size_t>(v) + 1);
        return ids;
    }

    /// Anchors follow the mesh's nodes: three per bedded vertex, along x, y and z, in the order of beds().
    std::string anchors(const mesh::TetMesh& mesh, const NodesOfStiffness& beds, std::vector<std::size_t>& ids)
    {
        std::string text = "<Nodes name=\"anchors\">\n";
        for (const auto& [stiffness, nodes] : beds)
            for (const VertexId v : nodes)
                for (Eigen::Index axis = 0; axis < 3; ++axis) {
                    ids.push_back(mesh.vertex_count() + ids.size() + 1);
                    Vec3 p = mesh.vertices.row(v).transpose();
                    p[axis] += kFebioAnchorMm;
                    text += node(ids.back(), p);
                }
        return text + "</Nodes>\n";
    }

    std::string springs(const mesh::TetMesh& mesh, const NodesOfStiffness& beds)
    {
        std::string text;
        std::size_t anchor = mesh.vertex_count();
        int set = 0;
        for (const auto& [stiffness, nodes] : beds) {
            text += "<DiscreteSet name=\"bed" + std::to_string(++set) + "\">\n";
            for (const VertexId v : nodes)
                for (std::size_t axis = 0; axis < kAxes.size(); ++axis)
                    text += "<delem>" + std::to_string(v + 1) + "," + std::to_string(++anchor) + "</delem>\n";
            text += "</DiscreteSet>\n";
        }
        return text;
    }

    std::string mesh_section(const ElasticProblem& problem, const NodesOfStiffness& beds)
    {
        const mesh::TetMesh& mesh = problem.mesh;
        std::string text = "<Mesh>\n<Nodes name=\"wall\">\n";
        for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
            text += node(v + 1, mesh.vertices.row(static_cast<Eigen::Index>(v)).transpose());
        text += "</Nodes>\n";
        std::vector<std::size_t> anchor_ids;
        if (!beds.empty())
            text += anchors(mesh, beds, anchor_ids);
        for (const Label label : labels_met(mesh))
            text += elements(mesh, label);
        if (!problem.supports.fixed.empty())
            text += node_set("fixed", ids_of(problem.supports.fixed));
        if (!anchor_ids.empty())
            text += node_set("anchors", anchor_ids);
        for (std::size_t h = 0; h < problem.hooks.size(); ++h)
            text += node_set(hook_set(h), ids_of(problem.hooks[h].nodes));
        return text + springs(mesh, beds) + "</Mesh>\n";
    }

    std::string zero_displacement(const std::string& set)
    {
        return "<bc name=\"" + set + "\" node_set=\"" + set
            + "\" type=\"zero displacement\"><x_dof>1</x_dof><y_dof>1</y_dof><z_dof>1</z_dof></bc>\n";
    }

    std::string boundary_section(const ElasticProblem& problem, bool bedded)
    {
        std::string text = "<Boundary>\n";
        if (!problem.supports.fixed.empty())
            text += zero_displacement("fixed");
        if (bedded)
            text += zero_displacement("anchors");
        for (std::size_t h = 0; h < problem.hooks.size(); ++h)
            for (std::size_t axis = 0; axis < kAxes.size(); ++axis)
                text += "<bc name=\"" + xml_escaped(problem.hooks[h].name) + "\" node_set=\"" + hook_set(h)
                    + "\" type=\"prescribed displacement\">" + tag("dof", kAxes[axis]) + "<value lc=\"1\">"
                    + number(problem.hooks[h].displacement[static_cast<Eigen::Index>(axis)])
                    + "</value><relative>0</relative></bc>\n";
        return text + "</Boundary>\n";
    }

    std::string discrete_section(const NodesOfStiffness& beds)
    {
        if (beds.empty())
            return {};
        std::string text = "<Discrete>\n";
        int set = 0;
        for (const auto& [stiffness, nodes] : beds) {
            const std::string id = std::to_string(++set);
            text += "<discrete_material id=\"" + id + "\" name=\"bed" + id + "\" type=\"linear spring\">"
                + tag("E", number(stiffness)) + "</discrete_material>\n";
        }
        for (int i = 1; i <= set; ++i)
            text += "<discrete dmat=\"" + std::to_string(i) + "\" discrete_set=\"bed" + std::to_string(i) + "\"/>\n";
        return text + "</Discrete>\n";
    }

    // Reading.

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

    void read_materials(const XmlElement& section, ElasticProblem& problem)
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

    /// Reads the hooks. A hook is three consecutive conditions on one node set.
    void read_boundary(const XmlElement& section, const XmlElement& mesh_section, ElasticProblem& problem)
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

    void read_beds(const XmlElement& root, const XmlElement& mesh_section, ElasticProblem& problem)
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

    Supports sorted(Supports supports)
    {
        std::sort(supports.bedded.begin(), supports.bedded.end(),
            [](const BeddedVertex& a, const BeddedVertex& b) { return a.vertex < b.vertex; });
        return supports;
    }

    bool same_elastic(const Material& a, const Material& b)
    {
        return a.name == b.name && a.youngs_modulus_MPa == b.youngs_modulus_MPa && a.poissons_ratio == b.poissons_ratio
            && a.density_tonne_per_mm3 == b.density_tonne_per_mm3;
    }

} // namespace

std::string febio_file(const ElasticProblem& problem)
{
    check_problem(problem);
    if (!problem.pressures.empty())
        throw InputError("FEBio files are written without pressure", "pressure of " + problem.pressures.front().name);
    if (!problem.loads.empty())
        throw InputError("FEBio files are written without loads: a tension that the cut set free is one", "loads");
    const NodesOfStiffness bedded = beds(problem);
    std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- opened wound; units mm, N, MPa; frame patient "
                       "LPS -->\n<febio_spec version=\"4.0\">\n<Module type=\"solid\"/>\n<Control>"
        + tag("analysis", "STATIC") + tag("time_steps", std::to_string(kSteps)) + tag("step_size", number(1.0 / kSteps))
        + "<solver type=\"solid\">" + tag("symmetric_stiffness", "symmetric") + "</solver></Control>\n";
    text += materials_section(problem) + mesh_section(problem, bedded) + "<MeshDomains>\n";
    for (const Label label : labels_met(problem.mesh))
        text += "<SolidDomain name=\"" + part(label) + "\" mat=\"" + part(label) + ": "
            + xml_escaped(problem.material_of_label[label].name) + "\"/>\n";
    text += "</MeshDomains>\n" + boundary_section(problem, !bedded.empty()) + discrete_section(bedded)
        + "<LoadData><load_controller id=\"1\" name=\"ramp\" type=\"loadcurve\"><interpolate>LINEAR</interpolate>"
          "<extend>CONSTANT</extend><points><pt>0,0</pt><pt>1,1</pt></points></load_controller></LoadData>\n"
          "<Output><plotfile type=\"febio\"><var type=\"displacement\"/><var type=\"stress\"/>"
          "<var type=\"reaction forces\"/></plotfile><logfile><node_data data=\"ux;uy;uz;Rx;Ry;Rz\" delim=\",\" "
          "file=\"nodes.csv\"/></logfile></Output>\n</febio_spec>\n";
    return text;
}

} // namespace retractor::fem
