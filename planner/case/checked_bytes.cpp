#include "planner/case/checked_bytes.h"

#include <boost/crc.hpp>

#include <cstring>

namespace retractor::planner {

std::uint32_t crc32(std::string_view bytes)
{
    boost::crc_32_type sum;
    sum.process_bytes(bytes.data(), bytes.size());
    return sum.checksum();
}

std::string with_sum(std::string_view mark, std::string_view bytes)
{
    const std::uint32_t sum = crc32(bytes);
    std::string content(mark);
    content.append(reinterpret_cast<const char*>(&sum), sizeof sum);
    content += bytes;
    return content;
}

std::optional<std::string_view> without_sum(std::string_view mark, std::string_view content)
{
    std::uint32_t sum = 0;
    const std::size_t header = mark.size() + sizeof sum;
    if (content.size() < header || !content.starts_with(mark))
        return std::nullopt;
    std::memcpy(&sum, content.data() + mark.size(), sizeof sum);
    const std::string_view bytes = content.substr(header);
    return crc32(bytes) == sum ? std::optional(bytes) : std::nullopt;
}

} // namespace retractor::planner
