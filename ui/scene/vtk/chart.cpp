#include "ui/scene/vtk/chart.h"

#include <vtkAxis.h>
#include <vtkChartLegend.h>
#include <vtkChartXY.h>
#include <vtkContextActor.h>
#include <vtkContextScene.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPen.h>
#include <vtkPlotPoints.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>
#include <vtkVariant.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace retractor::ui {

namespace {

    using Rgb = std::array<unsigned char, 3>;

    /// Colours that people with red-green blindness can tell apart [Okabe, Ito 2008].
    constexpr std::array<Rgb, 8> kSeriesColors { { { 0, 114, 178 }, { 213, 94, 0 }, { 0, 158, 115 }, { 204, 121, 167 },
        { 86, 180, 233 }, { 230, 159, 0 }, { 0, 0, 0 }, { 130, 130, 130 } } };
    constexpr std::array<int, 4> kMarks { vtkPlotPoints::CIRCLE, vtkPlotPoints::SQUARE, vtkPlotPoints::DIAMOND,
        vtkPlotPoints::CROSS };

    std::map<std::string, std::size_t> number_names(const ChartPicture& picture)
    {
        std::map<std::string, std::size_t> numbers;
        for (const ChartPanel& panel : picture.panels)
            for (const ChartSeries& series : panel.series)
                numbers.try_emplace(series.name, numbers.size());
        return numbers;
    }

    struct Range {
        double low = std::numeric_limits<double>::infinity(), high = -low;

        void add(double v)
        {
            low = std::min(low, v);
            high = std::max(high, v);
        }
        double share(double v) const { return (v - low) / (high - low); }
    };

    void title_axis(vtkAxis& axis, const std::string& title)
    {
        axis.SetTitle(title);
        axis.GetTitleProperties()->SetFontSize(14);
        axis.GetTitleProperties()->SetBold(false);
        axis.GetLabelProperties()->SetFontSize(12);
        axis.GetGridPen()->SetColor(225, 225, 225);
    }

    /// The range of an axis: the data with a small margin; on logarithmic axes full decades.
    Range axis_range(Range data, bool logarithmic)
    {
        if (!(data.low <= data.high))
            return { 0.0, 1.0 };
        constexpr double kDecades = 0.2;
        if (logarithmic)
            return { std::floor(data.low - kDecades), std::ceil(data.high + kDecades) };
        const double margin = data.high > data.low ? 0.04 * (data.high - data.low) : 0.5;
        return { data.low - margin, data.high + margin };
    }

    /// Labels an axis with powers of ten, at most about six.
    void label_decades(vtkAxis& axis, const Range& range)
    {
        const int every = std::max(1, static_cast<int>(std::ceil((range.high - range.low) / 6.0)));
        vtkNew<vtkDoubleArray> positions;
        vtkNew<vtkStringArray> labels;
        for (int decade = static_cast<int>(range.low); decade <= static_cast<int>(range.high); decade += every) {
            positions->InsertNextValue(decade);
            labels->InsertNextValue("1e" + std::to_string(decade));
        }
        axis.SetCustomTickPositions(positions, labels);
    }

    void label_axis(vtkAxis& axis, const Range& range, bool logarithmic, const std::string& title)
    {
        axis.SetBehavior(vtkAxis::FIXED);
        axis.SetRange(range.low, range.high);
        if (logarithmic)
            label_decades(axis, range);
        title_axis(axis, title);
    }

    constexpr int kLegendFont = 12, kTitleFont = 16;

    /// Approximate share of a panel's plot that the legend covers, from its longest name and the number of names.
    struct LegendSize {
        double width = 0.0, height = 0.0; ///< shares of the plot's width and height
    };

    LegendSize legend_size(const ChartPanel& panel, const ChartPicture& picture)
    {
        constexpr double kFrame = 75.0; // axes, their titles and labels; pixels
        constexpr double kLine = 17.5, kLetter = 7.0, kSymbol = 45.0; // at the legend's font
        std::size_t names = 0, longest = 0;
        for (const ChartSeries& series : panel.series)
            if (series.in_legend) {
                ++names;
                longest = std::max(longest, series.name.size());
            }
        return { (kSymbol + kLetter * static_cast<double>(longest)) / (picture.panel_width - kFrame),
            (10.0 + kLine * static_cast<double>(names)) / (picture.panel_height - kFrame) };
    }

