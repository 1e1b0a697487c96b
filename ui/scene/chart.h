#pragma once
// Line charts on logarithmic axes, side by side in one picture: measured points against what they cost.
// OffscreenRenderer::render() draws them.

#include <memory>
#include <string>
#include <vector>

class vtkRenderWindow;

namespace retractor {

/// A curve with a mark at each point; values that are not positive and finite are left out.
struct ChartSeries {
    std::string name; ///< the same name has the same colour in every panel
    std::vector<double> x, y;
};

struct ChartPanel {
    std::string title;
    std::vector<ChartSeries> series;
};

/// Panels in rows, `columns` in each; all with the same titles of axes.
struct ChartPicture {
    std::string x_title, y_title;
    std::vector<ChartPanel> panels;
    int columns = 3;
    int panel_width = 520, panel_height = 400; ///< pixels

    int rows() const { return (static_cast<int>(panels.size()) + columns - 1) / columns; }
};

/// Shows charts in a window, for as long as this lives.
class ChartView {
public:
    ChartView(vtkRenderWindow& window, const ChartPicture& picture);
    ~ChartView();
    ChartView(const ChartView&) = delete;
    ChartView& operator=(const ChartView&) = delete;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor
