#include "fem/statics/nonlinear_region.h"

#include "fem/linear_algebra/norm.h"
#include "fem/model/floating_components.h"
#include "fem/statics/condensed_region.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/largest_force_left.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

namespace retractor::fem {

namespace {

    /// Some elements of a mesh with their nodes. The nodes of the rim come last; the other nodes keep the order of the
    /// mesh.
    struct Part {
        mesh::TetMesh mesh;
        std::vector<VertexId> vertex; ///< vertex of the whole mesh, per node of the part
        std::vector<VertexId> node; ///< node of the part, per vertex of the whole mesh, or -1
        std::vector<TetId> element; ///< element of the whole mesh, per element of the part
    };

    Part part_of(const mesh::TetMesh& mesh, const std::vector<std::uint8_t>& near, std::uint8_t which,
        const std::vector<VertexId>& rim)
    {
        Part part;
        part.node.assign(mesh.vertex_count(), -1);
        std::vector<std::uint8_t> used(mesh.vertex_count(), 0);
        part.mesh.nodes_per_tet = mesh.nodes_per_tet;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            if (near[static_cast<std::size_t>(t)] == which) {
                part.element.push_back(t);
                part.mesh.labels.push_back(mesh.labels[static_cast<std::size_t>(t)]);
                for (const VertexId v : mesh.tet(t))
                    used[static_cast<std::size_t>(v)] = 1;
            }
        for (const VertexId v : rim)
            used[static_cast<std::size_t>(v)] = 0;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (used[static_cast<std::size_t>(v)] != 0)
                part.vertex.push_back(v);
        part.vertex.insert(part.vertex.end(), rim.begin(), rim.end());
        part.mesh.vertices.resize(static_cast<Eigen::Index>(part.vertex.size()), 3);
        for (std::size_t i = 0; i < part.vertex.size(); ++i) {
            part.node[static_cast<std::size_t>(part.vertex[i])] = static_cast<VertexId>(i);
            part.mesh.vertices.row(static_cast<Eigen::Index>(i)) = mesh.vertices.row(part.vertex[i]);
        }
        for (const TetId t : part.element)
            for (const VertexId v : mesh.tet(t))
                part.mesh.nodes.push_back(part.node[static_cast<std::size_t>(v)]);
        return part;
    }

    /// Free vertices that have elements on both sides of the border.
    std::vector<VertexId> rim_of(
        const mesh::TetMesh& mesh, const std::vector<std::uint8_t>& near, const Prescribed& prescribed)
    {
        constexpr std::uint8_t kNear = 1, kFar = 2;
        std::vector<std::uint8_t> sides(mesh.vertex_count(), 0);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            for (const VertexId v : mesh.tet(t))
                sides[static_cast<std::size_t>(v)] |= near[static_cast<std::size_t>(t)] != 0 ? kNear : kFar;
        std::vector<VertexId> rim;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v) {
            const auto i = static_cast<std::size_t>(v);
            if (const int hook = prescribed.hook_of_node[i]; hook >= 0 && (sides[i] & kFar) != 0)
                throw InputError("a hook holds a node of an element that is not near", "vertex " + std::to_string(v));
            if (sides[i] == (kNear | kFar) && prescribed.flag[3 * i] == 0)
                rim.push_back(v);
        }
        return rim;
    }

    std::vector<std::uint8_t> fixed_nodes(const Part& part, const Prescribed& prescribed)
    {
        std::vector<std::uint8_t> fixed;
        for (const VertexId v : part.vertex)
            fixed.push_back(prescribed.flag[3 * static_cast<std::size_t>(v)]);
        return fixed;
    }

    /// The bed of this part. The bed of the rim belongs to the near part.
    std::vector<double> bed_of(const std::vector<double>& bed, const Part& part, std::size_t without_last)
    {
        std::vector<double> own;
        if (!bed.empty()) {
            for (const VertexId v : part.vertex)
                own.push_back(bed[static_cast<std::size_t>(v)]);
            std::fill(own.end() - static_cast<std::ptrdiff_t>(without_last), own.end(), 0.0);
        }
        return own;
    }

    /// The hinges of this part: the edges whose nodes share an element of the part.
    std::vector<Hinge> hinges_of(std::vector<Hinge> hinges, const Part& part)
    {
        for (Hinge& hinge : hinges)
            for (HingeEdge& edge : hinge.edges)
                edge = { part.node[static_cast<std::size_t>(edge.a)], part.node[static_cast<std::size_t>(edge.b)],
                    edge.share };
        return hinges_within(part.mesh, std::move(hinges));
    }

