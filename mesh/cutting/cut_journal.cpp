#include "mesh/cutting/cut_journal.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cinttypes>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace retractor::mesh {

namespace {

    using Json = nlohmann::ordered_json;

    constexpr const char* kName = "retractor cuts";

    // ---- digests ---------------------------------------------------------------------------------------------------

    /// FNV-1a with 64 bits. Numbers enter as bytes, the lowest byte first.
    class Digest {
    public:
        explicit Digest(std::uint64_t start = kOffset)
            : value_(start)
        {
        }
        void add_byte(unsigned char byte) { value_ = (value_ ^ byte) * kPrime; }
        void add(std::string_view text)
        {
            for (const char c : text)
                add_byte(static_cast<unsigned char>(c));
        }
        void add(std::uint64_t number)
        {
            for (int i = 0; i < 8; ++i)
                add_byte(static_cast<unsigned char>(number >> (8 * i)));
        }
        void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
        void add_id(std::int32_t id)
        {
            const auto number = static_cast<std::uint32_t>(id);
            for (int i = 0; i < 4; ++i)
                add_byte(static_cast<unsigned char>(number >> (8 * i)));
        }
        void add(const Vec3& p)
        {
            for (int axis = 0; axis < 3; ++axis)
                add(p[axis]);
        }
        std::uint64_t value() const { return value_; }

    private:
        static constexpr std::uint64_t kOffset = 14695981039346656037U, kPrime = 1099511628211U;
        std::uint64_t value_;
    };

    void add(Digest& digest, const std::vector<MeshDelta::VertexBorn>& vertices)
    {
        digest.add(static_cast<std::uint64_t>(vertices.size()));
        for (const auto& v : vertices) {
            for (const VertexId id : { v.id, v.a, v.b })
                digest.add_id(id);
            digest.add(v.position);
            digest.add(v.t);
            digest.add_id(static_cast<std::int32_t>(v.origin));
        }
    }

    void add(Digest& digest, const std::vector<MeshDelta::Tet>& tets)
    {
        digest.add(static_cast<std::uint64_t>(tets.size()));
        for (const auto& tet : tets) {
            digest.add_id(tet.id);
            for (const VertexId v : tet.nodes)
                digest.add_id(v);
            digest.add_id(tet.label);
            digest.add_id(tet.origin);
        }
    }

    std::uint64_t digest_after(std::uint64_t before, const MeshDelta& delta)
    {
        Digest digest;
        digest.add(before);
        add(digest, delta.vertices_born);
        digest.add(static_cast<std::uint64_t>(delta.vertices_moved.size()));
        for (const auto& moved : delta.vertices_moved) {
            digest.add_id(moved.id);
            digest.add(moved.from);
            digest.add(moved.to);
        }
        add(digest, delta.tets_gone);
        add(digest, delta.tets_born);
        add(digest, delta.vertices_gone);
        return digest.value();
    }

    std::uint64_t check_after(std::uint64_t before, std::string_view line)
    {
        Digest digest;
        digest.add(before);
        digest.add(line);
        return digest.value();
    }

    std::string hexadecimal(std::uint64_t number) { return formatted("%016" PRIx64, number); }

    // ---- operations as JSON ----------------------------------------------------------------------------------------

    Json written(std::span<const Vec3> points)
    {
        Json list = Json::array();
        for (const Vec3& p : points)
            list.push_back({ p.x(), p.y(), p.z() });
        return list;
    }

    Vec3 read_point(const Json& json)
    {
        const auto p = json.get<std::array<double, 3>>();
        return { p[0], p[1], p[2] };
    }

    void read_points(const Json& json, std::vector<Vec3>& points)
    {
        for (const Json& point : json)
            points.push_back(read_point(point));
    }

    /// The only subdivision. Journals name it, because older programs had others.
    constexpr const char* kSubdivision = "adaptive";

    Json written(const CutOptions& options)
    {
        // The structured binding names every option, because a replay would lose an option that is not written.
        const auto& [snap, snap_angle_deg, improve_below_deg, crease_deg, uncut_labels, element_limit] = options;
        Json json;
        json["subdivision"] = kSubdivision;
        json["snap"] = snap;
        json["snap_angle_deg"] = snap_angle_deg;
        json["improve_below_deg"] = improve_below_deg;
        json["crease_deg"] = crease_deg;
        json["uncut_labels"] = uncut_labels;
        json["element_limit"] = element_limit;
        return json;
    }

