#include "fem/model/elastic_body.h"

#include "fem/linear_algebra/parallel.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

namespace retractor::fem {

namespace {

    using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    template <int Nodes> using FixedGradients = Eigen::Map<const Eigen::Matrix<double, Nodes, 3, Eigen::RowMajor>>;

    /// Stiffness block of two nodes whose gradients ga and gb are given in the basis V: see Tangent.
    Mat3 pair_block(const Tangent& t, const Vec3& ga, const Vec3& gb)
    {
        Mat3 k;
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, m = (i + 2) % 3;
            k(i, i) = t.scaling(i, i) * ga[i] * gb[i] + t.same[m] * ga[j] * gb[j] + t.same[j] * ga[m] * gb[m];
            k(i, j) = t.scaling(i, j) * ga[i] * gb[j] + t.cross[m] * ga[j] * gb[i];
            k(j, i) = t.scaling(j, i) * ga[j] * gb[i] + t.cross[m] * ga[i] * gb[j];
        }
        return k;
    }

    template <int Nodes> constexpr std::size_t kPairs = static_cast<std::size_t>(Nodes) * (Nodes + 1) / 2;

    /// @param target result of element_block_map().
    void add_block(double* values, std::int32_t target, const RowMat3& block)
    {
        if (target >= 0)
            Eigen::Map<RowMat3>(values + 9 * static_cast<std::size_t>(target)) += block;
        else
            Eigen::Map<RowMat3>(values + 9 * static_cast<std::size_t>(~target)) += block.transpose();
    }

    /// @pre `whole` has every block of `part`.
    void add_to(BlockMatrix& whole, const BlockMatrix& part)
    {
        for (std::size_t row = 0; row < part.pattern.row_count(); ++row) {
            auto to = static_cast<std::size_t>(whole.pattern.row_start[row]);
            const auto end = static_cast<std::size_t>(part.pattern.row_start[row + 1]);
            for (auto from = static_cast<std::size_t>(part.pattern.row_start[row]); from < end; ++from) {
                while (whole.pattern.column[to] != part.pattern.column[from]) // both lists are sorted
                    ++to;
                for (std::size_t i = 0; i < 9; ++i)
                    whole.values[9 * to + i] += part.values[9 * from + i];
            }
        }
    }

    using TangentRows = Eigen::Matrix<double, 3, 9>;

    /// sum_j g_j dP_ij/dF_kl, for one node's row of blocks.
    TangentRows contract(const Vec3& g, const TangentMatrix& tangent)
    {
        TangentRows rows;
        for (int i = 0; i < 3; ++i)
            rows.row(i) = g.transpose() * tangent.middleRows<3>(3 * i);
        return rows;
    }

    RowMat3 contract(const TangentRows& rows, const Vec3& g)
    {
        RowMat3 block;
        for (int k = 0; k < 3; ++k)
            block.col(k) = rows.middleCols<3>(3 * k) * g;
        return block;
    }

    bool all_edges_are_straight(const mesh::TetMesh& mesh, TetId t)
    {
        const auto nodes = mesh.tet(t);
        std::size_t straight = 0;
        for (std::size_t e = 0; nodes.size() == 10 && e < mesh::kTetEdges.size(); ++e)
            straight += mesh::is_straight(nodes, e) ? 1 : 0;
        return straight == mesh::kTetEdges.size();
    }

    void check_fibres(const std::vector<FibreDirections>& fibres)
    {
        constexpr double kUnit = 1e-6; // error of the length of a unit direction that was read from text
        for (std::size_t t = 0; t < fibres.size(); ++t)
            for (const Vec3& direction : { fibres[t].first, fibres[t].second })
                if (!(std::abs(direction.norm() - 1.0) <= kUnit))
                    throw InputError("a fibre direction must be a unit vector", "element " + std::to_string(t));
    }