    /// The hinges of the far part. An edge between nodes of the rim belongs to the near part when both parts have it.
    std::vector<Hinge> far_hinges_of(
        std::vector<Hinge> hinges, const Part& far, const Part& near, const std::vector<Hinge>& near_hinges)
    {
        std::set<std::pair<VertexId, VertexId>> in_near;
        for (const Hinge& hinge : near_hinges)
            for (const HingeEdge& edge : hinge.edges)
                in_near.emplace(edge.a, edge.b);
        for (Hinge& hinge : hinges)
            std::erase_if(hinge.edges, [&](const HingeEdge& edge) {
                return in_near.contains(
                    { near.node[static_cast<std::size_t>(edge.a)], near.node[static_cast<std::size_t>(edge.b)] });
            });
        return hinges_of(std::move(hinges), far);
    }

    ExternalLoads loads_of(const Eigen::VectorXd& load, const Part& part, std::size_t vertices)
    {
        if (load.size() == 0)
            return {};
        if (load.size() != 3 * static_cast<Eigen::Index>(vertices))
            throw InputError("a load has three entries per vertex", "nonlinear region");
        ExternalLoads own { .nodal = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(part.vertex.size())) };
        for (VertexId v = 0; v < static_cast<VertexId>(vertices); ++v) {
            const auto force = load.segment<3>(3 * static_cast<Eigen::Index>(v));
            const VertexId node = part.node[static_cast<std::size_t>(v)];
            if (node >= 0)
                own.nodal.segment<3>(3 * static_cast<Eigen::Index>(node)) = force;
            else if (!force.isZero(0.0))
                throw InputError("a node that is not near is loaded", "vertex " + std::to_string(v));
        }
        return own;
    }

    Vec3 segment(const Eigen::VectorXd& x, VertexId v) { return x.segment<3>(3 * static_cast<Eigen::Index>(v)); }

} // namespace

std::vector<std::uint8_t> elements_near(const mesh::TetMesh& mesh, const Points& points, double distance)
{
    if (points.rows() == 0 || !points.allFinite() || !(distance > 0.0))
        throw InputError("elements are near some points, within a positive distance", "nonlinear region");
    std::vector<std::uint8_t> near_vertex(mesh.vertex_count(), 0), near(mesh.tet_count(), 0);
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
        near_vertex[static_cast<std::size_t>(v)]
            = (points.rowwise() - mesh.vertices.row(v)).rowwise().squaredNorm().minCoeff() <= distance * distance ? 1
                                                                                                                  : 0;
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
        for (const VertexId v : mesh.tet(t))
            near[static_cast<std::size_t>(t)] |= near_vertex[static_cast<std::size_t>(v)];
    return near;
}

struct NonlinearRegion::State {
    NonlinearRegionOptions options;
    std::size_t vertices = 0; ///< number of vertices of the whole mesh
    Part near, far;
    std::size_t rim = 0;
    std::vector<std::vector<VertexId>> hook_nodes; ///< nodes of each hook in the near part
    std::optional<ElasticBody> body;
    double largest_load = 0.0; ///< largest nodal load, N
    std::vector<std::uint8_t> far_fixed; ///< per node of the far part
    std::optional<CondensedRegion> beyond;
    std::vector<Material> materials; ///< indexed by label
    std::vector<double> far_bed; ///< per node of the far part, or empty
    std::vector<Hinge> far_hinges; ///< by nodes of the far part
    std::optional<ElasticBody> far_body; ///< the far part with its own law; made when first needed
    std::vector<std::uint8_t> fixed; ///< per node of the near part, with nodes of hooks included

    CondensingSystem system;
    SparseCholesky factor;
    Eigen::MatrixXd columns; ///< displacement of the near part per hook and axis, by the present factor
    Eigen::MatrixXd far_columns; ///< forces of the far part on the rim per hook and axis
    Eigen::MatrixXd hook_stiffness; ///< N/mm, three rows per hook

    struct Point {
        Eigen::VectorXd u; ///< three per node of the near part
        Eigen::VectorXd far_force; ///< forces of the far part on the rim
        double energy = 0.0;
        Eigen::VectorXd forces;
    } now;
    std::vector<Vec3> at; ///< displacement of the hooks, mm
    std::vector<HookDrive> drives;
    std::vector<bool> yielded; ///< per hook
    std::vector<FacingHooks> facing, meeting; ///< pairs of hooks that can meet, and pairs that meet now
    Eigen::VectorXd last_u, last_far_force; ///< state at the start of the last frame; empty: none
    std::vector<Vec3> last_at;
    struct Pair {
        Eigen::VectorXd s, y;
        double sy;
    };
    std::deque<Pair> pairs;
    double lift = 0.0; ///< share of the negative eigenvalues that was last removed from the element stiffness
    int iterations = 0, factorisations = 0;

