#pragma once
// Line charts side by side in one picture: measured points against what they cost (logarithmic axes, the default), or
// curves over time (linear axes).
// OffscreenRenderer::render() draws them.

#include <memory>
#include <string>
#include <vector>

class vtkRenderWindow;

namespace retractor::ui {

/// A curve; values that are not finite, and on a logarithmic axis not positive, are left out.
struct ChartSeries {
    std::string name; ///< the same name has the same colour in every panel
    std::vector<double> x, y;
    bool marks = true; ///< a mark at each point
    bool in_legend = true; ///< a box of a box plot has several curves of one name
};

struct ChartPanel {
    std::string title;
    std::vector<ChartSeries> series;
    std::string x_title {}, y_title {}; ///< empty: the picture's
    bool legend_beside = false; ///< of the plot, which is so much narrower; else on it, where it covers no curve
};

/// Panels in rows, `columns` in each.
struct ChartPicture {
    std::string x_title, y_title;
    std::vector<ChartPanel> panels;
    int columns = 3;
    int panel_width = 520, panel_height = 400; ///< pixels
    bool logarithmic_x = true, logarithmic_y = true;

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

} // namespace retractor::ui
