#include "datasets/io/archive.h"

#include "mesh/base/error.h"

#include <archive.h>
#include <archive_entry.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

namespace retractor::datasets {
namespace archive_test {

    namespace fs = std::filesystem;

    struct Entry {
        std::string name, content {};
        unsigned type = AE_IFREG;
    };

    class Archive : public testing::Test {
    protected:
        void SetUp() override
        {
            folder_ = fs::path(testing::TempDir()) / "archive";
            fs::remove_all(folder_);
            fs::create_directories(folder_);
        }
        fs::path zip_of(const std::vector<Entry>& entries)
        {
            const fs::path file = folder_ / "study.zip";
            archive* writer = archive_write_new();
            archive_write_set_format_zip(writer);
            EXPECT_EQ(archive_write_open_filename(writer, file.c_str()), ARCHIVE_OK);
            for (const Entry& each : entries) {
                archive_entry* entry = archive_entry_new();
                archive_entry_set_pathname(entry, each.name.c_str());
                archive_entry_set_filetype(entry, each.type);
                archive_entry_set_perm(entry, 0644);
                if (each.type == AE_IFLNK)
                    archive_entry_set_symlink(entry, each.content.c_str());
                else
                    archive_entry_set_size(entry, static_cast<la_int64_t>(each.content.size()));
                EXPECT_EQ(archive_write_header(writer, entry), ARCHIVE_OK);
                if (each.type == AE_IFREG)
                    archive_write_data(writer, each.content.data(), each.content.size());
                archive_entry_free(entry);
            }
            archive_write_free(writer);
            return file;
        }
        fs::path out() const { return folder_ / "out"; }
        static std::string text_of(const fs::path& file)
        {
            std::ifstream in(file, std::ios::binary);
            return { std::istreambuf_iterator<char>(in), {} };
        }
        std::string refusal(const fs::path& file, const UnpackLimits& limits = {})
        {
            try {
                unpack_zip(file, out(), {}, limits);
            } catch (const InputError& error) {
                return error.what();
            }
            return {};
        }
        fs::path folder_;
    };

    TEST_F(Archive, FilesAndFoldersComeOutAsTheyWere)
    {
        const std::string binary { "\0\1\2\377DICM", 8 };
        const fs::path file
            = zip_of({ { "disc/", {}, AE_IFDIR }, { "disc/images/1", binary }, { "DICOMDIR", "a list" } });
        EXPECT_TRUE(is_zip_archive(file));
        unpack_zip(file, out());
        EXPECT_EQ(text_of(out() / "disc" / "images" / "1"), binary);
        EXPECT_EQ(text_of(out() / "DICOMDIR"), "a list");
    }

    TEST_F(Archive, NothingIsWrittenOutsideTheFolder)
    {
        for (const char* name : { "../outside", "images/../../outside", "/tmp/outside", "..\\outside" }) {
            EXPECT_NE(refusal(zip_of({ { name, "evil" } })).find("outside its folder"), std::string::npos) << name;
            EXPECT_FALSE(fs::exists(folder_ / "outside")) << name;
        }
        EXPECT_NE(refusal(zip_of({ { "link", "/etc", AE_IFLNK } })).find("link"), std::string::npos);
        EXPECT_FALSE(fs::exists(out() / "link"));
    }

    TEST_F(Archive, ASmallFileDoesNotFillTheDisk)
    {
        const fs::path bomb = zip_of({ { "zeros", std::string(4U << 20U, '\0') } });
        EXPECT_LT(fs::file_size(bomb), 40000U) << "a bomb is small";
        EXPECT_NE(refusal(bomb, { .expansion = 50 }).find("unpacks to more"), std::string::npos);
        EXPECT_NE(
            refusal(bomb, { .bytes = 1U << 20U, .expansion = 1000000 }).find("unpacks to more"), std::string::npos);
        EXPECT_NE(refusal(zip_of({ { "1", "a" }, { "2", "b" } }), { .files = 1 }).find("files"), std::string::npos);
    }

    TEST_F(Archive, DamageAndOtherFilesAreNamed)
    {
        const fs::path file = zip_of({ { "one", std::string(5000, 'x') + std::string(5000, 'y') } });
        std::string bytes = text_of(file);
        std::ofstream(file, std::ios::binary) << bytes.substr(0, bytes.size() / 3);
        EXPECT_NE(refusal(file).find("damaged"), std::string::npos) << refusal(file);
        std::ofstream(folder_ / "text.zip") << "this is no archive at all";
        EXPECT_FALSE(is_zip_archive(folder_ / "text.zip"));
        EXPECT_NE(refusal(folder_ / "text.zip"), "");
        EXPECT_THROW(unpack_zip(folder_ / "none.zip", out()), IoError);
    }

    TEST_F(Archive, ACancelledJobStops)
    {
        std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        unpack_zip(zip_of({ { "one", "1" } }), out(), job);
        EXPECT_FALSE(fs::exists(out() / "one"));
    }

} // namespace archive_test
} // namespace retractor::datasets
