#include "fem/opening.h"

#include "fem/elastic_problem.h"
#include "fem/equilibrium.h"
#include "fem/held_pieces.h"
#include "fem/hooks_apart.h"
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

    void measure(const ElasticBody& body, const Equilibrium& equilibrium, const Prescribed& prescribed,
        std::size_t hooks, OpeningResult& result)
    {
        const TetMesh& mesh = body.mesh();
        result.displacement = Eigen::Map<const Points>(equilibrium.displacement.data(), mesh.vertices.rows(), 3);
        result.hook_forces_N = hook_forces(equilibrium.forces, prescribed, hooks);
        ElasticBody::Deformation d = body.deformation(equilibrium.displacement);
        result.strain_p99 = strain_percentile(mesh, d, prescribed.hook_of_node);
        result.max_volume_ratio = *std::max_element(d.largest_ratio.begin(), d.largest_ratio.end());
        result.min_volume_ratio = *std::min_element(d.smallest_ratio.begin(), d.smallest_ratio.end());
        result.inverted_elements = static_cast<int>(
            std::count_if(d.smallest_ratio.begin(), d.smallest_ratio.end(), [](double r) { return r <= 0.0; }));
        result.strain = std::move(d.strain);
        if (body.contact() != nullptr) {
            result.contact = body.contact()->state(equilibrium.displacement);
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

} // namespace

struct Opening::State {
    TetMesh mesh;
    Supports supports;
    OpeningOptions options;
    std::vector<Lame> lame;
    std::vector<double> bed;
    std::unique_ptr<ElasticBody> body; ///< built by the first open()
    EquilibriumSolver solver;
    Eigen::VectorXd warm; ///< the last converged state; empty: none
};

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
    state_->lame = element_parameters(mesh, material_of_label);
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
    const Stopwatch watch;
    if (!s.body) {
        s.body = std::make_unique<ElasticBody>(s.mesh, s.options.elasticity, s.lame);
        s.body->set_bed(s.bed);
        if (s.options.contact)
            s.body->set_contact(Contact(s.mesh, s.lame, *s.options.contact));
        record_part(job, "solver", watch, s.body->bytes());
    }
    const Eigen::VectorXd start = s.warm.size() != 0 ? s.warm : Eigen::VectorXd::Zero(prescribed.value.size());
    const EquilibriumOptions options { .load_steps = s.options.load_steps,
        .max_newton_iterations = s.options.max_newton_iterations,
        .tolerance = s.options.tolerance };
    const Equilibrium equilibrium = s.solver.solve(*s.body, prescribed.flag, prescribed.value, start, options, job);
    OpeningResult result;
    copy_record(equilibrium, options.tolerance, result);
    measure(*s.body, equilibrium, prescribed, hooks.size(), result);
    s.warm = result.status == OpeningStatus::converged ? equilibrium.displacement : Eigen::VectorXd();
    return result;
}

} // namespace retractor
