#pragma once
// What belongs to the tissue and is carried along while it is cut: fibre direction and pre-strain per element, texture
// coordinates per vertex. (Material, label and rest position are the mesh's own.)
//
// An element has the values of the element of the first mesh that it is a part of (MeshDelta::Tet::origin). A vertex
// has the value that the first mesh has at its place, interpolated linearly in an element that one round the vertex is
// a part of: a vertex born on an edge has the edge's value there (as position = (1 - t) a + t b has, but without the
// error that moves would add up), a copy that of its twin, and a moved vertex the value at its new place. So the values
// depend on the state of the session only, and are the same bits again after undo and redo. Linear fields stay linear
// to round-off, moves or not.

#include "mesh/cutting/cut_session.h"

#include <array>
#include <vector>

namespace retractor::mesh {

/// Plain arrays, by id; each may be empty: then there is no such attribute.
struct AttributeArrays {
    std::vector<Vec3> fibre; ///< per element: unit direction, or zero where there is none
    std::vector<std::array<double, 6>> pre_strain; ///< per element: xx, yy, zz, xy, yz, zx, patient LPS
    std::vector<std::array<double, 2>> texture; ///< per vertex
};

class MeshAttributes {
public:
    /// @param mesh the session's first mesh, @param values of it.
    /// @throws InputError on a wrong length or NaN, naming the array.
    MeshAttributes(TetMesh mesh, AttributeArrays values);

    /// After an operation on the session (undo and redo too): costs what the delta is long.
    void follow(const MeshDelta& delta, const CutSession& session);
    /// From whatever state to the session's, at the cost of the whole mesh.
    void take(const CutSession& session);

    /// By the ids of the session; where there is no living element or vertex, a value is zero.
    const AttributeArrays& values() const { return values_; }
    /// By the ids of session.compact_mesh().
    AttributeArrays compact(const SlotMap& map) const;

private:
    void resize(const CutSession& session);
    void take_tet(const CutSession& session, TetId tet);
    void take_vertex(const CutSession& session, VertexId vertex);

    TetMesh mesh_;
    AttributeArrays first_, values_;
};

} // namespace retractor::mesh
