#include "ui/results/field_files.h"

#include "fem/model/loads.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/surface/wound_surface.h"
#include "mesh/tetrahedra/mesh_io.h"
#include "planner/anatomy/deflated_lung.h"
#include "planner/approach/approach_draft.h"
#include "planner/approach/divided_bones.h"
#include "planner/approach/incision_guide.h"
#include "planner/approach/neighbour_approaches.h"
#include "planner/decision/decisions.h"
#include "planner/measures/accuracy.h"
#include "planner/measures/ball_strain.h"
#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/comparison.h"
#include "planner/measures/force_moments.h"
#include "planner/measures/metric_table.h"
#include "planner/measures/metrics.h"
#include "planner/measures/ranking.h"
#include "planner/measures/region_text.h"
#include "planner/measures/rupture.h"
#include "planner/measures/tissue_values.h"
#include "planner/measures/verdict.h"
#include "planner/measures/volume_failures.h"
#include "planner/plan/saved/saved_plan.h"
#include "ui/plan_scene/case_picture.h"
#include "ui/plan_scene/plan_scene.h"
#include "ui/plan_scene/vessel_surfaces.h"
#include "ui/report_view/field_view.h"
#include "ui/results/metrics_csv.h"
#include "ui/scene/vtk/identifier_picture.h"
#include "ui/scene/vtk/render.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <set>

namespace retractor::ui {

namespace {

    using Json = nlohmann::ordered_json;

    std::string caption_of(const std::string& view)
    {
        if (view == "surgeon")
            return "The surgeon's eye: through the opened incision, target highlighted.";
        if (view == "overview")
            return "Overview of the opened patient.";
        return "Slices through the target, with the incision where it lies near them (cyan), and along and across the "
               "incision, with the cut to its depth.";
    }

    std::string contact_limit(planner::ContactMode contact)
    {
        const std::string what = "Lips, ribs, shoulder blades and organs ";
        switch (contact) {
        case planner::ContactMode::automatic:
            return what + "push against each other without friction where they would pass through each other";
        case planner::ContactMode::always:
            return what + "push against each other without friction";
        case planner::ContactMode::never:
            break;
        }
        return what + "do not slide or push against each other";
    }

    std::vector<std::string> report_limits(bool has_spine, const planner::Case& planned_case, std::string stiffness)
    {
        std::vector<std::string> limits {
            std::move(stiffness),
            has_spine ? "Beyond the meshed region, the model contains only bones and cartilages, up to their joints at "
                        "the spine. Soft tissue there does not resist the hooks, and the pictures show it at rest. A "
                        "gap at the border of the region is not a wound."
                      : "The border of the meshed region is held, so the hook forces are upper estimates.",
            contact_limit(planned_case.contact)
                + formatted(
                    "; organs do not move. Lungs that an approach holds aside are deflated to %.0f %% of their volume "
                    "at their hilum, an assumption; other organs held aside are removed from the view. ",
                    100.0 * planner::kDeflatedLungShare)
                + "Tissue without a label is not drawn and hides nothing.",
            "Fractures are foretold for ribs only, from the mean moments at which 52 tested pieces of ribs broke; "
            "single ribs differ from the mean. Age, thin bone and earlier fractures are not considered. The sternum, "
            "the joints, the cartilages and the neck of a rib at the spine are not judged.",
            "Hooks are rigid blades that bear on bone close behind them. A hook slips only where it has a force limit "
            "or a soft grip. Tissue does not tear. Inverted elements are errors of the computation.",
        };
        if (planner::under_pressure(planned_case))
            limits.emplace_back(
                "The scanned shape is taken as free of stress. Enter only the change of pressure since the scan.");
        return limits;
    }

    /// The limits of each way of solving among the fields.
    std::string stiffness_limit(const std::vector<planner::PlannedField>& fields)
    {
        std::string text = "Each tissue has a published mean stiffness, not the stiffness of this patient. The "
                           "stiffness is the same everywhere in a material. Forces are proportional to the stiffness.";
        for (const planner::PlannedField& field : fields)
            if (field.metrics.solution.choice.element == planner::ElementKind::p1)
                return text
                    + " Poisson's ratios are limited to 0.45, because the elements used here are too stiff above this "
                      "value.";
        return text;
    }

