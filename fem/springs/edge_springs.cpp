#include "fem/springs/edge_springs.h"

#include "fem/element/corner_gradients.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace retractor::fem {

namespace {

    using Six = Eigen::Matrix<double, 6, 1>;
    using SixBySix = Eigen::Matrix<double, 6, 6>;

    /// Smallest stiffness of a spring, relative to the stiffness of a single spring that fits alone. A vertex whose
    /// springs all vanish would be free to go anywhere.
    constexpr double kWeakest = 0.02;
    /// Largest share of the work that braces take, in elements whose edges are as far from isotropic as in a flat
    /// element.
    constexpr double kMostBraced = 0.5;
    /// Penalty on crushed elements over Young's modulus, relatively as stiff as in elasticity.cpp.
    constexpr double kSpringCrushPenalty = 30.0;

    /// Weights w >= 0 of six directions whose sum w d^4 is nearest to the isotropic tensor with lambda = mu = 2/5.
    /// The product of this tensor with any d^4 is lambda + 2 mu. Directions whose weight would be negative are
    /// removed one by one.
    struct Fit {
        Six weights;
        double misfit = 0.0; ///< norm of the difference over the norm of the isotropic tensor
    };

    Fit isotropic_fit(const std::array<Vec3, 6>& directions)
    {
        // product of the isotropic tensor with d^4, and its squared norm
        constexpr double kAlong = 1.2, kNormSquared = 7.2;
        SixBySix gram;
        for (int a = 0; a < 6; ++a)
            for (int b = 0; b < 6; ++b) {
                const double c = directions[static_cast<std::size_t>(a)].dot(directions[static_cast<std::size_t>(b)]);
                gram(a, b) = c * c * c * c;
            }
        std::array<bool, 6> used;
        used.fill(true);
        for (;;) {
            SixBySix matrix = SixBySix::Identity();
            Six right = Six::Zero();
            for (int a = 0; a < 6; ++a)
                if (used[static_cast<std::size_t>(a)]) {
                    right[a] = kAlong;
                    for (int b = 0; b < 6; ++b)
                        if (used[static_cast<std::size_t>(b)])
                            matrix(a, b) = gram(a, b);
                }
            const Six weights = matrix.ldlt().solve(right);
            Eigen::Index least = 0;
            if (weights.minCoeff(&least) >= 0.0) // in least squares the fit and the difference are orthogonal
                return { weights.cwiseMax(kWeakest * kAlong),
                    std::sqrt(std::max(0.0, 1.0 - kAlong * weights.sum() / kNormSquared)) };
            used[static_cast<std::size_t>(least)] = false;
        }
    }

    std::size_t at(std::int32_t id) { return static_cast<std::size_t>(id); }

    template <class Ids> void sort_unique(Ids& ids)
    {
        std::sort(ids.begin(), ids.end());
        ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    }

    void check_finite(std::span<const Mat3> stresses)
    {
        for (std::size_t t = 0; t < stresses.size(); ++t)
            if (!stresses[t].allFinite())
                throw InputError("the pre-stress is not finite", "element " + std::to_string(t));
    }

} // namespace

const std::array<Vec3, 6>& brace_axes()
{
    static const std::array<Vec3, 6> axes = [] {
        const double golden = 0.5 * (1.0 + std::sqrt(5.0));
        std::array<Vec3, 6> a { Vec3(0, 1, golden), Vec3(0, -1, golden), Vec3(1, golden, 0), Vec3(-1, golden, 0),
            Vec3(golden, 0, 1), Vec3(golden, 0, -1) };
        for (Vec3& axis : a)
            axis.normalize();
        return a;
    }();
    return axes;
}

