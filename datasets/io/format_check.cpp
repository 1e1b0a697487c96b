#include "datasets/io/format_check.h"

#include "datasets/io/volume_io.h"
#include "mesh/base/error.h"

#include <gdcmVersion.h>
#include <itkVersion.h>
#include <vtkDICOMConfig.h>
#include <vtkVersion.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string_view>
#include <system_error>

#include <unistd.h>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    constexpr int kEdge = 8;
    constexpr int kSlices = 3;
    constexpr int kIntercept = -1024;

    /// Values that use every bit of a 12-bit CT and do not compress to nothing.
    constexpr int value_at(int x, int y) { return (37 * x + 211 * y + (x * y) % 5 * 300) % 4096; }

    /// A transfer syntax, and the slice encoded with this syntax (hexadecimal; empty for no encoding).
    struct Syntax {
        std::string_view name, uid, encoded;
    };

    // GDCM 3.0 encoded these slices from value_at().
    constexpr std::array<Syntax, 5> kSyntaxes { {
        { "DICOM uncompressed", "1.2.840.10008.1.2.1", "" },
        { "DICOM JPEG lossless", "1.2.840.10008.1.2.4.70",
            "ffd8ffc3000b100008000801011100ffc40019000003010101000000000000000000000006090a080b10ffda00080101"
            "00010000f12929292929292ed36a2d45a8b51e6e8d45a8ed3a7da7d8a0a7d8a0a7da7dda7753399753399399753399b4"
            "fa6aaf85f0be17c74d55f1b4c9494949494949769b516a2d45a8f3746a2d4769d3ed3ec5053ec5053ed3efffd900" },
        { "DICOM JPEG-LS", "1.2.840.10008.1.2.4.80",
            "ffd8fff7000b100008000801011100fff8000d01ffff0012004301140040ffda0008010100000000a24c4989311e4590"
            "e8369b516a2d41a7831bd41a8ad37fe4fa6bfcaf69bfe27d5a4ff4ac44ac462b49fe158fa2201cb5c125974840395fa0"
            "7ba89311e45b4cf71126d369ed3da734d147d4e6a0e7bfb27c360e57e93fa27d00ffd900" },
        { "DICOM JPEG 2000", "1.2.840.10008.1.2.4.90",
            "ff4fff5100290000000000080000000800000000000000000000000800000008000000000000000000010f0101ff5200"
            "0c00000001000204040001ff5c000a4080888890888890ff64002a000143726561746564206279204744434d2f4f7065"
            "6e4a5045472076657273696f6e20322e352e30ff90000a0000000000850001ff93dff89050078157594bfc94d562a3c0"
            "3f606807ec0f00fe42000a634e268df30cfdacc651871f1072de7a50c3f63fc03f618807ec2f00fe43c009e7ce87a469"
            "2cd31b07efff76bba8204c1b7935c755ecd81832122dfe93e4682de6ac308db690b9783a8c1fe9be4116abb9096888e5"
            "3db3749d107b65bfffd9" },
        { "DICOM RLE", "1.2.840.10008.1.2.5",
            "02000000400000007e000000000000000000000000000000000000000000000000000000000000000000000000000000"
            "00000000000000000000000000000000fa00000107000203040601020407010406030502040707020603070503060407"
            "0308070605040807fa04000507040607080a0506080705080a070906080b0700254a6f94b9de0307d32475c6178cdd2e"
            "07a623a041be5fdc59077922ef986532dba8074c211a130c05dad3071f44698eb3d8fd2207f24394e536abfc4d07c542"
            "bf60dd7efb78" },
    } };

    // ---- a DICOM file written by hand: explicit VR, little endian --------------------------------------------------

    std::string number16(unsigned value)
    {
        return { static_cast<char>(value & 0xFFU), static_cast<char>(value >> 8U & 0xFFU) };
    }
    std::string number32(std::size_t value)
    {
        return number16(static_cast<unsigned>(value & 0xFFFFU))
            + number16(static_cast<unsigned>(value >> 16U & 0xFFFFU));
    }

    std::string element(unsigned group, unsigned number, std::string_view type, std::string value)
    {
        if (value.size() % 2 != 0)
            value += type == "UI" || type == "OB" ? '\0' : ' ';
        std::string text = number16(group) + number16(number) + std::string(type);
        if (type == "OB" || type == "OW")
            return text + number16(0) + number32(value.size()) + value;
        return text + number16(static_cast<unsigned>(value.size())) + value;
    }

    std::string item(std::string content)
    {
        return number16(0xFFFE) + number16(0xE000) + number32(content.size()) + content;
    }

    std::string bytes_of(std::string_view hexadecimal)
    {
        const auto digit = [](char c) { return static_cast<unsigned>(c <= '9' ? c - '0' : c - 'a' + 10); };
        std::string bytes;
        for (std::size_t n = 0; n + 1 < hexadecimal.size(); n += 2)
            bytes += static_cast<char>(digit(hexadecimal[n]) << 4U | digit(hexadecimal[n + 1]));
        return bytes;
    }

    std::string pixel_data(const Syntax& syntax)
    {
        if (!syntax.encoded.empty()) // a fragment after an empty table of offsets, in an element of undefined length
            return number16(0x7FE0) + number16(0x0010) + "OB" + number16(0) + number32(0xFFFFFFFF) + item("")
                + item(bytes_of(syntax.encoded)) + number16(0xFFFE) + number16(0xE0DD) + number32(0);
        std::string pixels;
        for (int y = 0; y < kEdge; ++y)
            for (int x = 0; x < kEdge; ++x)
                pixels += number16(static_cast<unsigned>(value_at(x, y)));
        return element(0x7FE0, 0x0010, "OW", pixels);
    }

    /// Slice k of a series. All slices show the same values.
    std::string dicom_file(const Syntax& syntax, int k)
    {
        const std::string uid = "2.25.1" + std::to_string(k);
        const std::string ct = "1.2.840.10008.5.1.4.1.1.2";
        const std::string meta = element(2, 1, "OB", std::string("\0\1", 2)) + element(2, 2, "UI", ct)
            + element(2, 3, "UI", uid) + element(2, 0x10, "UI", std::string(syntax.uid))
            + element(2, 0x12, "UI", "2.25.2");
        return std::string(128, '\0') + "DICM" + element(2, 0, "UL", number32(meta.size())) + meta
            + element(8, 0x16, "UI", ct) + element(8, 0x18, "UI", uid) + element(8, 0x60, "CS", "CT")
            + element(0x18, 0x50, "DS", "1") + element(0x20, 0xD, "UI", "2.25.3") + element(0x20, 0xE, "UI", "2.25.4")
            + element(0x20, 0x13, "IS", std::to_string(k + 1)) + element(0x20, 0x32, "DS", "0\\0\\" + std::to_string(k))
            + element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0") + element(0x20, 0x52, "UI", "2.25.5")
            + element(0x28, 2, "US", number16(1)) + element(0x28, 4, "CS", "MONOCHROME2")
            + element(0x28, 0x10, "US", number16(kEdge)) + element(0x28, 0x11, "US", number16(kEdge))
            + element(0x28, 0x30, "DS", "1\\1") + element(0x28, 0x100, "US", number16(16))
            + element(0x28, 0x101, "US", number16(16)) + element(0x28, 0x102, "US", number16(15))
            + element(0x28, 0x103, "US", number16(0)) + element(0x28, 0x1052, "DS", std::to_string(kIntercept))
            + element(0x28, 0x1053, "DS", "1") + pixel_data(syntax);
    }

    // ---- the tests -------------------------------------------------------------------------------------------------

    void write_and_read_series(const fs::path& folder, const Syntax& syntax)
    {
        for (int k = 0; k < kSlices; ++k) {
            const fs::path path = folder / (std::to_string(k) + ".dcm");
            std::ofstream file(path, std::ios::binary);
            file << dicom_file(syntax, k);
            if (!file.flush())
                throw IoError(
                    "cannot write: " + std::error_code(errno, std::generic_category()).message(), path.string());
        }
        const mesh::Volume read = read_volume(folder);
        if (read.grid.size != std::array { kEdge, kEdge, kSlices })
            throw IoError("the series has another size");
        for (int k = 0; k < kSlices; ++k)
            for (int y = 0; y < kEdge; ++y)
                for (int x = 0; x < kEdge; ++x)
                    if (read.voxels[read.grid.offset(x, y, k)] != value_at(x, y) + kIntercept)
                        throw IoError("the decoded slice differs");
    }

    void write_and_read_volume(const fs::path& path)
    {
        mesh::Volume volume;
        volume.grid.size = { kEdge, kEdge, 2 };
        volume.grid.origin = { -12.5, 30.0, 7.0 };
        for (int k = 0; k < 2; ++k)
            for (int y = 0; y < kEdge; ++y)
                for (int x = 0; x < kEdge; ++x)
                    volume.voxels.push_back(static_cast<std::int16_t>(value_at(x, y) + kIntercept + k));
        write_volume(path, volume);
        const mesh::Volume read = read_volume(path);
        if (read.voxels != volume.voxels || (read.grid.origin - volume.grid.origin).norm() > 1e-4)
            throw IoError("the volume comes back changed");
    }

    template <typename Try> FormatCheck tried(std::string_view name, const Try& attempt)
    {
        FormatCheck check { std::string(name), false, {} };
        try {
            attempt();
            check.works = true;
        } catch (const std::exception& error) {
            check.problem = error.what();
        }
        return check;
    }

    /// A new folder with a name that nobody else has or can guess.
    class ScratchFolder {
    public:
        explicit ScratchFolder(const fs::path& parent)
        {
            std::string name = (parent / "retractor-formats-XXXXXX").string();
            if (::mkdtemp(name.data()) == nullptr)
                throw IoError("cannot make a folder: " + std::error_code(errno, std::generic_category()).message(),
                    parent.string());
            path_ = name;
        }
        ScratchFolder(const ScratchFolder&) = delete;
        ScratchFolder& operator=(const ScratchFolder&) = delete;
        ~ScratchFolder()
        {
            std::error_code ignored;
            fs::remove_all(path_, ignored);
        }
        const fs::path& path() const { return path_; }

    private:
        fs::path path_;
    };

} // namespace

std::vector<FormatCheck> check_formats(const fs::path& folder)
{
    std::vector<FormatCheck> checks;
    for (const Syntax& syntax : kSyntaxes)
        checks.push_back(tried(syntax.name, [&] { write_and_read_series(ScratchFolder(folder).path(), syntax); }));
    for (const auto& [name, file] :
        { std::pair { "NRRD", "v.nrrd" }, std::pair { "NIfTI", "v.nii.gz" }, std::pair { "MetaImage", "v.mha" } })
        checks.push_back(tried(name, [&] { write_and_read_volume(ScratchFolder(folder).path() / file); }));
    return checks;
}

std::string image_library_versions()
{
    return std::string("ITK ") + itk::Version::GetITKVersion() + ", vtk-dicom " + DICOM_VERSION + ", GDCM "
        + gdcm::Version::GetVersion() + ", VTK " + vtkVersion::GetVTKVersion();
}

} // namespace retractor::datasets
