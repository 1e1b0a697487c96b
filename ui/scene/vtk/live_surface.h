#pragma once
// A surface that is cut and moves while it is shown. A cut replaces the topology; every frame replaces the positions.
// Sharp edges (a lip against the skin) stay sharp. Units mm.

#include "ui/scene/scene.h"

#include <array>
#include <memory>
#include <vector>

class vtkProp;

namespace retractor::ui {

/// The data that only a cut changes. Vertices are rows of the positions.
struct LiveTopology {
    std::vector<std::array<VertexId, 3>> triangles; ///< counter-clockwise seen from outside
    std::vector<Look> looks;
    std::vector<int> look_of; ///< index into looks of each triangle
    Points rest; ///< positions at rest, which decide whether an edge is sharp or smooth
    std::vector<std::array<VertexId, 2>> rims; ///< edges drawn as lines, so that a closed wound shows too
    Color rim_color { 0.32, 0.02, 0.03 };
};

/// Props drawn beside a scene that change between pictures.
class LiveProps {
public:
    LiveProps() = default;
    LiveProps(const LiveProps&) = default;
    LiveProps& operator=(const LiveProps&) = default;
    virtual ~LiveProps();
    /// The props to add to a renderer.
    [[nodiscard]] virtual std::vector<vtkProp*> props() const = 0;
};

class LiveSurface : public LiveProps {
public:
    LiveSurface();
    ~LiveSurface() override;

    /// Positions are those at rest until set_positions(). @throws InputError on indices out of range
    void set_topology(const LiveTopology& topology);
    /// @param positions as many rows as the topology's rest
    /// @throws InputError on another number of rows, or on NaN in a used row
    void set_positions(const Points& positions);
    /// A line on top of everything: the present stroke. Fewer than two points: no line.
    void set_line(const std::vector<Vec3>& points, const Color& color, double width_px);
    /// Pieces of a line on the surface, as pairs of ends; none: no line. @throws InputError on an odd number
    void set_outline(const std::vector<Vec3>& ends, const Color& color, double width_px);

    /// Steel instruments beside the surface, mm; a mesh without triangles: none.
    /// @throws InputError on indices out of range
    void set_steel(const TriMesh& mesh);

    /// The list changes only with the number of looks.
    [[nodiscard]] std::vector<vtkProp*> props() const override;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::ui
