#include "datasets/dicom_pixels.h"

#include "datasets/dicom_codecs.h"
#include "datasets/dicom_events.h"
#include "mesh/base/error.h"

#include <vtkDICOMReader.h>
#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkPointData.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <exception>
#include <fstream>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <thread>

namespace retractor {

namespace {

    constexpr std::int16_t kAir = -1024; // HU; the darkest that a 12-bit scanner writes

    std::size_t slice_size(const DicomFile& file)
    {
        return static_cast<std::size_t>(file.columns[0]) * static_cast<std::size_t>(file.rows[0]);
    }

    /// How the stored words of one file are to be read.
    struct PixelFormat {
        unsigned mask = 0xFFFF; ///< of the bits stored
        bool is_signed = false;
        bool spare_bits = false; ///< more bits allocated than stored, and nothing (an overlay) allowed in them
        std::optional<std::array<int, 2>> padding; ///< lowest and highest stored value

        int value(unsigned word) const
        {
            const unsigned bits = word & mask;
            const unsigned sign = (mask >> 1) + 1;
            return is_signed && (bits & sign) != 0 ? static_cast<int>(bits) - static_cast<int>(mask) - 1
                                                   : static_cast<int>(bits);
        }
        /// Spare bits repeat the sign, or are zero.
        bool fits(unsigned word, unsigned allocated_mask) const
        {
            const unsigned spare = word & ~mask & allocated_mask;
            return spare == 0 || (is_signed && spare == (~mask & allocated_mask) && value(word) < 0);
        }
        bool is_padding(int stored) const { return padding && stored >= (*padding)[0] && stored <= (*padding)[1]; }
    };

    PixelFormat format_of(const DicomFile& file)
    {
        PixelFormat format;
        format.mask = (1U << static_cast<unsigned>(file.bits_stored[0])) - 1U;
        format.is_signed = file.pixel_representation[0] == 1.0;
        format.spare_bits = file.bits_stored[0] < file.bits_allocated[0] && !file.overlay_in_pixels;
        if (file.padding_value.empty())
            return format;
        // Written as signed or unsigned by different scanners: what counts is the pattern of bits. It may be one
        // that the bits stored do not hold (-2000 in twelve bits).
        const auto pattern = [&](double value) {
            const auto word = static_cast<std::uint16_t>(static_cast<std::int64_t>(value));
            return format.is_signed ? static_cast<int>(static_cast<std::int16_t>(word)) : static_cast<int>(word);
        };
        const auto usable = [](const std::vector<double>& v) {
            return v.size() == 1 && v[0] >= std::numeric_limits<std::int16_t>::min()
                && v[0] <= std::numeric_limits<std::uint16_t>::max();
        };
        if (!usable(file.padding_value) || (!file.padding_limit.empty() && !usable(file.padding_limit)))
            throw InputError("not a 16-bit number", file.path.string() + " PixelPaddingValue (0028,0120)");
        const int a = pattern(file.padding_value[0]);
        const int b = file.padding_limit.empty() ? a : pattern(file.padding_limit[0]);
        format.padding = { std::min(a, b), std::max(a, b) };
        return format;
    }

    [[noreturn]] void refuse_pixel(
        const std::string& what, const DicomFile& file, const DicomSlice& slice, std::size_t pixel)
    {
        const auto columns = static_cast<std::size_t>(file.columns[0]);
        throw InputError(what,
            file.path.string() + (file.frames.size() > 1 ? " frame " + std::to_string(slice.frame + 1) : "")
                + " column " + std::to_string(pixel % columns) + " row " + std::to_string(pixel / columns));
    }

    void count_padding(DicomPixelCounts& counts, double hu)
    {
        const int value = static_cast<int>(std::lround(hu));
        counts.padding_darkest = counts.padding == 0 ? value : std::min(counts.padding_darkest, value);
        counts.padding_brightest = counts.padding == 0 ? value : std::max(counts.padding_brightest, value);
        ++counts.padding;
    }

