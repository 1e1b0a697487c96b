#include "datasets/dicom_identity.h"

#include "datasets/dicom_nesting.h"
#include "mesh/base/error.h"

#include <vtkCallbackCommand.h>
#include <vtkDICOMDictionary.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMParser.h>
#include <vtkDICOMUtilities.h>
#include <vtkDICOMValue.h>
#include <vtkNew.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <string_view>
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
        if (nests_too_deep(file)) // for the parser, whose stack ends somewhere
            throw InputError("damaged DICOM file: its sequences are nested too deep", file.string());
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

    std::vector<std::string> words_of(const PatientIdentity& identity)
    {
        constexpr std::size_t kShortest = 3;
        std::vector<std::string> words { identity.id };
        std::string word;
        for (const char c : identity.name + "^") {
            if (std::string_view("^= ,;.").find(c) == std::string_view::npos) {
                word += c;
                continue;
            }
            words.push_back(word);
            word.clear();
        }
        std::erase_if(words, [](const std::string& w) { return w.size() < kShortest; });
        return words;
    }

    bool same_letter(char a, char b)
    {
        return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
    }

    bool is_letter(const std::string& text, std::size_t at)
    {
        return at < text.size() && std::isalnum(static_cast<unsigned char>(text[at])) != 0;
    }

    /// Whole words only: a Mr Long does not take "along" with him.
    void withhold(std::string& text, const std::string& word)
    {
        static const std::string kMark = "[withheld]";
        std::size_t from = 0;
        while (true) {
            const auto found = std::search(
                text.begin() + static_cast<std::ptrdiff_t>(from), text.end(), word.begin(), word.end(), same_letter);
            if (found == text.end())
                return;
            const auto at = static_cast<std::size_t>(found - text.begin());
            const bool whole = (at == 0 || !is_letter(text, at - 1)) && !is_letter(text, at + word.size());
            if (whole)
                text.replace(at, word.size(), kMark);
            from = at + (whole ? kMark.size() : 1);
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
            continue; // whoever reads the images says what is wrong with them
        }
    }
    return found;
}

std::string without_identity(std::string text, const std::vector<PatientIdentity>& identities)
{
    for (const PatientIdentity& identity : identities)
        for (const std::string& word : words_of(identity))
            withhold(text, word);
    return text;
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

} // namespace retractor
