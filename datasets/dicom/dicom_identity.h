#pragma once
// Reads the patient's name and id from DICOM files, and keeps both out of messages. The functions are separate from the
// readers of images, so that a name is read only on request.

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::datasets {

/// A patient's name and id.
struct PatientIdentity {
    std::string name; ///< as DICOM writes a name, "Family^Given", UTF-8
    std::string id; ///< PatientID
};

/// Returns every patient that the DICOM files of a folder, or one file, name. Subfolders are not searched; unreadable
/// files are skipped. The result serves to remove names from text; callers do not print the result.
std::vector<PatientIdentity> dicom_identities(const std::filesystem::path& path);

/// Returns `text` with every word of a name and every id replaced by "[withheld]", in upper or lower case. A single
/// word of fewer than three letters stays, because such a word names nobody and often is a unit. Two such words are a
/// name.
std::string without_identity(std::string text, const std::vector<PatientIdentity>& identities);

/// Throws the current Error again, with the same type, but without the names and ids in the DICOM files at `path`.
/// Messages quote file names, and file names often contain the patient's name. The path itself, which the user gave,
/// stays at the start of the message and of its place. @pre The caller is inside a handler of an Error.
[[noreturn]] void rethrow_without_identity(const std::filesystem::path& path);

/// Reads PatientName and PatientID of the DICOM files of a folder, or of one file. Subfolders are not searched.
/// @throws InputError when there is no DICOM file, when a file is damaged, or when the files name several patients (the
/// message names none of them); IoError when the folder cannot be read.
PatientIdentity read_dicom_identity(const std::filesystem::path& path);

/// True when the path is a DICOM file, or a folder with a DICOM file, judged by content. False when the path cannot be
/// read.
bool holds_dicom(const std::filesystem::path& path);

} // namespace retractor::datasets
