#include "fem/model/floating_components.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <vector>

namespace retractor::fem {

namespace {

    using Elements = std::vector<TetId>;

    std::vector<Elements> elements_of_pieces(std::span<const int> piece)
    {
        std::vector<Elements> elements(
            piece.empty() ? 0 : static_cast<std::size_t>(*std::max_element(piece.begin(), piece.end())) + 1);
        for (std::size_t t = 0; t < piece.size(); ++t)
            elements[static_cast<std::size_t>(piece[t])].push_back(static_cast<TetId>(t));
        return elements;
    }

    /// The motions that a piece's held nodes prevent.
    struct Hold {
        std::size_t nodes = 0;
        /// all held nodes lie on one line, about which the piece can turn: their second principal extent is zero
        bool on_line = true;
    };

    Hold hold_on(const mesh::TetMesh& mesh, const Elements& elements, const std::vector<std::uint8_t>& held)
    {
        std::vector<VertexId> nodes;
        for (const TetId t : elements)
            for (const VertexId v : mesh.tet(t))
                if (held[static_cast<std::size_t>(v)] != 0)
                    nodes.push_back(v);
        std::sort(nodes.begin(), nodes.end());
        nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
        if (nodes.size() < 3)
            return { nodes.size(), true };
        Vec3 centre = Vec3::Zero();
        for (const VertexId v : nodes)
            centre += mesh.vertices.row(v).transpose() / static_cast<double>(nodes.size());
        Mat3 spread = Mat3::Zero();
        for (const VertexId v : nodes) {
            const Vec3 d = mesh.vertices.row(v).transpose() - centre;
            spread += d * d.transpose();
        }
        const Vec3 extent = Eigen::SelfAdjointEigenSolver<Mat3>(spread, Eigen::EigenvaluesOnly).eigenvalues();
        constexpr double kOnLine = 1e-10; // square of the ratio of width to length
        return { nodes.size(), !(extent[1] > kOnLine * extent[2]) };
    }

    std::string what_is_missing(const Hold& hold)
    {
        if (hold.nodes == 0)
            return "has neither a support nor a hook that keeps it from moving and turning";
        if (hold.nodes == 1)
            return "is held at one vertex alone: nothing keeps it from turning about that";
        return "is held at " + std::to_string(hold.nodes)
            + " vertices on one line alone: nothing keeps it from turning about that";
    }

    [[noreturn]] void refuse(const mesh::TetMesh& mesh, const Elements& elements, std::size_t number, const Hold& hold)
    {
        double volume = 0.0;
        Vec3 centre = Vec3::Zero();
        for (const TetId t : elements) {
            const auto n = mesh.tet(t);
            const double v = mesh::tet_volume(mesh, t);
            volume += v;
            for (std::size_t a = 0; a < 4; ++a)
                centre += 0.25 * v * mesh.vertices.row(n[a]).transpose();
        }
        centre /= volume;
        std::ostringstream text, where;
        text << "a piece of " << elements.size() << " element(s), " << volume << " mm^3, " << what_is_missing(hold);
        where << "piece " << number << " round (" << centre.x() << ", " << centre.y() << ", " << centre.z() << ") mm";
        throw SolverError(text.str(), where.str());
    }

    /// Flags the pieces that are held, one after the other.
    /// @param held one flag per vertex; the vertices of held pieces are added.
    std::vector<std::uint8_t> hold_pieces(
        const mesh::TetMesh& mesh, const std::vector<Elements>& pieces, std::vector<std::uint8_t>& held)
    {
        std::vector<std::uint8_t> done(pieces.size(), 0);
        for (bool progress = true; progress;) {
            progress = false;
            for (std::size_t p = 0; p < pieces.size(); ++p) {
                if (done[p] != 0 || hold_on(mesh, pieces[p], held).on_line)
                    continue;
                done[p] = 1;
                progress = true;
                for (const TetId t : pieces[p])
                    for (const VertexId v : mesh.tet(t))
                        held[static_cast<std::size_t>(v)] = 1;
            }
        }
        return done;
    }

    std::vector<std::uint8_t> flags(const mesh::TetMesh& mesh, std::span<const VertexId> vertices)
    {
        std::vector<std::uint8_t> flag(mesh.vertex_count(), 0);
        for (const VertexId v : vertices)
            flag[static_cast<std::size_t>(v)] = 1;
        return flag;
    }

} // namespace

std::vector<std::uint8_t> held_components(
    const mesh::TetMesh& mesh, std::span<const int> piece_of_tet, std::span<const VertexId> held_nodes)
{
    RETRACTOR_ASSERT(piece_of_tet.size() == mesh.tet_count());
    std::vector<std::uint8_t> held = flags(mesh, held_nodes);
    return hold_pieces(mesh, elements_of_pieces(piece_of_tet), held);
}

void check_no_floating_component(const mesh::TetMesh& mesh, std::span<const VertexId> held_nodes)
{
    const std::vector<Elements> pieces = elements_of_pieces(mesh::connected_pieces(mesh));
    std::vector<std::uint8_t> held = flags(mesh, held_nodes);
    const std::vector<std::uint8_t> done = hold_pieces(mesh, pieces, held);
    for (std::size_t p = 0; p < done.size(); ++p)
        if (done[p] == 0)
            refuse(mesh, pieces[p], p, hold_on(mesh, pieces[p], held));
}

} // namespace retractor::fem
