#pragma once
// The journal of a cutting session on disk: every operation is written as it is done, so that a crash loses at most the
// operation under way, and replaying the journal on the same mesh gives the same session, bit for bit, on any machine
// with IEEE arithmetic and any number of threads. Units mm; frame patient LPS.
//
// The file is text, one JSON object per line (version 4). The first line is the head:
//   {"journal":"retractor cuts","version":4,"frame":"LPS","units":"mm","vertices":n,"tets":n,"mesh":"<checksum>",...}
// and every further line an operation, by its key "do":
//   cut       "blade": {"line": [[x,y,z],...], "directions": [...], "depth_mm": d, "above_mm": a}, "options": {...}
//   step      of a freehand stroke, as given: a blade whose "line" and "directions" may leave out what they have in
//   common
//             with the step before ("same_points", "same_directions": how many); "options" where they changed
//   end, abandon     of the stroke
//   ablate    "tets": ids of the session, in ranges [first, last, first, last, ...]
//   undo, redo
// Numbers are the shortest decimals that read back as the same double. Every operation has a "digest": FNV-1a (64 bits)
// over the digest of the line before and what the operation changed, so that a replay that goes another way is noticed
// where it does; and every line ends with "check": FNV-1a over the check of the line before and the bytes of its own
// line in front of it, so that a line that was changed, lost, doubled or swapped is noticed when the file is read.
// A last line without its line end is an operation that was under way: it is dropped, and a message says so.

#include "mesh/cutting/cut_session.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace retractor::mesh {

/// Counts up whenever the format changes, or the same operation gives other elements than before.
inline constexpr int kCutJournalVersion = 4;

/// FNV-1a (64 bits) over the numbers of vertices and elements, the vertices' coordinates, nodes and labels.
std::uint64_t mesh_checksum(const TetMesh& mesh);

/// A session whose every operation is flushed to disk before it is kept; when writing fails, the operation has not
/// happened. Only one session at a time writes to a journal. The file is closed with the session.
/// @throws InputError as CutSession does; IoError when the file is there already or cannot be written.
CutSession start_journal(const std::filesystem::path& path, TetMesh mesh);

struct [[nodiscard]] ReplayedJournal {
    CutStatus status = CutStatus::done; ///< or cancelled: the session then holds a part of the journal, and writes none
    CutSession session;
    std::size_t operations = 0; ///< lines after the head
    std::string message; ///< what was dropped, and whether a stroke is open; empty when there is nothing to say
};

/// The session that a journal describes, as it was when the last whole line was written (a freehand stroke may be
/// open: extend, finish or abandon it). It goes on writing to the journal.
/// @throws IoError when the file cannot be read or written, or another session writes to it; InputError naming file and
/// line ("cuts.jsonl:7") when it is no such journal, of another version, of another mesh, damaged, or when an operation
/// does not do what it did.
ReplayedJournal open_journal(const std::filesystem::path& path, TetMesh mesh, const Job& job = {});

/// The same without writing: the file stays as it is, and may be read-only.
ReplayedJournal replay_journal(const std::filesystem::path& path, TetMesh mesh, const Job& job = {});

} // namespace retractor::mesh
