#include "fem/springs/spring_relaxation.h"

#include "fem/linear_algebra/norm.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace retractor::fem {

namespace {

    std::size_t at(std::int32_t id) { return static_cast<std::size_t>(id); }

    void check_options(const RelaxOptions& o)
    {
        if (!(o.tolerance > 0.0 && std::isfinite(o.tolerance)))
            throw InputError("the tolerance must be a positive number", "tolerance");
        if (o.max_iterations < 1)
            throw InputError("at least one iteration is needed", "max_iterations");
        if (!(o.reach_mm >= 0.0 && std::isfinite(o.reach_mm)))
            throw InputError("the reach must be finite and not negative", "reach_mm");
    }

    /// Conjugate gradients on the patch's tangent, preconditioned by the diagonal blocks.
    struct Solve {
        Eigen::VectorXd x;
        int iterations = 0;
    };

    Solve solve(const SpringPatch& patch, const std::vector<Mat3>& inverse, const Eigen::VectorXd& b, double tolerance,
        int max_iterations, const Job& job)
    {
        const auto precondition = [&](const Eigen::VectorXd& r) {
            Eigen::VectorXd z(r.size());
            for (std::size_t i = 0; i < inverse.size(); ++i)
                z.segment<3>(3 * static_cast<Eigen::Index>(i))
                    = inverse[i] * r.segment<3>(3 * static_cast<Eigen::Index>(i));
            return z;
        };
        Solve s { Eigen::VectorXd::Zero(b.size()), 0 };
        Eigen::VectorXd r = b, z = precondition(r), p = z;
        double rz = r.dot(z);
        const double target = tolerance * tolerance * rz;
        while (s.iterations < max_iterations && rz > target) {
            const Eigen::VectorXd Kp = patch.multiply(p);
            const double curvature = p.dot(Kp);
            if (!(curvature > 0.0))
                break;
            s.x += rz / curvature * p;
            r -= rz / curvature * Kp;
            ++s.iterations;
            z = precondition(r);
            const double next = r.dot(z);
            p = z + next / rz * p;
            rz = next;
            if (constexpr int kAsk = 32; s.iterations % kAsk == 0 && job.cancelled())
                break;
        }
        return s;
    }

    /// Shortens the step until the energy falls enough [Armijo].
    /// @return false when the energy does not fall at any length.
    bool search(const SpringPatch& patch, const Eigen::VectorXd& step, Eigen::VectorXd& u, SpringPatch::Response& state)
    {
        constexpr double kArmijo = 1e-4, kShortest = 1e-6;
        const double slope = state.forces.dot(step), noise = 1e-13 * std::abs(state.energy);
        for (double length = 1.0; slope < 0.0 && length > kShortest; length *= 0.5) {
            Eigen::VectorXd next = u + length * step;
            SpringPatch::Response there = patch.response(next);
            if (std::isfinite(there.energy) && there.energy <= state.energy + kArmijo * length * slope + noise) {
                u = std::move(next);
                state = std::move(there);
                return true;
            }
        }
        return false;
    }

    /// Newton's method on a patch, until the largest unbalanced force is `tolerance` of `scale`. Writes the outcome
    /// into `result` and the displacement into the network.
    void descend(SpringPatch& patch, double scale, const RelaxOptions& options, RelaxResult& result,
        SpringNetwork& network, const Job& job)
    {
        Eigen::VectorXd u = patch.displacement();
        SpringPatch::Response state = patch.response(u);
        const auto measure = [&] { result.residual = scale > 0.0 ? largest_length(state.forces) / scale : 0.0; };
        measure();
        while (result.residual > options.tolerance) {
            if (job.cancelled()) {
                result.status = RelaxStatus::cancelled;
                break;
            }
            if (result.iterations >= options.max_iterations) {
                result.status = RelaxStatus::out_of_iterations;
                result.message = "the wound is still opening: out of iterations";
                break;
            }
            job.report("relax springs", std::clamp(std::log(result.residual) / std::log(options.tolerance), 0.0, 1.0));
            patch.linearise(u);
            const double forcing = std::clamp(0.3 * options.tolerance / result.residual, 1e-4, 0.05);
            const Solve step = solve(patch, patch.inverse_diagonal(), -state.forces, forcing,
                options.max_iterations - result.iterations, job);
            result.iterations += std::max(step.iterations, 1);
            if (!search(patch, step.x, u, state)) {
                result.status = RelaxStatus::no_descent;
                result.message = "no step lowers the energy of the springs any further";
                break;
            }
            measure();
        }
        patch.store(u, network);
        result.energy = state.energy;
        result.inverted = state.inverted;
    }

} // namespace

