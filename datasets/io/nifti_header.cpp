#include "datasets/io/nifti_header.h"

#include "datasets/io/byte_source.h"
#include "datasets/io/header_text.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <utility>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    constexpr std::size_t kHeaderBytes = 348;
    constexpr std::size_t kDataBytes = 352; // bytes of the header and the flag of extensions

    bool named_gz(const fs::path& path) { return lower_case(path.extension().string()) == ".gz"; }

    std::unique_ptr<ByteSource> open_decoded(const fs::path& path)
    {
        EncodedBytes bytes { path };
        bytes.encoding = named_gz(path) ? Encoding::deflate : Encoding::raw;
        return open_source(bytes);
    }

    bool is_gzip(const fs::path& path)
    {
        std::ifstream file(path, std::ios::binary);
        if (!file)
            throw IoError("cannot open the file", path.string());
        std::array<char, 2> magic {};
        file.read(magic.data(), 2);
        return file.gcount() == 2 && magic[0] == '\x1f' && magic[1] == '\x8b';
    }

    /// The fixed part of the header, read in its byte order.
    class RawHeader {
    public:
        RawHeader(std::string bytes, const std::string& where)
            : bytes_(std::move(bytes))
        {
            constexpr std::int32_t kNifti2Bytes = 540;
            const auto size = static_cast<std::int32_t>(kHeaderBytes);
            if (bytes_.size() < 4)
                throw InputError("the NIfTI header is cut short", where);
            const auto at_start = get<std::int32_t>(0);
            swap_ = at_start != size;
            const auto swapped = get<std::int32_t>(0);
            if (at_start == kNifti2Bytes || swapped == kNifti2Bytes)
                throw InputError("a NIfTI-2 file: save it as NIfTI-1 (.nii, .nii.gz)", where);
            if (at_start != size && swapped != size)
                throw InputError("not a NIfTI-1 file", where);
            if (bytes_.size() < kHeaderBytes)
                throw InputError("the NIfTI header is cut short", where);
            if (bytes_.compare(344, 4, std::string("ni1\0", 4)) == 0)
                throw InputError("the header of a .hdr/.img pair: save it as one .nii file", where);
            if (bytes_.compare(344, 4, std::string("n+1\0", 4)) != 0)
                throw InputError("not a NIfTI-1 file (its magic is missing)", where);
            if (bytes_.size() < kDataBytes)
                throw InputError("the NIfTI header is cut short", where);
        }
        template <typename T> T get(std::size_t at) const
        {
            std::array<char, sizeof(T)> bytes {};
            std::memcpy(bytes.data(), bytes_.data() + at, sizeof(T));
            if (swap_)
                std::reverse(bytes.begin(), bytes.end());
            return std::bit_cast<T>(bytes);
        }
        double real(std::size_t at) const { return get<float>(at); }
        int integer(std::size_t at) const { return get<std::int16_t>(at); }
        bool swapped() const { return swap_; }

    private:
        std::string bytes_;
        bool swap_ = false;
    };

    RawHeader read_raw(const fs::path& path)
    {
        const std::string where = path.string();
        if (named_gz(path) != is_gzip(path))
            throw InputError(named_gz(path) ? "named .gz but not gzip-compressed"
                                            : "gzip-compressed but not named .gz: name it .nii.gz",
                where);
        const auto source = open_decoded(path);
        std::string bytes(kDataBytes, '\0');
        if (source->read(bytes.data(), bytes.size()) != bytes.size())
            throw InputError("the extension of the NIfTI header is cut short", path.string());
        return { std::move(bytes), where };
    }

    VoxelType type_of(const RawHeader& raw, const std::string& where)
    {
        static const std::map<int, std::pair<VoxelType, int>> kTypes { { 2, { VoxelType::uint8, 8 } },
            { 4, { VoxelType::int16, 16 } }, { 8, { VoxelType::int32, 32 } }, { 16, { VoxelType::float32, 32 } },
            { 64, { VoxelType::float64, 64 } }, { 256, { VoxelType::int8, 8 } }, { 512, { VoxelType::uint16, 16 } },
            { 768, { VoxelType::uint32, 32 } }, { 1024, { VoxelType::int64, 64 } },
            { 1280, { VoxelType::uint64, 64 } } };
        const int type = raw.integer(70);
        const int bits = raw.integer(72);
        const auto found = kTypes.find(type);
        if (found == kTypes.end())
            throw InputError("NIfTI datatype " + std::to_string(type) + " is not one number per voxel", where);
        if (found->second.second != bits)
            throw InputError(
                "NIfTI bitpix " + std::to_string(bits) + " contradicts datatype " + std::to_string(type), where);
        return found->second.first;
    }

    std::array<int, 3> sizes_of(const RawHeader& raw, const std::string& where)
    {
        const int dimensions = raw.integer(40);
        if (dimensions < 1 || dimensions > 7)
            throw InputError("NIfTI dim[0] is out of range: " + std::to_string(dimensions), where);
        std::vector<double> sizes;
        for (int d = 1; d <= dimensions; ++d) {
            const int n = raw.integer(40 + 2 * static_cast<std::size_t>(d));
            if (n < 1)
                throw InputError(
                    "NIfTI dim[" + std::to_string(d) + "] must be positive, got " + std::to_string(n), where);
            if (d > 3 && n > 1)
                throw InputError("the image must be three-dimensional: dim[" + std::to_string(d) + "] is "
                        + std::to_string(n) + " (a series in time, or several values per voxel)",
                    where);
            sizes.push_back(n);
        }
        if (dimensions < 3)
            throw InputError(
                "the image must be three-dimensional, it has " + std::to_string(dimensions) + " dimension(s)", where);
        return checked_sizes(sizes, where);
    }

    Vec3 pixdim_of(const RawHeader& raw, const std::string& where)
    {
        Vec3 spacing;
        for (int d = 0; d < 3; ++d) {
            spacing[d] = raw.real(80 + 4 * static_cast<std::size_t>(d));
            if (!(std::isfinite(spacing[d]) && spacing[d] > 0.0))
                throw InputError("NIfTI pixdim[" + std::to_string(d + 1) + "] must be positive and finite", where);
        }
        return spacing;
    }

    /// The transform from index to world as in the file: RAS, in the file's unit.
    struct Placement {
        Mat3 steps;
        Vec3 origin;
        Vec3 corner(const Vec3& index) const { return origin + steps * index; }
    };

    Placement qform_of(const RawHeader& raw, const Vec3& spacing, const std::string& where)
    {
        constexpr double kUnit = 1e-4; // single precision, reduced by text between tools
        const double b = raw.real(256);
        const double c = raw.real(260);
        const double d = raw.real(264);
        const double square = b * b + c * c + d * d;
        const double qfac = raw.real(76);
        const Vec3 origin(raw.real(268), raw.real(272), raw.real(276));
        if (!(square <= 1.0 + kUnit) || !std::isfinite(qfac) || !origin.allFinite())
            throw InputError("the qform is no rotation", where);
        Eigen::Quaterniond rotation(std::sqrt(std::max(0.0, 1.0 - square)), b, c, d);
        rotation.normalize();
        Placement placement { rotation.toRotationMatrix() * spacing.asDiagonal(), origin };
        if (qfac < 0.0)
            placement.steps.col(2) *= -1.0;
        return placement;
    }

    Placement sform_of(const RawHeader& raw)
    {
        Placement placement;
        for (int r = 0; r < 3; ++r) {
            const std::size_t row = 280 + 16 * static_cast<std::size_t>(r);
            for (int c = 0; c < 3; ++c)
                placement.steps(r, c) = raw.real(row + 4 * static_cast<std::size_t>(c));
            placement.origin[r] = raw.real(row + 12);
        }
        return placement;
    }

    std::string text_of(const Vec3& v) { return formatted("(%.4g, %.4g, %.4g)", v.x(), v.y(), v.z()); }

    /// The largest distance at which the two transforms place a corner of the image, and this corner.
    std::pair<double, Vec3> farthest_corner(const Placement& a, const Placement& b, const std::array<int, 3>& size)
    {
        std::pair<double, Vec3> worst { -1.0, Vec3::Zero() };
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3 index(corner & 1 ? size[0] - 1 : 0, corner & 2 ? size[1] - 1 : 0, corner & 4 ? size[2] - 1 : 0);
            const double apart = (a.corner(index) - b.corner(index)).norm();
            if (!(apart <= worst.first)) // NaN counts as the largest distance
                worst = { apart, index };
        }
        return worst;
    }

    double unit_mm(const RawHeader& raw, const std::string& where, std::vector<std::string>& notes)
    {
        switch (raw.get<std::uint8_t>(123) & 7) {
        case 0:
            notes.emplace_back("the header names no unit of length: taken as mm");
            return 1.0;
        case 1:
            notes.emplace_back("the header's unit is the metre: turned into mm");
            return 1e3;
        case 2:
            return 1.0;
        case 3:
            notes.emplace_back("the header's unit is the micrometre: turned into mm");
            return 1e-3;
        default:
            throw InputError("NIfTI xyzt_units names no unit of length", where);
        }
    }

    Placement placement_of(const RawHeader& raw, const ImageHeader& header, std::vector<std::string>& notes)
    {
        constexpr double kApart_mm = 0.1;
        // Near half a turn, a quaternion in single precision is accurate to about 6e-4 rad.
        constexpr double kQuaternion_rad = 6e-4;
        constexpr double kPixdim = 1e-3;
        constexpr int kStandardSpace = 3; // code of Talairach, MNI and other templates
        const std::string& where = header.where;
        const Vec3 spacing = pixdim_of(raw, where);
        const int qform_code = raw.integer(252);
        const int sform_code = raw.integer(254);
        if (qform_code < 0 || sform_code < 0)
            throw InputError("NIfTI qform_code and sform_code must not be negative", where);
        if (qform_code == 0 && sform_code == 0)
            throw InputError("the file has neither qform nor sform: left and right cannot be told", where);
        if ((sform_code > 0 ? sform_code : qform_code) >= kStandardSpace)
            notes.emplace_back("the image is placed in a standard or template space, not in the patient's");
        if (sform_code == 0)
            return qform_of(raw, spacing, where);
        const Placement sform = sform_of(raw);
        if (!sform.steps.allFinite() || !sform.origin.allFinite())
            throw InputError("the sform has numbers that are not finite", where);
        if (qform_code > 0) {
            const Placement qform = qform_of(raw, spacing, where);
            const auto [apart, index] = farthest_corner(qform, sform, header.grid.size);
            const std::array<int, 3>& n = header.grid.size;
            const double reach = spacing.cwiseProduct(Vec3(n[0], n[1], n[2])).norm();
            if (!(apart <= kApart_mm + kQuaternion_rad * reach))
                throw InputError("qform and sform disagree: voxel " + text_of(index) + " lies at RAS "
                        + text_of(qform.corner(index)) + " by the qform and " + text_of(sform.corner(index))
                        + " by the sform, " + std::to_string(apart) + " mm apart; correct the file (one code to 0)",
                    where);
        }
        const Vec3 steps = sform.steps.colwise().norm().transpose();
        if ((steps - spacing).cwiseAbs().maxCoeff() > kPixdim * spacing.maxCoeff())
            notes.push_back("pixdim says a spacing of " + text_of(spacing) + ", the sform " + text_of(steps)
                + ": the sform is taken");
        return sform;
    }

    void set_scaling(ImageHeader& header, const RawHeader& raw)
    {
        const double slope = raw.real(112);
        const double intercept = raw.real(116);
        if (!std::isfinite(slope) || !std::isfinite(intercept))
            throw InputError("NIfTI scl_slope and scl_inter must be finite", header.where);
        if (slope == 0.0) { // the format's sign for unscaled voxels
            if (intercept != 0.0)
                header.notes.push_back("scl_slope is 0, so that scl_inter is not used");
            return;
        }
        header.slope = slope;
        header.intercept = intercept;
    }

} // namespace

