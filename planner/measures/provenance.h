#pragma once
// The provenance of a result: its inputs, the program and the date. The report and metrics.json show the provenance, so
// that a printed page can be traced to its case. Units MPa.

#include "planner/case/case.h"

#include <nlohmann/json_fwd.hpp>

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

/// The record holds no name or id of a person; the checksums identify the images.
struct Provenance {
    std::string date; ///< UTC, "2026-11-22T12:58:03Z"
    std::string program; ///< name and version
    /// File with its folder, "C/case.json"; words of the identity that the case keeps are withheld.
    std::string case_file;
    bool identity_in_case = false; ///< the case file holds the patient's identity
    FileReference labels;
    std::optional<FileReference> ct;
    SolverSettings solution;
    ContactMode contact = ContactMode::automatic;
    std::vector<PressureSpec> pressures;
    SupportSpec supports;
    std::string stiffness {}; ///< factors on the stiffness, as stiffness_text(); empty: none
    fem::MaterialTable materials; ///< materials of the wall's labels, with Poisson's ratios as the elements take them
};

/// "2026-11-22T12:58:03Z"
std::string utc_text(std::chrono::system_clock::time_point when);

/// @param program name and version
Provenance provenance_of(const Case& planned_case, std::string program, std::chrono::system_clock::time_point when);

/// Rows for people: a caption and its text, in the order to show them; without the materials.
std::vector<std::pair<std::string, std::string>> provenance_rows(const Provenance& provenance);

/// The law of a material, in words.
std::string law_text(const Provenance& provenance, const fem::Material& material);

nlohmann::ordered_json provenance_document(const Provenance& provenance);

} // namespace retractor::planner
