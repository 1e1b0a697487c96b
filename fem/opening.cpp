#include "fem/opening.h"

#include "fem/elastic_problem.h"
#include "fem/equilibrium.h"
#include "fem/held_pieces.h"
#include "fem/hooks_apart.h"
#include "fem/near_field.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <sstream>
#include <utility>

namespace retractor {

namespace {

    constexpr double kPercentile = 0.99;

    void check_options(const OpeningOptions& options)
    {
        if (options.load_steps < 1 || options.max_newton_iterations < 1)
            throw InputError("opening needs at least one load step and one Newton iteration");
        if (!(options.tolerance > 0.0 && options.tolerance < 1.0))
            throw InputError("the tolerance " + std::to_string(options.tolerance) + " is not between 0 and 1");
        if (options.elasticity == Elasticity::bounded)
            throw InputError(
                "bounded elasticity is for tissue under the hand (near_field.h), not for wounds at rest", "elasticity");
        if (options.near.empty())
            return;
        if (options.elasticity == Elasticity::linear)
            throw InputError("nothing is nonlinear near the wound when the elasticity is linear", "near field");
        if (options.contact || options.locking_free)
            throw InputError(std::string("a linear far field goes without ")
                    + (options.contact ? "contact" : "locking-free elements"),
                "near field");
    }

    /// 99th percentile by volume of the strain outside the elements that touch a hook patch.
    double strain_percentile(
        const TetMesh& mesh, const ElasticBody::Deformation& d, const std::vector<int>& hook_of_node)
    {
        std::vector<std::size_t> order;
        double total = 0.0;
        for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
            const auto nodes = mesh.tet(static_cast<TetId>(t));
            if (std::any_of(nodes.begin(), nodes.end(),
                    [&](VertexId v) { return hook_of_node[static_cast<std::size_t>(v)] >= 0; }))
                continue;
            order.push_back(t);
            total += d.volume[t];
        }
        std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return d.strain[a] < d.strain[b]; });
        double below = 0.0;
        for (const std::size_t t : order)
            if ((below += d.volume[t]) >= kPercentile * total)
                return d.strain[t];
        return 0.0;
    }

    void measure(const ElasticBody& body, const Eigen::VectorXd& displacement, const Prescribed& prescribed,
        OpeningResult& result)
    {
        const TetMesh& mesh = body.mesh();
        result.displacement = Eigen::Map<const Points>(displacement.data(), mesh.vertices.rows(), 3);
        ElasticBody::Deformation d = body.deformation(displacement);
        result.strain_p99 = strain_percentile(mesh, d, prescribed.hook_of_node);
        result.max_volume_ratio = *std::max_element(d.largest_ratio.begin(), d.largest_ratio.end());
        result.min_volume_ratio = *std::min_element(d.smallest_ratio.begin(), d.smallest_ratio.end());
        result.inverted_elements = static_cast<int>(
            std::count_if(d.smallest_ratio.begin(), d.smallest_ratio.end(), [](double r) { return r <= 0.0; }));
        result.strain = std::move(d.strain);
        if (body.contact() != nullptr) {
            result.contact = body.contact()->state(displacement);
            result.contact_overlap_mm = body.contact()->overlap_at_rest();
        }
        if (result.inverted_elements == 0)
            return;
        result.message += "; " + std::to_string(result.inverted_elements)
            + " element(s) inside out: what is said of the tissue near them is wrong";
        if (result.status == OpeningStatus::converged)
            result.status = OpeningStatus::inverted;
    }

    void copy_record(const Equilibrium& equilibrium, double tolerance, OpeningResult& result)
    {
        result.residual = equilibrium.residual;
        result.newton_iterations = equilibrium.newton_iterations;
        result.assemble_seconds = equilibrium.assemble_seconds;
        result.factor_seconds = equilibrium.factor_seconds;
        result.solve_seconds = equilibrium.solve_seconds;
        std::ostringstream text;
        switch (equilibrium.status) {
        case EquilibriumStatus::converged:
            result.status = OpeningStatus::converged;
            text << "converged: residual " << equilibrium.residual << ", ";
            break;
        case EquilibriumStatus::not_converged:
            result.status = OpeningStatus::not_converged;
            text << "not converged: residual " << equilibrium.residual << " (asked for " << tolerance << ") at "
                 << 100.0 * equilibrium.load << " % of the hooks' displacement, ";
            break;
        case EquilibriumStatus::cancelled:
            result.status = OpeningStatus::cancelled;
            text << "cancelled at " << 100.0 * equilibrium.load << " % of the hooks' displacement, ";
            break;
        }
        text << equilibrium.newton_iterations << " Newton step(s), " << equilibrium.factorisations
             << " factorisation(s), " << equilibrium.solver_iterations << " iteration(s) with an older factor";
        if (!equilibrium.message.empty())
            text << "; " << equilibrium.message;
        result.message = text.str();
    }

    /// The hooks go step by step; a new factor is made where the one at hand leads the tissue too far off.
    NearFrame drag_in_steps(
        NearField& field, std::span<const HookPatch> hooks, const OpeningOptions& options, const Job& job)
    {
        constexpr double kLoadStep = 3.0; // mm, as EquilibriumOptions has it
        constexpr double kFarOff = 0.05; // residual: as for states on the way in equilibrium.cpp
        double farthest = 0.0;
        for (const HookPatch& hook : hooks)
            farthest = std::max(farthest, hook.displacement.norm());
        const int steps = std::max(options.load_steps, static_cast<int>(std::ceil(farthest / kLoadStep)));
        NearFrame frame;
        std::vector<Vec3> target(hooks.size());
        for (int step = 1; step <= steps; ++step) {
            for (std::size_t h = 0; h < hooks.size(); ++h)
                target[h] = hooks[h].displacement * step / steps;
            frame = field.drag(target);
            for (int again = 0; again < 3 && (!frame.reached || frame.residual > kFarOff); ++again) {
                if (job.cancelled())
                    break;
                field.refresh();
                frame = field.drag(target);
            }
            job.report("opening", static_cast<double>(step) / (steps + 1));
            if (job.cancelled() || !frame.reached)
                return frame;
        }
        return frame;
    }

    /// @param cancelled while the hooks were on their way: at rest or not, they are not where they should be.
    void copy_record(const NearFrame& dragged, const NearFrame& settled, bool cancelled, OpeningResult& result)
    {
        result.hook_forces_N = settled.hook_forces_N;
        result.residual = settled.residual;
        result.newton_iterations = settled.iterations;
        result.message = settled.message;
        result.status = settled.status == NearStatus::settled ? OpeningStatus::converged
            : settled.status == NearStatus::cancelled         ? OpeningStatus::cancelled
                                                              : OpeningStatus::not_converged;
        if (cancelled) {
            result.status = OpeningStatus::cancelled;
            result.message = "cancelled while the hooks moved; there " + result.message;
        } else if (!dragged.reached) {
            if (result.status == OpeningStatus::converged)
                result.status = OpeningStatus::not_converged;
            result.message = dragged.message + "; there " + result.message;
        }
    }

} // namespace

