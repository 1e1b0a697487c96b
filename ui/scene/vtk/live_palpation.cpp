#include "ui/scene/vtk/live_palpation.h"

#include "mesh/base/assert.h"
#include "ui/scene/vtk/surface_actors.h"
#include "ui/scene/vtk/surface_shader.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkMatrix4x4.h>
#include <vtkOpenGLSphereMapper.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr const char* kRadius = "radius";
    constexpr double kHandOpacity = 0.45; ///< the tissue under the hand stays visible
    constexpr float kMarkWidthPx = 2.0F;

    unsigned char byte_of(double share) { return static_cast<unsigned char>(std::lround(255.0 * share)); }

    /// Balls drawn as one point each, which the graphics card makes round.
    struct Balls {
        vtkSmartPointer<vtkPolyData> data = vtkSmartPointer<vtkPolyData>::New();
        vtkSmartPointer<vtkActor> actor = vtkSmartPointer<vtkActor>::New();

        Balls()
        {
            auto mapper = vtkSmartPointer<vtkOpenGLSphereMapper>::New();
            mapper->SetInputData(data);
            mapper->SetScaleArray(kRadius);
            mapper->SetScalarModeToUsePointData();
            mapper->SetColorModeToDirectScalars();
            actor->SetMapper(mapper);
            apply_look(*actor, { .finish = Finish::skin }, false);
            actor->SetVisibility(0);
        }

        void set(std::span<const ShownBall> balls)
        {
            const auto count = static_cast<vtkIdType>(balls.size());
            auto points = vtkSmartPointer<vtkPoints>::New();
            points->SetDataTypeToFloat();
            points->SetNumberOfPoints(count);
            auto radius = vtkSmartPointer<vtkFloatArray>::New();
            radius->SetName(kRadius);
            radius->SetNumberOfValues(count);
            auto colors = vtkSmartPointer<vtkUnsignedCharArray>::New();
            colors->SetNumberOfComponents(3);
            colors->SetNumberOfTuples(count);
            auto cells = vtkSmartPointer<vtkCellArray>::New();
            cells->AllocateExact(count, count);
            for (vtkIdType i = 0; i < count; ++i) {
                const ShownBall& ball = balls[static_cast<std::size_t>(i)];
                points->SetPoint(i, ball.centre.data());
                radius->SetValue(i, static_cast<float>(ball.radius));
                const std::array<unsigned char, 3> color { byte_of(ball.color.r), byte_of(ball.color.g),
                    byte_of(ball.color.b) };
                colors->SetTypedTuple(i, color.data());
                cells->InsertNextCell({ i });
            }
            data->SetPoints(points);
            data->GetPointData()->AddArray(radius);
            data->GetPointData()->SetScalars(colors);
            data->SetVerts(cells);
            actor->SetVisibility(balls.empty() ? 0 : 1);
        }
    };

    vtkSmartPointer<vtkActor> mark_actor(vtkPolyData* data)
    {
        auto mapper = vtkSmartPointer<vtkPolyDataMapper>::New();
        mapper->SetInputData(data);
        // The box is drawn over the tissue, so that its depth inside can be seen.
        mapper->SetResolveCoincidentTopologyToPolygonOffset();
        constexpr double kInFront = -60000.0;
        mapper->SetRelativeCoincidentTopologyLineOffsetParameters(0.0, kInFront);
        auto actor = vtkSmartPointer<vtkActor>::New();
        actor->SetMapper(mapper);
        actor->GetProperty()->SetLighting(false);
        actor->GetProperty()->SetLineWidth(kMarkWidthPx);
        actor->SetVisibility(0);
        return actor;
    }

    /// The near side of a translucent rod, so that the fingertip and the tissue behind it stay visible.
    struct Rods {
        vtkSmartPointer<vtkPolyData> data = vtkSmartPointer<vtkPolyData>::New();
        vtkSmartPointer<vtkActor> actor = vtkSmartPointer<vtkActor>::New();

        Rods()
        {
            auto mapper = vtkSmartPointer<vtkPolyDataMapper>::New();
            mapper->SetInputData(data);
            mapper->SetColorModeToDirectScalars();
            actor->SetMapper(mapper);
            apply_look(*actor, { .finish = Finish::skin }, false);
            actor->GetProperty()->SetOpacity(kHandOpacity);
            actor->GetProperty()->SetBackfaceCulling(true);
            actor->SetVisibility(0);
        }

        void set(std::span<const ShownRod> rods)
        {
            constexpr int kAround = 24;
            auto points = vtkSmartPointer<vtkPoints>::New();
            points->SetDataTypeToFloat();
            auto cells = vtkSmartPointer<vtkCellArray>::New();
            auto normals = vtkSmartPointer<vtkFloatArray>::New();
            normals->SetNumberOfComponents(3);
            auto colors = vtkSmartPointer<vtkUnsignedCharArray>::New();
            colors->SetNumberOfComponents(3);
            for (const ShownRod& rod : rods) {
                const Vec3 u = rod.outward.unitOrthogonal(), v = rod.outward.cross(u);
                const std::array<std::pair<double, double>, 3> rings { { { 0.0, rod.tip_radius },
                    { rod.taper, rod.radius }, { rod.length, rod.radius } } };
                std::array<vtkIdType, kAround> last {};
                for (std::size_t ring = 0; ring < rings.size(); ++ring) {
                    std::array<vtkIdType, kAround> here {};
                    for (int n = 0; n < kAround; ++n) {
                        const double angle = 2.0 * std::numbers::pi * n / kAround;
                        const Vec3 out = std::cos(angle) * u + std::sin(angle) * v;
                        const Vec3 at = rod.tip + rings[ring].first * rod.outward + rings[ring].second * out;
                        here[static_cast<std::size_t>(n)] = points->InsertNextPoint(at.data());
                        normals->InsertNextTuple(out.data());
                        const std::array<unsigned char, 3> color { byte_of(rod.color.r), byte_of(rod.color.g),
                            byte_of(rod.color.b) };
                        colors->InsertNextTypedTuple(color.data());
                    }
                    for (std::size_t n = 0; ring > 0 && n < kAround; ++n) {
                        const std::size_t next = (n + 1) % kAround;
                        cells->InsertNextCell({ last[n], last[next], here[next], here[n] });
                    }
                    last = here;
                }
            }
            data->SetPoints(points);
            data->SetPolys(cells);
            data->GetPointData()->SetNormals(normals);
            data->GetPointData()->SetScalars(colors);
            actor->SetVisibility(rods.empty() ? 0 : 1);
        }
    };

} // namespace

