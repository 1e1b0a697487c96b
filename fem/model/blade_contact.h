#pragma once
// Rigid blades in unilateral contact with tissue and bone. Units mm, N, MPa; vectors have three entries per node.
//
// A blade is a flat rectangle. Three nodes without elements carry it: its middle, and the ends of its half width and
// its half height. These nodes are prescribed like the nodes of a hook, so that the blade moves and turns with them,
// and the derivatives of the contact energy at the three nodes are the load of the blade: resultant force and moment
// are exact, because the energy does not change when blade and tissue move together as one rigid body.
//
// Contact is an integral over faces of the tissue that look at the blade, the wound's lip and the surface of bone
// (blade_samples.h). No pairs are searched for. A sample at the place x of a face has the energy
//   area w ( k/2 min(0, g)^2 + h_c(s) ).
// g is the distance of x from the plane of the blade less the distance at which the sample bears. So a blade pushes and
// never pulls. w fades from 1 to 0 across the edges of the rectangle at rest: the same tissue stays under the blade. s
// is the way of x along the blade since rest, and h_c the energy of a spring of stiffness k_t that slips at the stress
// c (Huber 1964, doi 10.1214/aoms/1177703732; a given limit of slip is the friction of Tresca). The friction opposes
// the whole way since rest, so the answer does not depend on the steps in which the blade was moved.
//
// c is even over the soft tissue under a blade, and over the bone under it. Its sum is the friction coefficient times
// the force that this tissue bears: the law of Coulomb for the sum. Coulomb's law at each sample has no equilibrium
// where bone bears on an edge: there friction shifts the pressure, and pressure the friction, to and fro.
//
// Within Newton's method c is constant, and the energy is convex but for the turning of the blade. renew() takes c from
// the present state.
//
// Error. The blade sinks by pressure over k into the tissue. k is set so that a pressure of a tenth of a tissue's
// modulus sinks by a two-hundredth of an edge, and on bone by 0.1 mm for each MPa of pressure (kStiffestN_mm3). The
// pattern of the stiffness has blocks between the nodes of a blade and those of its faces, and never changes.

#include "fem/linear_algebra/block_matrix.h"
#include "fem/model/contact.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace retractor::fem {

/// Width of the band across the edges of a blade in which its pressure fades, mm: the rounding of a blade's edge.
inline constexpr double kBladeFadeMm = 2.0;
/// Stiffness of the spring along the blade, relative to the stiffness of the penalty.
inline constexpr double kStickShare = 0.1;
/// Side of the squares of a blade over which its pressure is averaged, mm. At the edge of a blade pressure has no bound
/// under refinement; its average has one.
inline constexpr double kPressureCellMm = 5.0;

/// A place on a face of an element that a blade can touch.
struct BladeSample {
    TetId tet = 0;
    std::array<double, 4> barycentric {}; ///< place, by the corners of the element; also for ten-node elements
    double area = 0.0; ///< at rest, mm^2
    double stiffness = 0.0; ///< k: pressure per depth, N/mm^3
    double bears_at_mm = 0.0; ///< distance from the blade at which the sample bears
    bool bone = false;
};

/// A blade and the places that it can touch.
struct BladeSurface {
    std::string name; ///< of the blade's hook
    /// Middle of the blade, the end of its half width and the end of its half height. Counter-clockwise seen from the
    /// tissue that the blade pushes.
    std::array<VertexId, 3> nodes {};
    double half_width_mm = 0.0, half_height_mm = 0.0;
    double friction = 0.0; ///< friction over pressure, >= 0
    std::vector<BladeSample> samples;
};

/// How a blade bears.
struct BladeBearing {
    double force_N = 0.0; ///< sum of the normal forces
    double bone_force_N = 0.0; ///< the part of it on bone behind soft tissue
    double area_mm2 = 0.0; ///< area of tissue at rest that touches the blade; bone behind soft tissue is not counted
    double pressure_largest_MPa = 0.0; ///< mean over a square of kPressureCellMm, where it is largest
    /// Middle of this square, mm from the middle of the blade along its width and its height.
    double largest_along_mm = 0.0, largest_deep_mm = 0.0;
    double penetration_mm = 0.0; ///< largest depth by which tissue passes into the blade: the error of the penalty

    double pressure_mean_MPa = 0.0; ///< mean over the squares that bear
    /// Sum of the normal forces on each third of the blade's width, from the end that faces away from its second node.
    std::array<double, 3> thirds_N {};
};

