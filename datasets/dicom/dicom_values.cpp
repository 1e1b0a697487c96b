#include "datasets/dicom/dicom_values.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

namespace retractor::datasets {

namespace {

    constexpr std::int16_t kAir = -1024; // HU; the lowest value that a 12-bit scanner writes

    /// The format of the stored words of one file.
    struct PixelFormat {
        unsigned mask = 0xFFFF; ///< selects the stored bits
        bool is_signed = false;
        bool spare_bits = false; ///< more bits are allocated than stored, and the spare bits must be empty (no overlay)
        std::optional<std::array<int, 2>> padding; ///< lowest and highest stored value

        int value(unsigned word) const
        {
            const unsigned bits = word & mask;
            const unsigned sign = (mask >> 1) + 1;
            return is_signed && (bits & sign) != 0 ? static_cast<int>(bits) - static_cast<int>(mask) - 1
                                                   : static_cast<int>(bits);
        }
        /// True when the spare bits repeat the sign or are zero.
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
        // Scanners write the padding value as a signed or an unsigned number, so the bit patterns are compared. The
        // pattern may not fit the stored bits (-2000 in twelve bits).
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
        constexpr double kShown = 1e6; // HU; a damaged slope could give any number
        const int value = static_cast<int>(std::lround(std::clamp(hu, -kShown, kShown)));
        counts.padding_darkest = counts.padding == 0 ? value : std::min(counts.padding_darkest, value);
        counts.padding_brightest = counts.padding == 0 ? value : std::max(counts.padding_brightest, value);
        ++counts.padding;
    }

    /// Replaces pixels outside the scan circle by air. Some scanners write a value there that no tissue has (-3024 HU),
    /// without declaring the value as padding. The value is recognised because all four corners of the image have it.
    /// Other dark pixels (metal, noise) stay the same. Lossy compression changes this value, and declared padding, a
    /// little; then every pixel that is nearer to the value than to air is replaced.
    void clear_circle(std::span<std::int16_t> slice, const DicomFile& file, double padding, DicomPixelCounts& counts)
    {
        const auto columns = static_cast<std::size_t>(file.columns[0]);
        const auto [darkest, brightest]
            = std::minmax({ slice.front(), slice[columns - 1], slice[slice.size() - columns], slice.back() });
        const bool lossy = is_lossy(file);
        int fill = darkest;
        if (lossy && padding < kAir && padding >= std::numeric_limits<std::int16_t>::min())
            fill = std::min(fill, static_cast<int>(padding));
        if (fill >= kAir || (!lossy && darkest != brightest))
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

    /// Moves a slice of a tilted stack to its place, by linear interpolation between neighbouring pixels. Voxels
    /// outside the slice become air.
    void place_shifted(std::span<const std::int16_t> slice, std::array<int, 2> size, const DicomArrangement& stack,
        std::size_t k, std::span<std::int16_t> out)
    {
        struct Sample {
            int low = -1; ///< first pixel; -1 outside the slice
            int high = -1;
            double weight = 0.0; ///< weight of `high`
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

} // namespace

void store_dicom_slice(const void* stored, const DicomFile& file, const DicomArrangement& stack, std::size_t k,
    std::span<std::int16_t> voxels, DicomPixelCounts& counts)
{
    const auto convert = [&](std::span<std::int16_t> out) {
        if (file.bits_allocated[0] == 8.0)
            to_hounsfield_slice(static_cast<const std::uint8_t*>(stored), file, stack.slices[k], out, counts);
        else
            to_hounsfield_slice(static_cast<const std::uint16_t*>(stored), file, stack.slices[k], out, counts);
    };
    const std::array<int, 2> size { static_cast<int>(file.columns[0]), static_cast<int>(file.rows[0]) };
    const std::size_t layer
        = static_cast<std::size_t>(stack.grid.size[0]) * static_cast<std::size_t>(stack.grid.size[1]);
    const std::span<std::int16_t> out = voxels.subspan(k * layer, layer);
    if (stack.shift[0] == 0.0 && stack.shift[1] == 0.0) {
        convert(out);
        return;
    }
    std::vector<std::int16_t> straight(static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]));
    convert(straight);
    place_shifted(straight, size, stack, k, out);
}

} // namespace retractor::datasets
