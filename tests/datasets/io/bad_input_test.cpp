// Files that are wrong: each is refused with its reason or read right, whatever is broken.

#include "datasets/io/image_reader.h"
#include "datasets/io/volume_io.h"
#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"
#include "tests/support/temporary_folder.h"

#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkXMLImageDataWriter.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>

namespace retractor::datasets {
namespace bad_input_test {

    namespace fs = std::filesystem;

    std::string bytes_of(const fs::path& path)
    {
        std::ifstream file(path, std::ios::binary);
        return { std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>() };
    }

    void write_bytes(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

    void expect_equal(const mesh::Volume& a, const mesh::Volume& b)
    {
        EXPECT_EQ(a.grid.size, b.grid.size);
        EXPECT_EQ(a.grid.origin, b.grid.origin);
        EXPECT_EQ(a.grid.spacing, b.grid.spacing);
        EXPECT_EQ(a.grid.direction, b.grid.direction);
        EXPECT_EQ(a.voxels, b.voxels);
    }

    /// Every file of a folder has an expectation: a part of the reason why it is refused, or "" when it is read.
    void expect_outcomes(const fs::path& folder, const std::map<std::string, std::string>& reasons)
    {
        std::size_t tested = 0;
        for (const auto& entry : fs::directory_iterator(folder)) {
            const std::string name = entry.path().filename().string();
            SCOPED_TRACE(name);
            const auto found = reasons.find(name);
            ASSERT_NE(found, reasons.end()) << "a file without an expectation";
            ++tested;
            if (found->second.empty())
                EXPECT_NO_THROW(import_volume(entry.path()));
            else
                test_support::expect_refused<InputError>([&] { import_volume(entry.path()); }, found->second);
        }
        std::cout << "[   INFO   ] tested " << tested << " files of " << folder.filename().string() << '\n';
        EXPECT_EQ(tested, reasons.size());
    }

    TEST(BadInput, MalformedVolumes)
    {
        const fs::path folder = test_support::shared_data("bad/malformed_volumes");
        if (!fs::exists(folder))
            GTEST_SKIP() << "no shared data at " << folder;
        expect_outcomes(folder,
            {
                { "bad_crc.nii.gz", "damaged" },
                { "bad_magic.nii", "magic is missing" },
                { "bitpix_mismatch.nii", "bitpix 8 contradicts datatype 4" },
                { "crlf_header.nrrd", "" },
                { "empty.nii", "cut short" },
                { "huge_dims.mha", "more voxels than an image can have" },
                { "left_handed_negdet.nii", "" },
                { "missing_raw.mhd", "missing: \"missing.raw\"" },
                { "nan_pixdim.nii", "pixdim[1] must be positive" },
                { "nan_slope.nii", "scl_slope" },
                { "negative_dim.nii", "dim[1] must be positive, got -20" },
                { "no_blank_line.nrrd", "no blank line" },
                { "no_qform_no_sform.nii", "neither qform nor sform" },
                { "not_gzip.nii.gz", "not gzip-compressed" },
                { "ok_small.mha", "" },
                { "ok_small.nii", "" },
                { "ok_small.nii.gz", "" },
                { "ok_small.nrrd", "" },
                { "qform_sform_disagree.nii", "qform and sform disagree" },
                { "short_pixels.mha", "promises 128 bytes, there are 40" },
                { "singular_sform.nii", "spacing along axis 1" },
                { "size_overflow.nrrd", "more voxels than an image can have" },
                { "truncated_header.nii", "cut short" },
                { "unknown_datatype.nii", "datatype 9999" },
                { "vox_offset_past_end.nii", "cut short" },
                { "zero_pixdim.nii", "pixdim[1] must be positive" },
                { "zero_spacing.mha", "ElementSpacing" },
            });
        const mesh::Volume nifti = read_volume(folder / "ok_small.nii");
        expect_equal(read_volume(folder / "ok_small.nii.gz"), nifti);
        EXPECT_EQ(nifti.grid.size, (std::array<int, 3> { 20, 18, 16 }));
        EXPECT_EQ(nifti.grid.spacing, Vec3(1.5, 1.5, 2.0));
        EXPECT_EQ(nifti.grid.direction, Mat3(Vec3(-1, -1, 1).asDiagonal())); // RAS in the file
        const mesh::Volume mirrored = read_volume(folder / "left_handed_negdet.nii");
        EXPECT_EQ(mirrored.grid.direction, Mat3(Vec3(1, -1, 1).asDiagonal()));
        EXPECT_EQ(mirrored.voxels, nifti.voxels);
        const mesh::Volume nrrd = read_volume(folder / "ok_small.nrrd");
        expect_equal(read_volume(folder / "ok_small.mha"), nrrd);
        expect_equal(read_volume(folder / "crlf_header.nrrd"), nrrd);
        EXPECT_EQ(nrrd.grid.spacing, Vec3(1.0, 1.0, 2.0));
        for (std::size_t v = 0; v < nrrd.voxels.size(); ++v)
            ASSERT_EQ(nrrd.voxels[v], static_cast<std::int16_t>(v));
    }

    TEST(BadInput, NrrdEncodings)
    {
        constexpr std::int16_t kBall = 257; // 0 outside
        const fs::path folder = test_support::shared_data("bad/nrrd_pynrrd");
        if (!fs::exists(folder))
            GTEST_SKIP() << "no shared data at " << folder;
        std::map<std::string, std::string> reasons {
            { "BallBinary30x30x30.nii.gz", "" },
            { "BallBinary30x30x30.raw", "unknown image format" }, // the data of the detached headers
            { "BallBinary30x30x30_byteskip_minus_five.nhdr", "must not be negative" },
            { "BallBinary30x30x30_nifti.nhdr", "352 bytes more than the header promises" },
            { "test1d_ascii.nrrd", "it has 1 dimension(s)" },
            { "test2d_ascii.nrrd", "it has 2 dimension(s)" },
            { "test_customFields.nrrd", "it has 1 dimension(s)" },
            { "test_simple4d_raw.nrrd", "it has 4 dimension(s)" },
        };
        const std::vector<std::string> balls { "BallBinary30x30x30.nhdr", "BallBinary30x30x30.nrrd",
            "BallBinary30x30x30_byteskip_minus_one.nhdr", "BallBinary30x30x30_byteskip_minus_one_nifti.nhdr",
            "BallBinary30x30x30_bz2.nrrd", "BallBinary30x30x30_gz.nrrd",
            "BallBinary30x30x30_gz_byteskip_minus_one.nrrd", "BallBinary30x30x30_gz_lineskip.nrrd" };
        for (const std::string& name : balls)
            reasons[name] = "";
        expect_outcomes(folder, reasons);
        const mesh::Volume ball = read_volume(folder / "BallBinary30x30x30.nrrd");
        EXPECT_EQ(ball.grid.size, (std::array<int, 3> { 30, 30, 30 }));
        const auto inside = std::count(ball.voxels.begin(), ball.voxels.end(), kBall);
        EXPECT_EQ(inside + std::count(ball.voxels.begin(), ball.voxels.end(), 0), 30 * 30 * 30);
        EXPECT_GT(inside, 1000);
        for (const std::string& name : balls) {
            SCOPED_TRACE(name);
            expect_equal(read_volume(folder / name), ball);
        }
        EXPECT_EQ(read_volume(folder / "BallBinary30x30x30.nii.gz").voxels, ball.voxels);
    }

    // A small bad set of our own: one file for each way to be wrong.

    /// An NRRD of 2 x 2 x 1 int16 zeros with one line of the header replaced (or left out, or added).
    std::string nrrd_with(const std::string& field, const std::string& value, const std::string& data = "")
    {
        std::vector<std::pair<std::string, std::string>> lines { { "type", "short" }, { "dimension", "3" },
            { "space", "left-posterior-superior" }, { "sizes", "2 2 1" },
            { "space directions", "(1,0,0) (0,1,0) (0,0,2)" }, { "endian", "little" }, { "encoding", "raw" },
            { "space origin", "(0,0,0)" } };
        const auto at = std::find_if(lines.begin(), lines.end(), [&](const auto& line) { return line.first == field; });
        if (at == lines.end())
            lines.emplace_back(field, value);
        else
            at->second = value;
        std::string text = "NRRD0004\n";
        for (const auto& [name, content] : lines)
            if (!content.empty())
                text += name + ": " + content + "\n";
        return text + "\n" + (data.empty() ? std::string(8, '\0') : data);
    }

    TEST(BadInput, OwnNrrdFiles)
    {
        const test_support::TemporaryFolder folder;
        const auto refused = [&](const std::string& bytes, const std::string& reason) {
            write_bytes(folder / "x.nrrd", bytes);
            test_support::expect_refused<InputError>([&] { import_volume(folder / "x.nrrd"); }, reason);
        };
        write_bytes(folder / "x.nrrd", nrrd_with("content", "nothing wrong"));
        EXPECT_EQ(import_volume(folder / "x.nrrd").volume.voxels.size(), 4U);
        refused("", "not an NRRD file");
        refused("NRRD0009\n\n", "not an NRRD file");
        refused(std::string("NRRD0004\n\0\0\0", 12), "no text header");
        refused("NRRD0004\ntype short\n\n", "no field");
        refused(nrrd_with("type", ""), "no field \"type\"");
        refused(nrrd_with("type", "block"), "\"block\"");
        refused(nrrd_with("dimension", "three"), "\"dimension\" must be a whole number");
        refused(nrrd_with("dimension", "4"), "\"sizes\" must have one entry per axis");
        refused(nrrd_with("sizes", "2 -2 1"), "size along axis 2");
        refused(nrrd_with("sizes", "2 2.5 1"), "size along axis 2");
        refused(nrrd_with("sizes", "2 2 nan"), "size along axis 3");
        refused(nrrd_with("sizes", "200000 200000 200000"), "more voxels than an image can have");
        refused(nrrd_with("sizes", "20000 20000 100"), "cut short");
        refused(nrrd_with("sizes", "2 2 2"), "promises 16 bytes, there are 8");
        refused(nrrd_with("Sizes", "2 2 1"), "given twice");
        refused(nrrd_with("space", "scanner-xyz"), "no patient frame");
        refused(nrrd_with("space directions", ""), "neither \"space directions\" nor \"spacings\"");
        refused(nrrd_with("space directions", "(1,0,0) (0,1,0) (0,0,0)"), "spacing along axis 3");
        refused(nrrd_with("space directions", "(1,0,0) (0,1,0) (0,0,nan)"), "not finite");
        refused(nrrd_with("space directions", "(1,0,0) (0,1,0) (0.1,0,1)"), "sheared");
        refused(nrrd_with("space directions", "(1,0,0) (0,1,0) none"), "three-dimensional");
        refused(nrrd_with("space directions", "(1,0,0) (0,1,0)"), "one entry per axis");
        refused(nrrd_with("space directions", "(1,0) (0,1)"), "three numbers");
        refused(nrrd_with("space directions", "1 0 0"), "vectors");
        refused(nrrd_with("space origin", "(0,inf,0)"), "\"space origin\"");
        refused(nrrd_with("space units", "\"m\" \"m\" \"m\""), "unit \"m\"");
        refused(nrrd_with("kinds", "vector domain domain"), "three-dimensional");
        refused(nrrd_with("endian", ""), "byte order");
        refused(nrrd_with("endian", "middle"), "little or big");
        refused(nrrd_with("encoding", "zrl"), "encoding \"zrl\"");
        refused(nrrd_with("encoding", "gzip"), "damaged");
        refused(nrrd_with("encoding", "bzip2"), "damaged");
        refused(nrrd_with("encoding", "text", "1 2 3"), "cut short");
        refused(nrrd_with("encoding", "text", "1 2 3 four"), "\"four\"");
        refused(nrrd_with("encoding", "text", "1 2 3 400000"), "\"400000\"");
        refused(nrrd_with("encoding", "text", "1 2 3 " + std::string(70, '0') + "4"), "\"000000");
        refused(nrrd_with("encoding", "hex", "0100020003000"), "cut short");
        refused(nrrd_with("encoding", "hex", "01000200030004zz"), "no digit");
        refused(nrrd_with("old min", "-1024"), "quantised");
        refused(nrrd_with("line skip", "-1"), "must not be negative");
        refused(nrrd_with("line skip", "9"), "before the lines to skip");
        refused(nrrd_with("byte skip", "4"), "cut short");
        refused(nrrd_with("type", "float", std::string("\0\0\0\0\0\0\xc0\x7f", 8) + std::string(8, '\0')),
            "at voxel (1, 0, 0)");
    }

    TEST(BadInput, NrrdEncodingsOfOurOwn)
    {
        const test_support::TemporaryFolder folder;
        const auto voxels = [&](const std::string& bytes) {
            write_bytes(folder / "x.nrrd", bytes);
            return import_volume(folder / "x.nrrd").volume.voxels;
        };
        const std::vector<std::int16_t> expected { 1, -2, 300, -1000 };
        EXPECT_EQ(voxels(nrrd_with("encoding", "text", "+1 -2\n300\t-1000")), expected);
        EXPECT_EQ(voxels(nrrd_with("encoding", "ASCII", "1 -2 300 -1000\r\n")), expected);
        EXPECT_EQ(voxels(nrrd_with("encoding", "hex", "0100 FEff\n2c01 18fc\n")), expected);
        EXPECT_EQ(voxels(nrrd_with("endian", "big", std::string("\x00\x01\xff\xfe\x01\x2c\xfc\x18", 8))), expected);
        EXPECT_EQ(voxels(nrrd_with("line skip", "2",
                      "one line\nand another\n" + std::string("\x01\x00\xfe\xff\x2c\x01\x18\xfc", 8))),
            expected);
        EXPECT_EQ(voxels(nrrd_with("byte skip", "-1", "whatever" + std::string("\x01\x00\xfe\xff\x2c\x01\x18\xfc", 8))),
            expected);
    }

    TEST(BadInput, NrrdWithoutSpaceIsTakenAsLpsAloud)
    {
        const test_support::TemporaryFolder folder;
        write_bytes(folder / "x.nrrd",
            "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 2 1\nspacings: 0.5 0.6 2\nencoding: text\n\n0 1 2 3\n");
        const ImportedVolume imported = import_volume(folder / "x.nrrd");
        EXPECT_EQ(imported.volume.grid.spacing, Vec3(0.5, 0.6, 2.0));
        ASSERT_GE(imported.notes.size(), 2U);
        EXPECT_NE(imported.notes[0].find("names no space: taken as patient LPS"), std::string::npos);
        EXPECT_NE(imported.notes[1].find("names no origin"), std::string::npos);
    }

    TEST(BadInput, DetachedDataStayInTheirFolder)
    {
        const test_support::TemporaryFolder folder;
        fs::create_directories(folder / "in/sub");
        const std::string half("\x01\x00\xfe\xff", 4);
        const std::string rest("\x2c\x01\x18\xfc", 4);
        write_bytes(folder / "secret.raw", half + rest);
        write_bytes(folder / "in/sub/both.raw", half + rest);
        write_bytes(folder / "in/long.raw", half + rest + half);
        write_bytes(folder / "in/s01.raw", half);
        write_bytes(folder / "in/s02.raw", rest);
        const std::vector<std::int16_t> expected { 1, -2, 300, -1000 };
        const auto nrrd = [&](const std::string& data_file) {
            write_bytes(folder / "in/x.nhdr",
                "NRRD0004\ntype: short\ndimension: 3\nspace: LPS\nsizes: 2 1 2\nendian: little\nencoding: raw\n"
                "space directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (0,0,0)\ndata file: "
                    + data_file + "\n");
            return import_volume(folder / "in/x.nhdr").volume.voxels;
        };
        const auto metaimage = [&](const std::string& data_file) {
            write_bytes(folder / "in/x.mhd",
                "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 2 1 2\nElementSpacing = 1 1 2\n"
                "Offset = 0 0 0\nElementType = MET_SHORT\nElementDataFile = "
                    + data_file + "\n");
            return import_volume(folder / "in/x.mhd").volume.voxels;
        };
        const std::vector<std::function<std::vector<std::int16_t>(const std::string&)>> formats { nrrd, metaimage };
        for (const auto& read : formats) {
            EXPECT_EQ(read("sub/both.raw"), expected);
            EXPECT_EQ(read("LIST\ns01.raw\ns02.raw"), expected);
            EXPECT_EQ(read("s%02d.raw 1 2 1"), expected);
            const auto refused = [&](const std::string& data_file, const std::string& reason) {
                test_support::expect_refused<InputError>([&] { read(data_file); }, reason);
            };
            refused("../secret.raw", "outside the folder");
            refused("sub/../../secret.raw", "outside the folder");
            refused((folder / "secret.raw").string(), "outside the folder");
            refused("LIST\n../secret.raw", "outside the folder");
            refused("absent.raw", "missing: \"absent.raw\"");
            refused("s%02d.raw 1 3 1", "missing: \"s03.raw\"");
            refused("s%02d.raw 1 2 -1", "lead nowhere");
            refused("s%02d.raw 2 2 1", "cut short");
            refused("s%n%d.raw 1 2 1", "one %d");
            refused("LIST\n", "empty");
            refused("LIST\ns01.raw\ns01.raw\ns02.raw", "shared evenly");
            refused("long.raw", "4 bytes more than the header promises");
        }
    }

    /// ok.nii as write_volume() makes it, with bytes replaced.
    class NiftiBytes {
    public:
        NiftiBytes(const test_support::TemporaryFolder& folder, const mesh::Volume& volume)
        {
            write_volume(folder / "ok.nii", volume);
            bytes_ = bytes_of(folder / "ok.nii");
        }
        template <typename T> NiftiBytes with(std::size_t at, T value) const
        {
            NiftiBytes changed = *this;
            std::memcpy(changed.bytes_.data() + at, &value, sizeof(T));
            return changed;
        }
        std::string bytes_;
    };

    TEST(BadInput, OwnNiftiFiles)
    {
        const test_support::TemporaryFolder folder;
        const mesh::Volume volume = test_support::random_volume(test_support::oblique_rotation());
        const NiftiBytes ok(folder, volume);
        const auto import = [&](const std::string& bytes) {
            write_bytes(folder / "x.nii", bytes);
            return import_volume(folder / "x.nii");
        };
        const auto refused = [&](const NiftiBytes& bytes, const std::string& reason) {
            test_support::expect_refused<InputError>([&] { import(bytes.bytes_); }, reason);
        };
        const auto noted = [](const ImportedVolume& imported, const std::string& part) {
            return std::any_of(imported.notes.begin(), imported.notes.end(),
                [&](const std::string& note) { return note.find(part) != std::string::npos; });
        };
        EXPECT_EQ(import(ok.bytes_).volume.voxels, volume.voxels);
        refused(ok.with<std::int32_t>(0, 540), "NIfTI-2");
        refused(ok.with<std::int32_t>(0, 7), "not a NIfTI-1 file");
        refused(ok.with<std::int32_t>(344, 0x0031696e), ".hdr/.img pair");
        refused(ok.with<std::int16_t>(40, 0), "dim[0]");
        refused(ok.with<std::int16_t>(40, 2), "it has 2 dimension(s)");
        refused(ok.with<std::int16_t>(40, 4).with<std::int16_t>(48, 3), "dim[4] is 3");
        EXPECT_EQ(import(ok.with<std::int16_t>(40, 4).with<std::int16_t>(48, 1).bytes_).volume.voxels, volume.voxels);
        refused(ok.with<std::int16_t>(70, 128), "datatype 128 is not one number");
        refused(ok.with<std::int16_t>(42, 32000), "cut short");
        refused(ok.with<float>(84, -1.0F), "pixdim[2]");
        refused(ok.with<float>(108, 100.0F), "vox_offset");
        refused(ok.with<float>(108, 352.5F), "vox_offset");
        refused(ok.with<float>(108, std::nanf("")), "vox_offset");
        refused(ok.with<float>(116, INFINITY), "scl_inter");
        refused(ok.with<std::uint8_t>(123, 7), "no unit of length");
        refused(ok.with<std::int16_t>(252, 0).with<std::int16_t>(254, 0), "neither qform nor sform");
        refused(ok.with<std::int16_t>(252, -1), "must not be negative");
        refused(ok.with<float>(256, 3.0F).with<std::int16_t>(254, 0), "no rotation");
        refused(ok.with<float>(292, 90.0F), "qform and sform disagree");
        refused(ok.with<std::int16_t>(252, 0).with<float>(280, 90.0F), "sheared");
        refused(ok.with<std::int16_t>(252, 0).with<float>(292, std::nanf("")), "sform has numbers");
        NiftiBytes cut = ok;
        cut.bytes_.resize(cut.bytes_.size() - 1);
        refused(cut, "cut short");

        const ImportedVolume by_qform = import(ok.with<std::int16_t>(254, 0).bytes_);
        const ImportedVolume by_sform = import(ok.with<std::int16_t>(252, 0).bytes_);
        constexpr double kSinglePrecision = 1e-3; // as in volume_io_test.cpp
        test_support::expect_same_in_world(by_qform.volume, volume, kSinglePrecision);
        test_support::expect_same_in_world(by_sform.volume, volume, kSinglePrecision);
        const ImportedVolume metres = import(ok.with<std::uint8_t>(123, 1).bytes_);
        EXPECT_TRUE(noted(metres, "metre"));
        EXPECT_NEAR(metres.volume.grid.spacing.x(), 1e3 * volume.grid.spacing.x(), kSinglePrecision * 1e3);
        EXPECT_TRUE(noted(import(ok.with<std::uint8_t>(123, 0).bytes_), "taken as mm"));
        EXPECT_EQ(import(ok.with<float>(112, 0.0F).bytes_).volume.voxels, volume.voxels);
        const ImportedVolume doubled = import(ok.with<float>(112, 2.0F).with<float>(116, -10.0F).bytes_);
        EXPECT_EQ(doubled.volume.voxels[5], std::max(-1024, 2 * volume.voxels[5] - 10));
        EXPECT_TRUE(noted(import(ok.with<std::int16_t>(254, 4).bytes_), "standard or template space"));
        EXPECT_TRUE(noted(import(ok.bytes_ + "surplus"), "7 bytes after the last voxel"));
    }

    TEST(BadInput, BigEndianNifti)
    {
        const test_support::TemporaryFolder folder;
        const mesh::Volume volume = test_support::random_volume(test_support::oblique_rotation());
        std::string bytes = NiftiBytes(folder, volume).bytes_;
        const auto reverse = [&](std::size_t at, std::size_t size) {
            std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                bytes.begin() + static_cast<std::ptrdiff_t>(at + size));
        };
        reverse(0, 4);
        for (const std::size_t at : { 40, 42, 44, 46, 48, 50, 52, 54, 70, 72, 252, 254 })
            reverse(at, 2);
        for (std::size_t at = 76; at < 120; at += 4)
            reverse(at, 4);
        for (std::size_t at = 256; at < 328; at += 4)
            reverse(at, 4);
        for (std::size_t at = 352; at < bytes.size(); at += 2)
            reverse(at, 2);
        write_bytes(folder / "big.nii", bytes);
        expect_equal(read_volume(folder / "big.nii"), read_volume(folder / "ok.nii"));
    }

