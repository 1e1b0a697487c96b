#pragma once
// Penalty contact of a body's surface with itself (the lips of a wound) and with fixed surfaces (bones, organs),
// without friction. Units mm, N, MPa; vectors have three entries per node of the body.
//
// A point behind the face of its pair has the energy k/2 s^2. Here s < 0 is the signed distance from the face's
// plane, which moves and turns with the face's corners. k is the penalty stiffness times the point's area: a third of
// the area of the faces round the point, projected towards the partner. The derivative pushes point and face apart
// with equal and opposite forces. The points of both surfaces are paired with the faces of the other, each with half
// the stiffness. Edges are not paired with edges: only its vertices hold a sharp edge off.
//
// find() pairs each point with the nearest face that looks towards it (normals opposed), within reach in front and
// behind, and not adjacent to the point. Pairs are kept until the next find(); a pair that was found before the
// surfaces meet acts at any depth. A point behind a face at rest (on the other side of a thin sheet) is not in
// contact with that face. A point a little behind a face at rest (a bent cut, a rough segmentation) keeps this
// overlap without a force, so that rest remains an equilibrium. overlap_at_rest() returns the deepest such overlap.

#include "fem/linear_algebra/block_matrix.h"
#include "fem/material/elasticity.h"
#include "mesh/surface/triangle_hierarchy.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace retractor::fem {

/// Stiffest penalty: bone sinks by 0.1 mm for each MPa of pressure. By its own modulus it would sink by less than its
/// surface is known to, and Newton's method would shorten most of its steps where one of its vertices meets a surface.
inline constexpr double kStiffestN_mm3 = 10.0;

struct ContactOptions {
    /// Stiffness of the penalty: pressure per depth, in P-wave moduli (lambda + 2 mu) of the tissue per edge length.
    /// A pressure of a tenth of the tissue's modulus then causes a depth of a two-hundredth of an edge.
    double stiffness = 20.0;
    /// Upper limit of this stiffness, N/mm^3.
    double stiffest_N_mm3 = kStiffestN_mm3;
    /// search distance, mm; pairs stay complete while a surface moves less than half of it between two calls of
    /// find()
    double reach = 6.0;
    std::vector<TriMesh> fixed {}; ///< fixed surfaces, triangles counter-clockwise seen from outside
};

/// Distance of a point from the plane of a face, positive on the side from which the corners are counter-clockwise,
/// with its derivatives by the point and the three corners (three entries each).
struct PlaneDistance {
    double value = 0.0;
    Eigen::Matrix<double, 12, 1> gradient;
    Eigen::Matrix<double, 12, 12> hessian;
};
PlaneDistance plane_distance(const Vec3& point, const std::array<Vec3, 3>& face);

/// A pattern with more blocks.
/// @param more rows and columns of the blocks, row >= column; blocks may repeat, and may be in the pattern
BlockPattern extended_pattern(const BlockPattern& body, std::vector<std::pair<std::int32_t, std::int32_t>> more);

struct ContactPair {
    /// The point, then the corners of the face. Numbers >= 0 are nodes of the body; ~i is vertex i of the fixed
    /// surfaces.
    std::array<std::int32_t, 4> node {};
    double stiffness = 0.0; ///< N/mm
    double overlap = 0.0; ///< signed distance at rest, mm, <= 0: the energy is zero down to this distance

    bool operator==(const ContactPair&) const = default;
};

class Contact {
public:
    /// @param lame one per element.
    /// @throws InputError on options that are not positive, and on a fixed surface with an empty triangle or a vertex
    /// out of range; the message names the surface and the triangle.
    Contact(const mesh::TetMesh& mesh, const std::vector<Lame>& lame, ContactOptions options);

    /// The points that find() pairs: all points, or only points without a pair. On rough surfaces pairing all points
    /// can alternate between two equilibria without end; pairing only new points cannot.
    enum class Pairing { all_anew, new_only };

    /// Pairs points with faces.
    /// @return whether the pairs differ from the pairs before.
    bool find(const Eigen::VectorXd& displacement, Pairing pairing = Pairing::all_anew);
    /// Pairs points while the body moves from rest to `displacement` along straight lines, in steps that are short
    /// beside the reach: a point that ends deep behind a face is seen to pass through it.
    void follow(const Eigen::VectorXd& displacement);
    const std::vector<ContactPair>& pairs() const { return pairs_; }