class BladeContact {
public:
    /// @param mesh of four-node or ten-node elements, with the nodes of the blades
    /// @throws InputError naming the blade, when a number is out of range, a node does not exist, or its three nodes do
    /// not span its rectangle
    BladeContact(const mesh::TetMesh& mesh, std::vector<BladeSurface> blades);

    /// Moves the friction by a share of its way to the friction of the state u; all the way at first, and where there
    /// was none or is to be none. A body at rest does not slip.
    void renew(const Eigen::VectorXd& u, double share = 1.0);
    /// The largest friction force that is missing or too much at the state u, relative to the largest force of a blade;
    /// infinite where friction acts on a blade that bears nothing, and before the first renew().
    double friction_error(const Eigen::VectorXd& u) const;

    /// From now on the samples that touch at `u` count as touching: their spring pushes and pulls. A step of the blade
    /// can so be linearised before the tissue has followed.
    void expect(const Eigen::VectorXd& u);
    void expect_nothing(); ///< ends expect() and prepare_search()
    /// Prepares the stiffness for a search of the places of the blades, where the tissue follows them: on a blade that
    /// touches nothing at `u` the nearest samples count as touching, and a spring that slips has its secant stiffness,
    /// which does not vanish in the direction of the slip. A step with this stiffness does not go too far.
    void prepare_search(const Eigen::VectorXd& u);

    double energy(const Eigen::VectorXd& u) const; ///< N mm
    /// Adds the derivative of the energy to `forces` (N). @return the energy, N mm
    double add_response(const Eigen::VectorXd& u, Eigen::VectorXd& forces) const;
    /// The pattern of the body, extended by the blocks between blades and faces.
    BlockPattern pattern(const BlockPattern& body) const;
    /// Adds the second derivative of the energy to a matrix with the pattern of pattern(). The part from the turning of
    /// the blade is indefinite and is added only with the share 1 - `projected`.
    void add_stiffness(const Eigen::VectorXd& u, double projected, BlockMatrix& matrix) const;

    /// Largest contact force at a node of the tissue, N: the scale of a residual.
    double largest_nodal_force(const Eigen::VectorXd& u) const;
    std::vector<BladeBearing> bearing(const Eigen::VectorXd& u) const; ///< one per blade
    /// The elements with a sample under the rectangle at rest, rising.
    std::vector<TetId> covered_elements() const;
    const std::vector<BladeSurface>& blades() const { return blades_; }

private:
    struct Pose { ///< of a blade: its nodes, and its axes
        std::array<Vec3, 3> node;
        Vec3 normal, along, deep; ///< unit; `along` and `deep` follow the two edges
        double along_mm, deep_mm; ///< lengths of the edges
    };
    struct Place { ///< of a sample, seen from its blade
        Vec3 x;
        double gap, along, deep; ///< mm; gap as g in the first comment
    };
    struct Sample {
        std::int32_t blade = 0;
        std::int32_t begin = 0, end = 0; ///< its nodes and their weights in node_ and weight_
        double along_at_rest = 0.0, deep_at_rest = 0.0;
        double share = 0.0; ///< w
        bool expected = false;
    };

    /// Soft tissue or bone under a blade.
    struct Group {
        double area = 0.0; ///< sum of area times w, mm^2
        double slips_at = 0.0; ///< c, MPa; 0: no friction
        bool slips = false; ///< false: as at rest, where nothing slips
    };

    const BladeSample& given(std::size_t sample) const;
    std::vector<std::array<double, 2>> group_forces(const Eigen::VectorXd& u) const; ///< normal forces, N
    const Group& group(std::size_t sample) const;
    double slips_at(std::size_t sample) const;
    Pose pose(const Eigen::VectorXd& u, std::size_t blade) const;
    std::vector<Pose> poses(const Eigen::VectorXd& u) const;
    Place place(const Eigen::VectorXd& u, const Pose& pose, std::size_t sample) const;
    double share_at(const Place& place, std::size_t blade) const;
    Vec3 force_on(const Pose& pose, const Place& place, std::size_t sample) const;
    Vec3 moved(VertexId v, const Eigen::VectorXd& u) const; ///< place of a node
    double energy_of(const Place& place, std::size_t sample) const;

    Points rest_; ///< of all nodes
    std::vector<BladeSurface> blades_;
    std::vector<std::array<Group, 2>> groups_; ///< per blade: soft tissue and bone
    std::vector<std::size_t> first_; ///< index of the first sample of each blade, and their number
    std::vector<Sample> samples_;
    std::vector<VertexId> node_;
    std::vector<double> weight_;
    bool secant_friction_ = false; ///< prepare_search()
};

} // namespace retractor::fem
