#pragma once
// Whose images these are. Kept apart from reading them, so that a name is only ever read where somebody asked for it.

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::datasets {

struct PatientIdentity {
    std::string name; ///< as DICOM writes it, "Family^Given", UTF-8
    std::string id;
};

/// Every patient that the DICOM files of a folder (its subfolders are not searched), or one file, name; files that
/// cannot be read are passed over. To be kept out of what is printed and written.
std::vector<PatientIdentity> dicom_identities(const std::filesystem::path& path);

/// `text` with every word of a name and every id replaced by "[withheld]", whatever its case. A word of fewer
/// than three letters is left when it stands alone: it names nobody, and units would go with it. Two such are a name.
std::string without_identity(std::string text, const std::vector<PatientIdentity>& identities);

/// Inside a handler of an Error: throws it again, of the same type, without the names and ids of the DICOM files at
/// `path`. Messages quote names of files, and those are often the patient's. The path itself, which the user gave,
/// stays at the start of a message and of its place.
[[noreturn]] void rethrow_without_identity(const std::filesystem::path& path);

/// From Patient's Name and Patient ID of the DICOM files of a folder (its subfolders are not searched), or of one file.
/// @throws InputError when there is no DICOM file, a file is damaged, or the files name several patients (the message
/// names none of them); IoError when the folder cannot be read.
PatientIdentity read_dicom_identity(const std::filesystem::path& path);

/// Whether a path is a folder with a DICOM file in it, or a DICOM file, by its content. False when it cannot be read.
bool holds_dicom(const std::filesystem::path& path);

} // namespace retractor::datasets