ElementSprings element_springs(const std::array<Vec3, 4>& x, double youngs_modulus_MPa, const Mat3& stress)
{
    std::array<Vec3, 6> directions;
    std::array<double, 6> lengths {};
    for (std::size_t e = 0; e < 6; ++e) {
        const Vec3 edge
            = x[static_cast<std::size_t>(mesh::kTetEdges[e][1])] - x[static_cast<std::size_t>(mesh::kTetEdges[e][0])];
        lengths[e] = edge.norm();
        directions[e] = edge / lengths[e];
    }
    const Fit fit = isotropic_fit(directions);
    const double braced = std::clamp((fit.misfit - kGoodFit) / kGoodFit, 0.0, 1.0) * kMostBraced;
    const CornerGradients g = corner_gradients(x[0], x[1], x[2], x[3]);
    const bool tense = !stress.isZero(0.0);
    ElementSprings springs;
    springs.brace = braced * youngs_modulus_MPa; // six axes of weight E make lambda = mu = 2 E / 5
    for (std::size_t e = 0; e < 6; ++e) {
        springs.stiffness[e] = (1.0 - braced) * fit.weights[static_cast<Eigen::Index>(e)] * youngs_modulus_MPa
            * g.volume / (lengths[e] * lengths[e]);
        if (tense)
            springs.force_density[e] = -g.volume
                * g.of[static_cast<std::size_t>(mesh::kTetEdges[e][0])].dot(
                    stress * g.of[static_cast<std::size_t>(mesh::kTetEdges[e][1])]);
    }
    return springs;
}

SpringNetwork::SpringNetwork(const mesh::CutSession& session, std::span<const Material> material_of_label,
    std::span<const Mat3> stress_of_element)
    : materials_(material_of_label.begin(), material_of_label.end())
    , stress_of_origin_(stress_of_element.begin(), stress_of_element.end())
{
    mesh::SlotMap map;
    const mesh::TetMesh mesh = session.compact_mesh(&map);
    check_finite(stress_of_element);
    make_room(map.compact_vertex.size(), map.compact_tet.size());
    for (std::size_t v = 0; v < map.vertex_slot.size(); ++v)
        rest_.row(map.vertex_slot[v]) = mesh.vertices.row(static_cast<Eigen::Index>(v));
    for (std::size_t t = 0; t < map.tet_slot.size(); ++t) {
        const auto n = mesh.tet(static_cast<TetId>(t));
        std::array<VertexId, 4> nodes {};
        for (std::size_t i = 0; i < 4; ++i)
            nodes[i] = map.vertex_slot[at(n[i])];
        insert(map.tet_slot[t], nodes, mesh.labels[t], session.origin(map.tet_slot[t]));
    }
    for (VertexId v = 0; v < static_cast<VertexId>(rows_.size()); ++v)
        sum_row(v);
    set_wound(session.lips());
}

void SpringNetwork::make_room(std::size_t vertices, std::size_t tets)
{
    if (tets_.empty()) { // a quarter in reserve for the first cuts
        tets_.reserve(tets + tets / 4);
        around_.reserve(vertices + vertices / 4);
        rows_.reserve(vertices + vertices / 4);
    }
    if (const std::size_t old = rows_.size(); vertices > old) {
        const auto rows = static_cast<Eigen::Index>(vertices);
        rest_.conservativeResize(rows, 3);
        displacement_.conservativeResize(rows, 3);
        rest_.bottomRows(rows - static_cast<Eigen::Index>(old)).setZero();
        displacement_.bottomRows(rows - static_cast<Eigen::Index>(old)).setZero();
        fixed_.resize(vertices, 0);
        around_.resize(vertices);
        rows_.resize(vertices);
        release_.resize(vertices, Vec3::Zero());
    }
    if (tets > tets_.size())
        tets_.resize(tets);
}

void SpringNetwork::insert(TetId id, const std::array<VertexId, 4>& nodes, Label label, TetId origin)
{
    if (label >= materials_.size())
        throw InputError("there is no material for a label of the mesh", "label " + std::to_string(label));
    if (!stress_of_origin_.empty() && (origin < 0 || at(origin) >= stress_of_origin_.size()))
        throw InputError("there is no pre-stress for an element", "element " + std::to_string(origin));
    check_material(materials_[label]);
    Tet& tet = tets_[at(id)];
    tet = { .nodes = nodes, .label = label, .origin = origin, .alive = true, .springs = {} };
    for (const VertexId v : nodes) {
        auto& around = around_[at(v)];
        around.insert(std::lower_bound(around.begin(), around.end(), id), id);
    }
    measure(id);
}

void SpringNetwork::remove(TetId id)
{
    Tet& tet = tets_[at(id)];
    for (const VertexId v : tet.nodes) {
        auto& around = around_[at(v)];
        around.erase(std::lower_bound(around.begin(), around.end(), id));
    }
    tet.alive = false;
}