struct LivePalpation::State {
    Rods fingers;
    LiveSurface surface;
    Balls spheres, fingertips;
    std::array<std::vector<vtkSmartPointer<vtkActor>>, kHands> hands;
    vtkSmartPointer<vtkPolyData> marks = vtkSmartPointer<vtkPolyData>::New();
    vtkSmartPointer<vtkActor> mark_actor = ui::mark_actor(marks);
};

LivePalpation::LivePalpation()
    : state_(std::make_unique<State>())
{
}
LivePalpation::~LivePalpation() = default;

LiveSurface& LivePalpation::surface() noexcept { return state_->surface; }

void LivePalpation::set_spheres(std::span<const ShownBall> spheres) { state_->spheres.set(spheres); }

void LivePalpation::set_fingertips(std::span<const ShownBall> tips) { state_->fingertips.set(tips); }

void LivePalpation::set_hand(std::size_t hand, const TriMesh& mesh)
{
    RETRACTOR_ASSERT(hand < state_->hands.size());
    SurfaceItem item;
    item.name = "hand";
    item.mesh = std::make_shared<TriMesh>(mesh);
    item.look = { .color = { 0.90, 0.76, 0.66 }, .finish = Finish::skin };
    item.opacity = kHandOpacity;
    state_->hands[hand] = surface_actors(item);
    for (const auto& actor : state_->hands[hand])
        actor->GetProperty()->SetBackfaceCulling(true); // draws the near side only
    hide_hand(hand);
}

void LivePalpation::place_hand(std::size_t hand, const Mat3& turn, const Vec3& shift)
{
    RETRACTOR_ASSERT(hand < state_->hands.size());
    auto matrix = vtkSmartPointer<vtkMatrix4x4>::New();
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k)
            matrix->SetElement(i, k, turn(i, k));
        matrix->SetElement(i, 3, shift[i]);
    }
    for (const auto& actor : state_->hands[hand]) {
        actor->SetUserMatrix(matrix);
        actor->SetVisibility(1);
    }
}

void LivePalpation::hide_hand(std::size_t hand)
{
    RETRACTOR_ASSERT(hand < state_->hands.size());
    for (const auto& actor : state_->hands[hand])
        actor->SetVisibility(0);
}

void LivePalpation::set_fingers(std::span<const ShownRod> fingers) { state_->fingers.set(fingers); }

void LivePalpation::set_marks(const std::vector<std::array<Vec3, 2>>& pieces, const Color& color)
{
    auto points = vtkSmartPointer<vtkPoints>::New();
    points->SetDataTypeToFloat();
    auto cells = vtkSmartPointer<vtkCellArray>::New();
    for (const auto& [a, b] : pieces) {
        const vtkIdType first = points->InsertNextPoint(a.data());
        cells->InsertNextCell({ first, points->InsertNextPoint(b.data()) });
    }
    state_->marks->SetPoints(points);
    state_->marks->SetLines(cells);
    state_->mark_actor->GetProperty()->SetColor(color.r, color.g, color.b);
    state_->mark_actor->SetVisibility(pieces.empty() ? 0 : 1);
}

std::vector<vtkProp*> LivePalpation::props() const
{
    std::vector<vtkProp*> all;
    for (vtkProp* prop : state_->surface.props())
        all.push_back(prop);
    all.push_back(state_->spheres.actor);
    all.push_back(state_->fingertips.actor);
    for (const auto& hand : state_->hands)
        for (const auto& actor : hand)
            all.push_back(actor);
    all.push_back(state_->fingers.actor);
    all.push_back(state_->mark_actor);
    return all;
}

} // namespace retractor::ui