    TEST(BadInput, CompressedNifti)
    {
        const test_support::TemporaryFolder folder;
        const mesh::Volume volume = test_support::random_volume(test_support::oblique_rotation());
        write_volume(folder / "ok.nii.gz", volume);
        const std::string ok = bytes_of(folder / "ok.nii.gz");
        const auto refused = [&](const char* name, const std::string& bytes, const std::string& reason) {
            write_bytes(folder / name, bytes);
            test_support::expect_refused<InputError>([&] { import_volume(folder / name); }, reason);
        };
        std::string bad_sum = ok;
        bad_sum[ok.size() - 6] ^= 1; // the checksum, before the length
        refused("x.nii.gz", bad_sum, "damaged");
        refused("x.nii.gz", ok.substr(0, ok.size() / 2), "damaged or cut short");
        refused("x.nii", ok, "name it .nii.gz");
        write_volume(folder / "ok.nii", volume);
        refused("x.nii.gz", bytes_of(folder / "ok.nii"), "not gzip-compressed");
        write_bytes(folder / "X.NII.GZ", ok);
        EXPECT_EQ(import_volume(folder / "X.NII.GZ").volume.voxels, volume.voxels);
        write_bytes(folder / "x.nii.gz", ok + "garbage");
        const ImportedVolume imported = import_volume(folder / "x.nii.gz");
        EXPECT_EQ(imported.volume.voxels, volume.voxels);
        EXPECT_NE(imported.notes.back().find("after the end of the compressed data"), std::string::npos);
    }