    void check_tissue(const mesh::TetMesh& mesh, const HyperelasticTissue& tissue)
    {
        for (const Hyperelastic& law : tissue.laws)
            check_hyperelastic(law);
        if (tissue.law_of_element.size() != mesh.tet_count())
            throw InputError("a body needs a law for each element", "materials");
        for (std::size_t t = 0; t < mesh.tet_count(); ++t)
            if (tissue.law_of_element[t] < 0
                || static_cast<std::size_t>(tissue.law_of_element[t]) >= tissue.laws.size())
                throw InputError(
                    "there is no law " + std::to_string(tissue.law_of_element[t]), "element " + std::to_string(t));
        if (!tissue.fibres.empty() && tissue.fibres.size() != mesh.tet_count())
            throw InputError("fibres are given for all elements or for none", "fibres");
        check_fibres(tissue.fibres);
    }

} // namespace

ElasticBody::ElasticBody(const mesh::TetMesh& mesh, Elasticity model, std::vector<Lame> lame_of_element)
    : mesh_(mesh)
    , model_(model)
    , lame_(std::move(lame_of_element))
{
    if (model == Elasticity::hyperelastic)
        throw InputError("a hyperelastic body needs its laws", "model");
    if (lame_.size() != mesh.tet_count())
        throw InputError("a body needs the parameters of each element", "materials");
    measure_elements();
}

ElasticBody::ElasticBody(const mesh::TetMesh& mesh, HyperelasticTissue tissue)
    : mesh_(mesh)
    , model_(Elasticity::hyperelastic)
    , tissue_(std::move(tissue))
{
    check_tissue(mesh, tissue_);
    if (tissue_.fibres.empty())
        tissue_.fibres.assign(mesh.tet_count(), {});
    measure_elements();
}

void ElasticBody::measure_elements()
{
    nodes_per_tet_ = static_cast<std::size_t>(mesh_.nodes_per_tet);
    const auto rule = quadrature(mesh_.nodes_per_tet);
    points_per_tet_ = rule.size();
    gradients_.reserve(mesh_.tet_count() * points_per_tet_ * nodes_per_tet_ * 3);
    weights_.reserve(mesh_.tet_count() * points_per_tet_);
    for (std::size_t t = 0; t < mesh_.tet_count(); ++t) {
        const auto id = static_cast<TetId>(t);
        is_straight_.push_back(all_edges_are_straight(mesh_, id) ? 1 : 0);
        for (const QuadraturePoint& point : rule) {
            const ShapeGradients shape = shape_gradients(mesh_, id, point);
            if (!(shape.volume > 0.0))
                throw InputError("the element is turned over in part: its edge midpoints are too far off",
                    "element " + std::to_string(t));
            gradients_.insert(
                gradients_.end(), shape.gradients.data(), shape.gradients.data() + shape.gradients.size());
            weights_.push_back(shape.volume);
        }
        if (is_straight_.back() != 0) // the gradients are equal at all points
            weights_[t * points_per_tet_] = mesh::tet_volume(mesh_, id);
    }
    if (model_ == Elasticity::corotational_linear && nodes_per_tet_ == 4)
        corotational_linear_.emplace(mesh_, gradients_, weights_, lame_);
}

void ElasticBody::set_bed(std::vector<double> stiffness)
{
    if (!stiffness.empty() && stiffness.size() != mesh_.vertex_count())
        throw InputError("a bed needs one stiffness per node", "bed");
    for (std::size_t v = 0; v < stiffness.size(); ++v)
        if (!(stiffness[v] >= 0.0 && std::isfinite(stiffness[v])))
            throw InputError("the stiffness of a spring must be finite and not negative", "node " + std::to_string(v));
    bed_ = std::move(stiffness);
}

void ElasticBody::set_hinges(std::vector<Hinge> hinges)
{
    check_hinges(mesh_, hinges);
    hinges_ = std::move(hinges);
}

