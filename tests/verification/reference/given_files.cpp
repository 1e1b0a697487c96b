// Validation problem 13: published model files with their results.

#include "tests/verification/reference/given_files.h"

#include "mesh/base/error.h"
#include "tests/verification/reference/calculix_reference.h"
#include "tests/verification/reference/febio_reference.h"

#include <cmath>

namespace retractor::verification {

namespace {

    VerificationRow skipped(const std::string& problem, const std::filesystem::path& file)
    {
        VerificationRow row;
        row.problem = problem;
        row.error = std::numeric_limits<double>::quiet_NaN();
        row.note = "skipped: " + file.filename().string() + " is not there";
        return row;
    }

    VerificationRow calculix_beam(const std::filesystem::path& folder, const Job& job)
    {
        const std::filesystem::path file = folder / "beam10p.inp";
        if (!std::filesystem::exists(file))
            return skipped("CalculiX beam10p", file);
        const CalculixModel model = read_calculix(file);
        const std::vector<Vec3> printed = read_calculix_displacements(folder / "beam10p.dat.ref", model);
        VerificationLaw law { "linear", fem::Elasticity::linear, model.lame, {}, {} };
        fem::ElasticBody body = make_body(model.mesh, VerificationElement::p2, law);
        body.set_loads({ model.loads, {} });
        const VerificationSolve solve
            = solve_problem(body, model.held.prescribed, model.held.target, { .tolerance = 1e-10 }, job);
        VerificationRow row = make_row("CalculiX beam10p", VerificationElement::p2, law, model.mesh, solve);
        double worst = 0.0, largest = 0.0;
        for (std::size_t v = 0; v < printed.size(); ++v) {
            const Vec3 u = solve.equilibrium.displacement.segment<3>(3 * static_cast<Eigen::Index>(v));
            worst = std::max(worst, (u - printed[v]).cwiseAbs().maxCoeff());
            largest = std::max(largest, printed[v].norm());
        }
        compare(row, "largest difference of a displacement / largest displacement", worst / largest, 0.0);
        row.bound = 1e-6; // the file prints seven digits
        return row;
    }

    struct FebioCase {
        std::string name;
        double printed; ///< norm of the free displacements
        double bound;
        VerificationElement element;
    };

    VerificationRow febio_model(const FebioModel& model, const FebioCase& c, const Job& job)
    {
        const VerificationLaw law = hyperelastic_law(model.law_name, model.law);
        fem::ElasticBody body = make_body(model.mesh, c.element, law);
        body.set_loads({ model.loads, {} });
        const VerificationSolve solve = solve_problem(body, model.held.prescribed, model.held.target,
            { .load_steps = 10, .max_newton_iterations = 60, .tolerance = 1e-6 }, job);
        VerificationRow row = make_row("FEBio " + c.name, c.element, law, model.mesh, solve);
        double sum = 0.0;
        for (std::size_t i = 0; i < model.held.prescribed.size(); ++i)
            if (model.held.prescribed[i] == 0) {
                const double u = solve.equilibrium.displacement[static_cast<Eigen::Index>(i)];
                sum += u * u;
            }
        compare(row, "norm of the free displacements, mm", std::sqrt(sum), c.printed);
        row.bound = c.bound;
        return row;
    }

    std::vector<FebioCase> febio_cases()
    {
        using enum VerificationElement;
        return { { "te01", 0.44268188785, 1e-6, p1 }, { "te02", 97.9737049748, 0.02, nodal },
            { "te03", 11.6851473735, 0.02, locking_free }, { "te03", 11.6851473735, 0.02, nodal } };
    }

} // namespace

VerificationProblem calculix_problem()
{
    return { "CalculiX beam10p", "every displacement of CalculiX's own cantilever of ten-node tetrahedra",
        [](const VerificationOptions& options, const Job& job) {
            return std::vector<VerificationRow> { calculix_beam(options.shared_data / "fem" / "calculix", job) };
        },
        "the printed displacements are those of ten-node elements and linear tissue" };
}

VerificationProblem febio_problem()
{
    return { "FEBio", "FEBio's test suite: te01 with one element, te02 and te03 nearly incompressible",
        [](const VerificationOptions& options, const Job& job) {
            std::vector<VerificationRow> rows;
            for (const FebioCase& c : febio_cases()) {
                if (job.cancelled())
                    break;
                const std::filesystem::path file = options.shared_data / "fem" / "febio" / (c.name + ".feb");
                rows.push_back(std::filesystem::exists(file) ? febio_model(read_febio(file), c, job)
                                                             : skipped("FEBio " + c.name, file));
            }
            return rows;
        },
        "te02 and te03 are results of FEBio's own element, averaged round nodes, on its own coarse meshes: the nodal "
        "one is compared. Plain P1 locks (51 % off on te02); locking-free P1 is 8 % off on te02, as another element on "
        "such a mesh may be, and takes longer than all the rest" };
}

} // namespace retractor::verification
