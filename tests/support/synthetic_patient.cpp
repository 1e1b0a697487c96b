#include "tests/support/synthetic_patient.h"

#include "tests/planner/session/layered_wall.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/case/patient.h"
#include "planner/session/saved_cuts.h"
#include "ui/plan_scene/plan_scene.h"
#include "ui/scene/tissue_colors.h"

#include <chrono>
#include <optional>
#include <thread>

namespace retractor::test_support {

namespace {

    constexpr double kHalfWidthMm = 60.0;
    constexpr double kTargetDepthMm = 50.0;

    /// A box with its front at y = 0; the front is missing when `opened`.
    std::shared_ptr<const TriMesh> box(bool opened)
    {
        auto mesh = std::make_shared<TriMesh>();
        mesh->vertices.resize(8, 3);
        for (int i = 0; i < 8; ++i)
            mesh->vertices.row(i) = Eigen::RowVector3d((i & 1) != 0 ? kHalfWidthMm : -kHalfWidthMm,
                (i & 2) != 0 ? 90.0 : 0.0, (i & 4) != 0 ? kHalfWidthMm : -kHalfWidthMm);
        mesh->triangles = { { 2, 6, 7 }, { 2, 7, 3 }, { 0, 4, 6 }, { 0, 6, 2 }, { 1, 3, 7 }, { 1, 7, 5 }, { 0, 2, 3 },
            { 0, 3, 1 }, { 4, 5, 7 }, { 4, 7, 6 } };
        if (!opened)
            mesh->triangles.insert(mesh->triangles.end(), { { 0, 1, 5 }, { 0, 5, 4 } });
        return mesh;
    }

    std::shared_ptr<const mesh::Volume> ct()
    {
        auto image = std::make_shared<mesh::Volume>();
        image->grid.size = { 32, 32, 32 };
        image->grid.spacing = Vec3(4.0, 3.0, 4.0);
        image->grid.origin = Vec3(-62.0, 0.0, -62.0);
        image->voxels.assign(image->grid.voxel_count(), -1000);
        for (int k = 4; k < 28; ++k)
            for (int j = 12; j < 28; ++j)
                for (int i = 4; i < 28; ++i)
                    image->voxels[image->grid.offset(i, j, k)] = static_cast<std::int16_t>(i < 8 ? 700 : 60);
        return image;
    }

    ui::Scene patient_scene(const planner::Approach& approach, bool opened)
    {
        ui::Scene scene;
        scene.title = approach.name;
        ui::SurfaceItem skin;
        skin.name = ui::kBodyName;
        skin.mesh = box(opened);
        skin.look = ui::tissue_look("skin");
        skin.smooth = false;
        ui::SurfaceItem target;
        target.name = "target";
        target.mesh = std::make_shared<const TriMesh>(planner::sphere_surface({ 0.0, kTargetDepthMm, 0.0 }, 20.0));
        target.look.color = ui::target_color();
        target.target = true;
        scene.surfaces = { skin, target };
        ui::LineItem line;
        line.name = "incision";
        line.points = approach.incision;
        line.color = ui::incision_color();
        line.on_top = true;
        scene.lines.push_back(line);
        scene.camera
            = ui::camera_for_box({ { -kHalfWidthMm, 0.0, -kHalfWidthMm }, { kHalfWidthMm, 90.0, kHalfWidthMm } },
                { 0.4, 1.0, -0.3 }, Vec3::UnitZ());
        return scene;
    }

    /// The blade's way under the front of the box.
    std::shared_ptr<const TriMesh> cut_under(const planner::Approach& approach)
    {
        auto mesh = std::make_shared<TriMesh>();
        mesh->vertices.resize(4, 3);
        for (int n = 0; n < 2; ++n) {
            const Vec3 point = n == 0 ? approach.incision.front() : approach.incision.back();
            mesh->vertices.row(2 * n) = point.transpose();
            mesh->vertices.row(2 * n + 1) = (point + approach.depth_mm * approach.directions.front()).transpose();
        }
        mesh->triangles = { { 0, 1, 2 }, { 2, 1, 3 } };
        return mesh;
    }

