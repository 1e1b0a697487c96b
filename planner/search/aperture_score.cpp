#include "planner/search/aperture_score.h"

#include "mesh/base/error.h"
#include "mesh/base/segment.h"
#include "mesh/image/skeleton.h"
#include "planner/approach/approach_templates.h"
#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/risk_distances.h"
#include "planner/measures/sight/surgeon_eye.h"
#include "planner/plan/wound_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr const char* kWall = "wall";
    constexpr int kEyes = 19; ///< directions of the cone; the search for the best eye refines them
    constexpr double kRiskSpacingMm = 3.0; ///< between the points of structures at risk
    constexpr double kDepthMarginMm = 5.0; ///< of the blade beyond the wall, as that of the templates

    /// Whether a bone gives way to what is done.
    bool gives_way(const mesh::LabelInfo& bone, ApertureKind kind)
    {
        if (kind == ApertureKind::skin)
            return false;
        if (is_rib(bone.name) || bone.material == "cartilage")
            return true;
        return kind == ApertureKind::sternum && (bone.name == "sternum" || bone.name == "bone_other");
    }

} // namespace

std::vector<std::string> organs_aside(
    const mesh::LabelTable& table, const TargetSpec& target, ApertureKind kind, const std::vector<std::string>& asked)
{
    std::vector<std::string> organs
        = retracted_organs(table, kind != ApertureKind::right_space, kind != ApertureKind::left_space, true);
    for (const std::string& name : asked) {
        const mesh::LabelInfo* info = mesh::find_label(table, name);
        if (info == nullptr || mesh::is_wall(*info))
            throw InputError("there is no organ \"" + name + "\" that can be held aside", "retracted", { "retracted" });
        if (std::ranges::find(organs, name) == organs.end())
            organs.push_back(name);
    }
    std::erase(organs, target.label);
    return organs;
}

ApertureScorer::ApertureScorer(
    Patient& patient, TargetSpec target, ViewSpec view, std::vector<std::string> aside, const Job& job)
    : patient_(patient)
    , target_(std::move(target))
    , view_(view)
    , aside_(std::move(aside))
    , job_(job)
    , target_surface_(patient.target(target_))
    , labels_(patient.labels())
{
    static_cast<void>(organs_aside(patient.planned_case().label_table, target_, ApertureKind::skin, aside_));
    view_.eye_count = std::min(view_.eye_count, kEyes);
    for (const mesh::LabelInfo& info : patient.planned_case().label_table) {
        if (info.role != mesh::Role::at_risk || !patient.has_voxels(info.name))
            continue;
        std::set<std::tuple<int, int, int>> cells;
        const std::shared_ptr<const TriMesh> surface = patient.organ(info.name);
        for (Eigen::Index v = 0; v < surface->vertices.rows(); ++v) {
            const Vec3 at = surface->vertices.row(v).transpose();
            const auto cell = [&](int axis) { return static_cast<int>(std::floor(at[axis] / kRiskSpacingMm)); };
            if (cells.insert({ cell(0), cell(1), cell(2) }).second)
                risk_points_.push_back({ .at = at, .label = risk_names_.size() });
        }
        risk_names_.push_back(info.name);
        risk_labels_.push_back(info.id);
    }
}

std::vector<SurfaceSample> ApertureScorer::samples(int count) const { return surface_samples(*target_surface_, count); }

const RayScene& ApertureScorer::scene_of(ApertureKind kind)
{
    const std::scoped_lock lock(mutex_);
    std::unique_ptr<RayScene>& scene = scenes_.at(static_cast<std::size_t>(kind));
    if (!scene) {
        const mesh::LabelTable& table = patient_.planned_case().label_table;
        Approach approach;
        approach.target = target_;
        approach.retracted = organs_aside(table, target_, kind, aside_);
        std::vector<Occluder> occluders = organ_occluders(approach, patient_, { .lung_share = 0.0 });
        occluders.push_back({ .name = kWall, .surface = {}, .labels = {}, .material = {}, .wall = true });
        for (const mesh::LabelInfo& info : table)
            if (mesh::is_wall(info) && mesh::is_skeleton(info) && !gives_way(info, kind)
                && patient_.has_voxels(info.name))
                occluders.push_back({ .name = info.name,
                    .surface = *patient_.organ(info.name),
                    .labels = {},
                    .material = info.material,
                    .wall = true });
        scene = std::make_unique<RayScene>(*target_surface_, std::move(occluders), job_);
    }
    return *scene;
}

namespace {

    /// Sections at most this far apart, between those of the line.
    std::vector<ApertureSection> with_sections_between(const std::vector<ApertureSection>& sections, double spacing_mm)
    {
        std::vector<ApertureSection> dense { sections.front() };
        for (std::size_t n = 0; n + 1 < sections.size(); ++n) {
            const ApertureSection &a = sections[n], &b = sections[n + 1];
            const double longer = std::max((b.skin - a.skin).norm(), (b.inner - a.inner).norm());
            const int steps = std::max(1, static_cast<int>(std::ceil(longer / spacing_mm)));
            for (int i = 1; i <= steps; ++i) {
                const double t = static_cast<double>(i) / steps;
                dense.push_back(
                    { .skin = (1.0 - t) * a.skin + t * b.skin, .inner = (1.0 - t) * a.inner + t * b.inner });
            }
        }
        return dense;
    }

} // namespace

