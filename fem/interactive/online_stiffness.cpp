#include "fem/interactive/online_stiffness.h"

#include "fem/element/corner_gradients.h"
#include "fem/linear_algebra/parallel.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace retractor::fem {

namespace {

    /// Adds the block of two nodes with gradients a and b, row by row. The products of gradients are computed first, so
    /// that the block of (b, a) is the transpose of the block of (a, b) to the last bit.
    void add_block(const Lame& lame, double volume, const Vec3& a, const Vec3& b, double* block)
    {
        const double lambda = lame.lambda * volume, mu = lame.mu * volume;
        const double both = mu * a.dot(b);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                const double ab = a[i] * b[j], ba = a[j] * b[i];
                const double direct = lambda * ab, crossed = mu * ba;
                block[3 * i + j] += (direct + crossed) + (i == j ? both : 0.0);
            }
    }

    std::string element_name(TetId t) { return "element " + std::to_string(t); }
    std::string vertex_name(VertexId v) { return "vertex " + std::to_string(v); }

    /// A tension whose off-diagonal pairs differ by less than this share of its norm differs by rounding: a tension
    /// along a direction comes from products of rotations, which round by some 1e-16 of their size.
    constexpr double kSymmetryTolerance = 1e-9;

    /// The tensions, symmetric to the last bit, as assembly takes them.
    std::vector<Mat3> checked_stress(std::span<const Mat3> stress_of_element)
    {
        std::vector<Mat3> checked;
        checked.reserve(stress_of_element.size());
        for (std::size_t t = 0; t < stress_of_element.size(); ++t) {
            const Mat3& s = stress_of_element[t];
            if (!s.allFinite() || (s - s.transpose()).norm() > kSymmetryTolerance * s.norm())
                throw InputError(
                    "a tension must be finite and symmetric", "tension of " + element_name(static_cast<TetId>(t)));
            checked.push_back(0.5 * (s + s.transpose()));
        }
        return checked;
    }

} // namespace

OnlineStiffness::OnlineStiffness(const mesh::CutSession& session, std::span<const Material> material_of_label,
    std::span<const Mat3> stress_of_element)
    : stress_(checked_stress(stress_of_element))
{
    mesh::SlotMap map;
    const mesh::TetMesh mesh = session.compact_mesh(&map);
    std::vector<std::uint8_t> used(std::size_t { 1 } << 16, 0);
    for (const Label label : mesh.labels)
        used[label] = 1;
    for (std::size_t label = 0; label < material_of_label.size(); ++label)
        lame_.push_back(used[label] != 0 ? lame(material_of_label[label]) : Lame {});
    position_.assign(map.compact_vertex.size(), Vec3::Zero());
    around_.resize(position_.size());
    rows_.resize(position_.size());
    tets_.resize(map.compact_tet.size());
    load_ = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(position_.size()));
    for (std::size_t v = 0; v < map.vertex_slot.size(); ++v)
        position_[static_cast<std::size_t>(map.vertex_slot[v])]
            = mesh.vertices.row(static_cast<Eigen::Index>(v)).transpose();
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
        const TetId slot = map.tet_slot[static_cast<std::size_t>(t)];
        mesh::MeshDelta::Tet tet { slot, {}, mesh.labels[static_cast<std::size_t>(t)], session.origin(slot) };
        check_label(tet.label);
        check_origin(tet.origin);
        for (std::size_t a = 0; a < 4; ++a)
            tet.nodes[a] = map.vertex_slot[static_cast<std::size_t>(mesh.tet(t)[a])];
        add_tet(tet);
    }
    parallel_halves(rows_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            make_pattern(static_cast<VertexId>(v));
            sum_row(static_cast<VertexId>(v));
        }
    });
    living_vertices_ = map.vertex_slot.size();
    set_wound(session.lips());
}

void OnlineStiffness::check_label(Label label) const
{
    if (label >= lame_.size())
        throw InputError("no material for this label", "label " + std::to_string(label));
}

void OnlineStiffness::check_origin(TetId origin) const
{
    if (loaded() && (origin < 0 || static_cast<std::size_t>(origin) >= stress_.size()))
        throw InputError("there must be one tension per element of the first mesh: " + std::to_string(stress_.size()),
            element_name(origin));
}