void ElasticBody::set_loads(ExternalLoads loads)
{
    const auto size = 3 * mesh_.vertices.rows();
    if (loads.nodal.size() != 0 && loads.nodal.size() != size)
        throw InputError("nodal loads need three entries per node", "loads");
    for (Eigen::Index i = 0; i < loads.nodal.size(); ++i)
        if (!std::isfinite(loads.nodal[i]))
            throw InputError("a nodal load is not finite", "node " + std::to_string(i / 3));
    loads_ = std::move(loads);
    follower_.resize(0);
    if (model_ == Elasticity::linear) {
        const Eigen::VectorXd rest = Eigen::VectorXd::Zero(size);
        for (const FollowerPressure& pressure : std::exchange(loads_.pressures, {}))
            loads_.nodal = (loads_.nodal.size() == 0 ? rest : loads_.nodal) + pressure.force(rest);
    }
    (void)renew_follower_loads(Eigen::VectorXd::Zero(size));
}

double ElasticBody::renew_follower_loads(const Eigen::VectorXd& u)
{
    RETRACTOR_ASSERT(u.size() == 3 * mesh_.vertices.rows());
    if (loads_.pressures.empty())
        return 0.0;
    Eigen::VectorXd rest = Eigen::VectorXd::Zero(u.size());
    for (FollowerPressure& pressure : loads_.pressures) {
        pressure.renew_rim(u);
        rest += pressure.force(u);
        pressure.add_response(u, 1.0, rest);
    }
    const Eigen::VectorXd change = follower_.size() == 0 ? rest : rest - follower_;
    double largest = 0.0;
    for (Eigen::Index i = 0; i < change.size(); i += 3)
        largest = std::max(largest, change.segment<3>(i).norm());
    follower_ = std::move(rest);
    return load_share_ * largest;
}

void ElasticBody::add_loads(const Eigen::VectorXd& u, Response& response) const
{
    for (const Eigen::VectorXd* dead : { &loads_.nodal, &follower_ })
        if (dead->size() != 0) {
            response.energy -= load_share_ * dead->dot(u);
            response.forces -= load_share_ * *dead;
        }
    for (const FollowerPressure& pressure : loads_.pressures)
        response.energy += load_share_ * pressure.add_response(u, load_share_, response.forces);
}

void ElasticBody::set_contact(Contact contact)
{
    contact_ = std::move(contact);
    map_.clear();
}

void ElasticBody::set_blades(BladeContact blades)
{
    blades_ = std::move(blades);
    map_.clear();
}

void ElasticBody::expect_blades(const Eigen::VectorXd* u)
{
    if (!blades_)
        return;
    if (u != nullptr)
        blades_->expect(*u);
    else
        blades_->expect_nothing();
}

void ElasticBody::prepare_blade_search(const Eigen::VectorXd& u)
{
    if (blades_)
        blades_->prepare_search(u);
}

bool ElasticBody::find_contact(const Eigen::VectorXd& u, Contact::Pairing pairing)
{
    RETRACTOR_ASSERT(contact_.has_value());
    if (!contact_->find(u, pairing))
        return false;
    if (map_.empty() || !contact_->is_within(stiffness_.pattern)) {
        make_pattern();
        stiffness_.values.assign(9 * stiffness_.pattern.block_count(), 0.0);
    }
    return true;
}

void ElasticBody::make_pattern()
{
    const auto elements = [&] { return locking_free_ ? locking_free_->pattern() : block_pattern(mesh_); };
    if (!contact_ && !blades_) {
        stiffness_.pattern = elements();
    } else {
        if (elements_pattern_.row_start.empty())
            elements_pattern_ = elements();
        const BlockPattern with_blades = blades_ ? blades_->pattern(elements_pattern_) : elements_pattern_;
        stiffness_.pattern = contact_ ? contact_->pattern_with_neighbours(with_blades) : with_blades;
    }
    map_ = element_block_map(mesh_, stiffness_.pattern);
    ++patterns_made_;
}

