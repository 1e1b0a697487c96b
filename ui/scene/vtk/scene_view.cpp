#include "ui/scene/vtk/scene_view.h"

#include "mesh/base/assert.h"
#include "ui/scene/linked_slices.h"
#include "ui/scene/vtk/annotations.h"
#include "ui/scene/vtk/slice_actor.h"
#include "ui/scene/vtk/stereo.h"
#include "ui/scene/vtk/surface_actors.h"

#include <vtkAbstractVolumeMapper.h>
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCommand.h>
#include <vtkLight.h>
#include <vtkMapper.h>
#include <vtkPlane.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkVolume.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace retractor::ui {

namespace {

    /// Layers of the window: the scene, items over the scene, words, the orientation marker.
    constexpr int kLayers = 4;

    void add_light(vtkRenderer& renderer, const Vec3& from, const Color& color, double intensity)
    {
        auto light = vtkSmartPointer<vtkLight>::New();
        light->SetLightTypeToCameraLight();
        // Position in the camera's frame: x right, y up, z from the aim to the eye, with the eye at z = 1.
        light->SetPosition(from.x(), from.y(), from.z());
        light->SetFocalPoint(0.0, 0.0, 0.0);
        light->SetColor(color.r, color.g, color.b);
        light->SetIntensity(intensity);
        renderer.AddLight(light);
    }

    /// A surgical lamp beside the surgeon's head, and weak light from the room.
    void light_theatre(vtkRenderer& renderer)
    {
        renderer.RemoveAllLights();
        renderer.SetAutomaticLightCreation(false);
        renderer.SetTwoSidedLighting(true);
        add_light(renderer, { -0.35, 0.45, 1.0 }, { 1.0, 0.98, 0.94 }, 0.78);
        add_light(renderer, { 0.15, 0.0, 1.0 }, { 1.0, 1.0, 1.0 }, 0.22);
        add_light(renderer, { 1.0, -0.2, 0.3 }, { 0.85, 0.92, 1.0 }, 0.18);
    }

    /// Draws the near side of a translucent surface with the opaque ones, without passes over the whole picture of its
    /// own. The near side covers as much as both sides together would.
    void blend_at_once(vtkActor& actor)
    {
        vtkProperty& property = *actor.GetProperty();
        const double through = 1.0 - property.GetOpacity();
        property.SetOpacity(1.0 - through * through);
        property.SetBackfaceCulling(1);
        actor.ForceOpaqueOn();
    }

    // Ambient occlusion: where surfaces within this distance shade a place, it is darker. The depth of a wound is then
    // seen in a still picture.
    constexpr double kShadeReachMm = 40.0, kShadeBiasMm = 1.0;
    constexpr unsigned kShadeSamples = 32;

    /// Scenes of surfaces in full quality are shaded; slices, volumes and pictures of identifiers have no light.
    bool has_shaded_hollows(const Scene& scene, DrawingQuality quality)
    {
        return quality == DrawingQuality::full && scene.slices.empty() && scene.volumes.empty()
            && std::any_of(scene.surfaces.begin(), scene.surfaces.end(),
                [](const SurfaceItem& item) { return item.look.finish != Finish::unlit; });
    }

    void shade_hollows(vtkRenderer& renderer, bool on)
    {
        renderer.SetUseSSAO(on);
        renderer.SetSSAORadius(kShadeReachMm);
        renderer.SetSSAOBias(kShadeBiasMm);
        renderer.SetSSAOKernelSize(kShadeSamples);
        renderer.SetSSAOBlur(true);
    }

    struct SampledSlice {
        SliceItem item;
        vtkSmartPointer<vtkActor> actor;
    };

    /// Whether two slices give the same pixels. A slice along an axis of the patient may have another point in its
    /// plane.
    bool same_pixels(const SliceItem& a, const SliceItem& b)
    {
        const auto same_color = [](const auto& x, const auto& y) {
            return x.first == y.first && x.second.r == y.second.r && x.second.g == y.second.g
                && x.second.b == y.second.b;
        };
        const int axis = axis_across(a.plane);
        return !a.oblique && !b.oblique && a.image == b.image && a.plane == b.plane && a.point[axis] == b.point[axis]
            && a.window_hu == b.window_hu && a.level_hu == b.level_hu && a.labels == b.labels && a.fill == b.fill
            && a.pixel_mm == b.pixel_mm
            && std::equal(a.outline_of_label.begin(), a.outline_of_label.end(), b.outline_of_label.begin(),
                b.outline_of_label.end(), same_color);
    }