    /// Pressure on a face of each element; 0: none.
    std::vector<double> pressed_elements(const planner::PlannedField& field)
    {
        std::vector<double> pressed(field.wall.tet_count(), 0.0);
        for (const fem::SurfacePressure& pressure : field.problem.pressures)
            for (const mesh::TetFace& face : pressure.faces)
                pressed[static_cast<std::size_t>(face.tet)] = pressure.pressure / fem::kKiloPascal;
        return pressed;
    }

} // namespace

std::string_view status_word(planner::PlanStatus status)
{
    switch (status) {
    case planner::PlanStatus::done:
        return "done";
    case planner::PlanStatus::nothing_to_mesh:
        return "no wall tissue near the incision";
    case planner::PlanStatus::cut_missed:
        return "the blade does not meet the wall";
    case planner::PlanStatus::not_converged:
        return "not fully opened";
    case planner::PlanStatus::inverted:
        return "opened with elements inside out";
    case planner::PlanStatus::cancelled:
        return "cancelled";
    }
    return "unknown";
}

bool is_answer(const planner::PlannedField& field)
{
    return field.status == planner::PlanStatus::done && planner::is_believable(field.metrics);
}

void write_field_meshes(
    const std::filesystem::path& folder, planner::Patient& patient, const std::vector<planner::PlannedField>& fields)
{
    std::set<std::string> targets;
    for (const planner::PlannedField& field : fields) {
        if (!planner::is_measured(field))
            continue;
        mesh::MeshFields values;
        values.point_vectors["displacement_mm"] = field.opening.displacement;
        values.cell_scalars["strain"] = field.opening.strain;
        if (!field.problem.pressures.empty())
            values.cell_scalars["pressure_kPa"] = pressed_elements(field);
        values.texts["solution"] = planner::solution_text(field.metrics.solution.choice);
        mesh::write_vtu(folder / (field.approach.name + ".vtu"), field.wall, values);
        mesh::write_vtp(folder / (field.approach.name + "-opened.vtp"),
            mesh::deformed_boundary(field.wall, field.opening.displacement));
        const std::string target = field.approach.target.is_sphere() ? "sphere-" + field.approach.name
            : field.approach.target.is_site()                        ? "site-" + field.approach.name
                                                                     : field.metrics.target;
        if (targets.insert(target).second)
            mesh::write_vtp(folder / ("target-" + target + ".vtp"), *patient.target(field.approach.target));
    }
}

namespace {

    /// Counts the target's pixels in the surgeon's view, and names the structures in it.
    void check_and_name(Picture& picture, planner::PlannedField& field, OffscreenRenderer& renderer,
        planner::Patient& patient, const FieldViews& request)
    {
        Scene& scene = picture.viewports.front().scene;
        Scene counted = scene; // what an assumed vessel hides is in no number
        remove_vessels(counted);
        field.metrics.best_eye_pixels = target_pixels(renderer, counted).share();
        if (!request.names)
            return;
        add_names(scene,
            identifier_picture(renderer, scene, label_names(patient.planned_case()), picture.width, picture.height));
    }

    std::optional<planner::ReportPicture> draw_map(const std::filesystem::path& folder, planner::Patient& patient,
        const planner::PlannedField& field, FieldMapKind kind, OffscreenRenderer& renderer, const FieldViews& request)
    {
        const std::optional<SceneMap> map = field_map(patient, field, kind);
        if (!map)
            return std::nullopt;
        const auto name = std::find_if(
            kFieldMaps.begin(), kFieldMaps.end(), [&](const FieldMapName& one) { return one.kind == kind; });
        const std::filesystem::path file = folder / (field.approach.name + "-map-" + name->name + ".png");
        write_png(file, renderer.render(map_picture(patient, field, *map, name->words, request.width, request.height)));
        return planner::ReportPicture {
            .approach = field.approach.name, .caption = std::string(name->words) + ".", .file = file
        };
    }

