#pragma once
// What must hold of a cutting session after every stroke, told apart from the cutter: checks here share no code with
// it beyond the contract and the blade's own coordinates. Units mm.

#include "mesh/cut_session.h"

#include <array>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

namespace retractor::fuzz {

/// A broken promise.
struct Finding {
    std::string invariant; ///< short name, to be counted by
    std::string detail;
};
using Findings = std::vector<Finding>;

/// Everything a session shows of itself.
struct State {
    explicit State(const CutSession& session);
    SlotMap map;
    TetMesh mesh;
    std::vector<TetId> origins; ///< per compact element
    std::vector<LipFace> lips; ///< ids of `mesh`
    std::vector<VertexId> pinched; ///< ids of `mesh`
    std::size_t cuts = 0, tets = 0, vertices = 0;
};

/// Bit for bit, ids included.
bool same_bits(const State& a, const State& b);

/// Volumes positive, faces matched, surface closed and manifold but for the pinched vertices, lips on the surface,
/// Euler characteristic of the body that of its surface.
void check_sound(const State& state, Findings& findings);

/// What one cut may have changed: volumes, surface, lips, extent.
/// @param first the body before any cut, for local edge lengths.
void check_cut(const State& before, const State& after, const TetMesh& first, const Blade& blade,
    const CutOptions& options, const CutReport& report, Findings& findings);

/// A mesh kept by deltas alone.
class Mirror {
public:
    explicit Mirror(const State& state);
    void follow(const MeshDelta& delta, Findings& findings);
    void compare(const State& state, Findings& findings) const;

private:
    std::unordered_map<VertexId, Vec3> vertices_;
    std::unordered_map<TetId, std::pair<std::array<VertexId, 4>, Label>> tets_;
};

} // namespace retractor::fuzz