void OnlineStiffness::set_wound(std::span<const mesh::LipFace> lips)
{
    if (!loaded())
        return;
    std::vector<mesh::TetFace> faces;
    for (const mesh::LipFace& lip : lips) {
        const auto id = static_cast<std::size_t>(lip.face.tet);
        if (lip.face.tet < 0 || id >= tets_.size() || tets_[id].nodes[0] < 0 || lip.face.corner < 0
            || lip.face.corner > 3)
            throw InputError("the wound has a face that is not in the mesh", element_name(lip.face.tet));
        faces.push_back(lip.face);
    }
    std::sort(faces.begin(), faces.end(), // a fixed order gives the same bits for the same wound
        [](const mesh::TetFace& a, const mesh::TetFace& b) {
            return std::pair(a.tet, a.corner) < std::pair(b.tet, b.corner);
        });
    load_.setZero();
    for (const mesh::TetFace& face : faces) {
        const Tet& tet = tets_[static_cast<std::size_t>(face.tet)];
        const auto& corners = mesh::kTetFaces[static_cast<std::size_t>(face.corner)];
        const auto node = [&](std::size_t i) { return tet.nodes[static_cast<std::size_t>(corners[i])]; };
        const auto at = [&](std::size_t i) -> const Vec3& { return position_[static_cast<std::size_t>(node(i))]; };
        const Vec3 area = area_vector(at(0), at(1), at(2));
        const Vec3 share = stress_[static_cast<std::size_t>(tet.origin)] * area / 3.0;
        for (std::size_t i = 0; i < 3; ++i)
            load_.segment<3>(3 * node(i)) -= share;
    }
}

void OnlineStiffness::set_bed(std::vector<double> stiffness)
{
    for (std::size_t v = 0; v < stiffness.size(); ++v)
        if (!(stiffness[v] >= 0.0 && std::isfinite(stiffness[v])))
            throw InputError(
                "the stiffness of a spring must be finite and not negative", vertex_name(static_cast<VertexId>(v)));
    bed_ = std::move(stiffness);
    ablated_beds_.clear();
    for (VertexId v = 0; v < static_cast<VertexId>(std::min(bed_.size(), rows_.size())); ++v)
        if (!alive(v))
            bed_[static_cast<std::size_t>(v)] = 0.0;
    bed_.resize(std::min(bed_.size(), rows_.size()));
    for (VertexId v = 0; v < static_cast<VertexId>(rows_.size()); ++v)
        sum_row(v);
}

bool OnlineStiffness::acts(const HingeSpring& spring) const
{
    const std::vector<VertexId>& column = row(spring.a).column;
    return std::binary_search(column.begin(), column.end(), spring.b) && position(spring.a) == spring.at_a
        && position(spring.b) == spring.at_b;
}

void OnlineStiffness::set_hinges(std::vector<Hinge> hinges)
{
    std::vector<HingeSpring> springs;
    std::map<VertexId, std::vector<std::size_t>> springs_of;
    const auto lives = [&](VertexId v) { return v >= 0 && v < static_cast<VertexId>(rows_.size()) && alive(v); };
    for (const Hinge& hinge : hinges)
        for (const HingeEdge& edge : hinge.edges) {
            if (!lives(edge.a) || !lives(edge.b) || edge.a == edge.b
                || !std::ranges::binary_search(row(edge.a).column, edge.b))
                throw InputError("nodes " + std::to_string(edge.a) + " and " + std::to_string(edge.b)
                        + " of a hinge's edge share no element",
                    "hinge of " + hinge.name);
            springs_of[edge.a].push_back(springs.size());
            springs_of[edge.b].push_back(springs.size());
            springs.push_back({ edge.a, edge.b, position(edge.a), position(edge.b),
                hinge_spring(hinge, edge, position(edge.b) - position(edge.a)) });
        }
    hinges_ = std::move(hinges);
    std::swap(hinge_springs_, springs);
    std::swap(hinge_springs_of_, springs_of);
    for (const auto* changed : { &springs_of, &hinge_springs_of_ })
        for (const auto& [v, own] : *changed)
            if (lives(v))
                sum_row(v);
}

