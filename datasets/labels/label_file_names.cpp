#include "datasets/labels/label_file_names.h"

#include "datasets/io/header_text.h"
#include "datasets/io/nifti_header.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <optional>
#include <string_view>

namespace retractor::datasets {

namespace {

    std::string without_entities(std::string_view text)
    {
        static constexpr std::array<std::pair<std::string_view, char>, 5> kEntities { { { "&amp;", '&' },
            { "&lt;", '<' }, { "&gt;", '>' }, { "&quot;", '"' }, { "&apos;", '\'' } } };
        std::string plain;
        while (!text.empty()) {
            std::size_t length = 1;
            char c = text.front();
            for (const auto& [entity, meaning] : kEntities)
                if (text.starts_with(entity)) {
                    length = entity.size();
                    c = meaning;
                }
            plain += c;
            text.remove_prefix(length);
        }
        return plain;
    }

    /// The text of an element. A CDATA section is copied; entities in other text are replaced.
    std::string element_text(std::string_view body)
    {
        constexpr std::string_view kOpen = "<![CDATA[";
        if (!body.starts_with(kOpen))
            return without_entities(body);
        body.remove_prefix(kOpen.size());
        return std::string(body.substr(0, body.find("]]>")));
    }

    std::optional<Label> key_of(std::string_view tag)
    {
        constexpr std::string_view kKey = " Key=\"";
        const std::size_t found = tag.find(kKey);
        if (found == std::string_view::npos)
            return std::nullopt;
        const std::string_view digits = tag.substr(found + kKey.size());
        int key = -1;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), key);
        if (error != std::errc {} || end == digits.data() + digits.size() || *end != '"' || key < 0
            || key > std::numeric_limits<Label>::max())
            return std::nullopt;
        return static_cast<Label>(key);
    }

} // namespace

std::map<Label, std::string> label_names_from_xml(const std::string& xml, const std::string& where)
{
    std::map<Label, std::string> names;
    std::string_view rest(xml);
    for (std::size_t tag = rest.find("<Label "); tag != std::string_view::npos; tag = rest.find("<Label ")) {
        rest.remove_prefix(tag);
        const std::size_t open_end = rest.find('>');
        const std::size_t close = rest.find("</Label>");
        if (open_end == std::string_view::npos || close == std::string_view::npos || close < open_end)
            throw InputError("the names in the file's header are damaged", where);
        const std::optional<Label> key = key_of(rest.substr(0, open_end));
        if (!key)
            throw InputError("the names in the file's header have a key that is no id from 0 to 65535: "
                    + std::string(rest.substr(0, std::min<std::size_t>(open_end + 1, 60))),
                where);
        // Id 0 is the background. Some programs name it too.
        if (*key != 0 && !names.emplace(*key, element_text(rest.substr(open_end + 1, close - open_end - 1))).second)
            throw InputError("the names in the file's header give id " + std::to_string(*key) + " twice", where);
        rest.remove_prefix(close);
    }
    return names;
}

std::map<Label, std::string> label_names_in_file(const std::filesystem::path& image)
{
    const std::string name = lower_case(image.filename().string());
    if (!name.ends_with(".nii") && !name.ends_with(".nii.gz"))
        return {};
    std::string text;
    for (const NiftiExtension& extension : read_nifti_extensions(image))
        text += extension.bytes;
    return label_names_from_xml(text, image.string());
}

} // namespace retractor::datasets
