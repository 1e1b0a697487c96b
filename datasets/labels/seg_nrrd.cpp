#include "datasets/labels/seg_nrrd.h"

#include "datasets/io/header_text.h"
#include "datasets/io/image_reader.h"
#include "datasets/io/nrrd_header.h"
#include "mesh/base/error.h"

#include <limits>
#include <set>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    using Keys = std::map<std::string, std::string>;

    bool names_segments(const Keys& keys) { return keys.contains("Segment0_ID") || keys.contains("Segment0_Name"); }

    /// Converts "a:1|b:2|" to a map. Only the first colon of each part divides.
    std::map<std::string, std::string> tags_in(const std::string& text)
    {
        std::map<std::string, std::string> tags;
        std::size_t at = 0;
        while (at < text.size()) {
            const std::size_t end = std::min(text.find('|', at), text.size());
            const std::string part = text.substr(at, end - at);
            const std::size_t colon = part.find(':');
            if (colon != std::string::npos)
                tags[part.substr(0, colon)] = part.substr(colon + 1);
            at = end + 1;
        }
        return tags;
    }

    int integer_key(
        const Keys& keys, const std::string& key, int otherwise, int least, int most, const std::string& where)
    {
        const auto found = keys.find(key);
        if (found == keys.end())
            return otherwise;
        const std::int64_t value = integer_in(found->second, key, where);
        if (value < least || value > most)
            throw InputError("\"" + key + "\" must be from " + std::to_string(least) + " to " + std::to_string(most)
                    + ", it is " + std::to_string(value),
                where);
        return static_cast<int>(value);
    }

    /// Reads the segments. Files of Slicer before 4.11 have no layers, but one component or one value per segment.
    std::vector<Segment> segments_of(const Keys& keys, int layers, const std::string& where)
    {
        std::vector<Segment> segments;
        std::set<std::pair<int, Label>> taken;
        for (int n = 0;; ++n) {
            const std::string prefix = "Segment" + std::to_string(n) + "_";
            const auto text = [&](const char* key) {
                const auto found = keys.find(prefix + key);
                return found == keys.end() ? std::string() : trimmed(found->second);
            };
            if (!keys.contains(prefix + "ID") && !keys.contains(prefix + "Name"))
                return segments;
            Segment segment;
            segment.id = text("ID");
            segment.name = text("Name").empty() ? segment.id : text("Name");
            if (segment.name.empty())
                throw InputError("segment " + std::to_string(n) + " has neither name nor id", where);
            segment.layer = integer_key(keys, prefix + "Layer", layers > 1 ? n : 0, 0, layers - 1, where);
            segment.value = static_cast<Label>(
                integer_key(keys, prefix + "LabelValue", 1, 1, std::numeric_limits<Label>::max(), where));
            segment.tags = tags_in(text("Tags"));
            if (!taken.insert({ segment.layer, segment.value }).second)
                throw InputError("segment \"" + segment.name + "\" shares layer " + std::to_string(segment.layer)
                        + " and value " + std::to_string(segment.value) + " with another",
                    where);
            segments.push_back(std::move(segment));
        }
    }

    void check_values_named(const SegmentedImage& image, const std::string& where)
    {
        constexpr std::size_t kValues = std::size_t { std::numeric_limits<Label>::max() } + 1;
        const auto layers = static_cast<std::size_t>(image.layers);
        std::vector<bool> named(kValues * layers, false);
        for (std::size_t layer = 0; layer < layers; ++layer)
            named[layer * kValues] = true;
        for (const Segment& segment : image.segments)
            named[static_cast<std::size_t>(segment.layer) * kValues + segment.value] = true;
        for (std::size_t v = 0; v < image.voxels.size(); ++v)
            if (!named[v % layers * kValues + image.voxels[v]])
                throw InputError("layer " + std::to_string(v % layers) + " has the value "
                        + std::to_string(image.voxels[v]) + ", which no segment names",
                    where);
    }

} // namespace

bool is_seg_nrrd(const fs::path& path)
{
    const std::string name = lower_case(path.filename().string());
    if (!name.ends_with(".nrrd") && !name.ends_with(".nhdr"))
        return false;
    try {
        return names_segments(read_nrrd_header(path).keys);
    } catch (const Error&) {
        return false; // the reader of the file reports the reason
    }
}

SegmentedImage read_seg_nrrd(const fs::path& path, const Job& job)
{
    const std::string where = path.string();
    SegmentedImage image;
    const ImageHeader header = read_label_image(path, image.voxels, true, job);
    if (!names_segments(header.keys))
        throw InputError(
            "the file names no segments (Segment0_ID, Segment0_Name): not a segmentation of 3D Slicer", where);
    image.grid = header.grid;
    image.layers = header.components;
    image.notes = header.notes;
    image.segments = segments_of(header.keys, image.layers, where);
    if (!job.cancelled())
        check_values_named(image, where);
    return image;
}

} // namespace retractor::datasets
