#include "datasets/dicom/dicom_series.h"

#include "datasets/dicom/dicom_geometry.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <charconv>
#include <climits>
#include <map>
#include <tuple>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    std::string count_of(std::size_t n, const std::string& one)
    {
        return std::to_string(n) + " " + one + (n == 1 ? "" : "s");
    }

    std::vector<fs::path> files_of(const fs::path& folder, std::vector<std::string>& subfolders)
    {
        std::error_code error;
        fs::directory_iterator it(folder, error);
        if (error)
            throw IoError("cannot list the folder: " + error.message(), folder.string());
        std::vector<fs::path> files;
        for (const auto& entry : it) {
            std::error_code ignored;
            if (entry.is_regular_file(ignored))
                files.push_back(entry.path());
            else if (entry.is_directory(ignored))
                subfolders.push_back(entry.path().filename().string());
        }
        std::sort(files.begin(), files.end());
        std::sort(subfolders.begin(), subfolders.end());
        return files;
    }

    const char* kind_name(DicomKind kind)
    {
        switch (kind) {
        case DicomKind::localizer:
            return "localizer";
        case DicomKind::capture:
            return "secondary capture";
        default:
            return "";
        }
    }

    int to_number(const std::string& text)
    {
        int value = INT_MAX;
        std::from_chars(text.data(), text.data() + text.size(), value);
        return value;
    }

    /// Describes the series at this place of the list. The first place is #1 in the text.
    std::string describe(const DicomSeries& series, std::size_t place)
    {
        std::string text = "#" + std::to_string(place + 1) + ":";
        if (!series.number.empty())
            text += " number " + series.number;
        if (!series.description.empty())
            text += " \"" + series.description + "\"";
        text += " " + count_of(series.frames, "slice") + " of " + std::to_string(series.columns_rows[0]) + " x "
            + std::to_string(series.columns_rows[1]);
        text += ", " + (series.modality.empty() ? "no modality" : series.modality);
        if (!series.kind.empty())
            text += " " + series.kind;
        else if (series.axial)
            text += ", axial";
        return text + (series.uid.empty() ? ", no UID" : ", UID " + series.uid);
    }

    std::string list_of(const std::vector<DicomGroup>& groups)
    {
        std::string text;
        for (std::size_t g = 0; g < groups.size(); ++g)
            text += "\n  " + describe(groups[g].series, g);
        return text;
    }

    bool is_ct(const DicomGroup& group) { return group.series.modality == "CT" && group.kind == DicomKind::slices; }

    /// Indices of the series that the request names.
    std::vector<std::size_t> matching(const std::vector<DicomGroup>& groups, const std::string& wish)
    {
        std::vector<std::size_t> found;
        if (wish.size() > 1 && wish.front() == '#') {
            std::size_t place = 0;
            const auto [end, error] = std::from_chars(wish.data() + 1, wish.data() + wish.size(), place);
            if (error == std::errc() && end == wish.data() + wish.size() && place >= 1 && place <= groups.size())
                found.push_back(place - 1);
            return found;
        }
        for (const auto member : { &DicomSeries::uid, &DicomSeries::number }) {
            for (std::size_t g = 0; g < groups.size(); ++g)
                if (groups[g].series.*member == wish)
                    found.push_back(g);
            if (!found.empty())
                break;
        }
        // Some scanners store the localizer in the series itself.
        const auto is_slices = [&](std::size_t g) { return groups[g].kind == DicomKind::slices; };
        if (std::any_of(found.begin(), found.end(), is_slices))
            found.erase(
                std::remove_if(found.begin(), found.end(), [&](std::size_t g) { return !is_slices(g); }), found.end());
        return found;
    }

    std::size_t wished(const std::vector<DicomGroup>& groups, const std::string& wish, const std::string& where)
    {
        const std::vector<std::size_t> found = matching(groups, wish);
        if (found.empty())
            throw InputError(
                "there is no series \"" + wish + "\"; choose by UID, number or #place among:" + list_of(groups), where);
        if (found.size() > 1)
            throw InputError("\"" + wish + "\" fits " + std::to_string(found.size())
                    + " series; choose by UID or #place among:" + list_of(groups),
                where);
        return found.front();
    }

    std::string why_no_ct(const DicomGroup& group)
    {
        if (group.kind != DicomKind::slices)
            return std::string("a ") + kind_name(group.kind) + ", not slices";
        return (group.series.modality.empty() ? std::string("without a modality")
                                              : "of modality " + group.series.modality)
            + ", not CT: its values are no Hounsfield units";
    }

    std::size_t largest_ct(
        const std::vector<DicomGroup>& groups, const std::string& where, std::vector<std::string>& notes)
    {
        const auto ct = [](const DicomGroup& g) { return is_ct(g); };
        const auto axial_ct = [](const DicomGroup& g) { return is_ct(g) && g.series.axial; };
        auto chosen = std::find_if(groups.begin(), groups.end(), axial_ct);
        if (chosen == groups.end())
            chosen = std::find_if(groups.begin(), groups.end(), ct);
        if (chosen == groups.end()) {
            if (groups.size() == 1)
                throw InputError("the only series is " + why_no_ct(groups.front()), where);
            throw InputError("none of the series is a CT with slices:" + list_of(groups), where);
        }
        if (groups.size() == 1)
            return 0;
        const auto place = static_cast<std::size_t>(chosen - groups.begin());
        std::string note = std::string("chose the largest ")
            + (chosen->series.axial ? "axial CT" : "CT (none is axial)") + " of " + std::to_string(groups.size())
            + " series, " + describe(chosen->series, place) + "; left:";
        for (std::size_t g = 0; g < groups.size(); ++g)
            if (g != place)
                note += " " + describe(groups[g].series, g) + ";";
        note.pop_back();
        notes.push_back(note);
        return place;
    }

    DicomSeries describe_files(const std::vector<DicomFile>& files)
    {
        DicomSeries series;
        const DicomFile& first = files.front();
        series.uid = first.series_uid;
        series.number = first.series_number;
        series.description = first.description;
        series.modality = first.modality;
        series.kind = kind_name(first.kind);
        series.files = files.size();
        for (const DicomFile& file : files)
            series.frames += file.frames.size();
        const auto size = [](const std::vector<double>& value) {
            return value.size() == 1 && value[0] >= 0.0 && value[0] <= 65535.0 ? static_cast<int>(value[0]) : 0;
        };
        series.columns_rows = { size(first.columns), size(first.rows) };
        series.axial = first.kind == DicomKind::slices && !first.frames.empty() && is_axial(first.frames.front());
        return series;
    }

    std::string names_of(const std::vector<std::string>& names)
    {
        constexpr std::size_t kShown = 5;
        std::string text;
        for (std::size_t n = 0; n < std::min(names.size(), kShown); ++n)
            text += (n > 0 ? ", " : "") + names[n];
        return names.size() > kShown ? text + " and " + std::to_string(names.size() - kShown) + " more" : text;
    }

} // namespace

