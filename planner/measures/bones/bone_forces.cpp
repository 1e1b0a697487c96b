#include "planner/measures/bones/bone_forces.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

namespace retractor::planner {

namespace {

    /// The elements of one piece with their own nodes, in rising order: corners stay before midpoints.
    BoneForces piece_of(const mesh::TetMesh& bone, const std::vector<int>& piece_of_element, int piece)
    {
        BoneForces body;
        body.part.nodes_per_tet = bone.nodes_per_tet;
        for (TetId t = 0; t < static_cast<TetId>(bone.tet_count()); ++t) {
            if (piece_of_element[static_cast<std::size_t>(t)] != piece)
                continue;
            const auto nodes = bone.tet(t);
            body.part.nodes.insert(body.part.nodes.end(), nodes.begin(), nodes.end());
            body.part.labels.push_back(bone.labels[static_cast<std::size_t>(t)]);
        }
        body.node_of = body.part.nodes;
        std::sort(body.node_of.begin(), body.node_of.end());
        body.node_of.erase(std::unique(body.node_of.begin(), body.node_of.end()), body.node_of.end());
        for (VertexId& node : body.part.nodes)
            node = static_cast<VertexId>(
                std::lower_bound(body.node_of.begin(), body.node_of.end(), node) - body.node_of.begin());
        body.part.vertices = bone.vertices(body.node_of, Eigen::all);
        return body;
    }

    void solve_forces(BoneForces& body, std::span<const fem::Material> material_of_label, const fem::TissueModel& model,
        const Eigen::VectorXd& displacement)
    {
        const auto n = static_cast<Eigen::Index>(body.node_of.size());
        Eigen::VectorXd u(3 * n);
        for (Eigen::Index i = 0; i < n; ++i)
            u.segment<3>(3 * i)
                = displacement.segment<3>(3 * static_cast<Eigen::Index>(body.node_of[static_cast<std::size_t>(i)]));
        const fem::ElasticBody elastic = fem::tissue_body(body.part, material_of_label, model);
        const Eigen::VectorXd forces = elastic.response(u).forces;
        if (!forces.allFinite())
            throw SolverError("an element of the bone is turned over, so its forces are not known",
                "label " + std::to_string(body.part.labels.front()));
        body.forces = Eigen::Map<const Points>(forces.data(), n, 3);
        body.positions = body.part.vertices;
        if (model.elasticity != fem::Elasticity::linear)
            body.positions += Eigen::Map<const Points>(u.data(), n, 3);
    }

} // namespace

std::vector<BoneForces> bone_forces(const mesh::TetMesh& wall, std::span<const fem::Material> material_of_label,
    const fem::TissueModel& model, const Eigen::VectorXd& displacement, Label bone)
{
    if (displacement.size() != 3 * wall.vertices.rows())
        throw InputError("the displacement has " + std::to_string(displacement.size()) + " numbers, the wall "
            + std::to_string(wall.vertices.rows()) + " nodes");
    const mesh::TetMesh all = mesh::part_with_labels(wall, std::array { bone });
    const std::vector<int> piece_of_element = mesh::connected_pieces(all);
    const int pieces = piece_of_element.empty() ? 0 : 1 + *std::ranges::max_element(piece_of_element);
    std::vector<BoneForces> bodies;
    for (int piece = 0; piece < pieces; ++piece) {
        bodies.push_back(piece_of(all, piece_of_element, piece));
        solve_forces(bodies.back(), material_of_label, model, displacement);
    }
    return bodies;
}

} // namespace retractor::planner
