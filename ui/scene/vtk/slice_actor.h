#pragma once
// Resamples CT slices and shows them as textured rectangles in space.

#include "ui/scene/scene.h"

#include <vtkSmartPointer.h>

#include <cstdint>
#include <vector>

class vtkActor;

namespace retractor::ui {

/// A slice as pixels. Pixel (column, row) has its centre at corner + column * across + row * upward.
struct SliceImage {
    int columns = 0, rows = 0;
    Vec3 corner = Vec3::Zero(); ///< mm, LPS
    Vec3 across = Vec3::UnitX(), upward = Vec3::UnitY(); ///< mm per pixel
    std::vector<std::uint8_t> rgb; ///< column index varies fastest
};

/// Samples the plane at the image's finest spacing; black outside the image. Outlines are one pixel wide.
SliceImage sample_slice(const SliceItem& slice);
vtkSmartPointer<vtkActor> slice_actor(const SliceItem& slice);
/// Only the parts of the slice whose labels are not 0. @pre the slice has labels
vtkSmartPointer<vtkActor> cut_face_actor(const SliceItem& slice);

} // namespace retractor::ui