    /// Outside the scan circle some scanners write a value no tissue has (-3024 HU) and do not declare it. The
    /// corners of the image show it; other dark pixels (metal) stay as they are. Compression with loss smears the
    /// value (and declared padding with it): then all that is nearer to it than to air counts.
    void clear_circle(std::span<std::int16_t> slice, const DicomFile& file, double padding, DicomPixelCounts& counts)
    {
        const auto columns = static_cast<std::size_t>(file.columns[0]);
        const bool lossy = is_lossy(file);
        int fill = std::min({ slice.front(), slice[columns - 1], slice[slice.size() - columns], slice.back() });
        if (lossy && padding > std::numeric_limits<std::int16_t>::min())
            fill = std::min(fill, static_cast<int>(padding));
        if (fill >= kAir)
            return;
        const int lowest = lossy ? std::numeric_limits<std::int16_t>::min() : fill;
        const int highest = lossy ? (fill + kAir) / 2 : fill;
        for (std::int16_t& hu : slice)
            if (hu >= lowest && hu <= highest) {
                counts.circle_value = std::min(counts.circle_value, static_cast<int>(hu));
                hu = kAir;
                ++counts.circle;
            }
    }

    template <typename Word>
    void to_hounsfield_slice(const Word* stored, const DicomFile& file, const DicomSlice& slice,
        std::span<std::int16_t> out, DicomPixelCounts& counts)
    {
        const PixelFormat format = format_of(file);
        constexpr unsigned kAllocated = std::numeric_limits<Word>::max();
        for (std::size_t p = 0; p < out.size(); ++p) {
            const unsigned word = stored[p];
            const int raw = format.is_signed ? static_cast<std::make_signed_t<Word>>(stored[p]) : stored[p];
            const int value = format.value(word);
            const double hu = slice.slope * value + slice.intercept;
            if (format.padding && (format.is_padding(value) || format.is_padding(raw))) {
                count_padding(counts, hu);
                out[p] = kAir;
                continue;
            }
            if (format.spare_bits && !format.fits(word, kAllocated))
                refuse_pixel("the stored value " + std::to_string(raw) + " needs more than the "
                        + mm_text(file.bits_stored[0]) + " bits of BitsStored (0028,0101)",
                    file, slice, p);
            const double rounded = std::round(hu);
            if (!(rounded >= std::numeric_limits<std::int16_t>::min()
                    && rounded <= std::numeric_limits<std::int16_t>::max()))
                refuse_pixel("the value " + mm_text(hu) + " is not a Hounsfield number (16 bits)", file, slice, p);
            out[p] = static_cast<std::int16_t>(rounded);
        }
        const double padding = format.padding ? slice.slope * (*format.padding)[0] + slice.intercept : 0.0;
        clear_circle(out, file, padding, counts);
    }

    /// Moves a slice of a tilted stack to its place by linear interpolation between neighbouring pixels; what lies
    /// outside it is air.
    void place_shifted(std::span<const std::int16_t> slice, std::array<int, 2> size, const DicomArrangement& stack,
        std::size_t k, std::span<std::int16_t> out)
    {
        struct Sample {
            int low = -1; ///< -1 outside
            int high = -1;
            double weight = 0.0; ///< of `high`
        };
        const auto samples = [&](std::size_t axis) {
            std::vector<Sample> row(static_cast<std::size_t>(stack.grid.size[axis]));
            constexpr double kRoundOff = 1e-6; // pixels
            for (std::size_t i = 0; i < row.size(); ++i) {
                const double at
                    = static_cast<double>(i) + stack.first[axis] - static_cast<double>(k) * stack.shift[axis];
                const int low = static_cast<int>(std::floor(at + kRoundOff));
                const double weight = std::max(at - low, 0.0) <= kRoundOff ? 0.0 : at - low;
                if (low >= 0 && low + (weight > 0.0 ? 1 : 0) < size[axis])
                    row[i] = { low, weight > 0.0 ? low + 1 : low, weight };
            }
            return row;
        };
        const std::vector<Sample> across = samples(0);
        const std::vector<Sample> down = samples(1);
        const auto at = [&](int i, int j) {
            return static_cast<double>(
                slice[static_cast<std::size_t>(j) * static_cast<std::size_t>(size[0]) + static_cast<std::size_t>(i)]);
        };
        std::size_t o = 0;
        for (const Sample& y : down)
            for (const Sample& x : across) {
                double hu = kAir;
                if (x.low >= 0 && y.low >= 0)
                    hu = (1.0 - y.weight) * ((1.0 - x.weight) * at(x.low, y.low) + x.weight * at(x.high, y.low))
                        + y.weight * ((1.0 - x.weight) * at(x.low, y.high) + x.weight * at(x.high, y.high));
                out[o++] = static_cast<std::int16_t>(std::lround(hu));
            }
    }