    Eigen::Index rim_size() const { return 3 * static_cast<Eigen::Index>(rim); }

    Eigen::VectorXd far_forces(const Eigen::VectorXd& u) const
    {
        if (!beyond)
            return {};
        return beyond->stiffness().selfadjointView<Eigen::Lower>() * u.tail(rim_size());
    }

    Point point(Eigen::VectorXd u, Eigen::VectorXd far_force) const
    {
        Point p { std::move(u), std::move(far_force), 0.0, {} };
        ElasticBody::Response response = body->response(p.u);
        p.energy = response.energy;
        p.forces = std::move(response.forces);
        if (beyond) {
            p.energy += 0.5 * p.u.tail(rim_size()).dot(p.far_force);
            p.forces.tail(rim_size()) += p.far_force;
        }
        return p;
    }
    Point point(Eigen::VectorXd u) const
    {
        Eigen::VectorXd far_force = far_forces(u);
        return point(std::move(u), std::move(far_force));
    }

    Eigen::VectorXd unbalanced(const Point& p) const
    {
        RETRACTOR_ASSERT(p.forces.size() == 3 * static_cast<Eigen::Index>(fixed.size()));
        Eigen::VectorXd r = p.forces;
        for (std::size_t v = 0; v < fixed.size(); ++v)
            if (fixed[v] != 0)
                r.segment<3>(3 * static_cast<Eigen::Index>(v)).setZero();
        return r;
    }

    double residual() const
    {
        // Loads reduce the forces on supports. Where only far tissue supports the body, the load alone gives a scale.
        const double scale = std::max(largest_length(now.forces), largest_load);
        return scale > 0.0 ? largest_length(unbalanced(now)) / scale : 0.0;
    }

    /// Solves for right sides with three rows per node. Rows of nodes that are not free are ignored.
    Eigen::MatrixXd solve(const Eigen::MatrixXd& b)
    {
        RETRACTOR_ASSERT(factor.factorised() && b.rows() == 3 * static_cast<Eigen::Index>(fixed.size()));
        Eigen::MatrixXd packed(3 * static_cast<Eigen::Index>(system.free.size()), b.cols());
        for (std::size_t i = 0; i < system.free.size(); ++i)
            packed.middleRows<3>(3 * static_cast<Eigen::Index>(i))
                = b.middleRows<3>(3 * static_cast<Eigen::Index>(system.free[i]));
        const Eigen::MatrixXd solution = factor.solve(packed);
        Eigen::MatrixXd x = Eigen::MatrixXd::Zero(b.rows(), b.cols());
        for (std::size_t i = 0; i < system.free.size(); ++i)
            x.middleRows<3>(3 * static_cast<Eigen::Index>(system.free[i]))
                = solution.middleRows<3>(3 * static_cast<Eigen::Index>(i));
        return x;
    }

    void factorise(const BlockMatrix& K)
    {
        std::vector<double> values(system.source.size());
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = system.source[i] < 0 ? 0.0 : K.values[static_cast<std::size_t>(system.source[i])];
        const auto first = static_cast<std::int32_t>(3 * (system.free.size() - rim));
        if (beyond)
            for (std::int32_t column = first; column < system.pattern.size(); ++column) {
                const auto end
                    = static_cast<std::size_t>(system.pattern.column_start[static_cast<std::size_t>(column) + 1]);
                for (std::int32_t row = first; row <= column; ++row)
                    values[end - 1 - static_cast<std::size_t>(column - row)]
                        += beyond->stiffness()(row - first, column - first);
            }
        try {
            factor.factorise(values);
        } catch (const SolverError& error) {
            const std::int32_t unknown = factor.failed_unknown();
            if (unknown < 0)
                throw;
            const auto node = static_cast<std::size_t>(system.free[static_cast<std::size_t>(unknown / 3)]);
            throw SolverError(std::string("stiffness: ") + error.what(),
                "vertex " + std::to_string(near.vertex[node]) + ", axis " + "xyz"[unknown % 3]);
        }
        ++factorisations;
    }

