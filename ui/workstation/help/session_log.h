#pragma once
// What the window told its user, with times, to be attached to a report of a fault. No name or id of a patient, and no
// file path, gets into the log.

#include <cstddef>
#include <deque>
#include <string>

namespace retractor::ui {

class SessionLog {
public:
    /// @param kind "error", "message" or "action"
    void add(const std::string& kind, const std::string& text);
    std::size_t size() const { return lines_.size(); }

    /// The log with versions of program, system and drawing library at its head.
    /// @param renderer of OpenGL, as the picture names it
    std::string text(const std::string& renderer) const;

private:
    static constexpr std::size_t kMostLines = 2000; ///< the oldest are dropped
    std::deque<std::string> lines_;
};

/// The text without what looks like a path in the file system: "…" stands for it.
std::string without_paths(const std::string& text);

} // namespace retractor::ui
