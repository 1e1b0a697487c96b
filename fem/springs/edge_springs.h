#pragma once
// A mass-spring network on the edges of a four-node mesh: what opens a wound while the blade is still moving.
// Units mm, N, MPa; frame patient LPS; ids are those of the cutting session.
//
// Stiffness. A spring along the unit direction d with stiffness k and length L adds k L^2 (d.e.d)^2 / 2 to the energy
// of a strain e. In each element the six stiffnesses are those whose stress-strain tensor, sum k L^2 d^4 / V, is
// nearest to that of isotropic tissue with Young's modulus E, by least squares with none negative. Central forces
// fix Poisson's ratio at 1/4 (lambda = mu = 2 E / 5), so the material's own is not used. In a regular tetrahedron of
// edge l this is k = (2 sqrt(2) / 25) E l, the value of [Lloyd, Szekely, Harders 2007, doi 10.1109/TVCG.2007.1055];
// [Van Gelder 1998, doi 10.1080/10867651.1998.10487496] has k = E V / L^2, the same up to 4 % there. A network gives
// way between its vertices where a finite element does not, so that its modulus is a little off: `calibration` scales
// it. spring_calibration() in tests/verification/framework/tension.h measures on a mesh, against finite elements, what
// the factor ought to be.
//
// Braces. All edges of a flat element lie near one plane: whatever their stiffness, they do not resist the slip of one
// side over the other, which costs a finite element the more the flatter it is. So where six edges are far from
// isotropic (their tensor misses by more than kGoodFit), a share of their work is given to six springs inside the
// element, along the axes of an icosahedron, which together are isotropic exactly. They end on the element's own
// faces, so that what they pull at is its corners.
//
// Tension. Six edge tensions represent a stress in an element exactly: T / L = -V grad N_i . sigma0 . grad N_j. Springs
// so pre-stressed pull at the vertices as finite elements under sigma0 do; in a uniform field nothing is unbalanced.
// The uncut body is in equilibrium by definition (fem/pre_strain.h): what the tensions leave unbalanced at rest is
// taken as held, and only the lips are let go.
//
// Springs alone let an element be pushed through itself: slack springs carry compression, as tissue does, but nothing
// resists when a corner has passed its face. Below kCrushed of its volume an element therefore resists with a cubic
// penalty, as in fem/elasticity.h.

#include "fem/material/material.h"
#include "mesh/cutting/ablated_values.h"
#include "mesh/cutting/cut_session.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace retractor::fem {

/// What one element gives to its six edges, in the order of kTetEdges.
struct ElementSprings {
    std::array<double, 6> stiffness {}; ///< N/mm, >= 0
    std::array<double, 6> force_density {}; ///< tension over length, N/mm
    double brace = 0.0; ///< MPa: per volume and strain of each of brace_axes(); 0: the element has none
};

/// The six axes of an icosahedron, unit.
const std::array<Vec3, 6>& brace_axes();
/// Share of the isotropic tensor's norm by which six edges may miss it before braces take a part: a regular tetrahedron
/// misses it by 0.2, a flat prism's part by 0.5.
inline constexpr double kGoodFit = 0.25;

/// @param corners with positive volume; @param stress the pre-stress, MPa.
ElementSprings element_springs(const std::array<Vec3, 4>& corners, double youngs_modulus_MPa, const Mat3& stress);

/// Half of a spring: as seen from one of its ends.
struct SpringEnd {
    VertexId other = 0;
    double length = 0.0; ///< at rest, mm
    double stiffness = 0.0; ///< N/mm
    double force_density = 0.0; ///< N/mm
};

struct SpringOptions {
    double calibration = 1.0; ///< on every stiffness; see "Stiffness" above
};

class SpringNetwork {
public:
    /// Share of its volume below which an element resists being crushed.
    static constexpr double kCrushed = 0.25;

    /// On a mesh that a session has just been, or will be, started with.
    /// @param stress_of_element one per element (fem/pre_strain.h), or none at all.
    /// @throws InputError on a mesh check_mesh() refuses, ten-node elements, a label without a material or with a bad
    /// one, a calibration that is not positive, stresses that are not finite or of a wrong number.
    SpringNetwork(const mesh::TetMesh& mesh, std::span<const Material> material_of_label,
        std::span<const Mat3> stress_of_element = {}, SpringOptions options = {});
    /// On a session that has cuts already; `stress_of_element` by the elements of its first mesh.
    /// Copies of the cuts made before are not known to copies(); vertices that an ablation took before come back free
    /// when it is undone: fix() them then.
    SpringNetwork(const mesh::CutSession& session, std::span<const Material> material_of_label,
        std::span<const Mat3> stress_of_element = {}, SpringOptions options = {});