    std::string metaimage_with(const std::string& field, const std::string& value)
    {
        std::vector<std::pair<std::string, std::string>> lines { { "ObjectType", "Image" }, { "NDims", "3" },
            { "BinaryData", "True" }, { "CompressedData", "False" }, { "TransformMatrix", "1 0 0 0 1 0 0 0 1" },
            { "Offset", "0 0 0" }, { "ElementSpacing", "1 1 2" }, { "DimSize", "2 2 1" },
            { "ElementType", "MET_SHORT" } };
        const auto at = std::find_if(lines.begin(), lines.end(), [&](const auto& line) { return line.first == field; });
        if (at == lines.end())
            lines.emplace_back(field, value);
        else
            at->second = value;
        std::string text;
        for (const auto& [name, content] : lines)
            if (!content.empty())
                text += name + " = " + content + "\n";
        return text + "ElementDataFile = LOCAL\n" + std::string("\x01\x00\xfe\xff\x2c\x01\x18\xfc", 8);
    }

    TEST(BadInput, OwnMetaImageFiles)
    {
        const test_support::TemporaryFolder folder;
        const auto import = [&](const std::string& bytes) {
            write_bytes(folder / "x.mha", bytes);
            return import_volume(folder / "x.mha");
        };
        const auto refused = [&](const std::string& bytes, const std::string& reason) {
            test_support::expect_refused<InputError>([&] { import(bytes); }, reason);
        };
        EXPECT_EQ(
            import(metaimage_with("Comment", "ok")).volume.voxels, (std::vector<std::int16_t> { 1, -2, 300, -1000 }));
        EXPECT_EQ(import(metaimage_with("BinaryDataByteOrderMSB", "True")).volume.voxels[0], 256);
        refused("", "cut short");
        refused("hello\n", "not a MetaImage header");
        refused("NDims = 3\nNDims = 3\n", "given twice");
        refused(metaimage_with("ObjectType", "Tube"), "no image");
        refused(metaimage_with("NDims", "2"), "2 dimension(s)");
        refused(metaimage_with("DimSize", ""), "no field \"DimSize\"");
        refused(metaimage_with("DimSize", "2 2"), "must have 3 numbers");
        refused(metaimage_with("DimSize", "2 0 1"), "size along axis 2");
        refused(metaimage_with("DimSize", "4000 4000 1000"), "cut short");
        refused(metaimage_with("DimSize", "2 2 2"), "promises 16 bytes, there are 8");
        refused(metaimage_with("ElementSpacing", "1 -1 2"), "ElementSpacing");
        refused(metaimage_with("ElementSpacing", "1 nan 2"), "ElementSpacing");
        refused(metaimage_with("ElementSpacing", ""), "no field \"ElementSpacing\"");
        refused(metaimage_with("TransformMatrix", "1 0 0 0 1 0 0 0 0"), "unit vectors");
        refused(metaimage_with("TransformMatrix", "1 0 0 0 1 0 0.6 0 0.8"), "sheared");
        refused(metaimage_with("Offset", "0 inf 0"), "Offset");
        refused(metaimage_with("ElementType", "MET_SHORT_ARRAY"), "not one number per voxel");
        refused(metaimage_with("ElementNumberOfChannels", "3"), "one number per voxel, it has 3");
        refused(metaimage_with("CompressedData", "True"), "damaged");
        refused(metaimage_with("CompressedData", "maybe"), "True or False");
        refused(metaimage_with("BinaryData", "False"), "number of the voxels' type");
        refused(metaimage_with("DistanceUnits", "um"), "use mm");
        refused(metaimage_with("HeaderSize", "-5"), "HeaderSize");
    }

