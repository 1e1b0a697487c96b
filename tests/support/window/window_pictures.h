#pragma once
// What tests look for in pictures of a window, and where they keep them to be looked at.

#include "ui/scene/tissue_colors.h"

#include <QDialog>
#include <QImage>
#include <QPixmap>

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>

namespace retractor::test_support {

/// A shaded, anti-aliased picture has hundreds of colours, a blank one a gradient of a few dozen.
inline constexpr std::size_t kColoursOfAPicture = 300;

inline std::size_t distinct_colours(const QImage& image)
{
    std::set<QRgb> colours;
    for (int y = 0; y < image.height(); ++y)
        for (int x = 0; x < image.width(); ++x)
            colours.insert(image.pixel(x, y));
    return colours.size();
}

/// Pixels of the target's hue, whatever the light: no tissue is green.
inline int target_pixels(const QImage& image)
{
    const ui::Color wanted = ui::target_color();
    const int hue = QColor::fromRgbF(wanted.r, wanted.g, wanted.b).hsvHue();
    constexpr int kHueTolerance = 15, kLeastSaturation = 120, kLeastValue = 60;
    int count = 0;
    for (int y = 0; y < image.height(); ++y)
        for (int x = 0; x < image.width(); ++x) {
            const QColor colour = image.pixelColor(x, y);
            if (std::abs(colour.hsvHue() - hue) <= kHueTolerance && colour.hsvSaturation() >= kLeastSaturation
                && colour.value() >= kLeastValue)
                ++count;
        }
    return count;
}

/// A picture's file: in the folder that RETRACTOR_PICTURES names, or in `otherwise`.
inline std::filesystem::path picture_file(const std::filesystem::path& otherwise, const std::string& name)
{
    const char* pictures = std::getenv("RETRACTOR_PICTURES");
    return (pictures != nullptr ? std::filesystem::path(pictures) : otherwise) / name;
}

/// Keeps a picture of a dialog as it stands. @return whether it is drawn
inline bool keep_picture(QDialog& dialog, const std::filesystem::path& file)
{
    const QPixmap picture = dialog.grab();
    return picture.width() > 200 && picture.height() > 100 && picture.save(QString::fromStdString(file.string()));
}

} // namespace retractor::test_support
