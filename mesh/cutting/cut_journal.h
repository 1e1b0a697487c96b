#pragma once
// The journal of a cutting session on disk. Every operation is written when it is done, so that a crash loses at most
// the operation under way. Replaying the journal on the same mesh gives the same session bit for bit, on any machine
// with IEEE arithmetic and with any number of threads. Units mm; frame patient LPS.
//
// The file is text with one JSON object per line (version 4). The first line is the head:
//   {"journal":"retractor cuts","version":4,"frame":"LPS","units":"mm","vertices":n,"tets":n,"mesh":"<checksum>",...}
// Every further line is an operation, named by its key "do":
//   cut       "blade": {"line": [[x,y,z],...], "directions": [...], "depth_mm": d, "above_mm": a}, "options": {...}
//   step      of a freehand stroke: a blade as in "cut"; "same_points" and "same_directions" count the entries that
//             "line" and "directions" leave out because they begin as in the step before; "options" when changed
//   end, abandon     the stroke
//   ablate    "tets": ids of the session, in ranges [first, last, first, last, ...]
//   undo, redo
// Numbers are the shortest decimals that read back as the same double. Every operation has a "digest": FNV-1a (64 bits)
// over the digest of the line before and the changes of the operation, so that a replay detects the first operation
// with another result. Every line ends with "check": FNV-1a over the check of the line before and the preceding bytes
// of its own line, so that reading detects a line that was changed, lost, doubled or swapped. A last line without line
// end is an operation that was under way; the reader drops the line and says so in a message.

#include "mesh/cutting/cut_session.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

namespace retractor::mesh {

/// Increases when the format changes, or when an operation gives other elements than before.
inline constexpr int kCutJournalVersion = 4;

/// FNV-1a (64 bits) over the numbers of vertices and elements, the coordinates of vertices, the nodes and the labels.
std::uint64_t mesh_checksum(const TetMesh& mesh);

/// Starts a session with a new journal. Every operation is flushed to disk before the session keeps it; when writing
/// fails, the operation is taken back. Only one session at a time writes to a journal. The file is closed with the
/// session.
/// @throws InputError as CutSession; IoError when the file exists already or cannot be written
CutSession start_journal(const std::filesystem::path& path, TetMesh mesh);

struct Journal;

/// The lines of a journal that the disk has refused. They wait in memory, in order, while the session goes on; each
/// further operation tries to write them. A crash loses them. For the session's thread only.
class WaitingLines {
public:
    WaitingLines() = default; ///< of no session: nothing waits
    explicit WaitingLines(std::weak_ptr<Journal> journal)
        : journal_(std::move(journal))
    {
    }
    /// Why lines wait, for people; empty: every line is on the disk, or the session has gone.
    std::string reason() const;
    /// Tries to write them now. @return whether every line is on the disk
    bool write();

private:
    std::weak_ptr<Journal> journal_; ///< of the session
};

struct [[nodiscard]] ReplayedJournal {
    CutStatus status = CutStatus::done; ///< done or cancelled
    CutSession session; ///< after cancellation: holds a part of the operations and writes no journal
    std::size_t operations = 0; ///< number of lines after the head
    std::string message; ///< remarks on a dropped line and an open stroke; may be empty
};

/// Replays a journal up to its last whole line. The session continues the journal. A freehand stroke may be open:
/// extend, finish or abandon the stroke.
/// @throws IoError when the file cannot be read or written, or another session writes to it; InputError naming file and
/// line ("cuts.jsonl:7") when the file is no journal, is damaged, belongs to another version or another mesh, or when
/// an operation has another result than before
ReplayedJournal open_journal(const std::filesystem::path& path, TetMesh mesh, const Job& job = {});

/// The same two, for a session that must not stop when a disk is full or a folder may not be written: the operations
/// are kept, and their lines wait. A new journal may wait from the beginning. Its folder is made when it is missing. A
/// file that is deleted meanwhile is written anew, as soon as the folder above allows it.
/// @param waiting set to the lines of this journal
/// @throws IoError as the other two, except for a new journal only when its file exists already
CutSession start_patient_journal(const std::filesystem::path& path, TetMesh mesh, WaitingLines& waiting);
ReplayedJournal open_patient_journal(
    const std::filesystem::path& path, TetMesh mesh, WaitingLines& waiting, const Job& job = {});

/// The same without writing: the file is not changed and may be read-only.
ReplayedJournal replay_journal(const std::filesystem::path& path, TetMesh mesh, const Job& job = {});

} // namespace retractor::mesh
