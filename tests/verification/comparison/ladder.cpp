// Which solver? One opened incision by every solver against the finest answer.

#include "tests/verification/comparison/solver_problems.h"

#include "fem/springs/edge_springs.h"
#include "fem/springs/spring_relaxation.h"
#include "mesh/base/error.h"
#include "tests/verification/framework/incision.h"
#include "tests/verification/framework/meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace retractor::verification {

namespace {

    const fem::Material kFat { "fat", 0.01, 0.49, 0.92e-9, "verification" };
    const Vec3 kPull(0.0, 4.0, 1.0);

    /// Displacements by position and side of the cut, so that meshes can be compared.
    using Place = std::array<long, 4>;
    using Field = std::map<Place, Vec3>;

    /// Compares at the vertices of the coarsest mesh only.
    Field field_of(const IncisedBlock& block, double coarsest, const mesh::TetMesh& mesh, const Eigen::VectorXd& u)
    {
        Field field;
        const std::vector<int> side = sides_of_cut(block, mesh);
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v) {
            const Vec3 at = mesh.vertices.row(v).transpose() / coarsest;
            const Vec3 grid = at.array().round();
            if ((at - grid).cwiseAbs().maxCoeff() < 1e-6)
                field[{ std::lround(grid.x()), std::lround(grid.y()), std::lround(grid.z()),
                    side[static_cast<std::size_t>(v)] }]
                    = u.segment<3>(3 * v);
        }
        return field;
    }

    /// Root mean square of the difference, relative to the largest displacement.
    double difference(const Field& field, const Field& reference)
    {
        double sum = 0.0, largest = 0.0;
        std::size_t count = 0;
        for (const auto& [place, u] : reference)
            if (const auto at = field.find(place); at != field.end()) {
                sum += (at->second - u).squaredNorm();
                largest = std::max(largest, u.norm());
                ++count;
            }
        if (count < reference.size())
            throw SolverError("the meshes of the ladder do not have their vertices in common");
        return std::sqrt(sum / static_cast<double>(count)) / largest;
    }

    struct Rung {
        std::string law; ///< "springs", "linear", "corotational", "neo-Hookean"
        VerificationElement element;
        std::vector<double> cells; ///< mm, coarse to fine
    };

    /// The answers are compared at the vertices of the coarsest cells.
    constexpr double kCoarse = 5.0;

    IncisedBlock ladder_block(double cell)
    {
        return { .size = { 40.0, 30.0, 15.0 },
            .cell = cell,
            .length = 20.0,
            .depth = 10.0,
            .hook_width = 10.0,
            .hook_height = 5.0 };
    }

    VerificationLaw law_of(const std::string& name)
    {
        const fem::Lame l = fem::lame(kFat);
        if (name == "linear")
            return { name, fem::Elasticity::linear, l, {}, {} };
        if (name == "corotational")
            return { name, fem::Elasticity::corotational, l, {}, {} };
        return hyperelastic_law(name, fem::NeoHookean { l.mu, l.lambda });
    }

    struct Answer {
        VerificationRow row;
        Field field;
    };

    Answer solve_elements(const Rung& rung, double cell, const Job& job)
    {
        const IncisedBlock block = ladder_block(cell);
        const fem::ElasticProblem problem = hooked_open(
            block, incise(uncut_block(block), incision_blade(block)), kFat, kPull, nodes_per_tet(rung.element));
        const fem::Prescribed held = fem::prescribe(problem.mesh, problem.supports, problem.hooks);
        const VerificationLaw law = law_of(rung.law);
        const Stopwatch watch;
        fem::ElasticBody body = make_body(problem.mesh, rung.element, law);
        const VerificationSolve solve = solve_problem(body, held.flag, held.value, { .load_steps = 2 }, job);
        Answer answer { make_row("solver ladder", rung.element, law, problem.mesh, solve), {} };
        answer.row.seconds = watch.seconds();
        answer.field = field_of(block, kCoarse, problem.mesh, solve.equilibrium.displacement);
        return answer;
    }

    Answer solve_springs(double cell, const Job& job)
    {
        const IncisedBlock block = ladder_block(cell);
        const fem::ElasticProblem problem
            = hooked_open(block, incise(uncut_block(block), incision_blade(block)), kFat, kPull);
        const Stopwatch watch;
        constexpr int kSteps = 4, kPlenty = 100000; // iterations
        constexpr double kTolerance = 1e-4; // relative to the unbalanced force after a step of the hooks
        Points u = Points::Zero(problem.mesh.vertices.rows(), 3);
        for (int step = 1; step <= kSteps; ++step) {
            for (const fem::HookPatch& hook : problem.hooks)
                for (const VertexId v : hook.nodes)
                    u.row(v) = (hook.displacement * step / kSteps).transpose();
            fem::SpringNetwork network(mesh::CutSession { problem.mesh }, problem.material_of_label);
            network.set_displacement(u); // set before fixing, because fixed vertices keep their place
            network.fix(problem.supports.fixed);
            for (const fem::HookPatch& hook : problem.hooks)
                network.fix(hook.nodes);
            const fem::RelaxResult rest
                = fem::relax(network, { .tolerance = kTolerance, .max_iterations = kPlenty }, job);
            if (rest.status != fem::RelaxStatus::converged)
                throw SolverError("the springs did not come to rest: " + rest.message);
            u = network.displacement();
        }
        Answer answer;
        VerificationRow& row = answer.row;
        row.problem = "solver ladder";
        row.element = "springs";
        row.law = "springs";
        row.nodes = problem.mesh.vertex_count();
        row.tets = problem.mesh.tet_count();
        // relax() measures its residual by another force than the rows of finite elements do.
        row.residual = std::numeric_limits<double>::quiet_NaN();
        row.seconds = watch.seconds();
        answer.field = field_of(block, kCoarse, problem.mesh, Eigen::Map<const Eigen::VectorXd>(u.data(), u.size()));
        return answer;
    }

    std::vector<Rung> rungs(bool fine)
    {
        using enum VerificationElement;
        const double finest = 1.25;
        std::vector<Rung> all { { "springs", p1, { 5.0, 2.5 } }, { "linear", p1, { 5.0, 2.5, finest } },
            { "corotational", p1, { 5.0, 2.5 } }, { "linear", locking_free, { 5.0, 2.5 } },
            { "corotational", locking_free, { 5.0, 2.5 } }, { "neo-Hookean", locking_free, { 5.0, 2.5 } },
            { "linear", p2, { 5.0, 2.5 } }, { "neo-Hookean", p2, { 5.0 } } };
        if (fine) {
            all[2].cells.push_back(finest);
            all.back().cells.push_back(2.5);
        }
        return all;
    }

    std::vector<VerificationRow> solver_ladder(const VerificationOptions& options, const Job& job)
    {
        const Rung finest { "neo-Hookean", VerificationElement::p2, {} };
        const double cell_of_reference = options.meshes == 1 ? kCoarse : options.fine ? 5.0 / 3.0 : 2.5;
        Answer reference = solve_elements(finest, cell_of_reference, job);
        const std::string quantity = "error of the displacement, root mean square over the largest";
        compare(reference.row, quantity, 0.0, 0.0);
        show_only(reference.row, "the reference");
        // The error of the reference is estimated by the coarser answer of the same kind; smaller errors cannot be
        // distinguished.
        constexpr double kReference = 0.05;
        const OrderRule falls { .asks = OrderRule::Asks::fall,
            .why = "the reference has another law or is not much finer, which leaves a floor" },
            springs { .asks = OrderRule::Asks::nothing,
                .why = "springs along edges are another material, with a Poisson's ratio of 1/4: no mesh brings them "
                       "nearer" };
        std::vector<VerificationRow> rows;
        for (const Rung& rung : rungs(options.fine)) {
            std::vector<VerificationRow> series;
            for (const double cell : coarsest(rung.cells, options)) {
                if (job.cancelled())
                    return rows;
                Answer answer = rung.law == "springs" ? solve_springs(cell, job) : solve_elements(rung, cell, job);
                compare(answer.row, quantity, difference(answer.field, reference.field), 0.0);
                answer.row.size = cell / kCoarse;
                series.push_back(answer.row);
            }
            const bool like_reference = rung.law == finest.law && rung.element == finest.element;
            append_series(rows, series, std::numeric_limits<double>::quiet_NaN(),
                like_reference ? kReference : kNoBound, rung.law == "springs" ? springs : falls);
        }
        rows.push_back(reference.row);
        return rows;
    }

} // namespace

VerificationProblem solver_ladder_problem()
{
    return { "solver ladder",
        "an opened incision of 20 mm in nearly incompressible tissue by every solver, against quadratic hyperelastic "
        "elements",
        solver_ladder, "nodal P1, which `plan` does not offer; laws with fibres: fat has none" };
}

} // namespace retractor::verification
