#include "ui/cli/palpation/palpate_pictures.h"

#include "haptics/recording/csv_field.h"
#include "mesh/base/text_format.h"
#include "ui/cli/framework/ball_mesh.h"
#include "ui/scene/tissue_colors.h"
#include "ui/scene/vtk/render.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace retractor::ui::cli {

namespace {

    ChartPanel panel_of(const std::vector<PressLog>& logs, const char* title, const char* unit, auto value)
    {
        ChartPanel panel { title, {}, {}, unit };
        for (const PressLog& log : logs)
            for (const FingerLog& finger : log.fingers)
                panel.series.push_back({ finger.site, finger.time, value(finger), false });
        return panel;
    }

    /// A mesh of the triangles of one label of the surface, or of all.
    std::shared_ptr<TriMesh> part_of(const TriMesh& surface, const Points& deformed, std::optional<Label> label)
    {
        auto part = std::make_shared<TriMesh>();
        part->vertices = deformed;
        for (std::size_t t = 0; t < surface.triangles.size(); ++t)
            if (!label || surface.labels[t] == *label)
                part->triangles.push_back(surface.triangles[t]);
        return part;
    }

    Look look_of(const std::string& organ)
    {
        Look look = organ_look(organ);
        look.texture = 0.0;
        return look;
    }

    void add_body(
        Scene& view, const PressLog& log, const datasets::PalpationScene& scene, const haptics::TissueResponse& tissue)
    {
        auto surface = std::make_shared<TriMesh>(tissue.surface());
        surface->vertices = log.deformed;
        SurfaceItem item { .name = "tissue", .mesh = surface };
        item.look = { .color = { 0.82, 0.36, 0.32 }, .finish = Finish::wet };
        if (scene.organs.empty() && tissue.name() == "fem")
            for (const Label label : surface->labels)
                item.look_of_label[label]
                    = { .color = label == 2 ? Color { 0.93, 0.82, 0.50 } : Color { 0.82, 0.36, 0.32 },
                          .finish = Finish::wet };
        else
            surface->labels.clear();
        item.show_edges = true;
        item.smooth = false;
        view.surfaces.push_back(item);
    }

    void add_organs(Scene& view, const PressLog& log, const datasets::PalpationScene& scene,
        const haptics::TissueResponse& tissue, bool with_skin)
    {
        for (std::size_t o = 0; o < scene.organs.size(); ++o) {
            const std::string& name = scene.organs[o].name;
            if (!with_skin && (name == "skin" || name == "bowel"))
                continue;
            SurfaceItem item { .name = name,
                .mesh = part_of(tissue.surface(), log.deformed, planner::surface_label(scene, o, tissue)) };
            item.look = look_of(name);
            if (!item.mesh->triangles.empty())
                view.surfaces.push_back(item);
        }
    }

    /// Direction of the view: obliquely from outside, with the patient upright.
    Vec3 view_direction(const Press& press)
    {
        Vec3 out = Vec3::Zero();
        for (const datasets::TouchSite& site : press.sites)
            out += site.outward;
        out = out.norm() > 0.1 ? Vec3(out.normalized()) : press.sites[0].outward;
        Vec3 aside = out.cross(Vec3::UnitZ());
        if (aside.norm() < 0.3)
            aside = out.cross(Vec3::UnitX());
        const double frontal = press.sites.size() > 2 ? 2.0 : 0.7; // a whole hand is seen from the front
        return -(0.7 * aside.normalized() + frontal * out + 0.25 * Vec3::UnitZ()).normalized();
    }

    void add_hands(Scene& view, const PressLog& log, const Press& press, const std::array<haptics::HandModel, 2>& hands,
        const Vec3& look, const Vec3& up)
    {
        std::vector<haptics::ShownFinger> fingers;
        for (std::size_t f = 0; f < log.deepest.size(); ++f)
            fingers.push_back({ log.deepest[f].position, log.deepest[f].radius, press.sites[f].outward });
        const auto places = haptics::place_hands(hands, fingers, look, up);
        for (std::size_t h = 0; h < hands.size(); ++h) {
            if (!places[h])
                continue;
            auto mesh = std::make_shared<TriMesh>(hands[h].surface);
            mesh->vertices = (mesh->vertices * places[h]->turn.transpose()).rowwise() + places[h]->shift.transpose();
            view.surfaces.push_back({ .name = "hand",
                .mesh = std::move(mesh),
                .look = { .color = { 0.85, 0.70, 0.60 }, .finish = Finish::skin },
                .opacity = 0.45 });
        }
    }

