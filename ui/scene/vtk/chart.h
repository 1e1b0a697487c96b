#pragma once
// Line charts side by side in one picture: measured points against their cost (logarithmic axes, the default), or
// curves over time (linear axes). OffscreenRenderer::render() draws the charts.

#include <memory>
#include <string>
#include <vector>

class vtkRenderWindow;

namespace retractor::ui {

/// A curve. Values that are not finite are left out; on a logarithmic axis also values that are not positive.
struct ChartSeries {
    std::string name; ///< a name has the same colour in every panel
    std::vector<double> x, y;
    bool marks = true; ///< draw a mark at each point
    bool in_legend = true; ///< a box of a box plot has several curves with one name
};

struct ChartPanel {
    std::string title;
    std::vector<ChartSeries> series;
    std::string x_title {}, y_title {}; ///< empty: the titles of the picture
    /// The legend stands beside a narrower plot; otherwise on the plot, where it covers no curve.
    bool legend_beside = false;
};

/// Panels in rows of `columns`.
struct ChartPicture {
    std::string x_title, y_title;
    std::vector<ChartPanel> panels;
    int columns = 3;
    int panel_width = 520, panel_height = 400; ///< pixels
    bool logarithmic_x = true, logarithmic_y = true;

    int rows() const { return (static_cast<int>(panels.size()) + columns - 1) / columns; }
};

/// Shows charts in a window during the lifetime of this object.
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

} // namespace retractor::ui
