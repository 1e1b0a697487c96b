#pragma once
// A picture as plain data: what is drawn, how it looks and from where. No drawing library is named here, so a
// scene can be built, tested and handed to another thread without one. Units mm; frame patient LPS (x to the
// patient's left, y to the back, z to the head).

#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace retractor::ui {

/// sRGB, each 0 to 1.
struct Color {
    double r = 1.0, g = 1.0, b = 1.0;
};

/// How light falls on a surface.
enum class Finish {
    matte, ///< no shine
    skin, ///< soft, slight sheen, fine mottling
    wet, ///< moist tissue: small bright highlights
    bone, ///< hard, nearly matte
    metal, ///< steel
    unlit, ///< the plain colour, whatever the light
};

/// The natural look of a surface; `texture`, from 0 (uniform colour) to 1, is the strength of the procedural variation.
struct Look {
    Color color {};
    Finish finish = Finish::matte;
    double texture = 0.0;
};

/// A triangle surface.
struct SurfaceItem {
    std::string name {};
    std::shared_ptr<const TriMesh> mesh {};
    Look look {};
    /// Used when not empty: the look of each triangle by mesh->labels. Every label of the mesh must have an entry.
    std::map<Label, Look> look_of_label {};
    double opacity = 1.0;
    bool smooth = true; ///< shading normals averaged, except across edges sharper than 40 degrees
    bool show_edges = false; ///< draw the mesh's edges
    bool target = false; ///< highlighted (saturated, rim-lit)
    bool on_top = false; ///< the front is drawn over everything, also over nearer surfaces
};

/// One byte per voxel of `grid`; other than 0 means hidden. The grid may differ from the image's grid.
struct VoxelMask {
    mesh::ImageGrid grid {};
    std::vector<std::uint8_t> hidden {};
};

/// An axis-aligned box in patient LPS, mm.
struct Box {
    Vec3 low = Vec3::Zero(), high = Vec3::Zero();
};

/// A volume rendering. An image and a mask that several pictures share are uploaded once.
struct VolumeItem {
    std::string name {};
    std::shared_ptr<const mesh::Volume> image {}; ///< CT, Hounsfield units
    /// Hides the voxels that tetrahedra replace or an approach removes. Half-filled voxels at the mask's border are
    /// hidden too.
    std::shared_ptr<const VoxelMask> mask = nullptr;
    double opacity = 1.0; ///< scales the opacities of all tissues
};

/// Farther from a slice an incision would seem to lie across organs through which it does not go.
inline constexpr double kNearSliceMm = 10.0;

/// A polyline: an incision, a line of sight.
struct LineItem {
    std::string name {};
    std::vector<Vec3> points {};
    Color color { 0.10, 0.25, 0.95 };
    double width_px = 4.0; ///< at a picture height of 960 pixels
    bool on_top = false; ///< drawn even where something is in front of it
    double near_slice_mm = kNearSliceMm; ///< a linked slice shows the parts that lie as near to it (linked_slices.h)
};

/// An anatomical plane. Shown as radiologists do: axial from the feet, coronal from the front, sagittal from
/// the patient's left (front to the left of the picture).
enum class SlicePlane { axial, coronal, sagittal };

/// A rectangle in any direction.
struct ObliqueSlice {
    Vec3 right = Vec3::UnitX(), up = Vec3::UnitZ(); ///< unit and at right angles, along the picture's sides
    double half_width_mm = 100.0, half_height_mm = 100.0;
};

/// A grey image on a plane, with label outlines.
struct SliceItem {
    std::shared_ptr<const mesh::Volume> image {};
    SlicePlane plane = SlicePlane::axial;
    Vec3 point = Vec3::Zero(); ///< a point of the plane; the middle of an oblique slice
    std::optional<ObliqueSlice> oblique = std::nullopt; ///< instead of `plane`
    double window_hu = 500.0, level_hu = 40.0;
    std::shared_ptr<const mesh::LabelVolume> labels = nullptr; ///< may be null
    std::map<Label, Color> outline_of_label {}; ///< labels to outline, in these colours
    double fill = 0.15; ///< strength of the tint of outlined labels, 0 to 1
    double pixel_mm = 0.0; ///< size of a sample, so that outlines are one pixel of a small view; 0: half a voxel
};

