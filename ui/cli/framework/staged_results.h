#pragma once
// Files of one run that belong together. They are written aside and replace the files of an earlier run together, so
// that a run that fails, is cancelled or is killed leaves the earlier files as they were.

#include <filesystem>

namespace retractor::ui::cli {

/// A hidden folder for new files inside an existing folder.
class StagedResults {
public:
    /// Makes the hidden folder, and removes those that killed runs left behind. @pre `out` exists
    /// @throws IoError naming the folder
    explicit StagedResults(std::filesystem::path out);
    StagedResults(const StagedResults&) = delete;
    StagedResults& operator=(const StagedResults&) = delete;
    /// Removes what was not published.
    ~StagedResults();

    /// Where new files are written. Only files, no folders.
    const std::filesystem::path& folder() const { return staged_; }
    /// The place of a staged file after publish().
    std::filesystem::path published(const std::filesystem::path& staged_file) const;
    /// Moves all new files to their places; nothing is computed or written between the first move and the last. The
    /// earlier file `summary`, which describes the others, leaves first and the new one comes last: a run that is
    /// killed between two moves leaves no summary instead of one that describes other files.
    /// @throws IoError naming the file that cannot be moved
    void publish(const std::filesystem::path& summary);

private:
    std::filesystem::path out_, staged_;
};

} // namespace retractor::ui::cli
