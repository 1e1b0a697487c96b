#include "fem/statics/opening.h"

#include "fem/element/strain_percentile.h"
#include "fem/model/floating_components.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/equilibrium.h"
#include "fem/statics/hooks_apart.h"
#include "fem/statics/largest_force_left.h"
#include "fem/statics/near_opening.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/statistics.h"

#include <algorithm>
#include <iomanip>
#include <sstream>
#include <utility>

namespace retractor::fem {

namespace {

    void check_tolerances(double tolerance, double energy_tolerance)
    {
        if (!(tolerance > 0.0 && tolerance < 1.0))
            throw InputError("the tolerance " + std::to_string(tolerance) + " is not between 0 and 1");
        if (!(energy_tolerance >= 0.0 && energy_tolerance < 1.0))
            throw InputError("the tolerance of the energy is not between 0 and 1");
    }

    void check_options(const OpeningOptions& options)
    {
        if (options.load_steps < 1 || options.max_newton_iterations < 1)
            throw InputError("opening needs at least one load step and one Newton iteration");
        check_tolerances(options.tolerance, options.energy_tolerance);
        if (!(options.far_tolerance >= 0.0))
            throw InputError(
                "the tolerance " + std::to_string(options.far_tolerance) + " is not zero or more", "condensed region");
        if (options.elasticity == Elasticity::corotational_linear)
            throw InputError("an opening is computed with linear, corotational or hyperelastic elasticity, not with "
                             "corotational_linear",
                "elasticity");
        if (options.near.empty())
            return;
        if (options.elasticity == Elasticity::linear)
            throw InputError("nothing is nonlinear near the wound when the elasticity is linear", "nonlinear region");
        if (options.contact || !options.blades.empty() || options.locking_free || !options.pressures.empty())
            throw InputError(std::string("a condensed region cannot be combined with ")
                    + (options.contact                ? "contact"
                            : !options.blades.empty() ? "blades in contact"
                            : options.locking_free    ? "locking-free elements"
                                                      : "pressure"),
                "nonlinear region");
    }

