#include "ui/cli/training/trial_charts.h"

#include "ui/scene/vtk/render.h"

namespace retractor::ui::cli {

namespace {

    constexpr double kHalf = 0.3; ///< half the width of a box

    /// Adds the low and the high end, the box from quartile to quartile, and the median. All are curves with the same
    /// name.
    void add_box(ChartPanel& panel, double x, const haptics::BoxNumbers& box)
    {
        const auto curve = [&](std::vector<double> xs, std::vector<double> ys) {
            panel.series.push_back({ .name = "quartiles, median, ends",
                .x = std::move(xs),
                .y = std::move(ys),
                .marks = false,
                .in_legend = x == 1.0 && panel.series.size() == 1 });
        };
        const double left = x - kHalf, right = x + kHalf, inner = 0.5 * kHalf;
        curve({ left, right, right, left, left },
            { box.lower_quartile, box.lower_quartile, box.upper_quartile, box.upper_quartile, box.lower_quartile });
        curve({ left, right }, { box.median, box.median });
        curve({ x, x }, { box.low, box.lower_quartile });
        curve({ x, x }, { box.upper_quartile, box.high });
        curve({ x - inner, x + inner }, { box.low, box.low });
        curve({ x - inner, x + inner }, { box.high, box.high });
    }

} // namespace

void write_box_chart(
    const std::filesystem::path& file, const std::vector<BoxSeries>& series, const std::string& x_title, const Job& job)
{
    ChartPicture chart { .x_title = {},
        .y_title = "chosen, MPa",
        .panels = {},
        .columns = static_cast<int>(series.size()),
        .panel_width = 640,
        .panel_height = 520,
        .logarithmic_x = false,
        .logarithmic_y = false };
    for (const BoxSeries& one : series) {
        ChartPanel panel { .title = one.title, .series = {} };
        std::string names;
        for (std::size_t i = 0; i < one.labels.size(); ++i)
            names += (i == 0 ? "" : ", ")
                + (one.labels[i] == std::to_string(i + 1) ? one.labels[i]
                                                          : std::to_string(i + 1) + " " + one.labels[i]);
        panel.x_title = x_title + ": " + names;
        const double end = static_cast<double>(one.boxes.size()) + 0.5;
        panel.series.push_back({ .name = "right", .x = { 0.5, end }, .y = { one.target, one.target }, .marks = false });
        ChartSeries medians { .name = "median", .x = {}, .y = {} };
        for (std::size_t i = 0; i < one.boxes.size(); ++i) {
            add_box(panel, static_cast<double>(i + 1), one.boxes[i]);
            medians.x.push_back(static_cast<double>(i + 1));
            medians.y.push_back(one.boxes[i].median);
        }
        if (medians.x.size() > 1)
            panel.series.push_back(medians); // a curve needs two points
        chart.panels.push_back(std::move(panel));
    }
    OffscreenRenderer renderer(make_offscreen_context(), job);
    write_png(file, renderer.render(chart));
}

} // namespace retractor::ui::cli
