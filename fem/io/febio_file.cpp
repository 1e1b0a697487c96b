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

    constexpr int kSteps = 10; // FEBio is nonlinear: the hooks are moved in steps

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

} // namespace

std::string febio_file(const ElasticProblem& problem)
{
    check_problem(problem);
    for (const HookPatch& hook : problem.hooks)
        if (hook.turns())
            throw InputError("FEBio files are written without hooks that turn", "hook '" + hook.name + "'");
    if (!problem.supports.hinges.empty())
        throw InputError(
            "FEBio files are written without hinges of bones", "hinge of " + problem.supports.hinges.front().name);
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
