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

    /// Powers of ten, not more than about six of them.
    void label_axis(vtkAxis& axis, Range range, const std::string& title)
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
        axis.SetTitle(title);
        axis.GetTitleProperties()->SetFontSize(14);
        axis.GetTitleProperties()->SetBold(false);
        axis.GetLabelProperties()->SetFontSize(12);
        axis.GetGridPen()->SetColor(225, 225, 225);
    }

    /// vtkChartXY's own logarithmic axes lose points at the first change of range: decades are drawn on linear ones.
    vtkSmartPointer<vtkTable> decades(const ChartSeries& series, Range& x_range, Range& y_range)
    {
        const auto table = vtkSmartPointer<vtkTable>::New();
        vtkNew<vtkDoubleArray> x, y;
        x->SetName("x");
        y->SetName(series.name.c_str());
        for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
            const double lx = std::log10(series.x[i]), ly = std::log10(series.y[i]);
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
        vtkChartXY& chart, const vtkSmartPointer<vtkTable>& table, const std::string& name, std::size_t number)
    {
        auto* plot = vtkPlotPoints::SafeDownCast(chart.AddPlot(vtkChart::LINE));
        const Color& color = kColors[number % kColors.size()];
        plot->SetInputData(table, 0, 1);
        plot->SetLabel(name);
        plot->SetColor(color[0], color[1], color[2], 255);
        plot->SetWidth(2.0F);
        plot->SetMarkerStyle(kMarks[number % kMarks.size()]);
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
            if (const auto table = decades(series, x_range, y_range); table->GetNumberOfRows() > 0)
                add_series(*chart, table, series.name, numbers.at(series.name));
        label_axis(*chart->GetAxis(vtkAxis::BOTTOM), x_range, picture.x_title);
        label_axis(*chart->GetAxis(vtkAxis::LEFT), y_range, picture.y_title);
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