struct Opening::State {
    TetMesh mesh;
    Supports supports;
    OpeningOptions options;
    std::vector<Material> materials; ///< by label
    std::vector<double> bed;
    std::unique_ptr<ElasticBody> body; ///< built by the first open()
    EquilibriumSolver solver;
    Eigen::VectorXd warm; ///< the last converged state; empty: none

    void make_body(const Job& job);
    OpeningResult open_all(const Prescribed& prescribed, std::size_t hooks, const Job& job);
    OpeningResult open_near(const Prescribed& prescribed, std::span<const HookPatch> hooks, const Job& job);
};

void Opening::State::make_body(const Job& job)
{
    const Stopwatch watch;
    body = std::make_unique<ElasticBody>(tissue_body(mesh, materials, { options.elasticity, options.locking_free }));
    body->set_bed(bed);
    if (options.contact)
        body->set_contact(Contact(mesh, element_parameters(mesh, materials), *options.contact));
    record_part(job, "solver", watch, body->bytes());
}

OpeningResult Opening::State::open_all(const Prescribed& prescribed, std::size_t hooks, const Job& job)
{
    const Eigen::VectorXd start = warm.size() != 0 ? warm : Eigen::VectorXd::Zero(prescribed.value.size());
    const EquilibriumOptions newton { .load_steps = options.load_steps,
        .max_newton_iterations = options.max_newton_iterations,
        .tolerance = options.tolerance };
    const Equilibrium equilibrium = solver.solve(*body, prescribed.flag, prescribed.value, start, newton, job);
    OpeningResult result;
    copy_record(equilibrium, newton.tolerance, result);
    result.hook_forces_N = hook_forces(equilibrium.forces, prescribed, hooks);
    measure(*body, equilibrium.displacement, prescribed, result);
    warm = result.status == OpeningStatus::converged ? equilibrium.displacement : Eigen::VectorXd();
    return result;
}

OpeningResult Opening::State::open_near(const Prescribed& prescribed, std::span<const HookPatch> hooks, const Job& job)
{
    constexpr int kQuasiNewtonSteps = 10; // as opening.h says
    const Stopwatch watch;
    NearField field(mesh, materials, supports, { hooks.begin(), hooks.end() }, options.near,
        { .elasticity = options.elasticity,
            .tolerance = options.tolerance,
            .max_iterations = kQuasiNewtonSteps * options.max_newton_iterations });
    record_part(job, "near field", watch, field.bytes());
    OpeningResult result;
    result.factor_seconds = watch.seconds();
    const NearFrame dragged = drag_in_steps(field, hooks, options, job);
    const bool cancelled = job.cancelled();
    const NearFrame settled = field.settle(job);
    copy_record(dragged, settled, cancelled, result);
    measure(*body, settled.displacement, prescribed, result);
    result.solve_seconds = watch.seconds() - result.factor_seconds;
    return result;
}

Opening::Opening(
    const TetMesh& mesh, std::span<const Material> material_of_label, Supports supports, OpeningOptions options)
    : state_(std::make_unique<State>())
{
    check_options(options);
    check_mesh(mesh);
    if (mesh.tet_count() == 0)
        throw InputError("the mesh has no elements");
    (void)prescribe(mesh, supports, {});
    state_->bed = bed_stiffness(mesh, supports);
    (void)element_parameters(mesh, material_of_label);
    state_->materials.assign(material_of_label.begin(), material_of_label.end());
    state_->mesh = mesh;
    state_->supports = std::move(supports);
    state_->options = options;
}

Opening::~Opening() = default;
Opening::Opening(Opening&&) noexcept = default;

OpeningResult Opening::open(std::span<const HookPatch> hooks, const Job& job)
{
    State& s = *state_;
    const Prescribed prescribed = prescribe(s.mesh, s.supports, hooks);
    if (!s.options.contact) // else it lets them meet and go no farther
        check_hooks_apart(s.mesh, hooks);
    std::vector<VertexId> held = prescribed.nodes;
    for (const BeddedVertex& bedded : s.supports.bedded)
        held.push_back(bedded.vertex);
    check_pieces_held(s.mesh, held);
    if (!s.body)
        s.make_body(job);
    return s.options.near.empty() ? s.open_all(prescribed, hooks.size(), job) : s.open_near(prescribed, hooks, job);
}

} // namespace retractor
