#include "mesh/cutting/store/cut_types.h"

namespace retractor::mesh {

double CutReport::mean_increase() const
{
    return tets_crossed == 0
        ? 0.0
        : (static_cast<double>(tets_created) - static_cast<double>(tets_removed)) / static_cast<double>(tets_crossed);
}

MeshDelta inverse(const MeshDelta& delta)
{
    MeshDelta back;
    back.vertices_born.assign(delta.vertices_gone.rbegin(), delta.vertices_gone.rend());
    back.vertices_gone.assign(delta.vertices_born.rbegin(), delta.vertices_born.rend());
    for (auto it = delta.vertices_moved.rbegin(); it != delta.vertices_moved.rend(); ++it)
        back.vertices_moved.push_back({ it->id, it->to, it->from });
    back.tets_gone = delta.tets_born;
    back.tets_born = delta.tets_gone;
    return back;
}

} // namespace retractor::mesh