SpringPatch::SpringPatch(const SpringNetwork& network, std::vector<VertexId> active)
    : active_(std::move(active))
{
    RETRACTOR_ASSERT(std::adjacent_find(active_.begin(), active_.end(), std::greater_equal<>()) == active_.end());
    const auto n = static_cast<std::int32_t>(active_.size());
    std::vector<std::int32_t> number(network.vertex_slots(), -1);
    for (std::int32_t i = 0; i < n; ++i) {
        const VertexId v = active_[at(i)];
        if (v < 0 || at(v) >= network.vertex_slots() || network.is_fixed(v) || network.elements(v).empty())
            throw InputError("a vertex that is to move is fixed or in no element", "vertex " + std::to_string(v));
        number[at(v)] = i;
        for (int axis = 0; axis < 3; ++axis)
            if ((network.fixed_axes(v) >> axis & 1U) != 0)
                held_.push_back(3 * static_cast<Eigen::Index>(i) + axis);
    }
    const auto number_of = [&](VertexId v) {
        if (number[at(v)] < 0) {
            number[at(v)] = n + static_cast<std::int32_t>(rim_.size());
            rim_.push_back(v);
        }
        return number[at(v)];
    };
    const Points& rest = network.rest();
    row_.push_back(0);
    std::vector<TetId> tets;
    for (const VertexId v : active_) {
        for (const SpringEnd& end : network.springs(v))
            ends_.push_back({ number_of(end.other), end.length, end.stiffness, end.force_density,
                (rest.row(end.other) - rest.row(v)).transpose() });
        row_.push_back(ends_.size());
        const auto around = network.elements(v);
        tets.insert(tets.end(), around.begin(), around.end());
    }
    std::sort(tets.begin(), tets.end());
    tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
    for (const TetId t : tets) {
        Element element { {}, network.rest_volume(t), network.crush_stiffness(t) };
        for (std::size_t i = 0; i < 4; ++i)
            element.nodes[i] = number_of(network.nodes(t)[i]);
        elements_.push_back(element);
        if (network.brace(t) > 0.0) {
            Braced& braced = braced_.emplace_back();
            braced.nodes = element.nodes;
            braced.stiffness = element.volume * network.brace(t);
        }
    }
    const auto all = static_cast<Eigen::Index>(active_.size() + rim_.size());
    rest_.resize(all, 3);
    start_.resize(3 * n);
    load_.resize(3 * n);
    rim_displacement_.resize(3 * static_cast<Eigen::Index>(rim_.size()));
    for (Eigen::Index i = 0; i < n; ++i) {
        const VertexId v = active_[static_cast<std::size_t>(i)];
        rest_.row(i) = rest.row(v);
        start_.segment<3>(3 * i) = network.displacement().row(v).transpose();
        load_.segment<3>(3 * i) = network.release(v);
    }
    for (std::size_t i = 0; i < rim_.size(); ++i) {
        rest_.row(n + static_cast<Eigen::Index>(i)) = rest.row(rim_[i]);
        rim_displacement_.segment<3>(3 * static_cast<Eigen::Index>(i))
            = network.displacement().row(rim_[i]).transpose();
    }
    for (Braced& element : braced_) {
        Mat3 edges;
        for (std::size_t i = 0; i < 3; ++i)
            edges.col(static_cast<Eigen::Index>(i))
                = (rest_.row(element.nodes[i + 1]) - rest_.row(element.nodes[0])).transpose();
        const Mat3 inverse = edges.inverse();
        element.gradients[0] = -inverse.colwise().sum().transpose();
        for (std::size_t i = 0; i < 3; ++i)
            element.gradients[i + 1] = inverse.row(static_cast<Eigen::Index>(i)).transpose();
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = 0; j < 4; ++j)
                element.entry[4 * i + j] = entry(element.nodes[i], element.nodes[j]);
    }
}

