#pragma once
// The report page: one self-contained HTML file (pictures inside) for the case conference.

#include "planner/measures/field_metrics.h"
#include "planner/measures/provenance.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

/// A picture of the report, already on disk as PNG.
struct ReportPicture {
    std::string approach; ///< name of the approach it belongs to; empty: of the patient
    std::string caption;
    std::filesystem::path file;
};

struct Report {
    std::string title;
    std::string patient; ///< which data, in words; never a name or an id of a person
    std::optional<Provenance> computed; ///< from what, by what and when
    std::vector<FieldMetrics> fields;
    std::vector<std::string> refused; ///< which approaches have no numbers, and why
    std::vector<ReportPicture> pictures;
    std::vector<std::string> limits; ///< what these numbers do not say
};

/// Writes the page atomically. @throws IoError when a picture cannot be read or the page not written.
void write_report(const std::filesystem::path& path, const Report& report);

} // namespace retractor::planner