    double energy(const Eigen::VectorXd& u) const; ///< N mm
    /// Adds the derivative of the energy to `forces` (N). @return the energy, N mm.
    double add_response(const Eigen::VectorXd& u, Eigen::VectorXd& forces) const;
    /// The body's pattern, extended by blocks that couple the nodes of each pair.
    BlockPattern pattern(const BlockPattern& body) const;
    /// The same pattern with blocks that also couple each point with all faces round the corners of its face. A point
    /// that slides to one of these faces needs no other pattern.
    BlockPattern pattern_with_neighbours(const BlockPattern& body) const;
    /// Whether a pattern couples the nodes of each pair.
    bool is_within(const BlockPattern& pattern) const;
    /// Adds the second derivative of the energy to a matrix with the pattern of pattern(). The part from the turning
    /// of the planes is indefinite and is added only with the share 1 - `projected`.
    void add_stiffness(const Eigen::VectorXd& u, double projected, BlockMatrix& matrix) const;

    struct State {
        std::size_t touching = 0; ///< number of pairs with a force
        double penetration = 0.0; ///< largest penetration, mm
        Vec3 place = Vec3::Zero(); ///< place of the largest penetration, mm
        /// Fixed surface of the largest penetration, as in ContactOptions::fixed; not set: the body with itself.
        std::optional<std::size_t> fixed {};
        double force_N = 0.0; ///< sum of the force magnitudes of all pairs, N
    };
    State state(const Eigen::VectorXd& u) const;

    /// Share (0 to 1) of `motion` that the prescribed nodes can move before one of them lies behind a face of
    /// prescribed nodes. No contact force keeps prescribed nodes apart.
    double free_share(
        const Eigen::VectorXd& u, const Eigen::VectorXd& motion, const std::vector<std::uint8_t>& prescribed) const;

    double overlap_at_rest() const { return overlap_at_rest_; } ///< deepest overlap, mm, >= 0

private:
    using Triangles = std::vector<std::array<VertexId, 3>>;
    struct Surface { ///< rest geometry of a surface
        Points rest;
        Triangles triangles;
        std::vector<VertexId> points; ///< vertices of the triangles, sorted
        std::vector<std::vector<std::int32_t>> around; ///< triangles round each point
        std::vector<double> overlap_self, overlap_other; ///< overlap at rest per point, mm, <= 0
        /// unit normal per point; zero where the triangles of a point face all directions
        Points normals(const Points& positions) const;
        /// area of a point at rest, mm^2
        double area_towards(VertexId point, const Points& positions, const Vec3& direction) const;
    };

    static Surface surface_of(Points rest, Triangles triangles);
    struct Side { ///< a surface at its present place
        const Surface& surface;
        const Points& at;
        bool of_body; ///< false: the fixed surfaces
        const Points& normals; ///< as Surface::normals()
        const mesh::TriangleHierarchy& near; ///< fitted to the present place

        std::int32_t number(VertexId v) const { return of_body ? v : ~v; } ///< as in ContactPair::node
    };
    struct Seeker { ///< a point without a pair yet
        VertexId vertex;
        Vec3 place, normal;
        double overlap; ///< at rest, mm, <= 0
        const ContactPair* before; ///< the last pair of the point, or nullptr
    };
    void pair_points(const Side& points, const Side& faces, Pairing pairing, std::vector<ContactPair>& pairs) const;
    std::optional<std::array<VertexId, 3>> best_face(const Side& points, const Side& faces, const Seeker& seeker) const;
    bool is_adjacent(const Side& points, const Side& faces, VertexId point, const std::array<VertexId, 3>& face) const;
    bool can_meet(
        const Side& points, const Side& faces, const Seeker& seeker, const std::array<VertexId, 3>& triangle) const;
    ContactPair make_pair(
        const Side& points, const Side& faces, const Seeker& seeker, const std::array<VertexId, 3>& triangle) const;
    /// Edge length at a point, or at a face for points of the fixed surfaces, mm.
    double edge_at(const Side& points, VertexId point, const std::array<VertexId, 3>& triangle) const;
    void note_overlaps();
    Points positions(const Eigen::VectorXd& u) const;
    Vec3 place(const Eigen::VectorXd& u, std::int32_t node) const;
    std::array<Vec3, 4> corners(const Eigen::VectorXd& u, const ContactPair& pair) const;

    std::optional<std::size_t> fixed_surface_of(const ContactPair& pair) const;

    ContactOptions options_;
    Surface body_, fixed_;
    std::vector<VertexId> fixed_end_; ///< per fixed surface: the number after its last vertex in fixed_
    std::vector<double> modulus_per_edge_; ///< P-wave modulus over edge length, one per node of the body, N/mm^3
    std::vector<double> edge_; ///< edge length, one per node of the body, mm
    std::optional<mesh::TriangleHierarchy> near_body_, near_fixed_; ///< set by the constructor
    Points fixed_normals_; ///< as Surface::normals()
    std::vector<ContactPair> pairs_;
    double overlap_at_rest_ = 0.0;
};

} // namespace retractor::fem
