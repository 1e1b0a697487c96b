#include "ui/scene/vtk/annotations.h"

#include <vtkActor2D.h>
#include <vtkAnnotatedCubeActor.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCommand.h>
#include <vtkCoordinate.h>
#include <vtkObjectFactory.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty.h>
#include <vtkProperty2D.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numbers>
#include <string>

namespace retractor::ui {

namespace {

    /// Letters of this height are read from 1 m on a screen 960 pixels and 270 mm high.
    constexpr double kFontShare = 24.0 / 960.0;
    constexpr int kSmallestFont = 9;
    /// Width that a legend may take in a narrow view, whatever its share, in font sizes.
    constexpr double kNarrowLegend = 16.0;
    constexpr Color kInk { 0.96, 0.97, 0.98 };
    constexpr Color kDimInk { 0.78, 0.83, 0.87 };

    /// A narrow view gets smaller letters, so that a line still fits.
    int font_size(const Scene& scene, int width, int height)
    {
        if (scene.font_px > 0.0)
            return std::max(kSmallestFont, static_cast<int>(std::lround(scene.font_px)));
        const double size = kFontShare * std::min<double>(height, 1.2 * width);
        return std::max(kSmallestFont, static_cast<int>(std::lround(size)));
    }

    /// VTK turns letters into pixels with one FreeType library for the process, which serves one thread at a time.
    std::mutex letters_mutex;

    class TextActor : public vtkTextActor {
    public:
        static TextActor* New();
        vtkTypeMacro(TextActor, vtkTextActor)

            bool RenderImage(vtkTextProperty* property, vtkViewport* viewport) override
        {
            const std::lock_guard lock(letters_mutex);
            return vtkTextActor::RenderImage(property, viewport);
        }
        bool GetImageBoundingBox(vtkTextProperty* property, vtkViewport* viewport, int box[4]) override
        {
            const std::lock_guard lock(letters_mutex);
            return vtkTextActor::GetImageBoundingBox(property, viewport, box);
        }
    };
    vtkStandardNewMacro(TextActor)

        std::string& annotation_font()
    {
        static std::string file;
        return file;
    }

    vtkSmartPointer<vtkTextActor> text_actor(const std::string& text, int size, const Color& color, bool bold)
    {
        const vtkSmartPointer<vtkTextActor> actor = vtkSmartPointer<TextActor>::New();
        actor->SetInput(text.c_str());
        actor->SetTextScaleModeToNone();
        vtkTextProperty& property = *actor->GetTextProperty();
        if (annotation_font().empty())
            property.SetFontFamilyToArial();
        else {
            property.SetFontFamily(VTK_FONT_FILE);
            property.SetFontFile(annotation_font().c_str());
        }
        property.SetFontSize(size);
        property.SetBold(bold ? 1 : 0);
        property.SetColor(color.r, color.g, color.b);
        property.SetShadow(0);
        property.SetVerticalJustificationToBottom();
        return actor;
    }

    /// Shades the background, so that words over the picture stay readable.
    void shade_behind(vtkTextActor& text)
    {
        constexpr double kShade = 0.8; // opacity
        text.GetTextProperty()->SetBackgroundColor(0.0, 0.0, 0.0);
        text.GetTextProperty()->SetBackgroundOpacity(kShade);
    }

    double width_of(vtkTextActor& actor, vtkRenderer& renderer)
    {
        std::array<double, 2> size { 0.0, 0.0 };
        actor.GetSize(&renderer, size.data());
        return size[0];
    }

    vtkSmartPointer<vtkActor2D> rectangle(
        double left, double bottom, double right, double top, const Color& color, double opacity)
    {
        auto points = vtkSmartPointer<vtkPoints>::New();
        points->InsertNextPoint(left, bottom, 0);
        points->InsertNextPoint(right, bottom, 0);
        points->InsertNextPoint(right, top, 0);
        points->InsertNextPoint(left, top, 0);
        auto cells = vtkSmartPointer<vtkCellArray>::New();
        cells->InsertNextCell({ 0, 1, 2, 3 });
        auto data = vtkSmartPointer<vtkPolyData>::New();
        data->SetPoints(points);
        data->SetPolys(cells);
        auto mapper = vtkSmartPointer<vtkPolyDataMapper2D>::New();
        mapper->SetInputData(data);
        auto actor = vtkSmartPointer<vtkActor2D>::New();
        actor->SetMapper(mapper);
        actor->GetProperty()->SetColor(color.r, color.g, color.b);
        actor->GetProperty()->SetOpacity(opacity);
        return actor;
    }

