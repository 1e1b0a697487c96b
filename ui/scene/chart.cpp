#include "ui/scene/chart.h"

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

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace retractor {

namespace {

    using Color = std::array<unsigned char, 3>;

    /// Told apart by those who cannot tell red from green [Okabe, Ito 2008].
    constexpr std::array<Color, 7> kColors { { { 0, 114, 178 }, { 213, 94, 0 }, { 0, 158, 115 }, { 204, 121, 167 },
        { 86, 180, 233 }, { 230, 159, 0 }, { 0, 0, 0 } } };
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
    };

    void title_axis(vtkAxis& axis, const std::string& title)
    {
        axis.SetTitle(title);
        axis.GetTitleProperties()->SetFontSize(14);
        axis.GetTitleProperties()->SetBold(false);
        axis.GetLabelProperties()->SetFontSize(12);
        axis.GetGridPen()->SetColor(225, 225, 225);
    }

    /// Round numbers, the data with a little room round it.
    void label_linear_axis(vtkAxis& axis, Range range)
    {
        if (!(range.low <= range.high))
            range = { 0.0, 1.0 };
        const double margin = range.high > range.low ? 0.04 * (range.high - range.low) : 0.5;
        axis.SetBehavior(vtkAxis::FIXED);
        axis.SetRange(range.low - margin, range.high + margin);
    }

    /// Powers of ten, not more than about six of them.
    void label_decades(vtkAxis& axis, Range range)
    {
        if (!(range.low <= range.high))
            range = { 0.0, 1.0 };
        constexpr double kMargin = 0.2; // decades
        const double low = std::floor(range.low - kMargin), high = std::ceil(range.high + kMargin);
        const int every = std::max(1, static_cast<int>(std::ceil((high - low) / 6.0)));
        vtkNew<vtkDoubleArray> positions;
        vtkNew<vtkStringArray> labels;
        for (int decade = static_cast<int>(low); decade <= static_cast<int>(high); decade += every) {
            positions->InsertNextValue(decade);
            labels->InsertNextValue("1e" + std::to_string(decade));
        }
        axis.SetBehavior(vtkAxis::FIXED);
        axis.SetRange(low, high);
        axis.SetCustomTickPositions(positions, labels);
    }

    void label_axis(vtkAxis& axis, const Range& range, bool logarithmic, const std::string& title)
    {
        if (logarithmic)
            label_decades(axis, range);
        else
            label_linear_axis(axis, range);
        title_axis(axis, title);
    }

    /// vtkChartXY's own logarithmic axes lose points at the first change of range: decades are drawn on linear ones.
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
        auto* plot = vtkPlotPoints::SafeDownCast(chart.AddPlot(vtkChart::LINE));
        const Color& color = kColors[number % kColors.size()];
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
        Range x_range, y_range;
        for (const ChartSeries& series : panel.series)
            if (const auto table = chart_table(series, picture.logarithmic_x, picture.logarithmic_y, x_range, y_range);
                table->GetNumberOfRows() > 0)
                add_series(*chart, table, series, numbers.at(series.name));
        label_axis(*chart->GetAxis(vtkAxis::BOTTOM), x_range, picture.logarithmic_x,
            panel.x_title.empty() ? picture.x_title : panel.x_title);
        label_axis(*chart->GetAxis(vtkAxis::LEFT), y_range, picture.logarithmic_y,
            panel.y_title.empty() ? picture.y_title : panel.y_title);
        chart->SetTitle(panel.title);
        chart->GetTitleProperties()->SetFontSize(16);
        chart->SetShowLegend(true);
        chart->GetLegend()->SetLabelSize(12);
        chart->GetLegend()->SetHorizontalAlignment(vtkChartLegend::RIGHT);
        chart->GetLegend()->SetVerticalAlignment(vtkChartLegend::TOP);
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

} // namespace retractor