    /// Factors the present stiffness with the smallest sufficient lift of negative eigenvalues. The search starts a
    /// little below the last lift.
    void refresh()
    {
        constexpr double kLeast = 1.0 / 64.0, kMore = 4.0;
        lift = lift > kLeast ? lift / kMore : 0.0;
        for (;; lift = std::min(1.0, std::max(kMore * lift, kLeast))) {
            const BlockMatrix& K = body->stiffness(now.u, lift);
            if (!factor.analysed()) {
                system = condensing_system(K.pattern, fixed, rim, true);
                factor.analyse_in_order(system.pattern, system.order);
            }
            try {
                factorise(K);
                break;
            } catch (const SolverError&) {
                if (lift == 1.0)
                    throw;
            }
        }
        pairs.clear();
        make_columns(body->last_stiffness());
    }

    void make_columns(const BlockMatrix& K)
    {
        const auto count = 3 * static_cast<Eigen::Index>(hook_nodes.size());
        Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(now.u.size(), count), load(now.u.size(), count);
        for (Eigen::Index c = 0; c < count; ++c) {
            for (const VertexId v : hook_nodes[static_cast<std::size_t>(c / 3)])
                moved(3 * static_cast<Eigen::Index>(v) + c % 3, c) = 1.0;
            load.col(c) = -K.multiply(moved.col(c));
        }
        columns = count > 0 ? Eigen::MatrixXd(moved + solve(load)) : moved;
        if (beyond)
            far_columns = beyond->stiffness().selfadjointView<Eigen::Lower>() * columns.bottomRows(rim_size());
        Eigen::MatrixXd forces(columns.rows(), count);
        for (Eigen::Index c = 0; c < count; ++c)
            forces.col(c) = K.multiply(columns.col(c));
        hook_stiffness = columns.transpose() * forces;
        if (beyond)
            hook_stiffness += columns.bottomRows(rim_size()).transpose() * far_columns;
        hook_stiffness = (0.5 * (hook_stiffness + hook_stiffness.transpose())).eval();
    }

    std::vector<Vec3> hook_forces() const
    {
        std::vector<Vec3> forces;
        for (const std::vector<VertexId>& nodes : hook_nodes) {
            Vec3 sum = Vec3::Zero();
            for (const VertexId v : nodes)
                sum += segment(now.forces, v);
            forces.push_back(sum);
        }
        return forces;
    }

    bool hooks_go_where_told() const
    {
        return std::all_of(drives.begin(), drives.end(), [](const HookDrive& drive) { return drive.prescribes(); });
    }

    void check_drives(std::span<const HookDrive> of_hooks) const
    {
        if (of_hooks.size() != at.size())
            throw InputError("there are " + std::to_string(at.size()) + " hooks", "nonlinear region");
        for (std::size_t h = 0; h < of_hooks.size(); ++h)
            check_drive(of_hooks[h], std::to_string(h));
    }

    /// Predicts the rest of the hooks from the present forces and stiffness.
    RestApart rest_with(const std::vector<HookDrive>& of_hooks) const
    {
        const Eigen::MatrixXd R = definite(hook_stiffness);
        return rest_of_hooks_apart(R, packed(hook_forces()) - R * packed(at), of_hooks, facing);
    }

    /// Places where the hooks rest. Also sets which hooks have yielded and which meet.
    std::vector<Vec3> where_hooks_rest()
    {
        RestApart apart = hooks_go_where_told() ? rest_of_hooks_apart({}, {}, drives, facing) : rest_with(drives);
        const HookRest& rest = apart.rest;
        if (!rest.converged)
            throw SolverError("no equilibrium of the hooks was found");
        meeting = std::move(apart.meeting);
        yielded = rest.yielded;
        std::vector<Vec3> where = per_hook(rest.displacement);
        double farthest = 0.0;
        for (std::size_t h = 0; h < at.size(); ++h)
            if (!drives[h].prescribes())
                farthest = std::max(farthest, (where[h] - at[h]).norm());
        constexpr double kFarthestMm = 10.0; // the stiffness predicts no farther
        for (std::size_t h = 0; h < at.size() && farthest > kFarthestMm; ++h)
            if (!drives[h].prescribes())
                where[h] = at[h] + kFarthestMm / farthest * (where[h] - at[h]);
        return where;
    }

