#include "tests/fuzz/cut_bodies.h"

#include "datasets/phantoms/phantom.h"
#include "mesh/base/error.h"
#include "mesh/generation/hybrid_model.h"
#include "tests/support/label_shapes.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <utility>

namespace retractor::fuzz {

namespace {

    constexpr double kDiagonal = 100.0; // mm: meshes in other units are brought to the size of an organ

    mesh::TetMesh layered_box(int nx, int ny, int nz, double spacing)
    {
        mesh::TetMesh box = mesh::kuhn_box(nx, ny, nz, spacing);
        for (TetId t = 0; t < static_cast<TetId>(box.tet_count()); ++t) {
            double z = 0.0;
            for (const VertexId v : box.tet(t))
                z += 0.25 * box.vertices(v, 2) / spacing / nz;
            box.labels[static_cast<std::size_t>(t)] = z > 0.75 ? Label { 3 } : z > 0.5 ? Label { 2 } : Label { 1 };
        }
        return box;
    }

    /// A ball with a core of another tissue.
    mesh::TetMesh sphere()
    {
        const mesh::LabelTable table { { 1, "core", "muscle", mesh::Role::wall },
            { 2, "shell", "skin", mesh::Role::wall } };
        const Vec3 centre(25.3, 24.8, 25.1);
        const mesh::LabelVolume labels
            = test_support::sampled_labels({ 50, 50, 50 }, Vec3::Ones(), table, [=](const Vec3& p) {
                  const double r = (p - centre).norm();
                  return static_cast<Label>(r < 12.0 ? 1 : r < 20.0 ? 2 : 0);
              });
        mesh::MeshSizing sizing;
        sizing.corridor_edge_mm = sizing.coarse_edge_mm = 7.0;
        return mesh::build_hybrid_model(labels, sizing).wall;
    }

    mesh::TetMesh thorax()
    {
        const datasets::Phantom phantom
            = datasets::make_thorax_phantom({ .spacing_mm = { 3.0, 3.0, 3.0 }, .noise_hu = 0.0 });
        mesh::MeshSizing sizing;
        sizing.corridor = { { 0.0, -100.0, -40.0 }, { 0.0, -100.0, 40.0 } };
        sizing.corridor_edge_mm = 5.0;
        sizing.coarse_edge_mm = 15.0;
        sizing.region_mm = 60.0;
        return mesh::build_hybrid_model(phantom.labels, sizing).wall;
    }

    // Readers of what SOFA ships: gmsh 1 and the ASCII kinds of VTK. Not for files of unknown origin.

    struct Soup {
        std::vector<Vec3> points;
        std::vector<std::array<VertexId, 4>> tets;
    };

    Soup read_gmsh(std::istream& in)
    {
        Soup soup;
        std::string word;
        std::map<long, VertexId> id;
        while (in >> word) {
            std::size_t count = 0;
            if (word == "$NOD") {
                in >> count;
                for (std::size_t i = 0; i < count; ++i) {
                    long name = 0;
                    Vec3 p;
                    in >> name >> p.x() >> p.y() >> p.z();
                    id[name] = static_cast<VertexId>(soup.points.size());
                    soup.points.push_back(p);
                }
            } else if (word == "$ELM") {
                in >> count;
                for (std::size_t i = 0; i < count; ++i) {
                    long name = 0, type = 0, a = 0, b = 0;
                    std::size_t nodes = 0;
                    in >> name >> type >> a >> b >> nodes;
                    std::vector<long> n(nodes);
                    for (long& v : n)
                        in >> v;
                    if (type == 4)
                        soup.tets.push_back({ id.at(n[0]), id.at(n[1]), id.at(n[2]), id.at(n[3]) });
                }
            }
        }
        return soup;
    }

    template <class Number> std::vector<Number> numbers_after(std::istream& in, const std::string& mark)
    {
        std::vector<Number> numbers;
        for (std::string line; std::getline(in, line);)
            if (line.find(mark) != std::string::npos)
                break;
        for (Number x {}; in >> x;)
            numbers.push_back(x);
        in.clear();
        return numbers;
    }

    Soup read_ascii_vtu(std::istream& in)
    {
        Soup soup;
        const auto x = numbers_after<double>(in, "NumberOfComponents=\"3\"");
        const auto nodes = numbers_after<VertexId>(in, "Name=\"connectivity\"");
        const auto ends = numbers_after<std::size_t>(in, "Name=\"offsets\"");
        for (std::size_t i = 0; i + 2 < x.size(); i += 3)
            soup.points.emplace_back(x[i], x[i + 1], x[i + 2]);
        for (std::size_t i = 0, from = 0; i < ends.size(); from = ends[i++])
            if (ends[i] - from == 4)
                soup.tets.push_back({ nodes[from], nodes[from + 1], nodes[from + 2], nodes[from + 3] });
        return soup;
    }

