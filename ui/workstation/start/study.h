#pragma once
// A study that may be imported: what images a folder, an archive or a file holds, with a small picture of each series.

#include "datasets/io/archive.h"
#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <QImage>
#include <QString>

#include <filesystem>
#include <memory>
#include <vector>

namespace retractor::ui {

struct StudyImage {
    std::filesystem::path path; ///< for planner::ImportRequest::ct
    std::string series; ///< for planner::ImportRequest::series; empty for an image file
    QString title, detail;
    QImage picture; ///< null: none can be made
    bool is_ct = true; ///< slices of a CT; others are listed and cannot be imported
};

struct Study {
    std::filesystem::path path;
    std::vector<StudyImage> images; ///< the likeliest first
    /// The files of an archive, which live as long as the study.
    std::shared_ptr<const datasets::UnpackedArchive> unpacked;
};

/// Looks through a folder with its subfolders, a ZIP archive, a DICOM file, a DICOMDIR (its folder is searched) or an
/// image file. An empty study means that the job was cancelled.
/// @throws InputError, IoError when there is no image, or the archive cannot be unpacked
Study read_study(const std::filesystem::path& path, const Job& job = {});

/// A slice of constant k in grey, as radiologists look at it: the patient's left at the right of the picture, the back
/// at the bottom, as far as the grid's axes allow. @pre 0 <= k < size
QImage slice_picture(const mesh::Volume& volume, int k, double level_hu = 40.0, double window_hu = 500.0);

} // namespace retractor::ui
