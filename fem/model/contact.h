#pragma once
// Contact of a body's surface with itself (the lips of a wound) and with fixed surfaces (bones, organs), by a penalty.
// Units mm, N, MPa; vectors have three entries per node of the body.
//
// A point that lies behind the face it is paired with, s < 0, has the energy k/2 s^2: s is the signed distance from the
// face's plane, which moves and turns with its corners, k the penalty's stiffness times the area the point stands for
// (of the faces round it, a third as far as they look towards its partner). Its derivative pushes the point and the
// face apart with opposite, equal forces. Both surfaces' points are taken against the other's faces, each with half the
// stiffness. Edges are not paired with edges: a sharp edge is held off by its points alone.
//
// find() pairs each point with the nearest face that looks towards it (normals opposed), within reach in front and
// behind, other than those next to it; pairs stay as they are until the next find(), and a pair found before the
// surfaces meet acts however far they are then pushed. A point behind a face at rest (the other side of a thin sheet)
// is not in contact with it; one that lies a little behind (a bent cut, a rough segmentation) keeps that overlap
// without a force, so that rest stays an equilibrium: overlap_at_rest() says how much there is.

#include "fem/linear_algebra/block_matrix.h"
#include "fem/material/elasticity.h"
#include "mesh/surface/proximity.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace retractor::fem {

struct ContactOptions {
    /// Of the penalty: pressure per depth, in P-wave moduli (lambda + 2 mu) of the tissue per length of an edge. Tissue
    /// under a pressure of a tenth of its modulus is then pressed in by a two hundredth of an edge.
    double stiffness = 20.0;
    double reach = 6.0; ///< mm; twice what a surface moves between two calls of find()
    std::vector<TriMesh> fixed {}; ///< surfaces that do not move, counter-clockwise seen from outside
};

/// Distance of the first point from the plane of the other three, positive on the side from which they are
/// counter-clockwise, with its derivatives by all four (three entries each).
struct PlaneDistance {
    double value = 0.0;
    Eigen::Matrix<double, 12, 1> gradient;
    Eigen::Matrix<double, 12, 12> hessian;
};
PlaneDistance plane_distance(const Vec3& point, const std::array<Vec3, 3>& face);

struct ContactPair {
    /// The point and the corners of the face: nodes of the body, or ~i for corner i of the fixed surfaces.
    std::array<std::int32_t, 4> node {};
    double stiffness = 0.0; ///< N/mm
    double overlap = 0.0; ///< at rest, mm, <= 0: the energy begins there

    bool operator==(const ContactPair&) const = default;
};

class Contact {
public:
    /// @param lame one per element.
    /// @throws InputError on options that are not positive, and naming the fixed surface and triangle that has no area
    /// or a vertex out of range.
    Contact(const mesh::TetMesh& mesh, const std::vector<Lame>& lame, ContactOptions options);

    /// Which points find() pairs: where surfaces are rough, two sets of pairs can lead to each other's equilibrium
    /// without end, which new ones alone cannot.
    enum class Pairing { all_anew, new_only };

    /// Pairs points with faces. @return whether the pairs are others than before.
    bool find(const Eigen::VectorXd& displacement, Pairing pairing = Pairing::all_anew);
    const std::vector<ContactPair>& pairs() const { return pairs_; }

    double energy(const Eigen::VectorXd& u) const; ///< N mm
    /// The same; its derivative is added to `forces`.
    double add_response(const Eigen::VectorXd& u, Eigen::VectorXd& forces) const;
    /// The pattern with the pairs' nodes coupled.
    BlockPattern pattern(const BlockPattern& body) const;
    /// Adds the second derivative, to a matrix with such a pattern; the part of the planes' turning only to the share
    /// 1 - `projected`, for it is indefinite.
    void add_stiffness(const Eigen::VectorXd& u, double projected, BlockMatrix& matrix) const;

    struct State {
        std::size_t touching = 0; ///< pairs with a force
        double penetration = 0.0; ///< the deepest, mm
        Vec3 place = Vec3::Zero(); ///< where
        double force_N = 0.0; ///< sum of the pairs' forces' sizes
    };
    State state(const Eigen::VectorXd& u) const;

    /// How far along `motion` the nodes that are prescribed may go before they are behind faces of prescribed nodes:
    /// no force holds those apart. 1: all the way.
    double free_share(
        const Eigen::VectorXd& u, const Eigen::VectorXd& motion, const std::vector<std::uint8_t>& prescribed) const;

    double overlap_at_rest() const { return overlap_at_rest_; } ///< the deepest, mm, >= 0

private:
    using Triangles = std::vector<std::array<VertexId, 3>>;
    struct Surface { ///< points and triangles with what does not change
        Points rest;
        Triangles triangles;
        std::vector<VertexId> points; ///< those in triangles, rising
        std::vector<std::vector<std::int32_t>> around; ///< per point: triangles
        std::vector<double> overlap_self, overlap_other; ///< at rest, per point, <= 0
        Points normals(const Points& positions) const; ///< per point, unit; zero where its triangles look all ways
        double area_towards(VertexId point, const Points& positions, const Vec3& direction) const; ///< mm^2, at rest
    };

    static Surface surface_of(Points rest, Triangles triangles);
    void pair_points(const Surface& points, const Points& at, const Surface& faces, const Points& faces_at,
        const mesh::TriangleProximity& near, bool body_points, bool body_faces, const std::vector<double>& overlap,
        Pairing pairing, std::vector<ContactPair>& pairs) const;
    void note_overlaps();
    Points positions(const Eigen::VectorXd& u) const;
    Vec3 place(const Eigen::VectorXd& u, std::int32_t node) const;
    std::array<Vec3, 4> corners(const Eigen::VectorXd& u, const ContactPair& pair) const;

    ContactOptions options_;
    Surface body_, fixed_;
    std::vector<double> modulus_per_edge_; ///< per node of the body: N/mm^3
    std::vector<double> edge_; ///< per node of the body: mm
    std::optional<mesh::TriangleProximity> near_fixed_;
    std::vector<ContactPair> pairs_;
    double overlap_at_rest_ = 0.0;
};

} // namespace retractor::fem