    void place_camera(vtkCamera& vtk, const Camera& camera)
    {
        vtk.SetPosition(camera.eye.data());
        vtk.SetFocalPoint(camera.aim.data());
        vtk.SetViewUp(camera.up.data());
        vtk.SetParallelProjection(camera.parallel ? 1 : 0);
        vtk.SetViewAngle(camera.view_angle_deg);
        vtk.SetParallelScale(camera.half_height_mm);
        set_eyes_apart(vtk);
    }

} // namespace

struct SceneView::State {
    vtkRenderWindow* window = nullptr;
    VolumeCache* volumes = nullptr;
    vtkSmartPointer<vtkRenderer> main = vtkSmartPointer<vtkRenderer>::New();
    vtkSmartPointer<vtkRenderer> overlay = vtkSmartPointer<vtkRenderer>::New();
    vtkSmartPointer<vtkRenderer> words = vtkSmartPointer<vtkRenderer>::New();
    vtkSmartPointer<vtkRenderer> marker = vtkSmartPointer<vtkRenderer>::New();
    std::array<double, 4> rectangle { 0.0, 0.0, 1.0, 1.0 };
    DrawingQuality quality = DrawingQuality::full;
    std::vector<SampledSlice> slices; ///< of the last scene, so that one that has not moved is not sampled again
    std::vector<vtkSmartPointer<vtkAbstractMapper>> cut_mappers; ///< of what a plane cuts away
    vtkSmartPointer<vtkActor> cut_face;

    int width() const
    {
        return std::max(1, static_cast<int>(std::lround((rectangle[2] - rectangle[0]) * window->GetSize()[0])));
    }
    int height() const
    {
        return std::max(1, static_cast<int>(std::lround((rectangle[3] - rectangle[1]) * window->GetSize()[1])));
    }

    /// VTK 9.1 shades the whole window or, wrongly, a part of it.
    bool fills_window() const { return rectangle == std::array { 0.0, 0.0, 1.0, 1.0 }; }

    void clear() const
    {
        for (vtkRenderer* renderer : { main.Get(), overlay.Get(), words.Get(), marker.Get() }) {
            renderer->RemoveAllViewProps();
            renderer->RemoveObservers(vtkCommand::StartEvent);
        }
    }

    void cut_away(const std::optional<CutAway>& cut)
    {
        for (const auto& mapper : cut_mappers)
            mapper->RemoveAllClippingPlanes();
        if (cut_face != nullptr)
            main->RemoveActor(std::exchange(cut_face, nullptr));
        if (!cut)
            return;
        auto plane = vtkSmartPointer<vtkPlane>::New();
        plane->SetOrigin(cut->point.data());
        plane->SetNormal(cut->kept.data());
        for (const auto& mapper : cut_mappers)
            mapper->AddClippingPlane(plane);
        if (cut->face) {
            cut_face = cut_face_actor(*cut->face);
            main->AddActor(cut_face);
        }
    }

    void add_surface(vtkRenderer& renderer, vtkActor* actor)
    {
        renderer.AddActor(actor);
        cut_mappers.emplace_back(actor->GetMapper());
    }

    void add_items(const Scene& scene)
    {
        bool translucent = false;
        cut_mappers.clear();
        cut_face = nullptr;
        for (const SurfaceItem& item : scene.surfaces) {
            if (item.opacity < 1.0 && !item.on_top)
                translucent = true;
            else
                for (const auto& actor : surface_actors(item))
                    add_surface(item.on_top ? *overlay : *main, actor);
        }
        // Translucent surfaces are added last, so that they blend over the opaque ones.
        for (const SurfaceItem& item : scene.surfaces)
            if (item.opacity < 1.0 && !item.on_top)
                for (const auto& actor : surface_actors(item)) {
                    if (quality == DrawingQuality::fast)
                        blend_at_once(*actor);
                    add_surface(*main, actor);
                }
        for (const LineItem& item : scene.lines)
            (item.on_top ? overlay : main)->AddActor(line_actor(item, window->GetSize()[1]));
        std::vector<SampledSlice> sampled;
        for (const SliceItem& item : scene.slices) {
            const auto known = std::find_if(
                slices.begin(), slices.end(), [&](const SampledSlice& s) { return same_pixels(s.item, item); });
            sampled.push_back({ item, known != slices.end() ? known->actor : slice_actor(item) });
            main->AddActor(sampled.back().actor);
        }
        slices = std::move(sampled);
        for (const VolumeItem& item : scene.volumes) {
            const vtkSmartPointer<vtkVolume> volume = volumes->volume(item);
            main->AddVolume(volume);
            cut_mappers.emplace_back(volume->GetMapper());
        }
        cut_away(scene.cut_away);
        main->SetUseDepthPeeling(translucent && quality == DrawingQuality::full ? 1 : 0);
        main->SetMaximumNumberOfPeels(4);
    }

