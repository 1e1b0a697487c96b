#pragma once
// A case: one patient's images, materials and planned approaches. A case is one folder that can be handed on. The file
// case.json in the folder describes the case. Units mm, N, MPa; frame patient LPS.

#include "datasets/dicom/dicom_identity.h"
#include "fem/material/material.h"
#include "mesh/image/volume.h"
#include "planner/case/approach.h"
#include "planner/case/assumed_vessel.h"
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
    std::string sha256; ///< checksum() of the content; 64 hexadecimal digits
};

/// The supports that hold the wall in place while the hooks pull.
struct SupportSpec {
    std::vector<std::string> labels { "spine" }; ///< labels that hold the ribs; see wall_supports()
    bool region_border = true; ///< also fix the mesh where it was cut off; see wall_supports()
};

/// Limits of a pressure: the largest suction is a vacuum; the largest pressure is ten bar, more than any tissue is
/// under.
inline constexpr double kMostSuctionKPa = 100.0, kMostPressureKPa = 1000.0;

/// The pressure of a label that is no wall on the wall.
struct PressureSpec {
    std::string label;
    double pressure_kPa = 0.0; ///< from -kMostSuctionKPa (suction) to kMostPressureKPa; 0: none
};

/// The default name of a case file.
inline constexpr std::string_view kCaseFileName = "case.json";

struct Case {
    std::filesystem::path folder; ///< folder of the case file; not written
    std::string file_name { kCaseFileName }; ///< name of the case file in the folder; not written
    std::optional<datasets::PatientIdentity> patient; ///< kept only on request; never shown
    std::optional<FileReference> ct; ///< may be missing: a scene can do without a CT
    FileReference labels;
    mesh::LabelTable label_table; ///< the whole table of the label volume: names, materials, roles
    /// Labels that were estimated from their surroundings, because the image does not show the structure.
    std::vector<std::string> estimated_labels;
    /// Vessels and nerves that no label shows, at their usual places or where a hand has put them.
    std::vector<AssumedVessel> assumed_vessels {};
    fem::MaterialTable materials = fem::default_materials();
    SupportSpec supports;
    ContactMode contact = ContactMode::automatic; ///< of all approaches
    SolverSettings solution; ///< solver settings of all approaches
    std::vector<PressureSpec> pressures; ///< pressures on the wall
    SizingSpec sizing; ///< sizing of new approaches
    std::vector<Approach> approaches; ///< with unique names
    std::vector<std::string> views { "surgeon", "overview", "slices" }; ///< pictures to make; see kViewNames
    /// Numbers out of their plausible ranges (plausible_input.h) are planned with and recorded, instead of refused.
    bool accept_implausible = false;

    std::filesystem::path file() const { return folder / file_name; }
    std::filesystem::path labels_path() const { return folder / labels.path; }
    std::filesystem::path ct_path() const { return ct ? folder / ct->path : std::filesystem::path {}; }
};

inline constexpr std::string_view kViewNames[] = { "surgeon", "overview", "slices" };

/// Whether there is something to cut: a soft label of role wall. Bones alone are no wall.
bool has_soft_wall(const mesh::LabelTable& table);

/// The materials of the wall by label, adapted to this kind of element; see as_solved().
/// @throws InputError as find_material() does
std::vector<fem::Material> materials_as_solved(const Case& planned_case, ElementKind element);
/// The materials for the kind of element that the case is solved with.
std::vector<fem::Material> materials_as_solved(const Case& planned_case);

/// The approach of this name. @throws InputError naming the existing approaches when there is none
const Approach& find_approach(const Case& planned_case, std::string_view name);
Approach& find_approach(Case& planned_case, std::string_view name);

/// Adds a checked approach.
/// @throws InputError when the name is taken, or the target, a retracted or an uncut label is not in the label table;
/// the case is then unchanged
void add_approach(Case& planned_case, Approach approach);

/// @throws InputError when there is no approach of this name
void remove_approach(Case& planned_case, std::string_view name);

bool is_estimated(const Case& planned_case, std::string_view label);

/// Whether any of the pressures is other than 0.
bool under_pressure(const Case& planned_case);

/// @throws InputError naming the entry ("/pressures/0/...") when a label is missing, is wall or is listed twice, when a
/// pressure is not finite or beyond the limits, or when the tissue far from the lips is linear
/// (SolverSettings::near_mm)
void check_pressures(const Case& planned_case);

/// Checks the case without looking at files. @throws InputError with the JSON pointer of the first error
void check_case(const Case& planned_case);

} // namespace retractor::planner