std::vector<Hinge> OnlineStiffness::hinges() const
{
    std::vector<Hinge> living = hinges_;
    std::size_t at = 0;
    for (Hinge& hinge : living)
        std::erase_if(hinge.edges, [&](const HingeEdge&) { return !acts(hinge_springs_[at++]); });
    std::erase_if(living, [](const Hinge& hinge) { return hinge.edges.empty(); });
    return living;
}

std::vector<VertexId> OnlineStiffness::touched_by(const mesh::MeshDelta& delta) const
{
    std::vector<VertexId> touched;
    const auto add = [&](VertexId v) {
        if (v >= 0 && v < static_cast<VertexId>(rows_.size()) && alive(v))
            touched.push_back(v);
    };
    for (const auto* tets : { &delta.tets_gone, &delta.tets_born })
        for (const mesh::MeshDelta::Tet& tet : *tets)
            for (const VertexId v : tet.nodes)
                add(v);
    for (const mesh::MeshDelta::VertexMoved& moved : delta.vertices_moved)
        if (moved.id >= 0 && moved.id < static_cast<VertexId>(rows_.size()))
            for (const VertexId v : row(moved.id).column)
                add(v);
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    return touched;
}

void OnlineStiffness::check(const mesh::MeshDelta& delta) const
{
    const std::string wrong = "the delta does not belong to this state of the mesh: ";
    std::map<TetId, bool> lives; // life of the elements that the delta has changed so far
    for (const mesh::MeshDelta::Tet& tet : delta.tets_gone) {
        const auto id = static_cast<std::size_t>(tet.id);
        const auto known = lives.find(tet.id);
        if (tet.id < 0 || id >= tets_.size() || tets_[id].nodes != tet.nodes
            || (known != lives.end() && !known->second))
            throw InputError(wrong + "an element that goes is not there", element_name(tet.id));
        lives[tet.id] = false;
    }
    std::map<VertexId, Vec3> born;
    for (const mesh::MeshDelta::VertexBorn& vertex : delta.vertices_born) {
        if (!vertex.position.allFinite())
            throw InputError("a vertex is born at a place that is not finite", vertex_name(vertex.id));
        if (vertex.id < 0 || (vertex.id < static_cast<VertexId>(rows_.size()) && alive(vertex.id)))
            throw InputError(wrong + "a vertex is born that lives", vertex_name(vertex.id));
        born.emplace(vertex.id, vertex.position);
    }
    for (const mesh::MeshDelta::VertexMoved& moved : delta.vertices_moved) {
        const bool lives_now = moved.id >= 0 && moved.id < static_cast<VertexId>(rows_.size()) && alive(moved.id);
        if (!moved.to.allFinite())
            throw InputError("a vertex is moved to a place that is not finite", vertex_name(moved.id));
        if (!lives_now && !born.contains(moved.id))
            throw InputError(wrong + "a vertex is moved that does not live", vertex_name(moved.id));
    }
    for (const mesh::MeshDelta::Tet& tet : delta.tets_born) {
        check_label(tet.label);
        check_origin(tet.origin);
        const auto id = static_cast<std::size_t>(tet.id);
        const auto known = lives.find(tet.id);
        const bool taken = known != lives.end() ? known->second : id < tets_.size() && tets_[id].nodes[0] >= 0;
        if (tet.id < 0 || taken)
            throw InputError(wrong + "an element is born that lives", element_name(tet.id));
        for (const VertexId v : tet.nodes)
            if (v < 0 || ((v >= static_cast<VertexId>(rows_.size()) || !alive(v)) && !born.contains(v)))
                throw InputError(wrong + "an element has a vertex that does not live", element_name(tet.id));
        lives[tet.id] = true;
    }
}

void OnlineStiffness::grow(const mesh::MeshDelta& delta)
{
    std::size_t vertices = rows_.size(), tets = tets_.size();
    for (const mesh::MeshDelta::VertexBorn& vertex : delta.vertices_born)
        vertices = std::max(vertices, static_cast<std::size_t>(vertex.id) + 1);
    for (const mesh::MeshDelta::Tet& tet : delta.tets_born)
        tets = std::max(tets, static_cast<std::size_t>(tet.id) + 1);
    tets_.resize(tets);
    if (vertices == rows_.size())
        return;
    position_.resize(vertices, Vec3::Zero());
    around_.resize(vertices);
    rows_.resize(vertices);
    load_.conservativeResizeLike(Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(vertices)));
}

