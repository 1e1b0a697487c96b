#include "datasets/dicom/dicom_pixels.h"

#include "datasets/dicom/dicom_codecs.h"
#include "datasets/dicom/dicom_events.h"
#include "datasets/dicom/dicom_values.h"
#include "mesh/base/error.h"

#include <vtkDICOMReader.h>
#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <exception>
#include <fstream>
#include <mutex>
#include <span>
#include <thread>

namespace retractor::datasets {

namespace {

    std::size_t image_bytes(const DicomFile& file)
    {
        return static_cast<std::size_t>(file.columns[0]) * static_cast<std::size_t>(file.rows[0])
            * (static_cast<std::size_t>(file.bits_allocated[0]) / 8);
    }

    /// Reads uncompressed pixels from the file directly, because the library would cut off unexpected bits without an
    /// error.
    void read_plain(const DicomFile& file, const std::vector<std::size_t>& ks, const DicomArrangement& stack,
        std::span<std::int16_t> voxels, DicomPixelCounts& counts)
    {
        static_assert(std::endian::native == std::endian::little);
        std::vector<char> words(image_bytes(file));
        std::ifstream in(file.path, std::ios::binary);
        for (const std::size_t k : ks) {
            const auto frame = static_cast<std::size_t>(stack.slices[k].frame);
            in.seekg(static_cast<std::streamoff>(file.pixel_offset + frame * words.size()));
            if (!in.read(words.data(), static_cast<std::streamsize>(words.size())))
                throw InputError("the pixels cannot be read", file.path.string() + " PixelData (7fe0,0010)");
            store_dicom_slice(words.data(), file, stack, k, voxels, counts);
        }
    }

    void read_compressed(const DicomFile& file, const std::vector<std::size_t>& ks, const DicomArrangement& stack,
        std::span<std::int16_t> voxels, DicomPixelCounts& counts)
    {
        std::vector<std::vector<char>> images = compressed_images(file);
        for (const std::size_t k : ks) {
            std::vector<char>& image = images[static_cast<std::size_t>(stack.slices[k].frame)];
            store_dicom_slice(decode_image(file, image).data(), file, stack, k, voxels, counts);
            image = {};
        }
    }

    /// Reads the remaining syntaxes with the library: big endian, and files without a meta header.
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
        const int* size = reader->GetOutput()->GetDimensions();
        const bool right = !errors.failed() && reader->GetErrorCode() == 0 && pixels != nullptr
            && pixels->GetNumberOfComponents() == 1
            && pixels->GetDataTypeSize() == static_cast<int>(file.bits_allocated[0]) / 8
            && size[0] == static_cast<int>(file.columns[0]) && size[1] == static_cast<int>(file.rows[0])
            && static_cast<std::size_t>(size[2]) == file.frames.size();
        if (!right)
            throw InputError("the pixels cannot be read", file.path.string() + " PixelData (7fe0,0010)");
        for (const std::size_t k : ks)
            store_dicom_slice(static_cast<const char*>(pixels->GetVoidPointer(0))
                    + static_cast<std::size_t>(stack.slices[k].frame) * image_bytes(file),
                file, stack, k, voxels, counts);
    }

    void read_file(const DicomFile& file, const std::vector<std::size_t>& ks, const DicomArrangement& stack,
        std::span<std::int16_t> voxels, DicomPixelCounts& counts)
    {
        const bool plain = file.transfer_syntax == "1.2.840.10008.1.2" || file.transfer_syntax == "1.2.840.10008.1.2.1";
        const auto read = plain ? read_plain : is_compressed(file) ? read_compressed : read_by_library;
        read(file, ks, stack, voxels, counts);
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
    // The first file is read alone, because codecs create their tables on first use, possibly without protection from
    // other threads.
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
    // One thread would mostly throw the failure of the first file, so the same failure is thrown here.
    if (!failures.empty())
        std::rethrow_exception(std::min_element(failures.begin(), failures.end(), [](const auto& a, const auto& b) {
            return a.first < b.first;
        })->second);
    job.report("read CT", 1.0);
    return counts;
}

} // namespace retractor::datasets
