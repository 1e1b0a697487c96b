#include "ui/workstation/start/study.h"

#include "datasets/dicom/dicom_identity.h"
#include "datasets/dicom/study_search.h"
#include "datasets/io/volume_io.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace retractor::ui {

namespace {

    namespace fs = std::filesystem;

    constexpr int kPicturePx = 128;

    QImage thumbnail(const mesh::Volume& volume)
    {
        return slice_picture(volume, volume.grid.size[2] / 2)
            .scaled(kPicturePx, kPicturePx, Qt::KeepAspectRatio, Qt::SmoothTransformation);
    }

    /// A picture of one file of a series; null where the file cannot be read alone.
    QImage picture_of(const fs::path& file, const Job& job)
    {
        try {
            return thumbnail(datasets::read_dicom(file, {}, job).volume);
        } catch (const Error&) {
            return {};
        }
    }

    StudyImage image_of(const datasets::StudySeries& found, const Job& job)
    {
        const datasets::DicomSeries& s = found.series;
        StudyImage image { .path = found.path, .series = s.uid, .title = {}, .detail = {}, .picture = {} };
        image.is_ct = s.modality == "CT" && s.kind.empty();
        image.title = QString::fromStdString((s.number.empty() ? "" : s.number + "  ")
            + (s.description.empty() ? "series without a name" : s.description));
        image.detail = QString("%1, %2 %3, %4 × %5 pixels%6%7")
                           .arg(QString::fromStdString(s.modality))
                           .arg(s.frames)
                           .arg(s.frames == 1 ? "image" : "images")
                           .arg(s.columns_rows[0])
                           .arg(s.columns_rows[1])
                           .arg(s.axial ? ", axial" : "")
                           .arg(s.kind.empty() ? QString() : ", " + QString::fromStdString(s.kind));
        image.picture = picture_of(found.middle_file, job);
        return image;
    }

    std::vector<StudyImage> dicom_images(const fs::path& path, const Job& job)
    {
        std::vector<StudyImage> images;
        const std::vector<datasets::StudySeries> found = datasets::find_study_series(path, job);
        for (const datasets::StudySeries& series : found) {
            if (job.cancelled())
                return {};
            job.report("small pictures", static_cast<double>(images.size()) / static_cast<double>(found.size()));
            images.push_back(image_of(series, job));
            if (datasets::patients_of(found) > 1)
                images.back().title.prepend(QString("Patient %1: ").arg(series.patient));
        }
        return images;
    }

    StudyImage image_file(const fs::path& path, const Job& job)
    {
        const mesh::Volume volume = datasets::import_volume(path, {}, job).volume;
        StudyImage image { .path = path, .series = {}, .title = {}, .detail = {}, .picture = {} };
        image.title = QString::fromStdString(path.filename().string());
        image.detail = QString("image of %1 × %2 × %3 voxels, %4 × %5 × %6 mm")
                           .arg(volume.grid.size[0])
                           .arg(volume.grid.size[1])
                           .arg(volume.grid.size[2])
                           .arg(volume.grid.spacing.x(), 0, 'g', 3)
                           .arg(volume.grid.spacing.y(), 0, 'g', 3)
                           .arg(volume.grid.spacing.z(), 0, 'g', 3);
        if (!job.cancelled())
            image.picture = thumbnail(volume);
        return image;
    }

    bool is_dicomdir(const fs::path& path)
    {
        std::string name = path.filename().string();
        std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::toupper(c); });
        return name == "DICOMDIR";
    }

    std::vector<StudyImage> images_in(const fs::path& path, const Job& job)
    {
        if (fs::is_directory(path))
            return dicom_images(path, job);
        if (is_dicomdir(path))
            return dicom_images(path.parent_path(), job);
        if (datasets::holds_dicom(path))
            return dicom_images(path, job);
        return { image_file(path, job) };
    }

} // namespace

QImage slice_picture(const mesh::Volume& volume, int k, double level_hu, double window_hu)
{
    const mesh::ImageGrid& grid = volume.grid;
    QImage image(grid.size[0], grid.size[1], QImage::Format_Grayscale8);
    const double low = level_hu - 0.5 * window_hu;
    for (int j = 0; j < grid.size[1]; ++j)
        for (int i = 0; i < grid.size[0]; ++i) {
            const double share = (volume.voxels[grid.offset(i, j, k)] - low) / window_hu;
            image.scanLine(j)[i] = static_cast<uchar>(std::lround(255.0 * std::clamp(share, 0.0, 1.0)));
        }
    image = image.mirrored(grid.direction(0, 0) < 0.0, grid.direction(1, 1) < 0.0);
    // Square pixels.
    const double height = grid.size[1] * grid.spacing.y() / grid.spacing.x();
    return image.scaled(grid.size[0], std::max(1, static_cast<int>(std::lround(height))), Qt::IgnoreAspectRatio,
        Qt::SmoothTransformation);
}

Study read_study(const fs::path& path, const Job& job)
{
    Study study { .path = path, .images = {}, .unpacked = nullptr };
    std::error_code code;
    if (!fs::exists(path, code))
        throw IoError("there is no such file or folder", path.string());
    fs::path images = path;
    if (fs::is_regular_file(path, code) && datasets::is_zip_archive(path)) {
        study.unpacked = std::make_shared<const datasets::UnpackedArchive>(path, job);
        images = study.unpacked->folder();
    }
    if (!job.cancelled())
        study.images = images_in(images, job);
    return study;
}

} // namespace retractor::ui
