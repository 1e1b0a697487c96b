#include "ui/cli/plan/second_opinion.h"

#include "fem/io/calculix_deck.h"
#include "fem/io/febio_file.h"
#include "fem/statics/opening.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "ui/cli/framework/run_program.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <system_error>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    constexpr double kOwnTolerance = 1e-10; // relative residual; far below the seven digits of the comparison
    constexpr auto kFailed = "failed";

    void refuse_when_cancelled(const Job& job)
    {
        if (job.cancelled())
            throw SolverError("cancelled; there is no second opinion");
    }

    fem::OpeningResult own_answer(const fem::ElasticProblem& problem, const Job& job)
    {
        fem::OpeningOptions options;
        options.elasticity = fem::Elasticity::linear;
        options.tolerance = kOwnTolerance;
        fem::Opening opening(problem, options);
        fem::OpeningResult answer = opening.open(problem.hooks, job);
        refuse_when_cancelled(job);
        if (answer.status != fem::OpeningStatus::converged
            && answer.status != fem::OpeningStatus::inverted) // the linear equations do not see inverted elements
            throw SolverError("our own linear answer to compare with: " + answer.message);
        return answer;
    }

    std::string content_of(const fs::path& file)
    {
        std::ifstream in(file, std::ios::binary);
        return { std::istreambuf_iterator<char>(in), {} };
    }

    /// The reason of a failure of ccx, for people: its error lines, or its last line.
    std::string complaint_of(const std::string& log)
    {
        std::istringstream lines(log);
        std::string last, errors;
        int count = 0;
        for (std::string line; std::getline(lines, line);) {
            if (line.find_first_not_of(" \t\r") == std::string::npos)
                continue;
            last = line;
            if (line.find("*ERROR") != std::string::npos && ++count <= 2)
                errors += (errors.empty() ? "" : "; ") + line.substr(line.find_first_not_of(" \t"));
        }
        return errors.empty() ? last : errors;
    }

    struct Answer {
        fem::CalculixAnswer values;
        double seconds = 0.0;
        std::string failure; ///< empty when there is an answer
    };

    Answer ask_calculix(const fem::ElasticProblem& problem, const fs::path& ccx, const fs::path& place,
        std::chrono::milliseconds limit, const Job& job)
    {
        write_file_atomically(place / "wound.inp", fem::calculix_deck(problem));
        std::error_code ignored; // removes the answer of an earlier run
        fs::remove(place / "wound.dat", ignored);
        const Stopwatch watch;
        const ProgramRun run = run_program(
            { "/usr/bin/env", "OMP_NUM_THREADS=" + std::to_string(std::max(1, job.threads)), ccx.string(), "wound" },
            limit, place, [&job] { return job.cancelled(); });
        Answer answer;
        answer.seconds = watch.seconds();
        refuse_when_cancelled(job);
        write_file_atomically(place / "ccx.log", run.out);
        if (run.timed_out) {
            std::ostringstream text;
            text << "ccx did not end within " << static_cast<double>(limit.count()) / 1e3
                 << " s: give it more with --reference-limit";
            answer.failure = text.str();
        } else if (run.exit_code != 0) {
            answer.failure = (run.exit_code < 0 ? "ccx died: "
                                                : "ccx ended with exit code " + std::to_string(run.exit_code) + ": ")
                + complaint_of(run.out);
        } else {
            try {
                answer.values = fem::read_calculix_answer(content_of(place / "wound.dat"), problem);
            } catch (const InputError& error) {
                const std::string complaint = complaint_of(run.out);
                answer.failure
                    = std::string(error.what()) + (complaint.empty() ? "" : "; ccx's last words: " + complaint);
            }
        }
        return answer;
    }

    double largest_norm(const Points& vectors)
    {
        return vectors.rows() > 0 ? vectors.rowwise().norm().maxCoeff() : 0.0;
    }

    void compare(const fem::ElasticProblem& problem, const fem::OpeningResult& own, const fem::CalculixAnswer& other,
        planner::SecondOpinion& opinion)
    {
        std::vector<std::uint8_t> in_element(problem.mesh.vertex_count(), 0);
        for (const VertexId v : problem.mesh.nodes)
            in_element[static_cast<std::size_t>(v)] = 1;
        double difference = 0.0;
        for (Eigen::Index v = 0; v < own.displacement.rows(); ++v)
            if (in_element[static_cast<std::size_t>(v)] != 0)
                difference = std::max(difference, (own.displacement.row(v) - other.displacement.row(v)).norm());
        opinion.largest_displacement_mm = largest_norm(own.displacement);
        opinion.displacement_difference
            = opinion.largest_displacement_mm > 0.0 ? difference / opinion.largest_displacement_mm : difference;
        const fem::Prescribed prescribed = fem::prescribe(problem.mesh, problem.supports, problem.hooks);
        const Eigen::VectorXd reactions
            = Eigen::Map<const Eigen::VectorXd>(other.reaction.data(), other.reaction.size());
        const std::vector<Vec3> forces = fem::hook_forces(reactions, prescribed, problem.hooks.size());
        double force_difference = 0.0, largest_force = 0.0;
        for (std::size_t h = 0; h < forces.size(); ++h) {
            opinion.hook_forces_N.push_back(forces[h].norm());
            opinion.own_hook_forces_N.push_back(own.hook_forces_N[h].norm());
            force_difference = std::max(force_difference, (forces[h] - own.hook_forces_N[h]).norm());
            largest_force = std::max(largest_force, own.hook_forces_N[h].norm());
        }
        opinion.force_difference = largest_force > 0.0 ? force_difference / largest_force : force_difference;
        const bool agrees = opinion.displacement_difference <= kReferenceAgreement;
        opinion.status = agrees ? "agrees" : "differs";
    }

} // namespace

fs::path find_calculix()
{
    const fs::path ccx = program_on_path("ccx");
    if (ccx.empty())
        throw IoError("CalculiX is not on the PATH: apt install calculix-ccx, or plan without --reference", "ccx");
    return ccx;
}

planner::SecondOpinion second_opinion(const fem::ElasticProblem& problem, const fs::path& ccx, const fs::path& folder,
    const std::string& name, std::chrono::milliseconds limit, const Job& job)
{
    planner::SecondOpinion opinion;
    opinion.program = "CalculiX (ccx)";
    job.report("second opinion", 0.0);
    Stopwatch watch;
    const fem::OpeningResult own = own_answer(problem, job);
    opinion.own_seconds = watch.seconds();
    job.report("second opinion", 0.2);
    const fs::path place = folder / (name + "-ccx");
    std::error_code error;
    fs::create_directories(place, error);
    if (error)
        throw IoError("cannot make the folder: " + error.message(), place.string());
    const Answer answer = ask_calculix(problem, ccx, place, limit, job);
    opinion.seconds = answer.seconds;
    job.report("second opinion", 1.0);
    if (!answer.failure.empty()) {
        opinion.status = kFailed;
        opinion.message = answer.failure + " (see " + (place / "ccx.log").string() + ")";
        return opinion;
    }
    compare(problem, own, answer.values, opinion);
    std::error_code ignored; // a folder that cannot be removed does no harm
    fs::remove_all(place, ignored);
    return opinion;
}

fs::path export_problem(
    const fem::ElasticProblem& problem, const std::string& format, const fs::path& folder, const std::string& name)
{
    const fs::path file = folder / (name + (format == "feb" ? ".feb" : ".inp"));
    write_file_atomically(file, format == "feb" ? fem::febio_file(problem) : fem::calculix_deck(problem));
    return file;
}

} // namespace retractor::ui::cli
