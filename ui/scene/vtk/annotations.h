#pragma once
// Adds words and signs to a view: title, legend, scale bar, orientation letters.

#include "ui/scene/scene.h"

#include <string>

class vtkRenderer;

namespace retractor::ui {

/// Sets the font of all texts in pictures. Call it before the first picture is drawn.
/// @param file a font that FreeType reads; empty: VTK's own, which has no Japanese
void set_annotation_font(const std::string& file);

/// Adds title, notes and legend, inside the view and large enough to be read at arm's length.
/// @param width, height size of the view in pixels
/// @param panels drawn before `words`, because VTK does not order overlapping 2D actors of one renderer
void add_text(vtkRenderer& words, vtkRenderer& panels, const Scene& scene, int width, int height);

/// Adds the texts at places in the patient.
void add_words(vtkRenderer& renderer, const Scene& scene, int width, int height);

/// Adds a bar of a round length (mm, in the plane of the camera's aim). The bar stays correct while the camera moves.
void add_scale_bar(vtkRenderer& renderer, const Scene& scene, int width, int height);

/// Adds the letters at the four edges of a slice view.
void add_edge_letters(vtkRenderer& renderer, const Scene& scene, int width, int height);

/// Fills a small renderer with the cube of anatomical directions. Its camera follows the camera of `main`.
void fill_marker(vtkRenderer& marker, vtkRenderer& main);

/// The patient direction (R, L, A, P, S or I) nearest to a vector.
char anatomical_letter(const Vec3& direction);

/// The longest of 1, 2, 5, 10, 20, 50 ... mm that does not exceed `longest_mm`.
double round_length(double longest_mm);

} // namespace retractor::ui
