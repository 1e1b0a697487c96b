#include "mesh/base/atomic_file.h"

#include "mesh/base/error.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace retractor {

namespace {

    namespace fs = std::filesystem;

    class FileDescriptor {
    public:
        explicit FileDescriptor(int fd)
            : fd_(fd)
        {
        }
        FileDescriptor(const FileDescriptor&) = delete;
        FileDescriptor& operator=(const FileDescriptor&) = delete;
        ~FileDescriptor()
        {
            if (fd_ >= 0)
                ::close(fd_);
        }
        int get() const { return fd_; }
        bool good() const { return fd_ >= 0; }

    private:
        int fd_;
    };

    std::string last_error() { return std::error_code(errno, std::generic_category()).message(); }

    [[noreturn]] void fail(const std::string& what, const fs::path& path) { throw IoError(what, path.string()); }

    // ---- temporary files -------------------------------------------------------------------------------------------

    constexpr const char* kMark = ".retractor-";

    /// The whole extension, such as ".nii.gz". Libraries choose their format by the whole extension; with ".gz" alone
    /// they would write beside the locked file.
    std::string whole_extension(const fs::path& path)
    {
        const std::string last = path.extension().string();
        return last == ".gz" ? path.stem().extension().string() + last : last;
    }

    /// Path of a temporary file, named ".<stem>.retractor-<process>-<count><extension>".
    fs::path temporary_beside(const fs::path& path)
    {
        static std::atomic<unsigned> counter { 0 };
        const std::string extension = whole_extension(path);
        const std::string whole = path.filename().string();
        std::string name("."); // appended to, because GCC 12 warns wrongly of overlap in "." + string
        name += whole.substr(0, whole.size() - extension.size()) + kMark + std::to_string(::getpid()) + "-"
            + std::to_string(counter.fetch_add(1));
        return path.parent_path() / (name + extension);
    }

    fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

    bool is_file_of(const fs::path& path, const FileDescriptor& file)
    {
        struct stat by_name { };
        struct stat by_descriptor { };
        return ::stat(path.c_str(), &by_name) == 0 && ::fstat(file.get(), &by_descriptor) == 0
            && by_name.st_ino == by_descriptor.st_ino && by_name.st_dev == by_descriptor.st_dev;
    }

