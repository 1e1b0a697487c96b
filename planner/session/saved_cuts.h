#pragma once
// Cuts by hand that are kept on disk beside a case, one journal per approach: what to do with those of the last time.

#include "planner/session/surgery_session.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// CASE/cuts/APPROACH.jsonl for CASE/case.json, CASE/NAME.cuts/APPROACH.jsonl for CASE/NAME.json; whatever is no
/// letter, digit, '-' or '_' in the approach's name is written as %XX.
std::filesystem::path cuts_journal(const std::filesystem::path& case_file, std::string_view approach);

/// What a journal holds.
struct SavedCuts {
    std::vector<mesh::MeshDelta> deltas; ///< one per cut in force, in order
    bool more = false; ///< there are cuts that were taken back and could be made again
    std::string note; ///< what the reader should know, e.g. that an unfinished line was dropped
    bool worth_asking() const { return !deltas.empty() || more; }
};

/// Reads the journal on the uncut wall; a stroke that a crash left open is counted as finished.
/// @throws IoError; InputError when it is damaged or of another wall.
SavedCuts read_saved_cuts(const std::filesystem::path& journal, const mesh::TetMesh& wall, const Job& job = {});

/// A desk with the kept cuts, which goes on writing to their journal. @throws as read_saved_cuts().
SurgerySession restored_session(SurgerySetup table, const SavedCuts& kept, const Job& job = {});
/// A desk without cuts and with a new journal. @throws IoError when there is a journal already or none can be written.
SurgerySession new_session(SurgerySetup table, const Job& job = {});

/// Gives the journal another name in its folder (.1, .2, ... appended), so that nothing is ever lost; returns it.
/// @throws IoError.
std::filesystem::path set_aside(const std::filesystem::path& journal);

} // namespace retractor::planner