    /// Points along the curves of a panel, as shares of its ranges.
    std::vector<std::array<double, 2>> inked(
        const std::vector<vtkSmartPointer<vtkTable>>& tables, const Range& x, const Range& y)
    {
        constexpr int kPerSegment = 20;
        std::vector<std::array<double, 2>> points;
        for (const auto& table : tables) {
            const auto at = [&](vtkIdType row, int column) { return table->GetValue(row, column).ToDouble(); };
            for (vtkIdType row = 0; row < table->GetNumberOfRows(); ++row)
                for (int i = 0; i < kPerSegment; ++i) {
                    const vtkIdType next = std::min(row + 1, table->GetNumberOfRows() - 1);
                    const double t = static_cast<double>(i) / kPerSegment;
                    points.push_back({ x.share((1.0 - t) * at(row, 0) + t * at(next, 0)),
                        y.share((1.0 - t) * at(row, 1) + t * at(next, 1)) });
                }
        }
        return points;
    }

    /// Places the legend beside the plot when the panel requests it. Otherwise the legend goes to the corner with the
    /// fewest curves. When all corners have curves, the plot grows upwards to make room.
    void place_legend(vtkChartLegend& legend, const ChartPanel& panel, const ChartPicture& picture,
        const std::vector<vtkSmartPointer<vtkTable>>& tables, const Range& x, Range& y)
    {
        if (panel.legend_beside) {
            legend.SetInline(false);
            legend.SetHorizontalAlignment(vtkChartLegend::RIGHT);
            legend.SetVerticalAlignment(vtkChartLegend::CENTER);
            return;
        }
        const LegendSize size = legend_size(panel, picture);
        const auto points = inked(tables, x, y);
        struct Corner {
            int horizontal, vertical;
        };
        constexpr std::array<Corner, 4> kCorners { { { vtkChartLegend::RIGHT, vtkChartLegend::TOP },
            { vtkChartLegend::RIGHT, vtkChartLegend::BOTTOM }, { vtkChartLegend::LEFT, vtkChartLegend::BOTTOM },
            { vtkChartLegend::LEFT, vtkChartLegend::TOP } } };
        const auto covered = [&](const Corner& corner) {
            return std::count_if(points.begin(), points.end(), [&](const std::array<double, 2>& p) {
                const double from_side = corner.horizontal == vtkChartLegend::RIGHT ? 1.0 - p[0] : p[0];
                const double from_edge = corner.vertical == vtkChartLegend::TOP ? 1.0 - p[1] : p[1];
                return from_side < size.width && from_edge < size.height;
            });
        };
        const Corner best = *std::min_element(kCorners.begin(), kCorners.end(),
            [&](const Corner& a, const Corner& b) { return covered(a) < covered(b); });
        constexpr double kMostOfPlot = 0.6;
        if (covered(best) == 0 || size.height > kMostOfPlot) {
            legend.SetHorizontalAlignment(best.horizontal);
            legend.SetVerticalAlignment(best.vertical);
            return;
        }
        double highest = 0.0;
        for (const auto& p : points)
            highest = std::max(highest, p[1]);
        y.high = y.low + (y.high - y.low) * std::max(1.0, highest / (1.0 - size.height));
        legend.SetHorizontalAlignment(vtkChartLegend::RIGHT);
        legend.SetVerticalAlignment(vtkChartLegend::TOP);
    }

    /// Long titles get smaller letters, so that they do not run into the next panel.
    int title_font(const std::string& title, int panel_width)
    {
        constexpr double kLetter = 0.5; // width of a letter over the font's size
        const double fits
            = 0.85 * panel_width / (kLetter * static_cast<double>(std::max<std::size_t>(title.size(), 1)));
        return std::clamp(static_cast<int>(fits), 9, kTitleFont);
    }

