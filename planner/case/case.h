#pragma once
// A case: one patient's images, materials and planned approaches. One folder that can be handed on, described by the
// case.json in it. Units mm, N, MPa; frame patient LPS.

#include "datasets/dicom/dicom_identity.h"
#include "fem/material/material.h"
#include "mesh/image/volume.h"
#include "planner/case/approach.h"
#include "planner/case/solver_settings.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// A file, or a folder of files (a DICOM series), beside the case file.
struct FileReference {
    std::filesystem::path path; ///< relative to the case folder, inside it
    std::string sha256; ///< see checksum(); 64 hexadecimal digits
};

/// What holds the wall in place while the hooks pull.
struct SupportSpec {
    std::vector<std::string> labels { "spine" }; ///< what holds the ribs: see wall_supports()
    bool region_border = true; ///< also fix the mesh where it was cut off: see wall_supports()
};

/// The largest suction is a vacuum, and the largest pressure, ten bar, is more than any tissue is under.
inline constexpr double kMostSuctionKPa = 100.0, kMostPressureKPa = 1000.0;

/// The pressure of a label that is no wall on the wall.
struct PressureSpec {
    std::string label;
    double pressure_kPa = 0.0; ///< -kMostSuctionKPa to kMostPressureKPa; negative: suction; 0: none
};

/// What a case file is called unless somebody names it otherwise.
inline constexpr std::string_view kCaseFileName = "case.json";

struct Case {
    std::filesystem::path folder; ///< where the case file lies; not written
    std::string file_name { kCaseFileName }; ///< of the case file in the folder; not written
    std::optional<datasets::PatientIdentity> patient; ///< only where somebody asked to keep it; shown nowhere
    std::optional<FileReference> ct; ///< a scene may do without
    FileReference labels;
    mesh::LabelTable label_table; ///< the whole table of the label volume: names, materials, roles
    fem::MaterialTable materials = fem::default_materials();
    SupportSpec supports;
    bool contact = false; ///< lips and organs hold each other off (fem/contact.h); else they pass through
    SolverSettings solution; ///< of all approaches
    std::vector<PressureSpec> pressures; ///< on the wall
    SizingSpec sizing; ///< what new approaches start with
    std::vector<Approach> approaches; ///< names unique
    std::vector<std::string> views { "surgeon", "overview", "slices" }; ///< pictures to make, see kViewNames

    std::filesystem::path file() const { return folder / file_name; }
    std::filesystem::path labels_path() const { return folder / labels.path; }
    std::filesystem::path ct_path() const { return ct ? folder / ct->path : std::filesystem::path {}; }
};

inline constexpr std::string_view kViewNames[] = { "surgeon", "overview", "slices" };

/// Whether there is something to cut: a label of role wall that is soft. Bones alone are no wall.
bool has_soft_wall(const mesh::LabelTable& table);

/// The materials of the wall by label, as elements of this kind can have them: see as_solved().
/// @throws InputError as find_material() does.
std::vector<fem::Material> materials_as_solved(const Case& planned_case, ElementKind element);
/// The same for the kind of element that the case is solved with.
std::vector<fem::Material> materials_as_solved(const Case& planned_case);

/// The approach of this name. @throws InputError naming those there are.
const Approach& find_approach(const Case& planned_case, std::string_view name);
Approach& find_approach(Case& planned_case, std::string_view name);

/// Adds a checked approach: its name is new, its target, retracted and uncut labels are in the label table.
/// @throws InputError otherwise; the case is then unchanged.
void add_approach(Case& planned_case, Approach approach);

/// @throws InputError when there is none of this name.
void remove_approach(Case& planned_case, std::string_view name);

/// Whether any of the pressures presses or sucks.
bool under_pressure(const Case& planned_case);

/// @throws InputError naming the entry ("/pressures/0/..."): a label that there is not, that is wall or comes twice, a
/// pressure that is not finite or beyond the limits; or a linear far field.
void check_pressures(const Case& planned_case);

/// @throws InputError with the JSON pointer of the first thing that is wrong; looks at no file.
void check_case(const Case& planned_case);

} // namespace retractor::planner