    /// The n-th kept view of a field.
    planner::ReportPicture draw_kept(const std::filesystem::path& folder, planner::Patient& patient,
        const planner::PlannedField& field, const planner::NamedView& view, int n, OffscreenRenderer& renderer,
        const FieldViews& request)
    {
        Scene scene = overview_scene(patient, field);
        scene.title = planner::spoken_name(field.approach) + ": " + view.name;
        scene.camera = camera_of(view);
        const std::filesystem::path file = folder / (field.approach.name + "-view-" + std::to_string(n) + ".png");
        write_png(file,
            renderer.render(
                { .width = request.width, .height = request.height, .viewports = { { .scene = std::move(scene) } } }));
        return { .approach = field.approach.name, .caption = view.name + ".", .file = file };
    }

} // namespace

std::vector<planner::ReportPicture> render_fields(const std::filesystem::path& folder, planner::Patient& patient,
    std::vector<planner::PlannedField>& fields, const FieldViews& request, const Job& job)
{
    OffscreenRenderer renderer(make_offscreen_context(), job);
    renderer.set_language(request.language);
    std::vector<planner::ReportPicture> pictures;
    const double total
        = static_cast<double>(fields.size() * (request.views.size() + request.maps.size()) + request.kept.size());
    for (planner::PlannedField& field : fields) {
        if (!planner::is_measured(field))
            continue;
        const Stopwatch watch;
        const auto report = [&] { job.report("render", static_cast<double>(pictures.size()) / total); };
        for (const std::string& view : request.views) {
            if (job.cancelled())
                return pictures;
            if (view == "slices" && !patient.has_ct())
                continue;
            report();
            const std::filesystem::path file = folder / (field.approach.name + "-" + view + ".png");
            Picture picture = view_picture(patient, field, view, request.width, request.height);
            if (view == "surgeon")
                check_and_name(picture, field, renderer, patient, request);
            write_png(file, renderer.render(picture));
            pictures.push_back({ .approach = field.approach.name, .caption = caption_of(view), .file = file });
        }
        for (const FieldMapKind kind : request.maps) {
            if (job.cancelled())
                return pictures;
            report();
            if (auto drawn = draw_map(folder, patient, field, kind, renderer, request))
                pictures.push_back(*std::move(drawn));
        }
        int kept = 0;
        for (const planner::NamedView& view : request.kept)
            if (view.approach == field.approach.name && view.opened && !job.cancelled()) {
                report();
                pictures.push_back(draw_kept(folder, patient, field, view, ++kept, renderer, request));
            }
        field.metrics.seconds.emplace_back("render", watch.seconds());
    }
    return pictures;
}

std::vector<planner::ReportPicture> render_slices(
    const std::filesystem::path& folder, planner::Patient& patient, const FieldViews& request, const Job& job)
{
    OffscreenRenderer renderer(make_offscreen_context(), job);
    std::vector<planner::ReportPicture> pictures;
    for (const planner::Approach& approach : patient.planned_case().approaches) {
        if (job.cancelled())
            return pictures;
        const std::filesystem::path file = folder / (approach.name + "-slices.png");
        write_png(file, renderer.render(slices_picture(patient, approach, request.width, request.height)));
        pictures.push_back({ .approach = approach.name, .caption = caption_of("slices"), .file = file });
    }
    return pictures;
}

std::vector<planner::ReportPicture> render_case_views(const std::filesystem::path& folder, planner::Patient& patient,
    const std::optional<planner::TargetSpec>& target, const FieldViews& request, const Job& job)
{
    OffscreenRenderer renderer(make_offscreen_context(), job);
    std::vector<planner::ReportPicture> pictures;
    for (const std::string& view : request.views) {
        if (job.cancelled())
            return pictures;
        job.report("render", static_cast<double>(pictures.size()) / static_cast<double>(request.views.size()));
        const std::filesystem::path file = folder / (view + ".png");
        write_png(file, renderer.render(case_picture(patient, target, view, request.width, request.height)));
        pictures.push_back({ .approach = "",
            .caption = view == "slices" ? "Slices through the target, labels outlined."
                                        : "All labelled structures in space, with the target in green.",
            .file = file });
    }
    return pictures;
}

Json refused_document(const std::vector<planner::PlannedField>& fields)
{
    Json refused = Json::array();
    for (const planner::PlannedField& field : fields)
        if (!planner::is_measured(field))
            refused.push_back({ { "name", field.approach.name }, { "status", status_word(field.status) },
                { "attainable", planner::to_string(planner::Attainable::no) }, { "message", field.message } });
    return refused;
}

planner::Provenance provenance_now(const planner::Case& planned_case)
{
    return planner::provenance_of(planned_case, "retractor " RETRACTOR_VERSION, std::chrono::system_clock::now());
}

std::vector<std::string> keep_earlier_metrics(const std::filesystem::path& folder, const std::filesystem::path& staged,
    const std::vector<planner::PlannedField>& fields)
{
    std::ifstream in(folder / "metrics.json", std::ios::binary);
    const std::string content { std::istreambuf_iterator<char>(in), {} };
    const Json earlier = Json::parse(content, nullptr, false);
    if (!earlier.is_object() || !earlier.contains("approaches"))
        return {}; // no such file, or not written by this program
    const auto word = [](const Json& approach, const char* key) {
        const bool is_there = approach.is_object() && approach.contains(key) && approach.at(key).is_string();
        return is_there ? approach.at(key).get<std::string>() : std::string();
    };
    std::vector<std::string> lost;
    for (const Json& approach : earlier.at("approaches")) {
        const std::string name = word(approach, "name");
        const auto now = std::find_if(fields.begin(), fields.end(),
            [&](const planner::PlannedField& field) { return field.approach.name == name; });
        if (now == fields.end() || (!is_answer(*now) && word(approach, "mechanics_status") == "converged"))
            lost.push_back(name);
    }
    if (!lost.empty())
        write_file_atomically(staged / "metrics-earlier.json", content);
    return lost;
}

Json write_metrics(const std::filesystem::path& folder, const planner::Provenance& computed, planner::Patient& patient,
    const std::vector<planner::PlannedField>& fields)
{
    std::vector<planner::FieldMetrics> metrics;
    for (const planner::PlannedField& field : fields)
        if (planner::is_measured(field))
            metrics.push_back(field.metrics);
    Json document;
    document["computed"] = planner::provenance_document(computed);
    document.update(planner::metrics_document(metrics));
    std::size_t written = 0;
    for (const planner::PlannedField& field : fields)
        if (planner::is_measured(field)) {
            Json& numbers = document["approaches"][written++];
            if (is_solved(field.metrics) && planner::why_not_to_use(field.metrics).empty())
                numbers["score"] = planner::score_of(
                    { .field = field.metrics,
                        .divided_bones = planner::divided_bones(*patient.labels(), field.approach) },
                    planner::default_weights())
                                       .points;
        }
    const Json refused = refused_document(fields);
    if (!refused.empty())
        document["refused"] = refused;
    write_file_atomically(folder / "metrics.json", document.dump(2) + "\n");
    std::string table = metrics_csv_header() + "\n";
    for (const Json& approach : document["approaches"])
        table += metrics_csv_row(approach) + "\n";
    write_file_atomically(folder / "metrics.csv", table);
    return document;
}

namespace {

