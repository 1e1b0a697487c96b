#include "fem/interactive/multifrontal_factor.h"

#include "fem/interactive/vertex_matrix.h"
#include "fem/linear_algebra/parallel.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <utility>

namespace retractor::fem {

namespace {

    using RowBlock = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

    constexpr std::int32_t kOpenWeight = 64; // weight of a separator's vertex, which is factored anew with every cut

    double front_work(double own, double bound)
    {
        return own * own * own / 3.0 + own * own * bound + own * bound * bound;
    }

    /// Divides vertices until each part has few open vertices.
    class Dissector {
    public:
        Dissector(const OnlineStiffness& K, std::vector<VertexId> free, const std::vector<VertexId>& open,
            std::size_t part_vertices)
            : K_(K)
            , part_vertices_(part_vertices)
            , number_(K.slot_count(), -1)
            , open_(K.slot_count(), 0)
        {
            for (const VertexId v : open)
                open_[static_cast<std::size_t>(v)] = 1;
            dissect(std::move(free), -1);
        }
        std::vector<Dissection::Part> parts;

    private:
        bool is_open(VertexId v) const { return open_[static_cast<std::size_t>(v)] != 0; }

        void add_leaf(const std::vector<VertexId>& vertices, std::int32_t parent)
        {
            Dissection::Part leaf { parent, {}, {} };
            for (const VertexId v : vertices)
                (is_open(v) ? leaf.open : leaf.closed).push_back(v);
            parts.push_back(std::move(leaf));
        }

        void dissect(std::vector<VertexId> vertices, std::int32_t parent)
        {
            const auto opened = static_cast<std::size_t>(
                std::count_if(vertices.begin(), vertices.end(), [&](VertexId v) { return is_open(v); }));
            if (opened <= part_vertices_ || vertices.size() < 3 * part_vertices_)
                return add_leaf(vertices, parent);
            std::array<std::vector<VertexId>, 3> split;
            for (std::size_t i = 0; i < vertices.size(); ++i)
                number_[static_cast<std::size_t>(vertices[i])] = static_cast<std::int32_t>(i);
            SymmetricPattern graph; // both triangles, without the diagonal
            std::vector<std::int32_t> weight;
            graph.column_start.push_back(0);
            for (const VertexId v : vertices) {
                const auto begin = static_cast<std::ptrdiff_t>(graph.row.size());
                for (const VertexId w : K_.row(v).column)
                    if (const std::int32_t i = number_[static_cast<std::size_t>(w)]; i >= 0 && w != v)
                        graph.row.push_back(i);
                std::sort(graph.row.begin() + begin, graph.row.end());
                graph.column_start.push_back(static_cast<std::int32_t>(graph.row.size()));
                weight.push_back(is_open(v) ? kOpenWeight : 1);
            }
            const std::vector<std::int32_t> side = bisect(graph, weight);
            for (std::size_t i = 0; i < vertices.size(); ++i) {
                number_[static_cast<std::size_t>(vertices[i])] = -1;
                split[static_cast<std::size_t>(side[i])].push_back(vertices[i]);
            }
            if (split[0].empty() || split[1].empty())
                return add_leaf(vertices, parent);
            vertices = {};
            const auto self = static_cast<std::int32_t>(parts.size());
            parts.push_back({ parent, {}, std::move(split[2]) });
            dissect(std::move(split[0]), self);
            dissect(std::move(split[1]), self);
        }

        const OnlineStiffness& K_;
        std::size_t part_vertices_;
        std::vector<std::int32_t> number_;
        std::vector<std::uint8_t> open_;
    };