    /// The L-BFGS direction from the stored pairs.
    Eigen::VectorXd direction(const Eigen::VectorXd& r)
    {
        Eigen::VectorXd q = -r;
        std::vector<double> alpha(pairs.size());
        for (std::size_t i = pairs.size(); i-- > 0;) {
            alpha[i] = pairs[i].s.dot(q) / pairs[i].sy;
            q -= alpha[i] * pairs[i].y;
        }
        Eigen::VectorXd d = solve(q);
        for (std::size_t i = 0; i < pairs.size(); ++i)
            d += (alpha[i] - pairs[i].y.dot(d) / pairs[i].sy) * pairs[i].s;
        return d;
    }

    /// Makes one quasi-Newton step. @return false when the energy falls along no known direction
    bool iterate()
    {
        constexpr double kArmijo = 1e-4, kShortest = 1e-3, kNoise = 1e-13;
        constexpr std::size_t kPairs = 12;
        for (;;) {
            const Eigen::VectorXd r = unbalanced(now);
            const Eigen::VectorXd d = direction(r);
            const double slope = r.dot(d);
            if (slope < 0.0) {
                const Eigen::VectorXd far_change = far_forces(d);
                for (double length = 1.0; length > kShortest; length *= 0.5) {
                    Eigen::VectorXd far_force;
                    if (beyond)
                        far_force = now.far_force + length * far_change;
                    Point there = point(now.u + length * d, std::move(far_force));
                    if (!(there.energy <= now.energy + kArmijo * length * slope + kNoise * std::abs(now.energy)))
                        continue;
                    Pair pair { length * d, unbalanced(there) - r, 0.0 };
                    pair.sy = pair.s.dot(pair.y);
                    now = std::move(there);
                    ++iterations;
                    // A smaller curvature cannot be distinguished from noise.
                    if (pair.sy > 1e-6 * length * -slope * length) {
                        pairs.push_back(std::move(pair));
                        if (pairs.size() > kPairs)
                            pairs.pop_front();
                    }
                    return true;
                }
            }
            if (pairs.empty())
                return false;
            pairs.clear();
        }
    }

    /// Moves the hooks by a share of `motion`; the tissue follows as predicted.
    /// @return false when no prediction has a finite energy
    bool move(const std::vector<Vec3>& motion, double share)
    {
        RETRACTOR_ASSERT(motion.size() == at.size());
        const Eigen::VectorXd step = share * packed(motion);
        struct Way {
            Eigen::VectorXd u, far_force;
        };
        std::vector<Way> ways;
        const auto follow = [&](const Eigen::VectorXd& hooks) {
            return Way { columns * hooks, beyond ? Eigen::VectorXd(far_columns * hooks) : Eigen::VectorXd() };
        };
        if (last_u.size() != 0) {
            const Eigen::VectorXd before = packed(at) - packed(last_at);
            const double squared = before.squaredNorm();
            if (const double ratio = squared > 0.0 ? std::clamp(step.dot(before) / squared, 0.0, 2.0) : 0.0;
                ratio > 0.0) {
                Way on = follow(step - ratio * before);
                on.u += ratio * (now.u - last_u);
                if (beyond)
                    on.far_force += ratio * (now.far_force - last_far_force);
                ways.push_back(std::move(on));
            }
        }
        ways.push_back(follow(step));
        std::optional<Point> best; // the prediction with the lowest energy; a frame far from rest predicts badly
        for (const Way& way : ways) {
            Point there
                = point(now.u + way.u, beyond ? Eigen::VectorXd(now.far_force + way.far_force) : Eigen::VectorXd());
            if (std::isfinite(there.energy) && !(best && best->energy <= there.energy))
                best = std::move(there);
        }
        if (!best)
            return false;
        now = std::move(*best);
        for (std::size_t h = 0; h < at.size(); ++h)
            at[h] += share * motion[h];
        return true;
    }

    /// Moves the hooks towards `target`, with the quasi-Newton steps of a frame. @return whether the hooks have arrived
    bool draw_to(const std::vector<Vec3>& target)
    {
        RETRACTOR_ASSERT(target.size() == at.size());
        constexpr int kParts = 4; // most parts of a motion that cannot be made at once; bounds the work of a frame
        constexpr double kSmallest = 1.0 / 16.0;
        for (int part = 0; part < kParts; ++part) {
            std::vector<Vec3> motion;
            for (std::size_t h = 0; h < at.size(); ++h)
                motion.push_back(target[h] - at[h]);
            double share = 1.0;
            while (share >= kSmallest && !move(motion, share))
                share *= 0.5;
            for (int i = 0; i < options.frame_iterations && iterate(); ++i) { }
            if (share == 1.0) {
                at = target;
                return true;
            }
        }
        return false;
    }

