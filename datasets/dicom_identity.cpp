#include "datasets/dicom_identity.h"

#include "mesh/base/error.h"

#include <vtkCallbackCommand.h>
#include <vtkDICOMDictionary.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMParser.h>
#include <vtkDICOMUtilities.h>
#include <vtkDICOMValue.h>
#include <vtkNew.h>

#include <algorithm>
#include <optional>
#include <vector>

namespace retractor {

namespace {

    namespace fs = std::filesystem;

    bool is_dicom(const fs::path& file)
    {
        std::error_code error;
        return fs::is_regular_file(file, error) && vtkDICOMUtilities::IsDICOMFile(file.string().c_str());
    }

    std::vector<fs::path> files_of(const fs::path& path)
    {
        std::error_code error;
        if (!fs::is_directory(path, error))
            return is_dicom(path) ? std::vector { path } : std::vector<fs::path> {};
        fs::directory_iterator entries(path, error);
        if (error)
            throw IoError("cannot list the folder: " + error.message(), path.string());
        std::vector<fs::path> files;
        for (const auto& entry : entries)
            if (is_dicom(entry.path()) && entry.path().filename() != "DICOMDIR")
                files.push_back(entry.path());
        std::sort(files.begin(), files.end());
        return files;
    }

    PatientIdentity identity_of(const fs::path& file)
    {
        vtkNew<vtkDICOMMetaData> data;
        vtkNew<vtkDICOMParser> parser;
        vtkNew<vtkCallbackCommand> silent; // VTK prints errors that nobody observes
        parser->AddObserver(vtkCommand::ErrorEvent, silent);
        parser->AddObserver(vtkCommand::WarningEvent, silent);
        parser->SetFileName(file.string().c_str());
        parser->SetMetaData(data);
        parser->Update();
        if (parser->GetErrorCode() != 0)
            throw InputError("damaged DICOM file", file.string());
        return { .name = data->Get(DC::PatientName).AsUTF8String(), .id = data->Get(DC::PatientID).AsUTF8String() };
    }

} // namespace

PatientIdentity read_dicom_identity(const fs::path& path)
{
    std::optional<PatientIdentity> found;
    for (const fs::path& file : files_of(path)) {
        const PatientIdentity identity = identity_of(file);
        if (found && (found->name != identity.name || found->id != identity.id))
            throw InputError("the files are of several patients: import each from a folder of its own", path.string());
        found = identity;
    }
    if (!found)
        throw InputError("there is no DICOM file, and only those carry a patient's name and id", path.string());
    return *found;
}

bool holds_dicom(const fs::path& path)
{
    std::error_code error;
    if (!fs::is_directory(path, error))
        return is_dicom(path);
    fs::directory_iterator entries(path, error);
    return !error
        && std::any_of(begin(entries), end(entries), [](const auto& entry) { return is_dicom(entry.path()); });
}

} // namespace retractor
