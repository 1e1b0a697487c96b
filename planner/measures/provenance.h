#pragma once
// What a result was computed from, by which program and when: what the report and metrics.json say of it, so that a
// printed page can be traced to its case. Units MPa.

#include "planner/case/case.h"

#include <nlohmann/json_fwd.hpp>

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

/// Holds no name or id of a person: the checksums say which images these are.
struct Provenance {
    std::string date; ///< UTC, "2026-11-22T12:58:03Z"
    std::string program; ///< and its version
    std::string
        case_file; ///< with the name of its folder, "C/case.json"; words of the identity the case keeps withheld
    bool identity_in_case = false; ///< the case file says whose images these are
    FileReference labels;
    std::optional<FileReference> ct;
    SolverSettings solution;
    bool contact = false;
    std::vector<PressureSpec> pressures;
    SupportSpec supports;
    fem::MaterialTable materials; ///< of the wall's labels, with Poisson's ratios as the elements take them
};

/// @param program name and version.
Provenance computation_of(const Case& planned_case, std::string program, std::chrono::system_clock::time_point when);

/// What and value for people, in the order to show them; without the materials.
std::vector<std::pair<std::string, std::string>> computation_rows(const Provenance& provenance);

/// By which law a material resists.
std::string law_text(const Provenance& provenance, const fem::Material& material);

nlohmann::ordered_json computation_document(const Provenance& provenance);

} // namespace retractor::planner