    /// The plan of a neighbour: among the fields, or saved beside the case.
    planner::ReportNeighbour report_neighbour(const planner::Case& planned_case,
        const std::vector<planner::PlannedField>& fields, planner::NeighbourApproach neighbour)
    {
        planner::ReportNeighbour reported { .where = neighbour.where, .missing = neighbour.refused };
        if (!neighbour.approach)
            return reported;
        reported.missing = "not planned";
        const auto among = std::ranges::find_if(fields, [&](const planner::PlannedField& field) {
            return planner::is_measured(field) && field.approach.name == neighbour.approach->name
                && field.approach.incision == neighbour.approach->incision;
        });
        if (among != fields.end()) {
            reported.field = among->metrics;
        } else if (!planned_case.file().empty()) {
            planner::Case alone = planned_case;
            alone.approaches = { *neighbour.approach };
            if (const auto saved = planner::read_saved_plan(alone, neighbour.approach->name))
                reported.field = saved->field.metrics;
        }
        return reported;
    }

    /// The approach of a field as the case has it. A plan adds strokes of the division and places of bearing.
    const planner::Approach& asked_approach(const planner::Case& planned_case, const planner::PlannedField& field)
    {
        const auto asked = std::ranges::find(planned_case.approaches, field.approach.name, &planner::Approach::name);
        return asked != planned_case.approaches.end() ? *asked : field.approach;
    }

    std::vector<planner::ReportNeighbour> report_neighbours(
        planner::Patient& patient, const std::vector<planner::PlannedField>& fields, const planner::PlannedField& field)
    {
        std::vector<planner::ReportNeighbour> reported;
        try {
            const planner::Approach& approach = asked_approach(patient.planned_case(), field);
            for (planner::NeighbourApproach& neighbour : planner::neighbours_of(patient, approach))
                reported.push_back(report_neighbour(patient.planned_case(), fields, std::move(neighbour)));
        } catch (const Error& error) { // the page is written without what cannot be read
            reported.push_back({ .where = "neighbours", .missing = error.what() });
        }
        return reported;
    }

    /// The names of the approaches for people, by their own names. Where two would have one name, their own stand
    /// behind it.
    std::map<std::string, std::string> spoken_names(const std::vector<planner::PlannedField>& fields)
    {
        std::map<std::string, std::string> names;
        for (const planner::PlannedField& field : fields) {
            const std::string spoken = planner::spoken_name(field.approach);
            const bool shared = std::ranges::count(fields, spoken, [](const planner::PlannedField& other) {
                return planner::spoken_name(other.approach);
            }) > 1;
            names[field.approach.name] = shared ? spoken + " (" + field.approach.name + ")" : spoken;
        }
        return names;
    }