    /// Follows a cut, an undo or a redo: only edges of elements born, gone or with a moved corner are summed anew, from
    /// their elements in the order of their ids, so that the network has the bits of one built afresh. New vertices
    /// lie where the tissue they are made of lies now; one on an edge between two fixed vertices is fixed as both are.
    /// A vertex that comes back without this network having seen it go is free.
    /// @throws InputError on a new element without volume, material or pre-stress; the network must not be used then.
    void apply(const mesh::MeshDelta& delta);
    /// The faces of all wounds, as CutSession::lips() has them after that delta: where tension is set free.
    /// @throws InputError on a face of an element that does not exist.
    void set_wound(std::span<const mesh::LipFace> lips);

    /// Vertices that stay where they are now, or only along some axes (a plane of symmetry); further calls add to them.
    /// @param axes bits 1, 2, 4 for x, y, z. @throws InputError on an id or axes out of range.
    void fix(std::span<const VertexId> vertices, unsigned axes = kAllAxes);
    static constexpr unsigned kAllAxes = 7;
    bool is_fixed(VertexId v) const { return fixed_axes(v) == kAllAxes; }
    unsigned fixed_axes(VertexId v) const { return fixed_[static_cast<std::size_t>(v)]; }

    std::size_t vertex_slots() const { return rows_.size(); } ///< ids are smaller than this
    std::size_t spring_count() const;
    std::span<const SpringEnd> springs(VertexId v) const { return rows_[static_cast<std::size_t>(v)]; }
    const Points& rest() const { return rest_; } ///< one row per id; rows of ids not in use mean nothing
    const Points& displacement() const { return displacement_; } ///< likewise, mm
    /// @throws InputError on a wrong number of rows or on NaN; fixed vertices keep theirs.
    void set_displacement(const Points& displacement);
    /// One vertex; it stays along its fixed axes. @pre finite
    void place(VertexId v, const Vec3& displacement);
    Points positions() const { return rest_ + displacement_; }
    const Vec3& release(VertexId v) const { return release_[static_cast<std::size_t>(v)]; } ///< load on a lip, N
    std::span<const VertexId> lip_vertices() const { return lip_vertices_; } ///< by id
    /// Living vertices that were one before a cut parted them: original and copy; where the original was ablated, the
    /// oldest copy stands in for it.
    std::vector<std::pair<VertexId, VertexId>> copies() const;

    /// Living elements round a vertex, by id.
    std::span<const TetId> elements(VertexId v) const { return around_[static_cast<std::size_t>(v)]; }
    const std::array<VertexId, 4>& nodes(TetId t) const { return tets_[static_cast<std::size_t>(t)].nodes; }
    double rest_volume(TetId t) const { return tets_[static_cast<std::size_t>(t)].volume; } ///< mm^3
    Label label(TetId t) const { return tets_[static_cast<std::size_t>(t)].label; }
    double crush_stiffness(TetId t) const; ///< MPa, of the penalty
    double brace(TetId t) const { return tets_[static_cast<std::size_t>(t)].springs.brace; } ///< MPa
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

    /// Tells a vertex from others that had its id before or will have it.
    struct Identity {
        std::uint32_t own = 0; ///< rises with age; 0: no vertex
        std::uint32_t original = 0; ///< of the vertex it was parted from, or its own
    };

    void check_options(std::span<const Mat3> stresses, std::size_t elements) const;
    void make_room(std::size_t vertices, std::size_t tets);
    void insert(TetId id, const std::array<VertexId, 4>& nodes, Label label, TetId origin);
    void remove(TetId id);
    void measure(TetId id);
    void sum_row(VertexId v);
    void take_in(const mesh::MeshDelta::VertexBorn& born);
    Identity new_identity();

    SpringOptions options_;
    std::vector<Material> materials_;
    std::vector<Mat3> stress_of_origin_;
    Points rest_, displacement_;
    std::vector<std::uint8_t> fixed_;
    std::vector<Identity> identity_;
    std::uint32_t last_identity_ = 0;
    struct Ablated {
        std::uint8_t fixed = 0;
        Identity identity;
    };
    mesh::AblatedValues<Ablated> ablated_;
    std::vector<std::vector<TetId>> around_;
    std::vector<std::vector<SpringEnd>> rows_; ///< by the other end's id
    std::vector<Tet> tets_;
    std::vector<Vec3> release_;
    std::vector<VertexId> lip_vertices_;
};

/// Largest distance between two vertices that a cut parted, mm; 0 without a wound.
double widest_gape(const SpringNetwork& network);

} // namespace retractor::fem