    CutOptions read_options(const Json& json)
    {
        CutOptions options;
        if (const Json& subdivision = json.at("subdivision"); subdivision != kSubdivision)
            throw InputError("the subdivision is " + subdivision.dump()
                    + "; this version cuts adaptively only: replay the journal with the version that wrote it",
                "/options/subdivision");
        json.at("snap").get_to(options.snap);
        json.at("snap_angle_deg").get_to(options.snap_angle_deg);
        json.at("improve_below_deg").get_to(options.improve_below_deg);
        json.at("crease_deg").get_to(options.crease_deg);
        json.at("uncut_labels").get_to(options.uncut_labels);
        json.at("element_limit").get_to(options.element_limit);
        return options;
    }

    /// Number of equal entries at the beginning of two lists.
    std::size_t common(const std::vector<Vec3>& a, const std::vector<Vec3>& b)
    {
        std::size_t n = 0;
        while (n < a.size() && n < b.size()
            && std::memcmp(a[n].data(), b[n].data(), 3 * sizeof(double)) == 0) // compares bits: -0 differs from 0
            ++n;
        return n;
    }

    /// The blade of an operation as JSON. For a step, only the changes since the step before.
    Json written(const Blade& blade, const Blade* before)
    {
        Json json;
        const std::size_t points = before != nullptr ? common(before->line, blade.line) : 0,
                          directions = before != nullptr ? common(before->directions, blade.directions) : 0;
        if (before != nullptr)
            json["same_points"] = points;
        json["line"] = written(std::span(blade.line).subspan(points));
        if (before != nullptr)
            json["same_directions"] = directions;
        json["directions"] = written(std::span(blade.directions).subspan(directions));
        json["depth_mm"] = blade.depth_mm;
        json["above_mm"] = blade.above_mm;
        return json;
    }

    void take_over(const Json& json, const char* key, const std::vector<Vec3>& from, std::vector<Vec3>& to)
    {
        const std::size_t count = json.contains(key) ? json.at(key).get<std::size_t>() : 0;
        if (count > from.size())
            throw InputError(std::string(key) + " is more than the step before has");
        to.assign(from.begin(), from.begin() + static_cast<std::ptrdiff_t>(count));
    }

    Blade read_blade(const Json& json, const Blade& before)
    {
        Blade blade;
        take_over(json, "same_points", before.line, blade.line);
        read_points(json.at("line"), blade.line);
        take_over(json, "same_directions", before.directions, blade.directions);
        read_points(json.at("directions"), blade.directions);
        json.at("depth_mm").get_to(blade.depth_mm);
        json.at("above_mm").get_to(blade.above_mm);
        return blade;
    }

    /// Sorted ids as the first and last id of each run.
    Json written_ranges(std::span<const TetId> tets)
    {
        RETRACTOR_ASSERT(std::adjacent_find(tets.begin(), tets.end(), std::greater_equal<> {}) == tets.end());
        Json list = Json::array();
        for (std::size_t i = 0; i < tets.size();) {
            std::size_t last = i;
            while (last + 1 < tets.size() && tets[last + 1] == tets[last] + 1)
                ++last;
            list.push_back(tets[i]);
            list.push_back(tets[last]);
            i = last + 1;
        }
        return list;
    }

    std::vector<TetId> read_ranges(const Json& json, std::size_t slots)
    {
        const auto ends = json.get<std::vector<TetId>>();
        std::vector<TetId> tets;
        for (std::size_t i = 0; i < ends.size(); i += 2) {
            if (i + 1 == ends.size() || ends[i] < 0 || ends[i] > ends[i + 1]
                || static_cast<std::size_t>(ends[i + 1]) >= slots)
                throw InputError("\"tets\" are no ranges of elements that are there");
            for (TetId t = ends[i]; t <= ends[i + 1]; ++t)
                tets.push_back(t);
        }
        return tets;
    }

    /// Names of operations, in the order of CutEvent::Kind.
    constexpr std::array<const char*, 7> kOperations { "cut", "step", "end", "abandon", "ablate", "undo", "redo" };

    // ---- progress of a journal -------------------------------------------------------------------------------------