ImageHeader read_nifti_header(const fs::path& path)
{
    ImageHeader header;
    header.where = path.string();
    const RawHeader raw = read_raw(path);
    header.store.type = type_of(raw, header.where);
    header.grid.size = sizes_of(raw, header.where);
    set_scaling(header, raw);
    const Placement placement = placement_of(raw, header, header.notes);
    const double mm = unit_mm(raw, header.where, header.notes);
    const Vec3 ras_to_lps(-1.0, -1.0, 1.0);
    set_steps(header.grid, ras_to_lps.asDiagonal() * placement.steps * mm, header.where);
    header.grid.origin = ras_to_lps.cwiseProduct(placement.origin) * mm;
    const double offset = raw.real(108);
    constexpr double kMostOffset = 1e12;
    if (!(offset >= static_cast<double>(kDataBytes) && offset < kMostOffset) || offset != std::floor(offset))
        throw InputError("NIfTI vox_offset must be a whole number of at least 352", header.where);
    header.store.files = { path };
    header.store.skip_bytes = static_cast<std::uint64_t>(offset);
    header.store.encoding = named_gz(path) ? Encoding::deflate : Encoding::raw;
    header.store.big_endian = raw.swapped() != (std::endian::native == std::endian::big);
    header.store.anchored = true;
    return header;
}