    TEST(BadInput, MetaImageLettersAgreeWithTheMatrixOrAreTold)
    {
        const test_support::TemporaryFolder folder;
        const auto import = [&](std::string bytes, const std::string& letters) {
            bytes.insert(0, letters.empty() ? "" : "AnatomicalOrientation = " + letters + "\n");
            write_bytes(folder / "x.mha", bytes);
            return import_volume(folder / "x.mha").notes.size();
        };
        const std::string with_matrix = metaimage_with("Comment", "ok");
        const std::string without = metaimage_with("TransformMatrix", "");
        const std::size_t notes = import(with_matrix, "");
        for (const char* letters : { "RAI", "LPS", "???" }) {
            EXPECT_EQ(import(with_matrix, letters), notes) << letters;
            EXPECT_EQ(import(without, letters), notes) << letters;
        }
        EXPECT_EQ(import(with_matrix, "RAS"), notes + 1);
        test_support::expect_refused<InputError>([&] { import(without, "RAS"); }, "two customs");
    }

    std::string vti_with(const std::string& extent, const std::string& arrays, const std::string& direction = "")
    {
        return "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
               "<ImageData WholeExtent=\""
            + extent + "\" Origin=\"10 20 30\" Spacing=\"1 2 3\"" + direction + ">\n<Piece Extent=\"" + extent + "\">\n"
            + arrays + "</Piece></ImageData></VTKFile>\n";
    }

