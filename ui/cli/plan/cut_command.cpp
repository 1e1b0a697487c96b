// The command `retractor cut`: cuts the wall of an approach as planned, or as a journal records. A replayed journal can
// be continued.

#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"
#include "ui/cli/commands.h"
#include "ui/cli/framework/open_case.h"
#include "ui/cli/framework/out_folder.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/cutting/cut_journal.h"
#include "mesh/tetrahedra/mesh_io.h"
#include "planner/approach/find_division.h"
#include "planner/case/patient.h"
#include "planner/measures/metrics.h"
#include "planner/wall/parted_bones.h"
#include "planner/wall/wall_cut.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

namespace retractor::ui::cli {

namespace {

    namespace fs = std::filesystem;

    struct KnifeOptions {
        std::string case_file, approach, out, journal, replay;
        int undo = 0;
        bool finish = false, abandon = false;
    };

    Json report_document(const mesh::CutReport& r)
    {
        return { { "tets_crossed", r.tets_crossed }, { "tets_before", r.tets_before }, { "tets_after", r.tets_after },
            { "tets_created", r.tets_created }, { "tets_removed", r.tets_removed },
            { "mean_increase", r.mean_increase() }, { "vertices_moved", r.vertices_moved },
            { "vertices_merged", r.vertices_merged }, { "largest_move_mm", r.largest_move_mm },
            { "surface_deviation", r.surface_deviation }, { "lip_area_mm2", r.lip_area_mm2 },
            { "lip_to_blade", r.lip_to_blade }, { "worst_dihedral_before_deg", r.worst_dihedral_before_deg },
            { "worst_dihedral_deg", r.worst_dihedral_deg }, { "p01_dihedral_deg", r.p01_dihedral_deg },
            { "smallest_volume_ratio", r.smallest_volume_ratio }, { "attempts", r.attempts },
            { "seconds", r.seconds } };
    }

    Json piece_document(const planner::WallPiece& piece)
    {
        Json labels = Json::object();
        for (const auto& [name, volume] : piece.labels)
            labels[name] = volume;
        return { { "number", piece.number }, { "tets", piece.tets.size() }, { "volume_mm3", piece.volume_mm3 },
            { "centroid_mm", { piece.centroid.x(), piece.centroid.y(), piece.centroid.z() } }, { "labels_mm3", labels },
            { "supported_vertices", piece.fixed }, { "bedded_vertices", piece.bedded }, { "held", piece.held } };
    }

    void check_journal(const KnifeOptions& options)
    {
        for (const auto& [given, name] : { std::pair { options.finish, "--finish" }, { options.abandon, "--abandon" } })
            if (given && options.replay.empty())
                throw InputError("needs a journal to replay: name the journal with --replay", name);
        if (options.undo < 0)
            throw InputError("must be 0 or more, got " + std::to_string(options.undo), "--undo");
        std::error_code none; // a file that does not exist yet differs from any other
        if (!options.journal.empty() && !options.replay.empty()
            && !fs::equivalent(options.journal, options.replay, none))
            throw InputError("a replay can continue only its own journal: name the same file as --replay "
                    + options.replay + ", or omit --journal",
                "--journal " + options.journal);
    }

    /// Checks, before anything is written to the journal, that the open stroke can be ended as requested and that there
    /// are enough cuts.
    void check_ending(const KnifeOptions& options, const mesh::CutSession& session)
    {
        const bool open = session.stroke_open(), ends = options.finish || options.abandon;
        if (ends && !open)
            throw InputError("no stroke is open in " + options.replay, options.finish ? "--finish" : "--abandon");
        if (open && !ends && options.undo > 0)
            throw InputError("the journal ends in a freehand stroke that is open: add --finish or --abandon", "--undo");
        const std::size_t cuts = session.cut_count() + (options.finish ? 1 : 0);
        if (static_cast<std::size_t>(options.undo) > cuts)
            throw InputError(cuts == 0 ? "there is no cut to undo"
                    : cuts == 1        ? "there is only 1 cut to undo"
                                       : "there are only " + std::to_string(cuts) + " cuts to undo",
                "--undo");
    }

    /// Finishes the open stroke. A stroke that cannot be finished stays open.
    mesh::CutResult finish_stroke(mesh::CutSession& session, const Job& job)
    {
        try {
            return session.finish_stroke(job);
        } catch (const SolverError& error) {
            throw SolverError(std::string(error.what()) + "; --abandon takes the stroke back",
                error.where().empty() ? "--finish" : "--finish, " + error.where());
        }
    }

