#pragma once
// One window changes a case; other windows only look. A file beside the case says which window changes it.

#include <filesystem>
#include <memory>
#include <string>

class QLockFile;

namespace retractor::ui {

class CaseLock {
public:
    /// Takes the case for this window, unless another window has it. A lock whose window has crashed on this computer
    /// is taken over. Where no file can be written beside the case, the case counts as this window's: saving then says
    /// what is wrong.
    explicit CaseLock(const std::filesystem::path& case_file);
    /// Gives the case back.
    ~CaseLock();

    /// Whether this window may change the case.
    bool is_mine() const { return holder_.empty(); }
    /// Where the window is that changes the case: "on this computer", "on ward-3"; empty: it is this window.
    const std::string& holder() const { return holder_; }
    /// Of the lock: "case.lock" beside "case.json".
    static std::filesystem::path file_of(const std::filesystem::path& case_file);

private:
    std::unique_ptr<QLockFile> file_;
    std::string holder_;
};

} // namespace retractor::ui
