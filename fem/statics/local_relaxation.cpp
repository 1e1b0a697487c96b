#include "fem/statics/local_relaxation.h"

#include "fem/linear_algebra/constrained_solver.h"
#include "fem/linear_algebra/norm.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace retractor::fem {

namespace {

    constexpr std::size_t kMostNodes = 200; // with large forces: more are not local
    constexpr std::size_t kLeastOfBody = 4; // nodes of the body for each node that moves: more are not local
    constexpr double kLargeForce = 0.1; // of the largest force

    /// Newton's method with the projected stiffness, which always finds a descent. It ends after a number of steps if
    /// not at rest. @return whether the part moved
    bool bring_to_rest(ElasticBody& part, const std::vector<std::uint8_t>& prescribed, Eigen::VectorXd& u)
    {
        constexpr int kMostSteps = 30, kMostHalvings = 10;
        constexpr double kAtRest = 1e-3; // of the force at the start
        constexpr double kArmijo = 1e-4;
        (void)part.stiffness(u, 1.0);
        ConstrainedSolver solver(part.last_stiffness().pattern, prescribed);
        ElasticBody::Response now = part.response(u);
        bool moved = false;
        double first = 0.0;
        for (int step = 0; step < kMostSteps; ++step) {
            Eigen::VectorXd r = now.forces;
            solver.mask(r);
            const double force = largest_length(r);
            if (step == 0)
                first = force;
            if (force <= kAtRest * first)
                return moved;
            try {
                solver.factorise(part.stiffness(u, 1.0));
            } catch (const SolverError&) { // the whole body goes on from here
                return moved;
            }
            const Eigen::VectorXd du = solver.solve(-r);
            const double slope = r.dot(du);
            bool is_lower = false;
            for (double length = 1.0; !is_lower && length > std::pow(0.5, kMostHalvings); length *= 0.5) {
                ElasticBody::Response there = part.response(u + length * du);
                is_lower = std::isfinite(there.energy) && there.energy < now.energy + kArmijo * length * slope;
                if (is_lower) {
                    u += length * du;
                    now = std::move(there);
                }
            }
            if (!is_lower)
                return moved;
            moved = true;
        }
        return moved;
    }

} // namespace

LocalRelaxation::LocalRelaxation(const ElasticBody& body, const std::vector<std::uint8_t>& prescribed)
    : body_(body)
    , prescribed_(prescribed)
    , first_(body.mesh().vertex_count() + 1, 0)
{
    RETRACTOR_ASSERT(body.has_parts() && prescribed.size() == 3 * body.mesh().vertex_count());
    const mesh::TetMesh& mesh = body.mesh();
    // An element without midpoints names corners again in their place, and stands round these corners more than once.
    for (const VertexId v : mesh.nodes)
        ++first_[static_cast<std::size_t>(v) + 1];
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
        first_[v + 1] += first_[v];
    around_.resize(mesh.nodes.size());
    std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t t = 0; t < mesh.tet_count(); ++t)
        for (const VertexId v : mesh.tet(static_cast<TetId>(t)))
            around_[static_cast<std::size_t>(next[static_cast<std::size_t>(v)]++)] = static_cast<TetId>(t);
}

/// The nodes with large forces, of those that nothing touches; none where they are too many.
std::vector<VertexId> LocalRelaxation::find_worst_nodes(
    const Eigen::VectorXd& forces, const std::vector<std::uint8_t>& touched) const
{
    std::vector<double> force(touched.size(), 0.0);
    for (std::size_t v = 0; v < touched.size(); ++v)
        if (touched[v] == 0)
            force[v] = forces.segment<3>(3 * static_cast<Eigen::Index>(v)).norm();
    const double largest = *std::max_element(force.begin(), force.end()), least = kLargeForce * largest;
    if (largest < kLargeForce * largest_length(forces))
        return {};
    std::vector<VertexId> nodes;
    for (std::size_t v = 0; v < force.size() && nodes.size() <= kMostNodes; ++v)
        if (force[v] > 0.0 && force[v] >= least)
            nodes.push_back(static_cast<VertexId>(v));
    if (nodes.size() > kMostNodes)
        nodes.clear();
    return nodes;
}

std::optional<Eigen::VectorXd> LocalRelaxation::relax(const Eigen::VectorXd& u, const Eigen::VectorXd& forces) const
{
    const mesh::TetMesh& mesh = body_.mesh();
    RETRACTOR_ASSERT(u.size() == 3 * mesh.vertices.rows() && forces.size() == u.size());
    const auto elements_round = [&](const std::vector<VertexId>& nodes) {
        std::vector<TetId> elements;
        for (const VertexId v : nodes)
            elements.insert(elements.end(), around_.begin() + first_[static_cast<std::size_t>(v)],
                around_.begin() + first_[static_cast<std::size_t>(v) + 1]);
        std::sort(elements.begin(), elements.end());
        elements.erase(std::unique(elements.begin(), elements.end()), elements.end());
        return elements;
    };
    const std::vector<std::uint8_t> touched = body_.touched_nodes(u);
    std::vector<VertexId> free;
    for (const TetId t : elements_round(find_worst_nodes(forces, touched)))
        for (const VertexId v : mesh.tet(t))
            if (const auto i = static_cast<std::size_t>(v); touched[i] == 0 && prescribed_[3 * i] == 0
                && prescribed_[3 * i + 1] == 0 && prescribed_[3 * i + 2] == 0)
                free.push_back(v);
    std::sort(free.begin(), free.end());
    free.erase(std::unique(free.begin(), free.end()), free.end());
    if (free.empty() || kLeastOfBody * free.size() > mesh.vertex_count())
        return std::nullopt;
    std::vector<VertexId> nodes; // of the body, for each node of the part
    ElasticBody part = body_.part(elements_round(free), nodes);
    std::vector<std::uint8_t> held(3 * nodes.size(), 0);
    Eigen::VectorXd of_part(static_cast<Eigen::Index>(held.size()));
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        of_part.segment<3>(3 * static_cast<Eigen::Index>(n)) = u.segment<3>(3 * static_cast<Eigen::Index>(nodes[n]));
        if (!std::binary_search(free.begin(), free.end(), nodes[n]))
            std::fill_n(held.begin() + 3 * static_cast<std::ptrdiff_t>(n), 3, std::uint8_t { 1 });
    }
    if (!bring_to_rest(part, held, of_part))
        return std::nullopt;
    Eigen::VectorXd all = u;
    for (std::size_t n = 0; n < nodes.size(); ++n)
        all.segment<3>(3 * static_cast<Eigen::Index>(nodes[n])) = of_part.segment<3>(3 * static_cast<Eigen::Index>(n));
    return all;
}

} // namespace retractor::fem
