#include "datasets/label_file_names.h"

#include "mesh/base/error.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>

namespace retractor {

namespace {

    constexpr std::size_t kHeader = 348;
    constexpr std::size_t kMostExtension = std::size_t { 16 }
        << 20; ///< bytes; names of some hundred structures are 20 kB

    template <typename T> T number_at(const std::string& bytes, std::size_t at, bool swap)
    {
        std::array<char, sizeof(T)> raw {};
        std::memcpy(raw.data(), bytes.data() + at, sizeof(T));
        if (swap)
            std::reverse(raw.begin(), raw.end());
        T value {};
        std::memcpy(&value, raw.data(), sizeof(T));
        return value;
    }

    /// The first bytes of a file, inflated where it is compressed.
    class FileHead {
    public:
        explicit FileHead(const std::filesystem::path& path)
            : file_(gzopen(path.c_str(), "rb"), gzclose)
        {
        }
        bool is_open() const { return file_ != nullptr; }
        std::string next(std::size_t count)
        {
            std::string bytes(count, '\0');
            const int got = gzread(file_.get(), bytes.data(), static_cast<unsigned>(count));
            bytes.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
            return bytes;
        }

    private:
        std::unique_ptr<gzFile_s, int (*)(gzFile)> file_;
    };

    /// The extensions' bytes, one after the other; empty when there are none.
    std::string read_extensions(const std::filesystem::path& path)
    {
        const std::string where = path.string();
        FileHead file(path);
        if (!file.is_open())
            throw IoError("cannot be opened", where);
        const std::string header = file.next(kHeader + 4);
        if (header.size() < kHeader + 4 || header.compare(344, 3, "n+1") != 0 || header[kHeader] == 0)
            return {};
        const bool swap = number_at<std::int32_t>(header, 0, false) != static_cast<std::int32_t>(kHeader);
        const double end = static_cast<double>(number_at<float>(header, 108, swap));
        std::string text;
        for (auto at = static_cast<double>(kHeader + 4); at + 8 <= end;) {
            const std::string head = file.next(8);
            const std::int32_t size = head.size() == 8 ? number_at<std::int32_t>(head, 0, swap) : 0;
            if (size < 8 || at + size > end || static_cast<std::size_t>(size) + text.size() > kMostExtension)
                throw InputError("the extension of the NIfTI header is damaged", where);
            const std::string body = file.next(static_cast<std::size_t>(size) - 8);
            if (body.size() != static_cast<std::size_t>(size) - 8)
                throw InputError("the extension of the NIfTI header is cut short", where);
            text += body;
            at += size;
        }
        return text;
    }

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

    /// The text of an element: as it is in a CDATA section, else with entities.
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
        // Id 0 is the background, which some programs name too.
        if (*key != 0 && !names.emplace(*key, element_text(rest.substr(open_end + 1, close - open_end - 1))).second)
            throw InputError("the names in the file's header give id " + std::to_string(*key) + " twice", where);
        rest.remove_prefix(close);
    }
    return names;
}

std::map<Label, std::string> label_names_in_file(const std::filesystem::path& image)
{
    const std::string name = image.filename().string();
    if (!name.ends_with(".nii") && !name.ends_with(".nii.gz"))
        return {};
    return label_names_from_xml(read_extensions(image), image.string());
}

} // namespace retractor
