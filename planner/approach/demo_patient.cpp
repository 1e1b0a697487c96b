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

    /// Each with the retractor that surgeons use. The ribs of this phantom bear these openings, and the demo's coarse
    /// mesh still believes them: from about 20 mm on an element at the end of the divided space turns inside out.
    constexpr std::array<DemoApproach, 3> kDemoApproaches { { { "median", "sternal", 40.0 },
        { "intercostal:4", "finochietto", 16.0 }, { "distal", "finochietto", 16.0 } } };

    void add_approaches(Case& planned_case, const Job& job)
    {
        Patient patient(planned_case, job);
        for (const DemoApproach& demo : kDemoApproaches) {
            ApproachRequest request;
            request.template_name = demo.template_name;
            request.target.label = "aneurysm";
            request.sizing = planned_case.sizing;
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
    // Four-node elements: ten-node elements take more than a quarter of an hour for the three walls.
    demo.planned_case.solution.element = ElementKind::p1;
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