    /// 99th percentile by volume of the strain outside the elements that touch a hook patch or a blade.
    double strain_percentile(
        const ElasticBody& body, const ElasticBody::Deformation& d, const std::vector<int>& hook_of_node)
    {
        const mesh::TetMesh& mesh = body.mesh();
        const std::vector<TetId> covered
            = body.blades() != nullptr ? body.blades()->covered_elements() : std::vector<TetId>();
        std::vector<std::size_t> order;
        double total = 0.0;
        for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
            const auto nodes = mesh.tet(static_cast<TetId>(t));
            if (std::any_of(nodes.begin(), nodes.end(),
                    [&](VertexId v) { return hook_of_node[static_cast<std::size_t>(v)] >= 0; })
                || std::binary_search(covered.begin(), covered.end(), static_cast<TetId>(t)))
                continue;
            order.push_back(t);
            total += d.volume[t];
        }
        std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return d.strain[a] < d.strain[b]; });
        const auto at
            = weighted_percentile(order, kStrainPercentile, total, [&](std::size_t t) { return d.volume[t]; });
        return at == order.end() ? 0.0 : d.strain[*at];
    }

    /// Computes strain and volume ratios. @pre result.displacement is set
    void measure(const ElasticBody& body, const Prescribed& prescribed, OpeningResult& result)
    {
        const Eigen::VectorXd displacement
            = Eigen::Map<const Eigen::VectorXd>(result.displacement.data(), result.displacement.size());
        ElasticBody::Deformation d = body.deformation(displacement);
        result.strain_p99 = strain_percentile(body, d, prescribed.hook_of_node);
        result.max_volume_ratio = *std::max_element(d.largest_ratio.begin(), d.largest_ratio.end());
        result.min_volume_ratio = *std::min_element(d.smallest_ratio.begin(), d.smallest_ratio.end());
        for (std::size_t t = 0; t < d.smallest_ratio.size(); ++t)
            if (d.smallest_ratio[t] <= 0.0)
                result.inverted.push_back(static_cast<TetId>(t));
        result.inverted_elements = static_cast<int>(result.inverted.size());
        result.strain = std::move(d.strain);
        result.volume_ratio = std::move(d.volume_ratio);
        if (body.contact() != nullptr) {
            result.contact = body.contact()->state(displacement);
            result.contact_overlap_mm = body.contact()->overlap_at_rest();
        }
        if (body.blades() != nullptr)
            result.blades = body.blades()->bearing(displacement);
        if (result.inverted_elements == 0)
            return;
        result.message += "; " + std::to_string(result.inverted_elements)
            + " element(s) inside out: the results for the tissue near them are wrong";
        if (result.status == OpeningStatus::converged)
            result.status = OpeningStatus::inverted;
    }

    Eigen::VectorXd of_free_nodes(Eigen::VectorXd forces, const Prescribed& prescribed)
    {
        for (std::size_t i = 0; i < prescribed.flag.size(); ++i)
            if (prescribed.flag[i] != 0)
                forces[static_cast<Eigen::Index>(i)] = 0.0;
        return forces;
    }

    Eigen::VectorXd of_hook_nodes(Eigen::VectorXd forces, const Prescribed& prescribed)
    {
        for (std::size_t v = 0; v < prescribed.hook_of_node.size(); ++v)
            if (prescribed.hook_of_node[v] < 0)
                forces.segment<3>(3 * static_cast<Eigen::Index>(v)).setZero();
        return forces;
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
            text << "not converged: residual " << equilibrium.residual << " (limit " << tolerance << ") at "
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

    /// Message: the largest pressure that had an equilibrium, in the unit in which users set pressures.
    /// @param held share of the pressures and of the hooks' motion
    std::string no_rest_under(
        const std::vector<SurfacePressure>& pressures, double held, bool hooks, bool hooks_are_why)
    {
        std::ostringstream text;
        text << std::setprecision(4);
        for (const SurfacePressure& pressure : pressures)
            text << (hooks_are_why ? "; under p = " : "; no equilibrium at p = ") << pressure.pressure / kKiloPascal
                 << " kPa (" << pressure.name
                 << "), last load step that held: " << held * pressure.pressure / kKiloPascal << " kPa";
        text << (hooks ? "; the hooks had made the same share of their motion" : "");
        if (hooks_are_why)
            text << "; the tissue bears the pressure of the next step while the hooks stay in place, "
                    "but not the next step of the hooks";
        else
            text << "; tissue this soft bears less pressure, or needs a law that stiffens (fibres)";
        return text.str();
    }

    OpeningOptions with_loads_of(const ElasticProblem& problem, OpeningOptions options)
    {
        options.blades = problem.blades;
        if (problem.loads.empty() && problem.pressures.empty())
            return options;
        if (options.load.size() != 0 || !options.pressures.empty())
            throw InputError("there are loads in the problem and in the options", "load");
        options.load = std::move(external_loads(problem).nodal);
        options.pressures = problem.pressures;
        return options;
    }

} // namespace

struct Opening::State {
    mesh::TetMesh mesh;
    Supports supports;
    OpeningOptions options;
    std::vector<Material> materials; ///< by label
    std::unique_ptr<ElasticBody> body; ///< built by the first open()
    EquilibriumSolver solver;
    Eigen::VectorXd warm; ///< last converged displacement; empty: none

    void make_body(const Job& job);
    OpeningResult open_all(const Prescribed& prescribed, std::size_t hooks, const Job& job);
};

void Opening::State::make_body(const Job& job)
{
    const Stopwatch watch;
    body = std::make_unique<ElasticBody>(tissue_body(mesh, materials, { options.elasticity, options.locking_free }));
    set_springs(*body, supports);
    ExternalLoads loads { .nodal = options.load };
    for (const SurfacePressure& pressure : options.pressures)
        loads.pressures.emplace_back(mesh, pressure.faces, pressure.pressure);
    if (!loads.empty())
        body->set_loads(std::move(loads));
    if (options.contact) {
        Contact contact(mesh, element_parameters(mesh, materials), *options.contact);
        if (warm.size() != 0)
            contact.follow(warm);
        body->set_contact(std::move(contact));
    }
    if (!options.blades.empty())
        body->set_blades(BladeContact(mesh, options.blades));
    record_part(job, "solver", watch, body->bytes());
}

