#pragma once
// A mass-spring network on the edges of a four-node mesh. The network opens a wound while the blade is still moving.
// Units mm, N, MPa; frame patient LPS; ids are the ids of the cutting session.
//
// Stiffness. A spring along the unit direction d with stiffness k and length L adds k L^2 (d.e.d)^2 / 2 to the energy
// of a strain e. In each element the six stiffnesses are those whose stress-strain tensor, sum k L^2 d^4 / V, is
// nearest to the tensor of isotropic tissue with Young's modulus E, by least squares with no negative stiffness.
// Central forces fix Poisson's ratio at 1/4 (lambda = mu = 2 E / 5), so the material's own ratio is not used. In a
// regular tetrahedron of edge l this gives k = (2 sqrt(2) / 25) E l, the value of [Lloyd, Szekely, Harders 2007, doi
// 10.1109/TVCG.2007.1055]. [Van Gelder 1998, doi 10.1080/10867651.1998.10487496] has k = E V / L^2, which differs by
// up to 4 % there. A network yields between its vertices where a finite element does not, so its modulus is slightly
// off: spring_calibration() (tests/verification/framework/tension.h) measures the factor on a mesh.
//
// Braces. All edges of a flat element lie near one plane. Whatever their stiffness, such edges do not resist the slip
// of one side over the other, although the slip costs a finite element more energy the flatter the element is. Where
// six edges are far from isotropic (their tensor misses by more than kGoodFit), six springs inside the element
// therefore take a share of the work. These braces lie along the axes of an icosahedron and are exactly isotropic
// together. Braces end on the element's own faces, so they pull at the element's corners.
//
// Tension. Six edge tensions represent a stress in an element exactly: T / L = -V grad N_i . sigma0 . grad N_j.
// Springs with this pre-stress pull at the vertices like finite elements under sigma0; in a uniform field nothing is
// unbalanced. The uncut body is in equilibrium by definition (pre_strain.h): forces that the tensions leave
// unbalanced at rest count as held, and only the lips are released.
//
// Inversion. Slack springs carry compression, as tissue does, but springs do not resist a corner that has passed the
// opposite face. An element below kCrushed of its volume therefore resists with a cubic penalty, as in elasticity.h.

#include "fem/material/material.h"
#include "mesh/cutting/ablated_values.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace retractor::fem {

/// Springs of one element on its six edges, in the order of kTetEdges.
struct ElementSprings {
    std::array<double, 6> stiffness {}; ///< N/mm, >= 0
    std::array<double, 6> force_density {}; ///< tension over length, N/mm
    /// stiffness of each brace along brace_axes(), per volume and strain, MPa; 0: the element has no braces
    double brace = 0.0;
};

/// The six axes of an icosahedron, unit vectors.
const std::array<Vec3, 6>& brace_axes();
/// Largest misfit of six edges without braces, relative to the norm of the isotropic tensor. A regular tetrahedron
/// has a misfit of 0.2, an element of a flat prism 0.5.
inline constexpr double kGoodFit = 0.25;

/// Springs of an element at rest.
/// @param corners with positive volume, mm.
/// @param stress the pre-stress, MPa.
ElementSprings element_springs(const std::array<Vec3, 4>& corners, double youngs_modulus_MPa, const Mat3& stress);

/// A spring as seen from one of its two ends.
struct SpringEnd {
    VertexId other = 0;
    double length = 0.0; ///< at rest, mm
    double stiffness = 0.0; ///< N/mm
    double force_density = 0.0; ///< tension over length, N/mm
};

class SpringNetwork {
public:
    /// Share of the rest volume below which an element resists being crushed.
    static constexpr double kCrushed = 0.25;

    /// A network on a session, which may have cuts already. When an ablation from before is undone, its vertices
    /// return free: call fix() for them.
    /// @param stress_of_element pre-stress (pre_strain.h), one per element of the session's first mesh, or empty.
    /// @throws InputError on a label whose material is missing or invalid, and on stresses that are missing or not
    /// finite.
    SpringNetwork(const mesh::CutSession& session, std::span<const Material> material_of_label,
        std::span<const Mat3> stress_of_element = {});