    /// The state that the next line depends on.
    struct Progress {
        std::uint64_t digest = 0, check = 0;
        std::optional<Blade> blade; ///< blade of the open stroke's last step
        CutOptions options; ///< options of the open stroke's last step
    };

    /// Adds the check to the line's object, and updates the progress.
    std::string finished_line(const Json& json, Progress& progress)
    {
        std::string line = json.dump();
        line.pop_back(); // the closing brace
        progress.check = check_after(progress.check, line);
        return line + ",\"check\":\"" + hexadecimal(progress.check) + "\"}\n";
    }

    Json head_of(const TetMesh& mesh)
    {
        return { { "journal", kName }, { "version", kCutJournalVersion }, { "frame", "LPS" }, { "units", "mm" },
            { "vertices", mesh.vertex_count() }, { "tets", mesh.tet_count() },
            { "mesh", hexadecimal(mesh_checksum(mesh)) } };
    }

    /// Updates the blade and the options that a further step may refer to.
    void follow(Progress& progress, const CutEvent& event)
    {
        RETRACTOR_ASSERT(event.delta != nullptr);
        if (event.kind == CutEvent::Kind::stroke_step) {
            progress.blade = *event.blade;
            progress.options = *event.options;
        } else {
            progress.blade.reset();
        }
        progress.digest = digest_after(progress.digest, *event.delta);
    }

    std::string operation_line(const CutEvent& event, Progress& progress)
    {
        Json json { { "do", kOperations.at(static_cast<std::size_t>(event.kind)) } };
        if (event.kind == CutEvent::Kind::cut) {
            json["blade"] = written(*event.blade, nullptr);
            json["options"] = written(*event.options);
        } else if (event.kind == CutEvent::Kind::stroke_step) {
            const Json options = written(*event.options);
            json["blade"] = written(*event.blade, progress.blade ? &*progress.blade : nullptr);
            if (!progress.blade || options != written(progress.options))
                json["options"] = options;
        } else if (event.kind == CutEvent::Kind::ablation) {
            json["tets"] = written_ranges(event.tets);
        }
        follow(progress, event);
        json["digest"] = hexadecimal(progress.digest);
        return finished_line(json, progress);
    }

    // ---- the file --------------------------------------------------------------------------------------------------

    class JournalFile {
    public:
        JournalFile(std::filesystem::path path, int flags)
            : path_(std::move(path))
            , file_(::open(path_.c_str(), flags | O_CLOEXEC, 0666))
        {
            if (file_ < 0)
                fail(errno == EEXIST ? "there is a journal of this name already" : "cannot open the journal", errno);
            if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
                const int error = errno;
                ::close(file_);
                fail(error == EWOULDBLOCK ? "another session is writing to this journal" : "cannot lock the journal",
                    error);
            }
        }
        ~JournalFile() { ::close(file_); }
        JournalFile(const JournalFile&) = delete;
        JournalFile& operator=(const JournalFile&) = delete;

        /// Drops the bytes beyond `size`; writing continues there.
        void truncate(std::size_t size)
        {
            if (::ftruncate(file_, static_cast<::off_t>(size)) != 0
                || ::lseek(file_, static_cast<::off_t>(size), SEEK_SET) < 0)
                fail("cannot shorten the journal", errno);
            size_ = size;
        }
        /// Writes the whole text to disk or nothing.
        void append(const std::string& text)
        {
            std::size_t done = 0;
            while (done < text.size()) {
                const ::ssize_t n = ::write(file_, text.data() + done, text.size() - done);
                if (n < 0 && errno == EINTR)
                    continue;
                if (n <= 0)
                    give_back("cannot write the journal", n < 0 ? errno : ENOSPC);
                done += static_cast<std::size_t>(n);
            }
            if (::fsync(file_) != 0)
                give_back("cannot flush the journal to disk", errno);
            size_ += text.size();
        }
        /// Whether the file was deleted. What is written to it then is lost.
        bool is_deleted() const
        {
            struct ::stat status { };
            return ::fstat(file_, &status) == 0 && status.st_nlink == 0;
        }
        /// Flushes the folder to disk, which holds the name of a new file.
        void sync_folder() const
        {
            const std::filesystem::path folder = path_.has_parent_path() ? path_.parent_path() : ".";
            const int handle = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
            if (handle < 0)
                fail("cannot flush the journal's name to disk", errno);
            const int result = ::fsync(handle), error = errno;
            ::close(handle);
            if (result != 0 && error != EINVAL) // EINVAL: the file system does not flush folders
                fail("cannot flush the journal's name to disk", error);
        }