OpeningResult Opening::State::open_all(const Prescribed& prescribed, std::size_t hooks, const Job& job)
{
    const Eigen::VectorXd start = warm.size() != 0 ? warm : Eigen::VectorXd::Zero(prescribed.value.size());
    const EquilibriumOptions newton { .load_steps = options.load_steps,
        .max_newton_iterations = options.max_newton_iterations,
        .tolerance = options.tolerance,
        .energy_tolerance = options.energy_tolerance,
        .load_at_start = warm.size() != 0 ? 1.0 : 0.0 };
    const Equilibrium equilibrium = solver.solve(*body, prescribed.flag, prescribed.value, start, newton, job);
    OpeningResult result;
    copy_record(equilibrium, newton.tolerance, result);
    result.hook_forces_N = hook_forces(equilibrium.forces, prescribed, hooks);
    result.hook_nodal_forces_N = of_hook_nodes(equilibrium.forces, prescribed);
    result.displacement
        = Eigen::Map<const Points>(equilibrium.displacement.data(), equilibrium.displacement.size() / 3, 3);
    if (const double held = newton.load_at_start + equilibrium.load * (1.0 - newton.load_at_start);
        result.status == OpeningStatus::not_converged && equilibrium.none_found && held < 1.0
        && !options.pressures.empty())
        result.message += no_rest_under(options.pressures, held, hooks > 0, equilibrium.loads_rest_alone);
    if (result.status == OpeningStatus::not_converged)
        result.message += "; "
            + largest_force_left(
                mesh.vertices, equilibrium.displacement, of_free_nodes(equilibrium.forces, prescribed));
    measure(*body, prescribed, result);
    warm = result.status == OpeningStatus::converged ? equilibrium.displacement : Eigen::VectorXd();
    return result;
}

Opening::Opening(
    const mesh::TetMesh& mesh, std::span<const Material> material_of_label, Supports supports, OpeningOptions options)
    : state_(std::make_unique<State>())
{
    check_options(options);
    mesh::check_mesh(mesh);
    if (mesh.tet_count() == 0)
        throw InputError("the mesh has no elements");
    if (options.load.size() != 0 && (options.load.size() != 3 * mesh.vertices.rows() || !options.load.allFinite()))
        throw InputError("a load has three finite entries per node", "load");
    (void)prescribe(mesh, supports, {});
    (void)bed_stiffness(mesh, supports);
    check_hinges(mesh, supports.hinges);
    (void)element_parameters(mesh, material_of_label);
    state_->materials.assign(material_of_label.begin(), material_of_label.end());
    state_->mesh = mesh;
    state_->supports = std::move(supports);
    state_->options = std::move(options);
}

Opening::Opening(const ElasticProblem& problem, OpeningOptions options)
    : Opening(problem.mesh, problem.material_of_label, problem.supports, with_loads_of(problem, std::move(options)))
{
}

Opening::~Opening() = default;

void Opening::start_from(const Points& displacement)
{
    if (displacement.rows() != state_->mesh.vertices.rows() || !displacement.allFinite())
        throw InputError("a start has three finite entries per node", "start");
    state_->warm = Eigen::Map<const Eigen::VectorXd>(displacement.data(), displacement.size());
}

Eigen::MatrixXd Opening::stiffness(const Points& displacement, const Eigen::MatrixXd& motions)
{
    State& s = *state_;
    RETRACTOR_ASSERT(s.body && s.options.near.empty() && displacement.rows() == s.mesh.vertices.rows());
    return s.solver.response(
        *s.body, Eigen::Map<const Eigen::VectorXd>(displacement.data(), displacement.size()), motions);
}

void Opening::set_load_steps(int least)
{
    if (least < 1)
        throw InputError("opening needs at least one load step");
    state_->options.load_steps = least;
}

void Opening::set_tolerance(double tolerance, double energy_tolerance)
{
    check_tolerances(tolerance, energy_tolerance);
    state_->options.tolerance = tolerance;
    state_->options.energy_tolerance = energy_tolerance;
}

void Opening::stiffen(std::span<const TetId> elements, double factor)
{
    State& s = *state_;
    RETRACTOR_ASSERT(s.body && s.body->has_parts() && s.options.near.empty());
    s.body->stiffen(elements, factor);
}

OpeningResult Opening::open(std::span<const HookPatch> hooks, const Job& job)
{
    State& s = *state_;
    const Prescribed prescribed = prescribe(s.mesh, s.supports, hooks);
    if (!s.options.contact) // contact lets hooks meet and stops them there
        check_hooks_apart(s.mesh, hooks);
    std::vector<VertexId> held = prescribed.nodes;
    for (const BeddedVertex& bedded : s.supports.bedded)
        held.push_back(bedded.vertex);
    check_no_floating_component(s.mesh, held);
    if (!s.body)
        s.make_body(job);
    if (s.options.near.empty())
        return s.open_all(prescribed, hooks.size(), job);
    OpeningResult result = open_near(s.mesh, s.materials, s.supports, hooks, s.options, job);
    measure(*s.body, prescribed, result);
    return result;
}

} // namespace retractor::fem
