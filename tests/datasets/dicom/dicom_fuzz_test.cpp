// Damaged files: whatever the bytes, reading ends in a volume or in an Error.

#include "datasets/dicom/dicom.h"

#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"
#include "tests/datasets/dicom/dicom_bytes.h"
#include "tests/support/temporary_folder.h"

#include <iterator>
#include <random>

namespace retractor::datasets {
namespace dicom_fuzz_test {

    namespace fs = std::filesystem;

    struct Outcomes {
        int read = 0;
        int refused = 0;
    };

    /// Reads `path` with the file `damaged` cut short or with some bytes changed, `tries` times.
    Outcomes damage_and_read(const fs::path& path, const fs::path& damaged, int tries, unsigned seed)
    {
        std::ifstream in(damaged, std::ios::binary);
        const std::string good { std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>() };
        // --gtest_shuffle --gtest_repeat=N gives N different runs.
        std::mt19937 random(seed + 1000U * static_cast<unsigned>(testing::UnitTest::GetInstance()->random_seed()));
        const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
        constexpr std::size_t kPreamble = 132;
        constexpr std::size_t kTags = 4096; // most changes where they hurt
        Outcomes outcomes;
        for (int t = 0; t < tries; ++t) {
            std::string bytes = good;
            const std::size_t reach = (t % 3 == 0 ? bytes.size() : std::min(bytes.size(), kTags)) - kPreamble;
            if (t % 4 == 0)
                bytes.resize(below(bytes.size()));
            else
                for (std::size_t flips = t % 2 == 0 ? 1 : 1 + below(20); flips > 0; --flips)
                    bytes[kPreamble + below(reach)] = static_cast<char>(below(256));
            test_support::write_bytes(damaged, bytes);
            try {
                const mesh::Volume volume = read_dicom(path).volume;
                EXPECT_EQ(volume.voxels.size(), volume.grid.voxel_count());
                ++outcomes.read;
            } catch (const Error&) {
                ++outcomes.refused;
            }
        }
        EXPECT_EQ(outcomes.read + outcomes.refused, tries);
        return outcomes;
    }

    TEST(DicomFuzz, DamagedSeriesEndsInAVolumeOrAnError)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 3);
        constexpr int kTries = 600;
        const Outcomes outcomes = damage_and_read(folder / "ct", folder / "ct/02.dcm", kTries, 20);
        EXPECT_GT(outcomes.read, kTries / 20) << "damage to pixels and free text cannot be seen";
        EXPECT_GT(outcomes.refused, kTries / 5);
    }

    TEST(DicomFuzz, DamagedMultiFrameEndsInAVolumeOrAnError)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_bytes(folder / "enhanced",
            test_support::dicom_file(
                test_support::enhanced_ct({ 0, 3, 6 }, { 1, 1, 1 }), test_support::kEnhancedCtStorage));
        constexpr int kTries = 600;
        const Outcomes outcomes = damage_and_read(folder / "enhanced", folder / "enhanced", kTries, 21);
        EXPECT_GT(outcomes.read, kTries / 20);
        EXPECT_GT(outcomes.refused, kTries / 5);
    }

    TEST(DicomFuzz, DamagedCompressionEndsInAVolumeOrAnError)
    {
        const fs::path images = test_support::shared_data("bad/wg04_transfer_syntaxes");
        if (!fs::exists(images))
            GTEST_SKIP() << "no shared data at " << images;
        const test_support::TemporaryFolder folder;
        unsigned seed = 30;
        for (const char* image : { "CT1_RLE", "CT1_JPLL", "CT1_JLSL", "CT1_J2KR" }) {
            fs::copy(images / image, folder / image);
            constexpr int kTries = 30; // a decoded slice takes some 20 ms
            const Outcomes outcomes = damage_and_read(folder / image, folder / image, kTries, ++seed);
            EXPECT_GT(outcomes.refused, kTries / 10) << image;
        }
    }

    TEST(DicomFuzz, CutCompressedPixelsAreRefused)
    {
        const fs::path images = test_support::shared_data("bad/wg04_transfer_syntaxes");
        if (!fs::exists(images))
            GTEST_SKIP() << "no shared data at " << images;
        const test_support::TemporaryFolder folder;
        for (const char* image : { "CT1_RLE", "CT1_JPLL", "CT1_JLSL", "CT1_J2KR" })
            for (const std::uintmax_t bytes : { 9U, 200U, 20000U }) {
                fs::copy_file(images / image, folder / image, fs::copy_options::overwrite_existing);
                fs::resize_file(folder / image, fs::file_size(folder / image) - bytes);
                test_support::expect_refused<InputError>([&] { read_dicom(folder / image); }, "truncated");
            }
    }

    TEST(DicomFuzz, SequencesNestedWithoutEndAreRefused)
    {
        const test_support::TemporaryFolder folder;
        constexpr int kLevels = 200000; // would need some hundred megabytes of stack
        for (const bool defined : { false, true }) {
            const std::string good = test_support::dicom_file(test_support::ct_slice(0.0, 1));
            const std::size_t pixels = good.find("\xE0\x7F\x10");
            std::string nested;
            constexpr int kLevelBytes = 20;
            for (int level = 0; level < kLevels; ++level) {
                const std::int64_t rest = std::int64_t { kLevelBytes } * (kLevels - level);
                nested += test_support::DicomBytes::number(0x0040, 2) + test_support::DicomBytes::number(0xA730, 2)
                    + std::string("SQ\0\0", 4) + test_support::DicomBytes::number(defined ? rest - 12 : 0xFFFFFFFF, 4)
                    + test_support::DicomBytes::number(0xE000FFFE, 4)
                    + test_support::DicomBytes::number(defined ? rest - kLevelBytes : 0xFFFFFFFF, 4);
            }
            test_support::write_bytes(folder / "deep", good.substr(0, pixels) + nested + good.substr(pixels));
            test_support::expect_refused<InputError>([&] { read_dicom(folder / "deep"); }, "damaged DICOM file");
        }
    }

} // namespace dicom_fuzz_test
} // namespace retractor::datasets