    /// Places of the lines of a legend for one font size.
    struct LegendLayout {
        int font = 0;
        double line_height = 0.0, swatch = 0.0, key_width = 0.0, value_width = 0.0, gap = 0.0;
        double heading_width = 0.0; ///< of lines without a value, which have the whole width
        double width() const { return swatch + std::max(heading_width, key_width + gap + value_width); }
    };

    LegendLayout measure(const std::vector<LegendLine>& lines, int font, vtkRenderer& renderer)
    {
        LegendLayout layout;
        layout.font = font;
        layout.line_height = 1.40 * font;
        for (const LegendLine& line : lines) {
            if (line.swatch)
                layout.swatch = 1.3 * font;
            double& widest = line.value.empty() ? layout.heading_width : layout.key_width;
            widest = std::max(widest, width_of(*text_actor(line.key, font, kInk, line.value.empty()), renderer));
            if (!line.value.empty())
                layout.value_width
                    = std::max(layout.value_width, width_of(*text_actor(line.value, font, kInk, true), renderer));
        }
        layout.gap = layout.value_width > 0.0 ? 1.0 * font : 0.0;
        return layout;
    }

    void add_legend(
        vtkRenderer& renderer, vtkRenderer& panels, const Scene& scene, int width, double top, double bottom, int font)
    {
        const std::vector<LegendLine>& lines = scene.legend;
        const double margin = 0.6 * font;
        LegendLayout layout = measure(lines, font, renderer);
        const double widest = std::max(scene.legend_share * width, kNarrowLegend * font); // the wound needs the rest
        const double fits = std::min({ 1.0, (std::min(widest, 0.94 * width) - 4.0 * margin) / layout.width(),
            (top - bottom - 2.0 * margin) / (layout.line_height * static_cast<double>(lines.size())) });
        if (fits < 1.0)
            layout = measure(lines, std::max(kSmallestFont, static_cast<int>(font * fits)), renderer);

        const double left = 2.0 * margin;
        const double right = left + layout.width();
        const double height = layout.line_height * static_cast<double>(lines.size());
        panels.AddActor2D(
            rectangle(left - margin, top - height - margin, right + margin, top, { 0.0, 0.0, 0.0 }, 0.55));
        double y = top - 0.5 * margin;
        for (const LegendLine& line : lines) {
            y -= layout.line_height;
            const bool heading = line.value.empty();
            auto key = text_actor(line.key, layout.font, heading ? kInk : kDimInk, heading);
            key->SetPosition(left + layout.swatch, y);
            renderer.AddActor2D(key);
            if (!heading) {
                auto value = text_actor(line.value, layout.font, kInk, true);
                value->GetTextProperty()->SetJustificationToRight();
                value->SetPosition(right, y);
                renderer.AddActor2D(value);
            }
            if (line.swatch)
                renderer.AddActor2D(rectangle(
                    left, y + 0.1 * layout.font, left + 0.85 * layout.font, y + 0.95 * layout.font, *line.swatch, 1.0));
        }
    }

    /// The data that the scale bar's observer changes after a motion of the camera.
    struct ScaleBar {
        int width = 0, height = 0;
        double left = 0.0, bottom = 0.0, longest_px = 0.0;
        vtkSmartPointer<vtkPoints> points;
        vtkSmartPointer<vtkTextActor> label;
        double shown_mm = 0.0, shown_px = 0.0;

        void update(vtkCamera& camera)
        {
            const double half_mm = camera.GetParallelProjection() != 0
                ? camera.GetParallelScale()
                : camera.GetDistance() * std::tan(0.5 * camera.GetViewAngle() * std::numbers::pi / 180.0);
            const double px_per_mm = 0.5 * height / half_mm;
            const double mm = round_length(longest_px / px_per_mm);
            const double px = mm * px_per_mm;
            if (mm == shown_mm && px == shown_px)
                return;
            shown_mm = mm;
            shown_px = px;
            const double t = std::max(2.0, 0.004 * height), tick = 3.0 * t;
            // One outline: |____|
            const std::array<std::array<double, 2>, 8> outline { { { 0, 0 }, { px, 0 }, { px, tick }, { px - t, tick },
                { px - t, t }, { t, t }, { t, tick }, { 0, tick } } };
            for (std::size_t i = 0; i < outline.size(); ++i)
                points->SetPoint(static_cast<vtkIdType>(i), left + outline[i][0], bottom + outline[i][1], 0.0);
            points->Modified();
            std::string text = mm >= 1.0 ? std::to_string(std::lround(mm)) : std::to_string(mm).substr(0, 4);
            label->SetInput((text + " mm").c_str());
            label->SetPosition(left + 0.5 * px, bottom + tick + t);
        }
    };

