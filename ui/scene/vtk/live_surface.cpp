#include "ui/scene/vtk/live_surface.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"
#include "ui/scene/vtk/surface_shader.h"

#include <Eigen/Geometry>

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkOpenGLPolyDataMapper.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkSmartPointer.h>

#include <string>

namespace retractor::ui {

namespace {

    /// Cosine of 40 degrees. Faces that meet at a sharper edge are shaded separately.
    constexpr double kSmoothCosine = 0.766;
    constexpr float kRimWidthPx = 2.0F;
    constexpr Color kSteel { 0.72, 0.74, 0.77 };

    vtkSmartPointer<vtkActor> actor_of(vtkPolyData* data)
    {
        auto mapper = vtkSmartPointer<vtkOpenGLPolyDataMapper>::New();
        mapper->SetInputData(data);
        mapper->SetVBOShiftScaleMethod(0); // our shader wants coordinates in mm
        mapper->SetScalarVisibility(0);
        auto actor = vtkSmartPointer<vtkActor>::New();
        actor->SetMapper(mapper);
        return actor;
    }

    vtkSmartPointer<vtkPolyData> empty_data()
    {
        auto data = vtkSmartPointer<vtkPolyData>::New();
        auto points = vtkSmartPointer<vtkPoints>::New();
        points->SetDataTypeToFloat();
        data->SetPoints(points);
        return data;
    }

    vtkSmartPointer<vtkActor> line_actor(vtkPolyData* data, const Color& color, float width_px, double lift)
    {
        vtkSmartPointer<vtkActor> actor = actor_of(data);
        apply_look(*actor, { .color = color, .finish = Finish::unlit }, false);
        actor->GetProperty()->SetLineWidth(width_px);
        actor->GetMapper()->SetResolveCoincidentTopologyToPolygonOffset();
        // Draws the line before the skin on which it lies.
        actor->GetMapper()->SetRelativeCoincidentTopologyLineOffsetParameters(lift, lift);
        return actor;
    }

    /// The triangles of one look. A vertex has one point for every smooth patch that it touches.
    struct Part {
        vtkSmartPointer<vtkPolyData> data = empty_data();
        vtkSmartPointer<vtkFloatArray> normals = vtkSmartPointer<vtkFloatArray>::New();
        vtkSmartPointer<vtkActor> actor;
        std::vector<VertexId> vertex_of; ///< vertex of each point
        std::vector<std::array<int, 3>> triangles; ///< indices of points
    };

    struct SmoothPatch {
        int part = 0, point = 0;
        Vec3 normal;
    };

    void move_points(vtkPolyData& data, const std::vector<VertexId>& vertex_of, const Points& positions)
    {
        auto* xyz = vtkFloatArray::SafeDownCast(data.GetPoints()->GetData())->GetPointer(0);
        for (std::size_t i = 0; i < vertex_of.size(); ++i)
            for (int k = 0; k < 3; ++k)
                xyz[3 * i + static_cast<std::size_t>(k)] = static_cast<float>(positions(vertex_of[i], k));
        data.GetPoints()->Modified();
    }

    void shade(Part& part, const Points& positions)
    {
        std::vector<Vec3> sum(part.vertex_of.size(), Vec3::Zero());
        const auto at = [&](int point) -> Vec3 {
            return positions.row(part.vertex_of[static_cast<std::size_t>(point)]).transpose();
        };
        for (const auto& t : part.triangles) {
            const Vec3 a = at(t[0]);
            const Vec3 area = (at(t[1]) - a).cross(at(t[2]) - a);
            for (const int point : t)
                sum[static_cast<std::size_t>(point)] += area;
        }
        float* out = part.normals->GetPointer(0);
        for (std::size_t i = 0; i < sum.size(); ++i) {
            const double length = sum[i].norm();
            for (int k = 0; k < 3; ++k)
                out[3 * i + static_cast<std::size_t>(k)]
                    = static_cast<float>(length > 0.0 ? sum[i][k] / length : (k == 2 ? 1.0 : 0.0));
        }
        part.normals->Modified();
    }

} // namespace

struct LiveSurface::State {
    std::vector<Part> parts;
    Part steel;
    Eigen::Index rows = 0;
    vtkSmartPointer<vtkPolyData> rim = empty_data();
    std::vector<VertexId> rim_vertices;
    vtkSmartPointer<vtkActor> rim_actor = line_actor(rim, {}, kRimWidthPx, -2.0);
    vtkSmartPointer<vtkPolyData> stroke = empty_data();
    vtkSmartPointer<vtkActor> stroke_actor = line_actor(stroke, {}, 1.0F, -6.0);