std::vector<NiftiExtension> read_nifti_extensions(const fs::path& path)
{
    constexpr std::uint64_t kMost = 1U << 26U;
    const RawHeader raw = read_raw(path);
    std::vector<NiftiExtension> extensions;
    const double offset = raw.real(108);
    if (raw.get<std::uint8_t>(kHeaderBytes) == 0 || !(offset > static_cast<double>(kDataBytes)) || !(offset < kMost))
        return extensions;
    const auto source = open_decoded(path);
    std::string bytes(static_cast<std::size_t>(offset), '\0');
    if (source->read(bytes.data(), bytes.size()) != bytes.size())
        throw InputError("the extension of the NIfTI header is cut short", path.string());
    const auto word = [&](std::size_t at) {
        std::array<char, 4> four {};
        std::memcpy(four.data(), bytes.data() + at, 4);
        if (raw.swapped())
            std::reverse(four.begin(), four.end());
        return std::bit_cast<std::int32_t>(four);
    };
    for (std::size_t at = kDataBytes; at + 8 <= bytes.size();) {
        const std::int32_t size = word(at);
        if (size < 8 || static_cast<std::size_t>(size) > bytes.size() - at)
            throw InputError("the extension of the NIfTI header is damaged", path.string());
        extensions.push_back({ word(at + 4), bytes.substr(at + 8, static_cast<std::size_t>(size) - 8) });
        at += static_cast<std::size_t>(size);
    }
    return extensions;
}

} // namespace retractor::datasets