DicomFolder scan_dicom(const fs::path& path, const Job& job)
{
    DicomFolder folder;
    folder.path = path;
    std::vector<fs::path> files;
    std::vector<std::string> subfolders;
    std::error_code ignored;
    const bool is_folder = fs::is_directory(path, ignored);
    if (is_folder)
        files = files_of(path, subfolders);
    else if (fs::is_regular_file(path, ignored))
        files.push_back(path);
    else
        throw IoError("no such file or folder", path.string());
    for (std::size_t f = 0; f < files.size() && !job.cancelled(); ++f) {
        if (auto file = read_dicom_tags(files[f]))
            folder.files.push_back(std::move(*file));
        job.report("read tags", static_cast<double>(f + 1) / static_cast<double>(files.size()));
    }
    if (folder.files.empty() && !job.cancelled()) {
        if (!is_folder)
            throw InputError("this is no DICOM file", path.string());
        throw InputError("no DICOM files in this folder"
                + (subfolders.empty() ? std::string()
                                      : "; its subfolders are not searched, give one of them: " + names_of(subfolders)),
            path.string());
    }
    return folder;
}

std::vector<DicomGroup> group_dicom_series(DicomFolder folder, std::vector<std::string>& notes)
{
    // A damaged file that names its series is added to the series, so that reading the series fails.
    using Key = std::tuple<DicomKind, std::string, std::string>;
    std::map<Key, std::vector<DicomFile>> series;
    std::vector<std::string> passed_over;
    std::size_t damaged = 0;
    bool deflated = false;
    const std::size_t total = folder.files.size();
    for (DicomFile& file : folder.files) {
        if (file.kind == DicomKind::no_image)
            continue;
        const bool is_damaged = file.kind == DicomKind::damaged;
        if (is_damaged)
            ++damaged;
        // The parser cannot inflate this syntax.
        deflated = deflated || file.transfer_syntax == "1.2.840.10008.1.2.1.99";
        const Key key { is_damaged ? DicomKind::slices : file.kind, file.series_uid,
            file.series_uid.empty() && !is_damaged ? file.identity : std::string() };
        series[key].push_back(std::move(file));
    }
    std::vector<DicomGroup> groups;
    for (auto& [key, files] : series) {
        DicomGroup group;
        std::stable_partition(
            files.begin(), files.end(), [](const DicomFile& f) { return f.kind != DicomKind::damaged; });
        if (files.front().kind == DicomKind::damaged) {
            for (const DicomFile& file : files)
                passed_over.push_back(file.path.filename().string());
            continue; // only damaged files, so no series
        }
        group.kind = std::get<DicomKind>(key);
        group.series = describe_files(files);
        group.files = std::move(files);
        groups.push_back(std::move(group));
    }
    if (groups.empty())
        throw InputError(damaged == 0
                ? "no DICOM image: " + count_of(total, "object") + " without pixels (reports, presentation states ...)"
                : (deflated ? "deflated DICOM is not supported, convert it: " : "damaged DICOM file: ")
                    + names_of(passed_over),
            folder.path.string());
    if (!passed_over.empty())
        notes.push_back("passed over " + count_of(passed_over.size(), "damaged DICOM file")
            + ", of no known series: " + names_of(passed_over));
    std::stable_sort(groups.begin(), groups.end(), [](const DicomGroup& a, const DicomGroup& b) {
        if (a.series.frames != b.series.frames)
            return a.series.frames > b.series.frames;
        return std::make_tuple(to_number(a.series.number), a.series.uid, a.series.description)
            < std::make_tuple(to_number(b.series.number), b.series.uid, b.series.description);
    });
    return groups;
}

DicomGroup choose_dicom_series(
    std::vector<DicomGroup> groups, const std::string& wish, const std::string& where, std::vector<std::string>& notes)
{
    const std::size_t place = wish.empty() ? largest_ct(groups, where, notes) : wished(groups, wish, where);
    if (!is_ct(groups[place]))
        throw InputError(
            "the series " + describe(groups[place].series, place) + " is " + why_no_ct(groups[place]), where);
    return std::move(groups[place]);
}

std::vector<DicomSeries> list_dicom_series(const fs::path& folder)
{
    std::vector<DicomSeries> list;
    std::vector<std::string> notes; // notes about damaged files without a series; not used here
    for (const DicomGroup& group : group_dicom_series(scan_dicom(folder), notes))
        list.push_back(group.series);
    return list;
}

} // namespace retractor::datasets