    TEST(BadInput, VtiFiles)
    {
        const test_support::TemporaryFolder folder;
        const auto import = [&](const std::string& text) {
            write_bytes(folder / "x.vti", text);
            return import_volume(folder / "x.vti");
        };
        const auto refused = [&](const std::string& text, const std::string& reason) {
            test_support::expect_refused<InputError>([&] { import(text); }, reason);
        };
        const auto array = [](const std::string& name, const std::string& more, const std::string& values) {
            return "<DataArray type=\"Int16\" Name=\"" + name + "\" format=\"ascii\"" + more + ">" + values
                + "</DataArray>\n";
        };
        const std::string four = "1 -2 300 -1000";
        const auto points = [](const std::string& arrays) { return "<PointData>" + arrays + "</PointData>"; };
        const std::string direction = " Direction=\"0 -1 0 1 0 0 0 0 1\"";
        const ImportedVolume imported = import(vti_with("1 2 0 1 5 5", points(array("CT", "", four)), direction));
        EXPECT_EQ(imported.volume.voxels, (std::vector<std::int16_t> { 1, -2, 300, -1000 }));
        EXPECT_EQ(imported.volume.grid.spacing, Vec3(1, 2, 3));
        EXPECT_EQ(imported.volume.grid.direction.col(0), Vec3(0, 1, 0));
        EXPECT_EQ(imported.volume.grid.origin, Vec3(10, 20 + 1, 30 + 15)); // the extent begins at (1, 0, 5)
        EXPECT_NE(imported.notes[0].find("names no frame"), std::string::npos);
        EXPECT_EQ(
            import("<?xml version=\"1.0\"?>\n"
                + vti_with("0 1 0 1 0 0",
                    "<PointData Scalars=\"b\">" + array("a", "", "0 0 0 0") + array("b", "", four) + "</PointData>"))
                .volume.voxels[2],
            300);
        refused("", "not a readable .vti");
        refused("no xml", "not a readable .vti");
        refused("<VTKFile type=\"PolyData\"></VTKFile>", "not a readable .vti");
        refused("<VTKFile type=\"ImageData", "a tag does not end");
        refused("<VTKFile type></VTKFile>", "the element VTKFile is damaged");
        refused("<VTKFile type=\"ImageData\"><ImageData></ImageData></VTKFile>", "one piece, it has 0");
        refused(vti_with("0 1 0 1 0 0", points("")), "no values");
        refused(vti_with("0 1 0 1 0 1", "<CellData>" + array("a", "", "7") + "</CellData>"), "in cells");
        refused(vti_with("0 1 0 1 0", points(array("a", "", four))), "must have 6 numbers");
        refused(vti_with("0 1 0 -1 0 0", points(array("a", "", four))), "size along axis 2");
        refused(
            vti_with("0 1 0 1 0 0", points(array("a", "", four)), " Direction=\"2 0 0 0 1 0 0 0 1\""), "unit vectors");
        refused(vti_with("0 1 0 1 0 0", points(array("a", "", four) + array("b", "", four))), "several arrays");
        refused(vti_with("0 1 0 1 0 0", points(array("a", " NumberOfComponents=\"2\"", four + " " + four))),
            "one number per voxel, it has 2");
        refused(vti_with("0 1 0 1 0 0", points(array("a", "", "1 2 3"))), "cut short");
        refused(vti_with("0 2000000000 0 2000000000 0 2000000000", points(array("a", "", four))), "more voxels");
        refused(vti_with("0 999 0 999 0 999", points(array("a", "", four))), "cut short");
        refused(
            vti_with("0 1 0 1 0 0", points(array("a", "", four)), " Direction=\"0.8 0 0 0 1 0 0.6 0 1\""), "sheared");
    }

