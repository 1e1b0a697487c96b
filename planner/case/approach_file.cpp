#include "planner/case/approach_file.h"

#include "planner/case/case.h"

#include <array>
#include <cstdio>
#include <string>

namespace retractor::planner {

std::filesystem::path approach_file(const std::filesystem::path& case_file, std::string_view kind,
    std::string_view approach, std::string_view extension)
{
    std::string name;
    for (const char c : approach) {
        const bool plain
            = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
        if (plain) {
            name += c;
            continue;
        }
        std::array<char, 4> code {};
        std::snprintf(code.data(), code.size(), "%%%02X", static_cast<unsigned>(static_cast<unsigned char>(c)));
        name += code.data();
    }
    std::string folder(kind);
    if (case_file.filename() != kCaseFileName)
        folder = case_file.stem().string() + "." + folder;
    return case_file.parent_path() / folder / name.append(extension);
}

} // namespace retractor::planner
