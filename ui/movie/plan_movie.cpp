#include "ui/movie/plan_movie.h"

#include "mesh/base/assert.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/approach/divided_bones.h"
#include "planner/decision/presentation.h"
#include "planner/plan/wound_view.h"
#include "ui/movie/video_file.h"
#include "ui/plan_scene/field_map.h"
#include "ui/plan_scene/plan_scene.h"
#include "ui/plan_scene/planned_cut.h"
#include "ui/plan_scene/vessel_surfaces.h"
#include "ui/scene/arrange_scenes.h"
#include "ui/scene/camera_motion.h"
#include "ui/scene/scene_language.h"
#include "ui/scene/vtk/identifier_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr double kTurnDeg = 12.0; ///< to each side, round the closed patient
    constexpr double kOpeningS = 2.0, kFlightS = 2.0;
    /// The wound opens in fewer poses than frames: each pose is a new surface.
    constexpr int kFramesPerPose = 2;
    /// Letters in a line of the words under the title, at a picture as wide as high.
    constexpr double kLettersPerLine = 66.0;
    constexpr double kGlow = 0.3; ///< opacity of the target that shines through the closed skin

    /// Vertices between two poses of a surface with the same triangles.
    std::shared_ptr<const TriMesh> pose(const TriMesh& at_rest, const TriMesh& opened, double share)
    {
        RETRACTOR_ASSERT(at_rest.vertices.rows() == opened.vertices.rows());
        auto between = std::make_shared<TriMesh>(opened);
        between->vertices = (1.0 - share) * at_rest.vertices + share * opened.vertices;
        return between;
    }

    const planner::PlannedField* field_of(
        const std::vector<planner::PlannedField>& fields, const planner::Approach& approach)
    {
        for (const planner::PlannedField& field : fields)
            if (field.approach.name == approach.name && planner::is_measured(field))
                return &field;
        return nullptr;
    }

    class Player {
    public:
        Player(planner::Patient& patient, const MovieSettings& settings, const TextLanguage& language,
            OffscreenRenderer& renderer, const MovieSink& sink, const Job& job)
            : patient_(patient)
            , settings_(settings)
            , language_(language)
            , renderer_(renderer)
            , sink_(sink)
            , job_(job)
        {
        }

        void expect(int steps) { steps_ = steps; }

        /// @return false: cancelled
        bool play(const planner::PresentationStep& step, const planner::Approach* approach,
            const planner::PlannedField* field, const std::vector<const planner::PlannedField*>& compared)
        {
            switch (step.view) {
            case planner::PresentedView::patient:
                hold(step, { patient_scene(patient_) });
                break;
            case planner::PresentedView::incision:
                turn(step, closed_scene(*approach));
                break;
            case planner::PresentedView::blade:
                hold(step, incision_slice_scenes(patient_, *approach));
                break;
            case planner::PresentedView::cut:
                hold(step, { cut_scene(*approach) });
                break;
            case planner::PresentedView::opened:
                open(step, *field);
                break;
            case planner::PresentedView::seen:
                fly(step, *field);
                break;
            case planner::PresentedView::reached:
                hold(step, { reached_scene(*field) });
                break;
            case planner::PresentedView::kept: {
                Scene scene = step.kept->opened ? overview_scene(patient_, *field) : closed_scene(*approach);
                scene.legend = estimated_lines(std::move(scene.legend));
                scene.camera = camera_of(*step.kept);
                hold(step, { std::move(scene) });
                break;
            }
            case planner::PresentedView::comparison: {
                std::vector<Scene> scenes;
                for (const planner::PlannedField* each : compared)
                    scenes.push_back(surgeon_scene(patient_, *each));
                hold(step, std::move(scenes));
                break;
            }
            }
            ++done_;
            return !job_.cancelled();
        }

    private:
        int frames(double seconds) const
        {
            return std::max(1, static_cast<int>(std::lround(seconds * settings_.frames_per_second)));
        }
        void report(double share) const { job_.report("movie", (done_ + share) / std::max(1, steps_)); }

        /// Of several scenes side by side each keeps its title, and the words stand on the first.
        void show(const planner::PresentationStep& step, std::vector<Scene> scenes)
        {
            const bool alone = scenes.size() == 1;
            const double width = alone ? settings_.width : 0.5 * settings_.width;
            Scene& first = scenes.front();
            if (alone)
                first.title = step.title;
            for (Scene& scene : scenes)
                say_texts(scene, language_);
            first.notes = in_lines(
                said(language_, step.text), static_cast<std::size_t>(kLettersPerLine * width / settings_.height));
            renderer_.show({ .width = settings_.width,
                .height = settings_.height,
                .viewports = arrange_scenes(scenes, settings_.width, settings_.height) });
        }

        void hold(const planner::PresentationStep& step, std::vector<Scene> scenes)
        {
            report(0.0);
            const std::vector<Viewport> places = arrange_scenes(scenes, settings_.width, settings_.height);
            std::vector<Camera> cameras;
            for (const Viewport& place : places)
                cameras.push_back(place.scene.camera);
            show(step, std::move(scenes));
            sink_(renderer_.draw(cameras), frames(settings_.hold_s));
        }

        /// From the surgeon's eye, the target in the colours of what reaches it.
        Scene reached_scene(const planner::PlannedField& field)
        {
            Scene scene = surgeon_scene(patient_, field);
            scene.legend = estimated_lines(std::move(scene.legend));
            if (const auto map = field_map(patient_, field, FieldMapKind::reach))
                scene = with_map(std::move(scene), *map);
            return scene;
        }

        Scene cut_scene(const planner::Approach& approach)
        {
            if (!anatomy_)
                anatomy_ = anatomy_surfaces(patient_, job_);
            return planned_cut_scene(patient_, approach, *anatomy_);
        }

        /// The closed patient, opaque, because a translucent body takes ten times as long to draw.
        Scene closed_scene(const planner::Approach& approach)
        {
            Scene scene = planning_scene(patient_, approach);
            for (SurfaceItem& item : scene.surfaces) {
                item.on_top = item.target;
                item.opacity = item.target ? kGlow : 1.0;
                item.target = false;
            }
            return scene;
        }

        void turn(const planner::PresentationStep& step, Scene scene)
        {
            const Camera middle = scene.camera;
            show(step, { std::move(scene) });
            const int count = frames(settings_.hold_s);
            for (int n = 0; n < count && !job_.cancelled(); ++n) {
                report(static_cast<double>(n) / count);
                const double angle = 2.0 * std::numbers::pi * n / count; // back where it began
                sink_(renderer_.draw({ turned_round_aim(middle, kTurnDeg * std::sin(angle)) }), 1);
            }
        }

        /// The wound on its way open: 0 closed, 1 open.
        Scene opening_scene(const planner::PlannedField& field, const Scene& opened, double share)
        {
            Scene scene = opened;
            std::vector<planner::HookShape> hooks
                = planner::placed_hooks(field, share * field.opening.displacement, field.geometry);
            for (SurfaceItem& item : scene.surfaces) {
                if (item.name == kWallName)
                    item.mesh = pose(wall_at_rest_, *item.mesh, share);
                else if (item.name == kBeyondName)
                    item.mesh = pose(beyond_at_rest_, *item.mesh, share);
                else
                    for (const planner::HookShape& hook : hooks)
                        if (item.name == hook.name)
                            item.mesh = std::make_shared<const TriMesh>(planner::hook_mesh(hook));
            }
            return scene;
        }

        void open(const planner::PresentationStep& step, const planner::PlannedField& field)
        {
            report(0.0);
            Scene opened = overview_scene(patient_, field);
            remove_vessels(opened); // they would stand still while the wound opens
            opened.legend = estimated_lines(std::move(opened.legend));
            wall_at_rest_ = drawn_wall(patient_, field, Points::Zero(field.wall.vertices.rows(), 3));
            if (!field.remaining_wall.triangles.empty())
                beyond_at_rest_ = remaining_wall_at_rest(patient_, field);
            const Camera camera = opened.camera;
            const int poses = std::max(1, frames(kOpeningS) / kFramesPerPose);
            for (int n = 0; n <= poses && !job_.cancelled(); ++n) {
                report(static_cast<double>(n) / (poses + 1));
                show(step, { opening_scene(field, opened, eased(static_cast<double>(n) / poses)) });
                sink_(renderer_.draw({ camera }), n == poses ? frames(settings_.hold_s) : kFramesPerPose);
            }
        }

        void fly(const planner::PresentationStep& step, const planner::PlannedField& field)
        {
            Scene seen = surgeon_scene(patient_, field);
            const Camera last = seen.camera, first = overview_scene(patient_, field).camera;
            seen.legend = estimated_lines(std::move(seen.legend)); // the text under the title has the numbers
            show(step, { seen });
            const int count = frames(kFlightS);
            for (int n = 0; n < count && !job_.cancelled(); ++n) {
                report(static_cast<double>(n) / (count + 1));
                sink_(renderer_.draw({ camera_between(first, last, eased(static_cast<double>(n) / count)) }), 1);
            }
            if (job_.cancelled())
                return;
            const IdentifierPicture structures = identifier_picture(
                renderer_, seen, label_names(patient_.planned_case()), settings_.width, settings_.height);
            add_names(seen, structures);
            show(step, { std::move(seen) });
            sink_(renderer_.draw({ last }), frames(settings_.hold_s));
        }

        planner::Patient& patient_;
        const MovieSettings& settings_;
        const TextLanguage& language_;
        OffscreenRenderer& renderer_;
        const MovieSink& sink_;
        const Job& job_;
        TriMesh wall_at_rest_, beyond_at_rest_; ///< of the field that opens
        std::optional<std::vector<SurfaceItem>> anatomy_; ///< made once
        int done_ = 0, steps_ = 1;
    };

} // namespace

