#include "fem/held_pieces.h"

#include "mesh/base/error.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <vector>

namespace retractor {

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

    /// The held nodes of a piece do not lie on one line: their second principal extent is not zero.
    bool is_held(const TetMesh& mesh, const Elements& elements, const std::vector<std::uint8_t>& held)
    {
        std::vector<VertexId> nodes;
        for (const TetId t : elements)
            for (const VertexId v : mesh.tet(t))
                if (held[static_cast<std::size_t>(v)] != 0)
                    nodes.push_back(v);
        std::sort(nodes.begin(), nodes.end());
        nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
        if (nodes.size() < 3)
            return false;
        Vec3 centre = Vec3::Zero();
        for (const VertexId v : nodes)
            centre += mesh.vertices.row(v).transpose() / static_cast<double>(nodes.size());
        Mat3 spread = Mat3::Zero();
        for (const VertexId v : nodes) {
            const Vec3 d = mesh.vertices.row(v).transpose() - centre;
            spread += d * d.transpose();
        }
        const Vec3 extent = Eigen::SelfAdjointEigenSolver<Mat3>(spread, Eigen::EigenvaluesOnly).eigenvalues();
        constexpr double kOnLine = 1e-10; // square of width over length
        return extent[1] > kOnLine * extent[2];
    }

    [[noreturn]] void refuse(const TetMesh& mesh, const Elements& elements, std::size_t number)
    {
        double volume = 0.0;
        Vec3 centre = Vec3::Zero();
        for (const TetId t : elements) {
            const auto n = mesh.tet(t);
            const double v = tet_volume(mesh, t);
            volume += v;
            for (std::size_t a = 0; a < 4; ++a)
                centre += 0.25 * v * mesh.vertices.row(n[a]).transpose();
        }
        centre /= volume;
        std::ostringstream text, where;
        text << "a piece of " << elements.size() << " element(s), " << volume
             << " mm^3, has neither a support nor a hook that keeps it from moving and turning";
        where << "piece " << number << " round (" << centre.x() << ", " << centre.y() << ", " << centre.z() << ") mm";
        throw SolverError(text.str(), where.str());
    }

} // namespace

std::vector<std::uint8_t> held_pieces(
    const TetMesh& mesh, std::span<const int> piece_of_tet, std::span<const VertexId> held_nodes)
{
    std::vector<std::uint8_t> held(mesh.vertex_count(), 0);
    for (const VertexId v : held_nodes)
        held[static_cast<std::size_t>(v)] = 1;
    const std::vector<Elements> pieces = elements_of_pieces(piece_of_tet);
    std::vector<std::uint8_t> done(pieces.size(), 0);
    for (bool progress = true; progress;) {
        progress = false;
        for (std::size_t p = 0; p < pieces.size(); ++p) {
            if (done[p] != 0 || !is_held(mesh, pieces[p], held))
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

void check_pieces_held(const TetMesh& mesh, std::span<const VertexId> held_nodes)
{
    const std::vector<int> piece = connected_pieces(mesh);
    const std::vector<std::uint8_t> held = held_pieces(mesh, piece, held_nodes);
    for (std::size_t p = 0; p < held.size(); ++p)
        if (held[p] == 0)
            refuse(mesh, elements_of_pieces(piece)[p], p);
}

} // namespace retractor