    /// The displacement of the whole mesh from the displacements of both parts.
    Eigen::VectorXd whole_field(const Eigen::VectorXd& far_u, const Eigen::VectorXd& near_u) const
    {
        Eigen::VectorXd whole = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(vertices));
        const auto put = [&](const Part& part, const Eigen::VectorXd& u) {
            for (std::size_t i = 0; i < part.vertex.size(); ++i)
                whole.segment<3>(3 * static_cast<Eigen::Index>(part.vertex[i])) = segment(u, static_cast<VertexId>(i));
        };
        if (beyond)
            put(far, far_u);
        put(near, near_u);
        return whole;
    }

    FarChange far_change()
    {
        FarChange change { .hook_forces_N = std::vector<Vec3>(hook_nodes.size(), Vec3::Zero()) };
        Eigen::VectorXd r = Eigen::VectorXd::Zero(now.u.size());
        std::optional<CondensedRegion::Reduced> left;
        if (beyond) {
            if (!far_body) {
                far_body.emplace(tissue_body(far.mesh, materials, { options.elasticity }));
                far_body->set_bed(far_bed);
                far_body->set_hinges(far_hinges);
            }
            ElasticBody::Response response = far_body->response(beyond->field(now.u.tail(rim_size())));
            change.finite = std::isfinite(response.energy);
            if (!change.finite)
                return change;
            response.forces.tail(rim_size()) -= now.far_force;
            left = beyond->reduce(-response.forces);
            r.tail(rim_size()) = -left->on_rim;
        }
        const Eigen::VectorXd step = -solve(r);
        change.displacement = whole_field(left ? beyond->field(step.tail(rim_size()), *left) : Eigen::VectorXd(), step);
        // By Betti's theorem the hooks bear a force on a free node in proportion to the node's displacement per hook.
        const Eigen::VectorXd borne = columns.transpose() * r;
        for (std::size_t h = 0; h < hook_nodes.size(); ++h)
            change.hook_forces_N[h] = segment(borne, static_cast<VertexId>(h));
        return change;
    }

    /// Iterates to equilibrium while the hooks stand still.
    NearStatus come_to_rest(const Job& job)
    {
        constexpr int kWorthAFactor = 30; // iterations that cost as much as a factor
        constexpr std::size_t kSeen = 5; // residuals from which the rate is estimated
        std::vector<double> seen;
        bool fresh = false;
        for (int i = 0; i <= options.max_iterations; ++i) {
            const double off = residual();
            if (off <= options.tolerance)
                return NearStatus::settled;
            if (job.cancelled())
                return NearStatus::cancelled;
            seen.push_back(off);
            bool slow = false;
            if (seen.size() > kSeen) {
                const double rate = std::pow(off / seen[seen.size() - 1 - kSeen], 1.0 / static_cast<double>(kSeen));
                slow = rate >= 1.0 || std::log(options.tolerance / off) / std::log(rate) > kWorthAFactor;
            }
            if (slow || !iterate()) {
                if (fresh && !slow)
                    return NearStatus::not_settled; // no descent even with the factor of this state
                refresh();
                seen.clear();
                fresh = true;
                if (!iterate())
                    return NearStatus::not_settled;
                continue;
            }
            fresh = false;
        }
        return NearStatus::not_settled;
    }

    NearFrame frame(int iterations_before, int factorisations_before)
    {
        NearFrame f;
        f.residual = residual();
        f.iterations = iterations - iterations_before;
        f.factorisations = factorisations - factorisations_before;
        f.hook_displacements = at;
        f.hook_forces_N = hook_forces();
        f.hook_yielded = yielded;
        f.meeting = meeting;
        f.displacement = whole_field(beyond ? beyond->field(now.u.tail(rim_size())) : Eigen::VectorXd(), now.u);
        return f;
    }
};

