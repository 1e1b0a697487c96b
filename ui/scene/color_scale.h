#pragma once
// Colours of numbers on maps: from dark to bright, so that a map reads without colours, too.

#include "ui/scene/scene.h"

#include <string>
#include <vector>

namespace retractor::ui {

/// The colour at `share` from 0 (dark) to 1 (bright), after viridis. Shares beyond are cut off.
Color scale_color(double share);

/// Classes of numbers with a colour each, e.g. "below 5", "5 to 10", "10 or more".
struct ColorClasses {
    std::vector<double> limits; ///< ascending; between them and beyond lie limits.size() + 1 classes
    bool low_is_bright = false; ///< small numbers are what to look at

    std::size_t count() const { return limits.size() + 1; }
    /// The class of a number; a number at a limit belongs above it. @pre the number is finite
    std::size_t of(double number) const;
    Color color(std::size_t index) const;
    /// "5 to 10". @param digits after the point
    std::string words(std::size_t index, int digits = 0) const;
    /// One line for each class, the largest numbers first. @param unit behind each, e.g. "mm"
    std::vector<LegendLine> legend(const std::string& unit, int digits = 0) const;
};

} // namespace retractor::ui
