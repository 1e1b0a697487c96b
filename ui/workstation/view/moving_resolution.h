#pragma once

#include <vector>

namespace retractor::ui {

/// How coarse the picture has to be while it moves, so that this machine draws it in time. Coarser at once where
/// drawings take too long; finer again, at rest, where they were quick.
class MovingResolution {
public:
    /// Pixels drawn for each of the screen's, along each side: 0.5 to 1.
    double scale() const { return scale_; }
    /// Begins with what a drawing with all pixels takes (ms). @return whether the scale has changed
    bool begin(double ms);
    /// Notes the duration of a drawing (ms). @return whether the scale has changed
    bool drawn(double ms);
    /// The picture has come to rest. @return whether the scale has changed
    bool rested();

private:
    void set_scale(double scale);

    double scale_ = 1.0;
    int first_ = 0; ///< drawings since the scale changed that are not counted: they load textures and surfaces
    std::vector<double> drawings_ms_; ///< since the scale changed, or since the last rest
};

} // namespace retractor::ui