    double work_of(const OnlineStiffness& K, const std::vector<Dissection::Part>& parts)
    {
        std::vector<std::int32_t> part(K.slot_count(), -1), depth(parts.size(), 0);
        for (std::size_t p = 0; p < parts.size(); ++p) {
            for (const auto* list : { &parts[p].closed, &parts[p].open })
                for (const VertexId v : *list)
                    part[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(p);
            if (parts[p].parent >= 0)
                depth[p] = depth[static_cast<std::size_t>(parts[p].parent)] + 1;
        }
        std::vector<std::set<VertexId>> bound(parts.size());
        double work = 0.0;
        for (std::size_t p = parts.size(); p-- > 0;) {
            for (const auto* list : { &parts[p].closed, &parts[p].open })
                for (const VertexId v : *list)
                    for (const VertexId w : K.row(v).column)
                        if (const std::int32_t other = part[static_cast<std::size_t>(w)];
                            other >= 0 && depth[static_cast<std::size_t>(other)] < depth[p])
                            bound[p].insert(w);
            work += front_work(
                3.0 * static_cast<double>(parts[p].open.size()), 3.0 * static_cast<double>(bound[p].size()));
            if (parts[p].parent >= 0)
                for (const VertexId v : bound[p])
                    if (part[static_cast<std::size_t>(v)] != parts[p].parent)
                        bound[static_cast<std::size_t>(parts[p].parent)].insert(v);
        }
        return work;
    }

    using Rows = std::vector<VertexId>;

    Eigen::MatrixXd gathered(const Eigen::MatrixXd& by_id, const Rows& vertices)
    {
        Eigen::MatrixXd values(3 * static_cast<Eigen::Index>(vertices.size()), by_id.cols());
        for (Eigen::Index c = 0; c < by_id.cols(); ++c)
            for (std::size_t i = 0; i < vertices.size(); ++i)
                values.col(c).segment<3>(3 * static_cast<Eigen::Index>(i)) = by_id.col(c).segment<3>(3 * vertices[i]);
        return values;
    }
    void scatter(const Eigen::MatrixXd& values, const Rows& vertices, Eigen::MatrixXd& by_id)
    {
        for (Eigen::Index c = 0; c < by_id.cols(); ++c)
            for (std::size_t i = 0; i < vertices.size(); ++i)
                by_id.col(c).segment<3>(3 * vertices[i]) = values.col(c).segment<3>(3 * static_cast<Eigen::Index>(i));
    }
    void subtract(const Eigen::MatrixXd& values, const Rows& vertices, Eigen::MatrixXd& by_id)
    {
        for (Eigen::Index c = 0; c < by_id.cols(); ++c)
            for (std::size_t i = 0; i < vertices.size(); ++i)
                by_id.col(c).segment<3>(3 * vertices[i]) -= values.col(c).segment<3>(3 * static_cast<Eigen::Index>(i));
    }

} // namespace

Dissection dissect(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& fixed,
    const std::vector<VertexId>& open, std::size_t part_vertices)
{
    std::vector<VertexId> free;
    for (VertexId v = 0; v < static_cast<VertexId>(stiffness.slot_count()); ++v)
        if (stiffness.alive(v)
            && (static_cast<std::size_t>(v) >= fixed.size() || fixed[static_cast<std::size_t>(v)] == 0))
            free.push_back(v);
    Dissector dissector(stiffness, std::move(free), open, part_vertices);
    Dissection dissection { std::move(dissector.parts), 0.0 };
    dissection.work = work_of(stiffness, dissection.parts);
    return dissection;
}

MultifrontalFactor::MultifrontalFactor(const OnlineStiffness& stiffness, const Dissection& dissection)
    : part_(stiffness.slot_count(), -1)
{
    fronts_.resize(dissection.parts.size());
    for (std::size_t p = 0; p < fronts_.size(); ++p) {
        const Dissection::Part& part = dissection.parts[p];
        Front& front = fronts_[p];
        front.parent = part.parent;
        RETRACTOR_ASSERT(part.parent < static_cast<std::int32_t>(p)); // parents come first
        if (part.parent >= 0) {
            front.depth = fronts_[static_cast<std::size_t>(part.parent)].depth + 1;
            fronts_[static_cast<std::size_t>(part.parent)].children.push_back(static_cast<std::int32_t>(p));
        }
        front.members.insert(part.open.begin(), part.open.end());
        front.closed = part.closed;
        for (const VertexId v : part.closed)
            closed_.emplace_hint(closed_.end(), v, static_cast<std::int32_t>(p));
        for (const auto* list : { &part.closed, &part.open })
            for (const VertexId v : *list) {
                part_[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(p);
                planned_.insert(v);
            }
    }
    for (Front& front : fronts_)
        condense(stiffness, front);
    std::vector<std::uint8_t> active(stiffness.slot_count(), 0);
    for (std::size_t v = 0; v < active.size(); ++v)
        active[v] = part_[v] >= 0 ? 1 : 0;
    if (!update(stiffness, active, {}))
        throw SolverError("a part of the tissue has no support (the stiffness is not positive definite)");
    share_out(); // the cost of each front is known only now
}

std::vector<VertexId> MultifrontalFactor::open_vertices() const
{
    std::vector<VertexId> open;
    for (const Front& front : fronts_)
        if (front.children.empty())
            open.insert(open.end(), front.members.begin(), front.members.end());
    std::sort(open.begin(), open.end());
    return open;
}

std::size_t MultifrontalFactor::open_count() const
{
    std::size_t count = 0;
    for (const Front& front : fronts_)
        count += front.members.size();
    return count;
}

void MultifrontalFactor::touch(VertexId v, const OnlineStiffness::Row& before)
{
    RETRACTOR_ASSERT(v >= 0);
    if (closed(v))
        reference_.try_emplace(v, before);
    if (before.column.empty() && !planned_.contains(v)) // another vertex has had this id
        put(v, -1);
    touched_.insert(v);
}

std::vector<VertexId> MultifrontalFactor::changed_but_closed(const OnlineStiffness& stiffness) const
{
    std::vector<VertexId> changed;
    for (const auto& [v, row] : reference_)
        if (!(stiffness.row(v) == row))
            changed.push_back(v);
    return changed;
}

void MultifrontalFactor::open(const OnlineStiffness& stiffness, const std::vector<VertexId>& vertices)
{
    std::set<std::int32_t> leaves;
    for (const VertexId v : vertices) {
        const auto found = closed_.find(v);
        if (found == closed_.end())
            continue;
        leaves.insert(found->second);
        Front& leaf = fronts_[static_cast<std::size_t>(found->second)];
        std::erase(leaf.closed, v);
        leaf.members.insert(v);
        touched_.insert(v);
        reference_.erase(v);
        closed_.erase(found);
    }
    for (const std::int32_t leaf : leaves)
        condense(stiffness, fronts_[static_cast<std::size_t>(leaf)]);
}

void MultifrontalFactor::condense(const OnlineStiffness& stiffness, Front& front)
{
    front.dirty = true;
    front.beside.clear();
    front.taken.resize(0, 0);
    front.condensing = SparseCholesky();
    if (front.closed.empty())
        return;
    std::vector<std::int32_t> number(stiffness.slot_count(), -1);
    for (std::size_t i = 0; i < front.closed.size(); ++i)
        number[static_cast<std::size_t>(front.closed[i])] = static_cast<std::int32_t>(i);
    std::set<VertexId> beside;
    for (const VertexId v : front.closed)
        for (const VertexId w : stiffness.row(v).column)
            if (number[static_cast<std::size_t>(w)] < 0 && part_of(w) >= 0)
                beside.insert(w);
    front.beside.assign(beside.begin(), beside.end());
    std::vector<VertexId> vertices = front.closed;
    vertices.insert(vertices.end(), front.beside.begin(), front.beside.end());
    for (std::size_t i = front.closed.size(); i < vertices.size(); ++i)
        number[static_cast<std::size_t>(vertices[i])] = static_cast<std::int32_t>(i);
    const auto row = [&](VertexId v) -> const OnlineStiffness::Row& { return stiffness.row(v); };
    const auto number_of = [&](VertexId v) { return number[static_cast<std::size_t>(v)]; };
    SparseMatrix matrix = vertex_matrix(row, vertices, number_of);
    front.condensing.analyse_in_order(std::move(matrix.pattern),
        condensing_order(row, vertices, number_of, front.closed.size(), Ordering::nested_dissection));
    front.taken = front.condensing.condense(matrix.values, 3 * static_cast<Eigen::Index>(front.beside.size()));
    front.condensing.keep_factor_only();
}

void MultifrontalFactor::put(VertexId v, std::int32_t part)
{
    RETRACTOR_ASSERT(v >= 0 && part < static_cast<std::int32_t>(fronts_.size()));
    RETRACTOR_ASSERT(!closed(v)); // closed vertices have no place among the members
    if (static_cast<std::size_t>(v) >= part_.size())
        part_.resize(static_cast<std::size_t>(v) + 1, -1);
    if (part_of(v) >= 0) {
        front_of(v).members.erase(v);
        front_of(v).dirty = true;
    }
    part_[static_cast<std::size_t>(v)] = part;
    if (part >= 0) {
        front_of(v).members.insert(v);
        front_of(v).dirty = true;
    }
}

std::int32_t MultifrontalFactor::meet(std::int32_t a, std::int32_t b) const
{
    const auto at = [&](std::int32_t p) -> const Front& { return fronts_[static_cast<std::size_t>(p)]; };
    while (a != b)
        (at(a).depth >= at(b).depth ? a : b) = at(at(a).depth >= at(b).depth ? a : b).parent;
    return a;
}

bool MultifrontalFactor::comparable(std::int32_t a, std::int32_t b) const
{
    const std::int32_t both = meet(a, b);
    return both == a || both == b;
}

/// Puts each added vertex into the deepest part of its neighbours, or above all these parts where they do not lie on
/// one path to the root.
void MultifrontalFactor::place_added(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active)
{
    std::vector<VertexId> waiting;
    for (const VertexId v : touched_) {
        const bool lives = static_cast<std::size_t>(v) < active.size() && active[static_cast<std::size_t>(v)] != 0;
        if (!lives && part_of(v) >= 0 && !planned_.contains(v))
            put(v, -1);
        if (lives && part_of(v) < 0)
            waiting.push_back(v);
    }
    while (!waiting.empty()) {
        std::vector<VertexId> still_waiting;
        for (const VertexId v : waiting) {
            std::int32_t part = -1;
            for (const VertexId w : stiffness.row(v).column)
                if (const std::int32_t other = part_of(w); other >= 0 && active[static_cast<std::size_t>(w)] != 0) {
                    if (part < 0)
                        part = other;
                    const std::int32_t both = meet(part, other);
                    part = both == part ? other : both == other ? part : both;
                }
            if (part < 0)
                still_waiting.push_back(v);
            else
                put(v, part);
        }
        if (still_waiting.size() == waiting.size()) { // these vertices have no free neighbours
            for (const VertexId v : still_waiting)
                put(v, 0);
            return;
        }
        waiting = std::move(still_waiting);
    }
}

/// Moves vertices up until neighbours lie on one path to the root; of two neighbours, the vertex that was added later
/// moves. A vertex that lies higher than necessary costs time only.
void MultifrontalFactor::raise_strangers(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active)
{
    std::set<VertexId> look = touched_;
    while (!look.empty()) {
        const VertexId v = *look.begin();
        look.erase(look.begin());
        if (part_of(v) < 0 || static_cast<std::size_t>(v) >= active.size() || active[static_cast<std::size_t>(v)] == 0)
            continue;
        for (const VertexId w : stiffness.row(v).column) {
            if (part_of(w) < 0 || active[static_cast<std::size_t>(w)] == 0 || comparable(part_of(v), part_of(w)))
                continue;
            const std::int32_t both = meet(part_of(v), part_of(w));
            const VertexId raised = planned_.contains(v) && !planned_.contains(w) ? w : v;
            put(raised, both);
            look.insert(raised);
        }
    }
}

/// Collects the vertices that a front eliminates, and the higher vertices that couple to them.
void MultifrontalFactor::collect(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active,
    std::int32_t number, std::vector<std::int32_t>& place)
{
    Front& front = fronts_[static_cast<std::size_t>(number)];
    front.own.clear();
    front.bound.clear();
    const auto is_active = [&](VertexId v) {
        return static_cast<std::size_t>(v) < active.size() && active[static_cast<std::size_t>(v)] != 0;
    };
    for (const VertexId v : front.members)
        if (is_active(v) && !held_.contains(v)) {
            place[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(front.own.size());
            front.own.push_back(v);
        }
    constexpr std::int32_t kSeen = -2;
    const auto beyond = [&](VertexId v) {
        const std::int32_t part = part_of(v);
        if (part < 0 || part == number || place[static_cast<std::size_t>(v)] != -1 || !is_active(v)
            || fronts_[static_cast<std::size_t>(part)].depth > front.depth)
            return;
        place[static_cast<std::size_t>(v)] = kSeen;
        front.bound.push_back(v);
    };
    for (const VertexId v : front.own)
        for (const VertexId w : stiffness.row(v).column)
            beyond(w);
    for (const VertexId v : front.beside)
        beyond(v);
    for (const std::int32_t child : front.children)
        for (const VertexId v : fronts_[static_cast<std::size_t>(child)].bound)
            beyond(v);
    std::sort(front.bound.begin(), front.bound.end(), [&](VertexId a, VertexId b) {
        const std::int32_t pa = part_of(a), pb = part_of(b); // children have higher numbers than their parents
        return pa != pb ? pa > pb : a < b;
    });
    for (std::size_t i = 0; i < front.bound.size(); ++i)
        place[static_cast<std::size_t>(front.bound[i])] = static_cast<std::int32_t>(front.own.size() + i);
}

bool MultifrontalFactor::factor(const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active,
    std::int32_t number, std::vector<std::int32_t>& place, Cores cores)
{
    Front& front = fronts_[static_cast<std::size_t>(number)];
    collect(stiffness, active, number, place);
    const auto own = static_cast<Eigen::Index>(front.own.size()), bound = static_cast<Eigen::Index>(front.bound.size());
    front.L11 = Eigen::MatrixXd::Zero(3 * own, 3 * own);
    front.L21 = Eigen::MatrixXd::Zero(3 * bound, 3 * own);
    front.update = Eigen::MatrixXd::Zero(3 * bound, 3 * bound);
    const auto block = [&](Eigen::Index r, Eigen::Index c) { // a block of the lower triangle
        Eigen::MatrixXd& in = c >= own ? front.update : r >= own ? front.L21 : front.L11;
        return in.block<3, 3>(3 * (r >= own ? r - own : r), 3 * (c >= own ? c - own : c));
    };
    for (std::size_t j = 0; j < front.own.size(); ++j) {
        const OnlineStiffness::Row& row = stiffness.row(front.own[j]);
        for (std::size_t k = 0; k < row.column.size(); ++k)
            if (const std::int32_t at = place[static_cast<std::size_t>(row.column[k])];
                at >= static_cast<std::int32_t>(j))
                block(at, static_cast<Eigen::Index>(j)) += RowBlock(row.value.data() + 9 * k).transpose();
    }
    /// Adds the lower triangle of a matrix on some vertices. Vertices without a place are held and skipped.
    const auto add = [&](const Eigen::MatrixXd& lower, const std::vector<VertexId>& vertices) {
        std::vector<Eigen::Index> at;
        for (const VertexId v : vertices)
            at.push_back(place[static_cast<std::size_t>(v)]);
        for (std::size_t j = 0; j < at.size(); ++j) {
            if (at[j] < 0)
                continue;
            const auto c = 3 * static_cast<Eigen::Index>(j);
            block(at[j], at[j]).triangularView<Eigen::Lower>() += lower.block<3, 3>(c, c);
            for (std::size_t i = j + 1; i < at.size(); ++i) {
                if (at[i] < 0)
                    continue;
                const auto from = lower.block<3, 3>(3 * static_cast<Eigen::Index>(i), c);
                if (at[i] > at[j])
                    block(at[i], at[j]) += from;
                else
                    block(at[j], at[i]) += from.transpose();
            }
        }
    };
    add(front.taken, front.beside);
    for (const std::int32_t child : front.children)
        add(fronts_[static_cast<std::size_t>(child)].update, fronts_[static_cast<std::size_t>(child)].bound);
    for (const auto* list : { &front.own, &front.bound })
        for (const VertexId v : *list)
            place[static_cast<std::size_t>(v)] = -1;
    if (own == 0)
        return true;
    if (!cholesky(front.L11))
        return false;
    divide_by_transpose(front.L11, front.L21, cores);
    subtract_lower_product(front.update, front.L21, front.L21, cores);
    return true;
}

/// Divides the fronts into two groups for two cores, and the fronts that follow both groups.
void MultifrontalFactor::share_out()
{
    constexpr double kMuch = 1.0 / 6.0;
    std::vector<double> work(fronts_.size(), 0.0);
    double total = 0.0;
    for (std::size_t p = fronts_.size(); p-- > 0;) {
        const Front& f = fronts_[p];
        const double own
            = front_work(static_cast<double>(f.members.size()), static_cast<double>(f.bound.size() + f.beside.size()));
        work[p] += own;
        total += own;
        if (f.parent >= 0)
            work[static_cast<std::size_t>(f.parent)] += work[p];
    }
    enum Where : std::int8_t { as_parent, first, second, above };
    std::vector<std::int8_t> where(fronts_.size(), as_parent);
    std::vector<std::int32_t> subtrees { 0 };
    const auto lighter = [&](std::int32_t a, std::int32_t b) {
        return work[static_cast<std::size_t>(a)] < work[static_cast<std::size_t>(b)];
    };
    for (;;) {
        const auto heaviest = std::max_element(subtrees.begin(), subtrees.end(), lighter);
        const auto h = static_cast<std::size_t>(*heaviest);
        if (fronts_[h].children.empty() || work[h] <= kMuch * total)
            break;
        where[h] = above;
        subtrees.erase(heaviest);
        subtrees.insert(subtrees.end(), fronts_[h].children.begin(), fronts_[h].children.end());
    }
    std::stable_sort(subtrees.begin(), subtrees.end(), [&](std::int32_t a, std::int32_t b) { return lighter(b, a); });
    std::array<double, 2> load { 0.0, 0.0 };
    for (const std::int32_t s : subtrees) {
        const std::size_t to = load[1] < load[0] ? 1 : 0;
        load[to] += work[static_cast<std::size_t>(s)];
        where[static_cast<std::size_t>(s)] = to == 0 ? first : second;
    }
    above_.clear();
    below_ = {};
    for (std::size_t p = 0; p < fronts_.size(); ++p)
        if (where[p] == as_parent)
            where[p] = where[static_cast<std::size_t>(fronts_[p].parent)];
    for (std::size_t p = fronts_.size(); p-- > 0;)
        (where[p] == above ? above_ : below_[where[p] == first ? 0 : 1]).push_back(static_cast<std::int32_t>(p));
}

bool MultifrontalFactor::update(
    const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& active, const std::set<VertexId>& held)
{
    part_.resize(std::max(part_.size(), stiffness.slot_count()), -1);
    std::set_symmetric_difference(
        held.begin(), held.end(), held_.begin(), held_.end(), std::inserter(touched_, touched_.end()));
    held_ = held;
    place_added(stiffness, active);
    raise_strangers(stiffness, active);
    for (const VertexId v : touched_)
        if (part_of(v) >= 0)
            front_of(v).dirty = true;
    touched_.clear();
    for (std::size_t p = fronts_.size(); p-- > 0;)
        if (fronts_[p].dirty && fronts_[p].parent >= 0)
            fronts_[static_cast<std::size_t>(fronts_[p].parent)].dirty = true;
    if (above_.empty() && below_[0].empty())
        share_out();
    const auto is_dirty = [&](std::int32_t number) { return fronts_[static_cast<std::size_t>(number)].dirty; };
    const auto all_of = [&](const std::vector<std::int32_t>& numbers, std::vector<std::int32_t>& place, Cores cores) {
        bool good = true;
        for (const std::int32_t number : numbers)
            if (is_dirty(number) && good)
                good = factor(stiffness, active, number, place, cores);
        return good;
    };
    std::vector<std::int32_t> place(part_.size(), -1), other_place(part_.size(), -1);
    bool good = true, other_good = true;
    if (std::any_of(below_[0].begin(), below_[0].end(), is_dirty)
        && std::any_of(below_[1].begin(), below_[1].end(), is_dirty)) {
        const ScopedThread other([&] { other_good = all_of(below_[1], other_place, Cores::one); });
        good = all_of(below_[0], place, Cores::one);
    } else {
        good = all_of(below_[0], place, Cores::two) && all_of(below_[1], place, Cores::two);
    }
    if (!good || !other_good || !all_of(above_, place, Cores::two))
        return false; // the next update tries all dirty fronts again
    for (Front& front : fronts_)
        front.dirty = false;
    return true;
}

double MultifrontalFactor::reciprocal_condition() const
{
    double worst = 1.0;
    for (const Front& front : fronts_)
        if (front.L11.rows() > 0) {
            const auto pivots = front.L11.diagonal().array();
            const double ratio = pivots.minCoeff() / pivots.maxCoeff();
            worst = std::min(worst, ratio * ratio);
        }
    return worst;
}

/// Condenses the loads on the closed vertices of a leaf onto the open vertices beside them.
/// @param inside receives the input of fill_from_trailing_loaded(); stays empty where there is no load
void MultifrontalFactor::reduce_closed(const Front& front, Eigen::MatrixXd& y, Eigen::MatrixXd& inside)
{
    const Eigen::MatrixXd load = gathered(y, front.closed);
    if (!(load.array() != 0.0).any())
        return;
    inside = Eigen::MatrixXd::Zero(load.rows() + 3 * static_cast<Eigen::Index>(front.beside.size()), y.cols());
    inside.topRows(load.rows()) = load;
    front.condensing.reduce_to_trailing(inside.rows() - load.rows(), inside);
    subtract(-inside.bottomRows(inside.rows() - load.rows()), front.beside, y);
}

/// Forward substitution through some fronts, children first.
/// @param condensed per front: loads on closed vertices, as reduce_closed() gives them
void MultifrontalFactor::reduce(
    const std::vector<std::int32_t>& numbers, Eigen::MatrixXd& y, std::vector<Eigen::MatrixXd>& condensed) const
{
    for (const std::int32_t number : numbers) {
        const Front& front = fronts_[static_cast<std::size_t>(number)];
        if (!front.closed.empty())
            reduce_closed(front, y, condensed[static_cast<std::size_t>(number)]);
        if (front.own.empty())
            continue;
        Eigen::MatrixXd own = gathered(y, front.own);
        forward(front.L11, own);
        scatter(own, front.own, y);
        subtract(product(front.L21, own), front.bound, y);
    }
}

/// Sets the displacements of the closed vertices of a leaf.
/// @param reduced the result of reduce_closed()
void MultifrontalFactor::fill_closed(const Front& front, const Eigen::MatrixXd& reduced, Eigen::MatrixXd& x)
{
    const auto inside = 3 * static_cast<Eigen::Index>(front.closed.size()),
               beside = 3 * static_cast<Eigen::Index>(front.beside.size());
    Eigen::MatrixXd all(inside + beside, x.cols());
    all.bottomRows(beside) = gathered(x, front.beside);
    if (reduced.size() != 0) {
        all.topRows(inside) = reduced.topRows(inside);
        front.condensing.fill_from_trailing_loaded(beside, all);
    } else {
        front.condensing.fill_from_trailing(beside, all);
    }
    scatter(all.topRows(inside), front.closed, x);
}

/// Back substitution through some fronts, parents first.
void MultifrontalFactor::fill(
    const std::vector<std::int32_t>& numbers, const std::vector<Eigen::MatrixXd>& condensed, Eigen::MatrixXd& x) const
{
    for (auto number = numbers.rbegin(); number != numbers.rend(); ++number) {
        const Front& front = fronts_[static_cast<std::size_t>(*number)];
        if (!front.own.empty()) {
            Eigen::MatrixXd own = gathered(x, front.own);
            own -= product_transposed(front.L21, gathered(x, front.bound));
            backward(front.L11, own);
            scatter(own, front.own, x);
        }
        if (!front.closed.empty())
            fill_closed(front, condensed[static_cast<std::size_t>(*number)], x);
    }
}

/// Moves the rows of the vertices that some fronts eliminate into a field of their own.
Eigen::MatrixXd MultifrontalFactor::moved_apart(const std::vector<std::int32_t>& numbers, Eigen::MatrixXd& x) const
{
    Eigen::MatrixXd apart = Eigen::MatrixXd::Zero(x.rows(), x.cols());
    for (const std::int32_t number : numbers) {
        const Front& front = fronts_[static_cast<std::size_t>(number)];
        for (const auto* list : { &front.own, &front.closed })
            for (const VertexId v : *list) {
                apart.middleRows(3 * v, 3) = x.middleRows(3 * v, 3);
                x.middleRows(3 * v, 3).setZero();
            }
    }
    return apart;
}

Eigen::MatrixXd MultifrontalFactor::solve(const Eigen::MatrixXd& load) const
{
    RETRACTOR_ASSERT(touched_.empty());
    RETRACTOR_ASSERT(load.rows() == 3 * static_cast<Eigen::Index>(part_.size()));
    Eigen::MatrixXd x = load;
    std::vector<Eigen::MatrixXd> condensed(fronts_.size()); // of leaves with loads on closed vertices
    // Both groups subtract from the fronts above; the second group does so in a field of its own.
    Eigen::MatrixXd apart = moved_apart(below_[1], x);
    {
        const ScopedThread other([&] { reduce(below_[1], apart, condensed); });
        reduce(below_[0], x, condensed);
    }
    x += apart;
    reduce(above_, x, condensed);
    for (const VertexId v : held_)
        x.middleRows(3 * v, 3).setZero();
    fill(above_, condensed, x);
    const ScopedThread other([&] { fill(below_[1], condensed, x); });
    fill(below_[0], condensed, x);
    return x;
}

std::size_t MultifrontalFactor::bytes() const
{
    std::size_t sum = 0;
    for (const Front& front : fronts_)
        sum += static_cast<std::size_t>(front.L11.size() + front.L21.size() + front.update.size() + front.taken.size())
                * sizeof(double)
            + front.condensing.bytes();
    return sum;
}

} // namespace retractor::fem
