#include "mesh/base/atomic_file.h"

#include "mesh/base/error.h"

#include <atomic>
#include <fstream>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

namespace retractor {

namespace {

    namespace fs = std::filesystem;

    /// Unique within the machine: several writers of one target must not share a temporary file.
    fs::path temporary_beside(const fs::path& path)
    {
        static std::atomic<unsigned> counter { 0 };
        std::string stem("."); // appended to, because GCC 12 warns wrongly of overlap in "." + string
        stem += path.stem().string() + "." + std::to_string(::getpid()) + "." + std::to_string(counter.fetch_add(1));
        return path.parent_path() / (stem + path.extension().string());
    }

    void flush_to_disk(const fs::path& path)
    {
        const int fd = ::open(path.c_str(), O_RDONLY);
        if (fd < 0 || ::fsync(fd) != 0) {
            if (fd >= 0)
                ::close(fd);
            throw IoError("cannot flush the file to disk", path.string());
        }
        ::close(fd);
    }

} // namespace

void write_file_atomically(
    const fs::path& path, const std::function<void(const fs::path& temporary)>& write)
{
    const fs::path temporary = temporary_beside(path);
    try {
        write(temporary);
        if (!fs::exists(temporary))
            throw IoError("nothing was written", path.string());
        flush_to_disk(temporary);
        std::error_code code;
        fs::rename(temporary, path, code);
        if (code)
            throw IoError("cannot rename the finished file: " + code.message(), path.string());
    } catch (...) {
        std::error_code ignored;
        fs::remove(temporary, ignored);
        throw;
    }
}

void write_file_atomically(const fs::path& path, std::string_view content)
{
    write_file_atomically(path, [&](const fs::path& temporary) {
        std::ofstream out(temporary, std::ios::binary);
        out.write(content.data(), static_cast<std::streamsize>(content.size()));
        out.flush();
        if (!out)
            throw IoError("cannot write (is the folder there and writable, the disk not full?)", path.string());
    });
}

} // namespace retractor