    private:
        [[noreturn]] void fail(const std::string& what, int error) const
        {
            throw IoError(what + (error == EEXIST ? "" : std::string(": ") + std::strerror(error)), path_.string());
        }
        [[noreturn]] void give_back(const std::string& what, int error)
        {
            if (::ftruncate(file_, static_cast<::off_t>(size_)) == 0)
                static_cast<void>(::lseek(file_, static_cast<::off_t>(size_), SEEK_SET));
            fail(what, error);
        }

        std::filesystem::path path_;
        int file_;
        std::size_t size_ = 0;
    };

    // ---- reading and replaying -------------------------------------------------------------------------------------

    struct Lines {
        std::vector<std::string> lines;
        std::size_t whole = 0; ///< bytes of whole lines
        std::size_t torn = 0; ///< bytes after the whole lines
    };

    std::string content_of(const std::filesystem::path& path)
    {
        std::ifstream file(path, std::ios::binary);
        std::string text { std::istreambuf_iterator<char>(file), {} };
        if (!file)
            throw IoError("cannot read the journal", path.string());
        return text;
    }

    Lines read_lines(const std::filesystem::path& path)
    {
        const std::string text = content_of(path);
        Lines read;
        for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', read.whole)) {
            read.lines.push_back(text.substr(read.whole, end - read.whole));
            read.whole = end + 1;
        }
        read.torn = text.size() - read.whole;
        return read;
    }

    /// Parses a line, tests its check and removes the check.
    Json parse_line(const std::string& line, Progress& progress)
    {
        const std::string mark = ",\"check\":\"";
        const std::size_t end = mark.size() + 16 + 2;
        if (line.size() <= end || line.compare(line.size() - end, mark.size(), mark) != 0)
            throw InputError("the line is damaged: its end is not that of a journal's line");
        const std::string_view body = std::string_view(line).substr(0, line.size() - end);
        progress.check = check_after(progress.check, body);
        if (line.substr(body.size()) != mark + hexadecimal(progress.check) + "\"}")
            throw InputError("the line is damaged, or a line before it is missing: its check does not fit");
        return Json::parse(std::string(body) + "}");
    }

    void check_head(const Json& head, const TetMesh& mesh)
    {
        if (!head.is_object() || !head.contains("journal") || head.at("journal") != kName)
            throw InputError("this is no journal of cuts");
        if (const int version = head.at("version").get<int>(); version != kCutJournalVersion)
            // Another version's cutter would make other elements from the same operations.
            throw InputError("the journal has version " + std::to_string(version) + ", written by "
                + (version < kCutJournalVersion ? "an older" : "a newer") + " program; this program reads version "
                + std::to_string(kCutJournalVersion));
        for (const char* key : { "frame", "units", "vertices", "tets", "mesh" })
            if (const Json expected = head_of(mesh).at(key); head.at(key) != expected)
                throw InputError("the journal is of another mesh: its \"" + std::string(key) + "\" is "
                    + head.at(key).dump() + ", that of this mesh " + expected.dump());
    }

    class Replay {
    public:
        Replay(std::filesystem::path path, TetMesh mesh)
            : path_(std::move(path))
            , read_(read_lines(path_))
            , mesh_(std::move(mesh))
        {
        }
        ReplayedJournal run(const Job& job);
        std::size_t whole() const { return read_.whole; }
        const Progress& progress() const { return progress_; }

    private:
        template <class Work> void at_line(std::size_t i, Work&& work) const;
        void do_operation(CutSession& session, const Json& json, const Job& job);

        std::filesystem::path path_;
        Lines read_;
        TetMesh mesh_;
        Progress progress_;
        bool cancelled_ = false;
    };

    /// Runs `work` and adds the number of the line to its errors.
    template <class Work> void Replay::at_line(std::size_t i, Work&& work) const
    {
        const std::string where = path_.string() + ":" + std::to_string(i + 1);
        try {
            work();
        } catch (const Error& error) {
            throw InputError(error.what(), where + (error.where().empty() ? "" : " (" + error.where() + ")"));
        } catch (const Json::exception& error) {
            throw InputError(std::string("the line cannot be read: ") + error.what(), where);
        }
    }

    void Replay::do_operation(CutSession& session, const Json& json, const Job& job)
    {
        const auto name = json.at("do").get<std::string>();
        const auto digest = json.at("digest").get<std::string>();
        const auto options
            = [&] { return json.contains("options") ? read_options(json.at("options")) : progress_.options; };
        // The session's witness updates the progress, as it did when the journal was written.
        session.set_witness([&](const CutEvent& event) {
            follow(progress_, event);
            if (hexadecimal(progress_.digest) != digest)
                throw InputError("the operation \"" + name + "\" does not do what it did when the journal was written");
        });
        std::optional<CutResult> result;
        if (name == "cut")
            result = session.cut(read_blade(json.at("blade"), {}), options(), job);
        else if (name == "step")
            result = session.extend_stroke(
                read_blade(json.at("blade"), progress_.blade.value_or(Blade {})), options(), job);
        else if (name == "end")
            result = session.finish_stroke(job);
        else if (name == "abandon")
            static_cast<void>(session.abandon_stroke());
        else if (name == "ablate")
            result = session.ablate(read_ranges(json.at("tets"), session.tet_slots()), job);
        else if (name == "undo")
            static_cast<void>(session.undo());
        else if (name == "redo")
            static_cast<void>(session.redo());
        else
            throw InputError("unknown operation \"" + name + "\"");
        session.set_witness({});
        cancelled_ = result && result->status == CutStatus::cancelled;
        if (result && result->status == CutStatus::missed_body && name != "end")
            throw InputError("the operation \"" + name + "\" does not do what it did: " + result->message);
    }

    ReplayedJournal Replay::run(const Job& job)
    {
        if (read_.lines.empty())
            throw InputError("this is no journal of cuts: it has no whole line", path_.string());
        at_line(0, [&] { check_head(parse_line(read_.lines[0], progress_), mesh_); });
        ReplayedJournal replayed { .session = CutSession(std::move(mesh_)), .message = {} };
        for (std::size_t i = 1; i < read_.lines.size() && !cancelled_; ++i) {
            job.report("replay", static_cast<double>(i) / static_cast<double>(read_.lines.size()));
            at_line(i, [&] { do_operation(replayed.session, parse_line(read_.lines[i], progress_), job); });
            replayed.operations = i;
            cancelled_ = cancelled_ || job.cancelled();
        }
        if (cancelled_) {
            replayed.status = CutStatus::cancelled;
            replayed.message = "the replay was cancelled";
            return replayed;
        }
        const auto say
            = [&](const std::string& text) { replayed.message += (replayed.message.empty() ? "" : "; ") + text; };
        if (read_.torn > 0)
            say("line " + std::to_string(read_.lines.size() + 1) + " of the journal is incomplete ("
                + std::to_string(read_.torn) + " bytes): the operation that was under way is dropped");
        if (replayed.session.stroke_open())
            say("the last freehand stroke was left open");
        return replayed;
    }

} // namespace

