#include "fem/statics/local_problem.h"

#include "fem/statics/nonlinear_region.h"
#include "mesh/base/error.h"

#include <string>
#include <utility>

namespace retractor::fem {

LocalProblem local_problem(const ElasticProblem& whole, const Points& points, double distance)
{
    const mesh::TetMesh& mesh = whole.mesh;
    const std::vector<std::uint8_t> near = elements_near(mesh, points, distance);
    std::vector<std::uint8_t> kept(mesh.vertex_count(), 0), beyond(mesh.vertex_count(), 0);
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
        for (const VertexId v : mesh.tet(t))
            (near[static_cast<std::size_t>(t)] != 0 ? kept : beyond)[static_cast<std::size_t>(v)] = 1;

    LocalProblem local;
    std::vector<VertexId> place(mesh.vertex_count(), -1);
    for (std::size_t v = 0; v < kept.size(); ++v)
        if (kept[v] != 0) {
            place[v] = static_cast<VertexId>(local.vertex_of.size());
            local.vertex_of.push_back(static_cast<VertexId>(v));
        }
    ElasticProblem& part = local.problem;
    part.material_of_label = whole.material_of_label;
    part.mesh.nodes_per_tet = mesh.nodes_per_tet;
    part.mesh.vertices = mesh.vertices(local.vertex_of, Eigen::all);
    std::vector<TetId> element(mesh.tet_count(), -1); // index of each element in the submodel, or -1
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
        if (near[static_cast<std::size_t>(t)] != 0) {
            element[static_cast<std::size_t>(t)] = static_cast<TetId>(local.tet_of.size());
            local.tet_of.push_back(t);
            part.mesh.labels.push_back(mesh.labels[static_cast<std::size_t>(t)]);
            for (const VertexId v : mesh.tet(t))
                part.mesh.nodes.push_back(place[static_cast<std::size_t>(v)]);
        }

    std::vector<std::uint8_t> held(local.vertex_of.size(), 0);
    for (const HookPatch& hook : whole.hooks) {
        part.hooks.push_back({ hook.name, hook.side, {}, hook.displacement });
        for (const VertexId v : hook.nodes) {
            if (place[static_cast<std::size_t>(v)] < 0 || beyond[static_cast<std::size_t>(v)] != 0)
                throw InputError("the hook reaches beyond the part that is solved, " + std::to_string(distance)
                        + " mm round the wound",
                    "hook '" + hook.name + "'");
            part.hooks.back().nodes.push_back(place[static_cast<std::size_t>(v)]);
        }
    }
    if (!whole.pressures.empty())
        throw InputError("pressure moves all of a body, and a part of it holds the rest still",
            "pressure of " + whole.pressures.front().name);
    for (const auto& [face, traction] : whole.loads) {
        const TetId here = element.at(static_cast<std::size_t>(face.tet));
        if (here < 0)
            throw InputError("a load (such as tension that a cut sets free) acts beyond the part that is solved, "
                    + std::to_string(distance) + " mm round the lips: solve within a larger distance",
                "element " + std::to_string(face.tet));
        part.loads.push_back({ { here, face.corner }, traction });
    }
    for (const VertexId v : whole.supports.fixed)
        if (const VertexId here = place[static_cast<std::size_t>(v)]; here >= 0)
            held[static_cast<std::size_t>(here)] = 1;
    for (const BeddedVertex& bedded : whole.supports.bedded)
        if (const VertexId here = place[static_cast<std::size_t>(bedded.vertex)]; here >= 0)
            part.supports.bedded.push_back({ here, bedded.stiffness });
    for (std::size_t i = 0; i < held.size(); ++i)
        if (beyond[static_cast<std::size_t>(local.vertex_of[i])] != 0) {
            held[i] = 1;
            ++local.rim_vertices;
        }
    for (std::size_t i = 0; i < held.size(); ++i)
        if (held[i] != 0)
            part.supports.fixed.push_back(static_cast<VertexId>(i));
    return local;
}

} // namespace retractor::fem
