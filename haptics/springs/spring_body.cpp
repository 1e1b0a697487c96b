#include "haptics/springs/spring_body.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace retractor::haptics {

namespace {

    constexpr int kFewest = 3; // a bend spring spans three particles
    constexpr int kMost = 1000;

    void check(const SheetOptions& options)
    {
        for (const int count : { options.columns, options.rows })
            if (count < kFewest || count > kMost)
                throw InputError("a sheet has 3 to 1000 particles a side, got " + std::to_string(count));
        const std::pair<const char*, double> positive[] = { { "spacing", options.spacing },
            { "particle mass", options.particle_mass }, { "stiffness", options.stiffness } };
        for (const auto& [name, value] : positive)
            if (!(value > 0.0) || !std::isfinite(value))
                throw InputError(std::string("a sheet's ") + name + " must be positive, got " + std::to_string(value));
        if (!(options.pre_strain >= 0.0 && options.pre_strain <= 1.0))
            throw InputError("a sheet's pre-strain lies between 0 and 1, got " + std::to_string(options.pre_strain));
    }

    bool is_held(const SheetOptions& options, int column, int row)
    {
        return column == 0 || row == 0 || column == options.columns - 1 || row == options.rows - 1;
    }

    void add_springs(SpringBody& body, const SheetOptions& options)
    {
        const auto id = [&](int column, int row) { return static_cast<VertexId>(row * options.columns + column); };
        constexpr std::pair<int, int> kSteps[] = { { 1, 0 }, { 0, 1 }, { 1, 1 }, { -1, 1 }, { 2, 0 }, { 0, 2 } };
        for (int row = 0; row < options.rows; ++row)
            for (int column = 0; column < options.columns; ++column)
                for (const auto& [dc, dr] : kSteps) {
                    const int c = column + dc, r = row + dr;
                    if (c < 0 || c >= options.columns || r >= options.rows)
                        continue;
                    body.springs.push_back({ id(column, row), id(c, r),
                        options.spacing / (1.0 + options.pre_strain)
                            * std::sqrt(static_cast<double>(dc * dc + dr * dr)),
                        options.stiffness });
                }
    }

    void add_triangles(SpringBody& body, const SheetOptions& options)
    {
        for (int row = 0; row + 1 < options.rows; ++row)
            for (int column = 0; column + 1 < options.columns; ++column) {
                const auto a = static_cast<VertexId>(row * options.columns + column);
                const VertexId b = a + 1, c = a + options.columns, d = c + 1;
                body.surface.triangles.push_back({ a, b, d });
                body.surface.triangles.push_back({ a, d, c });
            }
    }

    void require(bool right, const std::string& what)
    {
        if (!right)
            throw InputError("spring body: " + what);
    }

} // namespace

SpringBody make_spring_sheet(const SheetOptions& options)
{
    check(options);
    SpringBody body;
    const auto particles = static_cast<std::size_t>(options.columns * options.rows);
    body.surface.vertices.resize(static_cast<Eigen::Index>(particles), 3);
    body.mass.assign(particles, options.particle_mass);
    body.held.assign(particles, 0);
    body.touchable.resize(particles);
    std::iota(body.touchable.begin(), body.touchable.end(), 0);
    for (int row = 0; row < options.rows; ++row)
        for (int column = 0; column < options.columns; ++column) {
            const int v = row * options.columns + column;
            body.surface.vertices.row(v) = options.spacing
                * Eigen::RowVector3d(column - 0.5 * (options.columns - 1), row - 0.5 * (options.rows - 1), 0.0);
            body.held[static_cast<std::size_t>(v)] = is_held(options, column, row) ? 1 : 0;
        }
    add_springs(body, options);
    add_triangles(body, options);
    return body;
}