/// A journal that is being written. The copies of a session share it.
struct Journal {
    std::filesystem::path path;
    std::unique_ptr<JournalFile> file; ///< null: not begun yet
    Progress progress;
    std::string whole {}; ///< every line, in case the file is deleted; empty in a strict journal
    std::string waiting {}; ///< lines that are not on the disk
    std::string reason {}; ///< see WaitingLines
    bool in_folder = false; ///< the folder's entry of the file is on the disk

    /// Writes what waits. @throws IoError: nothing is lost
    void write()
    {
        if (file != nullptr && file->is_deleted()) {
            file.reset();
            waiting = whole;
            in_folder = false;
        }
        if (file == nullptr) {
            // Only the last folder: where the case has gone, it does not come back by this.
            std::error_code ignored; // opening the file gives the reason
            std::filesystem::create_directory(path.parent_path(), ignored);
            file = std::make_unique<JournalFile>(path, O_WRONLY | O_CREAT | O_EXCL);
        }
        file->append(waiting);
        waiting.clear();
        if (!std::exchange(in_folder, true))
            file->sync_folder();
    }
    /// The same. @return whether it is written; if not, `reason` says why
    bool try_to_write()
    {
        try {
            write();
            reason.clear();
        } catch (const IoError&) {
            reason = to_string(current_failure());
        }
        return waiting.empty();
    }
};

namespace {

