#pragma once
// A folder for files that nobody keeps: the folder is removed with the object.

#include "mesh/base/error.h"

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

namespace retractor::test_support {

struct TemporaryFolder {
    /// @throws IoError when it cannot be made.
    TemporaryFolder()
    {
        std::string name = (std::filesystem::temp_directory_path() / "retractor-XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr)
            throw IoError("no temporary folder could be made", name);
        path = name;
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder()
    {
        std::error_code ignored; // it lies in the folder for temporary files
        std::filesystem::remove_all(path, ignored);
    }
    std::filesystem::path operator/(const std::string& name) const { return path / name; }

    std::filesystem::path path;
};

} // namespace retractor::test_support
