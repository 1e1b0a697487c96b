#pragma once
// Retractors: the instruments in the table, and their two blades on an approach. Units mm, N, degrees; frame patient
// LPS.
//
// Each instrument is a rigid frame with two blades on a rack. The arms of the blades run along the lips at the level of
// the skin, and a blade turns about its arm within its play. The table of this program can be replaced by a file.

#include "fem/statics/frame_opening.h"
#include "planner/case/case.h"

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// One row of the table of instruments.
struct RetractorKind {
    std::string kind; ///< name on the command line and in case.json
    std::string meaning; ///< the instrument, in words
    double blade_width_mm = 0.0; ///< along the incision
    double blade_depth_mm = 0.0; ///< from the arm into the wound, of the usual blade
    double deepest_blade_mm = 0.0; ///< such blades are made as deep as this, for thick walls
    double play_deg = 0.0; ///< largest turn of a blade about its arm, to either side
    double greatest_opening_mm = 0.0;
    std::string source; ///< a paper or a catalogue; "ours": an estimate of this program's authors
};

/// The table of this program: finochietto, sternal and midcab.
std::span<const RetractorKind> built_in_retractors();

/// Reads a table from a file: {"retractors": [{"kind", "meaning", "blade_width_mm", "blade_depth_mm", "play_deg",
/// "greatest_opening_mm", "source"}, ...]}; "deepest_blade_mm" may be left out where all blades have one depth.
/// @throws IoError when the file cannot be read, InputError naming the JSON pointer of a bad row
std::vector<RetractorKind> read_retractors(const std::filesystem::path& file);

/// @throws InputError naming the known kinds when the table has no such kind
const RetractorKind& find_retractor(std::span<const RetractorKind> table, std::string_view kind);

/// How far a retractor opens: one of the two.
struct RetractorDrive {
    double opening_mm = 0.0;
    std::optional<double> force_N {};
};

/// A retractor in the middle of the incision, with the usual blades, or deeper ones of the same kind where the wall is
/// thicker than those are deep.
RetractorSpec make_retractor(const Approach& approach, const RetractorKind& kind, const RetractorDrive& drive);

/// Gives the retractor of an approach deeper blades of its kind where the wall is thicker than its blades are deep. A
/// kind that is not in the table of this program keeps its blades. @pre approach.retractor
void deepen_blades(Approach& approach);

/// Gives an approach of the case a retractor in place of its hooks or retractor.
/// @throws InputError as check_approach() and find_approach() do, and where the wall is too thin for the blades
void set_retractor(
    Case& planned_case, std::string_view approach_name, const RetractorKind& kind, const RetractorDrive& drive);

/// The approach with a retractor as it was set and cranked by hand.
/// @param cranked its kind, sizes and opening; where it lies along the incision is not read
/// @param at between its blades, at rest
/// @throws InputError where this is farther than 30 mm from the incision, as check_approach() does, and where the wall
/// is too thin for the blades
Approach with_retractor_at(Approach approach, RetractorSpec cranked, const Vec3& at);

/// The two blades as hooks, side +1 first, each with half of the opening. @pre approach.retractor
/// @throws InputError where the wall is too thin for the blades
std::vector<HookSpec> blades_of(const Approach& approach);

/// The frame, for the solver. The pivots lie on the incision, where the arms are.
/// @pre approach.retractor, and approach.hooks are blades_of() the approach
fem::BladeFrame blade_frame_of(const Approach& approach);

/// "Finochietto rib spreader, 60.0 mm", "sternal spreader, 200.0 N".
std::string retractor_text(const RetractorSpec& retractor);

} // namespace retractor::planner
