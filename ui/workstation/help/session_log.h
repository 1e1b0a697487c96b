#pragma once
// What the window told its user, with times, to be attached to a report of a fault. File names, which may hold the name
// of a patient, are left out.

#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <set>
#include <string>

namespace retractor::ui {

class SessionLog {
public:
    /// From now on this path, its folders' names and its file name are left out.
    void hide(const std::filesystem::path& path);
    /// @param kind "error" or "message"
    void add(const std::string& kind, const std::string& text);
    std::size_t size() const { return lines_.size(); }

    /// The log with versions of program, system and drawing library at its head.
    /// @param renderer of OpenGL, as the picture names it
    std::string text(const std::string& renderer) const;

private:
    static constexpr std::size_t kMostLines = 2000; ///< the oldest are dropped
    std::deque<std::string> lines_;
    std::set<std::string, std::greater<>> hidden_; ///< longer words that begin alike come first
};

/// The text without what looks like a path in the file system: "…" stands for it. A place in a case file, such as
/// "/approaches/0/depth_mm", stays.
std::string without_paths(const std::string& text);

} // namespace retractor::ui