    /// Ends the open stroke that a crash left, as the options request.
    void end_open_stroke(const KnifeOptions& options, mesh::CutSession& session, Json& document, const Job& job)
    {
        const auto say = [&](const std::string& text) {
            document["message"]
                = document.contains("message") ? document.at("message").get<std::string>() + "; " + text : text;
        };
        if (!session.stroke_open())
            return;
        if (options.finish) {
            const mesh::CutResult result = finish_stroke(session, job);
            refuse_if_cancelled(job);
            if (result.status != mesh::CutStatus::done) // the stroke is over, and nothing is left to take back
                throw SolverError(result.message, "--finish");
            document["report"] = report_document(result.report);
            say("the stroke is now finished");
        } else if (options.abandon) {
            static_cast<void>(session.abandon_stroke());
            say("the stroke is now taken back");
        } else {
            say("the mesh contains the stroke as far as it is cut; --finish cuts up to the end of the stroke, "
                "--abandon takes the stroke back");
        }
    }

    /// Begins a session on the mesh, with a journal if requested.
    mesh::CutSession begin(const KnifeOptions& options, const mesh::TetMesh& mesh, Json& document, const Job& job)
    {
        if (options.replay.empty())
            return options.journal.empty() ? mesh::CutSession(mesh) : mesh::start_journal(options.journal, mesh);
        const bool goes_on = !options.journal.empty();
        mesh::ReplayedJournal replayed
            = goes_on ? mesh::open_journal(options.replay, mesh, job) : mesh::replay_journal(options.replay, mesh, job);
        refuse_if_cancelled(job);
        document["replayed"] = replayed.operations;
        if (!replayed.message.empty())
            document["message"] = replayed.message;
        return std::move(replayed.session);
    }

    /// Cuts the approach. @return the tissue that its ablations removed
    std::vector<planner::RemovedTissue> add_cut(const planner::Approach& approach, const mesh::LabelTable& table,
        mesh::CutSession& session, Json& document, const Job& job)
    {
        const planner::PlannedCut planned
            = planner::cut_as_planned(session, approach, table, planner::cut_options_of(approach, table), job);
        refuse_if_cancelled(job);
        if (planned.status != mesh::CutStatus::done)
            throw SolverError(planned.message, "approach " + approach.name);
        document["report"] = report_document(planned.report);
        document["removed_skin_mm2"] = planned.removed_skin_mm2;
        document["removed"] = Json::array();
        for (const planner::RemovedTissue& tissue : planned.removed)
            document["removed"].push_back(
                { { "what", tissue.what }, { "label", tissue.label }, { "volume_mm3", tissue.volume_mm3 } });
        if (planned.divided)
            document["division"] = { { "labels", planned.divided->labels }, { "length_mm", planned.divided->length_mm },
                { "forwards_mm", planned.divided->forwards_mm }, { "backwards_mm", planned.divided->backwards_mm },
                { "right_mm", planned.divided->right_mm }, { "left_mm", planned.divided->left_mm },
                { "severed_mm2", planned.divided->severed_mm2 } };
        std::string message = approach.division.words;
        remark(message, planned.message);
        if (!message.empty())
            document["message"] = message;
        return planned.removed;
    }

    /// The element of the uncut mesh to which each element belongs.
    std::vector<double> origins(const mesh::CutSession& session, const mesh::SlotMap& map)
    {
        std::vector<double> origin;
        for (const TetId slot : map.tet_slot)
            origin.push_back(static_cast<double>(session.origin(slot)));
        return origin;
    }

    /// The number of each element's piece.
    std::vector<double> piece_numbers(const mesh::TetMesh& wall, const std::vector<planner::WallPiece>& pieces)
    {
        std::vector<double> number(wall.tet_count(), 0.0);
        for (const planner::WallPiece& p : pieces)
            for (const TetId t : p.tets) {
                RETRACTOR_ASSERT(t >= 0 && static_cast<std::size_t>(t) < number.size());
                number[static_cast<std::size_t>(t)] = p.number;
            }
        return number;
    }

    /// The deltas of the cuts in force, in order, with an open stroke last. The session is used up; its journal stays
    /// unchanged.
    std::vector<mesh::MeshDelta> deltas_in_force(mesh::CutSession session)
    {
        session.set_witness({});
        std::vector<mesh::MeshDelta> deltas;
        if (session.stroke_open())
            deltas.push_back(mesh::inverse(session.abandon_stroke()));
        while (session.can_undo())
            deltas.push_back(mesh::inverse(session.undo()));
        std::reverse(deltas.begin(), deltas.end());
        return deltas;
    }

    std::string summary(const Json& document, const std::vector<planner::RemovedTissue>& removed,
        const std::vector<planner::WallPiece>& pieces, const fs::path& file)
    {
        std::string text = file.string() + ": " + std::to_string(document.at("tets").get<std::size_t>()) + " elements, "
            + std::to_string(document.at("cuts").get<std::size_t>()) + " cut(s) in force\n";
        if (document.contains("report")) {
            const Json& r = document.at("report");
            text += formatted(
                "%zu elements crossed, mean increase %.2f, dihedral angles from %.1f degrees (1 %% below %.1f)\n",
                r.at("tets_crossed").get<std::size_t>(), r.at("mean_increase").get<double>(),
                r.at("worst_dihedral_deg").get<double>(), r.at("p01_dihedral_deg").get<double>());
        }
        if (const std::string taken = planner::removed_text(removed); !taken.empty())
            text += taken + "\n";
        std::size_t crumbs = 0;
        for (const planner::WallPiece& piece : pieces)
            if (planner::is_crumb(piece))
                ++crumbs;
            else
                text += planner::piece_text(piece) + (piece.held ? "" : " (has no support)") + "\n";
        if (crumbs > 0)
            text += planner::crumbs_text(crumbs) + "\n";
        if (document.contains("message"))
            text += document.at("message").get<std::string>() + "\n";
        return text;
    }