    /// A writer holds a lock on its temporary file, and the lock ends with the process. Nobody locks the files that
    /// libraries put beside the temporary file. All files of a writer are leftovers when none of them is locked.
    void remove_leftovers_of_writer(const std::vector<fs::path>& paths)
    {
        std::vector<std::unique_ptr<FileDescriptor>> locked;
        for (const fs::path& path : paths) {
            locked.push_back(
                std::make_unique<FileDescriptor>(::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK)));
            if (!locked.back()->good() && errno == ENOENT)
                continue; // the writer has just finished
            if (!locked.back()->good() || ::flock(locked.back()->get(), LOCK_EX | LOCK_NB) != 0)
                return;
        }
        for (const fs::path& path : paths)
            ::unlink(path.c_str());
    }

    /// Removes the temporary files of writers that were killed; works once per process and folder.
    void remove_leftovers(const fs::path& folder)
    {
        static std::mutex mutex;
        static std::set<fs::path> cleaned;
        static const std::regex leftover("(\\..*\\.retractor-[0-9]+-[0-9]+)(\\..*)?");
        const std::lock_guard lock(mutex);
        if (!cleaned.insert(fs::absolute(folder)).second)
            return;
        std::map<std::string, std::vector<fs::path>> writers;
        std::error_code error;
        for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
            const std::string name = entry->path().filename().string();
            if (std::smatch match; std::regex_match(name, match, leftover))
                writers[match[1]].push_back(entry->path());
        }
        for (const auto& [writer, paths] : writers)
            remove_leftovers_of_writer(paths);
    }

    /// A new, locked file. `path` names this file until a library replaces the file.
    struct Temporary {
        explicit Temporary(const fs::path& made)
            : path(made)
            , file(::open(made.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666))
        {
            if (file.good())
                ::flock(file.get(), LOCK_EX | LOCK_NB); // on file systems without locks no leftovers are removed
        }
        fs::path path;
        FileDescriptor file;
    };

    std::unique_ptr<Temporary> make_temporary(const fs::path& target)
    {
        remove_leftovers(folder_of(target));
        constexpr int kAttempts = 8; // another process that is cleaning up may take the file for a leftover
        for (int attempt = 0; attempt < kAttempts; ++attempt) {
            auto made = std::make_unique<Temporary>(temporary_beside(target));
            if (!made->file.good() && errno != EEXIST)
                fail("cannot write: " + last_error(), target);
            if (!made->file.good())
                continue;
            if (is_file_of(made->path, made->file))
                return made;
        }
        fail("cannot make a temporary file beside it", target);
    }

    /// Removes the temporary file and the files that a library put beside it and named after it.
    void remove_with_companions(const fs::path& temporary)
    {
        const std::string name = temporary.filename().string();
        std::error_code error;
        for (fs::directory_iterator entry(folder_of(temporary), error), end; !error && entry != end;
             entry.increment(error))
            if (entry->path().filename().string().rfind(name, 0) == 0)
                ::unlink(entry->path().c_str());
    }

    // ---- failures --------------------------------------------------------------------------------------------------

    /// Libraries report that they failed, not why. The last block that they tried to write may have been this large
    /// (bytes).
    constexpr std::size_t kRoomAfterFailure = 1U << 16U;
    /// Some libraries do not notice that their last block found no room. The file then ends where the file system had
    /// to stop, so that no further byte can be written. A whole file that fills the disk to its last byte looks the
    /// same and is refused too.
    constexpr std::size_t kRoomAfterSuccess = 1;

    /// The reason why `room` more bytes cannot be written to this file, or nothing when they can be written. The
    /// function writes the bytes as zeros and cuts the file back to its length.
    std::optional<std::string> why_full(const FileDescriptor& file, std::size_t room)
    {
        static const std::array<char, kRoomAfterFailure> zeros {};
        struct stat status { };
        if (::fstat(file.get(), &status) != 0)
            return last_error();
        std::size_t done = 0;
        std::optional<std::string> reason;
        while (done < room && !reason) {
            const ssize_t n
                = ::pwrite(file.get(), zeros.data(), room - done, status.st_size + static_cast<off_t>(done));
            if (n > 0)
                done += static_cast<std::size_t>(n);
            else if (errno != EINTR)
                reason = last_error();
        }
        if (::ftruncate(file.get(), status.st_size) != 0 && !reason)
            reason = last_error();
        return reason;
    }

    /// Flushes a file or folder to disk; returns the system's reason when flushing fails.
    std::optional<std::string> flush_to_disk(const FileDescriptor& file)
    {
        // Some file systems cannot flush a folder and report EINVAL or ENOTSUP.
        if (file.good() && (::fsync(file.get()) == 0 || errno == EINVAL || errno == ENOTSUP))
            return std::nullopt;
        return last_error();
    }

    void write_all(const FileDescriptor& file, std::string_view content, const fs::path& named)
    {
        while (!content.empty()) {
            const ssize_t n = ::write(file.get(), content.data(), content.size());
            if (n < 0 && errno != EINTR)
                fail("cannot write: " + last_error(), named);
            if (n > 0)
                content.remove_prefix(static_cast<std::size_t>(n));
        }
    }

    void publish(const fs::path& temporary, const fs::path& path)
    {
        const FileDescriptor file(::open(temporary.c_str(), O_RDONLY | O_CLOEXEC));
        if (const auto reason = flush_to_disk(file))
            fail("cannot flush it to disk: " + *reason, path);
        const FileDescriptor folder(::open(folder_of(path).c_str(), O_RDONLY | O_CLOEXEC | O_DIRECTORY));
        if (!folder.good())
            fail("cannot open its folder: " + last_error(), path);
        std::error_code code;
        fs::rename(temporary, path, code);
        if (code)
            fail("cannot rename the finished file: " + code.message(), path);
        if (const auto reason = flush_to_disk(folder)) // the name must survive a power cut too
            fail("the new file is in place, but its name cannot be flushed to disk: " + *reason, path);
    }

    void run_writer(
        const Temporary& temporary, const fs::path& path, const std::function<void(const fs::path& temporary)>& write)
    {
        try {
            write(temporary.path);
        } catch (const IoError& error) {
            const std::optional<std::string> reason = why_full(temporary.file, kRoomAfterFailure);
            fail(error.what() + (reason ? ": " + *reason : std::string()), path);
        }
        std::error_code code;
        if (fs::file_size(temporary.path, code) == 0 || code)
            fail("nothing was written", path);
        if (const std::optional<std::string> reason = why_full(temporary.file, kRoomAfterSuccess); reason)
            if (is_file_of(temporary.path, temporary.file))
                fail("cannot write: " + *reason, path);
    }

    /// Makes a temporary file, lets `fill` write it, and renames it to `path`. Removes it when anything fails.
    template <class Fill> void write_beside(const fs::path& path, Fill&& fill)
    {
        const std::unique_ptr<Temporary> temporary = make_temporary(path);
        try {
            fill(*temporary);
            publish(temporary->path, path);
        } catch (...) {
            remove_with_companions(temporary->path);
            throw;
        }
    }

} // namespace

void write_file_atomically(const fs::path& path, const std::function<void(const fs::path& temporary)>& write)
{
    write_beside(path, [&](const Temporary& temporary) { run_writer(temporary, path, write); });
}

void write_file_atomically(const fs::path& path, std::string_view content)
{
    write_beside(path, [&](const Temporary& temporary) { write_all(temporary.file, content, path); });
}

} // namespace retractor