void SpringNetwork::measure(TetId id)
{
    Tet& tet = tets_[at(id)];
    std::array<Vec3, 4> x;
    for (std::size_t i = 0; i < 4; ++i)
        x[i] = rest_.row(tet.nodes[i]).transpose();
    tet.volume = mesh::tet_volume(x[0], x[1], x[2], x[3]);
    if (!(tet.volume > 0.0))
        throw InputError("an element has no volume", "element " + std::to_string(id));
    static const Mat3 kNone = Mat3::Zero();
    tet.springs = element_springs(x, materials_[tet.label].youngs_modulus_MPa,
        stress_of_origin_.empty() ? kNone : stress_of_origin_[at(tet.origin)]);
}

void SpringNetwork::sum_row(VertexId v)
{
    std::vector<SpringEnd>& row = rows_[at(v)];
    row.clear();
    for (const TetId t : around_[at(v)]) {
        const Tet& tet = tets_[at(t)];
        for (std::size_t e = 0; e < 6; ++e) {
            const VertexId a = tet.nodes[static_cast<std::size_t>(mesh::kTetEdges[e][0])];
            const VertexId b = tet.nodes[static_cast<std::size_t>(mesh::kTetEdges[e][1])];
            if (a != v && b != v)
                continue;
            const VertexId other = a == v ? b : a;
            const auto place = std::lower_bound(
                row.begin(), row.end(), other, [](const SpringEnd& end, VertexId id) { return end.other < id; });
            if (place != row.end() && place->other == other) {
                place->stiffness += tet.springs.stiffness[e];
                place->force_density += tet.springs.force_density[e];
            } else {
                const VertexId low = std::min(a, b), high = std::max(a, b); // equal bits from both ends
                row.insert(place,
                    { other, (rest_.row(high) - rest_.row(low)).norm(), tet.springs.stiffness[e],
                        tet.springs.force_density[e] });
            }
        }
    }
}

void SpringNetwork::take_in(const mesh::MeshDelta::VertexBorn& born)
{
    rest_.row(born.id) = born.position.transpose();
    if (born.origin == mesh::MeshDelta::Origin::restored) {
        if (const std::optional<std::uint8_t> axes = ablated_fixed_.give_back(born.id))
            fixed_[at(born.id)] = *axes;
        return;
    }
    displacement_.row(born.id) = (1.0 - born.t) * displacement_.row(born.a) + born.t * displacement_.row(born.b);
    fixed_[at(born.id)] = static_cast<std::uint8_t>(fixed_axes(born.a) & fixed_axes(born.b));
}

void SpringNetwork::apply(const mesh::MeshDelta& delta)
{
    // one allocation for all: each enlargement copies the whole
    std::size_t vertices = rows_.size(), tets = tets_.size();
    for (const mesh::MeshDelta::VertexBorn& born : delta.vertices_born)
        vertices = std::max(vertices, at(born.id) + 1);
    for (const mesh::MeshDelta::Tet& tet : delta.tets_born)
        tets = std::max(tets, at(tet.id) + 1);
    make_room(vertices, tets);
    for (const mesh::MeshDelta::VertexBorn& born : delta.vertices_born)
        take_in(born);
    std::vector<VertexId> touched;
    std::vector<TetId> reshaped;
    for (const mesh::MeshDelta::VertexMoved& moved : delta.vertices_moved)
        rest_.row(moved.id) = moved.to.transpose();
    for (const mesh::MeshDelta::Tet& tet : delta.tets_gone) {
        remove(tet.id);
        touched.insert(touched.end(), tet.nodes.begin(), tet.nodes.end());
    }
    for (const mesh::MeshDelta::Tet& tet : delta.tets_born) {
        insert(tet.id, tet.nodes, tet.label, tet.origin);
        touched.insert(touched.end(), tet.nodes.begin(), tet.nodes.end());
    }
    for (const mesh::MeshDelta::VertexMoved& moved : delta.vertices_moved)
        reshaped.insert(reshaped.end(), around_[at(moved.id)].begin(), around_[at(moved.id)].end());
    sort_unique(reshaped);
    for (const TetId t : reshaped) {
        measure(t);
        touched.insert(touched.end(), tets_[at(t)].nodes.begin(), tets_[at(t)].nodes.end());
    }
    for (const mesh::MeshDelta::VertexBorn& gone : delta.vertices_gone) {
        if (gone.origin == mesh::MeshDelta::Origin::restored)
            ablated_fixed_.keep(gone.id, fixed_[at(gone.id)]);
        displacement_.row(gone.id).setZero();
        rest_.row(gone.id).setZero();
        fixed_[at(gone.id)] = 0;
    }
    sort_unique(touched);
    for (const VertexId v : touched)
        sum_row(v);
}

