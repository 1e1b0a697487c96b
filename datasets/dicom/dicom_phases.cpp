#include "datasets/dicom/dicom_geometry.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <map>
#include <set>

namespace retractor::datasets {

namespace {

    /// The images at one place, [begin, end) of the sorted slices.
    struct Place {
        std::size_t begin = 0;
        std::size_t end = 0;
        std::size_t count() const { return end - begin; }
    };

    constexpr std::size_t kShown = 4; // most names or values in a message

    std::vector<Place> places_of(const std::vector<double>& heights)
    {
        constexpr double kSamePlace = 1e-3; // mm; the slices of every scanner are farther apart
        std::vector<Place> places;
        for (std::size_t s = 0; s < heights.size(); ++s) {
            if (s == 0 || heights[s] - heights[s - 1] >= kSamePlace)
                places.push_back({ s, s });
            places.back().end = s + 1;
        }
        return places;
    }

    const std::string& phase_value(const DicomSlice& slice, const std::vector<DicomFile>& files, std::size_t tag)
    {
        return files[slice.file].frames[static_cast<std::size_t>(slice.frame)].phase[tag];
    }

    std::string list(const std::vector<std::string>& values)
    {
        std::string text;
        for (std::size_t v = 0; v < std::min(values.size(), kShown); ++v)
            text += (v > 0 ? ", " : "") + (values[v].empty() ? "(none)" : values[v]);
        return values.size() > kShown ? text + " ..." : text;
    }

    /// Describes the tag whose values separate the images into stacks with one image per place. Empty when no tag does.
    std::string separating_tag(
        const std::vector<DicomSlice>& slices, const std::vector<Place>& places, const std::vector<DicomFile>& files)
    {
        const std::size_t images = places.front().count();
        for (std::size_t tag = 0; tag < kDicomPhaseTags.size(); ++tag) {
            std::map<std::string, std::size_t> stacks;
            bool once = true;
            for (const Place& place : places) {
                std::set<std::string> here;
                for (std::size_t s = place.begin; s < place.end; ++s) {
                    const std::string& value = phase_value(slices[s], files, tag);
                    once = once && here.insert(value).second;
                    ++stacks[value];
                }
            }
            if (!once || stacks.size() != images)
                continue;
            std::vector<std::string> values;
            for (const auto& [value, count] : stacks)
                values.push_back(value);
            return kDicomPhaseTags[tag] + " tells them apart (" + list(values) + ")";
        }
        return {};
    }

    /// Names of the tags with several values among the images at one place.
    std::string differing_tags(
        const std::vector<DicomSlice>& slices, const Place& place, const std::vector<DicomFile>& files)
    {
        std::vector<std::string> tags;
        for (std::size_t tag = 0; tag < kDicomPhaseTags.size(); ++tag)
            for (std::size_t s = place.begin + 1; s < place.end; ++s)
                if (phase_value(slices[s], files, tag) != phase_value(slices[place.begin], files, tag)) {
                    tags.push_back(kDicomPhaseTags[tag]);
                    break;
                }
        return list(tags);
    }

    bool same_object_twice(
        const std::vector<DicomSlice>& slices, const Place& place, const std::vector<DicomFile>& files)
    {
        for (std::size_t s = place.begin + 1; s < place.end; ++s) {
            const DicomFile& a = files[slices[s].file];
            const DicomFile& b = files[slices[s - 1].file];
            if (a.sop_instance.empty() || a.sop_instance != b.sop_instance || a.path == b.path)
                return false;
        }
        return true;
    }

    std::string names_at(const std::vector<DicomSlice>& slices, const Place& place, const std::vector<DicomFile>& files)
    {
        std::vector<std::string> names;
        for (std::size_t s = place.begin; s < place.end; ++s)
            names.push_back(slice_name(slices[s], files));
        return list(names);
    }

    std::string describe_stacks(const std::vector<DicomSlice>& slices, const std::vector<Place>& places,
        const std::vector<double>& heights, const std::vector<DicomFile>& files)
    {
        std::string text = std::to_string(places.front().count()) + " images at "
            + (places.size() == 1 ? "the same place (" : "each of " + std::to_string(places.size()) + " positions (")
            + mm_text(heights.front()) + (places.size() == 1 ? std::string() : " to " + mm_text(heights.back()))
            + " mm along the normal; first: " + names_at(slices, places.front(), files)
            + "): phases of one 4-D series?";
        const std::string tag = separating_tag(slices, places, files);
        if (!tag.empty())
            return text + " " + tag + ": export each as a series of its own";
        const std::string differing = differing_tags(slices, places.front(), files);
        return text
            + (differing.empty() ? " no tag tells them apart"
                                 : " no tag tells them apart everywhere; different: " + differing);
    }

} // namespace

void check_places(
    const std::vector<DicomSlice>& slices, const std::vector<double>& heights, const std::vector<DicomFile>& files)
{
    const std::vector<Place> places = places_of(heights);
    if (places.size() == slices.size())
        return;
    const std::string where
        = files[slices.front().file].path.parent_path().string() + " ImagePositionPatient (0020,0032)";
    const auto same = [&](const Place& p) { return p.count() == places.front().count(); };
    const auto copied = [&](const Place& p) { return p.count() == 1 || same_object_twice(slices, p, files); };
    const bool copies = std::all_of(places.begin(), places.end(), copied);
    if (std::all_of(places.begin(), places.end(), same) && !copies)
        throw InputError(describe_stacks(slices, places, heights, files), where);

    std::string text = copies ? "the same image twice" : "several images at the same place";
    std::size_t shown = 0;
    std::size_t repeated = 0;
    for (const Place& place : places) {
        if (place.count() == 1)
            continue;
        ++repeated;
        if (shown++ < kShown)
            text += std::string(shown > 1 ? ";" : ":") + " at " + mm_text(heights[place.begin])
                + " mm along the normal " + names_at(slices, place, files);
    }
    if (repeated > kShown)
        text += "; " + std::to_string(repeated) + " of " + std::to_string(places.size()) + " positions in all";
    const auto crowded = std::find_if(places.begin(), places.end(), [](const Place& p) { return p.count() > 1; });
    if (!copies)
        if (const std::string tags = differing_tags(slices, *crowded, files); !tags.empty())
            text += "; different there: " + tags;
    throw InputError(text, where);
}

} // namespace retractor::datasets