NonlinearRegion::NonlinearRegion(const mesh::TetMesh& mesh, std::span<const Material> material_of_label,
    const Supports& supports, std::vector<HookPatch> hooks, const std::vector<std::uint8_t>& near,
    NonlinearRegionOptions options)
    : state_(std::make_unique<State>())
{
    State& s = *state_;
    if (options.elasticity == Elasticity::linear)
        throw InputError(
            "the nonlinear region is nonlinear: hyperelastic, corotational or corotational_linear", "nonlinear region");
    if (options.frame_iterations < 1 || options.max_iterations < 1
        || !(options.tolerance > 0.0 && options.tolerance < 1.0))
        throw InputError("a frame takes at least one step, and the tolerance lies between 0 and 1", "nonlinear region");
    for (HookPatch& hook : hooks)
        hook.displacement.setZero();
    check_problem({ mesh, { material_of_label.begin(), material_of_label.end() }, supports, hooks });
    if (near.size() != mesh.tet_count())
        throw InputError("a nonlinear region needs a flag for each element", "nonlinear region");
    if (std::find(near.begin(), near.end(), std::uint8_t { 1 }) == near.end())
        throw InputError("no element is near", "nonlinear region");
    s.options = options;
    s.options.load.resize(0);
    s.vertices = mesh.vertex_count();
    const Prescribed prescribed = prescribe(mesh, supports, hooks);
    std::vector<VertexId> held = prescribed.nodes;
    for (const BeddedVertex& bedded : supports.bedded)
        held.push_back(bedded.vertex);
    check_no_floating_component(mesh, held);
    const std::vector<double> bed = bed_stiffness(mesh, supports);
    const std::vector<VertexId> rim = rim_of(mesh, near, prescribed);
    s.rim = rim.size();
    s.near = part_of(mesh, near, 1, rim);
    s.body.emplace(tissue_body(s.near.mesh, material_of_label, { options.elasticity }));
    s.body->set_bed(bed_of(bed, s.near, 0));
    const std::vector<Hinge> near_hinges = hinges_of(supports.hinges, s.near);
    s.body->set_hinges(near_hinges);
    s.body->set_loads(loads_of(options.load, s.near, s.vertices));
    s.largest_load = largest_length(options.load);
    s.fixed = fixed_nodes(s.near, prescribed);
    s.far = part_of(mesh, near, 0, rim);
    if (!rim.empty()) {
        s.materials.assign(material_of_label.begin(), material_of_label.end());
        s.far_bed = bed_of(bed, s.far, s.rim);
        s.far_hinges = far_hinges_of(supports.hinges, s.far, s.near, near_hinges);
        s.far_fixed = fixed_nodes(s.far, prescribed);
    }
    for (const HookPatch& hook : hooks) {
        std::vector<VertexId> nodes;
        for (const VertexId v : hook.nodes)
            if (prescribed.hook_of_node[static_cast<std::size_t>(v)]
                == static_cast<int>(s.hook_nodes.size())) // a node of two hooks belongs to the first
                nodes.push_back(s.near.node[static_cast<std::size_t>(v)]);
        s.hook_nodes.push_back(std::move(nodes));
    }
    s.at.assign(hooks.size(), Vec3::Zero());
    s.drives.assign(hooks.size(), {});
    s.yielded.assign(hooks.size(), false);
    s.facing = facing_hooks(mesh, hooks);
}

NonlinearRegion::~NonlinearRegion() = default;
NonlinearRegion::NonlinearRegion(NonlinearRegion&&) noexcept = default;

bool NonlinearRegion::prepare(const Job& job)
{
    State& s = *state_;
    if (s.factor.factorised())
        return true;
    if (job.cancelled())
        return false;
    if (s.rim > 0 && !s.beyond) {
        ElasticBody far = tissue_body(s.far.mesh, s.materials, { s.options.elasticity });
        far.set_bed(s.far_bed);
        far.set_hinges(s.far_hinges);
        s.beyond.emplace(far, s.far_fixed, s.rim);
    }
    if (job.cancelled())
        return false;
    if (s.now.u.size() == 0)
        s.now = s.point(Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(s.near.vertex.size())));
    s.refresh();
    return true;
}

void NonlinearRegion::start_from(const NearFrame& frame)
{
    (void)prepare();
    State& s = *state_;
    if (frame.displacement.size() != 3 * static_cast<Eigen::Index>(s.vertices)
        || frame.hook_displacements.size() != s.at.size() || !frame.displacement.allFinite())
        throw InputError("the start solution belongs to another mesh, or is not finite", "nonlinear region");
    Eigen::VectorXd u = Eigen::VectorXd::Zero(s.now.u.size());
    for (std::size_t i = 0; i < s.near.vertex.size(); ++i)
        u.segment<3>(3 * static_cast<Eigen::Index>(i)) = segment(frame.displacement, s.near.vertex[i]);
    State::Point there = s.point(std::move(u));
    if (!std::isfinite(there.energy))
        throw InputError("the start solution turns an element over", "nonlinear region");
    s.now = std::move(there);
    s.at = frame.hook_displacements;
    s.drives = prescribed_drives(s.at);
    s.last_u.resize(0);
    s.refresh();
}