    /// Follows a cut, an undo or a redo. Only edges of elements that were added, removed or have a moved corner are
    /// summed again, from their elements in the order of the ids; the network is therefore equal, bit by bit, to a
    /// newly built one. A new vertex lies where its tissue lies now. A new vertex on an edge between two fixed
    /// vertices is fixed along the axes that both have fixed. A vertex that returns, but was removed before this
    /// network existed, is free.
    /// @throws InputError on a new element without volume, material or pre-stress; the network must not be used
    /// afterwards.
    void apply(const mesh::MeshDelta& delta);
    /// Sets the faces of all wounds, at which tension is released. Pass CutSession::lips() after each delta.
    /// @throws InputError on a face of an element that does not exist.
    void set_wound(std::span<const mesh::LipFace> lips);

    /// Fixes vertices where they are now, completely or along some axes only (in a plane of symmetry). Further calls
    /// add axes.
    /// @param axes bits 1, 2, 4 for x, y, z.
    /// @throws InputError on an id or axes out of range.
    void fix(std::span<const VertexId> vertices, unsigned axes = kAllAxes);
    static constexpr unsigned kAllAxes = 7;
    bool is_fixed(VertexId v) const { return fixed_axes(v) == kAllAxes; }
    unsigned fixed_axes(VertexId v) const { return fixed_[static_cast<std::size_t>(v)]; }

    std::size_t vertex_slots() const { return rows_.size(); } ///< upper limit of the vertex ids
    std::size_t spring_count() const;
    std::span<const SpringEnd> springs(VertexId v) const { return rows_[static_cast<std::size_t>(v)]; }
    /// rest positions, mm, one row per id; rows of unused ids have no meaning
    const Points& rest() const { return rest_; }
    /// displacements, mm, one row per id; rows of unused ids have no meaning
    const Points& displacement() const { return displacement_; }
    /// Sets all displacements, mm; fixed vertices keep theirs.
    /// @throws InputError on a wrong number of rows or on NaN.
    void set_displacement(const Points& displacement);
    /// Sets the displacement of one vertex, mm, except along its fixed axes.
    /// @pre the displacement is finite
    void place(VertexId v, const Vec3& displacement);
    Points positions() const { return rest_ + displacement_; }
    /// load of the released tension at a vertex of a lip, N
    const Vec3& release(VertexId v) const { return release_[static_cast<std::size_t>(v)]; }
    std::span<const VertexId> lip_vertices() const { return lip_vertices_; } ///< sorted by id

    /// Living elements round a vertex, sorted by id.
    std::span<const TetId> elements(VertexId v) const { return around_[static_cast<std::size_t>(v)]; }
    const std::array<VertexId, 4>& nodes(TetId t) const { return tets_[static_cast<std::size_t>(t)].nodes; }
    double rest_volume(TetId t) const { return tets_[static_cast<std::size_t>(t)].volume; } ///< mm^3
    Label label(TetId t) const { return tets_[static_cast<std::size_t>(t)].label; }
    double crush_stiffness(TetId t) const; ///< stiffness of the penalty on crushing, MPa
    /// stiffness of each brace, MPa
    double brace(TetId t) const { return tets_[static_cast<std::size_t>(t)].springs.brace; }
    std::size_t bytes() const;

private:
    struct Tet {
        std::array<VertexId, 4> nodes {};
        double volume = 0.0;
        Label label = 0;
        TetId origin = 0;
        bool alive = false;
        ElementSprings springs;
    };

    void make_room(std::size_t vertices, std::size_t tets);
    void insert(TetId id, const std::array<VertexId, 4>& nodes, Label label, TetId origin);
    void remove(TetId id);
    void measure(TetId id);
    void sum_row(VertexId v);
    void take_in(const mesh::MeshDelta::VertexBorn& born);

    std::vector<Material> materials_;
    std::vector<Mat3> stress_of_origin_;
    Points rest_, displacement_;
    std::vector<std::uint8_t> fixed_;
    mesh::AblatedValues<std::uint8_t> ablated_fixed_;
    std::vector<std::vector<TetId>> around_;
    std::vector<std::vector<SpringEnd>> rows_; ///< per vertex, sorted by the id of the other end
    std::vector<Tet> tets_;
    std::vector<Vec3> release_;
    std::vector<VertexId> lip_vertices_;
};

} // namespace retractor::fem