    /// The front of the box under a ray.
    std::optional<Vec3> front_under(const Vec3& from, const Vec3& direction)
    {
        if (!(direction.y() > 0.0) || from.y() > 0.0)
            return std::nullopt;
        const Vec3 place = from - from.y() / direction.y() * direction;
        return place.cwiseAbs().maxCoeff() <= kHalfWidthMm ? std::optional(place) : std::nullopt;
    }

    ui::FieldPictures opened_field(const planner::Approach& approach)
    {
        ui::FieldPictures field;
        field.metrics.name = approach.name;
        field.metrics.target = "target";
        field.metrics.seen_best_eye = 0.456;
        field.metrics.opening_area_mm2 = 3200.0;
        field.metrics.hook_force_N = 38.0;
        field.metrics.mechanics_status = "converged";
        field.surgeon = patient_scene(approach, true);
        field.surgeon.camera = ui::surgeon_camera(approach, Vec3::UnitZ());
        field.overview = patient_scene(approach, true);
        ui::VolumeItem volume;
        volume.name = "CT";
        volume.image = ct();
        field.overview.volumes.push_back(volume);
        field.maps[ui::FieldMapKind::strain].legend = { { "largest elongation", "" } };
        field.maps[ui::FieldMapKind::reach].legend = { { "reach through the wound", "" } };
        return field;
    }

    /// The target on the grid of the CT.
    std::shared_ptr<const mesh::LabelVolume> labels()
    {
        auto made = std::make_shared<mesh::LabelVolume>();
        made->grid = ct()->grid;
        made->table = synthetic_case().label_table;
        for (int k = 0; k < made->grid.size[2]; ++k)
            for (int j = 0; j < made->grid.size[1]; ++j)
                for (int i = 0; i < made->grid.size[0]; ++i)
                    made->voxels.push_back(
                        (made->grid.world(Vec3(i, j, k)) - Vec3(0.0, kTargetDepthMm, 0.0)).norm() <= 20.0 ? 2 : 0);
        return made;
    }

    std::vector<ui::Scene> slices()
    {
        std::vector<ui::Scene> slices;
        for (const ui::SlicePlane plane :
            { ui::SlicePlane::axial, ui::SlicePlane::coronal, ui::SlicePlane::sagittal }) {
            ui::Scene scene;
            ui::SliceItem slice;
            slice.image = ct();
            slice.plane = plane;
            slice.point = { 0.0, kTargetDepthMm, 0.0 };
            slice.labels = labels();
            scene.slices.push_back(slice);
            scene.camera = ui::camera_for_slice(slice, 1.0);
            slices.push_back(scene);
        }
        return slices;
    }

    /// Across the middle of the incision, with the blade.
    std::vector<ui::Scene> incision_slices(const planner::Approach& approach)
    {
        const Vec3 middle(approach.incision.front().x(), 0.0, 0.0);
        ui::Scene scene;
        scene.title = "across its middle";
        scene.slices.push_back({ .image = ct(),
            .point = middle + Vec3(0.0, 30.0, 0.0),
            .oblique = ui::ObliqueSlice { .up = -Vec3::UnitY(), .half_width_mm = 60.0, .half_height_mm = 45.0 } });
        scene.lines.push_back({ .name = std::string(ui::kCutName),
            .points = { middle, middle + approach.depth_mm * approach.directions.front() },
            .on_top = true });
        scene.camera = ui::camera_for_slice(scene.slices.front(), 1.0);
        return { scene };
    }

} // namespace

planner::Case synthetic_case()
{
    planner::Case planned_case;
    planned_case.folder = "synthetic";
    planned_case.label_table
        = { { 1, "skin", "skin", mesh::Role::wall }, { 2, "target", "vessel", mesh::Role::target } };
    for (const char* name : { "median", "lateral", "broken" }) {
        planner::Approach approach;
        approach.name = name;
        approach.template_name = "points";
        const double x = approach.name == "lateral" ? 30.0 : 0.0;
        approach.incision = { { x, 0.0, 40.0 }, { x, 0.0, -40.0 } };
        approach.directions.assign(2, Vec3::UnitY());
        approach.depth_mm = 20.0;
        approach.target.label = "target";
        planned_case.approaches.push_back(approach);
    }
    return planned_case;
}

namespace {

