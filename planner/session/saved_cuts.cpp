#include "planner/session/saved_cuts.h"

#include "mesh/base/error.h"
#include "planner/case/approach_file.h"
#include "planner/case/case.h"

#include <string>
#include <system_error>
#include <utility>

namespace retractor::planner {

std::filesystem::path cuts_journal(const std::filesystem::path& case_file, std::string_view approach)
{
    return approach_file(case_file, "cuts", approach, ".jsonl");
}

SavedCuts read_saved_cuts(const std::filesystem::path& journal, const mesh::TetMesh& wall, const Job& job)
{
    mesh::ReplayedJournal replayed = mesh::replay_journal(journal, wall, job);
    SavedCuts kept;
    kept.note = replayed.message;
    if (replayed.status == mesh::CutStatus::cancelled)
        throw InputError("reading the kept cuts was cancelled", journal.string());
    mesh::CutSession& session = replayed.session;
    if (session.stroke_open()) {
        (void)session.finish_stroke();
        kept.note += "; it is finished where it ended";
    }
    kept.more = session.can_redo();
    const std::size_t count = session.cut_count();
    for (std::size_t i = 0; i < count; ++i)
        (void)session.undo();
    for (std::size_t i = 0; i < count; ++i)
        kept.deltas.push_back(session.redo());
    return kept;
}

SurgerySession restored_session(SurgerySetup setup, const SavedCuts& kept, const Job& job, mesh::WaitingLines* waiting)
{
    mesh::WaitingLines untold;
    mesh::ReplayedJournal opened
        = mesh::open_patient_journal(setup.journal, setup.wall, waiting != nullptr ? *waiting : untold, job);
    if (opened.status == mesh::CutStatus::cancelled)
        throw InputError("reading the kept cuts was cancelled", setup.journal.string());
    if (opened.session.stroke_open())
        (void)opened.session.finish_stroke();
    return SurgerySession(std::move(setup), std::move(opened.session), kept.deltas, job);
}

SurgerySession new_session(SurgerySetup setup, const Job& job, mesh::WaitingLines* waiting)
{
    mesh::WaitingLines untold;
    mesh::CutSession session
        = mesh::start_patient_journal(setup.journal, setup.wall, waiting != nullptr ? *waiting : untold);
    return SurgerySession(std::move(setup), std::move(session), {}, job);
}

std::filesystem::path set_aside(const std::filesystem::path& journal)
{
    for (int number = 1;; ++number) {
        std::filesystem::path other = journal;
        other += "." + std::to_string(number);
        if (std::filesystem::exists(other))
            continue;
        std::error_code error;
        std::filesystem::rename(journal, other, error);
        if (error)
            throw IoError("the kept cuts cannot be set aside: " + error.message(), journal.string());
        return other;
    }
}

} // namespace retractor::planner
