#include "datasets/dicom/study_search.h"

#include "datasets/dicom/dicom_identity.h"
#include "datasets/dicom/dicom_series.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <map>
#include <string>
#include <system_error>
#include <tuple>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    /// The folders in a folder, sorted. One that cannot be listed has none that are known.
    std::vector<fs::path> folders_in(const fs::path& folder)
    {
        std::vector<fs::path> folders;
        std::error_code code;
        for (fs::directory_iterator entry(folder, code); !code && entry != fs::directory_iterator();
             entry.increment(code)) {
            std::error_code unknown;
            if (entry->is_directory(unknown) && !entry->is_symlink(unknown))
                folders.push_back(entry->path());
        }
        std::sort(folders.begin(), folders.end());
        return folders;
    }

    /// The folder and all below it. A folder that cannot be listed does not end the search of the others.
    std::vector<fs::path> folders_of(const fs::path& root, const Job& job)
    {
        std::vector<fs::path> folders { root };
        for (std::size_t n = 0; n < folders.size() && !job.cancelled(); ++n) {
            const std::vector<fs::path> inside = folders_in(folders[n]);
            folders.insert(folders.end(), inside.begin(), inside.end());
        }
        return folders;
    }

    /// Name and id of the patient of a file; empty where they cannot be read.
    std::string patient_key(const fs::path& file)
    {
        try {
            const PatientIdentity identity = read_dicom_identity(file);
            return identity.name + '\n' + identity.id;
        } catch (const Error&) {
            return {};
        }
    }

    /// A series with the key of its patient, which goes no further than this file.
    struct KeyedSeries {
        StudySeries found;
        std::string patient;
    };

    /// @param why filled where there are DICOM files that cannot be read
    std::vector<KeyedSeries> series_in(const fs::path& path, std::exception_ptr& why, const Job& job)
    {
        std::vector<std::string> notes; // of damaged files; the import says them again
        std::vector<DicomGroup> groups;
        try {
            groups = group_dicom_series(scan_dicom(path, job), notes);
        } catch (const Error&) {
            if (why == nullptr && holds_dicom(path))
                try {
                    rethrow_without_identity(path);
                } catch (...) {
                    why = std::current_exception();
                }
            return {};
        }
        const std::vector<PatientIdentity> identities = dicom_identities(path);
        std::vector<KeyedSeries> found;
        for (DicomGroup& group : groups) {
            group.series.description = without_identity(group.series.description, identities);
            const fs::path middle = group.files.empty() ? fs::path() : group.files[group.files.size() / 2].path;
            found.push_back({ .found = { .path = path, .series = std::move(group.series), .middle_file = middle },
                .patient = patient_key(middle) });
        }
        return found;
    }

    /// Sorts CT slices to the front, and more slices before fewer.
    auto rank_of(const StudySeries& found)
    {
        const DicomSeries& s = found.series;
        return std::tuple(
            !(s.modality == "CT" && s.kind.empty()), !s.kind.empty(), !s.axial, -static_cast<long>(s.frames));
    }

} // namespace

std::vector<StudySeries> find_study_series(const fs::path& path, const Job& job)
{
    std::error_code code;
    if (!fs::exists(path, code))
        throw IoError("there is no such file or folder", path.string());
    const std::vector<fs::path> places
        = fs::is_directory(path, code) ? folders_of(path, job) : std::vector<fs::path> { path };
    std::vector<KeyedSeries> keyed;
    std::exception_ptr why; // of the first folder with DICOM files that cannot be read
    for (std::size_t n = 0; n < places.size() && !job.cancelled(); ++n) {
        job.report("look for images", static_cast<double>(n) / static_cast<double>(places.size()));
        std::vector<KeyedSeries> here = series_in(places[n], why, job);
        std::move(here.begin(), here.end(), std::back_inserter(keyed));
    }
    if (keyed.empty() && why != nullptr)
        std::rethrow_exception(why);
    if (keyed.empty() && !job.cancelled())
        throw InputError("no DICOM image was found in this folder or below it", path.string());
    std::stable_sort(keyed.begin(), keyed.end(),
        [](const KeyedSeries& a, const KeyedSeries& b) { return rank_of(a.found) < rank_of(b.found); });
    std::vector<StudySeries> found;
    std::map<std::string, std::size_t> number_of;
    for (KeyedSeries& one : keyed) {
        if (!one.patient.empty()) // whose file names nobody is not taken for another patient
            one.found.patient = number_of.try_emplace(one.patient, number_of.size() + 1).first->second;
        found.push_back(std::move(one.found));
    }
    return found;
}

std::size_t patients_of(const std::vector<StudySeries>& study)
{
    std::size_t most = 0;
    for (const StudySeries& one : study)
        most = std::max(most, one.patient);
    return most;
}

} // namespace retractor::datasets