void check_movie(const MovieSettings& settings)
{
    if (settings.width < 2 || settings.height < 2 || settings.width % 2 != 0 || settings.height % 2 != 0)
        throw InputError(
            formatted("a movie needs an even width and an even height, not %d x %d", settings.width, settings.height));
    if (!std::isfinite(settings.hold_s) || settings.hold_s <= 0.0 || settings.frames_per_second < 1)
        throw InputError("a movie needs a time for each step, and at least one frame per second");
}

bool play_plans(planner::Patient& patient, const MovieContent& content, const MovieSettings& settings,
    OffscreenRenderer& renderer, const MovieSink& sink, const Job& job)
{
    check_movie(settings);
    const planner::Case& planned_case = content.planned_case;
    const std::vector<planner::PlannedField>& fields = content.fields;
    std::vector<planner::PresentedApproach> known;
    for (const planner::Approach& approach : planned_case.approaches) {
        const planner::PlannedField* field = field_of(fields, approach);
        known.push_back({ .field = field == nullptr ? nullptr : &field->metrics,
            .has_slices = patient.has_ct(),
            .divided_bones
            = field == nullptr ? std::vector<std::string>() : planner::divided_bones(*patient.labels(), approach) });
    }
    const std::vector<planner::PresentationStep> steps
        = planner::presentation_of(planned_case, known, content.decisions);
    Player player(patient, settings, content.language, renderer, sink, job);
    player.expect(static_cast<int>(steps.size()));
    for (const planner::PresentationStep& step : steps) {
        const planner::Approach* approach = step.approach ? &planned_case.approaches.at(*step.approach) : nullptr;
        std::vector<const planner::PlannedField*> compared;
        for (const std::size_t index : step.compared)
            compared.push_back(field_of(fields, planned_case.approaches.at(index)));
        if (!player.play(step, approach, approach == nullptr ? nullptr : field_of(fields, *approach), compared))
            return false;
    }
    return true;
}