void ElasticBody::avoid_locking(const AveragingScheme& scheme)
{
    if (model_ == Elasticity::corotational_linear)
        throw InputError("corotational_linear elasticity has no locking-free elements", "elasticity");
    std::vector<PointLaw> laws;
    std::vector<std::int32_t> law_of_element = tissue_.law_of_element;
    for (const Hyperelastic& law : tissue_.laws)
        laws.push_back({ model_, {}, law });
    std::map<std::pair<double, double>, std::int32_t> known;
    for (const Lame& l : lame_) {
        const auto [at, added] = known.try_emplace({ l.mu, l.lambda }, static_cast<std::int32_t>(laws.size()));
        if (added)
            laws.push_back({ model_, l, {} });
        law_of_element.push_back(at->second);
    }
    locking_free_.emplace(mesh_, scheme, std::move(laws), law_of_element, tissue_.fibres);
    elements_pattern_ = {};
    map_.clear();
}

std::size_t ElasticBody::points_of(std::size_t element) const
{
    return is_straight_[element] != 0 ? 1 : points_per_tet_;
}

std::size_t ElasticBody::nodes_of(std::size_t element) const { return is_straight_[element] != 0 ? 4 : nodes_per_tet_; }

const double* ElasticBody::gradients(std::size_t element, std::size_t point) const
{
    RETRACTOR_ASSERT(element < mesh_.tet_count() && point < points_per_tet_);
    return gradients_.data() + (element * points_per_tet_ + point) * nodes_per_tet_ * 3;
}

Mat3 ElasticBody::deformation_gradient(const Eigen::VectorXd& u, std::size_t element, std::size_t point) const
{
    const double* g = gradients(element, point);
    const auto nodes = mesh_.tet(static_cast<TetId>(element));
    Mat3 F = Mat3::Identity();
    for (std::size_t a = 0; a < nodes_of(element); ++a)
        F.noalias()
            += u.segment<3>(3 * static_cast<Eigen::Index>(nodes[a])) * Eigen::Map<const Eigen::RowVector3d>(g + 3 * a);
    return F;
}

template <class F>
void ElasticBody::for_each_point(const Eigen::VectorXd& u, std::size_t begin, std::size_t end, const F& f) const
{
    for (std::size_t t = begin; t < end; ++t)
        for (std::size_t q = 0; q < points_of(t); ++q) {
            const Mat3 gradient = deformation_gradient(u, t, q);
            if (model_ == Elasticity::hyperelastic) {
                const auto law = static_cast<std::size_t>(tissue_.law_of_element[t]);
                const HyperelasticPoint point = evaluate_point(tissue_.laws[law], tissue_.fibres[t], gradient, false);
                f(t, q, point.energy, point.stress);
            } else {
                const PointResponse point = evaluate_point(model_, lame_[t], gradient, false);
                f(t, q, point.energy, point.stress);
            }
        }
}

ElasticBody::Response ElasticBody::response(const Eigen::VectorXd& u) const
{
    RETRACTOR_ASSERT(u.size() == 3 * mesh_.vertices.rows());
    std::array<Response, 2> half;
    if (locking_free_) {
        half[0].forces = half[1].forces = Eigen::VectorXd::Zero(u.size());
        half[0].energy = locking_free_->add_response(u, half[0].forces);
    } else if (corotational_linear_)
        parallel_halves(corotational_linear_->packs(), [&](std::size_t which, std::size_t begin, std::size_t end) {
            half[which].forces = Eigen::VectorXd::Zero(u.size());
            half[which].energy = corotational_linear_->add_response(u, begin, end, half[which].forces);
        });
    else
        parallel_halves(mesh_.tet_count(), [&](std::size_t which, std::size_t begin, std::size_t end) {
            Response& sum = half[which];
            sum.forces = Eigen::VectorXd::Zero(u.size());
            for_each_point(u, begin, end, [&](std::size_t t, std::size_t q, double energy, const Mat3& stress) {
                const auto nodes = mesh_.tet(static_cast<TetId>(t));
                const double weight = weights_[t * points_per_tet_ + q];
                sum.energy += weight * energy;
                const Mat3 P = weight * stress;
                const double* g = gradients(t, q);
                for (std::size_t a = 0; a < nodes_of(t); ++a)
                    sum.forces.segment<3>(3 * static_cast<Eigen::Index>(nodes[a])).noalias()
                        += P * Eigen::Map<const Vec3>(g + 3 * a);
            });
        });
    half[0].energy += half[1].energy;
    half[0].forces += half[1].forces;
    add_surroundings(u, half[0]);
    return std::move(half[0]);
}