SpringBody make_spring_organ(const mesh::TetMesh& mesh, std::span<const double> modulus_of_element, double density,
    std::span<const VertexId> held, double calibration)
{
    mesh::check_mesh(mesh);
    if (mesh.nodes_per_tet != 4)
        throw InputError("springs lie on the edges of four-node elements, got ten nodes");
    if (modulus_of_element.size() != mesh.tet_count())
        throw InputError("one Young's modulus per element is needed");
    for (std::size_t t = 0; t < modulus_of_element.size(); ++t)
        if (!(modulus_of_element[t] > 0.0) || !std::isfinite(modulus_of_element[t]))
            throw InputError("Young's modulus of element " + std::to_string(t) + " is not positive");
    if (!(density > 0.0) || !std::isfinite(density))
        throw InputError("the density must be positive, got " + std::to_string(density));
    if (!(calibration > 0.0) || !std::isfinite(calibration))
        throw InputError("the springs' calibration must be positive, got " + std::to_string(calibration));
    SpringBody body;
    body.surface.vertices = mesh.vertices;
    body.mass.assign(mesh.vertex_count(), 0.0);
    body.held.assign(mesh.vertex_count(), 0);
    for (const VertexId v : held) {
        require(v >= 0 && static_cast<std::size_t>(v) < mesh.vertex_count(),
            "held vertex " + std::to_string(v) + " does not exist");
        body.held[static_cast<std::size_t>(v)] = 1;
    }
    // Ordered, so that the springs are the same on any machine.
    std::map<std::pair<VertexId, VertexId>, double> stiffness;
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
        const auto element = static_cast<std::size_t>(t);
        const auto nodes = mesh.tet(t);
        const std::array<Vec3, 4> corners = mesh::tet_corners(mesh, t);
        const double quarter = 0.25 * mesh::tet_volume(mesh, t) * density;
        for (const VertexId v : nodes)
            body.mass[static_cast<std::size_t>(v)] += quarter;
        const double volume = mesh::tet_volume(mesh, t);
        for (const auto& edge : mesh::kTetEdges) {
            const auto a = static_cast<std::size_t>(edge[0]), b = static_cast<std::size_t>(edge[1]);
            stiffness[std::minmax(nodes[a], nodes[b])]
                += calibration * modulus_of_element[element] * volume / (corners[a] - corners[b]).squaredNorm();
        }
    }
    for (const auto& [ends, k] : stiffness)
        if (k > 0.0)
            body.springs.push_back({ ends.first, ends.second,
                (mesh.vertices.row(ends.first) - mesh.vertices.row(ends.second)).norm(), k });
    std::vector<std::uint8_t> outer(mesh.vertex_count(), 0);
    for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
        body.surface.triangles.push_back(mesh::face_vertices(mesh, face));
        body.surface.labels.push_back(mesh.labels[static_cast<std::size_t>(face.tet)]);
        for (const VertexId v : body.surface.triangles.back())
            outer[static_cast<std::size_t>(v)] = 1;
    }
    for (std::size_t v = 0; v < outer.size(); ++v) {
        if (outer[v] != 0)
            body.touchable.push_back(static_cast<VertexId>(v));
        if (body.mass[v] == 0.0) // the particle is in no element, so no spring pulls it
            require(false, "vertex " + std::to_string(v) + " belongs to no element");
    }
    return body;
}

void check_spring_body(const SpringBody& body)
{
    const auto particles = static_cast<std::size_t>(body.surface.vertices.rows());
    require(particles > 0, "no particles");
    require(body.surface.vertices.allFinite(), "a position is not finite");
    require(body.mass.size() == particles, "one mass per particle is needed");
    require(body.held.size() == particles, "one held flag per particle is needed");
    for (std::size_t v = 0; v < particles; ++v)
        require(body.mass[v] > 0.0 && std::isfinite(body.mass[v]),
            "the mass of particle " + std::to_string(v) + " is not positive");
    const auto inside = [&](VertexId v) { return v >= 0 && static_cast<std::size_t>(v) < particles; };
    for (std::size_t s = 0; s < body.springs.size(); ++s) {
        const TissueSpring& spring = body.springs[s];
        const std::string name = "spring " + std::to_string(s);
        require(inside(spring.a) && inside(spring.b) && spring.a != spring.b, name + " has wrong ends");
        require(spring.length > 0.0 && std::isfinite(spring.length), name + " has no length");
        require(
            spring.stiffness > 0.0 && std::isfinite(spring.stiffness), name + " has a stiffness that is not positive");
    }
    require(std::all_of(body.touchable.begin(), body.touchable.end(), inside), "a touchable particle does not exist");
    for (const auto& triangle : body.surface.triangles)
        require(std::all_of(triangle.begin(), triangle.end(), inside), "a triangle has wrong corners");
}

} // namespace retractor::haptics
