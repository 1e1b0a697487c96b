#include "planner/approach/demo_patient.h"

#include "datasets/dicom/dicom.h"
#include "datasets/io/volume_io.h"
#include "datasets/phantoms/phantom.h"
#include "mesh/base/error.h"
#include "planner/approach/approach_templates.h"
#include "planner/approach/retractors.h"
#include "planner/case/case_io.h"
#include "planner/case/import_case.h"
#include "planner/case/patient.h"

#include <array>
#include <system_error>

namespace retractor::planner {

namespace {

    namespace fs = std::filesystem;

    struct DemoApproach {
        const char* template_name;
        const char* retractor;
        double opening_mm;
    };

    /// Each with the retractor that surgeons use. The ribs of this phantom bear these openings.
    constexpr std::array<DemoApproach, 3> kDemoApproaches { { { "median", "sternal", 40.0 },
        { "intercostal:4", "finochietto", 30.0 }, { "distal", "finochietto", 25.0 } } };

    /// Ten-node elements at bone and lips bear these openings on edges that are twice those of an import. The force of
    /// the fourth space is within 2 % of that on edges of 12 and 24 mm.
    constexpr double kEdgeMm = 16.0, kCoarseEdgeMm = 30.0;

    void add_approaches(Case& planned_case, const Job& job)
    {
        Patient patient(planned_case, job);
        for (const DemoApproach& demo : kDemoApproaches) {
            ApproachRequest request;
            request.template_name = demo.template_name;
            request.target.label = "aneurysm";
            request.sizing = planned_case.sizing;
            request.sizing.corridor_edge_mm = kEdgeMm;
            request.sizing.coarse_edge_mm = kCoarseEdgeMm;
            Approach approach = approach_from_template(*patient.labels(), *patient.anatomy(), request);
            const std::string name = approach.name;
            add_approach(planned_case, std::move(approach));
            set_retractor(planned_case, name, find_retractor(built_in_retractors(), demo.retractor),
                { .opening_mm = demo.opening_mm });
        }
    }

} // namespace

std::optional<DemoPatient> write_demo_patient(const fs::path& folder, const Job& job)
{
    DemoPatient demo;
    Stopwatch watch;
    const auto step_done = [&](const char* step) {
        demo.seconds.emplace_back(step, watch.seconds());
        watch = {};
        return !job.cancelled();
    };
    std::error_code code;
    fs::create_directories(folder, code);
    if (code)
        throw IoError("cannot make the folder: " + code.message(), folder.string());
    ImportRequest request;
    request.ct = folder / "ct";
    request.labels = { folder / "labels.nrrd" };
    {
        const datasets::Phantom phantom = datasets::make_thorax_phantom({}, job);
        if (!step_done("phantom"))
            return std::nullopt;
        job.report("write phantom", 0.0);
        datasets::write_dicom_series(request.ct, phantom.ct);
        job.report("write phantom", 0.7);
        datasets::write_label_volume(request.labels.front(), phantom.labels);
        if (!step_done("write DICOM"))
            return std::nullopt;
    }
    const ImportedCase imported = read_import(request, job);
    if (imported.cancelled || job.cancelled())
        return std::nullopt;
    demo.planned_case = write_import(imported, folder / kCaseFileName);
    static_cast<void>(step_done("read DICOM, import"));
    job.report("approaches", 0.0);
    add_approaches(demo.planned_case, job);
    if (job.cancelled())
        return std::nullopt;
    write_case(demo.planned_case);
    static_cast<void>(step_done("templates"));
    return demo;
}

} // namespace retractor::planner
