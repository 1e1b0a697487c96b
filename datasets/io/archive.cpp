#include "datasets/io/archive.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <archive.h>
#include <archive_entry.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    constexpr std::size_t kBlock = std::size_t { 1 } << 16U;
    constexpr double kGiB = 1073741824.0;

    using Reader = std::unique_ptr<archive, int (*)(archive*)>;

    std::string reason(archive* reader)
    {
        const char* text = archive_error_string(reader);
        return text != nullptr ? text : "no reason given";
    }

    Reader open_archive(const fs::path& file)
    {
        Reader reader(archive_read_new(), archive_read_free);
        archive_read_support_format_zip(reader.get());
        if (archive_read_open_filename(reader.get(), file.c_str(), kBlock) != ARCHIVE_OK)
            throw InputError("the archive is damaged, or no ZIP archive: " + reason(reader.get()), file.string());
        return reader;
    }

    /// The place of an entry in the folder. @throws InputError when its name leads elsewhere
    fs::path place_of(archive_entry* entry, const fs::path& folder, const std::string& where)
    {
        const char* name = archive_entry_pathname_utf8(entry);
        if (name == nullptr)
            name = archive_entry_pathname(entry);
        if (name == nullptr || *name == '\0')
            throw InputError("an entry of the archive has no name", where);
        const std::string text = name;
        const fs::path path(text);
        bool leads_out = path.is_absolute() || text.find('\\') != std::string::npos;
        for (const fs::path& part : path)
            leads_out = leads_out || part == "..";
        if (leads_out)
            throw InputError(
                "the archive holds a file that would be written outside its folder (\"" + text + "\"); do not trust it",
                where);
        return folder / path.lexically_normal();
    }

    void make_folder(const fs::path& folder)
    {
        std::error_code code;
        fs::create_directories(folder, code);
        if (code)
            throw IoError("cannot make the folder: " + code.message(), folder.string());
    }

    /// Counts what was unpacked against the limits.
    class Counter {
    public:
        Counter(const UnpackLimits& limits, std::uint64_t archive_bytes, std::string where)
            : limits_(limits)
            , most_(std::min(limits.bytes, limits.expansion * archive_bytes))
            , where_(std::move(where))
        {
        }
        void add_file()
        {
            if (++files_ > limits_.files)
                throw InputError(
                    "the archive holds more than " + std::to_string(limits_.files) + " files: no study does", where_);
        }
        void add_bytes(std::size_t bytes)
        {
            bytes_ += bytes;
            if (bytes_ > most_)
                throw InputError("the archive unpacks to more than " + in_words(static_cast<double>(most_) / kGiB, 1)
                        + " GiB: it is damaged or malicious",
                    where_);
        }

    private:
        const UnpackLimits& limits_;
        std::uint64_t most_;
        std::string where_;
        std::size_t files_ = 0;
        std::uint64_t bytes_ = 0;
    };

    void unpack_file(archive* reader, const fs::path& file, Counter& counter, const std::string& where, const Job& job)
    {
        make_folder(file.parent_path());
        std::ofstream out(file, std::ios::binary);
        std::vector<char> block(kBlock);
        while (!job.cancelled()) {
            const la_ssize_t count = archive_read_data(reader, block.data(), block.size());
            if (count < 0)
                throw InputError("the archive is damaged: " + reason(reader), where);
            if (count == 0)
                break;
            counter.add_bytes(static_cast<std::size_t>(count));
            out.write(block.data(), count);
            if (!out)
                throw IoError("cannot write the unpacked file; is the disk full?", file.string());
        }
        out.close();
        if (!out)
            throw IoError("cannot write the unpacked file; is the disk full?", file.string());
    }

} // namespace

bool is_zip_archive(const fs::path& file)
{
    std::ifstream in(file, std::ios::binary);
    if (!in)
        throw IoError("cannot read the file", file.string());
    std::array<char, 4> magic {};
    in.read(magic.data(), magic.size());
    return in && magic == std::array { 'P', 'K', '\3', '\4' };
}

void unpack_zip(const fs::path& archive_file, const fs::path& folder, const Job& job, const UnpackLimits& limits)
{
    const std::string where = archive_file.string();
    std::error_code code;
    const std::uint64_t archive_bytes = fs::file_size(archive_file, code);
    if (code)
        throw IoError("cannot read the archive: " + code.message(), where);
    const Reader reader = open_archive(archive_file);
    Counter counter(limits, archive_bytes, where);
    for (archive_entry* entry = nullptr; !job.cancelled();) {
        const int status = archive_read_next_header(reader.get(), &entry);
        if (status == ARCHIVE_EOF)
            return;
        if (status != ARCHIVE_OK && status != ARCHIVE_WARN)
            throw InputError("the archive is damaged, or no ZIP archive: " + reason(reader.get()), where);
        const fs::path file = place_of(entry, folder, where);
        job.report("unpack",
            static_cast<double>(archive_filter_bytes(reader.get(), -1))
                / static_cast<double>(std::max<std::uint64_t>(archive_bytes, 1)));
        if (archive_entry_filetype(entry) == AE_IFDIR)
            continue;
        if (archive_entry_is_encrypted(entry) != 0)
            throw InputError("the archive is encrypted: unpack it first, and import the folder", where);
        if (archive_entry_filetype(entry) != AE_IFREG)
            throw InputError(
                "the archive holds a link or a device (\"" + file.filename().string() + "\"); do not trust it", where);
        counter.add_file();
        unpack_file(reader.get(), file, counter, where, job);
    }
}

UnpackedArchive::UnpackedArchive(const fs::path& archive, const Job& job)
{
    std::string name = (fs::temp_directory_path() / "retractor-study-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
        throw IoError("cannot make a folder for the archive's files", fs::temp_directory_path().string());
    folder_ = name;
    try {
        unpack_zip(archive, folder_, job);
    } catch (...) {
        std::error_code ignored;
        fs::remove_all(folder_, ignored);
        throw;
    }
}

UnpackedArchive::~UnpackedArchive()
{
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
}

} // namespace retractor::datasets