    Outcome knife(const KnifeOptions& options, const Job& job)
    {
        check_journal(options);
        const planner::Case planned_case = open_case(options.case_file);
        planner::Approach approach = planner::find_approach(planned_case, options.approach);
        const mesh::LabelTable& table = planned_case.label_table;
        planner::Patient patient(planned_case, job);
        planner::find_division(approach, patient);
        const mesh::MeshSizing sizing = planner::mesh_sizing_of(approach, table);
        const mesh::HybridModel model = planner::build_wall(*patient.labels(), sizing, job);
        refuse_if_cancelled(job);
        if (model.status != mesh::MeshStatus::done)
            throw SolverError(model.message, "approach " + approach.name);
        const fs::path folder = options.out;
        const OutFolder made(folder);

        Outcome outcome;
        Json& document = outcome.document;
        document["approach"] = approach.name;
        document["frame"] = "LPS";
        document["uncut_mesh"] = { { "tets", model.wall.tet_count() }, { "vertices", model.wall.vertex_count() } };
        mesh::CutSession session = begin(options, model.wall, document, job);
        std::vector<planner::RemovedTissue> removed;
        if (!options.replay.empty())
            check_ending(options, session);
        else
            try {
                removed = add_cut(approach, table, session, document, job);
                check_ending(options, session);
                // Remove the new journal, which would be in the way of the next attempt.
            } catch (...) {
                std::error_code kept;
                if (!options.journal.empty())
                    fs::remove(options.journal, kept);
                throw;
            }
        end_open_stroke(options, session, document, job);
        for (int i = 0; i < options.undo; ++i)
            static_cast<void>(session.undo());
        mesh::SlotMap map;
        const mesh::TetMesh wall = session.compact_mesh(&map);
        RETRACTOR_ASSERT(map.tet_slot.size() == wall.tet_count());
        document["tets"] = wall.tet_count();
        document["vertices"] = wall.vertex_count();
        document["cuts"] = session.cut_count();
        document["lip_faces"] = session.lips().size();
        const mesh::SessionBytes bytes = session.bytes();
        document["bytes"] = { { "mesh", bytes.mesh }, { "undo", bytes.journal } };
        mesh::MeshFields fields;
        fields.cell_scalars["origin"] = origins(session, map);
        const fem::Supports supports
            = planner::carried_supports(planner::supports_of(model.wall, *patient.labels(), planned_case, sizing),
                deltas_in_force(std::move(session)), map);
        const std::vector<planner::WallPiece> pieces = planner::find_wall_pieces(wall, table, supports, {});
        fields.cell_scalars["piece"] = piece_numbers(wall, pieces);
        document["pieces"] = Json::array();
        for (const planner::WallPiece& piece : pieces)
            document["pieces"].push_back(piece_document(piece));
        const fs::path file = folder / (approach.name + "-cut.vtu");
        mesh::write_vtu(file, wall, fields);
        write_file_atomically(
            folder / "report.json", document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
        outcome.text = summary(document, removed, pieces, file);
        return outcome;
    }

} // namespace

void add_cut_command(Commands& commands)
{
    auto options = std::make_shared<KnifeOptions>();
    CLI::App* command = commands.app.add_subcommand("cut",
        "Cut the wall of an approach as planned, or replay a journal of cuts; write the cut wall and its pieces");
    command->footer("Example: retractor cut case.json --approach median --out cut --journal cut/median.jsonl");
    command->add_option("case", options->case_file, "case.json")->required()->check(CLI::ExistingPath);
    command->add_option("--approach", options->approach, "Approach whose wall is cut")->required();
    command->add_option("--out", options->out, "Folder for <approach>-cut.vtu and report.json")->required();
    command->add_option("--journal", options->journal,
        "Write every operation to this file at once (a new file, or the file of --replay to continue that journal)");
    command->add_option("--replay", options->replay, "Repeat the cuts of this journal instead of the planned cut")
        ->check(CLI::ExistingFile);
    command->add_option("--undo", options->undo, "Number of the last cuts to undo");
    CLI::Option* finish = command->add_flag(
        "--finish", options->finish, "Finish the freehand stroke that the replayed journal leaves open");
    command
        ->add_flag("--abandon", options->abandon, "Take back the freehand stroke that the replayed journal leaves open")
        ->excludes(finish);
    commands.on(command, [options](const Job& job) { return knife(*options, job); });
}

} // namespace retractor::ui::cli
