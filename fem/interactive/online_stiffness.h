#pragma once
// The stiffness of small-strain P1 elasticity that follows a CutSession by its deltas. Pattern and values cost work
// that grows with the cut, not with the mesh, and depend on the mesh alone, not on its history: a row is always summed
// over the elements round its node in rising id, so that after any sequence of cuts, undos and redos the row has the
// same bits as a fresh assembly. Rows and vectors are indexed by the session's vertex ids, with three entries per
// vertex; ids that are not alive have empty rows. Units mm, N, MPa.

#include "fem/material/elasticity.h"
#include "fem/material/material.h"
#include "fem/model/hinge.h"
#include "mesh/cutting/ablated_values.h"
#include "mesh/cutting/cut_session.h"

#include <Eigen/Core>

#include <array>
#include <map>
#include <span>
#include <vector>

namespace retractor::fem {

class OnlineStiffness {
public:
    /// @param material_of_label indexed by the elements' labels.
    /// @param stress_of_element tension (MPa, symmetric) per element of the session's first mesh, which wounds release
    /// (pre_strain.h); empty: none
    /// @throws InputError on bad materials, a label without material, a stress that is not finite or not symmetric, or
    /// a wrong number of stresses.
    OnlineStiffness(const mesh::CutSession& session, std::span<const Material> material_of_label,
        std::span<const Mat3> stress_of_element = {});

    /// Sets springs to the ground, N/mm per vertex id, equally stiff in every direction: a bed of tissue that is not
    /// modelled. Vertices that cuts add have no spring. Vertices that an undone ablation brings back have their spring,
    /// unless they were ablated before this call. Values of ids without a living vertex are not used.
    /// @throws InputError on negative or infinite values
    void set_bed(std::vector<double> stiffness);
    double bed(VertexId v) const
    {
        return static_cast<std::size_t>(v) < bed_.size() ? bed_[static_cast<std::size_t>(v)] : 0.0;
    }

    /// Sets hinges by their stiffness at rest (hinge.h). An edge acts while both its vertices have the position that
    /// they have at this call, and share an element.
    /// @throws InputError on an edge whose vertices do not live or share no element
    void set_hinges(std::vector<Hinge> hinges);
    std::vector<Hinge> hinges() const; ///< with the edges that act now

    /// Living vertices whose rows this delta changes, and some neighbours whose rows stay the same; rising.
    std::vector<VertexId> touched_by(const mesh::MeshDelta& delta) const;
    /// @throws InputError when the delta does not fit the present mesh
    void check(const mesh::MeshDelta& delta) const;
    /// Follows the delta. @throws InputError as check(); nothing is changed then
    void apply(const mesh::MeshDelta& delta);

    /// Sets the load of all wounds: the traction that the tension exerted on their faces. Call after apply(). Has no
    /// effect without tension.
    /// @param lips the present faces of all wounds
    /// @throws InputError on a face that is not in the mesh; the load is then unchanged
    void set_wound(std::span<const mesh::LipFace> lips);

    /// Sums all rows anew in the present pattern, on two cores. For timing only: apply() keeps the rows up to date.
    void assemble();

    std::size_t slot_count() const { return rows_.size(); } ///< one more than the largest vertex id met
    std::size_t vertex_count() const { return living_vertices_; }
    std::size_t tet_count() const { return living_tets_; }
    bool alive(VertexId v) const { return !rows_[static_cast<std::size_t>(v)].column.empty(); }
    const Vec3& position(VertexId v) const { return position_[static_cast<std::size_t>(v)]; }

    /// The blocks of one row, on both sides of the diagonal and on the diagonal.
    struct Row {
        std::vector<VertexId> column; ///< rising; empty when the vertex is not alive
        std::vector<double> value; ///< nine per column, row by row

        bool operator==(const Row&) const = default;
    };
    const Row& row(VertexId v) const { return rows_[static_cast<std::size_t>(v)]; }

    /// y = K x. Large matrices use two cores. @pre x.size() == 3 slot_count()
    Eigen::VectorXd multiply(const Eigen::VectorXd& x) const;
    Eigen::MatrixXd multiply(const Eigen::MatrixXd& x) const;
    /// Nodal forces (N) by vertex id: the tension that the wounds have released, as released_tractions() computes it.
    const Eigen::VectorXd& load() const { return load_; }
    bool loaded() const { return !stress_.empty(); } ///< whether the body has tension, cut or uncut

    std::span<const TetId> elements_round(VertexId v) const { return around_[static_cast<std::size_t>(v)]; }
    const std::array<VertexId, 4>& tet(TetId t) const { return tets_[static_cast<std::size_t>(t)].nodes; }
    /// Ids of elements are below this bound; some of these ids do not live.
    std::size_t tet_slots() const { return tets_.size(); }
    bool tet_alive(TetId t) const { return tets_[static_cast<std::size_t>(t)].nodes[0] >= 0; }
    Label label(TetId t) const { return tets_[static_cast<std::size_t>(t)].label; }
    double volume(TetId t) const;

    std::size_t bytes() const;

private:
    struct Tet {
        std::array<VertexId, 4> nodes { -1, -1, -1, -1 }; ///< -1: not alive
        Label label = 0;
        TetId origin = 0;
    };
    void grow(const mesh::MeshDelta& delta);
    void add_tet(const mesh::MeshDelta::Tet& tet);
    void remove_tet(const mesh::MeshDelta::Tet& tet);
    void check_label(Label label) const;
    void check_origin(TetId origin) const;
    void make_pattern(VertexId v);
    void sum_row(VertexId v);
    void carry_beds(const mesh::MeshDelta& delta);
    struct HingeSpring {
        VertexId a = 0, b = 0;
        Vec3 at_a = Vec3::Zero(), at_b = Vec3::Zero(); ///< positions of the vertices to which the spring belongs
        Vec3 spring = Vec3::Zero(); ///< hinge_spring()
    };
    bool acts(const HingeSpring& spring) const;

    std::vector<Lame> lame_; ///< per label
    std::vector<Mat3> stress_; ///< per element of the first mesh; empty: none
    std::vector<double> bed_; ///< per vertex id; may be shorter than the rows; 0 where no vertex lives
    mesh::AblatedValues<double> ablated_beds_;
    std::vector<Hinge> hinges_;
    std::vector<HingeSpring> hinge_springs_; ///< of all edges of the hinges, in order
    std::map<VertexId, std::vector<std::size_t>> hinge_springs_of_; ///< per vertex id: indices into hinge_springs_
    std::vector<Vec3> position_; ///< per vertex id
    std::vector<std::vector<TetId>> around_; ///< per vertex id: elements, rising
    std::vector<Row> rows_;
    std::vector<Tet> tets_; ///< per element id
    Eigen::VectorXd load_;
    std::size_t living_vertices_ = 0, living_tets_ = 0;
};

} // namespace retractor::fem