void SpringPatch::mask(Eigen::VectorXd& vector) const
{
    for (const Eigen::Index unknown : held_)
        vector[unknown] = 0.0;
}

Mat3 SpringPatch::deformation(const Braced& element, const Eigen::VectorXd& u) const
{
    Mat3 F = Mat3::Identity();
    for (std::size_t i = 0; i < 4; ++i)
        F += moved(element.nodes[i], u) * element.gradients[i].transpose();
    return F;
}

Vec3 SpringPatch::moved(std::int32_t node, const Eigen::VectorXd& u) const
{
    const auto n = static_cast<std::int32_t>(active_.size());
    return node < n ? Vec3(u.segment<3>(3 * node)) : Vec3(rim_displacement_.segment<3>(3 * (node - n)));
}

std::vector<SpringPatch::Crushed> SpringPatch::crushed_elements(
    const Eigen::VectorXd& u, double& energy, int& inverted) const
{
    std::vector<Crushed> crushed;
    for (const Element& element : elements_) {
        std::array<Vec3, 4> x;
        for (std::size_t i = 0; i < 4; ++i)
            x[i] = rest_.row(element.nodes[i]).transpose() + moved(element.nodes[i], u);
        const Vec3 a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
        const double six = 6.0 * element.volume, ratio = a.dot(b.cross(c)) / six;
        if (ratio >= SpringNetwork::kCrushed)
            continue;
        inverted += ratio <= 0.0 ? 1 : 0;
        const double lack = SpringNetwork::kCrushed - ratio, weight = element.volume * element.penalty;
        energy += weight * lack * lack * lack / 3.0;
        Crushed item { element.nodes, {}, -weight * lack * lack, 2.0 * weight * lack };
        item.slope[1] = b.cross(c) / six;
        item.slope[2] = c.cross(a) / six;
        item.slope[3] = a.cross(b) / six;
        item.slope[0] = -(item.slope[1] + item.slope[2] + item.slope[3]);
        crushed.push_back(item);
    }
    return crushed;
}

SpringPatch::Response SpringPatch::response(const Eigen::VectorXd& u) const
{
    RETRACTOR_ASSERT(u.size() == start_.size());
    Response r;
    const auto n = static_cast<std::int32_t>(active_.size());
    r.forces = -load_;
    r.energy = -load_.dot(u);
    for (std::int32_t v = 0; v < n; ++v) {
        const Vec3 here = u.segment<3>(3 * v);
        Vec3 force = Vec3::Zero();
        double energy = 0.0;
        for (std::size_t i = row_[at(v)]; i < row_[at(v) + 1]; ++i) {
            const End& end = ends_[i];
            const Vec3 du = moved(end.other, u) - here, y = end.at_rest + du;
            const double l = y.norm(), stretch = l - end.length;
            const double at_rest = end.force_density * end.length;
            force -= (at_rest + end.stiffness * stretch) / l * y - end.force_density * end.at_rest;
            energy += (end.other < n ? 0.5 : 1.0)
                * (at_rest * stretch + 0.5 * end.stiffness * stretch * stretch
                    - end.force_density * end.at_rest.dot(du));
        }
        r.forces.segment<3>(3 * v) += force;
        r.energy += energy;
    }
    for (const Braced& element : braced_) {
        const Mat3 F = deformation(element, u);
        Mat3 stress = Mat3::Zero(); // stress times volume
        for (const Vec3& axis : brace_axes()) {
            const Vec3 y = F * axis;
            const double l = y.norm(), strain = l - 1.0;
            r.energy += 0.5 * element.stiffness * strain * strain;
            stress += element.stiffness * strain / l * y * axis.transpose();
        }
        for (std::size_t i = 0; i < 4; ++i)
            if (element.nodes[i] < n)
                r.forces.segment<3>(3 * element.nodes[i]) += stress * element.gradients[i];
    }
    const std::vector<Crushed> crushed = crushed_elements(u, r.energy, r.inverted);
    r.crushed = static_cast<int>(crushed.size());
    for (const Crushed& item : crushed)
        for (std::size_t i = 0; i < 4; ++i)
            if (item.nodes[i] < n)
                r.forces.segment<3>(3 * item.nodes[i]) += item.force * item.slope[i];
    mask(r.forces);
    return r;
}