/// Adds the energy and the forces of all that is no element.
void ElasticBody::add_surroundings(const Eigen::VectorXd& u, Response& response) const
{
    for (std::size_t v = 0; v < bed_.size(); ++v) {
        const auto at = 3 * static_cast<Eigen::Index>(v);
        response.energy += 0.5 * bed_[v] * u.segment<3>(at).squaredNorm();
        response.forces.segment<3>(at) += bed_[v] * u.segment<3>(at);
    }
    for (const Hinge& hinge : hinges_)
        response.energy += add_hinge_response(mesh_, hinge, hinge_angle(), u, response.forces);
    add_loads(u, response);
    if (contact_)
        response.energy += contact_->add_response(u, response.forces);
    if (blades_)
        response.energy += blades_->add_response(u, response.forces);
}

std::vector<std::uint8_t> ElasticBody::touched_nodes(const Eigen::VectorXd& u) const
{
    RETRACTOR_ASSERT(u.size() == 3 * mesh_.vertices.rows());
    Response response { 0.0, Eigen::VectorXd::Zero(u.size()) };
    add_surroundings(u, response);
    std::vector<std::uint8_t> touched(mesh_.vertex_count(), 0);
    for (std::size_t v = 0; v < touched.size(); ++v)
        if ((response.forces.segment<3>(3 * static_cast<Eigen::Index>(v)).array() != 0.0).any()
            || (!bed_.empty() && bed_[v] > 0.0))
            touched[v] = 1;
    return touched;
}

void ElasticBody::stiffen(std::span<const TetId> elements, double factor)
{
    RETRACTOR_ASSERT(has_parts() && factor > 0.0);
    for (const TetId t : elements) {
        Lame& lame = lame_[static_cast<std::size_t>(t)];
        lame = { factor * lame.mu, factor * lame.lambda };
    }
}

ElasticBody ElasticBody::part(const std::vector<TetId>& elements, std::vector<VertexId>& nodes) const
{
    RETRACTOR_ASSERT(has_parts());
    nodes.clear();
    for (const TetId t : elements)
        nodes.insert(nodes.end(), mesh_.tet(t).begin(), mesh_.tet(t).end());
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    mesh::TetMesh mesh { mesh_.vertices(nodes, Eigen::all), mesh_.nodes_per_tet, {}, {} };
    std::vector<Lame> lame;
    for (const TetId t : elements) {
        for (const VertexId v : mesh_.tet(t))
            mesh.nodes.push_back(
                static_cast<VertexId>(std::lower_bound(nodes.begin(), nodes.end(), v) - nodes.begin()));
        mesh.labels.push_back(mesh_.labels[static_cast<std::size_t>(t)]);
        lame.push_back(lame_[static_cast<std::size_t>(t)]);
    }
    return { mesh, model_, std::move(lame) };
}

template <int Nodes>
void ElasticBody::add_corotational(const Eigen::VectorXd& u, double projected, Extremes extremes, std::size_t begin,
    std::size_t end, double* values) const
{
    const auto& tangent_of = extremes == Extremes::raised ? tangent_raised_at_extremes : tangent;
    std::array<RowMat3, kPairs<Nodes>> blocks; // of one element: the matrix is far from the cache
    for (std::size_t t = begin; t < end; ++t) {
        const auto count = static_cast<int>(nodes_of(t));
        for (std::size_t q = 0; q < points_of(t); ++q) {
            const Mat3 F = deformation_gradient(u, t, q);
            const Tangent c = tangent_of(model_, lame_[t], F, projected);
            const Eigen::Matrix<double, Nodes, 3> g = FixedGradients<Nodes>(gradients(t, q)) * c.V;
            const Mat3 U = c.U * weights_[t * points_per_tet_ + q];
            std::size_t pair = 0;
            for (int a = 0; a < count; ++a)
                for (int b = 0; b <= a; ++b, ++pair) {
                    const RowMat3 block
                        = U * pair_block(c, g.row(a).transpose(), g.row(b).transpose()) * c.U.transpose();
                    if (q == 0)
                        blocks[pair] = block;
                    else
                        blocks[pair] += block;
                }
        }
        const std::int32_t* target = map_.data() + t * kPairs<Nodes>;
        for (std::size_t pair = 0; pair < static_cast<std::size_t>(count * (count + 1) / 2); ++pair)
            add_block(values, target[pair], blocks[pair]);
    }
}