    Scene condensed_state_of(const PressLog& log, const Press& press, const datasets::PalpationScene& scene,
        const haptics::TissueResponse& tissue, const std::string& note, bool with_skin,
        const std::array<haptics::HandModel, 2>* hands)
    {
        Scene view;
        view.title = log.name;
        view.notes.push_back(note);
        const bool by_organ = !scene.organs.empty()
            && tissue.surface().labels.size() == tissue.surface().triangles.size() && !tissue.surface().labels.empty();
        if (by_organ)
            add_organs(view, log, scene, tissue, with_skin);
        else
            add_body(view, log, scene, tissue);
        constexpr int kDivisions = 3;
        for (const haptics::Fingertip& tip : log.deepest)
            view.surfaces.push_back({ .name = "finger",
                .mesh = std::make_shared<TriMesh>(ball_mesh(tip.position, tip.radius, kDivisions)),
                .look = { .color = { 0.85, 0.70, 0.60 }, .finish = Finish::skin } });
        const Vec3 look = view_direction(press);
        const Vec3 up = std::abs(look.z()) > 0.9 ? Vec3(Vec3::UnitY()) : Vec3(Vec3::UnitZ());
        if (hands != nullptr)
            add_hands(view, log, press, *hands, look, up);
        view.camera = camera_for_box(*scene_bounds(view), look, up);
        return view;
    }

} // namespace

std::string palpation_csv(const std::vector<PressLog>& logs)
{
    std::string text = "press,finger,site,time_s,pressure_mmHg,x_mm,y_mm,z_mm,depth_mm,stiffness_N_per_mm,"
                       "force_x_N,force_y_N,force_z_N,force_N,hand_force_N\n";
    for (const PressLog& log : logs)
        for (std::size_t f = 0; f < log.fingers.size(); ++f) {
            const FingerLog& finger = log.fingers[f];
            const std::string who
                = haptics::csv_field(log.name) + "," + std::to_string(f) + "," + haptics::csv_field(finger.site);
            for (std::size_t i = 0; i < finger.time.size(); ++i) {
                const Vec3 &p = finger.position[i], &force = finger.force[i];
                text += who
                    + formatted(",%.6f,%.4f,%.5f,%.5f,%.5f,%.5f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f\n", finger.time[i],
                        finger.pressure_mmHg[i], p.x(), p.y(), p.z(), finger.depth[i], finger.stiffness[i], force.x(),
                        force.y(), force.z(), force.norm(), finger.hand_force[i]);
            }
        }
    return text;
}

void write_palpation_chart(
    const std::filesystem::path& file, const std::vector<PressLog>& logs, double force_gain, const Job& job)
{
    ChartPicture picture { .x_title = "time, s", .y_title = "", .panels = {}, .columns = 1 };
    picture.logarithmic_x = picture.logarithmic_y = false;
    picture.panel_width = 900;
    picture.panel_height = 300;
    const FingerLog& first = logs.front().fingers.front();
    if (!first.time.empty() && *std::max_element(first.pressure_mmHg.begin(), first.pressure_mmHg.end()) > 0.0)
        picture.panels.push_back(
            { "blood pressure", { { "pressure", first.time, first.pressure_mmHg, false } }, {}, "mmHg" });
    picture.panels.push_back(panel_of(logs, "force on the finger", "N", [](const FingerLog& finger) {
        std::vector<double> newtons;
        for (const Vec3& f : finger.force)
            newtons.push_back(f.norm());
        return newtons;
    }));
    if (force_gain != 1.0)
        picture.panels.back().title += formatted(" (force gain %.3g)", force_gain);
    picture.panels.push_back(
        panel_of(logs, "depth of the fingertip", "mm", [](const FingerLog& finger) { return finger.depth; }));
    OffscreenRenderer renderer(make_offscreen_context(), job);
    write_png(file, renderer.render(picture));
}

void write_palpation_view(const std::filesystem::path& file, const std::vector<PressLog>& logs,
    const std::vector<Press>& presses, const datasets::PalpationScene& scene, const haptics::TissueResponse& tissue,
    const std::string& note, const std::array<haptics::HandModel, 2>* hands, const Job& job)
{
    std::vector<Scene> views;
    for (std::size_t i = 0; i < logs.size(); ++i) {
        views.push_back(condensed_state_of(logs[i], presses[i], scene, tissue, note, true, hands));
        const auto is_skin = [](const datasets::TouchedOrgan& organ) { return organ.name == "skin"; };
        if (std::none_of(scene.organs.begin(), scene.organs.end(), is_skin))
            continue;
        views.push_back(condensed_state_of(logs[i], presses[i], scene, tissue, note, false, hands));
        views.back().title += ", beneath the skin";
    }
    const auto count = static_cast<double>(views.size());
    Picture picture { .width = static_cast<int>(800 * views.size()), .height = 800, .viewports = {} };
    for (std::size_t i = 0; i < views.size(); ++i)
        picture.viewports.push_back({ .left = static_cast<double>(i) / count,
            .bottom = 0.0,
            .right = static_cast<double>(i + 1) / count,
            .top = 1.0,
            .scene = views[i] });
    OffscreenRenderer renderer(make_offscreen_context(), job);
    write_png(file, renderer.render(picture));
}

} // namespace retractor::ui::cli