namespace {

    namespace fs = std::filesystem;

    std::string frame_name(int number) { return formatted("%05d.png", number); }

    /// @throws InputError when the folder holds anything but frames
    void check_frames_folder(const fs::path& folder)
    {
        if (!fs::exists(folder))
            return;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
            const std::string name = entry.path().filename().string();
            const bool is_frame = name.size() == frame_name(0).size() && name.ends_with(".png")
                && std::all_of(name.begin(), name.end() - 4, [](char c) { return c >= '0' && c <= '9'; });
            if (!is_frame)
                throw InputError("the folder for frames holds other files: " + name, folder.string());
        }
    }

    /// A new folder beside the one for frames, removed unless it takes its place.
    class NewFrames {
    public:
        explicit NewFrames(fs::path folder)
            : folder_(std::move(folder))
            , part_(folder_.string() + ".part")
        {
            if (folder_.empty())
                return;
            check_frames_folder(folder_);
            fs::remove_all(part_);
            fs::create_directories(part_);
        }
        ~NewFrames()
        {
            std::error_code ignored;
            if (!folder_.empty())
                fs::remove_all(part_, ignored);
        }
        NewFrames(const NewFrames&) = delete;
        NewFrames& operator=(const NewFrames&) = delete;

        void add(const Image& picture, int frames)
        {
            if (folder_.empty())
                return;
            const fs::path first = part_ / frame_name(number_ + 1);
            write_png(first, picture);
            for (int n = 2; n <= frames; ++n)
                fs::copy_file(first, part_ / frame_name(number_ + n));
            number_ += frames;
        }
        void keep()
        {
            if (folder_.empty())
                return;
            fs::remove_all(folder_);
            fs::rename(part_, folder_);
        }

    private:
        fs::path folder_, part_;
        int number_ = 0;
    };

} // namespace

bool write_movie(const std::filesystem::path& path, const std::filesystem::path& pictures, planner::Patient& patient,
    const MovieContent& content, const MovieSettings& settings, std::unique_ptr<OffscreenContext> context,
    const Job& job)
{
    check_movie(settings);
    struct Cancelled { }; // ends the writing of the file, which removes what was written
    try {
        NewFrames frames(pictures);
        OffscreenRenderer renderer(std::move(context), job);
        write_file_atomically(path, [&](const std::filesystem::path& temporary) {
            VideoFile video(temporary, settings.width, settings.height, settings.frames_per_second);
            const MovieSink sink = [&](const Image& picture, int count) {
                video.add(picture, count);
                frames.add(picture, count);
            };
            if (!play_plans(patient, content, settings, renderer, sink, job))
                throw Cancelled {};
            video.finish();
        });
        frames.keep();
    } catch (const Cancelled&) {
        return false;
    } catch (const std::filesystem::filesystem_error& error) {
        throw IoError(error.code().message(), error.path1().string());
    }
    return true;
}

} // namespace retractor::ui