template <int Nodes> void ElasticBody::add_linear(std::size_t begin, std::size_t end, double* values) const
{
    for (std::size_t t = begin; t < end; ++t)
        for (std::size_t q = 0; q < points_of(t); ++q) {
            const FixedGradients<Nodes> g(gradients(t, q));
            const double weight = weights_[t * points_per_tet_ + q];
            const double mu = weight * lame_[t].mu, lambda = weight * lame_[t].lambda;
            const std::int32_t* target = map_.data() + t * kPairs<Nodes>;
            const auto count = static_cast<int>(nodes_of(t));
            for (int a = 0; a < count; ++a) {
                const Vec3 ga = g.row(a).transpose();
                for (int b = 0; b <= a; ++b) {
                    const Vec3 gb = g.row(b).transpose();
                    RowMat3 block = lambda * ga * gb.transpose() + mu * gb * ga.transpose();
                    block.diagonal().array() += mu * ga.dot(gb);
                    add_block(values, *target++, block);
                }
            }
        }
}

template <int Nodes>
void ElasticBody::add_hyperelastic(
    const Eigen::VectorXd& u, double projected, std::size_t begin, std::size_t end, double* values) const
{
    for (std::size_t t = begin; t < end; ++t)
        for (std::size_t q = 0; q < points_of(t); ++q) {
            const auto law = static_cast<std::size_t>(tissue_.law_of_element[t]);
            HyperelasticPoint point
                = evaluate_point(tissue_.laws[law], tissue_.fibres[t], deformation_gradient(u, t, q), true);
            lift_negative(point.tangent, projected);
            point.tangent *= weights_[t * points_per_tet_ + q];
            const FixedGradients<Nodes> g(gradients(t, q));
            const std::int32_t* target = map_.data() + t * kPairs<Nodes>;
            const auto count = static_cast<int>(nodes_of(t));
            for (int a = 0; a < count; ++a) {
                const TangentRows rows = contract(g.row(a).transpose(), point.tangent);
                for (int b = 0; b <= a; ++b)
                    add_block(values, *target++, contract(rows, g.row(b).transpose()));
            }
        }
}

template <int Nodes>
void ElasticBody::add_stiffness(const Eigen::VectorXd& u, double projected, Extremes extremes, std::size_t begin,
    std::size_t end, double* values) const
{
    switch (model_) {
    case Elasticity::linear:
        add_linear<Nodes>(begin, end, values);
        break;
    case Elasticity::corotational:
    case Elasticity::corotational_linear:
        add_corotational<Nodes>(u, projected, extremes, begin, end, values);
        break;
    case Elasticity::hyperelastic:
        add_hyperelastic<Nodes>(u, projected, begin, end, values);
        break;
    }
}

/// Sets `stiffness_` to the sum of all elements.
void ElasticBody::add_elements(const Eigen::VectorXd& u, double projected, Extremes extremes)
{
    second_half_.resize(stiffness_.values.size());
    parallel_halves(mesh_.tet_count(), [&](std::size_t which, std::size_t begin, std::size_t end) {
        std::vector<double>& values = which == 0 ? stiffness_.values : second_half_;
        std::fill(values.begin(), values.end(), 0.0);
        if (nodes_per_tet_ == 4)
            add_stiffness<4>(u, projected, extremes, begin, end, values.data());
        else
            add_stiffness<10>(u, projected, extremes, begin, end, values.data());
    });
    parallel_halves(second_half_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            stiffness_.values[i] += second_half_[i];
    });
}