    void update_scale_bar(vtkObject* caller, unsigned long, void* data, void*)
    {
        static_cast<ScaleBar*>(data)->update(*static_cast<vtkRenderer*>(caller)->GetActiveCamera());
    }

    void follow_main_camera(vtkObject* caller, unsigned long, void* data, void*)
    {
        vtkCamera& own = *static_cast<vtkRenderer*>(caller)->GetActiveCamera();
        vtkCamera& main = *static_cast<vtkRenderer*>(data)->GetActiveCamera();
        const double* out = main.GetViewPlaneNormal();
        constexpr double kDistance = 5.0;
        own.SetFocalPoint(0.0, 0.0, 0.0);
        own.SetPosition(kDistance * out[0], kDistance * out[1], kDistance * out[2]);
        own.SetViewUp(main.GetViewUp());
        own.SetParallelProjection(1);
        own.SetParallelScale(0.95);
        own.SetClippingRange(1.0, 10.0);
    }

    /// Observers own their data: VTK calls back to free it.
    template <class Data>
    void observe_start(vtkRenderer& renderer, void (*call)(vtkObject*, unsigned long, void*, void*), Data* data,
        void (*free_data)(void*))
    {
        auto command = vtkSmartPointer<vtkCallbackCommand>::New();
        command->SetCallback(call);
        command->SetClientData(data);
        command->SetClientDataDeleteCallback(free_data);
        renderer.AddObserver(vtkCommand::StartEvent, command);
    }

} // namespace

void set_annotation_font(const std::string& file) { annotation_font() = file; }

double round_length(double longest_mm)
{
    const double power = std::pow(10.0, std::floor(std::log10(longest_mm)));
    for (const double step : { 5.0, 2.0 })
        if (step * power <= longest_mm)
            return step * power;
    return power;
}

char anatomical_letter(const Vec3& direction)
{
    Eigen::Index axis = 0;
    direction.cwiseAbs().maxCoeff(&axis);
    constexpr std::array<std::array<char, 2>, 3> kLetters { { { 'R', 'L' }, { 'A', 'P' }, { 'I', 'S' } } };
    return kLetters[static_cast<std::size_t>(axis)][direction[axis] > 0.0 ? 1 : 0];
}

void add_text(vtkRenderer& renderer, vtkRenderer& panels, const Scene& scene, int width, int height)
{
    const int font = font_size(scene, width, height);
    double top = height - 0.6 * font;
    if (!scene.title.empty()) {
        int size = static_cast<int>(1.25 * font);
        const double wide = width_of(*text_actor(scene.title, size, kInk, true), renderer);
        size = std::max(kSmallestFont, static_cast<int>(size * std::min(1.0, 0.94 * width / std::max(wide, 1.0))));
        auto title = text_actor(scene.title, size, kInk, true);
        title->SetPosition(0.6 * font, top - 1.2 * size);
        shade_behind(*title);
        renderer.AddActor2D(title);
        top -= 1.7 * size;
    }
    for (const std::string& line : scene.notes) {
        top -= 1.4 * font;
        auto note = text_actor(line, font, kInk, false);
        note->SetPosition(0.6 * font, top);
        shade_behind(*note);
        renderer.AddActor2D(note);
    }
    if (!scene.legend.empty()) // above the scale bar
        add_legend(renderer, panels, scene, width, top, scene.scale_bar ? 0.16 * height : 0.0, font);
}

void add_words(vtkRenderer& renderer, const Scene& scene, int width, int height)
{
    const int font = font_size(scene, width, height);
    for (const TextItem& item : scene.words) {
        auto word = text_actor(item.text, font, item.color, true);
        vtkTextProperty& property = *word->GetTextProperty();
        property.SetShadow(1);
        property.SetJustificationToCentered();
        property.SetVerticalJustificationToCentered();
        word->GetPositionCoordinate()->SetCoordinateSystemToWorld();
        word->GetPositionCoordinate()->SetValue(item.position.x(), item.position.y(), item.position.z());
        renderer.AddActor2D(word);
    }
}

void add_scale_bar(vtkRenderer& renderer, const Scene& scene, int width, int height)
{
    const int font = font_size(scene, width, height);
    auto bar = std::make_unique<ScaleBar>();
    bar->width = width;
    bar->height = height;
    bar->left = 1.2 * font;
    bar->bottom = 1.2 * font;
    bar->longest_px = 0.30 * width;
    bar->points = vtkSmartPointer<vtkPoints>::New();
    bar->points->SetNumberOfPoints(8);
    bar->label = text_actor("", font, kInk, true);
    bar->label->GetTextProperty()->SetJustificationToCentered();
    auto cells = vtkSmartPointer<vtkCellArray>::New();
    cells->InsertNextCell({ 0, 1, 4, 5 }); // the bar
    cells->InsertNextCell({ 0, 5, 6, 7 }); // left tick
    cells->InsertNextCell({ 1, 2, 3, 4 }); // right tick
    auto data = vtkSmartPointer<vtkPolyData>::New();
    data->SetPoints(bar->points);
    data->SetPolys(cells);
    auto mapper = vtkSmartPointer<vtkPolyDataMapper2D>::New();
    mapper->SetInputData(data);
    auto actor = vtkSmartPointer<vtkActor2D>::New();
    actor->SetMapper(mapper);
    actor->GetProperty()->SetColor(kInk.r, kInk.g, kInk.b);
    renderer.AddActor2D(actor);
    renderer.AddActor2D(bar->label);
    observe_start(renderer, update_scale_bar, bar.release(),
        [](void* data_of_bar) { delete static_cast<ScaleBar*>(data_of_bar); });
}

void add_edge_letters(vtkRenderer& renderer, const Scene& scene, int width, int height)
{
    const Camera& camera = scene.camera;
    const int font = static_cast<int>(1.1 * font_size(scene, width, height));
    const Vec3 sight = (camera.aim - camera.eye).normalized();
    const Vec3 right = sight.cross(camera.up).normalized();
    const Vec3 up = right.cross(sight);
    struct Place {
        Vec3 direction;
        double x, y;
    };
    const double inset = 0.8 * font;
    for (const Place& place : { Place { right, width - inset, 0.5 * height }, Place { -right, inset, 0.5 * height },
             Place { up, 0.5 * width, 0.80 * height }, Place { -up, 0.5 * width, inset + 0.10 * height } }) {
        auto letter = text_actor(std::string(1, anatomical_letter(place.direction)), font, { 1.0, 0.85, 0.35 }, true);
        letter->GetTextProperty()->SetJustificationToCentered();
        letter->GetTextProperty()->SetVerticalJustificationToCentered();
        letter->SetPosition(place.x, place.y);
        renderer.AddActor2D(letter);
    }
}

void fill_marker(vtkRenderer& marker, vtkRenderer& main)
{
    auto cube = vtkSmartPointer<vtkAnnotatedCubeActor>::New();
    cube->SetXPlusFaceText("L");
    cube->SetXMinusFaceText("R");
    cube->SetYPlusFaceText("P");
    cube->SetYMinusFaceText("A");
    cube->SetZPlusFaceText("S");
    cube->SetZMinusFaceText("I");
    // Upright for a standing patient seen from any side; S and I as seen with the front below.
    cube->SetXFaceTextRotation(0.0);
    cube->SetYFaceTextRotation(0.0);
    cube->SetZFaceTextRotation(-90.0);
    cube->SetFaceTextScale(0.60);
    cube->GetCubeProperty()->SetColor(0.30, 0.36, 0.42);
    cube->GetCubeProperty()->SetAmbient(0.5);
    cube->GetCubeProperty()->SetDiffuse(0.6);
    cube->SetTextEdgesVisibility(0);
    for (vtkProperty* face :
        { cube->GetXPlusFaceProperty(), cube->GetXMinusFaceProperty(), cube->GetYPlusFaceProperty(),
            cube->GetYMinusFaceProperty(), cube->GetZPlusFaceProperty(), cube->GetZMinusFaceProperty() }) {
        face->SetColor(1.0, 0.92, 0.55);
        face->SetAmbient(0.9);
        face->SetDiffuse(0.1);
    }
    marker.AddActor(cube);
    observe_start(marker, follow_main_camera, &main, nullptr);
}

} // namespace retractor::ui