    /// The points of a chart. Decades are drawn on linear axes, because vtkChartXY's own logarithmic axes lose points
    /// at the first change of range.
    vtkSmartPointer<vtkTable> chart_table(
        const ChartSeries& series, bool log_x, bool log_y, Range& x_range, Range& y_range)
    {
        const auto table = vtkSmartPointer<vtkTable>::New();
        vtkNew<vtkDoubleArray> x, y;
        x->SetName("x");
        y->SetName(series.name.c_str());
        for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
            const double lx = log_x ? std::log10(series.x[i]) : series.x[i];
            const double ly = log_y ? std::log10(series.y[i]) : series.y[i];
            if (!std::isfinite(lx) || !std::isfinite(ly))
                continue;
            x->InsertNextValue(lx);
            y->InsertNextValue(ly);
            x_range.add(lx);
            y_range.add(ly);
        }
        table->AddColumn(x);
        table->AddColumn(y);
        return table;
    }

    void add_series(
        vtkChartXY& chart, const vtkSmartPointer<vtkTable>& table, const ChartSeries& series, std::size_t number)
    {
        const bool line = table->GetNumberOfRows() > 1; // VTK refuses to draw a line through a single point
        auto* plot = vtkPlotPoints::SafeDownCast(chart.AddPlot(line ? vtkChart::LINE : vtkChart::POINTS));
        const Rgb& color = kSeriesColors[number % kSeriesColors.size()];
        plot->SetInputData(table, 0, 1);
        plot->SetLabel(series.in_legend ? series.name : std::string());
        plot->SetLegendVisibility(series.in_legend);
        plot->SetColor(color[0], color[1], color[2], 255);
        plot->SetWidth(2.0F);
        plot->SetMarkerStyle(series.marks ? kMarks[number % kMarks.size()] : static_cast<int>(vtkPlotPoints::NONE));
        plot->SetMarkerSize(8.0F);
    }

} // namespace

struct ChartView::State {
    vtkRenderWindow* window = nullptr;
    vtkNew<vtkRenderer> renderer;
    vtkNew<vtkContextActor> actor;
};

ChartView::ChartView(vtkRenderWindow& window, const ChartPicture& picture)
    : state_(std::make_unique<State>())
{
    const auto numbers = number_names(picture);
    for (std::size_t i = 0; i < picture.panels.size(); ++i) {
        const ChartPanel& panel = picture.panels[i];
        vtkNew<vtkChartXY> chart;
        Range x_data, y_data;
        std::vector<vtkSmartPointer<vtkTable>> tables;
        for (const ChartSeries& series : panel.series)
            if (const auto table = chart_table(series, picture.logarithmic_x, picture.logarithmic_y, x_data, y_data);
                table->GetNumberOfRows() > 0) {
                add_series(*chart, table, series, numbers.at(series.name));
                tables.push_back(table);
            }
        const Range x_range = axis_range(x_data, picture.logarithmic_x);
        Range y_range = axis_range(y_data, picture.logarithmic_y);
        place_legend(*chart->GetLegend(), panel, picture, tables, x_range, y_range);
        label_axis(*chart->GetAxis(vtkAxis::BOTTOM), x_range, picture.logarithmic_x,
            panel.x_title.empty() ? picture.x_title : panel.x_title);
        label_axis(*chart->GetAxis(vtkAxis::LEFT), y_range, picture.logarithmic_y,
            panel.y_title.empty() ? picture.y_title : panel.y_title);
        chart->SetTitle(panel.title);
        chart->GetTitleProperties()->SetFontSize(title_font(panel.title, picture.panel_width));
        chart->SetShowLegend(true);
        chart->GetLegend()->SetLabelSize(kLegendFont);
        chart->SetAutoSize(false);
        const int column = static_cast<int>(i) % picture.columns, row = static_cast<int>(i) / picture.columns;
        chart->SetSize(vtkRectf(static_cast<float>(column * picture.panel_width),
            static_cast<float>((picture.rows() - 1 - row) * picture.panel_height),
            static_cast<float>(picture.panel_width), static_cast<float>(picture.panel_height)));
        state_->actor->GetScene()->AddItem(chart);
    }
    state_->window = &window;
    state_->actor->GetScene()->SetRenderer(state_->renderer);
    state_->renderer->SetBackground(1.0, 1.0, 1.0);
    state_->renderer->AddActor(state_->actor);
    window.AddRenderer(state_->renderer);
}

ChartView::~ChartView() { state_->window->RemoveRenderer(state_->renderer); }

} // namespace retractor::ui