    /// Every way in which VTK writes an image: data mode and compressor.
    std::vector<std::string> vti_files_of_vtk(const test_support::TemporaryFolder& folder, const mesh::Volume& volume)
    {
        const vtkNew<vtkImageData> image;
        image->SetDimensions(volume.grid.size[0], volume.grid.size[1], volume.grid.size[2]);
        image->SetSpacing(volume.grid.spacing.data());
        image->SetOrigin(volume.grid.origin.data());
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c)
                image->GetDirectionMatrix()->SetElement(r, c, volume.grid.direction(r, c));
        image->AllocateScalars(VTK_SHORT, 1);
        std::copy(volume.voxels.begin(), volume.voxels.end(), static_cast<std::int16_t*>(image->GetScalarPointer()));
        std::vector<std::string> names;
        for (const int mode : { vtkXMLWriter::Ascii, vtkXMLWriter::Binary, vtkXMLWriter::Appended })
            for (const int packed : { vtkXMLWriter::NONE, vtkXMLWriter::ZLIB })
                for (const bool base64 : { false, true })
                    for (const int header : { vtkXMLWriter::UInt32, vtkXMLWriter::UInt64 }) {
                        const vtkNew<vtkXMLImageDataWriter> writer;
                        names.push_back("vtk" + std::to_string(names.size()) + ".vti");
                        writer->SetInputData(image);
                        writer->SetDataMode(mode);
                        writer->SetCompressorType(packed);
                        writer->SetEncodeAppendedData(base64);
                        writer->SetHeaderType(header);
                        writer->SetBlockSize(64); // several blocks
                        writer->SetFileName((folder / names.back()).c_str());
                        writer->Write();
                    }
        return names;
    }