void OnlineStiffness::add_tet(const mesh::MeshDelta::Tet& tet)
{
    tets_[static_cast<std::size_t>(tet.id)] = { tet.nodes, tet.label, tet.origin };
    for (const VertexId v : tet.nodes) {
        auto& around = around_[static_cast<std::size_t>(v)];
        around.insert(std::upper_bound(around.begin(), around.end(), tet.id), tet.id);
    }
    ++living_tets_;
}

void OnlineStiffness::remove_tet(const mesh::MeshDelta::Tet& tet)
{
    tets_[static_cast<std::size_t>(tet.id)] = {};
    for (const VertexId v : tet.nodes) {
        auto& around = around_[static_cast<std::size_t>(v)];
        around.erase(std::lower_bound(around.begin(), around.end(), tet.id));
    }
    --living_tets_;
}

/// Keeps the beds with their vertices. An id that is used again belongs to another vertex, which has no part in the bed
/// of the earlier vertex.
void OnlineStiffness::carry_beds(const mesh::MeshDelta& delta)
{
    for (const mesh::MeshDelta::VertexBorn& born : delta.vertices_born)
        if (born.origin == mesh::MeshDelta::Origin::restored)
            if (const std::optional<double> kept = ablated_beds_.give_back(born.id))
                bed_[static_cast<std::size_t>(born.id)] = *kept;
    for (const mesh::MeshDelta::VertexBorn& gone : delta.vertices_gone)
        if (bed(gone.id) > 0.0 || gone.origin == mesh::MeshDelta::Origin::restored) {
            bed_.resize(std::max(bed_.size(), static_cast<std::size_t>(gone.id) + 1), 0.0);
            const double was = std::exchange(bed_[static_cast<std::size_t>(gone.id)], 0.0);
            if (gone.origin == mesh::MeshDelta::Origin::restored)
                ablated_beds_.keep(gone.id, was);
        }
}

void OnlineStiffness::apply(const mesh::MeshDelta& delta)
{
    check(delta);
    std::vector<VertexId> touched = touched_by(delta);
    grow(delta);
    for (const mesh::MeshDelta::VertexBorn& vertex : delta.vertices_born) {
        position_[static_cast<std::size_t>(vertex.id)] = vertex.position;
        touched.push_back(vertex.id);
    }
    for (const mesh::MeshDelta::VertexMoved& moved : delta.vertices_moved)
        position_[static_cast<std::size_t>(moved.id)] = moved.to;
    for (const mesh::MeshDelta::Tet& tet : delta.tets_gone)
        remove_tet(tet);
    for (const mesh::MeshDelta::Tet& tet : delta.tets_born)
        add_tet(tet);
    carry_beds(delta);
    living_vertices_ += delta.vertices_born.size();
    living_vertices_ -= delta.vertices_gone.size();
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    for (const VertexId v : touched) {
        make_pattern(v);
        sum_row(v);
    }
}

void OnlineStiffness::make_pattern(VertexId v)
{
    Row& row = rows_[static_cast<std::size_t>(v)];
    row.column.clear();
    for (const TetId t : around_[static_cast<std::size_t>(v)]) {
        const auto& nodes = tets_[static_cast<std::size_t>(t)].nodes;
        row.column.insert(row.column.end(), nodes.begin(), nodes.end());
    }
    std::sort(row.column.begin(), row.column.end());
    row.column.erase(std::unique(row.column.begin(), row.column.end()), row.column.end());
    row.column.shrink_to_fit();
    row.value.resize(9 * row.column.size());
    row.value.shrink_to_fit();
}