    template <typename Word>
    void store_slice(const Word* stored, const DicomFile& file, const DicomArrangement& stack, std::size_t k,
        std::span<std::int16_t> voxels, DicomPixelCounts& counts)
    {
        const std::array<int, 2> size { static_cast<int>(file.columns[0]), static_cast<int>(file.rows[0]) };
        const std::size_t layer
            = static_cast<std::size_t>(stack.grid.size[0]) * static_cast<std::size_t>(stack.grid.size[1]);
        const std::span<std::int16_t> out = voxels.subspan(k * layer, layer);
        if (stack.shift[0] == 0.0 && stack.shift[1] == 0.0) {
            to_hounsfield_slice(stored, file, stack.slices[k], out, counts);
            return;
        }
        std::vector<std::int16_t> straight(slice_size(file));
        to_hounsfield_slice(stored, file, stack.slices[k], straight, counts);
        place_shifted(straight, size, stack, k, out);
    }

    /// Puts the slices of one decoded file (places `ks` in the stack) into the volume.
    template <typename Word>
    void store_slices(const Word* pixels, const DicomFile& file, const std::vector<std::size_t>& ks,
        const DicomArrangement& stack, std::span<std::int16_t> voxels, DicomPixelCounts& counts)
    {
        for (const std::size_t k : ks)
            store_slice(pixels + static_cast<std::size_t>(stack.slices[k].frame) * slice_size(file), file, stack, k,
                voxels, counts);
    }

    /// Uncompressed pixels as they are in the file: the library would cut off bits that should not be there.
    void read_plain(const DicomFile& file, const std::vector<std::size_t>& ks, const DicomArrangement& stack,
        std::span<std::int16_t> voxels, DicomPixelCounts& counts)
    {
        static_assert(std::endian::native == std::endian::little);
        const std::size_t bytes = static_cast<std::size_t>(file.bits_allocated[0]) / 8 * slice_size(file);
        std::vector<std::uint16_t> words((bytes + 1) / 2);
        std::ifstream in(file.path, std::ios::binary);
        for (const std::size_t k : ks) {
            in.seekg(static_cast<std::streamoff>(
                file.pixel_offset + static_cast<std::size_t>(stack.slices[k].frame) * bytes));
            if (!in.read(reinterpret_cast<char*>(words.data()), static_cast<std::streamsize>(bytes)))
                throw InputError("the pixels cannot be read", file.path.string() + " PixelData (7fe0,0010)");
            if (file.bits_allocated[0] == 8.0)
                store_slice(reinterpret_cast<const std::uint8_t*>(words.data()), file, stack, k, voxels, counts);
            else
                store_slice(words.data(), file, stack, k, voxels, counts);
        }
    }

    void read_compressed(const DicomFile& file, const std::vector<std::size_t>& ks, const DicomArrangement& stack,
        std::span<std::int16_t> voxels, DicomPixelCounts& counts)
    {
        std::vector<std::vector<char>> images = compressed_images(file);
        for (const std::size_t k : ks) {
            std::vector<char>& image = images[static_cast<std::size_t>(stack.slices[k].frame)];
            const std::vector<char> words = decode_image(file, image);
            image = {};
            if (file.bits_allocated[0] == 8.0)
                store_slice(reinterpret_cast<const std::uint8_t*>(words.data()), file, stack, k, voxels, counts);
            else
                store_slice(reinterpret_cast<const std::uint16_t*>(words.data()), file, stack, k, voxels, counts);
        }
    }