    TEST(BadInput, VtiFilesOfVtkAreReadAsWritten)
    {
        const test_support::TemporaryFolder folder;
        const mesh::Volume volume = test_support::random_volume(test_support::oblique_rotation());
        constexpr double kText = 1e-9; // numbers as text, relative to hundreds of mm
        for (const std::string& name : vti_files_of_vtk(folder, volume)) {
            SCOPED_TRACE(name);
            const mesh::Volume read = read_volume(folder / name);
            EXPECT_EQ(read.voxels, volume.voxels);
            test_support::expect_same_in_world(read, volume, kText);
            write_bytes(folder / "cut.vti", bytes_of(folder / name).substr(0, 900));
            test_support::expect_refused<InputError>([&] { read_volume(folder / "cut.vti"); }, "cut.vti");
        }
    }

    TEST(ImportVolume, DoubtfulValuesHaveANote)
    {
        const test_support::TemporaryFolder folder;
        const auto note = [&](std::int16_t least, std::int16_t most) {
            mesh::Volume volume = test_support::random_volume(Mat3::Identity());
            std::fill(volume.voxels.begin(), volume.voxels.end(), least);
            volume.voxels.back() = most;
            write_volume(folder / "x.nrrd", volume);
            const ImportedVolume imported = import_volume(folder / "x.nrrd");
            return imported.notes.empty() ? std::string() : imported.notes.front();
        };
        EXPECT_EQ(note(-1024, 1500), "");
        EXPECT_NE(note(0, 255).find("probably not Hounsfield units"), std::string::npos);
        EXPECT_NE(note(0, 2500).find("raw scanner values"), std::string::npos);
        EXPECT_NE(note(-1000, 20000).find("metal"), std::string::npos);
        EXPECT_NE(note(5, 5).find("all voxels are 5"), std::string::npos);
    }

