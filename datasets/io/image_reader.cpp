#include "datasets/io/image_reader.h"

#include "datasets/io/byte_source.h"
#include "datasets/io/header_text.h"
#include "datasets/io/metaimage_header.h"
#include "datasets/io/nifti_header.h"
#include "datasets/io/nrrd_header.h"
#include "datasets/io/voxel_values.h"
#include "datasets/io/vti_header.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <span>
#include <type_traits>
#include <utility>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    constexpr std::size_t kChunk = 1U << 18U; // bytes; a multiple of the size of every voxel type
    using TakeBytes = std::function<void(std::span<const char>)>;

    ImageHeader read_header(const fs::path& path)
    {
        const std::string name = lower_case(path.filename().string());
        if (name.ends_with(".nii") || name.ends_with(".nii.gz"))
            return read_nifti_header(path);
        if (name.ends_with(".nrrd") || name.ends_with(".nhdr"))
            return read_nrrd_header(path);
        if (name.ends_with(".mha") || name.ends_with(".mhd"))
            return read_metaimage_header(path);
        if (name.ends_with(".vti"))
            return read_vti_header(path);
        throw InputError(
            "unknown image format: use a DICOM folder, .nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd or .vti", path.string());
    }

    /// Offset of the first byte after `lines` lines.
    std::uint64_t after_lines(const fs::path& file, std::uint64_t start, std::uint64_t lines)
    {
        if (lines == 0)
            return start;
        EncodedBytes bytes { file };
        bytes.start = start;
        const auto source = open_source(bytes);
        std::vector<char> buffer(kChunk);
        std::uint64_t at = start;
        while (const std::size_t got = source->read(buffer.data(), buffer.size())) {
            for (std::size_t n = 0; n < got; ++n)
                if (buffer[n] == '\n' && --lines == 0)
                    return at + n + 1;
            at += got;
        }
        throw InputError("the data end before the lines to skip do", file.string());
    }

    /// The smallest number of encoded bytes that can hold `bytes` decoded bytes.
    std::uint64_t least_encoded(const VoxelStore& store, std::uint64_t bytes)
    {
        constexpr std::uint64_t kMostDeflated = 1032; // largest compression factor of the format
        switch (store.encoding) {
        case Encoding::raw:
            return bytes;
        case Encoding::deflate:
            return bytes / kMostDeflated;
        case Encoding::text:
            return 2 * (bytes / voxel_bytes(store.type)) - 1; // one digit and one blank per number
        case Encoding::hex:
            return 2 * bytes;
        default:
            return 1; // bzip2 has no useful limit
        }
    }

    [[noreturn]] void throw_short(std::uint64_t needed, std::uint64_t there, const fs::path& file)
    {
        throw InputError("the data are cut short: the header promises " + std::to_string(needed) + " bytes, there are "
                + (there < needed ? std::to_string(there) : "fewer"),
            file.string());
    }

    /// Opens the decoded bytes of one file at the first voxel. Sizes are compared as far as the encoding allows.
    std::unique_ptr<ByteSource> open_voxels(const VoxelStore& store, const fs::path& file, std::uint64_t bytes)
    {
        const std::uint64_t size = fs::file_size(file);
        EncodedBytes encoded { file };
        encoded.start = after_lines(file, store.start, store.skip_lines);
        encoded.length = store.length;
        encoded.encoding = store.encoding;
        encoded.base64 = store.base64;
        encoded.streams = store.streams;
        encoded.type = store.type;
        const std::uint64_t stored = std::min(store.length, size > encoded.start ? size - encoded.start : 0);
        const bool raw = store.encoding == Encoding::raw && !store.base64;
        const std::uint64_t ahead = store.at_end ? 0 : store.skip_bytes;
        if (stored < least_encoded(store, bytes + ahead))
            throw_short(bytes, raw ? (stored > ahead ? stored - ahead : 0) : stored, file);
        if (raw) {
            encoded.start = store.at_end ? size - bytes : encoded.start + ahead;
            return open_source(encoded);
        }
        std::uint64_t drop = ahead;
        if (store.at_end) {
            const std::uint64_t decoded = skip(*open_source(encoded), kWholeFile);
            if (decoded < bytes)
                throw_short(bytes, decoded, file);
            drop = decoded - bytes;
        }
        auto source = open_source(encoded);
        if (skip(*source, drop) < drop)
            throw InputError("the data end before the voxels begin", file.string());
        return source;
    }

    /// Checks the bytes after the voxels. Reading to the end also compares checksums.
    void check_end(ByteSource& source, const VoxelStore& store, const fs::path& file, std::vector<std::string>& notes)
    {
        constexpr std::uint64_t kCounted = 1U << 24U;
        const std::uint64_t surplus = skip(source, kCounted);
        if (surplus > 0 && !store.anchored)
            throw InputError("the data file holds " + std::to_string(surplus)
                    + " bytes more than the header promises: is a number of bytes to skip missing?",
                file.string());
        if (surplus > 0)
            notes.push_back(std::to_string(surplus) + " bytes after the last voxel were left alone");
        if (source.has_leftover())
            notes.emplace_back("bytes after the end of the compressed data were left alone");
    }

    template <std::size_t kBytes> void reverse_each(std::span<char> bytes)
    {
        for (std::size_t at = 0; at + kBytes <= bytes.size(); at += kBytes)
            std::reverse(bytes.data() + at, bytes.data() + at + kBytes);
    }

    void to_native_order(std::span<char> bytes, const VoxelStore& store)
    {
        if (store.big_endian == (std::endian::native == std::endian::big))
            return;
        switch (voxel_bytes(store.type)) {
        case 2:
            return reverse_each<2>(bytes);
        case 4:
            return reverse_each<4>(bytes);
        case 8:
            return reverse_each<8>(bytes);
        default:
            return;
        }
    }

    std::uint64_t number_count(const ImageHeader& header)
    {
        return static_cast<std::uint64_t>(header.grid.voxel_count()) * static_cast<std::uint64_t>(header.components);
    }

    void read_bytes(ImageHeader& header, const Job& job, std::string_view stage, const TakeBytes& take)
    {
        const VoxelStore& store = header.store;
        const std::uint64_t total = number_count(header) * voxel_bytes(store.type);
        const std::uint64_t share = total / store.files.size();
        if (share * store.files.size() != total || share % voxel_bytes(store.type) != 0)
            throw InputError(
                "the image cannot be shared evenly by its " + std::to_string(store.files.size()) + " data files",
                header.where);
        std::vector<char> chunk(kChunk);
        std::uint64_t done = 0;
        for (const fs::path& file : store.files) { // checked before any memory is allocated
            const auto source = open_voxels(store, file, share);
            for (std::uint64_t left = share; left > 0;) {
                if (job.cancelled())
                    return;
                const std::span<char> bytes(chunk.data(), std::min<std::uint64_t>(left, chunk.size()));
                const std::size_t got = source->read(bytes.data(), bytes.size());
                if (got < bytes.size())
                    throw_short(share, share - left + got, file);
                to_native_order(bytes, store);
                take(bytes);
                left -= got;
                done += got;
                job.report(stage, static_cast<double>(done) / static_cast<double>(total));
            }
            check_end(*source, store, file, header.notes);
        }
    }

    template <typename Out, typename T> bool fits(T stored)
    {
        if constexpr (std::is_integral_v<T>)
            return std::in_range<Out>(stored);
        else
            return false;
    }

    /// Appends numbers to an image and checks each number. The message for an impossible value names the voxel.
    template <typename Out> class VoxelSink {
    public:
        VoxelSink(const ImageHeader& header, std::vector<Out>& voxels)
            : header_(header)
            , voxels_(voxels)
        {
            voxels_.clear();
            // The reserved size is limited, because bzip2 tells only at its end how many bytes it holds.
            constexpr std::uint64_t kUnproven = 1U << 24U;
            const std::uint64_t count = number_count(header);
            voxels_.reserve(header.store.encoding == Encoding::bzip2 ? std::min(count, kUnproven) : count);
        }
        void take(std::span<const char> bytes)
        {
            with_voxel_type(header_.store.type, [&](auto stored) { append<decltype(stored)>(bytes); });
        }

    private:
        template <typename T> void append(std::span<const char> bytes)
        {
            const std::size_t begin = voxels_.size();
            const std::size_t count = bytes.size() / sizeof(T);
            voxels_.resize(begin + count);
            const bool plain = header_.slope == 1.0 && header_.intercept == 0.0;
            if (plain && std::is_same_v<T, Out>) {
                std::memcpy(voxels_.data() + begin, bytes.data(), bytes.size());
                return;
            }
            for (std::size_t n = 0; n < count; ++n) {
                T stored {};
                std::memcpy(&stored, bytes.data() + n * sizeof(T), sizeof(T));
                if (plain && fits<Out>(stored))
                    voxels_[begin + n] = static_cast<Out>(stored);
                else
                    voxels_[begin + n] = converted(static_cast<double>(stored), begin + n);
            }
        }
        Out converted(double stored, std::size_t at)
        {
            const double value = stored * header_.slope + header_.intercept;
            try {
                if constexpr (std::is_same_v<Out, Label>)
                    return to_label(value, header_.where);
                else
                    return to_hounsfield(value, header_.where);
            } catch (const InputError& error) {
                const std::array<int, 3>& n = header_.grid.size;
                const std::size_t voxel = at / static_cast<std::size_t>(header_.components);
                const auto nx = static_cast<std::size_t>(n[0]);
                const auto ny = static_cast<std::size_t>(n[1]);
                throw InputError(std::string(error.what()) + ", at voxel (" + std::to_string(voxel % nx) + ", "
                        + std::to_string(voxel / nx % ny) + ", " + std::to_string(voxel / nx / ny) + ")",
                    header_.where);
            }
        }

        const ImageHeader& header_;
        std::vector<Out>& voxels_;
    };

    template <typename Out>
    ImageHeader read_image(const fs::path& path, std::vector<Out>& voxels, bool layered, const Job& job)
    {
        const std::string where = path.string();
        const std::string_view stage = std::is_same_v<Out, Label> ? "read labels" : "read CT";
        if (is_image_name(path) && !fs::is_regular_file(path))
            throw IoError("no such file", where);
        job.report(stage, 0.0);
        try {
            ImageHeader header = read_header(path);
            if (header.components != 1 && !layered)
                throw InputError(
                    "the image must have one number per voxel, it has " + std::to_string(header.components), where);
            const VoxelStore& store = header.store;
            for (const fs::path& file : store.files) // before anything is allocated
                if (fs::file_size(file)
                    < least_encoded(store, number_count(header) * voxel_bytes(store.type) / store.files.size()))
                    throw_short(number_count(header) * voxel_bytes(store.type), fs::file_size(file), file);
            VoxelSink<Out> sink(header, voxels);
            read_bytes(header, job, stage, [&](std::span<const char> bytes) { sink.take(bytes); });
            return header;
        } catch (const std::bad_alloc&) {
            throw InputError("there is not enough memory for the image", where);
        } catch (const fs::filesystem_error& error) {
            throw IoError(std::string("cannot read the file: ") + error.code().message(), where);
        }
    }

} // namespace

bool is_image_name(const fs::path& path)
{
    const std::string name = lower_case(path.filename().string());
    const auto ends = [&](const char* suffix) { return name.ends_with(suffix); };
    return ends(".nii") || ends(".nii.gz") || ends(".nrrd") || ends(".nhdr") || ends(".mha") || ends(".mhd")
        || ends(".vti");
}

std::string image_stem(const fs::path& path)
{
    const fs::path stem = path.filename().stem();
    return (lower_case(path.extension().string()) == ".gz" ? stem.stem() : stem).string();
}

ImageHeader read_hounsfield_image(const fs::path& path, std::vector<std::int16_t>& voxels, const Job& job)
{
    return read_image(path, voxels, false, job);
}

ImageHeader read_label_image(const fs::path& path, std::vector<Label>& voxels, bool layered, const Job& job)
{
    return read_image(path, voxels, layered, job);
}

} // namespace retractor::datasets
