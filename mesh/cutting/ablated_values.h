#pragma once
// Keeps values of vertices that an ablation removed, for a follower of a session's deltas, so that undo can restore the
// values. Ids are reused in between, so that several values of one id may be kept; the last kept value returns first.

#include "mesh/tetrahedra/tet_mesh.h"

#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace retractor::mesh {

template <class Value> class AblatedValues {
public:
    /// Keeps the value of a vertex that a delta removes with MeshDelta::Origin::restored.
    void keep(VertexId v, Value value) { kept_[v].push_back(std::move(value)); }
    /// The value of a vertex that a delta adds with MeshDelta::Origin::restored. Nothing when the vertex was ablated
    /// before the follower was made.
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
    std::map<VertexId, std::vector<Value>> kept_; ///< by id, the last kept value last; no list is empty
};

} // namespace retractor::mesh