/// Of surfaces and volumes only what lies on one side of a plane is drawn.
struct CutAway {
    Vec3 point = Vec3::Zero();
    Vec3 kept = Vec3::UnitY(); ///< unit, across the plane, to the side that is drawn
    /// Drawn on the plane, where its labels are not 0. Its plane is that of the cut.
    std::optional<SliceItem> face = std::nullopt;
};

/// A short text at a place in the patient, drawn over everything.
struct TextItem {
    std::string text {};
    Vec3 position = Vec3::Zero();
    Color color {};
};

/// One line of the legend. A line without a value is a heading.
struct LegendLine {
    std::string key {}, value {};
    std::optional<Color> swatch = std::nullopt; ///< a coloured square before the key
};

struct Camera {
    Vec3 eye { 0.0, -600.0, 0.0 };
    Vec3 aim = Vec3::Zero();
    Vec3 up = Vec3::UnitZ();
    double view_angle_deg = 30.0; ///< angle over the picture's height; perspective only
    bool parallel = false;
    double half_height_mm = 100.0; ///< half the height of the picture; parallel only
};

/// One view: everything that is drawn in one rectangle of a picture.
struct Scene {
    std::string title {};
    std::vector<SurfaceItem> surfaces {};
    std::vector<VolumeItem> volumes {};
    std::vector<LineItem> lines {};
    std::vector<SliceItem> slices {};
    std::optional<CutAway> cut_away {};
    std::vector<TextItem> words {};
    std::vector<LegendLine> legend {};
    double legend_share = 0.34; ///< largest share of the view's width
    std::vector<std::string> notes {}; ///< plain lines under the title
    double font_px = 0.0; ///< height of letters; 0: chosen from the view's size
    Camera camera {};
    Color background_low { 0.16, 0.20, 0.23 }; ///< at the bottom of the picture
    Color background_high { 0.06, 0.08, 0.10 }; ///< at the top
    bool orientation_marker = true; ///< L R A P S I
    bool scale_bar = true; ///< mm, in the plane of the camera's aim
};

/// The place of a scene in a picture: fractions of width and height, from the lower left corner.
struct Viewport {
    double left = 0.0, bottom = 0.0, right = 1.0, top = 1.0;
    Scene scene {};
};

struct Picture {
    int width = 1280, height = 960;
    std::vector<Viewport> viewports {};
};

/// Checks that the scene can be drawn.
/// @throws InputError naming the item, on NaN or infinite coordinates, indices out of range, labels without a look, an
/// eye at its aim, an up vector along the line of sight, empty sizes, or sizes that do not match
void check_scene(const Scene& scene);
/// Checks all viewports, their rectangles and the size of the picture. @throws InputError as check_scene() does
void check_picture(const Picture& picture);

/// The box round a scene's surfaces, lines, volumes (their images) and slices; nothing when the scene is empty.
std::optional<Box> scene_bounds(const Scene& scene);

/// A camera that sees all of `box` along `direction` (from the eye into the scene) and fills the picture's height.
Camera camera_for_box(const Box& box, const Vec3& direction, const Vec3& up, double view_angle_deg = 30.0);
/// A parallel camera straight in front of a slice, with the whole image in a picture of `aspect` = width / height.
Camera camera_for_slice(const SliceItem& slice, double aspect);
/// The same camera with only `box` in the picture. An oblique slice fills the picture whatever the box.
Camera camera_for_slice(const SliceItem& slice, const Box& box, double aspect);

} // namespace retractor::ui