std::int32_t SpringPatch::entry(std::int32_t row, std::int32_t column) const
{
    if (row >= static_cast<std::int32_t>(active_.size()))
        return -1;
    if (row == column)
        return static_cast<std::int32_t>(ends_.size()) + row;
    std::size_t i = row_[at(row)];
    while (ends_[i].other != column) // a spring joins any two corners of an element
        ++i;
    return static_cast<std::int32_t>(i);
}

SpringPatch::Block& SpringPatch::block(std::int32_t entry)
{
    const std::size_t i = at(entry);
    return i < ends_.size() ? coupling_[i] : diagonal_[i - ends_.size()];
}

void SpringPatch::linearise(const Eigen::VectorXd& u, bool true_tangent)
{
    const auto n = static_cast<std::int32_t>(active_.size());
    diagonal_.assign(active_.size(), Block::Zero());
    coupling_.resize(ends_.size());
    const auto spring = [&](const Vec3& direction, double along, double pull) {
        const double across = true_tangent ? pull : std::max(pull, 0.0);
        return Mat3((along - across) * direction * direction.transpose() + across * Mat3::Identity());
    };
    for (std::int32_t v = 0; v < n; ++v) {
        const Vec3 here = u.segment<3>(3 * v);
        for (std::size_t i = row_[at(v)]; i < row_[at(v) + 1]; ++i) {
            const End& end = ends_[i];
            const Vec3 y = end.at_rest + moved(end.other, u) - here;
            const double l = y.norm();
            const Mat3 stiffness
                = spring(y / l, end.stiffness, (end.force_density * end.length + end.stiffness * (l - end.length)) / l);
            coupling_[i] = -stiffness;
            diagonal_[at(v)] += stiffness;
        }
    }
    for (const Braced& element : braced_) {
        const Mat3 F = deformation(element, u);
        std::array<Mat3, 10> sums; // sums for the pairs i <= j
        sums.fill(Mat3::Zero());
        for (const Vec3& axis : brace_axes()) {
            const Vec3 y = F * axis;
            const double l = y.norm();
            const Mat3 stiffness = spring(y / l, element.stiffness, element.stiffness * (l - 1.0) / l);
            std::array<double, 4> share {};
            for (std::size_t i = 0; i < 4; ++i)
                share[i] = element.gradients[i].dot(axis);
            for (std::size_t i = 0, pair = 0; i < 4; ++i)
                for (std::size_t j = i; j < 4; ++j, ++pair)
                    sums[pair] += share[i] * share[j] * stiffness;
        }
        for (std::size_t i = 0, pair = 0; i < 4; ++i)
            for (std::size_t j = i; j < 4; ++j, ++pair) { // each block is symmetric
                if (element.entry[4 * i + j] >= 0)
                    block(element.entry[4 * i + j]) += sums[pair];
                if (i != j && element.entry[4 * j + i] >= 0)
                    block(element.entry[4 * j + i]) += sums[pair];
            }
    }
    double energy = 0.0;
    int inverted = 0;
    for (const Crushed& item : crushed_elements(u, energy, inverted))
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = 0; item.nodes[i] < n && j < 4; ++j)
                block(entry(item.nodes[i], item.nodes[j]))
                    += item.stiffness * item.slope[i] * item.slope[j].transpose();
    for (const Eigen::Index unknown : held_) {
        Block& here = diagonal_[static_cast<std::size_t>(unknown / 3)];
        const double kept = here(unknown % 3, unknown % 3);
        here.row(unknown % 3).setZero();
        here.col(unknown % 3).setZero();
        here(unknown % 3, unknown % 3) = kept;
    }
}

