#include "datasets/dicom/dicom_identity.h"

#include "datasets/dicom/dicom_events.h"
#include "datasets/dicom/dicom_nesting.h"
#include "datasets/dicom/patient_words.h"
#include "mesh/base/error.h"

#include <vtkDICOMDictionary.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMParser.h>
#include <vtkDICOMUtilities.h>
#include <vtkDICOMValue.h>
#include <vtkNew.h>

#include <algorithm>
#include <optional>
#include <vector>

namespace retractor::datasets {

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
        if (nests_too_deep(file)) // protects the stack of the parser, which recurses
            throw InputError("damaged DICOM file: its sequences are nested too deep", file.string());
        vtkNew<vtkDICOMMetaData> data;
        vtkNew<vtkDICOMParser> parser;
        const ErrorCollector errors(parser);
        parser->SetFileName(file.string().c_str());
        parser->SetMetaData(data);
        parser->Update();
        if (errors.failed() || parser->GetErrorCode() != 0)
            throw InputError("damaged DICOM file", file.string());
        return { .name = data->Get(DC::PatientName).AsUTF8String(), .id = data->Get(DC::PatientID).AsUTF8String() };
    }

    void withhold(std::string& text, const std::string& word)
    {
        static const std::string kMark = "[withheld]";
        const std::vector<std::size_t> places = whole_words(fold_case(text), fold_case(word));
        std::size_t free = text.size(); // text from this position on is already replaced
        for (auto at = places.rbegin(); at != places.rend(); ++at)
            if (*at + word.size() <= free) {
                text.replace(*at, word.size(), kMark);
                free = *at;
            }
    }

} // namespace

std::vector<PatientIdentity> dicom_identities(const fs::path& path)
{
    std::vector<PatientIdentity> found;
    for (const fs::path& file : files_of(path)) {
        try {
            const PatientIdentity identity = identity_of(file);
            const auto same = [&](const PatientIdentity& p) { return p.name == identity.name && p.id == identity.id; };
            if (std::none_of(found.begin(), found.end(), same))
                found.push_back(identity);
        } catch (const InputError&) {
            continue; // the reader of the images reports the damaged file
        }
    }
    return found;
}

std::string without_identity(std::string text, const std::vector<PatientIdentity>& identities)
{
    for (const PatientIdentity& identity : identities) {
        std::vector<std::string> words = telling_parts(text, identity.name);
        if (identity.id.size() >= kShortestTelling)
            words.push_back(identity.id);
        std::sort(words.begin(), words.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
        for (const std::string& word : words)
            withhold(text, word);
    }
    return text;
}

void rethrow_without_identity(const fs::path& path)
{
    std::vector<PatientIdentity> identities;
    try {
        if (holds_dicom(path))
            identities = dicom_identities(path);
    } catch (const Error&) {
        identities.clear(); // a folder that cannot be listed contributes no names to the message
    }
    const std::string typed = path.string();
    const auto clean = [&](const std::string& text) {
        return !typed.empty() && text.starts_with(typed)
            ? typed + without_identity(text.substr(typed.size()), identities)
            : without_identity(text, identities);
    };
    try {
        throw;
    } catch (const InputError& error) {
        throw InputError(clean(error.what()), clean(error.where()), error.fields());
    } catch (const IoError& error) {
        throw IoError(clean(error.what()), clean(error.where()), error.fields());
    } catch (const SolverError& error) {
        throw SolverError(clean(error.what()), clean(error.where()), error.fields());
    }
}

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

} // namespace retractor::datasets