NearFrame NonlinearRegion::drag(std::span<const Vec3> hook_displacements)
{
    return drag(prescribed_drives(hook_displacements));
}

NearFrame NonlinearRegion::drag(std::span<const HookDrive> drives)
{
    State& s = *state_;
    s.check_drives(drives);
    (void)prepare();
    const int iterations = s.iterations, factorisations = s.factorisations;
    const Eigen::VectorXd begin = s.now.u, begin_far_force = s.now.far_force;
    const std::vector<Vec3> begin_at = s.at;
    s.drives.assign(drives.begin(), drives.end());
    const bool reached = s.draw_to(s.where_hooks_rest());
    s.last_u = begin;
    s.last_far_force = begin_far_force;
    s.last_at = begin_at;
    NearFrame frame = s.frame(iterations, factorisations);
    frame.reached = reached;
    if (!reached)
        frame.message = "the hooks stop short of where elements would turn over";
    return frame;
}

NearFrame NonlinearRegion::settle(const Job& job)
{
    (void)prepare();
    State& s = *state_;
    const int iterations = s.iterations, factorisations = s.factorisations;
    NearStatus status = s.come_to_rest(job);
    // Hooks that do not prescribe their displacement are moved until they stay where they are.
    constexpr int kRounds = 60, kWorthAFactor = 8;
    for (int round = 1; status == NearStatus::settled && !s.hooks_go_where_told(); ++round) {
        const std::vector<Vec3> target = s.where_hooks_rest();
        double shift = 0.0, farthest = 0.0;
        for (std::size_t h = 0; h < target.size(); ++h) {
            shift = std::max(shift, (target[h] - s.at[h]).norm());
            farthest = std::max({ farthest, s.drives[h].displacement.norm(), s.at[h].norm(), target[h].norm() });
        }
        if (shift <= s.options.tolerance * farthest)
            break;
        if (round % kWorthAFactor == 0)
            s.refresh();
        s.last_u.resize(0);
        if (round > kRounds || !s.draw_to(target))
            status = NearStatus::not_settled;
        else
            status = s.come_to_rest(job);
    }
    s.last_u.resize(0);
    NearFrame frame = s.frame(iterations, factorisations);
    frame.status = status;
    std::ostringstream text;
    text << (status == NearStatus::settled    ? "settled"
            : status == NearStatus::cancelled ? "cancelled"
                                              : "not settled")
         << ": residual " << frame.residual << " after " << frame.iterations << " step(s) and " << frame.factorisations
         << " factorisation(s)";
    if (status == NearStatus::not_settled)
        text << "; " << largest_force_left(s.near.mesh.vertices, s.now.u, s.unbalanced(s.now));
    frame.message = text.str();
    return frame;
}

std::vector<Vec3> NonlinearRegion::predict_hook_displacements(std::span<const HookDrive> drives)
{
    State& s = *state_;
    s.check_drives(drives);
    (void)prepare();
    return per_hook(s.rest_with({ drives.begin(), drives.end() }).rest.displacement);
}

void NonlinearRegion::refresh()
{
    if (state_->factor.factorised())
        state_->refresh();
    else
        (void)prepare();
}

double relative_change(const FarChange& change, const NearFrame& frame)
{
    const auto largest = [](const std::vector<Vec3>& vectors) {
        double most = 0.0;
        for (const Vec3& v : vectors)
            most = std::max(most, v.norm());
        return most;
    };
    if (!change.finite)
        return std::numeric_limits<double>::infinity();
    const double way = frame.displacement.norm(), force = largest(frame.hook_forces_N);
    return std::max(
        way > 0.0 ? change.displacement.norm() / way : 0.0, force > 0.0 ? largest(change.hook_forces_N) / force : 0.0);
}

FarChange NonlinearRegion::far_change()
{
    (void)prepare();
    return state_->far_change();
}

std::size_t NonlinearRegion::near_elements() const { return state_->near.element.size(); }
std::size_t NonlinearRegion::rim_vertices() const { return state_->rim; }

std::size_t NonlinearRegion::bytes() const
{
    const State& s = *state_;
    return s.factor.bytes() + s.body->bytes() + (s.beyond ? s.beyond->bytes() : 0)
        + static_cast<std::size_t>(s.columns.size()) * sizeof(double)
        + (s.system.source.size() + s.system.pattern.row.size()) * sizeof(std::int32_t)
        + s.pairs.size() * 2 * static_cast<std::size_t>(s.now.u.size()) * sizeof(double);
}

} // namespace retractor::fem