Eigen::VectorXd SpringPatch::multiply(const Eigen::VectorXd& x) const
{
    RETRACTOR_ASSERT(diagonal_.size() == active_.size()); // linearise() was called
    RETRACTOR_ASSERT(x.size() == start_.size());
    const auto n = static_cast<std::int32_t>(active_.size());
    Eigen::VectorXd product(x.size());
    for (std::int32_t v = 0; v < n; ++v) {
        Vec3 sum = diagonal_[at(v)] * x.segment<3>(3 * v);
        for (std::size_t i = row_[at(v)]; i < row_[at(v) + 1]; ++i)
            if (const std::int32_t other = ends_[i].other; other < n)
                sum.noalias() += coupling_[i] * x.segment<3>(3 * other);
        product.segment<3>(3 * v) = sum;
    }
    mask(product);
    return product;
}

std::vector<Mat3> SpringPatch::inverse_diagonal() const
{
    constexpr double kFlat = 1e-6; // all springs lie in one plane: nothing resists motion across the plane
    std::vector<Mat3> inverse;
    inverse.reserve(diagonal_.size());
    for (const Block& block : diagonal_)
        inverse.push_back((block + kFlat * block.trace() * Block::Identity()).inverse());
    return inverse;
}

void SpringPatch::store(const Eigen::VectorXd& u, SpringNetwork& network) const
{
    RETRACTOR_ASSERT(u.size() == start_.size());
    for (std::size_t i = 0; i < active_.size(); ++i)
        network.place(active_[i], u.segment<3>(3 * static_cast<Eigen::Index>(i)));
}

std::vector<VertexId> vertices_near_wound(const SpringNetwork& network, double reach_mm)
{
    std::vector<VertexId> active;
    const auto moves = [&](VertexId v) { return !network.is_fixed(v) && !network.elements(v).empty(); };
    if (reach_mm == 0.0) {
        for (VertexId v = 0; v < static_cast<VertexId>(network.vertex_slots()); ++v)
            if (moves(v))
                active.push_back(v);
        return active;
    }
    std::vector<double> distance(network.vertex_slots(), std::numeric_limits<double>::infinity());
    using Place = std::pair<double, VertexId>;
    std::priority_queue<Place, std::vector<Place>, std::greater<>> front;
    for (const VertexId v : network.lip_vertices()) {
        distance[at(v)] = 0.0;
        front.emplace(0.0, v);
    }
    while (!front.empty()) {
        const auto [d, v] = front.top();
        front.pop();
        if (d > distance[at(v)])
            continue;
        if (moves(v))
            active.push_back(v);
        for (const SpringEnd& end : network.springs(v))
            if (const double there = d + end.length; there <= reach_mm && there < distance[at(end.other)]) {
                distance[at(end.other)] = there;
                front.emplace(there, end.other);
            }
    }
    std::sort(active.begin(), active.end());
    return active;
}

RelaxResult relax(SpringNetwork& network, const RelaxOptions& options, const Job& job)
{
    check_options(options);
    const Stopwatch watch;
    RelaxResult result;
    double released = 0.0;
    for (const VertexId v : network.lip_vertices())
        released = std::max(released, network.release(v).norm());
    if (!(released > 0.0) && network.displacement().isZero(0.0))
        return result;
    SpringPatch patch(network, vertices_near_wound(network, released > 0.0 ? options.reach_mm : 0.0));
    result.active = patch.active().size();
    const double first = largest_length(patch.response(patch.displacement()).forces);
    const double scale = released > 0.0 ? released : first; // after an undone cut: relative to the initial force
    descend(patch, scale, options, result, network, job);
    result.seconds = watch.seconds();
    return result;
}

} // namespace retractor::fem
