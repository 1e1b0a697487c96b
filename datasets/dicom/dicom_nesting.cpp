#include "datasets/dicom/dicom_nesting.h"

#include <vtkDICOMVR.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <limits>
#include <string>

namespace retractor::datasets {

namespace {

    constexpr std::uint32_t kUndefined = 0xFFFFFFFFU;
    constexpr std::uint32_t kItem = 0xFFFEE000U;
    constexpr std::uint32_t kItemEnd = 0xFFFEE00DU;
    constexpr std::uint32_t kSequenceEnd = 0xFFFEE0DDU;
    constexpr std::uint64_t kNoBound = std::numeric_limits<std::uint64_t>::max();

    struct Syntax {
        bool explicit_vr = true;
        bool big_endian = false;
    };

    std::uint32_t number(const unsigned char* bytes, int count, bool big_endian)
    {
        std::uint32_t value = 0;
        for (int b = 0; b < count; ++b)
            value = value << 8 | bytes[big_endian ? b : count - 1 - b];
        return value;
    }

    std::uint32_t tag_at(const unsigned char* bytes, bool big_endian)
    {
        return number(bytes, 2, big_endian) << 16 | number(bytes + 2, 2, big_endian);
    }

    /// Walks through a file as the parser does, while both certainly agree. The walk stops at the first violation of
    /// the standard.
    class Walk {
    public:
        Walk(const std::filesystem::path& path, int limit)
            : in_(path, std::ios::binary)
            , limit_(limit)
        {
        }

        void run()
        {
            Syntax syntax;
            if (read_meta(syntax))
                elements(kNoBound, syntax, Within::file);
        }
        int deepest() const { return deepest_; }
        /// True when the walk met a violation of the standard, at place() and with depth() open items.
        bool odd() const { return odd_; }
        std::uint64_t place() const { return place_; }
        int depth() const { return depth_; }

    private:
        enum class Within { file, closed_item, open_item };

        struct Element {
            std::uint64_t start = 0;
            std::uint32_t tag = 0;
            std::uint32_t length = 0;
            vtkDICOMVR vr;
        };

        bool read(unsigned char* bytes, std::streamsize count)
        {
            in_.read(reinterpret_cast<char*>(bytes), count);
            at_ += static_cast<std::uint64_t>(in_.gcount());
            return in_.gcount() == count;
        }
        void go_to(std::uint64_t place)
        {
            constexpr std::uint64_t kNear = 1 << 12; // a seek discards buffered bytes, so short distances are read
            if (place >= at_ && place - at_ < kNear)
                in_.ignore(static_cast<std::streamsize>(place - at_));
            else
                in_.seekg(static_cast<std::streamoff>(place));
            at_ = place;
        }
        bool stop_odd(std::uint64_t place)
        {
            odd_ = true;
            place_ = place;
            return false;
        }

        /// Reads the preamble, and the meta header with the transfer syntax.
        bool read_meta(Syntax& syntax)
        {
            constexpr std::uint64_t kMeta = 132;
            constexpr std::uint32_t kLengthOfLength = 12;
            std::array<unsigned char, kMeta> preamble {};
            if (!read(preamble.data(), preamble.size())
                || std::string(preamble.begin() + 128, preamble.end()) != "DICM")
                return stop_odd(0);
            std::string uid;
            std::uint64_t declared_end = 0;
            Element e;
            while (read_head(e, Syntax {})) {
                if (e.tag >> 16 != 2) {
                    go_to(e.start);
                    break;
                }
                constexpr std::uint32_t kMostBytes = 1 << 16;
                if (e.vr == vtkDICOMVR::SQ || e.vr == vtkDICOMVR::UN || e.length > kMostBytes)
                    return stop_odd(kMeta);
                std::string value(e.length, '\0');
                if (!read(reinterpret_cast<unsigned char*>(value.data()), e.length))
                    return false;
                if (e.tag == 0x00020000U && e.length == 4)
                    declared_end = kMeta + kLengthOfLength
                        + number(reinterpret_cast<const unsigned char*>(value.data()), 4, false);
                if (e.tag == 0x00020010U && !uid.empty())
                    return stop_odd(kMeta);
                if (e.tag == 0x00020010U)
                    uid = value;
            }
            if (!uid.empty() && uid.back() == '\0')
                uid.pop_back();
            const bool clean
                = std::all_of(uid.begin(), uid.end(), [](char c) { return c == '.' || (c >= '0' && c <= '9'); });
            if (odd_ || uid.empty() || !clean || declared_end != at_)
                return stop_odd(kMeta);
            // The parser knows three UIDs of implicit little endian.
            syntax.explicit_vr
                = uid != "1.2.840.10008.1.2" && uid != "1.2.840.10008.1.20" && uid != "1.2.840.113619.5.2";
            syntax.big_endian = uid == "1.2.840.10008.1.2.2";
            return true;
        }

        bool read_head(Element& e, Syntax syntax)
        {
            std::array<unsigned char, 8> head {};
            e = { .start = at_, .tag = 0, .length = 0, .vr = {} };
            if (!read(head.data(), head.size()))
                return false;
            e.tag = tag_at(head.data(), syntax.big_endian);
            const bool delimiter = e.tag >> 16 == 0xFFFEU;
            if (!syntax.explicit_vr || delimiter) {
                e.length = (e.tag & 0xFFFFU) == 0 && !delimiter ? 4 : number(head.data() + 4, 4, syntax.big_endian);
                return true; // the length of a group length is always 4
            }
            e.vr = vtkDICOMVR(head.data() + 4);
            if (!e.vr.IsValid())
                return stop_odd(e.start);
            e.length = number(head.data() + 6, 2, syntax.big_endian);
            if (!e.vr.HasLongVL())
                return true;
            std::array<unsigned char, 4> length {};
            if (!read(length.data(), length.size()))
                return false;
            e.length = number(length.data(), 4, syntax.big_endian);
            return true;
        }

