#include "tests/verification/reference/febio_reference.h"

#include "fem/material/material.h"
#include "mesh/base/error.h"
#include "tests/verification/framework/number_list.h"
#include "tests/verification/reference/xml_element.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

namespace retractor::verification {

namespace {

    using Tag = XmlElement;

    class Model {
    public:
        Model(const Tag& root, std::string file)
            : root_(root)
            , file_(std::move(file))
        {
        }

        const Tag& child(const Tag& of, const std::string& name) const
        {
            for (const Tag& tag : of.children)
                if (tag.name == name)
                    return tag;
            throw IoError("<" + of.name + "> has no <" + name + ">", file_);
        }
        const Tag& section(const std::string& name) const { return child(root_, name); }
        double number(const Tag& of, const std::string& name) const
        {
            const std::vector<double> values = number_list(child(of, name).text);
            if (values.size() != 1)
                throw IoError("<" + name + "> is not one number", file_);
            return values[0];
        }
        std::string attribute(const Tag& tag, const std::string& name) const
        {
            const auto at = tag.attributes.find(name);
            if (at == tag.attributes.end())
                throw IoError("<" + tag.name + "> has no " + name, file_);
            return at->second;
        }
        const Tag& named(const std::string& kind, const std::string& name) const
        {
            for (const Tag& tag : section("Mesh").children)
                if (tag.name == kind && attribute(tag, "name") == name)
                    return tag;
            throw IoError("there is no " + kind + " '" + name + "'", file_);
        }
        VertexId vertex(double number) const
        {
            const auto at = id_.find(static_cast<int>(number));
            if (at == id_.end())
                throw IoError("there is no node " + std::to_string(static_cast<int>(number)), file_);
            return at->second;
        }
        std::vector<VertexId> vertices(const std::string& text) const
        {
            std::vector<VertexId> all;
            for (const double n : number_list(text))
                all.push_back(vertex(n));
            return all;
        }

        mesh::TetMesh mesh()
        {
            mesh::TetMesh mesh;
            const Tag& nodes = child(section("Mesh"), "Nodes");
            mesh.vertices.resize(static_cast<Eigen::Index>(nodes.children.size()), 3);
            for (std::size_t i = 0; i < nodes.children.size(); ++i) {
                const std::vector<double> p = number_list(nodes.children[i].text);
                if (p.size() != 3)
                    throw IoError("a node needs three coordinates", file_);
                mesh.vertices.row(static_cast<Eigen::Index>(i)) << p[0], p[1], p[2];
                id_[std::stoi(attribute(nodes.children[i], "id"))] = static_cast<VertexId>(i);
            }
            for (const Tag& element : child(section("Mesh"), "Elements").children) {
                const std::vector<VertexId> corners = vertices(element.text);
                if (corners.size() != 4)
                    throw IoError("elements must be tet4", file_);
                mesh.nodes.insert(mesh.nodes.end(), corners.begin(), corners.end());
                mesh.labels.push_back(1);
            }
            mesh::check_mesh(mesh);
            return mesh;
        }

        Held held(const mesh::TetMesh& mesh) const
        {
            Held held = hold_nothing(mesh);
            const std::array<std::string, 3> axes { "x", "y", "z" };
            for (const Tag& bc : section("Boundary").children)
                for (const VertexId v : vertices(named("NodeSet", attribute(bc, "node_set")).text))
                    for (int axis = 0; axis < 3; ++axis) {
                        const std::string& name = axes[static_cast<std::size_t>(axis)];
                        if (attribute(bc, "type") == "zero displacement") {
                            if (number(bc, name + "_dof") == 1.0)
                                hold(held, v, axis);
                        } else if (child(bc, "dof").text == name) {
                            const double value = number(bc, "value") * at_the_end(child(bc, "value"));
                            hold(held, v, axis, value);
                        }
                    }
            return held;
        }

        /// Value of the load curve at the end of the step.
        double at_the_end(const Tag& value) const
        {
            for (const Tag& curve : section("LoadData").children)
                if (attribute(curve, "id") == attribute(value, "lc"))
                    return number_list(child(curve, "points").children.back().text).at(1);
            throw IoError("there is no such load curve", file_);
        }

        Eigen::VectorXd loads(const mesh::TetMesh& mesh) const
        {
            Eigen::VectorXd loads = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
            for (const Tag& section : root_.children) {
                if (section.name != "Loads")
                    continue;
                for (const Tag& load : section.children) {
                    if (load.name == "nodal_load") {
                        const Tag& value = child(load, "value");
                        const std::vector<double> f = number_list(value.text);
                        for (const VertexId v : vertices(named("NodeSet", attribute(load, "node_set")).text))
                            loads.segment<3>(3 * v) += at_the_end(value) * Vec3(f.at(0), f.at(1), f.at(2));
                    } else {
                        const Tag& scale = child(load, "scale");
                        const std::vector<double> t = number_list(child(load, "traction").text);
                        loads += number(load, "scale") * at_the_end(scale)
                            * fem::traction_loads(
                                mesh, surface(mesh, attribute(load, "surface")), Vec3(t.at(0), t.at(1), t.at(2)));
                    }
                }
            }
            return loads;
        }

        std::vector<mesh::TetFace> surface(const mesh::TetMesh& mesh, const std::string& name) const
        {
            std::set<std::set<VertexId>> wanted;
            for (const Tag& face : named("Surface", name).children) {
                const std::vector<VertexId> corners = vertices(face.text);
                wanted.insert({ corners.begin(), corners.end() });
            }
            std::vector<mesh::TetFace> faces;
            for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
                const auto corners = mesh::face_vertices(mesh, face);
                if (wanted.contains({ corners.begin(), corners.end() }))
                    faces.push_back(face);
            }
            return faces;
        }

        void law(FebioModel& model) const
        {
            const Tag& material = child(section("Material"), "material");
            model.law_name = attribute(material, "type");
            if (model.law_name == "neo-Hookean") {
                const fem::Lame l = fem::lame({ "FEBio", number(material, "E"), number(material, "v"), 1e-9, file_ });
                model.law = fem::NeoHookean { l.mu, l.lambda };
            } else if (model.law_name == "Mooney-Rivlin") {
                model.law = fem::MooneyRivlin { number(material, "c1"), number(material, "c2"), number(material, "k") };
            } else {
                throw IoError("the material '" + model.law_name + "' is not known", file_);
            }
        }

    private:
        const Tag& root_;
        std::string file_;
        std::map<int, VertexId> id_;
    };

    Tag parse_named(const std::string& text, const std::filesystem::path& file)
    {
        try {
            return parse_xml(text);
        } catch (const InputError& error) {
            throw IoError(error.what(), file.string() + ", " + error.where());
        }
    }

} // namespace

FebioModel read_febio(const std::filesystem::path& file)
{
    std::ifstream stream(file);
    if (!stream)
        throw IoError("the file cannot be opened", file.string());
    std::ostringstream text;
    text << stream.rdbuf();
    const Tag root = parse_named(text.str(), file);
    Model reader(root, file.string());
    FebioModel model;
    model.mesh = reader.mesh();
    model.held = reader.held(model.mesh);
    model.loads = reader.loads(model.mesh);
    reader.law(model);
    return model;
}

} // namespace retractor::verification