    /// Only vertices in use, one size, positive volumes, two tissues.
    mesh::TetMesh as_mesh(const Soup& soup)
    {
        std::vector<VertexId> id(soup.points.size(), -1);
        std::vector<Vec3> points;
        mesh::TetMesh mesh;
        for (const auto& tet : soup.tets)
            for (const VertexId v : tet) {
                VertexId& mine = id[static_cast<std::size_t>(v)];
                if (mine < 0) {
                    mine = static_cast<VertexId>(points.size());
                    points.push_back(soup.points[static_cast<std::size_t>(v)]);
                }
                mesh.nodes.push_back(mine);
            }
        mesh.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
        for (std::size_t v = 0; v < points.size(); ++v)
            mesh.vertices.row(static_cast<Eigen::Index>(v)) = points[v].transpose();
        const Vec3 low = mesh.vertices.colwise().minCoeff(), high = mesh.vertices.colwise().maxCoeff();
        mesh.vertices *= kDiagonal / (high - low).norm();
        const double middle = 0.5 * (low.x() + high.x()) * kDiagonal / (high - low).norm();
        mesh.labels.resize(soup.tets.size());
        for (TetId t = 0; t < static_cast<TetId>(soup.tets.size()); ++t) {
            const auto first = static_cast<std::size_t>(t) * 4;
            if (mesh::tet_volume(mesh, t) < 0.0)
                std::swap(mesh.nodes[first], mesh.nodes[first + 1]);
            double x = 0.0;
            for (const VertexId v : mesh.tet(t))
                x += 0.25 * mesh.vertices(v, 0);
            mesh.labels[static_cast<std::size_t>(t)] = x < middle ? Label { 1 } : Label { 2 };
        }
        return mesh;
    }

    Body sofa(const std::string& name, const std::string& file)
    {
        const char* chosen = std::getenv("RETRACTOR_SHARED_DATA");
        const std::filesystem::path data = chosen != nullptr ? chosen : RETRACTOR_SHARED_DATA_DEFAULT;
        const std::filesystem::path path = data / "meshes" / "sofa" / file;
        std::ifstream in(path);
        if (!in)
            return { .name = name, .mesh = {}, .missing = "there is no " + file + " (set RETRACTOR_SHARED_DATA)" };
        return { .name = name,
            .mesh = as_mesh(path.extension() == ".vtu" ? read_ascii_vtu(in) : read_gmsh(in)),
            .missing = {} };
    }

    double mean_edge(const mesh::TetMesh& mesh)
    {
        double sum = 0.0;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            for (const auto& e : mesh::kTetEdges)
                sum += (mesh.vertices.row(mesh.tet(t)[static_cast<std::size_t>(e[0])])
                    - mesh.vertices.row(mesh.tet(t)[static_cast<std::size_t>(e[1])]))
                           .norm();
        return sum / (6.0 * static_cast<double>(mesh.tet_count()));
    }

} // namespace

const std::vector<std::string>& body_names()
{
    static const std::vector<std::string> names { "box", "block", "sphere", "liver", "liver2", "torus", "cylinder",
        "raptor", "ossicles", "thorax" };
    return names;
}

Body make_body(const std::string& name)
{
    Body body { .name = name, .mesh = {}, .missing = {} };
    if (name == "box")
        body.mesh = layered_box(5, 5, 4, 4.0);
    else if (name == "block")
        body.mesh = layered_box(16, 16, 8, 4.0);
    else if (name == "sphere")
        body.mesh = sphere();
    else if (name == "thorax")
        body.mesh = thorax();
    else if (name == "liver")
        body = sofa(name, "liver.msh");
    else if (name == "liver2")
        body = sofa(name, "liver2.msh");
    else if (name == "torus")
        body = sofa(name, "torus_low_res.msh");
    else if (name == "cylinder")
        body = sofa(name, "cylinder.msh");
    else if (name == "raptor")
        body = sofa(name, "raptorTetra_8418.vtu");
    else if (name == "ossicles")
        body = sofa(name, "Ossicles.vtu");
    else
        throw InputError("there is no such body", name);
    if (body.missing.empty())
        body.edge = mean_edge(body.mesh);
    return body;
}

} // namespace retractor::fuzz
