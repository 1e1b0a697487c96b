#pragma once
// What must hold of a cutting session after every stroke, told apart from the cutter: checks here share no code with
// it beyond the contract and the blade's own coordinates. Units mm.

#include "mesh/base/error.h"
#include "mesh/cutting/cut_session.h"

#include <array>
#include <map>
#include <string>
#include <vector>

namespace retractor::fuzz {

/// A broken guarantee.
struct Finding {
    std::string invariant; ///< short name, to be counted by
    std::string detail;
};
using Findings = std::vector<Finding>;

/// Whether the error is one of those that a stroke may be refused with: a blade that crosses or folds into itself, lips
/// that would hang together, an element without volume. Any other is a fault.
bool is_named_refusal(const Error& error);

/// Everything a session shows of itself.
struct State {
    explicit State(const mesh::CutSession& session);
    mesh::SlotMap map;
    mesh::TetMesh mesh;
    std::vector<TetId> origins; ///< per compact element
    std::vector<mesh::LipFace> lips; ///< ids of `mesh`
    std::vector<VertexId> pinched; ///< ids of `mesh`
    std::size_t cuts = 0, tets = 0, vertices = 0;

    // Worked out from the mesh, once.
    std::vector<mesh::TetFace> boundary; ///< faces of one element only
    std::size_t faces = 0; ///< different ones
    Findings face_findings; ///< faces of more than two elements, or with both on one side
};

/// Bit for bit, ids included.
bool same_bits(const State& a, const State& b);

/// What the body is made of, for the account of a stroke.
struct Topology {
    long body = 0; ///< Euler characteristic of the body
    long surface = 0; ///< of its surface
    long pieces = 0; ///< parts joined by faces
    long shells = 0; ///< parts of the surface joined by edges
    long pinches = 0; ///< fans of surface at a vertex beyond the first, summed
    long handles = 0; ///< of all shells, pinches taken apart
};

/// Volumes positive, faces matched, surface closed and manifold but for the pinched vertices, lips on the surface,
/// Euler characteristic of the body that of its surface, and an account of both by pieces, shells, handles and pinches.
Topology check_sound(const State& state, Findings& findings);
/// The wound of one stroke must explain how the Euler characteristic changed.
/// @param copies per vertex (session id) that the stroke made as a copy of another: that one.
void check_account(const State& before, const State& after, const std::map<VertexId, VertexId>& copies,
    const Topology& was, const Topology& is, Findings& findings);

/// What one cut may have changed: volumes, surface, lips, extent.
/// @param first the body before any cut, for local edge lengths.
void check_cut(const State& before, const State& after, const mesh::TetMesh& first, const mesh::Blade& blade,
    const mesh::CutOptions& options, const mesh::CutReport& report, Findings& findings);

/// What an ablation may have changed: what is marked is gone and nothing else.
void check_ablation(const State& before, const State& after, const std::vector<TetId>& marked,
    const mesh::CutReport& report, Findings& findings);

/// A mesh kept by deltas alone.
class Mirror {
public:
    explicit Mirror(const State& state);
    void follow(const mesh::MeshDelta& delta, Findings& findings);
    void compare(const State& state, Findings& findings);

private:
    struct Vertex {
        Vec3 position = Vec3::Zero();
        bool alive = false;
    };
    struct Tet {
        std::array<VertexId, 4> nodes {};
        Label label = 0;
        bool alive = false;
    };
    Vertex* vertex(VertexId v);
    Tet* tet(TetId t);
    std::vector<Vertex> vertices_; ///< by session id
    std::vector<Tet> tets_;
    std::size_t vertex_count_ = 0, tet_count_ = 0;
};

} // namespace retractor::fuzz
