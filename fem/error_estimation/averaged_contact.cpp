#include "fem/error_estimation/averaged_contact.h"

#include "fem/model/contact.h"
#include "mesh/base/triangle.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <map>

namespace retractor::fem {

AveragedContact::AveragedContact(const ElasticBody& coarse, const mesh::TetMesh& fine, const Eigen::VectorXd& answer)
    : contact_(coarse.contact())
    , coarse_size_(answer.size())
{
    if (contact_ == nullptr)
        return;
    forces_ = Eigen::VectorXd::Zero(answer.size());
    (void)contact_->add_response(answer, forces_);
    BlockPattern none;
    none.row_start.assign(coarse.mesh().vertex_count() + 1, 0);
    stiffness_.pattern = contact_->pattern(none);
    weigh_edges(coarse.mesh(), fine);
}

void AveragedContact::linearise(const Eigen::VectorXd& answer, double lifted)
{
    if (contact_ == nullptr)
        return;
    stiffness_.values.assign(9 * stiffness_.pattern.block_count(), 0.0);
    contact_->add_stiffness(answer, lifted, stiffness_);
}

void AveragedContact::add_forces(Eigen::VectorXd& to) const
{
    if (contact_ != nullptr)
        spread(forces_, to);
}

void AveragedContact::add_product(const Eigen::VectorXd& u, Eigen::VectorXd& to) const
{
    if (contact_ != nullptr)
        spread(stiffness_.multiply(average(u)), to);
}

void AveragedContact::weigh_edges(const mesh::TetMesh& coarse, const mesh::TetMesh& fine)
{
    std::vector<double> area(coarse.vertex_count(), 0.0);
    std::map<std::array<VertexId, 2>, double> of_edge; // area of the contact faces by end and midpoint of an edge
    std::map<VertexId, std::array<VertexId, 2>> ends;
    for (const mesh::TetFace& face : mesh::boundary_faces(coarse)) {
        const auto corners = mesh::face_vertices(coarse, face);
        if (!std::all_of(
                corners.begin(), corners.end(), [&](VertexId v) { return !forces_.segment<3>(3 * v).isZero(0.0); }))
            continue;
        const double size = triangle_area(coarse.vertices, corners);
        for (const VertexId v : corners)
            area[static_cast<std::size_t>(v)] += size;
        const auto nodes = fine.tet(face.tet);
        for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e) {
            const auto [i, j] = mesh::kTetEdges[e];
            if (i == face.corner || j == face.corner)
                continue;
            const VertexId middle = nodes[4 + e];
            ends[middle] = { nodes[static_cast<std::size_t>(i)], nodes[static_cast<std::size_t>(j)] };
            for (const VertexId end : ends[middle])
                of_edge[{ end, middle }] += 0.5 * size; // two edges of a face end at each corner
        }
    }
    for (const auto& [edge, size] : of_edge) {
        const auto [end, middle] = edge;
        const auto [a, b] = ends[middle];
        shares_.push_back({ end, end == a ? b : a, middle, size / area[static_cast<std::size_t>(end)] });
    }
}

Eigen::VectorXd AveragedContact::average(const Eigen::VectorXd& u) const
{
    Eigen::VectorXd mean = u.head(coarse_size_);
    for (const Share& s : shares_)
        mean.segment<3>(3 * s.end) += s.weight
            * (u.segment<3>(3 * s.middle) - 0.5 * u.segment<3>(3 * s.end) - 0.5 * u.segment<3>(3 * s.other));
    return mean;
}

/// The transpose of average().
void AveragedContact::spread(const Eigen::VectorXd& forces, Eigen::VectorXd& to) const
{
    to.head(coarse_size_) += forces;
    for (const Share& s : shares_) {
        const Vec3 part = s.weight * forces.segment<3>(3 * s.end);
        to.segment<3>(3 * s.middle) += part;
        to.segment<3>(3 * s.end) -= 0.5 * part;
        to.segment<3>(3 * s.other) -= 0.5 * part;
    }
}

} // namespace retractor::fem
