#pragma once
// Freehand cuts on disk beside a case, in one journal per approach, and their restoration in a later session.

#include "mesh/cutting/cut_journal.h"
#include "planner/session/surgery_session.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// Path of the journal: CASE/cuts/APPROACH.jsonl; see approach_file().
std::filesystem::path cuts_journal(const std::filesystem::path& case_file, std::string_view approach);

/// The content of a journal.
struct SavedCuts {
    std::vector<mesh::MeshDelta> deltas; ///< one per active cut, in order
    bool more = false; ///< undone cuts can be redone
    std::string note; ///< message for the user, e.g. that an unfinished line was dropped
    bool worth_asking() const { return !deltas.empty() || more; }
};

/// Reads the journal on the uncut wall. A stroke that a crash left open counts as finished.
/// @throws IoError; InputError when the journal is damaged or belongs to another wall
SavedCuts read_saved_cuts(const std::filesystem::path& journal, const mesh::TetMesh& wall, const Job& job = {});

/// A session with the saved cuts that continues their journal. Later cuts wait for a disk that is full.
/// @param waiting set to what waits; null: not told
/// @throws as read_saved_cuts()
SurgerySession restored_session(
    SurgerySetup setup, const SavedCuts& kept, const Job& job = {}, mesh::WaitingLines* waiting = nullptr);
/// A session without cuts and with a new journal. When no journal can be written, the cuts wait.
/// @param waiting set to what waits; null: not told
SurgerySession new_session(SurgerySetup setup, const Job& job = {}, mesh::WaitingLines* waiting = nullptr);

/// Renames the journal within its folder by appending .1, .2, ..., so that nothing is lost.
/// @return the new path
/// @throws IoError
std::filesystem::path set_aside(const std::filesystem::path& journal);

} // namespace retractor::planner