void OnlineStiffness::sum_row(VertexId v)
{
    const auto id = static_cast<std::size_t>(v);
    Row& row = rows_[id];
    std::fill(row.value.begin(), row.value.end(), 0.0);
    for (const TetId t : around_[id]) {
        const Tet& tet = tets_[static_cast<std::size_t>(t)];
        const auto at = [&](std::size_t a) -> const Vec3& { return position_[static_cast<std::size_t>(tet.nodes[a])]; };
        const CornerGradients g = corner_gradients(at(0), at(1), at(2), at(3));
        const auto self
            = static_cast<std::size_t>(std::find(tet.nodes.begin(), tet.nodes.end(), v) - tet.nodes.begin());
        for (std::size_t a = 0; a < 4; ++a) {
            const auto place
                = std::lower_bound(row.column.begin(), row.column.end(), tet.nodes[a]) - row.column.begin();
            add_block(lame_[tet.label], g.volume, g.of[self], g.of[a], row.value.data() + 9 * place);
        }
    }
    if (id < bed_.size() && !row.column.empty()) {
        const auto place = std::lower_bound(row.column.begin(), row.column.end(), v) - row.column.begin();
        for (const int axis : { 0, 4, 8 })
            row.value[static_cast<std::size_t>(9 * place + axis)] += bed_[id];
    }
    const auto hinged = hinge_springs_of_.find(v);
    if (hinged == hinge_springs_of_.end())
        return;
    for (const std::size_t index : hinged->second) {
        const HingeSpring& spring = hinge_springs_[index];
        if (!acts(spring))
            continue;
        const Mat3 block = spring.spring * spring.spring.transpose();
        for (const VertexId end : { spring.a, spring.b }) {
            const auto place = std::lower_bound(row.column.begin(), row.column.end(), end) - row.column.begin();
            for (std::size_t i = 0; i < 9; ++i) // the block is symmetric
                row.value[static_cast<std::size_t>(9 * place) + i] += (end == v ? 1.0 : -1.0) * block.data()[i];
        }
    }
}

void OnlineStiffness::assemble()
{
    parallel_halves(rows_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v)
            sum_row(static_cast<VertexId>(v));
    });
}

Eigen::VectorXd OnlineStiffness::multiply(const Eigen::VectorXd& x) const
{
    RETRACTOR_ASSERT(x.size() == 3 * static_cast<Eigen::Index>(rows_.size()));
    Eigen::VectorXd y(x.size());
    parallel_halves(rows_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const Row& row = rows_[v];
            double sum[3] = { 0.0, 0.0, 0.0 };
            const double* k = row.value.data();
            for (const VertexId column : row.column) {
                const double* u = x.data() + 3 * column;
                sum[0] += k[0] * u[0] + k[1] * u[1] + k[2] * u[2];
                sum[1] += k[3] * u[0] + k[4] * u[1] + k[5] * u[2];
                sum[2] += k[6] * u[0] + k[7] * u[1] + k[8] * u[2];
                k += 9;
            }
            std::copy(sum, sum + 3, y.data() + 3 * v);
        }
    });
    return y;
}

Eigen::MatrixXd OnlineStiffness::multiply(const Eigen::MatrixXd& x) const
{
    RETRACTOR_ASSERT(x.rows() == 3 * static_cast<Eigen::Index>(rows_.size()));
    // The cases of one unknown lie side by side, so that each block is read once for all cases.
    const Eigen::MatrixXd in = x.transpose();
    Eigen::MatrixXd out(in.rows(), in.cols());
    parallel_halves(rows_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        Eigen::Matrix<double, Eigen::Dynamic, 3> sum(in.rows(), 3);
        for (std::size_t v = begin; v < end; ++v) {
            const Row& row = rows_[v];
            sum.setZero();
            for (std::size_t k = 0; k < row.column.size(); ++k)
                sum.noalias() += in.middleCols<3>(3 * row.column[k])
                    // The map reads the block by columns, which transposes it.
                    * Eigen::Map<const Mat3>(row.value.data() + 9 * k);
            out.middleCols<3>(3 * static_cast<Eigen::Index>(v)) = sum;
        }
    });
    return out.transpose();
}

double OnlineStiffness::volume(TetId t) const
{
    const auto& n = tet(t);
    return mesh::tet_volume(position(n[0]), position(n[1]), position(n[2]), position(n[3]));
}

std::size_t OnlineStiffness::bytes() const
{
    std::size_t sum = tets_.size() * sizeof(Tet) + position_.size() * sizeof(Vec3)
        + static_cast<std::size_t>(load_.size()) * sizeof(double);
    for (const Row& row : rows_)
        sum += sizeof(Row) + row.column.capacity() * sizeof(VertexId) + row.value.capacity() * sizeof(double);
    for (const auto& around : around_)
        sum += sizeof(around) + around.capacity() * sizeof(TetId);
    return sum;
}

} // namespace retractor::fem