        /// Reads elements up to `bound`, to the end of an item of undefined length, or to the end of the file.
        bool elements(std::uint64_t bound, Syntax syntax, Within within)
        {
            while (within != Within::closed_item || at_ < bound) {
                Element e;
                if (!read_head(e, syntax))
                    return false;
                if (e.tag == kItemEnd && within == Within::open_item)
                    return at_ <= bound || stop_odd(e.start);
                if (e.tag >> 16 == 0xFFFEU || at_ > bound)
                    return stop_odd(e.start);
                if (!value(e, bound, syntax, within))
                    return false;
            }
            return at_ == bound || stop_odd(at_);
        }

        bool value(const Element& e, std::uint64_t bound, Syntax syntax, Within within)
        {
            const bool pixels = within == Within::file && (e.tag & 0xFF010000U) == 0x7F000000U;
            const bool unknown = !syntax.explicit_vr || e.vr == vtkDICOMVR::UN;
            const Syntax inner = unknown ? Syntax { .explicit_vr = false, .big_endian = false } : syntax;
            if (e.length == kUndefined) {
                if (pixels)
                    return fragments(e.start);
                return unknown || e.vr == vtkDICOMVR::SQ ? sequence(e.start, bound, false, inner) : stop_odd(e.start);
            }
            const std::uint64_t end = at_ + e.length;
            if (end > bound)
                return stop_odd(e.start);
            if (e.length > 0 && !pixels && (e.vr == vtkDICOMVR::SQ || (unknown && begins_with_item(e.length))))
                return sequence(e.start, end, true, inner);
            go_to(end);
            return true;
        }

        /// True when the value begins with an item. For the parser, an element without a type is a sequence when its
        /// dictionary says so; a walk without dictionary recognises sequences by their delimiters.
        bool begins_with_item(std::uint32_t length)
        {
            constexpr std::array<unsigned char, 2> kGroup { 0xFE, 0xFF };
            std::array<unsigned char, 2> head {};
            const std::uint64_t start = at_;
            const auto count = std::min<std::size_t>(length, head.size());
            if (!read(head.data(), static_cast<std::streamsize>(count)))
                return false;
            go_to(start);
            return std::equal(head.begin(), head.begin() + static_cast<std::ptrdiff_t>(count), kGroup.begin());
        }

        bool sequence(std::uint64_t start, std::uint64_t bound, bool closed, Syntax syntax)
        {
            while (!closed || at_ < bound) {
                Element e;
                if (!read_head(e, syntax))
                    return false;
                if (e.tag == kSequenceEnd && !closed)
                    return at_ <= bound || stop_odd(start);
                const bool open = e.length == kUndefined;
                if (e.tag != kItem || at_ > bound || (!open && at_ + e.length > bound))
                    return stop_odd(e.start);
                ++depth_;
                deepest_ = std::max(deepest_, depth_);
                if (deepest_ >= limit_
                    || !elements(open ? bound : at_ + e.length, syntax, open ? Within::open_item : Within::closed_item))
                    return false;
                --depth_;
            }
            return at_ == bound || stop_odd(start);
        }

        /// Reads compressed pixels, which are items without elements.
        bool fragments(std::uint64_t start)
        {
            Element e;
            while (read_head(e, Syntax {})) {
                if (e.tag == kSequenceEnd)
                    return true;
                if (e.tag != kItem || e.length == kUndefined)
                    return stop_odd(e.tag == kItem ? start : e.start);
                go_to(at_ + e.length);
            }
            return false;
        }

        std::ifstream in_;
        int limit_ = 0;
        std::uint64_t at_ = 0;
        int depth_ = 0;
        int deepest_ = 0;
        bool odd_ = false;
        std::uint64_t place_ = 0;
    };

    /// Counts bytes that could begin an item, in either byte order, at any place from `start` on.
    int count_items(const std::filesystem::path& path, std::uint64_t start, int limit)
    {
        constexpr std::size_t kChunk = 1 << 16;
        constexpr std::size_t kTag = 4;
        std::ifstream in(path, std::ios::binary);
        in.seekg(static_cast<std::streamoff>(start));
        std::string bytes;
        int count = 0;
        while (in && count < limit) {
            const std::size_t kept = bytes.size();
            bytes.resize(kept + kChunk);
            in.read(bytes.data() + kept, kChunk);
            bytes.resize(kept + static_cast<std::size_t>(in.gcount()));
            const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
            for (std::size_t at = 0; at + kTag <= bytes.size() && count < limit; ++at)
                count += tag_at(data + at, false) == kItem || tag_at(data + at, true) == kItem ? 1 : 0;
            bytes.erase(0, bytes.size() - std::min(bytes.size(), kTag - 1));
        }
        return count;
    }

} // namespace

int dicom_nesting(const std::filesystem::path& path, int limit)
{
    Walk walk(path, limit);
    walk.run();
    if (!walk.odd() || walk.deepest() >= limit)
        return std::min(walk.deepest(), limit);
    const int left = limit - walk.depth();
    return std::max(walk.deepest(), walk.depth() + count_items(path, walk.place(), left));
}

bool nests_too_deep(const std::filesystem::path& path)
{
    constexpr int kDeepest = 64;
    return dicom_nesting(path, kDeepest) >= kDeepest;
}

} // namespace retractor::datasets