const BlockMatrix& ElasticBody::stiffness(const Eigen::VectorXd& u, double projected, Extremes extremes)
{
    RETRACTOR_ASSERT(u.size() == 3 * mesh_.vertices.rows() && projected >= 0.0 && projected <= 1.0);
    if (map_.empty())
        make_pattern();
    stiffness_.values.resize(9 * stiffness_.pattern.block_count());
    if (locking_free_)
        std::fill(stiffness_.values.begin(), stiffness_.values.end(), 0.0);
    if (locking_free_ && (contact_ || blades_)) {
        BlockMatrix own { elements_pattern_, std::vector<double>(9 * elements_pattern_.block_count(), 0.0) };
        locking_free_->add_stiffness(u, projected, own);
        add_to(stiffness_, own);
    } else if (locking_free_)
        locking_free_->add_stiffness(u, projected, stiffness_);
    else
        add_elements(u, projected, extremes);
    for (std::size_t v = 0; v < bed_.size(); ++v)
        if (bed_[v] > 0.0) { // a node with a spring has elements, so its row ends with the diagonal block
            double* diagonal
                = stiffness_.values.data() + 9 * static_cast<std::size_t>(stiffness_.pattern.row_start[v + 1] - 1);
            for (const std::size_t axis : { 0U, 4U, 8U })
                diagonal[axis] += bed_[v];
        }
    for (const Hinge& hinge : hinges_)
        add_hinge_stiffness(mesh_, hinge, hinge_angle(), u, projected, stiffness_);
    // the stiffness of pressure is indefinite, so a projected stiffness omits it
    for (const FollowerPressure& pressure : loads_.pressures)
        pressure.add_stiffness(u, (1.0 - projected) * load_share_, stiffness_);
    if (contact_)
        contact_->add_stiffness(u, projected, stiffness_);
    if (blades_)
        blades_->add_stiffness(u, projected, stiffness_);
    return stiffness_;
}

ElasticBody::Deformation ElasticBody::deformation(const Eigen::VectorXd& u) const
{
    RETRACTOR_ASSERT(u.size() == 3 * mesh_.vertices.rows());
    Deformation d;
    for (std::size_t t = 0; t < mesh_.tet_count(); ++t) {
        double strain = 0.0, volume = 0.0, deformed = 0.0, smallest = 0.0, largest = 0.0;
        for (std::size_t q = 0; q < points_of(t); ++q) {
            const Mat3 F = deformation_gradient(u, t, q);
            const double weight = weights_[t * points_per_tet_ + q], ratio = F.determinant();
            const double stretch = signed_svd(F).sigma[0];
            strain += weight * 0.5 * (stretch * stretch - 1.0);
            volume += weight;
            deformed += weight * ratio;
            smallest = q == 0 ? ratio : std::min(smallest, ratio);
            largest = q == 0 ? ratio : std::max(largest, ratio);
        }
        d.strain.push_back(strain / volume);
        d.volume.push_back(volume);
        d.volume_ratio.push_back(deformed / volume);
        d.smallest_ratio.push_back(smallest);
        d.largest_ratio.push_back(largest);
    }
    return d;
}

std::size_t ElasticBody::bytes() const
{
    return (gradients_.size() + weights_.size() + stiffness_.values.size() + second_half_.size()) * sizeof(double)
        + (map_.size() + stiffness_.pattern.column.size() + stiffness_.pattern.row_start.size()) * sizeof(std::int32_t)
        + lame_.size() * sizeof(Lame) + tissue_.law_of_element.size() * sizeof(std::int32_t)
        + tissue_.fibres.size() * sizeof(FibreDirections) + (corotational_linear_ ? corotational_linear_->bytes() : 0);
}

} // namespace retractor::fem