    void add_annotations(const Scene& scene) const
    {
        add_text(*words, *overlay, scene, width(), height());
        add_words(*words, scene, width(), height());
        if (scene.scale_bar)
            add_scale_bar(*words, scene, width(), height());
        if (!scene.orientation_marker)
            return;
        if (!scene.slices.empty()) {
            add_edge_letters(*words, scene, width(), height());
            return;
        }
        // The marker is a square in the lower right corner.
        const double side = 0.17 * std::min(width(), height());
        const double across = side / window->GetSize()[0], upward = side / window->GetSize()[1];
        marker->SetViewport(rectangle[2] - across, rectangle[1], rectangle[2], rectangle[1] + upward);
        fill_marker(*marker, *main);
    }
};

SceneView::SceneView(vtkRenderWindow& window, const Viewport& viewport, VolumeCache& volumes, DrawingQuality quality)
    : state_(std::make_unique<State>())
{
    State& s = *state_;
    s.window = &window;
    s.volumes = &volumes;
    s.quality = quality;
    s.rectangle = { viewport.left, viewport.bottom, viewport.right, viewport.top };
    window.SetNumberOfLayers(kLayers);
    int layer = 0;
    for (vtkRenderer* renderer : { s.main.Get(), s.overlay.Get(), s.words.Get(), s.marker.Get() }) {
        renderer->SetViewport(s.rectangle.data());
        renderer->SetLayer(layer);
        renderer->SetInteractive(layer == 0 ? 1 : 0);
        ++layer;
        window.AddRenderer(renderer);
    }
    s.overlay->SetActiveCamera(s.main->GetActiveCamera());
    s.words->SetActiveCamera(s.main->GetActiveCamera());
    s.main->SetUseFXAA(quality == DrawingQuality::full);
    light_theatre(*s.main);
}

SceneView::~SceneView()
{
    if (state_ == nullptr)
        return;
    state_->clear();
    for (vtkRenderer* renderer :
        { state_->main.Get(), state_->overlay.Get(), state_->words.Get(), state_->marker.Get() })
        state_->window->RemoveRenderer(renderer);
}
SceneView::SceneView(SceneView&&) noexcept = default;

void SceneView::show(const Scene& scene)
{
    RETRACTOR_ASSERT(state_ != nullptr);
    check_scene(scene);
    State& s = *state_;
    s.clear();
    const bool shaded = s.fills_window() && has_shaded_hollows(scene, s.quality);
    shade_hollows(*s.main, shaded);
    const Color& low = shaded ? scene.background_high : scene.background_low; // VTK 9.1 shades no gradient
    s.main->SetGradientBackground(!shaded);
    s.main->SetBackground(low.r, low.g, low.b);
    s.main->SetBackground2(scene.background_high.r, scene.background_high.g, scene.background_high.b);
    s.add_items(scene);
    s.add_annotations(scene);
    set_camera(scene.camera);
}

void SceneView::set_camera(const Camera& camera)
{
    vtkCamera& vtk = *state_->main->GetActiveCamera();
    place_camera(vtk, camera);
    state_->main->ResetCameraClippingRange();
}

void SceneView::set_cut_away(const std::optional<CutAway>& cut_away) { state_->cut_away(cut_away); }

Camera SceneView::camera() const
{
    vtkCamera& vtk = *state_->main->GetActiveCamera();
    Camera camera;
    camera.eye = Vec3(vtk.GetPosition());
    camera.aim = Vec3(vtk.GetFocalPoint());
    camera.up = Vec3(vtk.GetViewUp());
    camera.parallel = vtk.GetParallelProjection() != 0;
    camera.view_angle_deg = vtk.GetViewAngle();
    camera.half_height_mm = vtk.GetParallelScale();
    return camera;
}

vtkRenderer& SceneView::renderer() { return *state_->main; }

} // namespace retractor::ui