std::set<Label> ApertureScorer::labels_on_blade(const std::vector<ApertureSection>& sections) const
{
    const double step = 0.5 * labels_->grid.spacing.minCoeff();
    std::set<Label> met;
    for (const ApertureSection& section : sections) {
        const Vec3 inward = (section.inner - section.skin).normalized();
        const double depth = (section.inner - section.skin).norm() + kDepthMarginMm;
        for (double at = 0.0; at <= depth; at += step)
            met.insert(mesh::label_at(*labels_, section.skin + at * inward));
    }
    return met;
}

std::vector<RiskDistance> ApertureScorer::risks_beside(const std::vector<ApertureSection>& sections) const
{
    constexpr double kSpacingMm = 2.5; // a vessel of this width is met
    const std::vector<ApertureSection> dense = with_sections_between(sections, kSpacingMm);
    std::vector<RiskDistance> nearest;
    for (const std::string& name : risk_names_)
        nearest.push_back({ .name = name, .distance_mm = kFarthestRiskMm });
    for (const ApertureSection& section : dense) {
        const Vec3 inward = (section.inner - section.skin).normalized();
        const Vec3 tip = section.inner + kDepthMarginMm * inward;
        for (const RiskPoint& point : risk_points_)
            if (const double distance = distance_to_segment(point.at, section.skin, tip);
                distance < nearest[point.label].distance_mm) {
                nearest[point.label].distance_mm = distance;
                nearest[point.label].at = point.at;
            }
    }
    const std::set<Label> met = labels_on_blade(dense);
    for (std::size_t n = 0; n < nearest.size(); ++n)
        if (met.contains(risk_labels_[n]))
            nearest[n].distance_mm = 0.0;
    std::erase_if(nearest, [](const RiskDistance& risk) { return risk.distance_mm >= kFarthestRiskMm; });
    return nearest_risks(std::move(nearest));
}

std::shared_ptr<const TriMesh> ApertureScorer::surface_of(std::string_view organ) const
{
    return patient_.has_voxels(organ) ? patient_.organ(organ) : std::make_shared<const TriMesh>();
}

namespace {

    /// Where a saw enters the skin and where its foot runs.
    struct SawWay {
        std::vector<Vec3> skin, inner;
    };
    SawWay saw_through(const std::vector<ApertureSection>& sections)
    {
        SawWay way;
        for (const ApertureSection& section : sections) {
            way.skin.push_back(section.skin);
            way.inner.push_back(section.inner);
        }
        return way;
    }

    mesh::Blade blade_through(const std::vector<ApertureSection>& sections)
    {
        mesh::Blade blade;
        blade.depth_mm = 0.0;
        for (const ApertureSection& section : sections) {
            blade.line.push_back(section.skin);
            blade.directions.push_back((section.inner - section.skin).normalized());
            blade.depth_mm = std::max(blade.depth_mm, (section.inner - section.skin).norm() + kDepthMarginMm);
        }
        return blade;
    }

} // namespace

std::vector<RiskDistance> ApertureScorer::risks_of_saw(const std::vector<ApertureSection>& sections) const
{
    const SawWay way = saw_through(sections);
    return saw_risk_distances(
        way.skin, way.inner, *labels_, [this](std::string_view organ) { return surface_of(organ); });
}

std::vector<RiskDistance> ApertureScorer::exact_risks(const std::vector<ApertureSection>& sections) const
{
    return risk_distances(
        blade_through(sections), *labels_, [this](std::string_view organ) { return surface_of(organ); });
}

std::vector<RiskDistance> ApertureScorer::assumed_risks(
    const std::vector<ApertureSection>& sections, ApertureKind kind) const
{
    const SawWay way = saw_through(sections);
    const TriMesh surface = kind == ApertureKind::sternum ? saw_surface(way.skin, way.inner)
                                                          : mesh::SweptBlade(blade_through(sections)).surface();
    std::vector<RiskDistance> risks = assumed_distances(surface, patient_.planned_case().assumed_vessels);
    keep_nearest_bundle(risks);
    return risks;
}

Candidate ApertureScorer::score(const std::vector<ApertureSection>& sections, const ApertureWidth& width,
    ApertureKind kind, const std::vector<SurfaceSample>& samples)
{
    const Aperture aperture(sections, width);
    const OpeningGeometry opening = aperture.opening();
    const RayScene scene(scene_of(kind), aperture, kWall);
    const EyePlaces places = eye_places_through(opening, aim_through(scene, opening, samples), view_);
    SurgeonEye best = best_eye(scene, places, samples);
    add_two_eyes_and_instruments(best, scene, opening, samples);
    Candidate candidate;
    FieldMetrics& field = candidate.field;
    field.target = target_name(target_);
    field.target_spec = target_;
    field.seen_best_eye = best.seen_fraction;
    field.reached_by_two_instruments = best.two_instruments_fraction;
    const double cosine = (best.eye - best.aim).normalized().dot(opening.normal);
    field.best_eye.bound_area_mm2 = best.bound_area_mm2;
    field.coaxiality_deg = 180.0 / std::numbers::pi * std::acos(std::clamp(cosine, -1.0, 1.0));
    field.incision_length_mm = opening.incision_length_mm;
    field.opening_width_mm = width.skin_mm;
    field.at_risk = kind == ApertureKind::sternum ? risks_of_saw(sections) : risks_beside(sections);
    if (kind == ApertureKind::sternum)
        candidate.divided_bones = { "sternum" };
    return candidate;
}

} // namespace retractor::planner