    /// What is left: big endian, and files without a meta header.
    void read_by_library(const DicomFile& file, const std::vector<std::size_t>& ks, const DicomArrangement& stack,
        std::span<std::int16_t> voxels, DicomPixelCounts& counts)
    {
        vtkNew<vtkDICOMReader> reader;
        const ErrorCollector errors(reader);
        reader->SetFileName(file.path.string().c_str());
        reader->SortingOff();
        reader->AutoRescaleOff();
        reader->SetMemoryRowOrderToFileNative();
        reader->Update();
        vtkDataArray* pixels = reader->GetOutput()->GetPointData()->GetScalars();
        const int bytes = static_cast<int>(file.bits_allocated[0]) / 8;
        const int* dimensions = reader->GetOutput()->GetDimensions();
        if (errors.failed() || reader->GetErrorCode() != 0 || pixels == nullptr || pixels->GetDataTypeSize() != bytes
            || pixels->GetNumberOfComponents() != 1 || dimensions[0] != static_cast<int>(file.columns[0])
            || dimensions[1] != static_cast<int>(file.rows[0])
            || static_cast<std::size_t>(dimensions[2]) != file.frames.size()
            || static_cast<std::size_t>(pixels->GetNumberOfValues()) != slice_size(file) * file.frames.size())
            throw InputError("the pixels cannot be read (damaged, truncated, or an unsupported compression)",
                file.path.string() + " PixelData (7fe0,0010)");
        if (bytes == 1)
            store_slices(static_cast<const std::uint8_t*>(pixels->GetVoidPointer(0)), file, ks, stack, voxels, counts);
        else
            store_slices(static_cast<const std::uint16_t*>(pixels->GetVoidPointer(0)), file, ks, stack, voxels, counts);
    }

    void read_file(const DicomFile& file, const std::vector<std::size_t>& ks, const DicomArrangement& stack,
        std::span<std::int16_t> voxels, DicomPixelCounts& counts)
    {
        const bool plain = file.transfer_syntax == "1.2.840.10008.1.2" || file.transfer_syntax == "1.2.840.10008.1.2.1";
        (plain ? read_plain : is_compressed(file) ? read_compressed : read_by_library)(file, ks, stack, voxels, counts);
    }

    void add(DicomPixelCounts& total, const DicomPixelCounts& part)
    {
        if (part.padding > 0) {
            total.padding_darkest
                = total.padding == 0 ? part.padding_darkest : std::min(total.padding_darkest, part.padding_darkest);
            total.padding_brightest = total.padding == 0 ? part.padding_brightest
                                                         : std::max(total.padding_brightest, part.padding_brightest);
        }
        total.padding += part.padding;
        total.circle += part.circle;
        total.circle_value = std::min(total.circle_value, part.circle_value);
    }

} // namespace

DicomPixelCounts read_dicom_pixels(const std::vector<DicomFile>& files, const DicomArrangement& stack,
    std::vector<std::int16_t>& voxels, const Job& job)
{
    std::vector<std::vector<std::size_t>> ks(files.size());
    for (std::size_t k = 0; k < stack.slices.size(); ++k)
        ks[stack.slices[k].file].push_back(k);
    DicomPixelCounts counts;
    // The first file alone: the codecs' tables are made on first use, which need not be safe from several threads.
    read_file(files.front(), ks.front(), stack, voxels, counts);

    std::atomic<std::size_t> next { 1 };
    std::atomic<std::size_t> done { 1 };
    std::atomic<bool> stop { false };
    std::mutex mutex; // guards counts and failures
    std::vector<std::pair<std::size_t, std::exception_ptr>> failures;
    const auto work = [&](bool reports) {
        for (std::size_t f = next++; f < files.size() && !stop && !job.cancelled(); f = next++) {
            DicomPixelCounts part;
            try {
                read_file(files[f], ks[f], stack, voxels, part);
            } catch (...) {
                const std::lock_guard lock(mutex);
                failures.emplace_back(f, std::current_exception());
                stop = true;
                break;
            }
            {
                const std::lock_guard lock(mutex);
                add(counts, part);
            }
            ++done;
            if (reports)
                job.report("read CT", static_cast<double>(done) / static_cast<double>(files.size()));
        }
    };
    {
        const std::size_t helpers
            = std::min<std::size_t>(static_cast<std::size_t>(std::max(job.threads, 1) - 1), files.size() - 1);
        std::vector<std::jthread> threads;
        for (std::size_t t = 0; t < helpers; ++t)
            threads.emplace_back(work, false);
        work(true);
    }
    if (!failures.empty()) // the first file's, as with one thread (mostly)
        std::rethrow_exception(std::min_element(failures.begin(), failures.end(), [](const auto& a, const auto& b) {
            return a.first < b.first;
        })->second);
    job.report("read CT", 1.0);
    return counts;
}

} // namespace retractor