    /// Adds interactive views while the page stays small enough to be sent by mail.
    void add_views(planner::Report& report, planner::Patient& patient, const std::vector<planner::PlannedField>& fields,
        const std::map<std::string, std::string>& names)
    {
        constexpr std::size_t kMostBytes = 14'000'000; // of all views; the pictures of as many fields take as much
        std::size_t bytes = 0;
        std::vector<std::string> without;
        for (const planner::PlannedField& field : fields) {
            if (!planner::is_measured(field))
                continue;
            std::string scene = field_view(patient, field);
            if (bytes + scene.size() > kMostBytes) {
                without.push_back(names.at(field.approach.name));
                continue;
            }
            bytes += scene.size();
            report.views.push_back({ .approach = names.at(field.approach.name), .scene = std::move(scene) });
        }
        report.viewer = field_viewer();
        if (!without.empty())
            report.limits.push_back("The page would become too large with interactive views of all fields. These have "
                                    "pictures only: "
                + joined(without) + ".");
    }

} // namespace

void write_field_report(const std::filesystem::path& file, planner::Patient& patient,
    const planner::Provenance& computed, const std::vector<planner::PlannedField>& fields,
    const std::vector<planner::ReportPicture>& pictures)
{
    planner::Report report;
    report.title = "Planned surgical fields";
    report.computed = computed;
    const auto labels = patient.labels();
    report.patient = formatted("Labels of %d x %d x %d voxels at %.2f x %.2f x %.2f mm, patient frame LPS.",
        labels->grid.size[0], labels->grid.size[1], labels->grid.size[2], labels->grid.spacing.x(),
        labels->grid.spacing.y(), labels->grid.spacing.z());
    const std::map<std::string, std::string> names = spoken_names(fields);
    for (const planner::PlannedField& field : fields)
        if (planner::is_measured(field)) {
            report.fields.push_back(field.metrics);
            report.fields.back().name = names.at(field.approach.name);
            report.divided_bones.push_back(planner::divided_bones(*labels, field.approach));
            report.landmarks.push_back(planner::theatre_sentences(patient, field.approach));
            report.neighbours.push_back(report_neighbours(patient, fields, field));
        }
    report.pictures = pictures;
    for (planner::ReportPicture& picture : report.pictures)
        if (const auto name = names.find(picture.approach); name != names.end())
            picture.approach = name->second;
    try {
        report.chosen = planner::holding_choice(patient.planned_case());
    } catch (const Error& error) { // the fields are planned and drawn: a damaged record must not hold them back
        report.chosen = std::string("The team's choice cannot be read: ") + error.what();
    }
    for (const planner::PlannedField& field : fields)
        if (!planner::is_measured(field))
            report.refused.push_back(names.at(field.approach.name)
                + " could not be planned: " + std::string(status_word(field.status)) + ". " + field.message);
    report.limits = report_limits(
        !patient.planned_case().supports.labels.empty(), patient.planned_case(), stiffness_limit(fields));
    add_views(report, patient, fields, names);
    planner::write_report(file, report);
}

namespace {

    /// A folder of this process, removed at the end.
    struct OwnFolder {
        std::filesystem::path path;
        OwnFolder()
        {
            std::string name = (std::filesystem::temp_directory_path() / "retractor-XXXXXX").string();
            if (mkdtemp(name.data()) == nullptr)
                throw IoError("a folder for pictures cannot be made: " + std::string(std::strerror(errno)), name);
            path = name;
        }
        OwnFolder(const OwnFolder&) = delete;
        OwnFolder& operator=(const OwnFolder&) = delete;
        ~OwnFolder()
        {
            std::error_code ignored;
            std::filesystem::remove_all(path, ignored);
        }
    };

} // namespace

bool write_report_page(const std::filesystem::path& file, planner::Patient& patient,
    std::vector<planner::PlannedField>& fields, const FieldViews& views, const Job& job)
{
    const OwnFolder folder;
    const std::vector<planner::ReportPicture> pictures = render_fields(folder.path, patient, fields, views, job);
    if (job.cancelled())
        return false;
    job.report("report", 0.0);
    write_field_report(file, patient, provenance_now(patient.planned_case()), fields, pictures);
    return true;
}

} // namespace retractor::ui
