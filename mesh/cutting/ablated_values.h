#pragma once
// What a follower of a session's deltas keeps of vertices that an ablation took, so that undoing it gives it back.
// Ids are reused in between: several vertices of one id may be kept at once, and return last gone, first back.

#include "mesh/tetrahedra/tet_mesh.h"

#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace retractor::mesh {

template <class Value> class AblatedValues {
public:
    /// For a vertex gone with MeshDelta::Origin::restored.
    void keep(VertexId v, Value value) { kept_[v].push_back(std::move(value)); }
    /// For one born with that origin; nothing when it was ablated before the follower was made.
    std::optional<Value> give_back(VertexId v)
    {
        const auto found = kept_.find(v);
        if (found == kept_.end())
            return std::nullopt;
        std::optional<Value> value = std::move(found->second.back());
        found->second.pop_back();
        if (found->second.empty())
            kept_.erase(found);
        return value;
    }
    void clear() { kept_.clear(); }

private:
    std::map<VertexId, std::vector<Value>> kept_; ///< by id, last gone last; none empty
};

} // namespace retractor::mesh
