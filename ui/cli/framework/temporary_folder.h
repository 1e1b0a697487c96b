#pragma once
// A temporary folder that the destructor deletes.

#include "mesh/base/error.h"

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

namespace retractor::ui::cli {

struct TemporaryFolder {
    /// @throws IoError when the folder cannot be made
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
    std::filesystem::path path;
};

} // namespace retractor::ui::cli