    vtkSmartPointer<vtkPolyData> outline = empty_data();
    vtkSmartPointer<vtkActor> outline_actor = line_actor(outline, {}, 1.0F, -4.0);

    void set_rims(const LiveTopology& topology)
    {
        rim_vertices.clear();
        auto cells = vtkSmartPointer<vtkCellArray>::New();
        for (const auto& edge : topology.rims) {
            const auto first = static_cast<vtkIdType>(rim_vertices.size());
            rim_vertices.insert(rim_vertices.end(), edge.begin(), edge.end());
            cells->InsertNextCell({ first, first + 1 });
        }
        rim->GetPoints()->SetNumberOfPoints(static_cast<vtkIdType>(rim_vertices.size()));
        rim->SetLines(cells);
        rim_actor->GetProperty()->SetColor(topology.rim_color.r, topology.rim_color.g, topology.rim_color.b);
        rim_actor->SetVisibility(rim_vertices.empty() ? 0 : 1);
    }
};

LiveSurface::LiveSurface()
    : state_(std::make_unique<State>())
{
    state_->steel.actor = actor_of(state_->steel.data);
    apply_look(*state_->steel.actor, { .color = kSteel, .finish = Finish::metal }, false);
    state_->steel.actor->SetVisibility(0);
    state_->rim_actor->SetVisibility(0);
    state_->stroke_actor->SetVisibility(0);
    state_->outline_actor->SetVisibility(0);
}
LiveProps::~LiveProps() = default;
LiveSurface::~LiveSurface() = default;

void LiveSurface::set_topology(const LiveTopology& topology)
{
    if (topology.look_of.size() != topology.triangles.size())
        throw InputError("there must be one look per triangle", "look_of");
    std::vector<Part> parts(topology.looks.size());
    std::vector<std::vector<SmoothPatch>> patches(static_cast<std::size_t>(topology.rest.rows()));
    for (std::size_t t = 0; t < topology.triangles.size(); ++t) {
        const auto& corners = topology.triangles[t];
        for (const VertexId v : corners)
            if (v < 0 || v >= topology.rest.rows())
                throw InputError("a corner is out of range", "triangle " + std::to_string(t));
        const int look = topology.look_of[t];
        if (look < 0 || static_cast<std::size_t>(look) >= parts.size())
            throw InputError("there is no such look", "triangle " + std::to_string(t));
        Part& part = parts[static_cast<std::size_t>(look)];
        const Vec3 normal = unit_normal(topology.rest, corners);
        std::array<int, 3> points {};
        for (std::size_t k = 0; k < 3; ++k) {
            auto& of_vertex = patches[static_cast<std::size_t>(corners[k])];
            int point = -1;
            for (const SmoothPatch& patch : of_vertex)
                if (patch.part == look && patch.normal.dot(normal) > kSmoothCosine)
                    point = patch.point;
            if (point < 0) {
                point = static_cast<int>(part.vertex_of.size());
                part.vertex_of.push_back(corners[k]);
                of_vertex.push_back({ look, point, normal });
            }
            points[k] = point;
        }
        part.triangles.push_back(points);
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
        Part& part = parts[i];
        part.data->GetPoints()->SetNumberOfPoints(static_cast<vtkIdType>(part.vertex_of.size()));
        part.normals->SetNumberOfComponents(3);
        part.normals->SetNumberOfTuples(static_cast<vtkIdType>(part.vertex_of.size()));
        part.data->GetPointData()->SetNormals(part.normals);
        auto cells = vtkSmartPointer<vtkCellArray>::New();
        cells->AllocateExact(
            static_cast<vtkIdType>(part.triangles.size()), static_cast<vtkIdType>(3 * part.triangles.size()));
        for (const auto& t : part.triangles)
            cells->InsertNextCell({ t[0], t[1], t[2] });
        part.data->SetPolys(cells);
        // Actors are kept, so that a renderer needs no update after every cut.
        if (i < state_->parts.size()) {
            part.actor = state_->parts[i].actor;
            vtkPolyDataMapper::SafeDownCast(part.actor->GetMapper())->SetInputData(part.data);
        } else {
            part.actor = actor_of(part.data);
        }
        apply_look(*part.actor, topology.looks[i], false);
        part.actor->GetProperty()->SetInterpolationToPhong();
        part.actor->SetVisibility(part.triangles.empty() ? 0 : 1);
    }
    state_->parts = std::move(parts);
    state_->rows = topology.rest.rows();
    state_->set_rims(topology);
    set_positions(topology.rest);
}

void LiveSurface::set_positions(const Points& positions)
{
    if (positions.rows() != state_->rows)
        throw InputError(
            "there are " + std::to_string(positions.rows()) + " positions, not " + std::to_string(state_->rows));
    for (const Part& part : state_->parts)
        for (const VertexId v : part.vertex_of)
            if (!positions.row(v).allFinite())
                throw InputError("a position is not finite", "vertex " + std::to_string(v));
    for (Part& part : state_->parts) {
        move_points(*part.data, part.vertex_of, positions);
        shade(part, positions);
    }
    move_points(*state_->rim, state_->rim_vertices, positions);
}

void LiveSurface::set_line(const std::vector<Vec3>& points, const Color& color, double width_px)
{
    auto cells = vtkSmartPointer<vtkCellArray>::New();
    auto xyz = vtkSmartPointer<vtkPoints>::New();
    xyz->SetDataTypeToFloat();
    if (points.size() >= 2) {
        cells->InsertNextCell(static_cast<int>(points.size()));
        for (const Vec3& p : points)
            cells->InsertCellPoint(xyz->InsertNextPoint(p.data()));
    }
    state_->stroke->SetPoints(xyz);
    state_->stroke->SetLines(cells);
    state_->stroke_actor->GetProperty()->SetColor(color.r, color.g, color.b);
    state_->stroke_actor->GetProperty()->SetLineWidth(static_cast<float>(width_px));
    state_->stroke_actor->SetVisibility(points.size() >= 2 ? 1 : 0);
}

void LiveSurface::set_outline(const std::vector<Vec3>& ends, const Color& color, double width_px)
{
    if (ends.size() % 2 != 0)
        throw InputError("every piece of a line has two ends", "outline");
    auto cells = vtkSmartPointer<vtkCellArray>::New();
    auto xyz = vtkSmartPointer<vtkPoints>::New();
    xyz->SetDataTypeToFloat();
    for (std::size_t i = 0; i + 1 < ends.size(); i += 2) {
        const vtkIdType from = xyz->InsertNextPoint(ends[i].data()), to = xyz->InsertNextPoint(ends[i + 1].data());
        cells->InsertNextCell({ from, to });
    }
    state_->outline->SetPoints(xyz);
    state_->outline->SetLines(cells);
    state_->outline_actor->GetProperty()->SetColor(color.r, color.g, color.b);
    state_->outline_actor->GetProperty()->SetLineWidth(static_cast<float>(width_px));
    state_->outline_actor->SetVisibility(ends.empty() ? 0 : 1);
}

void LiveSurface::set_steel(const TriMesh& mesh)
{
    Part& part = state_->steel;
    part.triangles.clear();
    part.vertex_of.clear();
    auto cells = vtkSmartPointer<vtkCellArray>::New();
    // Every corner has its own point, because steel has sharp edges.
    for (const auto& triangle : mesh.triangles) {
        const auto first = static_cast<int>(part.vertex_of.size());
        for (const VertexId v : triangle)
            if (v < 0 || v >= mesh.vertices.rows())
                throw InputError("a corner is out of range", "steel");
        part.vertex_of.insert(part.vertex_of.end(), triangle.begin(), triangle.end());
        part.triangles.push_back({ first, first + 1, first + 2 });
        cells->InsertNextCell({ first, first + 1, first + 2 });
    }
    RETRACTOR_ASSERT(part.vertex_of.size() == 3 * mesh.triangles.size());
    const auto points = static_cast<vtkIdType>(part.vertex_of.size());
    part.data->GetPoints()->SetNumberOfPoints(points);
    part.normals->SetNumberOfComponents(3);
    part.normals->SetNumberOfTuples(points);
    part.data->GetPointData()->SetNormals(part.normals);
    part.data->SetPolys(cells);
    move_points(*part.data, part.vertex_of, mesh.vertices);
    shade(part, mesh.vertices);
    part.actor->SetVisibility(mesh.triangles.empty() ? 0 : 1);
}

std::vector<vtkProp*> LiveSurface::props() const
{
    std::vector<vtkProp*> all;
    for (const Part& part : state_->parts)
        all.push_back(part.actor);
    all.push_back(state_->steel.actor);
    all.push_back(state_->rim_actor);
    all.push_back(state_->outline_actor);
    all.push_back(state_->stroke_actor);
    return all;
}

} // namespace retractor::ui