    /// Writes the text once the control lets it. @return false: cancelled
    bool write_held(
        const SyntheticControl& control, const std::filesystem::path& file, const std::string& text, const Job& job)
    {
        job.report("movie", 0.5);
        while (control.hold_files && !job.cancelled())
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (job.cancelled())
            return false;
        write_file_atomically(file, text);
        return true;
    }

} // namespace

ui::PlanningBackend synthetic_backend(const std::shared_ptr<SyntheticControl>& control)
{
    ui::PlanningBackend backend;
    backend.closed_pictures = [control](const planner::Approach& approach, const Job&) {
        ++control->closed_made;
        return ui::ClosedPictures { .patient = patient_scene(approach, false),
            .slices = slices(),
            .incision_slices = control->incision_slices ? incision_slices(approach) : std::vector<ui::Scene> {},
            .cut = ui::SurfaceItem { .name = "planned cut", .mesh = cut_under(approach) },
            .label_names = {},
            .skin_under = front_under };
    };
    backend.patient_pictures = [control](const Job&) {
        ++control->closed_made;
        planner::Approach none;
        none.name = "patient";
        ui::ClosedPictures pictures { .patient = patient_scene(none, false), .slices = slices(), .label_names = {} };
        pictures.patient.lines.clear();
        pictures.skin_under = front_under;
        return pictures;
    };
    backend.anatomy = [](const Job&) {
        return std::vector<ui::SurfaceItem> { { .name = "heart",
            .mesh = std::make_shared<const TriMesh>(planner::sphere_surface({ 40.0, kTargetDepthMm, 0.0 }, 15.0)),
            .look = ui::organ_look("heart") } };
    };
    backend.search = [control](const planner::Case&, const planner::SearchRequest& request, const Job& job) {
        ui::FoundProposals found;
        job.report("solve", 0.5);
        while (control->hold && !job.cancelled())
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (job.cancelled()) {
            found.drafts.status = planner::SearchStatus::cancelled;
            return found;
        }
        if (!request.limits.saw)
            throw InputError("none of 7 incisions is a proposal");
        for (const char* name : { "left_space_4_110mm", "sternum_180mm" }) {
            planner::PlannedProposal planned { .candidate
                = { .field = opened_field(synthetic_case().approaches.front()).metrics, .divided_bones = {} } };
            planned.proposal.approach = synthetic_case().approaches.front();
            planned.proposal.approach.name = name;
            planned.proposal.approach.target = request.target;
            planned.proposal.words = readable(name);
            found.drafts.best_first.push_back(planned);
        }
        found.drafts.failed = { "left space 7: shows 2 % of what could be seen" };
        found.map = { .width = 2, .height = 1, .rgb = { 255, 0, 0, 0, 255, 0 } };
        return found;
    };
    backend.make_approach = [](const planner::Case& present, const planner::ApproachDraft& draft) {
        if (draft.template_name == "median")
            throw InputError("there is no sternum", "labels");
        planner::Approach approach;
        approach.name = planner::free_approach_name(present, draft.name.empty() ? "drawn" : draft.name);
        approach.template_name = draft.template_name.empty() ? "points" : draft.template_name;
        approach.incision
            = draft.points.empty() ? std::vector<Vec3> { { -20.0, 0.0, 0.0 }, { 20.0, 0.0, 0.0 } } : draft.points;
        approach.directions.assign(approach.incision.size(), Vec3::UnitY());
        approach.depth_mm = 20.0;
        approach.target.label = draft.target;
        return approach;
    };
    backend.move_incision = [](const planner::Approach& approach, const std::vector<Vec3>& points) {
        planner::Approach moved = approach;
        moved.incision = points;
        moved.directions.assign(points.size(), Vec3::UnitY());
        return moved;
    };
    backend.change_blade = [](const planner::Approach& approach, double depth_mm, const Vec3& inward) {
        if (depth_mm < 5.0)
            throw InputError("the blade goes 5 to 250 mm deep");
        planner::Approach changed = approach;
        changed.depth_mm = depth_mm;
        changed.directions.assign(approach.incision.size(), inward.normalized());
        return changed;
    };
    backend.neighbours = [](const planner::Approach& approach) {
        planner::NeighbourApproach higher { .where = "one space higher", .approach = approach },
            lower { .where = "one space lower", .refused = "the lowest" };
        higher.approach->name = approach.name + "_space_3";
        return std::vector { higher, lower };
    };
    backend.surgery_input = [control](const planner::Approach& approach, const Job& job) -> ui::SurgeryInput {
        job.report("mesh", 0.5);
        ++control->setups_made;
        if (approach.name == "broken")
            throw InputError("there is no wall to cut", "approach broken");
        ui::SurgeryInput input { .setup = planner::layered_wall({ -kHalfWidthMm, 0.0, -kHalfWidthMm }),
            .surroundings = {} };
        input.setup.approach.incision = { { -30.0, 0.0, 0.0 }, { 30.0, 0.0, 0.0 } };
        input.setup.approach.directions.assign(2, Vec3::UnitY());
        input.setup.approach.depth_mm = 15.0;
        if (!control->cuts_folder.empty())
            input.setup.journal = planner::cuts_journal(control->cuts_folder / "case.json", approach.name);
        input.look = [control](const TriMesh& wall, const TriMesh& around, const Job&) {
            if (!around.labels.empty() && around.labels.size() != around.triangles.size())
                throw InputError("what hides has labels for a part of its triangles");
            control->hiding_triangles = around.triangles.size();
            // Wider wounds show more: by the surface's lips alone.
            return planner::SeenNow {
                .seen_fraction = wall.triangles.empty() ? 0.0 : 0.25, .sampling_error = 0.02, .off_straight_deg = 12.0
            };
        };
        input.surroundings.title = approach.name + ": by hand";
        input.surroundings.camera = { .eye = { 60.0, -400.0, 60.0 }, .aim = { 60.0, 0.0, 60.0 }, .up = Vec3::UnitZ() };
        return input;
    };
    backend.plan = [control](const planner::Approach& approach, const Job& job) -> ui::PlanOutcome {
        job.report("cut", 0.5);
        while (control->hold && !job.cancelled())
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        if (job.cancelled())
            return { .status = ui::PlanOutcome::Status::cancelled, .message = {}, .field = {} };
        ++control->plans_made;
        if (approach.name == "broken")
            throw InputError("the depth is negative", "/approaches/2/depth_mm");
        return { .status = ui::PlanOutcome::Status::planned, .message = {}, .field = opened_field(approach) };
    };
    backend.draft = [plan = backend.plan](const planner::Approach& approach, const Job& job) {
        ui::PlanOutcome outcome = plan(approach, job);
        outcome.field.metrics.solution.draft = true;
        return outcome;
    };
    backend.saved_plan = [control](const planner::Approach& approach) -> std::optional<ui::FieldPictures> {
        if (!control->saved_plans.contains(approach.name))
            return std::nullopt;
        if (approach.name == "broken")
            throw InputError("this saved plan is damaged: plan the approach again", "plans/broken.plan");
        return opened_field(approach);
    };
    backend.write_movie = [control](const ui::PlanningBackend::Shown& shown, const std::filesystem::path& file,
                              const std::filesystem::path& pictures, const Job& job) {
        return write_held(*control, file, shown.planned.front() + (pictures.empty() ? "" : " with pictures"), job);
    };
    backend.write_report = [control](const ui::PlanningBackend::Shown&, const std::filesystem::path& file,
                               const Job& job) { return write_held(*control, file, "report", job); };
    backend.palpate_through = [control](const planner::Approach& approach, const Job& job) {
        while (control->hold && !job.cancelled())
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        if (approach.name == "lateral")
            throw InputError("its plan is not saved beside the case: plan it again", "approach " + approach.name);
        ui::ShownWound wound;
        wound.scene.title = approach.name;
        return wound;
    };
    return backend;
}

} // namespace retractor::test_support