void SpringNetwork::set_wound(std::span<const mesh::LipFace> lips)
{
    for (const VertexId v : lip_vertices_)
        release_[at(v)].setZero();
    lip_vertices_.clear();
    std::vector<mesh::LipFace> sorted(lips.begin(), lips.end());
    std::sort(sorted.begin(), sorted.end(), [](const mesh::LipFace& a, const mesh::LipFace& b) {
        return std::pair(a.face.tet, a.face.corner) < std::pair(b.face.tet, b.face.corner);
    });
    for (const mesh::LipFace& lip : sorted) {
        if (lip.face.tet < 0 || at(lip.face.tet) >= tets_.size() || !tets_[at(lip.face.tet)].alive
            || lip.face.corner < 0 || lip.face.corner > 3)
            throw InputError(
                "the wound has a face that is not in the network", "element " + std::to_string(lip.face.tet));
        const Tet& tet = tets_[at(lip.face.tet)];
        const auto& local = mesh::kTetFaces[static_cast<std::size_t>(lip.face.corner)];
        std::array<VertexId, 3> v {};
        for (std::size_t i = 0; i < 3; ++i)
            v[i] = tet.nodes[static_cast<std::size_t>(local[i])];
        lip_vertices_.insert(lip_vertices_.end(), v.begin(), v.end());
        if (stress_of_origin_.empty())
            continue;
        const Vec3 share = stress_of_origin_[at(tet.origin)] * area_vector(rest_, v) / 3.0;
        for (const VertexId corner : v)
            release_[at(corner)] -= share;
    }
    sort_unique(lip_vertices_);
}

void SpringNetwork::fix(std::span<const VertexId> vertices, unsigned axes)
{
    if (axes == 0 || axes > kAllAxes)
        throw InputError("a vertex is fixed along x, y or z: bits 1, 2, 4", "axes");
    for (const VertexId v : vertices)
        if (v < 0 || at(v) >= rows_.size())
            throw InputError("a fixed vertex is not in the network", "vertex " + std::to_string(v));
    for (const VertexId v : vertices)
        fixed_[at(v)] = static_cast<std::uint8_t>(fixed_axes(v) | axes);
}

void SpringNetwork::place(VertexId v, const Vec3& displacement)
{
    RETRACTOR_ASSERT(v >= 0 && at(v) < rows_.size());
    for (int axis = 0; axis < 3; ++axis)
        if ((fixed_axes(v) >> axis & 1U) == 0)
            displacement_(v, axis) = displacement[axis];
}

void SpringNetwork::set_displacement(const Points& displacement)
{
    if (displacement.rows() != displacement_.rows())
        throw InputError("there must be one displacement per vertex: " + std::to_string(displacement.rows()) + " for "
                + std::to_string(displacement_.rows()),
            "displacement");
    if (!displacement.allFinite())
        throw InputError("a displacement is not finite", "displacement");
    for (VertexId v = 0; v < static_cast<VertexId>(displacement.rows()); ++v)
        place(v, displacement.row(v).transpose());
}

std::size_t SpringNetwork::spring_count() const
{
    std::size_t ends = 0;
    for (const auto& row : rows_)
        ends += row.size();
    return ends / 2;
}

double SpringNetwork::crush_stiffness(TetId t) const
{
    return kSpringCrushPenalty * materials_[tets_[at(t)].label].youngs_modulus_MPa;
}

std::size_t SpringNetwork::bytes() const
{
    return spring_count() * 2 * sizeof(SpringEnd) + tets_.size() * (sizeof(Tet) + 4 * sizeof(TetId))
        + rows_.size() * (12 * sizeof(double) + 2 * sizeof(std::vector<TetId>));
}

} // namespace retractor::fem