    /// Reads; whatever happens must be a volume or one of our errors.
    bool survives(const fs::path& path)
    {
        try {
            const ImportedVolume imported = import_volume(path);
            EXPECT_EQ(imported.volume.voxels.size(), imported.volume.grid.voxel_count());
            return true;
        } catch (const Error& error) {
            EXPECT_FALSE(std::string(error.what()).empty());
            return false;
        }
    }

    TEST(BadInput, RandomDamageEndsInAVolumeOrAnError)
    {
        constexpr int kPerFile = 20;
        const test_support::TemporaryFolder folder;
        const mesh::Volume volume = test_support::random_volume(test_support::oblique_rotation());
        std::map<std::string, std::string> valid;
        for (const char* name : { "v.nii", "v.nii.gz", "v.nrrd", "v.mha" }) {
            write_volume(folder / name, volume);
            valid[name] = bytes_of(folder / name);
        }
        valid["t.nrrd"] = nrrd_with("encoding", "text", "1 -2 300 -1000");
        valid["r.nrrd"] = nrrd_with("byte skip", "-1");
        valid["r.mha"] = metaimage_with("Comment", "ok");
        valid["v.vti"] = vti_with("0 1 0 1 0 0",
            "<PointData><DataArray type=\"Int16\" Name=\"a\" format=\"ascii\">1 -2 300 -1000</DataArray></PointData>");
        for (const std::string& name : vti_files_of_vtk(folder, volume))
            valid[name] = bytes_of(folder / name);
        std::mt19937 random(20261121);
        int read = 0;
        int damaged = 0;
        for (const auto& [name, bytes] : valid)
            for (int n = 0; n < kPerFile; ++n) {
                std::string changed = bytes;
                // Headers are where it hurts: half of the flips hit the first 400 bytes.
                const std::size_t reach = n % 2 == 0 ? std::min<std::size_t>(bytes.size(), 400) : bytes.size();
                for (unsigned flips = 1 + random() % 4; flips > 0; --flips)
                    changed[random() % reach] = static_cast<char>(random() % 256);
                if (n % 4 == 3)
                    changed.resize(random() % bytes.size());
                write_bytes(folder / name, changed);
                SCOPED_TRACE(name + " " + std::to_string(n));
                read += survives(folder / name) ? 1 : 0;
                ++damaged;
            }
        std::cout << "[   INFO   ] " << damaged << " damaged files: " << read << " read, " << damaged - read
                  << " refused\n";
        EXPECT_GT(read, 0);
        EXPECT_LT(read, damaged);
    }

} // namespace bad_input_test
} // namespace retractor::datasets
