#pragma once
// A surface that is cut and moves while it is looked at: topology is replaced when something is cut, positions in every
// frame. Sharp edges (a lip against the skin) stay sharp. Units mm.

#include "ui/scene/scene.h"

#include <array>
#include <memory>
#include <vector>

class vtkProp;

namespace retractor::ui {

/// What changes only when something is cut. Vertices are rows of the positions.
struct LiveTopology {
    std::vector<std::array<VertexId, 3>> triangles; ///< counter-clockwise seen from outside
    std::vector<Look> looks;
    std::vector<int> look_of; ///< per triangle: an index into looks
    Points rest; ///< where edges count as sharp or smooth is decided here
    std::vector<std::array<VertexId, 2>> rims; ///< drawn as lines: a wound shows also while it is closed
    Color rim_color { 0.32, 0.02, 0.03 };
};

/// What is drawn beside a scene and changes between pictures.
class LiveProps {
public:
    LiveProps() = default;
    LiveProps(const LiveProps&) = default;
    LiveProps& operator=(const LiveProps&) = default;
    virtual ~LiveProps();
    /// What is to be added to a renderer.
    [[nodiscard]] virtual std::vector<vtkProp*> props() const = 0;
};

class LiveSurface : public LiveProps {
public:
    LiveSurface();
    ~LiveSurface() override;
    LiveSurface(LiveSurface&&) noexcept;
    LiveSurface& operator=(LiveSurface&&) noexcept;

    /// Positions are those of the rest until they are set. @throws InputError on indices out of range.
    void set_topology(const LiveTopology& topology);
    /// @param positions as many rows as the topology's rest. @throws InputError otherwise, or on NaN in a used row.
    void set_positions(const Points& positions);
    /// A line on top of everything: the stroke drawn so far; fewer than two points: none.
    void set_line(const std::vector<Vec3>& points, const Color& color, double width_px);
    /// Pieces of a line on the surface, their ends two by two; none: nothing. @throws InputError on an odd number.
    void set_outline(const std::vector<Vec3>& ends, const Color& color, double width_px);

    /// Instruments of steel beside it, mm; without triangles: none. @throws InputError on indices out of range.
    void set_steel(const TriMesh& mesh);

    /// Changes only when the number of looks does.
    [[nodiscard]] std::vector<vtkProp*> props() const override;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::ui
