#pragma once
// The report page for the case conference: one HTML file with its pictures inside.

#include "planner/measures/field_metrics.h"
#include "planner/measures/provenance.h"
#include "planner/measures/report/neighbours_section.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

/// A picture of the report, already on disk as PNG.
struct ReportPicture {
    std::string approach; ///< name of the approach; empty: the picture shows the patient
    std::string caption;
    std::filesystem::path file;
};

/// The interactive view of a field.
struct ReportView {
    std::string approach; ///< name of the approach
    std::string scene; ///< JSON that the report's viewer reads; it holds no "<"
};

struct Report {
    std::string title;
    std::string patient; ///< the data in words; never a name or an id of a person
    std::string chosen {}; ///< the team's choice in a sentence; empty: nothing is chosen
    std::optional<Provenance> computed; ///< inputs, program and date
    std::vector<FieldMetrics> fields;
    std::vector<std::vector<std::string>> divided_bones; ///< of each field (planner::divided_bones()); empty: not known
    /// Of each field: distances from landmarks to check in the theatre, in sentences; empty: not known.
    std::vector<std::vector<std::string>> landmarks {};
    /// Of each field: the approaches beside it; empty: not known.
    std::vector<std::vector<ReportNeighbour>> neighbours {};
    std::vector<std::string> refused; ///< approaches without numbers, and the reasons
    std::vector<ReportPicture> pictures;
    std::vector<ReportView> views {};
    std::string viewer {}; ///< script that shows the views; empty: the page has none
    std::vector<std::string> limits; ///< limits of these numbers, in words
};

/// Writes the page in one step. @throws IoError when a picture cannot be read or the page cannot be written
void write_report(const std::filesystem::path& path, const Report& report);

} // namespace retractor::planner