    /// The witnesses of sessions. The strict one refuses an operation that it cannot write.
    CutWitness strict_witness(std::shared_ptr<Journal> journal)
    {
        return [journal = std::move(journal)](const CutEvent& event) {
            Progress next = journal->progress;
            journal->file->append(operation_line(event, next));
            journal->progress = std::move(next);
        };
    }

    CutWitness patient_witness(std::shared_ptr<Journal> journal)
    {
        return [journal = std::move(journal)](const CutEvent& event) {
            const std::string line = operation_line(event, journal->progress);
            journal->whole += line;
            journal->waiting += line;
            journal->try_to_write();
        };
    }

    using MakeWitness = CutWitness (*)(std::shared_ptr<Journal>);

    /// @param journal set to the journal when the replay is done
    ReplayedJournal reopened(const std::filesystem::path& path, TetMesh mesh, MakeWitness witness,
        std::shared_ptr<Journal>& journal, const Job& job)
    {
        auto file = std::make_unique<JournalFile>(path, O_WRONLY);
        Replay replay(path, std::move(mesh));
        ReplayedJournal replayed = replay.run(job);
        if (replayed.status != CutStatus::done)
            return replayed;
        file->truncate(replay.whole());
        journal = std::make_shared<Journal>(
            Journal { .path = path, .file = std::move(file), .progress = replay.progress(), .in_folder = true });
        replayed.session.set_witness(witness(journal));
        return replayed;
    }

    /// A journal whose first line waits.
    std::shared_ptr<Journal> new_journal(const std::filesystem::path& path, const TetMesh& mesh)
    {
        auto journal = std::make_shared<Journal>(Journal { .path = path, .file = nullptr, .progress = {} });
        journal->waiting = finished_line(head_of(mesh), journal->progress);
        return journal;
    }

} // namespace

std::string WaitingLines::reason() const
{
    const std::shared_ptr<Journal> journal = journal_.lock();
    return journal != nullptr ? journal->reason : std::string();
}

bool WaitingLines::write()
{
    const std::shared_ptr<Journal> journal = journal_.lock();
    return journal == nullptr || journal->try_to_write();
}

std::uint64_t mesh_checksum(const TetMesh& mesh)
{
    Digest digest;
    digest.add(static_cast<std::uint64_t>(mesh.vertex_count()));
    digest.add(static_cast<std::uint64_t>(mesh.tet_count()));
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
        digest.add(Vec3(mesh.vertices.row(v)));
    for (const VertexId v : mesh.nodes)
        digest.add_id(v);
    for (const Label label : mesh.labels)
        digest.add_id(label);
    return digest.value();
}

CutSession start_journal(const std::filesystem::path& path, TetMesh mesh)
{
    const std::shared_ptr<Journal> journal = new_journal(path, mesh);
    CutSession session(std::move(mesh));
    journal->file = std::make_unique<JournalFile>(path, O_WRONLY | O_CREAT | O_EXCL);
    journal->write();
    session.set_witness(strict_witness(journal));
    return session;
}

CutSession start_patient_journal(const std::filesystem::path& path, TetMesh mesh, WaitingLines& waiting)
{
    if (std::filesystem::exists(path))
        throw IoError("there is a journal of this name already", path.string());
    const std::shared_ptr<Journal> journal = new_journal(path, mesh);
    journal->whole = journal->waiting;
    CutSession session(std::move(mesh));
    journal->try_to_write();
    session.set_witness(patient_witness(journal));
    waiting = WaitingLines(journal);
    return session;
}

ReplayedJournal replay_journal(const std::filesystem::path& path, TetMesh mesh, const Job& job)
{
    return Replay(path, std::move(mesh)).run(job);
}

ReplayedJournal open_journal(const std::filesystem::path& path, TetMesh mesh, const Job& job)
{
    std::shared_ptr<Journal> journal;
    return reopened(path, std::move(mesh), strict_witness, journal, job);
}

ReplayedJournal open_patient_journal(
    const std::filesystem::path& path, TetMesh mesh, WaitingLines& waiting, const Job& job)
{
    std::shared_ptr<Journal> journal;
    ReplayedJournal replayed = reopened(path, std::move(mesh), patient_witness, journal, job);
    if (journal != nullptr)
        journal->whole = content_of(path);
    waiting = WaitingLines(journal);
    return replayed;
}

} // namespace retractor::mesh
