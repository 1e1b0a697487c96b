#pragma once
// Plays the plans of a case as a movie: the patient with the incision, what the blade passes, what is cut, the wound as
// it is pulled open, the flight to the surgeon's eye, what is seen from there and what is reached; at the end planned
// approaches side by side. The steps and their words are those of the conference (planner/decision/presentation.h). The
// same plans give the same pictures, in the window and on the command line.

#include "mesh/base/job.h"
#include "planner/case/patient.h"
#include "planner/decision/decisions.h"
#include "planner/plan/planned_field.h"
#include "ui/scene/vtk/render.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

namespace retractor::ui {

struct MovieSettings {
    int width = 1280, height = 720; ///< pixels, both even
    int frames_per_second = 20;
    double hold_s = 4.0; ///< time to read a step
};

/// Receives the pictures in their order; each is shown for a number of frames.
using MovieSink = std::function<void(const Image& picture, int frames)>;

/// @throws InputError on odd or empty sizes, a rate below 1, or a time that is not positive
void check_movie(const MovieSettings& settings);

struct MovieContent {
    planner::Case planned_case; ///< of the patient, with the approaches to play
    /// Plans of these approaches. A field without numbers is left out; an approach without a field is shown before the
    /// cut only.
    std::vector<planner::PlannedField> fields;
    planner::Decisions decisions {}; ///< of the team
    TextLanguage language {}; ///< of the texts in the pictures
};

/// Draws the movie.
/// @return false: cancelled
/// @throws as check_movie(), OffscreenRenderer::render() and `sink`
bool play_plans(planner::Patient& patient, const MovieContent& content, const MovieSettings& settings,
    OffscreenRenderer& renderer, const MovieSink& sink, const Job& job = {});

/// Writes the movie as VP9 in WebM, in one step.
/// @param pictures folder for all frames as 00001.png, 00002.png ..; frames of an earlier movie there are replaced;
/// empty: none
/// @return false: cancelled, and nothing is written
/// @throws InputError also when `pictures` holds other files; as play_plans(), VideoFile and write_png()
bool write_movie(const std::filesystem::path& path, const std::filesystem::path& pictures, planner::Patient& patient,
    const MovieContent& content, const MovieSettings& settings, std::unique_ptr<OffscreenContext> context,
    const Job& job = {});

} // namespace retractor::ui
