// Charts drawn by OSMesa.

#include "ui/scene/vtk/chart.h"

#include "tests/ui/scene/pictures.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace retractor::ui {
namespace chart_test {

    struct Ink {
        int r = 0, g = 0, b = 0;
    };
    constexpr Ink kFirst { 0, 114, 178 }; // of the first name in a chart

    int pixels_of(const Image& image, const Ink& ink)
    {
        int count = 0;
        for (std::size_t i = 0; i + 2 < image.rgb.size(); i += 3)
            count += image.rgb[i] == ink.r && image.rgb[i + 1] == ink.g && image.rgb[i + 2] == ink.b;
        return count;
    }

    ChartPicture picture_of(std::vector<ChartSeries> series)
    {
        return { .x_title = "run time, s", .y_title = "error", .panels = { { "a panel", std::move(series) } } };
    }

    TEST(Charts, ASeriesOfOnePointIsAMark)
    {
        const auto inked = [](bool marks) {
            return pixels_of(
                samples::renderer().render(
                    picture_of({ { .name = "one", .x = { 1.0 }, .y = { 1.0 }, .marks = marks, .in_legend = false } })),
                kFirst);
        };
        constexpr int kMark = 20; // pixels of a mark of 8 x 8, its rim blended with the ground
        EXPECT_GT(inked(true), kMark);
        EXPECT_EQ(inked(false), 0);
    }

    /// A curve in one corner, points of seven more names in the middle: the legend is large.
    ChartPicture cornered(double x, double y, bool legend)
    {
        std::vector<ChartSeries> series {
            { .name = "curve", .x = { 0.5 * (1.0 + x), x }, .y = { y, y }, .in_legend = false }
        };
        for (int i = 0; i < 7; ++i)
            series.push_back({ .name = "another name, number " + std::to_string(i),
                .x = { 0.0, 0.001, 1.0 },
                .y = { 0.0, 0.5, 0.0 },
                .marks = false,
                .in_legend = legend });
        ChartPicture picture = picture_of(std::move(series));
        picture.logarithmic_x = picture.logarithmic_y = false;
        return picture;
    }

    TEST(Charts, TheLegendCoversNoCurve)
    {
        for (const double x : { 0.0, 1.0 }) {
            const int without = pixels_of(samples::renderer().render(cornered(x, 1.0, false)), kFirst);
            const int with = pixels_of(samples::renderer().render(cornered(x, 1.0, true)), kFirst);
            ASSERT_GT(without, 0);
            EXPECT_EQ(with, without) << "curve towards x = " << x;
        }
    }

    TEST(Charts, WhereEachCornerIsTakenThePlotMakesRoomAbove)
    {
        const std::vector<double> x { 0.0, 1.0, 1.0, 0.0, 0.0 }, y { 0.0, 0.0, 1.0, 1.0, 0.0 };
        const auto framed = [&](bool legend) {
            std::vector<ChartSeries> series { { .name = "frame", .x = x, .y = y, .marks = false, .in_legend = false } };
            for (int i = 0; i < 3; ++i)
                series.push_back({ .name = "a long name of a curve, number " + std::to_string(i),
                    .x = { 0.1 },
                    .y = { 0.1 },
                    .marks = false,
                    .in_legend = legend });
            ChartPicture picture = picture_of(std::move(series));
            picture.logarithmic_x = picture.logarithmic_y = false;
            return pixels_of(samples::renderer().render(picture), kFirst);
        };
        const int without = framed(false), with = framed(true);
        // Its upper side is as long as before and all there; its sides are lower by the legend's height.
        EXPECT_LT(with, without);
        constexpr double kShorterAtMost = 0.25;
        EXPECT_GT(with, (1.0 - kShorterAtMost) * without);
    }

    TEST(Charts, ALegendBesideThePlotLeavesAllOfItFree)
    {
        const auto right_side = [](bool beside) {
            std::vector<ChartSeries> series { { .name = "right side",
                .x = { 0.0, 1.0, 1.0 },
                .y = { 0.0, 0.0, 1.0 },
                .marks = false,
                .in_legend = false } };
            for (int i = 0; i < 8; ++i)
                series.push_back({ .name = "a long name of a curve, number " + std::to_string(i),
                    .x = { 0.1 },
                    .y = { 0.1 },
                    .marks = false });
            ChartPicture picture = picture_of(std::move(series));
            picture.logarithmic_x = picture.logarithmic_y = false;
            picture.panels[0].legend_beside = beside;
            const Image image = samples::renderer().render(picture);
            int column = 0, height = 0; // of the last column with ink of the curve, and how much is in it
            for (int x = 0; x < image.width; ++x) {
                int ink = 0;
                for (int y = 0; y < image.height; ++y) {
                    const std::size_t at = 3
                        * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width)
                            + static_cast<std::size_t>(x));
                    ink += image.rgb[at] == kFirst.r && image.rgb[at + 1] == kFirst.g && image.rgb[at + 2] == kFirst.b;
                }
                if (ink > 0) {
                    column = x;
                    height = ink;
                }
            }
            return std::pair(column, height);
        };
        const auto [on, on_height] = right_side(false);
        const auto [beside, beside_height] = right_side(true);
        constexpr int kLegend = 180; // pixels, about, of those names
        EXPECT_LT(beside, on - kLegend);
        EXPECT_EQ(beside_height, on_height) << "the plot is as high, and nothing lies on the curve";
    }

} // namespace chart_test
} // namespace retractor::ui
