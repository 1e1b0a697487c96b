#pragma once
// Bytes of a file with a mark of their kind before them, and a sum that finds damage.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace retractor::planner {

/// The CRC-32 of the bytes.
std::uint32_t crc32(std::string_view bytes);

/// The mark, the sum of the bytes, and the bytes.
std::string with_sum(std::string_view mark, std::string_view bytes);

/// The bytes that with_sum() was given, within `content`; nothing: another mark, or the content is damaged.
std::optional<std::string_view> without_sum(std::string_view mark, std::string_view content);

} // namespace retractor::planner
