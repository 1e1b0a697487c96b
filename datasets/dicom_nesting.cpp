#include "datasets/dicom_nesting.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

namespace retractor {

namespace {

    constexpr std::uint32_t kUndefined = 0xFFFFFFFFU;

    std::uint32_t word(const char* bytes)
    {
        std::uint32_t value = 0;
        std::memcpy(&value, bytes, sizeof value);
        return value;
    }

    /// The ends (bytes from the start of the file) of the items that are open.
    class OpenItems {
    public:
        void begin(std::uint64_t place, std::uint32_t length)
        {
            leave(place);
            ends_.push_back(
                length == kUndefined ? std::numeric_limits<std::uint64_t>::max() : place + kHeader + length);
        }
        void end()
        {
            if (!ends_.empty())
                ends_.pop_back();
        }
        void leave(std::uint64_t place)
        {
            while (!ends_.empty() && ends_.back() <= place)
                ends_.pop_back();
        }
        int depth() const { return static_cast<int>(ends_.size()); }

    private:
        static constexpr std::uint64_t kHeader = 8;
        std::vector<std::uint64_t> ends_;
    };

} // namespace

int dicom_nesting(const std::filesystem::path& path, int limit)
{
    constexpr std::uint32_t kItem = 0xE000FFFEU;
    constexpr std::uint32_t kItemEnd = 0xE00DFFFEU;
    constexpr std::uint32_t kPixels = 0x00107FE0U;
    constexpr std::size_t kChunk = 1 << 16;
    constexpr std::size_t kHeader = 8;
    std::ifstream in(path, std::ios::binary);
    OpenItems items;
    int deepest = 0;
    std::string bytes;
    std::uint64_t start = 0; // of `bytes` in the file
    while (in && deepest < limit) {
        const std::size_t kept = bytes.size();
        bytes.resize(kept + kChunk);
        in.read(bytes.data() + kept, kChunk);
        bytes.resize(kept + static_cast<std::size_t>(in.gcount()));
        std::size_t at = 0;
        for (; at + kHeader <= bytes.size() && deepest < limit; at += 2) { // all elements lie at even places
            const std::uint32_t tag = word(bytes.data() + at);
            if (tag == kItem) {
                items.begin(start + at, word(bytes.data() + at + 4));
                deepest = std::max(deepest, items.depth());
            } else if (tag == kItemEnd && word(bytes.data() + at + 4) == 0) {
                items.end();
            } else if (tag == kPixels) {
                items.leave(start + at);
                if (items.depth() == 0)
                    return deepest;
            }
        }
        bytes.erase(0, at);
        start += at;
    }
    return deepest;
}

} // namespace retractor
